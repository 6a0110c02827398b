//! Concrete with a continuous surface and a cap, as in `*MAT_CSCM` (Murray 2007, Users Manual for
//! LS-DYNA Concrete Material Model 159, FHWA-HRT-05-062, ch. 2). Stresses are positive in
//! compression in the equations of this header.
//!
//! Elastic limit, with the first invariant J1, the second and third of the deviator J2 and J3, and
//! the hardening variable X:
//! ```text
//! J2 <= R^2 F_f^2 F_c
//! F_f = alpha - lambda exp(-beta J1) + theta J1
//! F_c = 1 - ((J1 - L)/(X - L))^2 beyond L, else 1,     X = L + cap_ratio F_f(L)
//! ```
//! R is the ratio of the strength to that of triaxial compression (Rubin 1991): 1 there, Q1 in
//! torsion, Q2 in triaxial extension, each `alpha_i - lambda_i exp(-beta_i J1) + theta_i J1`. In
//! tension Q1 is 1/sqrt(3) and Q2 is 1/2. The cap moves with the compacting plastic volume strain
//! e: `e = W (1 - exp(-D1 (X - X0) - D2 (X - X0)^2))`. It does not return.
//!
//! Plastic flow is associated in the plane of J1 and sqrt(J2): the deviator keeps its direction,
//! and R is held for the direction of flow. The return is the cutting-plane method (Simo & Hughes
//! 1998, sec. 3.6.2), in parts of a large increment.
//!
//! Damage d reduces all stress to `(1 - d)` of it. Brittle damage grows where J1 is negative,
//! ductile damage where it is positive, both from the first dilating flow on:
//! ```text
//! tau_b = sqrt(E) eps_max,          d_b = 0.999/D ((1 + D)/(1 + D exp(-C (tau_b - r_b))) - 1)
//! tau_d = sqrt(sigma:eps/2),        d_d = d_max/B ((1 + B)/(1 + B exp(-A (tau_d - r_d))) - 1)
//! ```
//! with the total strain eps, its largest principal value eps_max, the stress sigma without damage,
//! and the values r_b and r_d of tau at the start. C and A follow from the fracture energies and
//! the size h of the element, so that the energy over the area of the crack does not depend on h:
//! ```text
//! G_t = h r_b (1 + D)/(C D) ln(1 + D)
//! G_c = 4 h (1 + B)/B (r_d ln(1 + B)/A - Li2(-B)/A^2)
//! ```
//! They are the integrals of the stress over the displacement after the peak, in uniaxial tension
//! and with a constant stress without damage. Between shear and tension or compression the energy
//! is that of shear plus `t^power` of the difference, `t = |J1|/sqrt(3 J2)`, at most 1. Where J1
//! exceeds `sqrt(3 J2)`, `d_max = 0.999 (sqrt(3 J2)/J1)^1.5`, and A is that by the energy times
//! `(d_max + 0.001)^softening_power`.
//!
//! In compression brittle damage counts by `1 - (1 - recovery) t` of it. The source lets it step at
//! `J1 = 0`; here it is continuous, because a step of the stress would change the energy.
//!
//! Effects of the rate (optional): the stress is `(1 - g) sigma_trial + g sigma_plastic` with
//! `g = dt/(dt + eta)`, `eta = eta_0/rate^n` between shear and tension or compression as above, at
//! most that of the largest overstress `E rate eta`. The rate is `sqrt(2/3 e:e)` with the rate e of
//! the deviatoric strain. r grows by the overstress, and the energies by the power
//! `rate_energy_power` of the ratio of the strengths.
//!
//! Left out: hardening before the peak (`nh`, `ch`), a cap that returns, damage at the start.

use super::parameters::Parameters;
use super::tensor::{Principal, Symmetric, deviator, inner, trace};
use super::{
    DefaultValue, ELASTIC, Elastic, Form, Law, ParameterRow, SIZE_COLUMN, Solid, SolidLawResult,
    SolidPoint,
};
use crumple_math::lanes::{Lane, Lane32, Real};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law {
    name: "cscm",
    meaning: "Concrete: strength by pressure with a cap, damage by fracture energies.",
    constants: ELASTIC,
    parameters: PARAMETERS,
    build: None,
    solid: Some(solid),
    cohesive: None,
};

const STRENGTH: &str = "shear_surface";
const TORSION: &str = "torsion";
const EXTENSION: &str = "extension";
const CAP: &str = "cap";
const ENERGIES: [&str; 3] = ["tension_energy", "compression_energy", "shear_energy"];
const TENSION_RATE: &str = "tension_rate";
const COMPRESSION_RATE: &str = "compression_rate";

/// Returns the row of a list of numbers.
const fn list(
    key: &'static str,
    form: &'static str,
    otherwise: DefaultValue,
    meaning: &'static str,
) -> ParameterRow {
    ParameterRow { key, form: Form::List(form), otherwise, range: None, meaning }
}

/// Returns the row of a number.
const fn number(key: &'static str, otherwise: DefaultValue, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise, range: None, meaning }
}

