//! Friction acts on surfaces, at half a thickness from the nodes. It rotates the nodes, and no
//! unbalanced couple remains.

use super::*;

/// Returns a node with this rotational inertia.
fn turning(node: NodeRecord, inertia: f64) -> NodeRecord {
    NodeRecord { inertia, ..node }
}

/// Two plates that meet while they slide. All nodes are slaves of the segment of the other plate.
fn plates(of: &ContactInput, low: [f64; 4], high: [f64; 4], inertia: [f64; 2]) -> Scene {
    let v = V3::new(0.7, -0.2, 1.0);
    let lower = square(low)
        .into_iter()
        .map(|p| turning(NodeRecord { v: v.into(), ..p }, inertia[0] * p.mass));
    let upper = square(high).into_iter().map(|p| {
        let at = mass([p.x[0] + 0.1, p.x[1] - 0.05, THICK], (-v).into(), p.mass);
        turning(at, inertia[1] * p.mass)
    });
    let points: Vec<NodeRecord> = lower.chain(upper).collect();
    Scene::new(of, &points, &[[0, 1, 2, 3], [4, 5, 6, 7]], &[0, 1, 2, 3, 4, 5, 6, 7], 1e-3)
}

fn spins(scene: &Scene) -> impl Iterator<Item = (f64, V3)> {
    scene.nodes.inertia.iter().copied().zip(scene.nodes.w.iter().map(|w| V3::from(xyz(w))))
}

/// Returns angular momentum and kinetic energy, including nodal spins.
fn angular(scene: &Scene) -> V3 {
    scene.spin() + spins(scene).map(|(i, w)| i * w).sum::<V3>()
}

fn energy(scene: &Scene) -> f64 {
    scene.energy() + spins(scene).map(|(i, w)| 0.5 * i * w.norm_squared()).sum::<f64>()
}

/// Laws whose shares act at the contact point. Shares by mass do not conserve angular momentum,
/// with or without friction.
fn fair_laws() -> impl Iterator<Item = (String, ContactInput)> {
    all_laws()
        .into_iter()
        .filter(|(_, c)| c.weighting != "mass")
        .map(|(n, c)| (n, ContactInput { friction: 0.3, ..c }))
}

/// A29: friction conserves angular momentum to round-off, for rotations on either side. The
/// dissipated energy is in the ledger, and friction adds no energy.
#[test]
fn friction_keeps_angular_momentum() {
    // Square of the radius of gyration, from a thin section to a wide element.
    for inertia in [[THICK * THICK / 12.0, 1e-3], [0.01, 0.1], [0.01, 0.0], [0.0, 0.01]] {
        for (name, of) in fair_laws() {
            let name = format!("{name} {inertia:?}");
            let mut scene = plates(&of, [1.0, 3.0, 0.2, 5.0], [2.0, 0.5, 4.0, 1.0], inertia);
            let (before, first, had) = (angular(&scene), scene.momentum(), energy(&scene));
            let size: f64 = scene.sum(|m, x, v| m * x.norm() * v.norm());
            let (mut rubbed, mut most) = (0.0, had);
            for _ in 0..50 {
                rubbed += scene.step().friction.total();
                most = energy(&scene).max(most);
            }
            // With the penalty law stick is a spring, which returns its energy.
            assert!(
                of.law == "penalty" || rubbed < 1e-6 * had,
                "{name}: friction adds no energy, {rubbed} of {had}"
            );
            assert!(spins(&scene).any(|(_, w)| w.norm() > 1e-3), "{name}: the nodes rotate");
            // Round-off of 50 steps with about ten sums each.
            assert!(
                (scene.momentum() - first).norm() < 5e-12 * size,
                "{name}: {}",
                scene.momentum() - first
            );
            assert!(
                (angular(&scene) - before).norm() < 5e-12 * size,
                "{name}: {}",
                angular(&scene) - before
            );
            assert!(
                (energy(&scene) - had - scene.work).abs() < 1e-12 * had,
                "{name}: energy balance"
            );
            let doubt = if of.law == "penalty" { 0.05 } else { 1e-9 };
            assert!(most < had * (1.0 + doubt), "{name}: {most} of {had}");
        }
    }
}

