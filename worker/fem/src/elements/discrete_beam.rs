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
//! With `along_line`, r lies along d: R turns to it by the shortest rotation at the end of each
//! step, and the displacements along s and t are sums of those in the steps:
//! ```text
//! u_r = |d| - |d|(0),   du_s/dt = s . (v_2 - v_1 - omega x d),   alike along t
//! ```
//! As r is normal to omega x d, the forces and moments follow from virtual work as before.
//!
//! The functions of the displacement are those of springs, with or without a memory (`spring.rs`).
//! A spring has the displacement of the start added to u. A preload is added to its force; a spring
//! that yields has the elastic displacement of it added to u instead. With the limits u_i^+ and
//! u_i^- of the displacements and F_i of the forces, a beam fails if
//! ```text
//! together: sum (u_i/u_i^+-)^2 >= 1   or   sum (f_i/F_i)^2 >= 1
//! by sign:  the first sum for u_i > 0 and for u_i < 0 alone
//! any:      one term reaches 1
//! ```
//! It then has no force.
//!
//! Each node has half of the mass m and of the inertia J. Stable step: a force has the softness `mu
//! = 4/m + 2 (p_1^2 + p_2^2) d^2/J`, a moment 4/J. With weights 1/2 both are independent of each
//! other; otherwise `k mu` and `c mu` of both are added, which bounds the largest frequency. The
//! step then follows from the amplification polynomial in `spring.rs`. Across the line of
//! `along_line` a force along r has the stiffness F/|d|, which is below that along r: it is added
//! to that of s and t.

#[cfg(test)]
mod tests;

use super::spring::plastic::Plastic;
use super::spring::unloading::{BetweenCurves, PermanentSet};
use super::spring::{
    AddSpringProblem, ELONGATION, RATE, SpringLaw, SpringLawResult, boxed, force_line, number,
};
use super::{
    Constructor, Discrete, Element, ElementEntry, ElementFields, ElementPass, ElementResult,
    PassTotals, SingleElement,
};
use crate::columns::ElementState;
use crate::piecewise_linear::PiecewiseLinear;
use crumple_math::row::{V3, xyz};
use crumple_proto::job::{AxisSpring, BeamFailure, DiscreteBeamInput, Part, TurningNode};
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
/// start and now [length], angles, in the axes; force on the second node and moments on both; 1 if
/// it has failed; then those of the springs.
const STARTED: usize = 0;
const TURN: usize = 1;
const START: usize = 5;
const NOW: usize = 8;
const ANGLE: usize = 11;
const LOADS: usize = 14;
const FAILED: usize = 23;
const SPRINGS: usize = 24;
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
    /// True if r lies along the line between the nodes.
    along_line: bool,
    /// Springs along r, s, t, then about them.
    springs: [SpringOfAxis; AXES],
    /// Functions of the rate of the displacement, in the same order.
    viscous: [PiecewiseLinear; AXES],
    failure: BeamFailure,
}