const PARAMETERS: &[ParameterRow] = &[
    list(
        STRENGTH,
        "[alpha, theta, lambda, beta]",
        DefaultValue::Needed,
        "Strength sqrt(J2) in triaxial compression over J1 [force/length^2]; theta without \
         dimension, beta [length^2/force].",
    ),
    list(
        TORSION,
        "[alpha, theta, lambda, beta]",
        DefaultValue::Needed,
        "Ratio of the strength in torsion, without dimension; theta and beta [length^2/force].",
    ),
    list(
        EXTENSION,
        "[alpha, theta, lambda, beta]",
        DefaultValue::Needed,
        "Ratio of the strength in triaxial extension, without dimension; theta and beta \
         [length^2/force].",
    ),
    list(
        CAP,
        "[ratio, X0, W, D1, D2]",
        DefaultValue::Needed,
        "The cap: ratio of its axes, J1 where it begins under equal pressure [force/length^2], \
         largest plastic volume strain, D1 [length^2/force], D2 [length^4/force^2].",
    ),
    number(
        ENERGIES[0],
        DefaultValue::Needed,
        "Energy over the area of a crack in tension [force/length].",
    ),
    number(
        ENERGIES[1],
        DefaultValue::Needed,
        "Energy over the area of a crack in compression [force/length].",
    ),
    number(
        ENERGIES[2],
        DefaultValue::Needed,
        "Energy over the area of a crack in shear [force/length].",
    ),
    number(
        "tension_shape",
        DefaultValue::Number(0.1),
        "D: large values let tension soften slowly at first.",
    ),
    number(
        "compression_shape",
        DefaultValue::Number(100.0),
        "B: large values let compression soften slowly at first.",
    ),
    number(
        "tension_power",
        DefaultValue::Number(1.0),
        "Power of the transition from the energy in shear to that in tension.",
    ),
    number(
        "compression_power",
        DefaultValue::Number(5.0),
        "Power of the transition from the energy in shear to that in compression.",
    ),
    number(
        "softening_power",
        DefaultValue::Number(0.0),
        "Power by which confined compression softens more slowly.",
    ),
    number(
        "recovery",
        DefaultValue::Number(0.0),
        "Fraction of the brittle damage that acts in compression, from 0 to 1.",
    ),
    number(
        "erosion_strain",
        DefaultValue::Absent,
        "Largest principal strain above which a point with a damage of 0.99 fails.",
    ),
    list(
        TENSION_RATE,
        "[eta, n, overstress]",
        DefaultValue::Absent,
        "Effect of the rate in tension: eta/rate^n is a time, with the largest overstress \
         [force/length^2]; given together with `compression_rate`.",
    ),
    list(
        COMPRESSION_RATE,
        "[eta, n, overstress]",
        DefaultValue::Absent,
        "Effect of the rate in compression, as in `tension_rate`.",
    ),
    number(
        "shear_rate_ratio",
        DefaultValue::Number(1.0),
        "The time of the rate in shear over that in tension.",
    ),
    number(
        "rate_energy_power",
        DefaultValue::Number(1.0),
        "Power by which the energies of cracks grow with the strength by the rate.",
    ),
];

/// A function `alpha - lambda exp(-beta J1) + theta J1`.
#[derive(Clone, Copy)]
struct Meridian {
    alpha: f64,
    theta: f64,
    lambda: f64,
    beta: f64,
}

impl Meridian {
    fn new([alpha, theta, lambda, beta]: [f64; 4]) -> Self {
        Self { alpha, theta, lambda, beta }
    }

    /// Returns value and slope.
    #[inline(always)]
    fn at<R: Real>(&self, j1: R) -> [R; 2] {
        let [alpha, theta] = [self.alpha, self.theta].map(R::splat);
        let fading = R::splat(self.lambda) * (R::splat(-self.beta) * j1).exp();
        [theta.mul_add(j1, alpha - fading), R::splat(self.beta).mul_add(fading, theta)]
    }

    /// Returns the J1 of tension at which the value is zero, from the positive side.
    fn apex(&self) -> f64 {
        let size = self.at(0.0)[0] / self.at(0.0)[1];
        // The function is concave: it is zero between 0 and the zero of its tangent at 0.
        let (mut low, mut high) = (-size, 0.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if self.at(middle)[0] > 0.0 { high = middle } else { low = middle }
        }
        high
    }
}

/// Effect of the rate: `eta`, `n` and the largest overstress.
#[derive(Clone, Copy)]
struct ConcreteRate([f64; 3]);

/// Effects of the rate.
struct Rates {
    tension: ConcreteRate,
    compression: ConcreteRate,
    shear_ratio: f64,
    energy_power: f64,
}

/// Softening in tension or compression.
struct ConcreteSoftening {
    /// Energy over the area of a crack [force/length].
    energy: f64,
    /// D or B.
    shape: f64,
    /// Power of the transition from shear.
    power: f64,
}

