//! Honeycomb and other cellular solids, as in `*MAT_HONEYCOMB` and `*MAT_MODIFIED_HONEYCOMB`
//! (LS-DYNA Theory Manual, materials 26 and 126). In the axes a, b, c of the material no component
//! of the stress influences another one:
//! ```text
//! E_i = E_i0 + beta max(E - E_i0, 0),   beta = max over time of (1 - V)/(1 - V_f), from 0 to 1
//! |sigma_i| <= factor(rate) curve_i(1 - V),     with `directional`  curve_i(1 - lambda_i)
//! ```
//! and likewise the shear stresses with the shear moduli; V is the ratio of the volume to that at
//! the start, lambda_i the stretch along an axis (the exponential of the sum of its strain
//! increments), and with `directional` the curve of a shear stress is over the size of the shear
//! strain. At V <= V_f the material is the compacted solid, elastic and perfectly plastic with
//! `youngs_modulus`, `poisson` and `yield_stress`.
//!
//! The element rotates the axes with the stress. Curves are constant before their first point and
//! keep their last slope. Moduli follow the largest compaction so far, unlike those of the source,
//! which follow the present one: if they fell again, a closed path of strain could give energy. The
//! rate is the effective one of the deviator, as a running mean over 12 steps or more, such that
//! the stress it adds in a step is at most that of a quarter of the modulus of the step.
//!
//! The step follows a bound of the modulus in the present state,
//! ```text
//! M = M_0 + beta' max(M_f - M_0, 0) + sqrt(3) V |s|,   M_f = max(3 K, 2 G) of the solid
//! ```
//! with M_0 the largest of E_i0 and 2 G_ij0, s the slopes of the curves by which stresses are
//! limited, since a limited stress falls with its curve where the volume grows, and beta' with the
//! compaction of a next step like this one. With `directional` each slope counts once, times
//! lambda_i, or 2 of a shear.
//!
//! Valid for cells whose walls carry the stress of each direction on their own, with a compacted
//! solid that is stiffer than the cells.
//!
//! Left out: yield surfaces over the angle to the axes, damage in shear, factors of the rate for
//! each component.

use super::parameters::Parameters;
use super::polyline::{Beyond, RampCurve};
use super::tensor::{Symmetric, deviator, inner, rotated};
use super::{
    AXES_COLUMNS, DefaultValue, ELASTIC, Elastic, Form, Law, MaterialAxes, ParameterRow, Solid,
    SolidLawResult, SolidPoint, axes_of,
};
use crumple_math::lanes::{Lane, Lane32, Real, cross, dot};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

/// Curves in the order of the stress.
const CURVES: [&str; 6] = ["crush_a", "crush_b", "crush_c", "crush_ab", "crush_bc", "crush_ca"];
const SHEAR: &str = "crush_shear";
const MODULI: &str = "moduli";
const RATES: &str = "rate_factors";

/// Smallest number of steps of the running mean of the rate.
const STEPS_OF_MEAN: f64 = 12.0;
/// Largest modulus by the change of the rate, over that of the step.
const OF_RATE: f64 = 0.25;

