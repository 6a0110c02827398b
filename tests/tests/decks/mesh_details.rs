//! Mesh files of other programs: several instances, rigid bodies, materials, fields of elements,
//! pieces and numbers of VTK, names, copies of files. What is not read is in the table or an error.

use crumple::input::mesh_file::{Fate, ReadMesh, read};
use crumple_proto::mesh::Shape;
use crumple_proto::problem::{Problem, Severity};
use crumple_tests::program::{crumple_with, root, run};
use std::fs;
use std::path::PathBuf;

pub fn text_of(file: &str) -> String {
    fs::read_to_string(root().join("tests/meshes").join(file)).unwrap()
}

/// Reads a file with this content.
fn read_text(name: &str, text: &[u8], allowed: bool) -> Result<ReadMesh, Vec<Problem>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    read(&path, allowed, None)
}

pub fn good(name: &str, text: &str) -> ReadMesh {
    let found = read_text(name, text.as_bytes(), false);
    found.unwrap_or_else(|problems| panic!("{problems:?}\n{text}"))
}

/// Returns the messages of the errors of a file that is refused. Each error has a cure.
fn errors(name: &str, text: &str) -> Vec<String> {
    let Err(problems) = read_text(name, text.as_bytes(), false) else {
        panic!("it is read:\n{text}");
    };
    let errors = problems.into_iter().filter(|p| p.severity == Severity::Error);
    let cured = |p: Problem| {
        assert!(!p.help.is_empty(), "{}", p.message);
        p.message
    };
    errors.map(cured).collect()
}

/// Asserts that the first error has these words.
pub fn refused(name: &str, text: &str, wanted: &str) {
    let found = errors(name, text);
    assert!(found[0].contains(wanted), "`{wanted}` is not in {found:?}\n{text}");
}

/// Returns a text with one change that has to be possible.
pub fn changed(text: &str, old: &str, new: &str) -> String {
    assert!(text.contains(old), "{old} is not in {text}");
    text.replacen(old, new, 1)
}

/// Returns fate and count of a row of the table.
pub fn row(read: &ReadMesh, what: &str) -> Option<(Fate, usize)> {
    read.rows.iter().find(|row| row.what == what).map(|row| (row.fate, row.count))
}

fn set_names(read: &ReadMesh) -> Vec<&str> {
    read.mesh.node_sets.keys().map(String::as_str).collect()
}

/// Files of the tutorials have the numbers of nodes, elements and parts that the tutorials show,
/// and a file of hexahedra those that it states.
#[test]
fn files_of_the_tutorials_are_read() {
    for (file, nodes, elements, parts, sets) in [
        ("cases/examples/abaqus-beam/box-beam.inp", 544, 512, 1, &["Foot", "Head", "Wall"][..]),
        (
            "cases/examples/gmsh-sphere/plate-and-sphere.msh",
            1192,
            1358,
            2,
            &["plate", "rim", "sphere"],
        ),
        ("tests/meshes/third-party/meshio/06_unstructured.vtk", 42, 12, 1, &["part_1"]),
    ] {
        let path = root().join(file);
        let found =
            read(&path, false, None).unwrap_or_else(|problems| panic!("{file}: {problems:?}"));
        let mesh = &found.mesh;
        let counts = (mesh.nodes.len(), mesh.elements.len(), mesh.parts.len());
        assert_eq!(counts, (nodes, elements, parts), "{file}");
        assert_eq!(set_names(&found), sets, "{file}");
    }
    let found = good("a.vtk", &text_of("third-party/meshio/06_unstructured.vtk"));
    assert_eq!(row(&found, "array mat_id"), Some((Fate::Ignored, 1)));
}

/// Two instances of a part: the second one is moved by 2 along z and turned by 90 degrees about z.
/// Sets, surfaces and rigid bodies of the assembly have the nodes and elements of their instances.
#[test]
fn an_assembly_has_the_nodes_of_its_instances() {
    let found = good("a.inp", &text_of("made/assembly.inp"));
    let mesh = &found.mesh;
    let ids: Vec<u64> = mesh.nodes.iter().map(|node| node.id).collect();
    assert_eq!(ids, [1, 2, 3, 4, 5, 6, 7, 8]);
    let wanted = [[0.0, 0.0, 2.0], [0.0, 1.0, 2.0], [-1.0, 1.0, 2.0], [-1.0, 0.0, 2.0]];
    for (node, wanted) in mesh.nodes[4..].iter().zip(wanted) {
        let apart = (0..3).map(|c| (node.x[c] - wanted[c]).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-12, "{node:?}, not {wanted:?}");
    }
    let sets: [(&str, &[u64]); 10] = [
        ("P-1.edge", &[1, 2]),
        ("P-1.skin", &[1, 2, 3, 4]),
        ("P-2.edge", &[5, 6]),
        ("P-2.skin", &[5, 6, 7, 8]),
        ("S", &[5, 6, 7, 8]),
        ("corner", &[5, 7]),
        ("edges", &[1, 2, 5, 6]),
        ("hard", &[5, 6, 7, 8]),
        ("skin", &[1, 2, 3, 4]),
        ("skin-2", &[5, 6, 7, 8]),
    ];
    assert_eq!(set_names(&found), sets.map(|set| set.0));
    for (name, ids) in sets {
        assert_eq!(mesh.node_sets[name], ids, "{name}");
    }
    // The rigid plate is a part of its own.
    let rigid: Vec<bool> = mesh.parts.iter().map(|part| part.rigid).collect();
    assert_eq!(rigid, [false, true]);
    let elements: Vec<_> = mesh.elements.iter().map(|e| (e.id, e.part)).collect();
    assert_eq!(elements, [(1, 0), (5, 1)]);
    assert_eq!(row(&found, "ids of P-2"), Some((Fate::Read, 4)));
    assert_eq!(row(&found, "*RIGID BODY"), Some((Fate::Read, 1)));
    assert_eq!(row(&found, "nodes in no element"), Some((Fate::Ignored, 1)));
}

