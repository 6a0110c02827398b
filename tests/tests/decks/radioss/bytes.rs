//! Any content of a Radioss deck gives a model or a report.

use super::{mesh, moves, properties, steel, with};
use crate::bytes::{damaged, wound};
use crumple::input::job::read;
use proptest::prelude::*;
use std::fs;
use std::sync::LazyLock;

/// Names of all keywords, from the page that is generated from their table.
static KEYWORDS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let page = crumple::input::deck::radioss::page();
    let names = page.split('`').skip(1).step_by(2);
    names.filter(|name| name.starts_with('/') && !name.contains(' ')).map(String::from).collect()
});

/// A deck with an entity of every kind.
static PLATE: LazyLock<String> = LazyLock::new(|| {
    with(
        "/FUNCT/1
        =one
        r0 r1
        r10 r1
        /GRNOD/NODE/1
        =corner
        i11 i12
        /GRNOD/PART/2
        =cube
        i2
        /SURF/PART/1
        =all
        i1 i2
        /RBODY/1
        =body
        i1 i0 i0 i0 r0 i2
        /CLOAD/1
        =pull
        i1 wX i0 i0 i1 _ r1 r0.1
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
        r99 r0.1
        r0 r0 r-9
        r0 r0 r0",
    )
});

/// Generates the contents of a field.
fn word() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => (0i64..12).prop_map(|i| i.to_string()),
        2 => (-1e3f64..1e3).prop_map(|x| format!("{x:.2}")),
        1 => Just(String::new()),
        1 => prop::sample::select(vec![
            "-1", "1e20", "1e308", "-1e-308", "99999999999999999999", "nan", "1.5-3", "X", "ZZ",
            "PART", "ALL", "111", "é", "\t", "$", "#", "/", "1.0.0", "2147483648",
            "9223372036854775807", "-9223372036854775808", "&a", "NODE_G", "SEG_D",
        ]).prop_map(String::from),
    ]
}

fn line() -> impl Strategy<Value = String> {
    let columns =
        (prop::collection::vec(word(), 0..11), prop::sample::select(vec![3usize, 8, 10, 20]));
    let fixed = columns.prop_map(|(words, width)| {
        words.iter().map(|w| format!("{w:>width$}")).collect::<String>()
    });
    prop_oneof![5 => fixed, 1 => any::<String>()]
}

/// Generates a keyword of the table with lines of numbers below it.
fn block() -> impl Strategy<Value = String> {
    let ids =
        prop::sample::select(vec!["", "/1", "/2", "/1/1", "/-1", "/99999999999999999999", "/x"]);
    (prop::sample::select(KEYWORDS.clone()), ids, prop::collection::vec(line(), 0..8))
        .prop_map(|(name, ids, lines)| format!("{name}{ids}\n{}\n", lines.join("\n")))
}

/// Reads the bytes as a deck, strictly and with unsupported keywords ignored.
fn survives(bytes: &[u8]) -> bool {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a_0000.rad");
    fs::write(&path, bytes).unwrap();
    let mut sound = false;
    for sets in [&[][..], &["mesh.allow_unsupported=true".to_string()]] {
        match read(&path, sets) {
            Ok(model) => {
                sound = true;
                let said = crumple::input::check::describe(&model);
                let deck = crumple::input::deck::radioss::export::export(&model, "a");
                // Ids may have more digits than the columns of the format.
                assert!(!said.is_empty() && deck.err().is_none_or(|why| why.contains("digits")));
            }
            Err(report) => {
                let said = report.to_string();
                assert!(report.errors() > 0 && said.contains("error"), "{said}");
            }
        }
    }
    sound
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        cases: 128,
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        survives(&bytes);
    }

    #[test]
    fn keywords_with_anything_below_them(blocks in prop::collection::vec(block(), 1..8)) {
        survives(blocks.concat().as_bytes());
    }

    #[test]
    fn a_plate_and_then_anything(blocks in prop::collection::vec(block(), 1..4)) {
        survives((PLATE.clone() + &blocks.concat()).as_bytes());
    }

    #[test]
    fn a_plate_with_cuts_and_flips(
        wounds in prop::collection::vec(wound(word()), 1..4),
    ) {
        let bytes = damaged(&PLATE, &wounds);
        survives(&bytes);
    }
}

/// The damage is neither too small nor too large to be useful.
#[test]
fn some_damaged_plates_are_sound_and_some_are_not() {
    let text = mesh() + &properties() + &steel() + &moves();
    let (mut sound, mut faulty) = (0, 0);
    for at in (0..text.len()).step_by(37) {
        let mut bytes = text.clone().into_bytes();
        bytes[at] = b'7';
        if survives(&bytes) { sound += 1 } else { faulty += 1 }
    }
    assert!(sound > 8 && faulty > 8, "{sound} valid, {faulty} invalid");
}
