//! Edges against edges: what passes between the nodes that the local search looks at. Beams are
//! edges too.
//!
//! The edges that matter are those that stand out (`ridges.rs`). A pair is a point of one edge, the
//! slave, on a point of another, wherever the two edges are nearest to each other between their
//! ends; ends are nodes, which the local search has. Of two edges the one with the lower nodes is
//! the slave, so that no pair is there twice.
//!
//! Which edges those are changes as surfaces fold, and is found out every so many cycles. A contact
//! that is there lasts as long as it touches, however flat a fold becomes under it.
//!
//! A worker owns the edges whose lowest segment is its own. It then holds their nodes, and its
//! exterior copies are made to reach as far around them as around its slaves ([`outline`]): it has
//! all segments that contain an edge it could meet, and with these knows what kind of edge that is.
//!
//! The normal is the cross product of the edges. Its sign for shells is that of the side at which
//! the edges were when they first came near: the step is short enough for that to be seen before
//! they are through (`agreement.rs`). A fold is met from where it stands out: seen from it the
//! other edge lies behind none of its segments; unless the edges are then only just as near as they
//! may come. A solid's edge is met from where its two faces look: the normal lies between theirs,
//! as on a polyhedron's Gauss image.
//!
//! An edge that slides along a row of edges keeps what the pair with the last one had. That may
//! have belonged to another worker, so pairs that are known here are remembered, not only own ones.
//! A pair that is lost while it is deep is remembered for some steps more ([`Memory::lost`]).

use crate::constraints::ties::ContactExclusions;
use crate::contact::approach;
use crate::contact::folds::{Edge, EdgeTable, FoldWedge, Kind};
use crate::contact::geometry::{EdgeProjection, V3, project_edges, separation};
use crate::contact::local_search::{ACTIVE, BEHIND, BESIDE, REACH, moved, tolerated};
use crate::contact::pairs::{Pair, PairHistory, PairKey, padded};
use crate::contact::search::Search;
use crate::contact::surface::{NOT_LOCAL, Surface};
use crate::nodes::{Nodes, xyz};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::NodeId;

/// How far the normal of a contact may leave the angle between the normals of a solid's two faces,
/// in cosines against their middle; for solids that lie flat on each other it is one of these
/// normals. So for folds: the sine of the angle by which the other edge may lie behind a segment.
const CONE: f64 = 0.1;
/// How near to an end of an edge, as a fraction of the scale, a new contact of shells is left to
/// the node there, which keeps the other edge off to `sqrt(1 - END^2)` of the thickness.
const END: f64 = 0.1;
/// Memories of edges that follow each other are of the same contact if their normals have a product
/// above this.
const ALIKE: f64 = 0.7;
/// Two edges that come to stand out while each is this near behind the other, as a fraction of the
/// thickness, and in front of it by the way both are folded, have sunk in before: that far a fold
/// that does not stand out lets them.
const SUNK: f64 = 0.5;

/// Edges that are folded by this fraction of the angle at which they stand out are searched for
/// beside those that do: else each new one would ask for a search.
const NEARLY: f64 = 0.7;

/// All nodes of own segments, possibly several times: the edges between them may come to stand out,
/// whatever others have beside them, and the segments themselves may meet others. `surface` has own
/// segments only.
pub fn contact_edges(surface: &Surface) -> Vec<u32> {
    surface.segments.iter().flat_map(|s| s.nodes).collect()
}

/// What is remembered of a pair.
#[derive(Clone, Copy, Debug)]
struct EdgePairHistory {
    memory: PairHistory,
    /// Local nodes by role, or [`NOT_LOCAL`].
    nodes: [u32; 4],
    /// Whether the slave edge is this worker's own.
    own: bool,
}

/// The edges that a worker knows, and what its own have met.
#[derive(Debug, Default)]
pub struct Edges {
    lines: EdgeTable,
    /// Which of them stand out.
    out: Vec<bool>,
    /// Which of them do, or are near to it.
    nearly: Vec<bool>,
    /// Which of them were searched for: those that stood out then, and those that were near to it.
    searched: Vec<bool>,
    /// Whether some stand out that were not searched for.
    stale: bool,
    /// Indices of own edges.
    own: Vec<u32>,
    /// Slave and other edge of all pairs that could touch before the next search, in ascending
    /// order of their names.
    found: Vec<[u32; 2]>,
    /// Those of them that are near.
    candidates: Vec<[u32; 2]>,
    /// In ascending order of names.
    memories: Vec<EdgePairHistory>,
    /// Nodes of the memories, ascending, with the places of these.
    by_node: Vec<(NodeId, u32)>,
    /// Whether they are as they were gathered, alike on all workers that have them: no step has
    /// gone by since.
    gathered: bool,
    /// Whether none but beams meet others.
    of_beams: bool,
}

