//! Thermoplastics by their tests (Kolling, Haufe, Feucht & Du Bois 2005, SAMP-1), as in
//! `*MAT_SAMP-1`: elastic, with a yield surface through the yield stresses in tension, compression
//! and shear, and flow by a plastic Poisson's ratio n:
//! ```text
//! q^2 <= A0 + A1 p + A2 p^2
//! A0 = 3 s^2,   A1 = 9 s^2 (c - t)/(c t),   A2 = 9 (c t - 3 s^2)/(c t)
//! d eps_p = dl dg/d sigma,   g^2 = q^2 + a p^2,   a = 9/2 (1 - 2 n)/(1 + n)
//! sigma = (1 - d) sigma_e
//! ```
//! with the pressure p and the von Mises stress q of the effective stress sigma_e, the yield
//! stresses t, c and s, and the damage d. In uniaxial stress the flow has the ratio n across.
//! Without s the surface is a cone (Drucker & Prager), `s = 2 c t/(sqrt(3) (c + t))`, without c it
//! is that of von Mises. The curves are over the plastic strain of their test: with the effective
//! plastic strain e of the shape, `3 e/(2 (1 + n))` in tension and compression, `sqrt(3)/2 e` in
//! shear. That measure, the damage over e and the same effect of the rate on all three curves are
//! from memory of the manual of the format and of other codes.
//!
//! The return is exact for backward Euler: pressure and deviator of the trial are each divided by a
//! factor, in plane stress with the strain through the thickness that leaves no stress there, so
//! that one number is sought, in [`flow`]. The flow is along the effective stress in the space of
//! g. So it dissipates whatever the surface is, also where that is not convex.
//!
//! The rate is that of the plastic strain in tension, a running mean over 12 steps.
//!
//! Valid for small elastic strains.
//!
//! Left out: the curve of biaxial tension and the surface of planes, associated flow, failure and
//! damage by triaxiality or size (see `gissmo_...`), moduli by the rate.

mod flow;

use super::failed_points::FailedPoints;
use super::parameters::Parameters;
use super::polyline::{Beyond, CurveFamily, RampCurve};
use super::{
    DefaultValue, ELASTIC, Elastic, Form, Law, LawResult, ParameterRow, PlaneStress, Points, Solid,
    SolidLawResult, SolidPoint,
};
use crumple_math::lanes::{LANES, LANES32, Lane, Lane32, Lanes, Real};
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;
use flow::{OfSheet, OfSolid, PolymerState};

const TENSION: &str = "tension";
const BY_RATE: &str = "tension_by_rate";
const COMPRESSION: &str = "compression";
const SHEAR: &str = "shear";
const POISSON: &str = "plastic_poisson";
const POISSONS: &str = "plastic_poisson_curve";
const CONVEX: &str = "convexity";
const DAMAGE: &str = "damage";
const FAILURE: &str = "failure_strain";
const FADING: &str = "fading_strain";
const POINTS: &str = "failed_points";
const CURVE: &str = "[[plastic strain, yield stress], ...]";

/// The row of this law.
pub const LAW: Law = Law {
    name: "polymer",
    meaning: "Thermoplastic by yield stresses in tension, compression and shear, with flow that \
              changes the volume, damage and failure.",
    constants: ELASTIC,
    parameters: &[
        ParameterRow {
            otherwise: DefaultValue::Depends("needed without `tension_by_rate`"),
            ..list(TENSION, CURVE, "Yield stress in tension [force/length^2]; constant beyond.")
        },
        list(
            BY_RATE,
            "[[rate, plastic strain, yield stress], ...]",
            "The same at ascending plastic strain rates [1/time], constant beyond them.",
        ),
        list(
            COMPRESSION,
            CURVE,
            "Yield stress in compression at the lowest rate, positive; that in tension if not \
             given [force/length^2].",
        ),
        list(
            SHEAR,
            CURVE,
            "Yield stress in shear at the lowest rate over the plastic strain xy, half of the \
             engineering shear; needs `compression` [force/length^2].",
        ),
        ParameterRow {
            key: POISSON,
            form: Form::Number,
            otherwise: DefaultValue::Number(0.0),
            range: None,
            meaning: "Ratio of the plastic strains across and along a uniaxial test, 0 to 0.5.",
        },
        list(
            POISSONS,
            "[[plastic strain, ratio], ...]",
            "The same over the plastic strain in tension, instead of `plastic_poisson`.",
        ),
        number(
            CONVEX,
            "Factor from 1 on: the yield stress in shear is at least this times the root of a \
             third of those in tension and compression, with which the surface is convex.",
        ),
        list(
            DAMAGE,
            "[[effective plastic strain, damage], ...]",
            "Damage, from 0 to 1, that does not fall: (1 - damage) of the stress is left.",
        ),
        number(FAILURE, "Effective plastic strain at which failure begins; without it none does."),
        number(
            FADING,
            "Further plastic strain over which the stress falls to zero; at once without it.",
        ),
        number(
            POINTS,
            "Number of failed points through the thickness from which on a shell is removed, below \
             0 a percentage; without it all.",
        ),
    ],
    build: Some(build),
    solid: Some(solid),
    cohesive: None,
};

