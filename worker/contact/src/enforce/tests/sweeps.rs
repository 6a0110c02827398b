//! Tests of the convergence of sweeps for coupled pairs.

use super::*;
use crate::enforce::{ContactLaw, InterfaceLaw};
use std::sync::Mutex;

fn lagrange(iteration: &str, sweeps: i64) -> ContactInput {
    job("lagrange")
        .with("iteration", iteration)
        .with("sweeps", sweeps)
        .with("accelerated", 0)
        .with("tolerance", 0.0)
}

/// n nodes of mass m hit the centre of a segment of equal nodal masses M at the same time.
/// Simultaneous updates with full masses would multiply the error by
/// `-(n-1) (1/4M) / (1/m + 1/4M)` per sweep, which is above 1 for most of these cases. Masses split
/// among their pairs, and updates of one pair after the other, converge for all of them.
#[test]
fn many_nodes_on_one_segment_settle() {
    for (n, m, segment) in
        [(2, 1.0, 1.0), (5, 1.0, 1.0), (5, 4.0, 1.0), (10, 10.0, 1.0), (4, 1.0, 1e3)]
    {
        let (v, dt) = (10.0, 1e-3);
        let mut points = square([segment; 4]);
        points.extend((0..n).map(|_| mass([0.0, 0.0, THICK], [0.0, 0.0, -v], m)));
        let slaves: Vec<u32> = (4..4 + n as u32).collect();
        // All end with the common velocity of a plastic impact.
        let common = n as f64 * m * v / (n as f64 * m + 4.0 * segment);
        for (iteration, most) in [("split", 4), ("gauss_seidel", 200)] {
            let mut scene =
                Scene::new(&lagrange(iteration, 200), &points, &[[0, 1, 2, 3]], &slaves, dt);
            scene.step();
            // The residual gap of the law is 1e-10 of the contact thickness per step and pair.
            for i in 0..scene.nodes.len() {
                let z = scene.v(i).z;
                assert!(
                    (z + common).abs() < 1e-6,
                    "{iteration}, node {i}: {z}, expected {}",
                    -common
                );
            }
            let initial = n as f64 * m * v;
            assert!((scene.momentum().z / -initial - 1.0).abs() < 1e-12, "round-off");
            assert!(scene.contact.sweeps <= most, "{iteration}: {} sweeps", scene.contact.sweeps);
            eprintln!("{n} of {m} on {segment}: {iteration} {} sweeps", scene.contact.sweeps);
        }
    }
}

/// A row of touching bodies with the given masses, alternately a plate of four nodes and a node on
/// its centre, so that each acts as one mass. The last one hits the others, which are at rest, with
/// velocity `v`. Returns the largest error of a pair force after this number of sweeps, as a
/// fraction of the largest force.
fn row_error(iteration: &str, masses: &[f64], sweeps: i64) -> f64 {
    row_of(&lagrange(iteration, sweeps), masses).0
}

/// Returns the same error for any law, and the number of sweeps.
fn row_of(job: &ContactInput, masses: &[f64]) -> (f64, u64) {
    // Residual gaps of the law are small against the displacement of a step at this speed.
    let (v, dt) = (1e6, 1e-3);
    let (mut points, mut segments, mut slaves) = (Vec::new(), Vec::new(), Vec::new());
    for (i, &m) in masses.iter().enumerate() {
        let (z, speed) = (i as f64 * THICK, if i + 1 == masses.len() { -v } else { 0.0 });
        let first = points.len() as u32;
        if i % 2 == 0 {
            let plate = square([0.25 * m; 4]);
            points
                .extend(plate.iter().map(|p| mass([p.x[0], p.x[1], z], [0.0, 0.0, speed], p.mass)));
            segments.push([first, first + 1, first + 2, first + 3]);
        } else {
            points.push(mass([0.0, 0.0, z], [0.0, 0.0, speed], m));
            slaves.push(first);
        }
    }
    let mut scene = Scene::new(job, &points, &segments, &slaves, dt);
    scene.step();
    assert_eq!(scene.pairs().len(), masses.len() - 1, "each node touches the next");
    // Plastic impact: the force of each pair accelerates all bodies below it to the common
    // velocity.
    let common = v * masses[masses.len() - 1] / masses.iter().sum::<f64>();
    let exact: Vec<f64> =
        (1..masses.len()).map(|j| masses[..j].iter().sum::<f64>() * common / dt).collect();
    // Pairs in ascending order of (node, segment) follow the row from below.
    let off = scene.pairs().iter().zip(&exact).map(|(p, f)| (p.force.norm() - f).abs());
    (off.fold(0.0, f64::max) / exact[exact.len() - 1], scene.contact.sweeps)
}

