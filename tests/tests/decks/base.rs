//! The deck of tests that add a few lines: a plate of two shells above a cube.

use crumple::input::job::{Model, read};
use crumple_proto::partition::{Material, Param};
use crumple_tests::program::{crumple_with, run};
use std::fs;

/// The plate and the cube; units mm, ms, kg. Part 1: two shells at z = 12, part 2: a solid below;
/// nodes 1 to 8 the cube, 11 to 16 the plate.
pub const BASE: &str = "*KEYWORD\n*CONTROL_TERMINATION\n10.0\n*PART\nplate\n1,1,1\ncube\n2,2,1\n\
    *SECTION_SHELL\n1,2,1.0,3\n1.0\n\
    *SECTION_SOLID\n2,1\n*NODE\n1,0,0,0\n2,10,0,0\n3,10,10,0\n4,0,10,0\n5,0,0,10\n6,10,0,10\n\
    7,10,10,10\n8,0,10,10\n\
    11,0,0,12\n12,10,0,12\n13,20,0,12\n14,0,10,12\n15,10,10,12\n16,20,10,12\n*ELEMENT_SHELL\n\
    1,1,11,12,15,14\n\
    2,1,12,13,16,15\n*ELEMENT_SOLID\n1,2,1,2,3,4,5,6,7,8\n";
pub const STEEL: &str = "*MAT_ELASTIC\n1,7.85e-6,207.0,0.3\n";
pub const MOVES: &str = "*INITIAL_VELOCITY\n0\n1.0\n";
/// Holds an end of the plate and pulls the other one.
pub const PULLED: &str = "*SET_NODE_LIST\n1\n13,16\n*BOUNDARY_PRESCRIBED_MOTION_SET\n1,1,0,7\n\
    *DEFINE_CURVE\n7\n0,0\n0.2,30\n10,30\n\
    *BOUNDARY_SPC_NODE\n11,0,1,1,1,1,1,1\n14,0,1,1,1,1,1,1\n";

pub fn model_of(text: &str) -> Model {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{text}*END\n")).unwrap();
    read(&path, &[]).unwrap_or_else(|report| panic!("{report}"))
}

/// Reads the base with an elastic material and these lines.
pub fn with(lines: &str) -> Model {
    model_of(&format!("{BASE}{STEEL}{MOVES}{lines}"))
}

/// Returns the report of a deck that has errors.
pub fn report_of(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{text}*END\n")).unwrap();
    read(&path, &[]).err().unwrap_or_else(|| panic!("no errors: {text}")).to_string()
}

/// Checks that the report of a deck has all these words.
pub fn assert_refused(text: &str, words: &[&str]) {
    let report = report_of(text);
    for word in words {
        assert!(report.contains(word), "{word}: {report}");
    }
}

/// Returns the report of the base with an elastic material and these lines, which have errors.
pub fn refused(lines: &str) -> String {
    report_of(&format!("{BASE}{STEEL}{MOVES}{lines}"))
}

/// Checks that the run of a deck has the same digest as that of the deck that is written from it,
/// which has these words.
pub fn assert_same_when_written(text: &str, until: &str, words: &str) {
    let folder = tempfile::tempdir().unwrap();
    let [from, to] = ["from.k", "to.k"].map(|name| folder.path().join(name));
    let [deck, written] = [&from, &to].map(|path| path.to_str().unwrap());
    fs::write(&from, format!("{text}*END\n")).unwrap();
    run(crumple_with(&["export-deck", deck, "--out", written])).with_code(0);
    let made = fs::read_to_string(&to).unwrap();
    assert!(made.contains(words), "{made}");
    let digest = |deck: &str| {
        let args = ["run", deck, "--set", until, "--set", "output.field_interval=-1"];
        run(crumple_with(&args)).with_code(0).digest()
    };
    assert_eq!(digest(deck), digest(written), "{text}");
}

/// Reads the base with these lines, and with `--set`.
pub fn read_with(sets: &[&str], lines: &str) -> Model {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{BASE}{STEEL}{MOVES}{lines}*END\n")).unwrap();
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    read(&path, &sets).unwrap_or_else(|report| panic!("{report}"))
}

/// Returns a deck of a cube of 10 with a material.
pub fn cube(material: &str) -> String {
    format!(
        "*KEYWORD\n*CONTROL_TERMINATION\n1.0\n*PART\nblock\n1,1,1\n*SECTION_SOLID\n1,1\n\
         *NODE\n1,0,0,0\n2,10,0,0\n3,10,10,0\n4,0,10,0\n5,0,0,10\n6,10,0,10\n7,10,10,10\n\
         8,0,10,10\n*ELEMENT_SOLID\n1,1,1,2,3,4,5,6,7,8\n{material}"
    )
}

/// Returns a parameter of a material that is a number.
pub fn number(material: &Material, key: &str) -> f64 {
    match material.parameters.get(key) {
        Some(Param::Number(value)) => *value,
        other => panic!("{key}: {other:?}"),
    }
}

/// Returns a parameter of a material that is a list.
pub fn list(material: &Material, key: &str) -> Vec<f64> {
    match material.parameters.get(key) {
        Some(Param::List(list)) => list.clone(),
        other => panic!("{key}: {other:?}"),
    }
}
