//! Converts `*DATABASE_SWFORC`: forces of spot welds over time.

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::{MeshElement, Shape};
use std::collections::BTreeSet;

/// Largest number of welds with histories.
const MOST: usize = 200;

impl DeckConverter {
    /// Returns a section for each weld of one element.
    pub(super) fn weld_forces(&mut self) -> Vec<(Place, JobTable)> {
        let records = self.take_one("DATABASE_SWFORC");
        let Some(record) = records.last().filter(|record| record.real("dt") > 0.0) else {
            return Vec::new();
        };
        let place = record.place("dt");
        let parts = self.spot_welds();
        let has_ends = |e: &&MeshElement| matches!(e.shape, Shape::Beam2 | Shape::Hex8);
        let of_welds = self.rows.elements().filter(|e| parts.contains(&e.part));
        let welds: Vec<MeshElement> = of_welds.filter(has_ends).copied().collect();
        if welds.is_empty() {
            let message = "*DATABASE_SWFORC: no spot weld is an element";
            let help = "it has no effect: histories are those of beams and solids of \
                        *MAT_SPOTWELD, and of *CONSTRAINED_SPOTWELD with limits";
            self.trouble.warning(place, message, help);
            return Vec::new();
        }
        if welds.len() > MOST {
            let message = format!("*DATABASE_SWFORC: the deck has {} spot welds", welds.len());
            let help = format!(
                "the first {MOST} have histories; name others by *DATABASE_CROSS_SECTION_SET, or \
                 by `[[output.section]]` of a job"
            );
            self.trouble.warning(place, message, help);
        }
        let recorded = welds.len().min(MOST);
        self.map(
            "DATABASE_SWFORC",
            format!("axial and shear forces of {} spot welds", welds.len()),
            format!("sections.csv: forces of {recorded} welds on one of their ends, global axes"),
        );
        let sections = welds.iter().take(MOST).map(|weld| self.weld_section(weld, place));
        sections.collect()
    }

    /// Returns the parts whose elements are spot welds.
    fn spot_welds(&self) -> BTreeSet<u32> {
        let of_law = self.read.iter().filter(|r| r.row.keyword.name.starts_with("MAT_SPOTWELD"));
        let laws: BTreeSet<i64> = of_law.map(|record| record.integer("mid")).collect();
        let parts = self.read.iter().filter(|r| r.row.keyword.name == "PART");
        let own = parts.filter(|part| laws.contains(&part.integer("mid")));
        let own = own.filter_map(|part| u32::try_from(part.integer("pid")).ok());
        own.chain(self.welded_parts.iter().copied()).collect()
    }

    /// Returns the section at the last node of a beam, or at the face of the last four nodes of a
    /// hexahedron: its force is that of the weld on them.
    fn weld_section(&mut self, weld: &MeshElement, place: Place) -> (Place, JobTable) {
        let corners = weld.corners();
        let far = corners.len() / 2;
        let nodes: Vec<NodeId> = corners[far..].to_vec();
        let name = format!("weld-{}", weld.id.label());
        let set = format!("{name}-end");
        self.rows.add_set(set.clone(), nodes, place);
        let table = JobTable::new(place).with("name", place, name).with("nodes", place, set).with(
            "elements",
            place,
            vec![weld.id.0 as i64],
        );
        (place, table)
    }
}