struct Cscm {
    elastic: Elastic,
    strength: Meridian,
    torsion: Meridian,
    extension: Meridian,
    cap: Cap,
    /// J1 of the apex in tension.
    apex: f64,
    tension: ConcreteSoftening,
    compression: ConcreteSoftening,
    shear_energy: f64,
    /// -Li2(-B).
    dilogarithm: f64,
    softening_power: f64,
    recovery: f64,
    erosion: Option<f64>,
    rates: Option<Rates>,
    history: Vec<&'static str>,
}

struct Cap {
    ratio: f64,
    /// X0.
    start: f64,
    /// W, and D1 and D2.
    volume: f64,
    rates: [f64; 2],
}

/// Returns `-Li2(-b)`, the integral of `ln(1 + b x)/x` from 0 to 1.
fn dilogarithm(b: f64) -> f64 {
    // By x = exp(-u): the integral of ln(1 + b exp(-u)) over u, which decays as exp(-u); Simpson.
    let (end, count) = (b.max(1.0).ln() + 40.0, 8000);
    let step = end / f64::from(count);
    let value = |i: i32| (b * (-step * f64::from(i)).exp()).ln_1p();
    let weight = |i: i32| if i == 0 || i == count { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    (0..=count).map(|i| weight(i) * value(i)).sum::<f64>() * step / 3.0
}

fn solid(material: &Material) -> SolidLawResult {
    Parameters::new(material).solid_law(read)
}

/// Returns a list of N finite numbers that `fits` accepts; `wanted` says in words which.
fn numbers<const N: usize>(
    parameters: &mut Parameters<'_>,
    key: &'static str,
    form: &str,
    (wanted, fits): (&str, fn(&[f64; N]) -> bool),
) -> Option<[f64; N]> {
    let given = parameters.get(key)?;
    let values = match given {
        Param::List(list) => <[f64; N]>::try_from(list.as_slice()).ok(),
        _ => None,
    };
    let values = values.filter(|all| all.iter().all(|x| x.is_finite()) && fits(all));
    if values.is_none() {
        parameters.wrong(key, "has no valid numbers", format!("give {form}, {wanted}"));
    }
    values
}

fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<Cscm, Vec<Problem>> {
    let form = "[alpha, theta, lambda, beta]";
    let fits: (&str, fn(&[f64; 4]) -> bool) = (
        "theta, lambda and beta of 0 or above, alpha above lambda, theta or lambda above 0",
        |[alpha, theta, lambda, beta]| {
            *theta >= 0.0
                && *lambda >= 0.0
                && *beta >= 0.0
                && alpha > lambda
                && *theta + lambda * beta > 0.0
        },
    );
    let strength = numbers(&mut parameters, STRENGTH, form, fits);
    let ratios: (&str, fn(&[f64; 4]) -> bool) =
        ("such that the ratio is from 0.5 to 1 at J1 = 0", |[alpha, _, lambda, beta]| {
            (0.49..=1.01).contains(&(alpha - lambda)) && *lambda >= 0.0 && *beta >= 0.0
        });
    let torsion = numbers(&mut parameters, TORSION, form, ratios);
    let extension = numbers(&mut parameters, EXTENSION, form, ratios);
    let cap_fits: (&str, fn(&[f64; 5]) -> bool) = (
        "ratio, X0, W and D1 above 0, W below 1, D2 of 0 or above",
        |[ratio, start, volume, d1, d2]| {
            let hardens = *d1 > 0.0 && *d2 >= 0.0;
            *ratio > 0.0 && *start > 0.0 && *volume > 0.0 && *volume < 1.0 && hardens
        },
    );
    let cap = numbers(&mut parameters, CAP, "[ratio, X0, W, D1, D2]", cap_fits);
    let lists = [
        (STRENGTH, strength.is_some()),
        (TORSION, torsion.is_some()),
        (EXTENSION, extension.is_some()),
        (CAP, cap.is_some()),
    ];
    for (key, read) in lists {
        if !read && !parameters.given(key) {
            parameters.wrong(key, "is missing", "law 'cscm' needs it");
        }
    }
    let energies = ENERGIES.map(|key| parameters.required(key, "above 0", |g| g > 0.0));
    let mut above = |key: &'static str, otherwise: f64| {
        parameters.optional(key, "above 0", |x| x > 0.0).unwrap_or(otherwise)
    };
    let [tension_shape, compression_shape] =
        [above("tension_shape", 0.1), above("compression_shape", 100.0)];
    let [tension_power, compression_power] =
        [above("tension_power", 1.0), above("compression_power", 5.0)];
    let shear_ratio = above("shear_rate_ratio", 1.0);
    let softening_power =
        parameters.optional("softening_power", "0 or above", |x| x >= 0.0).unwrap_or(0.0);
    let energy_power =
        parameters.optional("rate_energy_power", "0 or above", |x| x >= 0.0).unwrap_or(1.0);
    let recovery =
        parameters.optional("recovery", "from 0 to 1", |x| (0.0..=1.0).contains(&x)).unwrap_or(0.0);
    let erosion = parameters.optional("erosion_strain", "0 or above", |x| x >= 0.0);
    let rate_fits: (&str, fn(&[f64; 3]) -> bool) =
        ("eta above 0, n from 0 to below 1, overstress above 0", |[eta, n, over]| {
            *eta > 0.0 && (0.0..1.0).contains(n) && *over > 0.0
        });
    let form = "[eta, n, overstress]";
    let tension_rate = numbers(&mut parameters, TENSION_RATE, form, rate_fits);
    let compression_rate = numbers(&mut parameters, COMPRESSION_RATE, form, rate_fits);
    if parameters.given(TENSION_RATE) != parameters.given(COMPRESSION_RATE) {
        let key = if parameters.given(TENSION_RATE) { COMPRESSION_RATE } else { TENSION_RATE };
        parameters.wrong(key, "is missing", "give both effects of the rate, or none of them");
    }
    parameters.finish()?;
    let rates = tension_rate.zip(compression_rate).map(|(tension, compression)| Rates {
        tension: ConcreteRate(tension),
        compression: ConcreteRate(compression),
        shear_ratio,
        energy_power,
    });
    // All four are known, since nothing is missing.
    let unused = [1.0, 1.0, 0.0, 0.0];
    let strength = Meridian::new(strength.unwrap_or(unused));
    let [ratio, start, volume, d1, d2] = cap.unwrap_or([1.0; 5]);
    let mut history = INVISCID.to_vec();
    history.extend(TOTAL);
    if rates.is_some() {
        history.extend(WITH_RATES);
    }
    history.extend(SCALARS);
    if erosion.is_some() {
        history.push("failed");
    }
    Ok(Cscm {
        elastic,
        strength,
        torsion: Meridian::new(torsion.unwrap_or(unused)),
        extension: Meridian::new(extension.unwrap_or(unused)),
        cap: Cap { ratio, start, volume, rates: [d1, d2] },
        apex: strength.apex(),
        tension: ConcreteSoftening {
            energy: energies[0],
            shape: tension_shape,
            power: tension_power,
        },
        compression: ConcreteSoftening {
            energy: energies[1],
            shape: compression_shape,
            power: compression_power,
        },
        shear_energy: energies[2],
        dilogarithm: dilogarithm(compression_shape),
        softening_power,
        recovery,
        erosion,
        rates,
        history,
    })
}

