//! Rows of joints: gaps and their derivatives, by the kind of the joint.

use super::body::Body;
use super::joints::{JointState, REGULAR};
use crate::math::row::V3;
use crate::piecewise_linear::PiecewiseLinear;
use crate::time::StepSizes;
use crumple_proto::job::JointKind;
use crumple_proto::joint::{Resistance, ResolvedJoint};
use nalgebra::{DMatrix, DVector, Matrix3};
use std::f64::consts::TAU;

/// One scalar condition of a joint. Its velocity is `linear . (v2 - v1) + angular2 . w2 -
/// angular1 . w1`, with the velocities of the centres and the rotational velocities of both bodies.
#[derive(Clone, Debug)]
pub struct JointRow {
    /// Index of the joint; place of this row within it.
    pub joint: usize,
    /// See `joint`.
    pub number: usize,
    first: Option<usize>,
    second: usize,
    /// Direction for translations [1].
    pub linear: V3,
    angular: [V3; 2],
    /// Value that has to be 0 at the end of the step, or the coordinate of a resistance [length, or
    /// radian].
    pub gap: f64,
    /// Distance or angle to which a gap is compared [length, or radian].
    pub size: f64,
    /// Factor from the velocity of the row to that of points of the joint [1, or length].
    pub reach: f64,
    /// Its effect.
    pub form: RowForm,
}

/// Effect of a row.
#[derive(Clone, Copy, Debug)]
pub enum RowForm {
    /// The gap has to vanish.
    Gap,
    /// Impulse `start - u / softness` at the velocity u.
    Soft {
        /// See above [velocity per impulse].
        softness: f64,
        /// See above [impulse].
        start: f64,
    },
    /// The impulse has bounds.
    Bounded(Bound),
}

/// Bounds of an impulse.
#[derive(Clone, Copy, Debug)]
pub enum Bound {
    /// Friction: at most this size [impulse].
    Friction(f64),
    /// Stop at the smallest coordinate: the impulse is positive.
    Low(f64),
    /// Stop at the largest coordinate: the impulse is negative.
    High(f64),
}

impl Bound {
    /// Returns the impulse within the bounds that is next to one.
    pub fn admit(&self, impulse: f64) -> f64 {
        match *self {
            Self::Friction(limit) => impulse.clamp(-limit, limit),
            Self::Low(_) => impulse.max(0.0),
            Self::High(_) => impulse.min(0.0),
        }
    }

    /// Returns minus the velocity at which a row holds without an impulse [1/time, or
    /// length/time].
    pub fn wanted(&self, row: &JointRow, dt: f64) -> f64 {
        match *self {
            Self::Friction(_) => 0.0,
            Self::Low(at) | Self::High(at) => (row.gap - at) / dt,
        }
    }
}

impl JointRow {
    /// Returns the bodies of the row with the impulse and the angular impulse on each by a unit
    /// impulse along the row.
    pub fn ends(&self) -> impl Iterator<Item = (usize, V3, V3)> + use<> {
        let first = self.first.map(|body| (body, -self.linear, -self.angular[0]));
        first.into_iter().chain([(self.second, self.linear, self.angular[1])])
    }

    /// Returns the velocity along the row at the next mid-step [length/time, or 1/time].
    pub fn velocity(&self, bodies: &[Body]) -> f64 {
        let part = |(body, linear, angular): (usize, V3, V3)| {
            let body = &bodies[body];
            linear.dot(&body.next.velocity) + angular.dot(&body.present_spin())
        };
        self.ends().map(part).sum()
    }

    /// Returns the velocity along the row at the last mid-step.
    fn last_velocity(&self, bodies: &[Body]) -> f64 {
        let part = |(body, linear, angular): (usize, V3, V3)| {
            linear.dot(&bodies[body].last.velocity) + angular.dot(&bodies[body].last_spin)
        };
        self.ends().map(part).sum()
    }

    /// Returns the change of velocity along this row per unit impulse along another one.
    pub fn compliance(&self, other: &Self, bodies: &[Body]) -> f64 {
        self.sum_of_replies(other, |body, impulse, moment| bodies[body].reply(impulse, moment))
    }

