//! Four-node shells with one point in their plane: frame, gradients, strains, drilling, corner
//! forces.
//!
//! Frame at x(t): normal n along `r31 x r42`. In-plane axes from the bisector frame,
//! `e1 ~ a/|a| + (b/|b|) x n`, `e2 = n x e1`, with a, b the mean directions of xi and eta, so that
//! numbering an element from another corner only rotates its axes by a right angle. With
//! `y24 = y2 - y4` and so on
//! ```text
//! A = |r31 x r42| / 2,   B1 = [y24, y31, y42, y13] / 2A,   B2 = [x42, x13, x24, x31] / 2A
//! K = dt grad v (3 x 2)           velocity gradient at the centre times the step, on x(t)
//! e = sym K - K'K/2,  eps = P (e + ee) P'
//! kappa = dt [B1 ty, -B2 tx, B2 ty - B1 tx]          gamma = dt [B1 vz + mean ty, B2 vz - mean tx]
//! ```
//! I - K is the inverse of the deformation gradient of the step, so e is its Almansi strain: it
//! vanishes in any finite rigid rotation; e + ee is the logarithmic strain to second order. In a
//! step the axes rotate by `delta = (e_yy - e_xx) a.b/(2 |a| |b|)` more than the material (the mean
//! of the rotations of a and b by the strain). P transforms the strain to axes that lag by half of
//! that, halfway between those before and those after the step. In the latter the stress in finite
//! shear would have an error of first order in the step (A26). Curvatures are transformed likewise.
//! gamma takes the rotation of the plane from K as a finite one, so that it vanishes too when the
//! nodes rotate with the element.
//!
//! Corner forces follow from virtual power with the same B. Two additions:
//! - Hourglass rates `gam (tx, ty, vz, vx, vy)` with `gam_I = h_I - (h x) B1_I - (h y) B2_I`
//!   (Flanagan & Belytschko 1981). They exclude the motion of out-of-plane corners of a warped
//!   element in a finite rotation, and the forces include the corresponding couple. Without it a
//!   warped element resists rigid rotation and adds angular momentum to it.
//! - Drilling: stiffness `alpha G t A/4` per node on its spin about n relative to that of the
//!   element. In plastic parts its moments are bounded. At a fold the spin of one face is the
//!   bending of the other, and a stiffness that never yields would carry more than the plastic
//!   hinge there, all the more in coarse meshes (`bounds.rs`).
//!
//! Concave quads are valid: one point needs the area between the diagonals, and no condition at the
//! corners. Crushed corners of tubes pass through such shapes, and the established codes also
//! continue there.
//!
//! Stable step: `L/c`, with L = A over the longest side and c the plate wave speed, is that of a
//! wave through many elements. The stable step of a single element may be smaller. With mass m/4 at
//! each corner the squared frequencies of its membrane stiffness are the eigenvalues of
//! `(4/rho) C B B'`. The largest one is, with `S = sum b_I b_I'` of the mean gradient (its
//! determinant is 1/A^2 for any quad, its trace D/A^2, D half the sum of the squared diagonals),
//! ```text
//! omega^2 = 2 c^2 (tr S + sqrt(tr^2 S - 4 (1-nu^2) det S))
//!         = 2 (c/A)^2 (D + sqrt(D^2 - 4 (1-nu^2) A^2))
//! ```
//! The step is the smaller of `L/c` and [`SINGLE_ELEMENT_FACTOR`] times `2/omega`, at the density
//! of the material. The mass of an element is that of the start while its area and thickness
//! change: [`Section::stable_dt`].
//!
//! All quantities at the four corners are stored as three or four modes, of which the corner values
//! are sums: the differences 1 - 3 and 2 - 4, `h` (1 - 2 + 3 - 4), and for rotations the sum. B has
//! parts in the first two only.

mod mode_rows;

