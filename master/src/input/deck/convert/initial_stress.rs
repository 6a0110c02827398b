//! Converts `*INITIAL_STRESS_SHELL` and `*INITIAL_STRESS_SOLID`: stress and plastic strain of
//! elements at the start, such as those of a `dynain` file of forming. They are read line by line,
//! because there may be millions.

use super::DeckConverter;
use super::mesh::start;
use super::sets::{SHELL_SETS, SOLID_SETS};
use crate::input::deck::keywords::KeywordRow;
use crate::input::deck::record::Cards;
use crate::input::deck::roles::OffsetKind;
use crate::input::deck::submodel::factor;
use crate::input::deck::text::KeywordBlock;
use crate::input::job::tree::Place;
use crumple_proto::ids::ElemId;
use crumple_proto::initial::InitialPoint;
use std::collections::{BTreeSet, HashMap, HashSet};

const OF_SHELLS: &str = "INITIAL_STRESS_SHELL";
/// Numbers of history variables on a line, in the standard and in the large format.
const ON_A_LINE: [usize; 2] = [8, 5];

/// Stresses of an element, or of the elements of a set, as written.
#[derive(Debug)]
pub struct DeckStress {
    /// Id of the element or of the set.
    id: i64,
    is_set: bool,
    of_shell: bool,
    /// Its points; the element is that of the deck.
    points: Vec<InitialPoint>,
    place: Place,
}

/// All stresses of a deck.
#[derive(Debug, Default)]
pub struct DeckStresses {
    all: Vec<DeckStress>,
    /// Largest number of history variables of a point that are not 0, by keyword.
    history: HashMap<&'static str, (usize, Place)>,
}

/// How many points and lines an element has.
struct StressHead {
    is_large: bool,
    /// Numbers of points in the plane and through the thickness.
    points: [usize; 2],
    history: usize,
}

impl DeckStresses {
    /// Reads a block of one of the keywords.
    pub fn read(
        &mut self,
        cards: &mut Cards<'_>,
        row: &'static KeywordRow,
        options: &[&str],
        block: &KeywordBlock,
    ) {
        let of_shell = row.keyword.name == OF_SHELLS;
        let is_set = options.contains(&"SET");
        let mut lines = block.lines.iter().copied();
        while let Some(line) = lines.next() {
            if line.0 == line.1 {
                continue;
            }
            let place = block.span(line, 0, (line.1 - line.0) as usize);
            let mut numbers = start(cards, &row.cards[0].0, block, line);
            let id = numbers.id(0) as i64;
            let all: [i64; 7] = std::array::from_fn(|field| numbers.integer(1 + field));
            let count = |n: i64| usize::try_from(n).unwrap_or(0);
            // Tensors and thermal data of shells, thermal data and volumes of solids.
            let (head, others) = match of_shell {
                true => (
                    StressHead {
                        is_large: all[4] != 0,
                        points: [count(all[0]).max(1), count(all[1]).max(1)],
                        history: count(all[2]),
                    },
                    [("ntensr", all[3] != 0), ("nthhsv", all[5] != 0 && all[6] != 0)],
                ),
                false => (
                    StressHead {
                        is_large: all[2] != 0,
                        points: [count(all[0]).max(1), 1],
                        history: count(all[1]),
                    },
                    [("iveflg", all[3] != 0), ("nthhsv", all[5] != 0 && all[6] != 0)],
                ),
            };
            if !numbers.whole {
                return;
            }
            if let Some((field, _)) = others.into_iter().find(|(_, is_given)| *is_given) {
                let message = format!(
                    "{}: element {id} has `{field}`, whose lines are not read",
                    block.shown()
                );
                let help = "write stresses and history only: tensors, thermal data and volumes \
                            at the start have no meaning here";
                cards.trouble.error(place, message, help);
                return cards.trouble.unsure();
            }
            if all[..3].iter().any(|count| *count < 0) {
                let message = format!("{}: element {id} has a count below 0", block.shown());
                cards.trouble.error(place, message, "give counts of points and variables");
                return cards.trouble.unsure();
            }
            let mut points = Vec::new();
            for number in 1..=head.points[0] {
                for _ in 0..head.points[1] {
                    let of = (number as u32, of_shell);
                    let Some(point) = self.point(cards, row, (block, &mut lines), &head, of) else {
                        let message =
                            format!("{} ends before the points of element {id}", block.shown());
                        let help = "give a line, or two in the large format, for each point";
                        cards.trouble.error(place, message, help);
                        return cards.trouble.unsure();
                    };
                    points.push(point);
                }
            }
            if of_shell {
                number_in_the_plane(&mut points);
                let most = points.iter().map(|point| point.number).max().unwrap_or(0);
                if most as usize > head.points[0] {
                    let message = format!(
                        "{}: element {id} has {most} points at one place through the thickness, \
                         and {} in its plane",
                        block.shown(),
                        head.points[0]
                    );
                    let help = "give nplane points at each of nthick positions from -1 to 1";
                    cards.trouble.error(place, message, help);
                }
            }
            let mut id = id;
            if let Some((submodel, _)) = &cards.submodel {
                let kind = if is_set { OffsetKind::Set } else { OffsetKind::Element };
                id = submodel.id(kind, id);
                let unit = factor(&submodel.units, &[1, -1, -2]);
                // A reflected shell has its corners in the other order.
                let exchanges = of_shell && head.points[0] == 4 && submodel.map.reflects();
                for point in &mut points {
                    point.stress = submodel.map.stress(point.stress).map(|s| unit * s);
                    point.number = match point.number {
                        2 if exchanges => 4,
                        4 if exchanges => 2,
                        other => other,
                    };
                }
                if submodel.map.stretches() {
                    let message =
                        format!("{}: stresses in a file that is stretched", block.shown());
                    let help = "move and turn the file only: a stretched body has other stresses";
                    cards.trouble.error(place, message, help);
                }
            }
            self.all.push(DeckStress { id, is_set, of_shell, points, place });
        }
    }

