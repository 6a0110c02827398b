//! Orthotropic plies of fibre composites: elastic along their axes a (fibres) and b (matrix), and
//! failing by the criteria of Chang & Chang (1987, J. Compos. Mater. 21) or, in the matrix, of
//! Tsai & Wu (1971, J. Compos. Mater. 5).
//!
//! With the strengths X_T, X_C along a, Y_T, Y_C along b and S in shear a stress is on its limit if
//! ```text
//! fibre, tension       (s_a/X_T)^2 + beta (s_ab/S)^2 = 1
//! fibre, compression   (s_a/X_C)^2 = 1
//! matrix, tension      (s_b/Y_T)^2 + (s_ab/S)^2 = 1
//! matrix, compression  (s_b/2S)^2 + ((Y_C/2S)^2 - 1) s_b/Y_C + (s_ab/S)^2 = 1
//! matrix, Tsai-Wu      s_b^2/(Y_C Y_T) + (1/Y_T - 1/Y_C) s_b + (s_ab/S)^2 = 1
//! ```
//! With `shear_energy` the term of the shear in all criteria but that of Tsai and Wu is the elastic
//! energy of its nonlinear shear over that at the strength (`*MAT_COMPOSITE_DAMAGE`; Chang & Chang
//! 1987),
//! ```text
//! (s_ab^2/(2 G) + 3/4 alpha s_ab^4)/(S^2/(2 G) + 3/4 alpha S^4)   in place of   (s_ab/S)^2
//! ```
//!
//! A stress beyond a limit is scaled back to it: s_b and s_ab for the matrix, s_a for fibres, with
//! s_ab if beta is above 0. The strain that this takes from the elastic one is along the same
//! components, so that failure dissipates and a ply unloads elastically. At first the limit is the
//! strength, in later steps the residual fraction of it. In a monotonic path this is the plateau at
//! the strength of Matzenmiller & Schweizerhof (1991). After compressive failure of the matrix the
//! strengths along a may be lower.
//!
//! A ply fails, and loses all its stress, at the largest strains; without one for tension along a,
//! when X_T is reached. Shear is `g = t/G + alpha t^3` (Chang & Chang 1987).
//!
//! Valid for plies in plane stress with strains of a few per cent, since the increments are summed
//! along axes that are fixed in the element.
//!
//! Left out: strengths over the strain rate, lower strengths next to failed elements, failure by
//! transverse shear, delamination, the strain through the thickness.

use super::axes::{
    ANGLE, DIRECTION, DIRECTION_COLUMNS, Orientation, Orthotropic, linear, strain_along,
    stress_across, stress_along,
};
use super::parameters::Parameters;
use super::{
    DefaultValue, ELASTIC, Elastic, Form, Law, LawResult, ParameterRow, PlaneStress, Points,
};
use crumple_math::lanes::{Lane, Lane32, Real};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law {
    name: "orthotropic",
    meaning: "Orthotropic ply of a composite: `youngs_modulus` is along its axis a (the fibres), \
              `poisson` the contraction along a due to tension along b. With strengths it fails.",
    constants: ELASTIC,
    parameters: &[
        needed("youngs_modulus_b", "Young's modulus along b [force/length^2]."),
        needed("shear_modulus", "Shear modulus in the plane [force/length^2]."),
        number("shear_modulus_bc", TRANSVERSE),
        number("shear_modulus_ca", TRANSVERSE),
        DIRECTION,
        ANGLE,
        number("strength_tension_a", "Tensile strength along a [force/length^2]."),
        number("strength_compression_a", "Compressive strength along a [force/length^2]."),
        number("strength_tension_b", "Tensile strength along b [force/length^2]."),
        number("strength_compression_b", "Compressive strength along b [force/length^2]."),
        number("strength_shear", "Shear strength [force/length^2]."),
        ParameterRow {
            key: "tsai_wu",
            form: Form::Flag,
            otherwise: DefaultValue::Flag(false),
            range: None,
            meaning: "True for failure of the matrix by Tsai and Wu instead of Chang and Chang.",
        },
        number("shear_weight", "Weight beta of shear in tensile failure of the fibres, 0 to 1."),
        number("shear_nonlinearity", "alpha in g = t/G + alpha t^3 [length^6/force^3]."),
        ParameterRow {
            key: "shear_energy",
            form: Form::Flag,
            otherwise: DefaultValue::Flag(false),
            range: None,
            meaning: "True if shear counts by the energy of `shear_nonlinearity`, not by the \
                      square of its stress.",
        },
        ParameterRow {
            key: "residual_strengths",
            form: Form::List("[tension a, compression a, tension b, compression b, shear]"),
            otherwise: DefaultValue::Absent,
            range: None,
            meaning: "Strengths after failure as fractions of those before; 1 if not given.",
        },
        number(
            "crushed_tension_a",
            "Tensile strength along a after compressive failure of the matrix [force/length^2].",
        ),
        number(
            "crushed_compression_a",
            "Compressive strength along a after compressive failure of the matrix \
             [force/length^2].",
        ),
        number(
            "failure_strain_tension_a",
            "Tensile strain along a at which the ply loses its stress; without it the ply does so \
             when its tensile strength along a is reached.",
        ),
        number(
            "failure_strain_compression_a",
            "The same for compression along a, a positive number.",
        ),
        number("failure_strain_b", "The same for tension and compression along b."),
        number(
            "failure_strain_shear",
            "The same for the shear strain, which is engineering shear.",
        ),
        number(
            "failure_strain_effective",
            "The same for sqrt(4/3 (e_a^2 + e_a e_b + e_b^2 + e_ab^2)), with e_ab half the \
             engineering shear.",
        ),
    ],
    build: Some(build),
    solid: None,
    cohesive: None,
};

