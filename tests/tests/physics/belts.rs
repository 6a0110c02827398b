//! Seat belts compared with closed forms: masses on belts, over slip rings, on retractors. Units of
//! the closed forms.

use crumple::input::job::{Model, read_text};
use crumple_proto::histories::BeltRecord;
use crumple_tests::restart::{Plan, run_interrupted};
use crumple_tests::{run_alone, run_side_by_side};
use crumple_verification::scene::{Elastic, Scene};
use crumple_worker::engine::Engine;
use std::f64::consts::{FRAC_PI_2, PI};

/// Stiffness of the belts, force over strain.
const EA: f64 = 400.0;
/// Mass of a belt per length, far below that of the masses that it holds.
const LIGHT: f64 = 1e-6;

fn model(scene: &Scene) -> Model {
    let model = read_text("belts.toml".into(), scene.text("Belts"), &[]);
    model.unwrap_or_else(|report| panic!("{report}"))
}

/// Adds the part of the belts.
fn part(scene: &mut Scene, mass: f64, min_length: f64, more: &str) {
    scene.add(&format!(
        "[[part]]\nid = 1\n[part.belt]\n\
         force_strain = [[0.0, 0.0], [0.001, {:?}], [1.0, {EA:?}]]\n\
         mass_per_length = {mass:?}\nmin_length = {min_length:?}\n{more}",
        0.001 * EA
    ));
}

/// Adds a belt through points. Returns its nodes.
fn belt(scene: &mut Scene, points: &[[f64; 3]]) -> Vec<u32> {
    let nodes: Vec<u32> = points.iter().map(|x| scene.node(*x)).collect();
    nodes.windows(2).for_each(|ends| scene.spring(1, [ends[0], ends[1]]));
    nodes
}

/// Returns `count + 1` points from one point to another.
fn line(from: [f64; 3], to: [f64; 3], count: usize) -> impl Iterator<Item = [f64; 3]> {
    (0..=count).map(move |k| {
        let share = k as f64 / count as f64;
        [0, 1, 2].map(|c| from[c] + share * (to[c] - from[c]))
    })
}

fn records(e: &Engine) -> Vec<BeltRecord> {
    e.constraints.belts.records()
}

/// Largest error of the energy balance over the largest energy that has been moved.
#[derive(Default)]
struct Ledger {
    first: Option<f64>,
    error: f64,
    moved: f64,
}

impl Ledger {
    fn record(&mut self, e: &Engine) {
        let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
        let now = energies.kinetic + energies.internal - energies.external;
        let first = *self.first.get_or_insert(now);
        self.error = self.error.max((now - first).abs());
        self.moved = self.moved.max(energies.kinetic).max(energies.external.abs());
    }

    /// Asserts that the balance is closed to a part of the energy that has been moved.
    fn assert_closed(&self, part: f64) {
        assert!(self.error < part * self.moved, "{:e} of {:e}", self.error, self.moved);
    }
}

/// Mass m on a belt of the stiffness k: half a period of a swing, then it flies away with the
/// velocity it came with. Central differences are ahead by the angle `pi (w dt)^2 / 24`.
#[test]
fn a_mass_swings_on_a_belt_and_leaves_it_slack() {
    let (m, v, length) = (2.0, 0.5, 10.0);
    let w = f64::sqrt(EA / length / m);
    let mut scene = Scene::new(1.5 * PI / w);
    part(&mut scene, LIGHT, 1.0, "");
    let nodes = belt(&mut scene, &[[0.0; 3], [length, 0.0, 0.0]]);
    scene.fix(&nodes[..1], "x y z");
    scene.mass(&nodes[1..], m);
    scene.start(&nodes[1..], [v, 0.0, 0.0], [0.0; 3]);
    scene.time(&format!("dt_max = {:?}", 0.01 / w));
    let (mut worst, mut ledger) = (0.0f64, Ledger::default());
    run_alone(&model(&scene), |e| {
        let t = e.clock.time;
        let exact = if w * t < PI { v / w * (w * t).sin() } else { -v * (t - PI / w) };
        worst = worst.max((e.nodes.x[1][0] - length - exact).abs() / (v / w));
        ledger.record(e);
    });
    // Half a step of the jump of the stiffness at the end of the swing, and the mass of the belt.
    assert!(worst < 1e-4, "{worst:e}");
    ledger.assert_closed(1e-10);
}

