//! Compressible rubber of Blatz and Ko (1962) for polyurethane:
//! ```text
//! sigma = G (B/J - J^(-1/(1 - 2 nu)) 1),   nu = 0.463
//! ```
//! It is the derivative of `W = G/2 (I - 3 + (J^(-2 beta) - 1)/beta)` with `beta = nu/(1 - 2 nu)`.
//! In uniaxial stress the lateral stretch is `lambda^-nu`, for any stretch.

use super::{Rubber, StrainEnergy, elastic_of_shear};
use crate::materials::parameters::Parameters;
use crate::materials::tensor::{Symmetric, largest_bound, volume_change};
use crate::materials::{DefaultValue, Elastic, Form, Law, ParameterRow, SolidLawResult};
use crumple_math::lanes::Real;
use crumple_proto::partition::Material;

/// Poisson's ratio of the law.
const NU: f64 = 0.463;
/// `nu/(1 - 2 nu)`.
const BETA: f64 = NU / (1.0 - 2.0 * NU);

/// The row of this law.
pub const LAW: Law = Law {
    name: "blatz_ko",
    meaning: "Compressible rubber of Blatz and Ko, with Poisson's ratio 0.463.",
    constants: &[],
    parameters: &[ParameterRow {
        key: "shear_modulus",
        form: Form::Number,
        otherwise: DefaultValue::Needed,
        range: None,
        meaning: "Shear modulus at small strain [force/length^2].",
    }],
    build: None,
    solid: Some(solid),
    cohesive: None,
};

struct BlatzKo {
    elastic: Elastic,
    shear: f64,
}

fn solid(material: &Material) -> SolidLawResult {
    let mut parameters = Parameters::new(material);
    let density = parameters.density();
    let shear = parameters.required("shear_modulus", "above 0", |g| g > 0.0);
    parameters.finish()?;
    Ok(Box::new(Rubber(BlatzKo { elastic: elastic_of_shear(shear, NU, density), shear })))
}

/// Returns `J^(-2 beta)`, exactly one without change of volume.
#[inline(always)]
fn power<R: Real>(third: R) -> R {
    let one = R::splat(1.0);
    let changed = (third - one).abs().gt(R::zero());
    third.powf_where(-BETA, changed)
}

impl StrainEnergy for BlatzKo {
    fn elastic(&self) -> Elastic {
        self.elastic
    }

    #[inline(always)]
    fn stress<R: Real>(&self, b: &Symmetric<R>) -> Symmetric<R> {
        let one = R::splat(1.0);
        let third = one + volume_change(b);
        let (per, direct) = (R::splat(self.shear) / third.sqrt(), one - power(third));
        std::array::from_fn(|c| per * if c < 3 { b[c] + direct } else { b[c] })
    }

    #[inline(always)]
    fn moduli<R: Real>(&self, b: &Symmetric<R>) -> [R; 2] {
        let one = R::splat(1.0);
        let third = one + volume_change(b);
        let per = R::splat(2.0 * self.shear) / third.sqrt();
        [per * (one + largest_bound(b)), per * R::splat(BETA) * power(third)]
    }
}
