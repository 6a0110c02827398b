//! Eight-node cohesive element between two faces of four nodes, with four points on the surface in
//! their middle. It may have no thickness.
//!
//! With the nodes `x_k` of the first face and `x_(k+4)` of the second one, bilinear functions N,
//! the middle surface `m = sum N_k (x_k + x_(k+4))/2`, its tangents `g1, g2` and its normal n, the
//! axes of a point are `n, e1 = g1/|g1|, e2 = n x e1`. With the distance `d = sum N_k (x_(k+4) -
//! x_k)` and R = [n e1 e2]
//! ```text
//! u = R^T d - (R^T d)(0),   t = t(u),   T = R t
//! P = sum_points w t . du/dt,   w the area of the point at the start
//! ```
//! The forces follow from the power P. The distance gives `+- w N_k T` at the two nodes. The turn
//! of the axes gives the moment `M = d x T` to the middle surface, with `a = M x n/|g1 x g2|`:
//! ```text
//! f_k = f_(k+4) = -w/2 (N_k,1 (g2 x a + (M . n) e2/|g1|) + N_k,2 (a x g1))
//! ```
//! so that momentum and angular momentum are conserved and a rigid motion does no work, also with a
//! thickness. An element is removed when so many points have failed as `failed_points` says.
//!
//! Stable step, with m/8 at each node and K the largest stiffness. The distance alone has the
//! squared frequency `2 K r/(m/8)` at most, where r is the largest row sum of `sum w N_k N_l`
//! (Gershgorin); parallelograms reach it. The turn of the axes adds `sum w K |d|^2 (sum |grad
//! N_k|^2 + sum N_k,1^2/|g1|^2)/2 /(m/8)`, the square of a norm of its rows. The frequencies of
//! both are added, as norms are. The change of forces with the geometry is left out: it is of the
//! order of the opening over the length of the sides.

#[cfg(test)]
mod tests;

use super::{
    Constructor, Element, ElementEntry, ElementFields, ElementPass, ElementResult, PassTotals,
    SingleElement,
};
use crate::columns::ElementState;
use crate::materials::{Cohesive, CohesivePoint};
use crate::parameter::{DefaultValue, Form, ParameterRow, Range, Values};
use crumple_math::row::{V3, xyz};
use crumple_proto::job::Part;
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::problem::Problem;

/// Name of this element in jobs.
pub const COHESIVE: &str = "cohesive";

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: COHESIVE,
    shape: Shape::Cohesive8,
    meaning: "Cohesive surface between two faces of four nodes, which may coincide.",
    parameters: [
        &[
            ParameterRow {
                key: "integration",
                form: Form::Word(&[GAUSS, "nodes"]),
                otherwise: DefaultValue::Word(GAUSS),
                range: None,
                meaning: "Points of cohesive elements: those of Gauss, or the nodes.",
            },
            ParameterRow {
                key: "failed_points",
                form: Form::Whole,
                otherwise: DefaultValue::Whole(4),
                range: Some(Range { wanted: "from 0 to 4", fits: |n| (0.0..=4.0).contains(&n) }),
                meaning: "Number of failed points from which on a cohesive element is removed; 0 \
                          keeps it, and its faces still push.",
            },
        ],
        &[],
    ],
    idle: |_| &[],
    build: Constructor::Cohesive(build),
};

const GAUSS: &str = "gauss";
/// Number of nodes of a face, and of points.
const FOUR: usize = 4;
const NODES: usize = 2 * FOUR;
/// Columns of a point: its area at the start [length^2]; distance at the start and opening
/// [length], traction [force/length^2], each along n, e1, e2; then those of the law.
const START: usize = 1;
const OPENING: usize = 4;
const TRACTION: usize = 7;
const OF_LAW: usize = 10;
/// Coordinates of the nodes of a face.
const CORNERS: [[f64; 2]; FOUR] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// Functions of the nodes at a point: values, and derivatives by both coordinates.
struct ShapeFunctions {
    value: [f64; FOUR],
    by: [[f64; FOUR]; 2],
}

