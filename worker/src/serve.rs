//! One worker: takes orders, runs the engine, sends reports.

mod capture;
mod steering;
mod view;
mod warnings;

use crate::checkpoint::{
    self,
    writer::{CheckpointWriter, Task},
};
use crate::engine::{Engine, StepConsensus, StepFailure};
use crate::fem::blocks::Blocks;
use crate::parallel::partition::PartitionData;
use crate::time::Clock;
use crate::timer::busy;
use crate::{output, step::step};
use crumple_proto::boxes::{Aabb, CutTree};
use crumple_proto::checkpoint::FileRecord;
use crumple_proto::disk;
use crumple_proto::message::{Action, Changes, ToMaster, ToWorker};
use crumple_proto::partition::Settings;
use crumple_proto::report::Phase;
use crumple_proto::report::{
    Displacement, Failure, FinalReport, PHASES, PhaseSeconds, StepLoads, StepReport, add_to_bin,
};
use crumple_proto::steering::Steer;
use crumple_proto::trace::{Event, OrderKind};
use crumple_proto::transport::{RankLost, Tag, Traffic, Transport};
use crumple_proto::wire::{await_message, poll_message, post};
use std::collections::VecDeque;
use std::path::Path;
use std::time::Duration;

/// Number of cycles between two reports to the master.
const REPORT_EVERY: u64 = crate::timer::SAMPLE_EVERY;
/// Number of cycles between two checks for edges that cross surfaces. The interval is long, so
/// that the checks cost nothing; the last check is at the end of the run.
const CROSSINGS_EVERY: u64 = 500;

/// A running worker.
pub struct RunningWorker {
    engine: Engine,
    /// Orders that have arrived, with their numbers. All workers carry out an order before the
    /// same cycle.
    orders: VecDeque<(u64, Action)>,
    done: u64,
    report: StepReport,
    cpu_before: Duration,
    /// Smoothed CPU time of a recent cycle, by phase [s], and the number of samples in it, since
    /// the boxes were cut.
    cost: PhaseSeconds,
    samples: u32,
    /// Messages and bytes sent until the last report.
    sent: Traffic,
    stopped: bool,
    /// True after the row of the end of the run.
    last_row_sent: bool,
    /// True after a warning that an edge crosses a surface.
    crossed: bool,
    /// Number of deleted elements named in warnings.
    named: u64,
    /// True if a checkpoint is ordered, and if a copy in memory is.
    checkpoint_due: bool,
    copy_due: bool,
    /// Cycle of the last field files.
    fields_cycle: Option<u64>,
    /// Folder of the picture that is due.
    view_due: Option<String>,
    /// Orders of the user, with their numbers, until an outer step begins.
    steering: VecDeque<(u64, Steer)>,
    paused: bool,
    /// Cycle of the last capture, and number of captures in it.
    captures: (u64, u64),
    /// The last copy, if it is newer than the last checkpoint; all workers have it of one cycle.
    kept: Option<Task>,
    /// True if the run has failed.
    failed: bool,
    writer: CheckpointWriter,
    /// Messages and bytes sent before the checkpoint from which the run continues.
    sent_before: [u64; 2],
}

/// Smallest weight of the latest report in the smoothed cost. The first reports after new boxes
/// have equal weights.
const NEWEST: f64 = 0.05;

