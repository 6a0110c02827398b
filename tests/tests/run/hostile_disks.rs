//! Checkpoints on disks that are full, read-only, slow or wrong: the run goes on, says what is
//! wrong, and continues from the newest checkpoint that is whole.

use crumple::run::checkpoint::manifest::Manifest;
use crumple_proto::checkpoint::{decode, encode, piece_name};
use crumple_proto::job::Compression;
use crumple_tests::program::{Ended, Running, crumple_with, run, start};
use crumple_tests::restart::{checkpoints, copy_folder};
use crumple_tests::tools::{fifo, tmpfs};
use rustix::process::Signal;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;

/// A run with checkpoints at two times.
const TWICE: [&str; 6] = [
    "run",
    "cases/tumble",
    "--no-report",
    "--workers=2",
    "--set=time.max_cycles=500",
    "--set=checkpoint.at=[0.2, 0.4]",
];
/// Patience with a disk that hangs. A run without trouble has the default, since a busy machine may
/// take longer to write.
const SOON: &str = "--set=checkpoint.patience=1 s";
/// Bytes of one of its checkpoints, rounded up.
const BYTES: u64 = 800_000;

fn with(out: &Path, more: &[&str]) -> std::process::Command {
    let out = [SOON, "--out", out.to_str().unwrap()];
    crumple_with(&[&TWICE[..], &out, more].concat())
}

fn resume(out: &Path) -> Ended {
    run(crumple_with(&["run", "--resume", out.to_str().unwrap(), "--workers=1", "--no-report"]))
}

fn digest_of(out: &Path) -> String {
    let summary = fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    summary["state_digest"].as_str().unwrap().into()
}

/// Returns a run without trouble, with both checkpoints, and its digest.
fn whole() -> (Ended, String) {
    let ended = run(crumple_with(&TWICE)).with_code(0);
    assert_eq!(checkpoints(&ended.out()).len(), 2);
    let digest = ended.digest();
    (ended, digest)
}

/// Copies the folder of a run. Returns the copy, its results and its newest checkpoint.
fn copy_of(known: &Ended) -> (TempDir, PathBuf, PathBuf) {
    let copy = tempfile::tempdir().unwrap();
    let out = copy.path().join("out");
    copy_folder(&known.out(), &out);
    let newest = out.join("checkpoints").join(checkpoints(&out).pop().unwrap());
    (copy, out, newest)
}

/// Checks that only the first checkpoint is there, after a run that said why, and that a run
/// continues from it.
fn assert_first_is_kept(out: &Path, ended: &Ended, why: &str, digest: &str) {
    assert!(ended.said().contains(why), "{why}: {}", ended.said());
    assert!(ended.said().contains("is kept"), "{}", ended.said());
    assert_eq!(checkpoints(out).len(), 1, "{}", ended.said());
    assert_eq!(digest_of(out), digest, "the run went on");
    resume(out).with_code(0);
    assert_eq!(digest_of(out), digest);
}

#[test]
fn a_full_disk_costs_the_checkpoint_and_keeps_the_one_before() {
    let (_, digest) = whole();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let Some(_disk) = tmpfs(&out.join("checkpoints"), BYTES + BYTES / 2) else { return };
    let ended = run(with(&out, &["--set=checkpoint.every=10 min"])).with_code(0);
    assert_first_is_kept(&out, &ended, "No space left on device", &digest);
}

#[test]
fn a_disk_that_becomes_read_only_keeps_the_checkpoint_before() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let Some(disk) = tmpfs(&out.join("checkpoints"), 8 * BYTES) else { return };
    let sets = ["--set=time.max_cycles=4000", "--set=checkpoint.at=[0.2]"];
    let mut running = start(with(&out, &sets));
    running.wait_for("the first checkpoint is there", |_| {
        (checkpoints(&out).len() == 1).then_some(())
    });
    disk.make_read_only();
    running.signal(Signal::USR1);
    let ended = running.end().with_code(0);
    disk.make_writable();
    assert_first_is_kept(&out, &ended, "Read-only file system", &digest_of(&out));
}

/// The next checkpoint makes the folder again.
#[test]
fn a_folder_that_is_removed_during_the_run_is_made_again() {
    let mut running = start(crumple_with(&[
        "run",
        "cases/tumble",
        "--no-report",
        "--workers=2",
        "--set=time.max_cycles=4000",
        "--set=checkpoint.at=[0.2]",
    ]));
    let out = running.out();
    running.wait_for("the first checkpoint is there", |_| {
        (checkpoints(&out).len() == 1).then_some(())
    });
    // At once: the run may still be writing there.
    fs::rename(out.join("checkpoints"), out.join("removed")).unwrap();
    running.signal(Signal::USR1);
    let ended = running.end().with_code(0);
    assert_eq!(checkpoints(&out).len(), 1, "{}", ended.said());
    let digest = ended.digest();
    resume(&out).with_code(0);
    assert_eq!(digest_of(&out), digest);
}

