//! Springs and dampers compared with closed forms, and the same bits on any number of workers.
//! Units of the closed forms.

use crumple::input::job::{Model, read_text};
use crumple_tests::{run_alone, run_side_by_side};
use crumple_verification::scene::{Elastic, Scene};
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;

/// Returns a job of `springs`, each in its own part: ends as numbers of `nodes` from 1, and the
/// contents of `[part.spring]`. The set `n1` holds the first node, and so on. `time` are the lines
/// of `[time]`, `rest` is the rest of the job.
pub fn job(
    nodes: &[[f64; 3]],
    springs: &[([u32; 2], &str)],
    end_time: f64,
    [time, rest]: [&str; 2],
) -> Model {
    let mut scene = Scene::new(end_time);
    for x in nodes {
        let node = scene.node(*x);
        scene.set_named(&format!("n{node}"), &[node]);
    }
    for (part, (ends, numbers)) in (1..).zip(springs) {
        scene.spring(part, *ends);
        scene.add(&format!("[[part]]\nid = {part}\n[part.spring]\n{numbers}"));
    }
    scene.time(time);
    scene.add(rest);
    model(&scene)
}

pub fn model(scene: &Scene) -> Model {
    let model = read_text("springs.toml".into(), scene.text("Springs"), &[]);
    model.unwrap_or_else(|report| panic!("{report}"))
}

/// Runs a job. Returns the largest changes of momentum and angular momentum, and the largest error
/// of the energy balance.
pub fn drift(model: &Model) -> ([f64; 2], f64) {
    let (mut first, mut worst, mut balance) = (None, [0.0f64; 2], Balance::default());
    run_alone(model, |e| {
        let (p, l) = momentum(&e.nodes);
        let now = [p, l];
        let first = *first.get_or_insert(now);
        for k in 0..2 {
            worst[k] = (0..3).map(|c| (now[k][c] - first[k][c]).abs()).fold(worst[k], f64::max);
        }
        balance.record(e);
    });
    (worst, balance.worst)
}

pub const HELD: &str = "[[fix]]\nnodes = \"n1\"\ndofs = [\"x\", \"y\", \"z\"]\n";

/// Error of the energy balance while the step is constant: velocities start at a whole time, and
/// the last steps are cut.
#[derive(Default)]
pub struct Balance {
    first: Option<f64>,
    pub worst: f64,
}

impl Balance {
    pub fn record(&mut self, e: &Engine) {
        if e.clock.cycle > 2 && e.clock.dt == e.clock.first_dt {
            // `balance` takes a negative kinetic energy, as at a reversal of the motion, as
            // zero.
            let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
            let now = energies.kinetic + energies.internal;
            let first = *self.first.get_or_insert(now);
            self.worst = self.worst.max((now / first - 1.0).abs());
        }
    }
}

/// A mass m on a spring k moves as v/w sin(w t) with w^2 = k/m, along the spring, along a fixed
/// direction, and with a table of forces. Central differences have the frequency 2/dt asin(w
/// dt/2): after the angle w t = 20 they are ahead by 20 (w dt)^2 / 24.
#[test]
fn a_mass_on_a_spring_swings_with_its_frequency() {
    let (k, m, v, step) = (3.0, 2.0, 0.05, 0.02);
    let w = f64::sqrt(k / m);
    for (numbers, at) in [
        ("stiffness = 3.0", [2.0, 0.0, 0.0]),
        ("stiffness = 3.0\ndirection = [5.0, 0.0, 0.0]", [0.0; 3]),
        ("force_elongation = [[-0.01, -0.03], [0.0, 0.0], [0.02, 0.06]]", [2.0, 0.0, 0.0]),
    ] {
        let rest = format!(
            "{HELD}[[mass]]\nnodes = \"n2\"\nmass = {m:?}\n\
             [[initial_velocity]]\nnodes = \"n2\"\nvelocity = [{v:?}, 0.0, 0.0]\n"
        );
        let time = format!("dt_max = {:?}", step / w);
        let model = job(&[[0.0; 3], at], &[([1, 2], numbers)], 20.0 / w, [&time, &rest]);
        let (mut worst, mut balance) = (0.0f64, Balance::default());
        run_alone(&model, |e| {
            let exact = v / w * (w * e.clock.time).sin();
            worst = worst.max((e.nodes.x[1][0] - at[0] - exact).abs() / (v / w));
            balance.record(e);
        });
        assert!(worst < 1.2 * 20.0 * step * step / 24.0, "{numbers}: {worst}");
        assert!(balance.worst < 1e-12, "{numbers}: round-off of 1000 steps: {}", balance.worst);
    }
}

