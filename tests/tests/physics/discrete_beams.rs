//! Discrete beams compared with closed forms: frequencies, momentum, energy, the stable step,
//! springs that yield or unload by other curves, failure, the same bits on any number of workers.
//! Units of the closed forms.

use super::springs::{Balance, drift, model};
use crumple::input::job::Model;
use crumple_tests::{run_alone, run_side_by_side};
use crumple_verification::scene::{Elastic, Scene};

/// Returns a discrete beam between two nodes, with the sets `n1` and `n2`; `numbers` are the
/// contents of `[part.discrete_beam]`, `rest` is the rest of the job.
fn job(nodes: [[f64; 3]; 2], numbers: &str, end_time: f64, [time, rest]: [&str; 2]) -> Model {
    let mut scene = Scene::new(end_time);
    let ends = nodes.map(|x| scene.node(x));
    scene.set_named("n1", &ends[..1]);
    scene.set_named("n2", &ends[1..]);
    scene.spring(1, ends);
    scene.add(&format!("[[part]]\nid = 1\n[part.discrete_beam]\n{numbers}"));
    scene.time(time);
    scene.add(rest);
    model(&scene)
}

/// Returns a spring on an axis as text.
fn spring(axis: &str, numbers: &str) -> String {
    format!("[[part.discrete_beam.spring]]\naxis = \"{axis}\"\n{numbers}\n")
}

const HELD: &str =
    "[[fix]]\nnodes = \"n1\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n";

/// The second of two nodes at one place swings along y on the spring of axis s with w^2 = k/(m/2),
/// and about z on that of axis rt with w^2 = k/(J/2). Central differences are ahead by 20 (w
/// dt)^2/24 = 3e-4 after the angle w t = 20.
#[test]
fn nodes_swing_along_and_about_an_axis() {
    let (mass, inertia, v) = (4.0, 1.0, 0.05);
    let both = spring("s", "stiffness = 3.0") + &spring("rt", "stiffness = 5.0");
    let tables = spring("s", "force_elongation = [[-1.0, -3.0], [1.0, 3.0]]")
        + &spring("rt", "force_elongation = [[-1.0, -5.0], [1.0, 5.0]]");
    let turned = "axes = [[0.0, -2.0, 0.0], [3.0, 1.0, 0.0]]\n";
    for (axes, springs) in [
        ("", &both),
        ("", &tables),
        (turned, &(spring("r", "stiffness = 3.0") + &spring("rt", "stiffness = 5.0"))),
    ] {
        let numbers = format!("mass = {mass:?}\ninertia = {inertia:?}\n{axes}{springs}");
        let w = [f64::sqrt(3.0 / (0.5 * mass)), f64::sqrt(5.0 / (0.5 * inertia))];
        let rest = format!(
            "{HELD}[[initial_velocity]]\nnodes = \"n2\"\nvelocity = [0.0, {v:?}, 0.0]\n\
             spin = [0.0, 0.0, {v:?}]\ncentre = [1.0, 0.0, 0.0]\n"
        );
        let time = format!("dt_max = {:?}", 0.02 / w[1]);
        let place = [1.0, 0.0, 0.0];
        let model = job([place; 2], &numbers, 20.0 / w[1], [&time, &rest]);
        let (mut worst, mut balance) = ([0.0f64; 2], Balance::default());
        run_alone(&model, |e| {
            let t = e.clock.time;
            worst[0] =
                worst[0].max((e.nodes.x[1][1] - v / w[0] * (w[0] * t).sin()).abs() * w[0] / v);
            let middle = t - 0.5 * e.clock.last_dt;
            worst[1] = worst[1].max((e.nodes.w[1][2] / v - (w[1] * middle).cos()).abs());
            balance.record(e);
        });
        // The axes turn with half of the rotation: up to 0.5 v/w of the force leaves the y axis,
        // and its couple is of second order.
        assert!(worst[0] < 2e-3 && worst[1] < 2e-3, "{numbers}: {worst:?}");
        assert!(balance.worst < 1e-12, "{numbers}: round-off: {}", balance.worst);
    }
}

