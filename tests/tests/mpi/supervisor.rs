//! `crumple run --retries`: lost ranks, hosts that are gone, and runs that are given up.

use crumple::run::checkpoint::find::newest_cycle;
use crumple::run::checkpoint::manifest::Manifest;
use crumple_tests::program::{
    Running, crumple, crumple_with, mpi_or_skip, mpirun, root, run, send, start,
};
use crumple_tests::restart::{assert_same_files, checkpoints};
use rustix::process::{Pid, Signal, kill_process_group};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

const TUMBLE: [&str; 6] = [
    "run",
    "cases/tumble",
    "--no-report",
    "--set",
    "time.max_cycles=600",
    "--set=checkpoint.every=\"0.05 s\"",
];

/// Writes an executable script.
fn script(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("launch.sh");
    fs::write(&path, format!("#!/bin/sh\n{text}\n")).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    path
}

/// Sets the environment that `mpirun` needs.
fn set_environment_of_mpirun(command: &mut Command) {
    for (name, value) in mpirun(1, &[]).get_envs() {
        command.env(name, value.unwrap_or_default());
    }
}

/// Returns a supervised run.
fn supervised(launcher: &str, more: &[&str]) -> Command {
    let mut command = crumple_with(&TUMBLE);
    set_environment_of_mpirun(&mut command);
    command.args(["--retries", "5", "--launcher", launcher]).args(more);
    command
}

/// Waits for a checkpoint, so that a loss is one of a run that makes progress.
fn wait_for_checkpoint(running: &mut Running) {
    let out = running.out();
    running.wait_for("there is a checkpoint", |_| newest_cycle(&out));
}

/// Returns the children of a process.
fn children_of(pid: u32) -> Vec<u32> {
    let children = format!("/proc/{pid}/task/{pid}/children");
    let children = fs::read_to_string(children).unwrap_or_default();
    children.split_whitespace().filter_map(|p| p.parse().ok()).collect()
}

/// Returns the ranks of all processes below this one.
fn ranks_below(pid: u32) -> Vec<u32> {
    let children = children_of(pid);
    let is_rank = |pid: &u32| {
        let environment = fs::read_to_string(format!("/proc/{pid}/environ")).unwrap_or_default();
        let name = fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
        name.trim() == "crumple" && environment.contains("OMPI_COMM_WORLD_RANK=")
    };
    let below = children.iter().flat_map(|&child| ranks_below(child));
    children.iter().copied().filter(is_rank).chain(below).collect()
}

/// A rank is killed; the supervisor starts mpirun again, and the results are those of a run without
/// a loss.
#[test]
fn a_run_whose_rank_was_killed_continues() {
    let Some(()) = mpi_or_skip() else { return };
    let whole = run(crumple_with(&[&TUMBLE[..5], &["--workers", "1"]].concat())).with_code(0);
    let mut running = start(supervised("mpirun -n 3", &[]));
    wait_for_checkpoint(&mut running);
    let supervisor = running.id();
    let ranks = running.wait_for("three ranks run", |_| {
        Some(ranks_below(supervisor)).filter(|ranks| ranks.len() == 3)
    });
    send(ranks[1], Signal::KILL);
    let ended = running.end().with_code(0);
    assert!(ended.said().contains("the run was lost"), "{}", ended.said());
    assert_eq!(ended.digest(), whole.digest());
    assert_same_files(&whole.out(), &ended.out());
}

/// A launcher that cannot start so many ranks any more, as when a host is gone: after two losses
/// without progress half of the workers run.
#[test]
fn a_run_continues_on_fewer_ranks_when_a_host_is_gone() {
    let Some(()) = mpi_or_skip() else { return };
    let folder = tempfile::tempdir().unwrap();
    let text = "[ \"$1\" -gt 3 ] && exit 213\nn=$1; shift\nexec mpirun -n $n \"$@\"";
    let launcher = script(folder.path(), text);
    let launcher = format!("{} {{ranks}}", launcher.display());
    let ended = run(supervised(&launcher, &["--workers", "5"])).with_code(0);
    assert_eq!(ended.summary()["workers"], 2, "{}", ended.said());
    assert!(ended.said().contains("with 2 workers"), "{}", ended.said());
    assert!(ended.said().contains("exit code 213"), "{}", ended.said());
}

