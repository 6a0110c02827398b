//! Three-node C0 shell of Belytschko, Stolarski & Carpenter 1984 with one point in its plane.
//!
//! Frame at x(t): normal along `r21 x r31`, and e1 along `sqrt(3) s1 + n x (s3 - s2)` with s1, s2,
//! s3 the sides from corner 1 on. This is the polar rotation of the map from the equilateral
//! triangle, so it rotates with the material, and numbering an element from another corner only
//! rotates its axes by 120 degrees.
//!
//! Membrane strains are constant, finite and logarithmic as in the four-node shell. So are
//! curvatures, `kappa = dt [B1 ty, -B2 tx, B2 ty - B1 tx]`. Transverse shear is interpolated from
//! the tangential shear of the three edges, at the centroid. With b = (ty, -tx), its mean bm,
//! `b21 = b2 - b1` and so on:
//! ```text
//! gamma = grad w + bm + grad applied to the edge values
//!         ([b21 (x21 - x31) - b31 x21] / 6,  [b31 (x31 - x21) - b21 x31] / 6)
//! ```
//! This is the matrix of the 1984 paper, and MITC3 (Lee & Bathe 2004) at its centroid: a test
//! compares them.
//!
//! One of the nine bending unknowns then has no stiffness: `c = (b31 x21 - b21 x31)/2`, a spin of
//! the fibres about the centroid. In MITC3 it causes the shear strain `c/2A (y, -x)` with stiffness
//! `5/6 G t (sum of squared sides)/(144 A)`; `hourglass_coefficient` is the fraction of it that is
//! used, always in stiffness form. c is zero for rigid motion and for any constant curvature.
//!
//! Drilling: stiffness `alpha G t A/3` per node on its spin about n relative to that of the
//! element.
//!
//! The stable step is [`Section::stable_dt`] from 2/omega of the free element in its membrane
//! modes, which is exact: with nodal mass m/3 and `b = B B'` (2 x 2),
//! `omega^2 = 3 c^2 (tr b + sqrt(tr^2 b - 4 (1-nu^2) det b))/2`. Twice the area over the longest
//! side is up to 1/0.82 of it and would not be safe. With s the larger principal value of b, P the
//! sum of squared sides and I the rotational inertia per mass, transverse shear has exactly
//! `omega^2 = 5/6 G/rho (3 s + (1 + P s/24)/I)`. So `I = (8 A^2/P + P/24)/5` limits it to that of
//! the membrane, except for 5 % at nu = 0 (1/s is at most 8 A^2/P).

use super::kinematics::{Frame, PlaneMotion, along_normal, curvature};
use super::section::{SHEAR_CORRECTION, Section, StepQuantities, Strains};
use super::shell::{Formulation, Shell};
use super::{
    Constructor, ElementEntry, ElementResult, GroupCorners, GroupNodes, Totals, parameters,
    zero_failed,
};
use crate::materials::{PlaneStress, PointLanes, PointReal};
use crate::nodes::NodeView;
use crate::parameter::Values;
use crumple_math::lanes::{Each, Lane, Real, cross, dot};
use crumple_proto::job::Part;
use crumple_proto::mesh::{OwnSection, Shape};

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "c0_triangle",
    meaning: "Belytschko-Stolarski-Carpenter: the formulation of all triangles.",
    shape: Shape::Tri3,
    parameters: [
        parameters::OF_SHELLS,
        &[
            parameters::coefficient_of_shell(
                0.03,
                "Fraction of the stiffness of the mode that its penalty has. See \
                 `cases/studies/README.md`, hourglass.",
            ),
            parameters::MEMBRANE,
        ],
    ],
    idle: parameters::idle_in_membrane_triangles,
    build: Constructor::Shell(build),
};

/// Number of own columns, after those of the section: drilling moments of the corners [force
/// length], resultant of c [force].
const OWN: usize = 4;

