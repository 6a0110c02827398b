//! A service that is killed at random moments, again and again, while jobs arrive, wait, start, run
//! and end; sometimes a supervisor, a master or a worker is killed too. Each job that was
//! acknowledged ends once, with the bits of an undisturbed run.
//!
//! `CRUMPLE_TORTURE_KILLS` sets the number of kills, `CRUMPLE_TORTURE_SEED` the seed;
//! `deploy/service_kills.sh` does so. At the end there is a report.

use crumple_tests::program::{crumple_with, mpi_or_skip, run, send};
use crumple_tests::service::{Service, bars};
use crumple_tests::variable;
use rustix::process::Signal;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Kills of the service in the suite.
const KILLS: u64 = 12;
/// Number of kills from which each state must have been met, and each kind of process killed.
const ENOUGH: u64 = 100;
/// Numbers of elements of the jobs: 0.2 s to 1 s on one core.
const SIZES: [usize; 3] = [100, 300, 600];
/// States in which a job stays.
const FINAL: [&str; 6] = ["checked", "completed", "refused", "failed", "lost", "stopped"];
/// States of which the report says how often a kill met them.
const OPEN: [&str; 4] = ["checking", "queued", "starting", "running"];

/// Counts of all kills.
#[derive(Default)]
struct Record {
    kills: u64,
    /// Kills at which a job was in a state.
    met: BTreeMap<&'static str, u64>,
    /// Kills that cut a submission off.
    uploads: u64,
    supervisors: u64,
    masters: u64,
    workers: u64,
    /// Attempts that a process has claimed, and those that were withdrawn.
    attempts: u64,
    withdrawn: u64,
    /// Jobs that were acknowledged, and others that were stored before a kill took the answer.
    acknowledged: usize,
    others: usize,
}

impl Record {
    fn show(&self, took: Duration) {
        println!("torture of the service: {:.0} s", took.as_secs_f64());
        println!("  kills of the service           {}", self.kills);
        for state in OPEN {
            let met = self.met.get(state).copied().unwrap_or(0);
            println!("    while a job was {state:<10}   {met}");
        }
        println!("    while a job arrived          {}", self.uploads);
        println!("  kills of a supervisor          {}", self.supervisors);
        println!("  kills of a master              {}", self.masters);
        println!("  kills of a worker              {}", self.workers);
        println!("  jobs acknowledged              {}", self.acknowledged);
        println!("  jobs stored without an answer  {}", self.others);
        println!("  attempts that ran              {}", self.attempts);
        println!("  attempts withdrawn             {}", self.withdrawn);
    }
}

/// Returns a job with checkpoints.
fn job(random: &mut fastrand::Rng, with_mpi: bool) -> Value {
    let elements = SIZES[random.usize(..SIZES.len())];
    let size = format!("scene.elements={elements}");
    let mut job = bars(&[&size, "checkpoint.every=0.2 s", "output.field_interval=-1"]);
    job["name"] = json!(elements.to_string());
    if with_mpi && random.u8(..5) == 0 {
        job["launcher"] = json!("mpirun");
    }
    job
}

/// Submits a job by pieces on a thread of its own. Returns its number if the whole answer arrives.
fn submit(service: &Service, job: &Value, pause: Duration) -> JoinHandle<Option<i64>> {
    let body = job.to_string();
    let (host, token) = (service.host.clone(), service.token.clone());
    std::thread::spawn(move || {
        let mut stream = TcpStream::connect(&host).ok()?;
        let head = format!(
            "POST /api/jobs HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\n\
             Connection: close\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n",
            body.len()
        );
        stream.write_all(head.as_bytes()).ok()?;
        let (first, rest) = body.split_at(body.len() / 2);
        stream.write_all(first.as_bytes()).ok()?;
        std::thread::sleep(pause);
        stream.write_all(rest.as_bytes()).ok()?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer).ok()?;
        let (head, body) = answer.split_once("\r\n\r\n")?;
        assert!(head.starts_with("HTTP/1.1 201"), "{answer}");
        serde_json::from_str::<Value>(body).ok()?["id"].as_i64()
    })
}

