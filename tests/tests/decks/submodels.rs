//! Files that are included with offsets of ids, in other units and in another position: the model
//! is that of a deck with the changed numbers.

use super::base::{BASE, MOVES, STEEL};
use crumple::input::job::{Model, read};
use std::fs;

/// Reads a deck that may include `part.k`; the report of its errors otherwise.
fn reading(main: &str, part: &str) -> Result<Model, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(folder.path().join("part.k"), format!("*KEYWORD\n{part}*END\n")).unwrap();
    fs::write(&path, format!("{BASE}{STEEL}{MOVES}{main}*END\n")).unwrap();
    read(&path, &[]).map_err(|report| report.to_string())
}

fn model(main: &str, part: &str) -> Model {
    reading(main, part).unwrap_or_else(|report| panic!("{report}"))
}

/// A rotation by 90 degrees about z, then a translation.
fn moved([x, y, z]: [f64; 3]) -> [f64; 3] {
    [100.0 - y, x, z + 7.0]
}

fn turned([x, y, z]: [f64; 3]) -> [f64; 3] {
    [-y, x, z]
}

/// Offsets of nodes, elements, parts, materials, sets, curves, definitions and others.
type Offsets = [u64; 8];

const MOVE: &str = "*DEFINE_TRANSFORMATION\n7\nROTATE,0,0,1,0,0,0,90\nTRANSL,100,0,7\n";

/// A solid with a shell, their materials, sets, loads, a wall and a contact, with offsets of its
/// ids, its points at `place` and its vectors turned by `turn`.
fn piece(
    [n, e, p, m, s, f, d, r]: Offsets,
    place: fn([f64; 3]) -> [f64; 3],
    turn: fn([f64; 3]) -> [f64; 3],
) -> String {
    let text = |v: [f64; 3]| format!("{:?},{:?},{:?}", v[0], v[1], v[2]);
    let at = |x: [f64; 3]| text(place(x));
    let way = |v: [f64; 3]| text(turn(v));
    let mut deck = String::from("*NODE\n");
    for k in 0..8u64 {
        let bit = |b: u64| 10.0 * ((k >> b) & 1) as f64;
        deck += &format!("{},{}\n", n + 1 + k, at([bit(0), bit(1), 30.0 + bit(2)]));
    }
    let corner = |k: u64| n + 1 + k;
    deck += &format!(
        "*ELEMENT_SOLID\n{},{},{},{},{},{},{},{},{},{}\n",
        e + 1,
        p + 1,
        corner(0),
        corner(1),
        corner(3),
        corner(2),
        corner(4),
        corner(5),
        corner(7),
        corner(6)
    );
    deck += &format!(
        "*ELEMENT_SHELL\n{},{},{},{},{},{}\n",
        e + 2,
        p + 2,
        corner(4),
        corner(5),
        corner(7),
        corner(6)
    );
    deck += &format!("*PART\n\n{},{},{}\n\n{},{},{}\n", p + 1, r + 1, m + 1, p + 2, r + 2, m + 1);
    deck += &format!("*SECTION_SOLID\n{},1\n*SECTION_SHELL\n{},2\n1.0\n", r + 1, r + 2);
    deck += &format!(
        "*MAT_PIECEWISE_LINEAR_PLASTICITY\n{},7.85e-6,207.0,0.3\n0,0,{}\n\n\n",
        m + 1,
        f + 1
    );
    deck += &format!("*DEFINE_CURVE\n{}\n0.0,0.3\n0.1,0.4\n", f + 1);
    deck += &format!("*DEFINE_CURVE\n{}\n0.0,0.0\n20.0,1.0\n", f + 2);
    deck += &format!("*SET_NODE_LIST\n{}\n{},{},{}\n", s + 1, corner(0), corner(1), corner(2));
    deck += &format!("*SET_NODE_GENERAL\n{}\nPART,{}\nSET_NODE,{}\n", s + 2, p + 2, s + 1);
    deck += &format!(
        "*SET_SEGMENT\n{}\n{},{},{},{}\n*LOAD_SEGMENT_SET\n{},{},0.001\n",
        s + 3,
        corner(4),
        corner(5),
        corner(7),
        corner(6),
        s + 3,
        f + 2
    );
    deck += &format!(
        "*INITIAL_VELOCITY_GENERATION\n{},2,0.01,{}\n{},{}\n",
        p + 1,
        way([1.0, 2.0, 3.0]),
        at([5.0, 6.0, 7.0]),
        way([0.0, 1.0, 0.0])
    );
    deck += &format!(
        "*DEFINE_COORDINATE_SYSTEM\n{},{},{}\n{}\n*INITIAL_VELOCITY_NODE\n{},1,0,0,0,0,0,{}\n",
        d + 1,
        at([0.0; 3]),
        at([0.0, 2.0, 0.0]),
        at([0.0, 0.0, 5.0]),
        corner(7),
        d + 1
    );
    deck += &format!(
        "*RIGIDWALL_GEOMETRIC_FLAT\n{}\n{},{}\n{},20,20\n",
        s + 1,
        at([0.0, 0.0, -40.0]),
        at([0.0, 0.0, -39.0]),
        at([1.0, 0.0, -40.0])
    );
    deck += &format!("*CONTACT_AUTOMATIC_NODES_TO_SURFACE\n{},{},4,3\n\n\n", s + 2, p + 1);
    deck + &format!("*DATABASE_HISTORY_NODE\n{}\n", corner(5))
}

