//! Overlap of two segments, seen along a common normal: the area where one has penetrated the
//! other, the mean depth there, and the points of both segments where the force acts.
//!
//! As in mortar methods (Puso & Laursen 2004, sec. 3; Yang, Laursen & Meng 2005, sec. 4) both
//! segments are projected onto a plane and their outlines are clipped against each other.
//! Integrals are evaluated over the triangles of the remaining polygon, where the shape values
//! of both segments are smooth. Here the outlines are those of the quarters that belong to the
//! corners. The remaining polygon is clipped along the line g = 0, so that either all of a piece
//! presses or none of it.
//!
//! With a pressure of k per depth and area the nodal forces are `k int -g N_a da` on one side
//! and `k int -g N_b da` on the other. Their sum is a force of `k A d`, with the area A and the
//! mean depth d, distributed by `int g N da / int g da`. This distribution places the force at
//! points of the two sides that lie above each other, so it has no moment. Uniform pressure
//! gives the nodal forces of uniform pressure on both sides, whatever the meshes, as the patch
//! test requires.
use crumple_math::row::V3;
use nalgebra::Vector2;

type V2 = Vector2<f64>;

/// Largest number of corners of the intersection of two quarters, clipped once more.
const MOST: usize = 12;
/// Smallest intersection as a fraction of a quarter's area. A smaller one is round-off where
/// meshes match, and it is left out.
const SLIVER: f64 = 1e-6;
/// Points and weights of a triangle, exact to the degree of four (Dunavant 1985, table II).
const POINTS: [([f64; 3], f64); 6] = {
    const A: f64 = 0.4459484909159649;
    const B: f64 = 0.09157621350977074;
    const W: f64 = 0.22338158967801147;
    const V: f64 = 0.10995174365532187;
    [
        ([1.0 - 2.0 * A, A, A], W),
        ([A, 1.0 - 2.0 * A, A], W),
        ([A, A, 1.0 - 2.0 * A], W),
        ([1.0 - 2.0 * B, B, B], V),
        ([B, 1.0 - 2.0 * B, B], V),
        ([B, B, 1.0 - 2.0 * B], V),
    ]
};

/// Overlap of two quarters.
#[derive(Clone, Copy, Debug)]
pub struct Overlap {
    /// Area where one is in the other, 0 if there is none [length^2].
    pub area: f64,
    /// Mean gap in this area, or the smallest gap if there is no such area [length].
    pub gap: f64,
    /// Shape values of either segment where the force acts.
    pub shape: [[f64; 4]; 2],
}

/// A plane onto which segments are projected.
pub struct Plane {
    origin: V3,
    /// Two directions in the plane, and its normal.
    axes: [V3; 3],
}

impl Plane {
    /// Builds the plane perpendicular to a unit vector.
    pub fn perpendicular(normal: V3, origin: V3) -> Self {
        // Any direction that is not the normal's own.
        let least =
            (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
        let along = normal.cross(&V3::ith(least, 1.0)).normalize();
        Self { origin, axes: [along, normal.cross(&along), normal] }
    }
}

/// A convex outline, counter-clockwise.
#[derive(Clone, Copy)]
struct Outline {
    corners: [V2; MOST],
    count: usize,
}

impl Outline {
    fn new(corners: &[V2]) -> Self {
        let mut outline = Self { corners: [V2::zeros(); MOST], count: 0 };
        corners.iter().for_each(|&c| outline.push(c));
        outline
    }

