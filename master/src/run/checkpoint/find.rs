//! Finds the newest checkpoint that is whole, and removes what a dead run has left.

use super::MasterState;
use super::manifest::{MANIFEST, Manifest, Stamp, sync};
use crate::input::job::Model;
use crate::results::history;
use crate::results::table::Tables;
use crumple_proto::checkpoint::{PARTIAL, read};
use crumple_proto::disk::watched;
use crumple_proto::message::Changes;
use crumple_proto::partition::ElementRecord;
use crumple_worker::checkpoint::fit::{Expected, InitialModel, verify};
use crumple_worker::checkpoint::layout::difference;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// Name of the folder of all checkpoints in the folder of a run.
pub const DIR: &str = "checkpoints";

/// Advice for a wrong folder.
const GIVE: &str = "give the folder of a run, with `checkpoints` in it, or of one checkpoint";

/// Mark in the name of a checkpoint that another one of the same cycle replaces.
const OLD: &str = ".old";

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
    /// Changes of the model; none until the job is known.
    pub changes: Changes,
    /// Newer checkpoints that could not be used, with the reasons.
    pub refused: Vec<String>,
    /// Messages about rows of histories that are lost.
    pub lost: Vec<String>,
    /// Complete checkpoints of later cycles, removed when the run continued.
    pub removed: Vec<PathBuf>,
}

/// Returns the folders of checkpoints in a folder, the newest first.
pub fn folders(dir: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(dir) else { return Vec::new() };
    let is_one = |path: &PathBuf| {
        path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("cycle_"))
    };
    let mut found: Vec<PathBuf> =
        entries.filter_map(|e| e.ok().map(|e| e.path())).filter(is_one).collect();
    // A folder in which a checkpoint was written is newer than one of its cycle with its own name,
    // and that is newer than one that was replaced.
    let order = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let (own, mark) = name.split_at(name.find('.').unwrap_or(name.len()));
        (own.to_owned(), if mark == OLD { 0 } else { 1 }, mark.to_owned())
    };
    found.sort_by_cached_key(order);
    found.reverse();
    found
}

/// Gives a complete checkpoint, in the folder in which it was written, its own name. A checkpoint
/// of the same cycle that has it is removed afterwards: at each moment one of them is whole.
/// Returns the new path.
///
/// # Errors
/// It cannot be renamed; the message names the folder.
pub fn publish(folder: &Path) -> Result<PathBuf, String> {
    let Some((own, old)) = names(folder) else { return Ok(folder.to_owned()) };
    let rename = |from: &Path, to: &Path| {
        std::fs::rename(from, to).map_err(|error| format!("{}: {error}", from.display()))
    };
    if own.exists() {
        let _ = std::fs::remove_dir_all(&old); // of a run that ended while it replaced one
        rename(&own, &old)?;
    }
    rename(folder, &own)?;
    let _ = own.parent().map(sync); // if a machine fails, any of the names is found
    let _ = std::fs::remove_dir_all(&old); // it is found after the new one, and removed in time
    Ok(own)
}

/// Returns the final name of a folder in which a checkpoint is written, and that of the folder
/// which it replaces.
fn names(folder: &Path) -> Option<(PathBuf, PathBuf)> {
    let name = folder.file_name()?.to_str()?;
    let (own, _) = name.split_once(PARTIAL)?;
    Some((folder.with_file_name(own), folder.with_file_name(format!("{own}{OLD}"))))
}

/// Returns the folder of the run, for this folder or that of one of its checkpoints.
///
/// # Errors
/// The folder does not exist, or it has no checkpoints and is none.
pub fn run_folder(dir: &Path) -> Result<PathBuf, String> {
    let named = |why: String| format!("{}: {why}", dir.display());
    let canonical = watched(dir, || std::fs::canonicalize(dir));
    let canonical = canonical.map_err(|e| named(e.to_string()))?;
    let single = watched(dir, || canonical.join(MANIFEST).exists());
    if !watched(dir, || canonical.is_dir()) {
        return Err(named(format!("a file; {GIVE}")));
    }
    if !single && watched(dir, || folders(&canonical.join(DIR))).is_empty() {
        let inside = canonical.ancestors().any(|a| a.file_name() == Some(DIR.as_ref()));
        let what = if inside { "not a whole checkpoint" } else { "there are no checkpoints" };
        return Err(named(format!("{what}; {GIVE}")));
    }
    Ok(canonical.ancestors().nth(if single { 2 } else { 0 }).unwrap_or(&canonical).to_owned())
}