/// Light layers between heavy ones, with mass ratios from 1 to 1 down to 1 to 10,000. Accelerated
/// sweeps converge within a bound that does not depend on the masses, for any iteration. A layer of
/// n light bodies has n + 1 different rates of convergence.
#[test]
fn accelerated_sweeps_settle_whatever_the_masses() {
    // With split masses, 80 sweeps with momentum come first.
    for (law, most, slow) in
        [(lagrange("gauss_seidel", 20), 50, 0.05), (lagrange("split", 20), 90, 5e-4)]
    {
        let law = law.with("tolerance", 1e-9).with("accelerated", 100);
        for ratio in [1.0, 1e-1, 1e-2, 1e-3, 1e-4] {
            for light in [1, 2, 3, 5] {
                let masses: Vec<f64> =
                    [1.0].into_iter().chain(vec![ratio; light]).chain([1.0]).collect();
                let (error, sweeps) = row_of(&law, &masses);
                let plain = row_of(&law.clone().with("accelerated", 0), &masses).0;
                eprintln!(
                    "{} {:?}, {light} of {ratio}: error {error:.1e} in {sweeps} sweeps, \
                     {plain:.1e} without acceleration",
                    law.law, law.parameters
                );
                assert!(error < 1e-5, "{law:?}, {masses:?}: {error}");
                assert!(sweeps < most, "{law:?}, {masses:?}: {sweeps}");
                assert!(
                    plain > 0.5 || ratio > slow,
                    "{law:?}, {masses:?}: plain sweeps converge too, {plain}"
                );
            }
        }
    }
}

/// A law without a solution: a sweep turns the force x of a pair into `x + r(x)`, and r has a least
/// value but no root, whatever the motion.
struct Rootless {
    /// Forces before the sweeps so far.
    seen: Arc<Mutex<Vec<f64>>>,
    accelerated: usize,
}

impl Rootless {
    fn residual(x: f64) -> f64 {
        0.05 + 0.1 * (x - 3.0) * (x - 3.0)
    }
}

impl ContactLaw for Rootless {
    fn sweeps(&self) -> usize {
        2
    }

    fn iteration(&self) -> Iteration {
        Iteration::GaussSeidel
    }

    fn converges(&self) -> bool {
        true
    }

    fn accelerated(&self) -> usize {
        self.accelerated
    }

    fn initial_force(&self, pair: &Pair, _: StepSizes) -> V3 {
        pair.normal
    }

    fn update(&self, pair: &Pair, _: &V3, _: StepSizes) -> Option<V3> {
        let x = pair.force.dot(&pair.normal);
        self.seen.lock().unwrap().push(x);
        Some(pair.normal * (x + Self::residual(x)))
    }

    fn slip(&self, _: &Pair, _: &V3, _: StepSizes) -> V3 {
        V3::zeros()
    }
}

/// Accelerated sweeps that do not settle end with the last forces whose residual is near the least
/// one. Here the extrapolation goes far away again and again.
#[test]
fn sweeps_that_do_not_settle_end_with_their_best_forces() {
    let mut lost = 0;
    // More sweeps would end beyond the range of numbers.
    for accelerated in 2..16_usize {
        // Without a tolerance no accelerated sweeps follow.
        let job = lagrange("gauss_seidel", 2)
            .with("accelerated", accelerated as i64)
            .with("tolerance", 1e-9);
        let mut points = square([1.0; 4]);
        points.push(mass([0.0, 0.0, THICK], [0.0, 0.0, -1.0], 1.0));
        let mut scene = Scene::new(&job, &points, &[[0, 1, 2, 3]], &[4], 1e-3);
        let seen = Arc::new(Mutex::new(Vec::new()));
        let law = Rootless { seen: seen.clone(), accelerated };
        scene.contact.laws.0[0].of[0] = Some(InterfaceLaw::new(Box::new(law)));
        scene.step();
        let seen = seen.lock().unwrap();
        // The plain sweeps come first.
        let seen = &seen[seen.len() - accelerated..];
        let residuals = || seen.iter().map(|x| Rootless::residual(*x));
        let least = residuals().fold(f64::INFINITY, f64::min);
        let last = residuals().rposition(|residual| residual <= 2.0 * least);
        let best = seen[last.expect("a sweep")];
        lost += usize::from(best != seen[accelerated - 1]);
        let pair = &scene.pairs()[0];
        let wanted = best + Rootless::residual(best);
        let found = pair.force.dot(&pair.normal);
        assert!((found - wanted).abs() < 1e-12 * wanted, "{found} of {seen:?}");
    }
    assert!(lost > 5, "the last sweep is not the best one in {lost} of 14 runs");
}

