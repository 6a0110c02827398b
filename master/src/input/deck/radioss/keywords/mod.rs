//! The table of keywords of Radioss, of the starter file and of the engine file. The folder
//! `convert/radioss` builds the model from it.

mod contact;
mod engine;
mod loads;
mod materials;
mod mesh;
mod output;
mod parts;
mod sets;

pub use engine::ENGINE_DAMP;

use crate::input::deck::keywords::{KeywordRow, similar};
use crate::input::deck::table::{Card, Effect, Keyword, Times};
use std::collections::HashMap;
use std::sync::LazyLock;

/// All keywords, family by family.
pub const FAMILIES: &[(&str, &[Keyword])] = &[
    ("Model and units", mesh::MODEL),
    ("Mesh", mesh::KEYWORDS),
    ("Parts and properties", parts::KEYWORDS),
    ("Materials", materials::KEYWORDS),
    ("Groups, surfaces, functions, systems", sets::KEYWORDS),
    ("Boundary conditions and loads", loads::KEYWORDS),
    ("Rigid bodies, walls, interfaces", contact::KEYWORDS),
    ("Histories", output::KEYWORDS),
    ("Engine file", engine::KEYWORDS),
];

/// Card of the ids in a keyword's own line.
const HEADER: &str = "id:i0 unit:i0";
/// Card of the title of an entity.
const TITLE: (&str, Times) = ("title:l", Times::Once);
/// Option of keywords of which any words may follow.
const ANY: &[&str] = &["any"];

static TABLE: LazyLock<HashMap<&'static str, KeywordRow>> = LazyLock::new(|| {
    let all = FAMILIES.iter().flat_map(|(_, keywords)| keywords.iter());
    all.flat_map(|k| std::iter::once(&k.name).chain(k.aliases).map(move |name| (*name, row(k))))
        .collect()
});

/// Returns a row of the table with the card of the ids first.
fn row(keyword: &'static Keyword) -> KeywordRow {
    let own = keyword.cards.iter().map(|(card, times)| (Card::parse(card), *times));
    let mut cards: Vec<(Card, Times)> = own.collect();
    if !cards.first().is_some_and(|(card, _)| card.is_header()) {
        cards.insert(0, (Card::parse(HEADER), Times::Once));
    }
    KeywordRow { keyword, cards }
}

/// Returns the row of a keyword; `None` if the table has none. Some keywords allow further words
/// after their name.
pub fn find(name: &str) -> Option<&'static KeywordRow> {
    if let Some(row) = TABLE.get(name) {
        return Some(row);
    }
    let ends = name.match_indices('/').map(|(at, _)| at).filter(|&at| at > 0);
    let longest_first = ends.collect::<Vec<_>>().into_iter().rev();
    longest_first.filter_map(|end| TABLE.get(&name[..end])).find(|row| row.keyword.options == ANY)
}

/// Returns the keyword of the table that is similar enough to a name to explain a typing error.
pub fn near(name: &str) -> Option<&'static str> {
    /// Smallest similarity; one letter of seven may be wrong.
    const ALIKE: f64 = 0.85;
    similar(name, &TABLE, ALIKE)
}

/// Returns true for a keyword of the engine file.
pub fn is_of_engine(name: &str) -> bool {
    let is_this = |row: &KeywordRow| engine::KEYWORDS.iter().any(|k| k.name == row.keyword.name);
    find(name).is_some_and(is_this)
}

/// Creates a keyword that has no effect here.
const fn harmless(name: &'static str, note: &'static str) -> Keyword {
    Keyword::new(name, &[], note).effect(Effect::Harmless)
}

/// Creates a keyword that the engine does not support yet.
const fn not_yet(name: &'static str, note: &'static str) -> Keyword {
    Keyword::new(name, &[], note).effect(Effect::NotYet)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_well_written() {
        let all = || FAMILIES.iter().flat_map(|(_, keywords)| keywords.iter());
        let names: usize = all().map(|k| 1 + k.aliases.len()).sum();
        assert_eq!(TABLE.len(), names, "a name occurs twice");
        for row in TABLE.values() {
            let name = row.keyword.name;
            assert!(name.starts_with('/') && !row.keyword.note.is_empty(), "{name}");
            for (card, _) in &row.cards {
                let count = card.fields.len();
                assert!(count > 0 && count <= crate::input::deck::fields::MOST, "{name}");
                let columns: usize = card.fields.iter().map(|f| usize::from(f.width)).sum();
                assert!(columns <= 110, "{name}: {columns} columns");
            }
        }
    }

    /// Every field is either named in the code that converts it, or the table says what becomes of
    /// it. Nodes and elements are read by position.
    #[test]
    fn every_field_has_a_fate() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/input/deck/convert/radioss");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let code: String = files.map(|path| std::fs::read_to_string(path).unwrap()).collect();
        let by_position: Vec<&str> = mesh::KEYWORDS.iter().map(|k| k.name).collect();
        let mut missing = Vec::new();
        for row in TABLE.values().filter(|row| row.keyword.effect == Effect::Model) {
            let name = row.keyword.name;
            let fields: Vec<&str> =
                row.cards.iter().flat_map(|c| &c.0.fields).map(|f| f.name.as_str()).collect();
            for field in &fields {
                let converted = code.contains(&format!("\"{field}\""))
                    || by_position.contains(&name) && row.unused(field).is_none();
                // Columns that are not used, and cards that are one line, have no fields.
                let is_no_field = matches!(*field, "blank" | "title" | "text" | "unit");
                if row.unused(field).is_none() && !converted && !is_no_field {
                    missing.push(format!("{name}: {field}"));
                }
            }
            for unused in row.keyword.unused.iter().flat_map(|u| u.names.split_whitespace()) {
                if !fields.contains(&unused) {
                    missing.push(format!("{name} has no field {unused}"));
                }
            }
        }
        missing.sort();
        missing.dedup();
        assert!(missing.is_empty(), "fields without a fate: {missing:#?}");
    }

    #[test]
    fn names_are_found_with_their_aliases() {
        let found = |name| find(name).map(|row| row.keyword.name);
        assert_eq!(found("/MAT/ELAST"), Some("/MAT/LAW1"));
        assert_eq!(found("/RUN/TUBE"), Some("/RUN"));
        assert_eq!(found("/H3D/SHELL/TENS/STRESS/NPT=ALL"), Some("/H3D"));
        assert_eq!(found("/MAT/LAW99"), None);
        assert_eq!(found("/"), None);
        assert_eq!(found(""), None);
        assert_eq!(near("/MAT/ELATS"), Some("/MAT/ELAST"));
        assert_eq!(near("/MAT/OGDEM"), Some("/MAT/OGDEN"));
        assert_eq!([near("/PROP/TYPE7"), near("/MAT/LAW37"), near("/MAT/FOAM_TAV")], [None; 3]);
    }
}
