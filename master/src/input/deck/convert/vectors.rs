//! Reads `*DEFINE_VECTOR`: directions, for cards that name one.

use super::DeckConverter;
use crate::input::job::tree::Place;

const VECTOR: &str = "DEFINE_VECTOR";

impl DeckConverter {
    /// Reads all vectors. Those along the axes of a missing coordinate system are left out.
    pub(super) fn vectors(&mut self) {
        for record in self.take_records(VECTOR) {
            for line in record.lines("vid") {
                let tail = ["xt", "yt", "zt"].map(|c| line.real(c));
                let head = ["xh", "yh", "zh"].map(|c| line.real(c));
                let vid = line.integer("vid");
                let along = [0, 1, 2].map(|c| head[c] - tail[c]);
                let lost = "the vector is left out";
                match self.in_global_axes(along, line, "cid", lost) {
                    Some(along) => drop(self.vectors.insert(vid, along)),
                    None => {
                        let reason = format!("*{VECTOR} {vid} is left out");
                        self.left_out.leave_out(VECTOR, vid, reason);
                    }
                }
            }
        }
    }

    /// Returns a vector along global axes, of any length. Without it, reports what is `lost`.
    pub(super) fn vector(&mut self, vid: i64, place: Place, lost: &str) -> Option<[f64; 3]> {
        let found = self.vectors.get(&vid).copied();
        if found.is_none() {
            let known: Vec<String> = self.vectors.keys().map(i64::to_string).collect();
            self.missing_for(place, (&format!("*{VECTOR}"), vid), &known, lost);
        }
        found
    }
}
