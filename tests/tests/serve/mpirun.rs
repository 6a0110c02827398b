//! Jobs that `mpirun` starts.

use crumple_tests::program::mpi_or_skip;
use crumple_tests::service::{Service, endless};
use serde_json::{Value, json};

/// One machine, more ranks than cores, perhaps root in a container.
pub const MPIRUN: &str = "mpirun --allow-run-as-root --oversubscribe -n {ranks}";

/// A job on two ranks is paused, saved, stopped and continued on three; it has the bits of a job
/// on threads that was never held.
#[test]
fn a_job_by_mpirun_continues_on_more_ranks_with_the_bits_of_threads() {
    let Some(()) = mpi_or_skip() else { return };
    let service = Service::start(&["--mpirun", MPIRUN, "--mpirun-slots", "2"]);
    let mut job = endless();
    job["launcher"] = json!("mpirun");
    let id = service.submit(&job);
    service.wait_for(id, "running");
    let order =
        |name: &str| service.post(&format!("/api/jobs/{id}/orders"), &json!({"request": name}));
    // The run has no socket in its first moments.
    service.wait("the run is paused", |_| (order("pause").status == 200).then_some(()));
    let saved = order("checkpoint");
    assert_eq!(saved.status, 200, "{}", saved.text());
    assert_eq!(order("status").json()["state"], "paused");
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop"), &json!({})).status, 202);
    service.wait_for(id, "stopped");
    let summary = |id: i64| -> Value {
        service.get(&format!("/api/jobs/{id}/files/results/summary.json")).json()
    };
    let first = summary(id);
    assert_eq!(first["workers"], 1, "{first}");
    let end = format!("end_time={:?}", first["end_time"].as_f64().unwrap() + 0.5);
    let change = json!({"workers": 2, "set": [end]});
    let resumed = service.post(&format!("/api/jobs/{id}/resume"), &change);
    assert_eq!(resumed.status, 202, "{}", resumed.text());
    let ended = service.wait_for(id, "completed");
    assert_eq!((&ended["attempt"], &ended["launcher"]), (&json!(2), &json!("mpirun")), "{ended}");
    let mut plain = endless();
    plain["set"].as_array_mut().unwrap().push(json!(end));
    let plain = service.submit(&plain);
    service.wait_for(plain, "completed");
    let (continued, plain) = (summary(id), summary(plain));
    assert_eq!(continued["workers"], 2, "{continued}");
    assert_eq!(continued["transport"], "mpi");
    assert_eq!(plain["transport"], "threads");
    assert_eq!(continued["cycles"], plain["cycles"]);
    assert_eq!(continued["state_digest"], plain["state_digest"]);
}
