//! A mesh as a generator or a file gives it: nodes, elements, named node sets.

use crate::ids::{ElemId, NodeId};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};

/// Shape of an element, before a part gives it a formulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Shape {
    /// Four-node shell.
    Quad4,
    /// Three-node shell.
    Tri3,
    /// Eight-node solid: the four nodes of a face, whose right-hand normal points into the solid,
    /// then those opposite.
    Hex8,
    /// Two nodes: a spring or damper.
    Line2,
    /// A beam: two nodes, and in a mesh as it is given a third one, in the plane of the first and
    /// second axis.
    Beam2,
}

impl Shape {
    /// All shapes, in the order of their numbers.
    pub const ALL: [Shape; 5] =
        [Shape::Quad4, Shape::Tri3, Shape::Hex8, Shape::Line2, Shape::Beam2];

    /// Number of corner nodes.
    pub fn corners(self) -> usize {
        match self {
            Shape::Quad4 => 4,
            Shape::Tri3 => 3,
            Shape::Hex8 => 8,
            Shape::Line2 | Shape::Beam2 => 2,
        }
    }

    /// Places for corners in the columns of a block: a triangle leaves its fourth unused.
    pub fn slots(self) -> usize {
        match self {
            Shape::Quad4 | Shape::Tri3 => 4,
            Shape::Hex8 => 8,
            Shape::Line2 | Shape::Beam2 => 2,
        }
    }

    /// Corners of each face, whose right-hand normal points outwards; of a shell its own corners
    /// (a triangle repeats its third). Lines have none.
    pub fn faces(self) -> &'static [[usize; 4]] {
        match self {
            Shape::Quad4 => &[[0, 1, 2, 3]],
            Shape::Tri3 => &[[0, 1, 2, 2]],
            Shape::Hex8 => &[
                [0, 3, 2, 1],
                [4, 5, 6, 7],
                [0, 1, 5, 4],
                [1, 2, 6, 5],
                [2, 3, 7, 6],
                [3, 0, 4, 7],
            ],
            Shape::Line2 | Shape::Beam2 => &[],
        }
    }

    /// Whether its nodes turn.
    pub fn turns(self) -> bool {
        self.is_shell() || self == Shape::Beam2
    }

    /// Whether it is a shell.
    pub fn is_shell(self) -> bool {
        matches!(self, Shape::Quad4 | Shape::Tri3)
    }

    /// Whether it is a solid.
    pub fn is_solid(self) -> bool {
        self == Shape::Hex8
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

/// Corner nodes of an element, the last repeated up to eight.
pub type CornerNodes = [NodeId; 8];

/// The corners as [`CornerNodes`].
///
/// # Panics
/// Without any corner, or with more than eight.
pub fn corner_nodes(corners: &[NodeId]) -> CornerNodes {
    let last = *corners.last().expect("an element has corners");
    assert!(corners.len() <= 8, "an element has eight corners at most");
    std::array::from_fn(|c| corners.get(c).copied().unwrap_or(last))
}

/// One element: id, id of its part, shape, corner nodes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshElement {
    /// Global id.
    pub id: ElemId,
    /// Id of the part that it belongs to.
    pub part: u32,
    /// Shape.
    pub shape: Shape,
    /// Corner nodes in the order of the shape.
    pub nodes: CornerNodes,
    /// Thickness of a shell that has one of its own; 0 for that of its part [length].
    pub thickness: f64,
}

impl MeshElement {
    /// An element with these corners.
    ///
    /// # Panics
    /// Without any corner, or with more than eight.
    pub fn new(id: ElemId, part: u32, shape: Shape, corners: &[NodeId]) -> Self {
        Self { id, part, shape, nodes: corner_nodes(corners), thickness: 0.0 }
    }

    /// The corner nodes that are in use.
    pub fn corners(&self) -> &[NodeId] {
        &self.nodes[..self.shape.corners()]
    }
}

/// The faces of each solid that no other solid repeats, as bits by their number; 0 for all else.
pub fn free_faces(elements: &[MeshElement]) -> Vec<u8> {
    let mut open: HashMap<[NodeId; 4], (usize, usize)> = HashMap::new();
    let mut free = vec![0u8; elements.len()];
    for (i, e) in elements.iter().enumerate().filter(|(_, e)| e.shape.is_solid()) {
        for (f, face) in e.shape.faces().iter().enumerate() {
            let mut key = face.map(|c| e.nodes[c]);
            key.sort_unstable();
            match open.remove(&key) {
                Some((other, opposing)) => free[other] &= !(1 << opposing),
                None => {
                    open.insert(key, (i, f));
                    free[i] |= 1 << f;
                }
            }
        }
    }
    free
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
