//! Open-celled foam of ribs of side impact dummies, as in `*MAT_VISCOUS_FOAM`: a nonlinear spring
//! next to a spring and a damper in series,
//! ```text
//! d sigma_1 = C(E_1 V^-n) e,    d sigma_2 = C(E_2) e - sigma_2 E_2/eta dt,    eta = c |1 - V|^m
//! ```
//! with the strain increment e, the elasticity C of a Young's modulus and of `poisson`, and the
//! ratio V of the volume to that at the start. The damper takes energy; the spring in series with
//! it bounds the step; the spring next to it bounds the compression. From memory of the LS-DYNA
//! Theory Manual (material 62).
//!
//! The mean stress of the first spring is a function of the volume,
//! `K (1 - V^-n)/n` with the bulk modulus K at the start. All else is exact for moduli of the
//! middle of the step and a constant strain rate in it. The sum over increments that the source has
//! does not follow from an energy: foam that is sheared, then stretched and sheared back could do
//! work. So a point keeps the work that was put into all but that mean stress, and lowers the rest
//! of its stress where this and a next step would give more back.
//!
//! The element computes in double precision. The step follows the modulus at the volume after a
//! next step like this one.
//!
//! Valid for foam that has regained its form before it is loaded again.

use super::parameters::Parameters;
use super::tensor::{Symmetric, inner, trace};
use super::{
    DefaultValue, ELASTIC, Elastic, Form, Law, ParameterRow, Solid, SolidLawResult, SolidPoint,
    VOLUME_COLUMN,
};
use crumple_math::lanes::{Lane, Lane32, Real};
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

const STIFFENS: &str = "stiffness_exponent";
const VISCOSITY: &str = "viscous_coefficient";
const SERIES: &str = "viscous_modulus";
const THICKENS: &str = "viscous_exponent";

const fn number(key: &'static str, otherwise: DefaultValue, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise, range: None, meaning }
}

/// The row of this law.
pub const LAW: Law = Law {
    name: "viscous_foam",
    meaning: "Foam with a damper that grows with the change of volume; `youngs_modulus` is that of \
              slow loads at the start.",
    constants: ELASTIC,
    parameters: &[
        number(
            STIFFENS,
            DefaultValue::Number(0.0),
            "n, 0 or above: the modulus of slow loads is multiplied by V^-n.",
        ),
        number(
            VISCOSITY,
            DefaultValue::Needed,
            "c of the viscosity c |1 - V|^m, 0 or above [force*time/length^2].",
        ),
        number(
            SERIES,
            DefaultValue::Needed,
            "Young's modulus of the spring in series with the damper; it bounds the step \
             [force/length^2].",
        ),
        number(THICKENS, DefaultValue::Number(0.0), "m of the viscosity, 0 or above."),
    ],
    build: None,
    solid: Some(solid),
    cohesive: None,
};

/// Columns with those of the stress: the stress of the damper, then these.
const VISCOUS: usize = 6;
const VOLUME: usize = 12;
const WORK: usize = 13;
const STIFFENING: usize = 14;
const HISTORY: [&str; 9] = [
    "viscous xx",
    "viscous yy",
    "viscous zz",
    "viscous xy",
    "viscous yz",
    "viscous zx",
    VOLUME_COLUMN,
    "work of shape and damper",
    "stiffening",
];

/// Largest ratio of a step to the time of relaxation; a damper of no viscosity has it.
const MOST_RELAXED: f64 = 1e12;
/// Ratio below which a series replaces the exponential.
const SHORT_STEP: f64 = 1e-3;

struct ViscousFoam {
    /// Constants of the bound of the step: E_1 + E_2.
    elastic: Elastic,
    /// E_1 and n.
    spring: (f64, f64),
    /// E_2.
    series: f64,
    /// c and m.
    damper: (f64, f64),
}

fn solid(material: &Material) -> SolidLawResult {
    Parameters::new(material).solid_law(read)
}

fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<ViscousFoam, Vec<Problem>> {
    let (wanted, fits) = ("0 or above", |x: f64| x >= 0.0);
    let stiffens = parameters.optional(STIFFENS, wanted, fits).unwrap_or(0.0);
    let viscosity = parameters.required(VISCOSITY, wanted, fits);
    let series = parameters.required(SERIES, wanted, fits);
    let thickens = parameters.optional(THICKENS, wanted, fits).unwrap_or(0.0);
    if viscosity > 0.0 && series == 0.0 && parameters.given(SERIES) {
        let help = "give a modulus above 0, or no viscosity";
        parameters.wrong(SERIES, "is 0: the damper would have no effect", help);
    }
    parameters.finish()?;
    Ok(ViscousFoam {
        elastic: Elastic { youngs_modulus: elastic.youngs_modulus + series, ..elastic },
        spring: (elastic.youngs_modulus, stiffens),
        series,
        damper: (viscosity, thickens),
    })
}

