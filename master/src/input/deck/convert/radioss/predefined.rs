//! Converts `/MAT/PLAS_PREDEF`: materials of the format by their names. Each is elastic-plastic
//! with the hardening `a + b eps^n` of a yield stress, an ultimate engineering stress and the
//! engineering strain there, without rate and temperature; the values are those of OpenRadioss
//! (`hm_read_mat02_predef.F90`, which prints them in the listing of the starter).

use super::StarterConverter;
use super::materials::hardening_to;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::units::{self, Units};

/// A material by the start of its name; SI units.
struct Predefined {
    name: &'static str,
    density: f64,
    youngs_modulus: f64,
    poisson: f64,
    /// Yield stress, ultimate engineering stress, engineering strain there.
    tension: [f64; 3],
}

const fn metal(name: &'static str, density: f64, e: f64, nu: f64, tension: [f64; 3]) -> Predefined {
    Predefined { name, density, youngs_modulus: e, poisson: nu, tension }
}

const MATERIALS: [Predefined; 7] = [
    metal("STEEL", 7850.0, 210e9, 0.3, [160e6, 380e6, 0.24]),
    metal("HSS", 7850.0, 210e9, 0.3, [300e6, 510e6, 0.23]),
    metal("UHSS", 7850.0, 210e9, 0.3, [500e6, 1500e6, 0.045]),
    metal("AA5182", 2700.0, 70e9, 0.33, [150e6, 300e6, 0.25]),
    metal("AA6082-T6", 2700.0, 70e9, 0.33, [300e6, 360e6, 0.08]),
    metal("PA6GF30", 1300.0, 7e9, 0.35, [50e6, 100e6, 0.02]),
    metal("PPT40", 1200.0, 4e9, 0.3, [20e6, 30e6, 0.06]),
];

/// Powers of length, time and mass of a density and of a stress.
const DENSITY: [i32; 3] = [-3, 0, 1];
const STRESS: [i32; 3] = [-1, -2, 1];

impl StarterConverter {
    /// Returns the table of a material by its name, with its density and Young's modulus; `None`
    /// after an error.
    pub(super) fn predefined(
        &mut self,
        record: &CardRecord,
        name: &str,
    ) -> Option<(JobTable, [f64; 2])> {
        let (word, place) = (record.word("predef").trim().to_string(), record.place("predef"));
        let Some(of) = MATERIALS.iter().find(|m| word.starts_with(m.name)) else {
            let names: Vec<&str> = MATERIALS.iter().map(|m| m.name).collect();
            let message = format!("{}: there is no material `{word}`", record.name());
            let help = format!("give one of {}", names.join(", "));
            self.deck.trouble.error(place, message, help);
            return None;
        };
        let Some(units) = self.units_of_deck() else {
            let message = format!("{}: the units of the deck are not known", record.name());
            let help = "give its units of mass, length and time in /BEGIN: the values of the \
                        material depend on them";
            self.deck.trouble.error(place, message, help);
            return None;
        };
        let (density, stress) = (of.density / units.factor(DENSITY), units.factor(STRESS));
        let e = of.youngs_modulus / stress;
        let [a, ultimate, strain] = of.tension;
        let [a, b, n] = hardening_to([a / stress, ultimate / stress, strain], e);
        let table = JobTable::new(record.head)
            .with("name", record.place("title"), name)
            .with("density", place, density)
            .with("youngs_modulus", place, e)
            .with("poisson", place, of.poisson)
            .with("law", place, "johnson_cook")
            .with("a", place, a)
            .with("b", place, b)
            .with("n", place, n);
        self.deck.map(
            format!("material {}", record.integer("id")),
            format!("{word}, a material of the format"),
            format!("density {density:.4e}, modulus {e:.4e}, {a:.4e} + {b:.4e} eps^{n:.4}"),
        );
        Some((table, [density, e]))
    }

    /// Returns the units of the deck, those of the International System without others; `None` if
    /// they are not known.
    fn units_of_deck(&self) -> Option<Units> {
        match &self.unit_names {
            Some(names) => units::read(names),
            None => Some(Units::SI),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The constants b and n that OpenRadioss has for these materials.
    #[test]
    fn constants_are_those_of_the_format() {
        let known = [
            ("STEEL", 513_330_169.338_7, 0.325_708_489_959_8),
            ("HSS", 611_407_465.148_3, 0.396_761_345_721_9),
            ("UHSS", 1_306_278_496.309, 0.064_633_693_574_514),
            ("AA5182", 393_050_051.478_1, 0.371_905_918_857),
            ("AA6082-T6", 210_717_297.972_3, 0.336_964_558_487_9),
            ("PA6GF30", 60_557_060.655_832, 0.038_843_615_080_968),
            ("PPT40", 18_439_331.380_79, 0.157_029_769_351_1),
        ];
        for (material, (name, b, n)) in MATERIALS.iter().zip(known) {
            assert_eq!(material.name, name);
            let found = hardening_to(material.tension, material.youngs_modulus);
            assert!((found[1] / b - 1.0).abs() < 1e-6, "{name}: b {} and {b}", found[1]);
            assert!((found[2] / n - 1.0).abs() < 1e-6, "{name}: n {} and {n}", found[2]);
        }
    }
}
