//! Changes of the model when a run continues: parts that are deleted or become rigid, new
//! velocities, new walls. Mass and momentum are those of what remains, and no bit depends on the
//! workers.

use crumple_tests::program::{Ended, crumple_with, numbers, run};
use crumple_tests::restart::{checkpoints, copy_folder};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

/// Two bodies in contact, stopped after 300 cycles with a checkpoint near its end.
static BEGUN: LazyLock<Ended> = LazyLock::new(|| {
    let words = [
        "run",
        "cases/tumble",
        "--no-report",
        "--workers=2",
        "--set=time.max_cycles=300",
        "--set=checkpoint.at=[0.4]",
    ];
    run(crumple_with(&words)).with_code(0)
});

/// A run that continued with changes.
struct Continued {
    summary: Value,
    /// Rows of `parts.csv`: time, part, mass, momentum.
    parts: Vec<(f64, u32, f64, [f64; 3])>,
    _folder: tempfile::TempDir,
}

fn continued(workers: &str, sets: &[&str]) -> Continued {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    copy_folder(&BEGUN.out(), &out);
    let mut words = vec!["run", "--resume", out.to_str().unwrap(), "--no-report"];
    words.extend(["--workers", workers, "--set=time.max_cycles=360"]);
    words.extend(sets.iter().flat_map(|set| ["--set", set]));
    run(crumple_with(&words)).with_code(0);
    let summary = fs::read_to_string(out.join("summary.json")).unwrap();
    Continued {
        summary: serde_json::from_str(&summary).unwrap(),
        parts: parts(&out),
        _folder: folder,
    }
}

fn parts(out: &Path) -> Vec<(f64, u32, f64, [f64; 3])> {
    let text = fs::read_to_string(out.join("parts.csv")).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<f64>().unwrap();
        (number(0), cells[1].parse().unwrap(), number(3), [number(7), number(8), number(9)])
    };
    text.lines().skip(1).map(row).collect()
}

/// Runs with changes on several numbers of workers: all bits are equal, and the changes are in the
/// summary.
fn on_any_workers(sets: &[&str]) -> Continued {
    let one = continued("1", sets);
    for workers in ["2", "3"] {
        let other = continued(workers, sets);
        assert_eq!(one.summary["state_digest"], other.summary["state_digest"], "{workers}");
        assert_eq!(one.parts, other.parts, "{workers}");
    }
    let known = one.summary["restarts"][0]["changes"].to_string();
    for set in sets {
        let key = set.split('=').next().unwrap();
        assert!(known.contains(key), "{key} is in {known}");
    }
    one
}

fn error(of: &Continued) -> f64 {
    of.summary["energy"]["error"].as_f64().unwrap().abs()
}

#[test]
fn a_deleted_part_takes_its_mass_and_momentum_with_it() {
    let plain = on_any_workers(&[]);
    let without = on_any_workers(&["restart.delete=[5]"]);
    assert_ne!(plain.summary["state_digest"], without.summary["state_digest"]);
    let last = |run: &Continued| {
        let end = run.parts.last().unwrap().0;
        run.parts.iter().filter(|row| row.0 == end).copied().collect::<Vec<_>>()
    };
    for (with, now) in last(&plain).iter().zip(&last(&without)) {
        let mass = if now.1 == 5 { 0.0 } else { with.2 };
        assert_eq!((now.1, now.2), (with.1, mass), "mass of part {}", now.1);
    }
    // The momentum of what remains, from the state before the change. Contact with the deleted part
    // is over, and that of the others exchanges momentum among them.
    let begun: Vec<_> = parts(&BEGUN.out());
    let at = begun.iter().filter(|row| row.0 < 0.4).map(|row| row.0).fold(0.0, f64::max);
    let rest = begun.iter().filter(|row| row.0 == at && row.1 != 5);
    let rest = rest.fold([0.0; 3], |p, row| std::array::from_fn(|c| p[c] + row.3[c]));
    let touched: [f64; 3] = {
        let five = |run: &[(f64, u32, f64, [f64; 3])], from: f64| {
            run.iter().find(|row| row.1 == 5 && row.0 >= from).unwrap().3
        };
        let (then, later) = (five(&begun, at), five(&begun, at + 0.04));
        std::array::from_fn(|c| (later[c] - then[c]).abs())
    };
    let end = numbers(&without.summary["momentum"]["end"]);
    for c in 0..3 {
        let most = 1e-9 * rest.iter().map(|p| p.abs()).sum::<f64>() + touched[c];
        assert!((end[c] - rest[c]).abs() <= most, "{end:?} and {rest:?}, {touched:?}");
    }
    assert!(error(&without) < 1e-3, "the balance goes on: {}", error(&without));
}

#[test]
fn a_part_that_becomes_rigid_keeps_mass_and_momentum() {
    let plain = on_any_workers(&[]);
    let rigid = on_any_workers(&["restart.rigid=[5]"]);
    assert_ne!(plain.summary["state_digest"], rigid.summary["state_digest"]);
    let [a, b] = [&plain, &rigid].map(|run| numbers(&run.summary["momentum"]["end"]));
    let size = a.iter().map(|p| p.abs()).sum::<f64>();
    (0..3).for_each(|c| assert!((a[c] - b[c]).abs() < 1e-9 * size, "{a:?} and {b:?}"));
    assert!(error(&rigid) < 1e-3, "the balance goes on: {}", error(&rigid));
}