/// The checkpoints in the folder of a run from which it could continue, the newest first, or the
/// one in this folder.
pub struct Candidates {
    dir: PathBuf,
    left: VecDeque<PathBuf>,
    /// Those that could not be used, with the reasons.
    refused: Vec<String>,
}

impl Candidates {
    /// Lists the checkpoints of a folder.
    ///
    /// # Errors
    /// The folder does not exist.
    pub fn new(dir: &Path) -> Result<Self, String> {
        let listed = || -> std::io::Result<Vec<PathBuf>> {
            let canonical = std::fs::canonicalize(dir)?;
            let single = canonical.join(MANIFEST).exists();
            Ok(if single { vec![canonical] } else { folders(&canonical.join(DIR)) })
        };
        let listed = watched(dir, listed).map_err(|e| format!("{}: {e}", dir.display()))?;
        Ok(Self { dir: dir.to_owned(), left: listed.into(), refused: Vec::new() })
    }

    /// Returns the next checkpoint with a manifest.
    ///
    /// # Errors
    /// There is none; the message says what was found instead.
    pub fn next_candidate(&mut self) -> Result<(PathBuf, Manifest), String> {
        while let Some(folder) = self.left.pop_front() {
            if names(&folder).is_some() && !watched(&folder, || folder.join(MANIFEST).exists()) {
                continue; // a run has ended while it wrote this one
            }
            match watched(&folder.join(MANIFEST), || Manifest::read(&folder)) {
                Ok(manifest) => return Ok((folder, manifest)),
                Err(why) => self.refuse(why),
            }
        }
        let mut message = format!("{}: there is no whole checkpoint; {GIVE}", self.dir.display());
        self.refused.iter().for_each(|why| message += &format!("\n  {why}"));
        Err(message)
    }

    /// Keeps the reason why a checkpoint cannot be used.
    pub fn refuse(&mut self, why: String) {
        self.refused.push(why);
    }

    /// Returns what a run needs to continue from a checkpoint: reads the state of the master. `job`
    /// has the names of the columns of this program.
    ///
    /// # Errors
    /// It cannot be used; the message names the file.
    pub fn resume_from(
        &self,
        folder: &Path,
        manifest: &Manifest,
        job: &Stamp,
    ) -> Result<Resumption, String> {
        if let Some(why) = difference(&manifest.stamp.layout, &job.layout) {
            return Err(format!(
                "{}: another version of the program ({}) wrote it: {why}",
                folder.join(MANIFEST).display(),
                manifest.program
            ));
        }
        let words = read(folder, &manifest.master)?;
        let master = MasterState::from_words(&words, &manifest.captured)
            .map_err(|why| format!("{}: {why}", folder.join(&manifest.master.name).display()))?;
        Ok(Resumption {
            run: run_folder(&self.dir)?,
            folder: folder.to_owned(),
            manifest: manifest.clone(),
            master,
            changes: Changes::default(),
            refused: self.refused.clone(),
            lost: Vec::new(),
            removed: Vec::new(),
        })
    }
}

impl Resumption {
    /// Checks that all files are a state of the model, with which the run continues.
    ///
    /// # Errors
    /// They are not; the message names the file.
    pub fn validate(&self, model: &Model) -> Result<(), String> {
        let (elements, nodes) = model.records();
        let source = InitialModel { settings: &model.settings, elements: &elements, nodes: &nodes };
        let deleted = &deleted(&self.manifest.stamp.job);
        let is_there =
            |e: &&ElementRecord| !deleted.contains(&model.settings.parts[e.part as usize].id);
        let wanted = elements.iter().filter(is_there).count();
        let Manifest { captured, elements, common, pieces, .. } = &self.manifest;
        if *elements != wanted {
            return Err(format!(
                "{}: it has {elements} of {wanted} elements",
                self.folder.join(MANIFEST).display()
            ));
        }
        let named =
            |why| format!("{}: {why}", self.folder.join(&self.manifest.master.name).display());
        self.master.validate(model).map_err(named)?;
        let expected = Expected { captured: *captured, elements: wanted };
        verify(&self.folder, common, pieces, source, expected)
    }

