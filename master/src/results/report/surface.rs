//! The visible faces of the elements: shells, lines and points, and the faces of solids that are
//! outside at some time.

use super::series::{ABSENT, CellShape, MeshSeries};
use crumple_proto::mesh::{Shape, face_key};
use std::collections::HashMap;

/// A face with up to four corners. A triangle repeats its third, a line its second, a point its
/// first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VisibleFace {
    /// Indices of its nodes.
    pub corners: [u32; 4],
    /// Indices of the elements on its two sides. The face is visible while exactly one of them is
    /// present.
    pub owners: [u32; 2],
}

/// Code of a side without element.
pub const NO_ELEMENT: u32 = u32::MAX;

/// Returns the faces of a solid by its corners.
fn faces_of(shape: CellShape) -> &'static [[usize; 4]] {
    match shape {
        CellShape::Hexahedron => Shape::Hex8.faces(),
        CellShape::Tetrahedron => Shape::Tet4.faces(),
        CellShape::Wedge => Shape::Wedge6.faces(),
        CellShape::QuadraticTetrahedron => Shape::Tet10.faces(),
        CellShape::Point | CellShape::Line | CellShape::Triangle | CellShape::Quad => &[],
    }
}

/// Returns the faces that are visible at some time, in the order of their elements.
pub fn faces(series: &MeshSeries) -> Vec<VisibleFace> {
    let mut faces: Vec<VisibleFace> = Vec::new();
    let mut between: HashMap<[u32; 4], usize> = HashMap::new();
    for (number, e) in series.elements.iter().enumerate() {
        let owner = number as u32;
        let c = e.corners;
        match e.shape {
            CellShape::Point => {
                faces.push(VisibleFace { corners: [c[0]; 4], owners: [owner, NO_ELEMENT] })
            }
            CellShape::Line => faces.push(VisibleFace {
                corners: [c[0], c[1], c[1], c[1]],
                owners: [owner, NO_ELEMENT],
            }),
            CellShape::Triangle => faces.push(VisibleFace {
                corners: [c[0], c[1], c[2], c[2]],
                owners: [owner, NO_ELEMENT],
            }),
            CellShape::Quad => faces.push(VisibleFace {
                corners: [c[0], c[1], c[2], c[3]],
                owners: [owner, NO_ELEMENT],
            }),
            CellShape::Hexahedron
            | CellShape::Tetrahedron
            | CellShape::Wedge
            | CellShape::QuadraticTetrahedron => {
                for face in faces_of(e.shape) {
                    let Some(corners) = without_repeats(face.map(|i| c[i])) else { continue };
                    let key = face_key(corners);
                    match between.remove(&key) {
                        Some(of_other) => faces[of_other].owners[1] = owner,
                        None => {
                            between.insert(key, faces.len());
                            faces.push(VisibleFace { corners, owners: [owner, NO_ELEMENT] });
                        }
                    }
                }
            }
        }
    }
    let there = |frame: usize, owner: u32| {
        let state = &series.frames[frame].state;
        owner != NO_ELEMENT && state.get(owner as usize).is_some_and(|&s| s != ABSENT)
    };
    let seen = |f: &VisibleFace| {
        (0..series.frames.len()).any(|k| there(k, f.owners[0]) != there(k, f.owners[1]))
    };
    faces.retain(seen);
    faces
}

/// Returns the face with each corner once and the last one repeated up to four; none if it has no
/// area.
pub fn without_repeats(corners: [u32; 4]) -> Option<[u32; 4]> {
    let mut once = Vec::with_capacity(4);
    for corner in corners {
        if !once.contains(&corner) {
            once.push(corner);
        }
    }
    match once[..] {
        [a, b, c, d] => Some([a, b, c, d]),
        [a, b, c] => Some([a, b, c, c]),
        _ => None,
    }
}

#[cfg(test)]
pub mod tests {
    use super::super::series::{FieldFrame, SeriesElement};
    use super::*;

    /// Returns a row of `count` cubes. All are present at the first time, and those of `later` at
    /// the second.
    pub fn row_of_cubes(count: u32, later: &[u8]) -> MeshSeries {
        let node = |i: u32, j: u32| 4 * i + j;
        let cube = |i: u32| SeriesElement {
            shape: CellShape::Hexahedron,
            corners: std::array::from_fn(|k| node(i + (k as u32 / 4).min(1), k as u32 % 4)),
            part: i % 2,
            id: (1 << 40) + 7 * u64::from(i),
        };
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let at = |shift: f32| {
            let x = |n: u32| {
                [(n / 4) as f32 + shift, square[n as usize % 4][0], square[n as usize % 4][1]]
            };
            (0..4 * (count + 1)).map(x).collect::<Vec<[f32; 3]>>()
        };
        let frame = |time: f64, state: Vec<u8>| FieldFrame {
            time,
            position: at(time as f32),
            worker: (0..count as u16).collect(),
            scalars: std::array::from_fn(|s| {
                (0..count).map(|e| (e * (s as u32 + 1)) as f32 * time as f32).collect()
            }),
            node_scalars: [(0..4 * (count + 1)).map(|n| n as f32 * time as f32).collect()],
            contact_force: Vec::new(),
            state,
        };
        MeshSeries {
            elements: (0..count).map(cube).collect(),
            node_ids: (0..4 * u64::from(count + 1)).map(|n| 3 * n + 1).collect(),
            frames: vec![frame(0.0, vec![1; count as usize]), frame(2.0, later.to_vec())],
            written: 2,
            unknown_shapes: 0,
        }
    }

    #[test]
    fn faces_between_solids_are_kept_only_where_they_come_to_light() {
        // Cubes 0..5; the third one fails. Both of its inner faces then become visible; the other
        // two inner faces never are.
        let series = row_of_cubes(5, &[1, 1, 0, 2, 1]);
        let faces = faces(&series);
        let inner: Vec<[u32; 2]> =
            faces.iter().map(|f| f.owners).filter(|o| o[1] != NO_ELEMENT).collect();
        assert_eq!(inner, [[1, 2], [2, 3]]);
        assert_eq!(faces.len() - inner.len(), 5 * 4 + 2);
    }

    #[test]
    fn a_face_of_a_wedge_has_three_corners_and_one_without_area_goes() {
        assert_eq!(without_repeats([3, 7, 7, 5]), Some([3, 7, 5, 5]));
        assert_eq!(without_repeats([3, 3, 5, 6]), Some([3, 5, 6, 6]));
        assert_eq!(without_repeats([3, 3, 5, 5]), None);
    }
}