/// Parameters of the three-node shell.
pub struct C0Triangle {
    section: Section,
    /// Fraction of the stiffness of the mode.
    hourglass_coefficient: f64,
    /// alpha.
    drilling: f64,
}

fn build(part: &Part, values: &Values<'_>, law: Box<dyn PlaneStress>) -> ElementResult {
    let section = Section::new(part, values, law)?;
    let membrane = parameters::is_membrane(part, values)?;
    let unless_membrane = |key: &str| if membrane { 0.0 } else { values.number(key) };
    Ok(Box::new(Shell(C0Triangle {
        section: if membrane { section.of_membrane() } else { section },
        hourglass_coefficient: unless_membrane("hourglass_coefficient"),
        drilling: unless_membrane("drilling"),
    })))
}

/// Corner vectors of an element: those of 2 and 3 relative to 1, and for rotations also the sum.
pub struct Corners<R> {
    /// Coordinates relative to corner 1 [length].
    pub x: [[R; 3]; 2],
    /// Velocities relative to corner 1 [length/time].
    pub v: [[R; 3]; 2],
    /// Rotational velocities relative to corner 1, and their sum over the corners [1/time].
    pub w: [[R; 3]; 3],
}

impl<R: Real> Corners<R> {
    /// Returns the sum of all magnitudes, which is not finite if one of them is not.
    #[inline(always)]
    fn sum(&self) -> R {
        let all = [self.x.as_flattened(), self.v.as_flattened(), self.w.as_flattened()];
        all.into_iter().flatten().fold(R::zero(), |sum, c| sum + c.abs())
    }
}

/// Result of a kernel for a group, in global axes.
pub struct TriangleResponse<R: Real> {
    /// Forces of corners 2 and 3; corner 1 has the negative of their sum [force].
    pub force: [[R; 3]; 2],
    /// Moments of corners 1, 2, 3 [force length].
    pub moment: [[R; 3]; 3],
    totals: Totals<R>,
    /// Lanes that have an area and the strain increments of a valid step.
    calm: R::Mask,
}

impl<R: Real> Corners<R> {
    /// Transforms velocities to those of the middle surface, as for quads. It is at the distance
    /// `e` from the nodes along the normal [length]; returns `e n`.
    #[inline(always)]
    fn shift_to_middle(&mut self, e: R) -> [R; 3] {
        let arm = along_normal(e, self.x[0], self.x[1]);
        for (v, w) in self.v.iter_mut().zip(&self.w) {
            let more = cross(*w, arm);
            (0..3).for_each(|i| v[i] += more[i]);
        }
        arm
    }
}

impl<R: Real> TriangleResponse<R> {
    /// Adds to the moments those of the forces, which act at `arm` from the nodes, as for quads.
    #[inline(always)]
    fn shift_to_nodes(&mut self, arm: [R; 3]) {
        let [f2, f3] = self.force;
        let first: [R; 3] = std::array::from_fn(|i| -(f2[i] + f3[i]));
        for (m, f) in self.moment.iter_mut().zip([first, f2, f3]) {
            let more = cross(arm, f);
            (0..3).for_each(|i| m[i] += more[i]);
        }
    }

    /// Removes failed elements: they have no forces, do not limit the step and are never reported
    /// as trouble.
    #[inline(always)]
    fn zero_failed(&mut self, failed: R::Mask) {
        zero_failed(failed, self.force.as_flattened_mut());
        zero_failed(failed, self.moment.as_flattened_mut());
        self.totals.zero_failed(failed);
    }
}

/// Frame and shape of an element.
struct TriangleGeometry<R: Real> {
    frame: Frame<R>,
    area: R,
    /// Sides 1-2 and 1-3 in the plane [length].
    x: [[R; 2]; 2],
    /// B1, B2 of corners 2 and 3 [1/length].
    b: [[R; 2]; 2],
}

