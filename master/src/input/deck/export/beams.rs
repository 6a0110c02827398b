//! Writes beams and trusses as cards.

use super::{Blank, CardValue, DeckWriter, Id, Number, line};
use crate::input::job::Model;
use crumple_proto::ids::ElemId;
use crumple_proto::job::{BeamInput, BeamSection, Part, TrussInput};
use crumple_proto::mesh::Shape;
use std::collections::{BTreeSet, HashMap};
use toml::{Table, Value};

/// Largest number of steps of the last bit from the nearest position of a third node to the one
/// that gives the axis exactly.
const MOST_STEPS: usize = 4;

/// Writes a part of beams or trusses with its section. Keys without a field are written after
/// `$crumple:`.
///
/// # Errors
/// The section has no card.
pub fn part(deck: &mut DeckWriter, part: &Part, law: &str, mid: u64) -> Result<(), String> {
    let id = u64::from(part.id);
    let (first, second, own) = match (&part.beam, &part.truss) {
        (Some(beam), _) => section(part, beam, law)?,
        (_, Some(truss)) => trusses(truss),
        _ => return Ok(()),
    };
    deck.keyword("SECTION_BEAM");
    deck.card(&[&[Id(id)], &first[..]].concat());
    deck.card(&second);
    deck.keyword("PART");
    deck.text(&line(&part.name));
    deck.card(&[Id(id), Id(id), Id(mid)]);
    let key = if part.beam.is_some() { "beam" } else { "truss" };
    let mut rest = Table::from_iter([("id".to_string(), Value::from(part.id))]);
    if !own.is_empty() {
        rest.insert(key.into(), own.into());
    }
    if part.skin {
        rest.insert("skin".into(), true.into());
    }
    for (key, value) in &part.parameters {
        rest.extend(Value::try_from(value).ok().map(|value| (key.clone(), value)));
    }
    if rest.len() > 1 {
        deck.entry("part", rest);
    }
    Ok(())
}

/// Fields after the id of the section, fields of its second card, and keys without a field.
type SectionCards = (Vec<CardValue>, Vec<CardValue>, Table);

fn trusses(truss: &TrussInput) -> SectionCards {
    let radius = truss.contact_radius.map(|radius| ("contact_radius".to_string(), radius.into()));
    (vec![Id(3)], vec![Number(truss.area)], radius.into_iter().collect())
}

fn section(part: &Part, beam: &BeamInput, law: &str) -> Result<SectionCards, String> {
    let shears = beam.shear_areas != [0.0; 2];
    // The engine reads the formulations with the fields of this section; sizes are exact there.
    let (first, second, fields): (Vec<CardValue>, Vec<CardValue>, &[&str]) = match beam.section {
        BeamSection::Rectangle => (
            vec![Id(if shears { 1 } else { 4 })],
            [beam.height, beam.height, beam.width, beam.width].map(Number).into(),
            &["section", "height", "width"],
        ),
        BeamSection::Tube => {
            let inner = if beam.wall > 0.0 { beam.radius - beam.wall } else { 0.0 };
            let [outer, inner] = [2.0 * beam.radius, 2.0 * inner];
            (
                vec![Id(if shears { 1 } else { 5 }), Blank, Blank, Number(1.0)],
                [outer, outer, inner, inner].map(Number).into(),
                &["section", "radius"],
            )
        }
        BeamSection::General if law == "elastic" => {
            let [about_s, about_t] = beam.second_moments;
            let fields = [beam.area, about_s, about_t, beam.torsion, beam.shear_areas[0]];
            (
                vec![Id(if shears { 13 } else { 2 })],
                fields.map(Number).into(),
                &["section", "area", "second_moments", "torsion"],
            )
        }
        BeamSection::General | BeamSection::I => {
            let what = if beam.section == BeamSection::I { "an I" } else { "a general section" };
            return Err(format!(
                "part {}: {what} with the law {law} has no card: use a rectangle or a tube",
                part.id
            ));
        }
    };
    let all = Value::try_from(beam);
    let mut own = match all {
        Ok(Value::Table(own)) => own,
        _ => Table::new(),
    };
    let none = Value::try_from(BeamInput::of(beam.section)).unwrap_or(Value::Boolean(false));
    own.retain(|key, value| !fields.contains(&key) && none.get(key) != Some(value));
    Ok((first, second, own))
}

/// Returns a new node for each beam, in the direction of its second axis: id, above `last`, and
/// position.
pub(in crate::input::deck) fn third_nodes(
    model: &Model,
    last: u64,
) -> HashMap<ElemId, (u64, [f64; 3])> {
    let place: HashMap<_, _> = model.mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
    let start: HashMap<ElemId, [f64; 3]> = model
        .mesh
        .elements
        .iter()
        .filter(|e| e.shape == Shape::Beam2)
        .map(|e| (e.id, place[&e.nodes[0]]))
        .collect();
    let axes = model.settings.axes.iter().filter_map(|(id, axis)| Some((id, axis, start.get(id)?)));
    let shown = |(number, (id, axis, from)): (u64, (&ElemId, &[f64; 3], &[f64; 3]))| {
        (*id, (number, std::array::from_fn(|c| end_of(from[c], axis[c]))))
    };
    (last + 1..).zip(axes).map(shown).collect()
}

/// Returns the coordinate from which `from` has to be subtracted to give `difference`, also in its
/// last bit if there is one.
pub(super) fn end_of(from: f64, difference: f64) -> f64 {
    let nearest = from + difference;
    let (mut up, mut down) = (nearest, nearest);
    for _ in 0..MOST_STEPS {
        if let Some(exact) = [up, down].into_iter().find(|to| to - from == difference) {
            return exact;
        }
        (up, down) = (up.next_up(), down.next_down());
    }
    nearest
}

/// Writes the third nodes and the elements; `discrete` are the parts of discrete beams.
pub fn elements(deck: &mut DeckWriter, model: &Model, discrete: &BTreeSet<u32>) {
    let third = third_nodes(model, deck.last_node);
    deck.last_node += third.len() as u64;
    let mut bars = model
        .mesh
        .elements
        .iter()
        .filter(|e| e.shape.is_bar() || discrete.contains(&e.part))
        .peekable();
    if bars.peek().is_none() {
        return;
    }
    let mut nodes: Vec<&(u64, [f64; 3])> = third.values().collect();
    nodes.sort_by_key(|node| node.0);
    if !nodes.is_empty() {
        deck.keyword("NODE");
    }
    for (id, x) in nodes {
        deck.card(&[Id(*id), Number(x[0]), Number(x[1]), Number(x[2])]);
    }
    deck.keyword("ELEMENT_BEAM");
    for e in bars {
        deck.card(&[
            Id(e.id.label()),
            Id(u64::from(e.part)),
            Id(e.nodes[0].label()),
            Id(e.nodes[1].label()),
            third.get(&e.id).map_or(Blank, |node| Id(node.0)),
        ]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The axis that a reader gets is the same in all its bits.
    #[test]
    fn ends_give_exact_differences() {
        let mut random = fastrand::Rng::with_seed(3);
        for _ in 0..100_000 {
            let mut number = || (random.f64() - 0.5) * 10f64.powi(random.i32(-3..4));
            let (from, to) = (number(), number());
            let difference = to - from;
            assert_eq!(end_of(from, difference) - from, difference, "{from:e} {to:e}");
        }
    }
}
