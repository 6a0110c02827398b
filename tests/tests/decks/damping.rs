//! Damping in proportion to mass, `*DAMPING_PART_MASS` and `*DAMPING_GLOBAL`: free cubes and rigid
//! bodies become slower by the exponential of its integral. Units mm, ms, kg, so kN and J.

use crate::base::{BASE, assert_refused, assert_same_when_written, model_of, refused, with};
use crumple_proto::ids::NodeId;
use crumple_tests::{run_alone, run_side_by_side};
use crumple_worker::engine::Engine;

const VELOCITY: f64 = 2.0;
/// Damping [1/ms], and the end of the run [ms].
const ALPHA: f64 = 3.0;
const END: f64 = 0.5;
/// Mass of a cube of side 10 [kg].
const MASS: f64 = 7.85e-6 * 1000.0;

/// Returns a deck of two cubes that share a face, parts 1 and 2, which move along x; the curve 9 is
/// 1, the curve 8 grows from 0 to 1 at the end.
fn cubes(material: &str, lines: &str) -> String {
    let nodes: String = (0..3)
        .flat_map(|i| [(0, 0), (10, 0), (10, 10), (0, 10)].map(move |(y, z)| (10 * i, y, z)))
        .zip(1..)
        .map(|((x, y, z), id)| format!("{id},{x},{y},{z}\n"))
        .collect();
    format!(
        "*KEYWORD\n*CONTROL_TERMINATION\n{END}\n*PART\nfirst\n1,1,1\n*PART\nsecond\n2,1,1\n\
         *SECTION_SOLID\n1,1\n{material}*NODE\n{nodes}*ELEMENT_SOLID\n1,1,1,5,6,2,4,8,7,3\n\
         2,2,5,9,10,6,8,12,11,7\n*INITIAL_VELOCITY\n0\n{VELOCITY}\n\
         *DEFINE_CURVE\n9\n0,1\n1,1\n*DEFINE_CURVE\n8\n0,0\n{END},1\n1,1\n{lines}"
    )
}

const STEEL: &str = "*MAT_ELASTIC\n1,7.85e-6,207.0,0.3\n";

/// Mean velocity along x, over the velocity at the start.
fn ratio(end: &Engine) -> f64 {
    let momentum: f64 = end.nodes.mass.iter().zip(&end.nodes.v).map(|(m, v)| m * v[0]).sum();
    momentum / end.nodes.mass.iter().sum::<f64>() / VELOCITY
}

/// Both cubes damped, by a constant and by one that grows: the exponential of the integral, within
/// a step. The work of the damping is the loss of kinetic energy, to round-off.
#[test]
fn damped_bodies_become_slower_by_the_exponential() {
    let all = |curve: u32| {
        cubes(STEEL, &format!("*DAMPING_PART_MASS\n1,{curve},{ALPHA}\n2,{curve},{ALPHA}\n"))
    };
    for (curve, integral) in [(9, ALPHA * END), (8, 0.5 * ALPHA * END)] {
        let end = run_alone(&model_of(&all(curve)), |_| {});
        let (found, exact) = (ratio(&end), (-integral).exp());
        let by_step = ALPHA * end.clock.time / end.clock.cycle as f64;
        let error = (found / exact).ln();
        // The velocity is that of half a step before the end, and the curve that before the step.
        assert!(error.abs() < by_step, "{curve}: {found}, {exact}, {error:.1e} of {by_step:.1e}");
        let energies = end.energies(true).values();
        let balance = (energies.external + MASS * VELOCITY * VELOCITY) / energies.kinetic - 1.0;
        println!("{curve}: {error:.1e} of {by_step:.1e}, balance {balance:.1e}");
        assert!(balance.abs() < 1e-9, "{energies:?}: {balance}");
    }
}