    /// Lets histories begin again whose files were removed or shortened.
    pub fn begin_lost_histories(&mut self) {
        let (lengths, time) = (&mut self.master.lengths, self.manifest.captured.time);
        self.lost = watched(&self.run, || Tables::take_lost(&self.run, lengths, time));
    }
}

/// Returns the parts that a run had deleted when it continued with this job.
fn deleted(job: &serde_json::Value) -> Vec<u32> {
    let list = job.pointer("/restart/delete").cloned();
    list.and_then(|list| serde_json::from_value(list).ok()).unwrap_or_default()
}

/// Returns the folder and the manifest of the newest checkpoint of a run that has a manifest.
pub fn newest(run: &Path) -> Option<(PathBuf, Manifest)> {
    let with_manifest = |folder: PathBuf| Some((Manifest::read(&folder).ok()?, folder));
    let found = folders(&run.join(DIR)).into_iter().find_map(with_manifest);
    found.map(|(manifest, folder)| (folder, manifest))
}

/// Returns the cycle of the newest checkpoint of a run that has a manifest.
pub fn newest_cycle(run: &Path) -> Option<u64> {
    newest(run).map(|(_, manifest)| manifest.captured.cycle)
}

/// Returns a message if a folder has results of a run, or a checkpoint from which it could
/// continue: a new run would remove them.
pub fn occupied(run: &Path) -> Option<String> {
    let has = |name: &str| run.join(name).is_file();
    let summary = std::fs::read(run.join("summary.json")).unwrap_or_default();
    let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap_or_default();
    let shown = run.display();
    let ways = "remove it with --overwrite, or choose another folder with --out";
    match newest(run).filter(|_| summary["status"] != "completed") {
        Some((folder, manifest)) => Some(format!(
            "{shown} has a run that did not complete, with a checkpoint of cycle {}, time {:.6e}, \
             in {}; continue it with `crumple run --resume {shown}`, {ways}",
            manifest.captured.cycle,
            manifest.captured.time,
            folder.display()
        )),
        None if has("summary.json") || has(history::FILE) => {
            Some(format!("{shown} has the results of a run; {ways}"))
        }
        None => None,
    }
}

/// Removes what a run that has ended left after its checkpoint: folders without manifest, and
/// checkpoints of later cycles; without a checkpoint from which the run continues, all. Returns the
/// complete ones that were removed.
pub fn tidy(dir: &Path, kept: Option<&Path>) -> Vec<PathBuf> {
    let is_later = |folder: &Path| kept.is_none_or(|kept| folder.file_name() > kept.file_name());
    let mut removed = Vec::new();
    for folder in folders(dir) {
        let is_complete = folder.join(MANIFEST).exists();
        if !is_later(&folder) && is_complete {
            continue;
        }
        // If it cannot be removed, it stays, and the run goes on.
        if std::fs::remove_dir_all(&folder).is_ok() && is_complete {
            removed.push(folder);
        }
    }
    removed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two checkpoints of one cycle: the second one replaces the first, and at each moment the
    /// newest that is whole is found first.
    #[test]
    fn a_second_checkpoint_of_a_cycle_replaces_the_first() {
        let dir = tempfile::tempdir().unwrap();
        let written = |name: &str, text: &str| {
            let folder = dir.path().join(name);
            std::fs::create_dir(&folder).unwrap();
            std::fs::write(folder.join(MANIFEST), text).unwrap();
            folder
        };
        let text = |folder: &Path| std::fs::read_to_string(folder.join(MANIFEST)).unwrap();
        let own = publish(&written("cycle_0000000007.part0", "one")).unwrap();
        assert_eq!(
            (own.file_name().unwrap(), &text(&own)[..]),
            ("cycle_0000000007".as_ref(), "one")
        );
        let second = written("cycle_0000000007.part1", "two");
        assert_eq!(folders(dir.path()), [second.clone(), own.clone()]);
        let old = written("cycle_0000000007.old", "a run died while it replaced this one");
        assert_eq!(folders(dir.path()), [second.clone(), own.clone(), old.clone()]);
        std::fs::remove_dir_all(old).unwrap();
        assert_eq!(publish(&second).unwrap(), own);
        assert_eq!(text(&own), "two");
        assert_eq!(folders(dir.path()).len(), 1, "nothing else is left");
        assert_eq!(publish(&own).unwrap(), own, "it has its name");
    }
}
