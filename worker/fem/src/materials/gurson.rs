//! Plasticity of metals with voids (Gurson 1977; Tvergaard & Needleman 1984), as in `*MAT_GURSON`
//! (LS-DYNA Keyword User's Manual, vol. II, material 120). With the von Mises stress q, the mean
//! stress p, the void fraction f and the yield stress sig_y of the matrix:
//! ```text
//! (q/sig_y)^2 + 2 q1 f* cosh(3 q2 p/(2 sig_y)) - 1 - (q1 f*)^2 = 0
//! f* = f up to f_c, then f_c + (1/q1 - f_c)/(f_F - f_c) (f - f_c)
//! df = (1 - f) tr(d eps_plastic) + A(e) de,   (1 - f) sig_y de = sigma:d eps_plastic
//! A = f_N/(s_N sqrt(2 pi)) exp(-1/2 ((e - e_N)/s_N)^2) in tension, 0 in compression
//! ```
//! with the plastic strain e of the matrix. A point fails at f = f_F.
//!
//! The condition is solved for sig_y: this equivalent stress is a homogeneous convex function of
//! the stress, so flow along its gradient by `(1 - f) de` does the work above. The return is that
//! to the closest point, with the voids at the start of the step (`gurson/flow.rs`).
//!
//! Each lane that yields is returned alone, in double precision.
//!
//! Not included: strain rates; sizes other than for f_F; damage by shear.

mod flow;
mod surface;
#[cfg(test)]
mod tests;

use self::flow::{PlaneSpace, SolidSpace, StressSpace, VoidFlow, Yielding};
use self::surface::{Nucleation, VoidSurface};
use super::failed_points::FailedPoints;
use super::hardening::{HARDENING, Hardening};
use super::parameters::Parameters;
use super::polyline::{Beyond, RampCurve};
use super::tensor::{deviator, inner, trace};
use super::{
    DefaultValue, ELASTIC, Elastic, Form, Law, LawResult, ParameterRow, PlaneStress, Points,
    SIZE_COLUMN, Solid, SolidLawResult, SolidPoint,
};
use crumple_math::lanes::{LANES, LANES32, Lane, Lane32, Lanes, Real};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law {
    name: "gurson",
    meaning: "Plasticity of metals with voids, which fails by their growth.",
    constants: ELASTIC,
    parameters: &[
        HARDENING[0],
        HARDENING[1],
        HARDENING[2],
        HARDENING[3],
        number(VOIDS, DefaultValue::Number(0.0), "Void fraction f at the start."),
        number(Q[0], DefaultValue::Number(1.5), "Factor q1 on the void fraction."),
        number(Q[1], DefaultValue::Number(1.0), "Factor q2 on the mean stress."),
        list(
            NUCLEATION,
            "[f_N, e_N, s_N]",
            "Voids that form at particles: their whole void fraction, and the mean and standard \
             deviation of the plastic strain at which they form.",
        ),
        number(
            CRITICAL,
            DefaultValue::Absent,
            "Void fraction f_c from which on voids coalesce; without it they do not.",
        ),
        number(
            FAILURE,
            DefaultValue::Absent,
            "Void fraction f_F at which a point fails; without it and `failure_void_fractions` no \
             point fails.",
        ),
        list(
            FAILURES,
            "[[size, fraction], ...]",
            "The same over the size of the element [length]: root of the area, cube root of the \
             volume; constant beyond the points.",
        ),
        flag(GROWS, "In compression voids keep their size."),
        flag(CLOSES, "In compression voids may become smaller than at the start."),
        number(
            POINTS,
            DefaultValue::Absent,
            "Number of failed points through the thickness from which on a shell is removed, below \
             0 a percentage; without it all.",
        ),
    ],
    build: Some(build),
    solid: Some(solid),
    cohesive: None,
};

