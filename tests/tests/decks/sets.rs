//! Sets of sets, sets of segments by options, and bodies of nodes with mass properties.
//!
//! In the base the plate has the shells 1 and 2 (nodes 11 to 16), the cube the nodes 1 to 8.

use super::base::{refused, with};
use super::fates::said;
use crumple::input::job::Model;
use crumple_proto::ids::ElemId;

/// A second cube on the first one: a solid of part 2 with the nodes 5 to 8 in common.
const UPPER: &str = "*NODE\n31,0,0,30\n32,10,0,30\n33,10,10,30\n34,0,10,30\n\
    *ELEMENT_SOLID\n9,2,5,6,7,8,31,32,33,34\n";
const RAMP: &str = "*DEFINE_CURVE\n4\n0,1\n1,1\n";

fn set(model: &Model, name: &str) -> Vec<u64> {
    model.mesh.node_sets[name].iter().map(|n| n.0).collect()
}

/// Returns the nodes of each face with a pressure, ascending.
fn loaded(lines: &str) -> Vec<Vec<u64>> {
    let model = with(&format!("{UPPER}{RAMP}{lines}*LOAD_SEGMENT_SET\n7,4,1.0\n"));
    let faces = model.settings.loads.pressures.iter().flat_map(|p| &p.faces);
    let nodes_of = |&(id, face): &(ElemId, u8)| {
        let element = model.mesh.elements.iter().find(|e| e.id == id).expect("an element");
        let face = element.shape.faces()[usize::from(face)];
        let mut nodes: Vec<u64> = face.iter().map(|&c| element.nodes[c].0).collect();
        nodes.sort_unstable();
        // The last node of a triangle is there twice.
        nodes.dedup();
        nodes
    };
    let mut all: Vec<Vec<u64>> = faces.map(nodes_of).collect();
    all.sort();
    all
}

/// Node sets may have the same title: each has its own id, and the later ones have a number in
/// their names. Sets with the same nodes are one.
#[test]
fn node_sets_may_have_one_title() {
    let titled = |sid: u32, nodes: &str| format!("*SET_NODE_LIST_TITLE\nhinge\n{sid}\n{nodes}\n");
    let model = with(&format!(
        "{}{}{}*DATABASE_HISTORY_NODE_SET\n2\n",
        titled(1, "11,12"),
        titled(2, "13,16"),
        titled(3, "12,11")
    ));
    assert_eq!(set(&model, "hinge"), [11, 12]);
    assert_eq!(set(&model, "hinge 2"), [13, 16]);
    assert_eq!([set(&model, "set-2"), set(&model, "set-3")], [vec![13, 16], vec![11, 12]]);
    assert!(!model.mesh.node_sets.contains_key("hinge 3"));
    assert_eq!(model.job.output.node[0].name, "hinge 2");
}