impl<R: Real> TriangleGeometry<R> {
    #[inline(always)]
    fn new([r21, r31]: [[R; 3]; 2]) -> Self {
        let one = R::splat(1.0);
        let raw = cross(r21, r31);
        let two_a = dot(raw, raw).sqrt();
        let inv_2a = one / two_a;
        let n = raw.map(|c| c * inv_2a);
        let [root, two] = [3.0_f64.sqrt(), 2.0].map(R::splat);
        let turned = cross(n, std::array::from_fn(|i| two.neg_mul_add(r31[i], r21[i])));
        let e1: [R; 3] = std::array::from_fn(|i| root.mul_add(r21[i], turned[i]));
        let inv = one / dot(e1, e1).sqrt();
        let e1 = e1.map(|c| c * inv);
        let e2 = cross(n, e1);
        let x = [r21, r31].map(|r| [dot(e1, r), dot(e2, r)]);
        let b = [[x[1][1] * inv_2a, -(x[1][0] * inv_2a)], [-(x[0][1] * inv_2a), x[0][0] * inv_2a]];
        Self { frame: Frame { e1, e2, n }, area: R::splat(0.5) * two_a, x, b }
    }

    /// Returns the gradient of a column from its values at corners 2 and 3 relative to corner 1.
    #[inline(always)]
    fn gradient(&self, u21: R, u31: R) -> [R; 2] {
        std::array::from_fn(|j| self.b[0][j].mul_add(u21, self.b[1][j] * u31))
    }

    /// Returns the contributions of a stress-like vector to corners 2 and 3.
    #[inline(always)]
    fn spread(&self, s1: R, s2: R) -> [R; 2] {
        std::array::from_fn(|c| self.b[c][0].mul_add(s1, self.b[c][1] * s2))
    }

    /// Returns half the sum of squared sides [length^2].
    #[inline(always)]
    fn half_sides2(&self) -> R {
        let [a, b] = self.x;
        // |x31 - x21|^2 + |x21|^2 + |x31|^2, halved.
        plane_dot(a, a) + plane_dot(b, b) - plane_dot(a, b)
    }

    /// Returns the stable step at the density of the material [time].
    #[inline(always)]
    fn stable_dt(&self, section: &Section) -> R {
        let side2 = self.equivalent_side2(section.elastic.poisson);
        section.membrane_step(self.area, R::splat(1.0) / side2, 1.0)
    }

    /// Returns the lanes whose corners are not on a line.
    #[inline(always)]
    fn sound(&self) -> R::Mask {
        self.area.gt(R::zero())
    }

    /// Returns the quantities of the present shape that determine the stable step.
    #[inline(always)]
    fn limits(&self, poisson: f64) -> StepQuantities<R> {
        let sides2 = R::splat(2.0) * self.half_sides2();
        StepQuantities {
            area: self.area,
            inv_area: R::splat(1.0) / self.area,
            side2: self.equivalent_side2(poisson),
            fraction: 1.0,
            corners: 3.0,
            least_s: 0.5 * 3.0_f64.sqrt(), // its determinant is 3/4A^2
            taper: R::splat(1.0 / 24.0) * sides2,
            floor: self.inertia(),
        }
    }

    /// Returns the rotational inertia per mass that limits the frequency of shear to that of the
    /// membrane [length^2].
    #[inline(always)]
    fn inertia(&self) -> R {
        let sides2 = R::splat(2.0) * self.half_sides2();
        R::splat(0.2)
            * R::splat(1.0 / 24.0).mul_add(sides2, R::splat(8.0) * self.area * self.area / sides2)
    }

    /// Returns the square of the side by which the area is divided for the stable step of the
    /// membrane times the plate wave speed [length^2].
    #[inline(always)]
    fn equivalent_side2(&self, poisson: f64) -> R {
        R::splat(3.0 / 8.0) * self.membrane_eigenvalue(poisson) * self.area * self.area
    }

