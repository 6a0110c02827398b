//! The run on one page: distribute the model, receive reports, decide, write results, stop.

mod distribute;
mod finish;
mod steer;
mod view;
mod watch;

use crate::input::job::Model;
use crate::results::fields::{self, Series};
use crate::results::history::{Course, Extras, History};
use crate::results::summary::{Outline, Restart, Summary};
use crate::results::table::Tables;
use crate::results::trace::Trace;
use crate::results::workers;
use crate::run::balance::{Balance, Limits};
use crate::run::checkpoint::find::{Resumption, tidy};
use crate::run::checkpoint::manifest::Stamp;
use crate::run::checkpoint::{Checkpoints, MasterState};
use crate::run::progress::{Progress, RunState};
use crate::run::service::Desk;
use crate::run::service::signals::StopFlag;
use crumple_proto::boxes::CutTree;
use crumple_proto::checkpoint::Captured;
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

/// Most messages that are taken from a worker before signals and clients have their turn: a run may
/// write rows faster than the master can take them.
const MOST_MESSAGES: usize = 100;
/// Sleep of the master when there is nothing to do, so that it does not occupy a core that
/// workers need.
const NAP: Duration = Duration::from_micros(500);

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
    outline: Outline,
    comm: &'a mut dyn Transport,
    workers: usize,
    tree: CutTree,
    balance: Balance,
    history: History,
    /// `workers.csv`.
    of_workers: workers::Workers,
    series: Series,
    progress: Progress,
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
    /// True after the warning about a deep penetration, and after the warning about energy created
    /// by contact.
    penetration_warned: bool,
    energy_warned: bool,
    /// True after the warning that contact shortens the step.
    step_warned: bool,
    closings: Vec<Option<FinalReport>>,
    trace: Option<Trace>,
    states: Vec<NodeRecord>,
    checkpoints: Checkpoints,
    /// The checkpoint from which the run continues, until the user knows.
    from: Option<Resumption>,
    /// Continuations so far.
    restarts: Vec<Restart>,
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
    let Guidance { quiet, stop, desk } = guidance;
    // The files of the run are changed only when all workers have the state of the checkpoint.
    let tree = match &mut origin.from {
        None => CutTree::single(),
        Some((from, _)) => distribute::restore(model, comm, results, from)?,
    };
    let new = || Control::new(model, comm, results, (origin, tree), (quiet, desk));
    let mut control = disk::watched(results.out, new)?;
    let ended = control.conclude(stop);
    control.viewing.end();
    match &ended {
        Ok(summary) => control.steering.end(summary.status.exit_code(), &summary.reason),
        Err(error) => control.steering.end(error.exit_code(), &error.to_string()),
    }
    ended
}

/// How a run is shown and who may steer it.
pub struct Guidance<'a> {
    /// True if only errors are printed.
    pub quiet: bool,
    /// Requests by signals.
    pub stop: &'a StopFlag,
    /// Requests by clients; without a socket `None`.
    pub desk: Option<Desk>,
}

