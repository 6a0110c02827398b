//! Eight-node thick shell with one point in its plane and several through its thickness.
//!
//! Nodes 1 to 4 are one face and 5 to 8 the other one. With `m_k = (x_k + x_(k+4))/2` the middle
//! surface, `d_k = x_(k+4) - x_k` the directors, d their mean, A and B1, B2 the area and the
//! gradients of the quad of the m_k (`quad.rs`), n its normal and `h = d.n` the thickness, the
//! element has, in the axes of that quad, the mean gradient of the increments u of a step
//! ```text
//! G_i1 = B1 m_i(u),  G_i2 = B2 m_i(u),  G_i3 = mean d_i(u)/h - G_i1 d_1/h - G_i2 d_2/h
//! eps = sym G (1, 2),   gamma = [G_13 + G_31, G_23 + G_32]
//! kappa t = sym E (1, 2),   E_ia = Ba d_i(u - G x)
//! ```
//! u is the difference of the coordinates after and before the step, each in the axes of its time,
//! so that a rigid motion of any size has u = 0; gradients are those in the middle of the step. The
//! law is in plane stress at each point through the thickness (`section/mod.rs`). The thickness t
//! of the law follows its strain, and a stress holds the faces at that distance:
//! ```text
//! sig_3 = C (h/t - t/h)/2,   C = lambda + 2 mu,   N += b sig_3 h I,   b = nu/(1 - nu)
//! ```
//! The elastic thickness strain of a law is -b tr eps, so that both terms have one potential
//! (layers that differ in nu have one nearly), and elastic elements have exactly the stiffness of
//! the solid, without locking of the thickness in bending. (C is that at nu = 0.4 at most, or the
//! step would vanish.) The stress sig_3 has no part in the yield condition: the element is for
//! sheets, not for lumps, as the plane stress form of thick shells in the LS-DYNA Theory Manual
//! (eight-node solid shell). Laws that are not isotropic keep the thickness of the start, with b =
//! 0.
//!
//! G is exact for linear fields in elements of any shape, and all other motions are those of
//! `u - G x`. Apart from kappa these are nine, with the forces
//! ```text
//! h of m_1, m_2        r E t A BB/8              h of d_1, d_2     r E t A BB/96
//! h of m_3             r 5/6 G t T2 BB/12        h of d_3          s E A/(144 h)
//! E_31, E_32           s E A/(12 h BBa)
//! (E_21 - E_12)/2      r 5/6 G A/(6 h max(BB1, BB2))
//! ```
//! per unit, with BBa = Ba Ba, BB = BB1 + BB2 and T2 the smaller one of t^2 and A; the coefficient
//! is r, and s = 1/4. For r = s = 1 they are about those of full integration in a square, and in no
//! rectangle their frequencies are above those of the strains. In plastic parts the first five are
//! bounded as in `belytschko_tsay.rs`.
//!
//! Forces follow from virtual power: with the forces P_I on `u - G x` and T on G,
//! `f_I = P_I + (T - sum_J P_J x_J') b_I`, b_I the gradient that G has of node I. As `sum x_I b_I'`
//! is the unit tensor and T is symmetric, all forces balance, and so do their moments.
//!
//! Stable step, with m/8 at each node. Strain at any depth lies between those of the faces, so the
//! frequency of membrane and bending is at most that of a quad of the same mass per area. Of shear,
//! of thickness and of the volume in the plane it is
//! ```text
//! omega_s^2 = (10/3) (G/rho) (S + 1/h^2),   omega_t^2 = 4 C/(rho h^2),
//! omega_v^2 = 4 b^2 C BB/rho
//! ```
//! with S the larger principal value of `sum b_I b_I'` over the quad. In a plate of one thickness
//! membrane, shear and thickness have no node component in common. Membrane and thickness are
//! coupled by b alone: the larger eigenvalue of `[p + v, sqrt(v t); sqrt(v t), t]`, with these
//! squares, bounds them, and the larger one of it and shear counts. In other shapes the motions
//! have components in common: with T the sum of the norms of their slopes, the bound is
//! `(max + T sum) (1 + T)^2`.