const fn number(key: &'static str, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise: DefaultValue::Absent, range: None, meaning }
}

const fn list(key: &'static str, form: &'static str, meaning: &'static str) -> ParameterRow {
    ParameterRow { form: Form::List(form), ..number(key, meaning) }
}

/// Columns after the stress.
const HISTORY: [&str; 5] = ["plastic_strain", "strain of tension", "rate", "damage", "failed"];
const COLUMNS: usize = HISTORY.len();

/// Damage from which on nothing is left.
const ALL_DAMAGED: f64 = 0.999;
/// Number of steps of the running mean of the rate.
const STEPS_OF_MEAN: f64 = 12.0;

/// The plastic Poisson's ratio.
enum FlowRatio {
    Constant(f64),
    OverStrain(RampCurve),
}

struct Polymer {
    elastic: Elastic,
    tension: CurveFamily,
    has_rates: bool,
    compression: Option<RampCurve>,
    shear: Option<RampCurve>,
    /// Least yield stress in shear over the root of `t c/3`; 0 for none.
    convexity: f64,
    ratio: FlowRatio,
    damage: Option<RampCurve>,
    /// Plastic strains at which failure begins and is complete.
    failure: Option<[f64; 2]>,
    failed_points: FailedPoints,
}

fn build(material: &Material) -> LawResult {
    Parameters::new(material).shell_law(read)
}

fn solid(material: &Material) -> SolidLawResult {
    Parameters::new(material).solid_law(read)
}

fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<Polymer, Vec<Problem>> {
    if elastic.poisson == 0.5 {
        let help = "give a finite bulk modulus: 0.49 or 0.499 for a nearly incompressible material";
        parameters.wrong("poisson", "is 0.5", help);
    }
    let tension = tension(&mut parameters);
    let wanted = ("with yield stresses above 0", |point: &[f64; 2]| point[1] > 0.0);
    let [compression, shear] = [COMPRESSION, SHEAR].map(|key| parameters.curve(key, CURVE, wanted));
    if shear.is_some() && compression.is_none() {
        let help = "give compression too: the surface needs it";
        parameters.wrong(SHEAR, "is given without compression", help);
    }
    let within = |n: f64| (0.0..=0.5).contains(&n);
    let constant = parameters.optional(POISSON, "from 0 to 0.5", within);
    let form = ("[[plastic strain, ratio], ...]", "with ratios from 0 to 0.5");
    let ratios = parameters.ascending(POISSONS, form, |point| within(point[1]));
    if constant.is_some() && ratios.is_some() {
        parameters.wrong(POISSONS, format!("is given with {POISSON}"), "give one of them");
    }
    let convexity = parameters.optional(CONVEX, "from 1 on", |x| x >= 1.0).unwrap_or(0.0);
    let form = ("[[effective plastic strain, damage], ...]", "with damages from 0 to 1");
    let damage = parameters.ascending(DAMAGE, form, |point| (0.0..=1.0).contains(&point[1]));
    if damage.iter().any(|points| points.windows(2).any(|two| two[1][1] < two[0][1])) {
        parameters.wrong(DAMAGE, "falls", "give damages that do not fall");
    }
    if damage.as_ref().and_then(|points| points.first()).is_some_and(|p| p[1] != 0.0) {
        parameters.wrong(DAMAGE, "begins with a damage", "begin it with a damage of 0");
    }
    let failure = parameters.optional(FAILURE, "above 0", |strain| strain > 0.0);
    let fading = parameters.optional(FADING, "0 or above", |strain| strain >= 0.0);
    if fading.is_some() && failure.is_none() && !parameters.given(FAILURE) {
        parameters.wrong(FADING, "is given without a strain at failure", "give failure_strain");
    }
    let failed_points = FailedPoints::read(&mut parameters, POINTS);
    parameters.finish()?;
    let curve = |points: Vec<[f64; 2]>| RampCurve::new(&points, 1.0, Beyond::Constant);
    Ok(Polymer {
        elastic,
        has_rates: tension.first().map(|row| row[0]) != tension.last().map(|row| row[0]),
        tension: CurveFamily::new(&tension, 1.0, Beyond::Constant),
        compression: compression.map(curve),
        shear: shear.map(curve),
        convexity,
        ratio: match ratios {
            Some(points) => FlowRatio::OverStrain(curve(points)),
            None => FlowRatio::Constant(constant.unwrap_or(0.0)),
        },
        damage: damage.map(curve),
        failure: failure.map(|start| [start, start + fading.unwrap_or(0.0)]),
        failed_points,
    })
}

