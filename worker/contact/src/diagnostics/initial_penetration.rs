//! Checks of the contact surface of the initial mesh, for warnings before the start: initial
//! penetrations, and shells and beams whose thickness in contact is reduced.

use crate::geometry::nearest;
use crate::local_search::is_opposed;
use crate::reach::{BEHIND, OUTSIDE};
use crate::search::{LINKED_CELLS, accepted, linked_cells};
use crate::surface::{ContactParts, Segment, Surface};
use crumple_fem::blocks::{Class, LocalElement};
use crumple_fem::nodes::Nodes;
use crumple_math::row::{V3, xyz};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::{MAX_CORNERS, Shape};
use crumple_proto::partition::{ElementRecord, NodeRecord, Settings};
use std::collections::{HashMap, HashSet};

/// A node that starts inside a shell's thickness, a beam or a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// The node.
    pub node: NodeId,
    /// The shell, beam or solid.
    pub elem: ElemId,
    /// Depth by which their surfaces overlap [length]. A node is seen from the side of a shell on
    /// which it is, so that no depth exceeds the contact thickness.
    pub depth: f64,
    /// Unit vector along which the node leaves the element.
    pub normal: [f64; 3],
    /// True if the node is so near the middle of a shell or beam that its part may come from the
    /// other side: the true depth is `depth` or more.
    pub at_least: bool,
    /// True if it is so deep in a solid that contact does not see it.
    pub unseen: bool,
}

/// Fraction of the contact thickness below which a penetration is round-off of the mesh.
const ROUND_OFF: f64 = 1e-6;

/// Fraction of the contact thickness above which the side from which a node has entered a shell is
/// not known.
const MIDDLE: f64 = 0.75;

/// Result of the checks of the contact surface before the start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InitialPenetrations {
    /// All penetrations, in ascending node id: for each node the deepest shell, or the nearest
    /// face of a solid in which it is. The run tolerates those that contact sees until the gap
    /// opens by itself.
    pub penetrations: Vec<Penetration>,
    /// Number of shells and beams whose thickness in contact is reduced
    /// ([`crumple_proto::job::ContactInput::thickness_limit`]), and the smallest fraction of the
    /// thickness that is left; `None` if there are none.
    pub thinned: Option<(usize, f64)>,
}

/// Checks the contact surface of a mesh (records sorted by id).
pub fn initial(
    settings: &Settings,
    elements: &[ElementRecord],
    nodes: &[NodeRecord],
) -> InitialPenetrations {
    if settings.contact.is_none() {
        return InitialPenetrations::default();
    }
    let (nodes, mut surface) = whole_surface(settings, elements, nodes);
    surface.collect_slaves(&nodes);
    surface.link_faces(nodes.local_count);
    let tied: HashSet<(NodeId, NodeId)> = settings
        .ties
        .iter()
        .flat_map(|t| t.partners().flat_map(|p| [(t.node, p), (p, t.node)]))
        .collect();
    let is_tied = |slave: u32, corners: &[u32]| {
        !tied.is_empty()
            && corners
                .iter()
                .any(|&c| tied.contains(&(nodes.id[slave as usize], nodes.id[c as usize])))
    };
    let mut found = in_shells(&nodes, &surface, is_tied);
    found.extend(in_solids(&nodes, &surface, elements, is_tied));
    found.sort_by(|a, b| {
        a.node.cmp(&b.node).then(b.depth.total_cmp(&a.depth)).then(a.elem.cmp(&b.elem))
    });
    found.dedup_by_key(|p| p.node);
    InitialPenetrations { penetrations: found, thinned: thinned(settings, elements, &surface) }
}