    /// Returns `tr b + sqrt(tr^2 b - 4 (1-nu^2) det b)` [1/length^2].
    #[inline(always)]
    fn membrane_eigenvalue(&self, poisson: f64) -> R {
        // tr b = (sum of squared sides)/4A^2; det b = 3/4A^2 for any triangle.
        let inv_4a2 = R::splat(0.25) / (self.area * self.area);
        let trace = R::splat(2.0) * self.half_sides2() * inv_4a2;
        let four_det = R::splat(12.0 * (1.0 - poisson * poisson)) * inv_4a2;
        let root = Real::max(four_det.neg_mul_add(R::splat(1.0), trace * trace), R::zero()).sqrt();
        trace + root
    }
}

#[inline(always)]
fn plane_dot<R: Real>(a: [R; 2], b: [R; 2]) -> R {
    a[0].mul_add(b[0], a[1] * b[1])
}

impl C0Triangle {
    /// Computes one element in each lane.
    #[inline(always)]
    pub fn respond<R: PointReal, const N: usize>(
        &self,
        corners: &Corners<R>,
        history: &mut [R],
        dt: f64,
    ) -> TriangleResponse<R> {
        let (section, own) = history.split_at_mut(self.section.columns());
        let own = &mut own[..OWN];
        let step = R::splat(dt);
        let [half, third, sixth] = [0.5, 1.0 / 3.0, 1.0 / 6.0].map(R::splat);

        // 1. Frame, and all motions in its axes, as increments of the step.
        let g = TriangleGeometry::new(corners.x);
        let u = g.frame.increments(&corners.v, step);

        // 2. Gradients.
        let k: [[R; 2]; 3] = std::array::from_fn(|i| g.gradient(u[0][i], u[1][i]));
        let plane = PlaneMotion::new(&k);
        let t = plane.offsets(g.frame.increments(&corners.w, step));
        let tx = g.gradient(t[0][0], t[1][0]);
        let ty = g.gradient(t[0][1], t[1][1]);

        // 3. Strains, as in the four-node shell.
        let PlaneMotion { eps, sine, angle, .. } = plane;

        // 4. Transverse shear from the edges.
        let [x21, x31] = g.x;
        let x23: [R; 2] = std::array::from_fn(|i| x21[i] - x31[i]);
        let [b21, b31] = [[t[0][1], -t[0][0]], [t[1][1], -t[1][0]]];
        let edge = g.gradient(
            sixth * (plane_dot(b21, x23) - plane_dot(b31, x21)),
            sixth * -(plane_dot(b31, x23) + plane_dot(b21, x31)),
        );
        let gamma = [
            angle.mul_add(sine[0], third.mul_add(t[2][1], edge[0])),
            angle.mul_add(sine[1], third.neg_mul_add(t[2][0], edge[1])),
        ];

        // 5. Stress.
        let strains = Strains { eps, kappa: curvature(tx, ty), gamma };
        let healthy = self.section.sound_points(&strains, self.section.current_thickness(section));
        let resultants = self.section.update::<R, N>(section, &strains, dt);
        let thickness = resultants.thickness;
        let [nx, ny, nxy] = resultants.n.map(|n| n * g.area);
        let [mx, my, mxy] = resultants.m.map(|m| m * g.area);
        let [qx, qy] = resultants.q.map(|q| q * g.area);

        // 6. Drilling at each corner, and the spin of the fibres without stiffness.
        let mut energy = R::zero();
        let mut advance = |column: &mut R, stiffness: R, rate: R| {
            let old = *column;
            *column = stiffness.mul_add(rate, old);
            energy = (old + *column).mul_add(rate, energy);
            *column
        };
        let shear_modulus = self.section.stabilising.shear_modulus();
        let stiff = R::splat(self.drilling * shear_modulus / 3.0) * thickness * g.area;
        let first = third * (t[2][2] - t[0][2] - t[1][2]) - angle * sine[2];
        let drill = [
            advance(&mut own[0], stiff, first),
            advance(&mut own[1], stiff, first + t[0][2]),
            advance(&mut own[2], stiff, first + t[1][2]),
        ];
        let fraction =
            self.hourglass_coefficient * SHEAR_CORRECTION * self.section.transverse_modulus / 72.0;
        let stiff = R::splat(fraction) * thickness * g.half_sides2() / g.area;
        let free =
            half * advance(&mut own[3], stiff, half * (plane_dot(b31, x21) - plane_dot(b21, x31)));

        // 7. Corner forces.
        let couple = half * (drill[0] + drill[1] + drill[2]);
        let fx = g.spread(nx, nxy + couple);
        let fy = g.spread(nxy - couple, ny);
        let fz = g.spread(qx, qy);
        let force = std::array::from_fn(|c| g.frame.global([fx[c], fy[c], fz[c]]));
        // Forces conjugate to b21 and b31: curvature, edge shear, spin of the fibres; then the part
        // of the mean.
        let [on_r, on_s] = fz.map(|f| f * sixth);
        let by = g.spread(mx, mxy);
        let bx = g.spread(mxy, my);
        let to2: [R; 2] = std::array::from_fn(|i| {
            on_r.mul_add(
                x23[i],
                (-(on_s + free)).mul_add(x31[i], if i == 0 { by[0] } else { bx[0] }),
            )
        });
        let to3: [R; 2] = std::array::from_fn(|i| {
            (free - on_r)
                .mul_add(x21[i], (-on_s).mul_add(x23[i], if i == 0 { by[1] } else { bx[1] }))
        });
        let mean = [third * qx, third * qy];
        let corner =
            |b: [R; 2], drill: R| g.frame.global([-(mean[1] + b[1]), mean[0] + b[0], drill]);
        let to1 = [-(to2[0] + to3[0]), -(to2[1] + to3[1])];
        let moment = [corner(to1, drill[0]), corner(to2, drill[1]), corner(to3, drill[2])];

        // 8. Validity. The sum is not finite if any of its terms is not.
        let mut total = R::zero();
        for c in 0..3 {
            total += force[0][c].abs() + force[1][c].abs();
            total += moment[0][c].abs() + moment[1][c].abs() + moment[2][c].abs();
        }
        let calm = R::both(healthy, g.sound());
        let sound = R::both(calm, total.le(R::splat(R::LARGEST)));
        let elastic = &self.section.elastic;
        let limits = g.limits(elastic.poisson);
        let totals = Totals {
            stable_dt: self.section.stable_dt(section, &limits),
            internal: resultants.work * g.area,
            hourglass: half * energy,
            sound,
        };
        let mut response = TriangleResponse { force, moment, totals, calm };
        if let Some(failed) = self.section.failed_lanes(section) {
            response.zero_failed(failed);
            zero_failed(failed, own);
        }
        response
    }
}

