//! Two sheets of 3 x 3 shells that fly at each other, one above the other. Units mm, ms, kg.

use crate::run_alone;
use crumple::input::job;
use crumple_verification::scene::{Elastic, Scene};

/// Returns the distance of the sheets at the first contact force on the lower one [mm]; afterwards
/// they bend. The lower sheet is part 1 with the shells 1 to 9 and the set `low`. The upper one is
/// part 2 with the shells 10 to 18 and the set `high`. `contact` are the lines of contact in the
/// job, `sets` changes of keys.
///
/// # Panics
/// If the job is bad or the sheets do not touch.
pub fn distance_at_contact(contact: &str, sets: &[&str]) -> f64 {
    let mut scene = Scene::new(6.0).in_units("mm, ms, kg");
    scene.elastic("steel", Elastic { e: 207.0, nu: 0.3, rho: 7.85e-6 });
    let [low, high] = [(1, 0.0, 0.0), (2, 6.0, 1.3)].map(|(part, z, shift)| {
        scene.part(part, "steel", 1.0, "");
        scene.grid(part, [3, 3], |u, v| [15.0 * u + shift, 15.0 * v + shift, z])
    });
    scene.set_named("low", low.all());
    scene.set_named("high", high.all());
    scene.start(high.all(), [0.0, 0.0, -1.0], [0.0; 3]);
    scene.add(contact);
    let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
    let model = job::read_text("sheets.toml".into(), scene.text("Two sheets"), &sets);
    let model = model.unwrap_or_else(|report| panic!("{report}"));
    let mut apart = None;
    run_alone(&model, |e| {
        let heights = |nodes: std::ops::Range<usize>| nodes.map(|n| e.nodes.x[n][2]);
        let is_pushed = (0..16).any(|n| e.nodes.v[n][2] != 0.0);
        if is_pushed && apart.is_none() {
            let lowest = heights(16..32).fold(f64::INFINITY, f64::min);
            apart = Some(lowest - heights(0..16).fold(f64::NEG_INFINITY, f64::max));
        }
    });
    apart.expect("there is contact")
}