/// Runs a worker from the first order to the last report.
///
/// # Errors
/// Another rank is gone.
pub fn serve(comm: &mut dyn Transport) -> Result<(), RankLost> {
    let (mut worker, trace) = match await_message(comm, 0, Tag::Order)? {
        ToWorker::Start { settings, tree, elements, nodes, trace } => {
            let elements = elements.into_iter().map(|e| (e, Vec::new())).collect();
            let share = PartitionData { elements, nodes, ..PartitionData::default() };
            (RunningWorker::new(Engine::new(comm, *settings, tree, share)?), trace)
        }
        ToWorker::Resume { settings, folder, common, pieces, changes, trace } => {
            let from = (Path::new(&folder), &common, &pieces[..]);
            let resumed = resume(comm, *settings, from, &changes)?;
            let Some(worker) = resumed else { return Ok(()) }; // the master reports why
            (worker, trace)
        }
        _ => return Ok(()), // the job is invalid; the master reports why
    };
    let Clock { cycle, time, .. } = worker.engine.clock;
    let _run = tracing::info_span!("run", rank = comm.rank()).entered();
    tracing::info!(cycle, time, elements = worker.engine.blocks.elements.len(), "worker starts");
    disk::set_patience(Duration::from_secs_f64(worker.engine.settings.checkpoint.patience));
    worker.warn_of_few_cores(comm)?;
    if trace {
        worker.engine.timer.record(comm)?;
        worker.engine.record_classes();
    }
    let ran = worker.run(comm);
    if ran.is_err() {
        worker.send_recording(comm)?;
    }
    ran?;
    worker.finalize(comm)
}

/// Reads the files of a checkpoint and builds a worker that continues from there, with changes of
/// the model. Returns `None` if a worker cannot read its files, or the changes do not fit the
/// state.
fn resume(
    comm: &mut dyn Transport,
    settings: Settings,
    (folder, common, pieces): (&Path, &FileRecord, &[FileRecord]),
    changes: &Changes,
) -> Result<Option<RunningWorker>, RankLost> {
    let (me, workers) = (comm.rank() - 1, comm.size() - 1);
    disk::set_patience(Duration::from_secs_f64(settings.checkpoint.patience));
    let state = match checkpoint::read_state(folder, &settings, common, pieces, (me, workers)) {
        Ok(state) => state,
        Err(why) => return refuse(comm, why),
    };
    post(comm, 0, Tag::Report, &ToMaster::Ready)?;
    // The cost of contact is not known yet.
    let loads: Vec<_> =
        checkpoint::loads(&settings, &state.share).map(|(c, load)| (c, [load, 0.0])).collect();
    let tree = loop {
        let question = await_message(comm, 0, Tag::Order)?;
        match answer(comm, question, &mut |_, f| loads.iter().for_each(|&(c, l)| f(c, l)))? {
            None => {}
            Some(ToWorker::Cuts(tree)) => break tree,
            Some(_) => return Ok(None), // another worker cannot read its files
        }
    };
    let (sent, crossed, named) = (state.own.sent, state.own.crossed, state.own.named);
    let restored = (state.common, state.own);
    let mut engine = Engine::restore(comm, settings, tree, state.share, restored)?;
    if let Some(why) = engine.apply(comm, changes)? {
        return refuse(comm, why);
    }
    post(comm, 0, Tag::Report, &ToMaster::Ready)?;
    Ok(Some(RunningWorker { sent_before: sent, crossed, named, ..RunningWorker::new(engine) }))
}

/// Sends the reason why this worker cannot continue, and waits until the master has it.
fn refuse(comm: &mut dyn Transport, why: String) -> Result<Option<RunningWorker>, RankLost> {
    let trouble = Failure { elem: None, cycle: 0, time: 0.0, why };
    post(comm, 0, Tag::Report, &ToMaster::Trouble(trouble))?;
    await_message::<ToWorker>(comm, 0, Tag::Order)?; // `Quit`
    Ok(None)
}

/// Calls a function with the centre and the load of every own element. The number is the CPU time
/// of a contact pair [s].
type EachLoad<'a> = dyn FnMut(f64, &mut dyn FnMut([f64; 3], StepLoads)) + 'a;

