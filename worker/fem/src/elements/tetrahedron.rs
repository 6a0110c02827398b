//! Four-node tetrahedron with one integration point and nodal averaging of the volume strain.
//!
//! The gradient of a linear field is constant: `B_I` are the rows of the inverse of the edges. The
//! step is that of [`hexahedron`](super::hexahedron): strain increment eps from the gradient in the
//! middle of the step, stress in the rotated frame, bulk viscosity in compression.
//!
//! A mesh has five to six tetrahedra per node, each with one condition on its volume: too many as
//! nu approaches 1/2, or in plastic flow (volumetric locking). So with `pressure = "nodal"` the
//! volume strain is that of the nodes (Bonet & Burton 1998). A node a sums over the elements e
//! around it, and an element takes the mean of its n_e nodes:
//! ```text
//! d_a = sum_e w_e dV_e/n_e / sum_e w_e V_e/n_e,    d_e = sum_a d_a/n_e
//! eps <- eps + (d_e - tr eps)/3 I
//! ```
//! with V the volume in the middle of the step and dV its change. `w_e` is the share of its volume
//! strain that an element averages: 1, and less for a [`wedge`](super::wedge). The forces use the
//! stress of the element and its own gradient. With one bulk modulus this is the potential of the
//! nodal volumes: `w_e V_e` times the matrix that averages d is symmetric, so work and stress
//! belong together, also where tetrahedra meet wedges. Its eigenvalues are at most 1: the stable
//! step of the element without averaging is safe. A node averages only over elements of the same
//! part, since a pressure may jump between two materials. A pressure that is not linear in the
//! volume strain has no such potential: foams do not average, and rubbers keep the energy as far as
//! their bulk modulus is constant. A failed element leaves the sums.
//!
//! Stable step as for the hexahedron, with a quarter of the mass at each corner:
//! `omega^2 <= (4/rho) (2 mu g + max(lambda, 0) tr G)`.
//!
//! The shear strain stays constant in an element: coarse meshes are too stiff in bending.

use super::pass::GroupCorners;
use super::solid::{
    PRESSURE_KEY, SOLID_KEYS, STRAIN_LIMIT, SolidMaterial, StressStep, averages_volume, corner,
    increment, scatter, viscous, work_and_size,
};
use super::{
    Constructor, Element, ElementEntry, ElementFields, ElementPass, ElementResult, GroupNodes,
    PassTotals, SolidGroups, TakenAtStart, Totals, zero_failed,
};
use crate::columns::ElementState;
use crate::materials::{PointLanes, PointReal, Solid};
use crate::nodes::NodeView;
use crate::parameter::Values;
use crumple_math::lanes::{Real, cross, dot};
use crumple_proto::initial::InitialPoint;
use crumple_proto::job::Part;
use crumple_proto::mesh::{OwnSection, Shape};

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "tetrahedron",
    meaning: "Four nodes, one point, volume strain averaged at nodes.",
    shape: Shape::Tet4,
    parameters: [PRESSURE_KEY, SOLID_KEYS],
    idle: |_| &[],
    build: Constructor::Solid(build),
};

/// Number of columns after the law's state: volume at the start [length^3], bulk viscosity
/// [force/length^2], volume strain increment of the nodes.
const OWN: usize = 3;
/// Number of nodes.
const NODES: usize = 4;

/// Parameters of the tetrahedron.
pub struct Tetrahedron {
    material: SolidMaterial,
    /// True if the volume strain is averaged at nodes.
    averages: bool,
}

fn build(part: &Part, values: &Values<'_>, law: Box<dyn Solid>) -> ElementResult {
    let averages = averages_volume(part, values, &*law)?;
    Ok(Box::new(Tetrahedron { material: SolidMaterial::new(values, law), averages }))
}

/// Volume and gradient at given coordinates.
struct TetrahedronGradient<R> {
    /// 6 V times the gradients at the corners 1 to 3 [length^2].
    b: [[R; 3]; 3],
    /// 6 V [length^3].
    volume6: R,
}