/// A pipe without a reader, in place of a file of a worker or of the master, blocks whoever opens
/// it: like a file system that hangs. The run goes on, and does not wait for it at its end.
#[test]
fn a_file_system_that_hangs_costs_the_checkpoint_only() {
    let (known, digest) = whole();
    let second = checkpoints(&known.out()).pop().unwrap();
    for name in [&piece_name(1), "master.bin"] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let mut running = start(with(&out, &[]));
        running.wait_for("the first checkpoint is there", |_| {
            (checkpoints(&out).len() == 1).then_some(())
        });
        let second = out.join("checkpoints").join(format!("{second}.part0"));
        fs::create_dir_all(&second).unwrap();
        let Some(()) = fifo(&second.join(name)) else { return };
        let ended = running.end().with_code(0);
        assert_first_is_kept(&out, &ended, "the file system hangs", &digest);
    }
}

/// Runs a job on a folder in which `prepare` puts a pipe, so that a file of the results blocks: it
/// ends with a warning, an error that names the file, and code 2.
fn assert_ends(file: &str, more: &[&str], prepare: impl FnOnce(&Path, &mut Running)) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    fs::create_dir_all(&out).unwrap();
    let short = "--set=checkpoint.patience=0.3 s";
    let long = "--set=time.max_cycles=3000";
    let words = TWICE.into_iter().filter(|&w| w != "--no-report" || file != "report.html");
    let place = ["--out", out.to_str().unwrap(), short, long];
    let words: Vec<&str> = words.chain(place).chain(more.iter().copied()).collect();
    let mut running = start(crumple_with(&words));
    prepare(&out, &mut running);
    let ended = running.end().with_code(2);
    let said = ended.said();
    for text in [file, "warning", "the run waits for it", "it hangs, and the program ends"] {
        assert!(said.contains(text), "{file}: {text}: {said}");
    }
    assert!(ended.took < Duration::from_secs(120), "{:?}", ended.took);
}

/// Waits for the first checkpoint, after which the run has several seconds to go.
fn wait_for_first(out: &Path, running: &mut Running) {
    running.wait_for("the first checkpoint is there", |_| {
        (!checkpoints(out).is_empty()).then_some(())
    });
}

#[test]
fn a_summary_on_a_disk_that_hangs_ends_the_run_with_a_message() {
    assert_ends("summary.json", &["--set=time.max_cycles=800"], |out, running| {
        wait_for_first(out, running);
        fifo(&out.join("summary.json.partial"));
    });
}

#[test]
fn fields_on_a_disk_that_hangs_end_the_run_with_a_message() {
    assert_ends("fields", &[], |out, running| {
        wait_for_first(out, running);
        fifo(&out.join("fields/fields.pvd.partial"));
    });
    // A piece of a worker, in the last step.
    assert_ends("fields", &[], |out, running| {
        wait_for_first(out, running);
        for step in 1..200 {
            let folder = out.join("fields").join(format!("step_{step:06}"));
            if !folder.exists() {
                fs::create_dir_all(&folder).unwrap();
                fifo(&folder.join("piece_001.vtu.partial"));
            }
        }
    });
}

/// Files that are written after the run: the report and the database of the fields.
#[test]
fn exports_on_a_disk_that_hangs_end_the_program_with_a_message() {
    for (name, set) in [("report.html", None), ("d3plot", Some("--set=output.d3plot=true"))] {
        let sets = ["--set=time.max_cycles=800"].into_iter().chain(set);
        assert_ends(name, &sets.collect::<Vec<_>>(), |out, running| {
            wait_for_first(out, running);
            fifo(&out.join(format!("{name}.partial")));
        });
    }
}

/// A pipe that is never emptied takes 64 kB and blocks then.
#[test]
fn a_history_on_a_disk_that_hangs_ends_the_run_with_a_message() {
    let pipe = tempfile::tempdir().unwrap();
    let path = pipe.path().join("full");
    let Some(()) = fifo(&path) else { return };
    let _reader = fs::File::options().read(true).write(true).open(&path).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    fs::create_dir_all(&out).unwrap();
    std::os::unix::fs::symlink(&path, out.join("history.csv")).unwrap();
    let more = [
        "--set=checkpoint.patience=0.3 s",
        "--set=output.history_interval=0.001",
        "--set=time.max_cycles=3000",
    ];
    let ended = run(with(&out, &more)).with_code(2);
    let said = ended.said();
    assert!(said.contains("history.csv: no answer"), "{said}");
    assert!(said.contains("it hangs, and the program ends"), "{said}");
}

