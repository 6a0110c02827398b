//! The table of keywords. A keyword is an entry of one of the lists in this folder. The folder
//! `convert` builds the model from it.

mod airbags;
mod belts;
mod cohesive;
mod composites;
mod concrete;
mod constraints;
mod contact;
mod control;
mod histories;
mod joints;
mod loads;
mod materials;
mod mesh;
mod particles;
mod parts;
mod polymers;
mod pressure_dependent;
mod sensors;
mod sets;
mod soft_materials;

use super::record::CardRecord;
use super::table::{Card, Effect, Keyword, Times, UnusedFields};
use std::collections::HashMap;
use std::sync::LazyLock;

/// All keywords, family by family.
pub const FAMILIES: &[(&str, &[Keyword])] = &[
    ("Mesh", mesh::KEYWORDS),
    ("Parts and sections", parts::KEYWORDS),
    ("Materials", materials::KEYWORDS),
    ("Particles", particles::KEYWORDS),
    ("Composites", composites::KEYWORDS),
    ("Cohesive elements", cohesive::KEYWORDS),
    ("Thermoplastics", polymers::KEYWORDS),
    ("Rubber, foam and honeycomb", soft_materials::KEYWORDS),
    ("Concrete", concrete::KEYWORDS),
    ("Ceramics, concrete and soil by pressure", pressure_dependent::KEYWORDS),
    ("Sets, curves, boxes", sets::KEYWORDS),
    ("Boundary conditions and loads", loads::KEYWORDS),
    ("Airbags", airbags::KEYWORDS),
    ("Seat belts", belts::KEYWORDS),
    ("Rigid bodies and constraints", constraints::KEYWORDS),
    ("Joints", joints::KEYWORDS),
    ("Contact and rigid walls", contact::KEYWORDS),
    ("Sensors", sensors::KEYWORDS),
    ("Control", control::KEYWORDS),
    ("Histories", histories::KEYWORDS),
];

/// Start of the names of keywords that request output. Each of them is reported once.
pub const OUTPUT: &[&str] = &["DATABASE_", "INTERFACE_SPRINGBACK", "CONTROL_OUTPUT"];

/// Start of the names of keywords on the division of a model among processes. Each of them is
/// reported once.
pub const DIVISION: &str = "CONTROL_MPP_";

/// A row of the table with its cards parsed.
pub struct KeywordRow {
    /// The entry.
    pub keyword: &'static Keyword,
    /// Its cards.
    pub cards: Vec<(Card, Times)>,
}

impl KeywordRow {
    /// Returns what becomes of a field that no code converts; `None` for other fields.
    pub fn unused(&self, field: &str) -> Option<&'static UnusedFields> {
        let names = |u: &&UnusedFields| u.names.split_whitespace().any(|name| name == field);
        self.keyword.unused.iter().find(names)
    }
}

impl std::fmt::Debug for KeywordRow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.keyword.name)
    }
}

static TABLE: LazyLock<HashMap<&'static str, KeywordRow>> = LazyLock::new(|| {
    let row = |keyword: &'static Keyword| KeywordRow {
        keyword,
        cards: keyword.cards.iter().map(|(card, times)| (Card::parse(card), *times)).collect(),
    };
    let all = FAMILIES.iter().flat_map(|(_, keywords)| keywords.iter());
    all.flat_map(|k| std::iter::once(&k.name).chain(k.aliases).map(move |name| (*name, row(k))))
        .collect()
});

/// Returns the row of a keyword for a name with options, and these options; `None` if the table
/// has none.
pub fn find(name: &str) -> Option<(&'static KeywordRow, Vec<&'static str>)> {
    let ends = name.match_indices('_').map(|(at, _)| at).chain([name.len()]);
    // The longest name first: SET_NODE_LIST before SET_NODE.
    ends.rev().find_map(|end| {
        let row = TABLE.get(&name[..end])?;
        let mut rest = name[end..].strip_prefix('_').unwrap_or(&name[end..]);
        let mut options = Vec::new();
        while !rest.is_empty() && !is_number_of_bag(row.keyword.name, rest) {
            let fits = |o: &&&str| {
                rest.strip_prefix(**o).is_some_and(|r| r.is_empty() || r.starts_with('_'))
            };
            let option = row.keyword.options.iter().filter(fits).max_by_key(|o| o.len())?;
            options.push(*option);
            rest = rest[option.len()..].strip_prefix('_').unwrap_or(&rest[option.len()..]);
        }
        Some((row, options))
    })
}

/// Returns true if the end of a name is a number that some writers of decks add to the names of
/// airbags, as in `AIRBAG_SIMPLE_PRESSURE_VOLUME_1`. It has no meaning: the cards are those of the
/// name without it.
pub fn is_number_of_bag(keyword: &str, end: &str) -> bool {
    keyword.starts_with("AIRBAG_") && end.bytes().all(|byte| byte.is_ascii_digit())
}

/// Returns the name of a keyword without options at its end.
pub fn without_options(name: &str) -> &str {
    let ends = ["_TITLE", "_ID", "_MPP"];
    ends.iter().find_map(|option| name.strip_suffix(option)).map_or(name, without_options)
}

/// Returns the keyword of the table that is similar enough to a name to explain a typing error.
pub fn near(name: &str) -> Option<&'static str> {
    /// Smallest similarity; one letter of ten may be wrong.
    const ALIKE: f64 = 0.88;
    similar(without_options(name), &TABLE, ALIKE)
}

