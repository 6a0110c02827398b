//! Contact of edges with edges. It covers contact between the nodes, which the local search of
//! nodes does not see. Beams are edges too.
//!
//! Only exposed edges take part (`folds.rs`). A pair is a point of one edge, the slave, on a
//! point of another edge. The points are where the two edges are nearest to each other, between
//! their ends. The ends are nodes and belong to the local search of nodes. The edge with the
//! lower nodes is the slave, so that no pair exists twice.
//!
//! The set of exposed edges changes as surfaces fold. It is updated after a fixed number of
//! cycles. An existing contact lasts as long as it touches, however flat its fold becomes.
//!
//! A worker owns the edges for whose lowest segment it searches. Its ghosts reach as far around the
//! nodes of these edges as around its slaves ([`contact_edges`]). Therefore it has all segments
//! that contain an edge which an own edge could touch, and it can find the kind of that edge.
//!
//! The normal is the cross product of the edges. For shells its sign is the side on which the
//! edges were when they first came near each other. The step is short enough to see this before
//! they pass through each other (`reduction.rs`). A fold is touched from its outside: seen from
//! the fold, the other edge lies behind none of its segments. Edges that are only just in
//! contact are accepted from either side. A solid's edge is touched from where its two faces
//! look: the normal lies between their normals, as on the Gauss image of a polyhedron.
//!
//! An edge that slides along a row of edges keeps the history of its pair with the last one.
//! This pair may have belonged to another worker. Therefore the history of all pairs that are
//! known here is stored, not only of own pairs. A pair that is lost while it is deep keeps its
//! history for some more steps ([`PairHistory::after_loss`]).

use crate::approach;
use crate::edge_sides::{facing, may_begin, side_of_folds};
use crate::folds::{Edge, EdgeTable, Kind};
use crate::friction;
use crate::geometry::{EdgeProjection, project_edges, separation};
use crate::kernels::{self, Vector};
use crate::local_search::{is_in_middle, moved, tolerated};
use crate::pairs::{Pair, PairHistory, PairKey, padded};
use crate::reach::{ACTIVE, REACH};
use crate::search::{Search, accepted};
use crate::shell_offset;
use crate::surface::{NOT_LOCAL, Surface};
use crate::surroundings::Exclusions;
use crate::waiting::Waiting;
use crumple_fem::nodes::Nodes;
use crumple_math::lanes::{LANES, Lane, Lanes, Real};
use crumple_math::row::{V3, xyz};
use crumple_math::threads::{self, joined, ranges};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::NodeId;
use std::ops::Range;

/// Product of normals above which the histories of successive edges belong to the same contact.
const ALIKE: f64 = 0.7;
/// Fraction of the angle of an exposed fold from which on edges are included in the search.
/// Without it each edge that becomes exposed would request a new search.
const NEARLY: f64 = 0.7;
/// Least number of candidates that a thread examines at a time.
const PIECE: usize = 256;

/// Returns all nodes of own segments, possibly several times. The edges between them may become
/// exposed, whatever segments of other workers adjoin them, and the segments themselves may
/// touch others. `surface` has own segments only.
pub fn contact_edges(surface: &Surface) -> Vec<u32> {
    surface.segments.iter().flat_map(|s| s.nodes).collect()
}

/// History of a pair of edges.
#[derive(Clone, Copy, Debug)]
struct EdgePairHistory {
    memory: PairHistory,
    /// Local nodes by role, or [`NOT_LOCAL`].
    nodes: [u32; 4],
    /// True if this worker searches for the lowest segment of the slave edge.
    own: bool,
}

/// Two edges that are near, by their indices: the slave edge and the other edge.
#[derive(Clone, Copy, Debug)]
struct EdgeCandidate {
    edges: [u32; 2],
    /// Local nodes of both.
    nodes: [[u32; 2]; 2],
    /// Distance beyond which they do not touch in a step [length].
    reach: f64,
}