/// With a steeper line for unloading of the stiffness u the mass comes back with `v sqrt(k/u)`.
#[test]
fn unloading_keeps_energy() {
    let (m, v, length) = (2.0, 0.5, 10.0);
    let w = f64::sqrt(EA / length / m);
    let mut scene = Scene::new(1.5 * PI / w);
    part(&mut scene, LIGHT, 1.0, &format!("unloading = [[0.0, 0.0], [0.25, {EA:?}]]"));
    let nodes = belt(&mut scene, &[[0.0; 3], [length, 0.0, 0.0]]);
    scene.fix(&nodes[..1], "x y z");
    scene.mass(&nodes[1..], m);
    scene.start(&nodes[1..], [v, 0.0, 0.0], [0.0; 3]);
    scene.time(&format!("dt_max = {:?}", 0.01 / w));
    let mut ledger = Ledger::default();
    let end = run_alone(&model(&scene), |e| ledger.record(e));
    // The force jumps in the step of the turn: (w dt)^2, and one step at the end.
    assert!((end.nodes.v[1][0] / v + 0.5).abs() < 5e-4, "{}", end.nodes.v[1][0]);
    ledger.assert_closed(1e-10);
}

/// Forces on the masses over a ring, and what follows from Newton and the friction mu of the ring:
/// with the ratio `r = exp(mu pi/2)` the acceleration `(F - r G)/(m + r m)`, and the tensions.
struct Atwood {
    ratio: f64,
    acceleration: f64,
    tensions: [f64; 2],
}

impl Atwood {
    fn new([f, g]: [f64; 2], friction: f64) -> Self {
        let ratio = f64::exp(friction * FRAC_PI_2);
        let acceleration = (f - ratio * g) / (1.0 + ratio);
        Self { ratio, acceleration, tensions: [f - acceleration, g + acceleration] }
    }
}

/// A unit mass at each end of a belt with `count` elements on each side of a ring, at which it
/// turns by 90 degrees. The belt has these tensions at the start.
fn over_a_ring(
    (forces, tensions): ([f64; 2], [f64; 2]),
    (count, mass): (usize, f64),
    end_time: f64,
    ring: &str,
) -> (Scene, Vec<u32>) {
    let mut scene = Scene::new(end_time);
    part(&mut scene, mass, 2.0, "damping = 0.5");
    let (down, along) = ([0.0, 0.0, -40.0], [40.0, 0.0, 0.0]);
    let points: Vec<[f64; 3]> =
        line(down, [0.0; 3], count).chain(line([0.0; 3], along, count).skip(1)).collect();
    let nodes = belt(&mut scene, &points);
    let ends = [nodes[0], nodes[2 * count]];
    scene.fix(&nodes[count..=count], "x y z");
    for ((end, force), axis) in ends.iter().zip(forces).zip([2, 0]) {
        let mut vector = [0.0; 3];
        vector[axis] = if axis == 2 { -force } else { force };
        scene.mass(&[*end], 1.0);
        let set = scene.set(&[*end]);
        scene.add(&format!("[[load]]\nnodes = \"{set}\"\nforce = {vector:?}"));
    }
    let lengths: String = (0..2 * count)
        .map(|k| {
            let length = 40.0 / count as f64 / (1.0 + tensions[k / count] / EA);
            format!("[{}.0, {length:?}],", k + 1)
        })
        .collect();
    scene.add(&format!(
        "[belts]\nunstretched = [{lengths}]\n\
         [[belts.ring]]\nname = \"d\"\nnode = {}\n{ring}",
        nodes[count]
    ));
    (scene, nodes)
}

/// Speed of the first mass at the end.
fn speed(end: &Engine, nodes: &[u32]) -> f64 {
    -end.nodes.v[at(end, nodes[0])][2]
}

fn at(e: &Engine, node: u32) -> usize {
    e.nodes.local_index(crumple_proto::ids::NodeId(node.into())).expect("a node") as usize
}

