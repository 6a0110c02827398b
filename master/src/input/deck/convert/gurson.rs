//! Converts `*MAT_GURSON` (LS-DYNA Keyword User's Manual, vol. II, material 120).

use super::DeckConverter;
use super::materials::{hardening_curve, pairs, rows};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

impl DeckConverter {
    pub(super) fn gurson(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "gurson");
        self.matrix(record, table);
        for (field, key) in [("q1", "q1"), ("q2", "q2"), ("f0", "void_fraction")] {
            table.put(key, record.place(field), record.real(field));
        }
        let [fraction, mean, deviation] = ["fn", "en", "sn"].map(|field| record.real(field));
        if fraction != 0.0 {
            table.put("nucleation", record.place("fn"), [fraction, mean, deviation]);
        }
        let fails = self.void_failure(record, table);
        if fails {
            table.put("critical_void_fraction", record.place("fc"), record.real("fc"));
        }
        match record.real("vgtyp") {
            0.0 => {}
            1.0 => table.put("voids_only_grow", record.place("vgtyp"), true),
            2.0 => table.put("voids_close", record.place("vgtyp"), true),
            _ => self.unsupported_value(record, "vgtyp", "use 0, 1 or 2"),
        }
        let points = record.real_or("numint", 1.0);
        if points < 0.0 {
            self.unsupported_value(record, "numint", "give a number of points from 1 on");
        } else if fails {
            table.put("failed_points", record.place("numint"), points);
        }
        for field in ["lcf0", "lcfc", "lcfn"].iter().filter(|field| record.integer(field) != 0) {
            let why = "a curve over the size of elements; only that of the failure has one (lclf)";
            self.unsupported_value(record, field, why);
        }
    }

    /// Converts the yield stress of the matrix.
    fn matrix(&mut self, record: &CardRecord, table: &mut JobTable) {
        let (id, place) = (record.integer("lcss"), record.place("lcss"));
        if id != 0 {
            if self.tables.contains_key(&id) {
                self.unsupported_value(record, "lcss", "a table over the strain rate");
            } else if let Some(curve) = self.curve(id, place) {
                let place = curve.lines.first().copied().unwrap_or(place);
                table.put("hardening", place, rows(&hardening_curve(curve.points)));
            }
            return;
        }
        let [e, sigy, n] = ["e", "sigy", "n"].map(|field| record.real(field));
        match record.real_or("atyp", 1.0) {
            // sigy ((eps_p + e0)/e0)^(1/n) with e0 = sigy/e.
            1.0 if n >= 1.0 && sigy > 0.0 => {
                let start = sigy / e;
                let strength = sigy * start.powf(-1.0 / n);
                table.put("swift", record.place("n"), [strength, start, 1.0 / n]);
            }
            1.0 => {
                let (field, help) = if sigy > 0.0 {
                    ("n", "give n from 1 on: the yield stress is a power 1/n of the strain")
                } else {
                    ("sigy", "give the yield stress, above 0")
                };
                let message = format!("{}: {field} is {}", record.name(), record.real(field));
                self.trouble.error(record.place(field), message, help);
            }
            2.0 => {
                table.put("yield_stress", record.place("sigy"), sigy);
                self.hardening_modulus(record, e, record.real("etan"), table);
            }
            3.0 => {
                let points = pairs(record, "eps", "es");
                if self.strains_increase(record, &points) {
                    table.put("hardening", record.place("es"), rows(&hardening_curve(points)));
                }
            }
            _ => self.unsupported_value(record, "atyp", "use 1, 2 or 3, or a curve (lcss)"),
        }
    }

    /// Converts the void fraction of failure. Returns false if there is none.
    fn void_failure(&mut self, record: &CardRecord, table: &mut JobTable) -> bool {
        const KEY: &str = "failure_void_fractions";
        let (id, place) = (record.integer("lclf"), record.place("lclf"));
        if id != 0 {
            if let Some(curve) = self.curve(id, place) {
                let place = curve.lines.first().copied().unwrap_or(place);
                table.put(KEY, place, rows(&curve.points));
            }
            return true;
        }
        let points = pairs(record, "l", "ff");
        if !points.is_empty() {
            table.put(KEY, record.place("ff"), rows(&points));
            return true;
        }
        let failure = record.real("ff0");
        if failure != 0.0 {
            table.put("failure_void_fraction", record.place("ff0"), failure);
        }
        failure != 0.0
    }
}
