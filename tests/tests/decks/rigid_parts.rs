//! Rigid bodies of decks: mass properties of their own, what is fixed of them, planes that fix
//! nodes, and prescribed rotations. The cube of the
//! base is rigid: nodes 1 to 8, its centre at (5, 5, 5). Units mm, ms, kg.

use crate::base::{BASE, MOVES, STEEL, model_of, report_of};
use crumple::input::check::describe;
use crumple::input::job::Model;
use crumple_proto::ids::NodeId;
use crumple_tests::run_alone;

/// Returns the base with the cube as a rigid part with these mass properties, and more lines.
fn with_inertia(inertia: &str, lines: &str) -> String {
    let base = BASE.replace("cube\n2,2,1\n", "");
    format!(
        "{base}{STEEL}{MOVES}*MAT_RIGID\n2,7.85e-6,207.0,0.3\n*PART_INERTIA\ncube\n2,2,2\n\
         {inertia}{lines}"
    )
}

/// Returns the masses of the solids of the rigid part.
fn masses(model: &Model) -> Vec<f64> {
    let all = model.mesh.elements.iter().zip(&model.elements.mass);
    all.filter(|(e, _)| e.part == 2).map(|(_, mass)| *mass).collect()
}

/// The centre of a body of one solid cannot move: its middle is the only place inside of it. With a
/// second solid of the part it can, and the masses of the elements follow.
#[test]
fn the_centre_of_mass_is_that_of_the_card() {
    let numbers = "0.5,0.0,0.0,0.5,0.0,0.5\n0.0,0.0,0.0\n";
    let one = model_of(&with_inertia(&format!("5.0,5.0,6.0,0.02\n{numbers}"), ""));
    assert_eq!(one.job.rigid[0].centre, None);
    let words = "is not inside of its elements";
    assert!(one.warnings.iter().any(|w| w.message.contains(words)), "{:?}", one.warnings);

    let second = "*NODE\n21,0,0,20\n22,10,0,20\n23,10,10,20\n24,0,10,20\n\
                  25,0,0,30\n26,10,0,30\n27,10,10,30\n28,0,10,30\n\
                  *ELEMENT_SOLID\n9,2,21,22,23,24,25,26,27,28\n";
    // The middles of the solids are at 5 and 25.
    let two = model_of(&with_inertia(&format!("5.0,5.0,10.0,0.02\n{numbers}"), second));
    assert_eq!(two.job.rigid[0].centre, Some([5.0, 5.0, 10.0]));
    let [lower, upper] = masses(&two)[..] else { panic!("two solids") };
    assert!((lower - 0.015).abs() < 1e-12 && (upper - 0.005).abs() < 1e-12, "{lower} {upper}");
}

/// Moments of a flat body that are rounded may exceed the sum of the other two a little.
#[test]
fn rounded_inertia_is_no_fault() {
    let of = |zz: &str| with_inertia(&format!("5,5,5,1.0\n8.334,0,0,52.08,0,{zz}\n0,0,0\n"), "");
    assert_eq!(model_of(&of("60.42")).job.rigid[0].inertia.unwrap()[2], 60.42);
    let report = report_of(&of("60.6"));
    assert!(report.contains("no distribution of mass has this inertia"), "{report}");
}

/// A part with nodes of other parts keeps its mass properties, with a warning; one without elements
/// has those of these nodes.
#[test]
fn parts_with_extra_nodes_keep_their_inertia() {
    let extra = "*CONSTRAINED_EXTRA_NODES_NODE\n2,11\n";
    let inertia = "5.0,5.0,5.0,0.02\n0.5,0.0,0.0,0.5,0.0,0.5\n1.0,0.0,0.0\n";
    let joined = model_of(&with_inertia(inertia, extra));
    assert_eq!(joined.job.rigid[0].mass, Some(0.02));
    let said = |model: &Model, words: &str| {
        assert!(model.warnings.iter().any(|w| w.message.contains(words)), "{:?}", model.warnings);
    };
    said(&joined, "masses of nodes of other parts in the body (1)");

    let three = "*CONSTRAINED_EXTRA_NODES_SET\n2,7\n*SET_NODE_LIST\n7\n11,12,14\n";
    let text = with_inertia(inertia, three).replace("*ELEMENT_SOLID\n1,2,1,2,3,4,5,6,7,8\n", "");
    let bare = model_of(&text);
    said(&bare, "part 2 has no elements");
    let body = &bare.job.rigid[0];
    assert!(body.mass.is_none() && body.parts.is_empty() && body.nodes.is_some());
    let moving = |id: u64| {
        let n = bare.mesh.nodes.iter().position(|n| n.id.0 == id).expect("a node");
        bare.nodes.velocity[n][0]
    };
    assert_eq!([11, 12, 14].map(moving), [1.0; 3]);
}

