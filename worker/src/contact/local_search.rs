//! Local search of nodes: decides which candidates of a node are contact pairs in this step. The
//! local search of edges is in `edges.rs`.
//!
//! The decision uses positions, velocities without contact and the pair history of the node. It
//! uses nothing else. In particular it does not depend on when or by which worker the candidates
//! were collected.
//!
//! A shell segment is touched from both sides at half its thickness, and around its rim. The
//! line of a beam is touched all around. A solid segment is touched from outside. A new contact
//! on a solid is a node that is now in front of the segment (or only just behind it) and is
//! behind the inside of the moving segment at the end of the step (velocity check of PRONTO3D).
//! An old contact lasts as long as the node is over the segment. A new contact also needs
//! opposed surfaces. Example: a block slides over another block; its side faces must not touch
//! the nodes on the top of the other block, although these pass at the lower rims of the side
//! faces.

use crate::contact::geometry::{Nearest, nearest};
use crate::contact::pairs::{Pair, PairHistory, PairKey, padded};
use crate::contact::projections::ProjectedPair;
use crate::contact::shell_offset;
use crate::contact::surface::{Segment, Surface};
use crate::math::row::{Row, V3};
use crate::nodes::Nodes;

/// Largest distance of a candidate that is examined, as a multiple of the contact thickness (of
/// the scale where solids take part). The global search must reach as far; its reach is computed
/// from this number.
pub const REACH: f64 = 1.5;
/// Predicted gap below which a pair is active, as a fraction of the contact thickness.
pub(super) const ACTIVE: f64 = 0.02;
/// Limit for a surface that is folded over itself: distance from the fold over the height above
/// the surface. Above this limit the angle of the fold is below about 60 degrees.
const FOLDED: f64 = 0.5;
/// Distance in front of the tangent plane of an accepted pair, as a fraction of the thickness.
/// Neighbouring segments whose nearest point is below it add nothing to that pair.
const PLANE: f64 = 0.02;
/// Distance behind a solid's face up to which a node without history counts as a new contact, as
/// a fraction of the scale. Such a node may have passed between two faces in the step before.
pub(super) const BEHIND: f64 = 0.2;
/// Distance outside the border of a solid's face up to which a node still touches it, as a
/// fraction of the scale.
pub(super) const OUTSIDE: f64 = 0.02;
/// Two surfaces are opposed where the product of their unit normals is below this value. At the
/// corner of a block that lies flat on a face the product is -1/sqrt(3) with the mean of the
/// corner's three normals. It is 0 for a top face and a side face.
const OPPOSED: f64 = -0.3;
/// Largest number of pairs of one node: a corner of three faces and one more.
const MOST: usize = 4;
/// Speed at which a tolerated penetration is given back to the gap, as a fraction of the wave
/// speed of the parts in contact. In steel it is 0.01 m/s. Parts that start inside each other
/// separate at this speed, whatever the step, the depth and the mesh. It must be far below
/// `CORRECT` in `enforce/mod.rs`.
const RELAX: f64 = 2e-6;

/// Returns the distance beyond which a slave and a segment without common history are no pair in
/// a step [length]. In that step they move by `step` against each other [length]. No gap closes
/// from farther away, and no new contact is as far behind a solid's face.
pub fn reach(surface: &Surface, slave: u32, segment: &Segment, step: f64) -> f64 {
    /// Factor for solids: contact with a face is judged where the face is at the end of the
    /// step, warped and turned.
    const TURNED: f64 = 1.25;
    let most = |sum| surface.interfaces.most(sum);
    let scale = most(surface.node_scale[slave as usize] + segment.scale);
    let added = surface.shift_reach();
    let before =
        most(surface.node_half[slave as usize] + segment.half_thickness) + ACTIVE * scale + step;
    let near = match segment.is_solid() {
        true => TURNED * (before.max(BEHIND * scale) + OUTSIDE * scale + step + added),
        false => before + added,
    };
    near.min(REACH * scale + added)
}

