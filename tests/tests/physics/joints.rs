//! Joints between rigid bodies: what each kind leaves free, pendulums and springs with closed
//! forms, momentum and energy, walls and contact, on any number of workers. Units mm, ms, kg.

use crate::rigid::Bodies;
use crumple::input::job::Model;
use crumple_tests::restart::{Plan, run_interrupted};
use crumple_tests::{run_alone, run_side_by_side};
use crumple_worker::constraints::rigid::body::Body;
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

type V3 = Vector3<f64>;

/// Two boxes, 10 by 10 by 10 and 15 by 10 by 10, 5 apart along x, as rigid bodies `a` and `b`.
fn pair(end_time: f64, rest: &str) -> Model {
    let mut bodies = Bodies::default();
    bodies.cuboid([0.0; 3], [2, 2, 2], 5.0);
    bodies.cuboid([15.0, 0.0, 0.0], [3, 2, 2], 5.0);
    let rigid = "[[rigid]]\nname = \"a\"\nparts = [1]\n[[rigid]]\nname = \"b\"\nparts = [2]\n";
    bodies.job(end_time, &format!("{rest}\n{rigid}"))
}

/// Motions of both bodies that no joint allows in full.
const TUMBLE: &str = "[[initial_velocity]]\nnodes = \"part_1\"\nvelocity = [0.3, -0.2, 0.5]\n\
                      spin = [0.05, 0.1, -0.04]\ncentre = [5.0, 5.0, 5.0]\n\
                      [[initial_velocity]]\nnodes = \"part_2\"\nvelocity = [-0.2, 0.4, 0.1]\n\
                      spin = [-0.06, 0.02, 0.09]\ncentre = [22.5, 5.0, 5.0]\n";

/// One box 10 by 10 by 10, rigid body `a`, with a joint to the ground.
fn one(end_time: f64, rest: &str) -> Model {
    let mut bodies = Bodies::default();
    bodies.cuboid([0.0; 3], [2, 2, 2], 5.0);
    bodies.job(end_time, &format!("{rest}\n[[rigid]]\nname = \"a\"\nparts = [1]\n"))
}

fn bodies(engine: &Engine) -> &[Body] {
    &engine.constraints.bodies.bodies
}

/// Returns where a point of a body is now; `start` is its place and `centre` that of the body at
/// time 0.
fn place(body: &Body, centre: V3, start: V3) -> V3 {
    let (now, turn) = body.frame();
    now + turn * (start - centre)
}

/// Returns the rotation of the second body against the first one, in the axes of time 0.
fn relative(bodies: &[Body]) -> Matrix3<f64> {
    bodies[0].frame().1.transpose() * bodies[1].frame().1
}

fn energy(engine: &Engine) -> [f64; 2] {
    let now = engine.ledger.energies(&engine.nodes, &engine.blocks).values();
    [now.kinetic, now.internal]
}

/// The centres of the two boxes at time 0, and the point of their joints [mm].
const CENTRES: [V3; 2] = [V3::new(5.0, 5.0, 5.0), V3::new(22.5, 5.0, 5.0)];
const POINT: V3 = V3::new(12.0, 6.0, 4.0);

