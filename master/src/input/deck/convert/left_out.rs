//! Keywords that are not supported: what the model lacks without them, and the ids of their cards,
//! so that cards that refer to them are no further errors.

use super::DeckConverter;
use crate::input::deck::fields::CardFormat;
use crate::input::deck::number;
use crate::input::deck::parameters::{DeckParameters, Parameter, reference};
use crate::input::deck::text::{KeywordBlock, Texts};
use crate::input::job::tree::Place;
use std::collections::BTreeMap;

/// Start of the names of keywords, and what a model lacks without them; the first that fits.
const LOST: [(&str, &str); 22] = [
    ("AIRBAG_", "bags have no pressure"),
    ("BOUNDARY_", "nodes lack this boundary condition"),
    ("CONSTRAINED_JOINT", "bodies move without this joint"),
    ("CONSTRAINED_", "nodes and bodies move without this constraint"),
    ("CONTACT_", "surfaces of this contact go through each other"),
    ("CONTROL_", "the run has the default of this setting"),
    ("DAMPING_", "this damping does not act"),
    ("DEFINE_", "cards that refer to it have no definition"),
    ("DEFORMABLE_TO_RIGID", "parts stay deformable"),
    ("ELEMENT_", "the model lacks these elements and their mass"),
    ("EOS_", "the pressure of the material is elastic"),
    ("INITIAL_", "the run starts without this state"),
    ("INTEGRATION_", "sections have the default rule"),
    ("LOAD_", "this load does not act"),
    ("MAT_ADD_", "the material lacks this addition, such as its failure"),
    ("MAT_", "parts that refer to it have no material"),
    ("NODE_", "nodes lack this change"),
    ("PART_", "the model lacks these parts or their change"),
    ("RIGIDWALL_", "nodes go through this wall"),
    ("SECTION_", "parts that refer to it have no section"),
    ("SENSOR_", "this sensor switches nothing"),
    ("SET_", "cards that refer to it have no set"),
];

/// Why a card is left out: its keyword has no conversion.
pub const NOT_SUPPORTED: &str = "is not supported";
/// Why a card is left out: `mesh.leave_out` names its keyword.
pub const BY_CHOICE: &str = "is left out";

/// Returns what a model lacks without a keyword.
pub fn lost(name: &str) -> &'static str {
    let found = LOST.iter().find(|(start, _)| name.starts_with(start));
    found.map_or("what it describes is missing", |(_, lost)| lost)
}

/// Kind of parts, see [`KINDS`].
const PART: &str = "PART";

/// Start of the names of cards to which others refer by an id, and the kind of that id. Radioss has
/// the first word of a name for it.
const KINDS: [(&str, &str); 22] = [
    ("MAT_ADD_", ""),
    ("MAT_THERMAL_", ""),
    ("MAT_", "MAT"),
    ("SECTION_", "SECTION"),
    ("PART", PART),
    ("rigid part", PART),
    ("EOS_", "EOS"),
    ("HOURGLASS", "HOURGLASS"),
    ("SET_NODE", "SET_NODE"),
    ("SET_PART", "SET_PART"),
    ("SET_SEGMENT", "SET_SEGMENT"),
    ("SET_SHELL", "SET_SHELL"),
    ("SET_SOLID", "SET_SOLID"),
    ("SET_BEAM", "SET_BEAM"),
    ("SET_DISCRETE", "SET_DISCRETE"),
    ("DEFINE_CURVE", "DEFINE_CURVE"),
    ("DEFINE_FUNCTION", "DEFINE_CURVE"),
    ("DEFINE_TABLE", "DEFINE_CURVE"),
    ("DEFINE_BOX", "DEFINE_BOX"),
    ("DEFINE_COORDINATE", "DEFINE_COORDINATE"),
    ("DEFINE_VECTOR", "DEFINE_VECTOR"),
    ("DEFINE_SD_ORIENTATION", "DEFINE_SD_ORIENTATION"),
];

/// Returns the kind of the ids of a card from its name, such as `*MAT_ELASTIC`, `*MAT_...` or
/// `/MAT/LAW1`; `None` if no card refers to it.
fn kind_of(name: &str) -> Option<&str> {
    let name = name.trim_start_matches('*');
    if let Some(words) = name.strip_prefix('/') {
        return words.split('/').next();
    }
    let found = KINDS.iter().find(|(start, _)| name.starts_with(start));
    found.map(|(_, kind)| *kind).filter(|kind| !kind.is_empty())
}

/// Cards of keywords that are not supported or were left out, and parts that need them.
#[derive(Debug, Default)]
pub struct LeftOutCards {
    /// Reasons by kind and id, as the end of a sentence.
    reasons: BTreeMap<(String, i64), String>,
    /// Keywords of implicit analysis.
    implicit: Vec<(String, Place)>,
}