/// Names of the columns after the stress: the stress without damage and rate.
const INVISCID: [&str; 6] = [
    "plastic stress xx",
    "plastic stress yy",
    "plastic stress zz",
    "plastic stress xy",
    "plastic stress yz",
    "plastic stress zx",
];
/// The total strain.
const TOTAL: [&str; 6] =
    ["strain xx", "strain yy", "strain zz", "strain xy", "strain yz", "strain zx"];
/// The stress without damage, with effects of the rate.
const WITH_RATES: [&str; 6] = [
    "rate stress xx",
    "rate stress yy",
    "rate stress zz",
    "rate stress xy",
    "rate stress yz",
    "rate stress zx",
];
/// The rest.
const SCALARS: [&str; 8] = [
    "plastic_strain",
    "damage",
    "cap volume strain",
    "brittle start",
    "ductile start",
    "brittle damage",
    "ductile damage",
    SIZE_COLUMN,
];
/// Columns of the tensors.
const PLASTIC: usize = 6;
const STRAIN: usize = 12;
const WITH_RATE: usize = 18;

/// Most steps of the return; each reduces the distance to the surface to a fifth or less.
const STEPS: usize = 20;
/// Increments of stress above this fraction of alpha are applied in so many parts.
const LARGE: f64 = 0.1;
const PARTS: usize = 8;
/// Steps of Newton's method for the start of the cap.
const CAP_STEPS: usize = 6;
/// Largest part of the plastic volume strain W that the cap uses.
const FULL: f64 = 0.9999;
/// Largest damage, and the damage from which on a point can fail.
const MOST_DAMAGE: f64 = 0.999;
const FAILS_FROM: f64 = 0.99;

/// The cap at a plastic volume strain.
struct CapPlace<R> {
    /// L, X - L and the slope of F_f at L.
    start: R,
    length: R,
    slope: R,
    /// Derivative of L over the plastic volume strain.
    hardening: R,
}

/// The values on which damage depends.
struct Softens<R: Real> {
    /// Negative J1.
    tensile: R::Mask,
    /// Plastic flow that dilates.
    dilates: R::Mask,
    /// |J1|/sqrt(3 J2) and its inverse, each at most 1.
    t: R,
    shear: R,
    /// Size of the element [length].
    length: R,
    /// Overstress by the rate in steady flow [force/length^2].
    overstress: R,
}

/// The state after plastic flow.
struct ConcreteFlow<R> {
    /// J1 and sqrt(J2).
    j1: R,
    q: R,
    /// Increment of the effective plastic strain.
    strain: R,
    /// Plastic volume strain of the cap.
    cap: R,
    /// Flow along J1, positive if it dilates [length^2/force].
    dilation: R,
}

