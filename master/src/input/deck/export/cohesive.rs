//! Writes materials of cohesive elements as cards.

use super::materials::{CardParameters, MaterialCards};
use super::{Blank, CardValue, DeckWriter, Id, Number};
use crumple_proto::job::{Part, Setting};
use crumple_worker::fem::elements::COHESIVE;
use toml::Value;

/// Formulation of the format.
pub const ELFORM: u64 = 19;
const GAUSS: &str = "gauss";

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

/// Writes a material, with the integration of the first part that has it. Returns false, and
/// writes nothing, for a law without a card.
pub fn write(
    deck: &mut DeckWriter,
    law: &str,
    cards: &MaterialCards<'_>,
    read: &mut CardParameters,
) -> bool {
    let (keyword, second): (_, fn(&MaterialCards<'_>) -> InterfaceCards) = match law {
        "cohesive_elastic" => ("MAT_COHESIVE_ELASTIC", elastic),
        "cohesive_mixed_mode" => ("MAT_COHESIVE_MIXED_MODE", mixed_mode),
        "cohesive_tvergaard_hutchinson" => ("MAT_COHESIVE_TH", with_plateau),
        "cohesive_elastoplastic" => ("MAT_COHESIVE_MIXED_MODE_ELASTOPLASTIC_RATE", elastoplastic),
        _ => return false,
    };
    let keys: Vec<&str> = cards.material.parameters.keys().map(String::as_str).collect();
    cards.keep(read, &keys);
    let per_area = Id(u64::from(cards.flag("density_per_area")));
    let density = Number(cards.material.density);
    let (rule, points) = integration(cards.part);
    let intfail = if rule == NODES { -points } else { points };
    let first = [Id(cards.mid), density, per_area, Number(intfail)];
    cards.head(deck, keyword);
    let (rest, others) = second(cards);
    deck.card(&[&first[..], &rest].concat());
    others.iter().for_each(|card| deck.card(card));
    true
}

/// Fields after those that all materials have: of the first card, and further cards.
type InterfaceCards = (Vec<CardValue>, Vec<Vec<CardValue>>);

fn elastic(cards: &MaterialCards<'_>) -> InterfaceCards {
    let keys = ["stiffness_shear", "stiffness_normal", "strength_normal", "strength_shear"];
    (keys.map(|key| cards.field(key)).to_vec(), Vec::new())
}

fn mixed_mode(cards: &MaterialCards<'_>) -> InterfaceCards {
    let keys = ["stiffness_normal", "stiffness_shear", "toughness_normal", "toughness_shear"];
    let exponent = match (cards.has("benzeggagh_kenane"), cards.has("power_exponent")) {
        (true, _) => Number(-cards.number("benzeggagh_kenane")),
        (false, true) => cards.field("power_exponent"),
        (false, false) => Number(1.0),
    };
    let [strength, of_shear] = ["strength_normal", "strength_shear"].map(|key| cards.field(key));
    let softening = cards.field("stiffness_exponent");
    let second = vec![exponent, strength, of_shear, Blank, Blank, softening];
    (keys.map(|key| cards.field(key)).to_vec(), vec![second])
}

fn with_plateau(cards: &MaterialCards<'_>) -> InterfaceCards {
    let keys = ["strength", "separation_normal", "separation_shear"];
    let [first, second] = ["peak_share", "softening_share"].map(|key| cards.field(key));
    let factor = match cards.has("pressure_factor") {
        true => cards.number("pressure_factor"),
        false => 1.0,
    };
    let shares = vec![first, second, Number(1.0), Number(factor)];
    (keys.map(|key| cards.field(key)).to_vec(), vec![shares])
}

fn elastoplastic(cards: &MaterialCards<'_>) -> InterfaceCards {
    let stiffness = ["stiffness_normal", "stiffness_shear"].map(|key| cards.field(key));
    let modes = ["normal", "shear"].map(|mode| {
        let [work, limit, share] =
            ["toughness", "strength", "plateau"].map(|what| cards.field(&format!("{what}_{mode}")));
        vec![work, Blank, Blank, limit, Blank, Blank, share]
    });
    // Moduli are stiffnesses times the thickness.
    ([&stiffness[..], &[Number(1.0)]].concat(), modes.to_vec())
}
