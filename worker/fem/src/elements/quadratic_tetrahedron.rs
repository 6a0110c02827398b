//! Ten-node tetrahedron with quadratic displacements and four integration points.
//!
//! With the volume coordinates `L_i` of the corners, the shape functions are `L_i (2 L_i - 1)` at
//! corners and `4 L_i L_j` on edges (Zienkiewicz, Taylor & Zhu 2013, sec. 6.3). The points have
//! `L_i = (5 + 3 sqrt 5)/20` at one corner and `(5 - sqrt 5)/20` at the others, with equal weights:
//! exact for polynomials of degree two. So the patch test is exact with straight edges; elements
//! with curved ones pass it as they get smaller. Strain, stress and rotation of a point are those
//! of [`hexahedron`](super::hexahedron). The bulk viscosity is one pressure, from the mean rate.
//!
//! A corner has 1/36 of the mass and a node on an edge 4/27, in proportion to the diagonal of the
//! consistent mass matrix (Hinton, Rock & Zienkiewicz 1976): row sums would be negative.
//!
//! Stable step: `omega^2 <= max_p sum_q D_pq + max_p sum_q P_pq`, with the matrices D and P whose
//! entries bound the accelerations that a deviatoric stress and a pressure at point q give at p:
//! ```text
//! D_pq = sqrt(V_p V_q)/(rho V) 2 mu |G_pq|,
//! P_pq = sqrt(V_p V_q)/(rho V) max(lambda, 0) |tr G_pq|,
//! G_pq = sum_I B_pI B_qI'/c_I
//! ```
//! with `c_I` the share of the mass. The stiffness over the mass is the sum of a part with 2 mu and
//! a part with lambda; the nonzero eigenvalues of each are those of a matrix of such blocks, and no
//! eigenvalue is larger than the sum of the norms in a row. `|G_pq|` is the root of the sum of
//! squares, or for p = q the bound of the hexahedron. For a single regular element the step is 0.77
//! (nu = 0), 0.84 (0.3) and 0.99 (0.49) of that at which it becomes unstable.
//!
//! Faces in contact and under pressure are four plane triangles per side.

use super::pass::GroupCorners;
use super::solid::{
    SOLID_KEYS, STRAIN_LIMIT, STRESS, SolidMaterial, StressStep, each, gather, increment,
    largest_and_trace, relative, scatter, viscous, work_and_size,
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
use crumple_proto::mesh::{EDGES_OF_TET10, OwnSection, Shape};

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "quadratic_tetrahedron",
    meaning: "Ten nodes, quadratic displacements, four points.",
    shape: Shape::Tet10,
    parameters: [&[], SOLID_KEYS],
    idle: |_| &[],
    build: Constructor::Solid(build),
};

/// Number of nodes, corners and points.
const NODES: usize = 10;
const CORNERS: usize = 4;
const POINTS: usize = 4;
/// Number of columns after the states of the points: volume at the start [length^3] and bulk
/// viscosity [force/length^2].
const OWN: usize = 2;
/// Volume coordinates of a point: that of its own corner, and the others.
const NEAR: f64 = 0.585_410_196_624_968_5;
const FAR: f64 = 0.138_196_601_125_010_5;

/// Derivatives of the shape functions by the second to fourth volume coordinate, at each point.
const DERIVATIVES: [[[f64; 3]; NODES]; POINTS] = derivatives();

const fn derivatives() -> [[[f64; 3]; NODES]; POINTS] {
    let mut all = [[[0.0; 3]; NODES]; POINTS];
    let mut p = 0;
    while p < POINTS {
        // By all four coordinates.
        let mut by = [[0.0; CORNERS]; NODES];
        let mut n = 0;
        while n < NODES {
            if n < CORNERS {
                by[n][n] = 4.0 * coordinate(p, n) - 1.0;
            } else {
                let [a, b] = EDGES_OF_TET10[n - CORNERS];
                by[n][a] = 4.0 * coordinate(p, b);
                by[n][b] = 4.0 * coordinate(p, a);
            }
            let mut k = 0;
            while k < 3 {
                all[p][n][k] = by[n][k + 1] - by[n][0];
                k += 1;
            }
            n += 1;
        }
        p += 1;
    }
    all
}

/// Returns a volume coordinate of a point.
const fn coordinate(point: usize, corner: usize) -> f64 {
    if point == corner { NEAR } else { FAR }
}

