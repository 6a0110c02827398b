//! Tests of Coulomb friction: a mass on a plate in slip, in stick and under an alternating pull.

use super::*;

/// A long fixed plate, and a mass on it that is pressed down with force N.
fn pressed(friction: f64, law: &str, velocity: f64, pull: f64, press: f64) -> Scene {
    plate(&ContactInput { friction, ..job(law) }, velocity, pull, press)
}

fn plate(of: &ContactInput, velocity: f64, pull: f64, press: f64) -> Scene {
    let rows = 40;
    let mut points: Vec<NodeRecord> = (0..=rows)
        .flat_map(|i| [-1.0, 1.0].map(|y| held([0.5 * i as f64 - 1.0, y, 0.0])))
        .collect();
    let segments: Vec<[u32; 4]> =
        (0..rows).map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).collect();
    let slave = points.len();
    points.push(mass([0.0, 0.3, THICK], [velocity, 0.0, 0.0], 2.0));
    let mut scene = Scene::new(of, &points, &segments, &[slave as u32], 1e-3);
    scene.load[slave] = V3::new(pull, 0.0, -press);
    scene
}

/// A07: Coulomb friction decelerates a sliding block of mass m under a force N by `mu N / m` until
/// it is at rest. The block sticks under a pull below mu N and slides under a larger one. It passes
/// 20 edges of segments.
#[test]
fn coulomb_friction_slows_holds_and_lets_go() {
    for law in ["lagrange", "kinematic"] {
        slows_holds_and_lets_go(law);
    }
}

fn slows_holds_and_lets_go(law: &str) {
    let (mu, n, m, v) = (0.3, 50.0, 2.0, 10.0);
    let mut scene = pressed(mu, law, v, 0.0, n);
    let block = scene.nodes.len() - 1;
    let slowing = mu * n / m; // 7.5
    for _ in 0..1000 {
        scene.step();
    }
    // v(1) = 10 - 7.5. The force law is exact for a constant load; the error is the tolerance,
    // 1e-3 of a force.
    let expected = v - slowing;
    assert!(
        (scene.v(block).x - expected).abs() < 2e-3 * slowing,
        "{}, expected {expected}",
        scene.v(block).x
    );
    assert!((scene.x(block).x - (v - 0.5 * slowing)).abs() < 2e-2, "{}", scene.x(block).x);
    for _ in 0..1000 {
        scene.step();
    }
    // At rest the residual of the law is 1e-4 of the thickness per step: 1e-4 * 0.1 / 1e-3.
    assert!(scene.v(block).norm() < 0.015, "at rest after 10 / 7.5 = 1.33: {:?}", scene.v(block));
    let way = v * v / (2.0 * slowing);
    assert!((scene.x(block).x / way - 1.0).abs() < 2e-3, "{}, expected {way}", scene.x(block).x);
    assert!((scene.x(block).z - THICK).abs() < 1e-3 * THICK, "on the plate");
    assert!(
        (scene.work + 0.5 * m * v * v).abs() < 1e-3 * m * v * v,
        "friction dissipates all kinetic energy: {}",
        scene.work
    );

    for (pull, moves) in [(0.9, 0.0), (1.1, 0.1)] {
        let mut scene = pressed(mu, law, 0.0, pull * mu * n, n);
        (0..1000).for_each(|_| _ = scene.step());
        let expected = moves * slowing;
        assert!(
            (scene.v(block).x - expected).abs() < 2e-3 * slowing,
            "pull {pull}: {}, expected {expected}",
            scene.v(block).x
        );
    }
}

/// The same with the penalty law, whose stick is a spring: a block in stick oscillates on it.
/// Without the dashpot the block bounces on its spring. Friction acts in every contact from its
/// first step on, so that the result is the same.
#[test]
fn coulomb_friction_of_the_penalty_law() {
    let (mu, n, m, v) = (0.3, 50.0, 2.0, 10.0);
    let damped = |damping: f64| {
        ContactInput { friction: mu, ..job("penalty") }.with("penalty_damping", damping)
    };
    let expected = v - mu * n / m;
    for damping in [0.1, 0.0] {
        let mut scene = plate(&damped(damping), v, 0.0, n);
        let block = scene.nodes.len() - 1;
        (0..1000).for_each(|_| _ = scene.step());
        let left = scene.v(block).x;
        assert!(
            (left - expected).abs() < 1e-2 * mu * n / m,
            "damping {damping}: {left}, expected {expected}"
        );
    }
    let mut scene = plate(&damped(0.1), 0.0, 0.4 * mu * n, n);
    let block = scene.nodes.len() - 1;
    (0..1000).for_each(|_| _ = scene.step());
    assert!((scene.x(block).x).abs() < 1e-2 * THICK, "held: {}", scene.x(block).x);
}

/// A14: a block that slides during the whole contact gets the tangential impulse mu times the
/// normal one. This does not depend on the time within a step at which contact begins, and is valid
/// also if the block starts outside the reach of the pairs.
#[test]
fn friction_of_a_penalty_acts_from_the_first_step_of_a_touch() {
    let mu = 0.3;
    for damping in [0.0, 0.1] {
        for phase in 0..20 {
            let of = ContactInput { friction: mu, ..job("penalty") };
            let of = of.with("penalty_damping", damping);
            let mut scene = plate(&of, 3.0, 0.0, 0.0);
            let block = scene.nodes.len() - 1;
            let (fall, dt) = (1.0, scene.steps.dt);
            scene.nodes.v[block][2] = -fall;
            scene.nodes.x[block][2] += (4.0 + 0.05 * f64::from(phase)) * fall * dt;
            (0..60).for_each(|_| _ = scene.step());
            assert!(
                scene.pairs().is_empty() && scene.v(block).z > 0.5 * fall,
                "the block has separated: {}",
                scene.v(block)
            );
            let ratio = (3.0 - scene.v(block).x) / (scene.v(block).z + fall);
            // Slides at 3 against 0.3: the spring force from the stick point is outside the cone in
            // every step.
            assert!(
                (ratio / mu - 1.0).abs() < 1e-9,
                "damping {damping}, phase {phase}: {ratio}, expected {mu}"
            );
        }
    }
}

