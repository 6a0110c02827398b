//! A check of the whole mesh, and the mesh after it.

use super::Engine;
use crate::adaptivity::division::{self, Formulations};
use crate::adaptivity::marks::marks;
use crate::adaptivity::{hanging, quarters};
use crate::energy::kinetic_at_mid_step;
use crate::math::row::xyz;
use crumple_proto::ids::NodeId;
use crumple_proto::transport::{RankLost, Transport, gather_all};
use std::collections::BTreeSet;

/// Number of steps of the new length before shells are divided, so that the steps before and after
/// the division are equal. Where they change, the energy balance has an error in proportion to the
/// power of unbalanced forces, which a division causes.
const STEPS_BEFORE: u64 = 2;

/// Returns the least value of all workers.
///
/// # Errors
/// A worker is gone.
fn least(comm: &mut dyn Transport, own: f64) -> Result<f64, RankLost> {
    Ok(gather_all(comm, vec![own])?.iter().map(|w| w[0]).fold(f64::INFINITY, f64::min))
}

impl Engine {
    /// Divides shells that bend, if a check is due. All workers call this together.
    ///
    /// If their quarters need a shorter step, the step becomes shorter first, and the check is
    /// repeated some steps later.
    ///
    /// A check waits for the next cycle if a field file is due, which needs the contact forces of
    /// the step, and there is none at the end of the run.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn adapt(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let Self { clock, settings, adaptivity, blocks, nodes, .. } = self;
        let Some(known) = adaptivity else { return Ok(()) };
        let waits = clock.is_over(settings)
            || clock.are_fields_due(settings)
            || clock.cycle < known.waits_until;
        if waits || !known.is_due(clock.time) {
            return Ok(());
        }
        let mut formulations = Formulations::new(settings);
        let marked = marks(comm, known, blocks, nodes)?;
        let own = || marked.iter().map(|&i| &blocks.elements[i]);
        let quarters = own().map(|e| e.nodes.map(|n| xyz(&nodes.x[n as usize])));
        let quarters =
            quarters.zip(own()).map(|(x, e)| formulations.step_of_quarters(&e.record, &x));
        let quarter_dt = least(comm, quarters.fold(f64::INFINITY, f64::min))?;
        if quarter_dt < f64::INFINITY
            && !known.ready
            && clock.needs_shorter_dt(settings, quarter_dt)
        {
            clock.shorten_dt(settings, quarter_dt);
            (known.ready, known.waits_until) = (true, clock.cycle + STEPS_BEFORE);
            return Ok(());
        }
        known.ready = false;
        known.pass(clock.time);
        let divisions = own().map(|e| {
            let x = std::array::from_fn(|c| xyz(&nodes.x0[e.nodes[c] as usize]));
            formulations.division(&e.record, &x)
        });
        let divisions = division::gather(comm, divisions.collect())?;
        if divisions.is_empty() {
            return Ok(());
        }
        let cycle = self.clock.cycle;
        let _span = tracing::debug_span!("redecomposition", kind = "division", cycle).entered();
        let before = kinetic_at_mid_step(&self.nodes);
        self.divide(comm, &divisions)?;
        let after = kinetic_at_mid_step(&self.nodes);
        self.ledger.external.transfer(&before, &after);
        let own = self.blocks.smallest_step(&self.nodes).map_or(f64::INFINITY, |s| s.0);
        self.clock.shorten_dt(&self.settings, least(comm, own)?);
        tracing::info!(cycle, time = self.clock.time, divided = divisions.len(), "shells divided");
        Ok(())
    }

    /// Carries out the divisions of all workers.
    fn divide(
        &mut self,
        comm: &mut dyn Transport,
        divisions: &[division::Division],
    ) -> Result<(), RankLost> {
        let mut known = self.adaptivity.take().expect("only engines with adaptivity divide");
        let wanted = known.known_middles(divisions);
        let numbered = known.number(divisions, self.clock.cycle);
        let is_owned = |id: NodeId| {
            self.nodes.local_index(id).is_some_and(|i| self.nodes.is_owned(i as usize))
        };
        let owned: BTreeSet<NodeId> = wanted.iter().copied().filter(|&id| is_owned(id)).collect();
        let (mut share, kept) = self.take_share(comm)?;
        quarters::publish(comm, &mut share, &wanted, |id| owned.contains(&id))?;
        known.take_back(&mut share.nodes);
        let mut formulations = Formulations::new(&self.settings);
        known.divide(&mut share, &numbered, &mut formulations);
        let added = known.add_masses(&numbered);
        for record in &mut share.nodes {
            if let Some([mass, inertia]) = added.get(&record.id) {
                record.mass += mass;
                record.inertia += inertia;
            }
        }
        known.hang(&hanging::find(comm, &known, &share)?);
        known.give(&mut share.nodes);
        let rotations = self.settings.rotations;
        self.constraints.ties.replace(|id| known.has_made(id), known.ties(), rotations);
        for (new, between) in numbered.iter().flat_map(|d| d.made()) {
            self.constraints.walls.inherit(new, &between);
        }
        self.adaptivity = Some(known);
        self.settle(comm, share, kept)
    }
}
