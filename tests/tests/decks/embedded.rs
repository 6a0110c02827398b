//! Beams in solids, whose nodes follow the solids. A bar of four solids along x, of 10 by 10 mm,
//! with a truss inside. Units mm, ms, kg.

use crate::base::{assert_refused, assert_same_when_written, model_of};
use crumple::input::job::Model;
use crumple_proto::ids::NodeId;
use crumple_proto::tie::Tie;
use crumple_tests::program::{crumple_with, run};
use crumple_tests::run_alone;
use std::fs;

/// Area [mm^2] and Young's modulus [GPa] of the truss.
const AREA: f64 = 4.0;
const STEEL: f64 = 210.0;
const CONCRETE: f64 = 30.0;

/// The bar of part 1 with solids 1 to 4, and trusses of part 2 with nodes 101 to 105 at y = 3,
/// z = 6, without a coupling. `more` are lines after it.
fn bar(more: &str) -> String {
    let mut nodes = String::new();
    for layer in 0..5 {
        for (k, [y, z]) in [[0, 0], [10, 0], [10, 10], [0, 10]].into_iter().enumerate() {
            nodes += &format!("{},{},{y},{z}\n", 4 * layer + k + 1, 10 * layer);
        }
    }
    for k in 0..5 {
        nodes += &format!("{},{},3.0,6.0\n", 101 + k, 2.5 + 8.0 * k as f64);
    }
    let solid = |k: usize| {
        let n: Vec<String> = (1..=8).map(|c| (4 * k + c).to_string()).collect();
        format!("{},1,{}\n", k + 1, n.join(","))
    };
    let solids: String = (0..4).map(solid).collect();
    let trusses: String =
        (0..4).map(|k| format!("{},2,{},{}\n", 11 + k, 101 + k, 102 + k)).collect();
    format!(
        "*KEYWORD\n*CONTROL_TERMINATION\n0.05\n*PART\nbar\n1,1,1\nsteel\n2,2,2\n\
         *SECTION_SOLID\n1,1\n*SECTION_BEAM\n2,3\n{AREA:?}\n\
         *MAT_ELASTIC\n1,2.4e-6,{CONCRETE:?},0.0\n*MAT_ELASTIC\n2,7.85e-6,{STEEL:?},0.3\n\
         *NODE\n{nodes}*ELEMENT_SOLID\n{solids}*ELEMENT_BEAM\n{trusses}{more}"
    )
}

/// One end is held, the other pulled by 0.1 mm in 0.05 ms.
const PULLED: &str = "*BOUNDARY_SPC_NODE\n1,0,1,1,1\n2,0,1,1,1\n3,0,1,1,1\n4,0,1,1,1\n\
    *SET_NODE_LIST\n9\n17,18,19,20\n*BOUNDARY_PRESCRIBED_MOTION_SET\n9,1,0,7\n\
    *DEFINE_CURVE\n7\n0,2\n10,2\n";
const COUPLED: &str = "*CONSTRAINED_BEAM_IN_SOLID_ID\n1,rebar\n2,1,1,1\n\n";

fn place(model: &Model, id: u64) -> usize {
    model.mesh.nodes.iter().position(|n| n.id == NodeId(id)).expect("a node")
}

/// Each node of the truss has the displacement of its solid at its place, and the energy is kept.
#[test]
fn nodes_of_beams_follow_their_solids() {
    let model = model_of(&bar(&format!("{PULLED}{COUPLED}")));
    let ties = &model.settings.ties;
    assert_eq!(ties.len(), 5);
    for tie in ties {
        let sum: f64 = tie.masters.iter().map(|m| m.1).sum();
        assert!((sum - 1.0).abs() < 1e-15 && tie.masters.len() == 8, "{tie:?}");
    }
    // At y = 3 and z = 6 of 10: 0.7 * 0.4 of the corners at 0, 0. At x = 2.5 of 10: 0.75 of these.
    let first = &ties.iter().find(|tie| tie.node == NodeId(101)).expect("a tie").masters;
    let of_corner = first.iter().find(|m| m.0 == NodeId(1)).expect("a master").1;
    assert!((of_corner - 0.75 * 0.7 * 0.4).abs() < 1e-14, "{of_corner}");

    let end = run_alone(&model, |_| {});
    let moved = |id: NodeId| {
        let n = end.nodes.id.iter().position(|of| *of == id).expect("a node");
        [0, 1, 2].map(|c| end.nodes.x[n][c] - end.nodes.x0[n][c])
    };
    for tie in ties {
        let own = moved(tie.node);
        for (c, own) in own.into_iter().enumerate() {
            let carried: f64 = tie.masters.iter().map(|&(id, n)| n * moved(id)[c]).sum();
            assert!((own - carried).abs() < 1e-13, "{tie:?}: {own} {carried}");
        }
    }
    assert!(moved(NodeId(105))[0] > 0.05, "the bar is pulled");
}

