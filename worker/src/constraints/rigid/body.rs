//! State and motion of one rigid body.
//!
//! The state consists of momentum and angular momentum in space at mid-steps, and of position
//! and orientation at whole steps. Only impulses change momenta, so a free body conserves them
//! to the last bit. Orientation follows from the implicit midpoint rule with Cayley's map
//! (Austin, Krishnaprasad & Wang 1993): the angular momentum P in body axes satisfies `P1 - P0
//! = dt (P0 + P1)/2 x J^-1 (P0 + P1)/2`, which conserves the energy of a free body too. Where
//! rotations are fixed or prescribed, the exponential map is used instead, so that a prescribed
//! rotation is exact.

use crate::constraints::prescribed::MotionCurve;
use crate::curve::Curve;
use crate::math::row::V3;
use crate::work::Work;
use crumple_proto::loads::PrescribedMotion;
use crumple_proto::rigid::{BodyLoad, BodyStop, RigidBody};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// Largest numbers of Newton steps and of fixed-point steps of a rotation. Newton converges
/// quadratically, the fixed-point iteration by a factor of the angle per step.
const NEWTON: usize = 12;
const FIXED_POINT: usize = 40;
/// Distance beyond a bound due to round-off, over the sizes of both coordinates.
const ROUNDING: f64 = 1e-9;

/// Rigid body.
#[derive(Debug, Serialize, Deserialize)]
pub struct Body {
    /// Mass [mass].
    pub mass: f64,
    /// Inertia about the centre in body axes, which are the axes of space at time 0 [mass
    /// length^2].
    pub inertia: Matrix3<f64>,
    inverse: Matrix3<f64>,
    /// Largest change of rotational velocity per unit angular impulse [1/(mass length^2)].
    pub softest: f64,
    /// True for each degree of freedom that is fixed or prescribed at present: translations, then
    /// rotations.
    held: [bool; 6],
    /// True for each fixed one; not part of a checkpoint.
    #[serde(skip)]
    fixed: [bool; 6],
    /// Prescribed motions; not part of a checkpoint.
    #[serde(skip)]
    courses: Vec<(u64, MotionCurve)>,
    /// Bounds of the centre; not part of a checkpoint.
    #[serde(skip)]
    bounds: Vec<StopBound>,
    /// Loads with their curves; not part of a checkpoint.
    #[serde(skip)]
    loads: Vec<(BodyLoad, Option<Curve>)>,
    /// Impulse and angular impulse of the loads in the step.
    #[serde(skip)]
    pub loaded: (V3, V3),
    /// Inward normal of each bound that acts in the step, and the distance from the centre to the
    /// bound at the end of the step [length].
    #[serde(skip)]
    pub limits: Vec<(V3, f64)>,
    start: V3,
    /// Rotational velocities at the last and next mid-step [1/time].
    pub last_spin: V3,
    /// See `last_spin`.
    pub next_spin: V3,
    next_turn: UnitQuaternion<f64>,
    /// Angular impulse of the prescribed motion in the step [mass length^2/time].
    led_angular: V3,
    /// Centre of mass [length].
    pub centre: V3,
    /// Orientation relative to time 0.
    pub turn: UnitQuaternion<f64>,
    /// Velocity and angular momentum about the centre at the last mid-step.
    pub last: Momentum,
    /// Velocity and angular momentum about the centre at the next mid-step.
    pub next: Momentum,
    /// Change of rotational velocity per unit angular impulse at the present orientation, zero
    /// along fixed axes.
    mobility: Matrix3<f64>,
    /// Rotational velocity at zero angular momentum: the prescribed part and its consequences
    /// [1/time].
    base: V3,
}

/// Part of the state of a body at the end of a step, see [`Body::end_state`].
#[derive(Clone, Copy, Debug)]
pub struct EndState {
    next: Momentum,
    next_turn: UnitQuaternion<f64>,
    next_spin: V3,
    led_angular: V3,
}

/// Velocity of the centre and angular momentum about it, in space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Momentum {
    /// Velocity [length/time].
    pub velocity: V3,
    /// Angular momentum [mass length^2/time].
    pub angular: V3,
    /// Impulse of the step so far, including constrained directions [force time].
    lead: V3,
}

impl Momentum {
    /// Builds it from velocity and angular momentum.
    pub fn new(velocity: V3, angular: V3) -> Self {
        Self { velocity, angular, lead: V3::zeros() }
    }
}

