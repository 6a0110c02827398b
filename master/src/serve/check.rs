//! `crumple check` of a job in a process of its own, with limits of time and memory: files of users
//! cannot harm the service.

use super::folder::JobFolder;
use crate::input::findings::Findings;
use rustix::process::{Pid, Resource, Rlimit, prlimit};
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::Duration;
use tokio::process::Command;

/// Memory that a check may always reserve, also where jobs get less [MB].
const LEAST_MB: f64 = 2000.0;
/// Longest duration of a check.
const LONGEST: Duration = Duration::from_secs(300);
/// Most bytes of text that are kept.
const MOST_TEXT: usize = 1 << 20;

/// Checks a job. `most_mb` is the most memory that the check may use [MB].
pub async fn check(
    program: &Path,
    folder: &JobFolder,
    main: &str,
    sets: &[String],
    workers: u32,
    most_mb: f64,
) -> Findings {
    let refused = |why: String| Findings::refused(&why, format!("error: {why}\n"));
    let mut command = Command::new(program);
    command.arg("check").arg(format!("input/{main}")).args(["--json", "--within", "input"]);
    command.args(["--workers", &workers.to_string()]);
    command.args(sets.iter().map(|set| format!("--set={set}")));
    command.current_dir(folder.path()).env_remove("CRUMPLE_TOKEN");
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = match command.kill_on_drop(true).spawn() {
        Ok(child) => child,
        Err(error) => return refused(format!("the check cannot be started: {error}")),
    };
    if let Some(pid) = child.id().and_then(|pid| Pid::from_raw(i32::try_from(pid).ok()?)) {
        let bytes = Some((most_mb.max(LEAST_MB) * 1e6) as u64);
        // Without the limit the check still ends by its time.
        let _ = prlimit(Some(pid), Resource::As, Rlimit { current: bytes, maximum: bytes });
    }
    match tokio::time::timeout(LONGEST, child.wait_with_output()).await {
        Err(_) => refused(format!("the check took longer than {} s", LONGEST.as_secs())),
        Ok(Err(error)) => refused(format!("the check failed: {error}")),
        Ok(Ok(output)) => found(&output),
    }
}

/// Returns what the program printed, or why it printed no findings.
fn found(output: &Output) -> Findings {
    let mut found = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| {
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let named = said.lines().rev().find_map(|line| line.strip_prefix("error: "));
        match (output.status.code(), named) {
            (Some(_), Some(why)) => Findings::refused(why, said.clone()),
            (code, _) => {
                let why = match code {
                    None => "the check needs more memory than the service allows",
                    Some(_) => "the check failed",
                };
                Findings::refused(why, format!("{said}error: {why}\n"))
            }
        }
    });
    let end = (0..=MOST_TEXT.min(found.text.len())).rev().find(|&i| found.text.is_char_boundary(i));
    found.text.truncate(end.unwrap_or(0));
    found.usable &= output.status.success();
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::process::ExitStatusExt;
    use std::process::ExitStatus;

    fn ended(status: i32, stdout: &str, stderr: &str) -> Findings {
        let (stdout, stderr) = (stdout.as_bytes().to_vec(), stderr.as_bytes().to_vec());
        found(&Output { status: ExitStatus::from_raw(status), stdout, stderr })
    }

    #[test]
    fn a_check_without_findings_is_refused_with_its_last_error() {
        let said = "one\nerror: input: no such folder\nnote: more\n";
        let failed = ended(0x200, "", said);
        assert_eq!(failed.findings[0].message, "input: no such folder");
        assert_eq!(failed.text, said, "the error stands there once");
        let silent = ended(0x200, "", "");
        assert_eq!((&*silent.text, silent.usable), ("error: the check failed\n", false));
        let killed = ended(6, "{\"usable\": true", "memory allocation of 8 bytes failed\n");
        assert!(killed.findings[0].message.contains("more memory"), "{killed:?}");
        assert!(!failed.usable && !killed.usable && killed.text.starts_with("memory allocation"));
    }

    #[test]
    fn text_is_shortened_between_two_characters() {
        let long = Findings::new(true, 12.5, (&[], 0), "é".repeat(MOST_TEXT) + "a");
        let found = ended(0, &serde_json::to_string(&long).unwrap(), "");
        assert_eq!((found.text.len(), found.memory_mb, found.usable), (MOST_TEXT, 12.5, true));
    }
}
