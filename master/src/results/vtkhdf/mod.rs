//! `crumple export-vtkhdf`: exports the fields of a run as one temporal VTKHDF file, with the
//! cargo feature `vtkhdf`.
//!
//! The export uses the field files after the run: `snapshot.rs` joins the workers' pieces of a
//! step, `file.rs` appends steps to the file. Format: VTK File Formats, VTKHDF, version 2.0,
//! unstructured grids with `Steps`.

#[cfg(feature = "vtkhdf")]
mod file;
#[cfg(feature = "vtkhdf")]
mod snapshot;

use std::path::Path;

/// Name of the file.
pub const NAME: &str = "fields.vtkhdf";

/// Exports the run in `dir`, prints the file written, and returns the exit code.
pub fn run(dir: &Path) -> u8 {
    match export(dir) {
        Ok(said) => {
            crate::stdout::write(format_args!("{said}\n"));
            0
        }
        Err(why) => {
            eprintln!("error: {why}");
            crate::input::job::Report::EXIT_CODE
        }
    }
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
    let collection = dir.join("fields").join(crate::results::fields::COLLECTION);
    let steps = crate::results::field_file::steps(&collection)?;
    if steps.is_empty() {
        return Err(format!("{} lists no step; run the job with fields", collection.display()));
    }
    let path = dir.join(NAME);
    let unfinished = dir.join(format!("{NAME}.part"));
    let mut file =
        file::Writer::create(&unfinished).map_err(|e| format!("{}: {e}", unfinished.display()))?;
    for step in &steps {
        file.append(snapshot::Snapshot::read(step)?)
            .map_err(|e| format!("{}: {e}", unfinished.display()))?;
    }
    file.finish().map_err(|e| format!("{}: {e}", unfinished.display()))?;
    std::fs::rename(&unfinished, &path).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(format!("VTKHDF: {} steps; open {}", steps.len(), path.display()))
}
