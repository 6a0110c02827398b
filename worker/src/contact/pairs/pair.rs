//! A pair, what it is called, what its slave remembers of it, and what others are told.

use crate::contact::geometry::V3;
use crate::contact::surface::NOT_LOCAL;
use crate::energy::Work;
use crate::nodes::{Nodes, Row, row, xyz};
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::{NodeId, SegmentId};

/// A node that is held fixed counts as this many times the mass of the segment that it meets.
pub const FIXED_MASS_RATIO: f64 = 1e6;

/// Most roles of a pair: the corners of two segments.
pub const MAX_PAIR_NODES: usize = 8;
/// Stands for the other node of a slave edge where the slave is a segment; no node is called so.
const SLAVE_SEGMENT: NodeId = NodeId(u64::MAX);

/// Values of the first roles, and nought for the others.
pub fn padded<const N: usize>(values: [f64; N]) -> [f64; MAX_PAIR_NODES] {
    std::array::from_fn(|r| values.get(r).copied().unwrap_or(0.0))
}

/// What a pair is called wherever it is known. Pairs are in ascending order of it, on any number of
/// workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
#[repr(C)]
pub struct PairKey {
    /// The node, or the node of the slave edge with the lower id, or the number of the slave
    /// segment.
    pub slave: NodeId,
    /// The other node of the slave edge; 0 where the slave is a node, as no edge has, and the
    /// largest number where it is a segment.
    pub slave_end: NodeId,
    /// The segment and 0, or the nodes of the edge that is met, ascending; or the segment, and
    /// which quarters of the slave and of it.
    pub target: [u64; 2],
}

impl PairKey {
    /// A node on a segment.
    pub fn of_node(slave: NodeId, segment: SegmentId) -> Self {
        Self { slave, slave_end: NodeId(0), target: [segment.0, 0] }
    }

    /// An edge on an edge, both by their nodes in ascending order.
    pub fn of_edges(slave: [NodeId; 2], other: [NodeId; 2]) -> Self {
        Self { slave: slave[0], slave_end: slave[1], target: other.map(|n| n.0) }
    }

    /// A quarter of a segment on a quarter of another one.
    pub fn of_segments([slave, met]: [SegmentId; 2], [of_slave, of_met]: [usize; 2]) -> Self {
        Self {
            slave: NodeId(slave.0),
            slave_end: SLAVE_SEGMENT,
            target: [met.0, (4 * of_slave + of_met) as u64],
        }
    }

    /// Whether the slave is a segment.
    pub fn is_segment(&self) -> bool {
        self.slave_end == SLAVE_SEGMENT
    }

    /// The slave segment, and which quarter of it.
    pub fn slave_quarter(&self) -> (SegmentId, usize) {
        (SegmentId(self.slave.0), (self.target[1] / 4) as usize)
    }

    /// Whether the slave is a node.
    pub fn is_node(&self) -> bool {
        self.slave_end == NodeId(0)
    }

    /// The nodes of the slave edge and of the other one.
    pub fn edge_nodes(&self) -> [NodeId; 4] {
        [self.slave, self.slave_end, NodeId(self.target[0]), NodeId(self.target[1])]
    }

    /// Whether the slave is an edge.
    pub fn is_edge(&self) -> bool {
        !self.is_node() && !self.is_segment()
    }
}

