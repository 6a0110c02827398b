//! Four-node shell with one point in its plane, physically stabilised: no coefficient to choose.
//!
//! Of the class of Belytschko & Leviathan 1994 and Zeng & Combescure 1998. Frame, strains at the centre and corner
//! forces are those of `quad.rs`; what varies over the plane is taken to the first order in xi and eta, with the
//! Jacobian of the centre, and its stress is that of the elastic material, integrated over the area in closed form.
//!
//! With `X = grad xi`, `Y = grad eta` at the centre, `H = (h x, h y)`, `beta = (ty, -tx)`, `q_x = gam vx` and so on,
//! ```text
//! J = A/3 (XX + YY),   Jxx = A/3 (X1 X1 + Y1 Y1) and so on
//! ```
//! - Membrane: the assumed strain for bending in the plane without dilation (Belytschko & Bindeman 1991, QBI),
//!   `eps_x = (q_x f,x - nu q_y f,y)/4`, `eps_y = (q_y f,y - nu q_x f,x)/4`, no shear, `f = xi eta`:
//!   energy `E t/32 [Jxx q_x^2 + Jyy q_y^2 - 2 nu Jxy q_x q_y]`. No locking in plane bending, none in volume.
//! - Bending: the same with `t^2/12` and the modes of beta.
//! - Transverse shear: covariant, from the sides (Bathe & Dvorkin 1985), so that it vanishes in any pure bending of
//!   any flat quad. With M1, M2 the derivatives of beta by xi and eta, a and b those of the coordinates:
//!   ```text
//!   gamma = gamma(quad.rs) + X (M2 H)/4 + Y (M1 H)/4
//!   gamma_xi = eta (s + M2 a),  gamma_eta = xi (s + M1 b),   s = (q_z + H gamma(quad.rs))/4
//!   ```
//!   energy `5/6 G t A/6 [X X (s + M2 a)^2 + Y Y (s + M1 b)^2]`, each term softer by what the bending of sides of
//!   length L adds, `1 + 5/6 G t L^2 / (12 D)` (residual bending flexibility, MacNeal 1978).
//! - Warped elements: a side that climbs by z0 = h z/4 against the plane is stretched by z0 q_z/4 when the element
//!   is twisted. Its mean goes into the membrane strain, `eps += z0 q_z/4 (XX + YY)`; at the centre alone the twist
//!   of a warped element would pass for stretching, and thin twisted strips lock. (Membrane strains tied at the sides
//!   for the same reason: Ko, Lee & Bathe 2017.)
//! - Drilling of `quad.rs`, but about the normals of the corners, `n - z0 (eta X + xi Y)`, so that a bent warped
//!   element asks for none: the modes h and sum lose `h z` times `tx,x + ty,y` and what remains of it with the sign
//!   of the second difference turned (the drill projection of Belytschko & Leviathan 1994).
//!
//! Plastic flow takes the stabilising forces of membrane and bending along, by two factors of the section: they shrink
//! as the radial return shrinks the deviator, by `sig / (sig + 3 G d eps_p)`, and grow with the ratio of tangent to
//! elastic stiffness, `d sig / (d sig + 3 G d eps_p)`, but at least with the part's `hourglass_coefficient` of it.
//! They unload elastically, so that flow takes energy from them. Shear stays elastic, as in the section.
//!
//! Valid where one layer of elements follows the stress; where the centre stays elastic nothing bounds the
//! stabilising forces. Of a part's options, `hourglass` and `warping` are not read.

use super::quad::{self, Capacity, DRILLING, Generalised, Geometry, Kernel, Modes, Motion, Quad, Response};
use super::section::{Resultants, SHEAR_CORRECTION, Section};
use super::shell::Shell;
use super::{Build, Built, ElementRow, let_go};
use crate::lanes::Real;
use crate::materials::{PlaneStress, PointReal};
use crumple_proto::job::Part;
use crumple_proto::mesh::Shape;

/// The row of this element.
pub const ROW: ElementRow = ElementRow {
    name: "stabilised_quad",
    meaning: "One point in its plane, physically stabilised: bends exactly where quads are distorted.",
    shape: Shape::Quad4,
    build: Build::Shell(build),
};

/// Own columns, after those of the section: stabilising forces on gam tx, gam ty, gamma_xi, gamma_eta
/// [force length], gam vx and gam vy [force]; then the drilling moments.
const STABILISING: usize = 6;

/// Parameters of the stabilised shell.
pub struct StabilisedQuad {
    section: Section,
    /// alpha.
    drilling: f64,
    /// Fraction of their elastic stiffness that stabilising forces keep in plastic flow, at least.
    least_stiffness: f64,
}

fn build(part: &Part, law: Box<dyn PlaneStress>) -> Built {
    let section = Section::new(part, law)?;
    let least_stiffness = section.hourglass_coefficient;
    Ok(Box::new(Shell(Quad(StabilisedQuad { section, drilling: part.drilling, least_stiffness }))))
}