const SHIFT: Offsets = [100, 200, 300, 400, 500, 600, 700, 800];
const INCLUDE: &str = "*INCLUDE_TRANSFORM\npart.k\n100,200,300,400,500,600,700\n800\n";

/// An included file with all kinds of ids, points and vectors gives the job and the mesh of the
/// deck with the numbers written out, bit for bit.
#[test]
fn a_moved_file_is_the_deck_written_out() {
    let part = piece([0; 8], |x| x, |v| v);
    let included = model(&format!("{MOVE}{INCLUDE}1,1,1\n7\n"), &part);
    let written = model(&piece(SHIFT, moved, turned), "");
    assert_eq!(included.mesh, written.mesh);
    assert_eq!(format!("{:?}", included.job), format!("{:?}", written.job));
    assert_eq!(included.mesh.nodes.iter().filter(|n| n.id.label() > 100).count(), 8);
    let plain = model(&format!("{INCLUDE}1,1,1\n"), &part);
    let written = model(&piece(SHIFT, |x| x, |v| v), "");
    assert_eq!(plain.mesh, written.mesh);
    assert_eq!(format!("{:?}", plain.job), format!("{:?}", written.job));
}

/// A file that includes another one changes it too: offsets add up, and the inner map comes first.
#[test]
fn changes_of_files_add_up() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("part.k", &format!("*KEYWORD\n{}*END\n", piece([0; 8], |x| x, |v| v)));
    write(
        "outer.k",
        "*KEYWORD\n*DEFINE_TRANSFORMATION\n1\nROTATE,0,0,1,0,0,0,90\n\
         *INCLUDE_TRANSFORM\npart.k\n40,100,200,300,400,500,600\n700\n\n1\n*END\n",
    );
    let main = "*DEFINE_TRANSFORMATION\n7\nTRANSL,100,0,7\n\
                *INCLUDE_TRANSFORM\nouter.k\n60,100,100,100,100,100,100\n100\n\n7\n";
    write("deck.k", &format!("{BASE}{STEEL}{MOVES}{main}*END\n"));
    let both = read(&folder.path().join("deck.k"), &[]).unwrap_or_else(|report| panic!("{report}"));
    let written = model(&piece(SHIFT, moved, turned), "");
    assert_eq!(both.mesh, written.mesh);
    assert_eq!(format!("{:?}", both.job), format!("{:?}", written.job));
}

/// The same file twice, with other ids: both copies are there, and equal titles do not collide.
#[test]
fn a_file_is_included_twice() {
    let part = piece([0; 8], |x| x, |v| v)
        + "*SET_NODE_LIST_TITLE\nbottom\n9\n1,2\n*PART\nlid\n3,2,1\n*NODE\n11,0,0,50\n\
           12,10,0,50\n13,10,10,50\n14,0,10,50\n*ELEMENT_SHELL\n3,3,11,12,13,14\n";
    let again = INCLUDE.replace("100,200,300", "200,300,310").replace("500,600", "530,630");
    let again = again.replace("400,", "410,").replace("700\n", "730\n").replace("800", "830");
    let shift = "*DEFINE_TRANSFORMATION\n8\nTRANSL,0,0,100\n";
    let both = model(&format!("{MOVE}{shift}{INCLUDE}1,1,1\n7\n{again}1,1,1\n8\n"), &part);
    assert_eq!(both.mesh.elements.len(), 3 + 2 * 3);
    let set = |name: &str| both.mesh.node_sets.get(name).map(Vec::len);
    assert_eq!([set("bottom"), set("bottom 2"), set("set-509"), set("set-539")], [Some(2); 4]);
    let names: Vec<&str> = both.job.part.iter().map(|p| p.name.as_str()).collect();
    assert!(names.contains(&"lid") && names.contains(&"lid (313)"), "{names:?}");
    let prefixed = INCLUDE.replace("800\n", "800,0,left,x\n");
    let prefixed = model(&format!("{prefixed}1,1,1\n"), &part);
    assert!(prefixed.job.part.iter().any(|p| p.name == "left.lid.x"));
}