/// Each kind of joint keeps what it has to keep, to round-off, while two free bodies tumble by more
/// than a turn, and leaves free what it has to leave free. Momentum and angular momentum are
/// conserved, and after the first step, in which the joint takes away what it does not allow, the
/// energy is.
#[test]
fn each_kind_leaves_free_what_it_names() {
    let axis = V3::new(0.48, 0.6, 0.64);
    let across = V3::new(0.8, 0.0, -0.6);
    for (kind, more, free) in [
        ("spherical", "", [0, 3]),
        ("revolute", "axis = [0.48, 0.6, 0.64]", [0, 1]),
        ("cylindrical", "axis = [0.48, 0.6, 0.64]", [1, 1]),
        ("translational", "axis = [0.48, 0.6, 0.64]", [1, 0]),
        ("planar", "axis = [0.48, 0.6, 0.64]", [2, 1]),
        ("universal", "axis = [0.48, 0.6, 0.64]\nsecond_axis = [0.8, 0.0, -0.6]", [0, 2]),
        ("screw", "axis = [0.48, 0.6, 0.64]\npitch = 3.0", [1, 1]),
        ("fixed", "", [0, 0]),
    ] {
        let joint = format!(
            "[time]\ndt_max = 0.05\n[[joint]]\nname = \"j\"\nkind = \"{kind}\"\n\
             bodies = [\"a\", \"b\"]\npoint = [12.0, 6.0, 4.0]\n{more}\n{TUMBLE}"
        );
        let (mut worst, mut first) = ([0.0f64; 2], None);
        let (mut slid, mut angle, mut drift) = (V3::zeros(), 0.0f64, [0.0f64; 2]);
        run_alone(&pair(60.0, &joint), |e| {
            let all = bodies(e);
            let turn = relative(all);
            let (_, of_first) = all[0].frame();
            let apart = of_first.transpose()
                * (place(&all[1], CENTRES[1], POINT) - place(&all[0], CENTRES[0], POINT));
            let (along, aside) = (axis * axis.dot(&apart), apart - axis * axis.dot(&apart));
            let turned = nalgebra::Rotation3::from_matrix_unchecked(turn).scaled_axis();
            let axis_stays = (turn * axis - axis).norm();
            let off = match kind {
                "spherical" => [apart.norm(), 0.0],
                "revolute" => [apart.norm(), axis_stays],
                "cylindrical" => [aside.norm(), axis_stays],
                "translational" => [aside.norm(), (turn - Matrix3::identity()).norm()],
                "planar" => [along.norm(), axis_stays],
                "universal" => [apart.norm(), axis.dot(&(turn * across)).abs()],
                "screw" => {
                    let sliding = (turned.dot(&axis) - axis.dot(&apart) * TAU / 3.0) / TAU;
                    [aside.norm(), axis_stays.max((sliding - sliding.round()).abs())]
                }
                _ => [apart.norm(), (turn - Matrix3::identity()).norm()],
            };
            worst = [worst[0].max(off[0]), worst[1].max(off[1])];
            (slid, angle) = (slid.sup(&apart.abs()), angle.max(turned.norm()));
            let (p, l) = momentum(&e.nodes);
            let [kinetic, _] = energy(e);
            // The first step takes away what the joint does not allow.
            if e.clock.cycle > 2 {
                let (p0, l0, k0) = *first.get_or_insert((p, l, kinetic));
                let change = |a: [f64; 3], b: [f64; 3]| (V3::from(a) - V3::from(b)).norm();
                drift[0] = drift[0].max(change(p, p0)).max(change(l, l0) / 20.0);
                drift[1] = drift[1].max((kinetic / k0 - 1.0).abs());
            }
        });
        eprintln!("{kind}: {worst:?}, slid {slid:?}, turned {angle}, drift {drift:?}");
        assert!(worst[0] < 1e-11 && worst[1] < 1e-11, "{kind}: gaps at round-off: {worst:?}");
        assert_eq!(free[0] > 0, slid.norm() > 0.1, "{kind} slides: {slid:?}");
        assert_eq!(free[1] > 0, angle > 0.1, "{kind} rotates: {angle}");
        assert!(drift[0] < 1e-7, "{kind}: momenta, second order in the step: {drift:?}");
        assert!(drift[1] < 3e-5, "{kind}: energy, second order in the step: {drift:?}");
    }
}

/// Two bodies with a fixed joint move as one body of both parts.
#[test]
fn a_fixed_joint_makes_one_body() {
    let joint = format!(
        "[time]\ndt_max = 0.05\n[[joint]]\nname = \"j\"\nkind = \"fixed\"\n\
         bodies = [\"a\", \"b\"]\npoint = [12.0, 6.0, 4.0]\n{TUMBLE}"
    );
    let mut scene = Bodies::default();
    scene.cuboid([0.0; 3], [2, 2, 2], 5.0);
    scene.cuboid([15.0, 0.0, 0.0], [3, 2, 2], 5.0);
    let whole =
        format!("[time]\ndt_max = 0.05\n{TUMBLE}[[rigid]]\nname = \"ab\"\nparts = [1, 2]\n");
    let [joined, alone] =
        [pair(20.0, &joint), scene.job(20.0, &whole)].map(|m| run_alone(&m, |_| {}));
    let off = |i: usize| {
        (0..3).map(|c| (joined.nodes.x[i][c] - alone.nodes.x[i][c]).abs()).fold(0.0, f64::max)
    };
    let worst = (0..alone.nodes.local_count).map(off).fold(0.0, f64::max);
    eprintln!("{worst:e}");
    // The rotation of two bodies and of one follow other schemes of second order.
    assert!(worst < 1e-3, "after some 20 mm and a radian: {worst:e}");
}

