//! Runs in progress that clients watch and steer, on threads and under MPI.

use crumple::run::request::{Answer, Request};
use crumple_tests::client::Client;
use crumple_tests::program::{Ended, Running, crumple_with, mpi_or_skip, mpirun, run, send, start};
use crumple_tests::restart::{assert_same_histories, checkpoints};
use rustix::process::Signal;
use serde_json::Value;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::time::{Duration, Instant};

/// Enough cycles for a change of the end to take effect first.
const LONG: [&str; 2] = ["--set", "time.max_cycles=9000"];
/// Long enough for a client to attach.
const TUMBLE: [&str; 6] =
    ["run", "cases/tumble", "--quiet", "--no-report", "--set", "time.max_cycles=900"];

fn transports() -> Vec<&'static str> {
    if mpi_or_skip().is_some() { vec!["threads", "mpi"] } else { vec!["threads"] }
}

fn start_on(transport: &str, workers: usize, more: &[&str]) -> Running {
    let (args, number) = ([&TUMBLE[..], more].concat(), workers.to_string());
    start(match transport {
        "mpi" => mpirun(workers + 1, &args),
        _ => crumple_with(&[&args[..], &["--workers", &number]].concat()),
    })
}

/// Returns options that repeat the orders in a file.
fn steered_by(plan: &Path) -> [&str; 4] {
    [LONG[0], LONG[1], "--steering", plan.to_str().expect("a name in UTF-8")]
}

fn undisturbed() -> Ended {
    start_on("threads", 1, &[]).end().with_code(0)
}

/// Returns the orders in the summary, without those that repeat nothing.
fn steering(summary: &Value) -> Vec<(u64, String)> {
    let list = summary["steering"].as_array().expect("a list").iter();
    let all = list.map(|r| (r["cycle"].as_u64().unwrap(), r["order"].as_str().unwrap().into()));
    all.filter(|(_, order): &(u64, String)| order != "pause" && order != "continue").collect()
}

/// The cycle of a paused run stands still. A checkpoint is written, once for the same cycle. Then
/// the run goes on with the bits of one without clients.
#[test]
fn a_paused_run_waits_and_goes_on_with_the_same_bits() {
    let whole = undisturbed().digest();
    for transport in transports() {
        let mut running = start_on(transport, 2, &[]);
        let mut first = Client::attach(&mut running);
        let pause = first.order(&Request::Pause);
        assert!(pause.cycle < 900, "{transport}: too late: {pause:?}");
        let mut second = Client::attach(&mut running);
        for client in [&mut first, &mut second] {
            let status = client.status();
            assert_eq!((status.state.as_str(), status.progress.cycle), ("paused", pause.cycle));
            assert_eq!((status.workers, status.transport.as_str()), (2, transport));
            std::thread::sleep(Duration::from_millis(300));
        }
        let socket = running.out().join("run.sock");
        assert_eq!(socket.metadata().unwrap().permissions().mode() & 0o777, 0o600);
        let saved = second.order(&Request::Checkpoint);
        assert_eq!(saved.cycle, pause.cycle);
        assert_eq!(checkpoints(&running.out()), [format!("cycle_{:010}", pause.cycle)]);
        let again = first.order(&Request::Checkpoint);
        assert!(again.note.contains("is complete"), "{again:?}");
        assert_eq!(first.order(&Request::Continue).cycle, pause.cycle);
        assert!(second.refusal("{\"request\": \"continue\"}\n").contains("not paused"));
        let out = running.out();
        let ended = running.end().with_code(0);
        assert_eq!(ended.digest(), whole, "{transport}");
        assert!(!out.join("run.sock").exists());
        let orders: Vec<Value> = ended.summary()["steering"].as_array().unwrap().clone();
        let names: Vec<&str> = orders.iter().map(|r| r["order"].as_str().unwrap()).collect();
        assert_eq!(names, ["pause", "checkpoint", "continue"]);
        let logged = |e: &Value| e["fields"]["message"] == "order has taken effect";
        assert_eq!(ended.log().iter().filter(|e| logged(e)).count(), 3);
    }
}

