//! Slurm by small programs that stand for `sbatch`, `squeue`, `sacct` and `scancel`: what they are
//! asked, and what becomes of their answers. `real_slurm.rs` has a real one.

use crumple_tests::service::{Service, bars, endless};
use serde_json::{Value, json};
use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use tempfile::TempDir;

/// Runs the script in the background and keeps its words. The number of a job is its process.
const SBATCH: &str = r#"#!/bin/sh
printf '%s\n' "$@" > "$SPOOL/words"
while [ $# -gt 0 ]; do
    case $1 in
        --chdir=*) cd "${1#--chdir=}" ;;
        --*) ;;
        *) break ;;
    esac
    shift
done
sh "$@" > /dev/null 2>&1 &
echo $!
"#;
const SQUEUE: &str = r#"#!/bin/sh
for last; do :; done
if [ -f "$SPOOL/pending" ]; then echo PENDING
elif kill -0 "$last" 2> /dev/null; then echo RUNNING
else echo "slurm_load_jobs error: Invalid job id specified" >&2; exit 1
fi
"#;
const SACCT: &str = "#!/bin/sh\necho FAILED\n";
const SCANCEL: &str = r#"#!/bin/sh
printf '%s\n' "$@" > "$SPOOL/cancelled"
for last; do :; done
kill -TERM "$last"
"#;

fn programs() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let all = [("sbatch", SBATCH), ("squeue", SQUEUE), ("sacct", SACCT), ("scancel", SCANCEL)];
    for (name, text) in all {
        let path = folder.path().join(name);
        fs::write(&path, text.replace("$SPOOL", &folder.path().display().to_string())).unwrap();
        fs::set_permissions(path, Permissions::from_mode(0o755)).unwrap();
    }
    folder
}

fn by_slurm(mut job: Value) -> Value {
    job["launcher"] = json!("slurm");
    job
}

fn words(path: &Path) -> Vec<String> {
    fs::read_to_string(path).unwrap_or_default().lines().map(String::from).collect()
}

#[test]
fn a_job_goes_through_slurm_as_a_list_of_words() {
    let programs = programs();
    let options = ["--slurm", "--slurm-option=--partition=crash"];
    let service = Service::start_with_path(&options, Some(programs.path()));
    let mut job = by_slurm(bars(&[]));
    job["name"] = json!("$(touch x); `id` 'quoted' \"twice\"");
    let id = service.submit(&job);
    service.wait_for(id, "completed");
    let asked = words(&programs.path().join("words"));
    for word in
        ["--parsable", "--partition=crash", "--ntasks=1", "--cpus-per-task=1", "input/job.toml"]
    {
        assert!(asked.iter().any(|w| w == word), "{asked:?}");
    }
    assert!(
        !asked.iter().any(|word| word.contains("touch")),
        "names of users stay here: {asked:?}"
    );
}

#[test]
fn a_job_of_slurm_is_found_again_and_stopped_by_a_signal() {
    let programs = programs();
    let mut service = Service::start_with_path(&["--slurm"], Some(programs.path()));
    let id = service.submit(&by_slurm(endless()));
    service.wait_for(id, "running");
    service.kill();
    service.again();
    assert_eq!(service.wait_for(id, "running")["attempt"], 1);
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop"), &json!({})).status, 202);
    service.wait_for(id, "stopped");
    let asked = words(&programs.path().join("cancelled"));
    assert_eq!(asked[..2], ["--batch", "--signal=TERM"], "{asked:?}");
}

/// A job that does not stop at a signal is cancelled as a whole.
#[test]
fn a_job_of_slurm_that_does_not_stop_is_cancelled() {
    let programs = programs();
    let spool = programs.path().display().to_string();
    let deaf = SCANCEL.replace("for last", "[ $# -gt 1 ] && exit\nfor last");
    fs::write(programs.path().join("scancel"), deaf.replace("$SPOOL", &spool)).unwrap();
    let service = Service::start_with_path(&["--slurm"], Some(programs.path()));
    let id = service.submit(&by_slurm(endless()));
    service.wait_for(id, "running");
    let cancelled = || words(&programs.path().join("cancelled"));
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop"), &json!({})).status, 202);
    service.wait("Slurm was asked for a signal", |_| (cancelled().len() == 3).then_some(()));
    assert_eq!(service.job(id)["state"], "running");
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop?force=true"), &json!({})).status, 202);
    service.wait_for(id, "stopped");
    assert_eq!(cancelled().len(), 1, "the number alone: {:?}", cancelled());
}

#[test]
fn a_job_that_waits_at_slurm_is_not_started_again() {
    let programs = programs();
    // `sbatch` keeps the job until it is released.
    let held = SBATCH
        .replace("$SPOOL", &programs.path().display().to_string())
        .replace("sh \"$@\" >", "while [ -f SPOOL/pending ]; do sleep 0.05; done; sh \"$@\" >")
        .replace("SPOOL/pending", &format!("{}/pending", programs.path().display()))
        .replace("while [ -f", "(while [ -f")
        .replace("2>&1 &", "2>&1) > /dev/null 2>&1 &");
    fs::write(programs.path().join("sbatch"), held).unwrap();
    fs::write(programs.path().join("pending"), "").unwrap();
    let mut service = Service::start_with_path(&["--slurm"], Some(programs.path()));
    let id = service.submit(&by_slurm(bars(&[])));
    service.wait("slurm has the job", |_| programs.path().join("words").exists().then_some(()));
    // The loop stores the number of a job before it starts another one.
    let next = service.submit(&bars(&[]));
    service.wait_for(next, "completed");
    assert_eq!(service.job(id)["state"], "starting");
    service.kill();
    service.again();
    assert_eq!(service.job(id)["attempt"], 1);
    fs::remove_file(programs.path().join("pending")).unwrap();
    assert_eq!(service.wait_for(id, "completed")["attempt"], 1);
}

/// A cluster without accounts: only the queue knows that a job was cancelled before it ran.
#[test]
fn a_job_that_is_cancelled_in_the_queue_is_stopped_without_accounts() {
    let programs = programs();
    let spool = programs.path().display().to_string();
    for (name, text) in [
        ("sbatch", "echo 7"),
        ("squeue", "if [ -f $SPOOL/gone ]; then echo CANCELLED; else echo PENDING; fi"),
        ("sacct", "echo 'Slurm accounting storage is disabled' >&2; exit 1"),
        ("scancel", "touch $SPOOL/gone"),
    ] {
        let text = format!("#!/bin/sh\n{}\n", text.replace("$SPOOL", &spool));
        fs::write(programs.path().join(name), text).unwrap();
    }
    let service = Service::start_with_path(&["--slurm"], Some(programs.path()));
    let id = service.submit(&by_slurm(bars(&[])));
    service.wait_for(id, "starting");
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop"), &json!({})).status, 202);
    let job = service.wait_for(id, "stopped");
    assert!(programs.path().join("gone").exists(), "{job}");
    // An administrator cancels this one.
    let next = service.submit(&by_slurm(bars(&[])));
    service.wait_for(next, "stopped");
}