/// C15: Gauss-Seidel on n equal masses in a row has the spectral radius `cos^2(pi/n)`, and
/// `1 / (1 + mu/m)^2` on a light layer between two heavy ones. Sweeps to an error of 1e-6: 10, 33,
/// 138 and 73, 695 in the catalogue.
#[test]
fn sweeps_in_order_converge_by_the_known_spectral_radii() {
    let row = |n: usize| (vec![1.0; n], (std::f64::consts::PI / n as f64).cos().powi(2));
    let layer = |mu: f64| (vec![1.0, mu, 1.0], (1.0 + mu).powi(-2));
    for (masses, radius) in [row(3), row(5), row(10), layer(0.1), layer(0.01)] {
        let needed = 1e-6f64.ln() / radius.ln();
        let late = (0.8 * needed) as i64;
        let measured =
            row_error("gauss_seidel", &masses, late + 1) / row_error("gauss_seidel", &masses, late);
        // Other modes have decayed by then, except in the smallest problem with the fewest sweeps.
        assert!(
            (measured - radius).abs() < 0.01 * radius,
            "{masses:?}: {measured}, expected {radius}"
        );
        let counted = (1..).find(|&k| row_error("gauss_seidel", &masses, k) < 1e-6).unwrap();
        eprintln!(
            "{masses:?}: radius {measured:.4} ({radius:.4}), {counted} sweeps ({needed:.0}) to 1e-6"
        );
        // The radius is the ratio of successive sweeps. The first sweeps remove the faster modes.
        assert!(
            (counted as f64 - needed).abs() < 0.1 * needed + 1.0,
            "{masses:?}: {counted} sweeps, expected {needed}"
        );
        // With split masses and two users of each inner mass, the radius of plain sweeps is `(1 +
        // rho) / 2` with the radius rho of Jacobi, `cos(pi/n)` or `1 / (1 + mu/m)`. With momentum
        // the number of sweeps is in proportion to the root of its condition number.
        let condition = 2.0 / (1.0 - radius.sqrt());
        let split = 4 * (1..).find(|&k| row_error("split", &masses, k) < 1e-6).unwrap();
        eprintln!("split: {split} sweeps, condition number {condition:.0}");
        let scaled = split as f64 / condition.sqrt();
        assert!((6.0..24.0).contains(&scaled), "{masses:?}: {split} sweeps, {scaled}");
    }
}

/// C15: a light node between two heavy plates with too few sweeps. The plates penetrate, and this
/// is reported; the node stays between them, and no sweeps add energy.
#[test]
fn too_few_sweeps_leave_penetration_that_shows() {
    let energy = |iteration: &str, sweeps: i64| {
        let at = |z: f64, v: f64| {
            square([1.0; 4]).into_iter().map(move |p| mass([p.x[0], p.x[1], z], [0.0, 0.0, v], 1.0))
        };
        let points: Vec<_> = at(-THICK, 1.0)
            .chain(at(THICK, -1.0))
            .chain([mass([0.0; 3], [0.0; 3], 0.004)])
            .collect();
        let job = lagrange(iteration, sweeps).with("tolerance", 1e-6);
        let mut scene = Scene::new(&job, &points, &[[0, 1, 2, 3], [4, 5, 6, 7]], &[8], 1e-3);
        let before = scene.energy();
        let mut most = before;
        for _ in 0..200 {
            scene.step();
            most = most.max(scene.energy());
            assert!(
                scene.x(0).z < scene.x(8).z && scene.x(8).z < scene.x(4).z,
                "{iteration}: the bodies changed sides"
            );
        }
        assert!(scene.momentum().norm() < 1e-12 * 8.0, "{iteration}: round-off");
        eprintln!(
            "{iteration}, {sweeps} sweeps: energy {:.4} at most, penetration {:.2e}",
            most / before,
            scene.contact.penetration
        );
        assert_eq!(
            scene.contact.penetration > 0.05,
            sweeps < 100,
            "{iteration}: {}",
            scene.contact.penetration
        );
        most / before
    };
    // 20 sweeps with momentum.
    for (iteration, few) in [("split", 5), ("gauss_seidel", 10)] {
        assert!(energy(iteration, few) < 1.0 + 1e-12, "{iteration}");
    }
    for iteration in ["split", "gauss_seidel"] {
        assert!(energy(iteration, 20_000) < 1.0 + 1e-12, "{iteration}");
    }
}

