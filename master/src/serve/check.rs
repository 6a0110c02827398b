//! `crumple check` of a job in a process of its own, with limits of time and memory: files of users
//! cannot harm the service.

use super::folder::JobFolder;
use rustix::process::{Pid, Resource, Rlimit, prlimit};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;
use tokio::process::Command;

/// Memory that a check may always reserve, also where jobs get less [MB].
const LEAST_MB: f64 = 2000.0;
/// Longest duration of a check.
const LONGEST: Duration = Duration::from_secs(300);
/// Most bytes of text that are kept.
const MOST_TEXT: usize = 1 << 20;

/// Result of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// True if the job can run.
    pub usable: bool,
    /// Output of the check.
    pub text: String,
    /// Estimated memory [MB].
    pub memory_mb: f64,
}

/// Checks a job. `most_mb` is the most memory that the check may use [MB].
pub async fn check(
    program: &Path,
    folder: &JobFolder,
    main: &str,
    sets: &[String],
    workers: u32,
    most_mb: f64,
) -> Checked {
    let refused = |text: String| Checked { usable: false, text, memory_mb: 0.0 };
    let mut command = Command::new(program);
    command.arg("check").arg(format!("input/{main}")).args(["--within", "input"]);
    command.args(["--workers", &workers.to_string()]);
    command.args(sets.iter().map(|set| format!("--set={set}")));
    command.current_dir(folder.path()).env_remove("CRUMPLE_TOKEN");
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = match command.kill_on_drop(true).spawn() {
        Ok(child) => child,
        Err(error) => return refused(format!("error: the check cannot be started: {error}\n")),
    };
    if let Some(pid) = child.id().and_then(|pid| Pid::from_raw(i32::try_from(pid).ok()?)) {
        let bytes = Some((most_mb.max(LEAST_MB) * 1e6) as u64);
        // Without the limit the check still ends by its time.
        let _ = prlimit(Some(pid), Resource::As, Rlimit { current: bytes, maximum: bytes });
    }
    match tokio::time::timeout(LONGEST, child.wait_with_output()).await {
        Err(_) => refused(format!("error: the check took longer than {} s\n", LONGEST.as_secs())),
        Ok(Err(error)) => refused(format!("error: the check failed: {error}\n")),
        Ok(Ok(output)) => {
            let mut text = String::from_utf8_lossy(&output.stdout).into_owned();
            text += &String::from_utf8_lossy(&output.stderr);
            if output.status.code().is_none() {
                text += "error: the check needs more memory than the service allows\n";
            }
            let memory_mb = memory(&text).unwrap_or(0.0);
            let end = (0..=MOST_TEXT.min(text.len())).rev().find(|&i| text.is_char_boundary(i));
            text.truncate(end.unwrap_or(0));
            Checked { usable: output.status.success(), text, memory_mb }
        }
    }
}

/// Returns the total of the estimate in the text of a check [MB].
fn memory(text: &str) -> Option<f64> {
    let total = text.lines().find_map(|line| line.strip_prefix("  total: "))?;
    total.split(" MB").next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimate_is_read_from_the_text() {
        let text = "memory\n  total: 12.5 MB with 0.1 MB of the master, 6.2 MB per worker of 2\n";
        assert_eq!(memory(text), Some(12.5));
        assert_eq!(memory("total: 3 MB\n"), None);
    }
}
