//! Tests of the partitioned kinematic predictor-corrector, and of properties of all laws.

use super::*;

fn kinematic(partition: f64) -> ContactInput {
    job("kinematic").with("partition", partition)
}

/// Two plates that face each other. All nodes are slaves of the segment of the other plate. The
/// lower plate has lower node ids.
fn plates(of: &ContactInput, low: [f64; 4], high: [f64; 4], v: V3) -> Scene {
    let lower = square(low);
    let upper =
        square(high).into_iter().map(|p| mass([p.x[0], p.x[1], THICK], (-v).into(), p.mass));
    let points: Vec<NodeRecord> =
        lower.into_iter().map(|p| NodeRecord { v: v.into(), ..p }).chain(upper).collect();
    Scene::new(of, &points, &[[0, 1, 2, 3], [4, 5, 6, 7]], &[0, 1, 2, 3, 4, 5, 6, 7], 1e-3)
}

/// All laws in all forms conserve momentum to round-off: with different masses on both sides, with
/// friction, at an angle. Energy does not increase, except for the error of the penalty steps.
#[test]
fn every_law_keeps_momentum() {
    for (name, of) in all_laws() {
        let of = ContactInput { friction: 0.3, ..of };
        let mut scene =
            plates(&of, [1.0, 3.0, 0.2, 5.0], [2.0, 0.5, 4.0, 1.0], V3::new(0.7, -0.2, 1.0));
        let (p, before) = (scene.momentum(), scene.energy());
        let mut met = 0;
        for _ in 0..50 {
            scene.step();
            met += scene.pairs().len();
        }
        let all: f64 = scene.sum(|m, _, v| m * v.norm());
        assert!(met > 8, "{name}: there is contact");
        // Round-off of 50 steps with about ten sums each.
        assert!(
            (scene.momentum() - p).norm() < 1e-13 * 50.0 * all,
            "{name}: {}",
            scene.momentum() - p
        );
        assert!(
            (scene.energy() - before - scene.work).abs() < 1e-12 * before,
            "{name}: energy balance"
        );
        let doubt = if of.law == "penalty" { 0.05 } else { 1e-9 };
        assert!(scene.energy() < before * (1.0 + doubt), "{name}: {} of {before}", scene.energy());
    }
}

/// A node without slaves on the other side closes its gap alone and in one step, at any position on
/// the segment and for any partition factor: C02, light on heavy and heavy on light.
#[test]
fn a_one_sided_pair_closes_its_gap_in_one_step() {
    for (m, segment) in [(1e-6, 1e-3), (1.0, 1e-6), (1.0, 1.0)] {
        for (x, y) in [(0.0, 0.0), (0.4, 0.2), (0.95, -0.9), (1.0, 1.0)] {
            for partition in [0.0, 0.5, 1.0] {
                let (v, dt) = (10.0, 1e-3);
                let mut points = square([segment; 4]);
                points.push(mass([x, y, THICK], [0.0, 0.0, -v], m));
                let mut scene =
                    Scene::new(&kinematic(partition), &points, &[[0, 1, 2, 3]], &[4], dt);
                let p = scene.momentum();
                scene.step();
                let shape = scene.pairs()[0].shape;
                let point: V3 = (0..4).map(|k| scene.v(k) * shape[k + 1]).sum();
                let at = format!("{m} on {segment} at {x}, {y}");
                assert!((scene.momentum() - p).norm() < 1e-13 * p.norm(), "{at}: round-off");
                assert!((scene.v(4) - point).norm() < 1e-9 * v, "{at}: {} and {point}", scene.v(4));
                // A plastic impact on the mass of the contact point.
                let behind: f64 = 1.0 / shape[1..].iter().map(|n| n * n / segment).sum::<f64>();
                let common = v * m / (m + behind);
                assert!(
                    (scene.v(4).z + common).abs() < 1e-9 * v,
                    "{at}: {}, expected {common}",
                    scene.v(4).z
                );
            }
        }
    }
}

/// Many nodes on a segment share its mass. At the centre, with equal masses, one pass is exact for
/// any number of nodes.
#[test]
fn nodes_that_share_a_segment_are_corrected_together() {
    for (n, m, segment) in [(2, 1.0, 1.0), (10, 10.0, 1.0), (10, 1e3, 1.0)] {
        let (v, dt) = (10.0, 1e-3);
        let mut points = square([segment; 4]);
        points.extend((0..n).map(|_| mass([0.0, 0.0, THICK], [0.0, 0.0, -v], m)));
        let slaves: Vec<u32> = (4..4 + n as u32).collect();
        let mut scene = Scene::new(&kinematic(0.5), &points, &[[0, 1, 2, 3]], &slaves, dt);
        scene.step();
        let common = n as f64 * m * v / (n as f64 * m + 4.0 * segment);
        (0..4 + n).for_each(|i| {
            assert!(
                (scene.v(i).z + common).abs() < 1e-9 * v,
                "{n} of {m}: node {i} {}",
                scene.v(i).z
            )
        });
    }
}

