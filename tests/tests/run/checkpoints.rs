//! Checkpoints: a run that is interrupted and continues, on any number of workers, gives the bits
//! of a run that was not.

use crumple::run::checkpoint::manifest::Manifest;
use crumple_proto::checkpoint::{FORMAT, FileRecord, decode};
use crumple_proto::job::Job;
use crumple_tests::program::{Ended, crumple_with, mpi_or_skip, mpirun, root, run, send, start};
use crumple_tests::restart::{Plan, assert_same_files, checkpoints, copy_folder, run_interrupted};
use crumple_tests::{case, read, run_side_by_side, variable};
use crumple_worker::contact::enforce::CONTACT_LAWS;
use rustix::process::Signal;
use std::fs;
use std::path::{Path, PathBuf};

/// Interrupts a job in a random cycle, and compares the digests. `CRUMPLE_INTERRUPT_CYCLES` sets
/// the length of the run, `CRUMPLE_INTERRUPT_SEED` the random numbers.
fn assert_survives(path: &Path, sets: &[&str], cycles: u64) {
    let model = read(path, sets);
    let cycles = variable("CRUMPLE_INTERRUPT_CYCLES", cycles);
    let whole = run_side_by_side(&model, 1, cycles, 0);
    let ended = whole.pairs.len() as u64;
    let name = path.file_name().unwrap().to_string_lossy();
    let seed = variable("CRUMPLE_INTERRUPT_SEED", 1);
    let seed = name.bytes().fold(seed, |s, b| s.wrapping_mul(31).wrapping_add(u64::from(b)));
    let mut random = fastrand::Rng::with_seed(seed);
    for workers in [[3, 2], [1, 4], [2, 1]] {
        // At the latest one cycle before the end.
        let at = random.u64(1..=ended.saturating_sub(2).max(1));
        let plan = Plan { at, cycles, workers };
        let digest = run_interrupted(&model, plan);
        assert_eq!(digest, whole.digest(), "{} {sets:?} {plan:?}", path.display());
    }
}

/// Every scene, with all its elements, laws, contact, walls, bodies and ties.
#[test]
fn every_scene_continues_with_the_same_bits() {
    let scenes = fs::read_dir(case("")).unwrap().map(|e| e.unwrap().path());
    let mut scenes: Vec<PathBuf> = scenes.filter(|p| p.join("job.toml").exists()).collect();
    scenes.sort();
    assert!(scenes.len() > 15, "{scenes:?}");
    for scene in scenes {
        println!("{}", scene.display());
        assert_survives(&scene, &[], 60);
    }
}

/// Every deck of the tests that runs.
#[test]
fn every_deck_continues_with_the_same_bits() {
    let mut count = 0;
    for folder in ["good", "scenes", "taylor"] {
        let entries = fs::read_dir(root().join("tests/decks").join(folder)).unwrap();
        let mut decks: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
        decks.retain(|p| p.extension().is_some_and(|e| e == "k" || e == "toml"));
        decks.sort();
        for deck in decks {
            if crumple::input::job::read(&deck, &[]).is_ok() {
                assert_survives(&deck, &[], 60);
                count += 1;
            }
        }
    }
    assert!(count > 5, "{count}");
}

/// State in single precision, of subcycles and of each contact law, long enough for erosion,
/// impacts and folds.
#[test]
fn precisions_subcycles_and_contact_laws_continue_with_the_same_bits() {
    assert_survives(&case("jeep-frame"), &["elements.precision=\"single\""], 150);
    assert_survives(&case("tumble"), &["elements.precision=\"single\""], 300);
    assert_survives(&case("graded"), &["time.subcycles=4"], 200);
    for law in CONTACT_LAWS.iter() {
        let set = format!("contact.law=\"{}\"", law.name);
        assert_survives(&case("tumble"), &[&set], 250);
    }
    // From cycle 650 on there are pairs of segments that were lost while they were deep.
    assert_survives(&case("tumble"), &["contact.law=\"mortar\"", "contact.friction=0.2"], 900);
    let with_rcb = ["parallel.contact=\"rcb\"", "contact.friction=0.2"];
    assert_survives(&case("tumble"), &with_rcb, 900);
    // Until cycle 240 there are more than 300 pairs.
    assert_survives(&case("brick-wall"), &[], 150);
    assert_survives(&case("brick-wall"), &[], 400);
}

const TUMBLE: [&str; 6] = [
    "run",
    "cases/tumble",
    "--no-report",
    "--set",
    "time.max_cycles=900",
    "--set=checkpoint.every=\"0.05 s\"",
];

