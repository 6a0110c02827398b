//! Writes damage of plastic materials as cards.

use super::materials::{CardParameters, MaterialCards};
use super::{Blank, CardValue, DeckWriter, Id, Number};

/// Writes the damage of a material. The card needs a start of the loss of stress and a number of
/// failed points, for which it has defaults that a job does not have.
pub fn gissmo(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    const STRAINS: [&str; 2] = ["gissmo_failure_strain", "gissmo_critical_strain"];
    const NUMBERS: [&str; 4] = [
        "gissmo_failed_points",
        "gissmo_critical_damage",
        "gissmo_exponent",
        "gissmo_fading_exponent",
    ];
    let starts = cards.has(STRAINS[1]) || cards.has(NUMBERS[1]);
    if !(cards.has(STRAINS[0]) && starts && cards.has(NUMBERS[0])) {
        return;
    }
    let failure = cards.curve(deck, STRAINS[0]);
    let critical = match cards.curve(deck, STRAINS[1]) {
        // Curves have ids below zero in this field.
        CardValue::Id(id) => Number(-(id as f64)),
        _ => Blank,
    };
    let sizes = cards.curve(deck, "gissmo_size_factors");
    let [points, damage, exponent, fading] = NUMBERS.map(|key| cards.field(key));
    deck.keyword("MAT_ADD_DAMAGE_GISSMO");
    deck.card(&[Id(cards.mid), Blank, Number(1.0), Blank, points]);
    deck.card(&[failure, critical, exponent, damage, fading, sizes]);
    cards.keep(read, &STRAINS);
    cards.keep(read, &NUMBERS);
    cards.keep(read, &["gissmo_size_factors"]);
}