impl<R: Real> TetrahedronGradient<R> {
    /// Computes the gradient from the edges from corner 0 to the others.
    #[inline(always)]
    fn new(x: &[[R; 3]; 3]) -> Self {
        let [x1, x2, x3] = *x;
        let b = [cross(x2, x3), cross(x3, x1), cross(x1, x2)];
        Self { b, volume6: dot(x1, b[0]) }
    }

    /// Returns the gradient of `scale` times the field with the differences `u`: component i by
    /// coordinate j.
    #[inline(always)]
    fn gradient_of(&self, u: &[[R; 3]; 3], scale: f64) -> [[R; 3]; 3] {
        let inverse = R::splat(scale) / self.volume6;
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let sum = u[0][i] * self.b[0][j];
                let sum = u[1][i].mul_add(self.b[1][j], sum);
                u[2][i].mul_add(self.b[2][j], sum) * inverse
            })
        })
    }

    /// Returns the sum over corners of `B_I B_I'`: xx, yy, zz, xy, yz, zx [1/length^2].
    #[inline(always)]
    fn gram(&self) -> [R; 6] {
        let [b1, b2, b3] = self.b;
        let b0: [R; 3] = std::array::from_fn(|i| -(b1[i] + b2[i] + b3[i]));
        let inverse = R::splat(1.0) / self.volume6;
        let scale = inverse * inverse;
        let at = |i: usize, j: usize| {
            let sum = b0[i].mul_add(b0[j], b1[i] * b1[j]);
            b2[i].mul_add(b2[j], b3[i].mul_add(b3[j], sum)) * scale
        };
        [at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(1, 2), at(2, 0)]
    }

    /// Returns the volume [length^3].
    #[inline(always)]
    fn volume(&self) -> R {
        R::splat(1.0 / 6.0) * self.volume6
    }
}

/// Shape of an element at the end of a step.
struct TetrahedronEndShape<R> {
    gradient: TetrahedronGradient<R>,
    /// Density [mass/length^3].
    density: R,
    /// 1/c_d [time/length], and the stable step without viscosity times c_d [length].
    slowness: R,
    length: R,
}

/// Forces on the corners 1 to 3 [force], and totals.
struct TetrahedronResponse<R: Real> {
    force: [[R; 3]; 3],
    totals: Totals<R>,
}

