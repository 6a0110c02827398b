//! Solids that fail together in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Solids that fail together, such as those of a spot weld: within eight cycles after one of them
/// has failed by its law, the others fail too.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FailureGroupInput {
    /// Name in messages.
    pub name: String,
    /// Ids of two or more hexahedra of parts whose law can fail. An element is in one group at
    /// most.
    pub elements: Vec<u64>,
}
