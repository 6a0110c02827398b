//! Springs and dampers compared with closed forms, and the same bits on any number of workers.
//! Units of the closed forms.

use crumple::input::job::Model;
use crumple_tests::{read, run_alone, run_side_by_side};
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;

/// Returns a job of `springs`, each in its own part: ends as numbers of `nodes` from 1, and the
/// contents of `[part.spring]`. The set `n1` holds the first node, and so on. `rest` is the rest
/// of the job.
fn scene(nodes: &[[f64; 3]], springs: &[([usize; 2], &str)], end_time: f64, rest: &str) -> Model {
    let (mut points, mut sets, mut rows, mut parts) =
        (String::new(), String::new(), String::new(), String::new());
    for (id, [x, y, z]) in (1..).zip(nodes) {
        points += &format!("[{id}, {x:?}, {y:?}, {z:?}],\n");
        sets += &format!("n{id} = [{id}], ");
    }
    for (id, ([a, b], numbers)) in (1..).zip(springs) {
        rows += &format!("[{id}, {id}, {a}, {b}],\n");
        parts += &format!("[[part]]\nid = {id}\n[part.spring]\n{numbers}\n");
    }
    let text = format!(
        "end_time = {end_time:?}\n[mesh]\nnodes = [{points}]\nsprings = [{rows}]\n\
         node_sets = {{ {sets} }}\n\
         [output]\nfield_interval = -1.0\n{parts}{rest}"
    );
    let there = tempfile::tempdir().unwrap();
    let path = there.path().join("springs.toml");
    std::fs::write(&path, text).unwrap();
    read(&path, &[])
}

const HELD: &str = "[[fix]]\nnodes = \"n1\"\ndofs = [\"x\", \"y\", \"z\"]\n";

/// Error of the energy balance while the step is constant: velocities start at a whole time, and
/// the last steps are cut.
#[derive(Default)]
struct Balance {
    first: Option<f64>,
    worst: f64,
}

