//! Converts `/INTER/TYPE2`: nodes tied to surfaces.

use super::StarterConverter;
use super::loads::nodes_of_faces;
use crate::input::deck::convert::tree::JobTable;

/// Codes of Spotflag for kinematic ties; others are penalties.
const KINEMATIC: [i64; 6] = [0, 1, 2, 4, 5, 30];
/// Codes of Spotflag for ties that break.
const BREAK: std::ops::RangeInclusive<i64> = 20..=22;
/// Code of Spotflag for ties that leave rotations free.
const TRANSLATIONS: i64 = 4;

impl StarterConverter {
    pub(super) fn ties(&mut self) {
        for (number, record) in (1..).zip(self.take(&["/INTER/TYPE2"])) {
            let id = record.integer("id");
            let (grnod, surf) = (record.integer("grnod"), record.integer("surf"));
            let place = record.place("surf");
            let nodes = self.deck.node_set(grnod, record.place("grnod"));
            let (Some(nodes), Some(surface)) = (nodes, self.surface(surf, place)) else {
                continue;
            };
            let spot = record.integer("spotflag");
            if BREAK.contains(&spot) {
                let why = "ties that break; use 5 for a tie that holds";
                self.deck.unsupported_value(&record, "spotflag", why);
            }
            let rotates = spot != TRANSLATIONS;
            let title = record.word("title").trim().to_string();
            let name = if title.is_empty() { format!("tie-{id}") } else { title };
            let mut table = JobTable::new(record.head)
                .with("name", record.place("title"), name.as_str())
                .with("nodes", record.place("grnod"), nodes)
                .with("rotations", record.place("spotflag"), rotates)
                .with("offset", record.head, true);
            if surface.segments.is_empty() {
                let parts: Vec<i64> = surface.parts.iter().copied().collect();
                table.put("parts", place, parts);
            } else {
                let mut all = nodes_of_faces(&surface.segments);
                all.extend(self.nodes_of(&surface.parts));
                let set = format!("tie-{number}-faces");
                let set = self.deck.rows.add_new_set(&set, all, place);
                table.put("faces", place, set);
            }
            let distance = record.real("dsearch");
            if distance > 0.0 {
                table.put("tolerance", record.place("dsearch"), distance);
            }
            let used = match KINEMATIC.contains(&spot) {
                true if rotates => "a constraint with rotations, at the end of arms",
                true => "a constraint without rotations, at the end of arms",
                false => "a constraint in place of a penalty, with rotations, at the end of arms",
            };
            self.deck.map(&name, format!("/INTER/TYPE2, Spotflag {spot}"), used);
            self.deck.add("tie", table);
        }
    }
}
