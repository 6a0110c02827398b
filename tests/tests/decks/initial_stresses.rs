//! `*INITIAL_STRESS_SHELL` and `*INITIAL_STRESS_SOLID`, as in `dynain` files. Units mm, ms, kg.

use super::base::{
    BASE, MOVES, STEEL, assert_refused, assert_same_when_written, model_of, read_with, with,
};
use super::fates::said;
use crumple::input::job::{Model, read};
use crumple_proto::ids::ElemId;
use crumple_proto::initial::of_element;
use crumple_tests::{run_alone, run_side_by_side};
use crumple_worker::math::row::xyz;
use std::fs;

/// Bending and tension along x of shell 1 at two points, and its plastic strain.
const BENT: &str = "*INITIAL_STRESS_SHELL\n1,1,2\n\
                    -0.5,-0.1,0,0,0,0,0,0.02\n0.5,0.3,0,0,0,0,0,0.01\n";
/// Holds all nodes.
const HELD: &str = "*SET_NODE_GENERAL\n99\nALL\n*BOUNDARY_SPC_SET\n99,0,1,1,1,1,1,1\n";
const FLOWS: &str = "*MAT_PLASTIC_KINEMATIC\n1,7.85e-6,207.0,0.3,0.6,1.0\n";

/// Returns the stress and the plastic strain of the points of an element after some steps at rest.
fn points_at_rest(model: &Model, element: u64) -> Vec<([f64; 6], f64)> {
    let mut found = Vec::new();
    run_alone(model, |e| {
        for b in &e.blocks.blocks {
            for i in 0..b.count {
                let local = &e.blocks.elements[b.first + i];
                if local.record.id.label() == element {
                    let x = local.nodes.map(|n| xyz(&e.nodes.x[n as usize]));
                    let points = b.element.points(b.state(i), &x);
                    found = points.iter().map(|p| (p.stress, p.plastic_strain)).collect();
                }
            }
        }
    });
    found
}

/// A `dynain` file with thicknesses and stresses in both formats, with history, is included; the
/// points of the job are those of the cards.
#[test]
fn dynain_files_run() {
    let large = "$#     eid    nplane    nthick     nhisv    ntensr     large\n\
        \u{20}        2         1         1         6         0         1\n\
        \u{20}            0.0             0.1             0.2             0.0           -0.05\n\
        \u{20}          0.003           0.004            0.15\n\
        \u{20}            1.0             2.0             0.0             0.0             0.0\n\
        \u{20}            0.0\n";
    let dynain = format!(
        "*KEYWORD\n*ELEMENT_SHELL_THICKNESS\n1,1,11,12,15,14\n0.8,0.8,0.8,0.8\n\
         2,1,12,13,16,15\n0.9,0.9,0.9,0.9\n{BENT}{large}*INITIAL_STRAIN_SHELL\n1,1,2\n\
         0.0,0.0,0.0,0.0,0.0,0.0,-1.0\n0.0,0.0,0.0,0.0,0.0,0.0,1.0\n*END\n"
    );
    let (before, after) = BASE.split_once("*ELEMENT_SHELL\n").expect("shells");
    let solids = after.split_once("*ELEMENT_SOLID").expect("solids").1;
    let deck = format!("{before}*ELEMENT_SOLID{solids}{FLOWS}*INCLUDE\ndynain\n{HELD}*END\n");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("dynain"), dynain).unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, deck).unwrap();
    let sets = ["end_time=0.01".to_string()];
    let model = read(&path, &sets).unwrap_or_else(|report| panic!("{report}"));
    let [inner, outer] = of_element(&model.mesh.initial, ElemId(1)) else { panic!("two points") };
    assert_eq!((inner.position, inner.stress[0], inner.plastic_strain), (-0.5, -0.1, 0.02));
    assert_eq!((outer.position, outer.stress[0], outer.plastic_strain), (0.5, 0.3, 0.01));
    let [one] = of_element(&model.mesh.initial, ElemId(2)) else { panic!("one point") };
    assert_eq!(one.stress, [0.1, 0.2, 0.0, -0.05, 0.003, 0.004]);
    assert_eq!(one.plastic_strain, 0.15);
    let all = said(&model);
    for words in [
        "up to 2 history variables of a point are not 0",
        "*INITIAL_STRAIN_SHELL is not read",
        "given at 2 points through the thickness, and its shells have 3",
    ] {
        assert!(all.contains(words), "{words}: {all}");
    }
    let points = points_at_rest(&model, 2);
    assert_eq!(points.len(), 3);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    for (stress, strain) in points {
        for (got, given) in stress.into_iter().zip(one.stress) {
            near(got, given);
        }
        near(strain, 0.15);
    }
}