/// `sum_I D_pI D_qI'/c_I` of the derivatives D at pairs of points.
const COUPLINGS: [[[[f64; 3]; 3]; POINTS]; POINTS] = couplings();

const fn couplings() -> [[[[f64; 3]; 3]; POINTS]; POINTS] {
    let mut all = [[[[0.0; 3]; 3]; POINTS]; POINTS];
    let mut at = 0;
    while at < POINTS * POINTS * NODES {
        let (p, q, n) = (at / NODES / POINTS, at / NODES % POINTS, at % NODES);
        let share = Shape::Tet10.mass_share(n) / NODES as f64;
        let mut kl = 0;
        while kl < 9 {
            let (k, l) = (kl / 3, kl % 3);
            all[p][q][k][l] += DERIVATIVES[p][n][k] * DERIVATIVES[q][n][l] / share;
            kl += 1;
        }
        at += 1;
    }
    all
}

/// Parameters of the tetrahedron.
pub struct QuadraticTetrahedron {
    material: SolidMaterial,
}

fn build(_: &Part, values: &Values<'_>, law: Box<dyn Solid>) -> ElementResult {
    Ok(Box::new(QuadraticTetrahedron { material: SolidMaterial::new(values, law) }))
}

/// Vectors at the nodes.
type TetrahedronNodes<R> = [[R; 3]; NODES];

/// Returns the derivatives of a field by the second to fourth volume coordinate at a point.
#[inline(always)]
fn derivatives_of<R: Real>(u: &TetrahedronNodes<R>, point: usize) -> [[R; 3]; 3] {
    let by: [[R; 3]; CORNERS] = std::array::from_fn(|c| {
        let own = R::splat(4.0 * coordinate(point, c) - 1.0);
        let mut sum = each(|i| own * u[c][i]);
        for (n, edge) in EDGES_OF_TET10.iter().enumerate().filter(|(_, edge)| edge.contains(&c)) {
            let other = if edge[0] == c { edge[1] } else { edge[0] };
            let weight = R::splat(4.0 * coordinate(point, other));
            sum = each(|i| weight.mul_add(u[CORNERS + n][i], sum[i]));
        }
        sum
    });
    std::array::from_fn(|k| each(|i| by[k + 1][i] - by[0][i]))
}

/// Gradients of the volume coordinates at the points.
struct PointGradients<R> {
    /// Gradients of the second to fourth coordinate [1/length].
    by: [[[R; 3]; 3]; POINTS],
    /// Volumes of the points [length^3].
    volumes: [R; POINTS],
    volume: R,
}

impl<R: Real> PointGradients<R> {
    #[inline(always)]
    fn new(x: &TetrahedronNodes<R>) -> Self {
        let points: [([[R; 3]; 3], R); POINTS] = std::array::from_fn(|p| {
            let [x1, x2, x3] = derivatives_of(x, p);
            let normals = [cross(x2, x3), cross(x3, x1), cross(x1, x2)];
            let determinant = dot(x1, normals[0]);
            let inverse = R::splat(1.0) / determinant;
            let by = normals.map(|n| n.map(|c| inverse * c));
            (by, R::splat(1.0 / (6.0 * POINTS as f64)) * determinant)
        });
        let volumes = std::array::from_fn(|p| points[p].1);
        let [a, b, c, d] = volumes;
        Self { by: points.map(|point| point.0), volumes, volume: (a + b) + (c + d) }
    }

    /// Returns the lanes whose points have positive volumes.
    #[inline(always)]
    fn whole(&self) -> R::Mask {
        let [a, b, c, d] = self.volumes;
        Real::min(Real::min(a, b), Real::min(c, d)).gt(R::zero())
    }

    /// Returns the gradient of `scale` times the field `u` at a point: component i by coordinate j.
    #[inline(always)]
    fn gradient_of(&self, u: &TetrahedronNodes<R>, point: usize, scale: f64) -> [[R; 3]; 3] {
        let [u1, u2, u3] = derivatives_of(u, point);
        let [g1, g2, g3] = self.by[point];
        each(|i| {
            each(|j| {
                let sum = u2[i].mul_add(g2[j], u1[i] * g1[j]);
                R::splat(scale) * u3[i].mul_add(g3[j], sum)
            })
        })
    }

