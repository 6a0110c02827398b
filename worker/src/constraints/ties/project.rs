//! Where nodes stand on a surface, before the start.

use crate::contact::geometry::{V3, nearest};
use crate::contact::search::linked_cells;
use crumple_proto::boxes::Aabb;

/// How far beyond the rim of a face a node may be, along the face, as a fraction of its shorter
/// diagonal: surfaces that curve gape between their faces.
const BESIDE: f64 = 0.05;

/// A face: its corners, of a triangle the third one twice [length].
pub type Face = [[f64; 3]; 4];

/// Where a point stands on a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Number of the face.
    pub face: usize,
    /// Shape values at its corners, none below 0; they sum to 1.
    pub shape: [f64; 4],
    /// The point of the face that is nearest [length].
    pub point: [f64; 3],
    /// How far that is [length].
    pub distance: f64,
}

/// The shorter diagonal of a face, of a triangle its shortest side [length].
pub fn diagonal(face: &Face) -> f64 {
    let between = |a: usize, b: usize| (V3::from(face[a]) - V3::from(face[b])).norm();
    if face[2] == face[3] {
        between(0, 1).min(between(1, 2)).min(between(2, 0))
    } else {
        between(0, 2).min(between(1, 3))
    }
}

/// The nearest face of each point that is within the tolerance for the two, the first one of
/// equals; `tolerance` is given a face and a point by their numbers, and nought where they may not
/// meet. `widest` is the largest of a face's tolerances.
pub fn feet(
    faces: &[Face],
    points: &[[f64; 3]],
    widest: impl Fn(usize) -> f64,
    tolerance: impl Fn(usize, usize) -> f64,
) -> Vec<Option<Foot>> {
    let grown = |(f, face): (usize, &Face)| Aabb::around(face.iter().copied()).grown(widest(f));
    let boxes: Vec<Aabb> = faces.iter().enumerate().map(grown).collect();
    let mut feet: Vec<Option<Foot>> = vec![None; points.len()];
    linked_cells(&boxes, points, &mut |f, p| {
        let (f, p) = (f as usize, p as usize);
        let (corners, at) = (faces[f].map(V3::from), V3::from(points[p]));
        let Some(near) = nearest(&at, &corners, faces[f][2] == faces[f][3]) else { return };
        let off = at - near.point;
        let beside = off - near.normal * near.normal.dot(&off);
        let distance = off.norm();
        let reached = distance <= tolerance(f, p) && beside.norm() <= BESIDE * diagonal(&faces[f]);
        if reached && feet[p].is_none_or(|old| distance < old.distance) {
            feet[p] = Some(Foot { face: f, shape: near.shape, point: near.point.into(), distance });
        }
    });
    feet
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares side by side, and a triangle beyond them.
    const FACES: [Face; 3] = [
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
        assert_eq!(found[1].map(|f| f.face), Some(0), "the first of two");
        assert_eq!(found[2].map(|f| (f.face, f.shape)), Some((2, [0.5, 0.25, 0.25, 0.0])));
        assert_eq!(found[3], None, "too far off");
        let beside = found[4].unwrap();
        assert_eq!(
            (beside.point, beside.shape),
            ([0.0, 0.5, 0.0], [0.5, 0.0, 0.0, 0.5]),
            "a twentieth of the diagonal is 0.07"
        );
        assert_eq!(found[5], None, "and not beyond");
    }
}
