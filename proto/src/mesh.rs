//! Mesh from a generator or a file: nodes, elements, named node sets.

use crate::ids::{ElemId, NodeId};
use crate::initial::InitialPoint;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};

/// Shape of an element; a part gives it a formulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Shape {
    /// Four-node shell.
    Quad4,
    /// Three-node shell.
    Tri3,
    /// Eight-node solid: the four nodes of a face, whose right-hand normal points into the
    /// solid, then the opposite four.
    Hex8,
    /// Spring or damper with two nodes.
    Line2,
    /// Beam with two nodes; in a mesh from a file a third one lies in the plane of the first
    /// and second axis.
    Beam2,
    /// Truss with two nodes.
    Truss2,
    /// Particle with one node.
    Point1,
    /// Four-node solid: the three nodes of a face, whose right-hand normal points into the solid,
    /// then the fourth.
    Tet4,
    /// Six-node solid, a wedge: the three nodes of a triangle, whose right-hand normal points into
    /// the solid, then the opposite three.
    Wedge6,
    /// Ten-node solid: the four corners as in [`Shape::Tet4`], then the nodes on the edges 0-1,
    /// 1-2, 2-0, 0-3, 1-3 and 2-3.
    Tet10,
    /// Eight-node cohesive element: the four nodes of one face, whose right-hand normal points to
    /// the other, then the four opposite ones, which may be at the same places. In a mesh it is
    /// written as [`Shape::Hex8`]; its part makes it cohesive.
    Cohesive8,
}

/// Largest number of nodes of an element.
pub const MAX_CORNERS: usize = 10;

/// Corners of the edges of [`Shape::Tet10`], in the order of their nodes.
pub const EDGES_OF_TET10: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Faces of [`Shape::Tet10`]: four triangles on each side of the tetrahedron, three at its corners
/// and one between the nodes on its edges.
const SIDES_OF_TET10: [[usize; 4]; 16] = [
    [0, 6, 4, 4],
    [2, 5, 6, 6],
    [1, 4, 5, 5],
    [4, 6, 5, 5],
    [0, 4, 7, 7],
    [1, 8, 4, 4],
    [3, 7, 8, 8],
    [4, 8, 7, 7],
    [1, 5, 8, 8],
    [2, 9, 5, 5],
    [3, 8, 9, 9],
    [5, 9, 8, 8],
    [2, 6, 9, 9],
    [0, 7, 6, 6],
    [3, 9, 7, 7],
    [6, 7, 9, 9],
];

impl Shape {
    /// All shapes, in the order of their numbers.
    pub const ALL: [Shape; 11] = [
        Shape::Quad4,
        Shape::Tri3,
        Shape::Hex8,
        Shape::Line2,
        Shape::Beam2,
        Shape::Truss2,
        Shape::Point1,
        Shape::Tet4,
        Shape::Wedge6,
        Shape::Tet10,
        Shape::Cohesive8,
    ];

    /// Returns the number of nodes, which are called corners also where they lie on edges.
    pub fn corners(self) -> usize {
        match self {
            Shape::Quad4 | Shape::Tet4 => 4,
            Shape::Tri3 => 3,
            Shape::Wedge6 => 6,
            Shape::Hex8 | Shape::Cohesive8 => 8,
            Shape::Tet10 => MAX_CORNERS,
            Shape::Line2 | Shape::Beam2 | Shape::Truss2 => 2,
            Shape::Point1 => 1,
        }
    }

    /// Returns the number of corner slots in the columns of a block; a triangle does not use
    /// its fourth.
    pub fn slots(self) -> usize {
        match self {
            Shape::Quad4 | Shape::Tri3 | Shape::Tet4 => 4,
            Shape::Wedge6 => 6,
            Shape::Hex8 | Shape::Cohesive8 => 8,
            Shape::Tet10 => MAX_CORNERS,
            Shape::Line2 | Shape::Beam2 | Shape::Truss2 => 2,
            Shape::Point1 => 1,
        }
    }

