//! Runs that fail or are stopped, through the binary: exit codes, and the files that remain.

use crumple::run::control::Guidance;
use crumple::run::service::signals::StopFlag;
use crumple_proto::transport::threads::{Threads, connect};
use crumple_proto::transport::{RankLost, Tag, Traffic, Transport};
use crumple_tests::program::{Ended, assert_finite, crumple_with, run, start};
use crumple_tests::{case, read};
use rustix::process::Signal;
use std::fs;
use std::sync::mpsc::channel;
use std::time::Duration;

/// Above the stability limit energy grows from step to step: the run must end, with complete
/// results until then.
#[test]
fn an_unstable_run_names_its_element_and_keeps_the_last_good_state() {
    let unstable = ["run", "cases/jeep-frame", "--workers", "2", "--set", "time.safety=2.5"];
    let failed = run(crumple_with(&unstable)).with_code(3);
    let s = failed.summary();
    let reason = s["reason"].as_str().unwrap().to_owned();
    assert_eq!(s["status"], "failed");
    for text in ["element ", "time ", "cycle ", "time.safety = 2.5 is above the stability limit"] {
        assert!(
            reason.contains(text) && failed.said().contains(&reason),
            "missing text: {text}: {reason}"
        );
    }
    kept(&failed);
    // No worker decides alone, so the last good state does not depend on the workers either.
    let alone = run(crumple_with(&[
        "run",
        "cases/jeep-frame",
        "--workers",
        "1",
        "--set",
        "time.safety=2.5",
    ]));
    assert_eq!((alone.digest(), &alone.summary()["reason"]), (failed.digest(), &s["reason"]));
}

/// Just above the limit plasticity bounds the motion; oscillations from step to step, or the
/// energy balance, still show the instability. The order to stop reaches workers at a cycle
/// that varies, so the digest is not compared.
#[test]
fn a_run_that_gains_energy_ends_and_names_its_element() {
    let failed = run(crumple_with(&[
        "run",
        "cases/jeep-frame",
        "--workers",
        "2",
        "--set",
        "time.safety=1.5",
    ]))
    .with_code(3);
    let reason = failed.summary()["reason"].as_str().unwrap().to_owned();
    for text in ["energy", "element ", "time ", "time.safety is 1.5, use 0.9 or less"] {
        assert!(
            reason.contains(text) && failed.said().contains(&reason),
            "missing text: {text}: {reason}"
        );
    }
    kept(&failed);
}

/// Ctrl-C: all workers end the same cycle and write their state. A run with this number of
/// cycles gives the same bits.
#[test]
fn an_interrupted_run_keeps_the_state_of_its_last_cycle() {
    let job =
        ["run", "cases/jeep-frame", "--workers", "3", "--set", "output.history_interval=0.05"];
    for signal in [Signal::INT, Signal::TERM] {
        let mut running = start(crumple_with(&job));
        running.wait_for_rows(3);
        running.signal(signal);
        let stopped = running.end().with_code(130);
        let s = stopped.summary();
        assert_eq!(
            (&s["status"], &s["reason"]),
            (&"stopped".into(), &"stopped by the user".into())
        );
        kept(&stopped);
        let cycles = format!("time.max_cycles={}", s["cycles"]);
        let counted = run(crumple_with(&[&job[..], &["--set", &cycles]].concat())).with_code(0);
        assert_eq!(counted.digest(), stopped.digest(), "{cycles}");
        assert_eq!(counted.summary()["end_time"], s["end_time"]);
    }
}

#[test]
fn a_limit_of_cycles_is_a_regular_end() {
    let ended =
        run(crumple_with(&["run", "cases/tumble", "--set", "time.max_cycles=37"])).with_code(0);
    let s = ended.summary();
    assert_eq!(
        (&s["status"], &s["reason"], &s["cycles"]),
        (&"completed".into(), &"max_cycles".into(), &37.into())
    );
    kept(&ended);
}

