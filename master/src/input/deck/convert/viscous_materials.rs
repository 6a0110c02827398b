//! Converts materials whose stress relaxes (LS-DYNA Keyword User's Manual, vol. II, materials 6,
//! 61, 62 and 76).

use super::DeckConverter;
use super::soft_materials::number;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

impl DeckConverter {
    /// Converts a material with one decay, as a rate or as a time. Returns Young's modulus of fast
    /// loads [force/length^2].
    pub(super) fn kelvin_maxwell(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        let e = fast_moduli(record, table);
        let decay = record.real("dc");
        let place = record.place("dc");
        match record.real("fo") {
            0.0 => table.put("decay_rate", place, decay),
            1.0 if decay > 0.0 => table.put("decay_rate", place, 1.0 / decay),
            1.0 => {
                let message = format!("{}: the time dc is {decay}", record.name());
                let help = "with fo 1, dc is the time of relaxation: give it above 0";
                self.trouble.error(place, message, help);
            }
            _ => self.unsupported_value(record, "fo", "use 0 (Maxwell) or 1 (Kelvin)"),
        }
        e
    }

    /// Converts a material with series of decays. Returns Young's modulus of fast loads
    /// [force/length^2].
    pub(super) fn general_viscoelastic(
        &mut self,
        record: &CardRecord,
        table: &mut JobTable,
    ) -> f64 {
        table.put("law", record.head, "general_viscoelastic");
        for (field, terms) in [("lcid", "gi and betai"), ("lcidk", "ki and betaki")] {
            if record.integer(field) != 0 {
                let why = format!("a fit to a test; give {terms}");
                self.unsupported_value(record, field, &why);
            }
        }
        if record.real("ef") != 0.0 {
            self.unsupported_value(record, "ef", "an elastic layer; use 0, or MAT_ELASTIC");
        }
        let terms = |modulus: &str, rate: &str| -> Vec<Vec<f64>> {
            let lines = record.lines("gi").map(|line| vec![line.real(modulus), line.real(rate)]);
            lines.filter(|term| term[0] != 0.0).collect()
        };
        let (shear, bulk) = (terms("gi", "betai"), terms("ki", "betaki"));
        let sum = |terms: &[Vec<f64>]| terms.iter().map(|term| term[0]).sum::<f64>();
        let stays = record.real("bulk");
        if shear.is_empty() {
            let message = format!("{}: it has no shear modulus", record.name());
            let help = "give lines with gi and betai, with betai 0 for the modulus of slow loads";
            self.trouble.error(record.place("gi"), message, help);
        }
        if stays != 0.0 && !bulk.is_empty() {
            let why = "next to ki it is not said if they add up; give it as a ki with betaki 0";
            self.unsupported_value(record, "bulk", why);
        }
        let [g, k] = [sum(&shear), if bulk.is_empty() { stays } else { sum(&bulk) }];
        let kept = if bulk.is_empty() { stays } else { 0.0 };
        table.put("bulk_modulus", record.place("bulk"), kept);
        table.put("shear_terms", record.place("gi"), shear);
        if !bulk.is_empty() {
            table.put("bulk_terms", record.place("ki"), bulk);
        }
        9.0 * k * g / (3.0 * k + g)
    }
}

/// Puts the constants of fast loads by the fields bulk and g0, and the modulus of slow ones.
/// Returns Young's modulus of fast loads [force/length^2].
fn fast_moduli(record: &CardRecord, table: &mut JobTable) -> f64 {
    let [bulk, fast] = ["bulk", "g0"].map(|field| record.real(field));
    let e = 9.0 * bulk * fast / (3.0 * bulk + fast);
    let nu = (3.0 * bulk - 2.0 * fast) / (2.0 * (3.0 * bulk + fast));
    table.put("law", record.head, "viscoelastic");
    table.put("youngs_modulus", record.place("bulk"), e);
    table.put("poisson", record.place("bulk"), nu);
    number(record, table, "gi", "long_term_shear_modulus");
    e
}

/// Converts the moduli to those of fast loads; returns Young's modulus [force/length^2].
pub(super) fn viscoelastic(record: &CardRecord, table: &mut JobTable) -> f64 {
    let e = fast_moduli(record, table);
    number(record, table, "beta", "decay_rate");
    e
}

/// Converts foam with a damper. Returns Young's modulus of the bound of the step [force/length^2].
pub(super) fn viscous_foam(record: &CardRecord, table: &mut JobTable) -> f64 {
    table.put("law", record.head, "viscous_foam");
    for (field, key) in [
        ("e1", "youngs_modulus"),
        ("pr", "poisson"),
        ("n1", "stiffness_exponent"),
        ("v2", "viscous_coefficient"),
        ("e2", "viscous_modulus"),
        ("n2", "viscous_exponent"),
    ] {
        number(record, table, field, key);
    }
    record.real("e1") + record.real("e2")
}