/// Returns the distance as in [`reach`] for a segment that has history with the slave [length].
pub fn reach_of_old(surface: &Surface, slave: u32, segment: &Segment) -> f64 {
    REACH * surface.interfaces.most(surface.node_scale[slave as usize] + segment.scale)
        + surface.shift_reach()
}

/// Returns true if a segment is not new to a slave with these pair histories. Faces of solids
/// take over the history of neighbouring faces.
pub fn has_history(segment: &Segment, memory: &[PairHistory]) -> bool {
    if segment.is_solid() { !memory.is_empty() } else { memory.iter().any(|m| m.is_of(segment.id)) }
}

/// Contact pair as evaluated by the local search, before selection.
struct PairCandidate {
    pair: Pair,
    /// Time within the step at which the gap closes, as a fraction of the step; 0 for existing
    /// contact.
    impact: f64,
    /// Normal velocity of the node relative to the segment without contact [length/time];
    /// negative when the gap closes.
    opening: f64,
    /// Vector to the node from the segment, from its middle surface if it is shifted [length].
    apart: V3,
    /// See [`PairGeometry::thickness`].
    thickness: f64,
    is_line: bool,
    /// Gap between the surfaces; the tolerated gap is not subtracted [length].
    gap: f64,
}

fn v3(r: &Row) -> V3 {
    V3::new(r[0], r[1], r[2])
}

/// Appends the active pairs of one slave to `out`, in ascending segment id. `place` is the index
/// of the slave among the surface's slaves. `meetings` are its projected pairs, segments
/// ascending. `memory` is the pair history of the node from the last step. `alive` states for
/// each interface if it is active.
pub fn find_pairs(
    nodes: &Nodes,
    (surface, alive): (&Surface, &[bool]),
    place: usize,
    meetings: &[ProjectedPair],
    memory: &[PairHistory],
    dt: f64,
    out: &mut Vec<Pair>,
) {
    let opposed = |normal: &V3| is_opposed(nodes, surface, place, normal);
    let found = |m: &ProjectedPair| {
        let visit = PairGeometry::new((nodes, surface), place, m, dt)
            .filter(|v| alive[v.interface as usize])?;
        evaluate_pair(nodes, surface, &visit, memory, opposed)
    };
    let mut finds: Vec<PairCandidate> = meetings.iter().filter_map(found).collect();
    // Existing contact first, the nearest pair first. Then by time of impact, the fastest
    // approach first. Ids break ties.
    finds.sort_by(|a, b| {
        let by_time = a.impact.total_cmp(&b.impact);
        let by_gap =
            if a.impact == 0.0 { a.gap.total_cmp(&b.gap) } else { a.opening.total_cmp(&b.opening) };
        by_time.then(by_gap).then(a.pair.segment.cmp(&b.pair.segment))
    });
    let mut accepted = 0;
    for i in 0..finds.len() {
        // If the neighbourhood is flat or convex, the accepted tangent plane already keeps the
        // node away from this segment. If it is concave, it does not.
        let f = &finds[i];
        let covered = |a: &PairCandidate| {
            // A beam may project out of the shell on which it lies.
            let stands_out = if f.is_line || a.is_line { f.thickness - a.thickness } else { 0.0 };
            f.apart.dot(&a.pair.normal)
                >= a.apart.dot(&a.pair.normal) + stands_out - PLANE * f.pair.contact_thickness
        };
        if accepted < MOST && !finds[..accepted].iter().any(covered) {
            finds.swap(accepted, i);
            accepted += 1;
        }
    }
    finds.truncate(accepted);
    finds.sort_unstable_by_key(|f| f.pair.segment);
    out.extend(finds.into_iter().map(|f| f.pair));
}

/// A projected pair with the data of its node and segment.
struct PairGeometry<'a> {
    segment: &'a Segment,
    slave: u32,
    /// Index of the slave among the surface's slaves.
    place: usize,
    /// Nodes of the segment in the mask of `CandidatePair::shared_node_mask`.
    ring: u8,
    interface: u16,
    /// Distance of the contact surfaces from the mesh, the sum of both half thicknesses
    /// [length].
    thickness: f64,
    /// Contact thickness [length].
    scale: f64,
    /// See [`Pair::speed`].
    speed: f64,
    /// True if the node's surface comes before the segment's.
    first: bool,
    dt: f64,
    /// See [`ProjectedPair::step`].
    step: f64,
    near: &'a Nearest,
    /// Distance of the segment's middle surface from its nodes along its normal [length].
    offset: f64,
    /// Vector from the node to the middle surface of its own shells [length].
    shift: V3,
}

