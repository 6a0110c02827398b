//! Plastic flow with the von Mises condition, mixed hardening and tables by strain rate. It extends
//! the flow of `plasticity` for laws that ask for one of them.
//!
//! The yield stress is `S = factor(rate) sig_y(eps_p, rate)`. A back stress a follows Prager's rule
//! with the modulus `H_k`. With the relative stress `xi = sig - a` of the elastic trial the return
//! is that of Simo & Hughes 1998, boxes 3.1 and 3.3, with kinematic hardening:
//! ```text
//! v(y) = p / alpha^2 + q / beta^2 = 1,   y = d eps_p
//! alpha = S + (E / (2 (1-nu)) + H_k) y,   beta = S + (3 G + H_k) y
//! plane stress: p = (xi_x + xi_y)^2/4,  q = 3/4 (xi_y - xi_x)^2 + 3 xi_xy^2
//! three dimensions: p = 0,  q = 3/2 dev xi : dev xi
//! a <- a + H_k y xi / S   with xi after the return
//! ```
//! In plane stress a is the stress-like back stress of the source. S is taken at the rate of the
//! total deviatoric strain, as in `plasticity`, or (viscoplastic) at the rate `y/dt` of the plastic
//! strain. `1/sqrt(v)` increases with y, so that a bracket always contains the solution; Newton
//! steps solve the equation, and bisection where they leave the bracket.
//!
//! Stresses are in units of the initial yield stress.

use super::{Coefficients, Plasticity, effective_rate, tolerance};
use crate::materials::polyline::{CurveFamily, RampCurve};
use crate::materials::{Elastic, PlaneStress, Points, Solid, SolidPoint};
use crumple_math::lanes::{Lane, Lane32, Real, dot};

/// Largest number of steps of the solver; about five are enough without bisection.
const MOST_STEPS: usize = 100;
/// Most columns of a point in plane stress.
const MOST_COLUMNS: usize = 8;

/// Names of the columns after stress, without and with back stress, without and with failure.
const SHELL: [[&[&str]; 2]; 2] = [
    [&["plastic_strain"], &["plastic_strain", "failed"]],
    [
        &["plastic_strain", "back stress xx", "back stress yy", "back stress xy"],
        &["plastic_strain", "failed", "back stress xx", "back stress yy", "back stress xy"],
    ],
];
const SOLID: [[&[&str]; 2]; 2] = [
    SHELL[0],
    [
        &[
            "back stress xx",
            "back stress yy",
            "back stress zz",
            "back stress xy",
            "back stress yz",
            "back stress zx",
            "plastic_strain",
        ],
        &[
            "back stress xx",
            "back stress yy",
            "back stress zz",
            "back stress xy",
            "back stress yz",
            "back stress zx",
            "plastic_strain",
            "failed",
        ],
    ],
];

/// Factor of the strain rate on the yield stress.
pub enum RateFactor {
    /// One.
    None,
    /// `1 + (rate/c)^inv_p`.
    CowperSymonds {
        /// Rate at which the yield stress is doubled [1/time].
        c: f64,
        /// Exponent 1/p.
        inv_p: f64,
    },
    /// A curve over the rate.
    Curve(RampCurve),
}

/// A plastic law with mixed hardening or tables by rate.
pub struct CombinedPlasticity {
    /// The law without kinematic hardening and rates: elastic constants, smallest yield stress.
    pub base: Plasticity,
    /// Yield stress over plastic strain by rate, in units of the initial yield stress.
    pub hardening: CurveFamily,
    /// H_k, in units of the initial yield stress.
    pub kinematic: f64,
    /// Factor of the rate.
    pub rate: RateFactor,
    /// True if the rate is that of the plastic strain.
    pub viscoplastic: bool,
    /// Plastic strain at which a point fails; infinite if it does not.
    pub failure_strain: f64,
}

/// A relative stress to be returned.
#[derive(Clone, Copy)]
struct RelativeTrial<R> {
    /// See above.
    p: R,
    q: R,
    /// Plastic strain before the step.
    eps_p: R,
    /// Rate of the total strain [1/time].
    rate: R,
    /// Step [time].
    dt: f64,
}