const TRANSVERSE: &str = "Transverse shear modulus; that in the plane if not given \
                          [force/length^2].";

const fn number(key: &'static str, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise: DefaultValue::Absent, range: None, meaning }
}

const fn needed(key: &'static str, meaning: &'static str) -> ParameterRow {
    ParameterRow { otherwise: DefaultValue::Needed, ..number(key, meaning) }
}

/// Columns of a point: after the stress the direction of the axis a, which elastic plies have
/// alone; then the strain along the axes, the modes that have failed, and the loss of all stress.
const COSINE: usize = 3;
const SINE: usize = 4;
const STRAIN: usize = 5;
const MODES: usize = 8;
const FAILED: usize = 12;
const HISTORY: [&str; 10] = [
    DIRECTION_COLUMNS[0],
    DIRECTION_COLUMNS[1],
    "strain a",
    "strain b",
    "strain ab",
    "failed tension a",
    "failed compression a",
    "failed tension b",
    "failed compression b",
    "failed",
];

/// Smallest residual strength as a fraction of the strength: a stress is divided by it.
const LEAST_RESIDUAL: f64 = 1e-6;
/// Iterations for the nonlinear shear. Newton's method squares its error, which is the square of
/// the strain increment over the strain at first.
const SHEAR_ITERATIONS: usize = 5;

struct Ply {
    density: f64,
    stiffness: Orthotropic,
    /// Transverse shear moduli G_ca and G_bc [force/length^2].
    transverse: [f64; 2],
    orientation: Orientation,
    failure: Option<PlyFailure>,
}

/// Constants of a ply that fails. Strengths that are not given are infinite.
struct PlyFailure {
    /// X_T and X_C before and after compressive failure of the matrix [force/length^2].
    fibre: [[f64; 2]; 2],
    /// Reciprocal of S [length^2/force].
    shear: f64,
    /// Coefficients of s_b^2 and s_b in the criteria of the matrix, for tension and compression.
    matrix: [[f64; 2]; 2],
    shear_weight: f64,
    shear_nonlinearity: f64,
    /// Factors c and k of the square of the shear: `(1 + c s_ab^2) k`.
    shear_energy: [f64; 2],
    /// Residual fractions of the strengths: the four modes, and shear.
    residual: [f64; 5],
    /// Largest strains: tension a, compression a, b, shear, effective; infinite if not given.
    strains: [f64; 5],
    /// True if a ply fails when X_T is reached.
    at_strength: bool,
}

fn build(material: &Material) -> LawResult {
    Parameters::new(material).shell_law(read)
}

fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<Ply, Vec<Problem>> {
    let positive = |value: f64| value > 0.0;
    let eb = parameters.required("youngs_modulus_b", "above 0", positive);
    let g = parameters.required("shear_modulus", "above 0", positive);
    let transverse = ["shear_modulus_ca", "shear_modulus_bc"]
        .map(|key| parameters.optional(key, "above 0", positive).unwrap_or(g));
    let moduli = [elastic.youngs_modulus, eb, g];
    let stiffness = Orthotropic::new(&mut parameters, moduli, elastic.poisson, "ply");
    let orientation = Orientation::read(&mut parameters);
    let failure = failure(&mut parameters, g);
    parameters.finish()?;
    Ok(Ply { density: elastic.density, stiffness, transverse, orientation, failure })
}

/// Reads strengths and largest strains.
fn failure(parameters: &mut Parameters<'_>, shear_modulus: f64) -> Option<PlyFailure> {
    const STRENGTHS: [&str; 5] = [
        "strength_tension_a",
        "strength_compression_a",
        "strength_tension_b",
        "strength_compression_b",
        "strength_shear",
    ];
    const STRAINS: [&str; 5] = [
        "failure_strain_tension_a",
        "failure_strain_compression_a",
        "failure_strain_b",
        "failure_strain_shear",
        "failure_strain_effective",
    ];
    let positive = |value: f64| value > 0.0;
    let mut or_none = |key| parameters.optional(key, "above 0", positive).unwrap_or(f64::INFINITY);
    let [xt, xc, yt, yc, s] = STRENGTHS.map(&mut or_none);
    let strains = STRAINS.map(&mut or_none);
    let crushed = [("crushed_tension_a", xt), ("crushed_compression_a", xc)]
        .map(|(key, before)| parameters.optional(key, "above 0", positive).unwrap_or(before));
    let share = |value: f64| (0.0..=1.0).contains(&value);
    let shear_weight = parameters.optional("shear_weight", "from 0 to 1", share).unwrap_or(0.0);
    let alpha = parameters.optional("shear_nonlinearity", "0 or above", |a| a >= 0.0);
    let tsai_wu = parameters.flag("tsai_wu");
    let by_energy = parameters.flag("shear_energy");
    if by_energy && tsai_wu {
        let help = "use the criterion of Chang and Chang with it";
        parameters.wrong("shear_energy", "is true with tsai_wu", help);
    }
    if tsai_wu && ![yt, yc, s].iter().all(|strength| strength.is_finite()) {
        let help = "give strength_tension_b, strength_compression_b and strength_shear";
        parameters.wrong("tsai_wu", "is true without the strengths of the matrix", help);
    }
    let residual = residual(parameters);
    let fails = [xt, xc, yt, yc, s].iter().chain(&strains).any(|limit| limit.is_finite())
        || alpha.is_some_and(|alpha| alpha > 0.0);
    fails.then(|| PlyFailure {
        fibre: [[xt, crushed[0].min(xt)], [xc, crushed[1].min(xc)]],
        shear: 1.0 / s,
        matrix: if tsai_wu {
            [[1.0 / (yc * yt), 1.0 / yt - 1.0 / yc]; 2]
        } else {
            [[1.0 / (yt * yt), 0.0], crushing(yc, s)]
        },
        shear_weight,
        shear_nonlinearity: alpha.unwrap_or(0.0),
        shear_energy: match 1.5 * alpha.unwrap_or(0.0) * shear_modulus {
            c if by_energy && c > 0.0 && s.is_finite() => [c, 1.0 / (1.0 + c * s * s)],
            _ => [0.0, 1.0],
        },
        residual,
        strains,
        at_strength: strains[0].is_infinite(),
    })
}

/// Returns the coefficients of s_b^2 and s_b for compression of the matrix by Chang and Chang.
/// Without a shear strength the limit is Y_C, without Y_C there is none.
fn crushing(yc: f64, s: f64) -> [f64; 2] {
    if yc.is_infinite() {
        [0.0; 2]
    } else if s.is_infinite() {
        [1.0 / (yc * yc), 0.0]
    } else {
        let half = 0.5 / s;
        [half * half, ((yc * half).powi(2) - 1.0) / yc]
    }
}

