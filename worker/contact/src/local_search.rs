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

use crate::contact_frame::{
    ContactFrame, last_face_frame, line_frame, shell_frame, solid_frame, touch_frame,
};
use crate::detail::ContactDetail;
use crate::geometry::Nearest;
use crate::pair_geometry::PairGeometry;
use crate::pairs::{Pair, PairHistory};
use crate::projections::ProjectedPair;
use crate::reach::{ACTIVE, REACH, reach};
use crate::smooth_surface::SmoothPatch;
use crate::surface::{Segment, Surface};
use crumple_fem::nodes::Nodes;
use crumple_math::row::{V3, xyz};

/// Distance in front of the tangent plane of an accepted pair, as a fraction of the thickness.
/// Neighbouring segments whose nearest point is below it add nothing to that pair.
const PLANE: f64 = 0.02;
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

/// Fraction of a step below which the times of two impacts are the same where the node's normal
/// decides.
const SAME_TIME: f64 = 1e-6;

/// Contact pair as evaluated by the local search, before selection.
pub struct PairCandidate {
    pair: Pair,
    /// Time within the step at which the gap closes, as a fraction of the step; 0 for existing
    /// contact. A multiple of [`SAME_TIME`] where the node's normal decides.
    impact: f64,
    /// Product of the pair's normal and the node's normal, times a positive number that is common
    /// to all pairs of the node; 0 where the node's normal does not decide, or a node of shells.
    opposition: f64,
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

/// Appends the active pairs of one slave to `out`, in ascending segment id. `finds` is a buffer of
/// the caller. `slave_index` is the
/// index of the slave among the surface's slaves. `projected` are its projected pairs, segments
/// ascending. `memory` is the pair history of the node from the last step. `alive` states for each
/// interface if it is active.
pub fn find_pairs(
    (nodes, detail): (&Nodes, ContactDetail),
    (surface, alive): (&Surface, &[bool]),
    slave_index: usize,
    projected: &[ProjectedPair],
    memory: &[PairHistory],
    dt: f64,
    (finds, out): (&mut Vec<PairCandidate>, &mut Vec<Pair>),
) {
    let found = |pair: &ProjectedPair| {
        let geometry = PairGeometry::new((nodes, surface), slave_index, pair, dt)
            .filter(|geometry| alive[geometry.interface as usize])?;
        evaluate_pair((nodes, detail), surface, &geometry, memory)
    };
    finds.clear();
    finds.extend(projected.iter().filter_map(found));
    // Existing contact first, the nearest pair first. Then by time of impact, the fastest
    // approach first. Ids break ties. If the node's normal decides, it comes before gap and
    // approach.
    finds.sort_by(|a, b| {
        let by_time = a.impact.total_cmp(&b.impact);
        let by_gap =
            if a.impact == 0.0 { a.gap.total_cmp(&b.gap) } else { a.opening.total_cmp(&b.opening) };
        let by_normal = a.opposition.total_cmp(&b.opposition);
        by_time.then(by_normal).then(by_gap).then(a.pair.segment.cmp(&b.pair.segment))
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
    out.extend(finds.iter().map(|f| f.pair));
}

/// Returns true if the surface around a slave faces against `normal`, with one of its faces or
/// with their mean. Nodes of shells only face in all directions.
pub(super) fn is_opposed(
    nodes: &Nodes,
    surface: &Surface,
    slave_index: usize,
    normal: &V3,
) -> bool {
    let (mut mean, mut faces) = (V3::zeros(), 0);
    for face in surface.around(slave_index).filter(|s| s.is_solid()) {
        let Some(outward) = face.middle_normal(&nodes.x) else { continue };
        if outward.dot(normal) < OPPOSED {
            return true;
        }
        mean += outward;
        faces += 1;
    }
    faces == 0 || mean.dot(normal) < OPPOSED * mean.norm()
}

/// Returns the sum of the normals of the solid faces around a slave; zero for nodes of shells.
fn node_normal(nodes: &Nodes, surface: &Surface, slave_index: usize) -> V3 {
    let solids = surface.around(slave_index).filter(|s| s.is_solid());
    solids.filter_map(|s| s.middle_normal(&nodes.x)).sum()
}

/// Returns the tolerated gap, 0 or negative [length].
///
/// A penetration that does not come from an impact (around a rim) stays without force and is
/// given back slowly. A penetration that was there at the start is not given back at all
/// ([`Pair::initial_gap`], [`Pair::keep_if_deep`]), because this would drive apart bodies at rest.
/// An increase of the penetration by more than `moved` [length] is tolerated too: either the normal
/// has turned, or the pair continues the history of another segment or edge. A force against this
/// increase would have no cause and would create energy. The step size `dt` and the wave speed
/// `speed` of the parts in contact determine how much is given back.
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

/// Returns true if a pair of shells or beams tolerates a penetration up to the middle surface, so
/// that only its history has the side on which the slave belongs. Without history, of two
/// nodes in the same place each could be held above the segments of the other, and the two forces
/// would grow without bound. `thickness` is the distance of the middle surfaces at which they touch
/// [length].
pub(super) fn is_in_middle(pair: &Pair, thickness: f64) -> bool {
    /// Tolerated penetration as a fraction of the thickness. It is that at which the normal of a
    /// shell's rim begins to turn with the node ([`shell_frame`]).
    const MIDDLE: f64 = 0.95;
    thickness > 0.0 && -pair.tolerated_gap >= MIDDLE * thickness
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
    let v = |n: u32| V3::from(xyz(&nodes.v[n as usize]));
    SHORTER * dt * of.map(|n| (v(n) - v(against)).norm_squared()).fold(0.0, f64::max).sqrt()
        + LITTLE * scale
}

/// Histories that a pair may continue.
struct PastPairs<'a, M> {
    surface: &'a Surface,
    segment: &'a Segment,
    scale: f64,
    /// All histories of the node.
    all: &'a [PairHistory],
    /// History of the node with this segment.
    own: Option<&'a PairHistory>,
    /// See [`moved`].
    moved: M,
}

impl<'a, M: Fn() -> f64> PastPairs<'a, M> {
    #[inline]
    fn new(
        surface: &'a Surface,
        geometry: &PairGeometry<'a>,
        all: &'a [PairHistory],
        moved: M,
    ) -> Self {
        let PairGeometry { segment, scale, .. } = *geometry;
        let own = None;
        let mut past = Self { surface, segment, scale, all, own, moved };
        past.own = all.iter().find(|m| m.is_of(segment.id)).filter(|m| past.is_fresh(m));
        past
    }

    fn is_fresh(&self, history: &PairHistory) -> bool {
        history.age == 0 || history.is_fresh((self.moved)(), self.scale)
    }

    /// Returns the history that the pair with this normal continues. History of the last step comes
    /// before lost history, whichever segment it belongs to.
    #[inline]
    fn continued(&self, normal: &V3) -> Option<&'a PairHistory> {
        // A node that slid over an edge keeps the history from the neighbouring segment. A segment
        // of another body that faces the same way gives no history.
        let slid_here = |m: &PairHistory| {
            m.normal.dot(normal) > 0.7 && self.surface.is_adjacent(m.segment(), self.segment)
        };
        let slid = |lost: bool| {
            self.all
                .iter()
                .filter(|m| self.is_fresh(m))
                .find(|m| (m.age > 0) == lost && slid_here(m))
        };
        let present = self.own.filter(|m| m.age == 0);
        present.or_else(|| slid(false)).or(self.own).or_else(|| slid(true))
    }

    /// Returns the histories in which the node is past the middle surface of a neighbouring
    /// segment. It is then not on the other side of this one.
    fn past_neighbours(&self) -> impl Iterator<Item = &'a PairHistory> {
        self.all.iter().filter(|m| {
            m.depth > m.thickness
                && self.is_fresh(m)
                && self.surface.is_adjacent(m.segment(), self.segment)
        })
    }

