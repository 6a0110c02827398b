//! Files as they come: other encodings, text around the cards, missing cards, foreign paths,
//! encrypted parts.

use super::base::{BASE, MOVES, STEEL, with};
use crumple::input::job::{Model, read};
use std::fs;

fn reading(text: &[u8], sets: &[&str]) -> Result<Model, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, text).unwrap();
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    read(&path, &sets).map_err(|report| report.to_string())
}

fn plain() -> String {
    format!("{BASE}{STEEL}{MOVES}*END\n")
}

fn passes(text: &[u8]) -> Model {
    reading(text, &[]).unwrap_or_else(|report| panic!("{report}"))
}

/// Byte order marks, UTF-16 and Latin-1.
#[test]
fn encodings_of_other_systems_are_read() {
    let text = plain().replace("plate", "Tür");
    let units: Vec<u16> = text.encode_utf16().collect();
    let little: Vec<u8> =
        [0xff, 0xfe].into_iter().chain(units.iter().flat_map(|u| u.to_le_bytes())).collect();
    let big: Vec<u8> =
        [0xfe, 0xff].into_iter().chain(units.iter().flat_map(|u| u.to_be_bytes())).collect();
    let marked = [b"\xef\xbb\xbf", text.as_bytes()].concat();
    for bytes in [little, big, marked] {
        let model = passes(&bytes);
        assert_eq!(model.job.part[0].name, "Tür");
        assert!(model.warnings.iter().all(|w| !w.message.contains("no *KEYWORD")));
    }
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    assert_eq!(passes(&latin).job.part[0].name, "T?r");
}

/// *KEYWORD_ID is followed by the name of the project.
#[test]
fn the_name_of_the_project_is_no_card() {
    for head in ["*KEYWORD_ID\nproject one\n", "*KEYWORD_JOBID\nname\n"] {
        let model = passes(plain().replace("*KEYWORD\n", head).as_bytes());
        assert!(model.warnings.iter().all(|w| !w.message.contains("KEYWORD")), "{head}");
    }
}

/// Text before the first keyword of a deck without *KEYWORD is not read; numbers there are a
/// mistake.
#[test]
fn text_before_the_first_keyword_is_no_card() {
    let bare = plain().replace("*KEYWORD\n", "");
    let model = passes(format!("a deck by hand\n{bare}").as_bytes());
    assert!(model.warnings.iter().any(|w| w.message == "text precedes the first keyword"));
    let report = reading(format!("1 2.0\n{bare}").as_bytes(), &[]).err().unwrap();
    assert!(report.contains("a card precedes the first keyword"), "{report}");
}

/// Cards at the end of a keyword whose fields all have defaults may be missing.
#[test]
fn missing_cards_at_the_end_are_blank() {
    let contact = with("*CONTACT_AUTOMATIC_SINGLE_SURFACE\n0,0,5\n").job.contact.unwrap();
    assert_eq!((contact.friction, contact.thickness_scale), (0.0, 1.0));
    with("*CONTROL_SHELL\n*CONTROL_CONTACT\n*DAMPING_GLOBAL\n*CONTROL_TIMESTEP\n");
}

/// An encrypted part is an error that names the cure, and can be left out.
#[test]
fn encrypted_parts_are_named() {
    let secret = "*DEFINE_CURVE\n7\n-----BEGIN PGP MESSAGE-----\nVersion: 2\n\nhQEMA5+x,1/\n*=ab\n\
                  -----END PGP MESSAGE-----\n0.0,0.0\n1.0,1.0\n";
    let text = plain().replace("*END", &format!("{secret}*END"));
    let report = reading(text.as_bytes(), &[]).err().expect("it is refused");
    assert!(report.contains("encrypted by PGP") && report.contains("1 error"), "{report}");
    reading(text.as_bytes(), &["mesh.allow_unsupported=true"]).unwrap_or_else(|r| panic!("{r}"));
}