/// Returns the sine of the angle of Lode of a deviator with `q = sqrt(J2)`: 1/2 in triaxial
/// compression, -1/2 in triaxial extension.
#[inline(always)]
fn sine_of_lode<R: Real>(s: &Symmetric<R>, q: R) -> R {
    let [a, b, c] = Principal::new(s).values;
    let largest = Real::max(Real::max(a, b), c);
    let smallest = Real::min(Real::min(a, b), c);
    let half = R::splat(0.5);
    let sine = R::splat(-0.5 * 3.0_f64.sqrt()) * (largest + smallest)
        / Real::max(q, R::splat(R::SMALLEST.sqrt()));
    Real::max(Real::min(sine, half), -half)
}

impl Cscm {
    /// Returns the cap at a plastic volume strain.
    #[inline(always)]
    fn cap_at<R: Real>(&self, e: R) -> CapPlace<R> {
        let one = R::splat(1.0);
        let [ratio, volume, start] =
            [self.cap.ratio, self.cap.volume, self.cap.start].map(R::splat);
        let [d1, d2] = self.cap.rates.map(R::splat);
        let left = one - e / volume;
        let z = -left.ln();
        let root = R::splat(4.0 * self.cap.rates[1]).mul_add(z, d1 * d1).sqrt();
        let tiny = R::splat(R::SMALLEST);
        let beyond = (z + z) / Real::max(d1 + root, tiny);
        let outer = start + beyond;
        // From the left of the zero of a concave function every step stays left of it.
        let mut l = (outer - R::splat(self.cap.ratio * self.strength.alpha))
            / R::splat(1.0 + self.cap.ratio * self.strength.theta);
        for _ in 0..CAP_STEPS {
            let [value, slope] = self.strength.at(l);
            let over = ratio.mul_add(value, l) - outer;
            l -= over / ratio.mul_add(slope, one);
        }
        let [value, slope] = self.strength.at(l);
        let outer_rate = (volume - e) * (d2 + d2).mul_add(beyond, d1);
        CapPlace {
            start: l,
            length: ratio * value,
            slope,
            hardening: one
                / (Real::max(outer_rate, R::splat(R::SMALLEST.sqrt())) * ratio.mul_add(slope, one)),
        }
    }

    /// Returns the ratio R of Rubin (1991) for the sine of the angle of Lode, 1/2 in triaxial
    /// compression and -1/2 in triaxial extension.
    #[inline(always)]
    fn ratio<R: Real>(&self, j1: R, sine: R) -> R {
        let (zero, one, two) = (R::zero(), R::splat(1.0), R::splat(2.0));
        let pressed = j1.gt(zero);
        let at = Real::max(j1, zero);
        let q1 = R::select(pressed, self.torsion.at(at)[0], R::splat(1.0 / 3.0_f64.sqrt()));
        let q2 = R::select(pressed, self.extension.at(at)[0], R::splat(0.5));
        let [q1, q2] = [Real::min(q1, one), Real::min(q2, one)];
        let less = q2 - one;
        let a0 = two * q1 * q1 * less;
        let a1 = R::splat(3.0_f64.sqrt()).mul_add(q2, two * q1 * less);
        let root = |square: R| Real::max(square, zero).sqrt();
        let a = (root(a1.mul_add(a1, -(R::splat(4.0) * q2 * a0))) - a1) / (two * q2);
        let sum = two.mul_add(q1, a);
        let b = sum.mul_add(sum, -R::splat(3.0));
        let b0 = R::splat(-0.25) * a.neg_mul_add(a, R::splat(3.0) + b);
        let cosine = root(sine.neg_mul_add(sine, one));
        let mixed = a.neg_mul_add(sine, cosine);
        let b1 = a * mixed;
        let b2 = mixed.mul_add(mixed, b * sine * sine);
        (root(b1.mul_add(b1, -(R::splat(4.0) * b2 * b0))) - b1) / (two * b2)
    }