const VOIDS: &str = "void_fraction";
const Q: [&str; 2] = ["q1", "q2"];
const NUCLEATION: &str = "nucleation";
const CRITICAL: &str = "critical_void_fraction";
const FAILURE: &str = "failure_void_fraction";
const FAILURES: &str = "failure_void_fractions";
const GROWS: &str = "voids_only_grow";
const CLOSES: &str = "voids_close";
const POINTS: &str = "failed_points";

const fn number(key: &'static str, otherwise: DefaultValue, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise, range: None, meaning }
}

const fn list(key: &'static str, form: &'static str, meaning: &'static str) -> ParameterRow {
    let otherwise = DefaultValue::Absent;
    ParameterRow { key, form: Form::List(form), otherwise, range: None, meaning }
}

const fn flag(key: &'static str, meaning: &'static str) -> ParameterRow {
    ParameterRow {
        key,
        form: Form::Flag,
        otherwise: DefaultValue::Flag(false),
        range: None,
        meaning,
    }
}

/// Columns after stress: plastic strain of the matrix, void fraction less that at the start,
/// failure, and the size where f_F depends on it.
const STRAIN: usize = 0;
const RISE: usize = 1;
const FAILED: usize = 2;
const SIZE: usize = 3;
const HISTORY: [&str; 4] = ["plastic_strain", "void_fraction_rise", "failed", SIZE_COLUMN];

/// Largest void fraction of a point without failure.
const MOST_VOIDS: f64 = 0.99;

/// Void fraction at failure.
enum VoidFailure {
    None,
    At(f64),
    BySize(RampCurve),
}

/// Behaviour of voids in compression.
#[derive(Clone, Copy)]
enum VoidClosing {
    /// They become smaller, down to this rise of the void fraction.
    Closes(f64),
    /// They keep their size.
    Holds,
}

struct Gurson {
    elastic: Elastic,
    hardening: Hardening,
    surface: VoidSurface,
    voids: f64,
    nucleation: Option<Nucleation>,
    failure: VoidFailure,
    compression: VoidClosing,
    failed_points: FailedPoints,
}

/// The state of a point besides its stress.
#[derive(Clone, Copy)]
struct VoidState {
    /// Plastic strain of the matrix.
    strain: f64,
    /// Void fraction less that at the start.
    rise: f64,
    failed: f64,
    size: f64,
}

fn build(material: &Material) -> LawResult {
    Parameters::new(material).shell_law(read)
}

fn solid(material: &Material) -> SolidLawResult {
    Parameters::new(material).solid_law(read)
}

fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<Gurson, Vec<Problem>> {
    let hardening = Hardening::read(&mut parameters);
    let share = |f: f64| (0.0..1.0).contains(&f);
    let voids = parameters.optional(VOIDS, "from 0 to below 1", share).unwrap_or(0.0);
    let q1 = parameters.optional(Q[0], "above 0", |q| q > 0.0).unwrap_or(1.5);
    let q2 = parameters.optional(Q[1], "above 0", |q| q > 0.0).unwrap_or(1.0);
    let nucleation = nucleation(&mut parameters);
    let critical = parameters.optional(CRITICAL, "from 0 to below 1", share);
    let part = |f: f64| f > 0.0 && f < 1.0;
    let at = parameters.optional(FAILURE, "above 0 and below 1", part);
    let by_size = parameters.rows::<2>(FAILURES, "[[size, fraction], ...]");
    if let Some(rows) = &by_size {
        let ascends = rows.windows(2).all(|two| two[0][0] < two[1][0]);
        if !(ascends && rows.iter().all(|row| row[0] >= 0.0 && part(row[1]))) {
            let help = "give increasing sizes from 0 on, with fractions above 0 and below 1";
            parameters.wrong(FAILURES, "is not such a curve", help);
        }
        if parameters.given(FAILURE) {
            parameters.wrong(FAILURES, format!("is given with {FAILURE}"), "remove one of them");
        }
    }
    let least = by_size.iter().flatten().map(|row| row[1]).chain(at).reduce(f64::min);
    check_order(&mut parameters, q1, [Some(voids), critical, least]);
    if q1 * voids >= 1.0 {
        let help = format!("use a void fraction below 1/q1 = {}", 1.0 / q1);
        parameters.wrong(VOIDS, "leaves no strength", help);
    }
    let [grows, closes] = [GROWS, CLOSES].map(|key| parameters.flag(key));
    if grows && closes {
        parameters.wrong(CLOSES, format!("is given with {GROWS}"), "remove one of them");
    }
    let failed_points = FailedPoints::read(&mut parameters, POINTS);
    parameters.finish()?;
    Ok(Gurson {
        elastic,
        hardening,
        surface: VoidSurface { q1, q2, critical: critical.unwrap_or(f64::INFINITY) },
        voids,
        nucleation,
        failure: match (at, by_size) {
            (_, Some(rows)) => VoidFailure::BySize(RampCurve::new(&rows, 1.0, Beyond::Constant)),
            (Some(at), None) => VoidFailure::At(at),
            (None, None) => VoidFailure::None,
        },
        compression: if grows {
            VoidClosing::Holds
        } else {
            VoidClosing::Closes(if closes { -voids } else { 0.0 })
        },
        failed_points,
    })
}

