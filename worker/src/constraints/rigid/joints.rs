//! Joints between rigid bodies.
//!
//! Each joint has scalar rows: the gap of a row is a function of the places and orientations of its
//! two bodies, and has to be 0 at the end of the step. Impulses along the rows follow from the
//! linear system `J M^-1 J^T l = -(gap / dt + J v)`, as in Andersen's RATTLE (1983) for the
//! central differences; at the end of the step Newton's method removes what the rotations add, so
//! that gaps stay at round-off. The two impulses of a row are opposite and act at one point, so
//! momentum and angular momentum are conserved.
//!
//! A table or a damper is a soft row: with the row's velocities u- and u+ at the mid-steps before
//! and after, its impulse is `-dt (f(q) + f'(q) dt (u+ - u-) / 4 + c (u- + u+) / 2)`. This is the
//! trapezoidal rule (Newmark, beta = 1/4), which loses no energy. The part of a stiffness that is
//! too large for the step is implicit, `-dt f'(q) dt u+`, which damps it. Friction and stops are
//! bounded rows, solved by projected Gauss-Seidel in the Schur complement of all others.
//!
//! All workers have all bodies and compute the same bits.

use super::body::Body;
use super::joint_rows::{JointRow, RowForm, rows_of};
use crate::math::row::V3;
use crate::time::StepSizes;
use crumple_proto::joint::ResolvedJoint;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3};
use serde::{Deserialize, Serialize};

/// Added to the diagonal of the scaled system: rows may depend on each other, as in a planar
/// linkage of four hinges, and more of them do where all its bars are in one line.
const REGULAR: f64 = 1e-6;
/// Largest number of Newton steps at the end of a step, and the gap at which they end, as a
/// fraction of the size of the joint or of a radian.
const NEWTON: usize = 8;
const CLOSED: f64 = 1e-14;
/// Largest number of sweeps over bounded rows, and the relative change at which they end.
const SWEEPS: usize = 200;
const SETTLED: f64 = 1e-12;

/// State of one joint.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct JointState {
    /// The point relative to the centres of both bodies, in their axes; that of the ground in
    /// space [length].
    pub arms: [V3; 2],
    /// Rotation about the axis since time 0, with full turns [radian].
    pub angle: f64,
}

/// All joints. A checkpoint has the states only.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Joints {
    #[serde(skip)]
    jobs: Vec<ResolvedJoint>,
    states: Vec<JointState>,
    #[serde(skip)]
    system: System,
}

/// Rows of a step and their solution.
#[derive(Debug, Default)]
struct System {
    dt: f64,
    rows: Vec<JointRow>,
    /// Impulses along the rows in this step [force time, or moment time].
    impulses: Vec<f64>,
    /// Rows that are always solved, and bounded ones.
    held: Vec<usize>,
    bounded: Vec<usize>,
    /// Factor for scaled held rows, and their scales.
    factor: Option<Cholesky<f64, Dyn>>,
    scale: Vec<f64>,
    /// Change of the velocity of bounded rows (first index) by an impulse along another one, with
    /// the held rows solved.
    schur: Vec<Vec<f64>>,
    /// Impulses along held rows by a unit impulse along each bounded row.
    replies: Vec<DVector<f64>>,
}

impl Joints {
    /// Adds the joints of a job that are not there yet, between bodies at time 0.
    pub fn extend(&mut self, jobs: &[ResolvedJoint], bodies: &[Body]) {
        self.jobs = jobs.to_vec();
        for job in &jobs[self.states.len()..] {
            let point = V3::from(job.point);
            let arm = |body: Option<usize>| body.map_or(point, |b| point - bodies[b].centre);
            let arms = [arm(job.first), arm(Some(job.second))];
            self.states.push(JointState { arms, angle: 0.0 });
        }
    }

    /// Returns true if these are as many joints as the job has.
    pub fn fits(&self, jobs: &[ResolvedJoint]) -> bool {
        self.states.len() == jobs.len()
    }

    /// Sets the definitions of joints from a checkpoint.
    pub fn restore(&mut self, jobs: &[ResolvedJoint]) {
        self.jobs = jobs.to_vec();
    }

    /// Returns true if there are no joints.
    pub fn is_empty(&self) -> bool {
        self.states.is_empty()
    }

    /// Prepares a step: the rows at the present places of bodies that have started the step.
    pub fn start_step(&mut self, bodies: &[Body], steps: StepSizes) {
        if self.is_empty() {
            return;
        }
        let frames: Vec<(V3, Matrix3<f64>)> = bodies.iter().map(Body::frame).collect();
        let Self { jobs, states, system } = self;
        system.rows.clear();
        add_rows(jobs, states, (&frames, bodies), steps, &mut system.rows);
        // A row between bodies that cannot react is no unknown.
        let reacts = |row: &JointRow| row.compliance(row, bodies) > 0.0;
        system.rows.retain(reacts);
        system.prepare(bodies, steps.dt);
    }

