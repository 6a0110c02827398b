//! Foam of low density whose principal directions do not influence each other, as in
//! `*MAT_LOW_DENSITY_FOAM` (Chang, Schulte & Hill 1994), and with curves by strain rate as in
//! `*MAT_FU_CHANG_FOAM`:
//! ```text
//! P_i = E (lambda_i - 1), at most `tension_cutoff`,   lambda_i > 1
//! P_i = -curve(1 - lambda_i, rate),                   lambda_i <= 1
//! sigma_i = (1 - d) P_i lambda_i / J
//! d = (1 - hysteresis) (1 - (W/W_max)^shape)
//! ```
//! P is the nominal stress in the principal directions of the left Cauchy-Green tensor B, whose
//! stretches are lambda. W is the energy of the curve of the lowest rate, W_max its largest value
//! so far. Poisson's ratio is zero.
//!
//! Each principal direction has its rate: the nominal compressive one, as a running mean, and zero
//! while the direction lengthens. So decompression follows the curve of the lowest rate, and no
//! closed path gives energy. The mean is over 12 steps or more: the stress by the rate rises at
//! most with the modulus E of the step, as in a Maxwell element. The history has the rates as a
//! tensor with the principal directions of B.
//!
//! `b = B - 1` is in the history, as in rubbers. Beyond its points a curve keeps its last slope.
//!
//! The step follows a bound of the modulus in the present state, for loading and unloading:
//! ```text
//! max_i lambda_i^2 ((1 - d) dP_i/dlambda_i + [E with rates])/J + c sum_i (lambda_i P_i)^2/J
//! c = (1 - hysteresis) shape (W/W_max)^shape/W
//! ```

use super::parameters::Parameters;
use super::polyline::{Beyond, CurveFamily};
use super::tensor::{Principal, stretch};
use super::{
    DefaultValue, Elastic, Form, Law, ParameterRow, STRETCH_COLUMN, Solid, SolidLawResult,
    SolidPoint, YOUNGS_MODULUS,
};
use crumple_math::lanes::{Lane, Lane32, Real, dot};
use crumple_proto::partition::Material;

const CURVE: &str = "compression";
const BY_RATE: &str = "compression_by_rate";

/// Smallest number of steps of the running mean of a rate.
const STEPS_OF_MEAN: f64 = 12.0;

/// Names of the columns after stress, without and with rates.
const HISTORY: [&[&str]; 2] = [
    &[
        STRETCH_COLUMN,
        "B-1 yy",
        "B-1 zz",
        "B-1 xy",
        "B-1 yz",
        "B-1 zx",
        "largest energy",
        "stiffening",
    ],
    &[
        STRETCH_COLUMN,
        "B-1 yy",
        "B-1 zz",
        "B-1 xy",
        "B-1 yz",
        "B-1 zx",
        "rate xx",
        "rate yy",
        "rate zz",
        "rate xy",
        "rate yz",
        "rate zx",
        "largest energy",
        "stiffening",
    ],
];
/// Columns with those of stress; without rates the last two stand in place of the rates.
const STRETCH: usize = 6;
const RATE: usize = 12;

/// The row of this law.
pub const LAW: Law = Law {
    name: "low_density_foam",
    meaning: "Foam of low density with a curve of compression, by strain rate if wanted; \
              `youngs_modulus` is that of tension.",
    constants: &[YOUNGS_MODULUS],
    parameters: PARAMETERS,
    build: None,
    solid: Some(solid),
    cohesive: None,
};