/// A node on a segment, or a point of an edge (the slave edge) on a point of another one, or what
/// two quarters of segments have over each other.
///
/// The local nodes of a pair have roles. A slave node has role 0, the segment's nodes 1 to 4. A
/// slave edge has roles 0 and 1, the other edge 2 and 3. A slave segment has roles 0 to 3, the
/// other segment 4 to 7. What is left is empty. The force acts on the slave's roles by their
/// shares, and with the opposite sign on the others.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Which pair it is.
    pub key: PairKey,
    /// The segment, or the lowest one that has the edge which is met.
    pub segment: SegmentId,
    /// Local numbers of the nodes by role, or [`NOT_LOCAL`].
    pub nodes: [u32; MAX_PAIR_NODES],
    /// Shape values N_k of the contact point by role; they sum to 1 on either side.
    pub shape: [f64; MAX_PAIR_NODES],
    /// Shares of the nodes in the contact force by role; they sum to 1 on either side.
    pub weight: [f64; MAX_PAIR_NODES],
    /// What the pair counts for where nodal masses are split: the area that two segments have in
    /// contact, 0 while there is none, and 1 where no segments meet segments [length^2].
    pub area: f64,
    /// Unit normal that points to the slave's side.
    pub normal: V3,
    /// Lever arms of friction, which acts between the middle surfaces: how far its point is off
    /// that of the slave and off that of the other side, along the normal. Together they are the
    /// distance of both, or both nought where no couple is taken; see [`Pair::lever`] [length].
    pub lever_arms: [f64; 2],
    /// Side of the slave along the segment's own normal, or the cross product of the two edges, +1
    /// or -1.
    pub side: f64,
    /// Gap that the law is to close, tolerated penetration taken off [length].
    pub gap: f64,
    /// Penetration of the surfaces, negative when open [length].
    pub penetration: f64,
    /// Penetration that is let be, 0 or negative [length].
    pub tolerated_gap: f64,
    /// The part of it that the run started with, which is let be until the gap opens by itself
    /// [length].
    pub initial_gap: f64,
    /// Length that gaps are judged by: the sum of the half thicknesses, or what stands for them
    /// where a side is a solid's ([`crate::contact::surface::Segment::scale`]) [length].
    pub contact_thickness: f64,
    /// The slower wave speed of the two sides [length/time].
    pub speed: f64,
    /// Its interface; others are not told.
    pub interface: u16,
    /// Coefficient of friction in this step; others are not told.
    pub friction_coefficient: f64,
    /// Most tangential force, infinite unless friction is limited and the pressure not yet known;
    /// others are not told [force].
    pub max_friction_force: f64,
    /// Normal pressure of all pairs around the slave node, as a mean over the last steps; nought if
    /// it is not known. Where friction is limited only, and others are not told [force/length^2].
    pub pressure: f64,
    /// Force on the slave [force].
    pub force: V3,
    /// Tangential distance of the slave from its stick point [length].
    pub slip: V3,
    /// Relative velocity change per unit impulse, normal and tangential, with nodal masses split
    /// among their pairs.
    pub compliance: [f64; 2],
    /// The part of the tangential compliance that is of nodes which friction turns.
    pub rotational_compliance: f64,
    /// The part of the normal compliance that is of the side which answers less, 0 if that is held.
    pub stiffer_compliance: f64,
    /// Speed at which the gap would be passed in the step without contact, 0 if it would not be
    /// [length/time].
    pub approach_speed: f64,
    /// What is to be added to the force if the segment stands still, and the fraction of the
    /// correction that this pair gets, for laws that predict and correct [force].
    pub predictor_force: V3,
    /// See `guess`.
    pub partition_factor: f64,
    /// Mass of the slave along the normal, with what holds it [mass].
    pub slave_mass: f64,
    /// The same across it: less than that where friction turns the slave [mass].
    pub slave_sliding_mass: f64,
    /// Most tangential force that a correction may add where friction turns nodes, for laws that
    /// predict and correct [force].
    pub max_tangential_correction: f64,
    /// Whether the slave is held fixed, or led, along the normal; others are told.
    pub slave_is_fixed: bool,
    /// Stiffness of the segment, for laws that have one for it [force/length].
    pub stiffness: f64,
    /// Whether the node's surface comes before the segment's, by part and then by segment.
    pub slave_surface_first: bool,
    /// Whether this worker owns the pair.
    pub is_owned: bool,
}

/// What a slave remembers of a pair of the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairHistory {
    /// See [`Pair::name`].
    pub name: PairKey,
    /// See [`Pair::side`].
    pub side: f64,
    /// See [`Pair::tolerated`].
    pub tolerated: f64,
    /// See [`Pair::kept`].
    pub kept: f64,
    /// See [`Pair::depth`].
    pub depth: f64,
    /// See [`Pair::normal`].
    pub normal: V3,
    /// See [`Pair::force`].
    pub force: V3,
    /// See [`Pair::slip`].
    pub slip: V3,
    /// See [`Pair::thickness`].
    pub thickness: f64,
    /// See [`Pair::pressure`].
    pub pressure: f64,
    /// Steps since the pair was lost, 0 for one of the last step.
    pub age: u32,
}