/// Checks the void fractions at the start, at coalescence and at failure, where they are given.
fn check_order(
    parameters: &mut Parameters<'_>,
    q1: f64,
    [voids, critical, failure]: [Option<f64>; 3],
) {
    let Some(failure) = failure else {
        if critical.is_some() {
            let help = format!("give {FAILURE} above it, at which the strength is lost");
            parameters.wrong(CRITICAL, "is given without a fraction of failure", help);
        }
        return;
    };
    for (key, before) in [(VOIDS, voids), (CRITICAL, critical)] {
        if let Some(before) = before.filter(|before| *before >= failure) {
            let what = format!("is {before}, which is not below the fraction of failure {failure}");
            parameters.wrong(key, what, "use a smaller value");
        }
    }
    if let Some(critical) = critical.filter(|critical| q1 * critical >= 1.0) {
        let what = format!("is {critical}, at which no strength is left");
        parameters.wrong(CRITICAL, what, format!("use a value below 1/q1 = {}", 1.0 / q1));
    }
}

fn nucleation(parameters: &mut Parameters<'_>) -> Option<Nucleation> {
    let list = match parameters.get(NUCLEATION)? {
        Param::List(list) => <[f64; 3]>::try_from(list.as_slice()).ok(),
        _ => None,
    };
    let sound = |&[fraction, mean, deviation]: &[f64; 3]| {
        (0.0..1.0).contains(&fraction) && mean >= 0.0 && deviation > 0.0
    };
    let list = list.filter(|list| list.iter().all(|x| x.is_finite()) && sound(list));
    if list.is_none() {
        let help = "give three numbers: a fraction below 1, a strain from 0 on, one above 0";
        parameters.wrong(NUCLEATION, "is not [f_N, e_N, s_N]", help);
    }
    list.map(|[fraction, mean, deviation]| Nucleation { fraction, mean, deviation })
}

impl Gurson {
    fn columns(&self) -> usize {
        if matches!(self.failure, VoidFailure::BySize(_)) { SIZE + 1 } else { SIZE }
    }

    /// Returns the void fraction of a point that fails.
    fn failure_fraction(&self, size: f64) -> f64 {
        match &self.failure {
            VoidFailure::None => f64::INFINITY,
            VoidFailure::At(fraction) => *fraction,
            VoidFailure::BySize(curve) => curve.at(size)[0],
        }
    }