/// Answers a request of the master for extents or histograms of the load. Returns all other
/// messages.
fn answer(
    comm: &mut dyn Transport,
    question: ToWorker,
    each_load: &mut EachLoad<'_>,
) -> Result<Option<ToWorker>, RankLost> {
    match question {
        ToWorker::Extents { tree, entries } => {
            let mut extents = vec![Aabb::EMPTY; entries.len()];
            each_load(0.0, &mut |centre, _| {
                if let Some(i) = entries.iter().position(|&e| e == tree.entry_of(centre)) {
                    extents[i].include(centre);
                }
            });
            post(comm, 0, Tag::Report, &ToMaster::Extents(extents))?;
        }
        ToWorker::Histograms { tree, of, bins, pair_s } => {
            let mut histograms = vec![vec![[0.0; 2]; bins]; of.len()];
            each_load(pair_s, &mut |centre, load| {
                let entry = tree.entry_of(centre);
                for (h, &(_, axis, lo, hi)) in
                    histograms.iter_mut().zip(&of).filter(|(_, o)| o.0 == entry)
                {
                    add_to_bin(h, (lo, hi), centre[axis], load);
                }
            });
            post(comm, 0, Tag::Report, &ToMaster::Histograms(histograms))?;
        }
        other => return Ok(Some(other)),
    }
    Ok(None)
}

impl RunningWorker {
    /// Creates a worker with an engine at time 0.
    pub fn new(engine: Engine) -> Self {
        let report = StepReport::default();
        Self {
            engine,
            orders: VecDeque::new(),
            done: 0,
            report,
            cpu_before: Duration::ZERO,
            cost: [0.0; PHASES.len()],
            samples: 0,
            sent: Traffic::default(),
            stopped: false,
            last_row_sent: false,
            crossed: false,
            named: 0,
            checkpoint_due: false,
            copy_due: false,
            fields_cycle: None,
            view_due: None,
            steering: VecDeque::new(),
            paused: false,
            captures: (0, 0),
            kept: None,
            failed: false,
            writer: CheckpointWriter::default(),
            sent_before: [0; 2],
        }
    }

    /// Computes cycles until the end of the run, an order to stop, or a failure.
    ///
    /// # Errors
    /// Another rank is gone.
    pub fn run(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        self.write_fields_if_due(comm, false)?;
        while !self.engine.clock.is_over(&self.engine.settings) {
            if self.starts_outer_step() {
                self.steer(comm)?;
                if self.stopped {
                    break;
                }
            }
            self.cpu_before = busy(comm);
            let force_every = self.engine.settings.force_every;
            if force_every > 0 && (self.engine.clock.cycle + 1).is_multiple_of(force_every) {
                self.engine.agreement.displacement =
                    Displacement { share: 1.0, ..Displacement::default() };
            }
            let before = self.engine.agreement.displacement;
            let capped = self.capped();
            let agreed = step(&mut self.engine, comm)?;
            if capped == 0 && self.capped() > 0 {
                self.warn_of_caps(comm)?;
            }
            self.warn_of_inverted(comm)?;
            if let Some(failure) = agreed.failure {
                self.report_failure(comm, failure)?;
                self.failed = true;
                break;
            }
            let cpu = self.cycle_cpu(comm);
            self.report.cpu.push(cpu.as_secs_f32());
            // Before a renewal, which forgets the contact forces of the step.
            self.write_fields_if_due(comm, false)?;
            // The workers agreed on the displacement before this cycle.
            let displaced = before.or_larger(self.engine.agreement.displacement);
            self.report.displacement = self.report.displacement.or_larger(displaced);
            if agreed.margin_used >= 1.0 {
                self.send_report(comm)?; // the master must know that all wait for its order
            }
            if self.engine.clock.is_over(&self.engine.settings) {
                self.send_rest(comm)?;
                self.send_last_row(comm)?; // a renewal also forgets the velocities before the step
            }
            let before = self.cycle_cpu(comm);
            self.take_orders(comm, &agreed)?;
            self.report.renewal_s += self.cycle_cpu(comm).saturating_sub(before).as_secs_f64();
            self.write_view_if_due(comm)?;
            if self.engine.clock.cycle.is_multiple_of(CROSSINGS_EVERY) {
                self.warn_of_crossings(comm)?;
            }
            if self.engine.clock.cycle.is_multiple_of(REPORT_EVERY) {
                self.send_report(comm)?;
            }
            // In each cycle: until the master knows of the files, they are no checkpoint.
            if let Some(saved) = self.writer.poll() {
                post(comm, 0, Tag::Report, &ToMaster::Saved(saved))?;
            }
        }
        self.send_rest(comm)
    }

