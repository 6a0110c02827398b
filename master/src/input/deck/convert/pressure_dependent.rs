//! Converts materials with strength by pressure (LS-DYNA Keyword User's Manual, vol. II, materials
//! 5, 110, 111); that of three surfaces is in [`karagozian_case`](super::karagozian_case).

use super::DeckConverter;
use super::materials::{pairs, rows};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

/// Keywords of this file.
pub const KEYWORDS: [&str; 4] = [
    "MAT_JOHNSON_HOLMQUIST_CERAMICS",
    "MAT_JOHNSON_HOLMQUIST_CONCRETE",
    "MAT_SOIL_AND_FOAM",
    THREE_SURFACES,
];
/// The keyword whose pressure is that of an equation of state.
pub(super) const THREE_SURFACES: &str = "MAT_CONCRETE_DAMAGE_REL3";

/// Strength of the format that stands for no limit.
const UNLIMITED: f64 = 1e19;

/// Puts fields as one list, at the place of the first one.
fn list<const N: usize>(
    record: &CardRecord,
    table: &mut JobTable,
    key: &'static str,
    fields: [&str; N],
) {
    table.put(key, record.place(fields[0]), fields.map(|field| record.real(field)));
}

impl DeckConverter {
    /// Converts the parameters of a material and returns Young's modulus [force/length^2].
    pub(super) fn pressure_dependent(
        &mut self,
        keyword: &str,
        record: &CardRecord,
        table: &mut JobTable,
    ) -> f64 {
        if keyword == THREE_SURFACES {
            let bulk = self.three_surfaces(record, table);
            return 3.0 * bulk * (1.0 - 2.0 * record.real("pr"));
        }
        let shear = record.real("g");
        table.put("shear_modulus", record.place("g"), shear);
        let bulk = match keyword {
            "MAT_JOHNSON_HOLMQUIST_CERAMICS" => self.ceramic(record, table),
            "MAT_JOHNSON_HOLMQUIST_CONCRETE" => self.crushed_concrete(record, table),
            _ => self.soil(record, table),
        };
        9.0 * bulk * shear / (3.0 * bulk + shear)
    }

    fn ceramic(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        table.put("law", record.head, "johnson_holmquist_ceramic");
        list(record, table, "intact_strength", ["a", "n"]);
        list(record, table, "fractured_strength", ["b", "m"]);
        list(record, table, "hugoniot_elastic_limit", ["hel", "phel"]);
        table.put("bulking", record.place("beta"), record.real("beta"));
        self.brittle(record, table, "epsi");
        match record.real("fs") {
            0.0 => {}
            strain if strain > 0.0 => table.put("failure_strain", record.place("fs"), strain),
            _ => table.put("fails_in_tension", record.place("fs"), true),
        }
        record.real("k1")
    }

    fn crushed_concrete(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        table.put("law", record.head, "johnson_holmquist_concrete");
        list(record, table, "strength_constants", ["a", "b", "n"]);
        list(record, table, "crushing_point", ["uc", "pc"]);
        list(record, table, "locking_point", ["ul", "pl"]);
        table.put("compressive_strength", record.place("fc"), record.real("fc"));
        table.put("least_fracture_strain", record.place("efmin"), record.real("efmin"));
        self.brittle(record, table, "eps0");
        match record.real("fs") {
            strain if strain > 0.0 => table.put("failure_strain", record.place("fs"), strain),
            _ if record.real("t") == 0.0 => {
                let of = format!("material {}", record.integer("mid"));
                let asked = format!("fs {}, failure in tension", record.real("fs"));
                self.map(of, asked, "not used: it has no tensile strength (t)");
            }
            0.0 => table.put("fails_in_tension", record.place("fs"), true),
            _ => table.put("fails_in_damaged_tension", record.place("fs"), true),
        }
        record.real("pc") / record.real("uc")
    }

    /// Converts what ceramics and concrete have in common; `reference` is the field of the rate.
    fn brittle(&mut self, record: &CardRecord, table: &mut JobTable, reference: &'static str) {
        table.put("tensile_strength", record.place("t"), record.real("t"));
        let most = record.real("sfmax");
        if most != 0.0 && most < UNLIMITED {
            table.put("largest_strength", record.place("sfmax"), most);
        }
        if record.real("c") != 0.0 {
            list(record, table, "rate", ["c", reference]);
        }
        list(record, table, "damage", ["d1", "d2"]);
        list(record, table, "pressure", ["k1", "k2", "k3"]);
    }

    fn soil(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        table.put("law", record.head, "soil");
        let bulk = record.real("bulk");
        table.put("bulk_modulus", record.place("bulk"), bulk);
        list(record, table, "yield_constants", ["a0", "a1", "a2"]);
        match record.real("pc") {
            0.0 => {}
            cutoff if cutoff < 0.0 => table.put("tension_cutoff", record.place("pc"), -cutoff),
            _ => self.unsupported_value(record, "pc", "a pressure; give a tension, below 0"),
        }
        match record.real("vcr") {
            0.0 => {}
            1.0 => table.put("reversible", record.place("vcr"), true),
            _ => self.unsupported_value(record, "vcr", "use 0 or 1"),
        }
        let (id, mut field) = (record.integer("lcid"), "lcid");
        let mut points = match id {
            0 => {
                field = "eps";
                pairs(record, "eps", "p")
            }
            id if self.tables.contains_key(&id) => {
                self.unsupported_value(record, "lcid", "a table over the temperature");
                return bulk;
            }
            id => {
                let Some(curve) = self.curve(id, record.place("lcid")) else { return bulk };
                curve.points
            }
        };
        let place = record.place(field);
        if points.iter().any(|point| point[0] > 0.0) {
            let message = format!("{}: a volume strain is above 0", record.name());
            let help = "volume strains are logarithms of the volume: give them below 0, which is \
                        compression, without points in tension";
            self.trouble.error(place, message, help);
            return bulk;
        }
        // Curves ascend, points of the card descend.
        points.iter_mut().for_each(|point| point[0] = 0.0 - point[0]);
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        if points.is_empty() {
            let message = format!("{}: it has no pressure", record.name());
            self.trouble.error(place, message, "give lcid, or two points of eps and p at least");
            return bulk;
        }
        if points[0][0] > 0.0 {
            points.insert(0, [0.0; 2]);
        }
        table.put("pressure", place, rows(&points));
        bulk
    }
}