/// Changes at agreed cycles are listed, and a run with this list has the same bits, histories and
/// times of fields on any number of workers.
#[test]
fn a_steered_run_is_repeated_bit_for_bit() {
    let whole = undisturbed();
    for transport in transports() {
        let mut running = start_on(transport, 2, &LONG);
        let mut client = Client::attach(&mut running);
        client.order(&Request::Pause);
        let status = client.status();
        let (time, end) = (status.progress.time, status.settings["end_time"]);
        assert!(
            client
                .refusal("{\"request\": \"set\", \"key\": \"time.end\", \"value\": 1}\n")
                .contains("output.field_interval")
        );
        client.set("output.history_interval", end / 1500.0);
        client.set("output.field_interval", end / 70.0);
        client.set("parallel.imbalance", 1.5);
        let changed = client.set("end_time", time + 0.1 * (end - time));
        assert_eq!(client.status().settings["end_time"], time + 0.1 * (end - time));
        client.order(&Request::Continue);
        let steered = running.end().with_code(0);
        let summary = steered.summary();
        assert_eq!(summary["reason"], "end_time", "{transport}");
        let ends = (summary["end_time"].as_f64().unwrap(), time + 0.1 * (end - time));
        assert!((ends.0 / ends.1 - 1.0).abs() < 1e-9, "{ends:?}");
        assert_ne!(steered.digest(), whole.digest());
        let orders = steering(&summary);
        assert_eq!(orders.len(), 4, "{orders:?}");
        assert!(orders.iter().all(|(cycle, _)| *cycle == changed.cycle));
        let plan = steered.out().join("summary.json");
        for workers in [1, 3] {
            let again = start_on(transport, workers, &steered_by(&plan));
            let again = again.end().with_code(0);
            assert_eq!(again.digest(), steered.digest(), "{transport}, {workers} workers");
            assert_eq!(steering(&again.summary()), orders);
            assert_same_histories(&steered.out(), &again.out());
            let times = |run: &Ended| {
                std::fs::read_to_string(run.out().join("fields/fields.pvd"))
                    .unwrap()
                    .lines()
                    .filter(|l| l.contains("part=\"0\""))
                    .count()
            };
            assert_eq!(times(&again), times(&steered));
        }
    }
}

/// A stopped run ends as by SIGTERM. One that continues from there keeps the change of its end.
#[test]
fn a_stopped_run_continues_with_what_was_changed() {
    for transport in transports() {
        let mut running = start_on(transport, 2, &LONG);
        let mut client = Client::attach(&mut running);
        client.order(&Request::Pause);
        client.order(&Request::Checkpoint);
        let end = client.status().progress.time + 0.1;
        let changed = client.set("end_time", end);
        // The checkpoint before lacks the change.
        assert!(!client.order(&Request::Checkpoint).note.contains("is complete"));
        let stopped = client.order(&Request::Stop);
        assert_eq!(stopped.cycle, changed.cycle);
        let ended = running.end().with_code(130);
        assert_eq!(ended.summary()["status"], "stopped");
        assert_eq!(checkpoints(&ended.out()), [format!("cycle_{:010}", stopped.cycle)]);
        let out = ended.out();
        let continued =
            run(crumple_with(&["run", "--resume", out.to_str().unwrap(), "--no-report"]));
        assert_eq!(continued.code, Some(0), "{}", continued.said());
        let summary: Value =
            serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).unwrap())
                .unwrap();
        assert_eq!(summary["reason"], "end_time");
        let orders = ["checkpoint", &changed.order, "checkpoint"];
        assert_eq!(steering(&summary), orders.map(|order| (changed.cycle, order.to_string())));
        let plan = out.join("summary.json");
        let whole = start_on(transport, 1, &steered_by(&plan));
        assert_eq!(whole.end().with_code(0).digest(), summary["state_digest"], "{transport}");
    }
}

/// A planned stop ends the run in its cycle.
#[test]
fn a_planned_stop_ends_the_run() {
    let dir = tempfile::tempdir().unwrap();
    let plan = dir.path().join("plan.json");
    std::fs::write(&plan, "[{\"cycle\": 123, \"order\": \"stop\"}]").unwrap();
    let ended = start_on("threads", 2, &["--steering", plan.to_str().unwrap()]).end();
    let summary = ended.with_code(130).summary();
    assert_eq!((&summary["status"], &summary["cycles"]), (&"stopped".into(), &123.into()));
    std::fs::write(&plan, "[{\"cycle\": 123, \"order\": \"halt\"}]").unwrap();
    let refused = start_on("threads", 2, &["--steering", plan.to_str().unwrap()]).end();
    assert!(refused.with_code(2).said().contains("plan.json"));
}

/// Garbage gets an error, a line that is too long also the end of the connection. A client that
/// never reads is dropped. The run goes on for others, with the same bits.
#[test]
fn rude_clients_do_not_disturb_a_run() {
    let whole = undisturbed().digest();
    let mut running = start_on("threads", 2, &[]);
    let mut polite = Client::attach(&mut running);
    polite.order(&Request::Pause);
    let mut rude = Client::attach(&mut running);
    for line in ["\n", "status\n", "{\"request\": \"halt\"}\n", "[1, 2\n"] {
        assert!(rude.refusal(line).contains("{\"request\": \"status\"}"));
    }
    let zero = "{\"request\": \"set\", \"key\": \"end_time\", \"value\": 0}\n";
    assert!(rude.refusal(zero).contains("above 0"));
    assert!(rude.refusal(&("x".repeat(100_000) + "\n")).contains("at most"));
    assert!(rude.next_line().is_none(), "the connection is closed");
    let mut binary = Client::attach(&mut running);
    let mut deaf = Client::attach(&mut running);
    deaf.send(&Request::Watch.to_line());
    deaf.flood(&Request::Status.to_line());
    let began = Instant::now();
    assert_eq!(polite.status().state, "paused");
    assert!(began.elapsed() < Duration::from_secs(3), "{:?}", began.elapsed());
    polite.order(&Request::Continue);
    binary.send(&Request::Watch.to_line());
    assert!(matches!(binary.next_line(), Some(Answer::Status(_))));
    let ended = running.end().with_code(0);
    assert_eq!(ended.digest(), whole);
    let mut last = None;
    while let Some(line) = binary.next_line() {
        last = Some(line);
    }
    assert!(
        matches!(&last, Some(Answer::Ended { code: 0, reason }) if reason == "max_cycles"),
        "{last:?}"
    );
}

