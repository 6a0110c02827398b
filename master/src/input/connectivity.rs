//! Connected pieces of parts, and the pieces that share nodes and could move as one body.

use crumple_proto::ids::NodeId;
use crumple_proto::mesh::Mesh;
use petgraph::unionfind::UnionFind;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// A connected piece of a part.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ConnectedPiece {
    /// Number among the pieces of all parts, from 0.
    pub number: usize,
    /// Pieces of other parts that share nodes with it, ascending.
    pub joined: Vec<usize>,
}

/// Returns the pieces of each part, by part id. Elements of a part that share a node belong to
/// one piece.
pub fn pieces(mesh: &Mesh) -> BTreeMap<u32, Vec<ConnectedPiece>> {
    let mut places: FxHashMap<(u32, NodeId), usize> = FxHashMap::default();
    let mut sets = UnionFind::<usize>::new_empty();
    for e in &mesh.elements {
        let corners: Vec<usize> = e
            .corners()
            .iter()
            .map(|&node| *places.entry((e.part, node)).or_insert_with(|| sets.new_set()))
            .collect();
        for &corner in &corners {
            sets.union(corners[0], corner);
        }
    }
    // Numbers in order of part and lowest node, independent of the order of the table.
    let mut ordered: Vec<((u32, NodeId), usize)> = places.into_iter().collect();
    ordered.sort_unstable();
    let mut numbers: FxHashMap<usize, usize> = FxHashMap::default();
    let mut parts: BTreeMap<u32, Vec<ConnectedPiece>> = BTreeMap::new();
    let mut at: BTreeMap<NodeId, BTreeSet<usize>> = BTreeMap::new();
    for ((part, node), place) in ordered {
        let next = numbers.len();
        let number = *numbers.entry(sets.find_mut(place)).or_insert_with(|| {
            parts
                .entry(part)
                .or_default()
                .push(ConnectedPiece { number: next, joined: Vec::new() });
            next
        });
        at.entry(node).or_default().insert(number);
    }
    let mut joined: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for here in at.values().filter(|here| here.len() > 1) {
        for &piece in here {
            joined.entry(piece).or_default().extend(here.iter().filter(|&&other| other != piece));
        }
    }
    for piece in parts.values_mut().flatten() {
        piece.joined = joined.remove(&piece.number).unwrap_or_default().into_iter().collect();
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::ids::ElemId;
    use crumple_proto::mesh::{MeshElement, OwnSection, Shape, corner_nodes};

    /// Two triangles of part 1 without a common node, and one of part 2 that touches both.
    #[test]
    fn pieces_are_joined_through_common_nodes() {
        let element = |id, part, nodes: [u64; 3]| MeshElement {
            id: ElemId(id),
            part,
            shape: Shape::Tri3,
            nodes: corner_nodes(&nodes.map(NodeId)),
            own: OwnSection::default(),
        };
        let mesh = Mesh {
            elements: vec![
                element(1, 1, [1, 2, 3]),
                element(2, 1, [4, 5, 6]),
                element(3, 2, [3, 4, 7]),
            ],
            ..Mesh::default()
        };
        let found = pieces(&mesh);
        let piece = |number, joined: &[usize]| ConnectedPiece { number, joined: joined.to_vec() };
        assert_eq!(found[&1], [piece(0, &[2]), piece(1, &[2])]);
        assert_eq!(found[&2], [piece(2, &[0, 1])]);
    }
}
