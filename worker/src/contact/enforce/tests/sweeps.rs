//! How fast sweeps bring the forces of pairs that feel each other into agreement, and when they do not.

use super::*;

fn lagrange(iteration: &str, sweeps: usize) -> ContactJob {
    ContactJob { iteration: iteration.into(), sweeps, tolerance: 0.0, ..job("lagrange") }
}

/// n nodes of mass m land together on the centre of a segment of equal nodal masses M. Simultaneous updates with full
/// masses multiply the error by `-(n-1) (1/4M) / (1/m + 1/4M)` per sweep (the coupling of a pair with the others over
/// its own compliance). Above 1 they overshoot to and fro and never end; masses split among their pairs, and pairs that
/// take turns, end for all of them.
#[test]
fn full_masses_diverge_by_the_known_factor_and_the_others_converge() {
    for (n, m, segment) in [(2, 1.0, 1.0), (5, 1.0, 1.0), (5, 4.0, 1.0), (10, 10.0, 1.0), (4, 1.0, 1e3)] {
        let (v, dt) = (10.0, 1e-3);
        let mut points = square([segment; 4]);
        points.extend((0..n).map(|_| mass([0.0, 0.0, THICK], [0.0, 0.0, -v], m)));
        let slaves: Vec<u32> = (4..4 + n as u32).collect();
        let run = |iteration: &str, sweeps: usize| {
            let mut scene = Scene::new(&lagrange(iteration, sweeps), &points, &[[0, 1, 2, 3]], &slaves, dt);
            scene.step();
            scene
        };
        // All end with the common velocity of a plastic impact.
        let common = n as f64 * m * v / (n as f64 * m + 4.0 * segment);
        let exact = m * (v - common) / dt;
        let error = |iteration: &str, sweeps: usize| {
            let scene = run(iteration, sweeps);
            scene.pairs().iter().map(|p| p.force.z - exact).fold(0.0, |w: f64, e| if e.abs() > w.abs() { e } else { w })
        };

        let factor = (n as f64 - 1.0) * (0.25 / segment) / (1.0 / m + 0.25 / segment);
        // Before the first sweep no force is there. Forces that may not pull hide the factor once it is above 1.
        let mut before = -exact;
        for sweeps in 1..if factor > 1.0 { 2 } else { 5 } {
            let after = error("jacobi", sweeps);
            // Few sweeps reach what the law leaves, 1e-4 of the thickness per step, 1e-3 of the approach.
            if after.abs() < 0.01 * exact {
                break;
            }
            let measured = -after / before;
            assert!((measured / factor - 1.0).abs() < 1e-9, "{n} nodes of {m} on {segment}: {measured}, not {factor}");
            before = after;
        }
        let many = run("jacobi", 200);
        assert_eq!(many.contact.sweeps == 200, factor > 1.0, "{n} of {m} on {segment}: {} sweeps", many.contact.sweeps);
        assert_eq!(error("jacobi", 200).abs() > 0.5 * exact, factor > 1.0, "{n} of {m} on {segment}");

        for (iteration, most) in [("split", 4), ("gauss_seidel", 200)] {
            let scene = run(iteration, 200);
            // The law leaves 1e-4 of the contact thickness of the gap per step and pair: 1e-4 * 0.1 / 1e-3 = 0.01 of 10.
            for i in 0..scene.nodes.len() {
                assert!(
                    (scene.v(i).z + common).abs() < 0.011,
                    "{iteration}, node {i}: {}, not {}",
                    scene.v(i).z,
                    -common
                );
            }
            let initial = n as f64 * m * v;
            assert!((scene.momentum().z / -initial - 1.0).abs() < 1e-12, "round-off");
            assert!(scene.contact.sweeps <= most, "{iteration}: {} sweeps", scene.contact.sweeps);
            eprintln!(
                "{n} of {m} on {segment}: jacobi factor {factor:.3}, {iteration} {} sweeps",
                scene.contact.sweeps
            );
        }
    }
}

/// Bodies of the given masses in a row that touch, in turn a plate of four nodes and a node on its centre, so that each
/// acts as one mass. The last one comes with velocity `v` upon the others at rest. Returns the largest error of a
/// pair's force after so many sweeps, as a fraction of the largest force.
fn row_error(iteration: &str, masses: &[f64], sweeps: usize) -> f64 {
    // The law leaves 1e-4 of the thickness per step, 1e-8 of the way that this speed makes in it.
    let (v, dt) = (1e6, 1e-3);
    let (mut points, mut segments, mut slaves) = (Vec::new(), Vec::new(), Vec::new());
    for (i, &m) in masses.iter().enumerate() {
        let (z, speed) = (i as f64 * THICK, if i + 1 == masses.len() { -v } else { 0.0 });
        let first = points.len() as u32;
        if i % 2 == 0 {
            let plate = square([0.25 * m; 4]);
            points.extend(plate.iter().map(|p| mass([p.x[0], p.x[1], z], [0.0, 0.0, speed], p.mass)));
            segments.push([first, first + 1, first + 2, first + 3]);
        } else {
            points.push(mass([0.0, 0.0, z], [0.0, 0.0, speed], m));
            slaves.push(first);
        }
    }
    let mut scene = Scene::new(&lagrange(iteration, sweeps), &points, &segments, &slaves, dt);
    scene.step();
    assert_eq!(scene.pairs().len(), masses.len() - 1, "each touches the next");
    // Plastic impact: all below the struck one are brought to the common velocity by what the pair above them passes on.
    let common = v * masses[masses.len() - 1] / masses.iter().sum::<f64>();
    let exact: Vec<f64> = (1..masses.len()).map(|j| masses[..j].iter().sum::<f64>() * common / dt).collect();
    // Pairs in ascending (node, segment) are those of the row from below.
    let off = scene.pairs().iter().zip(&exact).map(|(p, f)| (p.force.norm() - f).abs());
    off.fold(0.0, f64::max) / exact[exact.len() - 1]
}