/// Checks that summary, history and fields are complete and finite.
fn kept(r: &Ended) {
    assert_finite(&r.summary(), "summary");
    let h = r.history();
    let controlling = h.header.iter().position(|c| c == "controlling element");
    for row in &h.rows {
        let bad = row.iter().enumerate().find(|(i, a)| !a.is_finite() && Some(*i) != controlling);
        assert_eq!(bad, None, "{:?} in {row:?}", bad.map(|b| &h.header[b.0]));
    }
    let time = h.column("time");
    let end = r.summary()["end_time"].as_f64().unwrap();
    assert!(
        (time.last().unwrap() - end).abs() <= 1e-8 * end,
        "the last row is at the end: {time:?}, {end}"
    );
    assert!(r.read_fields() >= 2, "fields at the start and at the end");
}

/// A small valid job, into which tests put errors.
const PLATE: &str = r#"
end_time = 0.1
[mesh]
nodes = [[1, 0.0, 0.0, 0.0], [2, 9.0, 0.0, 0.0], [3, 9.0, 9.0, 0.0], [4, 0.0, 9.0, 0.0],
  [5, 18.0, 0.0, 0.0], [6, 18.0, 9.0, 0.0]]
shells = [[1, 1, 1, 2, 3, 4], [2, 1, 2, 5, 6, 3]]
[[material]]
name = "steel"
law = "elastic"
density = 7.85e-6
youngs_modulus = 207.0
poisson = 0.3
[[part]]
id = 1
name = "plate"
material = "steel"
thickness = 1.0
"#;

/// Runs the plate with `from` replaced by `to`.
fn spoilt(from: &str, to: &str, more: &[&str]) -> Ended {
    let there = tempfile::tempdir().unwrap();
    let job = there.path().join("plate.toml");
    assert!(PLATE.contains(from), "{from}");
    fs::write(&job, PLATE.replacen(from, to, 1)).unwrap();
    run(crumple_with(&[&["run", job.to_str().unwrap()], more].concat()))
}

/// The unchanged plate is valid, so that the following tests fail for the given reason.
#[test]
fn the_job_that_is_spoilt_below_is_good() {
    spoilt("steel", "steel", &["--workers", "2"]).with_code(0);
}

/// Bad input: code 2, before anything runs, with the error named and a remedy; never a panic.
#[test]
fn bad_input_is_refused_with_code_2_and_says_what_to_do() {
    let cases: &[(&str, &str, &[&str], &[&str])] = &[
        (
            "thickness = 1.0",
            "thicknes = 1.0",
            &[],
            &["unknown key `thicknes`", "did you mean `thickness`", "plate.toml:"],
        ),
        ("thickness = 1.0", "thickness = -1.0", &[], &["thickness is -1", "plate.toml:"]),
        ("density = 7.85e-6", "density = 0.0", &[], &["density", "plate.toml:"]),
        ("[2, 9.0, 0.0, 0.0]", "[1, 9.0, 0.0, 0.0]", &[], &["node 1", "plate.toml:"]),
        ("[2, 1, 2, 5, 6, 3]", "[1, 1, 2, 5, 6, 3]", &[], &["1", "plate.toml:"]),
        ("[5, 18.0, 0.0, 0.0]", "[5, nan, 0.0, 0.0]", &[], &["nan", "plate.toml:"]),
        ("[5, 18.0, 0.0, 0.0]", "[5, 9.0, 0.0, 0.0]", &[], &["element 2"]),
        ("end_time = 0.1", "end_time = 0.1", &["--set", "end_time=nan"], &["end_time", "nan"]),
        ("end_time = 0.1", "end_time = -0.1", &[], &["end_time", "plate.toml:"]),
        ("end_time = 0.1", "end_time = 0.1", &["--workers", "0"], &["0 workers cannot run a job"]),
        ("end_time = 0.1", "end_time = 0.1", &["--workers", "3"], &["workers", "2"]),
    ];
    for (from, to, more, said) in cases {
        let refused = spoilt(from, to, more).with_code(2);
        let words = refused.said();
        for text in *said {
            assert!(words.contains(text), "{to} {more:?}: missing text: {text}\n{words}");
        }
        assert!(!words.contains("panicked"), "{words}");
        assert!(!refused.out().join("summary.json").exists(), "nothing was run");
    }
}

#[test]
fn a_job_that_is_not_there_is_bad_input() {
    for verb in ["run", "check"] {
        let refused = run(crumple_with(&[verb, "nowhere/job.toml"])).with_code(2).said();
        assert!(refused.contains("nowhere/job.toml") && !refused.contains("panicked"), "{refused}");
    }
}

