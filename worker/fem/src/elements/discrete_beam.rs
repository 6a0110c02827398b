//! Discrete beams: six springs and dampers between two nodes, which may coincide, along and about
//! three axes that rotate with the nodes.
//!
//! The axes R rotate with the angular velocity omega = p_1 w_1 + p_2 w_2 of the nodes: both weights
//! 1/2, or 1 for one of them. With the vector d from the first node to the second one,
//! ```text
//! u = R^T d - (R^T d)(0),   dtheta/dt = R^T (w_2 - w_1)
//! f_i = f_i(u_i) + g_i(du_i/dt),   m_i = m_i(theta_i) + h_i(dtheta_i/dt)
//! ```
//! and `F = R f`, `M = R m` act on the second node, the opposite on the first. The rate of u is
//! `R^T (v_2 - v_1 - omega x d)`, so virtual work adds the moments `-p_k d x F` at the nodes k:
//! they balance the couple of the forces, so that momentum and angular momentum are conserved. A
//! rigid motion leaves u and theta as they are and does no work. The angles are summed up, as those
//! of rotational springs are: for large relative rotations about several axes they depend on the
//! path.
//!
//! Each node has half of the mass m and of the inertia J. Stable step: a force has the softness `mu
//! = 4/m + 2 (p_1^2 + p_2^2) d^2/J`, a moment 4/J. With weights 1/2 both are independent of each
//! other; otherwise `k mu` and `c mu` of both are added, which bounds the largest frequency. The
//! step then follows from the amplification polynomial in `spring.rs`.
//!
//! Left out: preload, failure, yielding.

#[cfg(test)]
mod tests;

use super::spring::{ELONGATION, RATE, force_line};
use super::{
    Constructor, Discrete, Element, ElementEntry, ElementFields, ElementPass, ElementResult,
    PassTotals, SingleElement,
};
use crate::columns::ElementState;
use crate::piecewise_linear::PiecewiseLinear;
use crumple_math::row::{V3, xyz};
use crumple_proto::job::{DiscreteBeamInput, Part, TurningNode};
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::problem::Problem;
use nalgebra::{Quaternion, Rotation3, UnitQuaternion};

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "discrete_beam",
    shape: Shape::Line2,
    meaning: "Six springs and dampers between two nodes, in axes that rotate with them.",
    parameters: [&[], &[]],
    idle: |_| &[],
    build: Constructor::Discrete(build),
};

type AxesRotation = UnitQuaternion<f64>;

/// Columns: 1 if it has started, else 0; rotation of the axes as a quaternion; displacement at the
/// start and now [length], angles, in the axes; force on the second node and moments on both.
const STARTED: usize = 0;
const TURN: usize = 1;
const START: usize = 5;
const NOW: usize = 8;
const ANGLE: usize = 11;
const LOADS: usize = 14;
const COLUMNS: usize = 23;
/// Number of ends.
const ENDS: usize = 2;
/// Number of axes along and about which springs act.
const AXES: usize = 6;

/// Parameters of discrete beams.
pub struct DiscreteBeam {
    /// Mass [mass] and rotational inertia [mass length^2] of an element.
    mass: f64,
    inertia: f64,
    /// Rotation of the axes at the start.
    axes: AxesRotation,
    /// Weights of the nodes in the rotation of the axes.
    weights: [f64; ENDS],
    /// Functions of the displacement and of its rate, along r, s, t, then about them.
    elastic: [PiecewiseLinear; AXES],
    viscous: [PiecewiseLinear; AXES],
}

fn build(part: &Part) -> ElementResult {
    Ok(Box::new(read(part)?))
}