/// Returns the rows [rate, plastic strain, yield stress] of tension.
fn tension(parameters: &mut Parameters<'_>) -> Vec<[f64; 3]> {
    let curve = parameters.rows::<2>(TENSION, CURVE);
    let by_rate = parameters.rows::<3>(BY_RATE, "[rate, plastic strain, yield stress]");
    let (key, rows): (_, Vec<[f64; 3]>) = match (curve, by_rate) {
        (Some(rows), None) => (TENSION, rows.iter().map(|row| [0.0, row[0], row[1]]).collect()),
        (None, Some(rows)) => (BY_RATE, rows),
        (Some(_), Some(_)) => {
            parameters.wrong(BY_RATE, "is given together with tension", "give one of them");
            return Vec::new();
        }
        (None, None) => {
            parameters.wrong(TENSION, "is missing", format!("give {CURVE}, or {BY_RATE}"));
            return Vec::new();
        }
    };
    let curves: Vec<&[[f64; 3]]> = rows.chunk_by(|a, b| a[0] == b[0]).collect();
    let ascends = |curve: &&[[f64; 3]]| {
        curve[0][1] == 0.0
            && curve.windows(2).all(|two| two[0][1] < two[1][1])
            && curve.iter().all(|row| row[2] > 0.0)
    };
    let sound = curves.iter().all(ascends)
        && rows.iter().all(|row| row[0] >= 0.0)
        && curves.windows(2).all(|two| two[0][0][0] < two[1][0][0]);
    if !sound {
        let help = "give plastic strains that increase from 0 on with yield stresses above 0, and \
                    rates that increase";
        parameters.wrong(key, "is not such a curve", help);
    }
    rows
}

impl Polymer {
    /// Returns the damage at an effective plastic strain: that of the curve, and of failure.
    fn damage_at(&self, strain: f64) -> f64 {
        let curve = self.damage.as_ref().map_or(0.0, |curve| curve.at(strain)[0]);
        let fading = match self.failure {
            Some([_, end]) if strain >= end => 1.0,
            Some([start, end]) if strain > start => (strain - start) / (end - start),
            _ => 0.0,
        };
        1.0 - (1.0 - curve) * (1.0 - fading)
    }

    /// Advances damage and failure after a step.
    fn fail(&self, state: &mut PolymerState) {
        state.damage = state.damage.max(self.damage_at(state.strain));
        if state.damage >= ALL_DAMAGED {
            (state.damage, state.failed) = (1.0, 1.0);
        }
    }

