//! Concrete in large strains, high rates and high pressures (Holmquist, Johnson & Cook 1993), as in
//! `*MAT_JOHNSON_HOLMQUIST_CONCRETE`:
//! ```text
//! Y/f_c = (A (1 - D) + B p*^N) (1 + C ln rate*) <= largest_strength,   p* = p/f_c
//! dD = (de + dmu_p)/max(D1 (p* + T*)^D2, least_fracture_strain)
//! ```
//! with the plastic strain e and the plastic compaction mu_p. In tension, p* < 0, the strength
//! falls linearly to zero at `-T* (1 - D)`. The pressure has three ranges:
//!
//! - elastic up to the crushing point (mu_c, p_c);
//! - pores are crushed on a line from there to the pressure p_l; the modulus of unloading grows
//!   from the elastic one to that with the work of the next range, by the part of the line passed;
//! - without pores `K1 m + K2 m^2 + K3 m^3`, `m = (mu - mu_l)/(1 + mu_l)`, with mu_l of the solid
//!   without pores. The line ends where this curve has p_l, as in the source.
//!
//! The source has K1 as the last modulus of unloading; then more work would come back just beyond
//! the line than on it.
//!
//! Rates below the reference rate count as this rate.

use super::super::parameters::Parameters;
use super::super::{DefaultValue, Law, SolidLawResult};
use super::*;
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

const STRENGTH: &str = "strength_constants";
const COMPRESSIVE: &str = "compressive_strength";
const LEAST: &str = "least_fracture_strain";
const CRUSHING: &str = "crushing_point";
const LOCKING: &str = "locking_point";
const WEARS: &str = "fails_in_damaged_tension";

/// The row of this law.
pub const LAW: Law = Law {
    name: "johnson_holmquist_concrete",
    meaning: "Concrete in high pressures and rates, with crushed pores and damage (HJC).",
    constants: &[SHEAR_MODULUS],
    parameters: &[
        needed(
            STRENGTH,
            "[A, B, N]",
            "Cohesion A, and constant B and exponent N of the pressure, over the compressive \
             strength.",
        ),
        number(
            COMPRESSIVE,
            DefaultValue::Needed,
            "Strength f_c of a bar in slow compression [force/length^2].",
        ),
        number(
            STRONGEST,
            DefaultValue::Absent,
            "Largest strength, over the compressive strength; without it there is no limit.",
        ),
        RATE_CONSTANTS,
        TENSILE_STRENGTH,
        needed(
            CRUSHING,
            "[mu_c, p_c]",
            "Compaction mu [-] and pressure [force/length^2] at which pores begin to be crushed.",
        ),
        needed(
            LOCKING,
            "[mu_l, p_l]",
            "Compaction mu [-] of the unloaded solid without pores, and pressure at which all \
             pores are crushed [force/length^2].",
        ),
        needed(
            PRESSURE,
            "[K1, K2, K3]",
            "Constants of the pressure without pores [force/length^2].",
        ),
        DAMAGE_CONSTANTS,
        number(LEAST, DefaultValue::Number(0.0), "Least strain to fracture."),
        FAILURE_STRAIN,
        FAILS_IN_TENSION,
        ParameterRow {
            key: WEARS,
            form: Form::Flag,
            otherwise: DefaultValue::Flag(false),
            range: None,
            meaning: "An element fails where its mean tension would exceed what damage has left of \
                      `tensile_strength`.",
        },
    ],
    build: None,
    solid: Some(solid),
    cohesive: None,
};

/// Own columns: damage, and the largest compaction.
const BREAK: usize = 0;
const MOST: usize = 1;

struct PorousConcrete {
    elastic: VolumeElastic,
    /// A, B, N.
    strength: [f64; 3],
    compressive: f64,
    largest: f64,
    rate: LogarithmicRate,
    tension: f64,
    /// Compaction and pressure where the line begins and ends.
    line: [[f64; 2]; 2],
    /// Moduli of unloading where the line begins and ends [force/length^2].
    unloading: [f64; 2],
    /// Compaction of the unloaded solid without pores.
    locked: f64,
    pressure: [f64; 3],
    damage: Option<[f64; 2]>,
    least_strain: f64,
    failure: FailureLimits,
    wears: bool,
}

fn solid(material: &Material) -> SolidLawResult {
    Ok(Box::new(read(Parameters::new(material))?))
}

