//! Recursive coordinate bisection (Berger & Bokhari 1987). The load of both sides of a cut is
//! proportional to their numbers of workers, of which any is possible. All cuts of a level are made
//! together.
//!
//! Without contact, a cut is made across the longest extent. A plane cannot divide a flat wall that
//! is parallel to it. If the cut is uneven for this reason, the next longest extent is tried,
//! unless it is so much shorter that the cut would have a large area.
//!
//! Workers wait for each other before contact and after it. So each of these two loads of a step
//! has to be even, not their sum (Walshaw, Cross & McManus 2000, on meshes with several phases). A
//! cut makes the sum of the largest loads small. Where there is contact, it is tried along each
//! axis. Example: a frame is crushed at its front end. A plane across the frame leaves this end to
//! one side; a plane along the frame divides the end and the rest.

use super::Load;
use crumple_proto::boxes::{Aabb, Cut, CutTree};
use crumple_proto::report::StepLoads;
use crumple_proto::transport::RankLost;

/// Number of bins of a histogram. The position of a cut is exact to this fraction of the extent.
const BINS: usize = 512;
/// Imbalance above which another axis is tried where there is no contact, see
/// [`CutCandidate::imbalance`].
const UNEVEN: f64 = 1.01;
/// Shortest extent that is cut across where there is no contact, as a fraction of the longest.
const SHORTEST: f64 = 0.25;
/// Cost of an element that is copied because of a cut, over that of its own worker. Cuts along and
/// across `tube-crush`, `can-crush` and the jeep frame on two workers have the order of their wall
/// times with 0.5 and 0.6, not with 0.25 and 1 (`cases/bench/RESULTS.md`).
const COPY_COST: f64 = 0.6;
/// Imbalance by which another axis must be better than that of the last cut, or than the longest:
/// most elements would change their worker, and measured loads scatter by some percent.
const CLEAR_GAIN: f64 = 0.05;
/// Share of contact in the load of a box from which on its cut takes contact into account.
const NOTABLE: f64 = 0.01;

/// State before a decomposition, besides the load.
#[derive(Clone, Copy, Default)]
pub struct Before<'a> {
    /// Last boxes, if there are any. Their axes are kept unless others are clearly better.
    pub tree: Option<&'a CutTree>,
    /// Width of the buffer [length]. Elements within this distance of a cut are copied.
    pub buffer: f64,
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
    let same = before.tree.map(|_| 0);
    let mut open = vec![OpenBox { entry: 0, first: 0, count: workers, same }];
    loop {
        open.retain(|o| o.count > 1);
        if open.is_empty() {
            return Ok(tree);
        }
        let entries: Vec<usize> = open.iter().map(|o| o.entry).collect();
        let extents = load.extents(&tree, &entries)?;
        let mut cuts: Vec<Vec<CutCandidate>> = vec![Vec::new(); open.len()];
        for rank in 0..3 {
            let is_asked = |i: &usize| {
                let tried = &cuts[*i];
                let has_contact = tried.iter().any(|c| c.has_contact);
                let is_uneven = tried.iter().all(|c| c.imbalance > UNEVEN);
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
                let count = open[i].count;
                let fraction = (count / 2) as f64 / count as f64;
                cuts[i].push(CutCandidate::new(histogram, fraction, range, before.buffer));
            }
        }
        let mut next = Vec::new();
        for (&OpenBox { entry, first, count, same }, candidates) in open.iter().zip(&cuts) {
            // Axis and halves of the last cut of this box.
            let last = match same.and_then(|same| before.tree?.entries.get(same)) {
                Some(&Cut::Plane { axis, below, above, .. }) => Some((axis, [below, above])),
                _ => None,
            };
            let Some(&CutCandidate { axis, at, .. }) = best(candidates, last.map(|l| l.0)) else {
                continue;
            };
            // With another axis, the halves are other boxes than the last ones.
            let halves = last.filter(|l| l.0 == axis).map(|l| l.1);
            let lower = count / 2;
            let below = tree.entries.len();
            tree.entries.extend([Cut::Leaf(first), Cut::Leaf(first + lower)]);
            tree.entries[entry] = Cut::Plane { axis, at, below, above: below + 1 };
            for (k, first, count) in [(0, first, lower), (1, first + lower, count - lower)] {
                next.push(OpenBox { entry: below + k, first, count, same: halves.map(|h| h[k]) });
            }
        }
        open = next;
    }
}

