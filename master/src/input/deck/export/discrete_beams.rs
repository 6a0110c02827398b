//! Writes parts of discrete beams as cards.

use super::{Blank, CardValue, DeckWriter, Id, Number, line, points};
use crumple_proto::job::{
    AxisSpring, BeamAxis, BeamFailure, DiscreteBeamInput, Part, SpringHardening, TurningNode,
};
use toml::{Table, Value};

/// Returns a coefficient and the table that replaces it.
type LineOf = fn(&AxisSpring) -> (f64, &Vec<[f64; 2]>);

/// Axes in the order of the cards.
const AXES: [BeamAxis; 6] =
    [BeamAxis::R, BeamAxis::S, BeamAxis::T, BeamAxis::Rr, BeamAxis::Rs, BeamAxis::Rt];

/// A material that is written, with what its cards have for each axis.
#[derive(Clone, Copy, PartialEq)]
enum BeamCards {
    /// Stiffness, damping and preload.
    Linear,
    /// Curves, preload, limits of forces and displacements.
    Curves,
    /// Yield forces and linear axes, with the same limits.
    Plastic,
    /// Curves of loading and unloading by one option, displacements of the start, limits of
    /// displacements.
    Unloading(u64),
    /// A card for each axis.
    General,
}

/// Writes a part with a section and an individual material `mid`. If some springs have tables, all
/// become curves. Axes other than the global ones are written after `$crumple:` too: cards do not
/// keep all of their bits.
///
/// # Errors
/// A text if no material has all of its springs.
pub fn part(
    deck: &mut DeckWriter,
    part: &Part,
    beam: &DiscreteBeamInput,
    mid: u64,
) -> Result<(), String> {
    let id = u64::from(part.id);
    let kinds = [BeamCards::Linear, BeamCards::Curves, BeamCards::Plastic, BeamCards::General];
    let unloading = (0..=3).map(BeamCards::Unloading);
    let cards = kinds.into_iter().chain(unloading).find(|cards| cards.fit(beam));
    let alike = |[a, b]: [BeamAxis; 2]| {
        let of = |axis: BeamAxis| {
            let spring = beam.spring.iter().find(|spring| spring.axis == axis);
            spring.map(|spring| AxisSpring { axis: a, ..spring.clone() })
        };
        of(a) == of(b) && of(a).is_none_or(|spring| is_alike_both_ways(&spring))
    };
    let across = [[BeamAxis::S, BeamAxis::T], [BeamAxis::Rs, BeamAxis::Rt]];
    let has_line =
        !beam.along_line || beam.turns_with != TurningNode::Both && across.into_iter().all(alike);
    let (Some(cards), true) = (cards, has_line) else {
        return Err(format!(
            "part {}: its discrete beams cannot be written as a deck: no material there has all \
             of their springs and limits together",
            part.label()
        ));
    };
    cards.write(deck, part, beam, mid);
    let has_axes = beam.axes != [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    if has_axes {
        deck.systems += 1;
        let [r, s] = beam.axes.map(|axis| axis.map(Number));
        deck.keyword("DEFINE_COORDINATE_SYSTEM");
        deck.card(&[&[Id(deck.systems)][..], &[Number(0.0); 3], &r].concat());
        deck.card(&s);
    }
    let far = if beam.along_line { 2.0 } else { 3.0 };
    let scoor = match beam.turns_with {
        TurningNode::Both => 0.0,
        TurningNode::First => -far,
        TurningNode::Second => far,
    };
    deck.keyword("SECTION_BEAM");
    deck.card(&[Id(id), Id(6), Blank, Blank, Blank, Number(scoor)]);
    let cid: CardValue = if has_axes { Id(deck.systems) } else { Blank };
    deck.card(&[Number(1.0), Number(beam.inertia), cid]);
    deck.keyword("PART");
    deck.text(&line(&part.name));
    deck.card(&[Id(id), Id(id), Id(mid)]);
    let Ok(Value::Table(mut own)) = Value::try_from(beam) else { return Ok(()) };
    own.retain(|key, _| key == "axes" && has_axes);
    if !own.is_empty() {
        let entry = [("id".into(), Value::from(part.id)), ("discrete_beam".into(), own.into())];
        deck.digits("part", Table::from_iter(entry));
    }
    Ok(())
}

impl BeamCards {
    /// Returns true if the cards have all that the springs of a part have.
    fn fit(self, beam: &DiscreteBeamInput) -> bool {
        let by_displacement =
            |s: &AxisSpring| s.failure_tension.is_some() || s.failure_compression.is_some();
        let limited = |s: &AxisSpring| by_displacement(s) || s.failure_force.is_some();
        let has_limits = beam.spring.iter().any(limited);
        let failure = match self {
            Self::Linear => !has_limits,
            Self::Curves | Self::Plastic => beam.failure == BeamFailure::Together,
            Self::Unloading(_) => beam.failure != BeamFailure::Any,
            Self::General => beam.failure == BeamFailure::Any,
        };
        let shares = !matches!(self, Self::Unloading(option) if !Self::share(option, beam));
        (failure || !has_limits) && shares && beam.spring.iter().all(|spring| self.fit_axis(spring))
    }

    fn fit_axis(self, spring: &AxisSpring) -> bool {
        let no_tables = spring.force_elongation.is_empty() && spring.force_rate.is_empty();
        let yields = spring.yielding.is_some();
        let unloads = [
            spring
                .hysteresis
                .as_ref()
                .map(|law| (1, law.hardening == SpringHardening::Independent)),
            spring.between_curves.as_ref().map(|law| (2, law.stiffness > 0.0)),
            spring.permanent_set.as_ref().map(|_| (3, true)),
        ];
        let unloads = unloads.into_iter().flatten().next();
        let same_limits = spring.failure_tension == spring.failure_compression;
        let rests = spring.initial_displacement == 0.0;
        match self {
            Self::Linear => no_tables && !yields && unloads.is_none() && rests,
            Self::Curves => !yields && unloads.is_none() && rests && same_limits,
            Self::Plastic => no_tables && unloads.is_none() && rests && same_limits,
            Self::Unloading(option) => {
                !yields
                    && unloads.is_none_or(|(own, fits)| own == option && fits)
                    && spring.preload == 0.0
                    && spring.failure_force.is_none()
            }
            Self::General => {
                unloads.is_none()
                    && rests
                    && spring.preload == 0.0
                    && spring.failure_force.is_none()
            }
        }
    }

    fn write(self, deck: &mut DeckWriter, part: &Part, beam: &DiscreteBeamInput, mid: u64) {
        let of = |axis: BeamAxis| beam.spring.iter().find(|spring| spring.axis == axis);
        let title = format!("{}, {}", line(&part.name), part.id);
        let number = |value: fn(&AxisSpring) -> f64| {
            AXES.map(|axis| of(axis).map_or(Blank, |spring| filled(value(spring))))
        };
        let head = [Id(mid), Number(beam.mass)];
        let limits = [
            number(|s| s.failure_force.unwrap_or(0.0)),
            number(|s| s.failure_tension.unwrap_or(0.0)),
        ];
        let [stiffness, damping, preload] =
            [number(|s| s.stiffness), number(|s| s.damping), number(|s| s.preload)];
        match self {
            Self::Linear => {
                deck.keyword("MAT_LINEAR_ELASTIC_DISCRETE_BEAM_TITLE");
                deck.text(&title);
                // The mass is that of a unit volume.
                deck.card(&[&head[..], &stiffness].concat());
                without_blanks(deck, &[damping, preload]);
            }
            Self::Curves => {
                let lines: [LineOf; 2] =
                    [|s| (s.stiffness, &s.force_elongation), |s| (s.damping, &s.force_rate)];
                let curves = lines.map(|line| {
                    AXES.map(|axis| of(axis).map_or(Blank, |s| curve(deck, line(s), unmirrored)))
                });
                deck.keyword("MAT_NONLINEAR_ELASTIC_DISCRETE_BEAM_TITLE");
                deck.text(&title);
                deck.card(&[&head[..], &curves[0]].concat());
                without_blanks(deck, &[curves[1], preload, limits[0], limits[1]]);
            }
            Self::Plastic => {
                let yields = |s: &AxisSpring| s.yielding.clone();
                let curves = AXES.map(|axis| match of(axis).and_then(yields) {
                    None => Blank,
                    Some(law) => Id(points(deck, &law.yield_force)),
                });
                let stiffness =
                    number(|s| s.yielding.as_ref().map_or(s.stiffness, |law| law.stiffness));
                deck.keyword("MAT_NONLINEAR_PLASTIC_DISCRETE_BEAM_TITLE");
                deck.text(&title);
                deck.card(&[&head[..], &stiffness].concat());
                without_blanks(deck, &[damping, curves, limits[0], limits[1], preload]);
            }
            Self::Unloading(option) => Self::unloading(deck, (&title, head), beam, option),
            Self::General => {
                let cards = AXES.map(|axis| of(axis).map(|spring| axis_cards(deck, spring)));
                deck.keyword("MAT_GENERAL_SPRING_DISCRETE_BEAM_TITLE");
                deck.text(&title);
                deck.card(&head);
                cards.iter().flatten().flatten().for_each(|card| deck.card(card));
            }
        }
    }
}

/// Cards for an axis of a material with six numbers on each.
type SixNumbers = [CardValue; 6];

impl BeamCards {
    /// Returns true if all axes have the numbers that the option has once.
    fn share(option: u64, beam: &DiscreteBeamInput) -> bool {
        let rotates = |s: &AxisSpring| s.axis as usize >= 3;
        let same = |number: fn(&AxisSpring) -> Option<f64>, apart: bool| {
            let all: Vec<_> =
                beam.spring.iter().map(|s| (rotates(s) && apart, number(s))).collect();
            [false, true].iter().all(|kind| {
                let mut own = all.iter().filter(|n| n.0 == *kind).filter_map(|n| n.1);
                let first = own.next();
                own.all(|n| Some(n) == first)
            })
        };
        match option {
            2 => same(|s| s.between_curves.as_ref().map(|law| law.stiffness), true),
            3 => {
                same(|s| s.permanent_set.as_ref().map(|law| law.fraction), false)
                    && beam
                        .spring
                        .iter()
                        .all(|s| s.stiffness == 0.0 && s.force_elongation.is_empty())
            }
            _ => true,
        }
    }

    /// Writes the material with curves of loading and unloading.
    fn unloading(
        deck: &mut DeckWriter,
        (title, [mid, mass]): (&str, [CardValue; 2]),
        beam: &DiscreteBeamInput,
        option: u64,
    ) {
        let of = |axis: BeamAxis| beam.spring.iter().find(|spring| spring.axis == axis);
        let [loading, unloading, damping]: [SixNumbers; 3] = [0, 1, 2].map(|which| {
            AXES.map(|axis| {
                let Some(s) = of(axis) else { return Blank };
                let of_laws = [
                    s.hysteresis.as_ref().map(|law| [&law.loading, &law.unloading]),
                    s.between_curves.as_ref().map(|law| [&law.loading, &law.unloading]),
                    s.permanent_set.as_ref().map(|law| [&law.loading, &law.loading]),
                ];
                match (of_laws.into_iter().flatten().next(), which) {
                    (_, 2) => curve(deck, (s.damping, &s.force_rate), <[_]>::to_vec),
                    (Some(_), 1) if option == 3 => Blank,
                    (Some(curves), _) => Id(points(deck, curves[which])),
                    (None, 0) => curve(deck, (s.stiffness, &s.force_elongation), <[_]>::to_vec),
                    (None, _) => Blank,
                }
            })
        });
        let number = |value: fn(&AxisSpring) -> f64| -> SixNumbers {
            AXES.map(|axis| of(axis).map_or(Blank, |spring| filled(value(spring))))
        };
        let first = |value: fn(&AxisSpring) -> Option<f64>, rotates: &[bool]| {
            let own = beam.spring.iter().filter(|s| rotates.contains(&(s.axis as usize >= 3)));
            own.filter_map(value).next().map_or(Blank, Number)
        };
        let stiffness = |s: &AxisSpring| s.between_curves.as_ref().map(|law| law.stiffness);
        let fraction = |s: &AxisSpring| s.permanent_set.as_ref().map(|law| law.fraction);
        let [kt, kr] = [false, true].map(|rotates| first(stiffness, &[rotates]));
        let offset = first(fraction, &[false, true]);
        deck.keyword("MAT_GENERAL_NONLINEAR_6DOF_DISCRETE_BEAM_TITLE");
        deck.text(title);
        deck.card(&[mid, mass, kt, kr, Id(option), offset]);
        let tension = number(|s| s.failure_tension.unwrap_or(0.0));
        let one_sum = Id(u64::from(beam.failure == BeamFailure::Together));
        let compression = number(|s| s.failure_compression.unwrap_or(0.0));
        let start = number(|s| s.initial_displacement);
        for card in [&loading[..], &unloading, &damping, &[]] {
            deck.card(card);
        }
        deck.card(&[&tension[..], &[one_sum]].concat());
        deck.card(&compression);
        deck.card(&start);
    }
}

/// Returns a number, blank if it is zero.
fn filled(number: f64) -> CardValue {
    if number == 0.0 { Blank } else { Number(number) }
}

/// Returns a curve for a coefficient or the table that replaces it, changed by `change`.
fn curve(
    deck: &mut DeckWriter,
    (number, table): (f64, &Vec<[f64; 2]>),
    change: fn(&[[f64; 2]]) -> Vec<[f64; 2]>,
) -> CardValue {
    match (number, table.is_empty()) {
        (0.0, true) => Blank,
        (_, true) => Id(points(deck, &[[-1.0, -number], [1.0, number]])),
        _ => Id(points(deck, &change(table))),
    }
}

/// Writes the curves of an axis of the material with cards for each. Returns the two cards.
fn axis_cards(deck: &mut DeckWriter, s: &AxisSpring) -> [Vec<CardValue>; 2] {
    let axis = s.axis as u64 + 1;
    let (kind, stiffness, force) = match &s.yielding {
        Some(law) => (1, law.stiffness, Id(points(deck, &law.yield_force))),
        None if s.force_elongation.is_empty() => (0, s.stiffness, Blank),
        None => (0, 0.0, Id(points(deck, &unmirrored(&s.force_elongation)))),
    };
    let rate = match s.force_rate.is_empty() {
        true => Blank,
        false => Id(points(deck, &unmirrored(&s.force_rate))),
    };
    let [compression, tension] =
        [s.failure_compression, s.failure_tension].map(|limit| filled(limit.unwrap_or(0.0)));
    let first = [Id(axis), Id(kind), filled(stiffness), filled(s.damping), compression, tension];
    [first.to_vec(), vec![force, rate]]
}

/// Writes cards without blank ones at the end.
fn without_blanks(deck: &mut DeckWriter, cards: &[SixNumbers]) {
    let is_filled = |card: &SixNumbers| card.iter().any(|value| !matches!(value, Blank));
    let last = cards.iter().rposition(is_filled).map_or(0, |last| last + 1);
    cards[..last].iter().for_each(|card| deck.card(card));
}

/// Returns the points of a table with one more before a first point at the origin: readers mirror
/// curves that begin there.
fn unmirrored(table: &[[f64; 2]]) -> Vec<[f64; 2]> {
    match table {
        [[0.0, 0.0], [x, y], ..] => [&[[-x, -y]], table].concat(),
        _ => table.to_vec(),
    }
}

/// Returns true for a spring that is the same in both directions, which a card with scoor 2 or -2
/// needs across the line.
fn is_alike_both_ways(spring: &AxisSpring) -> bool {
    let is_odd = |points: &[[f64; 2]]| {
        let mirrored = points.iter().rev().map(|p| p.map(|x| 0.0 - x));
        points.first().is_none_or(|p| p[0] >= 0.0) || points.iter().copied().eq(mirrored)
    };
    [spring.preload, spring.initial_displacement] == [0.0; 2]
        && spring.failure_tension == spring.failure_compression
        && is_odd(&spring.force_elongation)
        && is_odd(&spring.force_rate)
        && spring.yielding.iter().all(|yielding| is_odd(&yielding.yield_force))
}