/// Stresses turn with their file and have its units; a mirror exchanges the corners 2 and 4, and so
/// the points at them. The points of a plane may follow each other, or those through the thickness.
#[test]
fn stresses_turn_with_their_file() {
    let shell = "*NODE\n101,0,0,0\n102,10,0,0\n103,10,10,0\n104,0,10,0\n\
                 *ELEMENT_SHELL\n101,1,101,102,103,104\n";
    let by_layer = "-0.5,1\n-0.5,2\n-0.5,3\n-0.5,4\n0.5,5\n0.5,6\n0.5,7\n0.5,8\n";
    let by_plane = "-0.5,1\n0.5,5\n-0.5,2\n0.5,6\n-0.5,3\n0.5,7\n-0.5,4\n0.5,8\n";
    for (transformation, component, order) in
        [("ROTATE,0,0,1,0,0,0,90", 1, [1, 2, 3, 4]), ("MIRROR,0,0,0,1,0,0", 0, [1, 4, 3, 2])]
    {
        for points in [by_layer, by_plane] {
            let folder = tempfile::tempdir().unwrap();
            let part = format!("*KEYWORD\n{shell}*INITIAL_STRESS_SHELL\n101,4,2\n{points}*END\n");
            fs::write(folder.path().join("part.k"), part).unwrap();
            let path = folder.path().join("deck.k");
            let main = format!(
                "{BASE}{FLOWS}*DEFINE_TRANSFORMATION\n7\n{transformation}\n\
                 *INCLUDE_TRANSFORM\npart.k\n0,0,0,0,0,0,0\n0\n1000,1,1\n7\n*END\n"
            );
            fs::write(&path, main).unwrap();
            let model = read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
            let found = of_element(&model.mesh.initial, ElemId(101));
            assert_eq!(found.len(), 8);
            for point in found {
                let written = order[point.number as usize - 1];
                let layer = if point.position < 0.0 { 0 } else { 4 };
                let expected = 1000.0 * f64::from(written + layer);
                assert!((point.stress[component] / expected - 1.0).abs() < 1e-12, "{point:?}");
                let others = (0..6).filter(|&c| c != component);
                assert!(others.map(|c| point.stress[c].abs()).fold(0.0, f64::max) < 1e-9);
            }
        }
    }
}

/// Between and beyond the given points the stress is linear, the plastic strain constant beyond
/// them: at Gauss points at -sqrt(0.6), 0 and sqrt(0.6).
#[test]
fn stresses_are_linear_through_the_thickness() {
    let base = BASE.replacen("10.0", "0.01", 1);
    let model = model_of(&format!("{base}{FLOWS}{BENT}{HELD}"));
    let z = 0.6f64.sqrt();
    for ((stress, strain), (at, plastic)) in
        points_at_rest(&model, 1).into_iter().zip([(-z, 0.02), (0.0, 0.015), (z, 0.01)])
    {
        assert!((stress[0] - (0.1 + 0.4 * at)).abs() < 1e-12, "{stress:?}");
        assert!((strain - plastic).abs() < 1e-12, "{strain}");
    }
    // A set of shells.
    let set = BENT.replace("_SHELL\n1,", "_SHELL_SET\n7,") + "*SET_SHELL_LIST\n7\n1,2\n";
    let model = model_of(&format!("{BASE}{FLOWS}{set}{HELD}"));
    assert_eq!(model.mesh.initial.len(), 4);
}

/// A solid has the mean of its points.
#[test]
fn solids_have_the_mean_of_their_points() {
    let points: String = (0..8).map(|k| format!("0.{k},0,0,0,0.02,0,0.1\n")).collect();
    let lines = format!("*INITIAL_STRESS_SOLID\n1,8\n{points}{HELD}");
    let base = BASE.replacen("10.0", "0.01", 1);
    let model = model_of(&format!("{base}{FLOWS}{lines}"));
    // The ids of solids are raised, since shells have the same ones.
    let id = model.mesh.initial[0].element.label();
    let [(stress, strain)] = points_at_rest(&model, id)[..] else { panic!("one point") };
    for (got, mean) in stress.into_iter().zip([0.35, 0.0, 0.0, 0.0, 0.02, 0.0]) {
        assert!((got - mean).abs() < 1e-12, "{stress:?}");
    }
    assert!((strain - 0.1).abs() < 1e-12, "{strain}");
    assert!(said(&model).contains("the mean of the points of a solid"));
}

