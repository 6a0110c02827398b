//! Replication of pairs. If all workers together have few pairs, each worker gets all of them, and
//! computes the forces of those that act on its local nodes and ghosts, directly or through other
//! pairs. This takes one exchange per step and none during the plain sweeps. Pairs in order would
//! take several messages per sweep, which cost far more than a few hundred pairs
//! (`cases/bench/RESULTS.md`). Workers without nodes of pairs go on to the next step without
//! waiting.
//!
//! The nodes of pairs that a worker has neither as local nodes nor as ghosts come after its ghosts
//! until the forces are known.

use crate::contact::pairs::{MAX_PAIR_NODES, Pair, PairTable, padded};
use crate::contact::surface::NOT_LOCAL;
use crate::math::row::V3;
use crate::nodes::{ContactNode, Nodes};
use crate::parallel::pair_exchange::{self, FIRST, REST, read_pair, write_pair};
use crate::stateless;
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::NodeId;
use crumple_proto::transport::{Mailbox, RankLost, Transport, gather_all, words_of};
use std::collections::BTreeSet;

/// Additional data for the worker that computes the force of a pair of another worker.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct PackedLaw {
    shape: [f64; FIRST],
    gap: f64,
    speed: f64,
    friction_coefficient: f64,
    max_friction_force: f64,
    slip: V3,
    stiffness: f64,
    /// [`Pair::slave_surface_first`].
    slave_surface_first: u64,
}

/// Replicated pairs of a step.
#[derive(Debug, Default)]
pub struct ReplicatedPairs {
    /// `None` if pairs are not replicated, and after the sweeps.
    now: Option<Replication>,
    /// Number of replicas of the last step, 0 if pairs were not replicated.
    pub replicas: u64,
}

stateless!(ReplicatedPairs { now, replicas });

#[derive(Debug)]
struct Replication {
    /// Number of local nodes and ghosts.
    held: usize,
    /// Workers with own pairs or with nodes of pairs, ascending.
    members: Vec<usize>,
    /// Number of pairs of all workers.
    total: u64,
}

impl ReplicatedPairs {
    /// Returns the number of pairs of all workers, if pairs are replicated.
    pub fn total(&self) -> Option<u64> {
        self.now.as_ref().map(|now| now.total)
    }

    /// Returns the workers that have own pairs or nodes of pairs, ascending, if pairs are
    /// replicated.
    pub fn members(&self) -> Option<&[usize]> {
        self.now.as_ref().map(|now| &now.members[..])
    }

    /// Returns true if the worker takes part in sums and maxima of the sweeps.
    pub fn takes_part(&self, worker: usize) -> bool {
        self.members().is_none_or(|members| members.binary_search(&worker).is_ok())
    }

    /// Forgets the replicas of the last step.
    pub fn clear(&mut self) {
        self.replicas = 0;
    }

