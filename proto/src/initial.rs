//! Stress and plastic strain that elements have at the start.

use crate::ids::ElemId;
use serde::{Deserialize, Serialize};

/// State of a point of an element at the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InitialPoint {
    /// The element.
    pub element: ElemId,
    /// Number of the point in the plane of a shell, or of the point of a solid, from 1.
    pub number: u32,
    /// Place through the thickness of a shell, over half the thickness: -1 at the inner surface, 1
    /// at the outer one.
    pub position: f64,
    /// Global stress xx, yy, zz, xy, yz, zx [force/length^2].
    pub stress: [f64; 6],
    /// Effective plastic strain.
    pub plastic_strain: f64,
}

impl InitialPoint {
    /// Creates one from a row of a job, apart from its element and number.
    pub fn of_row(element: ElemId, number: u32, row: &[f64; 10]) -> Self {
        let [_, _, position, xx, yy, zz, xy, yz, zx, plastic_strain] = *row;
        Self { element, number, position, stress: [xx, yy, zz, xy, yz, zx], plastic_strain }
    }

    /// Returns true if neither stress nor plastic strain is there.
    pub fn is_zero(&self) -> bool {
        self.stress == [0.0; 6] && self.plastic_strain == 0.0
    }
}

/// Sorts points by element, number and position.
pub fn sort(points: &mut [InitialPoint]) {
    points.sort_by(|a, b| {
        (a.element, a.number).cmp(&(b.element, b.number)).then(a.position.total_cmp(&b.position))
    });
}

/// Returns the points of an element among sorted ones.
pub fn of_element(points: &[InitialPoint], element: ElemId) -> &[InitialPoint] {
    let first = points.partition_point(|p| p.element < element);
    let count = points[first..].iter().take_while(|p| p.element == element).count();
    &points[first..first + count]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_an_element_are_found() {
        let row = |position: f64| [0.0, 0.0, position, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5];
        let of = |id, number, position| InitialPoint::of_row(ElemId(id), number, &row(position));
        let mut points =
            vec![of(7, 1, 0.0), of(3, 2, 0.0), of(3, 1, 0.5), of(3, 1, -0.5), of(9, 1, 0.0)];
        sort(&mut points);
        let found = of_element(&points, ElemId(3));
        let places: Vec<_> = found.iter().map(|p| (p.number, p.position)).collect();
        assert_eq!(places, [(1, -0.5), (1, 0.5), (2, 0.0)]);
        assert_eq!(of_element(&points, ElemId(9)).len(), 1);
        assert!(of_element(&points, ElemId(5)).is_empty());
    }
}
