//! Accelerometers: the motion of a node in the axes of three nodes. Units mm, ms, kg.

use super::base::{BASE, MOVES, STEEL, assert_refused, assert_same_when_written, with};
use crumple::input::job::{Model, read};
use crumple_tests::program::{crumple_with, run};
use std::fs;

/// A rigid cube that spins about z through its centre at 1 rad/ms, and a plate at rest, which sets
/// the step. The first axis of the accelerometer points from corner 1 of the cube through the
/// centre to corner 3.
const SPINNING: &str = "*KEYWORD\n*CONTROL_TERMINATION\n4.0\n*PART\ncube\n1,1,1\nplate\n2,2,2\n\
    *SECTION_SOLID\n1,1\n*SECTION_SHELL\n2,2\n1,1,1,1\n*MAT_RIGID\n1,7.85e-6,207.0,0.3\n\
    *MAT_ELASTIC\n2,7.85e-6,207.0,0.3\n*NODE\n1,0,0,0\n2,10,0,0\n3,10,10,0\n\
    4,0,10,0\n5,0,0,10\n6,10,0,10\n7,10,10,10\n8,0,10,10\n\
    11,20,0,0\n12,30,0,0\n13,40,0,0\n14,20,10,0\n15,30,10,0\n16,40,10,0\n\
    *ELEMENT_SHELL\n1,2,11,12,15,14\n2,2,12,13,16,15\n\
    *ELEMENT_SOLID\n11,1,1,2,3,4,5,6,7,8\n\
    *INITIAL_VELOCITY_GENERATION\n1,2,1.0,0,0,0,0,0\n5,5,5,0,0,1,0\n\
    *ELEMENT_SEATBELT_ACCELEROMETER\n7,1,3,2,0,0,0\n*DATABASE_HISTORY_NODE\n1\n";

/// In the axes of the cube its corner has the constant acceleration of the rotation towards the
/// centre and a constant velocity across; in global axes both turn. The digits are the same on any
/// number of workers.
#[test]
fn a_spinning_accelerometer_measures_constant_values() {
    let folder = tempfile::tempdir().unwrap();
    let deck = folder.path().join("deck.k");
    fs::write(&deck, format!("{SPINNING}*END\n")).unwrap();
    let files = ["1", "2"].map(|workers| {
        let sets = ["--set", "output.field_interval=-1", "--set", "time.max_cycles=2000"];
        let args = ["run", deck.to_str().unwrap(), "--workers", workers];
        let ended = run(crumple_with(&[&args[..], &sets].concat())).with_code(0);
        fs::read_to_string(ended.out().join("nodes.csv")).unwrap()
    });
    assert_eq!(files[0], files[1]);
    let rows: Vec<Vec<&str>> = files[0].lines().skip(1).map(|l| l.split(',').collect()).collect();
    let radius = 50.0f64.sqrt();
    let last = rows.last().unwrap()[0];
    let (mut seen, mut turned) = (0, 0.0f64);
    for row in &rows {
        let numbers: Vec<f64> = row[3..].iter().map(|n| n.parse().unwrap()).collect();
        let [v, a] = [&numbers[6..9], &numbers[9..12]];
        if row[1] != "accelerometer 7" {
            turned = turned.max((a[0] - a[1]).abs());
            continue;
        }
        seen += 1;
        // A step turns the cube by dt = 1.54e-3 rad; values of a rotation in steps are smaller by
        // the fraction dt^2/4 = 6e-7.
        let near = |value: f64, wanted: f64, tolerance: f64| {
            assert!((value - wanted).abs() < tolerance * radius, "{row:?}");
        };
        // At the ends of the run there is no step on one side: these rows are half a step off.
        let tolerance = if ["0.000000000e0", last].contains(&row[0]) { 2e-3 } else { 1e-6 };
        near(a[0], radius, tolerance);
        near(a[1], 0.0, tolerance);
        near(v[0], 0.0, tolerance);
        near(v[1], radius, tolerance);
        near(v[2], 0.0, 1e-12);
    }
    assert!(seen > 100 && turned > radius, "{seen} {turned}");
}

/// The mass is divided among the three nodes; other fields do not change the model.
#[test]
fn the_mass_goes_to_the_nodes() {
    let model = with("*ELEMENT_SEATBELT_ACCELEROMETER\n5,11,12,14,1,1,0.03\n6,12,13,15\n");
    let [mass] = &model.job.mass[..] else { panic!("{:?}", model.job.mass) };
    assert_eq!((mass.mass, mass.nodes.as_str()), (0.03, "accelerometer 5"));
    let names: Vec<_> = model.job.output.node.iter().map(|n| (n.name.as_str(), n.axes)).collect();
    let axes = [Some([11, 12, 14]), Some([12, 13, 15])];
    assert_eq!(names, [("accelerometer 5", axes[0]), ("accelerometer 6", axes[1])]);
    let said = format!("{:?}", model.warnings);
    assert!(said.contains("igrav") && said.contains("intopt"), "{said}");
    assert_eq!(model.mesh.node_sets["accelerometer 5"].len(), 3);
}

/// A written deck has the same bits, and the same histories and masses.
#[test]
fn accelerometers_are_written() {
    assert_same_when_written(SPINNING, "time.max_cycles=40", "*ELEMENT_SEATBELT_ACCELEROMETER");
    let folder = tempfile::tempdir().unwrap();
    let [from, to] = ["from.k", "to.k"].map(|name| folder.path().join(name));
    let more = "*ELEMENT_SEATBELT_ACCELEROMETER\n5,11,12,14,0,0,0.03\n6,12,13,15\n";
    fs::write(&from, format!("{BASE}{STEEL}{MOVES}{more}*END\n")).unwrap();
    let paths = [&from, &to].map(|path| path.to_str().unwrap());
    run(crumple_with(&["export-deck", paths[0], "--out", paths[1]])).with_code(0);
    let [ours, theirs] =
        [&from, &to].map(|path| read(path, &[]).unwrap_or_else(|report| panic!("{report}")));
    let histories = |model: &Model| {
        let all = model.job.output.node.iter();
        all.map(|n| (n.name.clone(), n.ids.clone(), n.axes)).collect::<Vec<_>>()
    };
    assert_eq!(histories(&ours), histories(&theirs));
    assert_eq!(histories(&ours).len(), 2);
    let masses = |model: &Model| model.job.mass.iter().map(|m| m.mass).collect::<Vec<_>>();
    assert_eq!((masses(&ours), masses(&theirs)), (vec![0.03], vec![0.03]));
}

/// Nodes on one line have no axes, and nodes have to be there.
#[test]
fn wrong_accelerometers_are_refused() {
    let absent = SPINNING.replace("7,1,3,2,0,0,0", "7,1,3,99");
    assert_refused(&absent, &["axes of a history name node 99", "deck.k", "7,1,3,99"]);
    let line = SPINNING.replace("7,1,3,2,0,0,0", "7,11,12,13");
    assert_refused(&line, &["11, 12 and 13", "one line"]);
}
