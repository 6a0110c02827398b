//! Tests of the penalty law: a spring, and the bound on its stiffness.

use super::*;

/// The penalty law is a spring `k = scale m_red / dt^2`. It conserves momentum, the rebound is
/// without loss, and the penetration is `v sqrt(m_red / k) = v dt / sqrt(scale)`. It is stable up
/// to the limit of central differences, k m_red^-1 dt^2 < 4.
#[test]
fn penalty_is_a_spring_that_keeps_momentum_and_energy() {
    let mut sunk = Vec::new();
    for scale in [0.02, 0.1, 0.5] {
        let (m, v, dt) = (3.0, 1.0, 1e-3);
        let mut points = square([2.0; 4]);
        points.push(mass([0.0, 0.0, THICK + 1e-4], [0.0, 0.0, -v], m));
        let job = job("penalty").with("penalty_scale", scale);
        let mut scene = Scene::new(&job, &points, &[[0, 1, 2, 3]], &[4], dt);
        let (p, before) = (scene.momentum(), scene.energy());
        let mut deepest = 0.0f64;
        for _ in 0..200 {
            scene.step();
            deepest = deepest.max(scene.x(0).z - scene.x(4).z + THICK);
        }
        assert!(scene.pairs().is_empty() && scene.v(4).z > scene.v(0).z, "apart again");
        assert!((scene.momentum() - p).norm() < 1e-12 * p.norm(), "round-off");
        // The stiffness is at most half of what a safety factor of 0.9 leaves.
        let used = f64::min(scale, 2.0 * (1.0 - 0.9 * 0.9));
        let expected = v * dt / used.sqrt();
        // Steps are 1/8 of an oscillation and more: the deepest point is between two steps.
        assert!(
            (deepest / expected - 1.0).abs() < 0.05,
            "scale {scale}: {deepest}, expected {expected}"
        );
        // Central differences conserve the energy of a spring, also where contact begins and ends
        // within a step, since the first and the last impulse are reduced.
        let kept = scene.energy() / before;
        eprintln!("scale {scale}: penetration {deepest:.2e}, energy kept {kept:.15}");
        assert!((kept - 1.0).abs() < 1e-12, "scale {scale}: {kept}");
        sunk.push(deepest);
    }
    assert!(
        sunk.windows(2).all(|d| d[0] > d[1]),
        "a stiffer spring gives a smaller penetration: {sunk:?}"
    );
}

/// C02: a light node on a heavy segment and a heavy node on a light one. For any requested
/// stiffness, the stiffness in use keeps the step stable. Momentum and energy are conserved, and
/// pairs with reduced stiffness are counted.
#[test]
fn stiffness_is_bounded_by_the_masses_that_it_moves() {
    for (m, segment) in [(1e-6, 1e-3), (1.0, 1e-6)] {
        let (v, dt) = (10.0, 1e-6);
        let mut points = square([segment; 4]);
        points.push(mass([0.0, 0.0, THICK], [0.0, 0.0, -v], m));
        // 1e9 times the stiffness of the segment, E A / d = sqrt 2.
        let job = job("penalty")
            .with("penalty_form", "stiffness")
            .with("penalty_scale", 1e9 / 2f64.sqrt());
        let mut scene = Scene::new(&job, &points, &[[0, 1, 2, 3]], &[4], dt);
        let (p, before) = (scene.momentum(), scene.energy());
        (0..200).for_each(|_| _ = scene.step());
        assert!(scene.contact.capped_pairs > 0, "said");
        assert!((scene.momentum() - p).norm() < 1e-12 * p.norm(), "round-off");
        assert!(
            (scene.energy() / before - 1.0).abs() < 1e-12,
            "{m} on {segment}: {}",
            scene.energy() / before
        );
        let light = if m < segment { -scene.v(4).z - v } else { -scene.v(0).z };
        // In an elastic impact the light body gets `2 v M / (m + M)`.
        let heavy = f64::max(m, 4.0 * segment) / (m + 4.0 * segment);
        assert!(
            (light.abs() / (2.0 * v * heavy) - 1.0).abs() < 1e-12,
            "{m} on {segment}: the light body leaves with {light}"
        );
    }
}

