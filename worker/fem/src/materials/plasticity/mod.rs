//! Plastic flow with the von Mises condition and isotropic hardening, shared by several laws.
//! They return the elastic trial to the yield surface along the flow rule, for any size of step:
//! in plane stress by `plane_stress`, in three dimensions by `solid`. Stresses are in units of
//! the initial yield stress. Their powers then neither overflow nor underflow, in any units of
//! the job.
//!
//! The yield stress is `sig_y(eps_p)` times a factor of the rate and a factor of the temperature.
//! Both are constant over the step: the rate is that of the total strain increment, the
//! temperature that before the step.
//!
//! Columns after stress: the effective plastic strain; if the law heats or fails, also the
//! temperature rise, damage (failure at 1) and `failed` (0 or 1). A failed point has no stress
//! and no plastic flow from then on.

pub mod combined;
mod plane_stress;
pub mod softening;
mod solid;

use super::Elastic;
use crumple_math::lanes::Real;

/// Largest distance of a returned stress from the yield surface, as a fraction of the yield
/// stress.
const TOLERANCE: f64 = 1e-10;
/// The same tolerance for single precision, in units of its epsilon: the round-off of the
/// condition.
const ROUND_OFF: f64 = 16.0;
/// A power law is a straight line up to this plastic strain, since its slope is infinite at zero.
const POWER_START: f64 = 1e-5;
/// Smallest factor of temperature: molten material keeps this fraction of its yield stress.
const LEAST_THERMAL: f64 = 1e-3;
/// Smallest strain to failure of the formula of Johnson and Cook, which can be negative.
const LEAST_FAILURE_STRAIN: f64 = 1e-6;
/// Largest mean stress over von Mises stress for which the formula of Johnson and Cook is valid.
const LARGEST_TRIAXIALITY: f64 = 1.5;

/// Columns after the effective plastic strain: temperature rise, damage, `failed`.
const TEMPERATURE_RISE: usize = 1;
const DAMAGE: usize = 2;
const FAILED: usize = 3;

/// Returns the tolerance of a returned stress with this scalar, as a fraction of the yield
/// stress.
fn tolerance<R: Real>() -> f64 {
    TOLERANCE.max(ROUND_OFF * R::EPSILON)
}

/// A plastic law.
pub struct Plasticity {
    /// Elastic constants.
    pub elastic: Elastic,
    /// Yield stress at zero plastic strain [force/length^2].
    pub yield_stress: f64,
    /// Hardening.
    pub curve: YieldCurve,
    /// Dependence on the strain rate.
    pub rate: Rate,
    /// Dependence on the temperature, if any.
    pub thermal: Option<Thermal>,
    /// Failure of points.
    pub failure: FailureCriterion,
    /// Coefficients of the updates, from the elastic constants and the yield stress.
    pub coefficients: Coefficients,
}

/// Coefficients of the updates. They are stored because their quotients would take a fifth of an
/// update of a group.
pub struct Coefficients {
    /// See [`Elastic::plane_stress`] [force/length^2].
    plane_stress: [f64; 3],
    /// See [`Elastic::thinning`] [length^2/force].
    thinning: f64,
    /// Shear and bulk modulus [force/length^2].
    shear: f64,
    bulk: f64,
    /// Slopes of alpha and beta in y without hardening, in units of the initial yield stress; see
    /// `plane_stress`.
    moduli: [f64; 2],
    /// Factors of the square of the equivalent stress in plane stress; see [`Anisotropy`].
    anisotropy: Anisotropy,
    /// 1 over the initial yield stress [length^2/force], and over its square.
    per_yield: f64,
    per_yield2: f64,
}

/// Factors `[c, d]` of the square of the equivalent stress in plane stress,
/// `c (sig_x + sig_y)^2 + d ((sig_y - sig_x)^2 + 4 sig_xy^2)`: Hill 1948 with the same properties
/// in all directions of the sheet.
#[derive(Clone, Copy)]
pub struct Anisotropy([f64; 2]);

