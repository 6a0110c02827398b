//! Decks with several cases.

use super::base::{BASE, MOVES, STEEL};
use crumple::input::check::describe;
use crumple::input::job::{Model, read};
use std::fs;

/// Reads the base with these lines and changes.
fn reading(lines: &str, sets: &[&str]) -> Result<Model, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{BASE}{STEEL}{MOVES}{lines}*END\n")).unwrap();
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    read(&path, &sets).map_err(|report| report.to_string())
}

/// Two cases, of subcases 1 and 9, and of 2; gravity and curve belong to subcases.
const CASES: &str = "*CASE\n1,soft\nmemory=100m\n1,9\n*CASE\n4,hard\n\n2\n\
    *CASE_BEGIN_1\n*LOAD_BODY_X\n1\n*DEFINE_CURVE\n1\n0.0,1.0\n1.0,1.0\n*CASE_END_1\n\
    *CASE_BEGIN_2\n*LOAD_BODY_Y\n1,2.0\n*CASE_BEGIN_3\n*DEFINE_CURVE\n1\n0.0,5.0\n1.0,5.0\n\
    *CASE_END_2\n*CASE_END_3\n*LOAD_BODY_Z CID=2\n1,3.0\n*TITLE CID=7\nlost\n";

/// Returns the accelerations of gravity of a model.
fn gravity(model: &Model) -> Vec<[f64; 3]> {
    model.job.gravity.iter().map(|g| g.acceleration.map(f64::abs)).collect()
}

/// A case has the keywords of its subcases, those of overlapping ones, those with CID on their
/// line, and those of none.
#[test]
fn a_case_is_chosen_by_its_number() {
    let hard = reading(CASES, &["mesh.case=4"]).unwrap();
    assert_eq!(gravity(&hard), [[0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]);
    assert_eq!(hard.job.curve[0].points[0], [0.0, 5.0], "the curve of both 2 and 3");
    assert!(describe(&hard).contains("case 4 (hard) -> keywords of the subcases 2"));
    let lost = hard.warnings.iter().any(|w| w.message == "subcase 7 belongs to no *CASE");
    assert!(lost, "{:?}", hard.warnings);
    let soft = reading(CASES, &["mesh.case=1"]).unwrap();
    assert_eq!(gravity(&soft), [[1.0, 0.0, 0.0]]);
    assert_eq!(soft.job.curve[0].points[0], [0.0, 1.0]);
    let command = soft.warnings.iter().any(|w| w.message == "case 1: its command line is not used");
    assert!(command, "{:?}", soft.warnings);
}

/// Without a choice, and with a wrong one, the error lists the cases and says how to choose.
#[test]
fn several_cases_need_a_choice() {
    for (sets, words) in [
        (&[][..], "the deck has 2 cases, and none is chosen"),
        (&["mesh.case=2"][..], "the deck has no case 2"),
    ] {
        let report = reading(CASES, sets).err().expect("errors");
        let help = "choose one with --case N, or with mesh.case = N in a job: 1 (soft), 4 (hard)";
        assert!(report.contains(words) && report.contains(help), "{report}");
        assert_eq!(report.matches("error").count(), 2, "one error and their number: {report}");
    }
    let none = reading("", &["mesh.case=2"]).err().expect("errors");
    assert!(none.contains("the deck has no cases, and case 2 is chosen"), "{none}");
}

/// Subcases without `*CASE` are cases; a single case is read without a choice.
#[test]
fn a_single_case_needs_no_choice() {
    let curve = "*DEFINE_CURVE\n1\n0.0,1.0\n1.0,1.0\n";
    let body = format!("{curve}*CASE_BEGIN_5\n*LOAD_BODY_X\n1\n*CASE_END_5\n");
    assert_eq!(gravity(&reading(&body, &[]).unwrap()), [[1.0, 0.0, 0.0]]);
    let two = format!("{body}*LOAD_BODY_Y CID=6\n1\n");
    assert!(reading(&two, &[]).err().expect("errors").contains("mesh.case = N in a job: 5, 6"));
    assert_eq!(gravity(&reading(&two, &["mesh.case=6"]).unwrap()), [[0.0, 1.0, 0.0]]);
}

/// Unbalanced marks, ids that are missing or occur twice, and subcases that are no numbers.
#[test]
fn faulty_cases_are_refused() {
    for (lines, words) in [
        ("*CASE_BEGIN_2\n*TITLE\na\n", "subcase 2 does not end"),
        ("*CASE_BEGIN_2\n*CASE_BEGIN_2\n*CASE_END_2\n", "subcase 2 begins again before it ends"),
        ("*CASE_BEGIN_1\n*CASE_END_1\n*CASE_END_3\n", "subcase 3 ends, but it has not begun"),
        ("*CASE_BEGIN\n*CASE_END_1\n*CASE\n1\n", "*CASE_BEGIN has no number of a subcase"),
        ("*CASE\nfirst\n*CASE_BEGIN_1\n*CASE_END_1\n", "*CASE has no id"),
        ("*CASE\n1\n*CASE\n1\n", "case 1 is defined twice"),
        ("*CASE\n1\n\n2,x\n", "case 1: its subcases are not numbers"),
    ] {
        let report = reading(lines, &[]).err().expect("errors");
        assert!(report.contains(words), "{lines}: {report}");
    }
}