/// Returns the corner vectors of a group. Differences are taken row by row, before the rows become
/// lanes.
#[inline(always)]
fn gather<L: PointLanes<W>, const W: usize>(
    group: &GroupNodes<4, W>,
    nodes: &NodeView<'_>,
) -> Corners<L> {
    let n = nodes.x.len();
    let (x, v, w) = (&nodes.x[..n], &nodes.v[..n], &nodes.w[..n]);
    let mut rows = [[L::row(Lane::splat(0.0)); W]; 7];
    for lane in 0..W {
        let corner: [usize; 3] = std::array::from_fn(|c| group[c][lane] as usize);
        for (block, column) in [x, v, w].into_iter().enumerate() {
            let [a, b, c] = corner.map(|node| Lane::new(column[node]));
            rows[2 * block][lane] = L::row(b - a);
            rows[2 * block + 1][lane] = L::row(c - a);
            if block == 2 {
                rows[6][lane] = L::row(a + b + c);
            }
        }
    }
    let [x2, x3, v2, v3, w2, w3, ws] = rows.each(L::from_rows);
    Corners { x: [x2, x3], v: [v2, v3], w: [w2, w3, ws] }
}

/// Converts lanes to rows. The fourth corner repeats the third and gets zero.
#[inline(always)]
fn scatter<L: PointLanes<W>, const W: usize>(
    response: &TriangleResponse<L>,
    force: &mut GroupCorners<4, W>,
    moment: &mut GroupCorners<4, W>,
) {
    let [f2, f3] = response.force.each(L::to_rows);
    let [m1, m2, m3] = response.moment.each(L::to_rows);
    for lane in 0..W {
        let first = -(f2[lane] + f3[lane]);
        force[lane] = [first.to_array(), f2[lane].to_array(), f3[lane].to_array(), [0.0; 4]];
        moment[lane] = [m1[lane].to_array(), m2[lane].to_array(), m3[lane].to_array(), [0.0; 4]];
    }
}

