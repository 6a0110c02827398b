//! Volume strain of nodes across workers, for elements that average it at their nodes
//! ([`NodalVolumes`]). Workers with common nodes send each other the volumes of their elements
//! there, in each step before the element forces.

use crate::fem::blocks::{Blocks, NodalVolumes, RemoteVolume};
use crate::nodes::Nodes;
use crate::parallel::ghosts::Ghosts;
use crumple_proto::ids::ElemId;
use crumple_proto::transport::{Mailbox, RankLost, Tag, Transport};
use std::collections::HashMap;

/// Own elements whose volumes another worker needs, and its elements whose volumes this one needs.
#[derive(Debug)]
pub struct VolumeLink {
    /// The other worker (0-based).
    worker: usize,
    /// Indices into [`NodalVolumes::changes`] of own elements at shared nodes, in ascending id.
    out: Vec<u32>,
    /// First received entry there, and their number.
    received: (usize, usize),
}

/// Links under construction.
pub struct VolumeLinks {
    /// Own elements that average, by block and index in the block.
    own: Vec<[usize; 2]>,
    /// For each of them its index in `own` and the index of its part.
    known: HashMap<ElemId, (u32, u32)>,
    remote: Vec<RemoteVolume>,
    links: Vec<VolumeLink>,
}

impl VolumeLinks {
    /// Finds the own elements that average.
    pub fn new(blocks: &Blocks) -> Self {
        let own = NodalVolumes::own_elements(blocks);
        let known = own.iter().zip(0..).map(|(&[block, i], index)| {
            let record = &blocks.elements[blocks.blocks[block].first + i].record;
            (record.id, (index, record.part))
        });
        Self { known: known.collect(), own, remote: Vec::new(), links: Vec::new() }
    }

    /// Returns the mark of an own element in messages: the index of its part plus one if it
    /// averages, else 0.
    pub fn mark(&self, elem: ElemId) -> u64 {
        self.known.get(&elem).map_or(0, |&(_, part)| u64::from(part) + 1)
    }

    /// Links a worker. `mine` are the own elements at common nodes; `theirs` are its elements with
    /// their marks and common nodes, node by node. Both are in ascending id. Without such elements
    /// on one of the two sides no messages are necessary.
    pub fn add(
        &mut self,
        worker: usize,
        mine: impl Iterator<Item = ElemId>,
        theirs: impl Iterator<Item = (ElemId, u64, u32)>,
    ) {
        let mut out: Vec<u32> =
            mine.filter_map(|id| self.known.get(&id)).map(|&(index, _)| index).collect();
        out.dedup();
        let first = self.remote.len();
        for (elem, mark, node) in theirs.filter(|(_, mark, _)| *mark > 0 && !out.is_empty()) {
            if self.remote[first..].last().is_none_or(|last| last.elem != elem) {
                self.remote.push(RemoteVolume::new(elem, (mark - 1) as u32));
            }
            if let Some(last) = self.remote.last_mut() {
                last.add(node);
            }
        }
        let received = (self.own.len() + first, self.remote.len() - first);
        if received.1 > 0 {
            self.links.push(VolumeLink { worker, out, received });
        }
    }

    /// Creates the means of the own elements. Returns the links.
    pub fn finish(self, blocks: &mut Blocks) -> Vec<VolumeLink> {
        blocks.volumes = NodalVolumes::new(blocks, self.own, &self.remote);
        self.links
    }
}

/// Computes the volume strain of the nodes after a step of size `dt` [time], and stores it in the
/// elements that average it.
///
/// # Errors
/// A worker is gone.
pub fn average_volumes(
    comm: &mut dyn Transport,
    nodes: &Nodes,
    blocks: &mut Blocks,
    halo: &Ghosts,
    dt: f64,
) -> Result<(), RankLost> {
    let Some(mut volumes) = blocks.volumes.take() else { return Ok(()) };
    volumes.measure(blocks, nodes, dt);
    let mut mail = Mailbox::default();
    for link in &halo.volumes {
        let change = |index: u32| volumes.changes[index as usize];
        mail.send_items(comm, link.worker, Tag::Volumes, &link.out, change)?;
    }
    for link in &halo.volumes {
        let (first, count) = link.received;
        mail.receive(comm, link.worker, Tag::Volumes)?;
        volumes.changes[first..first + count].copy_from_slice(mail.take_many(count));
    }
    volumes.store(blocks);
    blocks.volumes = Some(volumes);
    Ok(())
}
