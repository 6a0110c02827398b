//! The master's part in checkpoints: when they are due, and the manifest that makes the files of
//! the workers a checkpoint.
//!
//! The master orders a checkpoint; all workers copy their states in the same cycle and send
//! `Captured`. Rows of histories and fields that belong to the time before were sent earlier, and
//! later ones need a message of every worker. So when the last `Captured` arrives, the master's own
//! state belongs to exactly that cycle, and is copied too. When all files are on disk, the manifest
//! is renamed into place.

pub mod compare;
mod completion;
pub mod copies;
pub mod find;
pub mod manifest;

use crate::input::job::Model;
use crate::results::history::Course;
use crate::results::summary::{CheckpointSummary, RestartSummary};
use crate::results::table::Tables;
use crate::results::warnings::EngineeringWarning;
use crate::run::balance::Accounts;
use completion::Completion;
use copies::Copies;
use crumple_proto::checkpoint::{Captured, FileRecord, Saved, folder_name};
use crumple_proto::job::Checkpoint;
use crumple_proto::steering::{OutputTimes, Planned, Steered};
use crumple_proto::wire;
use manifest::Stamp;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// Name of the file with the state of the master.
const MASTER: &str = "master.bin";

/// State of the master.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct MasterState {
    /// Extremes and last rows of the history.
    pub course: Course,
    /// Length of each file that grows with the run [byte].
    pub lengths: BTreeMap<String, u64>,
    /// Index and time of the field outputs.
    pub steps: Vec<(usize, f64)>,
    /// Costs so far.
    pub accounts: Accounts,
    /// Wall time so far [s].
    pub wall_s: f64,
    /// Engineering warnings so far.
    pub warnings: Vec<EngineeringWarning>,
    /// Continuations so far.
    pub restarts: Vec<RestartSummary>,
    /// Interval of history rows, and times of fields [time].
    pub history_interval: f64,
    /// See `history_interval`.
    pub field_times: Vec<f64>,
    /// Values that orders of users may have changed: end of the run [time], outputs, limits of
    /// redecompositions.
    pub end_time: f64,
    /// See `end_time`.
    pub output: OutputTimes,
    /// See `end_time`.
    pub imbalance: f64,
    /// See `end_time` [cycles].
    pub low_every_at_least: u64,
    /// Orders of users that have taken effect.
    pub steering: Vec<Steered>,
    /// Orders that were planned at the start.
    pub planned: Vec<Planned>,
}

impl MasterState {
    /// Reads the words of its file.
    ///
    /// # Errors
    /// They are no state of this cycle: the reason.
    pub fn from_words(words: &[u64], captured: &Captured) -> Result<Self, String> {
        let state: Self = wire::decode_state(words).ok_or("it is no state of the master")?;
        let times =
            [state.wall_s, state.history_interval, state.end_time, state.output.rows_from.1];
        let others = [state.imbalance, state.output.field_interval];
        let fields = state.field_times.iter().chain(&state.output.additional);
        let fields = fields.chain(state.steps.iter().map(|(_, time)| time));
        let planned = state.planned.iter().filter_map(|planned| planned.steer.value());
        let warned = state.warnings.iter().flat_map(|w| [w.time, w.worst_time, w.value]);
        let is_number = others.into_iter().chain(warned).chain(planned).chain(fields.copied());
        if !times.iter().all(|t| t.is_finite() && *t >= 0.0)
            || !is_number.into_iter().all(f64::is_finite)
        {
            return Err("it has a time that is not a time".into());
        }
        if state.output.rows_from.0 > captured.rows || state.steps.len() as u64 > captured.fields {
            return Err("it has another number of rows or fields than the manifest".into());
        }
        if let Some(name) = state.lengths.keys().find(|name| !Tables::is_one(name)) {
            return Err(format!("it has the length of a file `{name}`, which is no history"));
        }
        if !state.course.is_possible() || !state.accounts.are_possible() {
            return Err("it has a number of cycles that is not possible".into());
        }
        Ok(state)
    }

    /// Checks that it belongs to a model.
    ///
    /// # Errors
    /// It does not: the reason.
    pub fn validate(&self, model: &Model) -> Result<(), String> {
        let walls = model.job.wall.len() - model.job.restart.wall.len();
        if self.course.last.as_ref().is_some_and(|row| row.sum.wall_impulse.len() < walls) {
            return Err("its last row has fewer walls than the job".into());
        }
        Ok(())
    }
}

