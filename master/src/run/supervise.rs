//! `crumple run --retries N`: runs the job in a process of its own and starts it again from the
//! newest checkpoint when it is lost.

use crate::cli::RunArgs;
use crate::input::job::Report;
use crate::run::attempt::Attempt;
use crate::run::checkpoint::find::{DIR, folders, occupied, run_folder};
use crate::run::checkpoint::manifest::{MANIFEST, Manifest};
use crate::run::service::Service;
use crate::run::service::signals::{Manner, StopFlag};
use crumple_proto::disk::watched;
use crumple_proto::exit_code::{BAD_INPUT, COMPLETED, FAILED, STOPPED, UNMET, WORKER_LOST};
use rustix::process::{Pid, Signal, kill_process, kill_process_group};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant, SystemTime};

/// Interval between two looks at the process.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// Requests to stop within this time count as one: Ctrl-C reaches `deploy/run.sh`, which passes it
/// on, and also the supervisor itself.
const ONE_REQUEST: Duration = Duration::from_secs(1);
/// Exit codes that a run chooses itself: it ended as it should. All others are losses.
const ENDED: [u8; 4] = [COMPLETED, BAD_INPUT, FAILED, STOPPED];

/// Word of a launcher that stands for the number of ranks.
const RANKS: &str = "{ranks}";

/// The checkpoints that were there before a supervised run: files, with the times at which they
/// were written. They may be of another run, or later than the one from which this run continues.
struct Earlier(Vec<(PathBuf, Option<SystemTime>)>);

impl Earlier {
    fn new(out: &Path) -> Self {
        let all = || folders(&out.join(DIR)).iter().map(|folder| manifest_of(folder)).collect();
        Self(watched(out, all))
    }

    /// Returns the cycle of the newest checkpoint that the run itself has written.
    fn newest_other(&self, out: &Path) -> Option<u64> {
        let is_own = |folder: &PathBuf| !self.0.contains(&manifest_of(folder));
        let cycle = |folder: PathBuf| Some(Manifest::read(&folder).ok()?.captured.cycle);
        watched(out, || folders(&out.join(DIR)).into_iter().filter(is_own).find_map(cycle))
    }
}

fn manifest_of(folder: &Path) -> (PathBuf, Option<SystemTime>) {
    let path = folder.join(MANIFEST);
    let written = modified(&path);
    (path, written)
}

/// Runs the job, at most `retries` times more than once. Returns the exit code of the last run. The
/// file of the attempt notes a request to stop.
pub fn run(args: &RunArgs, retries: u32, attempt: Option<&Attempt>) -> u8 {
    let out = match args.resume.as_ref().map_or_else(|| Ok(args.out_dir()), |dir| run_folder(dir)) {
        Ok(out) => out,
        Err(why) => {
            eprintln!("error: {why}");
            return Report::EXIT_CODE;
        }
    };
    let service = Service::start(Manner::Patient);
    let stop = service.stop();
    let mut supervised = Supervised::new(args, out);
    for lost in 0..=retries {
        let (how, has_begun) = match supervised.run_once(stop, attempt) {
            Ok(End::Code(code)) => return code,
            Ok(End::Lost { how, has_begun }) => (how, has_begun),
            Err(error) => {
                eprintln!("error: the run cannot be started or watched: {error}");
                return Report::EXIT_CODE;
            }
        };
        if stop.is_raised() && !has_begun {
            return STOPPED; // before its first cycle it has nothing to keep
        }
        supervised.note_loss();
        if stop.is_raised() {
            eprintln!("error: the run was lost ({how}) while it stopped");
            supervised.show_way_on();
            return WORKER_LOST;
        }
        if lost == retries {
            let times = if lost == 0 { "once".to_string() } else { format!("{} times", lost + 1) };
            eprintln!("error: the run was lost ({how}) {times}; no retry is left");
            supervised.show_way_on();
        } else if !supervised.prepare_retry(&how) {
            return WORKER_LOST;
        }
    }
    WORKER_LOST
}

