//! `crumple export-exodus`: exports the fields of a run as one EXODUS II file (Schoof & Yarberry
//! 1994, SAND92-2137) in the 64-bit offset format of netCDF, for ParaView, Ensight and SEACAS.
//!
//! The export uses the field files after the run: `master/src/results/snapshot.rs` joins the
//! workers' pieces of a step, `file.rs` writes the step as a record. A part is an element block,
//! with a second block if it has shells of three nodes too. Elements that have failed have the
//! value 0 of the variable `status`, and 0 of all others.

mod file;

use crate::results::field_file::steps;
use crate::results::fields::{COLLECTION, DIR};
use crate::results::snapshot::Snapshot;
use crate::results::summary::part_names;
use crumple_proto::disk::watched;
use std::path::Path;

/// Name of the file.
pub const NAME: &str = "fields.exo";

/// Exports the run in `dir`, prints the file written, and returns the exit code.
pub fn run(dir: &Path) -> u8 {
    crate::stdout::ended(export(dir))
}

/// Writes the fields of the run in `dir` as one file. Returns a message about the file.
///
/// # Errors
/// There are no fields or they cannot be read, an id has more than 31 bits, or the file cannot be
/// written.
pub fn export(dir: &Path) -> Result<String, String> {
    let collection = dir.join(DIR).join(COLLECTION);
    let steps = steps(&collection)?;
    let Some(first) = steps.first() else {
        return Err(format!("{} lists no step; run the job with fields", collection.display()));
    };
    let model = file::ExodusModel::new(&Snapshot::read(first)?, &part_names(dir))?;
    let data = model.definition(steps.len()).map_err(|e| format!("{NAME}: {e:?}"))?;
    let path = dir.join(NAME);
    let unfinished = dir.join(format!("{NAME}.part"));
    let failed = |error: String| format!("{}: {error}", unfinished.display());
    let mut writer =
        watched(&unfinished, || file::ExodusWriter::create(&unfinished, &model, &data))
            .map_err(failed)?;
    for (record, step) in steps.iter().enumerate() {
        let snapshot = Snapshot::read(step)?;
        watched(&unfinished, || writer.write_step(record, &snapshot)).map_err(failed)?;
    }
    watched(&unfinished, || writer.finish()).map_err(failed)?;
    let rename = || std::fs::rename(&unfinished, &path);
    watched(&path, rename).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(format!("EXODUS II: {} steps; open {}", steps.len(), path.display()))
}
