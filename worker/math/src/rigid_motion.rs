//! Motion of nodes since a reference time: the best-fit rigid motion and the residual.
//!
//! Distances do not change in a rigid motion. So the result of a search, or a set of ghosts,
//! stays valid while the residual is small: a frame that flies and rotates needs neither a new
//! search nor a new decomposition.

use crate::row::{Row, V3};
use crate::vector_range::VectorRange;
use bytemuck::{Pod, Zeroable};
use crumple_proto::boxes::Aabb;
use nalgebra::Matrix3;

/// Number of nodes for the fit of the rigid motion. Any motion gives a valid bound; a good fit
/// gives a small one.
const SAMPLES: usize = 64;

/// Largest difference of two rotations for which [`RigidMotion::relative_motion_within`] is
/// valid. Outside its region the difference of the motions grows by at most this fraction of the
/// distance; the slacks reserve this fraction.
const MAX_ROTATION: f64 = 0.25;
/// Smallest number of nodes of a sample.
const MIN_SAMPLES: usize = 8;
/// Number of steps in which [`MotionTracker::follow`] fits the motion once. In each other step the
/// translation grows by the middle of the range of displacements, and the bounds of distances grow
/// by half of its diagonal.
const FIT_EVERY: u32 = 8;

/// A rigid motion and upper bounds of the distances of nodes from it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RigidMotion {
    /// Rotation.
    pub rotation: Matrix3<f64>,
    /// Translation after the rotation about the origin [length].
    pub translation: V3,
    /// Upper bound of |x - (R x_ref + t)| over the nodes [length]; their maximum after a fit.
    pub residual: f64,
    /// Upper bound of the distance minus the slack of the node [length]; their maximum after a fit.
    pub beyond_slack: f64,
}

impl RigidMotion {
    /// Returns the motion without rotation and translation.
    #[inline]
    pub fn none() -> Self {
        Self {
            rotation: Matrix3::identity(),
            translation: V3::zeros(),
            residual: 0.0,
            beyond_slack: 0.0,
        }
    }

    /// Returns the position of the point `p` after the motion [length].
    #[inline]
    pub fn carried(&self, p: V3) -> V3 {
        self.rotation * p + self.translation
    }

    /// Returns a bound on the relative displacement of two nodes [length]: one with its reference
    /// position in `region` that follows this motion, and any node that follows `other`.
    pub fn relative_motion(&self, other: &Self, region: &Aabb) -> f64 {
        self.carried_relative_motion(other, region) + self.residual + other.residual
    }

    /// Returns a bound on the relative displacement of all nodes of two workers [length].
    /// `region` contains the nodes of this worker that those of the other worker could reach
    /// without slack. Infinite if the two rotations differ too much for a bound.
    pub fn relative_motion_within(&self, other: &Self, region: &Aabb) -> f64 {
        let turns = (self.rotation - other.rotation).norm() > MAX_ROTATION;
        let apart =
            self.carried_relative_motion(other, region) + self.beyond_slack + other.beyond_slack;
        if turns { f64::INFINITY } else { apart }
    }

    fn carried_relative_motion(&self, other: &Self, region: &Aabb) -> f64 {
        // The difference is linear in the point and its length is convex: the largest is at a
        // corner.
        let at = |p: [f64; 3]| (self.carried(p.into()) - other.carried(p.into())).norm();
        region.corners().into_iter().map(at).fold(0.0, f64::max)
    }
}

/// Reference positions and the motion since then.
#[derive(Debug)]
pub struct MotionTracker {
    reference: Vec<Row>,
    /// Nodes to which the rigid motion is fitted.
    sample: Vec<u32>,
    /// Distance from the rigid motion that is ignored, for each node [length]; empty if zero for
    /// all.
    slack: Vec<f64>,
    drift: RigidMotion,
    /// Number of steps since the last fit.
    since_fit: u32,
}

crate::stateless!(MotionTracker { reference, sample, slack, drift, since_fit });

