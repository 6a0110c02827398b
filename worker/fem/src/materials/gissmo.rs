//! Damage by plastic strain over the triaxiality of stress, which any plastic law can have, as
//! `*MAT_ADD_DAMAGE_GISSMO` (Neukamm, Feucht & Haufe 2009; LS-DYNA Keyword User's Manual, vol. II).
//!
//! With the triaxiality eta, the mean stress over the von Mises stress, and the plastic strain e:
//! ```text
//! dD = n/(c e_f(eta)) D^(1 - 1/n) de,   dF = n/e_c(eta) F^(1 - 1/n) de
//! sigma = (1 - ((D - D_c)/(1 - D_c))^m) sigma~   where F >= 1,   sigma~ before
//! ```
//! D_c is the damage at which F reaches one, or a constant; a point fails at D = 1. The roots of D
//! and F, `D^(1/n)`, grow by `de/(c e_f)`, which is the law without an error of the step. c is a
//! factor of the size of the element: the root of the area of a shell, the cube root of the volume
//! of a solid.
//!
//! The law computes the effective stress sigma~, from which eta follows.
//!
//! Not included: strain rates, Lode's angle, sizes that depend on the triaxiality.

#[cfg(test)]
mod tests;

use super::damaged::{DamageColumns, DamageLaw};
use super::failed_points::FailedPoints;
use super::parameters::{Parameters, divided};
use super::polyline::{Beyond, RampCurve};
use super::tensor::{deviator, inner, trace};
use super::wrapped::{self, PointColumns};
use super::{DefaultValue, Form, LawResult, ParameterRow, PlaneStress, Solid, SolidLawResult};
use crumple_math::lanes::Real;
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

const FAILURE: &str = "gissmo_failure_strain";
const CRITICAL: &str = "gissmo_critical_strain";
const CRITICAL_DAMAGE: &str = "gissmo_critical_damage";
const EXPONENT: &str = "gissmo_exponent";
const FADING: &str = "gissmo_fading_exponent";
/// The key of the factors by size.
pub const SIZES: &str = "gissmo_size_factors";
const POINTS: &str = "gissmo_failed_points";

/// Column of the size of the element, which the element stores [length].
pub const SIZE_COLUMN: &str = "size";

const CURVE: &str = "[[triaxiality, strain], ...]";

/// Creates a row of a curve.
const fn curve(key: &'static str, meaning: &'static str) -> ParameterRow {
    ParameterRow {
        key,
        form: Form::List(CURVE),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning,
    }
}

/// Creates a row of a number.
const fn number(key: &'static str, otherwise: DefaultValue, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise, range: None, meaning }
}

