//! The commands that ask a service, with the exit codes of a run.

use crumple_tests::program::root;
use crumple_tests::service::{Service, endless};
use std::fs;

#[test]
fn the_commands_submit_watch_list_stop_resume_and_fetch() {
    let service = Service::start(&[]);
    let said = |output: &std::process::Output| {
        String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned()
    };
    let job = root().join("cases/bars/job.toml");
    let job = job.to_str().unwrap();
    let done = service.command(&["submit", job, "--watch", "--name", "two bars"]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    assert!(said(&done).contains("job 1: completed"), "{}", said(&done));
    let bad = service.command(&["submit", job, "--watch", "--set", "end_time=-1"]);
    assert_eq!(bad.status.code(), Some(2), "{}", said(&bad));
    let listed = service.command(&["jobs"]);
    assert!(
        said(&listed).contains("two bars") && said(&listed).contains("refused"),
        "{}",
        said(&listed)
    );
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let fetched = service.command(&["fetch", "1", "results/", "--out", out]);
    assert_eq!(fetched.status.code(), Some(0), "{}", said(&fetched));
    let own = fs::read(service.folder(1).join("results/history.csv")).unwrap();
    assert_eq!(fs::read(folder.path().join("results/history.csv")).unwrap(), own);
    assert!(folder.path().join("results/fields/fields.pvd").exists());
    let id = service.submit(&endless()).to_string();
    service.wait_for(id.parse().unwrap(), "running");
    assert_eq!(service.command(&["stop", &id]).status.code(), Some(0));
    assert_eq!(service.command(&["watch", &id]).status.code(), Some(130));
    let again = service.command(&["stop", &id]);
    assert_eq!(again.status.code(), Some(2), "{}", said(&again));
    assert!(said(&again).contains("stopped already"), "{}", said(&again));
    assert_eq!(service.command(&["resume", &id]).status.code(), Some(0));
    service.wait_for(id.parse().unwrap(), "running");
    assert_eq!(service.command(&["watch", "99"]).status.code(), Some(2));
}

/// A run that does not meet a requirement is completed, and its exit code 1 is that of the job and
/// of `crumple watch`; one that meets it has 0.
#[test]
fn a_requirement_that_is_not_met_is_exit_code_1_of_the_service() {
    let service = Service::start(&[]);
    let folder = tempfile::tempdir().unwrap();
    let bars = fs::read_to_string(root().join("cases/bars/job.toml")).unwrap();
    let with = |limit: &str| {
        format!(
            "{bars}\n[[require]]\nname = \"elements\"\nquantity = {{ summary = \
             \"elements.quad4\" }}\nbelow = {limit}\n"
        )
    };
    for (limit, code) in [("79.5", 1), ("80.5", 0)] {
        let job = folder.path().join("job.toml");
        fs::write(&job, with(limit)).unwrap();
        let sent = service.command(&["submit", job.to_str().unwrap(), "--watch"]);
        let said = String::from_utf8_lossy(&sent.stdout).into_owned();
        assert_eq!(sent.status.code(), Some(code), "{said}");
        let id = if code == 1 { 1 } else { 2 };
        let job = service.get(&format!("/api/jobs/{id}")).json();
        assert_eq!(
            (job["state"].as_str(), job["code"].as_i64()),
            (Some("completed"), Some(code.into()))
        );
        let watched = service.command(&["watch", &id.to_string()]);
        assert_eq!(watched.status.code(), Some(code), "watch of a job that has ended");
    }
}

#[test]
fn a_folder_with_includes_is_sent_as_it_is() {
    let service = Service::start(&[]);
    let folder = tempfile::tempdir().unwrap();
    let bars = fs::read_to_string(root().join("cases/bars/job.toml")).unwrap();
    fs::create_dir(folder.path().join("parts")).unwrap();
    // An absent include shows that names are relative to the folder of the job.
    fs::write(folder.path().join("job.toml"), bars).unwrap();
    fs::write(folder.path().join("parts/more.k"), "*KEYWORD\n*END\n").unwrap();
    let sent = service.command(&["submit", folder.path().to_str().unwrap(), "--check"]);
    assert_eq!(sent.status.code(), Some(0), "{sent:?}");
    service.wait_for(1, "checked");
    assert!(service.folder(1).join("input/parts/more.k").exists());
    assert!(!service.folder(1).join("results").exists());
}
