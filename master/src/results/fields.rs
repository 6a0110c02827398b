//! The time series of the workers' field files, for ParaView.
//!
//! Workers write `fields/step_000012/piece_003.vtu` (own elements) and `exterior_003.vtu` (ghost
//! elements). This module writes the files that connect them: a `.pvtu` per step, and the
//! collections `fields.pvd` and `exterior.pvd` that a user opens. Ghosts have a separate
//! collection, so that every element appears once in the main one. Files are renamed into place,
//! so that collections are complete at any moment, even if the run is killed.

use crumple_worker::vtu::{self, Array};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The main collection.
pub const COLLECTION: &str = "fields.pvd";
/// The collection of ghosts; only written with more than one worker.
pub const EXTERIOR_COLLECTION: &str = "exterior.pvd";

const STEP_FILE: &str = "fields.pvtu";
const STEP_EXTERIOR_FILE: &str = "exterior.pvtu";

/// A growing time series of field files.
#[derive(Debug)]
pub struct Series {
    dir: PathBuf,
    /// Index and time of the steps so far, in order of arrival.
    steps: Vec<(usize, f64)>,
}

impl Series {
    /// Creates an empty series in the folder `dir`. Nothing is written before the first step.
    pub fn new(dir: &Path) -> Self {
        Self { dir: dir.to_owned(), steps: Vec::new() }
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
        write_step(&folder.join(STEP_FILE), (0..workers).map(vtu::piece_name))?;
        self.steps.retain(|&(index, _)| index != step_index);
        self.steps.push((step_index, time));
        if workers > 1 {
            write_step(&folder.join(STEP_EXTERIOR_FILE), (0..workers).map(vtu::exterior_name))?;
        }
        self.write_collections()
    }
}

