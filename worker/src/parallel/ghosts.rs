//! What a worker exchanges with others in every step, over any transport.

use crate::fem::blocks::Blocks;
use crate::math::rigid_motion::RigidMotion;
use crate::nodes::Nodes;
use crumple_proto::boxes::Aabb;
use crumple_proto::transport::{RankLost, Tag, Transport};

/// Words of a drift, which leads the states of exterior nodes.
pub const RIGID_MOTION_WORDS: usize = RigidMotion::WORDS;
/// Words of the state of an exterior node: position, and velocities at the last and at the next
/// mid-step; with `spins` rotational velocities at both too.
pub fn ghost_words(spins: bool) -> u64 {
    if spins { 15 } else { 9 }
}

/// Words of a corner's force, and of its moment where nodes can turn.
pub fn element_force_words(rotations: bool) -> u64 {
    if rotations { 6 } else { 3 }
}

/// The connection to one other worker.
#[derive(Debug, Default)]
pub struct GhostLink {
    /// The other worker (0-based).
    pub worker: usize,
    /// Own corner slots at shared nodes, in the order of (element, corner).
    pub element_forces_out: Vec<u32>,
    /// First received corner slot and their number.
    pub element_forces_in: (usize, usize),
    /// Of both what does not belong to slow elements, as slots; without subcycles nobody asks.
    pub fast_out: Vec<u32>,
    /// See `fast_out`.
    pub fast_in: Vec<u32>,
    /// Owned nodes of which the other has exterior copies.
    pub export: Vec<u32>,
    /// Exterior copies here of nodes that the other owns.
    pub import: Vec<u32>,
    /// Whether some node is local on both sides, so that contact pairs may concern both.
    pub shares_nodes: bool,
    /// Where own contact nodes could come near the other's elements.
    pub region: Option<Aabb>,
    /// Relative motion since the last renewal that the exterior copies cover [length].
    pub margin: f64,
    /// Whether the other is so far off that no copies of its nodes are needed yet: the margin is
    /// then the distance left.
    pub is_distant: bool,
    /// Whether that is so on both sides: they tell each other of their motion now and then only.
    pub both_distant: bool,
    /// Relative motion when they last did [length].
    pub base: f64,
    /// Box around the other's held nodes at the last renewal, grown by all that the exterior copies
    /// cover.
    pub reach: Option<Aabb>,
}

/// All connections of a worker.
#[derive(Debug, Default)]
pub struct Ghosts {
    /// One link per other worker, ascending.
    pub links: Vec<GhostLink>,
    /// For each local node, where its entry in `users` starts.
    pub user_start: Vec<u32>,
    /// Other workers that have a node local, ascending, node after node.
    pub users: Vec<u32>,
    /// Message under construction.
    pub words: Vec<u64>,
    /// Whether workers that are apart tell each other of their motion in this step.
    pub sync_distant: bool,
    /// How much nearer any two nodes that can touch may have come since they last did, and in one
    /// step [length].
    pub max_approach: [f64; 2],
}

/// Workers that are apart tell each other of their motion when nodes may have come nearer by this
/// fraction of the margin.
const SYNC_FRACTION: f64 = 0.1;

impl Ghosts {
    /// Other workers that have local node `i`, held or exterior.
    pub fn users_of(&self, i: u32) -> &[u32] {
        &self.users[self.user_start[i as usize] as usize..self.user_start[i as usize + 1] as usize]
    }

    /// How far each held node may move on its own without coming upon what is not copied, beyond
    /// the links' margins [length]. Two nodes of two workers are at least as far apart as either is
    /// from the other's box; of that distance each may use three eighths, and a quarter is left for
    /// the turning of the motions (see `motion.rs`).
    pub fn slack(&self, nodes: &Nodes) -> Vec<f64> {
        let reaches: Vec<Aabb> = self.links.iter().filter_map(|l| l.reach).collect();
        let from = |x: [f64; 3]| {
            let point = Aabb { min: x, max: x };
            reaches.iter().map(|r| r.distance(&point)).fold(f64::INFINITY, f64::min)
        };
        nodes.x[..nodes.local_count].iter().map(|x| 0.375 * from([x[0], x[1], x[2]])).collect()
    }