/// The row of this law.
pub const LAW: Law = Law {
    name: "honeycomb",
    meaning: "Honeycomb: six stresses in the axes of the material, each limited by its own curve; \
              `youngs_modulus` and `poisson` are those of the compacted solid.",
    constants: ELASTIC,
    parameters: &[
        ParameterRow {
            key: "yield_stress",
            form: Form::Number,
            otherwise: DefaultValue::Needed,
            range: None,
            meaning: "Yield stress of the compacted solid [force/length^2].",
        },
        ParameterRow {
            key: "compacted_volume",
            form: Form::Number,
            otherwise: DefaultValue::Needed,
            range: None,
            meaning: "Volume over that at the start at which the honeycomb is compacted.",
        },
        ParameterRow {
            key: MODULI,
            form: Form::List("[E_a, E_b, E_c, G_ab, G_bc, G_ca]"),
            otherwise: DefaultValue::Needed,
            range: None,
            meaning: "Moduli along the axes and in shear before compaction; they grow with it to \
                      those of the solid [force/length^2].",
        },
        curve(
            CURVES[0],
            DefaultValue::Needed,
            "Limit of the stress along a over the relative decrease of volume, positive in \
             compression [force/length^2].",
        ),
        curve(
            CURVES[1],
            DefaultValue::Absent,
            "The same along b; `crush_a` if not given [force/length^2].",
        ),
        curve(
            CURVES[2],
            DefaultValue::Absent,
            "The same along c; `crush_a` if not given [force/length^2].",
        ),
        curve(
            SHEAR,
            DefaultValue::Absent,
            "The same of the shear stresses without a curve of their own; `crush_a` if not given \
             [force/length^2].",
        ),
        curve(CURVES[3], DefaultValue::Absent, "The same of the shear stress ab [force/length^2]."),
        curve(CURVES[4], DefaultValue::Absent, "The same of the shear stress bc [force/length^2]."),
        curve(CURVES[5], DefaultValue::Absent, "The same of the shear stress ca [force/length^2]."),
        ParameterRow {
            key: "directional",
            form: Form::Flag,
            otherwise: DefaultValue::Flag(false),
            range: None,
            meaning: "True if each curve is over the nominal strain of its own direction, positive \
                      in compression, or over the size of its shear strain.",
        },
        ParameterRow {
            key: RATES,
            form: Form::List("[[rate, factor], ...]"),
            otherwise: DefaultValue::Absent,
            range: None,
            meaning: "Factors on all curves over the effective strain rate [1/time].",
        },
        number("tension_failure_strain", "Nominal strain along an axis at which a point fails."),
        number("shear_failure_strain", "Shear strain in the axes at which a point fails."),
        vector(
            "direction",
            "Axis a at the start. Without it a goes from node 1 to node 2 of an element, and b is \
             in the plane of its nodes 1, 2 and 4.",
        ),
        vector("direction_2", "Vector in the plane of the axes a and b; with `direction`."),
    ],
    build: None,
    solid: Some(solid),
    cohesive: None,
};

const fn curve(key: &'static str, otherwise: DefaultValue, meaning: &'static str) -> ParameterRow {
    let form = Form::List("[[strain, stress], ...]");
    ParameterRow { key, form, otherwise, range: None, meaning }
}

const fn number(key: &'static str, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise: DefaultValue::Absent, range: None, meaning }
}

const fn vector(key: &'static str, meaning: &'static str) -> ParameterRow {
    let form = Form::List("[x, y, z]");
    ParameterRow { key, form, otherwise: DefaultValue::Absent, range: None, meaning }
}

/// Columns of all honeycombs: logarithm of the volume, largest compaction so far, stiffening, first
/// one of the axes.
const VOLUME: usize = 6;
const COMPACTION: usize = 7;
const STIFFENING: usize = 8;
const AXES: usize = 9;

struct Honeycomb {
    /// M_0 of the stable step, without a Poisson's ratio.
    bound: Elastic,
    /// M_f over M_0, less one, or zero.
    stiffer: f64,
    /// The compacted solid, its yield stress and V_f.
    solid: Elastic,
    yield_stress: f64,
    compacted: f64,
    /// Moduli before compaction, and by how much they grow [force/length^2].
    moduli: [[f64; 2]; 6],
    curves: [RampCurve; 6],
    directional: bool,
    /// Factors over the rate, and their largest slope [time].
    rates: Option<(RampCurve, f64)>,
    /// Logarithmic strain along an axis, and shear strain, of failure; infinite without one.
    failure: [f64; 2],
    axes: MaterialAxes,
    names: Vec<&'static str>,
    /// First columns of the strains, of the rate, and of failure.
    strain: Option<usize>,
    rate: Option<usize>,
    failed: Option<usize>,
}

fn solid(material: &Material) -> SolidLawResult {
    Parameters::new(material).solid_law(read)
}

