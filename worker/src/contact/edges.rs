//! Edges against edges: what passes between the nodes that the local search looks at.
//!
//! The edges that matter are the free ones of shells and those of solids where two faces meet in a sharp convex angle on the
//! mesh as it is given: a matter of topology and of initial coordinates, so that it does not depend on when or by whom it is
//! found out. A pair is a point of one edge, the slave, on a point of another, wherever the two edges are nearest to each
//! other between their ends; ends are nodes, which the local search has. Of two edges the one with the lower nodes is the
//! slave, so that no pair is there twice.
//!
//! A worker owns the edges whose lowest segment is its own. It then holds their nodes, and its exterior copies are made to
//! reach as far around them as around its slaves ([`outline`]): it has all segments that contain an edge it could meet, and
//! with these knows what kind of edge that is.
//!
//! The normal is the cross product of the edges. Its sign for shells is that of the side at which the edges were when they
//! first came near: the step is short enough for that to be seen before they are through (`agreement.rs`). A solid's edge is
//! met from where its two faces look: the normal lies between theirs, as on a polyhedron's Gauss image.
//!
//! An edge that slides along a row of edges keeps what the pair with the last one had. That may have belonged to another
//! worker, so pairs that are known here are remembered, not only own ones.

use crate::contact::approach;
use crate::contact::geometry::{Passing, V3, passing};
use crate::contact::local::{ACTIVE, BEHIND, BESIDE, REACH, moved, tolerated};
use crate::contact::pairs::{Memory, Name, Pair};
use crate::contact::search::Search;
use crate::contact::surface::{NOT_LOCAL, Segment, Surface};
use crate::nodes::{Nodes, Row, xyz};
use crate::ties::Joined;
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::NodeId;

/// Faces of solids whose normals have a product above this on the mesh as given meet in no edge worth looking at.
const SHARP: f64 = 0.7;
/// How far the normal of a contact may leave the angle between the normals of a solid's two faces, in cosines against their
/// middle; for solids that lie flat on each other it is one of these normals.
const CONE: f64 = 0.1;
/// How near to an end of an edge, as a fraction of the scale, a new contact of shells is left to the node there, which keeps
/// the other edge off to `sqrt(1 - END^2)` of the thickness.
const END: f64 = 0.1;
/// Memories of edges that follow each other are of the same contact if their normals have a product above this.
const ALIKE: f64 = 0.7;

/// An edge that matters.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Local nodes, in ascending id.
    pub nodes: [u32; 2],
    /// Indices of the segments that have it, in ascending id; one segment is there twice.
    pub segments: [u32; 2],
}

impl Edge {
    /// Its ends.
    pub fn ends(&self, x: &[Row]) -> [V3; 2] {
        self.nodes.map(|n| V3::from(xyz(&x[n as usize])))
    }

    fn ids(&self, nodes: &Nodes) -> [NodeId; 2] {
        self.nodes.map(|n| nodes.id[n as usize])
    }

    fn bounds(&self, x: &[Row]) -> Aabb {
        Aabb::around(self.nodes.map(|n| xyz(&x[n as usize])))
    }

    /// Whether a segment or a solid that has this edge has any of `others`.
    fn has_beside(&self, surface: &Surface, others: &[u32; 2]) -> bool {
        let has = |s: &Segment| others.iter().any(|n| s.nodes.contains(n) || s.behind.contains(n));
        self.segments.iter().any(|&g| has(&surface.segments[g as usize]))
    }
}

/// A segment's edge: local nodes in ascending id, and the segment.
type Side = ([u32; 2], u32);

fn sides(surface: &Surface, nodes: &Nodes) -> Vec<Side> {
    let mut all = Vec::with_capacity(4 * surface.segments.len());
    for (g, s) in surface.segments.iter().enumerate() {
        let corners = if s.is_triangle() { 3 } else { 4 };
        for k in 0..corners {
            let (a, b) = (s.nodes[k], s.nodes[(k + 1) % corners]);
            all.push((if nodes.id[a as usize] < nodes.id[b as usize] { [a, b] } else { [b, a] }, g as u32));
        }
    }
    all.sort_unstable();
    all
}