use super::belytschko_tsay::BOUNDS;
use super::kinematics::Frame;
use super::pass::GroupCorners;
use super::quad::{DRILLING, HOURGLASS, QuadGeometry};
use super::section::{Resultants, SHEAR_CORRECTION, Section, Strains};
use super::solid::{STRAIN_LIMIT, SolidMaterial, each, gather, relative, scatter};
use super::{
    Constructor, Element, ElementEntry, ElementFields, ElementPass, ElementResult, GroupNodes,
    PassTotals, PointFields, SolidGroups, Totals, parameters, with_points, zero_failed,
};
use crate::columns::ElementState;
use crate::materials::{Elastic, PlaneStress, PointLanes, PointReal};
use crate::nodes::NodeView;
use crate::parameter::Values;
use crumple_math::lanes::{Each, Real, dot};
use crumple_proto::job::Part;
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::problem::Problem;

/// Name of this element in jobs.
pub const THICK_SHELL: &str = "thick_shell";

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: THICK_SHELL,
    meaning: "Thick shell of eight nodes: one in-plane point, plane stress at points through the \
              thickness, from the face of the first four nodes to the other one.",
    shape: Shape::Hex8,
    parameters: [
        parameters::OF_THICK_SHELLS,
        &[parameters::coefficient_of_shell(
            0.03,
            "Hourglass coefficient: fraction of the stiffness of the element.",
        )],
    ],
    idle: |_| &[],
    build: Constructor::Shell(build),
};

const NODES: usize = 8;
/// Number of its own columns, and their places: hourglass forces on the directors by the thickness
/// [force length] and on the middle surface [force] as in `belytschko_tsay.rs`; force on h of d_3
/// [force]; forces on E_31, E_32 and the spin of the faces [force length]; sig_3 [force/length^2].
const OWN: usize = 10;
const OF_DIRECTORS: usize = HOURGLASS;
const TAPER: usize = OF_DIRECTORS + 1;
const SPIN: usize = TAPER + 2;
const THICKNESS: usize = SPIN + 1;
/// Poisson's ratio at which C is that of the solid at most.
const LARGEST_POISSON: f64 = 0.4;
/// s.
const THICKNESS_SHARE: f64 = 0.25;

/// Parameters of the thick shell.
pub struct ThickShell {
    section: Section,
    /// r.
    hourglass_coefficient: f64,
    /// C [force/length^2] and b.
    across: f64,
    contraction: f64,
}

fn build(part: &Part, values: &Values<'_>, law: Box<dyn PlaneStress>) -> ElementResult {
    let mut problems = Vec::new();
    let mut refuse = |given: bool, key: &str, why: &str| {
        if given {
            let message = format!("part {}: {key} is not for thick shells: {why}", part.label());
            problems.push(Problem::error(key, message, "remove it"));
        }
    };
    refuse(part.thickness != 0.0, "thickness", "their nodes give it");
    refuse(part.offset != 0.0, "offset", "their middle surface is between their nodes");
    // The thickness of each element replaces it.
    let sheet = Part { thickness: 1.0, offset: 0.0, ..part.clone() };
    let section = match Section::new(&sheet, values, law) {
        Ok(section) if problems.is_empty() => section,
        Ok(_) => return Err(problems),
        Err(found) => return Err([problems, found].concat()),
    };
    let section = if section.is_isotropic() { section } else { section.without_thinning() };
    let nu = section.elastic.poisson;
    let limited = Elastic { poisson: nu.min(LARGEST_POISSON), ..section.elastic };
    Ok(Box::new(ThickShell {
        hourglass_coefficient: values.number("hourglass_coefficient"),
        across: limited.lame() + 2.0 * limited.shear_modulus(),
        contraction: if section.is_thinning() { nu / (1.0 - nu) } else { 0.0 },
        section,
    }))
}

