//! Pictures for clients: fields of own elements in files that belong to no output.

use super::RunningWorker;
use crate::output;
use crumple_proto::message::{ToMaster, Viewed};
use crumple_proto::report::Phase;
use crumple_proto::transport::{RankLost, Tag, Transport};
use crumple_proto::wire::post;
use std::path::Path;
use std::time::Instant;

impl RunningWorker {
    /// Writes the picture that the master has ordered. It reads the state only.
    pub(super) fn write_view_if_due(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let Some(folder) = self.view_due.take() else { return Ok(()) };
        let began = Instant::now();
        let written = output::write_view(&self.engine, Path::new(&folder));
        let viewed = Viewed {
            cycle: self.engine.clock.cycle,
            time: self.engine.clock.time,
            seconds: began.elapsed().as_secs_f64(),
            error: written.err().map(|error| error.to_string()),
        };
        self.engine.timer.lap(Phase::Output);
        post(comm, 0, Tag::Report, &ToMaster::Viewed(viewed))
    }
}
