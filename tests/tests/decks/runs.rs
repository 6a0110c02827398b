//! Runs of decks: walls, springs and requested histories, on any number of workers. Units mm,
//! ms, kg, so kN and J.

use crumple_tests::program::{Ended, crumple_with, run};
use std::collections::BTreeSet;
use std::fs;

/// Returns the header and the rows of a history, as texts.
fn table(ended: &Ended, name: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let text = fs::read_to_string(ended.out().join(name))
        .unwrap_or_else(|e| panic!("{name}: {e}: {}", ended.said()));
    let mut lines = text.lines().map(|line| line.split(',').map(String::from).collect());
    (lines.next().expect("a header"), lines.collect())
}

/// Returns the numbers of a column in the rows whose second field is `of`.
fn column(ended: &Ended, name: &str, of: &str, column: &str) -> Vec<f64> {
    let (header, rows) = table(ended, name);
    let at = header
        .iter()
        .position(|h| h.starts_with(column))
        .unwrap_or_else(|| panic!("no {column} in {header:?}"));
    let own = rows.iter().filter(|row| row[1] == of);
    own.map(|row| row[at].parse().expect("a number")).collect()
}

/// Runs a deck on 1, 2 and 4 workers; checks that the digests are equal and the energies
/// balance.
fn on_any_workers(deck: &str, balance: f64) -> [Ended; 3] {
    let runs = ["1", "2", "4"].map(|workers| {
        let ended = run(crumple_with(&[
            "run",
            deck,
            "--workers",
            workers,
            "--set",
            "output.field_interval=-1",
        ]));
        ended.with_code(0)
    });
    for ended in &runs {
        assert_eq!(ended.digest(), runs[0].digest(), "{deck}");
        let error = ended.summary()["energy"]["error_max"].as_f64().expect("a number");
        assert!(error < balance, "{deck}: energy error {error}");
    }
    runs
}

/// A sheet hits a sled with a mass and hangs on springs and dampers at its other end; a curve
/// moves a roller into it from below. All of them act in the same way on any number of workers,
/// and no energy is lost.
#[test]
fn walls_and_springs_of_a_deck_give_the_same_on_any_workers() {
    // The measured value was 4e-4: single nodes hit the wall with a mass, one step at a time.
    let runs = on_any_workers("tests/decks/scenes/sled.k", 1e-3);
    let [one, ..] = &runs;
    let (header, rows) = table(one, "walls.csv");
    assert_eq!(header[..3], ["time [ms]", "wall", "impulse x [kg mm/ms]"]);
    let walls: BTreeSet<&str> = rows.iter().map(|row| row[1].as_str()).collect();
    assert_eq!(walls, BTreeSet::from(["roller", "sled"]));
    assert!(rows.len() >= 2 * 50, "one row per wall and interval: {}", rows.len());
    let last = |name: &str, c: &str| *column(one, "walls.csv", name, c).last().unwrap();
    // The sled is 0.02 kg at 2 mm/ms, the sheet 9.4e-3 kg at -10 mm/ms: the sheet is stopped or
    // thrown back.
    let momentum = 7.85e-6 * 40.0 * 20.0 * 1.5 * 10.0;
    assert!(
        last("sled", "impulse x") > 0.5 * momentum,
        "{} of {momentum}",
        last("sled", "impulse x")
    );
    assert!(last("roller", "impulse z") > 0.0, "the force is upwards");
    // Its curve ends at 4 mm; the numbers have ten digits.
    assert!((last("roller", "displacement z") - 4.0).abs() < 1e-8);
    for (of, name) in [("2", "spring"), ("3", "damper")] {
        let energy = column(one, "parts.csv", of, "internal");
        assert!(energy.iter().any(|e| *e > 0.0), "the {name} absorbs energy: {energy:?}");
    }
    // Sums over workers: ten digits of the largest value.
    for several in &runs[1..] {
        for (wall, c) in [("sled", "impulse x"), ("roller", "impulse z")] {
            let (a, b) = (column(one, "walls.csv", wall, c), column(several, "walls.csv", wall, c));
            let scale = a.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            assert!(
                a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-8 * scale),
                "{wall} {c}"
            );
        }
    }
}