/// A requirement that is not met is a result: under a launcher too the run is not repeated.
#[test]
fn a_run_that_misses_a_requirement_is_not_a_loss() {
    let Some(()) = mpi_or_skip() else { return };
    let require = "require=[{name=\"few cycles\", quantity={summary=\"cycles\"}, below=1}]";
    let ended = run(supervised("mpirun -n 3", &["--set", require])).with_code(1);
    assert!(ended.said().contains("FAIL  few cycles"), "{}", ended.said());
    assert!(!ended.said().contains("was lost"), "{}", ended.said());
}

/// No progress between two losses, and no fewer workers to try: exit code 4, long before the last
/// retry.
#[test]
fn a_run_that_makes_no_progress_is_given_up() {
    let ended = run(supervised("false", &[])).with_code(4);
    assert!(ended.said().contains("without a new checkpoint"), "{}", ended.said());
    assert_eq!(ended.said().matches("was lost").count(), 2, "{}", ended.said());
}

/// A launcher that hangs gets USR2 at the first request to stop, TERM at the second and KILL at the
/// third. Before the run has begun, it gets TERM at once.
#[test]
fn a_launcher_that_does_not_stop_is_ended_by_further_signals() {
    let folder = tempfile::tempdir().unwrap();
    let up = folder.path().join("up");
    for (traps, begins, requests, code) in [
        ("trap '' USR2; trap 'exit 9' TERM", true, 2, 4),
        ("trap '' USR2 TERM", true, 3, 4),
        ("trap '' USR2; trap 'exit 9' TERM", false, 1, 130),
    ] {
        let log = if begins { "out/log.jsonl" } else { "other" };
        let text = format!(
            "{traps}; mkdir -p {0}/out; touch {0}/{log} {0}/up; while :; do sleep 0.1; done",
            folder.path().display()
        );
        let launcher = script(folder.path(), &text);
        let out = folder.path().join("out");
        let place = ["--out", out.to_str().unwrap()];
        let mut running = start(supervised(launcher.to_str().unwrap(), &place));
        running.wait_for("the launcher runs", |_| up.exists().then_some(()));
        for request in 1..=requests {
            running.signal(Signal::INT);
            // Requests within a second count as one.
            std::thread::sleep(Duration::from_millis(1300));
            let launchers = running.children();
            assert_eq!(launchers.is_empty(), request == requests, "{traps}: {request}");
        }
        running.end().with_code(code);
        fs::remove_file(&up).unwrap();
        fs::remove_dir_all(&out).unwrap();
    }
}

/// From a single checkpoint: later runs continue from the newest checkpoint of the run's folder.
#[test]
fn a_supervised_run_from_one_checkpoint_continues_from_newer_ones() {
    let words = [&TUMBLE[..5], &["--set=checkpoint.at=[0.2, 0.3]", "--workers=1"]].concat();
    let whole = run(crumple_with(&words)).with_code(0);
    let out = whole.out();
    let digest = whole.digest();
    let first = out.join("checkpoints").join(&checkpoints(&out)[0]);
    let from = newest_cycle(&out).unwrap();
    let words = ["run", "--resume", first.to_str().unwrap(), "--retries=3", "--no-report"];
    let more = ["--workers=2", "--set=checkpoint.every=\"0.05 s\"", "--set=checkpoint.at=[]"];
    let mut running = start(crumple_with(&[&words[..], &more].concat()));
    running.wait_for("there is a newer checkpoint", |_| {
        newest_cycle(&out).filter(|&cycle| cycle > from)
    });
    send(running.children()[0], Signal::KILL);
    let ended = running.end().with_code(0);
    let said = ended.said();
    let continued: Vec<&str> = said.lines().filter(|l| l.contains("continues from T=")).collect();
    assert_eq!(continued.len(), 2, "{said}");
    assert!(continued[0].contains(first.to_str().unwrap()), "{said}");
    assert!(!continued[1].contains(first.to_str().unwrap()), "{said}");
    assert_eq!(whole.digest(), digest);
}

