//! A complete study: points, a failed one among them, charts, and no repeated computation.

use crumple_tests::program::{crumple_with, root, run};

const STUDY: &str = r#"
title = "Bars"
job = "JOB"
[[series]]
name = "lagrange"
grid = { scene.elements = [8, 16], time.safety = [0.9, 3.0] }
[[measure]]
name = "speed"
unit = "mm/ms"
quantity = { field = "velocity", component = "x", part = 2 }
reference = 10.0
[[chart]]
file = "front"
kind = "pareto"
[[chart]]
file = "map"
kind = "map"
measure = "ended"
x = "scene.elements"
y = "time.safety"
"#;

/// Runs a study with the given text and checks the exit code; returns its output.
fn study(folder: &std::path::Path, text: &str, code: i32) -> String {
    let file = folder.join("study.toml");
    let job = root().join("cases/bars/job.toml");
    std::fs::write(&file, text.replace("JOB", &job.display().to_string())).unwrap();
    let out = folder.join("out");
    let arguments = ["study", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    run(crumple_with(&arguments)).with_code(code).said()
}

#[test]
fn a_study_runs_once_and_keeps_failures_as_points() {
    let folder = tempfile::tempdir().unwrap();
    let first = study(folder.path(), STUDY, 0);
    assert!(first.contains("4 points, 4 of them to run"), "{first}");
    let results = std::fs::read_to_string(folder.path().join("out/results.csv")).unwrap();
    let codes: Vec<&str> =
        results.lines().skip(1).map(|line| line.split(',').nth(3).unwrap()).collect();
    // Three times the stable step fails for any mesh.
    assert_eq!(codes, ["0", "3", "0", "3"], "{results}");
    for chart in ["front.svg", "front.png", "map.svg", "map.png"] {
        assert!(folder.path().join("out").join(chart).metadata().unwrap().len() > 1000, "{chart}");
    }
    let second = study(folder.path(), STUDY, 0);
    assert!(second.contains("4 points, 0 of them to run"), "{second}");
}

#[test]
fn mistakes_are_named_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        ("scene.elements", "scene.elemnts", "the same at another point"),
        (
            "field = \"velocity\"",
            "field = \"velocty\"",
            "measure `speed`: there is no field `velocty`",
        ),
        (
            "field = \"velocity\", component = \"x\", part = 2",
            "history = \"kinetik\"",
            "did you mean `kinetic`?",
        ),
        (
            "field = \"velocity\", component = \"x\", part = 2",
            "summary = \"energy.eror\"",
            "did you mean `error`?",
        ),
        (
            "kind = \"pareto\"",
            "kind = \"pareto\"\nmeasure = \"sped\"",
            "there is no measure `sped`; there are: speed",
        ),
        ("part = 2", "prt = 2", "unknown field `prt`"),
        ("x = \"scene.elements\"", "x = \"scene.refine\"", "no series varies `scene.refine`"),
        ("component = \"x\"", "stat = \"max\"", "belong to history"),
    ];
    for (right, wrong, said) in cases {
        let words = study(folder.path(), &STUDY.replace(right, wrong), 2);
        assert!(words.contains(said), "{said}: {words}");
    }
    assert!(!folder.path().join("out/runs").exists());
}