impl MotionTracker {
    /// Starts at the positions `x`.
    pub fn since(x: &[Row]) -> Self {
        let mut motion = Self {
            reference: Vec::new(),
            sample: Vec::new(),
            slack: Vec::new(),
            drift: RigidMotion::none(),
            since_fit: FIT_EVERY,
        };
        motion.restart(x, Vec::new());
        motion
    }

    /// Restarts at the positions `x`. `slack` has one distance per node, up to which its
    /// departure is ignored, or is empty [length]. The motion is fitted to the nodes with zero
    /// slack.
    pub fn restart(&mut self, x: &[Row], slack: Vec<f64>) {
        self.reference.clear();
        self.reference.extend_from_slice(x);
        self.slack = slack;
        let tight = |i: &u32| self.slack.get(*i as usize).is_none_or(|&s| s == 0.0);
        let all = 0..x.len() as u32;
        let mut picked: Vec<u32> = all.clone().filter(tight).collect();
        if picked.len() < MIN_SAMPLES {
            picked = all.collect();
        }
        self.sample = picked.iter().copied().step_by((picked.len() / SAMPLES).max(1)).collect();
        (self.drift, self.since_fit) = (RigidMotion::none(), FIT_EVERY);
    }

    /// Returns the positions of the nodes at the last restart [length].
    pub fn reference(&self) -> &[Row] {
        &self.reference
    }

    /// Returns the bytes in use.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.reference[..])
            + size_of_val(&self.sample[..])
            + size_of_val(&self.slack[..])
    }

    /// Returns the motion to `x`, the present positions of the same nodes [length]. Call it in each
    /// step; `moved` is the range of the displacements of all nodes since the last call [length].
    /// The motion is fitted in some of the calls, and always if `exact`. In the others the bounds
    /// of distances grow.
    pub fn follow(&mut self, x: &[Row], moved: &VectorRange, exact: bool) -> RigidMotion {
        self.since_fit += 1;
        if exact || self.since_fit >= FIT_EVERY {
            self.since_fit = 0;
            return self.update(x);
        }
        if !x.is_empty() {
            let [low, high] = moved.bounds();
            self.drift.translation += (vec3(&low) + vec3(&high)) * 0.5;
            let apart = 0.5 * moved.diameter();
            self.drift.residual += apart;
            self.drift.beyond_slack += apart;
        }
        self.drift
    }

    /// Fits the motion to `x`, the present positions of the same nodes [length], and returns it.
    pub fn update(&mut self, x: &[Row]) -> RigidMotion {
        self.fit(x);
        let (r, t) = (&self.drift.rotation, &self.drift.translation);
        let departure = |a: &Row, b: &Row| {
            let mut d2 = 0.0;
            for c in 0..3 {
                let d = a[c] - (r[(c, 0)] * b[0] + r[(c, 1)] * b[1] + r[(c, 2)] * b[2] + t[c]);
                d2 += d * d;
            }
            d2
        };
        let squared = x.iter().zip(&self.reference).map(|(a, b)| departure(a, b));
        let (worst, beyond) = if self.slack.is_empty() {
            let worst = squared.fold(0.0, f64::max).sqrt();
            (worst, worst)
        } else {
            let with_slack = squared.map(f64::sqrt).zip(&self.slack);
            with_slack.fold((0.0f64, 0.0f64), |(w, b), (d, slack)| (w.max(d), b.max(d - slack)))
        };
        (self.drift.residual, self.drift.beyond_slack) = (worst, beyond);
        self.drift
    }

    /// Fits a rigid motion to the sample by least squares (Kabsch 1976).
    fn fit(&mut self, x: &[Row]) {
        let pair = |&i: &u32| (vec3(&x[i as usize]), vec3(&self.reference[i as usize]));
        let sample = || self.sample.iter().map(pair);
        let n = sample().count().max(1) as f64;
        let (sum, sum_ref) =
            sample().fold((V3::zeros(), V3::zeros()), |s, p| (s.0 + p.0, s.1 + p.1));
        let (centre, centre_ref) = (sum / n, sum_ref / n);
        let cross = sample()
            .fold(Matrix3::zeros(), |m, p| m + (p.0 - centre) * (p.1 - centre_ref).transpose());
        self.drift.rotation = rotation_of(&cross).unwrap_or(self.drift.rotation);
        self.drift.translation = centre - self.drift.rotation * centre_ref;
    }
}