/// Reads `summary.json` of a folder.
fn summary_in(out: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(out.join("summary.json")).unwrap()).unwrap()
}

/// A launcher that ends at once without a run, the first time.
fn fails_once(folder: &Path) -> PathBuf {
    let mark = folder.join("failed").display().to_string();
    script(folder, &format!("[ -e {mark} ] || {{ touch {mark}; exit 9; }}\nexec \"$@\""))
}

/// The folder has the checkpoint of another run that is complete. The new run is lost before it
/// begins: it starts again from time 0, not from that checkpoint.
#[test]
fn a_lost_new_run_does_not_continue_the_run_before() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let place = ["--out", out.to_str().unwrap(), "--workers=1", "--set=checkpoint.every=\"off\""];
    let other = [&TUMBLE[..2], &place, &["--set=time.max_cycles=300", "--set=time.damping=5.0"]];
    let kept = "--set=checkpoint.at=[0.3]";
    run(crumple_with(&[&other.concat()[..], &[kept, "--no-report"]].concat())).with_code(0);
    assert_eq!(checkpoints(&out).len(), 1);
    let job = [&TUMBLE[..2], &["--no-report", "--set=time.max_cycles=300"]].concat();
    let whole = run(crumple_with(&[&job[..], &["--workers=1"]].concat())).with_code(0);
    let launcher = fails_once(folder.path());
    let words = ["--overwrite", "--retries=2", "--launcher", launcher.to_str().unwrap()];
    let ended = run(crumple_with(&[&job[..], &place, &words].concat())).with_code(0);
    assert!(ended.said().contains("from the start"), "{}", ended.said());
    let summary = summary_in(&out);
    assert_eq!(summary["state_digest"], whole.summary()["state_digest"]);
    let restarts = &summary["restarts"];
    assert_eq!(restarts.as_array().map_or(0, Vec::len), 0, "{restarts}");
}

/// A run from an older checkpoint, with a change, is lost before it has removed the newer one: it
/// starts again from the older one, and with the change.
#[test]
fn a_lost_run_starts_again_from_its_own_checkpoint_and_with_its_changes() {
    let words = [&TUMBLE[..2], &["--no-report", "--workers=1", "--set=time.max_cycles=500"]];
    let at = "--set=checkpoint.at=[0.2, 0.4]";
    let begun = run(crumple_with(&[&words.concat()[..], &[at]].concat())).with_code(0);
    let out = begun.out();
    let older = out.join("checkpoints").join(&checkpoints(&out)[0]);
    let cycle = Manifest::read(&older).unwrap().captured.cycle;
    let folder = tempfile::tempdir().unwrap();
    let launcher = fails_once(folder.path());
    let resume = ["run", "--resume", older.to_str().unwrap(), "--no-report", "--workers=1"];
    let more = ["--set=time.damping=2.0", "--retries=2", "--launcher", launcher.to_str().unwrap()];
    run(crumple_with(&[&resume[..], &more].concat())).with_code(0);
    let summary = summary_in(&out);
    let restart = &summary["restarts"][0];
    assert_eq!(restart["cycle"], cycle, "{restart}");
    assert!(restart["changes"].to_string().contains("time.damping"), "{restart}");
}

