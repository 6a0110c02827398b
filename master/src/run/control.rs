//! The run on one page: distribute the model, receive reports, decide, write results, stop.

mod watch;

use crate::input::job::Model;
use crate::results::fields::Series;
use crate::results::history::{Course, Extras, History, Tables};
use crate::results::summary::{self, Outline, Restart, Status, Summary};
use crate::results::trace::Trace;
use crate::results::workers;
use crate::run::balance::{Balance, Due, Limits, URGENT};
use crate::run::checkpoint::find::{Resumption, tidy};
use crate::run::checkpoint::manifest::Stamp;
use crate::run::checkpoint::{Checkpoints, MasterState};
use crate::run::decompose::{Loads, Workers, bisect, drifted};
use crate::run::progress::{Progress, RunState};
use crate::run::stop::StopFlag;
use crumple_proto::boxes::CutTree;
use crumple_proto::checkpoint::Captured;
use crumple_proto::disk;
use crumple_proto::ids::NodeId;
use crumple_proto::message::{Action, ToMaster, ToWorker};
use crumple_proto::partition::{NodeRecord, Settings};
use crumple_proto::report::{Failure, FinalReport};
use crumple_proto::transport::{RankLost, Tag, Transport};
use crumple_proto::wire::{await_message, poll_message, post};
use crumple_worker::vtu;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

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
    /// The trace cannot be written.
    #[error("{path}: {error}; choose another file with --trace", path = .path.display())]
    Trace {
        /// File of the trace.
        path: PathBuf,
        /// Error of the operating system.
        error: std::io::Error,
    },
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
    /// The checkpoint from which the run continues, until the workers have it.
    from: Option<Resumption>,
    /// Continuations so far.
    restarts: Vec<Restart>,
    /// Wall time before the checkpoint [s].
    wall_before: f64,
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
    origin: Origin,
    (quiet, stop): (bool, &StopFlag),
) -> Result<Summary, RunError> {
    let patience = model.job.checkpoint.patience().expect("the job is checked when it is read");
    disk::set_patience(patience);
    let new = || Control::new(model, comm, results, origin, quiet);
    let mut control = disk::watched(results.out, new)?;
    let ended = control.supervise(stop);
    // Also after a loss: a checkpoint may lack its manifest only.
    for finished in control.checkpoints.wait() {
        control.show_checkpoint(finished);
    }
    let traced = control.write_trace();
    ended?;
    control.progress.finish();
    let summary = control.finish()?;
    traced?; // after the messages of the run itself
    Ok(summary)
}

