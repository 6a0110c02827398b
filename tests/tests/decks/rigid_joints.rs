//! Joints between rigid bodies in keyword decks, and their resistance. Units mm, ms, kg.

use crumple::input::job::{Model, Report, read};
use crumple_proto::job::JointKind;
use crumple_proto::joint::ResolvedJoint;
use std::f64::consts::TAU;
use std::fs;

/// Two rigid plates in the plane z = 0, with extra nodes 21 to 26 on a line along y at x = 15.
const BASE: &str = "*KEYWORD\n*CONTROL_TERMINATION\n1.0\n*PART\nleft\n1,1,1\nright\n2,1,1\n\
    *SECTION_SHELL\n1,2,1.0,3\n1.0\n\
    *MAT_RIGID\n1,7.85e-6,207.0,0.3\n\n\n\
    *NODE\n1,0,0,0\n2,10,0,0\n4,0,10,0\n5,10,10,0\n11,20,0,0\n12,30,0,0\n14,20,10,0\n15,30,10,0\n\
    21,15,0,0\n22,15,0,0\n23,15,8,0\n24,15,8,0\n25,15,0,4\n26,15,0,4\n31,99,0,0\n\
    *ELEMENT_SHELL\n1,1,1,2,5,4\n2,2,11,12,15,14\n\
    *CONSTRAINED_EXTRA_NODES_NODE\n1,21\n1,23\n1,25\n2,22\n2,24\n2,26\n";

fn deck(lines: &str) -> Result<Model, Report> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{BASE}{lines}*END\n")).unwrap();
    let job = folder.path().join("job.toml");
    fs::write(&job, "[mesh]\ndeck = \"deck.k\"\n[time]\ndt_max = 0.01\n").unwrap();
    read(&job, &[])
}

fn joints(lines: &str) -> Vec<ResolvedJoint> {
    deck(lines).unwrap_or_else(|report| panic!("{report}")).settings.joints
}

/// Each keyword becomes its kind, at n1, along its axes.
#[test]
fn each_keyword_has_its_kind() {
    for (keyword, nodes, kind) in [
        ("SPHERICAL", "21,22", JointKind::Spherical),
        ("REVOLUTE", "21,22,23,24", JointKind::Revolute),
        ("CYLINDRICAL", "21,22,23,24", JointKind::Cylindrical),
        ("PLANAR", "21,22,23,24", JointKind::Planar),
        ("TRANSLATIONAL", "21,22,23,24,25,26", JointKind::Translational),
        ("UNIVERSAL", "21,22,23,26", JointKind::Universal),
        ("LOCKING", "21,22,23,24,25,26", JointKind::Fixed),
        ("SCREW", "21,22,23,24\n0.25", JointKind::Screw),
    ] {
        let found = joints(&format!("*CONSTRAINED_JOINT_{keyword}\n{nodes}\n"));
        let [joint] = &found[..] else { panic!("{keyword}: {found:?}") };
        assert_eq!((joint.kind, joint.first, joint.second), (kind, Some(0), 1), "{keyword}");
        assert_eq!(joint.point, [15.0, 0.0, 0.0], "{keyword}");
        if !matches!(kind, JointKind::Spherical | JointKind::Fixed) {
            assert_eq!(joint.axes[0], [0.0, 1.0, 0.0], "{keyword}");
        }
        if kind == JointKind::Universal {
            assert_eq!(joint.axes[1], [0.0, 0.0, 1.0]);
        }
        let lead = if kind == JointKind::Screw { 0.25 } else { 0.0 };
        assert!((joint.lead - lead).abs() < 1e-15, "{keyword}: {}", joint.lead);
    }
}

