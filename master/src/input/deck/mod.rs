//! Keyword decks of LS-DYNA and Radioss: reading, and conversion to a job.
//!
//! 1. `text.rs`: files, `*INCLUDE`, blocks of lines; `cases.rs`: the blocks of one case;
//!    `fields.rs`, `number.rs`: fields of a line
//! 2. `table.rs`, `keywords`: the table of keywords and their cards; `record.rs` reads cards by
//!    it; `parameters.rs`, `expression.rs`: `&name`; `submodel.rs`, `roles.rs`, `affine.rs`:
//!    included files with other ids, units or position
//! 3. `convert`: a job's tree of values, and a mesh; `merge.rs` merges a job file over it
//! 4. `export.rs`: the reverse conversion
//! 5. `radioss`: files, keywords and export of Radioss, with the same steps
//!
//! The reader of cards does not know models. No input may cause a panic here.

mod affine;
mod cases;
mod convert;
mod diagnostics;
pub mod export;
mod expression;
mod fields;
mod keywords;
mod merge;
pub(super) mod number;
mod parameters;
pub mod radioss;
mod record;
pub mod reference;
mod roles;
pub(super) mod sniff;
mod submodel;
mod table;
mod text;
pub mod translate;

pub use affine::{Affine, sine_cosine};
pub use convert::mesh::{ListLengths, Places};
pub use merge::merge;
pub use text::Text;

use crate::input::job::report::{PlacedProblem, deck_path, deck_place};
use crate::input::job::tree::{Node, Place};
use crate::input::mesh_file::ImportRow;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::{Problem, Severity};
use diagnostics::Trouble;
use sniff::DeckFormat;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Plastic strain that no material reaches, where continued hardening curves end.
pub const BEYOND_ALL_STRAINS: f64 = 10.0;

/// A request of a deck, and the settings used for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapping {
    /// Object, such as `part 3`.
    pub of: String,
    /// Request of the deck.
    pub asked: String,
    /// Settings used.
    pub used: String,
}

/// Content of a deck that the engine does not support.
#[derive(Debug)]
pub struct Unsupported {
    /// Place.
    pub place: Place,
    /// Message, as a sentence.
    pub message: String,
    /// Name, in a word or two.
    pub what: String,
    /// Text: the loss if the run continues without it.
    pub lost: String,
}

/// A deck that was read.
#[derive(Debug)]
pub struct Deck {
    /// The job that it describes, without its mesh.
    pub tree: Node,
    /// The mesh, elements list by list as written.
    pub mesh: Mesh,
    /// Number of elements of each kind, in the order of the mesh.
    pub lists: ListLengths,
    /// Nodes of no element that stand for a rigid body.
    pub stand_ins: BTreeSet<NodeId>,
    /// Its files.
    pub files: Vec<Text>,
    /// Places of the mesh data.
    pub places: Places,
    /// Its problems.
    pub(crate) findings: Vec<PlacedProblem>,
    /// True if all its cards could be read.
    pub whole: bool,
    /// Requests and the settings used for them.
    pub mapping: Vec<Mapping>,
    /// Ignored content, with file and line; empty unless that is allowed.
    pub unsupported: Vec<String>,
    /// Keywords of a Radioss deck with their fates; empty for LS-DYNA.
    pub keywords: Vec<ImportRow>,
}

impl Deck {
    /// Creates that of a file that is no deck.
    fn refused(trouble: Trouble) -> Self {
        Deck {
            tree: Node::table(Place::Whole),
            mesh: Mesh::default(),
            lists: ListLengths::default(),
            stand_ins: BTreeSet::new(),
            files: Vec::new(),
            places: Places::default(),
            findings: trouble.into_findings(),
            whole: false,
            mapping: Vec::new(),
            unsupported: Vec::new(),
            keywords: Vec::new(),
        }
    }
}

/// Returns true if a file is a deck, from its name.
pub fn is_deck(path: &Path) -> bool {
    let extension =
        path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    matches!(extension.as_str(), "k" | "key" | "dyn" | "rad")
}

/// Choice of the content of a deck that is read.
#[derive(Clone, Debug, Default)]
pub struct DeckChoice {
    /// Keywords that are not read.
    pub leave_out: Vec<String>,
    /// Ignore unsupported content; otherwise it is an error.
    pub allow_unsupported: bool,
    /// The case that is read, if there are several.
    pub case: Option<u64>,
}

/// Reads a deck.
pub fn read(path: &Path, choice: &DeckChoice) -> Deck {
    let DeckChoice { leave_out, allow_unsupported, case } = choice;
    let mut trouble = Trouble::default();
    let Some(format) = sniff::format(path, &mut trouble) else { return Deck::refused(trouble) };
    let mut keywords = Vec::new();
    let (mut texts, tree, mut built) = match format {
        DeckFormat::LsDyna => {
            let mut texts = text::Texts::read(path, &mut trouble);
            let chosen = cases::select(&mut texts, *case, &mut trouble);
            let (tree, mut built) = convert::build(&texts, leave_out, trouble);
            built.mapping.splice(0..0, chosen);
            (texts, tree, built)
        }
        DeckFormat::Radioss => {
            cases::report_none(*case, &mut trouble);
            let texts = radioss::text::read(path, &mut trouble);
            keywords = radioss::fates(&texts);
            let (tree, built) = convert::radioss::build(&texts, leave_out, trouble);
            (texts, tree, built)
        }
    };
    let unsupported = report_unsupported(
        std::mem::take(&mut built.unsupported),
        *allow_unsupported,
        &texts.files,
        &mut built.trouble,
    );
    let mut whole = tree;
    for (number, file) in texts.files.iter().enumerate() {
        if let Some(own) = fragment(number, file, &mut built.trouble) {
            whole = merge(whole, own);
        }
    }
    let whole_cards = !built.trouble.is_unsure();
    let lists = built.rows.lists();
    let stand_ins = std::mem::take(&mut built.rows.stand_ins);
    let (mesh, places) = built.rows.finish();
    Deck {
        tree: whole,
        mesh,
        lists,
        stand_ins,
        files: std::mem::take(&mut texts.files),
        places,
        findings: built.trouble.into_findings(),
        whole: whole_cards,
        mapping: built.mapping,
        unsupported,
        keywords,
    }
}