/// Edges known to a worker, and the pair histories of its own edges.
#[derive(Debug, Default)]
pub struct Edges {
    lines: EdgeTable,
    /// For each edge, true if it is exposed.
    out: Vec<bool>,
    /// For each edge, true if it is exposed or nearly exposed.
    nearly: Vec<bool>,
    /// For each edge, true if it was included in the last search: it was exposed or nearly
    /// exposed then, or it had a history.
    searched: Vec<bool>,
    /// True if an edge is exposed that the last search did not include.
    stale: bool,
    /// Indices of own edges.
    own: Vec<u32>,
    /// Slave edge and other edge of all pairs that could touch before the next search, in
    /// ascending order of their keys.
    found: Vec<[u32; 2]>,
    /// Those of `found` that are near.
    candidates: Vec<EdgeCandidate>,
    /// Candidates that are out of reach.
    waiting: Waiting,
    /// Indices of the candidates that may be within reach.
    due: Vec<u32>,
    /// Histories in ascending order of their keys.
    memories: Vec<EdgePairHistory>,
    /// Nodes of the histories, ascending, with the indices of the histories.
    by_node: Vec<(NodeId, u32)>,
    /// True if the histories are as they were collected, with no step since then. They are then
    /// equal on all workers that have them.
    gathered: bool,
    /// True if only beams touch other edges.
    of_beams: bool,
}

