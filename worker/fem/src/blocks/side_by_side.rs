//! Element nodal forces and their sums on several threads.
//!
//! A thread computes a run of batches, and sums the forces of the nodes whose elements are all in
//! that run while they are in its cache. [`Blocks::assemble`] gives these sums to the nodes, and
//! sums the forces of the others.

use super::{Blocks, act_for_cycles, motion_of};
use crate::assembly::{AssemblyBatch, AssemblyPlan, LATE};
use crate::elements::{Element, ElementNodalForces, ElementPass, PassTotals};
use crate::nodes::Nodes;
use crumple_math::row::Row;
use crumple_math::threads;
use crumple_proto::transport::thread_cpu;
use std::ops::Range;
use std::time::Duration;

/// Least number of nodes that a thread assembles at a time.
const NODES: usize = 512;

/// A batch of a run.
struct BatchPass<'a> {
    element: &'a dyn Element,
    /// Its pass, without the forces.
    pass: ElementPass<'a>,
    /// Its first element in the block.
    first: usize,
    /// Its slots.
    slots: Range<usize>,
    /// Number of cycles of an outer step for slow elements, or else 1.
    cycles: u64,
    /// Nodes that are complete after it.
    nodes: &'a [u32],
}

/// Consecutive batches that one thread computes.
struct Run<'a> {
    batches: Vec<BatchPass<'a>>,
    /// First slot of the columns `force` and `moment`, in which the slots of all batches are.
    first: usize,
    force: &'a mut [Row],
    moment: &'a mut [Row],
    /// Sums of forces and moments of the nodes of the batches, in their order.
    sums: [&'a mut [Row]; 2],
}

impl Blocks {
    /// Computes batches, which are in the order of blocks and groups, in `runs`, as
    /// [`Self::compute`] does.
    pub(super) fn compute_side_by_side(
        &mut self,
        nodes: &Nodes,
        steps: [f64; 2],
        plan: &AssemblyPlan,
        (batches, runs): (&mut [AssemblyBatch], &[Range<usize>]),
    ) -> PassTotals {
        let (timed, subcycles) = (self.timed, self.subcycles);
        let mut passes = Vec::with_capacity(batches.len());
        let mut due = batches.iter().peekable();
        for (number, block) in self.blocks.iter_mut().enumerate() {
            let (view, steps) = motion_of(block, nodes, steps, subcycles);
            let (base, each, lanes) = (block.base, block.group_slots(), block.lanes());
            let cycles = if block.slow { subcycles } else { 1 };
            let none = ElementNodalForces { force: &mut [], moment: &mut [] };
            let (element, mut rest) = block.pass(view, steps, none);
            let mut done = 0;
            while let Some(batch) = due.next_if(|batch| batch.block == number) {
                let groups = &batch.groups;
                let [_, after] = rest.split_at(groups.start - done);
                let [pass, after] = after.split_at(groups.len());
                (rest, done) = (after, groups.end);
                let slots = base + groups.start * each..base + groups.end * each;
                let (first, nodes) = (groups.start * lanes, &plan.early[batch.nodes.clone()]);
                passes.push(BatchPass { element, pass, first, slots, cycles, nodes });
            }
        }
        let turns = !self.moment.is_empty();
        let (mut force, mut moment) = (&mut self.force[..], &mut self.moment[..]);
        let [forces, moments] = &mut self.early_sums;
        let mut sums = [&mut forces[..], &mut moments[..]];
        let (mut slot, mut place) = (0, 0);
        let mut passes = passes.into_iter();
        let cut = |run: &Range<usize>| {
            let some: Vec<BatchPass<'_>> = passes.by_ref().take(run.len()).collect();
            let ends = some.first().zip(some.last()).map(|(a, b)| (a.slots.start, b.slots.end));
            let (first, end) = ends.unwrap_or((slot, slot));
            let places = batches.get(run.start).map_or(place, |batch| batch.nodes.start);
            let summed: usize = some.iter().map(|batch| batch.nodes.len()).sum();
            let [force, moment] =
                [&mut force, &mut moment].map(|column| cut_off(column, first - slot..end - slot));
            let places = places - place..places + summed - place;
            let sums = sums.each_mut().map(|sums| cut_off(sums, places.clone()));
            (slot, place) = (end, place + places.end);
            Run { batches: some, first, force, moment, sums }
        };
        let runs = runs.iter().map(cut).collect();
        let computed = threads::map(runs, |run| run.compute(plan, turns, timed));
        let mut totals = PassTotals::NONE;
        for (batch, (pass, cost)) in batches.iter_mut().zip(computed.into_iter().flatten()) {
            totals.add(&self.complete(batch, pass));
            cost.into_iter().for_each(|cost| batch.add_cost(cost));
        }
        totals
    }

