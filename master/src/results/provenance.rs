//! `provenance.json`: what made the results in a folder. Each start of a run adds the program, the
//! machine, the command, and the files that it has read, with their SHA-256 sums.

use crumple_worker::vtu::write_whole;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::time::{FormatTime, SystemTime};

/// Name of the file.
pub const FILE: &str = "provenance.json";
/// Bytes of a file that are read at once.
const PORTION: usize = 1 << 20;

/// A file that a start has read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// Absolute path.
    pub path: PathBuf,
    /// SHA-256 sum of its bytes, in hexadecimal digits.
    pub sha256: String,
}

/// One start of a run: from time 0, or from a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ProgramStart {
    /// Version of the program.
    pub version: String,
    /// Commit of the program; none if it was built without its history.
    pub commit: Option<String>,
    /// Name of the machine of the master.
    pub host: String,
    /// Time of the start (UTC).
    pub began: String,
    /// Folder in which the command was given.
    pub folder: PathBuf,
    /// The command line.
    pub command: Vec<String>,
    /// The job file, as an absolute path.
    pub job_file: PathBuf,
    /// All `key=value` of this and earlier starts, in their order.
    pub set: Vec<String>,
    /// Number of workers.
    pub workers: usize,
    /// `threads` or `mpi`.
    pub transport: String,
    /// Cycle of the checkpoint from which the run continued; 0 from the start.
    pub from_cycle: u64,
    /// The job file, and the meshes, decks and included files of the job.
    pub files: Vec<InputFile>,
}

impl ProgramStart {
    /// Describes the start of this process. `commit` is that of the program.
    ///
    /// # Errors
    /// One of the files cannot be read; the message names it.
    pub fn of_this_process(
        commit: Option<&str>,
        (job_file, files): (&Path, &[PathBuf]),
        set: &[String],
    ) -> Result<Self, String> {
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").into(),
            commit: commit.map(String::from),
            host: rustix::system::uname().nodename().to_string_lossy().into_owned(),
            began: now(),
            folder: std::env::current_dir().unwrap_or_default(),
            command: std::env::args_os().map(|a| a.to_string_lossy().into_owned()).collect(),
            job_file: absolute(job_file),
            set: set.to_vec(),
            files: files.iter().map(|path| InputFile::read(path)).collect::<Result<_, _>>()?,
            ..Self::default()
        })
    }

    /// Returns version and commit of the program.
    pub fn program(&self) -> String {
        let commit = self.commit.as_ref().map_or(String::new(), |commit| format!(" ({commit})"));
        format!("{}{commit}", self.version)
    }

    /// Returns a line for each file that has changed since, or is missing.
    pub fn changed_files(&self) -> Vec<String> {
        let change = |file: &InputFile| match InputFile::read(&file.path) {
            Ok(now) if now.sha256 == file.sha256 => None,
            Ok(now) => Some(format!(
                "{}: its SHA-256 sum was {}, it is {}",
                file.path.display(),
                file.sha256,
                now.sha256
            )),
            Err(why) => Some(why),
        };
        self.files.iter().filter_map(change).collect()
    }
}

impl InputFile {
    fn read(path: &Path) -> Result<Self, String> {
        let sum = || -> io::Result<String> {
            let (mut file, mut sum) = (File::open(path)?, Sha256::new());
            let mut portion = vec![0; PORTION];
            loop {
                match file.read(&mut portion)? {
                    0 => break,
                    length => sum.update(&portion[..length]),
                }
            }
            Ok(sum.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
        };
        let sha256 = sum().map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self { path: absolute(path), sha256 })
    }
}

/// Returns the path without links and `..`.
fn absolute(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

/// Returns the present time (UTC), in whole seconds.
fn now() -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = SystemTime.format_time(&mut Writer::new(&mut text));
    match text.split_once('.') {
        Some((seconds, _)) => format!("{seconds}Z"),
        None => text,
    }
}

/// The whole file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// All keys of the job except those of the mesh, with the changes of all starts.
    pub job: Value,
    /// Starts of the run, the first one first.
    pub starts: Vec<ProgramStart>,
}

impl Provenance {
    /// Reads the file in the folder of a run.
    ///
    /// # Errors
    /// There is none, or it cannot be used; the message names the file.
    pub fn read(dir: &Path) -> Result<Self, String> {
        let path = dir.join(FILE);
        let named = |why: String| format!("{}: {why}", path.display());
        let text = std::fs::read_to_string(&path).map_err(|error| named(error.to_string()))?;
        let read: Self = serde_json::from_str(&text).map_err(|error| named(error.to_string()))?;
        if read.starts.is_empty() { Err(named("it has no start".into())) } else { Ok(read) }
    }

    /// Returns the last start.
    ///
    /// # Panics
    /// If it was not read from a file.
    pub fn last(&self) -> &ProgramStart {
        self.starts.last().expect("a file that was read has a start")
    }
}

/// Writes the file for a start with this job. One that continues is added to those before, as far
/// as the file has them.
///
/// # Errors
/// The file cannot be written.
pub fn record(dir: &Path, job: Value, start: ProgramStart) -> io::Result<()> {
    let before = if start.from_cycle > 0 { Provenance::read(dir).ok() } else { None };
    let mut starts = before.unwrap_or_default().starts;
    starts.push(start);
    let text = serde_json::to_string_pretty(&Provenance { job, starts }).unwrap_or_default() + "\n";
    write_whole(&dir.join(FILE), |out| out.write_all(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_and_a_missing_file_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let paths = ["same", "changed", "gone"].map(|name| dir.path().join(name));
        paths.iter().for_each(|path| std::fs::write(path, "abc").unwrap());
        let start = ProgramStart::of_this_process(None, (&paths[0], &paths), &[]).unwrap();
        // FIPS 180-2, appendix B.1.
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(start.files[0].sha256, sum);
        assert_eq!(start.changed_files(), Vec::<String>::new());
        std::fs::write(&paths[1], "abd").unwrap();
        std::fs::remove_file(&paths[2]).unwrap();
        let changed = start.changed_files();
        assert!(changed.len() == 2 && changed[0].contains("/changed: its SHA-256"), "{changed:?}");
        assert!(changed[1].contains("/gone: "), "{changed:?}");
        let missing = ProgramStart::of_this_process(None, (&paths[0], &paths), &[]);
        assert!(missing.unwrap_err().contains("/gone: "));
    }

    #[test]
    fn a_start_that_continues_is_added() {
        let dir = tempfile::tempdir().unwrap();
        let start = |from_cycle| ProgramStart { from_cycle, ..ProgramStart::default() };
        let count = || Provenance::read(dir.path()).unwrap().starts.len();
        for (from, known) in [(0, 1), (40, 2), (80, 3), (0, 1)] {
            record(dir.path(), Value::Null, start(from)).unwrap();
            assert_eq!(count(), known);
        }
        assert!(now().ends_with('Z') && now().len() == 20, "{}", now());
    }
}
