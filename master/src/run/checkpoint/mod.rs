//! The master's part in checkpoints: when they are due, and the manifest that makes the files of
//! the workers a checkpoint.
//!
//! The master orders a checkpoint; all workers copy their states in the same cycle and send
//! `Captured`. Rows of histories and fields that belong to the time before were sent earlier, and
//! later ones need a message of every worker. So when the last `Captured` arrives, the master's own
//! state belongs to exactly that cycle, and is copied too. When all files are on disk, the manifest
//! is renamed into place.

pub mod compare;
pub mod copies;
pub mod find;
pub mod manifest;

use crate::results::history::Course;
use crate::results::summary::{CheckpointSummary, Restart};
use crate::run::balance::Accounts;
use copies::Copies;
use crumple_proto::checkpoint::{COMMON, Captured, FileRecord, Saved, folder_name, write};
use crumple_proto::job::Checkpoint;
use crumple_proto::wire;
use manifest::{Manifest, Stamp, sync};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
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
    /// True for each warning that was given and is given once.
    pub warned: [bool; 3],
    /// Continuations so far.
    pub restarts: Vec<Restart>,
    /// Interval of history rows, and times of fields [time].
    pub history_interval: f64,
    /// See `history_interval`.
    pub field_times: Vec<f64>,
}

/// A checkpoint that is not complete.
#[derive(Default)]
struct Pending {
    captured: Captured,
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
    ordered: bool,
    /// Time without an end of the writing after which there is a warning.
    patience: Duration,
    complained: bool,
    pending: BTreeMap<u64, Pending>,
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
            ordered: false,
            patience: asked.patience().unwrap_or_default(),
            complained: false,
            pending: BTreeMap::new(),
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

    /// Returns true if a checkpoint should be ordered now: the interval is over, or one is
    /// `asked` for. It is then counted as ordered.
    pub fn take_due(&mut self, asked: bool) -> bool {
        let over = self.interval.is_some_and(|interval| self.last.elapsed() >= interval);
        let idle = self.pending.is_empty() && self.finishing.is_none();
        let due = (asked || over) && !self.ordered && idle;
        if due {
            self.ordered = true;
            self.last = Instant::now();
        }
        due
    }

    /// Counts a worker that has captured its state. Returns true if it is the last one; the state
    /// of the master has to follow at once.
    pub fn add_captured(&mut self, captured: Captured) -> bool {
        let pending = self.pending.entry(captured.cycle).or_default();
        pending.captured = captured;
        pending.copies += 1;
        pending.copies == self.workers
    }

    /// Sets the state of the master for the checkpoint of a cycle.
    pub fn add_master(&mut self, cycle: u64, state: MasterState) {
        if let Some(pending) = self.pending.get_mut(&cycle) {
            pending.master = Some(state);
        }
    }

    /// Returns a warning if the files of the last checkpoint take long, once for each.
    pub fn complain(&mut self) -> Option<String> {
        let finishing = self.finishing.iter().map(|f| f.captured.cycle);
        let cycle = finishing.chain(self.pending.keys().copied()).next()?;
        if self.complained || self.last.elapsed() < self.patience {
            return None;
        }
        self.complained = true;
        Some(format!(
            "the checkpoint of cycle {cycle} is still being written to {}: the file system is slow \
             or hangs. The run continues; no other checkpoint is written until then",
            self.dir.display()
        ))
    }

    /// Adds the files of a worker. After the last worker, a thread makes the checkpoint complete.
    /// Returns the end of the one before, as [`Self::poll`], if it is waited for here.
    pub fn add_saved(&mut self, saved: Saved) -> Option<Result<String, String>> {
        if let Some((captured, state)) = self.copies.take(saved.cycle) {
            let copied = Pending { captured, copies: self.workers, ..Pending::default() };
            self.pending.insert(saved.cycle, Pending { master: Some(state), ..copied });
        }
        let pending = self.pending.get_mut(&saved.cycle)?;
        pending.saved.push(saved.files);
        pending.copy_s = pending.copy_s.max(saved.copy_s);
        pending.write_s = pending.write_s.max(saved.write_s);
        if pending.saved.len() < self.workers {
            return None;
        }
        let mut pending = self.pending.remove(&saved.cycle)?;
        let before = self.wait();
        let Pending { captured, copy_s, write_s, .. } = pending;
        let saved = std::mem::take(&mut pending.saved);
        let master = pending.master;
        let task = Completion {
            run: self.run.clone(),
            dir: self.dir.clone(),
            keep: self.keep,
            captured,
            stamp: self.stamp.clone(),
            elements: self.elements,
        };
        let thread = std::thread::spawn(move || task.complete(saved, master));
        self.finishing = Some(Finishing { captured, copy_s, write_s, thread });
        before
    }