/// C15 (a): for any size of the first step, the light plate stays between the heavy ones. All are
/// at rest except for the speed at which penetration is removed.
#[test]
fn a_light_plate_between_heavy_ones_is_at_rest_with_them() {
    for iteration in ["split", "gauss_seidel"] {
        for (ratio, dt) in [(1e-2, 1e-3), (1e-3, 1e-3), (1e-4, 1e-3), (1e-3, 0.04)] {
            let at = |z: f64, side: f64, v: f64, m: f64| {
                square([m; 4])
                    .into_iter()
                    .map(move |p| mass([side * p.x[0], side * p.x[1], z], [0.0, 0.0, v], m))
            };
            let reach = 1.05 * THICK;
            let plates = [
                at(-reach, 1.0, 1.0, 0.25),
                at(0.0, 0.25, 0.0, 0.25 * ratio),
                at(reach, 1.0, -1.0, 0.25),
            ];
            let points: Vec<_> = plates.into_iter().flatten().collect();
            let segments = [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]];
            let job = job("lagrange").with("iteration", iteration);
            let slaves: Vec<u32> = (0..12).collect();
            let mut scene = Scene::new(&job, &points, &segments, &slaves, dt);
            for _ in 0..100 {
                scene.step();
            }
            let case = format!("{iteration}, 1 to {ratio}, step {dt}");
            let fastest = (0..12).map(|i| scene.v(i).norm()).fold(0.0, f64::max);
            let [steps, open] = scene.contact.unsettled;
            eprintln!(
                "{case}: {fastest:.2e}, {steps} steps accelerated, {open} open, penetration {:.1e}",
                scene.contact.penetration
            );
            assert!(fastest < 4e-5 * SPEED * 1.001, "{case}: {fastest}");
            assert!(
                scene.x(0).z < scene.x(4).z && scene.x(4).z < scene.x(8).z,
                "{case}: the bodies changed sides"
            );
            assert!(steps > 0 && open == 0, "{case}: {steps} steps accelerated, {open} open");
            assert!(scene.contact.penetration < 1e-3, "{case}: {}", scene.contact.penetration);
        }
    }
}

/// Penetration is removed at the same speed for any step size: 4e-5 of the wave speed.
#[test]
fn penetration_is_taken_out_at_a_speed_whatever_the_step() {
    for dt in [1e-3, 1e-5] {
        let mut points = square([1.0; 4]);
        points.push(mass([0.0, 0.0, THICK], [0.0; 3], 1.0));
        let steps = StepSizes { dt, dt_velocity: dt, dt_damped: dt, dt_stable: dt };
        let pair = |law: &str| {
            let mut scene = Scene::new(&job(law), &points, &[[0, 1, 2, 3]], &[4], dt);
            scene.load[4].z = -1.0;
            scene.step();
            (Pair { force: V3::zeros(), gap: -0.1 * THICK, ..scene.pairs()[0] }, scene)
        };
        let (p, scene) = pair("lagrange");
        let force = scene.contact.laws().of_pair(&p).update(&p, &V3::zeros(), steps).expect("deep");
        let lagrange = force.z * p.compliance[0] * dt;
        let (p, scene) = pair("kinematic");
        let kinematic =
            scene.contact.laws().of_pair(&p).guess(&p, &V3::zeros(), steps).z / p.slave_mass * dt;
        for (law, speed) in [("lagrange", lagrange), ("kinematic", kinematic)] {
            assert!((speed / (4e-5 * SPEED) - 1.0).abs() < 1e-9, "{law}, step {dt}: {speed}");
        }
    }
}