    /// Sends corner forces, and moments if there are any, of own elements at shared nodes; with
    /// `all` those of slow ones too.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn send_element_forces(
        &mut self,
        comm: &mut dyn Transport,
        blocks: &Blocks,
        all: bool,
    ) -> Result<(), RankLost> {
        for link in &self.links {
            let slots = if all { &link.element_forces_out } else { &link.fast_out };
            if slots.is_empty() {
                continue;
            }
            self.words.clear();
            for &slot in slots {
                self.words.extend(blocks.force[slot as usize][..3].iter().map(|a| a.to_bits()));
                if let Some(m) = blocks.moment.get(slot as usize) {
                    self.words.extend(m[..3].iter().map(|a| a.to_bits()));
                }
            }
            comm.send(link.worker + 1, Tag::Corners, &self.words)?;
        }
        Ok(())
    }

    /// Receives corner forces of others' elements at shared nodes; with `all` those of slow ones
    /// too.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn recv_element_forces(
        &mut self,
        comm: &mut dyn Transport,
        blocks: &mut Blocks,
        all: bool,
    ) -> Result<(), RankLost> {
        let width = if blocks.moment.is_empty() { 3 } else { 6 };
        let mut take = |slot: usize, words: &[u64]| {
            let at = |c: usize| f64::from_bits(words[c]);
            blocks.force[slot] = [at(0), at(1), at(2), 0.0];
            if let Some(m) = blocks.moment.get_mut(slot) {
                *m = [at(3), at(4), at(5), 0.0];
            }
        };
        for link in &self.links {
            let (first, count) = link.element_forces_in;
            if if all { count == 0 } else { link.fast_in.is_empty() } {
                continue;
            }
            comm.recv(link.worker + 1, Tag::Corners, &mut self.words)?;
            let corners = self.words.chunks_exact(width);
            if all {
                corners.zip(first..first + count).for_each(|(words, slot)| take(slot, words));
            } else {
                corners.zip(&link.fast_in).for_each(|(words, &slot)| take(slot as usize, words));
            }
        }
        Ok(())
    }

    /// Brings exterior nodes to the state that their owners have between two steps, for output:
    /// within a step they are known at its start only.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn refresh_ghosts_for_output(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
    ) -> Result<(), RankLost> {
        for link in self.links.iter().filter(|l| !l.export.is_empty()) {
            self.words.clear();
            for i in link.export.iter().map(|&i| i as usize) {
                let turning = nodes.w.get(i).map_or(&[][..], |w| &w[..3]);
                self.words.extend(
                    nodes.x[i][..3]
                        .iter()
                        .chain(&nodes.v[i][..3])
                        .chain(turning)
                        .map(|a| a.to_bits()),
                );
            }
            comm.send(link.worker + 1, Tag::Exterior, &self.words)?;
        }
        for link in self.links.iter().filter(|l| !l.import.is_empty()) {
            comm.recv(link.worker + 1, Tag::Exterior, &mut self.words)?;
            let width = if nodes.rotations { 9 } else { 6 };
            for (i, words) in
                link.import.iter().map(|&i| i as usize).zip(self.words.chunks_exact(width))
            {
                let three =
                    |k: usize| crate::nodes::row([0, 1, 2].map(|c| f64::from_bits(words[k + c])));
                (nodes.x[i], nodes.v[i]) = (three(0), three(3));
                if nodes.rotations {
                    nodes.w[i] = three(6);
                }
            }
        }
        Ok(())
    }

    /// How near the next check-in of workers that are apart is, due at 1.
    pub fn distant_fraction(&self) -> f64 {
        let margins =
            self.links.iter().filter(|l| l.both_distant && l.region.is_some()).map(|l| l.margin);
        self.max_approach[0] / (SYNC_FRACTION * margins.fold(f64::INFINITY, f64::min))
    }

    /// Any two nodes that can touch have come nearer by `by` at most in the last step [length].
    pub fn track_approach(&mut self, by: f64, check_in: bool) {
        self.max_approach = [self.max_approach[0] + by, by];
        self.sync_distant = check_in;
    }

    /// Brings exterior nodes up to date: coordinates, velocities at the last mid-step, and those
    /// without contact at the next one; with `spins`, which contact with friction needs, rotational
    /// velocities too. Workers also tell each other how their nodes have moved since the last
    /// renewal, those that are apart only when they check in: until then the range of all
    /// velocities bounds how much nearer they have come. Returns the largest relative motion as a
    /// fraction of what the exterior copies cover.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn exchange_ghosts(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        drift: &RigidMotion,
        spins: bool,
    ) -> Result<f64, RankLost> {
        let check_in = std::mem::take(&mut self.sync_distant);
        for link in self.links.iter().filter(|l| check_in || !l.both_distant) {
            self.words.clear();
            self.words.extend(drift.to_words().map(f64::to_bits));
            for &i in &link.export {
                let i = i as usize;
                let rows = [&nodes.x, &nodes.v, &nodes.v_next].map(|rows| &rows[i][..3]);
                self.words.extend(rows.into_iter().flatten().map(|a| a.to_bits()));
                if spins {
                    let rows = [&nodes.w, &nodes.w_next].map(|rows| &rows[i][..3]);
                    self.words.extend(rows.into_iter().flatten().map(|a| a.to_bits()));
                }
            }
            comm.send(link.worker + 1, Tag::Exterior, &self.words)?;
        }
        if check_in {
            self.max_approach[0] = 0.0;
        }
        let mut urgency = 0.0f64;
        for link in &mut self.links {
            if link.both_distant && !check_in {
                // Two steps more: so long the others take to hear of it.
                if link.region.is_some() {
                    urgency = urgency.max(
                        (link.base + self.max_approach[0] + 2.0 * self.max_approach[1])
                            / link.margin,
                    );
                }
                continue;
            }
            comm.recv(link.worker + 1, Tag::Exterior, &mut self.words)?;
            let words: &[f64] = bytemuck::cast_slice(&self.words);
            let (head, body) = words.split_at(RigidMotion::WORDS);
            for (&i, state) in
                link.import.iter().zip(body.chunks_exact(ghost_words(spins) as usize))
            {
                let rows = [
                    &mut nodes.x,
                    &mut nodes.v,
                    &mut nodes.v_next,
                    &mut nodes.w,
                    &mut nodes.w_next,
                ];
                rows.into_iter().zip(state.chunks_exact(3)).for_each(|(rows, three)| {
                    rows[i as usize][..3].copy_from_slice(three);
                });
            }
            if let Some(region) = &link.region {
                let other = RigidMotion::from_words(head);
                let apart = if link.is_distant {
                    drift.relative_motion(&other, region)
                } else {
                    drift.relative_motion_within(&other, region)
                };
                link.base = apart;
                urgency = urgency.max(apart / link.margin);
            }
        }
        Ok(urgency)
    }
}