/// A bar with tension along it at the start becomes shorter by the strain S/E. Its damping is that
/// of its slowest vibration.
#[test]
fn a_tensioned_bar_shortens_by_its_stress_over_its_modulus() {
    const S: f64 = 0.207;
    let mut deck = "*KEYWORD\n*CONTROL_TERMINATION\n0.25\n*PART\nbar\n1,1,1\n*SECTION_SHELL\n\
                    1,2,1.0,3\n1.0\n*DAMPING_GLOBAL\n0,200.0\n*NODE\n"
        .to_string();
    for i in 0..5 {
        for j in 0..2 {
            deck += &format!("{},{},{},0\n", 1 + 2 * i + j, 10 * i, 5 * j);
        }
    }
    deck += "*ELEMENT_SHELL\n";
    (0..4).for_each(|i| {
        let n = 1 + 2 * i;
        deck += &format!("{},1,{n},{},{},{}\n", i + 1, n + 2, n + 3, n + 1);
    });
    deck += STEEL;
    deck += "*INITIAL_STRESS_SHELL\n";
    (1..5).for_each(|e| deck += &format!("{e}\n0,{S},0,0,0,0,0,0\n"));
    deck += "*BOUNDARY_SPC_NODE\n1,0,1,0,1,0,0,0\n2,0,1,0,1,0,0,0\n";
    let model = model_of(&deck);
    let end = run_alone(&model, |_| ());
    let at = end.nodes.id.iter().position(|id| id.label() == 9).expect("node 9");
    let strain = end.nodes.x[at][0] / 40.0 - 1.0;
    let exact = -S / 207.0;
    assert!((strain / exact - 1.0).abs() < 1e-2, "1 % of the vibration is left: {strain} {exact}");
    let one = run_side_by_side(&model, 1, 20, 0).digest();
    assert_eq!(run_side_by_side(&model, 3, 20, 7).digest(), one);
}

/// Laws that compute their stress from the whole deformation take none: the report names part and
/// law; if that is allowed, a warning does.
#[test]
fn laws_of_the_whole_deformation_take_no_stress() {
    let rubber = "*MAT_MOONEY-RIVLIN_RUBBER\n1,1.1e-6,0.49,0.001,0.0005\n";
    let deck = format!("{BASE}{rubber}{MOVES}{BENT}");
    assert_refused(
        &deck,
        &["part 1 (plate)", "`mooney_rivlin`", "does not take", "the first is 1"],
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{deck}*END\n")).unwrap();
    let model = read(&path, &["mesh.allow_unsupported=true".to_string()]);
    let all = said(&model.unwrap_or_else(|report| panic!("{report}")));
    assert!(all.contains("does not take"), "{all}");
    let elastic = said(&with(BENT));
    assert!(elastic.contains("the law `elastic` has none"), "{elastic}");
}

/// Rigid parts have no stress: those of a card are named.
#[test]
fn stresses_of_rigid_parts_are_reported() {
    let rigid = BASE.replace("cube\n2,2,1\n", "cube\n2,2,2\n");
    let stress = "*INITIAL_STRESS_SOLID\n1\n0.1\n*INITIAL_STRESS_SHELL\n1,1,1\n0,0.1\n";
    let steel = "*MAT_RIGID\n2,7.85e-6,207.0,0.3\n";
    let model = model_of(&format!("{rigid}{STEEL}{steel}{MOVES}{stress}"));
    assert!(said(&model).contains("the stresses of part 2 have no effect, since it is rigid"));
    assert!(!said(&model).contains("the stresses of part 1"));
}

/// Cards that are wrong are named with the element.
#[test]
fn wrong_stresses_are_named() {
    let base = format!("{BASE}{STEEL}{MOVES}");
    for (lines, words) in [
        ("_SHELL\n77\n0,0.1\n", "there is no shell with the id 77"),
        ("_SHELL\n1,1,2\n0,0.1\n", "ends before the points of element 1"),
        ("_SHELL\n1,1,2\n0,0.1\n0,0.2\n", "has 2 points at one place"),
        ("_SHELL\n1\n1.5,0.1\n", "a position outside of the thickness"),
        ("_SHELL\n1\n0,0,0,0,0,0,0,-0.1\n", "a plastic strain below 0"),
        ("_SHELL\n1,1,1,0,6\n0,0.1\n0\n", "has `ntensr`"),
        ("_SOLID\n1,1,1,1,1\n0\n0\n0\n", "has `iveflg`"),
        ("_SHELL_SET\n5\n0,0.1\n", "there is no *SET_SHELL"),
    ] {
        assert_refused(&format!("{base}*INITIAL_STRESS{lines}"), &[words]);
    }
    let zero = "mesh.stresses=[[1,1,0,0.1,0,0,0,0,0,0]]";
    assert_eq!(read_with(&[zero], "").mesh.initial[0].stress[0], 0.1);
}

/// A deck that is written from a job with stresses gives the same bits.
#[test]
fn written_stresses_give_the_same_bits() {
    // Small stresses: nothing balances them, and with the first step the fastest vibrations begin.
    let stresses = "*INITIAL_STRESS_SHELL\n1,1,2\n-0.5,-0.001,0,0,0,0,0,0.02\n\
                    0.5,0.003,0,0,0,0,0,0.01\n\
                    *INITIAL_STRESS_SOLID\n1\n0.001,0.0002,0,0.0001,0,0,0.3\n";
    let deck = format!("{BASE}{FLOWS}{MOVES}{stresses}");
    assert_same_when_written(&deck, "end_time=0.1", "*INITIAL_STRESS_SOLID");
}
