//! Contact pairs of a step, own and others', and what nodes remember of them.
//!
//! A worker owns the pairs of the nodes that it owns, and of its edges (`edges.rs`). It learns of every other pair that
//! touches one of its local nodes, so that it can add up the contact force on each of them alone, in ascending order of the
//! pairs' names.

mod order;
pub mod quiet;

use crate::contact::enforce::Iteration;
use crate::contact::geometry::V3;
use crate::contact::surface::NOT_LOCAL;
use crate::halo::Halo;
use crate::nodes::{Nodes, Row, row, xyz};
use crate::rigid::Bodies;
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::{NodeId, SegmentId};
use crumple_proto::transport::{Lost, Tag, Transport};

/// A node that is held fixed counts as this many times the mass of the segment that it meets.
pub const HELD: f64 = 1e6;

/// What a pair is called wherever it is known. Pairs are in ascending order of it, on any number of workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
#[repr(C)]
pub struct Name {
    /// The node, or the node of the slave edge with the lower id.
    pub slave: NodeId,
    /// The other node of the slave edge; 0 where the slave is a node, as no edge has.
    pub far: NodeId,
    /// The segment and 0, or the nodes of the edge that is met, ascending.
    pub met: [u64; 2],
}

impl Name {
    /// A node on a segment.
    pub fn of_node(slave: NodeId, segment: SegmentId) -> Self {
        Self { slave, far: NodeId(0), met: [segment.0, 0] }
    }

    /// An edge on an edge, both by their nodes in ascending order.
    pub fn of_edges(slave: [NodeId; 2], other: [NodeId; 2]) -> Self {
        Self { slave: slave[0], far: slave[1], met: other.map(|n| n.0) }
    }

    /// The nodes of the slave edge and of the other one.
    pub fn edge_nodes(&self) -> [NodeId; 4] {
        [self.slave, self.far, NodeId(self.met[0]), NodeId(self.met[1])]
    }

    /// Whether the slave is an edge.
    pub fn is_edge(&self) -> bool {
        self.far != NodeId(0)
    }
}

/// A node on a segment, or a point of an edge (the slave edge) on a point of another one.
///
/// The local nodes of a pair have roles. A slave node has role 0, the segment's nodes 1 to 4. A slave edge has roles 0 and 1,
/// the other edge 2 and 3, and role 4 is empty. The force acts on the slave's roles by their shares, and with the opposite
/// sign on the others.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Which pair it is.
    pub name: Name,
    /// The segment, or the lowest one that has the edge which is met.
    pub segment: SegmentId,
    /// Local numbers of the nodes by role, or [`NOT_LOCAL`].
    pub nodes: [u32; 5],
    /// Shape values N_k of the contact point by role; they sum to 1 on either side.
    pub shape: [f64; 5],
    /// Shares of the nodes in the contact force by role; they sum to 1 on either side.
    pub weight: [f64; 5],
    /// Unit normal that points to the slave's side.
    pub normal: V3,
    /// Side of the slave along the segment's own normal, or the cross product of the two edges, +1 or -1.
    pub side: f64,
    /// Gap that the law is to close, tolerated penetration taken off [length].
    pub gap: f64,
    /// Penetration of the surfaces, negative when open [length].
    pub depth: f64,
    /// Penetration that is let be, 0 or negative [length].
    pub tolerated: f64,
    /// Length that gaps are judged by: the sum of the half thicknesses, or what stands for them where a side is a
    /// solid's ([`crate::contact::surface::Segment::scale`]) [length].
    pub thickness: f64,
    /// Force on the slave [force].
    pub force: V3,
    /// Tangential distance of the slave from its stick point [length].
    pub slip: V3,
    /// Relative velocity change per unit impulse, normal and tangential, with nodal masses split among their pairs.
    pub compliance: [f64; 2],
    /// Sum of the shares of all pairs that touch each of the five nodes, 0 where this one has none.
    pub crowd: [f64; 5],
    /// What is to be added to the force if the segment stands still, and the fraction of the correction that this pair
    /// gets, for laws that predict and correct [force].
    pub guess: V3,
    /// See `guess`.
    pub turn: f64,
    /// Mass of the slave along the normal, with what holds it [mass].
    pub mass: f64,
    /// Stiffness of the segment, for laws that have one for it [force/length].
    pub stiffness: f64,
    /// Whether the node's surface comes before the segment's, by part and then by segment.
    pub first: bool,
    /// Whether this worker owns the pair.
    pub own: bool,
}

