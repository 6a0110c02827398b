//! Checks of the elements of a mesh: ids, parts, corners, shapes.

use super::{Few, PlacedMesh, Written};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::{Mesh, MeshElement, MeshNode, Shape};
use crumple_proto::problem::Problem;
use crumple_proto::quality::{middle, quality};
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// Area over the square of the longest side below which the area of an element is only round-off.
const NO_AREA: f64 = 1e-12;

/// Reports elements that cannot be computed. `at` are the positions of the nodes, `parts` the ids
/// of the parts if they are known.
pub(super) fn check(
    read: &PlacedMesh,
    at: &FxHashMap<NodeId, [f64; 3]>,
    parts: Option<&[u32]>,
    few: &mut Few<'_>,
) {
    let mesh = &read.mesh;
    if mesh.elements.is_empty() {
        let path = match read.written {
            Written::Rows(_) => "mesh",
            Written::Elsewhere(key) => key,
        };
        few.error(
            "empty",
            path.into(),
            "the mesh has no elements".into(),
            "add mesh.shells or mesh.solids; in a deck *ELEMENT_SHELL or *ELEMENT_SOLID",
        );
    }
    let mut seen = HashSet::with_capacity(mesh.elements.len());
    // For each missing part, and for concave quads: the first element, and their number.
    let mut orphans: BTreeMap<u32, (usize, usize)> = BTreeMap::new();
    let mut concave: Option<(usize, usize)> = None;
    for (index, element) in mesh.elements.iter().enumerate() {
        let (id, path) = (element.id, || read.element_path(index));
        if id > ElemId::LARGEST {
            let message = format!("element id {} is too large", id.0);
            few.error("element id", path(), message, "use element ids below 9e15");
        }
        if !seen.insert(id) {
            let message = format!("element {id} is defined twice");
            few.error("element twice", path(), message, "give each element a unique id");
        }
        if parts.is_some_and(|parts| !parts.contains(&element.part)) {
            orphans.entry(element.part).or_insert((index, 0)).1 += 1;
        }
        let Some(x) = corners(element, at, path, few) else { continue };
        match element.shape {
            Shape::Line2 => {} // its part determines if it needs a length
            Shape::Point1 => {}
            Shape::Beam2 => beam(element, &x, at, path(), few),
            Shape::Truss2 => truss(element, &x, path(), few),
            Shape::Hex8 | Shape::Tet4 | Shape::Wedge6 | Shape::Tet10 => {
                solid(element, &x, path(), few)
            }
            Shape::Cohesive8 => cohesive(element, &x, path(), few),
            Shape::Quad4 | Shape::Tri3 => match outline(&x) {
                ShapeOutline::Concave => {
                    let (first, count) = concave.unwrap_or((index, 0));
                    concave = Some((first, count + 1));
                }
                outline => shell(element, &outline, path, few),
            },
        }
    }
    for (part, (index, count)) in orphans {
        orphan(read, part, (index, count), parts.unwrap_or_default(), few);
    }
    if let Some((index, count)) = concave {
        let first = mesh.elements[index].id;
        let message =
            format!("{count} quads have a re-entrant corner; the first is element {first}");
        few.findings.add(Problem::warning(
            read.element_path(index),
            message,
            "remesh these quads: results are poor there",
        ));
    }
}

/// Returns the positions of the corners of an element. Reports corners that are repeated or do not
/// exist; then, or if a coordinate is not finite, returns `None`.
fn corners(
    element: &MeshElement,
    at: &FxHashMap<NodeId, [f64; 3]>,
    path: impl Fn() -> String,
    few: &mut Few<'_>,
) -> Option<Vec<[f64; 3]>> {
    let (id, corners) = (element.id, element.corners());
    if let Some(twice) = (1..corners.len()).find(|&i| corners[..i].contains(&corners[i])) {
        let message = format!("element {id} uses node {} twice", corners[twice]);
        let help = match element.shape {
            Shape::Cohesive8 => {
                "a cohesive element needs eight different nodes; those of its two faces may be at \
                 the same places"
            }
            Shape::Hex8 => {
                "a solid needs eight different nodes; write a tetrahedron with four and a wedge \
                 with six nodes, and mesh again without pyramids"
            }
            Shape::Line2 => {
                "a spring needs two different nodes; for a spring to the ground, fix its other \
                 node by a [[fix]]"
            }
            Shape::Beam2 | Shape::Truss2 => "a bar needs two different ends; correct or remove it",
            _ => "a triangle repeats its last node only; correct or remove the element",
        };
        few.error("repeated", path(), message, help);
        return None;
    }
    let mut x = Vec::with_capacity(8);
    for node in corners {
        match at.get(node) {
            Some(&position) => x.push(position),
            None => no_node(element, *node, path(), few),
        }
    }
    let is_whole = x.len() == corners.len() && x.iter().flatten().all(|c| c.is_finite());
    is_whole.then_some(x)
}

