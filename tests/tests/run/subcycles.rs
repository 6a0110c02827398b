//! Subcycles: bars with a few short elements, compared with a closed form and with all elements
//! in each cycle; energy over many steps; the resonance that layers prevent; the same bits on
//! any number of workers. Units mm, ms, kg.

use crumple::input::job::Model;
use crumple_tests::{case, model_of, read, run_alone, run_side_by_side};
use crumple_verification::scene::{Cut, Scene};
use crumple_worker::engine::Engine;

const E: f64 = 207.0;
const RHO: f64 = 7.85e-6;
const LENGTH: f64 = 100.0;
const SIDE: f64 = 5.0;
const FORCE: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Bodies {
    Shells,
    Solids,
    Wedges,
    Beams,
}

/// Returns a bar along x of square elements, a quarter as long in its middle: 19 long and 4
/// short ones. Its root at x = 0 is held along it, its tip is pulled.
fn bar(kind: Bodies, end_time: f64, sets: &[&str]) -> Model {
    model_of(&bar_text(kind, end_time), sets)
}

fn bar_text(kind: Bodies, end_time: f64) -> String {
    let mut x = vec![0.0];
    for i in 0..23 {
        x.push(x[i] + if (10..14).contains(&i) { 0.25 * SIDE } else { SIDE });
    }
    assert_eq!(x[23], LENGTH);
    let section: &[[f64; 2]] = match kind {
        Bodies::Shells => &[[0.0, 0.0], [SIDE, 0.0]],
        Bodies::Solids | Bodies::Wedges => &[[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]],
        Bodies::Beams => &[[0.0, 0.0]],
    };
    let mut scene = Scene::default();
    if kind == Bodies::Wedges {
        scene.cut(Cut::Wedges);
    }
    let nodes: Vec<Vec<u32>> =
        x.iter().map(|&x| section.iter().map(|&[y, z]| scene.node([x, y, z])).collect()).collect();
    let third = if kind == Bodies::Beams { scene.node([50.0, 50.0, 0.0]) } else { 0 };
    for ends in nodes.windows(2) {
        let (a, b) = (&ends[0], &ends[1]);
        match kind {
            Bodies::Shells => _ = scene.shell(1, &[a[0], b[0], b[1], a[1]]),
            Bodies::Solids | Bodies::Wedges => {
                scene.solid(1, std::array::from_fn(|c| if c < 4 { a[c] } else { b[c - 4] }));
            }
            Bodies::Beams => scene.beam(1, [a[0], b[0], third]),
        }
    }
    scene.set_named("root", &nodes[0]);
    scene.set_named("tip", &nodes[23]);
    scene.set_named("all", &nodes.concat());
    let part = match kind {
        Bodies::Shells => format!("thickness = {SIDE:?}\npoints = 2"),
        Bodies::Solids | Bodies::Wedges => "bulk_viscosity = [0.0, 0.0]".to_string(),
        Bodies::Beams => {
            "[part.beam]\nsection = \"rectangle\"\nheight = 5.0\nwidth = 5.0".to_string()
        }
    };
    let across =
        if kind == Bodies::Beams { "\"y\", \"z\", \"rx\", \"ry\", \"rz\"" } else { "\"y\", \"z\"" };
    format!(
        "end_time = {end_time:?}\n{}[output]\nfield_interval = -1.0\n\
         [[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = {RHO:?}\n\
         youngs_modulus = {E:?}\npoisson = 0.0\n\
         [[part]]\nid = 1\nmaterial = \"steel\"\n{part}\n[[fix]]\nnodes = \"root\"\n\
         dofs = [\"x\"]\n\
         [[fix]]\nnodes = \"all\"\ndofs = [{across}]\n[[load]]\nnodes = \"tip\"\n\
         force = [{:?}, 0.0, 0.0]\n",
        scene.mesh_text(),
        FORCE,
    )
}

fn slow(model: &Model) -> usize {
    model.elements.slow.iter().filter(|&&slow| slow).count()
}

fn tip(e: &Engine) -> f64 {
    let last = e.nodes.local_count - 1;
    e.nodes.x[last][0] - e.nodes.x0[last][0]
}

/// Wedges are slow elements as long as they do not average their volume strain with neighbours:
/// with nu up to 0.3, or if they are asked not to.
#[test]
fn wedges_that_average_nothing_are_slow() {
    for (poisson, pressure, wanted) in
        [("0.3", "nodal", true), ("0.45", "nodal", false), ("0.45", "element", true)]
    {
        let sets = [
            "time.subcycles=2",
            &format!("material.steel.poisson={poisson}"),
            &format!("part.1.pressure={pressure}"),
        ];
        let model = bar(Bodies::Wedges, 0.01, &sets);
        assert_eq!(slow(&model) > 0, wanted, "nu = {poisson}, {pressure}");
    }
}

