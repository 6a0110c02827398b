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
    /// First id of a new element.
    pub first_element: ElemId,
    /// First id of a new node.
    pub first_node: NodeId,
}
