//! Runs that are killed at random moments, again and again, and continue on random numbers of
//! workers and transports: the digest and the files are those of a run without interruption.
//!
//! `CRUMPLE_TORTURE_ROUNDS` sets the number of rounds, `CRUMPLE_TORTURE_SEED` the first seed;
//! `deploy/torture.sh` does so. At the end there is a report. A round that fails names its seed and
//! leaves its folder.

use crumple::run::checkpoint::find::{folders, newest_cycle};
use crumple_tests::program::{crumple_with, mpi_or_skip, mpirun, run, send, start};
use crumple_tests::restart::assert_same_files;
use crumple_tests::variable;

use rustix::process::Signal;
use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant, SystemTime};

/// Rounds of the suite.
const ROUNDS: u64 = 4;
/// Scenes and their numbers of cycles: some seconds for each on one worker of a busy machine.
const SCENES: [(&str, u64); 6] = [
    ("tumble", 3000),
    ("brick-wall", 60),
    ("pipe-whip", 2400),
    ("tube-crush", 1000),
    ("flight", 1200),
    ("can-crush", 500),
];
/// Most kills in a round.
const KILLS: u32 = 3;
/// Intervals between two checkpoints, one of them for each round [s]. In the first, kills meet many
/// checkpoints; in the second, the time in which the workers agree on the cycle of a checkpoint is
/// small against the interval, also on a machine with more ranks than cores.
const INTERVALS: [f64; 2] = [0.2, 1.0];
/// Largest share of the kills after which more work is lost than that of the second interval.
/// Another process may keep a core for longer.
const LATE: f64 = 0.02;
/// Number of such kills from which the share is checked.
const ENOUGH: usize = 100;

/// Counts of all rounds.
#[derive(Default)]
struct Record {
    rounds: u64,
    kills: u64,
    /// Kills of a process that was the master, or of all ranks as threads of one process.
    of_master: u64,
    /// Kills that left a checkpoint without manifest.
    while_writing: u64,
    /// Kills of processes that had not written a checkpoint yet.
    before_any: u64,
    /// Times from the first file of the last checkpoint, or from the begin of the process if it has
    /// written none, to a kill [s]; for each of `INTERVALS`.
    losses: [Vec<f64>; 2],
    /// Kills after which more work is lost than that of the interval, of runs that had warned that
    /// the interval is too short; for each of `INTERVALS`.
    announced: [usize; 2],
    orphans: u64,
    temporary: u64,
}

impl Record {
    fn show(&self, took: Duration) {
        let Self { rounds, kills, of_master, while_writing, before_any, .. } = self;
        println!("torture: {rounds} rounds, {:.0} s", took.as_secs_f64());
        println!("  kills                            {kills}");
        println!("  of the master or of all workers  {of_master}");
        println!("  while a checkpoint was written   {while_writing}");
        println!("  before a first checkpoint        {before_any}");
        for ((losses, interval), announced) in self.losses.iter().zip(INTERVALS).zip(self.announced)
        {
            show_losses(interval, losses, announced);
        }
        println!("  orphan processes found           {}", self.orphans);
        println!("  temporary files left             {}", self.temporary);
    }

    /// Records the state of a run's folder right after a kill at the time `now`. `known` is the
    /// newest checkpoint when the process began.
    fn add_kill(
        &mut self,
        out: &Path,
        (known, begun): (Option<u64>, SystemTime),
        now: SystemTime,
        which: usize,
    ) {
        self.kills += 1;
        let all = folders(&out.join("checkpoints"));
        let (whole, parts): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|f| f.join("MANIFEST").exists());
        self.while_writing += u64::from(!parts.is_empty());
        let newest = whole.first().filter(|_| newest_cycle(out) > known);
        self.before_any += u64::from(newest.is_none());
        let kept = newest.and_then(|folder| began(folder)).unwrap_or(begun);
        let loss = now.duration_since(kept).map_or(0.0, |d| d.as_secs_f64());
        if loss > INTERVALS[which] {
            let since = newest.map_or("its begin".into(), |f| f.display().to_string());
            println!("  {loss:.2} s of work lost since {since}, interval {} s", INTERVALS[which]);
            let log = fs::read_to_string(out.join("log.jsonl")).unwrap_or_default();
            let warned = log.contains("more than half of `checkpoint.every`");
            self.announced[which] += usize::from(warned);
        }
        self.losses[which].push(loss);
    }

    /// Returns the number of kills after which more work was lost than that of the second interval,
    /// without a warning before.
    fn late(&self) -> usize {
        let late = self.losses[1].iter().filter(|&&loss| loss > INTERVALS[1]).count();
        late - self.announced[1]
    }
}

/// Prints the median, the 90th percentile and the largest loss of work.
fn show_losses(interval: f64, losses: &[f64], announced: usize) {
    let mut sorted = losses.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).or(sorted.last());
    let [middle, most, worst] = [0.5, 0.9, 1.0].map(|share| at(share).copied().unwrap_or(0.0));
    let late = losses.iter().filter(|&&loss| loss > interval).count();
    println!(
        "  loss of work, interval {interval:.1} s      median {middle:.2} s, 90 % below \
         {most:.2} s, worst {worst:.2} s; above the interval {late} of {} kills, {announced} of \
         them with a warning",
        losses.len()
    );
}

/// Returns the time at which the first file of a checkpoint was made.
fn began(folder: &Path) -> Option<SystemTime> {
    let made = |e: fs::DirEntry| e.metadata().ok()?.created().ok();
    fs::read_dir(folder).ok()?.filter_map(|e| made(e.ok()?)).min()
}