/// An instance places its own nodes as those of its part. Sets that it has without nodes of its own
/// are named, not lost.
#[test]
fn an_instance_places_the_nodes_that_it_has_itself() {
    let text = "*PART, NAME=P\n*END PART\n*ASSEMBLY, NAME=A\n\
                *INSTANCE, NAME=I, PART=P\n5., 0., 1.\n\
                *NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n\
                *ELEMENT, TYPE=S4, ELSET=E\n1, 1, 2, 3, 4\n*END INSTANCE\n*END ASSEMBLY\n";
    let found = good("own.inp", text);
    let places: Vec<[f64; 3]> = found.mesh.nodes.iter().map(|node| node.x).collect();
    assert_eq!(places, [[5.0, 0.0, 1.0], [6.0, 0.0, 1.0], [6.0, 1.0, 1.0], [5.0, 1.0, 1.0]]);

    let old = "*End Instance\n";
    let text = changed(&text_of("made/assembly.inp"), old, "*Nset, nset=own\n1\n*End Instance\n");
    let found = good("sets.inp", &text);
    assert_eq!(row(&found, "sets of instance P-1"), Some((Fate::LeftOut, 1)));
}

/// Wrong names in an assembly are errors at their lines, and no set gets nodes of another instance.
#[test]
fn wrong_names_in_an_assembly_are_errors() {
    let text = text_of("made/assembly.inp");
    for (old, new, wanted) in [
        (
            "*Nset, nset=corner, instance=P-2",
            "*Nset, nset=corner, instance=P-9",
            ":27: *NSET: there is no instance `P-9`",
        ),
        (
            "*Elset, elset=hard, instance=P-2",
            "*Elset, elset=hard",
            ":35: *ELSET has ids, and it is open of which instance",
        ),
        ("P-1.edge, P-2.edge", "P-1.edge, P-2.rim", ":30: `P-2.rim` is no id and no set"),
        ("_S_SPOS, SPOS", "_S_SNEG, SNEG", ":34: surface: there is no set `_S_SNEG`"),
        ("_S_SPOS, SPOS", "_S_SPOS, S6", ":34: element 1 has no face S6"),
        ("node=RP, elset=hard", "node=RP, elset=soft", ":37: there is no element set `soft`"),
    ] {
        refused("a.inp", &changed(&text, old, new), wanted);
    }
    let plate = text_of("broken/plate.inp");
    let text = changed(&plate, "*End Part", "*Rigid Body, elset=hull\n*End Part");
    refused("a.inp", &text, "*RIGID BODY: there is no element set `hull`");
}

/// Springs, connectors and masses of the assembly have nodes of instances. They are rows of the
/// table with their number; their sets have these nodes. A truss between instances is an element.
#[test]
fn elements_of_an_assembly_join_nodes_of_instances() {
    let text = text_of("made/joined.inp");
    let found = good("a.inp", &text);
    let mesh = &found.mesh;
    assert_eq!((mesh.nodes.len(), mesh.elements.len(), mesh.parts.len()), (8, 2, 1));
    for (name, ids) in
        [("Springs", &[1, 2, 5, 6][..]), ("Wire", &[3, 7, 8]), ("heavy", &[7]), ("tips", &[4, 8])]
    {
        assert_eq!(mesh.node_sets[name], ids, "{name}");
    }
    for (what, count) in [("spring", 2), ("connector", 3), ("point mass", 1), ("*SPRING", 1)] {
        assert_eq!(row(&found, what), Some((Fate::Ignored, count)), "{what}");
    }
    let rod = "*Element, type=T3D2, elset=rod\n9, A-1.1, B-1.1\n*Solid Section, elset=rod, \
               material=Steel\n2.,\n*Element, type=MASS";
    let mesh = good("a.inp", &changed(&text, "*Element, type=MASS", rod)).mesh;
    let rod = mesh.elements.iter().find(|e| e.shape == Shape::Beam2).unwrap();
    assert_eq!(rod.corners, [1, 5]);
    assert_eq!(mesh.parts[rod.part].beam.as_ref().unwrap().area, 2.0);
}

/// A node that is missing is one error, at its line and with the number of the file, whatever
/// names it.
#[test]
fn a_missing_node_is_one_error_with_the_number_of_the_file() {
    let text = text_of("made/joined.inp");
    for (old, new, wanted) in [
        ("1, A-1.1, B-1.1", "1, A-1.9, B-1.1", ":23: element 1 has node A-1.9, which is missing"),
        ("1, A-1.1, B-1.1", "1, C-1.1, B-1.1", ":23: element 1: there is no instance `C-1`"),
        ("1, A-1.1, B-1.1", "1, 70, B-1.1", ":23: element 1 has node 70, which is missing"),
        ("1, A-1.1, B-1.1", "1, 7.1, B-1.1", ":23: `1, 7.1, B-1.1` is no element"),
        ("A-1.4, B-1.4\n", "A-1.4, B-1.9\n", ":40: set `tips` has node 9, which is missing"),
        ("1, 1, 2, 3, 4", "1, 1, 2, 3, 40", ":10: element 1 has node 40, which is missing"),
        (
            "*Elset, elset=skin",
            "*Nset, nset=n\n4, 5\n*Elset, elset=skin",
            ":11: set `n` has node 5",
        ),
    ] {
        let found = errors("a.inp", &changed(&text, old, new));
        assert!(found.len() == 1 && found[0].contains(wanted), "`{wanted}`: {found:?}");
    }
    let plate = text_of("broken/plate.msh");
    let found = errors("a.msh", &changed(&plate, "3 1 2 5 4", "3 1 2 5 999"));
    assert!(found.len() == 1 && found[0].contains("element 3 has node 999"), "{found:?}");
}

