//! Parts that become rigid in a run and deform again: momentum, energy and stresses. Units mm, ms,
//! kg.

use crumple::input::job::{self, Model};
use crumple_tests::restart::{Plan, run_interrupted};
use crumple_tests::{run_alone, run_side_by_side};
use crumple_verification::scene::{Elastic, Scene};
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;

/// A bar of steel that spins, drifts and vibrates along its length, part 1, with these keys of its
/// rigid body.
fn bar(end_time: f64, keys: &str) -> Model {
    let mut scene = Scene::new(end_time).in_units("mm, ms, kg");
    scene.elastic("steel", Elastic { e: 207.0, nu: 0.3, rho: 7.85e-6 });
    scene.solid_part(1, "steel", "");
    let at = |x: [f64; 3]| [30.0 * x[0] - 15.0, 4.0 * x[1] - 2.0, 6.0 * x[2] - 3.0];
    let bar = scene.block(1, [10, 2, 2], at);
    // One end is faster: half of the bar vibrates against the other one.
    let end: Vec<u32> = bar.all().iter().copied().filter(|&n| scene.at(n)[0] > 9.0).collect();
    let end = scene.set(&end);
    scene.add("[[initial_velocity]]\nvelocity = [1.0, 2.0, -0.5]\nspin = [0.0, 0.5, 1.0]");
    scene.add(&format!(
        "[[initial_velocity]]\nnodes = \"{end}\"\nvelocity = [4.0, 2.0, -0.5]\n\
         spin = [0.0, 0.5, 1.0]"
    ));
    if !keys.is_empty() {
        scene.add(&format!("[[rigid]]\nname = \"bar\"\nparts = [1]\n{keys}\n"));
    }
    job::read_text("bar.toml".into(), scene.text("Bar"), &[]).unwrap_or_else(|r| panic!("{r}"))
}