/// A folder that cannot be written is detected before the run and named; the code is that of bad
/// input.
#[test]
fn an_output_folder_that_cannot_be_written_is_named() {
    let there = tempfile::tempdir().unwrap();
    let file = there.path().join("file");
    fs::write(&file, "").unwrap();
    let with = |in_the_way: &'static str| {
        let out = there.path().join("with").join(in_the_way);
        fs::create_dir_all(out.join(in_the_way)).unwrap();
        (out, [in_the_way, "choose another folder with --out"])
    };
    let is_file = ["file is a file", "name a folder with --out"];
    let files = [(file.join("below"), is_file), (file, is_file)];
    for (out, named) in files.into_iter().chain(["history.csv", "summary.json"].map(with)) {
        let out = out.to_str().unwrap();
        let refused =
            run(crumple_with(&["run", "cases/tumble", "--end-time", "0.1", "--out", out]))
                .with_code(2)
                .said();
        for text in named {
            assert!(
                refused.contains(text) && !refused.contains("panicked"),
                "missing text: {text}: {refused}"
            );
        }
    }
}

/// A connection that panics after a number of received messages: its worker is lost in the
/// middle of a step.
struct Frail(Threads, u32);

impl Transport for Frail {
    fn rank(&self) -> usize {
        self.0.rank()
    }
    fn size(&self) -> usize {
        self.0.size()
    }
    fn send(&mut self, to: usize, tag: Tag, words: &[u64]) -> Result<(), RankLost> {
        self.0.send(to, tag, words)
    }
    fn try_recv(&mut self, from: usize, tag: Tag, words: &mut Vec<u64>) -> Result<bool, RankLost> {
        self.0.try_recv(from, tag, words)
    }
    fn recv(&mut self, from: usize, tag: Tag, words: &mut Vec<u64>) -> Result<(), RankLost> {
        assert!(self.1 > 0, "deliberate panic of a test");
        self.1 -= 1;
        self.0.recv(from, tag, words)
    }
    fn wait_cpu(&self) -> Duration {
        self.0.wait_cpu()
    }
    fn traffic(&self) -> Traffic {
        self.0.traffic()
    }
    fn one_clock(&self) -> bool {
        self.0.one_clock()
    }
    fn name(&self) -> &'static str {
        self.0.name()
    }
}

/// A worker that panics closes its connections. The master and the other workers detect this and
/// end; none of them waits for it. The binary turns this error into code 4.
#[test]
fn a_worker_that_panics_is_a_lost_worker() {
    for messages in [0, 1, 40, 2000] {
        let mut ends = connect(4);
        let mut master = ends.remove(0);
        let (say, hear) = channel();
        for end in ends {
            let say = say.clone();
            std::thread::spawn(move || {
                let left = if end.rank() == 2 { messages } else { u32::MAX };
                let ended = crumple_worker::serve::serve(&mut Frail(end, left));
                say.send(ended.map_err(|lost| lost.to_string())).unwrap();
            });
        }
        std::thread::spawn(move || {
            let mut model = read(&case("tumble"), &["output.field_interval=-1"]);
            let out = tempfile::tempdir().unwrap();
            let trace = out.path().join("trace.json");
            let results = crumple::run::control::Results { out: out.path(), trace: Some(&trace) };
            let ended = crumple::run::control::run(
                &mut model,
                &mut master,
                results,
                crumple::run::control::Origin::default(),
                Guidance::quiet(&StopFlag::default()),
            );
            let text = fs::read_to_string(&trace).unwrap();
            serde_json::from_str::<serde_json::Value>(&text).expect("the trace is valid JSON");
            say.send(ended.map(|_| ()).map_err(|error| error.to_string())).unwrap();
        });
        // Two workers and the master end with an error; the third worker does not return.
        let mut errors: Vec<String> = (0..3)
            .map(|_| {
                hear.recv_timeout(Duration::from_secs(60)).expect("all ranks end").unwrap_err()
            })
            .collect();
        errors.sort();
        assert!(
            errors[0].starts_with("a worker was lost: rank"),
            "after {messages} messages: {errors:?}"
        );
        assert!(errors[1].contains("was lost") && errors[2].contains("was lost"), "{errors:?}");
    }
}
