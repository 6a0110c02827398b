//! Units of a deck: those of `*CONTROL_UNITS`, or the first ones in which its materials are
//! plausible.

use super::DeckConverter;
use super::materials::DeckMaterial;
use crate::input::job::tree::Place;
use crate::input::job::units_fit;
use std::collections::HashMap;

/// Consistent sets of units, the most usual first.
const SETS: [&str; 10] = [
    "mm, ms, kg",
    "mm, s, tonne",
    "m, s, kg",
    "mm, ms, g",
    "cm, us, g",
    "m, ms, kg",
    "cm, ms, g",
    "mm, us, g",
    "in, s, slinch",
    "ft, s, slug",
];

/// Units of length, time and mass in `*CONTROL_UNITS`, and their names in a job. The first ones are
/// those of blanks.
const STATED: [&[(&str, &str)]; 3] = [
    &[("m", "m"), ("mm", "mm"), ("cm", "cm"), ("in", "in"), ("ft", "ft")],
    &[("sec", "s"), ("ms", "ms"), ("micro_s", "us")],
    &[("kg", "kg"), ("g", "g"), ("mtrc_ton", "tonne"), ("slug", "slug"), ("slinch", "slinch")],
];

/// Returns the units of a job as `*CONTROL_UNITS` has them; `None` if a reader would give them
/// another form.
pub(in crate::input::deck) fn stated(units: &str) -> Option<[&'static str; 3]> {
    let names: Vec<&str> = units.split(", ").collect();
    let [length, time, mass]: [&str; 3] = names.try_into().ok()?;
    let word = |of: usize, name: &str| STATED[of].iter().find(|u| u.1 == name).map(|u| u.0);
    Some([word(0, length)?, word(1, time)?, word(2, mass)?])
}

impl DeckConverter {
    /// Returns the units that a deck states, with their place.
    fn stated_units(&mut self) -> Option<(String, Place)> {
        let record = self.take_one("CONTROL_UNITS").pop()?;
        let mut names = Vec::new();
        for (field, known) in ["length", "time", "mass"].iter().zip(STATED) {
            let word = record.word(field).trim();
            let is_word = |unit: &&(&str, &str)| unit.0.eq_ignore_ascii_case(word);
            let found = if word.is_empty() { known.first() } else { known.iter().find(is_word) };
            let Some((_, name)) = found else {
                let words: Vec<&str> = known.iter().map(|unit| unit.0).collect();
                let message = format!("{}: {field} {word} is not known", record.name());
                let help = format!("known are {}; the units are guessed", words.join(", "));
                self.trouble.warning(record.place(field), message, help);
                return None;
            };
            names.push(*name);
        }
        Some((names.join(", "), record.head))
    }

    /// Adds the materials in use to the job, and the units in which they are plausible.
    pub(super) fn units(&mut self, materials: &mut HashMap<i64, DeckMaterial>) {
        let mut used = Vec::new();
        let mut first = None;
        for id in std::mem::take(&mut self.used_materials) {
            let Some(material) = materials.get_mut(&id) else { continue };
            first = first.or(Some(material.place));
            if !material.skin {
                used.push((material.density, material.youngs_modulus));
            }
            if let Some(table) = material.table.take() {
                self.add("material", table);
            }
        }
        if let Some((units, place)) = self.stated_units() {
            self.tree.set("units", place, units);
            return;
        }
        let Some(first) = first.filter(|_| !used.is_empty()) else { return };
        let fits = |units: &&&str| used.iter().all(|&(density, e)| units_fit(units, density, e));
        match SETS.iter().find(fits) {
            Some(units) => {
                self.map(
                    "units",
                    "not given in a deck",
                    format!("{units}: densities and wave speeds are plausible"),
                );
                self.tree.set("units", Place::Whole, format!("{units} (guessed)"));
            }
            None => {
                let figures: Vec<String> = used
                    .iter()
                    .map(|(density, e)| {
                        format!(
                            "density {density:.4e} with sqrt(E/rho) {:.4e}",
                            (e / density).sqrt()
                        )
                    })
                    .collect();
                let message = format!(
                    "these materials are not plausible in any usual units: {}",
                    figures.join("; ")
                );
                self.trouble.warning(
                    first,
                    message,
                    format!("check their numbers; usual units are {}", SETS.join("; ")),
                );
            }
        }
    }
}
