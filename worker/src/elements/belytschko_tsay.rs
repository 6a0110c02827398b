//! Four-node shell of Belytschko, Lin & Tsay 1984 with one point in its plane, stabilised.
//!
//! Frame at x(t): normal n along `r31 x r42`; in-plane axes from the bisector frame,
//! `e1 ~ a/|a| + (b/|b|) x n`, `e2 = n x e1` with a, b the mean directions of xi and eta, so that numbering an
//! element from another corner only turns its axes by a right angle. With `y24 = y2 - y4` and so on
//! ```text
//! A = |r31 x r42| / 2,   B1 = [y24, y31, y42, y13] / 2A,   B2 = [x42, x13, x24, x31] / 2A
//! K = dt grad v (3 x 2)           velocity gradient at the centre times the step, on x(t)
//! e = sym K - K'K/2,  eps = e + ee
//! kappa = dt [B1 ty, -B2 tx, B2 ty - B1 tx]          gamma = dt [B1 vz + mean ty, B2 vz - mean tx]
//! ```
//! I - K is the inverse of the deformation gradient of the step, so e is its Almansi strain: it vanishes in any
//! finite rigid rotation; eps is the logarithmic strain to second order. gamma takes the rotation of the plane from
//! K as a finite one, so that it vanishes too when the nodes turn with the element.
//!
//! Corner forces by virtual power with the same B. Options and additions:
//! - Hourglass, after Flanagan & Belytschko 1981: `gam_I = h_I - (h x) B1_I - (h y) B2_I`, rates `gam (tx, ty, vz,
//!   vx, vy)`, with stiffness `r E t^3 A BB/192`, `r 5/6 G t^3 BB/12`, `r E t A BB/8` (BB = B1 B1 + B2 B2), which
//!   for r = 1 is about that of full integration. In the viscous form the coefficient is `(r/2) sqrt(K m)`, K the
//!   stiffness at r = 1 and m the mass (or inertia): the fraction r of critical damping of the mode. The rates
//!   leave out what a finite rotation of a warped element does to its corners off the plane, and the forces carry
//!   the couple that belongs to it; without it a warped element resists rigid rotation and feeds it angular momentum.
//! - Drilling: stiffness `alpha G t A/4` a node on its spin about n against that of the element.
//! - Warping of Belytschko, Wong & Chiang 1992: curvature gets `Bc1 vx, Bc2 vy, Bc2 vx + Bc1 vy` with
//!   `Bc1 = (2 z0/A^2) [x13, x42, x31, x24]`, Bc2 likewise with y, z0 = h z/4; here less what in-plane spin adds.
//!
//! Everything about four corners is held as three or four modes, of which the corners are sums:
//! the differences 1 - 3 and 2 - 4, `h` (1 - 2 + 3 - 4), and for rotations the sum. B has parts in the first two only.
//!
//! Left out: a shear projection, so bending patches of distorted quads fail, and thin twisted strips lock.

use super::section::{INERTIA_FLOOR, Resultants, SHEAR_CORRECTION, Section, Strains, angle_by_sine};
use super::{
    Build, Built, Element, ElementFields, ElementRow, GroupNodes, GroupTotals, NodeView, Pass, PassTotals, four,
    let_go, with_points,
};
use crate::lanes::{LANES, Lane, Real, cross, dot};
use crate::materials::{PlaneStress, PointReal};
use crumple_proto::job::{HourglassForm, Part};
use crumple_proto::mesh::Shape;

/// The row of this element.
pub const ROW: ElementRow = ElementRow { name: "belytschko_tsay", shape: Shape::Quad4, build: Build::Shell(build) };

/// Own columns, after those of the section: hourglass resultants of tx, ty [force length], vz, vx, vy [force].
const HOURGLASS: usize = 5;
/// Then drilling moments of the modes 1 - 3, 2 - 4, h and sum [force length].
const DRILLING: usize = 4;