/// A bound of the motion of the centre.
#[derive(Debug)]
struct StopBound {
    /// Unit vector towards the side on which the centre may be.
    inward: V3,
    /// Factor on the curve: its values are along the direction of the stop.
    sign: f64,
    curve: Curve,
    of_position: bool,
    window: Option<[f64; 2]>,
}

impl StopBound {
    /// Returns its coordinate along the inward normal [length].
    fn at(&self, time: f64) -> f64 {
        self.sign * self.curve.value(time)
    }

    /// Returns the distance from the centre, which started at `start`, to the bound at the end of
    /// the step [length]. A centre that is beyond the bound is not moved back, but by a bound that
    /// moves against it.
    fn gap(&self, centre: &V3, start: &V3, (time, dt): (f64, f64)) -> f64 {
        let from = if self.of_position { V3::zeros() } else { *start };
        let (place, bound) = (self.inward.dot(&(centre - from)), self.at(time + dt));
        let against = (self.at(time) - bound).min(0.0);
        let rounding = ROUNDING * (self.inward.dot(centre).abs() + bound.abs());
        let gap = place - bound;
        if gap < against - rounding { against } else { gap }
    }
}

/// Returns the bounds of a body.
fn bounds(job: &RigidBody, curves: &[Vec<[f64; 2]>]) -> Vec<StopBound> {
    let of = |stop: &BodyStop| {
        let along = V3::from(stop.direction);
        let bound = |curve: usize, sign: f64| StopBound {
            inward: along * sign,
            sign,
            curve: Curve::new(&curves[curve]),
            of_position: stop.of_position,
            window: stop.window,
        };
        let lower = stop.lower.map(|curve| bound(curve, 1.0));
        lower.into_iter().chain(stop.upper.map(|curve| bound(curve, -1.0))).collect::<Vec<_>>()
    };
    job.stops.iter().flat_map(of).collect()
}

/// Returns the loads of a body with their curves.
fn loads(job: &RigidBody, curves: &[Vec<[f64; 2]>]) -> Vec<(BodyLoad, Option<Curve>)> {
    let curve = |load: &BodyLoad| load.curve.map(|curve| Curve::new(&curves[curve]));
    job.loads.iter().map(|load| (load.clone(), curve(load))).collect()
}

/// Returns the prescribed motions of a body with their degrees of freedom.
fn courses(job: &RigidBody, curves: &[Vec<[f64; 2]>]) -> Vec<(u64, MotionCurve)> {
    job.motions.iter().map(|m| (m.dofs, MotionCurve::new(m, curves))).collect()
}

/// Returns true for each degree of freedom that is fixed, or prescribed by a motion that `acts`.
fn held(job: &RigidBody, acts: impl Fn(&PrescribedMotion) -> bool) -> [bool; 6] {
    let motions = job.motions.iter().filter(|m| acts(m));
    let bits = motions.fold(job.fixed, |bits, m| bits | m.dofs);
    std::array::from_fn(|c| bits >> c & 1 == 1)
}

impl Body {
    /// Returns true if it has the constraints of a job's body, and a possible mass, place and
    /// orientation.
    pub fn fits(&self, job: &RigidBody) -> bool {
        let vectors = [self.centre, self.last.velocity, self.last.angular, self.last_spin];
        // Round-off of a run is many orders smaller; other numbers are no turn.
        let is_turn = |q: &UnitQuaternion<f64>| (q.norm() - 1.0).abs() < 1e-3;
        let (least, most) = (held(job, |m| m.window.is_none()), held(job, |_| true));
        let is_possible = |c: usize| least[c] <= self.held[c] && self.held[c] <= most[c];
        (0..6).all(is_possible)
            && self.mass.is_finite()
            && self.mass >= 0.0
            && vectors.iter().flat_map(|v| v.iter()).all(|a| a.is_finite())
            && is_turn(&self.turn)
            && is_turn(&self.next_turn)
    }

    /// Sets the prescribed motions of a body from a checkpoint.
    pub fn restore(&mut self, job: &RigidBody, given: &[Vec<[f64; 2]>]) {
        self.courses = courses(job, given);
        self.bounds = bounds(job, given);
        self.loads = loads(job, given);
        self.fixed = held(job, |_| false);
    }