/// Two hinges of the same bodies have a stiffness each, as the two hinges of a door do; a third
/// stiffness has no joint.
#[test]
fn each_of_two_joints_has_a_stiffness() {
    let stiffness = |curve: u32| {
        format!("*CONSTRAINED_JOINT_STIFFNESS_GENERALIZED\n{curve},1,2,7,7\n0,{curve}\n0,0\n0,0\n")
    };
    let hinges = format!(
        "*DEFINE_COORDINATE_SYSTEM\n7,0,0,0,1,0,0\n0,1,0\n\
         *DEFINE_CURVE\n1\n-1.0,-30.0\n1.0,30.0\n*DEFINE_CURVE\n2\n-1.0,-20.0\n1.0,20.0\n\
         *CONSTRAINED_JOINT_REVOLUTE\n21,22,23,24\n*CONSTRAINED_JOINT_REVOLUTE\n21,22,23,24\n{}{}",
        stiffness(1),
        stiffness(2)
    );
    let last = |at: usize| joints(&hinges)[at].rotation.clone().expect("a stiffness").table[1];
    assert_eq!([last(0), last(1)], [[1.0, 30.0], [1.0, 20.0]]);
    let report = deck(&format!("{hinges}{}", stiffness(1))).err().expect("an error").to_string();
    assert!(report.contains("this joint has another one"), "{report}");
}

/// Resistance by the angles of a system of axes: its y axis is that of the joint, in the opposite
/// direction if the parts are named in the other order.
#[test]
fn stiffness_belongs_to_the_axis_of_the_joint() {
    let system = "*DEFINE_COORDINATE_SYSTEM\n7,0,0,0,1,0,0\n0,1,0\n\
                  *DEFINE_CURVE\n1\n-1.0,-30.0\n0.0,0.0\n2.0,10.0\n\
                  *DEFINE_CURVE\n2\n-1.0,-3.0\n1.0,3.0\n";
    let hinge = "*CONSTRAINED_JOINT_REVOLUTE_ID\n44,door\n21,22,23,24\n";
    let stiffness = |parts: &str, es: &str| {
        format!(
            "{system}{hinge}*CONSTRAINED_JOINT_STIFFNESS_GENERALIZED\n1,{parts},7,7,44\n\
             0,1,0,0,2,0\n0.0,0.0,{es},5.0\n0.0,0.0,30.0,90.0\n"
        )
    };
    let how = |parts: &str| joints(&stiffness(parts, "900.0"))[0].rotation.clone().unwrap();
    let forward = how("1,2");
    assert_eq!(forward.table, [[-1.0, -30.0], [0.0, 0.0], [2.0, 10.0]]);
    assert_eq!((forward.damping, forward.friction), (3.0, 5.0));
    assert!((forward.stops[0] + TAU / 12.0).abs() < 1e-15, "{:?}", forward.stops);
    assert!((forward.stops[1] - TAU / 4.0).abs() < 1e-15, "{:?}", forward.stops);
    let back = how("2,1");
    assert_eq!(back.table, [[-2.0, -10.0], [0.0, 0.0], [1.0, 30.0]]);
    assert!((back.stops[0] + TAU / 4.0).abs() < 1e-15, "{:?}", back.stops);
    // Without the stiffness of friction and stops, both are inactive.
    let idle = joints(&stiffness("1,2", "0.0"))[0].rotation.clone().unwrap();
    assert_eq!((idle.friction, idle.stops), (0.0, [f64::NEG_INFINITY, f64::INFINITY]));
    assert_eq!(idle.table, forward.table);
    let slider = "*CONSTRAINED_JOINT_TRANSLATIONAL\n21,22,23,24,25,26\n\
                  *CONSTRAINED_JOINT_STIFFNESS_TRANSLATIONAL\n1,1,2,7\n0,1\n0,0,5.0\n0,0,0.0,2.5\n";
    let sliding = joints(&format!("{system}{slider}"))[0].sliding.clone().unwrap();
    assert_eq!(sliding.table.len(), 3);
    assert_eq!(sliding.stops, [f64::NEG_INFINITY, 2.5]);
}

/// Joints without an id get numbers that no id of the deck has.
#[test]
fn numbers_of_joints_do_not_collide() {
    let lines = "*CONSTRAINED_JOINT_REVOLUTE_ID\n2,door\n21,22,23,24\n\
                 *CONSTRAINED_JOINT_SPHERICAL\n25,26\n*CONSTRAINED_JOINT_LOCKING\n23,24\n";
    assert_eq!(joints(lines).len(), 3);
}

