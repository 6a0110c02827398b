//! Airbags compared with closed forms: gas in a rigid tank, a piston, a rigid lid, a sphere of
//! membrane; the balances of momentum and energy; surfaces and jobs with errors. Units mm, ms, kg,
//! so kN, GPa and J.

use crumple::input::job::{Model, read_text};
use crumple::run::embedded;
use crumple_proto::histories::BagState;
use crumple_tests::{model_of, read, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::energy::momentum;
use crumple_worker::engine::{Engine, StepFailure};
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;

const CV: f64 = 743.0;
const CP: f64 = 1040.0;
const AMBIENT: f64 = 1e-4;

const STEEL: &str = "[output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\n\
    law = \"elastic\"\ndensity = 7.85e-6\nyoungs_modulus = 207.0\npoisson = 0.3\n";

/// All sides of a box: axis and end.
const SIDES: [(usize, f64); 6] = [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0), (2, 1.0)];

/// Builds surfaces of shells that share their nodes.
#[derive(Default)]
struct Surfaces {
    scene: Scene,
    known: HashMap<[i64; 3], u32>,
}

impl Surfaces {
    /// Adds sides of a box with `n` x `n` shells each. `place` maps it from [-1, 1]^3. Half of the
    /// normals point inwards, unless they are `aligned`.
    fn add(
        &mut self,
        part: u32,
        n: usize,
        sides: &[(usize, f64)],
        aligned: bool,
        place: impl Fn([f64; 3]) -> [f64; 3],
    ) {
        let Self { scene, known } = self;
        for &(axis, end) in sides {
            let at = |a: f64, b: f64| {
                let mut x = [end; 3];
                let [u, w] = if aligned && end < 0.0 { [2, 1] } else { [1, 2] };
                (x[(axis + u) % 3], x[(axis + w) % 3]) = (2.0 * a - 1.0, 2.0 * b - 1.0);
                place(x)
            };
            scene.grid_of(part, [n, n], at, |scene, x| {
                let key = x.map(|c| (c * 1e3).round() as i64);
                *known.entry(key).or_insert_with(|| scene.node(x))
            });
        }
    }

    /// Names sets of nodes, and returns the text of a job with parts of steel.
    fn text(&mut self, end_time: f64, parts: u32, rest: &str) -> String {
        let scene = &mut self.scene;
        let of = |top: bool| -> Vec<u32> {
            (1..=scene.count()).filter(|&n| (scene.at(n)[2] == 100.0) == top).collect()
        };
        let sets = [("top", of(true)), ("rest", of(false)), ("all", (1..=scene.count()).collect())];
        for (name, nodes) in sets.iter().filter(|(_, nodes)| !nodes.is_empty()) {
            scene.set_named(name, nodes);
        }
        let part =
            |id: u32| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\nthickness = 1.0\n");
        let parts: String = (1..=parts).map(part).collect();
        format!("end_time = {end_time:?}\n{}{STEEL}{parts}{rest}", self.scene.mesh_text())
    }
}

/// Returns the text of a cube of side 100 with 4 x 4 shells on each side, part 1, half of them with
/// normals inwards. The set `all` holds all nodes, `top` those at z = 100, `rest` the others.
fn cube_text(end_time: f64, rest: &str) -> String {
    let mut surfaces = Surfaces::default();
    surfaces.add(1, 4, &SIDES, false, |x| x.map(|c| 50.0 * (c + 1.0)));
    surfaces.text(end_time, 1, rest)
}

/// Returns the model of [`cube_text`].
fn cube(end_time: f64, rest: &str) -> Model {
    model_of(&cube_text(end_time, rest), &[])
}

/// Maps a cube to a sphere, with equal angles on each of its sides.
fn on_sphere(x: [f64; 3], radius: f64) -> [f64; 3] {
    let x = x.map(|c| (c * 0.5 * FRAC_PI_2).tan());
    let size = x.iter().map(|c| c * c).sum::<f64>().sqrt();
    x.map(|c| c * radius / size)
}

