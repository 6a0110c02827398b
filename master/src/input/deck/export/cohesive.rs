//! Writes materials of cohesive elements as cards.

use super::materials::{CardParameters, MaterialCards};
use super::{Blank, CardValue, DeckWriter, Id, Number};
use crumple_proto::job::{Part, Setting};

/// Formulation of the format.
pub const ELFORM: u64 = 19;
const ELASTIC: &str = "cohesive_elastic";

/// Returns the field `intfail` of a part: its integration and number of failed points.
fn intfail(part: Option<&Part>) -> f64 {
    let given = |key: &str| part.and_then(|part| part.parameters.get(key));
    let points = given("failed_points").and_then(Setting::number).unwrap_or(4.0);
    match given("integration") {
        Some(Setting::Word(word)) if word == "nodes" => -points,
        _ => points,
    }
}

/// Writes a material, with the integration of the first part that has it.
pub fn interface(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let keys: Vec<&str> = cards.material.parameters.keys().map(String::as_str).collect();
    cards.keep(read, &keys);
    let per_area = Id(u64::from(cards.flag("density_per_area")));
    let density = Number(cards.material.density);
    let first = [Id(cards.mid), density, per_area, Number(intfail(cards.part))];
    let is_elastic = cards.material.law == ELASTIC;
    let [normal, shear] = ["stiffness_normal", "stiffness_shear"].map(|key| cards.field(key));
    let [strength, of_shear] = ["strength_normal", "strength_shear"].map(|key| cards.field(key));
    let rest: [CardValue; 4] = match is_elastic {
        true => [shear, normal, strength, of_shear],
        false => [normal, shear, cards.field("toughness_normal"), cards.field("toughness_shear")],
    };
    cards.head(deck, if is_elastic { "MAT_COHESIVE_ELASTIC" } else { "MAT_COHESIVE_MIXED_MODE" });
    deck.card(&[first, rest].concat());
    if !is_elastic {
        let exponent = match (cards.has("benzeggagh_kenane"), cards.has("power_exponent")) {
            (true, _) => Number(-cards.number("benzeggagh_kenane")),
            (false, true) => cards.field("power_exponent"),
            (false, false) => Number(1.0),
        };
        let softening = cards.field("stiffness_exponent");
        deck.card(&[exponent, strength, of_shear, Blank, Blank, softening]);
    }
}
