//! Ctrl-C: the first one asks all workers to stop and to keep their state, the second ends the
//! process at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tokio::signal::unix::{SignalKind, signal};

/// Flag that is raised by an interrupt or a request to terminate.
#[derive(Clone, Debug, Default)]
pub struct StopFlag(Arc<AtomicBool>);

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
                loop {
                    tokio::select! { _ = interrupt.recv() => {}, _ = terminate.recv() => {} }
                    if raised.0.swap(true, Ordering::Relaxed) && !stubborn {
                        std::process::exit(130);
                    }
                }
            });
        });
        flag
    }

    /// Returns true if the flag is raised.
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
