//! Ranks as MPI processes: the same bits as with threads, and no end that hangs.

use crumple_tests::program::{Running, crumple_with, mpi_or_skip, mpirun, run, send, start};
use rustix::process::Signal;
use std::fs;
use std::time::{Duration, Instant};

const JEEP: [&str; 6] =
    ["run", "cases/jeep-frame", "--end-time", "2", "--set", "output.field_interval=-1"];
const TUMBLE: [&str; 4] = ["run", "cases/tumble", "--set", "output.field_interval=-1"];
/// A run that is stopped long before its end time.
const LONG: [&str; 5] =
    ["run", "cases/jeep-frame", "--quiet", "--set", "output.history_interval=0.05"];

/// Starts a long run. Open MPI waits 1 s before each of SIGTERM and SIGKILL; on a busy machine a
/// state may take longer to write.
fn long_run(ranks: usize) -> Running {
    let mut command = mpirun(ranks, &LONG);
    command.env("OMPI_MCA_odls_base_sigkill_timeout", "3");
    let mut running = start(command);
    running.wait_for_rows(3);
    running
}

/// No code above the transport can distinguish threads from processes, so the bits are the same.
#[test]
fn processes_give_the_bits_that_threads_give() {
    let Some(()) = mpi_or_skip() else { return };
    let tumble = [&TUMBLE[..], &["--set=time.max_cycles=800"]].concat();
    let with_rcb = [&tumble[..], &["--set=parallel.contact=\"rcb\""]].concat();
    for job in [&JEEP[..], &tumble, &with_rcb] {
        let threads = run(crumple_with(&[job, &["--workers", "2"]].concat())).with_code(0);
        for ranks in [3, 5] {
            let processes = run(mpirun(ranks, job)).with_code(0);
            let s = processes.summary();
            assert_eq!((&s["transport"], &s["workers"]), (&"mpi".into(), &(ranks - 1).into()));
            assert_eq!(threads.digest(), processes.digest(), "{job:?} on {ranks} ranks");
        }
    }
}

/// mpirun with one rank has no separate worker: the binary runs as it does alone.
#[test]
fn a_single_rank_runs_its_workers_as_threads() {
    let Some(()) = mpi_or_skip() else { return };
    let s = run(mpirun(1, &["run", "cases/tumble", "--end-time", "0.1", "--workers", "2"]))
        .with_code(0)
        .summary();
    assert_eq!((&s["transport"], &s["workers"]), (&"threads".into(), &2.into()));
}

/// The workers wait for their first order when the master rejects the job: they are ordered to
/// end.
#[test]
fn a_bad_job_ends_all_ranks_with_code_2() {
    let Some(()) = mpi_or_skip() else { return };
    for ranks in [1, 3] {
        let ended =
            run(mpirun(ranks, &["run", "cases/tumble", "--set", "time.safty=0.8"])).with_code(2);
        let said = ended.said();
        assert!(said.contains("did you mean `safety`"), "{said}");
        assert_eq!(said.matches("unknown key").count(), 1, "printed once, by the master: {said}");
        assert!(ended.took < Duration::from_secs(30), "took {:?}", ended.took);
    }
}

/// The disk of a history is full: the master ends, and so do the workers.
#[test]
fn a_history_that_cannot_be_written_ends_all_ranks_with_code_2() {
    let Some(()) = mpi_or_skip() else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    std::os::unix::fs::symlink("/dev/full", out.join("history.csv")).unwrap();
    let words = [&TUMBLE[..], &["--no-report", "--out", out.to_str().unwrap()]].concat();
    let ended = run(mpirun(3, &words)).with_code(2);
    assert!(ended.said().contains("No space left on device"), "{}", ended.said());
}

/// A change that the workers refuse: all ranks end in order, and the run continues without it.
#[test]
fn a_change_that_workers_refuse_ends_all_ranks_with_code_2() {
    let Some(()) = mpi_or_skip() else { return };
    let few = [&TUMBLE[..], &["--set=time.max_cycles=300", "--set=checkpoint.at=[0.4]"]].concat();
    let whole = run(mpirun(3, &few)).with_code(0);
    let out = whole.out();
    let digest = whole.digest();
    let resume = ["run", "--resume", out.to_str().unwrap(), "--no-report"];
    let wall = "--set=restart.wall=[{point=[0.0, 0.0, 20.0], normal=[0.0, 0.0, 1.0]}]";
    let refused = run(mpirun(4, &[&resume[..], &[wall]].concat())).with_code(2);
    assert!(refused.said().contains("nothing in the folder was changed"), "{}", refused.said());
    run(mpirun(4, &resume)).with_code(0);
    let summary = fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(summary.contains(&digest), "{summary}");
}

/// MPI cannot report to ranks that one of them is lost, but mpirun can, and ends them: 128 + 9
/// is its code for SIGKILL.
#[test]
fn a_worker_that_is_killed_ends_the_job() {
    let Some(()) = mpi_or_skip() else { return };
    for victim in [2, 0] {
        let running = long_run(4);
        let ranks = running.ranks();
        assert_eq!(ranks.len(), 4);
        send(ranks[victim], Signal::KILL);
        running.end().with_code(137);
        // Ended ranks whose exit code is not collected yet have no command line.
        let alive =
            |pid: &u32| fs::read(format!("/proc/{pid}/cmdline")).is_ok_and(|line| !line.is_empty());
        let deadline = Instant::now() + Duration::from_secs(10);
        while ranks.iter().any(alive) {
            assert!(
                Instant::now() < deadline,
                "rank {victim} was killed, but other ranks still run"
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

/// A signal to the master ends the run in order. The state is that of a run with this number of
/// cycles.
#[test]
fn an_interrupted_master_stops_all_ranks_with_code_130() {
    let Some(()) = mpi_or_skip() else { return };
    let running = long_run(3);
    send(running.ranks()[0], Signal::INT);
    let stopped = running.end().with_code(130);
    let s = stopped.summary();
    assert_eq!((&s["status"], &s["reason"]), (&"stopped".into(), &"stopped by the user".into()));
    assert!(stopped.read_fields() >= 1);
    let cycles = format!("time.max_cycles={}", s["cycles"]);
    let counted = run(crumple_with(&[&LONG[..], &["--workers", "3", "--set", &cycles]].concat()))
        .with_code(0);
    assert_eq!(stopped.digest(), counted.digest());
}

/// Ctrl-C reaches mpirun, which terminates the ranks after odls_base_sigkill_timeout and kills
/// them after the same time again: this is enough to write their state. The code is Open MPI's
/// own, 1, for any exit code of the ranks.
#[test]
fn an_interrupted_mpirun_leaves_a_whole_state() {
    let Some(()) = mpi_or_skip() else { return };
    let running = long_run(3);
    running.signal(Signal::INT);
    let stopped = running.end();
    assert!(matches!(stopped.code, Some(1 | 130)), "{:?}: {}", stopped.code, stopped.said());
    assert_eq!(stopped.summary()["status"], "stopped");
    assert!(stopped.read_fields() >= 1);
}

/// A worker ignores signals that a launcher sends to all ranks: the master decides.
#[test]
fn a_signal_to_a_worker_alone_does_not_stop_it() {
    let Some(()) = mpi_or_skip() else { return };
    let mut running =
        start(mpirun(3, &["run", "cases/tumble", "--set", "output.field_interval=-1"]));
    running.wait_for_rows(2);
    send(running.ranks()[1], Signal::TERM);
    assert_eq!(running.end().with_code(0).summary()["status"], "completed");
}
