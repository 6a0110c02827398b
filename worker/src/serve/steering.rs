//! Orders of the user. They take effect when an outer step begins, in the same cycle on all
//! workers, and so can be repeated.

use super::RunningWorker;
use crumple_proto::message::ToMaster;
use crumple_proto::steering::{Steer, Steered};
use crumple_proto::transport::{RankLost, Tag, Transport};
use crumple_proto::wire::post;

impl RunningWorker {
    /// Carries out the orders that are due, copies the state if that is due, and waits for further
    /// orders while the run is paused. All workers then carry out what arrives, in the same cycle.
    pub(super) fn steer(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let cycle = self.engine.clock.cycle;
        while self.engine.settings.planned.first().is_some_and(|p| p.cycle <= cycle) {
            let planned = self.engine.settings.planned.remove(0);
            self.carry_out(comm, 0, planned.steer)?;
        }
        loop {
            while let Some((number, steer)) = self.steering.pop_front() {
                self.carry_out(comm, number, steer)?;
            }
            self.save_if_due(comm)?;
            if !self.paused || self.stopped {
                return Ok(());
            }
            self.finish_writing(comm)?; // no later cycle announces the files of a checkpoint
            self.take_order(comm)?;
            self.write_view_if_due(comm)?;
            self.engine.agreement.order = self.orders.back().map_or(self.done, |o| o.0);
            self.engine.timer.restart(); // the wait belongs to no phase
        }
    }

    fn carry_out(
        &mut self,
        comm: &mut dyn Transport,
        number: u64,
        steer: Steer,
    ) -> Result<(), RankLost> {
        let clock = &self.engine.clock;
        let (cycle, time) = (clock.cycle, clock.time);
        let at = Steered { steer, cycle, time, rows: clock.rows, fields: clock.fields as u64 };
        match steer {
            Steer::Pause => self.paused = true,
            Steer::Continue => self.paused = false,
            Steer::Checkpoint => self.checkpoint_due = true,
            Steer::Stop => self.stopped = true,
            Steer::Set(change) => self.engine.settings.change(change, &at),
        }
        tracing::debug!(number, %steer, cycle, "order takes effect");
        if comm.rank() == 1 {
            post(comm, 0, Tag::Report, &ToMaster::Steered(number, at))?;
        }
        Ok(())
    }
}
