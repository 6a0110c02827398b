//! Services and runs that are killed: no job is lost, and none runs twice.

use super::mpirun::MPIRUN;
use crumple_tests::program::{crumple_with, mpi_or_skip, run, send};
use crumple_tests::service::{Service, bars, children, endless};
use rustix::process::Signal;
use serde_json::Value;
use std::fs;
use std::time::Duration;

/// Returns the process of an attempt.
pub(crate) fn process(service: &Service, id: i64, attempt: u32) -> u32 {
    let path = service.folder(id).join(format!("attempt-{attempt}"));
    let text = service.wait("the attempt is claimed", |_| fs::read_to_string(&path).ok());
    text.lines().find_map(|line| line.strip_prefix("pid ")?.parse().ok()).unwrap()
}

#[test]
fn a_run_survives_its_service_and_is_found_and_stopped_by_the_next_one() {
    let mut service = Service::start(&[]);
    let id = service.submit(&endless());
    service.wait_for(id, "running");
    let pid = process(&service, id, 1);
    service.kill();
    service.again();
    let job = service.wait_for(id, "running");
    assert_eq!(job["attempt"], 1);
    assert_eq!(process(&service, id, 1), pid);
    // The stream of the run is followed again.
    service.wait("there is progress", |service| {
        (service.get(&format!("/api/jobs/{id}/progress")).status == 200).then_some(())
    });
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop"), &serde_json::json!({})).status, 202);
    assert_eq!(service.wait_for(id, "stopped")["code"], 130);
}

#[test]
fn a_run_that_ends_while_there_is_no_service_has_its_exit_code() {
    let mut service = Service::start(&[]);
    let id = service.submit(&bars(&["scene.elements=400"]));
    let _ = process(&service, id, 1);
    service.kill();
    let path = service.folder(id).join("attempt-1");
    service.wait("the run has ended", |_| {
        fs::read_to_string(&path).ok()?.contains("code 0").then_some(())
    });
    service.again();
    let job = service.wait_for(id, "completed");
    assert_eq!((job["code"].as_i64(), job["attempt"].as_i64()), (Some(0), Some(1)));
}

#[test]
fn a_job_whose_processes_are_killed_continues_from_its_checkpoint() {
    let service = Service::start(&[]);
    let mut job = endless();
    job["set"].as_array_mut().unwrap().push("checkpoint.every=1 s".into());
    let id = service.submit(&job);
    let checkpoints = service.folder(id).join("results/checkpoints");
    service.wait("there is a checkpoint", |_| {
        let all = fs::read_dir(&checkpoints).ok()?.flatten();
        all.into_iter().any(|c| c.path().join("MANIFEST").exists()).then_some(())
    });
    let supervisor = process(&service, id, 1);
    let runs = children(supervisor);
    send(supervisor, Signal::KILL);
    runs.into_iter().for_each(|run| send(run, Signal::KILL));
    service.wait("it runs again", |service| {
        let job = service.job(id);
        (job["state"] == "running" && job["attempt"] == 2).then_some(())
    });
    let log = service.folder(id).join("results/log.jsonl");
    service.wait("the run continues from the checkpoint", |_| {
        fs::read_to_string(&log).ok()?.contains("run continues").then_some(())
    });
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop"), &serde_json::json!({})).status, 202);
    service.wait_for(id, "stopped");
}

/// Stops all processes of a job, which then answer neither signals nor the socket, and stops the
/// job by force.
fn assert_killed(service: &Service, job: &Value, processes: usize) {
    let id = service.submit(job);
    service.wait_for(id, "running");
    let supervisor = process(service, id, 1);
    let below = service.wait("the run has begun", |_| {
        let mut all = children(supervisor);
        all.extend(all.clone().into_iter().flat_map(children));
        let log = fs::read_to_string(service.folder(id).join("results/log.jsonl"));
        (all.len() == processes && log.is_ok_and(|log| !log.is_empty())).then_some(all)
    });
    below.iter().chain([&supervisor]).for_each(|&pid| send(pid, Signal::STOP));
    let (ask, force) = (format!("/api/jobs/{id}/stop"), format!("/api/jobs/{id}/stop?force=true"));
    let refused = service.post(&force, &serde_json::json!({}));
    assert_eq!(refused.status, 409, "it was not asked before");
    assert_eq!(service.post(&ask, &serde_json::json!({})).status, 202);
    service.wait("the request to stop has arrived", |_| {
        let status = fs::read_to_string(format!("/proc/{supervisor}/status")).unwrap();
        let pending = status.lines().find_map(|line| line.strip_prefix("ShdPnd:")).unwrap();
        let pending = u64::from_str_radix(pending.trim(), 16).unwrap();
        (pending >> (Signal::TERM.as_raw() - 1) & 1 == 1).then_some(())
    });
    assert_eq!(service.job(id)["state"], "running");
    let folder = service.folder(id).join("../..").to_string_lossy().into_owned();
    run(crumple_with(&["stop", &id.to_string(), "--force", "--dir", &folder])).with_code(0);
    let job = service.wait_for(id, "stopped");
    assert!(job["reason"].as_str().unwrap().starts_with("killed"), "{job}");
    let audit = service.get("/api/audit").json().to_string();
    assert!(audit.contains("\"detail\":\"force\""), "{audit}");
    for pid in below.into_iter().chain([supervisor]) {
        service.wait("the process has ended", |_| {
            let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
            (stat.is_empty() || stat.contains(") Z")).then_some(())
        });
    }
}