/// Returns the processes below a folder, with their command lines.
pub(crate) fn processes(folder: &Path) -> Vec<(u32, String)> {
    let all = fs::read_dir("/proc").unwrap().flatten();
    let pids = all.filter_map(|entry| entry.file_name().to_string_lossy().parse::<u32>().ok());
    pids.filter_map(|pid| {
        let own = fs::read_link(format!("/proc/{pid}/cwd")).ok()?.starts_with(folder);
        let line = fs::read_to_string(format!("/proc/{pid}/cmdline")).ok()?.replace('\0', " ");
        own.then_some((pid, line))
    })
    .collect()
}

/// Returns the rank of a process that `mpirun` has started.
fn rank(pid: u32) -> Option<u32> {
    let text = fs::read(format!("/proc/{pid}/environ")).ok()?;
    let text = String::from_utf8_lossy(&text).into_owned();
    text.split('\0').find_map(|v| v.strip_prefix("OMPI_COMM_WORLD_RANK=")?.parse().ok())
}

/// Kills one process of a job that has begun, once in the life of each job.
fn strike(
    service: &Service,
    random: &mut fastrand::Rng,
    struck: &mut BTreeSet<i64>,
    record: &mut Record,
) {
    let jobs = fs::read_dir(service.dir().join("jobs")).unwrap().flatten();
    let mut ids: Vec<i64> =
        jobs.filter_map(|job| job.file_name().to_string_lossy().parse().ok()).collect();
    ids.retain(|id| !struck.contains(id));
    ids.sort_unstable();
    for id in ids {
        let folder = service.folder(id);
        let mut all = processes(&folder);
        all.retain(|(_, line)| line.contains("crumple run") && !line.starts_with("mpirun"));
        let is_mpi = all.iter().any(|(_, line)| line.contains("--launcher"));
        // Open MPI 4 hangs if a rank is killed while it connects to `mpirun`.
        let has_begun = fs::metadata(folder.join("results/log.jsonl")).is_ok_and(|m| m.len() > 0);
        if all.is_empty() || (is_mpi && !has_begun) {
            continue;
        }
        let (pid, line) = &all[random.usize(..all.len())];
        struck.insert(id);
        send(*pid, Signal::KILL);
        let count = match (line.contains("--attempt"), rank(*pid)) {
            (true, _) => &mut record.supervisors,
            (false, Some(1..)) => &mut record.workers,
            (false, _) => &mut record.masters,
        };
        *count += 1;
        return;
    }
}

/// Returns the digests of runs that nothing disturbs, by the names of the jobs.
fn digests() -> BTreeMap<String, Value> {
    let digest = |elements: usize| {
        let size = format!("scene.elements={elements}");
        let words = ["run", "cases/bars", "--quiet", "--no-report", "--workers", "1", "--set"];
        let ended = run(crumple_with(&[&words[..], &[&size]].concat())).with_code(0);
        (elements.to_string(), ended.summary()["state_digest"].clone())
    };
    SIZES.map(digest).into()
}

