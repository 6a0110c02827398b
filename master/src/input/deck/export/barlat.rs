//! Writes sheets of Barlat and Lian as cards.

use super::materials::{CardParameters, MaterialCards};
use super::metals::tangent;
use super::{Blank, DeckWriter, Number};
use crumple_proto::partition::Param;

/// Keys that a reader has as they are.
const EXACT: [&str; 7] =
    ["exponent", "lankford_0", "lankford_45", "lankford_90", "direction", "yield_stress", "swift"];

/// Writes a material as a card.
pub fn sheet(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    cards.keep(read, &EXACT);
    let (mut form, mut curve, mut start) =
        ([Number(1.0), Blank, cards.field("yield_stress")], Blank, Blank);
    if let [k, e0, n] = *cards.list("swift") {
        (form, start) = ([Number(2.0), Number(k), Number(n)], Number(e0));
    } else if cards.has("hardening") {
        (form, curve) = ([Number(3.0), Blank, Blank], cards.curve(deck, "hardening"));
        cards.keep(read, &["hardening"]);
    } else if cards.has("hardening_modulus") {
        let [of_card, modulus] =
            tangent(cards.number("youngs_modulus"), cards.number("hardening_modulus"));
        form[1] = Number(of_card);
        read.insert("hardening_modulus".into(), Param::Number(modulus));
    }
    let direction = cards.list("direction");
    // The format has no angle with aopt 2.
    let has_angle = direction.is_empty() && !cards.turned;
    let angle = if has_angle { cards.field("angle") } else { Blank };
    if has_angle {
        cards.keep(read, &["angle"]);
    }
    cards.head(deck, "MAT_3-PARAMETER_BARLAT");
    deck.card(&[&cards.elastic()[..], &form].concat());
    let or =
        |key: &str, default: f64| Number(if cards.has(key) { cards.number(key) } else { default });
    let [r0, r45, r90] = ["lankford_0", "lankford_45", "lankford_90"].map(|key| or(key, 1.0));
    deck.card(&[or("exponent", 8.0), r0, r45, r90, curve, start]);
    deck.card(&[if direction.is_empty() { Blank } else { Number(2.0) }]);
    let [a1, a2, a3] = std::array::from_fn(|c| direction.get(c).map_or(Blank, |&x| Number(x)));
    deck.card(&[Blank, Blank, Blank, a1, a2, a3]);
    deck.card(&[Blank, Blank, Blank, Blank, Blank, Blank, angle]);
}
