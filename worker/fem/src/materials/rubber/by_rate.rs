//! Rubber and foam by tests at several strain rates (Kolling, Du Bois, Benson & Feng 2007, A
//! tabulated formulation of hyperelasticity with rate effects and damage, Comput. Mech. 40), as in
//! `*MAT_SIMPLIFIED_RUBBER/FOAM` with a table. The stress is that of
//! [`tabulated`](super::tabulated) by the curve of the lowest rate, and an overstress of the same
//! form by what the curve of the present rate has above it:
//! ```text
//! J h_i = F(lambda_i) - mean or F(J^-beta),   F = f(., rate) - f(., lowest rate)
//! h acts while sum_i h_i d_i > 0, with the rates d of the strain along the principal directions
//! ```
//! f is linear between the rates of the curves and constant beyond them. The rate is that of the
//! principal direction whose strain changes fastest, so that a uniaxial test at a constant rate has
//! the stress of the curve of this rate. In the source each direction has a rate of its own; then
//! the sides, with a smaller rate, take part of it away.
//!
//! A stress by a table of rates has no energy. Here the stress of the lowest rate has one, and the
//! overstress acts only while it takes work: all of it is lost, so no closed path gives energy.
//! While it would give work, or without motion, the rate is zero and the stress that of the lowest
//! rate.
//!
//! The rate is a running mean over 12 steps or more. Its share of the new rate is so small that the
//! overstress rises at most with a modulus that the step allows for.
//!
//! Left out: curves of unloading, damage.

use super::tabulated::{TabulatedRubber, Volume};
use super::test_curve::{CurveTerms, TestCurve};
use super::{StrainEnergy, stiffening};
use crate::materials::tensor::{Symmetric, inner, stretch};
use crate::materials::{Elastic, STRETCH_COLUMN, Solid, SolidPoint};
use crumple_math::lanes::{Lane, Lane32, Real, dot};

/// Smallest number of steps of the running mean of the rate.
const STEPS_OF_MEAN: f64 = 12.0;
/// Largest modulus of the overstress by the rate, in stiffnesses of the steepest curve at zero.
/// Below two the stress of a steep curve would come late.
const RISE: f64 = 2.0;

const HISTORY: &[&str] = &[
    STRETCH_COLUMN,
    "B-1 yy",
    "B-1 zz",
    "B-1 xy",
    "B-1 yz",
    "B-1 zx",
    "stiffening",
    "strain rate",
];
const STRETCH: usize = 6;
const STIFFENING: usize = 12;
const RATE: usize = 13;

/// Differences of the curves from one rate to the next.
pub(super) struct RateSteps {
    /// Rates of the curves, ascending [1/time].
    rates: Vec<f64>,
    /// Each curve less the one before it.
    steps: Vec<TestCurve>,
    /// Largest modulus of the overstress by the rate [force/length^2].
    rise: f64,
    /// True if the rates of the curves are those of the nominal strain.
    pub(super) nominal: bool,
    /// Time of the running mean [time]; 0 for that of 12 steps.
    pub(super) averaging: f64,
}

/// f of the overstress at a rate, by direction, with that of the volume in foam.
struct RateSums<R> {
    /// f [force/length^2].
    values: [R; 4],
    /// Its slopes over ln lambda [force/length^2].
    slopes: [R; 4],
    /// Its slopes over the rate [force time/length^2].
    by_rate: [R; 4],
}

impl RateSteps {
    /// Creates them from at least two curves with ascending rates.
    pub(super) fn new(curves: &[(f64, TestCurve)], nominal: bool, averaging: f64) -> Self {
        let steps = curves.windows(2).map(|two| two[1].1.above(&two[0].1)).collect();
        let stiffest = curves.iter().map(|(_, curve)| curve.stiffness()).fold(0.0, f64::max);
        let rates = curves.iter().map(|(rate, _)| *rate).collect();
        Self { rates, steps, rise: RISE * stiffest, nominal, averaging }
    }

    #[inline(always)]
    fn sums<R: Real>(&self, rate: R, terms: &[CurveTerms<R>]) -> RateSums<R> {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let mut sums = RateSums { values: [zero; 4], slopes: [zero; 4], by_rate: [zero; 4] };
        for (two, step) in self.rates.windows(2).zip(&self.steps) {
            let per = R::splat(1.0 / (two[1] - two[0]));
            let share = (rate - R::splat(two[0])) * per;
            let inside = R::both(share.ge(zero), share.lt(one));
            let share = Real::min(Real::max(share, zero), one);
            for (k, terms) in terms.iter().enumerate() {
                let [value, slope] = step.sum_of(terms);
                sums.values[k] = share.mul_add(value, sums.values[k]);
                sums.slopes[k] = share.mul_add(slope, sums.slopes[k]);
                sums.by_rate[k] = R::select(inside, value * per, sums.by_rate[k]);
            }
        }
        sums
    }
}

