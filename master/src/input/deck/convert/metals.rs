//! Converts metals that extend the law `j2` by damage, strains of failure or anisotropy, and
//! Johnson-Cook without temperature.

use super::DeckConverter;
use super::materials::{hardening_curve, rows};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

/// Keywords of this file.
pub const KEYWORDS: [&str; 5] = [
    "MAT_PLASTICITY_WITH_DAMAGE",
    "MAT_MODIFIED_PIECEWISE_LINEAR_PLASTICITY",
    "MAT_SIMPLIFIED_JOHNSON_COOK",
    "MAT_TRANSVERSELY_ANISOTROPIC_ELASTIC_PLASTIC",
    BARLAT,
];

/// The keyword of `barlat.rs`.
pub const BARLAT: &str = "MAT_3-PARAMETER_BARLAT";

/// Strain or stress from which on a limit of these cards is none: their defaults are 1e12 and more.
const NO_LIMIT: f64 = 1e10;

impl DeckConverter {
    /// Converts the parameters of a material.
    pub(super) fn metal(&mut self, keyword: &str, record: &CardRecord, table: &mut JobTable) {
        match keyword {
            "MAT_PLASTICITY_WITH_DAMAGE" => self.metal_with_damage(record, table),
            "MAT_MODIFIED_PIECEWISE_LINEAR_PLASTICITY" => self.metal_with_strains(record, table),
            "MAT_SIMPLIFIED_JOHNSON_COOK" => self.simplified_johnson_cook(record, table),
            BARLAT => self.barlat(record, table),
            _ => self.anisotropic_metal(record, table),
        }
    }

    fn metal_with_damage(&mut self, record: &CardRecord, table: &mut JobTable) {
        self.piecewise(record, table);
        if record.integer("lcdm") != 0 {
            self.unsupported_value(record, "lcdm", "a curve of damage; use eppf and eppfr");
        }
        // Blank fields are the defaults of the card, which are no limits.
        let or_none = |field: &str| match record.real(field) {
            0.0 => f64::INFINITY,
            given => given,
        };
        let (start, rupture) = (or_none("eppf"), or_none("eppfr"));
        if start >= NO_LIMIT {
            if rupture < NO_LIMIT {
                self.unsupported_value(record, "eppfr", "rupture without a start of damage (eppf)");
            }
            return;
        }
        if rupture >= NO_LIMIT || rupture <= start {
            let message = format!(
                "{}: damage starts at eppf = {start}, and eppfr does not give the plastic strain \
                 at which it is complete",
                record.name()
            );
            let help = "give eppfr, above eppf";
            self.trouble.error(record.place("eppfr"), message, help);
            return;
        }
        table.put("softening", record.place("eppf"), [start, rupture]);
    }

    fn metal_with_strains(&mut self, record: &CardRecord, table: &mut JobTable) {
        self.piecewise(record, table);
        for (field, key, negative) in [
            ("epsthin", "erosion_thinning", "the mean over the thickness"),
            ("epsmaj", "erosion_major_strain", "a filtered strain"),
        ] {
            let limit = record.real(field);
            if limit < 0.0 {
                self.unsupported_value(record, field, negative);
            } else if limit > 0.0 && limit < NO_LIMIT {
                table.put(key, record.place(field), limit);
            }
        }
    }

    fn simplified_johnson_cook(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "johnson_cook");
        for (field, key) in [("a", "a"), ("b", "b")] {
            table.put(key, record.place(field), record.real(field));
        }
        // Without hardening n has no influence, but must be above 0.
        table.put(
            "n",
            record.place("n"),
            if record.real("b") > 0.0 { record.real("n") } else { 1.0 },
        );
        if record.real("c") > 0.0 {
            table.put("c", record.place("c"), record.real("c"));
            table.put("reference_rate", record.place("epso"), record.real_or("epso", 1.0));
        }
        let fail = record.real("psfail");
        if fail > 0.0 && fail < NO_LIMIT {
            table.put("damage", record.place("psfail"), [fail, 0.0, 0.0, 0.0, 0.0]);
        }
        for field in ["sigmax", "sigsat"] {
            if record.real(field) > 0.0 && record.real(field) < NO_LIMIT {
                let why = "a largest stress; give MAT_024 a curve that ends with it";
                self.unsupported_value(record, field, why);
            }
        }
    }

    fn anisotropic_metal(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "j2");
        let lankford = record.real("r");
        if lankford < 0.0 {
            self.unsupported_value(record, "r", "output of strains; give its amount");
        }
        table.put("lankford", record.place("r"), lankford);
        let (curve, place) = (record.integer("hlcid"), record.place("hlcid"));
        if curve == 0 {
            table.put("yield_stress", record.place("sigy"), record.real("sigy"));
            self.hardening_modulus(record, record.real("e"), record.real("etan"), table);
        } else if let Some(curve) = self.curve(curve, place) {
            let place = curve.lines.first().copied().unwrap_or(place);
            table.put("hardening", place, rows(&hardening_curve(curve.points)));
        }
        for (field, why) in [
            ("idy", "a Young's modulus that falls with the plastic strain"),
            ("icfld", "a forming limit"),
        ] {
            if record.integer(field) != 0 {
                self.unsupported_value(record, field, why);
            }
        }
    }
}
