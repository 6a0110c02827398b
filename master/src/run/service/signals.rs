//! Signals. Ctrl-C, TERM and USR2: the first one asks all workers to stop and to keep their state,
//! the second ends the process at once; a supervisor passes them on (`supervise.rs`). USR1 requests
//! a checkpoint. Launchers of MPI end the ranks at Ctrl-C and TERM, but pass on USR1 and USR2.

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1, SIGUSR2};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};
use tokio::signal::unix::{Signal, SignalKind, signal};

/// The effect of a request to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Manner {
    /// It ends the process: there is no state yet.
    AtOnce,
    /// It raises the flag; the next one ends the process.
    Orderly,
    /// It raises the flag.
    Patient,
}

/// Flags that are raised by a request to stop and by a request for a checkpoint.
#[derive(Clone, Debug, Default)]
pub struct StopFlag {
    stops: Arc<AtomicU32>,
    checkpoint: Arc<AtomicBool>,
    manner: Arc<AtomicU8>,
}

impl StopFlag {
    /// Changes what a request to stop does.
    pub fn set_manner(&self, manner: Manner) {
        self.manner.store(manner as u8, Ordering::Relaxed);
    }

    /// Returns true if the flag is raised.
    pub fn is_raised(&self) -> bool {
        self.stops() > 0
    }

    /// Returns the number of requests to stop.
    pub fn stops(&self) -> u32 {
        self.stops.load(Ordering::Relaxed)
    }

    /// Returns true if a checkpoint was requested since the last call of [`Self::take_request`].
    pub fn is_requested(&self) -> bool {
        self.checkpoint.load(Ordering::Relaxed)
    }

    /// Returns true if a checkpoint was requested since the last call.
    pub fn take_request(&self) -> bool {
        self.checkpoint.swap(false, Ordering::Relaxed)
    }

    /// Counts a request to stop, and ends the process if that is its effect.
    pub fn raise(&self) {
        let again = self.stops.fetch_add(1, Ordering::Relaxed) > 0;
        let manner = self.manner.load(Ordering::Relaxed);
        if manner == Manner::AtOnce as u8 || (again && manner == Manner::Orderly as u8) {
            std::process::exit(130);
        }
    }
}

/// The signals that this process receives in place of their usual effect.
pub(super) struct Signals {
    stops: [Signal; 3],
    request: Signal,
}

impl Signals {
    /// Begins to receive signals; returns none if the system refuses.
    pub(super) fn catch() -> Option<Self> {
        let of = |kind| signal(kind).ok();
        let kinds = [SignalKind::interrupt(), SignalKind::terminate(), SignalKind::user_defined2()];
        let [interrupt, terminate, passed_on] = kinds.map(of);
        let request = of(SignalKind::user_defined1())?;
        Some(Self { stops: [interrupt?, terminate?, passed_on?], request })
    }

    /// Raises the flag at each signal, for ever.
    pub(super) async fn watch(mut self, flag: StopFlag) {
        let [interrupt, terminate, passed_on] = &mut self.stops;
        loop {
            tokio::select! {
                _ = interrupt.recv() => flag.raise(),
                _ = terminate.recv() => flag.raise(),
                _ = passed_on.recv() => flag.raise(),
                _ = self.request.recv() => flag.checkpoint.store(true, Ordering::Relaxed),
            }
        }
    }
}

/// Lets a worker rank survive the signals that a launcher sends to all ranks: the master decides
/// when to stop.
pub fn leave_to_master() {
    for kind in [SIGINT, SIGTERM, SIGUSR1, SIGUSR2] {
        // An error means that the signal keeps its usual effect.
        let _ = signal_hook::flag::register(kind, Arc::default());
    }
}