impl<'a> Guidance<'a> {
    /// Returns that of a quiet run without clients.
    pub fn quiet(stop: &'a StopFlag) -> Self {
        Self { quiet: true, stop, desk: None }
    }
}
impl<'a> Control<'a> {
    fn new(
        model: &'a mut Model,
        comm: &'a mut dyn Transport,
        Results { out, trace }: Results<'_>,
        (Origin { stamp, mut from }, tree): (Origin, CutTree),
        (quiet, desk): (bool, Option<Desk>),
    ) -> Result<Self, RunError> {
        let workers = comm.size() - 1;
        let (job, settings) = (&model.job, &model.settings);
        let folder = out.join(fields::DIR);
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |error| RunError::Output { path, error }
        };
        std::fs::create_dir_all(out).map_err(failed(out))?;
        let deleted = &job.restart.delete;
        let elements = model.mesh.elements.iter().filter(|e| !deleted.contains(&e.part)).count();
        let mut checkpoints = Checkpoints::new(out, &job.checkpoint, workers, elements);
        checkpoints.set_stamp(stamp);
        let mut series = Series::new(&folder);
        if let Some((from, _)) = &mut from {
            from.begin_lost_histories();
        }
        let known = from.as_ref().map(|(from, _)| from.master.clone());
        match &mut from {
            Some((from, _)) => {
                from.removed = tidy(checkpoints.dir(), Some(&from.folder));
                checkpoints.newest =
                    Some((from.manifest.captured.cycle, from.manifest.captured.time));
                series.restore(&from.master.steps).map_err(failed(&folder))?;
                remove_file(&out.join("summary.json"))?; // of the run before
            }
            None => {
                tidy(checkpoints.dir(), None);
                if folder.exists() {
                    std::fs::remove_dir_all(&folder).map_err(failed(&folder))?; // of an earlier run
                }
            }
        }
        let lengths = known.as_ref().map(|known| &known.lengths);
        let course = known.as_ref().map_or_else(Course::default, |known| known.course.clone());
        let history = History::new(Tables { dir: out, lengths }, workers, model, course)
            .map_err(|(path, error)| RunError::Output { path, error })?;
        let of_workers = workers::Workers::new(Tables { dir: out, lengths }, workers, model)
            .map_err(|(path, error)| RunError::Output { path, error })?;
        let trace = trace.map(|path| {
            let failed = |error| RunError::Trace { path: path.to_owned(), error };
            Trace::new(path, workers).map_err(failed)
        });
        let trace = trace.transpose()?;
        let limits = Limits {
            imbalance: job.parallel.imbalance,
            low_every_at_least: job.parallel.low_every_at_least,
            forced: job.parallel.force_every > 0,
        };
        let known = known.unwrap_or_default();
        let mut balance = Balance::new(workers, limits);
        if from.is_some() {
            balance.restore(&known.accounts);
        }
        let mut restarts = known.restarts;
        let from = from.map(|(from, changes)| {
            let Captured { cycle, time, .. } = from.manifest.captured;
            let transport = comm.name().into();
            restarts.push(Restart { cycle, time, workers, transport, changes });
            from
        });
        let [penetration_warned, energy_warned, step_warned] = known.warned;
        Ok(Self {
            began: Instant::now(),
            tree,
            balance,
            series,
            progress: Progress::new(settings.end_time, quiet),
            out: out.to_owned(),
            orders: 0,
            stop_ordered: false,
            ready: Vec::new(),
            ready_since: None,
            pieces: BTreeMap::new(),
            trouble: None,
            penetration_warned,
            energy_warned,
            step_warned,
            checkpoints,
            from,
            restarts,
            wall_before: known.wall_s,
            steering: Steering::new(desk, known.steering),
            viewing: Viewing::new(out),
            closings: vec![None; workers],
            trace,
            states: Vec::new(),
            outline: Outline::from_mesh(&model.mesh),
            model,
            comm,
            workers,
            history,
            of_workers,
        })
    }

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
            None => self.deal_out()?,
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
            penetration_warned,
            energy_warned,
            step_warned,
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
        let (settings, parallel) = (&model.settings, &model.job.parallel);
        MasterState {
            course: history.course.clone(),
            lengths: Tables::present(out),
            steps: series.steps().to_vec(),
            accounts: balance.accounts(),
            wall_s: wall_before + began.elapsed().as_secs_f64(),
            warned: [*penetration_warned, *energy_warned, *step_warned],
            restarts: restarts.clone(),
            history_interval: settings.history_interval,
            field_times: settings.field_times.clone(),
            end_time: settings.end_time,
            output: settings.output.clone(),
            imbalance: parallel.imbalance,
            low_every_at_least: parallel.low_every_at_least,
            steering: steering.done_without_stop(),
            planned: settings.planned.clone(),
        }
    }

    /// Returns the wall time of the run so far, with that before the checkpoint [s].
    fn wall(&self) -> f64 {
        self.wall_before + self.began.elapsed().as_secs_f64()
    }

    /// Receives messages that have arrived from workers. Returns true if there was one.
    fn listen(&mut self) -> Result<bool, RunError> {
        let mut heard = false;
        for worker in 0..self.workers {
            for _ in 0..MOST_MESSAGES {
                if self.closings[worker].is_some() {
                    break;
                }
                let Some(message) = poll_message(self.comm, worker + 1, Tag::Report)? else {
                    break;
                };
                heard = true;
                self.receive(worker, message)?;
            }
        }
        Ok(heard)
    }

    fn receive(&mut self, worker: usize, message: ToMaster) -> Result<(), RunError> {
        match message {
            ToMaster::Report(report) => {
                let _span = tracing::trace_span!("report", worker, cycle = report.cycle).entered();
                let imbalance = self.balance.imbalance();
                let path = self.out.join(workers::FILE);
                disk::watched(&path, || self.of_workers.add(worker, &report, imbalance))
                    .map_err(|e| self.unwritten(e))?;
                self.balance.add_report(worker, *report);
            }
            ToMaster::History(part) => {
                let b = &self.balance;
                let wall = self.wall();
                let extras = Extras {
                    wall,
                    cpu_total: b.total_s,
                    cpu_critical: b.critical_s,
                    cpu_renewal: b.renewal_s.iter().copied().fold(0.0, f64::max),
                    low: b.low,
                    high: b.high,
                    erosions: b.erosions(),
                    classes: b.classes(),
                };
                let path = self.out.join("history.csv");
                disk::watched(&path, || self.history.add_part(*part, extras))
                    .map_err(|e| RunError::Output { path, error: e.into() })?;
                self.watch_energy();
                self.watch_contact();
                self.watch_work();
                self.watch_files();
            }
            ToMaster::Fields { index, time } => {
                let pieces = self.pieces.entry(index).or_default();
                *pieces += 1;
                if *pieces == self.workers {
                    let _span = tracing::debug_span!("output", index, time).entered();
                    let path = self.series.dir().to_owned();
                    self.series
                        .add(index, time, self.workers)
                        .map_err(|error| RunError::Output { path, error })?;
                    tracing::info!(index, time, "fields written");
                }
            }
            ToMaster::Warning(warning) => {
                tracing::warn!(worker, warning);
                self.announce(&format!("warning: worker {worker}: {warning}"));
            }
            ToMaster::Captured(captured, repeat) => {
                if self.checkpoints.add_captured(captured, repeat) {
                    let cycle = captured.cycle;
                    let _span = tracing::debug_span!("checkpoint", cycle).entered();
                    self.finish_reports()?;
                    let state = self.state();
                    self.checkpoints.add_master([cycle, repeat], state);
                    self.take_deferred();
                }
            }
            ToMaster::Copied(captured, repeat, seconds) => {
                if self.checkpoints.copies.add(seconds) {
                    self.finish_reports()?;
                    let state = self.state();
                    self.checkpoints.copies.set(captured, repeat, state);
                    self.take_deferred();
                }
            }
            ToMaster::Saved(saved) => {
                self.checkpoints.add_saved(saved);
            }
            ToMaster::Viewed(viewed) => self.take_viewed(viewed),
            ToMaster::Steered(number, at) => self.take_steered(number, at),
            ToMaster::Ready => {
                self.ready.push(worker);
                self.ready_since.get_or_insert_with(Instant::now);
            }
            ToMaster::Trouble(trouble) => {
                tracing::error!(worker, ?trouble, "trouble");
                self.trouble = Some(trouble);
            }
            ToMaster::Recording(recording) => {
                if let Some(trace) = &mut self.trace {
                    trace.add_recording(worker, *recording);
                }
            }
            ToMaster::Closing(closing, states) => {
                self.closings[worker] = Some(*closing);
                self.states.extend(states);
            }
            ToMaster::Extents(_) | ToMaster::Histograms(_) => {
                tracing::warn!(worker, "unexpected answer: no request is pending")
            }
        }
        Ok(())
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

    /// Writes the rows of `workers.csv` that wait.
    fn finish_reports(&mut self) -> Result<(), RunError> {
        let (imbalance, path) = (self.balance.imbalance(), self.out.join(workers::FILE));
        disk::watched(&path, || self.of_workers.finish(imbalance)).map_err(|e| self.unwritten(e))
    }

    /// Returns the error for a failure to write `workers.csv`.
    fn unwritten(&self, error: csv::Error) -> RunError {
        RunError::Output { path: self.out.join(workers::FILE), error: error.into() }
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

/// Removes a file if it exists.
fn remove_file(path: &Path) -> Result<(), RunError> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(RunError::Output { path: path.to_owned(), error })
        }
        _ => Ok(()),
    }
}

/// Time for which the master waits for recordings after the loss of a worker.
const LAST_WORDS: Duration = Duration::from_secs(2);