fn in_shells(
    nodes: &Nodes,
    surface: &Surface,
    is_tied: impl Fn(u32, &[u32]) -> bool + Sync,
) -> Vec<Penetration> {
    let largest = surface.largest_scale();
    let shells: Vec<&Segment> = surface.segments.iter().filter(|s| !s.is_solid()).collect();
    let added = surface.shift_reach();
    let reach = |s: &Segment| surface.interfaces.most(s.scale + largest) + added;
    let boxes: Vec<_> = shells.iter().map(|s| s.bounds(&nodes.x, reach(s))).collect();
    let penetration = |[g, p]: [u32; 2]| {
        let (s, slave) = (shells[g as usize], surface.slaves[p as usize]);
        if s.nodes.contains(&slave) || is_tied(slave, &s.nodes) {
            return None;
        }
        // Lines next to a node's own lines do not touch it.
        if s.is_line()
            && surface.around(p as usize).any(|own| own.nodes.iter().any(|n| s.nodes.contains(n)))
        {
            return None;
        }
        let at = V3::from(xyz(&nodes.x[slave as usize]));
        let near = s.nearest(&at, &nodes.x)?;
        let interface = surface.interface(p as usize, s)?;
        let (thickness, scale) = surface.sizes(interface, slave, s);
        let pair = (interface, p as usize);
        let depth = thickness - surface.distance(pair, s, (&at, &near), &nodes.x);
        (depth > ROUND_OFF * scale).then(|| {
            let away = (at - near.point).try_normalize(ROUND_OFF * scale);
            Penetration {
                node: nodes.id[slave as usize],
                elem: s.id.elem(),
                depth,
                normal: away.unwrap_or(near.normal).into(),
                at_least: depth > MIDDLE * thickness,
                unseen: false,
            }
        })
    };
    let slaves = points(nodes, surface);
    // Few pairs penetrate, so that it does not matter that they are computed twice.
    let pairs = accepted(LINKED_CELLS, &boxes, &slaves, |g, p| penetration([g, p]).is_some());
    let mut found: Vec<Penetration> = pairs.into_iter().filter_map(penetration).collect();
    found.sort_by_key(|p| (p.elem, p.node));
    found
}

/// Returns the nodes that are in solids to which they do not belong. Their depth is measured
/// from the faces that are opposed to the surface around the node. Example: a corner that lies
/// in a side of a block has entered through the block's top.
fn in_solids(
    nodes: &Nodes,
    surface: &Surface,
    elements: &[ElementRecord],
    is_tied: impl Fn(u32, &[u32]) -> bool,
) -> Vec<Penetration> {
    let faces: Vec<&Segment> = surface.segments.iter().filter(|s| s.is_solid()).collect();
    let with_faces: HashSet<u32> = faces.iter().map(|s| s.part).collect();
    let number = |n: NodeId| nodes.local_index(n).expect("an element's nodes are in the mesh");
    let solids: Vec<(ElementRecord, [u32; MAX_CORNERS])> = elements
        .iter()
        .filter(|e| e.shape.is_solid() && with_faces.contains(&e.part))
        .map(|e| (*e, e.nodes.map(number)))
        .collect();
    // The point of a slave that is compared with a solid of a part is on the middle surface.
    let middle = |p: u32, part: u32| {
        let interface = surface.interface_with(p as usize, part)?;
        let shift = surface.shift_of_slave(interface, p as usize, &nodes.x);
        Some(V3::from(xyz(&nodes.x[surface.slaves[p as usize] as usize])) + shift)
    };
    let place = |&n: &u32| xyz(&nodes.x[n as usize]);
    let grown = |corners: &[u32; MAX_CORNERS]| {
        Aabb::around(corners.iter().map(place)).grown(surface.shift_reach())
    };
    let boxes: Vec<Aabb> = solids.iter().map(|(_, corners)| grown(corners)).collect();
    let inside = |e: u32, p: u32| {
        let ((solid, corners), slave) = (&solids[e as usize], surface.slaves[p as usize]);
        !corners.contains(&slave)
            && !is_tied(slave, corners)
            && middle(p, solid.part).is_some_and(|at| {
                is_inside(&at, solid.shape, &corners.map(|n| V3::from(place(&n))))
            })
    };
    let mut slaves: Vec<u32> = Vec::new();
    linked_cells(&boxes, &points(nodes, surface), &mut |e, p| {
        slaves.extend(inside(e, p).then_some(p))
    });
    slaves.sort_unstable();
    slaves.dedup();
    let depth_in = |s: &Segment, p: u32| {
        let slave = surface.slaves[p as usize];
        let at = middle(p, s.part)?;
        let near = nearest(&at, &s.corners(&nodes.x), s.is_triangle())?;
        let (offset, scale) = (at - near.point, s.scale + surface.node_scale[slave as usize]);
        let depth = -offset.dot(&near.normal);
        let behind =
            depth > -ROUND_OFF * scale && (offset + near.normal * depth).norm() <= OUTSIDE * scale;
        let other = !s.nodes.contains(&slave) && !s.behind.contains(&slave);
        (behind && other && is_opposed(nodes, surface, p as usize, &near.normal)).then_some((
            depth,
            scale,
            near.normal,
        ))
    };
    let mut found: Vec<Penetration> = Vec::new();
    for (p, (face, depth, scale, normal)) in nearest_faces(&faces, slaves, nodes, surface, depth_in)
    {
        if depth > ROUND_OFF * scale {
            let (node, elem) =
                (nodes.id[surface.slaves[p as usize] as usize], faces[face as usize].id.elem());
            found.push(Penetration {
                node,
                elem,
                depth,
                normal: normal.into(),
                at_least: false,
                unseen: depth > BEHIND * scale,
            });
        }
    }
    found
}

