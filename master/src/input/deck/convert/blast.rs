//! Converts `*LOAD_BLAST...`: pressure of explosions on segments.

use super::DeckConverter;
use super::motion::NEVER;
use super::segments::DeckSegment;
use super::tree::JobTable;
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::job::tree::Place;
use std::collections::BTreeMap;

/// Id of the curve on `*LOAD_SEGMENT` that stands for `*LOAD_BLAST`.
pub(super) const AS_CURVE: i64 = -2;
/// Pounds, feet, milliseconds and psi in SI, for conversion factors of the user.
const USER: [f64; 4] = [0.453_592_37, 0.304_8, 1e-3, 6_894.757_293_168];
/// Relative difference of a unit of pressure from that of mass, length and time that counts as
/// round-off of the factors.
const ROUNDED: f64 = 1e-3;

impl DeckConverter {
    /// Returns the tables of the explosions of the deck by their id, with the place of each;
    /// `None` for one that has been reported. That of `*LOAD_BLAST` has [`AS_CURVE`].
    pub(super) fn blasts(&mut self) -> BTreeMap<i64, (Option<JobTable>, Place)> {
        let mut blasts = BTreeMap::new();
        for record in self.take_one("LOAD_BLAST") {
            let why = "use 1 (ground) or 2 (air)";
            let table = self.blast(&record, ["wgt", "iunit", "isurf"], why);
            blasts.insert(AS_CURVE, (table, record.head));
        }
        for record in self.take_records("LOAD_BLAST_ENHANCED") {
            let why = "use 1 (ground) or 2 (air): moving charges (3) and the reflection of an \
                       air burst by the ground (4) are not supported";
            let mut table = self.blast(&record, ["m", "unit", "blast"], why);
            match record.integer("negphs") {
                0 => {}
                1 => {
                    if let Some(table) = &mut table {
                        table.put("suction", record.place("negphs"), false);
                    }
                }
                _ => self.unsupported_value(&record, "negphs", "use 0 or 1"),
            }
            let id = record.integer("bid");
            if id < 1 {
                let message = format!("{}: bid is {id}", record.name());
                self.trouble.error(record.place("bid"), message, "give an id above 0");
                continue;
            }
            if blasts.insert(id, (table, record.head)).is_some() {
                let message = format!("there are two explosions with the id {id}");
                self.trouble.error(record.place("bid"), message, "give each a different id");
            }
        }
        blasts
    }

    /// Converts what both cards have, from their fields of mass, units and place; `None` after a
    /// report. `places` says which places are supported.
    fn blast(
        &mut self,
        record: &CardRecord,
        [mass, unit, place]: [&str; 3],
        places: &str,
    ) -> Option<JobTable> {
        let burst = match record.integer(place) {
            1 => "ground",
            0 | 2 => "air",
            _ => {
                self.unsupported_card(record, place, places);
                return None;
            }
        };
        let death = record.real("death");
        if death > 0.0 && death < NEVER && death < self.end_time {
            let why = "an end of the pressure before that of the run";
            self.unsupported_value(record, "death", why);
        }
        let given = match record.integer(unit) {
            1 => {
                let why = "psi with feet and pounds, which are not consistent: convert the deck";
                self.unsupported_card(record, unit, why);
                return None;
            }
            0 | 2 => [1.0, 1.0, 1.0],
            // lbf s^2/in.
            3 => [0.0254, 1.0, 175.126_835],
            4 => [1e-2, 1e-6, 1e-3],
            5 => self.user_units(record)?,
            6 => [1e-3, 1e-3, 1.0],
            7 => [1e-3, 1.0, 1e3],
            8 => [1e-3, 1e-3, 1e-3],
            _ => {
                self.unsupported_card(record, unit, "use 2 to 4 or 6 to 8, or 5 with factors");
                return None;
            }
        };
        let position = ["xbo", "ybo", "zbo"].map(|c| record.real(c));
        Some(
            JobTable::new(record.head)
                .with("mass", record.place(mass), record.real(mass))
                .with("position", record.place("xbo"), position)
                .with("time", record.place("tbo"), record.real("tbo"))
                .with("burst", record.head, burst)
                .with("si", record.place(unit), given),
        )
    }

    /// Returns the units of length, time and mass in SI from conversion factors to pounds, feet,
    /// milliseconds and psi.
    fn user_units(&mut self, record: &CardRecord) -> Option<[f64; 3]> {
        let names = ["cfm", "cfl", "cft", "cfp"];
        let factors = names.map(|name| record.real(name));
        if let Some(missing) = names.iter().zip(factors).find(|(_, f)| f.is_nan() || *f <= 0.0) {
            let message = format!("{}: `{}` is {}", record.name(), missing.0, missing.1);
            let help = "give the factors of mass, length, time and pressure to pounds, feet, \
                        milliseconds and psi";
            self.trouble.error(record.place(missing.0), message, help);
            return None;
        }
        let [mass, length, time, pressure]: [f64; 4] =
            std::array::from_fn(|c| factors[c] * USER[c]);
        if (mass / (length * time * time) / pressure - 1.0).abs() > ROUNDED {
            let message = format!(
                "{}: cfp is not the unit of pressure of cfm, cfl and cft: {pressure:.6e} Pa and \
                 {:.6e} Pa",
                record.name(),
                mass / (length * time * time)
            );
            let help = "correct the factors: mass, length, time and pressure of a deck are \
                        consistent";
            self.trouble.error(record.place("cfp"), message, help);
            return None;
        }
        Some([length, time, mass])
    }

    /// Converts `*LOAD_BLAST_SEGMENT...`: the explosion, a factor, the place and the faces of each.
    pub(super) fn blast_segments(&mut self) -> Vec<(i64, f64, Place, Vec<DeckSegment>)> {
        let mut loads: Vec<(i64, f64, Place, Vec<DeckSegment>)> = Vec::new();
        for record in self.take_records("LOAD_BLAST_SEGMENT") {
            for line in record.lines("bid") {
                let (bid, scale, place) = (line.integer("bid"), blast_scale(line), line.place);
                let face = vec![super::segments::segment(line)];
                match loads.iter_mut().find(|load| load.0 == bid && load.1 == scale) {
                    Some(load) => load.3.extend(face),
                    None => loads.push((bid, scale, place, face)),
                }
            }
        }
        for record in self.take_records("LOAD_BLAST_SEGMENT_SET") {
            for line in record.lines("bid") {
                let ssid = line.integer("ssid");
                let Some(set) = self.segment_set(ssid, line.place("ssid")) else { continue };
                loads.push((line.integer("bid"), blast_scale(line), line.place, set));
            }
        }
        loads
    }
}

/// Returns the factor of the pressure on a segment or a set. Zero is its default, 1.
fn blast_scale(line: &CardLine) -> f64 {
    Some(line.real("scalep")).filter(|&scale| scale != 0.0).unwrap_or(1.0)
}