/// Share of a step in the mean pressure: forces change from one to the next where bodies vibrate.
const PRESSURE_SHARE: f64 = 0.1;
/// A pair that is lost is remembered for so many steps, if it was deeper than this fraction of its
/// thickness.
const KEPT_STEPS: u32 = 50;
const KEPT_PENETRATION: f64 = 0.01;
/// What is lost may have moved by this fraction of its scale until it counts as new.
const KEPT_DISTANCE: f64 = 0.5;

impl PairHistory {
    /// Words of a memory in a message.
    pub const WORDS: usize = 20;

    /// What is left of it a step later in which there is no such pair: on which side it was, how
    /// deep, and what of that is let be. Found again it does not begin anew. What was not deep is
    /// on no side that could not be seen.
    pub fn after_loss(self) -> Option<Self> {
        let kept = self.age < KEPT_STEPS && self.depth > KEPT_PENETRATION * self.thickness;
        kept.then(|| Self { age: self.age + 1, force: V3::zeros(), slip: V3::zeros(), ..self })
    }

    /// Whether the pair was there in the last step, or cannot have gone far since by what it moves
    /// in one, `moved` [length].
    pub fn is_fresh(&self, moved: f64, scale: f64) -> bool {
        f64::from(self.age) * moved <= KEPT_DISTANCE * scale
    }

    /// The remembered force turned to a new normal: same normal part, tangential part within the
    /// new tangent plane.
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
        let numbers = [
            self.side,
            self.tolerated,
            self.kept,
            self.depth,
            self.thickness,
            f64::from(self.age),
            self.pressure,
        ]
        .into_iter();
        let vectors = [self.normal, self.force, self.slip];
        let all = numbers.chain(vectors.iter().flat_map(|v| [v.x, v.y, v.z]));
        w[NAME_WORDS..].iter_mut().zip(all).for_each(|(w, a)| *w = a.to_bits());
        w
    }

    /// The segment that a node met.
    pub fn segment(&self) -> SegmentId {
        SegmentId(self.name.target[0])
    }

    /// Whether it is of the slave's pair with a segment.
    pub fn is_of(&self, segment: SegmentId) -> bool {
        self.name.target == [segment.0, 0]
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
            kept: at(2),
            depth: at(3),
            thickness: at(4),
            age: at(5) as u32,
            pressure: at(6),
            normal: vector(7),
            force: vector(10),
            slip: vector(13),
        }
    }
}

/// What is pushed back from a pair's side among the nodes that its slave meets, which are slaves
/// themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpposingPairs {
    /// Whether some are free, and whether some are held.
    pub free: bool,
    /// See `free`.
    pub held: bool,
    /// Whether the free ones need no more than a small part of their forces.
    pub settled: bool,
}

/// A pair as others need it.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct WirePair {
    name: PairKey,
    segment: SegmentId,
    nodes: [NodeId; FIRST],
    weight: [f64; FIRST],
    normal: [f64; 3],
    tolerated: f64,
    kept: f64,
    depth: f64,
    thickness: f64,
    force: [f64; 3],
    mass: f64,
    /// Bits: [`Pair::held`], and whether a [`WireLever`] follows.
    flags: u64,
}
const NAME_WORDS: usize = size_of::<PairKey>() / 8;
/// Roles of a pair in [`WirePair`], and those of two segments that follow it in [`WireRest`].
const FIRST: usize = 5;
const REST: usize = MAX_PAIR_NODES - FIRST;

/// What is told of two segments beside.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct WireRest {
    nodes: [NodeId; REST],
    weight: [f64; REST],
    area: f64,
}
/// What is told beside of pairs whose friction turns nodes.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct WireLever {
    arm: [f64; 2],
    sliding_mass: f64,
}
const WIRE_WORDS: usize = size_of::<WirePair>() / 8;
const REST_WORDS: usize = size_of::<WireRest>() / 8;
const LEVER_WORDS: usize = size_of::<WireLever>() / 8;