/// A node on a segment of four free nodes or on a held one, at the middle and elsewhere, with equal
/// and different masses: the energy is kept wherever the contact begins and ends within a step. A
/// dashpot only takes energy.
#[test]
fn energy_is_kept_wherever_a_contact_begins_within_a_step() {
    let v = 1.0;
    let lost = |masses: [f64; 4], is_held: bool, at: [f64; 2], damping: f64, phase: f64| {
        let dt = 1e-3;
        let mut points = square(masses);
        if is_held {
            points.iter_mut().for_each(|p| p.fixed = HELD);
        }
        points.push(mass([at[0], at[1], THICK + phase * v * dt], [0.0, 0.0, -v], 3.0));
        let job = job("penalty").with("penalty_damping", damping);
        let mut scene = Scene::new(&job, &points, &[[0, 1, 2, 3]], &[4], dt);
        let before = scene.energy();
        (0..60).for_each(|_| _ = scene.step());
        assert!(scene.pairs().is_empty(), "apart again");
        1.0 - scene.energy() / before
    };
    for phase in (0..20).map(|k| (0.5 + k as f64) / 20.0) {
        for (masses, is_held) in [([2.0; 4], false), ([0.01; 4], false), ([1.0; 4], true)] {
            let loss = lost(masses, is_held, [0.0; 2], 0.0, phase);
            assert!(loss.abs() < 1e-12, "{masses:?}, held {is_held}, phase {phase}: {loss:e}");
            let damped = lost(masses, is_held, [0.0; 2], 0.1, phase);
            assert!(damped > 1e-3, "{masses:?}, held {is_held}, phase {phase}: {damped:e}");
        }
        // The segment turns under the node, and the compliance follows its corners.
        let loss = lost([1.0, 2.0, 3.0, 4.0], false, [0.3, -0.2], 0.0, phase);
        assert!(loss.abs() < 1e-4, "phase {phase}: {loss:e}");
    }
}

const CELLS: usize = 12;
/// Force that holds the rods together.
const PRELOAD: f64 = 0.01;

/// Two rods of lumped masses, pressed together and at rest. Mass and stiffness per cell are 1, so
/// that a free rod is stable up to dt = 1. The lower rod is four strings with a segment at the end,
/// the upper rod is one string with the slave at the end.
fn rods(of: &ContactInput, dt: f64) -> Scene {
    let along_z = |x: f64, y: f64, z: f64, m: f64| NodeRecord {
        fixed: 0b011,
        ..mass([x, y, z], [0.0; 3], m)
    };
    let lumped = |i: usize| if i == 0 || i == CELLS { 0.5 } else { 1.0 };
    let mut points = Vec::new();
    for i in 0..=CELLS {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        points
            .extend(corners.map(|[x, y]| along_z(x, y, i as f64 - CELLS as f64, 0.25 * lumped(i))));
    }
    let slave = points.len();
    points.extend((0..=CELLS).map(|i| along_z(0.0, 0.0, i as f64 + THICK, lumped(i))));
    let top = 4 * CELLS as u32;
    let mut scene =
        Scene::new(of, &points, &[[top, top + 1, top + 2, top + 3]], &[slave as u32], dt);
    // The length without force is longer by the compression of the preload.
    scene.springs = (0..4 * CELLS).map(|i| (i, i + 4, 0.25, 1.0 + PRELOAD)).collect();
    scene.springs.extend((slave..slave + CELLS).map(|i| (i, i + 1, 1.0, 1.0 + PRELOAD)));
    (0..4).for_each(|i| scene.load[i].z = 0.25 * PRELOAD);
    scene.load[slave + CELLS].z = -PRELOAD;
    scene.run_damped(2000, 0.05);
    // At these steps the residual of the Lagrange law is up to 2.5 % of the preload.
    let force = scene.pairs()[0].force.z;
    assert!((force / PRELOAD - 1.0).abs() < 0.03, "contact force {force}");
    scene
}

