//! A contact pair and its key.

use super::PairHistory;
use crate::surface::NOT_LOCAL;
use bytemuck::{Pod, Zeroable};
use crumple_fem::nodes::Nodes;
use crumple_fem::work::Work;
use crumple_math::lanes::Lane;
use crumple_math::row::{Row, V3, row, xyz};
use crumple_proto::ids::{NodeId, SegmentId};

/// Weight of one step in the mean pressure. A mean is needed because forces change from step to
/// step if bodies vibrate.
const PRESSURE_SHARE: f64 = 0.1;
/// Mass assigned to a fixed slave node, as a multiple of the segment's mass.
pub const FIXED_MASS_RATIO: f64 = 1e6;

/// Largest number of roles of a pair: the corners of two segments.
pub const MAX_PAIR_NODES: usize = 8;
/// Value of [`PairKey::slave_end`] if the slave is a segment; no node has this id.
const SLAVE_SEGMENT: NodeId = NodeId(u64::MAX);

/// Returns the values of the first roles, followed by zeros for the other roles.
pub fn padded<const N: usize>(values: [f64; N]) -> [f64; MAX_PAIR_NODES] {
    std::array::from_fn(|r| values.get(r).copied().unwrap_or(0.0))
}

/// Globally unique key of a pair. Pairs are sorted in ascending order of their keys, for any
/// number of workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
#[repr(C)]
pub struct PairKey {
    /// The slave node, or the node of the slave edge with the lower id, or the id of the slave
    /// segment.
    pub slave: NodeId,
    /// The other node of the slave edge. It is 0 if the slave is a node (no edge has this value)
    /// and the largest number if the slave is a segment.
    pub slave_end: NodeId,
    /// For a node: the segment and 0. For an edge: the two nodes of the target edge, ascending.
    /// For a segment: the target segment, and the number that combines the quarter of the slave
    /// and the quarter of the target.
    pub target: [u64; 2],
}

impl PairKey {
    /// Returns the key of a node and a segment.
    pub fn of_node(slave: NodeId, segment: SegmentId) -> Self {
        Self { slave, slave_end: NodeId(0), target: [segment.0, 0] }
    }

    /// Returns the key of two edges, each given by its nodes in ascending order.
    pub fn of_edges(slave: [NodeId; 2], other: [NodeId; 2]) -> Self {
        Self { slave: slave[0], slave_end: slave[1], target: other.map(|n| n.0) }
    }

    /// Returns the key of a quarter of a segment and a quarter of another segment.
    pub fn of_segments([slave, met]: [SegmentId; 2], [of_slave, of_met]: [usize; 2]) -> Self {
        Self {
            slave: NodeId(slave.0),
            slave_end: SLAVE_SEGMENT,
            target: [met.0, (4 * of_slave + of_met) as u64],
        }
    }

    /// Returns true if the slave is a segment.
    pub fn is_segment(&self) -> bool {
        self.slave_end == SLAVE_SEGMENT
    }

    /// Returns the slave segment and the number of its quarter.
    pub fn slave_quarter(&self) -> (SegmentId, usize) {
        (SegmentId(self.slave.0), (self.target[1] / 4) as usize)
    }

    /// Returns true if the slave is a node.
    pub fn is_node(&self) -> bool {
        self.slave_end == NodeId(0)
    }

    /// Returns the nodes of the slave edge, then those of the target edge.
    pub fn edge_nodes(&self) -> [NodeId; 4] {
        [self.slave, self.slave_end, NodeId(self.target[0]), NodeId(self.target[1])]
    }

    /// Returns true if the slave is an edge.
    pub fn is_edge(&self) -> bool {
        !self.is_node() && !self.is_segment()
    }
}

