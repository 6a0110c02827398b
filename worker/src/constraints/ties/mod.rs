//! Tied nodes: each is carried by the nodes of a face, on any number of workers.
//!
//! A node s has a share `N_k > 0` of each carrier k, together 1, and goes as they do: `v_s = sum
//! N_k v_k`. At the start its mass goes to them, `M_k += N_k m_s`, and in every step the force on
//! it, `f_k += N_k f_s`. So momentum is kept, and with `f_s v_s = sum N_k f_s v_k` energy too. The
//! stable step does not shrink: of the elements at s the largest eigenvalue with the masses of its
//! carriers is no larger than with its own, since `m_s |sum N_k v_k|^2 <= sum N_k m_s |v_k|^2`
//! (Jensen).
//!
//! A node with an offset stands at the end of an arm d from its carriers' mean place, which turns
//! with their mean rotation: `v_s = sum N_k (v_k + w_k x d)`, and `d x f_s` is a moment on them,
//! `N_k` on each, so that angular momentum is kept too. Their inertias grow by `ARM_INERTIA` times
//! `N_k m_s d^2`: with `|v + w x d|^2 <= (1 + a) |v|^2 + (1 + 1/a) d^2 |w|^2` the stable step of
//! the elements at s is then at least `1/sqrt(1 + a)` of their own, which the master reckons with
//! (`share` of their records).
//!
//! A node that starts with another velocity than its carriers gives them the difference as an
//! impulse, so that momentum is what the mesh came with. When the element of its face fails the
//! node is free again and takes back its mass, and the momentum that this had at the face.
//!
//! Contact sees a tied node with the mass that it had, which is less than what carries it: too
//! little is given back in one step rather than too much. Its forces go to the carriers after the
//! sweeps, before these meet rigid walls. Walls do not see tied nodes.
//!
//! Every worker knows all ties. Forces on tied nodes come from the workers that own these,
//! velocities of carriers likewise; they are added up in ascending id of the tied nodes, and of a
//! node's carriers, so that all compute the same bits.

pub mod project;

use crate::constraints::rigid::Bodies;
use crate::contact::Contact;
use crate::contact::enforce::StepSizes;
use crate::contact::geometry::V3;
use crate::nodes::{Nodes, Row, xyz};
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::partition::Settings;
use crumple_proto::tie::Tie;
use crumple_proto::transport::{RankLost, Tag, Transport, exchange_all};
use nalgebra::Rotation3;
use std::collections::{BTreeSet, HashSet};

/// Stands for a node that is not local.
const NONE: u32 = u32::MAX;
/// `1 / (1 + a)`: what is fastened to the end of an arm counts on so much of the mass there, and
/// has 0.9 of the step that it would have without. More would make carriers still heavier to turn.
pub const ARM_SHARE: f64 = 0.81;
/// `1 + 1/a`.
const ARM_INERTIA: f64 = ARM_SHARE / (1.0 - ARM_SHARE) + 1.0;

/// A tied node or a carrier as all workers learn of it at the start.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct PackedNode {
    number: u64,
    fixed: u64,
    mass: f64,
    inertia: f64,
    x: [f64; 3],
    v: [f64; 3],
    w: [f64; 3],
}

/// What goes to and comes from another worker in every step, by numbers of ties and of carriers.
#[derive(Debug, Default)]
struct Link {
    worker: usize,
    slaves_out: Vec<u32>,
    slaves_in: Vec<u32>,
    masters_out: Vec<u32>,
    masters_in: Vec<u32>,
}