impl Edges {
    /// The edges of a new surface, and what is remembered at their nodes. With `of_beams` none meet
    /// but those of beams and others.
    pub fn new(
        surface: &Surface,
        nodes: &Nodes,
        memory_of: impl Fn(NodeId) -> Vec<PairHistory>,
        of_beams: bool,
    ) -> Self {
        let lines = EdgeTable::new(surface, nodes);
        let is_own = |e: &Edge| lines.lowest_segment(e, surface).own;
        let own: Vec<u32> =
            (0..lines.all.len() as u32).filter(|&i| is_own(&lines.all[i as usize])).collect();
        let mut names: Vec<[NodeId; 2]> =
            own.iter().map(|&i| lines.all[i as usize].ids(nodes)).collect();
        names.sort_unstable();
        let mut ends: Vec<NodeId> = names.iter().flatten().copied().collect();
        ends.sort_unstable();
        ends.dedup();
        let mut memories: Vec<PairHistory> =
            ends.into_iter().flat_map(memory_of).filter(|m| m.name.is_edge()).collect();
        memories.sort_unstable_by_key(|m| m.name);
        memories.dedup_by_key(|m| m.name);
        let local = |id| nodes.index_of(id).unwrap_or(NOT_LOCAL);
        let remembered = |memory: PairHistory| EdgePairHistory {
            memory,
            nodes: memory.name.edge_nodes().map(local),
            own: names.binary_search(&[memory.name.slave, memory.name.slave_end]).is_ok(),
        };
        let mut edges = Self {
            memories: memories.into_iter().map(remembered).collect(),
            lines,
            own,
            gathered: true,
            of_beams,
            ..Self::default()
        };
        edges.update_folds(surface, nodes);
        edges.index();
        edges
    }

    /// Lowest segment that has the edge between these local nodes, in the order in which edges have
    /// them.
    pub fn segment_of(&self, nodes: [u32; 2]) -> Option<u32> {
        self.lines.place(nodes).map(|i| self.lines.segments(&self.lines.all[i])[0])
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        self.lines.bytes()
            + size_of_val(&self.own[..])
            + size_of_val(&self.found[..])
            + size_of_val(&self.candidates[..])
    }

    /// Finds out which edges stand out where nodes were last seen.
    pub fn update_folds(&mut self, surface: &Surface, nodes: &Nodes) {
        self.out.clear();
        self.nearly.clear();
        for e in &self.lines.all {
            let [out, nearly] = self.lines.is_folded(e, surface, &nodes.seen, [1.0, NEARLY]);
            self.out.push(out);
            self.nearly.push(out || nearly);
        }
        let is_new = |(i, &out): (usize, &bool)| {
            out && !self.searched.get(i).is_some_and(|&searched| searched)
        };
        self.stale |= self.out.iter().enumerate().any(is_new);
    }

    /// Whether candidates are to be searched for anew though nodes have not moved.
    pub fn is_stale(&self) -> bool {
        self.stale
    }

    /// Which edges could meet others: those that stand out or nearly do, and those that are
    /// remembered.
    fn ready(&self) -> Vec<bool> {
        let mut ready = self.nearly.clone();
        for [i, j, k, l] in self.memories.iter().map(|r| r.nodes) {
            let places = [[i, j], [k, l]].into_iter().filter_map(|e| self.lines.place(e));
            places.for_each(|p| ready[p] = true);
        }
        ready
    }

