//! Messages of ties: the states of nodes at the start, the lists of data that workers exchange, and
//! the exchange of these data in every step.

use super::Ties;
use crate::nodes::Nodes;
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::NodeId;
use crumple_proto::transport::{Mailbox, RankLost, Tag, Transport, exchange_all, gather_all};

/// A slave or master, as it is sent to all workers at the start.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PackedNode {
    /// Index in the list of ids.
    pub number: u64,
    /// See [`Nodes::fixed`].
    pub fixed: u64,
    /// Mass [mass].
    pub mass: f64,
    /// Rotational inertia [mass length^2].
    pub inertia: f64,
    /// Coordinates [length].
    pub x: [f64; 3],
    /// Velocity [length/time].
    pub v: [f64; 3],
    /// Rotational velocity [1/time].
    pub w: [f64; 3],
}

/// Data exchanged with another worker in every step, by numbers of ties and of masters.
#[derive(Debug, Default)]
pub struct Link {
    /// The other worker.
    pub worker: usize,
    /// Ties whose slaves this worker owns and the other needs.
    pub slaves_out: Vec<u32>,
    /// Ties whose slaves the other worker owns and this one needs.
    pub slaves_in: Vec<u32>,
    /// Masters that this worker owns and the other needs.
    pub masters_out: Vec<u32>,
    /// Masters that the other worker owns and this one needs.
    pub masters_in: Vec<u32>,
}

impl Ties {
    /// Requests the required data from other workers, and receives the lists of data they will
    /// send.
    pub(super) fn link(&mut self, comm: &mut dyn Transport, nodes: &Nodes) -> Result<(), RankLost> {
        let (workers, me) = (comm.size() - 1, comm.rank() - 1);
        let is_held = |n: u32| (n as usize) < nodes.local_count;
        let tied: Vec<u64> = self
            .force_sources
            .iter()
            .filter(|&&t| !is_held(self.slave_index[t as usize]))
            .map(|&t| u64::from(t))
            .collect();
        // Forces on a slave that follows a mean motion depend on the positions of all masters.
        let of_means = self.force_sources.iter().filter(|&&t| self.definitions[t as usize].mean);
        let needed = self.local_slaves.iter().chain(of_means);
        let followed = needed.flat_map(|&t| self.shares[t as usize].iter().map(|s| s.0));
        let of_faces = self.local_slaves.iter().filter_map(|&t| *self.breakable.get(t as usize)?);
        let mut carriers: Vec<u64> = followed
            .chain(of_faces.flat_map(|breakable| breakable.corners))
            .filter(|&c| !is_held(self.master_index[c as usize]))
            .map(u64::from)
            .collect();
        carriers.sort_unstable();
        carriers.dedup();
        let wanted = [&[tied.len() as u64], &tied[..], &carriers[..]].concat();
        let wanted = gather_all(comm, wanted)?;
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
            if !(link.slaves_out.is_empty() && link.masters_out.is_empty()) {
                let count = [link.slaves_out.len() as u32];
                let words = [&count[..], &link.slaves_out, &link.masters_out].concat();
                offered[w] = words.into_iter().map(u64::from).collect();
            }
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
}

/// Sends an item per entry of a list of each link.
///
/// # Errors
/// A worker is gone.
pub fn send<T: Pod>(
    comm: &mut dyn Transport,
    (links, mail): (&[Link], &mut Mailbox),
    list: fn(&Link) -> &[u32],
    item: impl Fn(u32) -> T,
) -> Result<(), RankLost> {
    links.iter().try_for_each(|l| mail.send_items(comm, l.worker, Tag::Ties, list(l), &item))
}

/// Receives an item per entry of a list of each link.
///
/// # Errors
/// A worker is gone.
pub fn receive<T: Pod>(
    comm: &mut dyn Transport,
    (links, mail): (&[Link], &mut Mailbox),
    list: fn(&Link) -> &[u32],
    mut store: impl FnMut(u32, T),
) -> Result<(), RankLost> {
    links
        .iter()
        .try_for_each(|l| mail.receive_items(comm, l.worker, Tag::Ties, list(l), &mut store))
}

/// Splits a list, preceded by its length, from the list that follows it.
fn halves(words: &[u64]) -> (&[u64], &[u64]) {
    words.split_first().map_or((&[], &[]), |(&count, rest)| rest.split_at(count as usize))
}

/// Returns the states of nodes, in the order of `ids`, from the workers that own them.
///
/// # Errors
/// A worker is gone.
pub fn of_owners(
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
    let mut all = vec![PackedNode::zeroed(); ids.len()];
    for one in gather_all(comm, mine)?.iter().flatten() {
        all[one.number as usize] = *one;
    }
    Ok(all)
}
