//! Damage that begins at a plastic strain by the state of stress, and then grows with the plastic
//! displacement or the fracture energy, as `*MAT_ADD_DAMAGE_DIEM` (Hooputra, Gese, Dell & Werner
//! 2004; LS-DYNA Keyword User's Manual, vol. II). Any plastic law can have it.
//!
//! Each criterion has a curve of the strain at onset over a measure of the stress, with the von
//! Mises stress q, the pressure p, and the principal stresses s_1 > s_2 > s_3:
//! ```text
//! ductile    -p/q
//! shear      (q + k p)/tau,   tau = (s_1 - s_3)/2
//! principal  (q + k p)/s_1,   none where s_1 <= 0
//! dw = de/e_onset;   where w >= 1:   du = l de,   D = u/u_f,   u_f = 2 G_f/q at onset
//! ```
//! with the plastic strain e and the size l of the element. The damage of a point is the largest of
//! all criteria, or `1 - (1 - D_1) (1 - D_2)...` of those that are multiplied, if this is larger.
//! It takes this part of the stress; a point fails at D = 1.
//!
//! Not included: strain rates, criteria of thin sheets (FLD, MSFLD), displacements that depend on
//! the stress.

#[cfg(test)]
mod tests;

use super::damaged::{DamageColumns, DamageLaw};
use super::failed_points::FailedPoints;
use super::gissmo::SIZE_COLUMN;
use super::parameters::{Parameters, divided};
use super::polyline::{Beyond, RampCurve};
use super::tensor::{Principal, deviator, inner, trace};
use super::wrapped::{self, PointColumns};
use super::{DefaultValue, Form, LawResult, ParameterRow, PlaneStress, Solid, SolidLawResult};
use crumple_math::lanes::Real;
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