    /// Which own edges could meet which others before nodes have moved by more than `skin` against
    /// each other [length]. [`Self::pick`] comes after it.
    pub fn search(
        &mut self,
        surface: &Surface,
        nodes: &Nodes,
        joined: ContactExclusions<'_>,
        find: Search,
        skin: f64,
    ) {
        self.found.clear();
        self.stale = false;
        if self.own.is_empty() {
            return;
        }
        self.searched = self.ready();
        let ready = &self.searched;
        let (lines, is_ready) = (&self.lines, |i: &u32| ready[*i as usize]);
        let own: Vec<u32> = self.own.iter().copied().filter(is_ready).collect();
        if own.is_empty() {
            return;
        }
        let all: Vec<u32> = (0..lines.all.len() as u32).filter(is_ready).collect();
        let edge = |i: u32| &lines.all[i as usize];
        let [of_own, of_all] = [&own, &all]
            .map(|some| some.iter().map(|&i| EdgeBar::new(edge(i), nodes)).collect::<Vec<_>>());
        let longest = of_own.iter().map(|b| b.half).fold(0.0, f64::max);
        let largest = own.iter().map(|&i| edge(i).scale).fold(0.0, f64::max);
        let middles: Vec<[f64; 3]> = of_own.iter().map(|b| b.middle.into()).collect();
        let reach = |a: f64, b: f64| REACH * surface.interfaces.most(a + b) + skin;
        let grown =
            |i: &u32| edge(*i).bounds(&nodes.x).grown(reach(edge(*i).scale, largest) + longest);
        let boxes: Vec<Aabb> = all.iter().map(grown).collect();
        find(&boxes, &middles, &mut |b, p| {
            let (i, other) = (own[p as usize], all[b as usize]);
            let (slave, met) = (edge(i), edge(other));
            let reach = reach(slave.scale, met.scale);
            if of_own[p as usize].is_farther(&of_all[b as usize], reach) {
                return;
            }
            let [j, k] = met.nodes;
            let may_meet = slave.ids(nodes) < met.ids(nodes)
                && (!self.of_beams || slave.kind == Kind::Beam || met.kind == Kind::Beam)
                && are_within(slave, met, nodes, reach)
                && !lines.has_beside(slave, surface, &met.nodes)
                && !lines.has_beside(met, surface, &slave.nodes)
                && !joined.excludes(slave.nodes[0], &[slave.nodes[1], j, k, k])
                && !joined.ties.are_tied(slave.nodes[1], &[j, k, k, k])
                && lines.interface([slave, met], surface).is_some();
            if may_meet {
                self.found.push([i, other]);
            }
        });
        self.found.sort_unstable_by_key(|c| c.map(|i| edge(i).ids(nodes)));
    }

    /// Takes those of the pairs found that could touch in a step that moves nodes by no more than
    /// `step` against each other, before they have moved by more than `skin` [length].
    pub fn pick(&mut self, nodes: &Nodes, surface: &Surface, skin: f64, step: f64) {
        let is_near = |pair: &&[u32; 2]| {
            let [a, b] = pair.map(|i| &self.lines.all[i as usize]);
            let most = |sum| surface.interfaces.most(sum);
            let scale = most(a.scale + b.scale);
            let near = most(a.half + b.half) + ACTIVE * scale;
            let deepest =
                if [a, b].iter().any(|e| e.kind == Kind::Solid) { REACH * scale } else { near };
            let reach = near.max(deepest) + step + skin;
            a.bounds(&nodes.x).grown(reach).intersects(&b.bounds(&nodes.x))
                && are_within(a, b, nodes, reach)
        };
        self.candidates.clear();
        self.candidates.extend(self.found.iter().filter(is_near));
    }

    /// As [`approach::rate`] of all that was found [1/time].
    pub fn approach_rate(&self, nodes: &Nodes, surface: &Surface, (time, dt): (f64, f64)) -> f64 {
        let rate = |[a, b]: [&Edge; 2]| {
            let interface = self
                .lines
                .interface([a, b], surface)
                .filter(|&i| !surface.interfaces.is_over(i, time));
            let Some(interface) = interface else { return 0.0 };
            let scale = sizes(surface, interface, [a, b]).1;
            let speed = approach::speed(nodes, &a.nodes, &b.nodes);
            let near = are_within(a, b, nodes, REACH * scale + approach::STEPS * dt * speed);
            if near { speed / scale } else { 0.0 }
        };
        self.found.iter().map(|c| rate(c.map(|i| &self.lines.all[i as usize]))).fold(0.0, f64::max)
    }

    /// A node of the slave and a segment that has the other edge, for each candidate.
    pub fn near(&self) -> impl Iterator<Item = (u32, u32)> {
        let edges = self.candidates.iter().map(|c| c.map(|i| &self.lines.all[i as usize]));
        edges.map(|[a, b]| (a.nodes[0], self.lines.segments(b)[0]))
    }

