//! Contact pairs of a step, own and others', and what nodes remember of them.
//!
//! A worker owns the pairs of the nodes that it owns. It learns of every other pair that touches one of its local
//! nodes, so that it can add up the contact force on each of them alone, in ascending (node, segment).

mod order;

use crate::contact::geometry::V3;
use crate::contact::surface::NOT_LOCAL;
use crate::halo::Halo;
use crate::nodes::{Nodes, Row, row};
use crate::rigid::Bodies;
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::{NodeId, SegmentId};
use crumple_proto::transport::{Lost, Tag, Transport};

/// A node that is held fixed counts as this many times the mass of the segment that it meets.
pub const HELD: f64 = 1e6;

/// A node on a segment.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// The node.
    pub slave: NodeId,
    /// The segment.
    pub segment: SegmentId,
    /// Local numbers of the node and the segment's four, or [`NOT_LOCAL`].
    pub nodes: [u32; 5],
    /// Shape values N_k of the contact point.
    pub shape: [f64; 4],
    /// Shares of the segment's nodes in the contact force; they sum to 1.
    pub weight: [f64; 4],
    /// Unit normal that points to the node's side.
    pub normal: V3,
    /// Side of the node along the segment's own normal, +1 or -1.
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
    /// Force on the node [force].
    pub force: V3,
    /// Tangential distance of the node from its stick point [length].
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
    /// Mass of the node along the normal, with what holds it [mass].
    pub mass: f64,
    /// Stiffness of the segment, for laws that have one for it [force/length].
    pub stiffness: f64,
    /// Whether the node's surface comes before the segment's, by part and then by segment.
    pub first: bool,
    /// Whether this worker owns the pair.
    pub own: bool,
}

/// What a node remembers of a pair of the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memory {
    /// The segment.
    pub segment: SegmentId,
    /// See [`Pair::side`].
    pub side: f64,
    /// See [`Pair::tolerated`].
    pub tolerated: f64,
    /// See [`Pair::normal`].
    pub normal: V3,
    /// See [`Pair::force`].
    pub force: V3,
    /// See [`Pair::slip`].
    pub slip: V3,
}

impl Memory {
    /// Words of a memory in a message.
    pub const WORDS: usize = 12;

    /// The remembered force turned to a new normal: same normal part, tangential part within the new tangent plane.
    pub fn force_along(&self, normal: &V3) -> V3 {
        let pressed = self.force.dot(&self.normal);
        let sheared = self.force - self.normal * pressed;
        normal * pressed.max(0.0) + (sheared - normal * normal.dot(&sheared))
    }

    /// As words.
    pub fn to_words(&self) -> [u64; Self::WORDS] {
        let mut w = [0; Self::WORDS];
        w[0] = self.segment.0;
        let numbers = [self.side, self.tolerated].into_iter();
        let vectors = [self.normal, self.force, self.slip];
        let all = numbers.chain(vectors.iter().flat_map(|v| [v.x, v.y, v.z]));
        w[1..].iter_mut().zip(all).for_each(|(w, a)| *w = a.to_bits());
        w
    }

    /// From [`Memory::to_words`].
    pub fn from_words(w: &[u64]) -> Self {
        let at = |i: usize| f64::from_bits(w[i]);
        let vector = |i: usize| V3::new(at(i), at(i + 1), at(i + 2));
        Self {
            segment: SegmentId(w[0]),
            side: at(1),
            tolerated: at(2),
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
    slave: NodeId,
    segment: SegmentId,
    nodes: [NodeId; 4],
    weight: [f64; 4],
    force: [f64; 3],
    mass: f64,
}
const WIRE_WORDS: usize = size_of::<WirePair>() / 8;

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
    /// Pairs in ascending (node, segment).
    pub pairs: Vec<Pair>,
    /// Local nodes that a pair touches, ascending.
    pub touched: Vec<u32>,
    /// Contact force on each of `touched` [force].
    pub total: Vec<V3>,
    start: Vec<u32>,
    roles: Vec<(u32, u8)>,
    common: Vec<Common>,
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
        self.index();
        Ok(())
    }

