//! File of one attempt to run a job (`--attempt`), so that `crumple serve` loses no run and starts
//! none twice, even if it is killed at any moment.
//!
//! The process of the run creates the file, which must not exist, and holds its lock until it ends.
//! The operating system releases the lock in whatever way the process ends, so no process id has to
//! be trusted. The service gives each attempt a file of its own. It can create the file itself: a
//! process that comes later then runs nothing.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// An attempt of this process.
pub struct Attempt {
    file: File,
}

/// An attempt, as others see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// No process has claimed it.
    Absent,
    /// The service has withdrawn it.
    Withdrawn,
    /// The process with this number runs.
    Running(u32),
    /// The process has ended with this exit code.
    Ended(u8),
    /// The process has ended without an exit code: it was killed.
    Lost,
}

impl Attempt {
    /// Claims an attempt.
    ///
    /// # Errors
    /// It is claimed or withdrawn, or the file cannot be made.
    pub fn claim(path: &Path) -> Result<Self, String> {
        let named = |error: io::Error| format!("{}: {error}", path.display());
        // The lock is held before the file has its name.
        let own = PathBuf::from(format!("{}.{}", path.display(), std::process::id()));
        let mut file = File::create(&own).map_err(named)?;
        let made = (|| {
            file.try_lock().map_err(io::Error::from)?;
            writeln!(file, "pid {}", std::process::id())?;
            if let Some(host) = host() {
                writeln!(file, "host {host}")?;
            }
            fs::hard_link(&own, path)
        })();
        let _ = fs::remove_file(&own); // one that stays is harmless
        match made {
            Ok(()) => Ok(Self { file }),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(format!(
                "{}: this attempt was made or withdrawn already; nothing is run",
                path.display()
            )),
            Err(error) => Err(named(error)),
        }
    }

    /// Notes that a request to stop has arrived: a second one would end the run at once.
    pub fn note_stop(&self) {
        // Without it the service asks again.
        let _ = writeln!(&self.file, "stopping");
    }

    /// Writes the exit code. The lock ends with the process.
    pub fn end(mut self, code: u8) {
        // Without it the run counts as lost, and the summary says how it ended.
        let _ = writeln!(self.file, "code {code}").and_then(|()| self.file.sync_all());
        std::mem::forget(self.file);
    }
}

/// Returns the state of an attempt.
///
/// # Errors
/// The file cannot be read.
pub fn read_state(path: &Path) -> io::Result<State> {
    let mut file = match File::open(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(State::Absent),
        opened => opened?,
    };
    let held = matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
    let mut text = String::new();
    file.read_to_string(&mut text)?;
    let number = |key: &str| -> Option<u32> {
        text.lines().find_map(|line| line.strip_prefix(key)?.trim().parse().ok())
    };
    Ok(match (held, number("code "), number("pid ")) {
        (true, _, Some(pid)) => State::Running(pid),
        (_, Some(code), _) => State::Ended(u8::try_from(code).unwrap_or(u8::MAX)),
        // The service may have been killed before it wrote the word.
        (false, None, None) => State::Withdrawn,
        _ => State::Lost,
    })
}

/// Returns the name of this machine, if it has one.
fn host() -> Option<String> {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").ok()?.trim().to_string();
    (!name.is_empty()).then_some(name)
}

/// Returns true if the process of an attempt has ended. On other machines than that of the process
/// its lock may not be seen: there the answer is false.
pub fn is_released(path: &Path) -> bool {
    let Some(host) = host() else { return false };
    let is_here = |text: String| text.lines().any(|line| line.strip_prefix("host ") == Some(&host));
    fs::read_to_string(path).is_ok_and(is_here)
        && File::open(path).is_ok_and(|file| file.try_lock_shared().is_ok())
}

/// Returns true if a request to stop has arrived at the process of an attempt.
///
/// # Errors
/// The file cannot be read.
pub fn is_stopping(path: &Path) -> io::Result<bool> {
    match fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        text => Ok(text?.lines().any(|line| line == "stopping")),
    }
}

/// Withdraws an attempt that no process has claimed. Returns its state afterwards.
///
/// # Errors
/// The file cannot be made or read.
pub fn withdraw(path: &Path) -> io::Result<State> {
    match File::create_new(path) {
        Ok(mut file) => {
            file.write_all(b"withdrawn\n")?;
            file.sync_all()?;
            Ok(State::Withdrawn)
        }
        Err(error) if error.kind() == ErrorKind::AlreadyExists => read_state(path),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_attempt_is_claimed_once_and_shows_its_end() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("attempt-1");
        assert_eq!(read_state(&path).unwrap(), State::Absent);
        let attempt = Attempt::claim(&path).unwrap();
        assert_eq!(read_state(&path).unwrap(), State::Running(std::process::id()));
        assert_eq!(withdraw(&path).unwrap(), State::Running(std::process::id()));
        assert!(Attempt::claim(&path).is_err_and(|why| why.contains("nothing is run")));
        assert!(!is_released(&path));
        assert!(!is_stopping(&path).unwrap());
        attempt.note_stop();
        assert!(is_stopping(&path).unwrap());
        assert_eq!(read_state(&path).unwrap(), State::Running(std::process::id()));
        drop(attempt); // as after a kill
        assert_eq!(read_state(&path).unwrap(), State::Lost);
        assert!(is_released(&path));
        let elsewhere = fs::read_to_string(&path).unwrap().replace("host ", "host other-");
        fs::write(&path, elsewhere).unwrap();
        assert!(!is_released(&path), "the lock of another machine may not be seen");
        std::fs::write(&path, "pid 1\ncode 130\n").unwrap();
        assert_eq!(read_state(&path).unwrap(), State::Ended(130));
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1, "no other file stays");
    }

    #[test]
    fn no_process_claims_an_attempt_that_is_withdrawn() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("attempt-1");
        assert_eq!(withdraw(&path).unwrap(), State::Withdrawn);
        assert!(Attempt::claim(&path).is_err());
        assert_eq!(read_state(&path).unwrap(), State::Withdrawn);
    }
}
