//! A fragment at 300 m/s and a foil of 0.05 mm. They shorten the step while they are near each
//! other only. Units mm, ms, kg.

use crumple::input::job::{self, Model};
use crumple::run::embedded::watch_side_by_side;
use crumple_tests::{run_alone, run_side_by_side};
use crumple_verification::scene::{Elastic, Scene};
use crumple_worker::engine::Engine;

const THICKNESS: f64 = 0.05;
const SPEED: f64 = 300.0;
/// Distance of the fragment from the foil at the start.
const APART: f64 = 160.0;

/// A foil of 4 x 4 shells that is held along its rim, and a fragment of 2 x 2 shells above it, both
/// with sides of 5 mm.
fn scene(contact: &str, apart: f64) -> Model {
    let mut scene = Scene::new(1.1 * apart / SPEED).in_units("mm, ms, kg");
    scene.elastic("steel", Elastic { e: 207.0, nu: 0.3, rho: 7.85e-6 });
    let sizes = [(1, 4, 0.0, 0.0), (2, 2, 6.3, apart)];
    let [foil, fragment] = sizes.map(|(part, n, shift, z)| {
        scene.part(part, "steel", THICKNESS, "");
        let side = 5.0 * n as f64;
        scene.grid(part, [n, n], |u, v| [side * u + shift, side * v + shift, z])
    });
    let rim = foil.rim();
    scene.set_named("rim", &rim);
    scene.set_named("fragment", fragment.all());
    scene.start(fragment.all(), [0.0, 0.0, -SPEED], [0.0; 3]);
    scene.add(contact);
    scene.add("[[fix]]\nnodes = \"rim\"\ndofs = [\"x\", \"y\", \"z\"]");
    let model = job::read_text("fragment.toml".into(), scene.text("Fragment and foil"), &[]);
    model.unwrap_or_else(|report| panic!("{report}"))
}

#[test]
fn a_fragment_far_from_a_foil_does_not_shorten_the_step() {
    let (mut far, mut near, mut steps) = (f64::INFINITY, f64::INFINITY, 0);
    let mut crossed = 0;
    let elements = |e: &Engine| e.agreement.elements_dt;
    let end = run_alone(&scene("[contact]", APART), |e| {
        let heights = |nodes: std::ops::Range<usize>| nodes.map(|n| e.nodes.x[n][2]);
        let foil = heights(0..25).fold(f64::NEG_INFINITY, f64::max);
        let gap = heights(25..34).fold(f64::INFINITY, f64::min) - foil;
        let share = e.clock.dt / elements(e);
        // The whole surface decides the first step, and a step grows for the first time at cycle
        // 512. The search looks four steps of 0.26 mm ahead.
        match e.clock.cycle {
            0..=512 => {}
            _ if gap > 2.0 => far = far.min(share),
            _ if e.clock.dt > 0.0 => near = near.min(share),
            _ => {} // the end
        }
        steps += 1;
        let middle = e.nodes.x[29][2] - e.nodes.x[12][2];
        crossed += usize::from(middle < -THICKNESS);
    });
    let safety = end.settings.safety;
    // Sides change by 1e-3 in flight.
    assert!((far / safety - 1.0).abs() < 2e-3, "far from each other: {far} of the elements' step");
    // A step moves the fragment by at most the sum of both halves, times the safety.
    let limit = safety * THICKNESS / SPEED / elements(&end);
    // The step of the elements is another one at the end, by 1e-3, and the surface moves a little.
    assert!((near / limit - 1.0).abs() < 0.01, "near each other: {near}, limit {limit}");
    // A contact that missed the foil would leave the speed as it was.
    assert!(end.nodes.v[29][2] > -0.9 * SPEED, "the foil brakes it: {}", end.nodes.v[29][2]);
    assert_eq!(crossed, 0, "of {steps} steps");
}

/// Wherever the last renewal before the impact is: a worker needs the foil as ghosts some steps
/// before it touches.
#[test]
fn the_step_and_all_bits_are_those_of_one_worker() {
    for apart in [0.0, 1.0, 2.0, 3.0, 4.0].map(|more| APART + more) {
        let model = scene("[contact]", apart);
        let of = |workers, force| run_side_by_side(&model, workers, u64::MAX, force).digest();
        let alone = of(1, 0);
        for (workers, force) in [(2, 0), (3, 0), (2, 50), (4, 70)] {
            assert_eq!(of(workers, force), alone, "{apart}, {workers} workers, forced {force}");
        }
    }
}

/// The fragment reaches the foil just when the step grows, for the first time at cycle 512: the
/// search must look as far ahead as the longer steps go.
#[test]
fn a_step_does_not_grow_over_a_foil() {
    for apart in (0..40).map(|i| 22.9 + 0.0125 * f64::from(i)) {
        let mut least = f64::INFINITY;
        run_alone(&scene("[contact]", apart), |e| {
            least = least.min(e.nodes.x[29][2] - e.nodes.x[12][2]);
        });
        assert!(least > -THICKNESS, "{apart}: the fragment is {least} over the foil");
    }
}

/// A skin that the job gives is kept. With a narrow one the whole model decides.
#[test]
fn a_given_skin_is_not_widened() {
    let skin = |contact: &str| scene(contact, APART).settings.contact.unwrap().skin;
    assert_eq!(skin("[contact]\nskin = 1.25"), 1.25);
    // The step of the elements is 0.856 us, in which the fragment moves by 0.257 mm.
    let wide = skin("[contact]");
    assert!((wide / (19.2 * 0.257) - 1.0).abs() < 0.01, "{wide}");
    let mut dt = f64::INFINITY;
    let end = run_alone(&scene("[contact]\nskin = 0.5", APART), |e| {
        if e.clock.cycle == 20 {
            dt = e.clock.dt;
        }
    });
    // No force acts in flight, so that the speed is that of the start to round-off.
    let limit = end.settings.safety * THICKNESS / SPEED;
    assert!((dt / limit - 1.0).abs() < 1e-9, "{dt} {limit}");
}

/// Half of the skin that lets near pairs decide belongs to the width in which workers get ghosts.
#[test]
fn ghosts_reach_half_of_the_skin_farther() {
    let width = |contact: &str| {
        let seen = std::sync::Mutex::new(Vec::new());
        let model = scene(contact, APART);
        watch_side_by_side(&model, 2, [2, 0], &|e: &Engine| {
            seen.lock()
                .unwrap()
                .push((e.settings.contact.as_ref().unwrap().skin, e.boxes.half_width));
        });
        seen.into_inner().unwrap()[0]
    };
    // Near pairs do not decide with a skin of 0.5: 0.052 of it is less than both halves.
    let [narrow, wide] = ["[contact]\nskin = 0.5", "[contact]"].map(width);
    // Widths have an allowance of 1e-9 for round-off.
    assert!((wide.1 - narrow.1 - 0.5 * wide.0).abs() < 1e-8 * wide.1, "{narrow:?} {wide:?}");
}
