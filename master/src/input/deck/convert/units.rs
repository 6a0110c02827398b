//! Finds the units of a deck from the plausibility of its materials.

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

impl DeckConverter {
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
