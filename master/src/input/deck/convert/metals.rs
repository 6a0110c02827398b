//! Converts metals that extend the law `j2` by damage, strains of failure or anisotropy, and
//! Johnson-Cook without temperature.

use super::DeckConverter;
use super::materials::{hardening_curve, rates, rows};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

/// Keywords of this file.
pub const KEYWORDS: [&str; 7] = [
    "MAT_PLASTICITY_WITH_DAMAGE",
    "MAT_MODIFIED_PIECEWISE_LINEAR_PLASTICITY",
    "MAT_SIMPLIFIED_JOHNSON_COOK",
    "MAT_POWER_LAW_PLASTICITY",
    "MAT_TRANSVERSELY_ANISOTROPIC_ELASTIC_PLASTIC",
    BARLAT,
    "MAT_GURSON",
];

/// The keyword of `barlat.rs`.
pub const BARLAT: &str = "MAT_3-PARAMETER_BARLAT";

/// Largest value of sigy of a power law that is a strain.
const STRAIN_AT_YIELD: f64 = 0.02;
/// Strain from which on the curve of a power law has steps of 5 %.
const LEAST_STRAIN: f64 = 1e-6;
/// Strain at which the curve of a power law ends; its last slope continues it.
const LARGEST_PLASTIC_STRAIN: f64 = 3.0;
/// Strain or stress from which on a limit of these cards is none: their defaults are 1e12 and more.
const NO_LIMIT: f64 = 1e10;

impl DeckConverter {
    /// Converts the parameters of a material.
    pub(super) fn metal(&mut self, keyword: &str, record: &CardRecord, table: &mut JobTable) {
        match keyword {
            "MAT_PLASTICITY_WITH_DAMAGE" => self.metal_with_damage(record, table),
            "MAT_MODIFIED_PIECEWISE_LINEAR_PLASTICITY" => self.metal_with_strains(record, table),
            "MAT_SIMPLIFIED_JOHNSON_COOK" => self.simplified_johnson_cook(record, table),
            "MAT_POWER_LAW_PLASTICITY" => self.power_law(record, table),
            BARLAT => self.barlat(record, table),
            "MAT_GURSON" => self.gurson(record, table),
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
        let is_given = |field: &str| (0.0..NO_LIMIT).contains(&record.real(field));
        let limits = ["sigmax", "sigsat"].map(|field| record.real(field) > 0.0 && is_given(field));
        // The limit before the rate, and that with it.
        let limit = match limits {
            [true, _] if record.real("vp") == 1.0 => {
                self.map(
                    record.name(),
                    format!("sigmax {} with vp 1", record.real("sigmax")),
                    "not used, as in LS-DYNA",
                );
                None
            }
            [true, false] => Some("sigmax"),
            [false, true] if record.real("c") == 0.0 => Some("sigsat"),
            [_, true] => {
                let why = "a largest stress that the rate does not scale; give sigmax alone, or \
                           MAT_024 a table of curves that end with it";
                self.unsupported_value(record, "sigsat", why);
                None
            }
            _ => None,
        };
        if let Some(field) = limit {
            let (limit, place) = (record.real(field), record.place(field));
            if limit <= record.real("a") {
                // The limit is the yield stress.
                table.put("a", place, limit);
                table.put("b", place, 0.0);
            }
            table.put("largest_stress", place, limit);
        }
    }

    /// Converts the yield stress `k (e_y + eps_p)^n` to a curve. The strain at yield e_y follows
    /// from sigy, or is that at which the power law meets the elastic line.
    fn power_law(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "j2");
        let [e, k, n, sigy] = ["e", "k", "n", "sigy"].map(|field| record.real(field));
        let mut wrong = |field: &str, what: String, help: &str| {
            let message = format!("{}: {what}", record.name());
            self.trouble.error(record.place(field), message, help);
        };
        if k.is_nan() || k <= 0.0 {
            return wrong("k", format!("k is {k}"), "give the strength, a stress above 0");
        }
        if !(0.0..1.0).contains(&n) {
            let what = format!("n is {n}");
            return wrong("n", what, "give the exponent of hardening, from 0 to below 1");
        }
        let first = match sigy {
            0.0 => (e / k).powf(1.0 / (n - 1.0)),
            strain if strain <= STRAIN_AT_YIELD => strain,
            // Without hardening the strain has no influence.
            _ if n == 0.0 => 1.0,
            stress => (stress / k).powf(1.0 / n),
        };
        if !(first.is_finite() && first > 0.0) {
            let what = format!("sigy is {sigy} and n is {n}: they give no strain at yield");
            return wrong("sigy", what, "give the yield stress as sigy, and an n well below 1");
        }
        // A straight line over a step of 5 % is off by n (1 - n)/8 of 0.0025 at most: 8e-5.
        let strains = std::iter::successors(Some(first), |&strain| {
            let next = (1.05 * strain).max(LEAST_STRAIN);
            (strain < LARGEST_PLASTIC_STRAIN).then_some(next)
        });
        let points: Vec<[f64; 2]> =
            strains.map(|strain| [strain - first, k * strain.powf(n)]).collect();
        table.put("hardening", record.place("k"), rows(&hardening_curve(points)));
        let vp = record.real("vp");
        let is_flag = [0.0, 1.0, -1.0].contains(&vp);
        if rates(record, "src", "srp", table) {
            self.viscoplastic(record, table);
        } else if !is_flag {
            let message = format!(
                "{}: vp is {vp}, which is neither 0 nor 1, and is not used: there are no rates",
                record.name()
            );
            let help = "the order of this card is sigy, vp, epsf: if this is the strain of \
                        failure, give it as epsf, in columns 21 to 30";
            self.trouble.warning(record.place("vp"), message, help);
        }
        if record.real("epsf") > 0.0 {
            table.put("failure_strain", record.place("epsf"), record.real("epsf"));
        }
    }

    fn anisotropic_metal(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "j2");
        let given = record.real("r");
        if given < 0.0 {
            let asked = format!("r {given}: a treatment of thinning for long runs");
            self.map(record.name(), asked, format!("lankford {}", -given));
        }
        table.put("lankford", record.place("r"), given.abs());
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