#[inline]
fn vec3(r: &Row) -> V3 {
    V3::new(r[0], r[1], r[2])
}

/// Returns the rotation nearest to a cross-covariance; `None` if it is not determined (points on
/// a line).
fn rotation_of(cross: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = cross.try_svd(true, true, f64::EPSILON, 100)?;
    let (u, vt) = (svd.u?, svd.v_t?);
    let mut r = u * vt;
    if r.determinant() < 0.0 {
        let mut flipped = u;
        flipped.column_mut(2).neg_mut();
        r = flipped * vt;
    }
    r.iter().all(|a| a.is_finite()).then_some(r)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Lane;
    use nalgebra::Rotation3;

    fn cloud() -> Vec<Row> {
        (0..500)
            .map(|i| {
                let a = i as f64;
                [100.0 * (0.7 * a).sin(), 80.0 * (1.3 * a).cos(), 5.0 * (0.1 * a).sin() + a, 0.0]
            })
            .collect()
    }

    #[test]
    fn rigid_motion_leaves_nothing_over_and_a_dent_is_measured() {
        let x0 = cloud();
        let mut motion = MotionTracker::since(&x0);
        let r = Rotation3::from_euler_angles(0.4, -1.0, 2.0);
        let mut x: Vec<Row> = x0
            .iter()
            .map(|p| {
                let q = r * vec3(p) + V3::new(900.0, -20.0, 3.0);
                [q.x, q.y, q.z, 0.0]
            })
            .collect();
        assert!(motion.update(&x).residual < 1e-9, "round-off of coordinates around 1e3");
        x[3][1] += 2.5; // not in the sample
        let d = motion.update(&x);
        assert!((d.residual - 2.5).abs() < 1e-9, "{}", d.residual);
    }

    /// Between two fits the motion still bounds the distances of all nodes, and loses little for a
    /// body that rotates slowly.
    #[test]
    fn a_motion_that_is_followed_bounds_that_of_all_nodes() {
        let x0 = cloud();
        let at = |step: u32| -> Vec<Row> {
            let t = f64::from(step);
            let r = Rotation3::from_euler_angles(0.0, 0.0, 1e-4 * t);
            let moved = |(i, p): (usize, &Row)| {
                let q = r * vec3(p) + V3::new(3.0 * t, -0.5 * t, 0.0);
                [q.x, q.y, q.z + if i == 3 { 0.02 * t } else { 0.0 }, 0.0]
            };
            x0.iter().enumerate().map(moved).collect()
        };
        let (mut motion, mut exact) = (MotionTracker::since(&x0), MotionTracker::since(&x0));
        let mut before = x0.clone();
        let mut differ = 0;
        for step in 0..4 * FIT_EVERY {
            let x = at(step);
            let by = |i: usize| Lane::new(x[i]) - Lane::new(before[i]);
            let moved = VectorRange::from_vectors(x.len(), by);
            let followed = motion.follow(&x, &moved, false);
            let largest =
                x.iter().zip(&x0).map(|(a, b)| (vec3(a) - followed.carried(vec3(b))).norm());
            let largest = largest.fold(0.0, f64::max);
            assert!(followed.residual >= largest - 1e-9, "{step}: {largest}, {followed:?}");
            let fitted = exact.follow(&x, &moved, true).residual;
            assert!(followed.residual - fitted < 0.3, "{step}: {} {fitted}", followed.residual);
            differ += u32::from(followed.residual != fitted);
            before = x;
        }
        assert_eq!(differ, 4 * (FIT_EVERY - 1), "it is fitted in one of some steps");
    }
}