/// C15: Gauss-Seidel on n equal masses in a row has the spectral radius `cos^2(pi/n)`; on a light layer between two heavy
/// ones `1 / (1 + mu/m)^2`. Sweeps to an error of 1e-6: 10, 33, 138 and 73, 695 in the catalogue.
#[test]
fn sweeps_in_order_converge_by_the_known_spectral_radii() {
    let row = |n: usize| (vec![1.0; n], (std::f64::consts::PI / n as f64).cos().powi(2));
    let layer = |mu: f64| (vec![1.0, mu, 1.0], (1.0 + mu).powi(-2));
    for (masses, radius) in [row(3), row(5), row(10), layer(0.1), layer(0.01)] {
        let needed = 1e-6f64.ln() / radius.ln();
        let late = (0.8 * needed) as usize;
        let measured = row_error("gauss_seidel", &masses, late + 1) / row_error("gauss_seidel", &masses, late);
        // Other modes have died out by then, but for the smallest problem in the fewest sweeps.
        assert!((measured - radius).abs() < 0.01 * radius, "{masses:?}: {measured} and not {radius}");
        let counted = (1..).find(|&k| row_error("gauss_seidel", &masses, k) < 1e-6).unwrap();
        eprintln!("{masses:?}: radius {measured:.4} ({radius:.4}), {counted} sweeps ({needed:.0}) to 1e-6");
        // The radius tells of sweeps as they follow each other; the first ones take what is not of the slowest mode.
        assert!((counted as f64 - needed).abs() < 0.1 * needed + 1.0, "{masses:?}: {counted} sweeps and not {needed}");
        // Split masses converge too, more slowly: with two users of each inner mass `(1 + rho) / 2`, rho Jacobi's radius.
        let split = row_error("split", &masses, late + 1) / row_error("split", &masses, late);
        assert!(split < 1.0 && split > radius, "{masses:?}: {split}");
    }
}

/// C15: with too few sweeps for a light node between two heavy plates the plates sink in, and it shows; the node stays
/// between them. Gauss-Seidel takes no energy from anywhere. Split masses, whose remembered forces go on pushing when they
/// should long have ended, do: they must be given sweeps.
#[test]
fn too_few_sweeps_leave_penetration_that_shows() {
    let energy = |iteration: &str, sweeps: usize| {
        let at =
            |z: f64, v: f64| square([1.0; 4]).into_iter().map(move |p| mass([p.x[0], p.x[1], z], [0.0, 0.0, v], 1.0));
        let points: Vec<_> = at(-THICK, 1.0).chain(at(THICK, -1.0)).chain([mass([0.0; 3], [0.0; 3], 0.004)]).collect();
        let job = ContactJob { sweeps, iteration: iteration.into(), ..job("lagrange") };
        let mut scene = Scene::new(&job, &points, &[[0, 1, 2, 3], [4, 5, 6, 7]], &[8], 1e-3);
        let before = scene.energy();
        let mut most = before;
        for _ in 0..200 {
            scene.step();
            most = most.max(scene.energy());
            assert!(scene.x(0).z < scene.x(8).z && scene.x(8).z < scene.x(4).z, "{iteration}: expelled");
        }
        assert!(scene.momentum().norm() < 1e-12 * 8.0, "{iteration}: round-off");
        eprintln!(
            "{iteration}, {sweeps} sweeps: energy {:.4} at most, {:.2e} deep",
            most / before,
            scene.contact.penetration
        );
        assert_eq!(scene.contact.penetration > 0.05, sweeps < 100, "{iteration}: {}", scene.contact.penetration);
        most / before
    };
    assert!(energy("gauss_seidel", 10) < 1.0 + 1e-12);
    for iteration in ["split", "gauss_seidel"] {
        assert!(energy(iteration, 20_000) < 1.0 + 1e-12, "{iteration}");
    }
    energy("split", 10);
}

/// Penetration is taken out at one speed whatever the step: 4e-5 of the wave speed.
#[test]
fn penetration_is_taken_out_at_a_speed_whatever_the_step() {
    for dt in [1e-3, 1e-5] {
        let mut points = square([1.0; 4]);
        points.push(mass([0.0, 0.0, THICK], [0.0; 3], 1.0));
        let steps = Steps { dt, mid: dt, push: dt, whole: dt };
        let pair = |law: &str| {
            let mut scene = Scene::new(&job(law), &points, &[[0, 1, 2, 3]], &[4], dt);
            scene.load[4].z = -1.0;
            scene.step();
            (Pair { force: V3::zeros(), gap: -0.1 * THICK, ..scene.pairs()[0] }, scene)
        };
        let (p, scene) = pair("lagrange");
        let force = scene.contact.laws.of_pair(&p).update(&p, &V3::zeros(), steps).expect("deep");
        let lagrange = force.z * p.compliance[0] * dt;
        let (p, scene) = pair("kinematic");
        let kinematic = scene.contact.laws.of_pair(&p).guess(&p, &V3::zeros(), steps).z / p.mass * dt;
        for (law, speed) in [("lagrange", lagrange), ("kinematic", kinematic)] {
            assert!((speed / (4e-5 * SPEED) - 1.0).abs() < 1e-9, "{law}, step {dt}: {speed}");
        }
    }
}
