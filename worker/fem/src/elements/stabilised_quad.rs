//! Four-node shell with one point in its plane, physically stabilised: no coefficient to choose.
//!
//! The formulation belongs to the class of Belytschko & Leviathan 1994 and Zeng & Combescure 1998.
//! Frame, strains at the centre and corner forces are those of `quad.rs`. Strains vary over the
//! plane to the first order in xi and eta, with the Jacobian of the centre. Their stress is that of
//! the elastic material, integrated over the area in closed form.
//!
//! With `X = grad xi`, `Y = grad eta` at the centre, `H = (h x, h y)`, `beta = (ty, -tx)`,
//! `q_x = gam vx` and so on,
//! ```text
//! J = A/3 (XX + YY),   Jxx = A/3 (X1 X1 + Y1 Y1) and so on
//! ```
//! - Membrane: the assumed strain for bending in the plane without dilation (Belytschko & Bindeman
//!   1991, QBI), `eps_x = (q_x f,x - nu q_y f,y)/4`, `eps_y = (q_y f,y - nu q_x f,x)/4`, no shear,
//!   `f = xi eta`: energy `E t/32 [Jxx q_x^2 + Jyy q_y^2 - 2 nu Jxy q_x q_y]`. It locks neither in
//!   plane bending nor in volume.
//! - Bending: the same form with `t^2/12` and the modes of beta.
//! - Transverse shear: covariant, from the sides (Bathe & Dvorkin 1985), so that it vanishes in any
//!   pure bending of any flat quad. With M1, M2 the derivatives of beta by xi and eta, and a, b
//!   those of the coordinates, the strains are `gamma = gamma(quad.rs) + X (M2 H)/4 + Y (M1 H)/4`,
//!   `gamma_xi = eta (s + M2 a)`, `gamma_eta = xi (s + M1 b)`, `s = (q_z + H gamma(quad.rs))/4`,
//!   and the energy is `5/6 G t A/6 [X X (s + M2 a)^2 + Y Y (s + M1 b)^2]`. Each term is divided by
//!   `1 + 5/6 G t L^2 / (12 D)`, which adds the bending of sides of length L (residual bending
//!   flexibility, MacNeal 1978).
//! - Warped elements: a side that rises by z0 = h z/4 out of the plane is stretched by z0 q_z/4
//!   when the element is twisted. The mean of this goes into the membrane strain,
//!   `eps += f z0 q_z/4 (XX + YY)`. With the centre alone the twist of a warped element would count
//!   as stretching, and thin twisted strips would lock. (Ko, Lee & Bathe 2017 tie membrane strains
//!   at the sides for the same reason.) `f = 1/(1 + z0^2 (X X + Y Y))` is the square of a side's
//!   length in the plane over that in space. Without it an element that is folded upright would be
//!   too stiff for its stable step.
//! - Drilling of `quad.rs`, but about the normals of the corners, `n - z0 (eta X + xi Y)`, so that
//!   a bent warped element needs no drilling. From the modes h and sum, `h z` times `tx,x + ty,y`
//!   and the remainder of it with the sign of the second difference reversed are subtracted (the
//!   drill projection of Belytschko & Leviathan 1994).
//!
//! Plastic flow acts on the stabilising forces of membrane and bending by two factors of the
//! section. The forces are scaled as the radial return scales the deviator, by
//! `sig / (sig + 3 G d eps_p)`. Their stiffness is scaled by the ratio of tangent to elastic
//! stiffness, `d sig / (d sig + 3 G d eps_p)`, but at least by the part's `hourglass_coefficient`.
//! `d sig` excludes the contribution of the strain rate: a rate rises and falls from step to step,
//! and its rises are no hardening. The forces unload elastically, so that flow dissipates their
//! energy. Shear stays elastic, as in the section.
//!
//! Forces of membrane and bending in a plastic part are bounded by those of a fully plastic element
//! (`bounds.rs`), also where the centre stays elastic: one element over the depth of a beam that is
//! bent in its plane has the plastic moment. The options `hourglass` and `warping` of a part are
//! not read.