impl Anisotropy {
    /// The von Mises stress.
    pub const NONE: Self = Self::new(1.0);

    /// Computes the factors from Lankford's coefficient R, the ratio of the plastic strains across
    /// and through the sheet in uniaxial tension.
    pub const fn new(lankford: f64) -> Self {
        let c = 0.5 / (1.0 + lankford);
        Self([c, (1.0 + 2.0 * lankford) * c])
    }

    /// Returns the factors of `(sig_x + sig_y)^2`, `(sig_y - sig_x)^2` and `sig_xy^2`.
    fn factors(self) -> [f64; 3] {
        let Self([c, d]) = self;
        [c, d, 4.0 * d]
    }
}

impl Coefficients {
    /// Computes the coefficients from the elastic constants and the initial yield stress
    /// [force/length^2].
    pub fn new(elastic: &Elastic, yield_stress: f64) -> Self {
        Self::anisotropic(elastic, yield_stress, Anisotropy::NONE)
    }

    /// Computes the coefficients for sheets with this anisotropy.
    pub fn anisotropic(elastic: &Elastic, yield_stress: f64, anisotropy: Anisotropy) -> Self {
        let Elastic { youngs_modulus, poisson, .. } = *elastic;
        let shear = elastic.shear_modulus();
        let Anisotropy([c, d]) = anisotropy;
        let moduli = [2.0 * c * youngs_modulus / (1.0 - poisson), 4.0 * d * shear];
        Self {
            plane_stress: elastic.plane_stress(),
            thinning: elastic.thinning(),
            shear,
            bulk: elastic.bulk_modulus(),
            moduli: moduli.map(|m| m / yield_stress),
            anisotropy,
            per_yield: 1.0 / yield_stress,
            per_yield2: 1.0 / (yield_stress * yield_stress),
        }
    }
}

/// Yield stress over plastic strain, in units of the initial yield stress.
pub enum YieldCurve {
    /// Straight lines.
    Lines {
        /// First slope.
        slope: f64,
        /// Plastic strains at which the slope changes, and the change.
        ramps: Vec<(f64, f64)>,
    },
    /// `1 + b eps_p^n`, 0 < n <= 1, and at most `largest`.
    Power {
        /// Factor on the power.
        b: f64,
        /// Exponent.
        n: f64,
        /// Largest value, infinite for none.
        largest: f64,
    },
}

impl YieldCurve {
    /// Creates straight lines from slopes in the units of the job.
    pub fn lines(yield_stress: f64, slope: f64, ramps: &[(f64, f64)]) -> Self {
        let ramps = ramps.iter().map(|&(start, change)| (start, change / yield_stress)).collect();
        Self::Lines { slope: slope / yield_stress, ramps }
    }
}

/// Factor of the strain rate on the yield stress, at least one.
pub enum Rate {
    /// One.
    None,
    /// `1 + (rate/c)^inv_p`.
    CowperSymonds {
        /// Rate at which the yield stress is doubled [1/time].
        c: f64,
        /// Exponent 1/p.
        inv_p: f64,
    },
    /// `1 + c ln(rate/reference)` above the reference rate.
    Logarithmic {
        /// Factor on the logarithm.
        c: f64,
        /// Reference rate [1/time].
        reference: f64,
    },
}

impl Rate {
    /// Returns true if the yield stress depends on the rate.
    fn counts(&self) -> bool {
        !matches!(self, Rate::None)
    }

    /// Returns the strain rate of a unit of strain in the step `dt` [time], over the rate of the
    /// law. Laws with many points compute it once for all.
    fn of_unit_strain(&self, dt: f64) -> f64 {
        match self {
            Rate::None => 0.0,
            Rate::CowperSymonds { c: rate, .. } | Rate::Logarithmic { reference: rate, .. } => {
                per_time(dt * rate)
            }
        }
    }
}

/// Softening by temperature, `1 - T*^m` with T* the temperature rise over that to melting, and
/// heating by plastic work.
pub struct Thermal {
    /// Exponent of the homologous temperature.
    pub m: f64,
    /// Melting temperature minus initial temperature [temperature].
    pub to_melting: f64,
    /// Temperature rise per plastic strain at the initial yield stress [temperature].
    pub heating: f64,
}