/// Returns the largest nodal velocity in 400 steps of `dt`, over the velocity of an initial kick to
/// the touching end.
fn growth(of: &ContactInput, dt: f64, kick: f64) -> f64 {
    // The present step bounds the stiffness; there is no previous one.
    let bounded = of.law == "penalty" && of.parameters.get("penalty_cap") != Some(&false.into());
    let mut scene = rods(of, if bounded { dt } else { 0.1 });
    scene.steps = StepSizes { dt, dt_velocity: dt, dt_damped: dt, dt_stable: dt };
    scene.nodes.v[4 * (CELLS + 1)][2] += kick;
    let mut fastest = 0.0f64;
    for _ in 0..400 {
        scene.step();
        // In an unstable rod all spring forces would soon be NaN.
        fastest = scene.nodes.v.iter().map(|v| v[2].abs()).fold(fastest, f64::max).min(1e6);
        if fastest > 1e3 * kick {
            break;
        }
    }
    fastest / kick
}

fn stiff(beta: f64, cap: bool) -> ContactInput {
    // E A / d of the segment is 4 / (2 sqrt 2).
    let penalty_scale = beta / 2f64.sqrt();
    job("penalty")
        .with("penalty_form", "stiffness")
        .with("penalty_scale", penalty_scale)
        .with("penalty_cap", cap)
}

/// A24, C01: a spring of beta cell stiffnesses between two long rods lowers their stable step to
/// `2 / omega, omega^2 = 2 + 2 sqrt(1 + 4 beta^2)` cells (the mode that decays by
/// `2 beta - sqrt(1 + 4 beta^2)` per cell on each side). Two percent below this step the rods
/// oscillate, two percent above it they are unstable. With the bound on stiffness they are stable
/// with a safety of 0.9 for any requested stiffness.
#[test]
fn a_stiff_penalty_lowers_the_stable_step_as_it_should_and_the_bound_keeps_it() {
    let kick = 1e-6;
    for (beta, listed) in [(0.5, 0.910), (1.0, 0.786), (2.0, 0.625), (10.0, 0.308)] {
        let limit = 2.0 / (2.0 + 2.0 * f64::sqrt(1.0 + 4.0 * beta * beta)).sqrt();
        assert!((limit - listed).abs() < 6e-4, "the value of the catalogue");
        let (below, above) = (
            growth(&stiff(beta, false), 0.98 * limit, kick),
            growth(&stiff(beta, false), 1.02 * limit, kick),
        );
        eprintln!("beta {beta}: limit {limit:.4}, growth {below:.2} below and {above:.0} above");
        // Just below the limit the amplitude of a mode is up to 1 / sqrt(1 - 0.98^2) = 5 times its
        // kick.
        assert!(below < 10.0, "beta {beta}: growth {below} below {limit}");
        assert!(above > 100.0, "beta {beta}: growth only {above} above {limit}");
        let bounded = growth(&stiff(beta, true), 0.9, kick);
        assert!(bounded < 10.0, "beta {beta}: growth {bounded} at 0.9 in spite of the bound");
    }
    assert!(
        growth(&stiff(0.5, false), 0.9, kick) < 10.0
            && growth(&stiff(1.0, false), 0.9, kick) > 100.0,
        "A24 at 0.9"
    );
}

/// Local Lagrange and kinematic contact do not limit the stable step. The kick is large against the
/// residual of the Lagrange law, and the ends bounce.
#[test]
fn lagrange_and_kinematic_contact_do_not_lower_the_stable_step() {
    let gauss_seidel = job("lagrange").with("iteration", "gauss_seidel");
    for of in [job("lagrange"), gauss_seidel, job("kinematic")] {
        let (below, above) = (growth(&of, 0.99, 0.02), growth(&of, 1.02, 0.02));
        assert!(
            below < 10.0 && above > 100.0,
            "{} {:?}: growth {below} below, {above} above",
            of.law,
            of.parameters
        );
    }
}