/// Keys of all plastic laws.
pub const GISSMO: &[ParameterRow] = &[
    curve(
        FAILURE,
        "Plastic strain to failure over the triaxiality, constant beyond the points: damage by \
         GISSMO.",
    ),
    curve(
        CRITICAL,
        "Plastic strain over the triaxiality from which on damage reduces the stress; without it \
         and `gissmo_critical_damage` the stress acts until failure.",
    ),
    number(
        CRITICAL_DAMAGE,
        DefaultValue::Absent,
        "Damage from which on it reduces the stress, in place of `gissmo_critical_strain`.",
    ),
    number(
        EXPONENT,
        DefaultValue::Number(1.0),
        "Exponent n of damage: at a constant triaxiality it is the n-th power of the plastic \
         strain over that to failure.",
    ),
    number(FADING, DefaultValue::Number(1.0), "Exponent m of the loss of stress."),
    ParameterRow {
        key: SIZES,
        form: Form::List("[[size, factor], ...]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Factor on the strain to failure over the size of the element [length]: root of \
                  the area, cube root of the volume; constant beyond the points.",
    },
    number(
        POINTS,
        DefaultValue::Absent,
        "Number of failed points through the thickness from which on a shell is removed, below 0 a \
         percentage; without it all.",
    ),
];

/// Damage of a material.
pub struct GissmoInput {
    failure: RampCurve,
    critical: Critical,
    exponent: f64,
    fading: f64,
    sizes: Option<RampCurve>,
    failed_points: FailedPoints,
}

/// Start of the loss of stress.
enum Critical {
    /// Where F, with these strains, reaches one.
    Strain(RampCurve),
    /// At this damage.
    Damage(f64),
}

/// Returns the material without its damage, and the damage; or all its problems.
pub fn split(material: &Material) -> Result<(Material, Option<GissmoInput>), Vec<Problem>> {
    let (own, rest) = divided(material, "gissmo_");
    if own.parameters.is_empty() {
        return Ok((rest, None));
    }
    let mut parameters = Parameters::new(&own);
    let strains = |points: &[f64; 2]| points[1] > 0.0;
    let wanted = "and strains above 0";
    let failure = parameters.ascending(FAILURE, (CURVE, wanted), strains);
    if !parameters.given(FAILURE) {
        parameters.wrong(FAILURE, "is missing", "the other keys of damage need it");
    }
    let of_critical = parameters.ascending(CRITICAL, (CURVE, wanted), strains);
    let share = |d: f64| (0.0..1.0).contains(&d);
    let damage = parameters.optional(CRITICAL_DAMAGE, "from 0 to below 1", share);
    if of_critical.is_some() && damage.is_some() {
        parameters.wrong(
            CRITICAL_DAMAGE,
            format!("is given with {CRITICAL}"),
            "remove one of them",
        );
    }
    let mut exponent = |key| parameters.optional(key, "above 0", |n| n > 0.0).unwrap_or(1.0);
    let [exponent, fading] = [EXPONENT, FADING].map(&mut exponent);
    let sizes = parameters.ascending(
        SIZES,
        ("[[size, factor], ...]", "sizes from 0 on and factors above 0"),
        |point| point[0] >= 0.0 && point[1] > 0.0,
    );
    let failed_points = FailedPoints::read(&mut parameters, POINTS);
    parameters.finish()?;
    let ramps = |points: Vec<[f64; 2]>| RampCurve::new(&points, 1.0, Beyond::Constant);
    let critical = match of_critical {
        Some(points) => Critical::Strain(ramps(points)),
        None => Critical::Damage(damage.unwrap_or(1.0)),
    };
    let failure = ramps(failure.unwrap_or_default());
    let sizes = sizes.map(ramps);
    let input = GissmoInput { failure, critical, exponent, fading, sizes, failed_points };
    Ok((rest, Some(input)))
}

/// Damage of a law.
struct Gissmo {
    input: GissmoInput,
    columns: DamageColumns,
    /// Columns: root of damage, root of F and damage at which it reached one, size.
    root: usize,
    forming: Option<[usize; 2]>,
    size: Option<usize>,
}

impl Gissmo {
    fn new(
        material: &Material,
        input: GissmoInput,
        columns: &mut PointColumns,
    ) -> Result<Self, Vec<Problem>> {
        let root = columns.add("gissmo damage root");
        let forming = matches!(input.critical, Critical::Strain(_))
            .then(|| ["gissmo forming root", "gissmo critical damage"].map(|c| columns.add(c)));
        let size = input.sizes.is_some().then(|| columns.add(SIZE_COLUMN));
        let Some(columns) = DamageColumns::new(columns) else {
            let what = format!("material '{}': {FAILURE} is given", material.name);
            let message = format!("{what}, but the law has no plastic strain");
            return Err(vec![Problem::error(FAILURE, message, "remove it")]);
        };
        Ok(Self { input, columns, root, forming, size })
    }

    /// Returns the damage with this root.
    #[inline(always)]
    fn damage<R: Real>(&self, root: R) -> R {
        let root = Real::min(root, R::splat(1.0));
        match self.input.exponent {
            1.0 => root,
            n => {
                let any = root.gt(R::zero());
                R::select(any, root.powf_where(n, any), R::zero())
            }
        }
    }
}

impl DamageLaw for Gissmo {
    fn columns(&self) -> &DamageColumns {
        &self.columns
    }

    #[inline(always)]
    fn intact<R: Real>(&self, state: &[R]) -> R {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let critical = match (&self.input.critical, self.forming) {
            (Critical::Damage(1.0), _) => return one,
            (Critical::Damage(damage), _) => R::splat(*damage),
            (Critical::Strain(_), Some([forming, critical])) => {
                R::select(state[forming].ge(one), state[critical], one)
            }
            (Critical::Strain(_), None) => return one,
        };
        let room = one - critical;
        let fades = room.gt(zero);
        let beyond = (self.damage(state[self.root]) - critical) / R::select(fades, room, one);
        let beyond = Real::min(Real::max(R::select(fades, beyond, zero), zero), one);
        let lost = match self.input.fading {
            1.0 => beyond,
            m => {
                let any = beyond.gt(zero);
                R::select(any, beyond.powf_where(m, any), zero)
            }
        };
        one - lost
    }

    #[inline(always)]
    fn grow<R: Real>(&self, state: &mut [R], sig: &[R; 6], plastic_strain: R) {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let s = deviator(sig);
        let mises = (R::splat(1.5) * inner(&s, &s)).sqrt();
        let is_loaded = mises.gt(zero);
        let triaxiality = R::splat(1.0 / 3.0) * trace(sig) / R::select(is_loaded, mises, one);
        let mut limit = self.input.failure.at(triaxiality)[0];
        if let (Some(curve), Some(size)) = (&self.input.sizes, self.size) {
            limit = limit * curve.at(state[size])[0];
        }
        let (before, more) = (state[self.root], plastic_strain / limit);
        state[self.root] = before + more;
        if let (Critical::Strain(curve), Some([forming, critical])) =
            (&self.input.critical, self.forming)
        {
            let old = state[forming];
            let step = plastic_strain / curve.at(triaxiality)[0];
            let new = old + step;
            let reached = R::both(old.lt(one), new.ge(one));
            // The part of the step before F = 1.
            let part = (one - old) / R::select(reached, step, one);
            let damage = self.damage(part.mul_add(more, before));
            state[forming] = new;
            state[critical] = R::select(reached, damage, state[critical]);
        }
    }

    #[inline(always)]
    fn holds<R: Real>(&self, state: &[R], _intact: R) -> R::Mask {
        // Round-off of the sum must not delay failure by a step.
        state[self.root].lt(R::splat(1.0 - f64::max(1e-12, 16.0 * R::EPSILON)))
    }

    fn failed_points(&self, points: usize, of_law: usize) -> usize {
        self.input.failed_points.of(points, of_law)
    }
}

/// Adds damage to a law of shells, if there is any.
pub fn shell(
    material: &Material,
    law: Box<dyn PlaneStress>,
    input: Option<GissmoInput>,
) -> LawResult {
    let Some(input) = input else { return Ok(law) };
    wrapped::shell(law, |columns| Gissmo::new(material, input, columns))
}

/// Adds damage to a law of solids, if there is any.
pub fn solid(
    material: &Material,
    law: Box<dyn Solid>,
    input: Option<GissmoInput>,
) -> SolidLawResult {
    let Some(input) = input else { return Ok(law) };
    wrapped::solid(law, |columns| Gissmo::new(material, input, columns))
}