impl ViscousFoam {
    /// Returns the part of the stress of the damper that a step takes, and the part of its modulus
    /// that a strain of the step has, at this logarithm of the volume.
    #[inline(always)]
    fn relaxation<R: Real>(&self, volume: R, dt: f64) -> [R; 2] {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let (coefficient, exponent) = self.damper;
        let change = (one - volume.exp()).abs();
        let changes = change.gt(zero);
        let power = change.powf_where(exponent, changes);
        let at_start = R::splat(if exponent == 0.0 { 1.0 } else { 0.0 });
        let viscosity = R::splat(coefficient) * R::select(changes, power, at_start);
        let smallest = R::splat(1e-30);
        let x = R::splat(self.series * dt) / Real::max(viscosity, smallest);
        let x = Real::min(x, R::splat(MOST_RELAXED));
        let short = x.lt(R::splat(SHORT_STEP));
        let series = x.mul_add(x.mul_add(R::splat(1.0 / 6.0), R::splat(-0.5)), one);
        let mean = (one - (zero - x).exp()) / Real::max(x, R::splat(SHORT_STEP));
        let mean = R::select(short, series, mean);
        [x * mean, mean]
    }

    #[inline(always)]
    fn solid<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let (zero, one, half) = (R::zero(), R::splat(1.0), R::splat(0.5));
        let nu = self.elastic.poisson;
        // Per Young's modulus: twice the shear modulus, and the bulk modulus.
        let [shear, bulk] = [1.0 / (1.0 + nu), 1.0 / (3.0 * (1.0 - 2.0 * nu))].map(R::splat);
        let state = point.state;
        let strain: Symmetric<R> =
            std::array::from_fn(|c| if c < 3 { point.strain[c] } else { half * point.strain[c] });
        let growth = trace(&strain);
        let third = R::splat(1.0 / 3.0) * growth;
        let before = state[VOLUME];
        let after = before + growth;
        let middle = half.mul_add(growth, before);
        let (young, exponent) = self.spring;
        let power = |volume: R| (R::splat(-exponent) * volume).exp();

        // Spring: the mean stress at the start of the step, and its change, both of the volume.
        let stiff = R::splat(young) * power(middle);
        let of_volume = |volume: R| {
            if exponent == 0.0 {
                R::splat(young) * bulk * volume
            } else {
                R::splat(young / exponent) * bulk * (one - power(volume))
            }
        };
        let (mean, next_mean) = (of_volume(before), of_volume(after));
        let old: Symmetric<R> = std::array::from_fn(|c| {
            state[c] - state[VISCOUS + c] - if c < 3 { mean } else { zero }
        });
        let shape: Symmetric<R> =
            std::array::from_fn(|c| if c < 3 { strain[c] - third } else { strain[c] });
        let new: Symmetric<R> = std::array::from_fn(|c| (stiff * shear).mul_add(shape[c], old[c]));

        // Damper.
        let [lost, left] = self.relaxation(middle, dt);
        let series = R::splat(self.series) * left;
        let old_viscous: Symmetric<R> = std::array::from_fn(|c| state[VISCOUS + c]);
        let new_viscous: Symmetric<R> = std::array::from_fn(|c| {
            let pressed = if c < 3 { series * bulk * growth } else { zero };
            let more = (series * shear).mul_add(shape[c], pressed);
            lost.neg_mul_add(old_viscous[c], old_viscous[c]) + more
        });

        // Work per volume at the start.
        let per_start = half * middle.exp();
        let of_old = per_start * (inner(&old, &strain) + inner(&old_viscous, &strain));
        let of_new = per_start * (inner(&new, &strain) + inner(&new_viscous, &strain));
        let known = state[WORK] + of_old;
        // The next step will give as much again.
        let most = half * Real::max(known, zero);
        let gives = (zero - of_new).gt(most);
        let part = R::select(gives, most / (zero - of_new), one);
        state[WORK] = part.mul_add(of_new, known);
        for c in 0..6 {
            let viscous = part * new_viscous[c];
            state[VISCOUS + c] = viscous;
            let mean = if c < 3 { next_mean } else { zero };
            state[c] = part.mul_add(new[c], viscous) + mean;
        }
        state[VOLUME] = after;
        let modulus = R::splat(young) * (power(after - growth.abs()) - one);
        let over = modulus / R::splat(self.elastic.youngs_modulus);
        state[STIFFENING] = Real::max(over, zero);
        one
    }
}

impl Solid for ViscousFoam {
    fn history(&self) -> &[&'static str] {
        &HISTORY
    }
    fn tensors(&self) -> usize {
        1
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn averages_volume(&self) -> bool {
        false
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
#[path = "viscous_foam_tests.rs"]
mod tests;
