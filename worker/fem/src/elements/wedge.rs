//! Six-node wedge with two integration points and one mean dilatation.
//!
//! The points p are at the centroids of the cross sections at `zeta = -1/sqrt 3, 1/sqrt 3`, with
//! the gradients `B_pI` there and volumes `V_p`. The volume of the wedge and its derivatives are
//! integrated exactly by them, so distorted elements pass the patch test. Strain, stress and
//! rotation of a point are those of [`hexahedron`](super::hexahedron). Both points take the mean
//! volume strain and the mean pressure (Hughes 1980), weighted by `V_p`: one condition on the
//! volume instead of two. In the plane of the triangles the strain is constant: with the volume
//! strain of each wedge they lock there as nu approaches 1/2, as triangles of constant strain do.
//! So with `pressure = "nodal"` a share of it is averaged at nodes as for the
//! [`tetrahedron`](super::tetrahedron): with the mean trace tr eps of the wedge
//! ```text
//! eps <- eps + (1 - s) (d_e - tr eps)/3 I,   s = min(1, 13/6 mu/K)
//! ```
//! It counts in the sums of its nodes with `(1 - s) V_e`. The wedge resists its own change of
//! volume as at nu = 0.3, the mean change at its nodes with the rest of K (as Puso & Solberg 2006).
//! With s = 0 bending is too soft: by 19 % with two wedges through the depth of a beam, instead of
//! 4 %. Strains that are linear along zeta, as in bending of a plate, have no parasitic shear at
//! the centroids.
//!
//! The two points see no twist of the triangles against each other. With s = -1 at the first and 1
//! at the second triangle, n the unit vector between their centroids, r the vector from the
//! centroid of its triangle to a node and K the mean gradient of the displacement increment u:
//! ```text
//! t_I = s_I n x r_I,   dq = sum t_I . (u_I - K x_I),   Q <- f (Q + k dq)
//! f_J = Q (t_J - sum_I t_I (x_I . B_J)),   k = 0.1 mu V/(h^2 sum |t_I|^2)
//! ```
//! zero in each linear field (Flanagan & Belytschko 1981). k is the torsional stiffness 0.6 mu I_p
//! of an equilateral prism of length h (Timoshenko & Goodier 1970, sec. 104), and f the factor of
//! plastic flow as for the hexahedron. Q is a scalar, which no rotation changes.
//!
//! Stable step: with m/6 at each node, `omega^2 <= (6/rho) (sum V_p kappa_p/V + 0.1 mu/h^2)`, where
//! `kappa_p = 2 mu g + max(lambda, 0) tr G` of a point as for the hexahedron: the sum of the
//! largest frequencies of the terms of the stiffness.

use super::pass::GroupCorners;
use super::solid::{
    PRESSURE_KEY, SOLID_KEYS, STRAIN_LIMIT, STRESS, SolidMaterial, StressStep, averages_volume,
    each, gather, increment, relative, scatter, viscous, work_and_size,
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
use crumple_proto::problem::Problem;

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "wedge",
    meaning: "Six nodes, two points, one mean dilatation.",
    shape: Shape::Wedge6,
    parameters: [PRESSURE_KEY, SOLID_KEYS],
    idle: |_| &[],
    build: Constructor::Solid(build),
};

/// Number of nodes and of points.
const NODES: usize = 6;
const POINTS: usize = 2;
/// Number of columns after the states of the points: volume at the start [length^3], bulk viscosity
/// [force/length^2], Q [force/length], volume strain increment of the nodes.
const OWN: usize = 4;
/// Place of the first point; that of the second one is its negative.
const PLACE: f64 = -0.577_350_269_189_625_8;
/// K/mu of the resistance of a wedge to its own change of volume: that at nu = 0.3.
const OWN_STIFFNESS: f64 = 13.0 / 6.0;
/// k of the twist as a multiple of `mu V/(h^2 sum |t|^2)`.
const TWIST: f64 = 0.1;

