//! Processes of this machine, by the files of Linux.

use rustix::process::{Pid, Signal, kill_process};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;

/// Number of times that the processes of a folder are looked for: a process may begin another one
/// before it gets the signal.
const LOOKS: usize = 20;

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

/// Kills the processes of this machine that run a program in a folder, and all that they have
/// begun. Returns their number.
///
/// # Errors
/// It is not allowed, or the processes cannot be listed.
pub fn kill_all_in(folder: &Path, program: &Path) -> io::Result<usize> {
    let mut killed = Vec::new();
    for _ in 0..LOOKS {
        let own = family(folder, program)?;
        let more: Vec<u32> = own.into_iter().filter(|pid| !killed.contains(pid)).collect();
        if more.is_empty() {
            break;
        }
        // A stopped process begins no other one.
        more.iter().try_for_each(|&pid| send(pid, Signal::STOP))?;
        killed.extend(more);
    }
    killed.iter().try_for_each(|&pid| send(pid, Signal::KILL))?;
    Ok(killed.len())
}

/// Returns the processes that run a program in a folder, and all that they have begun.
fn family(folder: &Path, program: &Path) -> io::Result<Vec<u32>> {
    let folder = folder.canonicalize()?;
    let name = program.file_name().map(|name| name.to_string_lossy().into_owned());
    let name = name.unwrap_or_default();
    let is_own = |pid: u32| {
        let link = |of: &str| fs::read_link(format!("/proc/{pid}/{of}")).ok();
        // A program that was replaced meanwhile has a word after its name.
        let runs = link("exe").and_then(|exe| Some(exe.file_name()?.to_str()?.starts_with(&name)));
        link("cwd").is_some_and(|cwd| cwd == folder) && runs == Some(true)
    };
    let mut all = Vec::new();
    let mut begun: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for entry in fs::read_dir("/proc")?.flatten() {
        let Some(pid) = entry.file_name().to_str().and_then(|name| name.parse().ok()) else {
            continue;
        };
        if let Some(parent) = parent(pid) {
            begun.entry(parent).or_default().push(pid);
        }
        if is_own(pid) {
            all.push(pid);
        }
    }
    let mut at = 0;
    while let Some(pid) = all.get(at) {
        let more = begun.remove(pid).unwrap_or_default();
        all.extend(more.into_iter().filter(|pid| !all.contains(pid)).collect::<Vec<_>>());
        at += 1;
    }
    Ok(all)
}

/// Returns the process that has begun another one; none if that has ended.
fn parent(pid: u32) -> Option<u32> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name of the program, in brackets, may have any characters.
    let mut words = stat.rsplit_once(')')?.1.split_whitespace();
    let is_zombie = words.next()? == "Z";
    let parent = words.next()?.parse().ok()?;
    (!is_zombie).then_some(parent)
}
