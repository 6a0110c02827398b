//! Rigid bodies of nodes: constraints of their nodes, nodes without elements, directions of springs
//! that follow them. Units mm, ms, kg.

use super::base::{BASE, MOVES, STEEL, assert_refused, with};
use super::fates::said;
use crumple::input::job::Model;

/// A body of an end of the plate: nodes 13 and 16, 10 mm apart along y.
const BODY: &str = "*SET_NODE_LIST\n5\n13,16\n*CONSTRAINED_NODAL_RIGID_BODY\n7,0,5\n";

fn fixed(model: &Model) -> Vec<&str> {
    model.job.rigid[0].fixed.iter().map(String::as_str).collect()
}

/// Constraints fix the body where they mean the same for it: those of a node that cannot turn, of
/// all nodes, of pnode. Those of a node about which the body can turn are refused.
#[test]
fn constraints_of_nodes_hold_their_body() {
    let one = format!("{BODY}*BOUNDARY_SPC_NODE\n13,0,0,1,1,1,1,1\n");
    let model = with(&one);
    assert_eq!(fixed(&model), ["rx", "ry", "rz", "y", "z"]);
    assert!(model.job.fix.is_empty(), "{:?}", model.job.fix);
    let words = "the body is fixed: rx, ry, rz, y, z";
    assert!(said(&model).contains(words), "{}", said(&model));
    // Node 13 cannot move along z if the body does not turn about x and y.
    let enough = format!("{BODY}*BOUNDARY_SPC_NODE\n13,0,0,0,1,1,1,0\n");
    assert_eq!(fixed(&with(&enough)), ["rx", "ry", "z"]);
    // The rest of the set stays fixed.
    let more = format!("{BODY}*SET_NODE_LIST\n6\n13,11\n*BOUNDARY_SPC_SET\n6,0,0,0,1,1,1,0\n");
    let model = with(&more);
    assert_eq!(fixed(&model), ["rx", "ry", "z"]);
    let left: Vec<u64> = model.mesh.node_sets["set-6-deformable"].iter().map(|n| n.0).collect();
    assert_eq!(left, [11]);
    // All nodes along z: the body does not turn about x, either.
    let all = format!("{BODY}*BOUNDARY_SPC_SET\n5,0,0,0,1\n");
    assert_eq!(fixed(&with(&all)), ["rx", "z"]);
    // pnode is the centre of the body.
    let centre = "*NODE\n20,20,5,12\n*SET_NODE_LIST\n5\n13,16\n\
                  *CONSTRAINED_NODAL_RIGID_BODY\n7,0,5,20\n*BOUNDARY_SPC_NODE\n20,0,0,1,1\n";
    let model = with(centre);
    assert_eq!(fixed(&model), ["y", "z"]);
    assert!(!said(&model).contains("belongs to no element"), "{}", said(&model));
    let hinge = format!("{BASE}{STEEL}{MOVES}{BODY}*BOUNDARY_SPC_NODE\n13,0,0,0,1\n");
    assert_refused(&hinge, &["1 nodes of rigid body `body-7` have another constraint"]);
}

/// Nodes of bodies that no element has follow them: there is no report of them, and directions of
/// springs may follow them.
#[test]
fn nodes_without_elements_follow_their_body() {
    let nodes = "*NODE\n21,0,0,-5\n22,10,0,-5\n23,50,0,0\n24,60,0,0\n25,0,0,-9\n";
    let base = BASE.replace("cube\n2,2,1\n", "cube\n2,2,2\n");
    let text = format!(
        "{base}{STEEL}{MOVES}{nodes}*MAT_RIGID\n2,7.85e-6,207.0,0.3\n*SET_NODE_LIST\n9\n21,22,25\n\
         *CONSTRAINED_EXTRA_NODES_SET\n2,9\n*PART\nspring\n3,3,3\n*SECTION_DISCRETE\n3\n\n\
         *MAT_SPRING_ELASTIC\n3,1.0\n*ELEMENT_DISCRETE\n1,3,23,24,8\n\
         *DEFINE_SD_ORIENTATION\n8,2,0,0,0,21,22\n*ELEMENT_MASS\n1,23,0.1\n2,24,0.1\n"
    );
    let model = super::base::model_of(&text);
    let ids: Vec<u64> = model.mesh.nodes.iter().map(|n| n.id.0).collect();
    assert!(ids.contains(&21) && ids.contains(&22) && !ids.contains(&25), "{ids:?}");
    let all = said(&model);
    assert!(all.contains("springs without force connect them"), "{all}");
    assert!(!all.contains("belong to no element") && !all.contains("belongs to no"), "{all}");
    let loose = text.replace("*CONSTRAINED_EXTRA_NODES_SET\n2,9\n", "");
    assert_refused(&loose, &["the direction of its springs follows node 21"]);
}

/// Masses of extra nodes are reported next to those of a card of inertia, springs without mass are
/// not.
#[test]
fn extra_nodes_without_mass_are_no_addition() {
    let base = BASE.replace("cube\n2,2,1\n", "");
    let inertia = "*MAT_RIGID\n2,7.85e-6,207.0,0.3\n*PART_INERTIA\ncube\n2,2,2\n\
                   5.0,5.0,5.0,0.02\n0.5,0.0,0.0,0.5,0.0,0.5\n0.0,0.0,0.0\n";
    let spring = "*NODE\n21,0,0,-5\n22,0,0,-9\n*CONSTRAINED_EXTRA_NODES_NODE\n2,21\n\
                  *PART\nspring\n3,3,3\n*SECTION_DISCRETE\n3\n\n*MAT_SPRING_ELASTIC\n3,1.0\n\
                  *ELEMENT_DISCRETE\n1,3,21,22\n*ELEMENT_MASS\n1,22,0.1\n";
    let of = |lines: &str| {
        let text = format!("{base}{STEEL}{MOVES}{inertia}{spring}{lines}");
        said(&super::base::model_of(&text))
    };
    let words = "masses of nodes of other parts in the body (1) are added to tm";
    assert!(!of("").contains("are added to tm"), "{}", of(""));
    assert!(of("*ELEMENT_MASS\n2,21,0.1\n").contains(words));
}