/// Returns the text of an airbag of part 1 with a gas at 300 and the ambient pressure.
fn gas(rest: &str) -> String {
    format!(
        "[[airbag]]\nname = \"bag\"\nparts = [1]\ncv = {CV:?}\ncp = {CP:?}\ntemperature = 300.0\n\
         ambient_pressure = {AMBIENT:?}\n{rest}"
    )
}

const HELD: &str =
    "[[fix]]\nnodes = \"all\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n";

fn bag(engine: &Engine) -> BagState {
    engine.airbags.records()[0]
}

/// A rigid tank that is filled adiabatically: U = U0 + m cp T_in. Filled from nothing, the gas has
/// the temperature g T_in. Half of the shells of a cube in a lattice have their normals inwards.
#[test]
fn a_rigid_tank_fills_adiabatically() {
    let inflow = "[[airbag.inflow]]\nrate = 3e-3\ncurve = \"pulse\"\ntemperature = 500.0\n\
                  [[curve]]\nname = \"pulse\"\npoints = [[0.0, 0.0], [0.1, 1.0], [0.3, 0.0]]\n";
    for pressure in [0.0, AMBIENT] {
        let own = format!("pressure = {pressure:?}\n{inflow}{HELD}");
        let end = bag(&run_alone(&cube(0.4, &gas(&own)), |_| {}));
        let (volume, mass) = (1e6, 3e-3 * 0.15);
        assert!((end.volume / volume - 1.0).abs() < 1e-12, "{}", end.volume);
        assert!((end.mass_in / mass - 1.0).abs() < 1e-12, "the integral of the curve");
        let before = pressure * volume / ((CP - CV) * 300.0);
        let energy = before * CV * 300.0 + mass * CP * 500.0;
        let temperature = energy / ((before + mass) * CV);
        assert!((end.temperature / temperature - 1.0).abs() < 1e-10, "{}", end.temperature);
        let p = (CP / CV - 1.0) * energy / volume;
        assert!((end.pressure / p - 1.0).abs() < 1e-10, "{} {p}", end.pressure);
    }
}

/// A rigid tank empties through a choked orifice along the isentrope of its density,
/// p = p0 (1 + (g-1)/2 t/tau)^(-2g/(g-1)) with tau = m0 / (flow at the start).
#[test]
fn a_rigid_tank_empties_through_a_choked_vent() {
    let (g, r, area, pressure) = (CP / CV, CP - CV, 5e4, 100.0 * AMBIENT);
    let vent = format!(
        "pressure = {pressure:?}\n[[airbag.vent]]\narea = {area:?}\ncoefficient = 0.6\n{HELD}"
    );
    let flux =
        pressure * (g / (r * 300.0)).sqrt() * (2.0 / (g + 1.0)).powf(0.5 * (g + 1.0) / (g - 1.0));
    let tau = pressure * 1e6 / (r * 300.0) / (0.6 * area * flux);
    let mut worst = 0.0f64;
    let end = run_alone(&cube(0.1, &gas(&vent)), |e| {
        // The gas belongs to the beginning of the step.
        let time = e.clock.time - e.clock.last_dt;
        let exact = pressure * (1.0 + 0.5 * (g - 1.0) * time / tau).powf(-2.0 * g / (g - 1.0));
        worst = worst.max((bag(e).pressure / exact - 1.0).abs());
    });
    let now = bag(&end);
    assert!(now.pressure < 0.6 * pressure && now.pressure > 2.0 * AMBIENT, "{now:?}");
    assert!(worst < 1e-4, "second order, at most 2% of the mass per part of a step: {worst}");
    let left = now.energy + now.enthalpy_out;
    assert!((left / (pressure * 1e6 / (g - 1.0)) - 1.0).abs() < 1e-12, "the first law");
}