/// Parameters of the four-node shell.
pub struct BelytschkoTsay {
    section: Section,
    hourglass: HourglassForm,
    warping: bool,
    /// alpha.
    drilling: f64,
}

fn build(part: &Part, law: Box<dyn PlaneStress>) -> Built {
    let section = Section::new(part, law)?;
    Ok(Box::new(BelytschkoTsay { section, hourglass: part.hourglass, warping: part.warping, drilling: part.drilling }))
}

/// Corner vectors of an element as modes.
struct Modes<R> {
    /// 1 - 3, 2 - 4 and h of coordinates [length].
    x: [[R; 3]; 3],
    /// The same of velocities [length/time].
    v: [[R; 3]; 3],
    /// The same and the sum, of rotational velocities [1/time].
    w: [[R; 3]; 4],
}

/// What one pass over a group gives, in global axes.
struct Response<R: Real> {
    /// Corner forces: `+13 + h, +24 - h, -13 + h, -24 - h` [force].
    force: [[R; 3]; 3],
    /// Corner moments: the same with `+ sum` everywhere [force length].
    moment: [[R; 3]; 4],
    /// Increase of internal energy, of hourglass and drilling energy [energy].
    internal: R,
    hourglass: R,
    /// Stable step [time].
    stable_dt: R,
    /// Lanes whose element is sound.
    sound: R::Mask,
}

impl<R: Real> Response<R> {
    /// Elements that have failed give nothing, limit nothing and are never in trouble.
    #[inline(always)]
    fn let_go(&mut self, failed: R::Mask) {
        let_go(failed, self.force.as_flattened_mut());
        let_go(failed, self.moment.as_flattened_mut());
        self.internal = R::select(failed, R::zero(), self.internal);
        self.hourglass = R::select(failed, R::zero(), self.hourglass);
        self.stable_dt = R::select(failed, R::splat(f64::INFINITY), self.stable_dt);
        self.sound = R::either(self.sound, failed);
    }
}

/// Frame and shape of an element.
struct Geometry<R: Real> {
    e1: [R; 3],
    e2: [R; 3],
    n: [R; 3],
    area: R,
    /// 1/2A [1/length^2].
    inv_2a: R,
    /// Modes 13, 24 and h of the coordinates in the plane, and h off it [length].
    x: [R; 3],
    y: [R; 3],
    hz: R,
    /// B1 and B2 at corners 1 and 2; corners 3 and 4 have their negatives [1/length].
    b1: [R; 2],
    b2: [R; 2],
    /// A over the longest side [length].
    length: R,
    /// Lanes with all four corner Jacobians above nought.
    convex: R::Mask,
}

impl<R: Real> Geometry<R> {
    #[inline(always)]
    fn new(x: &[[R; 3]; 3]) -> Self {
        let [x13, x24, h] = *x;
        let one = R::splat(1.0);
        let half = R::splat(0.5);
        let raw = cross(x13, x24);
        let two_a = dot(raw, raw).sqrt();
        let inv_2a = one / two_a;
        let n = raw.map(|c| c * inv_2a);
        // Both lie in the plane already. Scaled by each other's length instead of divided by their own.
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

        // Half the sides of the element that its plane sees: 2 - 1 = -(p + s), 3 - 2 = -(q - s), ...
        let side = |ux: R, uy: R| ux.mul_add(ux, uy * uy);
        let [px, py] = [x[0] - x[1], y[0] - y[1]];
        let [qx, qy] = [x[0] + x[1], y[0] + y[1]];
        let [sx, sy] = [x[2], y[2]];
        let longest = Real::max(
            Real::max(side(px + sx, py + sy), side(px - sx, py - sy)),
            Real::max(side(qx + sx, qy + sy), side(qx - sx, qy - sy)),
        );
        // Sides above are doubled; every side also climbs by half of hz.
        let longest = hz.mul_add(hz, longest);
        let area = half * two_a;
        // Corner Jacobians are A +- (p x s)/4 +- (q x s)/4.
        let lopsided = px.mul_add(sy, -(py * sx)).abs() + qx.mul_add(sy, -(qy * sx)).abs();
        Self {
            e1,
            e2,
            n,
            area,
            inv_2a,
            b1: [y[1] * inv_2a, -(y[0] * inv_2a)],
            b2: [-(x[1] * inv_2a), x[0] * inv_2a],
            x,
            y,
            hz,
            length: two_a / longest.sqrt(),
            convex: area.gt(R::splat(0.25) * lopsided),
        }
    }