/// Returns `deploy/run.sh` on a job that takes long, with the binary of the tests. A shell cannot
/// trap a signal that it ignores from its start, like SIGINT in processes in the background.
fn run_script(out: &Path) -> Command {
    let mut command = Command::new("env");
    command.args(["--default-signal=INT", "deploy/run.sh"]);
    command.args(["cases/jeep-frame", "--quiet", "--no-report", "--out"]).arg(out);
    command.env("CRUMPLE", crumple()).env("WORKERS", "3");
    command
}

/// Interrupts `deploy/run.sh` and checks that it ends in order, and that the run continues.
fn assert_stops(interrupt: impl Fn(&Running)) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut running = start(run_script(&out));
    running.wait_for("the history has rows", |_| {
        let text = fs::read_to_string(out.join("history.csv")).ok()?;
        (text.lines().count() > 3).then_some(())
    });
    interrupt(&running);
    let ended = running.end().with_code(130);
    let summary = summary_in(&out);
    assert_eq!(summary["status"], "stopped", "{}", ended.said());
    let cycle = summary["cycles"].as_u64();
    assert_eq!(newest_cycle(&out), cycle, "{}", ended.said());
    assert!(!out.join("run.lock").exists());
    let end = format!("time.max_cycles={}", cycle.unwrap() + 50);
    let words = ["run", "--resume", out.to_str().unwrap(), "--no-report", "--workers=2", "--set"];
    let again = run(crumple_with(&[&words[..], &[&end]].concat())).with_code(0);
    assert!(again.said().contains("continues from"), "{}", again.said());
}

/// A signal to the script alone, as from `kill`.
#[test]
fn an_interrupted_script_stops_the_run_with_code_130() {
    let Some(()) = mpi_or_skip() else { return };
    assert_stops(|script| script.signal(Signal::INT));
    assert_stops(|script| script.signal(Signal::TERM));
}

/// Ctrl-C in a terminal: the script and the supervisor get the signal together.
#[test]
fn ctrl_c_in_a_terminal_stops_the_run_with_code_130() {
    let Some(()) = mpi_or_skip() else { return };
    assert_stops(|script| {
        let group = Pid::from_raw(script.id() as i32).unwrap();
        kill_process_group(group, Signal::INT).unwrap();
    });
}

/// A signal to `mpirun` alone: it ends its ranks, after the time that they have to write.
#[test]
fn an_interrupted_mpirun_below_the_script_stops_the_run_with_code_130() {
    let Some(()) = mpi_or_skip() else { return };
    assert_stops(|script| {
        let supervisor = script.children()[0];
        send(children_of(supervisor)[0], Signal::INT);
    });
}

/// Returns the processes whose command line names a folder.
fn processes_with(folder: &Path) -> Vec<String> {
    let name = folder.to_string_lossy().into_owned();
    let all = fs::read_dir("/proc").unwrap().filter_map(|entry| {
        let words = fs::read(entry.ok()?.path().join("cmdline")).ok()?;
        Some(String::from_utf8_lossy(&words).replace('\0', " "))
    });
    all.filter(|words| words.contains(&name)).collect()
}

/// In its first moments, a launcher does not pass on signals. The script ends with code 130, or by
/// the signal if it has not begun itself, and leaves no process.
#[test]
fn a_signal_in_the_first_moments_ends_the_script_and_all_ranks() {
    let Some(()) = mpi_or_skip() else { return };
    for delay in [30, 100, 150, 200, 300, 500] {
        let folder = tempfile::tempdir().unwrap();
        let mut command = run_script(&folder.path().join("out"));
        command.env("OMPI_MCA_odls_base_sigkill_timeout", "1");
        let running = start(command);
        std::thread::sleep(Duration::from_millis(delay));
        running.signal(Signal::TERM);
        let ended = running.end();
        let code = ended.code.unwrap_or(130);
        assert_eq!(code, 130, "{delay} ms: {}", ended.said());
        let left = (0..100).find_map(|_| {
            std::thread::sleep(Duration::from_millis(50));
            processes_with(folder.path()).is_empty().then_some(())
        });
        assert!(left.is_some(), "{delay} ms: {:?}", processes_with(folder.path()));
    }
}

