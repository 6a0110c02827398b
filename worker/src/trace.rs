//! Records the time line of a worker for `crumple run --trace`. Other runs have no recorder and
//! no cost.

use crumple_proto::report::Phase;
use crumple_proto::trace::{Event, MAX_EVENTS, Moment, Recording, Span};
use crumple_proto::transport::{MaxReduction, RankLost, Tag, Transport, clock};
use std::time::{Duration, Instant};

/// Records up to [`MAX_EVENTS`] spans and moments.
#[derive(Debug)]
pub struct Recorder {
    origin: Instant,
    cycle: u64,
    recording: Recording,
}

impl Recorder {
    /// Starts at the same moment on all workers. All workers call this together.
    ///
    /// No worker leaves a barrier before the last one has entered it. So the end of the barrier
    /// is later than this moment by at most the time that this worker was in the barrier; this is
    /// the uncertainty of the origin. The first barrier makes all workers enter the second at
    /// nearly the same time.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn start(comm: &mut dyn Transport) -> Result<Self, RankLost> {
        let mut barrier = MaxReduction::new(1, Tag::Maximum);
        let mut entered = Instant::now();
        for _ in 0..2 {
            entered = Instant::now();
            barrier.begin(comm, &[0.0])?;
            barrier.finish(comm)?;
        }
        let (origin, by_clock) = (Instant::now(), clock());
        let recording = Recording {
            origin: nanoseconds(by_clock),
            doubt: nanoseconds(origin - entered),
            ..Recording::default()
        };
        Ok(Self { origin, cycle: 0, recording })
    }

    /// Sets the cycle to which the next records belong.
    pub fn set_cycle(&mut self, cycle: u64) {
        self.cycle = cycle;
    }

    /// Records a span of time.
    pub fn span(&mut self, phase: Phase, from: Instant, to: Instant) {
        if self.has_room() {
            let (start, end) = (self.since_origin(from), self.since_origin(to));
            let span = Span { phase: phase as u8, cycle: self.cycle, start, duration: end - start };
            self.recording.spans.push(span);
        }
    }

    /// Records an event at the present moment.
    pub fn moment(&mut self, event: Event) {
        if self.has_room() {
            let moment = Moment { event, cycle: self.cycle, at: self.since_origin(Instant::now()) };
            self.recording.moments.push(moment);
        }
    }

    /// Returns the recording.
    pub fn into_recording(self) -> Recording {
        self.recording
    }

    fn has_room(&mut self) -> bool {
        let r = &mut self.recording;
        let room = r.spans.len() + r.moments.len() < MAX_EVENTS;
        if !room {
            r.full.get_or_insert(self.cycle);
        }
        room
    }

    fn since_origin(&self, at: Instant) -> u64 {
        nanoseconds(at.saturating_duration_since(self.origin))
    }
}

fn nanoseconds(time: Duration) -> u64 {
    time.as_nanos() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::transport::threads;

    #[test]
    fn a_full_recording_says_where_it_ends() {
        let mut comm = threads::connect(2).remove(1);
        let mut recorder = Recorder::start(&mut comm).unwrap();
        let now = Instant::now();
        recorder.moment(Event::Erosion);
        for cycle in 0..MAX_EVENTS as u64 + 10 {
            recorder.set_cycle(cycle);
            recorder.span(Phase::Halo, now, now);
        }
        let r = recorder.into_recording();
        assert_eq!(
            (r.spans.len() + r.moments.len(), r.full),
            (MAX_EVENTS, Some(MAX_EVENTS as u64 - 1))
        );
    }
}
