//! Where the boxes are. One method per file; so far recursive coordinate bisection.

mod rcb;

pub use rcb::bisect;

use crumple_proto::boxes::{Aabb, Cut, CutTree};
use crumple_proto::message::{ToMaster, ToWorker};
use crumple_proto::transport::{RankLost, Tag, Transport};
use crumple_proto::wire::{await_message, post};

/// An entry of a growing tree, an axis, and the lower and upper end of a histogram.
pub type HistogramRange = (usize, usize, f64, f64);

/// What a method may ask about the load. Only boxes and histograms pass, never the mesh.
pub trait Load {
    /// Box around the element centres in each of these leaf entries of the growing tree.
    ///
    /// # Errors
    /// A worker is gone.
    fn extents(&mut self, tree: &CutTree, entries: &[usize]) -> Result<Vec<Aabb>, RankLost>;

    /// Load per bin along an axis in leaf entries of the growing tree.
    ///
    /// # Errors
    /// A worker is gone.
    fn histograms(
        &mut self,
        tree: &CutTree,
        of: &[HistogramRange],
        bins: usize,
    ) -> Result<Vec<Vec<f64>>, RankLost>;
}

/// Adds up per bin.
fn add(sum: &mut [Vec<f64>], part: &[Vec<f64>]) {
    for (s, p) in sum.iter_mut().zip(part) {
        s.iter_mut().zip(p).for_each(|(a, b)| *a += b);
    }
}

/// Element centres that are at hand, all of one load: the master's before the start.
pub struct Centres(pub Vec<[f64; 3]>);

/// Element centres that are at hand, with the load of each.
pub struct Loads(pub Vec<([f64; 3], f64)>);

impl Load for Centres {
    fn extents(&mut self, tree: &CutTree, entries: &[usize]) -> Result<Vec<Aabb>, RankLost> {
        Ok(extents(self.0.iter().copied(), tree, entries))
    }

    fn histograms(
        &mut self,
        tree: &CutTree,
        of: &[HistogramRange],
        bins: usize,
    ) -> Result<Vec<Vec<f64>>, RankLost> {
        Ok(histograms(self.0.iter().map(|&c| (c, 1.0)), tree, of, bins))
    }
}

impl Load for Loads {
    fn extents(&mut self, tree: &CutTree, entries: &[usize]) -> Result<Vec<Aabb>, RankLost> {
        Ok(extents(self.0.iter().map(|l| l.0), tree, entries))
    }

    fn histograms(
        &mut self,
        tree: &CutTree,
        of: &[HistogramRange],
        bins: usize,
    ) -> Result<Vec<Vec<f64>>, RankLost> {
        Ok(histograms(self.0.iter().copied(), tree, of, bins))
    }
}

/// Place of each entry of a tree in a list of some of them; `usize::MAX` for the others.
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
    loads: impl Iterator<Item = ([f64; 3], f64)>,
    tree: &CutTree,
    of: &[HistogramRange],
    bins: usize,
) -> Vec<Vec<f64>> {
    let place = places(tree, of.iter().map(|o| o.0));
    let mut histograms = vec![vec![0.0; bins]; of.len()];
    for (c, load) in loads {
        let i = place[tree.entry_of(c)];
        if let Some(&(_, axis, lo, hi)) = of.get(i) {
            let at = (c[axis] - lo) / (hi - lo).max(f64::MIN_POSITIVE) * bins as f64;
            histograms[i][(at.max(0.0) as usize).min(bins - 1)] += load;
        }
    }
    histograms
}

/// Workers that have stopped for a low redecomposition and answer questions.
pub struct Workers<'a> {
    /// The master's end.
    pub comm: &'a mut dyn Transport,
    /// Cost of a contact pair in units of an element's.
    pub pair_weight: f64,
    /// Messages of other kinds that came in between, with the worker that sent them.
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
    ) -> Result<Vec<Vec<f64>>, RankLost> {
        let pair_weight = self.pair_weight;
        let question =
            ToWorker::Histograms { tree: tree.clone(), of: of.to_vec(), bins, pair_weight };
        let answers = self.ask(&question, |m| {
            if let ToMaster::Histograms(h) = m { Ok(h) } else { Err(Box::new(m)) }
        })?;
        let mut sum = vec![vec![0.0; bins]; of.len()];
        answers.iter().for_each(|a| add(&mut sum, a));
        Ok(sum)
    }
}

/// The tree with every plane moved along its axis with what lies under it: `drift` per worker,
/// weighed by `elements`. It still tiles space. A frame that flies takes its boxes along and
/// redecomposes for its crash only.
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
