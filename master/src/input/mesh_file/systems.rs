//! Coordinate systems of nodes in mesh files.

use crate::input::deck::{Affine, sine_cosine};

/// Kind of the coordinates of a system, with angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoordinateKind {
    /// x, y, z.
    Rectangular,
    /// Distance from the z axis, angle from the x axis, z.
    Cylindrical,
    /// Distance from the origin, angle from the z axis, angle about it from the x axis.
    Spherical,
}

impl CoordinateKind {
    /// Returns the rectangular coordinates of a point [length].
    pub fn rectangular(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        match self {
            CoordinateKind::Rectangular => [a, b, c],
            CoordinateKind::Cylindrical => {
                let (sine, cosine) = sine_cosine(b);
                [a * cosine, a * sine, c]
            }
            CoordinateKind::Spherical => {
                let ((sine, cosine), (sine_about, cosine_about)) = (sine_cosine(b), sine_cosine(c));
                [a * sine * cosine_about, a * sine * sine_about, a * cosine]
            }
        }
    }
}

/// A coordinate system of nodes.
#[derive(Clone, Copy, Debug)]
pub struct NodeSystem {
    kind: CoordinateKind,
    /// Map of its rectangular coordinates to those of the mesh.
    axes: Affine,
}

impl NodeSystem {
    /// The system of the mesh.
    pub fn basic() -> Self {
        NodeSystem { kind: CoordinateKind::Rectangular, axes: Affine::default() }
    }

    /// Creates it from its origin, a point on the z axis and one in the half plane of z and
    /// positive x [length]; `None` if they are on one line.
    pub fn with_z(kind: CoordinateKind, [a, b, c]: [[f64; 3]; 3]) -> Option<Self> {
        let own = [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        Some(NodeSystem { kind, axes: between(own, [a, b, c])? })
    }

    /// Returns a point with these coordinates, in those of the mesh [length].
    pub fn point(&self, coordinates: [f64; 3]) -> [f64; 3] {
        self.axes.point(self.kind.rectangular(coordinates))
    }

    /// Returns a vector with these components at a point of the mesh. On the z axis of a
    /// cylindrical or spherical system, they are those of the angle 0.
    pub fn direction(&self, at: [f64; 3], components: [f64; 3]) -> [f64; 3] {
        let origin = self.axes.point([0.0; 3]);
        let from: [f64; 3] = std::array::from_fn(|c| at[c] - origin[c]);
        let along = |axis: [f64; 3]| dot(self.axes.direction(axis), from);
        let (x, y) = (along([1.0, 0.0, 0.0]), along([0.0, 1.0, 0.0]));
        let z = along([0.0, 0.0, 1.0]);
        let across = x.hypot(y);
        let (sine_about, cosine_about) =
            if across > 0.0 { (y / across, x / across) } else { (0.0, 1.0) };
        let [a, b, c] = components;
        let own = match self.kind {
            CoordinateKind::Rectangular => components,
            CoordinateKind::Cylindrical => {
                [a * cosine_about - b * sine_about, a * sine_about + b * cosine_about, c]
            }
            CoordinateKind::Spherical => {
                let radius = across.hypot(z);
                let (sine, cosine) =
                    if radius > 0.0 { (across / radius, z / radius) } else { (0.0, 1.0) };
                let outward = a * sine + b * cosine;
                [
                    outward * cosine_about - c * sine_about,
                    outward * sine_about + c * cosine_about,
                    a * cosine - b * sine,
                ]
            }
        };
        self.axes.direction(own)
    }
}

/// Least sine of the angle between two lines that give a plane.
const LEAST_SINE: f64 = 1e-9;

/// Returns the rigid motion that takes the first point of a triangle to that of the other, the line
/// to the second point to that of the other, and their planes to each other; `None` if the points
/// of the other are on one line.
pub fn between(from: [[f64; 3]; 3], to: [[f64; 3]; 3]) -> Option<Affine> {
    let [a, b, c] = to;
    let side = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| p[k] - a[k]) };
    let (u, v) = (side(b), side(c));
    let n = cross(u, v);
    // Also false for a length that is no number.
    let is_plane = dot(n, n) > LEAST_SINE * LEAST_SINE * dot(u, u) * dot(v, v);
    let [p, q, r] = from;
    Affine::between([p, q, r, a, b, c]).filter(|_| is_plane)
}

/// Returns the scalar product of two vectors.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the vector product of two vectors.
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: [f64; 3], wanted: [f64; 3]) {
        let apart = (0..3).map(|c| (found[c] - wanted[c]).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-14, "{found:?}, not {wanted:?}");
    }

    /// Origin (1, 0, 0), z along the y axis of the mesh, x along its z axis; so y is along its x
    /// axis. Right angles are exact; other numbers are those of 30 and 60 degrees.
    #[test]
    fn coordinates_follow_the_axes_and_angles_of_their_system() {
        let points = [[1.0, 0.0, 0.0], [1.0, 5.0, 0.0], [1.0, 7.0, 2.0]];
        let system = |kind| NodeSystem::with_z(kind, points).unwrap();
        let own = [2.0, 3.0, 4.0];
        assert_eq!(system(CoordinateKind::Rectangular).point(own), [4.0, 4.0, 2.0]);
        // x = 2 cos 90 = 0, y = 2 sin 90 = 2, z = 4.
        assert_eq!(system(CoordinateKind::Cylindrical).point([2.0, 90.0, 4.0]), [3.0, 4.0, 0.0]);
        // 30 degrees from z, then 60 degrees about it: x = 2 (1/2)(1/2), y = 2 (1/2)(r3/2).
        let r3 = 3.0_f64.sqrt();
        let found = system(CoordinateKind::Spherical).point([2.0, 30.0, 60.0]);
        close(found, [1.0 + 0.5 * r3, r3, 0.5]);
    }

    /// At x = 3, y = 4, z = 0 of a cylinder the radial direction is (3, 4, 0)/5, that of the angle
    /// (-4, 3, 0)/5. On a sphere at (3, 4, 12), 13 from the origin, the direction of the first
    /// angle is (cos a cos b, cos a sin b, -sin a) with sin a = 5/13, cos a = 12/13.
    #[test]
    fn directions_are_those_at_their_point() {
        let points = [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        let system = |kind| NodeSystem::with_z(kind, points).unwrap();
        let cylinder = system(CoordinateKind::Cylindrical);
        let at = [3.0, 4.0, 0.0];
        close(cylinder.direction(at, [1.0, 0.0, 0.0]), [0.6, 0.8, 0.0]);
        close(cylinder.direction(at, [0.0, 1.0, 2.0]), [-0.8, 0.6, 2.0]);
        close(cylinder.direction([0.0, 0.0, 9.0], [1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
        let sphere = system(CoordinateKind::Spherical);
        let at = [3.0, 4.0, 12.0];
        close(sphere.direction(at, [13.0, 0.0, 0.0]), at);
        close(sphere.direction(at, [0.0, 65.0, 0.0]), [36.0, 48.0, -25.0]);
        close(sphere.direction(at, [0.0, 0.0, 5.0]), [-4.0, 3.0, 0.0]);
    }

    /// Points on one line give no system, also with digits that differ by rounding.
    #[test]
    fn points_on_a_line_give_no_system() {
        let line = [0.1, 0.2, 0.3].map(|x: f64| [x, 3.0 * x, 7.0 * x]);
        assert!(NodeSystem::with_z(CoordinateKind::Rectangular, line).is_none());
        let twice = [[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0]];
        assert!(NodeSystem::with_z(CoordinateKind::Rectangular, twice).is_none());
    }
}
