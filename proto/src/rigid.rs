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
    /// Inertia xx, yy, zz, xy, yz, zx that adds to either [mass length^2].
    pub added_inertia: Option<[f64; 6]>,
    /// Prescribed motions of the centre and rotations about it; their `nodes` are empty.
    pub motions: Vec<PrescribedMotion>,
    /// Times at which its parts become rigid and deformable again [time]; `None` for a body that is
    /// rigid in the whole run. The elements of its parts compute forces at all times.
    pub window: Option<[f64; 2]>,
    /// Bounds of the motion of its centre.
    pub stops: Vec<BodyStop>,
    /// Forces at its centre and moments about it.
    pub loads: Vec<BodyLoad>,
}

/// Force at the centre of a body, and moment about it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyLoad {
    /// Force [force].
    pub force: [f64; 3],
    /// Moment [force length].
    pub moment: [f64; 3],
    /// Index of its curve in the loads; constant if `None`.
    pub curve: Option<usize>,
    /// True if force and moment turn with the body.
    pub follows: bool,
}

/// Bounds of the motion of the centre of a body along a direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyStop {
    /// Unit vector in space.
    pub direction: [f64; 3],
    /// Curve of the least value over time [length], by its number in the loads.
    pub lower: Option<usize>,
    /// Curve of the largest value over time [length].
    pub upper: Option<usize>,
    /// True if the bounds are for the coordinate of the centre along the direction, not for its
    /// displacement since time 0.
    pub of_position: bool,
    /// Times at which it begins and ends to act [time]; `None` for the whole run.
    pub window: Option<[f64; 2]>,
}

impl RigidBody {
    /// Returns true if it is rigid at a time.
    pub fn is_rigid_at(&self, time: f64) -> bool {
        self.window.is_none_or(|[from, until]| from <= time && time < until)
    }

    /// Returns true if its parts stay rigid once they are.
    pub fn stays_rigid(&self) -> bool {
        self.window.is_none_or(|[_, until]| until == f64::MAX)
    }
}
