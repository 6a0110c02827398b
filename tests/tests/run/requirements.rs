//! Requirements of a job: verdicts, the exit code, and names that no run has.

use crumple_tests::program::{Ended, crumple_with, run};
use serde_json::Value;

/// Runs a few cycles of the flying shells with requirements given as the list of `--set require`.
fn run_with(requirements: &str) -> Ended {
    let set = format!("require=[{requirements}]");
    let job = ["run", "cases/flight", "--workers", "2", "--set", "time.max_cycles=20"];
    run(crumple_with(&[&job[..], &["--set", &set]].concat()))
}

/// Returns name, verdict and value of each requirement in the summary.
fn verdicts(ended: &Ended) -> Vec<(String, bool, Option<f64>)> {
    let summary = ended.summary();
    let one = |r: &Value| {
        let name = r["name"].as_str().unwrap().to_owned();
        (name, r["is_met"].as_bool().unwrap(), r["value"].as_f64())
    };
    summary["requirements"].as_array().unwrap().iter().map(one).collect()
}

#[test]
fn a_run_that_meets_its_requirements_is_complete() {
    let ended = run_with(
        "{name=\"cycles\", quantity={summary=\"cycles\"}, above=20, below=20}, \
         {name=\"kept\", quantity={history=\"kinetic\", over={history=\"kinetic\", \
         stat=\"first\"}}, above=0.5}",
    )
    .with_code(0);
    let all = verdicts(&ended);
    assert_eq!(all[0], ("cycles".into(), true, Some(20.0)));
    assert!(all[1].1 && all[1].2.unwrap() > 0.5, "{all:?}");
    assert!(ended.said().contains("PASS  cycles: 2.000000e1 (required: below 20, above 20)"));
}

#[test]
fn a_run_that_misses_a_requirement_has_code_1_and_its_results() {
    let ended = run_with(
        "{name=\"cycles\", quantity={summary=\"cycles\"}, below=19}, \
         {name=\"nodes\", quantity={summary=\"nodes\"}, above=1}, \
         {name=\"never\", quantity={history=\"kinetic\", crossing=-1.0}, above=0}",
    )
    .with_code(1);
    let met: Vec<bool> = verdicts(&ended).into_iter().map(|v| v.1).collect();
    assert_eq!(met, [false, true, false]);
    assert_eq!(ended.summary()["status"], "completed");
    let said = ended.said();
    assert!(said.contains("FAIL  cycles: 2.000000e1 (required: below 19)"), "{said}");
    assert!(said.contains("FAIL  never: the results do not have the value"), "{said}");
    let page = std::fs::read_to_string(ended.out().join("report.html")).unwrap();
    assert!(page.contains("requirements") && page.contains("never"), "the report has the table");
}

/// Runs half a millisecond of the tube with a node at either end, a section and a wall. The head
/// moves by 7.5 mm, and the limits of the distance and of the wall are given.
fn crushed(least_change: f64, least_force: f64) -> Ended {
    let nodes = "output.node=[{name=\"foot\", ids=[1]}, {name=\"head\", ids=[289]}]";
    let section = "output.section=[{name=\"cut\", nodes=\"head\", side=[0.0, 0.0, -1.0]}]";
    let foot = "table=\"nodes\", of=\"foot\", history=\"acceleration\", stat=\"peak\", from=0.05";
    let apart = "table=\"nodes\", of=\"head\", relative_to=\"foot\", history=\"distance change\"";
    let requirements = format!(
        "require=[{{name=\"raw\", quantity={{{foot}}}, above=0}}, \
         {{name=\"filtered\", quantity={{{foot}, filter=\"CFC 1000\"}}, above=0}}, \
         {{name=\"intrusion\", quantity={{{apart}, stat=\"min\"}}, above={least_change}}}, \
         {{name=\"section\", quantity={{table=\"sections\", of=\"cut\", history=\"force\", \
         stat=\"max\"}}, above=0.1}}, \
         {{name=\"wall\", quantity={{table=\"walls\", of=\"floor\", history=\"mean force z\", \
         filter=\"CFC 600\", stat=\"mean\"}}, above={least_force}}}]"
    );
    let size = ["scene.elements=6", "end_time=0.5", "output.history_interval=0.01"];
    let sets = size.into_iter().chain([nodes, section, requirements.as_str()]);
    let sets = sets.flat_map(|set| ["--set", set]);
    let args = ["run", "cases/tube", "--workers", "2"];
    run(crumple_with(&args.into_iter().chain(sets).collect::<Vec<_>>()))
}

