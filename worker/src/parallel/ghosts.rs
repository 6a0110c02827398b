//! Data that a worker exchanges with others in every step, over any transport.

use crate::fem::blocks::Blocks;
use crate::math::rigid_motion::RigidMotion;
use crate::math::row::{row, xyz};
use crate::nodes::Nodes;
use crate::parallel::contact_decomposition::SearchRegions;
use crate::parallel::volumes::VolumeLink;
use crate::stateless;
use crate::time::ElementSet;
use bytemuck::{Pod, Zeroable};
use crumple_proto::boxes::Aabb;
use crumple_proto::report::Displacement;
use crumple_proto::transport::{Mailbox, RankLost, Tag, Transport, words_of};

/// State of a ghost node in a message.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct GhostState {
    x: [f64; 3],
    v: [f64; 3],
    v_next: [f64; 3],
}

/// Rotational velocities of a ghost node in a message; they follow the [`GhostState`] if contact
/// with friction needs them.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct GhostSpin {
    w: [f64; 3],
    w_next: [f64; 3],
}

/// Force and moment on a corner of an element in a message.
type ForceAndMoment = [[f64; 3]; 2];

/// Number of words of a rigid motion, which precedes the states of ghost nodes in a message.
pub const RIGID_MOTION_WORDS: usize = words_of::<RigidMotion>();

/// Returns the number of words of a ghost node's state: position, and velocities at the last
/// and at the next mid-step; with `spins` also rotational velocities at both.
pub fn ghost_words(spins: bool) -> u64 {
    let spin = if spins { words_of::<GhostSpin>() } else { 0 };
    (words_of::<GhostState>() + spin) as u64
}

/// Returns the number of words of an element nodal force, with its moment if nodes can rotate.
pub fn element_force_words(rotations: bool) -> u64 {
    let words = if rotations { words_of::<ForceAndMoment>() } else { words_of::<[f64; 3]>() };
    words as u64
}

/// Connection to one other worker.
#[derive(Debug, Default)]
pub struct GhostLink {
    /// The other worker (0-based).
    pub worker: usize,
    /// Own element nodal forces at shared nodes, as slots in the order of (element, corner).
    pub element_forces_out: Vec<u32>,
    /// First slot of the received element nodal forces, and their number.
    pub element_forces_in: (usize, usize),
    /// Entries of `element_forces_out` that do not belong to slow elements; empty without
    /// subcycles.
    pub fast_out: Vec<u32>,
    /// Slots of received element nodal forces that do not belong to slow elements; see
    /// `fast_out`.
    pub fast_in: Vec<u32>,
    /// Owned nodes that are ghosts on the other worker.
    pub export: Vec<u32>,
    /// Ghosts here that the other worker owns.
    pub import: Vec<u32>,
    /// Local nodes that the other worker has as local nodes too, ascending.
    pub shared: Vec<u32>,
    /// Half thickness and scale of the other worker's surface at the nodes of `shared` [length].
    pub widths: Vec<[f64; 2]>,
    /// Box in which the other worker needs the segments of this one as ghosts, if any can be
    /// there; at the positions of the last renewal.
    pub supplies: Option<Aabb>,
    /// True if this worker can need segments of the other one as ghosts.
    pub needs: bool,
    /// True if both workers have a common node, so that both may need the same contact pairs.
    pub shares_nodes: bool,
    /// Region in which own contact nodes could approach the other worker's elements.
    pub region: Option<Aabb>,
    /// Relative motion since the last renewal that the ghosts allow [length].
    pub margin: f64,
    /// True if the other worker is too far away to need its nodes as ghosts yet; the margin is
    /// then the remaining distance.
    pub is_distant: bool,
    /// True if this holds for both sides; the two then exchange their motion only from time to
    /// time.
    pub both_distant: bool,
    /// Relative motion at the last exchange [length].
    pub base: f64,
    /// Motion of the other worker at the last exchange, if there was one.
    pub motion: Option<RigidMotion>,
    /// Box around the other's local nodes at the last renewal, extended by the distance that
    /// the ghosts cover.
    pub reach: Option<Aabb>,
}

