//! Rigid bodies for workers.

use crate::ids::NodeId;
use crate::loads::PrescribedMotion;
use serde::{Deserialize, Serialize};

/// Rigid body: nodes that move together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigidBody {
    /// Member nodes, ascending. All degrees of freedom are constrained in their records.
    pub nodes: Vec<NodeId>,
    /// Indices of its parts; their elements compute no forces.
    pub parts: Vec<u32>,
    /// Fixed degrees of freedom: bits 0..6 are translations and rotations about the axes of
    /// space.
    pub fixed: u64,
    /// Inertia about the centre, xx, yy, zz, xy, yz, zx, in place of that of the nodal masses
    /// [mass length^2].
    pub inertia: Option<[f64; 6]>,
    /// Prescribed motions of the centre and rotations about it; their `nodes` are empty.
    pub motions: Vec<PrescribedMotion>,
}
