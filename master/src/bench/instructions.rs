//! Instructions of this thread, where the system lets a program count them.

#[cfg(target_os = "linux")]
use perf_event::{Builder, Counter, events::Hardware};

/// A counter that runs since it was made.
pub struct Instructions {
    #[cfg(target_os = "linux")]
    counter: Counter,
}

impl Instructions {
    /// Starts to count; `None` where that is not allowed or not known.
    #[cfg(target_os = "linux")]
    pub fn start() -> Option<Self> {
        let mut counter = Builder::new(Hardware::INSTRUCTIONS).build().ok()?;
        counter.enable().ok()?;
        Some(Self { counter })
    }

    /// Starts to count; `None` where that is not allowed or not known.
    #[cfg(not(target_os = "linux"))]
    pub fn start() -> Option<Self> {
        None
    }

    /// So far, outside the system.
    pub fn so_far(&mut self) -> Option<u64> {
        #[cfg(target_os = "linux")]
        return self.counter.read().ok();
        #[cfg(not(target_os = "linux"))]
        None
    }
}
