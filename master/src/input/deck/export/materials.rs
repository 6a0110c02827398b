//! Writes materials as cards.

use super::{Blank, DeckWriter, Id, Number, barlat, cohesive, composites, line, named, points};
use crate::input::job::Model;
use crumple_proto::job::Part;
use crumple_proto::partition::{Material, Param};
use crumple_worker::fem::materials::{EQUATION_OF_STATE, EROSION, GISSMO};
use std::collections::BTreeMap;
use toml::Table;

/// Most terms of a rubber on its card.
const MOST_TERMS: usize = 8;

/// Returns the number of terms of a rubber.
fn terms(material: &Material) -> usize {
    match material.parameters.get("terms") {
        Some(Param::Table(terms)) => terms.len(),
        _ => 0,
    }
}

/// Writes the materials of deformable parts. `rigid` holds the parts with a material of a rigid
/// body.
pub fn write(deck: &mut DeckWriter, model: &Model, rigid: &BTreeMap<u32, u64>) {
    let deforms = |m: &Material| {
        let has = |p: &Part| p.materials().contains(&m.name.as_str());
        model.job.part.iter().any(|p| has(p) && !rigid.contains_key(&p.id))
    };
    let turned = model.mesh.elements.iter().any(|e| e.own.angle != 0.0);
    for (material, mid) in model.settings.materials.iter().zip(1..).filter(|(m, _)| deforms(m)) {
        let number = |key: &str| match material.parameters.get(key) {
            Some(Param::Number(x)) => *x,
            _ => 0.0,
        };
        let pair = |key: &str| match material.parameters.get(key) {
            Some(Param::List(list)) if list.len() == 2 => [list[0], list[1]],
            _ => [0.0; 2],
        };
        let first = [
            Id(mid),
            Number(material.density),
            Number(number("youngs_modulus")),
            Number(number("poisson")),
        ];
        let title = line(&material.name);
        match material.law.as_str() {
            "elastic" => {
                deck.keyword("MAT_ELASTIC_TITLE");
                deck.text(&title);
                deck.card(&first);
            }
            "j2" if is_isotropic(material) => {
                let [c, p] = pair("cowper_symonds");
                let table = curve(deck, material);
                deck.keyword("MAT_PIECEWISE_LINEAR_PLASTICITY_TITLE");
                deck.text(&title);
                let (yield_stress, fail) =
                    (Number(number("yield_stress")), Number(number("failure_strain")));
                let (e, h) = (number("youngs_modulus"), number("hardening_modulus"));
                deck.card(&[
                    first[0],
                    first[1],
                    first[2],
                    first[3],
                    yield_stress,
                    Number(e * h / (e + h)),
                    fail,
                ]);
                deck.card(&[Number(c), Number(p), table.map_or(Blank, Id)]);
                deck.card(&[]);
                deck.card(&[]);
                if h > 0.0 {
                    // The tangent modulus alone does not reproduce it to the last bit.
                    deck.entry(
                        "material",
                        Table::from_iter([
                            named(&material.name),
                            ("hardening_modulus".into(), h.into()),
                        ]),
                    );
                }
            }
            "johnson_cook" => johnson_cook(deck, material, mid, &title, number),
            "mooney_rivlin" | "polynomial_rubber" | "ogden" | "blatz_ko"
                if terms(material) <= MOST_TERMS =>
            {
                rubber(deck, material, mid, &title);
            }
            "barlat" => barlat::material(deck, material, mid, &title, turned),
            "orthotropic" => composites::ply(deck, material, mid, &title, turned),
            "cohesive_mixed_mode" | "cohesive_elastic" => {
                let part = model.settings.parts.iter().find(|p| p.material == material.name);
                cohesive::material(deck, material, mid, &title, part);
            }
            "low_density_foam" => low_density_foam(deck, material, mid, &title),
            "j2" | "viscoelastic" | "crushable_foam" | "fabric" | "honeycomb" => {
                deck.keyword("MAT_ELASTIC_TITLE");
                deck.text(&title);
                deck.card(&first);
                without_card(deck, material, &["youngs_modulus", "poisson"]);
                continue;
            }
            law => {
                deck.text(&format!("$ material {title}: law {} has no keyword", line(law)));
            }
        }
        additions(deck, material);
    }
}

/// Writes criteria of failure, damage and the equation of state after `$crumple:`.
fn additions(deck: &mut DeckWriter, material: &Material) {
    let added = |key: &str| {
        let mut rows = EROSION.iter().chain(EQUATION_OF_STATE).chain(GISSMO);
        rows.any(|row| row.key == key)
    };
    let given: Vec<(String, toml::Value)> = material
        .parameters
        .iter()
        .filter(|(key, _)| added(key))
        .map(|(key, param)| (key.clone(), value_of(param)))
        .collect();
    if !given.is_empty() {
        deck.entry("material", std::iter::once(named(&material.name)).chain(given).collect());
    }
}

/// Returns a parameter as a value of a job.
fn value_of(param: &Param) -> toml::Value {
    let list = |numbers: &[f64]| toml::Value::from(numbers.to_vec());
    match param {
        Param::Flag(flag) => (*flag).into(),
        Param::Number(x) => (*x).into(),
        Param::List(numbers) => list(numbers),
        Param::Table(rows) => rows.iter().map(|row| list(row)).collect::<Vec<_>>().into(),
    }
}

