//! Copies of the state in the memory of the workers, of which the last one becomes a checkpoint
//! when the run fails.
//!
//! A copy is due when a tenth of the wall time has passed since the last one, but not later than
//! after an interval of the job, and not so often that copies take more than a 200th of the time.

use super::MasterState;
use crumple_proto::checkpoint::Captured;
use std::time::{Duration, Instant};

/// Fraction of the wall time so far that may be lost.
const LOST: f64 = 0.1;
/// Least time between two copies, over the time of a copy.
const DEAR: f64 = 200.0;

/// All copies of a run.
pub struct Copies {
    /// Longest interval, `None` for no copies.
    limit: Option<Duration>,
    workers: usize,
    began: Instant,
    last: Instant,
    /// Time of the last copy on the slowest worker [s].
    cost: f64,
    /// Workers that have made the copy that is ordered.
    arrived: Option<usize>,
    /// The last copy that all workers have, and the number of earlier captures in its cycle.
    complete: Option<(Captured, u64, MasterState)>,
}

impl Copies {
    /// Prepares the copies of a run.
    pub fn new(limit: Option<Duration>, workers: usize) -> Self {
        let now = Instant::now();
        Self { limit, workers, began: now, last: now, cost: 0.0, arrived: None, complete: None }
    }

    /// Returns true if a copy should be ordered now. It is then counted as ordered.
    pub fn take_due(&mut self) -> bool {
        let Some(limit) = self.limit.filter(|_| self.arrived.is_none()) else { return false };
        let wanted = limit.as_secs_f64().min(LOST * self.began.elapsed().as_secs_f64());
        let due = self.last.elapsed().as_secs_f64() >= wanted.max(DEAR * self.cost);
        if due {
            (self.arrived, self.last) = (Some(0), Instant::now());
        }
        due
    }

    /// Returns true if some workers have made the copy, and others have not.
    pub fn is_partial(&self) -> bool {
        self.arrived.is_some_and(|arrived| arrived > 0)
    }

    /// Counts a worker that has copied its state in a time of `seconds`. Returns true if it is the
    /// last one; [`Self::set`] has to follow at once.
    pub fn add(&mut self, seconds: f64) -> bool {
        let first = self.arrived == Some(0);
        self.cost = if first { seconds } else { self.cost.max(seconds) };
        let arrived = self.arrived.map_or(1, |arrived| arrived + 1);
        self.arrived = (arrived < self.workers).then_some(arrived);
        self.arrived.is_none()
    }

    /// Sets the state of the master that belongs to the copy. `repeat` is the number of earlier
    /// captures in its cycle.
    pub fn set(&mut self, captured: Captured, repeat: u64, state: MasterState) {
        self.complete = Some((captured, repeat, state));
    }

    /// Takes the copy of this cycle and `repeat`, which the workers have written.
    pub fn take_copy(&mut self, at: [u64; 2]) -> Option<(Captured, MasterState)> {
        let taken = self.complete.take_if(|(captured, repeat, _)| [captured.cycle, *repeat] == at);
        taken.map(|(captured, _, state)| (captured, state))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_belongs_to_its_cycle_and_dear_copies_are_rare() {
        let mut copies = Copies::new(Some(Duration::from_secs(30)), 2);
        assert!(copies.take_due(), "the first one at the start");
        assert!(!copies.take_due(), "it is under way");
        assert!(!copies.add(1e3));
        assert!(copies.add(1e-3));
        copies.set(Captured { cycle: 7, ..Captured::default() }, 0, MasterState::default());
        assert!(!copies.take_due(), "a copy took 1000 s");
        assert!(copies.take_copy([6, 0]).is_none());
        assert!(copies.take_copy([7, 1]).is_none(), "a later capture of its cycle");
        assert_eq!(copies.take_copy([7, 0]).unwrap().0.cycle, 7);
        assert!(copies.take_copy([7, 0]).is_none());
        assert!(!Copies::new(None, 1).take_due());
    }
}
