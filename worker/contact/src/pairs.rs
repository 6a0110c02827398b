//! Contact pairs of a step, own pairs and copies of those of other workers, and their forces on
//! nodes.
//!
//! A worker owns the pairs of the nodes that it owns, and of its edges (`edges.rs`). It receives
//! every other pair that touches one of its local nodes or ghosts; where pairs are few, it computes
//! the forces of some of these too (replicas). So it can sum the contact force on each
//! of these nodes alone, in the same order as every other worker: of the pair keys, and of the
//! schedule (`pairs/schedule.rs`) for changes within Gauss-Seidel sweeps.

mod activity;
mod history;
mod pair;
mod peers;
mod redundant;
mod schedule;

pub use history::PairHistory;
pub use pair::{FIXED_MASS_RATIO, MAX_PAIR_NODES, OpposingPairs, Pair, PairKey, padded};
pub use peers::Peers;

use crate::surface::NOT_LOCAL;
use crate::surroundings::VelocityConstraint;
use crumple_fem::nodes::Nodes;
use crumple_math::row::{Row, V3, row};

/// Smallest share of a side's nodes that can move along the normal. Each node counts with its force
/// weight times its shape value, and with the part of its mobility that is along the normal [-]. A
/// node that closes a gap alone moves faster than the contact point by one over the root of this.
/// A pair with less on both sides has no force: it would throw nodes.
pub const MOVABLE: f64 = 1e-2;

/// Force of all pairs on a node [force], and their moment if any pair has one [force length].
pub type NodalLoad<'a> = (&'a V3, Option<&'a V3>);

/// Sums of predictor forces and of slave masses at a node of the pairs' target side, weighted by
/// force weights, see [`PairTable::predicted_load`].
#[derive(Clone, Copy, Debug, Default)]
pub struct PredictedLoad {
    /// Sum of predictor forces without friction that rotates nodes [force].
    pub force: V3,
    /// Sum of the slave masses along the normal [mass].
    pub mass: f64,
    /// Sum of friction that rotates nodes [force].
    pub tangential_force: V3,
    /// Moment of this friction [force length].
    pub couple: V3,
    /// Sum of the slave masses in the tangent plane, for pairs whose friction rotates nodes
    /// [mass].
    pub sliding_mass: f64,
    /// Sum of these masses times the squares of the lever arms [mass length^2].
    pub turned_mass: f64,
}

/// All pairs of a step that act on local nodes of this worker.
#[derive(Debug, Default)]
pub struct PairTable {
    /// Pairs in ascending order of their keys.
    pub pairs: Vec<Pair>,
    /// Nodes that a pair touches, ascending: local nodes, ghosts, nodes of replicas.
    pub touched: Vec<u32>,
    /// Contact force on each node of `touched` [force].
    pub total: Vec<V3>,
    /// Moment of friction on each node of `touched`, see [`Pair::lever_arms`]; empty if no pair
    /// has one [force length].
    pub couples: Vec<V3>,
    start: Vec<u32>,
    roles: Vec<(u32, u8)>,
    /// For each of `roles` the force weight, negative on the target side.
    signed_shares: Vec<f64>,
    /// For each pair and role, the sum of the force weights, times [`Pair::area`], of all pairs
    /// at the node. It is 0 if the pair does not act on the node; see
    /// [`Self::compute_compliances`].
    weight_sums: Vec<[f64; MAX_PAIR_NODES]>,
    /// Sum of the same products times the lever arms; empty if no pair has a moment.
    moment_weight_sums: Vec<[f64; MAX_PAIR_NODES]>,
    /// True if pairs are weighted by areas, see [`Pair::area`].
    pub by_area: bool,
    /// For each pair and role, the index of its node in `touched`, or [`NOT_LOCAL`] if the pair
    /// does not act on a local node there.
    slots: Vec<[u32; MAX_PAIR_NODES]>,
    schedule: schedule::SweepSchedule,
    activity: activity::Activity,
    incidence: Vec<(u32, u32, u8)>,
}

