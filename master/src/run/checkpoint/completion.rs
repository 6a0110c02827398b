//! The thread that makes a checkpoint complete: the state of the master, the manifest, and the
//! removal of old checkpoints.

use super::find;
use super::manifest::{self, Manifest, Stamp, sync};
use super::{MASTER, MasterState};
use crumple_proto::checkpoint::{COMMON, Captured, FileRecord, partial_name, verify_size, write};
use crumple_proto::wire;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Work of the thread that makes a checkpoint complete.
pub struct Completion {
    /// Folder of the run.
    pub run: PathBuf,
    /// Folder of all its checkpoints.
    pub dir: PathBuf,
    /// Number of checkpoints that are kept.
    pub keep: usize,
    /// Clock of the checkpoint.
    pub captured: Captured,
    /// Number of earlier captures in its cycle.
    pub repeat: u64,
    /// Job that the manifest names.
    pub stamp: Stamp,
    /// Number of elements.
    pub elements: usize,
    /// Counts the parts written.
    pub progress: Arc<AtomicU64>,
}

impl Completion {
    /// Writes the state of the master and the manifest, and removes old checkpoints; what is left
    /// of this one if that is not possible. Returns the bytes of all files.
    ///
    /// # Errors
    /// A file is missing or cannot be written: the reason.
    pub fn complete(
        &self,
        saved: Vec<Result<Vec<FileRecord>, String>>,
        master: Option<MasterState>,
    ) -> Result<u64, String> {
        let folder = self.dir.join(partial_name(self.captured.cycle, self.repeat));
        let written = self.write(&folder, saved, master);
        let ended = written.and_then(|bytes| find::publish(&folder).map(|_| bytes));
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
        let count = || {
            self.progress.fetch_add(1, Ordering::Relaxed);
        };
        for name in state.lengths.keys() {
            let path = self.run.join(name);
            sync(&path).map_err(|error| named(&path, error))?;
            count();
        }
        let master = write(folder, MASTER, &[&wire::encode(&state)], Default::default(), &count)
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
        // The folder may have been removed after a worker wrote into it.
        manifest.files().try_for_each(|file| verify_size(folder, file))?;
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
