//! Equations of state: the pressure of solids at large compression, which any law can have in place
//! of its bulk modulus. The law keeps its deviator.
//!
//! With `mu = 1/V - 1`, V the ratio of the volume to that at the start, and the internal energy E
//! per volume at the start, the pressure is `p = A(mu) + B(mu) E`:
//! ```text
//! Mie-Gruneisen (Mie 1903, Gruneisen 1912; the Hugoniot is U_s = c + s1 u + ...):
//!   A = rho c^2 mu (1 + (1 - gamma/2) mu - a/2 mu^2) / D^2   for mu > 0,   rho c^2 mu   else
//!   D = 1 - (s1 - 1) mu - s2 mu^2/(1 + mu) - s3 mu^3/(1 + mu)^2,   B = gamma + a mu
//! Polynomial:
//!   A = c1 mu + c2 mu^2 + c3 mu^3,   B = c4 + c5 mu + c6 mu^2   (c2 and c6 for mu > 0 only)
//! Tabulated:
//!   A = C(-ln V),   B = gamma T(-ln V), linear between the points and beyond their ends
//! ```
//! E is the work of the stress, and that of the bulk viscosity, which the element adds; heat is not
//! conducted. The equation of p and E over a step is linear and solved exactly:
//! `E = E* - p dV/2` with the work of all other stress in `E*`.
//!
//! The step follows the adiabatic bulk modulus `(1 + mu) dp/dmu + V p B`. Where D has no positive
//! value the pressure is infinite, and the run stops.

use super::polyline::AnchoredCurve;
use super::tensor::{deviator, inner, trace};
use super::{
    DefaultValue, Elastic, Form, HEAT_COLUMN, MaterialAxes, ParameterRow, PointReal, Solid,
    SolidPoint,
};
use crumple_math::lanes::{Lane, Lane32, Real};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

const GRUNEISEN: &str = "eos_gruneisen";
const POLYNOMIAL: &str = "eos_polynomial";
const TABLE: &str = "eos_table";
const CUTOFF: &str = "eos_min_pressure";
/// Number of constants of the first two forms.
const CONSTANTS: usize = 6;
/// Shear modulus of a fluid over its bulk modulus, in its elastic constants: they cannot be without
/// any. No force follows from it.
const FLUID_SHEAR: f64 = 1e-6;