/// Atwood's machine, without and with friction.
#[test]
fn masses_over_a_ring_accelerate_as_atwood_says() {
    for friction in [0.0, 0.2] {
        let (forces, time) = ([3.0, 1.0], 5.0);
        let exact = Atwood::new(forces, friction);
        let ring = format!("friction = {friction:?}");
        let (mut scene, nodes) = over_a_ring((forces, exact.tensions), (1, LIGHT), time, &ring);
        scene.time("dt_max = 0.01");
        let (mut ledger, mut worst) = (Ledger::default(), 0.0f64);
        let mut length = None;
        let end = run_alone(&model(&scene), |e| {
            ledger.record(e);
            let total: f64 = records(e)[..2].iter().map(|r| r.length).sum();
            worst = worst.max((total - *length.get_or_insert(total)).abs());
        });
        let a = speed(&end, &nodes) / (time - 0.5 * end.clock.last_dt);
        assert!((a / exact.acceleration - 1.0).abs() < 1e-3, "{friction}: {a}");
        assert!(worst < 1e-12 * 80.0, "the length changes by {worst:e}");
        let ring = records(&end)[2];
        assert!((ring.tensions[0] / ring.tensions[1] - exact.ratio).abs() < 1e-9, "{ring:?}");
        // Unstretched, as it comes from the second side.
        let last = time - end.clock.last_dt;
        let slid = 0.5 * exact.acceleration * last * last / (1.0 + exact.tensions[1] / EA);
        assert!((ring.length / slid - 1.0).abs() < 2e-3, "{} {slid}", ring.length);
        let heat = (exact.tensions[0] - exact.tensions[1]) * slid;
        assert!((ring.energy - heat).abs() <= 2e-3 * heat + 1e-9, "{} {heat}", ring.energy);
        ledger.assert_closed(1e-9);
    }
}

/// Below the limit of friction nothing moves: both sides hold their own force. A locked ring holds
/// any forces.
#[test]
fn friction_holds_unequal_forces() {
    for (forces, ring) in
        [([1.3, 1.0], "friction = 0.2"), ([3.0, 1.0], "friction = 0.0\nlock_time = 0.0")]
    {
        let (mut scene, nodes) = over_a_ring((forces, forces), (1, LIGHT), 10.0, ring);
        scene.time("dt_max = 0.01");
        let end = run_alone(&model(&scene), |_| ());
        let [a, b, ring] = records(&end)[..] else { panic!("two segments and a ring") };
        assert!((a.tensions[0] - forces[0]).abs() < 1e-9, "{a:?}");
        assert!((b.tensions[0] - forces[1]).abs() < 1e-9, "{b:?}");
        assert_eq!(ring.length, 0.0);
        assert!(speed(&end, &nodes).abs() < 1e-9);
    }
}

/// Nodes pass the ring as belt moves; masses accelerate as with one segment on each side, and the
/// length of the belt and the energy balance stay. The mass of the belt is 1% of theirs.
#[test]
fn nodes_pass_a_ring() {
    let (time, forces) = (7.0, [3.0, 1.0]);
    let exact = Atwood::new(forces, 0.1);
    let (scene, nodes) = over_a_ring((forces, exact.tensions), (10, 1e-4), time, "friction = 0.1");
    let (mut ledger, mut worst, mut length) = (Ledger::default(), 0.0f64, None);
    let end = run_alone(&model(&scene), |e| {
        ledger.record(e);
        let total: f64 = records(e)[..20].iter().map(|r| r.length).sum();
        worst = worst.max((total - *length.get_or_insert(total)).abs());
    });
    assert!(worst < 1e-12 * 80.0, "the length changes by {worst:e}");
    let v = speed(&end, &nodes);
    let a = exact.acceleration;
    assert!((v / (a * time) - 1.0).abs() < 0.02, "{} {a}", v / time);
    let passed = nodes[11..].iter().filter(|&&n| end.nodes.x[at(&end, n)][2] < -1e-6).count();
    let slid = 0.5 * a * time * time;
    assert!((passed as f64 - slid / 4.0).abs() < 1.5, "{passed} nodes for {slid}");
    ledger.assert_closed(1e-9);
}