/// What the stabilisation needs of the shape.
pub struct Slopes<R> {
    /// -4 dx/dxi and -4 dx/deta [length].
    pub p: [R; 2],
    pub q: [R; 2],
    /// 1/A, and X, Y [1/length].
    pub inv_a: R,
    pub to_xi: [R; 2],
    pub to_eta: [R; 2],
    /// 3 A times J: xx, yy, xy [length^2].
    pub j: [R; 3],
}

impl<R: Real> Slopes<R> {
    #[inline(always)]
    pub fn new(g: &Geometry<R>) -> Self {
        let p = [g.x[0] - g.x[1], g.y[0] - g.y[1]];
        let q = [g.x[0] + g.x[1], g.y[0] + g.y[1]];
        let inv_a = g.inv_2a + g.inv_2a;
        let sum = |a: R, b: R, c: R, d: R| a.mul_add(b, c * d);
        Self {
            p,
            q,
            inv_a,
            to_xi: [-(q[1] * inv_a), q[0] * inv_a],
            to_eta: [p[1] * inv_a, -(p[0] * inv_a)],
            j: [sum(q[1], q[1], p[1], p[1]), sum(q[0], q[0], p[0], p[0]), -sum(q[0], q[1], p[0], p[1])],
        }
    }
}

/// Scalar product in the plane.
#[inline(always)]
pub fn dot2<R: Real>(a: [R; 2], b: [R; 2]) -> R {
    a[0].mul_add(b[0], a[1] * b[1])
}

impl Kernel for StabilisedQuad {
    const OWN: usize = STABILISING + DRILLING;
    /// The sides' shear at the centre is `(X (M2 H) + Y (M1 H))/4` of rotations that vary, and `XX + YY = 4 S`: tr S/4, and
    /// tr S is s where elements are long.
    const TAPER: f64 = 0.25;

    fn section(&self) -> &Section {
        &self.section
    }