fn write_step(path: &Path, pieces: impl Iterator<Item = String>) -> io::Result<()> {
    vtu::write_whole(path, |out| {
        let order = vtu::BYTE_ORDER;
        writeln!(out, r#"<?xml version="1.0"?>"#)?;
        writeln!(
            out,
            r#"<VTKFile type="PUnstructuredGrid" version="1.0" byte_order="{order}" header_type="UInt64">"#
        )?;
        writeln!(out, r#"<PUnstructuredGrid GhostLevel="0">"#)?;
        write_arrays(out, "PPoints", &[vtu::POINTS])?;
        write_arrays(out, "PPointData", vtu::POINT_ARRAYS)?;
        write_arrays(out, "PCellData", vtu::CELL_ARRAYS)?;
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
    use crumple_proto::mesh::Shape;
    use crumple_worker::vtu::{Cells, Piece};
    use std::fs;
    use std::ops::Range;
    use std::process::Command;

    /// Writes the unit squares `squares` of a falling strip. Ids follow from the position, so
    /// that neighbouring pieces share nodes.
    fn write_strip(
        path: &Path,
        time: f64,
        worker: u32,
        classes: &[u8],
        squares: Range<u32>,
    ) -> io::Result<()> {
        let n = squares.len();
        let columns = if n == 0 { 0..0 } else { squares.start..squares.end + 1 };
        let corners: Vec<(u32, u32)> = columns.flat_map(|i| [(i, 0), (i, 1)]).collect();
        let fall = -time as f32;
        let mut cells = Cells::default();
        for i in 0..n as u32 {
            cells.push(Shape::Quad4, &[2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]);
        }
        Piece {
            time,
            points: &corners.iter().map(|&(i, j)| [i as f32, j as f32, fall]).collect::<Vec<_>>(),
            point_arrays: &[
                vtu::DISPLACEMENT.with(&vec![[0.0, 0.0, fall]; corners.len()]),
                vtu::VELOCITY.with(&vec![[0.0, 0.0, -1.0]; corners.len()]),
                vtu::ROTATIONAL_VELOCITY.with(&vec![[0.0_f32; 3]; corners.len()]),
                vtu::NODE_ID.with(
                    &corners.iter().map(|&(i, j)| i64::from(2 * i + j + 1)).collect::<Vec<_>>(),
                ),
            ],
            cells: &cells,
            cell_arrays: &[
                vtu::PLASTIC_STRAIN.with(&vec![0.5_f32; n]),
                vtu::VON_MISES.with(&vec![0.25_f32; n]),
                vtu::STRESS.with(&vec![[1.0, 2.0, 3.0, 4.0, 5.0, 6.0_f32]; n]),
                vtu::THICKNESS.with(&vec![2.0_f32; n]),
                vtu::PART.with(&vec![1_u32; n]),
                vtu::WORKER.with(&vec![worker; n]),
                vtu::CLASS.with(classes),
                vtu::ELEMENT_ID.with(&squares.map(|i| 100 + i64::from(i)).collect::<Vec<_>>()),
            ],
        }
        .write(path)
    }

    /// Three workers hold squares 0..2, 2..5 and none. Each of the first two has a ghost of the
    /// other's outermost square.
    fn write_series(dir: &Path) -> io::Result<()> {
        use vtu::{EXTERIOR, INTERFACE, INTERIOR};
        let mut series = Series::new(dir);
        for (step, time) in [(0, 0.0), (12, 0.125)] {
            let folder = dir.join(vtu::step_folder(step));
            let piece = |worker: usize| folder.join(vtu::piece_name(worker));
            let exterior = |worker: usize| folder.join(vtu::exterior_name(worker));
            write_strip(&piece(0), time, 0, &[INTERIOR, INTERFACE], 0..2)?;
            write_strip(&piece(1), time, 1, &[INTERFACE, INTERIOR, INTERIOR], 2..5)?;
            write_strip(&piece(2), time, 2, &[], 0..0)?;
            write_strip(&exterior(0), time, 0, &[EXTERIOR], 2..3)?;
            write_strip(&exterior(1), time, 1, &[EXTERIOR], 1..2)?;
            write_strip(&exterior(2), time, 2, &[], 0..0)?;
            series.add(step, time, 3)?;
        }
        Ok(())
    }

    #[test]
    fn the_series_names_every_step_and_piece() {
        let dir = tempfile::tempdir().unwrap();
        write_series(dir.path()).unwrap();
        let read = |name: &str| fs::read_to_string(dir.path().join(name)).unwrap();
        for (collection, file) in [("fields.pvd", "fields.pvtu"), ("exterior.pvd", "exterior.pvtu")]
        {
            let text = read(collection);
            assert!(
                text.contains(&format!(
                    r#"timestep="0" group="" part="0" file="step_000000/{file}""#
                )),
                "{text}"
            );
            assert!(
                text.contains(&format!(
                    r#"timestep="0.125" group="" part="0" file="step_000012/{file}""#
                )),
                "{text}"
            );
        }
        let step = read("step_000012/fields.pvtu");
        for worker in 0..3 {
            assert!(step.contains(&format!(r#"<Piece Source="piece_00{worker}.vtu"/>"#)), "{step}");
        }
        assert!(step.contains(r#"type="Float32" Name="stress" NumberOfComponents="6""#), "{step}");
        assert!(
            read("step_000000/exterior.pvtu").contains(r#"<Piece Source="exterior_002.vtu"/>"#)
        );
    }

    #[test]
    fn a_step_written_again_stands_once_and_one_worker_has_no_exterior() {
        let dir = tempfile::tempdir().unwrap();
        let mut series = Series::new(dir.path());
        series.add(0, 0.0, 1).unwrap();
        series.add(7, 1.0, 1).unwrap();
        series.add(7, 1.5, 1).unwrap();
        let text = fs::read_to_string(series.dir().join(COLLECTION)).unwrap();
        assert_eq!(text.matches("<DataSet").count(), 2);
        assert!(text.contains(r#"timestep="1.5""#));
        assert!(!dir.path().join(EXTERIOR_COLLECTION).exists());
    }

    /// VTK itself reads the series. `deploy/test.sh` names a Python that has VTK.
    #[test]
    fn vtk_reads_the_series() {
        let Some(python) = std::env::var_os("CRUMPLE_PYTHON") else {
            eprintln!("skipped: CRUMPLE_PYTHON does not name a Python with pyvista");
            return;
        };
        let dir = tempfile::tempdir().unwrap();
        write_series(dir.path()).unwrap();
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../deploy/read_fields.py");
        let read = || Command::new(&python).arg(script).arg(dir.path()).output().unwrap();
        let report = read();
        let said = String::from_utf8_lossy(&report.stdout);
        assert!(report.status.success(), "{said}\n{}", String::from_utf8_lossy(&report.stderr));
        assert!(said.contains("0.125: 5 cells, 14 points"), "{said}");

        // An element in two pieces must be detected.
        let twice = dir.path().join(vtu::step_folder(12)).join(vtu::piece_name(2));
        write_strip(&twice, 0.125, 2, &[vtu::INTERIOR], 4..5).unwrap();
        let report = read();
        assert!(!report.status.success());
        let said = String::from_utf8_lossy(&report.stderr);
        assert!(said.contains("element 104 is there 2 times"), "{said}");
    }
}