impl Tetrahedron {
    /// Computes one element in each lane, from differences to corner 0.
    #[inline(always)]
    fn respond<R: PointReal>(
        &self,
        x: &[[R; 3]; 3],
        v: &[[R; 3]; 3],
        history: &mut [R],
        dt: f64,
    ) -> TetrahedronResponse<R> {
        let (state, own) = history.split_at_mut(self.material.state);
        let [first_volume, viscosity, averaged] =
            own.first_chunk_mut().expect("the history has columns() values");
        // Before the first step nothing has moved, so all rates are zero.
        let per_time = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let (half, third) = (R::splat(0.5), R::splat(1.0 / 3.0));

        // 1. Kinematics in the middle of the step.
        let back = R::splat(0.5 * dt);
        let mid: [[R; 3]; 3] =
            std::array::from_fn(|k| std::array::from_fn(|i| back.neg_mul_add(v[k][i], x[k][i])));
        let mid_gradient = TetrahedronGradient::new(&mid);
        let (eps, turn) = increment(&mid_gradient.gradient_of(v, dt));
        let own_trace = eps[0] + eps[1] + eps[2];
        let mut strain = eps;
        if self.averages {
            let change = third * (*averaged - own_trace);
            (0..3).for_each(|c| strain[c] += change);
        }

        // 2. Stress and bulk viscosity.
        let TetrahedronEndShape { gradient, density, slowness, length } = self.end(x, first_volume);
        let StressStep { before, after, stress, .. } =
            self.material.update(state, &strain, &turn, dt);
        // Viscosity follows the own rate of the element, so that it dissipates.
        let slowness = self.material.stiffened(state, slowness);
        let (q, stable_dt) =
            self.material.viscosity(R::splat(-per_time) * own_trace, length, density, slowness);

        // 3. Forces.
        let sixth = R::splat(1.0 / 6.0);
        let [xx, yy, zz, xy, yz, zx] = stress;
        let [xx, yy, zz, xy, yz, zx] = [xx - q, yy - q, zz - q, xy, yz, zx].map(|s| sixth * s);
        let rows = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
        let force: [[R; 3]; 3] =
            std::array::from_fn(|k| std::array::from_fn(|i| dot(rows[i], gradient.b[k])));

        // 4. Energy and validity. The sum is not finite if any of its terms is not.
        let mean_q = half * (*viscosity + q);
        let (work, largest, mut total) = work_and_size(&before, &after, &eps, mean_q);
        let volume = mid_gradient.volume();
        self.material.heat(state, mean_q, own_trace, volume / *first_volume);
        *viscosity = q;
        for row in &force {
            total += row[0] + row[1] + row[2];
        }
        let calm =
            R::both(largest.le(R::splat(STRAIN_LIMIT)), total.abs().le(R::splat(R::LARGEST)));
        let sound = R::both(gradient.volume6.gt(R::zero()), calm);
        let internal = work * volume;
        let totals = Totals { stable_dt, internal, hourglass: R::zero(), sound };
        let mut response = TetrahedronResponse { force, totals };
        if let Some(column) = self.material.failed {
            let failed = state[column].gt(half);
            zero_failed(failed, response.force.as_flattened_mut());
            response.totals.zero_failed(failed);
        }
        response
    }

    /// Computes the shape at these differences. Sets the volume at the start if there is none yet.
    #[inline(always)]
    fn end<R: Real>(&self, x: &[[R; 3]; 3], first_volume: &mut R) -> TetrahedronEndShape<R> {
        let gradient = TetrahedronGradient::new(x);
        let volume = gradient.volume();
        *first_volume = R::select(first_volume.gt(R::zero()), *first_volume, volume);
        let density = R::splat(self.material.elastic.density) * *first_volume / volume;
        let slowness = (density * R::splat(1.0 / self.material.modulus())).sqrt();
        let length = self.material.length::<NODES, R>(&gradient.gram());
        TetrahedronEndShape { gradient, density, slowness, length }
    }
}

/// Returns the differences of two nodal columns to corner 0.
#[inline(always)]
fn gather<L: PointLanes<W>, const W: usize>(
    group: &GroupNodes<NODES, W>,
    [one, other]: [&[[f64; 4]]; 2],
) -> [[[L; 3]; 3]; 2] {
    // One length for both columns, so that one bounds check per node is enough.
    let n = one.len();
    let columns = [&one[..n], &other[..n]];
    let at = |c: usize| corner::<L, NODES, W>(group, columns, c);
    let c = [at(0), at(1), at(2), at(3)];
    std::array::from_fn(|of| {
        std::array::from_fn(|k| std::array::from_fn(|i| c[k + 1][of][i] - c[0][of][i]))
    })
}

/// Returns the edges from corner 0 of one element.
fn edges(x: &[[f64; 3]]) -> [[f64; 3]; 3] {
    std::array::from_fn(|k| std::array::from_fn(|i| x[k + 1][i] - x[0][i]))
}

impl SolidGroups<NODES> for Tetrahedron {
    fn material(&self) -> Option<(&SolidMaterial, usize)> {
        Some((&self.material, 1))
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
        let response = self.respond(&x, &v, history, dt);
        let [f1, f2, f3] = response.force;
        let f0: [L; 3] = std::array::from_fn(|i| -(f1[i] + f2[i] + f3[i]));
        scatter([f0, f1, f2, f3], force);
        response.totals
    }