/// A checkpoint that is not complete.
#[derive(Default)]
struct Pending {
    captured: Captured,
    /// Number of earlier captures in its cycle.
    repeat: u64,
    /// Number of workers that have captured their state.
    copies: usize,
    master: Option<MasterState>,
    /// Files, or the reason why a worker could not write them.
    saved: Vec<Result<Vec<FileRecord>, String>>,
    copy_s: f64,
    write_s: f64,
}

/// A checkpoint that a thread makes complete.
struct Finishing {
    captured: Captured,
    copy_s: f64,
    write_s: f64,
    /// Counts the parts written, and the last count with its time.
    progress: Arc<AtomicU64>,
    last: (u64, Instant),
    /// Returns the bytes of all files.
    thread: JoinHandle<Result<u64, String>>,
}

/// Interval between two looks at the thread.
const LOOK_EVERY: Duration = Duration::from_millis(2);

/// All checkpoints of a run.
pub struct Checkpoints {
    run: PathBuf,
    dir: PathBuf,
    interval: Option<Duration>,
    keep: usize,
    workers: usize,
    elements: usize,
    stamp: Stamp,
    /// Time of the last order, or of the start.
    last: Instant,
    /// Time from the order or the begin of a checkpoint to its end: the longest of the last ones.
    /// Nothing before the first one.
    took: Option<Duration>,
    /// The warning that the interval is too short, until it is given; once.
    short: Option<String>,
    is_short: bool,
    /// Time since which a checkpoint is being written.
    since: Instant,
    ordered: bool,
    /// True from a request until it is served.
    requested: bool,
    /// Wall time since the order after which there is a warning; at the end of the run, time
    /// without progress of a file after which a checkpoint is given up.
    patience: Duration,
    complained: bool,
    /// True when the run has ended and waits for its files.
    is_over: bool,
    /// By cycle and number of earlier captures in it.
    pending: BTreeMap<[u64; 2], Pending>,
    /// Checkpoints with the files of all workers, until the thread is free.
    queue: VecDeque<Pending>,
    finishing: Option<Finishing>,
    /// Copies in memory.
    pub copies: Copies,
    /// Number and cost.
    pub summary: CheckpointSummary,
    /// Cycle and time of the last complete one.
    pub newest: Option<(u64, f64)>,
}

impl Checkpoints {
    /// Prepares the checkpoints of a run in the folder `run`.
    pub fn new(run: &Path, asked: &Checkpoint, workers: usize, elements: usize) -> Self {
        Self {
            run: run.to_owned(),
            dir: run.join(find::DIR),
            interval: asked.interval().unwrap_or_default(),
            keep: asked.keep.max(1),
            workers,
            elements,
            stamp: Stamp::default(),
            last: Instant::now(),
            took: None,
            short: None,
            is_short: false,
            since: Instant::now(),
            ordered: false,
            requested: false,
            patience: asked.patience().expect("the job is checked when it is read"),
            complained: false,
            is_over: false,
            pending: BTreeMap::new(),
            queue: VecDeque::new(),
            finishing: None,
            copies: Copies::new(asked.copy_interval().unwrap_or_default(), workers),
            summary: CheckpointSummary::default(),
            newest: None,
        }
    }

    /// Sets the job that manifests name.
    pub fn set_stamp(&mut self, stamp: Stamp) {
        self.stamp = stamp;
    }

    /// Returns the folder for all checkpoints.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Returns true if a checkpoint should be ordered now: the interval is nearly over and the run
    /// is not `paused`, or one is `asked` for. It is then counted as ordered. While another is
    /// being written, the request waits.
    pub fn take_due(&mut self, asked: bool, paused: bool) -> bool {
        let wait = self.interval.map(|interval| interval - self.ahead(interval));
        let over = !paused && wait.is_some_and(|wait| self.last.elapsed() >= wait);
        self.requested |= asked;
        let due = (self.requested || over) && !self.is_busy();
        if due {
            (self.ordered, self.requested) = (true, false);
            self.last = Instant::now();
        }
        due
    }

    /// Returns the time before the end of the interval at which a checkpoint is ordered, so that it
    /// is complete when the interval is over: at any moment the work since the last complete one is
    /// that of one interval. It is twice the time that one takes, at most half the interval; half
    /// the interval for the first one, whose time is not known.
    fn ahead(&self, interval: Duration) -> Duration {
        self.took.map_or(interval / 2, |took| (2 * took).min(interval / 2))
    }