    /// Sends a report of the cycles since the last one, if there are any.
    fn send_rest(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        if self.report.cpu.is_empty() { Ok(()) } else { self.send_report(comm) }
    }

    /// Sends the row of the end of the run, once.
    fn send_last_row(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        if std::mem::replace(&mut self.last_row_sent, true) {
            return Ok(());
        }
        self.engine.send_row(comm, true)
    }

    fn starts_outer_step(&self) -> bool {
        self.engine.clock.starts_outer_step(&self.engine.settings)
    }

    fn write_fields_if_due(
        &mut self,
        comm: &mut dyn Transport,
        last: bool,
    ) -> Result<(), RankLost> {
        let e = &mut self.engine;
        let is_due = match last {
            false => e.clock.are_fields_due(&e.settings),
            true => !e.settings.field_times.is_empty() && self.fields_cycle != Some(e.clock.cycle),
        };
        if !is_due {
            return Ok(());
        }
        self.fields_cycle = Some(e.clock.cycle);
        let (index, time) = (e.clock.fields, e.clock.time);
        e.clock.fields += 1;
        let _span = tracing::debug_span!("output", cycle = e.clock.cycle, time, index).entered();
        e.halo.refresh_ghosts_for_output(comm, &mut e.nodes)?;
        let several = comm.size() > 2;
        match output::write_fields(e, index, several) {
            Ok(()) => post(comm, 0, Tag::Report, &ToMaster::Fields { index, time })?,
            Err(error) => {
                let warning = format!(
                    "{}: field files of time {time:.6e} could not be written: {error}",
                    e.settings.field_dir
                );
                post(comm, 0, Tag::Report, &ToMaster::Warning(warning))?;
            }
        }
        e.timer.lap(Phase::Output);
        Ok(())
    }

    /// Sends the cause of a failure to the master: the owner of the element, or for an airbag the
    /// first worker.
    fn report_failure(
        &mut self,
        comm: &mut dyn Transport,
        failure: StepFailure,
    ) -> Result<(), RankLost> {
        let e = &self.engine;
        let (elem, why) = match failure {
            StepFailure::Element(elem) => {
                (Some(elem), e.blocks.diagnose(&e.nodes, elem, e.settings.safety, e.clock.first_dt))
            }
            StepFailure::Airbag => {
                let first = comm.rank() == 1;
                (None, e.airbags.fault().filter(|_| first).map(str::to_string))
            }
        };
        let Some(why) = why else { return Ok(()) };
        let trouble = Failure { elem, cycle: e.clock.cycle, time: e.clock.time, why };
        post(comm, 0, Tag::Report, &ToMaster::Trouble(trouble))
    }

    /// Returns the CPU time of the cycle so far, without waiting.
    fn cycle_cpu(&self, comm: &dyn Transport) -> Duration {
        busy(comm).saturating_sub(self.cpu_before)
    }

    /// Returns the CPU time by phase since the last report [s]: that of the sampled cycle, scaled
    /// so that the sum is the time of all cycles. Zero if no cycle was sampled.
    fn take_phase_cpu(&mut self) -> PhaseSeconds {
        let sample = self.engine.timer.take_sample();
        let sampled = sample.iter().sum::<f64>();
        let cycles = self.report.cpu.len() as f64;
        if sampled == 0.0 || cycles == 0.0 {
            return [0.0; PHASES.len()];
        }
        let total = self.report.cpu.iter().map(|&s| f64::from(s)).sum::<f64>();
        let all = sample.map(|s| s * total / sampled);
        self.samples += 1;
        let newest = (1.0 / f64::from(self.samples)).max(NEWEST);
        self.cost.iter_mut().zip(all).for_each(|(c, s)| *c += newest * (s / cycles - *c));
        all
    }

