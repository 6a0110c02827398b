//! Tests of single masses against walls of all shapes.

use super::*;
use crate::nodes::ContactNode;
use crumple_proto::loads::{MotionForm, PrescribedMotion};
use crumple_proto::partition::NodeRecord;
use crumple_proto::transport::threads;

fn wall(friction: f64) -> Walls {
    Walls::new(&[ResolvedWall::plane([0.0, 0.0, 1.0], [0.0, 0.0, 2.0], friction)], &[])
}

/// Builds nodes from positions, velocities and masses.
fn masses(of: &[([f64; 3], [f64; 3], f64)]) -> Nodes {
    let record = |(id, &(at, v, mass)): (u64, &([f64; 3], [f64; 3], f64))| NodeRecord {
        id: NodeId(id),
        x0: at,
        x: at,
        v,
        mass,
        ..NodeRecord::default()
    };
    Nodes::new(&(1..).zip(of).map(record).collect::<Vec<_>>(), 0, true)
}

/// Returns the velocity of a mass of 1 after the walls.
fn stop(walls: &Walls, x: [f64; 3], v: [f64; 3], dt: f64) -> Row {
    walls.stop(&masses(&[(x, v, 1.0)]), 0, row(v), dt)
}

/// Computes one step of nodes and walls on one worker, starting at `time`; returns the work on
/// nodes, on walls with a mass, and of friction relative to the walls.
fn step(walls: &mut Walls, nodes: &mut Nodes, time: f64, dt: f64) -> [f64; 3] {
    let mut comm = threads::connect(2).remove(1);
    nodes.accelerate(dt);
    walls.start_step(time, dt);
    let steps = StepSizes { dt, dt_velocity: dt, dt_damped: dt, dt_stable: dt };
    let mut work = WallWork::default();
    walls.enforce(&mut comm, nodes, &[], steps, &mut work).unwrap();
    let on_masses = walls.work_on_masses().total();
    nodes.advance(dt);
    walls.advance(dt);
    [work.total.total(), on_masses, work.friction.total()]
}

#[test]
fn node_ends_on_the_wall_and_friction_obeys_the_cone() {
    let v = stop(&wall(0.1), [0.0, 0.0, 1.5], [10.0, 0.0, -10.0], 0.1);
    assert!((v[2] + 5.0).abs() < 1e-12, "stops at the plane: {v:?}");
    assert!((v[0] - 9.5).abs() < 1e-12, "slowed by mu times the normal change of 5: {v:?}");
    let v = stop(&wall(10.0), [0.0, 0.0, 1.0], [1.0, 0.0, -1.0], 0.1);
    assert_eq!([v[0], v[2]], [0.0, 0.0], "sticks");
    let v = stop(&wall(0.1), [0.0, 0.0, 1.0], [1.0, 0.0, 0.1], 0.1);
    assert_eq!(v, [1.0, 0.0, 0.1, 0.0], "leaves freely");
}

/// Slides a mass on the wall under a constant force, for `steps` steps of 1e-3. Returns
/// velocity, position and recorded work, that of the wall and that of friction.
fn slide(walls: &mut Walls, v: [f64; 3], force: [f64; 3], steps: usize) -> (Row, Row, [f64; 2]) {
    let mut nodes = masses(&[([0.0, 0.0, 1.0], v, 2.0)]);
    nodes.force[0] = row(force);
    let mut sums = [0.0; 2];
    for i in 0..steps {
        let [work, _, of_friction] = step(walls, &mut nodes, i as f64 * 1e-3, 1e-3);
        (sums[0], sums[1]) = (sums[0] + work, sums[1] + of_friction);
    }
    (nodes.v[0], nodes.x[0], sums)
}