    /// Returns the side of the node along the segment's `normal` by its past with a neighbour.
    fn neighbour_side(&self, normal: &V3) -> Option<f64> {
        let turned =
            |m: &PairHistory| Some(m.normal.dot(normal)).filter(|d| d.abs() > 0.7).map(f64::signum);
        self.past_neighbours().find_map(turned)
    }
}

/// Returns the position of the node relative to the segment; `None` if the two cannot be a pair.
/// `apart` is the vector to the node from the middle surface of the segment, `offset` that from its
/// nearest point [length].
#[inline]
fn contact_frame<M: Fn() -> f64>(
    (nodes, surface): (&Nodes, &Surface),
    geometry: &PairGeometry<'_>,
    past: &PastPairs<'_, M>,
    (apart, offset): (&V3, &V3),
) -> Option<ContactFrame> {
    let PairGeometry { segment, slave, step, near, .. } = *geometry;
    if segment.is_solid() {
        let is_new = past.continued(&near.normal).is_none();
        // The near list reaches no farther; the result must not depend on it, however the face
        // is warped and turned.
        if is_new && offset.norm() > reach(surface, slave, segment, step) {
            return None;
        }
        let opposed = || is_opposed(nodes, surface, geometry.slave_index, &near.normal);
        return solid_frame(nodes, geometry, !is_new).filter(|_| !is_new || opposed());
    }
    if surface.has_lines && segment.is_line() {
        let known = past.own.or_else(|| past.past_neighbours().next());
        return Some(line_frame(geometry, offset, known.map(|m| m.normal)));
    }
    let neighbour_side = || past.neighbour_side(&near.normal);
    Some(shell_frame(geometry, apart, past.own.map(|m| m.side), neighbour_side))
}

