//! Ties of nodes to the solids in which they are, as of reinforcement in concrete.
//!
//! The masters of a node are the corners of its solid; their weights are the linear shape functions
//! of its shape at the node, for a tetrahedron of ten nodes those of its four corners.

use super::surface::shape_values;
use super::{Projected, TieContext, name};
use crate::input::job::validate::JobProblems;
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::NodeId;
use crumple_proto::job::TieInput;
use crumple_proto::mesh::{MeshElement, Shape};
use crumple_proto::problem::Problem;
use crumple_proto::tie::Tie;
use crumple_worker::contact::search::linked_cells;
use crumple_worker::math::row::V3;
use nalgebra::Matrix3;
use std::collections::HashSet;

/// Default tolerance, as a fraction of the diagonal of the box around a solid.
const OF_BOX: f64 = 1e-3;
/// Steps of Newton's method, and the last change of the natural coordinates after which it ends.
const STEPS: usize = 30;
const SETTLED: f64 = 1e-12;
/// Natural coordinates within this distance of a face are on it. So a node on a plane of symmetry
/// has no masters off the plane.
const ON_FACE: f64 = 1e-6;

/// A node in a solid.
struct PointInSolid {
    /// Index of the solid.
    element: usize,
    shape: Vec<f64>,
    point: V3,
    /// Distance from the node to `point`, 0 if it is inside [length].
    distance: f64,
}

/// Returns the ties of nodes to the solids of the parts of an entry.
pub(super) fn to_solids(
    spec: &TieInput,
    entry: usize,
    nodes: &[usize],
    context: &TieContext<'_>,
    findings: &mut JobProblems,
) -> Vec<Projected> {
    let TieContext { job, mesh, .. } = context;
    let mut wrong = |key: &str, message: &str, help: &str| {
        let message = format!("{}: {message}", name(job, entry));
        findings.add(Problem::error(format!("tie.{entry}.{key}"), message, help));
    };
    let turns = spec.rotations || spec.offset;
    if turns || spec.faces.is_some() || spec.failure.is_some() || spec.thicknesses != [0.0; 2] {
        let help = "remove them: its nodes have the displacements of the solids in which they are";
        let keys = "it has `inside` and also `rotations`, `offset`, `faces`, `failure` or \
                    `thicknesses`";
        wrong("inside", keys, help);
    }
    let is_solid = |e: &MeshElement| e.shape.is_solid() && spec.parts.contains(&e.part);
    let solids: Vec<usize> =
        (0..mesh.elements.len()).filter(|&i| is_solid(&mesh.elements[i])).collect();
    if solids.is_empty() {
        wrong("parts", "its parts have no solids", "name `parts` of solids");
        return Vec::new();
    }
    let own: HashSet<NodeId> =
        solids.iter().flat_map(|&i| mesh.elements[i].corners()).copied().collect();
    let nodes: Vec<usize> =
        nodes.iter().copied().filter(|&n| !own.contains(&mesh.nodes[n].id)).collect();
    if nodes.is_empty() {
        let message = format!("{}: all its nodes belong to its solids", name(job, entry));
        let help = "if this is meant, remove the tie: they have the motion of the solids already";
        findings.add(Problem::warning(format!("tie.{entry}.nodes"), message, help));
        return Vec::new();
    }
    let found = locate(spec.tolerance, &solids, &nodes, context);
    let lost = (0..nodes.len()).filter(|&p| found[p].is_none());
    let lost: Vec<NodeId> = lost.map(|p| mesh.nodes[nodes[p]].id).collect();
    super::report_lost(job, (entry, "in a solid of its parts"), (&lost, nodes.len()), findings);
    let tied = |(&node, found): (&usize, Option<PointInSolid>)| {
        let found = found?;
        let element = &mesh.elements[found.element];
        let stays = context.rigid.contains(&element.part);
        Some(Projected {
            tie: Tie {
                node: mesh.nodes[node].id,
                masters: shape_values(element.corners(), &found.shape),
                near: Vec::new(),
                faces: vec![element.id],
                rotations: false,
                offset: false,
                mean: false,
                failure: None,
            },
            entry,
            node,
            point: if stays { mesh.nodes[node].x } else { found.point.into() },
            moved: if stays { 0.0 } else { found.distance / box_of(element, context).1 },
        })
    };
    nodes.iter().zip(found).filter_map(tied).collect()
}