    /// Components of a vector in the element's axes.
    #[inline(always)]
    fn local(&self, v: [R; 3]) -> [R; 3] {
        [dot(self.e1, v), dot(self.e2, v), dot(self.n, v)]
    }

    /// The vector with these components in the element's axes.
    #[inline(always)]
    fn global(&self, v: [R; 3]) -> [R; 3] {
        std::array::from_fn(|i| v[0].mul_add(self.e1[i], v[1].mul_add(self.e2[i], v[2] * self.n[i])))
    }

    /// B1 and B2 on a nodal column that has the modes u13 and u24.
    #[inline(always)]
    fn gradient(&self, u13: R, u24: R) -> [R; 2] {
        [self.b1[0].mul_add(u13, self.b1[1] * u24), self.b2[0].mul_add(u13, self.b2[1] * u24)]
    }

    /// gam on a nodal column that has the mode h and this gradient.
    #[inline(always)]
    fn gamma(&self, h: R, gradient: [R; 2]) -> R {
        self.x[2].neg_mul_add(gradient[0], self.y[2].neg_mul_add(gradient[1], h))
    }

    /// Modes 13 and 24 of `B1_I s1 + B2_I s2`.
    #[inline(always)]
    fn spread(&self, s1: R, s2: R) -> [R; 2] {
        [self.b1[0].mul_add(s1, self.b2[0] * s2), self.b1[1].mul_add(s1, self.b2[1] * s2)]
    }
}

/// Coupling of in-plane velocity to curvature in a warped element: corner values 1 and 2 of Bc1 and Bc2 [1/length^2],
/// and what they make of the coordinates.
struct Warping<R> {
    bc1: [R; 2],
    bc2: [R; 2],
    /// Bc1 x, Bc1 y (which is Bc2 x), Bc2 y.
    on_x: [R; 3],
}

impl<R: Real> Warping<R> {
    #[inline(always)]
    fn new(g: &Geometry<R>) -> Self {
        // 2 z0/A^2 with z0 = hz/4.
        let c = R::splat(2.0) * g.hz * g.inv_2a * g.inv_2a;
        let (bc1, bc2) = ([c * g.x[0], -(c * g.x[1])], [c * g.y[0], -(c * g.y[1])]);
        let on = |bc: [R; 2], u: [R; 3]| bc[0].mul_add(u[0], bc[1] * u[1]);
        Self { bc1, bc2, on_x: [on(bc1, g.x), on(bc1, g.y), on(bc2, g.y)] }
    }

    /// Curvature increments from displacement increments in the plane, less those of the rigid part of `k`,
    /// which is what remains of it without the strain `e` (xx, yy, xy).
    #[inline(always)]
    fn curvature(&self, u: [[R; 2]; 2], k: [[R; 2]; 2], e: [R; 3]) -> [R; 3] {
        let on = |bc: [R; 2], u: [R; 2]| bc[0].mul_add(u[0], bc[1] * u[1]);
        let [xx, xy, yy] = self.on_x;
        let rigid = [[k[0][0] - e[0], k[0][1] - e[2]], [k[1][0] - e[2], k[1][1] - e[1]]];
        [
            on(self.bc1, u[0]) - on([xx, xy], rigid[0]),
            on(self.bc2, u[1]) - on([xy, yy], rigid[1]),
            on(self.bc2, u[0]) + on(self.bc1, u[1]) - on([xy, yy], rigid[0]) - on([xx, xy], rigid[1]),
        ]
    }
}

