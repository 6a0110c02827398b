//! The field files of a real run, read back with VTK: every element once, shared nodes equal to
//! the last bit, times in order, all values finite. deploy/read_fields.py lists the checks.

use crumple_tests::program::{crumple_with, root, run};
use std::env;
use std::process::Command;

/// Boxes are renewed every 20 cycles, so that the pieces differ from step to step.
#[test]
fn vtk_reads_the_fields_of_a_run() {
    let Some(python) = env::var_os("CRUMPLE_PYTHON") else {
        eprintln!("skipped: CRUMPLE_PYTHON does not name a Python with pyvista");
        return;
    };
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
