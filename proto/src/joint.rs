//! Joints for workers, with names resolved to indices.

use crate::job::JointKind;
use serde::{Deserialize, Serialize};

/// Joint between two rigid bodies, or between the ground and a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResolvedJoint {
    /// Kind.
    pub kind: JointKind,
    /// Index of the first body; `None` for the ground.
    pub first: Option<usize>,
    /// Index of the second body.
    pub second: usize,
    /// Point at time 0 [length].
    pub point: [f64; 3],
    /// Unit vectors at time 0, a right-handed system: the axis, the second axis, their normal.
    pub axes: [[f64; 3]; 3],
    /// Distance along the axis per radian, of a screw [length].
    pub lead: f64,
    /// Resistance against rotation about the axis.
    pub rotation: Option<Resistance>,
    /// Resistance against sliding along the axis.
    pub sliding: Option<Resistance>,
}

/// Resistance in one coordinate of a joint, an angle [radian] or a distance [length].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resistance {
    /// Points of the coordinate and its moment or force, ascending; linear beyond the ends. Empty
    /// or at least two.
    pub table: Vec<[f64; 2]>,
    /// Damping [moment time, or force time/length].
    pub damping: f64,
    /// Largest moment or force of friction.
    pub friction: f64,
    /// Smallest and largest coordinate, infinite without stops.
    pub stops: [f64; 2],
}