use super::kinematics::{Frame, PlaneMotion, curvature, rotated};
use super::section::{Section, StepQuantities, Strains};
use super::shell::Formulation;
use super::{GroupCorners, GroupNodes, Totals, zero_failed};
use crate::materials::{PointLanes, PointReal};
use crate::nodes::NodeView;
use crumple_math::lanes::{Real, cross, dot};
use crumple_proto::mesh::OwnSection;
use mode_rows::{
    OfMiddle, gather_coordinates, gather_velocities, of_middle, scatter, shift_to_nodes,
};
pub use mode_rows::{magnitude, zero_corners};

/// Number of generalised hourglass rates: of tx, ty, vz, vx, vy.
pub const HOURGLASS: usize = 5;
/// Number of columns of the drilling moments of the modes 1 - 3, 2 - 4, h and sum [force length].
pub const DRILLING: usize = 4;

/// Upper limit of the step over that of a single element in its membrane modes. With the usual
/// safety factor of 0.9 a single square or strip is stable by 5 %. The value 1 would be safe for
/// any safety factor below 1, but would shorten the step of meshes of squares, which are stable for
/// L/c, by a further 5 %.
const SINGLE_ELEMENT_FACTOR: f64 = 1.05;

/// Fraction of its stable step for which a quad is stable alone.
pub const ALONE: f64 = 1.0 / SINGLE_ELEMENT_FACTOR;

/// Smallest area over the sum of the squared diagonals; an element below it has collapsed to a
/// line.
const MIN_AREA: f64 = 1e-6;

/// Corner velocities of an element, as modes.
pub struct QuadModes<R> {
    /// Modes 1 - 3, 2 - 4 and h of the velocities [length/time].
    pub v: [[R; 3]; 3],
    /// Modes 1 - 3, 2 - 4, h and the sum of the rotational velocities [1/time].
    pub w: [[R; 3]; 4],
}

/// Result of a kernel for a group, in global axes.
pub struct QuadResponse<R: Real> {
    /// Corner forces: `+13 + h, +24 - h, -13 + h, -24 - h` [force].
    pub force: [[R; 3]; 3],
    /// Corner moments: signs as in `force`, with `+ sum` at all corners [force length].
    pub moment: [[R; 3]; 4],
    /// Totals, with the stable step at the density of the material.
    pub totals: Totals<R>,
    /// Lanes that have an area and the strain increments of a valid step.
    calm: R::Mask,
}

impl<R: Real> QuadResponse<R> {
    /// Removes failed elements: they have no forces, do not limit the step and are never reported
    /// as trouble.
    #[inline(always)]
    pub fn zero_failed(&mut self, failed: R::Mask) {
        zero_failed(failed, self.force.as_flattened_mut());
        zero_failed(failed, self.moment.as_flattened_mut());
        self.totals.zero_failed(failed);
    }
}

/// Frame and shape of an element.
pub struct QuadGeometry<R: Real> {
    pub frame: Frame<R>,
    pub area: R,
    /// 1/2A [1/length^2].
    pub inv_2a: R,
    /// Modes 13, 24 and h of the coordinates in the plane, and h off it [length].
    pub x: [R; 3],
    pub y: [R; 3],
    pub hz: R,
    /// Cosine of the angle between the mean directions of xi and eta.
    skew: R,
    /// B1 and B2 at corners 1 and 2; corners 3 and 4 have their negatives [1/length].
    pub b1: [R; 2],
    pub b2: [R; 2],
    /// Square of the longest side, and D, half the sum of the squared diagonals [length^2].
    longest: R,
    diagonals: R,
    /// Lanes with elements that have not collapsed.
    pub has_area: R::Mask,
}