#[test]
fn a_service_that_is_killed_at_any_moment_loses_no_job_and_runs_none_twice() {
    let (kills, seed) =
        (variable("CRUMPLE_TORTURE_KILLS", KILLS), variable("CRUMPLE_TORTURE_SEED", 1));
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let (mut record, began) = (Record::default(), Instant::now());
    let with_mpi = mpi_or_skip().is_some();
    let launcher = "mpirun --allow-run-as-root --oversubscribe -n {ranks}";
    let mpi = ["--mpirun", launcher, "--mpirun-slots", "1"];
    let options = [&["--slots", "1"][..], if with_mpi { &mpi[..] } else { &[] }].concat();
    let mut service = Service::start(&options);
    let (mut ids, mut struck) = (BTreeSet::new(), BTreeSet::new());
    while record.kills < kills {
        let span = if random.bool() { 300 } else { 1500 };
        let until = Instant::now() + Duration::from_millis(random.u64(..span));
        // A few jobs wait at a time, so that they start, run and end while the service is killed.
        let some = random.usize(..=3);
        let arrivals: Vec<_> = (0..some)
            .map(|_| {
                let job = job(&mut random, with_mpi);
                submit(&service, &job, Duration::from_millis(random.u64(..600)))
            })
            .collect();
        std::thread::sleep(until.saturating_duration_since(Instant::now()));
        if random.bool() {
            strike(&service, &mut random, &mut struck, &mut record);
        }
        let counts = service.get("/metrics").text();
        service.kill();
        record.kills += 1;
        for state in OPEN {
            let none = format!("crumple_jobs{{state=\"{state}\"}} 0\n");
            *record.met.entry(state).or_default() += u64::from(!counts.contains(&none));
        }
        let arrived: Vec<_> = arrivals.into_iter().map(|one| one.join().unwrap()).collect();
        record.uploads += u64::from(arrived.contains(&None));
        ids.extend(arrived.into_iter().flatten());
        if random.u8(..3) == 0 {
            // Runs end while there is no service.
            std::thread::sleep(Duration::from_millis(random.u64(..800)));
        }
        service.again();
    }
    record.acknowledged = ids.len();
    let all = service.wait("all jobs have ended", |service| {
        let all = service.get("/api/jobs?limit=500").json();
        let jobs = all["jobs"].as_array().unwrap().clone();
        assert_eq!(all["total"], jobs.len(), "one page shows them all");
        let open = |job: &Value| !FINAL.contains(&job["state"].as_str().unwrap());
        (!jobs.iter().any(open)).then_some(jobs)
    });
    let known: BTreeSet<i64> = all.iter().map(|job| job["id"].as_i64().unwrap()).collect();
    record.others = known.difference(&ids).count();
    let digests = digests();
    for job in &all {
        assert_ended_once(&service, job, &digests, &mut record);
    }
    let lost: Vec<_> = ids.difference(&known).collect();
    assert!(lost.is_empty(), "lost: {lost:?}");
    service
        .wait("no process is left", |service| processes(&service.dir()).is_empty().then_some(()));
    assert_clean(&service.dir());
    record.show(began.elapsed());
    if kills >= ENOUGH {
        let met = OPEN.map(|state| record.met[state]);
        let struck = [record.supervisors, record.masters];
        assert!(met.iter().chain(&struck).all(|&count| count > 0), "{met:?} {struck:?}");
    }
}

/// A job is completed by its last attempt only, with one last state and the right bits.
fn assert_ended_once(
    service: &Service,
    job: &Value,
    digests: &BTreeMap<String, Value>,
    record: &mut Record,
) {
    let id = job["id"].as_i64().unwrap();
    let folder = service.folder(id);
    let said = || fs::read_to_string(folder.join("output.txt")).unwrap_or_default();
    assert_eq!((&job["state"], &job["code"]), (&json!("completed"), &json!(0)), "{job} {}", said());
    let attempts = job["attempt"].as_i64().unwrap();
    let text = |n: i64| fs::read_to_string(folder.join(format!("attempt-{n}"))).unwrap();
    let texts: Vec<String> = (1..=attempts).map(text).collect();
    let ended: Vec<_> = texts.iter().map(|text| text.contains("code ")).collect();
    // An attempt without an exit code was killed; its run may have gone on to the end.
    assert!(!ended[..ended.len() - 1].contains(&true), "job {id}: {texts:?}");
    let ran = texts.iter().filter(|text| text.contains("pid ")).count() as u64;
    record.attempts += ran;
    record.withdrawn += texts.len() as u64 - ran;
    assert!(texts.last().unwrap().contains("pid "), "job {id}: {texts:?}");
    assert!(!folder.join(format!("attempt-{}", attempts + 1)).exists(), "job {id}");
    let summary = fs::read(folder.join("results/summary.json")).unwrap();
    let summary: Value = serde_json::from_slice(&summary).unwrap();
    assert_eq!(summary["state_digest"], digests[job["name"].as_str().unwrap()], "job {id}");
    let events = service.get(&format!("/api/jobs/{id}/events")).text();
    let last = events.matches("\"state\":\"completed\"").count();
    assert_eq!(last, 1, "job {id}: {events}");
}

/// No temporary file, no lock, no socket, no incomplete checkpoint and no archive is left.
fn assert_clean(folder: &Path) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let incomplete = name.starts_with("cycle_") && !path.join("MANIFEST").exists();
        let temporary = [".tmp", ".partial", ".new"].iter().any(|end| name.ends_with(end));
        let own = ["run.lock", "run.sock", "archive"].contains(&&*name);
        let half_claimed = name.starts_with("attempt-") && name.contains('.');
        let is_left = incomplete || temporary || own || half_claimed;
        assert!(!is_left, "{} is left", path.display());
        if path.is_dir() {
            assert_clean(&path);
        }
    }
}
