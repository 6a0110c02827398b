//! Small models for the tests of this crate.

use crate::contact::pairs::Pair;
use crate::contact::surroundings::{Exclusions, NodalForces, Peers, VelocityConstraint};
use crate::math::row::{Row, V3};
use crate::nodes::Nodes;
use crate::time::StepSizes;
use crumple_proto::ids::NodeId;
use crumple_proto::partition::{NodeRecord, Settings};
use crumple_proto::transport::RankLost;

/// Returns nodes of mass 1 at rest at `places` [length], with ids from 1.
pub fn nodes_at(places: &[[f64; 3]]) -> Nodes {
    let record = |(&x, id): (&[f64; 3], u64)| NodeRecord {
        id: NodeId(id),
        x0: x,
        x,
        seen: x,
        mass: 1.0,
        ..NodeRecord::default()
    };
    Nodes::new(&places.iter().zip(1..).map(record).collect::<Vec<_>>(), 0, true)
}

/// Returns settings without parts that run to time 1.
pub fn settings() -> Settings {
    Settings {
        end_time: 1.0,
        safety: 0.9,
        max_cycles: 0,
        dt_min_ratio: 1e-3,
        history_interval: 0.1,
        field_times: Vec::new(),
        output: Default::default(),
        planned: Vec::new(),
        histories: Default::default(),
        field_dir: String::new(),
        checkpoint: Default::default(),
        materials: Vec::new(),
        parts: Vec::new(),
        with_own_offsets: Vec::new(),
        axes: Vec::new(),
        precision: Default::default(),
        walls: Vec::new(),
        loads: crumple_proto::loads::ResolvedLoads::default(),
        rigid: Vec::new(),
        ties: Vec::new(),
        dt_max: 0.0,
        subcycles: 1,
        contact: None,
        rotations: true,
        buffer: 1.0,
        force_every: 0,
    }
}

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
