//! Converts `/INTER/TYPE2`: nodes tied to surfaces.

use super::StarterConverter;
use super::loads::nodes_of_faces;
use crate::input::deck::convert::tree::JobTable;

/// Codes of Spotflag for kinematic ties; others are penalties.
const KINEMATIC: [i64; 6] = [0, 1, 2, 4, 5, 30];

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
            let title = record.word("title").trim().to_string();
            let name = if title.is_empty() { format!("tie-{id}") } else { title };
            let mut table = JobTable::new(record.head)
                .with("name", record.place("title"), name.as_str())
                .with("nodes", record.place("grnod"), nodes)
                .with("rotations", record.head, true)
                .with("offset", record.head, true);
            if surface.segments.is_empty() {
                let parts: Vec<i64> = surface.parts.iter().copied().collect();
                table.put("parts", place, parts);
            } else {
                let set = format!("tie-{number}-faces");
                let mut all = nodes_of_faces(&surface.segments);
                all.extend(self.nodes_of(&surface.parts));
                self.deck.rows.add_set(set.clone(), all, place);
                table.put("faces", place, set);
            }
            let distance = record.real("dsearch");
            if distance > 0.0 {
                table.put("tolerance", record.place("dsearch"), distance);
            }
            let spot = record.integer("spotflag");
            let used = match KINEMATIC.contains(&spot) {
                true => "a constraint with rotations, at the end of arms",
                false => "a constraint in place of a penalty, with rotations, at the end of arms",
            };
            self.deck.map(&name, format!("/INTER/TYPE2, Spotflag {spot}"), used);
            self.deck.add("tie", table);
        }
    }
}
