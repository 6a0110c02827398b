//! Converts materials of cohesive elements, and parts that have them (LS-DYNA Keyword User's
//! Manual, vol. II, materials 138, 184, 185 and 240).

use super::DeckConverter;
use super::materials::DeckMaterial;
use super::parts::Shapes;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;

/// Keywords of this file.
pub const KEYWORDS: [&str; 4] =
    ["MAT_COHESIVE_MIXED_MODE", "MAT_COHESIVE_ELASTIC", "MAT_COHESIVE_TH", ELASTOPLASTIC];

const ELASTOPLASTIC: &str = "MAT_COHESIVE_MIXED_MODE_ELASTOPLASTIC_RATE";

/// Formulation of cohesive elements between solids.
pub(super) const ELFORM: i64 = 19;

/// Integration of the elements of a material.
#[derive(Clone, Copy, Debug)]
pub struct CohesiveIntegration {
    /// `intfail`: above 0 points of Gauss, otherwise at the nodes; its size is the number of failed
    /// points from which on an element is removed, 0 for none.
    pub intfail: f64,
    /// Place of the field.
    pub place: Place,
}

/// Fields and keys of stiffnesses.
const STIFFNESSES: [(&str, &str); 2] = [("en", "stiffness_normal"), ("et", "stiffness_shear")];

/// Puts numbers as they are.
fn put_numbers(record: &CardRecord, table: &mut JobTable, pairs: &[(&str, &str)]) {
    for (field, key) in pairs {
        table.put(key, record.place(field), record.real(field));
    }
}

fn elastic(record: &CardRecord, table: &mut JobTable) {
    table.put("law", record.head, "cohesive_elastic");
    put_numbers(record, table, &STIFFNESSES);
    for (field, key) in [("fn_fail", "strength_normal"), ("ft_fail", "strength_shear")] {
        if record.real(field) != 0.0 {
            put_numbers(record, table, &[(field, key)]);
        }
    }
}

impl DeckConverter {
    /// Converts the parameters of a cohesive material.
    pub(super) fn cohesive(
        &mut self,
        keyword: &str,
        record: &CardRecord,
        table: &mut JobTable,
    ) -> CohesiveIntegration {
        match record.integer("roflg") {
            0 => {}
            1 => {
                table.put("density_per_area", record.place("roflg"), true);
            }
            _ => self.unsupported_value(record, "roflg", "use 0 (per volume) or 1 (per area)"),
        }
        match keyword {
            "MAT_COHESIVE_ELASTIC" => elastic(record, table),
            "MAT_COHESIVE_TH" => self.with_plateau(record, table),
            ELASTOPLASTIC => self.elastoplastic(record, table),
            _ => self.mixed_mode(record, table),
        }
        let intfail = record.real("intfail");
        if intfail.fract() != 0.0 {
            self.unsupported_value(record, "intfail", "a number of points is whole");
        }
        CohesiveIntegration { intfail, place: record.place("intfail") }
    }

