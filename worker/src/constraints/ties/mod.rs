//! Tied nodes: each slave follows the nodes of a face (its masters), on any number of workers.
//!
//! A slave s has a weight `N_k > 0` for each master k; the weights sum to 1. Its velocity is
//! `v_s = sum N_k v_k`. At the start its mass is added to the masters, `M_k += N_k m_s`, and in
//! every step its force, `f_k += N_k f_s`. This conserves momentum and, because `f_s v_s = sum
//! N_k f_s v_k`, energy. The stable step does not decrease: the largest eigenvalue of the
//! elements at s with the masses of the masters is at most the one with the slave's own mass,
//! because `m_s |sum N_k v_k|^2 <= sum N_k m_s |v_k|^2` (Jensen).
//!
//! A slave with an offset is at the end of an arm d from the weighted mean position of its
//! masters. The arm rotates with their mean rotation: `v_s = sum N_k (v_k + w_k x d)`. The
//! moment `d x f_s` acts on the masters, `N_k` of it on each, which conserves angular momentum.
//! Their inertias increase by `ARM_INERTIA` times `N_k m_s d^2`: with `|v + w x d|^2 <= (1 + a)
//! |v|^2 + (1 + 1/a) d^2 |w|^2` the stable step of the elements at s is at least `1/sqrt(1 +
//! a)` of their own. The master rank takes this into account (`share` of their records).
//!
//! A slave can also follow the mean motion of any set of masters, see `mean.rs`.
//!
//! If a slave starts with another velocity than its masters, the difference acts on them as an
//! impulse, so that the momentum of the mesh is conserved. When the element of its face fails, or
//! the tie itself, see `failure.rs`, the slave is released. It takes back its mass, and the
//! momentum of this mass at the face.
//!
//! Contact uses the original mass of a slave, which is less than the mass of its masters.
//! Contact forces of one step are therefore too small rather than too large. They are added to
//! the masters after the sweeps and before rigid walls act on these. Walls ignore slaves.
//!
//! Every worker has all ties. Forces on slaves come from the workers that own them, and so do
//! the velocities of masters. They are summed in ascending id of the slaves, and of the masters
//! of a slave, so that all workers compute the same bits.

mod build;
pub(super) mod exchange;
pub(super) mod failure;
mod mean;
pub mod project;

use crate::contact::Contact;
use crate::math::row::{Row, V3, xyz};
use crate::nodes::Nodes;
use crate::time::StepSizes;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::tie::Tie;
use crumple_proto::transport::{Mailbox, RankLost, Transport, gather_all};
use exchange::{Link, PackedNode, receive, send};
use failure::{Breakable, BrokenTies};
use mean::MeanRotation;
use nalgebra::Rotation3;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashSet};

/// Index of a node that is not present here.
const NONE: u32 = u32::MAX;
/// `1 / (1 + a)`: fraction of the mass at the end of an arm on which the stable step of the
/// elements there is based. Their step is 0.9 of the one without the arm. A larger value would
/// increase the inertia of the masters further.
pub const ARM_SHARE: f64 = 0.81;
/// `1 + 1/a`.
const ARM_INERTIA: f64 = ARM_SHARE / (1.0 - ARM_SHARE) + 1.0;

/// All ties. A checkpoint has all fields that are not skipped: those are derived from the local
/// mesh.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Ties {
    definitions: Vec<Tie>,
    /// True if any tie includes rotations or has an offset; and true if any has an offset.
    turn: bool,
    arms: bool,
    /// True if any slave follows the mean motion of its masters.
    means: bool,
    /// Original mass and inertia of each slave, and the inertia that it adds to its masters.
    slave_masses: Vec<[f64; 2]>,
    added_inertia: Vec<f64>,
    /// For each tie what it has if it can fail; empty if none can.
    breakable: Vec<Option<Breakable>>,
    /// Ties that have broken and are not released yet.
    broken: BrokenTies,
    /// All masters and corners of faces of ties that can fail, ascending.
    masters: Vec<NodeId>,
    /// Masters of each tie by number, with their weights.
    shares: Vec<Vec<(u32, f64)>>,
    /// Local indices of slaves and of masters.
    #[serde(skip)]
    slave_index: Vec<u32>,
    #[serde(skip)]
    master_index: Vec<u32>,
    /// Ties whose slave is present here, and ties with a master that is present here.
    #[serde(skip)]
    local_slaves: Vec<u32>,
    #[serde(skip)]
    force_sources: Vec<u32>,
    #[serde(skip)]
    links: Vec<Link>,
    /// For each node here, the start of its range in `partners`: the partners of a slave, or
    /// the slaves of which the node is a partner.
    #[serde(skip)]
    partner_start: Vec<u32>,
    #[serde(skip)]
    partners: Vec<u32>,
    /// Force and moment on each slave, as far as they are known here.
    slave_loads: Vec<[V3; 2]>,
    /// Velocities of masters that other workers own, and their positions.
    master_velocities: Vec<[[f64; 3]; 2]>,
    master_positions: Vec<[f64; 3]>,
    /// Contact forces of this step that were added to masters.
    contact_forces: Vec<V3>,
    #[serde(skip)]
    mail: Mailbox,
}