    #[inline(always)]
    fn respond<R: PointReal, const N: usize>(&self, modes: &Modes<R>, history: &mut [R], dt: f64) -> Response<R> {
        let (section, own) = history.split_at_mut(self.section.columns());
        let (stabilising, drill) = own[..STABILISING + DRILLING].split_at_mut(STABILISING);
        let [quarter, sixteenth] = [0.25, 0.0625].map(R::splat);

        // 1. Frame, and everything that moves as seen in it.
        let g = Geometry::new(&modes.x);
        let s = Slopes::new(&g);
        let (motion, mut strains) = Motion::new(&g, modes, dt);
        let [q_tx, q_ty, q_z, q_x, q_y] = motion.hourglass(&g);

        // 2. Shear from the sides. With beta, p is 4 (M1), q is 4 (M2), both less their sign.
        let t = &motion.t;
        let beta_p = [t[0][1] - t[1][1], t[1][0] - t[0][0]];
        let beta_q = [t[0][1] + t[1][1], -(t[0][0] + t[1][0])];
        let h = [g.x[2], g.y[2]];
        let twist = quarter * (dot2(h, strains.gamma) + q_z);
        let rate_xi = sixteenth.mul_add(dot2(beta_q, s.p), twist);
        let rate_eta = sixteenth.mul_add(dot2(beta_p, s.q), twist);
        let (by_xi, by_eta) = (dot2(beta_q, h) * sixteenth, dot2(beta_p, h) * sixteenth);
        for c in 0..2 {
            strains.gamma[c] = s.to_xi[c].neg_mul_add(by_xi, s.to_eta[c].neg_mul_add(by_eta, strains.gamma[c]));
        }

        // 3. Membrane strain of twisted sides.
        let per_climb = sixteenth * s.inv_a * s.inv_a;
        let climb = per_climb * g.hz;
        // The strain goes with the square of hz, so its increment with the mean of hz: with that of now a vibration would
        // stretch the element step by step.
        let stretch = per_climb * R::splat(0.5).neg_mul_add(q_z, g.hz) * q_z;
        strains.eps[0] = stretch.mul_add(s.j[0], strains.eps[0]);
        strains.eps[1] = stretch.mul_add(s.j[1], strains.eps[1]);
        strains.eps[2] = (stretch + stretch).mul_add(s.j[2], strains.eps[2]);

        // 4. Stress.
        let sound = self.section.healthy(&strains, self.section.current_thickness(section));
        let before = self.section.yielded::<R, N>(section);
        let Resultants { n, m, q, work, thickness } = self.section.update::<R, N>(section, &strains, dt);
        let [keep, tangent] = self.section.flow::<R, N>(section, &before);
        let (n, m, q) = (n.map(|n| n * g.area), m.map(|m| m * g.area), q.map(|q| q * g.area));

        // 5. Stabilising and drilling forces.
        let elastic = &self.section.elastic;
        let third = R::splat(1.0 / 3.0) * s.inv_a;
        let membrane = R::splat(elastic.youngs_modulus / 16.0) * thickness * third;
        // A single point through the thickness bears no bending.
        let bending = R::splat(if N > 1 { 1.0 / 12.0 } else { 0.0 }) * thickness * thickness * membrane;
        let shear = R::splat(SHEAR_CORRECTION * elastic.shear_modulus()) * thickness * third;
        let one = R::splat(1.0);
        // 5/6 G t L^2 over 12 times the bending stiffness, L = p/2 or q/2 the length along xi or eta.
        let bends = R::splat(SHEAR_CORRECTION / 8.0 * (1.0 - elastic.poisson)) / (thickness * thickness);
        let (p2, q2) = (dot2(s.p, s.p), dot2(s.q, s.q));
        let nu_xy = R::splat(elastic.poisson) * s.j[2];
        let [jxx, jyy, _] = s.j;
        let rates = [q_tx, q_ty, rate_xi, rate_eta, q_x, q_y];
        let more = [
            bending * jyy.mul_add(q_tx, nu_xy * q_ty),
            bending * jxx.mul_add(q_ty, nu_xy * q_tx),
            shear * q2 * rate_xi / bends.mul_add(p2, one),
            shear * p2 * rate_eta / bends.mul_add(q2, one),
            membrane * jxx.mul_add(q_x, -(nu_xy * q_y)),
            membrane * jyy.mul_add(q_y, -(nu_xy * q_x)),
        ];
        // Membrane is 0 and bending 1 in what the section tells; shear stays elastic.
        let kind = [Some(1), Some(1), None, None, Some(0), Some(0)];
        let tangent = tangent.map(|ratio| Real::max(ratio, R::splat(self.least_stiffness)));
        let mut energy = R::zero();
        for c in 0..STABILISING {
            let old = stabilising[c];
            let new = match kind[c] {
                Some(kind) => {
                    // Unloading is elastic: with the tangent it would give back more than it took.
                    let loading = (old * more[c]).gt(R::zero());
                    keep[kind] * R::select(loading, tangent[kind], one).mul_add(more[c], old)
                }
                None => old + more[c],
            };
            stabilising[c] = new;
            energy = (old + new).mul_add(rates[c], energy);
        }
        let stiff = quad::drilling_stiffness(&self.section, self.drilling, thickness, g.area);
        let mut ahead = motion.ahead();

        let [on_13, on_24] = std::array::from_fn(|c| g.b1[c].mul_add(t[c][0], g.b2[c] * t[c][1]));
        ahead[2] = g.hz.neg_mul_add(on_13 + on_24, ahead[2]);
        ahead[3] = g.hz.neg_mul_add(on_13 - on_24, ahead[3]);
        let flow_stress = self.section.flow_stress::<R, N>(section);
        let capacity = flow_stress.map(|stress| Capacity::new(stress, thickness, g.area));
        energy = quad::drill(drill, stiff, ahead, capacity.as_ref(), energy);

        // 6. Corner forces: what acts on the rates of stages 2 and 3 goes to the modes that these are made of.
        let [on_xi, on_eta] = [stabilising[2], stabilising[3]];
        let on_twist = quarter * (on_xi + on_eta);
        let on_q_z = climb.mul_add(n[0].mul_add(s.j[0], n[1].mul_add(s.j[1], (n[2] + n[2]) * s.j[2])), on_twist);
        let forces = Generalised {
            n,
            m,
            q: [h[0].mul_add(on_twist, q[0]), h[1].mul_add(on_twist, q[1])],
            hourglass: [stabilising[0], stabilising[1], on_q_z, stabilising[4], stabilising[5]],
            drilling: drill,
            couple: R::zero(),
        };
        let (force, mut moment) = forces.corners(&g);
        let (q_xi, q_eta) = (dot2(q, s.to_xi), dot2(q, s.to_eta));
        let tilting = [-(g.hz * (drill[2] + drill[3])), -(g.hz * (drill[2] - drill[3]))];
        for c in 0..2 {
            moment[c][0] = g.b1[c].mul_add(tilting[c], moment[c][0]);
            moment[c][1] = g.b2[c].mul_add(tilting[c], moment[c][1]);
        }
        let [[x_13, x_24], [y_13, y_24]] = [0, 1].map(|c| {
            let on_beta_q = sixteenth * s.p[c].mul_add(on_xi, -(h[c] * q_xi));
            let on_beta_p = sixteenth * s.q[c].mul_add(on_eta, -(h[c] * q_eta));
            [on_beta_q + on_beta_p, on_beta_q - on_beta_p]
        });
        moment[0][1] += x_13;
        moment[1][1] += x_24;
        moment[0][0] -= y_13;
        moment[1][0] -= y_24;
        let energies = [work * g.area, R::splat(0.5) * energy];
        let mut response = Response::new(&g, &self.section, (force, moment), energies, sound);
        if let Some(failed) = self.section.failed_lanes(section) {
            response.let_go(failed);
            let_go(failed, stabilising);
            let_go(failed, drill);
        }
        response
    }
}

#[cfg(test)]
#[path = "stabilised_quad_tests.rs"]
mod tests;