/// Whether the sides of one edge make it one that matters. With `partial`, segments may be missing.
fn matters(surface: &Surface, nodes: &Nodes, run: &[Side], partial: bool) -> bool {
    let segment = |side: &Side| &surface.segments[side.1 as usize];
    match run {
        [one] => partial || !segment(one).is_solid(),
        [one, other] => {
            segment(one).is_solid() && segment(other).is_solid() && is_sharp(segment(one), segment(other), &nodes.x0)
        }
        _ => false,
    }
}

/// Whether two faces of solids with a common edge meet in a sharp convex angle.
fn is_sharp(one: &Segment, other: &Segment, x: &[Row]) -> bool {
    let [Some(a), Some(b)] = [one, other].map(|s| s.middle_normal(x)) else { return false };
    let middle = |s: &Segment| s.corners(x).iter().sum::<V3>() * 0.25;
    a.dot(&b) < SHARP && (middle(other) - middle(one)).dot(&a) < 0.0
}

/// All edges of the surface that matter.
pub fn edges(surface: &Surface, nodes: &Nodes) -> Vec<Edge> {
    let all = sides(surface, nodes);
    let runs = all.chunk_by(|a, b| a.0 == b.0).filter(|run| matters(surface, nodes, run, false));
    runs.map(|run| Edge { nodes: run[0].0, segments: [run[0].1, run[run.len() - 1].1] }).collect()
}

/// Nodes of the edges of own segments that may matter, whatever others have beside them, possibly several times. `surface`
/// has own segments only.
pub fn outline(surface: &Surface, nodes: &Nodes) -> Vec<u32> {
    let all = sides(surface, nodes);
    let runs = all.chunk_by(|a, b| a.0 == b.0).filter(|run| matters(surface, nodes, run, true));
    runs.flat_map(|run| run[0].0).collect()
}

/// What is remembered of a pair.
#[derive(Clone, Copy, Debug)]
struct Remembered {
    memory: Memory,
    /// Local nodes by role, or [`NOT_LOCAL`].
    nodes: [u32; 4],
    /// Whether the slave edge is this worker's own.
    own: bool,
}

/// The edges that a worker knows, and what its own have met.
#[derive(Debug, Default)]
pub struct Edges {
    all: Vec<Edge>,
    /// Indices of own edges.
    own: Vec<u32>,
    /// Slave and other edge of all pairs that could touch before the next search, in ascending order of their names.
    candidates: Vec<[u32; 2]>,
    /// In ascending order of names.
    memories: Vec<Remembered>,
    /// Whether they are as they were gathered, alike on all workers that have them: no step has gone by since.
    gathered: bool,
}

impl Edges {
    /// The edges of a new surface, and what is remembered at their nodes.
    pub fn of(surface: &Surface, nodes: &Nodes, memory_of: impl Fn(NodeId) -> Vec<Memory>) -> Self {
        let all = edges(surface, nodes);
        let is_own = |e: &Edge| surface.segments[e.segments[0] as usize].own;
        let own: Vec<u32> = (0..all.len() as u32).filter(|&i| is_own(&all[i as usize])).collect();
        let mut names: Vec<[NodeId; 2]> = own.iter().map(|&i| all[i as usize].ids(nodes)).collect();
        names.sort_unstable();
        let mut ends: Vec<NodeId> = names.iter().flatten().copied().collect();
        ends.sort_unstable();
        ends.dedup();
        let mut memories: Vec<Memory> = ends.into_iter().flat_map(memory_of).filter(|m| m.name.is_edge()).collect();
        memories.sort_unstable_by_key(|m| m.name);
        memories.dedup_by_key(|m| m.name);
        let local = |id| nodes.number(id).unwrap_or(NOT_LOCAL);
        let remembered = |memory: Memory| Remembered {
            memory,
            nodes: memory.name.edge_nodes().map(local),
            own: names.binary_search(&[memory.name.slave, memory.name.far]).is_ok(),
        };
        Self {
            memories: memories.into_iter().map(remembered).collect(),
            all,
            own,
            candidates: Vec::new(),
            gathered: true,
        }
    }