/// A damper c slows a mass by exp(-c t/m). Its force is half a step late, which makes the rate
/// c/m (1 + c dt/2m). The dissipated energy is internal energy.
#[test]
fn a_damper_slows_exponentially() {
    let (c, m, v, dt) = (0.8, 2.0, 3.0, 1e-3);
    let rest = format!(
        "{HELD}[[mass]]\nnodes = \"n2\"\nmass = {m:?}\n\
         [[initial_velocity]]\nnodes = \"n2\"\nvelocity = [{v:?}, 0.0, 0.0]\n"
    );
    let time = format!("dt_max = {dt:?}");
    for numbers in ["damping = 0.8", "force_rate = [[-1.0, -0.8], [1.0, 0.8]]"] {
        let nodes = [[0.0; 3], [20.0, 0.0, 0.0]];
        let model = job(&nodes, &[([1, 2], numbers)], 2.0, [&time, &rest]);
        let mut balance = Balance::default();
        let end = run_alone(&model, |e| balance.record(e));
        let t = end.clock.time - 0.5 * end.clock.last_dt;
        let ratio = end.nodes.v[1][0] / (v * (-c * t / m).exp());
        let late = c * c * dt * t / (2.0 * m * m);
        assert!(
            (ratio - 1.0).abs() < 1.2 * late && (ratio - 1.0).abs() > 0.5 * late,
            "{numbers}: {ratio} {late}"
        );
        assert!(balance.worst < 1e-12, "{numbers}: {}", balance.worst);
        let taken =
            end.ledger.energies(&end.nodes, &end.blocks).values().internal / (0.5 * m * v * v);
        assert!((taken - (1.0 - (-2.0 * c * 2.0 / m).exp())).abs() < 1e-3, "{numbers}: {taken}");
    }
}

/// Two free masses on a hardening spring and a damper fly and turn about each other: momentum,
/// angular momentum and energy are conserved to round-off.
#[test]
fn free_masses_keep_momentum() {
    let rest = "[[mass]]\nnodes = \"n1\"\nmass = 2.0\n[[mass]]\nnodes = \"n2\"\nmass = 5.0\n\
                [[initial_velocity]]\nnodes = \"n1\"\nvelocity = [1.0, 2.0, -0.5]\n\
                [[initial_velocity]]\nnodes = \"n2\"\nvelocity = [0.3, -0.2, 0.6]\n";
    let springs = [
        ([1, 2], "force_elongation = [[-1.0, -2.0], [0.0, 0.0], [0.5, 2.0], [1.0, 8.0]]"),
        ([1, 2], "damping = 0.1"),
    ];
    let model = job(&[[0.0; 3], [1.0, 0.5, 0.0]], &springs, 30.0, ["safety = 0.1", rest]);
    let (worst, balance) = drift(&model);
    assert!(worst[0] < 1e-12 && worst[1] < 1e-11, "round-off of several thousand steps: {worst:?}");
    assert!(balance < 1e-11, "{balance}");
}

/// Eight masses in a ring with springs across: the step at full safety is stable, a step 1.8
/// times as long is not.
#[test]
fn the_step_is_stable_and_not_much_too_short() {
    let ring = |i: usize| {
        let angle = std::f64::consts::TAU * i as f64 / 8.0;
        [angle.cos(), angle.sin(), 0.0]
    };
    let nodes: Vec<[f64; 3]> = (0..8).map(ring).collect();
    let pairs = (1..=8).flat_map(|i| [[i, i % 8 + 1], [i, (i + 2) % 8 + 1]]);
    let springs: Vec<([u32; 2], &str)> = pairs.map(|p| (p, "stiffness = 4.0")).collect();
    let masses: String =
        (1..=8).map(|i| format!("[[mass]]\nnodes = \"n{i}\"\nmass = 1.0\n")).collect();
    let ring = |safety: f64| {
        let time = format!("safety = {safety:?}\ndt_min_ratio = 0.0");
        let rest =
            format!("{masses}[[initial_velocity]]\nnodes = \"n3\"\nvelocity = [1e-6, 2e-6, 0.0]\n");
        job(&nodes, &springs, 150.0, [&time, &rest])
    };
    let mut most = 0.0f64;
    run_alone(&ring(1.0), |e| most = most.max(e.nodes.v[4][0].abs()));
    let wild = run_side_by_side(&ring(1.8), 1, 400, 0);
    assert!(
        most < 1e-5 && (wild.trouble.is_some() || wild.nodes[4].v[0].abs() > 1e-2),
        "{most} {:?}",
        wild.nodes[4]
    );
}