/// Returns time and `columns` of each row of a node, from `nodes.csv`.
fn rows(ended: &Ended, node: &str, columns: [&str; 3]) -> Vec<(f64, [f64; 3])> {
    let text = std::fs::read_to_string(ended.out().join("nodes.csv")).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let place = |name: &str| head.iter().position(|column| column.starts_with(name)).unwrap();
    let places = columns.map(place);
    let number = |field: &str| field.parse::<f64>().unwrap();
    lines
        .filter(|row| row[1] == node)
        .map(|row| (number(row[0]), places.map(|at| number(row[at]))))
        .collect()
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Acceleration of a node with and without a filter, distance of two nodes, force in a section, and
/// mean force of a wall. Values without a filter are those of the files.
#[test]
fn histories_of_objects_are_judged() {
    let ended = crushed(-10.0, 0.1).with_code(0);
    let said = ended.said();
    let summary = ended.summary();
    let found = |name: &str| {
        let mut all = summary["requirements"].as_array().unwrap().iter();
        all.find(|one| one["name"] == name).unwrap_or_else(|| panic!("no {name}: {said}"))
    };
    let value = |name: &str| found(name)["value"].as_f64().unwrap();
    assert!(verdicts(&ended).iter().all(|one| one.1), "{said}");

    let axes = ["acceleration x", "acceleration y", "acceleration z"];
    let peak = rows(&ended, "foot", axes)
        .into_iter()
        .filter(|row| row.0 >= 0.05 * (1.0 - 1e-8))
        .map(|(_, a)| length(a))
        .fold(0.0, f64::max);
    assert!((value("raw") / peak - 1.0).abs() < 1e-12, "round-off of a magnitude");
    assert!((value("filtered") / peak - 1.0).abs() > 1e-3, "the filter changes nothing");
    assert_eq!(found("raw")["unit"], "mm/ms^2");

    let places = ["x [", "y [", "z ["];
    let (head, foot) = (rows(&ended, "head", places), rows(&ended, "foot", places));
    let apart = |k: usize| length(std::array::from_fn(|c| head[k].1[c] - foot[k].1[c]));
    let change = |k: usize| apart(k) - apart(0);
    let least = (0..head.len()).min_by(|&a, &b| change(a).total_cmp(&change(b))).unwrap();
    assert!((value("intrusion") - change(least)).abs() < 1e-9, "round-off of 60 mm");
    let intrusion = found("intrusion");
    let late = intrusion["time"].as_f64().unwrap() - head[least].0;
    assert!(late.abs() < 1e-12, "rounding of JSON: {late}");
    assert_eq!(intrusion["unit"], "mm");
    assert_eq!(intrusion["unit_of_time"], "ms");
    assert_eq!(found("section")["unit"], "kN");
    assert_eq!(found("wall")["unit"], "kN");
    assert!(found("wall")["time"].is_null(), "a mean has no time");
    let line = format!("PASS  intrusion: {:.6e} mm at time ", value("intrusion"));
    assert!(said.contains(&line), "{line}: {said}");
}

#[test]
fn histories_that_miss_their_limits_are_failures_with_unit_and_time() {
    let ended = crushed(-5.0, 1e6).with_code(1);
    let missed: Vec<String> =
        verdicts(&ended).into_iter().filter(|one| !one.1).map(|one| one.0).collect();
    assert_eq!(missed, ["intrusion", "wall"]);
    let said = ended.said();
    assert!(said.contains(" ms (required: above -5)"), "{said}");
    assert!(said.contains(" kN (required: above 1000000)"), "{said}");
    let page = std::fs::read_to_string(ended.out().join("report.html")).unwrap();
    assert!(page.contains("Requirement `intrusion` is not met: -"), "the warnings begin with it");
}

/// Wrong names of histories are found without a run, each with its line.
#[test]
fn check_names_the_line_of_a_wrong_history() {
    let job = "master/tests/bad/requirement_names.toml";
    let text = std::fs::read_to_string(crumple_tests::program::root().join(job)).unwrap();
    let line = 1 + text.lines().position(|line| line.contains("of = \"haed\"")).unwrap();
    let said = run(crumple_with(&["check", job])).with_code(2).said();
    assert!(said.contains(&format!("requirement_names.toml:{line}:")), "{said}");
    assert!(said.contains("did you mean `head`? known: edge 1, edge 2, edge 3, head"), "{said}");
}

/// A run that cannot be judged must not begin.
#[test]
fn quantities_that_no_run_has_are_errors_of_the_job() {
    let ended = run_with(
        "{name=\"error\", quantity={summary=\"energy.eror_max\"}, below=1}, \
         {name=\"height\", quantity={history=\"kinetik\"}, below=1}",
    )
    .with_code(2);
    let said = ended.said();
    for text in [
        "requirement `error`: no run has this quantity",
        "did you mean `error_max`?",
        "requirement `height`: no run has this quantity",
        "did you mean `kinetic`?",
    ] {
        assert!(said.contains(text), "missing: {text}: {said}");
    }
}
