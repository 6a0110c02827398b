//! Writes pressure on faces and ties. Entries of a list that a card cannot hold exactly keep the
//! whole list after `$crumple:`.

use super::{Blank, CardValue, DeckWriter, Id, Number, TimeCurves, line, list};
use crate::input::job::{Model, outer_faces};
use crumple_proto::ids::NodeId;
use crumple_proto::job::TieInput;
use crumple_proto::mesh::free_faces;
use std::collections::HashMap;

/// A face as the place of its element and its number there.
pub(super) type Face = (usize, usize);

/// Writes pressures on sets of segments. Segments name a face by its nodes only, so that no other
/// face may have the same nodes.
pub fn pressures(deck: &mut DeckWriter, model: &Model, curves: &mut TimeCurves<'_>) {
    let loads = &model.settings.loads.pressures;
    if loads.is_empty() {
        return;
    }
    let mut counts: HashMap<Vec<NodeId>, usize> = HashMap::new();
    for face in outer_faces(&model.mesh, &free_faces(&model.mesh.elements), |_| true, None) {
        *counts.entry(sorted(&corners(model, face))).or_default() += 1;
    }
    let place = |id| model.mesh.elements.binary_search_by_key(&id, |e| e.id).ok();
    let all: Option<Vec<Vec<[NodeId; 4]>>> = loads
        .iter()
        .map(|load| {
            let faces = load.faces.iter().map(|&(id, face)| {
                let corners = corners(model, (place(id)?, usize::from(face)));
                (counts.get(&sorted(&corners)) == Some(&1)).then_some(corners)
            });
            faces.collect()
        })
        .collect();
    let Some(all) = all else { return list(deck, "pressure", &model.job.pressure) };
    for (faces, input) in all.iter().zip(&model.job.pressure) {
        let curve = curves.id(deck, input.curve.as_deref());
        let set = segments(deck, faces);
        deck.keyword("LOAD_SEGMENT_SET");
        deck.card(&[Id(set), Id(curve), Number(input.pressure)]);
    }
}

/// Cards of one tie.
enum TieCards {
    /// To a surface: the faces of parts, or segments.
    Surface(Result<Vec<u32>, Vec<[NodeId; 4]>>),
    /// To the mean motion of nodes.
    Mean { slave: NodeId, masters: Vec<NodeId> },
}

impl TieCards {
    /// Returns the cards of a tie, or `None` if there are none.
    fn new(tie: &TieInput, model: &Model) -> Option<Self> {
        let nodes = |set: &str| model.mesh.node_sets.get(set);
        if tie.node.is_some() || tie.failure.is_some() {
            return None;
        }
        if let Some(of) = &tie.mean_of {
            let (&[slave], masters) = (&nodes(&tie.nodes)?[..], nodes(of)?.clone()) else {
                return None;
            };
            return Some(Self::Mean { slave, masters });
        }
        let Some(set) = &tie.faces else { return Some(Self::Surface(Ok(tie.parts.clone()))) };
        // A deck keeps the nodes of the segments, which must hold no other face.
        let free = free_faces(&model.mesh.elements);
        let of_part = |part: u32| tie.parts.is_empty() || tie.parts.contains(&part);
        let faces = outer_faces(&model.mesh, &free, of_part, Some(&sorted(nodes(set)?)));
        let segments: Vec<[NodeId; 4]> = faces.iter().map(|&face| corners(model, face)).collect();
        let within = sorted(segments.as_flattened());
        let same = outer_faces(&model.mesh, &free, |_| true, Some(&within)) == faces;
        same.then_some(Self::Surface(Err(segments)))
    }

    /// Returns the place of the keyword in the order in which decks are read.
    fn rank(&self, rotations: bool) -> u8 {
        match self {
            Self::Surface(_) => u8::from(rotations),
            Self::Mean { .. } => 2,
        }
    }
}

/// Writes ties to surfaces and to the mean motion of nodes. Ties keep their order, so that all
/// are written after `$crumple:` if a deck would be read in another order.
pub fn ties(deck: &mut DeckWriter, model: &Model, set: impl Fn(&str) -> CardValue) {
    let ties = &model.job.tie;
    let cards: Option<Vec<TieCards>> = ties.iter().map(|tie| TieCards::new(tie, model)).collect();
    let ranked = |cards: &Vec<TieCards>| {
        cards.iter().zip(ties).map(|(card, tie)| card.rank(tie.rotations)).is_sorted()
    };
    let Some(cards) = cards.filter(ranked) else { return list(deck, "tie", ties) };
    for ((number, tie), cards) in (1..).zip(ties).zip(cards) {
        match cards {
            TieCards::Surface(surface) => {
                to_surface(deck, tie, (set(&tie.nodes), surface), number);
            }
            TieCards::Mean { slave, masters } => {
                deck.keyword("CONSTRAINED_INTERPOLATION");
                let ddof = if tie.rotations { 123_456 } else { 123 };
                deck.card(&[Id(number), Id(slave.label()), Id(ddof)]);
                for (place, master) in masters.iter().enumerate() {
                    let weight = tie.weights.get(place).copied().unwrap_or(1.0);
                    deck.card(&[Id(master.label()), Id(123), Number(weight)]);
                }
            }
        }
    }
}

/// Writes a tie of a node set to a surface.
fn to_surface(
    deck: &mut DeckWriter,
    tie: &TieInput,
    (nodes, surface): (CardValue, Result<Vec<u32>, Vec<[NodeId; 4]>>),
    number: u64,
) {
    let (surface, kind) = match surface {
        Ok(parts) => (deck.part_set(&parts), 2),
        Err(faces) => (segments(deck, &faces), 0),
    };
    let keyword = if tie.rotations { "SHELL_EDGE_TO_SURFACE" } else { "NODES_TO_SURFACE" };
    let option = if tie.offset { "_OFFSET" } else { "" };
    deck.keyword(&format!("CONTACT_TIED_{keyword}{option}_ID"));
    deck.named_card(number, &line(&tie.name).chars().take(70).collect::<String>());
    deck.card(&[nodes, Id(surface), Id(4), Id(kind)]);
    deck.card(&[Number(0.0)]);
    let [ahead, behind] = match tie.tolerance {
        t if t > 0.0 => [-t, 0.0],
        _ => tie.thicknesses,
    };
    deck.card(&[Blank, Blank, Number(ahead), Number(behind)]);
}

/// Writes a set of segments, and returns its id.
pub(super) fn segments(deck: &mut DeckWriter, faces: &[[NodeId; 4]]) -> u64 {
    deck.segment_sets += 1;
    let id = deck.segment_sets;
    deck.keyword("SET_SEGMENT");
    deck.card(&[Id(id)]);
    faces.iter().for_each(|face| deck.card(&face.map(|n| Id(n.label()))));
    id
}

pub(super) fn corners(model: &Model, (element, face): Face) -> [NodeId; 4] {
    let element = &model.mesh.elements[element];
    element.shape.faces()[face].map(|corner| element.nodes[corner])
}

/// Returns nodes in ascending order, each once.
fn sorted(nodes: &[NodeId]) -> Vec<NodeId> {
    let mut nodes = nodes.to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