    /// Puts pairs in ascending (node, segment); where each goes is noted in `common`.
    fn sort(&mut self, source: &[(usize, u32)]) {
        let mut order: Vec<u32> = (0..self.pairs.len() as u32).collect();
        order.sort_unstable_by_key(|&i| (self.pairs[i as usize].slave, self.pairs[i as usize].segment));
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

    /// Which pairs touch which local node, in ascending (node, segment).
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
    /// m_k / M2 = M_k N_k / sum_j M_j N_j. To be done before others are told.
    pub fn weigh_by_mass(&mut self, nodes: &Nodes) {
        for pair in self.pairs.iter_mut().filter(|p| p.own) {
            let m: [f64; 4] = std::array::from_fn(|k| nodes.mass[pair.nodes[k + 1] as usize] * pair.shape[k]);
            let sum: f64 = m.iter().sum();
            if sum > 0.0 {
                pair.weight = m.map(|a| a / sum);
            }
        }
    }

    /// Sets how softly own pairs answer. With `split`, the mass of a node is divided among the pairs that touch it in
    /// proportion to their shares in it. That lets simultaneous updates converge whatever the masses: for shares w > 0 the
    /// matrix diag(w_p sum_q w_q) - w w^T has no negative eigenvalue (Gershgorin), so an update is damped by no less than
    /// the coupling. A pair whose share is of the size of round-off makes a difference of that size.
    pub fn soften(&mut self, nodes: &Nodes, bodies: &Bodies, split: bool) {
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
            if r == 0 { sum += pair.force } else { sum -= pair.force * pair.weight[r as usize - 1] }
        }
        sum
    }

    /// Shares of the guesses, and of the masses of the slaves that they are for, which the node at place `t` of `touched`
    /// takes as a segment's node [force], [mass].
    pub fn pressed_on(&self, t: usize) -> (V3, f64) {
        let (mut force, mut mass) = (V3::zeros(), 0.0);
        for &(p, r) in self.roles_at(t).iter().filter(|(_, r)| *r > 0) {
            let pair = &self.pairs[p as usize];
            if pair.guess != V3::zeros() {
                force += pair.guess * pair.weight[r as usize - 1];
                mass += pair.mass * pair.weight[r as usize - 1];
            }
        }
        (force, mass)
    }

    /// Whether a node of the own pair's segment is itself a slave that is pushed back from the pair's side.
    pub fn is_mutual(&self, pair: &Pair) -> bool {
        let places = (1..5).filter(|&r| pair.share(r) != 0.0);
        let places = places.filter_map(|r| self.touched.binary_search(&pair.nodes[r]).ok());
        let mut slaves = places.flat_map(|t| self.roles_at(t)).filter(|(_, r)| *r == 0);
        slaves.any(|&(q, _)| (self.pairs[q as usize].force + self.pairs[q as usize].guess).dot(&pair.normal) < 0.0)
    }

    /// Whether other workers know some of these pairs.
    pub fn is_common(&self) -> bool {
        !self.common.is_empty()
    }

    /// Exchanges the forces of pairs that several workers know. `quiet` counts the sweeps since anything last
    /// changed here or, as far as is known, elsewhere; returns the count with the others' news in it.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn swap_forces(&mut self, wire: &mut dyn Transport, quiet: u64) -> Result<u64, Lost> {
        self.swap(wire, quiet, |pair| &mut pair.force)
    }

    /// Exchanges the guesses of pairs that several workers know.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn swap_guesses(&mut self, wire: &mut dyn Transport) -> Result<(), Lost> {
        self.swap(wire, 0, |pair| &mut pair.guess).map(|_| ())
    }

    fn swap(&mut self, wire: &mut dyn Transport, quiet: u64, of: fn(&mut Pair) -> &mut V3) -> Result<u64, Lost> {
        for c in &self.common {
            self.words.clear();
            self.words.push(quiet);
            for &i in &c.sent {
                let f = of(&mut self.pairs[i as usize]);
                self.words.extend([f.x, f.y, f.z].map(f64::to_bits));
            }
            wire.send(c.worker + 1, Tag::Sweep, &self.words)?;
        }
        let mut least = quiet;
        for c in &self.common {
            wire.recv(c.worker + 1, Tag::Sweep, &mut self.words)?;
            least = least.min(self.words[0]);
            for (&i, f) in c.received.iter().zip(self.words[1..].chunks_exact(3)) {
                *of(&mut self.pairs[i as usize]) =
                    V3::new(f64::from_bits(f[0]), f64::from_bits(f[1]), f64::from_bits(f[2]));
            }
        }
        Ok(least)
    }
}