    /// Counts the time that a checkpoint took. A longer one counts for some of the next ones too.
    /// Prepares a warning, once, if the interval cannot be kept.
    fn add_time(&mut self, took: Duration) {
        self.took = Some(self.took.map_or(took, |known| took.max(known * 3 / 4)));
        let Some(interval) = self.interval.filter(|&interval| took > interval / 2) else { return };
        if !std::mem::replace(&mut self.is_short, true) {
            let [took, every, loss] =
                [took, interval, took + took.max(interval / 2)].map(|time| time.as_secs_f64());
            self.short = Some(format!(
                "a checkpoint takes {took:.2} s, more than half of `checkpoint.every` = {every:.2} \
                 s: a run that is lost can lose the work of {loss:.2} s. Set a longer interval, or \
                 write to a faster file system"
            ));
        }
    }

    /// Returns true if some workers have copied their states for a checkpoint or in memory, and
    /// others have not.
    pub fn is_capturing(&self) -> bool {
        let is_partial = |p: &Pending| (1..self.workers).contains(&p.copies);
        self.copies.is_partial() || self.pending.values().any(is_partial)
    }

    /// Returns true from the order of a checkpoint until it is complete or given up.
    pub fn is_busy(&self) -> bool {
        self.ordered || !self.is_idle()
    }

    /// Returns true if no checkpoint is being written.
    fn is_idle(&self) -> bool {
        self.pending.is_empty() && self.queue.is_empty() && self.finishing.is_none()
    }

    /// Counts a worker that has captured its state; `repeat` is the number of earlier captures in
    /// the same cycle. Returns true if it is the last one; the state of the master has to follow at
    /// once.
    pub fn add_captured(&mut self, captured: Captured, repeat: u64) -> bool {
        if self.is_idle() {
            self.since = Instant::now();
        }
        let pending = self.pending.entry([captured.cycle, repeat]).or_default();
        (pending.captured, pending.repeat) = (captured, repeat);
        pending.copies += 1;
        pending.copies == self.workers
    }

    /// Sets the state of the master for the checkpoint of a cycle and `repeat`.
    pub fn add_master(&mut self, at: [u64; 2], state: MasterState) {
        if let Some(pending) = self.pending.get_mut(&at) {
            pending.master = Some(state);
        }
    }

    /// Returns a warning if the files of the last checkpoint take long, once for each, or if the
    /// interval is too short.
    pub fn complain(&mut self) -> Option<String> {
        if self.short.is_some() {
            return self.short.take();
        }
        let finishing = self.finishing.iter().map(|f| f.captured.cycle);
        let queued = self.queue.iter().map(|p| p.captured.cycle);
        let cycle = finishing.chain(queued).chain(self.pending.keys().map(|at| at[0])).next()?;
        if self.complained || self.since.elapsed() < self.patience {
            return None;
        }
        self.complained = true;
        Some(format!(
            "the checkpoint of cycle {cycle} is still being written to {}: the file system is slow \
             or hangs. The run continues; no other checkpoint is written until this one is \
             complete",
            self.dir.display()
        ))
    }

    /// Adds the files of a worker. After the last worker, [`Self::poll`] makes the checkpoint
    /// complete.
    pub fn add_saved(&mut self, saved: Saved) {
        let at = [saved.cycle, saved.repeat];
        if let Some((captured, state)) = self.copies.take_copy(at) {
            let (copies, repeat) = (self.workers, saved.repeat);
            let copied = Pending { captured, repeat, copies, ..Pending::default() };
            self.pending.insert(at, Pending { master: Some(state), ..copied });
        }
        let Some(pending) = self.pending.get_mut(&at) else { return };
        pending.saved.push(saved.files);
        pending.copy_s = pending.copy_s.max(saved.copy_s);
        pending.write_s = pending.write_s.max(saved.write_s);
        if pending.saved.len() == self.workers {
            self.queue.extend(self.pending.remove(&at));
        }
    }

    /// Starts a thread that makes a checkpoint complete.
    ///
    /// # Errors
    /// No thread can be started; the warning says so.
    fn start(&mut self, pending: Pending) -> Result<(), String> {
        let Pending { captured, repeat, copies: _, master, saved, copy_s, write_s } = pending;
        let progress = Arc::new(AtomicU64::new(0));
        let task = Completion {
            run: self.run.clone(),
            dir: self.dir.clone(),
            keep: self.keep,
            captured,
            repeat,
            stamp: self.stamp.clone(),
            elements: self.elements,
            progress: progress.clone(),
        };
        let thread = Builder::new().name("checkpoint".into());
        match thread.spawn(move || task.complete(saved, master)) {
            Ok(thread) => {
                let last = (0, Instant::now());
                self.finishing =
                    Some(Finishing { captured, copy_s, write_s, progress, last, thread });
                Ok(())
            }
            Err(error) => {
                (self.ordered, self.complained) = (false, false);
                Err(self.unwritten(
                    captured.cycle,
                    &format!("the thread that writes cannot be started: {error}"),
                ))
            }
        }
    }