/// Damping of all masses by a curve: the exponential of its integral, within a step. The work is
/// the loss of kinetic energy, bits do not depend on workers, and the deck that is written is the
/// same.
#[test]
fn damping_of_all_masses_follows_its_curve() {
    let deck = cubes(
        STEEL,
        &format!("*DAMPING_GLOBAL\n8,0,{ALPHA},{ALPHA},{ALPHA},{ALPHA},{ALPHA},{ALPHA}\n"),
    );
    let model = model_of(&deck);
    let end = run_alone(&model, |_| {});
    let (found, exact) = (ratio(&end), (-0.5 * ALPHA * END).exp());
    let by_step = ALPHA * end.clock.time / end.clock.cycle as f64;
    let error = (found / exact).ln();
    assert!(error.abs() < by_step, "{found}, {exact}, {error:.1e} of {by_step:.1e}");
    let energies = end.energies(true).values();
    let balance = (energies.external + MASS * VELOCITY * VELOCITY) / energies.kinetic - 1.0;
    assert!(balance.abs() < 1e-9, "{energies:?}: {balance}");
    let digest = |workers| run_side_by_side(&model, workers, 300, 0).digest();
    let alone = digest(1);
    assert!([2, 3].into_iter().all(|workers| digest(workers) == alone));
    assert_same_when_written(&deck, "time.max_cycles=100", "*DAMPING_GLOBAL");
}

/// One damped cube of two: the nodes of the common face have half of the damping, so that the whole
/// momentum falls at half the rate.
#[test]
fn nodes_between_parts_have_their_share() {
    let one = cubes(STEEL, &format!("*DAMPING_PART_MASS\n1,9,{ALPHA}\n"));
    let model = model_of(&one);
    let shares = &model.settings.loads.part_damping[0].shares;
    assert_eq!(shares.len(), 8);
    let share = |id| shares.iter().find(|s| s.0 == NodeId(id)).expect("a node").1;
    assert_eq!((share(1), share(5)), (1.0, 0.5));
    let end = run_alone(&model, |_| {});
    let (found, exact) = (ratio(&end), (-0.5 * ALPHA * END).exp());
    // Measured 1e-3: the damped cube is slower than the other one, which pulls it along.
    println!("shared {:.1e}", found / exact - 1.0);
    assert!((found / exact - 1.0).abs() < 2e-3, "{found}, {exact}");
    let digest = |workers| run_side_by_side(&model, workers, 300, 0).digest();
    let alone = digest(1);
    assert!([2, 3, 4].into_iter().all(|workers| digest(workers) == alone));
    assert_same_when_written(&one, "time.max_cycles=100", "*DAMPING_PART_MASS_SET");
    let both =
        cubes(STEEL, &format!("*SET_PART_LIST\n5\n1,2\n*DAMPING_PART_MASS_SET\n5,9,{ALPHA}\n"));
    assert_same_when_written(&both, "time.max_cycles=100", "*DAMPING_PART_MASS_SET");
}