/// A contact pair: a node and a segment, or a point of the slave edge and a point of another
/// edge, or the overlap of a quarter of one segment with a quarter of another.
///
/// Each node of a pair has a role, the index of the node in the pair. A slave node has role 0,
/// the nodes of the segment have roles 1 to 4. A slave edge has roles 0 and 1, the other edge
/// has roles 2 and 3. A slave segment has roles 0 to 3, the other segment has roles 4 to 7.
/// Unused roles are empty. The force acts on the slave's nodes by their force weights, and with
/// the opposite sign on the nodes of the other side.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Key of the pair.
    pub key: PairKey,
    /// The segment, or the segment with the lowest id that has the target edge.
    pub segment: SegmentId,
    /// Local numbers of the nodes by role, or [`NOT_LOCAL`].
    pub nodes: [u32; MAX_PAIR_NODES],
    /// Shape values N_k of the contact point by role; they sum to 1 on each side.
    pub shape: [f64; MAX_PAIR_NODES],
    /// Force weights of the nodes by role; they sum to 1 on each side.
    pub weight: [f64; MAX_PAIR_NODES],
    /// Weight of the pair when nodal masses are split among pairs. For two segments it is the
    /// area of their contact, 0 while there is no contact. It is 0 for redundant pairs
    /// (`redundant.rs`). For other pairs it is the square of
    /// the contact thickness if the table can have pairs of two segments, else 1 [length^2].
    pub area: f64,
    /// Unit normal that points to the slave's side.
    pub normal: V3,
    /// Lever arms of friction, which acts between the middle surfaces. They are the distances
    /// along the normal from the friction point to the point of the slave and to the point of
    /// the other side. Their sum is the distance of both points. Both are zero if the pair has
    /// no friction couple; see [`Pair::lever`] [length].
    pub lever_arms: [f64; 2],
    /// Side of the slave: +1 or -1 along the segment's own normal, or along the cross product of
    /// the two edges.
    pub side: f64,
    /// Gap that the contact law closes: the gap of the surfaces less the tolerated gap [length].
    pub gap: f64,
    /// Penetration of the surfaces, negative if open [length].
    pub penetration: f64,
    /// Penetration that stays without force, 0 or negative [length].
    pub tolerated_gap: f64,
    /// Part of the tolerated gap that was there at the start of the run. It stays without force
    /// until the gap opens by itself [length].
    pub initial_gap: f64,
    /// Length by which gaps are judged: the sum of the half thicknesses, or the value used in
    /// their place for a side that belongs to a solid
    /// ([`crate::surface::Segment::scale`]) [length].
    pub contact_thickness: f64,
    /// Lower of the wave speeds of the two sides [length/time].
    pub speed: f64,
    /// Index of the interface.
    pub interface: u16,
    /// Coefficient of friction in this step; not sent to other workers.
    pub friction_coefficient: f64,
    /// Largest tangential force. It is infinite unless friction is limited and the pressure is
    /// not known yet; not sent to other workers [force].
    pub max_friction_force: f64,
    /// Normal pressure of all pairs at the slave node, as a mean over the last steps; zero if it
    /// is not known. It is set only if friction depends on it, and is not sent to other workers
    /// [force/length^2].
    pub pressure: f64,
    /// Area of contact of two edges, set only if friction depends on the pressure; not sent to
    /// other workers [length^2].
    pub edge_area: f64,
    /// Force on the slave [force].
    pub force: V3,
    /// Tangential distance of the slave from its stick point [length].
    pub slip: V3,
    /// Normal and tangential compliance: relative velocity change per unit impulse, with nodal
    /// masses split among their pairs [1/mass].
    pub compliance: [f64; 2],
    /// Part of the tangential compliance due to the rotation of nodes by friction [1/mass].
    pub rotational_compliance: f64,
    /// Normal compliance of the stiffer side, 0 if this side is fixed [1/mass].
    pub stiffer_compliance: f64,
    /// Relative normal velocity that closes the gap beyond zero in the step without contact, 0
    /// if the gap is not closed [length/time].
    pub approach_speed: f64,
    /// Relative velocity along the normal at the last mid-step, positive if the pair opened
    /// [length/time].
    pub opening_before: f64,
    /// Force to be added if the segment stands still, for laws that predict and correct [force].
    pub predictor_force: V3,
    /// Fraction of the correction that this pair gets, for laws that predict and correct.
    pub partition_factor: f64,
    /// Mass of the slave along the normal, including the constraints on it [mass].
    pub slave_mass: f64,
    /// Mass of the slave in the tangent plane. It is less than [`Pair::slave_mass`] if friction
    /// rotates the slave [mass].
    pub slave_sliding_mass: f64,
    /// Largest tangential force that a correction may add if friction rotates nodes, for laws
    /// that predict and correct [force].
    pub max_tangential_correction: f64,
    /// True if the slave is fixed or has a prescribed motion along the normal; sent to other
    /// workers.
    pub slave_is_fixed: bool,
    /// Stiffness of the segment, for laws that define one [force/length].
    pub stiffness: f64,
    /// True if the slave's surface comes before the segment's surface, ordered by part and then
    /// by segment.
    pub slave_surface_first: bool,
    /// True if this worker computes the force of the pair: it owns the pair, or has a replica.
    pub is_owned: bool,
    /// True if the pair is a replica: another worker owns it, and this one computes its force too.
    pub is_replica: bool,
}

/// Pairs that push back from the side of a given pair. Their slaves are nodes of the target of
/// that pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpposingPairs {
    /// True if at least one slave of these pairs is free.
    pub free: bool,
    /// True if at least one slave of these pairs is fixed.
    pub held: bool,
    /// True if the predictor forces of all free slaves are a small part of their forces.
    pub settled: bool,
}

