//! Nodes of rigid bodies that belong to no element, and inertias of nodes. Units mm, ms, kg.

use crate::base::{BASE, MOVES, STEEL, assert_refused, assert_same_when_written, model_of, with};
use crumple::input::job::Model;
use crumple_proto::ids::NodeId;
use crumple_tests::run_alone;

/// A body of an end of the plate and of node 20, which no element has, 28 mm above it.
const BODY: &str = "*NODE\n20,20.0,5.0,40.0\n*SET_NODE_LIST\n5\n13,16,20\n\
    *CONSTRAINED_NODAL_RIGID_BODY\n7,0,5\n";
const MASS: &str = "*ELEMENT_MASS\n1,20,0.5\n";
const INERTIA: &str = "*ELEMENT_INERTIA\n1,20,0\n2.0,0.1,0.3,3.0,0.2,4.0\n";

fn mass_of(model: &Model, node: u64) -> f64 {
    let at = model.mesh.nodes.iter().position(|n| n.id == NodeId(node)).expect("a node");
    model.nodes.added_mass[at]
}

/// The mass of a node without elements acts at its place, its inertia about it.
#[test]
fn a_node_without_elements_carries_mass_and_inertia() {
    let own = "*CONTROL_TERMINATION\n0.001\n";
    let end = |lines: &str| run_alone(&with(&format!("{BODY}{MASS}{lines}{own}")), |_| {});
    let [without, with_inertia] = ["", INERTIA].map(|lines| {
        let end = end(lines);
        let body = &end.constraints.bodies.bodies[0];
        (body.mass, body.centre, body.inertia)
    });
    assert_eq!(without.0, with_inertia.0);
    // The quarters of two nodes of a shell: 10 by 10 by 1 mm.
    let ends = 2.0 * 0.25 * 7.85e-6 * 100.0;
    assert!((without.0 - 0.5 - ends).abs() < 1e-12, "{}", without.0);
    let height = (12.0 * ends + 40.0 * 0.5) / (0.5 + ends);
    assert!((without.1.z - height).abs() < 1e-9, "{}", without.1);
    let added = with_inertia.2 - without.2;
    let given = [[2.0, 0.1, 0.3], [0.1, 3.0, 0.2], [0.3, 0.2, 4.0]];
    for (r, row) in given.iter().enumerate() {
        for (c, moment) in row.iter().enumerate() {
            assert!((added[(r, c)] - moment).abs() < 1e-9, "{added}");
        }
    }
}

/// A history of such a node is recorded, and a moment on it turns the body by M/J.
#[test]
fn a_node_without_elements_moves_with_its_body() {
    let lines = "*DATABASE_HISTORY_NODE\n20\n*LOAD_NODE_POINT\n20,7,3,0.6\n\
                 *DEFINE_CURVE\n3\n0,1\n10,1\n*CONTROL_TERMINATION\n0.1\n";
    // The body alone: without a shell at its nodes, these carry masses, too.
    let shells = "1,1,11,12,15,14\n2,1,12,13,16,15\n";
    let base = BASE.replace(shells, "1,1,11,12,15,14\n");
    let masses = "*ELEMENT_MASS\n2,13,0.1\n3,16,0.1\n*DATABASE_HISTORY_NODE\n13\n";
    let text = format!("{base}{STEEL}{MOVES}{BODY}{MASS}{INERTIA}{masses}{lines}");
    let model = model_of(&text);
    assert_eq!(mass_of(&model, 20), 0.5);
    let histories = &model.settings.histories.nodes;
    let found = histories.iter().any(|node| node.nodes.contains(&NodeId(20)));
    assert!(found, "{histories:?}");
    let end = run_alone(&model, |_| {});
    let body = &end.constraints.bodies.bodies[0];
    let time = end.clock.time - 0.5 * end.clock.last_dt;
    // About its centre; small angles.
    let expected = body.inertia.try_inverse().expect("an inertia").column(2) * (0.6 * time);
    assert!((body.last_spin - expected).norm() < 1e-4 * expected.norm(), "{}", body.last_spin);
}

/// Decks that are written have the inertias of the nodes of two bodies, one of which has an inertia
/// of its own.
#[test]
fn inertias_of_nodes_are_written_to_decks() {
    let rigid = BASE.replace("cube\n2,2,1\n", "");
    let cube = "*MAT_RIGID\n2,7.85e-6,207.0,0.3\n*PART_INERTIA\ncube\n2,2,2\n\
                5.0,5.0,5.0,0.02\n0.5,0.0,0.0,0.5,0.0,0.5\n0.0,0.0,0.0\n\
                *ELEMENT_INERTIA\n2,3\n0.1,0,0,0.2,0,0.3\n";
    let deck = format!("{rigid}{STEEL}{MOVES}{cube}{BODY}{MASS}{INERTIA}");
    assert_same_when_written(&deck, "end_time=0.02", "*ELEMENT_INERTIA");
    let end = run_alone(&model_of(&deck.replace("\n10.0\n", "\n0.001\n")), |_| {});
    let body = end.constraints.bodies.bodies.iter().find(|body| body.mass == 0.02);
    let moments = body.expect("the cube").inertia.diagonal();
    assert!((moments - nalgebra::Vector3::new(0.6, 0.7, 0.8)).norm() < 1e-12, "{moments}");
}

/// Inertias that the engine does not have are errors at their lines.
#[test]
fn inertias_without_a_body_are_refused() {
    let deck = |card: &str| format!("{BASE}{STEEL}{MOVES}*ELEMENT_INERTIA\n{card}");
    let numbers = "1.0,0,0,1.0,0,1.0\n";
    assert_refused(&deck(&format!("1,12\n{numbers}")), &["node 12 belongs to no rigid body"]);
    let local = format!("1,12,3\n{numbers}");
    assert_refused(&deck(&local), &["inertia about local axes"]);
    let body = format!("{BASE}{STEEL}{MOVES}{BODY}{MASS}");
    let wrong = "*ELEMENT_INERTIA\n1,20\n1.0,0,0,1.0,0,5.0\n";
    assert_refused(&format!("{body}{wrong}"), &["no distribution of mass", "added_inertia"]);
}
