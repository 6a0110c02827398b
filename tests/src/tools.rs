//! Programs of others that some tests need: MPI, a Python with packages, Chromium. Where one is
//! missing, its tests are skipped with a notice; with `CRUMPLE_REQUIRE_ALL=1`, as in CI, they fail.

use std::collections::BTreeMap;
use std::env;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

/// A program that is missing, and how to install it.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// Description of the problem.
    pub what: String,
    /// Remedy, as an order.
    pub install: String,
}

/// Returns the program, or `None` after a notice that the test is skipped.
///
/// # Panics
/// When it is missing although `CRUMPLE_REQUIRE_ALL` is 1.
pub fn or_skip<T>(found: Result<T, Missing>) -> Option<T> {
    skip_unless(env::var_os("CRUMPLE_REQUIRE_ALL").as_deref() == Some(OsStr::new("1")), found)
}

fn skip_unless<T>(require_all: bool, found: Result<T, Missing>) -> Option<T> {
    let Missing { what, install } = match found {
        Ok(program) => return Some(program),
        Err(missing) => missing,
    };
    assert!(!require_all, "{what}, but CRUMPLE_REQUIRE_ALL=1 forbids to skip a test: {install}");
    eprintln!("skipped: {what}; to run this test, {install}");
    None
}

/// Returns the Python in `CRUMPLE_PYTHON` if it has these packages; else see [`or_skip`].
pub fn python(packages: &str) -> Option<OsString> {
    static FOUND: Mutex<BTreeMap<String, Result<OsString, Missing>>> = Mutex::new(BTreeMap::new());
    let mut found = FOUND.lock().unwrap_or_else(PoisonError::into_inner);
    let result = found.entry(packages.into()).or_insert_with(|| {
        let missing = |what: String| Missing {
            what,
            install: "make a virtual environment with deploy/requirements.txt and name its Python \
                      in CRUMPLE_PYTHON; deploy/test.sh does both"
                .into(),
        };
        let python = env::var_os("CRUMPLE_PYTHON").filter(|path| !path.is_empty());
        let python =
            python.ok_or_else(|| missing("CRUMPLE_PYTHON does not name a Python".into()))?;
        let mut import = Command::new(&python);
        let said = import.args(["-c", &format!("import {packages}")]).output();
        let said = said.map_err(|error| missing(format!("{}: {error}", python.display())))?;
        let why = || String::from_utf8_lossy(&said.stderr).lines().last().map(String::from);
        match said.status.success() {
            true => Ok(python),
            false => Err(missing(format!(
                "{} lacks one of {packages}: {}",
                python.display(),
                why().unwrap_or_default()
            ))),
        }
    });
    let result = result.clone();
    drop(found);
    or_skip(result)
}

/// Returns `CRUMPLE_CHROMIUM`, or the first browser in `PATH`; else see [`or_skip`].
pub fn chromium() -> Option<PathBuf> {
    const NAMES: [&str; 4] =
        ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let in_path = || {
        let path = env::var_os("PATH")?;
        env::split_paths(&path)
            .flat_map(|folder| NAMES.map(|name| folder.join(name)))
            .find(|file| file.is_file())
    };
    let named = env::var_os("CRUMPLE_CHROMIUM").filter(|path| !path.is_empty());
    or_skip(named.map(PathBuf::from).or_else(in_path).ok_or_else(|| Missing {
        what: "no Chromium in PATH".into(),
        install: "install the package chromium, or name a browser in CRUMPLE_CHROMIUM".into(),
    }))
}

/// A disk in memory that is mounted until it is dropped.
pub struct Disk(PathBuf);

/// Mounts an empty disk of `bytes` on a folder, which is made; else see [`or_skip`].
///
/// # Panics
/// When the folder cannot be made.
pub fn tmpfs(folder: &Path, bytes: u64) -> Option<Disk> {
    std::fs::create_dir_all(folder).expect("a folder can be made");
    let size = format!("size={bytes}");
    let mounted = mount(&["-t", "tmpfs", "-o", &size, "tmpfs"], folder);
    or_skip(mounted.map(|()| Disk(folder.to_owned())).map_err(|what| Missing {
        what,
        install: "run it as root on a machine that allows mounts".into(),
    }))
}

impl Disk {
    /// Refuses all later writes. A file that is being written is waited for.
    ///
    /// # Panics
    /// When the disk cannot be mounted again.
    pub fn make_read_only(&self) {
        for _ in 0..100 {
            if mount(&["-o", "remount,ro"], &self.0).is_ok() {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        panic!("{} is always in use", self.0.display());
    }

    /// Allows writes again.
    ///
    /// # Panics
    /// When the disk cannot be mounted again.
    pub fn make_writable(&self) {
        mount(&["-o", "remount,rw"], &self.0).expect("it was writable before");
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").args(["-l"]).arg(&self.0).status();
    }
}

fn mount(options: &[&str], folder: &Path) -> Result<(), String> {
    let said = Command::new("mount").args(options).arg(folder).output();
    let said = said.map_err(|error| format!("mount: {error}"))?;
    let why = || format!("mount: {}", String::from_utf8_lossy(&said.stderr).trim());
    if said.status.success() { Ok(()) } else { Err(why()) }
}

/// Makes a pipe with a name; else see [`or_skip`].
pub fn fifo(path: &Path) -> Option<()> {
    let made = Command::new("mkfifo").arg(path).status().map_err(|error| error.to_string());
    let made = made.and_then(|status| status.success().then_some(()).ok_or("it failed".into()));
    or_skip(made.map_err(|why: String| Missing {
        what: format!("mkfifo: {why}"),
        install: "install coreutils".into(),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing() -> Result<(), Missing> {
        Err(Missing { what: "no hammer".into(), install: "install hammer".into() })
    }

    #[test]
    fn a_missing_program_skips_the_test() {
        assert_eq!(skip_unless(false, missing()), None);
        assert_eq!(skip_unless(true, Ok(7)), Some(7));
    }

    #[test]
    #[should_panic(expected = "no hammer, but CRUMPLE_REQUIRE_ALL=1 forbids to skip a test")]
    fn a_required_program_fails_the_test() {
        skip_unless(true, missing());
    }
}
