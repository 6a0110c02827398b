//! The run on one page: distribute the model, receive reports, decide, write results, stop.

mod begin;
mod distribute;
mod finish;
mod receive;
mod steer;
mod view;
mod watch;

use crate::input::job::Model;
use crate::results::fields::FieldSeries;
use crate::results::history::History;
use crate::results::provenance::ProgramStart;
use crate::results::summary::{MeshOutline, RestartSummary, Summary};
use crate::results::table::Tables;
use crate::results::trace::TraceFile;
use crate::results::warnings::EngineeringWarning;
use crate::results::workers;
use crate::run::balance::Balance;
use crate::run::checkpoint::find::Resumption;
use crate::run::checkpoint::manifest::Stamp;
use crate::run::checkpoint::{Checkpoints, MasterState};
use crate::run::progress::{Audience, ProgressDisplay, RunState};
use crate::run::service::Desk;
use crate::run::service::signals::StopFlag;
use crumple_proto::boxes::CutTree;
use crumple_proto::disk;
use crumple_proto::exit_code::{BAD_INPUT, WORKER_LOST};
use crumple_proto::message::{Action, ToMaster, ToWorker};
use crumple_proto::partition::NodeRecord;
use crumple_proto::report::{Failure, FinalReport};
use crumple_proto::transport::{RankLost, Tag, Transport};
use crumple_proto::wire::{poll_message, post};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use steer::Steering;
use view::Viewing;

/// Sleep of the master when there is nothing to do, so that it does not occupy a core that
/// workers need.
const NAP: Duration = Duration::from_micros(500);
/// Time for which the master waits for recordings after the loss of a worker.
const LAST_WORDS: Duration = Duration::from_secs(2);

/// Reason why a run has no summary.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A worker was lost.
    #[error("a worker was lost: {0}; the results so far are in the output folder")]
    Lost(#[from] RankLost),
    /// Results cannot be written.
    #[error("{path}: {error}; choose another folder with --out", path = .path.display())]
    Output {
        /// File or folder that cannot be written.
        path: PathBuf,
        /// Error of the operating system.
        error: std::io::Error,
    },
    /// A checkpoint with the right sums cannot be used.
    #[error("{0}; continue from another checkpoint: give its folder with --resume")]
    Unusable(String),
    /// A change of the model does not fit the state of the checkpoint.
    #[error("{0}; nothing in the folder was changed")]
    Refused(String),
    /// The trace cannot be written.
    #[error("{path}: {error}; choose another file with --trace", path = .path.display())]
    Trace {
        /// File of the trace.
        path: PathBuf,
        /// Error of the operating system.
        error: std::io::Error,
    },
}

impl RunError {
    /// Returns the exit code of the run.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Lost(_) => WORKER_LOST,
            Self::Output { .. } | Self::Unusable(_) | Self::Refused(_) | Self::Trace { .. } => {
                BAD_INPUT
            }
        }
    }
}

/// State of a run on the master.
pub struct Control<'a> {
    began: Instant,
    /// The model, without its mesh after the distribution.
    model: &'a mut Model,
    /// Numbers of the mesh that the summary contains.
    outline: MeshOutline,
    comm: &'a mut dyn Transport,
    workers: usize,
    tree: CutTree,
    balance: Balance,
    history: History,
    /// `workers.csv`.
    of_workers: workers::WorkerFile,
    series: FieldSeries,
    progress: ProgressDisplay,
    out: PathBuf,
    orders: u64,
    stop_ordered: bool,
    /// Workers that have stopped for a low redecomposition, and the time at which the first one
    /// stopped.
    ready: Vec<usize>,
    ready_since: Option<Instant>,
    /// Number of field pieces written, per output index.
    pieces: BTreeMap<usize, usize>,
    trouble: Option<Failure>,
    /// Engineering warnings so far.
    warnings: Vec<EngineeringWarning>,
    closings: Vec<Option<FinalReport>>,
    trace: Option<TraceFile>,
    states: Vec<NodeRecord>,
    checkpoints: Checkpoints,
    /// The checkpoint from which the run continues, until the user knows.
    from: Option<Resumption>,
    /// Continuations so far.
    restarts: Vec<RestartSummary>,
    /// Wall time before the checkpoint [s].
    wall_before: f64,
    /// Orders of users and their clients.
    steering: Steering,
    /// Pictures for clients.
    viewing: Viewing,
}