impl Edges {
    /// Builds the edges of a new surface and collects the histories at their nodes. With
    /// `of_beams` each pair has at least one beam.
    pub fn new(
        surface: &Surface,
        nodes: &Nodes,
        memory_of: impl Fn(NodeId) -> Vec<PairHistory>,
        of_beams: bool,
    ) -> Self {
        let lines = EdgeTable::new(surface, nodes);
        let is_own = |e: &Edge| lines.lowest_segment(e, surface).searched;
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

    /// Returns the lowest segment that has the edge between these local nodes; `nodes` are in
    /// the order of [`Edge::nodes`].
    pub fn segment_of(&self, nodes: [u32; 2]) -> Option<u32> {
        self.lines.place(nodes).map(|i| self.lines.segments(&self.lines.all[i])[0])
    }

    /// Returns the number of bytes in use.
    pub fn bytes(&self) -> usize {
        self.lines.bytes()
            + size_of_val(&self.own[..])
            + size_of_val(&self.found[..])
            + size_of_val(&self.candidates[..])
            + self.waiting.bytes()
            + size_of_val(&self.due[..])
    }

    /// Updates the set of exposed edges, with the nodes at [`Nodes::seen`].
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

    /// Returns true if a new search is necessary although nodes have not moved.
    pub fn is_stale(&self) -> bool {
        self.stale
    }

    /// Returns for each edge true if it could touch others: it is exposed or nearly exposed, or
    /// it has a history.
    fn ready(&self) -> Vec<bool> {
        let mut ready = self.nearly.clone();
        for [i, j, k, l] in self.memories.iter().map(|r| r.nodes) {
            let places = [[i, j], [k, l]].into_iter().filter_map(|e| self.lines.place(e));
            places.for_each(|p| ready[p] = true);
        }
        ready
    }

    /// Finds the pairs of an own edge and another edge that could touch before nodes have moved
    /// by more than `skin` against each other [length]. [`Self::pick`] must follow.
    pub fn search(
        &mut self,
        surface: &Surface,
        nodes: &Nodes,
        joined: &dyn Exclusions,
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
        let largest = of_own.iter().map(|b| b.scale).fold(0.0, f64::max);
        let middles: Vec<[f64; 3]> = of_own.iter().map(|b| b.middle.into()).collect();
        let added = surface.shift_reach() + skin;
        let reach = |a: f64, b: f64| REACH * surface.interfaces.most(a + b) + added;
        let grown =
            |i: &u32| edge(*i).bounds(&nodes.x).grown(reach(edge(*i).scale, largest) + longest);
        let boxes: Vec<Aabb> = all.iter().map(grown).collect();
        let may_meet = |b: u32, p: u32| {
            let (one, two) = (&of_own[p as usize], &of_all[b as usize]);
            let reach = reach(one.scale, two.scale);
            // Neither test is easy to predict: one branch for both.
            if (one.ids >= two.ids) | one.is_farther(two, reach) {
                return false;
            }
            let (slave, met) = (edge(own[p as usize]), edge(all[b as usize]));
            let [j, k] = met.nodes;
            (!self.of_beams || slave.kind == Kind::Beam || met.kind == Kind::Beam)
                && !lines.has_adjacent(slave, surface, &met.nodes)
                && !lines.has_adjacent(met, surface, &slave.nodes)
                && are_within(slave, met, nodes, reach)
                && !joined.excludes(slave.nodes[0], &[slave.nodes[1], j, k, k])
                && !joined.are_tied(slave.nodes[1], &[j, k, k, k])
                && lines.interface([slave, met], surface).is_some()
        };
        let found = accepted(find, &boxes, &middles, may_meet);
        self.found = found.into_iter().map(|[b, p]| [own[p as usize], all[b as usize]]).collect();
        self.found.sort_by_cached_key(|c| c.map(|i| edge(i).ids(nodes)));
    }

    /// Selects from the pairs found those that could touch in a step. In such a step nodes move
    /// by at most `step` against each other [length]. The selection is valid until they have
    /// moved by more than `skin` [length].
    pub fn pick(&mut self, nodes: &Nodes, surface: &Surface, (skin, step): (f64, f64)) {
        self.candidates.clear();
        self.waiting.restart(0);
        if self.found.is_empty() {
            return;
        }
        let near = |pair: &[u32; 2]| {
            let [a, b] = pair.map(|i| &self.lines.all[i as usize]);
            let most = |sum| surface.interfaces.most(sum);
            let scale = most(a.scale + b.scale);
            let near = most(a.half + b.half) + ACTIVE * scale;
            let deepest =
                if [a, b].iter().any(|e| e.kind == Kind::Solid) { REACH * scale } else { near };
            let reach = near.max(deepest) + step + surface.shift_reach();
            let is_near = a.bounds(&nodes.x).grown(reach + skin).intersects(&b.bounds(&nodes.x))
                && are_within(a, b, nodes, reach + skin);
            let nodes = [a.nodes, b.nodes];
            is_near.then_some(EdgeCandidate { edges: *pair, nodes, reach })
        };
        let of_range = |range: Range<usize>| self.found[range].iter().filter_map(near).collect();
        self.candidates = joined(threads::map(ranges(self.found.len(), PIECE), of_range));
        self.waiting.restart(self.candidates.len());
    }

    /// Returns the largest approach rate, as [`approach::rate`], of all pairs found [1/time].
    pub fn approach_rate(&self, nodes: &Nodes, surface: &Surface, (time, dt): (f64, f64)) -> f64 {
        let rate = |[a, b]: [&Edge; 2]| {
            let interface = self
                .lines
                .interface([a, b], surface)
                .filter(|&i| !surface.interfaces.is_over(i, time));
            let Some(interface) = interface else { return 0.0 };
            let scale = sizes(surface, interface, [a, b]).1;
            let speed = approach::speed(nodes, &a.nodes, &b.nodes);
            let reach = REACH * scale + surface.shift_reach() + approach::STEPS * dt * speed;
            if are_within(a, b, nodes, reach) { speed / scale } else { 0.0 }
        };
        self.found.iter().map(|c| rate(c.map(|i| &self.lines.all[i as usize]))).fold(0.0, f64::max)
    }

    /// Returns for each candidate a node of the slave edge and a segment that has the other
    /// edge.
    pub fn near(&self) -> impl Iterator<Item = (u32, u32)> {
        let edges = self.candidates.iter().map(|c| c.edges.map(|i| &self.lines.all[i as usize]));
        edges.map(|[a, b]| (a.nodes[0], self.lines.segments(b)[0]))
    }

    /// Appends the active pairs of own edges in this step to `out`, in ascending order of their
    /// keys. `stiffness` is per segment, or empty; a pair has the stiffness of its softer side.
    /// `dt` is the step size [time], `path` the path of the nodes so far [length].
    pub fn find_pairs(
        &mut self,
        nodes: &Nodes,
        (surface, alive): (&Surface, &[bool]),
        stiffness: &[f64],
        (dt, path): (f64, f64),
        out: &mut Vec<Pair>,
    ) {
        let mut due = std::mem::take(&mut self.due);
        let mut waiting = std::mem::take(&mut self.waiting);
        waiting.find_due(path, &mut due);
        let found = threads::map(ranges(due.len(), PIECE), |range| {
            let (mut pairs, mut deferred) = (Vec::new(), Vec::new());
            for some in due[range].chunks(LANES) {
                let beyond = self.distances_beyond_reach(some, nodes);
                for (&i, beyond) in some.iter().zip(beyond) {
                    if beyond > 0.0 {
                        deferred.push((i, path + beyond));
                    } else {
                        pairs.extend(self.pair_of(i, nodes, (surface, alive), stiffness, dt));
                    }
                }
            }
            (pairs, deferred)
        });
        for (pairs, deferred) in found {
            out.extend(pairs);
            deferred.into_iter().for_each(|(i, until)| waiting.defer(i, until));
        }
        waiting.update_blocks(&due);
        (self.due, self.waiting) = (due, waiting);
    }

    /// Returns by how much the distance of the edges of up to [`LANES`] candidates, given by their
    /// indices, exceeds their reach [length].
    fn distances_beyond_reach(&self, some: &[u32], nodes: &Nodes) -> [f64; LANES] {
        let four: [&EdgeCandidate; LANES] =
            std::array::from_fn(|lane| &self.candidates[some[lane.min(some.len() - 1)] as usize]);
        let ends = [0, 1].map(|edge| {
            [0, 1].map(|end| {
                let at = |c: &EdgeCandidate| Lane::new(nodes.x[c.nodes[edge][end] as usize]);
                Vector(Lane::from_rows(four.map(at)))
            })
        });
        let distance = Real::sqrt(kernels::separation(&ends[0], &ends[1]));
        (distance - Lane::new(four.map(|c| c.reach))).to_array()
    }

    /// Returns the pair of a candidate, given by its index, if it is active in this step.
    fn pair_of(
        &self,
        candidate: u32,
        nodes: &Nodes,
        (surface, alive): (&Surface, &[bool]),
        stiffness: &[f64],
        dt: f64,
    ) -> Option<Pair> {
        let places = self.candidates[candidate as usize].edges;
        let edges = places.map(|i| &self.lines.all[i as usize]);
        let met = project_edges(&edges[0].ends(&nodes.x), &edges[1].ends(&nodes.x))?;
        let interface = self.lines.interface(edges, surface).filter(|&i| alive[i as usize])?;
        let pair = self.evaluate_pair(nodes, (surface, interface), places, &met, dt)?;
        let of =
            |e: &Edge| stiffness.get(self.lines.segments(e)[0] as usize).copied().unwrap_or(0.0);
        Some(Pair { stiffness: of(edges[0]).min(of(edges[1])), ..pair })
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
        let shifts = edges.map(|e| lines.shift(e, (surface, interface), &nodes.x));
        let of_nodes = met.height;
        let met = &met.shifted(&shifts);
        let [one, other] = edges;
        let (thickness, scale) = sizes(surface, interface, edges);
        let near = thickness + ACTIVE * scale;
        // Shells that are through by more than the thickness are lost. Solids have no other
        // side.
        let solid = edges.iter().any(|e| e.kind == Kind::Solid);
        let deepest = if solid { REACH * scale } else { near };
        let ([i, j], [k, l]) = (edges[0].nodes, edges[1].nodes);
        let [s, t] = met.along;
        // Most candidates are too far away on either side.
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
        // The tolerated gap is at most 0: without it the pair is at its nearest.
        if met.height * side + dt * opening * side >= near || met.height * side < -deepest {
            return None;
        }
        if !stays && !places.iter().all(|&i| self.out[i as usize]) {
            return None;
        }
        if old.is_none() {
            side = side_of_folds((lines, nodes, surface), edges, met, (thickness, scale), side)?;
        }
        let (normal, gap) = (met.normal * side, met.height * side - thickness);
        if old.is_none() && !may_begin(nodes, edges, met, (gap, scale), solid) {
            return None;
        }
        let [one, two] = edges.map(|e| lines.lowest_segment(e, surface));
        let shape = padded([1.0 - s, s, 1.0 - t, t]);
        let pair = Pair {
            shape,
            weight: shape,
            normal,
            side,
            edge_area: friction::edge_area((surface, interface), edges, &nodes.x),
            lever_arms: levers((surface, interface), edges, &shifts, (&normal, of_nodes * side)),
            interface,
            contact_thickness: scale,
            speed: surface.slower(one.part, two.part),
            slave_surface_first: (one.part, one.id) < (two.part, two.id),
            is_owned: true,
            ..Pair::new(name, two.id, [i, j, k, l])
        };
        let tolerated = tolerated(old.as_ref(), gap, moved, dt, pair.speed);
        let pair = pair.with_history(old.as_ref(), gap, tolerated);
        // Also with history: a turned normal has carried them there, and nothing keeps edges from
        // passing each other then.
        if !solid && is_in_middle(&pair, thickness) {
            return None;
        }
        let predicted = pair.gap + dt * opening * side;
        (predicted < ACTIVE * scale).then_some(pair)
    }

    /// Returns the history of a pair. If it has none, returns the history of a pair that it
    /// continues, without the slip. `normal` is along the cross product of the edges.
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
        // Existing contact comes before lost contact, then the order of the keys decides.
        let before =
            at(a).chain(at(b)).filter_map(follows).min_by_key(|&(age, place, _)| (age, place));
        before.map(|(_, _, m)| m)
    }