/// A box that is not yet cut for all its workers.
struct OpenBox {
    /// Leaf entry in the growing tree.
    entry: usize,
    /// First worker, and number of workers.
    first: usize,
    count: usize,
    /// Entry of the same box in the last tree, if it has one.
    same: Option<usize>,
}

/// A cut of a box.
#[derive(Clone)]
struct CutCandidate {
    axis: usize,
    /// Coordinate [length].
    at: f64,
    /// Time of a step with this cut over that with even loads.
    imbalance: f64,
    /// Share of the elements, by load, that are copied because of the cut.
    copied: f64,
    /// True if contact has a notable load in the box.
    has_contact: bool,
}

impl CutCandidate {
    /// Computes the best cut along the axis of a histogram. The lower side gets `fraction` (at most
    /// 0.5) of the workers. `buffer` is the width of the buffer [length].
    fn new(
        histogram: &[StepLoads],
        fraction: f64,
        &(_, axis, lo, hi): &super::HistogramRange,
        buffer: f64,
    ) -> Self {
        let (edge, imbalance) = place(histogram, fraction);
        let bins = histogram.len();
        let width = (hi - lo) / bins as f64;
        let layer = (buffer / width.max(f64::MIN_POSITIVE)).ceil().min(bins as f64) as usize;
        let near = &histogram[edge.saturating_sub(layer)..(edge + layer).min(bins)];
        let sum = |of: &[StepLoads], kind: usize| of.iter().map(|l| l[kind]).sum::<f64>();
        let [elements, contact] = [0, 1].map(|kind| sum(histogram, kind));
        Self {
            axis,
            at: lo + (hi - lo) * (edge as f64 / bins as f64),
            imbalance,
            copied: if elements > 0.0 { sum(near, 0) / elements } else { 0.0 },
            has_contact: contact > NOTABLE * (elements + contact),
        }
    }
}

/// Returns the best of the cuts of a box, of which the first is across the longest extent.
/// `last_axis` is that of the last cut of this box.
fn best(candidates: &[CutCandidate], last_axis: Option<usize>) -> Option<&CutCandidate> {
    let kept = last_axis.or(candidates.first().map(|c| c.axis));
    let cost = |c: &CutCandidate| {
        let change = if Some(c.axis) == kept { 0.0 } else { CLEAR_GAIN };
        c.imbalance + if c.has_contact { COPY_COST * c.copied + change } else { 0.0 }
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
/// [`CutCandidate::imbalance`]. The lower side gets `fraction` (at most 0.5) of the workers. Of
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
    let equal: Vec<usize> = (0..times.len()).filter(|&i| times[i] == least).collect();
    let even = all[0] + all[1];
    (equal[equal.len() / 2], if even > 0.0 { least / even } else { 1.0 })
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
        let buffer = 1.0;
        let cut = |crushed, workers, tree: Option<&CutTree>| {
            let loads = frame(crushed);
            let before = Before { tree, buffer };
            let tree = bisect(&mut ElementLoads(loads.clone()), workers, before).unwrap();
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
        // Three workers: elements and contact of each are a third, except for a bin.
        let (three, _) = cut(100.0, 3, None);
        let most = three.iter().map(|s| s[0].max(s[1] / 4.0)).fold(0.0, f64::max);
        assert!(most <= 1.03 * 2000.0 / 3.0, "{three:?}");
    }

    /// A plane along a plate copies more elements than one across it, which does not pay if contact
    /// has a small load.
    #[test]
    fn copied_elements_count() {
        let plate = |contact: f64| -> Vec<_> {
            let place = |i: usize| [(i % 60) as f64, (i / 60) as f64, 0.0];
            let load = |x: f64| [1.0, if x < 6.0 { contact } else { 0.0 }];
            (0..2400).map(place).map(|p| (p, load(p[0]))).collect()
        };
        let axis_for = |contact: f64, buffer: f64| {
            let before = Before { tree: None, buffer };
            axis(&bisect(&mut ElementLoads(plate(contact)), 2, before).unwrap())
        };
        // With contact of 1 a step takes 9 % longer than with even loads if the plate is cut
        // across, with 4 it takes 29 %. A buffer of 8 copies 27 % of the elements across, 40 %
        // along.
        assert_eq!([axis_for(1.0, 8.0), axis_for(1.0, 0.1), axis_for(4.0, 8.0)], [0, 1, 1]);
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