/// Returns the box around a solid, and its diagonal [length].
fn box_of(element: &MeshElement, context: &TieContext<'_>) -> (Aabb, f64) {
    let places = || element.corners().iter().map(|&id| context.place(id));
    let least = places().fold(V3::repeat(f64::MAX), |all, x| all.inf(&x.into()));
    let most = places().fold(V3::repeat(f64::MIN), |all, x| all.sup(&x.into()));
    (Aabb::around(places()), (most - least).norm())
}

/// Finds the solid of each node: the nearest one within the tolerance, the first of equally near
/// ones. A tolerance of 0 is the default one.
fn locate(
    tolerance: f64,
    solids: &[usize],
    nodes: &[usize],
    context: &TieContext<'_>,
) -> Vec<Option<PointInSolid>> {
    let mesh = context.mesh;
    let reach = |diagonal: f64| if tolerance > 0.0 { tolerance } else { OF_BOX * diagonal };
    let grown: Vec<(Aabb, f64)> = solids
        .iter()
        .map(|&i| {
            let (around, diagonal) = box_of(&mesh.elements[i], context);
            (around.grown(reach(diagonal)), reach(diagonal))
        })
        .collect();
    let boxes: Vec<Aabb> = grown.iter().map(|b| b.0).collect();
    let points: Vec<[f64; 3]> = nodes.iter().map(|&n| mesh.nodes[n].x).collect();
    let mut found: Vec<Option<PointInSolid>> = nodes.iter().map(|_| None).collect();
    linked_cells(&boxes, &points, &mut |solid, p| {
        let (solid, p) = (solid as usize, p as usize);
        let element = &mesh.elements[solids[solid]];
        let corners: Vec<V3> =
            element.corners().iter().map(|&id| context.place(id).into()).collect();
        let found_here = nearest(element.shape, &corners, points[p].into());
        let Some((shape, point, distance)) = found_here else { return };
        let is_nearer = found[p]
            .as_ref()
            .is_none_or(|old| (distance, solids[solid]) < (old.distance, old.element));
        if distance <= grown[solid].1 && is_nearer {
            found[p] = Some(PointInSolid { element: solids[solid], shape, point, distance });
        }
    });
    found
}

/// Returns the shape functions of the corners of a solid at natural coordinates. They are linear in
/// each coordinate.
fn shape_at(shape: Shape, [a, b, c]: [f64; 3]) -> Vec<f64> {
    match shape {
        Shape::Tet4 | Shape::Tet10 => vec![1.0 - a - b - c, a, b, c],
        Shape::Wedge6 => {
            let [lower, upper] = [0.5 * (1.0 - c), 0.5 * (1.0 + c)];
            let triangle = [1.0 - a - b, a, b];
            [triangle.map(|l| l * lower), triangle.map(|l| l * upper)].concat()
        }
        _ => {
            let side = |sign: f64, x: f64| 0.5 * (1.0 + sign * x);
            let around = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let layer = |z: f64| around.map(|[x, y]| side(x, a) * side(y, b) * side(z, c));
            [layer(-1.0), layer(1.0)].concat()
        }
    }
}

/// Returns natural coordinates limited to those of a solid; those that are almost on a face are on
/// it.
fn within(shape: Shape, [a, b, c]: [f64; 3]) -> [f64; 3] {
    let limited = |x: f64| match x.abs() > 1.0 - ON_FACE {
        true => x.signum(),
        false => x,
    };
    let simplex = |list: &mut [f64]| {
        list.iter_mut().filter(|x| **x < ON_FACE).for_each(|x| *x = 0.0);
        let sum: f64 = list.iter().sum();
        if sum > 1.0 - ON_FACE {
            list.iter_mut().for_each(|x| *x /= sum);
        }
    };
    match shape {
        Shape::Tet4 | Shape::Tet10 => {
            let mut all = [a, b, c];
            simplex(&mut all);
            all
        }
        Shape::Wedge6 => {
            let mut triangle = [a, b];
            simplex(&mut triangle);
            [triangle[0], triangle[1], limited(c)]
        }
        _ => [a, b, c].map(limited),
    }
}

