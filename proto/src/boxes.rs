//! Axis-aligned boxes, and the tree of cuts that divides space into one box per worker (Wang et
//! al. 2007, sec. 2.1).

use serde::{Deserialize, Serialize};

/// Axis-aligned box [length].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Aabb {
    /// Lower corner.
    pub min: [f64; 3],
    /// Upper corner.
    pub max: [f64; 3],
}

impl Aabb {
    /// Empty box, which contains no point.
    pub const EMPTY: Aabb = Aabb { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };
    /// Box that contains all space.
    pub const ALL: Aabb = Aabb { min: [f64::NEG_INFINITY; 3], max: [f64::INFINITY; 3] };

    /// Returns the smallest box around `points`.
    pub fn around(points: impl IntoIterator<Item = [f64; 3]>) -> Self {
        let mut b = Self::EMPTY;
        points.into_iter().for_each(|p| b.include(p));
        b
    }

    /// Extends the box to contain `p`.
    #[inline]
    pub fn include(&mut self, p: [f64; 3]) {
        for (c, &pc) in p.iter().enumerate() {
            self.min[c] = self.min[c].min(pc);
            self.max[c] = self.max[c].max(pc);
        }
    }

    /// Returns the box with every face moved outwards by `d` [length], or inwards if `d` is
    /// negative.
    #[inline]
    pub fn grown(&self, d: f64) -> Self {
        Self { min: self.min.map(|a| a - d), max: self.max.map(|a| a + d) }
    }

    /// Returns true if the closed boxes have a point in common.
    #[inline]
    pub fn intersects(&self, o: &Self) -> bool {
        (0..3).all(|c| self.min[c] <= o.max[c] && o.min[c] <= self.max[c])
    }

    /// Returns true if `p` lies in the closed box.
    #[inline]
    pub fn contains(&self, p: [f64; 3]) -> bool {
        (0..3).all(|c| self.min[c] <= p[c] && p[c] <= self.max[c])
    }

    /// Returns true if the box contains all of `o`.
    pub fn contains_box(&self, o: &Self) -> bool {
        (0..3).all(|c| self.min[c] <= o.min[c] && o.max[c] <= self.max[c])
    }

    /// Returns the intersection of both boxes, empty if they have no point in common.
    pub fn intersection(&self, o: &Self) -> Self {
        let mut b = *self;
        for c in 0..3 {
            b.min[c] = b.min[c].max(o.min[c]);
            b.max[c] = b.max[c].min(o.max[c]);
        }
        b
    }

    /// Returns true if the box contains no point.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|c| self.min[c] > self.max[c])
    }

    /// Returns the distance between the two boxes [length], 0 if they touch.
    pub fn distance(&self, o: &Self) -> f64 {
        let gaps = (0..3).map(|c| (o.min[c] - self.max[c]).max(self.min[c] - o.max[c]).max(0.0));
        gaps.map(|g| g * g).sum::<f64>().sqrt()
    }

    /// Returns the eight corners [length].
    pub fn corners(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|i| {
            std::array::from_fn(|c| if i >> c & 1 == 0 { self.min[c] } else { self.max[c] })
        })
    }
}

/// One entry of a [`CutTree`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cut {
    /// Plane; points below it along `axis` are in entry `below`.
    Plane {
        /// Axis normal to the plane: 0, 1 or 2.
        axis: usize,
        /// Coordinate of the plane [length].
        at: f64,
        /// Entry of the lower half.
        below: usize,
        /// Entry of the upper half.
        above: usize,
    },
    /// Box of this worker (0-based).
    Leaf(usize),
}

/// Recursive bisection of space. Entry 0 is the root.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CutTree {
    /// Entries; children follow their parent.
    pub entries: Vec<Cut>,
}

impl CutTree {
    /// Returns the tree that gives all space to one worker.
    pub fn single() -> Self {
        Self { entries: vec![Cut::Leaf(0)] }
    }

    /// Returns the leaf entry whose box contains `p`.
    pub fn entry_of(&self, p: [f64; 3]) -> usize {
        let mut i = 0;
        while let Cut::Plane { axis, at, below, above } = self.entries[i] {
            i = if p[axis] < at { below } else { above };
        }
        i
    }

    /// Returns the worker whose box contains `p`.
    pub fn worker_of(&self, p: [f64; 3]) -> usize {
        match self.entries[self.entry_of(p)] {
            Cut::Leaf(w) => w,
            Cut::Plane { .. } => unreachable!("entry_of gives a leaf"),
        }
    }

    /// Returns the number of workers.
    pub fn workers(&self) -> usize {
        self.entries.iter().filter(|e| matches!(e, Cut::Leaf(_))).count()
    }

    /// Returns the box of each worker; outer faces are at infinity.
    pub fn boxes(&self) -> Vec<Aabb> {
        let mut of_entry = vec![Aabb::ALL; self.entries.len()];
        let mut boxes = vec![Aabb::EMPTY; self.workers()];
        for (i, e) in self.entries.iter().enumerate() {
            match *e {
                Cut::Leaf(w) => boxes[w] = of_entry[i],
                Cut::Plane { axis, at, below, above } => {
                    (of_entry[below], of_entry[above]) = (of_entry[i], of_entry[i]);
                    of_entry[below].max[axis] = at;
                    of_entry[above].min[axis] = at;
                }
            }
        }
        boxes
    }

    /// Returns the workers below entry `i`, ascending.
    pub fn leaves(&self, i: usize) -> Vec<usize> {
        match self.entries[i] {
            Cut::Leaf(w) => vec![w],
            Cut::Plane { below, above, .. } => {
                let mut all = self.leaves(below);
                all.extend(self.leaves(above));
                all.sort_unstable();
                all
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_of_a_tree_tile_space_and_agree_with_worker_of() {
        let tree = CutTree {
            entries: vec![
                Cut::Plane { axis: 0, at: 1.0, below: 1, above: 2 },
                Cut::Leaf(0),
                Cut::Plane { axis: 2, at: -2.0, below: 3, above: 4 },
                Cut::Leaf(1),
                Cut::Leaf(2),
            ],
        };
        let boxes = tree.boxes();
        for p in [[0.0, 0.0, 0.0], [1.5, 9.0, -3.0], [7.0, -4.0, 2.0]] {
            let holders: Vec<usize> = (0..3).filter(|&w| boxes[w].contains(p)).collect();
            assert_eq!(holders, [tree.worker_of(p)], "{p:?}");
        }
        assert_eq!(tree.leaves(2), [1, 2]);
    }

    #[test]
    fn distance_of_boxes() {
        let a = Aabb { min: [0.0; 3], max: [1.0; 3] };
        let b = Aabb { min: [4.0, 0.5, 5.0], max: [5.0, 2.0, 6.0] };
        assert_eq!(a.distance(&b), 5.0);
        assert!(!a.intersects(&b) && a.grown(4.0).intersects(&b));
    }
}
