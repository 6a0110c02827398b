//! Tests of one body without a mesh: conservation, and prescribed motion.

use super::body::{Body, Momentum};
use crate::math::row::V3;
use crumple_proto::loads::{MotionForm, PrescribedMotion};
use crumple_proto::rigid::RigidBody;
use nalgebra::Matrix3;

fn job() -> RigidBody {
    RigidBody {
        nodes: Vec::new(),
        parts: Vec::new(),
        fixed: 0,
        inertia: None,
        added_inertia: None,
        motions: Vec::new(),
        window: None,
        stops: Vec::new(),
        loads: Vec::new(),
    }
}

/// Three different principal moments, axes not aligned with space.
fn inertia() -> Matrix3<f64> {
    let r = nalgebra::Rotation3::from_euler_angles(0.3, -0.7, 1.1).into_inner();
    r * Matrix3::from_diagonal(&V3::new(1.0, 2.0, 2.7)) * r.transpose()
}

fn run(
    job: &RigidBody,
    moves: Momentum,
    steps: usize,
    dt: f64,
    mut look: impl FnMut(&Body),
) -> Body {
    let mut body = Body::new(job, &[], 3.0, inertia(), V3::new(1.0, 2.0, 3.0), moves);
    for i in 0..steps {
        body.start_step(i as f64 * dt, dt);
        body.rotate(i as f64 * dt, dt);
        body.advance(dt);
        look(&body);
    }
    body
}

/// A free body rotates about its middle axis, which is unstable, for 1e5 steps of 1/30 radian.
/// Angular momentum and velocity keep every bit; energy is constant to round-off. Round-off of
/// the orientation changes the energy by some eps per step, at random: sqrt(1e5) eps = 7e-14.
#[test]
fn a_free_body_keeps_energy_and_momentum() {
    let moves = Momentum::new(V3::new(0.1, -0.2, 0.3), V3::new(0.5, 1.8, -0.4));
    let mut worst = 0.0f64;
    let first = Body::new(&job(), &[], 3.0, inertia(), V3::zeros(), moves).energy();
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    let body = run(&job(), moves, 100_000, 0.03, |b| {
        worst = worst.max((b.energy() / first - 1.0).abs());
        let along = (b.turn.inverse() * b.last.angular).x;
        (least, most) = (least.min(along), most.max(along));
    });
    assert_eq!((body.last.velocity, body.last.angular), (moves.velocity, moves.angular));
    assert!(
        (body.centre - V3::new(1.0, 2.0, 3.0) - moves.velocity * 3000.0).norm()
            < 1e5 * 1e3 * f64::EPSILON,
        "round-off of 1e5 sums near 1e3"
    );
    assert!(most - least > 1.0, "the body tumbles: {least} to {most}");
    eprintln!("energy drifts by {worst:e}");
    assert!(worst < 1e-12, "{worst:e}");
}

/// The scheme is of second order: half the step gives a quarter of the orientation's error.
#[test]
fn orientation_converges_with_the_square_of_the_step() {
    let moves = Momentum::new(V3::zeros(), V3::new(0.5, 1.8, -0.4));
    let after = |steps: usize| run(&job(), moves, steps, 5.0 / steps as f64, |_| {}).turn;
    let exact = after(20_000);
    let [coarse, fine] = [200, 400].map(|n| after(n).angle_to(&exact));
    assert!((coarse / fine - 4.0).abs() < 0.05, "{coarse} {fine}");
}

/// With two rotations fixed, a body rotates about the third axis of space steadily, with L / J
/// about this axis.
#[test]
fn a_guided_body_turns_about_what_is_left() {
    let held = RigidBody { fixed: 0b01_1101, ..job() };
    let body = run(
        &held,
        Momentum::new(V3::new(1.0, 2.0, 3.0), inertia() * V3::new(0.0, 0.0, 0.4)),
        1000,
        0.01,
        |b| {
            assert!((b.last_spin - V3::new(0.0, 0.0, 0.4)).norm() < 1e-12, "{}", b.last_spin);
        },
    );
    assert!(
        (body.turn.scaled_axis() - V3::new(0.0, 0.0, 4.0 - std::f64::consts::TAU)).norm() < 1e-11
    );
    assert_eq!([body.centre.x, body.centre.z], [1.0, 3.0]);
    assert!((body.centre.y - 22.0).abs() < 1e-11);
}

/// Prescribed rotation and displacement, with the third translation free.
#[test]
fn a_prescribed_body_follows_its_curve() {
    let motion = |form, dofs, amount| PrescribedMotion {
        nodes: Vec::new(),
        dofs,
        form,
        amount,
        curve: None,
        window: None,
    };
    let spin = motion(MotionForm::Spin { centre: [0.0; 3] }, 0b11_1000, [0.0, 0.6, 0.8]);
    let led = RigidBody {
        motions: vec![spin, motion(MotionForm::Velocity, 0b011, [1.0, -2.0, 5.0])],
        ..job()
    };
    let body = run(&led, Momentum::new(V3::new(0.0, 0.0, 7.0), V3::zeros()), 1000, 0.002, |_| {});
    assert!((body.turn.scaled_axis() - V3::new(0.0, 1.2, 1.6)).norm() < 1e-12);
    assert!((body.centre - V3::new(3.0, -2.0, 17.0)).norm() < 1e-12);
}