/// Values of a vector field at the nodes, as modes: 1 - 3, 2 - 4 and h of the middle surface; these
/// and the sum of the directors.
#[derive(Clone, Copy)]
struct ShellModes<R> {
    middle: [[R; 3]; 3],
    director: [[R; 3]; 4],
}

impl<R: Real> ShellModes<R> {
    #[inline(always)]
    fn new(f: &[[R; 3]; NODES]) -> Self {
        let half = R::splat(0.5);
        let middle: [[R; 3]; 4] = std::array::from_fn(|k| each(|i| half * (f[k][i] + f[k + 4][i])));
        let director: [[R; 3]; 4] = std::array::from_fn(|k| each(|i| f[k + 4][i] - f[k][i]));
        let modes = |c: &[[R; 3]; 4]| {
            [
                each(|i| c[0][i] - c[2][i]),
                each(|i| c[1][i] - c[3][i]),
                each(|i| (c[0][i] - c[1][i]) + (c[2][i] - c[3][i])),
            ]
        };
        let [d13, d24, dh] = modes(&director);
        let sum = each(|i| (director[0][i] + director[1][i]) + (director[2][i] + director[3][i]));
        Self { middle: modes(&middle), director: [d13, d24, dh, sum] }
    }

    /// Returns the components in the axes of a frame.
    #[inline(always)]
    fn local(&self, frame: &Frame<R>) -> Self {
        Self {
            middle: self.middle.map(|v| frame.local(v)),
            director: self.director.map(|v| frame.local(v)),
        }
    }

    /// Returns `a` of these modes plus `b` of others.
    #[inline(always)]
    fn combined(&self, a: R, other: &Self, b: R) -> Self {
        let sum = |x: [R; 3], y: [R; 3]| each(|i| a.mul_add(x[i], b * y[i]));
        Self {
            middle: std::array::from_fn(|m| sum(self.middle[m], other.middle[m])),
            director: std::array::from_fn(|m| sum(self.director[m], other.director[m])),
        }
    }

    /// Returns the forces of the nodes from those on these modes.
    #[inline(always)]
    fn nodes(&self, frame: &Frame<R>) -> [[R; 3]; NODES] {
        let half = R::splat(0.5);
        let [m13, m24, mh] = frame.to_global(self.middle);
        let [d13, d24, dh, sum] = frame.to_global(self.director);
        let corner = |k: usize, [a, b, h]: [[R; 3]; 3], i: usize| match k {
            0 => a[i] + h[i],
            1 => b[i] - h[i],
            2 => h[i] - a[i],
            _ => -(b[i] + h[i]),
        };
        std::array::from_fn(|node| {
            let (k, upper) = (node % 4, node >= 4);
            each(|i| {
                let middle = half * corner(k, [m13, m24, mh], i);
                let director = sum[i] + corner(k, [d13, d24, dh], i);
                if upper { middle + director } else { middle - director }
            })
        })
    }
}

/// Shape of an element, from the modes of its coordinates in its own axes.
struct ThickShape<R> {
    at: ShellModes<R>,
    area: R,
    /// B1 and B2 at corners 1 and 2; corners 3 and 4 have their negatives [1/length].
    b1: [R; 2],
    b2: [R; 2],
    /// h [length] and its reciprocal; d_1/h and d_2/h.
    height: R,
    inverse_height: R,
    tilt: [R; 2],
}

/// Motion of a step: G, then `u - G x`: h of the middle surface, E, h of the directors.
struct ThickMotion<R> {
    g: [[R; 3]; 3],
    h: [R; 3],
    e: [[R; 2]; 3],
    director_h: [R; 3],
}