/// A tie that begins in the run.
pub struct AddedTie {
    /// The tie.
    pub tie: Tie,
    /// Mass and rotational inertia of its slave [mass], [mass length^2].
    pub mass: [f64; 2],
}

impl Ties {
    /// Checks that these are ties of a job; some may be released.
    ///
    /// # Errors
    /// They are not: the reason.
    pub fn validate(&self, jobs: &[Tie]) -> Result<(), String> {
        let known = |tie: &Tie| {
            jobs.binary_search_by_key(&tie.node, |j| j.node).is_ok_and(|i| jobs[i] == *tie)
        };
        if let Some(tie) = self.definitions.iter().find(|tie| !known(tie)) {
            return Err(format!("the job does not have its tie of node {}", tie.node));
        }
        let ascends = self.definitions.is_sorted_by(|a, b| a.node < b.node);
        let (ties, masters) = (self.definitions.len(), self.masters.len());
        let of_ties = [self.shares.len(), self.slave_masses.len(), self.added_inertia.len()];
        let of_masters = [self.master_velocities.len(), self.master_positions.len()];
        let is_share = |(&(number, weight), &(id, wanted)): (&(u32, f64), &(NodeId, f64))| {
            self.masters.get(number as usize) == Some(&id) && weight == wanted
        };
        let is_of = |(shares, tie): (&Vec<(u32, f64)>, &Tie)| {
            shares.len() == tie.masters.len() && shares.iter().zip(&tie.masters).all(is_share)
        };
        let is_face = |b: &Option<Breakable>| {
            b.is_none_or(|b| b.corners.iter().all(|&c| (c as usize) < masters))
        };
        let can_fail = (self.breakable.is_empty() || self.breakable.len() == ties)
            && self.breakable.iter().all(is_face)
            && (self.broken.is_empty() || !self.breakable.is_empty());
        let are_complete = can_fail
            && of_ties.iter().chain([&self.slave_loads.len()]).all(|&n| n == ties)
            && of_masters.iter().chain([&self.contact_forces.len()]).all(|&n| n == masters)
            && self.masters.is_sorted_by(|a, b| a < b)
            && self.shares.iter().zip(&self.definitions).all(is_of);
        if ascends && are_complete {
            return Ok(());
        }
        Err("its ties do not have the masters of the job".into())
    }

    /// Adds the momentum of slaves, minus the one they have when they follow their masters, to
    /// the masters. The masters in `carrying` have their own masses.
    fn share_momentum(&self, tied: &[PackedNode], arms: &[V3], carrying: &mut [PackedNode]) {
        let mut totals: Vec<[f64; 2]> = carrying.iter().map(|c| [c.mass, c.inertia]).collect();
        let mut pushes = vec![[V3::zeros(); 2]; carrying.len()];
        for (t, shares) in self.shares.iter().enumerate() {
            let [mass, inertia] = self.slave_masses[t];
            let mean = self.definitions[t].mean;
            let rotation = MeanRotation::new(shares, |c| carrying[c].x);
            let spin = match mean {
                true => rotation.spin(shares, |c| carrying[c].x, |c| carrying[c].v),
                false => V3::from(xyz(&blend(shares, |c| carrying[c].w))),
            };
            let led = V3::from(xyz(&blend(shares, |c| carrying[c].v))) + spin.cross(&arms[t]);
            let push = (V3::from(tied[t].v) - led) * mass;
            let mut turn = arms[t].cross(&push);
            if self.turn && self.definitions[t].rotations && !mean {
                turn += (V3::from(tied[t].w) - spin) * inertia;
            }
            for &(c, share) in shares {
                let c = c as usize;
                totals[c][0] += share * mass;
                totals[c][1] += share * self.added_inertia[t];
                if mean {
                    pushes[c][0] += rotation.force_on(carrying[c].x, share, [push, turn]);
                    continue;
                }
                pushes[c][0] += push * share;
                pushes[c][1] += turn * share;
            }
        }
        for ((state, [mass, inertia]), [push, turn]) in carrying.iter_mut().zip(totals).zip(pushes)
        {
            let free = |dof: usize| state.fixed >> dof & 1 == 0;
            for k in 0..3 {
                state.v[k] += if free(k) && mass > 0.0 { push[k] / mass } else { 0.0 };
                state.w[k] += if free(3 + k) && inertia > 0.0 { turn[k] / inertia } else { 0.0 };
            }
        }
    }

