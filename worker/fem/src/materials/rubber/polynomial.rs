//! Rubber with a strain energy in powers of the invariants (Rivlin & Saunders 1951), as in
//! `*MAT_HYPERELASTIC_RUBBER`:
//! ```text
//! W = sum c_pq (I1 - 3)^p (I2 - 3)^q + K/2 (J - 1)^2
//! K = 2 G (1 + nu) / (3 (1 - 2 nu)),   G = 2 (c10 + c01)
//! ```
//! with the invariants `I1 = I III^(-1/3)` and `I2 = II III^(-2/3)` of the isochoric part. Uniaxial
//! stress near nu = 1/2 is `2 (lambda^2 - 1/lambda) (dW/dI1 + dW/dI2 / lambda)`.

use super::{Rubber, StrainEnergy, check_shear, elastic_of_shear, poisson};
use crate::materials::parameters::Parameters;
use crate::materials::tensor::{
    Symmetric, deviator, inner, largest_bound, square, trace, volume_change,
};
use crate::materials::{DefaultValue, Elastic, Form, Law, POISSON, ParameterRow, SolidLawResult};
use crumple_math::lanes::Real;
use crumple_proto::partition::{Material, Param};

const KEY: &str = "coefficients";

/// The row of this law.
pub const LAW: Law = Law {
    name: "polynomial_rubber",
    meaning: "Rubber with a strain energy in powers of the invariants.",
    constants: &[POISSON],
    parameters: &[ParameterRow {
        key: KEY,
        form: Form::Numbers(6),
        otherwise: DefaultValue::Needed,
        range: None,
        meaning: "Coefficients c10, c01, c11, c20, c02, c30 of the strain energy; the shear \
                  modulus is 2 (c10 + c01) [force/length^2].",
    }],
    build: None,
    solid: Some(solid),
    cohesive: None,
};

struct Polynomial {
    elastic: Elastic,
    c: [f64; 6],
    bulk: f64,
}

fn solid(material: &Material) -> SolidLawResult {
    let mut parameters = Parameters::new(material);
    let density = parameters.density();
    let nu = poisson(&mut parameters);
    let c: Option<[f64; 6]> = match parameters.get(KEY) {
        Some(Param::List(list)) => list.as_slice().try_into().ok(),
        _ => None,
    };
    let c = c.filter(|c| c.iter().all(|c| c.is_finite())).unwrap_or_else(|| {
        let help = "give c10, c01, c11, c20, c02 and c30; 0 for a term that is not there";
        parameters.wrong(KEY, "is not a list of six numbers", help);
        [1.0; 6]
    });
    let shear = 2.0 * (c[0] + c[1]);
    check_shear(&mut parameters, KEY, shear);
    if shear > 0.0
        && let Some(stretch) = first_reversal(&c)
    {
        let what = format!("pushes back the wrong way at a stretch of {stretch:.2}");
        let help = "the stress of incompressible rubber, uniaxial and in two directions, has to \
                    keep the sign of the strain from a stretch of 0.5 to 2";
        parameters.wrong(KEY, what, help);
    }
    let elastic = elastic_of_shear(shear, nu, density);
    parameters.finish()?;
    Ok(Box::new(Rubber(Polynomial { elastic, c, bulk: elastic.bulk_modulus() })))
}

/// Returns the first stretch from 0.5 to 2 at which the uniaxial stress, or an equal one in two
/// directions, of incompressible rubber does not have the sign of the strain.
fn first_reversal(&[c10, c01, c11, c20, c02, c30]: &[f64; 6]) -> Option<f64> {
    let keeps = |first: f64, second: f64, factor: f64| {
        let (x, y) = (first - 3.0, second - 3.0);
        let w1 = c10 + c11 * y + 2.0 * c20 * x + 3.0 * c30 * x * x;
        w1 + (c01 + c11 * x + 2.0 * c02 * y) * factor > 0.0
    };
    (50..=200).map(|percent| 0.01 * f64::from(percent)).find(|&l| {
        let [one, other] = [l * l + 2.0 / l, 2.0 * l + l.powi(-2)];
        let biaxial = [2.0 * l * l + l.powi(-4), l.powi(4) + 2.0 * l.powi(-2)];
        !keeps(one, other, 1.0 / l) || !keeps(biaxial[0], biaxial[1], l * l)
    })
}