    /// Returns the compliance of the row itself as if no degree of freedom of its bodies were held.
    pub fn open_compliance(&self, bodies: &[Body]) -> f64 {
        self.sum_of_replies(self, |body, impulse, moment| bodies[body].open_reply(impulse, moment))
    }

    fn sum_of_replies(&self, other: &Self, reply: impl Fn(usize, &V3, &V3) -> (V3, V3)) -> f64 {
        let mut sum = 0.0;
        for (body, linear, angular) in self.ends() {
            for (_, impulse, moment) in other.ends().filter(|end| end.0 == body) {
                let (moved, turned) = reply(body, &impulse, &moment);
                sum += linear.dot(&moved) + angular.dot(&turned);
            }
        }
        sum
    }
}

/// Rows of one joint under construction.
struct RowBuilder<'a> {
    job: &'a ResolvedJoint,
    bodies: &'a [Body],
    joint: usize,
    number: usize,
    /// Arms from the centres to the point of the second body [length].
    arms: [V3; 2],
    /// Vector from the point of the first body to that of the second [length].
    apart: V3,
    size: f64,
    /// Number of rows of other joints before those of this one.
    start: usize,
    steps: StepSizes,
    rows: &'a mut Vec<JointRow>,
}

impl RowBuilder<'_> {
    fn add(&mut self, linear: V3, turning: V3, gap: f64, form: RowForm) {
        // The derivative of d . (p2 - p1), with d fixed in the first body.
        let angular = self.arms.map(|arm| arm.cross(&linear) + turning);
        let turns = linear == V3::zeros();
        let (size, reach) = if turns { (1.0, self.size) } else { (self.size, 1.0) };
        let (joint, number) = (self.joint, self.number);
        let (first, second) = (self.job.first, self.job.second);
        let row =
            JointRow { joint, number, first, second, linear, angular, gap, size, reach, form };
        self.rows.push(row);
        self.number += 1;
    }

    /// Keeps the points together along a direction of the first body.
    fn point(&mut self, along: V3) {
        self.add(along, V3::zeros(), along.dot(&self.apart), RowForm::Gap);
    }

    /// Keeps a direction of the first body perpendicular to one of the second.
    fn square(&mut self, of_first: V3, of_second: V3) {
        let turning = of_second.cross(&of_first);
        self.add(V3::zeros(), turning, of_first.dot(&of_second), RowForm::Gap);
    }

    /// Returns the compliance of the last row, with the gap rows of the joint solved.
    fn coupled_compliance(&self) -> f64 {
        let Some((row, others)) = self.rows[self.start..].split_last() else { return 0.0 };
        let gaps: Vec<&JointRow> =
            others.iter().filter(|r| matches!(r.form, RowForm::Gap)).collect();
        let own = row.compliance(row, self.bodies);
        let mut matrix = DMatrix::from_fn(gaps.len(), gaps.len(), |i, j| {
            gaps[i].compliance(gaps[j], self.bodies)
        });
        for (i, gap) in gaps.iter().enumerate() {
            matrix[(i, i)] += REGULAR * gap.open_compliance(self.bodies);
        }
        let column = DVector::from_fn(gaps.len(), |i, _| gaps[i].compliance(row, self.bodies));
        let taken = matrix.cholesky().map_or(0.0, |factor| column.dot(&factor.solve(&column)));
        (own - taken).max(0.0)
    }

    /// Resists in a coordinate q with the given directions.
    fn resist(&mut self, how: &Resistance, q: f64, (linear, turning): (V3, V3)) {
        let (dt, mid) = (self.steps.dt, self.steps.dt_damped);
        let line = PiecewiseLinear::new(&how.table, 0.0);
        let (force, slope) = (line.value(q), line.slope(q));
        // A falling branch has no stiffness here: its force is that at the present time.
        let (stiff, damping) = (mid * dt * slope.max(0.0), mid * how.damping);
        if stiff > 0.0 || damping > 0.0 || force != 0.0 {
            let at = self.rows.len();
            self.add(linear, turning, q, RowForm::Gap);
            let own = self.coupled_compliance();
            let before = self.rows[at].last_velocity(self.bodies);
            // The part that the step cannot follow is implicit, which damps it.
            let implicit = |x: f64| if x > 1.0 { 1.0 - 1.0 / x } else { 0.0 };
            let (late, slow) = (implicit(stiff * own), implicit(0.5 * damping * own));
            let (spring, damper) = (0.25 * stiff * (1.0 - late), 0.5 * damping * (1.0 - slow));
            let start = -mid * force + (spring - damper) * before;
            // A constant force has no stiffness: a tiny one keeps the row soft.
            let by = spring + stiff * late + damper + damping * slow;
            let softness = 1.0 / by.max(f64::MIN_POSITIVE.sqrt());
            self.rows[at].form = RowForm::Soft { softness, start };
        }
        if how.friction > 0.0 {
            let bound = Bound::Friction(mid * how.friction);
            self.add(linear, turning, q, RowForm::Bounded(bound));
        }
        for bound in [Bound::Low(how.stops[0]), Bound::High(how.stops[1])] {
            if let Bound::Low(at) | Bound::High(at) = bound
                && at.is_finite()
            {
                self.add(linear, turning, q, RowForm::Bounded(bound));
            }
        }
    }
}