/// Returns the parameters of a part, or all that is wrong with it.
fn read(part: &Part) -> Result<DiscreteBeam, Vec<Problem>> {
    let mut problems = Vec::new();
    let mut say = |key: &str, what: String, help: &str| {
        problems.push(Problem::error(key, format!("part {}: {what}", part.label()), help));
    };
    let Some(input) = &part.discrete_beam else {
        say("discrete_beam", "it has no [part.discrete_beam]".into(), "add it");
        return Err(problems);
    };
    if !part.material.is_empty() {
        say("material", "a part of discrete beams has no material".into(), "remove it");
    }
    if part.element.is_some() {
        say("element", "discrete beams have one formulation".into(), "remove `element`");
    }
    if part.spring.is_some() {
        let what = "it has both [part.spring] and [part.discrete_beam]";
        say("spring", what.into(), "give springs their own part");
    }
    let mut say = |key: &str, what: String, help: &str| {
        say(&format!("discrete_beam.{key}"), what, help);
    };
    for (key, value) in [("mass", input.mass), ("inertia", input.inertia)] {
        if !(value > 0.0 && value.is_finite()) {
            say(key, format!("{key} is {value}"), "it has to be above 0");
        }
    }
    if input.spring.iter().all(|s| {
        let none = s.force_elongation.is_empty() && s.force_rate.is_empty();
        none && s.stiffness == 0.0 && s.damping == 0.0
    }) {
        let help = "give stiffness, damping or a table of forces on an axis";
        say("spring", "its discrete beams carry no force".into(), help);
    }
    let [r, s] = input.axes.map(V3::from);
    let axes =
        r.try_normalize(0.0).zip((s - r * (r.dot(&s) / r.norm_squared())).try_normalize(0.0));
    if !axes.is_some_and(|(r, s)| r.dot(&s).abs() < 1e-9) {
        let help = "give two directions that are not parallel, such as [[1, 0, 0], [0, 1, 0]]";
        say("axes", "its axes span no plane".into(), help);
    }
    let nothing = || std::array::from_fn(|_| PiecewiseLinear::new(&[], 0.0));
    let [mut elastic, mut viscous]: [[PiecewiseLinear; AXES]; 2] = [nothing(), nothing()];
    let mut seen = [false; AXES];
    for (number, spring) in input.spring.iter().enumerate() {
        let axis = spring.axis as usize;
        let mut wrong = |key: &str, what: String, help: &str| {
            say(&format!("spring.{number}.{key}"), what, help);
        };
        if std::mem::replace(&mut seen[axis], true) {
            wrong("axis", "an axis has two springs".into(), "give each axis one spring");
        }
        let (stiffness, damping) = (spring.stiffness, spring.damping);
        elastic[axis] = force_line(ELONGATION, stiffness, &spring.force_elongation, &mut wrong);
        viscous[axis] = force_line(RATE, damping, &spring.force_rate, &mut wrong);
    }
    let (Some((r, s)), true) = (axes, problems.is_empty()) else { return Err(problems) };
    let columns = [r, s, r.cross(&s)];
    Ok(DiscreteBeam {
        mass: input.mass,
        inertia: input.inertia,
        axes: AxesRotation::from_rotation_matrix(&Rotation3::from_basis_unchecked(&columns)),
        weights: weights(input),
        elastic,
        viscous,
    })
}

/// Returns the weights of the nodes in the rotation of the axes.
fn weights(input: &DiscreteBeamInput) -> [f64; ENDS] {
    match input.turns_with {
        TurningNode::Both => [0.5, 0.5],
        TurningNode::First => [1.0, 0.0],
        TurningNode::Second => [0.0, 1.0],
    }
}

/// Positions at the end of the step, and velocities at its middle, of both nodes.
struct NodeMotion {
    x: [V3; ENDS],
    v: [V3; ENDS],
    w: [V3; ENDS],
}

impl DiscreteBeam {
    /// Returns the force on the second node and the moments on both.
    fn respond(&self, state: &mut [f64], ends: &NodeMotion, dt: f64) -> [V3; 3] {
        let between = ends.x[1] - ends.x[0];
        let first = state[STARTED] == 0.0;
        let turned = match first {
            true => self.axes,
            false => {
                let rate = ends.w[0] * self.weights[0] + ends.w[1] * self.weights[1];
                let now = AxesRotation::from_scaled_axis(rate * dt) * turn_at(&state[TURN..]);
                AxesRotation::new_normalize(now.into_inner())
            }
        };
        state[TURN..TURN + 4].copy_from_slice(&[turned.w, turned.i, turned.j, turned.k]);
        let place = turned.inverse() * between;
        if first {
            state[STARTED] = 1.0;
            state[START..START + 3].copy_from_slice(place.as_slice());
            state[NOW..NOW + 3].copy_from_slice(place.as_slice());
        }
        let turning = turned.inverse() * (ends.w[1] - ends.w[0]);
        let mut loads = [0.0; AXES];
        for c in 0..3 {
            let before = std::mem::replace(&mut state[NOW + c], place[c]);
            let rate = if dt > 0.0 { (place[c] - before) / dt } else { 0.0 };
            state[ANGLE + c] += turning[c] * dt;
            let way = place[c] - state[START + c];
            loads[c] = self.elastic[c].value(way) + self.viscous[c].value(rate);
            loads[3 + c] =
                self.elastic[3 + c].value(state[ANGLE + c]) + self.viscous[3 + c].value(turning[c]);
        }
        let [force, moment] =
            [0, 3].map(|from| turned * V3::from_column_slice(&loads[from..from + 3]));
        let couple = between.cross(&force);
        [force, -moment - couple * self.weights[0], moment - couple * self.weights[1]]
    }