fn no_node(element: &MeshElement, node: NodeId, path: String, few: &mut Few<'_>) {
    let message = format!("element {}: there is no node {}", element.id, node.0);
    few.error("no node", path, message, "add the node or correct the element");
}

/// Reports a truss without length.
fn truss(element: &MeshElement, x: &[[f64; 3]], path: String, few: &mut Few<'_>) {
    if x[0] == x[1] {
        let message = format!("truss {}: its nodes are at one point", element.id);
        few.error("no length", path, message, "move its nodes apart, or remove the truss");
    }
}

/// Reports a beam whose third node gives no direction.
fn beam(
    element: &MeshElement,
    x: &[[f64; 3]],
    at: &FxHashMap<NodeId, [f64; 3]>,
    path: String,
    few: &mut Few<'_>,
) {
    match at.get(&element.nodes[2]) {
        Some(third) if matches!(outline(&[x[0], x[1], *third]), ShapeOutline::Good) => {}
        Some(_) => {
            let message = format!(
                "beam {}: its third node lies on the line through the first two",
                element.id
            );
            let help = "give a third node off this line, in the direction of the second axis";
            few.error("third node", path, message, help);
        }
        None => no_node(element, element.nodes[2], path, few),
    }
}

/// Reports a shell with an outline that cannot be computed.
fn shell(
    element: &MeshElement,
    outline: &ShapeOutline,
    path: impl Fn() -> String,
    few: &mut Few<'_>,
) {
    let id = element.id;
    let (kind, message, help) = match outline {
        ShapeOutline::Good | ShapeOutline::Concave => return,
        ShapeOutline::NoArea => (
            "no area",
            format!("element {id} has no area: its nodes lie on one line or at one point"),
            "move its nodes apart, or remove the element",
        ),
        ShapeOutline::NoSide => (
            "no side",
            format!("element {id} has two corners at one point"),
            "make it a triangle, or move one of the two nodes",
        ),
        ShapeOutline::BowTie => (
            "bow-tie",
            format!("element {id} is folded over: its sides cross (bow-tie)"),
            "give its nodes in order around the element; two are exchanged",
        ),
        ShapeOutline::Overflow => (
            "overflow",
            format!("element {id} is too large or too small to compute with"),
            "check the units of the coordinates",
        ),
    };
    few.error(kind, path(), message, help);
}

/// Reports a part that the job does not have: index of its first element, and number of elements.
fn orphan(
    read: &PlacedMesh,
    part: u32,
    (index, count): (usize, usize),
    parts: &[u32],
    few: &mut Few<'_>,
) {
    let first = read.mesh.elements[index].id;
    let message = match count {
        1 => format!("element {first} belongs to part {part}, which the job does not have"),
        n => format!(
            "{n} elements belong to part {part}, which the job does not have; the first is \
             element {first}"
        ),
    };
    let known: BTreeSet<u32> = parts.iter().copied().collect();
    let known: Vec<String> = known.iter().map(u32::to_string).collect();
    let help = format!(
        "add a [[part]] with id = {part} (a *PART in a deck), or correct the element; there are \
         parts: {}",
        known.join(", ")
    );
    few.error("orphan", read.element_path(index), message, &help);
}

/// Reports a solid with a wrong order of corners, or without volume.
fn solid(element: &MeshElement, x: &[[f64; 3]], path: String, few: &mut Few<'_>) {
    let one = Mesh {
        nodes: element.corners().iter().zip(x).map(|(&id, &x)| MeshNode { id, x }).collect(),
        elements: vec![*element],
        ..Mesh::default()
    };
    let Some(figures) = quality(&one) else { return };
    let id = element.id;
    if !figures.zero_area.is_empty() && figures.min_jacobian.value > f64::NEG_INFINITY {
        let message = format!(
            "solid {id} has no volume: its nodes lie in one plane, on one line or at one point"
        );
        few.error("no volume", path, message, "move its nodes apart, or remove the element");
    } else if figures.min_jacobian.value <= 0.0 {
        let message = format!("solid {id} is inverted or twisted at a corner");
        let help = "give the nodes of one face so that its right-hand normal points into the \
                    solid, then those of the opposite face, or the fourth node of a tetrahedron; \
                    nodes on edges belong near their middles";
        few.error("inverted", path, message, help);
    }
}

