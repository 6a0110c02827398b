//! Runs the jobs of checks in this process, on one engine each, and watches energy and momentum on the way.

use super::row::Row;
use super::scene::Scene;
use crate::embedded::{Ended, run_alone};
use crate::job::{self, Model};
use crumple_proto::report::Energies;
use crumple_worker::contact::enforce::CONTACT_LAWS;
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Where checks run.
pub struct Bench {
    /// Folder for the job files, if they are to be kept.
    jobs: Option<PathBuf>,
}

/// A run that is over.
pub struct Finished {
    /// The engine at the end.
    pub engine: Engine,
    /// Energies at the end, but for the last step [J].
    pub energies: Energies,
    /// Kinetic energy at the start [J].
    pub initial: f64,
    /// Largest external work so far [J].
    pub came_in: f64,
    /// Largest energy that is not accounted for, as a fraction of that at the start and of external work.
    pub energy_error: f64,
    /// Linear and angular momentum at the start [kg m/s], [kg m^2/s].
    pub momentum: [[f64; 3]; 2],
    /// Whether an element was in trouble.
    pub trouble: bool,
}

impl Bench {
    /// A bench that keeps the jobs in a folder, if there is one.
    pub fn new(jobs: Option<PathBuf>) -> Self {
        Self { jobs }
    }

    /// Names of the contact laws there are.
    pub fn laws(&self) -> impl Iterator<Item = &'static str> {
        CONTACT_LAWS.iter().map(|l| l.name)
    }

    /// Reads a scene as the job file that it is.
    ///
    /// # Errors
    /// The job is bad, or its file cannot be kept.
    pub fn model(&self, name: &str, scene: &Scene) -> Result<Model, String> {
        self.model_of(name, scene.text(name), &[])
    }

    /// Reads the text of a job file, with changes `key=value`.
    ///
    /// # Errors
    /// The job is bad, or its file cannot be kept.
    pub fn model_of(&self, name: &str, text: String, sets: &[String]) -> Result<Model, String> {
        let file = format!("{}.toml", name.replace([' ', ','], "_").replace("__", "_"));
        if let Some(folder) = &self.jobs {
            std::fs::write(folder.join(&file), &text).map_err(|error| format!("{file}: {error}"))?;
        }
        job::read_text(file.into(), text, sets).map_err(|report| report.to_string())
    }

    /// Runs a scene; `look` sees the engine at every time, see [`run_alone`].
    ///
    /// # Errors
    /// The job is bad or cannot be run.
    pub fn run(
        &self,
        name: &str,
        scene: &Scene,
        look: impl FnMut(&mut Engine) -> ControlFlow<()>,
    ) -> Result<Finished, String> {
        run_watched(&self.model(name, scene)?, look)
    }

    /// Runs a scene that must come to its end without trouble; `look` only looks.
    ///
    /// # Errors
    /// The job is bad, cannot be run, or ends in trouble.
    pub fn watch(&self, name: &str, scene: &Scene, mut look: impl FnMut(&Engine)) -> Result<Finished, String> {
        let run = self.run(name, scene, |e| {
            look(e);
            ControlFlow::Continue(())
        })?;
        if run.trouble { Err(format!("{name} ended in trouble at {:e} s", run.engine.clock.time)) } else { Ok(run) }
    }
}

/// Runs a model on one engine and keeps account of energy.
///
/// # Errors
/// It cannot be run.
pub fn run_watched(model: &Model, mut look: impl FnMut(&mut Engine) -> ControlFlow<()>) -> Result<Finished, String> {
    let mut begun = false;
    let (mut initial, mut came_in, mut worst, mut last) = (0.0, 0.0f64, 0.0f64, Energies::default());
    let mut start = [[0.0; 3]; 2];
    let ended = run_alone(model, |e| {
        // The ledger is at the time at which the last step began.
        if begun {
            last = e.ledger.energies(&e.nodes);
            // Work that has come in may go out again: what there was at most is the measure.
            came_in = came_in.max(last.external.abs());
            let scale = initial + came_in;
            if scale > 0.0 {
                worst = worst.max((last.balance(initial) / scale).abs());
            }
        } else {
            initial = e.ledger.energies(&e.nodes).kinetic;
            start = momentum(&e.nodes).into();
            begun = true;
        }
        look(e)
    });
    let Ended { engine, trouble } = ended.map_err(|lost| lost.to_string())?;
    let trouble = trouble.is_some();
    Ok(Finished { engine, energies: last, initial, came_in, energy_error: worst, momentum: start, trouble })
}

impl Finished {
    /// Change of linear momentum along axis `c`, as a fraction of `scale` [kg m/s].
    pub fn momentum_drift(&self, c: usize, scale: f64) -> f64 {
        (momentum(&self.engine.nodes).0[c] - self.momentum[0][c]).abs() / scale
    }

    /// Rows, and after them those on energy.
    pub fn with_energy(&self, variant: &str, limit: f64, mut rows: Vec<Row>) -> Vec<Row> {
        rows.extend(self.energy_rows(variant, limit));
        rows
    }

    /// The gate of the catalogue on energy, 0.1 % for part A, 1 % for others: at the end, and the largest on the way.
    pub fn energy_rows(&self, variant: &str, limit: f64) -> [Row; 2] {
        const GATE: &str = "gate of the catalogue";
        let at_end = (self.energies.balance(self.initial) / (self.initial + self.came_in)).abs();
        [
            Row::new("energy not accounted for at the end", variant, "", at_end).at_most(limit, GATE),
            Row::new("energy not accounted for, largest on the way", variant, "", self.energy_error)
                .at_most(limit, GATE),
        ]
    }
}
