//! First touch of a moving point and a moving segment in a step: the time, the point of the
//! segment and its normal there.
//!
//! Attaway et al. (1998), "Detailed contact check", fig. 3: the velocity check solves for the time
//! at which a moving node meets a moving face, and for the point where it does. Point and corners
//! move at constant velocities. The bilinear face with the corners q_k(t) has the point p(t) where
//!
//! ```text
//! f(a, b, t) = sum_k N_k(a, b) q_k(t) - p(t) = 0 ,   0 <= a, b, t <= 1
//! ```
//!
//! f is linear in each of its variables. So over a box of (a, b, t) it is bounded by its values at
//! the eight corners of the box; Wang et al. (2021), ACM Trans. Graph. 40(5), sec. 4. A box is cut
//! down by these bounds after a multiplication with the inverse Jacobian at its centre (Krawczyk
//! 1969, Computing 4), and halved where that does not help. Earlier halves come first. The result
//! needs no start value, and no root is lost. It covers warped quads, faces that rotate, and
//! points that only graze the face, where the signed volume has a double root. A triangle is half
//! of a parallelogram; the roots of its signed volume are those of a cubic in time, against which
//! the tests compare.
//!
//! With a thickness the point touches where it is a distance d above the face along the normal n.
//! It is then the point p - d n that crosses the face. n is that of the touch, found by iteration.

use crumple_math::row::V3;
use nalgebra::Matrix3;

/// Motion of a point in a step, along a line at constant velocity.
#[derive(Clone, Copy, Debug)]
pub struct NodePath {
    /// Position at the start of the step [length].
    pub from: V3,
    /// Displacement in the step [length].
    pub by: V3,
}

/// First touch of a moving point and a moving segment.
#[derive(Clone, Copy, Debug)]
pub struct Impact {
    /// Time since the start of the step as a fraction of the step, from 0 to 1.
    pub time: f64,
    /// Shape values N_k of the point of the segment (a triangle's fourth is 0); they sum to 1.
    pub shape: [f64; 4],
    /// Unit normal of the segment at that time and point.
    pub normal: V3,
}

/// Width beyond the limits 0 and 1 within which a root still counts. So the common edge of two
/// segments belongs to both of them in spite of round-off.
const BORDER: f64 = 1e-12;
/// Round-off of f, as a fraction of the largest distance of a corner from the point.
const ROUND_OFF: f64 = 1e-15;
/// Width of a box that is a root.
const FINE: f64 = 1e-12;
/// Largest number of boxes. A transversal root needs about five, a double root some hundreds. A
/// point that moves within the face has a root at any time; the search stops at this number.
const BOXES: usize = 4000;
/// Sine of the angle between face and relative motion below which the Jacobian has no inverse.
const SINGULAR: f64 = 1e-12;

/// The function f of a point and a segment: position of a point of the face relative to the moving
/// point.
struct RelativeFace {
    /// At the start, by corner: (a, b) = (0, 0), (1, 0), (1, 1), (0, 1) [length].
    from: [V3; 4],
    /// Displacement in the step [length].
    by: [V3; 4],
    /// True for a triangle, the half with a + b <= 1.
    triangle: bool,
}

/// Box of (a, b, t).
#[derive(Clone, Copy)]
struct Region {
    low: [f64; 3],
    high: [f64; 3],
}

impl Region {
    fn centre(&self) -> [f64; 3] {
        std::array::from_fn(|i| 0.5 * (self.low[i] + self.high[i]))
    }

    fn corners(&self) -> [[f64; 3]; 8] {
        let side = |k: usize, i: usize| if k >> i & 1 == 0 { self.low[i] } else { self.high[i] };
        std::array::from_fn(|k| std::array::from_fn(|i| side(k, i)))
    }

    /// Returns its largest width and the variable of that width, time before place.
    fn widest(&self) -> (f64, usize) {
        let width = |i: usize| (self.high[i] - self.low[i], i);
        [width(1), width(0), width(2)]
            .into_iter()
            .fold((0.0, 2), |most, w| if w.0 >= most.0 { w } else { most })
    }

