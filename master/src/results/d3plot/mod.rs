//! `crumple export-d3plot`: exports the fields of a run as LS-DYNA's state database, for
//! post-processors that read it.
//!
//! The export uses the field files after the run: `source.rs` reads them, `format.rs` defines the
//! layout. It contains coordinates, velocities, stress and plastic strain of solids and shells,
//! thickness of shells, and the deletion table. Fields have one stress per element (at the middle
//! surface of a shell) and the largest plastic strain over the thickness, so the database has one
//! integration point with these values; with `output.points` it has all points. Strains are those
//! of `strain.rs`. The internal energy of single elements is not known and is written as zero.
//! Global energies are those of `history.csv`, interpolated.

mod format;
mod source;
mod strain;

use crumple_worker::vtu::write_whole;
use format::DatabaseLayout;
use source::FieldSource;
use std::io;
use std::path::{Path, PathBuf};
use strain::StrainedMesh;

/// Name of the first file. Files of states add a number to it.
pub const NAME: &str = "d3plot";

/// Exports the run in `dir`, prints the files written, and returns the exit code.
pub fn run(dir: &Path, file_size: u64, strains: bool) -> u8 {
    crate::stdout::ended(export(dir, file_size * 1_000_000, strains))
}

/// Writes the database of the run in `dir` next to its fields, in files of at most `limit` bytes
/// or one state; with `strains`, also strains. Returns a message about the files.
///
/// # Errors
/// There are no fields or they cannot be read, an id does not fit into the format, or a file
/// cannot be written.
pub fn export(dir: &Path, limit: u64, strains: bool) -> Result<String, String> {
    let mut source = FieldSource::open(dir)?;
    let mesh = source.mesh()?;
    let mut strains = strains.then(|| StrainedMesh::new(&mesh));
    let format = DatabaseLayout::new(mesh, strains.is_some());
    let path = dir.join(NAME);
    remove_family(dir).map_err(|e| format!("{}: {e}", path.display()))?;
    let failed = |e: io::Error| e.to_string();
    write_whole(&path, |out| format.write_geometry(out)).map_err(failed)?;
    let states = source.states();
    let most = (limit / format.state_bytes()).max(1) as usize;
    let mut files = 1;
    for (number, run) in (0..states).collect::<Vec<_>>().chunks(most).enumerate() {
        let file = dir.join(format!("{NAME}{:02}", number + 1));
        let fill = |out: &mut dyn io::Write| {
            let mut words = 0;
            for &i in run {
                let state = source.state(i).map_err(io::Error::other)?;
                let strained = strains.as_mut().map(|mesh| mesh.at(state));
                words += format.write_state(out, state, strained.as_ref())?;
            }
            format.end(out, words)
        };
        write_whole(&file, fill).map_err(failed)?;
        files += 1;
    }
    let (open, missing) = (path.display(), source.missing());
    Ok(format!("d3plot: {states} states in {files} files; open {open}{missing}"))
}

/// Removes the files of an earlier export.
fn remove_family(dir: &Path) -> io::Result<()> {
    let belongs = |path: &PathBuf| {
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        name.strip_prefix(NAME).is_some_and(|rest| rest.chars().all(|c| c.is_ascii_digit()))
    };
    for entry in std::fs::read_dir(dir)? {
        let path = entry?.path();
        if belongs(&path) && path.is_file() {
            std::fs::remove_file(path)?;
        }
    }
    Ok(())
}