const PARAMETERS: &[ParameterRow] = &[
    ParameterRow {
        key: CURVE,
        form: Form::List("[[strain, stress], ...]"),
        otherwise: DefaultValue::Depends("needed without `compression_by_rate`"),
        range: None,
        meaning: "Nominal stress over nominal strain in compression, both positive, from [0, 0] on \
                  [force/length^2].",
    },
    ParameterRow {
        key: BY_RATE,
        form: Form::List("[[rate, strain, stress], ...]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Curves as in `compression`, one for each nominal strain rate [1/time], in \
                  ascending order, none below that of a smaller rate; linear between rates, \
                  constant beyond them [force/length^2].",
    },
    ParameterRow {
        key: "tension_cutoff",
        form: Form::Number,
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Largest nominal stress in tension [force/length^2].",
    },
    ParameterRow {
        key: "hysteresis",
        form: Form::Number,
        otherwise: DefaultValue::Number(1.0),
        range: None,
        meaning: "Fraction of the stress that is left late in unloading, from 0 to 1; 1 for none \
                  lost.",
    },
    ParameterRow {
        key: "shape",
        form: Form::Number,
        otherwise: DefaultValue::Depends("1; it has an effect with `hysteresis` below 1"),
        range: None,
        meaning: "Exponent of unloading: large values lower the stress early.",
    },
];

struct LowDensityFoam {
    /// E of the stable step: the larger of tension and the start of the curves.
    elastic: Elastic,
    tension: f64,
    cutoff: f64,
    compression: CurveFamily,
    has_rates: bool,
    hysteresis: f64,
    shape: f64,
}

fn solid(material: &Material) -> SolidLawResult {
    let mut parameters = Parameters::new(material);
    let density = parameters.density();
    let tension = parameters.required("youngs_modulus", "above 0", |e| e > 0.0);
    let rows = compression(&mut parameters);
    let cutoff = parameters.optional("tension_cutoff", "above 0", |t| t > 0.0);
    let hysteresis = parameters.optional("hysteresis", "from 0 to 1", |h| (0.0..=1.0).contains(&h));
    let shape = parameters.optional("shape", "above 0", |s| s > 0.0);
    parameters.finish()?;
    let first = |rows: &[[f64; 3]]| rows[1][2] / rows[1][1];
    let steepest = rows.chunk_by(|a, b| a[0] == b[0]).map(first).fold(tension, f64::max);
    Ok(Box::new(LowDensityFoam {
        elastic: Elastic { youngs_modulus: steepest, poisson: 0.0, density },
        tension,
        cutoff: cutoff.unwrap_or(f64::INFINITY),
        has_rates: rows[0][0] != rows[rows.len() - 1][0],
        compression: CurveFamily::new(&rows, 1.0, Beyond::Straight),
        hysteresis: hysteresis.unwrap_or(1.0),
        shape: shape.unwrap_or(1.0),
    }))
}

/// Returns the rows [rate, strain, stress] of the curves.
fn compression(parameters: &mut Parameters<'_>) -> Vec<[f64; 3]> {
    let curve = parameters.rows::<2>(CURVE, "[strain, stress]");
    let by_rate = parameters.rows::<3>(BY_RATE, "[rate, strain, stress]");
    let (key, rows) = match (curve, by_rate) {
        (Some(rows), None) => (CURVE, rows.iter().map(|row| [0.0, row[0], row[1]]).collect()),
        (None, Some(rows)) => (BY_RATE, rows),
        (Some(_), Some(_)) => {
            parameters.wrong(BY_RATE, "is given together with compression", "give one of them");
            return Vec::new();
        }
        (None, None) => {
            let help = "give [[0, 0], [strain, stress], ...], or compression_by_rate";
            parameters.wrong(CURVE, "is missing", help);
            return Vec::new();
        }
    };
    let curves: Vec<&[[f64; 3]]> = rows.chunk_by(|a, b| a[0] == b[0]).collect();
    let ascends = |curve: &&[[f64; 3]]| {
        curve.len() > 1
            && curve[0][1..] == [0.0, 0.0]
            && curve[1][2] > 0.0
            && curve.windows(2).all(|two| two[0][1] < two[1][1] && two[0][2] <= two[1][2])
    };
    if !(rows.is_empty()
        || curves.iter().all(ascends)
            && rows[0][0] >= 0.0
            && curves.windows(2).all(|two| two[0][0][0] < two[1][0][0]))
    {
        let help = "give strains that increase and stresses that do not decrease, both from 0 on, \
                    and increasing rates from 0 on";
        parameters.wrong(key, "has rows in the wrong order", help);
        return rows;
    }
    if rows.iter().any(|row| row[1] >= 1.0) {
        let help = "nominal strain in compression is below 1, where no length is left";
        parameters.wrong(key, "has a strain of 1 or above", help);
        return rows;
    }
    let family = CurveFamily::new(&rows, 1.0, Beyond::Straight);
    if let Some([rate, strain]) = family.crossing(1.0) {
        let what = format!(
            "has a curve of the rate {rate} that lies below that of the rate before it at the \
             strain {strain}"
        );
        let help = "a faster compression must not have a smaller stress: closed paths would give \
                    energy; curves keep their last slope up to a strain of 1";
        parameters.wrong(key, what, help);
    }
    rows
}

/// Stress of a principal direction.
struct Nominal<R> {
    /// Nominal stress and its slope over the stretch [force/length^2].
    stress: R,
    slope: R,
    /// Energy of the lowest rate per volume [force/length^2].
    energy: R,
}

impl LowDensityFoam {
    /// Returns the stress at a nominal strain and a compressive rate.
    #[inline(always)]
    fn nominal<R: Real>(&self, strain: R, rate: R) -> Nominal<R> {
        let zero = R::zero();
        let [e, cutoff] = [self.tension, self.cutoff.min(f64::from(f32::MAX))].map(R::splat);
        let pulled = Real::max(strain, zero);
        let pressed = Real::max(-strain, zero);
        let [pressure, slope, _] = self.compression.at(rate, pressed);
        let elastic = e * pulled;
        let beyond = Real::max(pulled - cutoff / e, zero);
        let is_pulled = strain.gt(zero);
        let half = R::splat(0.5);
        let energy = half.mul_add(elastic * pulled, -(half * e * beyond * beyond));
        Nominal {
            stress: R::select(is_pulled, Real::min(elastic, cutoff), -pressure),
            slope: R::select(is_pulled, R::select(elastic.lt(cutoff), e, zero), slope),
            energy: energy + self.compression.lowest().area(pressed),
        }
    }

    /// Returns the running mean of the compressive rate after a step in which a principal
    /// direction is shortened by `shortening` to a nominal strain.
    #[inline(always)]
    fn mean_rate<R: Real>(&self, old: R, strain: R, shortening: R, dt: f64) -> R {
        let (zero, tiny) = (R::zero(), R::splat(R::SMALLEST));
        let old = Real::max(old, zero);
        let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let change = R::splat(per_dt) * shortening - old;
        let share = R::splat(1.0 / STEPS_OF_MEAN);
        let pressed = Real::max(-strain, zero);
        let at = |rate: R| self.compression.at(rate, pressed)[2];
        let viscosity = Real::max(at(old), at(share.mul_add(change, old)));
        let most = R::splat(self.elastic.youngs_modulus * dt) / Real::max(viscosity, tiny);
        let rate = Real::min(share, most).mul_add(change, old);
        R::select(shortening.gt(zero), rate, zero)
    }

    #[inline(always)]
    fn solid<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let state = point.state;
        let b = stretch(&std::array::from_fn(|c| state[STRETCH + c]), point.strain);
        let principal = Principal::new(&b);
        let strains = principal.values.map(|value| value / ((one + value).sqrt() + one));
        let stretches = strains.map(|strain| one + strain);
        let mut rates = [zero; 3];
        if self.has_rates {
            let half = |c: usize| R::splat(if c < 3 { 1.0 } else { 0.5 });
            let normal = principal.normal(&std::array::from_fn(|c| half(c) * point.strain[c]));
            let old = principal.normal(&std::array::from_fn(|c| state[RATE + c]));
            rates = std::array::from_fn(|k| {
                self.mean_rate(old[k], strains[k], -(stretches[k] * normal[k]), dt)
            });
            state[RATE..RATE + 6].copy_from_slice(&principal.compose(rates));
        }
        let parts: [_; 3] = std::array::from_fn(|k| self.nominal(strains[k], rates[k]));
        let last = state.len() - 2;
        let energy = parts[0].energy + parts[1].energy + parts[2].energy;
        let largest = Real::max(state[last], energy);
        let unloads = energy.lt(largest);
        let ratio = R::select(unloads, energy / largest, one);
        let ratio = Real::max(ratio, R::splat(R::SMALLEST));
        let left = R::select(unloads, ratio.powf_where(self.shape, unloads), one);
        let kept = R::splat(1.0 - self.hysteresis).neg_mul_add(one - left, one);
        let volume = stretches[0] * stretches[1] * stretches[2];
        let factor = kept / volume;
        let values = std::array::from_fn(|k| factor * stretches[k] * parts[k].stress);
        let stress = principal.compose(values);
        let by_rate = R::splat(if self.has_rates { self.elastic.youngs_modulus } else { 0.0 });
        let moduli: [R; 3] = std::array::from_fn(|k| {
            stretches[k] * stretches[k] * kept.mul_add(parts[k].slope, by_rate)
        });
        let stiffest = Real::max(Real::max(moduli[0], moduli[1]), moduli[2]);
        let forces = std::array::from_fn(|k| stretches[k] * parts[k].stress);
        let unloading = R::splat((1.0 - self.hysteresis) * self.shape) * left * dot(forces, forces)
            / Real::max(energy, R::splat(R::SMALLEST));
        let modulus = (stiffest + unloading) / volume;
        let over = modulus / R::splat(self.elastic.youngs_modulus) - one;
        state[..STRETCH].copy_from_slice(&stress);
        state[STRETCH..RATE].copy_from_slice(&b);
        state[last] = largest;
        // A fresh point keeps its zeros.
        state[last + 1] = R::select(largest.gt(zero), Real::max(over, zero), zero);
        one
    }
}

