//! Runs that are killed at random moments, again and again, and continue on random numbers of
//! workers and transports: the digest and the files are those of a run without interruption.
//!
//! `CRUMPLE_TORTURE_ROUNDS` sets the number of rounds, `CRUMPLE_TORTURE_SEED` the first seed;
//! `deploy/torture.sh` does so.

use crumple_tests::program::{crumple_with, mpi_or_skip, mpirun, run, send, start};
use crumple_tests::restart::assert_same_files;

use rustix::process::Signal;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Rounds of the suite.
const ROUNDS: u64 = 10;
/// Scenes and their numbers of cycles.
const SCENES: [(&str, u64); 6] = [
    ("tumble", 900),
    ("brick-wall", 60),
    ("pipe-whip", 60),
    ("tube-crush", 120),
    ("flight", 400),
    ("panel", 150),
];
/// Most kills in a round.
const KILLS: u32 = 3;
/// Longest time before a kill [ms].
const LONGEST: u64 = 1500;

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

#[test]
fn killed_runs_give_the_results_of_undisturbed_ones() {
    let seed = number("CRUMPLE_TORTURE_SEED", 1);
    let with_mpi = mpi_or_skip().is_some();
    let mut known: BTreeMap<&str, (String, PathBuf, tempfile::TempDir)> = BTreeMap::new();
    let mut kills = 0;
    for round in 0..number("CRUMPLE_TORTURE_ROUNDS", ROUNDS) {
        let mut random = fastrand::Rng::with_seed(seed + round);
        let (scene, cycles) = SCENES[random.usize(..SCENES.len())];
        let (digest, whole, _) = known.entry(scene).or_insert_with(|| {
            let folder = tempfile::tempdir().unwrap();
            let out = folder.path().join("out");
            let words = words(scene, cycles, &out, "off");
            let ended = run(command(&words, 1, false)).with_code(0);
            drop(ended);
            (digest_of(&out), out, folder)
        });
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let killed = one_round(&mut random, (scene, cycles), &out, with_mpi);
        println!("round {round}, seed {}: {scene}, {killed} kills", seed + round);
        kills += killed;
        assert_eq!(&digest_of(&out), digest, "seed {}: {scene}", seed + round);
        assert_same_files(whole, &out);
        assert_clean(&out);
    }
    println!("{kills} kills");
    assert!(kills > 0, "no run was killed before its end");
}

fn words(scene: &str, cycles: u64, out: &Path, every: &str) -> Vec<String> {
    let words = [
        "run".to_string(),
        format!("cases/{scene}"),
        "--no-report".into(),
        "--set".into(),
        format!("time.max_cycles={cycles}"),
        "--set".into(),
        format!("checkpoint.every=\"{every}\""),
        "--out".into(),
        out.to_string_lossy().into_owned(),
    ];
    words.into()
}

fn command(words: &[String], workers: usize, mpi: bool) -> Command {
    let mut words: Vec<&str> = words.iter().map(String::as_str).collect();
    if mpi {
        return mpirun(workers + 1, &words);
    }
    let number = workers.to_string();
    words.extend(["--workers", &number]);
    crumple_with(&words)
}

/// Runs a scene, kills it up to `KILLS` times, and lets it end. Returns the number of kills.
fn one_round(
    random: &mut fastrand::Rng,
    (scene, cycles): (&str, u64),
    out: &Path,
    with_mpi: bool,
) -> u32 {
    let mut killed = 0;
    for attempt in 0..=KILLS {
        let folder = out.to_string_lossy().into_owned();
        // Before the first checkpoint, a run starts again.
        let whole = crumple::run::checkpoint::find::newest_cycle(out).is_some();
        let words = if whole {
            ["run", "--resume", &folder, "--no-report"].map(String::from).to_vec()
        } else {
            words(scene, cycles, out, "0.03 s")
        };
        let (workers, mpi) = (random.usize(1..=4), with_mpi && random.bool());
        let running = start(command(&words, workers, mpi));
        if attempt == KILLS {
            running.end().with_code(0);
            return killed;
        }
        std::thread::sleep(Duration::from_millis(random.u64(100..LONGEST)));
        let ranks = if mpi { running.ranks() } else { Vec::new() };
        match ranks.get(random.usize(..=workers)) {
            Some(&rank) => send(rank, Signal::KILL),
            None => running.signal(Signal::KILL),
        }
        let ended = running.end();
        for &rank in &ranks {
            assert!(!is_running(rank), "rank {rank} is an orphan");
        }
        if ended.code == Some(0) {
            return killed;
        }
        killed += 1;
    }
    killed
}

/// Returns true if the process runs after a grace period, in which launchers end their ranks.
fn is_running(pid: u32) -> bool {
    let alive = || {
        let status = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        status.contains("(crumple)") && !status.contains(") Z")
    };
    (0..100).all(|_| {
        std::thread::sleep(Duration::from_millis(50));
        alive()
    })
}

fn digest_of(out: &Path) -> String {
    let text = fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(summary["status"], "completed");
    summary["state_digest"].as_str().unwrap().to_owned()
}

/// No temporary file, no lock and no incomplete checkpoint is left.
fn assert_clean(folder: &Path) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(!name.ends_with(".tmp") && name != "run.lock", "{}", path.display());
        if name.starts_with("cycle_") {
            assert!(path.join("MANIFEST").exists(), "{}", path.display());
        }
        if path.is_dir() {
            assert_clean(&path);
        }
    }
}
