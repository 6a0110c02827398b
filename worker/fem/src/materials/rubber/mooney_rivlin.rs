//! Rubber of Mooney and Rivlin (Mooney 1940, Rivlin 1948), in the compressible form of DYNA3D:
//! ```text
//! W = a (I - 3) + b (II - 3) + c (III^-2 - 1) + d (III - 1)^2
//! c = a/2 + b,   d = (a (5 nu - 2) + b (11 nu - 5)) / (2 (1 - 2 nu))
//! ```
//! with the invariants I, II, III of the Cauchy-Green tensor. The shear modulus at small strain is
//! `2 (a + b)`. Near nu = 1/2 uniaxial stress is `2 (lambda^2 - 1/lambda) (a + b/lambda)`.
//!
//! d must not be negative, that is nu at least `(2 a + 5 b)/(5 a + 11 b)`: tension on all sides
//! would end in pressure. Shells have it in plane stress, see `membrane`.

use super::membrane::MooneyRivlinShell;
use super::{Rubber, StrainEnergy, check_shear, elastic_of_shear, poisson};
use crate::materials::parameters::Parameters;
use crate::materials::tensor::{
    Symmetric, deviator, inner, largest_bound, square, trace, volume_change,
};
use crate::materials::{
    DefaultValue, Elastic, Form, Law, LawResult, POISSON, ParameterRow, SolidLawResult,
};
use crumple_math::lanes::Real;
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law {
    name: "mooney_rivlin",
    meaning: "Rubber of Mooney and Rivlin.",
    constants: &[POISSON],
    parameters: PARAMETERS,
    build: Some(shell),
    solid: Some(solid),
    cohesive: None,
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
    Ok(Box::new(Rubber(read(material)?)))
}

fn shell(material: &Material) -> LawResult {
    let MooneyRivlin { elastic, a, b, d } = read(material)?;
    Ok(Box::new(MooneyRivlinShell { elastic, a, b, d }))
}

fn read(material: &Material) -> Result<MooneyRivlin, Vec<Problem>> {
    let mut parameters = Parameters::new(material);
    let density = parameters.density();
    let nu = poisson(&mut parameters);
    let a = parameters.required("a", "0 or above", |a| a >= 0.0);
    let b = parameters.required("b", "0 or above", |b| b >= 0.0);
    check_shear(&mut parameters, "a", 2.0 * (a + b));
    let d = (a * (5.0 * nu - 2.0) + b * (11.0 * nu - 5.0)) / (2.0 * (1.0 - 2.0 * nu));
    if d < 0.0 {
        let least = (2.0 * a + 5.0 * b) / (5.0 * a + 11.0 * b);
        let what = format!(
            "is {nu}: with these a and b the rubber resists tension on all sides \
                            with pressure"
        );
        parameters.wrong("poisson", what, format!("it has to be at least {least:.4}"));
    }
    let elastic = elastic_of_shear(2.0 * (a + b), nu, density);
    parameters.finish()?;
    Ok(MooneyRivlin { elastic, a, b, d })
}

impl StrainEnergy for MooneyRivlin {
    fn elastic(&self) -> Elastic {
        self.elastic
    }

    /// `J sigma/2 = (a + b I) B - b B^2 + (2 d (III - 1) III - 2 c III^-2) 1`, written with b such
    /// that all terms vanish with it.
    #[inline(always)]
    fn stress<R: Real>(&self, tensor: &Symmetric<R>) -> Symmetric<R> {
        let [a, b, d] = [self.a, self.b, self.d].map(R::splat);
        let one = R::splat(1.0);
        let (first, x) = (trace(tensor), volume_change(tensor));
        let third = one + x;
        let ratio = x * (one + third) / (third * third);
        let volumetric = (d + d).mul_add(x * third, (a + b + b) * ratio);
        let direct = b.mul_add(first, volumetric);
        let factor = b.mul_add(one + first, a);
        let squared = square(tensor);
        let per = R::splat(2.0) / third.sqrt();
        std::array::from_fn(|c| {
            let shear = b.neg_mul_add(squared[c], factor * tensor[c]);
            per * if c < 3 { shear + direct } else { shear }
        })
    }

    /// The matrix is `4 (a B_i + b B_i (I - B_i))` in the diagonal, `4 b B_i B_j` elsewhere, and
    /// the volumetric term in all entries. The products of two principal values are those of the
    /// cofactor of B; V takes the largest of them, and S what is left.
    #[inline(always)]
    fn moduli<R: Real>(&self, tensor: &Symmetric<R>) -> [R; 2] {
        let (one, four) = (R::splat(1.0), R::splat(4.0));
        let [a, b] = [self.a, self.b].map(R::splat);
        let first = trace(tensor);
        let third = one + volume_change(tensor);
        // B (a + b (I - B)) grows up to its vertex.
        let factor = b.mul_add(first + R::splat(3.0), a);
        let vertex = factor / Real::max(b + b, R::splat(R::SMALLEST));
        let most = Real::min(one + largest_bound(tensor), vertex);
        let diagonal = most * b.neg_mul_add(most, factor);
        // The cofactor is II 1 - I B + B^2.
        let squared = square(tensor);
        let cofactor =
            deviator(&std::array::from_fn(|c| (one + first).neg_mul_add(tensor[c], squared[c])));
        let apart = (R::splat(2.0 / 3.0) * inner(&cofactor, &cofactor)).sqrt();
        let half = R::splat(0.5) * first.mul_add(first, -inner(tensor, tensor));
        let mean = one + R::splat(1.0 / 3.0) * (first + first + half);
        let rest = b.neg_mul_add(mean + apart, diagonal) + four * b * apart;
        // 4 III times the derivative of the volumetric term.
        let stiff = R::splat(2.0 * self.d) * (third + third - one) * third;
        let soft = R::splat(2.0 * (self.a + 2.0 * self.b)) / (third * third);
        let volumetric = four * (Real::max(stiff + soft, R::zero()) + b * (mean + apart));
        let per = one / third.sqrt();
        [per * four * rest, per * volumetric]
    }
}