    /// Returns a message for the user, or a warning, when a checkpoint is complete or could not be
    /// written. Starts the thread for the next one.
    pub fn poll(&mut self) -> Option<Result<String, String>> {
        if self.finishing.is_none()
            && let Some(next) = self.queue.pop_front()
        {
            return self.start(next).err().map(Err);
        }
        let Finishing { captured, copy_s, write_s, thread, .. } =
            self.finishing.take_if(|f| f.thread.is_finished())?;
        let ended = thread.join();
        // The workers begin those at simulated times without an order.
        let began = if self.ordered { self.last } else { self.since };
        (self.ordered, self.complained) = (false, false);
        Some(match ended.unwrap_or_else(|_| Err("the thread that writes ended early".into())) {
            Ok(bytes) => {
                self.add_time(began.elapsed());
                self.summary.written += 1;
                self.summary.bytes = bytes;
                self.summary.copy_s += copy_s;
                self.summary.write_s += write_s;
                self.newest = Some((captured.cycle, captured.time));
                Ok(format!(
                    "checkpoint at T={:.4e}, cycle {}: {:.1} MB in {}",
                    captured.time,
                    captured.cycle,
                    bytes as f64 / 1e6,
                    self.dir.join(folder_name(captured.cycle)).display()
                ))
            }
            Err(why) => Err(self.unwritten(captured.cycle, &why)),
        })
    }

    /// Waits until all checkpoints with the files of all workers are complete, and returns what
    /// [`Self::poll`] returns. Gives them up when no part of a file is written for the time for
    /// which a run waits for a file system.
    pub fn wait(&mut self) -> Vec<Result<String, String>> {
        let mut all = Vec::new();
        self.is_over = true;
        while self.finishing.is_some() || !self.queue.is_empty() {
            all.extend(self.poll());
            if let Some(cycle) = self.hanging() {
                self.finishing = None; // the thread ends with the process
                let queued = std::mem::take(&mut self.queue);
                let seconds = self.patience.as_secs_f64();
                let why = format!(
                    "no part of a file was written for {seconds:.0} s: the file system hangs"
                );
                for cycle in std::iter::once(cycle).chain(queued.iter().map(|p| p.captured.cycle)) {
                    all.push(Err(self.unwritten(cycle, &why)));
                }
            }
            std::thread::sleep(LOOK_EVERY);
        }
        all
    }

    /// Returns the cycle of the checkpoint of the thread, if it makes no progress.
    fn hanging(&mut self) -> Option<u64> {
        let Finishing { captured, progress, last, .. } = self.finishing.as_mut()?;
        let now = progress.load(Ordering::Relaxed);
        if now != last.0 {
            *last = (now, Instant::now());
        }
        (last.1.elapsed() > self.patience).then_some(captured.cycle)
    }