fn residual(parameters: &mut Parameters<'_>) -> [f64; 5] {
    let key = "residual_strengths";
    let list = match parameters.get(key) {
        None => return [1.0; 5],
        Some(Param::List(list)) => <[f64; 5]>::try_from(list.as_slice()).ok(),
        Some(_) => None,
    };
    let list = list.filter(|list| list.iter().all(|share| (0.0..=1.0).contains(share)));
    if list.is_none() {
        let help = "give [tension a, compression a, tension b, compression b, shear]";
        parameters.wrong(key, "is no list of five fractions from 0 to 1", help);
    }
    list.unwrap_or([1.0; 5]).map(|share| share.max(LEAST_RESIDUAL))
}

impl Ply {
    fn stress<R: Real>(&self, points: Points<'_, R>) {
        let stride = 3 + self.history().len();
        let states = points.state.chunks_exact_mut(stride);
        for ((state, eps), eps_z) in states.zip(points.strain).zip(points.thickness_strain) {
            let (c, s) = (state[COSINE] + R::splat(1.0), state[SINE]);
            let strain = strain_along(*eps, c, s);
            let Orthotropic { caa, cab, cbb, g, .. } = self.stiffness;
            let constants = [caa, cab, cbb, g].map(R::splat);
            // The increment is turned, not the stress, which would gather round-off.
            match &self.failure {
                None => {
                    let more = stress_across(linear(strain, constants), c, s);
                    (0..3).for_each(|k| state[k] += more[k]);
                }
                Some(failure) => {
                    let before = stress_along([state[0], state[1], state[2]], c, s);
                    let after = self.limited(failure, before, strain, state);
                    let more: [R; 3] = std::array::from_fn(|k| after[k] - before[k]);
                    let more = stress_across(more, c, s);
                    let failed = state[FAILED].gt(R::splat(0.5));
                    for k in 0..3 {
                        state[k] = R::select(failed, R::zero(), state[k] + more[k]);
                    }
                }
            }
            *eps_z = R::zero();
        }
    }

    /// Returns the stress after a strain increment, both along the axes, and updates the strain and
    /// the modes that have failed.
    #[inline(always)]
    fn limited<R: Real>(
        &self,
        failure: &PlyFailure,
        before: [R; 3],
        strain: [R; 3],
        state: &mut [R],
    ) -> [R; 3] {
        let (zero, one, half) = (R::zero(), R::splat(1.0), R::splat(0.5));
        let has_failed = |state: &[R], mode: usize| state[MODES + mode].gt(half);
        let Orthotropic { caa, cab, cbb, g, .. } = self.stiffness;
        let more = linear(strain, [caa, cab, cbb, g].map(R::splat));
        let (mut a, mut b) = (before[0] + more[0], before[1] + more[1]);
        let mut ab = sheared(before[2], strain[2], g, failure.shear_nonlinearity);

        // Matrix: the square q and the linear term l of the criterion at this stress.
        let residual = |mode: usize, mask: R::Mask| {
            R::select(mask, R::splat(1.0 / failure.residual[mode]), one)
        };
        let matrix_failed = R::either(has_failed(state, 2), has_failed(state, 3));
        let is_tension = b.ge(zero);
        let of_side = |side: usize, mode: usize| {
            let scaled = b * residual(mode, has_failed(state, mode));
            let [square, plain] = failure.matrix[side].map(R::splat);
            (square * scaled * scaled, plain * scaled)
        };
        let ((q_t, l_t), (q_c, l_c)) = (of_side(0, 2), of_side(1, 3));
        let shear = R::splat(failure.shear) * residual(4, matrix_failed);
        let sheared_part = |ab: R, shear: R| {
            let [c, k] = failure.shear_energy.map(R::splat);
            let t = ab * shear;
            k * (c * ab).mul_add(ab, one) * (t * t)
        };
        let q = sheared_part(ab, shear) + R::select(is_tension, q_t, q_c);
        let l = R::select(is_tension, l_t, l_c);
        let beyond = (q + l).gt(one);
        // The factor f on the stress follows from f^2 q + f l = 1.
        let factor = R::splat(2.0) / (l + l.mul_add(l, R::splat(4.0) * q).sqrt());
        let factor = R::select(beyond, factor, one);
        let elastic = b;
        (b, ab) = (b * factor, ab * factor);
        a -= R::splat(cab / cbb) * (elastic - b);
        let mark = |state: &mut [R], mode: usize, mask: R::Mask| {
            let column = &mut state[MODES + mode];
            *column = R::select(mask, one, *column);
        };
        let crushes = R::both(beyond, b.lt(zero));
        mark(state, 2, R::both(beyond, is_tension));
        mark(state, 3, crushes);

        // Fibres.
        let crushed = has_failed(state, 3);
        let strength = |side: usize| {
            let [intact, reduced] = failure.fibre[side].map(|strength| R::splat(1.0 / strength));
            R::select(crushed, reduced, intact) * residual(side, has_failed(state, side))
        };
        let [tension, compression] = [strength(0), strength(1)];
        let is_tension = a.ge(zero);
        let along = a * R::select(is_tension, tension, compression);
        let weight = R::select(is_tension, R::splat(failure.shear_weight), zero);
        let q = along.mul_add(along, weight * sheared_part(ab, shear));
        let beyond = q.gt(one);
        let factor = R::select(beyond, one / q.sqrt(), one);
        let elastic = a;
        a = a * factor;
        b -= R::splat(cab / caa) * (elastic - a);
        ab = R::select(weight.gt(zero), ab * factor, ab);
        mark(state, 0, R::both(beyond, is_tension));
        mark(state, 1, R::both(beyond, a.lt(zero)));

        // Loss of all stress.
        for k in 0..3 {
            state[STRAIN + k] += strain[k];
        }
        let [e_a, e_b, e_ab] = [state[STRAIN], state[STRAIN + 1], state[STRAIN + 2]];
        let [tension, compression, across, shear, effective] = failure.strains.map(R::splat);
        let half_shear = half * e_ab;
        let square = e_a.mul_add(e_a + e_b, e_b.mul_add(e_b, half_shear * half_shear));
        let limits = [
            e_a.gt(tension),
            (zero - e_a).gt(compression),
            e_b.abs().gt(across),
            e_ab.abs().gt(shear),
            (R::splat(4.0 / 3.0) * square).gt(effective * effective),
        ];
        for limit in limits {
            mark(state, FAILED - MODES, limit);
        }
        if failure.at_strength {
            let reached = has_failed(state, 0);
            mark(state, FAILED - MODES, reached);
        }
        [a, b, ab]
    }
}

