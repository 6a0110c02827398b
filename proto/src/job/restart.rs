//! Changes of the model that a run makes when it continues from a checkpoint.

use super::{PartRef, WallInput};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Changes of the model when a run continues, given by `--set` with `crumple run --resume`. Later
/// continuations keep them, and may add more.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Restart {
    /// Parts that are deleted: their elements, their mass, and the nodes that no other element has.
    #[schemars(with = "Vec<PartRef>")]
    pub delete: Vec<u32>,
    /// Parts of which each becomes a rigid body, with the mass and the momenta of its nodes.
    #[schemars(with = "Vec<PartRef>")]
    pub rigid: Vec<u32>,
    /// New velocities of parts.
    pub velocity: Vec<PartVelocity>,
    /// Additional rigid walls. They are at rest, or have a mass.
    pub wall: Vec<WallInput>,
}

/// New velocity of all nodes of some parts; their rotational velocities become zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartVelocity {
    /// Parts.
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Velocity [length/time].
    pub velocity: [f64; 3],
}

impl Restart {
    /// Returns the name of the rigid body that a part becomes.
    pub fn body_name(part: u32) -> String {
        format!("part {part} since a restart")
    }
}
