//! Writes damage of plastic materials as cards.

use super::materials::{CardParameters, MaterialCards};
use super::{Blank, CardValue, DeckWriter, Id, Number};

/// Criteria of damage from an onset on: number of the format and key of the curve, to which the
/// ends of the other keys are added.
const ONSETS: [(u64, &str); 3] = [(0, "diem_ductile"), (1, "diem_shear"), (4, "diem_principal")];

/// Writes damage from an onset on. The card needs a number of failed points, for which it has a
/// default that a job does not have.
pub fn diem(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let criteria: Vec<_> = ONSETS.into_iter().filter(|(_, key)| cards.has(key)).collect();
    if criteria.is_empty() || !cards.has("diem_failed_points") {
        return;
    }
    let curves: Vec<CardValue> = criteria.iter().map(|(_, key)| cards.curve(deck, key)).collect();
    deck.keyword("MAT_ADD_DAMAGE_DIEM");
    let count = Number(criteria.len() as f64);
    deck.card(&[Id(cards.mid), count, Blank, Blank, cards.field("diem_failed_points")]);
    cards.keep(read, &["diem_failed_points"]);
    for ((kind, key), curve) in criteria.into_iter().zip(curves) {
        let keys =
            ["pressure", "displacement", "energy", "multiplied"].map(|end| format!("{key}_{end}"));
        let by_energy = cards.has(&keys[2]);
        let growth = cards.number(&keys[if by_energy { 2 } else { 1 }]);
        deck.card(&[Id(kind), curve, cards.field(&keys[0])]);
        let multiplied = Id(u64::from(cards.flag(&keys[3])));
        deck.card(&[Id(u64::from(by_energy)), multiplied, Number(growth)]);
        cards.keep(read, &[key]);
        keys.iter().for_each(|key| cards.keep(read, &[key]));
    }
}

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
