//! Changes of the model when a run continues from a checkpoint: parts that are deleted, and new
//! velocities. New rigid bodies and walls are part of the settings.
//!
//! The energy that a change adds or takes counts as work of external forces, so that the balance
//! goes on.

use super::Engine;
use crate::erosion;
use crate::math::row::row;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::message::Changes;
use crumple_proto::transport::{RankLost, Transport, gather_all};
use std::collections::BTreeSet;

impl Engine {
    /// Applies changes to an engine that was restored. Returns the reason why the run cannot
    /// continue, if there is one. All workers call this together.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn apply(
        &mut self,
        comm: &mut dyn Transport,
        changes: &Changes,
    ) -> Result<Option<String>, RankLost> {
        if *changes != Changes::default() {
            self.change(comm, changes)?;
        }
        self.behind_walls(comm)
    }

    fn change(&mut self, comm: &mut dyn Transport, changes: &Changes) -> Result<(), RankLost> {
        let before = self.energies(true).stored();
        self.delete_parts(comm, &changes.delete)?;
        for (parts, velocity) in &changes.velocities {
            self.set_velocity(comm, parts, *velocity)?;
        }
        let after = self.energies(true).stored();
        self.ledger.external.transfer(&before, &after);
        Ok(())
    }

    /// Returns a message if nodes of any worker start behind a wall that is new.
    fn behind_walls(&self, comm: &mut dyn Transport) -> Result<Option<String>, RankLost> {
        let behind = self.constraints.walls.behind_new(&self.nodes, self.clock.dt);
        let mine = behind.map(|(w, i, depth)| [w as u64, self.nodes.id[i].0, depth.to_bits()]);
        let all = gather_all(comm, mine.collect())?.concat();
        let most = all.iter().max_by(|a, b| f64::from_bits(a[2]).total_cmp(&f64::from_bits(b[2])));
        Ok(most.map(|&[wall, node, depth]| {
            let count = all.iter().filter(|n| n[0] == wall).count();
            format!(
                "{count} nodes are behind the new {}, node {} by {:.3e}: move the wall, or \
                 reverse its normal, which points to the model",
                self.settings.walls[wall as usize].label(wall as usize),
                NodeId(node),
                f64::from_bits(depth)
            )
        }))
    }

    /// Sets the velocity of all nodes of some parts, except for constrained degrees of freedom.
    fn set_velocity(
        &mut self,
        comm: &mut dyn Transport,
        parts: &[u32],
        velocity: [f64; 3],
    ) -> Result<(), RankLost> {
        let own = self.blocks.elements.iter().filter(|e| parts.contains(&e.record.part));
        let own: BTreeSet<NodeId> = own.flat_map(|e| e.record.nodes).collect();
        // Another worker may have such a node without an element of these parts.
        let all = gather_all(comm, own.into_iter().collect())?;
        self.constraints.belts.forget_velocities();
        let n = &mut self.nodes;
        for &i in all.iter().flatten().filter_map(|&id| n.index_of(id)).collect::<Vec<_>>().iter() {
            let i = i as usize;
            let free = |dof: usize| n.fixed[i] >> dof & 1 == 0;
            for (c, &v) in velocity.iter().enumerate().filter(|(c, _)| free(*c)) {
                (n.v[i][c], n.v_next[i][c]) = (v, v);
            }
            if n.rotations {
                for c in (0..3).filter(|c| free(3 + c)) {
                    (n.w[i][c], n.w_next[i][c]) = (0.0, 0.0);
                }
            }
        }
        Ok(())
    }

    /// Deletes parts: as elements that fail, and then the elements with their mass.
    fn delete_parts(&mut self, comm: &mut dyn Transport, parts: &[u32]) -> Result<(), RankLost> {
        if parts.is_empty() {
            return Ok(());
        }
        let elements = self.blocks.elements.iter().enumerate();
        let gone = elements.filter(|(_, e)| parts.contains(&e.record.part));
        let gone: Vec<usize> = gone.map(|(i, _)| i).collect();
        let ids: Vec<ElemId> = gone.iter().map(|&i| self.blocks.elements[i].record.id).collect();
        self.constraints.release_failed(comm, &ids, &mut self.nodes)?;
        self.blocks.set_corner_masses(&self.nodes, |part| parts.contains(&part));
        let all = crate::time::ElementSet::All;
        self.halo.send_element_forces(comm, &self.blocks, all)?;
        self.halo.recv_element_forces(comm, &mut self.blocks, all)?;
        self.blocks.remove_masses(&mut self.nodes);
        erosion::leave_surface(comm, &mut self.blocks, &self.nodes, &self.halo, &gone)?;
        self.renew_without(comm, self.tree.clone(), parts)
    }

    /// Makes parts rigid, or deformable again, whose time has come. All workers call this together.
    ///
    /// The difference between the energies before and after counts as work of external forces.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn switch_bodies(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let due = self.constraints.bodies.due(self.clock.time);
        if due.is_empty() {
            return Ok(());
        }
        let before = self.energies(true).stored();
        let is_begun = |b: &usize| self.constraints.bodies.is_active(*b);
        let (ending, beginning): (Vec<usize>, Vec<usize>) = due.into_iter().partition(is_begun);
        ending.iter().for_each(|&b| self.release_members(b));
        let bodies = &mut self.constraints.bodies;
        bodies.activate(comm, &self.settings, &self.nodes, &beginning)?;
        self.carry_members(&beginning);
        for &b in &beginning {
            if self.constraints.bodies.has_settled(b, &self.settings.rigid[b]) {
                self.settings.rigid[b].window = None;
            }
        }
        let after = self.energies(true).stored();
        self.ledger.external.transfer(&before, &after);
        let (cycle, time) = (self.clock.cycle, self.clock.time);
        tracing::info!(cycle, time, ?beginning, ?ending, "parts become rigid or deformable");
        self.renew(comm, self.tree.clone()) // ghosts of members have other constraints too
    }

    /// Gives the members of a body the motion of the body, and frees them.
    fn release_members(&mut self, b: usize) {
        let nodes = self.constraints.bodies.nodes_of(b);
        let local: Vec<u32> = nodes.iter().filter_map(|&id| self.nodes.local_index(id)).collect();
        for i in local.into_iter().map(|n| n as usize) {
            self.nodes.fixed[i] &= !0b11_1111;
            self.nodes.invert_mass(i);
        }
        self.constraints.bodies.deactivate(&self.settings, b);
    }

    /// Sets the velocities of the members of rigid bodies to the motion of their body, and fixes
    /// their nodes.
    pub(super) fn carry_members(&mut self, bodies: &[usize]) {
        let members: Vec<_> = self.constraints.bodies.carried(bodies, &self.nodes).collect();
        for (i, velocity, spin) in members {
            let n = &mut self.nodes;
            n.fixed[i] |= 0b11_1111;
            (n.v[i], n.v_next[i]) = (row(velocity.into()), row(velocity.into()));
            if n.rotations {
                (n.w[i], n.w_next[i]) = (row(spin.into()), row(spin.into()));
            }
            n.invert_mass(i);
        }
    }
}