/// The law of a tabulated rubber or foam with an overstress.
pub(super) struct RateRubber {
    pub(super) rubber: TabulatedRubber,
    pub(super) steps: RateSteps,
}

impl RateRubber {
    /// Returns the part of J times the stress along the principal directions that follows from sums
    /// f, without the pressure of the bulk modulus.
    #[inline(always)]
    fn forces<R: Real>(&self, sums: &[R; 4]) -> [R; 3] {
        match self.rubber.volume {
            Volume::Rubber(_) => std::array::from_fn(|i| {
                let apart = (sums[i] - sums[(i + 1) % 3]) + (sums[i] - sums[(i + 2) % 3]);
                R::splat(1.0 / 3.0) * apart
            }),
            Volume::Foam(_) => std::array::from_fn(|i| sums[i] - sums[3]),
        }
    }

    #[inline(always)]
    fn solid<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let state = point.state;
        let b = stretch(&std::array::from_fn(|c| state[STRETCH + c]), point.strain);
        let lowest = self.rubber.stress(&b);
        let [mut shear, mut volumetric] = self.rubber.moduli(&b);
        let (principal, volume, strains, by_volume) = self.rubber.arguments(&b);
        let power = self.rubber.power();
        let all = [strains[0], strains[1], strains[2], by_volume]
            .map(|strain| CurveTerms::new(power, strain));
        // Only foam has a term of the volume.
        let terms = match self.rubber.volume {
            Volume::Rubber(_) => &all[..3],
            Volume::Foam(_) => &all[..],
        };
        // 1. The rate of the direction whose strain changes fastest.
        let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let half = |c: usize| R::splat(if c < 3 { per_dt } else { 0.5 * per_dt });
        let d = principal.normal(&std::array::from_fn(|c| half(c) * point.strain[c]));
        let stretches: [R; 3] = match self.steps.nominal {
            true => principal.values.map(|value| (one + value).sqrt()),
            false => [one; 3],
        };
        let (mut fastest, mut along) = (zero, one);
        for k in 0..3 {
            let is_faster = d[k].abs().gt(fastest);
            along = R::select(is_faster, stretches[k], along);
            fastest = R::select(is_faster, d[k].abs(), fastest);
        }
        // 2. Its running mean.
        let old = Real::max(state[RATE], zero);
        let change = along * fastest - old;
        let steps = match self.steps.averaging {
            0.0 => STEPS_OF_MEAN,
            time if dt > 0.0 => (time / dt).max(STEPS_OF_MEAN),
            _ => STEPS_OF_MEAN,
        };
        let share = R::splat(1.0 / steps);
        let viscosity = |rate: R| {
            let forces = self.forces(&self.steps.sums(rate, terms).by_rate).map(R::abs);
            along * Real::max(Real::max(forces[0], forces[1]), forces[2])
        };
        let viscosity = Real::max(viscosity(old), viscosity(share.mul_add(change, old)));
        let most = R::splat(self.steps.rise * dt) / Real::max(viscosity, R::splat(R::SMALLEST));
        let rate = Real::min(share, most).mul_add(change, old);
        // 3. The overstress, where it takes work.
        let sums = self.steps.sums(rate, terms);
        let forces = self.forces(&sums.values);
        // Below the lowest rate there is none yet, and the mean goes on.
        let acts = R::both(dot(forces, d).ge(zero), fastest.gt(zero));
        let over = principal.compose(forces.map(|force| R::select(acts, force / volume, zero)));
        let stress: Symmetric<R> = std::array::from_fn(|c| lowest[c] + over[c]);
        // 4. The modulus of the step.
        let [x, y, z, by_volume] = sums.slopes.map(|slope| Real::max(slope, zero) / volume);
        shear += Real::max(Real::max(x, y), z) + R::splat(self.steps.rise) / volume;
        if let Volume::Foam(beta) = self.rubber.volume {
            volumetric += R::splat(beta) * by_volume;
        }
        let ratio = stiffening(&self.rubber.elastic(), &stress, [shear, volumetric]);
        state[..STRETCH].copy_from_slice(&stress);
        state[STRETCH..STIFFENING].copy_from_slice(&b);
        let strained = inner(&b, &b).gt(zero);
        state[STIFFENING] = R::select(strained, Real::max(ratio, zero), zero);
        state[RATE] = R::select(acts, rate, zero);
        one
    }
}

impl Solid for RateRubber {
    fn history(&self) -> &'static [&'static str] {
        HISTORY
    }
    fn tensors(&self) -> usize {
        1
    }
    fn elastic(&self) -> Elastic {
        self.rubber.elastic()
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
#[path = "by_rate_tests.rs"]
mod tests;
