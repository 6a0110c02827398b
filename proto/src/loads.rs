//! Loads and prescribed motion as workers know them: names resolved to numbers, sets to ids.

use crate::ids::{ElemId, NodeId};
use serde::{Deserialize, Serialize};

/// Everything from outside that acts on the model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// Points `[time, factor]` of each curve, times ascending.
    pub curves: Vec<Vec<[f64; 2]>>,
    /// Body forces.
    pub gravity: Vec<Gravity>,
    /// Nodal forces.
    pub forces: Vec<NodalForce>,
    /// Pressures.
    pub pressures: Vec<Pressure>,
    /// Prescribed motions; no two have a degree of freedom in common.
    pub motions: Vec<Motion>,
    /// Mass-proportional damping [1/time], 0 for none.
    pub damping: f64,
}

/// A body force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gravity {
    /// Acceleration [length/time^2].
    pub acceleration: [f64; 3],
    /// Index of its curve.
    pub curve: Option<usize>,
}

/// The same force and moment on each of some nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodalForce {
    /// Nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// Force on each [force].
    pub force: [f64; 3],
    /// Moment on each [force length].
    pub moment: [f64; 3],
    /// Index of its curve.
    pub curve: Option<usize>,
}

/// A pressure on faces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pressure {
    /// Element and index into [`crate::mesh::Shape::faces`], ascending.
    pub faces: Vec<(ElemId, u8)>,
    /// Pressure, positive against the face's normal [force/length^2].
    pub pressure: f64,
    /// Index of its curve.
    pub curve: Option<usize>,
}

impl Pressure {
    /// Loaded faces of an element, as indices into [`crate::mesh::Shape::faces`].
    pub fn faces_of(&self, element: ElemId) -> impl Iterator<Item = u8> {
        let first = self.faces.partition_point(|f| f.0 < element);
        self.faces[first..].iter().take_while(move |f| f.0 == element).map(|f| f.1)
    }
}

/// A prescribed motion. Its degrees of freedom are among those that the records of its nodes have
/// as not free.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// Bits 0..6: x, y, z, rx, ry, rz are prescribed.
    pub dofs: u64,
    /// What `amount` is.
    pub form: MotionForm,
    /// Displacement, velocity, acceleration or spin, to be multiplied by the curve.
    pub amount: [f64; 3],
    /// Index of its curve.
    pub curve: Option<usize>,
}

/// How a motion is given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum MotionForm {
    /// Displacement [length].
    Displacement,
    /// Velocity [length/time].
    Velocity,
    /// Acceleration, from rest [length/time^2].
    Acceleration,
    /// Rotational velocity about an axis through `centre` [1/time].
    Spin {
        /// A point of the axis [length].
        centre: [f64; 3],
    },
}

impl Loads {
    /// Whether anything is loaded or moved.
    pub fn act(&self) -> bool {
        !(self.gravity.is_empty()
            && self.forces.is_empty()
            && self.pressures.is_empty()
            && self.motions.is_empty())
    }
}