impl<R: Real> QuadGeometry<R> {
    #[inline(always)]
    pub fn new(x: &[[R; 3]; 3]) -> Self {
        let [x13, x24, h] = *x;
        let one = R::splat(1.0);
        let half = R::splat(0.5);
        let raw = cross(x13, x24);
        let two_a = dot(raw, raw).sqrt();
        let inv_2a = one / two_a;
        let n = raw.map(|c| c * inv_2a);
        // Both are in the plane already. Each is scaled by the other's length, which avoids a
        // division by its own.
        let a: [R; 3] = std::array::from_fn(|i| x24[i] - x13[i]);
        let b: [R; 3] = std::array::from_fn(|i| -(x13[i] + x24[i]));
        let (len_a, len_b) = (dot(a, a).sqrt(), dot(b, b).sqrt());
        let bxn = cross(b, n);
        let e1: [R; 3] = std::array::from_fn(|i| a[i].mul_add(len_b, bxn[i] * len_a));
        let inv = one / dot(e1, e1).sqrt();
        let e1 = e1.map(|c| c * inv);
        let e2 = cross(n, e1);
        let x = [dot(e1, x13), dot(e1, x24), dot(e1, h)];
        let y = [dot(e2, x13), dot(e2, x24), dot(e2, h)];
        let hz = dot(n, h);

        // Half the sides of the projected element: 2 - 1 = -(p + s), 3 - 2 = -(q - s), ...
        let side = |ux: R, uy: R| ux.mul_add(ux, uy * uy);
        let [px, py] = [x[0] - x[1], y[0] - y[1]];
        let [qx, qy] = [x[0] + x[1], y[0] + y[1]];
        let [sx, sy] = [x[2], y[2]];
        let longest = Real::max(
            Real::max(side(px + sx, py + sy), side(px - sx, py - sy)),
            Real::max(side(qx + sx, qy + sy), side(qx - sx, qy - sy)),
        );
        // The sides above are doubled. Every side also rises by half of hz. The stretching of
        // twisted sides (`sides.rs`) needs half as much again (`plate_tests.rs`).
        let longest = (R::splat(1.5) * hz).mul_add(hz, longest);
        // |a| |b| (1 + sine) is half the square of the length that e1 had before it was normalised.
        let (sides, rise) = (len_a * len_b, R::splat(2.0) * two_a);
        let skew = (px * qx + py * qy) * (sides + rise) * (inv * inv);
        let area = half * two_a;
        let diagonals = half * (side(x[0], y[0]) + side(x[1], y[1]));
        Self {
            frame: Frame { e1, e2, n },
            area,
            inv_2a,
            b1: [y[1] * inv_2a, -(y[0] * inv_2a)],
            b2: [-(x[1] * inv_2a), x[0] * inv_2a],
            x,
            y,
            hz,
            skew: skew + skew,
            longest: R::splat(0.25) * longest,
            diagonals,
            has_area: area.gt(R::splat(MIN_AREA) * diagonals),
        }
    }

    /// Returns the stable step at the density of the material [time].
    #[inline(always)]
    pub fn stable_dt(&self, section: &Section, fraction: f64) -> R {
        let side2 = self.equivalent_side2(section.elastic.poisson);
        section.membrane_step(self.area, R::splat(1.0) / side2, fraction)
    }

    /// Returns the limits of the step for the kernel `K`.
    #[inline(always)]
    fn limits<K: Kernel>(&self, section: &Section) -> StepQuantities<R> {
        let area = self.area;
        let h2 = self.x[2].mul_add(self.x[2], self.y[2] * self.y[2]);
        let taper = R::splat(K::TAPER) * h2;
        StepQuantities {
            area,
            inv_area: self.inv_2a + self.inv_2a,
            side2: self.equivalent_side2(section.elastic.poisson),
            fraction: K::STEP,
            corners: 4.0,
            least_s: 1.0, // its determinant is 1/A^2
            taper,
            floor: R::splat(section.inertia_floor()) * (area + taper),
        }
    }

