//! Writes thermoplastics as cards.

use super::materials::{CardParameters, MaterialCards};
use super::{Blank, DeckWriter, Id, Number};

/// Keys that a reader has as they are.
const EXACT: [&str; 8] = [
    "tension",
    "tension_by_rate",
    "compression",
    "shear",
    "plastic_poisson",
    "plastic_poisson_curve",
    "damage",
    "convexity",
];

/// Writes a material as a card.
pub fn polymer(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    cards.keep(read, &EXACT);
    let tension = match cards.has("tension_by_rate") {
        true => cards.table(deck, "tension_by_rate"),
        false => cards.curve(deck, "tension"),
    };
    let keys = ["compression", "shear", "plastic_poisson_curve", "damage"];
    let [compression, shear, ratios, damage] = keys.map(|key| cards.curve(deck, key));
    let [e, nu] = ["youngs_modulus", "poisson"].map(|key| cards.number(key));
    let [k, g] = [e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))].map(Number);
    let fails = cards.has("failure_strain");
    if fails {
        cards.keep(read, &["failure_strain"]);
        if cards.number("fading_strain") > 0.0 {
            cards.keep(read, &["fading_strain"]);
        }
    }
    // Blank is one point.
    let points = match cards.has("failed_points") {
        true => {
            if fails || cards.has("damage") {
                cards.keep(read, &["failed_points"]);
            }
            cards.field("failed_points")
        }
        false => Number(-100.0),
    };
    let convexity = cards.has("convexity");
    cards.head(deck, "MAT_SAMP-1");
    let density = Number(cards.material.density);
    deck.card(&[Id(cards.mid), density, k, g, Number(e), Number(nu), Blank, points]);
    deck.card(&[tension, compression, shear, Blank, cards.field("plastic_poisson"), ratios]);
    deck.card(&[damage, cards.field("failure_strain"), cards.field("fading_strain")]);
    let form = if convexity { Number(1.0) } else { Blank };
    deck.card(&[Blank, Blank, Blank, Blank, form, cards.field("convexity")]);
}