/// Failure criterion of a point.
pub enum FailureCriterion {
    /// Points do not fail.
    None,
    /// Fails at this plastic strain.
    Strain(f64),
    /// Johnson & Cook 1985: strain to failure `(D1 + D2 exp(D3 sig*)) (1 + D4 ln rate*) (1 + D5
    /// T*)`. Damage is the sum of `d eps_p` over it. Rates are relative to the reference rate
    /// [1/time].
    JohnsonCook {
        /// D1 to D5.
        d: [f64; 5],
        /// Reference rate [1/time].
        reference: f64,
    },
}

/// Result of a step at a point; stresses in units of the initial yield stress.
struct Damage<R> {
    /// Plastic strain increment.
    y: R,
    /// Von Mises and mean stress after the step.
    sig_y: R,
    mean: R,
    /// `e:e` of the deviator of the strain increment.
    square: R,
    /// Step [time].
    dt: f64,
}

impl Plasticity {
    /// Returns the names of the columns after stress.
    fn names(&self) -> &'static [&'static str] {
        if self.thermal.is_none() && matches!(self.failure, FailureCriterion::None) {
            &["plastic_strain"]
        } else {
            &["plastic_strain", "temperature_rise", "damage", "failed"]
        }
    }

    /// Returns the yield stress and the plastic modulus at a plastic strain. It sums ramps and
    /// needs no search, so no lane waits for another.
    #[inline(always)]
    fn yield_curve<R: Real>(&self, eps_p: R) -> (R, R) {
        match &self.curve {
            YieldCurve::Lines { slope, ramps } => {
                let mut modulus = R::splat(*slope);
                let mut sig_y = modulus.mul_add(eps_p, R::splat(1.0));
                for &(start, change) in ramps {
                    let beyond = eps_p - R::splat(start);
                    let change = R::select(beyond.gt(R::zero()), R::splat(change), R::zero());
                    sig_y = change.mul_add(beyond, sig_y);
                    modulus += change;
                }
                (sig_y, modulus)
            }
            YieldCurve::Power { b, n, largest } => {
                let curved = eps_p.gt(R::splat(POWER_START));
                let at = R::select(curved, eps_p, R::splat(POWER_START));
                let secant = R::splat(*b) * at.powf_where(n - 1.0, R::zero().le(R::zero()));
                let sig_y = secant.mul_add(eps_p, R::splat(1.0));
                let modulus = R::select(curved, R::splat(*n), R::splat(1.0)) * secant;
                if largest.is_infinite() {
                    return (sig_y, modulus);
                }
                let below = sig_y.lt(R::splat(*largest));
                (R::select(below, sig_y, R::splat(*largest)), R::select(below, modulus, R::zero()))
            }
        }
    }

    /// Returns the yield stress of a point at zero rate [force/length^2]. `columns` are those
    /// after stress.
    #[inline(always)]
    pub fn static_yield_stress<R: Real>(&self, columns: &[R]) -> R {
        R::splat(self.yield_stress) * self.thermal_factor(columns) * self.yield_curve(columns[0]).0
    }

    /// Returns the factor of the rate in the lanes of `mask`, one in others. `square` is `e:e` of
    /// the deviator of the strain increment, `of_unit_strain` is [`Rate::of_unit_strain`].
    #[inline(always)]
    fn rate_factor<R: Real>(&self, square: R, of_unit_strain: f64, mask: R::Mask) -> R {
        let one = R::splat(1.0);
        let rate = effective_strain(square) * R::splat(of_unit_strain);
        let factor = match self.rate {
            Rate::None => return one,
            Rate::CowperSymonds { inv_p, .. } => one + rate.powf_where(inv_p, mask),
            Rate::Logarithmic { c, .. } => R::splat(c).mul_add(logarithm(rate), one),
        };
        R::select(mask, factor, one)
    }

    /// Returns the factor of the temperature. `columns` are those after stress.
    #[inline(always)]
    fn thermal_factor<R: Real>(&self, columns: &[R]) -> R {
        let one = R::splat(1.0);
        let Some(thermal) = &self.thermal else { return one };
        let homologous = self.homologous(columns);
        let warm = homologous.gt(R::zero());
        let power = R::select(warm, homologous.powf_where(thermal.m, warm), R::zero());
        Real::max(one - power, R::splat(LEAST_THERMAL))
    }

    /// Returns T*, at most one.
    #[inline(always)]
    fn homologous<R: Real>(&self, columns: &[R]) -> R {
        match &self.thermal {
            Some(thermal) => Real::min(
                columns[TEMPERATURE_RISE] * R::splat(1.0 / thermal.to_melting),
                R::splat(1.0),
            ),
            None => R::zero(),
        }
    }

    /// Adds heat and damage in the lanes of `mask`.
    #[inline(always)]
    fn accumulate_damage<R: Real>(&self, step: &Damage<R>, mask: R::Mask, columns: &mut [R]) {
        let one = R::splat(1.0);
        let homologous = self.homologous(columns);
        if let Some(thermal) = &self.thermal {
            let rise =
                R::splat(thermal.heating).mul_add(step.sig_y * step.y, columns[TEMPERATURE_RISE]);
            columns[TEMPERATURE_RISE] = R::select(mask, rise, columns[TEMPERATURE_RISE]);
        }
        let limit = match self.failure {
            FailureCriterion::None => return,
            FailureCriterion::Strain(limit) => R::splat(limit),
            FailureCriterion::JohnsonCook { d: [d1, d2, d3, d4, d5], reference } => {
                let triaxiality = Real::min(step.mean / step.sig_y, R::splat(LARGEST_TRIAXIALITY));
                let first = R::splat(d2).mul_add((R::splat(d3) * triaxiality).exp(), R::splat(d1));
                let rate = logarithm(effective_rate(step.square, step.dt * reference));
                let limit =
                    first * R::splat(d4).mul_add(rate, one) * R::splat(d5).mul_add(homologous, one);
                Real::max(limit, R::splat(LEAST_FAILURE_STRAIN))
            }
        };
        let damage = R::select(mask, columns[DAMAGE] + step.y / limit, columns[DAMAGE]);
        columns[DAMAGE] = damage;
        // Round-off of the sum must not delay failure by a step.
        columns[FAILED] = R::select(
            damage.ge(R::splat(1.0 - f64::max(1e-12, ROUND_OFF * R::EPSILON))),
            one,
            columns[FAILED],
        );
    }

    /// Returns the lanes that have not failed. `columns` are those after stress.
    #[inline(always)]
    fn alive<R: Real>(columns: &[R]) -> R::Mask {
        columns[FAILED].lt(R::splat(0.5))
    }

    /// Sets the stress of failed lanes, the first `stress` columns, to zero.
    #[inline(always)]
    fn zero_failed<R: Real>(state: &mut [R], stress: usize) {
        let alive = Self::alive(&state[stress..]);
        state[..stress].iter_mut().for_each(|s| *s = R::select(alive, *s, R::zero()));
    }
}

/// Returns the effective rate of a strain increment over a time, `sqrt(2/3 e:e)/time`. `square`
/// is `e:e` of its deviator.
#[inline(always)]
fn effective_rate<R: Real>(square: R, time: f64) -> R {
    effective_strain(square) * R::splat(per_time(time))
}

/// Returns the effective strain, `sqrt(2/3 e:e)`.
#[inline(always)]
fn effective_strain<R: Real>(square: R) -> R {
    (R::splat(2.0 / 3.0) * square).sqrt()
}

/// Returns 1 over a time, zero for none.
#[inline(always)]
fn per_time(time: f64) -> f64 {
    if time > 0.0 { 1.0 / time } else { 0.0 }
}

/// Returns the logarithm, zero below one.
#[inline(always)]
fn logarithm<R: Real>(ratio: R) -> R {
    Real::max(ratio, R::splat(1.0)).ln()
}