    /// Returns the corners of each face, whose right-hand normal points outwards; a triangle
    /// repeats its third. The face of a shell has the shell's own corners. Each side of a ten-node
    /// tetrahedron is four triangles. Lines, particles and cohesive elements have none.
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
            Shape::Tet4 => &[[0, 2, 1, 1], [0, 1, 3, 3], [1, 2, 3, 3], [2, 0, 3, 3]],
            Shape::Wedge6 => {
                &[[0, 2, 1, 1], [3, 4, 5, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]
            }
            Shape::Tet10 => &SIDES_OF_TET10,
            Shape::Line2 | Shape::Beam2 | Shape::Truss2 | Shape::Point1 | Shape::Cohesive8 => &[],
        }
    }

    /// Returns the mass of a node over the mean of the nodes. In proportion to the diagonal of the
    /// consistent mass matrix (Hinton, Rock & Zienkiewicz 1976) a corner of a ten-node tetrahedron
    /// has 1/36 of its mass and a node on an edge 4/27.
    pub const fn mass_share(self, node: usize) -> f64 {
        match self {
            Shape::Tet10 if node < 4 => 10.0 / 36.0,
            Shape::Tet10 => 40.0 / 27.0,
            _ => 1.0,
        }
    }

    /// Returns the factors on the forces that a pressure on a face gives its corners, if these are
    /// those of a linear face. A uniform pressure on a side of a ten-node tetrahedron acts on the
    /// nodes of the edges alone, a third on each, as its shape functions demand: the three outer
    /// triangles give nothing to the corner, and the more to both edges.
    pub fn load_shares(self, face: usize) -> [f64; 4] {
        match self {
            Shape::Tet10 if face % 4 < 3 => [0.0, 1.5, 1.5, 1.5],
            _ => [1.0; 4],
        }
    }

    /// Returns the nodes of a solid that are behind a face: not on it, nor on the other triangles
    /// of its side. There are at most four.
    pub fn behind(self, face: usize) -> impl Iterator<Item = usize> {
        let faces = self.faces();
        let side = match self {
            Shape::Tet10 => &faces[face / 4 * 4..][..4],
            _ => &faces[face..][..1],
        };
        (0..self.corners()).filter(move |c| !side.as_flattened().contains(c))
    }

    /// Returns true if its nodes have rotational degrees of freedom.
    pub fn turns(self) -> bool {
        self.is_shell() || self == Shape::Beam2
    }

    /// Returns true for bars, which have a cross section about the line between their nodes.
    pub fn is_bar(self) -> bool {
        matches!(self, Shape::Beam2 | Shape::Truss2)
    }

    /// Returns true for shells.
    pub fn is_shell(self) -> bool {
        matches!(self, Shape::Quad4 | Shape::Tri3)
    }

    /// Returns true for solids.
    pub fn is_solid(self) -> bool {
        matches!(self, Shape::Hex8 | Shape::Tet4 | Shape::Wedge6 | Shape::Tet10)
    }
}

/// Node: id and initial coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshNode {
    /// Global id.
    pub id: NodeId,
    /// Initial coordinates [length].
    pub x: [f64; 3],
}

/// Nodes of an element; the last one is repeated up to [`MAX_CORNERS`].
pub type CornerNodes = [NodeId; MAX_CORNERS];

/// Returns the corners as [`CornerNodes`].
///
/// # Panics
/// If there are no corners, or more than [`MAX_CORNERS`].
pub fn corner_nodes(corners: &[NodeId]) -> CornerNodes {
    let last = *corners.last().expect("an element has corners");
    assert!(corners.len() <= MAX_CORNERS, "an element has {MAX_CORNERS} nodes at most");
    std::array::from_fn(|c| corners.get(c).copied().unwrap_or(last))
}

/// Values of a shell that replace those of its part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OwnSection {
    /// Thickness at the start; 0 for that of its part [length].
    pub thickness: f64,
    /// Distance from the nodes to the middle surface, over half the thickness; `None` for that of
    /// its part.
    pub offset: Option<f64>,
    /// Angle about the normal by which the axis a of its material is turned at the start, in
    /// addition to that of its part [degrees].
    pub angle: f64,
}

/// Element: id, part, shape, corner nodes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshElement {
    /// Global id.
    pub id: ElemId,
    /// Id of its part.
    pub part: u32,
    /// Shape.
    pub shape: Shape,
    /// Corner nodes in the order of the shape.
    pub nodes: CornerNodes,
    /// Values of a shell that replace those of its part.
    pub own: OwnSection,
}

impl MeshElement {
    /// Builds an element with these corners.
    ///
    /// # Panics
    /// If there are no corners, or more than [`MAX_CORNERS`].
    pub fn new(id: ElemId, part: u32, shape: Shape, corners: &[NodeId]) -> Self {
        Self { id, part, shape, nodes: corner_nodes(corners), own: OwnSection::default() }
    }