/// Keys of a criterion.
struct OnsetKeys {
    /// Curve of the strain at onset, factor on the pressure, plastic displacement and fracture
    /// energy from onset to failure, flag of multiplication.
    onset: &'static str,
    pressure: Option<&'static str>,
    displacement: &'static str,
    energy: &'static str,
    multiplied: &'static str,
    /// Columns: w, u, and u_f where it follows from an energy.
    columns: [&'static str; 3],
}

const CRITERIA: [OnsetKeys; 3] = [
    OnsetKeys {
        onset: "diem_ductile",
        pressure: None,
        displacement: "diem_ductile_displacement",
        energy: "diem_ductile_energy",
        multiplied: "diem_ductile_multiplied",
        columns: ["diem ductile onset", "diem ductile displacement", "diem ductile end"],
    },
    OnsetKeys {
        onset: "diem_shear",
        pressure: Some("diem_shear_pressure"),
        displacement: "diem_shear_displacement",
        energy: "diem_shear_energy",
        multiplied: "diem_shear_multiplied",
        columns: ["diem shear onset", "diem shear displacement", "diem shear end"],
    },
    OnsetKeys {
        onset: "diem_principal",
        pressure: Some("diem_principal_pressure"),
        displacement: "diem_principal_displacement",
        energy: "diem_principal_energy",
        multiplied: "diem_principal_multiplied",
        columns: ["diem principal onset", "diem principal displacement", "diem principal end"],
    },
];
const POINTS: &str = "diem_failed_points";

/// Largest principal stress over the von Mises stress below which there is no tension.
const TENSILE: f64 = 1e-6;

/// Column of the damage of all criteria together.
pub const DAMAGE_COLUMN: &str = "diem damage";

const CURVE: &str = "[[measure, strain], ...]";
const WANTED: &str = "with strains above 0";

const fn curve(key: &'static str, meaning: &'static str) -> ParameterRow {
    let otherwise = DefaultValue::Absent;
    ParameterRow { key, form: Form::List(CURVE), otherwise, range: None, meaning }
}

const fn number(key: &'static str, meaning: &'static str) -> ParameterRow {
    let otherwise = DefaultValue::Absent;
    ParameterRow { key, form: Form::Number, otherwise, range: None, meaning }
}

const fn flag(key: &'static str) -> ParameterRow {
    ParameterRow {
        key,
        form: Form::Flag,
        otherwise: DefaultValue::Flag(false),
        range: None,
        meaning: "This damage is multiplied with the other multiplied ones; without it the largest \
                  damage counts.",
    }
}

const DISPLACEMENT: &str = "Plastic displacement from onset to failure [length]: plastic strain \
                            times the size of the element, the root of the area or the cube root \
                            of the volume.";
const ENERGY: &str = "Energy over the area of a crack from onset to failure, in place of the \
                      displacement [force/length].";
const FACTOR: &str = "Factor k of the pressure in the measure of this criterion; without it 0.";

/// Keys of all plastic laws.
pub const DIEM: &[ParameterRow] = &[
    curve(
        CRITERIA[0].onset,
        "Plastic strain at the onset of damage over the triaxiality, constant beyond the points: \
         ductile damage by DIEM.",
    ),
    number(CRITERIA[0].displacement, DISPLACEMENT),
    number(CRITERIA[0].energy, ENERGY),
    flag(CRITERIA[0].multiplied),
    curve(
        CRITERIA[1].onset,
        "Plastic strain at the onset of damage over (q + k p)/tau, with the von Mises stress, the \
         pressure and the largest shear stress: shear damage by DIEM.",
    ),
    number("diem_shear_pressure", FACTOR),
    number(CRITERIA[1].displacement, DISPLACEMENT),
    number(CRITERIA[1].energy, ENERGY),
    flag(CRITERIA[1].multiplied),
    curve(
        CRITERIA[2].onset,
        "Plastic strain at the onset of damage over (q + k p)/s_1, with the largest principal \
         stress: ductile damage by DIEM.",
    ),
    number("diem_principal_pressure", FACTOR),
    number(CRITERIA[2].displacement, DISPLACEMENT),
    number(CRITERIA[2].energy, ENERGY),
    flag(CRITERIA[2].multiplied),
    number(
        POINTS,
        "Number of failed points through the thickness from which on a shell is removed, below 0 a \
         percentage; without it all.",
    ),
];

/// Growth of damage from onset to failure.
#[derive(Clone, Copy)]
enum DamageGrowth {
    /// Plastic displacement [length].
    Displacement(f64),
    /// Energy over the area of a crack [force/length].
    Energy(f64),
}

/// A criterion of a material.
struct OnsetCriterion {
    /// Its place in [`CRITERIA`].
    kind: usize,
    onset: RampCurve,
    factor: f64,
    growth: DamageGrowth,
    multiplied: bool,
}

/// Damage of a material.
pub struct DiemInput {
    criteria: Vec<OnsetCriterion>,
    failed_points: FailedPoints,
}

/// Returns the material without its damage, and the damage; or all its problems.
pub fn split(material: &Material) -> Result<(Material, Option<DiemInput>), Vec<Problem>> {
    let (own, rest) = divided(material, "diem_");
    if own.parameters.is_empty() {
        return Ok((rest, None));
    }
    let mut parameters = Parameters::new(&own);
    let gissmo = rest.parameters.keys().find(|key| key.starts_with("gissmo_"));
    if let (Some(other), Some(key)) = (gissmo, own.parameters.keys().next()) {
        let help = "a material has one damage: keep one of both kinds";
        parameters.wrong(key, format_args!("is given with {other}"), help);
    }
    let mut criteria = Vec::new();
    for (kind, keys) in CRITERIA.iter().enumerate() {
        criteria.extend(criterion(&mut parameters, kind, keys));
    }
    if !CRITERIA.iter().any(|keys| parameters.given(keys.onset)) {
        let names = CRITERIA.map(|keys| keys.onset).join(", ");
        parameters.wrong(POINTS, "is given without a criterion", format!("give one of {names}"));
    }
    let failed_points = FailedPoints::read(&mut parameters, POINTS);
    parameters.finish()?;
    Ok((rest, Some(DiemInput { criteria, failed_points })))
}

/// Reads a criterion, if it is given.
fn criterion(
    parameters: &mut Parameters<'_>,
    kind: usize,
    keys: &OnsetKeys,
) -> Option<OnsetCriterion> {
    let rows = parameters.ascending(keys.onset, (CURVE, WANTED), |point| point[1] > 0.0);
    let factor = keys.pressure.and_then(|key| parameters.optional(key, "a number", |_| true));
    let [displacement, energy] = [keys.displacement, keys.energy]
        .map(|key| parameters.optional(key, "0 or above", |x| x >= 0.0));
    let multiplied = parameters.flag(keys.multiplied);
    let own = [Some(keys.displacement), Some(keys.energy), Some(keys.multiplied), keys.pressure];
    let Some(rows) = rows else {
        let given: Vec<&str> =
            own.into_iter().flatten().filter(|key| parameters.given(key)).collect();
        for key in given {
            let help = format!("give {} as well, or remove it", keys.onset);
            parameters.wrong(key, format_args!("is given without {}", keys.onset), help);
        }
        return None;
    };
    let growth = match (displacement, energy) {
        (Some(displacement), None) => DamageGrowth::Displacement(displacement),
        (None, Some(energy)) => DamageGrowth::Energy(energy),
        _ => {
            if parameters.given(keys.displacement) == parameters.given(keys.energy) {
                let help = format!("give one of {} and {}", keys.displacement, keys.energy);
                parameters.wrong(keys.onset, "has no way to failure, or two", help);
            }
            return None;
        }
    };
    let onset = RampCurve::new(&rows, 1.0, Beyond::Constant);
    Some(OnsetCriterion { kind, onset, factor: factor.unwrap_or(0.0), growth, multiplied })
}

/// Columns of a criterion: w, u, and u_f where it follows from an energy.
struct OnsetColumns {
    onset: usize,
    displacement: usize,
    end: Option<usize>,
}

/// Damage of a law.
struct Diem {
    criteria: Vec<(OnsetCriterion, OnsetColumns)>,
    columns: DamageColumns,
    /// Columns: size, damage.
    size: usize,
    all: usize,
    failed_points: FailedPoints,
}

impl Diem {
    fn new(
        material: &Material,
        input: DiemInput,
        columns: &mut PointColumns,
    ) -> Result<Self, Vec<Problem>> {
        let DiemInput { criteria, failed_points } = input;
        let with_columns = |criterion: OnsetCriterion| {
            let [onset, displacement, end] = CRITERIA[criterion.kind].columns;
            let by_energy = matches!(criterion.growth, DamageGrowth::Energy(_));
            let places = OnsetColumns {
                onset: columns.add(onset),
                displacement: columns.add(displacement),
                end: by_energy.then(|| columns.add(end)),
            };
            (criterion, places)
        };
        let criteria: Vec<_> = criteria.into_iter().map(with_columns).collect();
        let [size, all] = [SIZE_COLUMN, DAMAGE_COLUMN].map(|name| columns.add(name));
        let Some(columns) = DamageColumns::new(columns) else {
            let key = criteria.first().map_or(POINTS, |(of, _)| CRITERIA[of.kind].onset);
            let what = format!("material '{}': {key} is given", material.name);
            let message = format!("{what}, but the law has no plastic strain");
            return Err(vec![Problem::error(key, message, "remove it")]);
        };
        Ok(Self { criteria, columns, size, all, failed_points })
    }