/// Returns for each slave the face with its smallest depth, this depth, the scale and the normal of
/// the face. The search reach grows until no face outside it can be nearer.
fn nearest_faces(
    faces: &[&Segment],
    mut slaves: Vec<u32>,
    nodes: &Nodes,
    surface: &Surface,
    depth_in: impl Fn(&Segment, u32) -> Option<(f64, f64, V3)>,
) -> Vec<(u32, (u32, f64, f64, V3))> {
    let all: Vec<Aabb> = faces.iter().map(|s| s.bounds(&nodes.x, 0.0)).collect();
    let place = |p: u32| xyz(&nodes.x[surface.slaves[p as usize] as usize]);
    let whole = Aabb::around(
        all.iter().flat_map(|b| [b.min, b.max]).chain(slaves.iter().map(|&p| place(p))),
    );
    let largest = (0..3).map(|c| whole.max[c] - whole.min[c]).fold(0.0, f64::max);
    let added = surface.shift_reach();
    let mut reach = surface.largest_scale() + added;
    let mut found = Vec::new();
    while !slaves.is_empty() {
        let boxes: Vec<Aabb> = all.iter().map(|b| b.grown(reach)).collect();
        let points: Vec<[f64; 3]> = slaves.iter().map(|&p| place(p)).collect();
        let mut least: Vec<Option<(u32, f64, f64, V3)>> = vec![None; slaves.len()];
        linked_cells(&boxes, &points, &mut |f, i| {
            let Some((depth, scale, normal)) = depth_in(faces[f as usize], slaves[i as usize])
            else {
                return;
            };
            let best = &mut least[i as usize];
            let nearer = |&(g, least, ..): &(u32, f64, f64, V3)| {
                depth.total_cmp(&least).then(f.cmp(&g)).is_lt()
            };
            if best.as_ref().is_none_or(nearer) {
                *best = Some((f, depth, scale, normal));
            }
        });
        // A slave that is deeper than the reach may be less deep in a face outside the reach.
        let last = reach > 2.0 * largest;
        let mut left = Vec::new();
        for (p, best) in slaves.into_iter().zip(least) {
            match best.filter(|best| last || best.1 + added <= reach) {
                Some(best) => found.push((p, best)),
                None if !last => left.push(p),
                None => {}
            }
        }
        (slaves, reach) = (left, 4.0 * reach);
    }
    found
}

fn points(nodes: &Nodes, surface: &Surface) -> Vec<[f64; 3]> {
    surface.slaves.iter().map(|&i| xyz(&nodes.x[i as usize])).collect()
}

/// Returns true if a point is in a solid, up to round-off. The test uses the planes through the
/// middles of its faces.
fn is_inside(at: &V3, shape: Shape, corners: &[V3; MAX_CORNERS]) -> bool {
    shape.faces().iter().all(|f| {
        let [a, b, c, d] = f.map(|i| corners[i]);
        let outward = (c - a).cross(&(d - b));
        (at - (a + b + c + d) * 0.25).dot(&outward) <= ROUND_OFF * outward.norm() * (c - a).norm()
    })
}

fn thinned(
    settings: &Settings,
    elements: &[ElementRecord],
    surface: &Surface,
) -> Option<(usize, f64)> {
    let parts = ContactParts::from_settings(settings);
    let given: HashMap<ElemId, f64> = elements
        .iter()
        .filter_map(|e| Some((e.id, parts.half_thickness(e.part, e.own.thickness)?)))
        .collect();
    let shells = surface.segments.iter().filter(|s| !s.is_solid());
    let shares = shells
        .map(|s| s.half_thickness / given.get(&s.id.elem()).copied().unwrap_or(s.half_thickness))
        .filter(|&share| share < 1.0);
    shares.fold(None, |sum, share| {
        Some(sum.map_or((1, share), |(count, least): (usize, f64)| (count + 1, least.min(share))))
    })
}

/// Builds the surface of a whole mesh, with its nodes.
fn whole_surface(
    settings: &Settings,
    elements: &[ElementRecord],
    nodes: &[NodeRecord],
) -> (Nodes, Surface) {
    let nodes = Nodes::new(nodes, 0, false);
    let local = |e: &ElementRecord| {
        let numbers =
            e.nodes.map(|n| nodes.local_index(n).expect("an element's nodes are in the mesh"));
        LocalElement { record: *e, nodes: numbers, shared: false, class: Class::Interior }
    };
    let elements: Vec<LocalElement> = elements.iter().map(local).collect();
    let surface = Surface::new(elements.iter(), &nodes, &ContactParts::from_settings(settings));
    (nodes, surface)
}