    /// Lowest segment that has the edge between these local nodes, in the order in which edges have them.
    pub fn segment_of(&self, nodes: [u32; 2]) -> Option<u32> {
        self.all.binary_search_by_key(&nodes, |e| e.nodes).ok().map(|i| self.all[i].segments[0])
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.all[..]) + size_of_val(&self.own[..]) + size_of_val(&self.candidates[..])
    }

    /// Global search: which own edges could meet which others before nodes have moved by more than `skin` against each
    /// other [length].
    pub fn search(&mut self, surface: &Surface, nodes: &Nodes, joined: Joined<'_>, find: Search, skin: f64) {
        self.candidates.clear();
        if self.own.is_empty() {
            return;
        }
        let own = |i: u32| &self.all[self.own[i as usize] as usize];
        let scale = |e: &Edge| surface.segments[e.segments[0] as usize].scale;
        let half = |e: &Edge| 0.5 * (e.ends(&nodes.x)[1] - e.ends(&nodes.x)[0]).norm();
        let numbers = 0..self.own.len() as u32;
        let longest = numbers.clone().map(|i| half(own(i))).fold(0.0, f64::max);
        let largest = numbers.clone().map(|i| scale(own(i))).fold(0.0, f64::max);
        let middle = |e: &Edge| ((e.ends(&nodes.x)[0] + e.ends(&nodes.x)[1]) * 0.5).into();
        let middles: Vec<[f64; 3]> = numbers.map(|i| middle(own(i))).collect();
        let reach = |e: &Edge| REACH * (scale(e) + largest) + skin;
        let boxes: Vec<Aabb> = self.all.iter().map(|e| e.bounds(&nodes.x).grown(reach(e) + longest)).collect();
        find(&boxes, &middles, &mut |other, i| {
            let (slave, met) = (own(i), &self.all[other as usize]);
            let [j, k] = met.nodes;
            let may_meet = slave.ids(nodes) < met.ids(nodes)
                && met.bounds(&nodes.x).grown(reach(met)).touches(&slave.bounds(&nodes.x))
                && !slave.has_beside(surface, &met.nodes)
                && !met.has_beside(surface, &slave.nodes)
                && !joined.are_one(slave.nodes[0], &[slave.nodes[1], j, k, k])
                && !joined.ties.are_tied(slave.nodes[1], &[j, k, k, k]);
            if may_meet {
                self.candidates.push([self.own[i as usize], other]);
            }
        });
        let all = &self.all;
        self.candidates.sort_unstable_by_key(|c| c.map(|i| all[i as usize].ids(nodes)));
    }

    /// As [`approach::rate`] of all candidates: what counts is near by the boxes around both edges [1/time].
    pub fn approach_rate(&self, nodes: &Nodes, surface: &Surface, dt: f64) -> f64 {
        let rate = |[a, b]: [&Edge; 2]| {
            let scale = [a, b].iter().map(|e| surface.segments[e.segments[0] as usize].scale).sum::<f64>();
            let speed = approach::speed(nodes, &a.nodes, &b.nodes);
            let near = a.bounds(&nodes.x).grown(REACH * scale + approach::STEPS * dt * speed);
            if near.touches(&b.bounds(&nodes.x)) { speed / scale } else { 0.0 }
        };
        self.candidates.iter().map(|c| rate(c.map(|i| &self.all[i as usize]))).fold(0.0, f64::max)
    }

    /// A node of the slave and a segment that has the other edge, for each candidate.
    pub fn near(&self) -> impl Iterator<Item = (u32, u32)> {
        self.candidates.iter().map(|c| c.map(|i| &self.all[i as usize])).map(|[a, b]| (a.nodes[0], b.segments[0]))
    }

    /// Active pairs of own edges in this step, appended in ascending order of their names. `stiffness` is per segment,
    /// or empty; a pair is as stiff as the softer side.
    pub fn find_pairs(&self, nodes: &Nodes, surface: &Surface, stiffness: &[f64], dt: f64, out: &mut Vec<Pair>) {
        for [a, b] in self.candidates.iter().map(|c| c.map(|i| &self.all[i as usize])) {
            let Some(met) = passing(&a.ends(&nodes.x), &b.ends(&nodes.x)) else { continue };
            if let Some(mut pair) = self.look(nodes, surface, [a, b], &met, dt) {
                let of = |e: &Edge| stiffness.get(e.segments[0] as usize).copied().unwrap_or(0.0);
                pair.stiffness = of(a).min(of(b));
                out.push(pair);
            }
        }
    }

    fn look(&self, nodes: &Nodes, surface: &Surface, edges: [&Edge; 2], met: &Passing, dt: f64) -> Option<Pair> {
        let [one, other] = edges.map(|e| &surface.segments[e.segments[0] as usize]);
        let (thickness, scale) = (one.half + other.half, one.scale + other.scale);
        let speed = surface.slower(one.part, other.part);
        if met.height.abs() > REACH * scale {
            return None;
        }
        let [slave, other_ids] = edges.map(|e| e.ids(nodes));
        let name = Name::of_edges(slave, other_ids);
        let known = self.recall(&name, &met.normal);
        let solid = one.is_solid() || other.is_solid();
        let side = if solid {
            facing(surface, nodes, edges, &met.normal)?
        } else {
            known.as_ref().map_or(met.height, |m| m.normal.dot(&met.normal))
        };
        let side = if side < 0.0 { -1.0 } else { 1.0 };
        let (normal, gap) = (met.normal * side, met.height * side - thickness);
        let old = known.filter(|m| m.normal.dot(&normal) > 0.0);
        if old.is_none() {
            let to_end = |k: usize| {
                let [p, q] = edges[k].ends(&nodes.x);
                met.along[k].min(1.0 - met.along[k]) * (q - p).norm()
            };
            // An upright edge that stands on a face a little deep is as deep beside the face's edges as that is from them,
            // and does not meet those.
            let margin = if solid { (BESIDE * scale).max(-gap) } else { END * scale };
            if solid && gap < -BEHIND * scale || to_end(0).min(to_end(1)) < margin {
                return None;
            }
        }
        let [s, t] = met.along;
        let shape = [1.0 - s, s, 1.0 - t, t, 0.0];
        let ([i, j], [k, l]) = (edges[0].nodes, edges[1].nodes);
        let pair = Pair {
            shape,
            weight: shape,
            normal,
            side,
            thickness: scale,
            speed,
            first: (one.part, one.id) < (other.part, other.id),
            own: true,
            ..Pair::unknown(name, other.id, [i, j, k, l, NOT_LOCAL])
        };
        let moved = moved(nodes, [j, k, l].into_iter(), i, dt, scale);
        let tolerated = tolerated(old.as_ref(), gap, moved, dt, speed);
        let pair = pair.remembering(old.as_ref(), gap, tolerated);
        let predicted = pair.gap + dt * pair.relative_velocity(&nodes.next_v).dot(&normal);
        (predicted < ACTIVE * scale).then_some(pair)
    }

    /// What is remembered of a pair, or of one that it follows on, without its slip; `normal` is along the cross product of
    /// the edges.
    fn recall(&self, name: &Name, normal: &V3) -> Option<Memory> {
        if let Ok(i) = self.memories.binary_search_by_key(name, |r| r.memory.name) {
            return Some(self.memories[i].memory);
        }
        let [a, b, c, d] = name.edge_nodes();
        let shares = |p: [NodeId; 2], q: [NodeId; 2]| p.iter().any(|n| q.contains(n));
        let alike = |m: &Memory| m.normal.dot(normal).abs() > ALIKE;
        let before = self.memories.iter().find_map(|r| {
            let [i, j, k, l] = r.memory.name.edge_nodes();
            let m = r.memory;
            let along = shares([a, b], [i, j]) && shares([c, d], [k, l]);
            let across = shares([a, b], [k, l]) && shares([c, d], [i, j]);
            let turned = || Memory { normal: -m.normal, force: -m.force, ..m };
            along.then_some(m).or_else(|| across.then(turned)).filter(alike)
        });
        before.map(|m| Memory { slip: V3::zeros(), ..m })
    }

    /// Remembers the pairs of a step, all that are known here.
    pub fn remember<'a>(&mut self, pairs: impl Iterator<Item = &'a Pair>) {
        self.memories.clear();
        self.gathered = false;
        let edges = pairs.filter(|p| p.name.is_edge());
        let [i, j, k, l] = [0, 1, 2, 3];
        self.memories.extend(edges.map(|p| Remembered {
            memory: p.memory(),
            nodes: [i, j, k, l].map(|r: usize| p.nodes[r]),
            own: p.own,
        }));
    }

    /// What own edges remember, under each of the four nodes of a pair that is known here; before a step has gone by since the
    /// last time also what is left of edges that nobody has any more.
    pub fn memories(&self) -> impl Iterator<Item = (u32, &Memory)> {
        let told = self.memories.iter().filter(|r| r.own || self.gathered);
        told.flat_map(|r| r.nodes.map(|n| (n, &r.memory))).filter(|(n, _)| *n != NOT_LOCAL)
    }
}

