//! Shape quality of the elements of a mesh: pure geometry, for `crumple check` and for the
//! tests of generators.

use crate::ids::{ElemId, NodeId};
use crate::mesh::{EDGES_OF_TET10, MAX_CORNERS, Mesh, MeshElement, Shape, once_each};
use std::collections::HashMap;

type Coordinates = [f64; 3];

/// Extreme value and the element in which it occurs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// The value, in the unit of the field that holds it.
    pub value: f64,
    /// The element; of several with the same value the one with the lowest id.
    pub element: ElemId,
}

/// Quality of the elements of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Shortest side [length].
    pub min_side: Worst,
    /// Median of all sides; a side counts once per element that has it [length].
    pub median_side: f64,
    /// Longest side [length].
    pub max_side: Worst,
    /// Largest ratio of longest to shortest side of an element; 1 is best.
    pub max_aspect: Worst,
    /// Largest warpage of a quad or of a solid's face: angle between the normals of the two
    /// halves on either side of a diagonal [degree].
    pub max_warpage_deg: Worst,
    /// Smallest ratio of the smallest to the largest Jacobian at an element's corners: 1 for a
    /// parallelogram, 0 for a quad that has degenerated to a triangle, negative for a concave
    /// or folded one.
    pub min_jacobian: Worst,
    /// Largest skew of a shell or of a solid's face, see [`ElementQuality::skew_deg`] [degree].
    pub max_skew_deg: Worst,
    /// Smallest area of a shell or of a solid's face [length^2].
    pub min_area: Worst,
    /// Elements whose area or volume is zero to round-off, or that contain a node twice; a run
    /// cannot start with them.
    pub zero_area: Vec<ElemId>,
    /// Elements with a node that is not in the mesh; all other values exclude them.
    pub dangling: Vec<ElemId>,
}

/// Shape quality of one element.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementQuality {
    /// Lengths of its sides [length].
    pub sides: Vec<f64>,
    /// Longest over shortest side; 1 is best.
    pub aspect: f64,
    /// Warpage of a quad, or of the worst face of a solid [degree]; 0 is best.
    pub warpage_deg: f64,
    /// Smallest over largest Jacobian at the corners; 1 is best.
    pub jacobian: f64,
    /// Skew, of the worst face of a solid [degree]; 0 is best. For a quad: 90 degrees minus the
    /// angle between the lines through the middles of opposite sides. For a triangle: 90 degrees
    /// minus the smallest angle between the line from a corner to the middle of the opposite side
    /// and the line through the middles of the other two sides.
    pub skew_deg: f64,
    /// Smallest area of a shell or of a solid's face, infinite for lines [length^2].
    pub area: f64,
    /// True if its area or volume is zero to round-off, or if it contains a node twice.
    pub is_degenerate: bool,
}

