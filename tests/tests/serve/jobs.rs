//! Jobs of a service, from their submission to their files.

use crumple_tests::program::{crumple_with, run};
use crumple_tests::service::{Service, bars, endless};
use serde_json::{Value, json};

/// Returns the events of a job that has ended, as kind and data.
fn events(service: &Service, id: i64, headers: &[(&str, &str)]) -> Vec<(i64, String, Value)> {
    let bearer = format!("Bearer {}", service.token);
    let headers = [&[("Authorization", &*bearer)], headers].concat();
    let reply = service.ask("GET", &format!("/api/jobs/{id}/events"), &headers, b"");
    assert_eq!(reply.status, 200, "{}", reply.text());
    let text = reply.text();
    let field = |block: &str, key: &str| {
        block.lines().find_map(|line| Some(line.strip_prefix(key)?.trim().to_string()))
    };
    // Lines of sizes stand between the blocks of a chunked body.
    text.split("\n\n")
        .filter_map(|block| {
            let data = serde_json::from_str(&field(block, "data:")?).ok()?;
            let id = field(block, "id:").and_then(|id| id.parse().ok()).unwrap_or(0);
            Some((id, field(block, "event:")?, data))
        })
        .collect()
}

#[test]
fn a_job_has_the_bits_of_a_run_and_its_files_and_events_can_be_fetched() {
    let service = Service::start(&[]);
    let id = service.submit(&bars(&[]));
    let job = service.wait_for(id, "completed");
    assert_eq!((job["code"].as_i64(), job["attempt"].as_i64()), (Some(0), Some(1)), "{job}");
    assert!(job["memory_mb"].as_f64().unwrap() > 0.0, "{job}");
    let file = |path: &str| service.get(&format!("/api/jobs/{id}/files/{path}"));
    let plain = run(crumple_with(&["run", "cases/bars", "--quiet", "--workers", "1"]));
    assert_eq!(
        file("results/summary.json").json()["state_digest"],
        plain.summary()["state_digest"]
    );

    let listed = service.get(&format!("/api/jobs/{id}/files")).json();
    let names: Vec<_> =
        listed.as_array().unwrap().iter().map(|f| f["path"].as_str().unwrap()).collect();
    for name in ["input/job.toml", "results/history.csv", "results/report.html", "check.json"] {
        assert!(names.contains(&name), "{names:?}");
    }
    let whole = file("results/history.csv").body;
    let bearer = format!("Bearer {}", service.token);
    let part = service.ask(
        "GET",
        &format!("/api/jobs/{id}/files/results/history.csv"),
        &[("Authorization", &bearer), ("Range", "bytes=10-19")],
        b"",
    );
    assert_eq!((part.status, &part.body[..]), (206, &whole[10..20]));
    assert_eq!(part.header("Content-Range"), Some(&*format!("bytes 10-19/{}", whole.len())));
    let report = file("results/report.html");
    assert!(report.header("Content-Security-Policy").unwrap().starts_with("sandbox"));
    let check = service.get(&format!("/api/jobs/{id}/check")).json();
    assert!(check["text"].as_str().unwrap().contains("no warnings"), "{check}");

    let all = events(&service, id, &[]);
    let states: Vec<_> =
        all.iter().filter(|e| e.1 == "state").map(|e| e.2["state"].clone()).collect();
    assert_eq!(states.first(), Some(&json!("checking")));
    assert_eq!(states.last(), Some(&json!("completed")));
    assert_eq!(all.last().unwrap().1, "end");
    let ids: Vec<i64> = all.iter().map(|e| e.0).filter(|id| *id > 0).collect();
    assert!(ids.is_sorted_by(|a, b| a < b), "{ids:?}");
    let second = ids[1].to_string();
    let later = events(&service, id, &[("Last-Event-ID", &second)]);
    assert_eq!(later[..], all[2..], "events after the second");
}

#[test]
fn jobs_start_by_priority_and_one_that_is_cancelled_never_starts() {
    let service = Service::start(&["--slots", "1"]);
    let with = |mut job: Value, priority: i32| {
        job["priority"] = json!(priority);
        service.submit(&job)
    };
    let first = with(endless(), 0);
    service.wait_for(first, "running");
    let [low, high, cancelled] =
        [(bars(&[]), 0), (bars(&[]), 5), (bars(&[]), 9)].map(|(job, priority)| with(job, priority));
    for id in [low, high, cancelled] {
        service.wait_for(id, "queued");
    }
    assert_eq!(service.post(&format!("/api/jobs/{cancelled}/stop"), &json!({})).status, 202);
    assert_eq!(service.job(cancelled)["state"], "stopped");
    assert_eq!(service.post(&format!("/api/jobs/{first}/stop"), &json!({})).status, 202);
    let stopped = service.wait_for(first, "stopped");
    assert_eq!(stopped["code"], 130);
    let started = |id| service.wait_for(id, "completed")["started"].as_f64().unwrap();
    assert!(started(high) < started(low));
    assert_eq!(service.job(cancelled)["attempt"], 0);
    let page = service.get("/api/jobs?limit=2").json();
    assert_eq!((page["total"].as_i64(), page["next"].as_i64()), (Some(4), Some(high)));
    let next = service.get(&format!("/api/jobs?limit=2&before={high}")).json();
    assert_eq!(next["jobs"][0]["id"].as_i64(), Some(low));
    let done = service.get("/api/jobs?state=completed").json();
    assert_eq!(done["total"], 2);
    let metrics = service.get("/metrics").text();
    assert!(metrics.contains("crumple_jobs{state=\"completed\"} 2\n"), "{metrics}");
}

