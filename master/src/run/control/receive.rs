//! Messages of workers: each is taken into the results, the balance or a checkpoint.

use super::{Control, RunError};
use crate::results::history::Extras;
use crate::results::workers;
use crate::run::checkpoint::MasterState;
use crumple_proto::disk;
use crumple_proto::exact_sum::ExactSum;
use crumple_proto::message::ToMaster;
use crumple_proto::report::{HistoryPart, StepReport};
use crumple_proto::transport::Tag;
use crumple_proto::wire::poll_message;
use std::time::Instant;

/// Most messages that are taken from a worker before signals and clients have their turn: a run may
/// write rows faster than the master can take them.
const MOST_MESSAGES: usize = 100;

impl Control<'_> {
    /// Receives messages that have arrived from workers. Returns true if there was one.
    pub(super) fn listen(&mut self) -> Result<bool, RunError> {
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

    pub(super) fn receive(&mut self, worker: usize, message: ToMaster) -> Result<(), RunError> {
        match message {
            ToMaster::Report(report) => self.add_report(worker, *report)?,
            ToMaster::History(part) => self.add_history(*part)?,
            ToMaster::Fields { index, time } => self.add_fields(index, time)?,
            ToMaster::Warning(warning) => {
                tracing::warn!(worker, warning);
                self.announce(&format!("warning: worker {worker}: {warning}"));
            }
            ToMaster::Crossed(crossings) => self.watch_crossings(&crossings),
            ToMaster::Captured(captured, repeat) => {
                if self.checkpoints.add_captured(captured, repeat) {
                    let cycle = captured.cycle;
                    let _span = tracing::debug_span!("checkpoint", cycle).entered();
                    let state = self.state_on_disk()?;
                    self.checkpoints.add_master([cycle, repeat], state);
                    self.take_deferred();
                }
            }
            ToMaster::Copied(captured, repeat, seconds) => {
                if self.checkpoints.copies.add(seconds) {
                    let state = self.state_on_disk()?;
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

    /// Adds the report of a worker to `workers.csv` and to the balance.
    fn add_report(&mut self, worker: usize, report: StepReport) -> Result<(), RunError> {
        let _span = tracing::trace_span!("report", worker, cycle = report.cycle).entered();
        let imbalance = self.balance.imbalance();
        let path = self.out.join(workers::FILE);
        disk::watched(&path, || self.of_workers.add(worker, &report, imbalance))
            .map_err(|e| self.unwritten(e))?;
        self.balance.add_report(worker, report);
        Ok(())
    }

    /// Adds the sums of a worker to the row of the histories, and watches the complete row.
    fn add_history(&mut self, part: HistoryPart<ExactSum>) -> Result<(), RunError> {
        let b = &self.balance;
        let extras = Extras {
            wall: self.wall(),
            cpu_total: b.total_s,
            cpu_critical: b.critical_s,
            cpu_renewal: b.renewal_s.iter().copied().fold(0.0, f64::max),
            low: b.low,
            high: b.high,
            erosions: b.erosions(),
            classes: b.classes(),
        };
        let path = self.out.join("history.csv");
        disk::watched(&path, || self.history.add_part(part, extras))
            .map_err(|e| RunError::Output { path, error: e.into() })?;
        self.watch_energy();
        self.watch_row();
        self.watch_work();
        self.watch_files();
        Ok(())
    }

    /// Counts the pieces of an output of fields, and adds it to the series when it is complete.
    fn add_fields(&mut self, index: usize, time: f64) -> Result<(), RunError> {
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
        Ok(())
    }

    /// Returns the state of the master for a checkpoint, after all rows so far are written.
    fn state_on_disk(&mut self) -> Result<MasterState, RunError> {
        self.finish_reports()?;
        Ok(self.state())
    }

    /// Writes the rows of `workers.csv` that wait.
    pub(super) fn finish_reports(&mut self) -> Result<(), RunError> {
        let (imbalance, path) = (self.balance.imbalance(), self.out.join(workers::FILE));
        disk::watched(&path, || self.of_workers.finish(imbalance)).map_err(|e| self.unwritten(e))
    }

    /// Returns the error for a failure to write `workers.csv`.
    fn unwritten(&self, error: csv::Error) -> RunError {
        RunError::Output { path: self.out.join(workers::FILE), error: error.into() }
    }
}