impl ShapeFunctions {
    fn new([p, q]: [f64; 2]) -> Self {
        let of = |f: fn(f64, f64, f64, f64) -> f64| CORNERS.map(|[a, b]| 0.25 * f(a, b, p, q));
        Self {
            value: of(|a, b, p, q| (1.0 + a * p) * (1.0 + b * q)),
            by: [of(|a, b, _, q| a * (1.0 + b * q)), of(|a, b, p, _| b * (1.0 + a * p))],
        }
    }
}

/// Parameters of cohesive elements.
pub struct CohesiveElement {
    law: Box<dyn Cohesive>,
    /// Column of the law that is 1 from failure on.
    failed: usize,
    failed_points: usize,
    points: [ShapeFunctions; FOUR],
}

fn build(part: &Part, values: &Values<'_>, law: Box<dyn Cohesive>) -> ElementResult {
    if part.skin {
        let message = format!("part {}: cohesive elements cannot be a skin", part.label());
        return Err(vec![Problem::error("skin", message, "remove it")]);
    }
    let scale = if values.word("integration") == GAUSS { 1.0 / 3.0_f64.sqrt() } else { 1.0 };
    let failed = law.history().iter().position(|name| *name == "failed");
    Ok(Box::new(CohesiveElement {
        failed: OF_LAW + failed.expect("a cohesive law marks failure"),
        law,
        failed_points: values.whole("failed_points"),
        points: CORNERS.map(|corner| ShapeFunctions::new(corner.map(|c| scale * c))),
    }))
}

/// Surface at a point.
struct SurfacePoint {
    /// Tangents [length].
    g: [V3; 2],
    /// Norm of their cross product [length^2].
    area: f64,
    /// Normal, and axes in the surface.
    axes: [V3; 3],
    /// Distance of the two faces [length].
    distance: V3,
}

impl SurfacePoint {
    fn new(functions: &ShapeFunctions, x: &[V3; NODES]) -> Self {
        let mut g = [V3::zeros(); 2];
        let mut distance = V3::zeros();
        for k in 0..FOUR {
            let middle = 0.5 * (x[k] + x[k + FOUR]);
            (0..2).for_each(|i| g[i] += functions.by[i][k] * middle);
            distance += functions.value[k] * (x[k + FOUR] - x[k]);
        }
        let cross = g[0].cross(&g[1]);
        let (area, n, e) = (cross.norm(), cross.normalize(), g[0].normalize());
        Self { g, area, axes: [n, e, n.cross(&e)], distance }
    }

    /// Returns the distance along the axes [length].
    fn local(&self) -> [f64; 3] {
        self.axes.map(|axis| axis.dot(&self.distance))
    }

    /// Adds the forces of a traction, times the area of the point, to those of the nodes.
    fn add_forces(&self, functions: &ShapeFunctions, load: &V3, force: &mut [V3; NODES]) {
        let [n, _, e2] = self.axes;
        let [g1, g2] = self.g;
        let moment = self.distance.cross(load);
        let a = moment.cross(&n) / self.area;
        let turn = [g2.cross(&a) + e2 * (moment.dot(&n) / g1.norm()), a.cross(&g1)];
        for k in 0..FOUR {
            let middle = 0.5 * (functions.by[0][k] * turn[0] + functions.by[1][k] * turn[1]);
            let along = functions.value[k] * load;
            force[k] -= middle + along;
            force[k + FOUR] += along - middle;
        }
    }

