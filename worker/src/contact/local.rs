//! Local search: which candidates of a node are contact pairs in this step.
//!
//! The decision uses positions, velocities without contact and the node's memory, nothing else; above all not
//! when or by whom the candidates were collected.

use crate::contact::geometry::{V3, nearest};
use crate::contact::pairs::{Memory, Pair};
use crate::contact::surface::{Segment, Surface};
use crate::nodes::{Nodes, Row};

/// Candidates farther than this multiple of the contact thickness are not looked at. The global search must
/// reach as far (its reach is built from the same number).
pub const REACH: f64 = 1.5;
/// A pair is active when its predicted gap falls below this fraction of the contact thickness.
const ACTIVE: f64 = 0.02;
/// Neighbouring segments whose nearest point lies less than this fraction of the thickness in front of the
/// tangent plane of an accepted pair add nothing to it.
const PLANE: f64 = 0.02;
/// Most pairs of one node: a corner of three faces and one more.
const MOST: usize = 4;
/// Share of a tolerated penetration that is given back to the gap per step.
const RELAX: f64 = 0.002;

/// A pair as the local search sees it, before selection.
struct Find {
    pair: Pair,
    /// When within the step the gap closes, 0 for existing contact.
    impact: f64,
    /// Normal velocity of the node against the segment without contact [length/time]; negative when closing.
    opening: f64,
    /// Segment to node [length].
    offset: V3,
    /// Gap between surfaces, penetration that is tolerated not taken off [length].
    gap: f64,
}

fn v3(r: &Row) -> V3 {
    V3::new(r[0], r[1], r[2])
}

/// Active pairs of node `slave` among `candidates` (indices of segments, ascending), appended to `out`
/// in ascending segment id. `memory` is what the node remembers of its pairs of the last step.
pub fn find_pairs(
    nodes: &Nodes,
    surface: &Surface,
    slave: u32,
    candidates: &[u32],
    memory: &[Memory],
    dt: f64,
    out: &mut Vec<Pair>,
) {
    let at = v3(&nodes.x[slave as usize]);
    let half = surface.node_half[slave as usize];
    let mut finds: Vec<Find> = Vec::new();
    for &c in candidates {
        let segment = &surface.segments[c as usize];
        if may_touch(nodes, segment, &at, half) {
            finds.extend(look(nodes, segment, slave, &at, half, memory, dt));
        }
    }
    // Existing contact first, nearest first; then by time of impact, the most opposed first; ids break ties.
    finds.sort_by(|a, b| {
        let by_time = a.impact.total_cmp(&b.impact);
        let by_gap = if a.impact == 0.0 { a.gap.total_cmp(&b.gap) } else { a.opening.total_cmp(&b.opening) };
        by_time.then(by_gap).then(a.pair.segment.cmp(&b.pair.segment))
    });
    let mut accepted: Vec<Find> = Vec::new();
    for f in finds {
        // On a flat or convex neighbourhood the accepted tangent plane already keeps the node off this segment;
        // on a concave one it does not.
        let covered =
            |a: &Find| f.offset.dot(&a.pair.normal) >= a.offset.dot(&a.pair.normal) - PLANE * f.pair.thickness;
        if accepted.len() < MOST && !accepted.iter().any(covered) {
            accepted.push(f);
        }
    }
    accepted.sort_by_key(|f| f.pair.segment);
    out.extend(accepted.into_iter().map(|f| f.pair));
}

/// A cheap look before the projection: is the node within reach of the segment's box and of its mean plane?
fn may_touch(nodes: &Nodes, segment: &Segment, at: &V3, half: f64) -> bool {
    let reach = REACH * (half + segment.half);
    let q = segment.nodes.map(|n| &nodes.x[n as usize]);
    let in_box = (0..3).all(|c| {
        let (lo, hi) = q.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |b, r| (b.0.min(r[c]), b.1.max(r[c])));
        at[c] >= lo - reach && at[c] <= hi + reach
    });
    in_box && {
        // All of the segment lies as near to the plane through its first node as its other corners do.
        let [a, b, c, d] = q.map(v3);
        let normal = (c - a).cross(&(d - b));
        let size = normal.norm();
        let off = |p: &V3| (p - a).dot(&normal);
        let (low, high) = [b, c, d].iter().map(off).fold((0.0f64, 0.0f64), |s, o| (s.0.min(o), s.1.max(o)));
        (low - reach * size..=high + reach * size).contains(&off(at))
    }
}

fn look(nodes: &Nodes, segment: &Segment, slave: u32, at: &V3, half: f64, memory: &[Memory], dt: f64) -> Option<Find> {
    let thickness = half + segment.half;
    let near = nearest(at, &segment.corners(&nodes.x), segment.is_triangle())?;
    let offset = at - near.point;
    let distance = offset.norm();
    if distance > REACH * thickness {
        return None;
    }
    let height = offset.dot(&near.normal);
    let known = memory.iter().find(|m| m.segment == segment.id);
    // The normal points to the node's side. Around the rim it turns with the node, so that nothing jumps when
    // the node passes from one segment to the next or slides off. Deep inside, the remembered side decides.
    let here = if height < 0.0 { -1.0 } else { 1.0 };
    let side = known.filter(|_| !near.rim).map_or(here, |m| m.side);
    let deep = height * side < 0.0 || distance < 0.05 * thickness;
    let (normal, reached) = if deep { (near.normal * side, height * side) } else { (offset / distance, distance) };
    let gap = reached - thickness;
    let velocity = |n: u32| v3(&nodes.next_v[n as usize]);
    let point_velocity: V3 = segment.nodes.iter().zip(near.shape).map(|(&n, s)| velocity(n) * s).sum();
    let opening = (velocity(slave) - point_velocity).dot(&normal);
    let predicted = gap + dt * opening;
    // A node that slid over an edge keeps what it had on the neighbouring segment.
    let inherited = || memory.iter().find(|m| m.normal.dot(&normal) > 0.7);
    let old = known.or_else(inherited);
    // Penetration that was not there through an impact (at the start, or around a rim) is let be and given back slowly.
    let tolerated = old.map_or(gap.min(0.0), |m| (m.tolerated * (1.0 - RELAX)).max(gap.min(0.0)));
    if predicted - tolerated >= ACTIVE * thickness {
        return None;
    }
    let impact =
        if old.is_some() || gap <= 0.0 { 0.0 } else { (gap / (gap - predicted).max(f64::MIN_POSITIVE)).min(1.0) };
    let shape = near.shape;
    let pair = Pair {
        slave: nodes.id[slave as usize],
        segment: segment.id,
        nodes: [slave, segment.nodes[0], segment.nodes[1], segment.nodes[2], segment.nodes[3]],
        shape,
        weight: shape,
        normal,
        side,
        gap: gap - tolerated,
        depth: -gap,
        tolerated,
        thickness,
        force: old.map_or(V3::zeros(), |m| m.force_along(&normal)),
        slip: old.map_or(V3::zeros(), |m| m.slip - normal * normal.dot(&m.slip)),
        compliance: [0.0; 2],
        users: [0; 5],
        guess: V3::zeros(),
        turn: 1.0,
        mass: 0.0,
        stiffness: 0.0,
        own: true,
    };
    Some(Find { pair, impact, opening, offset, gap })
}
