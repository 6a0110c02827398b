//! Converts `*MAT_3-PARAMETER_BARLAT` (LS-DYNA Keyword User's Manual, vol. II, material 36).

use super::DeckConverter;
use super::materials::{hardening_curve, rows};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

/// Largest `spi` that is a strain; above it is a stress.
const LARGEST_STRAIN: f64 = 0.02;

impl DeckConverter {
    pub(super) fn barlat(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "barlat");
        table.put("exponent", record.place("m"), record.real("m"));
        for (field, key) in [("r00", "lankford_0"), ("r45", "lankford_45"), ("r90", "lankford_90")]
        {
            let ratio = record.real(field);
            if ratio < 0.0 {
                self.unsupported_value(record, field, "a curve over the plastic strain");
            } else {
                table.put(key, record.place(field), ratio);
            }
        }
        match record.real_or("hr", 1.0) {
            1.0 => {
                table.put("yield_stress", record.place("p2"), record.real("p2"));
                let (e, tangent) = (record.real("e"), record.real("p1"));
                let modulus = self.plastic_modulus((record, "p1"), e, tangent);
                if modulus != 0.0 {
                    table.put("hardening_modulus", record.place("p1"), modulus);
                }
            }
            2.0 => self.swift(record, table),
            3.0 => {
                let (id, place) = (record.integer("lcid"), record.place("lcid"));
                if self.tables.contains_key(&id) {
                    self.unsupported_value(record, "lcid", "a table over the strain rate");
                } else if let Some(curve) = self.curve(id, place) {
                    let place = curve.lines.first().copied().unwrap_or(place);
                    table.put("hardening", place, rows(&hardening_curve(curve.points)));
                }
            }
            _ => self.unsupported_value(record, "hr", "use 1, 2 or 3"),
        }
        for field in ["c", "p"].iter().filter(|field| record.real(field) != 0.0) {
            self.unsupported_value(record, field, "the yield stress has no strain rate");
        }
        self.shell_axes(record, "beta", table);
    }

    /// Converts `k (e0 + eps_p)^n`. Without `e0` it follows from `spi`, a strain or a stress, or is
    /// where the curve meets the elastic line.
    fn swift(&mut self, record: &CardRecord, table: &mut JobTable) {
        let [k, n, given, spi] = ["p1", "p2", "e0", "spi"].map(|field| record.real(field));
        let (e0, from) = if given > 0.0 {
            (given, "e0")
        } else if spi == 0.0 {
            ((record.real("e") / k).powf(1.0 / (n - 1.0)), "p1")
        } else if spi <= LARGEST_STRAIN {
            (spi, "spi")
        } else {
            ((spi / k).powf(1.0 / n), "spi")
        };
        table.put("swift", record.place(from), [k, e0, n]);
    }
}