impl LeftOutCards {
    /// Notes a block that is not converted, and why. Only the first id of a block is noted, since
    /// the cards of an unknown keyword are not known: what refers to another one is an error.
    pub fn note(
        &mut self,
        texts: &Texts,
        block: &KeywordBlock,
        parameters: &DeckParameters,
        why: &str,
    ) {
        // Other keywords of parts change a part that is there.
        let Some(kind) = kind_of(&block.name).filter(|kind| *kind != PART) else { return };
        let title = usize::from(block.name.ends_with("_TITLE"));
        let Some(&span) = block.lines.get(title) else { return };
        let line = texts.line(block, span);
        let width = if block.format == CardFormat::Long { 20 } else { 10 };
        let separator = if block.name.starts_with('/') { b'/' } else { b',' };
        let first = match line.contains(&separator) {
            true => line.split(|&b| b == separator).next().unwrap_or_default(),
            false => &line[..line.len().min(width)],
        };
        let text = String::from_utf8_lossy(first.trim_ascii());
        let id = match reference(&text).and_then(|(_, name)| parameters.get(name)) {
            Some(Parameter::Integer(id)) => Some(*id),
            _ => number::integer(text.as_bytes()),
        };
        if let Some(id) = id {
            self.leave_out(kind, id, format!("{} {why}", block.shown()));
        }
    }

    /// Notes that the card of a kind and id is left out, and why.
    pub(super) fn leave_out(&mut self, kind: &str, id: i64, reason: String) {
        self.reasons.insert((kind.to_string(), id), reason);
    }

    /// Returns why there is no card of this id, if that is known; `what` is the name of the card.
    pub fn reason(&self, what: &str, id: i64) -> Option<&str> {
        self.reasons.get(&(kind_of(what)?.to_string(), id)).map(String::as_str)
    }

    /// Returns true if there are parts that are left out.
    pub(super) fn has_parts(&self) -> bool {
        self.reasons.keys().any(|(kind, _)| kind == PART)
    }

    /// Notes a keyword of implicit analysis.
    pub fn implicit(&mut self, block: &KeywordBlock) {
        self.implicit.push((block.name.clone(), block.place()));
    }
}

impl DeckConverter {
    /// Leaves out a part if it needs a card that is left out: the card named `what` with the id of
    /// the field. Returns false if it does not.
    pub(super) fn part_lacks(
        &mut self,
        pid: i64,
        (what, field): (&str, &str),
        (id, place): (i64, Place),
    ) -> bool {
        let Some(reason) = self.left_out.reason(what, id) else { return false };
        let why = format!("it needs {field} {id}, and {reason}");
        let page = if what.starts_with('/') { "RADIOSS" } else { "DECKS" };
        let help = format!("give the part another {what} (cases/{page}.md lists them)");
        self.leave_out_part(pid, place, &why, help);
        true
    }

    /// Leaves out a part with its elements.
    pub(super) fn leave_out_part(&mut self, pid: i64, place: Place, why: &str, help: String) {
        if !self.is_left_out(pid) {
            let message = format!("part {pid} and its elements are left out: {why}");
            self.trouble.warning(place, message, help);
            self.left_out.leave_out(PART, pid, format!("part {pid} is left out"));
        }
    }

    /// Returns true if a part is left out.
    pub(super) fn is_left_out(&self, pid: i64) -> bool {
        self.left_out.reason(PART, pid).is_some()
    }

    /// Removes the elements of parts that are left out.
    pub(super) fn remove_left_out(&mut self) {
        if self.left_out.has_parts() {
            let left_out = &self.left_out;
            self.rows.remove(|e| left_out.reason(PART, i64::from(e.part)).is_some());
        }
    }

    /// Removes nodes of parts that are left out from the node sets of the job, with what acts on
    /// such nodes only.
    pub(super) fn without_lost_nodes(&mut self) {
        let lost = self.rows.lost_nodes();
        if lost.is_empty() {
            return;
        }
        let emptied = self.rows.remove_from_sets(&lost);
        let (removed, bodies) = self.tree.remove_entries_of(&emptied);
        for (list, place) in removed {
            let what = match list.as_str() {
                "output" => "an entry of [output]".to_string(),
                list => format!("[[{list}]]"),
            };
            let message =
                format!("{what} is left out: all its nodes are those of parts that are left out");
            self.trouble.warning(place, message, "it has no effect");
        }
        for (place, body) in self.tree.remove_entries_on(&bodies) {
            let message = format!("the rigid body `{body}` is left out with all its nodes");
            self.trouble.warning(place, message, "it has no effect");
        }
    }

    /// Reports a deck for implicit analysis. Without it, its other keywords have no effect.
    pub(super) fn implicit(&mut self) {
        let mut active = false;
        for record in self.take_records("CONTROL_IMPLICIT_GENERAL") {
            if record.integer("imflag") != 0 {
                active = true;
                let message = format!(
                    "*CONTROL_IMPLICIT_GENERAL: imflag = {} asks for implicit analysis, but this \
                     is an explicit code: it computes fast events in many small steps",
                    record.integer("imflag")
                );
                let what = "*CONTROL_IMPLICIT_GENERAL imflag".into();
                self.unsupported(record.place("imflag"), message, what);
            }
        }
        for (name, place) in std::mem::take(&mut self.left_out.implicit) {
            let help = match active {
                true => "it belongs to implicit analysis",
                false => "it has no effect: the deck is explicit (imflag is 0)",
            };
            self.trouble.warn_once(&name, place, format!("*{name} is not read"), help);
        }
    }
}
