//! Position of a slave relative to a segment in the local search: the direction of the contact
//! force and the distance along it.

use crate::geometry::{Nearest, nearest};
use crate::impact::{NodePath, first_touch};
use crate::pair_geometry::PairGeometry;
use crate::reach::{BEHIND, OUTSIDE};
use crumple_fem::nodes::Nodes;
use crumple_math::row::{V3, xyz};

/// Position of a node relative to a segment: the direction of the contact force and the distance
/// along it.
#[derive(Clone, Copy)]
pub struct ContactFrame {
    /// Unit vector along which the contact force acts on the node.
    pub normal: V3,
    /// Side of the node along the segment's own normal, +1 or -1.
    pub side: f64,
    /// Distance of the node from the segment along `normal`, between their middle surfaces
    /// [length].
    pub reached: f64,
}

/// Returns the contact frame of a shell segment. `apart` is the vector from its middle surface to
/// the node. Around the rim the normal turns with the node, so that nothing jumps when the node
/// passes to the next segment or slides off. Deep inside, the side in the history of this segment
/// decides; without it, the side from the history of a neighbour.
pub fn shell_frame(
    geometry: &PairGeometry<'_>,
    apart: &V3,
    known: Option<f64>,
    neighbour_side: impl Fn() -> Option<f64>,
) -> ContactFrame {
    let near = geometry.near;
    let (distance, height) = (apart.norm(), apart.dot(&near.normal));
    let between = height + geometry.shift_along(&near.normal);
    let here = if between < 0.0 { -1.0 } else { 1.0 };
    let side = if near.rim { here } else { known.or_else(neighbour_side).unwrap_or(here) };
    // A node next to the rim is not deep, whatever its own shift is.
    let is_through = !near.rim && height * side < 0.0;
    if is_through || distance < 0.05 * geometry.thickness {
        return ContactFrame { normal: near.normal * side, side, reached: between * side };
    }
    let normal = apart / distance;
    ContactFrame { normal, side, reached: distance + geometry.shift_along(&normal) }
}

/// Returns the contact frame of a line. The normal turns with the node all around the line. A
/// node that has passed through the line stays on the side of the normal in its history.
pub fn line_frame(geometry: &PairGeometry<'_>, offset: &V3, known: Option<V3>) -> ContactFrame {
    let near = geometry.near;
    let side = if known.is_some_and(|n| n.dot(&near.normal) < 0.0) { -1.0 } else { 1.0 };
    let between = offset.dot(&near.normal) + geometry.shift_along(&near.normal);
    ContactFrame { normal: near.normal * side, side, reached: between * side }
}

/// Returns the contact frame of a solid's face; the contact acts along the face's normal.
/// Returns `None` if the node does not touch this face: it belongs to the same element, it is
/// deeper inside than a new contact can be, or it is not over the face at the end of the step.
pub fn solid_frame(nodes: &Nodes, geometry: &PairGeometry<'_>, old: bool) -> Option<ContactFrame> {
    let PairGeometry { segment, slave, scale, dt, near, .. } = geometry;
    let at = V3::from(xyz(&nodes.x[*slave as usize]));
    let height = (at - near.point).dot(&near.normal) + geometry.shift_along(&near.normal);
    if segment.behind.contains(slave) || !old && height < -BEHIND * scale {
        return None;
    }
    let later = |n: u32| {
        V3::from(xyz(&nodes.x[n as usize])) + V3::from(xyz(&nodes.v_next[n as usize])) * *dt
    };
    let then = later(*slave);
    let met = nearest(&then, &segment.nodes.map(later), segment.is_triangle())?;
    let offset = then - met.point;
    let outside = (offset - met.normal * offset.dot(&met.normal)).norm();
    (!met.rim || outside <= OUTSIDE * scale).then_some(ContactFrame {
        normal: near.normal,
        side: 1.0,
        reached: height,
    })
}

/// Returns the first touch of a node and the moving segment in the step: the point of the segment,
/// where it is at the start of the step, and the contact frame with the normal of the touch. The
/// gap of this frame closes at the time of the touch. `side` is the side of the node along the
/// segment's normal, +1 or -1. Returns `None` if they do not touch, or only on a rim.
pub fn touch_frame(
    nodes: &Nodes,
    geometry: &PairGeometry<'_>,
    side: f64,
) -> Option<(Nearest, ContactFrame)> {
    let PairGeometry { segment, slave, dt, near, .. } = *geometry;
    let path = |n: u32| NodePath {
        from: V3::from(xyz(&nodes.x[n as usize])),
        by: V3::from(xyz(&nodes.v_next[n as usize])) * dt,
    };
    let (node, corners) = (path(slave), segment.nodes.map(path));
    let distance = |n: &V3| geometry.thickness + geometry.offset * side - geometry.shift_along(n);
    let segment = (&corners, segment.is_triangle());
    let impact = first_touch(&node, segment, near.normal * side, distance)?;
    let (shape, normal) = (impact.shape, impact.normal);
    let blend =
        |of: fn(&NodePath) -> V3| corners.iter().zip(shape).map(|(c, n)| of(c) * n).sum::<V3>();
    let point = blend(|c| c.from);
    let approaches = (node.by - blend(|c| c.by)).dot(&normal) < 0.0;
    let height = (node.from - point).dot(&normal) - geometry.offset * side;
    let reached = height + geometry.shift_along(&normal);
    let near = Nearest { shape, point, normal: normal * side, rim: false };
    approaches.then_some((near, ContactFrame { normal, side, reached }))
}

/// Returns the position of a node relative to a solid's face along the normal of the face from
/// which the node came over a convex edge: the point of the face in that direction, and the
/// distance to it; Attaway et al. (1998), fig. 4. `None` if that normal lies in the face.
pub fn last_face_frame(
    nodes: &Nodes,
    geometry: &PairGeometry<'_>,
    last: V3,
) -> Option<(Nearest, ContactFrame)> {
    let PairGeometry { segment, slave, near, .. } = *geometry;
    let at = V3::from(xyz(&nodes.x[slave as usize]));
    let along = last.dot(&near.normal);
    if along <= 0.0 {
        return None;
    }
    let reached = (at - near.point).dot(&near.normal) / along;
    let near = nearest(&(at - last * reached), &segment.corners(&nodes.x), segment.is_triangle())?;
    let reached = reached + geometry.shift_along(&last);
    Some((near, ContactFrame { normal: last, side: 1.0, reached }))
}
