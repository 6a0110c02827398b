//! Writes the files of a worker on a thread of its own, while the worker advances.

use crate::checkpoint::piece_words;
use crate::engine::checkpoint::Copied;
use crumple_proto::checkpoint::{COMMON, FileRecord, Saved, folder_name, piece_name, write};
use crumple_proto::job::Compression;
use std::path::PathBuf;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The files of one checkpoint.
pub struct Task {
    /// The copied state.
    pub copied: Copied,
    /// Folder for all checkpoints of the run.
    pub dir: PathBuf,
    /// Cycles completed.
    pub cycle: u64,
    /// Number of this worker, from 0.
    pub worker: usize,
    /// Compression of the files.
    pub compression: Compression,
    /// Time of the copy.
    pub copy: Duration,
}

impl Task {
    /// Writes the files.
    pub fn run(self) -> Saved {
        let began = Instant::now();
        let files = self.write();
        let (cycle, copy_s) = (self.cycle, self.copy.as_secs_f64());
        Saved { cycle, files, copy_s, write_s: began.elapsed().as_secs_f64() }
    }

    fn write(&self) -> Result<Vec<FileRecord>, String> {
        let folder = self.dir.join(folder_name(self.cycle));
        let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
        std::fs::create_dir_all(&folder).map_err(failed)?;
        let words = piece_words(&self.copied.parcel, &self.copied.own);
        let mut files = vec![
            write(&folder, &piece_name(self.worker), &words, self.compression).map_err(failed)?,
        ];
        if !self.copied.common.is_empty() {
            let common = write(&folder, COMMON, &self.copied.common, self.compression);
            files.push(common.map_err(failed)?);
        }
        Ok(files)
    }
}

/// The thread that writes, if one is at work.
#[derive(Default)]
pub struct Writer {
    thread: Option<JoinHandle<Saved>>,
    cycle: u64,
}

impl Writer {
    /// Starts to write. [`Writer::wait`] must have returned the result of the last task.
    pub fn start(&mut self, task: Task) {
        self.cycle = task.cycle;
        self.thread = Some(std::thread::spawn(|| task.run()));
    }

    /// Returns the result of the task, if it has ended.
    pub fn poll(&mut self) -> Option<Saved> {
        if self.thread.as_ref()?.is_finished() { self.wait() } else { None }
    }

    /// Waits for the task, if there is one, and returns its result.
    pub fn wait(&mut self) -> Option<Saved> {
        let failed = |_| Saved {
            cycle: self.cycle,
            files: Err("the thread that writes the checkpoint ended early".into()),
            copy_s: 0.0,
            write_s: 0.0,
        };
        self.thread.take().map(|thread| thread.join().unwrap_or_else(failed))
    }
}