impl Pair {
    /// With the gap between the surfaces [length] and what is remembered of the pair: the force and
    /// the slip from the stick point, turned to its normal, and the penetration that is let be, 0
    /// or negative [length].
    pub fn with_history(self, old: Option<&PairHistory>, gap: f64, tolerated: f64) -> Self {
        let kept = old.map_or(0.0, |m| m.kept.max(gap.min(0.0)));
        let tolerated = tolerated.min(kept);
        Self {
            gap: gap - tolerated,
            penetration: -gap,
            tolerated_gap: tolerated,
            initial_gap: kept,
            force: old.map_or(V3::zeros(), |m| m.force_along(&self.normal)),
            slip: old.map_or(V3::zeros(), |m| m.slip_along(&self.normal)),
            pressure: old.map_or(0.0, |m| m.pressure),
            ..self
        }
    }

    /// A pair of which no more is known.
    pub fn new<const N: usize>(name: PairKey, segment: SegmentId, nodes: [u32; N]) -> Self {
        Self {
            key: name,
            segment,
            nodes: std::array::from_fn(|r| nodes.get(r).copied().unwrap_or(NOT_LOCAL)),
            shape: [0.0; MAX_PAIR_NODES],
            weight: [0.0; MAX_PAIR_NODES],
            area: 1.0,
            normal: V3::zeros(),
            lever_arms: [0.0; 2],
            side: 0.0,
            gap: 0.0,
            penetration: 0.0,
            tolerated_gap: 0.0,
            initial_gap: 0.0,
            contact_thickness: 0.0,
            speed: 0.0,
            interface: 0,
            friction_coefficient: 0.0,
            max_friction_force: f64::INFINITY,
            pressure: 0.0,
            force: V3::zeros(),
            slip: V3::zeros(),
            compliance: [0.0; 2],
            rotational_compliance: 0.0,
            stiffer_compliance: 0.0,
            approach_speed: 0.0,
            predictor_force: V3::zeros(),
            partition_factor: 1.0,
            slave_mass: 0.0,
            slave_sliding_mass: 0.0,
            max_tangential_correction: 0.0,
            slave_is_fixed: false,
            stiffness: 0.0,
            slave_surface_first: false,
            is_owned: false,
        }
    }

    /// Holds the friction of this step to a shear stress [force/length^2] on the area of the slave
    /// node [length^2]. Where two surfaces are slaves of each other the load is shared in any way
    /// between their pairs, so that what a pair bears tells nothing of the pressure: the
    /// coefficient is held to the limit over the pressure, once that is known. Two segments have
    /// their own area, and no pressure is noted of them.
    pub fn limit_friction(&mut self, limit: f64, area: f64) {
        if self.pressure > 0.0 {
            self.friction_coefficient = self.friction_coefficient.min(limit / self.pressure);
        } else {
            self.max_friction_force = limit * area;
        }
    }

    /// Takes the normal force on the slave node in this step [force] into the mean of its pressure.
    pub fn note_pressure(&mut self, pressed: f64, area: f64) {
        let now = if area > 0.0 { pressed.max(0.0) / area } else { 0.0 };
        let share = if self.pressure > 0.0 { PRESSURE_SHARE } else { 1.0 };
        self.pressure += share * (now - self.pressure);
    }

    /// Most tangential force under the normal force `pressed` [force].
    pub fn friction_force(&self, pressed: f64) -> f64 {
        (self.friction_coefficient * pressed).min(self.max_friction_force)
    }

    /// Number of roles on the slave's side.
    pub fn slave_node_count(&self) -> usize {
        match self.key.slave_end {
            NodeId(0) => 1,
            SLAVE_SEGMENT => 4,
            _ => 2,
        }
    }

    /// Number of roles.
    pub fn node_count(&self) -> usize {
        match self.key.slave_end {
            NodeId(0) => 5,
            SLAVE_SEGMENT => 8,
            _ => 4,
        }
    }

