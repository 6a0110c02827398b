//! Trusses in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Cross section of a part of trusses; its elements are the rows of `mesh.trusses`. A truss has a
/// force along the line between its two nodes and nothing else: its nodes do not rotate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrussInput {
    /// Cross-section area [length^2].
    pub area: f64,
    /// Contact radius [length]. Without it, the radius of the circle with the same area.
    /// `contact.thickness_limit` bounds it by the length of the truss.
    #[serde(default)]
    pub contact_radius: Option<f64>,
}