/// Returns the pressure without pores at m, and its slope.
fn without_pores([k1, k2, k3]: [f64; 3], m: f64) -> [f64; 2] {
    let pressed = m.max(0.0);
    [
        k1 * m + pressed * pressed * k3.mul_add(pressed, k2),
        k1 + pressed * (2.0 * k2 + 3.0 * k3 * pressed),
    ]
}

/// Returns the m at which the pressure without pores is `pressure`; none if it stays below.
fn pressed_to(constants: [f64; 3], pressure: f64) -> Option<f64> {
    let above = |m: f64| without_pores(constants, m)[0] >= pressure;
    // A compaction of 8 is far beyond any solid.
    let mut high = (1..=800).map(|k| 0.01 * f64::from(k)).find(|m| above(*m))?;
    let mut low = high - 0.01;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if above(middle) { high = middle } else { low = middle }
    }
    Some(high)
}

fn read(mut parameters: Parameters<'_>) -> Result<PorousConcrete, Vec<Problem>> {
    let table = &mut parameters;
    let density = table.density();
    let shear = table.required(SHEAR, "above 0", |g| g > 0.0);
    let wanted = "[A, B, N], all 0 or above";
    let strength =
        needed_constants(table, STRENGTH, wanted, |l: &[f64; 3]| l.iter().all(|x| *x >= 0.0));
    let compressive = table.required(COMPRESSIVE, "above 0", |f| f > 0.0);
    let largest = table.optional(STRONGEST, "above 0", |most| most > 0.0);
    let rate = LogarithmicRate::read(table);
    let tension = table.required(TENSION, "0 or above", |t| t >= 0.0);
    let positive = |point: &[f64; 2]| point[0] > 0.0 && point[1] > 0.0;
    let crushing = needed_constants(table, CRUSHING, "[mu_c, p_c], both above 0", positive);
    let locking = needed_constants(table, LOCKING, "[mu_l, p_l], both above 0", positive);
    let pressure = needed_constants(table, PRESSURE, "[K1, K2, K3], K1 above 0", |k| k[0] > 0.0);
    let (mut line, mut unloading) = ([[0.0; 2]; 2], [1.0; 2]);
    if let (Some(begin), Some([locked, full]), Some(constants)) = (crushing, locking, pressure) {
        match pressed_to(constants, full) {
            Some(m) => {
                line = [begin, [locked + m * (1.0 + locked), full]];
                // Both ways from the end of the line give back the same work.
                let [k1, k2, k3] = constants;
                let work = m * m * (k1 / 2.0 + m * (k2 / 3.0 + m * k3 / 4.0)) * (1.0 + locked);
                unloading = [begin[1] / begin[0], full * full / (2.0 * work)];
                check_growth(table, constants);
                check_line(table, line, unloading);
            }
            None => {
                let what = format!("never gives the pressure {full}");
                let help = format!("use other constants, or a lower pressure in {LOCKING}");
                table.wrong(PRESSURE, what, help);
            }
        }
    }
    let damage = constants(table, DAMAGE, "[D1, D2], D1 0 or above", |d| d[0] >= 0.0);
    let least_strain = table.optional(LEAST, "0 or above", |e| e >= 0.0).unwrap_or(0.0);
    let failure = FailureLimits::read(table, tension);
    let wears = table.flag(WEARS);
    if wears && tension == 0.0 {
        let help = format!("give {TENSION} above 0, or remove it");
        table.wrong(WEARS, "is set without a tensile strength", help);
    }
    parameters.finish()?;
    // The lists are there: else there were problems.
    Ok(PorousConcrete {
        elastic: VolumeElastic { bulk: unloading[0], shear, density },
        strength: strength.unwrap_or_default(),
        compressive,
        largest: largest.unwrap_or(f64::INFINITY),
        rate,
        tension,
        line,
        unloading,
        locked: locking.unwrap_or_default()[0],
        pressure: pressure.unwrap_or_default(),
        damage,
        least_strain,
        failure,
        wears,
    })
}

