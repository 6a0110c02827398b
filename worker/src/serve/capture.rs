//! The worker's part in checkpoints: copies of the state, and their files.

use super::RunningWorker;
use crate::checkpoint::writer::Task;
use crate::engine::Engine;
use crumple_proto::checkpoint::Captured;
use crumple_proto::message::ToMaster;
use crumple_proto::report::Phase;
use crumple_proto::transport::{RankLost, Tag, Transport};
use crumple_proto::wire::post;
use std::sync::Arc;
use std::time::{Duration, Instant};

impl RunningWorker {
    /// Copies the state if a checkpoint or a copy is due, in the same cycle on all workers, and
    /// starts to write it if it is a checkpoint.
    pub(super) fn save_if_due(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let Engine { clock, settings, .. } = &mut self.engine;
        let asked = &settings.checkpoint;
        let timed = clock.pass_checkpoint_time(&asked.times);
        let at_end = self.stopped && asked.at_stop && !(self.failed && self.kept.is_some());
        let writes = std::mem::take(&mut self.checkpoint_due) || timed || at_end;
        let copies = std::mem::take(&mut self.copy_due) && !self.stopped;
        if !writes && !copies {
            return Ok(());
        }
        if self.stopped {
            self.finish_writing(comm)?;
        }
        let cycle = self.engine.clock.cycle;
        let _span = tracing::debug_span!("checkpoint", cycle, writes).entered();
        let began = Instant::now();
        let earlier = if self.captures.0 == cycle { self.captures.1 } else { 0 };
        self.captures = (cycle, earlier + 1);
        self.kept = None; // before the memory for the next one is needed
        let mut copied = self.engine.copy_state(comm)?;
        // A new field is an error here: state has to be added, all else to the last lists.
        let Self {
            crossed,
            named,
            sent_before,
            // Saved by `copy_state`.
            engine: _,
            // They belong to the partition and to this process.
            orders: _,
            done: _,
            cpu_before: _,
            cost: _,
            samples: _,
            sent: _,
            stopped: _,
            last_row_sent: _,
            checkpoint_due: _,
            copy_due: _,
            fields_cycle: _,
            view_due: _,
            steering: _,
            paused: _,
            captures: _,
            kept: _,
            failed: _,
            writer: _,
            // Costs since the last report; they are in no file that has to be the same.
            report: _,
        } = self;
        (copied.own.crossed, copied.own.named) = (*crossed, *named);
        (0..2).for_each(|i| copied.own.sent[i] += sent_before[i]);
        let Engine { clock, settings, .. } = &self.engine;
        let captured = Captured {
            cycle: clock.cycle,
            time: clock.time,
            rows: clock.rows,
            fields: clock.fields as u64,
        };
        let task = Task {
            copied,
            dir: settings.checkpoint.dir.clone().into(),
            cycle: clock.cycle,
            repeat: earlier,
            worker: comm.rank() - 1,
            compression: settings.checkpoint.compression,
            copy: began.elapsed(),
            progress: Arc::default(),
        };
        if writes {
            post(comm, 0, Tag::Report, &ToMaster::Captured(captured, earlier))?;
            self.write(comm, task)?;
        } else {
            let seconds = task.copy.as_secs_f64();
            post(comm, 0, Tag::Report, &ToMaster::Copied(captured, earlier, seconds))?;
            self.kept = Some(task);
        }
        self.engine.timer.lap(Phase::Output);
        Ok(())
    }

    /// Starts to write a checkpoint.
    pub(super) fn write(&mut self, comm: &mut dyn Transport, task: Task) -> Result<(), RankLost> {
        for saved in self.writer.poll().into_iter().chain(self.writer.start(task)) {
            post(comm, 0, Tag::Report, &ToMaster::Saved(saved))?;
        }
        Ok(())
    }

    /// Waits for the files of a checkpoint, if some are being written.
    pub(super) fn finish_writing(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let patience = Duration::from_secs_f64(self.engine.settings.checkpoint.patience);
        match self.writer.wait(patience) {
            None => Ok(()),
            Some(saved) => post(comm, 0, Tag::Report, &ToMaster::Saved(saved)),
        }
    }
}