    /// Applies the impulses of all joints to the momenta of the bodies, which contain no impulse of
    /// a joint in this step yet.
    pub fn solve(&mut self, bodies: &mut [Body]) {
        self.system.impulses.fill(0.0);
        self.correct(bodies);
    }

    /// Changes the impulses of all joints to fit the present momenta of the bodies. Returns the
    /// largest change of a row's velocity, of points only [length/time].
    pub fn correct(&mut self, bodies: &mut [Body]) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        self.system.solve(bodies)
    }

    /// Closes the gaps at the end of the step, with all rotations computed by `turn`.
    pub fn close(
        &mut self,
        bodies: &mut [Body],
        steps: StepSizes,
        mut turn: impl FnMut(&mut [Body]),
    ) {
        if self.is_empty() {
            return;
        }
        let Self { jobs, states, system } = self;
        let mut at_end: Vec<JointRow> = Vec::new();
        let mut before = f64::INFINITY;
        for _ in 0..NEWTON {
            let frames: Vec<(V3, Matrix3<f64>)> =
                bodies.iter().map(|b| b.next_frame(steps.dt)).collect();
            at_end.clear();
            add_rows(jobs, states, (&frames, bodies), steps, &mut at_end);
            let (gaps, largest) = system.gaps(&at_end);
            // Near a singular position Newton's method may not converge: the next step goes on.
            if largest <= CLOSED || largest > 0.5 * before {
                break;
            }
            before = largest;
            system.close(&gaps, bodies);
            turn(bodies);
        }
    }

    /// Returns the impulse and the angular impulse of all joints on each body in this step.
    pub fn impulses(&self, bodies: usize) -> Vec<(V3, V3)> {
        let mut sums = vec![(V3::zeros(), V3::zeros()); bodies];
        for (row, &by) in self.system.rows.iter().zip(&self.system.impulses) {
            for (body, linear, angular) in row.ends() {
                sums[body].0 += linear * by;
                sums[body].1 += angular * by;
            }
        }
        sums
    }

    /// Ends the step, with the bodies at their new places: counts full turns.
    pub fn advance(&mut self, bodies: &[Body]) {
        let frames: Vec<(V3, Matrix3<f64>)> = bodies.iter().map(Body::frame).collect();
        for (job, state) in self.jobs.iter().zip(&mut self.states) {
            state.angle = super::joint_rows::angle(job, state, &frames);
        }
    }
}

/// Adds the rows of all joints at the places and orientations `frames` of the bodies.
fn add_rows(
    jobs: &[ResolvedJoint],
    states: &[JointState],
    (frames, bodies): (&[(V3, Matrix3<f64>)], &[Body]),
    steps: StepSizes,
    rows: &mut Vec<JointRow>,
) {
    for (index, (job, state)) in jobs.iter().zip(states).enumerate() {
        rows_of((index, job, state), (frames, bodies), steps, rows);
    }
}

impl System {
    /// Builds the factor for the rows.
    fn prepare(&mut self, bodies: &[Body], dt: f64) {
        let rows = &self.rows;
        self.dt = dt;
        self.impulses.clear();
        self.impulses.resize(rows.len(), 0.0);
        let is_bounded = |&i: &usize| matches!(rows[i].form, RowForm::Bounded(_));
        (self.bounded, self.held) = (0..rows.len()).partition(is_bounded);
        let held = &self.held;
        let softness = |i: usize| match rows[i].form {
            RowForm::Soft { softness, .. } => softness,
            RowForm::Gap | RowForm::Bounded(_) => 0.0,
        };
        let stiff = |i: usize| rows[i].compliance(&rows[i], bodies) + softness(i);
        self.scale = held.iter().map(|&i| 1.0 / stiff(i).sqrt()).collect();
        let scale = &self.scale;
        let mut matrix = DMatrix::zeros(held.len(), held.len());
        for (a, &i) in held.iter().enumerate() {
            for (b, &j) in held.iter().enumerate().take(a) {
                let value = rows[i].compliance(&rows[j], bodies) * scale[a] * scale[b];
                (matrix[(a, b)], matrix[(b, a)]) = (value, value);
            }
            matrix[(a, a)] = 1.0 + REGULAR;
        }
        self.factor = Cholesky::new(matrix);
        let coupling = |k: usize| -> DVector<f64> {
            let along = |&i: &usize| rows[i].compliance(&rows[k], bodies);
            DVector::from_iterator(held.len(), held.iter().map(along))
        };
        let columns: Vec<DVector<f64>> = self.bounded.iter().map(|&k| coupling(k)).collect();
        self.replies = columns.iter().map(|column| -self.inverse(column)).collect();
        self.schur = self
            .bounded
            .iter()
            .zip(&columns)
            .map(|(&k, column)| {
                let with = |(&l, reply): (&usize, &DVector<f64>)| {
                    rows[k].compliance(&rows[l], bodies) + column.dot(reply)
                };
                self.bounded.iter().zip(&self.replies).map(with).collect()
            })
            .collect();
    }