/// Returns the digest of the run without interruption.
fn undisturbed() -> Ended {
    run(crumple_with(&[&TUMBLE[..5], &["--workers", "1"]].concat())).with_code(0)
}

fn resume(out: &Path, workers: &str) -> Ended {
    let out = out.to_str().unwrap();
    run(crumple_with(&["run", "--resume", out, "--workers", workers, "--no-report"]))
}

/// A killed run continues on other numbers of workers, twice.
#[test]
fn a_killed_run_continues_as_if_nothing_had_happened() {
    let whole = undisturbed();
    let mut running = start(crumple_with(&[&TUMBLE[..], &["--workers", "3"]].concat()));
    running.wait_for_rows(6);
    running.signal(Signal::KILL);
    let killed = running.end();
    assert_eq!(killed.code, None);
    let out = killed.out();
    assert!(!checkpoints(&out).is_empty());
    for workers in ["2", "1"] {
        let copy = tempfile::tempdir().unwrap();
        let copied = copy.path().join("out");
        copy_folder(&out, &copied);
        resume(&copied, workers).with_code(0);
        assert_same_files(&whole.out(), &copied);
        let summary = fs::read_to_string(copied.join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        assert_eq!(summary["state_digest"], whole.digest());
        assert_eq!(summary["restarts"].as_array().unwrap().len(), 1);
        assert!(!copied.join("run.lock").exists());
    }
}

/// A stopped run continues: its checkpoint is that of its last cycle.
#[test]
fn a_stopped_run_continues_from_its_last_cycle() {
    let whole = undisturbed();
    let words = ["--set", "checkpoint.every=\"10 min\"", "--workers", "2"];
    let mut running = start(crumple_with(&[&TUMBLE[..5], &words].concat()));
    running.wait_for_rows(4);
    running.signal(Signal::TERM);
    let stopped = running.end().with_code(130);
    let cycle = stopped.summary()["cycles"].as_u64().unwrap();
    assert_eq!(checkpoints(&stopped.out()), [format!("cycle_{cycle:010}")]);
    resume(&stopped.out(), "3").with_code(0);
    assert_eq!(stopped.digest(), whole.digest());
    assert_same_files(&whole.out(), &stopped.out());
}

/// A rank under MPI is killed; the run continues as threads, and the other way round.
#[test]
fn a_killed_rank_loses_no_work() {
    let Some(()) = mpi_or_skip() else { return };
    let whole = undisturbed();
    for rank in [0, 2] {
        let mut running = start(mpirun(4, &TUMBLE));
        running.wait_for_rows(6);
        send(running.ranks()[rank], Signal::KILL);
        let killed = running.end();
        assert_ne!(killed.code, Some(0));
        let out = killed.out();
        assert!(!checkpoints(&out).is_empty());
        let copy = tempfile::tempdir().unwrap();
        let copied = copy.path().join("out");
        copy_folder(&out, &copied);
        resume(&copied, "2").with_code(0);
        assert_same_files(&whole.out(), &copied);
        run(mpirun(3, &["run", "--resume", out.to_str().unwrap(), "--no-report"])).with_code(0);
        assert_eq!(killed.digest(), whole.digest());
    }
}

/// USR1 requests a checkpoint; the run continues.
#[test]
fn a_signal_requests_a_checkpoint() {
    let words = ["--set", "checkpoint.every=\"off\"", "--workers", "2"];
    let mut running = start(crumple_with(&[&TUMBLE[..5], &words].concat()));
    running.wait_for_rows(4);
    running.signal(Signal::USR1);
    let ended = running.end().with_code(0);
    assert_eq!(checkpoints(&ended.out()).len(), 1);
    assert_eq!(ended.summary()["checkpoints"]["written"], 1);
}

/// A run that fails keeps a state from shortly before, also if it writes no checkpoints before. The
/// message names it, and the run continues from there with a change.
#[test]
fn a_failed_run_keeps_the_state_before_its_failure() {
    let cause = "--set=time.safety=2.5";
    let words = ["run", "cases/jeep-frame", "--workers", "2", "--no-report", cause];
    let failed = run(crumple_with(&words)).with_code(3);
    let (said, out) = (failed.said(), failed.out());
    let kept = checkpoints(&out);
    assert_eq!(kept.len(), 1, "{said}");
    assert!(said.contains(&kept[0]) && said.contains("--resume"), "{said}");
    let end = failed.summary()["cycles"].as_u64().unwrap();
    let cycle: u64 = kept[0].strip_prefix("cycle_").unwrap().parse().unwrap();
    assert!(cycle < end && end - cycle < 1000, "cycle {cycle} of {end}");
    let suggested = said.split("--set ").nth(1).unwrap().split_whitespace().next().unwrap();
    let more = ["--set", suggested, "--set", "time.max_cycles=1", "--workers", "1"];
    let more = [&["run", "--resume", out.to_str().unwrap(), "--no-report"][..], &more].concat();
    let again = run(crumple_with(&more)).with_code(0);
    assert!(again.said().contains("continues from"), "{}", again.said());
    let off = ["--set", "checkpoint.in_memory=off"];
    let failed = run(crumple_with(&[&words[..], &off].concat())).with_code(3);
    assert!(failed.said().contains("there is no checkpoint"), "{}", failed.said());
}

/// Times of the job: a checkpoint in the first cycle after each; `keep` of them stay.
#[test]
fn checkpoints_are_written_at_times_and_old_ones_are_removed() {
    // Far apart: one that is due while another is being written waits; several that wait are one.
    let words =
        ["--set", "checkpoint.every=\"off\"", "--set", "checkpoint.at=[0.2, 0.7, 1.2, 99.0]"];
    let ended = run(crumple_with(&[&TUMBLE[..5], &words].concat())).with_code(0);
    assert_eq!(ended.summary()["checkpoints"]["written"], 3);
    assert_eq!(checkpoints(&ended.out()).len(), 2, "keep = 2");
}

/// A broken checkpoint is refused with its reason, and the one before is used.
#[test]
fn a_broken_checkpoint_is_refused_and_the_one_before_is_used() {
    let words = ["--set", "checkpoint.at=[0.2, 0.3]", "--workers", "2"];
    let ended = run(crumple_with(&[&TUMBLE[..5], &words].concat())).with_code(0);
    let (out, digest) = (ended.out(), ended.digest());
    let newest = out.join("checkpoints").join(checkpoints(&out).pop().unwrap());
    for (file, how) in [("piece_00001.bin", "blake3"), ("common.bin", "bytes instead of")] {
        let path = newest.join(file);
        let good = fs::read(&path).unwrap();
        let mut bad = good.clone();
        let middle = bad.len() / 2;
        if how == "blake3" {
            bad[middle] ^= 1
        } else {
            bad.truncate(middle)
        };
        fs::write(&path, bad).unwrap();
        let copy = tempfile::tempdir().unwrap();
        let copied = copy.path().join("out");
        copy_folder(&out, &copied);
        let again = resume(&copied, "1").with_code(0);
        assert!(again.said().contains(how) && again.said().contains(file), "{}", again.said());
        let summary = fs::read_to_string(copied.join("summary.json")).unwrap();
        assert!(summary.contains(&digest));
        fs::write(&path, good).unwrap();
    }
    for name in checkpoints(&out) {
        let path = out.join("checkpoints").join(name).join("MANIFEST");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replacen(&format!(" {FORMAT} "), " 99 ", 1)).unwrap();
    }
    let refused = resume(&out, "1").with_code(2);
    for text in ["no whole checkpoint", "format 99", "MANIFEST"] {
        assert!(refused.said().contains(text), "{}", refused.said());
    }
}