    /// Adds mass and inertia of a slave to its masters here, multiplied by `factor`; -1 removes
    /// them.
    fn add_masses(&self, t: usize, factor: f64, nodes: &mut Nodes) {
        for &(c, share) in &self.shares[t] {
            let Some(n) = nodes.index_of(self.masters[c as usize]).map(|n| n as usize) else {
                continue;
            };
            nodes.mass[n] += factor * share * self.slave_masses[t][0];
            if self.added_inertia[t] > 0.0 {
                nodes.inertia[n] += factor * share * self.added_inertia[t];
            }
            nodes.invert_mass(n);
        }
    }

    /// Releases slaves whose face belongs to an element that has just failed on any worker. Returns
    /// true if there are any; the local mesh must be built again then. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn release_failed(
        &mut self,
        comm: &mut dyn Transport,
        failed: &[ElemId],
        nodes: &mut Nodes,
    ) -> Result<bool, RankLost> {
        if self.is_empty() {
            return Ok(false);
        }
        let failed: HashSet<ElemId> = failed.iter().copied().collect();
        let holds =
            |t: &usize| !self.definitions[*t].faces.iter().any(|elem| failed.contains(elem));
        let here: Vec<u64> =
            (0..self.definitions.len()).filter(|t| !holds(t)).map(|t| t as u64).collect();
        let released: BTreeSet<usize> =
            gather_all(comm, here)?.into_iter().flatten().map(|t| t as usize).collect();
        self.release(&released, nodes);
        Ok(!released.is_empty())
    }

    /// Releases the slaves of ties, which take back their masses.
    fn release(&mut self, released: &BTreeSet<usize>, nodes: &mut Nodes) {
        for &t in released {
            self.add_masses(t, -1.0, nodes);
            if let Some(n) = nodes.index_of(self.definitions[t].node).map(|n| n as usize) {
                if self.has_arm(&self.definitions[t]) {
                    // The masters had the mass at the foot of the arm: with their velocity the
                    // slave takes back the momentum that it gave.
                    let held = |c: usize| {
                        Some(self.master_index[c] as usize).filter(|&k| k < nodes.local_count)
                    };
                    nodes.v[n] = blend(&self.shares[t], |c| {
                        held(c).map_or(self.master_velocities[c][0], |k| xyz(&nodes.v[k]))
                    });
                    nodes.v_next[n] = nodes.v[n];
                }
                nodes.mass[n] = self.slave_masses[t][0];
                if self.turn && self.definitions[t].rotations {
                    nodes.inertia[n] = self.slave_masses[t][1];
                }
                nodes.invert_mass(n);
            }
        }
        for &t in released {
            self.broken.remove(&self.definitions[t].node);
        }
        keep(&mut self.definitions, released);
        keep(&mut self.shares, released);
        keep(&mut self.slave_masses, released);
        keep(&mut self.added_inertia, released);
        keep(&mut self.breakable, released);
        self.slave_loads.truncate(self.definitions.len());
        if self.definitions.is_empty() {
            *self = Self::default();
        }
    }

    /// Replaces the ties of the slaves for which `is_replaced` is true by others, whose masters
    /// have the masses of the slaves already. No tie may be one that can fail.
    pub fn replace(
        &mut self,
        is_replaced: impl Fn(NodeId) -> bool,
        by: Vec<AddedTie>,
        rotations: bool,
    ) {
        let (old, masses, inertias) = (
            std::mem::take(&mut self.definitions),
            std::mem::take(&mut self.slave_masses),
            std::mem::take(&mut self.added_inertia),
        );
        let old = old.into_iter().zip(masses).zip(inertias);
        let kept = old.map(|((tie, mass), inertia)| (tie, mass, inertia));
        let added = by.into_iter().map(|added| (added.tie, added.mass, added.mass[1]));
        let mut all: Vec<(Tie, [f64; 2], f64)> =
            kept.filter(|(tie, ..)| !is_replaced(tie.node)).chain(added).collect();
        all.sort_by_key(|(tie, ..)| tie.node);
        let mut ties = Self::of_jobs(all.iter().map(|(tie, ..)| tie.clone()).collect(), rotations);
        (ties.slave_masses, ties.added_inertia) =
            all.into_iter().map(|(_, mass, inertia)| (mass, inertia)).unzip();
        *self = ties;
    }

    /// Finds the slaves and masters that are present here, and sets up the exchange.
    /// Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn bind_local(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
    ) -> Result<(), RankLost> {
        if self.definitions.is_empty() {
            return Ok(());
        }
        let here = |id: NodeId| nodes.index_of(id).unwrap_or(NONE);
        self.slave_index = self.definitions.iter().map(|t| here(t.node)).collect();
        self.master_index = self.masters.iter().map(|&id| here(id)).collect();
        let numbers = 0..self.definitions.len() as u32;
        self.local_slaves =
            numbers.clone().filter(|&t| self.slave_index[t as usize] != NONE).collect();
        let carried_here = |t: &u32| {
            self.shares[*t as usize].iter().any(|s| self.master_index[s.0 as usize] != NONE)
        };
        self.force_sources = numbers.filter(carried_here).collect();
        for &t in &self.local_slaves {
            let (n, mass) =
                (self.slave_index[t as usize] as usize, self.slave_masses[t as usize][0]);
            let free = |c: usize| if nodes.fixed[n] >> c & 1 == 1 { 0.0 } else { 1.0 / mass };
            nodes.inv_mass[n] =
                if mass > 0.0 { [free(0), free(1), free(2), 0.0] } else { [0.0; 4] };
        }
        self.list_partners(nodes);
        self.link(comm, nodes)
    }

    /// Lists the partners of each node, by local index.
    fn list_partners(&mut self, nodes: &Nodes) {
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for &t in &self.local_slaves {
            let tied = self.slave_index[t as usize];
            let partners =
                self.definitions[t as usize].partners().filter_map(|id| nodes.index_of(id));
            partners.for_each(|n| pairs.extend([(tied, n), (n, tied)]));
        }
        pairs.sort_unstable();
        self.partner_start =
            (0..=nodes.len() as u32).map(|n| pairs.partition_point(|p| p.0 < n) as u32).collect();
        self.partners = pairs.into_iter().map(|p| p.1).collect();
    }

    /// Returns the number of ties.
    pub fn count(&self) -> usize {
        self.definitions.len()
    }

    /// Returns true if there are no ties.
    pub fn is_empty(&self) -> bool {
        self.definitions.is_empty()
    }

    /// Returns true if the node is a slave and the segment has one of its partners, or vice
    /// versa.
    pub fn are_tied(&self, node: u32, segment: &[u32; 4]) -> bool {
        let run = match self.partner_start.get(node as usize..node as usize + 2) {
            Some(&[from, to]) => &self.partners[from as usize..to as usize],
            _ => &[],
        };
        !run.is_empty() && segment.iter().any(|corner| run.binary_search(corner).is_ok())
    }

    /// Distributes the forces and moments on slaves to their masters, once all but contact
    /// forces are known.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn distribute_forces(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
    ) -> Result<(), RankLost> {
        if self.is_empty() {
            return Ok(());
        }
        if self.arms || self.can_fail() {
            self.exchange_positions(comm, nodes)?;
        }
        for t in 0..self.local_slaves.len() {
            let t = self.local_slaves[t] as usize;
            let n = self.slave_index[t] as usize;
            if n < nodes.local_count {
                let force = V3::from(xyz(&nodes.force[n]));
                let mut moment = self.arm(t, nodes).cross(&force);
                if self.turn && self.definitions[t].rotations {
                    moment += V3::from(xyz(&nodes.moment[n]));
                }
                self.slave_loads[t] = [force, moment];
            }
        }
        self.exchange_slave_forces(comm)?;
        for &t in &self.force_sources {
            let [force, moment] = self.slave_loads[t as usize];
            let turns = self.turns(t as usize);
            let mean = self.mean_rotation(t as usize, nodes);
            for &(c, share) in &self.shares[t as usize] {
                let n = self.master_index[c as usize] as usize;
                if n >= nodes.local_count {
                    continue;
                }
                if let Some(mean) = &mean {
                    let f = mean.force_on(xyz(&nodes.x[n]), share, [force, moment]);
                    (0..3).for_each(|k| nodes.force[n][k] += f[k]);
                    continue;
                }
                (0..3).for_each(|k| nodes.force[n][k] += share * force[k]);
                if turns {
                    (0..3).for_each(|k| nodes.moment[n][k] += share * moment[k]);
                }
            }
        }
        Ok(())
    }

    /// Distributes the contact forces on slaves to their masters and updates the velocities of
    /// these.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn distribute_contact_forces(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        contact: &Contact,
        steps: StepSizes,
    ) -> Result<(), RankLost> {
        if self.is_empty() {
            return Ok(());
        }
        for &t in &self.local_slaves {
            let n = self.slave_index[t as usize];
            if (n as usize) < nodes.local_count {
                let force = contact.force_on(n);
                self.slave_loads[t as usize] = [force, self.arm(t as usize, nodes).cross(&force)];
            }
        }
        self.exchange_slave_forces(comm)?;
        self.contact_forces.fill(V3::zeros());
        for &t in &self.force_sources {
            let [force, moment] = self.slave_loads[t as usize];
            let mean = self.mean_rotation(t as usize, nodes);
            for &(c, share) in self.shares[t as usize].iter().filter(|_| force != V3::zeros()) {
                let n = self.master_index[c as usize];
                let (force, times) = match &mean {
                    Some(mean) => {
                        let place = self.master_place(c as usize, nodes);
                        (mean.force_on(place, share, [force, moment]), 1.0)
                    }
                    None => (force, share),
                };
                if self.turns(t as usize) && (n as usize) < nodes.local_count {
                    let (next, inverse) =
                        (&mut nodes.w_next[n as usize], &nodes.inv_inertia[n as usize]);
                    (0..3)
                        .for_each(|k| next[k] += steps.dt_damped * share * moment[k] * inverse[k]);
                }
                if n != NONE {
                    let (next, inverse) =
                        (&mut nodes.v_next[n as usize], &nodes.inv_mass[n as usize]);
                    (0..3).for_each(|k| next[k] += steps.dt_damped * times * force[k] * inverse[k]);
                    self.contact_forces[c as usize] += force * times;
                }
            }
        }
        Ok(())
    }

    /// Adds the effect of [`Ties::contact_force_on_master`] to velocities of local nodes that
    /// do not include it.
    pub fn add_contact_forces(
        &self,
        velocities: &mut [(u32, Row)],
        nodes: &Nodes,
        steps: StepSizes,
    ) {
        for (n, v) in velocities.iter_mut().filter(|_| !self.is_empty()) {
            let (force, inverse) =
                (self.contact_force_on_master(*n, nodes), &nodes.inv_mass[*n as usize]);
            (0..3).for_each(|k| v[k] += steps.dt_damped * force[k] * inverse[k]);
        }
    }

    /// Returns the contact force of this step on the slaves of local node `n` [force].
    pub fn contact_force_on_master(&self, n: u32, nodes: &Nodes) -> V3 {
        self.masters
            .binary_search(&nodes.id[n as usize])
            .map_or(V3::zeros(), |c| self.contact_forces[c])
    }

    /// Returns true if a tie exerts moments on its masters.
    fn turns(&self, t: usize) -> bool {
        let tie = &self.definitions[t];
        self.turn && (tie.rotations || tie.offset) && !tie.mean
    }

    /// Returns the position of a master that is present here or that this worker receives.
    fn master_place(&self, c: usize, nodes: &Nodes) -> [f64; 3] {
        match self.master_index[c] as usize {
            n if n < nodes.local_count => xyz(&nodes.x[n]),
            _ => self.master_positions[c],
        }
    }

    /// Returns the mean rotation of the masters of a tie that follows it.
    fn mean_rotation(&self, t: usize, nodes: &Nodes) -> Option<MeanRotation> {
        let place = |c: usize| self.master_place(c, nodes);
        self.definitions[t].mean.then(|| MeanRotation::new(&self.shares[t], place))
    }

    /// Returns true if the slave of a tie is at the end of an arm.
    fn has_arm(&self, tie: &Tie) -> bool {
        self.arms && tie.offset && (self.turn || tie.mean)
    }

    /// Returns the vector from the mean position of the masters to a slave here; zero without
    /// an offset [length].
    fn arm(&self, t: usize, nodes: &Nodes) -> V3 {
        if !self.has_arm(&self.definitions[t]) {
            return V3::zeros();
        }
        let foot = blend(&self.shares[t], |c| self.master_place(c, nodes));
        V3::from(xyz(&nodes.x[self.slave_index[t] as usize])) - V3::from(xyz(&foot))
    }

    /// Sets the velocities of the slaves here from those of their masters.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn update_slave_velocities(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        dt: f64,
    ) -> Result<(), RankLost> {
        if self.is_empty() {
            return Ok(());
        }
        let Self { links, mail, master_index, master_velocities, .. } = self;
        let local = |c: u32| master_index[c as usize] as usize;
        if self.turn {
            let both = |c| [&nodes.v_next, &nodes.w_next].map(|rows| xyz(&rows[local(c)]));
            send(comm, (links, mail), |l| &l.masters_out, both)?;
            receive(
                comm,
                (links, mail),
                |l| &l.masters_in,
                |c, both| {
                    master_velocities[c as usize] = both;
                },
            )?;
        } else {
            send(comm, (links, mail), |l| &l.masters_out, |c| xyz(&nodes.v_next[local(c)]))?;
            receive(
                comm,
                (links, mail),
                |l| &l.masters_in,
                |c, v| {
                    master_velocities[c as usize] = [v, [0.0; 3]];
                },
            )?;
        }
        for &t in &self.local_slaves {
            let (n, shares) = (self.slave_index[t as usize] as usize, &self.shares[t as usize]);
            let held =
                |c: usize| Some(self.master_index[c] as usize).filter(|&k| k < nodes.local_count);
            nodes.v_next[n] = blend(shares, |c| {
                held(c).map_or(self.master_velocities[c][0], |k| xyz(&nodes.v_next[k]))
            });
            let (rotations, arm) =
                (self.definitions[t as usize].rotations, self.arm(t as usize, nodes));
            let mean = self.mean_rotation(t as usize, nodes);
            if !((self.turn || mean.is_some()) && (rotations || arm != V3::zeros())) {
                continue;
            }
            let spin = match mean {
                Some(mean) => {
                    let velocity = |c: usize| {
                        held(c).map_or(self.master_velocities[c][0], |k| xyz(&nodes.v_next[k]))
                    };
                    let place = |c: usize| self.master_place(c, nodes);
                    crate::math::row::row(mean.spin(shares, place, velocity).into())
                }
                None => blend(shares, |c| {
                    held(c).map_or(self.master_velocities[c][1], |k| xyz(&nodes.w_next[k]))
                }),
            };
            if self.turn && rotations && n < nodes.local_count {
                nodes.w_next[n] = spin;
            }
            if arm != V3::zeros() {
                // Displacement of the arm's end at constant length, over the step.
                let moved = (Rotation3::new(V3::from(xyz(&spin)) * dt) * arm - arm) / dt;
                (0..3).for_each(|k| nodes.v_next[n][k] += moved[k]);
            }
        }
        Ok(())
    }

    /// Exchanges the positions of masters that other workers own.
    fn exchange_positions(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &Nodes,
    ) -> Result<(), RankLost> {
        let Self { links, mail, master_index, master_positions, .. } = self;
        let position = |c: u32| xyz(&nodes.x[master_index[c as usize] as usize]);
        send(comm, (links, mail), |l| &l.masters_out, position)?;
        receive(comm, (links, mail), |l| &l.masters_in, |c, x| master_positions[c as usize] = x)
    }

    /// Sends the forces on owned slaves to the workers that have their masters.
    fn exchange_slave_forces(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let Self { links, mail, slave_loads, .. } = self;
        if self.turn || self.means {
            send(comm, (links, mail), |l| &l.slaves_out, |t| slave_loads[t as usize])?;
            receive(comm, (links, mail), |l| &l.slaves_in, |t, load| slave_loads[t as usize] = load)
        } else {
            send(comm, (links, mail), |l| &l.slaves_out, |t| slave_loads[t as usize][0])?;
            receive(
                comm,
                (links, mail),
                |l| &l.slaves_in,
                |t, force| {
                    slave_loads[t as usize] = [force, V3::zeros()];
                },
            )
        }
    }
}

/// Removes the entries whose numbers are in `out`.
fn keep<T>(list: &mut Vec<T>, out: &BTreeSet<usize>) {
    let mut number = 0..;
    list.retain(|_| number.next().is_none_or(|n| !out.contains(&n)));
}

/// Returns the weighted mean of the masters' vectors, summed in ascending order.
fn blend(shares: &[(u32, f64)], of: impl Fn(usize) -> [f64; 3]) -> Row {
    let mut sum = [0.0; 4];
    for &(c, share) in shares {
        let v = of(c as usize);
        (0..3).for_each(|k| sum[k] += share * v[k]);
    }
    sum
}
