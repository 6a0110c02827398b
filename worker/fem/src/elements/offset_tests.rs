//! Shells with an offset of the middle surface: stiffness about the nodes, and bending by a force
//! in the nodal plane.

use super::statics::Statics;
use super::testing::*;
use crumple_proto::job::Part;

const T: f64 = 0.2;
const LENGTH: f64 = 10.0;
const WIDTH: f64 = 1.0;
/// Without transverse strain plates are beams.
const NO_POISSON: f64 = 0.0;

fn shell(element: &str, offset: f64) -> Part {
    Part { offset, ..part_of(element, T) }
}

/// A cantilever is pulled by F along the line of its nodes, e below its middle. It carries F and
/// the moment F e about the middle, so that the tip rises by `F e L^2/(2 E I)` and moves along by
/// `F L (1/(E A) + e^2/(E I))`; quads give both exactly.
#[test]
fn a_force_along_the_nodes_bends_a_cantilever() {
    const F: f64 = 1e-3;
    for element in QUADS {
        for offset in [1.0, -0.5, 0.0] {
            let (nodes, quads) = grid(2, 10, WIDTH, LENGTH);
            // Along x, its normal along z.
            let nodes: Vec<[f64; 3]> = nodes.iter().map(|x| [x[1], -x[0], 0.0]).collect();
            let mut statics =
                Statics::new(shell(element, offset), elastic(E, NO_POISSON, 1.0), &nodes, &quads);
            (0..3).for_each(|node| statics.fix(node, &[0, 1, 2, 3, 4, 5]));
            let tip = [30, 31, 32];
            tip.iter()
                .zip([0.25, 0.5, 0.25])
                .for_each(|(node, share)| statics.load[6 * node] = share * F);
            let moved = statics.solve();
            let (area, inertia, e) = (WIDTH * T, WIDTH * T.powi(3) / 12.0, 0.5 * offset * T);
            let along = F * LENGTH * (1.0 / (E * area) + e * e / (E * inertia));
            let up = F * e * LENGTH * LENGTH / (2.0 * E * inertia);
            let turn = -F * e * LENGTH / (E * inertia);
            for node in tip {
                for (found, wanted) in
                    [(moved[node][0], along), (moved[node][2], up), (moved[node][4], turn)]
                {
                    let tolerance = 1e-8 * (wanted.abs() + along);
                    assert_close(
                        found,
                        wanted,
                        tolerance,
                        &format!("{element}, offset {offset}: round-off"),
                    );
                }
            }
        }
    }
}

/// A strip that is bent about the line of its nodes, which keeps its length, has the stiffness
/// `E (I + A e^2)`.
#[test]
fn bending_about_the_nodes_has_their_stiffness() {
    const KAPPA: f64 = 1e-12;
    for (element, triangular) in FORMULATIONS {
        for offset in [1.0, -1.0, 0.3, 2.0] {
            let (nodes, quads) = grid(4, 2, LENGTH, WIDTH);
            let cells = if triangular { triangles(&quads) } else { quads };
            let mut patch =
                Patch::new(shell(element, offset), elastic(E, NO_POISSON, 1.0), &nodes, &cells);
            for ((v, w), x) in patch.v.iter_mut().zip(&mut patch.w).zip(&nodes) {
                (v[2], w[1]) = (-0.5 * KAPPA * x[0] * x[0], KAPPA * x[0]);
            }
            let found = patch.forces(1.0).internal;
            let e = 0.5 * offset * T;
            let wanted = 0.5 * E * WIDTH * (T.powi(3) / 12.0 + T * e * e) * KAPPA * KAPPA * LENGTH;
            assert!(
                (found / wanted - 1.0).abs() < 1e-9,
                "{element}, offset {offset}: {found} for {wanted}: round-off"
            );
        }
    }
}
