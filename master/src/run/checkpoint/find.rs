//! Finds the newest checkpoint that is whole, and removes what a dead run has left.

use super::MasterState;
use super::manifest::{MANIFEST, Manifest};
use crumple_proto::checkpoint::{read, verify};
use crumple_proto::wire;
use std::path::{Path, PathBuf};

/// Name of the folder of all checkpoints in the folder of a run.
pub const DIR: &str = "checkpoints";

/// A whole checkpoint from which a run continues.
pub struct Resumption {
    /// Folder of the run.
    pub run: PathBuf,
    /// Folder of the checkpoint.
    pub folder: PathBuf,
    /// Its manifest.
    pub manifest: Manifest,
    /// State of the master.
    pub master: MasterState,
    /// Newer checkpoints that could not be used, with the reasons.
    pub refused: Vec<String>,
}

/// Returns the folders of checkpoints in a folder, the newest first.
pub fn folders(dir: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(dir) else { return Vec::new() };
    let is_one = |path: &PathBuf| {
        path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("cycle_"))
    };
    let mut found: Vec<PathBuf> =
        entries.filter_map(|e| e.ok().map(|e| e.path())).filter(is_one).collect();
    found.sort();
    found.reverse();
    found
}

/// Reads a checkpoint and checks all its files.
fn check(folder: &Path) -> Result<(Manifest, MasterState), String> {
    let manifest = Manifest::read(folder)?;
    manifest.files().try_for_each(|file| verify(folder, file))?;
    let words = read(folder, &manifest.master)?;
    let master = wire::decode(&words)
        .ok_or_else(|| format!("{}: the state of the master is not valid", folder.display()))?;
    Ok((manifest, master))
}

/// Returns the folder of the run, for this folder or that of one of its checkpoints.
///
/// # Errors
/// The folder does not exist.
pub fn run_folder(dir: &Path) -> Result<PathBuf, String> {
    let canonical = std::fs::canonicalize(dir).map_err(|e| format!("{}: {e}", dir.display()))?;
    let single = canonical.join(MANIFEST).exists();
    Ok(canonical.ancestors().nth(if single { 2 } else { 0 }).unwrap_or(&canonical).to_owned())
}

/// Finds the newest whole checkpoint in the folder of a run, or reads the one in this folder.
///
/// # Errors
/// There is none; the message says what was found instead.
pub fn find(dir: &Path) -> Result<Resumption, String> {
    let canonical = std::fs::canonicalize(dir).map_err(|e| format!("{}: {e}", dir.display()))?;
    let single = canonical.join(MANIFEST).exists();
    let candidates = if single { vec![canonical.clone()] } else { folders(&canonical.join(DIR)) };
    let mut refused = Vec::new();
    for folder in candidates {
        match check(&folder) {
            Ok((manifest, master)) => {
                return Ok(Resumption { run: run_folder(dir)?, folder, manifest, master, refused });
            }
            Err(why) => refused.push(why),
        }
    }
    let mut message = format!(
        "{}: there is no whole checkpoint; give the folder of a run, with `{DIR}` in it, or of one \
         checkpoint",
        dir.display()
    );
    refused.iter().for_each(|why| message += &format!("\n  {why}"));
    Err(message)
}

/// Returns the cycle of the newest checkpoint of a run that has a manifest.
pub fn newest_cycle(run: &Path) -> Option<u64> {
    folders(&run.join(DIR)).iter().find_map(|f| Manifest::read(f).ok()).map(|m| m.captured.cycle)
}

/// Removes what a run that has ended left after its checkpoint: folders without manifest, and
/// checkpoints of later cycles.
pub fn tidy(dir: &Path, kept: Option<&Path>) {
    for folder in folders(dir) {
        let later = kept.is_some_and(|kept| folder.file_name() > kept.file_name());
        if kept.is_none() || later || !folder.join(MANIFEST).exists() {
            // If this fails, the next checkpoint of that cycle replaces the files.
            let _ = std::fs::remove_dir_all(folder);
        }
    }
}
