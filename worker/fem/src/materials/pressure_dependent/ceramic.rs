//! Brittle material that breaks to rubble (Johnson & Holmquist 1994, JH-2), as in
//! `*MAT_JOHNSON_HOLMQUIST_CERAMICS`:
//! ```text
//! Y/Y_HEL = (1 - D) Y_i + D Y_f
//! Y_i = A (p* + T*)^N (1 + C ln rate*),   Y_f = min(B p*^M (1 + C ln rate*), largest_strength)
//! p = K1 mu + K2 mu^2 + K3 mu^3 + dp for mu > 0,   K1 mu + dp for mu < 0,   p >= -T (1 - D)
//! dD = de/(D1 (p* + T*)^D2)
//! ```
//! with p* and T* over the pressure at the Hugoniot elastic limit, and
//! `Y_HEL = 3/2 (HEL - p_HEL)`. Where damage takes elastic energy `dU = d(Y^2/(6 G))` of the
//! deviator away, bulking adds the fraction beta of it to the pressure:
//! ```text
//! dp <- -K1 mu + sqrt((K1 mu + dp)^2 + 2 beta K1 dU)
//! ```
//! dU takes the strength after damage in the pressure of a first estimate of dp, so that no more
//! energy is added than lost. In tension there is no bulking. The source adds dp in compression
//! only; here the pressure is continuous at the volume of the start. Rates below the reference rate
//! count as this rate.

use super::super::parameters::Parameters;
use super::super::{DefaultValue, Law, SolidLawResult};
use super::*;
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

const INTACT: &str = "intact_strength";
const BROKEN: &str = "fractured_strength";
const LIMIT: &str = "hugoniot_elastic_limit";
const BULKING: &str = "bulking";

/// The row of this law.
pub const LAW: Law = Law {
    name: "johnson_holmquist_ceramic",
    meaning: "Brittle material that breaks to rubble, with strength by pressure (JH-2).",
    constants: &[SHEAR_MODULUS],
    parameters: &[
        needed(INTACT, "[A, N]", "Constant and exponent of the strength of intact material."),
        list(
            BROKEN,
            "[B, M]",
            "Constant and exponent of the strength of broken material; without it it has none.",
        ),
        number(
            STRONGEST,
            DefaultValue::Absent,
            "Largest strength of broken material, over that at the Hugoniot elastic limit.",
        ),
        RATE_CONSTANTS,
        TENSILE_STRENGTH,
        needed(
            LIMIT,
            "[HEL, p_HEL]",
            "Stress at the Hugoniot elastic limit and its pressure [force/length^2].",
        ),
        number(
            BULKING,
            DefaultValue::Absent,
            "Fraction beta of the elastic energy lost by damage that becomes pressure; without it \
             none does.",
        ),
        DAMAGE_CONSTANTS,
        needed(
            PRESSURE,
            "[K1, K2, K3]",
            "Constants of the pressure over the compaction; K1 is the bulk modulus \
             [force/length^2].",
        ),
        FAILURE_STRAIN,
        FAILS_IN_TENSION,
    ],
    build: None,
    solid: Some(solid),
    cohesive: None,
};

/// Own columns: damage, and the pressure of bulking.
const BREAK: usize = 0;
const BULK: usize = 1;

struct Ceramic {
    elastic: VolumeElastic,
    intact: [f64; 2],
    fractured: [f64; 2],
    largest: f64,
    rate: LogarithmicRate,
    tension: f64,
    /// Strength and pressure at the Hugoniot elastic limit [force/length^2].
    limit: [f64; 2],
    bulking: f64,
    damage: Option<[f64; 2]>,
    pressure: [f64; 3],
    failure: FailureLimits,
}

fn solid(material: &Material) -> SolidLawResult {
    Ok(Box::new(read(Parameters::new(material))?))
}