    /// Returns the stable step of an element with this distance of its nodes [time].
    fn step(&self, distance: f64) -> f64 {
        let steepest = |lines: &[PiecewiseLinear]| {
            lines.iter().map(PiecewiseLinear::steepest).fold(0.0, f64::max)
        };
        let arm: f64 = self.weights.iter().map(|p| p * p).sum();
        let along = 4.0 / self.mass + 2.0 * arm * distance * distance / self.inertia;
        let about = 4.0 / self.inertia;
        let of = |lines: &[PiecewiseLinear; AXES]| {
            [along * steepest(&lines[..3]), about * steepest(&lines[3..])]
        };
        let (stiffness, damping) = (of(&self.elastic), of(&self.viscous));
        let step = |stiffness: f64, damping: f64| {
            let both = Discrete { stiffness, damping, along_line: false, rotational: false };
            both.stable_dt(1.0)
        };
        match self.weights[0] == self.weights[1] {
            true => step(stiffness[0], damping[0]).min(step(stiffness[1], damping[1])),
            false => step(stiffness.iter().sum(), damping.iter().sum()),
        }
    }
}

fn turn_at(columns: &[f64]) -> AxesRotation {
    AxesRotation::new_unchecked(Quaternion::new(columns[0], columns[1], columns[2], columns[3]))
}

impl Element for DiscreteBeam {
    fn columns(&self) -> usize {
        COLUMNS
    }

    fn names(&self) -> Vec<String> {
        let several = |name: &'static str, count| (0..count).map(move |k| format!("{name} {k}"));
        std::iter::once("started".to_string())
            .chain(several("axes", START - TURN))
            .chain(several("place at the start", NOW - START))
            .chain(several("place", ANGLE - NOW))
            .chain(several("angle", LOADS - ANGLE))
            .chain(several("load", COLUMNS - LOADS))
            .collect()
    }

    fn corner_mass(&self, _: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        (0.5 * self.mass, 0.5 * self.inertia)
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        let (nodes, dt) = (pass.nodes, pass.dt);
        pass.one_by_one::<ENDS>(COLUMNS, |element, out| {
            let SingleElement { index, nodes: of_element, state, internal } = element;
            let at = |rows: &[[f64; 4]], c: usize| V3::from(xyz(&rows[of_element[c]]));
            let ends = NodeMotion {
                x: [0, 1].map(|c| at(nodes.x, c)),
                v: [0, 1].map(|c| at(nodes.v, c)),
                w: [0, 1].map(|c| at(nodes.w, c)),
            };
            let loads = self.respond(state, &ends, dt);
            let moves = [ends.v[1] - ends.v[0], ends.w[0], ends.w[1]];
            for ((now, moved), column) in loads.iter().zip(moves).zip((LOADS..).step_by(3)) {
                let before = V3::from_column_slice(&state[column..column + 3]);
                *internal += 0.5 * dt * (before + now).dot(&moved);
                state[column..column + 3].copy_from_slice(now.as_slice());
            }
            let slot = index * ENDS;
            let [force, first, second] = loads;
            for c in 0..3 {
                (out.force[slot][c], out.force[slot + 1][c]) = (-force[c], force[c]);
                (out.moment[slot][c], out.moment[slot + 1][c]) = (first[c], second[c]);
            }
            let sound = loads.iter().all(|load| load.iter().all(|c| c.is_finite()));
            (self.step((ends.x[1] - ends.x[0]).norm()), sound)
        })
    }

    fn stable_dt(&self, x: &[[f64; 3]], _: OwnSection) -> f64 {
        self.step((V3::from(x[1]) - V3::from(x[0])).norm())
    }

    fn has_dampers(&self) -> bool {
        self.viscous.iter().any(|line| line.steepest() > 0.0)
    }

    fn failed(&self, _: ElementState<'_>) -> bool {
        false
    }

    fn can_fail(&self) -> bool {
        false
    }

    fn fields(&self, _: ElementState<'_>, _: &[[f64; 3]]) -> ElementFields {
        ElementFields::default()
    }
}
