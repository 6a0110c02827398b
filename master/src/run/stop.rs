//! Signals. Ctrl-C: the first one asks all workers to stop and to keep their state, the second ends
//! the process at once. USR1 requests a checkpoint.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tokio::signal::unix::{SignalKind, signal};

/// Flags that are raised by an interrupt or a request to terminate, and by a request for a
/// checkpoint.
#[derive(Clone, Debug, Default)]
pub struct StopFlag {
    stop: Arc<AtomicBool>,
    checkpoint: Arc<AtomicBool>,
}

impl StopFlag {
    /// Listens for signals on its own thread. With `stubborn`, further signals do not end the
    /// process: ranks that wait for the master's order receive signals of the launcher together
    /// with it.
    pub fn listen(stubborn: bool) -> Self {
        let flag = Self::default();
        let raised = flag.clone();
        std::thread::spawn(move || {
            let Ok(runtime) = tokio::runtime::Builder::new_current_thread().enable_io().build()
            else {
                return;
            };
            runtime.block_on(async {
                let signals = (signal(SignalKind::interrupt()), signal(SignalKind::terminate()));
                let (Ok(mut interrupt), Ok(mut terminate)) = signals else { return };
                let Ok(mut request) = signal(SignalKind::user_defined1()) else { return };
                loop {
                    tokio::select! {
                        _ = interrupt.recv() => {}
                        _ = terminate.recv() => {}
                        _ = request.recv() => {
                            raised.checkpoint.store(true, Ordering::Relaxed);
                            continue;
                        }
                    }
                    if raised.stop.swap(true, Ordering::Relaxed) && !stubborn {
                        std::process::exit(130);
                    }
                }
            });
        });
        flag
    }

    /// Returns true if the flag is raised.
    pub fn is_raised(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Returns true if a checkpoint was requested since the last call.
    pub fn take_request(&self) -> bool {
        self.checkpoint.swap(false, Ordering::Relaxed)
    }
}
