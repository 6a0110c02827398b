//! Writes materials of cohesive elements as cards.

use super::materials::{CardParameters, MaterialCards};
use super::{Blank, CardValue, DeckWriter, Id, Number};
use crumple_proto::job::{Part, Setting};
use crumple_worker::fem::elements::COHESIVE;
use toml::Value;

/// Formulation of the format.
pub const ELFORM: u64 = 19;
const GAUSS: &str = "gauss";
const ELASTIC: &str = "cohesive_elastic";

const NODES: &str = "nodes";
/// Keys of parts that the field `intfail` of their material holds.
const KEYS: [&str; 2] = ["integration", "failed_points"];

/// Returns the integration and the number of failed points of a part.
fn integration(part: Option<&Part>) -> (&str, f64) {
    let given = |key: &str| part.and_then(|part| part.parameters.get(key));
    let rule = match given(KEYS[0]) {
        Some(Setting::Word(word)) => word,
        _ => GAUSS,
    };
    (rule, given(KEYS[1]).and_then(Setting::number).unwrap_or(4.0))
}

/// Returns true for a key of cohesive parts that the card of the material holds.
pub fn is_on_card(key: &str, part: &Part) -> bool {
    KEYS.contains(&key) && part.element.as_deref() == Some(COHESIVE)
}

/// Returns the keys of a part that differ from the card of its material, which has those of the
/// first part with it.
pub fn differing(part: &Part, parts: &[Part]) -> Vec<(String, Value)> {
    let first = parts.iter().find(|p| p.material == part.material);
    let (rule, points) = integration(Some(part));
    if part.element.as_deref() != Some(COHESIVE) || integration(first) == (rule, points) {
        return Vec::new();
    }
    let [of_rule, of_points] = KEYS.map(String::from);
    vec![(of_rule, rule.into()), (of_points, (points as i64).into())]
}

/// Writes a material, with the integration of the first part that has it.
pub fn interface(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let keys: Vec<&str> = cards.material.parameters.keys().map(String::as_str).collect();
    cards.keep(read, &keys);
    let per_area = Id(u64::from(cards.flag("density_per_area")));
    let density = Number(cards.material.density);
    let (rule, points) = integration(cards.part);
    let intfail = if rule == NODES { -points } else { points };
    let first = [Id(cards.mid), density, per_area, Number(intfail)];
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
