//! Element types of Abaqus, and the faces of elements.

use crate::input::mesh_file::cells::Cell;

/// Element types: the begin of their name, number of nodes, cell. The longest begin counts.
const TYPES: &[(&str, usize, Cell)] = &[
    ("C3D8", 8, Cell::Hexahedron),
    ("C3D4", 4, Cell::Tetrahedron),
    ("C3D5", 5, Cell::Pyramid),
    ("C3D6", 6, Cell::Wedge),
    ("C3D10", 10, Cell::Tetrahedron10),
    ("C3D15", 15, Cell::SecondOrder("wedge with 15 nodes", 3)),
    ("C3D20", 20, Cell::SecondOrder("hexahedron with 20 nodes", 3)),
    ("C3D27", 27, Cell::SecondOrder("hexahedron with 27 nodes", 3)),
    ("S3", 3, Cell::Triangle),
    ("STRI3", 3, Cell::Triangle),
    ("M3D3", 3, Cell::Other("membrane", 2)),
    ("SFM3D3", 3, Cell::Other("surface element without stiffness", 2)),
    ("R3D3", 3, Cell::Triangle),
    ("CPS3", 3, Cell::Triangle),
    ("CPE3", 3, Cell::Triangle),
    ("S4", 4, Cell::Quad),
    ("M3D4", 4, Cell::Other("membrane", 2)),
    ("SFM3D4", 4, Cell::Other("surface element without stiffness", 2)),
    ("R3D4", 4, Cell::Quad),
    ("CPS4", 4, Cell::Quad),
    ("CPE4", 4, Cell::Quad),
    ("S8", 8, Cell::SecondOrder("quad with 8 nodes", 2)),
    ("S9", 9, Cell::SecondOrder("quad with 9 nodes", 2)),
    ("STRI65", 6, Cell::SecondOrder("triangle with 6 nodes", 2)),
    ("M3D6", 6, Cell::SecondOrder("triangle with 6 nodes", 2)),
    ("M3D8", 8, Cell::SecondOrder("quad with 8 nodes", 2)),
    ("CPS6", 6, Cell::SecondOrder("triangle with 6 nodes", 2)),
    ("CPE6", 6, Cell::SecondOrder("triangle with 6 nodes", 2)),
    ("CPS8", 8, Cell::SecondOrder("quad with 8 nodes", 2)),
    ("CPE8", 8, Cell::SecondOrder("quad with 8 nodes", 2)),
    ("B21", 2, Cell::Line),
    ("B31", 2, Cell::Line),
    ("B33", 2, Cell::Line),
    ("PIPE31", 2, Cell::Line),
    ("T2D2", 2, Cell::Line),
    ("T3D2", 2, Cell::Line),
    ("B22", 3, Cell::SecondOrder("line with 3 nodes", 1)),
    ("B32", 3, Cell::SecondOrder("line with 3 nodes", 1)),
    ("T3D3", 3, Cell::SecondOrder("line with 3 nodes", 1)),
    ("SC6", 6, Cell::Other("continuum shell", 3)),
    ("SC8", 8, Cell::Other("continuum shell", 3)),
    ("COH3D6", 6, Cell::Other("cohesive element", 3)),
    ("COH3D8", 8, Cell::Other("cohesive element", 3)),
    ("CAX3", 3, Cell::Other("axisymmetric element", 2)),
    ("CAX4", 4, Cell::Other("axisymmetric element", 2)),
    ("CAX6", 6, Cell::Other("axisymmetric element", 2)),
    ("CAX8", 8, Cell::Other("axisymmetric element", 2)),
    ("MASS", 1, Cell::Joint("point mass", "point masses: [[mass]]")),
    ("ROTARYI", 1, Cell::Joint("point inertia", "point inertia: rigid.added_inertia")),
    ("SPRINGA", 2, Cell::Joint("spring", "springs: mesh.springs of a job with its own mesh")),
    ("SPRING1", 1, Cell::Joint("spring", "springs: mesh.springs of a job with its own mesh")),
    ("SPRING2", 2, Cell::Joint("spring", "springs: mesh.springs of a job with its own mesh")),
    ("DASHPOTA", 2, Cell::Joint("damper", "dampers: mesh.springs of a job with its own mesh")),
    ("DASHPOTA", 2, Cell::Joint("dashpot", "dampers: mesh.springs of a job with its own mesh")),
    ("DASHPOT1", 1, Cell::Joint("dashpot", "dampers: mesh.springs of a job with its own mesh")),
    ("DASHPOT2", 2, Cell::Joint("dashpot", "dampers: mesh.springs of a job with its own mesh")),
    ("CONN3D2", 2, Cell::Joint("connector", "connectors: [[rigid]] or [[tie]]")),
];

