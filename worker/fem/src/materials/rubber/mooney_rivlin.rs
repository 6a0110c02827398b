//! Rubber of Mooney and Rivlin (Mooney 1940, Rivlin 1948), in the compressible form of DYNA3D:
//! ```text
//! W = a (I - 3) + b (II - 3) + c (III^-2 - 1) + d (III - 1)^2
//! c = a/2 + b,   d = (a (5 nu - 2) + b (11 nu - 5)) / (2 (1 - 2 nu))
//! ```
//! with the invariants I, II, III of the Cauchy-Green tensor. The shear modulus at small strain is
//! `2 (a + b)`. Near nu = 1/2 uniaxial stress is `2 (lambda^2 - 1/lambda) (a + b/lambda)`.

use super::{Rubber, StrainEnergy, check_shear, elastic_of_shear, poisson};
use crate::materials::parameters::Parameters;
use crate::materials::tensor::{Symmetric, largest_bound, square, trace, volume_change};
use crate::materials::{DefaultValue, Elastic, Form, Law, POISSON, ParameterRow, SolidLawResult};
use crumple_math::lanes::Real;
use crumple_proto::partition::Material;

/// The row of this law.
pub const LAW: Law = Law {
    name: "mooney_rivlin",
    meaning: "Rubber of Mooney and Rivlin.",
    constants: &[POISSON],
    parameters: PARAMETERS,
    build: None,
    solid,
};

const PARAMETERS: &[ParameterRow] = &[
    ParameterRow {
        key: "a",
        form: Form::Number,
        otherwise: DefaultValue::Needed,
        range: None,
        meaning: "Constant of the first invariant; the shear modulus is 2 (a + b) \
                  [force/length^2].",
    },
    ParameterRow {
        key: "b",
        form: Form::Number,
        otherwise: DefaultValue::Needed,
        range: None,
        meaning: "Constant of the second invariant [force/length^2].",
    },
];

struct MooneyRivlin {
    elastic: Elastic,
    a: f64,
    b: f64,
    /// d [force/length^2].
    d: f64,
}

fn solid(material: &Material) -> SolidLawResult {
    let mut parameters = Parameters::new(material);
    let density = parameters.density();
    let nu = poisson(&mut parameters);
    let a = parameters.required("a", "0 or above", |a| a >= 0.0);
    let b = parameters.required("b", "0 or above", |b| b >= 0.0);
    check_shear(&mut parameters, "a", 2.0 * (a + b));
    let d = (a * (5.0 * nu - 2.0) + b * (11.0 * nu - 5.0)) / (2.0 * (1.0 - 2.0 * nu));
    let elastic = elastic_of_shear(2.0 * (a + b), nu, density);
    parameters.finish()?;
    Ok(Box::new(Rubber(MooneyRivlin { elastic, a, b, d })))
}

impl StrainEnergy for MooneyRivlin {
    fn elastic(&self) -> Elastic {
        self.elastic
    }

    /// `J sigma/2 = (a + b I) B - b B^2 + (2 d (III - 1) III - 2 c III^-2) 1`, written with b such
    /// that all terms vanish with it.
    #[inline(always)]
    fn stress<R: Real>(&self, green: &Symmetric<R>) -> Symmetric<R> {
        let [a, b, d] = [self.a, self.b, self.d].map(R::splat);
        let one = R::splat(1.0);
        let (first, x) = (trace(green), volume_change(green));
        let third = one + x;
        let ratio = x * (one + third) / (third * third);
        let volumetric = (d + d).mul_add(x * third, (a + b + b) * ratio);
        let direct = b.mul_add(first, volumetric);
        let factor = b.mul_add(one + first, a);
        let squared = square(green);
        let per = R::splat(2.0) / third.sqrt();
        std::array::from_fn(|c| {
            let shear = b.neg_mul_add(squared[c], factor * green[c]);
            per * if c < 3 { shear + direct } else { shear }
        })
    }

    #[inline(always)]
    fn modulus<R: Real>(&self, green: &Symmetric<R>) -> R {
        let one = R::splat(1.0);
        let third = one + volume_change(green);
        let (largest, rest) = (one + largest_bound(green), trace(green) + R::splat(3.0));
        let shear = R::splat(self.b).mul_add(rest - largest, R::splat(self.a)) * largest;
        // 4 III times the derivative of the volumetric term.
        let stiff = R::splat(2.0 * self.d) * (third + third - one) * third;
        let soft = R::splat(2.0 * (self.a + 2.0 * self.b)) / (third * third);
        let volumetric = R::splat(4.0) * (stiff + soft);
        (R::splat(4.0) * shear + Real::max(volumetric, R::zero())) / third.sqrt()
    }
}
