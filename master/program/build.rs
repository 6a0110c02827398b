//! Passes its commit to the program: the variable `CRUMPLE_COMMIT` of the build if it is set,
//! otherwise that of the folder by git. An archive of the sources has no commit.

use std::path::Path;
use std::process::Command;

/// Root of the repository.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
/// Sources of the program: after a change of one of them, the build is marked as changed.
const SOURCES: [&str; 6] =
    ["Cargo.lock", "cases/src", "master/src", "proto/src", "worker", "tests/verification/src"];

fn main() {
    println!("cargo:rerun-if-env-changed=CRUMPLE_COMMIT");
    let given = std::env::var("CRUMPLE_COMMIT").ok().filter(|text| !text.is_empty());
    let commit = given.or_else(of_git).unwrap_or_default();
    println!("cargo:rustc-env=CRUMPLE_COMMIT={commit}");
}

/// Returns the commit of the sources, with a mark if they were changed since. A repository around
/// an unpacked archive is not that of the sources.
fn of_git() -> Option<String> {
    let whole = |path: &str| Path::new(path).canonicalize().ok();
    if whole(&git(&["rev-parse", "--show-toplevel"])?) != whole(ROOT) {
        return None;
    }
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    println!("cargo:rerun-if-changed={}", Path::new(ROOT).join(log).display());
    for source in SOURCES {
        println!("cargo:rerun-if-changed={ROOT}/{source}");
    }
    git(&["describe", "--always", "--tags", "--abbrev=12", "--dirty=-changed"])
}

/// Returns the answer of git in the root of the repository.
fn git(words: &[&str]) -> Option<String> {
    let done = Command::new("git").arg("-C").arg(ROOT).args(words).output().ok()?;
    let text = String::from_utf8(done.stdout).ok()?;
    Some(text.trim().to_string()).filter(|text| done.status.success() && !text.is_empty())
}