    /// Returns `G_pq` of a pair of points [1/length^2].
    #[inline(always)]
    fn coupling(&self, p: usize, q: usize) -> [[R; 3]; 3] {
        let of = self.by[q];
        let half: [[R; 3]; 3] = std::array::from_fn(|k| {
            let [a, b, c] = COUPLINGS[p][q][k].map(R::splat);
            each(|j| c.mul_add(of[2][j], b.mul_add(of[1][j], a * of[0][j])))
        });
        let [g1, g2, g3] = self.by[p];
        each(|i| {
            each(|j| {
                let sum = g2[i].mul_add(half[1][j], g1[i] * half[0][j]);
                g3[i].mul_add(half[2][j], sum)
            })
        })
    }
}

/// Shape of an element at the end of a step.
struct QuadraticEndShape<R> {
    gradients: PointGradients<R>,
    /// Density [mass/length^3].
    density: R,
    /// 1/c_d [time/length], and the stable step without viscosity times c_d [length].
    slowness: R,
    length: R,
}

/// Forces on the nodes [force], and totals.
struct QuadraticResponse<R: Real> {
    force: TetrahedronNodes<R>,
    totals: Totals<R>,
}

/// Results of all points.
struct QuadraticPoints<R> {
    /// Stress at the end without bulk viscosity [force/length^2].
    stress: [[R; STRESS]; POINTS],
    /// Work of the step without bulk viscosity [energy].
    work: R,
    /// Largest strain increment, and the sum of all of them.
    largest: R,
    total: R,
    /// Mean volume strain.
    trace: R,
}

impl QuadraticTetrahedron {
    /// Computes one element in each lane, from coordinates and velocities relative to node 0.
    #[inline(always)]
    fn respond<R: PointReal>(
        &self,
        x: &TetrahedronNodes<R>,
        v: &TetrahedronNodes<R>,
        history: &mut [R],
        dt: f64,
    ) -> QuadraticResponse<R> {
        let (states, own) = history.split_at_mut(POINTS * self.material.state);
        let [first_volume, viscosity] =
            own.first_chunk_mut().expect("the history has columns() values");
        // Before the first step nothing has moved, so all rates are zero.
        let per_time = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let half = R::splat(0.5);

        // 1. Kinematics in the middle of the step, and stress.
        let back = R::splat(0.5 * dt);
        let mid: TetrahedronNodes<R> =
            std::array::from_fn(|n| each(|i| back.neg_mul_add(v[n][i], x[n][i])));
        let mid_gradients = PointGradients::new(&mid);
        let points = self.points(&mid_gradients, v, states, dt);

        // 2. Shape at the end, and bulk viscosity.
        let QuadraticEndShape { gradients, density, slowness, length } = self.end(x, first_volume);
        let slowness = states
            .chunks_exact(self.material.state)
            .map(|state| self.material.stiffened(state, slowness))
            .fold(slowness, Real::min);
        let rate = R::splat(-per_time) * points.trace;
        let (q, stable_dt) = self.material.viscosity(rate, length, density, slowness);

        // 3. Forces.
        let force = forces(&gradients, &points.stress, q);

        // 4. Energy and validity. The sum is not finite if any of its terms is not.
        let mean_q = half * (*viscosity + q);
        let viscous = mean_q * points.trace * mid_gradients.volume;
        for state in states.chunks_exact_mut(self.material.state) {
            let volume = mid_gradients.volume / *first_volume;
            self.material.heat(state, mean_q, points.trace, volume);
        }
        *viscosity = q;
        let mut total = points.total;
        for row in &force {
            total += row[0] + row[1] + row[2];
        }
        let calm = R::both(
            points.largest.le(R::splat(STRAIN_LIMIT)),
            total.abs().le(R::splat(R::LARGEST)),
        );
        let sound = R::both(gradients.whole(), calm);
        let internal = points.work - viscous;
        let totals = Totals { stable_dt, internal, hourglass: R::zero(), sound };
        let mut response = QuadraticResponse { force, totals };
        if let Some(column) = self.material.failed {
            let state = self.material.state;
            let at = |p: usize| states[p * state + column];
            let least = Real::min(Real::min(at(0), at(1)), Real::min(at(2), at(3)));
            let failed = least.gt(half);
            zero_failed(failed, response.force.as_flattened_mut());
            response.totals.zero_failed(failed);
        }
        response
    }

