//! `crumple run --retries N`: runs the job in a process of its own and starts it again from the
//! newest checkpoint when it is lost.

use crate::cli::RunArgs;
use crate::input::job::Report;
use crate::run::checkpoint::find::{newest_cycle, run_folder};
use crate::run::stop::StopFlag;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::time::Duration;

/// Interval between two looks at the process.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// Exit code of a run that has lost a worker.
const WORKER_LOST: u8 = 4;
/// Exit codes that a run chooses itself: it ended as it should. All others are losses.
const ENDED: [i32; 4] = [0, 2, 3, 130];

/// Runs the job, at most `retries` times more than once. Returns the exit code of the last run.
pub fn run(args: &RunArgs, retries: u32) -> u8 {
    // Later runs continue from the newest checkpoint of the run, also if a single one is given.
    let out = match &args.resume {
        None => args.out_dir(),
        Some(dir) => match run_folder(dir) {
            Ok(out) => out,
            Err(why) => {
                eprintln!("error: {why}");
                return Report::EXIT_CODE;
            }
        },
    };
    let stop = StopFlag::listen(true);
    let mut reached = if args.resume.is_some() { newest_cycle(&out) } else { None };
    let mut continues = args.resume.is_some();
    for lost in 0..=retries {
        let from = args.resume.as_ref().filter(|_| lost == 0).unwrap_or(&out);
        let folder = if continues { from } else { &out };
        let ended = start(args, folder, continues).and_then(|child| wait(child, &stop));
        let status = match ended {
            Ok(status) => status,
            Err(error) => {
                eprintln!("error: the run cannot be started or watched: {error}");
                return Report::EXIT_CODE;
            }
        };
        let code = status.code();
        if let Some(code) = code.filter(|code| ENDED.contains(code)) {
            return code as u8;
        }
        if stop.is_raised() {
            return 130;
        }
        let what = match (code, status.signal()) {
            (Some(code), _) => format!("exit code {code}"),
            (None, signal) => format!("signal {}", signal.unwrap_or_default()),
        };
        let newest = newest_cycle(&out);
        let cycle = newest.map_or("the start".to_string(), |cycle| format!("cycle {cycle}"));
        if lost == retries {
            eprintln!("error: the run was lost ({what}) {} times; no retry is left", lost + 1);
        } else if lost > 0 && newest <= reached {
            eprintln!(
                "error: the run was lost again ({what}) without a new checkpoint after {cycle}"
            );
            return WORKER_LOST;
        } else {
            eprintln!("warning: the run was lost ({what}); it continues from {cycle}");
        }
        (reached, continues) = (newest, newest.is_some());
    }
    WORKER_LOST
}

/// Starts the run by the launcher, if one is given.
fn start(args: &RunArgs, out: &Path, continues: bool) -> std::io::Result<Child> {
    let program = std::env::current_exe()?;
    let mut words: Vec<&str> =
        args.launcher.iter().flat_map(|launcher| launcher.split_whitespace()).collect();
    let mut command = if words.is_empty() {
        Command::new(&program)
    } else {
        let mut command = Command::new(words.remove(0));
        command.args(words).arg(&program);
        command
    };
    command.arg("run");
    command.args(args.job.iter());
    if continues {
        command.arg("--resume").arg(out);
    } else {
        command.arg("--out").arg(out);
    }
    command.args(args.passed_on(continues && args.resume.is_none()));
    command.spawn()
}

/// Waits for the end of the run. Passes on a request to stop.
fn wait(mut child: Child, stop: &StopFlag) -> std::io::Result<ExitStatus> {
    let mut asked = false;
    let pid = i32::try_from(child.id()).ok().and_then(rustix::process::Pid::from_raw);
    let send = |signal| {
        if let Some(pid) = pid {
            // It may have ended meanwhile.
            let _ = rustix::process::kill_process(pid, signal);
        }
    };
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if stop.is_raised() && !asked {
            asked = true;
            send(rustix::process::Signal::TERM);
        }
        if stop.take_request() {
            send(rustix::process::Signal::USR1);
        }
        std::thread::sleep(LOOK_EVERY);
    }
}