    /// Returns a trial state to the elastic limit.
    #[inline(always)]
    fn flow<R: Real>(&self, j1: R, q: R, sine: R, cap: R) -> ConcreteFlow<R> {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let [g, k9] = [self.elastic.shear_modulus(), 9.0 * self.elastic.bulk_modulus()];
        let [g, k9] = [g, k9].map(R::splat);
        let apex = R::splat(self.apex);
        let small = R::splat(16.0 * R::EPSILON);
        let size = R::splat(self.strength.alpha);
        let least = R::splat(1e-6 * self.strength.alpha);
        let third = R::splat(1.0 / 3.0_f64.sqrt());
        // From below the apex: along the surface there, at most to the apex.
        let opens = j1.lt(apex);
        let slope = self.ratio(apex, sine) * self.strength.at(apex)[1];
        let along = slope.mul_add(apex - j1, q) / k9.mul_add(slope * slope, g);
        let step = R::select(opens, Real::min(along, q / g), zero);
        let raised = (k9 * slope).mul_add(step, j1);
        let start = Real::max(raised, apex);
        let mut to = ConcreteFlow {
            j1: start,
            q: Real::max(g.neg_mul_add(step, q), zero),
            strain: third * step,
            cap,
            dilation: R::select(opens, (start - j1) / k9, zero),
        };
        let limit = |to: &ConcreteFlow<R>| {
            let ratio = self.ratio(to.j1, sine);
            let [value, slope] = self.strength.at(to.j1);
            let place = self.cap_at(to.cap);
            let surface = Real::max(ratio * value, least);
            let w = Real::max(to.j1 - place.start, zero) / place.length;
            (surface, ratio * slope, place, w)
        };
        let mut began = zero.gt(zero);
        for _ in 0..STEPS {
            let (surface, slope, place, w) = limit(&to);
            let m = to.q / surface;
            let u = m.mul_add(m, w * w).sqrt();
            let over = surface * (u - one);
            // A step past the surface is taken back.
            let tolerance = small * (size + to.j1.abs());
            let flows = R::either(over.gt(tolerance), R::both(began, over.lt(-tolerance)));
            if !R::any(flows) {
                break;
            }
            began = R::either(began, flows);
            let per = one / Real::max(u, R::splat(R::SMALLEST.sqrt()));
            let by_q = m * per;
            let by_j = slope.mul_add(u - one - m * m * per, surface * w * per / place.length);
            let compacts = Real::max(by_j, zero);
            let moved = w.mul_add(R::splat(self.cap.ratio) * place.slope, one) / place.length;
            let hardening = surface * w * per * moved * place.hardening * R::splat(3.0) * compacts;
            let stiffness = g.mul_add(by_q * by_q, k9.mul_add(by_j * by_j, hardening));
            let step = R::select(flows, over / stiffness, zero);
            let radial = Real::min(step * by_q, to.q / g);
            to.q = Real::max(g.neg_mul_add(radial, to.q), zero);
            to.j1 = Real::max(k9.neg_mul_add(step * by_j, to.j1), apex);
            to.strain += third * radial;
            let full = R::splat(FULL * self.cap.volume);
            let added = (R::splat(3.0) * step).mul_add(compacts, to.cap);
            to.cap = R::select(flows, Real::max(Real::min(added, full), cap), to.cap);
            to.dilation -= step * by_j;
        }
        // A small part of a step is left of the distance.
        let (surface, _, place, w) = limit(&to);
        let outer = place.start + place.length;
        to.j1 = R::select(to.j1.gt(outer), outer, to.j1);
        let inside = Real::min(w, one);
        let most = surface * Real::max(inside.neg_mul_add(inside, one), zero).sqrt();
        to.q = R::select(to.j1.gt(apex), Real::min(to.q, most), zero);
        to
    }

    /// Returns the energy between that of shear and that of tension or compression.
    #[inline(always)]
    fn energy<R: Real>(&self, softening: &ConcreteSoftening, t: R) -> R {
        let acts = t.gt(R::zero());
        let part = R::select(acts, t.powf_where(softening.power, acts), R::zero());
        R::splat(softening.energy - self.shear_energy).mul_add(part, R::splat(self.shear_energy))
    }

    /// Returns the damage by `tau - r` over the softening parameter, from 0 to `most`.
    #[inline(always)]
    fn damage<R: Real>(shape: f64, most: R, exponent: R) -> R {
        let (one, b) = (R::splat(1.0), R::splat(shape));
        let decay = (-Real::min(Real::max(exponent, R::zero()), R::splat(80.0))).exp();
        most / b * ((one + b) / b.mul_add(decay, one) - one)
    }

    #[inline(always)]
    fn solid<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let (state, eps) = (point.state, point.strain);
        let (zero, one, half) = (R::zero(), R::splat(1.0), R::splat(0.5));
        let tiny = R::splat(R::SMALLEST.sqrt());
        let [lame, g] = [self.elastic.lame(), self.elastic.shear_modulus()].map(R::splat);
        let pressure = lame * (eps[0] + eps[1] + eps[2]);
        let elastic: [R; 6] = std::array::from_fn(|c| match c {
            0..3 => (g + g).mul_add(eps[c], pressure),
            _ => g * eps[c],
        });
        let shift = if self.rates.is_some() { WITH_RATE + 6 } else { WITH_RATE };
        let [plastic_strain, damage, cap, starts, ends, size, failed] =
            [0, 1, 2, 3, 5, 7, 8].map(|c| shift + c);