/// A mass drawn by a force from a retractor with wound up nodes. Before it locks the belt has the
/// first tension of its curve, and after that the curve of the pull-out since then.
#[test]
fn a_retractor_lets_belt_out_and_locks() {
    let (force, mass, lock) = (4.0, 1.0, 3.0);
    let mut scene = Scene::new(12.0);
    part(&mut scene, 1e-3, 1.0, "damping = 2.0");
    let points: Vec<[f64; 3]> =
        [[0.0; 3]; 5].into_iter().chain(line([0.0; 3], [10.0, 0.0, 0.0], 2)).collect();
    let nodes = belt(&mut scene, &points);
    let (reel, end) = (nodes[5], nodes[7]);
    scene.fix(&[reel], "x y z");
    scene.mass(&[end], mass);
    let set = scene.set(&[end]);
    let ids: String = (1..=5).map(|id| format!("[{id}.0, 5.0],")).collect();
    scene.add(&format!(
        "[[load]]\nnodes = \"{set}\"\nforce = [{force:?}, 0.0, 0.0]\n\
         [belts]\nunstretched = [{ids}]\n\
         [[belts.sensor]]\nname = \"time\"\ntime = 2.0\n\
         [[belts.retractor]]\nname = \"reel\"\nnode = {reel}\nsensors = [\"time\"]\ndelay = 1.0\n\
         force_pull_out = [[0.0, 1.0], [5.0, 6.0], [6.0, 6.0]]\n\
         unloading = [[0.0, 0.0], [1.0, 6.0]]"
    ));
    let (mut ledger, mut before, mut begin, mut speed) = (Ledger::default(), 0.0, None, 0.0);
    let mut largest = 0.0f64;
    let stop = run_alone(&model(&scene), |e| {
        ledger.record(e);
        let reel = records(e)[7];
        assert_eq!(reel.locked, e.clock.time - e.clock.last_dt >= lock, "{}", e.clock.time);
        if reel.locked {
            let begin = *begin.get_or_insert(before);
            let way = reel.length - begin;
            if way >= largest && way > 0.1 {
                let held = (1.0 + way).min(6.0);
                assert!((reel.tensions[0] - held).abs() < 1e-6, "{way} {reel:?}");
            }
            largest = largest.max(way);
        } else {
            assert!((reel.tensions[0] - 1.0).abs() < 1e-6, "{reel:?}");
            before = reel.length;
            speed = e.nodes.v[e.nodes.local_count - 1][0];
        }
    });
    // The belt between has mass, strain and damping: a percent of the force.
    assert!((speed / ((force - 1.0) / mass * lock) - 1.0).abs() < 0.03, "{speed}");
    let reel = records(&stop)[7];
    // 0.5 m v^2 = work of the curve less that of the force over the way after locking.
    let work = |way: f64| {
        let held = if way < 5.0 { way + 0.5 * way * way } else { 17.5 + 6.0 * (way - 5.0) };
        held - force * way
    };
    let energy = 0.5 * mass * speed * speed;
    assert!((work(largest) / energy - 1.0).abs() < 0.03, "{largest} {} {energy}", work(largest));
    let out = stop.nodes.x.iter().filter(|x| x[0] > 1e-3).count();
    assert_eq!(out, 7, "all wound up nodes have come out");
    assert!(reel.length < begin.unwrap() + largest, "it has gone back: {reel:?}");
    ledger.assert_closed(1e-9);
}

/// A pretensioner pulls belt in against a fixed end: the tension is that of the strain, up to its
/// limit; its work is external, and the retractor is locked then.
#[test]
fn a_pretensioner_pulls_belt_in() {
    for (limit, tension) in [("", EA * (10.0 / 9.5 - 1.0)), ("force_limit = 8.0\n", 8.0)] {
        let mut scene = Scene::new(6.0);
        part(&mut scene, 0.01, 1.0, "damping = 1.0");
        let nodes = belt(&mut scene, &line([0.0; 3], [10.0, 0.0, 0.0], 2).collect::<Vec<_>>());
        scene.fix(&[nodes[0], nodes[2]], "x y z");
        scene.add(&format!(
            "[[belts.sensor]]\nname = \"time\"\ntime = 1.0\n\
             [[belts.retractor]]\nname = \"reel\"\nnode = {}\n\
             force_pull_out = [[0.0, 0.0], [1.0, 1000.0]]\n\
             [[belts.pretensioner]]\nname = \"charge\"\nretractor = \"reel\"\n\
             sensors = [\"time\"]\n\
             pull_in = [[0.0, 0.0], [3.0, 0.5]]\n{limit}",
            nodes[2]
        ));
        let mut ledger = Ledger::default();
        let end = run_alone(&model(&scene), |e| ledger.record(e));
        let reel = records(&end)[2];
        assert!(reel.locked);
        // Locked with its own tension, it lets nothing out except in small swings of the node
        // between.
        assert!((reel.tensions[0] / tension - 1.0).abs() < 0.02, "{reel:?} {tension}");
        let strain = tension / EA;
        let work = 0.5 * tension * 10.0 * strain / (1.0 + strain);
        let external = end.ledger.energies(&end.nodes, &end.blocks).values().external;
        assert!((external / work - 1.0).abs() < 0.03, "{external} {work}");
        ledger.assert_closed(0.01);
    }
}