/// Measures all elements; returns `None` if no element has all its nodes in the mesh.
pub fn quality(mesh: &Mesh) -> Option<Quality> {
    let at: HashMap<NodeId, Coordinates> = mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
    let mut order: Vec<&MeshElement> = mesh.elements.iter().collect();
    order.sort_by_key(|e| e.id);

    let mut q: Option<Quality> = None;
    let mut sides = Vec::new();
    let (mut zero_area, mut dangling) = (Vec::new(), Vec::new());
    for element in order {
        let corners: Option<Vec<Coordinates>> =
            element.corners().iter().map(|id| at.get(id).copied()).collect();
        let Some(corners) = corners else {
            dangling.push(element.id);
            continue;
        };
        let f = measure(element, &corners);
        if f.is_degenerate {
            zero_area.push(element.id);
        }
        let here = |value| Worst { value, element: element.id };
        let shortest = f.sides.iter().copied().fold(f64::INFINITY, f64::min);
        let longest = f.sides.iter().copied().fold(0.0, f64::max);
        let q = q.get_or_insert_with(|| Quality {
            min_side: here(f64::INFINITY),
            median_side: 0.0,
            max_side: here(0.0),
            max_aspect: here(0.0),
            max_warpage_deg: here(0.0),
            min_jacobian: here(f64::INFINITY),
            max_skew_deg: here(0.0),
            min_area: here(f64::INFINITY),
            zero_area: Vec::new(),
            dangling: Vec::new(),
        });
        for (worst, value) in [
            (&mut q.min_side, shortest),
            (&mut q.min_jacobian, f.jacobian),
            (&mut q.min_area, f.area),
        ] {
            if value < worst.value {
                *worst = here(value);
            }
        }
        for (worst, value) in [
            (&mut q.max_side, longest),
            (&mut q.max_aspect, f.aspect),
            (&mut q.max_warpage_deg, f.warpage_deg),
            (&mut q.max_skew_deg, f.skew_deg),
        ] {
            if value > worst.value {
                *worst = here(value);
            }
        }
        sides.extend(f.sides);
    }
    let mut q = q?;
    if sides.is_empty() {
        // There are only particles and springs of zero length.
        (sides, q.min_side.value) = (vec![0.0], 0.0);
    }
    let middle = sides.len() / 2;
    q.median_side = *sides.select_nth_unstable_by(middle, f64::total_cmp).1;
    q.zero_area = zero_area;
    q.dangling = dangling;
    Some(q)
}

/// Measures an element whose corners have the coordinates `x` [length].
pub fn measure(element: &MeshElement, x: &[Coordinates]) -> ElementQuality {
    match element.shape {
        Shape::Hex8 | Shape::Tet4 | Shape::Wedge6 | Shape::Tet10 => measure_solid(element, x),
        Shape::Quad4 | Shape::Tri3 => measure_face(element.corners(), x),
        Shape::Line2 | Shape::Beam2 | Shape::Truss2 => measure_line(x),
        Shape::Point1 => measure_line(&[x[0], x[0]]),
        // Its thickness may be zero.
        Shape::Cohesive8 => measure_face(&element.nodes[..4], &middle(x)),
    }
}

/// Returns the Jacobians at the corners of an element with the coordinates `x`: of a solid
/// [length^3], of a shell along the normal of its middle [length^2]. They are 0 for lines, and for
/// corners that the shape does not have. Those of a ten-node tetrahedron are at all its nodes.
pub fn corner_jacobians(shape: Shape, x: &[Coordinates]) -> [f64; MAX_CORNERS] {
    let mut jacobians = [0.0; MAX_CORNERS];
    match shape {
        Shape::Hex8 => (0..8).for_each(|c| jacobians[c] = solid_jacobian::<4>(c, x)),
        Shape::Wedge6 => (0..6).for_each(|c| jacobians[c] = solid_jacobian::<3>(c, x)),
        Shape::Tet4 => {
            let [a, b, d] = [1, 2, 3].map(|c| sub(x[c], x[0]));
            jacobians[..4].fill(dot(cross(a, b), d));
        }
        Shape::Tet10 => (0..MAX_CORNERS).for_each(|c| jacobians[c] = quadratic_jacobian(c, x)),
        Shape::Quad4 | Shape::Tri3 => {
            let x = &x[..shape.corners()];
            let twice = twice_area(x);
            let length = norm(twice);
            if length > 0.0 {
                (0..x.len()).for_each(|c| jacobians[c] = dot(corner(c, x), twice) / length);
            }
        }
        Shape::Line2 | Shape::Beam2 | Shape::Truss2 | Shape::Point1 | Shape::Cohesive8 => {}
    }
    jacobians
}

/// Returns the middle surface of a cohesive element between its nodes `x` [length].
pub fn middle(x: &[Coordinates]) -> [Coordinates; 4] {
    std::array::from_fn(|c| std::array::from_fn(|i| 0.5 * (x[c][i] + x[c + 4][i])))
}

