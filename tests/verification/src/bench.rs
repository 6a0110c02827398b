//! Runs the jobs of checks in this process, on one engine each, and observes energy and momentum
//! during the run.

use super::laws::Law;
use super::row::CheckRow;
use super::scene::Scene;
use crumple::input::job::{self, Model};
use crumple::run::embedded::{Ended, run_alone};
use crumple_proto::report::Energies;
use crumple_worker::contact::enforce::CONTACT_LAWS;
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Environment in which checks run.
pub struct Bench {
    /// Folder for the job files, if they are kept.
    jobs: Option<PathBuf>,
}

/// Result of a completed run.
pub struct Finished {
    /// Engine at the end.
    pub engine: Engine,
    /// Energies at the start of the last step [J].
    pub energies: Energies,
    /// Kinetic energy at the start [J].
    pub initial: f64,
    /// Largest external work during the run [J].
    pub came_in: f64,
    /// Largest error of the energy balance, as a fraction of the initial energy and the external
    /// work.
    pub energy_error: f64,
    /// Largest energy that contact, friction and walls gave, each one counted only where it is
    /// positive [J].
    pub given: f64,
    /// Largest hourglass energy and largest internal energy [J].
    pub stored: [f64; 2],
    /// Flags: there is contact or a wall, and contact uses springs.
    touches: bool,
    springs: bool,
    /// Linear and angular momentum at the start [kg m/s], [kg m^2/s].
    pub momentum: [[f64; 3]; 2],
    /// True if an element failed.
    pub trouble: bool,
}

impl Bench {
    /// Creates a bench; it keeps the job files in the folder `jobs`, if there is one.
    pub fn new(jobs: Option<PathBuf>) -> Self {
        Self { jobs }
    }