/// vad 2 of a rotation is an angle over the time.
#[test]
fn rotations_may_be_given_as_angles() {
    let rigid = BASE.replace("cube\n2,2,1\n", "cube\n2,2,2\n");
    let turn = |vad: i32, key: &str| {
        format!(
            "{rigid}{STEEL}{MOVES}*MAT_RIGID\n2,7.85e-6,207.0,0.3\n\
             *BOUNDARY_PRESCRIBED_MOTION_{key},6,{vad},9,0.5\n\
             *DEFINE_CURVE\n9\n0.0,0.0\n10.0,3.0\n*SET_NODE_LIST\n4\n11,12\n"
        )
    };
    let model = model_of(&turn(2, "RIGID\n2"));
    let motion = &model.job.motion[0];
    assert_eq!(motion.rotation, Some([0.0, 0.5, 0.0]));
    assert_eq!((motion.spin, &motion.dofs[..]), (None, &["ry".to_string()][..]));
    // Nodes have rotations by velocities only.
    assert!(report_of(&turn(2, "SET\n4")).contains("`vad` = 2 is not supported"));
    assert!(report_of(&turn(1, "RIGID\n2")).contains("`vad` = 1 is not supported"));
}

/// With iflag 0 the inertia of a leading part is that of the whole body; a part that it leads needs
/// none. Others are named.
#[test]
fn a_leading_part_has_the_inertia_of_its_body() {
    let second = |iflag: i32, lead: i32, other: i32| {
        let joined = format!(
            "*PART\nblock\n3,2,2\n*NODE\n21,30,0,0\n22,40,0,0\n23,40,10,0\n24,30,10,0\n\
             25,30,0,10\n26,40,0,10\n27,40,10,10\n28,30,10,10\n\
             *ELEMENT_SOLID\n9,3,21,22,23,24,25,26,27,28\n\
             *CONSTRAINED_RIGID_BODIES\n{lead},{other},{iflag}\n"
        );
        with_inertia("20.0,5.0,5.0,0.02\n0.5,0.0,0.0,0.5,0.0,0.5\n0.0,0.0,0.0\n", &joined)
    };
    let model = model_of(&second(0, 2, 3));
    let body = &model.job.rigid[0];
    assert_eq!((&body.parts[..], body.mass), (&[2, 3][..], Some(0.02)));
    // The middle of both solids is that of the card.
    assert_eq!(body.centre, None);
    let total: f64 = model
        .elements
        .mass
        .iter()
        .zip(&model.mesh.elements)
        .map(|(mass, e)| if e.part == 1 { 0.0 } else { *mass })
        .sum();
    assert!((total - 0.02).abs() < 1e-15, "{total}");
    for (iflag, lead, other) in [(1, 2, 3), (0, 3, 2)] {
        let report = report_of(&second(iflag, lead, other));
        assert!(report.contains("*PART_INERTIA of a part that is joined to others"), "{report}");
    }
}

/// The card of a body of nodes fixes its centre and its rotations, in axes of space.
#[test]
fn bodies_of_nodes_are_held() {
    let card = |codes: &str| {
        format!(
            "{BASE}{STEEL}{MOVES}*SET_NODE_LIST\n7\n11,12,14\n\
             *CONSTRAINED_NODAL_RIGID_BODY_SPC\n50,0,7\n{codes}\n"
        )
    };
    let fixed = |codes: &str| model_of(&card(codes)).job.rigid[0].fixed.clone();
    assert_eq!(fixed("1,4,3"), ["x", "y", "rz"]);
    assert!(fixed("0,4,3").is_empty());
    let report = report_of(&card("-1,4,111"));
    assert!(report.contains("`cmo` = -1 is not supported: constraints in local axes"), "{report}");
}

/// A plane that fixes what one of symmetry does is one; another one is named.
#[test]
fn global_planes_are_planes_of_symmetry() {
    let card = |codes: &str| {
        format!("{BASE}{STEEL}{MOVES}*CONSTRAINED_GLOBAL\n{codes},20.0,1.0,2.0,0.3\n")
    };
    let model = model_of(&card("1,5,1"));
    let plane = &model.job.symmetry[0];
    assert_eq!((plane.normal, plane.point), ([1.0, 0.0, 0.0], [20.0, 1.0, 2.0]));
    assert_eq!(plane.tolerance, 0.3);
    for codes in ["1,7,1", "4,5,1", "1,5,4"] {
        let report = report_of(&card(codes));
        assert!(report.contains("they are not those of a plane of symmetry"), "{report}");
        assert!(report.contains("*BOUNDARY_SPC_SET"), "{report}");
    }
}

