//! Nodes that follow the mean motion of a set of nodes, their masters (RBE3 in other programs).
//!
//! With weights N_k that sum to 1, the masters are at `r_k` from their weighted mean position.
//! Their mean rotational velocity is that of the rigid motion that fits their velocities best:
//! `w = T^-1 sum N_k r_k x v_k`, `T = sum N_k (r_k^2 I - r_k r_k')`. A force F and a moment M
//! about the mean position act on the masters as `f_k = N_k (F + (T^-1 M) x r_k)`. These have the
//! sum F and the moment M, and their power is that of F and M on the mean motion, because
//! `sum N_k r_k = 0`.

use crate::math::row::V3;
use nalgebra::Matrix3;

/// Mean rotation of masters at their present positions.
pub struct MeanRotation {
    /// Mean position [length].
    foot: V3,
    /// Inverse of T [1/length^2].
    inverse: Matrix3<f64>,
}

impl MeanRotation {
    /// Computes it from the weights of the masters and their positions.
    pub fn new(shares: &[(u32, f64)], place: impl Fn(usize) -> [f64; 3]) -> Self {
        let points = || shares.iter().map(|&(c, share)| (V3::from(place(c as usize)), share));
        let foot: V3 = points().map(|(x, share)| x * share).sum();
        let spread = points().fold(Matrix3::zeros(), |sum, (x, share)| {
            let r = x - foot;
            sum + (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * share
        });
        Self { foot, inverse: spread.try_inverse().unwrap_or_else(Matrix3::zeros) }
    }

    /// Returns the mean rotational velocity [1/time].
    pub fn spin(
        &self,
        shares: &[(u32, f64)],
        place: impl Fn(usize) -> [f64; 3],
        velocity: impl Fn(usize) -> [f64; 3],
    ) -> V3 {
        let turn = |&(c, share): &(u32, f64)| {
            let r = V3::from(place(c as usize)) - self.foot;
            r.cross(&V3::from(velocity(c as usize))) * share
        };
        self.inverse * shares.iter().map(turn).sum::<V3>()
    }

    /// Returns the part of a force and a moment about the mean position that a master with the
    /// weight `share` gets [force].
    pub fn force_on(&self, place: [f64; 3], share: f64, [force, moment]: [V3; 2]) -> V3 {
        let r = V3::from(place) - self.foot;
        (force + (self.inverse * moment).cross(&r)) * share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHARES: [(u32, f64); 4] = [(0, 0.1), (1, 0.2), (2, 0.3), (3, 0.4)];
    const PLACES: [[f64; 3]; 4] =
        [[0.0, 0.0, 0.0], [3.0, 0.0, 1.0], [0.0, 2.0, 0.0], [1.0, 1.0, -2.0]];

    /// The forces on masters have the force and the moment of the slave, and the power of both on
    /// the mean motion, for any velocities.
    #[test]
    fn forces_keep_sum_moment_and_power() {
        let place = |c: usize| PLACES[c];
        let mean = MeanRotation::new(&SHARES, place);
        let (force, moment) = (V3::new(1.0, -2.0, 0.5), V3::new(0.3, 4.0, -1.0));
        let on =
            |&(c, share): &(u32, f64)| mean.force_on(place(c as usize), share, [force, moment]);
        let sum: V3 = SHARES.iter().map(on).sum();
        let turn: V3 =
            SHARES.iter().map(|s| (V3::from(place(s.0 as usize)) - mean.foot).cross(&on(s))).sum();
        assert!((sum - force).norm() < 1e-14 && (turn - moment).norm() < 1e-14, "{sum} {turn}");
        let velocity = |c: usize| [[1.0, 2.0, 3.0], [-1.0, 0.0, 2.0], [0.5, 0.1, 0.0], [0.0; 3]][c];
        let power: f64 = SHARES.iter().map(|s| on(s).dot(&V3::from(velocity(s.0 as usize)))).sum();
        let drift: V3 = SHARES.iter().map(|s| V3::from(velocity(s.0 as usize)) * s.1).sum();
        let spin = mean.spin(&SHARES, place, velocity);
        assert!((power - force.dot(&drift) - moment.dot(&spin)).abs() < 1e-13);
    }

    /// The mean rotation of a rigid motion is that of the motion.
    #[test]
    fn a_rigid_motion_has_its_own_rotation() {
        let place = |c: usize| PLACES[c];
        let (drift, spin) = (V3::new(1.0, 2.0, 3.0), V3::new(-0.2, 0.5, 0.7));
        let velocity = |c: usize| (drift + spin.cross(&V3::from(PLACES[c]))).into();
        let found = MeanRotation::new(&SHARES, place).spin(&SHARES, place, velocity);
        assert!((found - spin).norm() < 1e-14, "{found}");
    }
}