    #[inline(never)]
    fn forceless<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<NODES, W>,
        nodes: &NodeView<'_>,
        history: &mut [L],
    ) -> Totals<L> {
        let [x, _] = gather(group, [nodes.x, nodes.v]);
        let TetrahedronEndShape { gradient, slowness, length, .. } =
            self.end(&x, &mut history[self.material.state]);
        let [b1, _] = self.material.bulk_viscosity;
        let dt = viscous(length * slowness, L::splat(b1));
        Totals::inactive(dt, gradient.volume6.gt(L::zero()))
    }
}

impl Element for Tetrahedron {
    fn columns(&self) -> usize {
        self.material.state + OWN
    }

    fn names(&self) -> Vec<String> {
        let own = ["volume at start", "bulk viscosity", "volume strain of nodes"];
        self.material.names().chain(own.map(String::from)).collect()
    }

    fn any_precision(&self) -> bool {
        self.material.any_precision()
    }

    fn measure(&self, history: &mut [f64], x: &[[f64; 3]], _: OwnSection) {
        let volume = TetrahedronGradient::new(&edges(x)).volume();
        self.material.measure(history, x, 1, volume);
    }

    fn taken_at_start(&self) -> TakenAtStart {
        self.material.taken_at_start()
    }

    fn set_initial(&self, history: &mut [f64], _: &[[f64; 3]], points: &[InitialPoint]) {
        self.material.set_initial(history, 1, points);
    }

    fn corner_mass(&self, x: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        let volume = TetrahedronGradient::new(&edges(x)).volume();
        (0.25 * self.material.elastic.density * volume, 0.0)
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        pass.solids::<NODES>(self.columns(), self)
    }

    /// Without the viscosity that is quadratic in the rate.
    fn stable_dt(&self, x: &[[f64; 3]], _: OwnSection) -> f64 {
        let gradient = TetrahedronGradient::new(&edges(x));
        if gradient.volume6 <= 0.0 || !gradient.volume6.is_finite() {
            return f64::NAN;
        }
        let [b1, _] = self.material.bulk_viscosity;
        let speed = self.material.elastic.dilatational_wave_speed();
        viscous(self.material.length::<NODES, f64>(&gradient.gram()) / speed, b1)
    }

    fn stable_dt_now(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> f64 {
        let (first, volume) =
            (history.at(self.material.state), TetrahedronGradient::new(&edges(x)).volume());
        self.stable_dt(x, OwnSection::default())
            * if first > 0.0 { (first / volume).sqrt() } else { 1.0 }
            * self.material.step_factor(history, 0)
    }

    fn averaged_volume(&self) -> Option<usize> {
        self.averages.then_some(self.material.state + OWN - 1)
    }

    fn volume_change(&self, [x, v]: [&[[f64; 3]]; 2], dt: f64) -> [f64; 2] {
        let (x, v) = (edges(x), edges(v));
        let back = 0.5 * dt;
        let mid: [[f64; 3]; 3] =
            std::array::from_fn(|k| std::array::from_fn(|i| back.neg_mul_add(v[k][i], x[k][i])));
        let gradient = TetrahedronGradient::new(&mid);
        let trace = (0..3).map(|k| dot(gradient.b[k], v[k])).sum::<f64>();
        [gradient.volume6 / 6.0, dt * trace / 6.0]
    }

    fn is_unstrained(&self, history: ElementState<'_>) -> bool {
        self.material.is_unstrained(history, 1)
    }

    fn failed(&self, history: ElementState<'_>) -> bool {
        self.material.has_failed(history, 0)
    }

    fn is_deleted(&self, history: ElementState<'_>) -> bool {
        self.material.is_deleted(history)
    }

    fn can_fail(&self) -> bool {
        self.material.failed.is_some()
    }

    fn fields(&self, history: ElementState<'_>, _x: &[[f64; 3]]) -> ElementFields {
        self.material.fields(history, 0)
    }
}