/// A07: friction decelerates a sliding block of mass m under a force N by `mu N / m` until it
/// stops. It holds the block against a pull below mu N and releases it above. The wall's force
/// is constant, so the only errors are round-off and the last step, in which the block stops.
#[test]
fn coulomb_friction_slows_holds_and_lets_go() {
    let (mu, n, m) = (0.3, 50.0, 2.0);
    let slowing = mu * n / m;
    let mut walls = wall(mu);
    let (v, x, _) = slide(&mut walls, [10.0, 0.0, 0.0], [0.0, 0.0, -n], 1000);
    assert!((v[0] - (10.0 - slowing)).abs() < 1e-10 && v[2] == 0.0, "{v:?}");
    assert!(
        (x[0] - (10.0 - 0.5 * slowing)).abs() < 0.5e-3 * slowing * 1.01,
        "mid-step velocities: {x:?}"
    );
    let impulse = walls.impulse(0);
    assert!(
        (impulse[2] - n).abs() < 1e-9 && (impulse[0] + mu * n).abs() < 1e-9,
        "over a time of 1: {impulse:?}"
    );

    let (v, x, [work, of_friction]) = slide(&mut wall(mu), [10.0, 0.0, 0.0], [0.0, 0.0, -n], 2000);
    assert_eq!(v[0], 0.0, "rests");
    assert!(
        (x[0] / (100.0 / (2.0 * slowing)) - 1.0).abs() < 1e-3,
        "stopping distance, within one step: {x:?}"
    );
    assert!(
        (work / (-0.5 * m * 100.0) - 1.0).abs() < 1e-3,
        "friction dissipates all kinetic energy: {work}"
    );
    assert!((of_friction - work).abs() < 1e-9, "the wall does no other work: {of_friction}");

    let (v, x, _) = slide(&mut wall(mu), [0.0; 3], [0.9 * mu * n, 0.0, -n], 1000);
    assert_eq!([v[0], x[0]], [0.0, 0.0], "held");
    let (v, ..) = slide(&mut wall(mu), [0.0; 3], [1.1 * mu * n, 0.0, -n], 1000);
    assert!((v[0] - 0.1 * slowing).abs() < 1e-10, "released: {v:?}");
}

/// The impact on the wall is plastic: the whole normal part of the energy is lost. Friction
/// takes its part of the sliding energy at once, and no more than the cone allows.
#[test]
fn an_impact_loses_its_normal_part_and_friction_its_share() {
    for mu in [0.0, 0.2, 5.0] {
        let mut walls = wall(mu);
        let (v, x, [work, of_friction]) = slide(&mut walls, [3.0, 0.0, -10.0], [0.0; 3], 3);
        let slid = (3.0 - mu * 10.0f64).max(0.0);
        assert!(
            (v[0] - slid).abs() < 1e-12 && v[2].abs() < 1e-12 && (x[2] - 1.0).abs() < 1e-12,
            "{v:?} {x:?}"
        );
        let lost = 0.5 * 2.0 * (9.0 + 100.0 - slid * slid);
        assert!((work + lost).abs() < 1e-9, "mu {mu}: {work}, not {lost}");
        let rubbed = 0.5 * 2.0 * (9.0 - slid * slid);
        assert!((of_friction + rubbed).abs() < 1e-9, "mu {mu}: {of_friction}, not {rubbed}");
        let p = walls.impulse(0);
        assert!((p[0] - 2.0 * (slid - 3.0)).abs() < 1e-12 && (p[2] - 20.0).abs() < 1e-12, "{p:?}");
    }
}

/// In the corner of two walls a node stays in front of both; no wall moves a fixed node.
#[test]
fn a_corner_keeps_out_and_a_held_node_stays() {
    let to = |normal| ResolvedWall::plane([0.0; 3], normal, 0.0);
    let corner = Walls::new(&[to([1.0, 0.0, 0.0]), to([0.0, 1.0, 0.0])], &[]);
    let v = stop(&corner, [0.1, 0.2, 0.0], [-5.0, -5.0, 1.0], 0.1);
    assert!((v[0] + 1.0).abs() < 1e-12 && (v[1] + 2.0).abs() < 1e-12 && v[2] == 1.0, "{v:?}");
    let held = NodeRecord { fixed: 0b111, x: [-1.0, 0.0, 0.0], mass: 1.0, ..NodeRecord::default() };
    assert_eq!(corner.stop(&Nodes::new(&[held], 0, true), 0, [0.0; 4], 0.1), [0.0; 4]);
}