    /// Returns the warning about a checkpoint that could not be written.
    fn unwritten(&self, cycle: u64, why: &str) -> String {
        let kept = self.newest.map_or("there is no earlier one".to_string(), |(cycle, _)| {
            format!("the one of cycle {cycle} is kept")
        });
        let continues = if self.is_over { "" } else { ", and the run continues" };
        format!(
            "the checkpoint of cycle {cycle} could not be written: {why}; {kept}{continues}. Free \
             space or make the folder writable"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::checkpoint::{COMMON, partial_name, write};

    /// Returns the checkpoints of a run with one worker that waits briefly for its disk.
    fn checkpoints(run: &Path) -> Checkpoints {
        let asked = Checkpoint { patience: "0.5 s".into(), ..Checkpoint::default() };
        Checkpoints::new(run, &asked, 1, 1)
    }

    fn save(all: &mut Checkpoints, cycle: u64, files: Result<Vec<FileRecord>, String>) {
        all.add_captured(Captured { cycle, ..Captured::default() }, 0);
        all.add_master([cycle, 0], MasterState::default());
        all.add_saved(Saved { cycle, repeat: 0, files, copy_s: 0.0, write_s: 0.0 });
    }

    #[test]
    fn a_request_during_a_checkpoint_is_served_after_it() {
        let run = tempfile::tempdir().unwrap();
        let mut all = checkpoints(run.path());
        assert!(all.take_due(true, false));
        assert!(!all.take_due(true, false), "another is ordered");
        save(&mut all, 7, Err("no space".into()));
        assert!(!all.take_due(false, false), "another is being written");
        let ended = all.wait();
        assert!(matches!(&ended[..], [Err(why)] if why.contains("no space")), "{ended:?}");
        assert!(all.take_due(false, false), "the request has waited");
        assert!(!all.take_due(false, false), "it is served");
    }

    /// A checkpoint is ordered before the end of its interval by twice the time that one takes.
    #[test]
    fn a_checkpoint_is_complete_when_its_interval_is_over() {
        let run = tempfile::tempdir().unwrap();
        let mut all = checkpoints(run.path());
        let interval = Duration::from_secs(1000);
        all.interval = Some(interval);
        let times = [(None, 500), (Some(8), 16), (Some(1), 12), (Some(400), 500), (Some(0), 500)];
        for (took, ahead) in times {
            took.into_iter().for_each(|seconds| all.add_time(Duration::from_secs(seconds)));
            let ago = |seconds| Instant::now().checked_sub(Duration::from_secs(seconds)).unwrap();
            all.last = ago(1000 - ahead - 1);
            assert!(!all.take_due(false, false), "{took:?}");
            all.last = ago(1000 - ahead);
            assert!(all.take_due(false, false), "{took:?}");
            all.ordered = false;
        }
        assert_eq!(all.complain(), None);
    }

    /// The time since the last order has nothing to do with a checkpoint that was not ordered.
    #[test]
    fn a_checkpoint_at_a_simulated_time_takes_only_its_own_time() {
        let run = tempfile::tempdir().unwrap();
        let mut all = checkpoints(run.path());
        all.interval = Some(Duration::from_secs(1000));
        all.last = Instant::now().checked_sub(Duration::from_secs(900)).unwrap();
        let folder = all.dir().join(partial_name(1, 0));
        std::fs::create_dir_all(&folder).unwrap();
        save(
            &mut all,
            1,
            Ok(vec![write(&folder, COMMON, &[&[1]], Default::default(), &|| ()).unwrap()]),
        );
        assert!(all.wait().iter().all(Result::is_ok));
        assert!(all.took.unwrap() < Duration::from_secs(100), "{:?}", all.took);
        assert_eq!(all.complain(), None);
    }

    #[test]
    fn an_interval_that_cannot_be_kept_is_named_once() {
        let run = tempfile::tempdir().unwrap();
        let mut all = checkpoints(run.path());
        all.interval = Some(Duration::from_secs(10));
        all.add_time(Duration::from_secs(5));
        assert_eq!(all.complain(), None);
        all.add_time(Duration::from_secs(6));
        all.add_time(Duration::from_secs(7));
        let warning = all.complain().unwrap();
        assert!(warning.contains("takes 6.00 s") && warning.contains("12.00 s"), "{warning}");
        assert_eq!(all.complain(), None);
    }

    /// The folder was removed after a worker wrote into it, and made again by another one.
    #[test]
    fn a_checkpoint_that_lost_a_file_is_none() {
        let run = tempfile::tempdir().unwrap();
        let mut all = checkpoints(run.path());
        let folder = all.dir().join(partial_name(1, 0));
        std::fs::create_dir_all(&folder).unwrap();
        let common = write(&folder, COMMON, &[&[1]], Default::default(), &|| ()).unwrap();
        let piece = FileRecord { name: "piece_00000.bin".into(), ..common.clone() };
        save(&mut all, 1, Ok(vec![common, piece]));
        let ended = all.wait();
        let is_named = |why: &String| why.contains("piece_00000.bin");
        assert!(ended[0].as_ref().is_err_and(is_named), "{ended:?}");
        assert!(find::folders(all.dir()).is_empty());
    }

    /// A pipe without a reader in place of a file blocks the thread, as a disk that hangs.
    #[test]
    fn a_disk_that_hangs_does_not_block_the_master() {
        let run = tempfile::tempdir().unwrap();
        let mut all = checkpoints(run.path());
        let folder = all.dir().join(partial_name(1, 0));
        std::fs::create_dir_all(&folder).unwrap();
        let pipe = std::process::Command::new("mkfifo").arg(folder.join(MASTER)).status();
        assert!(pipe.unwrap().success());
        let common = FileRecord { name: COMMON.into(), bytes: 0, blake3: String::new() };
        let began = Instant::now();
        save(&mut all, 1, Ok(vec![common]));
        assert!(all.poll().is_none());
        save(&mut all, 2, Err("no space".into()));
        assert!(all.poll().is_none(), "the second waits for the first");
        assert!(began.elapsed() < Duration::from_millis(400), "{:?}", began.elapsed());
        let ended = all.wait();
        assert_eq!(ended.len(), 2, "{ended:?}");
        let hangs = |e: &Result<String, String>| e.as_ref().is_err_and(|w| w.contains("hangs"));
        assert!(ended.iter().all(hangs), "{ended:?}");
    }
}