    /// Returns a message for the user, or a warning, when the thread has ended.
    pub fn poll(&mut self) -> Option<Result<String, String>> {
        let Finishing { captured, copy_s, write_s, thread } =
            self.finishing.take_if(|f| f.thread.is_finished())?;
        let ended = thread.join();
        (self.ordered, self.complained) = (false, false);
        Some(match ended.unwrap_or_else(|_| Err("the thread that writes ended early".into())) {
            Ok(bytes) => {
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

    /// Waits for the thread, if there is one, as [`Self::poll`]. Gives it up after the time for
    /// which a run waits for a file system.
    pub fn wait(&mut self) -> Option<Result<String, String>> {
        let began = Instant::now();
        loop {
            let cycle = self.finishing.as_ref()?.captured.cycle;
            if let Some(ended) = self.poll() {
                return Some(ended);
            }
            if began.elapsed() > self.patience {
                self.finishing = None; // the thread ends with the process
                let seconds = self.patience.as_secs_f64();
                let why =
                    format!("it was not complete after {seconds:.0} s: the file system hangs");
                return Some(Err(self.unwritten(cycle, &why)));
            }
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Returns the warning about a checkpoint that could not be written.
    fn unwritten(&self, cycle: u64, why: &str) -> String {
        let kept = self.newest.map_or("there is no earlier one".to_string(), |(cycle, _)| {
            format!("the one of cycle {cycle} is kept")
        });
        format!(
            "the checkpoint of cycle {cycle} could not be written: {why}; {kept}, and the run \
             continues. Free space or make the folder writable"
        )
    }
}

/// Work of the thread that makes a checkpoint complete.
struct Completion {
    run: PathBuf,
    dir: PathBuf,
    keep: usize,
    captured: Captured,
    stamp: Stamp,
    elements: usize,
}

impl Completion {
    /// Writes the state of the master and the manifest, and removes old checkpoints; what is left
    /// of this one if that is not possible. Returns the bytes of all files.
    fn complete(
        &self,
        saved: Vec<Result<Vec<FileRecord>, String>>,
        master: Option<MasterState>,
    ) -> Result<u64, String> {
        let folder = self.dir.join(folder_name(self.captured.cycle));
        let ended = self.write(&folder, saved, master);
        match ended {
            Ok(_) => self.prune(),
            // Without a manifest it is no checkpoint, even if it cannot be removed.
            Err(_) => drop(std::fs::remove_dir_all(&folder)),
        }
        ended
    }

    fn write(
        &self,
        folder: &Path,
        saved: Vec<Result<Vec<FileRecord>, String>>,
        master: Option<MasterState>,
    ) -> Result<u64, String> {
        let named = |path: &Path, error: io::Error| format!("{}: {error}", path.display());
        let mut files = Vec::new();
        for saved in saved {
            files.extend(saved?);
        }
        let state = master.ok_or("not all workers have copied their states")?;
        let common = files.iter().position(|f| f.name == COMMON).ok_or("a file is missing")?;
        let common = files.swap_remove(common);
        files.sort_by(|a, b| a.name.cmp(&b.name));
        for name in state.lengths.keys() {
            let path = self.run.join(name);
            sync(&path).map_err(|error| named(&path, error))?;
        }
        let master = write(folder, MASTER, &wire::encode(&state), Default::default(), &|| ())
            .map_err(|error| named(folder, error))?;
        let manifest = Manifest {
            program: env!("CARGO_PKG_VERSION").into(),
            captured: self.captured,
            stamp: self.stamp.clone(),
            elements: self.elements,
            master,
            common,
            pieces: files,
        };
        manifest.write(folder).map_err(|error| named(folder, error))?;
        Ok(manifest.files().map(|f| f.bytes).sum())
    }

    /// Removes all complete checkpoints except the newest ones.
    fn prune(&self) {
        let complete = |f: &PathBuf| f.join(manifest::MANIFEST).exists();
        let folders = find::folders(&self.dir).into_iter().filter(complete);
        for folder in folders.skip(self.keep) {
            // Without its manifest a folder is no checkpoint, even if the rest stays.
            let _ = std::fs::remove_file(folder.join(manifest::MANIFEST));
            let _ = std::fs::remove_dir_all(folder);
        }
    }
}