    fn send_report(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let _span = tracing::trace_span!("report", cycle = self.engine.clock.cycle).entered();
        let phase_cpu = self.take_phase_cpu();
        let (e, traffic) = (&self.engine, comm.traffic());
        let report = StepReport {
            cycle: e.clock.cycle,
            time: e.clock.time,
            dt: e.clock.dt,
            pairs: e.contact.as_ref().map_or(0, |c| c.owned_pairs().count() as u64),
            elements: e.blocks.elements.len() as u64,
            drift: e.drift(),
            candidates: e.contact.as_ref().map_or(0, |c| c.candidates()),
            slaves: e.contact.as_ref().map_or(0, |c| c.surface.slaves.len() as u64),
            interface: e.classes.interface,
            exterior: e.classes.exterior,
            exterior_nodes: e.classes.exterior_nodes,
            phase_cpu,
            messages: traffic.messages - self.sent.messages,
            bytes: traffic.bytes - self.sent.bytes,
            erosions: e.erosions,
            order: self.done,
            ..std::mem::take(&mut self.report)
        };
        self.sent = traffic;
        post(comm, 0, Tag::Report, &ToMaster::Report(Box::new(report)))
    }

    /// Carries out the orders that all workers have received, by the agreed number. If the ghosts
    /// no longer cover the motion, it waits for the master's next order: no node may move before
    /// it.
    fn take_orders(
        &mut self,
        comm: &mut dyn Transport,
        agreed: &StepConsensus,
    ) -> Result<(), RankLost> {
        while let Some(order) = poll_message(comm, 0, Tag::Order)? {
            self.enqueue(order);
        }
        let mut covered = agreed.margin_used < 1.0;
        while self.done < agreed.order || !covered {
            covered |= self.take_order(comm)?;
        }
        self.engine.agreement.order = self.orders.back().map_or(self.done, |o| o.0);
        Ok(())
    }

    /// Waits for the next order, if none has arrived, and carries it out. Returns true if the
    /// ghosts cover the motion after it, or if it ends the run.
    fn take_order(&mut self, comm: &mut dyn Transport) -> Result<bool, RankLost> {
        let (number, action) = loop {
            if let Some(order) = self.orders.pop_front() {
                break order;
            }
            let order = await_message(comm, 0, Tag::Order)?;
            self.enqueue(order);
        };
        let (kind, covers) = (kind(&action), action.renews_or_ends());
        self.record(Event::Begun(number, kind));
        tracing::debug!(number, ?kind, cycle = self.engine.clock.cycle, "order begins");
        self.execute(comm, number, action)?;
        self.done = number;
        if covers {
            self.report.displacement = Displacement::default(); // this motion is over
        }
        Ok(covers)
    }

    fn enqueue(&mut self, message: ToWorker) {
        if let ToWorker::Order { number, action } = message {
            self.record(Event::Arrived(number, kind(&action)));
            tracing::debug!(number, kind = ?kind(&action), "order arrives");
            self.orders.push_back((number, action));
        }
    }

    /// Records an event now, if a recorder is on.
    fn record(&mut self, event: Event) {
        self.engine.timer.recorder().iter_mut().for_each(|r| r.moment(event));
    }

    /// Sends the recording to the master, if there is one.
    fn send_recording(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        match self.engine.timer.recorder().take() {
            None => Ok(()),
            Some(r) => {
                post(comm, 0, Tag::Report, &ToMaster::Recording(Box::new(r.into_recording())))
            }
        }
    }