    /// Whether role `r` is on the slave's side.
    pub(super) fn is_slave_role(&self, r: u8) -> bool {
        usize::from(r) < self.slave_node_count()
    }

    /// Share of the pair's force that the node in role `r` takes.
    pub(super) fn share(&self, r: usize) -> f64 {
        self.weight[r]
    }

    /// How far the point on its side follows the node in role `r`.
    pub(super) fn follows(&self, r: usize) -> f64 {
        self.shape[r]
    }

    /// Whether its friction turns nodes.
    pub fn has_couple(&self) -> bool {
        self.lever_arms != [0.0; 2]
    }

    /// Lever arm of the side of role `r` [length].
    pub(super) fn lever_arm_of(&self, r: usize) -> f64 {
        self.lever_arms[usize::from(r >= self.slave_node_count())]
    }

    /// Moment of the pair's force on both of its sides together, per lever arm [force].
    ///
    /// Friction F acts on the slave at `x_s - a n` and with the opposite sign on the other side at
    /// `x_m + b n`, with the arms a and b. About `x_s` and `x_m` that is `-a n x F` and `-b n x F`,
    /// which the nodes take by their shares in F.
    pub(super) fn twist(&self, force: &V3) -> V3 {
        -self.normal.cross(force)
    }

    /// Sets the lever arms of the own pair from what they are to each other, as `arm` has it.
    /// Together they span the distance of the points of both sides along the normal: the couple of
    /// forces on the middle surfaces is then taken to round-off. A side without rotational inertia
    /// at a node that the force acts on can take none of it, and leaves it to the other one; where
    /// neither can, the couple stays.
    pub fn lever(&mut self, nodes: &Nodes) {
        if !self.has_couple() {
            return;
        }
        if !nodes.rotations {
            self.lever_arms = [0.0; 2];
            return;
        }
        let loaded = |roles: std::ops::Range<usize>| roles.filter(|&r| self.share(r) != 0.0);
        let can_turn = |roles| loaded(roles).all(|r| nodes.inertia[self.nodes[r] as usize] > 0.0);
        let [slave, met] = self.lever_arms;
        let arm = match [
            can_turn(0..self.slave_node_count()),
            can_turn(self.slave_node_count()..self.node_count()),
        ] {
            [true, true] => [slave / (slave + met), met / (slave + met)],
            [true, false] => [1.0, 0.0],
            [false, true] => [0.0, 1.0],
            [false, false] => [0.0, 0.0],
        };
        let along = |r: usize| {
            V3::from(xyz(&nodes.x[self.nodes[r] as usize])).dot(&self.normal) * self.shape[r]
        };
        let apart = loaded(0..self.slave_node_count()).map(along).sum::<f64>()
            - loaded(self.slave_node_count()..self.node_count()).map(along).sum::<f64>();
        self.lever_arms = arm.map(|a| a * apart);
    }

    /// Share of the own pair's correction where both surfaces are slaves of each other: `partition`
    /// for the first one, the rest for the other. Where one of them is held, the free one closes
    /// the gap; the held one takes what is left when the free one has settled, such as a held node
    /// between the free ones of a coarser face.
    pub fn partition_factor_of(&self, partition: f64, met: OpposingPairs) -> f64 {
        match (self.slave_is_fixed, met) {
            (_, OpposingPairs { free: false, held: false, .. })
            | (false, OpposingPairs { free: false, .. }) => 1.0,
            (true, OpposingPairs { free: true, settled, .. }) => f64::from(settled),
            _ => {
                if self.slave_surface_first {
                    partition
                } else {
                    1.0 - partition
                }
            }
        }
    }

