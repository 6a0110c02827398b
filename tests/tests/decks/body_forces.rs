//! Forces and moments on rigid bodies of decks against closed forms. The cube of the base is rigid;
//! its plate is at rest and sets the step. Units mm, ms, kg, so kN and J.

use crate::base::{BASE, STEEL, assert_refused, assert_same_when_written, model_of};
use crumple::input::check::describe;
use crumple_tests::{run_alone, run_side_by_side};
use crumple_worker::engine::Engine;
use nalgebra::Vector3;

/// Mass of the cube [kg], and the end of the runs [ms].
const MASS: f64 = 7.85e-3;
const END: f64 = 0.5;

/// Returns the base with a rigid cube that turns with this velocity about z [1/ms], and more lines.
fn deck(spin: f64, lines: &str) -> String {
    let base = BASE.replace("\n10.0\n", &format!("\n{END}\n")).replace("cube\n2,2,1\n", "");
    format!(
        "{base}{STEEL}*MAT_RIGID\n2,7.85e-6,207.0,0.3\n*PART_INERTIA\ncube\n2,2,2\n\
         5.0,5.0,5.0,{MASS}\n0.3,0.0,0.0,0.3,0.0,0.3\n0.0,0.0,0.0,0.0,0.0,{spin}\n\
         *DEFINE_CURVE\n7\n0.0,1.0\n10.0,1.0\n{lines}"
    )
}

/// Returns the displacement of the centre.
fn moved(engine: &Engine) -> Vector3<f64> {
    engine.constraints.bodies.bodies[0].centre - Vector3::new(5.0, 5.0, 5.0)
}

/// A constant force moves the centre by `F t^2/(2 m)`, which the scheme gives to round-off; a
/// constant moment turns it by `M t^2/(2 I)`, to the error of the turn of a step. The work of both
/// is the kinetic energy.
#[test]
fn constant_forces_and_moments_give_parabolas() {
    let lines = "*LOAD_RIGID_BODY\n2,1,7,0.02\n2,3,7,-0.01\n2,7,7,0.04\n";
    let end = run_alone(&model_of(&deck(0.0, lines)), |_| {});
    let body = &end.constraints.bodies.bodies[0];
    let time = end.clock.time;
    let expected = Vector3::new(0.02, 0.0, -0.01) * (0.5 * time * time / MASS);
    let error = (moved(&end) - expected).norm() / expected.norm();
    let (angle, turn) = (body.turn.scaled_axis().z, 0.5 * 0.04 * time * time / 0.3);
    println!("displacement {error:.1e}, angle {:.1e}", angle / turn - 1.0);
    assert!(error < 1e-11, "{}, expected {expected}", moved(&end));
    assert!((angle / turn - 1.0).abs() < 1e-6, "{angle}, expected {turn}");
    let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
    let work = 0.5 * MASS * (expected * (2.0 / time)).norm_squared()
        + 0.5 * 0.3 * (2.0 * turn / time).powi(2);
    println!("work {:.1e}", energies.external / work - 1.0);
    // The last work is that of the step before the end: 2 dt/t = 7e-3.
    assert!((energies.external / work - 1.0).abs() < 1e-2, "{} of {work}", energies.external);
    let both = end.energies(true).values();
    println!("balance {:.1e}", both.kinetic / both.external - 1.0);
    // After the last step the inertia beyond that of the nodes counts with the velocity of half a
    // step later: measured 7.4e-5.
    assert!((both.kinetic / both.external - 1.0).abs() < 2e-4, "{both:?}");
}

/// A force that follows a body which turns with w about z gives the velocity
/// `F/(m w) (sin w t, 1 - cos w t)`.
#[test]
fn a_force_follows_the_body() {
    let (spin, force) = (3.0, 0.05);
    let lines = format!("*LOAD_RIGID_BODY\n2,4,7,{force},0,1,4,5\n");
    let model = model_of(&deck(spin, &lines));
    assert!(describe(&model).contains("a force along the normal m1m2 x m1m3"));
    let mut worst = 0.0f64;
    let scale = force / (MASS * spin);
    run_alone(&model, |engine| {
        let turned = spin * engine.clock.time;
        let place = Vector3::new(1.0 - turned.cos(), turned - turned.sin(), 0.0) / spin;
        worst = worst.max((moved(engine) - place * scale).norm() / scale * spin);
    });
    println!("largest error {worst:.1e} of F/(m w^2)");
    // The trapezoidal sums of a circle are off by (w dt)^2/12, with the step of 1.7e-3.
    assert!(worst < 1e-5, "{worst}");
    let still = run_alone(&model_of(&deck(spin, &lines.replace("2,4,", "2,1,"))), |_| {});
    assert!(moved(&still).y.abs() < 1e-12, "a force of dof 1 keeps its direction");
}

/// A curve is the factor on the force, along axes of a system; the bits are those of one worker.
#[test]
fn forces_follow_curves_along_axes_on_any_workers() {
    let lines = "*LOAD_RIGID_BODY\n2,1,8,2.0,5\n2,6,8,0.1\n\
                 *DEFINE_CURVE\n8\n0.0,0.0\n0.25,0.01\n10.0,0.4\n\
                 *DEFINE_COORDINATE_SYSTEM\n5,0,0,0,0,1,0\n-1,0,0\n";
    let model = model_of(&deck(1.0, lines));
    assert_eq!(model.job.rigid[0].load[0].force, [0.0, 2.0, 0.0]);
    let end = run_alone(&model, |_| {});
    // The force is 2 * 0.04 t: m y = 0.08 t^3/6. The sums over steps are off by (dt/t)^2.
    let expected = 0.08 * end.clock.time.powi(3) / 6.0 / MASS;
    let error = moved(&end).y / expected - 1.0;
    println!("error {error:.1e}");
    assert!(error.abs() < 3e-5, "{} of {expected}", moved(&end).y);
    let digest = |workers| run_side_by_side(&model, workers, 1_000_000, 0).digest();
    assert_eq!(digest(2), digest(1));
    assert_eq!(digest(3), digest(1));
}

/// Cards and errors: what is written reads back with the same bits.
#[test]
fn loads_of_bodies_are_written_as_cards_and_errors_are_named() {
    let plain = deck(0.0, "*LOAD_RIGID_BODY\n2,1,7,0.02\n2,7,7,0.04\n");
    assert_same_when_written(&plain, "end_time=0.05", "*LOAD_RIGID_BODY");
    let follows = deck(2.0, "*LOAD_RIGID_BODY\n2,8,7,0.04,0,1,2,4\n2,1,7,0.02\n");
    assert_same_when_written(&follows, "end_time=0.05", "follows = true");
    for (line, words) in [
        ("1,1,7,1.0", "there is no rigid part with the id 1"),
        ("2,9,7,1.0", "`dof` is 9"),
        ("2,1,9,1.0", "there is no *DEFINE_CURVE with the id 9"),
        ("2,4,7,1.0,0,1,2,11", "node 11 is no node of the body of part 2"),
        ("2,4,7,1.0,0,1,2,2", "m1, m2 and m3 are on one line"),
        ("2,4,7,1.0,0,1,2,99", "there is no node with the id 99"),
        ("2,1,7,1.0,5", "there is no *DEFINE_COORDINATE_... with the id 5"),
    ] {
        assert_refused(&deck(0.0, &format!("*LOAD_RIGID_BODY\n{line}\n")), &[words]);
    }
}
