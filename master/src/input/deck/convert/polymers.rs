//! Converts thermoplastics (LS-DYNA Keyword User's Manual, vol. II, material 187).

use super::DeckConverter;
use super::materials::{hardening_curve, rows};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

/// Keywords of this file.
pub const KEYWORDS: [&str; 1] = ["MAT_SAMP-1"];

/// Strain from which on a failure is none; the default of the card is 1e5.
const NO_LIMIT: f64 = 1e4;
/// Percentage of the points, as numint, for all points.
const ALL_POINTS: f64 = -100.0;

impl DeckConverter {
    /// Converts the parameters of a polymer and returns Young's modulus [force/length^2].
    pub(super) fn polymer(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        table.put("law", record.head, "polymer");
        table.put("youngs_modulus", record.place("emod"), record.real("emod"));
        self.tension(record, table);
        for (field, key) in [("lcid_c", "compression"), ("lcid_s", "shear")] {
            let id = record.integer(field);
            if self.tables.contains_key(&id) {
                let why = "a table over the rate: give its slowest curve, rates act as in lcid_t";
                self.unsupported_value(record, field, why);
            } else if id != 0
                && let Some(curve) = self.curve(id, record.place(field))
            {
                let place = curve.lines.first().copied().unwrap_or(record.place(field));
                table.put(key, place, rows(&hardening_curve(curve.points)));
            }
        }
        let fails = self.damage_of_polymer(record, table);
        let points = record.real_or("numint", 1.0);
        if fails && points != ALL_POINTS {
            table.put("failed_points", record.place("numint"), points);
        }
        let nu = self.ratios(record, table);
        table.put("poisson", record.place("nue"), nu);
        record.real("emod")
    }

    fn tension(&mut self, record: &CardRecord, table: &mut JobTable) {
        let (id, place) = (record.integer("lcid_t"), record.place("lcid_t"));
        if !self.tables.contains_key(&id) {
            if let Some(curve) = self.curve(id, place) {
                let place = curve.lines.first().copied().unwrap_or(place);
                table.put("tension", place, rows(&hardening_curve(curve.points)));
            }
            return;
        }
        let Some(rows) = self.table_rows(id, place) else { return };
        if rows.iter().any(|row| row[0] < 0.0) {
            self.unsupported_value(record, "lcid_t", "logarithms of the rates; give the rates");
            return;
        }
        let points = |curve: &[Vec<f64>]| curve.iter().map(|row| [row[1], row[2]]).collect();
        let curves = rows.chunk_by(|a, b| a[0] == b[0]);
        let curves = curves.map(|curve| (curve[0][0], points(curve))).collect();
        let of = format!("material {}", record.integer("mid"));
        table.put("tension_by_rate", place, self.rate_rows(&of, curves));
    }

    /// Puts the plastic Poisson's ratio and the form of the surface. Returns Poisson's ratio.
    fn ratios(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        let (nu, plastic) = (record.real("nue"), record.real("nuep"));
        let id = record.integer("lcid_p");
        if id != 0 {
            let place = record.place("lcid_p");
            if let Some(curve) = self.curve(id, place) {
                let place = curve.lines.first().copied().unwrap_or(place);
                table.put("plastic_poisson_curve", place, rows(&curve.points));
            }
        } else if plastic < 0.0 {
            self.unsupported_value(record, "nuep", "associated flow; give a ratio from 0 to 0.5");
        } else {
            table.put("plastic_poisson", record.place("nuep"), plastic);
        }
        match record.real("iconv") {
            0.0 => {}
            1.0 => {
                let factor = record.real_or("asaf", 1.0);
                table.put("convexity", record.place("iconv"), factor);
            }
            2.0 if id == 0 => return nu.min(plastic.max(0.0)),
            2.0 => self.unsupported_value(record, "iconv", "2 next to lcid_p; use 0 or 1"),
            _ => self.unsupported_value(record, "iconv", "use 0, 1 or 2"),
        }
        nu
    }

    /// Puts damage and failure. Returns false if nothing can fail.
    fn damage_of_polymer(&mut self, record: &CardRecord, table: &mut JobTable) -> bool {
        let id = record.integer("lcid_d");
        if id > 0 {
            let place = record.place("lcid_d");
            if let Some(curve) = self.curve(id, place) {
                let place = curve.lines.first().copied().unwrap_or(place);
                table.put("damage", place, rows(&curve.points));
            }
        } else if id < 0 {
            let why = "yield stresses of the damaged material; give those without damage, and a \
                       curve above 0";
            self.unsupported_value(record, "lcid_d", why);
        }
        let acts = match record.real("incfail") {
            0.0 => true,
            -1.0 => false,
            _ => {
                self.unsupported_value(record, "incfail", "failure by triaxiality; use 0 or -1");
                true
            }
        };
        for (field, why) in [
            ("epfail", "a curve over the strain rate; give a strain"),
            ("deprpt", "a curve over the triaxiality; give a strain"),
        ] {
            if record.real(field) < 0.0 {
                self.unsupported_value(record, field, why);
            }
        }
        let [start, fading] = [record.real_or("epfail", NO_LIMIT), record.real("deprpt")];
        let fails = acts && start > 0.0 && start < NO_LIMIT;
        if fails {
            table.put("failure_strain", record.place("epfail"), start);
            if fading > 0.0 {
                table.put("fading_strain", record.place("deprpt"), fading);
            }
        }
        fails || id > 0
    }
}
