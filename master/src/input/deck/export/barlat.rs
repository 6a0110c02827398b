//! Writes sheets of Barlat and Lian as cards.

use super::{Blank, DeckWriter, Id, Number, named, points};
use crumple_proto::partition::{Material, Param};
use toml::Value;

/// Writes a material as a card, and after `$crumple:` what the card cannot hold to the last bit.
/// `turned` is true if shells have angles of their own, which replace that of the material.
pub fn material(deck: &mut DeckWriter, material: &Material, mid: u64, title: &str, turned: bool) {
    let given = |key: &str| match material.parameters.get(key) {
        Some(Param::Number(x)) => Some(*x),
        _ => None,
    };
    let number = |key: &str| given(key).map_or(Blank, Number);
    let list = |key: &str| match material.parameters.get(key) {
        Some(Param::List(list)) => list.clone(),
        _ => Vec::new(),
    };
    let mut others: Vec<(String, Value)> = Vec::new();
    let (mut form, mut curve, mut start) =
        ([Number(1.0), Blank, number("yield_stress")], Blank, Blank);
    if let [k, e0, n] = list("swift")[..] {
        (form, start) = ([Number(2.0), Number(k), Number(n)], Number(e0));
    } else if let Some(Param::Table(rows)) = material.parameters.get("hardening") {
        let pairs: Vec<[f64; 2]> =
            rows.iter().filter(|row| row.len() == 2).map(|row| [row[0], row[1]]).collect();
        (form, curve) = ([Number(3.0), Blank, Blank], Id(points(deck, &pairs)));
    } else if let (Some(e), Some(h)) = (given("youngs_modulus"), given("hardening_modulus")) {
        form[1] = Number(e * h / (e + h));
        // The tangent modulus alone does not reproduce it to the last bit.
        others.push(("hardening_modulus".into(), h.into()));
    }
    let direction = list("direction");
    // The format has no angle with aopt 2.
    let has_angle = direction.is_empty() && !turned;
    if let (false, Some(angle)) = (has_angle, given("angle")) {
        others.push(("angle".into(), angle.into()));
    }
    deck.keyword("MAT_3-PARAMETER_BARLAT_TITLE");
    deck.text(title);
    let (e, nu) = (number("youngs_modulus"), number("poisson"));
    deck.card(&[Id(mid), Number(material.density), e, nu, form[0], form[1], form[2]]);
    let or = |key: &str, default: f64| Number(given(key).unwrap_or(default));
    let ratios = ["lankford_0", "lankford_45", "lankford_90"].map(|key| or(key, 1.0));
    deck.card(&[or("exponent", 8.0), ratios[0], ratios[1], ratios[2], curve, start]);
    deck.card(&[if direction.is_empty() { Blank } else { Number(2.0) }]);
    let [a1, a2, a3] = std::array::from_fn(|c| direction.get(c).map_or(Blank, |&x| Number(x)));
    deck.card(&[Blank, Blank, Blank, a1, a2, a3]);
    let angle = if has_angle { number("angle") } else { Blank };
    deck.card(&[Blank, Blank, Blank, Blank, Blank, Blank, angle]);
    if !others.is_empty() {
        deck.entry("material", std::iter::once(named(&material.name)).chain(others).collect());
    }
}