impl Pair {
    /// Share of the pair's force that the node in role `r` takes: the slave all of it.
    fn share(&self, r: usize) -> f64 {
        if r == 0 { 1.0 } else { self.weight[r - 1] }
    }

    /// How far the contact point or the slave follows the node in role `r`.
    fn follows(&self, r: usize) -> f64 {
        if r == 0 { 1.0 } else { self.shape[r - 1] }
    }

    /// Share of the own pair's correction where both surfaces are slaves of each other: `partition` for the first one, the
    /// rest for the other.
    pub fn turn_of(&self, partition: f64) -> f64 {
        if self.first { partition } else { 1.0 - partition }
    }

    /// Notes the slave's mass along the normal; own pairs only.
    pub fn weigh_slave(&mut self, nodes: &Nodes) {
        let segment: f64 = self.nodes[1..].iter().map(|&n| nodes.mass[n as usize]).sum();
        let (n, inv) = (&self.normal, &nodes.inv_mass[self.nodes[0] as usize]);
        let moves = n.x * n.x * inv[0] + n.y * n.y * inv[1] + n.z * n.z * inv[2];
        self.mass = if moves * HELD * segment > 1.0 { 1.0 / moves } else { HELD * segment };
    }

    /// Local nodes that the pair's force acts on.
    fn touching(&self) -> impl Iterator<Item = u32> + '_ {
        self.nodes.iter().enumerate().filter(|&(r, _)| self.share(r) != 0.0).map(|(_, &n)| n)
    }

    /// Velocity of the node relative to the contact point, own pairs only [length/time].
    pub fn relative_velocity(&self, v: &[Row]) -> V3 {
        let at = |n: u32| {
            let r = &v[n as usize];
            V3::new(r[0], r[1], r[2])
        };
        let n = &self.nodes;
        let point =
            at(n[1]) * self.shape[0] + at(n[2]) * self.shape[1] + at(n[3]) * self.shape[2] + at(n[4]) * self.shape[3];
        at(n[0]) - point
    }

    /// What the node remembers of this pair.
    pub fn memory(&self) -> Memory {
        Memory {
            segment: self.segment,
            side: self.side,
            tolerated: self.tolerated,
            normal: self.normal,
            force: self.force,
            slip: self.slip,
        }
    }
}

impl WirePair {
    fn of(p: &Pair, nodes: &Nodes) -> Self {
        let ids = [p.nodes[1], p.nodes[2], p.nodes[3], p.nodes[4]].map(|n| nodes.id[n as usize]);
        Self { slave: p.slave, segment: p.segment, nodes: ids, weight: p.weight, force: p.force.into(), mass: p.mass }
    }

    fn pair(&self, nodes: &Nodes) -> Pair {
        let local = |id: NodeId| nodes.number(id).unwrap_or(NOT_LOCAL);
        let s = self.nodes.map(local);
        Pair {
            slave: self.slave,
            segment: self.segment,
            nodes: [local(self.slave), s[0], s[1], s[2], s[3]],
            shape: [0.0; 4],
            weight: self.weight,
            normal: V3::zeros(),
            side: 0.0,
            gap: 0.0,
            depth: 0.0,
            tolerated: 0.0,
            thickness: 0.0,
            force: self.force.into(),
            slip: V3::zeros(),
            compliance: [0.0; 2],
            crowd: [0.0; 5],
            guess: V3::zeros(),
            turn: 1.0,
            mass: self.mass,
            stiffness: 0.0,
            first: false,
            own: false,
        }
    }
}

/// Adds impulse `force * dt` to a velocity row.
pub fn push(v: &Row, force: &V3, inv_mass: &Row, dt: f64) -> Row {
    let f = row([force.x, force.y, force.z]);
    std::array::from_fn(|c| v[c] + dt * f[c] * inv_mass[c])
}