    fn with_plateau(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "cohesive_tvergaard_hutchinson");
        put_numbers(
            record,
            table,
            &[
                ("sigmax", "strength"),
                ("nls", "separation_normal"),
                ("tls", "separation_shear"),
                ("stfsf", "pressure_factor"),
            ],
        );
        let end = record.real("lamdaf");
        if end > 0.0 {
            for (field, key) in [("lamda1", "peak_share"), ("lamda2", "softening_share")] {
                table.put(key, record.place(field), record.real(field) / end);
            }
        } else {
            let message = format!("{}: `lamdaf` is {end}", record.name());
            let help = "it is the opening at separation, over which lamda1 and lamda2 are taken: \
                        give it above 0, such as 1";
            self.trouble.error(record.place("lamdaf"), message, help);
        }
        if record.real("stfsf") == 0.0 {
            let message = format!("{}: `stfsf` is blank or 0", record.name());
            let help = "the faces pass through each other without a force; give the stiffness \
                        under pressure over that of opening, such as 1";
            self.trouble.warning(record.place("stfsf"), message, help);
        }
    }

    fn elastoplastic(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "cohesive_elastoplastic");
        let thickness = record.real("thick");
        if thickness <= 0.0 {
            let message = format!("{}: `thick` is blank or not above 0", record.name());
            let help = "the stiffnesses are emod and gmod over it, and it is not taken from the \
                        nodes: give the thickness of the layer";
            self.trouble.error(record.place("thick"), message, help);
        }
        if record.real("inicrt") != 0.0 {
            self.unsupported_value(record, "inicrt", "yield is on the ellipse of strengths, 0");
        }
        for (modulus, toughness, strength, share, mode) in
            [("emod", "g1c_0", "t0", "fg1", "normal"), ("gmod", "g2c_0", "s0", "fg2", "shear")]
        {
            let stiffness = record.real(modulus) / thickness;
            let [work, limit, given] = [toughness, strength, share].map(|f| record.real(f));
            table.put(&format!("stiffness_{mode}"), record.place(modulus), stiffness);
            let rates = [(toughness, work), (strength, limit)].map(|(field, value)| {
                if value < 0.0 {
                    let why = "there are no rates; give the value of the rate of interest, above 0";
                    self.unsupported_value(record, field, why);
                }
                value < 0.0
            });
            if rates.contains(&true) {
                continue;
            }
            table.put(&format!("toughness_{mode}"), record.place(toughness), work);
            table.put(&format!("strength_{mode}"), record.place(strength), limit);
            // Below 0 it is the share of the opening from yield to separation that flow takes.
            let of_work = match given {
                f if f >= 0.0 => f,
                f => -f * (2.0 - limit * limit / (stiffness * work)) / (1.0 - f),
            };
            table.put(&format!("plateau_{mode}"), record.place(share), of_work);
        }
    }

    fn mixed_mode(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "cohesive_mixed_mode");
        put_numbers(record, table, &STIFFNESSES);
        let id = record.integer("mid");
        for (toughness, peak, end, keys) in [
            ("gic", "t", "und", ["toughness_normal", "strength_normal"]),
            ("giic", "s", "utd", ["toughness_shear", "strength_shear"]),
        ] {
            let [work, strength, opening] = [toughness, peak, end].map(|f| record.real(f));
            if work < 0.0 {
                self.unsupported_value(record, toughness, "a curve over the size of the element");
                continue;
            }
            table.put(keys[0], record.place(toughness), work);
            if strength < 0.0 {
                self.unsupported_value(record, peak, "a curve over the size of the element");
            } else if strength > 0.0 {
                table.put(keys[1], record.place(peak), strength);
                if opening != 0.0 {
                    let of = format!("material {id}");
                    self.map(of, format!("{end} {opening}"), format!("not used: {peak} is given"));
                }
            } else if opening > 0.0 {
                table.put(keys[1], record.place(end), 2.0 * work / opening);
            } else {
                let message = format!("{}: neither `{peak}` nor `{end}` is given", record.name());
                let help = format!(
                    "give the strength {peak}, or the opening {end} at separation, from which it \
                     follows as 2 {toughness}/{end}"
                );
                self.trouble.error(record.place(peak), message, help);
            }
        }
        let (exponent, place) = (record.real("xmu"), record.place("xmu"));
        if exponent < 0.0 {
            table.put("benzeggagh_kenane", place, -exponent);
            table.put("stiffness_exponent", record.place("gamma"), record.real("gamma"));
        } else {
            table.put("power_exponent", place, exponent);
        }
    }

    /// Checks that cohesive elements have a cohesive material, and others do not. Returns true if
    /// the part is one of cohesive elements, with their keys in `table`.
    pub(super) fn cohesive_part(
        &mut self,
        record: &CardRecord,
        (elform, at): (i64, Place),
        material: &DeckMaterial,
        shapes: Shapes,
        table: &mut JobTable,
    ) -> bool {
        let id = record.integer("pid");
        let is_cohesive = elform == ELFORM;
        match (is_cohesive, material.cohesive) {
            (false, None) => return false,
            (true, Some(integration)) => {
                table.put("element", at, "cohesive");
                let rule = if integration.intfail > 0.0 { "gauss" } else { "nodes" };
                table.put("integration", integration.place, rule);
                table.put("failed_points", integration.place, integration.intfail.abs() as i64);
                self.map(format!("part {id}"), "solids, elform 19", "cohesive elements");
            }
            (true, None) => {
                let message = format!("part {id}: its material is not for cohesive elements");
                let help = "give it a *MAT_COHESIVE_..., or a *SECTION_SOLID with another elform";
                self.trouble.error(record.place("mid"), message, help);
            }
            (false, Some(_)) => {
                let message = format!("part {id}: its material is for cohesive elements only");
                let help = "give it a *SECTION_SOLID with elform 19, or another material";
                self.trouble.error(record.place("mid"), message, help);
            }
        }
        if is_cohesive && shapes.have_others_than_hexahedra() {
            let message = format!("part {id}: cohesive elements of elform 19 have eight nodes");
            let help = "move wedges and tetrahedra to another part; cohesive wedges (elform 21) \
                        are not supported";
            self.trouble.error(record.place("secid"), message, help);
        }
        true
    }
}