/// C09: an alternating pull `1.5 mu N sin(2 pi t / T)`. Friction dissipates `mu N |v|` and never
/// adds energy. In stick the force follows the pull and changes its sign at most once. The block
/// returns to its position.
#[test]
fn friction_follows_a_reversing_pull_without_chatter() {
    let (mu, period) = (0.3, 200);
    let gauss_seidel = job("lagrange").with("iteration", "gauss_seidel");
    let stiff = job("penalty").with("penalty_form", "stiffness").with("penalty_scale", 1e6);
    for of in [job("lagrange"), gauss_seidel, job("kinematic"), job("penalty"), stiff] {
        let name = format!("{} {:?}", of.law, of.parameters);
        // Lagrange: so large that its residual, 1e-4 of the thickness per step, is 0.25 % of mu N.
        // Penalty: so small that the penetration is a third of the thickness.
        let n = if of.law == "penalty" { 2e3 / mu } else { 8e3 / mu };
        let mut scene = plate(&ContactInput { friction: mu, ..of.clone() }, 0.0, 0.0, n);
        let block = scene.nodes.len() - 1;
        scene.nodes.x[block][0] = 9.0; // midway
        scene.run_damped(400, 0.1);
        let dt = scene.steps.dt;
        let (mut dissipated, mut expected, mut means) = (0.0, 0.0, Vec::new());
        let mut widest = (f64::INFINITY, f64::NEG_INFINITY);
        // Sign of the force in stick: steps since its last change, changes in this phase.
        let (mut last_sign, mut since, mut changes, mut quickest, mut most) =
            (0.0, 0, 0, usize::MAX, 0);
        for _ in 0..20 {
            let mut mean = 0.0;
            for step in 0..period {
                let pull =
                    1.5 * mu * n * (std::f64::consts::TAU * step as f64 / period as f64).sin();
                scene.load[block].x = pull;
                let work = scene.step();
                let v = scene.v(block).x;
                dissipated -= work.friction.total();
                mean += scene.x(block).x / period as f64;
                widest = (scene.x(block).x.min(widest.0), scene.x(block).x.max(widest.1));
                let force = scene.pairs()[0].force.x;
                // In stick with the penalty law the block oscillates on its spring without loss.
                if force.abs() > 0.99 * mu * scene.pairs()[0].force.z {
                    expected += mu * n * v.abs() * dt;
                }
                if pull.abs() < mu * n && v.abs() < 0.1 {
                    since += 1;
                    if last_sign * force < 0.0 {
                        (quickest, since, changes) = (quickest.min(since), 0, changes + 1);
                    }
                    last_sign = force.signum();
                } else {
                    most = most.max(changes);
                    (last_sign, since, changes) = (0.0, 0, 0);
                }
            }
            means.push(mean);
        }
        let amplitude = 0.5 * (widest.1 - widest.0);
        let drift = (means[19] - means[1]).abs();
        eprintln!(
            "{name}: friction dissipates {dissipated:.4} of {expected:.4}, drift {drift:.2e} of \
             {amplitude:.3}, {most} changes"
        );
        assert!(
            (dissipated / expected - 1.0).abs() < 5e-3,
            "{name}: {dissipated}, expected {expected}"
        );
        assert!(drift < 0.01 * amplitude, "{name}: drifts by {drift} of {amplitude}");
        if of.law == "penalty" {
            // A block on its stick spring oscillates about the pull in about 20 steps or more.
            assert!(quickest > 4, "{name}: the force reverses after {quickest} steps");
        } else {
            assert!(most <= 1, "{name}: {most} changes of sign while it sticks");
        }
    }
}

/// A stick point remains through steps in which its pair has no force but stays in contact. It is
/// lost if the slave separates or slides away.
#[test]
fn a_stick_point_lasts_through_a_step_without_force() {
    for law in ["lagrange", "kinematic"] {
        let mut scene = pressed(0.3, law, 0.0, 1.0, 50.0);
        scene.step();
        let (law, steps) = (scene.contact.laws().of_pair(&scene.pairs()[0]), scene.steps);
        let little = V3::x() * (1e-6 * THICK);
        let idle = Pair { force: V3::zeros(), slip: little, gap: 0.0, ..scene.pairs()[0] };
        let after = |pair: &Pair, way: V3| law.slip(pair, &(way / steps.dt), steps);
        assert_eq!(after(&idle, V3::zeros()), little, "stays");
        assert!(
            (after(&idle, little) - little * 2.0).norm() < 1e-15,
            "a moving node leaves the stick point behind"
        );
        assert_eq!(after(&idle, V3::z() * (1e-3 * THICK)), V3::zeros(), "lifted off");
        assert_eq!(after(&idle, V3::x() * (1e-3 * THICK)), V3::zeros(), "slid away");
    }
}