    /// Builds a body at time 0.
    pub fn new(
        job: &RigidBody,
        curves: &[Vec<[f64; 2]>],
        mass: f64,
        inertia: Matrix3<f64>,
        centre: V3,
        moves: Momentum,
    ) -> Self {
        let smallest = inertia.symmetric_eigenvalues().min();
        let inverse = inertia.try_inverse().unwrap_or_else(Matrix3::zeros);
        let mut last = moves;
        for c in (0..3).filter(|c| job.fixed >> c & 1 == 1) {
            last.velocity[c] = 0.0;
        }
        let mut spin = inverse * last.angular;
        if job.fixed >> 3 != 0 {
            (0..3).filter(|c| job.fixed >> (c + 3) & 1 == 1).for_each(|c| spin[c] = 0.0);
            last.angular = inertia * spin;
        }
        Self {
            mass,
            inertia,
            inverse,
            softest: if smallest > 0.0 { 1.0 / smallest } else { 0.0 },
            held: held(job, |m| m.acts_at(0.0)),
            fixed: held(job, |_| false),
            courses: courses(job, curves),
            bounds: bounds(job, curves),
            loads: loads(job, curves),
            loaded: (V3::zeros(), V3::zeros()),
            limits: Vec::new(),
            start: centre,
            centre,
            turn: UnitQuaternion::identity(),
            last,
            next: last,
            last_spin: spin,
            next_spin: spin,
            next_turn: UnitQuaternion::identity(),
            led_angular: V3::zeros(),
            mobility: Matrix3::zeros(),
            base: V3::zeros(),
        }
    }

    /// Returns true if all degrees of freedom are fixed or prescribed.
    pub fn is_prescribed(&self) -> bool {
        self.held.iter().all(|&h| h)
    }

    /// Prepares a step: fixed and prescribed velocities, and the mobility at the present
    /// orientation.
    pub fn start_step(&mut self, time: f64, dt: f64) {
        if self.courses.iter().any(|(_, course)| course.is_timed()) {
            let acting = self.courses.iter().filter(|(_, course)| course.acts_at(time));
            let bits = acting.fold(0, |bits, (dofs, _)| bits | dofs);
            self.held = std::array::from_fn(|c| self.fixed[c] || bits >> c & 1 == 1);
        }
        self.next = self.last;
        self.led_angular = V3::zeros();
        let (velocity, spin) = self.prescribed_velocities(time, dt);
        for c in (0..3).filter(|&c| self.held[c]) {
            self.next.velocity[c] = velocity[c];
        }
        (self.mobility, self.base) = self.answer(&self.turn, &spin);
        let acts =
            |b: &&StopBound| b.window.is_none_or(|[from, until]| from <= time && time < until);
        let limit = |b: &StopBound| (b.inward, b.gap(&self.centre, &self.start, (time, dt)));
        self.limits = self.bounds.iter().filter(acts).map(limit).collect();
    }

    /// Returns the velocity and rotational velocity of fixed and prescribed degrees of freedom
    /// in the step.
    fn prescribed_velocities(&self, time: f64, dt: f64) -> (V3, V3) {
        let (mut velocity, mut spin) = (V3::zeros(), V3::zeros());
        for (dofs, course) in self.courses.iter().filter(|(_, course)| course.acts_at(time)) {
            let (next, increment) = (course.amount(time + dt), course.increment(time, dt));
            let turns = course.form.centre().is_some();
            for c in 0..3 {
                if dofs >> c & 1 == 1 && !turns {
                    velocity[c] = match course.is_timed() {
                        true => increment[c] / dt,
                        false => (self.start[c] + next[c] - self.centre[c]) / dt,
                    };
                }
                if dofs >> (c + 3) & 1 == 1 && turns {
                    spin[c] = increment[c] / dt;
                }
            }
        }
        (velocity, spin)
    }

    /// Returns mobility and base at an orientation. With free axes S and the prescribed
    /// rotational velocity p, `w = p + S (S' J S)^-1 S' (L - J p)`.
    fn answer(&self, turn: &UnitQuaternion<f64>, spin: &V3) -> (Matrix3<f64>, V3) {
        let r = turn.to_rotation_matrix().into_inner();
        let held = &self.held[3..];
        if !held.contains(&true) {
            return (r * self.inverse * r.transpose(), V3::zeros());
        }
        let inertia = r * self.inertia * r.transpose();
        let mut free = inertia;
        for c in (0..3).filter(|&c| held[c]) {
            free.set_row(c, &nalgebra::RowVector3::zeros());
            free.set_column(c, &V3::zeros());
            free[(c, c)] = 1.0;
        }
        let mut mobility = free.try_inverse().unwrap_or_else(Matrix3::zeros);
        for c in (0..3).filter(|&c| held[c]) {
            mobility[(c, c)] = 0.0;
        }
        (mobility, spin - mobility * (inertia * spin))
    }

