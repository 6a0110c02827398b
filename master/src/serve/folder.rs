//! Folders of the service and names in them.
//!
//! ```text
//! DIR/service.db        queue, events, tokens, audit log
//! DIR/jobs/ID/input     files of the job as they were submitted
//! DIR/jobs/ID/results   folder of results of `crumple run`
//! DIR/jobs/ID/attempt-N one file for each process, see `run/attempt.rs`
//! DIR/jobs/ID/check.json what `crumple check` found; output.txt: what `crumple run` said
//! ```

use crate::input::confine::is_within;
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Component, Path, PathBuf};

/// Longest path of a file in a job [byte].
const LONGEST: usize = 200;
/// Most folders in the path of a file.
const DEEPEST: usize = 8;
/// Most files that a list has.
const MOST_FILES: usize = 20_000;

/// The folder of the service.
#[derive(Clone, Debug)]
pub struct Root(PathBuf);

/// The folder of a job.
#[derive(Clone, Debug)]
pub struct JobFolder(PathBuf);

impl Root {
    /// Makes the folder, for its owner only.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn make(dir: &Path) -> io::Result<Self> {
        let private =
            |path: &Path| std::fs::DirBuilder::new().recursive(true).mode(0o700).create(path);
        private(dir)?;
        let root = Self(std::fs::canonicalize(dir)?);
        private(&root.0.join("jobs"))?;
        Ok(root)
    }

    /// Returns a path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Returns the folder of a job.
    pub fn job(&self, id: i64) -> JobFolder {
        JobFolder(self.0.join("jobs").join(id.to_string()))
    }
}

impl JobFolder {
    /// Returns the folder itself.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Returns the folder of the submitted files.
    pub fn input(&self) -> PathBuf {
        self.0.join("input")
    }

    /// Returns the folder of results.
    pub fn results(&self) -> PathBuf {
        self.0.join("results")
    }

    /// Returns the name of the file of an attempt.
    pub fn attempt_name(attempt: u32) -> String {
        format!("attempt-{attempt}")
    }

    /// Returns the file of an attempt.
    pub fn attempt(&self, attempt: u32) -> PathBuf {
        self.0.join(Self::attempt_name(attempt))
    }

    /// Returns the file with what `crumple check` found.
    pub fn findings(&self) -> PathBuf {
        self.0.join("check.json")
    }

    /// Returns the file with what `crumple run` said.
    pub fn output(&self) -> PathBuf {
        self.0.join("output.txt")
    }

    /// Returns a file that clients may read, by its path in the folder.
    ///
    /// # Errors
    /// The name is refused, or there is no such file; the kind of the error says which.
    pub fn readable(&self, name: &str) -> io::Result<PathBuf> {
        let refused = |why: String| io::Error::new(io::ErrorKind::InvalidInput, why);
        let path = self.0.join(relative(name).map_err(refused)?);
        let folder = std::fs::canonicalize(&self.0)?;
        // Links, sockets and devices are no files of a job.
        if !is_within(&folder, &path) || !std::fs::symlink_metadata(&path)?.is_file() {
            return Err(io::ErrorKind::NotFound.into());
        }
        Ok(path)
    }

    /// Returns all files of the job with their sizes, sorted.
    pub fn files(&self) -> Vec<(String, u64)> {
        let mut found = Vec::new();
        let mut open = vec![self.0.clone()];
        while let Some(folder) = open.pop() {
            for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
                // `DirEntry::metadata` does not follow links.
                let Ok(about) = entry.metadata() else { continue };
                if about.is_dir() {
                    open.push(entry.path());
                } else if about.is_file()
                    && found.len() < MOST_FILES
                    && let Ok(name) = entry.path().strip_prefix(&self.0)
                {
                    found.push((name.to_string_lossy().into_owned(), about.len()));
                }
            }
        }
        found.sort();
        found
    }
}

/// Returns a path that cannot leave a folder, or the reason why it is refused.
///
/// # Errors
/// It is empty, absolute, too long or too deep, or has `..`, `.`, backslashes, control characters
/// or names that begin with a point.
pub fn relative(name: &str) -> Result<PathBuf, String> {
    let refused = |why: &str| {
        let shown: String = name.chars().take(80).filter(|c| !c.is_control()).collect();
        Err(format!("the file name `{shown}` is refused: {why}"))
    };
    if name.is_empty() || name.len() > LONGEST {
        return refused(&format!("give 1 to {LONGEST} bytes"));
    }
    if name.chars().any(|c| c.is_control() || c == '\\') {
        return refused("it has control characters or backslashes");
    }
    if name.split('/').any(|part| part.is_empty() || part.starts_with('.')) {
        return refused("give a path without empty names and names that begin with a point");
    }
    let path = Path::new(name);
    if path.components().count() > DEEPEST {
        return refused(&format!("it has more than {DEEPEST} folders"));
    }
    match path.components().all(|c| matches!(c, Component::Normal(_))) {
        true => Ok(path.to_path_buf()),
        false => refused("it leaves the folder of the job"),
    }
}

/// Makes the folders of a path and the file, which must not exist.
///
/// # Errors
/// It exists, or cannot be made.
pub fn create(folder: &Path, path: &Path) -> io::Result<std::fs::File> {
    let whole = folder.join(path);
    if let Some(parent) = whole.parent() {
        std::fs::create_dir_all(parent)?;
    }
    std::fs::File::create_new(whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_could_leave_the_folder_are_refused() {
        let long = "a".repeat(LONGEST + 1);
        let deep = "a/".repeat(DEEPEST) + "b";
        for name in [
            "",
            "/",
            "/etc/passwd",
            "..",
            "../x",
            "a/../x",
            "a/..",
            "./a",
            "a/./b",
            "a//b",
            "a/",
            ".ssh/x",
            "a/.x",
            "a\\b",
            "..\\x",
            "C:\\x",
            "a\0b",
            "a\nb",
            "a\rb",
            "\u{7f}",
            &long,
            &deep,
        ] {
            assert!(relative(name).is_err(), "{name:?}");
        }
        for name in ["job.toml", "a/b c.k", "-x", "mesh..k", "ü.k", "%2e%2e", "C:x"] {
            assert_eq!(relative(name), Ok(PathBuf::from(name)));
        }
    }

    #[test]
    fn only_plain_files_of_the_job_can_be_read() {
        let dir = tempfile::tempdir().unwrap();
        let root = Root::make(&dir.path().join("service")).unwrap();
        let job = root.job(7);
        std::fs::create_dir_all(job.results().join("sub")).unwrap();
        std::fs::write(job.results().join("a"), "").unwrap();
        std::fs::write(root.path("service.db"), "").unwrap();
        std::os::unix::fs::symlink("../../service.db", job.path().join("link")).unwrap();
        std::os::unix::fs::symlink("..", job.path().join("up")).unwrap();
        let _socket = std::os::unix::net::UnixListener::bind(job.results().join("s")).unwrap();
        assert!(job.readable("results/a").is_ok());
        for name in ["link", "up/8", "results", "results/sub", "results/s", "results/absent"] {
            let error = job.readable(name).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::NotFound, "{name}: {error}");
        }
        assert_eq!(job.files(), [("results/a".to_string(), 0)]);
        assert!(create(&job.results(), Path::new("a")).is_err(), "files are not replaced");
    }
}
