//! Writes materials of cohesive elements as cards.

use super::{Blank, CardValue, DeckWriter, Id, Number};
use crumple_proto::job::{Part, Setting};
use crumple_proto::partition::{Material, Param};

/// Formulation of the format.
pub const ELFORM: u64 = 19;

/// Returns the field `intfail` of a part: its integration and number of failed points.
fn intfail(part: Option<&Part>) -> f64 {
    let given = |key: &str| part.and_then(|part| part.parameters.get(key));
    let points = given("failed_points").and_then(Setting::number).unwrap_or(4.0);
    match given("integration") {
        Some(Setting::Word(word)) if word == "nodes" => -points,
        _ => points,
    }
}

/// Writes a material. `part` is the first part that has it: the card has its integration.
pub fn material(
    deck: &mut DeckWriter,
    material: &Material,
    mid: u64,
    title: &str,
    part: Option<&Part>,
) {
    let number = |key: &str| match material.parameters.get(key) {
        Some(Param::Number(x)) => Number(*x),
        _ => Blank,
    };
    let per_area = material.parameters.get("density_per_area") == Some(&Param::Flag(true));
    let first = [Id(mid), Number(material.density), Id(u64::from(per_area)), Number(intfail(part))];
    let [normal, shear] = ["stiffness_normal", "stiffness_shear"].map(number);
    let [strength, of_shear] = ["strength_normal", "strength_shear"].map(number);
    let rest: [CardValue; 4] = match material.law.as_str() {
        "cohesive_elastic" => [shear, normal, strength, of_shear],
        _ => [normal, shear, number("toughness_normal"), number("toughness_shear")],
    };
    deck.keyword(match material.law.as_str() {
        "cohesive_elastic" => "MAT_COHESIVE_ELASTIC_TITLE",
        _ => "MAT_COHESIVE_MIXED_MODE_TITLE",
    });
    deck.text(title);
    deck.card(&[first, rest].concat());
    if material.law == "cohesive_mixed_mode" {
        let exponent = match material.parameters.get("benzeggagh_kenane") {
            Some(Param::Number(m)) => Number(-m),
            _ if material.parameters.contains_key("power_exponent") => number("power_exponent"),
            _ => Number(1.0),
        };
        deck.card(&[exponent, strength, of_shear, Blank, Blank, number("stiffness_exponent")]);
    }
}