impl Balance {
    fn look(&mut self, e: &Engine) {
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
            "{HELD}[[mass]]\nnodes = \"n2\"\nmass = {m:?}\n[time]\ndt_max = {:?}\n\
             [[initial_velocity]]\nnodes = \"n2\"\nvelocity = [{v:?}, 0.0, 0.0]\n",
            step / w
        );
        let model = scene(&[[0.0; 3], at], &[([1, 2], numbers)], 20.0 / w, &rest);
        let (mut worst, mut balance) = (0.0f64, Balance::default());
        run_alone(&model, |e| {
            let exact = v / w * (w * e.clock.time).sin();
            worst = worst.max((e.nodes.x[1][0] - at[0] - exact).abs() / (v / w));
            balance.look(e);
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
        "{HELD}[[mass]]\nnodes = \"n2\"\nmass = {m:?}\n[time]\ndt_max = {dt:?}\n\
         [[initial_velocity]]\nnodes = \"n2\"\nvelocity = [{v:?}, 0.0, 0.0]\n"
    );
    for numbers in ["damping = 0.8", "force_rate = [[-1.0, -0.8], [1.0, 0.8]]"] {
        let model = scene(&[[0.0; 3], [20.0, 0.0, 0.0]], &[([1, 2], numbers)], 2.0, &rest);
        let mut balance = Balance::default();
        let end = run_alone(&model, |e| balance.look(e));
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
                [time]\nsafety = 0.1\n\
                [[initial_velocity]]\nnodes = \"n1\"\nvelocity = [1.0, 2.0, -0.5]\n\
                [[initial_velocity]]\nnodes = \"n2\"\nvelocity = [0.3, -0.2, 0.6]\n";
    let springs = [
        ([1, 2], "force_elongation = [[-1.0, -2.0], [0.0, 0.0], [0.5, 2.0], [1.0, 8.0]]"),
        ([1, 2], "damping = 0.1"),
    ];
    let mut first = None;
    let (mut worst, mut balance) = ([0.0f64; 2], Balance::default());
    run_alone(&scene(&[[0.0; 3], [1.0, 0.5, 0.0]], &springs, 30.0, rest), |e| {
        let (p, l) = momentum(&e.nodes);
        let now = [p, l];
        let first = *first.get_or_insert(now);
        for k in 0..2 {
            worst[k] = (0..3).map(|c| (now[k][c] - first[k][c]).abs()).fold(worst[k], f64::max);
        }
        balance.look(e);
    });
    assert!(worst[0] < 1e-12 && worst[1] < 1e-11, "round-off of several thousand steps: {worst:?}");
    assert!(balance.worst < 1e-11, "{}", balance.worst);
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
    let springs: Vec<([usize; 2], &str)> = pairs.map(|p| (p, "stiffness = 4.0")).collect();
    let masses: String =
        (1..=8).map(|i| format!("[[mass]]\nnodes = \"n{i}\"\nmass = 1.0\n")).collect();
    let job = |safety: f64| {
        let rest = format!(
            "{masses}[time]\nsafety = {safety:?}\ndt_min_ratio = 0.0\n\
             [[initial_velocity]]\nnodes = \"n3\"\nvelocity = [1e-6, 2e-6, 0.0]\n"
        );
        scene(&nodes, &springs, 150.0, &rest)
    };
    let mut most = 0.0f64;
    run_alone(&job(1.0), |e| most = most.max(e.nodes.v[4][0].abs()));
    let wild = run_side_by_side(&job(1.8), 1, 400, 0);
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
    let (mut nodes, mut shells, mut springs) = (String::new(), String::new(), String::new());
    let (mut ground, mut upper, mut spring) = (Vec::new(), Vec::new(), 1000);
    for i in 0..5 {
        for j in 0..5 {
            let n = 5 * i + j + 1;
            let (x, y) = (10.0 * i as f64, 10.0 * j as f64);
            nodes += &format!(
                "[{n}, {x:?}, {y:?}, 0.0], [{}, {x:?}, {y:?}, -8.0], [{}, {x:?}, {y:?}, 9.0],\n",
                n + 100,
                n + 200
            );
            ground.push(n + 100);
            upper.push(n + 200);
            for (part, ends) in [(3 + (i + j) % 2, [n, n + 100]), (5, [n, n + 200])] {
                springs += &format!("[{spring}, {part}, {}, {}],\n", ends[0], ends[1]);
                spring += 1;
            }
            if i < 4 && j < 4 {
                shells += &format!("[{n}, 1, {n}, {}, {}, {}],\n", n + 5, n + 6, n + 1);
                shells += &format!(
                    "[{}, 2, {}, {}, {}, {}],\n",
                    n + 50,
                    n + 200,
                    n + 205,
                    n + 206,
                    n + 201
                );
            }
        }
    }
    let text = format!(
        "end_time = 5.0\n[mesh]\nnodes = [{nodes}]\nshells = [{shells}]\nsprings = [{springs}]\n\
         node_sets = {{ ground = {ground:?}, upper = {upper:?} }}\n[output]\n\
         field_interval = -1.0\n\
         [[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
         youngs_modulus = 207.0\npoisson = 0.3\n\
         [[part]]\nid = 1\nmaterial = \"steel\"\nthickness = 1.0\n[[part]]\nid = 2\n\
         material = \"steel\"\nthickness = 2.0\n\
         [[part]]\nid = 3\n[part.spring]\nstiffness = 0.02\ndamping = 1e-4\n\
         [[part]]\nid = 4\n[part.spring]\nforce_elongation = [[-1.0, -0.03], [0.0, 0.0], [1.0, \
         0.01]]\ndirection = [0.1, 0.0, 1.0]\n\
         [[part]]\nid = 5\n[part.spring]\nforce_rate = [[-1.0, -2e-5], [0.0, 0.0], [1.0, 1e-5]]\n\
         stiffness = 1e-4\n\
         [[rigid]]\nname = \"upper\"\nparts = [2]\n[contact]\n\
         [[fix]]\nnodes = \"ground\"\ndofs = [\"x\", \"y\", \"z\"]\n\
         [[initial_velocity]]\nnodes = \"upper\"\nvelocity = [1.0, 0.5, -8.0]\n\
         spin = [0.02, 0.0, 0.05]\n"
    );
    let there = tempfile::tempdir().unwrap();
    let path = there.path().join("sheet.toml");
    std::fs::write(&path, text).unwrap();
    let model = read(&path, &[]);
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