/// Shells and solids with one property are one part: a warning names the line of the second kind.
#[test]
fn shells_and_solids_of_one_property_are_warned_of() {
    let plate = text_of("broken/plate.bdf");
    let more = "GRID,9,,0.,0.,1.\nCTETRA,30,7,1,2,4,9\nPSHELL         7";
    let found = good("a.bdf", &changed(&plate, "PSHELL         7", more));
    let [warning] = &found.warnings[..] else { panic!("{:?}", found.warnings) };
    assert!(warning.message.contains(":13: property 7 has shells and solids"), "{warning:?}");
    assert!(good("b.bdf", &plate).warnings.is_empty());
}

/// A reference point and its mass leave the ids and the names of the sets of the only instance.
#[test]
fn a_reference_point_changes_no_ids_and_names() {
    let plate = text_of("broken/plate.inp");
    let more = "*End Instance\n*Node\n7, 0., 0., 5.\n*Nset, nset=RP\n7,\n*Element, type=MASS, \
                elset=heavy\n9, 7\n*Surface, type=NODE, name=N\nPlate-1.rim\n";
    let found = good("a.inp", &changed(&plate, "*End Instance\n", more));
    let ids: Vec<u64> = found.mesh.nodes.iter().map(|node| node.id).collect();
    assert_eq!(ids, [1, 2, 3, 4, 5, 6]);
    assert_eq!(set_names(&found), ["N", "corner", "rim", "skin", "top"]);
    assert_eq!(found.mesh.node_sets["N"], [1, 2, 3]);
    assert_eq!(row(&found, "node set RP"), Some((Fate::Ignored, 1)));
    assert_eq!(row(&found, "point mass"), Some((Fate::Ignored, 1)));
}

/// A rigid body of some elements of a section makes only these rigid, in a part of their own.
#[test]
fn rigid_elements_of_a_section_are_a_part_of_their_own() {
    let plate = text_of("broken/plate.inp");
    let body = "*Elset, elset=half\n2,\n*Rigid Body, ref node=1, elset=half\n*End Part";
    let mesh = good("a.inp", &changed(&plate, "*End Part", body)).mesh;
    let parts: Vec<_> = mesh.parts.iter().map(|p| (p.name.as_str(), p.rigid)).collect();
    assert_eq!(parts, [("skin", false), ("skin-2", true)]);
    let of: Vec<usize> = mesh.elements.iter().map(|e| e.part).collect();
    assert_eq!(of, [0, 1]);
}

/// An unknown keyword does not end a material, curves of several rates are one table, and values
/// without a material are an error.
#[test]
fn materials_go_on_after_unknown_keywords() {
    let plate = text_of("broken/plate.inp");
    let heat = "*Inelastic Heat Fraction\n0.9,\n*Plastic, rate=0.\n";
    let text = changed(&plate, "*Plastic\n", heat) + "*Plastic, rate=10.\n400., 0.\n500., 0.2\n";
    let found = good("a.inp", &text);
    let rows = [[0.0, 0.0, 300.0], [0.0, 0.5, 500.0], [10.0, 0.0, 400.0], [10.0, 0.2, 500.0]];
    assert_eq!(found.mesh.materials[0].hardening_by_rate, rows);
    let heat = row(&found, "*INELASTIC HEAT FRACTION of material Steel");
    assert_eq!(heat, Some((Fate::Ignored, 1)));
    let rate = row(&found, "*PLASTIC, RATE= of material Steel");
    assert_eq!(rate, Some((Fate::Read, 2)));
    let twice = plate.clone() + "*Plastic\n400., 0.\n";
    refused("a.inp", &twice, "material `Steel` has *PLASTIC twice");
    let outside = plate + "*Step\n*Elastic\n1., 0.\n";
    refused("a.inp", &outside, "*ELASTIC belongs to no *MATERIAL");
}

