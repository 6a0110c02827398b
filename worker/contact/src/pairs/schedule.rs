//! Schedule of Gauss-Seidel sweeps: pairs are updated one by one, and each update includes the
//! new forces of all earlier pairs with common nodes.
//!
//! The order is the same for any number of workers. Blocks of consecutive slave ids follow each
//! other in the order of a hash of the block; in a block the pairs follow in ascending order of
//! their keys. Chains of blocks that wait for each other are short in a random order: the longest
//! one grows like the logarithm of their number if each touches few others (Jones & Plassmann
//! 1993). In the order of the keys a chain follows the numbering of the mesh through all workers.
//!
//! Two pairs without a common node are independent, so only pairs with a common node must wait for
//! each other. A pair is in a later *phase* than the pairs of other workers that it touches and
//! that come before it in the order, and not in an earlier phase than such own pairs. In each
//! phase every worker updates its own pairs in order; then the forces are exchanged. Pairs whose
//! update would give the same result as their last one are skipped. The result is bitwise equal to
//! that of a single worker; phases only determine when a pair is computed.

use super::Peers;
use super::{MAX_PAIR_NODES, NodalLoad, Pair, PairTable};
use crate::surface::NOT_LOCAL;
use crumple_math::row::V3;
use crumple_proto::transport::RankLost;
use std::ops::Range;

/// Number of consecutive slave ids in a block. With larger blocks fewer pairs wait for other
/// workers but chains are longer: messages per cycle of `cases/brick-wall` in 200 cycles on 3 and
/// 6 workers are 1630 and 5301 in the order of the keys, 1408 and 2987 with blocks of 1, 1340 and
/// 3334 with 8, 1183 and 3126 with 64.
const BLOCK: u64 = 64;

/// Schedule of the updates of pairs.
#[derive(Debug, Default)]
pub struct SweepSchedule {
    /// Phase of each pair.
    phase: Vec<u32>,
    /// Nodes whose motion changes the force of each pair, as indices of `felt`.
    watched: Vec<[u32; MAX_PAIR_NODES]>,
    /// Hash of each block and its pairs, in the order of the sweeps.
    blocks: Vec<(u64, Range<u32>)>,
    /// All pairs in the order of the sweeps.
    sequence: Vec<u32>,
    /// Place of each pair in `sequence`.
    rank: Vec<u32>,
    /// Own pairs in ascending order of (phase, rank).
    own: Vec<u32>,
    /// Number of phases of the pairs that this worker knows.
    phases: u32,
    /// Counter of changed forces, starting at 1.
    turn: u64,
    /// Value of `turn` when a new force last acted on the node at each index of `touched`. Two
    /// more entries stand for roles without effect (0) and for nodes that are not local (the
    /// largest number).
    felt: Vec<u64>,
    /// Value of `turn` when each pair was last updated, 0 for never.
    looked: Vec<u64>,
    /// Forces of other workers' pairs of a phase.
    received: Vec<(u32, V3)>,
}

impl SweepSchedule {
    /// Marks all pairs for an update in the next sweep.
    pub(super) fn mark_all(&mut self) {
        self.looked.fill(0);
    }

    /// Returns true if a pair may have to change its force: a new force has acted on one of its
    /// nodes since its last update. So work continues only where pairs are connected to pairs
    /// that still change.
    fn is_scheduled(&self, i: u32) -> bool {
        let looked = self.looked[i as usize];
        self.watched[i as usize].iter().any(|&t| self.felt[t as usize] > looked)
    }
}