    /// Reads a point, with its history variables.
    fn point(
        &mut self,
        cards: &mut Cards<'_>,
        row: &'static KeywordRow,
        (block, lines): (&KeywordBlock, &mut impl Iterator<Item = (u32, u32)>),
        head: &StressHead,
        (number, of_shell): (u32, bool),
    ) -> Option<InitialPoint> {
        let first = if head.is_large { 2 } else { 1 };
        let line = lines.next()?;
        let place = block.span(line, 0, (line.1 - line.0) as usize);
        let card = &row.cards[first].0;
        let mut numbers = start(cards, card, block, line);
        let mut values: Vec<f64> = (0..card.fields.len()).map(|at| numbers.real(at)).collect();
        if head.is_large {
            let card = &row.cards[3].0;
            let mut numbers = start(cards, card, block, lines.next()?);
            values.extend((0..card.fields.len()).map(|at| numbers.real(at)));
        }
        let position = if of_shell { values.remove(0) } else { 0.0 };
        let mut given = values[7..].iter().filter(|value| **value != 0.0).count();
        let read = values.len() - 7;
        let each = ON_A_LINE[usize::from(head.is_large)];
        let card = &row.cards[if head.is_large { 5 } else { 4 }].0;
        for _ in 0..head.history.saturating_sub(read).div_ceil(each) {
            let mut numbers = start(cards, card, block, lines.next()?);
            given += (0..each).filter(|&at| numbers.real(at) != 0.0).count();
        }
        if given > 0 {
            let entry = self.history.entry(row.keyword.name).or_insert((given, place));
            entry.0 = entry.0.max(given);
        }
        Some(InitialPoint {
            element: ElemId(0),
            number,
            position,
            stress: std::array::from_fn(|c| values[c]),
            plastic_strain: values[6],
        })
    }
}

/// Numbers the points of each plane of a shell in their order. So it does not matter whether those
/// of a plane or those through the thickness follow each other.
fn number_in_the_plane(points: &mut [InitialPoint]) {
    let mut known: HashMap<u64, u32> = HashMap::new();
    for point in points {
        let number = known.entry((point.position + 0.0).to_bits()).or_default();
        *number += 1;
        point.number = *number;
    }
}