/// Fixed nodes against a free segment, without the other direction. They act as very heavy nodes.
#[test]
fn a_segment_stops_at_fixed_nodes() {
    let mut points: Vec<NodeRecord> =
        square([1.0; 4]).into_iter().map(|p| NodeRecord { v: [0.0, 0.0, 10.0], ..p }).collect();
    points.extend(
        [[0.0, 0.0], [0.1, 0.0], [-0.2, 0.3], [0.5, -0.6]].map(|[x, y]| held([x, y, THICK])),
    );
    let mut scene = Scene::new(&kinematic(0.5), &points, &[[0, 1, 2, 3]], &[4, 5, 6, 7], 1e-3);
    let before = scene.energy();
    for _ in 0..30 {
        scene.step();
        assert!(scene.energy() < before * (1.0 + 1e-12), "no energy gain");
    }
    let point = |i: usize| scene.x(i).z;
    let centre = 0.25 * (0..4).map(point).sum::<f64>();
    assert!(
        centre < 1e-3 * THICK && scene.contact.penetration < 0.05,
        "{centre}, {}",
        scene.contact.penetration
    );
}

/// C08: both plates are slaves of each other. The partition factor splits the correction, and the
/// gap is closed once.
#[test]
fn mutual_pairs_close_the_gap_once_whatever_the_partition() {
    for partition in [0.0, 0.3, 0.5, 1.0] {
        let (low, high, v) = (1.0, 3.0, 10.0);
        let mut scene = plates(&kinematic(partition), [low; 4], [high; 4], V3::new(0.0, 0.0, v));
        scene.step();
        let common = v * (low - high) / (low + high);
        (0..8).for_each(|i| {
            assert!(
                (scene.v(i).z - common).abs() < 1e-12 * v,
                "{partition}: node {i} {}",
                scene.v(i).z
            )
        });
        let exact = low * (v - common) / 1e-3;
        for p in scene.pairs() {
            let share = if p.key.slave.0 <= 4 { partition } else { 1.0 - partition };
            assert!(
                (p.force.norm() - share * exact).abs() < 1e-9 * exact,
                "{partition}: {:?}",
                p.force
            );
        }
    }
}

/// C08: two plates that are pressed together transmit the load once and uniformly, with any law.
#[test]
fn pressed_plates_pass_the_load_once() {
    for (name, of) in all_laws() {
        // Much larger than the residual of the Lagrange law, and much smaller than the load for a
        // penalty penetration of one thickness.
        let load = if of.law == "penalty" { 100.0 } else { 5e3 };
        let of = if is_stiff(&of) {
            of.with("penalty_scale", 1e5)
        } else {
            of.with("penalty_scale", 0.1)
        };
        let mut scene = plates(&of, [1.0; 4], [1.0; 4], V3::zeros());
        (0..8).for_each(|i| scene.load[i].z = if i < 4 { load } else { -load });
        scene.run_damped(600, 0.05);
        // Force on the nodes of the upper plate, from its own pairs and as reaction of the pairs
        // of the lower plate.
        let mut on_node = [0.0; 4];
        for p in scene.pairs() {
            for (r, &n) in p.nodes[..p.node_count()].iter().enumerate().filter(|(_, n)| **n >= 4) {
                on_node[n as usize - 4] +=
                    if r == 0 { p.force.z } else { -p.force.z * p.weight[r] };
            }
        }
        // The Lagrange law does not update a force that changes by less than 1e-3.
        on_node.iter().for_each(|f| {
            assert!((f / load - 1.0).abs() < 3e-3, "{name}: {on_node:?}, expected {load}")
        });
        assert_eq!(scene.pairs().len(), 8, "{name}: both directions");
    }
}

/// A fine surface falls on a coarse one; all nodes are slaves. Nodes at mid-face of the coarse
/// segment share the correction with its corners, so that their gap closes step by step and never
/// more than once. Energy does not increase, and momentum is conserved.
#[test]
fn a_fine_surface_on_a_coarse_one_comes_to_rest_on_it() {
    for partition in [0.2, 0.5, 0.8] {
        let mut points = square([2.0; 4]);
        let grid = (0..25).map(|i| [0.45 * ((i % 5) as f64 - 2.0), 0.45 * ((i / 5) as f64 - 2.0)]);
        points.extend(grid.map(|[x, y]| mass([x, y, THICK], [0.0, 0.0, -10.0], 0.4)));
        let fine = |i: u32| 4 + i % 4 + 5 * (i / 4);
        let mut segments = vec![[0, 1, 2, 3]];
        segments.extend((0..16).map(|i| [fine(i), fine(i) + 1, fine(i) + 6, fine(i) + 5]));
        let slaves: Vec<u32> = (0..29).collect();
        let mut scene = Scene::new(&kinematic(partition), &points, &segments, &slaves, 1e-3);
        let (p, mut last) = (scene.momentum(), scene.energy());
        let plastic = 0.5 * p.norm_squared() / scene.sum(|m, _, _| m);
        for step in 0..40 {
            scene.step();
            assert!(
                scene.energy() < last * (1.0 + 1e-12),
                "step {step}: {} after {last}",
                scene.energy()
            );
            last = scene.energy();
        }
        assert!((scene.momentum() - p).norm() < 1e-12 * p.norm(), "round-off");
        eprintln!(
            "partition {partition}: energy {last:.6}, plastic {plastic:.6}, deepest {:.2e}",
            scene.contact.penetration
        );
        assert!((last / plastic - 1.0).abs() < 1e-3, "{last} and not {plastic}");
    }
}