fn read(mut parameters: Parameters<'_>, solid: Elastic) -> Result<Honeycomb, Vec<Problem>> {
    let positive = |value: f64| value > 0.0;
    let yield_stress = parameters.required("yield_stress", "above 0", positive);
    let compacted =
        parameters.required("compacted_volume", "between 0 and 1", |v| v > 0.0 && v < 1.0);
    let moduli = moduli(&mut parameters).unwrap_or([1.0; 6]);
    let [first, b, c, ab, bc, ca] = CURVES.map(|key| crush_curve(&mut parameters, key));
    let shear = crush_curve(&mut parameters, SHEAR);
    if first.is_none() && !parameters.given(CURVES[0]) {
        parameters.wrong(CURVES[0], "is missing", "give [[strain, stress], ...]");
    }
    let directional = parameters.flag("directional");
    let rates = rate_factors(&mut parameters);
    let tension = parameters.optional("tension_failure_strain", "above 0", positive);
    let sheared = parameters.optional("shear_failure_strain", "above 0", positive);
    let axes = axes(&mut parameters);
    parameters.finish()?;

    let first = first.unwrap_or_default();
    let shear = shear.unwrap_or_else(|| first.clone());
    let curves = [
        first.clone(),
        b.unwrap_or_else(|| first.clone()),
        c.unwrap_or_else(|| first.clone()),
        ab.unwrap_or_else(|| shear.clone()),
        bc.unwrap_or_else(|| shear.clone()),
        ca.unwrap_or_else(|| shear.clone()),
    ]
    .map(|points| RampCurve::new(&points, 1.0, Beyond::Straight));
    let g = solid.shear_modulus();
    let full = [solid.youngs_modulus, solid.youngs_modulus, solid.youngs_modulus, g, g, g];
    let bound = (0..6).map(|i| if i < 3 { 1.0 } else { 2.0 } * moduli[i]).fold(0.0, f64::max);
    let mut names = vec!["volume strain", "compaction", "stiffening"];
    names.extend(AXES_COLUMNS);
    let mut column = |needed: bool, own: &[&'static str]| {
        let first = 6 + names.len();
        needed.then(|| {
            names.extend(own);
            first
        })
    };
    let fails = tension.is_some() || sheared.is_some();
    let of_axes = ["strain aa", "strain bb", "strain cc", "strain ab", "strain bc", "strain ca"];
    let strain = column(directional || fails, &of_axes);
    let rate = column(rates.is_some(), &["strain rate"]);
    let failed = column(fails, &["failed"]);
    Ok(Honeycomb {
        bound: Elastic { youngs_modulus: bound, poisson: 0.0, density: solid.density },
        stiffer: ((3.0 * solid.bulk_modulus()).max(2.0 * g) / bound - 1.0).max(0.0),
        solid,
        yield_stress,
        compacted,
        moduli: std::array::from_fn(|i| [moduli[i], (full[i] - moduli[i]).max(0.0)]),
        curves,
        directional,
        rates,
        failure: [tension.map(f64::ln_1p), sheared].map(|limit| limit.unwrap_or(f64::INFINITY)),
        axes,
        names,
        strain,
        rate,
        failed,
    })
}

/// Returns the six moduli.
fn moduli(parameters: &mut Parameters<'_>) -> Option<[f64; 6]> {
    let given = parameters.get(MODULI);
    let values = match given {
        Some(Param::List(list)) => <[f64; 6]>::try_from(list.as_slice()).ok(),
        _ => None,
    };
    let values = values.filter(|all| all.iter().all(|m| m.is_finite() && *m > 0.0));
    if values.is_none() {
        let what = if given.is_some() { "are not six moduli" } else { "is missing" };
        parameters.wrong(MODULI, what, "give [E_a, E_b, E_c, G_ab, G_bc, G_ca], each above 0");
    }
    values
}

/// Returns the points of a curve: increasing strains, stresses of 0 or above.
fn crush_curve(parameters: &mut Parameters<'_>, key: &'static str) -> Option<Vec<[f64; 2]>> {
    let points = parameters.rows::<2>(key, "[strain, stress]")?;
    let ascends = points.windows(2).all(|two| two[0][0] < two[1][0]);
    if !(ascends && points.iter().all(|point| point[1] >= 0.0)) {
        let help = "give increasing strains, positive in compression, and stresses of 0 or above";
        parameters.wrong(key, "is not such a curve", help);
    }
    Some(points)
}

fn rate_factors(parameters: &mut Parameters<'_>) -> Option<(RampCurve, f64)> {
    let points = parameters.rows::<2>(RATES, "[rate, factor]")?;
    let rises = |two: &[[f64; 2]]| two[0][0] < two[1][0] && two[0][1] <= two[1][1];
    let starts = points.iter().all(|point| point[0] >= 0.0 && point[1] > 0.0);
    if !(starts && points.windows(2).all(rises)) {
        let help = "give increasing rates from 0 on and factors above 0 that do not decrease";
        parameters.wrong(RATES, "are not such factors", help);
        return None;
    }
    let slope = |two: &[[f64; 2]]| (two[1][1] - two[0][1]) / (two[1][0] - two[0][0]);
    let steepest = points.windows(2).map(slope).fold(0.0, f64::max);
    Some((RampCurve::new(&points, 1.0, Beyond::Constant), steepest))
}

