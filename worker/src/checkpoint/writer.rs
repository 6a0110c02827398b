//! Writes the files of a worker on a thread of its own, while the worker advances.

use crate::engine::checkpoint::Copied;
use crumple_proto::checkpoint::{COMMON, FileRecord, Saved, partial_name, piece_name, write};
use crumple_proto::job::Compression;
use crumple_proto::wire;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// The files of one checkpoint.
pub struct Task {
    /// The copied state.
    pub copied: Copied,
    /// Folder for all checkpoints of the run.
    pub dir: PathBuf,
    /// Cycles completed.
    pub cycle: u64,
    /// Number of earlier captures in this cycle.
    pub repeat: u64,
    /// Number of this worker, from 0.
    pub worker: usize,
    /// Compression of the files.
    pub compression: Compression,
    /// Time of the copy.
    pub copy: Duration,
    /// Counts the portions written.
    pub progress: Arc<AtomicU64>,
}

impl Task {
    /// Writes the files.
    pub fn run(self) -> Saved {
        let began = Instant::now();
        let files = self.write();
        let (cycle, repeat, copy_s) = (self.cycle, self.repeat, self.copy.as_secs_f64());
        Saved { cycle, repeat, files, copy_s, write_s: began.elapsed().as_secs_f64() }
    }

    fn write(&self) -> Result<Vec<FileRecord>, String> {
        let folder = self.dir.join(partial_name(self.cycle, self.repeat));
        let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
        std::fs::create_dir_all(&folder).map_err(failed)?;
        let count = || {
            self.progress.fetch_add(1, Ordering::Relaxed);
        };
        let (length, own) = ([self.copied.parcel.len() as u64], wire::encode(&self.copied.own));
        let words = [&length[..], &self.copied.parcel, &own];
        let name = piece_name(self.worker);
        let mut files =
            vec![write(&folder, &name, &words, self.compression, &count).map_err(failed)?];
        if !self.copied.common.is_empty() {
            let common = [&self.copied.common[..]];
            files.push(write(&folder, COMMON, &common, self.compression, &count).map_err(failed)?);
        }
        Ok(files)
    }
}

/// Interval between two looks at the thread.
const LOOK_EVERY: Duration = Duration::from_millis(2);

/// The thread that writes, if one is at work.
#[derive(Default)]
pub struct CheckpointWriter {
    thread: Option<JoinHandle<Saved>>,
    /// Cycle of its task, and number of earlier captures in it.
    at: [u64; 2],
    progress: Arc<AtomicU64>,
}

impl CheckpointWriter {
    /// Starts to write, unless another task is still at work: the new one then fails at once, so
    /// that no worker waits for a slow disk.
    pub fn start(&mut self, task: Task) -> Option<Saved> {
        if self.thread.is_some() {
            let why = format!(
                "the files of the checkpoint of cycle {} are still being written to {}",
                self.at[0],
                task.dir.display()
            );
            return Some(failed([task.cycle, task.repeat], why));
        }
        (self.at, self.progress) = ([task.cycle, task.repeat], task.progress.clone());
        match Builder::new().name("checkpoint".into()).spawn(|| task.run()) {
            Ok(thread) => self.thread = Some(thread),
            Err(error) => {
                return Some(failed(
                    self.at,
                    format!("the thread that writes cannot be started: {error}"),
                ));
            }
        }
        None
    }

    /// Returns the result of the task, if it has ended.
    pub fn poll(&mut self) -> Option<Saved> {
        if !self.thread.as_ref()?.is_finished() {
            return None;
        }
        let ended = |_| failed(self.at, "the thread that writes ended early".into());
        self.thread.take().map(|thread| thread.join().unwrap_or_else(ended))
    }

    /// Waits for the task, if there is one, and returns its result. Gives it up if it makes no
    /// progress for a time of `patience`: it then has failed.
    pub fn wait(&mut self, patience: Duration) -> Option<Saved> {
        let mut last = (self.progress.load(Ordering::Relaxed), Instant::now());
        loop {
            self.thread.as_ref()?;
            if let Some(saved) = self.poll() {
                return Some(saved);
            }
            let now = self.progress.load(Ordering::Relaxed);
            if now != last.0 {
                last = (now, Instant::now());
            }
            if last.1.elapsed() > patience {
                self.thread = None; // it ends with the process
                let why = format!(
                    "no part of a file was written for {:.0} s: the file system hangs",
                    patience.as_secs_f64()
                );
                return Some(failed(self.at, why));
            }
            std::thread::sleep(LOOK_EVERY);
        }
    }
}

fn failed([cycle, repeat]: [u64; 2], why: String) -> Saved {
    Saved { cycle, repeat, files: Err(why), copy_s: 0.0, write_s: 0.0 }
}
