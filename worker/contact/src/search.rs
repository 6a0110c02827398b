//! Global search: finds the points that lie in boxes. It does not depend on the decomposition
//! into workers.
//!
//! Two methods that must give the same result: linked cells (Wang, Cheng & Yao 2000), O(N), and
//! point in box by three one-dimensional sorts (Heinstein et al., PRONTO3D).

use crumple_math::lanes::{Lane, Real};
use crumple_math::row::row;
use crumple_math::threads;
use crumple_proto::boxes::Aabb;
use std::ops::Range;

/// An index of points, for a global search.
pub trait PointIndex: Sync {
    /// Calls `found` with the index of a box and the index of a point for each point in a closed
    /// box, boxes ascending. The first of `boxes` has the index `first`.
    fn find(&self, boxes: &[Aabb], first: u32, found: &mut dyn FnMut(u32, u32));
}

/// A global search: builds an index of points for these boxes.
pub type Search = for<'a> fn(boxes: &[Aabb], points: &'a [[f64; 3]]) -> Box<dyn PointIndex + 'a>;

/// A search method and its name.
pub struct Method {
    /// Name in the job.
    pub name: &'static str,
    /// The search.
    pub find: Search,
}

/// All search methods.
pub const SEARCHES: &[Method] = &[
    Method { name: "cells", find: LINKED_CELLS },
    Method { name: "boxes", find: |_, points| Box::new(SortedLists::new(points)) },
];

/// The search by linked cells.
pub const LINKED_CELLS: Search = |boxes, points| Box::new(LinkedCells::new(boxes, points));

/// Least number of boxes that a thread examines at a time.
const PIECE: usize = 256;

/// Returns the index of a box and the index of a point for each point in a closed box that
/// `accept` accepts, boxes ascending.
pub fn accepted(
    find: Search,
    boxes: &[Aabb],
    points: &[[f64; 3]],
    accept: impl Fn(u32, u32) -> bool + Sync,
) -> Vec<[u32; 2]> {
    let index = find(boxes, points);
    let of_range = |range: Range<usize>| {
        let (mut found, first) = (Vec::new(), range.start as u32);
        index.find(&boxes[range], first, &mut |b, p| {
            if accept(b, p) {
                found.push([b, p]);
            }
        });
        found
    };
    threads::joined(threads::map(threads::ranges(boxes.len(), PIECE), of_range))
}

/// Calls `found` with the index of a box and the index of a point for each point in a closed box,
/// boxes ascending. Uses linked cells.
pub fn linked_cells(boxes: &[Aabb], points: &[[f64; 3]], found: &mut dyn FnMut(u32, u32)) {
    LinkedCells::new(boxes, points).find(boxes, 0, found);
}

/// Points in the cells of a grid whose cell size is half the mean size of a box, or larger. Each
/// box examines the cells that it covers.
struct LinkedCells {
    bounds: Aabb,
    grid: Grid,
    /// Start of each cell in `members`, and their end.
    start: Vec<u32>,
    /// Points by cell, and their coordinates: cells of a line, and so their points, are read from
    /// consecutive memory.
    members: Vec<u32>,
    places: Vec<Lane>,
}

impl LinkedCells {
    fn new(boxes: &[Aabb], points: &[[f64; 3]]) -> Self {
        let bounds = Aabb::around(points.iter().copied());
        if boxes.is_empty() || bounds.is_empty() {
            let grid = Grid { origin: [0.0; 3], per_length: [0.0; 3], count: [1; 3] };
            let (start, members, places) = (Vec::new(), Vec::new(), Vec::new());
            return Self { bounds: Aabb::EMPTY, grid, start, members, places };
        }
        let grid = Grid::new(&bounds, boxes, points.len());
        let (start, members) = grid.fill(points);
        let place = |&p: &u32| Lane::new(row(points[p as usize]));
        let places = members.iter().map(place).collect();
        Self { bounds, grid, start, members, places }
    }
}

impl PointIndex for LinkedCells {
    fn find(&self, boxes: &[Aabb], first: u32, found: &mut dyn FnMut(u32, u32)) {
        let Self { bounds, grid, start, members, places } = self;
        let mut hits = vec![0; members.len()];
        for (b, bx) in (first..).zip(boxes) {
            let common = bx.intersection(bounds);
            if common.is_empty() {
                continue;
            }
            let (min, max) = (Lane::new(row(bx.min)), Lane::new(row(bx.max)));
            let (lo, hi) = (grid.place(common.min), grid.place(common.max));
            for k in lo[2]..=hi[2] {
                for j in lo[1]..=hi[1] {
                    let line = (k * grid.count[1] + j) * grid.count[0];
                    let cells = start[line + lo[0]] as usize..start[line + hi[0] + 1] as usize;
                    // About half of the points are inside: a branch for each would often be
                    // predicted wrong.
                    let mut count = 0;
                    for (&p, &at) in members[cells.clone()].iter().zip(&places[cells]) {
                        hits[count] = p;
                        count += usize::from((at.ge(min) & at.le(max)).all());
                    }
                    hits[..count].iter().for_each(|&p| found(b, p));
                }
            }
        }
    }
}

struct Grid {
    origin: [f64; 3],
    per_length: [f64; 3],
    count: [usize; 3],
}