    /// Active pairs of own edges in this step, appended in ascending order of their names.
    /// `stiffness` is per segment, or empty; a pair is as stiff as the softer side.
    pub fn find_pairs(
        &self,
        nodes: &Nodes,
        (surface, alive): (&Surface, &[bool]),
        stiffness: &[f64],
        dt: f64,
        out: &mut Vec<Pair>,
    ) {
        for places in &self.candidates {
            let edges = places.map(|i| &self.lines.all[i as usize]);
            let Some(met) = project_edges(&edges[0].ends(&nodes.x), &edges[1].ends(&nodes.x))
            else {
                continue;
            };
            let interface = self.lines.interface(edges, surface).filter(|&i| alive[i as usize]);
            let Some(interface) = interface else { continue };
            if let Some(mut pair) =
                self.evaluate_pair(nodes, (surface, interface), *places, &met, dt)
            {
                let of = |e: &Edge| {
                    stiffness.get(self.lines.segments(e)[0] as usize).copied().unwrap_or(0.0)
                };
                pair.stiffness = of(edges[0]).min(of(edges[1]));
                out.push(pair);
            }
        }
    }

    fn evaluate_pair(
        &self,
        nodes: &Nodes,
        (surface, interface): (&Surface, u16),
        places: [u32; 2],
        met: &EdgeProjection,
        dt: f64,
    ) -> Option<Pair> {
        let lines = &self.lines;
        let edges = places.map(|i| &lines.all[i as usize]);
        let [one, other] = edges;
        let (thickness, scale) = sizes(surface, interface, edges);
        let near = thickness + ACTIVE * scale;
        // Shells that are through by more than the thickness are lost; solids have no other side.
        let solid = edges.iter().any(|e| e.kind == Kind::Solid);
        let deepest = if solid { REACH * scale } else { near };
        let ([i, j], [k, l]) = (edges[0].nodes, edges[1].nodes);
        let [s, t] = met.along;
        // Most are too far away on whatever side they belong.
        let velocity = |n: u32| V3::from(xyz(&nodes.v_next[n as usize]));
        let slave = velocity(i) * (1.0 - s) + velocity(j) * s;
        let opening = (slave - velocity(k) * (1.0 - t) - velocity(l) * t).dot(&met.normal);
        if met.height.abs() - dt * opening.abs() >= near.max(deepest) {
            return None;
        }
        let name = PairKey::of_edges(one.ids(nodes), other.ids(nodes));
        let moved = moved(nodes, [j, k, l].into_iter(), i, dt, scale);
        let known = self.recall_history(&name, &met.normal).filter(|m| m.is_fresh(moved, scale));
        let stays = known.as_ref().is_some_and(|m| m.name == name);
        let side = if solid {
            facing(lines, surface, nodes, edges, &met.normal)?
        } else {
            known.as_ref().map_or(met.height, |m| m.normal.dot(&met.normal))
        };
        let mut side = if side < 0.0 { -1.0 } else { 1.0 };
        let old = known.filter(|m| m.normal.dot(&met.normal) * side > 0.0);
        let [one, two] = edges.map(|e| lines.lowest_segment(e, surface));
        let shape = padded([1.0 - s, s, 1.0 - t, t]);
        let mut pair = Pair {
            shape,
            weight: shape,
            lever_arms: levers(surface, interface, edges),
            interface,
            contact_thickness: scale,
            speed: surface.slower(one.part, two.part),
            slave_surface_first: (one.part, one.id) < (two.part, two.id),
            is_owned: true,
            ..Pair::new(name, two.id, [i, j, k, l])
        };
        // What is tolerated is no gap: it can only make the pair less near.
        if met.height * side + dt * opening * side >= near || met.height * side < -deepest {
            return None;
        }
        if !stays && !places.iter().all(|&i| self.out[i as usize]) {
            return None;
        }
        let folds = if old.is_none() { self.folds(nodes, edges)? } else { Folds { of: [None; 2] } };
        if old.is_none() && !folds.are_met_from(&(met.normal * side)) {
            // Edges that have just come as near as they may are on the sides where they belong,
            // whatever else holds them off. Left to nodes until the fold has turned, they would
            // have sunk in by then.
            let touches = met.height * side - thickness >= -ACTIVE * scale;
            if !touches || lines.are_neighbours(edges, surface) {
                // They may have met before they stood out.
                let sunk =
                    met.height.abs() < SUNK * thickness && folds.are_before(&(met.normal * -side));
                side = if sunk { -side } else { return None };
            }
        }
        let (normal, gap) = (met.normal * side, met.height * side - thickness);
        if old.is_none() {
            let to_end = |k: usize| {
                let [p, q] = edges[k].ends(&nodes.x);
                met.along[k].min(1.0 - met.along[k]) * (q - p).norm()
            };
            // An upright edge that stands on a face a little deep is as deep beside the face's
            // edges as that is from them, and does not meet those.
            let margin = if solid { (BESIDE * scale).max(-gap) } else { END * scale };
            if solid && gap < -BEHIND * scale || to_end(0).min(to_end(1)) < margin {
                return None;
            }
        }
        (pair.normal, pair.side) = (normal, side);
        let tolerated = tolerated(old.as_ref(), gap, moved, dt, pair.speed);
        let pair = pair.with_history(old.as_ref(), gap, tolerated);
        let predicted = pair.gap + dt * opening * side;
        (predicted < ACTIVE * scale).then_some(pair)
    }

