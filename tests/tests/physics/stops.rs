//! Bounds of the motion of rigid bodies and walls that act for a part of the run: places, energy
//! and momentum, on any number of workers and after a restart. Units mm, ms, kg.

use crate::rigid::Bodies;
use crumple::input::job::Model;
use crumple_tests::restart::{Plan, run_interrupted};
use crumple_tests::{run_alone, run_side_by_side};
use crumple_worker::engine::Engine;
use nalgebra::Vector3;

/// A rigid cube, part 1, with these keys of its body and of the job.
fn cube(end_time: f64, keys: &str) -> Model {
    let mut bodies = Bodies::default();
    bodies.cuboid([0.0; 3], [2, 2, 2], 5.0);
    let rest = format!("[[rigid]]\nname = \"cube\"\nparts = [1]\n{keys}[time]\ndt_max = 0.01\n");
    bodies.job(end_time, &rest)
}

/// A curve with this name and these points.
fn curve(name: &str, points: &str) -> String {
    format!("[[curve]]\nname = \"{name}\"\npoints = [{points}]\n")
}

/// Motion of the cube at the start.
const THROWN: &str = "[[initial_velocity]]\nvelocity = [3.0, 1.0, -0.5]\n";

fn moved(e: &Engine) -> Vector3<f64> {
    e.constraints.bodies.bodies[0].centre - Vector3::new(5.0, 5.0, 5.0)
}

/// A body that is thrown against an oblique stop ends on it and slides along it: the impact takes
/// the velocity along the stop, and its energy is the work of the stop. The place is that of the
/// bound to round-off, 10 mm times 1e-13.
#[test]
fn a_stop_takes_the_velocity_along_its_direction() {
    let along = Vector3::new(3.0, 4.0, 0.0) / 5.0;
    let thrown = Vector3::new(3.0, 1.0, -0.5);
    for (bound, value) in [("upper", 0.7), ("position = true\nupper", 7.7)] {
        let keys = format!(
            "[[rigid.stop]]\ndirection = [3.0, 4.0, 0.0]\n{bound} = \"bound\"\n{}{THROWN}",
            curve("bound", &format!("[0.0, {value:?}], [9.0, {value:?}]"))
        );
        let mut beyond = f64::NEG_INFINITY;
        let end = run_alone(&cube(1.0, &keys), |e| beyond = beyond.max(moved(e).dot(&along)));
        let body = &end.constraints.bodies.bodies[0];
        assert!((moved(&end).dot(&along) - 0.7).abs() < 1e-12, "{bound}: {}", moved(&end));
        assert!(beyond < 0.7 + 1e-12, "{bound}: {beyond}");
        let left = thrown - along * along.dot(&thrown);
        assert!((body.last.velocity - left).norm() < 1e-12, "{bound}: {}", body.last.velocity);
        assert!(body.last_spin.norm() < 1e-12, "the force is on the centre: {}", body.last_spin);
        let lost = 0.5 * body.mass * along.dot(&thrown).powi(2);
        let work = end.ledger.energies(&end.nodes, &end.blocks).values().wall;
        assert!((work / -lost - 1.0).abs() < 1e-9, "{bound}: {work} of {lost}");
    }
}

/// A bound that moves against a body at rest takes it along, and its work is the kinetic energy.
#[test]
fn a_bound_that_moves_takes_the_body_along() {
    let keys = format!(
        "[[rigid.stop]]\ndirection = [0.0, 0.0, 2.0]\nlower = \"lift\"\n{}",
        curve("lift", "[0.0, 0.0], [0.5, 0.0], [1.5, 2.0]")
    );
    let mut worst = 0.0f64;
    let end = run_alone(&cube(1.5, &keys), |e| {
        let lift = (2.0 * (e.clock.time - 0.5)).max(0.0);
        worst = worst.max((moved(e).z - lift).abs());
    });
    assert!(worst < 1e-12, "the body is on the bound at all times: {worst}");
    let body = &end.constraints.bodies.bodies[0];
    let work = end.ledger.energies(&end.nodes, &end.blocks).values().wall;
    assert!((work / (0.5 * body.mass * 4.0) - 1.0).abs() < 1e-9, "{work}");
}

/// A stop acts from its birth to its death. A body that is beyond it at the birth is held there,
/// not moved back, and goes on after the death with no velocity along the stop.
#[test]
fn a_stop_acts_between_birth_and_death() {
    let held = |birth: f64, death: f64| {
        let keys = format!(
            "[[rigid.stop]]\ndirection = [1.0, 0.0, 0.0]\nupper = \"bound\"\nbirth = {birth:?}\n\
             death = {death:?}\n{}{THROWN}",
            curve("bound", "[0.0, 0.5], [9.0, 0.5]")
        );
        let end = run_alone(&cube(1.0, &keys), |_| {});
        (moved(&end).x, end.constraints.bodies.bodies[0].last.velocity.x)
    };
    // 1e-12 is round-off of the momentum of the nodes.
    assert!((held(5.0, 6.0).1 - 3.0).abs() < 1e-12, "it begins after the run");
    let (x, v) = held(0.5, 2.0);
    assert!((x - 1.5).abs() < 3.0 * 0.01 && v.abs() < 1e-12, "within a step: {x}, {v}");
    let (x, v) = held(0.0, 0.1);
    assert!(
        (x - 3.0).abs() < 1e-12 && (v - 3.0).abs() < 1e-12,
        "it ends before the impact: {x}, {v}"
    );
}