/// Returns cell and number of nodes of an element type; `None` if it is not known.
pub fn cell_of(name: &str) -> Option<(Cell, usize)> {
    let begins = TYPES.iter().filter(|(begin, ..)| name.starts_with(begin));
    // `C3D20` is no C3D2 and `S3` no STRI3; further letters are variants, further digits are not.
    let fits =
        begins.filter(|(begin, ..)| !name[begin.len()..].starts_with(|c: char| c.is_ascii_digit()));
    fits.max_by_key(|(begin, ..)| begin.len()).map(|&(_, nodes, cell)| (cell, nodes))
}

/// Returns true for types that belong to rigid bodies.
pub fn is_rigid(name: &str) -> bool {
    name.starts_with("R3D")
}

/// Returns the nodes of a face of an element; `None` if it has no such face.
pub fn face(cell: Cell, name: &str) -> Option<&'static [usize]> {
    let faces: &[(&str, &'static [usize])] = match cell {
        Cell::Hexahedron => &[
            ("S1", &[0, 1, 2, 3]),
            ("S2", &[4, 7, 6, 5]),
            ("S3", &[0, 4, 5, 1]),
            ("S4", &[1, 5, 6, 2]),
            ("S5", &[2, 6, 7, 3]),
            ("S6", &[3, 7, 4, 0]),
        ],
        Cell::Tetrahedron => {
            &[("S1", &[0, 1, 2]), ("S2", &[0, 3, 1]), ("S3", &[1, 3, 2]), ("S4", &[2, 3, 0])]
        }
        Cell::Tetrahedron10 => &[
            ("S1", &[0, 1, 2, 4, 5, 6]),
            ("S2", &[0, 3, 1, 7, 8, 4]),
            ("S3", &[1, 3, 2, 8, 9, 5]),
            ("S4", &[2, 3, 0, 9, 7, 6]),
        ],
        Cell::Wedge => &[
            ("S1", &[0, 1, 2]),
            ("S2", &[3, 5, 4]),
            ("S3", &[0, 3, 4, 1]),
            ("S4", &[1, 4, 5, 2]),
            ("S5", &[2, 5, 3, 0]),
        ],
        Cell::Quad => &[
            ("SPOS", &[0, 1, 2, 3]),
            ("SNEG", &[0, 1, 2, 3]),
            ("E1", &[0, 1]),
            ("E2", &[1, 2]),
            ("E3", &[2, 3]),
            ("E4", &[3, 0]),
        ],
        Cell::Triangle => &[
            ("SPOS", &[0, 1, 2]),
            ("SNEG", &[0, 1, 2]),
            ("E1", &[0, 1]),
            ("E2", &[1, 2]),
            ("E3", &[2, 0]),
        ],
        _ => &[],
    };
    faces.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, corners)| *corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_with_further_digits_are_others() {
        for (name, wanted) in [
            ("C3D8R", Some(Cell::Hexahedron)),
            ("C3D8", Some(Cell::Hexahedron)),
            ("C3D20R", Some(Cell::SecondOrder("hexahedron with 20 nodes", 3))),
            ("S4RS", Some(Cell::Quad)),
            ("STRI65", Some(Cell::SecondOrder("triangle with 6 nodes", 2))),
            ("C3D81", None),
            // Read as shells, they would bend.
            ("M3D4R", Some(Cell::Other("membrane", 2))),
            ("M3D3", Some(Cell::Other("membrane", 2))),
            ("SFM3D4R", Some(Cell::Other("surface element without stiffness", 2))),
            ("S", None),
            ("", None),
        ] {
            assert_eq!(cell_of(name).map(|c| c.0), wanted, "{name}");
        }
    }
}
