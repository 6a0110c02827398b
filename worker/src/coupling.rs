//! The coupling of contact with constraints and with other workers. [`ContactCoupling`] implements
//! the traits of [`crate::contact::surroundings`] with the data that the engine owns.

use crate::constraints::Constraints;
use crate::contact::pairs::{Pair, Peers};
use crate::contact::surroundings::{NodalForces, VelocityConstraint};
use crate::math::row::{Row, V3};
use crate::nodes::Nodes;
use crate::parallel::pair_exchange::PairExchange;
use crate::parallel::replicated_pairs::ReplicatedPairs;
use crate::time::StepSizes;
use crumple_proto::transport::{
    MaxReduction, RankLost, Tag, Transport, max_among, sum_all, sum_among,
};

/// Constraints and other workers during the contact iteration of a step.
pub struct ContactCoupling<'a> {
    /// Messages to other workers.
    pub comm: &'a mut dyn Transport,
    /// Constraints on nodes.
    pub constraints: &'a mut Constraints,
    /// Pairs that other workers know.
    pub pair_exchange: &'a mut PairExchange,
    /// Pairs whose forces several workers compute.
    pub replicated: &'a ReplicatedPairs,
}

impl VelocityConstraint for ContactCoupling<'_> {
    fn prepare(&mut self, nodes: &Nodes, touched: &[u32], couples: bool) -> Result<bool, RankLost> {
        self.constraints.bodies.prepare_contact(self.comm, touched, nodes, couples)
    }

    #[inline]
    fn is_in_body(&self, node: u32) -> bool {
        self.constraints.bodies.body_of(node).is_some()
    }

    #[inline]
    fn inv_mass(&self, nodes: &Nodes, node: u32) -> Row {
        self.constraints.bodies.inv_mass(node, nodes)
    }

    #[inline]
    fn inv_inertia(&self, nodes: &Nodes, node: u32) -> Row {
        self.constraints.bodies.inv_inertia(node, nodes)
    }

    #[inline]
    fn allowed_velocity(&self, nodes: &Nodes, node: u32, v: Row, dt: f64) -> Row {
        self.constraints.walls.stop(nodes, node as usize, v, dt)
    }

    fn apply_forces(
        &mut self,
        nodes: &mut Nodes,
        forces: NodalForces<'_>,
        steps: StepSizes,
        changed: bool,
    ) -> Result<bool, RankLost> {
        let Constraints { bodies, walls, .. } = &mut *self.constraints;
        bodies.apply_contact(self.comm, nodes, forces, walls, steps, changed)
    }
}

impl Peers for ContactCoupling<'_> {
    fn known_pairs(&self) -> Option<u64> {
        self.replicated.total()
    }

    fn takes_part(&self) -> bool {
        self.replicated.takes_part(self.comm.rank() - 1)
    }

    fn has_shared_pairs(&self) -> bool {
        self.pair_exchange.has_shared_pairs()
    }

    fn exchange_forces(&mut self, pairs: &mut [Pair], changed: bool) -> Result<bool, RankLost> {
        self.pair_exchange.exchange_forces(self.comm, pairs, changed)
    }

    fn exchange_intermediate_forces(&mut self, pairs: &mut [Pair]) -> Result<(), RankLost> {
        self.pair_exchange.exchange_vectors(self.comm, pairs, |pair| &mut pair.force)
    }

    fn exchange_predictor_forces(&mut self, pairs: &mut [Pair]) -> Result<(), RankLost> {
        self.pair_exchange.exchange_vectors(self.comm, pairs, |pair| &mut pair.predictor_force)
    }

    fn exchange_flags(&mut self, flags: &mut [bool]) -> Result<(), RankLost> {
        self.pair_exchange.exchange_flags(self.comm, flags)
    }

    fn exchange_phases(&mut self, phases: &mut [u32], changed: bool) -> Result<bool, RankLost> {
        self.pair_exchange.exchange_phases(self.comm, phases, changed)
    }

    fn exchange_phase_forces(
        &mut self,
        pairs: &[Pair],
        phases: &[u32],
        phase: u32,
        received: &mut Vec<(u32, V3)>,
    ) -> Result<(), RankLost> {
        self.pair_exchange.exchange_phase_forces(self.comm, pairs, phases, phase, received)
    }

    fn max(&mut self, value: f64) -> Result<f64, RankLost> {
        if let Some(members) = self.replicated.members() {
            return max_among(self.comm, Tag::Settled, members, value);
        }
        let mut reduction = MaxReduction::new(1, Tag::Settled);
        reduction.begin(self.comm, &[value])?;
        Ok(reduction.finish(self.comm)?[0])
    }

    fn sum(&mut self, values: &mut [i64]) -> Result<(), RankLost> {
        match self.replicated.members() {
            Some(members) => sum_among(self.comm, Tag::Settled, members, values),
            None => sum_all(self.comm, Tag::Settled, values),
        }
    }
}
