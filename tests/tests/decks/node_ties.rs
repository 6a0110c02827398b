//! Equations between displacements of nodes, coincident nodes, and shells on solids. Units mm, ms,
//! kg.

use super::base::{BASE, MOVES, STEEL, assert_refused, with};
use super::fates::said;
use crumple::input::job::Model;

fn equation(keyword: &str, lines: &str) -> String {
    format!("*CONSTRAINED_LINEAR_{keyword}\n1\n{lines}")
}

/// Returns the equations that let two nodes have these degrees of freedom in common.
fn equal(a: u64, b: u64, dofs: &[u64]) -> String {
    dofs.iter().map(|dof| equation("GLOBAL", &format!("{a},{dof},1.0\n{b},{dof},-1.0\n"))).collect()
}

/// Returns the nodes of a set.
fn set(model: &Model, name: &str) -> Vec<u64> {
    model.mesh.node_sets[name].iter().map(|id| id.label()).collect()
}

/// Equal displacements are a tie; a chain follows its first node. One term holds a node.
#[test]
fn equations_of_equal_displacements_are_ties() {
    let chain = equal(12, 5, &[1, 2, 3]) + &equal(5, 6, &[1, 2, 3]);
    let model = with(&format!("{chain}{}", equation("GLOBAL", "16,3,2.0\n")));
    let [tie] = &model.job.tie[..] else { panic!("one tie: {:?}", model.job.tie) };
    assert_eq!((tie.node, tie.rotations), (Some(5), false));
    assert_eq!(set(&model, &tie.nodes), [6, 12]);
    let [fix] = &model.job.fix[..] else { panic!("one fix") };
    assert_eq!((set(&model, &fix.nodes), fix.dofs.len()), (vec![16], 1));
    let turning = with(&equal(11, 12, &[1, 2, 3, 4, 5, 6]));
    assert!(turning.job.tie[0].rotations);
    // Along the axes of one system.
    let local: String = (1..=3)
        .map(|dof| equation("LOCAL", &format!("11,{dof},3,1.0\n12,{dof},3,-1.0\n")))
        .collect();
    let system = "*DEFINE_COORDINATE_SYSTEM\n3,0,0,0,0,1,0\n-1,0,0\n";
    assert_eq!(with(&format!("{system}{local}")).job.tie.len(), 1);
}

/// All other equations are refused, each with the reason.
#[test]
fn other_equations_are_refused() {
    let base = format!("{BASE}{STEEL}{MOVES}");
    let three = equation("GLOBAL", "11,1,1.0\n12,1,-1.0\n13,1,-1.0\n");
    for (lines, words) in [
        (equal(11, 12, &[1, 3]), "have only x, z in common"),
        (equal(11, 12, &[1, 2, 3, 4]), "with all rotations or none"),
        (three, "if it holds one node"),
        (equation("GLOBAL", "11,8,1.0\n"), "a term has `dof` 8"),
    ] {
        assert_refused(&format!("{base}{lines}"), &[words]);
    }
}

/// Coincident nodes of a set are tied, those of shells with rotations; ties that fail are refused.
#[test]
fn coincident_nodes_are_tied() {
    let more = "*PART\nmore\n3,1,1\n*NODE\n21,20,0,12\n22,30,0,12\n23,30,10,12\n24,20,10,12\n\
                *ELEMENT_SHELL\n11,3,21,22,23,24\n*SET_NODE_LIST\n9\n13,16,21,24,22\n";
    let model = with(&format!("{more}*CONSTRAINED_TIED_NODES_FAILURE\n9,0.0,0\n"));
    let ties: Vec<_> = model
        .job
        .tie
        .iter()
        .map(|tie| (tie.node, set(&model, &tie.nodes), tie.rotations))
        .collect();
    assert_eq!(ties.len(), 2);
    for pair in [(Some(13), vec![21], true), (Some(16), vec![24], true)] {
        assert!(ties.contains(&pair), "{ties:?}");
    }
    assert!(said(&model).contains("2 nodes tied to others at their places"));
    // A node of two sets joins their groups; one without another at its place is a warning.
    let third = "*NODE\n31,20,0,12\n32,20,-10,12\n33,10,-10,12\n34,10,0,12\n\
                 *ELEMENT_SHELL\n12,3,31,34,33,32\n*SET_NODE_LIST\n8\n21,31,33\n";
    let cards = "*CONSTRAINED_TIED_NODES_FAILURE\n9,0.0,0\n*CONSTRAINED_TIED_NODES_FAILURE\n8\n";
    let model = with(&format!("{more}{third}{cards}"));
    let of_13 = model.job.tie.iter().find(|tie| tie.node == Some(13)).expect("a tie");
    assert_eq!(set(&model, &of_13.nodes), [21, 31]);
    assert!(said(&model).contains("1 of its nodes have no other one"));
    let fails = format!("{BASE}{STEEL}{MOVES}{more}*CONSTRAINED_TIED_NODES_FAILURE\n9,0.1\n");
    assert_refused(&fails, &["`eppf` = 0.1", "fail by the plastic strain"]);
}

/// A node of a shell and the nodes of solids along its fibre are a rigid body.
#[test]
fn shells_on_solids_are_rigid_bodies() {
    let lines = "*SET_NODE_LIST\n9\n5,1\n*CONSTRAINED_SHELL_TO_SOLID\n11,9\n";
    let model = with(lines);
    let [body] = &model.job.rigid[..] else { panic!("one body") };
    assert_eq!(set(&model, body.nodes.as_deref().expect("a set")), [1, 5, 11]);
    assert!(said(&model).contains("keeps its length"));
}
