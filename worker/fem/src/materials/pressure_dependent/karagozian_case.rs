//! Concrete with three surfaces of strength and damage by a curve (Malvar, Crawford, Wesevich &
//! Simons 1997), the K&C model, as in `*MAT_CONCRETE_DAMAGE_REL3`:
//! ```text
//! q <= r_f S(p/r_f, theta, eta(lambda)),   eta by a curve: 0 to 1 at its peak and back
//! d lambda = d e/(r_f (1 + p/(r_f f_t))^b),   b = b1 for p >= 0, b2 in tension
//! d lambda = b3 (1 - 10 q/|p|) d e_v   where the mean tension is at its limit, q < |p|/10
//! d e_p = omega dS/dp d e,   beyond the peak omega eta^edrop
//! ```
//! S is in [`three_surfaces`](super::three_surfaces), the pressure in
//! [`compaction`](super::compaction). e is the equivalent plastic strain, e_p the plastic dilation:
//! it presses the material, with the pressure of the volume without it. The deviator returns along
//! its radius, so omega takes the part of the flow along p that is associated. Mean tension is at
//! most r_f f_t, beyond the peak eta of it, and no more than where it has torn before.
//!
//! The factor r_f of the rate is a curve, with rates below 0 for tension; between p = 0 and
//! `p = f_c/3` it goes from that of tension to that of compression. The shear modulus follows that
//! of unloading by Poisson's ratio. It only grows, so that no path gives energy by it.
//!
//! The factor k_d of b3 in the source is 1 here. Left out: damage that depends on the size of the
//! element, so that the energy of a crack is in proportion to it.

use super::super::parameters::Parameters;
use super::super::tensor::{Symmetric, deviator, inner, square};
use super::super::{DefaultValue, Law, SolidLawResult};
use super::compaction::CompactionTable;
use super::three_surfaces::{DamageState, ThreeSurfaces, bar_strength};
use super::*;
use crate::materials::polyline::{Beyond, RampCurve};
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

const POISSON: &str = "poisson";
const LARGEST: &str = "largest_surface";
const FIRST: &str = "yield_surface";
const RESIDUAL: &str = "residual_surface";
const CURVE: &str = "damage_curve";
const SCALING: &str = "damage_scaling";
const DILATANCY: &str = "dilatancy";
const FACTORS: &str = "rate_factors";
const COMPACTION: &str = "compaction";
/// Mises stress over the mean tension below which tension along all axes makes damage.
const TRIAXIAL: f64 = 0.1;
/// Least `1 + p/f_t`: lambda grows without bounds there.
const LEAST: f64 = 1e-9;

/// The row of this law.
pub const LAW: Law = Law {
    name: "karagozian_case_concrete",
    meaning: "Concrete with three surfaces of strength, damage by a curve and compaction (K&C).",
    constants: &[],
    parameters: &[
        number(POISSON, DefaultValue::Needed, "Poisson's ratio."),
        number(TENSION, DefaultValue::Needed, "Strength f_t in uniaxial tension [force/length^2]."),
        needed(
            LARGEST,
            "[a0, a1, a2]",
            "Largest strength `a0 + p/(a1 + a2 p)` in triaxial compression [stress, 1, 1/stress].",
        ),
        needed(
            FIRST,
            "[a0y, a1y, a2y]",
            "Strength at first yield, as `largest_surface` [stress, 1, 1/stress].",
        ),
        needed(
            RESIDUAL,
            "[a1f, a2f]",
            "Strength without cohesion, `p/(a1f + a2f p)` [1, 1/stress].",
        ),
        needed(
            CURVE,
            "[[lambda, eta], ...]",
            "Part eta of the largest surface over the modified plastic strain lambda, from [0, \
             eta] on, rising to a peak of 1 and falling behind it.",
        ),
        needed(
            SCALING,
            "[b1, b2, b3]",
            "Growth of lambda: exponents in compression and tension, and factor of tension along \
             all axes.",
        ),
        list(
            DILATANCY,
            "[omega, edrop]",
            "Part of the associated dilation from 0 to 1, and exponent of its fall with eta behind \
             the peak; without it flow keeps the volume.",
        ),
        list(
            FACTORS,
            "[[rate, factor], ...]",
            "Factor of the strength over the strain rate [1/time], in tension over rates below 0; \
             constant beyond the ends.",
        ),
        needed(
            COMPACTION,
            "[[volume strain, pressure, bulk modulus], ...]",
            "Pressure over -ln V in loading, and modulus of unloading from there, from [0, 0, bulk \
             modulus] on [-, force/length^2, force/length^2].",
        ),
    ],
    build: None,
    solid: Some(solid),
    cohesive: None,
};

