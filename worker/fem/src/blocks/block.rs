//! Elements of one part and shape: connectivity, history columns, energies.

use super::{Class, LocalElement, Portion};
use crate::columns::{ElementState, HistoryColumns};
use crate::elements::{
    Element, ElementNodalForces, ElementPass, PassTotals, build_block, energy_places,
};
use crate::nodes::NodeView;
use crumple_proto::job::Precision;
use crumple_proto::mesh::Shape;
use crumple_proto::partition::Settings;
use std::ops::Range;

/// Elements of one part and shape.
pub struct Block {
    /// Formulation with its parameters.
    pub element: Box<dyn Element>,
    /// Index of its first element in [`Blocks::elements`].
    pub first: usize,
    /// Number of elements.
    pub count: usize,
    /// Number of groups that contain all elements at shared nodes, and number of groups that
    /// contain all interface elements. They are computed in this order, interior ones last.
    pub(super) fronts: [usize; 2],
    /// Number of interface elements, which are its first ones.
    pub interface: usize,
    /// True if the part is rigid or has a null material: its elements have no forces and do not
    /// limit the step.
    pub idle: bool,
    /// True if its elements are computed only in the first cycle of an outer step.
    pub slow: bool,
    /// First slot of its element nodal forces.
    pub(super) base: usize,
    /// Number of slots per element.
    pub(super) slots: usize,
    /// Local nodes: one row per slot in each group.
    pub(super) groups: Vec<u32>,
    /// History columns.
    pub(super) history: HistoryColumns,
    /// Energies of each element so far, see [`ElementPass::energies`] [energy].
    energies: Vec<f64>,
    /// See [`ElementPass::step_factors`].
    step_factors: Vec<f64>,
    /// For each group, true if it was never strained: its forces are zero while all its nodes
    /// move alike.
    pub(super) unstrained: Vec<bool>,
}

