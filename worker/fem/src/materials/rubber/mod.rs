//! Rubbers in three dimensions: the stress follows from the left Cauchy-Green tensor B, by the
//! derivative of a strain energy. One file for each energy.
//!
//! The history holds `b = B - 1` and rotates with the stress. [`tensor::stretch`](super::tensor)
//! advances it by the strain increment, so that the stress depends on the deformation alone, up to
//! the second order of the step where the body rotates. Elements compute in double precision: in
//! single precision the sum of many steps has a wrong volume. The step follows the stiffening of
//! the rubber.

pub mod blatz_ko;
mod by_rate;
mod membrane;
pub mod mooney_rivlin;
pub mod ogden;
pub mod polynomial;
pub mod tabulated;
mod test_curve;

use super::parameters::Parameters;
use super::tensor::{Symmetric, deviator, inner, stretch, trace};
use super::{Elastic, STRETCH_COLUMN, Solid, SolidPoint};
use crumple_math::lanes::{Lane, Lane32, Real};

const HISTORY: &[&str] =
    &[STRETCH_COLUMN, "B-1 yy", "B-1 zz", "B-1 xy", "B-1 yz", "B-1 zx", "stiffening"];

/// A strain energy.
trait StrainEnergy: Send + Sync {
    /// Returns the elastic constants at small strain.
    fn elastic(&self) -> Elastic;

    /// Returns the Cauchy stress [force/length^2]. It is zero, bit for bit, if b is zero.
    fn stress<R: Real>(&self, b: &Symmetric<R>) -> Symmetric<R>;

    /// Returns S and V of the bound `S 1 + V (1, 1, 1) (1, 1, 1)'` of the matrix
    /// `d(J sigma_i)/d(ln lambda_j)/J` [force/length^2]. At small strain they are 2 G and lambda.
    fn moduli<R: Real>(&self, b: &Symmetric<R>) -> [R; 2];
}

/// The law of a strain energy.
struct Rubber<W>(W);

impl<W: StrainEnergy> Rubber<W> {
    #[inline(always)]
    fn solid<R: Real>(&self, point: SolidPoint<'_, R>) -> R {
        let state = point.state;
        let b = stretch(&std::array::from_fn(|c| state[6 + c]), point.strain);
        let stress = self.0.stress(&b);
        let ratio = stiffening(&self.0.elastic(), &stress, self.0.moduli(&b));
        state[..6].copy_from_slice(&stress);
        state[6..12].copy_from_slice(&b);
        // Rounding does not stiffen a point without strain.
        let strained = inner(&b, &b).gt(R::zero());
        state[12] = R::select(strained, Real::max(ratio, R::zero()), R::zero());
        R::splat(1.0)
    }
}

/// Returns the modulus of the step over that at the start, less one, with the bound of
/// [`StrainEnergy::moduli`].
#[inline(always)]
fn stiffening<R: Real>(elastic: &Elastic, stress: &Symmetric<R>, moduli: [R; 2]) -> R {
    // Waves along a principal axis have the modulus minus the stress there.
    let s = deviator(stress);
    let least = (R::splat(2.0 / 3.0) * inner(&s, &s))
        .sqrt()
        .neg_mul_add(R::splat(1.0), R::splat(1.0 / 3.0) * trace(stress));
    let [shear, volumetric] = moduli;
    let shear = shear + Real::max(-least, R::zero());
    // An element has `2 G g + lambda tr G` with g from `tr G/3` to `tr G`: both ends count.
    let over = |share: f64| {
        let first = share * 2.0 * elastic.shear_modulus() + elastic.lame();
        R::splat(1.0 / first) * R::splat(share).mul_add(shear, volumetric) - R::splat(1.0)
    };
    Real::max(over(1.0), over(1.0 / 3.0))
}

impl<W: StrainEnergy> Solid for Rubber<W> {
    fn history(&self) -> &'static [&'static str] {
        HISTORY
    }
    fn tensors(&self) -> usize {
        1
    }
    fn elastic(&self) -> Elastic {
        self.0.elastic()
    }
    fn update(&self, point: SolidPoint<'_, Lane>, _dt: f64) -> Lane {
        self.solid(point)
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, _dt: f64) -> Lane32 {
        self.solid(point)
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, _dt: f64) -> f64 {
        self.solid(point)
    }
}

/// Returns the elastic constants of a shear modulus [force/length^2] and Poisson's ratio.
fn elastic_of_shear(shear: f64, poisson: f64, density: f64) -> Elastic {
    Elastic { youngs_modulus: 2.0 * shear * (1.0 + poisson), poisson, density }
}

/// Reads Poisson's ratio of a rubber.
fn poisson(parameters: &mut Parameters<'_>) -> f64 {
    let wanted = "from 0 and below 0.5, as 0.495";
    parameters.required("poisson", wanted, |nu| (0.0..0.5).contains(&nu))
}

/// Records a problem if the shear modulus of some keys is not above 0.
fn check_shear(parameters: &mut Parameters<'_>, key: &str, shear: f64) {
    if shear.is_nan() || shear <= 0.0 {
        let what = format!("gives the shear modulus {shear} at small strain");
        parameters.wrong(key, what, "it has to be above 0");
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
