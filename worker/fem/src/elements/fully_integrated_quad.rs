//! Four-node shell with 2 x 2 points in its plane: only the material at the points resists the
//! deformation.
//!
//! The formulation belongs to the class of Dvorkin & Bathe 1984 (MITC4) for shear and of Belytschko
//! & Bindeman 1991 for the membrane. Frame, strains at the centre and corner forces are those of
//! `quad.rs`. Strains vary over the plane to the first order in xi and eta, with the Jacobian of
//! the centre, as in `stabilised_quad.rs`. Here each of the Gauss points `xi, eta = +-1/sqrt 3` has
//! the weight A/4, its own points through the thickness, its own shear and its own thickness. With
//! X, Y the gradients of xi and eta at the centre, `f = xi eta`, `q_x = gam vx` and so on,
//! ```text
//! eps_x   = eps_x(0)   + (q_x f,x - nu q_y f,y)/4
//! eps_y   = eps_y(0)   + (q_y f,y - nu q_x f,x)/4
//! kappa_x = kappa_x(0) + (q_ty f,x + nu q_tx f,y)/4
//! kappa_y = kappa_y(0) - (q_tx f,y + nu q_ty f,x)/4
//! gamma   = gamma(0) + X eta k_xi gamma_xi + Y xi k_eta gamma_eta
//! f,x = X_x eta + Y_x xi,   f,y = X_y eta + Y_y xi
//! ```
//! - Membrane and bending: the assumed strain for bending in the plane (QBI), which locks neither
//!   in shear nor in volume. Its mean over the points is zero, so that a patch under constant
//!   stress is exact for any shape.
//! - Transverse shear: covariant, from the sides (Dvorkin & Bathe 1984), gamma_xi and gamma_eta as
//!   in `stabilised_quad.rs`, elastic, and not part of the yield condition. The factor
//!   `k^2 = 1/(1 + 5/6 G t L^2/(12 D))` for sides of length L accounts for their own bending
//!   (MacNeal 1978). The shear is zero in any pure bending, with k or without; without k the stable
//!   step of oblique elements would be less than half as large.
//! - Warped elements and drilling as in `stabilised_quad.rs`.
//!
//! There is no hourglass control and no coefficient: in plastic flow the modes that vary over the
//! plane have exactly the resistance of the points. A point at which all points through the
//! thickness have failed carries no stress, shear included. An element fails as a whole when three
//! of its four points have failed.
//!
//! Small elastic strains have the same stiffness as in `stabilised_quad.rs`, since 2 x 2 points
//! integrate its squares exactly; so inertia and stable step are those of `quad.rs`. The options
//! `hourglass`, `hourglass_coefficient` and `warping` of a part are not read.

use super::bounds;
use super::quad::{DRILLING, Kernel, Quad, QuadGeometry, QuadModes, QuadMotion, QuadResponse};
use super::section::{SHEAR_CORRECTION, Section, Strains};
use super::shell::Shell;
use super::sides::{OnSides, Sides, dot2};
use super::{Constructor, ElementEntry, ElementResult, parameters, zero_failed};
use crate::materials::{PlaneStress, PointReal};
use crate::parameter::Values;
use crumple_proto::job::Part;
use crumple_proto::mesh::Shape;

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "fully_integrated_quad",
    meaning: "2 x 2 in-plane points, no hourglass control: the reference for the other quads.",
    shape: Shape::Quad4,
    parameters: [parameters::OF_SHELLS, &[]],
    idle: |_| &[],
    build: Constructor::Shell(build),
};

/// Number of points in the plane.
const PLANAR: usize = 4;

/// Parameters of the fully integrated shell. Its own columns, after those of the section, are the
/// drilling moments.
pub struct FullyIntegratedQuad {
    section: Section,
    /// alpha.
    drilling: f64,
}

fn build(part: &Part, values: &Values<'_>, law: Box<dyn PlaneStress>) -> ElementResult {
    let section = Section::new(part, values, law)?.at_points(PLANAR);
    let drilling = values.number("drilling");
    Ok(Box::new(Shell(Quad(FullyIntegratedQuad { section, drilling }))))
}