/// A belt over a ring on a plate, with a retractor on another plate and a pretensioner.
fn plates(end_time: f64) -> Model {
    let mut scene = Scene::new(end_time).in_units("mm, ms, kg");
    scene.elastic("steel", Elastic { e: 207.0, nu: 0.3, rho: 7.85e-6 });
    scene.part(2, "steel", 1.0, "");
    let low = scene.grid(2, [4, 4], |a, b| [100.0 * a, 100.0 * b, 0.0]);
    let high = scene.grid(2, [4, 4], |a, b| [100.0 * a, 100.0 * b, 400.0]);
    part(&mut scene, 6e-5, 10.0, "damping = 5.0");
    let (ring, reel) = (high.at(2, 2), low.at(2, 2));
    let chest = scene.node([600.0, 50.0, 300.0]);
    let up: Vec<u32> = line([50.0, 50.0, 0.0], [50.0, 50.0, 400.0], 8)
        .skip(1)
        .take(7)
        .map(|x| scene.node(x))
        .collect();
    let out: Vec<u32> = line([50.0, 50.0, 400.0], [600.0, 50.0, 300.0], 10)
        .skip(1)
        .take(9)
        .map(|x| scene.node(x))
        .collect();
    let inside: Vec<u32> = (0..4).map(|_| scene.node([50.0, 50.0, 0.0])).collect();
    let all: Vec<u32> = inside
        .into_iter()
        .chain([reel])
        .chain(up)
        .chain([ring])
        .chain(out)
        .chain([chest])
        .collect();
    all.windows(2).for_each(|ends| scene.spring(1, [ends[0], ends[1]]));
    scene.mass(&[chest], 5.0);
    scene.start(&[chest], [10.0, 0.0, 0.0], [0.0; 3]);
    for grid in [&low, &high] {
        let rim = grid.rim();
        scene.fix(&rim, "x y z rx ry rz");
    }
    let first = 33; // after 32 shells
    let ids: String = (first..first + 4).map(|id| format!("[{id}.0, 20.0],")).collect();
    scene.add(&format!(
        "[belts]\nunstretched = [{ids}]\n\
         [[belts.sensor]]\nname = \"rate\"\nretractor = \"reel\"\npull_out_rate = 1.0\n\
         duration = 0.5\n[[belts.sensor]]\nname = \"time\"\ntime = 1.0\n\
         [[belts.ring]]\nname = \"d\"\nnode = {ring}\nfriction = 0.1\nstatic_friction = 0.2\n\
         decay = 0.5\n[[belts.retractor]]\nname = \"reel\"\nnode = {reel}\nsensors = [\"rate\"]\n\
         delay = 3.0\nforce_pull_out = [[0.0, 0.05], [50.0, 4.0]]\n\
         unloading = [[0.0, 0.0], [10.0, 4.0]]\n\
         [[belts.pretensioner]]\nname = \"charge\"\nretractor = \"reel\"\nsensors = [\"time\"]\n\
         pull_in = [[0.0, 0.0], [2.0, 30.0]]\nforce_limit = 2.0"
    ));
    model(&scene)
}

