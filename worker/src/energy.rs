//! The energy ledger: external work, stored, dissipated and lost energy. The sums are for reports
//! only; no decision of a worker depends on them.
//!
//! All sums are exact, and each of their terms belongs to one node, element, pair, wall or body.
//! So they do not depend on the distribution of these over workers.

use crate::fem::blocks::Blocks;
use crate::math::row::{Row, xyz};
use crate::nodes::Nodes;
use crumple_proto::exact_sum::ExactSum;
use crumple_proto::histories::each_value;
use crumple_proto::report::Energies;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::iter::Sum;
use std::ops::{Add, Mul};

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

/// Number of cycles between two calls of [`ExactSum::carry`]; sums over a worker's nodes in each
/// cycle have fewer than 2^31 terms in between.
pub const CARRY_EVERY: u64 = 64;

/// Work so far.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct WorkSum {
    /// Work of all steps [energy].
    total: ExactSum,
    /// Its part between the present time and the next mid-step [energy].
    ahead: ExactSum,
}

impl WorkSum {
    /// Adds the work of one node, pair or body in the present step.
    pub fn add(&mut self, work: Work) {
        self.total.add(work.total());
        self.ahead.add(work.after);
    }

    /// Adds the work that has changed an energy from `before` to `after`.
    pub fn transfer(&mut self, before: &ExactSum, after: &ExactSum) {
        self.total.merge(after);
        self.total.remove(before);
    }

    fn merge(&mut self, o: &Self) {
        self.total.merge(&o.total);
        self.ahead.merge(&o.ahead);
    }

    /// Returns the work of all steps [energy].
    #[cfg(test)]
    pub fn total(&self) -> f64 {
        self.total.value()
    }

    /// Returns the work until the present time [energy].
    pub fn at_present(&self) -> ExactSum {
        let mut sum = self.total.clone();
        sum.remove(&self.ahead);
        sum
    }
}

/// Work of contact forces.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ContactWork {
    /// Work of all contact forces.
    pub total: WorkSum,
    /// Work of friction.
    pub friction: WorkSum,
    /// Work of the pairs that penetrate since the start of the run.
    pub starting: WorkSum,
}

/// Work accumulated on this worker.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// Work of contact forces.
    pub contact: ContactWork,
    /// Work of walls on nodes and bodies, and of these on walls with a mass.
    pub wall: WorkSum,
    /// Work of loads, damping and prescribed motion.
    pub external: WorkSum,
}

impl Ledger {
    /// Adds the ledger of another worker.
    pub fn add(&mut self, o: &Self) {
        let Self { contact: ContactWork { total, friction, starting }, wall, external } = o;
        self.contact.total.merge(total);
        self.contact.friction.merge(friction);
        self.contact.starting.merge(starting);
        self.wall.merge(wall);
        self.external.merge(external);
    }

    /// Begins a step, before its first work is added.
    pub fn begin_step(&mut self, cycle: u64) {
        let Self { contact: ContactWork { total, friction, starting }, wall, external } = self;
        for sum in [total, friction, starting, wall, external] {
            sum.ahead = ExactSum::ZERO;
            if cycle.is_multiple_of(CARRY_EVERY) {
                sum.total.carry();
            }
        }
    }

    /// Returns the energies at the present time, between the mid-steps with velocities v- and v+
    /// (`v` and `v_next`). Kinetic energy is `m v- . v+ / 2`; internal work uses the trapezoidal
    /// rule in the force. Then the central-difference scheme keeps the balance to round-off while
    /// the step is constant: `m (v+ - v-) = dt f` gives `K(n+1) - K(n) = dt v(n+1/2) . (f(n) +
    /// f(n+1)) / 2`.
    ///
    /// Between two steps these are the energies of the time at which the finished step began.
    pub fn energies(&self, nodes: &Nodes, blocks: &Blocks) -> Energies<ExactSum> {
        let (kinetic, swing) = kinetic(nodes);
        let of_elements = |kind: usize| blocks.energies().map(|(_, e)| e[kind]).collect();
        Energies {
            kinetic,
            swing,
            internal: of_elements(0),
            hourglass: of_elements(1),
            contact: self.contact.total.at_present(),
            friction: self.contact.friction.at_present(),
            starting: self.contact.starting.at_present(),
            wall: self.wall.at_present(),
            external: self.external.at_present(),
        }
    }
}

/// Returns the kinetic energy of owned nodes at the present time, and by how much the mean of the
/// squared velocities gives more, `m |v+ - v-|^2 / 4` [energy].
fn kinetic(nodes: &Nodes) -> (ExactSum, ExactSum) {
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
    (own().map(of).collect(), own().map(swing).collect())
}

/// Linear momentum [mass length/time] and angular momentum about the origin [mass length^2/time].
pub type Momenta<N = f64> = ([N; 3], [N; 3]);

/// Returns the momenta of owned nodes at the last mid-step. Positions at mid-step are not stored;
/// angular momentum uses present positions.
pub fn momentum(nodes: &Nodes) -> Momenta {
    let (linear, angular) = momentum_sums(nodes, true);
    (each_value(&linear), each_value(&angular))
}

/// Returns the momenta of owned nodes as exact sums: at the last mid-step if the run has `ended`,
/// otherwise at the present time, within a step, with the mean of the velocities before and after.
pub fn momentum_sums(nodes: &Nodes, ended: bool) -> Momenta<ExactSum> {
    let (mut linear, mut angular) = Momenta::<ExactSum>::default();
    let next = if ended { [&nodes.v, &nodes.w] } else { [&nodes.v_next, &nodes.w_next] };
    let mean = |a: &Row, b: &Row| 0.5 * (Vector3::from(xyz(a)) + Vector3::from(xyz(b)));
    for i in (0..nodes.local_count).filter(|&i| nodes.is_owned(i)) {
        let p = nodes.mass[i] * mean(&nodes.v[i], &next[0][i]);
        let mut l = Vector3::from(xyz(&nodes.x[i])).cross(&p);
        if nodes.rotations {
            l += nodes.inertia[i] * mean(&nodes.w[i], &next[1][i]);
        }
        (0..3).for_each(|c| {
            linear[c].add(p[c]);
            angular[c].add(l[c]);
        });
    }
    (linear, angular)
}
