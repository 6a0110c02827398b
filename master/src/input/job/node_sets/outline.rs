//! Rules by edges of shells and faces of solids.

use crumple_proto::ids::NodeId;
use crumple_proto::job::SetRule;
use crumple_proto::mesh::{Mesh, MeshElement, free_faces};
use std::collections::HashMap;

/// Returns the nodes of the edges and faces that a rule selects, ascending. `is_in` is true for the
/// elements that the rule looks at.
pub fn nodes(
    rule: SetRule,
    mesh: &Mesh,
    index: &HashMap<NodeId, usize>,
    is_in: &dyn Fn(&MeshElement) -> bool,
) -> Vec<usize> {
    let inside = || mesh.elements.iter().filter(|e| is_in(e));
    let ids: Vec<NodeId> = match rule {
        SetRule::FreeEdges => {
            let counts = edge_counts(mesh.elements.iter());
            inside().flat_map(edges).filter(|edge| counts[edge] == 1).flatten().collect()
        }
        SetRule::Boundary => {
            let own: Vec<MeshElement> = inside().copied().collect();
            let counts = edge_counts(own.iter());
            let edges = own.iter().flat_map(edges).filter(|edge| counts[edge] == 1);
            edges.flatten().chain(faces(own.iter().zip(free_faces(&own)))).collect()
        }
        _ => {
            let free = free_faces(&mesh.elements);
            let own = mesh.elements.iter().zip(free).filter(|(e, _)| is_in(e));
            let shells = inside().filter(|e| e.shape.is_shell()).flat_map(|e| e.corners());
            shells.copied().chain(faces(own)).collect()
        }
    };
    let mut nodes: Vec<usize> = ids.iter().filter_map(|id| index.get(id).copied()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Returns the edges of a shell, each with its lower node first; none of other elements.
fn edges(element: &MeshElement) -> impl Iterator<Item = [NodeId; 2]> {
    let corners = if element.shape.is_shell() { element.corners() } else { &[] };
    (0..corners.len()).map(|k| {
        let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
        [a.min(b), a.max(b)]
    })
}

/// Returns the number of shells that have each edge.
fn edge_counts<'m>(elements: impl Iterator<Item = &'m MeshElement>) -> HashMap<[NodeId; 2], usize> {
    let mut counts = HashMap::new();
    elements.flat_map(edges).for_each(|edge| *counts.entry(edge).or_default() += 1);
    counts
}

/// Returns the nodes of the free faces of solids, given as one bit per face.
fn faces<'m>(
    elements: impl Iterator<Item = (&'m MeshElement, u16)>,
) -> impl Iterator<Item = NodeId> {
    elements.flat_map(|(e, free)| {
        let faces = e.shape.faces().iter().enumerate();
        let free = faces.filter(move |(f, _)| e.shape.is_solid() && free >> f & 1 == 1);
        free.flat_map(|(_, corners)| corners.map(|c| e.nodes[c]))
    })
}
