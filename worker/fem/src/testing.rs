//! Small models for the tests of this crate and of those that use it.

use crate::nodes::Nodes;
use crumple_proto::ids::NodeId;
use crumple_proto::partition::{ContactDecomposition, NodeRecord, Settings};

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
        contact_forces: false,
        field_points: 0,
        checkpoint: Default::default(),
        materials: Vec::new(),
        parts: Vec::new(),
        with_own_offsets: Vec::new(),
        axes: Vec::new(),
        initial: Vec::new(),
        followed: Vec::new(),
        precision: Default::default(),
        walls: Vec::new(),
        loads: crumple_proto::loads::ResolvedLoads::default(),
        rigid: Vec::new(),
        joints: Vec::new(),
        ties: Vec::new(),
        failure_groups: Vec::new(),
        belts: Default::default(),
        dt_max: 0.0,
        subcycles: 1,
        contact: None,
        rotations: true,
        adaptivity: None,
        buffer: 1.0,
        force_every: 0,
        threads: 1,
        contact_decomposition: ContactDecomposition::Boxes,
    }
}