/// A lid that moves into a tank compresses its gas along p V^g, with an error of second order in
/// the step. The gas keeps its work as energy, and the energies of lid, walls and gas balance. The
/// walls are soft; a shell of steel outside of the tank sets the step.
#[test]
fn a_piston_compresses_along_the_isentrope() {
    let rest = "[[motion]]\nnodes = \"top\"\nvelocity = [0.0, 0.0, -100.0]\n\
                [[fix]]\nnodes = \"rest\"\n\
                dofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n";
    let soft = "[[material]]\nname = \"soft\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
                youngs_modulus = 1e-5\npoisson = 0.3\n";
    let errors = [0.8, 0.4].map(|safety: f64| {
        let mut surfaces = Surfaces::default();
        surfaces.add(1, 4, &SIDES, false, |x| x.map(|c| 50.0 * (c + 1.0)));
        surfaces.add(2, 1, &SIDES[..1], false, |x| x.map(|c| 5.0 * c - 50.0));
        let keys = format!("{}{rest}{soft}[time]\nsafety = {safety:?}\n", gas(""));
        let text =
            surfaces.text(0.2, 2, &keys).replacen("material = \"steel\"", "material = \"soft\"", 1);
        let (mut worst, mut left) = (0.0f64, 0.0f64);
        let end = run_alone(&model_of(&text, &[]), |e| {
            let now = bag(e);
            let exact = AMBIENT * (1e6 / now.volume).powf(CP / CV);
            worst = worst.max((now.pressure / exact - 1.0).abs());
            let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
            left = left.max(energies.balance(0.0).abs());
        });
        let now = bag(&end);
        assert!((8e5..8.1e5).contains(&now.volume), "the last step is one before: {now:?}");
        let before = AMBIENT * 1e6 / (CP / CV - 1.0);
        assert!((now.energy - before + now.work).abs() < 1e-10 * before, "the first law");
        assert!(left < 1e-3 * now.work.abs(), "{left} {now:?}");
        worst
    });
    assert!(errors[0] < 1e-4, "{errors:?}");
    assert!((errors[0] / errors[1] - 4.0).abs() < 0.5, "second order: {errors:?}");
}

/// A rigid lid on a gas is a spring with the stiffness g p A^2/V: it swings with this frequency,
/// and steadily for many periods, although the light and soft sides of the tank alone would allow
/// steps thirty times as long as the critical one of the lid.
#[test]
fn a_rigid_lid_on_a_gas_swings_as_its_closed_form_says() {
    let soft = "[[material]]\nname = \"soft\"\nlaw = \"elastic\"\ndensity = 1e-9\n\
                youngs_modulus = 1e-8\npoisson = 0.0\n[[part]]\nid = 2\nmaterial = \"soft\"\n\
                thickness = 1.0\n[[rigid]]\nname = \"lid\"\nparts = [1]\n\
                fixed = [\"x\", \"y\", \"rx\", \"ry\", \"rz\"]\n\
                [[initial_velocity]]\nnodes = \"top\"\nvelocity = [0.0, 0.0, 0.5]\n\
                [[fix]]\nnodes = \"rest\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n";
    let tank = gas("").replace("[1]", "[1, 2]").replace(&format!("{AMBIENT:?}"), "0.01");
    let model = |end_time: f64, safety: f64| {
        let mut surfaces = Surfaces::default();
        let place = |x: [f64; 3]| x.map(|c| 50.0 * (c + 1.0));
        surfaces.add(1, 1, &SIDES[5..], true, place);
        surfaces.add(2, 1, &SIDES[..5], true, place);
        let rest = format!("{tank}{soft}[time]\nsafety = {safety:?}\n");
        model_of(&surfaces.text(end_time, 1, &rest), &[])
    };
    let mass = 7.85e-6 * 1e4;
    let omega = (CP / CV * 0.01 * 1e8 / 1e6 / mass).sqrt();
    let mut worst = 0.0f64;
    run_alone(&model(4.0 * PI / omega, 0.1), |e| {
        let rise = (bag(e).volume / 1e6 - 1.0) * 100.0;
        let time = e.clock.time - e.clock.last_dt;
        worst = worst.max((rise - 0.5 / omega * (omega * time).sin()).abs());
    });
    assert!(worst < 0.02 * 0.5 / omega, "1% of strain, 0.06 rad per step: {worst} {omega}");
    let mut fastest = 0.0f64;
    let end = run_alone(&model(200.0 * PI / omega, 0.9), |e| {
        let v = |i: usize| e.nodes.v[i][2].abs();
        fastest = (0..e.nodes.local_count).map(v).fold(fastest, f64::max);
    });
    assert!(end.clock.cycle > 200, "{}", end.clock.cycle);
    assert!(fastest < 0.55, "it keeps its amplitude: {fastest}");
}

