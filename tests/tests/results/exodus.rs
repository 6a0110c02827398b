//! EXODUS II: files of runs are read back by VTK and compared with the field files
//! (deploy/read_exodus.py), and are meshes of jobs.

use crumple_tests::program::{Ended, crumple_with, root, run};
use crumple_tests::tools;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Runs a job that requests the file.
fn with_file(job: &str, more: &[&str]) -> Ended {
    let asked = ["run", job, "--quiet", "--no-report", "--set", "output.exodus=true"];
    run(crumple_with(&[&asked[..], more].concat())).with_code(0)
}

fn read_back(ended: &Ended) -> Option<String> {
    let mut reader = Command::new(tools::python("pyvista")?);
    reader.arg(root().join("deploy/read_exodus.py")).arg(ended.out());
    Some(run(reader).with_code(0).said())
}

/// Pieces of several workers that change from step to step.
#[test]
fn shells_of_several_workers_read_back() {
    let sets = ["--set", "output.field_interval=0.25", "--set", "parallel.force_every=50"];
    let args = ["--workers", "3", "--end-time", "1.0"];
    let ended = with_file("cases/tumble", &[&args[..], &sets].concat());
    let Some(said) = read_back(&ended) else { return };
    assert!(said.contains("5 steps as in the fields; the last has 1200 elements"), "{said}");
}

/// Solids, shells and springs, and elements that fail.
#[test]
fn other_shapes_and_failing_elements_read_back() {
    let fails = ["--workers", "2", "--set", "material.mat-1.failure_strain=0.001"];
    for (job, more) in [
        ("tests/decks/scenes/transducers.k", &["--workers", "2"][..]),
        ("tests/decks/scenes/sled.k", &fails),
    ] {
        let ended = with_file(job, more);
        let Some(said) = read_back(&ended) else { return };
        let whole = said.contains("has 91 elements") || said.contains("has 36 elements");
        assert_eq!(whole, job.ends_with("transducers.k"), "{job}: {said}");
    }
}

/// A job on the file of a run has the mesh of the run: its ids, parts and corners, and its
/// coordinates to 32 bits.
#[test]
fn the_file_of_a_run_is_a_mesh() {
    let ended = with_file("cases/tumble", &["--workers", "2", "--set", "time.max_cycles=10"]);
    let original = crumple::input::job::read(&root().join("cases/tumble"), &[]).unwrap();
    let mesh = crumple::input::exodus::read(&ended.out().join("fields.exo")).unwrap();
    assert_eq!(mesh.elements.len(), original.mesh.elements.len());
    let ours: std::collections::BTreeMap<_, _> =
        mesh.elements.iter().map(|e| (e.id, (e.part, e.nodes))).collect();
    assert!(original.mesh.elements.iter().all(|e| ours[&e.id] == (e.part, e.nodes)));
    let at: std::collections::BTreeMap<_, _> = mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
    for node in &original.mesh.nodes {
        let x = at[&node.id];
        assert!((0..3).all(|c| (x[c] - node.x[c]).abs() < 1e-5), "{node:?} {x:?}");
    }
}

/// A part without a name, and one whose name looks like what stands for it: both keep their ids.
#[test]
fn names_of_parts_do_not_change_their_ids() {
    let sets = ["--set", "part.2.name=part_1", "--set", "part.1.name="];
    let ended = with_file("cases/bars", &[&["--set", "time.max_cycles=2"], &sets[..]].concat());
    let mesh = crumple::input::exodus::read(&ended.out().join("fields.exo")).unwrap();
    let parts: std::collections::BTreeSet<u32> = mesh.elements.iter().map(|e| e.part).collect();
    assert_eq!(parts, [1, 2].into());
}

const JOB: &str = r#"
title = "a block"
units = "mm, ms, kg"
end_time = 0.001
[mesh]
exodus = "model.g"
[[part]]
id = 1
material = "steel"
[[material]]
name = "steel"
law = "elastic"
density = 7.85e-6
youngs_modulus = 210.0
poisson = 0.3
"#;

/// A block of solids, from the file of a run.
#[test]
fn a_job_on_the_file_of_a_run_runs() {
    let first = with_file("cases/block", &["--set", "time.max_cycles=2"]);
    let folder = tempfile::tempdir().unwrap();
    fs::copy(first.out().join("fields.exo"), folder.path().join("model.g")).unwrap();
    let job = folder.path().join("job.toml");
    fs::write(&job, JOB).unwrap();
    let ended = run(crumple_with(&["run", job.to_str().unwrap(), "--no-report"])).with_code(0);
    // Names of parts come back.
    let imported = folder.path().join("imported");
    let model = folder.path().join("model.g").display().to_string();
    run(crumple_with(&["import", &model, "--out", imported.to_str().unwrap()])).with_code(0);
    let text = fs::read_to_string(imported.join("job.toml")).unwrap();
    let name = first.summary()["parts"][0]["name"].as_str().expect("a name").to_string();
    assert!(!name.is_empty() && text.contains(&format!("name = \"{name}\"")), "{text}");
    assert_eq!(ended.summary()["nodes"], first.summary()["nodes"]);
    assert_eq!(ended.summary()["elements"], first.summary()["elements"]);
}

/// Misuse: the file is missing, or has another format, or is given with a generator.
#[test]
fn jobs_with_wrong_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let check = |text: &str| {
        let job = folder.path().join("job.toml");
        fs::write(&job, text).unwrap();
        run(crumple_with(&["check", job.to_str().unwrap()])).with_code(2).said()
    };
    let said = check(JOB);
    assert!(said.contains("there is no file") && said.contains("job.toml:6"), "{said}");
    fs::write(folder.path().join("model.g"), "solid").unwrap();
    let said = check(JOB);
    assert!(said.contains("cannot be read as netCDF"), "{said}");
    let said = check(&JOB.replace("[mesh]", "[mesh]\ngenerator = \"bars\""));
    assert!(said.contains("more than one mesh"), "{said}");
    let said = run(crumple_with(&["export-exodus", &folder.path().to_string_lossy()]));
    assert!(said.with_code(2).said().contains("fields.pvd"));
    assert!(!Path::new(&folder.path().join("fields.exo")).exists());
}