/// Own columns: lambda, plastic dilation, largest compaction, damage, and the least mean tension at
/// which the material has torn, 0 before [force/length^2].
const LAMBDA: usize = 0;
const DILATION: usize = 1;
const MOST: usize = 2;
const BREAK: usize = 3;
const TORN_AT: usize = 4;

struct KaragozianCase {
    /// Elastic constants at the start.
    elastic: VolumeElastic,
    /// Shear modulus over the bulk modulus.
    shear_share: f64,
    surfaces: ThreeSurfaces,
    /// eta over lambda.
    eta: RampCurve,
    /// lambda of the peak of eta.
    peak: f64,
    /// b1, b2, b3.
    scaling: [f64; 3],
    /// omega, edrop.
    dilatancy: [f64; 2],
    factors: Option<RampCurve>,
    compaction: CompactionTable,
}

fn solid(material: &Material) -> SolidLawResult {
    Ok(Box::new(read(Parameters::new(material))?))
}

fn read(mut parameters: Parameters<'_>) -> Result<KaragozianCase, Vec<Problem>> {
    let table = &mut parameters;
    let density = table.density();
    let poisson = table.required(POISSON, "from 0 and below 0.5", |nu| (0.0..0.5).contains(&nu));
    let tension = table.required(TENSION, "above 0", |t| t > 0.0);
    let sound = |s: &[f64; 3]| s[0] > 0.0 && s[1] > 0.0 && s[2] >= 0.0;
    let wanted = "[a0, a1, a2], the first two above 0, the last 0 or above";
    let largest = needed_constants(table, LARGEST, wanted, sound);
    let wanted = "[a0y, a1y, a2y], the first two above 0, the last 0 or above";
    let first = needed_constants(table, FIRST, wanted, sound);
    let wanted = "[a1f, a2f], the first above 0, the last 0 or above";
    let residual =
        needed_constants(table, RESIDUAL, wanted, |s: &[f64; 2]| s[0] > 0.0 && s[1] >= 0.0);
    let bar = largest.and_then(|surface| {
        let bar = bar_strength(surface);
        if bar.is_none() {
            let help = "use a1 above 1/3 or a2 above 0";
            table.wrong(LARGEST, "gives a bar in compression no strength", help);
        }
        bar
    });
    if bar.is_some_and(|bar| 3.0 * tension > bar) {
        let what = format!("is above a third of the strength {:?} of a bar", bar.unwrap_or(0.0));
        table.wrong(TENSION, what, "concrete has about a tenth of it");
    }
    let (eta, peak) = damage_curve(table);
    let wanted = "[b1, b2, b3], b1 from 0 to 10, b2 from -10 to 10, b3 0 or above";
    let fits = |b: &[f64; 3]| (0.0..=10.0).contains(&b[0]) && b[1].abs() <= 10.0 && b[2] >= 0.0;
    let scaling = needed_constants(table, SCALING, wanted, fits);
    let wanted = "[omega, edrop], omega from 0 to 1, edrop 0 or above";
    let fits = |d: &[f64; 2]| (0.0..=1.0).contains(&d[0]) && d[1] >= 0.0;
    let dilatancy = constants(table, DILATANCY, wanted, fits);
    let form = ("[[rate, factor], ...]", "factors above 0");
    let factors = table.ascending(FACTORS, form, |point| point[1] > 0.0);
    let compaction = CompactionTable::read(table, COMPACTION);
    parameters.finish()?;
    let bulk = compaction.modulus(0.0);
    let shear_share = 1.5 * (1.0 - 2.0 * poisson) / (1.0 + poisson);
    // The lists are there: else there were problems.
    let [largest, first] = [largest, first].map(Option::unwrap_or_default);
    let strengths = [tension, bar.unwrap_or(1.0)];
    Ok(KaragozianCase {
        elastic: VolumeElastic { bulk, shear: shear_share * bulk, density },
        shear_share,
        surfaces: ThreeSurfaces::new([largest, first], residual.unwrap_or_default(), strengths),
        eta,
        peak,
        scaling: scaling.unwrap_or_default(),
        dilatancy: dilatancy.unwrap_or_default(),
        factors: factors.map(|points| RampCurve::new(&points, 1.0, Beyond::Constant)),
        compaction,
    })
}