/// Rigid shells without a thickness are met at their surface: a cube that flies against a wall of
/// them comes as far as half of the thickness that contact needs, and is thrown back.
#[test]
fn rigid_shells_without_a_thickness_are_a_surface() {
    let wall = |codes: &str, thickness: &str| {
        let base = BASE.replace("plate\n1,1,1\n", "plate\n1,1,9\n");
        let base = base.replace("1,2,1.0,3\n1.0\n", &format!("1,2,1.0,3\n{thickness}\n"));
        format!(
            "{base}{STEEL}*MAT_RIGID\n9,7.85e-6,207.0,0.3\n{codes}*SET_NODE_LIST\n4\n\
             1,2,3,4,5,6,7,8\n*INITIAL_VELOCITY\n4\n0.0,0.0,5.0\n\
             *CONTACT_AUTOMATIC_SINGLE_SURFACE\n0\n\n\n"
        )
    };
    let held = model_of(&wall("1,7,7\n", "0.0").replace("\n10.0\n", "\n1.0\n"));
    let said = describe(&held);
    assert!(
        said.contains("part 1: rigid shells without a thickness -> thickness 1.000e-1"),
        "{said}"
    );
    assert!(held.warnings.iter().all(|w| !w.message.contains("no thickness")));
    let mut highest = f64::NEG_INFINITY;
    let end = run_alone(&held, |engine| {
        let n = engine.nodes.local_index(NodeId(7)).expect("a corner of the cube") as usize;
        highest = highest.max(engine.nodes.x[n][2]);
    });
    println!("highest {highest}");
    // The plate is at 12; a step of 2e-3 at 5 is 0.01.
    assert!((highest - 11.95).abs() < 0.02, "{highest}");
    let corner = |id: u64| end.nodes.local_index(NodeId(id)).expect("a corner") as usize;
    let back = (1..=8).map(|id| end.nodes.v[corner(id)][2]).sum::<f64>() / 8.0;
    println!("velocity {back}");
    // One cell stops its upper nodes on the wall, with the loss of such an impact.
    assert!(back < -1.5 && back > -5.0, "it flies back: {back}");
    // A wall that can move has the mass of that thickness, with a warning.
    let free = model_of(&wall("", "0.0"));
    let words = "part 1 is rigid and can move, and its shells have no thickness";
    assert!(free.warnings.iter().any(|w| w.message.contains(words)), "{:?}", free.warnings);
    let report = report_of(&wall("", "0.0").replace("1,1,9\n", "1,1,1\n"));
    assert!(report.contains("have no `thickness`"), "{report}");
}

/// A velocity of a rigid body is that of all its parts and extra nodes, also if the card names one
/// of them.
#[test]
fn a_body_of_several_parts_starts_as_one() {
    let text = BASE.replace("cube\n2,2,1\n", "cube\n2,2,2\nother\n3,2,2\n");
    let model = model_of(&format!(
        "{text}{STEEL}{MOVES}*MAT_RIGID\n2,7.85e-6,207.0,0.3\n*NODE\n21,0,0,-10\n22,10,0,-10\n\
         23,10,10,-10\n24,0,10,-10\n*ELEMENT_SOLID\n9,3,21,22,23,24,1,2,3,4\n\
         *CONSTRAINED_RIGID_BODIES\n2,3\n*CONSTRAINED_EXTRA_NODES_NODE\n3,11\n\
         *INITIAL_VELOCITY_RIGID_BODY\n3,0,2.0,0,0.1\n"
    ));
    for (node, v) in model.mesh.nodes.iter().zip(&model.nodes.velocity) {
        let is_member = node.id.0 < 11 || node.id.0 > 20 || node.id.0 == 11;
        // The centre of both cubes is at z = 0, y = 5.
        let [_, y, z] = node.x;
        let wanted =
            if is_member { [0.0, 2.0 - 0.1 * z, 0.1 * (y - 5.0)] } else { [1.0, 0.0, 0.0] };
        let error = (0..3).map(|c| (v[c] - wanted[c]).abs()).fold(0.0, f64::max);
        assert!(error < 1e-12, "{}: {v:?}, {wanted:?}", node.id);
    }
}

/// Constraints of some nodes hold the body, with the rotations that would move these nodes; the
/// constraints of other nodes stay.
#[test]
fn constraints_of_some_nodes_hold_a_body() {
    let held = |lines: &str| {
        let text = BASE.replace("cube\n2,2,1\n", "cube\n2,2,2\n");
        let model =
            model_of(&format!("{text}{STEEL}{MOVES}*MAT_RIGID\n2,7.85e-6,207.0,0.3\n{lines}"));
        let mut fixed = model.job.rigid[0].fixed.clone();
        fixed.sort_unstable();
        let warned = model.warnings.iter().filter(|w| w.message.contains("hold its body")).count();
        (fixed, model.job.fix.len(), warned)
    };
    // The top is off the centre along all axes.
    let ring = "*SET_NODE_LIST\n7\n5,6,7,8\n*BOUNDARY_SPC_SET\n7,0,1,1\n";
    let words = |text: &str| text.split(' ').map(String::from).collect::<Vec<_>>();
    assert_eq!(held(ring), (words("rx ry rz x y"), 0, 1));
    // A node straight above the centre: z does not turn it.
    let middle = "*NODE\n31,5,5,20\n*CONSTRAINED_EXTRA_NODES_NODE\n2,31\n\
                  *ELEMENT_SHELL\n9,1,11,12,31\n*BOUNDARY_SPC_NODE\n31,0,0,0,1\n";
    assert_eq!(held(middle), (words("z"), 0, 1));
    // A plane of symmetry, with nodes of the plate too.
    let plane = "*SET_NODE_LIST\n7\n1,2,5,6,11,12,13\n*BOUNDARY_SPC_SET\n7,0,0,1,0,1,0,1\n";
    assert_eq!(held(plane), (words("rx rz y"), 1, 1));
}
