//! Tied nodes as workers know them.

use crate::ids::NodeId;
use serde::{Deserialize, Serialize};

/// A node that is carried by others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tie {
    /// The node.
    pub node: NodeId,
    /// What carries it, ascending, with their shares: above 0, together 1. None of them is tied itself.
    pub carriers: Vec<(NodeId, f64)>,
    /// Whether rotations are tied too.
    pub rotations: bool,
    /// Whether it keeps its place against its carriers' mean one, as an arm that turns with them; without, that is its place.
    pub offset: bool,
}