impl Block {
    /// Returns the history columns of one element.
    pub fn state(&self, index: usize) -> ElementState<'_> {
        self.history.element(index)
    }

    /// Returns the internal energy of an element so far, and its hourglass and drilling energy
    /// [energy].
    pub fn energies(&self, index: usize) -> [f64; 2] {
        energy_places(index, self.lanes()).map(|place| self.energies[place])
    }

    /// Returns the state of an element for its next worker: history columns and energies.
    pub fn columns(&self, index: usize) -> Vec<f64> {
        // A new field is an error here: state of an element has to be added to its columns.
        let Self {
            history: _,
            energies: _,
            // From the job, or computed for each partition.
            element: _,
            first: _,
            count: _,
            fronts: _,
            interface: _,
            idle: _,
            slow: _,
            base: _,
            slots: _,
            groups: _,
            step_factors: _,
            unstrained: _,
        } = self;
        let mut columns = self.state(index).to_vec();
        columns.extend(self.energies(index));
        columns
    }

    /// Returns the number of columns of an element of this kind on its way to another worker.
    pub fn columns_of(element: &dyn Element) -> usize {
        element.columns() + 2
    }

    /// Returns the names of these columns.
    pub fn names_of(element: &dyn Element) -> Vec<String> {
        let energies = ["internal energy", "hourglass energy"].map(String::from);
        element.names().into_iter().chain(energies).collect()
    }

    /// Returns the number of elements per group.
    pub fn lanes(&self) -> usize {
        self.history.lanes()
    }

    /// Returns the portion in which an element of the block is computed.
    pub fn portion_of(&self, index: usize) -> Portion {
        match index / self.lanes() {
            group if group < self.fronts[0] => Portion::Shared,
            group if group < self.fronts[1] => Portion::Interface,
            _ => Portion::Interior,
        }
    }

    /// Returns the groups of a portion.
    pub(super) fn groups_of(&self, portion: Portion) -> Range<usize> {
        let [shared, interface] = self.fronts;
        match portion {
            Portion::Shared => 0..shared,
            Portion::Interface => shared..interface,
            Portion::Interior => interface..self.group_count(),
        }
    }

    /// Builds the block of the elements `run`, with their states from elsewhere, if there are any.
    /// `first` is the index of the first element, `base` its first slot.
    pub(super) fn new(
        settings: &Settings,
        run: &[LocalElement],
        histories: &[Vec<f64>],
        [first, base]: [usize; 2],
    ) -> Self {
        let (part, shape): (usize, Shape) = (run[0].record.part as usize, run[0].record.shape);
        let element = build_block(settings, part, shape).unwrap_or_else(|problems| {
            panic!(
                "part {part} cannot be built: {problems:?}; `crumple check` should have \
                 reported it"
            )
        });
        let precision =
            if element.any_precision() { settings.precision } else { Precision::Double };
        let history = HistoryColumns::new(precision, run.len(), element.columns());
        let (lanes, slots) = (history.lanes(), shape.slots());
        let groups = run.len().div_ceil(lanes);
        let shared = run.iter().filter(|e| e.shared).count();
        let interface = run.iter().filter(|e| e.class == Class::Interface).count();
        let mut b = Self {
            base,
            slots,
            groups: vec![0; groups * slots * lanes],
            history,
            energies: vec![0.0; 2 * groups * lanes],
            step_factors: step_factors(run, groups * lanes),
            unstrained: vec![false; groups],
            fronts: [shared, interface].map(|count| count.div_ceil(lanes)),
            interface,
            count: run.len(),
            idle: settings.is_inactive(run[0].record.part),
            slow: run[0].record.slow,
            first,
            element,
        };
        let mut fresh = vec![0.0; b.element.columns()];
        for place in 0..groups * lanes {
            // Padding repeats the last element, so that it computes no exceptional values.
            let i = place.min(run.len() - 1);
            (0..slots).for_each(|c| {
                b.groups[(place / lanes * slots + c) * lanes + place % lanes] = run[i].nodes[c]
            });
            if let Some((state, energies)) = histories[i].split_last_chunk::<2>() {
                b.history.set(place, state);
                energy_places(place, lanes)
                    .iter()
                    .zip(energies)
                    .for_each(|(&i, &e)| b.energies[i] = e);
            } else {
                fresh.fill(0.0);
                b.element.start(&mut fresh, run[i].record.own);
                if let Ok(at) = settings.axes.binary_search_by_key(&run[i].record.id, |a| a.0) {
                    b.element.orient(&mut fresh, settings.axes[at].1);
                }
                b.history.set(place, &fresh);
            }
        }
        for (group, unstrained) in b.unstrained.iter_mut().enumerate() {
            *unstrained = (group * lanes..(group + 1) * lanes)
                .all(|i| b.element.is_unstrained(b.history.element(i)));
        }
        b
    }

    /// Returns the bytes of history columns and energies.
    pub(super) fn history_bytes(&self) -> usize {
        self.column_bytes() + self.energy_bytes()
    }

    /// Returns the bytes of history columns.
    pub(super) fn column_bytes(&self) -> usize {
        self.history.bytes()
    }

    /// Returns the bytes of the energies of elements.
    pub(super) fn energy_bytes(&self) -> usize {
        size_of_val(&self.energies[..])
    }

    /// Returns the number of slots of a group.
    pub(super) fn group_slots(&self) -> usize {
        self.slots * self.lanes()
    }

    /// Returns the number of groups.
    pub(super) fn group_count(&self) -> usize {
        self.groups.len() / self.group_slots()
    }

    /// Returns the number of slots, including padding.
    pub(super) fn corner_slots(&self) -> usize {
        self.groups.len()
    }

    /// Returns the slots of some groups.
    pub(super) fn slots_of(&self, groups: &Range<usize>) -> Range<usize> {
        let each = self.group_slots();
        self.base + groups.start * each..self.base + groups.end * each
    }

    /// Stores the volume strain increment of the nodes of an element that averages it. The padding
    /// repeats the last element.
    pub(super) fn set_averaged_volume(&mut self, index: usize, increment: f64) {
        let Some(column) = self.element.averaged_volume() else { return };
        let lanes = self.lanes();
        let last = if index + 1 == self.count { self.group_count() * lanes } else { index + 1 };
        (index..last).for_each(|place| self.history.set_column(place, column, increment));
        if increment != 0.0 {
            self.unstrained[index / lanes] = false;
        }
    }

    /// Returns the formulation and a pass over all groups after a step `dt`, which writes the
    /// forces to `out`; solids with a stable step below `least_dt` may be deleted [time].
    pub(super) fn pass<'a>(
        &'a mut self,
        nodes: NodeView<'a>,
        [dt, least_dt]: [f64; 2],
        out: ElementNodalForces<'a>,
    ) -> (&'a dyn Element, ElementPass<'a>) {
        let pass = ElementPass {
            range: 0..self.group_count(),
            count: self.count,
            groups: &self.groups,
            history: self.history.as_mut(),
            unstrained: &mut self.unstrained,
            nodes,
            dt,
            least_dt,
            step_factors: &self.step_factors,
            out,
            energies: &mut self.energies,
        };
        (&*self.element, pass)
    }

    /// Computes the forces of the groups `range`, see [`Self::pass`].
    pub(super) fn forces(
        &mut self,
        range: Range<usize>,
        nodes: NodeView<'_>,
        steps: [f64; 2],
        out: ElementNodalForces<'_>,
    ) -> PassTotals {
        let (element, pass) = self.pass(nodes, steps, out);
        element.forces(ElementPass { range, ..pass })
    }
}

/// Returns the [`ElementPass::step_factors`] of these elements at so many places.
fn step_factors(run: &[LocalElement], places: usize) -> Vec<f64> {
    let factor = |e: &LocalElement| (e.record.mass_factor * e.record.share).sqrt();
    if run.iter().all(|e| factor(e) == 1.0) {
        return Vec::new();
    }
    (0..places).map(|place| factor(&run[place.min(run.len() - 1)])).collect()
}
