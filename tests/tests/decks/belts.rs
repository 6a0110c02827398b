//! Seat belts of LS-DYNA decks. Units mm, ms, kg.

use crate::base::{BASE, MOVES, STEEL, refused, with};
use crumple_proto::belt::{BeltSensor, BeltSystem};
use crumple_proto::ids::NodeId;
use crumple_tests::program::{crumple_with, run};
use crumple_tests::run_alone;
use std::fs;

/// Nodes of a belt: two are wound up at node 11 of the plate, where 303 is the mouth; 304 is at
/// node 12 of the plate, where the belt turns upwards.
const NODES: &str = "*NODE\n301,0,0,12\n302,0,0,12\n303,0,0,12\n310,5,0,12\n304,10,0,12\n\
    305,10,0,26\n306,10,0,40\n*ELEMENT_MASS\n9,306,2.0\n";
const PART: &str = "*PART\nwebbing\n9,9,9\n*SECTION_SEATBELT\n9,60.0,1.2\n\
    *MAT_SEATBELT\n9,6.0e-5,21,22,2.0\n\
    *DEFINE_CURVE\n21\n-1,0\n0,0\n0.02,2\n0.12,11\n*DEFINE_CURVE\n22\n0,0\n0.03,11\n";
const ELEMENTS: &str = "*ELEMENT_SEATBELT\n1,9,301,302,7\n2,9,302,303,7\n3,9,303,310\n4,9,310,304\n\
    5,9,304,305\n6,9,305,306,0,0.5\n";
const RING: &str = "*ELEMENT_SEATBELT_SLIPRING\n4,4,5,0.1,12,0,0.2\n0,0,0,0.3\n";
const REEL: &str = "*ELEMENT_SEATBELT_RETRACTOR\n7,11,3,1,2,3\n0.5,1.5,23,24,4.0\n\
    *DEFINE_CURVE\n23\n0,0.05\n50,4\n*DEFINE_CURVE\n24\n0,0\n10,4\n";
const CHARGE: &str = "*ELEMENT_SEATBELT_PRETENSIONER\n8,5,4\n7,0.25,25,2.5\n\
    *DEFINE_CURVE\n25\n0,0\n2,3\n";
const SENSORS: &str = "*ELEMENT_SEATBELT_SENSOR\n1,1\n13,3,0.5,0.2\n\
    *ELEMENT_SEATBELT_SENSOR\n2,2\n7,4.0,0.3\n*ELEMENT_SEATBELT_SENSOR\n3,3\n0.75\n\
    *ELEMENT_SEATBELT_SENSOR\n4,4\n11,306,60.0,5.0\n*DATABASE_SBTOUT\n0.1\n";

fn deck(changes: &[(&str, &str)]) -> String {
    let mut text = format!("{NODES}{PART}{ELEMENTS}{RING}{REEL}{CHARGE}{SENSORS}");
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    text
}

#[test]
fn cards_of_belts_become_paths_and_devices() {
    let model = with(&deck(&[]));
    let BeltSystem { laws, paths, rings, retractors, pretensioners, sensors } =
        &model.settings.belts;
    assert_eq!(laws[0].loading, [[0.0, 0.0], [0.02, 2.0], [0.12, 11.0]]);
    assert_eq!(laws[0].unloading, [[0.0, 0.0], [0.03, 11.0]]);
    assert_eq!((laws[0].min_length, laws[0].damping), (2.0, 0.0));
    let nodes: Vec<u64> = paths[0].nodes.iter().map(|n| n.0).collect();
    assert_eq!(nodes, [301, 302, 11, 310, 12, 305, 306]);
    assert_eq!(paths[0].loose, [true, true, false, true, false, true, false]);
    let lengths: Vec<f64> = paths[0].segments.iter().map(|s| s.length).collect();
    assert_eq!(lengths, [0.0, 0.0, 5.0, 5.0, 14.0, 14.5]);
    let [ring] = &rings[..] else { panic!("one ring") };
    assert_eq!((ring.name.as_str(), ring.node), ("slipring-4", NodeId(12)));
    assert_eq!((ring.friction, ring.decay), ([0.1, 0.2], 0.3));
    assert_eq!(ring.lock_time, f64::MAX);
    let [reel] = &retractors[..] else { panic!("one retractor") };
    assert_eq!((reel.node, reel.before, reel.fed_length), (NodeId(11), true, 4.0));
    assert_eq!((reel.delay, reel.pull_out), (0.5, 1.5));
    assert_eq!((&reel.loading[1], &reel.unloading[1]), (&[50.0, 4.0], &[10.0, 4.0]));
    assert_eq!(reel.sensors, [0, 1, 2]);
    let [charge] = &pretensioners[..] else { panic!("one pretensioner") };
    assert_eq!((charge.retractor, &charge.sensors[..], charge.delay), (0, &[3][..], 0.25));
    assert_eq!((charge.pull_in[1], charge.force_limit), ([2.0, 3.0], 2.5));
    let (direction, limit, duration) = ([0.0, 0.0, 1.0], 0.5, 0.2);
    let expected = [
        BeltSensor::Acceleration { node: NodeId(13), direction, limit, duration },
        BeltSensor::PullOutRate { retractor: 0, limit: 4.0, duration: 0.3 },
        BeltSensor::Time(0.75),
        BeltSensor::Distance { nodes: [NodeId(11), NodeId(306)], limits: [5.0, 60.0] },
    ];
    assert_eq!(sensors[..], expected);
    let mass = |node: u64| {
        let at = model.mesh.nodes.iter().position(|n| n.id == NodeId(node)).expect("a node");
        model.nodes.added_mass[at]
    };
    // Wound up elements have the fed length.
    for (node, length) in [(301, 2.0), (302, 4.0), (11, 4.5), (310, 5.0), (305, 14.25)] {
        assert!((mass(node) - 6.0e-5 * length).abs() < 1e-15, "{node}: {}", mass(node));
    }
    assert!((mass(306) - 2.0 - 6.0e-5 * 7.25).abs() < 1e-12);
}