/// Reads eta over lambda, and returns lambda of its peak.
fn damage_curve(parameters: &mut Parameters<'_>) -> (RampCurve, f64) {
    let wanted = ("eta from 0 to 1", |point: &[f64; 2]| (0.0..=1.0).contains(&point[1]));
    let points = parameters.curve(CURVE, "[[lambda, eta], ...]", wanted);
    if points.is_none() {
        parameters.wrong(CURVE, "is missing", "give [[0, 0], [lambda, eta], ...]");
    }
    let points = points.unwrap_or_default();
    let top = points.iter().position(|point| point[1] == 1.0);
    let (before, behind) = points.split_at(top.unwrap_or(0));
    let rises = before.windows(2).all(|two| two[0][1] <= two[1][1]);
    let falls = behind.windows(2).all(|two| two[0][1] >= two[1][1]);
    let has_peak = top.is_some_and(|top| top > 0) && rises && falls;
    if !points.is_empty() && !has_peak {
        let help = "let eta rise to 1 at some lambda above 0, and not rise behind it";
        parameters.wrong(CURVE, "has no peak of 1", help);
    }
    let peak = behind.first().map_or(1.0, |point| point[0]);
    (RampCurve::new(&points, 1.0, Beyond::Constant), peak)
}

/// Returns `cos 3 theta` of a deviator, 1 on the tensile meridian.
fn lode(shape: &Symmetric<f64>, mises: f64) -> f64 {
    // J3 is a third of the trace of the cube.
    let third = inner(&square(shape), shape) / 3.0;
    if mises > 0.0 { 13.5 * third / mises.powi(3) } else { -1.0 }
}

impl KaragozianCase {
    fn damage(&self, lambda: f64) -> DamageState {
        // The sum of ramps has round-off.
        let eta = self.eta.at(lambda)[0].clamp(0.0, 1.0);
        DamageState { eta, softens: lambda > self.peak }
    }

    /// Returns the factor of the strength in this pressure at this strain rate.
    fn factor(&self, pressure: f64, rate: f64) -> f64 {
        let Some(factors) = &self.factors else { return 1.0 };
        let share = (3.0 * pressure / self.surfaces.compression).clamp(0.0, 1.0);
        let [pulled, pressed] = [-rate, rate].map(|rate| factors.at(rate)[0]);
        pulled + share * (pressed - pulled)
    }

    fn strength(&self, pressure: f64, cos3: f64, damage: DamageState, rate: f64) -> f64 {
        let factor = self.factor(pressure, rate);
        factor * self.surfaces.strength(pressure / factor, cos3, damage)
    }

    /// Returns lambda after plastic flow and an expansion of the volume, in a pressure that the
    /// limit of tension may hold.
    fn grown(&self, lambda: f64, flow: f64, factor: f64, (pressure, torn): (f64, f64)) -> f64 {
        let [b1, b2, b3] = self.scaling;
        let over = (1.0 + pressure / (factor * self.surfaces.tension)).max(LEAST);
        let power = if pressure >= 0.0 { b1 } else { b2 };
        lambda + flow / (factor * over.powf(power)) + b3 * torn
    }
}

