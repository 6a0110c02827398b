//! Assembly plans: the element nodal forces that each local node sums, and when. There is one
//! plan for steps with all elements and one for steps without slow elements.

use crumple_math::row::Row;
use std::ops::Range;
use std::time::Duration;

/// Order in which elements are computed and nodal forces are assembled.
#[derive(Debug, Default)]
pub struct AssemblyPlan {
    /// For each local node, the start of its slots in `slots`.
    start: Vec<u32>,
    /// Slots of element nodal forces, node by node, in ascending global element id.
    slots: Vec<u32>,
    /// Groups in the order of computation, by portion of the elements.
    pub batches: [Vec<AssemblyBatch>; 3],
    /// Ranges of the batches that a thread computes one after the other, by portion; empty for a
    /// single thread.
    pub runs: [Vec<Range<usize>>; 3],
    /// Nodes that are assembled after a batch, batch by batch.
    pub early: Vec<u32>,
    /// With several threads the place of each local node in `early`, or [`LATE`].
    pub place: Vec<u32>,
    /// Local nodes that are assembled at the end: they need messages of other workers, they have no
    /// slots, or their slots belong to more than one run.
    pub late: Vec<u32>,
}

/// Place of a node that is assembled at the end.
pub const LATE: u32 = u32::MAX;

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

/// Weight of the latest measurement in the smoothed cost of a batch.
const NEWEST: f64 = 0.2;

impl AssemblyBatch {
    /// Adds a measured CPU time to the smoothed cost.
    pub fn add_cost(&mut self, measured: Duration) {
        let newest = if self.cost > 0.0 { NEWEST } else { 1.0 };
        self.cost += newest * (measured.as_secs_f64() - self.cost);
    }
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
    /// since forces are added to these slots until then. So are nodes whose slots belong to more
    /// than one of the `runs` of several threads, see [`Self::runs`]. `slots_of` returns the slots
    /// that a batch computes.
    pub fn build_batches(
        &mut self,
        batches: [Vec<AssemblyBatch>; 3],
        runs: [Vec<Range<usize>>; 3],
        received: usize,
        loaded: &[Range<usize>],
        slots_of: impl Fn(&AssemblyBatch) -> Range<usize>,
    ) {
        (self.batches, self.runs) = (batches, runs);
        // Batch after which each slot is complete. Slots of inactive elements always are, but
        // belong to no run: with several threads nodes of such elements are assembled at the end.
        let is_cut = self.runs.iter().any(|runs| !runs.is_empty());
        let mut when = vec![if is_cut { u32::MAX } else { 0 }; received];
        for (number, batch) in self.batches.iter().flatten().enumerate() {
            let slots = slots_of(batch);
            when[slots].fill(number as u32);
        }
        for slots in loaded {
            when[slots.clone()].fill(u32::MAX);
        }
        let lengths = self.batches.each_ref().map(Vec::len);
        let count = lengths.iter().sum();
        // The run of each batch.
        let mut run_of = vec![0u32; count];
        let firsts = [0, lengths[0], lengths[0] + lengths[1]];
        let runs = firsts.iter().zip(&self.runs);
        let all = runs.flat_map(|(first, runs)| {
            runs.iter().map(move |run| first + run.start..first + run.end)
        });
        all.zip(0..).for_each(|(run, number)| run_of[run].fill(number));
        let mut ready: Vec<Vec<u32>> = vec![Vec::new(); count];
        self.late.clear();
        for i in 0..self.start.len().saturating_sub(1) {
            let complete = self
                .slots_of(i)
                .iter()
                .map(|&slot| when.get(slot as usize).copied())
                .max_by_key(|w| w.unwrap_or(u32::MAX));
            let complete = complete.flatten().filter(|&w| {
                let run = |w: u32| run_of.get(w as usize);
                let mut others = self.slots_of(i).iter().map(|&slot| when.get(slot as usize));
                !is_cut || others.all(|other| other.is_some_and(|&other| run(other) == run(w)))
            });
            match complete.and_then(|w| ready.get_mut(w as usize)) {
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
        self.place.clear();
        if is_cut {
            self.place.resize(self.start.len().saturating_sub(1), LATE);
            (0..).zip(&self.early).for_each(|(place, &i)| self.place[i as usize] = place);
        }
    }

    /// Returns true if several threads compute the batches, in [`Self::runs`].
    pub fn is_cut(&self) -> bool {
        !self.place.is_empty()
    }

    /// Returns the slots of local node `i`, in ascending element id.
    #[inline]
    pub fn slots_of(&self, i: usize) -> &[u32] {
        &self.slots[self.start[i] as usize..self.start[i + 1] as usize]
    }

    /// Sets sums of nodes to minus the sum of their slots of `column`, in ascending element id.
    /// The column begins with the slot `first`. `which` gives local nodes, each with its place in
    /// `sums`.
    pub fn assemble(
        &self,
        (column, first): (&[Row], usize),
        sums: &mut [Row],
        which: impl Iterator<Item = [usize; 2]>,
    ) {
        for [i, place] in which {
            let mut sum = [0.0; 4];
            for &slot in self.slots_of(i) {
                (0..4).for_each(|c| sum[c] -= column[slot as usize - first][c]);
            }
            sums[place] = sum;
        }
    }

    /// Assembles two columns at once, see [`Self::assemble`].
    pub fn assemble_both(
        &self,
        (columns, first): ([&[Row]; 2], usize),
        sums: [&mut [Row]; 2],
        which: impl Iterator<Item = [usize; 2]>,
    ) {
        let ([forces, moments], [force, moment]) = (columns, sums);
        for [i, place] in which {
            let (mut f, mut m) = ([0.0; 4], [0.0; 4]);
            for &slot in self.slots_of(i) {
                let slot = slot as usize - first;
                let (sf, sm) = (&forces[slot], &moments[slot]);
                for c in 0..4 {
                    f[c] -= sf[c];
                    m[c] -= sm[c];
                }
            }
            (force[place], moment[place]) = (f, m);
        }
    }

    /// Returns the bytes in use, without unused capacity.
    pub fn bytes(&self) -> usize {
        [&self.slots, &self.start, &self.early, &self.late, &self.place]
            .map(|l| size_of_val(&l[..]))
            .iter()
            .sum()
    }
}
