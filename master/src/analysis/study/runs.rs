//! Runs every point as a process of its own. A crash then affects only one point, and CPU times
//! are those of the point alone.

use super::grid::{Point, StudyPlan};
use super::spec::Study;
use crate::results::quantity::{self, RunResults};
use crate::run::service::signals::StopFlag;
use crumple_proto::exit_code::UNMET;
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Deserialize, Serialize};
use std::collections::{HashSet, VecDeque};
use std::fs::{self, File};
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Interval between two checks of a process.
const LOOK_EVERY: Duration = Duration::from_millis(5);
/// Exit code of a run that the user stopped.
const STOPPED: i32 = 130;

/// End of the run of a point.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PointOutcome {
    /// Exit code; -1 if a signal or the time limit ended the run.
    pub code: i32,
    /// Reason of the end.
    pub reason: String,
    /// Wall time [s].
    pub wall_s: f64,
    /// Settings of the point, for the user.
    pub settings: Vec<String>,
}

/// End of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// All points are done.
    Done,
    /// The user stopped the study.
    Stopped,
}

/// Returns the folder of a point.
pub fn folder(out: &Path, point: &Point) -> PathBuf {
    out.join("runs").join(&point.key)
}

/// Returns the outcome of a point, none if it has not ended.
pub fn outcome(out: &Path, point: &Point) -> Option<PointOutcome> {
    let text = fs::read_to_string(folder(out, point).join("point.json")).ok()?;
    serde_json::from_str(&text).ok()
}

/// Removes the results of the plan's points, so that all of them run again.
///
/// # Errors
/// A folder cannot be removed.
pub fn forget(plan: &StudyPlan, out: &Path) -> Result<(), String> {
    let folders = plan.points.iter().map(|point| folder(out, point));
    // Existence is checked one by one, because points with the same settings share a folder.
    folders.filter(|folder| folder.exists()).try_for_each(|folder| {
        fs::remove_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))
    })
}

/// Returns the number of runs that are not done.
pub fn open(plan: &StudyPlan, out: &Path) -> usize {
    to_do(plan, out).len()
}

fn to_do<'p>(plan: &'p StudyPlan, out: &Path) -> VecDeque<&'p Point> {
    let mut seen = HashSet::new();
    plan.points.iter().filter(|p| seen.insert(&p.key) && outcome(out, p).is_none()).collect()
}

/// Runs the points that are not done, `jobs` at a time.
///
/// # Errors
/// Results cannot be written, or a measure needs a number that the runs do not have.
pub fn run_all(
    study: &Study,
    plan: &StudyPlan,
    out: &Path,
    jobs: usize,
    stop: &StopFlag,
) -> Result<Ending, String> {
    let queue = Mutex::new(to_do(plan, out));
    let progress = StudyProgress::new(open(plan, out));
    let failure = Mutex::new(None);
    let over = AtomicBool::new(false);
    let work = || {
        while !over.load(Ordering::Relaxed) && !stop.is_raised() {
            let Some(point) = queue.lock().ok().and_then(|mut q| q.pop_front()) else { break };
            match one(study, point, out, stop) {
                Ok(Some(outcome)) => progress.done(&point.label(study), &outcome),
                Ok(None) => break,
                Err(why) => {
                    over.store(true, Ordering::Relaxed);
                    if let Ok(mut first) = failure.lock() {
                        first.get_or_insert(why);
                    }
                }
            }
        }
    };
    std::thread::scope(|scope| (0..jobs).for_each(|_| drop(scope.spawn(work))));
    progress.finish();
    match failure.into_inner().ok().flatten() {
        Some(why) => Err(why),
        None if stop.is_raised() => Ok(Ending::Stopped),
        None => Ok(Ending::Done),
    }
}

/// Returns the number of workers of a point: that of its settings, or else 1.
fn workers(sets: &[String]) -> &str {
    sets.iter().rev().find_map(|set| set.strip_prefix("parallel.workers=")).unwrap_or("1")
}