/// No bit depends on the workers, and a run that is interrupted continues with the same bits, in
/// each stage of the devices.
#[test]
fn belts_are_the_same_on_any_workers_and_after_a_restart() {
    let model = plates(12.0);
    let mut reels: Vec<BeltRecord> = Vec::new();
    let last = run_alone(&model, |e| reels.extend(records(e).last()));
    let pulled_in: f64 = reels.windows(2).map(|r| (r[0].length - r[1].length).max(0.0)).sum();
    assert!(pulled_in > 1.0, "{pulled_in}");
    assert!(!reels[0].locked && reels[reels.len() - 1].locked);
    assert!(records(&last)[records(&last).len() - 2].length.abs() > 10.0, "it slides");
    let one = run_side_by_side(&model, 1, 1_000_000, 0);
    for (workers, force) in [(2, 0), (3, 400), (5, 150)] {
        let other = run_side_by_side(&model, workers, 1_000_000, force);
        assert_eq!(other.digest(), one.digest(), "{workers} workers, renewed every {force}");
    }
    let count = one.pairs.len() as u64;
    for part in [1, 3, 7, 12, 18] {
        let plan = Plan { at: count * part / 20, cycles: 1_000_000, workers: [2, 3] };
        assert_eq!(run_interrupted(&model, plan), one.digest(), "{plan:?}");
    }
}

/// All errors of a job are reported at once, with their places.
#[test]
fn bad_belts_are_refused() {
    let refused = |part_keys: &str, rest: &str| -> String {
        let mut scene = Scene::new(1.0);
        scene.add(&format!("[[part]]\nid = 1\n[part.belt]\n{part_keys}"));
        belt(&mut scene, &line([0.0; 3], [10.0, 0.0, 0.0], 4).collect::<Vec<_>>());
        scene.fix(&[1], "x y z");
        scene.add(rest);
        let read = read_text("belts.toml".into(), scene.text("Bad"), &[]);
        read.err().unwrap_or_else(|| panic!("it passes: {part_keys} {rest}")).to_string()
    };
    let sound =
        "force_strain = [[0.0, 0.0], [0.1, 9.0]]\nmass_per_length = 0.1\nmin_length = 1.0\n";
    let ring = "[[belts.ring]]\nname = \"d\"\n";
    let reel = "[[belts.retractor]]\nname = \"r\"\nforce_pull_out = [[0.0, 1.0], [1.0, 2.0]]\n";
    for (part_keys, rest, words) in [
        (
            "force_strain = [[0.0, 1.0], [0.1, 0.5]]\nmass_per_length = 0.0\nmin_length = -1.0\n",
            String::new(),
            &["begins with [0.0, 1.0]", "mass_per_length is 0", "min_length is -1"][..],
        ),
        (
            "force_strain = [[0.0, 0.0], [0.1, 9.0]]\nunloading = [[0.0, 0.0], [0.2, 9.0]]\n\
             mass_per_length = 0.1\nmin_length = 3.0\n",
            String::new(),
            &["unloading is less steep"],
        ),
        (
            "force_strain = [[0.0, 0.0], [0.1, 9.0]]\nmass_per_length = 0.1\nmin_length = 3.0\n",
            String::new(),
            &["below its min_length 3"],
        ),
        (
            sound,
            format!(
                "[belts]\nunstretched = [[9.0, 1.0], [1.0, 0.0]]\n{ring}node = 77\n\
                 {ring}node = 1\nfriction = -1.0\n{reel}node = 3\nsensors = [\"no\"]\n\
                 [[belts.sensor]]\nname = \"s\"\n\
                 [[belts.sensor]]\nname = \"t\"\ntime = 1.0\nduration = 2.0\n\
                 [[belts.pretensioner]]\nname = \"p\"\nretractor = \"x\"\nsensors = []\n\
                 pull_in = [[0.0, 0.0], [1.0, -1.0]]\n"
            ),
            &[
                "no element 9 belongs to a belt",
                "unstretched length of element 1 is 0",
                "no element has node 77",
                "have the name `d`",
                "node 1 is an end of its belt",
                "`friction` is -1",
                "node 3 is not at an end of its belt",
                "there is no sensor `no`",
                "has no kind or several",
                "do not use `duration`",
                "there is no retractor `x`",
                "no sensor fires it",
                "pull_in goes from 0.0 to -1.0",
            ],
        ),
        (
            sound,
            format!("{reel}node = 5\n{ring}node = 5\n[restart]\ndelete = [1]\n"),
            &["has another ring or retractor", "part 1 is a seat belt"],
        ),
    ] {
        let report = refused(part_keys, &rest);
        for word in words {
            assert!(report.contains(word), "{word}: {report}");
        }
    }
}