/// Forces on the motions of [`ThickMotion`].
struct ThickForces<R> {
    g: [[R; 3]; 3],
    h: [R; 3],
    e: [[R; 2]; 3],
    director_h: [R; 3],
}

impl<R: Real> ThickShape<R> {
    #[inline(always)]
    fn new(at: ShellModes<R>) -> Self {
        let half = R::splat(0.5);
        let [x13, x24, _] = at.middle;
        let two_a = x13[0].mul_add(x24[1], -(x13[1] * x24[0]));
        let inv_2a = R::splat(1.0) / two_a;
        let height = R::splat(0.25) * at.director[3][2];
        let inverse_height = R::splat(1.0) / height;
        let quarter = R::splat(0.25) * inverse_height;
        Self {
            area: half * two_a,
            b1: [x24[1] * inv_2a, -(x13[1] * inv_2a)],
            b2: [-(x24[0] * inv_2a), x13[0] * inv_2a],
            height,
            inverse_height,
            tilt: [quarter * at.director[3][0], quarter * at.director[3][1]],
            at,
        }
    }

    /// Returns B1 and B2 applied to a column with the modes u13 and u24.
    #[inline(always)]
    fn gradient(&self, u13: R, u24: R) -> [R; 2] {
        [self.b1[0].mul_add(u13, self.b1[1] * u24), self.b2[0].mul_add(u13, self.b2[1] * u24)]
    }

    /// Returns the modes 13 and 24 of `B1_I s1 + B2_I s2`.
    #[inline(always)]
    fn spread(&self, [s1, s2]: [R; 2]) -> [R; 2] {
        [self.b1[0].mul_add(s1, self.b2[0] * s2), self.b1[1].mul_add(s1, self.b2[1] * s2)]
    }

    /// Returns the sums of the squares of B1 and of B2 over the corners [1/length^2].
    #[inline(always)]
    fn squares(&self) -> [R; 2] {
        let of = |b: [R; 2]| R::splat(2.0) * b[0].mul_add(b[0], b[1] * b[1]);
        [of(self.b1), of(self.b2)]
    }

    /// Returns the motion of the increments `u`.
    #[inline(always)]
    fn motion(&self, u: &ShellModes<R>) -> ThickMotion<R> {
        let quarter = R::splat(0.25) * self.inverse_height;
        let g: [[R; 3]; 3] = each(|i| {
            let [g1, g2] = self.gradient(u.middle[0][i], u.middle[1][i]);
            let tilted = self.tilt[0].mul_add(g1, self.tilt[1] * g2);
            [g1, g2, quarter.mul_add(u.director[3][i], -tilted)]
        });
        let rest = |u: [R; 3], x: [R; 3]| each(|i| u[i] - dot(g[i], x));
        let director: [[R; 3]; 3] =
            std::array::from_fn(|m| rest(u.director[m], self.at.director[m]));
        ThickMotion {
            g,
            h: rest(u.middle[2], self.at.middle[2]),
            e: each(|i| self.gradient(director[0][i], director[1][i])),
            director_h: director[2],
        }
    }

    /// Returns the forces on the modes of the nodes.
    #[inline(always)]
    fn forces(&self, on: &ThickForces<R>) -> ShellModes<R> {
        let quarter = R::splat(0.25) * self.inverse_height;
        let mut forces = ShellModes {
            middle: [[R::zero(); 3], [R::zero(); 3], on.h],
            director: [[R::zero(); 3], [R::zero(); 3], on.director_h, [R::zero(); 3]],
        };
        for i in 0..3 {
            let [d13, d24] = self.spread(on.e[i]);
            (forces.director[0][i], forces.director[1][i]) = (d13, d24);
            let of_rest = |j: usize| {
                let [x13, x24, xh, _] = self.at.director;
                d13.mul_add(
                    x13[j],
                    d24.mul_add(
                        x24[j],
                        on.director_h[i].mul_add(xh[j], on.h[i] * self.at.middle[2][j]),
                    ),
                )
            };
            let on_g: [R; 3] = each(|j| on.g[i][j] - of_rest(j));
            let [m13, m24] =
                self.spread([0, 1].map(|a| self.tilt[a].neg_mul_add(on_g[2], on_g[a])));
            (forces.middle[0][i], forces.middle[1][i]) = (m13, m24);
            forces.director[3][i] = quarter * on_g[2];
        }
        forces
    }