impl BelytschkoTsay {
    /// One element in each lane; the reference and the fast kernel are this one function.
    #[inline(always)]
    fn respond<R: PointReal, const N: usize>(&self, modes: &Modes<R>, history: &mut [R], dt: f64) -> Response<R> {
        let (section, own) = history.split_at_mut(self.section.columns());
        let (hourglass, drill) = own[..HOURGLASS + DRILLING].split_at_mut(HOURGLASS);
        let step = R::splat(dt);
        // Nothing has moved before the first step: no time, no rate.
        let per_time = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let [half, quarter] = [0.5, 0.25].map(R::splat);

        // 1. Frame, and everything that moves as seen in it, as increments of the step.
        let g = Geometry::new(&modes.x);
        let u = modes.v.map(|v| g.local(v).map(|c| c * step));
        let t = modes.w.map(|w| g.local(w).map(|c| c * step));

        // 2. Gradients: k[i][j] of displacement i by coordinate j, tx and ty of the rotations.
        let k: [[R; 2]; 3] = std::array::from_fn(|i| g.gradient(u[0][i], u[1][i]));
        let tx = g.gradient(t[0][0], t[1][0]);
        let ty = g.gradient(t[0][1], t[1][1]);

        // 3. Strains.
        let product = |i: usize, j: usize| k[0][i].mul_add(k[0][j], k[1][i].mul_add(k[1][j], k[2][i] * k[2][j]));
        let e_xx = half.neg_mul_add(product(0, 0), k[0][0]);
        let e_yy = half.neg_mul_add(product(1, 1), k[1][1]);
        let e_xy = half * (k[0][1] + k[1][0] - product(0, 1));
        let eps_xy = e_xy.mul_add(e_xx + e_yy, e_xy);
        let xy2 = e_xy * e_xy;
        let eps = [e_xx.mul_add(e_xx, e_xx + xy2), e_yy.mul_add(e_yy, e_yy + xy2), eps_xy + eps_xy];
        let mut kappa = [ty[0], -tx[1], ty[1] - tx[0]];

        // The third column of K, as if I - K were a rotation, and from it the angles that the plane turned by.
        let k_xz = -(k[1][0].mul_add(k[2][1], k[1][1].neg_mul_add(k[2][0], k[2][0])));
        let k_yz = -(k[2][0].mul_add(k[0][1], k[0][0].neg_mul_add(k[2][1], k[2][1])));
        let tilt2 = k_xz.mul_add(k_xz, k_yz * k_yz);
        // 1 - sqrt(1 - tilt2)
        let k_zz = half * tilt2 * quarter.mul_add(tilt2.mul_add(half * tilt2, tilt2), R::splat(1.0));
        let sine = [half * (k[2][0] - k_xz), half * (k[2][1] - k_yz), half * (k[1][0] - k[0][1])];
        let angle = angle_by_sine(dot(sine, sine));
        let gamma = [angle.mul_add(sine[0], quarter * t[3][1]), (-quarter).mul_add(t[3][0], angle * sine[1])];
        let spin = angle * sine[2];

        let warping = if self.warping { Some(Warping::new(&g)) } else { None };
        if let Some(warping) = &warping {
            let plane = [[u[0][0], u[1][0]], [u[0][1], u[1][1]]];
            let more = warping.curvature(plane, [k[0], k[1]], [e_xx, e_yy, e_xy]);
            kappa = std::array::from_fn(|c| kappa[c] + more[c]);
        }

        // 4. Stress.
        let strains = Strains { eps, kappa, gamma };
        let sound = self.section.healthy(&strains, self.section.current_thickness(section));
        let Resultants { n, m, q, work, thickness } = self.section.update::<R, N>(section, &strains, dt);
        let [nx, ny, nxy] = n.map(|n| n * g.area);
        let [mx, my, mxy] = m.map(|m| m * g.area);
        let [qx, qy] = q.map(|q| q * g.area);

        // 5. Hourglass: generalised increments of tx, ty, vz, vx, vy.
        let mut energy = R::zero();
        let rates = [
            g.gamma(t[2][0], tx),
            g.gamma(t[2][1], ty),
            g.gamma(k_zz.neg_mul_add(g.hz, u[2][2]), k[2]),
            g.gamma(k_xz.neg_mul_add(g.hz, u[2][0]), k[0]),
            g.gamma(k_yz.neg_mul_add(g.hz, u[2][1]), k[1]),
        ];
        let stiffness = self.hourglass_stiffness(&g, thickness);
        for c in 0..HOURGLASS {
            let old = hourglass[c];
            let new = match self.hourglass {
                HourglassForm::Viscous => stiffness[c] * rates[c] * R::splat(per_time),
                _ => stiffness[c].mul_add(rates[c], old),
            };
            hourglass[c] = new;
            energy = (old + new).mul_add(rates[c], energy);
        }
        let [hg_tx, hg_ty, hg_z, hg_x, hg_y] = [hourglass[0], hourglass[1], hourglass[2], hourglass[3], hourglass[4]];

        // 6. Drilling: how far nodes turn about n beyond the element. Modes weigh one half and one quarter.
        let stiff = R::splat(0.125 * self.drilling * self.section.elastic.shear_modulus()) * thickness * g.area;
        let ahead = [t[0][2], t[1][2], t[2][2], R::splat(4.0).neg_mul_add(spin, t[3][2])];
        for c in 0..DRILLING {
            let old = drill[c];
            let new = (if c < 2 { stiff } else { half * stiff }).mul_add(ahead[c], old);
            drill[c] = new;
            energy = (old + new).mul_add(ahead[c], energy);
        }

        // 7. Corner forces, mode by mode; a couple that acts on the spin is shared by the in-plane forces.
        let mut couple = R::splat(-4.0) * drill[3];
        let mut extra = [[R::zero(); 2]; 2];
        if let Some(Warping { bc1, bc2, on_x: [xx, xy, yy] }) = &warping {
            couple += xy.mul_add(mx, (*yy - *xx).mul_add(mxy, -(*xy * my)));
            for c in 0..2 {
                extra[c] = [bc1[c].mul_add(mx, bc2[c] * mxy), bc2[c].mul_add(my, bc1[c] * mxy)];
            }
        }
        let couple = half * couple;
        let (hx, hy) = (g.x[2], g.y[2]);
        let fx = g.spread(hx.neg_mul_add(hg_x, nx), hy.neg_mul_add(hg_x, nxy) - couple);
        let fy = g.spread(hx.neg_mul_add(hg_y, nxy) + couple, hy.neg_mul_add(hg_y, ny));
        let fz = g.spread(hx.neg_mul_add(hg_z, g.hz.mul_add(hg_x, qx)), hy.neg_mul_add(hg_z, g.hz.mul_add(hg_y, qy)));
        let mtx = g.spread(-hx.mul_add(hg_tx, mxy), -hy.mul_add(hg_tx, my));
        let mty = g.spread(hx.neg_mul_add(hg_ty, mx), hy.neg_mul_add(hg_ty, mxy));
        let force = [
            g.global([fx[0] + extra[0][0], fy[0] + extra[0][1], fz[0]]),
            g.global([fx[1] + extra[1][0], fy[1] + extra[1][1], fz[1]]),
            g.global([hg_x, hg_y, hg_z]),
        ];
        let moment = [
            g.global([mtx[0], mty[0], drill[0]]),
            g.global([mtx[1], mty[1], drill[1]]),
            g.global([hg_tx, hg_ty, drill[2]]),
            g.global([-(quarter * qy), quarter * qx, drill[3]]),
        ];

        // 8. Health. A sum tells of what is not finite wherever it is.
        let mut total = R::zero();
        for c in 0..3 {
            total += force[0][c].abs() + force[1][c].abs() + force[2][c].abs() + moment[0][c].abs();
            total += moment[1][c].abs() + moment[2][c].abs() + moment[3][c].abs();
        }
        let sound = R::both(R::both(sound, g.convex), total.le(R::splat(f64::MAX)));
        let inv_c = R::splat(1.0 / self.section.elastic.plate_wave_speed());
        let mut response = Response {
            force,
            moment,
            internal: work * g.area,
            hourglass: half * energy,
            stable_dt: g.length * inv_c,
            sound,
        };
        if let Some(failed) = self.section.failed_lanes(section) {
            response.let_go(failed);
            let_go(failed, hourglass);
            let_go(failed, drill);
        }
        response
    }