/// All ties.
#[derive(Debug, Default)]
pub struct Ties {
    definitions: Vec<Tie>,
    /// Whether any ties rotations or has an arm, and whether any has an arm.
    turn: bool,
    arms: bool,
    /// Masses and inertias that tied nodes had, and the inertias that carriers have of them.
    slave_masses: Vec<[f64; 2]>,
    added_inertia: Vec<f64>,
    /// All carriers, ascending.
    masters: Vec<NodeId>,
    /// Carriers of each tie by their number, with their shares.
    shares: Vec<Vec<(u32, f64)>>,
    /// Local numbers of tied nodes and of carriers.
    slave_index: Vec<u32>,
    master_index: Vec<u32>,
    /// Ties whose node is local, and those of which a carrier is.
    local_slaves: Vec<u32>,
    force_sources: Vec<u32>,
    links: Vec<Link>,
    /// For each local node, the start of its run in `partners`: those of a tied node, and the tied
    /// nodes of which it is one.
    partner_start: Vec<u32>,
    partners: Vec<u32>,
    /// Force and moment on each tied node, as far as they are known here.
    slave_loads: Vec<[V3; 2]>,
    /// Velocities of carriers that others own, and their places.
    master_velocities: Vec<[[f64; 3]; 2]>,
    master_positions: Vec<[f64; 3]>,
    /// Contact forces that carriers were given in this step.
    contact_forces: Vec<V3>,
    words: Vec<u64>,
}

/// What contact does not look at: nodes and segments that cannot move against each other.
#[derive(Clone, Copy)]
pub struct ContactExclusions<'a> {
    /// Rigid bodies.
    pub bodies: &'a Bodies,
    /// Ties.
    pub ties: &'a Ties,
}

impl ContactExclusions<'_> {
    /// Whether a node and a segment belong to one body, or one is tied to the other.
    pub fn excludes(&self, slave: u32, segment: &[u32; 4]) -> bool {
        self.bodies.share_body(slave, segment) || self.ties.are_tied(slave, segment)
    }
}

