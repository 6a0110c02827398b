//! Stable step of shells with a section: present area and thickness, rotational inertia, offset.

use super::{INERTIA, Section, VOLUME};
use crumple_math::lanes::Real;
use crumple_proto::mesh::OwnSection;

/// Relative change of mass per area that counts as round-off in single precision. A smaller change
/// is ignored, so that an element in rigid motion keeps its stable step exactly.
const ROUND_OFF: f64 = 4e-6;

/// Quantities of the present shape of a shell that determine its stable step. The squared frequency
/// of its shear is `5/6 G/rho (corners s + (1 + taper s)/I)`, with I the rotational inertia per
/// mass and s the larger principal value of `sum b_I b_I'` of the gradient [1/length^2].
pub struct StepQuantities<R> {
    /// Area [length^2] and its reciprocal.
    pub area: R,
    pub inv_area: R,
    /// Square of the side for which the stable step of the membrane is that of the plate wave over
    /// the area by the side, at the density of the material [length^2].
    pub side2: R,
    /// Fraction of that step for which the element is stable.
    pub fraction: f64,
    /// Number of corners of the element.
    pub corners: f64,
    /// Smallest `s` of elements of any shape, times their area.
    pub least_s: f64,
    /// Coefficient of `s` in the frequency of shear [length^2].
    pub taper: R,
    /// Smallest I of an element of this shape at the start [length^2].
    pub floor: R,
}

impl Section {
    /// Returns the factor by which an offset shortens the stable step of an element at rest,
    /// because it couples the displacement of nodes to their rotation; `None` without an offset.
    /// For the middle surface `K <= omega^2 diag(m, m i)` for displacements and rotations, with i
    /// the rotational inertia about it per mass. For the nodes this becomes
    /// `K <= omega^2 m [1 e; e i + e^2]`, and `diag(m, m (i + e^2))` is at least `1/(1 + a)` of
    /// that matrix, `a = |e|/sqrt(i + e^2)`.
    #[inline(always)]
    pub fn offset_factor<R: Real>(&self, history: &[R]) -> Option<R> {
        if !self.has_offset() {
            return None;
        }
        let (arm, inertia, one) = (self.arm(history), history[INERTIA], R::splat(1.0));
        let ratio = R::select(inertia.gt(R::zero()), arm.abs() / inertia.sqrt(), R::zero());
        Some(one / (one + ratio).sqrt())
    }

    /// Returns [`Self::offset_factor`] of an element at the start.
    pub fn offset_factor_at_start(&self, own: OwnSection, floor: f64) -> f64 {
        let arm = self.arm_at_start(own);
        let ratio = arm.abs() / self.inertia_per_mass(own, floor).sqrt();
        if arm == 0.0 { 1.0 } else { 1.0 / (1.0 + ratio).sqrt() }
    }

    /// Returns the stable step [time]. An element keeps the mass of the start while its area A and
    /// its thickness t change, so the step of the membrane at the density of the material is
    /// multiplied by `sqrt(A0 t0 / (A t))`. It is smaller if the rotational inertia, which is also
    /// that of the start, has become too small for shear. Without [`Self::measure`] it is that of
    /// the membrane.
    #[inline(always)]
    pub fn stable_dt<R: Real>(&self, history: &[R], of: &StepQuantities<R>) -> R {
        if self.has_offset() {
            return self.stable_dt_with_offset(history, of);
        }
        self.stable_dt_at(history, of, history[INERTIA])
    }

    /// Returns [`Self::stable_dt`] for this rotational inertia about the middle surface per mass
    /// [length^2].
    #[inline(always)]
    fn stable_dt_at<R: Real>(&self, history: &[R], of: &StepQuantities<R>, inertia: R) -> R {
        let one = R::splat(1.0);
        // The squared frequency of shear goes with `corners s + (1 + taper s)/i`. If the inertia i
        // has become less than the floor f, it has risen by at most the factor
        // `(x + 1/i)/(x + 1/f)` with `x = corners s/(1 + taper s)`, which is largest for the least
        // possible s. All is brought to one denominator, as quotients are the most expensive
        // operations of the kernel.
        let s = R::splat(of.least_s) * of.inv_area;
        let (by_corners, spread) = (R::splat(of.corners) * s, of.taper.mul_add(s, one));
        let at = |inertia: R| by_corners.mul_add(inertia, spread);
        let borne = at(of.floor) * inertia;
        let needed = at(inertia) * of.floor;
        let first = R::splat(self.planar as f64) * history[VOLUME] * of.inv_area;
        let kept = first * Real::min(needed, borne);
        let present = self.thicknesses(history) * needed;
        let is_known = history[VOLUME].gt(R::zero());
        let changed = R::both(is_known, (kept - present).abs().gt(R::splat(ROUND_OFF) * present));
        let (kept, present) = (R::select(changed, kept, one), R::select(changed, present, one));
        self.membrane_step(of.area, kept / (of.side2 * present), of.fraction)
    }

    /// Returns the stable step of the membrane for an area [length^2] and the inverse square of a
    /// side [1/length^2] at the density of the material [time].
    #[inline(always)]
    pub fn membrane_step<R: Real>(&self, area: R, inv_side2: R, fraction: f64) -> R {
        area * inv_side2.sqrt() * R::splat(fraction / self.elastic.plate_wave_speed())
    }

    /// Returns [`Self::stable_dt`] of a section with an offset.
    #[cold]
    #[inline(never)]
    fn stable_dt_with_offset<R: Real>(&self, history: &[R], of: &StepQuantities<R>) -> R {
        let (one, known, arm) = (R::splat(1.0), history[INERTIA], self.arm(history));
        // Shear rotates the section about the middle surface. An inertia that is too small for
        // shear is replaced by a larger one; then more inertia is assumed than the nodes have.
        let arm2 = arm * arm;
        let inertia = Real::max(known - arm2, of.floor);
        let stable_dt = self.stable_dt_at(history, of, inertia);
        // The larger eigenvalue of `[1 e; e i + e^2]` over `diag(1, I)`, see `offset_factor`.
        let is_known = history[VOLUME].gt(R::zero());
        let [i, both] =
            [inertia, inertia + arm2].map(|of| R::select(is_known, of / known, R::zero()));
        let half_trace = R::splat(0.5) * (one + both);
        let root = Real::max(half_trace.mul_add(half_trace, R::zero() - i), R::zero()).sqrt();
        stable_dt / Real::max(half_trace + root, one).sqrt()
    }
}
