//! Writes ceramics, concrete in high pressures, and soil as cards.

use super::materials::{CardParameters, MaterialCards};
use super::{Blank, CardValue, DeckWriter, Id, Number, points};
use crumple_proto::partition::Param;

/// Strain that no point reaches: the format has no other word for no limit.
const NEVER: f64 = 1e20;

/// Writes the card of a law; returns false if it has none.
pub fn write(
    deck: &mut DeckWriter,
    law: &str,
    cards: &MaterialCards<'_>,
    read: &mut CardParameters,
) -> bool {
    match law {
        "johnson_holmquist_ceramic" => ceramic(deck, cards, read),
        "johnson_holmquist_concrete" => concrete(deck, cards, read),
        "soil" => soil(deck, cards, read),
        "karagozian_case_concrete" => three_surfaces(deck, cards, read),
        _ => return false,
    }
    true
}

/// Returns id, density and shear modulus.
fn first(cards: &MaterialCards<'_>) -> [CardValue; 3] {
    [Id(cards.mid), Number(cards.material.density), Number(cards.number("shear_modulus"))]
}

/// Returns the numbers of a list, blanks if it is not given.
fn list<const N: usize>(cards: &MaterialCards<'_>, key: &str) -> [CardValue; N] {
    let list = cards.list(key);
    std::array::from_fn(|k| list.get(k).map_or(Blank, |&x| Number(x)))
}

/// Returns the constants of damage, and the numbers of a reader where the job has none.
fn damage(cards: &MaterialCards<'_>, read: &mut CardParameters) -> [CardValue; 2] {
    if cards.has("damage") {
        return list(cards, "damage");
    }
    read.insert("damage".into(), Param::List(vec![NEVER, 0.0]));
    [Number(NEVER), Number(0.0)]
}

fn ceramic(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let lists = ["intact_strength", "hugoniot_elastic_limit", "rate", "damage", "pressure"];
    let numbers = ["shear_modulus", "tensile_strength", "largest_strength", "bulking"];
    cards.keep(read, &lists);
    cards.keep(read, &numbers);
    cards.keep(read, &["fractured_strength"]);
    let [a, n] = list(cards, "intact_strength");
    let [b, m] = list(cards, "fractured_strength");
    let [c, reference] = list(cards, "rate");
    let [hel, pressure] = list(cards, "hugoniot_elastic_limit");
    let [k1, k2, k3] = list(cards, "pressure");
    let [d1, d2] = damage(cards, read);
    // The card has one of both.
    let fails = match cards.flag("fails_in_tension") {
        true => {
            cards.keep(read, &["fails_in_tension"]);
            Number(-1.0)
        }
        false => {
            cards.keep(read, &["failure_strain"]);
            cards.field("failure_strain")
        }
    };
    let [tension, largest, bulking] =
        ["tensile_strength", "largest_strength", "bulking"].map(|key| cards.field(key));
    cards.head(deck, "MAT_JOHNSON_HOLMQUIST_CERAMICS");
    deck.card(&[&first(cards)[..], &[a, b, c, m, n]].concat());
    deck.card(&[reference, tension, largest, hel, pressure, bulking]);
    deck.card(&[d1, d2, k1, k2, k3, fails]);
}

fn concrete(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let lists =
        ["strength_constants", "crushing_point", "locking_point", "rate", "damage", "pressure"];
    let numbers = [
        "shear_modulus",
        "compressive_strength",
        "tensile_strength",
        "largest_strength",
        "least_fracture_strain",
    ];
    cards.keep(read, &lists);
    cards.keep(read, &numbers);
    let [a, b, n] = list(cards, "strength_constants");
    let [c, reference] = list(cards, "rate");
    let [uc, pc] = list(cards, "crushing_point");
    let [ul, pl] = list(cards, "locking_point");
    let [k1, k2, k3] = list(cards, "pressure");
    let [d1, d2] = damage(cards, read);
    // The card has one way to fail.
    let fails = if cards.flag("fails_in_tension") {
        cards.keep(read, &["fails_in_tension"]);
        Number(0.0)
    } else if cards.flag("fails_in_damaged_tension") {
        cards.keep(read, &["fails_in_damaged_tension"]);
        Number(-1.0)
    } else if cards.has("failure_strain") {
        cards.keep(read, &["failure_strain"]);
        cards.field("failure_strain")
    } else {
        read.insert("failure_strain".into(), Param::Number(NEVER));
        Number(NEVER)
    };
    let field = |key: &str| cards.field(key);
    cards.head(deck, "MAT_JOHNSON_HOLMQUIST_CONCRETE");
    deck.card(&[&first(cards)[..], &[a, b, c, n, field("compressive_strength")]].concat());
    let strengths = [
        field("tensile_strength"),
        reference,
        field("least_fracture_strain"),
        field("largest_strength"),
    ];
    deck.card(&[&strengths[..], &[pc, uc, pl, ul]].concat());
    deck.card(&[d1, d2, k1, k2, k3, fails]);
}