fn read(mut parameters: Parameters<'_>) -> Result<Ceramic, Vec<Problem>> {
    let table = &mut parameters;
    let density = table.density();
    let shear = table.required(SHEAR, "above 0", |g| g > 0.0);
    let powers = |list: &[f64; 2]| list[0] >= 0.0 && list[1] >= 0.0;
    let wanted = "[constant, exponent], both 0 or above";
    let intact = needed_constants(table, INTACT, wanted, powers);
    let fractured = constants(table, BROKEN, wanted, powers).unwrap_or([0.0, 1.0]);
    let largest = table.optional(STRONGEST, "above 0", |most| most > 0.0);
    let rate = LogarithmicRate::read(table);
    let tension = table.required(TENSION, "0 or above", |t| t >= 0.0);
    let limit = needed_constants(
        table,
        LIMIT,
        "[HEL, p_HEL], with a pressure above 0 and below the stress",
        |&[stress, pressure]| pressure > 0.0 && stress > pressure,
    );
    let share = |beta: f64| (0.0..=1.0).contains(&beta);
    let bulking = table.optional(BULKING, "from 0 to 1", share).unwrap_or(0.0);
    let damage = constants(table, DAMAGE, "[D1, D2], D1 0 or above", |d| d[0] >= 0.0);
    let pressure = needed_constants(table, PRESSURE, "[K1, K2, K3], K1 above 0", |k| k[0] > 0.0);
    if let Some(pressure) = pressure {
        check_growth(table, pressure);
    }
    let failure = FailureLimits::read(table, tension);
    parameters.finish()?;
    // The lists are there: else there were problems.
    let [hel, pressure_at_limit] = limit.unwrap_or_default();
    let pressure = pressure.unwrap_or_default();
    Ok(Ceramic {
        elastic: VolumeElastic { bulk: pressure[0], shear, density },
        intact: intact.unwrap_or_default(),
        fractured,
        largest: largest.unwrap_or(f64::INFINITY),
        rate,
        tension,
        limit: [1.5 * (hel - pressure_at_limit), pressure_at_limit],
        bulking,
        damage,
        pressure,
        failure,
    })
}

impl Ceramic {
    /// Returns the strength with this damage [force/length^2].
    fn strength_with(&self, damage: f64, pressure: f64, rate: f64) -> f64 {
        let [strength, reference] = self.limit;
        let factor = self.rate.at(rate);
        let [a, n] = self.intact;
        let intact = a * ((pressure + self.tension) / reference).max(0.0).powf(n) * factor;
        let [b, m] = self.fractured;
        let pressed = (pressure / reference).max(0.0);
        let fractured = if pressed > 0.0 { b * pressed.powf(m) * factor } else { 0.0 };
        strength * damage.mul_add(fractured.min(self.largest) - intact, intact)
    }
}

impl Ceramic {
    /// Adds the pressure of bulking for damage from one value to the other.
    fn bulk(&self, own: &mut [f64], step: &PointStep, [before, after]: [f64; 2]) {
        let k1 = self.pressure[0];
        let linear = k1 * step.compaction;
        let sum = linear + own[BULK];
        // In tension the root would turn the sign of the pressure.
        if self.bulking == 0.0 || sum < 0.0 {
            return;
        }
        let energy = |damage: f64, pressure: f64| {
            let strength = self.strength_with(damage, pressure, step.rate).max(0.0);
            strength * strength / (6.0 * self.elastic.shear)
        };
        let at_start = energy(before, step.pressure);
        let bulked = |more: f64| {
            let lost = (at_start - energy(after, step.pressure + more)).max(0.0);
            (2.0 * k1).mul_add(self.bulking * lost, sum * sum).sqrt() - linear
        };
        // The strength grows with the pressure that bulking adds. With the first estimate of it the
        // second adds no more energy than the deviator loses.
        let first = bulked(0.0);
        own[BULK] = bulked(first - own[BULK]).max(own[BULK]);
    }
}

impl PressureDependent for Ceramic {
    fn columns(&self) -> &'static [&'static str] {
        &[VOLUME_COLUMN, "stiffening", "plastic_strain", "failed", "damage", "bulking"]
    }

    fn elastic(&self) -> &VolumeElastic {
        &self.elastic
    }

    fn pressure(&self, own: &mut [f64], compaction: f64) -> VolumePressure {
        let [k1, k2, k3] = self.pressure;
        let mu = compaction.max(0.0);
        let free = k1 * compaction + mu * mu * k3.mul_add(mu, k2) + own[BULK];
        let slope = k1 + mu * (2.0 * k2 + 3.0 * k3 * mu);
        let modulus = (1.0 + compaction) * slope;
        VolumePressure { free, tension: self.tension * (1.0 - own[BREAK]), modulus }
    }

    fn strength(&self, own: &[f64], pressure: f64, rate: f64) -> f64 {
        self.strength_with(own[BREAK], pressure, rate)
    }

    fn advance(&self, own: &mut [f64], step: &PointStep) -> bool {
        let &PointStep { free, pressure, flow, plastic_strain, .. } = step;
        if let Some([d1, d2]) = self.damage.filter(|_| flow > 0.0) {
            let before = own[BREAK];
            let over = ((pressure + self.tension) / self.limit[1]).max(0.0);
            let strain = d1 * over.powf(d2);
            let after = if flow < (1.0 - before) * strain { before + flow / strain } else { 1.0 };
            own[BREAK] = after;
            if after > before {
                self.bulk(own, step, [before, after]);
            }
        }
        self.failure.are_reached(plastic_strain, free)
    }
}