/// Masses hit a wall of mass M, two at once and one later; each time it is a perfectly plastic
/// impact. They continue with the wall at the velocity that follows from momentum, and the lost
/// energy is recorded. The first two separate when the third slows down the wall. A node ahead
/// of the wall and one in the excluded set do not change.
#[test]
fn a_wall_with_a_mass_goes_on_with_what_it_meets() {
    let (mass, speed, dt) = (3.0, 4.0, 1e-3);
    let motion = WallMotion::Pushed { mass, speed };
    let job = ResolvedWall {
        motion,
        except: vec![NodeId(5)],
        ..ResolvedWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.0)
    };
    let mut walls = Walls::new(&[job], &[]);
    let still = [0.0; 3];
    let mut nodes = masses(&[
        ([0.0, 0.0, 0.0], [1.0, 0.0, -2.0], 1.0),
        ([5.0, 0.0, 0.0], still, 2.0),
        ([9.0, 0.0, 0.1], still, 4.0),
        ([2.0, 0.0, 1.0], [0.0, 0.0, 9.0], 7.0),
        ([0.0, 7.0, 0.0], still, 5.0),
    ]);
    walls.bind_local(&nodes);
    let at_first = (mass * speed - 2.0) / (mass + 3.0);
    let at_last = mass * at_first / (mass + 4.0);
    let kinetic = |nodes: &Nodes, walls: &Walls| {
        let of = |i: usize| 0.5 * nodes.mass[i] * V3::from(xyz(&nodes.v[i])).norm_squared();
        (0..5).map(of).sum::<f64>() + 0.5 * mass * walls.walls[0].next.norm_squared()
    };
    let before = kinetic(&nodes, &walls);
    let mut work = 0.0;
    for i in 0..200 {
        work += step(&mut walls, &mut nodes, i as f64 * dt, dt)[..2].iter().sum::<f64>();
        if nodes.v[2][2] == 0.0 {
            let v = walls.walls[0].next.z;
            assert!(
                (v - at_first).abs() < 1e-12 * at_first,
                "step {i}, after two impacts: {v} {at_first}"
            );
        }
    }
    let v = walls.walls[0].next.z;
    assert!((v - at_last).abs() < 1e-12 * at_last, "round-off: {v} {at_last}");
    let place = walls.walls[0].surface.position().z;
    assert!(
        (nodes.v[2][2] - v).abs() < 1e-12 && (nodes.x[2][2] - place).abs() < 1e-12,
        "{:?}",
        nodes.v[2]
    );
    assert!(
        (0..2).all(|i| (nodes.v[i][2] - at_first).abs() < 1e-12 && nodes.x[i][2] > place),
        "{:?}",
        nodes.v
    );
    assert_eq!((nodes.v[0][0], nodes.v[3], nodes.v[4]), (1.0, [0.0, 0.0, 9.0, 0.0], [0.0; 4]));
    let given: f64 = (0..3).map(|i| nodes.mass[i] * nodes.v[i][2]).sum::<f64>() + 2.0;
    assert!(
        (walls.impulse(0)[2] - given).abs() < 1e-12 && (given - mass * (speed - v)).abs() < 1e-12,
        "{given}"
    );
    let lost = before - kinetic(&nodes, &walls);
    assert!((work + lost).abs() < 1e-12 * before && lost > 0.0, "work {work}, energy loss {lost}");
}

/// A wall with prescribed motion accelerates a node to its own velocity, tangentially within
/// the cone of friction, and does the work. Friction dissipates energy in the relative motion.
#[test]
fn a_prescribed_wall_moves_nodes_in_contact() {
    let dt = 1e-3;
    let motion = PrescribedMotion {
        nodes: Vec::new(),
        dofs: 0b111,
        form: MotionForm::Velocity,
        amount: [2.0, 0.0, 1.0],
        curve: Some(0),
        window: None,
    };
    let job = ResolvedWall {
        motion: WallMotion::Led(motion),
        ..ResolvedWall::plane([0.0, 0.0, -0.05], [0.0, 0.0, 1.0], 0.5)
    };
    let mut walls = Walls::new(&[job], &[vec![[0.0, 1.0], [0.1, 1.0], [0.2, 3.0]]]);
    let mut nodes = masses(&[([0.0; 3], [0.0; 3], 2.0)]);
    let mut work = [0.0; 2];
    let mut at = |from: usize, to: usize| {
        for i in from..to {
            let [of_wall, _, of_friction] = step(&mut walls, &mut nodes, i as f64 * dt, dt);
            work = [work[0] + of_wall, work[1] + of_friction];
        }
        (nodes.v[0], nodes.x[0], work)
    };
    let (v, x, _) = at(0, 45);
    assert_eq!((v, x), ([0.0; 4], [0.0; 4]), "not yet met");
    let (v, x, [work, of_friction]) = at(45, 100);
    assert!(
        (v[2] - 1.0).abs() < 1e-9 && (v[0] - 0.5).abs() < 1e-9,
        "mu times the normal change of 1: {v:?}"
    );
    assert!((x[2] - 0.05).abs() < 1e-9, "on the wall: {x:?}");
    assert!((work - 0.5 * 2.0 * (1.0 + 0.25)).abs() < 1e-9, "{work}");
    let rubbed = 2.0 * 0.5 * 0.5 * (2.0 + 1.5);
    assert!((of_friction + rubbed).abs() < 1e-9, "an impulse of 1 at speeds of 2 and 1.5");
    let (v, x, _) = at(100, 300);
    assert!(
        (v[2] - 3.0).abs() < 1e-9 && (v[0] - 1.5).abs() < 1e-9,
        "further slip by half of the normal change of 2: {v:?}"
    );
    assert!((x[2] - 0.55).abs() < 1e-9, "the integral of the curve: {x:?}");
}