/// Adds the rows of a joint at the places and orientations `frames` of the bodies.
pub fn rows_of(
    (joint, job, state): (usize, &ResolvedJoint, &JointState),
    (frames, bodies): (&[(V3, Matrix3<f64>)], &[Body]),
    steps: StepSizes,
    rows: &mut Vec<JointRow>,
) {
    use JointKind::{
        Cylindrical, Fixed, Planar, Revolute, Screw, Spherical, Translational, Universal,
    };
    let [(c1, r1), (c2, r2)] = ends(job, frames);
    let points = [c1 + r1 * state.arms[0], c2 + r2 * state.arms[1]];
    let of = |turn: Matrix3<f64>| job.axes.map(|axis| turn * V3::from(axis));
    let ([s, e, f], [_, e2, f2]) = (of(r1), of(r2));
    let mut build = RowBuilder {
        job,
        bodies,
        joint,
        number: 0,
        arms: [points[1] - c1, points[1] - c2],
        apart: points[1] - points[0],
        size: points[1].norm().max(state.arms[1].norm()).max(f64::MIN_POSITIVE),
        start: rows.len(),
        steps,
        rows,
    };
    if matches!(job.kind, Spherical | Revolute | Universal | Fixed) {
        build.point(s);
    }
    if job.kind == Planar {
        build.point(s);
    } else {
        build.point(e);
        build.point(f);
    }
    match job.kind {
        Spherical => {}
        Universal => build.square(s, e2),
        Revolute | Cylindrical | Planar | Screw | Translational | Fixed => {
            build.square(s, e2);
            build.square(s, f2);
        }
    }
    if matches!(job.kind, Translational | Fixed) {
        build.square(e, f2);
    }
    let (turned, slid) = (angle(job, state, frames), s.dot(&build.apart));
    if job.kind == Screw {
        build.add(s, -s * job.lead, slid - job.lead * turned, RowForm::Gap);
    }
    if let Some(how) = &job.rotation {
        build.resist(how, turned, (V3::zeros(), s));
    }
    if let Some(how) = &job.sliding {
        build.resist(how, slid, (s, V3::zeros()));
    }
}

/// Returns the rotation of the second body against the first about the axis, next to that of the
/// last step [radian].
pub fn angle(job: &ResolvedJoint, state: &JointState, frames: &[(V3, Matrix3<f64>)]) -> f64 {
    let [(_, r1), (_, r2)] = ends(job, frames);
    let [_, e, f] = job.axes.map(|axis| r1 * V3::from(axis));
    let turned = r2 * V3::from(job.axes[1]);
    let angle = turned.dot(&f).atan2(turned.dot(&e));
    angle + TAU * ((state.angle - angle) / TAU).round()
}

fn ends(job: &ResolvedJoint, frames: &[(V3, Matrix3<f64>)]) -> [(V3, Matrix3<f64>); 2] {
    let ground = (V3::zeros(), Matrix3::identity());
    [job.first.map_or(ground, |body| frames[body]), frames[job.second]]
}