/// End of one process of the run.
enum End {
    /// The run ended as it should, with this exit code.
    Code(u8),
    /// The run was lost: exit code or signal, and whether it had begun to write its log.
    Lost { how: String, has_begun: bool },
}

/// A run that starts again when it is lost.
struct Supervised<'a> {
    args: &'a RunArgs,
    out: PathBuf,
    earlier: Earlier,
    workers: usize,
    /// Cycle of the newest checkpoint that the run has written. Without one, the run starts again
    /// as at first, with all changes.
    own: Option<u64>,
    /// Losses in a row without a new checkpoint.
    in_vain: u32,
    /// True if the folder had no results before the first start: those that are there later are of
    /// this run.
    was_free: bool,
}

impl<'a> Supervised<'a> {
    fn new(args: &'a RunArgs, out: PathBuf) -> Self {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let threads = args.options.threads.unwrap_or(1);
        let workers = args.options.workers.unwrap_or_else(|| (cores() / threads).max(1));
        let earlier = Earlier::new(&out);
        let was_free = watched(&out, || occupied(&out)).is_none();
        Self { args, earlier, out, workers, own: None, in_vain: 0, was_free }
    }

    /// Starts the run and waits for its end or its loss.
    fn run_once(&self, stop: &StopFlag, attempt: Option<&Attempt>) -> std::io::Result<End> {
        let before = summary_of(&self.out).map(|(written, _)| written);
        // Times of the file system alone: its clock may differ from that of this machine.
        let log = self.out.join("log.jsonl");
        let logged = modified(&log);
        let has_begun = || modified(&log) != logged;
        let child = self.start()?;
        // Launchers of MPI end their ranks at TERM, but pass on USR2.
        let to_stop = if self.args.launcher.is_some() { Signal::USR2 } else { Signal::TERM };
        let asked = || attempt.into_iter().for_each(Attempt::note_stop);
        let status = wait(child, stop, to_stop, has_begun, asked)?;
        let code = status.code();
        let code_of_run = code.and_then(|code| u8::try_from(code).ok());
        if let Some(code) = code_of_run.filter(|code| ENDED.contains(code)) {
            return Ok(End::Code(code));
        }
        // A launcher that was interrupted has its own code, often that of a requirement that is not
        // met. The summary has the end of the run.
        if let Some((written, text)) = summary_of(&self.out)
            && Some(written) != before
        {
            if text.contains("\"status\": \"stopped\"") {
                return Ok(End::Code(STOPPED));
            }
            if text.contains("\"is_met\": false") {
                return Ok(End::Code(UNMET));
            }
        }
        let how = match (code, status.signal()) {
            (Some(code), _) => format!("exit code {code}"),
            (None, signal) => format!("signal {}", signal.unwrap_or_default()),
        };
        Ok(End::Lost { how, has_begun: has_begun() })
    }

    /// Starts the run by the launcher, if one is given: from its own newest checkpoint if it has
    /// one, otherwise as the user asked for it.
    fn start(&self) -> std::io::Result<Child> {
        let (args, out, workers) = (self.args, &self.out, self.workers);
        let program = std::env::current_exe()?;
        let ranks = (workers + 1).to_string();
        let launcher = args.launcher.as_deref().unwrap_or_default().replace(RANKS, &ranks);
        let mut words: Vec<&str> = launcher.split_whitespace().collect();
        let mut command = if words.is_empty() {
            Command::new(&program)
        } else {
            let mut command = Command::new(words.remove(0));
            command.args(words).arg(&program);
            command
        };
        command.arg("run");
        command.args(args.job.iter());
        let own = self.own.map(|_| out.as_path());
        if let Some(from) = own.or(args.resume.as_deref()) {
            command.arg("--resume").arg(from);
        } else {
            command.arg("--out").arg(out);
            command.args((args.overwrite || self.was_free).then_some("--overwrite"));
        }
        if let Some(workers) = args.options.workers.filter(|_| !has_ranks(args)) {
            command.args(["--workers", &workers.to_string()]);
        }
        command.args(args.passed_on(own.is_some()));
        // In a group of its own: Ctrl-C would reach it directly too, and a launcher that gets two
        // signals ends its ranks at once.
        command.stdin(Stdio::null()).process_group(0).spawn()
    }