/// Plasticity of Johnson and Cook, and each form of the strain rate, are keys of the job, and the
/// job is valid. What a law does not have is a row of the table.
#[test]
fn strain_rates_of_abaqus_are_keys_of_the_law() {
    let folder = tempfile::tempdir().unwrap();
    let curve = "*Plastic\n300., 0.\n500., 0.5\n";
    let plate = changed(&text_of("broken/plate.inp"), curve, "");
    let cook = "*Plastic, hardening=JOHNSON COOK\n300., 500., 0.3\n";
    let hot = "*Plastic, hardening=Johnson  Cook\n300., 500., 0.3, 1.03, 1700., 293.\n";
    let fast = "*Plastic, rate=10.\n400., 0.\n600., 0.5\n";
    let power = "*Rate Dependent\n40., 5.\n";
    let ratio = "*Rate Dependent, type=YIELD RATIO\n1., 0.\n1.5, 100.\n";
    let cook_rate = "*Rate Dependent, type=JOHNSON COOK\n0.02, 1.\n";
    let cases: [(&[&str], &[&str]); 5] = [
        (&[hot, cook_rate], &["johnson_cook", "a = 300.0", "b = 500.0", "n = 0.3", "c = 0.02"]),
        (&[cook], &["law = \"johnson_cook\""]),
        (&[curve, power], &["law = \"j2\"", "cowper_symonds = [40.0, 5.0]", "viscoplastic = true"]),
        (&[curve, ratio], &["rate_factors = [[0.0, 1.0], [100.0, 1.5]]", "viscoplastic = true"]),
        (&[fast, curve], &["hardening_by_rate = [[0.0, 0.0, 300.0], [0.0, 0.5, 500.0], [10.0,"]),
    ];
    for (number, (parts, keys)) in cases.iter().enumerate() {
        let [file, out] = ["inp", "job"].map(|end| folder.path().join(format!("{number}.{end}")));
        fs::write(&file, plate.clone() + &parts.concat()).unwrap();
        let [file, to] = [&file, &out].map(|path| path.to_str().unwrap());
        let said = run(crumple_with(&["import", file, "--out", to])).with_code(0).said();
        let job = fs::read_to_string(out.join("job.toml")).unwrap();
        assert!(keys.iter().all(|key| job.contains(key)), "{keys:?}: {said}{job}");
        run(crumple_with(&["check", to])).with_code(0);
    }
    let with = |parts: &[&str]| good("a.inp", &(plate.clone() + &parts.concat()));
    let found = with(&[hot, power]);
    let heat = row(&found, "m and temperatures of material Steel");
    assert_eq!(heat, Some((Fate::LeftOut, 1)));
    let rate = "*RATE DEPENDENT of material Steel";
    assert_eq!(row(&found, rate), Some((Fate::LeftOut, 1)));
    assert_eq!(row(&with(&[curve, cook_rate]), rate), Some((Fate::LeftOut, 1)));
    let other = changed(power, "Dependent", "Dependent, type=USER");
    let other = row(&with(&[curve, &other]), "*RATE DEPENDENT, TYPE=USER of material Steel");
    assert_eq!(other, Some((Fate::LeftOut, 1)));
    for (old, new, wanted) in [
        (cook, "*Plastic, hardening=JOHNSON COOK\n300., 500.\n", "lacks A, B or n of Johnson"),
        (cook, "*Plastic, hardening=JOHNSON COOK\n-1., 5., 1.\n", ":34: Johnson and Cook: A is -1"),
        (power, "*Rate Dependent\n40.\n", "*RATE DEPENDENT of material `Steel` lacks a value"),
        (power, "*Rate Dependent\n0., 5.\n", "*RATE DEPENDENT has the values 0 and 5"),
        (power, "*Rate Dependent\n", "*RATE DEPENDENT has no values"),
        (ratio, "*Rate Dependent, type=YIELD RATIO\n1., x\n", "`1., x` is no ratio and rate"),
        (fast, "*Plastic, rate=fast\n400., 0.\n", "`fast` is no strain rate"),
    ] {
        let text = plate.clone() + cook + power + ratio + fast;
        refused("a.inp", &changed(&text, old, new), wanted);
    }
}

/// Elements and sections that bend otherwise than a shell are refused, and left out if the job
/// allows it.
#[test]
fn membranes_and_stiffnesses_are_no_shells() {
    let plate = text_of("broken/plate.inp");
    refused("a.inp", &plate.replace("S4R", "M3D4"), "2 elements of type membrane are not");
    refused("a.inp", &plate.replace("S4R", "SFM3D4R"), "2 elements of type surface element with");
    let old = "*Shell Section, elset=skin, material=Steel\n0.1, 5\n";
    let stiff = changed(&plate, old, "*Shell General Section, elset=skin\n1000., 300.\n");
    assert_eq!(errors("a.inp", &stiff).len(), 1);
    refused("a.inp", &stiff, "the section of `skin` has stiffnesses and no material");
    let found = read_text("a.inp", stiff.as_bytes(), true).ok().unwrap();
    assert_eq!(found.mesh.parts[0].thickness, None);
}

/// The third node of a beam gives its direction n1: here along y, instead of -z of the section.
#[test]
fn a_third_node_gives_the_direction_of_a_beam() {
    let text = "*Node\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 5., 0.\n*Element, type=B31, elset=b\n\
                1, 1, 2, 3\n*Beam Section, elset=b, section=RECT, material=Steel\n2., 1.\n\
                0., 0., -1.\n*Material, name=Steel\n*Elastic\n207., 0.3\n";
    assert_eq!(good("a.inp", text).mesh.elements[0].axis, Some([0.0, 5.0, 0.0]));
    let without = changed(text, "1, 1, 2, 3", "1, 1, 2");
    assert_eq!(good("a.inp", &without).mesh.elements[0].axis, Some([0.0, 0.0, -1.0]));
    let missing = changed(text, "1, 1, 2, 3", "1, 1, 2, 4");
    refused("a.inp", &missing, ":6: element 1 has node 4, which is missing");
}

/// A set that names itself has each node once, and too many ids are an error before they are made.
#[test]
fn sets_of_sets_stay_small() {
    let plate = text_of("broken/plate.inp");
    let again = "*Nset, nset=rim\nrim, rim\n".repeat(40);
    let found = good("a.inp", &changed(&plate, "*End Part", &(again + "*End Part")));
    assert_eq!(found.mesh.node_sets["rim"], [1, 2, 3]);
    let long = changed(&plate, "1, 3, 1", "1, 60000000, 1");
    refused("a.inp", &long, ":15: the sets of the file have more than 50000000 ids");
}

