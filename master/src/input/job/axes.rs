//! Axes of three nodes, for histories that are written in them.

use nalgebra::{Matrix3, Vector3};

/// Sine of the least angle between the sides of axes: far above the round-off of coordinates.
const FLAT: f64 = 1e-6;

/// Axes of three nodes: columns are the unit vectors x, y and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeAxes(Matrix3<f64>);

impl NodeAxes {
    /// Returns the axes of nodes at these coordinates [length]: x from the first to the second, z
    /// perpendicular to it and to the line from the first to the third; `None` if they are on one
    /// line.
    pub fn new(places: [[f64; 3]; 3]) -> Option<Self> {
        let [first, second, third] = places.map(Vector3::from);
        let (along, other) = (second - first, third - first);
        let normal = along.cross(&other);
        // False for NaN too.
        let spans = normal.norm() > FLAT * along.norm() * other.norm();
        spans.then(|| {
            let (x, z) = (along.normalize(), normal.normalize());
            Self(Matrix3::from_columns(&[x, z.cross(&x), z]))
        })
    }

    /// Returns a global vector in these axes.
    pub fn of(&self, vector: [f64; 3]) -> [f64; 3] {
        self.0.tr_mul(&Vector3::from(vector)).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The second axis completes a right-handed system; nodes on one line have no axes.
    #[test]
    fn axes_are_those_of_the_nodes() {
        let axes = NodeAxes::new([[1.0; 3], [1.0, 3.0, 1.0], [1.0, 2.0, 5.0]]).unwrap();
        assert_eq!(axes.of([2.0, 3.0, 5.0]), [3.0, 5.0, 2.0]);
        assert_eq!(NodeAxes::new([[0.0; 3], [1.0; 3], [2.0; 3]]), None);
        assert_eq!(NodeAxes::new([[0.0; 3], [0.0; 3], [2.0; 3]]), None);
        assert_eq!(NodeAxes::new([[f64::NAN; 3], [0.0; 3], [2.0, 1.0, 0.0]]), None);
    }
}
