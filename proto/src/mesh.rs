//! A mesh as a generator or a file gives it: nodes, elements, named node sets.

use crate::ids::{ElemId, NodeId};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Shape of an element, before a part gives it a formulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Shape {
    /// Four-node shell.
    Quad4,
    /// Three-node shell.
    Tri3,
}

impl Shape {
    /// Number of corner nodes.
    pub fn corners(self) -> usize {
        match self {
            Shape::Quad4 => 4,
            Shape::Tri3 => 3,
        }
    }

    /// Corners of each face that pressure may act on, in order around its normal; a triangle repeats its third.
    /// The one face of a shell has the shell's own normal.
    pub fn faces(self) -> &'static [[usize; 4]] {
        match self {
            Shape::Quad4 => &[[0, 1, 2, 3]],
            Shape::Tri3 => &[[0, 1, 2, 2]],
        }
    }
}

/// One node: id and initial coordinates [length].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshNode {
    /// Global id.
    pub id: NodeId,
    /// Initial coordinates [length].
    pub x: [f64; 3],
}

/// One element: id, id of its part, shape, corner nodes (a triangle repeats its third node as the fourth).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshElement {
    /// Global id.
    pub id: ElemId,
    /// Id of the part that it belongs to.
    pub part: u32,
    /// Shape.
    pub shape: Shape,
    /// Corner nodes in order around the element.
    pub nodes: [NodeId; 4],
}

impl MeshElement {
    /// The corner nodes that are in use.
    pub fn corners(&self) -> &[NodeId] {
        &self.nodes[..self.shape.corners()]
    }
}

/// A whole mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Nodes, in any order of id.
    pub nodes: Vec<MeshNode>,
    /// Elements, in any order of id.
    pub elements: Vec<MeshElement>,
    /// Named node sets.
    pub node_sets: BTreeMap<String, Vec<NodeId>>,
}
