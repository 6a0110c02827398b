//! The collections of field files; the field files of a real run, read back with VTK: every
//! element once, shared nodes equal to the last bit, times in order, all values finite.
//! deploy/read_fields.py lists the checks.

use crumple::results::fields::FieldSeries;
use crumple_proto::mesh::Shape;
use crumple_tests::program::{crumple_with, root, run};
use crumple_tests::tools;
use crumple_worker::vtu::{self, Cells, FieldPiece};
use std::ops::Range;
use std::path::Path;
use std::process::Command;
use std::{fs, io};

/// Boxes are renewed every 20 cycles, so that the pieces differ from step to step.
#[test]
fn vtk_reads_the_fields_of_a_run() {
    let Some(python) = tools::python("pyvista") else { return };
    for workers in ["1", "3"] {
        let args = ["run", "cases/jeep-frame", "--workers", workers, "--end-time", "0.2"];
        let sets = ["--set", "output.field_interval=0.05", "--set", "parallel.force_every=20"];
        let ended = run(crumple_with(&[&args[..], &sets].concat())).with_code(0);

        let mut reader = Command::new(&python);
        reader.arg(root().join("deploy/read_fields.py")).arg(ended.out());
        let said = run(reader).with_code(0).said();
        let steps = said.lines().filter(|line| line.contains(": 7208 cells")).count();
        assert!(
            steps >= 5,
            "t = 0 and every 0.05 ms, but only {steps} steps with {workers} workers: {said}"
        );
        assert_eq!(ended.out().join("fields/exterior.pvd").exists(), workers != "1");
    }
}

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
    FieldPiece {
        time,
        points: &corners.iter().map(|&(i, j)| [i as f32, j as f32, fall]).collect::<Vec<_>>(),
        point_arrays: &[
            vtu::DISPLACEMENT.with(&vec![[0.0, 0.0, fall]; corners.len()]),
            vtu::VELOCITY.with(&vec![[0.0, 0.0, -1.0]; corners.len()]),
            vtu::ROTATIONAL_VELOCITY.with(&vec![[0.0_f32; 3]; corners.len()]),
            vtu::NODE_ID
                .with(&corners.iter().map(|&(i, j)| i64::from(2 * i + j + 1)).collect::<Vec<_>>()),
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
    let mut series = FieldSeries::new(dir, Default::default());
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
    for (collection, file) in [("fields.pvd", "fields.pvtu"), ("exterior.pvd", "exterior.pvtu")] {
        let text = read(collection);
        assert!(
            text.contains(&format!(r#"timestep="0" group="" part="0" file="step_000000/{file}""#)),
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
    assert!(read("step_000000/exterior.pvtu").contains(r#"<Piece Source="exterior_002.vtu"/>"#));
}

/// VTK itself reads the series.
#[test]
fn vtk_reads_the_series() {
    let Some(python) = tools::python("pyvista") else { return };
    let dir = tempfile::tempdir().unwrap();
    write_series(dir.path()).unwrap();
    let script = root().join("deploy/read_fields.py");
    let read = || Command::new(&python).arg(&script).arg(dir.path()).output().unwrap();
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
