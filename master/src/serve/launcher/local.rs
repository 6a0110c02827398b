//! Runs as processes of this machine. Workers are threads, or ranks that `mpirun` starts, also on
//! other hosts. A run survives the service.

use super::processes::{kill_all_in, send};
use super::{LaunchOrder, LaunchState, Launcher, stop_by_socket};
use crate::run::attempt::{self, State};
use crate::run::lock::is_held;
use crate::serve::limits::Amount;
use rustix::process::Signal;
use std::fs::File;
use std::io;
use std::path::PathBuf;
use std::process::Stdio;
use tokio::process::Command;

/// Processes of this machine.
pub struct Local {
    /// Limit of what is in use at a time.
    pub limit: Amount,
    /// The program.
    pub program: PathBuf,
    /// Command that starts ranks, with `{ranks}` in place of their number; none for threads.
    pub ranks: Option<String>,
}

impl Launcher for Local {
    fn limit(&self) -> Amount {
        self.limit
    }

    fn ranks(&self) -> Option<&str> {
        self.ranks.as_deref()
    }

    fn start(&self, order: &LaunchOrder) -> Result<String, String> {
        let failed = |error: std::io::Error| format!("the run cannot be started: {error}");
        let output = File::options()
            .create(true)
            .append(true)
            .open(order.folder.output())
            .map_err(failed)?;
        let errors = output.try_clone().map_err(failed)?;
        // In a group of its own: Ctrl-C ends the service only. The runtime reaps the process.
        Command::new(&self.program)
            .args(&order.words)
            .current_dir(order.folder.path())
            .env_remove("CRUMPLE_TOKEN")
            .stdin(Stdio::null())
            .stdout(output)
            .stderr(errors)
            .process_group(0)
            .spawn()
            .map_err(failed)?;
        Ok(String::new())
    }

    fn attempt_state(&self, order: &LaunchOrder, _: &str) -> Result<LaunchState, String> {
        let state =
            attempt::read_state(&order.folder.attempt(order.attempt)).map_err(|e| e.to_string())?;
        Ok(match state {
            State::Absent => LaunchState::Waiting,
            State::Running(_) => LaunchState::Running,
            State::Ended(code) => LaunchState::Ended(code),
            // The run goes on if only its supervisor was killed.
            State::Lost | State::Withdrawn if is_held(&order.folder.results()) => {
                LaunchState::Running
            }
            State::Withdrawn => LaunchState::Waiting,
            State::Lost => LaunchState::Lost,
        })
    }

    fn stop(&self, order: &LaunchOrder, _: &str) -> Result<(), String> {
        let failed = |error: io::Error| format!("the run cannot be stopped: {error}");
        let path = order.folder.attempt(order.attempt);
        match attempt::read_state(&path).map_err(failed)? {
            State::Running(pid) if !attempt::is_stopping(&path).map_err(failed)? => {
                send(pid, Signal::TERM).map_err(failed)?;
            }
            State::Running(_) => stop_by_socket(order),
            // Only its supervisor was killed.
            _ if is_held(&order.folder.results()) => stop_by_socket(order),
            _ => {}
        }
        Ok(())
    }

    fn kill(&self, order: &LaunchOrder, _: &str) -> Result<(), String> {
        match kill_all_in(order.folder.path(), &self.program) {
            Ok(0) => Err("the run cannot be killed: it has no process on this machine".into()),
            Ok(_) => Ok(()),
            Err(error) => Err(format!("the run cannot be killed: {error}")),
        }
    }

    fn is_queued_elsewhere(&self, _: &str) -> bool {
        false
    }
}