/// A sphere of membrane under a small gauge pressure grows by p R^2 (1 - nu)/(2 E t), less the
/// drop of the pressure. The bag is loaded slowly and damped.
#[test]
fn a_sphere_inflates_as_its_elastic_closed_form_says() {
    let (radius, pressure) = (100.0, 1e-3);
    let mut surfaces = Surfaces::default();
    surfaces.add(1, 8, &SIDES, false, |x| on_sphere(x, radius));
    let rest = format!(
        "[[airbag]]\nname = \"ball\"\nparts = [1]\ninverse_pressure = {pressure:?}\n\
         curve = \"ramp\"\n[[curve]]\nname = \"ramp\"\npoints = [[0.0, 0.0], [1.0, 1.0]]\n\
         [time]\ndamping = 5.0\n"
    );
    let model = model_of(&surfaces.text(2.5, 1, &rest), &[]);
    let (mut first, mut largest) = (0.0, 0.0f64);
    let end = run_alone(&model, |e| {
        if e.clock.cycle == 1 {
            first = bag(e).volume;
        }
        let (linear, _) = momentum(&e.nodes);
        largest = linear.iter().fold(largest, |m, c| m.max(c.abs()));
    });
    let now = bag(&end);
    let grown = (now.volume / first).cbrt() - 1.0;
    let exact = now.pressure * radius * (1.0 - 0.3) / (2.0 * 207.0);
    assert!((grown / exact - 1.0).abs() < 0.01, "facets of 384 shells: {grown} {exact}");
    assert!((now.pressure * now.volume / (pressure * first) - 1.0).abs() < 1e-9);
    let pushed = pressure * 4.0 * PI * radius * radius * 2.5;
    assert!(largest < 1e-13 * pushed, "round-off of the pressure over the run: {largest}");
}

/// Half a tank on a plane of symmetry has half the volume, although its surface is open there.
#[test]
fn a_plane_of_symmetry_closes_a_bag() {
    // The sides and the lid z = 50; open at z = 10.
    let sides = [SIDES[0], SIDES[1], SIDES[2], SIDES[3], SIDES[5]];
    let job = |at: &str| {
        let mut surfaces = Surfaces::default();
        surfaces.add(1, 2, &sides, false, |[x, y, z]| {
            [50.0 * (x + 1.0), 50.0 * (y + 1.0), 10.0 + 20.0 * (z + 1.0)]
        });
        let plane = format!("[[symmetry]]\npoint = [0.0, 0.0, {at}]\nnormal = [0.0, 0.0, 1.0]\n");
        surfaces.text(0.01, 1, &format!("{}{plane}", gas("")))
    };
    let end = bag(&run_alone(&model_of(&job("10.0"), &[]), |_| {}));
    assert!((end.volume / 4e5 - 1.0).abs() < 1e-6, "{}", end.volume);
    // A plane elsewhere does not close it.
    let report = refused(&job("50.0"));
    assert!(report.contains("not closed: 8 of its edges are open"), "{report}");
}

