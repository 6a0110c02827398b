//! Writes bodies that are rigid for a part of the run as cards of switches.

use super::{Blank, DeckWriter, Id, Number, named, table_of};
use crumple_proto::job::Rigid;
use toml::{Table, Value};

/// Returns true for a body whose parts become rigid after the start, or deform again.
pub fn is_switched(body: &Rigid) -> bool {
    body.from > 0.0 || body.until.is_some()
}

/// Returns the name that a reader gives the body.
pub fn name(body: &Rigid) -> String {
    let parts: Vec<String> = body.parts.iter().map(u32::to_string).collect();
    format!("rigid-{}-from-{}", parts.join("-"), body.from)
}

/// Returns true if cards can hold bodies in this order: a reader sorts them by their times and
/// first parts.
pub fn are_in_order(bodies: &[&Rigid]) -> bool {
    let key = |body: &&Rigid| {
        let until = body.until.unwrap_or(f64::INFINITY);
        (body.from, until, body.parts.first().copied().unwrap_or(0))
    };
    let has_cards = |body: &&Rigid| !body.parts.is_empty() && body.parts.is_sorted();
    bodies.iter().all(has_cards) && bodies.is_sorted_by(|a, b| key(a) <= key(b))
}

/// Writes the switches of a body, from the number `first` on, and returns how many there are.
pub fn write(deck: &mut DeckWriter, body: &Rigid, first: u64) -> u64 {
    let lead = Id(body.parts.first().map_or(0, |&p| u64::from(p)));
    let count = Id(body.parts.len() as u64);
    let zero = Id(0);
    let head = |number: u64, time: f64| [Id(number), Id(0), Number(time)];
    let keyword = "DEFORMABLE_TO_RIGID_AUTOMATIC";
    deck.keyword(keyword);
    deck.card(&head(first, body.from));
    deck.card(&[Blank, Blank, Blank, Blank, count, zero]);
    for &part in &body.parts {
        let id = Id(u64::from(part));
        deck.card(&[id, if Some(&part) == body.parts.first() { Blank } else { lead }]);
    }
    if let Some(until) = body.until {
        deck.keyword(keyword);
        deck.card(&head(first + 1, until));
        deck.card(&[Blank, Blank, Blank, Blank, zero, count]);
        body.parts.iter().for_each(|&part| deck.card(&[Id(u64::from(part))]));
    }
    let mut own = Table::from_iter([named(&name(body))]);
    let rest =
        Rigid { name: String::new(), parts: Vec::new(), from: 0.0, until: None, ..body.clone() };
    let given = |value: &Value| value.as_array().is_none_or(|list| !list.is_empty());
    own.extend(table_of(&rest).into_iter().filter(|(key, value)| {
        ["nodes", "fixed", "mass", "inertia"].contains(&key.as_str()) && given(value)
    }));
    if own.len() > 1 {
        deck.entry("rigid", own);
    }
    1 + u64::from(body.until.is_some())
}