    /// Returns the present stable step from the columns of the section [time]. Call it long before
    /// its result is needed: it is a chain of roots and quotients, each of which waits for the one
    /// before.
    #[inline(always)]
    pub fn stable_dt_now<K: Kernel>(&self, section: &Section, columns: &[R]) -> R {
        section.stable_dt(columns, &self.limits::<K>(section))
    }

    /// Returns the square of the side by which the area is divided for the stable length: the
    /// longest side, or that which stands for a single element [length^2].
    #[inline(always)]
    fn equivalent_side2(&self, poisson: f64) -> R {
        let root = (4.0 * (1.0 - poisson * poisson)).sqrt();
        let (d, a) = (self.diagonals, R::splat(root) * self.area);
        // D is at least 2 A, except for round-off.
        let lone = d + Real::max(d.mul_add(d, -(a * a)), R::zero()).sqrt();
        Real::max(
            self.longest,
            R::splat(0.5 / (SINGLE_ELEMENT_FACTOR * SINGLE_ELEMENT_FACTOR)) * lone,
        )
    }

    /// Returns B1 and B2 applied to a nodal column that has the modes u13 and u24.
    #[inline(always)]
    pub fn gradient(&self, u13: R, u24: R) -> [R; 2] {
        [self.b1[0].mul_add(u13, self.b1[1] * u24), self.b2[0].mul_add(u13, self.b2[1] * u24)]
    }

    /// Returns gam applied to a nodal column that has the mode h and this gradient.
    #[inline(always)]
    pub fn gamma(&self, h: R, gradient: [R; 2]) -> R {
        self.x[2].neg_mul_add(gradient[0], self.y[2].neg_mul_add(gradient[1], h))
    }

    /// Returns the modes 13 and 24 of `B1_I s1 + B2_I s2`.
    #[inline(always)]
    pub fn spread(&self, s1: R, s2: R) -> [R; 2] {
        [self.b1[0].mul_add(s1, self.b2[0] * s2), self.b1[1].mul_add(s1, self.b2[1] * s2)]
    }
}

/// Motion of an element in a step, in its axes, as increments of the step.
pub struct QuadMotion<R> {
    /// Modes 13, 24 and h of displacement [length].
    pub u: [[R; 3]; 3],
    /// Modes 13, 24, h and the sum of rotation.
    pub t: [[R; 3]; 4],
    /// Gradients: k[i][j] of displacement i by coordinate j; tx and ty of the rotations [1/length].
    pub k: [[R; 2]; 3],
    pub tx: [R; 2],
    pub ty: [R; 2],
    /// Almansi strain xx, yy, xy.
    pub almansi: [R; 3],
    /// Rotation of the element about its normal.
    pub spin: R,
    /// Third column of K, computed as if I - K were a rotation.
    k_z: [R; 3],
}

impl<R: Real> QuadMotion<R> {
    /// Computes the motion of a step and its strain increments.
    #[inline(always)]
    pub fn new(g: &QuadGeometry<R>, modes: &QuadModes<R>, dt: f64) -> (Self, Strains<R>) {
        let step = R::splat(dt);
        let [half, quarter] = [0.5, 0.25].map(R::splat);
        let u = g.frame.increments(&modes.v, step);
        let k: [[R; 2]; 3] = std::array::from_fn(|i| g.gradient(u[0][i], u[1][i]));
        let plane = PlaneMotion::new(&k);
        let t = plane.offsets(g.frame.increments(&modes.w, step));
        let tx = g.gradient(t[0][0], t[1][0]);
        let ty = g.gradient(t[0][1], t[1][1]);

        let PlaneMotion { almansi, eps, k_z: [k_xz, k_yz], sine, angle } = plane;
        let tilt2 = k_xz.mul_add(k_xz, k_yz * k_yz);
        // 1 - sqrt(1 - tilt2)
        let [c4, c3, c2] = [5.0 / 64.0, 0.125, 0.25].map(R::splat);
        let k_zz =
            half * tilt2 * tilt2.mul_add(tilt2.mul_add(tilt2.mul_add(c4, c3), c2), R::splat(1.0));
        let gamma = [
            angle.mul_add(sine[0], quarter * t[3][1]),
            (-quarter).mul_add(t[3][0], angle * sine[1]),
        ];
        let spin = angle * sine[2];
        let motion = Self { u, t, k, tx, ty, almansi, spin, k_z: [k_xz, k_yz, k_zz] };
        let ahead = quarter * g.skew * (eps[0] - eps[1]);
        let between = |c: [R; 3]| rotated(ahead, c);
        (motion, Strains { eps: between(eps), kappa: between(curvature(tx, ty)), gamma })
    }