/// Parameters of the wedge.
pub struct Wedge {
    material: SolidMaterial,
    /// Share of the volume strain that is averaged at nodes, 1 - s.
    averaged_share: f64,
}

fn build(part: &Part, values: &Values<'_>, law: Box<dyn Solid>) -> ElementResult {
    if law.viscosity().is_some() {
        let message =
            format!("part {}: wedges cannot be a fluid: nothing resists their twist", part.label());
        let help = "mesh the fluid with hexahedra or tetrahedra, or use particles";
        return Err(vec![Problem::error("element", message, help)]);
    }
    let averages = averages_volume(part, values, &*law)?;
    let material = SolidMaterial::new(values, law);
    // K/mu.
    let nu = material.elastic.poisson;
    let stiffness = 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu));
    let averaged_share = if averages { (1.0 - OWN_STIFFNESS / stiffness).max(0.0) } else { 0.0 };
    Ok(Box::new(Wedge { material, averaged_share }))
}

/// Vectors at the nodes.
type WedgeNodes<R> = [[R; 3]; NODES];

/// Gradients of the points at given coordinates.
struct WedgeGradient<R> {
    /// Gradients of the nodes at each point [1/length].
    b: [WedgeNodes<R>; POINTS],
    /// Volumes of the points [length^3].
    volumes: [R; POINTS],
    volume: R,
}

impl<R: Real> WedgeGradient<R> {
    #[inline(always)]
    fn new(x: &WedgeNodes<R>) -> Self {
        let (half, third) = (R::splat(0.5), R::splat(1.0 / 3.0));
        let along = each(|i| {
            half * third * ((x[3][i] - x[0][i]) + (x[4][i] - x[1][i]) + (x[5][i] - x[2][i]))
        });
        let points: [(WedgeNodes<R>, R); POINTS] = std::array::from_fn(|p| {
            let at = if p == 0 { PLACE } else { -PLACE };
            let [low, high] = [0.5 - 0.5 * at, 0.5 + 0.5 * at].map(R::splat);
            let edge =
                |k: usize| each(|i| low * (x[k][i] - x[0][i]) + high * (x[3 + k][i] - x[3][i]));
            let (e1, e2) = (edge(1), edge(2));
            let across = cross(e1, e2);
            let determinant = dot(across, along);
            let inverse = R::splat(1.0) / determinant;
            // Gradients of the three coordinates of the element.
            let xi = cross(e2, along).map(|c| inverse * c);
            let eta = cross(along, e1).map(|c| inverse * c);
            let zeta = across.map(|c| inverse * half * third * c);
            let corners = [each(|i| -(xi[i] + eta[i])), xi, eta];
            let b = std::array::from_fn(|n| match n < 3 {
                true => each(|i| low.mul_add(corners[n][i], -zeta[i])),
                false => each(|i| high.mul_add(corners[n - 3][i], zeta[i])),
            });
            (b, half * determinant)
        });
        let [(b0, v0), (b1, v1)] = points;
        Self { b: [b0, b1], volumes: [v0, v1], volume: v0 + v1 }
    }

    /// Returns the lanes whose points have positive volumes.
    #[inline(always)]
    fn whole(&self) -> R::Mask {
        R::both(self.volumes[0].gt(R::zero()), self.volumes[1].gt(R::zero()))
    }

    /// Returns the mean gradients of the nodes [1/length].
    #[inline(always)]
    fn mean(&self) -> WedgeNodes<R> {
        let inverse = R::splat(1.0) / self.volume;
        let [w0, w1] = self.volumes.map(|v| v * inverse);
        std::array::from_fn(|n| each(|i| w0.mul_add(self.b[0][n][i], w1 * self.b[1][n][i])))
    }
}

