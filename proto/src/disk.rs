//! Watch over operations on files. An operation on a file system that hangs blocks its thread for
//! ever, and nothing can end it: so another thread reports it, and ends the process if it takes too
//! long. That is also the end of a program that embeds the engine and uses this watch.

use crate::exit_code;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, Once, PoisonError};
use std::thread::{Builder, sleep};
use std::time::{Duration, Instant};

/// Time after which there is a warning [ms].
static PATIENCE_MS: AtomicU64 = AtomicU64::new(60_000);
/// Time after which the process ends, over that of the warning.
const LIMIT: u32 = 10;
/// Longest interval between two looks.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// Time for the last message before the process ends.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// An operation that has not ended.
struct Operation {
    number: u64,
    path: PathBuf,
    began: Instant,
    warned: bool,
}

static RUNNING: Mutex<Vec<Operation>> = Mutex::new(Vec::new());
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
        let _ = Builder::new().name("disk watch".into()).spawn(watch);
    });
    let _ticket = Ticket::new(path);
    operation()
}

/// A file on which every operation is under watch, as by [`watched`].
#[derive(Debug)]
pub struct WatchedFile {
    path: PathBuf,
    file: File,
}

impl WatchedFile {
    /// Opens a file by `open`, which gets the path.
    ///
    /// # Errors
    /// Those of `open`.
    pub fn open(path: &Path, open: impl FnOnce(&Path) -> io::Result<File>) -> io::Result<Self> {
        let file = watched(path, || open(path))?;
        Ok(Self { path: path.to_owned(), file })
    }
}

/// Several threads may write to the same file.
impl Write for &WatchedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        watched(&self.path, || (&self.file).write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        watched(&self.path, || (&self.file).flush())
    }
}

impl Read for WatchedFile {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        watched(&self.path, || (&self.file).read(bytes))
    }
}

impl Write for WatchedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        (&*self).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        (&*self).flush()
    }
}

/// Counts an operation as ended when it is dropped, also if it panics.
struct Ticket(u64);

impl Ticket {
    fn new(path: &Path) -> Self {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let (path, began) = (path.to_owned(), Instant::now());
        let operation = Operation { number, path, began, warned: false };
        RUNNING.lock().unwrap_or_else(PoisonError::into_inner).push(operation);
        Self(number)
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        RUNNING.lock().unwrap_or_else(PoisonError::into_inner).retain(|o| o.number != self.0);
    }
}

fn watch() {
    loop {
        let patience = Duration::from_millis(PATIENCE_MS.load(Ordering::Relaxed));
        sleep((patience / 4).min(LOOK_EVERY));
        if let Some((what, ends)) = next_message(patience) {
            print(what);
            if ends {
                sleep(LAST_WORDS);
                std::process::exit(i32::from(exit_code::BAD_INPUT));
            }
        }
    }
}

/// Prints on a thread of its own: standard error may be on the same file system, and hang or fail.
fn print(what: String) {
    let body = move || {
        let _ = writeln!(std::io::stderr(), "{what}");
    };
    // Without the thread there is no message; the watch goes on.
    let _ = Builder::new().name("disk message".into()).spawn(body);
}

/// Returns a warning about an operation, once for each, or an error and true.
fn next_message(patience: Duration) -> Option<(String, bool)> {
    let mut all = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
    let limit = patience.saturating_mul(LIMIT);
    all.iter_mut().find_map(|operation| {
        let (path, waited) = (operation.path.display(), operation.began.elapsed());
        let what =
            format!("{path}: no answer of the file system for {:.0} s", waited.as_secs_f64());
        if waited > limit {
            let error = format!(
                "error: {what}: it hangs, and the program ends; a run that is not complete \
                 continues with --resume, or starts again in another folder with --out"
            );
            return Some((error, true));
        }
        let warns = waited > patience && !std::mem::replace(&mut operation.warned, true);
        let limit = limit.as_secs_f64();
        let warning = || format!("warning: {what}; the run waits for it, at most {limit:.0} s");
        warns.then(|| (warning(), false))
    })
}