/// Output locations of a run.
#[derive(Clone, Copy, Debug)]
pub struct Results<'a> {
    /// Folder for the results of every run.
    pub out: &'a Path,
    /// File for the timeline of all workers, if requested.
    pub trace: Option<&'a Path>,
}

/// The job as manifests name it, and the checkpoint from which the run continues, if any.
#[derive(Default)]
pub struct Origin {
    /// The job.
    pub stamp: Stamp,
    /// The program, its command, and the files that it has read.
    pub start: ProgramStart,
    /// The checkpoint, and the changes of the job since then.
    pub from: Option<(Resumption, Vec<String>)>,
}

/// Runs a job with the workers at the other ranks of `comm`. The model loses its mesh after the
/// distribution.
///
/// # Errors
/// A worker was lost, or results cannot be written.
pub fn run(
    model: &mut Model,
    comm: &mut dyn Transport,
    results: Results<'_>,
    mut origin: Origin,
    guidance: Guidance<'_>,
) -> Result<Summary, RunError> {
    let _run = tracing::info_span!("run", rank = 0).entered();
    let patience = model.job.checkpoint.patience().expect("the job is checked when it is read");
    disk::set_patience(patience);
    let Guidance { audience, stop, desk } = guidance;
    // The files of the run are changed only when all workers have the state of the checkpoint.
    let tree = match &mut origin.from {
        None => CutTree::single(),
        Some((from, _)) => distribute::restore(model, comm, results, from)?,
    };
    let new = || Control::new(model, comm, results, (origin, tree), (audience, desk));
    let mut control = disk::watched(results.out, new)?;
    let ended = control.conclude(stop);
    control.viewing.end();
    match &ended {
        Ok(summary) => control.steering.end(summary.exit_code(), &summary.reason),
        Err(error) => control.steering.end(error.exit_code(), &error.to_string()),
    }
    ended
}

/// How a run is shown and who may steer it.
pub struct Guidance<'a> {
    /// The reader of progress and messages.
    pub audience: Audience,
    /// Requests by signals.
    pub stop: &'a StopFlag,
    /// Requests by clients; without a socket `None`.
    pub desk: Option<Desk>,
}

impl<'a> Guidance<'a> {
    /// Returns that of a quiet run without clients.
    pub fn quiet(stop: &'a StopFlag) -> Self {
        Self { audience: Audience::Silent, stop, desk: None }
    }
}