impl<'a> Control<'a> {
    fn new(
        model: &'a mut Model,
        comm: &'a mut dyn Transport,
        Results { out, trace }: Results<'_>,
        Origin { stamp, from }: Origin,
        quiet: bool,
    ) -> Result<Self, RunError> {
        let workers = comm.size() - 1;
        let (job, settings) = (&model.job, &model.settings);
        let fields = out.join("fields");
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |error| RunError::Output { path, error }
        };
        std::fs::create_dir_all(out).map_err(failed(out))?;
        let deleted = &job.restart.delete;
        let elements = model.mesh.elements.iter().filter(|e| !deleted.contains(&e.part)).count();
        let mut checkpoints = Checkpoints::new(out, &job.checkpoint, workers, elements);
        checkpoints.set_stamp(stamp);
        let mut series = Series::new(&fields);
        let known = from.as_ref().map(|(from, _)| from.master.clone());
        match &from {
            Some((from, _)) => {
                tidy(checkpoints.dir(), Some(&from.folder));
                checkpoints.newest =
                    Some((from.manifest.captured.cycle, from.manifest.captured.time));
                series.restore(&from.master.steps).map_err(failed(&fields))?;
                remove_file(&out.join("summary.json"))?; // of the run before
            }
            None => {
                tidy(checkpoints.dir(), None);
                if fields.exists() {
                    std::fs::remove_dir_all(&fields).map_err(failed(&fields))?; // of an earlier run
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
            tree: CutTree::single(),
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

    /// Distributes the model and supervises the run until all workers have sent their final
    /// reports.
    fn supervise(&mut self, stop: &StopFlag) -> Result<(), RunError> {
        match self.from.take() {
            None => self.deal_out()?,
            Some(from) => self.continue_from(&from)?,
        }
        while self.closings.iter().any(Option::is_none) {
            let heard = self.listen()?;
            if stop.is_raised() && !self.stop_ordered {
                self.stop_ordered = true;
                self.progress
                    .println("stopping: the workers finish their cycle and write their state");
                self.order(Action::Stop);
            } else if !self.stop_ordered && self.checkpoints.take_due(stop.take_request()) {
                self.order(Action::Checkpoint);
            } else if !self.stop_ordered && self.checkpoints.copies.take_due() {
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
        self.progress.println(&format!("trace: {said}"));
        Ok(())
    }

    /// Sends the checkpoint to the workers, which read it, and computes boxes with them.
    fn continue_from(&mut self, from: &Resumption) -> Result<(), RunError> {
        let captured = &from.manifest.captured;
        for why in &from.refused {
            self.warn(&format!("a newer checkpoint cannot be used: {why}"));
        }
        tracing::info!(cycle = captured.cycle, time = captured.time, "run continues");
        self.progress.println(&format!(
            "continues from T={:.4e}, cycle {}: {}",
            captured.time,
            captured.cycle,
            from.folder.display()
        ));
        self.model.forget_mesh();
        let resume = ToWorker::Resume {
            settings: Box::new(self.settings()),
            folder: from.folder.to_string_lossy().into_owned(),
            common: from.manifest.common.clone(),
            pieces: from.manifest.pieces.clone(),
            changes: from.changes.clone(),
            trace: self.trace.is_some(),
        };
        for rank in 1..=self.workers {
            post(self.comm, rank, Tag::Order, &resume)?;
        }
        let mut refused = None;
        for rank in 1..=self.workers {
            if let ToMaster::Trouble(trouble) = await_message(self.comm, rank, Tag::Report)? {
                refused = Some(trouble.why);
            }
        }
        let Some(why) = refused else { return self.recut() };
        for rank in 1..=self.workers {
            let _ = post(self.comm, rank, Tag::Order, &ToWorker::Quit); // it may have ended
        }
        Err(RunError::Unusable(why))
    }

    /// Returns the settings of the workers.
    fn settings(&self) -> Settings {
        let mut settings = self.model.settings.clone();
        settings.field_dir = self.series.dir().to_string_lossy().into_owned();
        settings.checkpoint.dir = self.checkpoints.dir().to_string_lossy().into_owned();
        settings
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
            from: _,
            // Complete when the last worker has captured its state.
            pieces: _,
            // They belong to a run that ends.
            trouble: _,
            closings: _,
            states: _,
        } = self;
        MasterState {
            course: history.course.clone(),
            lengths: Tables::present(out),
            steps: series.steps().to_vec(),
            accounts: balance.accounts(),
            wall_s: wall_before + began.elapsed().as_secs_f64(),
            warned: [*penetration_warned, *energy_warned, *step_warned],
            restarts: restarts.clone(),
            history_interval: model.settings.history_interval,
            field_times: model.settings.field_times.clone(),
        }
    }

    /// Returns the wall time of the run so far, with that before the checkpoint [s].
    fn wall(&self) -> f64 {
        self.wall_before + self.began.elapsed().as_secs_f64()
    }

    /// Cuts space into boxes and sends to every worker the elements and nodes of its box.
    fn deal_out(&mut self) -> Result<(), RankLost> {
        let (elements, nodes) = self.model.records();
        let of_id: HashMap<NodeId, &NodeRecord> = nodes.iter().map(|n| (n.id, n)).collect();
        let centre = |e: &crumple_proto::partition::ElementRecord| {
            let corners = &e.nodes[..e.shape.corners()];
            std::array::from_fn(|c| {
                corners.iter().map(|n| of_id[n].x[c]).sum::<f64>() / corners.len() as f64
            })
        };
        let centres: Vec<[f64; 3]> = elements.iter().map(centre).collect();
        let load = |e| self.model.settings.load(e);
        let loads = centres.iter().copied().zip(elements.iter().map(load)).collect();
        self.tree = bisect(&mut Loads(loads), self.workers)?;
        let mut shares = vec![Vec::new(); self.workers];
        for (e, &c) in elements.iter().zip(&centres) {
            shares[self.tree.worker_of(c)].push(*e);
        }
        let settings = self.settings();
        for (worker, elements) in shares.into_iter().enumerate() {
            let mut ids: Vec<NodeId> = elements.iter().flat_map(|e| e.nodes).collect();
            ids.sort_unstable();
            ids.dedup();
            tracing::info!(worker, elements = elements.len(), nodes = ids.len(), "partition sent");
            let nodes = ids.iter().map(|id| *of_id[id]).collect();
            let trace = self.trace.is_some();
            let (settings, tree) = (Box::new(settings.clone()), self.tree.clone());
            let start = ToWorker::Start { settings, tree, elements, nodes, trace };
            post(self.comm, worker + 1, Tag::Order, &start)?;
        }
        self.model.forget_mesh();
        Ok(())
    }

    /// Receives all messages that have arrived from workers. Returns true if there was one.
    fn listen(&mut self) -> Result<bool, RunError> {
        let mut heard = false;
        for worker in 0..self.workers {
            while self.closings[worker].is_none() {
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
            }
            ToMaster::Fields { index, time } => {
                let pieces = self.pieces.entry(index).or_default();
                *pieces += 1;
                if *pieces == self.workers {
                    let path = self.series.dir().to_owned();
                    self.series
                        .add(index, time, self.workers)
                        .map_err(|error| RunError::Output { path, error })?;
                    tracing::info!(index, time, "fields written");
                }
            }
            ToMaster::Warning(warning) => {
                tracing::warn!(worker, warning);
                self.progress.println(&format!("warning: worker {worker}: {warning}"));
            }
            ToMaster::Captured(captured) => {
                if self.checkpoints.add_captured(captured) {
                    self.finish_reports()?;
                    let state = self.state();
                    self.checkpoints.add_master(captured.cycle, state);
                }
            }
            ToMaster::Copied(captured, seconds) => {
                if self.checkpoints.copies.add(seconds) {
                    self.finish_reports()?;
                    let state = self.state();
                    self.checkpoints.copies.set(captured, state);
                }
            }
            ToMaster::Saved(saved) => {
                self.checkpoints.add_saved(saved);
            }
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
        match ended {
            Ok(message) => {
                tracing::info!(message);
                self.progress.println(&message);
            }
            Err(warning) => self.warn(&warning),
        }
    }

    /// Reports a warning.
    fn warn(&mut self, warning: &str) {
        tracing::warn!(warning);
        self.progress.println(&format!("warning: {warning}"));
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

    fn redecompose(&mut self, due: &Due) {
        let last = self.balance.last.iter().max_by_key(|r| r.cycle).cloned().unwrap_or_default();
        let (kind, why) = match due {
            Due::High { why } => ("high", why),
            Due::Low { why } => ("low", why),
        };
        tracing::info!(kind, why, cycle = last.cycle, time = last.time, "redecomposition ordered");
        match due {
            Due::High { .. } => {
                let drift: Vec<[f64; 3]> = self.balance.last.iter().map(|r| r.drift).collect();
                let elements: Vec<u64> = self.balance.last.iter().map(|r| r.elements).collect();
                self.tree = drifted(&self.tree, &drift, &elements);
                self.order(Action::Renew(self.tree.clone()));
            }
            Due::Low { .. } => self.order(Action::Recut),
        }
        self.balance.ordered(self.orders, due);
        if self.balance.low + self.balance.high <= MOST_SAID || matches!(due, Due::Low { .. }) {
            self.progress.println(&format!(
                "{kind} redecomposition at T={:.4e}, cycle {}: {why}",
                last.time, last.cycle
            ));
        }
    }

    /// Repartitions while all workers wait: measures the load on the workers, computes new boxes,
    /// and lets the workers migrate elements.
    fn recut(&mut self) -> Result<(), RunError> {
        let pair_s = self.balance.pair_seconds();
        let mut load = Workers { comm: self.comm, pair_s, aside: Vec::new() };
        self.tree = bisect(&mut load, self.workers)?;
        let aside = load.aside;
        for rank in 1..=self.workers {
            post(self.comm, rank, Tag::Order, &ToWorker::Cuts(self.tree.clone()))?;
        }
        self.ready.clear();
        if let Some(since) = self.ready_since.take() {
            // Migration takes about as long as the measurement and the new boxes.
            self.balance.low_took(2.0 * since.elapsed().as_secs_f64());
        }
        aside.into_iter().try_for_each(|(worker, message)| self.receive(worker, message))
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

    /// Writes the summary after all final reports have arrived.
    fn finish(mut self) -> Result<Summary, RunError> {
        self.finish_reports()?;
        let wall_s = self.wall();
        let closings: Vec<FinalReport> = self.closings.into_iter().flatten().collect();
        let end = closings[0].clone();
        let (status, reason) = match &self.trouble {
            Some(t) => {
                (Status::Failed, format!("cycle {}, time {:.6e}: {}", t.cycle, t.time, t.why))
            }
            None if end.stopped => (Status::Stopped, "stopped by the user".into()),
            None if end.time < self.model.settings.end_time * (1.0 - 1e-9) => {
                (Status::Completed, "max_cycles".into())
            }
            None => (Status::Completed, "end_time".into()),
        };
        let count: usize = self.outline.elements.values().sum();
        let mean = |f: fn(&FinalReport) -> u64| {
            closings.iter().map(f).sum::<u64>() as f64 / closings.len() as f64
        };
        let cycles = end.cycles.max(1) as f64;
        let (first, last) = (
            self.history.course.first.unwrap_or_default().sum,
            self.history.course.last.unwrap_or_default(),
        );
        let (e, i) = (last.sum.energies, first.energies);
        let summary = Summary {
            title: self.model.job.title.clone(),
            units: self.model.job.units.clone(),
            status,
            reason,
            end_time: end.time,
            cycles: end.cycles,
            nodes: self.outline.nodes,
            workers: self.workers,
            transport: self.comm.name().into(),
            wall_s,
            grind_ns: 1e9 * wall_s * self.workers as f64 / (count as f64 * cycles),
            phase_s: summary::phases(&closings),
            cpu_s: summary::Cpu {
                total: self.balance.total_s,
                critical_path: self.balance.critical_s,
                renewal: self.balance.renewal_s.iter().copied().fold(0.0, f64::max),
                messages_per_cycle: mean(|c| c.messages) / cycles,
                bytes_per_cycle: mean(|c| c.bytes) / cycles,
            },
            energy: summary::Energy {
                kinetic: e.kinetic,
                internal: e.internal,
                contact: e.contact,
                friction: e.friction,
                contact_starting: e.starting,
                wall: e.wall,
                hourglass: e.hourglass,
                external: e.external,
                total_initial: i.kinetic + i.internal + i.hourglass,
                error: last.error,
                error_max: self.history.course.worst_error,
                contact_created: self.history.course.worst_created,
            },
            momentum: summary::Momentum {
                start: first.momentum,
                end: last.sum.momentum,
                wall_impulse: std::array::from_fn(|c| {
                    last.sum.wall_impulse.iter().map(|p| p[c]).sum()
                }),
            },
            dt: summary::Steps { first: end.dt[0], min: end.dt[1], last: end.dt[2] },
            redecompositions: summary::Redecompositions {
                low: self.balance.low,
                high: self.balance.high,
                erosion: end.erosions,
            },
            thresholds: summary::Thresholds {
                margin: URGENT,
                imbalance: self.model.job.parallel.imbalance,
            },
            classes: summary::classes(&closings),
            imbalance: summary::MeanMax {
                mean: self.balance.mean_imbalance(),
                max: self.balance.worst,
            },
            contact: summary::ContactSummary {
                pairs_max: self.history.course.pairs,
                penetration_max: self.history.course.penetration,
                searches: mean(|c| c.searches),
                sweeps_per_cycle: mean(|c| c.sweeps) / cycles,
                accelerated_steps: closings.iter().map(|c| c.unsettled[0]).max().unwrap_or(0),
                unsettled_steps: closings.iter().map(|c| c.unsettled[1]).max().unwrap_or(0),
                capped_per_cycle: closings.iter().map(|c| c.capped).sum::<u64>() as f64 / cycles,
            },
            unsupported: self.model.unsupported.clone(),
            parts: summary::parts(
                &self.model.job,
                &self.outline,
                &self.model.settings.parts,
                &closings,
            ),
            walls: self.model.job.wall.clone(),
            elements: self.outline.elements,
            restarts: self.restarts,
            checkpoints: self.checkpoints.summary,
            state_digest: summary::state_digest(&mut self.states),
        };
        let path = self.out.join("summary.json");
        let text = serde_json::to_string_pretty(&summary).unwrap_or_default() + "\n";
        vtu::write_whole(&path, |out| out.write_all(text.as_bytes()))
            .map_err(|error| RunError::Output { path, error })?;
        Ok(summary)
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
/// Number of high redecompositions that are printed. All are in `log.jsonl`.
const MOST_SAID: u64 = 10;