    /// Returns `(sum |grad N_k|^2 + sum N_k,1^2/|g1|^2)/2`, which bounds the rows of the turn of
    /// the axes [1/length^2].
    fn turning(&self, functions: &ShapeFunctions) -> f64 {
        let [g1, g2] = self.g;
        let n = self.axes[0];
        let dual = [g2.cross(&n) / self.area, n.cross(&g1) / self.area];
        let mut sum = 0.0;
        for k in 0..FOUR {
            let [by1, by2] = [functions.by[0][k], functions.by[1][k]];
            sum += (by1 * dual[0] + by2 * dual[1]).norm_squared();
            sum += by1 * by1 / g1.norm_squared();
        }
        0.5 * sum
    }
}

/// Nodes of an element.
fn eight(x: &[[f64; 3]]) -> [V3; NODES] {
    std::array::from_fn(|c| V3::from(x[c]))
}

impl CohesiveElement {
    /// Number of columns of a point.
    fn of_point(&self) -> usize {
        OF_LAW + self.law.history().len()
    }

    /// Returns the mass of an element from areas and thicknesses of its points [mass].
    fn mass(&self, points: impl Iterator<Item = [f64; 2]>) -> f64 {
        let face = self.law.face();
        face.density
            * points.map(|[area, t]| if face.per_area { area } else { area * t }).sum::<f64>()
    }

    /// Returns the stable step with these areas of the points [length^2] and this mass [time].
    fn step(&self, points: &[SurfacePoint; FOUR], areas: [f64; FOUR], mass: f64) -> f64 {
        let (stiffness, corner) = (self.law.face().stiffest(), mass / NODES as f64);
        let mut rows = [0.0; FOUR];
        let mut turn = 0.0;
        for ((point, functions), area) in points.iter().zip(&self.points).zip(areas) {
            // The functions of a point add up to one.
            rows.iter_mut().zip(functions.value).for_each(|(row, value)| *row += area * value);
            turn += area * point.distance.norm_squared() * point.turning(functions);
        }
        let largest = rows.into_iter().fold(0.0, f64::max);
        let frequency = |square: f64| (stiffness * square / corner).sqrt();
        2.0 / (frequency(2.0 * largest) + frequency(turn))
    }

    fn surface(&self, x: &[V3; NODES]) -> [SurfacePoint; FOUR] {
        self.points.each_ref().map(|functions| SurfacePoint::new(functions, x))
    }

    /// Returns areas and thicknesses of the points at the start.
    fn at_start(&self, at: impl Fn(usize) -> f64) -> [[f64; 2]; FOUR] {
        std::array::from_fn(|p| [0, START].map(|column| at(p * self.of_point() + column)))
    }

    /// Returns true if so many points have failed that the element is removed.
    fn is_removed(&self, at: impl Fn(usize) -> f64) -> bool {
        let failed = (0..FOUR).filter(|p| at(p * self.of_point() + self.failed) > 0.5).count();
        self.failed_points > 0 && failed >= self.failed_points
    }

    /// Updates the points, and returns the forces on the nodes [force] and the work of the step
    /// [energy].
    fn respond(&self, state: &mut [f64], surface: &[SurfacePoint; FOUR]) -> ([V3; NODES], f64) {
        let mut force = [V3::zeros(); NODES];
        let mut work = 0.0;
        let states = state.chunks_exact_mut(self.of_point());
        for ((state, point), functions) in states.zip(surface).zip(&self.points) {
            let local = point.local();
            let opening: [f64; 3] = std::array::from_fn(|c| local[c] - state[START + c]);
            let (own, history) = state.split_at_mut(OF_LAW);
            let traction = self.law.update(CohesivePoint { opening, history });
            let area = own[0];
            for c in 0..3 {
                let mean = 0.5 * (own[TRACTION + c] + traction[c]);
                work += area * mean * (opening[c] - own[OPENING + c]);
                (own[OPENING + c], own[TRACTION + c]) = (opening[c], traction[c]);
            }
            let load: V3 = point.axes.iter().zip(traction).map(|(axis, t)| area * t * axis).sum();
            point.add_forces(functions, &load, &mut force);
        }
        (force, work)
    }
}

impl Element for CohesiveElement {
    fn columns(&self) -> usize {
        FOUR * self.of_point()
    }