/// What a slave remembers of a pair of the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memory {
    /// See [`Pair::name`].
    pub name: Name,
    /// See [`Pair::side`].
    pub side: f64,
    /// See [`Pair::tolerated`].
    pub tolerated: f64,
    /// See [`Pair::depth`].
    pub depth: f64,
    /// See [`Pair::normal`].
    pub normal: V3,
    /// See [`Pair::force`].
    pub force: V3,
    /// See [`Pair::slip`].
    pub slip: V3,
}

impl Memory {
    /// Words of a memory in a message.
    pub const WORDS: usize = 16;

    /// The remembered force turned to a new normal: same normal part, tangential part within the new tangent plane.
    pub fn force_along(&self, normal: &V3) -> V3 {
        let pressed = self.force.dot(&self.normal);
        let sheared = self.force - self.normal * pressed;
        normal * pressed.max(0.0) + (sheared - normal * normal.dot(&sheared))
    }

    /// The remembered slip within a new tangent plane.
    pub fn slip_along(&self, normal: &V3) -> V3 {
        self.slip - normal * normal.dot(&self.slip)
    }

    /// As words.
    pub fn to_words(&self) -> [u64; Self::WORDS] {
        let mut w = [0; Self::WORDS];
        w[..NAME_WORDS].copy_from_slice(bytemuck::cast_slice(std::slice::from_ref(&self.name)));
        let numbers = [self.side, self.tolerated, self.depth].into_iter();
        let vectors = [self.normal, self.force, self.slip];
        let all = numbers.chain(vectors.iter().flat_map(|v| [v.x, v.y, v.z]));
        w[NAME_WORDS..].iter_mut().zip(all).for_each(|(w, a)| *w = a.to_bits());
        w
    }

    /// The segment that a node met.
    pub fn segment(&self) -> SegmentId {
        SegmentId(self.name.met[0])
    }

    /// Whether it is of the slave's pair with a segment.
    pub fn is_of(&self, segment: SegmentId) -> bool {
        self.name.met == [segment.0, 0]
    }

    /// From [`Memory::to_words`].
    pub fn from_words(w: &[u64]) -> Self {
        let (name, rest) = w.split_at(NAME_WORDS);
        let at = |i: usize| f64::from_bits(rest[i]);
        let vector = |i: usize| V3::new(at(i), at(i + 1), at(i + 2));
        Self {
            name: bytemuck::pod_read_unaligned(bytemuck::cast_slice(name)),
            side: at(0),
            tolerated: at(1),
            depth: at(2),
            normal: vector(3),
            force: vector(6),
            slip: vector(9),
        }
    }
}

/// A pair as others need it.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct WirePair {
    name: Name,
    segment: SegmentId,
    nodes: [NodeId; 5],
    weight: [f64; 5],
    normal: [f64; 3],
    tolerated: f64,
    depth: f64,
    force: [f64; 3],
    mass: f64,
}
const NAME_WORDS: usize = size_of::<Name>() / 8;
/// Words of a pair in a message to others.
pub const WIRE_WORDS: usize = size_of::<WirePair>() / 8;

/// The pairs that one other worker and this one both know.
#[derive(Debug, Default)]
struct Common {
    worker: usize,
    /// Own pairs that the other knows, ascending.
    sent: Vec<u32>,
    /// The other's pairs, ascending.
    received: Vec<u32>,
}

/// All pairs that concern a worker in this step.
#[derive(Debug, Default)]
pub struct PairTable {
    /// Pairs in ascending order of their names.
    pub pairs: Vec<Pair>,
    /// Local nodes that a pair touches, ascending.
    pub touched: Vec<u32>,
    /// Contact force on each of `touched` [force].
    pub total: Vec<V3>,
    start: Vec<u32>,
    roles: Vec<(u32, u8)>,
    common: Vec<Common>,
    quiet: quiet::Quiet,
    order: order::Order,
    incidence: Vec<(u32, u32, u8)>,
    words: Vec<u64>,
}