impl Solid for LowDensityFoam {
    fn history(&self) -> &'static [&'static str] {
        HISTORY[usize::from(self.has_rates)]
    }
    fn tensors(&self) -> usize {
        1 + usize::from(self.has_rates)
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

    /// A foam of a seat, in MPa.
    const CURVE: [[f64; 2]; 5] = [[0.0, 0.0], [0.05, 0.01], [0.5, 0.02], [0.8, 0.1], [0.9, 1.1]];

    fn foam(more: &[(&str, f64)]) -> Material {
        let numbers = [&[("youngs_modulus", 0.3)], more].concat();
        material("low_density_foam", &numbers, &[("compression", table(&CURVE))])
    }

    fn curve(strain: f64) -> f64 {
        let two = CURVE.windows(2).find(|two| strain <= two[1][0]).unwrap_or(&CURVE[3..]);
        let slope = (two[1][1] - two[0][1]) / (two[1][0] - two[0][0]);
        two[0][1] + slope * (strain - two[0][0])
    }

    /// Area under the curve.
    fn area(strain: f64) -> f64 {
        let n = 20_000;
        let h = strain / f64::from(n);
        (0..n).map(|k| h * curve(h * (f64::from(k) + 0.5))).sum()
    }

    /// Uniaxial compression to 93 % gives the curve, with free and with fixed sides; the step
    /// follows its slope.
    #[test]
    fn compression_follows_the_curve() {
        for free in [true, false] {
            let mut cube = Cube::new(&foam(&[]));
            for percent in 1..94 {
                let strain = 0.01 * f64::from(percent);
                if free {
                    cube.stretch(1.0 - strain, 4, 1.0);
                } else {
                    let each = 2.0 * (0.125 * ((1.0 - strain).ln() - cube.strain[0])).tanh();
                    (0..4).for_each(|_| _ = cube.step([each, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0));
                }
                let got = -cube.state[0];
                assert!((got - curve(strain)).abs() < 1e-11, "{strain}: {got} {}", curve(strain));
                assert!(cube.state[1].abs() < 1e-12 && cube.strain[1].abs() < 1e-12);
            }
            // The modulus of waves in the present state is lambda^2/J dP/dlambda, here that of the
            // sides: 0.2/0.07, against 0.07 times 10 along the load.
            let modulus = 0.2 / 0.07 / 0.3 - 1.0;
            assert!((cube.at("stiffening") - modulus).abs() < 1e-9, "{}", cube.at("stiffening"));
        }
    }

    /// Tension is linear up to its limit, and returns along the same line.
    #[test]
    fn tension_is_cut_off() {
        let mut cube = Cube::new(&foam(&[("tension_cutoff", 0.03)]));
        cube.stretch(1.05, 20, 1.0);
        assert!((cube.state[0] - 0.3 * 0.05).abs() < 1e-13, "{}", cube.state[0]);
        cube.stretch(1.3, 20, 1.0);
        assert!((cube.state[0] - 0.03).abs() < 1e-13, "{}", cube.state[0]);
        cube.stretch(1.05, 20, 1.0);
        assert!((cube.state[0] - 0.3 * 0.05).abs() < 1e-12, "{}", cube.state[0]);
    }

    /// Unloading loses the fraction of the stress that the energy gives. A closed cycle loses
    /// `(1 - hysteresis) shape/(shape + 1)` of the largest energy, and a second one the same.
    #[test]
    fn unloading_loses_the_energy_of_the_closed_form() {
        for shape in [1.0, 3.0] {
            let mut cube = Cube::new(&foam(&[("hysteresis", 0.1), ("shape", shape)]));
            cube.stretch(0.3, 3000, 1.0);
            let largest = area(0.7);
            assert!((cube.work / largest - 1.0).abs() < 1e-4, "{} {largest}", cube.work);
            cube.stretch(0.6, 1000, 1.0);
            let exact = curve(0.4) * (1.0 - 0.9 * (1.0 - (area(0.4) / largest).powf(shape)));
            assert!((-cube.state[0] / exact - 1.0).abs() < 1e-6, "{} {exact}", cube.state[0]);
            cube.stretch(1.0, 1000, 1.0);
            let lost = 0.9 * shape / (shape + 1.0) * largest;
            assert!((cube.work / lost - 1.0).abs() < 1e-3, "{} {lost}", cube.work);
            let first = cube.work;
            cube.stretch(0.4, 1000, 1.0);
            cube.stretch(1.0, 1000, 1.0);
            assert!(cube.work >= first - 1e-6 * first, "{} {first}", cube.work);
        }
    }

    /// At a constant rate the stress is that between the curves of two rates; decompression follows
    /// the lowest one, so that a cycle costs work.
    #[test]
    fn faster_compression_is_stiffer() {
        let rows = [
            [0.01, 0.0, 0.0],
            [0.01, 0.5, 0.02],
            [0.01, 0.9, 0.2],
            [1.01, 0.0, 0.0],
            [1.01, 0.5, 0.06],
            [1.01, 0.9, 0.5],
        ];
        let by_rate = [("compression_by_rate", table(&rows))];
        let law = material("low_density_foam", &[("youngs_modulus", 0.3)], &by_rate);
        for (rate, share) in [(0.001, 0.0), (0.26, 0.25), (0.76, 0.75), (20.0, 1.0)] {
            let mut cube = Cube::new(&law);
            let press = |cube: &mut Cube, by: f64| {
                let length = 1.0 + cube.strain[0].exp_m1();
                let each = 2.0 * by / (length + length + by);
                cube.step([each, 0.0, 0.0, 0.0, 0.0, 0.0], by.abs() / rate);
            };
            (0..500).for_each(|_| press(&mut cube, -0.001));
            let exact = (1.0 - share) * 0.02 + share * 0.06;
            // The rate of a step is that at its middle: one part in a thousand.
            assert!((-cube.state[0] / exact - 1.0).abs() < 2e-3, "{rate}: {}", cube.state[0]);
            (0..250).for_each(|_| press(&mut cube, 0.001));
            assert!((-cube.state[0] / 0.01 - 1.0).abs() < 2e-3, "{rate}: {}", cube.state[0]);
            (0..250).for_each(|_| press(&mut cube, 0.001));
            // The area between the curves up to a strain of 0.5; the running mean lags a little.
            let lost = 0.25 * (exact - 0.02);
            assert!((cube.work - lost).abs() < 0.02 * lost + 1e-6, "{rate}: {} {lost}", cube.work);
        }
    }

    /// Curves at the rates 0 and 1, with which fast compression has four times the stress.
    fn fast() -> Material {
        let rows = [[0.0, 0.0, 0.0], [0.0, 0.6, 0.06], [1.0, 0.0, 0.0], [1.0, 0.6, 0.24]];
        let by_rate = [("compression_by_rate", table(&rows))];
        material("low_density_foam", &[("youngs_modulus", 0.3)], &by_rate)
    }

    /// A slow cycle of one direction with a fast cycle of another inside it costs work: each
    /// direction has its own rate.
    #[test]
    fn a_fast_direction_does_not_stiffen_a_slow_one() {
        let mut cube = Cube::new(&fast());
        let mut move_by = |step: [f64; 3], dt: f64| {
            let [x, y, z] = step;
            (0..500).for_each(|_| _ = cube.step([x, y, z, 0.0, 0.0, 0.0], dt));
        };
        move_by([-1e-3, 0.0, 0.0], 1e6);
        move_by([1e-3, -1e-4, 0.0], 1e-4);
        move_by([0.0, 1e-4, 0.0], 1e6);
        assert!(cube.work > 1e-4, "the fast direction dissipates: {}", cube.work);
        let cost = 0.5 * 0.3 * 0.05 * 0.05;
        assert!(cube.work < cost, "{} above {cost}", cube.work);
    }

    /// Random closed paths with random rates never give energy.
    #[test]
    fn closed_paths_cost_work() {
        for seed in 0..30 {
            let mut cube = Cube::new(&fast());
            let mut noise = Noise(seed);
            let path: Vec<[f64; 6]> =
                (0..4).map(|_| std::array::from_fn(|_| 1e-3 * noise.next())).collect();
            for (sign, legs) in [(1.0, [0, 1, 2, 3]), (-1.0, [3, 2, 1, 0])] {
                for leg in legs {
                    let dt = 10f64.powf(3.0 * noise.next() - 2.0);
                    (0..200).for_each(|_| _ = cube.step(path[leg].map(|e| sign * e), dt));
                }
            }
            assert!(cube.work > -1e-9, "{seed}: {}", cube.work);
        }
    }

    #[test]
    fn wrong_curves_are_refused() {
        let e = [("youngs_modulus", 0.3), ("hysteresis", 2.0)];
        let falling = table(&[[0.0, 0.0], [0.5, 0.1], [0.6, 0.05]]);
        let text = problems(&material("low_density_foam", &e, &[("compression", falling)]));
        assert!(text.contains("wrong order") && text.contains("hysteresis is 2"), "{text}");
        let text = problems(&material("low_density_foam", &e, &[]));
        assert!(text.contains("compression is missing"), "{text}");
        let whole = table(&[[0.0, 0.0], [0.5, 0.1], [1.0, 0.5]]);
        let text = problems(&material("low_density_foam", &e[..1], &[("compression", whole)]));
        assert!(text.contains("strain of 1 or above"), "{text}");
        // The fast curve begins above the slow one and crosses it beyond its last point.
        let rows =
            [[0.0, 0.0, 0.0], [0.0, 0.5, 0.1], [1.0, 0.0, 0.0], [1.0, 0.4, 0.1], [1.0, 0.6, 0.11]];
        let crossing = [("compression_by_rate", table(&rows))];
        let text = problems(&material("low_density_foam", &e[..1], &crossing));
        assert!(text.contains("the rate 1 that lies below") && text.contains("strain 1"), "{text}");
    }
}
