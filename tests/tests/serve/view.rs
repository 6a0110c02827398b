//! Pictures of jobs that run.

use crumple_tests::service::{Reply, Service, bars, endless};
use serde_json::{Value, json};
use std::fs;

/// Returns the answer to a request for the picture of a job.
fn view(service: &Service, id: i64, tag: &str) -> Reply {
    let bearer = format!("Bearer {}", service.token);
    let headers = [("Authorization", &*bearer), ("If-None-Match", tag)];
    service.ask("GET", &format!("/api/jobs/{id}/view"), &headers, b"")
}

/// Waits for a picture later than `cycle`.
fn later(service: &Service, id: i64, cycle: u64) -> (u64, Value, String) {
    service.wait("there is a later picture", |service| {
        let reply = view(service, id, "");
        let picture = (reply.status == 200).then(|| reply.json())?;
        let now = picture["cycle"].as_u64()?;
        let tag = reply.header("ETag").unwrap().to_string();
        (now > cycle).then_some((now, picture, tag))
    })
}

/// Without any output the pictures follow the run, also after the service was killed; a run that is
/// paused has the same one; and a run that ends leaves no file of them.
#[test]
fn a_running_job_is_seen_without_output_files_and_after_the_service_was_killed() {
    let mut service = Service::start(&[]);
    let mut job = endless();
    job["workers"] = json!(2);
    let id = service.submit(&job);
    let (first, picture, _) = later(&service, id, 0);
    assert_eq!(picture["model"]["frames"].as_array().unwrap().len(), 1);
    assert!(picture["model"]["faces"].as_u64().unwrap() > 0, "{picture}");
    assert_eq!(picture["boxes"].as_array().unwrap().len(), 2, "a box for each worker");
    assert!(picture["part_names"].as_object().is_some_and(|names| !names.is_empty()));
    service.kill();
    service.again();
    let (second, next, _) = later(&service, id, first);
    assert_ne!(picture["picture"], next["picture"], "the bars have moved");
    let order = |what: &str| {
        let reply = service.post(&format!("/api/jobs/{id}/orders"), &json!({"request": what}));
        assert_eq!(reply.status, 200, "{}", reply.text());
        reply.json()
    };
    let paused = order("pause")["cycle"].as_u64().unwrap();
    assert!(paused > second);
    let (at, _, tag) = later(&service, id, paused - 1);
    assert_eq!(at, paused, "the picture is that of the pause");
    std::thread::sleep(std::time::Duration::from_millis(2500));
    let same = view(&service, id, &tag);
    assert_eq!((same.status, same.body.len()), (304, 0), "{}", same.head);
    order("continue");
    assert!(service.folder(id).join("results/view").exists());
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop"), &json!({})).status, 202);
    service.wait_for(id, "stopped");
    assert!(!service.folder(id).join("results/view").exists());
}

#[test]
fn a_job_that_has_ended_shows_its_last_output_and_damage_is_no_failure() {
    let service = Service::start(&[]);
    let id = service.submit(&bars(&[]));
    service.wait_for(id, "completed");
    let reply = view(&service, id, "");
    assert_eq!(reply.status, 200, "{}", reply.text());
    let picture = reply.json();
    let summary = service.get(&format!("/api/jobs/{id}/files/results/summary.json")).json();
    assert_eq!(picture["model"]["frames"][0]["time"], summary["end_time"]);
    assert!(picture["boxes"].as_array().unwrap().is_empty());
    assert_eq!(view(&service, 99, "").status, 404);
    let only = bars(&["output.field_interval=-1"]);
    let none = service.submit(&only);
    service.wait_for(none, "completed");
    assert_eq!(view(&service, none, "").status, 204);
    let broken = service.submit(&bars(&[]));
    service.wait_for(broken, "completed");
    let fields = service.folder(broken).join("results/fields");
    for step in fs::read_dir(&fields).unwrap().flatten().filter(|e| e.path().is_dir()) {
        fs::write(step.path().join("piece_000.vtu"), "no field file").unwrap();
    }
    assert_eq!(view(&service, broken, "").status, 204);
}
