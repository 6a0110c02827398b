//! Small models for the tests of this crate.

use crate::pairs::{Pair, Peers};
use crate::surroundings::{Exclusions, NodalForces, VelocityConstraint};
use crumple_fem::nodes::Nodes;
use crumple_fem::time::StepSizes;
use crumple_math::row::{Row, V3};
use crumple_proto::transport::RankLost;

/// The surroundings of contact on a single worker without constraints.
pub struct Free;

impl Exclusions for Free {
    fn excludes(&self, _: u32, _: &[u32; 4]) -> bool {
        false
    }

    fn are_tied(&self, _: u32, _: &[u32; 4]) -> bool {
        false
    }
}

impl VelocityConstraint for Free {
    fn prepare(&mut self, _: &Nodes, _: &[u32], _: bool) -> Result<bool, RankLost> {
        Ok(false)
    }

    fn is_in_body(&self, _: u32) -> bool {
        false
    }

    fn inv_mass(&self, nodes: &Nodes, node: u32) -> Row {
        nodes.inv_mass[node as usize]
    }

    fn inv_inertia(&self, nodes: &Nodes, node: u32) -> Row {
        nodes.inv_inertia[node as usize]
    }

    fn allowed_velocity(&self, _: &Nodes, _: u32, v: Row, _: f64) -> Row {
        v
    }

    fn apply_forces(
        &mut self,
        _: &mut Nodes,
        _: NodalForces<'_>,
        _: StepSizes,
        changed: bool,
    ) -> Result<bool, RankLost> {
        Ok(changed)
    }
}

impl Peers for Free {
    fn known_pairs(&self) -> Option<u64> {
        None
    }

    fn takes_part(&self) -> bool {
        true
    }

    fn has_shared_pairs(&self) -> bool {
        false
    }

    fn exchange_forces(&mut self, _: &mut [Pair], changed: bool) -> Result<bool, RankLost> {
        Ok(!changed)
    }

    fn exchange_intermediate_forces(&mut self, _: &mut [Pair]) -> Result<(), RankLost> {
        Ok(())
    }

    fn exchange_predictor_forces(&mut self, _: &mut [Pair]) -> Result<(), RankLost> {
        Ok(())
    }

    fn exchange_flags(&mut self, _: &mut [bool]) -> Result<(), RankLost> {
        Ok(())
    }

    fn exchange_phases(&mut self, _: &mut [u32], changed: bool) -> Result<bool, RankLost> {
        Ok(!changed)
    }

    fn exchange_phase_forces(
        &mut self,
        _: &[Pair],
        _: &[u32],
        _: u32,
        _: &mut Vec<(u32, V3)>,
    ) -> Result<(), RankLost> {
        Ok(())
    }

    fn max(&mut self, value: f64) -> Result<f64, RankLost> {
        Ok(value)
    }

    fn sum(&mut self, _: &mut [i64]) -> Result<(), RankLost> {
        Ok(())
    }
}