/// A box on a hinge swings under its weight with the period `2 pi sqrt(J / (m g d))` of a small
/// pendulum, J about the hinge, and keeps its energy.
#[test]
fn a_pendulum_swings_with_its_period() {
    let rest = "[time]\ndt_max = 0.2\n[[gravity]]\nacceleration = [0.0, 0.0, -0.1]\n\
                [[joint]]\nname = \"hinge\"\nkind = \"revolute\"\nbodies = [\"a\"]\n\
                point = [5.0, 5.0, 35.0]\naxis = [0.0, 1.0, 0.0]\n\
                [[initial_velocity]]\nnodes = \"part_1\"\nvelocity = [0.0, 0.0, 0.0]\n\
                spin = [0.0, 1e-3, 0.0]\n\
                centre = [5.0, 5.0, 35.0]\n";
    let (mut last, mut crossings, mut height) = (0.0f64, Vec::new(), 0.0f64);
    let end = run_alone(&one(1200.0, rest), |e| {
        let x = bodies(e)[0].centre.x - 5.0;
        if last < 0.0 && x >= 0.0 {
            crossings.push(e.clock.time - e.clock.last_dt * x / (x - last));
        }
        last = x;
        height = height.max(bodies(e)[0].centre.z - 5.0);
    });
    let body = &bodies(&end)[0];
    let inertia = body.inertia[(1, 1)] + body.mass * 900.0;
    let period = TAU * (inertia / (body.mass * 0.1 * 30.0)).sqrt();
    let count = crossings.len() - 1;
    let measured = (crossings[count] - crossings[0]) / count as f64;
    assert!(count >= 8, "{count}");
    // Amplitude 0.018: the period of the finite swing is 2e-5 longer.
    assert!((measured / period - 1.0).abs() < 1e-4, "{measured} of {period}");
    let rise = 0.5 * inertia * 1e-6 / (body.mass * 0.1);
    assert!((height / rise - 1.0).abs() < 1e-3, "{height} of {rise}");
}

/// Rotation of the box about its own axis, against a spring, a damper, friction and stops of a
/// hinge to the ground.
fn hinged(end_time: f64, dt: f64, rotation: &str, look: impl FnMut(&Engine)) -> Engine {
    let rest = format!(
        "[time]\ndt_max = {dt:?}\n[[joint]]\nname = \"hinge\"\nkind = \"revolute\"\n\
         bodies = [\"a\"]\npoint = [5.0, 5.0, 5.0]\naxis = [0.0, 0.0, 1.0]\n\
         [joint.rotation]\n{rotation}\n[[initial_velocity]]\nnodes = \"part_1\"\n\
         velocity = [0.0, 0.0, 0.0]\nspin = [0.0, 0.0, 0.1]\ncentre = [5.0, 5.0, 5.0]\n"
    );
    run_alone(&one(end_time, &rest), look)
}

fn angle(engine: &Engine) -> f64 {
    bodies(engine)[0].turn.scaled_axis().z
}

