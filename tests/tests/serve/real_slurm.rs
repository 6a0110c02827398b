//! A real Slurm, which `deploy/slurm_single_node.sh` starts. Its node takes one job at a time.

use crate::torture::processes;
use crumple_tests::program::send;
use crumple_tests::service::{Service, bars, endless};
use rustix::process::Signal;
use serde_json::{Value, json};
use std::fs;
use std::process::Command;
use std::time::Instant;

fn by_slurm(mut job: Value) -> Value {
    job["launcher"] = json!("slurm");
    job
}

/// Returns state and name of all jobs that Slurm knows, such as `PENDING crumple-2`.
fn queue() -> String {
    let mut command = Command::new("squeue");
    command.args(["--noheader", "--states=all", "--format=%T %j"]);
    String::from_utf8(command.output().unwrap().stdout).unwrap()
}

fn wait_in_queue(service: &Service, text: &str) {
    service.wait(text, |_| queue().lines().any(|line| line == text).then_some(()));
}

fn order(service: &Service, id: i64, order: &str, body: &Value) {
    let reply = service.post(&format!("/api/jobs/{id}/{order}"), body);
    assert_eq!(reply.status, 202, "{}", reply.text());
}

fn summary(service: &Service, id: i64) -> Value {
    let text = fs::read(service.folder(id).join("results/summary.json")).unwrap();
    serde_json::from_slice(&text).unwrap()
}

#[test]
#[ignore = "needs a Slurm: deploy/slurm_single_node.sh"]
fn jobs_go_through_a_real_slurm() {
    let mut service = Service::start(&["--slurm"]);
    let began = Instant::now();
    let step = |what: &str| println!("{:6.1} s  {what}", began.elapsed().as_secs_f64());
    let id = service.submit(&by_slurm(endless()));
    service.wait_for(id, "running");
    step("the first job runs");
    service.wait("its progress is seen", |service| {
        (service.get(&format!("/api/jobs/{id}/progress")).status == 200).then_some(())
    });
    step("its progress is seen");

    // The next ones wait at Slurm. One is stopped there, also by a service that was killed.
    let (stopped, next) =
        (service.submit(&by_slurm(bars(&[]))), service.submit(&by_slurm(bars(&[]))));
    wait_in_queue(&service, &format!("PENDING crumple-{stopped}"));
    wait_in_queue(&service, &format!("PENDING crumple-{next}"));
    service.kill();
    service.again();
    step("the service was killed and started again");
    assert_eq!(service.wait_for(id, "running")["attempt"], 1);
    order(&service, stopped, "stop", &json!({}));
    assert_eq!(service.wait_for(stopped, "stopped")["code"], 130);
    wait_in_queue(&service, &format!("CANCELLED crumple-{stopped}"));
    step("a job that waits is cancelled");
    assert!(!service.folder(stopped).join("results").exists(), "it has never run");
    assert_eq!(service.job(next)["state"], "starting");

    // The one that runs keeps its state; then the next one runs.
    order(&service, id, "stop", &json!({}));
    let job = service.wait_for(id, "stopped");
    step("the first job has stopped");
    assert_eq!(job["code"], 130, "{job}");
    let checkpoints = fs::read_dir(service.folder(id).join("results/checkpoints")).unwrap();
    assert!(checkpoints.flatten().any(|one| one.path().join("MANIFEST").exists()));
    let before = summary(&service, id);
    service.wait_for(next, "completed");
    step("the next job is complete");

    // It continues, and ends while there is no service.
    let end = before["end_time"].as_f64().unwrap() + 1.0;
    order(&service, id, "resume", &json!({"set": [format!("end_time={end}")]}));
    service.wait("it is at Slurm", |service| {
        (service.job(id)["attempt"] == 2 && queue().lines().count() >= 4).then_some(())
    });
    service.kill();
    let attempt = service.folder(id).join("attempt-2");
    service.wait("it has ended", |_| {
        fs::read_to_string(&attempt).ok()?.contains("code 0").then_some(())
    });
    service.again();
    let job = service.wait_for(id, "completed");
    step("the first job has continued to its end without a service");
    assert_eq!((job["attempt"].as_i64(), job["code"].as_i64()), (Some(2), Some(0)));
    let after = summary(&service, id);
    assert!(after["cycles"].as_i64() > before["cycles"].as_i64(), "{before} {after}");

    // One that does not stop is killed by force: all its processes are stopped.
    let deaf = service.submit(&by_slurm(endless()));
    service.wait_for(deaf, "running");
    service.wait("it answers", |service| {
        (service.get(&format!("/api/jobs/{deaf}/progress")).status == 200).then_some(())
    });
    let folder = service.folder(deaf).canonicalize().unwrap();
    let processes = || processes(&folder);
    assert!(!processes().is_empty(), "it has processes");
    processes().into_iter().for_each(|(pid, _)| send(pid, Signal::STOP));
    order(&service, deaf, "stop", &json!({}));
    std::thread::sleep(std::time::Duration::from_secs(2));
    assert_eq!(service.job(deaf)["state"], "running", "it does not stop");
    order(&service, deaf, "stop?force=true", &json!({}));
    let job = service.wait_for(deaf, "stopped");
    assert!(job["reason"].as_str().unwrap().starts_with("killed"), "{job}");
    service.wait("no process is left", |_| processes().is_empty().then_some(()));
    step("a job that does not stop is killed");

    // The service still knows jobs that Slurm has forgotten, and does not run them again.
    service.wait("slurm forgets", |_| queue().is_empty().then_some(()));
    service.kill();
    service.again();
    let states: Vec<Value> = [id, stopped, next].map(|id| service.job(id)["state"].clone()).into();
    assert_eq!(states, ["completed", "stopped", "completed"]);
    step("slurm has forgotten all jobs");
}
