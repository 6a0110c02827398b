//! The contact surface of the mesh as it is given, for warnings before the start: what penetrates, and what is met with less than
//! its thickness.

use crate::blocks::LocalElement;
use crate::contact::geometry::{V3, nearest};
use crate::contact::search::linked_cells;
use crate::contact::surface::{ContactParts, Surface};
use crate::nodes::{Nodes, xyz};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::partition::{ElementRecord, NodeRecord, Settings};
use std::collections::HashSet;

/// A node that starts inside a shell's thickness or a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// The node.
    pub node: NodeId,
    /// The shell or solid.
    pub elem: ElemId,
    /// How far their surfaces overlap [length].
    pub depth: f64,
}

/// Penetrations below this fraction of the contact thickness are round-off of the mesh.
const ROUND_OFF: f64 = 1e-6;

/// All penetrations of a mesh (records sorted by id), the deepest shell for each node, in ascending node id.
/// The run tolerates them and gives them back slowly.
pub fn initial_penetrations(settings: &Settings, elements: &[ElementRecord], nodes: &[NodeRecord]) -> Vec<Penetration> {
    if settings.contact.is_none() {
        return Vec::new();
    }
    let (nodes, mut surface) = whole_surface(settings, elements, nodes);
    surface.collect_slaves(&nodes);
    let largest = surface.largest_scale();
    let boxes: Vec<_> = surface.segments.iter().map(|s| s.bounds(&nodes.x, s.scale + largest)).collect();
    let points: Vec<[f64; 3]> = surface.slaves.iter().map(|&i| xyz(&nodes.x[i as usize])).collect();
    let tied: HashSet<(NodeId, NodeId)> =
        settings.ties.iter().flat_map(|t| t.partners().flat_map(|p| [(t.node, p), (p, t.node)])).collect();
    let mut found: Vec<Penetration> = Vec::new();
    for (g, p) in linked_cells(&boxes, &points) {
        let (s, slave) = (&surface.segments[g as usize], surface.slaves[p as usize]);
        if s.nodes.contains(&slave) || s.behind.contains(&slave) {
            continue;
        }
        let are_tied = |corner: &u32| tied.contains(&(nodes.id[slave as usize], nodes.id[*corner as usize]));
        if !tied.is_empty() && s.nodes.iter().any(are_tied) {
            continue;
        }
        let thickness = s.half + surface.node_half[slave as usize];
        let at = V3::from(points[p as usize]);
        let Some(near) = nearest(&at, &s.corners(&nodes.x), s.is_triangle()) else { continue };
        let scale = s.scale + surface.node_scale[slave as usize];
        let offset = at - near.point;
        // A solid has no thickness: what is behind its face, and not beside it, is inside. What is behind the very edge
        // may lie on the next face of the solid.
        let at_edge = || near.rim || near.shape.iter().any(|&n| n < ROUND_OFF);
        let apart = if !s.is_solid() {
            offset.norm()
        } else if at_edge() || offset.norm() > scale {
            f64::INFINITY
        } else {
            offset.dot(&near.normal)
        };
        let depth = thickness - apart;
        if depth > ROUND_OFF * scale {
            found.push(Penetration { node: nodes.id[slave as usize], elem: s.id.elem(), depth });
        }
    }
    found.sort_by(|a, b| a.node.cmp(&b.node).then(b.depth.total_cmp(&a.depth)).then(a.elem.cmp(&b.elem)));
    found.dedup_by_key(|p| p.node);
    found
}

/// How many shells are met with less than their thickness ([`crumple_proto::job::Contact::thickness_limit`]), and the smallest
/// fraction of it that is left; `None` if all are met as they are.
pub fn thinned_shells(settings: &Settings, elements: &[ElementRecord], nodes: &[NodeRecord]) -> Option<(usize, f64)> {
    settings.contact.as_ref()?;
    let (_, surface) = whole_surface(settings, elements, nodes);
    let shells = surface.segments.iter().filter(|s| !s.is_solid());
    let shares = shells.map(|s| 2.0 * s.half / settings.parts[s.part as usize].thickness).filter(|&share| share < 1.0);
    shares.fold(None, |sum, share| {
        Some(sum.map_or((1, share), |(count, least): (usize, f64)| (count + 1, least.min(share))))
    })
}

/// The surface of a whole mesh, with its nodes.
fn whole_surface(settings: &Settings, elements: &[ElementRecord], nodes: &[NodeRecord]) -> (Nodes, Surface) {
    let nodes = Nodes::new(nodes, 0, false);
    let local = |e: &ElementRecord| {
        let numbers = e.nodes.map(|n| nodes.held_number(n).expect("an element's nodes are in the mesh"));
        LocalElement { record: *e, nodes: numbers, shared: false }
    };
    let elements: Vec<LocalElement> = elements.iter().map(local).collect();
    let surface = Surface::of(&elements, &nodes, &ContactParts::of(settings));
    (nodes, surface)
}
