//! Adaptivity for workers: which shells may be divided, and when.

use crate::ids::{ElemId, NodeId};
use serde::{Deserialize, Serialize};

/// Division of shells that bend, as all workers have it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AdaptivitySettings {
    /// Indices of the parts whose quads may be divided, ascending.
    pub parts: Vec<u32>,
    /// Plastic bending angle from which on a quad is divided [rad].
    pub angle: f64,
    /// Number of rings of neighbours that are divided with it.
    pub rings: u32,
    /// Largest number of divisions, one after the other, of an element of the mesh.
    pub levels: u32,
    /// Times of the first check and after the last one [time].
    pub window: [f64; 2],
    /// Time between two checks [time].
    pub interval: f64,
    /// Quads of these parts that are never divided, ascending.
    pub kept: Vec<ElemId>,
    /// Pairs of nodes, each with the lower id first, ascending: both nodes have one motion that is
    /// prescribed, and so has a node between them.
    pub led: Vec<[NodeId; 2]>,
    /// First ids of new elements and nodes.
    pub first: (ElemId, NodeId),
}

impl AdaptivitySettings {
    /// Returns the time of a check by its number [time].
    pub fn time_of(&self, number: u64) -> f64 {
        self.window[0] + number as f64 * self.interval
    }
}