/// Returns the gradient of `scale` times the field `u`: component i by coordinate j.
#[inline(always)]
fn gradient_of<R: Real>(b: &WedgeNodes<R>, u: &WedgeNodes<R>, scale: f64) -> [[R; 3]; 3] {
    each(|i| {
        each(|j| {
            let mut sum = u[0][i] * b[0][j];
            for n in 1..NODES {
                sum = u[n][i].mul_add(b[n][j], sum);
            }
            R::splat(scale) * sum
        })
    })
}

/// Returns the sum over nodes of `B_I B_I'`: xx, yy, zz, xy, yz, zx [1/length^2].
#[inline(always)]
fn gram<R: Real>(b: &WedgeNodes<R>) -> [R; 6] {
    let at = |i: usize, j: usize| {
        let mut sum = b[0][i] * b[0][j];
        for n in &b[1..] {
            sum = n[i].mul_add(n[j], sum);
        }
        sum
    };
    [at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(1, 2), at(2, 0)]
}

/// The twist of the triangles against each other, at given coordinates.
struct Twist<R> {
    /// t of the nodes [length], and the sum of their squares [length^2].
    t: WedgeNodes<R>,
    square: R,
    /// Distance h of the triangles, squared [length^2].
    height2: R,
}

impl<R: Real> Twist<R> {
    #[inline(always)]
    fn new(x: &WedgeNodes<R>) -> Self {
        let third = R::splat(1.0 / 3.0);
        let middle = |n: usize| each(|i| third * (x[n][i] + x[n + 1][i] + x[n + 2][i]));
        let [low, high] = [middle(0), middle(3)];
        let along = each(|i| high[i] - low[i]);
        let height2 = dot(along, along);
        let inverse = R::splat(1.0) / height2.sqrt();
        let n = along.map(|c| inverse * c);
        let t: WedgeNodes<R> = std::array::from_fn(|k| match k < 3 {
            true => cross(each(|i| x[k][i] - low[i]), n),
            false => cross(n, each(|i| x[k][i] - high[i])),
        });
        let mut square = dot(t[0], t[0]);
        for t in &t[1..] {
            square += dot(*t, *t);
        }
        Self { t, square, height2 }
    }

    /// Returns the sum over nodes of `t_I x_I'`.
    #[inline(always)]
    fn moments(&self, x: &WedgeNodes<R>) -> [[R; 3]; 3] {
        each(|i| {
            each(|j| {
                let mut sum = self.t[0][i] * x[0][j];
                for (t, x) in self.t[1..].iter().zip(&x[1..]) {
                    sum = t[i].mul_add(x[j], sum);
                }
                sum
            })
        })
    }
}

/// Shape of an element at the end of a step.
struct WedgeEndShape<R> {
    gradient: WedgeGradient<R>,
    /// Density [mass/length^3].
    density: R,
    /// 1/c_d [time/length], and the stable step without viscosity times c_d [length].
    slowness: R,
    length: R,
}

/// Forces on the nodes [force], and totals.
struct WedgeResponse<R: Real> {
    force: WedgeNodes<R>,
    totals: Totals<R>,
}

/// Results of both points.
struct PointResults<R> {
    /// Stress at the end without bulk viscosity [force/length^2].
    stress: [[R; STRESS]; POINTS],
    /// Work of the step without bulk viscosity [energy].
    work: R,
    /// Largest strain increment, and the sum of all of them.
    largest: R,
    total: R,
    /// Volume strain of the element.
    trace: R,
    /// Mean of the factors of plastic flow.
    left: R,
}