    /// Returns a stress to the surface; the state gets the plastic strain, the voids and failure.
    /// Returns nothing inside the surface.
    fn returned(
        &self,
        space: &impl StressSpace,
        trial: [f64; 3],
        state: &mut VoidState,
    ) -> Option<VoidFlow> {
        let failure = self.failure_fraction(state.size);
        let voids = self.voids + state.rise;
        let weakening = self.surface.weakening(voids, failure);
        let [yield_stress, _] = self.hardening.at(state.strain);
        if self.surface.holds(space.invariants(trial), weakening, yield_stress) {
            return None;
        }
        let yielding = Yielding {
            surface: &self.surface,
            weakening,
            hardening: &self.hardening,
            strain: state.strain,
            matrix: 1.0 - voids,
        };
        let flow = yielding.flow(space, trial);
        let strain = flow.multiplier / (1.0 - voids);
        let grown = (1.0 - voids) * flow.volume;
        let rise = match self.compression {
            VoidClosing::Holds => state.rise + grown.max(0.0),
            VoidClosing::Closes(least) => (state.rise + grown).max(least),
        };
        let [_, mean] = space.invariants(flow.stress);
        let formed = match &self.nucleation {
            Some(nucleation) if mean > 0.0 => nucleation.rate(state.strain + 0.5 * strain) * strain,
            _ => 0.0,
        };
        state.strain += strain;
        state.rise = (rise + formed).min(MOST_VOIDS - self.voids);
        if self.voids + state.rise >= failure {
            state.failed = 1.0;
        }
        Some(flow)
    }

    /// Updates the points of a group of so many lanes; `lanes` makes one of their numbers.
    #[inline(always)]
    fn points<R: Real>(
        &self,
        points: Points<'_, R>,
        count: usize,
        lanes: impl Fn(&[f64; LANES32]) -> R,
    ) {
        const STRESS: usize = 3;
        let plane = PlaneSpace { elastic: self.elastic.plane_stress() };
        let [c11, c12, g] = plane.elastic.map(R::splat);
        let Elastic { youngs_modulus, poisson, .. } = self.elastic;
        let across = R::splat(-poisson / youngs_modulus);
        let states = points.state.chunks_exact_mut(STRESS + self.columns());
        for ((state, eps), eps_z) in states.zip(points.strain).zip(points.thickness_strain) {
            let before = state[0] + state[1];
            state[0] = c11.mul_add(eps[0], c12.mul_add(eps[1], state[0]));
            state[1] = c11.mul_add(eps[1], c12.mul_add(eps[0], state[1]));
            state[2] = g.mul_add(eps[2], state[2]);
            let (stress, history) = state.split_at_mut(STRESS);
            let mut after = [[0.0; LANES32]; 4];
            self.lanes(stress, history, count, &lanes, |trial: &[f64; STRESS], state, lane| {
                let Some(flow) = self.returned(&plane, *trial, state) else { return };
                (0..3).for_each(|k| after[k][lane] = flow.stress[k] - trial[k]);
                after[3][lane] = flow.thickness;
            });
            // The increment is added, so that elastic lanes keep their bits.
            for (stress, after) in stress.iter_mut().zip(&after) {
                *stress += lanes(after);
            }
            Self::zero_failed(stress, history);
            let change = (state[0] + state[1]) - before;
            *eps_z = across.mul_add(change, lanes(&after[3]));
        }
    }

    #[inline(always)]
    fn point<R: Real>(
        &self,
        point: SolidPoint<'_, R>,
        count: usize,
        lanes: impl Fn(&[f64; LANES32]) -> R,
    ) -> R {
        const STRESS: usize = 6;
        let (lame, g) = (self.elastic.lame(), self.elastic.shear_modulus());
        let space = SolidSpace { three_g: 3.0 * g, bulk: self.elastic.bulk_modulus() };
        let (lame, g) = (R::splat(lame), R::splat(g));
        let eps = point.strain;
        let pressure = lame * (eps[0] + eps[1] + eps[2]);
        for c in 0..3 {
            point.state[c] += (g + g).mul_add(eps[c], pressure);
            point.state[3 + c] = g.mul_add(eps[3 + c], point.state[3 + c]);
        }
        let (stress, history) = point.state.split_at_mut(STRESS);
        let mut after = [[0.0; LANES32]; STRESS];
        let mut lost = [0.0; LANES32];
        self.lanes(stress, history, count, &lanes, |trial: &[f64; STRESS], state, lane| {
            let s = deviator(trial);
            let (mises, mean) = ((1.5 * inner(&s, &s)).sqrt(), trace(trial) / 3.0);
            let Some(flow) = self.returned(&space, [mises, mean, 0.0], state) else { return };
            let [mises_after, mean, _] = flow.stress;
            let kept = if mises > 0.0 { mises_after.max(0.0) / mises } else { 1.0 };
            for (k, after) in after.iter_mut().enumerate() {
                let direct = if k < 3 { mean } else { 0.0 };
                after[lane] = kept * s[k] + direct - trial[k];
            }
            lost[lane] = 1.0 - kept;
        });
        for (stress, after) in stress.iter_mut().zip(&after) {
            *stress += lanes(after);
        }
        Self::zero_failed(stress, history);
        R::splat(1.0) - lanes(&lost)
    }

