//! Writes parts of discrete beams as cards.

use super::{Blank, CardValue, DeckWriter, Id, Number, line, points};
use crumple_proto::job::{AxisSpring, BeamAxis, DiscreteBeamInput, Part, TurningNode};
use toml::{Table, Value};

/// Returns a coefficient and the table that replaces it.
type LineOf = fn(&AxisSpring) -> (f64, &Vec<[f64; 2]>);

/// Axes in the order of the cards.
const AXES: [BeamAxis; 6] =
    [BeamAxis::R, BeamAxis::S, BeamAxis::T, BeamAxis::Rr, BeamAxis::Rs, BeamAxis::Rt];

/// Writes a part with a section and an individual material `mid`. If some springs have tables, all
/// become curves. Axes other than the global ones are written after `$crumple:` too: cards do not
/// keep all of their bits.
pub fn part(deck: &mut DeckWriter, part: &Part, beam: &DiscreteBeamInput, mid: u64) {
    let id = u64::from(part.id);
    let of = |axis: BeamAxis| beam.spring.iter().find(|spring| spring.axis == axis);
    let curves =
        beam.spring.iter().any(|s| !(s.force_elongation.is_empty() && s.force_rate.is_empty()));
    let lines: [LineOf; 2] =
        [|s| (s.stiffness, &s.force_elongation), |s| (s.damping, &s.force_rate)];
    let fields = lines.map(|line| {
        AXES.map(|axis| match (of(axis).map(line), curves) {
            (None, _) => Blank,
            (Some((number, _)), false) => Number(number),
            (Some((0.0, table)), true) if table.is_empty() => Blank,
            (Some((number, table)), true) if table.is_empty() => {
                Id(points(deck, &[[-1.0, -number], [1.0, number]]))
            }
            (Some((_, table)), true) => Id(points(deck, &unmirrored(table))),
        })
    });
    deck.keyword(match curves {
        true => "MAT_NONLINEAR_ELASTIC_DISCRETE_BEAM_TITLE",
        false => "MAT_LINEAR_ELASTIC_DISCRETE_BEAM_TITLE",
    });
    deck.text(&format!("{}, {id}", line(&part.name)));
    // The mass is that of a unit volume.
    deck.card(&[&[Id(mid), Number(beam.mass)][..], &fields[0]].concat());
    deck.card(&fields[1]);
    let has_axes = beam.axes != [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    if has_axes {
        deck.systems += 1;
        let [r, s] = beam.axes.map(|axis| axis.map(Number));
        deck.keyword("DEFINE_COORDINATE_SYSTEM");
        deck.card(&[&[Id(deck.systems)][..], &[Number(0.0); 3], &r].concat());
        deck.card(&s);
    }
    let scoor = match beam.turns_with {
        TurningNode::Both => 0.0,
        TurningNode::First => -3.0,
        TurningNode::Second => 3.0,
    };
    deck.keyword("SECTION_BEAM");
    deck.card(&[Id(id), Id(6), Blank, Blank, Blank, Number(scoor)]);
    let cid: CardValue = if has_axes { Id(deck.systems) } else { Blank };
    deck.card(&[Number(1.0), Number(beam.inertia), cid]);
    deck.keyword("PART");
    deck.text(&line(&part.name));
    deck.card(&[Id(id), Id(id), Id(mid)]);
    let Ok(Value::Table(mut own)) = Value::try_from(beam) else { return };
    own.retain(|key, _| key == "axes" && has_axes);
    if !own.is_empty() {
        let entry = [("id".into(), Value::from(part.id)), ("discrete_beam".into(), own.into())];
        deck.digits("part", Table::from_iter(entry));
    }
}

/// Returns the points of a table with one more before a first point at the origin: readers mirror
/// curves that begin there.
fn unmirrored(table: &[[f64; 2]]) -> Vec<[f64; 2]> {
    match table {
        [[0.0, 0.0], [x, y], ..] => [&[[-x, -y]], table].concat(),
        _ => table.to_vec(),
    }
}
