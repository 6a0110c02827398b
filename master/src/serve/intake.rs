//! Files of a job as they arrive: each has a name of its own that cannot leave the folder.

use super::folder::{create, relative};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// Most files of a job.
const MOST_FILES: usize = 2000;

/// Why files of a job are not taken.
#[derive(Debug)]
pub enum IntakeFault {
    /// A name or an archive is refused; the text names it and the rule.
    Refused(String),
    /// There is too much of something.
    TooMuch(String),
    /// It takes too long.
    Late(String),
    /// The disk has no room.
    Full(String),
    /// A file cannot be written.
    Failed(io::Error),
}

/// Result of taking files.
pub type Taken<T> = Result<T, IntakeFault>;

/// The files of a job so far.
pub struct Intake {
    input: PathBuf,
    /// Exact name, and whether it is a file, by the name in lower case.
    names: HashMap<String, (PathBuf, bool)>,
    files: Vec<PathBuf>,
}

impl Intake {
    /// Returns an empty intake for the folder `input`.
    pub fn new(input: PathBuf) -> Self {
        Self { input, names: HashMap::new(), files: Vec::new() }
    }

    /// Returns the paths of all files, in the order of their arrival.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Makes a file.
    ///
    /// # Errors
    /// Its name is refused, there are too many files, or it cannot be made.
    pub fn create(&mut self, name: &str) -> Taken<File> {
        if self.files.len() >= MOST_FILES {
            return Err(IntakeFault::TooMuch(format!("a job has at most {MOST_FILES} files")));
        }
        let path = relative(name).map_err(IntakeFault::Refused)?;
        self.claim(&path, true)?;
        let file = create(&self.input, &path).map_err(|error| match error.kind() {
            io::ErrorKind::InvalidFilename => {
                IntakeFault::Refused("a file name is too long".into())
            }
            _ => IntakeFault::Failed(error),
        })?;
        self.files.push(path);
        Ok(file)
    }

    /// Checks the name of a folder. It is made with its first file.
    ///
    /// # Errors
    /// It is refused.
    pub fn folder(&mut self, name: &str) -> Taken<()> {
        let path = relative(name).map_err(IntakeFault::Refused)?;
        self.claim(&path, false)
    }

    /// Takes the names of a path and of its folders. On file systems that ignore case, names that
    /// differ only by case are one.
    fn claim(&mut self, path: &Path, is_file: bool) -> Taken<()> {
        for part in path.ancestors().filter(|part| !part.as_os_str().is_empty()) {
            let is_file = is_file && part == path;
            let taken = match self.names.entry(part.to_string_lossy().to_lowercase()) {
                Entry::Vacant(free) => {
                    free.insert((part.into(), is_file));
                    continue;
                }
                Entry::Occupied(taken) => taken,
            };
            let (known, was_file) = taken.get();
            let why = match known == part {
                true if !was_file && !is_file => continue,
                true if part == path => "it is given twice".into(),
                true => format!("`{}` is a file", part.display()),
                false => format!("`{}` differs from it only by case", known.display()),
            };
            let shown = path.display();
            return Err(IntakeFault::Refused(format!("the file name `{shown}` is refused: {why}")));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_given_once_whatever_their_case() {
        let folder = tempfile::tempdir().unwrap();
        let mut intake = Intake::new(folder.path().into());
        intake.create("a/b.k").unwrap();
        intake.create("a/c.k").unwrap();
        intake.folder("a").unwrap();
        intake.folder("d").unwrap();
        for (name, why) in [
            ("a/b.k", "it is given twice"),
            ("A/d.k", "only by case"),
            ("a/B.k", "only by case"),
            ("a/b.k/c", "`a/b.k` is a file"),
            ("d", "it is given twice"),
            ("../x", "begin with a point"),
        ] {
            match intake.create(name) {
                Err(IntakeFault::Refused(said)) => assert!(said.contains(why), "{name}: {said}"),
                other => panic!("{name}: {other:?}"),
            }
        }
        assert_eq!(intake.files(), [PathBuf::from("a/b.k"), PathBuf::from("a/c.k")]);
    }
}