    /// Coefficients of tx, ty, vz, vx, vy.
    #[inline(always)]
    fn hourglass_stiffness<R: Real>(&self, g: &Geometry<R>, t: R) -> [R; HOURGLASS] {
        let elastic = &self.section.elastic;
        let e = elastic.youngs_modulus;
        let sq = |v: R| v * v;
        let bb = R::splat(2.0) * (sq(g.b1[0]) + sq(g.b1[1]) + sq(g.b2[0]) + sq(g.b2[1]));
        let (t2, tbb) = (t * t, t * bb);
        let theta = R::splat(e / 192.0) * t2 * tbb * g.area;
        let w = R::splat(SHEAR_CORRECTION * elastic.shear_modulus() / 12.0) * t2 * tbb;
        let membrane = R::splat(e / 8.0) * tbb * g.area;
        let r = self.section.hourglass_coefficient;
        let [theta, w, membrane] = match self.hourglass {
            HourglassForm::Viscous => {
                let mass = R::splat(elastic.density) * t * g.area;
                let radius2 = Real::max(t2 * R::splat(1.0 / 12.0), R::splat(INERTIA_FLOOR) * g.area);
                let damping = |k: R, m: R| R::splat(0.5 * r) * (k * m).sqrt();
                [damping(theta, mass * radius2), damping(w, mass), damping(membrane, mass)]
            }
            _ => [theta, w, membrane].map(|k| R::splat(r) * k),
        };
        [theta, theta, w, membrane, membrane]
    }

