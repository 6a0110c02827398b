//! Converts `*SET_SHELL_GENERAL` and the same of solids, springs and beams: sets of elements by
//! options.

use super::DeckConverter;
use super::sets::ElementSets;
use crate::input::deck::record::CardLine;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::MeshElement;
use std::collections::BTreeSet;

/// An element as the deck has it.
struct WrittenElement {
    id: i64,
    part: i64,
    corners: Vec<NodeId>,
}

impl DeckConverter {
    /// Adds the sets by options to those of one kind of elements, whose lists have this keyword.
    pub(super) fn sets_by_options(&mut self, list: &str, sets: &mut ElementSets) {
        let keyword = format!("{}_GENERAL", list.trim_end_matches("_LIST"));
        let records = self.take_records(&keyword);
        if records.is_empty() {
            return;
        }
        let all = self.written_elements(list);
        for record in records {
            let mut members: BTreeSet<i64> = BTreeSet::new();
            let lines: Vec<CardLine> = record.lines("option").cloned().collect();
            for line in lines {
                let word = line.word("option").to_ascii_uppercase();
                let (word, away) = match word.strip_prefix('D') {
                    Some(rest) if ["ELEM", "PART", "BOX"].contains(&rest) => (rest, true),
                    _ => (word.as_str(), false),
                };
                let own: Vec<(i64, Place)> = line.integers("e").collect();
                let found: BTreeSet<i64> = match word {
                    "ALL" => all.iter().map(|e| e.id).collect(),
                    "ELEM" => own.iter().map(|e| e.0).collect(),
                    "PART" => {
                        let parts: Vec<i64> =
                            own.iter().filter(|p| self.has_part(p.0, p.1)).map(|p| p.0).collect();
                        let is_of = |e: &&WrittenElement| parts.contains(&e.part);
                        all.iter().filter(is_of).map(|e| e.id).collect()
                    }
                    "BOX" => {
                        let boxes = own.iter().map(|b| self.in_box(b.0, b.1));
                        let boxes: Vec<BTreeSet<NodeId>> =
                            boxes.map(|nodes| nodes.into_iter().collect()).collect();
                        let is_in = |e: &&WrittenElement| {
                            boxes.iter().any(|nodes| e.corners.iter().all(|n| nodes.contains(n)))
                        };
                        all.iter().filter(is_in).map(|e| e.id).collect()
                    }
                    _ => {
                        let message = format!("*{keyword}: option {word} is not supported");
                        let what = format!("*{keyword} {word}");
                        self.unsupported(line.place("option"), message, what);
                        continue;
                    }
                };
                match away {
                    true => members.retain(|id| !found.contains(id)),
                    false => members.extend(found),
                }
            }
            let own = members.into_iter().map(|id| [id, id]);
            sets.entry(record.integer("sid")).or_default().extend(own);
        }
    }

    /// Returns all elements of a kind with the ids that the deck has for them.
    fn written_elements(&self, list: &str) -> Vec<WrittenElement> {
        let rows = &self.rows;
        let [solids, springs, beams] = rows.raised;
        let (elements, raised) = match list {
            "SET_SHELL_LIST" => (&rows.shells, 0),
            "SET_SOLID" => (&rows.solids, solids),
            "SET_BEAM" => (&rows.beams, beams),
            _ => (&rows.springs, springs),
        };
        let written = |e: &MeshElement| WrittenElement {
            id: e.id.0.saturating_sub(raised) as i64,
            part: i64::from(e.part),
            // The third node of a beam is no end of it.
            corners: e.corners().to_vec(),
        };
        elements.iter().map(written).collect()
    }
}