impl Kernel for FullyIntegratedQuad {
    const OWN: &'static [&'static str] =
        &["drilling 1 - 3", "drilling 2 - 4", "drilling h", "drilling sum"];
    /// See the stabilised shell, which has the same shear at the centre.
    const TAPER: f64 = 0.25;
    /// A single thin element that is stretched to twice its length is stable for 0.876 of the step
    /// of the membrane (`stretched_tests.rs`).
    const STEP: f64 = 0.95;

    fn section(&self) -> &Section {
        &self.section
    }

    fn section_mut(&mut self) -> &mut Section {
        &mut self.section
    }

    #[inline(always)]
    fn respond<R: PointReal, const N: usize>(
        &self,
        g: &QuadGeometry<R>,
        modes: &QuadModes<R>,
        history: &mut [R],
        dt: f64,
    ) -> QuadResponse<R> {
        let (section, own) = history.split_at_mut(self.section.columns());
        let drill = &mut own[..DRILLING];
        let quarter = R::splat(0.25);
        let gauss = R::splat(1.0 / 3.0_f64.sqrt());

        // 1. Frame, and all motions in its axes.
        let (motion, mut strains) = QuadMotion::new(g, modes, dt);
        let [q_tx, q_ty, q_z, q_x, q_y] = motion.hourglass(g);

        // 2. Shear from the sides, and membrane strain of twisted sides.
        let sides = Sides::new(g, &motion, q_z, &mut strains);
        let Sides { slopes: s, rate_xi, rate_eta, .. } = &sides;
        let (rate_xi, rate_eta) = (*rate_xi, *rate_eta);

        // 3. Strains that are added at the points (1, 1) and (-1, 1) over sqrt 3, and subtracted at
        //    the opposite points.
        let nu = R::splat(self.section.stabilising.poisson);
        let along: [[R; 2]; 2] = [
            std::array::from_fn(|c| gauss * (s.to_xi[c] + s.to_eta[c])),
            std::array::from_fn(|c| gauss * (s.to_xi[c] - s.to_eta[c])),
        ];
        let more = |f: [R; 2], qx: R, qy: R| {
            let (x, y) = (quarter * f[0] * qx, quarter * f[1] * qy);
            [nu.neg_mul_add(y, x), nu.neg_mul_add(x, y)]
        };
        let each = self.section.each();
        let mut thickness = R::zero();
        for columns in section.chunks_exact(each) {
            thickness = quarter.mul_add(self.section.current_thickness(columns), thickness);
        }
        let bends =
            R::splat(SHEAR_CORRECTION / 8.0 * self.section.shear_ratio) / (thickness * thickness);
        let soft = |along: [R; 2]| gauss / bends.mul_add(dot2(along, along), R::splat(1.0)).sqrt();
        let (soft_xi, soft_eta) = (soft(s.p), soft(s.q));
        let (shear_xi, shear_eta) = (soft_xi * rate_xi, soft_eta * rate_eta);
        let varying: [[[R; 2]; 3]; 2] = std::array::from_fn(|pair| {
            let sign = if pair == 0 { shear_eta } else { -shear_eta };
            let gamma = std::array::from_fn(|c| s.to_xi[c].mul_add(shear_xi, s.to_eta[c] * sign));
            [more(along[pair], q_x, q_y), more(along[pair], q_ty, -q_tx), gamma]
        });

        // 4. Stress at the points, its sums, and its differences between opposite points.
        let zero = R::zero();
        let weight = quarter * g.area;
        let (mut n, mut m, mut q) = ([zero; 3], [zero; 3], [zero; 2]);
        let mut across = [[[zero; 2]; 3]; 2];
        let mut work = zero;
        let mut sound = zero.le(zero);
        for (point, columns) in section.chunks_exact_mut(each).enumerate() {
            let sign = R::splat(if point % 2 == 0 { 1.0 } else { -1.0 });
            let [eps, kappa, gamma] = &varying[point / 2];
            let mut here: Strains<R> = strains;
            for c in 0..2 {
                here.eps[c] = sign.mul_add(eps[c], here.eps[c]);
                here.kappa[c] = sign.mul_add(kappa[c], here.kappa[c]);
                here.gamma[c] = sign.mul_add(gamma[c], here.gamma[c]);
            }
            sound = R::both(
                sound,
                self.section.sound_points(&here, self.section.current_thickness(columns)),
            );
            let on = self.section.update::<R, N>(columns, &here, dt);
            for c in 0..3 {
                n[c] = weight.mul_add(on.n[c], n[c]);
                m[c] = weight.mul_add(on.m[c], m[c]);
            }
            let signed = sign * weight;
            let difference = &mut across[point / 2];
            for c in 0..2 {
                q[c] = weight.mul_add(on.q[c], q[c]);
                difference[0][c] = signed.mul_add(on.n[c], difference[0][c]);
                difference[1][c] = signed.mul_add(on.m[c], difference[1][c]);
                difference[2][c] = signed.mul_add(on.q[c], difference[2][c]);
            }
            work = weight.mul_add(on.work, work);
        }
        let stable_dt = g.stable_dt_now::<Self>(&self.section, section);

        // 5. Forces on the rates of stage 3, and drilling.
        let acts = |kind: usize| {
            let [a, b] = [0, 1].map(|pair: usize| {
                let [x, y] = across[pair][kind];
                [along[pair][0] * nu.neg_mul_add(y, x), along[pair][1] * nu.neg_mul_add(x, y)]
            });
            [quarter * (a[0] + b[0]), quarter * (a[1] + b[1])]
        };
        let ([on_x, on_y], [on_ty, minus_on_tx]) = (acts(0), acts(1));
        let [shear_1, shear_2] = [across[0][2], across[1][2]];
        let on_xi = soft_xi * (dot2(s.to_xi, shear_1) + dot2(s.to_xi, shear_2));
        let on_eta = soft_eta * (dot2(s.to_eta, shear_1) - dot2(s.to_eta, shear_2));

        let stiff = bounds::drilling_stiffness(&self.section, self.drilling, thickness, g.area);
        let ahead = sides.ahead(g, &motion);
        let energy = bounds::drill(drill, stiff, &ahead, zero);
        let lost = bounds::DRILLING.apply::<R, N>(
            (&self.section, section),
            (&mut [], drill),
            (&[], &ahead),
            thickness,
            ([], g.area),
        );
        let energy = energy + lost;

        // 6. Corner forces.
        let hourglass = [-minus_on_tx, on_ty, on_x, on_y];
        let (force, moment) =
            sides.corners(g, &OnSides { n, m, q, shear: [on_xi, on_eta], hourglass, drill });
        let mut response =
            QuadResponse::new(g, (force, moment), [work, R::splat(0.5) * energy], stable_dt, sound);
        if let Some(failed) = self.section.fail_with_last_point(section) {
            response.zero_failed(failed);
            zero_failed(failed, drill);
        }
        response
    }
}

#[cfg(test)]
#[path = "fully_integrated_quad_tests.rs"]
mod tests;