/// In stick the relative velocity of the touching surfaces is zero. The impulse is that of a rod
/// with both inertias, `v / (1/m + a^2/I + sum_k N_k^2 (1/M + b^2/J))`. The lever arm is half a
/// thickness on each side.
#[test]
fn what_sticks_does_so_at_the_surface() {
    let (m, inertia, dt) = (1.5, 2e-3, 1e-3);
    let (node, turns) = (0.8, 3e-3);
    for of in [("lagrange", "split"), ("lagrange", "gauss_seidel"), ("kinematic", "split")] {
        let job = ContactInput { friction: 2.0, ..job(of.0) };
        let job = job.with("sweeps", 500).with("tolerance", 0.0);
        let job = job.with("partition", 1.0).with("iteration", of.1);
        let mut points: Vec<NodeRecord> =
            square([node; 4]).into_iter().map(|p| turning(p, turns)).collect();
        points.push(turning(mass([0.3, -0.4, THICK], [2.0, 1.0, -10.0], m), inertia));
        let mut scene = Scene::new(&job, &points, &[[0, 1, 2, 3]], &[4], dt);
        let before = angular(&scene);
        scene.step();
        let pair = scene.pairs()[0];
        assert!(
            (pair.lever_arms[0] - HALF).abs() < 1e-15 && (pair.lever_arms[1] - HALF).abs() < 1e-15,
            "{:?}",
            pair.lever_arms
        );
        let spin = |i: usize| V3::from(xyz(&scene.nodes.w[i]));
        let arm = V3::z() * HALF;
        let slave = scene.v(4) - spin(4).cross(&arm);
        let plate: V3 =
            (0..4).map(|k| (scene.v(k) + spin(k).cross(&arm)) * pair.shape[k + 1]).sum();
        let name = format!("{} {}", of.0, of.1);
        assert!((slave - plate).norm() < 1e-6, "{name}: slides with {}", slave - plate);
        let squares: f64 = pair.shape[1..5].iter().map(|n| n * n).sum();
        let rod = 1.0 / m + HALF * HALF / inertia + squares * (1.0 / node + HALF * HALF / turns);
        let impulse = pair.force * dt;
        assert!((impulse.xy().norm() * rod / 5f64.sqrt() - 1.0).abs() < 1e-6, "{name}: {impulse}");
        assert!((angular(&scene) - before).norm() < 1e-13 * before.norm(), "{name}");
    }
}

/// A block on a plate whose friction rotates it. Friction at the surface holds a pull below mu N
/// for a long time and adds no energy.
#[test]
fn a_pull_below_the_limit_is_held() {
    for (name, of) in fair_laws() {
        if of.law == "penalty" {
            continue; // sticks by a spring
        }
        let mut points: Vec<NodeRecord> =
            square([1e3; 4]).into_iter().map(|p| turning(held(p.x), 1.0)).collect();
        // No rotations: nodes would spin like free wheels.
        points.push(turning(mass([0.0, 0.0, THICK], [0.0; 3], 2.0), 1e-3));
        points.iter_mut().for_each(|p| p.fixed |= 0b11_1000);
        let mut scene = Scene::new(&of, &points, &[[0, 1, 2, 3]], &[4], 1e-3);
        scene.load[4] = V3::new(0.8 * 0.3 * 50.0, 0.0, -50.0);
        (0..1000).for_each(|_| _ = scene.step());
        assert!(scene.pairs()[0].has_couple(), "{name}");
        assert!(scene.v(4).norm() < 0.015, "{name}: {}", scene.v(4));
    }
}

/// Without rotational inertia on both sides no node takes the couple. Without friction there is no
/// couple.
#[test]
fn what_cannot_turn_or_rub_has_no_lever() {
    for (inertia, friction, turns) in [(0.0, 0.3, false), (0.01, 0.0, false), (0.01, 0.3, true)] {
        let of = ContactInput { friction, ..job("lagrange") };
        let mut scene = plates(&of, [1.0; 4], [1.0; 4], [inertia; 2]);
        scene.step();
        assert!(
            !scene.pairs().is_empty() && scene.pairs().iter().all(|p| p.has_couple() == turns),
            "{inertia} {friction}"
        );
        assert_eq!(scene.contact.table.couples.is_empty(), !turns);
    }
}

/// Friction along the rim of an upright shell on a plate would rotate it about its own normal, a
/// rotation with almost no stiffness. Therefore the plate takes the whole couple, about the middle
/// of the rim.
#[test]
fn the_rim_of_a_shell_takes_no_couple() {
    let of = ContactInput { friction: 0.3, ..job("lagrange") };
    let upright = [[-0.3, 0.1, THICK], [0.4, 0.1, THICK], [0.4, 0.1, 1.0], [-0.3, 0.1, 1.0]];
    let mut points = square([1.0; 4]);
    points.extend(upright.map(|x| mass(x, [1.0, 0.0, -1.0], 1.0)));
    let points: Vec<NodeRecord> = points.into_iter().map(|p| turning(p, 0.01)).collect();
    let mut scene = Scene::new(&of, &points, &[[0, 1, 2, 3], [4, 5, 6, 7]], &[4, 5], 1e-3);
    let before = angular(&scene);
    scene.step();
    assert_eq!(scene.pairs().len(), 2);
    for p in scene.pairs() {
        assert!(
            p.lever_arms[0].abs() < 1e-12 && (p.lever_arms[1] - THICK).abs() < 1e-12,
            "{:?}",
            p.lever_arms
        );
    }
    assert!((angular(&scene) - before).norm() < 1e-13 * before.norm());
}