/// All connections of a worker.
#[derive(Debug, Default)]
pub struct Ghosts {
    /// One link per other worker, ascending.
    pub links: Vec<GhostLink>,
    /// Start of each node's entry in `users`.
    pub user_start: Vec<u32>,
    /// Other workers that have a node, as local or ghost node; ascending, node after node.
    pub users: Vec<u32>,
    mail: Mailbox,
    /// True if distant workers exchange their motion in this step.
    pub sync_distant: bool,
    /// Upper bound of the approach of any two nodes of contact surfaces since the last
    /// exchange, and in one step [length].
    pub max_approach: [f64; 2],
    /// Regions of the search, if contact has a second decomposition.
    pub regions: Option<SearchRegions>,
    /// Links of elements that average their volume strain at nodes.
    pub volumes: Vec<VolumeLink>,
}

stateless!(Ghosts { links, user_start, users, mail, sync_distant, max_approach, regions, volumes });

/// Fraction of the margin by which nodes may approach each other before distant workers
/// exchange their motion.
const SYNC_FRACTION: f64 = 0.1;

impl Ghosts {
    /// Returns the connections of a worker, without users of nodes.
    pub fn new(links: Vec<GhostLink>) -> Self {
        Self { links, ..Self::default() }
    }

    /// Returns for each of the workers whether the update of a surface concerns it and this one:
    /// workers with common nodes or with ghosts of each other.
    pub fn neighbours(&self, workers: usize) -> Vec<bool> {
        let mut neighbours = vec![false; workers];
        for l in &self.links {
            neighbours[l.worker] = !l.shared.is_empty() || l.supplies.is_some() || l.needs;
        }
        neighbours
    }

    /// Returns the other workers that have node `i`, as local or ghost node.
    pub fn users_of(&self, i: u32) -> &[u32] {
        &self.users[self.user_start[i as usize] as usize..self.user_start[i as usize + 1] as usize]
    }

    /// Returns the distance that each local node may move on its own, in addition to the
    /// margins of the links, without contact with entities that have no ghosts [length]. Two
    /// nodes of two workers are at least as far apart as either is from the other's box. Each
    /// may use three eighths of that distance; a quarter is reserved for the rotation of the
    /// motions (see `math/rigid_motion.rs`). Empty, for no distance, with a second decomposition of
    /// contact: a node may then come near to entities of its own worker that have no ghosts.
    pub fn slack(&self, nodes: &Nodes) -> Vec<f64> {
        if self.regions.is_some() {
            return Vec::new();
        }
        let reaches: Vec<Aabb> = self.links.iter().filter_map(|l| l.reach).collect();
        let from = |x: [f64; 3]| {
            let point = Aabb { min: x, max: x };
            reaches.iter().map(|r| r.distance(&point)).fold(f64::INFINITY, f64::min)
        };
        nodes.x[..nodes.local_count].iter().map(|x| 0.375 * from([x[0], x[1], x[2]])).collect()
    }