/// A truss along the whole axis of the bar, with nodes on the faces of its solids, makes all
/// sections stiffer and heavier alike: the amplitude of a given speed is that of the bar alone
/// times the root of mass over stiffness.
#[test]
fn a_coupled_truss_makes_a_bar_stiffer() {
    // A uniform extension; small steps, because the amplitude is the largest of all steps.
    let speeds: String = (1..5)
        .flat_map(|layer| (1..=4).map(move |k| (4 * layer + k, 10 * layer)))
        .chain((0..5).map(|k| (101 + k, 10 * k)))
        .map(|(node, x)| format!("{node},{:?}\n", 0.001 * x as f64))
        .collect();
    let held = "*BOUNDARY_SPC_NODE\n1,0,1,1,1\n2,0,1,1,1\n3,0,1,1,1\n4,0,1,1,1\n\
                *CONTROL_TIMESTEP\n0,0.1\n";
    let most = |coupling: &str| {
        let mut text = bar(&format!("{held}*INITIAL_VELOCITY_NODE\n{speeds}{coupling}"));
        for k in 0..5 {
            let old = format!("{},{},3.0,6.0\n", 101 + k, 2.5 + 8.0 * k as f64);
            text = text.replace(&old, &format!("{},{},5.0,5.0\n", 101 + k, 10 * k));
        }
        let model = model_of(&text);
        let tip = place(&model, 17);
        let mut most = 0.0f64;
        run_alone(&model, |e| most = most.max(e.nodes.x[tip][0] - e.nodes.x0[tip][0]));
        most
    };
    let (alone, coupled) = (most(""), most(COUPLED));
    let stiffness = 1.0 + STEEL * AREA / (CONCRETE * 100.0);
    let mass = 1.0 + 7.85e-6 * AREA / (2.4e-6 * 100.0);
    let expected = (mass / stiffness).sqrt();
    let ratio = coupled / alone;
    assert!((ratio / expected - 1.0).abs() < 1e-3, "{ratio} {expected}");
}

/// Decks that are written keep the coupling, and the older keyword gives the same.
#[test]
fn both_keywords_give_the_same() {
    let deck = bar(&format!("{PULLED}{COUPLED}"));
    assert_same_when_written(&deck, "end_time=0.02", "inside = true");
    let older = "*SET_PART_LIST\n4\n2\n*CONSTRAINED_LAGRANGE_IN_SOLID\n4,1,0,1,0,2,1\n\n";
    let [new, old] = [COUPLED, older].map(|coupling| model_of(&bar(coupling)).settings.ties);
    assert_eq!(new, old);
    let penalty = COUPLED.replace("_ID", "_PENALTY_ID");
    assert_eq!(model_of(&bar(&penalty)).settings.ties, new);
}

/// Bars in two parts, each with a card: every node is tied to the solid around it, also on a plane
/// of symmetry. Any number of workers gives the same bits.
#[test]
fn beams_pass_through_several_parts() {
    let split = bar("").replace("\n3,1,9,", "\n3,3,9,").replace("\n4,1,13,", "\n4,3,13,");
    let split = split.replace("steel\n2,2,2\n", "steel\n2,2,2\nother\n3,1,1\n");
    let cards = "*CONSTRAINED_BEAM_IN_SOLID\n2,1,1,1\n\n2,3,1,1\n\n";
    let text = format!("{split}{PULLED}{cards}");
    let model = model_of(&text);
    let first_master = |tie: &Tie| tie.masters[0].0.0;
    let ties = &model.settings.ties;
    assert_eq!(ties.iter().map(first_master).collect::<Vec<_>>(), [1, 5, 5, 9, 13]);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bar.k");
    fs::write(&path, format!("{text}*END\n")).unwrap();
    let digest = |workers: &str| {
        let deck = path.to_str().unwrap();
        let fields = ["--set", "output.field_interval=-1"];
        let args = [&["run", deck, "--workers", workers, "--no-report"][..], &fields].concat();
        run(crumple_with(&args)).with_code(0).digest()
    };
    assert_eq!(digest("1"), digest("3"));

    let mut plane = text.replace(",3.0,6.0\n", ",1e-7,6.0\n");
    // The corners with y = 0 are the first and the fourth of each layer.
    let on_plane = |id: u64| id % 4 <= 1;
    for id in (5..=20).filter(|id| on_plane(*id)).chain(101..=105) {
        plane += &format!("*BOUNDARY_SPC_NODE\n{id},0,0,1,0\n");
    }
    let ties = model_of(&plane).settings.ties;
    let masters = || ties.iter().flat_map(|tie| &tie.masters);
    assert!(ties.len() == 5 && masters().all(|(id, _)| on_plane(id.0)), "{ties:?}");
}

/// A node outside of the solids is not tied and is named; nothing inside is an error, and so are
/// fields without a meaning here.
#[test]
fn what_cannot_be_coupled_is_named() {
    let outside = bar(COUPLED).replace("105,34.5,3.0,6.0", "105,34.5,3.0,10.5");
    let model = model_of(&outside);
    assert_eq!(model.settings.ties.len(), 4);
    let words = "1 of 5 nodes are not in a solid of its parts and it does not tie them: 105";
    assert!(model.warnings.iter().any(|w| w.message.contains(words)), "{:?}", model.warnings);
    let away = bar(COUPLED).replace(",3.0,6.0\n", ",3.0,16.0\n");
    assert_refused(&away, &["rebar", "none of its 5 nodes is in a solid of its parts"]);
    let refused = |card: &str, words: &str| {
        assert_refused(&bar(&format!("*CONSTRAINED_BEAM_IN_SOLID\n{card}")), &[words]);
    };
    refused("2,1,1,1,0,0,0,1\n\n", "slide along their axis");
    refused("2,1,1,1\n0,0,0,5\n", "a bond that fails");
    refused("2,1,1,1\n0.01,0\n", "begin or end within the run");
    refused("2,7,1,1\n\n", "there is no *PART with the id 7");
    let fluid = "*CONSTRAINED_LAGRANGE_IN_SOLID\n2,1,1,1,0,4\n\n";
    assert_refused(&bar(fluid), &["a coupling to fluids"]);
}
