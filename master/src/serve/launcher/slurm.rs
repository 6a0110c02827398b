//! Runs by Slurm: `sbatch`, `squeue`, `sacct` and `scancel`. The folder of the service must be on a
//! file system that all nodes share.

use super::{LaunchOrder, LaunchState, Launcher, stop_by_socket};
use crate::run::attempt::{self, State};
use crate::serve::limits::Amount;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// The batch script. It has no text of users: the words of the command are its arguments.
pub const SCRIPT: &str = "#!/bin/sh\nexec \"$@\"\n";

/// Jobs of Slurm.
pub struct Slurm {
    /// Limit of what is submitted at a time.
    pub limit: Amount,
    /// The program, on all nodes.
    pub program: PathBuf,
    /// File with [`SCRIPT`].
    pub script: PathBuf,
    /// Further options of `sbatch`, such as `--partition=crash`.
    pub options: Vec<String>,
    /// Command that starts ranks within an allocation; none for threads on one node.
    pub ranks: Option<String>,
}

impl Launcher for Slurm {
    fn limit(&self) -> Amount {
        self.limit
    }

    fn ranks(&self) -> Option<&str> {
        self.ranks.as_deref()
    }

    fn start(&self, order: &LaunchOrder) -> Result<String, String> {
        let mut command = Command::new("sbatch");
        let folder = order.folder.path();
        command.arg("--parsable").arg("--no-requeue");
        command.arg(format!("--job-name=crumple-{}", order.id));
        command.arg(format!("--chdir={}", folder.display()));
        command.arg(format!("--output={}", order.folder.output().display()));
        command.arg("--open-mode=append");
        match self.ranks {
            Some(_) => command.arg(format!("--ntasks={}", order.workers + 1)),
            None => command.arg("--ntasks=1").arg(format!("--cpus-per-task={}", order.workers)),
        };
        command.args(&self.options).arg(&self.script).arg(&self.program).args(&order.words);
        let said = output(command)?;
        let number = said.trim().split(';').next().unwrap_or_default();
        match is_number(number) {
            true => Ok(number.to_string()),
            false => Err(format!("sbatch gave no number: {said}")),
        }
    }

    fn attempt_state(&self, order: &LaunchOrder, handle: &str) -> Result<LaunchState, String> {
        let path = order.folder.attempt(order.attempt);
        let state = || attempt::read_state(&path).map_err(|error| error.to_string());
        if let State::Ended(code) = state()? {
            return Ok(LaunchState::Ended(code));
        }
        if !is_number(handle) {
            return Ok(LaunchState::Waiting);
        }
        let mut queue = Command::new("squeue");
        queue.args(["--noheader", "--states=all", "--format=%T", "--jobs", handle]);
        let seen = match output(queue) {
            Ok(said) => seen(&said),
            // Slurm forgets jobs that ended a while ago.
            Err(why) if why.contains("Invalid job id") => accounted(handle)?,
            Err(why) => return Err(why),
        };
        // The file may have arrived meanwhile.
        match (seen, state()?) {
            (LaunchState::Waiting | LaunchState::Running, _) => Ok(seen),
            (_, State::Ended(code)) => Ok(LaunchState::Ended(code)),
            _ => Ok(seen),
        }
    }

    fn stop(&self, order: &LaunchOrder, handle: &str) -> Result<(), String> {
        if !is_number(handle) {
            return Ok(());
        }
        let path = order.folder.attempt(order.attempt);
        if attempt::is_stopping(&path).map_err(|e| e.to_string())? {
            stop_by_socket(order);
            return Ok(());
        }
        let begun = attempt::read_state(&path).map_err(|e| e.to_string())?;
        let mut command = Command::new("scancel");
        if matches!(begun, State::Running(_)) {
            // Only to the batch script, which is the supervisor of the run.
            command.args(["--batch", "--signal=TERM"]);
        }
        output(command_with(command, handle)).map(drop)
    }

    fn kill(&self, _: &LaunchOrder, handle: &str) -> Result<(), String> {
        if !is_number(handle) {
            return Ok(());
        }
        // Slurm sends TERM, and KILL after its KillWait.
        output(command_with(Command::new("scancel"), handle)).map(drop)
    }

    fn is_queued_elsewhere(&self, handle: &str) -> bool {
        is_number(handle)
    }
}

/// Returns what a state of Slurm means.
fn seen(state: &str) -> LaunchState {
    match state.split_whitespace().next().unwrap_or_default() {
        "PENDING" | "CONFIGURING" | "REQUEUED" | "SUSPENDED" => LaunchState::Waiting,
        "RUNNING" | "COMPLETING" | "SIGNALING" | "STAGE_OUT" => LaunchState::Running,
        "CANCELLED" | "CANCELLED+" => LaunchState::Ended(crumple_proto::exit_code::STOPPED),
        _ => LaunchState::Lost,
    }
}

/// Returns what became of a job that the queue has forgotten. Many clusters keep no accounts.
fn accounted(handle: &str) -> Result<LaunchState, String> {
    let mut accounts = Command::new("sacct");
    accounts.args(["--noheader", "--allocations", "--parsable2", "--format=State"]);
    accounts.args(["--jobs", handle]);
    match output(accounts) {
        Ok(said) => Ok(seen(&said)),
        Err(why) if why.contains("is disabled") => Ok(LaunchState::Lost),
        Err(why) => Err(why),
    }
}

fn command_with(mut command: Command, word: &str) -> Command {
    command.arg(word);
    command
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.len() < 20 && text.bytes().all(|b| b.is_ascii_digit())
}

/// Runs a program and returns its output.
fn output(mut command: Command) -> Result<String, String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let ended =
        command.stdin(Stdio::null()).output().map_err(|error| format!("{name}: {error}"))?;
    match ended.status.success() {
        true => Ok(String::from_utf8_lossy(&ended.stdout).into_owned()),
        false => Err(format!("{name}: {}", String::from_utf8_lossy(&ended.stderr).trim())),
    }
}