/// A spring of a hinge swings the box with `2 pi sqrt(J / k)` for twenty periods without loss, its
/// energy is internal energy, and a spring that is far too stiff for the step does no harm.
#[test]
fn a_spring_keeps_its_energy_at_any_stiffness() {
    let inertia = bodies(&hinged(1.0, 0.5, "stiffness = 0.01", |_| {}))[0].inertia[(2, 2)];
    let stiffness = inertia * (TAU / 20.0f64).powi(2);
    let given = format!("stiffness = {stiffness:?}");
    let (mut last, mut crossings, mut sums) = (0.0, Vec::new(), [f64::INFINITY, 0.0f64]);
    let mut largest = 0.0f64;
    hinged(410.0, 0.1, &given, |e| {
        let now = angle(e);
        if last < 0.0 && now >= 0.0 {
            crossings.push(e.clock.time - e.clock.last_dt * now / (now - last));
        }
        (last, largest) = (now, largest.max(now));
        let [kinetic, internal] = energy(e);
        sums = [sums[0].min(kinetic + internal), sums[1].max(kinetic + internal)];
        assert!(internal > -1e-12, "stored: {internal}");
    });
    let period = (crossings[19] - crossings[0]) / 19.0;
    // The trapezoidal rule lengthens the period by (w dt)^2 / 12 = 8e-5.
    assert!((period / 20.0 - 1.0).abs() < 2e-4, "{period}");
    assert!((largest / (0.1 * 20.0 / TAU) - 1.0).abs() < 1e-3, "{largest}");
    // The kinetic energy is a product of the velocities of two mid-steps: a rotation lowers it by
    // (w dt)^2 / 2.
    assert!((sums[1] / sums[0] - 1.0).abs() < 1e-4, "{sums:?}");
    let stiff = format!("stiffness = {:?}", 1e6 * stiffness);
    let mut fastest = 0.0f64;
    hinged(400.0, 0.1, &stiff, |e| fastest = fastest.max(bodies(e)[0].last_spin.z.abs()));
    assert!(fastest < 0.1 * (1.0 + 1e-9), "{fastest}");
}

/// A damper of a hinge slows the box as `exp(-c t / J)`; what it takes is internal energy.
#[test]
fn a_damper_slows_exponentially() {
    let inertia = bodies(&hinged(1.0, 0.5, "damping = 0.01", |_| {}))[0].inertia[(2, 2)];
    let damping = format!("damping = {:?}", inertia / 10.0);
    let end = hinged(20.0, 0.05, &damping, |_| {});
    let spin = bodies(&end)[0].last_spin.z;
    let wanted = 0.1 * (-(end.clock.time - 0.5 * end.clock.last_dt) / 10.0).exp();
    assert!((spin / wanted - 1.0).abs() < 1e-4, "{spin} of {wanted}");
    let [kinetic, internal] = energy(&end);
    let whole = 0.5 * inertia * 0.01;
    assert!(((kinetic + internal) / whole - 1.0).abs() < 1e-7, "{kinetic} {internal} {whole}");
}

/// Friction of a hinge stops the box after `w^2 J / (2 M)` and holds it; a table with a constant
/// moment does the same up to the stop, and then turns it back.
#[test]
fn friction_stops_and_holds() {
    let inertia = bodies(&hinged(1.0, 0.5, "friction = 0.01", |_| {}))[0].inertia[(2, 2)];
    let moment = inertia * 0.01;
    let end = hinged(20.0, 0.01, &format!("friction = {moment:?}"), |_| {});
    assert!((angle(&end) / 0.5 - 1.0).abs() < 2e-3, "half a step of 10 ms: {}", angle(&end));
    assert!(bodies(&end)[0].last_spin.norm() < 1e-15, "{}", bodies(&end)[0].last_spin);
    let table = format!("table = [[0.0, {moment:?}], [1.0, {moment:?}]]");
    let mut furthest = 0.0f64;
    let end = hinged(20.0, 0.01, &table, |e| furthest = furthest.max(angle(e)));
    assert!((furthest / 0.5 - 1.0).abs() < 1e-4, "{furthest}");
    assert!(angle(&end).abs() < 2e-3, "it is back after 20 ms: {}", angle(&end));
}

/// A stop of a hinge ends the rotation where it is, without rebound and without penetration; the
/// energy of the impact is booked.
#[test]
fn a_stop_ends_the_rotation() {
    let mut furthest = 0.0f64;
    let end = hinged(20.0, 0.03, "stops = [-0.2, 0.7]", |e| furthest = furthest.max(angle(e)));
    assert!((furthest - 0.7).abs() < 1e-12 && (angle(&end) - 0.7).abs() < 1e-12, "{furthest}");
    let [kinetic, internal] = energy(&end);
    let whole = 0.5 * bodies(&end)[0].inertia[(2, 2)] * 0.01;
    assert!(kinetic < 1e-20 && (internal / whole - 1.0).abs() < 1e-9, "{kinetic} {internal}");
}

