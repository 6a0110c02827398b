//! Work of impulses on nodes, in exact sums: each of their terms belongs to one node, pair, wall or
//! body.

use crumple_math::row::Row;
use crumple_proto::exact_sum::ExactSum;
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
    #[inline]
    pub fn from_impulse(impulse: f64, before: f64, after: f64) -> Self {
        Self { before: 0.5 * impulse * before, after: 0.5 * impulse * after }
    }

    /// Returns the work of an impulse with three components.
    #[inline]
    pub fn from_impulses(impulse: &Row, before: &Row, after: &Row) -> Self {
        (0..3).map(|c| Self::from_impulse(impulse[c], before[c], after[c])).sum()
    }

    /// Returns the sum of both halves [energy].
    #[inline]
    pub fn total(&self) -> f64 {
        self.before + self.after
    }
}

impl Add for Work {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        Self { before: self.before + b.before, after: self.after + b.after }
    }
}

impl Mul<f64> for Work {
    type Output = Self;
    #[inline]
    fn mul(self, a: f64) -> Self {
        Self { before: self.before * a, after: self.after * a }
    }
}

impl Sum for Work {
    #[inline]
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
    #[inline]
    pub fn add(&mut self, work: Work) {
        self.total.add(work.total());
        self.ahead.add(work.after);
    }

    /// Adds the work that has changed an energy from `before` to `after`.
    pub fn transfer(&mut self, before: &ExactSum, after: &ExactSum) {
        self.total.merge(after);
        self.total.remove(before);
    }

    /// Adds the work of another worker.
    pub fn merge(&mut self, o: &Self) {
        self.total.merge(&o.total);
        self.ahead.merge(&o.ahead);
    }

    /// Begins a step. With `carry` the sums get room for more terms, see [`CARRY_EVERY`].
    pub fn begin_step(&mut self, carry: bool) {
        self.ahead = ExactSum::ZERO;
        if carry {
            self.total.carry();
        }
    }

    /// Returns the work of all steps [energy].
    #[inline]
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