    /// Returns both halves, the lower one first.
    fn halves(&self) -> [Self; 2] {
        let (i, centre) = (self.widest().1, self.centre());
        let (mut lower, mut upper) = (*self, *self);
        (lower.high[i], upper.low[i]) = (centre[i], centre[i]);
        [lower, upper]
    }
}

impl RelativeFace {
    fn new(p: &NodePath, q: &[NodePath; 4], triangle: bool) -> Self {
        let (from, by) = (q.map(|c| c.from - p.from), q.map(|c| c.by - p.by));
        let fourth = |v: &[V3; 4]| [v[0], v[1], v[1] + (v[2] - v[0]), v[2]];
        let whole = |v: [V3; 4]| if triangle { fourth(&v) } else { v };
        Self { from: whole(from), by: whole(by), triangle }
    }

    /// Returns the largest distance of a corner from the point [length].
    fn size(&self) -> f64 {
        let square =
            |k: usize| self.from[k].norm_squared().max((self.from[k] + self.by[k]).norm_squared());
        (0..4).map(square).fold(0.0, f64::max).sqrt()
    }

    fn value(&self, [a, b, t]: [f64; 3]) -> V3 {
        let [p, q, r, s] = std::array::from_fn(|k| self.from[k] + self.by[k] * t);
        (p * (1.0 - a) + q * a) * (1.0 - b) + (s * (1.0 - a) + r * a) * b
    }

    /// Returns the derivatives along a, b and t [length].
    fn gradient(&self, [a, b, t]: [f64; 3]) -> [V3; 3] {
        let [p, q, r, s] = std::array::from_fn(|k| self.from[k] + self.by[k] * t);
        let [dp, dq, dr, ds] = self.by;
        [
            (q - p) * (1.0 - b) + (r - s) * b,
            (s - p) * (1.0 - a) + (r - q) * a,
            (dp * (1.0 - a) + dq * a) * (1.0 - b) + (ds * (1.0 - a) + dr * a) * b,
        ]
    }

    /// Returns the inverse Jacobian; `None` where it is singular [1/length].
    fn inverse(&self, at: [f64; 3]) -> Option<Matrix3<f64>> {
        let [along_a, along_b, along_t] = self.gradient(at);
        let most = along_a.norm() * along_b.norm() * along_t.norm();
        let volume = along_a.cross(&along_b).dot(&along_t);
        (volume.abs() > SINGULAR * most)
            .then(|| Matrix3::from_columns(&[along_a, along_b, along_t]).try_inverse())
            .flatten()
    }

    /// Returns the part of a region that can contain a root; `None` if it cannot contain one.
    /// `tolerance` is the round-off of f [length].
    fn narrowed(&self, region: &Region, tolerance: f64) -> Option<Region> {
        if self.triangle && region.low[0] + region.low[1] > 1.0 + BORDER {
            return None;
        }
        let (centre, corners) = (region.centre(), region.corners());
        let values = corners.map(|u| self.value(u));
        let Some(inverse) = self.inverse(centre) else {
            let [along_a, along_b, _] = self.gradient(centre);
            let normal = along_a.cross(&along_b).try_normalize(0.0);
            let is_apart = |d: V3| {
                let along = values.map(|v| v.dot(&d));
                along.iter().all(|&x| x > tolerance) || along.iter().all(|&x| x < -tolerance)
            };
            let directions = [V3::x(), V3::y(), V3::z()].into_iter().chain(normal);
            return (!directions.into_iter().any(is_apart)).then_some(*region);
        };
        let mut part = *region;
        let scaled = values.map(|v| inverse * v);
        for i in 0..3 {
            // u = centre - rest(u) at a root. The rest is linear in each variable, like f.
            let rest: [f64; 8] =
                std::array::from_fn(|k| scaled[k][i] - (corners[k][i] - centre[i]));
            let margin = inverse.row(i).abs().sum() * tolerance;
            let most = rest.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let least = rest.iter().copied().fold(f64::INFINITY, f64::min);
            part.low[i] = region.low[i].max(centre[i] - most - margin);
            part.high[i] = region.high[i].min(centre[i] - least + margin);
            if part.low[i] > part.high[i] {
                return None;
            }
        }
        Some(part)
    }