    /// Stores the history of all pairs of a step that are known here, and keeps the history of
    /// lost pairs for some steps.
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
                // Pairs from other workers have no side, and lost pairs need none.
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

    /// Returns the histories of own edges, once for each local node of the pair. It also returns
    /// the histories of other workers' edges if the pair is lost or if no step has passed since
    /// they were collected: such an edge may have no owner any more.
    pub fn pair_histories(&self) -> impl Iterator<Item = (u32, &PairHistory)> {
        let sent = self.memories.iter().filter(|r| r.own || self.gathered || r.memory.age > 0);
        sent.flat_map(|r| r.nodes.map(|n| (n, &r.memory))).filter(|(n, _)| *n != NOT_LOCAL)
    }
}

/// Sphere around an edge.
struct EdgeBar {
    middle: V3,
    half: f64,
    /// See [`Edge::scale`].
    scale: f64,
    /// Ids of its nodes.
    ids: [NodeId; 2],
}

impl EdgeBar {
    fn new(edge: &Edge, nodes: &Nodes) -> Self {
        let (middle, half) = sphere(&edge.ends(&nodes.x));
        Self { middle, half, scale: edge.scale, ids: edge.ids(nodes) }
    }

    /// Returns true if another edge is certainly farther away than `reach` [length].
    fn is_farther(&self, other: &Self, reach: f64) -> bool {
        are_farther((self.middle, self.half), (other.middle, other.half), reach)
    }
}

