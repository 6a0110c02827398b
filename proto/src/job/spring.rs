//! Discrete springs and dampers in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Properties of a part of springs and dampers; its elements are the rows of `mesh.springs`. The
/// force is the sum of a function of the elongation and a function of its rate. It acts along the
/// line between the two nodes; tension is positive.
///
/// A rotational spring (`rotational`) has a moment instead of a force, an angle in radians instead
/// of an elongation, and acts about the line or the direction.
///
/// Springs have no mass, so a free node at their end needs some mass. To connect a node to the
/// ground, use as second node one that a `[[fix]]` fixes in x, y and z; it needs no mass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringInput {
    /// Stiffness [force/length].
    #[serde(default)]
    pub stiffness: f64,
    /// Force as a function of the elongation since the start, instead of `stiffness`: points
    /// `[elongation, force]` with ascending elongations. Outside its range it continues with its
    /// first and last slope [length, force].
    #[serde(default)]
    pub force_elongation: Vec<[f64; 2]>,
    /// Damping [force time/length].
    #[serde(default)]
    pub damping: f64,
    /// Force as a function of the rate of elongation, instead of `damping`, in the same form
    /// [length/time, force].
    #[serde(default)]
    pub force_rate: Vec<[f64; 2]>,
    /// True for a moment about the line or the direction, by the relative rotation of the second
    /// node against the first; both have to be nodes of rigid bodies, or fixed in all rotations.
    /// Stiffness and damping are then moments per angle and per rate.
    #[serde(default)]
    pub rotational: bool,
    /// Fixed direction of the force. The elongation is then the relative displacement in this
    /// direction, of the second node against the first. Springs of zero length need it.
    #[serde(default)]
    pub direction: Option<[f64; 3]>,
}
