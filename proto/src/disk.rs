//! Watch over operations on files. An operation on a file system that hangs blocks its thread for
//! ever, and nothing can end it: so another thread reports it, and ends the process if it takes too
//! long.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, Once, PoisonError};
use std::time::{Duration, Instant};

/// Time after which there is a warning [ms].
static PATIENCE_MS: AtomicU64 = AtomicU64::new(60_000);
/// Time after which the process ends, over that of the warning.
const LIMIT: u32 = 10;
/// Longest interval between two looks.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// Exit code for results that cannot be written.
const UNWRITTEN: i32 = 2;

/// An operation that has not ended.
struct Open {
    number: u64,
    path: PathBuf,
    began: Instant,
    warned: bool,
}

static OPEN: Mutex<Vec<Open>> = Mutex::new(Vec::new());
static NUMBER: AtomicU64 = AtomicU64::new(0);
static WATCH: Once = Once::new();

/// Sets the time after which there is a warning; after ten times as long the process ends.
pub fn set_patience(patience: Duration) {
    let ms = u64::try_from(patience.as_millis()).unwrap_or(u64::MAX);
    PATIENCE_MS.store(ms.max(1), Ordering::Relaxed);
}

/// Carries out an operation on a file, under watch. If it takes longer than the time of
/// [`set_patience`], there is a warning with the path on standard error; after ten times as long
/// the process ends with exit code 2.
pub fn watched<T>(path: &Path, operation: impl FnOnce() -> T) -> T {
    WATCH.call_once(|| {
        // Without the thread, the operation has no limit.
        let _ = std::thread::Builder::new().name("disk watch".into()).spawn(watch);
    });
    let _open = Ticket::new(path);
    operation()
}

/// Counts an operation as ended when it is dropped, also if it panics.
struct Ticket(u64);

impl Ticket {
    fn new(path: &Path) -> Self {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let open = Open { number, path: path.to_owned(), began: Instant::now(), warned: false };
        OPEN.lock().unwrap_or_else(PoisonError::into_inner).push(open);
        Self(number)
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        OPEN.lock().unwrap_or_else(PoisonError::into_inner).retain(|open| open.number != self.0);
    }
}

fn watch() {
    loop {
        let patience = Duration::from_millis(PATIENCE_MS.load(Ordering::Relaxed));
        std::thread::sleep((patience / 4).min(LOOK_EVERY));
        // Nothing is printed under the lock: standard error may be on the same file system.
        if let Some((what, ends)) = next_message(patience) {
            eprintln!("{what}");
            if ends {
                std::process::exit(UNWRITTEN);
            }
        }
    }
}

/// Returns a warning about an operation, once for each, or an error and true.
fn next_message(patience: Duration) -> Option<(String, bool)> {
    let mut all = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
    let limit = patience.saturating_mul(LIMIT);
    all.iter_mut().find_map(|open| {
        let (path, waited) = (open.path.display(), open.began.elapsed());
        let what =
            format!("{path}: no answer of the file system for {:.0} s", waited.as_secs_f64());
        if waited > limit {
            let error = format!(
                "error: {what}: it hangs, and the run ends; continue with --resume, or choose \
                 another folder with --out"
            );
            return Some((error, true));
        }
        let warns = waited > patience && !std::mem::replace(&mut open.warned, true);
        let limit = limit.as_secs_f64();
        let warning = || format!("warning: {what}; the run waits for it, at most {limit:.0} s");
        warns.then(|| (warning(), false))
    })
}