fn attach(out: &Path, options: &[&str]) -> Ended {
    run(crumple_with(&[&["attach", out.to_str().unwrap()], options].concat()))
}

/// The command gives orders, shows a run until its end with its exit code, and says what is wrong.
#[test]
fn the_command_gives_orders_and_says_what_is_wrong() {
    let mut running = start_on("threads", 2, &[]);
    drop(Client::attach(&mut running));
    let out = running.out();
    let paused = attach(&out, &["--pause"]).with_code(0).said();
    assert!(paused.starts_with("pause: cycle "), "{paused}");
    let status = attach(&out, &["--status"]).with_code(0).said();
    assert!(status.contains("paused") && status.contains("worker 1:"), "{status}");
    let json = attach(&out, &["--status", "--json"]).with_code(0).said();
    assert_eq!(serde_json::from_str::<Value>(&json).unwrap()["answer"], "status");
    let refused = attach(&out, &["--set", "time.safety=0.5"]).with_code(2).said();
    assert!(refused.contains("parallel.low_every_at_least"), "{refused}");
    let refused = attach(&out, &["--set", "end_time=soon"]).with_code(2).said();
    assert!(refused.contains("number"), "{refused}");
    attach(&out, &["--pause", "--stop"]).with_code(2);
    let watch = {
        let watching = start(crumple_with(&["attach", out.to_str().unwrap()]));
        std::thread::sleep(Duration::from_millis(500));
        attach(&out, &["--continue"]).with_code(0);
        attach(&out, &["--stop"]).with_code(0);
        watching.end().with_code(130).said()
    };
    assert!(watch.contains("NC=") && watch.contains("order: stop"), "{watch}");
    running.end().with_code(130);
    let missing = attach(Path::new("no/such/folder"), &[]).with_code(2).said();
    assert!(missing.contains("no such folder"), "{missing}");
}

/// A killed run leaves its socket; the command says so, and the run that continues removes it.
#[test]
fn a_killed_run_leaves_no_socket_for_long() {
    let mut running = start_on("threads", 2, &["--set", "checkpoint.every=0.05 s"]);
    let out = running.out();
    running.wait_for("it has a checkpoint", |_| (!checkpoints(&out).is_empty()).then_some(()));
    send(running.id(), Signal::KILL);
    let killed = running.end();
    assert_eq!(killed.code, None);
    assert!(killed.out().join("run.sock").symlink_metadata().is_ok());
    let said = attach(&killed.out(), &[]).with_code(2).said();
    assert!(said.contains("--resume"), "{said}");
    let out = killed.out();
    run(crumple_with(&["run", "--resume", out.to_str().unwrap(), "--no-report"])).with_code(0);
    assert!(out.join("run.sock").symlink_metadata().is_err());
    let said = attach(&out, &[]).with_code(2).said();
    assert!(said.contains("no run is in progress"), "{said}");
}

/// A client that always asks for pictures changes no bit, no history and no file of results.
#[test]
fn pictures_change_nothing() {
    let plain = undisturbed();
    for transport in transports() {
        let mut running = start_on(transport, 2, &[]);
        let out = running.out();
        let mut client = Client::attach(&mut running);
        let mut cycles = Vec::new();
        // The last request meets the end of the run.
        while let Some(Answer::View(view)) = client.try_ask(&Request::View) {
            if cycles.last() != Some(&view.cycle) {
                assert_eq!((view.pieces, view.boxes.len()), (2, 2));
                assert!(out.join(&view.folder).join("piece_001.vtu").exists());
                cycles.push(view.cycle);
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        let ended = running.end().with_code(0);
        assert!(!cycles.is_empty() && cycles.is_sorted(), "{transport}: {cycles:?}");
        assert_eq!(ended.digest(), plain.digest(), "{transport}");
        assert_same_histories(&plain.out(), &out);
        assert!(!out.join("view").exists());
        assert!(ended.summary()["steering"].as_array().unwrap().is_empty());
    }
}
