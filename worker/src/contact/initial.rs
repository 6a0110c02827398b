//! The contact surface of the mesh as it is given, for warnings before the start: what penetrates, and what is met with less than
//! its thickness.

use crate::blocks::LocalElement;
use crate::contact::geometry::{V3, nearest};
use crate::contact::local::{BEHIND, BESIDE, is_opposed};
use crate::contact::search::linked_cells;
use crate::contact::surface::{ContactParts, Segment, Surface};
use crate::nodes::{Nodes, xyz};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::Shape;
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
    /// Whether it is so deep in a solid that contact does not see it.
    pub unseen: bool,
}

/// Penetrations below this fraction of the contact thickness are round-off of the mesh.
const ROUND_OFF: f64 = 1e-6;

/// All penetrations of a mesh (records sorted by id), in ascending node id: the deepest shell for each node, or the nearest face of
/// a solid that it is in. The run tolerates what it sees and gives it back slowly.
pub fn initial_penetrations(settings: &Settings, elements: &[ElementRecord], nodes: &[NodeRecord]) -> Vec<Penetration> {
    if settings.contact.is_none() {
        return Vec::new();
    }
    let (nodes, mut surface) = whole_surface(settings, elements, nodes);
    surface.collect_slaves(&nodes);
    surface.link_faces(nodes.held);
    let tied: HashSet<(NodeId, NodeId)> =
        settings.ties.iter().flat_map(|t| t.partners().flat_map(|p| [(t.node, p), (p, t.node)])).collect();
    let is_tied = |slave: u32, corners: &[u32]| {
        !tied.is_empty() && corners.iter().any(|&c| tied.contains(&(nodes.id[slave as usize], nodes.id[c as usize])))
    };
    let mut found = in_shells(&nodes, &surface, is_tied);
    found.extend(in_solids(&nodes, &surface, elements, is_tied));
    found.sort_by(|a, b| a.node.cmp(&b.node).then(b.depth.total_cmp(&a.depth)).then(a.elem.cmp(&b.elem)));
    found.dedup_by_key(|p| p.node);
    found
}

fn in_shells(nodes: &Nodes, surface: &Surface, is_tied: impl Fn(u32, &[u32]) -> bool) -> Vec<Penetration> {
    let largest = surface.largest_scale();
    let shells: Vec<&Segment> = surface.segments.iter().filter(|s| !s.is_solid()).collect();
    let boxes: Vec<_> = shells.iter().map(|s| s.bounds(&nodes.x, s.scale + largest)).collect();
    let mut found = Vec::new();
    for (g, p) in linked_cells(&boxes, &points(nodes, surface)) {
        let (s, slave) = (shells[g as usize], surface.slaves[p as usize]);
        if s.nodes.contains(&slave) || is_tied(slave, &s.nodes) {
            continue;
        }
        let at = V3::from(xyz(&nodes.x[slave as usize]));
        let Some(near) = nearest(&at, &s.corners(&nodes.x), s.is_triangle()) else { continue };
        let depth = s.half + surface.node_half[slave as usize] - (at - near.point).norm();
        if depth > ROUND_OFF * (s.scale + surface.node_scale[slave as usize]) {
            found.push(Penetration { node: nodes.id[slave as usize], elem: s.id.elem(), depth, unseen: false });
        }
    }
    found
}

/// Nodes in solids that they do not belong to. How deep they are tell the faces that the surface around them faces against: a corner
/// that lies in a side of a block has gone in by its top.
fn in_solids(
    nodes: &Nodes,
    surface: &Surface,
    elements: &[ElementRecord],
    is_tied: impl Fn(u32, &[u32]) -> bool,
) -> Vec<Penetration> {
    let faces: Vec<&Segment> = surface.segments.iter().filter(|s| s.is_solid()).collect();
    let with_faces: HashSet<u32> = faces.iter().map(|s| s.part).collect();
    let number = |n: NodeId| nodes.held_number(n).expect("an element's nodes are in the mesh");
    let solids: Vec<[u32; 8]> = elements
        .iter()
        .filter(|e| e.shape == Shape::Hex8 && with_faces.contains(&e.part))
        .map(|e| e.nodes.map(number))
        .collect();
    let place = |&n: &u32| xyz(&nodes.x[n as usize]);
    let boxes: Vec<Aabb> = solids.iter().map(|c| Aabb::around(c.iter().map(place))).collect();
    let inside = |(e, p): &(u32, u32)| {
        let (corners, slave) = (&solids[*e as usize], surface.slaves[*p as usize]);
        !corners.contains(&slave)
            && !is_tied(slave, corners)
            && is_inside(&V3::from(xyz(&nodes.x[slave as usize])), &corners.map(|n| V3::from(place(&n))))
    };
    let mut slaves: Vec<u32> =
        linked_cells(&boxes, &points(nodes, surface)).into_iter().filter(inside).map(|found| found.1).collect();
    slaves.sort_unstable();
    slaves.dedup();
    let into = |&p: &u32| {
        let slave = surface.slaves[p as usize];
        let at = V3::from(xyz(&nodes.x[slave as usize]));
        let depth = |s: &&&Segment| {
            let near = nearest(&at, &s.corners(&nodes.x), s.is_triangle())?;
            let (offset, scale) = (at - near.point, s.scale + surface.node_scale[slave as usize]);
            let depth = -offset.dot(&near.normal);
            let behind = depth > -ROUND_OFF * scale && (offset + near.normal * depth).norm() <= BESIDE * scale;
            let other = !s.nodes.contains(&slave) && !s.behind.contains(&slave);
            (behind && other && is_opposed(nodes, surface, p as usize, &near.normal)).then_some((depth, scale))
        };
        let nearest_face =
            faces.iter().filter_map(|s| depth(&s).map(|d| (s, d))).min_by(|a, b| a.1.0.total_cmp(&b.1.0));
        let (face, (depth, scale)) = nearest_face.filter(|(_, (depth, scale))| *depth > ROUND_OFF * scale)?;
        let (node, elem) = (nodes.id[slave as usize], face.id.elem());
        Some(Penetration { node, elem, depth, unseen: depth > BEHIND * scale })
    };
    slaves.iter().filter_map(into).collect()
}

fn points(nodes: &Nodes, surface: &Surface) -> Vec<[f64; 3]> {
    surface.slaves.iter().map(|&i| xyz(&nodes.x[i as usize])).collect()
}

/// Whether a point is in a hexahedron, but for round-off, by the planes through the middles of its faces.
fn is_inside(at: &V3, corners: &[V3; 8]) -> bool {
    Shape::Hex8.faces().iter().all(|f| {
        let [a, b, c, d] = f.map(|i| corners[i]);
        let outward = (c - a).cross(&(d - b));
        (at - (a + b + c + d) * 0.25).dot(&outward) <= ROUND_OFF * outward.norm() * (c - a).norm()
    })
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
