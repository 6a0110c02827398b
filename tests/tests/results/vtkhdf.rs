//! The VTKHDF file of a run, read back by VTK and compared bit for bit with the field files:
//! deploy/read_vtkhdf.py. A binary built without VTKHDF refuses the request and names a remedy.

use crumple_tests::program::{Ended, crumple_with, root, run, vtkhdf_or_skip};
use crumple_tests::tools;
use std::process::Command;

/// Runs a job that requests the file. Returns `None` for a binary without VTKHDF, after a check
/// that it refuses the request.
fn with_file(job: &str, more: &[&str]) -> Option<Ended> {
    let asked = ["run", job, "--quiet", "--set", "output.vtkhdf=true"];
    let ended = run(crumple_with(&[&asked[..], more].concat()));
    if ended.code == Some(0) {
        return Some(ended);
    }
    let said = ended.said();
    assert!(
        said.contains("this crumple was built without VTKHDF")
            && said.contains("--features vtkhdf"),
        "{said}"
    );
    assert_eq!(ended.code, Some(2), "bad input");
    let export = run(crumple_with(&["export-vtkhdf", "."])).with_code(2).said();
    assert!(export.contains("this crumple was built without VTKHDF"), "{export}");
    assert_eq!(vtkhdf_or_skip(), None);
    None
}

fn read_back(ended: &Ended) -> Option<String> {
    let mut reader = Command::new(tools::python("pyvista")?);
    reader.arg(root().join("deploy/read_vtkhdf.py")).arg(ended.out());
    Some(run(reader).with_code(0).said())
}

/// Pieces of several workers that change from step to step.
#[test]
fn shells_of_several_workers_read_back() {
    let sets = ["--set", "output.field_interval=0.25", "--set", "parallel.force_every=50"];
    let args = ["--workers", "3", "--end-time", "1.0"];
    let Some(ended) = with_file("cases/tumble", &[&args[..], &sets].concat()) else { return };
    let Some(said) = read_back(&ended) else { return };
    assert!(said.contains("5 steps, 1200 cells at first, 1200 at last: all agrees"), "{said}");
}

/// Solids, shells and springs, and cells whose number decreases (32 of 36 remain).
#[test]
fn other_shapes_and_failing_elements_read_back() {
    for (job, more, wanted) in [
        (
            "tests/decks/scenes/transducers.k",
            &["--workers", "2"][..],
            "91 cells at first, 91 at last",
        ),
        (
            "tests/decks/scenes/sled.k",
            &["--workers", "2", "--set", "material.mat-1.failure_strain=0.001"],
            "36 cells at first, ",
        ),
    ] {
        let Some(ended) = with_file(job, more) else { return };
        let Some(said) = read_back(&ended) else { return };
        assert!(said.contains(wanted), "{job}: {said}");
        assert!(
            job.ends_with("transducers.k") || !said.contains("36 at last"),
            "{job}: some elements fail: {said}"
        );
    }
}
