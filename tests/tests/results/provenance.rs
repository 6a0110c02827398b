//! Results that can be traced: `provenance.json`, `crumple reproduce`, `crumple diff`, and folders
//! with results.

use crumple_tests::program::{Ended, crumple_with, root, run};
use crumple_tests::restart::copy_folder;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A deck with an included file and a job that adds keys to it.
const DECK: &str = "cases/pipe-whip/job.toml";

/// Returns a folder with a copy of the bars, and its job file.
fn bars() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let job = folder.path().join("job.toml");
    fs::copy(root().join("cases/bars/job.toml"), &job).unwrap();
    (folder, job)
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Runs the job for some cycles, with checkpoints and fields.
fn run_into(job: &Path, out: &Path, more: &[&str]) -> Ended {
    let words = ["run", text(job), "--no-report", "--out", text(out), "--set=time.max_cycles=60"];
    run(crumple_with(&[&words[..], more].concat()))
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

fn reproduce(out: &Path, more: &[&str]) -> Ended {
    run(crumple_with(&[&["reproduce", text(out)], more].concat()))
}

#[test]
fn a_folder_names_program_machine_command_and_all_files() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let more = ["--workers=2", "--set=time.safety=0.8"];
    run_into(&root().join(DECK), &out, &more).with_code(0);
    let known = json(&out.join("provenance.json"));
    let start = &known["starts"][0];
    assert_eq!(start["version"], env!("CARGO_PKG_VERSION"));
    assert!(!start["host"].as_str().unwrap().is_empty(), "{start}");
    assert_eq!(start["workers"], 2);
    assert_eq!(start["set"].to_string(), r#"["time.max_cycles=60","time.safety=0.8"]"#);
    assert!(start["command"].to_string().contains("--set=time.safety=0.8"), "{start}");
    assert_eq!(known["job"]["time"]["safety"], 0.8);
    let files: Vec<&str> =
        start["files"].as_array().unwrap().iter().map(|f| f["path"].as_str().unwrap()).collect();
    let names = |end: &str| files.iter().any(|path| path.ends_with(end));
    assert!(names("pipe-whip/job.toml") && names("pipe-whip/pipe.k"), "{files:?}");
    assert!(start["files"][0]["sha256"].as_str().unwrap().len() == 64);
}

#[test]
fn a_run_is_reproduced_to_the_bit_on_other_workers() {
    let (folder, job) = bars();
    let out = folder.path().join("out");
    run_into(&job, &out, &["--workers=2", "--set=time.safety=0.85"]).with_code(0);
    let said = reproduce(&out, &["--workers=1"]).with_code(0).said();
    assert!(said.contains("PASS") && said.contains("after 60 cycles"), "{said}");
    let again = folder.path().join("out-reproduced");
    assert_eq!(json(&again.join("summary.json"))["workers"], 1);
    let refused = reproduce(&out, &["--workers=1"]).with_code(2).said();
    assert!(refused.contains("has the results of a run"), "{refused}");
    let equal = run(crumple_with(&["diff", text(&out), text(&again)])).with_code(0).said();
    assert!(equal.contains("the final states are equal"), "{equal}");
    assert!(equal.contains("workers: 2 / 1"), "{equal}");
    // Another final state.
    let summary = fs::read_to_string(out.join("summary.json")).unwrap();
    let known = json(&out.join("summary.json"));
    let digest = known["state_digest"].as_str().unwrap();
    fs::write(out.join("summary.json"), summary.replace(digest, &"0".repeat(64))).unwrap();
    let failed = reproduce(&out, &["--overwrite", "--quiet"]).with_code(1).said();
    assert!(failed.contains("FAIL") && failed.contains(digest), "{failed}");
}

#[test]
fn a_run_whose_files_were_changed_is_refused() {
    let (folder, job) = bars();
    let out = folder.path().join("out");
    run_into(&job, &out, &["--workers=1"]).with_code(0);
    let before = fs::read_to_string(&job).unwrap();
    fs::write(&job, format!("{before}# a comment\n")).unwrap();
    let refused = reproduce(&out, &[]).with_code(2).said();
    assert!(refused.contains(&format!("{}: its SHA-256", text(&job))), "{refused}");
    assert!(refused.contains("--allow-changed"), "{refused}");
    assert!(!folder.path().join("out-reproduced").exists());
    reproduce(&out, &["--allow-changed"]).with_code(0);
    fs::remove_file(&job).unwrap();
    let missing = reproduce(&out, &[]).with_code(2).said();
    assert!(missing.contains(text(&job)), "{missing}");
}

/// A job of two files is reproduced; a change of the included one is noticed. The state is that of
/// the job in one file.
#[test]
fn a_job_that_includes_another_is_reproduced() {
    let (folder, job) = bars();
    let out = folder.path().join("out");
    run_into(&job, &out, &["--workers=1"]).with_code(0);
    let whole = json(&out.join("summary.json"))["state_digest"].clone();
    let text_of_job = fs::read_to_string(&job).unwrap();
    let (head, parts) = text_of_job.split_at(text_of_job.find("[[material]]").unwrap());
    fs::create_dir(folder.path().join("model")).unwrap();
    let included = folder.path().join("model/parts.toml");
    fs::write(&included, parts).unwrap();
    fs::write(&job, format!("include = [\"model/parts.toml\"]\n{head}")).unwrap();
    run_into(&job, &out, &["--workers=1", "--overwrite"]).with_code(0);
    assert_eq!(json(&out.join("summary.json"))["state_digest"], whole);
    let files = json(&out.join("provenance.json"))["starts"][0]["files"].to_string();
    assert!(files.contains("model/parts.toml"), "{files}");
    reproduce(&out, &[]).with_code(0);
    fs::write(&included, format!("{parts}# a comment\n")).unwrap();
    let refused = reproduce(&out, &[]).with_code(2).said();
    assert!(refused.contains("model/parts.toml: its SHA-256"), "{refused}");
}

/// A run that continues without a change is reproduced by one run; one with a change is not.
#[test]
fn a_run_that_continued_is_reproduced_if_nothing_was_changed() {
    let (folder, job) = bars();
    let out = folder.path().join("out");
    run_into(&job, &out, &["--workers=1", "--set=checkpoint.at=[0.001]"]).with_code(0);
    let copy = folder.path().join("copy");
    copy_folder(&out, &copy);
    run(crumple_with(&["run", "--resume", text(&out), "--no-report"])).with_code(0);
    let known = json(&out.join("provenance.json"));
    assert_eq!(known["starts"].as_array().unwrap().len(), 2);
    assert!(known["starts"][1]["from_cycle"].as_u64().unwrap() > 0, "{known}");
    reproduce(&out, &[]).with_code(0);
    let more = ["--set=time.damping=2.0", "--no-report"];
    run(crumple_with(&[&["run", "--resume", text(&copy)], &more[..]].concat())).with_code(0);
    let refused = reproduce(&copy, &[]).with_code(2).said();
    assert!(refused.contains("with the change time.damping"), "{refused}");
}

/// With the default interval of rows, a part of the end time, runs with other ends have
/// penetrations of other intervals.
#[test]
fn runs_that_differ_only_in_their_end_are_equal_until_then() {
    let (folder, job) = bars();
    // Powers of two, so that both runs have the same steps to the last bit.
    let step = 2.0_f64.powi(-12);
    let [a, b] = [("a", 32.0), ("b", 56.0)].map(|(name, steps)| {
        let out = folder.path().join(name);
        let sets = [
            format!("--set=end_time={}", steps * step),
            format!("--set=time.dt_max={step}"),
            format!("--set=output.history_interval={}", steps / 8.0 * step),
        ];
        let sets = sets.each_ref().map(String::as_str);
        let more = ["--workers=1", "--set=contact.law=penalty"];
        run_into(&job, &out, &[&sets[..], &more].concat()).with_code(0);
        out
    });
    let said = run(crumple_with(&["diff", text(&a), text(&b)])).with_code(1).said();
    assert!(said.contains("histories: equal at 2 moments"), "{said}");
    assert!(said.contains("no difference before the end of the shorter run"), "{said}");
    let left_out = "because they cover the interval between rows: history.csv: penetration";
    assert!(said.contains(left_out), "{said}");
}

#[test]
fn the_first_difference_of_two_runs_is_found_in_all_kinds_of_files() {
    let (folder, job) = bars();
    let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
    let end = "--set=end_time=0.02";
    let often = ["--set=output.history_interval=0.0005", "--set=output.field_interval=0.005"];
    let often = [&often[..], &["--set=checkpoint.at=[0.01]", "--workers=1", end]].concat();
    run_into(&job, &a, &often).with_code(0);
    let slower = [&often[..], &["--set=initial_velocity.0.velocity=[0.9,0,0]"]].concat();
    run_into(&job, &b, &slower).with_code(0);
    let said = run(crumple_with(&["diff", text(&a), text(&b)])).with_code(1).said();
    for found in [
        "the final states differ",
        "initial_velocity.0.velocity=[0.9,0,0]",
        "histories: first difference by cycle 0, time 0",
        "checkpoints: first difference by cycle",
        "fields: first difference by time 0",
        "history.csv: kinetic",
        "velocity x",
        "node ",
        "element ",
    ] {
        assert!(said.contains(found), "no `{found}` in {said}");
    }
    let none = run(crumple_with(&["diff", text(&a), text(folder.path())])).with_code(2).said();
    assert!(none.contains("no results of the same moments"), "{none}");
}

/// The jobs differ by a force on the second bar. It is zero in the step that begins at 20 steps,
/// and acts in the next one, of cycle 22. Rows are 8 cycles apart.
#[test]
fn runs_that_are_repeated_part_in_the_cycle_in_which_a_force_begins() {
    let (folder, job) = bars();
    let step = 2.0_f64.powi(-12); // a power of two, so that times are exact
    let with_force = folder.path().join("with-force.toml");
    let force = format!(
        "\n[[curve]]\nname = \"later\"\npoints = [[0.0, 0.0], [{}, 0.0], [{}, 1.0], [1.0, 1.0]]\n\
         [[load]]\nnodes = \"two\"\nforce = [0.0, 0.1, 0.0]\ncurve = \"later\"\n",
        20.0 * step,
        20.5 * step
    );
    fs::write(&with_force, fs::read_to_string(&job).unwrap() + &force).unwrap();
    let sets = [
        format!("--set=end_time={}", 56.0 * step),
        format!("--set=time.dt_max={step}"),
        format!("--set=output.history_interval={}", 8.0 * step),
    ];
    let sets = [&sets.each_ref().map(String::as_str)[..], &["--set=contact.law=penalty"]].concat();
    let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
    run_into(&job, &a, &[&sets[..], &["--workers=1"]].concat()).with_code(0);
    run_into(&with_force, &b, &[&sets[..], &["--workers=2"]].concat()).with_code(0);
    let count = || fs::read_dir(folder.path()).unwrap().count();
    let before = count();
    let rerun = |a: &Path, b: &Path| run(crumple_with(&["diff", text(a), text(b), "--rerun"]));
    let said = rerun(&a, &b).with_code(1).said();
    assert!(said.contains("histories: first difference by cycle 24"), "{said}");
    let nodes = "nodes: first differ after cycle 22 (equal after 21)";
    assert!(said.contains(nodes) && said.contains(": velocity y "), "{said}");
    let elements = "elements: first differ after cycle 23 (equal after 22)";
    assert!(said.contains(elements) && said.contains("\n  element "), "{said}");
    assert_eq!(count(), before, "no files are written");

    let same = rerun(&a, &a).with_code(0).said();
    assert!(same.contains("the results are equal: nothing is run again"), "{same}");
    // A final state that no run has, as from another program.
    let other = folder.path().join("other");
    copy_folder(&a, &other);
    let digest = json(&a.join("summary.json"))["state_digest"].as_str().unwrap().to_string();
    let summary = fs::read_to_string(other.join("summary.json")).unwrap();
    fs::write(other.join("summary.json"), summary.replace(&digest, &"0".repeat(64))).unwrap();
    let refused = rerun(&a, &other).with_code(2).said();
    assert!(refused.contains("the runs do not part when they are run again"), "{refused}");
    // Another file than the run has read.
    fs::write(&with_force, fs::read_to_string(&job).unwrap()).unwrap();
    let refused = rerun(&a, &b).with_code(2).said();
    assert!(refused.contains("with-force.toml: its SHA-256"), "{refused}");
    assert!(refused.contains("restore these files"), "{refused}");
}

#[test]
fn a_folder_with_results_is_not_overwritten() {
    let (folder, job) = bars();
    let out = folder.path().join("out");
    run_into(&job, &out, &["--workers=1"]).with_code(0);
    let before = fs::read(out.join("summary.json")).unwrap();
    let refused = run_into(&job, &out, &["--workers=1"]).with_code(2).said();
    assert!(refused.contains("has the results of a run") && refused.contains("--overwrite"));
    assert_eq!(fs::read(out.join("summary.json")).unwrap(), before);
    fs::remove_file(out.join("summary.json")).unwrap(); // as after a loss
    run_into(&job, &out, &["--workers=1"]).with_code(2);
    run_into(&job, &out, &["--workers=1", "--overwrite"]).with_code(0);
}
