//! The energy ledger: external work, stored, dissipated and lost energy. The sums are for reports
//! only; no decision depends on them.

use crate::fem::elements::PassTotals;
use crate::math::row::{Row, xyz};
use crate::nodes::Nodes;
use crumple_proto::report::Energies;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::iter::Sum;
use std::ops::{Add, AddAssign, Mul};

/// Work of impulses in a step, in two halves: before the present time with the velocities of the
/// previous mid-step, after it with those of the next mid-step [energy].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// `p . v- / 2` [energy]
    pub before: f64,
    /// `p . v+ / 2` [energy]
    pub after: f64,
}

impl Work {
    /// Returns the work of one component of an impulse [mass length/time] between velocities
    /// `before` and `after` [length/time].
    pub fn from_impulse(impulse: f64, before: f64, after: f64) -> Self {
        Self { before: 0.5 * impulse * before, after: 0.5 * impulse * after }
    }

    /// Returns the work of an impulse with three components.
    pub fn from_impulses(impulse: &Row, before: &Row, after: &Row) -> Self {
        (0..3).map(|c| Self::from_impulse(impulse[c], before[c], after[c])).sum()
    }

    /// Returns the sum of both halves [energy].
    pub fn total(&self) -> f64 {
        self.before + self.after
    }
}

impl Add for Work {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self { before: self.before + b.before, after: self.after + b.after }
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}

impl Mul<f64> for Work {
    type Output = Self;
    fn mul(self, a: f64) -> Self {
        Self { before: self.before * a, after: self.after * a }
    }
}

impl Sum for Work {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), Add::add)
    }
}

/// Work of contact forces in a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactWork {
    /// Work of all contact forces.
    pub total: Work,
    /// Work of friction.
    pub friction: Work,
    /// Work of the pairs that penetrate since the start of the run.
    pub starting: Work,
}

/// Energies and work accumulated on this worker.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Ledger {
    internal: f64,
    hourglass: f64,
    contact: LedgerEntry,
    friction: LedgerEntry,
    starting: LedgerEntry,
    wall: LedgerEntry,
    external: LedgerEntry,
}

/// Work so far, and the part of it between the present time and the next mid-step [energy].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct LedgerEntry {
    total: f64,
    ahead: f64,
}

impl LedgerEntry {
    fn book(&mut self, work: Work) {
        self.total += work.total();
        self.ahead = work.after;
    }

    fn add(&mut self, o: &Self) {
        self.total += o.total;
        self.ahead += o.ahead;
    }

    fn at_present(&self) -> f64 {
        self.total - self.ahead
    }
}

impl Ledger {
    /// Adds the ledger of another worker.
    pub fn add(&mut self, o: &Self) {
        let Self { internal, hourglass, contact, friction, starting, wall, external } = o;
        self.internal += internal;
        self.hourglass += hourglass;
        self.contact.add(contact);
        self.friction.add(friction);
        self.starting.add(starting);
        self.wall.add(wall);
        self.external.add(external);
    }

    /// Books the energies of a pass over elements.
    pub fn book_elements(&mut self, t: &PassTotals) {
        self.internal += t.internal;
        self.hourglass += t.hourglass;
    }

    /// Books the work of contact in a step.
    pub fn book_contact(&mut self, work: ContactWork) {
        self.contact.book(work.total);
        self.friction.book(work.friction);
        self.starting.book(work.starting);
    }

    /// Books the work of walls in a step.
    pub fn book_wall(&mut self, work: Work) {
        self.wall.book(work);
    }

    /// Books the work of loads, damping and prescribed motion in a step.
    pub fn book_external(&mut self, work: Work) {
        self.external.book(work);
    }

    /// Returns the energies at the present time, between the mid-steps with velocities v- and v+
    /// (`v` and `v_next`). Kinetic energy is `m v- . v+ / 2`; internal work uses the trapezoidal
    /// rule in the force. Then the central-difference scheme keeps the balance to round-off while
    /// the step is constant: `m (v+ - v-) = dt f` gives `K(n+1) - K(n) = dt v(n+1/2) . (f(n) +
    /// f(n+1)) / 2`.
    ///
    /// Between two steps these are the energies of the time at which the finished step began.
    pub fn energies(&self, nodes: &Nodes) -> Energies {
        let (kinetic, swing) = kinetic(nodes);
        Energies {
            kinetic,
            swing,
            internal: self.internal,
            hourglass: self.hourglass,
            contact: self.contact.at_present(),
            friction: self.friction.at_present(),
            starting: self.starting.at_present(),
            wall: self.wall.at_present(),
            external: self.external.at_present(),
        }
    }
}

/// Returns the kinetic energy of owned nodes at the present time, and by how much the mean of the
/// squared velocities gives more, `m |v+ - v-|^2 / 4` [energy].
fn kinetic(nodes: &Nodes) -> (f64, f64) {
    let product = |a: &Row, b: &Row| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let change = |a: &Row, b: &Row| (0..3).map(|c| (b[c] - a[c]) * (b[c] - a[c])).sum::<f64>();
    let swing = |i: usize| 0.25 * nodes.mass[i] * change(&nodes.v[i], &nodes.v_next[i]);
    let of = |i: usize| {
        let turning = if nodes.rotations {
            nodes.inertia[i] * product(&nodes.w[i], &nodes.w_next[i])
        } else {
            0.0
        };
        0.5 * (nodes.mass[i] * product(&nodes.v[i], &nodes.v_next[i]) + turning)
    };
    let own = || (0..nodes.local_count).filter(|&i| nodes.is_owned(i));
    (own().map(of).sum(), own().map(swing).sum())
}

/// Returns the linear and angular momentum of owned nodes about the origin at the last mid-step.
/// Positions at mid-step are not stored; angular momentum uses present positions.
pub fn momentum(nodes: &Nodes) -> ([f64; 3], [f64; 3]) {
    momentum_of(nodes, &nodes.v, &nodes.w)
}

/// Returns both momenta at the present time, within a step: with the mean of the velocities
/// before and after.
pub fn momentum_at_present(nodes: &Nodes) -> ([f64; 3], [f64; 3]) {
    momentum_of(nodes, &nodes.v_next, &nodes.w_next)
}

fn momentum_of(nodes: &Nodes, next_v: &[Row], next_w: &[Row]) -> ([f64; 3], [f64; 3]) {
    let (mut p, mut l) = (Vector3::zeros(), Vector3::zeros());
    for i in (0..nodes.local_count).filter(|&i| nodes.is_owned(i)) {
        let mean = |a: &Row, b: &Row| 0.5 * (Vector3::from(xyz(a)) + Vector3::from(xyz(b)));
        let v = mean(&nodes.v[i], &next_v[i]);
        p += nodes.mass[i] * v;
        l += nodes.mass[i] * Vector3::from(xyz(&nodes.x[i])).cross(&v);
        if nodes.rotations {
            l += nodes.inertia[i] * mean(&nodes.w[i], &next_w[i]);
        }
    }
    (p.into(), l.into())
}