/// Returns the supported keyword of a table that is most similar to a name, at least by `alike`.
/// Names that differ by a number mean different things, and are no typing errors.
pub fn similar(
    name: &str,
    table: &HashMap<&'static str, KeywordRow>,
    alike: f64,
) -> Option<&'static str> {
    let letters = |name: &str| name.replace(|c: char| c.is_ascii_digit(), "");
    let own = letters(name);
    let supported = table.iter().filter(|(_, row)| row.keyword.effect != Effect::NotYet);
    let others = supported.map(|(known, _)| *known).filter(|known| letters(known) != own);
    let scores = others.map(|k| (strsim::normalized_damerau_levenshtein(name, k), k));
    let (best, known) = scores.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(a.1)))?;
    (best >= alike).then_some(known)
}

/// Returns what to do in place of a keyword that is not in the table and changes no result: it
/// requests output, or divides the model among processes. `None` for other keywords.
pub fn instead_of(name: &str) -> Option<&'static str> {
    if OUTPUT.iter().any(|start| name.starts_with(start)) {
        return Some(
            "docs/guide/output.md lists the output of a run; set its intervals in [output] of a \
             job",
        );
    }
    name.starts_with(DIVISION).then_some("set `parallel.workers`, or give --workers")
}

/// Returns 1, for a heading line, with the option `TITLE`.
fn title(record: &CardRecord) -> usize {
    usize::from(record.has("TITLE"))
}

/// Returns 1, for a line with an id and a heading, with the options `ID` and `TITLE`.
fn id(record: &CardRecord) -> usize {
    usize::from(record.has("ID") || record.has("TITLE"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_well_written() {
        let count: usize = FAMILIES.iter().map(|(_, k)| k.len()).sum();
        let names: usize =
            FAMILIES.iter().flat_map(|(_, k)| k.iter()).map(|k| 1 + k.aliases.len()).sum();
        assert_eq!(TABLE.len(), names, "a name occurs twice");
        assert!(count >= 40, "{count}");
        for row in TABLE.values() {
            assert!(!row.keyword.note.is_empty(), "{}", row.keyword.name);
            for (card, _) in &row.cards {
                assert!(
                    !card.fields.is_empty() && card.fields.len() <= super::super::fields::MOST,
                    "{}",
                    row.keyword.name
                );
            }
        }
    }

    /// Every field is either named in the code that converts it, or the table says what becomes of
    /// it. Mesh data and parameters are read by position.
    #[test]
    fn every_field_has_a_fate() {
        const BY_POSITION: [&str; 10] = [
            "CASE",
            "NODE",
            "ELEMENT_SHELL",
            "ELEMENT_SOLID",
            "ELEMENT_TSHELL",
            "INITIAL_STRESS_SHELL",
            "INITIAL_STRESS_SOLID",
            "PARAMETER",
            "PARAMETER_EXPRESSION",
            "PARAMETER_DUPLICATION",
        ];
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/input/deck/convert");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let files = files.filter(|path| path.is_file());
        let code: String = files.map(|path| std::fs::read_to_string(path).unwrap()).collect();
        let mut missing = Vec::new();
        for row in TABLE.values().filter(|row| row.keyword.effect == Effect::Model) {
            let name = row.keyword.name;
            let fields: Vec<&str> =
                row.cards.iter().flat_map(|c| &c.0.fields).map(|f| f.name.as_str()).collect();
            for field in &fields {
                let converted =
                    code.contains(&format!("\"{field}\"")) || BY_POSITION.contains(&name);
                // A card that is one line has no fields.
                let is_line = matches!(*field, "card" | "text" | "heading");
                if row.unused(field).is_none() && !converted && !is_line {
                    missing.push(format!("*{name}: {field}"));
                }
            }
            for unused in row.keyword.unused.iter().flat_map(|u| u.names.split_whitespace()) {
                let shared = ["SET_", "CONSTRAINED_", "RIGIDWALL_"];
                let is_shared = shared.iter().any(|family| name.starts_with(family));
                if !fields.contains(&unused) && !is_shared {
                    missing.push(format!("*{name} has no field {unused}"));
                }
            }
        }
        missing.sort();
        missing.dedup();
        assert!(missing.is_empty(), "fields without a fate: {missing:#?}");
    }

    /// Only supported keywords explain a typing error, and no keyword with another number does.
    #[test]
    fn near_names_are_supported() {
        assert_eq!(near("MAT_ELASTC"), Some("MAT_ELASTIC"));
        assert_eq!(near("MAT_025"), None);
    }

    #[test]
    fn names_are_found_with_their_options() {
        let found = |name: &str| find(name).map(|(row, options)| (row.keyword.name, options));
        assert_eq!(found("MAT_RIGID_TITLE"), Some(("MAT_RIGID", vec!["TITLE"])));
        assert_eq!(found("MAT_020"), Some(("MAT_RIGID", vec![])));
        assert_eq!(found("SET_NODE_LIST_TITLE"), Some(("SET_NODE_LIST", vec!["TITLE"])));
        assert_eq!(
            found("CONTACT_AUTOMATIC_SINGLE_SURFACE_ID"),
            Some(("CONTACT_AUTOMATIC_SINGLE_SURFACE", vec!["ID"]))
        );
        let bag = "AIRBAG_SIMPLE_PRESSURE_VOLUME";
        assert_eq!(found(&format!("{bag}_12")), Some((bag, vec![])));
        assert_eq!(found(&format!("{bag}_ID_3")), Some((bag, vec!["ID"])));
        assert_eq!(found(&format!("{bag}_1A")), None);
        assert_eq!(found("CONTACT_AUTOMATIC_SINGLE_SURFACE_1"), None);
        assert_eq!(found("MAT_RIGID_DISCRETE"), None);
        assert_eq!(found("MAT_"), None);
        assert_eq!(found(""), None);
    }
}