    /// Returns the impulses along held rows that change their velocities by `by`.
    fn inverse(&self, by: &DVector<f64>) -> DVector<f64> {
        let scaled = |v: &DVector<f64>| {
            let of = v.iter().zip(&self.scale).map(|(a, scale)| a * scale);
            DVector::from_iterator(v.len(), of)
        };
        match &self.factor {
            Some(factor) => scaled(&factor.solve(&scaled(by))),
            None => DVector::zeros(by.len()),
        }
    }

    /// Applies an impulse along a row.
    fn push(&mut self, row: usize, by: f64, bodies: &mut [Body]) {
        self.impulses[row] += by;
        for (body, linear, angular) in self.rows[row].ends() {
            bodies[body].add_impulse(&(linear * by), &(angular * by));
        }
    }

    /// Solves all rows for the present momenta; returns the largest change of a velocity by a row
    /// of points.
    fn solve(&mut self, bodies: &mut [Body]) -> f64 {
        let first = self.solve_held(bodies);
        if self.bounded.is_empty() {
            return first;
        }
        let moved = self.solve_bounded(bodies);
        if moved { first.max(self.solve_held(bodies)) } else { first }
    }

    fn solve_held(&mut self, bodies: &mut [Body]) -> f64 {
        let mut largest = 0.0f64;
        let wanted = self.held.iter().map(|&i| {
            let (row, u) = (&self.rows[i], self.rows[i].velocity(bodies));
            match row.form {
                // With its impulse p, a soft row wants p = start - u / softness.
                RowForm::Soft { softness, start } => (start - self.impulses[i]) * softness - u,
                RowForm::Gap | RowForm::Bounded(_) => {
                    let wanted = -row.gap / self.dt - u;
                    largest = largest.max(wanted.abs() * row.linear.norm());
                    wanted
                }
            }
        });
        let wanted = DVector::from_iterator(self.held.len(), wanted);
        let by = self.inverse(&wanted);
        for (a, i) in self.held.clone().into_iter().enumerate() {
            self.push(i, by[a], bodies);
        }
        largest
    }

    /// Solves bounded rows, with held ones; returns true if an impulse has changed.
    fn solve_bounded(&mut self, bodies: &mut [Body]) -> bool {
        let mut u: Vec<f64> = self.bounded.iter().map(|&k| self.rows[k].velocity(bodies)).collect();
        let mut by = vec![0.0; self.bounded.len()];
        for _ in 0..SWEEPS {
            let (mut change, mut largest) = (0.0f64, 0.0f64);
            for (a, &k) in self.bounded.iter().enumerate() {
                let own = self.schur[a][a];
                let RowForm::Bounded(bound) = self.rows[k].form else { continue };
                if own <= 0.0 {
                    continue;
                }
                let now = self.impulses[k] + by[a];
                let new = bound.admit(now - (bound.wanted(&self.rows[k], self.dt) + u[a]) / own);
                let step = new - now;
                by[a] += step;
                for (v, reply) in u.iter_mut().zip(&self.schur) {
                    *v += reply[a] * step;
                }
                change = change.max(step.abs());
                largest = largest.max(new.abs());
            }
            if change <= SETTLED * largest {
                break;
            }
        }
        for (k, step) in self.bounded.clone().into_iter().zip(&by) {
            self.push(k, *step, bodies);
        }
        by.iter().any(|step| *step != 0.0)
    }

    /// Returns the gaps of the held rows at the end of the step, and the largest one as a fraction
    /// of its size.
    fn gaps(&self, at_end: &[JointRow]) -> (Vec<f64>, f64) {
        let gap_of = |&i: &usize| {
            let row = &self.rows[i];
            let end = at_end.iter().find(|r| r.joint == row.joint && r.number == row.number);
            match row.form {
                RowForm::Gap => end.map_or(0.0, |r| r.gap),
                RowForm::Soft { .. } | RowForm::Bounded(_) => 0.0,
            }
        };
        let gaps: Vec<f64> = self.held.iter().map(gap_of).collect();
        let fraction = |(gap, &i): (&f64, &usize)| gap.abs() / self.rows[i].size;
        let largest = gaps.iter().zip(&self.held).map(fraction).fold(0.0, f64::max);
        (gaps, largest)
    }

    /// Applies a Newton step for gaps of the held rows at the end of the step.
    fn close(&mut self, gaps: &[f64], bodies: &mut [Body]) {
        let wanted = DVector::from_iterator(gaps.len(), gaps.iter().map(|gap| -gap / self.dt));
        let by = self.inverse(&wanted);
        for (a, i) in self.held.clone().into_iter().enumerate() {
            self.push(i, by[a], bodies);
        }
    }
}