/// A plate falls on a stopped cube, which does not yield: no bit depends on the workers, nor on an
/// interruption before or after the impact on the stop.
#[test]
fn stops_are_the_same_on_any_workers_and_after_a_restart() {
    let mut bodies = Bodies::default();
    bodies.cuboid([0.0; 3], [2, 2, 2], 5.0);
    bodies.plate([0.0, 0.0, 11.5], [2, 2], 5.0);
    let rest = format!(
        "[[rigid]]\nname = \"cube\"\nparts = [1]\n\
         [[rigid.stop]]\ndirection = [0.1, 0.0, 1.0]\nlower = \"floor\"\nbirth = 0.01\n{}\
         [contact]\n[[initial_velocity]]\nnodes = \"part_2\"\nvelocity = [1.0, 0.0, -30.0]\n",
        curve("floor", "[0.0, -0.05], [9.0, -0.05]")
    );
    let with = bodies.job(0.06, &rest);
    let without = bodies.job(0.06, &rest.replace("birth = 0.01", "birth = 1.0"));
    let one = run_side_by_side(&with, 1, 1_000_000, 0);
    assert_ne!(
        one.digest(),
        run_side_by_side(&without, 1, 1_000_000, 0).digest(),
        "the stop acts in this run"
    );
    for workers in [2, 3] {
        assert_eq!(run_side_by_side(&with, workers, 1_000_000, 0).digest(), one.digest());
    }
    let count = one.pairs.len() as u64;
    for part in [2, 12] {
        let plan = Plan { at: count * part / 20, cycles: 1_000_000, workers: [2, 3] };
        assert_eq!(run_interrupted(&with, plan), one.digest(), "{plan:?}");
    }
}

/// A plate that flies down meets a wall only between its birth and its death, whether it is rigid
/// or not. Nodes behind a plane at its birth are not thrown out.
#[test]
fn a_wall_acts_between_birth_and_death() {
    let end = |rigid: &str, times: &str| {
        let mut bodies = Bodies::default();
        bodies.plate([0.0; 3], [2, 2], 5.0);
        let rest = format!(
            "{rigid}[[wall]]\npoint = [0.0, 0.0, -1.0]\nnormal = [0.0, 0.0, 1.0]\n{times}\
             [[initial_velocity]]\nvelocity = [0.0, 0.0, -10.0]\n\
             [time]\ndt_max = 1e-3\n"
        );
        let end = run_alone(&bodies.job(0.3, &rest), |_| {});
        let z: Vec<f64> = (0..end.nodes.local_count).map(|i| end.nodes.x[i][2]).collect();
        let [least, most] = [f64::min, f64::max].map(|f| z.iter().copied().reduce(f).unwrap());
        (least, most, end.constraints.walls.impulse(0)[2])
    };
    let momentum = 10.0 * 7.85e-6 * 100.0;
    for rigid in ["", "[[rigid]]\nname = \"plate\"\nparts = [1]\n"] {
        for times in ["", "birth = 0.05\n", "death = 0.2\n", "birth = 0.05\ndeath = 0.25\n"] {
            let (least, most, impulse) = end(rigid, times);
            assert!((least + 1.0).abs().max((most + 1.0).abs()) < 1e-9, "{rigid}{times}: {least}");
            assert!((impulse / momentum - 1.0).abs() < 1e-9, "{rigid}{times}: {impulse}");
        }
        // The plate passes at 0.1.
        for times in ["birth = 0.15\n", "death = 0.05\n", "birth = 0.02\ndeath = 0.06\n"] {
            let (least, most, impulse) = end(rigid, times);
            assert!((least + 3.0).abs().max((most + 3.0).abs()) < 1e-9, "{rigid}{times}: {least}");
            assert_eq!(impulse, 0.0, "{rigid}{times}");
        }
    }
}

/// No bit depends on the workers or on an interruption before the birth of a wall or after its
/// death.
#[test]
fn walls_with_times_are_the_same_on_any_workers_and_after_a_restart() {
    let mut bodies = Bodies::default();
    bodies.plate([0.0; 3], [4, 3], 5.0);
    let rest = "[[wall]]\npoint = [0.0, 0.0, -0.2]\nnormal = [0.1, 0.0, 1.0]\nbirth = 0.005\n\
                death = 0.03\n[[initial_velocity]]\nvelocity = [0.0, 0.0, -20.0]\n";
    let model = bodies.job(0.04, rest);
    let one = run_side_by_side(&model, 1, 1_000_000, 0);
    let later = bodies.job(0.04, &rest.replace("0.03", "0.035"));
    assert_ne!(one.digest(), run_side_by_side(&later, 1, 1_000_000, 0).digest());
    for workers in [2, 3] {
        assert_eq!(run_side_by_side(&model, workers, 1_000_000, 0).digest(), one.digest());
    }
    let count = one.pairs.len() as u64;
    for part in [1, 10, 18] {
        let plan = Plan { at: count * part / 20, cycles: 1_000_000, workers: [2, 3] };
        assert_eq!(run_interrupted(&model, plan), one.digest(), "{plan:?}");
    }
}