impl CombinedPlasticity {
    fn kinds(&self) -> [usize; 2] {
        [self.kinematic > 0.0, self.failure_strain < f64::INFINITY].map(usize::from)
    }

    /// Returns the yield stress, and its derivatives by plastic strain and by rate.
    #[inline(always)]
    fn yield_stress<R: Real>(&self, eps_p: R, rate: R) -> [R; 3] {
        let [sig_y, by_strain, by_rate] = self.hardening.at(rate, eps_p);
        match &self.rate {
            RateFactor::None => [sig_y, by_strain, by_rate],
            RateFactor::CowperSymonds { c, inv_p } => {
                let ratio = rate * R::splat(1.0 / c);
                let moves = ratio.gt(R::splat(R::SMALLEST));
                let power = R::select(moves, ratio.powf_where(*inv_p, moves), R::zero());
                let slope = R::select(moves, R::splat(*inv_p) * power / rate, R::zero());
                let factor = R::splat(1.0) + power;
                [factor * sig_y, factor * by_strain, factor * by_rate + slope * sig_y]
            }
            RateFactor::Curve(curve) => {
                let [factor, slope] = curve.at(rate);
                [factor * sig_y, factor * by_strain, factor * by_rate + slope * sig_y]
            }
        }
    }

    /// Returns the rate that counts before flow.
    #[inline(always)]
    fn first_rate<R: Real>(&self, trial: &RelativeTrial<R>) -> R {
        if self.viscoplastic { R::zero() } else { trial.rate }
    }

    /// Returns the yield stress at y, with alpha and beta and their derivatives.
    #[inline(always)]
    fn denominators<R: Real>(&self, trial: &RelativeTrial<R>, y: R) -> ([R; 3], [R; 2]) {
        let [a, b] = self.base.coefficients.moduli.map(|m| R::splat(m + self.kinematic));
        let per_dt = R::splat(if trial.dt > 0.0 { 1.0 / trial.dt } else { 0.0 });
        let rate = if self.viscoplastic { y * per_dt } else { trial.rate };
        let [s, by_strain, by_rate] = self.yield_stress(trial.eps_p + y, rate);
        let slope = if self.viscoplastic { by_rate.mul_add(per_dt, by_strain) } else { by_strain };
        ([s, a.mul_add(y, s), b.mul_add(y, s)], [a + slope, b + slope])
    }

    /// Returns y in the lanes of `mask`, zero in others, with the yield stress, alpha and beta at
    /// it.
    #[inline(always)]
    fn solve<R: Real>(&self, trial: &RelativeTrial<R>, mask: R::Mask) -> (R, [R; 3]) {
        let [a, b] = self.base.coefficients.moduli;
        let (zero, one, half) = (R::zero(), R::splat(1.0), R::splat(0.5));
        let mut high = (trial.p + trial.q).sqrt() * R::splat(1.0 / (a.min(b) + self.kinematic));
        let (mut low, mut y) = (zero, zero);
        let small = R::splat(tolerance::<R>());
        for _ in 0..MOST_STEPS {
            let ([_, alpha, beta], [d_alpha, d_beta]) = self.denominators(trial, y);
            let (of_p, of_q) = (trial.p / (alpha * alpha), trial.q / (beta * beta));
            let v = of_p + of_q;
            let root = one / v.sqrt();
            let off = root - one;
            let slope = root / v * (of_p * d_alpha / alpha + of_q * d_beta / beta);
            let active = R::both(mask, off.abs().gt(small));
            if !R::any(active) {
                break;
            }
            low = R::select(off.lt(zero), y, low);
            high = R::select(off.lt(zero), high, y);
            let newton = y - off / slope;
            let inside = R::both(newton.gt(low), newton.lt(high));
            let next = R::select(inside, newton, half * (low + high));
            y = R::select(active, next, y);
        }
        let y = R::select(mask, y, zero);
        (y, self.denominators(trial, y).0)
    }

    /// Returns the lanes in which the trial is beyond the yield surface.
    #[inline(always)]
    fn over<R: Real>(&self, trial: &RelativeTrial<R>) -> R::Mask {
        let [s, ..] = self.yield_stress(trial.eps_p, self.first_rate(trial));
        (trial.p + trial.q).gt(s * s)
    }