/// Returns the Jacobian of a solid between two faces with N corners at a corner [length^3].
fn solid_jacobian<const N: usize>(c: usize, x: &[Coordinates]) -> f64 {
    let (base, other) = (c / N * N, N - c / N * N);
    let [next, before] = [1, N - 1].map(|step| base + (c % N + step) % N);
    let up = dot(cross(sub(x[next], x[c]), sub(x[before], x[c])), sub(x[other + c % N], x[c]));
    if base == 0 { up } else { -up }
}

/// Returns the Jacobian of a ten-node tetrahedron at a node [length^3].
fn quadratic_jacobian(node: usize, x: &[Coordinates]) -> f64 {
    // Volume coordinates of the node.
    let mut at = [0.0; 4];
    match node.checked_sub(4) {
        None => at[node] = 1.0,
        Some(edge) => EDGES_OF_TET10[edge].iter().for_each(|&c| at[c] = 0.5),
    }
    // Derivatives of the position by the volume coordinates.
    let mut by = [0, 1, 2, 3].map(|c| x[c].map(|x| (4.0 * at[c] - 1.0) * x));
    for ([a, b], x) in EDGES_OF_TET10.into_iter().zip(&x[4..]) {
        (0..3).for_each(|i| {
            by[a][i] += 4.0 * at[b] * x[i];
            by[b][i] += 4.0 * at[a] * x[i];
        });
    }
    let [a, b, c] = [1, 2, 3].map(|k| sub(by[k], by[0]));
    dot(cross(a, b), c)
}

/// Returns the cross product of the sides of a face at a corner [length^2].
fn corner(c: usize, x: &[Coordinates]) -> Coordinates {
    let n = x.len();
    cross(sub(x[(c + 1) % n], x[c]), sub(x[(c + n - 1) % n], x[c]))
}

/// Returns twice the area vector of a face: the cross product of the diagonals of a quad, or of two
/// sides of a triangle [length^2].
fn twice_area(x: &[Coordinates]) -> Coordinates {
    if x.len() == 4 {
        cross(sub(x[2], x[0]), sub(x[3], x[1]))
    } else {
        cross(sub(x[1], x[0]), sub(x[2], x[0]))
    }
}

/// Measures a line: only its length, unless it is zero, as of a particle.
fn measure_line(x: &[Coordinates]) -> ElementQuality {
    let length = norm(sub(x[1], x[0]));
    let sides = if length > 0.0 { vec![length] } else { Vec::new() };
    ElementQuality {
        sides,
        aspect: 1.0,
        warpage_deg: 0.0,
        jacobian: 1.0,
        skew_deg: 0.0,
        area: f64::INFINITY,
        is_degenerate: false,
    }
}

/// Measures a solid: its sides are its edges, its warpage and area those of its worst face, its
/// Jacobians those at its corners.
fn measure_solid(element: &MeshElement, x: &[Coordinates]) -> ElementQuality {
    let faces = element.shape.faces();
    let measured = faces.iter().map(|face| {
        let corners = once_each(face);
        let ids: Vec<NodeId> = corners.iter().map(|&c| element.nodes[c]).collect();
        let x: Vec<Coordinates> = corners.iter().map(|&c| x[c]).collect();
        measure_face(&ids, &x)
    });
    let measured: Vec<ElementQuality> = measured.collect();
    // Every edge is in two faces, once in each direction.
    let around = |face: &[usize; 4]| {
        let c = once_each(face).to_vec();
        (0..c.len()).map(move |i| (c[i], c[(i + 1) % c.len()]))
    };
    let edges = faces.iter().flat_map(around).filter(|(from, to)| from < to);
    let sides: Vec<f64> = edges.map(|(from, to)| norm(sub(x[to], x[from]))).collect();
    let longest = sides.iter().copied().fold(0.0, f64::max);
    let shortest = sides.iter().copied().fold(f64::INFINITY, f64::min);
    let jacobians = &corner_jacobians(element.shape, x)[..element.shape.corners()];
    let largest = jacobians.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smallest = jacobians.iter().copied().fold(f64::INFINITY, f64::min);
    let ids = element.corners();
    let repeats = (1..ids.len()).any(|i| ids[..i].contains(&ids[i]));
    ElementQuality {
        aspect: if shortest > 0.0 { longest / shortest } else { f64::INFINITY },
        warpage_deg: measured.iter().map(|f| f.warpage_deg).fold(0.0, f64::max),
        jacobian: if largest > 0.0 { smallest / largest } else { f64::NEG_INFINITY },
        skew_deg: measured.iter().map(|f| f.skew_deg).fold(0.0, f64::max),
        area: measured.iter().map(|f| f.area).fold(f64::INFINITY, f64::min),
        is_degenerate: repeats || largest <= 1e-12 * longest.powi(3),
        sides,
    }
}

