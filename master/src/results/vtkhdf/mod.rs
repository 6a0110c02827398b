//! `crumple export-vtkhdf`: exports the fields of a run as one temporal VTKHDF file, with the
//! cargo feature `vtkhdf`.
//!
//! The export uses the field files after the run: `master/src/results/snapshot.rs` joins the
//! workers' pieces of a step, `file.rs` appends steps to the file. Format: VTK File Formats,
//! VTKHDF, version 2.0, unstructured grids with `Steps`.

#[cfg(feature = "vtkhdf")]
mod file;

#[cfg(feature = "vtkhdf")]
use crumple_proto::disk::watched;
use std::path::Path;

/// Name of the file.
pub const NAME: &str = "fields.vtkhdf";

/// Exports the run in `dir`, prints the file written, and returns the exit code.
pub fn run(dir: &Path) -> u8 {
    crate::stdout::ended(export(dir))
}

/// Writes the fields of the run in `dir` as one file. Returns a message about the file.
///
/// # Errors
/// There are no fields or they cannot be read, the file cannot be written, or this build lacks
/// the feature.
#[cfg(not(feature = "vtkhdf"))]
pub fn export(_: &Path) -> Result<String, String> {
    Err(format!("{}; {}", crate::features::NO_VTKHDF, crate::features::ADD_VTKHDF))
}

/// Writes the fields of the run in `dir` as one file. Returns a message about the file.
///
/// # Errors
/// There are no fields or they cannot be read, or the file cannot be written.
#[cfg(feature = "vtkhdf")]
pub fn export(dir: &Path) -> Result<String, String> {
    use crate::results::{field_file, fields};
    let collection = dir.join(fields::DIR).join(fields::COLLECTION);
    let steps = field_file::steps(&collection)?;
    if steps.is_empty() {
        return Err(format!("{} lists no step; run the job with fields", collection.display()));
    }
    let path = dir.join(NAME);
    let unfinished = dir.join(format!("{NAME}.part"));
    let failed = |e: rust_hdf5::Hdf5Error| format!("{}: {e}", unfinished.display());
    let create = || file::VtkhdfWriter::create(&unfinished);
    let mut file = watched(&unfinished, create).map_err(failed)?;
    for step in &steps {
        let snapshot = crate::results::snapshot::Snapshot::read(step)?;
        watched(&unfinished, || file.append(snapshot)).map_err(failed)?;
    }
    watched(&unfinished, || file.finish()).map_err(failed)?;
    let rename = || std::fs::rename(&unfinished, &path);
    watched(&path, rename).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(format!("VTKHDF: {} steps; open {}", steps.len(), path.display()))
}