    /// Marks failure and removes the stress of failed lanes. `failed` is the column.
    #[inline(always)]
    fn fail<R: Real>(&self, state: &mut [R], strain: usize, failed: usize, stress: usize) {
        let limit = R::splat(self.failure_strain * (1.0 - f64::max(1e-12, 16.0 * R::EPSILON)));
        let fails = state[strain].ge(limit);
        state[failed] = R::select(fails, R::splat(1.0), state[failed]);
        let alive = state[failed].lt(R::splat(0.5));
        state[..stress].iter_mut().for_each(|s| *s = R::select(alive, *s, R::zero()));
    }

    /// Updates a point in plane stress. Returns the strain through the thickness.
    #[inline(always)]
    fn shell_point<R: Real>(&self, state: &mut [R], eps: [R; 3], dt: f64) -> R {
        const STRAIN: usize = 3;
        const FAILED: usize = 4;
        let [kinematic, fails] = self.kinds();
        let back = STRAIN + 1 + fails;
        let Coefficients { plane_stress, thinning, per_yield2, anisotropy, .. } =
            self.base.coefficients;
        let [c11, c12, g] = plane_stress.map(R::splat);
        let before = state[0] + state[1];
        state[0] += c11.mul_add(eps[0], c12 * eps[1]);
        state[1] += c11.mul_add(eps[1], c12 * eps[0]);
        state[2] = g.mul_add(eps[2], state[2]);
        let a: [R; 3] =
            std::array::from_fn(|c| if kinematic == 1 { state[back + c] } else { R::zero() });
        let xi: [R; 3] = std::array::from_fn(|c| state[c] - a[c]);
        let (sum, difference) = (xi[0] + xi[1], xi[1] - xi[0]);
        let [of_s, of_d, of_t] = anisotropy.factors().map(|factor| R::splat(factor * per_yield2));
        let trial = RelativeTrial {
            p: of_s * sum * sum,
            q: (of_d * difference).mul_add(difference, of_t * xi[2] * xi[2]),
            eps_p: state[STRAIN],
            rate: effective_rate(super::plane_stress::square(eps), dt),
            dt,
        };
        let mut over = self.over(&trial);
        if fails == 1 {
            over = R::both(over, state[FAILED].lt(R::splat(0.5)));
        }
        if R::any(over) {
            let (y, [s, alpha, beta]) = self.solve(&trial, over);
            let (sum, difference) = (sum * s / alpha, difference * s / beta);
            let half = R::splat(0.5);
            let xi = [half * (sum - difference), half * (sum + difference), xi[2] * s / beta];
            let moves = R::splat(self.kinematic) * y / s;
            for c in 0..3 {
                let a = moves.mul_add(xi[c], a[c]);
                state[c] = R::select(over, a + xi[c], state[c]);
                if kinematic == 1 {
                    state[back + c] = R::select(over, a, state[back + c]);
                }
            }
            state[STRAIN] += y;
        }
        // The strain follows from the stress before failure removes it, as in `plane_stress`.
        let through = R::splat(thinning).mul_add(state[0] + state[1] - before, -(eps[0] + eps[1]));
        if fails == 1 {
            self.fail(state, STRAIN, FAILED, 3);
        }
        through
    }

    #[inline(always)]
    fn shell<R: Real>(&self, points: Points<'_, R>, dt: f64) {
        let columns = 3 + PlaneStress::history(self).len();
        debug_assert!(columns <= MOST_COLUMNS, "beams keep no more columns");
        let states = points.state.chunks_exact_mut(columns);
        for ((state, eps), through) in states.zip(points.strain).zip(points.thickness_strain) {
            *through = self.shell_point(state, *eps, dt);
        }
    }