/// A rectangle stops nodes that fall on it, ignores nodes outside its edges, and does not push
/// out nodes that get behind it from the side.
#[test]
fn a_rectangle_ends_where_it_ends() {
    let form = WallForm::Rectangle { edge: [1.0, 0.0, 0.0], lengths: [2.0, 1.0] };
    let mut walls = Walls::new(
        &[ResolvedWall { form, ..ResolvedWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.0) }],
        &[],
    );
    let down = [0.0, 0.0, -10.0];
    let mut nodes = masses(&[
        ([1.0, 0.5, 0.1], down, 1.0),
        ([2.0, 1.0, 0.1], down, 1.0),
        ([2.1, 0.5, 0.1], down, 1.0),
        ([1.0, -0.1, 0.1], down, 1.0),
        ([-0.5, 0.5, -0.2], [10.0, 0.0, 0.0], 1.0),
    ]);
    for i in 0..200 {
        step(&mut walls, &mut nodes, i as f64 * 1e-3, 1e-3);
    }
    let z = [0, 1, 2, 3, 4].map(|i| nodes.x[i][2]);
    assert!(z[..2].iter().all(|z| z.abs() < 1e-12), "stopped: {z:?}");
    assert!(z[2..4].iter().all(|z| (z + 1.9).abs() < 1e-12), "passed outside: {z:?}");
    assert_eq!((nodes.v[4], z[4]), ([10.0, 0.0, 0.0, 0.0], -0.2), "always behind the wall");
    let ends = WallForm::Rectangle { edge: [1.0, 0.0, 0.0], lengths: [0.0, 1.0] };
    let long = Walls::new(
        &[ResolvedWall { form: ends, ..ResolvedWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.0) }],
        &[],
    );
    assert_eq!(stop(&long, [-1e6, 0.5, 0.0], down, 0.1)[2], 0.0, "an infinite side");
}

/// A cylinder stops nodes from all sides within its length. A mass on it moves around it
/// without friction under gravity. It leaves the cylinder when gravity no longer holds it on
/// the surface, at cos a = 2/3 for the angle a from the top (a textbook case). Nodes inside
/// stay there.
#[test]
fn a_cylinder_catches() {
    let form = WallForm::Cylinder { radius: 1.0, length: 3.0 };
    let job = ResolvedWall { form, ..ResolvedWall::plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], 0.0) };
    let mut walls = Walls::new(&[job], &[]);
    let mut nodes = masses(&[
        ([0.6, 0.0, 2.0], [0.0, 0.0, -5.0], 1.0),
        ([-3.0, 1.9, 0.0], [5.0, 0.0, 0.0], 1.0),
        ([-3.0, 2.1, 0.0], [5.0, 0.0, 0.0], 1.0),
        ([0.2, 0.0, 0.0], [0.0, 1.0, 0.0], 1.0),
    ]);
    for i in 0..1000 {
        step(&mut walls, &mut nodes, i as f64 * 1e-3, 1e-3);
    }
    let off = |i: usize| (nodes.x[i][0].powi(2) + nodes.x[i][2].powi(2)).sqrt();
    // The normal part of 5 is lost at the impact, the rest remains along the tangent.
    let v = nodes.v[0];
    assert!((v[0].hypot(v[2]) - 5.0 * 0.6).abs() < 0.02 && off(0) > 1.0, "within one step: {v:?}");
    assert!(
        nodes.v[1][0].abs() < 1e-9 && (nodes.x[1][0] + 1.0).abs() < 1e-9,
        "head-on impact: {:?}",
        nodes.x[1]
    );
    assert_eq!((nodes.v[2][0], nodes.v[3][1]), (5.0, 1.0), "outside its end, and inside it");

    let mut nodes = masses(&[([1e-3, 0.0, 1.0], [0.0; 3], 1.0)]);
    nodes.force[0] = row([0.0, 0.0, -1.0]);
    let mut left = None;
    for i in 0..200_000 {
        step(&mut walls, &mut nodes, i as f64 * 1e-4, 1e-4);
        let off = nodes.x[0][0].hypot(nodes.x[0][2]);
        assert!(off > 1.0 - 1e-9, "no penetration: {off}");
        if off > 1.0 + 1e-6 {
            left = Some(nodes.x[0][2] / off);
            break;
        }
    }
    // The distance reaches 1e-6 at t = 0.015 by 3 g sin(a) v t^3 / 6 R: 0.01 later in the
    // cosine.
    assert!(left.is_some_and(|cosine| (cosine - (2.0 / 3.0 - 0.01)).abs() < 2e-3), "{left:?}");
}