    /// Returns the root in a box of the width [`FINE`] or less.
    fn root_in(&self, region: &Region) -> Option<[f64; 3]> {
        let mut root = region.centre();
        if let Some(inverse) = self.inverse(root) {
            let step = inverse * self.value(root);
            (0..3).for_each(|i| root[i] -= step[i]);
        }
        let is_in = !self.triangle || root[0] + root[1] <= 1.0 + 2.0 * BORDER;
        is_in.then(|| root.map(|u| u.clamp(0.0, 1.0)))
    }

    /// Returns the root with the least time, as (a, b, t).
    fn first_root(&self) -> Option<[f64; 3]> {
        let tolerance = ROUND_OFF * self.size();
        let mut first: Option<[f64; 3]> = None;
        let mut later = Vec::new();
        let mut next = Some(Region { low: [-BORDER; 3], high: [1.0 + BORDER; 3] });
        for _ in 0..BOXES {
            let Some(region) = next.take().or_else(|| later.pop()) else { break };
            if first.is_some_and(|root| region.low[2] >= root[2]) {
                continue;
            }
            let Some(part) = self.narrowed(&region, tolerance) else { continue };
            let (width, _) = part.widest();
            if width <= FINE {
                let root = self.root_in(&part);
                first = [first, root].into_iter().flatten().min_by(|a, b| a[2].total_cmp(&b[2]));
            } else if width <= 0.5 * region.widest().0 {
                next = Some(part);
            } else {
                let [lower, upper] = part.halves();
                later.push(upper);
                next = Some(lower);
            }
        }
        first
    }
}

/// Returns the first time in a step at which point `p` lies on the segment with corners `q`, whose
/// fourth is ignored for a triangle. A touch at the start, at the end or on the border counts.
/// The accuracy is that of round-off; the time at which a point grazes the face has half as many
/// digits. A point that moves within the face has no defined time.
pub fn first_crossing(p: &NodePath, q: &[NodePath; 4], triangle: bool) -> Option<Impact> {
    let face = RelativeFace::new(p, q, triangle);
    let [a, b, time] = face.first_root()?;
    let [along_a, along_b, _] = face.gradient([a, b, time]);
    let shape = match triangle {
        true => [(1.0 - a - b).max(0.0), a, b, 0.0],
        false => [(1.0 - a) * (1.0 - b), a * (1.0 - b), a * b, (1.0 - a) * b],
    };
    Some(Impact { time, shape, normal: along_a.cross(&along_b).try_normalize(0.0)? })
}

/// Returns the first touch of point `p` at a distance from the segment. `normal` is a unit normal
/// on the side of the point, from which the iteration starts; `distance` returns the distance of
/// the touch along a normal [length]. The normal of the result is on the same side. `None` also
/// if the iteration does not converge, because the normal turns too much over that distance.
pub fn first_touch(
    p: &NodePath,
    (q, triangle): (&[NodePath; 4], bool),
    normal: V3,
    distance: impl Fn(&V3) -> f64,
) -> Option<Impact> {
    /// Largest number of iterations, and change of the normal at which they end. The error of the
    /// distance is of the second order in this change.
    const ITERATIONS: usize = 12;
    const SETTLED: f64 = 1e-9;
    let mut facing = normal;
    for _ in 0..ITERATIONS {
        let apart = distance(&facing);
        let shifted = NodePath { from: p.from - facing * apart, by: p.by };
        let found = first_crossing(&shifted, q, triangle)?;
        let found = Impact { normal: found.normal * found.normal.dot(&facing).signum(), ..found };
        if apart == 0.0 || (found.normal - facing).norm() <= SETTLED {
            return Some(found);
        }
        facing = found.normal;
    }
    None
}

#[cfg(test)]
#[path = "impact_tests.rs"]
mod tests;
