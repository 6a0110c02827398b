//! Hourglass resistance of the one-point hexahedron.
//!
//! `q_a = U_a - K X_a` (a = 4..7) are the hourglass modes of the displacement increment without its
//! linear field: `gamma_aI = Gamma_aI - X_a . B_I` on the corners (Flanagan & Belytschko 1981, eq.
//! 43), zero in every linear field of any hexahedron. Corner forces are
//! `sum over a of P_a gamma_aI`, whose power is `P_a . dq_a/dt`.
//!
//! - *Stiffness*: `dP = (kappa/16) M V (B_iI B_iI) dq`, where P rotates with the element and
//!   `M = min(lambda + 2 mu, 3.5 mu)`. The source has lambda + 2 mu, which is unbounded as nu
//!   approaches 1/2, while the modes do not change the volume to first order. With it a thick
//!   cylinder of three elements radially was 5 % too stiff at nu = 0.49 and kappa = 0.05, 36 % at
//!   0.499 (C12). Both are equal at nu = 0.3. Up to there a single mode on a cube of side L has the
//!   frequency `sqrt(6 kappa) c_d/L`.
//! - *Viscous*: `P = r/4 sqrt(k rho V) dq/dt` with k = dP/dq above at kappa = 1: r is the fraction
//!   of critical damping of the mode.
//! - *Assumed strain*, the default, after Belytschko & Bindeman 1993 (ASQBI): the hourglass modes
//!   give strains that are linear in xi, in eta and in zeta. With l_i, n_i the length and direction
//!   of X_i, a one of the three and (b, c) the others, and q_c the mode that has both xi_a and
//!   xi_b, the strains are `e_bb = q_c.n_b / l_b`, `e_cc = q_b.n_c / l_c`,
//!   `g_bc = q_c.n_c / l_b + q_b.n_b / l_c`, the stresses `dS_bb = E/(1-nu^2) (e_bb + nu e_cc)`,
//!   dS_cc likewise, `dS_bc = G g_bc`, and the energy is V/3 (S e). The shears ab and ac, which
//!   bending does not have, are left out, and the strain along a is such that it gives no stress
//!   along a: bending of bricks is exact and nothing locks at nu = 0.5. Mode 7 gives
//!   `e_i = q_7.n_i / l_i`, `dT_i = E e_i`, energy V/9 (T e). S and T are stored along the edges
//!   n_i, which rotate with the element. Skew of the element is left out of S, as in the source.
//!
//! Plastic flow scales P, S and T by the factor by which the return to the yield surface scales the
//! deviator of the mean stress, `f = |s|/|s of the elastic trial|`: `P <- f (P + dP)`. This is the
//! return of a small stress in addition to the mean one, except for its part along the flow, which
//! is reduced more. In steady flow P therefore tends to the force of a fluid of viscosity
//! `sig_y/(3 d eps_p/dt)`. Without f the elastic resistance grows far beyond yield: the foot of a
//! Taylor bar (B01, 8 cells on the radius, foot fixed to the wall) is 6 % too narrow with stiffness
//! at kappa = 0.05, and 0.6 % with f and assumed strain.

use super::modes::{Gradient, HOURGLASS_MODES, HexahedronModes};
use crate::elements::HourglassForm;
use crate::materials::Elastic;
use crumple_math::lanes::{Real, dot};

/// Number of history columns, in any form: P of the four modes [force], or nine S and three T
/// [force/length^2].
pub const COLUMNS: usize = 3 * HOURGLASS_MODES;

/// Form and coefficient of hourglass control of a part.
pub struct Hourglass {
    pub form: HourglassForm,
    /// kappa or r.
    pub coefficient: f64,
    /// Elastic constants of the modes: those of the law, or of a fluid those with which M is its
    /// bulk modulus.
    pub elastic: Elastic,
}

/// Data of a step that the hourglass modes use.
pub struct HourglassStep<'a, R> {
    /// Coordinates and mean gradient in the middle of the step.
    pub mid: &'a HexahedronModes<R>,
    pub mid_gradient: &'a Gradient<R>,
    /// Coordinates and mean gradient at the end of the step.
    pub end: &'a HexahedronModes<R>,
    pub end_gradient: &'a Gradient<R>,
    /// Increments q of the four modes [length].
    pub q: [[R; 3]; HOURGLASS_MODES],
    /// Rotation of half the step.
    pub half_turn: &'a [[R; 3]; 3],
    /// Trace of [`Gradient::gram`] at the end.
    pub gram_trace: R,
    /// Mass over volume at the end [mass/length^3].
    pub density: R,
    /// Factor f by which plastic flow scales stress.
    pub left: R,
    /// Inverse of the step, zero for a step of zero [1/time].
    pub per_time: f64,
}

impl Hourglass {
    /// Returns P of the four modes at the end of the step, and the energy that the step adds to
    /// them.
    #[inline(always)]
    pub fn update<R: Real>(
        &self,
        step: &HourglassStep<'_, R>,
        history: &mut [R],
    ) -> ([[R; 3]; HOURGLASS_MODES], R) {
        match self.form {
            HourglassForm::AssumedStrain => assumed_strain(&self.elastic, step, history),
            HourglassForm::Stiffness => self.perturbation(step, history, false),
            HourglassForm::Viscous => self.perturbation(step, history, true),
        }
    }