    fn names(&self) -> Vec<String> {
        let three = |what: &'static str| ["n", "s", "t"].map(|c| format!("{what} {c}"));
        let vectors = ["start", "opening", "traction"].into_iter().flat_map(three);
        let law = self.law.history().iter().map(|name| name.to_string());
        let point: Vec<String> =
            std::iter::once("area".to_string()).chain(vectors).chain(law).collect();
        (0..FOUR).flat_map(|p| point.iter().map(move |name| format!("{name} {p}"))).collect()
    }

    fn measure(&self, history: &mut [f64], x: &[[f64; 3]], _: OwnSection) {
        let surface = self.surface(&eight(x));
        for (state, point) in history.chunks_exact_mut(self.of_point()).zip(surface) {
            state[0] = point.area;
            state[START..OPENING].copy_from_slice(&point.local());
        }
    }

    fn corner_mass(&self, x: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        let surface = self.surface(&eight(x));
        let mass = self.mass(surface.iter().map(|point| [point.area, point.local()[0]]));
        (mass / NODES as f64, 0.0)
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        let nodes = pass.nodes;
        pass.one_by_one::<NODES>(self.columns(), |element, out| {
            let SingleElement { index, nodes: of_element, state, internal } = element;
            let slots = &mut out.force[index * NODES..(index + 1) * NODES];
            if self.is_removed(|column| state[column]) {
                slots.fill([0.0; 4]);
                return (f64::INFINITY, true);
            }
            let x = of_element.map(|node| V3::from(xyz(&nodes.x[node])));
            let surface = self.surface(&x);
            let (force, work) = self.respond(state, &surface);
            let start = self.at_start(|column| state[column]);
            let removed = self.is_removed(|column| state[column]);
            for (slot, force) in slots.iter_mut().zip(force) {
                (0..3).for_each(|c| slot[c] = if removed { 0.0 } else { force[c] });
            }
            *internal += work;
            if removed {
                return (f64::INFINITY, true);
            }
            let step = self.step(&surface, start.map(|s| s[0]), self.mass(start.into_iter()));
            (step, force.iter().all(|f| f.iter().all(|c| c.is_finite())))
        })
    }

    fn stable_dt(&self, x: &[[f64; 3]], _: OwnSection) -> f64 {
        let surface = self.surface(&eight(x));
        let mass = self.mass(surface.iter().map(|point| [point.area, point.local()[0]]));
        let areas = surface.each_ref().map(|point| point.area);
        self.step(&surface, areas, mass)
    }

    fn stable_dt_now(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> f64 {
        let start = self.at_start(|column| history.at(column));
        let mass = self.mass(start.into_iter());
        self.step(&self.surface(&eight(x)), start.map(|s| s[0]), mass)
    }

    fn failed(&self, history: ElementState<'_>) -> bool {
        self.is_removed(|column| history.at(column))
    }

    fn can_fail(&self) -> bool {
        self.failed_points > 0
    }

    /// The stress is `n T' + T n' - (T . n) n n'`, the mean over the points.
    fn fields(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> ElementFields {
        let surface = self.surface(&eight(x));
        let of_point = std::array::from_fn(|p| {
            let [n, s, t] = [0, 1, 2].map(|c| history.at(p * self.of_point() + TRACTION + c));
            let [normal, e1, e2] = surface[p].axes;
            let traction = n * normal + s * e1 + t * e2;
            let both = |i: usize, j: usize| {
                normal[i] * traction[j] + traction[i] * normal[j] - n * normal[i] * normal[j]
            };
            let pairs = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];
            ElementFields {
                stress: pairs.map(|[i, j]| both(i, j)),
                von_mises: (n * n + 3.0 * (s * s + t * t)).sqrt(),
                ..ElementFields::default()
            }
        });
        let all = ElementFields::of_points::<FOUR>(&of_point);
        ElementFields { failed: self.failed(history), ..all }
    }
}
