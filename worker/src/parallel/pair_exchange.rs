//! Exchange of contact pairs between workers, and of their forces during the contact iteration.
//!
//! A worker sends each own pair to all other workers that have one of its nodes as local node or
//! ghost. Then every worker has all pairs that touch its local nodes, and sums the contact force on
//! each of these nodes alone. A pair that other workers know is *shared*. Few pairs are replicated
//! instead (`replicated_pairs.rs`).

use crate::contact::enforce::{Iteration, Laws};
use crate::contact::pairs::{MAX_PAIR_NODES, Pair, PairKey, PairTable, padded};
use crate::contact::surface::NOT_LOCAL;
use crate::math::row::V3;
use crate::nodes::Nodes;
use crate::parallel::convergence::ConvergenceDetector;
use crate::parallel::ghosts::Ghosts;
use crate::stateless;
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::{NodeId, SegmentId};
use crumple_proto::transport::{Mailbox, RankLost, Tag, Transport, words_of};

/// The pairs that both this worker and one other worker know.
#[derive(Debug, Default)]
struct SharedPairs {
    worker: usize,
    /// Own pairs that the other worker knows, ascending.
    sent: Vec<u32>,
    /// Pairs of the other worker, ascending.
    received: Vec<u32>,
}

/// Shared pairs of a step, and the detection of convergence of their forces.
#[derive(Debug, Default)]
pub struct PairExchange {
    shared: Vec<SharedPairs>,
    convergence: ConvergenceDetector,
    mail: Mailbox,
}

stateless!(PairExchange { shared, convergence, mail });

impl PairExchange {
    /// Sends own pairs to other workers and adds theirs to the table. Before the call, the table
    /// has the own pairs, ascending.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn exchange_pairs(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &Nodes,
        halo: &Ghosts,
        table: &mut PairTable,
    ) -> Result<(), RankLost> {
        self.shared.clear();
        for link in halo.links.iter().filter(|l| l.shares_nodes) {
            self.mail.start();
            let concerns = |p: &Pair| {
                p.local_nodes()
                    .any(|n| halo.users_of(n).binary_search(&(link.worker as u32)).is_ok())
            };
            let sent: Vec<u32> = (0..table.pairs.len())
                .filter(|&i| concerns(&table.pairs[i]))
                .map(|i| i as u32)
                .collect();
            for &i in &sent {
                write_pair(&mut self.mail, &table.pairs[i as usize], nodes);
            }
            self.mail.send(comm, link.worker, Tag::Pairs)?;
            self.shared.push(SharedPairs { worker: link.worker, sent, received: Vec::new() });
        }
        let own = table.pairs.len();
        for with in &mut self.shared {
            self.mail.receive(comm, with.worker, Tag::Pairs)?;
            let first = table.pairs.len() as u32;
            while !self.mail.is_read() {
                let index = |id: NodeId| nodes.index_of(id).unwrap_or(NOT_LOCAL);
                table.pairs.push(read_pair(&mut self.mail, index, table.by_area));
            }
            with.received.extend(first..table.pairs.len() as u32);
        }
        if table.pairs.len() > own {
            // The pairs of a sender arrive in its ascending order, which is also the order here.
            let place = table.sort_by_key();
            for with in &mut self.shared {
                let lists = with.sent.iter_mut().chain(&mut with.received);
                lists.for_each(|i| *i = place[*i as usize]);
            }
        }
        self.shared.retain(|with| !with.sent.is_empty() || !with.received.is_empty());
        self.convergence.start(comm.rank() - 1, self.shared.iter().map(|with| with.worker));
        table.index_by_node();
        Ok(())
    }

    /// Forgets the shared pairs of the last step: in this step no worker needs forces of others.
    pub fn clear(&mut self) {
        self.shared.clear();
    }

    /// Returns true if other workers know some of these pairs.
    pub fn has_shared_pairs(&self) -> bool {
        !self.shared.is_empty()
    }

    /// Exchanges the forces of shared pairs after a sweep. `changed` is true if the sweep has
    /// changed the force of an own pair. Returns true if all workers that are connected by
    /// shared pairs have converged.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn exchange_forces(
        &mut self,
        comm: &mut dyn Transport,
        pairs: &mut [Pair],
        changed: bool,
    ) -> Result<bool, RankLost> {
        self.convergence.record_change(changed);
        self.exchange(comm, pairs, true, |p| p.force, |p, force| p.force = force)?;
        self.convergence.end_round();
        Ok(self.convergence.has_converged())
    }

    /// Exchanges a vector of shared pairs, for example their forces within a sweep.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn exchange_vectors(
        &mut self,
        comm: &mut dyn Transport,
        pairs: &mut [Pair],
        of: fn(&mut Pair) -> &mut V3,
    ) -> Result<(), RankLost> {
        self.exchange(comm, pairs, false, |p| *of(p), |p, v| *of(p) = v)
    }

    /// Exchanges flags of shared pairs, by pair.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn exchange_flags(
        &mut self,
        comm: &mut dyn Transport,
        flags: &mut [bool],
    ) -> Result<(), RankLost> {
        self.exchange(comm, flags, false, |f| u64::from(*f), |f, flag| *f = flag != 0)
    }

    /// Exchanges the phases of shared pairs in the schedule of a sweep, see
    /// [`crate::contact::pairs::Peers::exchange_phases`].
    ///
    /// # Errors
    /// A worker is gone.
    pub fn exchange_phases(
        &mut self,
        comm: &mut dyn Transport,
        phases: &mut [u32],
        changed: bool,
    ) -> Result<bool, RankLost> {
        self.convergence.record_change(changed);
        self.exchange(comm, phases, true, |p| u64::from(*p), |p, phase| *p = phase as u32)?;
        self.convergence.end_round();
        let are_final = self.convergence.has_converged();
        if are_final {
            self.convergence.restart(); // changes of forces follow
        }
        Ok(are_final)
    }

    /// Exchanges a value of shared pairs, by pair: `get` reads it, `set` stores that of a pair of
    /// another worker. With `detects` the messages begin with the state of the detection of
    /// convergence.
    fn exchange<P, T: Pod>(
        &mut self,
        comm: &mut dyn Transport,
        of_pairs: &mut [P],
        detects: bool,
        get: impl Fn(&mut P) -> T,
        set: impl Fn(&mut P, T),
    ) -> Result<(), RankLost> {
        let Self { shared, convergence, mail } = self;
        for with in &*shared {
            mail.start();
            if detects {
                convergence.write(mail);
            }
            with.sent.iter().for_each(|&i| mail.push(get(&mut of_pairs[i as usize])));
            mail.send(comm, with.worker, Tag::Sweep)?;
        }
        for with in &*shared {
            mail.receive(comm, with.worker, Tag::Sweep)?;
            if detects {
                convergence.read(mail);
            }
            let values = with.received.iter().zip(mail.rest::<T>());
            values.for_each(|(&i, value)| set(&mut of_pairs[i as usize], *value));
        }
        Ok(())
    }

    /// Sends the forces of the own shared pairs of a phase and receives those of other workers, as
    /// indices of pairs with their forces.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn exchange_phase_forces(
        &mut self,
        comm: &mut dyn Transport,
        pairs: &[Pair],
        phases: &[u32],
        phase: u32,
        received: &mut Vec<(u32, V3)>,
    ) -> Result<(), RankLost> {
        let is_due = |i: &&u32| phases[**i as usize] == phase;
        for with in &self.shared {
            self.mail.start();
            let due = with.sent.iter().filter(is_due);
            due.for_each(|&i| self.mail.push(pairs[i as usize].force));
            if !self.mail.is_empty() {
                self.mail.send(comm, with.worker, Tag::Sweep)?;
            }
        }
        for with in &self.shared {
            let mut due = with.received.iter().filter(is_due).peekable();
            if due.peek().is_some() {
                self.mail.receive(comm, with.worker, Tag::Sweep)?;
                received.extend(due.copied().zip(self.mail.rest::<V3>().iter().copied()));
            }
        }
        Ok(())
    }
}

