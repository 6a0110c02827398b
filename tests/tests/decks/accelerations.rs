//! `*LOAD_BODY_GENERALIZED`: gravity of nodes and of parts. Units mm, ms, kg.

use super::base::{BASE, MOVES, STEEL, assert_refused, assert_same_when_written, with};
use super::fates::said;

const CURVE: &str = "*DEFINE_CURVE\n5\n0,9.81e-3\n10,9.81e-3\n";

fn gravity(keyword: &str, first: &str, lines: &str) -> String {
    format!("{CURVE}*LOAD_BODY_GENERALIZED{keyword}\n{first}\n0,0,1.0,0,0,0\n{lines}")
}

/// Bodies accelerate against their frame: all of them, those of a set, of a range or of parts.
#[test]
fn gravity_acts_on_the_parts_of_its_nodes() {
    let plate = "*SET_NODE_LIST\n9\n11,12,13,14,15,16\n";
    let all = "*SET_NODE_GENERAL\n9\nALL\n";
    for (keyword, first, lines, parts) in [
        ("_SET_NODE", "9,0,5", plate, vec![1]),
        ("_SET_NODE", "9,0,5", all, vec![]),
        ("", "1,8,5", "", vec![2]),
        ("_SET_PART", "9,0,5", "*SET_PART_LIST\n9\n2\n", vec![2]),
    ] {
        let model = with(&gravity(keyword, first, lines));
        let [own] = &model.job.gravity[..] else { panic!("one load: {keyword}") };
        assert_eq!((own.acceleration, &own.parts), ([0.0, 0.0, -1.0], &parts), "{keyword}");
        assert_eq!(own.curve.as_deref(), Some("curve-5"));
        let words = "as of *LOAD_BODY";
        assert!(said(&model).contains(words), "{}", said(&model));
    }
    // Along the axes of a system, and on nodes that two parts share.
    let turned = "*DEFINE_COORDINATE_SYSTEM\n3,0,0,0,0,1,0\n-1,0,0\n\
                  *LOAD_BODY_GENERALIZED_SET_PART\n9,0,5\n1.0,0,0,0,0,0,3\n*SET_PART_LIST\n9\n2\n";
    let model = with(&format!("{CURVE}{turned}"));
    assert_eq!(model.job.gravity[0].acceleration, [0.0, -1.0, 0.0]);
    let shared = "*SET_NODE_LIST\n9\n11,12,13,14,15,16\n*PART\nmore\n3,1,1\n\
                  *NODE\n17,30,0,12\n18,30,10,12\n*ELEMENT_SHELL\n3,3,13,17,18,16\n";
    // Those and lumped masses are masses of nodes.
    let heavy = format!("{plate}*ELEMENT_MASS\n1,11,0.5\n");
    for lines in [shared, &heavy] {
        let model = with(&gravity("_SET_NODE", "9,0,5", lines));
        let [own] = &model.job.gravity[..] else { panic!("one load") };
        assert_eq!((own.nodes.as_deref(), own.parts.len()), (Some("set-9"), 0), "{lines}");
    }
}

/// Gravity of some nodes acts on their masses, those of elements and lumped ones; written as a
/// deck it is the same.
#[test]
fn gravity_of_some_nodes_acts_on_their_masses() {
    let some = "*SET_NODE_LIST\n9\n11,12\n*ELEMENT_MASS\n1,11,0.5\n";
    for (keyword, first, name) in [("_SET_NODE", "9,0,5", "set-9"), ("", "11,12,5", "nodes-11-12")]
    {
        let lines = gravity(keyword, first, some);
        let model = with(&lines);
        assert_eq!(model.job.gravity[0].nodes.as_deref(), Some(name));
        let shares = model.settings.loads.gravity[0].shares.clone().expect("some nodes");
        let labels: Vec<_> = shares.iter().map(|(id, share)| (id.label(), *share)).collect();
        assert_eq!(labels, [(11, 1.0), (12, 1.0)]);
        let base = format!("{BASE}{STEEL}{MOVES}{lines}");
        let words = "*LOAD_BODY_GENERALIZED_SET_NODE";
        assert_same_when_written(&base, "end_time=0.2", words);
    }
    let none = gravity("", "90,99,5", "*NODE\n95,0,0,0\n");
    let all = said(&with(&none));
    assert!(all.contains("none of its nodes has a mass"), "{all}");
}

/// A rotating frame is refused.
#[test]
fn rotating_frames_are_refused() {
    let based = |lines: &str| format!("{BASE}{STEEL}{MOVES}{lines}");
    let turns = format!("{CURVE}*LOAD_BODY_GENERALIZED\n1,8,5\n0,0,1.0,0,0,2.0\n");
    assert_refused(&based(&turns), &["`omz` = 2", "a rotating frame of reference"]);
}