    /// Sends the element nodal forces, and moments if there are any, of own elements at shared
    /// nodes.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn send_element_forces(
        &mut self,
        comm: &mut dyn Transport,
        blocks: &Blocks,
        set: ElementSet,
    ) -> Result<(), RankLost> {
        let Blocks { force, moment, .. } = blocks;
        let Self { links, mail, .. } = self;
        for link in links {
            let (to, tag) = (link.worker, Tag::Corners);
            let slots = match set {
                ElementSet::All => &link.element_forces_out,
                ElementSet::Fast => &link.fast_out,
            };
            if moment.is_empty() {
                mail.send_items(comm, to, tag, slots, |slot| xyz(&force[slot as usize]))?;
            } else {
                let both = |slot: u32| [force, moment].map(|rows| xyz(&rows[slot as usize]));
                mail.send_items::<ForceAndMoment>(comm, to, tag, slots, both)?;
            }
        }
        Ok(())
    }

    /// Receives the element nodal forces of other workers' elements at shared nodes.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn recv_element_forces(
        &mut self,
        comm: &mut dyn Transport,
        blocks: &mut Blocks,
        set: ElementSet,
    ) -> Result<(), RankLost> {
        let Self { links, mail, .. } = self;
        for link in links {
            let (first, count) = link.element_forces_in;
            let expected = match set {
                ElementSet::All => count,
                ElementSet::Fast => link.fast_in.len(),
            };
            if expected == 0 {
                continue;
            }
            let slot = |k: usize| match set {
                ElementSet::All => first + k,
                ElementSet::Fast => link.fast_in[k] as usize,
            };
            mail.receive(comm, link.worker, Tag::Corners)?;
            if blocks.moment.is_empty() {
                for (k, force) in mail.take_many::<[f64; 3]>(expected).iter().enumerate() {
                    blocks.force[slot(k)] = row(*force);
                }
            } else {
                let all = mail.take_many::<ForceAndMoment>(expected);
                for (k, [force, moment]) in all.iter().enumerate() {
                    blocks.force[slot(k)] = row(*force);
                    blocks.moment[slot(k)] = row(*moment);
                }
            }
        }
        Ok(())
    }

    /// Sets ghosts to the state of their owners between two steps, for output: within a step
    /// their state is known at its start only.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn refresh_ghosts_for_output(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
    ) -> Result<(), RankLost> {
        let (Self { links, mail, .. }, tag) = (self, Tag::Exterior);
        for link in &*links {
            let (to, list) = (link.worker, &link.export);
            if nodes.rotations {
                let state = |i| [&nodes.x, &nodes.v, &nodes.w].map(|rows| xyz(&rows[i as usize]));
                mail.send_items(comm, to, tag, list, state)?;
            } else {
                let state = |i| [&nodes.x, &nodes.v].map(|rows| xyz(&rows[i as usize]));
                mail.send_items(comm, to, tag, list, state)?;
            }
        }
        for link in &*links {
            let (from, list) = (link.worker, &link.import);
            if nodes.rotations {
                mail.receive_items(comm, from, tag, list, |i, [x, v, w]: [[f64; 3]; 3]| {
                    let i = i as usize;
                    (nodes.x[i], nodes.v[i], nodes.w[i]) = (row(x), row(v), row(w));
                })?;
            } else {
                mail.receive_items(comm, from, tag, list, |i, [x, v]: [[f64; 3]; 2]| {
                    (nodes.x[i as usize], nodes.v[i as usize]) = (row(x), row(v));
                })?;
            }
        }
        Ok(())
    }

    /// Returns the fraction of the permitted approach since distant workers last exchanged
    /// their motion; 1 triggers an exchange.
    pub fn distant_fraction(&self) -> f64 {
        let margins =
            self.links.iter().filter(|l| l.both_distant && l.region.is_some()).map(|l| l.margin);
        self.max_approach[0] / (SYNC_FRACTION * margins.fold(f64::INFINITY, f64::min))
    }

    /// Records that any two nodes of contact surfaces have approached by at most `by` in the
    /// last step [length], and if distant workers exchange their motion in this step
    /// (`check_in`).
    pub fn track_approach(&mut self, by: f64, check_in: bool) {
        self.max_approach = [self.max_approach[0] + by, by];
        self.sync_distant = check_in;
    }

    /// Updates ghosts: coordinates, velocities at the last mid-step, and velocities without
    /// contact at the next one; with `spins`, which contact with friction needs, also
    /// rotational velocities. Workers also send each other their motion since the last renewal.
    /// Distant workers do so only at an exchange; until then the range of all velocities bounds
    /// their approach. Returns the relative motion that is largest as a fraction of the motion
    /// that the ghosts allow.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn exchange_ghosts(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        drift: &RigidMotion,
        spins: bool,
    ) -> Result<Displacement, RankLost> {
        let check_in = std::mem::take(&mut self.sync_distant);
        for link in self.links.iter().filter(|l| check_in || !l.both_distant) {
            self.mail.start();
            self.mail.push(*drift);
            for i in link.export.iter().map(|&i| i as usize) {
                let [x, v, v_next] = [&nodes.x, &nodes.v, &nodes.v_next].map(|rows| xyz(&rows[i]));
                self.mail.push(GhostState { x, v, v_next });
                if spins {
                    let [w, w_next] = [&nodes.w, &nodes.w_next].map(|rows| xyz(&rows[i]));
                    self.mail.push(GhostSpin { w, w_next });
                }
            }
            self.mail.send(comm, link.worker, Tag::Exterior)?;
        }
        if check_in {
            self.max_approach[0] = 0.0;
        }
        let mut largest = Displacement::default();
        for link in &mut self.links {
            if link.both_distant && !check_in {
                // Two more steps pass until the other workers receive the request for an
                // exchange.
                if link.region.is_some() {
                    let apart = link.base + self.max_approach[0] + 2.0 * self.max_approach[1];
                    largest = largest.or_larger(Displacement::new(apart, link.margin));
                }
                continue;
            }
            self.mail.receive(comm, link.worker, Tag::Exterior)?;
            let other: RigidMotion = self.mail.take();
            for i in link.import.iter().map(|&i| i as usize) {
                let state: GhostState = self.mail.take();
                nodes.x[i][..3].copy_from_slice(&state.x);
                nodes.v[i][..3].copy_from_slice(&state.v);
                nodes.v_next[i][..3].copy_from_slice(&state.v_next);
                if spins {
                    let spin: GhostSpin = self.mail.take();
                    nodes.w[i][..3].copy_from_slice(&spin.w);
                    nodes.w_next[i][..3].copy_from_slice(&spin.w_next);
                }
            }
            link.motion = Some(other);
            if let Some(region) = link.region.as_ref().filter(|_| self.regions.is_none()) {
                let apart = if link.is_distant {
                    drift.relative_motion(&other, region)
                } else {
                    drift.relative_motion_within(&other, region)
                };
                link.base = apart;
                largest = largest.or_larger(Displacement::new(apart, link.margin));
            }
        }
        Ok(largest.or_larger(self.displacement_of_regions(nodes.me as usize, drift, check_in)))
    }

    /// Returns the largest displacement of entities for which this worker searches, against the
    /// elements of each other worker. Zero without a second decomposition of contact: a worker then
    /// searches for own entities only.
    fn displacement_of_regions(
        &mut self,
        me: usize,
        drift: &RigidMotion,
        check_in: bool,
    ) -> Displacement {
        let mut largest = Displacement::default();
        let Some(regions) = &self.regions else { return largest };
        let links = &self.links;
        let motion = |w: usize| {
            let of_link = || links.binary_search_by_key(&w, |l| l.worker).ok().map(|i| &links[i]);
            let of_other = || of_link().and_then(|l| l.motion);
            if w == me { *drift } else { of_other().expect("owners of entities are not distant") }
        };
        let is_due = |l: &GhostLink| l.region.is_some() && (check_in || !l.both_distant);
        let apart =
            |l: &GhostLink| is_due(l).then(|| regions.relative_motion(&motion(l.worker), motion));
        let all: Vec<Option<f64>> = links.iter().map(apart).collect();
        for (link, apart) in self.links.iter_mut().zip(all) {
            let Some(apart) = apart else { continue };
            link.base = apart;
            largest = largest.or_larger(Displacement::new(apart, link.margin));
        }
        largest
    }
}