/// A request for a checkpoint as soon as the launcher has started: it waits until the run has
/// begun, and the run goes on to its end.
#[test]
fn a_request_in_the_first_moments_gives_a_checkpoint() {
    let Some(()) = mpi_or_skip() else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut command = run_script(&out);
    command.args(["--set=time.max_cycles=100", "--set=checkpoint.every=\"1 h\""]);
    let mut running = start(command);
    running.wait_for("the launcher has started", |script| {
        script.children().into_iter().find(|&child| !children_of(child).is_empty())
    });
    running.signal(Signal::USR1);
    let ended = running.end().with_code(0);
    assert!(newest_cycle(&out).is_some_and(|cycle| cycle < 100), "{}", ended.said());
}

/// Starts the script of Slurm as Slurm does, in a folder with the scenes and with a `scontrol` that
/// writes its arguments to a file.
fn slurm_script(folder: &Path) -> Command {
    let tools = folder.join("tools");
    if !tools.exists() {
        fs::create_dir(&tools).unwrap();
        std::os::unix::fs::symlink(root().join("cases"), folder.join("cases")).unwrap();
        let path = script(&tools, "echo \"$@\" >> \"$SLURM_SUBMIT_DIR/orders\"");
        fs::rename(path, tools.join("scontrol")).unwrap();
    }
    let mut command = Command::new("bash");
    set_environment_of_mpirun(&mut command);
    let path = std::env::var("PATH").unwrap();
    command.env("PATH", format!("{}:{path}", tools.display()));
    command.env("SLURM_SUBMIT_DIR", folder).env("SLURM_JOB_ID", "7").env("SLURM_NTASKS", "3");
    command.env("LAUNCHER", "mpirun -n {ranks}").env("CRUMPLE", crumple());
    command.arg(root().join("deploy/slurm.sbatch"));
    command.args(["cases/jeep-frame", "--no-report", "--set=time.max_cycles=900"]);
    command
}

/// Runs the script of Slurm until the history has rows, and sends it a signal. Returns the requests
/// to `scontrol`.
fn interrupted_slurm_script(folder: &Path, signal: Signal) -> String {
    let mut running = start(slurm_script(folder));
    let history = folder.join("out/jeep-frame-7/history.csv");
    running.wait_for("the history has rows", |_| {
        (fs::read_to_string(&history).ok()?.lines().count() > 3).then_some(())
    });
    running.signal(signal);
    running.end().with_code(130);
    fs::read_to_string(folder.join("orders")).unwrap_or_default()
}

/// USR1, which Slurm sends before the time limit: the job requeues itself and then continues. TERM
/// is that of `scancel`: it is not requeued.
#[test]
fn a_slurm_job_continues_after_its_time_limit_and_not_after_its_cancellation() {
    let Some(()) = mpi_or_skip() else { return };
    let folder = tempfile::tempdir().unwrap();
    let cancelled = tempfile::tempdir().unwrap();
    assert_eq!(interrupted_slurm_script(cancelled.path(), Signal::TERM), "");
    assert_eq!(interrupted_slurm_script(folder.path(), Signal::USR1), "requeue 7\n");
    let out = folder.path().join("out/jeep-frame-7");
    assert!(newest_cycle(&out).is_some_and(|cycle| cycle < 900));
    let mut again = slurm_script(folder.path());
    again.env("SLURM_RESTART_COUNT", "1");
    let again = run(again).with_code(0);
    assert!(again.said().contains("continues from"), "{}", again.said());
    let whole = ["run", "cases/jeep-frame", "--no-report", "--set=time.max_cycles=900"];
    let whole = run(crumple_with(&whole)).with_code(0);
    assert_same_files(&whole.out(), &out);
    let summary = summary_in(&out);
    assert_eq!(summary["state_digest"], whole.digest());
}