/// The isochoric invariants and the derivatives of the energy by them.
struct Invariants<R> {
    /// J, and `J^(-2/3)`.
    volume: R,
    scale: R,
    /// Invariants minus 3.
    first: R,
    second: R,
    /// Derivatives of W by them.
    w1: R,
    w2: R,
}

impl Polynomial {
    #[inline(always)]
    fn invariants<R: Real>(&self, b: &Symmetric<R>) -> Invariants<R> {
        let [c10, c01, c11, c20, c02, c30] = self.c.map(R::splat);
        let (one, two, three) = (R::splat(1.0), R::splat(2.0), R::splat(3.0));
        let all = R::zero().le(R::zero());
        let x = volume_change(b);
        let scale = (one + x).powf_where(-1.0 / 3.0, all);
        let i = trace(b);
        // II = 3 + 2 tr b + (tr b^2 - b:b)/2.
        let ii = two.mul_add(i, R::splat(0.5) * i.mul_add(i, -inner(b, b)));
        let rest = scale - one;
        let first = scale.mul_add(i, three * rest);
        let second = (scale * scale).mul_add(ii, three * rest * (scale + one));
        let w1 = c10 + c11 * second + two * c20 * first + three * c30 * first * first;
        let w2 = c01 + c11 * first + two * c02 * second;
        Invariants { volume: (one + x).sqrt(), scale, first, second, w1, w2 }
    }
}

impl StrainEnergy for Polynomial {
    fn elastic(&self) -> Elastic {
        self.elastic
    }

    /// `J sigma = 2 dev((w1 + w2 I1) B - w2 B^2) + K J (J - 1) 1` with the isochoric B.
    #[inline(always)]
    fn stress<R: Real>(&self, b: &Symmetric<R>) -> Symmetric<R> {
        let Invariants { volume, scale, first, w1, w2, .. } = self.invariants(b);
        let (one, two) = (R::splat(1.0), R::splat(2.0));
        let (linear, squared) = (deviator(b), deviator(&square(b)));
        // dev B^2 = 2 dev b + dev b^2.
        let rest = w2 * scale * scale;
        let factor = scale.mul_add(w2.mul_add(first + R::splat(3.0), w1), -(rest + rest));
        let x = volume_change(b);
        let mean = R::splat(self.bulk) * (x / (volume + one));
        std::array::from_fn(|c| {
            let s = two * rest.neg_mul_add(squared[c], factor * linear[c]) / volume;
            if c < 3 { s + mean } else { s }
        })
    }

    /// The part of the isochoric invariants acts on deviators only, as in `ogden`.
    #[inline(always)]
    fn moduli<R: Real>(&self, b: &Symmetric<R>) -> [R; 2] {
        let Invariants { volume, scale, first, second, w1, w2 } = self.invariants(b);
        let [_, _, c11, c20, c02, c30] = self.c.map(|c| R::splat(c.abs()));
        let (one, three) = (R::splat(1.0), R::splat(3.0));
        let (i1, i2) = (first + three, second + three);
        let two_thirds = R::splat(2.0 / 3.0);
        // Squares of the deviators of the isochoric B and of its inverse.
        let s = deviator(b);
        let of_b = scale * scale * inner(&s, &s);
        let of_inverse = Real::max(two_thirds * i2 * i2 - (i1 + i1), R::zero());
        let largest = scale * (one + largest_bound(b));
        let inverse = R::splat(1.0 / 3.0) * i2 + (two_thirds * of_inverse).sqrt();
        let linear = w1.abs() * largest + w2.abs() * inverse;
        let second_order = (c20 + three * c30 * first) * of_b
            + c02 * of_inverse
            + c11 * (of_b * of_inverse).sqrt();
        let shear = (R::splat(4.0) * linear + R::splat(8.0) * second_order) / volume;
        // d(J (J - 1))/d ln J = J (2 J - 1).
        let volumetric = R::splat(self.bulk) * Real::max(volume + volume - one, R::zero());
        [shear, R::splat(1.0 / 3.0).neg_mul_add(shear, volumetric)]
    }
}