    /// Notes the slave's mass along the normal and across it; own pairs only.
    pub fn set_slave_mass(&mut self, nodes: &Nodes) {
        let met = self.nodes[self.slave_node_count()..].iter().filter(|&&n| n != NOT_LOCAL);
        let segment: f64 = met.map(|&n| nodes.contact_mass(n as usize)).sum();
        let n = &self.normal;
        let moves = |r: usize| {
            let inv = &nodes.inv_mass[self.nodes[r] as usize];
            self.share(r)
                * self.follows(r)
                * (n.x * n.x * inv[0] + n.y * n.y * inv[1] + n.z * n.z * inv[2])
        };
        let moves: f64 = (0..self.slave_node_count()).map(moves).sum();
        self.slave_is_fixed = moves * FIXED_MASS_RATIO * segment <= 1.0;
        self.slave_mass =
            if self.slave_is_fixed { FIXED_MASS_RATIO * segment } else { 1.0 / moves };
        self.slave_sliding_mass = self.slave_mass;
        if self.lever_arms[0] != 0.0 {
            let inverse = |r: usize| {
                let inv = &nodes.inv_inertia[self.nodes[r] as usize];
                self.share(r) * self.follows(r) * inv[0].max(inv[1]).max(inv[2])
            };
            let turns: f64 = (0..self.slave_node_count()).map(inverse).sum();
            self.slave_sliding_mass = self.slave_mass
                / (1.0 + self.slave_mass * self.lever_arms[0] * self.lever_arms[0] * turns);
        }
    }

    /// Local nodes that the pair's force acts on.
    pub fn local_nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.nodes[..self.node_count()]
            .iter()
            .enumerate()
            .filter(|&(r, _)| self.share(r) != 0.0)
            .map(|(_, &n)| n)
    }

    /// Velocity at the next mid-step of the slave where friction acts on it, own pairs only
    /// [length/time].
    pub fn slave_velocity(&self, nodes: &Nodes) -> V3 {
        let middle = self.slave_mean(&nodes.v_next);
        if self.lever_arms[0] == 0.0 {
            return middle;
        }
        middle - self.slave_mean(&nodes.w_next).cross(&self.normal) * self.lever_arms[0]
    }

    /// Mean of the vectors at the slave's nodes by their shape values.
    fn slave_mean(&self, v: &[Row]) -> V3 {
        let at = |r: usize| V3::from(xyz(&v[self.nodes[r] as usize]));
        match self.key.slave_end {
            NodeId(0) => at(0),
            SLAVE_SEGMENT => self.mean(v, 0),
            _ => at(0) * self.shape[0] + at(1) * self.shape[1],
        }
    }

    /// The same at the nodes of the other side.
    fn met_mean(&self, v: &[Row]) -> V3 {
        let part = |r: usize| V3::from(xyz(&v[self.nodes[r] as usize])) * self.shape[r];
        match self.key.slave_end {
            NodeId(0) => self.mean(v, 1),
            SLAVE_SEGMENT => self.mean(v, 4),
            _ => part(2) + part(3),
        }
    }

    /// Mean of the vectors at four nodes from a role on, by their shape values.
    fn mean(&self, v: &[Row], from: usize) -> V3 {
        let part =
            |r: usize| V3::from(xyz(&v[self.nodes[from + r] as usize])) * self.shape[from + r];
        part(0) + part(1) + part(2) + part(3)
    }

    /// Velocity at the next mid-step of the slave relative to the other side, both where friction
    /// acts on them; own pairs only [length/time].
    pub fn relative_velocity(&self, nodes: &Nodes) -> V3 {
        let relative = self.slave_velocity(nodes) - self.met_mean(&nodes.v_next);
        if self.lever_arms[1] == 0.0 {
            return relative;
        }
        relative - self.met_mean(&nodes.w_next).cross(&self.normal) * self.lever_arms[1]
    }

    /// Work of its force on its nodes over `mid`, the time from one mid-step to the next; own pairs
    /// only.
    pub fn work(&self, nodes: &Nodes, mid: f64) -> Work {
        let on = |r: usize| {
            let share = if r < self.slave_node_count() { self.share(r) } else { -self.share(r) };
            let n = self.nodes[r] as usize;
            let moved = Work::from_impulses(
                &row((self.force * (mid * share)).into()),
                &nodes.v[n],
                &nodes.v_next[n],
            );
            let arm = self.lever_arm_of(r);
            if arm == 0.0 {
                return moved;
            }
            let couple = self.twist(&self.force) * (mid * self.share(r) * arm);
            moved + Work::from_impulses(&row(couple.into()), &nodes.w[n], &nodes.w_next[n])
        };
        (0..self.node_count())
            .filter(|&r| self.nodes[r] != NOT_LOCAL && self.share(r) != 0.0)
            .map(on)
            .sum()
    }

    /// What the slave remembers of this pair.
    pub fn to_history(&self) -> PairHistory {
        PairHistory {
            name: self.key,
            side: self.side,
            tolerated: self.tolerated_gap,
            kept: self.initial_gap,
            depth: self.penetration,
            normal: self.normal,
            force: self.force,
            slip: self.slip,
            thickness: self.contact_thickness,
            pressure: self.pressure,
            age: 0,
        }
    }
}