impl Ties {
    /// Ties nodes: masses go to carriers, velocities follow. All workers call this together.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn new(
        comm: &mut dyn Transport,
        settings: &Settings,
        nodes: &mut Nodes,
    ) -> Result<Self, RankLost> {
        let jobs = settings.ties.clone();
        if jobs.is_empty() {
            return Ok(Self::default());
        }
        let mut carriers: Vec<NodeId> =
            jobs.iter().flat_map(|t| t.masters.iter().map(|c| c.0)).collect();
        carriers.sort_unstable();
        carriers.dedup();
        let number = |id: NodeId| carriers.partition_point(|&c| c < id) as u32;
        let mut all = Self {
            turn: nodes.rotations && jobs.iter().any(|t| t.rotations || t.offset),
            arms: nodes.rotations && jobs.iter().any(|t| t.offset),
            shares: jobs
                .iter()
                .map(|t| t.masters.iter().map(|&(id, share)| (number(id), share)).collect())
                .collect(),
            slave_loads: vec![[V3::zeros(); 2]; jobs.len()],
            master_velocities: vec![[[0.0; 3]; 2]; carriers.len()],
            master_positions: vec![[0.0; 3]; carriers.len()],
            contact_forces: vec![V3::zeros(); carriers.len()],
            definitions: jobs,
            masters: carriers,
            ..Self::default()
        };
        let tied: Vec<NodeId> = all.definitions.iter().map(|t| t.node).collect();
        let states = of_owners(comm, nodes, &tied)?;
        all.slave_masses = states.iter().map(|s| [s.mass, s.inertia]).collect();
        let mut carrying = of_owners(comm, nodes, &all.masters)?;
        let foot_of = |shares: &[(u32, f64)]| V3::from(xyz(&blend(shares, |c| carrying[c].x)));
        let arm_of =
            |job: &Tie, shares: &[(u32, f64)], tied: &PackedNode| match all.arms && job.offset {
                true => V3::from(tied.x) - foot_of(shares),
                false => V3::zeros(),
            };
        let arms: Vec<V3> = all
            .definitions
            .iter()
            .zip(&all.shares)
            .zip(&states)
            .map(|((j, s), t)| arm_of(j, s, t))
            .collect();
        let heavier = |(job, (own, arm)): (&Tie, (&[f64; 2], &V3))| {
            let turns = if all.turn && job.rotations { own[1] } else { 0.0 };
            turns + ARM_INERTIA * own[0] * arm.norm_squared()
        };
        all.added_inertia =
            all.definitions.iter().zip(all.slave_masses.iter().zip(&arms)).map(heavier).collect();
        all.share_momentum(&states, &arms, &mut carrying);
        for t in 0..all.definitions.len() {
            all.add_masses(t, 1.0, nodes);
            if let Some(n) = nodes.index_of(all.definitions[t].node).map(|n| n as usize) {
                nodes.mass[n] = 0.0;
                if all.turn && all.definitions[t].rotations {
                    nodes.inertia[n] = 0.0;
                }
                nodes.invert_mass(n);
            }
        }
        for (&id, state) in all.masters.iter().zip(&carrying) {
            if let Some(n) = nodes.index_of(id).map(|n| n as usize) {
                nodes.v[n][..3].copy_from_slice(&state.v);
                nodes.v_next[n] = nodes.v[n];
                if nodes.rotations {
                    nodes.w[n][..3].copy_from_slice(&state.w);
                }
            }
        }
        for ((job, shares), arm) in all.definitions.iter().zip(&all.shares).zip(&arms) {
            let Some(n) = nodes.index_of(job.node).map(|n| n as usize) else { continue };
            let spin = blend(shares, |c| carrying[c].w);
            nodes.v[n] = blend(shares, |c| carrying[c].v);
            let turned = V3::from(xyz(&spin)).cross(arm);
            (0..3).for_each(|k| nodes.v[n][k] += turned[k]);
            nodes.v_next[n] = nodes.v[n];
            if all.turn && job.rotations {
                nodes.w[n] = spin;
            }
        }
        Ok(all)
    }

    /// Gives carriers, whose masses are still their own, the momentum that tied nodes have beyond
    /// what they have as they follow.
    fn share_momentum(&self, tied: &[PackedNode], arms: &[V3], carrying: &mut [PackedNode]) {
        let mut totals: Vec<[f64; 2]> = carrying.iter().map(|c| [c.mass, c.inertia]).collect();
        let mut pushes = vec![[V3::zeros(); 2]; carrying.len()];
        for (t, shares) in self.shares.iter().enumerate() {
            let [mass, inertia] = self.slave_masses[t];
            let spin = V3::from(xyz(&blend(shares, |c| carrying[c].w)));
            let led = V3::from(xyz(&blend(shares, |c| carrying[c].v))) + spin.cross(&arms[t]);
            let push = (V3::from(tied[t].v) - led) * mass;
            let mut turn = arms[t].cross(&push);
            if self.turn && self.definitions[t].rotations {
                turn += (V3::from(tied[t].w) - spin) * inertia;
            }
            for &(c, share) in shares {
                let c = c as usize;
                totals[c][0] += share * mass;
                totals[c][1] += share * self.added_inertia[t];
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

    /// Adds mass and inertia of a tied node to its local carriers, or with a factor of -1 takes it
    /// from them.
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

    /// Lets nodes go whose faces are of elements that have just failed here or elsewhere.
    /// Membership has to be settled anew afterwards. All workers call this together.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn release_failed(
        &mut self,
        comm: &mut dyn Transport,
        failed: &[ElemId],
        nodes: &mut Nodes,
    ) -> Result<(), RankLost> {
        if self.is_empty() {
            return Ok(());
        }
        let failed: HashSet<ElemId> = failed.iter().copied().collect();
        let holds =
            |t: &usize| !self.definitions[*t].faces.iter().any(|elem| failed.contains(elem));
        let here: Vec<u64> =
            (0..self.definitions.len()).filter(|t| !holds(t)).map(|t| t as u64).collect();
        let parcels = vec![here; comm.size() - 1];
        let told = exchange_all(comm, parcels)?;
        let released: BTreeSet<usize> = told.into_iter().flatten().map(|t| t as usize).collect();
        for &t in &released {
            self.add_masses(t, -1.0, nodes);
            if let Some(n) = nodes.index_of(self.definitions[t].node).map(|n| n as usize) {
                if self.arms && self.definitions[t].offset {
                    // Carriers have had its mass at the foot of the arm: with their velocity it
                    // takes the momentum that it gave.
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
        keep(&mut self.definitions, &released);
        keep(&mut self.shares, &released);
        keep(&mut self.slave_masses, &released);
        keep(&mut self.added_inertia, &released);
        self.slave_loads.truncate(self.definitions.len());
        if self.definitions.is_empty() {
            *self = Self::default();
        }
        Ok(())
    }

    /// Finds what is here, and what goes where. All workers call this together.
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
        self.link_workers(nodes);
        self.link(comm, nodes)
    }

    /// Lists who is tied to whom, by local numbers.
    fn link_workers(&mut self, nodes: &Nodes) {
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

    /// Tells other workers what is needed here, and learns what they will send.
    fn link(&mut self, comm: &mut dyn Transport, nodes: &Nodes) -> Result<(), RankLost> {
        let (workers, me) = (comm.size() - 1, comm.rank() - 1);
        let is_held = |n: u32| (n as usize) < nodes.local_count;
        let tied: Vec<u64> = self
            .force_sources
            .iter()
            .filter(|&&t| !is_held(self.slave_index[t as usize]))
            .map(|&t| u64::from(t))
            .collect();
        let followed = self.local_slaves.iter().flat_map(|&t| &self.shares[t as usize]);
        let mut carriers: Vec<u64> = followed
            .filter(|s| !is_held(self.master_index[s.0 as usize]))
            .map(|s| u64::from(s.0))
            .collect();
        carriers.sort_unstable();
        carriers.dedup();
        let wanted = [&[tied.len() as u64], &tied[..], &carriers[..]].concat();
        let wanted = exchange_all(comm, vec![wanted; workers])?;
        let own = |list: &[u32], numbers: &[u64]| -> Vec<u32> {
            let mine = |t: &&u64| nodes.is_owned(list[**t as usize] as usize);
            numbers.iter().filter(mine).map(|&t| t as u32).collect()
        };
        self.links.clear();
        let mut offered = vec![Vec::new(); workers];
        for (w, words) in wanted.iter().enumerate().filter(|(w, _)| *w != me) {
            let (tied, carriers) = halves(words);
            let link = Link {
                worker: w,
                slaves_out: own(&self.slave_index, tied),
                masters_out: own(&self.master_index, carriers),
                ..Link::default()
            };
            let words =
                [link.slaves_out.len() as u32].into_iter().chain(link.slaves_out.iter().copied());
            offered[w] = words.chain(link.masters_out.iter().copied()).map(u64::from).collect();
            self.links.push(link);
        }
        let offered = exchange_all(comm, offered)?;
        for link in &mut self.links {
            let (tied, carriers) = halves(&offered[link.worker]);
            link.slaves_in = tied.iter().map(|&t| t as u32).collect();
            link.masters_in = carriers.iter().map(|&c| c as u32).collect();
        }
        Ok(())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.definitions.is_empty()
    }

    /// Whether a node is tied and the segment has one of its partners, or the other way round.
    pub fn are_tied(&self, node: u32, segment: &[u32; 4]) -> bool {
        let run = match self.partner_start.get(node as usize..node as usize + 2) {
            Some(&[from, to]) => &self.partners[from as usize..to as usize],
            _ => &[],
        };
        !run.is_empty() && segment.iter().any(|corner| run.binary_search(corner).is_ok())
    }

    /// Gives the forces and moments on tied nodes to their carriers, when all but those of contact
    /// are there.
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
        if self.arms {
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
            for &(c, share) in &self.shares[t as usize] {
                let n = self.master_index[c as usize] as usize;
                if n >= nodes.local_count {
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

    /// Gives the contact forces on tied nodes to their carriers, whose velocities feel them.
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
            for &(c, share) in self.shares[t as usize].iter().filter(|_| force != V3::zeros()) {
                let n = self.master_index[c as usize];
                if self.turns(t as usize) && (n as usize) < nodes.local_count {
                    let (next, inverse) =
                        (&mut nodes.w_next[n as usize], &nodes.inv_inertia[n as usize]);
                    (0..3)
                        .for_each(|k| next[k] += steps.dt_damped * share * moment[k] * inverse[k]);
                }
                if n != NONE {
                    let (next, inverse) =
                        (&mut nodes.v_next[n as usize], &nodes.inv_mass[n as usize]);
                    (0..3).for_each(|k| next[k] += steps.dt_damped * share * force[k] * inverse[k]);
                    self.contact_forces[c as usize] += force * share;
                }
            }
        }
        Ok(())
    }

    /// Adds what carriers have felt of contact on tied nodes to velocities of local nodes without
    /// it.
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

    /// Contact force in this step on what is tied to local node `n` [force].
    pub fn contact_force_on_master(&self, n: u32, nodes: &Nodes) -> V3 {
        self.masters
            .binary_search(&nodes.id[n as usize])
            .map_or(V3::zeros(), |c| self.contact_forces[c])
    }

    /// Whether a tie gives moments to its carriers.
    fn turns(&self, t: usize) -> bool {
        self.turn && (self.definitions[t].rotations || self.definitions[t].offset)
    }

    /// From the place of its carriers to a local tied node; nought if it has no offset [length].
    fn arm(&self, t: usize, nodes: &Nodes) -> V3 {
        if !(self.arms && self.definitions[t].offset) {
            return V3::zeros();
        }
        let held =
            |c: usize| Some(self.master_index[c] as usize).filter(|&k| k < nodes.local_count);
        let foot = blend(&self.shares[t], |c| {
            held(c).map_or(self.master_positions[c], |k| xyz(&nodes.x[k]))
        });
        V3::from(xyz(&nodes.x[self.slave_index[t] as usize])) - V3::from(xyz(&foot))
    }

    /// Brings the velocities of local tied nodes to those of their carriers.
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
        for link in self.links.iter().filter(|l| !l.masters_out.is_empty()) {
            self.words.clear();
            for &c in &link.masters_out {
                let n = self.master_index[c as usize] as usize;
                self.words.extend(nodes.v_next[n][..3].iter().map(|v| v.to_bits()));
                if self.turn {
                    self.words.extend(nodes.w_next[n][..3].iter().map(|w| w.to_bits()));
                }
            }
            comm.send(link.worker + 1, Tag::Ties, &self.words)?;
        }
        let width = if self.turn { 6 } else { 3 };
        for link in self.links.iter().filter(|l| !l.masters_in.is_empty()) {
            comm.recv(link.worker + 1, Tag::Ties, &mut self.words)?;
            for (&c, words) in link.masters_in.iter().zip(self.words.chunks_exact(width)) {
                self.master_velocities[c as usize] = pair(words);
            }
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
            if !(self.turn && (rotations || arm != V3::zeros())) {
                continue;
            }
            let spin = blend(shares, |c| {
                held(c).map_or(self.master_velocities[c][1], |k| xyz(&nodes.w_next[k]))
            });
            if rotations && n < nodes.local_count {
                nodes.w_next[n] = spin;
            }
            if arm != V3::zeros() {
                // As far as the end of the arm goes when it keeps its length.
                let moved = (Rotation3::new(V3::from(xyz(&spin)) * dt) * arm - arm) / dt;
                (0..3).for_each(|k| nodes.v_next[n][k] += moved[k]);
            }
        }
        Ok(())
    }

    /// Learns where carriers are that others own.
    fn exchange_positions(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &Nodes,
    ) -> Result<(), RankLost> {
        for link in self.links.iter().filter(|l| !l.masters_out.is_empty()) {
            self.words.clear();
            let places =
                link.masters_out.iter().map(|&c| &nodes.x[self.master_index[c as usize] as usize]);
            self.words.extend(places.flat_map(xyz).map(f64::to_bits));
            comm.send(link.worker + 1, Tag::Ties, &self.words)?;
        }
        for link in self.links.iter().filter(|l| !l.masters_in.is_empty()) {
            comm.recv(link.worker + 1, Tag::Ties, &mut self.words)?;
            for (&c, words) in link.masters_in.iter().zip(self.words.chunks_exact(3)) {
                self.master_positions[c as usize] = pair(words)[0];
            }
        }
        Ok(())
    }

    /// Sends what acts on own tied nodes to those who have their carriers.
    fn exchange_slave_forces(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let width = if self.turn { 6 } else { 3 };
        for link in self.links.iter().filter(|l| !l.slaves_out.is_empty()) {
            self.words.clear();
            for &t in &link.slaves_out {
                let all =
                    self.slave_loads[t as usize].iter().flat_map(|v| v.iter()).map(|v| v.to_bits());
                self.words.extend(all.take(width));
            }
            comm.send(link.worker + 1, Tag::Ties, &self.words)?;
        }
        for link in self.links.iter().filter(|l| !l.slaves_in.is_empty()) {
            comm.recv(link.worker + 1, Tag::Ties, &mut self.words)?;
            for (&t, words) in link.slaves_in.iter().zip(self.words.chunks_exact(width)) {
                self.slave_loads[t as usize] = pair(words).map(V3::from);
            }
        }
        Ok(())
    }
}

/// Takes entries out by their numbers.
fn keep<T>(list: &mut Vec<T>, out: &BTreeSet<usize>) {
    let mut number = 0..;
    list.retain(|_| number.next().is_none_or(|n| !out.contains(&n)));
}

/// Two vectors from three or six words; the second is nought without its own.
fn pair(words: &[u64]) -> [[f64; 3]; 2] {
    let at = |k: usize| words.get(k).map_or(0.0, |&w| f64::from_bits(w));
    [[at(0), at(1), at(2)], [at(3), at(4), at(5)]]
}

/// A list that is led by its length, and what follows it.
fn halves(words: &[u64]) -> (&[u64], &[u64]) {
    words.split_first().map_or((&[], &[]), |(&count, rest)| rest.split_at(count as usize))
}

/// What a node has of its carriers' velocities, in ascending order.
fn blend(shares: &[(u32, f64)], of: impl Fn(usize) -> [f64; 3]) -> Row {
    let mut sum = [0.0; 4];
    for &(c, share) in shares {
        let v = of(c as usize);
        (0..3).for_each(|k| sum[k] += share * v[k]);
    }
    sum
}

/// The states of nodes, in the order of `ids`, from the workers that own them.
fn of_owners(
    comm: &mut dyn Transport,
    nodes: &Nodes,
    ids: &[NodeId],
) -> Result<Vec<PackedNode>, RankLost> {
    let mut mine: Vec<PackedNode> = Vec::new();
    for (number, &id) in ids.iter().enumerate() {
        if let Some(i) = nodes.local_index(id).map(|n| n as usize).filter(|&i| nodes.is_owned(i)) {
            let record = nodes.record(i);
            mine.push(PackedNode {
                number: number as u64,
                fixed: record.fixed,
                mass: record.mass,
                inertia: record.inertia,
                x: record.x,
                v: record.v,
                w: record.w,
            });
        }
    }
    let parcels = vec![bytemuck::cast_slice(&mine).to_vec(); comm.size() - 1];
    let mut all = vec![PackedNode::zeroed(); ids.len()];
    for parcel in exchange_all(comm, parcels)? {
        for one in bytemuck::cast_slice::<u64, PackedNode>(&parcel) {
            all[one.number as usize] = *one;
        }
    }
    Ok(all)
}