impl Wedge {
    /// Computes one element in each lane, from coordinates and velocities relative to node 0.
    #[inline(always)]
    fn respond<R: PointReal>(
        &self,
        x: &WedgeNodes<R>,
        v: &WedgeNodes<R>,
        history: &mut [R],
        dt: f64,
    ) -> WedgeResponse<R> {
        let (states, own) = history.split_at_mut(POINTS * self.material.state);
        let [first_volume, viscosity, resistance, averaged] =
            own.first_chunk_mut().expect("the history has columns() values");
        // Before the first step nothing has moved, so all rates are zero.
        let per_time = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let half = R::splat(0.5);

        // 1. Kinematics in the middle of the step, and stress.
        let back = R::splat(0.5 * dt);
        let mid: WedgeNodes<R> =
            std::array::from_fn(|n| each(|i| back.neg_mul_add(v[n][i], x[n][i])));
        let mid_gradient = WedgeGradient::new(&mid);
        let points = self.points(&mid_gradient, v, (states, *averaged), dt);

        // 2. Shape at the end, and bulk viscosity.
        let WedgeEndShape { gradient, density, slowness, length } = self.end(x, first_volume);
        let slowness = states
            .chunks_exact(self.material.state)
            .map(|state| self.material.stiffened(state, slowness))
            .fold(slowness, Real::min);
        let rate = R::splat(-per_time) * points.trace;
        let (q, stable_dt) = self.material.viscosity(rate, length, density, slowness);

        // 3. Twist.
        let mean = mid_gradient.mean();
        let twist = Twist::new(&mid);
        let k = gradient_of(&mean, v, dt);
        let mut turned = R::zero();
        for n in 0..NODES {
            let left = each(|i| R::splat(dt).mul_add(v[n][i], -dot(k[i], mid[n])));
            turned += dot(twist.t[n], left);
        }
        let end_twist = Twist::new(x);
        let shear = R::splat(TWIST * self.material.elastic.shear_modulus());
        let stiffness = shear * gradient.volume / (end_twist.height2 * end_twist.square);
        let old = *resistance;
        *resistance = points.left * stiffness.mul_add(turned, old);
        let resisted = half * (old + *resistance) * turned;

        // 4. Forces: both points have the mean pressure.
        let mut force = self.forces(&gradient, &points.stress, q);
        let (moments, mean) = (end_twist.moments(x), gradient.mean());
        for n in 0..NODES {
            let t = each(|i| end_twist.t[n][i] - dot(moments[i], mean[n]));
            (0..3).for_each(|i| force[n][i] = resistance.mul_add(t[i], force[n][i]));
        }

        // 5. Energy and validity. The sum is not finite if any of its terms is not.
        let mean_q = half * (*viscosity + q);
        let viscous = mean_q * points.trace * mid_gradient.volume;
        for state in states.chunks_exact_mut(self.material.state) {
            let volume = mid_gradient.volume / *first_volume;
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
        let sound = R::both(gradient.whole(), calm);
        let totals =
            Totals { stable_dt, internal: points.work - viscous, hourglass: resisted, sound };
        let mut response = WedgeResponse { force, totals };
        if let Some(column) = self.material.failed {
            let state = self.material.state;
            let failed = R::both(states[column].gt(half), states[state + column].gt(half));
            zero_failed(failed, response.force.as_flattened_mut());
            response.totals.zero_failed(failed);
            *resistance = R::select(failed, R::zero(), *resistance);
        }
        response
    }

    /// Updates the stress of both points with the mean volume strain, or with that `averaged` at
    /// the nodes.
    #[inline(always)]
    fn points<R: PointReal>(
        &self,
        gradient: &WedgeGradient<R>,
        v: &WedgeNodes<R>,
        (states, averaged): (&mut [R], R),
        dt: f64,
    ) -> PointResults<R> {
        let third = R::splat(1.0 / 3.0);
        let [(mut eps0, turn0), (mut eps1, turn1)] =
            [0, 1].map(|p| increment(&gradient_of(&gradient.b[p], v, dt)));
        let [trace0, trace1] = [&eps0, &eps1].map(|e| e[0] + e[1] + e[2]);
        let inverse = R::splat(1.0) / gradient.volume;
        let sum = gradient.volumes[0].mul_add(trace0, gradient.volumes[1] * trace1);
        let trace = sum * inverse;
        let (change0, change1) = (third * (trace - trace0), third * (trace - trace1));
        (0..3).for_each(|c| {
            eps0[c] += change0;
            eps1[c] += change1;
        });
        let share = R::splat(self.averaged_share / 3.0);
        let change = if self.averaged_share > 0.0 { share * (averaged - trace) } else { R::zero() };
        let mut results = PointResults {
            stress: [[R::zero(); STRESS]; POINTS],
            work: R::zero(),
            largest: R::zero(),
            total: R::zero(),
            trace,
            left: R::zero(),
        };
        let each_point = states.chunks_exact_mut(self.material.state);
        let strains = [(eps0, turn0), (eps1, turn1)];
        for (p, (state, (eps, turn))) in each_point.zip(strains).enumerate() {
            let mut strain = eps;
            (0..3).for_each(|c| strain[c] += change);
            let StressStep { before, after, stress, left } =
                self.material.update(state, &strain, &turn, dt);
            let (work, largest, total) = work_and_size(&before, &after, &eps, R::zero());
            results.stress[p] = stress;
            results.work = gradient.volumes[p].mul_add(work, results.work);
            results.largest = Real::max(results.largest, largest);
            results.total += total;
            results.left += R::splat(0.5) * left;
        }
        results
    }

    /// Returns the forces of the stresses, with the mean of their pressures, and of the bulk
    /// viscosity.
    #[inline(always)]
    fn forces<R: Real>(
        &self,
        gradient: &WedgeGradient<R>,
        stress: &[[R; STRESS]; POINTS],
        viscosity: R,
    ) -> WedgeNodes<R> {
        let third = R::splat(1.0 / 3.0);
        let means = [0, 1].map(|p| third * (stress[p][0] + stress[p][1] + stress[p][2]));
        let inverse = R::splat(1.0) / gradient.volume;
        let sum = gradient.volumes[0].mul_add(means[0], gradient.volumes[1] * means[1]);
        let mean = sum.mul_add(inverse, -viscosity);
        let mut force = [[R::zero(); 3]; NODES];
        for p in 0..POINTS {
            let [xx, yy, zz, xy, yz, zx] = stress[p];
            let by = mean - means[p];
            let weight = gradient.volumes[p];
            let [xx, yy, zz, xy, yz, zx] =
                [xx + by, yy + by, zz + by, xy, yz, zx].map(|s| weight * s);
            let rows = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
            for (force, b) in force.iter_mut().zip(&gradient.b[p]) {
                (0..3).for_each(|i| force[i] += dot(rows[i], *b));
            }
        }
        force
    }

    /// Computes the shape at these coordinates. Sets the volume at the start if there is none yet.
    #[inline(always)]
    fn end<R: Real>(&self, x: &WedgeNodes<R>, first_volume: &mut R) -> WedgeEndShape<R> {
        let gradient = WedgeGradient::new(x);
        *first_volume = R::select(first_volume.gt(R::zero()), *first_volume, gradient.volume);
        let density = R::splat(self.material.elastic.density) * *first_volume / gradient.volume;
        let slowness = (density * R::splat(1.0 / self.material.modulus())).sqrt();
        let length = self.length(x, &gradient);
        WedgeEndShape { gradient, density, slowness, length }
    }

    /// Returns the stable step without viscosity times c_d [length].
    #[inline(always)]
    fn length<R: Real>(&self, x: &WedgeNodes<R>, gradient: &WedgeGradient<R>) -> R {
        let material = &self.material;
        let kappa = gradient.b.map(|b| material.stiffness(&gram(&b)));
        let sum = gradient.volumes[0].mul_add(kappa[0], gradient.volumes[1] * kappa[1]);
        let twist = R::splat(TWIST * material.elastic.shear_modulus()) / Twist::new(x).height2;
        // 2 c_d/omega with omega^2 = 6 stiffness/density.
        let stiffness = sum / gradient.volume + twist;
        (R::splat(4.0 / NODES as f64 * material.modulus()) / stiffness).sqrt()
    }
}

impl SolidGroups<NODES> for Wedge {
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
        let WedgeEndShape { gradient, slowness, length, .. } =
            self.end(&x, &mut history[POINTS * self.material.state]);
        let [b1, _] = self.material.bulk_viscosity;
        Totals::inactive(viscous(length * slowness, L::splat(b1)), gradient.whole())
    }
}