    /// All groups of a range. N is the number of points.
    fn pass<const N: usize>(&self, pass: Pass<'_>) -> PassTotals {
        let dt = pass.dt;
        pass.shells(self.columns(), |group, nodes, history, force, moment| {
            let response = self.respond::<Lane, N>(&gather(group, nodes), history, dt);
            scatter(&response, force, moment);
            GroupTotals {
                stable_dt: response.stable_dt,
                internal: response.internal,
                hourglass: response.hourglass,
                sound: response.sound,
            }
        })
    }
}

/// Corner values of a group as modes. Differences are taken row by row, before the rows become lanes.
#[inline(always)]
fn gather(group: &GroupNodes<4>, nodes: &NodeView<'_>) -> Modes<Lane> {
    // One length for all three columns: one check for each node.
    let n = nodes.x.len();
    let (x, v, w) = (&nodes.x[..n], &nodes.v[..n], &nodes.w[..n]);
    let zero = Lane::splat(0.0);
    let (mut mx, mut mv, mut mw) = ([[zero; LANES]; 3], [[zero; LANES]; 3], [[zero; LANES]; 4]);
    for lane in 0..LANES {
        let corner: [usize; 4] = std::array::from_fn(|c| group[c][lane] as usize);
        let modes = |column: &[[f64; 4]]| {
            let [a, b, c, d] = corner.map(|node| Lane::new(column[node]));
            [a - c, b - d, (a + c) - (b + d), (a + c) + (b + d)]
        };
        let rows = modes(x);
        (mx[0][lane], mx[1][lane], mx[2][lane]) = (rows[0], rows[1], h_from_sides(x, corner));
        let rows = modes(v);
        (mv[0][lane], mv[1][lane], mv[2][lane]) = (rows[0], rows[1], rows[2]);
        let rows = modes(w);
        (mw[0][lane], mw[1][lane], mw[2][lane], mw[3][lane]) = (rows[0], rows[1], rows[2], rows[3]);
    }
    Modes { x: mx.map(components), v: mv.map(components), w: mw.map(components) }
}