/// One file under two paths is included twice.
#[test]
fn a_file_is_included_once_whatever_its_path() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("sub")).unwrap();
    fs::write(folder.path().join("more.inp"), "*Nset, nset=more\n1, 2\n").unwrap();
    let plate = text_of("broken/plate.inp");
    let path = folder.path().join("a.inp");
    for second in ["./more.inp", "sub/../more.inp", "./a.inp"] {
        let lines = format!("*Include, input=more.inp\n*Include, input={second}\n*End Part");
        fs::write(&path, changed(&plate, "*End Part", &lines)).unwrap();
        let problems = read(&path, false, None).err().unwrap();
        let wanted = format!("`{second}` is included twice");
        assert!(problems[0].message.contains(&wanted), "{problems:?}");
    }
}

/// Thicknesses of corners, pin flags and offsets of bars of Nastran are refused, or left out if the
/// job allows it; blank fields and 0 are read, and so are fields after tabs.
#[test]
fn fields_of_nastran_elements_are_not_dropped() {
    let plate = text_of("broken/plate.bdf");
    let quad = "CQUAD4         1       7       1       2       5       4";
    let bar = "CBAR          11       8       3       6      0.      0.      1.";
    for (old, new, wanted) in [
        (quad, "CQUAD4,1,7,1,2,5,4\n+,,,.1,.1,.1,.1", "thicknesses of its corners (T1 to T4)"),
        (bar, "CBAR,11,8,3,6,0.,0.,1.\n+,123", "pin flags (PA, PB)"),
        (bar, "CBAR,11,8,3,6,0.,0.,1.\n+,,,.1", "offsets of its ends (W1A to W3B)"),
    ] {
        let text = changed(&plate, old, new);
        refused("a.bdf", &text, &format!("an element has {wanted}"));
        let found = read_text("a.bdf", text.as_bytes(), true).ok().unwrap();
        assert_eq!(found.mesh.elements.len(), 3, "{new}");
        assert_eq!(row(&found, wanted), Some((Fate::LeftOut, 1)));
    }
    let zero = changed(&plate, quad, "CQUAD4,1,7,1,2,5,4,,0.\n+,,,0.");
    assert_eq!(good("a.bdf", &zero).mesh.elements.len(), 3);
    let tabs = changed(&plate, "GRID,6,,2.,1.,0.", "GRID\t6\t\t2.\t1.\t0.");
    assert_eq!(good("a.bdf", &tabs).mesh.nodes[5].x, [2.0, 1.0, 0.0]);
}

/// Offsets of shells are keys of the job, from the nodes to the middle surface over half the
/// thickness. With SPOS of Abaqus the nodes are on the top face. With ZOFFS 0.05 of Nastran and the
/// thickness 0.1 they are on the bottom face. Contact is then at the true faces.
#[test]
fn offsets_of_shells_are_keys_of_the_job() {
    let folder = tempfile::tempdir().unwrap();
    let abaqus = text_of("broken/plate.inp");
    let section = "material=Steel\n";
    let [top, bottom] = ["offset=SPOS", "offset=sneg"]
        .map(|offset| changed(&abaqus, section, &format!("material=Steel, {offset}\n")));
    let bulk = text_of("broken/plate.bdf");
    let quads = "CQUAD4         1       7       1       2       5       4\n\
                 CQUAD4         2       7       2       3       6       5\n";
    let nastran = |one: &str, two: &str| {
        let new = format!("CQUAD4,1,7,1,2,5,4,,{one}\nCQUAD4,2,7,2,3,6,5,,{two}\n");
        changed(&bulk, quads, &new)
    };
    let own = "# its shells have the offsets of the file";
    let hint = "# shell_offset = true";
    let cases: [(&str, String, &[&str], &str); 6] = [
        ("a.inp", top, &["offset = -1.0", hint], own),
        ("b.inp", bottom, &["offset = 1.0", hint], own),
        ("c.inp", abaqus, &[], "offset"),
        ("d.bdf", nastran(".05", ".05"), &["offset = 1.0", hint], own),
        ("e.bdf", nastran("-.05", "-.05"), &["offset = -1.0", hint], own),
        ("f.bdf", nastran(".05", ""), &[own, hint], "offset = 1.0"),
    ];
    for (name, text, keys, other) in cases {
        let (file, out) = (folder.path().join(name), folder.path().join(format!("{name}-job")));
        fs::write(&file, text).unwrap();
        let [file, to] = [&file, &out].map(|path| path.to_str().unwrap());
        run(crumple_with(&["import", file, "--out", to])).with_code(0);
        let job = fs::read_to_string(out.join("job.toml")).unwrap();
        assert!(keys.iter().all(|key| job.contains(key)), "{name}: {keys:?}\n{job}");
        assert!(!job.contains(other), "{name}: {other}\n{job}");
        let checked = run(crumple_with(&["check", to])).with_code(0).said();
        assert!(!checked.contains("have the offset"), "{name}: {checked}");
    }
    let found = good("a.bdf", &nastran(".05", ".05"));
    assert_eq!(row(&found, "ZOFFS"), Some((Fate::Read, 2)));
    let found = good("a.bdf", &nastran("", ".05"));
    assert_eq!(row(&found, "ZOFFS"), Some((Fate::Read, 1)));
}

