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

/// CPU time of one wait. To read the CPU clock is a system call, which takes longer than many
/// waits. So a brief wait, in which the rank polls and hardly ever loses its core, counts its wall
/// time.
pub struct WaitClock {
    start: Instant,
    /// Time for which the rank had polled when the wait was no longer brief, and the CPU clock
    /// then.
    later: Option<[Duration; 2]>,
}

impl WaitClock {
    /// Starts with the wait.
    pub fn start() -> Self {
        Self { start: Instant::now(), later: None }
    }

    /// Returns the wall time since the start. Call it at least once in [`BRIEF`] while polling.
    pub fn elapsed(&mut self) -> Duration {
        let elapsed = self.start.elapsed();
        if elapsed > BRIEF {
            self.before_sleep();
        }
        elapsed
    }

    /// Reads the CPU clock, unless it has been read. Call it before the rank sleeps.
    pub fn before_sleep(&mut self) {
        if self.later.is_none() {
            self.later = Some([self.start.elapsed().min(BRIEF), thread_cpu()]);
        }
    }

    /// Returns the CPU time since the start.
    pub fn cpu(&self) -> Duration {
        match self.later {
            None => self.start.elapsed().min(BRIEF),
            Some([polled, then]) => polled + thread_cpu().saturating_sub(then),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polling is CPU time, sleep is none.
    #[test]
    fn the_clock_of_a_wait_counts_cpu_time() {
        let before = thread_cpu();
        let mut brief = WaitClock::start();
        while brief.elapsed() < BRIEF / 4 {}
        let (cpu, all) = (brief.cpu(), thread_cpu() - before);
        assert!(cpu >= BRIEF / 4 && cpu <= BRIEF + all, "{cpu:?} of {all:?}");
        let mut long = WaitClock::start();
        let before = thread_cpu();
        while thread_cpu() - before < Duration::from_millis(5) {
            long.elapsed();
        }
        std::thread::sleep(Duration::from_millis(20));
        let (cpu, all) = (long.cpu(), thread_cpu() - before);
        assert!(cpu + Duration::from_millis(1) >= all, "polling counts: {cpu:?} of {all:?}");
        assert!(cpu <= all + BRIEF, "sleep does not: {cpu:?} of {all:?}");
        // A rank without a core of its own sleeps at once.
        let before = thread_cpu();
        let mut asleep = WaitClock::start();
        asleep.before_sleep();
        std::thread::sleep(Duration::from_millis(20));
        let (cpu, all) = (asleep.cpu(), thread_cpu() - before);
        assert!(cpu <= all, "only what it used: {cpu:?} of {all:?}");
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