impl<'a> PairGeometry<'a> {
    /// Returns `None` if the two do not touch.
    fn new(
        (nodes, surface): (&Nodes, &'a Surface),
        place: usize,
        meeting: &'a ProjectedPair,
        dt: f64,
    ) -> Option<Self> {
        let ProjectedPair { of, step, near } = meeting;
        let (slave, segment) = (surface.slaves[place], &surface.segments[of.segment as usize]);
        let interface = surface.interface(place, segment)?;
        let (thickness, scale) = surface.sizes(interface, slave, segment);
        let around = surface.precedes(place);
        let (first, speed) =
            (around < (segment.part, segment.id), surface.slower(around.0, segment.part));
        Some(Self {
            segment,
            slave,
            place,
            ring: of.shared_node_mask,
            interface,
            thickness,
            scale,
            speed,
            first,
            dt,
            step: *step,
            near,
            offset: surface.offset_of(interface, segment),
            shift: surface.shift_of_slave(interface, place, &nodes.x),
        })
    }

    /// Returns the vector from the middle surface of the segment to a point, from the vector from
    /// its nearest point [length].
    fn relative_to_middle(&self, offset: &V3) -> V3 {
        if self.offset == 0.0 { *offset } else { offset - self.near.normal * self.offset }
    }

    /// Returns the shift of the node along a unit vector [length]. A node without shift has -0.0,
    /// whose sum with any number has the same bits.
    fn shift_along(&self, direction: &V3) -> f64 {
        if self.shift == V3::zeros() { -0.0 } else { self.shift.dot(direction) }
    }
}

/// Returns true if the surface around a slave faces against `normal`, with one of its faces or
/// with their mean. Nodes of shells only face in all directions.
pub(super) fn is_opposed(nodes: &Nodes, surface: &Surface, place: usize, normal: &V3) -> bool {
    let (mut mean, mut faces) = (V3::zeros(), 0);
    for face in surface.around(place).filter(|s| s.is_solid()) {
        let Some(outward) = face.middle_normal(&nodes.x) else { continue };
        if outward.dot(normal) < OPPOSED {
            return true;
        }
        mean += outward;
        faces += 1;
    }
    faces == 0 || mean.dot(normal) < OPPOSED * mean.norm()
}

/// Position of a node relative to a segment: the direction of the contact force and the distance
/// along it.
struct ContactFrame {
    normal: V3,
    /// Side of the node along the segment's own normal, +1 or -1.
    side: f64,
    /// Distance of the node from the segment along `normal`, between their middle surfaces
    /// [length].
    reached: f64,
}

/// Returns the contact frame of a shell segment. `apart` is the vector from its middle surface to
/// the node. Around the rim the normal turns with the node,
/// so that nothing jumps when the node passes to the next segment or slides off. Deep inside,
/// the side in the history of this segment decides; without it, the side from the history of a
/// neighbour.
fn shell_frame(
    visit: &PairGeometry<'_>,
    apart: &V3,
    known: Option<f64>,
    neighbour_side: impl Fn() -> Option<f64>,
) -> ContactFrame {
    let near = visit.near;
    let (distance, height) = (apart.norm(), apart.dot(&near.normal));
    let between = height + visit.shift_along(&near.normal);
    let here = if between < 0.0 { -1.0 } else { 1.0 };
    let side = if near.rim { here } else { known.or_else(neighbour_side).unwrap_or(here) };
    // A node next to the rim is not deep, whatever its own shift is.
    let is_through = !near.rim && height * side < 0.0;
    if is_through || distance < 0.05 * visit.thickness {
        return ContactFrame { normal: near.normal * side, side, reached: between * side };
    }
    let normal = apart / distance;
    ContactFrame { normal, side, reached: distance + visit.shift_along(&normal) }
}

/// Returns the contact frame of a line. The normal turns with the node all around the line. A
/// node that has passed through the line stays on the side of the normal in its history.
fn line_frame(visit: &PairGeometry<'_>, offset: &V3, known: Option<V3>) -> ContactFrame {
    let near = visit.near;
    let side = if known.is_some_and(|n| n.dot(&near.normal) < 0.0) { -1.0 } else { 1.0 };
    let between = offset.dot(&near.normal) + visit.shift_along(&near.normal);
    ContactFrame { normal: near.normal * side, side, reached: between * side }
}

/// Returns the contact frame of a solid's face; the contact acts along the face's normal.
/// Returns `None` if the node does not touch this face: it belongs to the same element, it is
/// deeper inside than a new contact can be, or it is not over the face at the end of the step.
fn solid_frame(
    nodes: &Nodes,
    visit: &PairGeometry<'_>,
    at: &V3,
    old: bool,
) -> Option<ContactFrame> {
    let PairGeometry { segment, slave, scale, dt, near, .. } = visit;
    let height = (at - near.point).dot(&near.normal) + visit.shift_along(&near.normal);
    if segment.behind.contains(slave) || !old && height < -BEHIND * scale {
        return None;
    }
    let later = |n: u32| v3(&nodes.x[n as usize]) + v3(&nodes.v_next[n as usize]) * *dt;
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

/// Returns true if the surface has folded over between a slave and a neighbouring shell, so that
/// the slave is above the shell's inside. The rim of that shell is shared with the slave's own
/// segments or with the next ones. Contact with the rim would make a mesh that is finer than its
/// thickness touch itself in its plane and at every corner.
fn has_folded_over(nodes: &Nodes, visit: &PairGeometry<'_>, offset: &V3) -> bool {
    let in_ring = |k: &usize| visit.ring >> k & 1 == 1;
    let near = visit.near;
    let corners = if visit.segment.is_triangle() { 3 } else { 4 };
    let (ring, others) = ((0..corners).filter(in_ring), (0..corners).filter(|k| !in_ring(k)));
    if near.rim || others.clone().next().is_none() {
        return false;
    }
    let at = |k: usize| v3(&nodes.x[visit.segment.nodes[k] as usize]);
    let of_others = others.clone().map(at).sum::<V3>() / others.clone().count() as f64;
    let of_ring = ring.clone().map(at).sum::<V3>() / ring.count() as f64;
    let inside = others.map(|k| near.shape[k]).sum::<f64>() * (of_others - of_ring).norm();
    inside > FOLDED * offset.norm()
}

/// Returns the tolerated gap, 0 or negative [length].
///
/// A penetration that does not come from an impact (around a rim) stays without force and is
/// given back slowly. A penetration that was there at the start is not given back at all
/// ([`Pair::initial_gap`]), because this would drive apart bodies at rest. An increase of the
/// penetration by more than `moved` [length] is tolerated too: either the normal has turned, or
/// the pair continues the history of another segment or edge. A force against this increase
/// would have no cause and would create energy. The step size `dt` and the wave speed `speed` of
/// the parts in contact determine how much is given back.
pub(super) fn tolerated(
    old: Option<&PairHistory>,
    gap: f64,
    moved: f64,
    dt: f64,
    speed: f64,
) -> f64 {
    let Some(old) = old else { return gap.min(0.0) };
    let jump = (gap + old.depth + moved).min(0.0);
    ((old.tolerated + RELAX * speed * dt).min(0.0) + jump).max(gap.min(0.0))
}

/// Returns the largest distance by which nodes of a pair may have approached one of them in a
/// step like the last one [length]. `scale` is the contact thickness of the pair [length].
pub(super) fn moved(
    nodes: &Nodes,
    of: impl Iterator<Item = u32>,
    against: u32,
    dt: f64,
    scale: f64,
) -> f64 {
    /// Factor for steps that become shorter.
    const SHORTER: f64 = 2.0;
    /// Fraction of the scale that is no jump. It covers round-off where nothing moves.
    const LITTLE: f64 = 1e-3;
    let v = |n: u32| v3(&nodes.v[n as usize]);
    SHORTER * dt * of.map(|n| (v(n) - v(against)).norm_squared()).fold(0.0, f64::max).sqrt()
        + LITTLE * scale
}

/// Returns the lever arms of friction on the slave and on the segment, in proportion to each
/// other [length]; zero without friction.
///
/// The contact surfaces are half a thickness away from the middle surfaces. A couple about the
/// normal of a shell meets almost no stiffness. Therefore, where friction acts on the rim of one
/// shell, the other side takes the couple: each half thickness is weighted with the square of
/// the cosine between the pair's normal and the shell's normal.
fn levers(nodes: &Nodes, surface: &Surface, visit: &PairGeometry<'_>, normal: &V3) -> [f64; 2] {
    /// Limit of the weighted half thicknesses, as a fraction of their sum, at which both
    /// surfaces touch at their rims.
    const RIM: f64 = 1e-6;
    let PairGeometry { segment, slave, interface, near, .. } = *visit;
    if !surface.interfaces.has_friction(interface) {
        return [0.0; 2];
    }
    let halves = surface.halves(interface, slave, segment);
    let shifted = visit.offset != 0.0 || visit.shift != V3::zeros();
    let facing = |s: &Segment| {
        let own = || s.middle_normal(&nodes.x).map_or(0.0, |n| n.dot(normal).powi(2));
        if s.is_line() { 1.0 } else { own() }
    };
    let shells = surface.around(visit.place).filter(|s| !s.is_solid());
    let ahead = shells.map(facing).reduce(f64::max).unwrap_or(1.0);
    let behind = if segment.is_line() { 1.0 } else { near.normal.dot(normal).powi(2) };
    if shifted {
        let towards = [-visit.shift_along(normal), visit.offset * near.normal.dot(normal)];
        let apart = (v3(&nodes.x[slave as usize]) - near.point).dot(normal);
        let weighted = [halves[0] * ahead, halves[1] * behind];
        return shell_offset::lever_arms(weighted, towards, apart, [ahead, behind]);
    }
    if halves[0] * ahead + halves[1] * behind <= RIM * (halves[0] + halves[1]) {
        return halves;
    }
    [halves[0] * ahead, halves[1] * behind]
}

fn evaluate_pair(
    nodes: &Nodes,
    surface: &Surface,
    visit: &PairGeometry<'_>,
    memory: &[PairHistory],
    opposed: impl Fn(&V3) -> bool,
) -> Option<PairCandidate> {
    let PairGeometry { segment, slave, thickness, scale, speed, dt, step, near, .. } = *visit;
    let at = v3(&nodes.x[slave as usize]);
    let offset = at - near.point;
    let apart = visit.relative_to_middle(&offset);
    if apart.norm() > REACH * scale + visit.shift.norm() {
        return None;
    }
    if visit.ring != 0 && !has_folded_over(nodes, visit, &offset) {
        return None;
    }
    let moved = || moved(nodes, segment.nodes.into_iter(), slave, dt, scale);
    let is_fresh = |m: &&PairHistory| m.age == 0 || m.is_fresh(moved(), scale);
    let known = memory.iter().find(|m| m.is_of(segment.id)).filter(is_fresh);
    // A node that slid over an edge keeps the history from the neighbouring segment. A segment
    // of another body that faces the same way gives no history.
    let slid_here = |m: &&PairHistory, normal: &V3| {
        m.normal.dot(normal) > 0.7 && surface.is_adjacent(m.segment(), segment)
    };
    // History of the last step comes before lost history, whichever segment it belongs to.
    let kept = |normal: &V3| {
        let present = known.filter(|m| m.age == 0);
        let slid = |lost: bool| {
            memory.iter().filter(is_fresh).find(|m| (m.age > 0) == lost && slid_here(m, normal))
        };
        present.or_else(|| slid(false)).or(known).or_else(|| slid(true))
    };
    let ContactFrame { normal, side, reached } = if segment.is_solid() {
        let is_new = kept(&near.normal).is_none();
        // The near list reaches no farther; the result must not depend on it, however the face
        // is warped and turned.
        if is_new && offset.norm() > reach(surface, slave, segment, step) {
            return None;
        }
        solid_frame(nodes, visit, &at, !is_new).filter(|_| !is_new || opposed(&near.normal))?
    } else {
        // A node past the middle surface of one segment is not on the other side of the next
        // segment.
        let past = |m: &&PairHistory| {
            m.depth > m.thickness && is_fresh(m) && surface.is_adjacent(m.segment(), segment)
        };
        if surface.has_lines && segment.is_line() {
            line_frame(visit, &offset, known.or_else(|| memory.iter().find(past)).map(|m| m.normal))
        } else {
            let turned = |m: &PairHistory| {
                Some(m.normal.dot(&near.normal)).filter(|d| d.abs() > 0.7).map(f64::signum)
            };
            let on_side = || memory.iter().filter(past).find_map(turned);
            shell_frame(visit, &apart, known.map(|m| m.side), on_side)
        }
    };
    let gap = reached - thickness;
    let velocity = |n: u32| v3(&nodes.v_next[n as usize]);
    let point_velocity: V3 =
        segment.nodes.iter().zip(near.shape).map(|(&n, s)| velocity(n) * s).sum();
    let opening = (velocity(slave) - point_velocity).dot(&normal);
    let predicted = gap + dt * opening;
    // The tolerated gap is at most 0: without it the pair is at its nearest.
    if predicted >= ACTIVE * scale {
        return None;
    }
    let old = kept(&normal);
    let tolerated = tolerated(old, gap, moved(), dt, speed);
    if predicted - tolerated >= ACTIVE * scale {
        return None;
    }
    let impact = if old.is_some() || gap <= 0.0 {
        0.0
    } else {
        (gap / (gap - predicted).max(f64::MIN_POSITIVE)).min(1.0)
    };
    let [a, b, c, d] = near.shape;
    let shape = padded([1.0, a, b, c, d]);
    let [i, j, k, l] = segment.nodes;
    let pair = Pair {
        shape,
        weight: shape,
        normal,
        lever_arms: levers(nodes, surface, visit, &normal),
        side,
        interface: visit.interface,
        contact_thickness: scale,
        speed,
        slave_surface_first: visit.first,
        is_owned: true,
        ..Pair::new(
            PairKey::of_node(nodes.id[slave as usize], segment.id),
            segment.id,
            [slave, i, j, k, l],
        )
    };
    let is_line = surface.has_lines && segment.is_line();
    Some(PairCandidate {
        pair: pair.with_history(old, gap, tolerated),
        impact,
        opening,
        apart,
        thickness,
        is_line,
        gap,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::candidates::CandidatePair;
    use crate::contact::geometry::Sphere;
    use crate::contact::near_list::CandidateFilter;
    use crate::contact::surface::NOT_LOCAL;
    use crate::testing::nodes_at;
    use crumple_proto::ids::{NodeId, SegmentId};
    use proptest::prelude::*;

    #[test]
    fn a_depth_without_motion_is_tolerated() {
        let pair = Pair::new(PairKey::of_node(NodeId(1), SegmentId(2)), SegmentId(2), [0; 5]);
        let memory = pair.with_history(None, -0.25, 0.0).to_history();
        let tolerated =
            |old: Option<&PairHistory>, gap, moved| tolerated(old, gap, moved, 1e-3, 2.0);
        assert_eq!(tolerated(None, -0.5, 0.125), -0.5, "a pair with initial penetration");
        assert_eq!(tolerated(Some(&memory), -0.375, 0.125), 0.0, "released by the distance moved");
        assert_eq!(tolerated(Some(&memory), -0.5, 0.125), -0.125, "released by no more than that");
        assert_eq!(tolerated(Some(&memory), 0.5, 0.125), 0.0, "open");
    }

    #[test]
    fn tolerated_gaps_are_reduced_at_a_speed_whatever_the_step() {
        let pair = Pair::new(PairKey::of_node(NodeId(1), SegmentId(2)), SegmentId(2), [0; 5]);
        let (speed, depth) = (2.0, 0.25);
        let mut memory = pair.with_history(None, -depth, -depth).to_history();
        for dt in [1e-3, 1e-5] {
            let before = memory.tolerated;
            for _ in 0..1000 {
                memory.tolerated = tolerated(Some(&memory), -depth, 0.0, dt, speed);
            }
            // Round-off of a thousand sums.
            let back = memory.tolerated - before;
            assert!((back / (1000.0 * dt * RELAX * speed) - 1.0).abs() < 1e-6, "step {dt}: {back}");
        }
        memory.tolerated = -1e-9;
        assert_eq!(
            tolerated(Some(&memory), -depth, 0.0, 1e-3, speed),
            0.0,
            "not more than the tolerated gap"
        );
    }

    /// Returns a square face of a solid with displaced corners, and a slave.
    fn face_and_slave(corners: [[f64; 3]; 4], at: [f64; 3]) -> (Nodes, Surface) {
        const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let corner =
            |k: usize| [SQUARE[k][0] + corners[k][0], SQUARE[k][1] + corners[k][1], corners[k][2]];
        let nodes = nodes_at(&[corner(0), corner(1), corner(2), corner(3), at]);
        let face = Segment {
            id: SegmentId(8),
            nodes: [0, 1, 2, 3],
            behind: [NOT_LOCAL; 4],
            half_thickness: 0.0,
            offset: 0.0,
            scale: SCALE,
            part: 0,
            own: true,
        };
        let mut surface = Surface {
            segments: vec![face],
            slaves: vec![4],
            node_half: vec![0.0; 5],
            node_scale: vec![SCALE; 5],
            thinnest: SCALE,
            short: 1.0,
            ..Surface::default()
        };
        surface.link_faces(5);
        (nodes, surface)
    }

    const SCALE: f64 = 0.25;

    /// Returns the force and the tolerated gap of a node that is 0.05 deep in the second of two
    /// neighbouring shells and has the given pair history.
    fn on_the_second_of_two(memory: &[PairHistory]) -> (f64, f64) {
        const HALF: f64 = 0.1;
        let row = |y: f64| [0.0, 1.0, 2.0].map(|x| [x, y, 0.0]);
        let nodes = nodes_at(&[&row(0.0)[..], &row(1.0)[..], &[[1.3, 0.5, 0.15]]].concat());
        let shell = |(id, nodes): (u64, [u32; 4])| Segment {
            id: SegmentId(id),
            nodes,
            behind: [NOT_LOCAL; 4],
            half_thickness: HALF,
            offset: 0.0,
            scale: HALF,
            part: 0,
            own: true,
        };
        let mut surface = Surface {
            segments: [(8, [0, 1, 4, 3]), (16, [1, 2, 5, 4])].map(shell).into(),
            slaves: vec![6],
            node_half: vec![HALF; 7],
            node_scale: vec![HALF; 7],
            speeds: vec![1.0],
            ..Surface::default()
        };
        surface.link_faces(7);
        let at = v3(&nodes.x[6]);
        let near = nearest(&at, &surface.segments[1].corners(&nodes.x), false).unwrap();
        let of = CandidatePair { slave_index: 0, segment: 1, shared_node_mask: 0 };
        let mut found = Vec::new();
        find_pairs(
            &nodes,
            (&surface, &[true]),
            0,
            &[ProjectedPair { of, step: 0.0, near }],
            memory,
            0.0,
            &mut found,
        );
        let [pair] = found[..] else { panic!("expected one pair, found {}", found.len()) };
        assert!((pair.penetration - 0.05).abs() < 1e-15 && pair.normal == V3::z());
        (pair.force.z, pair.tolerated_gap)
    }

    /// History of the last step is used before lost history, even if the lost history belongs to
    /// the segment itself.
    #[test]
    fn memories_of_the_last_step_come_before_lost_ones() {
        let pair = |segment: u64, force: f64, tolerated: f64| {
            let name = PairKey::of_node(NodeId(7), SegmentId(segment));
            let (normal, side) = (V3::z(), 1.0);
            let of = Pair {
                normal,
                side,
                contact_thickness: 0.2,
                ..Pair::new(name, SegmentId(segment), [6, 0, 0, 0, 0])
            };
            Pair { force: V3::z() * force, ..of.with_history(None, -0.05, tolerated) }.to_history()
        };
        let lost =
            |segment: u64, tolerated: f64| pair(segment, 0.0, tolerated).after_loss().unwrap();
        // With a step size of zero nothing is given back.
        assert_eq!(on_the_second_of_two(&[lost(16, -0.04)]), (0.0, -0.04), "its own lost pair");
        assert_eq!(on_the_second_of_two(&[pair(16, 3.0, -0.03)]), (3.0, -0.03), "its own");
        assert_eq!(
            on_the_second_of_two(&[pair(8, 2.0, -0.01)]),
            (2.0, -0.01),
            "from the segment it slid from"
        );
        assert_eq!(
            on_the_second_of_two(&[pair(8, 2.0, -0.01), lost(16, -0.04)]),
            (2.0, -0.01),
            "not its own lost pair"
        );
        assert_eq!(
            on_the_second_of_two(&[pair(8, 2.0, -0.01), pair(16, 3.0, -0.03)]),
            (3.0, -0.03),
            "its own first"
        );
        assert_eq!(
            on_the_second_of_two(&[lost(8, -0.02), lost(16, -0.04)]),
            (0.0, -0.04),
            "of two lost pairs its own"
        );
    }

    #[test]
    fn a_slave_with_a_past_is_given_faces_that_it_may_go_over_to() {
        let (nodes, surface) = face_and_slave([[0.0; 3]; 4], [0.5, 0.5, 0.3]);
        let pair =
            Pair::new(PairKey::of_node(NodeId(5), SegmentId(16)), SegmentId(16), [4, 0, 1, 2, 3]);
        let picked = |memory: &[PairHistory]| {
            let mut near = Vec::new();
            let mut picker = CandidateFilter::new(&nodes, &surface, (0.0, 0.0), |g| {
                Sphere::around(&surface.segments[g].corners(&nodes.x))
            });
            picker.add_slave(0, &[0], memory, &mut near);
            picker.finish(&mut near);
            near.len()
        };
        assert_eq!(picked(&[]), 0, "a new pair, too far for a step without motion");
        assert_eq!(picked(&[pair.to_history()]), 1, "within 1.5 times the scales");
    }

    proptest! {
        /// However a face is warped and moves, a contact within the step lies within the reach
        /// of the search.
        #[test]
        fn nothing_new_is_met_from_beyond_reach(
            corners in prop::array::uniform4(prop::array::uniform3(-0.15..0.15f64)),
            at in prop::array::uniform3(-0.4..1.4f64),
            moves in prop::array::uniform5(prop::array::uniform3(-0.1..0.1f64)),
        ) {
            let (mut nodes, surface) = face_and_slave(corners, at);
            nodes.v_next.iter_mut().zip(moves).for_each(|(v, m)| *v = [m[0], m[1], m[2], 0.0]);
            let segment = &surface.segments[0];
            let v = |n: u32| v3(&nodes.v_next[n as usize]);
            let step = segment.nodes.iter().map(|&n| (v(n) - v(4)).norm()).fold(0.0, f64::max);
            let (at, scale) = (V3::from(at), 2.0 * SCALE);
            let Some(near) = nearest(&at, &segment.corners(&nodes.x), false) else { return Ok(()) };
            let of = CandidatePair { slave_index: 0, segment: 0, shared_node_mask: 0 };
            let meeting = ProjectedPair { of, step, near };
            let visit = PairGeometry::new((&nodes, &surface), 0, &meeting, 1.0).expect("all touch");
            let Some(place) = solid_frame(&nodes, &visit, &at, false) else { return Ok(()) };
            let moving: V3 = segment.nodes.iter().zip(near.shape).map(|(&n, s)| v(n) * s).sum();
            if place.reached + (v(4) - moving).dot(&place.normal) < ACTIVE * scale {
                let (far, reach) = ((at - near.point).norm(), reach(&surface, 4, segment, step));
                prop_assert!(far <= reach, "contact at {far}, reach {reach}");
            }
        }
    }
}