/// Fates of the content of a deck.
#[derive(Debug)]
pub struct DeckFates {
    /// True if it has parts: without them it is no model, but may have a mesh.
    pub has_parts: bool,
    /// Its keywords, after its mesh.
    pub rows: Vec<ImportRow>,
    /// Requests and the settings used for them.
    pub mapping: Vec<Mapping>,
    /// Ignored content, with file and line.
    pub unsupported: Vec<String>,
    /// Warnings, with file and line in their texts.
    pub warnings: Vec<Problem>,
}

/// The mesh of a deck, for a job that has everything else.
pub struct DeckMesh {
    /// Nodes, elements, node sets.
    pub mesh: Mesh,
    /// Ids and names of its parts.
    pub parts: Vec<(u32, String)>,
    /// Its units, if it states them.
    pub units: Option<String>,
    /// Its files.
    pub files: Vec<PathBuf>,
    /// Fates of its content.
    pub table: DeckFates,
}

/// Reads the mesh of a deck.
///
/// # Errors
/// All problems of the deck, with file and line in their texts.
pub fn mesh_of(path: &Path, choice: &DeckChoice) -> Result<DeckMesh, Vec<Problem>> {
    let deck = read(path, choice);
    let found = deck.findings.iter().map(|found| {
        let place = deck_place(&found.problem.path).map(|place| at(place, &deck.files));
        let place = place.unwrap_or_default();
        let message = match place.is_empty() {
            true => found.problem.message.clone(),
            false => format!("{place}: {}", found.problem.message),
        };
        Problem { path: "mesh.file".into(), message, ..found.problem.clone() }
    });
    let (errors, warnings): (Vec<_>, Vec<_>) =
        found.partition(|problem| problem.severity == Severity::Error);
    if !errors.is_empty() {
        return Err(errors);
    }
    let tree = deck.tree.to_value();
    let part = |value: &toml::Value| {
        let id = u32::try_from(value.get("id")?.as_integer()?).ok()?;
        Some((id, value.get("name")?.as_str()?.to_string()))
    };
    let parts = tree.get("part").and_then(toml::Value::as_array);
    let parts: Vec<_> = parts.into_iter().flatten().filter_map(part).collect();
    let units = tree.get("units").and_then(toml::Value::as_str).map(str::to_string);
    let files = deck.files.iter().map(|text| text.path.clone()).collect();
    let Deck { mesh, mapping, unsupported, keywords: rows, .. } = deck;
    let table = DeckFates { has_parts: !parts.is_empty(), rows, mapping, unsupported, warnings };
    Ok(DeckMesh { mesh, parts, units, files, table })
}

/// Reports all unsupported content, once for each kind, and returns the list for the summary.
fn report_unsupported(
    all: Vec<Unsupported>,
    allowed: bool,
    files: &[Text],
    trouble: &mut Trouble,
) -> Vec<String> {
    let mut kinds: BTreeMap<String, (Unsupported, usize)> = BTreeMap::new();
    let mut order: Vec<String> = Vec::new();
    for one in all {
        let key = one.what.clone();
        match kinds.get_mut(&key) {
            Some(found) => found.1 += 1,
            None => {
                order.push(key.clone());
                kinds.insert(key, (one, 1));
            }
        }
    }
    let mut list = Vec::new();
    for (one, count) in order.iter().filter_map(|key| kinds.remove(key)) {
        let message = match count {
            1 => one.message,
            n => format!("{}; and {} more of this kind", one.message, n - 1),
        };
        if allowed {
            list.push(format!("{} ({}): {}", one.what, at(one.place, files), one.lost));
            let help = format!("the run continues because of --allow-unsupported: {}", one.lost);
            trouble.warning(one.place, message, help);
        } else {
            let help = format!(
                "it would change the result: remove it, or ignore it with --allow-unsupported \
                 ({})",
                one.lost
            );
            trouble.error(one.place, message, help);
        }
    }
    list
}

/// Returns file and line of a place.
fn at(place: Place, files: &[Text]) -> String {
    match place {
        Place::Deck { file, start, .. } => match files.get(file as usize) {
            Some(text) => {
                let before = &text.text.as_bytes()[..(start as usize).min(text.text.len())];
                format!("{}:{}", text.file, 1 + before.iter().filter(|&&b| b == b'\n').count())
            }
            None => String::new(),
        },
        _ => files.first().map_or(String::new(), |f| f.file.clone()),
    }
}

/// Parses the keys of a job in the comments of a file.
fn fragment(number: usize, file: &Text, trouble: &mut Trouble) -> Option<Node> {
    let text = file.fragment.as_ref()?;
    let file = number as u32;
    match Node::parse(text) {
        Ok(mut node) => {
            node.move_to(file);
            Some(node)
        }
        Err(errors) => {
            for (message, help, place) in errors {
                let place = match place {
                    Place::File { start, end } => Place::Deck { file, start, end },
                    other => other,
                };
                trouble.error(place, format!("after $crumple: {message}"), help);
            }
            None
        }
    }
}

/// Returns a problem at a place of a deck.
pub(crate) fn placed(problem: Problem, place: Place) -> PlacedProblem {
    PlacedProblem::from(Problem { path: deck_path(place), ..problem })
}