/// Files with right sums and wrong contents: an error with the file, or the checkpoint before; no
/// panic.
#[test]
fn wrong_contents_with_right_sums_are_refused() {
    let (known, digest) = whole();
    type Change = fn(&mut Vec<u64>);
    let changes: [(&str, Change); 7] = [
        ("no words", |words| words.clear()),
        ("a huge parcel", |words| words[0] = u64::MAX),
        ("a huge number of elements", |words| words[1] = u64::MAX >> 1),
        ("one element less", |words| words[1] -= 1),
        ("an element with another node", |words| words[9] = 999_999_999),
        ("an unknown shape", |words| words[6] |= 0xffff << 32),
        ("half of the words", |words| words.truncate(words.len() / 2)),
    ];
    for (what, change) in changes {
        let (_copy, out, newest) = copy_of(&known);
        rewrite(&newest, &piece_name(1), change);
        let ended = resume(&out).with_code(0);
        let said = ended.said();
        assert!(said.contains("a newer checkpoint cannot be used"), "{what}: {said}");
        assert!(said.contains(&piece_name(1)) && !said.contains("panicked"), "{what}: {said}");
        assert_eq!(digest_of(&out), digest, "{what}");
    }
    let changes: [(&str, Change); 2] = [
        ("half of the words", |words| words.truncate(words.len() / 2)),
        ("a byte of the time", |words| words[1] ^= 1 << 8),
    ];
    for (what, change) in changes {
        let (_copy, out, newest) = copy_of(&known);
        rewrite(&newest, "common.bin", change);
        let ended = resume(&out).with_code(0);
        let said = ended.said();
        assert!(said.contains("a newer checkpoint cannot be used"), "{what}: {said}");
        assert!(said.contains("common.bin") && !said.contains("panicked"), "{what}: {said}");
        assert_eq!(digest_of(&out), digest, "{what}");
        // Without another one there is nothing to continue from.
        let single = run(crumple_with(&["run", "--resume", newest.to_str().unwrap()]));
        assert!(single.code == Some(0) || single.said().contains("common.bin"), "{what}");
    }
}

/// The clock of the common state and the manifest show the same cycle; a manifest of another one is
/// refused also with a right sum.
#[test]
fn a_manifest_of_another_cycle_is_refused() {
    let (known, digest) = whole();
    let (_copy, out, newest) = copy_of(&known);
    let mut manifest = Manifest::read(&newest).unwrap();
    manifest.captured.cycle += 1;
    manifest.write(&newest).unwrap();
    let refused = run(crumple_with(&["run", "--resume", newest.to_str().unwrap()])).with_code(2);
    assert!(refused.said().contains("its clock shows cycle"), "{}", refused.said());
    let ended = resume(&out).with_code(0);
    assert!(ended.said().contains("its clock shows cycle"), "{}", ended.said());
    assert_eq!(digest_of(&out), digest);
}

/// A program with other columns refuses a checkpoint, and names the first that differs.
#[test]
fn a_checkpoint_with_other_columns_is_refused() {
    let (known, digest) = whole();
    let (_copy, out, newest) = copy_of(&known);
    let mut manifest = Manifest::read(&newest).unwrap();
    let columns = manifest.stamp.layout.iter_mut().find(|(key, _)| key.starts_with("Quad4 of"));
    let (key, names) = columns.unwrap();
    let message = format!(
        "number 1 of {key} is `other` in the checkpoint and `{}` in this program",
        names[0]
    );
    names[0] = "other".into();
    manifest.write(&newest).unwrap();
    let ended = resume(&out).with_code(0);
    assert!(ended.said().contains(&message), "{message}: {}", ended.said());
    assert_eq!(digest_of(&out), digest);
}