/// A suddenly pulled tip moves with F c/(E A) until the wave returns: 1.5 F L/(E A) after 1.5
/// L/c. Elements 5 and 1.25 long oscillate behind the front. They deviate from the closed form
/// by 0.2 % if all are computed in each cycle, by 0.4 % if the long ones are computed in every
/// fourth. Beams deviate in the same way, since their wave has the same speed.
#[test]
fn a_pulled_bar_goes_as_the_wave_says() {
    let exact = 1.5 * FORCE * LENGTH / (E * SIDE * SIDE);
    let end = 1.5 * LENGTH / (E / RHO).sqrt();
    for kind in [Bodies::Shells, Bodies::Solids, Bodies::Beams] {
        let model = bar(kind, end, &["time.subcycles=4"]);
        assert_eq!(
            (slow(&model), model.settings.subcycles),
            (17, 4),
            "{kind:?}: all but 4 short ones and one on each side"
        );
        let [every, some] = [bar(kind, end, &[]), model].map(|model| run_alone(&model, |_| {}));
        assert_eq!(some.clock.cycle % 4, 0, "{kind:?}: complete outer steps");
        for (what, e) in [("every", &every), ("some", &some)] {
            println!(
                "{kind:?} {what}: {} of {exact}, {} cycles",
                tip(e) / exact - 1.0,
                e.clock.cycle
            );
            assert!((tip(e) / exact - 1.0).abs() < 6e-3, "{kind:?} {what}: {} of {exact}", tip(e));
        }
        assert!(
            every.clock.cycle.abs_diff(some.clock.cycle) <= 4,
            "{kind:?}: the same number of \
            steps"
        );
    }
}

/// A rigid body transmits fast motion without delay: the layer lies behind it.
#[test]
fn layers_lie_behind_rigid_bodies() {
    let free = bar_text(Bodies::Shells, 0.1).replace("nodes = \"all\"", "nodes = \"root\"");
    let text = free.replace("[10, 1,", "[10, 2,").replace("[15, 1,", "[15, 2,");
    let rigid = "[[part]]\nid = 2\nmaterial = \"steel\"\nthickness = 5.0\n[[rigid]]\n\
                 name = \"both\"\nparts = [2]\n";
    let model = model_of(&(text + rigid), &["time.subcycles=4"]);
    assert_eq!(slow(&model), 15, "of 17, all but those that share a body with the short ones");
}

/// Returns the largest error of the energy balance at the starts of outer steps, over the
/// largest work.
fn imbalance(model: &Model) -> f64 {
    let (mut most, mut work) = (0.0f64, 0.0f64);
    run_alone(model, |e| {
        if (e.clock.cycle - 1).is_multiple_of(model.settings.subcycles) {
            let now = e.energies(false).values();
            most = most.max((now.kinetic + now.internal + now.hourglass - now.external).abs());
            work = work.max(now.external);
        }
    });
    most / work
}

/// In 5000 outer steps, 250 periods of the bar, the error of the energy stays within half a
/// percent of the largest work. Frequencies near the stable limit, which a sudden force excites,
/// exceed the second-order accuracy of the balance, but the error does not grow. Layers separate
/// the motion of the short elements from the slow forces. Without them the error grows without
/// bound at this step, because 4 steps are half a period of one of the modes of the short
/// elements.
#[test]
fn energy_stays_with_a_layer_and_resonates_without() {
    let end = 20_000.0 * 0.78 * 0.25 * SIDE / (E / RHO).sqrt();
    let sets = ["time.subcycles=4", "time.safety=0.78"];
    let with = imbalance(&bar(Bodies::Shells, end, &sets));
    let early = imbalance(&bar(Bodies::Shells, 0.1 * end, &sets));
    let without = imbalance(&bar(
        Bodies::Shells,
        0.1 * end,
        &[&sets[..], &["time.subcycle_layers=0"]].concat(),
    ));
    println!("with a layer {with}, in the first tenth {early}, without {without}");
    assert!(with < 5e-3 && with < 2.0 * early, "with a layer: {with}, in the first tenth {early}");
    assert!(without > 1e3, "without: {without}");
}

