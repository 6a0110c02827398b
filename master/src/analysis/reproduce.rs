//! `crumple reproduce`: runs the job of a folder of results again and compares the final states.

use crate::cli::{JobOptions, ReproduceArgs, RunArgs};
use crate::results::provenance::{ProgramStart, Provenance};
use crate::run::launch;
use crate::stdout::say;
use crumple_proto::exit_code::{BAD_INPUT, COMPLETED, STOPPED, UNMET, WORKER_LOST};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Keys that change no state: runs that continued with a change of one of them can be reproduced.
const HARMLESS: [&str; 5] = ["title", "output", "parallel", "checkpoint", "require"];

/// The part of `summary.json` that is read.
#[derive(Debug, Deserialize)]
struct RunOutcome {
    status: String,
    cycles: u64,
    state_digest: String,
    restarts: Vec<Continuation>,
    steering: Vec<serde_json::Value>,
}

#[derive(Debug, Deserialize)]
struct Continuation {
    changes: Vec<String>,
}

/// A run, as its folder describes it.
pub(super) struct KnownRun {
    /// Its last start.
    pub(super) start: ProgramStart,
    outcome: RunOutcome,
}

/// Runs the job again. Returns the exit code: 1 if the final state differs.
pub fn run(args: &ReproduceArgs) -> u8 {
    let known = match known_run(args) {
        Ok(known) => known,
        Err(problems) => {
            problems.iter().for_each(|why| eprintln!("error: {why}"));
            return BAD_INPUT;
        }
    };
    let out = args.out_dir();
    let code = launch::run(&repeated(args, &known, &out));
    if [BAD_INPUT, WORKER_LOST].contains(&code) || (code == STOPPED && !known.was_stopped()) {
        return code;
    }
    match RunOutcome::read(&out) {
        Ok(outcome) => judge(&known.outcome, &outcome, [&args.dir, &out]),
        Err(why) => {
            eprintln!("error: {why}");
            BAD_INPUT
        }
    }
}

impl KnownRun {
    /// Reads the files that describe a run.
    ///
    /// # Errors
    /// One of them is missing or cannot be used; the message names it.
    pub(super) fn read(dir: &Path) -> Result<Self, String> {
        let provenance = Provenance::read(dir).map_err(|why| {
            format!("{why}; name the folder of a run of this version of the program")
        })?;
        let outcome = RunOutcome::read(dir)
            .map_err(|why| format!("{why}; a run has a final state when it has ended"))?;
        Ok(Self { start: provenance.last().clone(), outcome })
    }

    /// Returns the reason why one run from time 0 does not repeat this one, if there is one.
    pub(super) fn obstacle(&self, dir: &Path) -> Option<String> {
        let changes = self.outcome.restarts.iter().flat_map(|restart| &restart.changes);
        let is_harmless = |change: &&String| {
            HARMLESS.iter().any(|key| {
                change.strip_prefix(key).is_some_and(|rest| rest.starts_with(['.', '=']))
            })
        };
        let change = changes.into_iter().find(|change| !is_harmless(change))?;
        Some(format!(
            "{}: the run continued from a checkpoint with the change {change}: one run from time 0 \
             does not repeat it; repeat the commands in provenance.json",
            dir.display()
        ))
    }

    /// Returns a line for each file that the run has read and that has changed since.
    pub(super) fn changed_files(&self) -> Vec<String> {
        let changed = self.start.changed_files().into_iter();
        changed.map(|why| format!("{why}; the run has read another file")).collect()
    }

    /// Returns the number of cycles of the run.
    pub(super) fn cycles(&self) -> u64 {
        self.outcome.cycles
    }

    /// Returns the file with the orders of users that the run has carried out, if there were any.
    pub(super) fn steering(&self, dir: &Path) -> Option<PathBuf> {
        (!self.outcome.steering.is_empty()).then(|| dir.join("summary.json"))
    }

    fn was_stopped(&self) -> bool {
        self.outcome.status == "stopped"
    }
}

/// Returns an error if the program was started by MPI.
///
/// # Errors
/// It was.
pub(super) fn refuse_mpi(command: &str) -> Result<(), String> {
    match launch::launched_by_mpi() {
        true => Err(format!(
            "`crumple {command}` starts its own workers, as threads: run it without mpirun"
        )),
        false => Ok(()),
    }
}

impl RunOutcome {
    fn read(dir: &Path) -> Result<Self, String> {
        let path = dir.join("summary.json");
        let named = |why: String| format!("{}: {why}", path.display());
        let text = std::fs::read_to_string(&path).map_err(|error| named(error.to_string()))?;
        serde_json::from_str(&text).map_err(|error| named(error.to_string()))
    }
}

/// Reads what is known of the run.
///
/// # Errors
/// All reasons why it cannot be repeated.
fn known_run(args: &ReproduceArgs) -> Result<KnownRun, Vec<String>> {
    let mut problems: Vec<String> = refuse_mpi("reproduce").err().into_iter().collect();
    let known = KnownRun::read(&args.dir).map_err(|why| vec![why])?;
    let status = &known.outcome.status;
    if !["completed", "stopped"].contains(&&status[..]) {
        problems.push(format!(
            "{}: the run has {status}: the cycle in which it ends depends on the machine",
            args.dir.display(),
        ));
    }
    problems.extend(known.obstacle(&args.dir));
    if !args.allow_changed {
        let changed = known.changed_files();
        if !changed.is_empty() {
            problems.extend(changed);
            problems.push(
                "restore these files, or run the job with them as they are: --allow-changed".into(),
            );
        }
    }
    if problems.is_empty() { Ok(known) } else { Err(problems) }
}

/// Returns the options of the run that repeats the known one.
fn repeated(args: &ReproduceArgs, known: &KnownRun, out: &Path) -> RunArgs {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let workers = args.workers.unwrap_or(known.start.workers.min(cores));
    if !args.quiet {
        say!(
            "{} was made by {} on {}, {}: {}",
            args.dir.display(),
            known.start.program(),
            known.start.host,
            known.start.began,
            known.start.command.join(" ")
        );
    }
    RunArgs {
        job: Some(known.start.job_file.clone()),
        options: JobOptions::new(Some(workers), known.start.set.clone()),
        out: Some(out.to_owned()),
        overwrite: args.overwrite,
        quiet: args.quiet,
        no_report: true,
        steering: known.steering(&args.dir),
        ..RunArgs::default()
    }
}

/// Prints the verdict and returns the exit code.
fn judge(known: &RunOutcome, now: &RunOutcome, [dir, out]: [&PathBuf; 2]) -> u8 {
    let end = |outcome: &RunOutcome| {
        format!(
            "{} after {} cycles, state_digest {}",
            outcome.status, outcome.cycles, outcome.state_digest
        )
    };
    if known.state_digest == now.state_digest && known.cycles == now.cycles {
        say!("PASS  {}: {}", out.display(), end(now));
        return COMPLETED;
    }
    say!("FAIL  the final states differ");
    say!("  {}: {}", dir.display(), end(known));
    say!("  {}: {}", out.display(), end(now));
    say!("find the first difference with: crumple diff {} {}", dir.display(), out.display());
    UNMET
}