/// Returns the point of the segment and the contact frame of a pair where the options of `detail`
/// give others than the nearest point and the frame `near` there: the first touch of a new contact
/// with the moving surface, or the normal of the last face at a convex edge.
fn placed_by_option<M: Fn() -> f64>(
    (nodes, surface): (&Nodes, &Surface),
    detail: ContactDetail,
    geometry: &PairGeometry<'_>,
    past: &PastPairs<'_, M>,
    near: Option<ContactFrame>,
) -> Option<(Nearest, ContactFrame)> {
    let PairGeometry { segment, slave, slave_index, step, .. } = *geometry;
    let is_solid = segment.is_solid();
    if segment.is_line() || segment.behind.contains(&slave) {
        return None;
    }
    let (side, normal) = match near {
        Some(frame) if !is_solid => (frame.side, frame.normal),
        _ => (1.0, geometry.near.normal),
    };
    if let Some(last) = past.continued(&normal) {
        let came_over = detail.along_last_face
            && is_solid
            && near.is_some()
            && last.age == 0
            && last.segment() != segment.id
            && surface.is_convex(last.segment(), segment, &last.normal, &nodes.x);
        return came_over.then(|| last_face_frame(nodes, geometry, last.normal)).flatten();
    }
    let offset = V3::from(xyz(&nodes.x[slave as usize])) - geometry.near.point;
    let height = offset.dot(&normal) - geometry.offset * side + geometry.shift_along(&normal);
    let is_ahead = height > geometry.thickness && offset.norm() - REACH * geometry.scale <= step;
    if !detail.on_moving_surface || !is_ahead {
        return None;
    }
    let opposed = |n: &V3| !is_solid || is_opposed(nodes, surface, slave_index, n);
    touch_frame(nodes, geometry, side).filter(|(_, frame)| opposed(&frame.normal))
}