/// Returns a number whose bits all depend on all bits of `x` (the finaliser of SplitMix64; Steele,
/// Lea & Flood 2014).
fn mixed(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

impl PairTable {
    /// Computes the phases of all pairs that this worker knows.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn build_schedule(&mut self, peers: &mut impl Peers) -> Result<(), RankLost> {
        let mut order = std::mem::take(&mut self.schedule);
        self.order_blocks(&mut order);
        order.rank.clear();
        order.rank.resize(self.pairs.len(), 0);
        for (rank, &i) in (0..).zip(&order.sequence) {
            order.rank[i as usize] = rank;
        }
        order.phase.clear();
        order.phase.resize(self.pairs.len(), 0);
        // Phases only increase, from their lower bound. They are final if no worker increases
        // one. All own pairs that meet no pair of another worker are in the first phase.
        while peers.has_shared_pairs() {
            let changed = self.raise_levels(&mut order);
            if peers.exchange_phases(&mut order.phase, changed)? {
                break;
            }
        }
        order.own.clear();
        order.own.extend(order.sequence.iter().filter(|&&i| self.pairs[i as usize].is_owned));
        order.own.sort_by_key(|&i| order.phase[i as usize]);
        order.phases = order.phase.iter().map(|p| p + 1).max().unwrap_or(0);
        order.turn = 1;
        order.felt.clear();
        order.felt.resize(self.touched.len(), order.turn);
        order.felt.extend([0, u64::MAX]);
        let [without_effect, elsewhere] = [0, 1].map(|more| (self.touched.len() + more) as u32);
        order.watched.clear();
        order.watched.extend(self.pairs.iter().zip(&self.slots).map(|(pair, slots)| {
            std::array::from_fn(|r| match slots[r] {
                _ if pair.shape[r] == 0.0 => without_effect,
                NOT_LOCAL => elsewhere,
                t => t,
            })
        }));
        order.looked.clear();
        order.looked.resize(self.pairs.len(), 0);
        self.schedule = order;
        Ok(())
    }

    /// Returns the indices of all pairs in the order of the sweeps.
    pub fn sweep_order(&self) -> Vec<u32> {
        let mut order = SweepSchedule::default();
        self.order_blocks(&mut order);
        order.sequence
    }

    /// Lists all pairs in the order of the sweeps. The pairs of a block follow each other, because
    /// pairs are in ascending order of their keys.
    fn order_blocks(&self, order: &mut SweepSchedule) {
        let block = |p: &Pair| p.key.slave.0 / BLOCK;
        order.blocks.clear();
        let mut from = 0;
        for run in self.pairs.chunk_by(|a, b| block(a) == block(b)) {
            let to = from + run.len() as u32;
            order.blocks.push((mixed(block(&run[0])), from..to));
            from = to;
        }
        order.blocks.sort_unstable_by_key(|b| b.0); // no two blocks have the same hash
        order.sequence.clear();
        order.sequence.extend(order.blocks.iter().flat_map(|b| b.1.clone()));
    }

    /// Updates the phases of own pairs from those of all earlier pairs. Returns true if one has
    /// changed.
    fn raise_levels(&self, order: &mut SweepSchedule) -> bool {
        let mut earliest = vec![0u32; self.touched.len()];
        let mut changed = false;
        let sequence = std::mem::take(&mut order.sequence);
        for &i in &sequence {
            let i = i as usize;
            let pair = &self.pairs[i];
            let slots = || self.slots[i].iter().filter(|&&t| t != NOT_LOCAL).map(|&t| t as usize);
            let next = if pair.is_owned {
                let phase = slots().map(|t| earliest[t]).max().unwrap_or(0);
                changed |= phase != order.phase[i];
                order.phase[i] = phase;
                phase
            } else {
                order.phase[i] + 1
            };
            slots().for_each(|t| earliest[t] = earliest[t].max(next));
        }
        order.sequence = sequence;
        changed
    }

    /// Sweeps in order over the pairs that may have to change. `update` returns the new force of
    /// a pair, if there is one, and its residual relative to the tolerance. `feel` applies
    /// forces to a node: it takes an index in `touched`, the node there, and its total force and
    /// moment. `peers` returns the other workers. Returns the largest residual of the own pairs,
    /// relative to the tolerance.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn sweep_in_order<S, P: Peers>(
        &mut self,
        state: &mut S,
        peers: impl for<'s> Fn(&'s mut S) -> &'s mut P,
        update: impl Fn(&Pair, &S) -> Option<(V3, f64)>,
        feel: impl Fn(&mut S, u32, u32, NodalLoad<'_>),
    ) -> Result<f64, RankLost> {
        let mut order = std::mem::take(&mut self.schedule);
        let mut next = 0;
        let mut undone: f64 = 0.0;
        for phase in 0..order.phases {
            while let Some(&i) = order.own.get(next).filter(|&&i| order.phase[i as usize] == phase)
            {
                next += 1;
                if !order.is_scheduled(i) {
                    continue;
                }
                order.looked[i as usize] = order.turn;
                if let Some((force, left)) = update(&self.pairs[i as usize], state) {
                    undone = undone.max(left);
                    if force != self.pairs[i as usize].force {
                        self.apply_force(i, force, &mut order, state, &feel);
                    }
                }
            }
            if !peers(state).has_shared_pairs() {
                continue;
            }
            let mut received = std::mem::take(&mut order.received);
            received.clear();
            peers(state).exchange_phase_forces(&self.pairs, &order.phase, phase, &mut received)?;
            received.sort_unstable_by_key(|&(i, _)| order.rank[i as usize]);
            for &(i, force) in &received {
                if force != self.pairs[i as usize].force {
                    self.apply_force(i, force, &mut order, state, &feel);
                }
            }
            order.received = received;
        }
        self.schedule = order;
        Ok(undone)
    }

    /// Sets a new force of a pair and applies it to the nodes of the pair. The totals of the nodes
    /// change by the difference of the forces. All workers that know two pairs with a common node
    /// update them in the same order, so the round-off is the same.
    fn apply_force<S>(
        &mut self,
        i: u32,
        force: V3,
        order: &mut SweepSchedule,
        state: &mut S,
        feel: &impl Fn(&mut S, u32, u32, NodalLoad<'_>),
    ) {
        let pair = &mut self.pairs[i as usize];
        let change = force - pair.force;
        pair.force = force;
        let twist = if self.couples.is_empty() { V3::zeros() } else { pair.twist(&change) };
        order.turn += 1;
        for (r, &t) in self.slots[i as usize].iter().enumerate().filter(|&(_, &t)| t != NOT_LOCAL) {
            order.felt[t as usize] = order.turn;
            let share = pair.share(r);
            self.total[t as usize] +=
                change * if pair.is_slave_role(r as u8) { share } else { -share };
            if let Some(couple) = self.couples.get_mut(t as usize) {
                *couple += twist * (pair.lever_arm_of(r) * share);
            }
            feel(
                state,
                t,
                self.touched[t as usize],
                (&self.total[t as usize], self.couples.get(t as usize)),
            );
        }
    }
}
