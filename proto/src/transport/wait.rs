//! How long a rank polls for a message before it leaves its core to others.
//!
//! Waking a sleeping thread takes longer than most waits, so a rank polls first. But if the sender
//! waits for this core, each poll delays the message. So the polling time follows the waits: it is
//! twice the longest wait that has ended while polling, and becomes shorter with each wait that has
//! not.

use std::time::{Duration, Instant};

/// Shortest and longest polling time.
const SHORTEST: Duration = Duration::from_micros(4);
const LONGEST: Duration = Duration::from_micros(64);
/// One of this number of waits polls for at least [`PROBE`], to notice that waits have become
/// short.
const PROBE_EVERY: u32 = 32;
const PROBE: Duration = Duration::from_micros(32);

/// Polling time of one rank.
#[derive(Debug)]
pub struct Patience {
    time: Duration,
    longest: Duration,
    waits: u32,
}

impl Patience {
    /// Returns the polling time of a rank that has a core, or of one that never polls because
    /// ranks share cores.
    pub fn new(has_core: bool) -> Self {
        let longest = if has_core { LONGEST } else { Duration::ZERO };
        Self { time: longest, longest, waits: 0 }
    }

    /// Returns the time to poll in the wait that begins.
    pub fn start(&mut self) -> Duration {
        self.waits = self.waits.wrapping_add(1);
        let least = if self.waits.is_multiple_of(PROBE_EVERY) { PROBE } else { SHORTEST };
        self.time.max(least).min(self.longest)
    }

    /// Records a wait that has ended after `waited` while the rank polled.
    pub fn record_success(&mut self, waited: Duration) {
        self.time = self.time.max(2 * waited).min(self.longest);
    }

    /// Records a wait that has not ended while the rank polled.
    pub fn record_failure(&mut self) {
        self.time = self.time * 3 / 4;
    }
}

/// How a rank that cannot block waits for a message after it has polled: it yields its core, or
/// sleeps.
///
/// To yield costs less than a microsecond if only ranks of the run want the core. But a process
/// outside the run keeps the core for a slice of some milliseconds, even one of low priority. A
/// thread that wakes from a sleep gets the core back at once. So after a yield that took long, the
/// rank sleeps in the next pauses: in twice as many each time, until yields are short again.
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
const SLEEP: [Duration; 2] = [Duration::from_micros(20), Duration::from_micros(500)];
const LATE: u32 = 4;

impl Rest {
    /// Creates it for the calling thread, and makes the sleeps of this thread as short as they are
    /// asked for; the default of Linux adds up to 50 us.
    pub fn new() -> Self {
        // Without it, sleeps are longer.
        let _ = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1));
        Self { sleeps: 0, next: SLEEPS[0], short: 0 }
    }

    /// Leaves the core to others for a short time, in a wait that lasts since `waited`.
    pub fn pause(&mut self, waited: Duration) {
        if self.sleeps > 0 || waited > YIELDS {
            self.sleeps = self.sleeps.saturating_sub(1);
            std::thread::sleep((waited / LATE).clamp(SLEEP[0], SLEEP[1]));
            return;
        }
        let start = Instant::now();
        std::thread::yield_now();
        self.record_yield(start.elapsed());
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
    fn polling_follows_the_waits() {
        let mut patience = Patience::new(true);
        assert_eq!(patience.start(), LONGEST);
        for _ in 0..40 {
            patience.record_failure();
        }
        assert_eq!(patience.start(), SHORTEST, "the sender needs the core");
        let polls: Vec<_> = (0..PROBE_EVERY).map(|_| patience.start()).collect();
        assert_eq!(polls.iter().filter(|&&poll| poll == PROBE).count(), 1);
        let waited = Duration::from_micros(20);
        patience.record_success(waited);
        assert_eq!(patience.start(), 2 * waited, "such waits end while polling");
        patience.record_success(2 * LONGEST);
        assert_eq!(patience.start(), LONGEST);
        let mut shared = Patience::new(false);
        shared.record_success(waited);
        assert!((0..PROBE_EVERY).all(|_| shared.start() == Duration::ZERO));
    }

    #[test]
    fn a_rank_sleeps_longer_each_time_that_others_keep_its_core() {
        let mut rest = Rest::new();
        rest.record_yield(Duration::from_micros(1));
        assert_eq!(rest.sleeps, 0);
        for number in 0..20 {
            rest.record_yield(2 * SLICE);
            assert_eq!(rest.sleeps, (SLEEPS[0] << number).min(SLEEPS[1]));
        }
        rest.pause(Duration::ZERO);
        assert_eq!(rest.sleeps, SLEEPS[1] - 1, "it sleeps");
        (0..FREE).for_each(|_| rest.record_yield(Duration::ZERO));
        rest.record_yield(2 * SLICE);
        assert_eq!(rest.sleeps, SLEEPS[0], "the core was free meanwhile");
    }
}