/// Two free nodes at a distance on springs and dampers of all axes fly and turn: momentum, angular
/// momentum and energy are conserved.
#[test]
fn free_nodes_keep_momentum() {
    let all = |damping: f64| {
        let axes = ["r", "s", "t", "rr", "rs", "rt"].into_iter().zip(1..);
        axes.map(|(axis, k)| {
            let (k, c) = (f64::from(k), damping * f64::from(k));
            spring(axis, &format!("stiffness = {k:?}\ndamping = {c:?}"))
        })
        .collect::<String>()
    };
    let rest = "[[mass]]\nnodes = \"n1\"\nmass = 2.0\n\
                [[initial_velocity]]\nnodes = \"n1\"\nvelocity = [0.1, 0.2, -0.05]\n\
                spin = [0.1, -0.2, 0.3]\ncentre = [0.0, 0.0, 0.0]\n\
                [[initial_velocity]]\nnodes = \"n2\"\nvelocity = [0.03, -0.2, 0.06]\n\
                spin = [0.2, 0.1, 0.1]\ncentre = [1.0, 0.5, 0.2]\n";
    for (turns_with, damping, along_line) in [
        ("both", 0.0, false),
        ("both", 0.02, false),
        ("first", 0.02, false),
        ("second", 0.0, false),
        ("both", 0.0, true),
        ("second", 0.02, true),
    ] {
        let numbers = format!(
            "mass = 2.0\ninertia = 3.0\naxes = [[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]\n\
             turns_with = \"{turns_with}\"\nalong_line = {along_line}\n{}",
            all(damping)
        );
        let nodes = [[0.0; 3], [1.0, 0.5, 0.2]];
        let model = job(nodes, &numbers, 30.0, ["safety = 0.1", rest]);
        let (worst, balance) = drift(&model);
        let case = format!("{turns_with}, {damping}, {along_line}");
        assert!(worst[0] < 1e-12 && worst[1] < 1e-11, "{case}: round-off: {worst:?}");
        assert!(balance < 1e-11, "{case}: {balance}");
    }
}

/// A mass m = 2 with the velocity 3 on the r axis of a beam, from x = 5. Returns its largest
/// displacement, its velocity at the end, the internal energy there, and the largest error of the
/// energy balance.
fn swing(springs: &str, failure: &str, end_time: f64) -> [f64; 4] {
    let numbers = format!("mass = 4.0\ninertia = 1.0\n{failure}{springs}");
    let rest = format!("{HELD}[[initial_velocity]]\nnodes = \"n2\"\nvelocity = [3.0, 0.0, 0.0]\n");
    let model =
        job([[0.0; 3], [5.0, 0.0, 0.0]], &numbers, end_time, ["dt_max = 2e-4", rest.as_str()]);
    let (mut most, mut balance) = (0.0f64, Balance::default());
    let end = run_alone(&model, |e| {
        most = most.max(e.nodes.x[1][0] - 5.0);
        balance.record(e);
    });
    let internal = end.ledger.energies(&end.nodes, &end.blocks).values().internal;
    [most, end.nodes.v[1][0], internal, balance.worst]
}