#[test]
fn a_job_that_does_not_stop_is_killed() {
    assert_killed(&Service::start(&[]), &endless(), 1);
}

#[test]
fn a_job_by_mpirun_that_does_not_stop_is_killed() {
    let Some(()) = mpi_or_skip() else { return };
    let service = Service::start(&["--mpirun", MPIRUN]);
    let mut job = endless();
    job["launcher"] = "mpirun".into();
    assert_killed(&service, &job, 3); // mpirun, master and worker
}

#[test]
fn a_run_whose_supervisor_is_killed_is_not_started_again() {
    let service = Service::start(&[]);
    let id = service.submit(&endless());
    service.wait_for(id, "running");
    let supervisor = process(&service, id, 1);
    let lock = service.folder(id).join("results/run.lock");
    let run = service.wait("the run has its lock", |_| {
        fs::read_to_string(&lock).ok()?.trim().parse::<u32>().ok()
    });
    send(supervisor, Signal::KILL);
    std::thread::sleep(Duration::from_secs(2)); // several turns of the loop
    let job = service.job(id);
    assert_eq!((job["state"].as_str(), job["attempt"].as_i64()), (Some("running"), Some(1)));
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop"), &serde_json::json!({})).status, 202);
    service.wait_for(id, "stopped");
    assert!(!std::path::Path::new(&format!("/proc/{run}/cwd")).exists());
}

/// A supervisor that is killed in the first moments of its run: the service starts another one.
#[test]
fn a_run_whose_supervisor_has_ended_before_it_runs_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("attempt-1");
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap();
    fs::write(&path, format!("pid 1\nhost {host}")).unwrap();
    let words = ["run", "cases/bars", "--quiet", "--under", path.to_str().unwrap()];
    let ended = run(crumple_with(&words)).with_code(2);
    assert!(ended.said().contains("the supervisor has ended; nothing is run"), "{}", ended.said());
    assert!(!ended.out().join("history.csv").exists());
    let attempt = fs::File::open(&path).unwrap();
    attempt.lock().unwrap();
    run(crumple_with(&words)).with_code(0);
}

#[test]
fn a_run_that_stops_is_not_asked_again_by_the_next_service() {
    let mut service = Service::start(&[]);
    let id = service.submit(&endless());
    service.wait_for(id, "running");
    service.wait("the run has begun", |service| {
        (service.get(&format!("/api/jobs/{id}/progress")).status == 200).then_some(())
    });
    // The run takes long to stop. Its supervisor would kill it at the third request.
    let runs = children(process(&service, id, 1));
    runs.iter().for_each(|run| send(*run, Signal::STOP));
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop"), &serde_json::json!({})).status, 202);
    for _ in 0..3 {
        std::thread::sleep(Duration::from_millis(1500)); // several turns of the loop
        service.kill();
        service.again();
    }
    std::thread::sleep(Duration::from_millis(1500));
    assert_eq!(service.job(id)["state"], "running");
    runs.iter().for_each(|run| send(*run, Signal::CONT));
    assert_eq!(service.wait_for(id, "stopped")["code"], 130);
    let checkpoints = fs::read_dir(service.folder(id).join("results/checkpoints")).unwrap();
    assert!(checkpoints.flatten().any(|one| one.path().join("MANIFEST").exists()));
}

#[test]
fn two_services_do_not_share_a_folder() {
    let service = Service::start(&[]);
    let second = service.command(&["serve", "--listen", "127.0.0.1:0"]);
    assert_eq!(second.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&second.stderr).contains("another service"), "{second:?}");
}
