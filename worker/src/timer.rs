//! Time of a worker by phase: wall-clock time of all cycles, and CPU time of some of them.
//!
//! To read the CPU clock of a thread is a system call, which costs about as much as some elements.
//! So CPU time by phase is measured in one of [`SAMPLE_EVERY`] cycles.

use crate::math::threads;
use crate::trace::Recorder;
use crumple_proto::report::{PHASES, Phase, PhaseSeconds};
use crumple_proto::transport::{RankLost, Transport};
use std::time::{Duration, Instant};

/// Number of cycles of which one is sampled.
pub const SAMPLE_EVERY: u64 = 10;

/// Time per phase.
#[derive(Debug)]
pub struct Timer {
    /// Wall-clock time so far [s].
    pub seconds: PhaseSeconds,
    /// CPU time without waiting of the sampled cycles, since the last call of
    /// [`Self::take_sample`] [s].
    cpu: PhaseSeconds,
    /// CPU time at the last stage, in a sampled cycle.
    sampled: Option<Duration>,
    last: Instant,
    recorder: Option<Box<Recorder>>,
}

impl Default for Timer {
    /// Starts with no time booked.
    fn default() -> Self {
        Self {
            seconds: [0.0; PHASES.len()],
            cpu: [0.0; PHASES.len()],
            sampled: None,
            last: Instant::now(),
            recorder: None,
        }
    }
}

/// Returns the CPU time so far of this thread and its helpers, without waiting for messages or for
/// each other.
pub fn busy(comm: &dyn Transport) -> Duration {
    threads::cpu().saturating_sub(comm.wait_cpu())
}

impl Timer {
    /// Starts a lap and does not book the time before it.
    pub fn restart(&mut self) {
        self.last = Instant::now();
    }

    /// Begins a cycle. One of [`SAMPLE_EVERY`] cycles is sampled, at a place that changes, so that
    /// work which recurs at regular intervals is neither always nor never sampled.
    pub fn begin_cycle(&mut self, cycle: u64, comm: &dyn Transport) {
        let hash = (cycle / SAMPLE_EVERY).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32;
        let is_sampled = cycle % SAMPLE_EVERY == hash % SAMPLE_EVERY;
        self.sampled = is_sampled.then(|| busy(comm));
    }

    /// Returns true if the present cycle is sampled.
    pub fn is_sampled(&self) -> bool {
        self.sampled.is_some()
    }

    /// Books the time since the last lap for `phase`, and in a sampled cycle the CPU time since
    /// the last stage. Returns the time since the last lap.
    pub fn lap_of_stage(&mut self, phase: Phase, comm: &dyn Transport) -> Duration {
        if let Some(before) = &mut self.sampled {
            let now = busy(comm);
            self.cpu[phase as usize] += now.saturating_sub(*before).as_secs_f64();
            *before = now;
        }
        self.lap(phase)
    }

    /// Returns the CPU time by phase of the cycles sampled since the last call [s].
    pub fn take_sample(&mut self) -> PhaseSeconds {
        std::mem::replace(&mut self.cpu, [0.0; PHASES.len()])
    }

    /// Books the time since the last lap for `phase`, and returns it.
    pub fn lap(&mut self, phase: Phase) -> Duration {
        let now = Instant::now();
        let lap = now - self.last;
        self.seconds[phase as usize] += lap.as_secs_f64();
        if let Some(recorder) = &mut self.recorder {
            recorder.span(phase, self.last, now);
        }
        self.last = now;
        lap
    }

    /// Returns the time that a checkpoint contains: wall-clock time so far by phase [s].
    pub fn saved(&self) -> PhaseSeconds {
        // A new field is an error here: it has to be added to a checkpoint, or to the last list.
        let Self {
            seconds,
            // Since the last report, or for one cycle only.
            cpu: _,
            sampled: _,
            last: _,
            // It belongs to this process.
            recorder: _,
        } = self;
        *seconds
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

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::transport::threads;

    #[test]
    fn one_cycle_of_each_report_is_sampled_and_not_always_the_same() {
        let comm = threads::connect(2).remove(1);
        let mut timer = Timer::default();
        let mut places = std::collections::BTreeSet::new();
        for report in 0..50 {
            let sampled: Vec<u64> = (0..SAMPLE_EVERY)
                .filter(|place| {
                    timer.begin_cycle(report * SAMPLE_EVERY + place, &comm);
                    timer.is_sampled()
                })
                .collect();
            assert_eq!(sampled.len(), 1, "report {report}");
            places.extend(sampled);
        }
        assert_eq!(places.len(), SAMPLE_EVERY as usize, "each place comes up");
    }

    /// Sleep is no CPU time.
    #[test]
    fn only_work_counts_as_cpu_time() {
        let comm = threads::connect(2).remove(1);
        let mut timer = Timer::default();
        let sampled = (0..).find(|&c| {
            timer.begin_cycle(c, &comm);
            timer.is_sampled()
        });
        assert!(sampled.is_some());
        timer.restart();
        std::thread::sleep(Duration::from_millis(30));
        timer.lap_of_stage(Phase::Halo, &comm);
        let (wall, cpu) = (timer.seconds[Phase::Halo as usize], timer.take_sample());
        assert!(wall >= 0.03 && cpu[Phase::Halo as usize] < 0.02, "{wall}, {cpu:?}");
        assert_eq!(timer.take_sample(), [0.0; PHASES.len()]);
    }
}