/// A linkage of three boxes and four parallel hinges to the ground, which runs with the spin
/// `spin` of its cranks. Returns the largest gap [mm], the largest angle of a crank and the largest
/// change of the kinetic energy.
fn linkage(spin: f64, end_time: f64) -> [f64; 3] {
    let mut scene = Bodies::default();
    for at in [[0.0, 0.0, 0.0], [15.0, 0.0, 0.0], [30.0, 0.0, 0.0]] {
        scene.cuboid(at, [2, 2, 2], 5.0);
    }
    let hinge = |name: &str, bodies: &str, x: f64, z: f64| {
        format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"revolute\"\nbodies = [{bodies}]\n\
             point = [{x:?}, 5.0, {z:?}]\naxis = [0.0, 1.0, 0.0]\n"
        )
    };
    let rigid: String =
        (1..4).map(|k| format!("[[rigid]]\nname = \"{k}\"\nparts = [{k}]\n")).collect();
    let hinges = [
        hinge("p", "\"1\"", 5.0, 0.0),
        hinge("q", "\"1\", \"2\"", 5.0, 30.0),
        hinge("r", "\"2\", \"3\"", 35.0, 30.0),
        hinge("s", "\"3\"", 35.0, 0.0),
    ]
    .concat();
    let crank = |part: u32, x: f64| {
        format!(
            "[[initial_velocity]]\nnodes = \"part_{part}\"\nvelocity = [0.0, 0.0, 0.0]\n\
             spin = [0.0, {spin:?}, 0.0]\ncentre = [{x:?}, 5.0, 0.0]\n"
        )
    };
    let rest = format!(
        "[time]\ndt_max = 0.05\n{rigid}{hinges}{}{}[[initial_velocity]]\nnodes = \"part_2\"\n\
         velocity = [{:?}, 0.0, 0.0]\n",
        crank(1, 5.0),
        crank(3, 35.0),
        30.0 * spin
    );
    let [mut gap, mut lean, mut drift] = [0.0f64; 3];
    let mut first = None;
    run_alone(&scene.job(end_time, &rest), |e| {
        let all = bodies(e);
        let at = |body: usize, x: f64, z: f64| {
            let centre = V3::new(15.0 * body as f64 + 5.0, 5.0, 5.0);
            place(&all[body], centre, V3::new(x, 5.0, z))
        };
        gap = gap
            .max((at(0, 5.0, 0.0) - V3::new(5.0, 5.0, 0.0)).norm())
            .max((at(0, 5.0, 30.0) - at(1, 5.0, 30.0)).norm())
            .max((at(1, 35.0, 30.0) - at(2, 35.0, 30.0)).norm());
        lean = lean.max(all[0].turn.angle());
        let [kinetic, _] = energy(e);
        let first = *first.get_or_insert(kinetic);
        drift = drift.max((kinetic / first - 1.0).abs());
    });
    eprintln!("gap {gap:e}, lean {lean}, energy {drift:e}");
    [gap, lean, drift]
}

/// A planar linkage has more conditions than unknowns. It moves without binding: gaps stay at
/// round-off, and it keeps its energy.
#[test]
fn a_planar_linkage_does_not_bind() {
    let [gap, lean, drift] = linkage(0.1, 14.0);
    assert!(lean > 1.3 && lean < 1.5, "{lean}");
    assert!(gap < 1e-9, "{gap:e}");
    assert!(drift < 1e-4, "{drift:e}");
}

/// Where all bars of the linkage are in one line it may go on in two ways, and more of its
/// conditions depend on each other. It passes this position with small gaps and keeps its energy.
#[test]
fn a_linkage_passes_its_singular_position() {
    let [gap, lean, drift] = linkage(0.1, 60.0);
    assert!(lean > 3.0, "half a turn: {lean}");
    assert!(gap < 1e-3, "{gap:e}");
    assert!(drift < 0.01, "{drift:e}");
}

