//! Lock of a run's folder, so that no two runs write into it. The operating system releases the
//! lock when its owner ends, in whatever way.

use std::fs::{File, TryLockError};
use std::io::Write;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Name of the file.
const NAME: &str = "run.lock";

/// Number of further tries to lock a folder, and the time between them. [`is_held`] holds the lock
/// for some microseconds.
const TRIES: u32 = 5;
const WAIT: Duration = Duration::from_millis(10);

/// A lock that is held.
pub struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    /// Locks a folder.
    ///
    /// # Errors
    /// Another run holds the lock, or the folder cannot be written; the message names it.
    pub fn acquire(folder: &Path) -> Result<Self, String> {
        let path = folder.join(NAME);
        let named = |error: std::io::Error| {
            format!("{}: {error}; choose another folder with --out", path.display())
        };
        if let Some(file) = folder.ancestors().find(|path| path.is_file()) {
            return Err(format!("{} is a file; name a folder with --out", file.display()));
        }
        std::fs::create_dir_all(folder).map_err(named)?;
        let mut tries = 0;
        loop {
            let mut file = File::options()
                .create(true)
                .read(true)
                .write(true)
                .truncate(false)
                .open(&path)
                .map_err(named)?;
            match file.try_lock() {
                Ok(()) => {}
                // A process may just ask for the owner.
                Err(TryLockError::WouldBlock) if tries < TRIES => {
                    tries += 1;
                    std::thread::sleep(WAIT);
                    continue;
                }
                Err(TryLockError::WouldBlock) => {
                    let owner = std::fs::read_to_string(&path).unwrap_or_default();
                    return Err(format!(
                        "{}: another run writes into this folder (process {}); wait for its end, \
                         or choose another folder with --out",
                        folder.display(),
                        owner.trim()
                    ));
                }
                // Some file systems have no locks.
                Err(TryLockError::Error(error))
                    if error.kind() == std::io::ErrorKind::Unsupported => {}
                Err(TryLockError::Error(error)) => return Err(named(error)),
            }
            // The last owner may have removed the file between the two calls.
            let same = |m: std::fs::Metadata| file.metadata().is_ok_and(|f| f.ino() == m.ino());
            if std::fs::metadata(&path).is_ok_and(same) {
                file.set_len(0).map_err(named)?;
                write!(file, "{}", std::process::id()).map_err(named)?;
                return Ok(Self { path, _file: file });
            }
        }
    }
}

/// Returns true if a process holds the lock of a folder.
pub fn is_held(folder: &Path) -> bool {
    let file = File::open(folder.join(NAME));
    file.is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

impl Drop for Lock {
    fn drop(&mut self) {
        // A file that stays is harmless: it is not locked.
        let _ = std::fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_question_for_the_owner_does_not_prevent_a_run() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join(NAME), "1").unwrap();
        let asked = File::open(dir.path().join(NAME)).unwrap();
        asked.try_lock_shared().unwrap();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(WAIT / 2);
                asked.unlock().unwrap();
            });
            Lock::acquire(dir.path()).unwrap();
        });
    }

    #[test]
    fn a_file_is_no_folder() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("base.toml");
        std::fs::write(&file, "").unwrap();
        for folder in [file.clone(), file.join("below")] {
            let refused = Lock::acquire(&folder).err().unwrap();
            assert!(
                refused.ends_with("base.toml is a file; name a folder with --out"),
                "{refused}"
            );
        }
    }

    #[test]
    fn a_folder_has_one_owner_and_a_file_that_stayed_locks_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let first = Lock::acquire(dir.path()).unwrap();
        let refused = Lock::acquire(dir.path()).err().unwrap();
        assert!(refused.contains(&std::process::id().to_string()), "{refused}");
        assert!(is_held(dir.path()));
        drop(first);
        assert!(!is_held(dir.path()));
        std::fs::write(dir.path().join(NAME), "99999").unwrap();
        assert!(!is_held(dir.path()), "the file without its lock");
        let second = Lock::acquire(dir.path()).unwrap();
        drop(second);
        assert!(!dir.path().join(NAME).exists());
    }
}
