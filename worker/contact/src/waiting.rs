//! Candidates that wait: a candidate that is out of reach is left out until the nodes have moved
//! far enough against each other to bring it within reach.

use crumple_math::lanes::{LANES, Lane, Real};

/// Number of candidates that are passed over together while none of them is due.
const BLOCK: usize = 64;

/// For each candidate of a list the path of the nodes ([`Travel::path`]) up to which it is
/// certainly out of reach.
///
/// [`Travel::path`]: crate::travel::Travel::path
#[derive(Debug, Default)]
pub struct Waiting {
    /// The path of each candidate, infinite up to a whole number of lanes [length].
    until: Vec<f64>,
    /// Least path of each block of [`BLOCK`] candidates [length].
    least: Vec<f64>,
}

impl Waiting {
    /// Starts with `count` candidates; all of them are due.
    pub fn restart(&mut self, count: usize) {
        self.until.clear();
        self.until.resize(count, 0.0);
        self.until.resize(count.next_multiple_of(LANES), f64::INFINITY);
        self.least.clear();
        self.least.resize(count.div_ceil(BLOCK), 0.0);
    }

    /// Returns the bytes in use, without spare capacity.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.until[..]) + size_of_val(&self.least[..])
    }

    /// Replaces `due` by the indices of the candidates that are due at this path of the nodes
    /// [length], ascending. [`Self::close`] must follow, after those out of reach have been
    /// deferred.
    pub fn find_due(&mut self, path: f64, due: &mut Vec<u32>) {
        due.clear();
        let blocks = (0u32..).step_by(BLOCK).zip(self.until.chunks(BLOCK)).zip(&mut self.least);
        for ((first, of_block), least) in blocks.filter(|(_, least)| **least <= path) {
            let never = Lane::splat(f64::INFINITY);
            let (mut found, mut count, mut later) = ([0; BLOCK], 0, never);
            for (i, some) in (first..).step_by(LANES).zip(of_block.as_chunks().0) {
                let until = Lane::new(*some);
                let is_due = Real::le(until, Lane::splat(path));
                later = Real::min(Real::select(is_due, never, until), later);
                // No branch depends on whether a candidate is due, because it is hard to predict.
                let mask = is_due.to_bitmask();
                for lane in 0..LANES {
                    found[count] = i + lane as u32;
                    count += (mask >> lane & 1) as usize;
                }
            }
            due.extend_from_slice(&found[..count]);
            *least = later.to_array().into_iter().fold(f64::INFINITY, f64::min);
        }
    }

    /// Leaves out a candidate that was due until the nodes have this path [length].
    pub fn defer(&mut self, candidate: u32, until: f64) {
        self.until[candidate as usize] = until;
    }

    /// Updates the blocks of the candidates that were due.
    pub fn update_blocks(&mut self, due: &[u32]) {
        for &i in due {
            let (least, until) = (&mut self.least[i as usize / BLOCK], self.until[i as usize]);
            *least = if until < *least { until } else { *least };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_are_due_when_the_path_has_reached_theirs() {
        for count in [0, 1, 3, 4, 63, 64, 65, 200] {
            let mut waiting = Waiting::default();
            waiting.restart(count);
            let mut due = Vec::new();
            waiting.find_due(0.0, &mut due);
            assert_eq!(due, (0..count as u32).collect::<Vec<_>>(), "all are due at the start");
            // Every seventh candidate stays due, the others are due one after the other.
            let until = |i: u32| if i.is_multiple_of(7) { 0.0 } else { 1.0 + f64::from(i / 2) };
            due.iter().for_each(|&i| waiting.defer(i, until(i)));
            waiting.update_blocks(&due);
            for path in [0.5, 1.0, 1.5, 40.0, 40.5, 1e3] {
                waiting.find_due(path, &mut due);
                let expected: Vec<u32> = (0..count as u32).filter(|&i| until(i) <= path).collect();
                assert_eq!(due, expected, "{count} candidates at {path}");
                waiting.update_blocks(&due);
            }
        }
    }
}
