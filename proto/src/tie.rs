//! Tied nodes as workers know them.

use crate::ids::{ElemId, NodeId};
use serde::{Deserialize, Serialize};

/// A node that is carried by others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tie {
    /// The node.
    pub node: NodeId,
    /// What carries it, ascending, with their shares: above 0, together 1. None of them is tied
    /// itself.
    pub masters: Vec<(NodeId, f64)>,
    /// Nodes of the surface that stand on faces between tied nodes, of which this is one: contact
    /// lets them be, as it does carriers.
    pub near: Vec<NodeId>,
    /// Elements of the face that it stands on, and of those of tied nodes in between: when one of
    /// them fails it is let go. None for what is tied to a node.
    pub faces: Vec<ElemId>,
    /// Whether rotations are tied too.
    pub rotations: bool,
    /// Whether it keeps its place against its carriers' mean one, as an arm that turns with them;
    /// without, that is its place.
    pub offset: bool,
}

impl Tie {
    /// Nodes of the surface that contact does not look at together with this one.
    pub fn partners(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.masters.iter().map(|c| c.0).chain(self.near.iter().copied())
    }
}