/// A sheet of shells on springs and dampers of all kinds to the ground and to a rigid body: the
/// same bits on 1, 2 and 4 workers, with forced renewals of the boxes.
#[test]
fn bits_do_not_depend_on_workers() {
    let mut scene = Scene::new(5.0).in_units("mm, ms, kg");
    scene.elastic("steel", Elastic { e: 207.0, nu: 0.3, rho: 7.85e-6 });
    scene.part(1, "steel", 1.0, "");
    scene.part(2, "steel", 2.0, "");
    let sheet = scene.grid(1, [4, 4], |u, v| [40.0 * u, 40.0 * v, 0.0]);
    let upper = scene.grid(2, [4, 4], |u, v| [40.0 * u, 40.0 * v, 9.0]);
    let ground: Vec<u32> = (0..25)
        .map(|n| scene.node([10.0 * f64::from(n / 5), 10.0 * f64::from(n % 5), -8.0]))
        .collect();
    for (n, (&node, &above)) in sheet.all().iter().zip(upper.all()).enumerate() {
        scene.spring(3 + (n / 5 + n % 5) as u32 % 2, [node, ground[n]]);
        scene.spring(5, [node, above]);
    }
    scene.set_named("ground", &ground);
    scene.set_named("upper", upper.all());
    scene.add(
        "[[part]]\nid = 3\n[part.spring]\nstiffness = 0.02\ndamping = 1e-4\n\
         [[part]]\nid = 4\n[part.spring]\nforce_elongation = [[-1.0, -0.03], [0.0, 0.0], [1.0, \
         0.01]]\ndirection = [0.1, 0.0, 1.0]\n\
         [[part]]\nid = 5\n[part.spring]\nforce_rate = [[-1.0, -2e-5], [0.0, 0.0], [1.0, 1e-5]]\n\
         stiffness = 1e-4\n\
         [[rigid]]\nname = \"upper\"\nparts = [2]\n[contact]\n\
         [[fix]]\nnodes = \"ground\"\ndofs = [\"x\", \"y\", \"z\"]\n\
         [[initial_velocity]]\nnodes = \"upper\"\nvelocity = [1.0, 0.5, -8.0]\n\
         spin = [0.02, 0.0, 0.05]",
    );
    let model = model(&scene);
    let serial = run_side_by_side(&model, 1, 900, 0);
    let met = serial.pairs.iter().any(|p| !p.is_empty());
    assert!(
        serial.trouble.is_none() && met,
        "{:?} in {} cycles",
        serial.trouble,
        serial.pairs.len()
    );
    for (workers, force) in [(2, 0), (4, 0), (2, 7), (4, 11)] {
        let parallel = run_side_by_side(&model, workers, 900, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}

/// Two rigid shells, the second at z = 100, with a rotational spring between their first corners;
/// the first one has an inertia of 4, or is held.
fn plates(numbers: &str, held: bool, spin: f64, end_time: f64, time: &str) -> Model {
    let mut scene = Scene::new(end_time);
    let places = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    let [a, b] = [0.0, 100.0].map(|z| places.map(|[x, y]| scene.node([x, y, z])));
    scene.set_named("b", &b);
    scene.shell(2, &a);
    scene.shell(3, &b);
    scene.spring(1, [a[0], b[0]]);
    scene.elastic("steel", Elastic { e: 1.0, nu: 0.3, rho: 1.0 });
    for part in [2, 3] {
        scene.part(part, "steel", 1.0, "");
    }
    scene.time(time);
    let fixed = match held {
        true => "fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n",
        false => "",
    };
    scene.add(&format!(
        "[[part]]\nid = 1\n[part.spring]\nrotational = true\n{numbers}\n[[rigid]]\nname = \"a\"\n\
         parts = [2]\ninertia = [4.0, 4.0, 4.0, 0.0, 0.0, 0.0]\n{fixed}[[rigid]]\nname = \"b\"\n\
         parts = [3]\ninertia = [6.0, 6.0, 6.0, 0.0, 0.0, 0.0]\n[[initial_velocity]]\n\
         nodes = \"b\"\nvelocity = [0.0, 0.0, 0.0]\nspin = [0.0, 0.0, {spin:?}]\n\
         centre = [1.0, 1.0, 100.0]\n"
    ));
    model(&scene)
}

/// Bodies of inertia 4 and 6 on a rotational spring about z: the relative rotation swings with
/// `w^2 = k (1/4 + 1/6)`, energy and angular momentum are kept. The first one held, `w^2 = k/6`.
#[test]
fn bodies_on_a_rotational_spring_swing_with_their_frequency() {
    let (k, spin) = (3.0, 0.05);
    for (numbers, held) in [
        ("stiffness = 3.0\ndirection = [0.0, 0.0, 2.0]", false),
        ("stiffness = 3.0", true),
        ("force_elongation = [[-1.0, -3.0], [1.0, 3.0]]\ndirection = [0.0, 0.0, 1.0]", true),
    ] {
        let w = f64::sqrt(k * (1.0 / 6.0 + if held { 0.0 } else { 0.25 }));
        let time = format!("dt_max = {:?}", 0.02 / w);
        let (mut worst, mut stored_worst) = (0.0f64, 0.0f64);
        let (turned, inertia) = if held { (1.0, 6.0) } else { (4.0 / 10.0, 24.0 / 10.0) };
        let end = run_alone(&plates(numbers, held, spin, 20.0 / w, &time), |e| {
            let t = e.clock.time - 0.5 * e.clock.last_dt;
            let of_second = spin * (turned * (w * t).cos() + 1.0 - turned);
            worst = worst.max((e.nodes.w[4][2] - of_second).abs());
            // The energy of the spring, at the time of its last force.
            let at = e.clock.time - e.clock.last_dt;
            let stored = e.ledger.energies(&e.nodes, &e.blocks).values().internal;
            let exact = 0.5 * inertia * (spin * (w * at).sin()).powi(2);
            stored_worst = stored_worst.max((stored - exact).abs() / (0.5 * inertia * spin * spin));
        });
        // Central differences are ahead by 20 (w dt)^2/24 = 3e-4 after the angle w t = 20; the axis
        // of the spring along its line leans with its ends by up to 1e-3.
        assert!(worst < 2e-3 * spin, "{numbers}: {worst}");
        assert!(stored_worst < 2e-3, "{numbers}: {stored_worst}");
        if !held {
            let [a, b] = [0, 4].map(|node: usize| end.nodes.w[node][2]);
            let kept = (4.0 * a + 6.0 * b) / (6.0 * spin);
            assert!((kept - 1.0).abs() < 1e-12, "{kept}");
        }
        // Without a limit of the step the spring is stable, at the step that it asks for.
        let mut most = 0.0f64;
        let end = run_alone(&plates(numbers, held, spin, 400.0 / w, ""), |e| {
            most = most.max(e.nodes.w[4][2].abs());
        });
        assert!(most < 1.5 * spin, "{numbers}: {most}");
        let step = end.clock.first_dt * w;
        // 0.9 of the limit 2/w, times 2/3, because the smallest moment is taken as 4/9 of that
        // of a cube, and times the root of 1/6, the share of springs at shells. A body counts as
        // free also if it is held.
        let free = w / f64::sqrt(k * (1.0 / 6.0 + 0.25));
        let expected = 1.8 * (2.0 / 3.0) * f64::sqrt(1.0 / 6.0) * free;
        assert!((step / expected - 1.0).abs() < 2e-3, "{numbers}: {step}");
    }
}

/// A rotational spring at a node without a rotational inertia of its own is refused by name.
#[test]
fn rotational_springs_need_bodies() {
    let mut scene = Scene::new(1.0);
    let ends = [[0.0; 3], [0.0, 0.0, 1.0]].map(|x| scene.node(x));
    scene.set_named("n1", &ends[..1]);
    scene.set_named("n2", &ends[1..]);
    scene.spring(1, ends);
    scene.add("[[part]]\nid = 1\n[part.spring]\nrotational = true\nstiffness = 1.0\n");
    scene.add(HELD);
    scene.add("[[mass]]\nnodes = \"n2\"\nmass = 1.0\n");
    let found = read_text("springs.toml".into(), scene.text("Springs"), &[]);
    let text = found.err().expect("no body").to_string();
    assert!(text.contains("2 ends of rotational springs") && text.contains("[[rigid]]"), "{text}");
}
