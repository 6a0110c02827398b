//! Projection of nodes onto a surface, before the start.

use crate::contact::geometry::nearest;
use crate::contact::search::linked_cells;
use crate::math::row::V3;
use crumple_proto::boxes::Aabb;

/// Largest distance of a node beyond the edge of a face, along the face, over the shorter
/// diagonal of the face. Faces of a curved surface leave such gaps between them.
const MAX_OUTSIDE: f64 = 0.05;

/// Corners of a face; a triangle repeats the third [length].
pub type FaceCorners = [[f64; 3]; 4];

/// Projection of a point onto a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Index of the face.
    pub face: usize,
    /// Shape values at its corners, none below 0; they sum to 1.
    pub shape: [f64; 4],
    /// Nearest point of the face [length].
    pub point: [f64; 3],
    /// Distance to that point [length].
    pub distance: f64,
}

/// Returns the shorter diagonal of a face, or the shortest side of a triangle [length].
pub fn diagonal(face: &FaceCorners) -> f64 {
    let between = |a: usize, b: usize| (V3::from(face[a]) - V3::from(face[b])).norm();
    if face[2] == face[3] {
        between(0, 1).min(between(1, 2)).min(between(2, 0))
    } else {
        between(0, 2).min(between(1, 3))
    }
}

/// Projects each point onto the nearest face that is within the tolerance; of equally near
/// faces the first one counts. `tolerance` gets the indices of a face and a point, and returns
/// zero for a pair that is excluded [length]. `widest` returns the largest tolerance of a face
/// [length].
pub fn feet(
    faces: &[FaceCorners],
    points: &[[f64; 3]],
    widest: impl Fn(usize) -> f64,
    tolerance: impl Fn(usize, usize) -> f64,
) -> Vec<Option<Foot>> {
    let grown =
        |(f, face): (usize, &FaceCorners)| Aabb::around(face.iter().copied()).grown(widest(f));
    let boxes: Vec<Aabb> = faces.iter().enumerate().map(grown).collect();
    let mut feet: Vec<Option<Foot>> = vec![None; points.len()];
    linked_cells(&boxes, points, &mut |f, p| {
        let (f, p) = (f as usize, p as usize);
        let (corners, at) = (faces[f].map(V3::from), V3::from(points[p]));
        let Some(near) = nearest(&at, &corners, faces[f][2] == faces[f][3]) else { return };
        let off = at - near.point;
        let outside = off - near.normal * near.normal.dot(&off);
        let distance = off.norm();
        let reached =
            distance <= tolerance(f, p) && outside.norm() <= MAX_OUTSIDE * diagonal(&faces[f]);
        if reached && feet[p].is_none_or(|old| distance < old.distance) {
            feet[p] = Some(Foot { face: f, shape: near.shape, point: near.point.into(), distance });
        }
    });
    feet
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two adjacent squares, followed by a triangle.
    const FACES: [FaceCorners; 3] = [
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
        [[2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0], [2.0, 1.0, 0.0]],
    ];

    #[test]
    fn points_find_the_face_they_are_nearest_to() {
        let points = [
            [0.25, 0.5, 0.1],
            [1.0, 0.5, -0.1],
            [2.25, 0.25, 0.0],
            [0.5, 0.5, 0.3],
            [-0.06, 0.5, 0.0],
            [-0.08, 0.5, 0.0],
        ];
        let found = feet(&FACES, &points, |_| 0.2, |_, _| 0.2);
        let one = found[0].unwrap();
        assert_eq!((one.face, one.point), (0, [0.25, 0.5, 0.0]));
        assert!(
            one.shape.iter().zip([0.375, 0.125, 0.125, 0.375]).all(|(a, b)| (a - b).abs() < 1e-15),
            "{one:?}"
        );
        assert_eq!(found[1].map(|f| f.face), Some(0), "the first of two faces");
        assert_eq!(found[2].map(|f| (f.face, f.shape)), Some((2, [0.5, 0.25, 0.25, 0.0])));
        assert_eq!(found[3], None, "too far off");
        let outside = found[4].unwrap();
        assert_eq!(
            (outside.point, outside.shape),
            ([0.0, 0.5, 0.0], [0.5, 0.0, 0.0, 0.5]),
            "the tolerance is a twentieth of the diagonal, 0.07"
        );
        assert_eq!(found[5], None, "beyond the tolerance");
    }
}