/// Reports a cohesive element without a middle surface, or whose second face is behind its first.
fn cohesive(element: &MeshElement, x: &[[f64; 3]], path: String, few: &mut Few<'_>) {
    let (id, surface) = (element.id, middle(x));
    if !matches!(outline(&surface), ShapeOutline::Good) {
        let message = format!("cohesive element {id} has no middle surface between its two faces");
        let help = "give the four nodes of one face in order around it, then the opposite four";
        few.error("no surface", path, message, help);
        return;
    }
    let along = |a: usize, b: usize| [0, 1, 2].map(|i| surface[b][i] - surface[a][i]);
    let ([a, b, c], [d, e, f]) = (along(0, 2), along(1, 3));
    let normal = [b * f - c * e, c * d - a * f, a * e - b * d];
    let apart: f64 = (0..4)
        .flat_map(|k| (0..3).map(move |i| (k, i)))
        .map(|(k, i)| normal[i] * (x[k + 4][i] - x[k][i]))
        .sum();
    if apart < 0.0 {
        let message = format!("cohesive element {id} is inside out");
        let help = "give the nodes of one face so that its right-hand normal points to the \
                    opposite face, then those of the opposite face";
        few.error("inverted", path, message, help);
    }
}

enum ShapeOutline {
    Good,
    Concave,
    /// Two corners coincide.
    NoSide,
    BowTie,
    NoArea,
    Overflow,
}

fn outline(x: &[[f64; 3]]) -> ShapeOutline {
    let n = x.len();
    let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let side = |i: usize| sub(x[(i + 1) % n], x[i]);
    let longest = (0..n).map(|i| dot(side(i), side(i))).fold(0.0, f64::max);
    let area =
        if n == 4 { cross(sub(x[2], x[0]), sub(x[3], x[1])) } else { cross(side(0), side(1)) };
    let size = dot(area, area);
    // This function and the elements compute fourth powers of lengths.
    if !(longest * longest).is_finite() || longest > 0.0 && longest * longest < f64::MIN_POSITIVE {
        return ShapeOutline::Overflow;
    }
    let corner = |i: usize| cross(side((i + n - 1) % n), side(i));
    if 0.5 * size.sqrt() <= NO_AREA * longest {
        let open = (0..n).any(|i| dot(corner(i), corner(i)).sqrt() > 1e-6 * longest);
        return if open { ShapeOutline::BowTie } else { ShapeOutline::NoArea };
    }
    if (0..n).any(|i| dot(side(i), side(i)).sqrt() <= NO_AREA * longest.sqrt()) {
        return ShapeOutline::NoSide;
    }
    let turned = (0..n).filter(|&i| dot(corner(i), area) < 0.0).count();
    match turned {
        0 => ShapeOutline::Good,
        1 => ShapeOutline::Concave,
        _ => ShapeOutline::BowTie,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(points: [[f64; 2]; 4]) -> ShapeOutline {
        outline(&points.map(|[x, y]| [x, y, 0.0]))
    }

    #[test]
    fn outlines() {
        assert!(matches!(
            shape([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
            ShapeOutline::Good
        ));
        assert!(matches!(
            shape([[0.0, 0.0], [1.0, 0.0], [0.3, 0.3], [0.0, 1.0]]),
            ShapeOutline::Concave
        ));
        assert!(
            matches!(shape([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]), ShapeOutline::BowTie),
            "halves cancel"
        );
        assert!(matches!(
            shape([[0.0, 0.0], [1.0, 0.0], [0.0, 2.0], [1.0, 1.0]]),
            ShapeOutline::BowTie
        ));
        assert!(matches!(
            shape([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]),
            ShapeOutline::NoArea
        ));
        assert!(matches!(
            shape([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
            ShapeOutline::NoSide
        ));
        assert!(matches!(
            shape([[0.0, 0.0], [1e200, 0.0], [1e200, 1e200], [0.0, 1e200]]),
            ShapeOutline::Overflow
        ));
    }
}
