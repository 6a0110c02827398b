//! The field files of a real run, read back with VTK: every element once, shared nodes equal to the last bit,
//! times in order, all values finite. What is looked at is listed in deploy/read_fields.py.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The binary to test: `CRUMPLE_BIN`, or the one that cargo built beside this test.
fn crumple() -> PathBuf {
    if let Some(path) = env::var_os("CRUMPLE_BIN") {
        return path.into();
    }
    let beside = env::current_exe().unwrap().ancestors().nth(2).unwrap().join("crumple");
    assert!(beside.exists(), "no {}: run `cargo build` first, or name the binary in CRUMPLE_BIN", beside.display());
    beside
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Boxes are renewed every 20 cycles, so that the pieces differ from step to step.
#[test]
fn vtk_reads_the_fields_of_a_run() {
    let Some(python) = env::var_os("CRUMPLE_PYTHON") else {
        eprintln!("skipped: CRUMPLE_PYTHON does not name a Python with pyvista");
        return;
    };
    for workers in ["1", "3"] {
        let out = tempfile::tempdir().unwrap();
        let run = Command::new(crumple())
            .current_dir(root())
            .args(["run", "cases/jeep-frame", "--workers", workers, "--end-time", "0.2"])
            .args(["--set", "output.field_interval=0.05", "--set", "parallel.force_every=20"])
            .arg("--out")
            .arg(out.path())
            .output()
            .unwrap();
        assert!(run.status.success(), "{}", said(&run));

        let read =
            Command::new(&python).current_dir(root()).arg("deploy/read_fields.py").arg(out.path()).output().unwrap();
        assert!(read.status.success(), "with {workers} workers: {}", said(&read));
        let steps = said(&read).lines().filter(|line| line.contains(": 7208 cells")).count();
        assert!(steps >= 5, "t = 0 and every 0.05 ms, but only {steps} steps: {}", said(&read));
        assert_eq!(out.path().join("fields/exterior.pvd").exists(), workers != "1");
    }
}
