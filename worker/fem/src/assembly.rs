//! Assembly plans: the element nodal forces that each local node sums, and when. There is one
//! plan for steps with all elements and one for steps without slow elements.

use crumple_math::row::Row;
use std::ops::Range;

/// Order in which elements are computed and nodal forces are assembled.
#[derive(Debug, Default)]
pub struct AssemblyPlan {
    /// For each local node, the start of its slots in `slots`.
    start: Vec<u32>,
    /// Slots of element nodal forces, node by node, in ascending global element id.
    slots: Vec<u32>,
    /// Groups in the order of computation, by portion of the elements.
    pub batches: [Vec<AssemblyBatch>; 3],
    /// Nodes that are assembled after a batch, batch by batch.
    pub early: Vec<u32>,
    /// Local nodes that are assembled at the end: they need messages of other workers, or they
    /// have no slots.
    pub late: Vec<u32>,
}

/// Groups of a block that are computed together, and the nodes that are complete after them.
/// These are assembled while the forces are still in the cache.
#[derive(Debug)]
pub struct AssemblyBatch {
    /// Index of the block.
    pub block: usize,
    /// Groups of the block.
    pub groups: Range<usize>,
    /// Range of `AssemblyPlan::early`.
    pub nodes: Range<usize>,
    /// Measured CPU time of its elements in a cycle, smoothed; 0 before the first measurement
    /// [s].
    pub cost: f64,
}

/// Corners of an element at local nodes, own or received.
pub struct ElementCorner<'a> {
    /// Local nodes.
    pub nodes: &'a [u32],
    /// Slot of the first corner; the others follow.
    pub first: usize,
}

impl AssemblyPlan {
    /// Creates a plan in which nodes sum corners in the order of `elements`.
    pub fn new<'a>(held: usize, elements: impl Iterator<Item = ElementCorner<'a>> + Clone) -> Self {
        let mut start = vec![0; held + 1];
        for e in elements.clone() {
            e.nodes.iter().for_each(|&n| start[n as usize + 1] += 1);
        }
        for i in 0..held {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut slots = vec![0; start[held] as usize];
        for e in elements {
            for (&n, slot) in e.nodes.iter().zip(e.first as u32..) {
                slots[next[n as usize] as usize] = slot;
                next[n as usize] += 1;
            }
        }
        Self { start, slots, ..Self::default() }
    }

    /// Decides when nodes are assembled: after the batch that completes them, in the order of
    /// `batches`. Nodes with a slot from `received` on, or in `loaded`, are assembled at the end,
    /// since forces are added to these slots until then. `slots_of` returns the slots that a
    /// batch computes.
    pub fn build_batches(
        &mut self,
        batches: [Vec<AssemblyBatch>; 3],
        received: usize,
        loaded: &[Range<usize>],
        slots_of: impl Fn(&AssemblyBatch) -> Range<usize>,
    ) {
        self.batches = batches;
        // Batch after which each slot is complete; slots of inactive elements always are.
        let mut when = vec![0u32; received];
        for (number, batch) in self.batches.iter().flatten().enumerate() {
            let slots = slots_of(batch);
            when[slots].fill(number as u32);
        }
        for slots in loaded {
            when[slots.clone()].fill(u32::MAX);
        }
        let count = self.batches.iter().map(Vec::len).sum();
        let mut ready: Vec<Vec<u32>> = vec![Vec::new(); count];
        self.late.clear();
        for i in 0..self.start.len().saturating_sub(1) {
            let complete = self
                .slots_of(i)
                .iter()
                .map(|&slot| when.get(slot as usize).copied())
                .max_by_key(|w| w.unwrap_or(u32::MAX));
            match complete.flatten().and_then(|w| ready.get_mut(w as usize)) {
                Some(batch) => batch.push(i as u32),
                None => self.late.push(i as u32),
            }
        }
        self.early.clear();
        for (batch, nodes) in self.batches.iter_mut().flatten().zip(ready) {
            let first = self.early.len();
            self.early.extend(nodes);
            batch.nodes = first..self.early.len();
        }
    }

    /// Returns the slots of local node `i`, in ascending element id.
    #[inline]
    pub fn slots_of(&self, i: usize) -> &[u32] {
        &self.slots[self.start[i] as usize..self.start[i + 1] as usize]
    }

    /// Sets `sums` at the nodes `which` to minus the sum of their slots of `column`, in ascending
    /// element id.
    pub fn assemble(&self, column: &[Row], sums: &mut [Row], which: &[u32]) {
        for i in which.iter().map(|&i| i as usize) {
            let mut sum = [0.0; 4];
            for &slot in self.slots_of(i) {
                (0..4).for_each(|c| sum[c] -= column[slot as usize][c]);
            }
            sums[i] = sum;
        }
    }

    /// Assembles two columns at once, see [`Self::assemble`].
    pub fn assemble_both(&self, columns: [&[Row]; 2], sums: [&mut [Row]; 2], which: &[u32]) {
        let ([forces, moments], [force, moment]) = (columns, sums);
        for i in which.iter().map(|&i| i as usize) {
            let (mut f, mut m) = ([0.0; 4], [0.0; 4]);
            for &slot in self.slots_of(i) {
                let (sf, sm) = (&forces[slot as usize], &moments[slot as usize]);
                for c in 0..4 {
                    f[c] -= sf[c];
                    m[c] -= sm[c];
                }
            }
            (force[i], moment[i]) = (f, m);
        }
    }

    /// Returns the bytes in use, without unused capacity.
    pub fn bytes(&self) -> usize {
        [&self.slots, &self.start, &self.early, &self.late]
            .map(|l| size_of_val(&l[..]))
            .iter()
            .sum()
    }
}