    /// Updates the stress of all points.
    #[inline(always)]
    fn points<R: PointReal>(
        &self,
        gradients: &PointGradients<R>,
        v: &TetrahedronNodes<R>,
        states: &mut [R],
        dt: f64,
    ) -> QuadraticPoints<R> {
        let mut results = QuadraticPoints {
            stress: [[R::zero(); STRESS]; POINTS],
            work: R::zero(),
            largest: R::zero(),
            total: R::zero(),
            trace: R::zero(),
        };
        for (p, state) in states.chunks_exact_mut(self.material.state).enumerate() {
            let (eps, turn) = increment(&gradients.gradient_of(v, p, dt));
            let StressStep { before, after, stress, .. } =
                self.material.update(state, &eps, &turn, dt);
            let (work, largest, total) = work_and_size(&before, &after, &eps, R::zero());
            let weight = gradients.volumes[p];
            results.stress[p] = stress;
            results.work = weight.mul_add(work, results.work);
            results.trace = weight.mul_add(eps[0] + eps[1] + eps[2], results.trace);
            results.largest = Real::max(results.largest, largest);
            results.total += total;
        }
        results.trace = results.trace / gradients.volume;
        results
    }

    /// Computes the shape at these coordinates. Sets the volume at the start if there is none yet.
    #[inline(always)]
    fn end<R: Real>(&self, x: &TetrahedronNodes<R>, first_volume: &mut R) -> QuadraticEndShape<R> {
        let gradients = PointGradients::new(x);
        *first_volume = R::select(first_volume.gt(R::zero()), *first_volume, gradients.volume);
        let density = R::splat(self.material.elastic.density) * *first_volume / gradients.volume;
        let slowness = (density * R::splat(1.0 / self.material.modulus())).sqrt();
        let length = self.length(&gradients);
        QuadraticEndShape { gradients, density, slowness, length }
    }

    /// Returns the stable step without viscosity times c_d [length].
    #[inline(always)]
    fn length<R: Real>(&self, gradients: &PointGradients<R>) -> R {
        let elastic = &self.material.elastic;
        let roots = gradients.volumes.map(Real::sqrt);
        // Rows of D and P without their constants.
        let mut rows = [[R::zero(); POINTS]; 2];
        for p in 0..POINTS {
            let [[xx, xy, _], [_, yy, yz], [zx, _, zz]] = gradients.coupling(p, p);
            let (largest, trace) = largest_and_trace(&[xx, yy, zz, xy, yz, zx]);
            let volume = gradients.volumes[p];
            rows[0][p] += volume * largest;
            rows[1][p] += volume * trace;
            for q in p + 1..POINTS {
                let g = gradients.coupling(p, q);
                let square = dot(g[0], g[0]) + dot(g[1], g[1]) + dot(g[2], g[2]);
                let trace = (g[0][0] + g[1][1] + g[2][2]).abs();
                let root = roots[p] * roots[q];
                for (row, norm) in rows.iter_mut().zip([square.sqrt(), trace]) {
                    row[p] = root.mul_add(norm, row[p]);
                    row[q] = root.mul_add(norm, row[q]);
                }
            }
        }
        let [shear, volume] = rows.map(|[a, b, c, d]| Real::max(Real::max(a, b), Real::max(c, d)));
        let largest = R::splat(2.0 * elastic.shear_modulus())
            .mul_add(shear, R::splat(elastic.lame().max(0.0)) * volume);
        // 2 c_d/omega with omega^2 = largest/(rho V).
        (R::splat(4.0 * self.material.modulus()) * gradients.volume / largest).sqrt()
    }
}