    /// Returns the corner nodes that the shape uses.
    pub fn corners(&self) -> &[NodeId] {
        &self.nodes[..self.shape.corners()]
    }
}

/// Returns shape and corners of a solid that is written with eight nodes: a hexahedron, or with
/// repeated nodes a tetrahedron (four different nodes) or a wedge (six, if two opposite faces have
/// become triangles). Returns `None` for all others, such as pyramids.
pub fn solid_of_eight<N: Copy + PartialEq>(nodes: &[N; 8]) -> Option<(Shape, Vec<N>)> {
    let mut once: Vec<N> = Vec::with_capacity(8);
    nodes.iter().for_each(|n| once.extend((!once.contains(n)).then_some(*n)));
    match once.len() {
        8 => return Some((Shape::Hex8, once)),
        // A quad that is folded onto itself has four nodes too.
        4 if nodes[5..].iter().all(|n| *n == nodes[4]) => return Some((Shape::Tet4, once)),
        6 => {}
        _ => return None,
    }
    let around = |face: &[usize; 4]| {
        let mut corners: Vec<N> = face.iter().map(|&c| nodes[c]).collect();
        corners.dedup();
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        corners
    };
    let faces: Vec<Vec<N>> = Shape::Hex8.faces().iter().map(around).collect();
    let mut triangles = faces.iter().filter(|f| f.len() == 3);
    let (first, second) = (triangles.next()?, triangles.next()?);
    let across = |from: &N| {
        let sides = faces.iter().filter(|f| f.len() == 4);
        let mut next = sides.flat_map(|f| (0..4).map(|i| [f[i], f[(i + 1) % 4]]));
        next.find_map(|[a, b]| (a == *from && second.contains(&b)).then_some(b))
    };
    let below = [first[0], first[2], first[1]];
    let above: Option<Vec<N>> = below.iter().map(across).collect();
    let corners = [&below[..], &above?[..]].concat();
    let is_whole = (1..6).all(|i| !corners[..i].contains(&corners[i]));
    is_whole.then_some((Shape::Wedge6, corners))
}

/// Returns the corners of a face once each: three of a triangle, which repeats its third.
pub fn once_each<T: PartialEq>(face: &[T; 4]) -> &[T] {
    if face[2] == face[3] { &face[..3] } else { face }
}

/// Returns the nodes of a face in ascending order, the last one of a triangle twice: equal for the
/// two solids on both sides of the face.
pub fn face_key<N: Copy + Ord>(face: [N; 4]) -> [N; 4] {
    let mut key = face;
    let count = once_each(&face).len();
    key[..count].sort_unstable();
    if count == 3 {
        key[3] = key[2];
    }
    key
}