impl Element for Wedge {
    fn columns(&self) -> usize {
        POINTS * self.material.state + OWN
    }

    fn names(&self) -> Vec<String> {
        let points = (1..=POINTS)
            .flat_map(|p| self.material.names().map(move |name| format!("{name} of point {p}")));
        let own = ["volume at start", "bulk viscosity", "twist", "volume strain of nodes"]
            .map(String::from);
        points.chain(own).collect()
    }

    fn any_precision(&self) -> bool {
        self.material.any_precision()
    }

    fn measure(&self, history: &mut [f64], x: &[[f64; 3]], _: OwnSection) {
        let volume = WedgeGradient::new(&relative(x)).volume;
        self.material.measure(history, x, POINTS, volume);
    }

    fn taken_at_start(&self) -> TakenAtStart {
        self.material.taken_at_start()
    }

    fn set_initial(&self, history: &mut [f64], _: &[[f64; 3]], points: &[InitialPoint]) {
        self.material.set_initial(history, POINTS, points);
    }

    fn corner_mass(&self, x: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        let volume = WedgeGradient::new(&relative(x)).volume;
        (self.material.elastic.density * volume / NODES as f64, 0.0)
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        pass.solids::<NODES>(self.columns(), self)
    }

    /// Without the viscosity that is quadratic in the rate.
    fn stable_dt(&self, x: &[[f64; 3]], _: OwnSection) -> f64 {
        let x = relative(x);
        let gradient = WedgeGradient::new(&x);
        if !gradient.whole() || !gradient.volume.is_finite() {
            return f64::NAN;
        }
        let [b1, _] = self.material.bulk_viscosity;
        let speed = self.material.elastic.dilatational_wave_speed();
        viscous(self.length(&x, &gradient) / speed, b1)
    }

