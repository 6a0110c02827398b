//! Airbags compared with closed forms: gas in a rigid tank, a piston, a sphere of membrane; and
//! the balances of momentum and energy. Units mm, ms, kg, so kN, GPa and J.

use crumple::input::job::Model;
use crumple_proto::histories::BagState;
use crumple_tests::{model_of, read, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;
use crumple_worker::math::row::xyz;
use std::collections::HashMap;
use std::fmt::Write;

const CV: f64 = 743.0;
const CP: f64 = 1040.0;
const AMBIENT: f64 = 1e-4;

const STEEL: &str = "[output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\n\
    law = \"elastic\"\ndensity = 7.85e-6\nyoungs_modulus = 207.0\npoisson = 0.3\n";

/// Returns a cube of side 100 with 4 x 4 shells on each side, part 1. The set `all` holds all
/// nodes, `top` those at z = 100, `rest` the others. Nodes keep `dofs`; `rest` is the rest of the
/// job.
fn cube(end_time: f64, sets: &str) -> Model {
    let mut scene = Scene::default();
    let mut known = HashMap::new();
    let mut node = |scene: &mut Scene, x: [f64; 3]| {
        let key = x.map(|c| (c * 1e3).round() as i64);
        *known.entry(key).or_insert_with(|| scene.node(x))
    };
    for axis in 0..3 {
        for end in [0.0, 100.0] {
            let place = |a: f64, b: f64| {
                let mut x = [end; 3];
                (x[(axis + 1) % 3], x[(axis + 2) % 3]) = (100.0 * a, 100.0 * b);
                x
            };
            scene.grid_of(1, [4, 4], place, &mut node);
        }
    }
    let of = |scene: &Scene, top: bool| -> Vec<u32> {
        (1..=scene.count()).filter(|&n| (scene.at(n)[2] == 100.0) == top).collect()
    };
    let (top, rest) = (of(&scene, true), of(&scene, false));
    scene.set_named("top", &top);
    scene.set_named("rest", &rest);
    scene.set_named("all", &[top, rest].concat());
    let text = format!(
        "end_time = {end_time:?}\n{}{STEEL}[[part]]\nid = 1\nmaterial = \"steel\"\n\
         thickness = 1.0\n{sets}",
        scene.mesh_text()
    );
    model_of(&text, &[])
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

/// A lid that moves into a tank compresses its gas along p V^g; the gas keeps its work as energy.
#[test]
fn a_piston_compresses_along_the_isentrope() {
    let motion = "[[motion]]\nnodes = \"top\"\nvelocity = [0.0, 0.0, -100.0]\n\
                  [[fix]]\nnodes = \"rest\"\n\
                  dofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n";
    let mut worst = 0.0f64;
    let end = run_alone(&cube(0.2, &gas(motion)), |e| {
        let now = bag(e);
        let exact = AMBIENT * (1e6 / now.volume).powf(CP / CV);
        worst = worst.max((now.pressure / exact - 1.0).abs());
    });
    let now = bag(&end);
    assert!((now.volume / 8e5 - 1.0).abs() < 1e-6, "{}", now.volume);
    assert!(worst < 1e-5, "second order in a change of the volume of 1e-3 per step: {worst}");
    let (before, after) = (AMBIENT * 1e6 / (CP / CV - 1.0), now.energy);
    assert!((after - before + now.work).abs() < 1e-10 * before, "the first law");
}

/// A sphere of membrane under a small gauge pressure grows by p R^2 (1 - nu)/(2 E t), less the
/// drop of the pressure. The bag is loaded slowly and damped; it starts with a gas of its own.
#[test]
fn a_sphere_inflates_as_its_elastic_closed_form_says() {
    let (radius, thickness, pressure) = (100.0, 1.0, 1e-3);
    let mut scene = Scene::default();
    let mut known = HashMap::new();
    let n = 8;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let place = |a: f64, b: f64| {
                // Equal angles on each side of a cube.
                let angle = |s: f64| ((s - 0.5) * std::f64::consts::FRAC_PI_2).tan();
                let mut x = [side; 3];
                (x[(axis + 1) % 3], x[(axis + 2) % 3]) = (side * angle(a), angle(b));
                let size = x.iter().map(|c| c * c).sum::<f64>().sqrt();
                x.map(|c| c * radius / size)
            };
            scene.grid_of(1, [n, n], place, |scene, x| {
                let key = x.map(|c| (c * 1e3).round() as i64);
                *known.entry(key).or_insert_with(|| scene.node(x))
            });
        }
    }
    let bag_text = format!(
        "[[airbag]]\nname = \"ball\"\nparts = [1]\ninverse_pressure = {pressure:?}\n\
         curve = \"ramp\"\n[[curve]]\nname = \"ramp\"\npoints = [[0.0, 0.0], [1.0, 1.0]]\n"
    );
    let text = format!(
        "end_time = 3.0\n{}{STEEL}[[part]]\nid = 1\nmaterial = \"steel\"\n\
         thickness = {thickness:?}\n{bag_text}[time]\ndamping = 5.0\n",
        scene.mesh_text()
    );
    let model = model_of(&text, &[]);
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
    let exact = now.pressure * radius * (1.0 - 0.3) / (2.0 * 207.0 * thickness);
    assert!((grown / exact - 1.0).abs() < 0.01, "facets of 384 shells: {grown} {exact}");
    assert!((now.pressure * now.volume / (pressure * first) - 1.0).abs() < 1e-9);
    let pushed = pressure * 4.0 * std::f64::consts::PI * radius * radius * 3.0;
    assert!(largest < 1e-13 * pushed, "round-off of the pressure over the run: {largest}");
}