impl Grid {
    fn new(bounds: &Aabb, boxes: &[Aabb], points: usize) -> Self {
        let size = |b: &Aabb| (0..3).map(|c| b.max[c] - b.min[c]).fold(0.0, f64::max);
        let cell = boxes.iter().map(size).sum::<f64>() / boxes.len() as f64;
        let mut grid = Self { origin: bounds.min, per_length: [0.0; 3], count: [1; 3] };
        // The number of cells is limited to a multiple of the number of points, even for thin
        // boxes.
        let mut cell = (0.5 * cell).max(f64::MIN_POSITIVE);
        loop {
            for c in 0..3 {
                grid.count[c] = (((bounds.max[c] - bounds.min[c]) / cell).min(1e6) as usize) + 1;
                grid.per_length[c] = 1.0 / cell;
            }
            // If coordinates are not finite, the step that computed them ends the run, and any
            // grid will do.
            let few =
                grid.count.iter().map(|&n| n as f64).product::<f64>() <= 8.0 * points as f64 + 64.0;
            if few || !cell.is_finite() {
                return grid;
            }
            cell *= 1.5;
        }
    }

    fn place(&self, p: [f64; 3]) -> [usize; 3] {
        std::array::from_fn(|c| {
            (((p[c] - self.origin[c]) * self.per_length[c]) as usize).min(self.count[c] - 1)
        })
    }

    /// Sorts points by cell (counting sort). Returns the start of each cell and the points by
    /// cell.
    fn fill(&self, points: &[[f64; 3]]) -> (Vec<u32>, Vec<u32>) {
        let cell = |p: &[f64; 3]| {
            let [i, j, k] = self.place(*p);
            (k * self.count[1] + j) * self.count[0] + i
        };
        let mut start = vec![0u32; self.count.iter().product::<usize>() + 1];
        points.iter().for_each(|p| start[cell(p) + 1] += 1);
        for i in 1..start.len() {
            start[i] += start[i - 1];
        }
        let mut next = start.clone();
        let mut members = vec![0u32; points.len()];
        for (i, p) in points.iter().enumerate() {
            let at = &mut next[cell(p)];
            members[*at as usize] = i as u32;
            *at += 1;
        }
        (start, members)
    }
}

/// Points sorted along each axis. A box selects the axis on which the fewest points lie within it,
/// and tests the other two axes.
struct SortedLists<'a> {
    points: &'a [[f64; 3]],
    sorted: [Vec<(f64, u32)>; 3],
}

impl<'a> SortedLists<'a> {
    fn new(points: &'a [[f64; 3]]) -> Self {
        let sorted = std::array::from_fn(|c| {
            let mut list: Vec<(f64, u32)> =
                points.iter().zip(0..).map(|(p, i)| (p[c], i)).collect();
            list.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            list
        });
        Self { points, sorted }
    }
}

impl PointIndex for SortedLists<'_> {
    fn find(&self, boxes: &[Aabb], first: u32, found: &mut dyn FnMut(u32, u32)) {
        let Self { points, sorted } = self;
        for (b, bx) in (first..).zip(boxes) {
            let within = |c: usize| {
                let from = sorted[c].partition_point(|p| p.0 < bx.min[c]);
                from..sorted[c].partition_point(|p| p.0 <= bx.max[c]).max(from)
            };
            let ranges: [_; 3] = std::array::from_fn(within);
            let fewest = (0..3).min_by_key(|&c| ranges[c].len()).unwrap_or(0);
            let inside = sorted[fewest][ranges[fewest].clone()]
                .iter()
                .filter(|p| bx.contains(points[p.1 as usize]));
            inside.for_each(|p| found(b, p.1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn brute(boxes: &[Aabb], points: &[[f64; 3]]) -> Vec<(u32, u32)> {
        let all = (0..boxes.len()).flat_map(|b| (0..points.len()).map(move |p| (b, p)));
        all.filter(|&(b, p)| boxes[b].contains(points[p]))
            .map(|(b, p)| (b as u32, p as u32))
            .collect()
    }

    /// Pieces of the boxes on several threads.
    #[test]
    fn several_threads_find_the_same_in_the_same_order() {
        let mut angle = 0.0_f64;
        let mut scattered = || {
            angle += 1.0;
            50.0 * (angle * angle).sin()
        };
        let mut point = || std::array::from_fn(|_| scattered());
        let points: Vec<[f64; 3]> = (0..2000).map(|_| point()).collect();
        let boxes: Vec<Aabb> = (0..3000).map(|_| Aabb::around([point()]).grown(6.0)).collect();
        let find = |threads: usize, method: Search| {
            let run = || {
                threads::start(threads).unwrap();
                accepted(method, &boxes, &points, |b, p| !(b + p).is_multiple_of(3))
            };
            std::thread::scope(|s| s.spawn(run).join().unwrap())
        };
        for method in SEARCHES {
            let alone = find(1, method.find);
            assert!(alone.len() > 1000, "{}", alone.len());
            assert!(find(3, method.find) == alone, "{}", method.name);
        }
    }

    proptest! {
        #[test]
        fn both_methods_find_what_looking_at_all_pairs_finds(
            points in prop::collection::vec(prop::array::uniform3(-50.0..50.0f64), 0..200),
            boxes in prop::collection::vec(
                (prop::array::uniform3(-60.0..60.0f64), prop::array::uniform3(0.0..30.0f64)),
                0..60,
            ),
            flat in any::<bool>(),
        ) {
            let points: Vec<[f64; 3]> =
                points.into_iter().map(|p| if flat { [p[0], p[1], 1.0] } else { p }).collect();
            let boxes: Vec<Aabb> = boxes
                .into_iter()
                .map(|(a, d)| Aabb { min: a, max: std::array::from_fn(|c| a[c] + d[c]) })
                .collect();
            let expected = brute(&boxes, &points);
            for method in SEARCHES {
                let all = accepted(method.find, &boxes, &points, |_, _| true);
                let mut found: Vec<(u32, u32)> = all.iter().map(|&[b, p]| (b, p)).collect();
                prop_assert!(found.is_sorted_by_key(|f| f.0), "{}", method.name);
                found.sort_unstable();
                prop_assert_eq!(&found, &expected, "{}", method.name);
            }
        }
    }
}