/// Returns the pair of a node and a segment, if it is active in this step.
fn evaluate_pair(
    (nodes, detail): (&Nodes, ContactDetail),
    surface: &Surface,
    geometry: &PairGeometry<'_>,
    memory: &[PairHistory],
) -> Option<PairCandidate> {
    let PairGeometry { segment, slave, slave_index, thickness, scale, speed, dt, near, .. } =
        *geometry;
    let at = V3::from(xyz(&nodes.x[slave as usize]));
    let offset = at - near.point;
    let apart = geometry.relative_to_middle(&offset);
    if apart.norm() > REACH * scale + geometry.shift.norm() + surface.largest_rise() {
        return None;
    }
    if geometry.shared_node_mask != 0 && !geometry.has_folded_over(nodes, &offset) {
        return None;
    }
    let (smooth, on_smooth);
    let patch = (detail.smooth && !segment.is_line())
        .then(|| SmoothPatch::new(nodes, surface, segment)?.project(&at, near.shape))
        .flatten();
    let (geometry, apart) = match patch {
        None => (geometry, apart),
        Some(on_patch) => {
            smooth = on_patch;
            on_smooth = PairGeometry { near: &smooth, ..*geometry };
            (&on_smooth, on_smooth.relative_to_middle(&(at - smooth.point)))
        }
    };
    let moved = || moved(nodes, segment.nodes.into_iter(), slave, dt, scale);
    let past = PastPairs::new(surface, geometry, memory, moved);
    let frame = contact_frame((nodes, surface), geometry, &past, (&apart, &offset));
    let placed = detail
        .is_set()
        .then(|| placed_by_option((nodes, surface), detail, geometry, &past, frame))
        .flatten();
    let is_placed = placed.is_some();
    let (point, elsewhere);
    let (geometry, apart, ContactFrame { normal, side, reached }) = match placed {
        None => (geometry, apart, frame?),
        Some((near, frame)) => {
            point = near;
            elsewhere = PairGeometry { near: &point, ..*geometry };
            (&elsewhere, elsewhere.relative_to_middle(&(at - point.point)), frame)
        }
    };
    let gap = reached - thickness;
    let velocity = |n: u32| V3::from(xyz(&nodes.v_next[n as usize]));
    let point_velocity: V3 =
        segment.nodes.iter().zip(geometry.near.shape).map(|(&n, s)| velocity(n) * s).sum();
    let opening = (velocity(slave) - point_velocity).dot(&normal);
    let predicted = gap + dt * opening;
    // The tolerated gap is at most 0: without it the pair is at its nearest.
    if predicted >= ACTIVE * scale {
        return None;
    }
    let old = past.continued(&normal);
    // The faces of a solid leave no gap between them: a node that comes in without a touch of this
    // one touches another one.
    if detail.on_moving_surface
        && segment.is_solid()
        && thickness == 0.0
        && !is_placed
        && old.is_none()
        && gap > 0.0
        && predicted < 0.0
    {
        return None;
    }
    let tolerated = tolerated(old, gap, moved(), dt, speed);
    if predicted - tolerated >= ACTIVE * scale {
        return None;
    }
    let impact = if old.is_some() || gap <= 0.0 {
        0.0
    } else {
        (gap / (gap - predicted).max(f64::MIN_POSITIVE)).min(1.0)
    };
    let (impact, opposition) = match detail.by_node_normal {
        true => {
            let facing = node_normal(nodes, surface, geometry.slave_index);
            ((impact / SAME_TIME).round() * SAME_TIME, facing.dot(&normal))
        }
        false => (impact, 0.0),
    };
    let mut pair = geometry.pair(nodes, surface, normal, side).with_history(old, gap, tolerated);
    let of_shells = !segment.is_solid() && surface.around(slave_index).all(|s| !s.is_solid());
    // The history has the side of a node above the inside of a segment, and the normal at a beam.
    let is_side_known = old.is_some() && (segment.is_line() || !geometry.near.rim);
    if of_shells && !is_side_known && is_in_middle(&pair, thickness) {
        return None;
    }
    if of_shells && old.is_none() {
        pair.keep_if_deep(thickness);
    }
    let is_line = surface.has_lines && segment.is_line();
    Some(PairCandidate { pair, impact, opposition, opening, apart, thickness, is_line, gap })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::candidates::CandidatePair;
    use crate::geometry::{Sphere, nearest};
    use crate::near_list::CandidateFilter;
    use crate::pairs::PairKey;
    use crate::surface::NOT_LOCAL;
    use crumple_fem::testing::nodes_at;
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
            searched: true,
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
            searched: true,
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
        let at = V3::from(xyz(&nodes.x[6]));
        let near = nearest(&at, &surface.segments[1].corners(&nodes.x), false).unwrap();
        let of = CandidatePair { slave_index: 0, segment: 1, shared_node_mask: 0 };
        let mut found = Vec::new();
        find_pairs(
            (&nodes, ContactDetail::default()),
            (&surface, &[true]),
            0,
            &[ProjectedPair { of, step: 0.0, near }],
            memory,
            0.0,
            (&mut Vec::new(), &mut found),
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
            let v = |n: u32| V3::from(xyz(&nodes.v_next[n as usize]));
            let step = segment.nodes.iter().map(|&n| (v(n) - v(4)).norm()).fold(0.0, f64::max);
            let (at, scale) = (V3::from(at), 2.0 * SCALE);
            let Some(near) = nearest(&at, &segment.corners(&nodes.x), false) else { return Ok(()) };
            let of = CandidatePair { slave_index: 0, segment: 0, shared_node_mask: 0 };
            let projected = ProjectedPair { of, step, near };
            let geometry =
                PairGeometry::new((&nodes, &surface), 0, &projected, 1.0).expect("all touch");
            if let Some((touch, _)) = touch_frame(&nodes, &geometry, 1.0) {
                let (far, reach) = ((at - near.point).norm(), reach(&surface, 4, segment, step));
                prop_assert!(far <= reach, "touch at {}, {far}, reach {reach}", touch.point);
            }
            let Some(frame) = solid_frame(&nodes, &geometry, false) else { return Ok(()) };
            let moving: V3 = segment.nodes.iter().zip(near.shape).map(|(&n, s)| v(n) * s).sum();
            if frame.reached + (v(4) - moving).dot(&frame.normal) < ACTIVE * scale {
                let (far, reach) = ((at - near.point).norm(), reach(&surface, 4, segment, step));
                prop_assert!(far <= reach, "contact at {far}, reach {reach}");
            }
        }
    }
}
