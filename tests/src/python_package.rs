//! The Python package `crumple` as `pip install .` installs it, without its installation: links to
//! its files, and the compiled part as cargo builds it with the tests.

use crate::program::root;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// Folder with the package.
pub struct PythonPackage(TempDir);

impl PythonPackage {
    /// Links the files of the package.
    ///
    /// # Panics
    /// When the compiled part is missing: this crate depends on it.
    pub fn link() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let package = folder.path().join("crumple");
        fs::create_dir(&package).expect("the folder is empty");
        let sources = fs::read_dir(root().join("master/python/crumple")).expect("the sources");
        for source in sources.map(|source| source.expect("an entry").path()) {
            symlink(&source, package.join(source.file_name().expect("a name"))).expect("a link");
        }
        let test = std::env::current_exe().expect("this program");
        let name = format!("{DLL_PREFIX}crumple_native{DLL_SUFFIX}");
        let native = test.with_file_name(name);
        assert!(Path::is_file(&native), "{} is missing", native.display());
        symlink(native, package.join("_native.abi3.so")).expect("a link");
        Self(folder)
    }

    /// Adds the package to those that a Python finds.
    pub fn add_to(&self, command: &mut Command) {
        command.env("PYTHONPATH", self.0.path()).env("PYTHONDONTWRITEBYTECODE", "1");
    }
}
