//! Types of cells in mesh files, and their use as elements.

use crumple_proto::mesh::Shape;

/// A type of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// One node.
    Point,
    /// Two nodes.
    Line,
    /// Three corners.
    Triangle,
    /// Four corners.
    Quad,
    /// Eight corners.
    Hexahedron,
    /// Four corners of a volume.
    Tetrahedron,
    /// Four corners of a volume and the middles of its edges, in the order of
    /// [`Shape::Tet10`].
    Tetrahedron10,
    /// Six corners of a volume.
    Wedge,
    /// Five corners of a volume.
    Pyramid,
    /// Nodes on its sides too; its name, and the dimension of its geometry.
    SecondOrder(&'static str, usize),
    /// A shell with nodes on its sides too, which is read by its corners; its name, and the shape
    /// of the corners.
    ByCorners(&'static str, Shape),
    /// A mass, spring or connector, which the job has in sections of its own; its name, and what to
    /// write there.
    Joint(&'static str, &'static str),
    /// Not supported; its name, and the dimension of its geometry.
    Other(&'static str, usize),
}

/// Use of a type of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellUse {
    /// It is an element of this shape.
    Element(Shape),
    /// It is no element.
    Point,
    /// It is ignored; what to write in the job.
    Ignored(&'static str),
    /// It is not supported; the cure.
    Refused(&'static str),
}

const PYRAMIDS: &str = "mesh the volume with tetrahedra alone, or with hexahedra alone (sweep or \
                        map it; in Gmsh Transfinite or Extrude with Layers, and Recombine)";

impl Cell {
    /// Returns its name, for messages.
    pub fn name(self) -> &'static str {
        match self {
            Cell::Point => "point",
            Cell::Line => "line",
            Cell::Triangle => "triangle",
            Cell::Quad => "quad",
            Cell::Hexahedron => "hexahedron",
            Cell::Tetrahedron => "tetrahedron with 4 nodes",
            Cell::Tetrahedron10 => "tetrahedron with 10 nodes",
            Cell::Wedge => "wedge with 6 nodes",
            Cell::Pyramid => "pyramid with 5 nodes",
            Cell::SecondOrder(name, _)
            | Cell::ByCorners(name, _)
            | Cell::Other(name, _)
            | Cell::Joint(name, _) => name,
        }
    }

    /// Returns its use.
    pub fn usage(self) -> CellUse {
        match self {
            Cell::Point => CellUse::Point,
            Cell::Joint(_, advice) => CellUse::Ignored(advice),
            Cell::Line => CellUse::Element(Shape::Beam2),
            Cell::Triangle => CellUse::Element(Shape::Tri3),
            Cell::Quad => CellUse::Element(Shape::Quad4),
            Cell::Hexahedron => CellUse::Element(Shape::Hex8),
            Cell::Tetrahedron => CellUse::Element(Shape::Tet4),
            Cell::Tetrahedron10 => CellUse::Element(Shape::Tet10),
            Cell::Wedge => CellUse::Element(Shape::Wedge6),
            Cell::ByCorners(_, shape) => CellUse::Element(shape),
            Cell::Pyramid => CellUse::Refused(PYRAMIDS),
            Cell::SecondOrder(..) => CellUse::Refused(
                "mesh with elements of first order, without nodes on their sides (in Gmsh \
                 Mesh.ElementOrder = 1); of second order only tetrahedra with 10 nodes are read, \
                 and shells of Gmsh by their corners",
            ),
            Cell::Other(..) => CellUse::Refused(
                "these are read: quads, triangles, hexahedra with 8 nodes, tetrahedra with 4 or \
                 10, wedges with 6, lines. Remove the others from the mesh",
            ),
        }
    }

    /// Returns the dimension of its geometry.
    pub fn dimension(self) -> usize {
        match self {
            Cell::Point | Cell::Joint(..) => 0,
            Cell::Line => 1,
            Cell::Triangle | Cell::Quad | Cell::ByCorners(..) => 2,
            Cell::SecondOrder(_, dimension) | Cell::Other(_, dimension) => dimension,
            Cell::Hexahedron
            | Cell::Tetrahedron
            | Cell::Tetrahedron10
            | Cell::Wedge
            | Cell::Pyramid => 3,
        }
    }
}