    #[inline(always)]
    fn solid<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let [kinematic, fails] = self.kinds();
        let (stress, columns) = point.state.split_at_mut(6);
        let (back, columns) = columns.split_at_mut(6 * kinematic);
        let (third, one) = (R::splat(1.0 / 3.0), R::splat(1.0));
        let [g, bulk] = [self.base.coefficients.shear, self.base.coefficients.bulk].map(R::splat);
        let eps = point.strain;
        let trace = eps[0] + eps[1] + eps[2];
        let e: [R; 6] =
            std::array::from_fn(|c| if c < 3 { eps[c] - third * trace } else { eps[c] });
        let old_mean = third * (stress[0] + stress[1] + stress[2]);
        let mean = bulk.mul_add(trace, old_mean);
        let mut deviator: [R; 6] = std::array::from_fn(|c| {
            let (modulus, old) = if c < 3 { (g + g, stress[c] - old_mean) } else { (g, stress[c]) };
            modulus.mul_add(e[c], old)
        });
        let a: [R; 6] = std::array::from_fn(|c| if kinematic == 1 { back[c] } else { R::zero() });
        let xi: [R; 6] = std::array::from_fn(|c| deviator[c] - a[c]);
        let square = R::splat(1.5) * inner(&xi, 2.0);
        let trial = RelativeTrial {
            p: R::zero(),
            q: square * R::splat(self.base.coefficients.per_yield2),
            eps_p: columns[0],
            rate: effective_rate(inner(&e, 0.5), dt),
            dt,
        };
        let mut over = self.over(&trial);
        if fails == 1 {
            over = R::both(over, columns[1].lt(R::splat(0.5)));
        }
        let mut left = one;
        if R::any(over) {
            let (y, [s, _, beta]) = self.solve(&trial, over);
            let (keep, moves) = (s / beta, R::splat(self.kinematic) * y / s);
            let before = inner(&deviator, 2.0);
            for c in 0..6 {
                let xi = keep * xi[c];
                let a = moves.mul_add(xi, a[c]);
                deviator[c] = R::select(over, a + xi, deviator[c]);
                if kinematic == 1 {
                    back[c] = R::select(over, a, back[c]);
                }
            }
            if kinematic == 1 {
                // Not that of the relative stress.
                let kept = inner(&deviator, 2.0) / Real::max(before, R::splat(R::SMALLEST));
                left = R::select(over, Real::min(kept.sqrt(), one), one);
            } else {
                left = R::select(over, keep, one);
            }
            columns[0] += y;
        }
        for c in 0..3 {
            (stress[c], stress[3 + c]) = (deviator[c] + mean, deviator[3 + c]);
        }
        if fails == 1 {
            let strain = 6 * (1 + kinematic);
            self.fail(point.state, strain, strain + 1, 6);
        }
        left
    }
}

/// Returns `t:t` of a symmetric tensor whose shear components count `twice`.
#[inline(always)]
fn inner<R: Real>(t: &[R; 6], twice: f64) -> R {
    let (direct, shear) = ([t[0], t[1], t[2]], [t[3], t[4], t[5]]);
    R::splat(twice).mul_add(dot(shear, shear), dot(direct, direct))
}

impl PlaneStress for CombinedPlasticity {
    fn history(&self) -> &'static [&'static str] {
        let [kinematic, fails] = self.kinds();
        SHELL[kinematic][fails]
    }
    fn initial_yield_stress(&self) -> f64 {
        self.base.yield_stress
    }
    fn rate_dependent(&self) -> Option<&Plasticity> {
        // With back stress the static yield stress is no bound of the stress.
        (self.kinematic == 0.0).then_some(&self.base)
    }
    fn adds_stress(&self) -> bool {
        true
    }
    fn elastic(&self) -> Elastic {
        self.base.elastic
    }
    fn update(&self, points: Points<'_, Lane>, dt: f64) {
        self.shell(points, dt);
    }
    fn update_short(&self, points: Points<'_, Lane32>, dt: f64) {
        self.shell(points, dt);
    }
    fn update_one(&self, points: Points<'_, f64>, dt: f64) {
        self.shell(points, dt);
    }
}

impl Solid for CombinedPlasticity {
    fn history(&self) -> &'static [&'static str] {
        let [kinematic, fails] = self.kinds();
        SOLID[kinematic][fails]
    }
    fn tensors(&self) -> usize {
        self.kinds()[0]
    }
    fn adds_stress(&self) -> bool {
        true
    }
    fn elastic(&self) -> Elastic {
        self.base.elastic
    }
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) -> Lane {
        self.solid(point, dt)
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, dt: f64) -> Lane32 {
        self.solid(point, dt)
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) -> f64 {
        self.solid(point, dt)
    }
}

#[cfg(test)]
#[path = "combined_tests.rs"]
mod tests;
