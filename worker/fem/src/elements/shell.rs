//! Implementation of [`Element`] that all shells share.

use super::section::Section;
use super::{
    Element, ElementFields, ElementPass, GroupCorners, GroupNodes, PassTotals, PointFields,
    ShellGroups, TakenAtStart, Totals, four, with_points,
};
use crate::columns::ElementState;
use crate::materials::PointLanes;
use crate::nodes::NodeView;
use crumple_proto::initial::InitialPoint;
use crumple_proto::mesh::OwnSection;

/// Properties and kernel of one shell formulation.
pub trait Formulation: Send + Sync {
    /// Names of its own columns, after those of the section.
    const OWN: &'static [&'static str];

    /// See [`Element::single_element_step`].
    const ALONE: f64;

    /// True for quads, which can be divided into four, see [`Element::quarter`].
    const DIVISIBLE: bool;

    /// Returns the section through the thickness.
    fn section(&self) -> &Section;

    /// Returns the section to change it.
    fn section_mut(&mut self) -> &mut Section;

    /// See [`Element::corner_mass`].
    fn corner_mass(&self, x: &[[f64; 3]; 4], own: OwnSection) -> (f64, f64);

    /// Returns the area [length^2] and the floor of [`Section::inertia_per_mass`] [length^2] at
    /// these coordinates.
    fn size(&self, x: &[[f64; 3]; 4]) -> [f64; 2];

    /// See [`Element::stable_dt`], for nodes in the middle of the thickness.
    fn stable_dt(&self, x: &[[f64; 3]; 4]) -> f64;

    /// Returns [`Section::stable_dt`] at these coordinates.
    fn stable_dt_now(&self, history: &[f64], x: &[[f64; 3]; 4]) -> f64;

    /// Returns the axes e1, e2 and the normal at these coordinates.
    fn axes(x: &[[f64; 3]; 4]) -> [[f64; 3]; 3];

    /// See [`ShellGroups::group`], with N points through the thickness.
    fn group<L: PointLanes<W>, const W: usize, const N: usize>(
        &self,
        group: &GroupNodes<4, W>,
        nodes: &NodeView<'_>,
        history: &mut [L],
        dt: f64,
        out: [&mut GroupCorners<4, W>; 2],
    ) -> Totals<L>;

    /// See [`ShellGroups::forceless`].
    fn forceless<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<4, W>,
        nodes: &NodeView<'_>,
        history: &[L],
    ) -> Totals<L>;
}

/// A formulation with N points through the thickness.
struct WithPoints<'a, F, const N: usize>(&'a F);

impl<F: Formulation, const N: usize> ShellGroups for WithPoints<'_, F, N> {
    #[inline(always)]
    fn group<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<4, W>,
        nodes: &NodeView<'_>,
        history: &mut [L],
        dt: f64,
        out: [&mut GroupCorners<4, W>; 2],
    ) -> Totals<L> {
        self.0.group::<L, W, N>(group, nodes, history, dt, out)
    }

    #[inline(always)]
    fn forceless<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<4, W>,
        nodes: &NodeView<'_>,
        history: &[L],
    ) -> Totals<L> {
        self.0.forceless(group, nodes, history)
    }

    #[inline(always)]
    fn section(&self) -> &Section {
        self.0.section()
    }
}

/// A shell with the formulation `F`.
pub struct Shell<F>(pub F);

impl<F: Formulation> Shell<F> {
    fn section(&self) -> &Section {
        self.0.section()
    }
}

impl<F: Formulation> Element for Shell<F> {
    fn columns(&self) -> usize {
        self.section().columns() + F::OWN.len() + usize::from(self.section().deletes)
    }

    fn names(&self) -> Vec<String> {
        let deleted = self.section().deletes.then_some("deleted");
        let own = F::OWN.iter().copied().chain(deleted).map(String::from);
        self.section().names().into_iter().chain(own).collect()
    }

    fn any_precision(&self) -> bool {
        true
    }

    fn store_offsets(&mut self) {
        self.0.section_mut().store_offsets();
    }

    fn start(&self, history: &mut [f64], own: OwnSection) {
        self.section().start(history, own);
    }

    fn measure(&self, history: &mut [f64], x: &[[f64; 3]], own: OwnSection) {
        let [area, floor] = self.0.size(four(x));
        self.section().measure(history, own, area, floor);
        let side = [0, 1, 2].map(|c| x[1][c] - x[0][c]);
        self.section().orient(history, own, &F::axes(four(x)), side);
    }

    fn quarter(
        &self,
        history: &[f64],
        corner: usize,
        x: &[[f64; 3]],
        own: OwnSection,
    ) -> Option<Vec<f64>> {
        if !F::DIVISIBLE {
            return None;
        }
        let mut quarter = vec![0.0; self.columns()];
        self.start(&mut quarter, own);
        self.measure(&mut quarter, x, own);
        self.section().inherit(history, corner, &mut quarter);
        Some(quarter)
    }

    fn taken_at_start(&self) -> TakenAtStart {
        self.section().taken_at_start()
    }

    fn set_initial(&self, history: &mut [f64], x: &[[f64; 3]], points: &[InitialPoint]) {
        self.section().set_initial(history, points, &F::axes(four(x)));
    }

    fn plastic_bending_strain(&self, history: ElementState<'_>) -> f64 {
        self.section().plastic_bending_strain(history)
    }

    fn corner_mass(&self, x: &[[f64; 3]], own: OwnSection) -> (f64, f64) {
        self.0.corner_mass(four(x), own)
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        let columns = self.columns();
        with_points!(self.section().points, N => pass.shells(columns, &WithPoints::<F, N>(&self.0)))
    }

    fn is_unstrained(&self, history: ElementState<'_>) -> bool {
        self.section().is_unstrained(history)
    }

    fn stable_dt(&self, x: &[[f64; 3]], own: OwnSection) -> f64 {
        let [_, floor] = self.0.size(four(x));
        self.0.stable_dt(four(x)) * self.section().offset_factor_at_start(own, floor)
    }

    fn stable_dt_now(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> f64 {
        // A history row asks all elements: no copy of all columns, and no allocation.
        match self.section().shape_columns(history) {
            Some(columns) => self.0.stable_dt_now(&columns, four(x)),
            None => self.0.stable_dt_now(&history.to_vec(), four(x)),
        }
    }

    fn single_element_step(&self) -> f64 {
        F::ALONE
    }

    fn failed(&self, history: ElementState<'_>) -> bool {
        self.section().has_failed(history) || self.is_deleted(history)
    }

    fn is_deleted(&self, history: ElementState<'_>) -> bool {
        self.section().deletes && history.at(self.columns() - 1) > 0.5
    }

    fn can_fail(&self) -> bool {
        self.section().can_fail()
    }

    fn fields(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> ElementFields {
        let fields = self.section().fields(history, &F::axes(four(x)));
        ElementFields { failed: self.failed(history), ..fields }
    }

    fn points(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> Vec<PointFields> {
        self.section().point_fields(history, &F::axes(four(x)))
    }
}