    /// Sends the own pairs to all workers and adds those of all others to the table, with the
    /// nodes that they touch. Before the call, the table has the own pairs, ascending. `users`
    /// returns the other workers that have a node.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn gather<'a>(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        table: &mut PairTable,
        users: impl Fn(u32) -> &'a [u32],
    ) -> Result<(), RankLost> {
        let me = comm.rank() - 1;
        let sent = gather_all(comm, packed(nodes, &table.pairs, users))?;
        let held = nodes.len();
        let mut now = Replication { held, members: Vec::new(), total: 0 };
        let mut mails: Vec<(usize, Mailbox)> = Vec::new();
        for (worker, words) in sent.into_iter().enumerate().filter(|(_, words)| !words.is_empty()) {
            let mut mail = Mailbox::from_words(words);
            let [pair_count, user_count] = mail.take::<[u64; 2]>();
            now.total += pair_count;
            now.members.push(worker);
            let sent = mail.take_many::<u64>(user_count as usize).iter();
            now.members.extend(sent.map(|&w| w as usize));
            mails.push((worker, mail));
        }
        now.members.sort_unstable();
        now.members.dedup();
        self.now = Some(now);
        mails.retain(|(worker, _)| *worker != me);
        if self.takes_part(me) && !mails.is_empty() {
            let mut added: Vec<ContactNode> = Vec::new();
            for (_, mail) in &mut mails {
                let count = mail.take::<u64>() as usize;
                let sent = mail.take_many::<ContactNode>(count).iter();
                added.extend(sent.filter(|n| nodes.index_of(n.id).is_none()));
            }
            added.sort_unstable_by_key(|n| n.id);
            added.dedup_by_key(|n| n.id);
            added.iter().for_each(|n| nodes.push_contact_node(n));
            for (_, mail) in &mut mails {
                while !mail.is_read() {
                    table.pairs.push(read(mail, nodes, held, table.by_area));
                }
            }
            table.sort_by_key();
            table.index_by_node();
            table.keep_coupled(held as u32);
            self.replicas = table.pairs.iter().filter(|p| p.is_replica).count() as u64;
        }
        table.index_by_node();
        Ok(())
    }

    /// Keeps the pairs that touch a local node or a ghost, as copies of the pairs of their owners,
    /// and removes all other pairs of other workers and their nodes. Call it when the forces are
    /// known.
    pub fn remove(&mut self, nodes: &mut Nodes, table: &mut PairTable) {
        let Some(Replication { held, .. }) = self.now.take() else { return };
        if table.pairs.iter().any(|p| p.is_replica) {
            table.remove_replicas(held as u32);
        }
        nodes.truncate(held);
    }
}

/// Returns the number of words that the owner of these pairs sends to all workers, if this number
/// of other workers have nodes of them. `pairs` must have the indices of all their nodes.
pub fn message_words(pairs: &[&Pair], users: usize) -> usize {
    if pairs.is_empty() {
        return 0;
    }
    let of_pair = |pair: &&Pair| {
        let rest = if pair.key.is_segment() { REST } else { 0 };
        pair_exchange::message_words(pair) + words_of::<PackedLaw>() + rest
    };
    let nodes = corners(pairs.iter().copied()).len() * words_of::<ContactNode>();
    3 + users + nodes + pairs.iter().map(of_pair).sum::<usize>()
}

/// Returns the indices of all corners of pairs, also of those without a share of the force: the
/// velocity of a face includes them.
fn corners<'a>(pairs: impl Iterator<Item = &'a Pair>) -> Vec<u32> {
    let all = pairs.flat_map(|p| p.nodes[..p.node_count()].iter().copied());
    let mut corners: Vec<u32> = all.filter(|&n| n != NOT_LOCAL).collect();
    corners.sort_unstable();
    corners.dedup();
    corners
}

/// Returns the own pairs with their nodes, as words of a message; empty without pairs. `users`
/// returns the other workers that have a node.
fn packed<'a>(nodes: &Nodes, own: &[Pair], users: impl Fn(u32) -> &'a [u32]) -> Vec<u64> {
    let mut mail = Mailbox::default();
    if own.is_empty() {
        return mail.into_words();
    }
    let all = own.iter().flat_map(Pair::local_nodes).flat_map(users);
    let all: BTreeSet<u64> = all.map(|&w| w.into()).collect();
    mail.push([own.len(), all.len()].map(|n| n as u64));
    all.iter().for_each(|&w| mail.push(w));
    let corners = corners(own.iter());
    mail.push(corners.len() as u64);
    corners.iter().for_each(|&n| mail.push(nodes.contact_node(n as usize)));
    for pair in own {
        write_pair(&mut mail, pair, nodes);
        mail.push(PackedLaw {
            shape: std::array::from_fn(|r| pair.shape[r]),
            gap: pair.gap,
            speed: pair.speed,
            friction_coefficient: pair.friction_coefficient,
            max_friction_force: pair.max_friction_force,
            slip: pair.slip,
            stiffness: pair.stiffness,
            slave_surface_first: pair.slave_surface_first.into(),
        });
        if pair.key.is_segment() {
            mail.push::<[f64; REST]>(std::array::from_fn(|r| pair.shape[FIRST + r]));
        }
    }
    mail.into_words()
}