#[test]
fn sets_of_segments_have_options() {
    let general = |lines: &str| loaded(&format!("*SET_SEGMENT_GENERAL\n7\n{lines}"));
    let plate = [[11, 12, 14, 15], [12, 13, 15, 16]];
    assert_eq!(general("PART,1\n"), plate);
    assert_eq!(general("SHELL,2\n"), plate[1..]);
    assert_eq!(general("SEG,11,12,15,14\n"), plate[..1]);
    let cubes = general("PART,2\n");
    assert_eq!(cubes.len(), 10, "{cubes:?}");
    assert!(!cubes.contains(&vec![5, 6, 7, 8]), "the face between the cubes");
    assert_eq!(general("ALL\n").len(), 12);
    assert_eq!(general("ALL\nDPART,2\n"), plate);
    assert_eq!(general("PART,1\nDSEG,15,14,11,12\n"), plate[1..]);
    let low = "BOX,3\n*DEFINE_BOX\n3,-1,11,-1,11,-1,1\n";
    assert_eq!(general(low), [[1, 2, 3, 4]]);
    assert_eq!(general("BOX_SHELL,3\n*DEFINE_BOX\n3,-1,99,-1,99,-1,99\n"), plate);
    let of_sets = "SET_SHELL,5\nSET,6\n*SET_SHELL_LIST\n5\n1\n*SET_SEGMENT\n6\n1,2,3,4\n";
    assert_eq!(general(of_sets), [vec![1, 2, 3, 4], plate[0].to_vec()]);
    // The solids have raised ids, since the shells have them too. The upper cube has one face.
    assert_eq!(general("SET_SOLID,5\n*SET_SOLID\n5\n1\n").len(), 5);
    let sum = "*SET_SEGMENT_ADD\n7\n6,8\n*SET_SEGMENT\n6\n1,2,3,4\n\
               *SET_SEGMENT_GENERAL\n8\nSHELL,1\n";
    assert_eq!(loaded(sum), [vec![1, 2, 3, 4], plate[0].to_vec()]);
    // Attributes follow the ids: three, or four nodes with a blank one for a triangle.
    assert_eq!(general("PART,1,0,0,1.5\n"), plate);
    let triangle = "SEG,21,22,23,,12.0\n*PART\nfoil\n3,1,1\n*NODE\n21,0,0,40\n22,10,0,40\n\
                    23,10,10,40\n*ELEMENT_SHELL\n21,3,21,22,23,23\n";
    assert_eq!(general(triangle), [[21, 22, 23]]);
    // Sets of sets may name later ones.
    let later = "SET,8\n*SET_SEGMENT_ADD\n8\n9\n*SET_SEGMENT_GENERAL\n9\nSHELL,1\n";
    assert_eq!(general(later), plate[..1]);
    let report = refused("*SET_SEGMENT_GENERAL\n7\nSET,8\n*SET_SEGMENT_ADD\n8\n7\n");
    assert!(report.contains("*SET_SEGMENT_GENERAL 7: it is made of itself"), "{report}");
    let report = refused("*SET_SEGMENT_GENERAL\n7\nSHELL,77\n");
    assert!(report.contains("there is no shell 77"), "{report}");
    let report = refused("*SET_SEGMENT_GENERAL\n7\nPART,1.5\n");
    assert!(report.contains("`e` has to be a whole number, not 1.5"), "{report}");
    let report = refused("*SET_SEGMENT_GENERAL\n7\nVOL,3\n");
    assert!(report.contains("*SET_SEGMENT_GENERAL: option VOL is not supported"), "{report}");
    let report = refused("*SET_SEGMENT_ADD\n7\n6\n");
    assert!(report.contains("there is no *SET_SEGMENT with the id 6"), "{report}");
}

#[test]
fn sets_of_nodes_have_other_kinds_of_sets() {
    let model = with(
        "*SET_NODE_ADD_ADVANCED_TITLE\nall kinds\n7\n1,1,2,2,3,5\n4,4\n*SET_NODE_LIST\n1\n1\n\
         *SET_SHELL_LIST\n2\n2\n*SET_SEGMENT\n3\n1,2,3,4\n*SET_SOLID\n4\n1\n\
         *SET_NODE_ADD\n8\n7\n",
    );
    let nodes = [1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 15, 16];
    for name in ["set-7", "set-8", "all kinds"] {
        assert_eq!(set(&model, name), nodes, "{name}");
    }
    let report = refused("*SET_NODE_ADD_ADVANCED\n7\n1,3\n");
    assert!(report.contains("`type` = 3 is not supported"), "{report}");
    let report = refused("*SET_NODE_ADD_ADVANCED\n7\n6,2\n");
    assert!(report.contains("there is no *SET_SHELL_LIST with the id 6"), "{report}");
}

#[test]
fn sets_of_elements_and_parts_add_others() {
    let lists = "*SET_SHELL_LIST\n1\n1\n*SET_SHELL_LIST\n2\n2\n*SET_SHELL_ADD\n3\n1,2\n";
    let model = with(&format!("{RAMP}{lists}*LOAD_SHELL_SET\n3,4,1.0\n"));
    let faces: usize = model.settings.loads.pressures.iter().map(|p| p.faces.len()).sum();
    assert_eq!(faces, 2);
    for (lines, what) in [
        ("*SET_SHELL_ADD\n3\n1\n", "*SET_SHELL_LIST with the id 1"),
        ("*SET_SOLID_ADD\n3\n1\n", "*SET_SOLID with the id 1"),
        ("*SET_PART_ADD\n3\n1\n", "*SET_PART_... with the id 1"),
    ] {
        let report = refused(lines);
        assert!(report.contains(&format!("there is no {what}")), "{report}");
    }
}