    /// Returns T: the norms of the slopes of the directors, of their mean and of the warp.
    #[inline(always)]
    fn slopes(&self) -> R {
        let [bb1, bb2] = self.squares();
        let warp = self.at.middle[2][2].abs() * (bb1 + bb2).sqrt();
        let [t1, t2] = self.tilt;
        let mut square = R::zero();
        for i in 0..3 {
            let [s1, s2] = self.gradient(self.at.director[0][i], self.at.director[1][i]);
            square = s1.mul_add(s1, s2.mul_add(s2, square));
        }
        square.sqrt() + t1.mul_add(t1, t2 * t2).sqrt() + warp
    }
}

/// A thick shell with N points through the thickness.
struct ThickShellWithPoints<'a, const N: usize>(&'a ThickShell);

impl ThickShell {
    /// Returns the volume of an element at the start, from the columns of its section [length^3].
    fn volume<R: Real>(&self, columns: &[R]) -> R {
        self.section.volume_at_start(columns)
    }

    /// Returns the stable step of an element with this volume at the start [length^3] and this
    /// thickness of the law [length], at any density of the material [time].
    #[inline(always)]
    fn step<R: Real>(&self, quad: &QuadGeometry<R>, shape: &ThickShape<R>, volume: R, t: R) -> R {
        let [one, half] = [1.0, 0.5].map(R::splat);
        let elastic = &self.section.elastic;
        let [h, inverse] = [shape.height, shape.inverse_height];
        // Squared frequencies over 4.
        let plane = quad.stable_dt(&self.section, 1.0);
        let plane = shape.area * t / (volume * plane * plane);
        let [bb1, bb2] = shape.squares();
        let inv_area = one / shape.area;
        let root = Real::max(
            (bb1 + bb2).mul_add(bb1 + bb2, R::splat(-4.0) * inv_area * inv_area),
            R::zero(),
        )
        .sqrt();
        let s = half * (bb1 + bb2 + root);
        let per_mass = shape.area / (R::splat(elastic.density) * volume);
        let modulus = R::splat(SHEAR_CORRECTION * self.section.largest_shear_modulus());
        let shear = modulus * per_mass * t * (s + inverse * inverse);
        let across = R::splat(0.5 * self.across) * per_mass * (one / t + t * inverse * inverse);
        let in_plane = R::splat(self.across * self.contraction * self.contraction)
            * (per_mass * t * (bb1 + bb2));
        let [sum, difference] = [plane + in_plane + across, plane + in_plane - across];
        let coupled =
            half * (sum + difference.mul_add(difference, R::splat(4.0) * in_plane * across).sqrt());
        let slopes = shape.slopes();
        let bound = slopes.mul_add(sum + shear, Real::max(coupled, shear));
        let valid = h.gt(R::zero());
        R::select(valid, one / (bound.sqrt() * (one + slopes)), R::zero())
    }

