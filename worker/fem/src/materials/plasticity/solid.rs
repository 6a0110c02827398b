//! Three dimensions: radial return of Simo & Hughes 1998, box 3.1. With the deviator s of the
//! elastic trial,
//! ```text
//! sig_vm = sqrt(3/2 s:s),   sig_vm - 3 G y = sig_y(eps_p + y),   s <- s (1 - 3 G y / sig_vm)
//! ```
//! If hardening consists of straight lines, the equation for y = d eps_p is solved without
//! iteration: from the slope at eps_p, then corrected for each bend of the curve below the
//! solution. For a power law Newton steps from y = 0 solve it: hardening is concave, so the steps
//! never overshoot.

use super::{Damage, Plasticity, YieldCurve, tolerance};
use crate::materials::{Elastic, Solid, SolidPoint};
use crumple_math::lanes::{Lane, Lane32, Real, dot};

/// Columns of stress: xx, yy, zz, xy, yz, zx.
const STRESS: usize = 6;
/// Column of the effective plastic strain.
const STRAIN: usize = STRESS;
/// Largest number of Newton steps; three to six are enough.
const NEWTON_STEPS: usize = 60;

impl Plasticity {
    #[inline(always)]
    fn solid_stress<R: Real, const COLUMNS: usize>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let third = R::splat(1.0 / 3.0);
        let g = R::splat(self.coefficients.shear);
        let bulk = R::splat(self.coefficients.bulk);
        let one = R::splat(1.0);
        let Some(state) = point.state.first_chunk_mut::<COLUMNS>() else { return one };
        let eps = point.strain;

        // 1. Elastic trial, as mean and deviator.
        let bulk_strain = eps[0] + eps[1] + eps[2];
        let third_strain = third * bulk_strain;
        let old_mean = third * (state[0] + state[1] + state[2]);
        let mean = bulk.mul_add(bulk_strain, old_mean);
        let e: [R; 3] = std::array::from_fn(|c| eps[c] - third_strain);
        let direct: [R; 3] = std::array::from_fn(|c| (g + g).mul_add(e[c], state[c] - old_mean));
        let shear: [R; 3] = std::array::from_fn(|c| g.mul_add(eps[3 + c], state[3 + c]));

        // 2. Yield, in units of the initial yield stress.
        let per_yield = R::splat(self.coefficients.per_yield);
        let size = R::splat(1.5) * (dot(direct, direct) + R::splat(2.0) * dot(shear, shear));
        let trial = size.sqrt() * per_yield;
        let square = || {
            let sheared = [eps[3], eps[4], eps[5]];
            dot(e, e) + R::splat(0.5) * dot(sheared, sheared)
        };
        let (sig_y, modulus) = self.yield_curve(state[STRAIN]);
        let mut scale = self.thermal_factor(&state[STRAIN..]);
        let mut over = trial.gt(scale * sig_y);
        if self.rate.counts() && R::any(over) {
            scale = scale * self.rate_factor(square(), self.rate.of_unit_strain(dt), over);
            over = trial.gt(scale * sig_y);
        }
        if COLUMNS > STRAIN + 1 {
            over = R::both(over, Self::alive(&state[STRAIN..]));
        }

        // 3. Return.
        let mut factor = one;
        if R::any(over) {
            let start = Trial {
                stress: trial,
                three_g: R::splat(3.0) * g * per_yield,
                scale,
                eps_p: state[STRAIN],
            };
            let y = R::select(over, self.radial(&start, sig_y, modulus, over), R::zero());
            let returned = start.three_g.neg_mul_add(y, trial);
            factor = R::select(over, returned / trial, one);
            state[STRAIN] += y;
            if COLUMNS > STRAIN + 1 {
                let damage =
                    Damage { y, sig_y: returned, mean: mean * per_yield, square: square(), dt };
                self.accumulate_damage(&damage, over, &mut state[STRAIN..]);
            }
        }
        for c in 0..3 {
            state[c] = factor.mul_add(direct[c], mean);
            state[3 + c] = factor * shear[c];
        }
        if COLUMNS > STRAIN + 1 {
            Self::zero_failed(state, STRAIN);
        }
        factor
    }

    /// Returns the plastic strain increment that returns a trial beyond yield.
    #[inline(always)]
    fn radial<R: Real>(&self, trial: &Trial<R>, sig_y: R, modulus: R, over: R::Mask) -> R {
        let &Trial { stress, three_g, scale, eps_p } = trial;
        let mut slope = scale.mul_add(modulus, three_g);
        let mut y = (stress - scale * sig_y) / slope;
        match &self.curve {
            YieldCurve::Lines { ramps, .. } => {
                for &(start, change) in ramps {
                    let bend = R::splat(start) - eps_p;
                    // The slope includes bends before eps_p already.
                    let ahead = R::both(bend.ge(R::zero()), y.gt(bend));
                    let steeper = scale.mul_add(R::splat(change), slope);
                    y = R::select(ahead, bend + (y - bend) * (slope / steeper), y);
                    slope = R::select(ahead, steeper, slope);
                }
            }
            YieldCurve::Power { .. } => {
                for _ in 0..NEWTON_STEPS {
                    let (sig_y, modulus) = self.yield_curve(eps_p + y);
                    let beyond = three_g.neg_mul_add(y, stress) - scale * sig_y;
                    let active =
                        R::both(over, beyond.abs().gt(R::splat(tolerance::<R>()) * scale * sig_y));
                    if !R::any(active) {
                        break;
                    }
                    y = R::select(active, y + beyond / scale.mul_add(modulus, three_g), y);
                }
            }
        }
        y
    }

    #[inline(always)]
    fn point<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        match self.names().len() {
            1 => self.solid_stress::<R, 7>(point, dt),
            _ => self.solid_stress::<R, 10>(point, dt),
        }
    }
}

/// A trial stress to be returned, in units of the initial yield stress.
struct Trial<R> {
    /// Von Mises stress of the trial.
    stress: R,
    three_g: R,
    /// Factor of rate and temperature on the yield stress.
    scale: R,
    /// Plastic strain before the step.
    eps_p: R,
}

impl Solid for Plasticity {
    fn history(&self) -> &'static [&'static str] {
        self.names()
    }
    fn adds_stress(&self) -> bool {
        true
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) -> Lane {
        self.point(point, dt)
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, dt: f64) -> Lane32 {
        self.point(point, dt)
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) -> f64 {
        self.point(point, dt)
    }
}

#[cfg(test)]
#[path = "solid_tests.rs"]
mod tests;
