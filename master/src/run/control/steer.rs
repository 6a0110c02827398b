//! Requests of clients: they become orders, which the workers carry out in a cycle on which they
//! agree. The answer follows when the order has taken effect.

use super::Control;
use crate::results::steering::SteeringRecord;
use crate::run::balance::URGENT;
use crate::run::request::{Answer, Done, Energy, Progress, Request, Status, Thresholds, Worker};
use crate::run::service::{Desk, Reply};
use crumple_proto::message::Action;
use crumple_proto::report::StepReport;
use crumple_proto::steering::{Change, KEYS, MOST_FIELDS, Steer, Steered};
use std::time::{Duration, Instant};

/// Interval between two lines of progress in the stream.
const SHOW_EVERY: Duration = Duration::from_millis(200);

/// Orders of users, and the clients that wait for their effect.
pub(super) struct Steering {
    /// Orders that have not taken effect, by number.
    waiting: Vec<(u64, Reply)>,
    /// Clients that wait for the end of a checkpoint.
    for_checkpoint: Vec<Reply>,
    /// True from a request for a checkpoint until it is ordered.
    asks_checkpoint: bool,
    /// Orders that have taken effect.
    done: Vec<Steered>,
    /// Orders that have taken effect after the state which the workers are copying.
    deferred: Vec<(u64, Steered)>,
    /// Cycle and time of the pause in which the workers wait.
    paused: Option<(u64, f64)>,
    /// True if a client has ordered a checkpoint in the pause, and no order has followed it.
    is_saved: bool,
    shown: Instant,
    desk: Option<Desk>,
}

impl Steering {
    /// Prepares orders. `done` are those of the run before the checkpoint.
    pub(super) fn new(desk: Option<Desk>, done: Vec<Steered>) -> Self {
        Self {
            waiting: Vec::new(),
            for_checkpoint: Vec::new(),
            asks_checkpoint: false,
            done,
            deferred: Vec::new(),
            paused: None,
            is_saved: false,
            shown: Instant::now(),
            desk,
        }
    }

    /// Returns true if the workers wait in a pause.
    pub(super) fn is_paused(&self) -> bool {
        self.paused.is_some()
    }

    /// Returns the orders that have taken effect, for a checkpoint: a run that continues from there
    /// has not stopped.
    pub(super) fn done_without_stop(&self) -> Vec<Steered> {
        self.done.iter().filter(|at| at.steer != Steer::Stop).copied().collect()
    }

    /// Returns the orders that have taken effect, for the summary.
    pub(super) fn records(&self) -> Vec<SteeringRecord> {
        self.done.iter().map(SteeringRecord::from).collect()
    }

    /// Sends a line to all clients. Without clients none is made.
    fn publish(&self, line: impl FnOnce() -> Answer) {
        if let Some(desk) = self.desk.as_ref().filter(|desk| desk.has_clients()) {
            desk.publish(&line());
        }
    }

    /// Informs clients that the run has ended.
    pub(super) fn end(&mut self, code: u8, reason: &str) {
        self.publish(|| Answer::Ended { code, reason: reason.into() });
        self.waiting.clear(); // their clients learn it too
        self.for_checkpoint.clear();
        self.desk = None;
    }
}

