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
