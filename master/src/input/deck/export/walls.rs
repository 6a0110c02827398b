//! Writes rigid walls as cards. Values that the digits of a card do not reproduce to the last bit
//! are written after `$crumple:` with the wall's name.

use super::{Blank, CardValue, DeckWriter, Id, Number, TimeCurves, line, list, named};
use crumple_proto::job::{Job, WallInput};
use std::collections::BTreeSet;
use toml::{Table, Value};

/// Keyword of a wall.
#[derive(Clone, Copy, PartialEq, Eq)]
enum WallCard {
    Plane,
    LedRectangle,
    Cylinder,
    Sphere,
}

fn kind(wall: &WallInput) -> Option<WallCard> {
    let led = wall.velocity.or(wall.displacement);
    let stands = led.is_some_and(|v| v == [0.0; 3]);
    match (wall.axis, wall.normal) {
        _ if stands => None,
        (Some(_), None) => Some(WallCard::Cylinder),
        (None, None) if wall.radius.is_some() => Some(WallCard::Sphere),
        (None, Some(_)) if led.is_none() => Some(WallCard::Plane),
        (None, Some(_)) if wall.edge.is_some() => Some(WallCard::LedRectangle),
        _ => None,
    }
}

/// Writes walls with cards up to the first one without; it and all others stay in comments, so
/// that their order is kept.
pub fn write(
    deck: &mut DeckWriter,
    job: &Job,
    set: impl Fn(&str) -> CardValue,
    curves: &mut TimeCurves<'_>,
) {
    let mut names = BTreeSet::new();
    let kinds: Vec<WallCard> = (1..)
        .zip(&job.wall)
        .map_while(|(number, wall)| kind(wall).filter(|_| names.insert(name(wall, number))))
        .collect();
    for ((wall, kind), number) in job.wall.iter().zip(&kinds).zip(1..) {
        one(deck, wall, *kind, (&name(wall, number), number), &set, curves);
    }
    list(deck, "wall", &job.wall[kinds.len()..]);
}

fn name(wall: &WallInput, number: u64) -> String {
    if wall.name.is_empty() { format!("wall-{number}") } else { line(&wall.name) }
}

fn one(
    deck: &mut DeckWriter,
    wall: &WallInput,
    kind: WallCard,
    (name, number): (&str, u64),
    set: impl Fn(&str) -> CardValue,
    curves: &mut TimeCurves<'_>,
) {
    let mut exact = Table::from_iter([named(name)]);
    let mut head = |key: &str, v: [f64; 3]| {
        let head = [0, 1, 2].map(|c| wall.point[c] + v[c]);
        if [0, 1, 2].map(|c| head[c] - wall.point[c]) != v {
            exact.insert(key.into(), Value::from(v.to_vec()));
        }
        head.map(Number)
    };
    let direction = match kind {
        WallCard::Cylinder => head("axis", wall.axis.unwrap_or_default()),
        // A sphere has no direction, but a card has one.
        WallCard::Sphere => [wall.point[0], wall.point[1], wall.point[2] + 1.0].map(Number),
        _ => head("normal", wall.normal.unwrap_or_default()),
    };
    let edge = wall.edge.map(|e| head("edge", e));
    let led = led(deck, wall, curves, &mut exact);
    let options: Vec<&str> = [
        (wall.edge.is_some() && kind == WallCard::Plane, "_FINITE"),
        (wall.mass.is_some(), "_MOVING"),
        (led.is_some(), "_MOTION"),
    ]
    .iter()
    .filter_map(|(has, option)| has.then_some(*option))
    .collect();
    let keyword = match kind {
        WallCard::Plane => "RIGIDWALL_PLANAR",
        WallCard::LedRectangle => "RIGIDWALL_GEOMETRIC_FLAT",
        WallCard::Cylinder => "RIGIDWALL_GEOMETRIC_CYLINDER",
        WallCard::Sphere => "RIGIDWALL_GEOMETRIC_SPHERE",
    };
    deck.keyword(&format!("{keyword}{}_ID", options.concat()));
    deck.named_card(number, name);
    let chosen = |of: &Option<String>| of.as_deref().map_or(Blank, &set);
    let mut head = vec![chosen(&wall.nodes), chosen(&wall.except)];
    if wall.birth > 0.0 || wall.death.is_some() {
        // A plane has an offset before its birth.
        head.extend(vec![Blank; if kind == WallCard::Plane { 2 } else { 1 }]);
        head.extend([Number(wall.birth), wall.death.map_or(Blank, Number)]);
    }
    deck.card(&head);
    deck.card(&[wall.point.map(Number).as_slice(), &direction, &[Number(wall.friction)]].concat());
    if kind == WallCard::Cylinder {
        deck.card(&[Number(wall.radius.unwrap_or(0.0)), Number(wall.length)]);
    }
    if kind == WallCard::Sphere {
        deck.card(&[Number(wall.radius.unwrap_or(0.0))]);
    }
    if let Some(edge) = edge {
        deck.card(&[edge.as_slice(), &wall.lengths.unwrap_or_default().map(Number)].concat());
    }
    if let Some(mass) = wall.mass {
        deck.card(&[Number(mass), Number(wall.speed)]);
    }
    if let Some(motion) = led {
        deck.card(&motion);
    }
    if exact.len() > 1 {
        deck.digits("wall", exact);
    }
}

/// Writes the card of a motion: a curve of lengths along a direction of length 1.
fn led(
    deck: &mut DeckWriter,
    wall: &WallInput,
    curves: &mut TimeCurves<'_>,
    exact: &mut Table,
) -> Option<[CardValue; 5]> {
    let (key, form, v) = match (wall.velocity, wall.displacement) {
        (Some(v), _) => ("velocity", 0, v),
        (None, Some(u)) => ("displacement", 1, u),
        (None, None) => return None,
    };
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let way = v.map(|c| c / length);
    let of = wall.curve.as_deref();
    let curve = match length == 1.0 {
        true => curves.id(deck, of),
        false => {
            // A curve times the speed differs in its last digits.
            let name = curves.write_table(deck, of);
            exact.insert(key.into(), Value::from(v.to_vec()));
            exact.insert("curve".into(), name.into());
            curves.scaled(deck, of, length)
        }
    };
    // The reader normalizes the direction again.
    let again = way.iter().map(|c| c * c).sum::<f64>().sqrt();
    if way.map(|c| c / again) != v {
        exact.insert(key.into(), Value::from(v.to_vec()));
    }
    let [x, y, z] = way.map(Number);
    Some([Id(curve), Id(form), x, y, z])
}