impl DeckConverter {
    /// Converts all stresses to those of elements. Sets of elements are known.
    pub(super) fn initial_stresses(&mut self) {
        let DeckStresses { all, history } = std::mem::take(&mut self.stresses);
        if all.is_empty() {
            return;
        }
        let mut found: Vec<_> = history.into_iter().collect();
        found.sort_unstable_by_key(|(keyword, _)| *keyword);
        for (keyword, (count, place)) in found {
            let message = format!(
                "*{keyword}: up to {count} history variables of a point are not 0 and have no \
                 meaning here"
            );
            let help = "the plastic strain is used; all other history of the materials, such as a \
                        damage or a back stress, is 0 at the start";
            self.trouble.warning(place, message, help);
        }
        let raised = self.rows.raised[0];
        let written = |of_shell: bool, id: ElemId| match of_shell {
            true => id.0 as i64,
            false => id.0.saturating_sub(raised) as i64,
        };
        let ids: [HashMap<i64, ElemId>; 2] =
            [(false, &self.rows.solids), (true, &self.rows.shells)].map(|(of_shell, list)| {
                list.iter().map(|e| (written(of_shell, e.id), e.id)).collect()
            });
        let gone: HashSet<(bool, i64)> = self
            .rows
            .removed
            .iter()
            .map(|e| (e.shape.is_shell(), written(e.shape.is_shell(), e.id)))
            .collect();
        let (mut taken, mut several) = (HashMap::new(), [false; 2]);
        for stress in all {
            let DeckStress { id, is_set, of_shell, points, place } = stress;
            let keyword = if of_shell { OF_SHELLS } else { "INITIAL_STRESS_SOLID" };
            if let Some(fault) = fault_of(&points, of_shell) {
                let message = format!("*{keyword}: {fault} of element {id}");
                let help = "positions of points are different numbers from -1 to 1, stresses are \
                            finite, and plastic strains at least 0";
                self.trouble.error(place, message, help);
                continue;
            }
            several[usize::from(of_shell)] |= points.iter().any(|point| point.number > 1);
            let of_kind = &ids[usize::from(of_shell)];
            let members: Vec<ElemId> = match is_set {
                false => of_kind.get(&id).copied().into_iter().collect(),
                true => {
                    let sets = &self.element_sets[if of_shell { SHELL_SETS } else { SOLID_SETS }];
                    let Some(ranges) = sets.get(&id) else {
                        let known: Vec<String> = sets.keys().map(i64::to_string).collect();
                        let what = if of_shell { "*SET_SHELL_..." } else { "*SET_SOLID..." };
                        self.missing(place, what, id, &known);
                        continue;
                    };
                    let mut ranges = ranges.clone();
                    ranges.sort_unstable();
                    // The largest end of the ranges so far: they may lie in each other.
                    let ends: Vec<i64> = ranges
                        .iter()
                        .scan(i64::MIN, |end, range| {
                            *end = range[1].max(*end);
                            Some(*end)
                        })
                        .collect();
                    let is_in = |id: &i64| {
                        let before = ranges.partition_point(|range| range[0] <= *id);
                        before > 0 && ends[before - 1] >= *id
                    };
                    let mut members: Vec<ElemId> =
                        of_kind.iter().filter(|(id, _)| is_in(id)).map(|(_, e)| *e).collect();
                    members.sort_unstable();
                    members
                }
            };
            if members.is_empty() && !is_set && !gone.contains(&(of_shell, id)) {
                let what = if of_shell { "shell" } else { "solid" };
                let message = format!("*{keyword}: there is no {what} with the id {id}");
                let help = "correct the id, or remove the stress";
                self.trouble.error(place, message, help);
            }
            for element in members {
                // A later card replaces an earlier one.
                taken.insert(element, points.clone());
            }
        }
        for (of_shell, several) in [false, true].into_iter().zip(several) {
            if several {
                let (keyword, used) = match of_shell {
                    true => (OF_SHELLS, "the mean of the points in the plane in shells with one"),
                    false => ("INITIAL_STRESS_SOLID", "the mean of the points of a solid"),
                };
                self.map(format!("*{keyword}"), "stresses at several points", used);
            }
        }
        self.stresses_of_rigid(&taken);
        let initial = &mut self.rows.initial;
        for (element, points) in taken {
            initial.extend(points.into_iter().map(|point| InitialPoint { element, ..point }));
        }
        crumple_proto::initial::sort(initial);
        let used = "stress and plastic strain at the start; no internal energy";
        self.map("*INITIAL_STRESS_...", format!("{} points", self.rows.initial.len()), used);
    }

    /// Reports stresses of rigid parts, which have no effect.
    fn stresses_of_rigid(&mut self, taken: &HashMap<ElemId, Vec<InitialPoint>>) {
        let elements = self.rows.shells.iter().chain(&self.rows.solids);
        let stressed: BTreeSet<u32> =
            elements.filter(|e| taken.contains_key(&e.id)).map(|e| e.part).collect();
        for part in stressed {
            let Some(rigid) = self.parts.get(&i64::from(part)).filter(|p| p.rigid.is_some()) else {
                continue;
            };
            let message = format!(
                "*INITIAL_STRESS_...: the stresses of part {part} have no effect, since it is rigid"
            );
            let help = "give the part another material if it deforms";
            self.trouble.warning(rigid.place, message, help);
        }
    }
}

/// Returns what is wrong with the points of an element.
fn fault_of(points: &[InitialPoint], of_shell: bool) -> Option<&'static str> {
    let is_odd = |p: &InitialPoint| p.stress.iter().any(|s| !s.is_finite());
    if points.iter().any(is_odd) {
        return Some("a stress that is not finite");
    }
    if points.iter().any(|p| !(p.plastic_strain >= 0.0 && p.plastic_strain.is_finite())) {
        return Some("a plastic strain below 0");
    }
    if !of_shell {
        return None;
    }
    if points.iter().any(|p| !(-1.0..=1.0).contains(&p.position)) {
        return Some("a position outside of the thickness");
    }
    let mut places: Vec<(u32, u64)> =
        points.iter().map(|p| (p.number, (p.position + 0.0).to_bits())).collect();
    places.sort_unstable();
    let several = places.len();
    places.dedup();
    (places.len() < several).then_some("two points at one place through the thickness")
}
