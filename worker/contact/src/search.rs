//! Global search: finds the points that lie in boxes. It does not depend on the decomposition
//! into workers.
//!
//! Two methods that must give the same result: linked cells (Wang, Cheng & Yao 2000), O(N), and
//! point in box by three one-dimensional sorts (Heinstein et al., PRONTO3D).

use crumple_math::lanes::{Lane, Real};
use crumple_math::row::row;
use crumple_proto::boxes::Aabb;

/// A global search: calls `found` with the index of a box and the index of a point for each
/// point in a closed box, boxes ascending.
pub type Search = fn(boxes: &[Aabb], points: &[[f64; 3]], found: &mut dyn FnMut(u32, u32));

/// A search method and its name.
pub struct Method {
    /// Name in the job.
    pub name: &'static str,
    /// The search.
    pub find: Search,
}

/// All search methods.
pub const SEARCHES: &[Method] =
    &[Method { name: "cells", find: linked_cells }, Method { name: "boxes", find: sorted_lists }];

/// Assigns points to the cells of a grid whose cell size is half the mean size of a box, or
/// larger. Each box examines the cells that it covers.
pub fn linked_cells(boxes: &[Aabb], points: &[[f64; 3]], found: &mut dyn FnMut(u32, u32)) {
    let bounds = Aabb::around(points.iter().copied());
    if boxes.is_empty() || bounds.is_empty() {
        return;
    }
    let grid = Grid::new(&bounds, boxes, points.len());
    let (start, members) = grid.fill(points);
    // Cells of a line, and so their points, are read from consecutive memory.
    let place = |&p: &u32| Lane::new(row(points[p as usize]));
    let places: Vec<Lane> = members.iter().map(place).collect();
    let mut hits = vec![0; points.len()];
    for (b, bx) in boxes.iter().enumerate() {
        let common = bx.intersection(&bounds);
        if common.is_empty() {
            continue;
        }
        let (min, max) = (Lane::new(row(bx.min)), Lane::new(row(bx.max)));
        let (lo, hi) = (grid.place(common.min), grid.place(common.max));
        for k in lo[2]..=hi[2] {
            for j in lo[1]..=hi[1] {
                let line = (k * grid.count[1] + j) * grid.count[0];
                let cells = start[line + lo[0]] as usize..start[line + hi[0] + 1] as usize;
                // About half of the points are inside: a branch for each would often be predicted
                // wrong.
                let mut count = 0;
                for (&p, &at) in members[cells.clone()].iter().zip(&places[cells]) {
                    hits[count] = p;
                    count += usize::from((at.ge(min) & at.le(max)).all());
                }
                hits[..count].iter().for_each(|&p| found(b as u32, p));
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

/// Sorts points along each axis. A box selects the axis on which the fewest points lie within
/// it, and tests the other two axes.
pub fn sorted_lists(boxes: &[Aabb], points: &[[f64; 3]], found: &mut dyn FnMut(u32, u32)) {
    let sorted: [Vec<(f64, u32)>; 3] = std::array::from_fn(|c| {
        let mut list: Vec<(f64, u32)> =
            points.iter().enumerate().map(|(i, p)| (p[c], i as u32)).collect();
        list.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        list
    });
    for (b, bx) in boxes.iter().enumerate() {
        let within = |c: usize| {
            let from = sorted[c].partition_point(|p| p.0 < bx.min[c]);
            from..sorted[c].partition_point(|p| p.0 <= bx.max[c]).max(from)
        };
        let ranges: [_; 3] = std::array::from_fn(within);
        let fewest = (0..3).min_by_key(|&c| ranges[c].len()).unwrap_or(0);
        let inside = sorted[fewest][ranges[fewest].clone()]
            .iter()
            .filter(|p| bx.contains(points[p.1 as usize]));
        inside.for_each(|p| found(b as u32, p.1));
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
                let mut found = Vec::new();
                (method.find)(&boxes, &points, &mut |b, p| found.push((b, p)));
                prop_assert!(found.is_sorted_by_key(|f| f.0), "{}", method.name);
                found.sort_unstable();
                prop_assert_eq!(&found, &expected, "{}", method.name);
            }
        }
    }
}