    /// Appends a corner. A corner for which there is no space is left out: it is round-off
    /// between edges that lie on each other.
    fn push(&mut self, corner: V2) {
        if self.count < MOST {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    fn corners(&self) -> &[V2] {
        &self.corners[..self.count]
    }

    fn area(&self) -> f64 {
        let c = self.corners();
        0.5 * (2..c.len()).map(|i| (c[i - 1] - c[0]).perp(&(c[i] - c[0]))).sum::<f64>()
    }

    /// Returns the part where a function is at most zero. The function is taken as linear along
    /// the edges.
    fn clipped(&self, of: impl Fn(&V2) -> f64) -> Self {
        let mut left = Self { count: 0, ..*self };
        let c = self.corners();
        let values: [f64; MOST] =
            std::array::from_fn(|i| if i < c.len() { of(&c[i]) } else { 0.0 });
        for i in 0..c.len() {
            let next = (i + 1) % c.len();
            let (here, there) = (values[i], values[next]);
            if here <= 0.0 {
                left.push(c[i]);
            }
            if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
                left.push(c[i] + (c[next] - c[i]) * (here / (here - there)));
            }
        }
        left
    }

    /// Returns the intersection with another outline.
    fn intersection(&self, other: &Self) -> Self {
        let c = other.corners();
        (0..c.len()).fold(*self, |left, i| {
            let (from, along) = (c[i], c[(i + 1) % c.len()] - c[i]);
            left.clipped(|p| -along.perp(&(p - from)))
        })
    }
}

/// A segment on a plane.
pub struct ProjectedSegment {
    /// Corners on the plane, and their heights above it [length].
    corners: [V2; 4],
    heights: [f64; 4],
    triangle: bool,
    /// Outlines of the quarters, by corner; `None` for a quarter that is not convex.
    quarters: [Option<Outline>; 4],
    /// Lowest and highest coordinates [length].
    low: V2,
    high: V2,
}

impl ProjectedSegment {
    /// Projects a segment with corners `q` onto a plane; `None` if the projection has no area.
    pub fn on(plane: &Plane, q: &[V3; 4], triangle: bool) -> Option<Self> {
        let [e, f, n] = &plane.axes;
        let offsets = q.map(|p| p - plane.origin);
        let corners = offsets.map(|o| V2::new(o.dot(e), o.dot(f)));
        let turn = (corners[2] - corners[0]).perp(&(corners[3] - corners[1]));
        let turn = if triangle {
            (corners[1] - corners[0]).perp(&(corners[2] - corners[0]))
        } else {
            turn
        };
        if turn == 0.0 {
            return None;
        }
        let count = if triangle { 3 } else { 4 };
        let middle = corners[..count].iter().sum::<V2>() / count as f64;
        let half = |a: usize, b: usize| (corners[a] + corners[b]) * 0.5;
        let quarter = |k: usize| {
            let (before, after) = ((k + count - 1) % count, (k + 1) % count);
            let mut c = [corners[k], half(k, after), middle, half(before, k)];
            if turn < 0.0 {
                c.swap(1, 3);
            }
            let is_convex = (0..4)
                .all(|i| (c[(i + 1) % 4] - c[i]).perp(&(c[(i + 2) % 4] - c[(i + 1) % 4])) > 0.0);
            (k < count && is_convex).then(|| Outline::new(&c))
        };
        let quarters = [0, 1, 2, 3].map(quarter);
        let (low, high) =
            corners.iter().fold((corners[0], corners[0]), |(l, h), c| (l.inf(c), h.sup(c)));
        Some(Self { corners, heights: offsets.map(|o| o.dot(n)), triangle, quarters, low, high })
    }

    /// Computes the shape values at a point of the plane.
    fn shape(&self, at: &V2) -> [f64; 4] {
        const MOST_STEPS: usize = 12;
        let q = &self.corners;
        if self.triangle {
            let (u, w, p) = (q[1] - q[0], q[2] - q[0], at - q[0]);
            let [b, c] = [p.perp(&w), u.perp(&p)].map(|part| part / u.perp(&w));
            return [1.0 - b - c, b, c, 0.0];
        }
        let (mean, by_x) = ((q[0] + q[1] + q[2] + q[3]) * 0.25, (q[1] + q[2] - q[0] - q[3]) * 0.25);
        let (by_y, twist) =
            ((q[2] + q[3] - q[0] - q[1]) * 0.25, (q[0] + q[2] - q[1] - q[3]) * 0.25);
        let (mut x, mut y) = (0.0, 0.0);
        for _ in 0..MOST_STEPS {
            let left = at - (mean + by_x * x + by_y * y + twist * (x * y));
            let (along, across) = (by_x + twist * y, by_y + twist * x);
            let size = along.perp(&across);
            if size == 0.0 {
                break;
            }
            let (dx, dy) = (left.perp(&across) / size, along.perp(&left) / size);
            (x, y) = (x + dx, y + dy);
            // The error that remains is of the order of the square of the step.
            if dx.abs() + dy.abs() < 1e-9 {
                break;
            }
        }
        [(1.0 - x) * (1.0 - y), (1.0 + x) * (1.0 - y), (1.0 + x) * (1.0 + y), (1.0 - x) * (1.0 + y)]
            .map(|n| 0.25 * n)
    }