/// Half a tank on a plane of symmetry has half the volume, although its surface is open there.
#[test]
fn a_plane_of_symmetry_closes_a_bag() {
    let mut scene = Scene::default();
    let mut known = HashMap::new();
    let mut node = |scene: &mut Scene, x: [f64; 3]| {
        let key = x.map(|c| (c * 1e3).round() as i64);
        *known.entry(key).or_insert_with(|| scene.node(x))
    };
    // The sides x = 0, x = 100, y = 0, y = 100 and the lid z = 50; open at z = 10.
    for (axis, end) in [(0, 0.0), (0, 100.0), (1, 0.0), (1, 100.0), (2, 50.0)] {
        let place = |a: f64, b: f64| {
            let [u, w] = [(axis + 1) % 3, (axis + 2) % 3];
            let along = |axis: usize, s: f64| if axis == 2 { 10.0 + 40.0 * s } else { 100.0 * s };
            let mut x = [end; 3];
            (x[u], x[w]) = (along(u, a), along(w, b));
            x
        };
        scene.grid_of(1, [2, 2], place, &mut node);
    }
    let job = |rest: &str| {
        format!(
            "end_time = 0.01\n{}{STEEL}[[part]]\nid = 1\nmaterial = \"steel\"\nthickness = 1.0\n{}\
             [[symmetry]]\npoint = [0.0, 0.0, {rest}]\nnormal = [0.0, 0.0, 1.0]\n",
            scene.mesh_text(),
            gas("")
        )
    };
    let end = bag(&run_alone(&model_of(&job("10.0"), &[]), |_| {}));
    assert!((end.volume / 4e5 - 1.0).abs() < 1e-6, "{}", end.volume);
    // A plane elsewhere does not close it.
    let text = job("50.0");
    let refused = crumple::input::job::read_text("job.toml".into(), text, &[]);
    let report = refused.err().expect("an open surface").to_string();
    assert!(report.contains("not closed: 8 of its edges are open"), "{report}");
}

/// The folded bag of `cases/airbag`: momentum, energy, and the same bits on 1, 2 and 3 workers.
#[test]
fn a_folded_bag_keeps_momentum_and_energy_on_any_number_of_workers() {
    let mut sets = String::new();
    write!(sets, "end_time=4.0").unwrap();
    let model = read(
        &crumple_tests::case("airbag"),
        &[&sets, "scene.along=6", "scene.across=8", "output.field_interval=-1.0"],
    );
    let (mut left, mut moved, mut pairs) = (0.0f64, 0.0f64, 0);
    let end = run_alone(&model, |e| {
        let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
        left = left.max(energies.balance(0.0).abs());
        let (linear, _) = momentum(&e.nodes);
        moved = linear.iter().fold(moved, |m, c| m.max(c.abs()));
        pairs = pairs.max(e.contact.as_ref().map_or(0, |c| c.owned_pairs().count()));
    });
    let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
    let now = bag(&end);
    assert!(pairs > 0, "the sheets touch");
    assert!(now.volume > 2e5, "it fills: {now:?}");
    assert!(left < 1e-3 * energies.external, "{left} of {}", energies.external);
    // The fabric and the air outside have the energy that the gas has lost.
    let start = model.settings.loads.airbags[0].ambient_pressure;
    let first = run_alone(&read_start(&model), |_| {});
    let pushed = now.work - start * (now.volume - bag(&first).volume);
    assert!((energies.external / pushed - 1.0).abs() < 1e-3, "{} {pushed}", energies.external);
    let speed = 1.0; // fabric moves by some mm/ms
    let mass: f64 = (0..end.nodes.local_count).map(|i| end.nodes.mass[i]).sum();
    assert!(moved < 1e-9 * mass * speed, "{moved}");
    let [one, two, three] =
        [1, 2, 3].map(|workers| run_side_by_side(&model, workers, 1500, 100).digest());
    assert_eq!(one, two);
    assert_eq!(one, three);
    let x = end.nodes.x.iter().map(xyz).flatten();
    assert!(x.into_iter().all(f64::is_finite));
}

/// Returns the model of the bag with an end after one step.
fn read_start(model: &Model) -> Model {
    let mut first = read(
        &crumple_tests::case("airbag"),
        &["scene.along=6", "scene.across=8", "output.field_interval=-1.0"],
    );
    first.settings.end_time = 1e-6 * model.settings.end_time;
    first
}