/// Returns the shape functions at a point in a solid, the point and the distance 0; for a point
/// outside those at its natural coordinates limited to the solid, which is near the nearest point.
/// `None` if there are no natural coordinates.
fn nearest(shape: Shape, corners: &[V3], point: V3) -> Option<(Vec<f64>, V3, f64)> {
    // From the point, so that round-off is that of the solid's size.
    let place = |natural: [f64; 3]| -> V3 {
        shape_at(shape, natural).iter().zip(corners).map(|(n, x)| (x - point) * *n).sum()
    };
    let mut natural = match shape {
        Shape::Tet4 | Shape::Tet10 => [0.25; 3],
        Shape::Wedge6 => [1.0 / 3.0, 1.0 / 3.0, 0.0],
        _ => [0.0; 3],
    };
    for _ in 0..STEPS {
        let slope = |k: usize| {
            // Exact, because the place is linear in each coordinate.
            let [mut below, mut above] = [natural; 2];
            below[k] -= 0.5;
            above[k] += 0.5;
            place(above) - place(below)
        };
        let jacobian = Matrix3::from_columns(&[slope(0), slope(1), slope(2)]);
        let change = jacobian.lu().solve(&-place(natural))?;
        (0..3).for_each(|k| natural[k] += change[k]);
        if change.amax() < SETTLED {
            let limited = within(shape, natural);
            let values = shape_at(shape, limited);
            let moved = (0..3).map(|k| (limited[k] - natural[k]).abs()).fold(0.0, f64::max);
            return Some(match moved > ON_FACE {
                true => (values, point + place(limited), place(limited).norm()),
                false => (values, point, 0.0),
            });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of distorted solids are found from their places, points outside are moved to the
    /// surface.
    #[test]
    fn points_are_found_from_their_places() {
        let hexahedron = [
            [0.0, 0.0, 0.0],
            [2.0, 0.2, 0.1],
            [2.3, 1.9, -0.2],
            [-0.1, 1.5, 0.0],
            [0.2, 0.1, 1.4],
            [1.8, -0.1, 1.7],
            [2.1, 2.2, 1.5],
            [0.1, 1.8, 1.9],
        ];
        let solids: [(Shape, &[[f64; 3]]); 3] = [
            (Shape::Hex8, &hexahedron),
            (Shape::Tet4, &[hexahedron[0], hexahedron[1], hexahedron[3], hexahedron[4]]),
            (
                Shape::Wedge6,
                &[
                    hexahedron[0],
                    hexahedron[1],
                    hexahedron[3],
                    hexahedron[4],
                    hexahedron[5],
                    hexahedron[7],
                ],
            ),
        ];
        for (shape, places) in solids {
            let corners: Vec<V3> = places.iter().map(|&x| x.into()).collect();
            let at = |natural: [f64; 3]| -> V3 {
                shape_at(shape, natural).iter().zip(&corners).map(|(n, x)| x * *n).sum()
            };
            let inside = [0.3, 0.4, 0.2];
            let (found, point, distance) = nearest(shape, &corners, at(inside)).expect("inside");
            let expected = shape_at(shape, inside);
            assert_eq!((point, distance), (at(inside), 0.0));
            for (a, b) in found.iter().zip(&expected) {
                assert!((a - b).abs() < 1e-12, "{shape:?}: {found:?} {expected:?}");
            }
            assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            // Far from the origin round-off of coordinates is larger than that of the solid.
            let far = V3::new(1e5, -2e5, 3e5);
            let moved: Vec<V3> = corners.iter().map(|x| x + far).collect();
            let (shifted, ..) = nearest(shape, &moved, at(inside) + far).expect("inside");
            for (a, b) in shifted.iter().zip(&expected) {
                assert!((a - b).abs() < 1e-9, "{shape:?}: {shifted:?} {expected:?}");
            }
            let (found, ..) = nearest(shape, &corners, at([-0.1, 0.4, -1.2])).expect("outside");
            assert!(found.iter().all(|n| *n >= 0.0), "{shape:?}: {found:?}");
        }
        // Half a side below the first face of a cube, and almost on it.
        let cube: Vec<V3> = (0..8).map(|k| V3::from(hexahedron[k].map(f64::round))).collect();
        let square = [0.25, 0.25, 0.25, 0.25, 0.0, 0.0, 0.0, 0.0];
        let (found, foot, distance) =
            nearest(Shape::Hex8, &cube, V3::new(1.0, 1.0, -1.0)).expect("outside");
        assert_eq!((found, foot, distance), (square.to_vec(), V3::new(1.0, 1.0, 0.0), 1.0));
        let almost = V3::new(1.0, 1.0, 1e-8);
        let (found, foot, distance) = nearest(Shape::Hex8, &cube, almost).expect("inside");
        assert_eq!((found, foot, distance), (square.to_vec(), almost, 0.0));
        let flat = vec![V3::zeros(); 8];
        assert!(nearest(Shape::Hex8, &flat, V3::new(1.0, 0.0, 0.0)).is_none());
    }
}