/// A file in mm, s, tonne in a deck in mm, ms, kg: densities, moduli, curves by their use,
/// velocities, pressures and times.
#[test]
fn units_of_a_file_are_converted() {
    let part = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n\
        *ELEMENT_SOLID\n1,1,1,2,3,4,5,6,7,8\n*PART\n\n1,1,1\n*SECTION_SOLID\n1,1\n\
        *MAT_PIECEWISE_LINEAR_PLASTICITY\n1,7.85e-9,2.07e5,0.3\n40.0,5.0,1\n\n\n\
        *DEFINE_CURVE\n1\n0.0,300.0\n0.1,400.0\n*DEFINE_CURVE\n2\n0.0,0.0\n0.02,5.0\n\
        *INITIAL_VELOCITY_NODE\n1,2000.0\n*LOAD_SEGMENT\n2,1,0,5,6,7,8\n\
        *BOUNDARY_PRESCRIBED_MOTION_NODE\n2,1,0,3,1,0,0.009,0.004\n\
        *DEFINE_CURVE\n3\n0.0,0.0\n0.01,50.0\n";
    // Lengths are in cm in this file.
    let main = "*INCLUDE_TRANSFORM\npart.k\n100,100,100,100,100,100,100\n100\n1000,1000,10\n";
    let found = model(main, part);
    let near = |x: f64, y: f64| assert!((x - y).abs() < 1e-12 * y.abs(), "{x} is not {y}");
    let node = found.mesh.nodes.iter().find(|n| n.id.label() == 107).unwrap();
    assert_eq!(node.x, [10.0, 10.0, 10.0]);
    let material = found.job.material.iter().find(|m| m.name == "mat-101").unwrap();
    near(material.density, 7.85e-9);
    let text = format!("{material:?}");
    let curve = |name: &str| found.job.curve.iter().find(|c| c.name == name).unwrap();
    // tonne/(cm s^2) is 1000 kg/(10 mm 1e6 ms^2): a factor of 1e-4.
    near(curve("curve-102").points[1][0], 20.0);
    near(curve("curve-102").points[1][1], 5e-4);
    // cm/s is 0.01 mm/ms.
    near(curve("curve-103-from-4").points[1][1], 0.5);
    near(found.job.motion[0].birth, 4.0);
    near(found.job.motion[0].death.unwrap(), 9.0);
    let fastest = found.job.initial_velocity.iter().map(|v| v.velocity[0]).fold(0.0, f64::max);
    near(fastest, 20.0);
    assert!(text.contains("0.03") && text.contains("20.7"), "yield stress and modulus: {text}");
    // Numbers of keywords without known dimensions are refused.
    let table = "*DEFINE_TABLE\n9\n0.0\n1.0\n";
    let report = reading(main, &format!("{part}{table}")).err().unwrap();
    assert!(report.contains("*DEFINE_TABLE is in a file with factors of units"), "{report}");
    let unknown = "*DEFINE_CURVE\n8\n0.0,1.0\n";
    let report = reading(main, &format!("{part}{unknown}")).err().unwrap();
    assert!(
        report.contains("*DEFINE_CURVE 108") && report.contains("use are not known"),
        "{report}"
    );
}

