//! Nearest point of a segment (bilinear quad, triangle or line), and nearest points of two
//! edges.

use crate::kernels::{self, Projection, is_in, project};
use crumple_math::lanes::Real;
use crumple_math::row::V3;

/// Point of a segment that is nearest to a given point.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Shape values N_k of the point at the segment's four nodes (a triangle's fourth is 0);
    /// they sum to 1.
    pub shape: [f64; 4],
    /// The point [length].
    pub point: V3,
    /// Unit normal of the segment there, by the right-hand rule over its nodes.
    pub normal: V3,
    /// True if the nearest point lies on the rim.
    pub rim: bool,
}

impl Nearest {
    /// Returns the nearest point of a lane; `None` for a segment without area.
    pub fn from_lane<R: Real>(found: &Projection<R>, lane: usize) -> Option<Self> {
        let vector = |of: kernels::Vector<R>| V3::from(of.0.map(|c| c.lane(lane)));
        is_in::<R>(found.found, lane).then(|| Self {
            shape: found.shape.map(|n| n.lane(lane)),
            point: vector(found.point),
            normal: vector(found.normal),
            rim: is_in::<R>(found.rim, lane),
        })
    }
}

/// Computes the nearest point of segment `q` (its third node repeated for a triangle) to `p`.
/// Returns `None` for a segment without area.
pub fn nearest(p: &V3, q: &[V3; 4], triangle: bool) -> Option<Nearest> {
    Nearest::from_lane(&project((*p).into(), &q.map(Into::into), triangle), 0)
}

/// Computes the nearest point of a line between two ends to `p`. Its normal is the direction
/// from this point to `p`, around an end as along the line. If `p` is on the line, the normal is
/// any direction perpendicular to the line.
pub fn nearest_on_line(p: &V3, [from, to]: [&V3; 2]) -> Nearest {
    let along = to - from;
    let length2 = along.norm_squared();
    let s = if length2 > 0.0 { ((p - from).dot(&along) / length2).clamp(0.0, 1.0) } else { 0.0 };
    let point = from * (1.0 - s) + to * s;
    let normal = (p - point).try_normalize(0.0).unwrap_or_else(|| perpendicular_to(&along));
    Nearest { shape: [1.0 - s, s, 0.0, 0.0], point, normal, rim: true }
}

/// Returns a unit vector perpendicular to another one.
fn perpendicular_to(v: &V3) -> V3 {
    let least = (0..3).min_by(|&a, &b| v[a].abs().total_cmp(&v[b].abs())).unwrap_or(0);
    v.cross(&V3::ith(least, 1.0)).try_normalize(0.0).unwrap_or_else(V3::z)
}

/// A sphere around a segment, which lies within the hull of its corners; centre and radius in
/// [length].
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    centre: V3,
    radius: f64,
}

impl Sphere {
    /// Builds the sphere around a segment with corners `q`.
    pub fn around(q: &[V3; 4]) -> Self {
        let centre = (q[0] + q[1] + q[2] + q[3]) * 0.25;
        let radius = q.iter().map(|p| (p - centre).norm_squared()).fold(0.0, f64::max).sqrt();
        Self { centre, radius }
    }

    /// Returns its centre [length].
    pub fn centre(&self) -> V3 {
        self.centre
    }

    /// Returns its radius [length].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns true if another segment is certainly farther than `reach` from this one [length].
    pub fn are_separated(&self, other: &Self, reach: f64) -> bool {
        self.is_farther(&other.centre, reach + other.radius)
    }

    /// Returns true if a point is certainly farther than `reach` from the segment [length].
    pub fn is_farther(&self, at: &V3, reach: f64) -> bool {
        (at - self.centre).norm_squared() > (reach + self.radius) * (reach + self.radius)
    }
}

/// Sine of the angle between two edges below which they count as parallel. The points where
/// parallel edges are nearest to each other are ill conditioned, and contact of their ends is
/// equivalent.
const PARALLEL: f64 = 0.03;

/// Points of two edges that are nearest to each other, both between the ends.
#[derive(Clone, Copy, Debug)]
pub struct EdgeProjection {
    /// Positions of the points along either edge, above 0 and below 1.
    pub along: [f64; 2],
    /// Unit vector along the cross product of the edges.
    pub normal: V3,
    /// Distance of the first edge from the second along `normal` [length].
    pub height: f64,
}

