//! Crushable foam, as in `*MAT_CRUSHABLE_FOAM`: elastic, with a limit of each principal stress that
//! depends on the volume:
//! ```text
//! -curve(1 - V) <= sigma_i <= tension_cutoff
//! ```
//! V is the ratio of the volume to that at the start. Unloading is elastic, so that crushed foam
//! does not recover. Principal directions of the elastic trial are kept.
//!
//! Valid for foam with a Poisson's ratio near zero. Beyond its points the curve keeps its last
//! slope; no slope may exceed Young's modulus. Stress grows at most with
//! the elastic moduli, but where the volume grows it falls with the limit, whose bulk modulus is V
//! times the slope: the step follows where that exceeds the elastic one.

use super::parameters::Parameters;
use super::polyline::{Beyond, RampCurve};
use super::tensor::Principal;
use super::{
    DefaultValue, ELASTIC, Elastic, Form, Law, ParameterRow, Solid, SolidLawResult, SolidPoint,
};
use crumple_math::lanes::{Lane, Lane32, Real, dot};
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

const CURVE: &str = "compression";

/// The row of this law.
pub const LAW: Law = Law {
    name: "crushable_foam",
    meaning: "Foam that is crushed: principal stresses are limited by the change of volume.",
    constants: ELASTIC,
    parameters: &[
        ParameterRow {
            key: CURVE,
            form: Form::List("[[volume strain, stress], ...]"),
            otherwise: DefaultValue::Needed,
            range: None,
            meaning: "Limit of compressive stress over the relative decrease of volume, both \
                      positive, from a volume strain of 0 on [force/length^2].",
        },
        ParameterRow {
            key: "tension_cutoff",
            form: Form::Number,
            otherwise: DefaultValue::Number(0.0),
            range: None,
            meaning: "Limit of tensile stress [force/length^2].",
        },
    ],
    build: None,
    solid: Some(solid),
    cohesive: None,
};

struct CrushableFoam {
    elastic: Elastic,
    curve: RampCurve,
    cutoff: f64,
}

fn solid(material: &Material) -> SolidLawResult {
    Parameters::new(material).solid_law(read)
}

fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<CrushableFoam, Vec<Problem>> {
    let wanted = ("with stresses of 0 or above", |point: &[f64; 2]| point[1] >= 0.0);
    let points = parameters.curve(CURVE, "[[volume strain, stress], ...]", wanted);
    if points.is_none() {
        parameters.wrong(CURVE, "is missing", "give [[0, stress], [volume strain, stress], ...]");
    }
    let points = points.unwrap_or_default();
    if points.iter().any(|point| point[0] >= 1.0) {
        let help = "the volume strain is below 1, where no volume is left";
        parameters.wrong(CURVE, "has a volume strain of 1 or above", help);
    }
    let slope = |two: &[[f64; 2]]| (two[1][1] - two[0][1]) / (two[1][0] - two[0][0]);
    let steepest = points.windows(2).map(slope).fold(0.0, f64::max);
    if steepest > elastic.youngs_modulus {
        let help = format!("use a Young's modulus of at least its largest slope, {steepest}");
        parameters.wrong(CURVE, "is steeper than Young's modulus", help);
    }
    let cutoff = parameters.optional("tension_cutoff", "0 or above", |t| t >= 0.0);
    parameters.finish()?;
    let curve = RampCurve::new(&points, 1.0, Beyond::Straight);
    Ok(CrushableFoam { elastic, curve, cutoff: cutoff.unwrap_or(0.0) })
}

/// Columns: logarithm of the volume, and stiffening.
const VOLUME: usize = 6;
const STIFFENING: usize = 7;

impl CrushableFoam {
    #[inline(always)]
    fn solid<R: Real>(&self, point: SolidPoint<'_, R>, _dt: f64) -> R {
        let (state, eps) = (point.state, point.strain);
        let [lame, g] = [self.elastic.lame(), self.elastic.shear_modulus()].map(R::splat);
        let trace = eps[0] + eps[1] + eps[2];
        let pressure = lame * trace;
        let mut trial = [R::zero(); 6];
        for c in 0..3 {
            trial[c] = (g + g).mul_add(eps[c], state[c] + pressure);
            trial[3 + c] = g.mul_add(eps[3 + c], state[3 + c]);
        }
        state[VOLUME] += trace;
        let (zero, one) = (R::zero(), R::splat(1.0));
        let volume = state[VOLUME].exp();
        let crushed = Real::max(one - volume, zero);
        let [limit, slope] = self.curve.at(crushed);
        let least = -Real::max(limit, zero);
        let over = volume * slope * R::splat(1.0 / self.elastic.bulk_modulus()) - one;
        state[STIFFENING] = R::select(crushed.gt(zero), Real::max(over, zero), zero);
        let most = R::splat(self.cutoff);
        let principal = Principal::new(&trial);
        let limited = principal.values.map(|value| Real::max(Real::min(value, most), least));
        let mut beyond = zero.gt(zero);
        for (value, limited) in principal.values.into_iter().zip(limited) {
            beyond = R::either(beyond, (value - limited).abs().gt(zero));
        }
        let inside = principal.compose(limited);
        for c in 0..6 {
            state[c] = R::select(beyond, inside[c], trial[c]);
        }
        let norm = |values: [R; 3]| dot(values, values).sqrt();
        let size = Real::max(norm(principal.values), R::splat(R::SMALLEST));
        R::select(beyond, norm(limited) / size, one)
    }
}