impl PairTable {
    /// Sorts the pairs in ascending order of their keys, after the pairs of other workers have been
    /// appended. Returns the new index of each pair.
    pub fn sort_by_key(&mut self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.pairs.len() as u32).collect();
        order.sort_unstable_by_key(|&i| self.pairs[i as usize].key);
        let mut place = vec![0u32; order.len()];
        order.iter().enumerate().for_each(|(to, &from)| place[from as usize] = to as u32);
        self.pairs = order.iter().map(|&i| self.pairs[i as usize]).collect();
        place
    }

    /// Lists the pairs that touch each local node, ascending; call it when `pairs` is complete.
    pub fn index_by_node(&mut self) {
        self.incidence.clear();
        for (p, pair) in self.pairs.iter().enumerate() {
            let nodes = pair.nodes[..pair.node_count()].iter().enumerate();
            let roles = nodes.filter(|&(r, &n)| n != NOT_LOCAL && pair.share(r) != 0.0);
            self.incidence.extend(roles.map(|(r, &n)| (n, p as u32, r as u8)));
        }
        self.incidence.sort_unstable();
        self.touched.clear();
        self.start.clear();
        self.roles.clear();
        self.signed_shares.clear();
        self.activity.reset();
        self.slots.clear();
        self.slots.resize(self.pairs.len(), [NOT_LOCAL; MAX_PAIR_NODES]);
        for &(n, p, r) in &self.incidence {
            if self.touched.last() != Some(&n) {
                self.touched.push(n);
                self.start.push(self.roles.len() as u32);
            }
            self.roles.push((p, r));
            self.slots[p as usize][r as usize] = self.touched.len() as u32 - 1;
            let pair = &self.pairs[p as usize];
            let share = pair.share(r as usize);
            self.signed_shares.push(if pair.is_slave_role(r) { share } else { -share });
        }
        self.start.push(self.roles.len() as u32);
        self.total.clear();
        self.total.resize(self.touched.len(), V3::zeros());
        self.couples.clear();
        if self.pairs.iter().any(Pair::has_couple) {
            self.couples.resize(self.touched.len(), V3::zeros());
        }
    }

    /// Returns the group of each pair: pairs that are connected by nodes, directly or through
    /// other pairs. It is the index of the first pair of the group. [`Self::index_by_node`] must
    /// come before.
    pub fn connected_groups(&self) -> Vec<u32> {
        let root = |group: &[u32], mut i: u32| {
            while group[i as usize] != i {
                i = group[i as usize];
            }
            i
        };
        let mut group: Vec<u32> = (0..self.pairs.len() as u32).collect();
        for t in 0..self.touched.len() {
            for two in self.roles_at(t).windows(2) {
                let [a, b] = [0, 1].map(|i| root(&group, two[i].0));
                let first = a.min(b);
                for i in [a, b, two[0].0, two[1].0] {
                    group[i as usize] = first;
                }
            }
        }
        (0..group.len() as u32).map(|i| root(&group, i)).collect()
    }

    /// Removes the replicas that have no effect on own pairs and on nodes with an index below
    /// `held`, not even through other pairs. [`Self::index_by_node`] must come before and after.
    pub fn keep_coupled(&mut self, held: u32) {
        let group = self.connected_groups();
        let mut is_needed = vec![false; group.len()];
        for (pair, &group) in self.pairs.iter().zip(&group) {
            is_needed[group as usize] |= !pair.is_replica || pair.local_nodes().any(|n| n < held);
        }
        let mut groups = group.into_iter();
        self.pairs.retain(|_| groups.next().is_some_and(|group| is_needed[group as usize]));
    }

    /// Keeps the replicas that touch a node with an index below `held`, as copies of the pairs of
    /// their owners, and removes the others. Forces on nodes stay as they are.
    pub fn remove_replicas(&mut self, held: u32) {
        let kept = self.touched.partition_point(|&n| n < held);
        let (total, couples) = (std::mem::take(&mut self.total), std::mem::take(&mut self.couples));
        self.pairs.retain(|p| !p.is_replica || p.local_nodes().any(|n| n < held));
        for pair in self.pairs.iter_mut().filter(|p| p.is_replica) {
            let nodes = pair.nodes.map(|n| if n < held { n } else { NOT_LOCAL });
            *pair = pair.as_copy(nodes);
        }
        self.index_by_node();
        debug_assert_eq!(self.touched.len(), kept, "all pairs of these nodes are kept");
        self.total.copy_from_slice(&total[..kept]);
        if !self.couples.is_empty() {
            self.couples.copy_from_slice(&couples[..kept]);
        }
    }

    /// Divides the forces of own pairs among the nodes of their segments by mass, Wang et al.
    /// (2007), eq. 7 and 11: m_k / M2 = M_k N_k / sum_j M_j N_j. Edges and segments keep their
    /// shape values. It must be called before the pairs are sent to other workers.
    pub fn weight_by_mass(&mut self, nodes: &Nodes) {
        for pair in self.pairs.iter_mut().filter(|p| p.is_owned && p.key.is_node()) {
            let m: [f64; 4] = std::array::from_fn(|k| {
                nodes.contact_mass(pair.nodes[k + 1] as usize) * pair.shape[k + 1]
            });
            let sum: f64 = m.iter().sum();
            if sum > 0.0 {
                pair.weight[1..5].iter_mut().zip(m).for_each(|(w, a)| *w = a / sum);
            }
        }
    }

    /// Computes the compliances of own pairs. `is_split` returns true for the pairs that get parts
    /// of nodal masses; other pairs get full masses.
    ///
    /// If all pairs are split, the mass of a node is divided among the pairs that touch it, in
    /// proportion to their force weights. Then simultaneous updates converge for any masses: for
    /// weights w > 0 the matrix diag(w_p sum_q w_q) - w w^T has no negative eigenvalue
    /// (Gershgorin), so an update is damped at least by the coupling. A pair with a weight of
    /// the size of round-off changes the result only by this size.
    ///
    /// Pairs can be weighted by [`Pair::area`] A: with c the sum of A times the force weight
    /// over all pairs of a node, a pair gets the part A/c of the node's mass, and the update
    /// converges as well.
    ///
    /// A side that hardly moves along the normal counts as fixed ([`MOVABLE`]).
    ///
    /// If friction rotates nodes, the tangential compliance includes their rotational inertias.
    /// These are split in the same way: the weight of a pair in a moment is its force weight
    /// times its lever arm.
    pub fn compute_compliances(
        &mut self,
        nodes: &Nodes,
        constraints: &impl VelocityConstraint,
        is_split: impl Fn(&Pair) -> bool,
    ) {
        self.weight_sums.clear();
        self.weight_sums.resize(self.pairs.len(), [0.0; MAX_PAIR_NODES]);
        self.moment_weight_sums.clear();
        if !self.couples.is_empty() {
            self.moment_weight_sums.resize(self.pairs.len(), [0.0; MAX_PAIR_NODES]);
        }
        for t in 0..self.touched.len() {
            let roles = self.start[t] as usize..self.start[t + 1] as usize;
            let counts = |p: u32, r: u8| {
                self.pairs[p as usize].area * self.pairs[p as usize].share(r as usize)
            };
            let crowd = self.roles[roles.clone()].iter().map(|&(p, r)| counts(p, r)).sum();
            for &(p, r) in &self.roles[roles.clone()] {
                self.weight_sums[p as usize][r as usize] = crowd;
            }
            if !self.moment_weight_sums.is_empty() {
                let turns = |p: u32, r: u8| {
                    counts(p, r) * self.pairs[p as usize].lever_arm_of(r as usize).abs()
                };
                let twist = self.roles[roles.clone()].iter().map(|&(p, r)| turns(p, r)).sum();
                for &(p, r) in &self.roles[roles] {
                    self.moment_weight_sums[p as usize][r as usize] = twist;
                }
            }
        }
        // Two segments without contact area, and redundant pairs, have no force and need no
        // compliance.
        let answers = |p: &Pair| p.is_owned && p.area > 0.0;
        for (i, (pair, crowd)) in self
            .pairs
            .iter_mut()
            .zip(&self.weight_sums)
            .enumerate()
            .filter(|(_, (p, _))| answers(p))
        {
            let mut soft = [0.0; 2];
            let mut sides = [0.0; 2];
            // Force weights of the nodes of either side, and those that can move along the normal.
            let (mut all, mut movable) = ([0.0; 2], [0.0; 2]);
            let mut rolling = 0.0;
            let split = is_split(pair);
            // Roles give the same order on all workers; local numbers do not.
            for r in (0..pair.node_count()).filter(|&r| crowd[r] > 0.0) {
                let inv = constraints.inv_mass(nodes, pair.nodes[r]);
                // A sweep's forces act on the nodes of a rigid body together, after the sweep.
                let together = split || constraints.is_in_body(pair.nodes[r]);
                let moved =
                    if together { crowd[r] / pair.area } else { pair.share(r) } * pair.follows(r);
                let n = &pair.normal;
                let direct = n.x * n.x * inv[0] + n.y * n.y * inv[1] + n.z * n.z * inv[2];
                let largest = inv[0].max(inv[1]).max(inv[2]);
                let side = usize::from(pair.is_slave_role(r as u8));
                let weight = pair.share(r) * pair.follows(r);
                all[side] += weight;
                if direct > 0.0 {
                    movable[side] += weight * (direct / largest);
                }
                soft[0] += moved * direct;
                sides[side] += moved * direct;
                soft[1] += moved * largest;
                let arm = pair.lever_arm_of(r).abs();
                if arm > 0.0 {
                    let inv = constraints.inv_inertia(nodes, pair.nodes[r]);
                    let twist = if together {
                        self.moment_weight_sums[i][r] / pair.area
                    } else {
                        pair.share(r) * arm
                    };
                    rolling += twist * arm * pair.follows(r) * inv[0].max(inv[1]).max(inv[2]);
                }
            }
            // A side that hardly moves still gives way to one that can: without its compliance the
            // sweeps of a heavy slave would not converge.
            if (0..2).all(|side| movable[side] <= MOVABLE * all[side]) {
                (sides, soft[0]) = ([0.0; 2], 0.0);
            }
            pair.compliance = [soft[0], soft[1] + rolling];
            pair.rotational_compliance = rolling;
            pair.stiffer_compliance = sides[0].min(sides[1]);
        }
    }

    /// Sums the contact force and the moment on every touched node.
    pub fn sum_forces(&mut self) {
        (0..self.touched.len()).for_each(|t| self.sum_forces_at(t));
    }

    /// Sums the contact force and the moment on the node at index `t` of `touched`.
    fn sum_forces_at(&mut self, t: usize) {
        self.total[t] = self.force_at(t);
        if !self.couples.is_empty() {
            self.couples[t] = self.couple_at(t);
        }
    }

    /// Marks all pairs for an update in the next sweep, because velocities have changed other than
    /// by the forces of pairs.
    pub fn mark_all_changed(&mut self) {
        self.schedule.mark_all();
        if self.activity.is_started() {
            self.start_activity();
        }
    }

    /// Returns the own pairs, ascending.
    pub fn own_pairs(&self) -> Vec<u32> {
        (0..).zip(&self.pairs).filter(|(_, p)| p.is_owned).map(|(i, _)| i).collect()
    }

    /// Returns the pairs that touch the node at index `t` of `touched`, ascending, and its role
    /// in each.
    fn roles_at(&self, t: usize) -> &[(u32, u8)] {
        &self.roles[self.start[t] as usize..self.start[t + 1] as usize]
    }

    /// Returns the sum of the forces of all pairs on the node at index `t` of `touched` [force].
    fn force_at(&self, t: usize) -> V3 {
        let shares = &self.signed_shares[self.start[t] as usize..self.start[t + 1] as usize];
        let mut sum = V3::zeros();
        for (&(p, _), &share) in self.roles_at(t).iter().zip(shares) {
            sum += self.pairs[p as usize].force * share;
        }
        sum
    }

    /// Returns the sum of the moments of all pairs on the node at index `t` of `touched` [force
    /// length].
    fn couple_at(&self, t: usize) -> V3 {
        let mut sum = V3::zeros();
        for &(p, r) in self.roles_at(t) {
            let pair = &self.pairs[p as usize];
            let arm = pair.lever_arm_of(r as usize);
            if arm != 0.0 {
                sum += pair.twist(&pair.force) * (arm * pair.share(r as usize));
            }
        }
        sum
    }

    /// Returns the sum of the predictor forces [force] and of the slave masses [mass] of the
    /// pairs that have the node at index `t` of `touched` on their target side, weighted by
    /// force weights. Pairs without a predictor force are left out.
    pub fn predicted_normal_load(&self, t: usize) -> (V3, f64) {
        let (mut force, mut mass) = (V3::zeros(), 0.0);
        for &(p, r) in self.roles_at(t) {
            let pair = &self.pairs[p as usize];
            if !pair.is_slave_role(r) && pair.predictor_force != V3::zeros() {
                force += pair.predictor_force * pair.share(r as usize);
                mass += pair.slave_mass * pair.share(r as usize);
            }
        }
        (force, mass)
    }

    /// Returns the sums of [`Self::predicted_normal_load`] for a step in which friction can
    /// rotate nodes. For pairs with a friction couple, the tangential part of the predictor
    /// force is summed separately.
    pub fn predicted_load(&self, t: usize) -> PredictedLoad {
        let mut sum = PredictedLoad::default();
        for &(p, r) in self.roles_at(t) {
            let pair = &self.pairs[p as usize];
            if pair.is_slave_role(r) || pair.predictor_force == V3::zeros() {
                continue;
            }
            let (share, arm) = (pair.share(r as usize), pair.lever_arm_of(r as usize));
            sum.mass += pair.slave_mass * share;
            if pair.has_couple() {
                let pressed = pair.normal * pair.predictor_force.dot(&pair.normal);
                sum.force += pressed * share;
                sum.tangential_force += (pair.predictor_force - pressed) * share;
                sum.couple += pair.twist(&pair.predictor_force) * (arm * share);
                sum.sliding_mass += pair.slave_sliding_mass * share;
                sum.turned_mass += pair.slave_sliding_mass * share * arm * arm;
            } else {
                sum.force += pair.predictor_force * share;
            }
        }
        sum
    }

    /// Finds the pairs that push back from the side of the own pair `pair`. Their slaves are
    /// nodes of its target. A slave has settled if its predictor force is at most the fraction
    /// `little` of its force.
    pub fn opposing_pairs(&self, pair: &Pair, little: f64) -> OpposingPairs {
        let mut found = OpposingPairs { free: false, held: false, settled: true };
        let places = (pair.slave_node_count()..pair.node_count()).filter(|&r| pair.share(r) != 0.0);
        let places = places.filter_map(|r| self.touched.binary_search(&pair.nodes[r]).ok());
        for &(q, _) in places
            .flat_map(|t| self.roles_at(t))
            .filter(|&&(q, r)| self.pairs[q as usize].is_slave_role(r))
        {
            let other = &self.pairs[q as usize];
            let force = other.force + other.predictor_force;
            if force.dot(&pair.normal) < 0.0 {
                found.free |= !other.slave_is_fixed;
                found.held |= other.slave_is_fixed;
                found.settled &=
                    other.slave_is_fixed || other.predictor_force.norm() <= little * force.norm();
            }
        }
        found
    }

    /// Returns true if a local node is the slave of a pair whose normal is at less than 60
    /// degrees to `normal`.
    pub fn bears(&self, node: u32, normal: &V3) -> bool {
        let Ok(t) = self.touched.binary_search(&node) else { return false };
        let of = |&(q, r): &(u32, u8)| {
            let pair = &self.pairs[q as usize];
            r == 0 && pair.key.is_node() && pair.normal.dot(normal) > 0.5
        };
        self.roles_at(t).iter().any(of)
    }
}

/// Returns the velocity row `v` after the impulse `force * dt`.
pub fn accelerated_velocity(v: &Row, force: &V3, inv_mass: &Row, dt: f64) -> Row {
    let f = row([force.x, force.y, force.z]);
    std::array::from_fn(|c| v[c] + dt * f[c] * inv_mass[c])
}