    /// Returns the trial stress of each lane that has not failed by `one`, and stores the history.
    #[inline(always)]
    fn lanes<R: Real, const N: usize>(
        &self,
        stress: &[R],
        history: &mut [R],
        count: usize,
        lanes: &impl Fn(&[f64; LANES32]) -> R,
        mut one: impl FnMut(&[f64; N], &mut VoidState, usize),
    ) {
        let mut kept = [[0.0; SIZE]; LANES32];
        for (lane, kept) in kept.iter_mut().enumerate().take(count) {
            let trial: [f64; N] = std::array::from_fn(|k| stress[k].lane(lane));
            let mut state = VoidState {
                strain: history[STRAIN].lane(lane),
                rise: history[RISE].lane(lane),
                failed: history[FAILED].lane(lane),
                size: history.get(SIZE).map_or(0.0, |size| size.lane(lane)),
            };
            if state.failed < 0.5 && trial != [0.0; N] {
                one(&trial, &mut state, lane);
            }
            (kept[STRAIN], kept[RISE]) = (state.strain, state.rise);
            kept[FAILED] = state.failed;
        }
        for (k, column) in history.iter_mut().enumerate().take(SIZE) {
            *column = lanes(&kept.map(|of_lane| of_lane[k]));
        }
    }

    /// Takes the stress of failed lanes away.
    #[inline(always)]
    fn zero_failed<R: Real>(stress: &mut [R], history: &[R]) {
        let alive = history[FAILED].lt(R::splat(0.5));
        stress.iter_mut().for_each(|s| *s = R::select(alive, *s, R::zero()));
    }
}

impl PlaneStress for Gurson {
    fn history(&self) -> &[&'static str] {
        &HISTORY[..self.columns()]
    }
    fn adds_stress(&self) -> bool {
        true
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn initial_yield_stress(&self) -> f64 {
        self.hardening.at(0.0)[0]
    }
    fn failed_points(&self, points: usize) -> usize {
        self.failed_points.of(points, points)
    }
    fn update(&self, points: Points<'_, Lane>, _dt: f64) {
        self.points(points, LANES, |all| Lane::from_array(std::array::from_fn(|k| all[k])));
    }
    fn update_short(&self, points: Points<'_, Lane32>, _dt: f64) {
        self.points(points, LANES32, |all| Lane32::from_array(*all));
    }
    fn update_one(&self, points: Points<'_, f64>, _dt: f64) {
        self.points(points, 1, |all| all[0]);
    }
}

impl Solid for Gurson {
    fn history(&self) -> &[&'static str] {
        &HISTORY[..self.columns()]
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
    fn update(&self, point: SolidPoint<'_, Lane>, _dt: f64) -> Lane {
        self.point(point, LANES, |all| Lane::from_array(std::array::from_fn(|k| all[k])))
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, _dt: f64) -> Lane32 {
        self.point(point, LANES32, |all| Lane32::from_array(*all))
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, _dt: f64) -> f64 {
        self.point(point, 1, |all| all[0])
    }
}
