//! How long a rank polls for a message before it leaves its core to others.
//!
//! Waking a sleeping thread takes longer than most waits, so a rank polls first. But if the sender
//! waits for this core, each poll delays the message. So the polling time follows the waits: it is
//! twice the longest wait that has ended while polling, and becomes shorter with each wait that has
//! not.

use super::thread_cpu;
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

/// Polling time that counts as CPU time without a look at the CPU clock.
const BRIEF: Duration = Duration::from_micros(16);

/// CPU time of one wait. To read the CPU clock is a system call, which takes longer than many waits.
/// So a brief wait, in which the rank polls and hardly ever loses its core, counts its wall time.
pub struct WaitClock {
    start: Instant,
    /// CPU time when the wait was no longer brief.
    later: Option<Duration>,
}

impl WaitClock {
    /// Starts with the wait.
    pub fn start() -> Self {
        Self { start: Instant::now(), later: None }
    }

    /// Returns the wall time since the start. Call it at least once in [`BRIEF`] while polling, and
    /// before the rank sleeps.
    pub fn elapsed(&mut self) -> Duration {
        let elapsed = self.start.elapsed();
        if elapsed > BRIEF && self.later.is_none() {
            self.later = Some(thread_cpu());
        }
        elapsed
    }

    /// Returns the CPU time since the start.
    pub fn cpu(&self) -> Duration {
        let polled = self.start.elapsed().min(BRIEF);
        polled + self.later.map_or(Duration::ZERO, |later| thread_cpu().saturating_sub(later))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polling is CPU time, sleep is none.
    #[test]
    fn the_clock_of_a_wait_counts_cpu_time() {
        let mut brief = WaitClock::start();
        while brief.elapsed() < BRIEF / 4 {}
        assert!(brief.cpu() >= BRIEF / 4 && brief.cpu() <= BRIEF, "{:?}", brief.cpu());
        let mut long = WaitClock::start();
        let before = thread_cpu();
        while thread_cpu() - before < Duration::from_millis(5) {
            long.elapsed();
        }
        std::thread::sleep(Duration::from_millis(20));
        let (wall, cpu) = (long.elapsed(), long.cpu());
        assert!(wall >= Duration::from_millis(25), "{wall:?}");
        let wanted = Duration::from_millis(4)..Duration::from_millis(10);
        assert!(wanted.contains(&cpu), "{cpu:?}");
    }

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
}
