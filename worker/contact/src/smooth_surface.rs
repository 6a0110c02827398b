//! Smooth contact surface: over each segment a curved patch through its corners, whose normals
//! are common to the segments around a node. A node that slides over a curved body then meets
//! neither the corners of its mesh nor a jump of the normal.
//!
//! 1. The normal at a corner is the mean over the segments around it, with the weights of Max
//!    (1999). Segments at an angle of more than [`SMOOTH`] to [`SHARP`] count less and less, so
//!    that corners of a body stay sharp.
//! 2. Each side of a segment is a parabola, as in Nagata (2005). It rises along the mean normal of
//!    both ends only: Nagata's other part is large where the normals are almost parallel and the
//!    side is not at a right angle to them. The middle of the parabola is that of a circular arc.
//! 3. With the shape values N, the rise b of the four sides and the corners x, the patch is
//!    `x(N) = sum N_k x_k + sum N_i N_j/(N_i + N_j) b_ij` (quads), `sum N_i N_j b_ij` (triangles),
//!    and its normal is the direction of `sum N_k n_k`. Adjacent patches agree in both where all
//!    segments around the ends of their side are within 45 degrees of each other.
//!
//! The force acts at the point of the patch, with the shape values of the mesh. Their points
//! differ by the rise, mostly along the force.

use crate::geometry::{Nearest, nearest};
use crate::surface::{Segment, Surface};
use crumple_fem::nodes::Nodes;
use crumple_math::row::{Row, V3};

/// Cosine of the angle between segments up to which the surface is smooth: 45 degrees.
const SMOOTH: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Cosine of the angle from which on their common edge is sharp: 60 degrees.
const SHARP: f64 = 0.5;
/// Largest rise of a side over the chord, as a fraction of its length: an arc of 62 degrees. A side
/// that has been stretched rises no more than the longest one of the surface at the start.
const MOST: f64 = 0.15;
/// Number of times that the projection onto the patch is improved. The error falls each time by
/// about the distance over the radius of curvature.
const ITERATIONS: usize = 3;

/// Curved patch over a segment.
pub struct SmoothPatch {
    corners: [V3; 4],
    normals: [V3; 4],
    /// Per side from its first corner: four times the vector from the middle of the chord to that
    /// of the parabola [length].
    rises: [V3; 4],
    is_triangle: bool,
}

impl SmoothPatch {
    /// Builds the patch over a quad or triangle. Returns `None` for one without area.
    pub fn new(nodes: &Nodes, surface: &Surface, segment: &Segment) -> Option<Self> {
        let corners = segment.corners(&nodes.x);
        let own = segment.middle_normal(&nodes.x)?;
        let is_triangle = segment.is_triangle();
        let normal = |k: usize| {
            let sum = surface.normal_at(segment.nodes[k], (segment, &own), &nodes.x);
            sum.try_normalize(0.0).unwrap_or(own)
        };
        let mut normals = [own; 4];
        let count = if is_triangle { 3 } else { 4 };
        normals.iter_mut().enumerate().take(count).for_each(|(k, n)| *n = normal(k));
        let mut rises = [V3::zeros(); 4];
        for (k, rise) in rises.iter_mut().enumerate().take(count) {
            let next = (k + 1) % count;
            let side = corners[next] - corners[k];
            let most = MOST * side.norm().min(surface.longest_side);
            *rise = rise_of(&side, [&normals[k], &normals[next]]).cap_magnitude(4.0 * most);
        }
        Some(Self { corners, normals, rises, is_triangle })
    }

    /// Returns the vector from the point of the segment with these shape values to that of the
    /// patch [length].
    fn rise(&self, n: &[f64; 4]) -> V3 {
        if self.is_triangle {
            let [a, b, c, _] = *n;
            return self.rises[0] * (a * b) + self.rises[1] * (b * c) + self.rises[2] * (c * a);
        }
        let of_side = |k: usize| {
            let (a, b) = (n[k], n[(k + 1) % 4]);
            if a + b > 0.0 { self.rises[k] * (a * b / (a + b)) } else { V3::zeros() }
        };
        of_side(0) + of_side(1) + of_side(2) + of_side(3)
    }

    /// Returns the point and the unit normal of the patch at these shape values.
    fn point(&self, n: &[f64; 4]) -> Option<(V3, V3)> {
        let blend = |of: &[V3; 4]| of.iter().zip(n).map(|(v, n)| v * *n).sum::<V3>();
        Some((blend(&self.corners) + self.rise(n), blend(&self.normals).try_normalize(0.0)?))
    }

    /// Returns the point of the patch from which `at` lies along the normal, or the nearest one on
    /// its rim. `start` are shape values to begin with. Returns `None` where normals of the
    /// corners cancel.
    pub fn project(&self, at: &V3, start: [f64; 4]) -> Option<Nearest> {
        let mut shape = start;
        let mut rim = false;
        for _ in 0..ITERATIONS {
            let (point, normal) = self.point(&shape)?;
            let height = (at - point).dot(&normal);
            let below = at - normal * height - self.rise(&shape);
            let near = nearest(&below, &self.corners, self.is_triangle)?;
            (shape, rim) = (near.shape, near.rim);
        }
        let (point, normal) = self.point(&shape)?;
        Some(Nearest { shape, point, normal, rim })
    }
}