        // 1. The stress without damage and rate; a large increment in parts.
        let trial: Symmetric<R> = std::array::from_fn(|c| state[PLASTIC + c] + elastic[c]);
        let s = deviator(&trial);
        let q = (half * inner(&s, &s)).sqrt();
        let large = inner(&elastic, &elastic).gt(R::splat((LARGE * self.strength.alpha).powi(2)));
        let share = R::select(large, R::splat(1.0 / PARTS as f64), one);
        let part = elastic.map(|increment| share * increment);
        let mut inviscid: Symmetric<R> = std::array::from_fn(|c| state[PLASTIC + c]);
        let mut to =
            ConcreteFlow { j1: -trace(&trial), q, strain: zero, cap: state[cap], dilation: zero };
        let mut flows = zero.gt(zero);
        for k in 0..PARTS {
            let acts = if k == 0 { zero.le(zero) } else { large };
            if !R::any(acts) {
                break;
            }
            let next: Symmetric<R> = std::array::from_fn(|c| inviscid[c] + part[c]);
            let s = deviator(&next);
            let q = (half * inner(&s, &s)).sqrt();
            let new = self.flow(-trace(&next), q, sine_of_lode(&s, q), to.cap);
            let kept = R::select(q.gt(tiny), new.q / Real::max(q, tiny), one);
            let mean = R::splat(-1.0 / 3.0) * new.j1;
            let moved = R::either(new.strain.abs().gt(zero), new.dilation.abs().gt(zero));
            for c in 0..6 {
                let back = if c < 3 { kept.mul_add(s[c], mean) } else { kept * s[c] };
                let stress = R::select(moved, back, next[c]);
                inviscid[c] = R::select(acts, stress, inviscid[c]);
            }
            flows = R::either(flows, R::both(acts, moved));
            to.j1 = R::select(acts, new.j1, to.j1);
            to.q = R::select(acts, new.q, to.q);
            to.cap = R::select(acts, new.cap, to.cap);
            to.strain += R::select(acts, new.strain, zero);
            to.dilation += R::select(acts, new.dilation, zero);
        }
        state[PLASTIC..PLASTIC + 6].copy_from_slice(&inviscid);
        state[cap] = to.cap;
        state[plastic_strain] += to.strain;

        // 2. Effects of the rate.
        let tensile = to.j1.lt(zero);
        let von_mises = R::splat(3.0_f64.sqrt()) * to.q;
        let t = Real::min(to.j1.abs() / Real::max(von_mises, tiny), one);
        let shear = Real::min(von_mises / Real::max(to.j1.abs(), tiny), one);
        let mut viscid = inviscid;
        let mut overstress = zero;
        if let Some(rates) = &self.rates {
            let share;
            (share, overstress) = self.share(rates, eps, dt, tensile, t);
            for c in 0..6 {
                let old = state[WITH_RATE + c] + elastic[c];
                viscid[c] = share.mul_add(inviscid[c] - old, old);
            }
            state[WITH_RATE..WITH_RATE + 6].copy_from_slice(&viscid);
        }