/// Keys of all laws.
pub const EQUATION_OF_STATE: &[ParameterRow] = &[
    ParameterRow {
        key: GRUNEISEN,
        form: Form::List("[c, s1, s2, s3, gamma, a]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Pressure of solids by Mie and Gruneisen: speed of sound c [length/time], slopes \
                  of the shock velocity, Gruneisen's coefficient and its first-order change.",
    },
    ParameterRow {
        key: POLYNOMIAL,
        form: Form::List("[c1, c2, c3, c4, c5, c6]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Pressure of solids as polynomials of the compression mu: `c1 mu + c2 mu^2 + \
                  c3 mu^3 + (c4 + c5 mu + c6 mu^2) E`; c1 to c3 in force/length^2.",
    },
    ParameterRow {
        key: TABLE,
        form: Form::List("[[-ln V, C, gamma T], ...]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Pressure of solids by a table: `C + gamma T E` with V the volume over that at \
                  the start, linear between its rows and beyond the first and the last; -ln V \
                  ascends, and C ascends through 0 at 0.",
    },
    ParameterRow {
        key: CUTOFF,
        form: Form::Number,
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Least pressure of the equation of state, negative in tension: spall; 0 is no \
                  tension at all [force/length^2].",
    },
];

/// A pressure by compression and energy.
#[derive(Clone, Debug, PartialEq)]
enum PressureForm {
    /// See above; with `rho c^2` [force/length^2] in place of c.
    Gruneisen([f64; CONSTANTS]),
    Polynomial([f64; CONSTANTS]),
    /// C [force/length^2] and gamma T.
    Table([AnchoredCurve; 2]),
}

/// The equation of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct Equation {
    form: PressureForm,
    /// Least pressure [force/length^2]; minus infinity if there is none.
    cutoff: f64,
}

/// Returns the material without these keys, and its equation; or all problems of them.
pub fn split(material: &Material) -> Result<(Material, Option<Equation>), Vec<Problem>> {
    let mut rest = material.clone();
    let mut problems = Vec::new();
    let name = &material.name;
    let mut wrong = |key: &str, what: &str, help: &str| {
        let message = format!("material '{name}': {key} {what}");
        problems.push(Problem::error(key, message, help));
    };
    let mut list = |key: &str, form: &str| -> Option<[f64; CONSTANTS]> {
        let given = rest.parameters.remove(key)?;
        let numbers: Option<[f64; CONSTANTS]> = match &given {
            Param::List(list) => list.as_slice().try_into().ok(),
            _ => None,
        };
        let fits = numbers.filter(|n| n.iter().all(|x| x.is_finite()) && n[0] > 0.0);
        if fits.is_none() {
            let help = format!("give {form}: six numbers, the first above 0");
            wrong(key, "is not valid", &help);
        }
        fits
    };
    let given = [GRUNEISEN, POLYNOMIAL, TABLE].map(|key| material.parameters.contains_key(key));
    let gruneisen = list(GRUNEISEN, "[c, s1, s2, s3, gamma, a]");
    let polynomial = list(POLYNOMIAL, "[c1, c2, c3, c4, c5, c6]");
    let table = rest.parameters.remove(TABLE).map(|table| curves(&table));
    if let Some(Err(help)) = &table {
        wrong(TABLE, "is not valid", help);
    }
    if given.iter().filter(|given| **given).count() > 1 {
        let what = "is given together with another equation of state";
        let last = if given[2] { TABLE } else { POLYNOMIAL };
        wrong(last, what, "give only one of them");
    }
    let cutoff = match rest.parameters.remove(CUTOFF) {
        None => f64::NEG_INFINITY,
        Some(Param::Number(p)) if p.is_finite() && p <= 0.0 => p,
        Some(_) => {
            wrong(CUTOFF, "is not valid", "it has to be 0 or below");
            f64::NEG_INFINITY
        }
    };
    let form = match (gruneisen, polynomial, table) {
        (Some([c, rest @ ..]), ..) => Some(Equation::gruneisen(material.density, c, rest).form),
        (None, Some(constants), _) => Some(PressureForm::Polynomial(constants)),
        (None, None, Some(Ok(curves))) => Some(PressureForm::Table(curves)),
        (None, None, _) => None,
    };
    if form.is_none() && cutoff > f64::NEG_INFINITY && problems.is_empty() {
        let message = format!("material '{name}': {CUTOFF} is given without an equation of state");
        let help = "give eos_gruneisen, eos_polynomial or eos_table, or use erosion_min_pressure";
        problems.push(Problem::error(CUTOFF, message, help));
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    Ok((rest, form.map(|form| Equation { form, cutoff })))
}

/// Returns the curves C and gamma T of a table, or what it has to be.
fn curves(table: &Param) -> Result<[AnchoredCurve; 2], &'static str> {
    let Param::Table(rows) = table else { return Err("give rows [-ln V, C, gamma T]") };
    let rows: Option<Vec<[f64; 3]>> =
        rows.iter().map(|row| row.as_slice().try_into().ok()).collect();
    let Some(rows) = rows.filter(|rows| rows.as_flattened().iter().all(|x| x.is_finite())) else {
        return Err("give rows of three numbers, [-ln V, C, gamma T]");
    };
    if rows.len() < 2 || rows.windows(2).any(|two| two[1][0] <= two[0][0]) {
        return Err("give two rows or more, whose -ln V ascends");
    }
    let of = |at: usize| AnchoredCurve::new(rows.iter().map(|row| [row[0], row[at]]));
    let [cold, thermal] = [of(1), of(2)];
    let ascends = rows.windows(2).all(|two| two[1][1] >= two[0][1]);
    // A pressure of the size of rounding is that of a state without stress.
    let most = rows.iter().fold(0.0, |most: f64, row| most.max(row[1].abs()));
    if cold.at_zero().abs() > 1e-9 * most || !ascends || cold.steepest_at_zero() <= 0.0 {
        return Err("C has to be 0 at -ln V = 0, and may not descend; it ascends next to 0");
    }
    Ok([cold.through_zero(), thermal])
}

/// Pressure at a state: `A`, `B`, and their derivatives by mu.
struct Terms<R> {
    a: R,
    b: R,
    d_a: R,
    d_b: R,
}

impl Equation {
    /// Creates the equation of Mie and Gruneisen with the constants s1, s2, s3, gamma and a.
    pub fn gruneisen(density: f64, c: f64, [s1, s2, s3, gamma, a]: [f64; 5]) -> Self {
        let form = PressureForm::Gruneisen([density * c * c, s1, s2, s3, gamma, a]);
        Self { form, cutoff: f64::NEG_INFINITY }
    }

    /// Returns the pressure [force/length^2] at the compression `mu` with the energy E per volume
    /// at the start, and its derivatives by `mu` and by E.
    pub fn pressure(&self, mu: f64, energy: f64) -> [f64; 3] {
        let Terms { a, b, d_a, d_b } = self.terms(mu, -mu.ln_1p());
        [a + b * energy, d_a + d_b * energy, b]
    }

    /// Returns the bulk modulus at the start [force/length^2].
    pub fn bulk_modulus(&self) -> f64 {
        match &self.form {
            PressureForm::Gruneisen(c) | PressureForm::Polynomial(c) => c[0],
            PressureForm::Table([cold, _]) => cold.steepest_at_zero(),
        }
    }

    /// Computes the terms at the compression `mu` with the logarithm of the ratio of volumes.
    #[inline(always)]
    fn terms<R: Real>(&self, mu: R, volume_strain: R) -> Terms<R> {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let compressed = mu.gt(zero);
        let in_compression = |x: R| R::select(compressed, x, zero);
        match &self.form {
            PressureForm::Table([cold, thermal]) => {
                let per_mu = one / (one + mu);
                let [[a, d_a], [b, d_b]] = [cold, thermal].map(|curve| curve.at(-volume_strain));
                Terms { a, b, d_a: d_a * per_mu, d_b: d_b * per_mu }
            }
            &PressureForm::Gruneisen([bulk, s1, s2, s3, gamma, a]) => {
                let [bulk, gamma, a] = [bulk, gamma, a].map(R::splat);
                let half = R::splat(0.5);
                let mu_c = in_compression(mu);
                let ratio = mu_c / (one + mu_c);
                let n_2 = half.neg_mul_add(gamma, one);
                // N/mu and N', D and D'.
                let n = mu_c.mul_add((half * a).neg_mul_add(mu_c, n_2), one);
                let d_n = mu_c.mul_add((R::splat(1.5) * a).neg_mul_add(mu_c, n_2 + n_2), one);
                let [s1, s2, s3] = [s1 - 1.0, s2, s3].map(R::splat);
                let d = one - mu_c * (s1 + ratio * (s2 + ratio * s3));
                let d_d = -(s1
                    + ratio * (R::splat(2.0) - ratio) * s2
                    + ratio * ratio * (R::splat(3.0) - (ratio + ratio)) * s3);
                let valid = d.gt(zero);
                let per_d = one / R::select(valid, d, one);
                let over = bulk * per_d * per_d;
                Terms {
                    a: R::select(valid, over * n * mu, R::splat(f64::INFINITY)),
                    b: a.mul_add(mu, gamma),
                    d_a: over * ((n * mu_c * d_d) * (per_d + per_d)).neg_mul_add(one, d_n),
                    d_b: a,
                }
            }
            &PressureForm::Polynomial(constants) => {
                let [c1, c2, c3, c4, c5, c6] = constants.map(R::splat);
                let (c2, c6) = (in_compression(c2), in_compression(c6));
                let square = mu * mu;
                Terms {
                    a: mu * c3.mul_add(square, c2.mul_add(mu, c1)),
                    b: c6.mul_add(square, c5.mul_add(mu, c4)),
                    d_a: (R::splat(3.0) * c3).mul_add(square, (c2 + c2).mul_add(mu, c1)),
                    d_b: (c6 + c6).mul_add(mu, c5),
                }
            }
        }
    }
}

/// A law with an equation of state.
struct WithEquation {
    law: Box<dyn Solid>,
    equation: Equation,
    elastic: Elastic,
    names: Vec<&'static str>,
    /// Number of columns of stress and of the law.
    own: usize,
    /// Columns: logarithm of the volume, energy per volume at the start, stiffening, failure.
    volume: usize,
    energy: usize,
    stiffening: usize,
    failed: Option<usize>,
    /// `8 eta/(3 M)` of a fluid [time], M its bulk modulus; see `fluid.rs`.
    viscous: Option<f64>,
}

/// Gives a law of solids an equation of state, if there is one.
pub fn solid(
    material: &Material,
    law: Box<dyn Solid>,
    equation: Option<Equation>,
) -> Result<Box<dyn Solid>, Vec<Problem>> {
    let Some(equation) = equation else {
        return match law.viscosity() {
            None => Ok(law),
            Some(_) => {
                let message = format!("material '{}': a fluid has no pressure", material.name);
                let help = "give it eos_gruneisen, eos_polynomial or eos_table";
                Err(vec![Problem::error("law", message, help)])
            }
        };
    };
    let mut names = law.history().to_vec();
    if names.contains(&"stiffening") {
        let Material { name, law, .. } = material;
        let message = format!("material '{name}': the law '{law}' has a pressure of its own");
        return Err(vec![Problem::error("law", message, "remove the equation of state")]);
    }
    let own = 6 + names.len();
    names.extend(["volume strain", HEAT_COLUMN, "stiffening"]);
    let failed = names.iter().position(|name| *name == "failed").map(|at| 6 + at);
    // Moduli of small strain: the bulk modulus of the equation, the shear modulus of the law.
    let bulk = equation.bulk_modulus();
    let shear = match law.viscosity() {
        None => law.elastic().shear_modulus(),
        Some(_) => FLUID_SHEAR * bulk,
    };
    let viscous = law.viscosity().map(|eta| 8.0 / 3.0 * eta / bulk);
    let elastic = Elastic {
        youngs_modulus: 9.0 * bulk * shear / (3.0 * bulk + shear),
        poisson: 0.5 * (3.0 * bulk - 2.0 * shear) / (3.0 * bulk + shear),
        density: law.elastic().density,
    };
    let (volume, energy, stiffening) = (own, own + 1, own + 2);
    Ok(Box::new(WithEquation {
        law,
        equation,
        elastic,
        names,
        own,
        volume,
        energy,
        stiffening,
        failed,
        viscous,
    }))
}

impl WithEquation {
    #[inline(always)]
    fn point<R: PointReal>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let (state, strain) = (point.state, point.strain);
        let (zero, one, half) = (R::zero(), R::splat(1.0), R::splat(0.5));
        let third = R::splat(1.0 / 3.0);

        // 1. Deviator by the law.
        let before: [R; 6] = std::array::from_fn(|c| state[c]);
        let own = SolidPoint { state: &mut state[..self.own], strain };
        let left = R::update_solid(&*self.law, own, dt);
        let after: [R; 6] = std::array::from_fn(|c| state[c]);
        let alive = match self.failed {
            Some(column) => state[column].lt(half),
            None => zero.le(zero),
        };

        // 2. Volume, and energy without the pressure at the end.
        let change = strain[0] + strain[1] + strain[2];
        let first = state[self.volume].exp();
        state[self.volume] += change;
        let volume = state[self.volume].exp();
        let (d_v, mean_v) = (volume - first, half * (volume + first));
        let (s0, s1) = (deviator(&before), deviator(&after));
        let mean: [R; 6] = std::array::from_fn(|c| half * (s0[c] + s1[c]));
        // `inner` counts shear twice; the strains are engineering ones.
        let halved: [R; 6] =
            std::array::from_fn(|c| if c < 3 { strain[c] } else { half * strain[c] });
        let p0 = -third * trace(&before);
        let energy = mean_v.mul_add(inner(&mean, &halved), state[self.energy]) - half * p0 * d_v;

        // 3. Pressure.
        let mu = one / volume - one;
        let Terms { a, b, d_a, d_b } = self.equation.terms(mu, state[self.volume]);
        let below = (half * b).mul_add(d_v, one);
        let valid = below.gt(zero);
        // Too large a step has no solution either.
        let solution = b.mul_add(energy, a) / R::select(valid, below, one);
        let pressure = R::select(valid, solution, R::splat(f64::INFINITY));
        let pressure = Real::max(pressure, R::splat(self.equation.cutoff));
        let energy = (half * pressure).neg_mul_add(d_v, energy);
        state[self.energy] = R::select(alive, energy, state[self.energy]);
        for c in 0..6 {
            let stress = if c < 3 { s1[c] - pressure } else { s1[c] };
            state[c] = R::select(alive, stress, zero);
        }

        // 4. Stiffening.
        let bulk = (one + mu).mul_add(d_b.mul_add(energy, d_a), volume * pressure * b);
        let modulus = self.elastic.lame() + 2.0 * self.elastic.shear_modulus();
        let more = (bulk - R::splat(self.equation.bulk_modulus())) * R::splat(1.0 / modulus);
        let more = match self.viscous {
            // A state without strain stays zero.
            Some(viscous) if dt > 0.0 => {
                let moved = strain.iter().fold(zero, |sum, e| sum + e.abs()).gt(zero);
                more + R::select(moved, R::splat(viscous / dt), zero)
            }
            _ => more,
        };
        state[self.stiffening] = R::select(alive, Real::max(more, zero), zero);
        left
    }
}

impl Solid for WithEquation {
    fn history(&self) -> &[&'static str] {
        &self.names
    }
    fn tensors(&self) -> usize {
        self.law.tensors()
    }
    fn axes(&self) -> Option<MaterialAxes> {
        self.law.axes()
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn averages_volume(&self) -> bool {
        false
    }
    fn viscosity(&self) -> Option<f64> {
        self.law.viscosity()
    }
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) -> Lane {
        self.point(point, dt)
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, dt: f64) -> Lane32 {
        self.point(point, dt)
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) -> f64 {
        self.point(point, dt)
    }
}

#[cfg(test)]
#[path = "equation_of_state_tests.rs"]
mod tests;