/// A strip of shells that turns about an edge is damped with its rotations, also if it is computed
/// in subcycles and on several workers.
#[test]
fn rotations_are_damped() {
    let model = |more: &[&str]| {
        let text = format!(
            "{BASE}{STEEL}*DAMPING_PART_MASS\n1,9,{ALPHA}\n*DEFINE_CURVE\n9\n0,1\n20,1\n\
             *SET_PART_LIST\n5\n1\n*INITIAL_VELOCITY_GENERATION\n5,1,0.05\n0,5,12,0,1,0\n"
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deck.k");
        std::fs::write(&path, format!("{text}*END\n")).unwrap();
        let sets = [&["end_time=0.3"], more].concat();
        let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
        crumple::input::job::read(&path, &sets).unwrap_or_else(|report| panic!("{report}"))
    };
    let plain = model(&[]);
    let end = run_alone(&plain, |_| {});
    let w = end.nodes.w[end.nodes.local_index(NodeId(12)).expect("a node") as usize][1];
    let by_step = ALPHA * end.clock.time / end.clock.cycle as f64;
    let error = (w / 0.05).ln() + ALPHA * end.clock.time - 0.5 * by_step;
    println!("rotation: {error:.1e}");
    // The edges of the free strip swing about its rigid rotation, with 1 % at most.
    assert!(error.abs() < 1e-2, "{w}: {error}");
    for model in [plain, model(&["time.subcycles=2"])] {
        let digest = |workers| run_side_by_side(&model, workers, 200, 0).digest();
        assert_eq!(digest(1), digest(3));
    }
}

/// Members of a rigid body pass the forces on to it, with their moment: its spin falls at the same
/// rate as its velocity.
#[test]
fn rigid_bodies_are_damped() {
    let rigid = "*MAT_RIGID\n1,7.85e-6,207.0,0.3\n";
    let spin = 0.02;
    let set = format!(
        "*SET_PART_LIST\n5\n1,2\n*DAMPING_PART_MASS_SET\n5,9,{ALPHA},1\n2,2,2\n\
         *CONSTRAINED_RIGID_BODIES\n1,2\n*INITIAL_VELOCITY_RIGID_BODY\n\
         1,0,{VELOCITY},0,{spin},0,0\n*CONTROL_TIMESTEP\n,,,,,7\n*DEFINE_CURVE\n7\n0,5e-4\n9,5e-4\n"
    );
    let deck = cubes(rigid, &set);
    let at_start = format!("*INITIAL_VELOCITY\n0\n{VELOCITY}\n");
    assert!(deck.contains(&at_start));
    let model = model_of(&deck.replace(&at_start, ""));
    let end = run_alone(&model, |_| {});
    let v = |id| end.nodes.v[end.nodes.local_index(NodeId(id)).expect("a node") as usize];
    // Nodes 1 to 4 are the corners of the end, about the axis x.
    let mean = 0.25 * (1..=4).map(|id| v(id)[1]).sum::<f64>();
    let turning = ((v(4)[1] - v(1)[1]).powi(2) + (v(4)[2] - v(1)[2]).powi(2)).sqrt() / 10.0;
    let exact = (-2.0 * ALPHA * END).exp();
    for found in [mean / VELOCITY, turning / spin] {
        // With the velocity before the step: faster by the fraction alpha dt/2 of the exponent, 3,
        // so by 4.5e-3; and half a step early, 1.5e-3.
        println!("rigid {:.1e}", found / exact - 1.0);
        assert!((found / exact - 1.0).abs() < 5e-3, "{found}, {exact}");
    }
    let digest = |workers| run_side_by_side(&model, workers, 200, 0).digest();
    assert_eq!(digest(1), digest(2));
}

#[test]
fn wrong_damping_is_refused() {
    for (lines, words) in [
        ("*DAMPING_PART_MASS\n7,9,1.0\n", "known: 1, 2"),
        ("*DAMPING_PART_MASS\n1,6,1.0\n", "*DEFINE_CURVE"),
        ("*DAMPING_PART_MASS\n1,9,1.0,1\n1,2,1\n", "`sty` = 2"),
        ("*DAMPING_PART_MASS\n1,9,-1.0\n", "`coefficient` is -1"),
        ("*DAMPING_PART_STIFFNESS\n1,-1e-4\n", "`coef` = -0.0001 is not supported"),
    ] {
        assert_refused(&cubes(STEEL, lines), &[words]);
    }
    let report = refused("$\n*DAMPING_PART_STIFFNESS_SET\n9,0.1\n");
    assert!(report.contains("*SET_PART"), "{report}");
}

/// A fraction of the critical damping of the highest frequencies is left out with a warning.
#[test]
fn stiffness_damping_is_ignored_with_a_warning() {
    let model = with("*DAMPING_PART_STIFFNESS\n1,0.1\n2,0.05\n");
    let ignored: Vec<&str> =
        model.warnings.iter().map(|w| w.message.as_str()).filter(|m| m.contains("coef")).collect();
    assert!(ignored.len() == 1 && ignored[0].contains("is ignored, and 1 more"), "{ignored:?}");
    assert!(model.job.damping.is_empty());
}