/// Returns a sphere around the origin.
fn sphere(radius: f64, friction: f64) -> ResolvedWall {
    let form = WallForm::Sphere { radius };
    ResolvedWall { form, ..ResolvedWall::plane([0.0; 3], [0.0, 0.0, 1.0], friction) }
}

/// A sphere stops nodes from all sides: the normal part of the velocity is lost, friction takes
/// mu times that from the tangential part, nodes that miss it or are inside pass. The impulse is
/// the change of momentum.
#[test]
fn a_sphere_stops_nodes_along_its_normal() {
    for mu in [0.0, 0.25] {
        let mut walls = Walls::new(&[sphere(1.0, mu)], &[]);
        // At a distance of 0.6 from the axis, the normal has the parts 0.6 and 0.8.
        let mut nodes = masses(&[
            ([0.36, 0.48, 2.0], [0.0, 0.0, -5.0], 2.0),
            ([-3.0, 0.0, 0.0], [5.0, 0.0, 0.0], 1.0),
            ([-3.0, 0.9, 0.9], [5.0, 0.0, 0.0], 1.0),
            ([0.2, 0.1, 0.0], [0.0, 0.5, 0.0], 1.0),
        ]);
        for i in 0..1000 {
            step(&mut walls, &mut nodes, i as f64 * 1e-3, 1e-3);
        }
        let v = V3::from(xyz(&nodes.v[0]));
        let wanted = 3.0 - mu * 4.0;
        assert!((v.norm() - wanted).abs() < 0.02, "within one step: {v:?}, not {wanted}");
        assert!(V3::from(xyz(&nodes.x[0])).norm() > 1.0, "{:?}", nodes.x[0]);
        let head_on = nodes.x[1];
        assert!(nodes.v[1][0].abs() < 1e-9 && (head_on[0] + 1.0).abs() < 1e-9, "{head_on:?}");
        assert_eq!((nodes.v[2][0], nodes.v[3][1]), (5.0, 0.5), "a miss, and one inside");
        let given = walls.impulse(0);
        let change = [2.0 * v.x - 5.0, 2.0 * v.y, 2.0 * (v.z + 5.0)];
        let most = (0..3).map(|c| (given[c] - change[c]).abs()).fold(0.0, f64::max);
        assert!(most < 1e-9, "{given:?}, not {change:?}");
    }
}

/// A mass slides from the top of a smooth sphere under gravity, along any meridian, and leaves
/// it at cos a = 2/3 (a textbook case). It is never inside.
#[test]
fn a_mass_leaves_a_smooth_sphere_at_two_thirds_of_its_height() {
    let mut walls = Walls::new(&[sphere(1.0, 0.0)], &[]);
    let mut nodes = masses(&[([6e-4, 8e-4, 1.0], [0.0; 3], 1.0)]);
    nodes.force[0] = row([0.0, 0.0, -1.0]);
    let mut left = None;
    for i in 0..200_000 {
        step(&mut walls, &mut nodes, i as f64 * 1e-4, 1e-4);
        let off = V3::from(xyz(&nodes.x[0])).norm();
        assert!(off > 1.0 - 1e-9, "no penetration: {off}");
        if off > 1.0 + 1e-6 {
            left = Some(nodes.x[0][2] / off);
            break;
        }
    }
    // The distance reaches 1e-6 later by 0.01 in the cosine, as on a cylinder.
    assert!(left.is_some_and(|cosine| (cosine - (2.0 / 3.0 - 0.01)).abs() < 2e-3), "{left:?}");
}

