//! Any content of a deck gives a model or a report.

use crumple::input::job::read;
use proptest::prelude::*;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

static PLATE: LazyLock<Vec<String>> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("decks/good");
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    ["fixed.k", "long.k", "comma.k"].map(read).to_vec()
});

/// Names of all keywords, from the page that is generated from their table.
static KEYWORDS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let page = crumple::input::deck::reference::page();
    let names = page.split('`').skip(1).step_by(2);
    let upper = |n: &&str| {
        n.len() > 3 && n.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
    };
    names.filter(upper).map(String::from).collect()
});

/// Generates the contents of a field.
fn word() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => (0i64..12).prop_map(|i| i.to_string()),
        2 => (-1e3f64..1e3).prop_map(|x| format!("{x:.2}")),
        1 => Just(String::new()),
        1 => prop::sample::select(vec![
            "-1", "1e20", "1e308", "-1e-308", "99999999999999999999", "&a", "-&a", "nan", "1.5-3",
            "PART", "BOX", "ALL", "é", "\t", "$", "*", "1.0.0", "2147483648", "9223372036854775807",
            "-9223372036854775808", "R  a", "I  b",
        ]).prop_map(String::from),
    ]
}

fn line() -> impl Strategy<Value = String> {
    let columns =
        (prop::collection::vec(word(), 0..11), prop::sample::select(vec![5usize, 8, 10, 16, 20]));
    let fixed = columns.prop_map(|(words, width)| {
        words.iter().map(|w| format!("{w:>width$}")).collect::<String>()
    });
    let commas = prop::collection::vec(word(), 0..11).prop_map(|words| words.join(","));
    prop_oneof![4 => fixed, 2 => commas, 1 => any::<String>()]
}

/// Generates a keyword of the table with lines of numbers below it.
fn block() -> impl Strategy<Value = String> {
    let option = prop::sample::select(vec![
        "",
        "",
        "",
        "_TITLE",
        "_ID",
        "_MPP",
        "_THICKNESS",
        "+",
        " LONG=Y",
        "%",
    ]);
    (prop::sample::select(KEYWORDS.clone()), option, prop::collection::vec(line(), 0..7))
        .prop_map(|(name, option, lines)| format!("*{name}{option}\n{}\n", lines.join("\n")))
}

/// Reads the bytes as a deck, strictly and with unsupported keywords ignored.
fn survives(bytes: &[u8]) -> (bool, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, bytes).unwrap();
    let mut said = String::new();
    let mut sound = false;
    for sets in [&[][..], &["mesh.allow_unsupported=true".to_string()]] {
        match read(&path, sets) {
            Ok(model) => {
                sound = true;
                said = crumple::input::check::describe(&model);
                let _ = (crumple::input::deck::export::export(&model), model.records());
            }
            Err(report) => {
                said = report.to_string();
                assert!(report.errors() > 0 && said.contains("error"), "{said}");
            }
        }
    }
    (sound, said)
}

/// Damage: place, kind and text.
pub type Wound = (prop::sample::Index, usize, String);

/// Generates damage with texts from `word`.
pub fn wound(word: impl Strategy<Value = String>) -> impl Strategy<Value = Wound> {
    (any::<prop::sample::Index>(), 0usize..5, word)
}

/// Returns a text with cuts, flipped bits, and texts within it or instead of a part of it.
pub fn damaged(text: &str, wounds: &[Wound]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for (at, kind, word) in wounds {
        let at = at.index(bytes.len());
        match kind {
            0 => bytes.truncate(at.max(40)),
            1 => drop(bytes.remove(at)),
            2 => drop(bytes.splice(at..at, word.bytes())),
            3 => bytes[at] ^= 1 << (word.len() % 8),
            _ => {
                let end = (at + word.len().max(1)).min(bytes.len());
                drop(bytes.splice(at..end, word.bytes()));
            }
        }
        if bytes.is_empty() {
            break;
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        survives(&bytes);
    }

    #[test]
    fn keywords_with_anything_below_them(blocks in prop::collection::vec(block(), 1..8)) {
        survives(format!("*KEYWORD\n{}", blocks.concat()).as_bytes());
    }

    #[test]
    fn a_plate_and_then_anything(
        which in 0usize..3,
        blocks in prop::collection::vec(block(), 1..4),
    ) {
        let end = PLATE[which].find("*END").unwrap();
        survives(format!("{}{}", &PLATE[which][..end], blocks.concat()).as_bytes());
    }

    #[test]
    fn a_plate_with_damage(
        which in 0usize..3,
        wounds in prop::collection::vec(wound(word()), 1..4),
    ) {
        let bytes = damaged(&PLATE[which], &wounds);
        survives(&bytes);
    }
}

/// The damage is neither too small nor too large to be useful.
#[test]
fn some_damaged_plates_are_sound_and_some_are_not() {
    let text = &PLATE[0];
    let (mut sound, mut faulty) = (0, 0);
    for at in (0..text.len()).step_by(23) {
        let mut bytes = text.clone().into_bytes();
        bytes[at] = b'7';
        if survives(&bytes).0 { sound += 1 } else { faulty += 1 }
    }
    assert!(sound > 10 && faulty > 10, "{sound} valid, {faulty} invalid");
}