/// Positions in systems of Nastran and Abaqus are in that of the mesh, and the table says so. The
/// dofs of a support in another system are named.
#[test]
fn systems_of_nodes_are_rows_of_the_table() {
    let plate = text_of("broken/plate.bdf");
    let cards = "CORD2C,3,,0.,0.,0.,0.,0.,1.\n+,1.,0.,0.\nCORD2R,4,,0.,0.,0.,0.,0.,1.\n\
                 +,1.,0.,0.\nGRID,6,3,2.,30.,1.,3\n";
    let found = good("a.bdf", &changed(&plate, "GRID,6,,2.,1.,0.\n", cards));
    assert_eq!(row(&found, "CORD2C"), Some((Fate::Read, 1)));
    assert_eq!(row(&found, "CORD2R"), Some((Fate::Ignored, 1)));
    // The vector of a bar has the axes of the displacements of its first node.
    let bar = "GRDSET,,,,,,4\nGRID,6,3,2.,30.,1.\nCBAR,90,91,6,1,5.,0.,0.\n\
               PBAR,91,1,1.,1.,1.,1.\n";
    let text = changed(&plate, "GRID,6,,2.,1.,0.\n", cards);
    let with_bar = good("a.bdf", &changed(&text, "GRID,6,3,2.,30.,1.,3\n", bar));
    assert_eq!(row(&with_bar, "CORD2R"), Some((Fate::Read, 1)));
    assert_eq!(row(&with_bar, "GRDSET"), Some((Fate::Read, 1)));
    // 2 cos 30, 2 sin 30.
    let wanted = [3.0_f64.sqrt(), 1.0, 1.0];
    let apart = (0..3).map(|c| (found.mesh.nodes[5].x[c] - wanted[c]).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-14, "{:?}", found.mesh.nodes[5]);
    let spc = "SPC1           1  123456       1       2";
    let text = changed(&changed(&plate, "GRID,6,,2.,1.,0.\n", cards), spc, "SPC1,1,123,1,6");
    let found = good("a.bdf", &text);
    let became = found.rows.iter().find(|row| row.what == "SPC1 1").map(|row| &row.became);
    assert!(became.unwrap().contains("1 of the nodes have others (CD)"), "{became:?}");

    let plate = text_of("broken/plate.inp");
    let found =
        good("a.inp", &changed(&plate, "*Node\n", "*System\n5., 0., 0.\n*Node, system=C\n"));
    assert_eq!(row(&found, "*NODE, SYSTEM=C"), Some((Fate::Read, 6)));
    assert_eq!(row(&found, "*SYSTEM"), Some((Fate::Read, 1)));
    // Node 2 has the radius 1; the instance is moved by 1 along z.
    assert_eq!(found.mesh.nodes[1].x, [6.0, 0.0, 1.0]);
}

/// A section with thicknesses at nodes is refused, or has the thickness of its first line if the
/// job allows it. The thicknesses are a row of the table.
#[test]
fn thicknesses_at_nodes_are_not_dropped() {
    let plate = text_of("broken/plate.inp");
    let more = "material=Steel, nodal thickness\n";
    let text = changed(&plate, "material=Steel\n", more);
    let text = changed(&text, "*End Part", "*Nodal Thickness\nrim, 0.3\n*End Part");
    refused("a.inp", &text, ":18: the section of `skin` has NODAL THICKNESS");
    let found = read_text("a.inp", text.as_bytes(), true).ok().unwrap();
    assert_eq!(found.mesh.parts[0].thickness, Some(0.1));
    assert_eq!(row(&found, "*NODAL THICKNESS"), Some((Fate::Ignored, 1)));
}

/// `crumple import` writes only into its folder, and replaces no file there.
#[test]
fn an_import_stays_in_its_folder_and_replaces_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| -> PathBuf { folder.path().join(name) };
    let plate = text_of("broken/plate.inp");
    let more = "*Nset, nset=more\n1, 2\n";
    for name in ["models", "common"] {
        fs::create_dir(at(name)).unwrap();
        fs::write(at(name).join("more.inp"), more).unwrap();
    }
    let with = |include: &str| {
        let lines = format!("*Include, input={include}\n*End Part");
        fs::write(at("models/a.inp"), changed(&plate, "*End Part", &lines)).unwrap();
    };
    let import = || {
        let words = ["import", at("models/a.inp").to_str().unwrap(), "--out"].map(String::from);
        let out = at("out").to_str().unwrap().to_string();
        let words: Vec<&str> = words.iter().map(String::as_str).chain([out.as_str()]).collect();
        run(crumple_with(&words))
    };
    with("../common/more.inp");
    let said = import().with_code(2).said();
    assert!(said.contains("is not in the folder of") && said.contains("next to"), "{said}");
    assert!(!at("out").exists());
    with("more.inp");
    fs::create_dir(at("out")).unwrap();
    fs::write(at("out/more.inp"), "mine").unwrap();
    let said = import().with_code(2).said();
    assert!(said.contains("would replace") && said.contains("--out"), "{said}");
    assert_eq!(fs::read_to_string(at("out/more.inp")).unwrap(), "mine");
    assert!(!at("out/job.toml").exists());
    // A file with the same bytes loses nothing.
    fs::write(at("out/more.inp"), more).unwrap();
    import().with_code(0);
    assert!(at("out/job.toml").exists() && at("out/a.inp").exists());
}

