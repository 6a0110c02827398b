//! What holds shells of a plastic part in the modes that its points do not see: bounds of
//! stabilising forces, and drilling.
//!
//! A square of side a, of flow stress sig, is plastic through and through in the modes of the
//! stabilising forces at
//! ```text
//! membrane Q_m = sig t a/4,   bending Q_b = Q_m t/4,   drilling of a node Q_d = sig t^2 a/16
//! ```
//! (stress of one sign on either side of the middle; Q_d is a quarter of the plastic moment of a
//! side). Formulations say which fractions of these they bear at most.

use super::quad::DRILLING;
use super::section::Section;
use crate::math::lanes::Real;

/// Drilling moments of a node in a plastic part, at most, as a fraction of [`Capacity::drilling`].
const DRILLING_BOUND: f64 = 0.01;

/// What a plastic element bears in the modes of stabilising forces.
pub struct Capacity<R> {
    /// On the rates of gam vx and gam vy [force].
    pub membrane: R,
    /// On those of gam tx and gam ty [force length].
    pub bending: R,
    /// Of a node about the normal [force length].
    pub drilling: R,
}

impl<R: Real> Capacity<R> {
    /// By flow stress [force/length^2], thickness and area.
    #[inline(always)]
    pub fn new(flow_stress: R, thickness: R, area: R) -> Self {
        let membrane = R::splat(0.25) * flow_stress * thickness * area.sqrt();
        let bending = R::splat(0.25) * thickness * membrane;
        Self { membrane, bending, drilling: bending }
    }
}

/// The value, or the bound with its sign.
#[inline(always)]
pub fn bounded<R: Real>(value: R, bound: R) -> R {
    Real::max(Real::min(value, bound), -bound)
}

/// Brings the drilling moments up to date, bounded in plastic parts; gives twice the energy, on top
/// of `energy`.
#[inline(always)]
pub fn drill<R: Real>(
    moments: &mut [R],
    stiff: R,
    ahead: [R; DRILLING],
    capacity: Option<&Capacity<R>>,
    energy: R,
) -> R {
    let bound = capacity.map(|capacity| R::splat(DRILLING_BOUND) * capacity.drilling);
    let mut energy = energy;
    for c in 0..DRILLING {
        let old = moments[c];
        // Modes weigh one half and one quarter.
        let new = (if c < 2 { stiff } else { R::splat(0.5) * stiff }).mul_add(ahead[c], old);
        let new = bound.map_or(new, |bound| bounded(new, bound));
        moments[c] = new;
        energy = (old + new).mul_add(ahead[c], energy);
    }
    energy
}

/// Coefficient of [`drill`], for a stiffness of `alpha G t A/4` a node.
#[inline(always)]
pub fn drilling_stiffness<R: Real>(section: &Section, alpha: f64, thickness: R, area: R) -> R {
    R::splat(0.125 * alpha * section.elastic.shear_modulus()) * thickness * area
}
