//! Discrete springs and dampers as they are written in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What makes a part one of springs and dampers: its elements are the rows of `mesh.springs`. The
/// force is that of the elongation plus that of its rate, tension positive, along the line between
/// the two nodes.
///
/// Springs have no mass: what is free at their ends needs some. To tie a node to the ground, let
/// the other node be one that a `[[fix]]` holds in x, y and z; it needs no mass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// Stiffness [force/length].
    #[serde(default)]
    pub stiffness: f64,
    /// Force over elongation against the start instead of `stiffness`: `[elongation, force]` with
    /// ascending elongations; beyond its ends it goes on with its first and last slope [length,
    /// force].
    #[serde(default)]
    pub force_elongation: Vec<[f64; 2]>,
    /// Damping [force time/length].
    #[serde(default)]
    pub damping: f64,
    /// Force over the rate of elongation instead of `damping`, likewise [length/time, force].
    #[serde(default)]
    pub force_rate: Vec<[f64; 2]>,
    /// A direction that stays: elongation is the relative displacement along it, from the first
    /// node to the second, and so is the force. Springs without length need one.
    #[serde(default)]
    pub direction: Option<[f64; 3]>,
}