#[test]
fn killed_runs_give_the_results_of_undisturbed_ones() {
    let seed = variable("CRUMPLE_TORTURE_SEED", 1);
    let with_mpi = mpi_or_skip().is_some();
    let mut known: BTreeMap<&str, Undisturbed> = BTreeMap::new();
    let (mut record, began) = (Record::default(), Instant::now());
    for round in 0..variable("CRUMPLE_TORTURE_ROUNDS", ROUNDS) {
        let seed = seed + round;
        let mut random = fastrand::Rng::with_seed(seed);
        let (scene, cycles) = SCENES[random.usize(..SCENES.len())];
        let whole = known.entry(scene).or_insert_with(|| Undisturbed::run(scene, cycles));
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let before = record.kills;
        let survived = catch_unwind(AssertUnwindSafe(|| {
            one_round(&mut random, whole, &out, with_mpi, &mut record);
            assert_eq!(digest_of(&out), whole.digest, "digest");
            assert_same_files(&whole.out, &out);
            assert_clean(&out, &mut record);
        }));
        record.rounds += 1;
        println!("round {round}, seed {seed}: {scene}, {} kills", record.kills - before);
        if let Err(why) = survived {
            record.show(began.elapsed());
            println!("seed {seed} failed; repeat it by: deploy/torture.sh 1 {seed}");
            println!("its folder is {}", folder.keep().display());
            resume_unwind(why);
        }
    }
    record.show(began.elapsed());
    assert!(record.kills > 0, "no run was killed before its end");
    let (late, kills) = (record.late(), record.losses[1].len());
    assert!(kills < ENOUGH || (late as f64) < LATE * kills as f64, "{late} of {kills} lost more");
}

/// A run that nothing disturbs.
struct Undisturbed {
    scene: &'static str,
    cycles: u64,
    digest: String,
    out: PathBuf,
    took: Duration,
    _folder: tempfile::TempDir,
}

impl Undisturbed {
    fn run(scene: &'static str, cycles: u64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let ended = run(command(&words(scene, cycles, &out, "off"), 1, false)).with_code(0);
        let (digest, took) = (digest_of(&out), ended.took);
        Self { scene, cycles, digest, out, took, _folder: folder }
    }
}

fn words(scene: &str, cycles: u64, out: &Path, every: &str) -> Vec<String> {
    let words = [
        "run".to_string(),
        format!("cases/{scene}"),
        "--no-report".into(),
        "--overwrite".into(), // what a run that was killed before its first checkpoint has left
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

/// Runs a scene, kills it up to `KILLS` times, and lets it end. A kill is at a random time within
/// the duration of the undisturbed run, or within one and a half intervals after a checkpoint is
/// complete.
fn one_round(
    random: &mut fastrand::Rng,
    whole: &Undisturbed,
    out: &Path,
    with_mpi: bool,
    record: &mut Record,
) {
    let which = random.usize(..INTERVALS.len());
    for attempt in 0..=KILLS {
        let folder = out.to_string_lossy().into_owned();
        // Before the first checkpoint, a run starts again.
        let known = newest_cycle(out);
        let words = if known.is_some() {
            ["run", "--resume", &folder, "--no-report"].map(String::from).to_vec()
        } else {
            words(whole.scene, whole.cycles, out, &format!("{} s", INTERVALS[which]))
        };
        let (workers, mpi) = (random.usize(1..=4), with_mpi && random.bool());
        let log = || fs::metadata(out.join("log.jsonl")).map_or(0, |m| m.len());
        let before = log();
        let mut running = start(command(&words, workers, mpi));
        if attempt == KILLS {
            running.end().with_code(0);
            return;
        }
        // Open MPI 4 hangs if a rank is killed while it connects to `mpirun`.
        running.wait_for("the run has begun", |_| {
            let now = log();
            (now > 0 && now != before).then_some(())
        });
        let begun = SystemTime::now();
        std::thread::sleep(if random.bool() {
            whole.took.mul_f64(random.f64())
        } else {
            // A run may end without one.
            running.wait_for("a checkpoint is complete", |_| {
                let late = begun.elapsed().is_ok_and(|time| time > 3 * whole.took);
                (late || newest_cycle(out) > known).then_some(())
            });
            Duration::from_secs_f64(1.5 * INTERVALS[which] * random.f64())
        });
        let ranks = if mpi { running.ranks() } else { Vec::new() };
        let victim = random.usize(..=workers);
        let killed = SystemTime::now();
        match ranks.get(victim) {
            Some(&rank) => send(rank, Signal::KILL),
            None => running.signal(Signal::KILL),
        }
        let ended = running.end();
        let orphans: Vec<u32> = ranks.iter().copied().filter(|&rank| is_running(rank)).collect();
        record.orphans += orphans.len() as u64;
        assert!(orphans.is_empty(), "orphans: {orphans:?}");
        if ended.code == Some(0) {
            return;
        }
        record.of_master += u64::from(ranks.is_empty() || victim == 0);
        println!("  killed: {workers} workers, {}", if mpi { "MPI" } else { "threads" });
        record.add_kill(out, (known, begun), killed, which);
    }
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
fn assert_clean(folder: &Path, record: &mut Record) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let incomplete = name.starts_with("cycle_") && !path.join("MANIFEST").exists();
        let temporary = [".tmp", ".partial"].iter().any(|end| name.ends_with(end));
        if temporary || name == "run.lock" || name == "run.sock" || incomplete {
            record.temporary += 1;
            panic!("{} is left", path.display());
        }
        if path.is_dir() {
            assert_clean(&path, record);
        }
    }
}
