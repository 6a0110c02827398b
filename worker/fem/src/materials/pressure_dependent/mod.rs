//! Materials whose pressure depends on the volume, and whose strength depends on the pressure:
//! ceramics, concrete, soil.
//! ```text
//! mu = rho/rho_0 - 1,   p = p(mu, history)
//! s <- s_trial Y/q where q > Y,   de = (q - Y)/(3 G)
//! ```
//! with the deviator s of the stress, its von Mises stress q, the strength Y in the pressure of the
//! same step, the plastic strain e and the shear modulus G. Flow keeps the volume. Each law has its
//! pressure, its strength and its damage. [`karagozian_case`] has a step of its own.
//!
//! Each lane is updated alone. Elements of these laws compute in double precision, since a small
//! increment of the volume changes the pressure by much.

pub mod ceramic;
mod compaction;
pub mod concrete;
pub mod karagozian_case;
pub mod soil;
#[cfg(test)]
mod tests;
mod three_surfaces;

use super::parameters::Parameters;
use super::tensor::{deviator, inner};
use super::{DefaultValue, Elastic, Form, ParameterRow, Solid, SolidPoint, VOLUME_COLUMN};
use crumple_math::lanes::{LANES, LANES32, Lane, Lane32, Lanes, Real};
use crumple_proto::partition::Param;

/// Components of the stress.
const STRESS: usize = 6;
/// Columns that all these laws have after the stress: the logarithm of the volume, stiffening,
/// plastic strain and failure. Those of a law follow.
const VOLUME: usize = 6;
const STIFFENING: usize = 7;
const PLASTIC: usize = 8;
const FAILED: usize = 9;
const OWN: usize = 10;
/// Largest number of columns of a law, stress included.
const COLUMNS: usize = 16;

const SHEAR: &str = "shear_modulus";
const TENSION: &str = "tensile_strength";
const RATE: &str = "rate";
const STRONGEST: &str = "largest_strength";
const DAMAGE: &str = "damage";
const PRESSURE: &str = "pressure";
const FAILURE: &str = "failure_strain";
const TEARS: &str = "fails_in_tension";

/// Shear modulus as a parameter.
const SHEAR_MODULUS: ParameterRow =
    number(SHEAR, DefaultValue::Needed, "Shear modulus [force/length^2].");
/// Largest tension as a parameter.
const TENSILE_STRENGTH: ParameterRow = number(
    TENSION,
    DefaultValue::Needed,
    "Largest mean tensile stress of intact material [force/length^2]; damage D leaves (1 - D) of \
     it.",
);
/// Effect of the strain rate as a parameter.
const RATE_CONSTANTS: ParameterRow = list(
    RATE,
    "[C, reference rate]",
    "The strength is multiplied by 1 + C ln(rate/reference rate) at rates above it [-, 1/time].",
);
/// Damage as a parameter.
const DAMAGE_CONSTANTS: ParameterRow = list(
    DAMAGE,
    "[D1, D2]",
    "Plastic strain to fracture `D1 (p* + T*)^D2`, with the pressure and the tensile strength over \
     the reference stress of the law; D1 of 0: it breaks where it yields. Without it there is no \
     damage.",
);
const FAILURE_STRAIN: ParameterRow = number(
    FAILURE,
    DefaultValue::Absent,
    "Plastic strain at which an element fails; without it none does.",
);
const FAILS_IN_TENSION: ParameterRow = ParameterRow {
    key: TEARS,
    form: Form::Flag,
    otherwise: DefaultValue::Flag(false),
    range: None,
    meaning: "An element fails where its mean tension would exceed `tensile_strength`.",
};

const fn number(key: &'static str, otherwise: DefaultValue, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise, range: None, meaning }
}

const fn list(key: &'static str, form: &'static str, meaning: &'static str) -> ParameterRow {
    ParameterRow {
        key,
        form: Form::List(form),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning,
    }
}

const fn needed(key: &'static str, form: &'static str, meaning: &'static str) -> ParameterRow {
    ParameterRow { otherwise: DefaultValue::Needed, ..list(key, form, meaning) }
}

/// Returns an optional list of N numbers that `fits` accepts; `wanted` describes it.
fn constants<const N: usize>(
    parameters: &mut Parameters<'_>,
    key: &'static str,
    wanted: &str,
    fits: impl Fn(&[f64; N]) -> bool,
) -> Option<[f64; N]> {
    let found = match parameters.get(key)? {
        Param::List(list) => <[f64; N]>::try_from(list.as_slice()).ok(),
        _ => None,
    };
    let found = found.filter(|list| list.iter().all(|x| x.is_finite()) && fits(list));
    if found.is_none() {
        parameters.wrong(key, format_args!("is not {wanted}"), format!("give {wanted}"));
    }
    found
}