/// Nodes of rings and retractors may be those of the belt, and a belt may have no smallest length.
#[test]
fn a_belt_may_have_the_nodes_of_its_devices() {
    let own = [("302,303,7", "302,11,7"), ("303,310", "11,310"), ("310,304", "310,12")];
    let more = [("304,305", "12,305"), ("21,22,2.0", "21,22")];
    let model = with(&deck(&[&own[..], &more[..]].concat()));
    let path = &model.settings.belts.paths[0];
    let nodes: Vec<u64> = path.nodes.iter().map(|n| n.0).collect();
    assert_eq!(nodes, [301, 302, 11, 310, 12, 305, 306]);
    assert_eq!(model.settings.belts.laws[0].min_length, 0.5);
}

/// A mass that flies away draws belt over the ring and out of the retractor, which then locks.
#[test]
fn a_deck_with_a_belt_runs() {
    let pulled = "*INITIAL_VELOCITY_NODE\n306,0,0,10\n*CONTROL_TERMINATION\n3.0\n\
                  *BOUNDARY_SPC_NODE\n11,0,1,1,1,1,1,1\n12,0,1,1,1,1,1,1\n";
    let end = run_alone(&with(&format!("{}{pulled}", deck(&[]))), |_| {});
    let records = end.constraints.belts.records();
    let [ring, reel] = &records[6..] else { panic!("six elements, a ring and a retractor") };
    assert!(reel.locked && reel.length > 1.5, "{reel:?}");
    // Belt that comes through the ring goes to its second side.
    assert!(ring.length < -1.5 && ring.tensions[1] > ring.tensions[0], "{ring:?}");
    let out = end.nodes.local_index(NodeId(302)).expect("a node");
    assert!(end.nodes.x[out as usize][0] > 0.1, "a wound up node has come out");
}

/// The commands know belts: the check counts them, the run writes their histories, exports are
/// refused.
#[test]
fn commands_know_belts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    let short = BASE.replace("*CONTROL_TERMINATION\n10.0", "*CONTROL_TERMINATION\n0.5");
    fs::write(&path, format!("{short}{STEEL}{MOVES}{}*END\n", deck(&[]))).unwrap();
    let path = path.to_str().unwrap();
    let checked = run(crumple_with(&["check", path])).with_code(0).said();
    let counts = "seat belts   1: 6 elements, 1 rings, 1 retractors, 1 pretensioners";
    assert!(checked.contains(counts), "{checked}");
    let ended = run(crumple_with(&["run", path])).with_code(0);
    let table = fs::read_to_string(ended.out().join("belts.csv")).unwrap();
    let mut lines = table.lines();
    let head = lines.next().unwrap();
    let columns = ["belt", "tension", "tension beyond", "length", "energy", "locked"];
    for (name, given) in columns.iter().zip(head.split(',').skip(1)) {
        assert!(given.starts_with(name), "{head}");
    }
    let names: Vec<&str> = lines.take(8).filter_map(|line| line.split(',').nth(1)).collect();
    assert_eq!(names[6..], ["ring slipring-4", "retractor retractor-7"], "{table}");
    let refused = run(crumple_with(&["export-deck", path]));
    assert!(refused.code != Some(0));
    let said = refused.said();
    assert!(said.contains("seat belts cannot be written as a deck"), "{said}");
}

#[test]
fn what_belts_cannot_do_is_refused() {
    for (from, to, words) in [
        ("6,9,305,306,0,0.5", "6,9,305,306,0,0.5,307,308", &["element 6 is a shell"][..]),
        ("21,22,2.0", "21,22,2.0,0,0,5.0\n1,1,1,1", &["stiffness in bending"]),
        ("8,5,4\n", "8,4,4\n", &["pretensioners other than those with a pull-in over time"]),
        ("3,3\n0.75", "3,5\n7,1.0", &["sensors of other types than 1 to 4"]),
        ("13,3,0.5", "13,4,0.5", &["directions other than 1, 2 and 3"]),
        ("4,4,5,0.1,12,0,0.2", "4,3,5,0.1,12,0,0.2", &["have no common node"]),
        ("4,4,5,0.1,12,0,0.2", "4,4,8,0.1,12,0,0.2", &["no *ELEMENT_SEATBELT with the id 8"]),
        ("4,4,5,0.1,12,0,0.2", "4,4,5,0.1,13,0,0.2", &["away from node 304 of the belt"]),
        ("0,0,0,0.3\n", "0,0,1,0.3\n", &["lets belt through in one direction"]),
        ("7,11,3,1,2,3\n", "7,11,3,1,2,3,0,9\n", &["a sensor that deactivates it"]),
        ("7,11,3,1,2,3\n", "7,11,3,1,2,6\n", &["there is no sensor `sensor-6`"]),
        ("24\n0,0\n10,4", "24\n0,0\n100,4", &["less steep than force_pull_out"]),
        ("9,9,9\n", "9,9,8\n", &["*MAT_SEATBELT"]),
        ("9,6.0e-5,21,22", "9,6.0e-5,26,22", &["no *DEFINE_CURVE with the id 26"]),
    ] {
        let report = refused(&deck(&[(from, to)]));
        for word in words {
            assert!(report.contains(word), "{word}: {report}");
        }
    }
}