/// Writes the law and all parameters but these, which its card has, after `$crumple:`.
fn without_card(deck: &mut DeckWriter, material: &Material, on_card: &[&str]) {
    let value = |(key, param): (&String, &Param)| (key.clone(), value_of(param));
    let others = material.parameters.iter().filter(|(key, _)| !on_card.contains(&key.as_str()));
    let head = [named(&material.name), ("law".into(), material.law.as_str().into())];
    deck.entry("material", head.into_iter().chain(others.map(value)).collect());
}

/// Writes a rubber as a card.
fn rubber(deck: &mut DeckWriter, material: &Material, mid: u64, title: &str) {
    let number = |key: &str| match material.parameters.get(key) {
        Some(Param::Number(x)) => Number(*x),
        _ => Blank,
    };
    let (id, density) = (Id(mid), Number(material.density));
    let keyword = match material.law.as_str() {
        "mooney_rivlin" => "MAT_MOONEY-RIVLIN_RUBBER_TITLE",
        "polynomial_rubber" => "MAT_HYPERELASTIC_RUBBER_TITLE",
        "ogden" => "MAT_OGDEN_RUBBER_TITLE",
        _ => "MAT_BLATZ-KO_RUBBER_TITLE",
    };
    let mut cards = vec![match material.law.as_str() {
        "mooney_rivlin" => vec![id, density, number("poisson"), number("a"), number("b")],
        "blatz_ko" => vec![id, density, number("shear_modulus")],
        _ => vec![id, density, number("poisson")],
    }];
    match material.parameters.get("terms").or(material.parameters.get("coefficients")) {
        Some(Param::Table(terms)) => {
            for column in 0..2 {
                cards.push(terms.iter().map(|term| Number(term[column])).collect());
            }
        }
        Some(Param::List(c)) => cards.push(c.iter().map(|c| Number(*c)).collect()),
        _ => {}
    }
    deck.keyword(keyword);
    deck.text(title);
    for card in cards {
        deck.card(&card);
    }
}

/// Writes a foam as a card with a curve; the rest, also curves by rate, after `$crumple:`.
fn low_density_foam(deck: &mut DeckWriter, material: &Material, mid: u64, title: &str) {
    const CURVE: &str = "compression";
    let Some(Param::Table(rows)) = material.parameters.get(CURVE) else {
        deck.text(&format!("$ material {title}: curves by rate have no keyword"));
        return;
    };
    let pairs: Vec<[f64; 2]> = rows.iter().map(|row| [row[0], row[1]]).collect();
    let curve = points(deck, &pairs);
    let e = match material.parameters.get("youngs_modulus") {
        Some(Param::Number(e)) => Number(*e),
        _ => Blank,
    };
    deck.keyword("MAT_LOW_DENSITY_FOAM_TITLE");
    deck.text(title);
    deck.card(&[Id(mid), Number(material.density), e, Id(curve)]);
    deck.card(&[]);
    without_card(deck, material, &["youngs_modulus", CURVE]);
}

/// Returns true if a material has no key that the card of piecewise linear plasticity lacks here.
fn is_isotropic(material: &Material) -> bool {
    let others = [
        "kinematic_modulus",
        "hardening_by_rate",
        "rate_factors",
        "viscoplastic",
        "softening",
        "lankford",
    ];
    !others.iter().any(|key| material.parameters.contains_key(*key))
}

fn johnson_cook(
    deck: &mut DeckWriter,
    material: &Material,
    mid: u64,
    title: &str,
    number: impl Fn(&str) -> f64,
) {
    let (e, nu) = (number("youngs_modulus"), number("poisson"));
    deck.keyword("MAT_JOHNSON_COOK_TITLE");
    deck.text(title);
    deck.card(&[
        Id(mid),
        Number(material.density),
        Number(e / (2.0 * (1.0 + nu))),
        Number(e),
        Number(nu),
    ]);
    let keys =
        ["a", "b", "n", "c", "m", "melting_temperature", "reference_temperature", "reference_rate"];
    deck.card(&keys.map(|key| Number(number(key))));
    let d = match material.parameters.get("damage") {
        Some(Param::List(d)) if d.len() == 5 => [d[0], d[1], d[2], d[3], d[4]],
        _ => [0.0; 5],
    };
    deck.card(&[
        Number(number("specific_heat")),
        Blank,
        Blank,
        Blank,
        Number(d[0]),
        Number(d[1]),
        Number(d[2]),
        Number(d[3]),
    ]);
    deck.card(&[Number(d[4])]);
    if let Some(Param::Number(share)) = material.parameters.get("taylor_quinney") {
        deck.entry(
            "material",
            Table::from_iter([named(&material.name), ("taylor_quinney".into(), (*share).into())]),
        );
    }
}

/// Writes the hardening table of a material as a curve, and returns its id.
fn curve(deck: &mut DeckWriter, material: &Material) -> Option<u64> {
    let Some(Param::Table(rows)) = material.parameters.get("hardening") else { return None };
    let pairs: Vec<[f64; 2]> =
        rows.iter().filter(|row| row.len() == 2).map(|row| [row[0], row[1]]).collect();
    Some(points(deck, &pairs))
}