/// The spring of an axis.
struct SpringOfAxis {
    law: Box<dyn SpringLaw>,
    /// First column of the law.
    column: usize,
    /// Displacement at the start [length], and what is added to it for the law.
    start: f64,
    elastic: f64,
    /// Force that is added to that of the law [force].
    preload: f64,
    /// Limits of positive and negative displacements [length], and of forces [force].
    limits: [Option<f64>; 3],
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
    if input.spring.iter().all(carries_nothing) {
        let help = "give stiffness, damping, a law or a table of forces on an axis";
        say("spring", "its discrete beams carry no force".into(), help);
    }
    let [r, s] = input.axes.map(V3::from);
    let axes =
        r.try_normalize(0.0).zip((s - r * (r.dot(&s) / r.norm_squared())).try_normalize(0.0));
    if !axes.is_some_and(|(r, s)| r.dot(&s).abs() < 1e-9) {
        let help = "give two directions that are not parallel, such as [[1, 0, 0], [0, 1, 0]]";
        say("axes", "its axes span no plane".into(), help);
    }
    let mut springs: [_; AXES] = std::array::from_fn(|_| SpringOfAxis::nothing());
    let mut viscous: [_; AXES] = std::array::from_fn(|_| PiecewiseLinear::new(&[], 0.0));
    let mut seen = [false; AXES];
    for (number, spring) in input.spring.iter().enumerate() {
        let axis = spring.axis as usize;
        let mut wrong = |key: &str, what: String, help: &str| {
            say(&format!("spring.{number}.{key}"), what, help);
        };
        if std::mem::replace(&mut seen[axis], true) {
            wrong("axis", "an axis has two springs".into(), "give each axis one spring");
        }
        springs[axis] = SpringOfAxis::read(spring, &mut wrong);
        viscous[axis] = force_line(RATE, spring.damping, &spring.force_rate, &mut wrong);
    }
    if input.failure != BeamFailure::default()
        && springs.iter().all(|spring| spring.limits == [None; 3])
    {
        let help = "give `failure_tension`, `failure_compression` or `failure_force` on an axis";
        say("failure", "no axis has a limit".into(), help);
    }
    // A force on r turns with the line: the stable step counts that of the stiffness only.
    let [along, ..] = &springs;
    if input.along_line && (along.preload != 0.0 || along.elastic != 0.0 || along.start != 0.0) {
        let help = "remove `along_line`, or the preload and the initial displacement on r";
        say("along_line", "the spring on r has a force at the start".into(), help);
    }
    let mut column = SPRINGS;
    for spring in &mut springs {
        spring.column = column;
        column += spring.law.names().len();
    }
    let (Some((r, s)), true) = (axes, problems.is_empty()) else { return Err(problems) };
    let columns = [r, s, r.cross(&s)];
    let beam = DiscreteBeam {
        mass: input.mass,
        inertia: input.inertia,
        axes: AxesRotation::from_rotation_matrix(&Rotation3::from_basis_unchecked(&columns)),
        weights: weights(input),
        along_line: input.along_line,
        springs,
        viscous,
        failure: input.failure,
    };
    let starts = [|s: &SpringOfAxis| s.start, |s: &SpringOfAxis| s.preload]
        .map(|of| std::array::from_fn(|c| of(&beam.springs[c])));
    if beam.fails(&starts[0], &starts[1]) {
        let what = format!("part {}: its beams fail at the start", part.label());
        let help = "give larger limits, or a smaller preload or initial displacement";
        return Err(vec![Problem::error("discrete_beam.spring", what, help)]);
    }
    Ok(beam)
}

/// Returns true for a spring without any force.
fn carries_nothing(spring: &AxisSpring) -> bool {
    let numbers = [spring.stiffness, spring.damping, spring.preload];
    numbers == [0.0; 3]
        && spring.force_elongation.is_empty()
        && spring.force_rate.is_empty()
        && spring.yielding.is_none()
        && spring.hysteresis.is_none()
        && spring.between_curves.is_none()
        && spring.permanent_set.is_none()
}

impl SpringOfAxis {
    fn nothing() -> Self {
        let law = Box::new(PiecewiseLinear::new(&[], 0.0));
        let [start, elastic, preload] = [0.0; 3];
        Self { law, column: SPRINGS, start, elastic, preload, limits: [None; 3] }
    }

    /// Reads the function of the displacement and the limits; reports what is wrong.
    fn read(input: &AxisSpring, say: &mut AddSpringProblem<'_>) -> Self {
        let line = force_line(ELONGATION, input.stiffness, &input.force_elongation, say);
        let any = |key: &str, value: f64, say: &mut AddSpringProblem<'_>| {
            number(key, value, "a number", |_| true, say);
        };
        any("preload", input.preload, say);
        any("initial_displacement", input.initial_displacement, say);
        let limits = [
            ("failure_tension", input.failure_tension),
            ("failure_compression", input.failure_compression),
            ("failure_force", input.failure_force),
        ];
        for (key, limit) in limits {
            if let Some(limit) = limit {
                number(key, limit, "above 0", |limit| limit > 0.0, say);
            }
        }
        let mut own = Self {
            start: input.initial_displacement,
            preload: input.preload,
            limits: limits.map(|(_, limit)| limit),
            ..Self::nothing()
        };
        let is_elastic = input.stiffness != 0.0 || !input.force_elongation.is_empty();
        let given = [
            ("stiffness or force_elongation", is_elastic),
            ("yielding", input.yielding.is_some()),
            ("hysteresis", input.hysteresis.is_some()),
            ("between_curves", input.between_curves.is_some()),
            ("permanent_set", input.permanent_set.is_some()),
        ];
        let given: Vec<_> = given.into_iter().filter(|(_, given)| *given).map(|g| g.0).collect();
        if let [first, second, ..] = given[..] {
            say(second, format!("an axis has both {first} and {second}"), "give one of them");
        }
        if let Some(yielding) = &input.yielding {
            if let Some(law) = Plastic::yielding(yielding, say) {
                let [least, most] = law.first_yield();
                if !(least..=most).contains(&input.preload) {
                    let what = format!("preload is {:?}, beyond the yield force", input.preload);
                    say("preload", what, "give a smaller preload");
                }
                own.law = Box::new(law);
            }
            own.elastic = std::mem::take(&mut own.preload) / yielding.stiffness;
            return own;
        }
        let law = with_memory(input, say);
        if law.is_some() && input.preload != 0.0 {
            let what = "a spring with this law has no preload".into();
            say("preload", what, "remove it, or give an initial_displacement");
        }
        own.law = law.flatten().unwrap_or_else(|| Box::new(line));
        own
    }
}