    /// Computes one element in each lane, from coordinates and velocities relative to node 0.
    #[inline(always)]
    fn respond<R: PointReal, const N: usize>(
        &self,
        x: &[[R; 3]; NODES],
        v: &[[R; 3]; NODES],
        history: &mut [R],
        dt: f64,
    ) -> ([[R; 3]; NODES], Totals<R>) {
        let [half, zero] = [0.5, 0.0].map(R::splat);
        let (section, own) = history.split_at_mut(self.section.columns());
        let own = &mut own[..OWN];

        // 1. Motion of the step, in axes that move with the element.
        let back = R::splat(dt);
        let before: [[R; 3]; NODES] =
            std::array::from_fn(|n| each(|i| back.neg_mul_add(v[n][i], x[n][i])));
        let [now, before] = [x, &before].map(ShellModes::new);
        let quad = QuadGeometry::new(&now.middle);
        let first = QuadGeometry::new(&before.middle);
        let [now, before] = [now.local(&quad.frame), before.local(&first.frame)];
        let u = now.combined(R::splat(1.0), &before, R::splat(-1.0));
        let middle = ThickShape::new(now.combined(half, &before, half));
        let motion = middle.motion(&u);
        let shape = ThickShape::new(now);

        // 2. Stress.
        let t = self.section.current_thickness(section);
        let per_thickness = R::splat(1.0) / t;
        let (g, e) = (&motion.g, &motion.e);
        let strains = Strains {
            eps: [g[0][0], g[1][1], g[0][1] + g[1][0]],
            kappa: [e[0][0], e[1][1], e[0][1] + e[1][0]].each(|c| c * per_thickness),
            gamma: [g[0][2] + g[2][0], g[1][2] + g[2][1]],
        };
        let within = R::both(
            self.section.sound_points(&strains, t),
            g[2][2].abs().le(R::splat(STRAIN_LIMIT)),
        );
        let Resultants { n, m, q, work, .. } = self.section.update::<R, N>(section, &strains, dt);
        let thin = self.section.current_thickness(section);
        let stable_dt = self.step(&quad, &shape, self.volume(section), thin);
        let area = shape.area;
        let (n, m, q) =
            (n.each(|c| c * area), m.each(|c| c * (area * per_thickness)), q.each(|c| c * area));
        let ratio = shape.height / thin;
        let across = R::splat(0.5 * self.across) * (ratio - thin * shape.inverse_height);
        let contraction = R::splat(self.contraction);
        let drawn = contraction.mul_add(g[0][0] + g[1][1], g[2][2]);
        let mean = half * (own[THICKNESS] + across);
        let internal = middle.area * (mean * middle.height).mul_add(drawn, work);
        own[THICKNESS] = across;
        let across = across * (area * shape.height);
        let n = [contraction.mul_add(across, n[0]), contraction.mul_add(across, n[1]), n[2]];

        // 3. Stabilising forces. Twice the energy is the work of old and new forces.
        let rates = [
            motion.director_h[0] * per_thickness,
            motion.director_h[1] * per_thickness,
            motion.h[2],
            motion.h[0],
            motion.h[1],
            motion.director_h[2],
            e[2][0],
            e[2][1],
            half * (e[1][0] - e[0][1]),
        ];
        let stiffness = self.stiffness(&middle, half * (t + thin));
        let mut energy = zero;
        for c in 0..THICKNESS {
            let old = own[c];
            own[c] = stiffness[c].mul_add(rates[c], old);
            energy = (old + own[c]).mul_add(rates[c], energy);
        }
        let mut none = [zero; DRILLING];
        let increments = none;
        let lost = BOUNDS.apply::<R, N>(
            (&self.section, section),
            (own, &mut none),
            (&rates, &increments),
            thin,
            ([area; HOURGLASS], area),
        );
        let hourglass = half * (energy + lost);

        // 4. Forces of the nodes.
        let by_thickness = |c: usize| own[c] * per_thickness;
        let spin = half * own[SPIN];
        let forces = shape.forces(&ThickForces {
            g: [[n[0], n[2], q[0]], [n[2], n[1], q[1]], [q[0], q[1], across]],
            h: [own[3], own[4], own[2]],
            e: [[m[0], m[2] - spin], [m[2] + spin, m[1]], [own[TAPER], own[TAPER + 1]]],
            director_h: [by_thickness(0), by_thickness(1), own[OF_DIRECTORS]],
        });
        let mut force = forces.nodes(&quad.frame);

        // 5. Validity. The sum is not finite if any of its terms is not.
        let mut nothing = zero;
        for c in force.as_flattened() {
            nothing = c.mul_add(zero, nothing);
        }
        let calm = R::both(R::both(within, quad.has_area), shape.height.gt(zero));
        let sound = R::both(calm, nothing.le(zero));
        let mut totals = Totals { stable_dt, internal, hourglass, sound };
        if let Some(failed) = self.section.failed_lanes(section) {
            zero_failed(failed, force.as_flattened_mut());
            zero_failed(failed, own);
            totals.zero_failed(failed);
        }
        if self.section.deletes {
            let moves = || {
                let all = x.as_flattened().iter().chain(v.as_flattened());
                all.fold(zero, |sum, c| sum + c.abs())
            };
            let gone = self.section.delete_inverted(history, calm, sound, moves);
            zero_failed(gone, force.as_flattened_mut());
            totals.zero_failed(gone);
        }
        (force, totals)
    }