/// A heading may be the name that another joint gets from its id, before or after it.
#[test]
fn names_of_joints_do_not_collide() {
    let named = "*CONSTRAINED_JOINT_SPHERICAL_ID\n5,joint-3\n25,26\n";
    let other = "*CONSTRAINED_JOINT_LOCKING_ID\n3\n23,24\n";
    for (lines, names) in [
        (format!("{named}{other}"), ["joint-3", "joint-3 (3)"]),
        (format!("{other}{named}"), ["joint-3", "joint-3 (5)"]),
    ] {
        let model = deck(&lines).unwrap_or_else(|report| panic!("{report}"));
        let found: Vec<&str> = model.job.joint.iter().map(|joint| joint.name.as_str()).collect();
        assert_eq!(found, names);
    }
}

/// An included file is read where it is included: its joints precede those that follow.
#[test]
fn joints_are_in_the_order_of_the_deck() {
    let folder = tempfile::tempdir().unwrap();
    let [path, own, job] = ["deck.k", "own.k", "job.toml"].map(|name| folder.path().join(name));
    fs::write(&own, "*KEYWORD\n*CONSTRAINED_JOINT_LOCKING_ID\n2,inner\n23,24\n*END\n").unwrap();
    let joint = |id, name| format!("*CONSTRAINED_JOINT_SPHERICAL_ID\n{id},{name}\n25,26\n");
    let lines = format!("{}*INCLUDE\nown.k\n{}", joint(1, "outer"), joint(3, "last"));
    fs::write(&path, format!("{BASE}{lines}*END\n")).unwrap();
    fs::write(&job, "[mesh]\ndeck = \"deck.k\"\n[time]\ndt_max = 0.01\n").unwrap();
    let model = read(&job, &[]).unwrap_or_else(|report| panic!("{report}"));
    let names: Vec<&str> = model.job.joint.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["outer", "inner", "last"]);
}

/// Faults name the card, the field and what to do.
#[test]
fn faults_of_joints_are_named() {
    let system = "*DEFINE_COORDINATE_SYSTEM\n7,0,0,0,1,0,0\n0,1,0\n";
    let hinge = "*CONSTRAINED_JOINT_REVOLUTE\n21,22,23,24\n";
    for (lines, wanted) in [
        ("*CONSTRAINED_JOINT_REVOLUTE\n31,22,23,24\n", "node 31 belongs to no rigid body"),
        ("*CONSTRAINED_JOINT_REVOLUTE\n21,22,21,24\n", "n1 and n3 have the same position"),
        ("*CONSTRAINED_JOINT_REVOLUTE\n21,22,77,24\n", "there is no node with the id 77"),
        ("*CONSTRAINED_JOINT_SPHERICAL\n21,23\n", "both ends are the same body"),
        ("*CONSTRAINED_JOINT_UNIVERSAL\n21,22,23,24\n", "not perpendicular"),
        ("*CONSTRAINED_JOINT_SCREW\n21,22,23,24\n0.0\n", "has no pitch"),
        ("*CONSTRAINED_JOINT_REVOLUTE\n21,22,12,24\n", "node 12 is not of the rigid body of n1"),
        (
            &format!(
                "{system}{hinge}*CONSTRAINED_JOINT_STIFFNESS_GENERALIZED\n1,1,2,7\n\n0,0,3.0,2.0\n\
                 *CONSTRAINED_JOINT_STIFFNESS_GENERALIZED\n2,1,2,7\n\n0,0,3.0,2.0\n"
            ),
            "this joint has another one",
        ),
        ("*CONSTRAINED_JOINT_GEARS\n21,22,23,24,25,26\n", "is not supported"),
        (
            &format!("{hinge}*CONSTRAINED_JOINT_STIFFNESS_GENERALIZED\n1,1,2,8\n"),
            "there is no *DEFINE_COORDINATE_... with the id 8",
        ),
        (
            &format!("{system}{hinge}*CONSTRAINED_JOINT_STIFFNESS_TRANSLATIONAL\n1,1,2,7\n"),
            "no joint of these bodies has a `sliding`",
        ),
        (
            &format!(
                "{system}{hinge}*CONSTRAINED_JOINT_STIFFNESS_GENERALIZED\n1,1,2,7\n\n3.0,2.0\n"
            ),
            "the joint is not free about this axis",
        ),
    ] {
        let report = deck(lines).err().expect(lines).to_string();
        assert!(report.contains(wanted), "{lines}\n{report}");
        assert!(report.contains("deck.k:") && report.contains("help"), "{lines}\n{report}");
    }
}