use super::bounds::{self, Bounds, Mode};
use super::quad::{DRILLING, Kernel, Quad, QuadGeometry, QuadModes, QuadMotion, QuadResponse};
use super::section::{Flow, Resultants, SAVED, SHEAR_CORRECTION, Section};
use super::shell::Shell;
use super::sides::{OnSides, Sides, dot2};
use super::{Constructor, ElementEntry, ElementResult, parameters, zero_failed};
use crate::materials::{PlaneStress, PointReal};
use crate::parameter::Values;
use crumple_math::lanes::{Each, Real};
use crumple_proto::job::Part;
use crumple_proto::mesh::Shape;

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "stabilised_quad",
    meaning: "One in-plane point, physically stabilised: exact in bending of distorted quads.",
    shape: Shape::Quad4,
    parameters: [
        parameters::OF_SHELLS,
        &[parameters::coefficient_of_shell(
            0.01,
            "Smallest fraction of its elastic stabilisation that remains in plastic flow. \
             Hourglass forces of shells with a plastic law are bounded. See \
             `cases/studies/README.md`, crush-floor.",
        )],
    ],
    idle: |_| &[],
    build: Constructor::Shell(build),
};

/// Number of stabilising forces, on gam tx, gam ty [force length], gam vx, gam vy [force], gamma_xi
/// and gamma_eta [force length]. They are the first own columns, after those of the section; the
/// drilling moments follow.
const STABILISING: usize = 6;
/// Largest stabilising forces of membrane and bending in a plastic part: those of a fully plastic
/// element.
const BOUNDS: Bounds<4> =
    Bounds { modes: [Mode::Bending, Mode::Bending, Mode::Membrane, Mode::Membrane], strength: 1.0 };

/// Parameters of the stabilised shell.
pub struct StabilisedQuad {
    section: Section,
    /// alpha.
    drilling: f64,
    /// Smallest fraction of their elastic stiffness that stabilising forces keep in plastic flow.
    least_stiffness: f64,
}

fn build(part: &Part, values: &Values<'_>, law: Box<dyn PlaneStress>) -> ElementResult {
    Ok(Box::new(Shell(Quad(StabilisedQuad {
        section: Section::new(part, values, law)?,
        drilling: values.number("drilling"),
        least_stiffness: values.number("hourglass_coefficient"),
    }))))
}