/// In a mirror, elements keep their volume and pressure its side: corners change their order.
#[test]
fn a_reflected_file_is_not_inside_out() {
    let mirror = "*DEFINE_TRANSFORMATION\n7\nMIRROR,0,0,0,1,0,0\n";
    // A reflected rectangle is refused.
    let whole = piece([0; 8], |x| x, |v| v);
    let (wall, rest) = (whole.find("*RIGIDWALL").unwrap(), whole.find("*CONTACT").unwrap());
    let part = [&whole[..wall], &whole[rest..]].concat();
    let refused = reading(&format!("{mirror}{INCLUDE}1,1,1\n7\n"), &whole).err().unwrap();
    assert!(refused.contains("a rectangle in a file that"), "{refused}");
    let found = model(&format!("{mirror}{INCLUDE}1,1,1\n7\n"), &part);
    let plain = model(&format!("{INCLUDE}1,1,1\n"), &part);
    let of = |m: &Model| m.settings.loads.pressures.iter().map(|p| p.pressure).collect::<Vec<_>>();
    assert_eq!(of(&found), of(&plain));
    let masses = |m: &Model| m.elements.mass.clone();
    assert_eq!(masses(&found), masses(&plain), "the volumes are above 0");
    let top = |m: &Model| {
        let shell = m.mesh.elements.iter().find(|e| e.part == 302).unwrap();
        let at = |k: usize| m.mesh.nodes.iter().find(|n| n.id == shell.nodes[k]).unwrap().x;
        let [a, b, d] = [at(0), at(1), at(3)];
        let (u, v) = ([b[0] - a[0], b[1] - a[1]], [d[0] - a[0], d[1] - a[1]]);
        u[0] * v[1] - u[1] * v[0]
    };
    assert!(top(&found) > 0.0 && top(&plain) > 0.0, "normals are upwards in both");
}

/// Vectors turn with their file, once also if they are along the axes of a system of the file; the
/// amount of a rotation has no length.
#[test]
fn motions_along_vectors_turn_with_their_file() {
    let main = "*DEFINE_TRANSFORMATION\n7\nROTATE,0,0,1,0,0,0,90\n\
                *INCLUDE_TRANSFORM\npart.k\n0,0,0,0,0,0,0\n0\n1,1,1000\n7\n";
    for (system, cid) in [("", 0), ("*DEFINE_COORDINATE_VECTOR\n4,1,0,0,0,1,0\n", 4)] {
        let part = format!(
            "*SET_NODE_LIST\n5\n1,2\n{system}*DEFINE_VECTOR\n6,0,0,0,2.0,0,0,{cid}\n\
             *DEFINE_CURVE\n11\n0,3.0\n20,3.0\n*DEFINE_CURVE\n12\n0,3.0\n20,3.0\n\
             *BOUNDARY_PRESCRIBED_MOTION_SET\n5,8,0,11,1.0,6\n5,4,0,12,1.0,6\n"
        );
        let found = model(main, &part);
        let [turns, moves] = &found.job.motion[..] else { panic!("two motions") };
        assert_eq!((&turns.dofs[..], turns.spin), (&["ry".to_string()][..], Some([0.0, 1.0, 0.0])));
        let along = (&moves.dofs[..], moves.velocity);
        assert_eq!(along, (&["y".to_string()][..], Some([0.0, 1.0, 0.0])));
        let most = |name: &Option<String>| {
            let curve = found.job.curve.iter().find(|c| Some(&c.name) == name.as_ref()).unwrap();
            curve.points[1][1]
        };
        assert_eq!([most(&turns.curve), most(&moves.curve)], [3.0, 3000.0], "cid {cid}");
        assert!(!found.warnings.iter().any(|w| w.message.contains("turns, but its degrees")));
    }
}

/// A node set is moved by itself; other nodes stay.
#[test]
fn a_node_set_is_moved() {
    let lines = "*SET_NODE_LIST\n5\n5,6,7,8\n*DEFINE_TRANSFORMATION\n3\nTRANSL,0,0,-1\n\
                 TRANSL,0,0,-0.5\n*NODE_TRANSFORM\n3,5\n";
    let found = model(lines, "");
    let z = |label: u64| found.mesh.nodes.iter().find(|n| n.id.label() == label).unwrap().x[2];
    assert_eq!([z(5), z(8), z(1), z(11)], [8.5, 8.5, 0.0, 12.0]);
}