    fn height(&self, shape: &[f64; 4]) -> f64 {
        (0..4).map(|k| shape[k] * self.heights[k]).sum()
    }

    /// Calls `found` with the overlap of each quarter of this segment and each quarter of a
    /// segment below it, in ascending order. The segments touch at the distance `thickness`
    /// [length].
    pub fn gap_at(&self, below: &Self, thickness: f64, mut found: impl FnMut([usize; 2], Overlap)) {
        if self.low.x >= below.high.x
            || below.low.x >= self.high.x
            || self.low.y >= below.high.y
            || below.low.y >= self.high.y
        {
            return;
        }
        for (i, one) in self.quarters.iter().enumerate() {
            let Some(one) = one else { continue };
            let left = (0..4).filter_map(|j| Some((j, below.quarters[j].as_ref()?)));
            for (j, other) in left {
                let common = one.intersection(other);
                if common.count > 2 && common.area() > SLIVER * one.area().min(other.area()) {
                    found([i, j], self.pressed_area(below, &common, thickness));
                }
            }
        }
    }

    /// Computes the overlap with another segment within an outline.
    fn pressed_area(&self, below: &Self, within: &Outline, thickness: f64) -> Overlap {
        let shapes = |p: &V2| [self.shape(p), below.shape(p)];
        let gap_of =
            |[ahead, behind]: &[[f64; 4]; 2]| self.height(ahead) - below.height(behind) - thickness;
        let gap = |p: &V2| gap_of(&shapes(p));
        let inside = within.clipped(gap);
        let (mut area, mut volume, mut sums) = (0.0, 0.0, [[0.0; 4]; 2]);
        if inside.count > 2 {
            inside.sum(|weight, p| {
                let shapes = shapes(p);
                let part = weight * (-gap_of(&shapes)).max(0.0);
                area += weight;
                volume += part;
                sums.iter_mut()
                    .zip(shapes)
                    .for_each(|(sums, n)| (0..4).for_each(|k| sums[k] += part * n[k]));
            });
        }
        if area > 0.0 && volume > 0.0 {
            return Overlap {
                area,
                gap: -volume / area,
                shape: sums.map(|s| s.map(|s| s / volume)),
            };
        }
        let mut whole = 0.0;
        within.sum(|weight, p| {
            whole += weight;
            let shapes = shapes(p);
            sums.iter_mut()
                .zip(shapes)
                .for_each(|(sums, n)| (0..4).for_each(|k| sums[k] += weight * n[k]));
        });
        let least = within.corners().iter().map(gap).fold(f64::INFINITY, f64::min);
        Overlap { area: 0.0, gap: least, shape: sums.map(|s| s.map(|s| s / whole)) }
    }
}

impl Outline {
    /// Calls `add` with each point of its triangles and the part of the area of this point.
    fn sum(&self, mut add: impl FnMut(f64, &V2)) {
        let c = self.corners();
        for i in 2..c.len() {
            let area = 0.5 * (c[i - 1] - c[0]).perp(&(c[i] - c[0]));
            POINTS
                .iter()
                .for_each(|([a, b, d], w)| add(w * area, &(c[0] * *a + c[i - 1] * *b + c[i] * *d)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(from: [f64; 2], side: f64, z: impl Fn(f64, f64) -> f64) -> [V3; 4] {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| {
            let (x, y) = (from[0] + side * x, from[1] + side * y);
            V3::new(x, y, z(x, y))
        })
    }

    fn all(above: &[V3; 4], below: &[V3; 4]) -> Vec<([usize; 2], Overlap)> {
        let plane = Plane::perpendicular(V3::z(), V3::zeros());
        let [one, two] =
            [above, below].map(|q| ProjectedSegment::on(&plane, q, q[2] == q[3]).unwrap());
        let mut found = Vec::new();
        one.gap_at(&two, 0.0, |quarters, overlap| found.push((quarters, overlap)));
        found
    }

    /// A square with a penetration of 0.1 over half of its length: area, depth and nodal forces
    /// are those of the integrals.
    #[test]
    fn uniform_depth_gives_the_nodal_forces_of_uniform_pressure() {
        let above = square([0.5, 0.0], 1.0, |_, _| -0.1);
        let below = square([0.0, 0.0], 1.0, |_, _| 0.0);
        let found = all(&above, &below);
        let area: f64 = found.iter().map(|f| f.1.area).sum();
        assert!((area - 0.5).abs() < 1e-14 && found.iter().all(|f| (f.1.gap + 0.1).abs() < 1e-14));
        let on = |side: usize, k: usize| {
            found.iter().map(|f| f.1.area * f.1.shape[side][k]).sum::<f64>()
        };
        // Over half of a square: int (1 - x) dx from 0 to 1/2 is 3/8, and 1/8 for x.
        for (side, expected) in [[3.0, 1.0, 1.0, 3.0], [1.0, 3.0, 3.0, 1.0]].into_iter().enumerate()
        {
            (0..4).for_each(|k| {
                assert!(
                    (on(side, k) - expected[k] / 16.0).abs() < 1e-14,
                    "{side} {k}: {}",
                    on(side, k)
                )
            });
        }
    }

    /// A tilted square that penetrates with its edge only: force and moment of the linear pressure
    /// over the penetrating part.
    #[test]
    fn what_is_tilted_presses_where_it_is_in() {
        let (slope, depth) = (0.5, 0.1);
        let above = square([0.0, 0.0], 1.0, |x, _| slope * x - depth);
        let below = square([-1.0, -1.0], 3.0, |_, _| 0.0);
        let found = all(&above, &below);
        let pressed = found.iter().filter(|f| f.1.area > 0.0);
        let force: f64 = pressed.clone().map(|f| f.1.area * -f.1.gap).sum();
        let at = |q: &[V3; 4], n: &[f64; 4]| (0..4).map(|k| q[k] * n[k]).sum::<V3>();
        let turn: f64 =
            pressed.clone().map(|f| f.1.area * -f.1.gap * at(&above, &f.1.shape[0]).x).sum();
        // A wedge of the length depth / slope: its volume, and its centre at a third of the
        // length.
        let length = depth / slope;
        assert!((force - 0.5 * depth * length).abs() < 1e-14, "{force}");
        assert!((turn / force - length / 3.0).abs() < 1e-14, "{turn}");
        for (_, f) in pressed {
            let off = at(&above, &f.shape[0]) - at(&below, &f.shape[1]);
            assert!(off.xy().norm() < 1e-14, "both forces act at one point: {off}");
        }
    }

    /// Shape values of a point on an irregular quad reproduce the point.
    #[test]
    fn shape_values_place_a_point() {
        let plane = Plane::perpendicular(V3::z(), V3::zeros());
        let q = [[0.0, 0.0], [1.2, 0.1], [0.9, 1.4], [-0.2, 0.8]].map(|[x, y]| V3::new(x, y, 0.0));
        for corners in [q, [q[0], q[1], q[2], q[2]]] {
            let laid = ProjectedSegment::on(&plane, &corners, corners[2] == corners[3]).unwrap();
            for at in [V2::new(0.3, 0.3), V2::new(0.7, 0.2)] {
                let at = V2::new(
                    at.x * plane.axes[0].x + at.y * plane.axes[0].y,
                    at.x * plane.axes[1].x + at.y * plane.axes[1].y,
                );
                let n = laid.shape(&at);
                let back: V2 = (0..4).map(|k| laid.corners[k] * n[k]).sum();
                assert!(
                    (back - at).norm() < 1e-14 && (n.iter().sum::<f64>() - 1.0).abs() < 1e-14,
                    "{n:?}"
                );
            }
        }
    }
}