/// Mode h of coordinates from differences of neighbours, which are small: `(1 - 2) + (3 - 4)`.
#[inline(always)]
fn h_from_sides(x: &[[f64; 4]], corner: [usize; 4]) -> Lane {
    let [a, b, c, d] = corner.map(|node| Lane::new(x[node]));
    (a - b) + (c - d)
}

/// The three components of rows that hold one vector each.
#[inline(always)]
fn components(rows: [Lane; LANES]) -> [Lane; 3] {
    let [x, y, z, _] = Lane::transpose(rows);
    [x, y, z]
}

/// Modes to corners, lanes to rows.
#[inline(always)]
fn scatter(response: &Response<Lane>, force: &mut [[f64; 4]; LANES * 4], moment: &mut [[f64; 4]; LANES * 4]) {
    let rows = |v: [Lane; 3]| Lane::transpose([v[0], v[1], v[2], Lane::splat(0.0)]);
    let [f13, f24, fh] = response.force.map(rows);
    let [m13, m24, mh, ms] = response.moment.map(rows);
    for lane in 0..LANES {
        let slot = 4 * lane;
        force[slot] = (fh[lane] + f13[lane]).to_array();
        force[slot + 1] = (f24[lane] - fh[lane]).to_array();
        force[slot + 2] = (fh[lane] - f13[lane]).to_array();
        force[slot + 3] = (-(f24[lane] + fh[lane])).to_array();
        let (even, odd) = (ms[lane] + mh[lane], ms[lane] - mh[lane]);
        moment[slot] = (even + m13[lane]).to_array();
        moment[slot + 1] = (odd + m24[lane]).to_array();
        moment[slot + 2] = (even - m13[lane]).to_array();
        moment[slot + 3] = (odd - m24[lane]).to_array();
    }
}

/// Modes 13, 24 and h of the corners of one element.
fn coordinate_modes(x: &[[f64; 3]; 4]) -> [[f64; 3]; 3] {
    let mode = |f: &dyn Fn(usize) -> f64| std::array::from_fn(f);
    [mode(&|i| x[0][i] - x[2][i]), mode(&|i| x[1][i] - x[3][i]), mode(&|i| (x[0][i] - x[1][i]) + (x[2][i] - x[3][i]))]
}

impl Element for BelytschkoTsay {
    fn columns(&self) -> usize {
        self.section.columns() + HOURGLASS + DRILLING
    }

    fn start(&self, history: &mut [Lane]) {
        self.section.start(history);
    }

    fn corner_mass(&self, x: &[[f64; 3]]) -> (f64, f64) {
        let area = Geometry::new(&coordinate_modes(four(x))).area;
        let mass = 0.25 * self.section.elastic.density * self.section.thickness * area;
        (mass, mass * self.section.inertia_per_mass(area))
    }

    fn forces(&self, pass: Pass<'_>) -> PassTotals {
        with_points!(self.section.points, N => self.pass::<N>(pass))
    }

    fn stable_dt(&self, x: &[[f64; 3]]) -> f64 {
        let geometry = Geometry::new(&coordinate_modes(four(x)));
        if !geometry.convex {
            return f64::NAN;
        }
        geometry.length / self.section.elastic.plate_wave_speed()
    }

    fn failed(&self, history: &[Lane], lane: usize) -> bool {
        self.section.has_failed(history, lane)
    }

    fn fields(&self, history: &[Lane], lane: usize, x: &[[f64; 3]]) -> ElementFields {
        let Geometry { e1, e2, n, .. } = Geometry::new(&coordinate_modes(four(x)));
        self.section.fields(history, lane, &[e1, e2, n])
    }
}

#[cfg(test)]
#[path = "belytschko_tsay_tests.rs"]
mod tests;