/// Returns the distance of two nodes at the ends of the bar.
fn length(e: &Engine) -> f64 {
    let x = |i: usize| e.nodes.x[i];
    let (a, b) = (x(0), x(e.nodes.local_count - 1));
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

fn size(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// While the bar is rigid its length and internal energy stay; momentum and angular momentum are
/// those of its nodes before and after. The kinetic energy of the vibration is booked as external
/// work, so that the balance stays closed. The stress remains: the bar vibrates again afterwards.
#[test]
fn a_part_is_rigid_for_a_while() {
    let [from, until] = [0.05, 0.2];
    let model = bar(0.3, &format!("from = {from:?}\nuntil = {until:?}"));
    let mut first: Option<([f64; 3], [f64; 3])> = None;
    let (mut initial, mut worst) = (0.0, 0.0f64);
    let (mut kept, mut lengths, mut internal): (Option<[f64; 2]>, f64, f64) = (None, 0.0, 0.0);
    let (mut moved, mut turned) = (0.0f64, 0.0f64);
    let (mut taken, mut vibrates) = (0.0, 0.0f64);
    run_alone(&model, |e| {
        let (p, l) = momentum(&e.nodes);
        let (p0, l0) = *first.get_or_insert((p, l));
        moved = moved.max(size([0, 1, 2].map(|c| p[c] - p0[c])) / size(p0));
        turned = turned.max(size([0, 1, 2].map(|c| l[c] - l0[c])) / size(l0));
        let energies = e.energies(false).values();
        if e.clock.cycle == 1 {
            initial = energies.balance(0.0);
        }
        worst = worst.max(energies.balance(initial).abs() / initial);
        let dt = e.clock.dt;
        if e.clock.time > from + 2.0 * dt && e.clock.time < until - 2.0 * dt {
            let now = [length(e), energies.internal];
            let then = *kept.get_or_insert(now);
            lengths = lengths.max((now[0] - then[0]).abs() / then[0]);
            internal = internal.max((now[1] - then[1]).abs() / then[1]);
            taken = energies.external;
            assert!(then[1] > 0.0, "it is under stress");
        }
        if let Some(then) = kept.filter(|_| e.clock.time > until) {
            vibrates = vibrates.max((length(e) - then[0]).abs() / then[0]);
        }
    });
    // Members have velocities that are differences of positions: eps 15 mm / 3e-4 ms.
    assert!(moved < 1e-11, "round-off: {moved:e}");
    // Velocities and positions of a switch are half a step apart.
    assert!(turned < 1e-6, "{turned:e}");
    assert!(lengths < 1e-12, "{lengths:e}");
    assert!(internal < 1e-9, "elements that rotate have no strain: {internal:e}");
    assert!(taken < -1e-3 * initial, "the vibration is taken out: {taken:e} of {initial:e}");
    assert!(worst < 1e-4, "balance: {worst:e}");
    assert!(vibrates > 1e-5, "the stress acts again: {vibrates:e}");
}

/// No bit depends on the workers, and a run that is interrupted before, between or after the
/// switches continues with the same bits: with and without an end.
#[test]
fn switches_are_the_same_on_any_workers_and_after_a_restart() {
    for keys in ["from = 0.01\nuntil = 0.03", "from = 0.02"] {
        let model = bar(0.04, keys);
        let one = run_side_by_side(&model, 1, 1_000_000, 0);
        assert_ne!(one.digest(), run_side_by_side(&bar(0.04, ""), 1, 1_000_000, 0).digest());
        for workers in [2, 3] {
            assert_eq!(run_side_by_side(&model, workers, 1_000_000, 0).digest(), one.digest());
        }
        let count = one.pairs.len() as u64;
        for part in [5, 10, 18] {
            let plan = Plan { at: count * part / 20, cycles: 1_000_000, workers: [2, 3] };
            assert_eq!(run_interrupted(&model, plan), one.digest(), "{keys} {plan:?}");
        }
    }
}

/// Without an end the elements of the part are not computed any more: the step is that of the job,
/// and the internal energy stays to the last bit.
#[test]
fn a_part_that_stays_rigid_sets_no_step() {
    let mut at: Vec<(f64, f64, f64)> = Vec::new();
    let mut scene = bar(0.2, "from = 0.05");
    scene.settings.dt_max = 1e-3;
    run_alone(&scene, |e| {
        at.push((e.clock.time, e.clock.dt, e.energies(false).values().internal));
    });
    let rigid: Vec<_> = at.iter().filter(|row| row.0 > 0.06).collect();
    assert!(rigid.len() > 10 && rigid.iter().all(|row| row.2 == rigid[0].2));
    let before = at.iter().find(|row| row.0 > 0.04).unwrap().1;
    let longest = rigid.iter().map(|row| row.1).fold(0.0, f64::max);
    assert!(longest > 1.5 * before, "{longest} {before}");
}

/// Keys that cannot be combined with a switch are refused, each with its place.
#[test]
fn switches_that_cannot_act_are_refused() {
    let refused = |keys: &str| {
        let mut scene = Scene::new(1.0).in_units("mm, ms, kg");
        scene.elastic("steel", Elastic { e: 207.0, nu: 0.3, rho: 7.85e-6 });
        scene.solid_part(1, "steel", "");
        scene.block(1, [2, 1, 1], |x| x);
        scene.add(&format!("[[rigid]]\nname = \"bar\"\nparts = [1]\n{keys}\n"));
        let read = job::read_text("bar.toml".into(), scene.text("Bar"), &[]);
        read.err().unwrap_or_else(|| panic!("it passes: {keys}")).to_string()
    };
    for (keys, word) in [
        ("from = 0.5\nuntil = 0.4", "ends before it begins"),
        ("until = 0.4", "begins at 0 and ends"),
        ("from = 0.5\nmass = 1.0", "has a mass or inertia"),
        (
            "from = 0.5\n[[motion]]\nrigid = \"bar\"\nvelocity = [1.0, 0.0, 0.0]",
            "has a prescribed motion",
        ),
    ] {
        let report = refused(keys);
        assert!(report.contains(word), "{word}: {report}");
    }
}
