//! Harness of the tests across crates: engines side by side without a master, step by step; the
//! binary with a deadline.

pub mod brittle;
pub mod browser;
pub mod client;
pub mod fields;
pub mod imports;
pub mod manual;
pub mod program;
pub mod python_package;
pub mod restart;
pub mod service;
pub mod sheets;
pub mod tools;

pub use crumple::run::embedded::{PairIds, Trace, run_side_by_side, watch_side_by_side};

use crumple::input::job::{self, Model};
use crumple::run::embedded;
use crumple_worker::engine::Engine;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Returns the number in an environment variable, or a default.
pub fn variable(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Returns the path of a folder of `cases/`.
pub fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases").join(name)
}

/// Reads a job with `--set` changes.
///
/// # Panics
/// When the job is bad.
pub fn read(path: &Path, sets: &[&str]) -> Model {
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    job::read(path, &sets).unwrap_or_else(|report| panic!("{report}"))
}

/// Reads the text of a job with `--set` changes. Files that it names are in the present folder.
///
/// # Panics
/// When the job is bad.
pub fn model_of(text: &str, sets: &[&str]) -> Model {
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    job::read_text(PathBuf::from("job.toml"), text.to_string(), &sets)
        .unwrap_or_else(|report| panic!("{report}"))
}

/// Runs a job on one engine to its end; `look` sees the engine after each step.
///
/// # Panics
/// When an element fails.
pub fn run_alone(model: &Model, mut look: impl FnMut(&Engine)) -> Engine {
    let after_each_step = |e: &mut Engine| {
        if e.clock.cycle > 0 {
            look(e);
        }
        ControlFlow::Continue(())
    };
    let ended = embedded::run_alone(model, after_each_step).expect("one worker");
    assert_eq!(ended.trouble, None, "cycle {}", ended.engine.clock.cycle);
    ended.engine
}