/// Returns middle and radius of the sphere around an edge between these points [length].
fn sphere([p, q]: &[V3; 2]) -> (V3, f64) {
    ((p + q) * 0.5, 0.5 * (q - p).norm())
}

/// Returns true if two spheres, by middle and radius, are farther apart than `reach` [length].
fn are_farther((one, r): (V3, f64), (two, q): (V3, f64), reach: f64) -> bool {
    let apart = r + q + reach;
    (one - two).norm_squared() > apart * apart
}

/// Returns true if the distance of two edges is at most `reach` [length].
fn are_within(a: &Edge, b: &Edge, nodes: &Nodes, reach: f64) -> bool {
    separation(&a.ends(&nodes.x), &b.ends(&nodes.x)) <= reach * reach
}

/// Returns the sum of the half thicknesses of two edges in an interface, and the sum of their
/// scales [length].
fn sizes(surface: &Surface, interface: u16, edges: [&Edge; 2]) -> (f64, f64) {
    let [a, b] = edges.map(|e| surface.interfaces.measure(interface, (e.half, e.scale)));
    (a.0 + b.0, a.1 + b.1)
}

/// Returns the lever arms of friction on two edges, in proportion to each other: their half
/// thicknesses, or zero without friction [length]. `shifts` are those of the edges, `apart` is
/// their distance along the pair's normal.
fn levers(
    (surface, interface): (&Surface, u16),
    edges: [&Edge; 2],
    shifts: &[V3; 2],
    (normal, apart): (&V3, f64),
) -> [f64; 2] {
    if !surface.interfaces.has_friction(interface) {
        return [0.0; 2];
    }
    let halves = edges.map(|e| surface.interfaces.measure(interface, (e.half, e.scale)).0);
    if *shifts == [V3::zeros(); 2] {
        return halves;
    }
    let towards = [-shifts[0].dot(normal), shifts[1].dot(normal)];
    shell_offset::lever_arms(halves, towards, apart, [1.0; 2])
}

#[cfg(test)]
#[path = "edges_tests.rs"]
mod tests;