impl PointLaw for KaragozianCase {
    fn columns(&self) -> &'static [&'static str] {
        &[
            VOLUME_COLUMN,
            "stiffening",
            "plastic_strain",
            "failed",
            "modified plastic strain",
            "plastic dilation",
            "largest volume strain",
            "damage",
            "torn at",
        ]
    }

    fn elastic(&self) -> &VolumeElastic {
        &self.elastic
    }

    fn update(&self, state: &mut [f64], strain: &[f64; STRESS], dt: f64) -> f64 {
        let expansion = strain[0] + strain[1] + strain[2];
        state[VOLUME] += expansion;
        let (common, own) = state.split_at_mut(OWN);
        // 1. Trial stress with the moduli of the largest compaction so far.
        let before = self.compaction.modulus(own[MOST]);
        let shear = self.shear_share * before;
        let half = [0, 1, 2, 3, 4, 5].map(|c| if c < 3 { strain[c] } else { 0.5 * strain[c] });
        let change = deviator(&half);
        let old = deviator(&std::array::from_fn(|c| common[c]));
        let trial: [f64; STRESS] =
            std::array::from_fn(|c| (2.0 * shear).mul_add(change[c], old[c]));
        let mises = (1.5 * inner(&trial, &trial)).sqrt();
        let rate = if dt > 0.0 { (2.0 / 3.0 * inner(&change, &change)).sqrt() / dt } else { 0.0 };
        let damage = self.damage(own[LAMBDA]);
        let left = if damage.softens { damage.eta } else { 1.0 };
        // 2. Pressure of the volume without the plastic dilation, and the limit of tension.
        let (volume, before_flow, torn_at) = (common[VOLUME], own[DILATION], own[TORN_AT]);
        let mut most = own[MOST];
        let mut pressure_at = |dilation: f64| {
            let compressed = dilation - volume;
            most = most.max(compressed);
            let free = self.compaction.pressure(most, compressed);
            let limit = left * self.factor(free, rate) * self.surfaces.tension;
            // A crack that opened slowly does not pull more when it closes fast.
            let limit = if torn_at > 0.0 { limit.min(torn_at) } else { limit };
            (free.max(-limit), free < -limit)
        };
        let (first, is_torn) = pressure_at(before_flow);
        // 3. Flow: the strength as its tangent, then what is left above it.
        let cos3 = lode(&trial, mises);
        let at = |pressure: f64| self.strength(pressure, cos3, damage, rate);
        let above = mises - at(first);
        let (mut pressure, mut torn, mut dilation, mut after) =
            (first, is_torn, before_flow, mises);
        if above > 0.0 {
            let small = 1e-6 * self.surfaces.compression;
            let slope = ((at(first + small) - at(first)) / small).max(0.0);
            let [omega, drop] = self.dilatancy;
            let part = if damage.softens { omega * damage.eta.powf(drop) } else { omega };
            let flow = above / before.mul_add(part * slope * slope, 3.0 * shear);
            dilation += part * slope * flow;
            (pressure, torn) = pressure_at(dilation);
            after = (mises - 3.0 * shear * flow).min(at(pressure)).max(0.0);
        }
        let flow = (mises - after) / (3.0 * shear);
        let more = dilation - before_flow;
        own[DILATION] = dilation;
        own[MOST] = most;
        if torn {
            own[TORN_AT] = -pressure;
        }
        common[PLASTIC] += flow;
        // 4. Damage.
        let equivalent = (2.0 / 9.0 * more).mul_add(more, flow * flow).sqrt();
        let near = 1.0 - after / (TRIAXIAL * pressure.abs().max(f64::MIN_POSITIVE));
        let opened = if torn { near.max(0.0) * expansion.max(0.0) } else { 0.0 };
        let factor = self.factor(pressure, rate);
        let lambda = self.grown(own[LAMBDA], equivalent, factor, (pressure, opened));
        own[LAMBDA] = lambda;
        let DamageState { eta, softens } = self.damage(lambda);
        own[BREAK] = if softens { 1.0 - eta } else { 0.0 };
        // 5. Stress and the modulus of the step.
        let scale = if mises > 0.0 { after / mises } else { 1.0 };
        for c in 0..STRESS {
            common[c] = scale * trial[c] - if c < 3 { pressure } else { 0.0 };
        }
        let stiff = self.compaction.modulus(own[MOST]);
        common[STIFFENING] = stiff / self.elastic.bulk - 1.0;
        scale
    }
}

#[cfg(test)]
#[path = "karagozian_case_tests.rs"]
mod tests;