/// Reads the next pair of another worker. `held` is the number of local nodes and ghosts, which
/// the nodes of such pairs follow in ascending id.
fn read(mail: &mut Mailbox, nodes: &Nodes, held: usize, by_area: bool) -> Pair {
    let index = |id: NodeId| {
        let added = || nodes.id[held..].binary_search(&id).ok().map(|i| (held + i) as u32);
        nodes.index_among(id, held).or_else(added).unwrap_or(NOT_LOCAL)
    };
    let pair = read_pair(mail, index, by_area);
    let law: PackedLaw = mail.take();
    let mut shape: [f64; MAX_PAIR_NODES] = padded(law.shape);
    if pair.key.is_segment() {
        shape[FIRST..].copy_from_slice(&mail.take::<[f64; REST]>());
    }
    Pair {
        shape,
        gap: law.gap,
        speed: law.speed,
        friction_coefficient: law.friction_coefficient,
        max_friction_force: law.max_friction_force,
        slip: law.slip,
        stiffness: law.stiffness,
        slave_surface_first: law.slave_surface_first != 0,
        is_owned: true,
        is_replica: true,
        ..pair
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::pairs::PairKey;
    use crumple_proto::ids::SegmentId;
    use crumple_proto::partition::NodeRecord;
    use crumple_proto::transport::threads;

    /// A mass whose inverse has another inverse than itself.
    fn mass(id: u64) -> f64 {
        49.0 * id as f64
    }

    /// Nodes of a worker, the last `ghosts` of them ghosts. Coordinates, velocities and masses
    /// follow from the ids.
    fn nodes(me: u32, ids: &[u64], ghosts: usize) -> Nodes {
        let record = |&id: &u64| NodeRecord {
            id: NodeId(id),
            x: [id as f64, 0.0, 1.0],
            v: [0.0, id as f64, 0.0],
            mass: mass(id),
            ..NodeRecord::default()
        };
        let (local, others) = ids.split_at(ids.len() - ghosts);
        let mut nodes = Nodes::new(&local.iter().map(record).collect::<Vec<_>>(), me, true);
        nodes.add_ghosts(others.iter().map(|id| (record(id), 2)));
        (0..ids.len()).for_each(|i| {
            nodes.v_next[i] = [ids[i] as f64, 2.0, 3.0, 0.0];
            nodes.w_next[i] = [4.0, 5.0, ids[i] as f64, 0.0];
        });
        nodes
    }

    /// An own pair of the nodes at these indices: the slave, and a face without a share of its
    /// last corner.
    fn pair(nodes: &Nodes, places: [u32; 5]) -> Pair {
        let slave = nodes.id[places[0] as usize];
        let shape = padded([1.0, 0.5, 0.25, 0.25, 0.0]);
        Pair {
            shape,
            weight: shape,
            normal: V3::new(0.0, 0.0, slave.0 as f64),
            gap: -0.1 * slave.0 as f64,
            slip: V3::new(1.0, 0.0, slave.0 as f64),
            friction_coefficient: 0.3,
            slave_surface_first: true,
            is_owned: true,
            ..Pair::new(PairKey::of_node(slave, SegmentId(7)), SegmentId(7), places)
        }
    }

    /// Pairs and number of nodes of a worker, during the sweeps and after them.
    #[derive(Debug, PartialEq)]
    struct Seen {
        /// Slaves of the pairs, with true for pairs whose forces it computes.
        pairs: [Vec<(u64, bool)>; 2],
        nodes: [usize; 2],
    }

    /// The first two workers have pairs with a common node; the pair of the third one is alone, the
    /// fourth one has a node of a pair, and the fifth one a ghost of another. Each worker computes
    /// the pairs that act on its nodes, directly or through others. Afterwards it has the pairs
    /// that touch its nodes, and no node more.
    #[test]
    fn workers_compute_the_pairs_that_act_on_their_nodes() {
        let nodes_of: [&[u64]; 5] =
            [&[1, 2, 3, 4, 5], &[3, 6, 7, 8, 9], &[21, 22, 23, 24, 25], &[9, 30], &[31, 22]];
        let run = |me: usize, comm: &mut dyn Transport| {
            let mut nodes = nodes(me as u32, nodes_of[me], usize::from(me == 4));
            let mut table = PairTable::default();
            match me {
                1 => table.pairs.push(pair(&nodes, [4, 0, 1, 2, 3])),
                3 | 4 => {}
                _ => table.pairs.push(pair(&nodes, [0, 1, 2, 3, 4])),
            }
            let mut replicated = ReplicatedPairs::default();
            let users = |n: u32| match (me, nodes_of[me][n as usize]) {
                (0, 3) => &[1][..],
                (1, 3) => &[0],
                (1, 9) => &[3],
                (2, 22) => &[4],
                _ => &[],
            };
            replicated.gather(comm, &mut nodes, &mut table, users).unwrap();
            assert_eq!(replicated.total(), Some(3));
            assert_eq!(replicated.members(), Some(&[0, 1, 2, 3, 4][..]));
            let slaves = |table: &PairTable| {
                table.pairs.iter().map(|p| (p.key.slave.0, p.is_owned)).collect::<Vec<_>>()
            };
            let during = (slaves(&table), nodes.len());
            for p in &table.pairs {
                // The whole pair, with the state of its nodes, is there on each worker.
                let id = p.key.slave.0 as f64;
                assert_eq!((p.gap, p.slip.z, p.normal.z), (-0.1 * id, id, id));
                assert!(p.slave_surface_first && p.friction_coefficient == 0.3);
                assert_eq!(p.shape, padded([1.0, 0.5, 0.25, 0.25, 0.0]));
                for n in p.nodes[..5].iter().map(|&n| n as usize) {
                    let id = nodes.id[n].0 as f64;
                    assert_eq!(nodes.contact_node(n).x, [id, 0.0, 1.0]);
                    assert_eq!(nodes.contact_node(n).v, [[0.0, id, 0.0], [id, 2.0, 3.0]]);
                    assert_eq!(nodes.contact_node(n).w_next, [4.0, 5.0, id]);
                    assert_eq!(nodes.inv_mass[n][..3], [1.0 / mass(nodes.id[n].0); 3]);
                    assert_eq!(nodes.contact_mass(n), mass(nodes.id[n].0));
                }
            }
            for (n, total) in table.touched.iter().zip(&mut table.total) {
                *total = V3::new(0.0, 0.0, nodes.id[*n as usize].0 as f64);
            }
            replicated.remove(&mut nodes, &mut table);
            for (n, total) in table.touched.iter().zip(&table.total) {
                assert_eq!(total.z, nodes.id[*n as usize].0 as f64, "forces on nodes stay");
            }
            assert!(table.pairs.iter().all(|p| !p.is_replica));
            Seen { pairs: [during.0, slaves(&table)], nodes: [during.1, nodes.len()] }
        };
        let mut comms = threads::connect(6).into_iter().skip(1).enumerate();
        let seen: Vec<Seen> = std::thread::scope(|scope| {
            let each: Vec<_> =
                comms.by_ref().map(|(me, mut c)| scope.spawn(move || run(me, &mut c))).collect();
            each.into_iter().map(|one| one.join().unwrap()).collect()
        });
        let (both, alone) = (vec![(1, true), (9, true)], vec![(21, true)]);
        let copied = |first: bool| vec![(1, first), (9, !first)];
        let expected = [
            (both.clone(), copied(true), [14, 5]),
            (both.clone(), copied(false), [14, 5]),
            (alone.clone(), alone, [14, 5]),
            (both, vec![(9, false)], [15, 2]),
            (vec![(21, true)], vec![(21, false)], [15, 2]),
        ];
        for (w, (seen, (during, after, nodes))) in seen.iter().zip(expected).enumerate() {
            assert_eq!(*seen, Seen { pairs: [during, after], nodes }, "worker {w}");
        }
    }
}
