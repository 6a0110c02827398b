//! Tied nodes for workers.

use crate::ids::{ElemId, NodeId};
use serde::{Deserialize, Serialize};

/// Tie of a node (slave) to other nodes (masters).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tie {
    /// The slave.
    pub node: NodeId,
    /// Masters with their weights, ascending. Weights are above 0 and sum to 1. No master is
    /// itself a slave.
    pub masters: Vec<(NodeId, f64)>,
    /// Untied nodes of the surface whose projection is on a face between tied nodes that
    /// include this one; contact ignores them as it does masters.
    pub near: Vec<NodeId>,
    /// Elements of the face that the slave is projected onto, and of the faces of slaves in
    /// between. If one of them fails, the slave is released. Empty if it is tied to a node.
    pub faces: Vec<ElemId>,
    /// True if rotations are tied too.
    pub rotations: bool,
    /// True if the slave keeps its position relative to the mean position of its masters, at
    /// the end of an arm that rotates with them. Otherwise it is at the mean position.
    pub offset: bool,
    /// True if the arm has the mean rotation of the positions of the masters, and moments act on
    /// them as forces. Otherwise the arm has the mean of their rotations.
    pub mean: bool,
    /// Limits at which the slave is released, if it can come off its face.
    pub failure: Option<TieStrength>,
}

/// Limits of the force between a slave and its face, and the face.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TieStrength {
    /// Tension and shear at which the slave is released without the other; infinite without a
    /// limit [force].
    pub limits: [f64; 2],
    /// Their exponents.
    pub exponents: [f64; 2],
    /// Distance over which the force falls to zero after the failure [length].
    pub opening: f64,
    /// Corners of the face, in an order that turns its normal towards the slave.
    pub corners: [NodeId; 4],
}

impl Tie {
    /// Returns the nodes of the surface whose contact with this slave is ignored.
    pub fn partners(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.masters.iter().map(|c| c.0).chain(self.near.iter().copied())
    }
}
