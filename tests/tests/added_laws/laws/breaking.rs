//! A law with a fault: that of `maxwell.rs`, but its update of shells panics while [`BREAKS`] is
//! set. It shows what a run does when a worker has a bug.

use super::maxwell;
use crumple_worker::fem::materials::{Elastic, Law, LawResult, PlaneStress, Points};
use crumple_worker::math::lanes::{Lane, Lane32};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// The row of this law.
pub static LAW: Law = Law {
    name: "breaking",
    meaning: "Linear viscoelasticity of shells that panics on request.",
    constants: maxwell::LAW.constants,
    parameters: maxwell::LAW.parameters,
    build: Some(build),
    solid: maxwell::LAW.solid,
    cohesive: None,
};

/// True while updates panic.
pub static BREAKS: AtomicBool = AtomicBool::new(false);
/// True while updates are slow, so that a run does not end before a test has seen its checkpoint.
pub static IS_SLOW: AtomicBool = AtomicBool::new(false);
/// Time that a slow update waits.
const WAIT: Duration = Duration::from_millis(1);

struct Breaking(Box<dyn PlaneStress>);

fn build(material: &crumple_proto::partition::Material) -> LawResult {
    let build = maxwell::LAW.build.expect("a law of shells");
    Ok(Box::new(Breaking(build(material)?)))
}

impl PlaneStress for Breaking {
    fn history(&self) -> &[&'static str] {
        self.0.history()
    }
    fn elastic(&self) -> Elastic {
        self.0.elastic()
    }
    fn update(&self, points: Points<'_, Lane>, dt: f64) {
        assert!(!BREAKS.load(Ordering::Relaxed), "a fault that a test requested");
        if IS_SLOW.load(Ordering::Relaxed) {
            std::thread::sleep(WAIT);
        }
        self.0.update(points, dt);
    }
    fn update_short(&self, points: Points<'_, Lane32>, dt: f64) {
        self.0.update_short(points, dt);
    }
    fn update_one(&self, points: Points<'_, f64>, dt: f64) {
        self.0.update_one(points, dt);
    }
}