    /// Adds an impulse and an angular impulse about the centre.
    pub fn add_impulse(&mut self, impulse: &V3, angular: &V3) {
        for c in (0..3).filter(|&c| !self.held[c]) {
            self.next.velocity[c] += impulse[c] / self.mass;
        }
        self.next.angular += angular;
        self.next.lead += impulse;
    }

    /// Adds the impulses of the loads at a time, in the order of the job, over a velocity step.
    pub fn add_loads(&mut self, time: f64, mid: f64) {
        if self.loads.is_empty() {
            return;
        }
        let (mut force, mut moment) = (V3::zeros(), V3::zeros());
        for (load, curve) in &self.loads {
            let factor = curve.as_ref().map_or(1.0, |curve| curve.value(time));
            let in_space = |v: [f64; 3]| match load.follows {
                true => self.turn * V3::from(v),
                false => V3::from(v),
            };
            force += in_space(load.force) * factor;
            moment += in_space(load.moment) * factor;
        }
        self.loaded = (force * mid, moment * mid);
        let (impulse, angular) = self.loaded;
        self.add_impulse(&impulse, &angular);
    }

    /// Applies damping by `b` (see `loads.rs`); returns the impulses.
    pub fn damp(&mut self, b: f64) -> (V3, V3) {
        if b == 0.0 {
            return (V3::zeros(), V3::zeros());
        }
        let by = -b / (1.0 + b);
        let impulse = (self.next.velocity + self.last.velocity) * (self.mass * by);
        self.apply_damping(impulse, (self.next.angular + self.last.angular) * by)
    }

    /// Applies damping impulses, which are zero in constrained directions; returns the applied
    /// ones.
    pub fn apply_damping(&mut self, mut impulse: V3, angular: V3) -> (V3, V3) {
        for c in (0..3).filter(|&c| self.held[c]) {
            impulse[c] = 0.0;
        }
        self.add_impulse(&impulse, &angular);
        (impulse, angular)
    }

    /// Returns the rotational velocity at an angular momentum and the present orientation
    /// [1/time].
    pub fn spin(&self, angular: &V3) -> V3 {
        self.base + self.mobility * angular
    }

    /// Returns the rotational velocity at the next mid-step, with the mobility at the present
    /// orientation [1/time].
    pub fn present_spin(&self) -> V3 {
        self.spin(&self.next.angular)
    }

    /// Returns the velocity at the next mid-step of a point at `arm` from the centre, with the
    /// mobility at the present orientation [length/time].
    pub fn velocity_at(&self, arm: &V3) -> V3 {
        self.next.velocity + self.present_spin().cross(arm)
    }

    /// Returns the changes of velocity and rotational velocity by an impulse at the centre and an
    /// angular impulse, at the present orientation.
    pub fn reply(&self, impulse: &V3, angular: &V3) -> (V3, V3) {
        let mut moved = impulse / self.mass;
        (0..3).filter(|&c| self.held[c]).for_each(|c| moved[c] = 0.0);
        (moved, self.mobility * angular)
    }

    /// Returns the changes as [`Body::reply`], as if no degree of freedom were held.
    pub fn open_reply(&self, impulse: &V3, angular: &V3) -> (V3, V3) {
        let r = self.turn.to_rotation_matrix().into_inner();
        (impulse / self.mass, r * (self.inverse * (r.transpose() * angular)))
    }

    /// Returns the change of velocity along `direction` at `arm` per unit impulse in that
    /// direction [1/mass].
    pub fn compliance(&self, arm: &V3, direction: &V3) -> f64 {
        let moved: f64 = (0..3)
            .filter(|&c| !self.held[c])
            .map(|c| direction[c] * direction[c] / self.mass)
            .sum();
        let lever = arm.cross(direction);
        moved + lever.dot(&(self.mobility * lever))
    }

    /// Computes the orientation at the end of the step, and the rotational velocity that leads
    /// to it.
    pub fn rotate(&mut self, time: f64, dt: f64) {
        (self.next_turn, self.next_spin) = self.rotated(time, dt);
        if self.held[3..].contains(&true) {
            // Along constrained axes the angular momentum follows from the motion.
            let r = self.turn.to_rotation_matrix().into_inner();
            let taken = r * self.inertia * r.transpose() * self.next_spin;
            for c in (0..3).filter(|&c| self.held[c + 3]) {
                self.led_angular[c] += taken[c] - self.next.angular[c];
                self.next.angular[c] = taken[c];
            }
        }
    }

