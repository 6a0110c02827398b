//! The size and the number of failed points that elements give damage by plastic strain.

use super::solid_testing::block;
use super::testing::{Patch, part, part_of, steel};
use crate::materials::SIZE_COLUMN;
use crumple_proto::job::{LayerInput, Part};
use crumple_proto::partition::{Material, Param};

fn table(rows: &[[f64; 2]]) -> Param {
    Param::Table(rows.iter().map(|row| row.to_vec()).collect())
}

fn metal(more: &[(&str, Param)]) -> Material {
    let fails =
        [("yield_stress", Param::Number(0.25)), ("gissmo_failure_strain", table(&[[-1.0, 0.02]]))];
    steel("j2", &[&fails[..], more].concat())
}

/// Returns a metal whose points fail at the same plastic strain by a criterion instead of damage.
fn eroding(more: &[(&str, Param)]) -> Material {
    let fails =
        [("yield_stress", Param::Number(0.25)), ("erosion_plastic_strain", Param::Number(0.02))];
    steel("j2", &[&fails[..], more].concat())
}

/// Returns the values of the columns of an element with this name.
fn columns<const C: usize>(patch: &Patch<C>, name: &str) -> Vec<f64> {
    let names = patch.element.names();
    let history = patch.history.element(0).to_vec();
    let own = |at: usize| names[at].split(" of point").next().expect("a name");
    let has = |at: &usize| own(*at).ends_with(name);
    (0..names.len()).filter(has).map(|at| history[at]).collect()
}

/// The size is the root of the area of shells, at all points, and the cube root of the volume of
/// solids. It says nothing of strain: such elements are at rest.
#[test]
fn elements_store_their_size() {
    let sized = metal(&[("gissmo_size_factors", table(&[[1.0, 1.0], [3.0, 0.5]]))]);
    let corners = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
    for (element, points) in
        [("belytschko_tsay", 3), ("stabilised_quad", 3), ("fully_integrated_quad", 12)]
    {
        let part = part_of(element, 1.0).with("points", 3_i64);
        let patch: Patch<4> = Patch::new(part, sized.clone(), &corners, &[[0, 1, 2, 3]]);
        let sizes = columns(&patch, SIZE_COLUMN);
        assert_eq!(sizes, vec![6.0_f64.sqrt(); points], "{element}");
        assert!(patch.element.is_unstrained(patch.history.element(0)), "{element}");
    }
    let triangle: Patch<4> = Patch::new(part(1.0), sized.clone(), &corners, &[[0, 1, 2, 2]]);
    assert!(
        columns(&triangle, SIZE_COLUMN).iter().all(|size| (size - 3.0_f64.sqrt()).abs() < 1e-14)
    );
    let (nodes, cells) = block([1, 1, 1], [1.0, 2.0, 3.0]);
    let cube: Patch<8> = Patch::new(part(0.0), sized.clone(), &nodes, &cells);
    assert!((columns(&cube, SIZE_COLUMN)[0] - 6.0_f64.cbrt()).abs() < 1e-14);
    assert!(cube.element.is_unstrained(cube.history.element(0)));
    let [a, b, c, _, d, ..] = cells[0];
    let of = Part { element: Some("tetrahedron".into()), ..part(0.0) };
    let tetrahedron: Patch<4> = Patch::new(of, sized.clone(), &nodes, &[[a, b, c, d]]);
    assert!((columns(&tetrahedron, SIZE_COLUMN)[0] - 1.0).abs() < 1e-14);
    let [.., e, f, _] = cells[0];
    let wedge: Patch<6> = Patch::new(part(0.0), sized, &nodes, &[[a, b, c, d, e, f]]);
    let sizes = columns(&wedge, SIZE_COLUMN);
    let exact = 3.0_f64.cbrt();
    assert!(sizes.len() == 2 && sizes.iter().all(|s| (s - exact).abs() < 1e-14), "{sizes:?}");
}

/// A shell of three points that is bent keeps the one in its middle: it goes with the first failed
/// point, with two, with two thirds of them, but not if all have to fail.
#[test]
fn a_shell_goes_with_so_many_failed_points() {
    let corners = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 3.0, 0.0], [0.0, 3.0, 0.0]];
    for (wanted, goes) in [
        (Some(1.0), true),
        (Some(2.0), true),
        (Some(3.0), false),
        (Some(-66.0), true),
        (None, false),
    ] {
        let with = |key: &'static str| -> Vec<(&str, Param)> {
            wanted.map(|n| (key, Param::Number(n))).into_iter().collect()
        };
        let laws = [metal(&with("gissmo_failed_points")), eroding(&with("erosion_failed_points"))];
        // Layers count as points.
        let layer = LayerInput { thickness: 1.0, material: String::new(), angle: 30.0, points: 3 };
        for (law, layered) in laws.iter().flat_map(|law| [(law, false), (law, true)]) {
            let part = part_of("belytschko_tsay", 1.0);
            let part = match layered {
                false => part.with("points", 3_i64),
                true => Part { layer: vec![layer.clone()], ..part },
            };
            let mut patch: Patch<4> = Patch::new(part, law.clone(), &corners, &[[0, 1, 2, 3]]);
            for k in [1, 2] {
                patch.w[k][1] = 0.01;
            }
            for k in [0, 3] {
                patch.w[k][1] = -0.01;
            }
            for _ in 0..60 {
                patch.step(1.0);
            }
            let failed = columns(&patch, " failed");
            let count = failed.iter().filter(|mark| **mark > 0.5).count();
            assert_eq!(count, 2, "the outer points of {wanted:?}: {failed:?}");
            let gone = patch.element.failed(patch.history.element(0));
            assert_eq!(gone, goes, "{wanted:?} {layered}");
            let moments = (0..4).map(|c| patch.corner(0, c).1[1].abs()).fold(0.0, f64::max);
            assert!(!gone || moments == 0.0, "{wanted:?}: {moments}");
        }
    }
}
