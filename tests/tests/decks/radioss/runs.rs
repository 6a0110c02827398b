//! Runs of Radioss decks, and conversion between formats. Units mm, ms, kg.

use super::read_at;
use crumple_tests::program::{crumple, crumple_with, root, run};
use crumple_tests::tools;
use std::fs;
use std::path::Path;
use std::process::Command;

const FEW: [&str; 5] =
    ["--set", "output.field_interval=-1", "--no-report", "--quiet", "--overwrite"];

/// Runs a job with these settings and returns the digest of its final state.
fn digest(job: &str, workers: &str, sets: &[&str]) -> String {
    let args = [&["run", job, "--workers", workers], &FEW[..], sets].concat();
    run(crumple_with(&args)).with_code(0).digest()
}

/// A tube is crushed against a wall: the deck gives the same result as the job, to the bit, on any
/// number of workers.
#[test]
fn a_crush_tube_gives_the_same_as_job_and_as_deck() {
    let job = digest("tests/decks/radioss/tube.toml", "1", &[]);
    for workers in ["1", "2", "3"] {
        assert_eq!(job, digest("tests/decks/radioss/tube_0000.rad", workers, &[]), "{workers}");
    }
}

/// Returns the keys in the comments of a deck: the list, the name or id of the entry, the key.
fn keys_in_comments(deck: &str) -> Vec<(String, String, String)> {
    let text: String = deck
        .lines()
        .filter_map(|l| l.strip_prefix("$crumple: "))
        .map(|l| l.to_string() + "\n")
        .collect();
    let rest: toml::Table = text.parse().unwrap();
    let mut found = Vec::new();
    for (list, value) in rest {
        let tables: Vec<&toml::Table> = match &value {
            toml::Value::Array(items) => items.iter().filter_map(|item| item.as_table()).collect(),
            toml::Value::Table(table) => vec![table],
            _ => Vec::new(),
        };
        for table in tables {
            let of = ["name", "id"].iter().find_map(|k| table.get(*k));
            let of = of.map_or(String::new(), |of| of.to_string());
            let keys = table.keys().filter(|key| !["name", "id"].contains(&key.as_str()));
            found.extend(keys.map(|key| (list.clone(), of.clone(), key.clone())));
        }
    }
    found
}

/// A job that is written as a Radioss deck, and an LS-DYNA deck that is written as one and back,
/// give the same result to the bit.
#[test]
fn a_converted_job_gives_the_same_digest() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let few = ["--set", "time.max_cycles=40"];
    for (job, sets) in [
        ("cases/tube-crush", &["--set", "scene.elements=4"][..]),
        ("cases/block", &[]),
        ("tests/decks/scenes/sled.k", &[]),
        ("tests/decks/scenes/bodies.toml", &[]),
    ] {
        let one = digest(job, "1", &[&few[..], sets].concat());
        let (rad, back) = (path("a_0000.rad"), path("a.k"));
        let convert = |from: &str, to: &str, sets: &[&str]| {
            let args = [&["convert", from, to, "--overwrite"], sets].concat();
            run(crumple_with(&args)).with_code(0).said()
        };
        let said = convert(job, &rad, sets);
        assert_eq!(one, digest(&rad, "1", &few), "{job} as Radioss deck\n{said}");
        let losses = fs::read_to_string(path("a_0000.losses.txt")).unwrap();
        let rest = keys_in_comments(&fs::read_to_string(&rad).unwrap());
        for (list, entry, key) in &rest {
            let listed = losses.lines().any(|l| {
                l.starts_with(&format!("- {list}")) && l.contains(entry) && l.contains(key)
            });
            assert!(listed, "{job}: {key} of {list} {entry} is lost and not listed\n{losses}");
        }
        let lost = losses.contains("no card for");
        assert_eq!(lost, !rest.is_empty(), "{job}\n{losses}");
        let said = convert(&rad, &back, &[]);
        assert_eq!(one, digest(&back, "1", &few), "{job} as LS-DYNA deck again\n{said}");
    }
}