/// Changes that the state does not depend on are recorded; others are refused.
#[test]
fn a_run_continues_with_allowed_changes_only() {
    let words = ["--set", "checkpoint.at=[0.3]", "--workers", "2"];
    let ended = run(crumple_with(&[&TUMBLE[..5], &words].concat())).with_code(0);
    let out = ended.out();
    let out = out.to_str().unwrap();
    let with =
        |set: &str| run(crumple_with(&["run", "--resume", out, "--no-report", "--set", set]));
    for (set, key) in [
        ("time.safety=0.5", "`time.safety`"),
        ("scene.refine=2", "`scene.refine`"),
        ("contact.edges=false", "`contact.edges`"),
        ("output.history_interval=0.001", "`output.history_interval`"),
        ("end_time=0.1", "end_time"),
    ] {
        let refused = with(set).with_code(2);
        assert!(refused.said().contains(key), "{set}: {}", refused.said());
    }
    with("time.max_cycles=700").with_code(0);
    let summary = ended.summary();
    assert_eq!(summary["cycles"], 700);
    assert_eq!(summary["restarts"][0]["changes"][0], "time.max_cycles=700");
}

/// Two runs do not write into one folder.
#[test]
fn a_folder_in_use_is_refused() {
    let mut running = start(crumple_with(&[&TUMBLE[..5], &["--workers", "1"]].concat()));
    running.wait_for_rows(2);
    let out = running.out();
    let refused =
        run(crumple_with(&["run", "cases/tumble", "--out", out.to_str().unwrap()])).with_code(2);
    assert!(refused.said().contains("another run writes into this folder"), "{}", refused.said());
    running.end().with_code(0);
}