/// A body inside a bag is a hole in it, and a body next to it adds to its volume, whichever way
/// their elements are turned.
#[test]
fn bodies_inside_a_bag_are_holes() {
    for aligned in [true, false] {
        let mut surfaces = Surfaces::default();
        surfaces.add(1, 2, &SIDES, aligned, |x| x.map(|c| 50.0 * c));
        surfaces.add(1, 2, &SIDES, aligned, |x| x.map(|c| 20.0 * c));
        surfaces.add(1, 2, &SIDES, aligned, |[x, y, z]| [10.0 * x + 90.0, 10.0 * y, 10.0 * z]);
        let end = bag(&run_alone(&model_of(&surfaces.text(1e-3, 1, &gas("")), &[]), |_| {}));
        let volume = 1e6 - 64e3 + 8e3;
        assert!((end.volume / volume - 1.0).abs() < 1e-6, "{aligned}: {} {volume}", end.volume);
    }
}

/// Two sheets in one plane with a common rim. The normals of their elements decide what is inside:
/// the gas presses them apart. If they do not agree, the bag is refused.
#[test]
fn a_flat_bag_fills_along_its_normals() {
    let job = |aligned: bool, keys: &str| {
        let mut surfaces = Surfaces::default();
        for (side, end) in [(&SIDES[4..5], -1.0), (&SIDES[5..], 1.0)] {
            // The inner nodes of the two sheets differ in the last digits only.
            surfaces.add(1, 4, side, aligned, |[x, y, _]| {
                let inner = x.abs() < 1.0 && y.abs() < 1.0;
                [50.0 * x, 50.0 * y, if inner { 1e-3 * end } else { 0.0 }]
            });
        }
        let own = format!("added_volume = 1e4\npressure = 0.01\n{keys}");
        surfaces.text(0.02, 1, &gas(&own))
    };
    let model = model_of(&job(true, ""), &[]);
    let end = bag(&run_alone(&model, |_| {}));
    assert!(end.volume > 1.001e4, "it opens: {end:?}");
    let turned = model_of(&job(true, "normals_inwards = true\n"), &[]);
    let opposite = |model: &Model| -> Vec<bool> {
        model.settings.loads.airbags[0].faces.iter().map(|f| f.inwards).collect()
    };
    assert_eq!(opposite(&model), [false; 32]);
    assert_eq!(opposite(&turned), [true; 32]);
    let flat = job(false, "").replace("0.001", "0.0");
    let report = refused(&flat);
    assert!(report.contains("is flat at the start, and its elements"), "{report}");
}