fn measure_face(ids: &[NodeId], x: &[Coordinates]) -> ElementQuality {
    let n = x.len();
    let sides: Vec<f64> = (0..n).map(|i| norm(sub(x[(i + 1) % n], x[i]))).collect();
    let longest = sides.iter().copied().fold(0.0, f64::max);
    let shortest = sides.iter().copied().fold(f64::INFINITY, f64::min);
    let twice = twice_area(x);
    let area = 0.5 * norm(twice);
    let repeats = (1..n).any(|i| ids[..i].contains(&ids[i]));
    // 1e-12: about a thousand times the round-off of products of coordinates.
    let degenerate = repeats || area <= 1e-12 * longest * longest;
    let (jacobian, warpage_deg) = if n == 3 {
        (1.0, 0.0)
    } else if degenerate {
        (0.0, 0.0)
    } else {
        let j = [0, 1, 2, 3].map(|c| dot(corner(c, x), twice));
        let largest = j.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let smallest = j.into_iter().fold(f64::INFINITY, f64::min);
        // The halves on either side of diagonal 0-2 are at corners 1 and 3; those of 1-3 at 0
        // and 2.
        let warp = angle_deg(corner(1, x), corner(3, x)).max(angle_deg(corner(0, x), corner(2, x)));
        (smallest / largest, warp)
    };
    let aspect = if shortest > 0.0 { longest / shortest } else { f64::INFINITY };
    let skew_deg = if degenerate { 90.0 } else { skew_deg(x) };
    ElementQuality {
        sides,
        aspect,
        warpage_deg,
        jacobian,
        skew_deg,
        area,
        is_degenerate: degenerate,
    }
}

/// Returns the skew of a face with three or four corners [degree].
fn skew_deg(x: &[Coordinates]) -> f64 {
    let n = x.len();
    // Middles of the sides, times two.
    let middle = |i: usize| [0, 1, 2].map(|c| x[i % n][c] + x[(i + 1) % n][c]);
    let between = |a: Coordinates, b: Coordinates| {
        let angle = angle_deg(a, b);
        90.0 - angle.min(180.0 - angle)
    };
    if n == 4 {
        return between(sub(middle(2), middle(0)), sub(middle(3), middle(1)));
    }
    let of_corner = |c: usize| {
        let to_opposite = sub(middle(c + 1), x[c].map(|a| 2.0 * a));
        between(to_opposite, sub(middle(c + 2), middle(c)))
    };
    (0..3).map(of_corner).fold(0.0, f64::max)
}