impl PairTable {
    /// Tells other workers of own pairs and learns of theirs; `pairs` holds own ones, ascending, at the start.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn share(&mut self, wire: &mut dyn Transport, nodes: &Nodes, halo: &Halo) -> Result<(), Lost> {
        self.common.clear();
        for link in halo.links.iter().filter(|l| l.meets) {
            self.words.clear();
            let concerns =
                |p: &Pair| p.touching().any(|n| halo.users_of(n).binary_search(&(link.worker as u32)).is_ok());
            let sent: Vec<u32> =
                (0..self.pairs.len()).filter(|&i| concerns(&self.pairs[i])).map(|i| i as u32).collect();
            for &i in &sent {
                let p = WirePair::of(&self.pairs[i as usize], nodes);
                self.words.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(&p)));
            }
            wire.send(link.worker + 1, Tag::Pairs, &self.words)?;
            self.common.push(Common { worker: link.worker, sent, received: Vec::new() });
        }
        let own = self.pairs.len();
        let mut source = vec![(usize::MAX, 0u32); own];
        for (c, common) in self.common.iter_mut().enumerate() {
            wire.recv(common.worker + 1, Tag::Pairs, &mut self.words)?;
            for (k, words) in self.words.chunks_exact(WIRE_WORDS).enumerate() {
                self.pairs.push(bytemuck::pod_read_unaligned::<WirePair>(bytemuck::cast_slice(words)).pair(nodes));
                source.push((c, k as u32));
            }
        }
        if self.pairs.len() > own {
            self.sort(&source);
        }
        self.common.retain(|c| !c.sent.is_empty() || !c.received.is_empty());
        self.quiet.start(wire.rank() - 1, self.common.iter().map(|c| c.worker));
        self.index();
        Ok(())
    }

    /// Puts pairs in ascending order of their names; where each goes is noted in `common`.
    fn sort(&mut self, source: &[(usize, u32)]) {
        let mut order: Vec<u32> = (0..self.pairs.len() as u32).collect();
        order.sort_unstable_by_key(|&i| self.pairs[i as usize].name);
        let mut place = vec![0u32; order.len()];
        order.iter().enumerate().for_each(|(to, &from)| place[from as usize] = to as u32);
        self.pairs = order.iter().map(|&i| self.pairs[i as usize]).collect();
        for (c, common) in self.common.iter_mut().enumerate() {
            common.sent.iter_mut().for_each(|i| *i = place[*i as usize]);
            // A sender's pairs arrive in its ascending order, which is also the order here.
            let received = source.iter().enumerate().filter(|(_, s)| s.0 == c).map(|(from, _)| place[from]);
            common.received = received.collect();
        }
    }

    /// Which pairs touch which local node, ascending.
    fn index(&mut self) {
        self.incidence.clear();
        for (p, pair) in self.pairs.iter().enumerate() {
            let roles = pair.nodes.iter().enumerate().filter(|&(r, &n)| n != NOT_LOCAL && pair.share(r) != 0.0);
            self.incidence.extend(roles.map(|(r, &n)| (n, p as u32, r as u8)));
        }
        self.incidence.sort_unstable();
        self.touched.clear();
        self.start.clear();
        self.roles.clear();
        for &(n, p, r) in &self.incidence {
            if self.touched.last() != Some(&n) {
                self.touched.push(n);
                self.start.push(self.roles.len() as u32);
            }
            self.roles.push((p, r));
        }
        self.start.push(self.roles.len() as u32);
        self.total.clear();
        self.total.resize(self.touched.len(), V3::zeros());
    }

    /// Shares the forces of own pairs among their segments' nodes by mass, Wang et al. (2007), eq. 7 and 11:
    /// m_k / M2 = M_k N_k / sum_j M_j N_j. Edges keep their shape values. To be done before others are told.
    pub fn weigh_by_mass(&mut self, nodes: &Nodes) {
        for pair in self.pairs.iter_mut().filter(|p| p.own && !p.name.is_edge()) {
            let m: [f64; 4] =
                std::array::from_fn(|k| nodes.contact_mass(pair.nodes[k + 1] as usize) * pair.shape[k + 1]);
            let sum: f64 = m.iter().sum();
            if sum > 0.0 {
                pair.weight[1..].iter_mut().zip(m).for_each(|(w, a)| *w = a / sum);
            }
        }
    }

    /// Sets how softly own pairs answer. When all pairs are split, the mass of a node is divided among the pairs that touch it in
    /// proportion to their shares in it. That lets simultaneous updates converge whatever the masses: for shares w > 0 the
    /// matrix diag(w_p sum_q w_q) - w w^T has no negative eigenvalue (Gershgorin), so an update is damped by no less than
    /// the coupling. A pair whose share is of the size of round-off makes a difference of that size.
    /// With prediction and correction the masses of edges are split: a slave edge may be in several pairs, which do not see
    /// each other's corrections as pairs on one segment do.
    pub fn soften(&mut self, nodes: &Nodes, bodies: &Bodies, iteration: Iteration) {
        self.pairs.iter_mut().for_each(|p| p.crowd = [0.0; 5]);
        for t in 0..self.touched.len() {
            let roles = self.start[t] as usize..self.start[t + 1] as usize;
            let crowd = self.roles[roles.clone()].iter().map(|&(p, r)| self.pairs[p as usize].share(r as usize)).sum();
            for &(p, r) in &self.roles[roles] {
                self.pairs[p as usize].crowd[r as usize] = crowd;
            }
        }
        for pair in self.pairs.iter_mut().filter(|p| p.own) {
            let mut soft = [0.0; 2];
            let split = match iteration {
                Iteration::Split => true,
                Iteration::Correct { .. } => pair.name.is_edge(),
                Iteration::Jacobi | Iteration::GaussSeidel => false,
            };
            // In the order of roles: local numbers, and with them any other order, differ from worker to worker.
            for r in (0..5).filter(|&r| pair.crowd[r] > 0.0) {
                let inv = bodies.inv_mass(pair.nodes[r], nodes);
                // The nodes of a rigid body feel a sweep's forces together, when it is over.
                let together = split || bodies.of(pair.nodes[r]).is_some();
                let moved = if together { pair.crowd[r] } else { pair.share(r) } * pair.follows(r);
                let n = &pair.normal;
                soft[0] += moved * (n.x * n.x * inv[0] + n.y * n.y * inv[1] + n.z * n.z * inv[2]);
                soft[1] += moved * inv[0].max(inv[1]).max(inv[2]);
            }
            pair.compliance = soft;
        }
    }

    /// Adds up the contact force on every touched node.
    pub fn add_up(&mut self) {
        for t in 0..self.touched.len() {
            self.total[t] = self.force_at(t);
        }
    }

    /// Pairs that touch the node at place `t` of `touched`, ascending, and its role in each.
    fn roles_at(&self, t: usize) -> &[(u32, u8)] {
        &self.roles[self.start[t] as usize..self.start[t + 1] as usize]
    }

    /// Sum of the forces of all pairs on the node at place `t` of `touched` [force].
    fn force_at(&self, t: usize) -> V3 {
        let mut sum = V3::zeros();
        for &(p, r) in self.roles_at(t) {
            let pair = &self.pairs[p as usize];
            let part = pair.force * pair.share(r as usize);
            if pair.is_ahead(r) { sum += part } else { sum -= part }
        }
        sum
    }

    /// Shares of the guesses, and of the masses of the slaves that they are for, which the node at place `t` of `touched`
    /// takes as a node of what slaves meet [force], [mass].
    pub fn pressed_on(&self, t: usize) -> (V3, f64) {
        let (mut force, mut mass) = (V3::zeros(), 0.0);
        for &(p, r) in self.roles_at(t) {
            let pair = &self.pairs[p as usize];
            if !pair.is_ahead(r) && pair.guess != V3::zeros() {
                force += pair.guess * pair.share(r as usize);
                mass += pair.mass * pair.share(r as usize);
            }
        }
        (force, mass)
    }

    /// Whether a node of what the own pair's slave meets is itself a slave that is pushed back from the pair's side.
    pub fn is_mutual(&self, pair: &Pair) -> bool {
        let places = (pair.ahead()..5).filter(|&r| pair.share(r) != 0.0);
        let places = places.filter_map(|r| self.touched.binary_search(&pair.nodes[r]).ok());
        let mut slaves = places.flat_map(|t| self.roles_at(t)).filter(|&&(q, r)| self.pairs[q as usize].is_ahead(r));
        slaves.any(|&(q, _)| (self.pairs[q as usize].force + self.pairs[q as usize].guess).dot(&pair.normal) < 0.0)
    }

    /// Whether other workers know some of these pairs.
    pub fn is_common(&self) -> bool {
        !self.common.is_empty()
    }

    /// Exchanges the forces of pairs that several workers know, after a sweep that has `changed` an own one or not. Returns
    /// whether all that have pairs in common, one with the next, are quiet.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn swap_forces(&mut self, wire: &mut dyn Transport, changed: bool) -> Result<bool, Lost> {
        self.quiet.note(changed);
        let mut quiet = std::mem::take(&mut self.quiet);
        self.swap(wire, Some(&mut quiet), |pair| &mut pair.force)?;
        quiet.close();
        self.quiet = quiet;
        Ok(self.quiet.is_over())
    }

    /// Exchanges the guesses of pairs that several workers know.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn swap_guesses(&mut self, wire: &mut dyn Transport) -> Result<(), Lost> {
        self.swap(wire, None, |pair| &mut pair.guess)
    }

    fn swap(
        &mut self,
        wire: &mut dyn Transport,
        mut quiet: Option<&mut quiet::Quiet>,
        of: fn(&mut Pair) -> &mut V3,
    ) -> Result<(), Lost> {
        for c in &self.common {
            self.words.clear();
            if let Some(quiet) = &quiet {
                quiet.write(&mut self.words);
            }
            for &i in &c.sent {
                let f = of(&mut self.pairs[i as usize]);
                self.words.extend([f.x, f.y, f.z].map(f64::to_bits));
            }
            wire.send(c.worker + 1, Tag::Sweep, &self.words)?;
        }
        for c in &self.common {
            wire.recv(c.worker + 1, Tag::Sweep, &mut self.words)?;
            let forces = quiet.as_mut().map_or(&self.words[..], |q| q.read(&self.words));
            for (&i, f) in c.received.iter().zip(forces.chunks_exact(3)) {
                *of(&mut self.pairs[i as usize]) =
                    V3::new(f64::from_bits(f[0]), f64::from_bits(f[1]), f64::from_bits(f[2]));
            }
        }
        Ok(())
    }
}