    /// Returns the names of the contact laws for nodes on segments.
    pub fn laws(&self) -> impl Iterator<Item = &'static str> {
        CONTACT_LAWS
            .iter()
            .map(|l| l.name)
            .filter(|&name| Law::BY_SEGMENTS.iter().all(|law| !law.has_name(name)))
    }

    /// Reads a scene as a job file.
    ///
    /// # Errors
    /// The job is bad, or its file cannot be kept.
    pub fn model(&self, name: &str, scene: &Scene) -> Result<Model, String> {
        self.model_of(name, scene.text(name), &[])
    }

    /// Reads the text of a job file, with changes `key=value`. The file that is kept names the
    /// changes at its start.
    ///
    /// # Errors
    /// The job is bad, or its file cannot be kept.
    pub fn model_of(&self, name: &str, text: String, sets: &[String]) -> Result<Model, String> {
        let file = format!("{}.toml", name.replace([' ', ',', '/'], "_").replace("__", "_"));
        if let Some(folder) = &self.jobs {
            // The text does not contain the changes; without this comment the file would be
            // another job.
            let with: String = sets.iter().map(|set| format!("# --set '{set}'\n")).collect();
            std::fs::write(folder.join(&file), with + &text)
                .map_err(|error| format!("{file}: {error}"))?;
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

    /// Runs a scene that must reach its end without failed elements; `look` only observes.
    ///
    /// # Errors
    /// The job is bad, cannot be run, or ends with a failed element.
    pub fn watch(
        &self,
        name: &str,
        scene: &Scene,
        mut look: impl FnMut(&Engine),
    ) -> Result<Finished, String> {
        let run = self.run(name, scene, |e| {
            look(e);
            ControlFlow::Continue(())
        })?;
        if run.trouble {
            Err(format!(
                "{name}: the run stopped at {:e} s because an element failed",
                run.engine.clock.time
            ))
        } else {
            Ok(run)
        }
    }
}

/// Runs a model on one engine and records the energies.
///
/// # Errors
/// It cannot be run.
pub fn run_watched(
    model: &Model,
    mut look: impl FnMut(&mut Engine) -> ControlFlow<()>,
) -> Result<Finished, String> {
    let mut begun = false;
    let (mut initial, mut came_in, mut worst, mut last) =
        (0.0, 0.0f64, 0.0f64, Energies::default());
    let mut start = [[0.0; 3]; 2];
    let (mut given, mut stored) = (0.0f64, [0.0f64; 2]);
    let ended = run_alone(model, |e| {
        // The ledger is at the time at which the last step began.
        if begun {
            last = e.ledger.energies(&e.nodes, &e.blocks).values();
            // External work can be returned, so its largest value is the measure.
            came_in = came_in.max(last.external.abs());
            // Normal contact, friction and walls count separately: the loss of one must not hide
            // the gain of another.
            given = given.max(
                [last.contact - last.friction, last.friction, last.wall]
                    .map(|w| w.max(0.0))
                    .iter()
                    .sum(),
            );
            stored = [stored[0].max(last.hourglass.abs()), stored[1].max(last.internal)];
            let scale = initial + came_in;
            if scale > 0.0 {
                worst = worst.max((last.balance(initial) / scale).abs());
            }
        } else {
            initial = e.ledger.energies(&e.nodes, &e.blocks).values().kinetic;
            start = momentum(&e.nodes).into();
            begun = true;
        }
        look(e)
    });
    let Ended { engine, trouble } = ended.map_err(|lost| lost.to_string())?;
    let trouble = trouble.is_some();
    let contact = model.job.contact.as_ref();
    Ok(Finished {
        engine,
        energies: last,
        initial,
        came_in,
        energy_error: worst,
        given,
        stored,
        touches: contact.is_some() || !model.job.wall.is_empty(),
        springs: contact.is_some_and(|c| super::laws::is_spring(&c.law)),
        momentum: start,
        trouble,
    })
}

impl Finished {
    /// Returns the change of linear momentum along axis `c`, as a fraction of `scale` [kg m/s].
    pub fn momentum_drift(&self, c: usize, scale: f64) -> f64 {
        (momentum(&self.engine.nodes).0[c] - self.momentum[0][c]).abs() / scale
    }

    /// Returns `rows`, followed by those on energy.
    pub fn with_energy(&self, variant: &str, limit: f64, mut rows: Vec<CheckRow>) -> Vec<CheckRow> {
        rows.extend(self.energy_rows(variant, limit));
        rows
    }

    /// Returns the initial energy plus the external work [J].
    fn measure(&self) -> f64 {
        self.initial + self.came_in
    }

    /// Returns the energy criterion of the catalogue: the energy that contact, friction and
    /// walls give, or without them the error of the balance. `limit` is 0.1 % for part A, 1 %
    /// for others.
    pub fn energy_rows(&self, variant: &str, limit: f64) -> [CheckRow; 1] {
        [if self.touches { self.given_row(variant) } else { self.closing_row(variant, limit) }]
    }

    /// Returns the energy that contact, friction and walls give. They may only take energy. The
    /// balance of the ledger does not show this, because it closes in both cases.
    pub fn given_row(&self, variant: &str) -> CheckRow {
        let row = CheckRow::new(
            "work given by contact, friction and walls, largest / energy",
            variant,
            "",
            self.given(),
        );
        // Springs of several pairs with common nodes; the catalogue allows half a per cent (A29).
        match self.springs {
            true => row.at_most(5e-3, "limit of A29 for springs"),
            false => row.at_most(1e-3, "[D] they only absorb energy; limit of part A"),
        }
    }

    /// Returns the energy that contact, friction and walls give, as a fraction.
    pub fn given(&self) -> f64 {
        self.given / self.measure()
    }

    /// Compares the hourglass energy with the internal energy, or with a hundredth of all energy
    /// if bodies hardly deform.
    pub fn hourglass_row(&self, variant: &str) -> CheckRow {
        let [hourglass, internal] = self.stored;
        let share = hourglass / internal.max(0.01 * self.measure());
        CheckRow::new("hourglass energy / internal energy, largest of each", variant, "", share)
            .at_most(0.1, "limit of the catalogue, 5 to 10 %")
    }

    /// Returns the error of the energy balance. With a constant step it is zero by construction;
    /// it is not if elements book other work than they do, or if the step is unstable.
    pub fn closing_row(&self, variant: &str, limit: f64) -> CheckRow {
        CheckRow::new(
            "energy not accounted for, largest on the way",
            variant,
            "",
            self.energy_error,
        )
        .at_most(limit, "limit of the catalogue")
    }
}