fn sub(a: Coordinates, b: Coordinates) -> Coordinates {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Coordinates, b: Coordinates) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Coordinates, b: Coordinates) -> Coordinates {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn norm(a: Coordinates) -> f64 {
    dot(a, a).sqrt()
}

/// Returns the angle between two vectors [degree], accurate near zero too.
fn angle_deg(a: Coordinates, b: Coordinates) -> f64 {
    norm(cross(a, b)).atan2(dot(a, b)).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshNode;

    fn mesh(points: &[Coordinates], elements: &[(Shape, [u64; 4])]) -> Mesh {
        Mesh {
            nodes: points.iter().zip(1..).map(|(&x, id)| MeshNode { id: NodeId(id), x }).collect(),
            elements: elements
                .iter()
                .zip(1..)
                .map(|(&(shape, n), id)| MeshElement::new(ElemId(id), 1, shape, &n.map(NodeId)))
                .collect(),
            ..Mesh::default()
        }
    }

    #[test]
    fn a_rectangle_is_good() {
        let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let q = quality(&mesh(&points, &[(Shape::Quad4, [1, 2, 3, 4])])).unwrap();
        assert_eq!((q.min_side.value, q.max_side.value, q.max_aspect.value), (1.0, 2.0, 2.0));
        assert_eq!(
            (q.max_warpage_deg.value, q.min_jacobian.value, q.min_area.value),
            (0.0, 1.0, 2.0)
        );
        assert!(q.zero_area.is_empty() && q.dangling.is_empty());
    }

    /// One corner of a unit square is lifted by h. The halves on either side of the diagonal
    /// without this corner include the angle atan(h sqrt 2). Along the diagonal with this
    /// corner, the planes z = h y and z = h x include the slightly larger acos(1/(1 + h^2)).
    #[test]
    fn a_lifted_corner_is_warpage() {
        let h = 0.1;
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, h], [0.0, 1.0, 0.0]];
        let q = quality(&mesh(&points, &[(Shape::Quad4, [1, 2, 3, 4])])).unwrap();
        let expected = (1.0 / (1.0 + h * h)).acos().to_degrees();
        assert!(
            (q.max_warpage_deg.value - expected).abs() < 1e-12,
            "{} {expected}",
            q.max_warpage_deg.value
        );
    }

    /// A parallelogram whose sides include the angle a has the skew 90 - a; a square has none. In a
    /// right triangle with the legs 2 and 1, the line from the end of the short leg and that
    /// through the middles of the other two sides include 45 degrees, the smallest angle.
    #[test]
    fn skew_has_its_closed_forms() {
        let a = 60f64.to_radians();
        let points = [
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [2.0 + a.cos(), a.sin(), 0.0],
            [a.cos(), a.sin(), 0.0],
        ];
        let q = quality(&mesh(&points, &[(Shape::Quad4, [1, 2, 3, 4])])).unwrap();
        assert!((q.max_skew_deg.value - 30.0).abs() < 1e-12, "{}", q.max_skew_deg.value);
        let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let q = quality(&mesh(&points, &[(Shape::Tri3, [1, 2, 3, 3])])).unwrap();
        assert!((q.max_skew_deg.value - 45.0).abs() < 1e-12, "{}", q.max_skew_deg.value);
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let q = quality(&mesh(&square, &[(Shape::Quad4, [1, 2, 3, 4])])).unwrap();
        assert_eq!(q.max_skew_deg.value, 0.0);
    }

    #[test]
    fn folded_flat_and_dangling_elements_are_named() {
        let points =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.3, 0.3, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0]];
        let q = quality(&mesh(
            &points,
            &[
                (Shape::Quad4, [1, 2, 3, 4]),  // concave
                (Shape::Tri3, [1, 2, 5, 5]),   // on one line
                (Shape::Tri3, [1, 2, 4, 4]),   // good
                (Shape::Quad4, [1, 2, 4, 1]),  // a node twice
                (Shape::Quad4, [1, 2, 4, 99]), // no such node
            ],
        ))
        .unwrap();
        assert!(q.min_jacobian.value < 0.0);
        assert_eq!(q.min_jacobian.element, ElemId(1));
        assert_eq!(q.zero_area, [ElemId(2), ElemId(4)]);
        assert_eq!(q.dangling, [ElemId(5)]);
    }

    #[test]
    fn an_empty_mesh_has_no_quality() {
        assert_eq!(quality(&Mesh::default()), None);
    }
}
