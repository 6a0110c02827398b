//! Rigid bodies as workers know them.

use crate::ids::NodeId;
use crate::loads::Motion;
use serde::{Deserialize, Serialize};

/// A rigid body: nodes that move together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigidBody {
    /// Member nodes, ascending. Their records have no degree of freedom as free.
    pub nodes: Vec<NodeId>,
    /// Indices of its parts, whose elements compute no forces.
    pub parts: Vec<u32>,
    /// Bits 0..6: translations and rotations that are held, about the axes of space.
    pub fixed: u64,
    /// Inertia about the centre, xx, yy, zz, xy, yz, zx, instead of that of the nodal masses [mass
    /// length^2].
    pub inertia: Option<[f64; 6]>,
    /// Prescribed motions of the centre and rotations about it; their `nodes` are empty.
    pub motions: Vec<Motion>,
}