impl Control<'_> {
    /// Takes the requests that have arrived, and sends progress to clients.
    pub(super) fn serve_clients(&mut self) {
        while let Some(call) = self.steering.desk.as_mut().and_then(Desk::next_call) {
            let (request, reply) = call.split();
            self.take_request(request, reply);
        }
        if self.steering.shown.elapsed() >= SHOW_EVERY {
            self.steering.shown = Instant::now();
            self.steering.publish(|| Answer::Progress(self.current_progress()));
        }
    }

    fn take_request(&mut self, request: Request, reply: Reply) {
        let order = match request {
            Request::Status | Request::Watch => {
                return reply.send(Answer::Status(Box::new(self.status())));
            }
            Request::View => return self.take_view(reply),
            Request::Set { key, value } => match self.check_change(&key, value) {
                Ok(change) => Steer::Set(change),
                Err(why) => return reply.send(Answer::refused(why)),
            },
            Request::Checkpoint => Steer::Checkpoint,
            Request::Pause => Steer::Pause,
            Request::Continue => Steer::Continue,
            Request::Stop => Steer::Stop,
        };
        tracing::info!(%order, "order of a user");
        if self.stop_ordered {
            return reply.send(Answer::refused("the run is stopping"));
        }
        match order {
            Steer::Continue if self.steering.paused.is_none() => {
                reply.send(Answer::refused("the run is not paused"));
            }
            Steer::Checkpoint => {
                self.steering.asks_checkpoint = true;
                self.steering.for_checkpoint.push(reply);
            }
            Steer::Stop => {
                self.stop();
                self.steering.waiting.push((self.orders, reply));
            }
            _ => {
                self.order(Action::Steer(order));
                self.steering.waiting.push((self.orders, reply));
            }
        }
    }

    /// Checks a change against the state of the run.
    fn check_change(&self, key: &str, value: f64) -> Result<Change, String> {
        let change = Change::new(key, value)?;
        let (time, end) = (self.latest().time, self.model.settings.end_time);
        let fields = match change {
            Change::EndTime(end) if end <= time => {
                return Err(format!("end_time = {end:?}: the run has reached {time:?}"));
            }
            Change::EndTime(end) => end / self.model.settings.output.field_interval,
            Change::FieldInterval(interval) => end / interval,
            _ => 0.0,
        };
        if fields > MOST_FIELDS {
            return Err(format!("{key} = {value:?} gives {fields:.0} field files"));
        }
        Ok(change)
    }

    /// Orders the end of the run, once.
    pub(super) fn stop(&mut self) {
        self.stop_ordered = true;
        self.announce("stopping: the workers finish their cycle and write their state");
        self.order(Action::Steer(Steer::Stop));
    }

    /// Orders a checkpoint if one is due. `asked` is true if a signal asks for it. A run that is
    /// paused needs no second checkpoint if nothing has changed since the last one.
    pub(super) fn order_checkpoint_if_due(&mut self, asked: bool) -> bool {
        let paused = self.steering.paused;
        let newest = self.checkpoints.newest.filter(|n| Some(n.0) == paused.map(|p| p.0));
        if let Some((cycle, time)) =
            newest.filter(|_| self.steering.is_saved && !self.checkpoints.is_busy())
        {
            self.steering.asks_checkpoint = false;
            let order = Steer::Checkpoint.to_string();
            let note = "the checkpoint of this cycle is complete".to_string();
            let done = Done { order, cycle, time, note };
            for reply in self.steering.for_checkpoint.drain(..) {
                reply.send(Answer::Done(done.clone()));
            }
            return false;
        }
        let asks = self.steering.asks_checkpoint;
        if !self.checkpoints.take_due(asks || asked, paused.is_some()) {
            return false;
        }
        self.steering.asks_checkpoint = false;
        self.order(if asks { Action::Steer(Steer::Checkpoint) } else { Action::Checkpoint });
        true
    }

    /// Answers the clients that wait for a checkpoint, when one has ended.
    pub(super) fn answer_checkpoint(&mut self, ended: &Result<String, String>) {
        self.steering.is_saved &= ended.is_ok();
        if self.steering.asks_checkpoint {
            return; // theirs is the next one
        }
        let (cycle, time) = self.checkpoints.newest.unwrap_or_default();
        for reply in self.steering.for_checkpoint.drain(..) {
            reply.send(match ended {
                Ok(note) => {
                    let order = Steer::Checkpoint.to_string();
                    Answer::Done(Done { order, cycle, time, note: note.clone() })
                }
                Err(why) => Answer::refused(why),
            });
        }
    }

    /// Takes an order that has taken effect. If some workers have copied their states and others
    /// have not, it belongs to a later cycle than the copy, and waits.
    pub(super) fn take_steered(&mut self, number: u64, at: Steered) {
        if self.checkpoints.is_capturing() {
            self.steering.deferred.push((number, at));
        } else {
            self.record_steered(number, at);
        }
    }

    /// Takes the orders that have waited for a copy.
    pub(super) fn take_deferred(&mut self) {
        for (number, at) in std::mem::take(&mut self.steering.deferred) {
            self.take_steered(number, at);
        }
    }

    /// Records an order that has taken effect, applies what concerns the master, and answers its
    /// client.
    fn record_steered(&mut self, number: u64, at: Steered) {
        let Steered { steer, cycle, time, .. } = at;
        tracing::info!(number, order = %steer, cycle, time, "order has taken effect");
        self.steering.is_saved = steer == Steer::Checkpoint;
        match steer {
            Steer::Pause => self.steering.paused = Some((cycle, time)),
            Steer::Continue => self.steering.paused = None,
            Steer::Checkpoint => {}
            // A planned one, too: no order follows it.
            Steer::Stop => self.stop_ordered = true,
            Steer::Set(change) => self.apply(change, &at),
        }
        self.steering.done.push(at);
        self.announce(&format!("order: {steer}, in cycle {cycle}, at time {time:.6e}"));
        let waiting = &mut self.steering.waiting;
        if let Some(place) = waiting.iter().position(|(n, _)| *n == number) {
            let (_, reply) = waiting.remove(place);
            let note = String::new();
            reply.send(Answer::Done(Done { order: steer.to_string(), cycle, time, note }));
        }
    }

    fn apply(&mut self, change: Change, at: &Steered) {
        self.model.settings.change(change, at);
        let limits = &mut self.model.decomposition;
        match change {
            Change::EndTime(end) => self.progress.set_end_time(end),
            Change::Imbalance(imbalance) => limits.imbalance = imbalance,
            Change::LowEveryAtLeast(cycles) => limits.low_every_at_least = cycles,
            Change::FieldInterval(_) | Change::HistoryInterval(_) => {}
        }
        let limits = &self.model.decomposition;
        self.balance.set_limits(limits.imbalance, limits.low_every_at_least);
    }

    /// Prints a line, and sends it to clients.
    pub(super) fn announce(&self, line: &str) {
        self.progress.println(line);
        self.tell_clients(line);
    }

    /// Sends a line to clients.
    pub(super) fn tell_clients(&self, line: &str) {
        self.steering.publish(|| Answer::Event { text: line.into() });
    }

    /// Returns the last report of the worker that is ahead.
    pub(super) fn latest(&self) -> StepReport {
        self.balance.last.iter().max_by_key(|r| r.cycle).cloned().unwrap_or_default()
    }

    fn status(&self) -> Status {
        let (settings, limits) = (&self.model.settings, &self.model.decomposition);
        let values = [
            settings.end_time,
            settings.output.field_interval,
            settings.history_interval,
            limits.imbalance,
            limits.low_every_at_least as f64,
        ];
        let state = match (self.stop_ordered, self.steering.paused) {
            (true, _) => "stopping",
            (false, Some(_)) => "paused",
            (false, None) => "running",
        };
        Status {
            title: self.model.job.title.clone(),
            state: state.into(),
            pid: std::process::id(),
            workers: self.workers,
            transport: self.comm.name().into(),
            settings: KEYS.iter().map(|key| key.to_string()).zip(values).collect(),
            checkpoint: self.checkpoints.newest,
            progress: self.current_progress(),
        }
    }

    fn current_progress(&self) -> Progress {
        // JSON has no other numbers.
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        let last = self.latest();
        // Reports come every ten cycles.
        let (cycle, time) = self.steering.paused.unwrap_or((last.cycle, last.time));
        let row = self.history.course.last.clone().unwrap_or_default();
        let e = row.sum.energies;
        let worker = |r: &StepReport| Worker {
            displacement: finite(r.displacement.moved),
            margin: finite(r.displacement.margin),
            share: finite(r.displacement.share),
            load: r.cpu.iter().map(|&s| f64::from(s)).sum::<f64>() / r.cpu.len().max(1) as f64,
            elements: r.elements,
            pairs: r.pairs,
        };
        Progress {
            cycle,
            time,
            dt: finite(last.dt),
            wall_s: self.wall(),
            energy: Energy {
                kinetic: finite(e.kinetic),
                internal: finite(e.internal),
                hourglass: finite(e.hourglass),
                contact: finite(e.contact),
                external: finite(e.external),
                error: finite(row.error),
            },
            pairs: self.balance.pairs(),
            imbalance: finite(self.balance.mean_imbalance()),
            redecompositions: [self.balance.low, self.balance.high],
            thresholds: Thresholds {
                margin: URGENT,
                imbalance: self.model.decomposition.imbalance,
            },
            workers: self.balance.last.iter().map(worker).collect(),
        }
    }
}