/// Checks that crushing goes forward, and that no more work can be taken out by unloading than
/// crushing has put in: unloading is steeper than crushing and does not become softer.
fn check_line(
    parameters: &mut Parameters<'_>,
    [begin, end]: [[f64; 2]; 2],
    [elastic, locked]: [f64; 2],
) {
    if end[0] <= begin[0] || end[1] <= begin[1] {
        let what = format!("is not beyond {CRUSHING}");
        parameters.wrong(LOCKING, what, "use a larger compaction and a larger pressure");
        return;
    }
    let slope = (end[1] - begin[1]) / (end[0] - begin[0]);
    if slope > elastic || locked < elastic {
        let what = format!(
            "gives crushing the modulus {slope}, and unloading {elastic} before and {locked} after"
        );
        let help = "use constants with which the first is the least and the last the largest: the \
                    second is p_c/mu_c, the third follows from K1, K2, K3";
        parameters.wrong(LOCKING, what, help);
    }
}

impl PorousConcrete {
    /// Returns the pressure on the line at this compaction, and the modulus of unloading from there
    /// [force/length^2].
    fn crushed(&self, compaction: f64) -> [f64; 2] {
        let [begin, end] = self.line;
        let part = ((compaction - begin[0]) / (end[0] - begin[0])).clamp(0.0, 1.0);
        let between = |a: f64, b: f64| part.mul_add(b - a, a);
        [between(begin[1], end[1]), between(self.unloading[0], self.unloading[1])]
    }

    /// Returns the plastic compaction after this largest compaction.
    fn plastic_compaction(&self, most: f64) -> f64 {
        let [begin, end] = self.line;
        if most <= begin[0] {
            return 0.0;
        }
        let at = most.min(end[0]);
        let [pressure, modulus] = self.crushed(at);
        at - pressure / modulus
    }

    /// Returns the strength with this damage [force/length^2].
    fn strength_with(&self, damage: f64, pressure: f64, rate: f64) -> f64 {
        let [a, b, n] = self.strength;
        let over = pressure / self.compressive;
        let part = if over >= 0.0 {
            a * (1.0 - damage) + if b > 0.0 { b * over.powf(n) } else { 0.0 }
        } else if self.tension > 0.0 {
            a * (1.0 - damage + pressure / self.tension).max(0.0)
        } else {
            0.0
        };
        self.compressive * (part * self.rate.at(rate)).min(self.largest)
    }
}

impl PressureDependent for PorousConcrete {
    fn columns(&self) -> &'static [&'static str] {
        &[VOLUME_COLUMN, "stiffening", "plastic_strain", "failed", "damage", "largest compaction"]
    }

    fn elastic(&self) -> &VolumeElastic {
        &self.elastic
    }

    fn pressure(&self, own: &mut [f64], compaction: f64) -> VolumePressure {
        let before = own[MOST];
        own[MOST] = before.max(compaction);
        let [begin, end] = self.line;
        let most = own[MOST];
        let [free, slope] = if most <= begin[0] {
            let modulus = self.unloading[0];
            [modulus * compaction, modulus]
        } else if most < end[0] {
            let [pressure, modulus] = self.crushed(most);
            [modulus.mul_add(compaction - most, pressure), modulus]
        } else {
            let scale = 1.0 + self.locked;
            let [pressure, slope] =
                without_pores(self.pressure, (compaction - self.locked) / scale);
            [pressure, slope / scale]
        };
        // Damage by crushing needs no flow, so it is added with the pressure.
        let crushed = self.plastic_compaction(most) - self.plastic_compaction(before);
        if crushed > 0.0 {
            self.add_damage(own, crushed, free);
        }
        let tension = self.tension * (1.0 - own[BREAK]);
        VolumePressure { free, tension, modulus: (1.0 + compaction) * slope }
    }

    fn strength(&self, own: &[f64], pressure: f64, rate: f64) -> f64 {
        self.strength_with(own[BREAK], pressure, rate)
    }

    fn advance(&self, own: &mut [f64], step: &PointStep) -> bool {
        let left = self.tension * (1.0 - own[BREAK]);
        if step.flow > 0.0 {
            self.add_damage(own, step.flow, step.pressure);
        }
        let worn = self.wears && step.free < -left;
        worn || self.failure.are_reached(step.plastic_strain, step.free)
    }
}

impl PorousConcrete {
    /// Adds the damage of a plastic strain or compaction in this pressure.
    fn add_damage(&self, own: &mut [f64], strain: f64, pressure: f64) {
        let Some([d1, d2]) = self.damage else { return };
        let over = ((pressure + self.tension) / self.compressive).max(0.0);
        let limit = (d1 * over.powf(d2)).max(self.least_strain);
        let left = 1.0 - own[BREAK];
        own[BREAK] += if strain < left * limit { strain / limit } else { left };
    }
}