/// A deck that is written again is the same job: the differences are on the list of losses.
#[test]
fn a_deck_that_is_written_again_is_the_same_job() {
    let folder = tempfile::tempdir().unwrap();
    let text = super::with(
        "/GRNOD/NODE/1
        =corner
        i11 i12
        /SURF/PART/1
        =all
        i1 i2
        /FUNCT/1
        =ramp
        r0 r0
        r20 r1
        /CLOAD/1
        =pull
        i1 wX i0 i0 i1 _ r1 r0.5
        /GRAV/1
        =fall
        i1 wZ i0 i0 i0 _ r1 r-0.01
        /ADMAS/1/1
        =ballast
        r0.25 i1
        /INTER/TYPE25/1
        =touch
        i1
        i0
        _
        r0 r0.1
        _
        /RWALL/PLANE/1
        =floor
        i0 i2
        r99 r0.2
        r0 r0 r-5
        r0 r0 r0",
    );
    let first = folder.path().join("first_0000.rad");
    fs::write(&first, text + "/END\n").unwrap();
    let again = folder.path().join("again_0000.rad");
    let paths = [&first, &again].map(|p| p.to_str().unwrap());
    run(crumple_with(&["convert", paths[0], paths[1]])).with_code(0);
    let [one, two] = [&first, &again].map(|p| read_at(p, &[]).unwrap());
    let shown = |model: &crumple::input::job::Model| {
        let mut job = model.job.clone();
        // Names of sets and curves follow from ids, which the writer gives.
        job.load.iter_mut().for_each(|l| (l.nodes, l.curve) = (String::new(), None));
        job.gravity.iter_mut().for_each(|g| g.curve = None);
        job.initial_velocity.iter_mut().for_each(|v| v.nodes = None);
        job.mass.iter_mut().for_each(|m| m.nodes = String::new());
        job.curve.iter_mut().for_each(|c| c.name = String::new());
        job.mesh = Default::default();
        toml::to_string(&job).unwrap()
    };
    assert_eq!(shown(&one), shown(&two));
    assert_eq!(one.mesh.elements, two.mesh.elements);
    assert_eq!(one.mesh.nodes, two.mesh.nodes);
    // It does not replace files.
    let refused = run(crumple_with(&["convert", paths[0], paths[1]])).with_code(2);
    assert!(refused.said().contains("--overwrite"), "{}", refused.said());
    let refused = run(crumple_with(&["convert", paths[0], "a.xyz"])).with_code(2);
    assert!(refused.said().contains("_0000.rad"), "{}", refused.said());
    assert!(!Path::new("a.xyz").exists());
}

/// Prints phases as a Radioss engine does; the elements take ten hours.
const OTHER_SOLVER: &str = "#!/bin/sh
set -e
test -f \"$1\"
grep -q /MON/ON \"$(echo \"$1\" | sed s/_0000/_0001/)\"
echo ' CONTACT SORTING.............: .1000E+00     0.00 %'
echo ' ELEMENT FORCES..............: .3600E+05    99.99 %'
echo ' TOTAL.......................: .3601E+05   100.00 %'
";

/// The script that times another solver: both run on the same deck, phases are compared by their
/// names, and a solver that fails is named.
#[test]
fn another_solver_is_timed_on_the_same_deck() {
    let Some(python) = tools::python("json") else { return };
    let folder = tempfile::tempdir().unwrap();
    let solver = folder.path().join("solver.sh");
    fs::write(&solver, OTHER_SOLVER).unwrap();
    let timed = |command: String| {
        let mut script = Command::new(&python);
        script.arg(root().join("deploy/peer.py")).current_dir(root());
        script.args(["cases/tube-crush", "--end-time", "0.02", "--rounds", "2"]);
        script.env("CRUMPLE_PEER", command).env("CRUMPLE_BIN", crumple());
        run(script)
    };
    let said = timed(format!("sh {} {{deck}}", solver.display())).with_code(0).said();
    let row = |name: &str| {
        let line = said.lines().find(|line| line.starts_with(&format!("| {name} |")));
        let cells = line.unwrap_or_else(|| panic!("{said}")).split('|').map(str::trim);
        cells.map(String::from).collect::<Vec<_>>()
    };
    assert_eq!(row("elements")[3], "36000.000", "{said}");
    assert!(row("elements")[4].parse::<f64>().unwrap() > 1e4, "{said}");
    assert_eq!((&row("contact search")[3][..], &row("the rest")[3][..]), ("0.100", "9.900"));
    let said = timed("false {deck}".into()).with_code(1).said();
    assert!(said.contains("the other solver ended with 1"), "{said}");
}
