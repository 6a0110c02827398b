//! How runs are started: on this machine, or by Slurm. Arguments are lists of words; no shell reads
//! them.

pub mod local;
mod processes;
pub mod slurm;

use super::folder::JobFolder;
use super::limits::Amount;
use crate::run::request::Request;
use crate::run::service::socket;
use std::io::{BufRead, BufReader, Write};
use std::time::Duration;

/// Longest time until a run answers.
const ANSWER_WITHIN: Duration = Duration::from_secs(2);

/// An attempt to run a job.
#[derive(Clone, Debug)]
pub struct LaunchOrder {
    /// Number of the job.
    pub id: i64,
    /// Its folder, in which the process runs.
    pub folder: JobFolder,
    /// Number of the attempt.
    pub attempt: u32,
    /// Number of workers.
    pub workers: u32,
    /// Words after `crumple`.
    pub words: Vec<String>,
}

/// Asks a run to stop through its socket. A second signal would end it at once and cut its last
/// checkpoint short; here a run that stops already only says so.
fn stop_by_socket(order: &LaunchOrder) {
    let ask = || -> std::io::Result<()> {
        let mut stream = socket::connect(&order.folder.results())?;
        stream.set_read_timeout(Some(ANSWER_WITHIN))?;
        stream.write_all(Request::Stop.to_line().as_bytes())?;
        BufReader::new(stream).read_line(&mut String::new()).map(drop)
    };
    // It may have no socket: before its first cycle, at its end, on another machine.
    let _ = ask();
}

/// State of an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaunchState {
    /// It has not begun.
    Waiting,
    /// It runs.
    Running,
    /// It has ended with this exit code.
    Ended(u8),
    /// It has ended without an exit code.
    Lost,
}

/// A way to start runs. Its functions may wait for other programs.
pub trait Launcher: Send + Sync {
    /// Returns what may be in use at a time.
    fn limit(&self) -> Amount;

    /// Returns the command that starts ranks (`crumple run --launcher`); none for threads.
    fn ranks(&self) -> Option<&str>;

    /// Starts an attempt, and returns the name by which it is found later.
    ///
    /// # Errors
    /// It cannot be started.
    fn start(&self, order: &LaunchOrder) -> Result<String, String>;

    /// Returns what became of an attempt.
    ///
    /// # Errors
    /// It is not known now.
    fn attempt_state(&self, order: &LaunchOrder, handle: &str) -> Result<LaunchState, String>;

    /// Asks a run to stop and to keep its state. It may be asked again, also by a later service.
    ///
    /// # Errors
    /// It cannot be reached.
    fn stop(&self, order: &LaunchOrder, handle: &str) -> Result<(), String>;

    /// Kills all processes of an attempt, or has them killed. It may be called again.
    ///
    /// # Errors
    /// They cannot be reached.
    fn kill(&self, order: &LaunchOrder, handle: &str) -> Result<(), String>;

    /// Returns true if an attempt that waits will run without the service.
    fn is_queued_elsewhere(&self, handle: &str) -> bool;
}