/// Returns the law of a spring that unloads by a rule of its own, if it has one.
fn with_memory(input: &AxisSpring, say: &mut AddSpringProblem<'_>) -> Option<SpringLawResult> {
    if let Some(input) = &input.hysteresis {
        return Some(boxed(Plastic::hysteresis(input, say)));
    }
    if let Some(input) = &input.between_curves {
        return Some(boxed(BetweenCurves::new(input, say)));
    }
    let input = input.permanent_set.as_ref()?;
    Some(boxed(PermanentSet::new(input, say)))
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
        if state[FAILED] > 0.5 {
            return [V3::zeros(); 3];
        }
        let between = ends.x[1] - ends.x[0];
        let first = state[STARTED] == 0.0;
        let mut turned = match first {
            true => self.axes,
            false => {
                let rate = ends.w[0] * self.weights[0] + ends.w[1] * self.weights[1];
                let now = AxesRotation::from_scaled_axis(rate * dt) * turn_at(&state[TURN..]);
                AxesRotation::new_normalize(now.into_inner())
            }
        };
        if first && self.along_line {
            turned = onto_line(turned, &between);
        }
        let mut place = turned.inverse() * between;
        if first {
            state[STARTED] = 1.0;
            state[START..START + 3].copy_from_slice(place.as_slice());
            state[NOW..NOW + 3].copy_from_slice(place.as_slice());
        } else if self.along_line {
            let across = place;
            turned = onto_line(turned, &between);
            place = turned.inverse() * between;
            // The displacements across the line remain as they are in the axes before.
            for c in 1..3 {
                state[START + c] += place[c] - across[c];
                state[NOW + c] += place[c] - across[c];
            }
        }
        state[TURN..TURN + 4].copy_from_slice(&[turned.w, turned.i, turned.j, turned.k]);
        let turning = turned.inverse() * (ends.w[1] - ends.w[0]);
        let [mut ways, mut rates] = [[0.0; AXES]; 2];
        for c in 0..3 {
            let before = std::mem::replace(&mut state[NOW + c], place[c]);
            state[ANGLE + c] += turning[c] * dt;
            ways[c] = place[c] - state[START + c];
            ways[3 + c] = state[ANGLE + c];
            rates[c] = if dt > 0.0 { (place[c] - before) / dt } else { 0.0 };
            rates[3 + c] = turning[c];
        }
        let mut loads = [0.0; AXES];
        for (c, spring) in self.springs.iter().enumerate() {
            ways[c] += spring.start;
            let columns = &mut state[spring.column..];
            let elastic = spring.law.force(columns, ways[c] + spring.elastic, dt);
            loads[c] = spring.preload + elastic + self.viscous[c].value(rates[c]);
        }
        if self.fails(&ways, &loads) {
            state[FAILED] = 1.0;
            return [V3::zeros(); 3];
        }
        let [force, moment] =
            [0, 3].map(|from| turned * V3::from_column_slice(&loads[from..from + 3]));
        let couple = between.cross(&force);
        [force, -moment - couple * self.weights[0], moment - couple * self.weights[1]]
    }

    /// Returns true if a beam fails with these displacements and forces.
    fn fails(&self, ways: &[f64; AXES], loads: &[f64; AXES]) -> bool {
        let (mut positive, mut negative, mut force, mut largest) = (0.0, 0.0, 0.0, 0.0f64);
        for (c, spring) in self.springs.iter().enumerate() {
            let ratio = |value: f64, limit: Option<f64>| {
                limit.map_or(0.0, |limit| (value / limit) * (value / limit))
            };
            let [tension, compression, strength] = spring.limits;
            let of_way = [ratio(ways[c].max(0.0), tension), ratio(ways[c].min(0.0), compression)];
            let of_force = ratio(loads[c], strength);
            positive += of_way[0];
            negative += of_way[1];
            force += of_force;
            largest = largest.max(of_way[0]).max(of_way[1]).max(of_force);
        }
        match self.failure {
            BeamFailure::Together => positive + negative >= 1.0 || force >= 1.0,
            BeamFailure::BySign => positive >= 1.0 || negative >= 1.0 || force >= 1.0,
            BeamFailure::Any => largest >= 1.0,
        }
    }

    /// Returns the stable step of an element with this distance of its nodes [time].
    fn step(&self, distance: f64) -> f64 {
        let arm: f64 = self.weights.iter().map(|p| p * p).sum();
        let along = 4.0 / self.mass + 2.0 * arm * distance * distance / self.inertia;
        let about = 4.0 / self.inertia;
        let of = |slopes: [f64; AXES]| {
            let [r, s, t, rr, rs, rt] = slopes;
            let across = s.max(t);
            let force = if self.along_line { r + across } else { r.max(across) };
            [along * force, about * rr.max(rs).max(rt)]
        };
        let stiffness = of(std::array::from_fn(|c| self.springs[c].law.steepest()));
        let damping = of(std::array::from_fn(|c| self.viscous[c].steepest()));
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

/// Returns the axes after the shortest rotation of their first axis to a line; as they are if it
/// has no length.
fn onto_line(axes: AxesRotation, line: &V3) -> AxesRotation {
    let turn = AxesRotation::rotation_between(&(axes * V3::x()), line);
    turn.map_or(axes, |turn| AxesRotation::new_normalize((turn * axes).into_inner()))
}

fn turn_at(columns: &[f64]) -> AxesRotation {
    AxesRotation::new_unchecked(Quaternion::new(columns[0], columns[1], columns[2], columns[3]))
}

impl Element for DiscreteBeam {
    fn columns(&self) -> usize {
        SPRINGS + self.springs.iter().map(|spring| spring.law.names().len()).sum::<usize>()
    }

    fn names(&self) -> Vec<String> {
        let several = |name: &'static str, count| (0..count).map(move |k| format!("{name} {k}"));
        std::iter::once("started".to_string())
            .chain(several("axes", START - TURN))
            .chain(several("place at the start", NOW - START))
            .chain(several("place", ANGLE - NOW))
            .chain(several("angle", LOADS - ANGLE))
            .chain(several("load", FAILED - LOADS))
            .chain(std::iter::once("failed".to_string()))
            .chain(self.springs.iter().enumerate().flat_map(|(axis, spring)| {
                spring.law.names().iter().map(move |name| format!("spring {axis} {name}"))
            }))
            .collect()
    }

    fn corner_mass(&self, _: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        (0.5 * self.mass, 0.5 * self.inertia)
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        let (nodes, dt) = (pass.nodes, pass.dt);
        pass.one_by_one::<ENDS>(self.columns(), |element, out| {
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
            if state[FAILED] > 0.5 {
                return (f64::INFINITY, true);
            }
            let sound = loads.iter().all(|load| load.iter().all(|c| c.is_finite()));
            (self.step((ends.x[1] - ends.x[0]).norm()), sound)
        })
    }

    fn stable_dt(&self, x: &[[f64; 3]], _: OwnSection) -> f64 {
        let distance = (V3::from(x[1]) - V3::from(x[0])).norm();
        if self.along_line && distance == 0.0 { f64::NAN } else { self.step(distance) }
    }

    fn has_dampers(&self) -> bool {
        self.viscous.iter().any(|line| line.steepest() > 0.0)
    }

    fn failed(&self, history: ElementState<'_>) -> bool {
        history.at(FAILED) > 0.5
    }

    fn can_fail(&self) -> bool {
        self.springs.iter().any(|spring| spring.limits != [None; 3])
    }

    fn fields(&self, history: ElementState<'_>, _: &[[f64; 3]]) -> ElementFields {
        ElementFields { failed: self.failed(history), ..ElementFields::default() }
    }
}
