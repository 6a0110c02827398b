//! Decomposition of space into boxes. One method per file; at present recursive coordinate
//! bisection.

mod rcb;

pub use rcb::{Before, bisect};

use crumple_proto::boxes::{Aabb, Cut, CutTree};
use crumple_proto::message::{ToMaster, ToWorker};
use crumple_proto::report::{StepLoads, add_to_bin};
use crumple_proto::transport::{RankLost, Tag, Transport};
use crumple_proto::wire::{await_message, post};

/// Leaf entry of a growing tree, axis, and lower and upper end of a histogram [length].
pub type HistogramRange = (usize, usize, f64, f64);

/// The load as a decomposition method sees it. Only boxes and histograms are exchanged, never the
/// mesh.
pub trait Load {
    /// Returns the box around the element centres in each of these leaf entries of the growing
    /// tree.
    ///
    /// # Errors
    /// A worker was lost.
    fn extents(&mut self, tree: &CutTree, entries: &[usize]) -> Result<Vec<Aabb>, RankLost>;

    /// Returns the loads per bin along an axis in leaf entries of the growing tree.
    ///
    /// # Errors
    /// A worker was lost.
    fn histograms(
        &mut self,
        tree: &CutTree,
        of: &[HistogramRange],
        bins: usize,
    ) -> Result<Vec<Vec<StepLoads>>, RankLost>;
}

/// Adds histograms bin by bin.
fn add(sum: &mut [Vec<StepLoads>], part: &[Vec<StepLoads>]) {
    let bins = sum.iter_mut().flatten().zip(part.iter().flatten());
    bins.for_each(|(a, b)| (0..2).for_each(|kind| a[kind] += b[kind]));
}

/// Element centres in this process, all with equal load: those of the master before the start.
pub struct Centres(pub Vec<[f64; 3]>);

/// Element centres in this process, each with its loads.
pub struct ElementLoads(pub Vec<([f64; 3], StepLoads)>);

impl Load for Centres {
    fn extents(&mut self, tree: &CutTree, entries: &[usize]) -> Result<Vec<Aabb>, RankLost> {
        Ok(extents(self.0.iter().copied(), tree, entries))
    }

    fn histograms(
        &mut self,
        tree: &CutTree,
        of: &[HistogramRange],
        bins: usize,
    ) -> Result<Vec<Vec<StepLoads>>, RankLost> {
        Ok(histograms(self.0.iter().map(|&c| (c, [1.0, 0.0])), tree, of, bins))
    }
}

impl Load for ElementLoads {
    fn extents(&mut self, tree: &CutTree, entries: &[usize]) -> Result<Vec<Aabb>, RankLost> {
        Ok(extents(self.0.iter().map(|l| l.0), tree, entries))
    }

    fn histograms(
        &mut self,
        tree: &CutTree,
        of: &[HistogramRange],
        bins: usize,
    ) -> Result<Vec<Vec<StepLoads>>, RankLost> {
        Ok(histograms(self.0.iter().copied(), tree, of, bins))
    }
}

/// Returns the index of each entry of a tree in `entries`, `usize::MAX` for those not in it.
fn places(tree: &CutTree, entries: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut place = vec![usize::MAX; tree.entries.len()];
    entries.enumerate().for_each(|(i, e)| place[e] = i);
    place
}

fn extents(
    centres: impl Iterator<Item = [f64; 3]>,
    tree: &CutTree,
    entries: &[usize],
) -> Vec<Aabb> {
    let place = places(tree, entries.iter().copied());
    let mut extents = vec![Aabb::EMPTY; entries.len()];
    for c in centres {
        if let Some(extent) = extents.get_mut(place[tree.entry_of(c)]) {
            extent.include(c);
        }
    }
    extents
}