/// Two hinged boxes fall on a wall: no node ends behind it, the hinge stays closed, and both rest
/// at the end.
#[test]
fn joints_and_walls_agree() {
    let rest = "[time]\ndt_max = 0.05\n[[gravity]]\nacceleration = [0.0, 0.0, -0.1]\n\
                [[wall]]\npoint = [0.0, 0.0, -2.0]\nnormal = [0.1, 0.0, 1.0]\nfriction = 0.8\n\
                [[joint]]\nname = \"hinge\"\nkind = \"revolute\"\nbodies = [\"a\", \"b\"]\n\
                point = [12.0, 5.0, 5.0]\naxis = [0.0, 1.0, 0.0]\n";
    let (mut deepest, mut gap, mut speed) = (0.0f64, 0.0f64, 0.0);
    let normal = V3::new(0.1, 0.0, 1.0).normalize();
    let end = run_alone(&pair(60.0, rest), |e| {
        let all = bodies(e);
        let hinge = V3::new(12.0, 5.0, 5.0);
        let [a, b] = [0, 1].map(|k| place(&all[k], CENTRES[k], hinge));
        gap = gap.max((a - b).norm());
        for x in &e.nodes.x[..e.nodes.local_count] {
            let depth = -normal.dot(&(V3::new(x[0], x[1], x[2]) - V3::new(0.0, 0.0, -2.0)));
            deepest = deepest.max(depth);
        }
        speed = all[0].last.velocity.norm() + all[1].last.velocity.norm();
    });
    eprintln!("depth {deepest:e}, gap {gap:e}, speed {speed:e}");
    assert!(gap < 1e-11, "{gap:e}");
    assert!(deepest < 1e-7, "{deepest:e}");
    assert!(speed < 1e-6, "{speed:e}");
    let wall = end.ledger.energies(&end.nodes, &end.blocks).values().wall;
    assert!(wall < 0.0, "the impact takes energy: {wall}");
}

/// A hinged pair with a spring and a stop, in contact with a plate and above a wall: the same bits
/// on 1, 2 and 4 workers, with forced renewals, and after an interruption.
#[test]
fn bits_do_not_depend_on_workers_or_interruptions() {
    let mut scene = Bodies::default();
    scene.cuboid([0.0, 0.0, 2.0], [2, 2, 2], 5.0);
    scene.cuboid([15.0, 0.0, 2.0], [3, 2, 2], 5.0);
    scene.plate([-5.0, -5.0, 0.0], [9, 4], 5.0);
    let rest = "[[rigid]]\nname = \"a\"\nparts = [1]\n[[rigid]]\nname = \"b\"\nparts = [2]\n\
                [[wall]]\npoint = [0.0, 0.0, -2.0]\nnormal = [0.0, 0.0, 1.0]\nfriction = 0.2\n\
                [[joint]]\nname = \"hinge\"\nkind = \"revolute\"\nbodies = [\"a\", \"b\"]\n\
                point = [12.0, 5.0, 7.0]\naxis = [0.0, 1.0, 0.2]\n[joint.rotation]\n\
                stiffness = 0.5\nfriction = 0.1\ndamping = 0.1\nstops = [-0.01, 0.02]\n\
                [[initial_velocity]]\nnodes = \"part_1\"\nvelocity = [0.0, 0.0, -12.0]\n\
                [[initial_velocity]]\nnodes = \"part_2\"\nvelocity = [0.0, 2.0, -9.0]\n\
                [contact]\nfriction = 0.3\n";
    let model = scene.job(0.4, rest);
    let serial = run_side_by_side(&model, 1, 600, 0);
    let met: usize = serial.pairs.iter().map(Vec::len).sum();
    assert!(serial.trouble.is_none() && met > 500, "{met} pairs in {} cycles", serial.pairs.len());
    for (workers, force) in [(2, 0), (4, 7)] {
        let parallel = run_side_by_side(&model, workers, 600, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
    let [straight, interrupted] =
        [300, 101].map(|at| run_interrupted(&model, Plan { at, cycles: 300, workers: [1, 3] }));
    assert_eq!(straight, interrupted, "continued from a checkpoint in cycle 101");
}