/// Returns the forces of the stresses at the points less a pressure.
#[inline(always)]
fn forces<R: Real>(
    gradients: &PointGradients<R>,
    stress: &[[R; STRESS]; POINTS],
    pressure: R,
) -> TetrahedronNodes<R> {
    let mut force = [[R::zero(); 3]; NODES];
    for (p, &[xx, yy, zz, xy, yz, zx]) in stress.iter().enumerate() {
        let weight = gradients.volumes[p];
        let [xx, yy, zz, xy, yz, zx] =
            [xx - pressure, yy - pressure, zz - pressure, xy, yz, zx].map(|s| weight * s);
        let rows = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
        let [t1, t2, t3] = gradients.by[p].map(|g| each(|i| dot(rows[i], g)));
        let t0 = each(|i| -(t1[i] + t2[i] + t3[i]));
        let by = [t0, t1, t2, t3];
        for c in 0..CORNERS {
            let own = R::splat(4.0 * coordinate(p, c) - 1.0);
            (0..3).for_each(|i| force[c][i] = own.mul_add(by[c][i], force[c][i]));
        }
        for (n, [a, b]) in EDGES_OF_TET10.into_iter().enumerate() {
            let [of_a, of_b] = [coordinate(p, b), coordinate(p, a)].map(|l| R::splat(4.0 * l));
            let force = &mut force[CORNERS + n];
            (0..3).for_each(|i| {
                force[i] = of_a.mul_add(by[a][i], of_b.mul_add(by[b][i], force[i]));
            });
        }
    }
    force
}

impl SolidGroups<NODES> for QuadraticTetrahedron {
    fn material(&self) -> Option<(&SolidMaterial, usize)> {
        Some((&self.material, POINTS))
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
        scatter(response.force, force);
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
        let QuadraticEndShape { gradients, slowness, length, .. } =
            self.end(&x, &mut history[POINTS * self.material.state]);
        let [b1, _] = self.material.bulk_viscosity;
        Totals::inactive(viscous(length * slowness, L::splat(b1)), gradients.whole())
    }
}

impl Element for QuadraticTetrahedron {
    fn columns(&self) -> usize {
        POINTS * self.material.state + OWN
    }

    fn names(&self) -> Vec<String> {
        let points = (1..=POINTS)
            .flat_map(|p| self.material.names().map(move |name| format!("{name} of point {p}")));
        points.chain(["volume at start", "bulk viscosity"].map(String::from)).collect()
    }

    fn any_precision(&self) -> bool {
        self.material.any_precision()
    }

    fn measure(&self, history: &mut [f64], x: &[[f64; 3]], _: OwnSection) {
        let volume = PointGradients::new(&relative(x)).volume;
        self.material.measure(history, x, POINTS, volume);
    }

    fn taken_at_start(&self) -> TakenAtStart {
        self.material.taken_at_start()
    }

    fn set_initial(&self, history: &mut [f64], _: &[[f64; 3]], points: &[InitialPoint]) {
        self.material.set_initial(history, POINTS, points);
    }

    fn corner_mass(&self, x: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        let volume = PointGradients::new(&relative(x)).volume;
        (self.material.elastic.density * volume / NODES as f64, 0.0)
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        pass.solids::<NODES>(self.columns(), self)
    }

    /// Without the viscosity that is quadratic in the rate.
    fn stable_dt(&self, x: &[[f64; 3]], _: OwnSection) -> f64 {
        let gradients = PointGradients::new(&relative(x));
        if !gradients.whole() || !gradients.volume.is_finite() {
            return f64::NAN;
        }
        let [b1, _] = self.material.bulk_viscosity;
        let speed = self.material.elastic.dilatational_wave_speed();
        viscous(self.length(&gradients) / speed, b1)
    }

    fn stable_dt_now(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> f64 {
        let first = history.at(POINTS * self.material.state);
        let volume = PointGradients::new(&relative(x)).volume;
        self.stable_dt(x, OwnSection::default())
            * if first > 0.0 { (first / volume).sqrt() } else { 1.0 }
            * (0..POINTS)
                .map(|p| self.material.step_factor(history, p * self.material.state))
                .fold(1.0, f64::min)
    }

    fn is_unstrained(&self, history: ElementState<'_>) -> bool {
        self.material.is_unstrained(history, POINTS)
    }

    fn failed(&self, history: ElementState<'_>) -> bool {
        (0..POINTS).all(|p| self.material.has_failed(history, p * self.material.state))
    }

    fn is_deleted(&self, history: ElementState<'_>) -> bool {
        self.material.is_deleted(history)
    }

    fn can_fail(&self) -> bool {
        self.material.failed.is_some()
    }

    fn fields(&self, history: ElementState<'_>, _x: &[[f64; 3]]) -> ElementFields {
        let points: [ElementFields; POINTS] =
            std::array::from_fn(|p| self.material.fields(history, p * self.material.state));
        ElementFields::of_points(&points)
    }
}