    /// The wedges of what of two edges are folds. `None` if one of them has no outside any more.
    fn folds(&self, nodes: &Nodes, edges: [&Edge; 2]) -> Option<Folds> {
        let mut folds = Folds { of: [None; 2] };
        for (edge, fold) in
            edges.into_iter().zip(&mut folds.of).filter(|(e, _)| e.kind == Kind::Fold)
        {
            *fold = Some(self.lines.wedge(edge, &nodes.x)?);
        }
        Some(folds)
    }

    /// What is remembered of a pair, or of one that it follows on, without its slip; `normal` is
    /// along the cross product of the edges.
    fn recall_history(&self, name: &PairKey, normal: &V3) -> Option<PairHistory> {
        if let Ok(i) = self.memories.binary_search_by_key(name, |r| r.memory.name) {
            return Some(self.memories[i].memory);
        }
        let [a, b, c, d] = name.edge_nodes();
        let shares = |p: [NodeId; 2], q: [NodeId; 2]| p.iter().any(|n| q.contains(n));
        let alike = |m: &PairHistory| m.normal.dot(normal).abs() > ALIKE;
        let at = |n: NodeId| {
            let from = self.by_node.partition_point(|e| e.0 < n);
            self.by_node[from..].iter().take_while(move |e| e.0 == n).map(|e| e.1)
        };
        let follows = |place: u32| {
            let m = self.memories[place as usize].memory;
            let [i, j, k, l] = m.name.edge_nodes();
            let along = shares([a, b], [i, j]) && shares([c, d], [k, l]);
            let across = shares([a, b], [k, l]) && shares([c, d], [i, j]);
            let turned = || PairHistory { normal: -m.normal, force: -m.force, ..m };
            let of = along.then_some(m).or_else(|| across.then(turned)).filter(alike);
            of.map(|m| (m.age, place, PairHistory { slip: V3::zeros(), ..m }))
        };
        // What is touched before what was lost, then by name.
        let before =
            at(a).chain(at(b)).filter_map(follows).min_by_key(|&(age, place, _)| (age, place));
        before.map(|(_, _, m)| m)
    }

    /// Remembers the pairs of a step, all that are known here, and for some steps those that are
    /// lost.
    pub fn store_history<'a>(&mut self, pairs: impl Iterator<Item = &'a Pair>) {
        let before = std::mem::take(&mut self.memories);
        self.gathered = false;
        let edges = pairs.filter(|p| p.key.is_edge());
        let [i, j, k, l] = [0, 1, 2, 3];
        self.memories.extend(edges.map(|p| EdgePairHistory {
            memory: p.to_history(),
            nodes: [i, j, k, l].map(|r: usize| p.nodes[r]),
            own: p.is_owned,
        }));
        let touched = self.memories.len();
        for r in before {
            let found =
                self.memories[..touched].binary_search_by_key(&r.memory.name, |n| n.memory.name);
            if let (Err(_), Some(memory)) = (found, r.memory.after_loss()) {
                // What others have told has no side, and needs none.
                self.memories
                    .push(EdgePairHistory { memory: PairHistory { side: 0.0, ..memory }, ..r });
            }
        }
        if self.memories.len() > touched {
            self.memories.sort_unstable_by_key(|r| r.memory.name);
        }
        self.index();
    }

    fn index(&mut self) {
        self.by_node.clear();
        for (place, r) in (0..).zip(&self.memories) {
            self.by_node.extend(r.memory.name.edge_nodes().map(|n| (n, place)));
        }
        self.by_node.sort_unstable();
    }

    /// What own edges remember, under each of the four nodes of a pair that is known here; of pairs
    /// that are lost, and before a step has gone by since the last time, also what is left of edges
    /// that nobody has any more.
    pub fn pair_histories(&self) -> impl Iterator<Item = (u32, &PairHistory)> {
        let told = self.memories.iter().filter(|r| r.own || self.gathered || r.memory.age > 0);
        told.flat_map(|r| r.nodes.map(|n| (n, &r.memory))).filter(|(n, _)| *n != NOT_LOCAL)
    }
}

