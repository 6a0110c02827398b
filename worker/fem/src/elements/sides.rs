//! Transverse shear from the sides of a quad, and membrane strain of twisted sides, shared by
//! `stabilised_quad.rs`, which has the equations, and `fully_integrated_quad.rs`.

use super::quad::{DRILLING, Generalised, QuadGeometry, QuadMotion};
use super::section::Strains;
use crumple_math::lanes::Real;

/// Quantities of the shape that shear and stabilisation use.
pub struct Slopes<R> {
    /// -4 dx/dxi and -4 dx/deta [length].
    pub p: [R; 2],
    pub q: [R; 2],
    /// 1/A [1/length^2], and X, Y [1/length].
    pub inv_a: R,
    pub to_xi: [R; 2],
    pub to_eta: [R; 2],
    /// 3 A times J: xx, yy, xy [length^2].
    pub j: [R; 3],
}

impl<R: Real> Slopes<R> {
    #[inline(always)]
    pub fn new(g: &QuadGeometry<R>) -> Self {
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
            j: [
                sum(q[1], q[1], p[1], p[1]),
                sum(q[0], q[0], p[0], p[0]),
                -sum(q[0], q[1], p[0], p[1]),
            ],
        }
    }
}

/// Returns the scalar product in the plane.
#[inline(always)]
pub fn dot2<R: Real>(a: [R; 2], b: [R; 2]) -> R {
    a[0].mul_add(b[0], a[1] * b[1])
}

/// Increments of the strains of the sides in a step.
pub struct Sides<R> {
    pub slopes: Slopes<R>,
    /// Increments of gamma_xi and gamma_eta [length].
    pub rate_xi: R,
    pub rate_eta: R,
    /// Mode h of the coordinates in the plane [length].
    h: [R; 2],
    /// Membrane strain per q_z, without the factor J [1/length^3].
    climb: R,
}

/// Generalised forces on the rates of an element with such sides, in its axes.
pub struct OnSides<'a, R> {
    /// Resultants times the area: membrane [force], moments [force length], shear [force].
    pub n: [R; 3],
    pub m: [R; 3],
    pub q: [R; 2],
    /// Forces on gamma_xi and gamma_eta [force].
    pub shear: [R; 2],
    /// Forces on the hourglass increments of tx, ty [force length], vx, vy [force].
    pub hourglass: [R; 4],
    /// Drilling moments [force length].
    pub drill: &'a [R],
}

impl<R: Real> Sides<R> {
    /// Computes the increments of this motion, whose hourglass increment of vz is `q_z`, and adds
    /// their parts of the strains to `strains`.
    #[inline(always)]
    pub fn new(
        g: &QuadGeometry<R>,
        motion: &QuadMotion<R>,
        q_z: R,
        strains: &mut Strains<R>,
    ) -> Self {
        let [quarter, sixteenth] = [0.25, 0.0625].map(R::splat);
        let s = Slopes::new(g);

        // Shear from the sides: beta_p is -4 M1 and beta_q is -4 M2.
        let t = &motion.t;
        let beta_p = [t[0][1] - t[1][1], t[1][0] - t[0][0]];
        let beta_q = [t[0][1] + t[1][1], -(t[0][0] + t[1][0])];
        let h = [g.x[2], g.y[2]];
        let twist = quarter * (dot2(h, strains.gamma) + q_z);
        let rate_xi = sixteenth.mul_add(dot2(beta_q, s.p), twist);
        let rate_eta = sixteenth.mul_add(dot2(beta_p, s.q), twist);
        let (by_xi, by_eta) = (dot2(beta_q, h) * sixteenth, dot2(beta_p, h) * sixteenth);
        for c in 0..2 {
            strains.gamma[c] =
                s.to_xi[c].neg_mul_add(by_xi, s.to_eta[c].neg_mul_add(by_eta, strains.gamma[c]));
        }

        // Membrane strain of twisted sides, relative to their own length if they are steep. It is
        // quadratic in hz, so its increment uses the mean of hz over the step. With the present hz
        // a vibration would stretch the element step by step.
        let mean = R::splat(0.5).neg_mul_add(q_z, g.hz);
        let plane = sixteenth * s.inv_a * s.inv_a;
        let per_climb = plane / (plane * mean * mean).mul_add(s.j[0] + s.j[1], R::splat(1.0));
        let climb = per_climb * g.hz;
        let stretch = per_climb * mean * q_z;
        strains.eps[0] = stretch.mul_add(s.j[0], strains.eps[0]);
        strains.eps[1] = stretch.mul_add(s.j[1], strains.eps[1]);
        strains.eps[2] = (stretch + stretch).mul_add(s.j[2], strains.eps[2]);
        Self { slopes: s, rate_xi, rate_eta, h, climb }
    }

    /// Returns [`QuadMotion::extrapolated`] about the normals of the corners.
    #[inline(always)]
    pub fn ahead(&self, g: &QuadGeometry<R>, motion: &QuadMotion<R>) -> [R; DRILLING] {
        let (t, mut ahead) = (&motion.t, motion.extrapolated());
        let [on_13, on_24] = std::array::from_fn(|c| g.b1[c].mul_add(t[c][0], g.b2[c] * t[c][1]));
        ahead[2] = g.hz.neg_mul_add(on_13 + on_24, ahead[2]);
        ahead[3] = g.hz.neg_mul_add(on_13 - on_24, ahead[3]);
        ahead
    }

    /// Returns the modes of the corner forces and moments. Forces on the rates of the sides are
    /// distributed to the modes from which these rates are computed.
    #[inline(always)]
    pub fn corners(&self, g: &QuadGeometry<R>, on: &OnSides<'_, R>) -> ([[R; 3]; 3], [[R; 3]; 4]) {
        let [quarter, sixteenth] = [0.25, 0.0625].map(R::splat);
        let Self { slopes: s, h, climb, .. } = self;
        let (OnSides { n, m, q, drill, .. }, [on_xi, on_eta], [on_tx, on_ty, on_x, on_y]) =
            (on, on.shear, on.hourglass);
        let on_twist = quarter * (on_xi + on_eta);
        let on_q_z = climb
            .mul_add(n[0].mul_add(s.j[0], n[1].mul_add(s.j[1], (n[2] + n[2]) * s.j[2])), on_twist);
        let forces = Generalised {
            n: *n,
            m: *m,
            q: [h[0].mul_add(on_twist, q[0]), h[1].mul_add(on_twist, q[1])],
            hourglass: [on_tx, on_ty, on_q_z, on_x, on_y],
            drilling: drill,
            couple: R::zero(),
        };
        let (force, mut moment) = forces.corners(g);
        let (q_xi, q_eta) = (dot2(*q, s.to_xi), dot2(*q, s.to_eta));
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
        (force, moment)
    }
}