/// The mass of the card is on the nodes of the body, with the centre of the card.
#[test]
fn bodies_of_nodes_have_mass_properties() {
    let with_option = |option: &str, cards: &str| {
        format!(
            "*SET_NODE_LIST\n6\n1,2,3,4\n*CONSTRAINED_NODAL_RIGID_BODY_{option}\n9,0,6\n{cards}"
        )
    };
    let body = |cards: &str| with_option("INERTIA", cards);
    let cards = "4.0,5.0,0.0,0.3\n9.0,0.5,0.0,8.0,0.25,7.0\n1.0,2.0,3.0,0.0,0.0,0.1\n";
    let model = with(&body(cards));
    let rigid = &model.job.rigid[0];
    assert_eq!(rigid.inertia, Some([9.0, 8.0, 7.0, 0.5, 0.25, 0.0]));
    let masses = &model.job.mass;
    let total: f64 = masses.iter().map(|m| m.mass).sum();
    let at = |name: &str| {
        let node = model.mesh.node_sets[name][0];
        model.mesh.nodes.iter().find(|n| n.id == node).expect("a node").x
    };
    let moment = |c: usize| masses.iter().map(|m| m.mass * at(&m.nodes)[c]).sum::<f64>();
    assert!((total - 0.3).abs() < 1e-12, "{total}");
    assert!((moment(0) / total - 4.0).abs() < 1e-9 && (moment(1) / total - 5.0).abs() < 1e-9);
    let start = &model.job.initial_velocity[0];
    assert_eq!(
        (start.velocity, start.spin, start.centre),
        ([1.0, 2.0, 3.0], [0.0, 0.0, 0.1], [4.0, 5.0, 0.0])
    );
    assert!(said(&model).contains("its mass is tm and the masses of its nodes"));

    let far = with(&body("40.0,5.0,0.0,0.3\n9.0,0,0,8.0,0,7.0\n0\n"));
    assert_eq!((far.job.mass.len(), far.job.mass[0].mass), (1, 0.3));
    assert!(said(&far).contains("which is not between its nodes"), "{}", said(&far));
    let cards = "1,7,7\n5.0,5.0,0.0,0.3\n9.0,0,0,8.0,0,7.0\n0\n";
    let held = with(&with_option("SPC_INERTIA", cards));
    assert_eq!((held.job.rigid[0].fixed.len(), held.job.mass.len()), (6, 4));
    let report = refused(&body("5.0,5.0,0.0,-0.3\n9.0,0,0,8.0,0,7.0\n0\n"));
    assert!(report.contains("`tm` is -0.3, it has to be above 0"), "{report}");
    let report = refused(&body("5.0,5.0,0.0,0.3,1\n9.0,0,0,8.0,0,7.0\n0\n1,0,0,0,1,0\n"));
    assert!(report.contains("inertia about local axes"), "{report}");
}

/// Sets of elements by options: the shells with loads.
#[test]
fn sets_of_elements_have_options() {
    let of = |lines: &str| {
        let set = format!("{RAMP}*SET_SHELL_GENERAL\n6\n{lines}*LOAD_SHELL_SET\n6,4,1.0\n");
        let model = with(&set);
        let faces = model.settings.loads.pressures.iter().flat_map(|p| p.faces.clone());
        let mut ids: Vec<u64> = faces.map(|face| face.0.0).collect();
        ids.sort_unstable();
        ids
    };
    assert_eq!(of("ALL\n"), [1, 2]);
    assert_eq!(of("PART,1\nDELEM,1\n"), [2]);
    assert_eq!(of("ELEM,1\n"), [1]);
    assert_eq!(of("BOX,3\n*DEFINE_BOX\n3,-1,11,-1,11,0,20\n"), [1]);
    assert!(refused("*SET_SHELL_GENERAL\n6\nVOL,1\n").contains("option VOL is not supported"));
}

/// Cards of one set with COLLECT are joined; an intersection has the nodes of all of its sets.
#[test]
fn sets_are_collected_and_intersected() {
    let lines = "*SET_NODE_LIST_COLLECT\n7\n1,2,3\n*SET_NODE_LIST_COLLECT_TITLE\nall\n7\n3,4\n\
                 *SET_NODE_LIST\n8\n3,4,5\n*SET_NODE_INTERSECT\n9\n7,8\n\
                 *SET_PART_LIST_COLLECT\n3\n1\n*SET_PART_LIST_COLLECT\n3\n2\n\
                 *SET_NODE_GENERAL\n10\nSET_PART,3\n";
    let model = with(lines);
    assert_eq!(set(&model, "set-7"), [1, 2, 3, 4]);
    assert_eq!(set(&model, "set-9"), [3, 4]);
    assert_eq!(set(&model, "set-10").len(), 14);
    assert!(refused("*SET_NODE_INTERSECT\n9\n7\n").contains("there is no *SET_NODE"));
}