    /// Returns the increments of the hourglass modes tx, ty, vz, vx, vy.
    #[inline(always)]
    pub fn hourglass(&self, g: &QuadGeometry<R>) -> [R; HOURGLASS] {
        let Self { u, t, k, .. } = self;
        let [k_xz, k_yz, k_zz] = self.k_z;
        // I - K rotates back: `back` is the increment of the shape in the configuration before the
        // step.
        let back: [R; 3] = std::array::from_fn(|i| {
            g.gamma([k_xz, k_yz, k_zz][i].neg_mul_add(g.hz, u[2][i]), k[i])
        });
        // In the present configuration. Otherwise the rotation of a step tilts a vibration, and
        // the tilt feeds it with energy of the rotation: it grows at the rate omega^2 dt, with
        // omega the rate of rotation.
        let now = |i: usize, k_z: R| {
            k[i][0].mul_add(back[0], k[i][1].mul_add(back[1], k_z.mul_add(back[2], back[i])))
        };
        [
            g.gamma(t[2][0], self.tx),
            g.gamma(t[2][1], self.ty),
            now(2, k_zz),
            now(0, k_xz),
            now(1, k_yz),
        ]
    }

    /// Returns the rotation of the nodes about n beyond that of the element: modes 13, 24, h and
    /// sum.
    #[inline(always)]
    pub fn extrapolated(&self) -> [R; DRILLING] {
        let t = &self.t;
        [t[0][2], t[1][2], t[2][2], R::splat(4.0).neg_mul_add(self.spin, t[3][2])]
    }
}

/// Generalised forces on the motions of an element, in its axes.
pub struct Generalised<'a, R> {
    /// Resultants times the area: membrane [force], moments [force length], shear [force].
    pub n: [R; 3],
    pub m: [R; 3],
    pub q: [R; 2],
    /// Forces on the hourglass increments: the first two [force length], the other three [force].
    pub hourglass: [R; HOURGLASS],
    /// Drilling moments [force length].
    pub drilling: &'a [R],
    /// Couple on the spin, in addition to that of drilling, carried by the in-plane forces [force
    /// length].
    pub couple: R,
}

impl<R: Real> Generalised<'_, R> {
    /// Returns the modes of the corner forces and moments, in the axes of the element.
    #[inline(always)]
    pub fn corners(&self, g: &QuadGeometry<R>) -> ([[R; 3]; 3], [[R; 3]; 4]) {
        let [half, quarter] = [0.5, 0.25].map(R::splat);
        let ([nx, ny, nxy], [mx, my, mxy], [qx, qy]) = (self.n, self.m, self.q);
        let [hg_tx, hg_ty, hg_z, hg_x, hg_y] = self.hourglass;
        let drill = self.drilling;
        let couple = half * (R::splat(-4.0).mul_add(drill[3], self.couple));
        let (hx, hy) = (g.x[2], g.y[2]);
        let fx = g.spread(hx.neg_mul_add(hg_x, nx), hy.neg_mul_add(hg_x, nxy) - couple);
        let fy = g.spread(hx.neg_mul_add(hg_y, nxy) + couple, hy.neg_mul_add(hg_y, ny));
        let fz = g.spread(
            hx.neg_mul_add(hg_z, g.hz.mul_add(hg_x, qx)),
            hy.neg_mul_add(hg_z, g.hz.mul_add(hg_y, qy)),
        );
        let mtx = g.spread(-hx.mul_add(hg_tx, mxy), -hy.mul_add(hg_tx, my));
        let mty = g.spread(hx.neg_mul_add(hg_ty, mx), hy.neg_mul_add(hg_ty, mxy));
        let force = [[fx[0], fy[0], fz[0]], [fx[1], fy[1], fz[1]], [hg_x, hg_y, hg_z]];
        let moment = [
            [mtx[0], mty[0], drill[0]],
            [mtx[1], mty[1], drill[1]],
            [hg_tx, hg_ty, drill[2]],
            [-(quarter * qy), quarter * qx, drill[3]],
        ];
        (force, moment)
    }
}

