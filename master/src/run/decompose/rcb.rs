//! Recursive coordinate bisection (Berger & Bokhari 1987). Each cut is made across the longest
//! extent, so that the load of both sides is proportional to their numbers of workers. Any number
//! of workers is possible. All cuts of a level are made together.
//!
//! A plane cannot divide a flat wall that is parallel to it. If the cut across the longest extent
//! is uneven for this reason, the next longest extent is tried, unless it is so much shorter that
//! the cut would have a large area.
//!
//! Workers wait for each other before contact and after it. So each of these two loads of a step
//! has to be even, not their sum (Walshaw, Cross & McManus 2000, on meshes with several phases). A
//! cut makes the sum of the largest loads small. It is tried along each axis where there is
//! contact: a plane across a frame leaves the crushed end to one side, a plane along it divides
//! both the end and the rest.

use super::Load;
use crumple_proto::boxes::{Aabb, Cut, CutTree};
use crumple_proto::report::StepLoads;
use crumple_proto::transport::RankLost;

/// Number of bins of a histogram. The position of a cut is exact to this fraction of the extent.
const BINS: usize = 512;
/// Excess above which another axis is tried, see [`CutCandidate::excess`].
const UNEVEN: f64 = 0.01;
/// Shortest extent that is cut across where there is no contact, as a fraction of the longest.
const SHORTEST: f64 = 0.25;
/// Cost of an element at a cut, which both sides know, over that of its own worker.
const SHARED_COST: f64 = 0.6;
/// Excess by which another axis must be better than that of the last cut, or than the longest:
/// most elements would change their worker, and measured loads scatter.
const CLEAR_GAIN: f64 = 0.05;

/// State before a decomposition, besides the load.
#[derive(Clone, Copy, Default)]
pub struct Before<'a> {
    /// Last boxes, if there are any. Their axes are kept unless others are clearly better.
    pub tree: Option<&'a CutTree>,
    /// Usual side of an element [length]. Elements within this distance of a cut are shared.
    pub side: f64,
}

/// Returns the boxes for `workers` workers.
///
/// # Errors
/// A worker was lost.
pub fn bisect(
    load: &mut dyn Load,
    workers: usize,
    before: Before<'_>,
) -> Result<CutTree, RankLost> {
    let mut tree = CutTree::single();
    // Leaf entry, first worker, number of workers.
    let mut open = vec![(0usize, 0usize, workers)];
    loop {
        open.retain(|o| o.2 > 1);
        if open.is_empty() {
            return Ok(tree);
        }
        let entries: Vec<usize> = open.iter().map(|o| o.0).collect();
        let extents = load.extents(&tree, &entries)?;
        let mut cuts: Vec<Vec<CutCandidate>> = vec![Vec::new(); open.len()];
        for rank in 0..3 {
            let is_asked = |i: &usize| {
                let tried = &cuts[*i];
                let has_contact = tried.iter().any(|c| c.has_contact);
                let is_uneven = tried.iter().all(|c| c.excess > UNEVEN);
                rank == 0 || has_contact || (is_uneven && is_long(&extents[*i], rank))
            };
            let asked: Vec<usize> = (0..open.len()).filter(is_asked).collect();
            if asked.is_empty() {
                break;
            }
            let range = |&i: &usize| {
                let (b, axis) = (&extents[i], by_length(&extents[i])[rank]);
                if b.is_empty() {
                    (entries[i], 0, 0.0, 0.0)
                } else {
                    (entries[i], axis, b.min[axis], b.max[axis])
                }
            };
            let ranges: Vec<_> = asked.iter().map(range).collect();
            let histograms = load.histograms(&tree, &ranges, BINS)?;
            for ((&i, range), histogram) in asked.iter().zip(&ranges).zip(&histograms) {
                let (_, _, count) = open[i];
                let fraction = (count / 2) as f64 / count as f64;
                cuts[i].push(CutCandidate::new(histogram, fraction, range, before.side));
            }
        }
        let mut next = Vec::new();
        for (&(entry, first, count), candidates) in open.iter().zip(&cuts) {
            let last = before.tree.and_then(|tree| tree.entries.get(entry));
            let Some(CutCandidate { axis, at, .. }) = best(candidates, last) else { continue };
            let (axis, at) = (*axis, *at);
            let lower = count / 2;
            let below = tree.entries.len();
            tree.entries.extend([Cut::Leaf(first), Cut::Leaf(first + lower)]);
            tree.entries[entry] = Cut::Plane { axis, at, below, above: below + 1 };
            next.extend([(below, first, lower), (below + 1, first + lower, count - lower)]);
        }
        open = next;
    }
}