fn soil(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let keys = [
        "shear_modulus",
        "bulk_modulus",
        "yield_constants",
        "pressure",
        "tension_cutoff",
        "reversible",
    ];
    cards.keep(read, &keys);
    let [a0, a1, a2] = list(cards, "yield_constants");
    let cutoff = match cards.number("tension_cutoff") {
        0.0 => Blank,
        tension => Number(-tension),
    };
    // Curves ascend, and the volume strain of the format is negative.
    let pair = |row: &Vec<f64>| Some([0.0 - *row.first()?, *row.get(1)?]);
    let curve: Vec<[f64; 2]> = cards.rows("pressure").iter().rev().filter_map(pair).collect();
    let curve = Id(points(deck, &curve));
    cards.head(deck, "MAT_SOIL_AND_FOAM");
    let bulk = Number(cards.number("bulk_modulus"));
    deck.card(&[&first(cards)[..], &[bulk, a0, a1, a2, cutoff]].concat());
    let reversible = if cards.flag("reversible") { Number(1.0) } else { Blank };
    deck.card(&[reversible, Blank, curve]);
}

/// Points of the damage curve on the card.
const DAMAGE_POINTS: usize = 13;

fn three_surfaces(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let lists = ["largest_surface", "yield_surface", "residual_surface", "damage_scaling"];
    cards.keep(read, &["poisson", "tensile_strength", "rate_factors"]);
    cards.keep(read, &lists);
    let [a0, a1, a2] = list(cards, "largest_surface");
    let [a0y, a1y, a2y] = list(cards, "yield_surface");
    let [a1f, a2f] = list(cards, "residual_surface");
    let [b1, b2, b3] = list(cards, "damage_scaling");
    let [mut omega, mut edrop] = list(cards, "dilatancy");
    if cards.has("dilatancy") {
        cards.keep(read, &["dilatancy"]);
    } else {
        [omega, edrop] = [Number(0.0); 2];
        read.insert("dilatancy".into(), Param::List(vec![0.0; 2]));
    }
    // The card has a fixed number of points: the last one goes on.
    let mut points: Vec<Vec<f64>> = cards.rows("damage_curve").to_vec();
    points.truncate(DAMAGE_POINTS);
    while let (true, Some(last)) = (points.len() < DAMAGE_POINTS, points.last().cloned()) {
        points.push(vec![10.0 * last[0], last[1]]);
    }
    read.insert("damage_curve".into(), Param::Table(points.clone()));
    let column = |c: usize| points.iter().map(|point| Number(point[c])).collect::<Vec<_>>();
    let (lambda, eta) = (column(0), column(1));
    let rates = cards.curve(deck, "rate_factors");
    cards.head(deck, "MAT_CONCRETE_DAMAGE_REL3");
    let ids = [Id(cards.mid), Number(cards.material.density)];
    deck.card(&[&ids[..], &[cards.field("poisson")]].concat());
    deck.card(&[cards.field("tensile_strength"), a0, a1, a2, b1, omega, a1f]);
    let count = Number(DAMAGE_POINTS as f64);
    deck.card(&[Blank, Blank, edrop, Blank, Blank, rates, Blank, count]);
    deck.card(&lambda[..8]);
    deck.card(&[&lambda[8..], &[b3, a0y, a1y]].concat());
    deck.card(&eta[..8]);
    deck.card(&[&eta[8..], &[b2, a2f, a2y]].concat());
}

/// Writes the equation of state of a material with a compaction and returns its id.
pub fn compaction(
    deck: &mut DeckWriter,
    cards: &MaterialCards<'_>,
    read: &mut CardParameters,
) -> u64 {
    let rows = cards.rows("compaction");
    // A curve ascends in ln V.
    let mut curve = |column: usize| {
        let pair = |row: &Vec<f64>| [0.0 - row[0], row[column]];
        Id(points(deck, &rows.iter().rev().map(pair).collect::<Vec<_>>()))
    };
    let [cold, moduli] = [curve(1), curve(2)];
    deck.keyword("EOS_TABULATED_COMPACTION");
    deck.card(&[Id(cards.mid), Blank, Blank, Blank, cold, Blank, moduli]);
    cards.keep(read, &["compaction"]);
    cards.mid
}