/// Runs a point. Returns none if the user stopped it.
fn one(
    study: &Study,
    point: &Point,
    out: &Path,
    stop: &StopFlag,
) -> Result<Option<PointOutcome>, String> {
    let folder = folder(out, point);
    let cannot = |error: io::Error| format!("{}: {error}", folder.display());
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(cannot)?; // of a run that was stopped
    }
    fs::create_dir_all(&folder).map_err(cannot)?;
    let words = folder.join("stderr.txt");
    let mut command = Command::new(std::env::current_exe().map_err(cannot)?);
    command
        .arg("run")
        .arg(&study.job)
        .args(["--workers", workers(&point.sets), "--quiet", "--no-report", "--out"])
        .arg(&folder);
    for set in &point.sets {
        command.args(["--set", set]);
    }
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(File::create(&words).map_err(cannot)?);
    let began = Instant::now();
    let mut child = command.spawn().map_err(cannot)?;
    let Some(status) = wait(&mut child, began, study.time_limit, stop).map_err(cannot)? else {
        return Ok(None);
    };
    let wall_s = began.elapsed().as_secs_f64();
    let (code, reason) = match status {
        Waited::Late => (-1, format!("not finished after {wall_s:.0} s of wall time")),
        Waited::Ended(status) => match status.code() {
            Some(STOPPED) => return Ok(None),
            // Studies measure; requirements are for single runs.
            Some(code) if code == i32::from(UNMET) => (0, reason(&folder, &words, 0)),
            Some(code) => (code, reason(&folder, &words, code)),
            None => (-1, format!("{status}; see {}", words.display())),
        },
    };
    if code == 0 {
        // A measure with an unknown name must fail at the first point, not after the last.
        let run = RunResults::load(&folder)?;
        for measure in &study.measure {
            quantity::value(&measure.quantity, &run)
                .map_err(|why| format!("measure `{}`: {why}", measure.name))?;
        }
        quantity::value(&study.cost.quantity, &run).map_err(|why| format!("cost: {why}"))?;
    }
    let outcome = PointOutcome { code, reason, wall_s, settings: point.sets.clone() };
    let text = serde_json::to_string_pretty(&outcome).map_err(|error| error.to_string())?;
    fs::write(folder.join("point.json.part"), text + "\n").map_err(cannot)?;
    fs::rename(folder.join("point.json.part"), folder.join("point.json")).map_err(cannot)?;
    Ok(Some(outcome))
}

enum Waited {
    Ended(ExitStatus),
    Late,
}

/// Waits for a process. If the user wants to stop, ends the process and returns none.
fn wait(
    child: &mut Child,
    began: Instant,
    limit: Option<f64>,
    stop: &StopFlag,
) -> io::Result<Option<Waited>> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(Waited::Ended(status)));
        }
        let late = limit.is_some_and(|limit| began.elapsed().as_secs_f64() > limit);
        if late || stop.is_raised() {
            child.kill()?;
            child.wait()?;
            return Ok(late.then_some(Waited::Late));
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

/// Returns the reason for the end of a run: from the summary, otherwise the last error message.
fn reason(folder: &Path, words: &Path, code: i32) -> String {
    let summary = RunResults::load(folder)
        .ok()
        .and_then(|run| run.summary["reason"].as_str().map(String::from));
    let last = || {
        let said = fs::read_to_string(words).unwrap_or_default();
        said.lines()
            .rfind(|line| line.contains("error"))
            .or(said.lines().last())
            .unwrap_or_default()
            .to_string()
    };
    summary.filter(|_| code == 0 || code == 3).unwrap_or_else(last)
}

/// Progress of the study: a bar with the remaining time on a terminal, otherwise a line per
/// point.
struct StudyProgress {
    bar: Option<ProgressBar>,
    began: Instant,
    total: usize,
    done: Mutex<usize>,
}

impl StudyProgress {
    fn new(total: usize) -> Self {
        let bar = (total > 0 && io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(total as u64);
            let style = ProgressStyle::with_template(
                "{bar:30} {pos}/{len} {elapsed}, {eta} left  {wide_msg}",
            );
            style.into_iter().for_each(|s| bar.set_style(s));
            bar.enable_steady_tick(Duration::from_secs(1));
            bar
        });
        Self { bar, began: Instant::now(), total, done: Mutex::new(0) }
    }

    fn done(&self, label: &str, outcome: &PointOutcome) {
        let Ok(mut done) = self.done.lock() else { return };
        *done += 1;
        let line = match outcome.code {
            0 => format!("{label} ({:.1} s)", outcome.wall_s),
            code => format!("{label}: exit code {code}: {}", outcome.reason),
        };
        match &self.bar {
            Some(bar) => {
                bar.set_message(line);
                bar.inc(1);
            }
            None => {
                let left =
                    self.began.elapsed().as_secs_f64() / *done as f64 * (self.total - *done) as f64;
                eprintln!("{}/{}, {left:.0} s left: {line}", *done, self.total);
            }
        }
    }

    fn finish(&self) {
        self.bar.iter().for_each(|b| b.finish_and_clear());
    }
}