/// Part of a pair that is sent to other workers.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct PackedPair {
    key: PairKey,
    segment: SegmentId,
    nodes: [NodeId; FIRST],
    weight: [f64; FIRST],
    normal: V3,
    tolerated_gap: f64,
    initial_gap: f64,
    penetration: f64,
    contact_thickness: f64,
    force: V3,
    slave_mass: f64,
    /// Bit 0: [`Pair::slave_is_fixed`]. Bit 1: a [`PackedLever`] follows. Further bits:
    /// [`Pair::interface`].
    flags: u64,
}
/// Number of roles of a pair in [`PackedPair`]. The other roles of two segments follow in
/// [`PackedRest`].
pub const FIRST: usize = 5;
/// Number of the other roles.
pub const REST: usize = MAX_PAIR_NODES - FIRST;

/// Additional data that is sent for a pair of two segments.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct PackedRest {
    nodes: [NodeId; REST],
    weight: [f64; REST],
    area: f64,
}

/// Additional data that is sent for a pair whose friction rotates nodes.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct PackedLever {
    arms: [f64; 2],
    sliding_mass: f64,
}

/// Returns the number of words of a pair in a message to another worker.
pub fn message_words(pair: &Pair) -> usize {
    let rest = if pair.key.is_segment() { words_of::<PackedRest>() } else { 0 };
    let lever = if pair.has_couple() { words_of::<PackedLever>() } else { 0 };
    words_of::<PackedPair>() + rest + lever
}

/// Appends the data of a pair that other workers need.
pub fn write_pair(mail: &mut Mailbox, pair: &Pair, nodes: &Nodes) {
    let id = |n: u32| if n == NOT_LOCAL { NodeId(u64::MAX) } else { nodes.id[n as usize] };
    mail.push(PackedPair {
        key: pair.key,
        segment: pair.segment,
        nodes: std::array::from_fn(|r| id(pair.nodes[r])),
        weight: std::array::from_fn(|r| pair.weight[r]),
        normal: pair.normal,
        tolerated_gap: pair.tolerated_gap,
        initial_gap: pair.initial_gap,
        penetration: pair.penetration,
        contact_thickness: pair.contact_thickness,
        force: pair.force,
        slave_mass: pair.slave_mass,
        flags: u64::from(pair.slave_is_fixed)
            | u64::from(pair.has_couple()) << 1
            | u64::from(pair.interface) << 2,
    });
    if pair.key.is_segment() {
        mail.push(PackedRest {
            nodes: std::array::from_fn(|r| id(pair.nodes[FIRST + r])),
            weight: std::array::from_fn(|r| pair.weight[FIRST + r]),
            area: pair.area,
        });
    }
    if pair.has_couple() {
        mail.push(PackedLever { arms: pair.lever_arms, sliding_mass: pair.slave_sliding_mass });
    }
}