/// A cut of a box.
#[derive(Clone)]
struct CutCandidate {
    axis: usize,
    /// Coordinate [length].
    at: f64,
    /// Time of a step with this cut over that with even loads, minus 1.
    excess: f64,
    /// Share of the load in elements that are shared because of the cut.
    shared: f64,
    /// True if the box has a load of contact.
    has_contact: bool,
}

impl CutCandidate {
    /// Computes the best cut along the axis of a histogram. The lower side gets `fraction` (at most
    /// 0.5) of the workers. `side` is the usual side of an element [length].
    fn new(
        histogram: &[StepLoads],
        fraction: f64,
        &(_, axis, lo, hi): &super::HistogramRange,
        side: f64,
    ) -> Self {
        let (edge, excess) = place(histogram, fraction);
        let bins = histogram.len();
        let width = (hi - lo) / bins as f64;
        let layer = (side / width.max(f64::MIN_POSITIVE)).min(bins as f64) as usize;
        let near = &histogram[edge.saturating_sub(layer)..(edge + layer).min(bins)];
        let motion = |of: &[StepLoads]| of.iter().map(|l| l[0]).sum::<f64>();
        let all = motion(histogram);
        Self {
            axis,
            at: lo + (hi - lo) * (edge as f64 / bins as f64),
            excess,
            shared: if all > 0.0 { motion(near) / all } else { 0.0 },
            has_contact: histogram.iter().any(|l| l[1] > 0.0),
        }
    }
}

/// Returns the best of the cuts of a box, of which the first is across the longest extent. `last`
/// is the cut of this box in the last tree.
fn best<'a>(candidates: &'a [CutCandidate], last: Option<&Cut>) -> Option<&'a CutCandidate> {
    let axis = match last {
        Some(&Cut::Plane { axis, .. }) => Some(axis),
        _ => candidates.first().map(|c| c.axis),
    };
    let cost = |c: &CutCandidate| {
        let change = if Some(c.axis) == axis { 0.0 } else { CLEAR_GAIN };
        c.excess + if c.has_contact { SHARED_COST * c.shared + change } else { 0.0 }
    };
    candidates.iter().min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

/// Returns the axes, the one with the longest extent first.
fn by_length(b: &Aabb) -> [usize; 3] {
    let length = |c: usize| b.max[c] - b.min[c];
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &c| length(c).total_cmp(&length(a)).then(a.cmp(&c)));
    axes
}

/// Returns true if the axis with this index in [`by_length`] is long enough for a cut across it
/// where there is no contact.
fn is_long(b: &Aabb, rank: usize) -> bool {
    let axes = by_length(b);
    let length = |c: usize| b.max[c] - b.min[c];
    !b.is_empty() && length(axes[rank]) >= SHORTEST * length(axes[0])
}

/// Returns the bin edge of a histogram at which a cut takes the least time, and its
/// [`CutCandidate::excess`]. The lower side gets `fraction` (at most 0.5) of the workers. Of
/// equally good edges the middle one is taken, so that a cut through empty space has a distance
/// from both sides.
fn place(histogram: &[StepLoads], fraction: f64) -> (usize, f64) {
    let sum = |kind: usize| histogram.iter().map(|l| l[kind]).sum::<f64>();
    let all = [sum(0), sum(1)];
    let mut below = [0.0; 2];
    let largest = |below: [f64; 2]| {
        let of = |kind: usize| {
            f64::max(below[kind] / fraction, (all[kind] - below[kind]) / (1.0 - fraction))
        };
        of(0) + of(1)
    };
    let times: Vec<f64> = std::iter::once(largest([0.0; 2]))
        .chain(histogram.iter().map(|l| {
            below = [below[0] + l[0], below[1] + l[1]];
            largest(below)
        }))
        .collect();
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    let nearest: Vec<usize> = (0..times.len()).filter(|&i| times[i] == least).collect();
    let even = all[0] + all[1];
    let excess = if even > 0.0 { least / even - 1.0 } else { 0.0 };
    (nearest[nearest.len() / 2], excess)
}

#[cfg(test)]
mod tests {
    use super::super::{Centres, ElementLoads, drifted};
    use super::*;

    fn beam(n: usize) -> Vec<[f64; 3]> {
        (0..n).map(|i| [i as f64, (i % 7) as f64, (i % 3) as f64]).collect()
    }

