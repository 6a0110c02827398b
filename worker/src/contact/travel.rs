//! Motion of nodes since the near list was made: how far two nodes may have moved against each
//! other.
//!
//! Two bounds are combined. The path is the sum over the steps of the largest relative
//! displacement of any two nodes. It is cheap and shows how long candidates can be left out
//! ([`Travel::path`]). The residual of a rigid motion is smaller for bodies that rotate and for
//! nodes that vibrate; it is fitted only if the path does not suffice.

use crate::math::lanes::{Lane, Real};
use crate::math::rigid_motion::MotionTracker;
use crate::math::row::Row;

/// Motion of nodes since a reference time.
#[derive(Debug)]
pub struct Travel {
    tracker: MotionTracker,
    /// Positions at the last call of [`Travel::advance`] [length].
    before: Vec<Row>,
    /// Sum of the largest relative displacements of the steps [length].
    path: f64,
    /// Bound by the last fit of a rigid motion, and the path at that time [length].
    fitted: f64,
    path_at_fit: f64,
}

impl Travel {
    /// Starts at the positions `x`.
    pub fn since(x: &[Row]) -> Self {
        let (tracker, before) = (MotionTracker::since(x), x.to_vec());
        Self { tracker, before, path: 0.0, fitted: 0.0, path_at_fit: 0.0 }
    }

    /// Restarts at the positions `x`.
    pub fn restart(&mut self, x: &[Row]) {
        self.tracker.restart(x, Vec::new());
        self.before.clear();
        self.before.extend_from_slice(x);
        (self.path, self.fitted, self.path_at_fit) = (0.0, 0.0, 0.0);
    }

    /// Returns the bytes in use.
    pub fn bytes(&self) -> usize {
        self.tracker.bytes() + size_of_val(&self.before[..])
    }

    /// Adds the motion to `x`, the present positions of the same nodes, to the path.
    pub fn advance(&mut self, x: &[Row]) {
        let (count, before) = (x.len().min(self.before.len()), &mut self.before);
        self.path += spread(count, |i| {
            let moved = Lane::new(x[i]) - Lane::new(before[i]);
            before[i] = x[i];
            moved
        });
    }

    /// Returns the path: no two nodes have moved farther against each other since the start
    /// [length].
    pub fn path(&self) -> f64 {
        self.path
    }

    /// Returns a bound of the relative motion of two nodes apart from a rigid motion of all nodes
    /// [length].
    pub fn bound(&self) -> f64 {
        self.fitted + (self.path - self.path_at_fit)
    }

    /// Lowers [`Travel::bound`] by a fit of the rigid motion to `x`, the present positions.
    pub fn fit(&mut self, x: &[Row]) {
        self.fitted = self.bound().min(2.0 * self.tracker.update(x).residual);
        self.path_at_fit = self.path;
    }
}

/// Returns an upper bound of the difference of any two of the `count` vectors that `at` returns.
pub fn spread(count: usize, mut at: impl FnMut(usize) -> Lane) -> f64 {
    /// Number of bounds that are kept apart: each comparison waits for the last one of its bound.
    const APART: usize = 4;
    let (mut low, mut high) =
        ([Lane::splat(f64::INFINITY); APART], [Lane::splat(f64::NEG_INFINITY); APART]);
    // Numbers that are not finite are left out: the step that computed them ends the run.
    let mut extend = |k: usize, v: Lane| {
        (low[k], high[k]) = (Real::min(v, low[k]), Real::max(v, high[k]));
    };
    let whole = count - count % APART;
    for i in (0..whole).step_by(APART) {
        (0..APART).for_each(|k| extend(k, at(i + k)));
    }
    (whole..count).for_each(|i| extend(0, at(i)));
    let low = low.into_iter().reduce(Real::min).map_or([0.0; 4], |low| low.to_array());
    let high = high.into_iter().reduce(Real::max).map_or([0.0; 4], |high| high.to_array());
    let size = |c: usize| (high[c] - low[c]).max(0.0);
    (size(0) * size(0) + size(1) * size(1) + size(2) * size(2)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Vector3};

    /// Two points of a body that rotates do not move against each other, but their path is long.
    #[test]
    fn a_fit_removes_rotation_from_the_bound_and_not_from_the_path() {
        let points: Vec<Vector3<f64>> = (0..20)
            .map(f64::from)
            .map(|a| Vector3::new(a.sin(), (1.7 * a).cos(), (0.3 * a).sin()))
            .collect();
        let turned = |angle: f64, dent: f64| -> Vec<Row> {
            let turn = Rotation3::from_euler_angles(0.0, 0.0, angle);
            let mut x: Vec<Row> =
                points.iter().map(|p| turn * p).map(|p| [p.x, p.y, p.z, 0.0]).collect();
            x[7][2] += dent;
            x
        };
        let mut travel = Travel::since(&turned(0.0, 0.0));
        for i in 1..=10 {
            travel.advance(&turned(0.1 * f64::from(i), 0.0));
        }
        let path = travel.path();
        let width = points.iter().map(|p| p.xy().norm()).fold(0.0, f64::max);
        assert!(path >= width && travel.bound() == path, "no node moves less than the path");
        travel.fit(&turned(1.0, 0.0));
        assert!(travel.bound() < 1e-12 && travel.path() == path, "{}", travel.bound());
        travel.advance(&turned(1.0, 0.25));
        assert!((travel.bound() - 0.25).abs() < 1e-12, "{}", travel.bound());
        travel.restart(&turned(1.0, 0.25));
        assert_eq!([travel.path(), travel.bound()], [0.0; 2]);
    }
}