/// A sphere with prescribed motion takes a mass along: the mass gets its speed, and the work on it
/// is its kinetic energy. With the mass on its axis of motion nothing slides.
#[test]
fn a_prescribed_sphere_takes_a_mass_along() {
    let dt = 1e-3;
    let motion = PrescribedMotion {
        nodes: Vec::new(),
        dofs: 0b111,
        form: MotionForm::Velocity,
        amount: [0.0, 3.0, 4.0],
        curve: None,
        window: None,
    };
    let job = ResolvedWall { motion: WallMotion::Led(motion), ..sphere(1.0, 0.3) };
    let mut walls = Walls::new(&[job], &[]);
    let mut nodes = masses(&[([0.0, 0.75, 1.0], [0.0; 3], 2.0)]);
    let work: f64 = (0..200).map(|i| step(&mut walls, &mut nodes, i as f64 * dt, dt)[0]).sum();
    let v = nodes.v[0];
    assert!((v[1] - 3.0).abs() < 1e-9 && (v[2] - 4.0).abs() < 1e-9, "{v:?}");
    assert!((work - 0.5 * 2.0 * 25.0).abs() < 1e-9, "{work}");
    let off = (V3::from(xyz(&nodes.x[0])) - walls.walls[0].surface.position()).norm();
    assert!((off - 1.0).abs() < 1e-9, "on the surface: {off}");
}

/// The fast test never hides a contact: at the edge of the surface, where round-off decides, it
/// leaves the decision to the exact one.
#[test]
fn the_fast_test_agrees_with_the_exact_one() {
    let cylinder = WallForm::Cylinder { radius: 3.0, length: 0.0 };
    for form in [cylinder, WallForm::Sphere { radius: 3.0 }] {
        let place = ResolvedWall::plane([0.1, -0.7, 0.3], [0.0, 0.6, 0.8], 0.0);
        let surface = WallSurface::new(&ResolvedWall { form, ..place });
        let (mut met, mut missed) = (0, 0);
        for k in 0..10_000 {
            let turn = f64::from(k) * 0.618;
            let off = 3.0 + (f64::from(k % 101) - 50.0) * 1e-13;
            let out = V3::new(turn.cos(), 0.8 * turn.sin(), -0.6 * turn.sin());
            let x = surface.position() + out * (off + 1.0);
            let (v, before) = (-out, -out);
            let meets = surface.contact_point(&x, &v, &before, 1.0).is_some();
            let misses = surface.cannot_reach(&x, &v, 1.0);
            assert!(!(meets && misses), "{form:?} {k}");
            met += usize::from(meets);
            missed += usize::from(misses);
        }
        assert!(met > 3000 && missed > 3000, "{form:?}: {met} {missed}");
    }
}

/// Nodes of replicated pairs come after the nodes for which walls know whether they meet them. A
/// wall for some nodes stops those of them that are in its list.
#[test]
fn walls_for_some_nodes_stop_appended_nodes_in_their_list_only() {
    let nodes_of_wall = Some(vec![NodeId(1), NodeId(8)]);
    let job = ResolvedWall {
        nodes: nodes_of_wall,
        ..ResolvedWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.0)
    };
    let mut walls = Walls::new(&[job], &[]);
    let mut nodes = masses(&[([0.0; 3], [0.0, 0.0, -1.0], 1.0); 2]);
    walls.bind_local(&nodes);
    for id in [8, 9] {
        nodes.push_contact_node(&ContactNode { id: NodeId(id), ..nodes.contact_node(0) });
    }
    walls.start_step(0.0, 0.1);
    let stopped = |i| walls.stop(&nodes, i, [0.0, 0.0, -1.0, 0.0], 0.1)[2] == 0.0;
    assert_eq!([0, 1, 2, 3].map(stopped), [true, false, true, false]);
}