    /// Updates the points of a group of so many lanes; `lanes` makes one of their numbers.
    #[inline(always)]
    fn points<R: Real>(
        &self,
        points: Points<'_, R>,
        dt: f64,
        count: usize,
        lanes: impl Fn(&[f64; LANES32]) -> R,
    ) {
        let states = points.state.chunks_exact_mut(3 + COLUMNS);
        for ((state, eps), eps_z) in states.zip(points.strain).zip(points.thickness_strain) {
            let mut after = [[0.0; LANES32]; 3 + COLUMNS + 1];
            #[expect(clippy::needless_range_loop, reason = "a lane is a column of `after`")]
            for lane in 0..count {
                let mut one: [f64; 3 + COLUMNS] = std::array::from_fn(|c| state[c].lane(lane));
                let strain = [0, 1, 2].map(|c| eps[c].lane(lane));
                let mut history = PolymerState::read(&one[3..]);
                let [xx, yy, xy] = [one[0], one[1], one[2]].map(|s| s / history.intact());
                let old = [xx, yy, 0.0, xy, 0.0, 0.0];
                let elastic = self.elastic;
                let space = OfSheet { elastic, old, strain };
                let mut through = 0.0;
                if history.failed < 0.5 {
                    let flow = self.flow(&space, &mut history, dt);
                    self.fail(&mut history);
                    let [xx, yy, _, xy, ..] = flow.stress.map(|s| s * history.intact());
                    one[..3].copy_from_slice(&[xx, yy, xy]);
                    through = flow.thickness;
                }
                if history.failed >= 0.5 {
                    one[..3].fill(0.0);
                }
                history.write(&mut one[3..]);
                (0..3 + COLUMNS).for_each(|c| after[c][lane] = one[c]);
                after[3 + COLUMNS][lane] = through;
            }
            state.iter_mut().zip(&after).for_each(|(column, after)| *column = lanes(after));
            *eps_z = lanes(&after[3 + COLUMNS]);
        }
    }

    #[inline(always)]
    fn point<R: Real>(
        &self,
        point: SolidPoint<'_, R>,
        dt: f64,
        count: usize,
        lanes: impl Fn(&[f64; LANES32]) -> R,
    ) -> R {
        let mut after = [[0.0; LANES32]; 6 + COLUMNS];
        let mut kept = [1.0; LANES32];
        for lane in 0..count {
            let mut one: [f64; 6 + COLUMNS] = std::array::from_fn(|c| point.state[c].lane(lane));
            let strain = std::array::from_fn(|c| point.strain[c].lane(lane));
            let mut history = PolymerState::read(&one[6..]);
            if history.failed < 0.5 {
                let old = std::array::from_fn(|c| one[c] / history.intact());
                let space = OfSolid::new(self.elastic, old, strain);
                let flow = self.flow(&space, &mut history, dt);
                self.fail(&mut history);
                kept[lane] = flow.kept;
                (0..6).for_each(|c| one[c] = flow.stress[c] * history.intact());
            }
            if history.failed >= 0.5 {
                one[..6].fill(0.0);
                kept[lane] = 0.0;
            }
            history.write(&mut one[6..]);
            (0..6 + COLUMNS).for_each(|c| after[c][lane] = one[c]);
        }
        point.state.iter_mut().zip(&after).for_each(|(column, after)| *column = lanes(after));
        lanes(&kept)
    }
}

impl PlaneStress for Polymer {
    fn history(&self) -> &[&'static str] {
        &HISTORY
    }
    fn adds_stress(&self) -> bool {
        true
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn initial_yield_stress(&self) -> f64 {
        self.tension.lowest().at(0.0)[0]
    }
    fn failed_points(&self, points: usize) -> usize {
        self.failed_points.of(points, points)
    }
    fn update(&self, points: Points<'_, Lane>, dt: f64) {
        self.points(points, dt, LANES, |all| Lane::from_array(std::array::from_fn(|k| all[k])));
    }
    fn update_short(&self, points: Points<'_, Lane32>, dt: f64) {
        self.points(points, dt, LANES32, |all| Lane32::from_array(*all));
    }
    fn update_one(&self, points: Points<'_, f64>, dt: f64) {
        self.points(points, dt, 1, |all| all[0]);
    }
}

impl Solid for Polymer {
    fn history(&self) -> &[&'static str] {
        &HISTORY
    }
    fn adds_stress(&self) -> bool {
        true
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn averages_volume(&self) -> bool {
        false
    }
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) -> Lane {
        self.point(point, dt, LANES, |all| Lane::from_array(std::array::from_fn(|k| all[k])))
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, dt: f64) -> Lane32 {
        self.point(point, dt, LANES32, |all| Lane32::from_array(*all))
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) -> f64 {
        self.point(point, dt, 1, |all| all[0])
    }
}

#[cfg(test)]
mod tests;
