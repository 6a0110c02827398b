//! Signals. Ctrl-C, TERM and USR2: the first one asks all workers to stop and to keep their state,
//! the second ends the process at once; a supervisor passes them on (`supervise.rs`). USR1 requests
//! a checkpoint. Launchers of MPI end the ranks at Ctrl-C and TERM, but pass on USR1 and USR2.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};
use tokio::signal::unix::{SignalKind, signal};

/// The effect of a request to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Manner {
    /// It ends the process: there is no state yet.
    AtOnce,
    /// It raises the flag; the next one ends the process.
    Orderly,
    /// It raises the flag. Ranks that wait for the master's order receive signals of the launcher
    /// together with it.
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
    /// Listens for signals on its own thread.
    pub fn listen(manner: Manner) -> Self {
        let flag = Self::default();
        flag.set_manner(manner);
        let (raised, (ready, is_ready)) = (flag.clone(), std::sync::mpsc::channel());
        std::thread::spawn(move || {
            let Ok(runtime) = tokio::runtime::Builder::new_current_thread().enable_io().build()
            else {
                return;
            };
            runtime.block_on(async {
                let signals = (signal(SignalKind::interrupt()), signal(SignalKind::terminate()));
                let (Ok(mut interrupt), Ok(mut terminate)) = signals else { return };
                let signals =
                    (signal(SignalKind::user_defined1()), signal(SignalKind::user_defined2()));
                let (Ok(mut request), Ok(mut passed_on)) = signals else { return };
                let _ = ready.send(());
                loop {
                    tokio::select! {
                        _ = interrupt.recv() => {}
                        _ = terminate.recv() => {}
                        _ = passed_on.recv() => {}
                        _ = request.recv() => {
                            raised.checkpoint.store(true, Ordering::Relaxed);
                            continue;
                        }
                    }
                    let again = raised.stops.fetch_add(1, Ordering::Relaxed) > 0;
                    let manner = raised.manner.load(Ordering::Relaxed);
                    if manner == Manner::AtOnce as u8 || (again && manner == Manner::Orderly as u8)
                    {
                        std::process::exit(130);
                    }
                }
            });
        });
        // An error means that the thread has ended: signals keep their usual effect.
        let _ = is_ready.recv();
        flag
    }

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
}