/// A free ball of fabric with an inflator and a vent: momentum, energy, and the same bits on 1, 2
/// and 3 workers. The fabric and the air outside have the energy that the gas has lost.
#[test]
fn a_free_bag_keeps_momentum_and_energy_on_any_number_of_workers() {
    let mut surfaces = Surfaces::default();
    surfaces.add(1, 4, &SIDES, false, |x| on_sphere(x, 100.0));
    let inflow = "[[airbag.inflow]]\nrate = 2e-3\ncurve = \"pulse\"\ntemperature = 500.0\n\
                  [[airbag.vent]]\narea = 1000.0\nopening_pressure = 1e-6\n\
                  [[curve]]\nname = \"pulse\"\npoints = [[0.0, 0.0], [0.5, 1.0], [4.0, 0.0]]\n";
    let fabric = "[[material]]\nname = \"cloth\"\nlaw = \"fabric\"\ndensity = 0.9e-6\n\
                  youngs_modulus = 0.3\npoisson = 0.3\n";
    let text = surfaces.text(6.0, 1, &format!("{}{fabric}", gas(inflow)));
    let part = "material = \"cloth\"\nelement = \"belytschko_tsay\"\nmembrane = true\n";
    let model = model_of(&text.replace("material = \"steel\"\n", part), &[]);
    let (mut first, mut left, mut moved) = (None, 0.0f64, 0.0f64);
    let end = run_alone(&model, |e| {
        first.get_or_insert(bag(e));
        let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
        left = left.max(energies.balance(0.0).abs());
        let (linear, _) = momentum(&e.nodes);
        moved = linear.iter().fold(moved, |m, c| m.max(c.abs()));
    });
    let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
    let (first, now) = (first.unwrap(), bag(&end));
    assert!(now.mass_out > 0.0 && now.volume > 1.01 * first.volume, "{now:?}");
    let passed = now.enthalpy_in - now.enthalpy_out;
    let lost = first.energy + passed - now.energy;
    assert!((lost - now.work).abs() < 1e-10 * passed, "the first law: {lost} {}", now.work);
    let pushed = lost - AMBIENT * (now.volume - first.volume);
    assert!(left < 1e-3 * energies.external, "{left} of {}", energies.external);
    assert!((energies.external / pushed - 1.0).abs() < 1e-3, "{} {pushed}", energies.external);
    let mass: f64 = end.nodes.mass.iter().sum();
    assert!(moved < 1e-9 * mass, "round-off at velocities of some mm/ms: {moved}");
    let [one, two, three] = [(1, 0), (2, 0), (3, 17)]
        .map(|(workers, force)| run_side_by_side(&model, workers, 300, force).digest());
    assert_eq!(one, two);
    assert_eq!(one, three);
}

/// The folded bag of `cases/airbag` touches itself: energy, and the same bits on 1 and 2 workers.
#[test]
fn a_folded_bag_keeps_its_energy() {
    let sets = [
        "end_time=1.5",
        "scene.along=6",
        "scene.across=6",
        "scene.radius=1.0",
        "scene.gap=0.5",
        "output.field_interval=-1.0",
    ];
    let model = read(&crumple_tests::case("airbag"), &sets);
    let (mut left, mut pairs) = (0.0f64, 0);
    let end = run_alone(&model, |e| {
        let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
        left = left.max(energies.balance(0.0).abs());
        pairs = pairs.max(e.contact.as_ref().map_or(0, |c| c.owned_pairs().count()));
    });
    let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
    assert!(pairs > 0, "the sheets touch");
    assert!(left < 1e-3 * energies.external, "{left} of {}", energies.external);
    let [one, two] = [1, 2].map(|workers| run_side_by_side(&model, workers, 200, 50).digest());
    assert_eq!(one, two);
}

/// The middle of a lid that moves through the bottom of a bag stops the run. The state before is
/// kept.
#[test]
fn a_bag_that_collapses_stops_the_run() {
    let motion = "[[motion]]\nnodes = \"middle\"\nvelocity = [0.0, 0.0, -4000.0]\n\
                  [[fix]]\nnodes = \"others\"\n\
                  dofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n";
    let mut surfaces = Surfaces::default();
    surfaces.add(1, 2, &SIDES, true, |x| x.map(|c| 50.0 * (c + 1.0)));
    let count = surfaces.scene.count();
    let is_middle = |scene: &Scene, n: u32| scene.at(n) == [50.0, 50.0, 100.0];
    let (middle, others): (Vec<u32>, Vec<u32>) =
        (1..=count).partition(|&n| is_middle(&surfaces.scene, n));
    surfaces.scene.set_named("middle", &middle);
    surfaces.scene.set_named("others", &others);
    let model = model_of(&surfaces.text(0.2, 1, &gas(motion)), &[]);
    let mut last = None;
    let ended = embedded::run_alone(&model, |e| {
        last = Some(bag(e));
        ControlFlow::Continue(())
    })
    .expect("one worker");
    let e = &ended.engine;
    assert_eq!(ended.trouble, Some(StepFailure::Airbag), "at {}", e.clock.time);
    let why = e.airbags.fault().expect("a fault");
    assert!(why.starts_with("airbag `bag`: its volume"), "{why}");
    let kept = bag(e);
    assert_eq!(kept, last.expect("a step"));
    assert!(kept.volume > 0.0 && kept.pressure.is_finite() && kept.energy > 0.0, "{kept:?}");
    let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
    assert!(energies.external.is_finite() && energies.internal.is_finite());
}