impl Control<'_> {
    /// Supervises the run and writes its results.
    fn conclude(&mut self, stop: &StopFlag) -> Result<Summary, RunError> {
        let ended = self.supervise(stop);
        // Also after a loss: a checkpoint may lack its manifest only.
        for finished in self.checkpoints.wait() {
            self.show_checkpoint(finished);
        }
        let traced = self.write_trace();
        ended?;
        self.progress.finish();
        let summary = self.finish()?;
        traced?; // after the messages of the run itself
        Ok(summary)
    }

    /// Distributes the model and supervises the run until all workers have sent their final
    /// reports.
    fn supervise(&mut self, stop: &StopFlag) -> Result<(), RunError> {
        match self.from.take() {
            None => {
                self.watch_mass();
                self.deal_out()?;
            }
            Some(from) => self.continue_from(&from),
        }
        while self.closings.iter().any(Option::is_none) {
            let heard = self.listen()?;
            self.serve_clients();
            let is_paused = self.steering.is_paused();
            if stop.is_raised() && !self.stop_ordered {
                self.stop();
            } else if !self.stop_ordered && self.order_checkpoint_if_due(stop.take_request()) {
            } else if !self.stop_ordered && !is_paused && self.checkpoints.copies.take_due() {
                self.order(Action::Copy);
            } else if let Some(due) = self.balance.due().filter(|_| !self.stop_ordered) {
                self.redecompose(&due);
            }
            if self.ready.len() == self.workers {
                self.recut()?;
            }
            if let Some(ended) = self.checkpoints.poll() {
                self.show_checkpoint(ended);
            }
            if let Some(warning) = self.checkpoints.complain() {
                self.warn(&warning);
            }
            self.show();
            if !heard {
                std::thread::sleep(NAP);
            }
        }
        Ok(())
    }

    /// Writes the timeline, if requested. After the loss of a worker the others also end, and
    /// send their recordings.
    fn write_trace(&mut self) -> Result<(), RunError> {
        let Some(mut trace) = self.trace.take() else { return Ok(()) };
        let began = Instant::now();
        for worker in 0..self.workers {
            while !trace.has(worker) && began.elapsed() < LAST_WORDS {
                match poll_message(self.comm, worker + 1, Tag::Report) {
                    Ok(Some(ToMaster::Recording(recording))) => {
                        trace.add_recording(worker, *recording)
                    }
                    Ok(Some(_)) => {} // late messages of the run
                    Ok(None) => std::thread::sleep(NAP),
                    Err(_) => break,
                }
            }
        }
        let path = trace.path.clone();
        let said =
            trace.write(self.comm.one_clock()).map_err(|error| RunError::Trace { path, error })?;
        self.announce(&format!("trace: {said}"));
        Ok(())
    }

    /// Returns the state of the master for a checkpoint.
    fn state(&self) -> MasterState {
        // A new field is an error here: state has to be added, all else to the last lists.
        let Self {
            history,
            series,
            balance,
            warnings,
            restarts,
            wall_before,
            began,
            out,
            steering,
            // From the job.
            model,
            outline: _,
            // Its rows are on disk: `lengths`.
            of_workers: _,
            // They belong to this process.
            comm: _,
            workers: _,
            tree: _,
            progress: _,
            orders: _,
            stop_ordered: _,
            ready: _,
            ready_since: _,
            trace: _,
            checkpoints: _,
            viewing: _,
            from: _,
            // Complete when the last worker has captured its state.
            pieces: _,
            // They belong to a run that ends.
            trouble: _,
            closings: _,
            states: _,
        } = self;
        let (settings, limits) = (&model.settings, &model.decomposition);
        MasterState {
            course: history.course.clone(),
            lengths: Tables::present(out),
            steps: series.steps().to_vec(),
            accounts: balance.accounts(),
            wall_s: wall_before + began.elapsed().as_secs_f64(),
            warnings: warnings.clone(),
            restarts: restarts.clone(),
            history_interval: settings.history_interval,
            field_times: settings.field_times.clone(),
            end_time: settings.end_time,
            output: settings.output.clone(),
            imbalance: limits.imbalance,
            low_every_at_least: limits.low_every_at_least,
            steering: steering.done_without_stop(),
            planned: settings.planned.clone(),
        }
    }

    /// Returns the wall time of the run so far, with that before the checkpoint [s].
    fn wall(&self) -> f64 {
        self.wall_before + self.began.elapsed().as_secs_f64()
    }

    /// Reports the end of a checkpoint.
    fn show_checkpoint(&mut self, ended: Result<String, String>) {
        self.answer_checkpoint(&ended);
        match ended {
            Ok(message) => {
                tracing::info!(message);
                self.announce(&message);
            }
            Err(warning) => self.warn(&warning),
        }
    }

    /// Reports a warning.
    fn warn(&mut self, warning: &str) {
        tracing::warn!(warning);
        self.announce(&format!("warning: {warning}"));
    }

    fn order(&mut self, action: Action) {
        self.orders += 1;
        tracing::debug!(number = self.orders, action = action.name(), "order sent");
        for rank in 1..=self.workers {
            // A worker that cannot be reached has ended or is lost. The next receive finds out.
            let _ = post(
                self.comm,
                rank,
                Tag::Order,
                &ToWorker::Order { number: self.orders, action: action.clone() },
            );
        }
    }

    fn show(&mut self) {
        let last = &self.balance.last[0];
        let error = self.history.course.last.as_ref().map_or(0.0, |r| r.error);
        let (pairs, imbalance) = (self.balance.pairs(), self.balance.mean_imbalance());
        self.progress.show(&RunState {
            cycle: last.cycle,
            time: last.time,
            dt: last.dt,
            error,
            pairs,
            imbalance,
        });
    }
}