/// A folder that cannot be written costs the checkpoint, not the run.
#[test]
fn a_checkpoint_that_cannot_be_written_does_not_end_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    fs::create_dir_all(&out).unwrap();
    fs::write(out.join("checkpoints"), "a file where a folder should be").unwrap();
    let words = ["--out", out.to_str().unwrap(), "--set", "checkpoint.at=[0.2]"];
    let ended = run(crumple_with(&[&TUMBLE[..5], &words].concat())).with_code(0);
    assert!(ended.said().contains("could not be written"), "{}", ended.said());
}

/// The supervisor starts a killed run again, and gives up when there is no new checkpoint.
#[test]
fn a_supervised_run_continues_after_its_loss() {
    let whole = undisturbed();
    let words = ["--retries", "3", "--workers", "2"];
    let mut running = start(crumple_with(&[&TUMBLE[..], &words].concat()));
    running.wait_for_rows(6);
    let child = running.children()[0];
    send(child, Signal::KILL);
    let ended = running.end().with_code(0);
    assert_eq!(ended.digest(), whole.digest());
    assert!(ended.said().contains("the run was lost (signal 9)"), "{}", ended.said());
    assert_same_files(&whole.out(), &ended.out());
}

/// The section has defaults, so that a job without it has checkpoints.
#[test]
fn checkpoints_are_on_by_default() {
    let job: Job = toml::from_str("end_time = 1.0\n[mesh]\n").unwrap();
    assert_eq!(job.checkpoint.interval().unwrap().unwrap().as_secs(), 600);
    assert_eq!(job.checkpoint.keep, 2);
}

/// Changes of random kinds to manifests and files: none is accepted, none causes a panic. The
/// variable `CRUMPLE_MUTATIONS` sets their number.
#[test]
fn mutated_manifests_and_files_are_refused() {
    let words = ["--set", "checkpoint.at=[0.2]", "--workers", "2"];
    let ended = run(crumple_with(&[&TUMBLE[..5], &words].concat())).with_code(0);
    let folder = ended.out().join("checkpoints").join(&checkpoints(&ended.out())[0]);
    let manifest = fs::read(folder.join("MANIFEST")).unwrap();
    let known = Manifest::from_bytes(&manifest).unwrap();
    let files: Vec<(FileRecord, Vec<u8>)> =
        known.files().map(|f| (f.clone(), fs::read(folder.join(&f.name)).unwrap())).collect();
    let mut random = fastrand::Rng::with_seed(20);
    for number in 0..variable("CRUMPLE_MUTATIONS", 3000) {
        let bad = mutated(&mut random, &manifest);
        assert!(bad == manifest || Manifest::from_bytes(&bad).is_err(), "mutation {number}");
        // With a right sum only the meaning is wrong. It may be read, or refused with a reason.
        let start = manifest.iter().position(|&b| b == b'\n').unwrap() + 1;
        let body = mutated(&mut random, &manifest[start..]);
        let line = format!("crumple-checkpoint {FORMAT} {}\n", blake3::hash(&body).to_hex());
        let _ = Manifest::from_bytes(&[line.as_bytes(), &body].concat());
        let (record, good) = &files[random.usize(..files.len())];
        let bad = mutated(&mut random, good);
        let same = bad.len() as u64 == record.bytes
            && blake3::hash(&bad).to_hex().as_str() == record.blake3;
        assert_eq!(same, &bad == good, "mutation {number}");
        let _ = decode(&bad);
    }
}

/// Returns bytes with one to four changes: bits, bytes, cuts, repeated or removed ranges.
fn mutated(random: &mut fastrand::Rng, good: &[u8]) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..random.usize(1..=4) {
        if bytes.is_empty() {
            return bytes;
        }
        let (a, b) = (random.usize(..bytes.len()), random.usize(..bytes.len()));
        let (from, to) = (a.min(b), a.max(b));
        match random.u8(..6) {
            0 => bytes[a] ^= 1 << random.u8(..8),
            1 => bytes[a] = random.u8(..),
            2 => bytes.truncate(a),
            3 => drop(bytes.drain(from..to)),
            4 => bytes.swap(a, b),
            _ => {
                let range = bytes[from..(from + 64).min(to)].to_vec();
                bytes.splice(a..a, range);
            }
        }
    }
    bytes
}