    fn execute(
        &mut self,
        comm: &mut dyn Transport,
        number: u64,
        action: Action,
    ) -> Result<(), RankLost> {
        let cycle = self.engine.clock.cycle;
        match action {
            Action::Steer(steer) => self.steering.push_back((number, steer)),
            Action::Fail => (self.stopped, self.failed) = (true, true),
            Action::Copy => self.copy_due = true,
            Action::Checkpoint => self.checkpoint_due = true,
            Action::View(folder) => self.view_due = Some(folder),
            Action::Renew(tree) => {
                let _span = tracing::debug_span!("redecomposition", kind = "high", cycle).entered();
                self.engine.renew(comm, tree)?;
            }
            Action::Recut => {
                let _span = tracing::debug_span!("redecomposition", kind = "low", cycle).entered();
                post(comm, 0, Tag::Report, &ToMaster::Ready)?;
                let tree = self.answer_requests(comm)?;
                self.engine.renew(comm, tree)?;
                self.samples = 0;
            }
        }
        Ok(())
    }

    /// Answers the master's requests for extents and histograms of the load until the new boxes
    /// arrive.
    fn answer_requests(&mut self, comm: &mut dyn Transport) -> Result<CutTree, RankLost> {
        let (engine, cost) = (&self.engine, &self.cost);
        let mut aside = Vec::new();
        let tree = loop {
            let question = await_message(comm, 0, Tag::Order)?;
            let mut each_load = |pair_s: f64, f: &mut dyn FnMut([f64; 3], StepLoads)| {
                engine.for_each_load(cost, pair_s, f);
            };
            match answer(comm, question, &mut each_load)? {
                None => {}
                Some(ToWorker::Cuts(tree)) => break tree,
                Some(other) => aside.push(other),
            }
        };
        aside.into_iter().for_each(|message| self.enqueue(message));
        Ok(tree)
    }

    /// Sends the last outputs, the final report and the states of owned nodes.
    ///
    /// # Errors
    /// Another rank is gone.
    pub fn finalize(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let Clock { cycle, time, .. } = self.engine.clock;
        tracing::info!(cycle, time, stopped = self.stopped, failed = self.failed, "worker ends");
        self.send_last_row(comm)?;
        self.warn_of_crossings(comm)?;
        self.write_fields_if_due(comm, true)?;
        self.send_recording(comm)?;
        self.finish_writing(comm)?;
        if let Some(kept) = self.kept.take().filter(|_| self.failed) {
            self.write(comm, kept)?;
            self.finish_writing(comm)?;
        }
        let e = &self.engine;
        let traffic = comm.traffic();
        let closing = FinalReport {
            cycles: e.clock.cycle,
            time: e.clock.time,
            phases: e.timer.seconds,
            dt: [e.clock.first_dt, e.clock.min_dt, e.clock.last_dt],
            messages: traffic.messages + self.sent_before[0],
            bytes: traffic.bytes + self.sent_before[1],
            searches: e.contact.as_ref().map_or(0, |c| c.searches),
            sweeps: e.contact.as_ref().map_or(0, |c| c.sweeps),
            unsettled: e.contact.as_ref().map_or([0; 2], |c| c.unsettled),
            capped: e.contact.as_ref().map_or(0, |c| c.capped_pairs),
            erosions: e.erosions,
            divisions: e.adaptivity.as_ref().map_or_else(Default::default, |a| a.counts(cycle)),
            classes: [e.classes.interior, e.classes.interface, e.classes.exterior],
            half_buffer: e.boxes.half_width,
            stopped: self.stopped,
            parts: output::part_records(e),
        };
        // The states need about the memory of the elements, which no code uses from here on.
        self.engine.blocks = Blocks::default();
        let e = &self.engine;
        let states = (0..e.nodes.local_count)
            .filter(|&i| e.nodes.is_owned(i))
            .map(|i| e.nodes.record(i))
            .collect();
        post(comm, 0, Tag::Report, &ToMaster::Closing(Box::new(closing), states))
    }
}

/// Returns the kind of an order, for the recording.
fn kind(action: &Action) -> OrderKind {
    match action {
        Action::Renew(_) => OrderKind::High,
        Action::Recut => OrderKind::Low,
        Action::Checkpoint | Action::Copy => OrderKind::Checkpoint,
        Action::View(_) => OrderKind::View,
        Action::Steer(Steer::Stop) | Action::Fail => OrderKind::Stop,
        Action::Steer(_) => OrderKind::Steering,
    }
}
