//! Rubber and foam by the curve of a uniaxial test (Kolling, Du Bois & Benson 2007, A tabulated
//! formulation of hyperelasticity with rate effects and damage, Comput. Mech. 40), as in
//! `*MAT_SIMPLIFIED_RUBBER/FOAM`. With the stretches lambda_i, `l_i = lambda_i J^(-1/3)`:
//! ```text
//! rubber:  J sigma_i = f(l_i) - (f(l_1) + f(l_2) + f(l_3))/3 + K (J - 1)
//! foam:    J sigma_i = f(lambda_i) - f(J^-beta),   beta = nu/(1 - 2 nu)
//! f(lambda) = sum_k g(lambda^((-p)^k)),   g(lambda) = lambda P(lambda - 1)
//! ```
//! P is the nominal stress over the nominal strain, and p is 1/2 in rubber and nu in foam. In
//! uniaxial stress the lateral stretch is `lambda^-p`, in rubber with a large K. Two terms of f
//! then differ by g, so that the test gives P. Both stresses are derivatives of an energy.
//!
//! Between its points, and beyond them, g is linear over `q = lambda^2 - 1/lambda`: each piece is
//! the curve of a neo-Hookean rubber plus a constant. Straight lines of P would let f fall in
//! strong compression, where its terms nearly cancel. The sum has eight terms; the others are
//! those of a straight curve on either side of zero, which they approach.
//!
//! f must grow with lambda: otherwise a rubber under equal stress along two axes is not stable. A
//! curve that does not do so is refused.
//!
//! Curves by the strain rate are in [`by_rate`](super::by_rate).
//!
//! Left out: unloading with loss of energy without rates, relaxation.

use super::by_rate::{RateRubber, RateSteps};
use super::test_curve::TestCurve;
use super::{Rubber, StrainEnergy, elastic_of_shear};
use crate::materials::parameters::Parameters;
use crate::materials::tensor::{Principal, Symmetric, volume_change};
use crate::materials::{DefaultValue, Elastic, Form, Law, ParameterRow, SolidLawResult};
use crumple_math::lanes::Real;
use crumple_proto::partition::Material;

const CURVE: &str = "curve";
const BY_RATE: &str = "curve_by_rate";
const NOMINAL: &str = "nominal_rate";
const AVERAGING: &str = "rate_averaging_time";
const BULK: &str = "bulk_modulus";
const POISSON: &str = "poisson";

/// The row of this law.
pub const LAW: Law = Law {
    name: "tabulated_rubber",
    meaning: "Rubber, or with `poisson` foam, by the curve of a uniaxial test, or by curves at \
              several strain rates.",
    constants: &[],
    parameters: PARAMETERS,
    build: None,
    solid: Some(solid),
    cohesive: None,
};