    /// Returns the part of the state at the end of the step that joints change.
    pub fn end_state(&self) -> EndState {
        EndState {
            next: self.next,
            next_turn: self.next_turn,
            next_spin: self.next_spin,
            led_angular: self.led_angular,
        }
    }

    /// Sets the part of the state at the end of the step that joints change.
    pub fn set_end_state(&mut self, state: &EndState) {
        let EndState { next, next_turn, next_spin, led_angular } = *state;
        (self.next, self.next_turn, self.next_spin) = (next, next_turn, next_spin);
        self.led_angular = led_angular;
    }

    /// Returns the centre and the rotation R at present: a member is at `c + R r`, where r is
    /// its position relative to the centre at time 0.
    pub fn frame(&self) -> (V3, Matrix3<f64>) {
        (self.centre, self.turn.to_rotation_matrix().into_inner())
    }

    /// Returns the centre and the rotation at the end of the step.
    pub fn next_frame(&self, dt: f64) -> (V3, Matrix3<f64>) {
        (self.centre + self.next.velocity * dt, self.next_turn.to_rotation_matrix().into_inner())
    }

    /// Returns the work of impulses in the step.
    pub fn work(&self, impulse: &V3, angular: &V3) -> Work {
        let with = |velocity: &V3, spin: &V3| 0.5 * (impulse.dot(velocity) + angular.dot(spin));
        Work {
            before: with(&self.last.velocity, &self.last_spin),
            after: with(&self.next.velocity, &self.next_spin),
        }
    }

    /// Returns the work of the prescribed motion in the step.
    pub fn prescribed_work(&self) -> Work {
        let mut impulse = (self.next.velocity - self.last.velocity) * self.mass - self.next.lead;
        for c in (0..3).filter(|&c| !self.held[c]) {
            impulse[c] = 0.0;
        }
        self.work(&impulse, &self.led_angular)
    }

    fn rotated(&self, time: f64, dt: f64) -> (UnitQuaternion<f64>, V3) {
        let momentum = self.next.angular;
        if !self.held[3..].contains(&true) {
            return self.rotated_without_moment(&momentum, dt);
        }
        let (_, spin) = self.prescribed_velocities(time, dt);
        let mut w = self.spin(&momentum);
        for _ in 0..FIXED_POINT {
            let middle = UnitQuaternion::from_scaled_axis(w * (0.5 * dt)) * self.turn;
            let (mobility, base) = self.answer(&middle, &spin);
            let new = base + mobility * momentum;
            let settled = new == w;
            w = new;
            if settled {
                break;
            }
        }
        (UnitQuaternion::from_scaled_axis(w * dt) * self.turn, w)
    }

    fn rotated_without_moment(&self, momentum: &V3, dt: f64) -> (UnitQuaternion<f64>, V3) {
        // In body axes: Newton's method for the mean P of the angular momenta before and after.
        let start = self.turn.inverse_transform_vector(momentum);
        let mut mean = start;
        for _ in 0..NEWTON {
            let w = self.inverse * mean;
            let left = mean - mean.cross(&w) * (0.5 * dt) - start;
            let slope = Matrix3::identity()
                - (mean.cross_matrix() * self.inverse - w.cross_matrix()) * (0.5 * dt);
            let Some(change) = slope.try_inverse().map(|s| s * left) else { break };
            mean -= change;
            if change.norm() <= 0.25 * f64::EPSILON * mean.norm() {
                break;
            }
        }
        let w = self.inverse * mean;
        let half = w * (0.5 * dt);
        // Cayley's map, as a quaternion.
        let by = UnitQuaternion::from_quaternion(Quaternion::new(1.0, half.x, half.y, half.z));
        let turn = UnitQuaternion::from_quaternion((self.turn * by).into_inner());
        (turn, self.turn * w)
    }

    /// Ends the step.
    pub fn advance(&mut self, dt: f64) {
        self.turn = self.next_turn;
        self.centre += self.next.velocity * dt;
        self.last = Momentum { lead: V3::zeros(), ..self.next };
        self.last_spin = self.next_spin;
    }

    /// Returns the kinetic energy of a free body at the present orientation with the last
    /// momenta [energy].
    pub fn energy(&self) -> f64 {
        let own = self.turn.inverse_transform_vector(&self.last.angular);
        0.5 * (self.mass * self.last.velocity.norm_squared() + own.dot(&(self.inverse * own)))
    }
}