/// A plate with short shells in it, one half of it rigid, the other under pressure: its slow and
/// its fast shells are several batches, which threads share.
#[test]
fn threads_change_no_bit() {
    let mut x = vec![0.0];
    for i in 0..40 {
        x.push(x[i] + if (28..31).contains(&i) { 1.25 } else { 5.0 });
    }
    let mut scene = Scene::default();
    scene.lattice(1, [10, 40], |i, j| [x[i], 5.0 * j as f64, 0.0]);
    let right = scene.lattice(2, [30, 40], |i, j| [x[10 + i], 5.0 * j as f64, 0.0]);
    scene.set_named("right", right.all());
    let text = format!(
        "end_time = 1.0\n{}\
         [output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\nlaw = \"j2\"\n\
         density = {RHO:?}\nyoungs_modulus = {E:?}\n\
         poisson = 0.3\nhardening = [[0.0, 0.3], [1.0, 0.9]]\n[[part]]\nid = 1\n\
         material = \"steel\"\nthickness = 1.0\n[[rigid]]\nname = \"left\"\nparts = [1]\n\
         [[part]]\nid = 2\nmaterial = \"steel\"\nthickness = 1.0\n[[pressure]]\nparts = [2]\n\
         pressure = -0.002\n\
         [[initial_velocity]]\nnodes = \"right\"\nvelocity = [4.0, 1.0, -30.0]\n\
         spin = [0.1, 0.2, 0.1]\ncentre = [40.0, 7.0, 2.0]\n",
        scene.mesh_text()
    );
    let on = |threads: usize, workers: usize| {
        let sets = ["time.subcycles=3", &format!("parallel.threads={threads}")];
        let model = model_of(&text, &sets);
        assert!(slow(&model) > 600, "{}", slow(&model));
        run_side_by_side(&model, workers, 60, 7).digest()
    };
    let alone = on(1, 1);
    for (threads, workers) in [(3, 1), (2, 2)] {
        assert_eq!(on(threads, workers), alone, "{workers} workers of {threads} threads");
    }
}

/// Two strips of shells with short shells in them collide, one of them under pressure: pairs and
/// state on three workers are those of one worker. Boxes are renewed every 7 cycles, also in the
/// middle of outer steps of 3.
#[test]
fn workers_and_renewals_change_no_bit() {
    let mut x = vec![0.0];
    for i in 0..20 {
        x.push(x[i] + if (8..11).contains(&i) { 1.25 } else { 5.0 });
    }
    let mut scene = Scene::default();
    for (strip, z) in [0.0, 2.0].into_iter().enumerate() {
        let at = |i: usize, j: usize| [x[i] + 3.0 * strip as f64, 5.0 * j as f64, z];
        let grid = scene.lattice(1 + strip as u32, [20, 3], at);
        if strip == 1 {
            scene.set_named("upper", grid.all());
        }
    }
    let text = format!(
        "end_time = 1.0\n{}\
         [output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\nlaw = \"j2\"\n\
         density = {RHO:?}\nyoungs_modulus = {E:?}\n\
         poisson = 0.3\nhardening = [[0.0, 0.3], [1.0, 0.9]]\n[[part]]\nid = 1\n\
         material = \"steel\"\nthickness = 1.0\n\
         [[part]]\nid = 2\nmaterial = \"steel\"\nthickness = 1.0\n[[pressure]]\nparts = [2]\n\
         pressure = -0.002\n\
         [[gravity]]\nacceleration = [0.0, 0.0, -1.0]\n\
         [[initial_velocity]]\nnodes = \"upper\"\nvelocity = [4.0, 1.0, -30.0]\n\
         spin = [0.1, 0.2, 0.1]\ncentre = [40.0, 7.0, 2.0]\n[contact]\n",
        scene.mesh_text()
    );
    let [model, kept] = [true, false]
        .map(|all| model_of(&text, &["time.subcycles=3", &format!("time.subcycle_contact={all}")]));
    assert_eq!(slow(&kept), 0, "all parts are in contact");
    assert!(
        kept.warnings.iter().any(|w| w.message.contains("is not in contact")),
        "{:?}",
        kept.warnings
    );
    assert!(slow(&model) > 60, "{}", slow(&model));
    let cycles = 1601;
    let serial = run_side_by_side(&model, 1, cycles, 0);
    let met: usize = serial.pairs.iter().map(Vec::len).sum();
    assert!(met > 1000, "there is contact: {met} pairs");
    let forced = run_side_by_side(&model, 3, cycles, 7);
    assert!(forced.renewals >= cycles / 7);
    for (cycle, (a, b)) in serial.pairs.iter().zip(&forced.pairs).enumerate() {
        assert_eq!(a, b, "pairs in cycle {cycle}");
    }
    assert_eq!(serial.digest(), forced.digest());
    let without = run_side_by_side(&model_of(&text, &[]), 1, cycles, 0);
    let place = |t: &crumple_tests::Trace| {
        t.nodes.iter().map(|n| n.x[2]).sum::<f64>() / t.nodes.len() as f64
    };
    assert!(
        (place(&serial) - place(&without)).abs() < 0.02,
        "{} and {}",
        place(&serial),
        place(&without)
    );
}