    /// Returns the stiffnesses of the stabilising forces, in the order of their columns.
    #[inline(always)]
    fn stiffness<R: Real>(&self, shape: &ThickShape<R>, t: R) -> [R; THICKNESS] {
        let stabilising = &self.section.stabilising;
        let (e, r) = (stabilising.youngs_modulus, self.hourglass_coefficient);
        let shear = r * SHEAR_CORRECTION * self.section.transverse_modulus;
        let [bb1, bb2] = shape.squares();
        let (bb, t2) = (bb1 + bb2, t * t);
        let membrane = R::splat(r * e / 8.0) * t * shape.area * bb;
        let bending = R::splat(1.0 / 12.0) * t2 * membrane;
        let twist = R::splat(shear / 12.0) * Real::min(t2, shape.area) * t * bb;
        let per_height = shape.area * shape.inverse_height;
        let across = R::splat(THICKNESS_SHARE * e / 144.0) * per_height;
        let taper = R::splat(12.0) * across;
        let [inv1, inv2] = [bb1, bb2].map(|bb| R::splat(1.0) / bb);
        let spin = R::splat(shear / 6.0) * per_height * Real::min(inv1, inv2);
        [bending, bending, twist, membrane, membrane, across, taper * inv1, taper * inv2, spin]
    }

    /// Returns quad and shape of an element with these slots.
    fn shape(x: &[[f64; 3]]) -> (QuadGeometry<f64>, ThickShape<f64>) {
        let modes = ShellModes::new(&relative(x));
        let quad = QuadGeometry::new(&modes.middle);
        let shape = ThickShape::new(modes.local(&quad.frame));
        (quad, shape)
    }

    fn axes(x: &[[f64; 3]]) -> [[f64; 3]; 3] {
        let Frame { e1, e2, n } = Self::shape(x).0.frame;
        [e1, e2, n]
    }
}

impl<const N: usize> SolidGroups<NODES> for ThickShellWithPoints<'_, N> {
    fn material(&self) -> Option<(&SolidMaterial, usize)> {
        None
    }

    fn section(&self) -> Option<&Section> {
        Some(&self.0.section)
    }

    #[inline(always)]
    fn group<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<NODES, W>,
        nodes: &NodeView<'_>,
        history: &mut [L],
        dt: f64,
        force: &mut GroupCorners<NODES, W>,
    ) -> Totals<L> {
        let [x, v] = gather(group, [nodes.x, nodes.v]);
        let (forces, totals) = self.0.respond::<L, N>(&x, &v, history, dt);
        scatter(forces, force);
        totals
    }

    #[inline(never)]
    fn forceless<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<NODES, W>,
        nodes: &NodeView<'_>,
        history: &mut [L],
    ) -> Totals<L> {
        let [x, _] = gather(group, [nodes.x, nodes.v]);
        let modes = ShellModes::new(&x);
        let quad = QuadGeometry::new(&modes.middle);
        let shape = ThickShape::new(modes.local(&quad.frame));
        let t = self.0.section.current_thickness(history);
        let stable_dt = self.0.step(&quad, &shape, self.0.volume(history), t);
        Totals::inactive(stable_dt, L::both(quad.has_area, shape.height.gt(L::zero())))
    }
}