    #[test]
    fn any_number_of_workers_gets_equal_shares() {
        let centres = beam(2100);
        for workers in 1..=9 {
            let tree = bisect(&mut Centres(centres.clone()), workers, Before::default()).unwrap();
            let mut shares = vec![0; workers];
            centres.iter().for_each(|&c| shares[tree.worker_of(c)] += 1);
            let (even, worst) = (2100.0 / workers as f64, *shares.iter().max().unwrap() as f64);
            assert!(worst <= 1.03 * even, "{workers}: {shares:?}, a bin is 1/512 of the extent");
        }
    }

    /// A square tube that is longer across the walls parallel to the cut than otherwise. Such a
    /// wall is on one side as a whole.
    #[test]
    fn a_wall_along_the_cut_is_divided_along_another_axis() {
        let on = |i: usize, n: usize, length: f64| (i % n) as f64 / (n - 1) as f64 * length;
        let wall =
            |k: usize| [on(k, 40, 90.0), if k < 2000 { 0.0 } else { 100.0 }, on(k / 40, 50, 60.0)];
        let centres: Vec<_> = (0..3000).map(wall).collect();
        let tree = bisect(&mut Centres(centres.clone()), 2, Before::default()).unwrap();
        let below = centres.iter().filter(|&&c| tree.worker_of(c) == 0).count();
        assert!(
            (1470..=1530).contains(&below),
            "two thirds are at y = 0, a row of 50 or 75 cannot be divided: {below}"
        );
    }

    /// A frame of two rails of 100 by 10 elements, each element with load 1. Elements whose x is
    /// below `crushed` also have a contact load of 4.
    fn frame(crushed: f64) -> Vec<([f64; 3], StepLoads)> {
        let place = |i: usize| {
            let (x, rail, row) = (i % 100, i / 100 % 2, i / 200);
            [x as f64, 40.0 * rail as f64 + 0.1 * row as f64, 0.1 * row as f64]
        };
        let load = |x: f64| [1.0, if x < crushed { 4.0 } else { 0.0 }];
        (0..2000).map(place).map(|p| (p, load(p[0]))).collect()
    }

    fn shares(frame: &[([f64; 3], StepLoads)], tree: &CutTree) -> Vec<StepLoads> {
        let mut of = vec![[0.0; 2]; tree.workers()];
        for &(p, load) in frame {
            let share = &mut of[tree.worker_of(p)];
            (0..2).for_each(|kind| share[kind] += load[kind]);
        }
        of
    }

    /// No plane across the rails divides elements and contact at once. A plane between the rails
    /// does.
    #[test]
    fn contact_and_the_rest_are_divided_each_for_itself() {
        let side = 1.0;
        let cut = |crushed, workers, tree: Option<&CutTree>| {
            let loads = frame(crushed);
            let tree =
                bisect(&mut ElementLoads(loads.clone()), workers, Before { tree, side }).unwrap();
            (shares(&loads, &tree), tree)
        };
        let (without, across) = cut(0.0, 2, None);
        assert_eq!((without, axis(&across)), (vec![[1000.0, 0.0]; 2], 0));
        let (even, along) = cut(10.0, 2, Some(&across));
        assert_eq!((even, axis(&along)), (vec![[1000.0, 400.0]; 2], 1));
        // Contact everywhere: each axis is as good as any, and the last one stays.
        for last in [&across, &along] {
            let (even, tree) = cut(100.0, 2, Some(last));
            assert_eq!((even, axis(&tree)), (vec![[1000.0, 4000.0]; 2], axis(last)));
        }
        // Two of four workers have the crushed ends, and as many elements as the others: with
        // fewer elements they would wait for the others.
        let (four, _) = cut(10.0, 4, Some(&across));
        let ends = four.iter().filter(|s| s[1] == 400.0).count();
        assert_eq!((ends, four.iter().map(|s| s[0]).fold(0.0, f64::max)), (2, 500.0), "{four:?}");
    }

    fn axis(tree: &CutTree) -> usize {
        match tree.entries[0] {
            Cut::Plane { axis, .. } => axis,
            Cut::Leaf(_) => panic!("one worker"),
        }
    }

    #[test]
    fn planes_drift_with_their_content_and_still_tile() {
        let tree = bisect(&mut Centres(beam(400)), 4, Before::default()).unwrap();
        let moved = drifted(&tree, &[[5.0, 0.0, 0.0]; 4], &[100; 4]);
        for c in beam(400) {
            assert_eq!(tree.worker_of(c), moved.worker_of([c[0] + 5.0, c[1], c[2]]));
        }
    }
}
