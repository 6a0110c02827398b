//! Contacts that begin as ties and fail.

use super::base::{refused, with};
use crumple::input::check::describe;
use crumple::input::job::Model;

/// The nodes of the plate above the cube.
const NODES: &str = "*SET_NODE_LIST\n7\n11,12,14,15\n";

/// Returns limits, exponents and opening of the ties of a model.
fn strengths(model: &Model) -> Vec<([f64; 2], [f64; 2], f64)> {
    let ties = model.settings.ties.iter();
    ties.map(|tie| tie.failure.as_ref().expect("it fails"))
        .map(|f| (f.limits, f.exponents, f.opening))
        .collect()
}

/// Forces on nodes, with exponents; contact of the two sides follows, except for NODES_ONLY.
#[test]
fn nodal_forces_break_ties() {
    let card = |kind: &str, limits: &str| {
        format!("{NODES}*CONTACT_TIEBREAK_NODES_{kind}\n7,2,4,3\n0.3\n,,-3.0\n{limits}\n")
    };
    let model = with(&card("TO_SURFACE", "0.5,0.4,1.5,3.0"));
    assert_eq!(strengths(&model), vec![([0.5, 0.4], [1.5, 3.0], 0.0); 4]);
    let contact = model.job.contact.as_ref().unwrap();
    assert_eq!((&contact.parts[..], &contact.against[..]), (&[1][..], &[2][..]));
    assert_eq!((contact.friction, contact.thickness), (0.3, None));
    let only = with(&card("ONLY", "0.5,1e10"));
    assert_eq!(strengths(&only), vec![([0.5, 1e10], [2.0, 2.0], 0.0); 4]);
    assert!(only.job.contact.is_none());
    assert!(refused(&card("ONLY", "0.5")).contains("sflf"));
}

/// Stresses act on the shares of the nodes of a face of 10 by 10: a quarter of it each.
#[test]
fn stresses_break_ties() {
    let card =
        |keyword: &str, limits: &str| format!("*CONTACT_{keyword}\n1,2,3,3\n\n,,-3.0\n{limits}\n");
    let surface = with(&card("TIEBREAK_SURFACE_TO_SURFACE_ID\n9,glue", "0.02,0.03"));
    assert_eq!(strengths(&surface), vec![([0.5, 0.75], [2.0, 2.0], 0.0); 4]);
    assert_eq!(surface.job.tie[0].name, "glue");
    assert!(surface.job.contact.is_some());
    let only = with(&card("TIEBREAK_SURFACE_TO_SURFACE_ONLY", "0.02,0.03"));
    assert_eq!(strengths(&only), vec![([0.5, 0.75], [2.0, 2.0], 0.0); 4]);
    assert!(only.job.contact.is_none());
    let automatic = "AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE_TIEBREAK";
    for (limits, opening) in [("2,0.02,0.03", 0.0), ("6,0.02,0.03,0.4", 0.4)] {
        let model = with(&card(automatic, limits));
        assert_eq!(strengths(&model), vec![([0.5, 0.75], [2.0, 2.0], opening); 4]);
        assert!(model.job.tie[0].offset && model.job.contact.is_some());
    }
    let turning = with(&card(automatic, "-3,0.02,0.03"));
    assert!(turning.job.tie[0].rotations);
    assert!(describe(&turning).contains("only nodes on the surface at the start are tied"));
    let never = with(&card(automatic, "1,0.02,0.03"));
    assert!(never.settings.ties.len() == 4 && never.settings.ties[0].failure.is_none());
}

/// Errors name the fields that are not supported, and those that are missing.
#[test]
fn other_options_are_refused() {
    let card =
        |keyword: &str, limits: &str| format!("*CONTACT_{keyword}\n1,2,3,3\n\n,,-3.0\n{limits}\n");
    let automatic = "AUTOMATIC_SURFACE_TO_SURFACE_TIEBREAK";
    for (keyword, limits, words) in [
        (automatic, "4,0.02,0.03", "`option` = 4 is not supported"),
        (automatic, "9,0.02,0.03,1.0,0.1,0.2", "`option` = 9 is not supported"),
        (automatic, "6,0.02,0.03", "param is 0 with option 6"),
        ("TIEBREAK_SURFACE_TO_SURFACE", "0.02,0.03,5", "`tblcid` = 5"),
        ("TIEBREAK_SURFACE_TO_SURFACE", "0.0,0.0", "has no limit"),
        ("TIEBREAK_SURFACE_TO_SURFACE", "-7.0,0.03", "`nfls` = -7 is not supported: a curve"),
        (automatic, "2,0.02,-7.0", "`sfls` = -7 is not supported: a curve"),
        (automatic, "4,-7.0,0.03", "`nfls` = -7 is not supported: a curve"),
    ] {
        let report = refused(&card(keyword, limits));
        assert!(report.contains(words), "{keyword} {limits}: {report}");
    }
}

/// Nodes that are all too far away are not tied; only contacts that can tie them later warn.
#[test]
fn distant_nodes_may_come_into_contact_later() {
    let card = |keyword: &str, limits: &str| format!("*CONTACT_{keyword}\n1,2,3,3\n\n\n{limits}\n");
    let later = with(&card("AUTOMATIC_SURFACE_TO_SURFACE_TIEBREAK", "1"));
    let words = "none of its 6 nodes is near enough";
    assert!(later.warnings.iter().any(|w| w.message.contains(words)), "{:?}", later.warnings);
    assert!(later.settings.ties.is_empty() && later.job.contact.is_some());
    let report = refused(&card("TIEBREAK_SURFACE_TO_SURFACE", "0.1,0.1"));
    assert!(report.contains(words), "{report}");
}

/// Ties of all keywords have the order of the deck.
#[test]
fn ties_are_in_the_order_of_the_deck() {
    let model = with(
        "*SET_NODE_LIST\n7\n11,12\n*SET_NODE_LIST\n8\n14,15\n*SET_NODE_LIST\n9\n5,13\n\
         *CONSTRAINED_NODE_SET\n9,7\n\
         *CONTACT_TIED_NODES_TO_SURFACE_ID\n1,lasting\n7,2,4,3\n\n,,-3.0\n\
         *CONTACT_TIEBREAK_NODES_ONLY_ID\n2,failing\n8,2,4,3\n\n,,-3.0\n0.5,0.4\n",
    );
    let names: Vec<&str> = model.job.tie.iter().map(|tie| tie.name.as_str()).collect();
    assert_eq!(names, ["", "lasting", "failing"]);
    assert_eq!(model.job.tie[0].node, Some(5));
}
