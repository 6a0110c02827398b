//! Rubber of Ogden (1972), in the compressible form of `*MAT_OGDEN_RUBBER`:
//! ```text
//! W = sum_j mu_j/alpha_j (l1^alpha_j + l2^alpha_j + l3^alpha_j - 3) + K (J - 1 - ln J)
//! K = 2 G (1 + nu) / (3 (1 - 2 nu)),   G = sum_j mu_j alpha_j / 2
//! ```
//! with the isochoric stretches `l_i = lambda_i J^(-1/3)`. Uniaxial stress near nu = 1/2 is
//! `sum mu_j (lambda^alpha_j - lambda^(-alpha_j/2))`.

use super::{Rubber, StrainEnergy, check_shear, elastic_of_shear, poisson};
use crate::materials::parameters::Parameters;
use crate::materials::tensor::{Principal, Symmetric, volume_change};
use crate::materials::{DefaultValue, Elastic, Form, Law, POISSON, ParameterRow, SolidLawResult};
use crumple_math::lanes::Real;
use crumple_proto::partition::Material;

const KEY: &str = "terms";

/// The row of this law.
pub const LAW: Law = Law {
    name: "ogden",
    meaning: "Rubber of Ogden.",
    constants: &[POISSON],
    parameters: &[ParameterRow {
        key: KEY,
        form: Form::List("[[mu, alpha], ...]"),
        otherwise: DefaultValue::Needed,
        range: None,
        meaning: "Terms of the strain energy: a modulus and an exponent each; the shear modulus is \
                  half the sum of mu alpha [force/length^2].",
    }],
    build: None,
    solid: Some(solid),
    cohesive: None,
};

struct Ogden {
    elastic: Elastic,
    /// mu and alpha.
    terms: Vec<[f64; 2]>,
    bulk: f64,
}

fn solid(material: &Material) -> SolidLawResult {
    let mut parameters = Parameters::new(material);
    let density = parameters.density();
    let nu = poisson(&mut parameters);
    let terms = parameters.rows::<2>(KEY, "[mu, alpha]");
    if terms.is_none() {
        parameters.wrong(KEY, "is missing", "give [[mu, alpha], ...]");
    }
    let terms = terms.unwrap_or_default();
    if terms.iter().any(|term| term[0] * term[1] <= 0.0) {
        let help = "give mu and alpha of the same sign, both not 0: other terms can be unstable";
        parameters.wrong(KEY, "has a term whose mu alpha is not above 0", help);
    }
    let shear = 0.5 * terms.iter().map(|[mu, alpha]| mu * alpha).sum::<f64>();
    if !terms.is_empty() {
        check_shear(&mut parameters, KEY, shear);
    }
    let elastic = elastic_of_shear(shear, nu, density);
    parameters.finish()?;
    Ok(Box::new(Rubber(Ogden { elastic, terms, bulk: elastic.bulk_modulus() })))
}

/// Principal directions, J and the isochoric squares of the stretches.
struct Stretches<R> {
    principal: Principal<R>,
    volume: R,
    squares: [R; 3],
}

impl<R: Real> Stretches<R> {
    #[inline(always)]
    fn new(b: &Symmetric<R>) -> Self {
        let one = R::splat(1.0);
        let all = R::zero().le(R::zero());
        let third = one + volume_change(b);
        let scale = third.powf_where(-1.0 / 3.0, all);
        let principal = Principal::new(b);
        let squares = principal.values.map(|value| scale * (one + value));
        Self { principal, volume: third.sqrt(), squares }
    }

    /// Returns the isochoric stretches to the power `alpha`.
    #[inline(always)]
    fn powers(&self, alpha: f64) -> [R; 3] {
        let all = R::zero().le(R::zero());
        self.squares.map(|square| square.powf_where(0.5 * alpha, all))
    }
}

impl StrainEnergy for Ogden {
    fn elastic(&self) -> Elastic {
        self.elastic
    }

    /// `J sigma_i = sum_j mu_j (l_i^alpha_j - mean) + K (J - 1)`.
    #[inline(always)]
    fn stress<R: Real>(&self, b: &Symmetric<R>) -> Symmetric<R> {
        let stretches = Stretches::new(b);
        let mut sums = [R::zero(); 3];
        for &[mu, alpha] in &self.terms {
            let powers = stretches.powers(alpha);
            for (i, sum) in sums.iter_mut().enumerate() {
                let others = [powers[(i + 1) % 3], powers[(i + 2) % 3]];
                let apart = (powers[i] - others[0]) + (powers[i] - others[1]);
                *sum = R::splat(mu / 3.0).mul_add(apart, *sum);
            }
        }
        let volume = stretches.volume;
        let change = volume_change(b) / (volume + R::splat(1.0));
        let values = sums.map(|sum| R::splat(self.bulk).mul_add(change, sum) / volume);
        stretches.principal.compose(values)
    }

    /// With `D = sum_j mu_j alpha_j diag(l_i^alpha_j)` and the deviatoric projection P the matrix
    /// is `P D P + K J` in all entries, and `P D P` is at most P times the largest entry of D.
    #[inline(always)]
    fn moduli<R: Real>(&self, b: &Symmetric<R>) -> [R; 2] {
        let stretches = Stretches::new(b);
        let mut sums = [R::zero(); 3];
        for &[mu, alpha] in &self.terms {
            for (sum, power) in sums.iter_mut().zip(stretches.powers(alpha)) {
                *sum = R::splat(mu * alpha).mul_add(power, *sum);
            }
        }
        let shear = Real::max(Real::max(sums[0], sums[1]), sums[2]) / stretches.volume;
        [shear, R::splat(1.0 / 3.0).neg_mul_add(shear, R::splat(self.bulk))]
    }
}
