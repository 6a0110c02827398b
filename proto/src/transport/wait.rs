//! How long a rank polls for a message before it leaves its core to others.
//!
//! Waking a sleeping thread takes longer than most waits, so a rank polls first. But if the sender
//! waits for this core, each poll delays the message. So the polling time follows the waits: it is
//! twice the longest wait that has ended while polling, and becomes shorter with each wait that has
//! not.

use std::time::Duration;

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
}
