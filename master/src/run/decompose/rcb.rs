//! Recursive coordinate bisection (Berger & Bokhari 1987). Each cut is made across the longest
//! extent, so that the load of both sides is proportional to their numbers of workers. Any number
//! of workers is possible. All cuts of a level are made together.
//!
//! A plane cannot divide a flat wall that is parallel to it. If the cut across the longest extent
//! is uneven for this reason, the next longest extent is tried, unless it is so much shorter that
//! the cut would have a large area.

use super::Load;
use crumple_proto::boxes::{Aabb, Cut, CutTree};
use crumple_proto::transport::RankLost;

/// Number of bins of a histogram. The position of a cut is exact to this fraction of the extent.
const BINS: usize = 512;
/// Load on the wrong side, as a fraction, above which another axis is tried.
const UNEVEN: f64 = 0.01;
/// Shortest extent that is cut across, as a fraction of the longest.
const SHORTEST: f64 = 0.25;

/// Returns the boxes for `workers` workers.
///
/// # Errors
/// A worker was lost.
pub fn bisect(load: &mut dyn Load, workers: usize) -> Result<CutTree, RankLost> {
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
        let mut cuts: Vec<Option<CutCandidate>> = vec![None; open.len()];
        for rank in 0..3 {
            let fair = |i: usize| cuts[i].as_ref().is_some_and(|c| c.uneven <= UNEVEN);
            let asked: Vec<usize> = (0..open.len())
                .filter(|&i| !fair(i) && (rank == 0 || worth(&extents[i], rank)))
                .collect();
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
            for ((&i, &(_, axis, lo, hi)), histogram) in asked.iter().zip(&ranges).zip(&histograms)
            {
                let (_, _, count) = open[i];
                let (at, uneven) = place(histogram, (count / 2) as f64 / count as f64);
                if cuts[i].as_ref().is_none_or(|c| uneven < c.uneven) {
                    cuts[i] = Some(CutCandidate { axis, at: lo + (hi - lo) * at, uneven });
                }
            }
        }
        let mut next = Vec::new();
        for (&(entry, first, count), cut) in open.iter().zip(cuts) {
            let Some(CutCandidate { axis, at, .. }) = cut else { continue };
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
    /// Load on the wrong side, as a fraction of the load that the smaller side should have.
    uneven: f64,
}

/// Returns the axes, the one with the longest extent first.
fn by_length(b: &Aabb) -> [usize; 3] {
    let length = |c: usize| b.max[c] - b.min[c];
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &c| length(c).total_cmp(&length(a)).then(a.cmp(&c)));
    axes
}

/// Returns true if the axis with this index in [`by_length`] is long enough for a cut across it.
fn worth(b: &Aabb, rank: usize) -> bool {
    let axes = by_length(b);
    let length = |c: usize| b.max[c] - b.min[c];
    !b.is_empty() && length(axes[rank]) >= SHORTEST * length(axes[0])
}

/// Returns the position of a cut in a histogram, 0 to 1, and the load on the wrong side as a
/// fraction of the wanted load. The position is the bin edge at which the load below comes
/// nearest to `fraction` (at most 0.5) of the sum. Of equally good edges the middle one is taken,
/// so that a cut through empty space has a distance from both sides.
fn place(histogram: &[f64], fraction: f64) -> (f64, f64) {
    let wanted = fraction * histogram.iter().sum::<f64>();
    let mut below = 0.0;
    let off: Vec<f64> = std::iter::once(wanted)
        .chain(histogram.iter().map(|h| {
            below += h;
            (below - wanted).abs()
        }))
        .collect();
    let best = off.iter().copied().fold(f64::INFINITY, f64::min);
    let nearest: Vec<usize> = (0..off.len()).filter(|&i| off[i] == best).collect();
    let uneven = if wanted > 0.0 { best / wanted } else { 0.0 };
    (nearest[nearest.len() / 2] as f64 / histogram.len() as f64, uneven)
}

#[cfg(test)]
mod tests {
    use super::super::{Centres, drifted};
    use super::*;

    fn beam(n: usize) -> Vec<[f64; 3]> {
        (0..n).map(|i| [i as f64, (i % 7) as f64, (i % 3) as f64]).collect()
    }

    #[test]
    fn any_number_of_workers_gets_equal_shares() {
        let centres = beam(2100);
        for workers in 1..=9 {
            let tree = bisect(&mut Centres(centres.clone()), workers).unwrap();
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
        let tree = bisect(&mut Centres(centres.clone()), 2).unwrap();
        let below = centres.iter().filter(|&&c| tree.worker_of(c) == 0).count();
        assert!(
            (1470..=1530).contains(&below),
            "two thirds are at y = 0, a row of 50 or 75 cannot be divided: {below}"
        );
    }

    #[test]
    fn planes_drift_with_their_content_and_still_tile() {
        let tree = bisect(&mut Centres(beam(400)), 4).unwrap();
        let moved = drifted(&tree, &[[5.0, 0.0, 0.0]; 4], &[100; 4]);
        for c in beam(400) {
            assert_eq!(tree.worker_of(c), moved.worker_of([c[0] + 5.0, c[1], c[2]]));
        }
    }
}