impl<R: Real> QuadResponse<R> {
    /// Builds the response from corner modes in the axes of the element. `energies` are internal
    /// and hourglass energy; `healthy` are the lanes with the strain increments of a valid step.
    #[inline(always)]
    pub fn new(
        g: &QuadGeometry<R>,
        (force, moment): ([[R; 3]; 3], [[R; 3]; 4]),
        [internal, hourglass]: [R; 2],
        stable_dt: R,
        healthy: R::Mask,
    ) -> Self {
        let (force, moment) = (g.frame.to_global(force), g.frame.to_global(moment));
        // Zero times a number is not zero if the number is not finite.
        let mut nothing = [R::zero(); 3];
        for c in 0..3 {
            for part in force.iter().chain(&moment) {
                nothing[c] = part[c].mul_add(R::zero(), nothing[c]);
            }
        }
        let calm = R::both(healthy, g.has_area);
        let finite = (nothing[0] + nothing[1] + nothing[2]).le(R::zero());
        let sound = R::both(calm, finite);
        Self { force, moment, totals: Totals { stable_dt, internal, hourglass, sound }, calm }
    }
}

/// Properties and kernel of one quad formulation.
pub trait Kernel: Send + Sync {
    /// Names of its own columns, after those of the section.
    const OWN: &'static [&'static str];
    /// Factor for the shear that rotations cause if they vary over a tapered element. It enters the
    /// rotational inertia: shear has the squared frequency `5/6 G/rho (4 s + (1 + TAPER s H^2)/I)`,
    /// with s the larger principal value of S and I the inertia per mass.
    const TAPER: f64;
    /// Fraction of the step of the membrane for which the formulation is stable.
    const STEP: f64 = 1.0;

    /// Returns the section through the thickness.
    fn section(&self) -> &Section;

    /// Returns the section to change it.
    fn section_mut(&mut self) -> &mut Section;

    /// Computes one element of the geometry `g` in each lane. The reference kernel and the fast
    /// kernel are this one function.
    fn respond<R: PointReal, const N: usize>(
        &self,
        g: &QuadGeometry<R>,
        modes: &QuadModes<R>,
        history: &mut [R],
        dt: f64,
    ) -> QuadResponse<R>;
}

/// A quad with the kernel `K`.
pub struct Quad<K>(pub K);

