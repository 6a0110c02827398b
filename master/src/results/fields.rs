//! The time series of the workers' field files, for ParaView.
//!
//! Workers write `fields/step_000012/piece_003.vtu` (own elements) and `exterior_003.vtu` (ghost
//! elements). This module writes the files that connect them: a `.pvtu` per step, and the
//! collections `fields.pvd` and `exterior.pvd` that a user opens. Ghosts have a separate
//! collection, so that every element appears once in the main one. Files are renamed into place,
//! so that collections are complete at any moment, even if the run is killed.

use crumple_worker::vtu::{self, Array, OptionalArrays};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Name of the folder of fields in that of a run.
pub const DIR: &str = "fields";
/// The main collection.
pub const COLLECTION: &str = "fields.pvd";
/// The collection of ghosts; only written with more than one worker.
pub const EXTERIOR_COLLECTION: &str = "exterior.pvd";

const STEP_FILE: &str = "fields.pvtu";
const STEP_EXTERIOR_FILE: &str = "exterior.pvtu";

/// A growing time series of field files.
#[derive(Debug)]
pub struct FieldSeries {
    dir: PathBuf,
    /// Index and time of the steps so far, in order of arrival.
    steps: Vec<(usize, f64)>,
    /// Arrays that the pieces have in addition to those of all runs.
    optional: OptionalArrays,
}

impl FieldSeries {
    /// Creates an empty series in the folder `dir`. Nothing is written before the first step.
    pub fn new(dir: &Path, optional: OptionalArrays) -> Self {
        Self { dir: dir.to_owned(), steps: Vec::new(), optional }
    }

    /// Continues a series after a checkpoint: removes all other steps in the folder.
    ///
    /// # Errors
    /// A step cannot be removed, or a collection cannot be written.
    pub fn restore(&mut self, steps: &[(usize, f64)]) -> io::Result<()> {
        let kept: Vec<String> = steps.iter().map(|s| vtu::step_folder(s.0)).collect();
        let entries = match std::fs::read_dir(&self.dir) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            entries => entries?,
        };
        for entry in entries {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if entry.file_type()?.is_dir() && !kept.contains(&name) {
                std::fs::remove_dir_all(entry.path())?;
            }
        }
        self.steps = steps.to_vec();
        if steps.is_empty() { Ok(()) } else { self.write_collections() }
    }

    /// Returns the steps so far.
    pub fn steps(&self) -> &[(usize, f64)] {
        &self.steps
    }

    /// Writes the collections. Steps with one worker have no ghosts.
    fn write_collections(&self) -> io::Result<()> {
        write_collection(&self.dir.join(COLLECTION), STEP_FILE, &self.steps)?;
        let has_ghosts = |step: &&(usize, f64)| {
            self.dir.join(vtu::step_folder(step.0)).join(STEP_EXTERIOR_FILE).exists()
        };
        let steps: Vec<_> = self.steps.iter().filter(has_ghosts).copied().collect();
        if steps.is_empty() {
            return Ok(());
        }
        write_collection(&self.dir.join(EXTERIOR_COLLECTION), STEP_EXTERIOR_FILE, &steps)
    }

    /// Returns the folder of the series.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Adds a step, after all its `workers` have written their pieces. Replaces a step of the
    /// same index.
    pub fn add(&mut self, step_index: usize, time: f64, workers: usize) -> io::Result<()> {
        let folder = self.dir.join(vtu::step_folder(step_index));
        let optional = self.optional;
        write_step(&folder.join(STEP_FILE), (0..workers).map(vtu::piece_name), optional)?;
        self.steps.retain(|&(index, _)| index != step_index);
        self.steps.push((step_index, time));
        if workers > 1 {
            let pieces = (0..workers).map(vtu::exterior_name);
            write_step(&folder.join(STEP_EXTERIOR_FILE), pieces, optional)?;
        }
        self.write_collections()
    }
}

fn write_step(
    path: &Path,
    pieces: impl Iterator<Item = String>,
    optional: OptionalArrays,
) -> io::Result<()> {
    vtu::write_whole(path, |out| {
        let order = vtu::BYTE_ORDER;
        writeln!(out, r#"<?xml version="1.0"?>"#)?;
        writeln!(
            out,
            r#"<VTKFile type="PUnstructuredGrid" version="1.0" byte_order="{order}" header_type="UInt64">"#
        )?;
        writeln!(out, r#"<PUnstructuredGrid GhostLevel="0">"#)?;
        write_arrays(out, "PPoints", &[vtu::POINTS])?;
        write_arrays(out, "PPointData", &optional.point_arrays())?;
        write_arrays(out, "PCellData", &optional.cell_arrays())?;
        for piece in pieces {
            writeln!(out, r#"<Piece Source="{piece}"/>"#)?;
        }
        writeln!(out, "</PUnstructuredGrid>\n</VTKFile>")
    })
}

fn write_arrays(out: &mut dyn Write, place: &str, arrays: &[Array]) -> io::Result<()> {
    writeln!(out, "<{place}>")?;
    for Array { name, components, kind } in arrays {
        let kind = kind.vtk_name();
        writeln!(
            out,
            r#"<PDataArray type="{kind}" Name="{name}" NumberOfComponents="{components}"/>"#
        )?;
    }
    writeln!(out, "</{place}>")
}

fn write_collection(path: &Path, file: &str, steps: &[(usize, f64)]) -> io::Result<()> {
    vtu::write_whole(path, |out| {
        writeln!(out, r#"<?xml version="1.0"?>"#)?;
        writeln!(
            out,
            r#"<VTKFile type="Collection" version="0.1" byte_order="{}">"#,
            vtu::BYTE_ORDER
        )?;
        writeln!(out, "<Collection>")?;
        for (index, time) in steps {
            let folder = vtu::step_folder(*index);
            writeln!(
                out,
                r#"<DataSet timestep="{time}" group="" part="0" file="{folder}/{file}"/>"#
            )?;
        }
        writeln!(out, "</Collection>\n</VTKFile>")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_step_written_again_stands_once_and_one_worker_has_no_exterior() {
        let dir = tempfile::tempdir().unwrap();
        let mut series = FieldSeries::new(dir.path(), OptionalArrays::default());
        series.add(0, 0.0, 1).unwrap();
        series.add(7, 1.0, 1).unwrap();
        series.add(7, 1.5, 1).unwrap();
        let text = fs::read_to_string(series.dir().join(COLLECTION)).unwrap();
        assert_eq!(text.matches("<DataSet").count(), 2);
        assert!(text.contains(r#"timestep="1.5""#));
        assert!(!dir.path().join(EXTERIOR_COLLECTION).exists());
    }
}
