//! Volume strain of nodes, for elements that average it
//! ([`Element::averaged_volume`](crate::elements::Element::averaged_volume)).
//!
//! A node has one mean for each part around it, over the elements of all workers in ascending
//! global id. So it has the same bits on every worker.

use super::Blocks;
use crate::elements::volume_change;
use crate::nodes::Nodes;
use crumple_proto::ids::ElemId;

/// Number of nodes of an element that averages.
const NODES: usize = 4;

/// An element of another worker that averages, with at least one local node.
#[derive(Clone, Copy, Debug)]
pub struct RemoteVolume {
    /// The element.
    pub elem: ElemId,
    /// Index of its part.
    pub part: u32,
    /// Its local nodes; `None` for the others.
    pub nodes: [Option<u32>; NODES],
}

impl RemoteVolume {
    /// Adds a local node.
    pub fn add(&mut self, node: u32) {
        if let Some(free) = self.nodes.iter_mut().find(|n| n.is_none()) {
            *free = Some(node);
        }
    }
}

/// Means over the elements around the nodes.
#[derive(Debug, Default)]
pub struct NodalVolumes {
    /// Own elements, by block and index in the block.
    own: Vec<[usize; 2]>,
    /// For each own element, the indices of the means of its nodes.
    corners: Vec<[u32; NODES]>,
    /// For each mean, the start of its elements in `elements`.
    start: Vec<u32>,
    /// Indices into `changes`, mean by mean, in ascending element id.
    elements: Vec<u32>,
    /// Volume in the middle of the step and its change [length^3]: of own elements, then of
    /// received ones.
    pub changes: Vec<[f64; 2]>,
    means: Vec<f64>,
}

impl NodalVolumes {
    /// Returns the own elements that average their volume strain, by block and index in the block.
    pub fn own_elements(blocks: &Blocks) -> Vec<[usize; 2]> {
        let averaging = blocks.blocks.iter().enumerate();
        let averaging = averaging.filter(|(_, b)| b.element.averaged_volume().is_some() && !b.idle);
        averaging.flat_map(|(block, b)| (0..b.count).map(move |i| [block, i])).collect()
    }

    /// Creates the means of the own elements, with elements of other workers; `None` without own
    /// elements.
    pub fn new(blocks: &Blocks, own: Vec<[usize; 2]>, remote: &[RemoteVolume]) -> Option<Self> {
        let corner = |node: u32, part: u32, elem: ElemId, index: usize| (part, node, elem, index);
        let mut around = Vec::with_capacity(NODES * (own.len() + remote.len()));
        for (index, &[block, i]) in own.iter().enumerate() {
            let e = &blocks.elements[blocks.blocks[block].first + i];
            let nodes = e.nodes[..NODES].iter();
            around.extend(nodes.map(|&n| corner(n, e.record.part, e.record.id, index)));
        }
        for (index, e) in (own.len()..).zip(remote) {
            around.extend(e.nodes.iter().flatten().map(|&n| corner(n, e.part, e.elem, index)));
        }
        around.sort_unstable();
        let mut all = Self {
            corners: vec![[0; NODES]; own.len()],
            changes: vec![[0.0; 2]; own.len() + remote.len()],
            ..Self::default()
        };
        let mut filled = vec![0; own.len()];
        for run in around.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let mean = all.start.len() as u32;
            all.start.push(all.elements.len() as u32);
            for &(.., index) in run {
                all.elements.push(index as u32);
                if let Some(place) = filled.get_mut(index) {
                    all.corners[index][*place] = mean;
                    *place += 1;
                }
            }
        }
        all.means = vec![0.0; all.start.len()];
        all.start.push(all.elements.len() as u32);
        all.own = own;
        (!all.own.is_empty()).then_some(all)
    }

    /// Computes volumes and their changes in the last step, of size `dt` [time], of own elements.
    pub fn measure(&mut self, blocks: &Blocks, nodes: &Nodes, dt: f64) {
        let view = nodes.view();
        for (change, &[block, i]) in self.changes.iter_mut().zip(&self.own) {
            let b = &blocks.blocks[block];
            let e = &blocks.elements[b.first + i];
            let has_failed =
                e.record.failed || b.element.can_fail() && b.element.failed(b.state(i));
            *change = match (has_failed, e.nodes.first_chunk()) {
                (false, Some(corners)) => volume_change(&view, corners, dt),
                _ => [0.0; 2],
            };
        }
    }

    /// Computes the means from all changes and stores them in the histories of the own elements.
    pub fn store(&mut self, blocks: &mut Blocks) {
        for (mean, run) in self.means.iter_mut().zip(self.start.windows(2)) {
            let [mut volume, mut change] = [0.0; 2];
            for &index in &self.elements[run[0] as usize..run[1] as usize] {
                let [v, dv] = self.changes[index as usize];
                volume += v;
                change += dv;
            }
            *mean = if volume > 0.0 { change / volume } else { 0.0 };
        }
        for (&[block, i], corners) in self.own.iter().zip(&self.corners) {
            let [a, b, c, d] = corners.map(|mean| self.means[mean as usize]);
            blocks.blocks[block].set_averaged_volume(i, 0.25 * ((a + b) + (c + d)));
        }
    }

    /// Returns the bytes in use, without unused capacity.
    pub fn bytes(&self) -> usize {
        let Self { own, corners, start, elements, changes, means } = self;
        size_of_val(&own[..])
            + size_of_val(&corners[..])
            + size_of_val(&start[..])
            + size_of_val(&elements[..])
            + size_of_val(&changes[..])
            + size_of_val(&means[..])
    }
}