fn histograms(
    loads: impl Iterator<Item = ([f64; 3], StepLoads)>,
    tree: &CutTree,
    of: &[HistogramRange],
    bins: usize,
) -> Vec<Vec<StepLoads>> {
    let place = places(tree, of.iter().map(|o| o.0));
    let mut histograms = vec![vec![[0.0; 2]; bins]; of.len()];
    for (c, load) in loads {
        let i = place[tree.entry_of(c)];
        if let Some(&(_, axis, lo, hi)) = of.get(i) {
            add_to_bin(&mut histograms[i], (lo, hi), c[axis], load);
        }
    }
    histograms
}

/// Workers that have stopped for a low redecomposition and answer requests.
pub struct Workers<'a> {
    /// The master's end of the connection.
    pub comm: &'a mut dyn Transport,
    /// Time of a contact pair in a cycle [s].
    pub pair_s: f64,
    /// Messages of other kinds that arrived meanwhile, with the worker that sent them.
    pub aside: Vec<(usize, ToMaster)>,
}

impl Workers<'_> {
    fn ask<T>(
        &mut self,
        question: &ToWorker,
        answer: impl Fn(ToMaster) -> Result<T, Box<ToMaster>>,
    ) -> Result<Vec<T>, RankLost> {
        let ranks = 1..self.comm.size();
        for rank in ranks.clone() {
            post(self.comm, rank, Tag::Order, question)?;
        }
        let mut answers = Vec::new();
        for rank in ranks {
            loop {
                match answer(await_message(self.comm, rank, Tag::Report)?) {
                    Ok(a) => break answers.push(a),
                    Err(other) => self.aside.push((rank - 1, *other)),
                }
            }
        }
        Ok(answers)
    }
}

impl Load for Workers<'_> {
    fn extents(&mut self, tree: &CutTree, entries: &[usize]) -> Result<Vec<Aabb>, RankLost> {
        let question = ToWorker::Extents { tree: tree.clone(), entries: entries.to_vec() };
        let answers = self.ask(&question, |m| {
            if let ToMaster::Extents(e) = m { Ok(e) } else { Err(Box::new(m)) }
        })?;
        let around = |i: usize| {
            let boxes = answers.iter().map(|a| &a[i]).filter(|b| !b.is_empty());
            Aabb::around(boxes.flat_map(|b| [b.min, b.max]))
        };
        Ok((0..entries.len()).map(around).collect())
    }

    fn histograms(
        &mut self,
        tree: &CutTree,
        of: &[HistogramRange],
        bins: usize,
    ) -> Result<Vec<Vec<StepLoads>>, RankLost> {
        let (of_ranges, pair_s) = (of.to_vec(), self.pair_s);
        let question = ToWorker::Histograms { tree: tree.clone(), of: of_ranges, bins, pair_s };
        let answers = self.ask(&question, |m| {
            if let ToMaster::Histograms(h) = m { Ok(h) } else { Err(Box::new(m)) }
        })?;
        let mut sum = vec![vec![[0.0; 2]; bins]; of.len()];
        answers.iter().for_each(|a| add(&mut sum, a));
        Ok(sum)
    }
}

/// Returns the tree with every plane moved along its axis by the mean drift of the workers below
/// it: `drift` per worker [length], weighted by `elements`. The boxes still tile space. Boxes
/// follow a structure in flight, so that it is redecomposed only for its deformation.
pub fn drifted(tree: &CutTree, drift: &[[f64; 3]], elements: &[u64]) -> CutTree {
    let mut moved = tree.clone();
    for i in 0..tree.entries.len() {
        let leaves = tree.leaves(i);
        let weight: f64 = leaves.iter().map(|&w| elements[w] as f64).sum();
        if let Cut::Plane { axis, at, .. } = &mut moved.entries[i] {
            let sum: f64 = leaves.iter().map(|&w| elements[w] as f64 * drift[w][*axis]).sum();
            *at += if weight > 0.0 { sum / weight } else { 0.0 };
        }
    }
    moved
}
