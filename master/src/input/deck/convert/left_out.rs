//! Keywords that are not supported: what the model lacks without them, and the ids of their
//! materials and sections, so that a part can name what it misses.

use super::DeckConverter;
use crate::input::deck::fields::CardFormat;
use crate::input::deck::number;
use crate::input::deck::record::CardRecord;
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

/// Returns what a model lacks without a keyword.
pub fn lost(name: &str) -> &'static str {
    let found = LOST.iter().find(|(start, _)| name.starts_with(start));
    found.map_or("what it describes is missing", |(_, lost)| lost)
}

/// Materials and sections of keywords that are not supported or were left out.
#[derive(Debug, Default)]
pub struct LeftOutCards {
    /// Names of the keywords by family and id.
    names: BTreeMap<(&'static str, i64), String>,
    /// Keywords of implicit analysis.
    implicit: Vec<(String, Place)>,
}

impl LeftOutCards {
    /// Notes a block that is not converted.
    pub fn note(&mut self, texts: &Texts, block: &KeywordBlock) {
        let Some(family) = ["MAT_", "SECTION_"].into_iter().find(|f| block.name.starts_with(f))
        else {
            return;
        };
        let title = usize::from(block.name.ends_with("_TITLE"));
        let Some(&span) = block.lines.get(title) else { return };
        let line = texts.line(block, span);
        let width = if block.format == CardFormat::Long { 20 } else { 10 };
        let first = match line.contains(&b',') {
            true => line.split(|&b| b == b',').next().unwrap_or_default(),
            false => &line[..line.len().min(width)],
        };
        if let Some(id) = number::integer(first.trim_ascii()) {
            self.names.insert((family, id), block.name.clone());
        }
    }

    /// Notes a keyword of implicit analysis.
    pub fn implicit(&mut self, block: &KeywordBlock) {
        self.implicit.push((block.name.clone(), block.place()));
    }
}

impl DeckConverter {
    /// Reports a part whose material or section is of a keyword that is not supported. Returns
    /// false if there is no such keyword.
    pub(super) fn part_without(
        &mut self,
        record: &CardRecord,
        (family, field): (&'static str, &str),
    ) -> bool {
        let card = (record.integer(field), record.place(field));
        self.part_lacks(record.integer("pid"), (family, field), card)
    }

    /// Reports that part `pid` needs a card of this id that was left out; false if none was.
    pub(super) fn part_lacks(
        &mut self,
        pid: i64,
        (family, field): (&'static str, &str),
        (id, place): (i64, Place),
    ) -> bool {
        let Some(name) = self.left_out.names.get(&(family, id)) else { return false };
        let message = format!("part {pid} needs {field} {id}, a *{name}, which is not supported");
        let help = format!(
            "give the part another *{family}... (cases/DECKS.md lists them), or remove the part \
             and its elements"
        );
        self.trouble.error(place, message, help);
        true
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