impl Element for ThickShell {
    fn columns(&self) -> usize {
        self.section.columns() + OWN + usize::from(self.section.deletes)
    }

    fn names(&self) -> Vec<String> {
        let own = [
            "hourglass dx",
            "hourglass dy",
            "hourglass z",
            "hourglass x",
            "hourglass y",
            "hourglass dz",
            "taper 1",
            "taper 2",
            "spin of faces",
            "thickness force",
        ];
        let deleted = self.section.deletes.then_some("deleted");
        let own = own.into_iter().chain(deleted).map(String::from);
        self.section.names().into_iter().chain(own).collect()
    }

    fn measure(&self, history: &mut [f64], x: &[[f64; 3]], own: OwnSection) {
        let (_, shape) = Self::shape(x);
        let own = OwnSection { thickness: shape.height, offset: None, ..own };
        self.section.start(history, own);
        self.section.measure(history, own, shape.area, 0.0);
        let side = each(|i| x[1][i] - x[0][i]);
        self.section.orient(history, own, &Self::axes(x), side);
    }

    fn corner_mass(&self, x: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        let (_, shape) = Self::shape(x);
        let mass = self.section.elastic.density * shape.area * shape.height;
        (mass / NODES as f64, 0.0)
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        let columns = self.columns();
        // Other numbers of points are rare: they share a kernel, which is slower.
        with_points!(
            self.section.points,
            N => pass.double_solids(columns, &ThickShellWithPoints::<N>(self)); 2 3 5
        )
    }

    fn is_unstrained(&self, history: ElementState<'_>) -> bool {
        self.section.is_unstrained(history)
    }

    fn stable_dt(&self, x: &[[f64; 3]], _: OwnSection) -> f64 {
        let (quad, shape) = Self::shape(x);
        if !quad.has_area || shape.height.is_nan() || shape.height <= 0.0 {
            return f64::NAN;
        }
        self.step(&quad, &shape, shape.area * shape.height, shape.height)
    }

    fn stable_dt_now(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> f64 {
        let (quad, shape) = Self::shape(x);
        if !quad.has_area || shape.height.is_nan() || shape.height <= 0.0 {
            return f64::NAN;
        }
        let columns = history.to_vec();
        let t = self.section.current_thickness(&columns);
        self.step(&quad, &shape, self.volume(&columns), t)
    }

    fn single_element_step(&self) -> f64 {
        super::quad::ALONE
    }

    fn failed(&self, history: ElementState<'_>) -> bool {
        self.section.has_failed(history) || self.is_deleted(history)
    }

    fn is_deleted(&self, history: ElementState<'_>) -> bool {
        self.section.deletes && history.at(self.columns() - 1) > 0.5
    }

    fn can_fail(&self) -> bool {
        self.section.can_fail()
    }

    fn fields(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> ElementFields {
        let axes = Self::axes(x);
        let fields = self.section.fields(history, &axes);
        let across = history.at(self.section.columns() + THICKNESS);
        let stress = std::array::from_fn(|c| {
            let [i, j] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]][c];
            let plane = axes[0][i] * axes[0][j] + axes[1][i] * axes[1][j];
            let more = axes[2][i] * axes[2][j] + self.contraction * plane;
            across.mul_add(more, fields.stress[c])
        });
        ElementFields { stress, failed: self.failed(history), ..fields }
    }

    fn points(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> Vec<PointFields> {
        self.section.point_fields(history, &Self::axes(x))
    }
}

#[cfg(test)]
#[path = "thick_shell_tests.rs"]
mod tests;