        // 3. Damage.
        for c in 0..6 {
            state[STRAIN + c] += if c < 3 { eps[c] } else { half * eps[c] };
        }
        let strain: Symmetric<R> = std::array::from_fn(|c| state[STRAIN + c]);
        let dilates = to.dilation.gt(zero);
        let known = R::either(state[starts].gt(zero), state[starts + 1].gt(zero));
        let mut greatest = zero;
        if R::any(R::either(dilates, known)) {
            // An element has stored its size; a point without one counts as one unit.
            let length = R::select(state[size].gt(zero), state[size], one);
            let softens = Softens { tensile, dilates, t, shear, length, overstress };
            let tau: [R; 2];
            (tau, greatest) = self.tau(&inviscid, &strain);
            // The flow begins within the step, after this part of it.
            let flowed: Symmetric<R> = std::array::from_fn(|c| trial[c] - inviscid[c]);
            let whole = Real::max(inner(&elastic, &elastic), tiny).sqrt();
            let part = Real::min(inner(&flowed, &flowed).sqrt() / whole, one);
            let start: Symmetric<R> = std::array::from_fn(|c| {
                let moved = if c < 3 { eps[c] } else { half * eps[c] };
                part.neg_mul_add(moved, strain[c])
            });
            let (first, _) = self.tau(&inviscid, &start);
            self.soften(&mut state[starts..ends + 2], softens, tau, first);
        }
        let closing = R::splat(1.0 - self.recovery).neg_mul_add(t, one);
        let brittle = R::select(tensile, state[ends], closing * state[ends]);
        let total = Real::max(brittle, state[ends + 1]);
        state[damage] = total;
        let mut factor = one - total;
        if let Some(limit) = self.erosion {
            let breaks = R::both(total.ge(R::splat(FAILS_FROM)), greatest.gt(R::splat(limit)));
            let broken = R::select(breaks, one, state[failed]);
            state[failed] = broken;
            factor = R::select(broken.gt(half), zero, factor);
        }
        for c in 0..6 {
            state[c] = factor * viscid[c];
        }
        let moved = deviator(&viscid);
        let left = factor * (half * inner(&moved, &moved)).sqrt() / Real::max(q, tiny);
        let changed = R::either(flows, factor.lt(one));
        R::select(R::both(changed, q.gt(tiny)), Real::min(left, one), factor)
    }

    /// Returns the share of the plastic stress in the step, and the overstress in steady flow.
    #[inline(always)]
    fn share<R: Real>(
        &self,
        rates: &Rates,
        eps: &[R; 6],
        dt: f64,
        tensile: R::Mask,
        t: R,
    ) -> (R, R) {
        let (zero, half, tiny) = (R::zero(), R::splat(0.5), R::splat(R::SMALLEST.sqrt()));
        let tensor: Symmetric<R> =
            std::array::from_fn(|c| if c < 3 { eps[c] } else { half * eps[c] });
        let e = deviator(&tensor);
        let per_dt = R::splat(if dt > 0.0 { 1.0 / dt } else { 0.0 });
        let rate = per_dt * (R::splat(2.0 / 3.0) * inner(&e, &e)).sqrt();
        let moves = rate.gt(tiny);
        let of =
            |ConcreteRate([eta, n, _]): ConcreteRate| R::splat(eta) * rate.powf_where(-n, moves);
        let acts = t.gt(zero);
        let part = |softening: &ConcreteSoftening| {
            R::select(acts, t.powf_where(softening.power, acts), zero)
        };
        let shear = R::splat(rates.shear_ratio) * of(rates.tension);
        let between = |time: R, part: R| part.mul_add(time - shear, shear);
        let time = R::select(
            tensile,
            between(of(rates.tension), part(&self.tension)),
            between(of(rates.compression), part(&self.compression)),
        );
        let [tension, compression] = [rates.tension.0[2], rates.compression.0[2]].map(R::splat);
        let stress = R::splat(self.elastic.youngs_modulus) * rate;
        let overstress = Real::min(stress * time, R::select(tensile, tension, compression));
        let time = overstress / Real::max(stress, tiny);
        let share = R::splat(dt) / (R::splat(dt) + time);
        (R::select(moves, share, zero), R::select(moves, overstress, zero))
    }

    /// Returns tau_b and tau_d, and the largest principal strain.
    #[inline(always)]
    fn tau<R: Real>(&self, stress: &Symmetric<R>, strain: &Symmetric<R>) -> ([R; 2], R) {
        let values = Principal::new(strain).values;
        let greatest = Real::max(Real::max(values[0], values[1]), values[2]);
        let root = R::splat(self.elastic.youngs_modulus.sqrt());
        let brittle = root * Real::max(greatest, R::zero());
        let work = R::splat(0.5) * inner(stress, strain);
        ([brittle, Real::max(work, R::zero()).sqrt()], greatest)
    }

    /// Advances starts and values of both damages: columns r_b, r_d, d_b, d_d. `first` has
    /// tau where the flow of this step begins.
    #[inline(always)]
    fn soften<R: Real>(&self, columns: &mut [R], now: Softens<R>, tau: [R; 2], first: [R; 2]) {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let Softens { tensile, dilates, t, shear, length, overstress } = now;
        let compressive = R::select(tensile, zero, one).gt(zero);
        for (c, acts) in [tensile, compressive].into_iter().enumerate() {
            let begins = R::both(R::both(acts, dilates), columns[c].le(zero));
            columns[c] = R::select(begins, first[c], columns[c]);
        }
        let tiny = R::splat(R::SMALLEST.sqrt());
        let e = self.elastic.youngs_modulus;
        let power = self.rates.as_ref().map_or(0.0, |rates| rates.energy_power);
        let stronger = |start: R, scale: f64| {
            let raised = R::splat(scale).mul_add(overstress, start);
            let ratio = raised / Real::max(start, tiny);
            let by_rate = overstress.gt(zero);
            let energy = R::select(by_rate, ratio.powf_where(power, by_rate), one);
            (raised, energy)
        };

        let d = self.tension.shape;
        let (start, factor) = stronger(columns[0], 1.0 / e.sqrt());
        let energy = factor * self.energy(&self.tension, t);
        let rate = length * start * R::splat((1.0 + d) / d * d.ln_1p()) / energy;
        let value = Self::damage(d, R::splat(MOST_DAMAGE), rate * (tau[0] - start));
        let acts = R::both(tensile, columns[0].gt(zero));
        columns[2] = Real::max(columns[2], R::select(acts, value, zero));

        let b = self.compression.shape;
        let (start, factor) = stronger(columns[1], 1.0 / (2.0 * e).sqrt());
        let energy = factor * self.energy(&self.compression, t);
        let scaled = energy * R::splat(b / (4.0 * (1.0 + b))) / length;
        let linear = start * R::splat(b.ln_1p());
        let root = linear.mul_add(linear, R::splat(4.0 * self.dilogarithm) * scaled).sqrt();
        let rate = (linear + root) / Real::max(scaled + scaled, tiny);
        let confined = shear.lt(one);
        let most = R::splat(MOST_DAMAGE) * shear * shear.sqrt();
        let slower =
            (most + R::splat(1.0 - MOST_DAMAGE)).powf_where(self.softening_power, confined);
        let slower = R::select(confined, slower, one);
        let value = Self::damage(b, most, slower * rate * (tau[1] - start));
        let acts = R::both(compressive, columns[1].gt(zero));
        columns[3] = Real::max(columns[3], R::select(acts, value, zero));
    }
}

impl Solid for Cscm {
    fn history(&self) -> &[&'static str] {
        &self.history
    }
    fn tensors(&self) -> usize {
        if self.rates.is_some() { 3 } else { 2 }
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
#[path = "cscm_tests.rs"]
mod tests;
