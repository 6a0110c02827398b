//! Motion of nodes since the near list was made: how far two nodes may have moved against each
//! other.
//!
//! Two bounds are combined. The path is the sum over the steps of the largest relative
//! displacement of any two nodes. It is cheap and shows how long candidates can be left out
//! ([`Travel::path`]). The residual of a rigid motion is smaller for bodies that rotate and for
//! nodes that vibrate; it is fitted only if the path does not suffice.

use crumple_fem::nodes::Nodes;
use crumple_math::lanes::Lane;
use crumple_math::rigid_motion::MotionTracker;
use crumple_math::row::Row;

/// Largest ratio of the bound after a fit to the bound before it for which the fit had an effect.
const EFFECT: f64 = 0.9;
/// Largest number of fits in succession that are left out.
const MOST_LEFT_OUT: u32 = 15;

/// Motion of nodes since a reference time.
#[derive(Debug)]
pub struct Travel {
    tracker: MotionTracker,
    /// Positions of the ghosts at the last call of [`Travel::advance`] [length].
    ghosts: Vec<Row>,
    /// Sum of the largest relative displacements of the steps [length].
    path: f64,
    /// Bound by the last fit of a rigid motion, and the path at that time [length].
    fitted: f64,
    path_at_fit: f64,
    /// Number of fits to be left out, and number of fits that were left out after the last one
    /// that did not lower the bound.
    left_out: [u32; 2],
}

impl Travel {
    /// Starts without nodes.
    pub fn none() -> Self {
        let (tracker, ghosts) = (MotionTracker::since(&[]), Vec::new());
        Self { tracker, ghosts, path: 0.0, fitted: 0.0, path_at_fit: 0.0, left_out: [0; 2] }
    }

    /// Restarts at the present positions.
    pub fn restart(&mut self, nodes: &Nodes) {
        self.tracker.restart(&nodes.x, Vec::new());
        self.ghosts.clear();
        self.ghosts.extend_from_slice(&nodes.x[nodes.local_count..]);
        (self.path, self.fitted, self.path_at_fit) = (0.0, 0.0, 0.0);
    }

    /// Returns the bytes in use.
    pub fn bytes(&self) -> usize {
        self.tracker.bytes() + size_of_val(&self.ghosts[..])
    }

    /// Adds the motion of the last step to the path. Call it once in each step: the displacements
    /// of local nodes are those of [`Nodes::displacements`].
    pub fn advance(&mut self, nodes: &Nodes) {
        let mut moved = nodes.displacements;
        for (x, before) in nodes.x[nodes.local_count..].iter().zip(&mut self.ghosts) {
            moved.include(Lane::new(*x) - Lane::new(*before));
            *before = *x;
        }
        self.path += moved.diameter();
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

    /// Lowers [`Travel::bound`] by a fit of the rigid motion to `x`, the present positions. After
    /// a fit without much effect, more and more calls do nothing: bodies that are crushed do not
    /// move like a rigid body, and later fits will hardly help either.
    pub fn fit(&mut self, x: &[Row]) {
        let [due, last] = &mut self.left_out;
        if *due > 0 {
            *due -= 1;
            return;
        }
        let before = self.fitted + (self.path - self.path_at_fit);
        self.fitted = before.min(2.0 * self.tracker.update(x).residual);
        self.path_at_fit = self.path;
        *last = if self.fitted < EFFECT * before { 0 } else { (2 * *last + 1).min(MOST_LEFT_OUT) };
        *due = *last;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_fem::testing::nodes_at;
    use crumple_math::row::row;
    use nalgebra::{Rotation3, Vector3};

    /// Two points of a body that rotates do not move against each other, but their path is long.
    #[test]
    fn a_fit_removes_rotation_from_the_bound_and_not_from_the_path() {
        let points: Vec<Vector3<f64>> = (0..20)
            .map(f64::from)
            .map(|a| Vector3::new(a.sin(), (1.7 * a).cos(), (0.3 * a).sin()))
            .collect();
        let turned = |angle: f64, dent: f64| {
            let turn = Rotation3::from_euler_angles(0.0, 0.0, angle);
            let mut x: Vec<[f64; 3]> = points.iter().map(|p| (turn * p).into()).collect();
            x[7][2] += dent;
            x
        };
        let mut nodes = nodes_at(&turned(0.0, 0.0));
        let mut travel = Travel::none();
        // The first nodes are local and move by their velocities, the others are ghosts.
        nodes.local_count = 12;
        travel.restart(&nodes);
        let mut step = |travel: &mut Travel, angle: f64, dent: f64| {
            let to = turned(angle, dent);
            for (i, to) in to.iter().enumerate() {
                nodes.v_next[i] = row(std::array::from_fn(|c| to[c] - nodes.x[i][c]));
            }
            nodes.advance(1.0);
            (12..to.len()).for_each(|i| nodes.x[i] = row(to[i]));
            travel.advance(&nodes);
            nodes.x.clone()
        };
        for i in 1..=10 {
            step(&mut travel, 0.1 * f64::from(i), 0.0);
        }
        let path = travel.path();
        let width = points.iter().map(|p| p.xy().norm()).fold(0.0, f64::max);
        assert!(path >= width && travel.bound() == path, "no node moves less than the path");
        let x = step(&mut travel, 1.0, 0.0);
        travel.fit(&x);
        assert!(travel.bound() < 1e-12 && travel.path() - path < 1e-12, "{}", travel.bound());
        step(&mut travel, 1.0, 0.25);
        assert!((travel.bound() - 0.25).abs() < 1e-12, "{}", travel.bound());
        travel.restart(&nodes);
        assert_eq!([travel.path(), travel.bound()], [0.0; 2]);
    }
}