impl Pair {
    /// With the gap between the surfaces [length] and what is remembered of the pair: the force and the slip from the stick
    /// point, turned to its normal, and the penetration that is let be, 0 or negative [length].
    pub fn remembering(self, old: Option<&Memory>, gap: f64, tolerated: f64) -> Self {
        Self {
            gap: gap - tolerated,
            depth: -gap,
            tolerated,
            force: old.map_or(V3::zeros(), |m| m.force_along(&self.normal)),
            slip: old.map_or(V3::zeros(), |m| m.slip_along(&self.normal)),
            ..self
        }
    }

    /// A pair of which no more is known.
    pub fn unknown(name: Name, segment: SegmentId, nodes: [u32; 5]) -> Self {
        Self {
            name,
            segment,
            nodes,
            shape: [0.0; 5],
            weight: [0.0; 5],
            normal: V3::zeros(),
            side: 0.0,
            gap: 0.0,
            depth: 0.0,
            tolerated: 0.0,
            thickness: 0.0,
            force: V3::zeros(),
            slip: V3::zeros(),
            compliance: [0.0; 2],
            crowd: [0.0; 5],
            guess: V3::zeros(),
            turn: 1.0,
            mass: 0.0,
            stiffness: 0.0,
            first: false,
            own: false,
        }
    }