impl<K: Kernel> Formulation for Quad<K> {
    const OWN: &'static [&'static str] = K::OWN;
    /// The frequency of shear may require a step up to 7 % below `L/c`; the membrane of a single
    /// square is stable for `L/c` only if nu = 0.
    const ALONE: f64 = ALONE;
    const DIVISIBLE: bool = true;

    fn section(&self) -> &Section {
        self.0.section()
    }

    fn section_mut(&mut self) -> &mut Section {
        self.0.section_mut()
    }

    /// s is at least 1/A. So an inertia of [`Section::inertia_floor`] times `A + TAPER H^2` limits
    /// the frequency of shear to that of the membrane, except for 7 %.
    fn corner_mass(&self, x: &[[f64; 3]; 4], own: OwnSection) -> (f64, f64) {
        let (section, [area, floor]) = (self.section(), self.size(x));
        let mass = 0.25 * section.elastic.density * section.thickness_at_start(own) * area;
        (mass, mass * section.inertia_per_mass(own, floor))
    }

    fn size(&self, x: &[[f64; 3]; 4]) -> [f64; 2] {
        let (section, g) = (self.section(), QuadGeometry::new(&coordinate_modes(x)));
        [g.area, g.limits::<K>(section).floor]
    }

    fn stable_dt(&self, x: &[[f64; 3]; 4]) -> f64 {
        let geometry = QuadGeometry::new(&coordinate_modes(x));
        if !geometry.has_area {
            return f64::NAN;
        }
        geometry.stable_dt(self.section(), K::STEP)
    }

    fn stable_dt_now(&self, history: &[f64], x: &[[f64; 3]; 4]) -> f64 {
        let (section, geometry) = (self.section(), QuadGeometry::new(&coordinate_modes(x)));
        if !geometry.has_area {
            return f64::NAN;
        }
        geometry.stable_dt_now::<K>(section, history)
    }

    fn axes(x: &[[f64; 3]; 4]) -> [[f64; 3]; 3] {
        let Frame { e1, e2, n } = QuadGeometry::new(&coordinate_modes(x)).frame;
        [e1, e2, n]
    }

    #[inline(always)]
    fn group<L: PointLanes<W>, const W: usize, const N: usize>(
        &self,
        group: &GroupNodes<4, W>,
        nodes: &NodeView<'_>,
        history: &mut [L],
        dt: f64,
        [force, moment]: [&mut GroupCorners<4, W>; 2],
    ) -> Totals<L> {
        let section = self.section();
        // The frame is a chain of roots and quotients, each of which waits for the one before. The
        // velocities are gathered after it, so that the processor has other work meanwhile.
        let geometry = QuadGeometry::new(&gather_coordinates(group, nodes.x));
        // Rare options gather once more, outside of this function: here they would cost every
        // element a fifth of its time.
        let mut middle = OfMiddle { modes: gather_velocities(group, nodes), arm: [L::zero(); 3] };
        if section.has_offset() {
            middle = of_middle(group, nodes, section.arm(history));
        }
        let OfMiddle { modes, arm } = middle;
        let response = self.0.respond::<L, N>(&geometry, &modes, history, dt);
        scatter(&response, force, moment);
        let (calm, mut totals) = (response.calm, response.totals);
        if section.has_offset() {
            shift_to_nodes(arm, force, moment);
        }
        if section.deletes {
            let moves = || magnitude(group, nodes);
            let gone = section.delete_inverted(history, calm, totals.sound, moves);
            totals.zero_failed(gone);
            zero_corners::<L, W>(gone, force, moment);
        }
        totals
    }

    #[inline(never)]
    fn forceless<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<4, W>,
        nodes: &NodeView<'_>,
        history: &[L],
    ) -> Totals<L> {
        let geometry = QuadGeometry::<L>::new(&gather_coordinates(group, nodes.x));
        let stable_dt = geometry.stable_dt(self.section(), K::STEP);
        let factor = self.section().offset_factor(history);
        let stable_dt = factor.map_or(stable_dt, |factor| factor * stable_dt);
        Totals::inactive(stable_dt, geometry.has_area)
    }
}

/// Returns the modes 13, 24 and h of the corners of one element.
pub fn coordinate_modes(x: &[[f64; 3]; 4]) -> [[f64; 3]; 3] {
    let mode = |f: &dyn Fn(usize) -> f64| std::array::from_fn(f);
    [
        mode(&|i| x[0][i] - x[2][i]),
        mode(&|i| x[1][i] - x[3][i]),
        mode(&|i| (x[0][i] - x[1][i]) + (x[2][i] - x[3][i])),
    ]
}

#[cfg(test)]
#[path = "quad_tests.rs"]
pub mod tests;
