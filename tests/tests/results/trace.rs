//! The time line of a run: its contents, and their agreement with the summary.

use crumple::results::summary::Summary;
use crumple::run::control::{self, Guidance, Origin, Results};
use crumple::run::service::signals::StopFlag;
use crumple_proto::report::PHASES;
use crumple_proto::transport::threads::connect;
use crumple_tests::{case, read};
use serde_json::Value;

const WORKERS: usize = 2;

/// Runs a job on two workers; returns the summary and the events of its trace.
fn traced(sets: &[&str]) -> (Summary, Vec<Value>) {
    let mut model = read(&case("bars"), sets);
    let out = tempfile::tempdir().unwrap();
    let path = out.path().join("trace.json");
    let mut ends = connect(WORKERS + 1);
    let mut master = ends.remove(0);
    let summary = std::thread::scope(|scope| {
        for mut end in ends {
            scope.spawn(move || crumple_worker::serve::serve(&mut end).unwrap());
        }
        let results = Results { out: out.path(), trace: Some(&path) };
        let (origin, stop) = (Origin::default(), StopFlag::default());
        control::run(&mut model, &mut master, results, origin, Guidance::quiet(&stop)).unwrap()
    });
    let trace: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    assert!(trace["otherData"]["clocks"].as_str().unwrap().contains("one clock"));
    (summary, trace["traceEvents"].as_array().unwrap().clone())
}

fn number(event: &Value, key: &str) -> f64 {
    event[key].as_f64().unwrap_or_else(|| panic!("no {key}: {event}"))
}

fn spans(events: &[Value], worker: usize) -> Vec<&Value> {
    events.iter().filter(|e| e["ph"] == "X" && e["tid"] == worker).collect()
}

/// The trace has every phase of every worker, in the order of time. The sums agree with the
/// summary. Renewals and orders are in the trace.
#[test]
fn a_trace_holds_all_phases_of_all_workers_and_they_add_up() {
    let (summary, events) = traced(&["time.max_cycles=120", "parallel.force_every=25"]);
    assert_eq!(summary.cycles, 120);
    let mut most = [0.0f64; PHASES.len()];
    let mut sums = [0.0f64; PHASES.len()];
    for worker in 0..WORKERS {
        let spans = spans(&events, worker);
        let mut end = 0.0;
        for s in &spans {
            // Times have three decimal places: an event may end later than the next begins by
            // half of the last place.
            assert!(number(s, "ts") >= end - 1e-3, "overlap at {s}");
            end = number(s, "ts") + number(s, "dur");
        }
        for (p, name) in PHASES.iter().enumerate() {
            let of_phase = || spans.iter().filter(|s| s["name"] == *name);
            assert!(of_phase().next().is_some(), "worker {worker} has no {name}");
            let seconds = 1e-6 * of_phase().map(|s| number(s, "dur")).sum::<f64>();
            most[p] = most[p].max(seconds);
            sums[p] += seconds;
        }
        let cycles: Vec<u64> = spans.iter().map(|s| s["args"]["cycle"].as_u64().unwrap()).collect();
        assert!(
            cycles.is_sorted() && (cycles[0], cycles[cycles.len() - 1]) == (0, 119),
            "{cycles:?}"
        );
        let moments: Vec<&str> = events
            .iter()
            .filter(|e| e["ph"] == "i" && e["tid"] == worker)
            .map(|e| e["name"].as_str().unwrap())
            .collect();
        // Copies of the state in memory are orders too, so that numbers differ from run to run.
        for words in
            [" received: high redecomposition", ": high redecomposition", ": low redecomposition"]
        {
            let is_there = moments.iter().any(|m| {
                let number = m.strip_prefix("order ").and_then(|m| m.strip_suffix(words));
                number.is_some_and(|n| n.parse::<u32>().is_ok())
            });
            assert!(is_there, "no order{words} among {moments:?}");
        }
    }
    for (p, name) in PHASES.iter().enumerate() {
        let said = &summary.phase_s[*name];
        // Each event, of microseconds and more, is truncated to nanoseconds once.
        let close = |a: f64, b: f64| (a - b).abs() <= 0.01 * b.max(1e-6);
        assert!(
            close(most[p], said.max) && close(sums[p] / WORKERS as f64, said.mean),
            "{name}: {} {said:?}",
            most[p]
        );
    }
}

/// A run that fails writes its trace too.
#[test]
fn a_run_that_fails_leaves_its_trace() {
    let (summary, events) = traced(&["time.safety=3"]);
    assert_eq!(summary.status, crumple::results::summary::RunEnd::Failed, "{}", summary.reason);
    for worker in 0..WORKERS {
        let last = spans(&events, worker).last().unwrap()["args"]["cycle"].as_u64().unwrap();
        assert!(last.abs_diff(summary.cycles) <= 1, "cycle {last} of {}", summary.cycles);
    }
}