/// Returns a list that the law needs, or reports its error.
fn needed_constants<const N: usize>(
    parameters: &mut Parameters<'_>,
    key: &'static str,
    wanted: &str,
    fits: impl Fn(&[f64; N]) -> bool,
) -> Option<[f64; N]> {
    if !parameters.given(key) {
        parameters.wrong(key, "is missing", format!("give {wanted}"));
    }
    constants(parameters, key, wanted, fits)
}

/// Elastic constants at the start. Young's modulus would round the bulk modulus.
#[derive(Clone, Copy)]
struct VolumeElastic {
    /// Bulk modulus [force/length^2].
    bulk: f64,
    /// Shear modulus [force/length^2].
    shear: f64,
    density: f64,
}

impl VolumeElastic {
    fn constants(&self) -> Elastic {
        let &Self { bulk, shear, density } = self;
        let youngs_modulus = 9.0 * bulk * shear / (3.0 * bulk + shear);
        let poisson = (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear));
        Elastic { youngs_modulus, poisson, density }
    }
}

/// Reports constants of a pressure `K1 m + K2 m^2 + K3 m^3` that falls where m grows.
fn check_growth(parameters: &mut Parameters<'_>, [k1, k2, k3]: [f64; 3]) {
    // The slope is quadratic in m, with its least value at a positive m if K2 < 0.
    let falls = k2 < 0.0 && 3.0 * k1 * k3 <= k2 * k2 || k2 >= 0.0 && k3 < 0.0;
    if falls {
        let help = "use constants whose slope K1 + 2 K2 m + 3 K3 m^2 stays above 0";
        parameters.wrong(PRESSURE, "gives a pressure that falls in compression", help);
    }
}

/// Effect of the strain rate on the strength: C and the reference rate.
struct LogarithmicRate([f64; 2]);

impl LogarithmicRate {
    fn read(parameters: &mut Parameters<'_>) -> Self {
        let wanted = "[C, reference rate], C 0 or above and the rate above 0";
        let given = constants(parameters, RATE, wanted, |c: &[f64; 2]| c[0] >= 0.0 && c[1] > 0.0);
        Self(given.unwrap_or([0.0, 1.0]))
    }

    fn at(&self, rate: f64) -> f64 {
        let Self([coefficient, reference]) = self;
        coefficient.mul_add((rate / reference).max(1.0).ln(), 1.0)
    }
}

/// Limits at which an element fails.
struct FailureLimits {
    strain: f64,
    /// Mean tension.
    tension: f64,
}

impl FailureLimits {
    /// Reads the limits of a law with this tensile strength.
    fn read(parameters: &mut Parameters<'_>, tension: f64) -> Self {
        let strain = parameters.optional(FAILURE, "above 0", |strain| strain > 0.0);
        let tears = parameters.flag(TEARS);
        if tears && tension == 0.0 {
            let help = format!("give {TENSION} above 0, or remove it");
            parameters.wrong(TEARS, "is set without a tensile strength", help);
        }
        Self {
            strain: strain.unwrap_or(f64::INFINITY),
            tension: if tears { tension } else { f64::INFINITY },
        }
    }

    /// Returns true at this plastic strain, and the pressure that the volume gives without a limit
    /// of tension [force/length^2].
    fn are_reached(&self, strain: f64, pressure: f64) -> bool {
        strain >= self.strain || pressure < -self.tension
    }
}

/// Pressure that follows from the volume.
#[derive(Clone, Copy)]
struct VolumePressure {
    /// Pressure without a limit of tension [force/length^2].
    free: f64,
    /// Largest tension [force/length^2].
    tension: f64,
    /// Change of pressure by that of the logarithm of the density [force/length^2].
    modulus: f64,
}

/// Values of a point after a step.
struct PointStep {
    /// rho/rho_0 - 1.
    compaction: f64,
    /// Pressure without a limit of tension, and with it [force/length^2].
    free: f64,
    pressure: f64,
    /// Increment of the plastic strain, and the plastic strain after it.
    flow: f64,
    plastic_strain: f64,
    /// Strain rate [1/time].
    rate: f64,
}

/// A law that updates one point at a time.
trait PointLaw: Send + Sync {
    /// Returns the names of all columns after the stress, the common ones first.
    fn columns(&self) -> &'static [&'static str];

    /// Returns the elastic constants at the start.
    fn elastic(&self) -> &VolumeElastic;

    /// Updates a point over a step `dt` [time]. Returns the von Mises stress over that of the
    /// elastic trial.
    fn update(&self, state: &mut [f64], strain: &[f64; STRESS], dt: f64) -> f64;
}

impl<L: PressureDependent> PointLaw for L {
    fn columns(&self) -> &'static [&'static str] {
        PressureDependent::columns(self)
    }
    fn elastic(&self) -> &VolumeElastic {
        PressureDependent::elastic(self)
    }
    fn update(&self, state: &mut [f64], strain: &[f64; STRESS], dt: f64) -> f64 {
        update(self, state, strain, dt)
    }
}