/// A cube on a plate: the force of a transducer on a part is the contact force on that part,
/// from either side, by parts and by segments. Its digits do not depend on the workers.
#[test]
fn transducers_of_a_deck_record_the_contact() {
    // The measured value was 2.4e-5.
    let runs = on_any_workers("tests/decks/scenes/transducers.k", 1e-4);
    let (header, rows) = table(&runs[0], "transducers.csv");
    assert_eq!(header, ["time [ms]", "transducer", "force x [kN]", "force y [kN]", "force z [kN]"]);
    assert!(
        runs.iter().all(|ended| table(ended, "transducers.csv").1 == rows),
        "the same digits for any number of workers"
    );
    for (c, sign) in ["x", "y", "z"].map(|c| [(c, 1.0), (c, -1.0)]).as_flattened() {
        let felt = |name: &str| column(&runs[0], "transducers.csv", name, &format!("force {c}"));
        let of_part = |part: &str| column(&runs[0], "contacts.csv", part, &format!("force {c}"));
        let cube = of_part("2");
        let scale = cube.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        assert!(
            *c != "z" || cube.iter().filter(|f| **f > 0.1).count() > 20,
            "the cube has contact \
            forces: {cube:?}"
        );
        let same = |a: &[f64], b: &[f64], sign: f64| {
            a.iter().zip(b).all(|(a, b)| (a - sign * b).abs() < 1e-8 * scale)
        };
        let names = if *sign > 0.0 {
            vec!["cube", "foot from plate", "transducer 4"]
        } else {
            vec!["plate from foot"]
        };
        for name in names {
            assert!(
                same(&felt(name), &cube, *sign),
                "{name} {c}: {:?}, expected {sign} times {cube:?}",
                felt(name)
            );
        }
    }
}

/// A bar at rest under a force at its end has this force in every section. A plane with the
/// opposite normal changes the sign, and so do elements on the other side.
#[test]
fn cross_sections_of_a_deck_carry_the_applied_load() {
    // The measured value was 1.6e-6.
    let [one, ..] = on_any_workers("tests/decks/scenes/sections.k", 1e-5);
    for (name, force) in [("cut", 1.0), ("disc", -1.0), ("left", -1.0)] {
        let x = *column(&one, "sections.csv", name, "force x").last().unwrap();
        // The remaining motion of the slowest mode is exp(-30 * 3); numbers have ten digits.
        assert!((x - force).abs() < 1e-8, "{name}: {x}");
        let [y, z] =
            ["force y", "force z"].map(|c| *column(&one, "sections.csv", name, c).last().unwrap());
        assert!(y.abs() < 1e-8 && z.abs() < 1e-8, "{name}: {y} {z}");
    }
    let (header, rows) = table(&one, "nodes.csv");
    assert_eq!(header[..3], ["time [ms]", "nodes", "id"]);
    let named: BTreeSet<(&str, &str)> =
        rows.iter().map(|row| (row[1].as_str(), row[2].as_str())).collect();
    assert_eq!(named, BTreeSet::from([("nodes 0", "25"), ("nodes 0", "26"), ("corner", "27")]));
}

/// Copies of a file, turned, reflected and in other units, with a motion in a window, a mean
/// motion, a part that is rigid for a while, gravity on a part and a box: the same on any number of
/// workers, and the energies balance.
#[test]
fn an_assembly_of_files_gives_the_same_on_any_workers() {
    // The measured value was 2e-4.
    let runs = on_any_workers("tests/decks/scenes/assembly.k", 1e-3);
    let walls: BTreeSet<String> =
        table(&runs[0], "walls.csv").1.into_iter().map(|row| row[1].clone()).collect();
    assert_eq!(walls.len(), 6, "{walls:?}");
}

/// The same assembly as an exported deck: the same bits, with the curve of gravity on a part.
#[test]
fn an_exported_assembly_gives_the_same_digest() {
    let deck = "tests/decks/scenes/assembly.k";
    let quiet = ["--workers", "1", "--set", "output.field_interval=-1"];
    let whole = run(crumple_with(&[&["run", deck][..], &quiet].concat())).with_code(0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("exported.k");
    let path = path.to_str().unwrap();
    run(crumple_with(&["export-deck", deck, "--out", path])).with_code(0);
    let again = run(crumple_with(&[&["run", path][..], &quiet].concat())).with_code(0);
    assert_eq!(again.digest(), whole.digest());
}