impl Solid for CrushableFoam {
    fn history(&self) -> &'static [&'static str] {
        &["volume strain", "stiffening"]
    }
    fn elastic(&self) -> Elastic {
        self.elastic
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
mod tests {
    use crate::elements::testing::Noise;
    use crate::materials::testing::{Cube, material, problems, table};
    use crumple_proto::partition::Material;

    const E: f64 = 2.0;
    const CURVE: [[f64; 2]; 3] = [[0.0, 0.02], [0.5, 0.03], [0.8, 0.2]];

    fn foam(poisson: f64) -> Material {
        let numbers = [("youngs_modulus", E), ("poisson", poisson), ("tension_cutoff", 0.01)];
        material("crushable_foam", &numbers, &[("compression", table(&CURVE))])
    }

    fn curve(strain: f64) -> f64 {
        if strain < 0.5 { 0.02 + 0.02 * strain } else { 0.03 + 0.17 / 0.3 * (strain - 0.5) }
    }

    /// Uniaxial compression follows the curve, unloading has Young's modulus, tension is cut off,
    /// and crushing goes on where the unloading line meets the curve again.
    #[test]
    fn crushing_follows_the_curve_and_does_not_recover() {
        let mut cube = Cube::new(&foam(0.0));
        for percent in 2..70 {
            let strain = 0.01 * f64::from(percent);
            cube.stretch(1.0 - strain, 10, 1.0);
            let (got, exact) = (-cube.state[0], curve(strain));
            // The volume is the exponential of the strain increments: third order in the step.
            assert!((got - exact).abs() < 1e-7, "{strain}: {got} {exact}");
        }
        let (before, strain) = (cube.state[0], cube.strain[0]);
        cube.pull([0.01, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 1.0);
        assert!((cube.state[0] - before - E * 0.01).abs() < 1e-12, "Young's modulus");
        (0..20).for_each(|_| cube.pull([0.01, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 1.0));
        assert!((cube.state[0] - 0.01).abs() < 1e-12, "cut off: {}", cube.state[0]);
        let lost = cube.strain[0] - strain;
        (0..40).for_each(|_| cube.pull([-0.01, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 1.0));
        let exact = curve(1.0 - cube.strain[0].exp());
        assert!((-cube.state[0] - exact).abs() < 1e-6, "{} {exact}", cube.state[0]);
        assert!(lost > 0.1 && exact > 0.05, "it was unloaded far, and crushed more");
    }

    /// Pressure on all sides is limited by the same curve over the volume.
    #[test]
    fn pressure_follows_the_curve_of_the_volume() {
        let mut cube = Cube::new(&foam(0.2));
        (0..300).for_each(|_| _ = cube.step([-1e-3, -1e-3, -1e-3, 0.0, 0.0, 0.0], 1.0));
        let exact = curve(1.0 - (-0.9f64).exp());
        for c in 0..3 {
            assert!((-cube.state[c] / exact - 1.0).abs() < 1e-6, "{} {exact}", cube.state[c]);
        }
    }

    /// Closed random paths never give energy.
    #[test]
    fn closed_paths_cost_work() {
        for (seed, nu) in (0..20).flat_map(|seed| [(seed, 0.0), (seed, 0.3)]) {
            let mut cube = Cube::new(&foam(nu));
            let mut noise = Noise(seed);
            let path: Vec<[f64; 6]> =
                (0..3).map(|_| std::array::from_fn(|_| 1e-3 * noise.next())).collect();
            for sign in [1.0, -1.0] {
                for e in &path {
                    (0..50).for_each(|_| _ = cube.step(e.map(|e| sign * e), 1.0));
                }
            }
            let s = &cube.state;
            let square: f64 = s[..3].iter().map(|x| x * x).sum::<f64>()
                + 2.0 * s[3..6].iter().map(|x| x * x).sum::<f64>();
            let sum = s[0] + s[1] + s[2];
            let stored = ((1.0 + nu) * square - nu * sum * sum) / (2.0 * E);
            assert!(cube.work > stored - 1e-6, "{seed} {nu}: {} {stored}", cube.work);
        }
    }

    /// Crushed foam has no more hourglass stress than limited stress; the step follows the curve
    /// where all sides are at the limit, by the bulk modulus V times its slope.
    #[test]
    fn crushing_lowers_what_is_left_and_shortens_the_step() {
        let law = [("compression", table(&[[0.0, 0.02], [0.5, 0.03], [0.9, 0.8]]))];
        let law = material("crushable_foam", &[("youngs_modulus", E), ("poisson", 0.0)], &law);
        let mut cube = Cube::new(&law);
        assert_eq!(cube.step([-1e-3, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0), 1.0, "elastic");
        (0..50).for_each(|_| _ = cube.step([-0.01, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0));
        let trial = cube.state[0] - E * 0.01;
        let left = cube.step([-0.01, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
        assert!((left - cube.state[0] / trial).abs() < 1e-12 && left < 0.8, "{left}");
        (0..100).for_each(|_| _ = cube.step([-1e-3, -1e-3, -1e-3, 0.0, 0.0, 0.0], 1.0));
        let bulk = cube.at("volume strain").exp() * (0.8 - 0.03) / 0.4;
        let over = bulk / (E / 3.0) - 1.0;
        assert!((cube.at("stiffening") - over).abs() < 1e-9 && over > 0.2, "{over}");
    }

    #[test]
    fn a_curve_steeper_than_the_modulus_is_refused() {
        let steep = [("compression", table(&[[0.0, 0.0], [0.1, 1.0]]))];
        let text = problems(&material(
            "crushable_foam",
            &[("youngs_modulus", E), ("poisson", 0.0)],
            &steep,
        ));
        assert!(text.contains("at least its largest slope, 10"), "{text}");
        let whole = [("compression", table(&[[0.0, 0.1], [1.0, 0.2]]))];
        let numbers = [("youngs_modulus", E), ("poisson", 0.0)];
        let text = problems(&material("crushable_foam", &numbers, &whole));
        assert!(text.contains("volume strain of 1 or above"), "{text}");
    }
}