    /// Number of roles on the slave's side.
    fn ahead(&self) -> usize {
        if self.name.is_edge() { 2 } else { 1 }
    }

    /// Whether role `r` is on the slave's side.
    fn is_ahead(&self, r: u8) -> bool {
        usize::from(r) < self.ahead()
    }

    /// Share of the pair's force that the node in role `r` takes.
    fn share(&self, r: usize) -> f64 {
        self.weight[r]
    }

    /// How far the point on its side follows the node in role `r`.
    fn follows(&self, r: usize) -> f64 {
        self.shape[r]
    }

    /// Share of the own pair's correction where both surfaces are slaves of each other: `partition` for the first one, the
    /// rest for the other.
    pub fn turn_of(&self, partition: f64) -> f64 {
        if self.first { partition } else { 1.0 - partition }
    }

    /// Notes the slave's mass along the normal; own pairs only.
    pub fn weigh_slave(&mut self, nodes: &Nodes) {
        let met = self.nodes[self.ahead()..].iter().filter(|&&n| n != NOT_LOCAL);
        let segment: f64 = met.map(|&n| nodes.contact_mass(n as usize)).sum();
        let n = &self.normal;
        let moves = |r: usize| {
            let inv = &nodes.inv_mass[self.nodes[r] as usize];
            self.share(r) * self.follows(r) * (n.x * n.x * inv[0] + n.y * n.y * inv[1] + n.z * n.z * inv[2])
        };
        let moves: f64 = (0..self.ahead()).map(moves).sum();
        self.mass = if moves * HELD * segment > 1.0 { 1.0 / moves } else { HELD * segment };
    }

