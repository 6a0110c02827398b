//! Converts `*INITIAL_AXIAL_FORCE_BEAM`: preloads of beams, such as bolts.

use super::DeckConverter;
use super::sets::{BEAM_SETS, ElementSets};
use crate::input::deck::record::CardLine;
use crate::input::job::tree::Place;
use std::collections::BTreeMap;

/// Preload of a part of beams.
#[derive(Debug)]
pub struct DeckPreload {
    /// Axial stress [force/length^2] over time [time].
    pub points: Vec<Vec<f64>>,
    /// True if fibres keep their differences of stress.
    pub bending: bool,
    /// Place of the set on the card.
    pub place: Place,
}

impl DeckConverter {
    /// Reads the preloads of all parts. The beams and curves are known.
    pub(super) fn read_preloads(&mut self) {
        self.read_sets_of(BEAM_SETS);
        let sets = std::mem::take(&mut self.element_sets[BEAM_SETS]);
        for record in self.take_records("INITIAL_AXIAL_FORCE_BEAM") {
            for line in record.lines("bsid") {
                self.preload(line, &sets, &record.name());
            }
        }
        self.element_sets[BEAM_SETS] = sets;
    }

    fn preload(&mut self, line: &CardLine, sets: &ElementSets, card: &str) {
        let (bsid, place) = (line.integer("bsid"), line.place("bsid"));
        let Some(ranges) = sets.get(&bsid) else {
            let known: Vec<String> = sets.keys().map(i64::to_string).collect();
            return self.missing(place, "*SET_BEAM", bsid, &known);
        };
        let lcid = line.integer("lcid");
        let Some(curve) = self.curve(lcid, line.place("lcid")) else { return };
        let scale = line.real("scale");
        let points: Vec<Vec<f64>> = curve.points.iter().map(|p| vec![p[0], scale * p[1]]).collect();
        let bending = line.integer("kbend") != 0;
        // Beams in the set, and all beams, of each part.
        let mut counts: BTreeMap<i64, [usize; 2]> = BTreeMap::new();
        for (id, part) in self.rows.beams_of_deck() {
            let is_member = ranges.iter().any(|[first, last]| (*first..=*last).contains(&id));
            let count = counts.entry(i64::from(part)).or_default();
            count[0] += usize::from(is_member);
            count[1] += 1;
        }
        counts.retain(|_, [members, _]| *members > 0);
        if counts.is_empty() {
            let message = format!("{card}: set {bsid} has no beams of the deck");
            return self.trouble.error(place, message, "correct the ids of the set");
        }
        for (part, [members, all]) in counts {
            if members < all {
                let message = format!(
                    "{card}: set {bsid} has {members} of the {all} beams of part {part}, and a \
                     preload is that of a whole part: give these beams a part of their own"
                );
                self.unsupported(place, message, format!("{card} of a part of a part"));
                continue;
            }
            let preload = DeckPreload { points: points.clone(), bending, place };
            if self.preloads.insert(part, preload).is_some() {
                let message = format!("{card}: the beams of part {part} have two preloads");
                self.trouble.error(place, message, "remove one of them");
            }
        }
    }

    /// Reports preloads of parts that have no fibres.
    pub(super) fn preloads_without_fibres(&mut self) {
        for (part, preload) in std::mem::take(&mut self.preloads) {
            if self.trouble.is_unsure() {
                return;
            }
            let message = format!(
                "*INITIAL_AXIAL_FORCE_BEAM: the beams of part {part} are trusses or discrete \
                 beams, which have no preload: use elform 1, 2, 4, 5, 9 or 13"
            );
            self.unsupported(preload.place, message, "*INITIAL_AXIAL_FORCE_BEAM".into());
        }
    }
}