/// Returns four times the vector from the middle of a side, given as a vector, to the middle of
/// the arc that turns by the angle between the normals at its ends [length].
fn rise_of(side: &V3, [from, to]: [&V3; 2]) -> V3 {
    let sum = from + to;
    let length = sum.norm(); // twice the cosine of half the angle
    if length == 0.0 {
        return V3::zeros();
    }
    sum * ((to - from).dot(side) / (length * (1.0 + 0.5 * length)))
}

/// Returns the weight of a segment at this cosine of the angle to another one.
fn weight(cosine: f64) -> f64 {
    let t = ((cosine - SHARP) / (SMOOTH - SHARP)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl Surface {
    /// Returns the largest distance between a segment and its patch [length]; 0 if the surface is
    /// flat. In the middle of a quad the rises of both directions add up.
    pub fn largest_rise(&self) -> f64 {
        2.0 * MOST * self.longest_side
    }

    /// Returns the distance beyond a segment within which its patch may depend on other segments,
    /// and rise, also where solids that are hidden now come to the surface [length]; 0 if the
    /// surface is flat.
    pub fn patch_reach(&self) -> f64 {
        (1.0 + 2.0 * MOST) * self.diameter
    }

    /// Collects the segments around each of `count` nodes.
    pub fn link_nodes(&mut self, count: usize) {
        let mut around: Vec<(u32, u32)> = Vec::new();
        for (g, s) in self.segments.iter().enumerate().filter(|(_, s)| !s.is_line()) {
            let corners = if s.is_triangle() { 3 } else { 4 };
            around.extend(s.nodes[..corners].iter().map(|&n| (n, g as u32)));
        }
        around.sort_unstable();
        self.node_face_start = vec![0; count + 1];
        around.iter().for_each(|&(n, _)| self.node_face_start[n as usize + 1] += 1);
        for n in 0..count {
            self.node_face_start[n + 1] += self.node_face_start[n];
        }
        self.node_faces = around.into_iter().map(|(_, g)| g).collect();
    }

    /// Returns the normal of the smooth surface at a node of a segment with this normal at its
    /// middle, not of unit length. The segments are taken in ascending id, so that the sum has the
    /// same bits on each worker.
    fn normal_at(&self, node: u32, (segment, own): (&Segment, &V3), x: &[Row]) -> V3 {
        let run = self.node_face_start[node as usize]..self.node_face_start[node as usize + 1];
        let around = self.node_faces[run.start as usize..run.end as usize].iter();
        let mut sum = V3::zeros();
        for other in around.map(|&g| &self.segments[g as usize]) {
            let Some(middle) = other.middle_normal(x) else { continue };
            let cosine = middle.dot(own);
            // Shells side by side may be numbered in opposite senses.
            let is_turned = cosine < 0.0 && !other.is_solid();
            let sense = if is_turned { -1.0 } else { 1.0 };
            let weight = weight(sense * cosine);
            if weight > 0.0 && other.is_solid() == segment.is_solid() {
                sum += other.corner_vector(node, x) * (sense * weight);
            }
        }
        sum
    }
}

impl Segment {
    /// Returns the normal at one of its nodes, with the weight of Max (1999): the cross product of
    /// the two sides over the squares of their lengths. It is exact on a sphere.
    fn corner_vector(&self, node: u32, x: &[Row]) -> V3 {
        let count = if self.is_triangle() { 3 } else { 4 };
        let q = self.corners(x);
        let Some(k) = self.nodes.iter().position(|&n| n == node) else { return V3::zeros() };
        let (ahead, behind) = (q[(k + 1) % count] - q[k], q[(k + count - 1) % count] - q[k]);
        let squares = ahead.norm_squared() * behind.norm_squared();
        if squares > 0.0 { ahead.cross(&behind) / squares } else { V3::zeros() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::NOT_LOCAL;
    use crumple_fem::testing::nodes_at;
    use crumple_proto::ids::SegmentId;

    /// Angle of a quad on the cylinder.
    const STEP: f64 = 0.2;

    /// Returns nine quads on a cylinder of radius 1 with nodes turned by `turn`, as faces of a
    /// solid, and the middle one. Every other quad of shells is numbered in the other sense.
    fn cylinder(turn: f64, half_thickness: f64) -> (Nodes, Surface, Segment) {
        let at = |k: usize| {
            let (i, j) = ((k % 4) as f64 - 1.5, (k / 4) as f64 - 1.5);
            let (y, x) = (STEP * i + turn * j).sin_cos();
            [x, y, 0.3 * j]
        };
        let nodes = nodes_at(&(0..16).map(at).collect::<Vec<_>>());
        let quad = |e: u32| {
            let a = e % 3 + 4 * (e / 3);
            let mut nodes = [a, a + 1, a + 5, a + 4];
            if half_thickness > 0.0 && e % 2 == 1 {
                nodes.reverse();
            }
            Segment {
                id: SegmentId(u64::from(8 * e)),
                nodes,
                behind: [NOT_LOCAL; 4],
                half_thickness,
                offset: 0.0,
                scale: 0.1,
                part: 0,
                own: true,
                searched: true,
            }
        };
        let segments = (0..9).map(quad).collect();
        let mut surface = Surface { segments, longest_side: 0.3, ..Surface::default() };
        surface.link_nodes(nodes.len());
        let middle = surface.segments[4];
        (nodes, surface, middle)
    }

    /// On a cylinder the patch is a tenth as far from the circle as the chord, or nearer, and its
    /// normals point away from the axis. The sense of numbering of shells does not matter.
    #[test]
    fn a_patch_follows_a_cylinder() {
        let chord = 1.0 - (0.5 * STEP).cos();
        for half_thickness in [0.0, 0.05] {
            let (nodes, surface, middle) = cylinder(0.0, half_thickness);
            let patch = SmoothPatch::new(&nodes, &surface, &middle).unwrap();
            for k in 0..=10 {
                let u = 0.1 * f64::from(k);
                let shape = [0.7 * (1.0 - u), 0.7 * u, 0.3 * u, 0.3 * (1.0 - u)];
                let (point, normal) = patch.point(&shape).unwrap();
                let radius = point.x.hypot(point.y);
                assert!((radius - 1.0).abs() < 1e-3 * chord, "{u}: {}", (radius - 1.0) / chord);
                let outward = V3::new(point.x, point.y, 0.0) / radius;
                assert!(normal.dot(&outward) > 1.0 - 1e-7, "{u}: {normal}");
            }
        }
    }

    /// The projection of a point lies on its radius, wherever the point is and however the mesh is
    /// turned on the cylinder.
    #[test]
    fn points_project_along_the_normal_of_the_patch() {
        for turn in [0.0, 0.1] {
            let (nodes, surface, middle) = cylinder(turn, 0.0);
            let patch = SmoothPatch::new(&nodes, &surface, &middle).unwrap();
            for (angle, height) in [(0.0, 0.1), (0.05, 0.05), (-0.06, -0.04), (0.02, 0.0)] {
                let (y, x) = f64::sin_cos(angle);
                let at = V3::new(x, y, 0.02) * (1.0 + height) - V3::z() * (0.02 * height);
                let found = patch.project(&at, [0.25; 4]).unwrap();
                let apart = at - found.point;
                assert!((apart.dot(&found.normal) - height).abs() < 2e-5, "{turn} {angle}");
                let across = (apart - found.normal * apart.dot(&found.normal)).norm();
                assert!(across < 1e-5, "{turn} {angle} {height}: {across}");
                assert!(!found.rim);
            }
        }
    }

    /// Two patches have the same points and normals along their common side.
    #[test]
    fn adjacent_patches_agree_along_their_side() {
        let (nodes, surface, middle) = cylinder(0.1, 0.0);
        let patch = SmoothPatch::new(&nodes, &surface, &middle).unwrap();
        let next = SmoothPatch::new(&nodes, &surface, &surface.segments[5]).unwrap();
        for k in 0..=4 {
            let u = 0.25 * f64::from(k);
            // Corners 1 and 2 of the one are 0 and 3 of the other.
            let (a, n) = patch.point(&[0.0, 1.0 - u, u, 0.0]).unwrap();
            let (b, m) = next.point(&[1.0 - u, 0.0, 0.0, u]).unwrap();
            assert!((a - b).norm() < 1e-15 && (n - m).norm() < 1e-15, "{u}");
        }
    }

    /// The faces of a cube stay flat: its edges are sharp.
    #[test]
    fn right_angles_stay_sharp() {
        let nodes = nodes_at(&[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, -1.0],
            [1.0, 0.0, -1.0],
        ]);
        let face = |(id, nodes): (u64, [u32; 4])| Segment {
            id: SegmentId(id),
            nodes,
            behind: [NOT_LOCAL; 4],
            half_thickness: 0.0,
            offset: 0.0,
            scale: 0.25,
            part: 0,
            own: true,
            searched: true,
        };
        let faces = [(8, [0, 1, 2, 3]), (16, [0, 4, 5, 1])].map(face);
        let mut surface =
            Surface { segments: faces.into(), longest_side: 1.0, ..Surface::default() };
        surface.link_nodes(nodes.len());
        let patch = SmoothPatch::new(&nodes, &surface, &faces[0]).unwrap();
        assert!(patch.normals.iter().all(|n| *n == V3::z()));
        assert!(patch.rises.iter().all(|r| *r == V3::zeros()));
    }
}