/// Numbers of points that are no whole numbers from 0 are errors in both forms of VTK.
#[test]
fn numbers_of_points_are_whole() {
    let offsets = |points: &str| {
        format!(
            "# vtk DataFile Version 5.1\na\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n\
             0 0 0 1 0 0 1 1 0 0 1 0\nCELLS 2 4\nOFFSETS vtktypeint64\n0 4\n\
             CONNECTIVITY vtktypeint64\n{points}\nCELL_TYPES 1\n9\n"
        )
    };
    assert_eq!(good("a.vtk", &offsets("0 1 2 3")).mesh.elements[0].corners, [1, 2, 3, 4]);
    refused("a.vtk", &offsets("0 1 2 -1"), "cell 0 has the point -1");
    refused("a.vtk", &offsets("0 1 2 2.5"), "cell 0 has the point 2.5");
    let plate = text_of("broken/plate.vtk");
    refused("a.vtk", &changed(&plate, "4 0 1 4 3", "4 0 1 4 3.5"), "cell 0 has the point 3.5");
    let plate = text_of("broken/plate.vtu");
    for wrong in ["18446744073709551615", "4.5", "1e300"] {
        let text = changed(&plate, "0 1 4 3 1 2 5 4", &format!("0 1 {wrong} 3 1 2 5 4"));
        refused("a.vtu", &text, ":10: a cell has the points [0.0, 1.0, ");
    }
    let shares = changed(&text_of("broken/plate.vtk"), "\n4\n5\nPOINT", "\n4.5\n5\nPOINT");
    let found = good("a.vtk", &shares);
    assert_eq!(row(&found, "array MaterialID"), Some((Fate::Ignored, 1)));
    assert_eq!(found.mesh.parts.len(), 1);
}

/// Part numbers that can be ids keep them; 0 gets a free id, and the table says which.
#[test]
fn part_numbers_of_vtk_keep_their_ids() {
    let text = changed(&text_of("broken/plate.vtk"), "\n4\n5\nPOINT", "\n0\n1\nPOINT");
    let found = good("a.vtk", &text);
    let mesh = &found.mesh;
    let ids: Vec<_> = mesh.elements.iter().map(|e| (e.id, mesh.parts[e.part].id)).collect();
    assert_eq!(ids, [(1, 2), (2, 1)]);
    assert_eq!(row(&found, "faces of part number 0"), Some((Fate::Read, 1)));
}

/// Points of two pieces with one id are one node; without ids a warning names the seam.
#[test]
fn pieces_are_joined_by_the_ids_of_their_points() {
    let text = text_of("made/pieces.vtu");
    let found = good("a.vtu", &text);
    assert_eq!((found.mesh.nodes.len(), found.warnings.len()), (6, 0));
    let corners: Vec<_> = found.mesh.elements.iter().map(|e| e.corners.clone()).collect();
    assert_eq!(corners, [[0, 1, 2, 3], [1, 4, 5, 2]]);
    let found = good("a.vtu", &text.replace("GlobalNodeId", "level"));
    assert_eq!(found.mesh.nodes.len(), 8);
    assert!(found.warnings[0].message.contains("2 pieces"), "{:?}", found.warnings);
    // One id at two places is no id of a point.
    let found = good("a.vtu", &changed(&text, "1 0 0 2 0 0 2 1 0", "1 0 1 2 0 0 2 1 0"));
    assert_eq!(found.mesh.nodes.len(), 8);
    assert_eq!(row(&found, "array GlobalNodeId"), Some((Fate::Ignored, 1)));
}

/// Fields of bits and signed bytes do not refuse a mesh, as text and in binary form.
#[test]
fn fields_of_bits_are_read_over() {
    let fields = "CELL_DATA 2\nSCALARS flag bit 1\nLOOKUP_TABLE default\n0\n1\nSCALARS level \
                  signed_char 1\nLOOKUP_TABLE default\n-1\n1\n";
    let text = changed(&text_of("broken/plate.vtk"), "CELL_DATA 2\n", fields);
    assert_eq!(good("a.vtk", &text).mesh.elements.len(), 2);
    let mut bytes = b"# vtk DataFile Version 3.0\na\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 \
                      float\n"
        .to_vec();
    let points = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    let put = |bytes: &mut Vec<u8>, numbers: &[i32]| {
        bytes.extend(numbers.iter().flat_map(|number| number.to_be_bytes()));
    };
    bytes.extend(points.iter().flat_map(|number| number.to_be_bytes()));
    bytes.extend(b"\nCELLS 1 5\n");
    put(&mut bytes, &[4, 0, 1, 2, 3]);
    bytes.extend(b"\nCELL_TYPES 1\n");
    put(&mut bytes, &[9]);
    bytes.extend(b"\nCELL_DATA 1\nSCALARS flag bit 1\nLOOKUP_TABLE default\n\x80\nSCALARS part ");
    bytes.extend(b"int 1\nLOOKUP_TABLE default\n");
    put(&mut bytes, &[7]);
    let found = read_text("a.vtk", &bytes, false).unwrap_or_else(|p| panic!("{p:?}"));
    assert_eq!(found.mesh.parts[0].id, 7);
}