/// Computes the points where edges `p` and `q`, given by their ends, are nearest to each other.
/// Returns `None` if one of the points is an end or if the edges are parallel.
pub fn project_edges(p: &[V3; 2], q: &[V3; 2]) -> Option<EdgeProjection> {
    let (u, w, apart) = (p[1] - p[0], q[1] - q[0], q[0] - p[0]);
    let cross = u.cross(&w);
    let size2 = cross.norm_squared();
    if size2 <= PARALLEL * PARALLEL * u.norm_squared() * w.norm_squared() {
        return None;
    }
    let along = [apart.cross(&w), apart.cross(&u)].map(|a| a.dot(&cross) / size2);
    let between = along.iter().all(|&a| a > 0.0 && a < 1.0);
    let normal = cross / size2.sqrt();
    between.then(|| EdgeProjection { along, normal, height: -apart.dot(&normal) })
}

/// Computes the square of the distance of two edges, ends included [length^2].
pub fn separation(p: &[V3; 2], q: &[V3; 2]) -> f64 {
    kernels::separation(&p.map(Into::into), &q.map(Into::into))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn where_edges_pass_is_the_nearest_of_many_points() {
        let p = [V3::new(0.0, 0.1, 0.3), V3::new(2.0, -0.2, 0.5)];
        let q = [V3::new(0.8, -1.0, -0.4), V3::new(1.3, 1.5, 0.1)];
        let at = |e: &[V3; 2], a: f64| e[0] + (e[1] - e[0]) * a;
        let found = project_edges(&p, &q).unwrap();
        let offset = at(&p, found.along[0]) - at(&q, found.along[1]);
        assert!(
            (offset - found.normal * found.height).norm() < 1e-15,
            "the offset is along the normal"
        );
        let grid =
            (0..=400).flat_map(|i| (0..=400).map(move |j| (i as f64 / 400.0, j as f64 / 400.0)));
        let best = grid.map(|(a, b)| (at(&p, a) - at(&q, b)).norm()).fold(f64::INFINITY, f64::min);
        assert!(
            offset.norm() <= best + 1e-15 && offset.norm() > best - 1e-4,
            "{}, on a grid {best}",
            offset.norm()
        );
        let back = project_edges(&q, &p).unwrap();
        assert!(
            (back.height - found.height).abs() < 1e-15
                && (back.normal + found.normal).norm() < 1e-15
        );
    }

    proptest! {
        /// The distance of two edges is that of the nearest of many points, at the ends or
        /// between.
        #[test]
        fn how_far_edges_are_apart_is_the_least_of_many(
            ends in prop::array::uniform4(prop::array::uniform3(-1.0..1.0f64)),
            parallel in any::<bool>(),
        ) {
            let [p, q, r, s] = ends.map(V3::from);
            let (one, other) = ([p, q], [r, if parallel { r + (q - p) * 0.7 } else { s }]);
            let found = separation(&one, &other).sqrt();
            let at = |e: &[V3; 2], a: usize| e[0] + (e[1] - e[0]) * (a as f64 / 100.0);
            let of = |(a, b): (usize, usize)| (at(&one, a) - at(&other, b)).norm();
            let best = (0..=100)
                .flat_map(|a| (0..=100).map(move |b| (a, b)))
                .map(of)
                .fold(f64::INFINITY, f64::min);
            // The grid's points are up to 0.035 apart.
            prop_assert!(found <= best + 1e-12 && found > best - 0.04, "{found}, on a grid {best}");
        }
    }

    #[test]
    fn edges_that_end_before_they_pass_or_run_side_by_side_do_not_pass() {
        let p = [V3::zeros(), V3::x()];
        let over = |x: f64, y: f64| [V3::new(x, y, 1.0), V3::new(x, y + 2.0, 1.0)];
        assert!(
            (project_edges(&p, &over(0.3, -0.5)).unwrap().height + 1.0).abs() < 1e-15,
            "along x cross y, it is below"
        );
        assert!(project_edges(&p, &over(1.1, -0.5)).is_none(), "beyond the end of the first");
        assert!(project_edges(&p, &over(0.3, 0.1)).is_none(), "before the start of the second");
        assert!(
            project_edges(&p, &[V3::z(), V3::new(1.0, 0.02, 1.0)]).is_none(),
            "parallel except for a slope of 0.02"
        );
        assert!(project_edges(&p, &[V3::z(), V3::z()]).is_none(), "no length");
    }

    /// Returns a point of a quad at a position in its plane.
    fn at(q: &[V3; 4], xi: f64, eta: f64) -> V3 {
        let side = |a: usize, b: usize| q[a] * (1.0 - xi) + q[b] * (1.0 + xi);
        (side(0, 1) * (1.0 - eta) + side(3, 2) * (1.0 + eta)) * 0.25
    }

    fn warped() -> [V3; 4] {
        [
            V3::new(0.0, 0.0, 0.2),
            V3::new(2.0, 0.1, -0.2),
            V3::new(2.2, 1.9, 0.3),
            V3::new(-0.1, 2.0, -0.1),
        ]
    }

    #[test]
    fn projection_on_a_warped_quad_is_the_nearest_of_many_points() {
        let q = warped();
        for p in [
            V3::new(1.0, 1.2, 0.8),
            V3::new(2.6, 1.0, 0.4),
            V3::new(-0.5, -0.7, 0.3),
            V3::new(0.3, 1.9, -0.9),
        ] {
            let found = nearest(&p, &q, false).unwrap();
            let grid = (0..=400).flat_map(|i| {
                (0..=400).map(move |j| (i as f64 / 200.0 - 1.0, j as f64 / 200.0 - 1.0))
            });
            let best =
                grid.map(|(xi, eta)| (at(&q, xi, eta) - p).norm()).fold(f64::INFINITY, f64::min);
            let d = (found.point - p).norm();
            assert!(d <= best + 1e-12 && d > best - 1e-4, "{d}, on a grid of 0.005 {best}");
            assert!((found.shape.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    /// Folded quads as in a crushed tube: a node 2.6 from the inside, 3.0 from the rim. Newton's
    /// method from the middle goes far out of the first quad. The second quad is the first a
    /// little later.
    #[test]
    fn a_nearest_point_inside_a_strongly_warped_quad_is_not_missed() {
        let first = [
            [30.154, -447.420, 120.686],
            [45.470, -456.271, 124.389],
            [36.194, -444.492, 150.504],
            [33.950, -443.0, 147.162],
        ];
        let second = [
            [30.036, -447.405, 120.687],
            [45.329, -456.315, 124.416],
            [36.018, -444.514, 150.518],
            [33.810, -443.005, 147.166],
        ];
        for (quad, p) in
            [(first, [40.962, -456.242, 125.619]), (second, [40.842, -456.281, 125.646])]
        {
            // The result does not depend on which corner comes first.
            for turn in 0..4 {
                let q: [V3; 4] = std::array::from_fn(|k| V3::from(quad[(k + turn) % 4]));
                let (p, found) = (V3::from(p), nearest(&V3::from(p), &q, false).unwrap());
                let grid = (0..=400).flat_map(|i| {
                    (0..=400).map(move |j| (i as f64 / 200.0 - 1.0, j as f64 / 200.0 - 1.0))
                });
                let best = grid
                    .map(|(xi, eta)| (at(&q, xi, eta) - p).norm())
                    .fold(f64::INFINITY, f64::min);
                let d = (found.point - p).norm();
                assert!(
                    !found.rim && d <= best + 1e-12 && d > best - 1e-3,
                    "turn {turn}: {d}, on a grid {best}"
                );
            }
        }
    }

    #[test]
    fn triangle_inside_edge_and_corner() {
        let q = [V3::zeros(), V3::x(), V3::y(), V3::y()];
        let n = nearest(&V3::new(0.25, 0.25, 3.0), &q, true).unwrap();
        assert!(!n.rim && (n.shape[0] - 0.5).abs() < 1e-15 && n.normal == V3::z());
        let n = nearest(&V3::new(0.5, -2.0, 0.0), &q, true).unwrap();
        assert!(n.rim && n.shape == [0.5, 0.5, 0.0, 0.0]);
        let n = nearest(&V3::new(-1.0, -2.0, 0.0), &q, true).unwrap();
        assert!(n.rim && n.shape == [1.0, 0.0, 0.0, 0.0]);
    }

    proptest! {
        /// No point of a segment on a grid is nearer than the computed point.
        #[test]
        fn what_is_found_is_the_nearest(
            corners in prop::array::uniform4(prop::array::uniform3(-0.2..0.2f64)),
            triangle in any::<bool>(),
            p in prop::array::uniform3(-0.7..1.7f64),
        ) {
            let square = [V3::zeros(), V3::x(), V3::new(1.0, 1.0, 0.0), V3::y()];
            let mut q: [V3; 4] = std::array::from_fn(|k| square[k] + V3::from(corners[k]));
            if triangle {
                q[3] = q[2];
            }
            let p = V3::from([p[0], p[1], 0.5 * p[2]]);
            let found = nearest(&p, &q, triangle).unwrap();
            let grid = (0..=40).flat_map(|i| {
                (0..=40).map(move |j| (f64::from(i) / 20.0 - 1.0, f64::from(j) / 20.0 - 1.0))
            });
            let best =
                grid.map(|(xi, eta)| (at(&q, xi, eta) - p).norm()).fold(f64::INFINITY, f64::min);
            let (d, sum) = ((found.point - p).norm(), found.shape.iter().sum::<f64>());
            prop_assert!(d <= best + 1e-12, "{d}, on the grid {best}");
            prop_assert!((sum - 1.0).abs() < 1e-12 && (found.normal.norm() - 1.0).abs() < 1e-12);
        }

        /// Candidates that the near list leaves out stay out of reach, or outside the border,
        /// while point and corners move by half the skin each.
        #[test]
        fn far_and_outside_points_stay_so_within_the_skin(
            corners in prop::array::uniform4(prop::array::uniform3(-0.2..0.2f64)),
            triangle in any::<bool>(),
            at in prop::array::uniform3(-2.5..2.5f64),
            moves in prop::array::uniform5(prop::array::uniform3(-1.0..1.0f64)),
            skin in 0.0..0.3f64,
            reach in 0.1..1.5f64,
        ) {
            let square = [V3::zeros(), V3::x(), V3::new(1.0, 1.0, 0.0), V3::y()];
            let mut q: [V3; 4] = std::array::from_fn(|k| square[k] + V3::from(corners[k]));
            if triangle {
                q[3] = q[2];
            }
            let at = V3::from(at);
            // The displacement is at most half the skin.
            let moved = |k: usize| V3::from(moves[k]) * (0.5 * skin / 3.0f64.sqrt());
            let (then, mut later) = (at + moved(4), q);
            (0..4).for_each(|k| later[k] += moved(if triangle { k.min(2) } else { k }));
            let Some(near) = nearest(&then, &later, triangle) else { return Ok(()) };
            let is_outside = |at: V3, q: &[V3; 4], skin| {
                kernels::projects_outside(at.into(), &q.map(Into::into), skin)
            };
            let is_apart = kernels::distance_bound(at.into(), &q.map(Into::into)) > reach + skin;
            if Sphere::around(&q).is_farther(&at, reach + skin) || is_apart {
                prop_assert!((then - near.point).norm() > reach);
            }
            if is_outside(at, &q, skin) {
                // The local search rejects both.
                prop_assert!(is_outside(then, &later, 0.0) || near.rim);
            }
            // A plane convex segment: a point outside its border projects onto its rim. Nothing
            // is stated about segments that are not convex or are warped that much.
            let flat = q.map(|p| V3::new(p.x, p.y, 0.0));
            if is_outside(at, &flat, 0.0) {
                prop_assert!(nearest(&at, &flat, triangle).is_none_or(|n| n.rim));
            }
        }
    }

    #[test]
    fn the_nearest_point_of_a_line_is_between_its_ends() {
        let (from, to) = (V3::new(1.0, 0.0, 0.0), V3::new(3.0, 0.0, 0.0));
        let near = |x: f64, y: f64| nearest_on_line(&V3::new(x, y, 0.0), [&from, &to]);
        assert_eq!(
            (near(1.5, -2.0).shape, near(1.5, -2.0).normal),
            ([0.75, 0.25, 0.0, 0.0], -V3::y())
        );
        assert_eq!(
            (near(4.0, 0.0).point, near(4.0, 0.0).normal),
            (to, V3::x()),
            "beyond an end the contact surface is a sphere"
        );
        let on = near(2.0, 0.0);
        assert!(on.normal.x == 0.0 && (on.normal.norm() - 1.0).abs() < 1e-15, "{}", on.normal);
        let point = nearest_on_line(&V3::z(), [&from, &from]);
        assert!(
            point.point == from && point.normal.dot(&V3::new(-1.0, 0.0, 1.0)) > 1.41,
            "no length"
        );
    }

    #[test]
    fn a_segment_without_area_has_no_nearest_point() {
        assert!(
            nearest(&V3::z(), &[V3::zeros(), V3::x(), V3::x() * 2.0, V3::x()], false).is_none()
        );
    }
}