#[test]
fn a_run_is_steered_stopped_and_resumed_with_another_end() {
    let service = Service::start(&[]);
    let id = service.submit(&endless());
    service.wait_for(id, "running");
    let order = |body: Value| service.post(&format!("/api/jobs/{id}/orders"), &body);
    // The run has no socket in its first moments.
    let done = service.wait("the run takes orders", |_| {
        let reply = order(json!({"request": "pause"}));
        (reply.status == 200).then(|| reply.json())
    });
    assert_eq!(done["order"], "pause");
    assert_eq!(order(json!({"request": "status"})).json()["state"], "paused");
    let refused = order(json!({"request": "set", "key": "end_time", "value": -1.0}));
    assert_eq!(refused.status, 409, "{}", refused.text());
    assert_eq!(order(json!({"request": "continue"})).status, 200);
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop"), &json!({})).status, 202);
    service.wait_for(id, "stopped");
    let summary = || service.get(&format!("/api/jobs/{id}/files/results/summary.json")).json();
    let reached = summary()["end_time"].as_f64().unwrap();
    let end = format!("end_time={:?}", reached + 0.5);
    let resumed = service.post(&format!("/api/jobs/{id}/resume"), &json!({"set": [end]}));
    assert_eq!(resumed.status, 202, "{}", resumed.text());
    let job = service.wait_for(id, "completed");
    assert_eq!(job["attempt"], 2);
    assert!(summary()["end_time"].as_f64().unwrap() >= reached + 0.49, "{}", summary());
    let audit = service.get("/api/audit").json();
    let audit = audit.as_array().unwrap();
    let count =
        |what: &str| audit.iter().filter(|e| e["what"].as_str().unwrap().ends_with(what)).count();
    assert!(count("/orders") >= 3 && count("/stop") == 1 && count("/resume") == 1, "{audit:?}");
}

#[test]
fn a_job_with_errors_is_refused_with_its_findings_and_one_that_is_only_checked_waits() {
    let service = Service::start(&[]);
    let bad = service.submit(&bars(&["material.steel.density=-1"]));
    let job = service.wait_for(bad, "refused");
    assert!(job["reason"].as_str().unwrap().contains("density"), "{job}");
    let check = service.get(&format!("/api/jobs/{bad}/check")).json();
    assert_eq!(check["usable"], false);
    assert_eq!(service.post(&format!("/api/jobs/{bad}/resume"), &json!({})).status, 409);
    let mut only = bars(&[]);
    only["check_only"] = json!(true);
    let only = service.submit(&only);
    service.wait_for(only, "checked");
    assert_eq!(service.post(&format!("/api/jobs/{only}/resume"), &json!({})).status, 202);
    service.wait_for(only, "completed");
}

#[test]
fn a_job_that_needs_more_memory_than_there_is_is_refused() {
    let service = Service::start(&["--memory", "0.5"]);
    let large = service.submit(&bars(&["scene.elements=2000"]));
    let job = service.wait_for(large, "refused");
    let check = service.get(&format!("/api/jobs/{large}/check")).json();
    let why = [&job["reason"], &check["text"]].map(|text| text.as_str().unwrap().to_string());
    assert!(why.concat().contains("MB") || why.concat().contains("memory"), "{why:?}");
    let small = service.submit(&bars(&[]));
    service.wait_for(small, "completed");
}

/// A job that waits while the service starts again with fewer places would hold back all others.
#[test]
fn a_job_that_no_longer_fits_is_refused_and_others_start() {
    let mut service = Service::start(&["--slots", "2"]);
    let first = service.submit(&endless());
    service.wait_for(first, "running");
    let mut large = bars(&[]);
    large["workers"] = json!(2);
    let large = service.submit(&large);
    service.wait_for(large, "queued");
    service.kill();
    service.set_options(&["--slots", "1"]);
    service.again();
    let reason = service.wait_for(large, "refused")["reason"].to_string();
    assert!(reason.contains("2 workers") && reason.contains("1 workers"), "{reason}");
    let small = service.submit(&bars(&[]));
    assert_eq!(service.post(&format!("/api/jobs/{first}/stop"), &json!({})).status, 202);
    service.wait_for(small, "completed");
}