    /// Finds the newest checkpoint of the run, and counts losses without a new one.
    fn note_loss(&mut self) {
        let newest = self.earlier.newest_other(&self.out);
        self.in_vain = if newest > self.own { 0 } else { self.in_vain + 1 };
        self.own = newest;
    }

    /// Prepares the next start, with fewer workers after losses without a new checkpoint, if the
    /// launcher allows it. Returns false if the next start would be as much in vain.
    fn prepare_retry(&mut self, how: &str) -> bool {
        let cycle = match (self.own, &self.args.resume) {
            (Some(cycle), _) => format!("cycle {cycle}"),
            (None, Some(dir)) => dir.display().to_string(),
            (None, None) => "the start".to_string(),
        };
        let mut next = format!("it continues from {cycle}");
        if self.in_vain > 1 {
            if self.workers <= 1 || !has_ranks(self.args) {
                eprintln!(
                    "error: the run was lost again ({how}) without a new checkpoint after {cycle}"
                );
                return false;
            }
            (self.workers, self.in_vain) = (self.workers / 2, 0);
            next += &format!(", with {} workers: a host may have failed", self.workers);
        }
        eprintln!("warning: the run was lost ({how}); {next}");
        true
    }

    /// Prints the command that continues the run: from its own newest checkpoint, or as it began.
    fn show_way_on(&self) {
        let own = self.own.map(|_| self.out.as_path());
        if let Some(from) = own.or(self.args.resume.as_deref()) {
            eprintln!("  continue with: crumple run --resume {}", from.display());
        }
    }
}

/// Returns the time and the text of the summary in a folder.
fn summary_of(out: &Path) -> Option<(SystemTime, String)> {
    let path = out.join("summary.json");
    Some((modified(&path)?, std::fs::read_to_string(path).ok()?))
}

/// Returns the time at which a file was last written.
fn modified(path: &Path) -> Option<SystemTime> {
    path.metadata().and_then(|m| m.modified()).ok()
}

/// Returns true if the launcher takes any number of ranks.
fn has_ranks(args: &RunArgs) -> bool {
    args.launcher.as_ref().is_some_and(|launcher| launcher.contains(RANKS))
}

/// Waits for the end of the run. Passes on requests to stop: the first as the signal `to_stop`,
/// the second as TERM, at which launchers of MPI end their ranks, all others as KILL to the group
/// of the process. In its first moments a launcher does not pass on signals: they would end it, and
/// leave its ranks behind. So before the run `has_begun`, the first request is TERM too, and a
/// request for a checkpoint waits. `asked` is called at each request to stop.
fn wait(
    mut child: Child,
    stop: &StopFlag,
    to_stop: Signal,
    has_begun: impl Fn() -> bool,
    asked: impl Fn(),
) -> std::io::Result<ExitStatus> {
    let (mut seen, mut passed_on, mut last) = (0, 0, None::<Instant>);
    let pid = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
    let send = |signal| {
        if let Some(pid) = pid {
            // It may have ended meanwhile.
            let _ = kill_process(pid, signal);
        }
    };
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        let stops = stop.stops();
        if stops > std::mem::replace(&mut seen, stops)
            && last.is_none_or(|last| last.elapsed() > ONE_REQUEST)
        {
            last = Some(Instant::now());
            passed_on += 1;
            asked();
            match (passed_on, pid) {
                (1, _) if has_begun() => send(to_stop),
                (1 | 2, _) => send(Signal::TERM),
                (_, Some(pid)) => drop(kill_process_group(pid, Signal::KILL)),
                _ => {}
            }
        }
        if stop.is_requested() && has_begun() && stop.take_request() {
            send(Signal::USR1);
        }
        std::thread::sleep(LOOK_EVERY);
    }
}