    /// Returns the damage.
    #[inline(always)]
    fn damage<R: Real>(&self, state: &[R]) -> R {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let (mut largest, mut whole) = (zero, one);
        for (criterion, places) in &self.criteria {
            let begun = state[places.onset].ge(one);
            let end = match (criterion.growth, places.end) {
                (DamageGrowth::Displacement(end), _) => R::splat(end),
                (DamageGrowth::Energy(_), Some(end)) => state[end],
                (DamageGrowth::Energy(_), None) => zero,
            };
            let gradual = R::both(begun, end.gt(zero));
            let share = state[places.displacement] / R::select(gradual, end, one);
            let of_one = R::select(gradual, Real::min(share, one), R::select(begun, one, zero));
            if criterion.multiplied {
                whole = whole * (one - of_one);
            } else {
                largest = Real::max(largest, of_one);
            }
        }
        Real::max(largest, one - whole)
    }
}

impl DamageLaw for Diem {
    fn columns(&self) -> &DamageColumns {
        &self.columns
    }

    #[inline(always)]
    fn intact<R: Real>(&self, state: &[R]) -> R {
        R::splat(1.0) - self.damage(state)
    }

    #[inline(always)]
    fn grow<R: Real>(&self, state: &mut [R], sig: &[R; 6], plastic_strain: R) {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let s = deviator(sig);
        let mises = (R::splat(1.5) * inner(&s, &s)).sqrt();
        let pressure = R::splat(-1.0 / 3.0) * trace(sig);
        let by_principal = self.criteria.iter().any(|(of, _)| of.kind > 0);
        let [shear, major] = if by_principal {
            let values = Principal::new(sig).values;
            let major = Real::max(Real::max(values[0], values[1]), values[2]);
            let minor = Real::min(Real::min(values[0], values[1]), values[2]);
            [R::splat(0.5) * (major - minor), major]
        } else {
            [one, one]
        };
        let over = |top: R, bottom: R| {
            let sound = bottom.abs().gt(zero);
            R::select(sound, top / R::select(sound, bottom, one), zero)
        };
        for (criterion, places) in &self.criteria {
            let with_pressure = R::splat(criterion.factor).mul_add(pressure, mises);
            let measure = match criterion.kind {
                0 => over(-pressure, mises),
                1 => over(with_pressure, shear),
                _ => over(with_pressure, major),
            };
            let before = state[places.onset];
            let step = plastic_strain / criterion.onset.at(measure)[0];
            // Without tension the principal stress is round-off.
            let pulled = major.gt(R::splat(TENSILE) * mises);
            let step = if criterion.kind == 2 { R::select(pulled, step, zero) } else { step };
            let after = before + step;
            state[places.onset] = after;
            let reached = R::both(before.lt(one), after.ge(one));
            if let (DamageGrowth::Energy(energy), Some(end)) = (criterion.growth, places.end) {
                let strong = Real::max(mises, R::splat(R::SMALLEST.sqrt()));
                state[end] = R::select(reached, R::splat(2.0 * energy) / strong, state[end]);
            }
            // The part of the step after onset.
            let part = R::select(reached, (after - one) / R::select(reached, step, one), one);
            let moved = state[self.size] * plastic_strain * part;
            let more = R::select(after.ge(one), moved, zero);
            state[places.displacement] += more;
        }
        state[self.all] = self.damage(state);
    }

    #[inline(always)]
    fn holds<R: Real>(&self, _state: &[R], intact: R) -> R::Mask {
        // Round-off of the sum must not delay failure by a step.
        intact.gt(R::splat(f64::max(1e-12, 16.0 * R::EPSILON)))
    }

    fn failed_points(&self, points: usize, of_law: usize) -> usize {
        self.failed_points.of(points, of_law)
    }
}

/// Adds damage to a law of shells, if there is any.
pub fn shell(
    material: &Material,
    law: Box<dyn PlaneStress>,
    input: Option<DiemInput>,
) -> LawResult {
    let Some(input) = input else { return Ok(law) };
    wrapped::shell(law, |columns| Diem::new(material, input, columns))
}

/// Adds damage to a law of solids, if there is any.
pub fn solid(material: &Material, law: Box<dyn Solid>, input: Option<DiemInput>) -> SolidLawResult {
    let Some(input) = input else { return Ok(law) };
    wrapped::solid(law, |columns| Diem::new(material, input, columns))
}