    /// Assembles all local nodes.
    pub(super) fn assemble_side_by_side(&self, plan: &AssemblyPlan, nodes: &mut Nodes) {
        let ranges = threads::ranges(nodes.local_count, NODES);
        let forces = threads::cut(&mut nodes.force, &ranges);
        let early = |sums: &[Row], range: Range<usize>, out: &mut [Row]| {
            for (&place, out) in plan.place[range].iter().zip(out) {
                if place != LATE {
                    *out = sums[place as usize];
                }
            }
        };
        let [of_forces, of_moments] = &self.early_sums;
        let late = |range: Range<usize>| {
            let first = range.start;
            range.filter(|&i| plan.place[i] == LATE).map(move |i| [i, i - first])
        };
        if self.moment.is_empty() {
            let pieces = ranges.into_iter().zip(forces).collect();
            threads::map(pieces, |(range, force)| {
                early(of_forces, range.clone(), force);
                plan.assemble((&self.force, 0), force, late(range));
            });
            return;
        }
        let moments = threads::cut(&mut nodes.moment, &ranges);
        let pieces = ranges.into_iter().zip(forces.into_iter().zip(moments)).collect();
        threads::map(pieces, |(range, (force, moment))| {
            early(of_forces, range.clone(), force);
            early(of_moments, range.clone(), moment);
            let columns = [&self.force[..], &self.moment[..]];
            plan.assemble_both((columns, 0), [force, moment], late(range));
        });
    }
}

/// Removes the rows before the end of `range` from a column, and returns those in `range`; none of
/// an empty column.
fn cut_off<'a>(column: &mut &'a mut [Row], range: Range<usize>) -> &'a mut [Row] {
    if column.is_empty() {
        return Default::default();
    }
    let (first, rest) = std::mem::take(column).split_at_mut(range.end);
    *column = rest;
    &mut first[range.start..]
}

impl Run<'_> {
    /// Computes the batches and sums up the nodes that are complete after each. Returns the totals
    /// of each batch, and its CPU time if it is `timed`. With `turns` there are moments.
    fn compute(
        self,
        plan: &AssemblyPlan,
        turns: bool,
        timed: bool,
    ) -> Vec<(PassTotals, Option<Duration>)> {
        let Run { batches, first, force, moment, sums: [forces, moments] } = self;
        let mut summed = 0;
        let compute = |batch: BatchPass<'_>| {
            let before = timed.then(thread_cpu);
            let slots = batch.slots.start - first..batch.slots.end - first;
            let turning = if turns { slots.clone() } else { 0..0 };
            let out = ElementNodalForces {
                force: &mut force[slots.clone()],
                moment: &mut moment[turning.clone()],
            };
            let mut totals = batch.element.forces(ElementPass { out, ..batch.pass });
            totals.trouble = totals.trouble.map(|i| batch.first + i);
            if batch.cycles > 1 {
                act_for_cycles([&mut force[slots], &mut moment[turning]], batch.cycles);
            }
            let which = batch.nodes.iter().zip(summed..).map(|(&i, place)| [i as usize, place]);
            if turns {
                let sums = [&mut *forces, &mut *moments];
                plan.assemble_both(([&*force, &*moment], first), sums, which);
            } else {
                plan.assemble((&*force, first), forces, which);
            }
            summed += batch.nodes.len();
            (totals, before.map(|before| thread_cpu().saturating_sub(before)))
        };
        batches.into_iter().map(compute).collect()
    }
}