/// A plate on a bed of fixed nodes. All nodes are slaves of the other side, and the middle node of
/// the bed is higher by `bump`. `press` acts downwards and `pull` sideways on each corner.
fn on_a_bed(of: &ContactInput, bump: f64, press: f64, pull: f64) -> Scene {
    let mut points: Vec<NodeRecord> = (0..25)
        .map(|i| {
            held([
                0.45 * ((i % 5) as f64 - 2.0),
                0.45 * ((i / 5) as f64 - 2.0),
                if i == 12 { bump } else { 0.0 },
            ])
        })
        .collect();
    let corners = square([1.0, 2.0, 0.5, 1.5]).into_iter();
    let fixed = if pull == 0.0 { 0b011 } else { 0 }; // only vertical motion: no slip off the bump
    let above = |p: NodeRecord| mass([0.7 * p.x[0], 0.7 * p.x[1], THICK + bump], [0.0; 3], p.mass);
    points.extend(corners.map(|p| NodeRecord { fixed, ..above(p) }));
    let bed = |i: u32| i % 4 + 5 * (i / 4);
    let mut segments: Vec<[u32; 4]> =
        (0..16).map(|i| [bed(i), bed(i) + 1, bed(i) + 6, bed(i) + 5]).collect();
    segments.push([25, 26, 27, 28]);
    let slaves: Vec<u32> = (0..29).collect();
    let mut scene = Scene::new(of, &points, &segments, &slaves, 1e-3);
    (25..29).for_each(|i| scene.load[i] = V3::new(pull, 0.0, -press));
    scene
}

/// A09: on a fixed bed the free nodes carry the load for any partition factor, and they do not
/// creep under a pull below mu N.
#[test]
fn what_stands_on_held_nodes_bears_all_and_does_not_creep() {
    for partition in [0.0, 0.5, 1.0] {
        let of = ContactInput { friction: 0.5, ..kinematic(partition) };
        let (press, pull, steps) = (500.0, 200.0, 1000);
        let mut scene = on_a_bed(&of, 0.0, press, pull);
        scene.run_damped(200, 0.05);
        let start: Vec<f64> = (25..29).map(|i| scene.x(i).x).collect();
        (0..steps).for_each(|_| _ = scene.step());
        for p in scene.pairs() {
            let borne = if p.key.slave.0 > 25 { press } else { 0.0 };
            assert!(
                (p.force.z.abs() - borne).abs() < 1e-3 * press,
                "{partition}: {:?}, expected {borne}",
                p.force
            );
        }
        let time = f64::from(steps) * scene.steps.dt;
        for (i, start) in (25..29).zip(start) {
            let free = 0.5 * pull / scene.nodes.mass[i] * time * time;
            let crept = (scene.x(i).x - start).abs() / free;
            // The residual of a step, 1e-3 of a force, is corrected in the next one.
            assert!(crept < 1e-5, "{partition}: corner {i} crept by {crept:e} of its free path");
        }
    }
}

/// A fixed node that protrudes between the free corners of a coarse face still stops it, and the
/// corners are stopped too.
#[test]
fn a_held_node_between_free_ones_takes_what_they_leave() {
    let bump = 0.5 * THICK;
    let mut scene = on_a_bed(&kinematic(0.5), bump, 500.0, 0.0);
    scene.load[25].z -= 100.0; // tips over the bump onto its own corner
    scene.run_damped(2000, 0.05);
    let corners: Vec<f64> = (25..29).map(|i| scene.x(i).z).collect();
    let middle = 0.25 * corners.iter().sum::<f64>();
    let borne = |held: bool| -> f64 {
        let pairs = scene.pairs().iter().filter(|p| (p.key.slave.0 <= 25) == held);
        pairs.map(|p| p.force.z.abs()).sum()
    };
    // The residual of the law is 1e-3 of a force.
    assert!(
        (borne(true) - 2000.0).abs() < 4.0 && (borne(false) - 100.0).abs() < 4.0,
        "{}, {}",
        borne(true),
        borne(false)
    );
    assert!(
        (middle - THICK - bump).abs() < 1e-3 * THICK,
        "the bump does not penetrate the plate: {corners:?}"
    );
}