    /// Local nodes that the pair's force acts on.
    pub fn touching(&self) -> impl Iterator<Item = u32> + '_ {
        self.nodes.iter().enumerate().filter(|&(r, _)| self.share(r) != 0.0).map(|(_, &n)| n)
    }

    /// Velocity of the slave, own pairs only [length/time].
    pub fn slave_velocity(&self, v: &[Row]) -> V3 {
        let at = |r: usize| V3::from(xyz(&v[self.nodes[r] as usize]));
        if self.name.is_edge() { at(0) * self.shape[0] + at(1) * self.shape[1] } else { at(0) }
    }

    /// Velocity of the slave relative to the contact point, own pairs only [length/time].
    pub fn relative_velocity(&self, v: &[Row]) -> V3 {
        let part = |r: usize| V3::from(xyz(&v[self.nodes[r] as usize])) * self.shape[r];
        let point = if self.name.is_edge() { part(2) + part(3) } else { part(1) + part(2) + part(3) + part(4) };
        self.slave_velocity(v) - point
    }

    /// What the slave remembers of this pair.
    pub fn memory(&self) -> Memory {
        Memory {
            name: self.name,
            side: self.side,
            tolerated: self.tolerated,
            depth: self.depth,
            normal: self.normal,
            force: self.force,
            slip: self.slip,
        }
    }
}

impl WirePair {
    fn of(p: &Pair, nodes: &Nodes) -> Self {
        let id = |n: u32| if n == NOT_LOCAL { NodeId(u64::MAX) } else { nodes.id[n as usize] };
        Self {
            name: p.name,
            segment: p.segment,
            nodes: p.nodes.map(id),
            weight: p.weight,
            normal: p.normal.into(),
            tolerated: p.tolerated,
            depth: p.depth,
            force: p.force.into(),
            mass: p.mass,
        }
    }

    fn pair(&self, nodes: &Nodes) -> Pair {
        let local = |id: NodeId| nodes.number(id).unwrap_or(NOT_LOCAL);
        Pair {
            weight: self.weight,
            normal: self.normal.into(),
            tolerated: self.tolerated,
            depth: self.depth,
            force: self.force.into(),
            mass: self.mass,
            ..Pair::unknown(self.name, self.segment, self.nodes.map(local))
        }
    }
}

/// Adds impulse `force * dt` to a velocity row.
pub fn push(v: &Row, force: &V3, inv_mass: &Row, dt: f64) -> Row {
    let f = row([force.x, force.y, force.z]);
    std::array::from_fn(|c| v[c] + dt * f[c] * inv_mass[c])
}