impl Kernel for StabilisedQuad {
    const OWN: &'static [&'static str] = &[
        "stabilising tx",
        "stabilising ty",
        "stabilising vx",
        "stabilising vy",
        "stabilising xi",
        "stabilising eta",
        "drilling 1 - 3",
        "drilling 2 - 4",
        "drilling h",
        "drilling sum",
    ];
    /// Rotations that vary cause the shear `(X (M2 H) + Y (M1 H))/4` of the sides at the centre,
    /// and `XX + YY = 4 S`. This gives tr S/4, and tr S is s if elements are long.
    const TAPER: f64 = 0.25;

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
        let (stabilising, drill) = own[..STABILISING + DRILLING].split_at_mut(STABILISING);

        // 1. Frame, and all motions in its axes.
        let (motion, mut strains) = QuadMotion::new(g, modes, dt);
        let [q_tx, q_ty, q_z, q_x, q_y] = motion.hourglass(g);

        // 2. Shear from the sides, and membrane strain of twisted sides.
        let sides = Sides::new(g, &motion, q_z, &mut strains);
        let Sides { slopes: s, rate_xi, rate_eta, .. } = &sides;
        let (rate_xi, rate_eta) = (*rate_xi, *rate_eta);

        // 3. Stress.
        let sound = self.section.sound_points(&strains, self.section.current_thickness(section));
        let mut before = [[R::zero(); SAVED]; N];
        self.section.save_points::<R, N>(section, &mut before);
        let Resultants { n, m, q, work, thickness } =
            self.section.update::<R, N>(section, &strains, dt);
        let stable_dt = g.stable_dt_now::<Self>(&self.section, section);
        let Flow { keep, tangent } = self.section.flow::<R, N>(section, &before);
        let (n, m, q) = (n.each(|n| n * g.area), m.each(|m| m * g.area), q.each(|q| q * g.area));

        // 4. Stabilising and drilling forces.
        let elastic = &self.section.stabilising;
        let third = R::splat(1.0 / 3.0) * s.inv_a;
        let membrane = R::splat(elastic.youngs_modulus / 16.0) * thickness * third;
        // A single point through the thickness has no bending stiffness.
        let bending =
            R::splat(if N > 1 { 1.0 / 12.0 } else { 0.0 }) * thickness * thickness * membrane;
        let shear =
            R::splat(SHEAR_CORRECTION * self.section.transverse_modulus) * thickness * third;
        let one = R::splat(1.0);
        // 5/6 G t L^2 over 12 times the bending stiffness, with L = p/2 or q/2 the length along xi
        // or eta.
        let bends =
            R::splat(SHEAR_CORRECTION / 8.0 * self.section.shear_ratio) / (thickness * thickness);
        let (p2, q2) = (dot2(s.p, s.p), dot2(s.q, s.q));
        let nu_xy = R::splat(elastic.poisson) * s.j[2];
        let [jxx, jyy, _] = s.j;
        let rates = [q_tx, q_ty, q_x, q_y, rate_xi, rate_eta];
        let more = [
            bending * jyy.mul_add(q_tx, nu_xy * q_ty),
            bending * jxx.mul_add(q_ty, nu_xy * q_tx),
            membrane * jxx.mul_add(q_x, -(nu_xy * q_y)),
            membrane * jyy.mul_add(q_y, -(nu_xy * q_x)),
            shear * q2 * rate_xi / bends.mul_add(p2, one),
            shear * p2 * rate_eta / bends.mul_add(q2, one),
        ];
        // In the section's factors membrane is 0 and bending is 1; shear stays elastic.
        let kind = [Some(1), Some(1), Some(0), Some(0), None, None];
        let tangent = tangent.each(|ratio| Real::max(ratio, R::splat(self.least_stiffness)));
        let ahead = sides.ahead(g, &motion);
        let mut energy = R::zero();
        for c in 0..STABILISING {
            let old = stabilising[c];
            let new = match kind[c] {
                Some(kind) => {
                    // Unloading is elastic: with the tangent it would release more energy than
                    // loading stored. Loading means that the elastic trial is larger in magnitude,
                    // so that round-off of a force near zero has no effect.
                    let loading = (more[c] * (old + old + more[c])).gt(R::zero());
                    keep[kind] * R::select(loading, tangent[kind], one).mul_add(more[c], old)
                }
                None => old + more[c],
            };
            stabilising[c] = new;
            energy = (old + new).mul_add(rates[c], energy);
        }
        let stiff = bounds::drilling_stiffness(&self.section, self.drilling, thickness, g.area);
        let energy = bounds::drill(drill, stiff, &ahead, energy);
        // Squares of the sides of a rectangle. Strain along x varies over the side along y.
        let along_y = R::splat(0.25) * jxx;
        let along_x = R::splat(0.25) * jyy;
        let lost = BOUNDS.apply::<R, N>(
            (&self.section, section),
            (stabilising, drill),
            (&rates, &ahead),
            thickness,
            ([along_x, along_y, along_y, along_x], g.area),
        );
        let energy = energy + lost;

        // 5. Corner forces.
        let [on_tx, on_ty, on_x, on_y, on_xi, on_eta] = std::array::from_fn(|c| stabilising[c]);
        let on_sides = OnSides {
            n,
            m,
            q,
            shear: [on_xi, on_eta],
            hourglass: [on_tx, on_ty, on_x, on_y],
            drill,
        };
        let (force, moment) = sides.corners(g, &on_sides);
        let energies = [work * g.area, R::splat(0.5) * energy];
        let mut response = QuadResponse::new(g, (force, moment), energies, stable_dt, sound);
        if let Some(failed) = self.section.failed_lanes(section) {
            response.zero_failed(failed);
            zero_failed(failed, stabilising);
            zero_failed(failed, drill);
        }
        response
    }
}

#[cfg(test)]
#[path = "stabilised_quad_tests.rs"]
mod tests;
