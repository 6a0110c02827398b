//! Writes parts with layers and plies as cards.

use super::materials::MaterialCards;
use super::parts::elform;
use super::{Blank, CardValue, DeckWriter, Id, Number, line, named};
use crumple_proto::job::Part;
use crumple_proto::partition::{Material, Param};
use toml::{Table, Value};

/// Writes a part with layers; layers of several points follow after `$crumple:`.
pub fn part(deck: &mut DeckWriter, part: &Part, materials: &[Material], hourglass: bool) {
    let id = u64::from(part.id);
    deck.keyword("PART_COMPOSITE_LONG");
    deck.text(&line(&part.name));
    deck.card(&[
        Id(id),
        Id(elform(part)),
        Blank,
        if part.offset == 0.0 { Blank } else { Number(-part.offset) },
        Blank,
        if hourglass { Id(id) } else { Blank },
    ]);
    for layer in &part.layer {
        let name = if layer.material.is_empty() { &part.material } else { &layer.material };
        let mid = materials.iter().position(|m| m.name == *name).map_or(0, |i| i as u64 + 1);
        deck.card(&[Id(mid), Number(layer.thickness), Number(layer.angle)]);
    }
    if part.layer.iter().any(|layer| layer.points != 1)
        && let Ok(layers) = Value::try_from(&part.layer)
    {
        deck.entry(
            "part",
            Table::from_iter([("id".into(), part.id.into()), ("layer".into(), layers)]),
        );
    }
}

/// Factor of a strength that is never reached.
const NO_LIMIT: f64 = 1e20;

/// Writes a ply as a card, and after `$crumple:` what the card cannot hold to the last bit.
pub fn ply(deck: &mut DeckWriter, cards: &MaterialCards<'_>) {
    let &MaterialCards { material, mid, turned, .. } = cards;
    let given = |key: &str| match material.parameters.get(key) {
        Some(Param::Number(x)) => *x,
        _ => 0.0,
    };
    let number = |key: &str| match given(key) {
        0.0 => Blank,
        x => Number(x),
    };
    let list = |key: &str| match material.parameters.get(key) {
        Some(Param::List(list)) => list.clone(),
        _ => Vec::new(),
    };
    let direction = list("direction");
    let [a1, a2, a3] = std::array::from_fn(|c| direction.get(c).map_or(Blank, |&x| Number(x)));
    let aopt = if direction.is_empty() { Blank } else { Number(2.0) };
    let tsai_wu = material.parameters.get("tsai_wu") == Some(&Param::Flag(true));
    let negative = |key: &str| match given(key) {
        0.0 => Blank,
        x => Number(-x),
    };
    // A blank ycfac is 2. This one gives a strength above X_C, so that the law keeps X_C.
    let no_crushing = match (given("strength_compression_a"), given("strength_compression_b")) {
        (0.0, _) | (_, 0.0) => NO_LIMIT,
        (xc, yc) => 2.0 * xc / yc,
    };
    cards.head(deck, "MAT_ENHANCED_COMPOSITE_DAMAGE");
    let (ea, eb, nu) = (number("youngs_modulus"), number("youngs_modulus_b"), number("poisson"));
    deck.card(&[Id(mid), Number(material.density), ea, eb, Blank, nu]);
    let shear = ["shear_modulus", "shear_modulus_bc", "shear_modulus_ca"].map(number);
    deck.card(&[shear[0], shear[1], shear[2], Blank, aopt]);
    // The format has no angle with aopt 2.
    let has_angle = direction.is_empty() && !turned;
    let angle = if has_angle { number("angle") } else { Blank };
    deck.card(&[Blank, Blank, Blank, a1, a2, a3, angle]);
    let matrix: CardValue = number("failure_strain_b");
    deck.card(&[Blank, Blank, Blank, Blank, Blank, Blank, matrix]);
    deck.card(&[
        Blank,
        number("shear_nonlinearity"),
        Blank,
        Blank,
        Number(no_crushing),
        number("failure_strain_tension_a"),
        negative("failure_strain_compression_a"),
        number("failure_strain_effective"),
    ]);
    deck.card(&[
        number("strength_compression_a"),
        number("strength_tension_a"),
        number("strength_compression_b"),
        number("strength_tension_b"),
        number("strength_shear"),
        Number(if tsai_wu { 55.0 } else { 54.0 }),
        number("shear_weight"),
    ]);
    let residual = list("residual_strengths");
    if !residual.is_empty() {
        deck.card(&[]);
        deck.card(&residual.iter().map(|&share| Number(share)).collect::<Vec<_>>());
    }
    // Keys whose fields depend on others, are half of the value, or mean something else if they
    // are zero.
    let mut keys = vec![
        "failure_strain_b",
        "failure_strain_shear",
        "crushed_tension_a",
        "crushed_compression_a",
    ];
    if tsai_wu || given("failure_strain_tension_a") == 0.0 {
        keys.extend(["failure_strain_tension_a", "failure_strain_compression_a"]);
        keys.push("failure_strain_effective");
    }
    if !has_angle {
        keys.push("angle");
    }
    let numbers = keys.into_iter().filter(|key| given(key) != 0.0);
    let mut others: Vec<(String, Value)> =
        numbers.map(|key| (key.to_string(), given(key).into())).collect();
    if !residual.is_empty() && residual.iter().all(|share| *share == 0.0) {
        others.push(("residual_strengths".into(), residual.clone().into()));
    }
    if material.parameters.get("shear_energy") == Some(&Param::Flag(true)) {
        others.push(("shear_energy".into(), true.into()));
    }
    if !others.is_empty() {
        deck.digits("material", std::iter::once(named(&material.name)).chain(others).collect());
    }
}
