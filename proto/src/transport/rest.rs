//! How a rank leaves its core to others while it waits for a message.

use std::time::{Duration, Instant};

/// How a rank waits for a message after it has polled: it yields its core, or sleeps.
///
/// To yield costs less than a microsecond if only ranks of the run want the core. But a process
/// outside the run keeps the core for a slice of some milliseconds, even one of low priority. A
/// thread that wakes from a sleep gets the core back at once. So after a yield that took long, the
/// rank sleeps in the next pauses: in twice as many each time, until yields are short again.
///
/// A pause with MPI is one yield or one sleep between two polls. A rank that is a thread is woken
/// by its message: there a pause with sleep is the rest of the wait.
#[derive(Debug)]
pub struct Rest {
    /// Number of pauses left in which the rank sleeps.
    sleeps: u32,
    /// Number of such pauses after the next long yield.
    next: u32,
    /// Number of short yields since the last long one.
    short: u32,
}

/// Duration of a yield from which another process is assumed to occupy the core.
const SLICE: Duration = Duration::from_millis(2);
/// Smallest and largest number of pauses with sleep after such a yield.
const SLEEPS: [u32; 2] = [200, 100_000];
/// Number of short yields in a row after which the core counts as free again.
const FREE: u32 = 2000;
/// Time of waiting up to which a rank yields.
const YIELDS: Duration = Duration::from_millis(2);
/// Shortest and longest sleep. A sleep is also this part of the time of waiting: a message is
/// received late by at most this part.
#[cfg(feature = "mpi")]
const SLEEP: [Duration; 2] = [Duration::from_micros(20), Duration::from_micros(500)];
#[cfg(feature = "mpi")]
const LATE: u32 = 4;

impl Rest {
    /// Creates it for a rank that has not waited yet.
    pub fn new() -> Self {
        Self { sleeps: 0, next: SLEEPS[0], short: 0 }
    }

    /// Makes the sleeps of the calling thread as short as they are asked for; the default of Linux
    /// adds up to 50 us.
    #[cfg(feature = "mpi")]
    pub fn shorten_sleeps() {
        // Without it, sleeps are longer.
        let _ = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1));
    }

    /// Leaves the core to others for a short time, in a wait that has lasted for `waited`.
    #[cfg(feature = "mpi")]
    pub fn pause(&mut self, waited: Duration) {
        if self.yields(waited) {
            self.yield_core();
        } else {
            self.record_sleep();
            std::thread::sleep((waited / LATE).clamp(SLEEP[0], SLEEP[1]));
        }
    }

    /// Returns true if the rank yields now, in a wait that has lasted for `waited`; false if it
    /// sleeps.
    pub fn yields(&self, waited: Duration) -> bool {
        self.sleeps == 0 && waited <= YIELDS
    }

    /// Yields the core.
    pub fn yield_core(&mut self) {
        let start = Instant::now();
        std::thread::yield_now();
        self.record_yield(start.elapsed());
    }

    /// Records a sleep.
    pub fn record_sleep(&mut self) {
        self.sleeps = self.sleeps.saturating_sub(1);
    }

    fn record_yield(&mut self, took: Duration) {
        if took > SLICE {
            (self.sleeps, self.short) = (self.next, 0);
            self.next = (2 * self.next).min(SLEEPS[1]);
        } else {
            self.short += 1;
            if self.short >= FREE {
                (self.next, self.short) = (SLEEPS[0], 0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rank_sleeps_longer_each_time_that_others_keep_its_core() {
        let mut rest = Rest::new();
        rest.record_yield(Duration::from_micros(1));
        assert_eq!(rest.sleeps, 0);
        for number in 0..20 {
            rest.record_yield(2 * SLICE);
            assert_eq!(rest.sleeps, (SLEEPS[0] << number).min(SLEEPS[1]));
        }
        assert!(!rest.yields(Duration::ZERO), "it sleeps");
        rest.record_sleep();
        assert_eq!(rest.sleeps, SLEEPS[1] - 1);
        (0..FREE).for_each(|_| rest.record_yield(Duration::ZERO));
        rest.record_yield(2 * SLICE);
        assert_eq!(rest.sleeps, SLEEPS[0], "the core was free meanwhile");
    }
}