/// A mesh without small elements is computed as without the key, and a message reports this.
#[test]
fn a_job_without_slow_elements_is_reported() {
    let [plain, asked] = [&[][..], &["time.subcycles=3"]].map(|sets| read(&case("plate"), sets));
    assert!(
        asked.warnings.iter().any(|w| w.message.contains("leaves no slow element")),
        "{:?}",
        asked.warnings
    );
    assert_eq!((asked.settings.subcycles, plain.settings.subcycles), (1, 1));
    let [a, b] = [plain, asked].map(|model| run_side_by_side(&model, 1, 50, 0).digest());
    assert_eq!(a, b);
}

/// The bar of `cases/graded` bends freely under gravity, with a rigid block at its tip, a spring
/// to the ground and a tied strip: the same bits on three workers with boxes renewed every 35
/// cycles, and energies as without subcycles.
#[test]
fn rigid_bodies_ties_and_springs_go_with_it() {
    let text = std::fs::read_to_string(case("graded").join("job.toml")).unwrap();
    let strip: String = (0..9)
        .map(|i| {
            format!(
                "[{}, {}.0, 0.5, 1.5], [{}, {}.0, 4.5, 1.5],\n",
                301 + 2 * i,
                30 + 5 * i,
                302 + 2 * i,
                30 + 5 * i
            )
        })
        .collect();
    let quads: String = (0..8)
        .map(|i| {
            format!(
                "[{}, 3, {}, {}, {}, {}],\n",
                301 + i,
                301 + 2 * i,
                303 + 2 * i,
                304 + 2 * i,
                302 + 2 * i
            )
        })
        .collect();
    let (head, tail) = text.split_once("[[fix]]").unwrap();
    let (_, loads) = tail.split_once("[[curve]]").unwrap();
    let text = format!(
        "{head}[[fix]]\nnodes = \"ground\"\ndofs = [\"x\", \"y\", \"z\"]\n[[fix]]\n\
         nodes = \"root\"\n\
         dofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n[[part]]\nid = 2\n\
         material = \"steel\"\nthickness = 5.0\n\
         [[part]]\nid = 3\nmaterial = \"steel\"\nthickness = 1.0\n[[part]]\nid = 4\n[part.spring]\n\
         stiffness = 0.5\n\
         [[rigid]]\nname = \"block\"\nparts = [2]\n[[tie]]\nnodes = \"glued\"\nparts = [1]\n\
         tolerance = 2.0\noffset = true\n\
         [[gravity]]\nacceleration = [0.0, 0.0, -2.0]\n[[curve]]{loads}"
    );
    let nodes = format!(
        "nodes = [\n[101, 105.0, 0.0, 0.0], [102, 105.0, 5.0, 0.0], [201, 7.0, 0.0, -30.0],\n\
         {strip}"
    );
    let text = text.replacen("nodes = [\n", &nodes, 1);
    let text = text.replacen(
        "shells = [\n",
        &format!("shells = [\n[101, 2, 55, 101, 102, 56],\n{quads}"),
        1,
    );
    let sets = "springs = [[401, 4, 5, 201]]\n[mesh.node_sets]\nground = [201]\n\
                glued = [301, 302, 303, 304, 311, 312, 313, 314, 315, 316, 317, 318]\n";
    let text = text.replacen("[mesh.node_sets]\n", sets, 1);
    let job = |m: &str| model_of(&text, &["end_time=0.3", "time.safety=0.9", m]);
    let model = job("time.subcycles=3");
    // Three fewer than by their own steps: those at tied nodes keep a share for the arms.
    assert_eq!(slow(&model), 21, "of 27 quads in the bar, 8 tied, one rigid, and a spring");
    let [serial, forced] =
        [(1, 0), (3, 35)].map(|(workers, every)| run_side_by_side(&model, workers, 2700, every));
    assert!(forced.renewals >= 2700 / 35);
    assert_eq!(serial.digest(), forced.digest());
    // With a smaller step than above: the difference is 2.8e-3 at 0.9.
    let short = |m: &str| model_of(&text, &["end_time=0.3", "time.safety=0.7", m]);
    let internal = |m: &str| run_alone(&short(m), |_| {}).energies(true).internal.value();
    let (every, some) = (internal("time.subcycles=1"), internal("time.subcycles=3"));
    assert!((some / every - 1.0).abs() < 2e-3, "second order in the outer step: {some} of {every}");
}