impl Pair {
    /// Words of the pair in a message to others.
    pub fn words(&self) -> usize {
        let rest = if self.key.is_segment() { REST_WORDS } else { 0 };
        WIRE_WORDS + rest + if self.has_couple() { LEVER_WORDS } else { 0 }
    }

    /// Appends what others need of it.
    pub(super) fn pack(&self, nodes: &Nodes, words: &mut Vec<u64>) {
        let id = |n: u32| if n == NOT_LOCAL { NodeId(u64::MAX) } else { nodes.id[n as usize] };
        let first = WirePair {
            name: self.key,
            segment: self.segment,
            nodes: std::array::from_fn(|r| id(self.nodes[r])),
            weight: std::array::from_fn(|r| self.weight[r]),
            normal: self.normal.into(),
            tolerated: self.tolerated_gap,
            kept: self.initial_gap,
            depth: self.penetration,
            thickness: self.contact_thickness,
            force: self.force.into(),
            mass: self.slave_mass,
            flags: u64::from(self.slave_is_fixed) | u64::from(self.has_couple()) << 1,
        };
        words.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(&first)));
        if self.key.is_segment() {
            let rest = WireRest {
                nodes: std::array::from_fn(|r| id(self.nodes[FIRST + r])),
                weight: std::array::from_fn(|r| self.weight[FIRST + r]),
                area: self.area,
            };
            words.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(&rest)));
        }
        if self.has_couple() {
            let lever = WireLever { arm: self.lever_arms, sliding_mass: self.slave_sliding_mass };
            words.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(&lever)));
        }
    }

    /// The first pair in a message, and what follows it.
    pub(super) fn unpack<'a>(words: &'a [u64], nodes: &Nodes) -> (Self, &'a [u64]) {
        let local = |id: NodeId| nodes.index_of(id).unwrap_or(NOT_LOCAL);
        let (first, mut after) = words.split_at(WIRE_WORDS);
        let first: WirePair = bytemuck::pod_read_unaligned(bytemuck::cast_slice(first));
        let mut pair = Self {
            weight: padded(first.weight),
            normal: first.normal.into(),
            tolerated_gap: first.tolerated,
            initial_gap: first.kept,
            penetration: first.depth,
            contact_thickness: first.thickness,
            force: first.force.into(),
            slave_mass: first.mass,
            slave_sliding_mass: first.mass,
            slave_is_fixed: first.flags & 1 != 0,
            ..Self::new(first.name, first.segment, first.nodes.map(local))
        };
        if pair.key.is_segment() {
            let rest;
            (rest, after) = after.split_at(REST_WORDS);
            let rest: WireRest = bytemuck::pod_read_unaligned(bytemuck::cast_slice(rest));
            pair.nodes[FIRST..].copy_from_slice(&rest.nodes.map(local));
            pair.weight[FIRST..].copy_from_slice(&rest.weight);
            pair.area = rest.area;
        }
        if first.flags & 2 != 0 {
            let lever;
            (lever, after) = after.split_at(LEVER_WORDS);
            let lever: WireLever = bytemuck::pod_read_unaligned(bytemuck::cast_slice(lever));
            (pair.lever_arms, pair.slave_sliding_mass) = (lever.arm, lever.sliding_mass);
        }
        (pair, after)
    }
}