/// Returns the report about a job with errors.
fn refused(text: &str) -> String {
    let read = read_text("job.toml".into(), text.to_string(), &[]);
    read.err().unwrap_or_else(|| panic!("it passes: {text}")).to_string()
}

/// Jobs with errors, and what is said about them.
#[test]
fn jobs_with_errors_are_refused() {
    let inflow = |keys: &str| gas(&format!("[[airbag.inflow]]\nrate = 1.0\n{keys}"));
    let vent = |keys: &str| gas(&format!("[[airbag.vent]]\n{keys}"));
    let below = "[[curve]]\nname = \"c\"\npoints = [[0.0, 1.0], [1.0, -1.0]]\n";
    for (job, said) in [
        (format!("{}{}", gas(""), gas("")), "two airbags have the name `bag`"),
        (gas("inverse_pressure = 1.0\n"), "no law of its pressure, or several"),
        (gas("").replace("300.0", "0.0"), "`temperature` is 0.0"),
        (gas("").replace("temperature = 300.0\n", ""), "is not complete"),
        (gas("").replace("1040.0", "700.0"), "`cp` is 700.0"),
        (gas("").replace("[1]", "[7]"), "airbag: there is no part 7"),
        (gas("").replace("parts = [1]\n", ""), "an airbag has neither parts nor nodes"),
        (
            inflow(&format!("temperature = 1.0\ncurve = \"c\"\n{below}")),
            "has the factor -1.0 at 1.0",
        ),
        (
            inflow(&format!("temperature = 1.0\ntemperature_curve = \"c\"\n{below}")),
            "has the factor -1.0 at 1.0",
        ),
        (inflow("temperature = -5.0\n"), "`temperature` is -5.0"),
        (vent(&format!("area = 1.0\ncurve = \"c\"\n{below}")), "has the factor -1.0 at 1.0"),
        (vent(""), "a vent has no area or rate"),
        (vent("rate_over_pressure = [[0.0, -1.0]]\n"), "-1.0 is below 0"),
        (vent("area_over_pressure = [[1.0, 1.0], [0.0, 1.0]]\n"), "0.0 is listed after 1.0"),
        (
            vent("rate_over_pressure = [[0.0, 1.0]]\ncoefficient = 1.0\n"),
            "is for a vent with an area",
        ),
        (
            format!("{}[restart]\ndelete = [1]\n", gas("")),
            "part 1 belongs to the surface of airbag",
        ),
        (format!("{}[time]\nsubcycles = 2\n", gas("")), "airbags do not work with subcycles"),
    ] {
        let report = refused(&cube_text(0.1, &job));
        assert!(report.contains(said), "missing: {said}\n{report}");
    }
    // A sheet inside that belongs to three faces.
    let mut surfaces = Surfaces::default();
    surfaces.add(1, 2, &SIDES, true, |x| x.map(|c| 50.0 * c));
    surfaces.add(1, 2, &SIDES[5..], true, |[x, y, _]| [50.0 * x, 50.0 * y, 0.0]);
    let report = refused(&surfaces.text(0.1, 1, &gas("")));
    assert!(report.contains("belong to three or more faces"), "{report}");
    // A surface that is inside out by its own word.
    let mut surfaces = Surfaces::default();
    let thin = |x: [f64; 3]| [50.0 * x[0], 50.0 * x[1], 1e-2 * x[2]];
    surfaces.add(1, 2, &SIDES, true, thin);
    let report = refused(&surfaces.text(0.1, 1, &gas("normals_inwards = true\n")));
    assert!(report.contains("which has to be above 0"), "{report}");
}
