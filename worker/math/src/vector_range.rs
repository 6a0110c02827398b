//! Range of a set of vectors by component.

use crate::lanes::{Lane, Real};
use crate::threads;

/// Smallest and largest component of all vectors in a set, for each direction.
#[derive(Clone, Copy, Debug)]
pub struct VectorRange {
    low: Lane,
    high: Lane,
}

impl Default for VectorRange {
    /// Returns the range of the empty set.
    #[inline]
    fn default() -> Self {
        Self { low: Lane::splat(f64::INFINITY), high: Lane::splat(f64::NEG_INFINITY) }
    }
}

impl VectorRange {
    /// Returns the range of the `count` vectors that `at` returns.
    #[inline]
    pub fn from_vectors(count: usize, mut at: impl FnMut(usize) -> Lane) -> Self {
        /// Number of ranges that are kept apart: each comparison waits for the last one of its
        /// range.
        const APART: usize = 4;
        let mut ranges = [Self::default(); APART];
        let whole = count - count % APART;
        for i in (0..whole).step_by(APART) {
            ranges.iter_mut().zip(i..).for_each(|(range, i)| range.include(at(i)));
        }
        (whole..count).for_each(|i| ranges[0].include(at(i)));
        let [a, b, c, d] = ranges;
        a.joined(&b).joined(&c.joined(&d))
    }

    /// Returns the range of the `count` vectors that `at` returns; threads share them.
    pub fn side_by_side(count: usize, at: impl Fn(usize) -> Lane + Sync) -> Self {
        /// Least number of vectors that a thread compares at a time.
        const PIECE: usize = 2048;
        let of_piece = |piece: std::ops::Range<usize>| {
            Self::from_vectors(piece.len(), |i| at(piece.start + i))
        };
        Self::of_all(threads::map(threads::ranges(count, PIECE), of_piece))
    }

    /// Adds a vector. Components that are not a number are left out: the step that computed them
    /// ends the run.
    #[inline]
    pub fn include(&mut self, v: Lane) {
        (self.low, self.high) = (Real::min(v, self.low), Real::max(v, self.high));
    }

    /// Returns the range of all sets together.
    pub fn of_all(sets: impl IntoIterator<Item = Self>) -> Self {
        sets.into_iter().fold(Self::default(), |all, set| all.joined(&set))
    }

    /// Returns the range of both sets.
    #[inline]
    fn joined(&self, other: &Self) -> Self {
        Self { low: Real::min(self.low, other.low), high: Real::max(self.high, other.high) }
    }

    /// Returns the smallest and the largest components; infinite for the empty set.
    #[inline]
    pub fn bounds(&self) -> [[f64; 4]; 2] {
        [self.low.to_array(), self.high.to_array()]
    }

    /// Returns an upper bound of the length of the difference of any two vectors in the set.
    #[inline]
    pub fn diameter(&self) -> f64 {
        let [low, high] = self.bounds();
        let size = |c: usize| (high[c] - low[c]).max(0.0);
        (size(0) * size(0) + size(1) * size(1) + size(2) * size(2)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_diameter_bounds_all_differences() {
        let vectors = |count: usize| {
            (0..count).map(|i| i as f64).map(|a| [a.sin(), 3.0 * (1.7 * a).cos(), 0.1 * a, 9.0 * a])
        };
        for count in [0, 1, 2, 3, 4, 5, 7, 30] {
            let all: Vec<[f64; 4]> = vectors(count).collect();
            let range = VectorRange::from_vectors(count, |i| Lane::new(all[i]));
            let [low, high] = range.bounds();
            for c in 0..4 {
                let column = || all.iter().map(|v| v[c]);
                assert_eq!(low[c], column().fold(f64::INFINITY, f64::min));
                assert_eq!(high[c], column().fold(f64::NEG_INFINITY, f64::max));
            }
            let apart = |a: &[f64; 4], b: &[f64; 4]| {
                (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
            };
            let most = all.iter().flat_map(|a| all.iter().map(|b| apart(a, b))).fold(0.0, f64::max);
            assert!(range.diameter() >= most && range.diameter() <= 3f64.sqrt() * most);
        }
    }
}