/// A law whose flow keeps the volume, with a strength by pressure alone. `own` are its own columns.
trait PressureDependent: Send + Sync {
    /// Returns the names of all columns after the stress, the common ones first.
    fn columns(&self) -> &'static [&'static str];

    /// Returns the elastic constants at the start.
    fn elastic(&self) -> &VolumeElastic;

    /// Returns the pressure at a compaction `rho/rho_0 - 1`.
    fn pressure(&self, own: &mut [f64], compaction: f64) -> VolumePressure;

    /// Returns the largest von Mises stress in this pressure at this strain rate [force/length^2].
    fn strength(&self, own: &[f64], pressure: f64, rate: f64) -> f64;

    /// Advances the damage over a step. Returns true if the point fails.
    fn advance(&self, _own: &mut [f64], _step: &PointStep) -> bool {
        false
    }
}

/// Updates a point over a step `dt` [time]. Returns the von Mises stress over that of the elastic
/// trial.
fn update(law: &impl PressureDependent, state: &mut [f64], strain: &[f64; STRESS], dt: f64) -> f64 {
    if state[FAILED] >= 0.5 {
        state[..STRESS].fill(0.0);
        return 0.0;
    }
    state[VOLUME] += strain[0] + strain[1] + strain[2];
    let compaction = (-state[VOLUME]).exp_m1();
    let &VolumeElastic { bulk, shear: g, .. } = PressureDependent::elastic(law);
    let increments = [0, 1, 2, 3, 4, 5].map(|c| if c < 3 { strain[c] } else { 0.5 * strain[c] });
    let shape = deviator(&increments);
    let before: [f64; STRESS] = std::array::from_fn(|c| state[c]);
    let old = deviator(&before);
    let trial: [f64; STRESS] = std::array::from_fn(|c| (2.0 * g).mul_add(shape[c], old[c]));
    let (common, own) = state.split_at_mut(OWN);
    let VolumePressure { free, tension, modulus } = law.pressure(own, compaction);
    let pressure = free.max(-tension);
    let rate = if dt > 0.0 { (2.0 / 3.0 * inner(&shape, &shape)).sqrt() / dt } else { 0.0 };
    let mises = (1.5 * inner(&trial, &trial)).sqrt();
    let strength = law.strength(own, pressure, rate).max(0.0);
    let left = if mises > strength { strength / mises } else { 1.0 };
    let flow = (mises - strength).max(0.0) / (3.0 * g);
    common[PLASTIC] += flow;
    common[STIFFENING] = ((modulus - bulk) / (bulk + 4.0 / 3.0 * g)).max(0.0);
    let plastic_strain = common[PLASTIC];
    let step = PointStep { compaction, free, pressure, flow, plastic_strain, rate };
    if law.advance(own, &step) {
        common[FAILED] = 1.0;
        common[..STRESS].fill(0.0);
        return 0.0;
    }
    for c in 0..STRESS {
        common[c] = left * trial[c] - if c < 3 { pressure } else { 0.0 };
    }
    left
}

/// Updates so many lanes one by one; `lanes` makes one of their numbers.
#[inline(always)]
fn each_lane<R: Real>(
    law: &impl PointLaw,
    point: SolidPoint<'_, R>,
    dt: f64,
    (count, lanes): (usize, impl Fn(&[f64; LANES32]) -> R),
) -> R {
    let columns = STRESS + law.columns().len();
    let mut after = [[0.0; LANES32]; COLUMNS];
    let mut left = [1.0; LANES32];
    for lane in 0..count {
        let mut state: [f64; COLUMNS] =
            std::array::from_fn(|c| if c < columns { point.state[c].lane(lane) } else { 0.0 });
        let strain = std::array::from_fn(|c| point.strain[c].lane(lane));
        left[lane] = law.update(&mut state[..columns], &strain, dt);
        (0..columns).for_each(|c| after[c][lane] = state[c]);
    }
    point.state.iter_mut().zip(&after).for_each(|(column, after)| *column = lanes(after));
    lanes(&left)
}

impl<L: PointLaw> Solid for L {
    fn history(&self) -> &[&'static str] {
        PointLaw::columns(self)
    }
    fn elastic(&self) -> Elastic {
        PointLaw::elastic(self).constants()
    }
    fn averages_volume(&self) -> bool {
        false
    }
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) -> Lane {
        let lanes = |all: &[f64; LANES32]| Lane::from_array(std::array::from_fn(|k| all[k]));
        each_lane(self, point, dt, (LANES, lanes))
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, dt: f64) -> Lane32 {
        each_lane(self, point, dt, (LANES32, |all: &[f64; LANES32]| Lane32::from_array(*all)))
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) -> f64 {
        PointLaw::update(self, point.state, point.strain, dt)
    }
}
