//! Recursive coordinate bisection (Berger & Bokhari 1987): cut across the longest extent so that both sides carry
//! load in proportion to the workers that they get. Any number of workers; all cuts of a level are made together.

use super::Load;
use crumple_proto::boxes::{Cut, CutTree};
use crumple_proto::transport::Lost;

/// Bins of a histogram: a cut is placed to this fraction of the extent.
const BINS: usize = 512;

/// Boxes for `workers` workers.
///
/// # Errors
/// A worker is gone.
pub fn bisect(load: &mut dyn Load, workers: usize) -> Result<CutTree, Lost> {
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
        let ranges: Vec<_> = entries
            .iter()
            .zip(&extents)
            .map(|(&entry, b)| {
                let length = |c: usize| b.max[c] - b.min[c];
                let axis = (0..3).max_by(|&a, &c| length(a).total_cmp(&length(c)).then(c.cmp(&a))).unwrap_or(0);
                if b.is_empty() { (entry, 0, 0.0, 0.0) } else { (entry, axis, b.min[axis], b.max[axis]) }
            })
            .collect();
        let histograms = load.histograms(&tree, &ranges, BINS)?;
        let mut next = Vec::new();
        for ((&(entry, first, count), &(_, axis, lo, hi)), histogram) in open.iter().zip(&ranges).zip(&histograms) {
            let lower = count / 2;
            let at = lo + (hi - lo) * place(histogram, lower as f64 / count as f64);
            let below = tree.entries.len();
            tree.entries.extend([Cut::Leaf(first), Cut::Leaf(first + lower)]);
            tree.entries[entry] = Cut::Plane { axis, at, below, above: below + 1 };
            next.extend([(below, first, lower), (below + 1, first + lower, count - lower)]);
        }
        open = next;
    }
}

/// Where along the histogram the given fraction of the load lies below: the bin edge that comes nearest, 0 to 1.
/// Among edges that are equally near, the middle one: a cut through empty space keeps off both sides.
fn place(histogram: &[f64], fraction: f64) -> f64 {
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
    nearest[nearest.len() / 2] as f64 / histogram.len() as f64
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

    #[test]
    fn planes_drift_with_their_content_and_still_tile() {
        let tree = bisect(&mut Centres(beam(400)), 4).unwrap();
        let moved = drifted(&tree, &[[5.0, 0.0, 0.0]; 4], &[100; 4]);
        for c in beam(400) {
            assert_eq!(tree.worker_of(c), moved.worker_of([c[0] + 5.0, c[1], c[2]]));
        }
    }
}