    fn stable_dt_now(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> f64 {
        let first = history.at(POINTS * self.material.state);
        let volume = WedgeGradient::new(&relative(x)).volume;
        self.stable_dt(x, OwnSection::default())
            * if first > 0.0 { (first / volume).sqrt() } else { 1.0 }
            * (0..POINTS)
                .map(|p| self.material.step_factor(history, p * self.material.state))
                .fold(1.0, f64::min)
    }

    fn averaged_volume(&self) -> Option<usize> {
        (self.averaged_share > 0.0).then_some(POINTS * self.material.state + OWN - 1)
    }

    fn volume_change(&self, [x, v]: [&[[f64; 3]]; 2], dt: f64) -> [f64; 2] {
        let [x, v]: [WedgeNodes<f64>; 2] = [relative(x), relative(v)];
        let back = 0.5 * dt;
        let mid: WedgeNodes<f64> =
            std::array::from_fn(|n| each(|i| back.neg_mul_add(v[n][i], x[n][i])));
        let gradient = WedgeGradient::new(&mid);
        let trace =
            |p: usize| -> f64 { gradient.b[p].iter().zip(&v).map(|(b, v)| dot(*b, *v)).sum() };
        let change = gradient.volumes[0] * trace(0) + gradient.volumes[1] * trace(1);
        // Without the share in the sums, wedges and tetrahedra together would have no potential.
        [gradient.volume, dt * change].map(|of_all| self.averaged_share * of_all)
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
        let points = [0, 1].map(|p| self.material.fields(history, p * self.material.state));
        ElementFields::of_points(&points)
    }
}