/// Returns the shear stress after the increment `more` of engineering shear, for
/// `g = t/G + alpha t^3`.
#[inline(always)]
fn sheared<R: Real>(stress: R, more: R, g: f64, alpha: f64) -> R {
    let mut after = R::splat(g).mul_add(more, stress);
    if alpha > 0.0 {
        let (soft, alpha) = (R::splat(1.0 / g), R::splat(alpha));
        let wanted = stress.mul_add(alpha.mul_add(stress * stress, soft), more);
        for _ in 0..SHEAR_ITERATIONS {
            let square = alpha * after * after;
            let slope = R::splat(3.0).mul_add(square, soft);
            after -= (after * (square + soft) - wanted) / slope;
        }
    }
    after
}

impl PlaneStress for Ply {
    fn history(&self) -> &[&'static str] {
        if self.failure.is_some() { &HISTORY } else { &HISTORY[..2] }
    }
    fn adds_stress(&self) -> bool {
        true
    }
    fn elastic(&self) -> Elastic {
        self.stiffness.bound(&self.transverse, self.density)
    }
    fn stabilising(&self) -> Elastic {
        let Orthotropic { ea, eb, .. } = self.stiffness;
        Elastic { youngs_modulus: (ea * eb).sqrt(), poisson: 0.0, density: self.density }
    }
    fn thins(&self) -> bool {
        false
    }
    fn orientation(&self, _point: usize) -> Option<Orientation> {
        Some(self.orientation)
    }
    fn transverse_shear(&self, _point: usize) -> Option<[f64; 2]> {
        Some(self.transverse)
    }
    fn update(&self, points: Points<'_, Lane>, _dt: f64) {
        self.stress(points);
    }
    fn update_short(&self, points: Points<'_, Lane32>, _dt: f64) {
        self.stress(points);
    }
    fn update_one(&self, points: Points<'_, f64>, _dt: f64) {
        self.stress(points);
    }
}

#[cfg(test)]
#[path = "orthotropic_tests.rs"]
mod tests;