/// Reads the next pair of a message. `index` returns the index of a node, or [`NOT_LOCAL`].
/// `by_area` is [`PairTable::by_area`].
pub fn read_pair(mail: &mut Mailbox, index: impl Fn(NodeId) -> u32, by_area: bool) -> Pair {
    let first: PackedPair = mail.take();
    let mut pair = Pair {
        weight: padded(first.weight),
        normal: first.normal,
        tolerated_gap: first.tolerated_gap,
        initial_gap: first.initial_gap,
        penetration: first.penetration,
        contact_thickness: first.contact_thickness,
        force: first.force,
        slave_mass: first.slave_mass,
        slave_sliding_mass: first.slave_mass,
        slave_is_fixed: first.flags & 1 != 0,
        interface: (first.flags >> 2) as u16,
        ..Pair::new(first.key, first.segment, first.nodes.map(&index))
    };
    if by_area && !pair.key.is_segment() {
        pair.area = pair.contact_thickness * pair.contact_thickness;
    }
    if pair.key.is_segment() {
        let rest: PackedRest = mail.take();
        pair.nodes[FIRST..].copy_from_slice(&rest.nodes.map(&index));
        pair.weight[FIRST..].copy_from_slice(&rest.weight);
        pair.area = rest.area;
    }
    if first.flags & 2 != 0 {
        let lever: PackedLever = mail.take();
        (pair.lever_arms, pair.slave_sliding_mass) = (lever.arms, lever.sliding_mass);
    }
    pair
}

/// Estimate of the messages between two workers with shared pairs in a step, without the
/// exchange of the pairs themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrafficEstimate {
    /// Number of sweeps of both workers.
    pub sweeps: f64,
    /// Number of messages in one direction.
    pub messages: f64,
    /// Number of header words, and number of words per pair that is sent to the other worker.
    pub words: [f64; 2],
    /// Number of sweeps with a message for each phase of pairs in order.
    pub phased_sweeps: f64,
    /// Number of accelerated sweeps, each with a sum and a maximum over all workers.
    pub accelerated_sweeps: f64,
}

impl TrafficEstimate {
    /// Estimates the traffic of a step that takes `alone` sweeps on one worker, if the workers
    /// detect convergence after `quiet` rounds without a change, and pairs in order have this
    /// number of `phases`. It counts the messages of the contact solver. Sweeps of one worker
    /// beyond the largest number of the laws are accelerated ones.
    ///
    /// Each sweep has one message for the forces. It has a second one for predictor forces, and
    /// one for each phase of pairs in order, which are counted apart. The phases are known after
    /// one round each, and the end of this computation after `quiet` more. The last sweep of one
    /// worker changes nothing; several workers make `quiet` such sweeps, up to the largest number
    /// of sweeps of the laws. If interfaces have different iterations, each iteration has its
    /// messages in every sweep, and the forces are exchanged once more.
    pub fn estimate(laws: &Laws, alone: f64, quiet: u64, phases: u64) -> Self {
        let rounds = quiet as f64 + phases.saturating_sub(1) as f64;
        let quiet = quiet as f64;
        let sweeps = (alone + quiet - 1.0).min(laws.sweeps() as f64).max(alone);
        let of_one = |iteration: &Iteration| match iteration {
            Iteration::Split => [sweeps, 2.0 * sweeps, 3.0 * sweeps],
            Iteration::Correct { .. } => [2.0 * sweeps, 2.0 * sweeps, 6.0 * sweeps],
            Iteration::GaussSeidel => {
                [rounds + sweeps, 2.0 * (rounds + sweeps), rounds + 6.0 * sweeps]
            }
        };
        let common = if laws.iterations().len() > 1 {
            [sweeps, 2.0 * sweeps, 3.0 * sweeps]
        } else {
            [0.0; 3]
        };
        // Flags of redundant pairs.
        let flags = if laws.converge() { [1.0, 0.0, 1.0] } else { [0.0; 3] };
        let add = |sum: [f64; 3], one: [f64; 3]| std::array::from_fn(|i| sum[i] + one[i]);
        let [messages, lead, each] =
            laws.iterations().iter().map(of_one).fold(add(common, flags), add);
        let phased = laws.iterations().contains(&Iteration::GaussSeidel);
        let phased_sweeps = if phased { sweeps } else { 0.0 };
        let accelerated_sweeps = (alone - laws.sweeps() as f64).max(0.0);
        Self { sweeps, messages, words: [lead, each], phased_sweeps, accelerated_sweeps }
    }
}