impl Pair {
    /// Returns the pair with the gap between the surfaces [length] and the history of the pair:
    /// the force and the slip from the stick point, projected for the new normal, and the
    /// tolerated gap, 0 or negative [length].
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

    /// Keeps the penetration of a new pair of shells as one of the start, if it is so deep that the
    /// nodes must have been in each other's middle surfaces, where they are no pair. `thickness` is
    /// the distance of the middle surfaces at which they touch [length].
    pub fn keep_if_deep(&mut self, thickness: f64) {
        /// Penetration as a fraction of the thickness: no impact gets as deep in one step.
        const DEEP: f64 = 0.75;
        if thickness > 0.0 && -self.tolerated_gap > DEEP * thickness {
            self.initial_gap = self.tolerated_gap;
        }
    }

    /// Returns a pair with a key, a segment and nodes; all other fields have default values.
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
            edge_area: 0.0,
            force: V3::zeros(),
            slip: V3::zeros(),
            compliance: [0.0; 2],
            rotational_compliance: 0.0,
            stiffer_compliance: 0.0,
            approach_speed: 0.0,
            opening_before: 0.0,
            predictor_force: V3::zeros(),
            partition_factor: 1.0,
            slave_mass: 0.0,
            slave_sliding_mass: 0.0,
            max_tangential_correction: 0.0,
            slave_is_fixed: false,
            stiffness: 0.0,
            slave_surface_first: false,
            is_owned: false,
            is_replica: false,
        }
    }

    /// Returns what other workers know of the pair: no values that only its owner needs. `nodes`
    /// are their indices of its nodes.
    pub fn as_copy(&self, nodes: [u32; MAX_PAIR_NODES]) -> Self {
        Self {
            weight: self.weight,
            area: self.area,
            normal: self.normal,
            lever_arms: self.lever_arms,
            penetration: self.penetration,
            tolerated_gap: self.tolerated_gap,
            initial_gap: self.initial_gap,
            contact_thickness: self.contact_thickness,
            interface: self.interface,
            force: self.force,
            slave_mass: self.slave_mass,
            slave_sliding_mass: self.slave_sliding_mass,
            slave_is_fixed: self.slave_is_fixed,
            ..Self::new(self.key, self.segment, nodes)
        }
    }

    /// Limits the friction of this step to a shear stress [force/length^2] on the area of the
    /// slave node [length^2]. If two surfaces are slaves of each other, the load is divided
    /// arbitrarily between their pairs, so the force of one pair does not give the pressure.
    /// Therefore the coefficient of friction is limited to the shear stress over the pressure as
    /// soon as the pressure is known. A pair of two segments or of two edges has its own area,
    /// and its pressure is not recorded.
    pub fn limit_friction(&mut self, limit: f64, area: f64) {
        if self.pressure > 0.0 {
            self.friction_coefficient = self.friction_coefficient.min(limit / self.pressure);
        } else {
            self.max_friction_force = limit * area;
        }
    }

    /// Updates the mean pressure with the normal force on the slave node in this step [force]
    /// and the area of the node [length^2].
    pub fn note_pressure(&mut self, pressed: f64, area: f64) {
        let now = if area > 0.0 { pressed.max(0.0) / area } else { 0.0 };
        let share = if self.pressure > 0.0 { PRESSURE_SHARE } else { 1.0 };
        self.pressure += share * (now - self.pressure);
    }

    /// Returns the largest tangential force under the normal force `pressed` [force].
    pub fn friction_force(&self, pressed: f64) -> f64 {
        (self.friction_coefficient * pressed).min(self.max_friction_force)
    }

    /// Returns the number of roles on the slave's side.
    pub fn slave_node_count(&self) -> usize {
        match self.key.slave_end {
            NodeId(0) => 1,
            SLAVE_SEGMENT => 4,
            _ => 2,
        }
    }

    /// Returns the number of roles.
    pub fn node_count(&self) -> usize {
        match self.key.slave_end {
            NodeId(0) => 5,
            SLAVE_SEGMENT => 8,
            _ => 4,
        }
    }

    /// Returns true if role `r` is on the slave's side.
    pub(super) fn is_slave_role(&self, r: u8) -> bool {
        usize::from(r) < self.slave_node_count()
    }

    /// Returns the force weight of the node in role `r`.
    pub(super) fn share(&self, r: usize) -> f64 {
        self.weight[r]
    }

    /// Returns the shape value of the node in role `r`, by which the point on its side moves
    /// with the node.
    pub(super) fn follows(&self, r: usize) -> f64 {
        self.shape[r]
    }

    /// Returns true if friction of the pair rotates nodes.
    pub fn has_couple(&self) -> bool {
        self.lever_arms != [0.0; 2]
    }

    /// Returns the lever arm of the side of role `r` [length].
    pub(super) fn lever_arm_of(&self, r: usize) -> f64 {
        self.lever_arms[usize::from(r >= self.slave_node_count())]
    }

    /// Returns the moment of the pair's force on both sides together, per unit lever arm
    /// [force].
    ///
    /// Friction F acts on the slave at `x_s - a n` and with the opposite sign on the other side
    /// at `x_m + b n`, with the lever arms a and b. The moments about `x_s` and `x_m` are `-a n
    /// x F` and `-b n x F`. They are divided among the nodes by the force weights.
    pub(super) fn twist(&self, force: &V3) -> V3 {
        -self.normal.cross(force)
    }

    /// Sets the lever arms of the own pair from the ratio of their values before the call. Their
    /// sum becomes the distance of the points of both sides along the normal, so that the couple
    /// of the forces on the middle surfaces is balanced to round-off. A side takes no moment if
    /// a node that the force acts on has no rotational inertia; then the other side takes all of
    /// it. If neither side can take a moment, the couple is not balanced.
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

    /// Returns the partition factor of the own pair. If both surfaces are slaves of each other,
    /// it is `partition` for the first surface and the rest for the other. If one of the slaves
    /// is fixed, the free slave closes the gap. The fixed slave corrects the rest after the free
    /// slave has settled, for example a fixed node between the free nodes of a coarser face.
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

    /// Sets the slave's mass along the normal and in the tangent plane; own pairs only.
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

    /// Returns the local nodes that the pair's force acts on.
    pub fn local_nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.nodes[..self.node_count()]
            .iter()
            .enumerate()
            .filter(|&(r, _)| self.share(r) != 0.0)
            .map(|(_, &n)| n)
    }

    /// Returns the velocity of the slave at the next mid-step, at the point where friction acts
    /// on it; own pairs only [length/time].
    pub fn slave_velocity(&self, nodes: &Nodes) -> V3 {
        let middle = self.slave_mean(&nodes.v_next);
        if self.lever_arms[0] == 0.0 {
            return middle;
        }
        middle - self.slave_mean(&nodes.w_next).cross(&self.normal) * self.lever_arms[0]
    }

    /// Returns the mean of the vectors at the slave's nodes, weighted by the shape values.
    fn slave_mean(&self, v: &[Row]) -> V3 {
        match self.key.slave_end {
            NodeId(0) => V3::from(xyz(&v[self.nodes[0] as usize])),
            SLAVE_SEGMENT => self.mean::<4>(v, 0),
            _ => self.mean::<2>(v, 0),
        }
    }

    /// Returns the mean of the vectors at the nodes of the other side, weighted by the shape
    /// values.
    fn met_mean(&self, v: &[Row]) -> V3 {
        match self.key.slave_end {
            NodeId(0) => self.mean::<4>(v, 1),
            SLAVE_SEGMENT => self.mean::<4>(v, 4),
            _ => self.mean::<2>(v, 2),
        }
    }

    /// Returns the mean of the vectors at `N` consecutive roles from `from` on, weighted by the
    /// shape values. All components are summed at once, as in a row.
    #[inline(always)]
    fn mean<const N: usize>(&self, v: &[Row], from: usize) -> V3 {
        let part = |r: usize| Lane::new(v[self.nodes[r] as usize]) * Lane::splat(self.shape[r]);
        let sum = (from + 1..from + N).fold(part(from), |sum, r| sum + part(r));
        V3::from(xyz(&sum.to_array()))
    }

    /// Returns the velocity of the slave relative to the other side at the next mid-step, both
    /// at the points where friction acts; own pairs only [length/time].
    #[inline]
    pub fn relative_velocity(&self, nodes: &Nodes) -> V3 {
        let relative = self.slave_velocity(nodes) - self.met_mean(&nodes.v_next);
        if self.lever_arms[1] == 0.0 {
            return relative;
        }
        relative - self.met_mean(&nodes.w_next).cross(&self.normal) * self.lever_arms[1]
    }

    /// Returns [`Pair::opening_before`]; own pairs only. Rotations do not move the points along
    /// the normal.
    pub fn last_opening(&self, nodes: &Nodes) -> f64 {
        (self.slave_mean(&nodes.v) - self.met_mean(&nodes.v)).dot(&self.normal)
    }

    /// Returns the work of the pair's force on its nodes over `mid`, the time from one mid-step
    /// to the next [time]; own pairs only.
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

    /// Returns the history of this pair for the next step.
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