/// Sign with which `normal`, at right angles to both edges, points out of the other one's solid and into the first one's, as
/// far as they are edges of solids. `None` where neither sign does.
fn facing(surface: &Surface, nodes: &Nodes, edges: [&Edge; 2], normal: &V3) -> Option<f64> {
    let mut sign = 0.0;
    for (edge, out) in edges.into_iter().zip([-1.0, 1.0]) {
        let [one, two] = edge.segments.map(|g| &surface.segments[g as usize]);
        if !one.is_solid() {
            continue;
        }
        let [face, next] = [one.middle_normal(&nodes.x)?, two.middle_normal(&nodes.x)?];
        let middle = (face + next).try_normalize(0.0)?;
        let along = middle.dot(normal);
        let of_this = if along < 0.0 { -out } else { out };
        if along.abs() < middle.dot(&face) - CONE || sign * of_this < 0.0 {
            return None;
        }
        sign = of_this;
    }
    Some(sign)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::ids::SegmentId;

    /// An edge that follows on another one, as slave or as the one that is met, takes over what that had, but for its slip.
    #[test]
    fn what_an_edge_had_goes_to_the_next_one() {
        let name = |slave: [u64; 2], other: [u64; 2]| Name::of_edges(slave.map(NodeId), other.map(NodeId));
        let pair = Pair {
            normal: V3::z(),
            tolerated: -0.25,
            force: V3::new(0.5, 0.0, 2.0),
            slip: V3::x(),
            ..Pair::unknown(name([5, 6], [8, 9]), SegmentId(1), [0; 5])
        };
        // With a lower name, and across: another contact of the same edge.
        let other = Pair { name: name([4, 6], [8, 9]), normal: V3::x(), ..pair };
        let mut edges = Edges::default();
        edges.remember([other, pair].iter());
        let recall = |slave, other, normal: &V3| edges.recall(&name(slave, other), normal);
        assert_eq!(recall([5, 6], [8, 9], &V3::z()), Some(pair.memory()), "its own");
        let next = Memory { slip: V3::zeros(), ..pair.memory() };
        assert_eq!(recall([6, 7], [8, 9], &V3::z()), Some(next), "along the slave's row");
        assert_eq!(recall([5, 6], [9, 12], &-V3::z()), Some(next), "along the other row, which may run the other way");
        let turned = Memory { normal: -next.normal, force: -next.force, ..next };
        assert_eq!(recall([4, 8], [6, 7], &V3::z()), Some(turned), "slave and other change places");
        assert_eq!(recall([6, 7], [8, 9], &V3::y()), None, "another contact by its normal");
        assert_eq!(recall([5, 6], [10, 11], &V3::z()), None, "an edge elsewhere");
    }
}