/// A path of another machine is looked up next to the deck.
#[test]
fn paths_of_other_machines_are_found_next_to_the_deck() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("law.k"), format!("*KEYWORD\n{STEEL}*END\n")).unwrap();
    let path = folder.path().join("deck.k");
    for name in ["C:\\models\\car\\law.k", "/home/someone/law.k"] {
        fs::write(&path, format!("{BASE}{MOVES}*INCLUDE\n{name}\n*END\n")).unwrap();
        let model = read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
        assert!(model.warnings.iter().any(|w| w.message.contains("is not there")), "{name}");
    }
}

/// The id line of a solid may be padded with zeros; solids of ten nodes are not read as eight.
#[test]
fn solids_on_two_lines_may_have_zeros_on_the_first() {
    let old = "1,2,1,2,3,4,5,6,7,8\n";
    let two = plain().replace(old, "1,2,0,0,0,0,0,0,0,0\n1,2,3,4,5,6,7,8,0,0\n");
    assert_eq!(passes(two.as_bytes()).mesh.elements, passes(plain().as_bytes()).mesh.elements);
    let fixed = plain().replace(
        old,
        "       1       2       0       0       0       0       0       0       0       0\n\
         \x20      1       2       3       4       5       6       7       8\n",
    );
    assert_eq!(passes(fixed.as_bytes()).mesh.elements, passes(plain().as_bytes()).mesh.elements);
    for first in ["1,2\n", "1,2,0,0,0,0,0,0,0,0\n"] {
        let ten = plain().replace(old, &format!("{first}1,2,3,5,4,6,7,8,11,12\n"));
        let report = reading(ten.as_bytes(), &[]).err().expect("its nodes are those of a cube");
        assert!(report.contains("is inverted or twisted"), "{report}");
    }
    let eight = plain().replace("1,1,11,12,15,14\n", "1,1,11,12,15,14,1,2,3,4\n");
    let report = reading(eight.as_bytes(), &[]).err().expect("it is refused");
    assert!(report.contains("has nodes n5 to n8"), "{report}");
}

/// Lines whose numbers are one column too far right, or cross the border of their columns, are read
/// as meant, with a warning. Where this would be a guess, they are errors.
#[test]
fn numbers_that_cross_their_columns_are_read_with_a_warning() {
    let base = plain();
    let end = |line: &str| {
        let text =
            base.replace("*CONTROL_TERMINATION\n10.0", &format!("*CONTROL_TERMINATION\n{line}"));
        reading(text.as_bytes(), &[])
    };
    let says = |model: &Model, words: &str| {
        assert!(model.warnings.iter().any(|w| w.message.contains(words)), "{:?}", model.warnings);
    };
    for (line, until) in [
        ("       10.0         0       0.0       0.01.000000E8         0", 10.0),
        ("    0.002       0      0.0     0.0     0.0", 0.002),
        ("     1.0E-3", 1.0e-3),
        ("     1.0E-3         0       0.0", 1.0e-3),
    ] {
        let model = end(line).unwrap_or_else(|report| panic!("{line}: {report}"));
        assert_eq!(model.job.end_time, until, "{line}");
        says(&model, "card 1 are not in their columns");
    }
    for line in ["     1.0E-x", "  0.002 0.0  0.0     0.0        0.0"] {
        let report = end(line).err().unwrap_or_else(|| panic!("no error: {line}"));
        assert!(report.contains("has to be a"), "{report}");
    }
    // The third word may be the third number or the fourth one.
    let wall =
        "*RIGIDWALL_PLANAR\n0\n      0.0         0.0        0.0       0.0        0.0        1.0\n";
    let report = reading(base.replace("*END", &format!("{wall}*END")).as_bytes(), &[]).err();
    assert!(report.is_some_and(|report| report.contains("check the columns")));

    let long = "*PARAMETER\nRlong      10.12345678901\n";
    let model = passes(
        base.replace("*KEYWORD\n", &format!("*KEYWORD\n{long}"))
            .replace("*CONTROL_TERMINATION\n10.0", "*CONTROL_TERMINATION\n&long")
            .as_bytes(),
    );
    assert_eq!(model.job.end_time, 10.12345678901);
    says(&model, "the value of `Rlong` has more columns than its field");
}
