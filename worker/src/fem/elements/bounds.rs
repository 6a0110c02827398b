//! Bounds of stabilising forces in plastic shells, and drilling. They act in the modes that the
//! integration points do not see.
//!
//! A square of side a and flow stress sig is fully plastic in the modes of the stabilising forces
//! at
//! ```text
//! membrane Q_m = sig t a/4,   bending Q_b = Q_m t/4,   drilling of a node Q_d = sig t^2 a/16
//! ```
//! (stress of one sign on either side of the middle; Q_d is a quarter of the plastic moment of a
//! side). Each formulation limits its forces to fractions of these.

use super::quad::DRILLING;
use super::section::Section;
use crate::math::lanes::Real;

/// Largest drilling moment of a node in a plastic part, as a fraction of [`Capacity::drilling`].
const DRILLING_BOUND: f64 = 0.01;

/// Limit forces of a fully plastic element in the modes of stabilising forces.
pub struct Capacity<R> {
    /// Limit on the rates of gam vx and gam vy [force].
    pub membrane: R,
    /// Limit on the rates of gam tx and gam ty [force length].
    pub bending: R,
    /// Limit of a node about the normal [force length].
    pub drilling: R,
}

impl<R: Real> Capacity<R> {
    /// Computes the capacity from flow stress [force/length^2], thickness [length] and area
    /// [length^2].
    #[inline(always)]
    pub fn new(flow_stress: R, thickness: R, area: R) -> Self {
        let membrane = R::splat(0.25) * flow_stress * thickness * area.sqrt();
        let bending = R::splat(0.25) * thickness * membrane;
        Self { membrane, bending, drilling: bending }
    }
}

/// Returns the value, or the bound with the sign of the value if that is smaller in magnitude.
#[inline(always)]
pub fn bounded<R: Real>(value: R, bound: R) -> R {
    Real::max(Real::min(value, bound), -bound)
}

/// Updates the drilling moments, bounded in plastic parts; returns `energy` plus twice their
/// energy.
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
        // The first two modes have the weight one half, the other two one quarter.
        let new = (if c < 2 { stiff } else { R::splat(0.5) * stiff }).mul_add(ahead[c], old);
        let new = bound.map_or(new, |bound| bounded(new, bound));
        moments[c] = new;
        energy = (old + new).mul_add(ahead[c], energy);
    }
    energy
}

/// Returns the coefficient of [`drill`] for a stiffness of `alpha G t A/4` per node.
#[inline(always)]
pub fn drilling_stiffness<R: Real>(section: &Section, alpha: f64, thickness: R, area: R) -> R {
    R::splat(0.125 * alpha * section.elastic.shear_modulus()) * thickness * area
}