/// Returns the faces of each solid that no other solid shares, one bit per face number; 0 for
/// all other elements.
pub fn free_faces(elements: &[MeshElement]) -> Vec<u16> {
    let mut open: HashMap<[NodeId; 4], (usize, usize)> = HashMap::new();
    let mut free = vec![0u16; elements.len()];
    for (i, e) in elements.iter().enumerate().filter(|(_, e)| e.shape.is_solid()) {
        for (f, face) in e.shape.faces().iter().enumerate() {
            let key = face_key(face.map(|c| e.nodes[c]));
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

/// Complete mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Nodes, in any order of id.
    pub nodes: Vec<MeshNode>,
    /// Elements, in any order of id.
    pub elements: Vec<MeshElement>,
    /// Named node sets.
    pub node_sets: BTreeMap<String, Vec<NodeId>>,
    /// Stress and plastic strain of elements at the start, at any number of points.
    pub initial: Vec<InitialPoint>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the free faces by the face numbers of Attaway et al. (1998), eq. 14: a face is that
    /// of its lowest node and of the node diagonal to it.
    fn free_faces_by_diagonals(elements: &[MeshElement]) -> Vec<u16> {
        let key = |e: &MeshElement, face: &[usize; 4]| {
            let nodes = face.map(|c| e.nodes[c]);
            let least = (0..4).min_by_key(|&k| nodes[k]).expect("four nodes");
            (nodes[least], nodes[(least + 2) % 4])
        };
        let faces = |e: &MeshElement| e.shape.faces().iter().map(|f| key(e, f)).collect::<Vec<_>>();
        let all: Vec<_> = elements.iter().flat_map(faces).collect();
        let is_free = |k: &(NodeId, NodeId)| all.iter().filter(|o| *o == k).count() == 1;
        let bits = |e| faces(e).iter().enumerate().map(|(f, k)| u16::from(is_free(k)) << f).sum();
        elements.iter().map(bits).collect()
    }

    fn solid(id: u64, nodes: [u64; 8]) -> MeshElement {
        MeshElement::new(ElemId(id), 1, Shape::Hex8, &nodes.map(NodeId))
    }

    /// Faces by all of their nodes are those of eq. 14 in a mesh without cracks.
    #[test]
    fn free_faces_of_a_block_are_those_of_face_numbers_by_diagonals() {
        let node = |[x, y, z]: [u64; 3]| 1 + x + 4 * (y + 4 * z);
        let cell = |k: u64| {
            let [x, y, z] = [k % 3, k / 3 % 3, k / 9];
            let plane = |z| [[x, y, z], [x + 1, y, z], [x + 1, y + 1, z], [x, y + 1, z]];
            let [low, high] = [plane(z), plane(z + 1)].map(|p| p.map(node));
            solid(k + 1, [low, high].concat().try_into().expect("eight nodes"))
        };
        let block: Vec<_> = (0..27).map(cell).collect();
        let free = free_faces(&block);
        assert_eq!(free, free_faces_by_diagonals(&block));
        assert_eq!(free.iter().map(|f| f.count_ones()).sum::<u32>(), 54);
        assert_eq!(free[13], 0, "the inner cell has no free face");
    }

    /// Two solids on both sides of a crack have two nodes in common, diagonal to each other. Both
    /// faces of the crack are free. The face numbers of eq. 14 are equal, so that neither would be.
    #[test]
    fn faces_of_a_crack_held_by_a_diagonal_are_free() {
        let (lower, upper) = ([5, 6, 7, 8], [5, 9, 7, 10]);
        let below = solid(1, [[1, 2, 3, 4], lower].concat().try_into().expect("eight nodes"));
        let above = solid(2, [upper, [11, 12, 13, 14]].concat().try_into().expect("eight nodes"));
        let crack = [below, above];
        assert_eq!(free_faces(&crack), [0b11_1111; 2]);
        assert_eq!(free_faces_by_diagonals(&crack), [0b11_1101, 0b11_1110]);
    }

    /// A wedge on a tetrahedron: the triangle between them is no free face, in whichever order its
    /// nodes come.
    #[test]
    fn triangles_between_two_solids_are_not_free() {
        let of = |id, shape, nodes: &[u64]| {
            let nodes: Vec<NodeId> = nodes.iter().copied().map(NodeId).collect();
            MeshElement::new(ElemId(id), 1, shape, &nodes)
        };
        let wedge = of(1, Shape::Wedge6, &[1, 2, 3, 4, 5, 6]);
        let tetrahedron = of(2, Shape::Tet4, &[6, 4, 5, 7]);
        assert_eq!(free_faces(&[wedge, tetrahedron]), [0b1_1101, 0b1110]);
    }

    /// Returns the corners of a tetrahedron and the middles of its edges.
    fn with_middles(x: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let middle = |[a, b]: [usize; 2]| [0, 1, 2].map(|c| 0.5 * (x[a][c] + x[b][c]));
        x.iter().copied().chain(EDGES_OF_TET10.map(middle)).collect()
    }

    /// The four triangles of each side have a third of its load on each edge and none at the
    /// corners.
    #[test]
    fn a_pressure_on_a_quadratic_side_acts_on_the_edges() {
        for side in 0..4 {
            let mut load = [0.0; MAX_CORNERS];
            for face in 4 * side..4 * side + 4 {
                // Each triangle has a quarter of the side, and a third of it for each corner.
                let of_corner = Shape::Tet10.load_shares(face).map(|share| share / 12.0);
                let corners = Shape::Tet10.faces()[face];
                (0..3).for_each(|c| load[corners[c]] += of_corner[c]);
            }
            assert_eq!(load[..4], [0.0; 4], "side {side}");
            let edges: Vec<f64> = load[4..].iter().copied().filter(|f| *f > 0.0).collect();
            assert!(edges.len() == 3 && edges.iter().all(|f| (f - 1.0 / 3.0).abs() < 1e-15));
        }
    }

    /// Behind a triangle of a ten-node tetrahedron are the opposite corner and the nodes on the
    /// edges to it; behind a face of another solid all nodes that it does not have.
    #[test]
    fn nodes_behind_a_face_are_not_on_its_side() {
        let behind = |shape: Shape, face| shape.behind(face).collect::<Vec<_>>();
        for face in 0..4 {
            assert_eq!(behind(Shape::Tet10, face), [3, 7, 8, 9]);
            assert_eq!(behind(Shape::Tet10, 12 + face), [1, 4, 5, 8]);
        }
        assert_eq!(behind(Shape::Tet4, 1), [2]);
        assert_eq!(behind(Shape::Hex8, 0), [4, 5, 6, 7]);
        for shape in [Shape::Hex8, Shape::Tet4, Shape::Wedge6, Shape::Tet10] {
            assert!((0..shape.faces().len()).all(|f| shape.behind(f).count() <= 4), "{shape:?}");
        }
    }

    /// All faces of all solids have their normals outwards, and each edge is in two of them.
    #[test]
    fn faces_of_solids_are_closed_and_point_outwards() {
        let corner = |z: f64| [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
        let cube = [corner(0.0), corner(1.0)].concat();
        let pick = |c: &[usize]| c.iter().map(|&c| cube[c]).collect::<Vec<[f64; 3]>>();
        let shapes = [
            (Shape::Hex8, cube.clone(), 1.0),
            (Shape::Wedge6, pick(&[0, 1, 2, 4, 5, 6]), 0.5),
            (Shape::Tet4, pick(&[0, 1, 2, 6]), 1.0 / 6.0),
            (Shape::Tet10, with_middles(&pick(&[0, 1, 2, 6])), 1.0 / 6.0),
        ];
        for (shape, x, volume) in shapes {
            let mut edges = Vec::new();
            let mut sum = 0.0;
            for face in shape.faces() {
                let c = once_each(face);
                edges.extend((0..c.len()).map(|i| (c[i], c[(i + 1) % c.len()])));
                for k in 1..c.len() - 1 {
                    let [a, b, d] = [c[0], c[k], c[k + 1]].map(|c| x[c]);
                    sum += a[0] * (b[1] * d[2] - b[2] * d[1])
                        + a[1] * (b[2] * d[0] - b[0] * d[2])
                        + a[2] * (b[0] * d[1] - b[1] * d[0]);
                }
            }
            assert!((sum / 6.0 - volume).abs() < 1e-15, "{shape:?}: {sum}");
            assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "{shape:?}");
        }
    }

    /// Solids written with eight nodes and repeated ones, as in decks.
    #[test]
    fn repeated_nodes_make_tetrahedra_and_wedges() {
        let shape = |nodes: [u64; 8]| solid_of_eight(&nodes);
        assert_eq!(shape([1, 2, 3, 4, 5, 6, 7, 8]).unwrap().0, Shape::Hex8);
        assert_eq!(shape([1, 2, 3, 4, 4, 4, 4, 4]), Some((Shape::Tet4, vec![1, 2, 3, 4])));
        assert_eq!(shape([1, 2, 3, 3, 5, 5, 5, 5]), Some((Shape::Tet4, vec![1, 2, 3, 5])));
        // The triangles of LS-DYNA's wedge are 1 2 5 and 4 3 7; the normal of the first one points
        // into the solid in the order 1 5 2.
        let (kind, nodes) = shape([1, 2, 3, 4, 5, 5, 7, 7]).unwrap();
        let turned = |n: [u64; 3]| [0, 1, 2].map(|i| [n[i], n[(i + 1) % 3], n[(i + 2) % 3]]);
        assert_eq!(kind, Shape::Wedge6);
        assert!(turned([nodes[0], nodes[1], nodes[2]]).contains(&[1, 5, 2]), "{nodes:?}");
        let above = |n: u64| nodes[3 + nodes.iter().position(|m| *m == n).unwrap()];
        assert_eq!([1, 5, 2].map(above), [4, 7, 3]);
        assert_eq!(shape([1, 2, 3, 3, 5, 6, 7, 7]), Some((Shape::Wedge6, vec![1, 2, 3, 5, 6, 7])));
        assert_eq!(shape([1, 2, 3, 4, 5, 5, 5, 5]), None, "a pyramid");
        assert_eq!(shape([1, 2, 3, 4, 1, 2, 3, 4]), None, "a folded quad");
    }
}