/// A history that is missing or shorter than at the checkpoint costs its rows and nothing else.
#[test]
fn a_history_that_is_lost_before_the_run_continues_begins_again() {
    let (known, digest) = whole();
    let (_copy, out, _) = copy_of(&known);
    let text = |name: &str| fs::read_to_string(out.join(name)).unwrap();
    let [history, workers] = ["history.csv", "workers.csv"].map(text);
    fs::remove_file(out.join("workers.csv")).unwrap();
    let cut = history.match_indices('\n').nth(1).unwrap().0 + 1;
    fs::write(out.join("history.csv"), &history[..cut]).unwrap();
    let ended = resume(&out).with_code(0);
    let said = ended.said();
    for name in ["history.csv was removed or shortened", "workers.csv was removed or shortened"] {
        assert!(said.contains(name), "{name}: {said}");
    }
    assert_eq!(digest_of(&out), digest);
    assert!(text("summary.json").contains("history.csv was removed or shortened"));
    assert_eq!(text("history.csv.short"), history[..cut], "what was left is kept");
    let header = |text: &str| text.lines().next().unwrap().to_string();
    assert_eq!(header(&text("history.csv")), header(&history));
    assert_eq!(header(&text("workers.csv")), header(&workers));
    let last = |text: &str| text.lines().last().unwrap().split(',').next().unwrap().to_string();
    assert_eq!(last(&text("history.csv")), last(&history), "the rows after the checkpoint");
}

/// The folder of the run is removed while it goes: rows so far are lost, and the user knows.
#[test]
fn a_folder_of_a_run_that_is_removed_is_made_again_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let more = ["--set=time.max_cycles=3000", "--set=output.history_interval=0.02"];
    let mut running = start(with(&out, &more));
    running.wait_for("there are rows", |_| {
        let rows = fs::read_to_string(out.join("history.csv")).unwrap_or_default();
        (rows.lines().count() > 4).then_some(())
    });
    // The run may add a file meanwhile.
    while fs::remove_dir_all(&out).is_err() {}
    let ended = running.end().with_code(0);
    let said = ended.said();
    let text = |name: &str| fs::read_to_string(out.join(name)).unwrap();
    for name in ["history.csv", "workers.csv"] {
        let message = format!("{name} was removed during the run: its rows until time");
        assert!(said.contains(&message), "{name}: {said}");
        assert!(text("summary.json").contains(&message), "{name}");
    }
    let history = text("history.csv");
    assert!(history.starts_with("time [") && history.lines().count() > 10, "{history}");
    let whole = run(crumple_with(&[&TWICE[..], &more].concat())).with_code(0);
    assert_eq!(digest_of(&out), whole.digest());
}

/// A pipe in place of a manifest blocks whoever reads it: the start of a run that continues ends
/// with a message, after the time that the command line gives.
#[test]
fn a_checkpoint_on_a_disk_that_hangs_ends_the_start_with_a_message() {
    let (known, _) = whole();
    let (_copy, out, newest) = copy_of(&known);
    fs::remove_file(newest.join("MANIFEST")).unwrap();
    let Some(()) = fifo(&newest.join("MANIFEST")) else { return };
    let patience = "--set=checkpoint.patience=0.3 s";
    let ended = run(crumple_with(&["run", "--resume", out.to_str().unwrap(), patience]));
    let said = ended.with_code(2).said().to_string();
    for text in ["MANIFEST: no answer", "it hangs, and the program ends"] {
        assert!(said.contains(text), "{text}: {said}");
    }
}

/// Changes the words of a file, and the manifest so that the sums are right.
fn rewrite(folder: &Path, name: &str, change: fn(&mut Vec<u64>)) {
    let mut words = decode(&fs::read(folder.join(name)).unwrap()).unwrap();
    change(&mut words);
    let bytes = encode(&words, Compression::None).unwrap();
    fs::write(folder.join(name), &bytes).unwrap();
    let mut manifest = Manifest::read(folder).unwrap();
    let files = [&mut manifest.common].into_iter().chain(&mut manifest.pieces);
    for file in files.filter(|file| file.name == name) {
        file.bytes = bytes.len() as u64;
        file.blake3 = blake3::hash(&bytes).to_hex().to_string();
    }
    manifest.write(folder).unwrap();
}

/// A new run does not remove the checkpoints of an unfinished one without being asked.
#[test]
fn a_folder_with_an_unfinished_run_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut running = start(with(&out, &[]));
    running.wait_for("the first checkpoint is there", |_| {
        (checkpoints(&out).len() == 1).then_some(())
    });
    running.signal(rustix::process::Signal::TERM);
    running.end().with_code(130);
    let before = checkpoints(&out);
    let refused = run(with(&out, &[])).with_code(2);
    for text in ["did not complete", "--resume", "--overwrite"] {
        assert!(refused.said().contains(text), "{}", refused.said());
    }
    assert_eq!(checkpoints(&out), before);
    run(with(&out, &["--overwrite"])).with_code(0);
    let refused = run(with(&out, &[])).with_code(2); // also the results of a complete run
    assert!(refused.said().contains("has the results of a run"), "{}", refused.said());
}
