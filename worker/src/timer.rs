//! Wall-clock time of a worker by phase.

use crate::trace::Recorder;
use crumple_proto::report::{PHASES, Phase, PhaseSeconds};
use crumple_proto::transport::{RankLost, Transport};
use std::time::Instant;

/// Time per phase.
#[derive(Debug)]
pub struct Timer {
    /// Time so far [s].
    pub seconds: PhaseSeconds,
    last: Instant,
    recorder: Option<Box<Recorder>>,
}

impl Default for Timer {
    /// Starts with no time booked.
    fn default() -> Self {
        Self { seconds: [0.0; PHASES.len()], last: Instant::now(), recorder: None }
    }
}

impl Timer {
    /// Starts a lap and does not book the time before it.
    pub fn restart(&mut self) {
        self.last = Instant::now();
    }

    /// Books the time since the last lap for `phase`.
    pub fn lap(&mut self, phase: Phase) {
        let now = Instant::now();
        self.seconds[phase as usize] += (now - self.last).as_secs_f64();
        if let Some(recorder) = &mut self.recorder {
            recorder.span(phase, self.last, now);
        }
        self.last = now;
    }

    /// Records all laps from now on. All workers call this together.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn record(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        self.recorder = Some(Box::new(Recorder::start(comm)?));
        self.restart();
        Ok(())
    }

    /// Returns the recorder, if there is one.
    pub fn recorder(&mut self) -> &mut Option<Box<Recorder>> {
        &mut self.recorder
    }
}
