//! Logs of ranks by `--log` and `RUST_LOG`, on threads and under MPI.

use crumple_tests::program::{Ended, crumple_with, mpi_or_skip, mpirun, run};
use std::fs;
use std::process::Command;

const WORKERS: usize = 2;
const TUMBLE: [&str; 9] = [
    "run",
    "cases/tumble",
    "--quiet",
    "--no-report",
    "--set=time.max_cycles=60",
    "--set=output.field_interval=-1",
    "--set=checkpoint.every=off",
    "--set=parallel.imbalance=100",
    "--set=parallel.force_every=20",
];

/// Returns the command on each transport that is there.
fn commands(more: &[&str]) -> Vec<Command> {
    let args = [&TUMBLE[..], more].concat();
    let workers = WORKERS.to_string();
    let threads = crumple_with(&[&args[..], &["--workers", &workers]].concat());
    let mut all = vec![threads];
    all.extend(mpi_or_skip().map(|()| mpirun(WORKERS + 1, &args)));
    for command in &mut all {
        command.env_remove("RUST_LOG");
    }
    all
}

/// Returns the logs of all ranks.
fn logs(ended: &Ended) -> Vec<String> {
    let folder = ended.out().join("logs");
    let mut names: Vec<_> = fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    let expected: Vec<_> = (0..=WORKERS).map(|r| folder.join(format!("rank_{r:04}.log"))).collect();
    assert_eq!(names, expected);
    names.iter().map(|path| fs::read_to_string(path).unwrap()).collect()
}

/// Each level adds lines, and no level changes a bit.
#[test]
fn each_rank_writes_what_the_level_asks_for() {
    let silent = commands(&[]).into_iter().map(|c| run(c).with_code(0)).collect::<Vec<_>>();
    assert!(silent.iter().all(|ended| !ended.out().join("logs").exists()));
    let digest = silent[0].digest();
    for level in ["info", "debug", "trace"] {
        for command in commands(&["--log", level]) {
            let ended = run(command).with_code(0);
            assert_eq!(ended.digest(), digest);
            for (rank, log) in logs(&ended).iter().enumerate() {
                let has = |text: &str| log.contains(text);
                assert!(has(&format!("run{{rank={rank}}}")), "{log}");
                let (debug, trace) = (level != "info", level == "trace");
                assert_eq!(has("redecomposition{kind="), debug, "{level}, {rank}: {log}");
                assert_eq!(has("report{"), trace, "{level}, {rank}");
                if rank == 0 {
                    assert_eq!(has("order sent"), debug);
                } else {
                    assert!(has("worker starts"));
                    assert_eq!(has("members renewed"), debug);
                    assert_eq!(has("order arrives"), debug);
                    assert_eq!(has("step{cycle=59}") && has("phase=\"elements\""), trace);
                }
            }
            // Events of the master, without those of a finer level.
            assert!(ended.log().iter().all(|e| e["level"] != "DEBUG" && e["level"] != "TRACE"));
        }
    }
}

#[test]
fn the_variable_counts_without_the_option_and_a_wrong_level_is_refused() {
    for mut command in commands(&[]) {
        command.env("RUST_LOG", "warn,crumple_worker=debug");
        let all = logs_or_fewer(&run(command).with_code(0));
        assert!(all.iter().any(|log| log.contains("members renewed")), "{all:?}");
        assert!(all.iter().all(|log| !log.contains("order sent")), "{all:?}");
    }
    for mut command in commands(&["--log", "info"]) {
        command.env("RUST_LOG", "trace");
        assert!(logs(&run(command).with_code(0)).iter().all(|log| !log.contains("DEBUG")));
    }
    let refused = run(crumple_with(&[&TUMBLE[..], &["--log", "loud"]].concat())).with_code(2);
    assert!(refused.said().contains("debug or trace"), "{}", refused.said());
}

/// Returns the logs that exist: a rank without lines has none.
fn logs_or_fewer(ended: &Ended) -> Vec<String> {
    let files = fs::read_dir(ended.out().join("logs")).unwrap();
    files.map(|e| fs::read_to_string(e.unwrap().path()).unwrap()).collect()
}