const PARAMETERS: &[ParameterRow] = &[
    ParameterRow {
        key: CURVE,
        form: Form::List("[[strain, stress], ...]"),
        otherwise: DefaultValue::Depends("needed without `curve_by_rate`"),
        range: None,
        meaning: "Nominal stress over nominal strain of uniaxial stress, negative in compression, \
                  with the point [0, 0] [force/length^2].",
    },
    ParameterRow {
        key: BY_RATE,
        form: Form::List("[[rate, strain, stress], ...]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Curves as in `curve`, one for each strain rate [1/time], in ascending order, \
                  none below that of a smaller rate; linear between rates, constant beyond them \
                  [force/length^2].",
    },
    ParameterRow {
        key: NOMINAL,
        form: Form::Flag,
        otherwise: DefaultValue::Flag(false),
        range: None,
        meaning: "The rates of `curve_by_rate` are those of the nominal strain; else of its \
                  logarithm.",
    },
    ParameterRow {
        key: AVERAGING,
        form: Form::Number,
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Time over which the strain rate is a running mean [time]; without it, or if it \
                  is shorter, 12 steps.",
    },
    ParameterRow {
        key: BULK,
        form: Form::Number,
        otherwise: DefaultValue::Depends("needed without `poisson`"),
        range: None,
        meaning: "Bulk modulus of a rubber [force/length^2].",
    },
    ParameterRow {
        key: POISSON,
        form: Form::Number,
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Poisson's ratio of a foam, from 0 and below 0.5: the lateral stretch in uniaxial \
                  stress is the stretch to the power of minus this ratio.",
    },
];

/// Pressure of the law.
pub(super) enum Volume {
    /// K [force/length^2].
    Rubber(f64),
    /// beta.
    Foam(f64),
}

pub(super) struct TabulatedRubber {
    elastic: Elastic,
    test: TestCurve,
    pub(super) volume: Volume,
    /// p.
    power: f64,
}

fn solid(material: &Material) -> SolidLawResult {
    let mut parameters = Parameters::new(material);
    let density = parameters.density();
    let tests = tests(&mut parameters);
    let bulk = parameters.optional(BULK, "above 0", |k| k > 0.0);
    let poisson =
        parameters.optional(POISSON, "from 0 and below 0.5", |nu| (0.0..0.5).contains(&nu));
    let nominal = parameters.flag(NOMINAL);
    let averaging = parameters.optional(AVERAGING, "above 0", |time| time > 0.0);
    let given = [BULK, POISSON].map(|key| parameters.given(key));
    if given == [false; 2] {
        parameters.wrong(BULK, "is missing", "give it for a rubber, or poisson for a foam");
    } else if given == [true; 2] {
        parameters.wrong(BULK, "is given together with poisson", "give one of them");
    }
    for key in [NOMINAL, AVERAGING] {
        if parameters.given(key) && !parameters.given(BY_RATE) {
            parameters.wrong(key, "is given without curve_by_rate", "remove it");
        }
    }
    let (Some((key, tests)), true) = (tests, bulk.is_some() != poisson.is_some()) else {
        // Something of it is missing or wrong: the problems are recorded.
        parameters.finish()?;
        return Err(Vec::new());
    };
    let power = poisson.unwrap_or(0.5);
    let curves: Vec<(f64, TestCurve)> =
        tests.iter().map(|(rate, points)| (*rate, TestCurve::new(points, power))).collect();
    check(&mut parameters, key, &curves);
    let shear = |(_, curve): &(f64, TestCurve)| 0.5 * curve.stiffness();
    // The step follows the stiffer curves of larger rates.
    let (lowest, stiffest) = (shear(&curves[0]), curves.iter().map(shear).fold(0.0, f64::max));
    if bulk.is_some_and(|k| 3.0 * k < 2.0 * stiffest) {
        let what = format!("is below 2/3 of the shear modulus {stiffest} of the curve");
        parameters.wrong(BULK, what, "that of rubber is 100 times as large and more");
    }
    let (nu, volume) = match (bulk, poisson) {
        (Some(k), _) => ((3.0 * k - 2.0 * lowest) / (6.0 * k + 2.0 * lowest), Volume::Rubber(k)),
        (None, nu) => {
            let nu = nu.unwrap_or_default();
            (nu, Volume::Foam(nu / (1.0 - 2.0 * nu)))
        }
    };
    parameters.finish()?;
    let elastic = elastic_of_shear(lowest, nu, density);
    let rubber = TabulatedRubber { elastic, test: curves[0].1.clone(), volume, power };
    if curves.len() == 1 {
        return Ok(Box::new(Rubber(rubber)));
    }
    let steps = RateSteps::new(&curves, nominal, averaging.unwrap_or(0.0));
    Ok(Box::new(RateRubber { rubber, steps }))
}

/// Checks that f of each curve grows with the stretch, and that no curve is below that of a smaller
/// rate.
fn check(parameters: &mut Parameters<'_>, key: &str, curves: &[(f64, TestCurve)]) {
    for (rate, curve) in curves {
        if let Some(strain) = curve.falls() {
            let of_rate =
                if key == BY_RATE { format!("at the rate {rate} ") } else { String::new() };
            let what = format!(
                "{of_rate}bends too much near the strain {strain:.3}: equal stress along two axes \
                 would not be stable"
            );
            let help =
                "give more points on a smooth curve, in compression too, where the slope grows";
            parameters.wrong(key, what, help);
        }
    }
    for two in curves.windows(2) {
        if let Some(stretch) = two[1].1.falls_below(&two[0].1) {
            let what = format!(
                "has a curve of the rate {} that lies below that of the rate before it at the \
                 strain {:.3}",
                two[1].0,
                stretch - 1.0
            );
            let help = "a faster test must not have a smaller stress: the overstress would give \
                        energy; curves go on beyond their ends to those of the others";
            parameters.wrong(key, what, help);
        }
    }
}

/// Rate of a test [1/time], and its points of nominal strain and stress [-, force/length^2].
type RatedTest = (f64, Vec<[f64; 2]>);

/// Returns the key of the curves, and the points of each with its rate; `None` if they are missing
/// or wrong.
fn tests(parameters: &mut Parameters<'_>) -> Option<(&'static str, Vec<RatedTest>)> {
    let curve = parameters.rows::<2>(CURVE, "[strain, stress]");
    let by_rate = parameters.rows::<3>(BY_RATE, "[rate, strain, stress]");
    let (key, rows) = match (curve, by_rate) {
        (Some(rows), None) => (CURVE, rows.iter().map(|row| [0.0, row[0], row[1]]).collect()),
        (None, Some(rows)) => (BY_RATE, rows),
        (Some(_), Some(_)) => {
            parameters.wrong(BY_RATE, "is given together with curve", "give one of them");
            return None;
        }
        (None, None) => {
            let help = "give [[strain, stress], ...], or curve_by_rate";
            parameters.wrong(CURVE, "is missing", help);
            return None;
        }
    };
    if rows.is_empty() {
        return None;
    }
    let curves: Vec<RatedTest> = rows
        .chunk_by(|a, b| a[0] == b[0])
        .map(|rows| (rows[0][0], rows.iter().map(|row| [row[1], row[2]]).collect()))
        .collect();
    if curves.windows(2).any(|two| two[0].0 >= two[1].0) || curves[0].0 < 0.0 {
        let help = "give the rows of each rate together, and increasing rates from 0 on";
        parameters.wrong(key, "has rates in the wrong order", help);
        return None;
    }
    if !curves.iter().all(|(_, points)| is_test(points)) {
        let help = "give increasing strains above -1 with the point [0, 0], and stresses with the \
                    sign of the strain";
        parameters.wrong(key, "is not such a curve", help);
        return None;
    }
    Some((key, curves))
}

/// Returns true for points of a test: ascending, through zero, with the sign of the strain.
fn is_test(points: &[[f64; 2]]) -> bool {
    let ascends = points.windows(2).all(|two| two[0][0] < two[1][0]) && points[0][0] > -1.0;
    let fits = |point: &[f64; 2]| *point == [0.0, 0.0] || point[0] * point[1] > 0.0;
    points.len() > 1 && ascends && points.iter().all(fits) && points.contains(&[0.0, 0.0])
}

impl TabulatedRubber {
    /// Returns p, the exponent of the lateral stretch in uniaxial stress.
    pub(super) fn power(&self) -> f64 {
        self.power
    }

    /// Returns principal directions, J, the strains of the arguments of f along the directions, and
    /// that of the argument of the volume in foam.
    #[inline(always)]
    pub(super) fn arguments<R: Real>(&self, b: &Symmetric<R>) -> (Principal<R>, R, [R; 3], R) {
        let one = R::splat(1.0);
        let third = one + volume_change(b);
        let changed = (third - one).abs().gt(R::zero());
        let principal = Principal::new(b);
        let (squares, by_volume) = match self.volume {
            Volume::Rubber(_) => {
                let scale = third.powf_where(-1.0 / 3.0, changed);
                let rest = scale - one;
                (principal.values.map(|value| scale.mul_add(value, rest)), R::zero())
            }
            Volume::Foam(beta) => (principal.values, third.powf_where(-0.5 * beta, changed) - one),
        };
        let strains = squares.map(|square| square / ((one + square).sqrt() + one));
        (principal, third.sqrt(), strains, by_volume)
    }
}

impl StrainEnergy for TabulatedRubber {
    fn elastic(&self) -> Elastic {
        self.elastic
    }

    #[inline(always)]
    fn stress<R: Real>(&self, b: &Symmetric<R>) -> Symmetric<R> {
        let (principal, volume, strains, by_volume) = self.arguments(b);
        let sums = strains.map(|strain| self.test.sum(strain)[0]);
        let forces: [R; 3] = match self.volume {
            Volume::Rubber(bulk) => {
                let change = volume_change(b) / (volume + R::splat(1.0));
                std::array::from_fn(|i| {
                    let apart = (sums[i] - sums[(i + 1) % 3]) + (sums[i] - sums[(i + 2) % 3]);
                    R::splat(1.0 / 3.0).mul_add(apart, R::splat(bulk) * change)
                })
            }
            Volume::Foam(_) => {
                let all = self.test.sum(by_volume)[0];
                sums.map(|sum| sum - all)
            }
        };
        principal.compose(forces.map(|force| force / volume))
    }

    /// With `D = diag(f'(l_i))` the matrix of a rubber is that of `ogden`; that of a foam is D and
    /// `beta f'(J^-beta)` in all entries.
    #[inline(always)]
    fn moduli<R: Real>(&self, b: &Symmetric<R>) -> [R; 2] {
        let (_, volume, strains, by_volume) = self.arguments(b);
        let [x, y, z] = strains.map(|strain| self.test.sum(strain)[1]);
        let shear = Real::max(Real::max(x, y), z) / volume;
        match self.volume {
            Volume::Rubber(bulk) => [shear, R::splat(1.0 / 3.0).neg_mul_add(shear, R::splat(bulk))],
            Volume::Foam(beta) => [shear, R::splat(beta) * self.test.sum(by_volume)[1] / volume],
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::materials::testing::{Cube, material, problems, table};
    use crumple_proto::partition::Material;

    /// A test of a soft rubber in MPa, stiffer in compression and at large strain.
    fn test(strain: f64) -> f64 {
        let l = 1.0 + strain;
        0.5 * (l - l.powi(-2)) + 0.02 * (l.powi(3) - l.powf(-3.0))
    }

    /// Points from a strain of -0.6 to 2.
    fn points() -> Vec<[f64; 2]> {
        (-6..=20).map(|k| 0.1 * f64::from(k)).map(|strain| [strain, test(strain)]).collect()
    }

    fn rubber(points: &[[f64; 2]]) -> Material {
        material("tabulated_rubber", &[("bulk_modulus", 1e5)], &[("curve", table(points))])
    }

    fn foam(nu: f64) -> Material {
        material("tabulated_rubber", &[("poisson", nu)], &[("curve", table(&points()))])
    }

    /// A uniaxial test gives the curve at its points, and between them a piece of a neo-Hookean
    /// curve; the lateral stretch is that of the law. The tolerance is the rest of the sum; in
    /// rubber also the stress over K, 3e-5.
    #[test]
    fn a_uniaxial_test_gives_the_curve() {
        let points = points();
        let q = |strain: f64| (1.0 + strain).powi(2) - 1.0 / (1.0 + strain);
        for (law, power) in [(rubber(&points), 0.5), (foam(0.3), 0.3), (foam(0.0), 0.0)] {
            for two in points.windows(2).filter(|two| two.iter().all(|point| point[0] != 0.0)) {
                for share in [0.0, 0.4] {
                    let strain = two[0][0] + share * (two[1][0] - two[0][0]);
                    let [first, last] = [two[0], two[1]].map(|[e, p]| (1.0 + e) * p);
                    let part = (q(strain) - q(two[0][0])) / (q(two[1][0]) - q(two[0][0]));
                    let stress = (first + part * (last - first)) / (1.0 + strain);
                    let mut cube = Cube::new(&law);
                    cube.stretch(1.0 + strain, 4, 1.0);
                    let area = (cube.strain[1] + cube.strain[2]).exp();
                    let got = cube.state[0] * area;
                    assert!((got / stress - 1.0).abs() < 1e-4, "{power} {strain}: {got} {stress}");
                    let lateral = cube.strain[1] + power * (1.0 + strain).ln();
                    assert!(lateral.abs() < 1e-4, "{power} {strain}: {lateral}");
                }
            }
        }
    }

    /// Three points of a neo-Hookean rubber give its stress on other paths, and beyond the points
    /// too: `f = G lambda^2` plus a constant. The tolerance is the rest of the sum and the stress
    /// over K.
    #[test]
    fn the_curve_of_a_neo_hookean_rubber_gives_this_rubber() {
        let g = 0.8;
        let stress = |e: f64| g * (1.0 + e - (1.0 + e).powi(-2));
        let law = rubber(&[-0.5, 0.0, 1.5].map(|e| [e, stress(e)]));
        for l in [0.3, 0.45, 0.8, 1.3, 2.4, 3.5_f64] {
            let each = 2.0 * (0.5 * l.ln() / 20.0).tanh();
            let mut cubes = [(); 2].map(|_| Cube::new(&law));
            for _ in 0..20 {
                cubes[0].pull([each, 0.0, 0.0, 0.0, 0.0, 0.0], &[2], 1.0);
                cubes[1].pull([-0.5 * each, -0.5 * each, 0.0, 0.0, 0.0, 0.0], &[2], 1.0);
            }
            let two = (-cubes[1].strain[0]).exp();
            let held = g * (l * l - l.powi(-2));
            let equal = g * (two.powi(-2) - two.powi(4));
            for (cube, exact) in cubes.iter().zip([held, equal]) {
                let off = cube.state[0] / exact - 1.0;
                assert!(off.abs() < 2e-4, "{l}: {off} of {exact}");
            }
        }
    }

    /// Each wrong parameter has an error that names it.
    #[test]
    fn wrong_curves_are_refused() {
        let of = |numbers: &[(&str, f64)], points: &[[f64; 2]]| {
            problems(&material("tabulated_rubber", numbers, &[("curve", table(points))]))
        };
        let k = ("bulk_modulus", 100.0);
        let line = [[-0.5, -1.0], [0.0, 0.0], [0.5, 0.8]];
        let bent = [[-0.5, -0.1], [0.0, 0.0], [0.5, 0.8]];
        for (text, words) in [
            (of(&[], &line), "poisson for a foam"),
            (of(&[k, ("poisson", 0.3)], &line), "together with poisson"),
            (of(&[("poisson", 0.5)], &line), "below 0.5"),
            (of(&[k], &line[..1]), "not such a curve"),
            (of(&[k], &[[-0.5, -1.0], [0.5, 0.8]]), "the point [0, 0]"),
            (of(&[k], &[[0.0, 0.0], [0.5, -0.8]]), "sign of the strain"),
            (of(&[k], &[[-1.0, -1.0], [0.0, 0.0]]), "above -1"),
            (of(&[k], &bent), "bends too much near the strain"),
            (of(&[("bulk_modulus", 0.1)], &points()), "2/3 of the shear modulus"),
            (problems(&material("tabulated_rubber", &[k], &[])), "curve is missing"),
        ] {
            assert!(text.contains(words), "{words}: {text}");
        }
    }
}
