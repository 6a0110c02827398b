//! What is the same of every shell as an [`Element`].

use super::section::Section;
use super::{Element, ElementFields, Pass, PassTotals, four, with_points};
use crate::lanes::Lane;

/// What differs from shell to shell.
pub trait Formulation: Send + Sync {
    /// Columns of its own, after those of the section.
    const OWN: usize;

    /// What it does through the thickness.
    fn section(&self) -> &Section;

    /// As [`Element::corner_mass`].
    fn corner_mass(&self, x: &[[f64; 3]; 4]) -> (f64, f64);

    /// As [`Element::stable_dt`].
    fn stable_dt(&self, x: &[[f64; 3]; 4]) -> f64;

    /// Axes e1, e2 and normal at these coordinates.
    fn axes(x: &[[f64; 3]; 4]) -> [[f64; 3]; 3];

    /// As [`Element::forces`], with N points through the thickness.
    fn pass<const N: usize>(&self, pass: Pass<'_>) -> PassTotals;
}

/// A shell of this formulation.
pub struct Shell<F>(pub F);

impl<F: Formulation> Shell<F> {
    fn section(&self) -> &Section {
        self.0.section()
    }
}

impl<F: Formulation> Element for Shell<F> {
    fn columns(&self) -> usize {
        self.section().columns() + F::OWN
    }

    fn start(&self, history: &mut [Lane]) {
        self.section().start(history);
    }

    fn corner_mass(&self, x: &[[f64; 3]]) -> (f64, f64) {
        self.0.corner_mass(four(x))
    }

    fn forces(&self, pass: Pass<'_>) -> PassTotals {
        with_points!(self.section().points, N => self.0.pass::<N>(pass))
    }

    fn stable_dt(&self, x: &[[f64; 3]]) -> f64 {
        self.0.stable_dt(four(x))
    }

    fn failed(&self, history: &[Lane], lane: usize) -> bool {
        self.section().has_failed(history, lane)
    }

    fn can_fail(&self) -> bool {
        self.section().can_fail()
    }

    fn fields(&self, history: &[Lane], lane: usize, x: &[[f64; 3]]) -> ElementFields {
        self.section().fields(history, lane, &F::axes(four(x)))
    }
}