fn axes(parameters: &mut Parameters<'_>) -> MaterialAxes {
    let (given, second) = (parameters.given("direction"), parameters.given("direction_2"));
    let vectors = parameters.direction("direction").zip(parameters.direction("direction_2"));
    if given != second {
        let missing = if given { "direction_2" } else { "direction" };
        parameters.wrong(missing, "is missing", "give both vectors, or none of them");
    }
    let Some([a, d]) = vectors.map(<[_; 2]>::from) else { return MaterialAxes::Nodes };
    let normal = cross(a, d);
    if dot(normal, normal) <= 1e-12 * dot(a, a) * dot(d, d) {
        let help = "give a vector that has another direction than `direction`";
        parameters.wrong("direction_2", "is along direction", help);
    }
    MaterialAxes::Vectors([a, d])
}

/// Results of the honeycomb that is not compacted, in the axes of the material.
struct Crushed<R> {
    trial: Symmetric<R>,
    stress: Symmetric<R>,
    /// Bound of the modulus by the slopes of the active curves [force/length^2].
    slope: R,
}

impl Honeycomb {
    #[inline(always)]
    fn solid<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let (state, eps) = (point.state, point.strain);
        let (zero, one, half) = (R::zero(), R::splat(1.0), R::splat(0.5));

        // 1. Strain increment (a tensor) and stress in the axes of the material.
        let axes = axes_of(&state[AXES..]);
        let increment: Symmetric<R> =
            std::array::from_fn(|c| if c < 3 { eps[c] } else { half * eps[c] });
        let increment = rotated(&axes, &increment);
        let before = rotated(&axes, state);

        // 2. Volume and compaction.
        let trace = eps[0] + eps[1] + eps[2];
        state[VOLUME] += trace;
        let volume = state[VOLUME].exp();
        let per = R::splat(1.0 / (1.0 - self.compacted));
        let part = Real::min(Real::max(per * (one - volume), zero), one);
        let compaction = Real::max(state[COMPACTION], part);
        state[COMPACTION] = compaction;
        if let Some(first) = self.strain {
            for (c, &e) in increment.iter().enumerate() {
                state[first + c] += if c < 3 { e } else { e + e };
            }
        }

        // 3. Stress of the honeycomb, and of the solid where it is compacted.
        let Crushed { trial, stress, slope } = self.crush(state, &before, &increment, dt);
        let mut result = stress;
        let norm = |s: &Symmetric<R>| inner(s, s).sqrt();
        let limited = (0..6)
            .fold(zero.gt(zero), |any, c| R::either(any, (trial[c] - stress[c]).abs().gt(zero)));
        let ratio = norm(&stress) / Real::max(norm(&trial), R::splat(R::SMALLEST));
        let mut left = R::select(limited, ratio, one);
        let is_solid = volume.le(R::splat(self.compacted));
        if R::any(is_solid) {
            let (of_solid, flow) = self.compact(&before, &increment);
            result = std::array::from_fn(|c| R::select(is_solid, of_solid[c], stress[c]));
            left = R::select(is_solid, flow, left);
        }

        // 4. Step: the compaction of the next one is ahead by that of this one.
        let ahead = Real::max(-(per * volume * trace), zero);
        let ahead = Real::min(compaction + ahead, one);
        let stiffer = R::splat(1.0 / self.bound.youngs_modulus)
            .mul_add(slope, R::splat(self.stiffer) * ahead);
        let by_rate = match self.rate {
            Some(column) => R::select(state[column].gt(zero), R::splat(OF_RATE), zero),
            None => zero,
        };
        state[STIFFENING] = stiffer + by_rate;

