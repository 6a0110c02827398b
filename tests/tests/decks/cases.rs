//! Decks with several cases.

use super::base::{BASE, MOVES, STEEL};
use crumple::input::check::describe;
use crumple::input::job::{Model, read};
use crumple::input::mesh_file;
use crumple_tests::program::{crumple_with, run};
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
        ("*CASE\nfirst\n*CASE_BEGIN_1\n*CASE_END_1\n", "`caseid` has to be a whole number"),
        ("*CASE\n,first\n", "*CASE: `caseid` of card 1 is blank"),
        ("*CASE\n0,first\n", "*CASE has the id 0"),
        ("*CASE\n-2,first\n", "the deck has keywords of cases, but no case"),
        ("*CASE\n1\n*CASE\n1\n", "case 1 is defined twice"),
        ("*CASE\n1\n\n2,x\n", "*CASE: `scid` has to be a whole number, not `x`"),
        ("*CASE\n1\n1 9\n", "case 1: its subcases are not in their columns"),
        ("*TITLE CID=x\na\n", "*TITLE: CID is `X`, not a number above 0"),
        ("*TITLE CID\na\n", "*TITLE: CID is ``, not a number above 0"),
        ("*TITLE CID = 0\na\n", "*TITLE: CID is `0`, not a number above 0"),
    ] {
        let report = reading(lines, &[]).err().expect("errors");
        assert!(report.contains(words), "{lines}: {report}");
    }
}

/// A keyword of cases that does not exist is an error: alone, and with real cases.
#[test]
fn unknown_keywords_of_cases_are_refused() {
    let title = "*CASE_TITLE\nall\n";
    for (lines, sets) in
        [(title.to_string(), &[][..]), (format!("{CASES}{title}"), &["mesh.case=4"])]
    {
        let report = reading(&lines, sets).err().expect("errors");
        assert!(report.contains("*CASE_TITLE is not supported"), "{report}");
    }
}

/// The cards of `*CASE` have columns, also in the long format; blanks around `=` have no effect.
#[test]
fn cards_of_cases_have_columns() {
    let curve = "*DEFINE_CURVE\n1\n0.0,1.0\n1.0,1.0\n";
    let loads = "*LOAD_BODY_X CID = 11\n1\n*LOAD_BODY_Y, cid= 12\n1\n*LOAD_BODY_Z CID =9\n1\n";
    let subcases = format!("{:>10}{:>10}", 11, 12);
    let short = format!("*CASE\n{:>10}soft one\n{subcases}\n", 1);
    let long = format!("*CASE+\n{:>20}soft one\ncommand\n{:>20}{:>20}\n", 1, 11, 12);
    for case in [short, long] {
        let model = reading(&format!("{curve}{loads}{case}"), &[]).unwrap();
        assert_eq!(gravity(&model), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "{case}");
        assert!(describe(&model).contains("case 1 (soft one) -> keywords of the subcases 11, 12"));
    }
}

/// An included file has the case of the marks around `*INCLUDE`; `CID` on its line is refused.
#[test]
fn included_files_have_the_case_of_marks() {
    let folder = tempfile::tempdir().unwrap();
    let [path, own] = ["deck.k", "own.k"].map(|name| folder.path().join(name));
    fs::write(&own, "*KEYWORD\n*LOAD_BODY_X\n1\n*END\n").unwrap();
    let curve = "*DEFINE_CURVE\n1\n0.0,1.0\n1.0,1.0\n*LOAD_BODY_Y CID=2\n1\n";
    let read_with = |include: &str| {
        fs::write(&path, format!("{BASE}{STEEL}{MOVES}{curve}{include}*END\n")).unwrap();
        read(&path, &["mesh.case=2".into()]).map_err(|report| report.to_string())
    };
    let within = read_with("*CASE_BEGIN_3\n*INCLUDE\nown.k\n*CASE_END_3\n").unwrap();
    assert_eq!(gravity(&within), [[0.0, 1.0, 0.0]]);
    for include in ["*INCLUDE CID=3\nown.k\n", "*INCLUDE_PATH CID = 3\n.\n"] {
        let report = read_with(include).err().expect("errors");
        assert!(report.contains("CID is not supported here"), "{report}");
    }
}

/// A case of a mesh without cases is an error: of a mesh file, and of a job with a generator.
#[test]
fn a_case_that_nothing_uses_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let flat = folder.path().join("plate.stl");
    fs::write(
        &flat,
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                      vertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
    )
    .unwrap();
    let problems = mesh_file::read(&flat, false, Some(2)).err().expect("errors");
    assert_eq!(problems[0].path, "mesh.case");
    let job = crumple_tests::case("bars").join("job.toml");
    let report = read(&job, &["mesh.case=2".into()]).err().expect("errors").to_string();
    assert!(report.contains("case 2 is chosen, and the mesh is not from a deck"), "{report}");
}

/// `--case` chooses on the command line.
#[test]
fn a_case_is_chosen_on_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{BASE}{STEEL}{MOVES}{CASES}*END\n")).unwrap();
    let deck = path.to_str().unwrap();
    let checked = run(crumple_with(&["check", deck, "--case", "4"])).with_code(0);
    assert!(checked.said().contains("case 4 (hard)"), "{}", checked.said());
    run(crumple_with(&["check", deck])).with_code(2);
}