/// An edge as a sphere around it.
struct EdgeBar {
    middle: V3,
    half: f64,
}

impl EdgeBar {
    fn new(edge: &Edge, nodes: &Nodes) -> Self {
        let [p, q] = edge.ends(&nodes.x);
        Self { middle: (p + q) * 0.5, half: 0.5 * (q - p).norm() }
    }

    /// Whether another one is farther than `reach` for certain [length].
    fn is_farther(&self, other: &Self, reach: f64) -> bool {
        let reach = self.half + other.half + reach;
        (self.middle - other.middle).norm_squared() > reach * reach
    }
}

/// Whether two edges are no farther apart than `reach` [length].
fn are_within(a: &Edge, b: &Edge, nodes: &Nodes, reach: f64) -> bool {
    separation(&a.ends(&nodes.x), &b.ends(&nodes.x)) <= reach * reach
}

/// Half thicknesses of two edges together in an interface, and their scales [length].
fn sizes(surface: &Surface, interface: u16, edges: [&Edge; 2]) -> (f64, f64) {
    let [a, b] = edges.map(|e| surface.interfaces.measure(interface, (e.half, e.scale)));
    (a.0 + b.0, a.1 + b.1)
}

/// Lever arms of friction on two edges, as they are to each other: their half thicknesses; nought
/// without friction [length].
fn levers(surface: &Surface, interface: u16, edges: [&Edge; 2]) -> [f64; 2] {
    if !surface.interfaces.has_friction(interface) {
        return [0.0; 2];
    }
    edges.map(|e| surface.interfaces.measure(interface, (e.half, e.scale)).0)
}

/// Wedges of the slave edge and of the other one, of folds only.
struct Folds {
    of: [Option<FoldWedge>; 2],
}

impl Folds {
    /// Wedges, with the directions in which the other edge lies if `normal` points to the slave's
    /// side.
    fn each(&self, normal: &V3) -> impl Iterator<Item = (&FoldWedge, V3)> {
        self.of.iter().zip([-normal, *normal]).filter_map(|(w, d)| Some((w.as_ref()?, d)))
    }

    /// Whether, for each fold, the other edge lies behind none of its segments.
    fn are_met_from(&self, normal: &V3) -> bool {
        self.each(normal).all(|(wedge, to)| wedge.arms.iter().all(|arm| to.dot(arm) <= CONE))
    }

    /// Whether two folds stand out towards each other.
    fn are_before(&self, normal: &V3) -> bool {
        /// Cosine between the direction of the other edge and that in which a fold stands out.
        const TOWARDS: f64 = 0.7;
        let out = |w: &FoldWedge| (w.arms[0] + w.arms[1]).try_normalize(0.0).map(|m| -m);
        self.of.iter().all(|w| w.is_some())
            && self.are_met_from(normal)
            && self.each(normal).all(|(wedge, to)| out(wedge).is_some_and(|o| o.dot(&to) > TOWARDS))
    }
}

/// Sign with which `normal`, at right angles to both edges, points out of the other one's solid and
/// into the first one's, as far as they are edges of solids. `None` where neither sign does.
fn facing(
    lines: &EdgeTable,
    surface: &Surface,
    nodes: &Nodes,
    edges: [&Edge; 2],
    normal: &V3,
) -> Option<f64> {
    let mut sign = 0.0;
    for (edge, out) in edges.into_iter().zip([-1.0, 1.0]) {
        if edge.kind != Kind::Solid {
            continue;
        }
        let &[one, two] = lines.segments(edge) else { return None };
        let [face, next] = [one, two].map(|g| surface.segments[g as usize].middle_normal(&nodes.x));
        let (face, next) = (face?, next?);
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
#[path = "edges_tests.rs"]
mod tests;
