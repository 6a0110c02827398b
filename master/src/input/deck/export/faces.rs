//! Writes pressure on faces. If a card cannot hold an entry exactly, the whole list is written
//! after `$crumple:`.

use super::{DeckWriter, Id, Number, TimeCurves, list};
use crate::input::job::{Model, outer_faces};
use crumple_proto::ids::NodeId;
use crumple_proto::job::Job;
use crumple_proto::loads::Pressure;
use crumple_proto::mesh::free_faces;
use std::collections::HashMap;

/// A face as the place of its element and its number there.
pub(super) type Face = (usize, usize);

/// Corners of the faces under each pressure.
pub(super) type LoadedFaces = Vec<Vec<[NodeId; 4]>>;

/// Returns the faces under pressures; `None` if a card cannot hold all of them. Segments name a
/// face by its nodes only, so that no other face may have the same nodes.
pub(super) fn of_pressures(model: &Model) -> Option<LoadedFaces> {
    let loads = &model.settings.loads.pressures;
    if loads.is_empty() {
        return Some(Vec::new());
    }
    // Explosions are listed with all their digits.
    if loads.iter().any(|load| load.blast.is_some()) {
        return None;
    }
    let mut counts: HashMap<Vec<NodeId>, usize> = HashMap::new();
    for face in outer_faces(&model.mesh, &free_faces(&model.mesh.elements), |_| true, None) {
        *counts.entry(sorted(&corners(model, face))).or_default() += 1;
    }
    let place = |id| model.mesh.elements.binary_search_by_key(&id, |e| e.id).ok();
    let of_load = |load: &Pressure| {
        let faces = load.faces.iter().map(|&(id, face)| {
            let corners = corners(model, (place(id)?, usize::from(face)));
            (counts.get(&sorted(&corners)) == Some(&1)).then_some(corners)
        });
        faces.collect()
    };
    loads.iter().map(of_load).collect()
}

/// Writes pressures on sets of segments.
pub fn pressures(
    deck: &mut DeckWriter,
    job: &Job,
    faces: Option<LoadedFaces>,
    curves: &mut TimeCurves<'_>,
) {
    let Some(faces) = faces else { return list(deck, "pressure", &job.pressure) };
    for (faces, input) in faces.iter().zip(&job.pressure) {
        let curve = curves.id(deck, input.curve.as_deref());
        let set = segments(deck, faces);
        deck.keyword("LOAD_SEGMENT_SET");
        deck.card(&[Id(set), Id(curve), Number(input.pressure)]);
    }
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
pub(super) fn sorted(nodes: &[NodeId]) -> Vec<NodeId> {
    let mut nodes = nodes.to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