/// A mass with the energy 9 on four springs that keep a part of it.
///
/// Yielding at 3 + 2 p, k = 10: 9 = F^2/20 + 3 p + p^2, with the largest displacement p + F/k. It
/// swings back by less than twice the force: the energy that it lost remains lost.
///
/// Between curves of the slopes 4 and 2 with lines of 8: it turns at x = `sqrt(18/4)`. It comes
/// back with the area below the steep line, which meets 2 x at 2/3 of it, and below the curve.
///
/// With a permanent set of a quarter of x and the slope 4: the parabola gives F (3/4 x)/3 = x^2
/// back, half of 2 x^2 = 9.
#[test]
fn springs_keep_the_area_between_their_curves() {
    let near = |found: f64, exact: f64, what: &str| {
        assert!((found / exact - 1.0).abs() < 1e-3, "{what}: {found} {exact}");
    };
    // (3 + 2 p)^2/20 + 3 p + p^2 = 9.
    let law = "[part.discrete_beam.spring.yielding]\nstiffness = 10.0\n\
               yield_force = [[0.0, 3.0], [1.0, 5.0]]";
    let [a, b, c] = [0.2 + 1.0, 0.6 + 3.0, 0.45 - 9.0];
    let p = ((b * b - 4.0f64 * a * c).sqrt() - b) / (2.0 * a);
    let force = 3.0 + 2.0 * p;
    let [most, v, internal, balance] = swing(&spring("r", law), "", 2.0);
    near(most, p + force / 10.0, "yielding: largest displacement");
    near(internal + v * v, 9.0, "yielding: energy");
    assert!(balance < 1e-10, "round-off: {balance}");
    assert!(v * v < force * force / 20.0 * 1.001, "{v}");

    let law = "[part.discrete_beam.spring.between_curves]\n\
               loading = [[-1.0, -1e-6], [0.0, 0.0], [1.0, 4.0]]\n\
               unloading = [[-1.0, 0.0], [0.0, 0.0], [1.0, 2.0]]\nstiffness = 8.0";
    let [most, v, internal, balance] = swing(&spring("r", law), "", 4.0);
    let turn = f64::sqrt(4.5);
    // The steep line ends at 4 x - 8 y = 2 (x - y): y = x/3.
    let end = turn * 2.0 / 3.0;
    let back = 0.5 * (4.0 * turn + 2.0 * end) * (turn - end) + end * end;
    near(most, turn, "between curves: largest displacement");
    near(v * v, back, "between curves: energy that comes back");
    near(internal, 9.0 - back, "between curves: energy that is lost");
    assert!(balance < 1e-10, "round-off: {balance}");

    let law = "[part.discrete_beam.spring.permanent_set]\nfraction = 0.25\n\
               loading = [[-1.0, -1e-6], [0.0, 0.0], [1.0, 4.0]]";
    let [most, v, internal, balance] = swing(&spring("r", law), "", 4.0);
    near(most, turn, "permanent set: largest displacement");
    near(v * v, 4.5, "permanent set: energy that comes back");
    near(internal, 4.5, "permanent set: energy that is lost");
    assert!(balance < 1e-10, "round-off: {balance}");

    let law = "[part.discrete_beam.spring.hysteresis]\n\
               loading = [[-1.0, -1e-6], [0.0, 0.0], [1.0, 4.0]]\n\
               unloading = [[0.0, 0.0], [1.0, 16.0]]";
    let [_, v, internal, _] = swing(&spring("r", law), "", 4.0);
    near(v * v, 9.0 / 4.0, "hysteresis: energy that comes back");
    near(internal, 9.0 * 0.75, "hysteresis: energy that is lost");
}

/// A mass tears a spring of k = 4 at the displacement 1.5: it goes on with 9 - 4.5, the work that
/// the spring took. The force of the last step is missing: 6 of it by 2e-4 v in 9, half of it, is
/// 1e-4.
#[test]
fn a_beam_fails_within_a_step_of_its_limit() {
    for limit in ["failure_tension = 1.5", "failure_force = 6.0"] {
        let springs = spring("r", &format!("stiffness = 4.0\n{limit}"));
        for failure in ["", "failure = \"any\"\n", "failure = \"by_sign\"\n"] {
            let [_, v, internal, _] = swing(&springs, failure, 2.0);
            assert!((v * v / 4.5 - 1.0).abs() < 5e-4, "{limit} {failure}: {v}");
            assert!((internal / 4.5 - 1.0).abs() < 5e-4, "{limit} {failure}: {internal}");
        }
    }
    let held = spring("r", "stiffness = 4.0\nfailure_tension = 2.2\nfailure_compression = 2.0");
    let [most, ..] = swing(&held, "", 1.5);
    assert!((most - f64::sqrt(4.5)).abs() < 1e-3, "it holds until it has turned: {most}");
}

/// The step is that of the softness 4/m, or 4/J: the smaller one. At 0.99 of it nothing grows.
#[test]
fn the_step_is_that_of_the_stiffest_axis() {
    for (springs, largest) in [
        (spring("r", "stiffness = 40.0") + &spring("s", "stiffness = 1.0"), 40.0 * 4.0 / 2.0),
        (spring("r", "stiffness = 1.0") + &spring("rs", "stiffness = 40.0"), 40.0 * 4.0 / 3.0),
    ] {
        let numbers = format!("mass = 2.0\ninertia = 3.0\n{springs}");
        let rest = "[[initial_velocity]]\nnodes = \"n2\"\nvelocity = [0.01, 0.02, 0.0]\n\
                    spin = [0.0, 0.01, 0.0]\ncentre = [0.0, 0.0, 0.0]\n";
        let model =
            job([[0.0; 3]; 2], &numbers, 100.0, ["safety = 0.99\ndt_min_ratio = 0.0", rest]);
        let mut most = 0.0f64;
        let end = run_alone(&model, |e| {
            let all = e.nodes.v[1].iter().chain(&e.nodes.w[1]);
            most = all.fold(most, |most, v| most.max(v.abs()));
        });
        // Whole steps reach the end, so that they are up to one part in their number shorter.
        let ratio = end.clock.first_dt / (0.99 * 2.0 / f64::sqrt(largest));
        assert!((0.99..=1.0 + 1e-12).contains(&ratio), "{ratio}");
        assert!(most < 0.2, "{most}");
    }
}