fn sides(x: &[[f64; 3]; 4]) -> [[f64; 3]; 2] {
    [1, 2].map(|c: usize| std::array::from_fn(|i| x[c][i] - x[0][i]))
}

impl Formulation for C0Triangle {
    const OWN: &'static [&'static str] = &["drilling 1", "drilling 2", "drilling 3", "resultant c"];
    /// Step that shear requires at nu = 0.
    const ALONE: f64 = 0.95;
    const DIVISIBLE: bool = false;

    fn section(&self) -> &Section {
        &self.section
    }

    fn section_mut(&mut self) -> &mut Section {
        &mut self.section
    }

    fn corner_mass(&self, x: &[[f64; 3]; 4], own: OwnSection) -> (f64, f64) {
        let [area, floor] = self.size(x);
        let mass = self.section.elastic.density * self.section.thickness_at_start(own) * area / 3.0;
        (mass, mass * self.section.inertia_per_mass(own, floor))
    }

    fn size(&self, x: &[[f64; 3]; 4]) -> [f64; 2] {
        let g = TriangleGeometry::new(sides(x));
        [g.area, g.inertia()]
    }

    fn stable_dt(&self, x: &[[f64; 3]; 4]) -> f64 {
        let geometry = TriangleGeometry::new(sides(x));
        if !geometry.sound() {
            return f64::NAN;
        }
        geometry.stable_dt(&self.section)
    }

    fn stable_dt_now(&self, history: &[f64], x: &[[f64; 3]; 4]) -> f64 {
        let geometry = TriangleGeometry::new(sides(x));
        if !geometry.sound() {
            return f64::NAN;
        }
        self.section.stable_dt(history, &geometry.limits(self.section.elastic.poisson))
    }

    fn axes(x: &[[f64; 3]; 4]) -> [[f64; 3]; 3] {
        let Frame { e1, e2, n } = TriangleGeometry::new(sides(x)).frame;
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
        let mut corners = gather(group, nodes);
        let mut arm = [L::zero(); 3];
        if self.section.has_offset() {
            arm = corners.shift_to_middle(self.section.arm(history));
        }
        let mut response = self.respond::<L, N>(&corners, history, dt);
        if self.section.has_offset() {
            response.shift_to_nodes(arm);
        }
        if self.section.deletes {
            let (calm, sound) = (response.calm, response.totals.sound);
            let gone = self.section.delete_inverted(history, calm, sound, || corners.sum());
            response.zero_failed(gone);
        }
        scatter(&response, force, moment);
        response.totals
    }

    #[inline(never)]
    fn forceless<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<4, W>,
        nodes: &NodeView<'_>,
        history: &[L],
    ) -> Totals<L> {
        let mut rows = [[L::row(Lane::splat(0.0)); W]; 2];
        for lane in 0..W {
            let [a, b, c] = std::array::from_fn(|c| Lane::new(nodes.x[group[c][lane] as usize]));
            [rows[0][lane], rows[1][lane]] = [b - a, c - a].map(L::row);
        }
        let geometry = TriangleGeometry::new(rows.each(L::from_rows));
        let stable_dt = geometry.stable_dt(&self.section);
        let stable_dt =
            self.section.offset_factor(history).map_or(stable_dt, |factor| stable_dt * factor);
        Totals::inactive(stable_dt, geometry.sound())
    }
}

#[cfg(test)]
#[path = "c0_triangle_tests.rs"]
mod tests;
