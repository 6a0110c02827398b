//! Soil, and foam that behaves like a fluid (Krieg 1972; Key 1974), as in `*MAT_SOIL_AND_FOAM`:
//! ```text
//! J_2 <= a0 + a1 p + a2 p^2,   p = curve(-ln V) where the soil is compacted
//! ```
//! with the second invariant J_2 of the deviator, so that `Y = sqrt(3 (a0 + a1 p + a2 p^2))`, and
//! the volume V over that at the start. Unloading has the bulk modulus, down to the cutoff of
//! tension; with `reversible` it follows the curve. Beyond its points the curve keeps its last
//! slope.

use super::super::parameters::Parameters;
use super::super::polyline::{Beyond, RampCurve};
use super::super::{DefaultValue, Law, SolidLawResult};
use super::*;
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

const UNLOADING: &str = "bulk_modulus";
const YIELD: &str = "yield_constants";
const CUTOFF: &str = "tension_cutoff";
const REVERSIBLE: &str = "reversible";
const CURVE: &str = "[[volume strain, pressure], ...]";

/// The row of this law.
pub const LAW: Law = Law {
    name: "soil",
    meaning: "Soil that is compacted, with strength by pressure.",
    constants: &[SHEAR_MODULUS],
    parameters: &[
        number(
            UNLOADING,
            DefaultValue::Needed,
            "Bulk modulus of unloading, at least the largest slope of `pressure` [force/length^2].",
        ),
        needed(
            YIELD,
            "[a0, a1, a2]",
            "Constants of the largest J_2 over the pressure [stress^2, stress, 1].",
        ),
        needed(
            PRESSURE,
            CURVE,
            "Pressure over the volume strain -ln V, both positive in compression, from [0, 0] on \
             [force/length^2].",
        ),
        number(CUTOFF, DefaultValue::Number(0.0), "Largest mean tensile stress [force/length^2]."),
        ParameterRow {
            key: REVERSIBLE,
            form: Form::Flag,
            otherwise: DefaultValue::Flag(false),
            range: None,
            meaning: "Unloading follows `pressure`.",
        },
    ],
    build: None,
    solid: Some(solid),
    cohesive: None,
};

/// Own column: the largest volume strain -ln V.
const MOST: usize = 0;

struct Soil {
    elastic: VolumeElastic,
    yields: [f64; 3],
    curve: RampCurve,
    cutoff: f64,
    reversible: bool,
}

fn solid(material: &Material) -> SolidLawResult {
    Ok(Box::new(read(Parameters::new(material))?))
}

fn read(mut parameters: Parameters<'_>) -> Result<Soil, Vec<Problem>> {
    let table = &mut parameters;
    let density = table.density();
    let shear = table.required(SHEAR, "above 0", |g| g > 0.0);
    let bulk = table.required(UNLOADING, "above 0", |k| k > 0.0);
    let yields = needed_constants(table, YIELD, "[a0, a1, a2], a0 0 or above", |a| a[0] >= 0.0);
    let wanted = ("with pressures of 0 or above", |point: &[f64; 2]| point[1] >= 0.0);
    let points = table.curve(PRESSURE, CURVE, wanted);
    if points.is_none() {
        table.wrong(PRESSURE, "is missing", "give [[0, 0], [volume strain, pressure], ...]");
    }
    let points = points.unwrap_or_default();
    if points.first().is_some_and(|first| first[1] != 0.0) {
        table.wrong(PRESSURE, "has a pressure at the start", "begin it with [0, 0]");
    }
    let slope = |two: &[[f64; 2]]| (two[1][1] - two[0][1]) / (two[1][0] - two[0][0]);
    let slopes = || points.windows(2).map(slope);
    let steepest = slopes().fold(0.0, f64::max);
    if steepest > bulk * (1.0 + 1e-9) {
        let help = format!("use a bulk modulus of at least the largest slope, {steepest}");
        table.wrong(UNLOADING, format_args!("is {bulk}, below the slope of {PRESSURE}"), help);
    }
    if slopes().any(|slope| slope < 0.0) {
        table.wrong(PRESSURE, "falls", "give pressures that do not fall");
    }
    let cutoff = table.optional(CUTOFF, "0 or above", |t| t >= 0.0).unwrap_or(0.0);
    let reversible = table.flag(REVERSIBLE);
    parameters.finish()?;
    let curve = RampCurve::new(&points, 1.0, Beyond::Straight);
    let yields = yields.unwrap_or_default();
    let elastic = VolumeElastic { bulk, shear, density };
    Ok(Soil { elastic, yields, curve, cutoff, reversible })
}

impl PressureDependent for Soil {
    fn columns(&self) -> &'static [&'static str] {
        &[VOLUME_COLUMN, "stiffening", "plastic_strain", "failed", "largest volume strain"]
    }

    fn elastic(&self) -> &VolumeElastic {
        &self.elastic
    }

    fn pressure(&self, own: &mut [f64], compaction: f64) -> VolumePressure {
        let strain = compaction.ln_1p();
        own[MOST] = own[MOST].max(strain);
        let modulus = self.elastic.bulk;
        let from = if self.reversible { strain.max(0.0) } else { own[MOST] };
        let free = modulus.mul_add(strain - from, self.curve.at(from)[0]);
        VolumePressure { free, tension: self.cutoff, modulus }
    }

    fn strength(&self, _own: &[f64], pressure: f64, _rate: f64) -> f64 {
        let [a0, a1, a2] = self.yields;
        (3.0 * (a0 + pressure * a2.mul_add(pressure, a1))).max(0.0).sqrt()
    }
}