#[test]
fn a_new_velocity_is_that_of_all_nodes_of_the_part() {
    let moved = on_any_workers(&["restart.velocity=[{parts=[5], velocity=[0.5, 0.0, 40.0]}]"]);
    let row = moved.parts.iter().find(|row| row.1 == 5 && row.0 > 0.41).unwrap();
    // A plate that flies: contact has changed its momentum by less than a hundredth since then.
    let speed = row.3.map(|p| p / row.2);
    assert!((speed[2] - 40.0).abs() < 0.4 && (speed[0] - 0.5).abs() < 0.4, "{speed:?}");
    assert!(error(&moved) < 1e-3, "the balance goes on: {}", error(&moved));
}

#[test]
fn a_new_wall_stops_what_hits_it() {
    let wall = "restart.wall=[{name=\"late\", point=[0.0, 0.0, -116.0], normal=[0.0, 0.0, 1.0]}]";
    let all = "restart.velocity=[{parts=[1,2,3,4,5,6,7], velocity=[0.0, 0.0, -100.0]}]";
    let held = on_any_workers(&[wall, all]);
    let impulse = numbers(&held.summary["momentum"]["wall_impulse"]);
    assert!(impulse[2] > 0.0, "{impulse:?}");
    let time = held.parts.last().unwrap().0;
    let mass: f64 = held.parts.iter().filter(|row| row.0 == time).map(|row| row.2).sum();
    let start = [0.0, 0.0, -100.0 * mass];
    let end = numbers(&held.summary["momentum"]["end"]);
    let size = start.iter().chain(&impulse).map(|p| p.abs()).sum::<f64>();
    for c in 0..3 {
        let off = end[c] - start[c] - impulse[c];
        assert!(off.abs() < 1e-9 * size, "{off}: momentum changes by the impulse of the wall");
    }
}

#[test]
fn changes_that_are_not_possible_are_refused() {
    let refused = |sets: &[&str], text: &str| {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        copy_folder(&BEGUN.out(), &out);
        let mut words = vec!["run", "--resume", out.to_str().unwrap(), "--no-report"];
        words.extend(sets.iter().flat_map(|set| ["--set", set]));
        let said = run(crumple_with(&words)).with_code(2).said();
        assert!(said.contains(text), "{sets:?}: {said}");
    };
    refused(&["restart.delete=[77]"], "there is no part 77");
    refused(&["restart.delete=[5]", "restart.rigid=[5]"], "also deleted");
    let moving = "restart.wall=[{point=[0,0,0], normal=[0,0,1], velocity=[0,0,1]}]";
    refused(&[moving], "prescribed motion");
    refused(&["restart.velocity=[{parts=[], velocity=[0.0, 0.0, 1.0]}]"], "names no parts");
    let fresh = ["run", "cases/tumble", "--set", "restart.delete=[5]", "--no-report"];
    let said = run(crumple_with(&fresh)).with_code(2).said();
    assert!(said.contains("--resume"), "{said}");
}

/// A wall with nodes behind it is found by the workers. The folder stays as it was: the summary,
/// the histories and the later checkpoint are there, and the run continues without the wall.
#[test]
fn a_wall_with_nodes_behind_it_is_refused_and_nothing_is_changed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    copy_folder(&BEGUN.out(), &out);
    let first = out.join("checkpoints").join(&checkpoints(&out)[0]);
    let later = out.join("checkpoints").join("cycle_0000000999");
    copy_folder(&first, &later);
    let files = ["summary.json", "history.csv", "parts.csv", "fields/fields.pvd"];
    let texts = || files.map(|name| fs::read_to_string(out.join(name)).unwrap());
    let (before, digest) = (texts(), BEGUN.digest());
    let from = first.to_str().unwrap();
    for workers in ["--workers=1", "--workers=3"] {
        let wall = "--set=restart.wall=[{point=[0.0, 0.0, 20.0], normal=[0.0, 0.0, 1.0]}]";
        let said = run(crumple_with(&["run", "--resume", from, "--no-report", workers, wall]));
        let said = said.with_code(2).said();
        assert!(said.contains("behind the new wall "), "{said}");
        assert_eq!(texts(), before);
        assert!(later.join("MANIFEST").exists());
    }
    let said = run(crumple_with(&["run", "--resume", from, "--no-report"])).with_code(0);
    assert!(said.said().contains("later checkpoint cycle_0000000999 was removed"));
    assert!(!later.exists());
    let summary = fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(summary.contains(&digest), "the run continues");
}

/// A second continuation names the velocity of the first one and adds another. Only the new one is
/// applied.
#[test]
fn a_velocity_is_set_once() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    copy_folder(&BEGUN.out(), &out);
    let speed = |part: u32| {
        let rows = parts(&out);
        let last = rows.iter().rev().find(|row| row.1 == part).unwrap();
        last.3[2] / last.2
    };
    let go_on = |cycles: &str, velocity: &str| {
        let (cycles, velocity) = (format!("time.max_cycles={cycles}"), velocity.to_string());
        let sets =
            ["--set", &cycles, "--set", &velocity, "--set=checkpoint.at=[0.4, 0.6, 0.7, 0.8]"];
        let words = ["run", "--resume", out.to_str().unwrap(), "--no-report"];
        run(crumple_with(&[&words[..], &sets].concat()))
    };
    let one = "{parts=[5], velocity=[0.0, 0.0, 40.0]}";
    go_on("450", &format!("restart.velocity=[{one}]")).with_code(0);
    let first = speed(5);
    let two = format!("restart.velocity=[{one}, {{parts=[6], velocity=[0.0, 0.0, 60.0]}}]");
    go_on("600", &two).with_code(0);
    assert_ne!(speed(5), 40.0);
    assert!(
        (speed(5) - first).abs() < 4.0 && (speed(6) - 60.0).abs() < 6.0,
        "{first} {}",
        speed(6)
    );
    let said = go_on("650", "restart.velocity=[]").with_code(2).said();
    assert!(said.contains("has to begin with the 2 entries"), "{said}");
}
