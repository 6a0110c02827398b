//! Bounds of stabilising forces in plastic shells, and drilling. They act in the modes that the
//! integration points do not see.
//!
//! A square of side a and flow stress sig is fully plastic in the modes of the stabilising forces
//! at
//! ```text
//! membrane Q_m = sig t a/4,   bending Q_b = Q_m t/4,   twist Q_t = sig t^2/(2 sqrt 3)
//! drilling of a node Q_d = sig t^2 a/16
//! ```
//! (stress of one sign on either side of the middle; Q_t is twice the plastic twisting moment; Q_d
//! is a quarter of the plastic moment of a side). In a rectangle, a is the side across which the
//! strain of the mode varies; `belytschko_tsay` and drilling use the root of the area. Each
//! formulation limits its forces to fractions of these.

use super::quad::DRILLING as DRILLING_MODES;
use super::section::Section;
use crate::materials::PointReal;
use crumple_math::lanes::Real;

/// Largest drilling moment of a node in a plastic part, as a fraction of its capacity.
const DRILLING_BOUND: f64 = 0.01;
/// 8/sqrt 3: Q_t over `sig t^2/16`.
const TWIST: f64 = 4.618_802_153_517_006;

/// Mode of a stabilising force.
#[derive(Clone, Copy, PartialEq)]
pub enum Mode {
    /// Rates of gam vx and gam vy.
    Membrane,
    /// Rates of gam tx and gam ty.
    Bending,
    /// Rate of gam vz.
    Twist,
}

/// Bounds of the `M` stabilising forces and of the drilling moments of a formulation.
pub struct Bounds<const M: usize> {
    /// Mode of each stabilising force.
    pub modes: [Mode; M],
    /// Largest stabilising force as a fraction of the capacity in its mode.
    pub strength: f64,
}

/// Bounds of a formulation that limits its drilling moments alone.
pub const DRILLING: Bounds<0> = Bounds { modes: [], strength: 0.0 };

impl Mode {
    /// Returns the force of a fully plastic element in this mode [force or force length] from flow
    /// stress [force/length^2], thickness [length] and the square of its side [length^2].
    #[inline(always)]
    fn capacity<R: Real>(self, flow_stress: R, thickness: R, side2: R) -> R {
        let quarter = R::splat(0.25) * thickness;
        let per_length = quarter * flow_stress;
        match self {
            Self::Membrane => per_length * side2.sqrt(),
            Self::Bending => quarter * (per_length * side2.sqrt()),
            Self::Twist => R::splat(TWIST) * quarter * per_length,
        }
    }

    /// Returns the square of [`Self::capacity`], which needs no root.
    #[inline(always)]
    fn capacity_squared<R: Real>(self, flow_stress: f64, thickness: R, side2: R) -> R {
        let quarter = R::splat(0.25) * thickness;
        let per_length = R::splat(flow_stress) * quarter;
        let (quarter2, per_length2) = (quarter * quarter, per_length * per_length);
        match self {
            Self::Membrane => per_length2 * side2,
            Self::Bending => quarter2 * (per_length2 * side2),
            Self::Twist => R::splat(TWIST * TWIST) * quarter2 * per_length2,
        }
    }
}

/// Mode whose capacity is that of a node about the normal.
const OF_DRILLING: Mode = Mode::Bending;

impl<const M: usize> Bounds<M> {
    /// Limits stabilising forces and drilling moments of plastic elements, and returns by how much
    /// that changes their work on the `increments` [energy]. `columns` are those of the section,
    /// `sides2` the squares of the sides for each mode and for drilling [length^2]. Flow stress and
    /// roots are computed only in groups with an element that is beyond its capacity at the initial
    /// yield stress, which is the least flow stress.
    #[inline(always)]
    pub fn apply<R: PointReal, const N: usize>(
        &self,
        (section, columns): (&Section, &[R]),
        (stabilising, drill): (&mut [R], &mut [R]),
        increments: (&[R], &[R]),
        thickness: R,
        sides2: ([R; M], R),
    ) -> R {
        let Some(yield_stress) = section.least_flow_stress() else { return R::zero() };
        let exceeds = |force: R, mode: Mode, side2: R, fraction: f64| {
            let square = mode.capacity_squared(yield_stress, thickness, side2);
            (force * force).gt(R::splat(fraction * fraction) * square)
        };
        let mut moment = drill[0].abs();
        for other in &drill[1..DRILLING_MODES] {
            moment = Real::max(moment, other.abs());
        }
        let mut beyond = exceeds(moment, OF_DRILLING, sides2.1, DRILLING_BOUND);
        for ((&force, &mode), side2) in stabilising[..M].iter().zip(&self.modes).zip(sides2.0) {
            beyond = R::either(beyond, exceeds(force, mode, side2, self.strength));
        }
        if !R::any(beyond) {
            return R::zero();
        }
        let flow_stress = section.flow_stress::<R, N>(columns, yield_stress);
        self.limit((stabilising, drill), increments, (flow_stress, thickness, sides2), beyond)
    }

    /// Limits the forces of the lanes `beyond` and returns by how much that changes their work on
    /// the increments [energy]. The other lanes keep their bits, so that an element does not depend
    /// on its neighbours in a group.
    #[expect(clippy::needless_range_loop, reason = "in a cold function zip is not inlined")]
    #[cfg_attr(target_arch = "nvptx64", inline(always))]
    #[cfg_attr(not(target_arch = "nvptx64"), cold, inline(never))]
    fn limit<R: Real>(
        &self,
        (stabilising, drill): (&mut [R], &mut [R]),
        increments: (&[R], &[R]),
        (flow_stress, thickness, sides2): (R, R, ([R; M], R)),
        beyond: R::Mask,
    ) -> R {
        let mut lost = R::zero();
        let mut limit = |force: &mut R, bound: R, increment: R| {
            let within = Real::max(Real::min(*force, bound), -bound);
            let new = R::select(beyond, within, *force);
            lost = (new - *force).mul_add(increment, lost);
            *force = new;
        };
        for c in 0..M {
            let capacity = self.modes[c].capacity(flow_stress, thickness, sides2.0[c]);
            limit(&mut stabilising[c], R::splat(self.strength) * capacity, increments.0[c]);
        }
        let capacity = OF_DRILLING.capacity(flow_stress, thickness, sides2.1);
        for c in 0..DRILLING_MODES {
            limit(&mut drill[c], R::splat(DRILLING_BOUND) * capacity, increments.1[c]);
        }
        lost
    }
}

/// Updates the drilling moments by the increments `ahead` of the drilling modes. Returns `energy`
/// plus the work of old and new moments, which is twice that of the step.
#[inline(always)]
pub fn drill<R: Real>(moments: &mut [R], stiff: R, ahead: &[R], energy: R) -> R {
    let mut energy = energy;
    for c in 0..ahead.len() {
        // The first two modes have the weight one half, the other two one quarter.
        let stiff = if c < 2 { stiff } else { R::splat(0.5) * stiff };
        let old = moments[c];
        let new = stiff.mul_add(ahead[c], old);
        moments[c] = new;
        energy = (old + new).mul_add(ahead[c], energy);
    }
    energy
}

/// Returns the coefficient of [`drill`] for a stiffness of `alpha G t A/4` per node.
#[inline(always)]
pub fn drilling_stiffness<R: Real>(section: &Section, alpha: f64, thickness: R, area: R) -> R {
    R::splat(0.125 * alpha * section.stabilising.shear_modulus()) * thickness * area
}