    #[inline(always)]
    fn perturbation<R: Real>(
        &self,
        step: &HourglassStep<'_, R>,
        history: &mut [R],
        viscous: bool,
    ) -> ([[R; 3]; HOURGLASS_MODES], R) {
        let shear = self.elastic.shear_modulus();
        let modulus = (self.elastic.lame() + 2.0 * shear).min(3.5 * shear);
        let volume = step.end_gradient.volume();
        let unit = R::splat(modulus / 16.0) * volume * step.gram_trace;
        let factor = if viscous {
            R::splat(0.25 * self.coefficient * step.per_time)
                * (unit * step.density * volume).sqrt()
        } else {
            R::splat(self.coefficient) * unit
        };
        let turn = step.half_turn;
        let mut energy = R::zero();
        let mut forces = [[R::zero(); 3]; HOURGLASS_MODES];
        for (a, force) in forces.iter_mut().enumerate() {
            let kept = &mut history[3 * a..3 * a + 3];
            let old = apply(turn, [kept[0], kept[1], kept[2]]);
            let new: [R; 3] = std::array::from_fn(|i| {
                if viscous {
                    factor * step.q[a][i]
                } else {
                    step.left * factor.mul_add(step.q[a][i], old[i])
                }
            });
            energy += dot(std::array::from_fn(|i| old[i] + new[i]), step.q[a]);
            *force = apply(turn, new);
            kept.copy_from_slice(force);
        }
        (forces, R::splat(0.5) * energy)
    }
}

/// Inverse squares and products of the lengths of the first three modes.
struct Lengths<R> {
    /// `1/(l_i l_i)`.
    square: [R; 3],
    /// `1/(l_b l_c)` of the other two.
    others: [R; 3],
}

/// Computes the inverse lengths with one division, which costs as much as a dozen products.
#[inline(always)]
fn lengths<R: Real>(x: &HexahedronModes<R>) -> Lengths<R> {
    let [a, b, c] = std::array::from_fn(|i| dot(x[i], x[i]));
    let ab = a * b;
    let all = R::splat(1.0) / (ab * c);
    let one = all * c;
    let square = [one * b, one * a, all * ab];
    let [a, b, c] = square;
    Lengths { square, others: [(b * c).sqrt(), (c * a).sqrt(), (a * b).sqrt()] }
}

#[inline(always)]
fn assumed_strain<R: Real>(
    elastic: &Elastic,
    step: &HourglassStep<'_, R>,
    history: &mut [R],
) -> ([[R; 3]; HOURGLASS_MODES], R) {
    let [plane, _, g] = elastic.plane_stress().map(R::splat);
    let [nu, e] = [elastic.poisson, elastic.youngs_modulus].map(R::splat);
    let third = R::splat(1.0 / 3.0);
    let per = lengths(step.mid);
    let along: [[R; 3]; HOURGLASS_MODES] =
        std::array::from_fn(|a| std::array::from_fn(|i| dot(step.q[a], step.mid[i])));
    let end = lengths(step.end);
    let weight = third * step.end_gradient.volume();
    let (end_square, end_others) = (end.square.map(|s| weight * s), end.others.map(|s| weight * s));

    // Updates stress and energy of the modes b and c, which are linear along a.
    let linear = |a: usize, b: usize, c: usize, history: &mut [R]| {
        let e_bb = along[c][b] * per.square[b];
        let e_cc = along[b][c] * per.square[c];
        let g_bc = (along[c][c] + along[b][b]) * per.others[a];
        let kept = &mut history[3 * a..3 * a + 3];
        let old = [kept[0], kept[1], kept[2]];
        let new = [
            step.left * plane.mul_add(nu.mul_add(e_cc, e_bb), old[0]),
            step.left * plane.mul_add(nu.mul_add(e_bb, e_cc), old[1]),
            step.left * g.mul_add(g_bc, old[2]),
        ];
        kept.copy_from_slice(&new);
        let energy = dot([old[0] + new[0], old[1] + new[1], old[2] + new[2]], [e_bb, e_cc, g_bc]);
        (new[0] * end_square[b], new[1] * end_square[c], new[2] * end_others[a], energy)
    };
    let (s21, s12, t0, energy0) = linear(0, 1, 2, history);
    let (s02, s20, t1, energy1) = linear(1, 2, 0, history);
    let (s10, s01, t2, energy2) = linear(2, 0, 1, history);
    let bilinear = |i: usize, history: &mut [R]| {
        let strain = along[3][i] * per.square[i];
        let old = history[9 + i];
        let new = step.left * e.mul_add(strain, old);
        history[9 + i] = new;
        (third * new * end_square[i], (old + new) * strain)
    };
    let (q0, more0) = bilinear(0, history);
    let (q1, more1) = bilinear(1, history);
    let (q2, more2) = bilinear(2, history);

    let [x0, x1, x2, ..] = *step.end;
    // Force from its components along the first three modes.
    let force = |on: [R; 3]| {
        std::array::from_fn(|i| on[0].mul_add(x0[i], on[1].mul_add(x1[i], on[2] * x2[i])))
    };
    let forces = [
        force([t1 + t2, s01, s02]),
        force([s10, t0 + t2, s12]),
        force([s20, s21, t0 + t1]),
        force([q0, q1, q2]),
    ];
    let density = third * third.mul_add(more0 + more1 + more2, energy0 + energy1 + energy2);
    (forces, R::splat(0.5) * density * step.mid_gradient.volume())
}

/// Returns `turn v`.
#[inline(always)]
pub fn apply<R: Real>(turn: &[[R; 3]; 3], v: [R; 3]) -> [R; 3] {
    std::array::from_fn(|i| dot(turn[i], v))
}
