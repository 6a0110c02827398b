//! Converts `*MAT_FABRIC` (LS-DYNA Keyword User's Manual, vol. II, material 34).

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

impl DeckConverter {
    /// Converts the parameters of a fabric and returns Young's modulus of the yarns a
    /// [force/length^2].
    pub(super) fn fabric(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        table.put("law", record.head, "fabric");
        let put = |table: &mut JobTable, field: &str, key: &str| {
            let value = record.real(field);
            if value != 0.0 {
                table.put(key, record.place(field), value);
            }
        };
        let (ea, eb) = (record.real("ea"), record.real("eb"));
        table.put("youngs_modulus", record.place("ea"), ea);
        let minor = self.minor_ratio(record, ea, eb);
        table.put("poisson", record.place("prba"), minor);
        put(table, "eb", "youngs_modulus_b");
        put(table, "gab", "shear_modulus");
        if eb != 0.0 || record.real("gab") != 0.0 {
            self.shell_axes(record, "beta", table);
        }
        match record.real("cse") {
            0.0 => table.put("compression", record.place("cse"), true),
            1.0 => {}
            _ => self.unsupported_value(record, "cse", "use 0 (compression) or 1 (none)"),
        }
        put(table, "damp", "damping");
        if record.real("lratio") > 0.0 {
            put(table, "lratio", "liner_fraction");
            put(table, "el", "liner_youngs_modulus");
            put(table, "prl", "liner_poisson");
        }
        let form = record.integer("form");
        let of = format!("material {}", record.integer("mid"));
        match form {
            0 | 1 => {}
            2 | 3 | 12 | 13 => self.map(
                of,
                format!("form {form}: another measure of large strains"),
                "logarithmic strains in the axes of the element",
            ),
            _ => self.unsupported_value(record, "form", "curves of stress; use form 0 with moduli"),
        }
        ea
    }

    /// Returns the contraction along a due to tension along b, from prba, or from prab where that
    /// is not given.
    fn minor_ratio(&mut self, record: &CardRecord, ea: f64, eb: f64) -> f64 {
        let (prba, prab) = (record.real("prba"), record.real("prab"));
        let from_major = if ea > 0.0 && eb > 0.0 { prab * eb / ea } else { prab };
        if prba == 0.0 {
            return from_major;
        }
        if prab != 0.0 && (from_major / prba - 1.0).abs() > 1e-3 {
            let message = format!("prab {prab} does not fit prba {prba}");
            let help = "prba is used: prab has to be prba ea/eb, or 0";
            self.trouble.warning(record.place("prab"), message, help);
        }
        prba
    }
}