/// A sheet of shells on discrete beams to a rigid sheet and to the ground: the same bits on 1, 2
/// and 3 workers, with forced renewals of the boxes.
#[test]
fn bits_do_not_depend_on_workers() {
    let mut scene = Scene::new(3.0).in_units("mm, ms, kg");
    scene.elastic("steel", Elastic { e: 207.0, nu: 0.3, rho: 7.85e-6 });
    scene.part(1, "steel", 1.0, "");
    scene.part(2, "steel", 2.0, "");
    let sheet = scene.grid(1, [4, 4], |u, v| [40.0 * u, 40.0 * v, 0.0]);
    let upper = scene.grid(2, [4, 4], |u, v| [40.0 * u, 40.0 * v, 9.0]);
    let ground: Vec<u32> = (0..25)
        .map(|n| scene.node([10.0 * f64::from(n / 5), 10.0 * f64::from(n % 5), 0.0]))
        .collect();
    for (n, (&node, &above)) in sheet.all().iter().zip(upper.all()).enumerate() {
        scene.spring(3, [node, ground[n]]);
        scene.spring(if n % 2 == 0 { 4 } else { 5 }, [node, above]);
    }
    scene.set_named("ground", &ground);
    scene.set_named("sheet", sheet.all());
    let of = |numbers: &[(&str, &str)]| -> String {
        numbers.iter().map(|(axis, numbers)| spring(axis, numbers)).collect()
    };
    let first = of(&[
        ("r", "stiffness = 0.02\ndamping = 1e-5"),
        ("t", "force_elongation = [[-1.0, -0.03], [0.0, 0.0], [1.0, 0.01]]"),
        ("rs", "stiffness = 0.1"),
    ]);
    let second =
        of(&[("s", "stiffness = 0.01"), ("t", "damping = 1e-4"), ("rr", "damping = 1e-3")]);
    // Beams that yield, follow their lines, and fail at the middle of the sheet.
    let third = of(&[
        (
            "r",
            "failure_tension = 3.0\nfailure_compression = 0.5\n\
             yielding = { stiffness = 0.02, yield_force = [[0.0, 0.01], [1.0, 0.02]] }",
        ),
        ("s", "permanent_set = { loading = [[-1.0, -0.02], [1.0, 0.02]], fraction = 0.2 }"),
        ("rs", "stiffness = 0.1\nfailure_force = 0.02\ninitial_displacement = 0.01"),
    ]);
    scene.add(&format!(
        "[[part]]\nid = 5\n[part.discrete_beam]\nmass = 1e-4\ninertia = 1e-3\n\
         turns_with = \"first\"\nalong_line = true\n{third}\
         [[part]]\nid = 3\n[part.discrete_beam]\nmass = 1e-4\ninertia = 1e-3\n{first}\
         [[part]]\nid = 4\n[part.discrete_beam]\nmass = 2e-4\ninertia = 2e-3\n\
         turns_with = \"second\"\naxes = [[1.0, 0.2, 0.0], [0.0, 1.0, 0.3]]\n{second}\
         [[rigid]]\nname = \"upper\"\nparts = [2]\n\
         [[fix]]\nnodes = \"ground\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
         [[initial_velocity]]\nnodes = \"sheet\"\nvelocity = [0.5, 0.2, -4.0]\n\
         spin = [0.01, 0.02, 0.03]\ncentre = [20.0, 20.0, 0.0]\n"
    ));
    let model = model(&scene);
    let serial = run_side_by_side(&model, 1, 600, 0);
    assert!(serial.trouble.is_none(), "{:?}", serial.trouble);
    let end = run_alone(&model, |_| {});
    let broken = end.blocks.elements.iter().filter(|e| e.record.failed).count();
    assert!((1..=12).contains(&broken), "{broken} of 12 beams that can fail");
    for (workers, force) in [(2, 0), (3, 0), (2, 7), (3, 11)] {
        let parallel = run_side_by_side(&model, workers, 600, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}