/// Content that cannot be moved, or that is ambiguous, is refused with a cure, at its line.
#[test]
fn what_cannot_be_changed_is_refused() {
    let part = "*DEFINE_BOX\n1,0,1,0,1,0,1\n";
    let turn = "*DEFINE_TRANSFORMATION\n7\nROTATE,0,0,1,0,0,0,30\n";
    let include = "*INCLUDE_TRANSFORM\npart.k\n100\n\n\n";
    for (main, part, word) in [
        (format!("{turn}{include}7\n"), part, "right angles"),
        (format!("{include}9\n"), "", "no *DEFINE_TRANSFORMATION 9 above this line"),
        (
            "*DEFINE_TRANSFORMATION\n7\nPOINT,1,0,0,0\nPOINT,2,0,0,1\nTRANSL,1,0,0\nROTATE,1,2,90\n"
                .into(),
            "",
            "POINT 1 precedes another transformation",
        ),
        ("*DEFINE_TRANSFORMATION\n7\nROTATE,0,0,0,1,1,1,90\n".into(), "", "no direction"),
        ("*DEFINE_TRANSFORMATION\n7\nSHEAR,1\n".into(), "", "option SHEAR is not supported"),
        ("*INCLUDE_TRANSFORM\n".into(), "", "has no file"),
    ] {
        let report = reading(&main, part).err().unwrap_or_else(|| panic!("it passes: {main}"));
        assert!(report.contains(word), "{word}: {report}");
    }
    // Degrees of freedom stay along the axes of the deck, with a warning.
    let held = "*SET_NODE_LIST\n1\n1\n*NODE\n1,50,0,0\n*BOUNDARY_SPC_SET\n1,0,1\n";
    let held = format!(
        "{held}*NODE\n2,60,0,0\n3,60,9,0\n*ELEMENT_SHELL\n1,1,1,2,3\n*PART\n\n1,1,1\n\
        *SECTION_SHELL\n1,2\n1.0\n*MAT_ELASTIC\n1,7.85e-6,207.0,0.3\n"
    );
    let main = format!("{turn}*INCLUDE_TRANSFORM\npart.k\n100,100,100,100,100,100\n100\n\n7\n");
    let found = model(&main, &held);
    let said = found.warnings.iter().any(|w| w.message.contains("axes of the whole deck"));
    assert!(said, "{:?}", found.warnings);
}

/// A plane of symmetry moves with its file, in the units of the deck. Its normal stays along the
/// axis of the deck, with a warning if the file turns.
#[test]
fn planes_of_symmetry_move_with_their_file() {
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} is not {b}");
    let shift = "*DEFINE_TRANSFORMATION\n7\nTRANSL,100,0,7\n";
    let include = |lengths: u32| format!("*INCLUDE_TRANSFORM\npart.k\n0\n0\n1,1,{lengths}\n7\n");
    let turned_axes =
        |m: &Model| m.warnings.iter().any(|w| w.message.contains("axes of the whole deck"));
    for (main, part, point, tolerance, turns) in [
        // The file in the units of the deck, and in cm.
        (shift.to_string() + &include(1), "-80,1,2,0.3", [20.0, 1.0, 9.0], 0.3, false),
        (shift.to_string() + &include(10), "-8,0.1,0.2,0.03", [20.0, 1.0, 9.0], 0.3, false),
        (MOVE.to_string() + &include(1), "1,80,2,0.3", [20.0, 1.0, 9.0], 0.3, true),
    ] {
        let found = model(&main, &format!("*CONSTRAINED_GLOBAL\n1,5,1,{part}\n"));
        let [plane] = found.job.symmetry.as_slice() else { panic!("one plane: {main}") };
        assert_eq!(plane.normal, [1.0, 0.0, 0.0]);
        (0..3).for_each(|c| near(plane.point[c], point[c]));
        near(plane.tolerance, tolerance);
        assert_eq!(turned_axes(&found), turns, "{:?}", found.warnings);
    }
}

/// The fixed axes of a body of nodes are those of the deck. If the file turns, a warning says so.
#[test]
fn fixed_axes_of_a_body_of_nodes_do_not_turn() {
    let main = format!("{MOVE}*INCLUDE_TRANSFORM\npart.k\n0\n0\n1,1,1\n7\n");
    for (cmo, is_fixed) in [(1, true), (0, false)] {
        let part = format!(
            "*SET_NODE_LIST\n7\n11,12,14\n*CONSTRAINED_NODAL_RIGID_BODY_SPC\n50,0,7\n{cmo},1,7\n"
        );
        let found = model(&main, &part);
        let said = found.warnings.iter().any(|w| {
            w.message.contains("CONSTRAINED_NODAL_RIGID_BODY")
                && w.message.contains("axes of the whole deck")
        });
        assert_eq!(said, is_fixed, "{:?}", found.warnings);
    }
}