/// An element that MSH 2.2 repeats for its second group is counted in the table; in MSH 4.1 two
/// elements with the same corners are two elements.
#[test]
fn repeated_elements_of_gmsh_are_counted() {
    let nodes = "1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n";
    let old = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n{nodes}$EndNodes\n$Elements\n2\n\
         1 3 2 1 1 1 2 3 4\n2 3 2 2 1 1 2 3 4\n$EndElements\n"
    );
    let found = good("a.msh", &old);
    assert_eq!(found.mesh.elements.len(), 1);
    assert_eq!(row(&found, "elements of several groups"), Some((Fate::Ignored, 1)));
    let new = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n2 1 0 4\n1\n2\n3\n4\n\
               0 0 0\n1 0 0\n1 1 0\n0 1 0\n$EndNodes\n$Elements\n1 2 1 2\n2 1 3 2\n1 1 2 3 4\n\
               2 1 2 3 4\n$EndElements\n";
    assert_eq!(good("a.msh", new).mesh.elements.len(), 2);
}

/// Two solids of one name are two parts with names and sets of their own.
#[test]
fn solids_of_one_name_get_names_of_their_own() {
    let solid = |z: u32| {
        format!(
            "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 {z}\nvertex 1 0 {z}\n\
             vertex 0 1 {z}\nendloop\nendfacet\nendsolid a\n"
        )
    };
    let found = good("a.stl", &(solid(0) + &solid(1)));
    let names: Vec<&str> = found.mesh.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["a", "a-2"]);
    assert_eq!(found.mesh.node_sets["a"], [1, 2, 3]);
    assert_eq!(found.mesh.node_sets["a-2"], [4, 5, 6]);
    assert_eq!(row(&found, "part a"), Some((Fate::Read, 1)));
}

/// The end of an analysis of Abaqus is that of the job, and the units are printed; a folder is no
/// mesh file, and a mesh file no job.
#[test]
fn the_duration_of_an_abaqus_analysis_is_the_end_time() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("beam.inp");
    let step = "*Step\n*Dynamic, Explicit\n, 0.002\n*End Step\n";
    fs::write(&source, text_of("made/block.inp") + step + step).unwrap();
    let out = folder.path().join("job");
    let [file, to, inside] = [&source, &out, &folder.path().to_path_buf()]
        .map(|path| path.to_string_lossy().into_owned());
    let said = run(crumple_with(&["import", &file, "--out", &to])).with_code(0).said();
    assert!(said.contains("units        mm, ms, kg: the file has no materials"), "{said}");
    let job = fs::read_to_string(out.join("job.toml")).unwrap();
    assert!(job.contains("end_time = 0.004") && !job.contains("\"end_time\""), "{job}");

    // A file with everything leaves no placeholder, and nothing speaks of one.
    let shell = text_of("third-party/meshioplusplus/s4.inp");
    let whole = changed(&shell, "*STATIC", "*DYNAMIC, EXPLICIT\n, 0.002");
    fs::write(&source, whole).unwrap();
    let to = folder.path().join("whole");
    let words = ["import", &file, "--out", to.to_str().unwrap()];
    let said = run(crumple_with(&words)).with_code(0).said();
    let job = fs::read_to_string(to.join("job.toml")).unwrap();
    assert!(said.contains("\nnext         crumple check"), "{said}");
    assert!(!said.contains("placeholder") && !job.contains("placeholder"), "{said}{job}");
    run(crumple_with(&["check", to.to_str().unwrap()])).with_code(0);

    let said = run(crumple_with(&["import", &inside])).with_code(2).said();
    assert!(said.contains("is a folder"), "{said}");
    let said = run(crumple_with(&["run", &file])).with_code(2).said();
    assert!(
        said.contains("is a mesh file, not a job") && said.contains("crumple import"),
        "{said}"
    );
}

/// Units fit the materials of the file: without a density, Young's modulus alone.
#[test]
fn units_follow_from_the_modulus_where_there_is_no_density() {
    let folder = tempfile::tempdir().unwrap();
    let imported = |name: &str, text: &str| {
        let (source, out) = (folder.path().join(format!("{name}.inp")), folder.path().join(name));
        fs::write(&source, text).unwrap();
        let [file, to] = [&source, &out].map(|path| path.to_string_lossy().into_owned());
        let said = run(crumple_with(&["import", &file, "--out", &to])).with_code(0).said();
        (said, fs::read_to_string(out.join("job.toml")).unwrap())
    };
    let block = text_of("made/block.inp");
    let with = |elastic: &str| format!("{block}*MATERIAL, NAME=STEEL\n*ELASTIC\n{elastic}, 0.3\n");
    for (name, modulus, units, density) in [
        ("gpa", "210.", "mm, ms, kg", "density = 7.85e-6"),
        ("mpa", "210000.", "mm, s, t", "density = 7.85e-9"),
        ("si", "2.1e11", "m, s, kg", "density = 7850.0"),
    ] {
        let (said, job) = imported(name, &with(modulus));
        assert!(said.contains(&format!("units        {units}: the file has no density")), "{said}");
        assert!(said.contains("STEEL can have Young's modulus 210"), "{said}");
        assert!(job.contains(&format!("units = \"{units}\"")) && job.contains(density), "{job}");
        assert!(job.contains("material.STEEL.density"), "a placeholder: {job}");
    }
    // Rubber and steel, and a modulus that no solid has.
    let rubber = "*MATERIAL, NAME=RUBBER\n*ELASTIC\n5., 0.49\n";
    let (said, _) = imported("rubber", &(with("210000.") + rubber));
    assert!(said.contains("units        mm, s, t: the file has no density"), "{said}");
    let (said, _) = imported("none", &with("1e20"));
    assert!(said.contains("fit no common units"), "{said}");
    let (said, _) = imported("dense", &(with("210000.") + "*DENSITY\n7.85e-9\n"));
    assert!(said.contains("units        mm, s, t: the materials of the file fit"), "{said}");
}
