//! Processes of this machine, by the numbers of Linux.

use rustix::process::{Pid, Signal, kill_process};
use std::fs;
use std::io;

/// Sends a signal to a process; one that does not exist is no error.
///
/// # Errors
/// It is not allowed.
pub fn send(pid: u32, signal: Signal) -> io::Result<()> {
    match i32::try_from(pid).ok().and_then(Pid::from_raw).map(|pid| kill_process(pid, signal)) {
        None | Some(Ok(()) | Err(rustix::io::Errno::SRCH)) => Ok(()),
        Some(Err(error)) => Err(error.into()),
    }
}

/// Kills a process and all that it has started, itself first: it could start others.
///
/// # Errors
/// It is not allowed.
pub fn kill_tree(pid: u32) -> io::Result<()> {
    tree(pid).into_iter().try_for_each(|pid| send(pid, Signal::KILL))
}

/// Returns a process and all that it has started.
fn tree(pid: u32) -> Vec<u32> {
    let mut all = vec![pid];
    let mut at = 0;
    while let Some(&pid) = all.get(at) {
        all.extend(children(pid));
        at += 1;
    }
    all
}

/// Returns what the threads of a process have started.
fn children(pid: u32) -> Vec<u32> {
    let threads = fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten();
    let lists =
        threads.filter_map(|thread| fs::read_to_string(thread.path().join("children")).ok());
    lists
        .flat_map(|list| list.split_whitespace().filter_map(|n| n.parse().ok()).collect::<Vec<_>>())
        .collect()
}
