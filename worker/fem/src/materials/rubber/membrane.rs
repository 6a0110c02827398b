//! Rubber of Mooney and Rivlin in plane stress: the energy of `mooney_rivlin`, with the stretch
//! through the thickness that leaves no stress there. With D the determinant of the left
//! Cauchy-Green tensor B in the plane and III = D B_zz:
//! ```text
//! (a + b tr B) B_zz + 2 d (III - 1) III - (a + 2 b) III^-2 = 0
//! J sigma/2 = a (B - B_zz 1) + b (B_zz (B - tr B 1) + D 1),   J = sqrt(III)
//! ```
//! The first equation grows with B_zz; its root is found by Newton steps from III = 1. The history
//! holds B - 1 in the axes of the element. The stable step has the moduli at the start: it does not
//! follow the rubber where it stiffens, in compression and at large stretch, as it does in solids.

use super::super::tensor::stretch;
use crate::materials::{Elastic, PlaneStress, Points, STRETCH_COLUMN};
use crumple_math::lanes::{Lane, Lane32, Real};

/// Columns after stress.
const HISTORY: &[&str] = &[STRETCH_COLUMN, "B-1 yy", "B-1 xy", "B-1 zz"];
/// Columns of a point.
const COLUMNS: usize = 7;
/// Steps to the root. At Poisson's ratio 0.47 and stretches of 3 it is exact after five.
const STEPS: usize = 8;
/// Smallest III of a step, between 1/2, where d has no slope, and the root.
const LEAST_VOLUME: f64 = 0.55;

/// A rubber with the constants of [`super::mooney_rivlin`].
pub struct MooneyRivlinShell {
    /// Elastic constants at the start.
    pub elastic: Elastic,
    /// a [force/length^2].
    pub a: f64,
    /// b [force/length^2].
    pub b: f64,
    /// d [force/length^2].
    pub d: f64,
}

impl MooneyRivlinShell {
    fn stress<R: Real>(&self, points: Points<'_, R>) {
        let (states, _) = points.state.as_chunks_mut::<COLUMNS>();
        let (zero, one) = (R::zero(), R::splat(1.0));
        let [a, b] = [self.a, self.b].map(R::splat);
        for ((state, eps), eps_z) in
            states.iter_mut().zip(points.strain).zip(points.thickness_strain)
        {
            let old = [state[3], state[4], zero, state[5], zero, zero];
            let [p, q, _, r, ..] = stretch(&old, &[eps[0], eps[1], zero, eps[2], zero, zero]);
            let z = self.through_thickness([p, q, r]);
            // D - 1 and III.
            let m = p + q + r.neg_mul_add(r, p * q);
            let third = one + m + z + m * z;
            let per = R::splat(2.0) / third.sqrt();
            let sheared = b * r * r;
            state[0] = per * ((p - z) * b.mul_add(one + q, a) - sheared);
            state[1] = per * ((q - z) * b.mul_add(one + p, a) - sheared);
            state[2] = per * r * b.mul_add(one + z, a);
            let before = one + state[6];
            *eps_z = R::splat(0.5) * ((one + z) / before).ln();
            (state[3], state[4], state[5], state[6]) = (p, q, r, z);
        }
    }

    /// Returns B_zz - 1 for B - 1 in the plane.
    fn through_thickness<R: Real>(&self, [p, q, r]: [R; 3]) -> R {
        let one = R::splat(1.0);
        let [sum, b, twice_d] = [self.a + 2.0 * self.b, self.b, 2.0 * self.d].map(R::splat);
        let m = p + q + r.neg_mul_add(r, p * q);
        let share = one / (one + m);
        let least = R::splat(LEAST_VOLUME).mul_add(share, -one);
        let direct = b * (p + q);
        let mut z = (R::zero() - m) * share;
        for _ in 0..STEPS {
            let v = m + z + m * z;
            let third = one + v;
            let inverse = one / (third * third);
            let rest =
                sum * (z + v * (one + third) * inverse) + direct * (one + z) + twice_d * v * third;
            let slope = sum * (one + R::splat(2.0) * (one + m) * inverse / third)
                + direct
                + twice_d * (one + m) * (third + third - one);
            z = Real::max(z - rest / slope, least);
        }
        z
    }
}

impl PlaneStress for MooneyRivlinShell {
    fn history(&self) -> &'static [&'static str] {
        HISTORY
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, points: Points<'_, Lane>, _dt: f64) {
        self.stress(points);
    }
    fn update_short(&self, points: Points<'_, Lane32>, _dt: f64) {
        self.stress(points);
    }
    fn update_one(&self, points: Points<'_, f64>, _dt: f64) {
        self.stress(points);
    }
}

#[cfg(test)]
#[path = "membrane_tests.rs"]
mod tests;