        // 5. Global stress; none in a failed point.
        let back = std::array::from_fn(|i| std::array::from_fn(|k| axes[k][i]));
        let global = rotated(&back, &result);
        state[..6].copy_from_slice(&global);
        if let (Some(failed), Some(first)) = (self.failed, self.strain) {
            let [pulled, sheared] = self.failure.map(|x| R::splat(x.min(f64::from(f32::MAX))));
            let fails = (0..6).fold(state[failed].gt(half), |any, c| {
                let e = state[first + c];
                R::either(any, if c < 3 { e.ge(pulled) } else { e.abs().ge(sheared) })
            });
            state[failed] = R::select(fails, one, zero);
            state[..6].iter_mut().for_each(|s| *s = R::select(fails, zero, *s));
        }
        left
    }

    /// Returns the stress of the honeycomb from that before the step.
    #[inline(always)]
    fn crush<R: Real>(
        &self,
        state: &mut [R],
        before: &Symmetric<R>,
        increment: &Symmetric<R>,
        dt: f64,
    ) -> Crushed<R> {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let volume = state[VOLUME].exp();
        let (mut limits, mut slopes) = ([zero; 6], [zero; 6]);
        for c in 0..6 {
            // Abscissa, and the largest change of the stress with the strain over the slope.
            let (x, rate) = match self.strain.filter(|_| self.directional) {
                None => {
                    let weight = if c < 3 { 3.0f64 } else { 6.0 };
                    (one - volume, R::splat(weight.sqrt()) * volume)
                }
                Some(first) if c < 3 => {
                    let stretch = state[first + c].exp();
                    (one - stretch, stretch)
                }
                Some(first) => (state[first + c].abs(), R::splat(2.0)),
            };
            let [limit, slope] = self.curves[c].at(x);
            limits[c] = Real::max(limit, zero);
            slopes[c] = rate * slope;
        }
        let factor = self.rate_factor(state, &limits, increment, dt);
        let [mut trial, mut stress] = [*before; 2];
        let mut square = zero;
        for c in 0..6 {
            let [first, growth] = self.moduli[c].map(R::splat);
            let modulus = growth.mul_add(state[COMPACTION], first);
            let modulus = if c < 3 { modulus } else { modulus + modulus };
            trial[c] = modulus.mul_add(increment[c], before[c]);
            let limit = factor * limits[c];
            stress[c] = Real::max(Real::min(trial[c], limit), -limit);
            let slope = factor * slopes[c];
            square += R::select(trial[c].abs().gt(limit), slope * slope, zero);
        }
        Crushed { trial, stress, slope: square.sqrt() }
    }

    /// Advances the mean rate and returns its factor on the curves.
    #[inline(always)]
    fn rate_factor<R: Real>(
        &self,
        state: &mut [R],
        limits: &[R; 6],
        increment: &Symmetric<R>,
        dt: f64,
    ) -> R {
        let (Some((factors, steepest)), Some(column)) = (&self.rates, self.rate) else {
            return R::splat(1.0);
        };
        let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let e = deviator(increment);
        let rate = R::splat(per_dt) * (R::splat(2.0 / 3.0) * inner(&e, &e)).sqrt();
        let most = limits.iter().fold(R::zero(), |most, &limit| Real::max(most, limit));
        let viscosity = Real::max(R::splat(*steepest) * most, R::splat(R::SMALLEST));
        let share = R::splat(OF_RATE * self.bound.youngs_modulus * dt) / viscosity;
        let share = Real::min(share, R::splat(1.0 / STEPS_OF_MEAN));
        state[column] = share.mul_add(rate - state[column], state[column]);
        factors.at(state[column])[0]
    }

    /// Returns the stress of the compacted solid from that before the step, and the factor by which
    /// flow reduces its deviator.
    #[inline(always)]
    fn compact<R: Real>(
        &self,
        before: &Symmetric<R>,
        increment: &Symmetric<R>,
    ) -> (Symmetric<R>, R) {
        let [lame, g] = [self.solid.lame(), self.solid.shear_modulus()].map(R::splat);
        let pressure = lame * (increment[0] + increment[1] + increment[2]);
        let trial: Symmetric<R> = std::array::from_fn(|c| {
            let shear = (g + g).mul_add(increment[c], before[c]);
            if c < 3 { shear + pressure } else { shear }
        });
        let s = deviator(&trial);
        let size = (R::splat(1.5) * inner(&s, &s)).sqrt();
        let limit = R::splat(self.yield_stress);
        let flows = size.gt(limit);
        let left = R::select(flows, limit / Real::max(size, limit), R::splat(1.0));
        let lost = left - R::splat(1.0);
        (std::array::from_fn(|c| lost.mul_add(s[c], trial[c])), left)
    }
}

impl Solid for Honeycomb {
    fn history(&self) -> &[&'static str] {
        &self.names
    }
    fn axes(&self) -> Option<MaterialAxes> {
        Some(self.axes)
    }
    fn elastic(&self) -> Elastic {
        self.bound
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
#[path = "honeycomb_tests.rs"]
mod tests;
