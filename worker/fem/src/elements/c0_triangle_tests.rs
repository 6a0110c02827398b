//! Tests of the properties that only the three-node shell has.

use super::super::testing::*;
use super::*;

const E: f64 = 210.0;
const NU: f64 = 0.3;

/// A triangle in the plane with its first side along x.
const NODES: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.2, 0.0, 0.0], [0.3, 0.9, 0.0]];

fn triangle(part: Part, nodes: &[[f64; 3]; 3]) -> Patch {
    Patch::new(part, elastic(E, NU, 1.0), nodes, &[[0, 1, 2, 2]])
}

/// Returns the transverse shear xz, yz due to a unit rotation of a node, in global axes [1].
fn shear_of(node: usize, axis: usize) -> [f64; 2] {
    let mut patch = triangle(part(0.1), &NODES);
    patch.w[node][axis] = 1e-6;
    patch.forces(1.0);
    let stress = patch.fields(0).stress;
    let g = SHEAR_CORRECTION * 0.5 * E / (1.0 + NU);
    [stress[5] / g * 1e6, stress[4] / g * 1e6]
}

/// The shear matrix of Belytschko, Stolarski & Carpenter 1984 in the axes of side 1-2, and MITC3 at
/// its centroid.
#[test]
fn shear_is_that_of_the_paper_and_of_mitc3() {
    let (x2, x3, y3) = (NODES[1][0], NODES[2][0], NODES[2][1]);
    // Columns tx1, ty1, tx2, ty2, tx3, ty3, over 6 x2 y3 (12 A, A = x2 y3/2).
    let paper = [
        [-y3 * y3, y3 * (2.0 * x2 + x3), y3 * y3, y3 * (3.0 * x2 - x3), 0.0, x2 * y3],
        [
            y3 * (x3 - 2.0 * x2),
            x2 * x2 - x3 * x3,
            -y3 * (x2 + x3),
            x3 * (x3 - 2.0 * x2),
            -3.0 * x2 * y3,
            x2 * (2.0 * x3 - x2),
        ],
    ];
    // MITC3: edge shears e_r on 1-2, e_s on 1-3, c = their misfit with the third edge; centroid e_r
    // + c/3, e_s - c/3.
    let mitc3 = |node: usize, axis: usize| {
        let mut b = [[0.0; 2]; 3];
        b[node] = if axis == 0 { [0.0, -1.0] } else { [1.0, 0.0] };
        let along = |b: [f64; 2], x: [f64; 2]| b[0] * x[0] + b[1] * x[1];
        let (x21, x31, x32) = ([x2, 0.0], [x3, y3], [x3 - x2, y3]);
        let mean = |i: usize, j: usize, x| 0.5 * (along(b[i], x) + along(b[j], x));
        let (r, s, t) = (mean(0, 1, x21), mean(0, 2, x31), mean(1, 2, x32));
        let c = s - r - t;
        let (r, s) = (r + c / 3.0, s - c / 3.0);
        [r / x2, (s - x3 / x2 * r) / y3]
    };
    for node in 0..3 {
        for axis in 0..2 {
            let ours = shear_of(node, axis);
            for row in 0..2 {
                let why = "round-off";
                assert_close(ours[row], mitc3(node, axis)[row], 1e-9, why);
                assert_close(ours[row], paper[row][2 * node + axis] / (6.0 * x2 * y3), 1e-9, why);
            }
        }
    }
}

#[test]
fn bending_patch_is_exact() {
    // w = 1e-3 (x^2 + xy + y^2)/2 and its slopes, on a distorted triangle: no shear, and no spin of
    // the fibres.
    let mut patch = triangle(part(0.001), &NODES);
    for (x, (v, w)) in patch.x.iter().zip(patch.v.iter_mut().zip(&mut patch.w)) {
        let (x, y) = (x[0], x[1]);
        *v = [0.0, 0.0, 0.5e-10 * (x * x + x * y + y * y), 0.0];
        *w = [1e-10 * (0.5 * x + y), -1e-10 * (x + 0.5 * y), 0.0, 0.0];
    }
    patch.step(1.0);
    let lane = |column: usize| patch.history.element(0).at(column);
    let fields = patch.fields(0);
    assert!(
        fields.stress[4].abs() < 1e-19 * E && fields.stress[5].abs() < 1e-19 * E,
        "squared slopes: {fields:?}"
    );
    let free = lane(patch.element.columns() - 1);
    assert!(free.abs() < 1e-19 * E * 0.001, "squared slopes: {free:e}");
    // Principal curvatures of w are (1 +- 1/2) 1e-10 in any axes.
    let [sx, sy, t] = [0, 1, 2].map(|c| lane(5 + 4 * 3 + c) / 0.906179845938664);
    let radius = (0.25 * (sx - sy) * (sx - sy) + t * t).sqrt();
    let d = E / (1.0 - NU * NU) * 0.0005 * 1e-10;
    assert_close(0.5 * (sx + sy), -d * (1.0 + NU), 1e-5 * d, "squared slopes");
    assert_close(radius, 0.5 * d * (1.0 - NU), 1e-5 * d, "squared slopes");
}

/// The spin of the fibres has the stiffness that MITC3 has beyond its centroid, times the
/// coefficient.
#[test]
fn the_free_spin_is_resisted() {
    let r = 0.2;
    let size = 1e-7;
    let mut patch = triangle(part(0.1).with("hourglass_coefficient", r), &NODES);
    // Fibres rotate about the centroid: b = size (-(y - yc), x - xc), so tx = -b_y, ty = b_x.
    let centre: [f64; 2] = std::array::from_fn(|i| NODES.iter().map(|x| x[i]).sum::<f64>() / 3.0);
    for (w, x) in patch.w.iter_mut().zip(&NODES) {
        *w = [-size * (x[0] - centre[0]), -size * (x[1] - centre[1]), 0.0, 0.0];
    }
    let totals = patch.forces(1.0);
    let stress = patch.fields(0).stress;
    assert!(
        stress[4].abs() < 1e-14 * E && stress[5].abs() < 1e-14 * E,
        "round-off: no shear at the centroid"
    );
    let area = 0.5 * 1.2 * 0.9;
    let sides: f64 = [[0, 1], [1, 2], [2, 0]].iter().map(|&[a, b]| dist2(NODES[a], NODES[b])).sum();
    let g = SHEAR_CORRECTION * 0.5 * E / (1.0 + NU);
    // c = 2A size, strain c/2A times the distance from the centroid, whose mean square is sides/36.
    let exact = 0.5 * r * g * 0.1 * size * size * area * sides / 36.0;
    assert_close(totals.hourglass, exact, 1e-9 * exact, "round-off");
}

fn dist2(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum()
}

#[test]
fn numbering_does_not_matter() {
    let mut first = None;
    for turn in 0..3 {
        let order: [u32; 3] = std::array::from_fn(|c| ((c + turn) % 3) as u32);
        let part = part(0.05).with("drilling", 0.1);
        let cell = [[order[0], order[1], order[2], order[2]]];
        let mut patch = Patch::new(part, elastic(E, NU, 1.0), &NODES, &cell);
        for ((v, w), x) in patch.v.iter_mut().zip(&mut patch.w).zip(&NODES) {
            *w = [0.01 * x[0], 0.02 * x[1], 0.01, 0.0];
            *v = [0.01 * x[1], 0.0, 0.002 * x[0], 0.0];
        }
        (0..100).for_each(|_| _ = patch.step(1.0));
        let stress = patch.fields(0).stress;
        let stress0 = *first.get_or_insert(stress);
        for c in 0..6 {
            assert_close(stress[c], stress0[c], 1e-11 * E, "round-off over 100 steps");
        }
    }
}

/// The fourth corner repeats the third and gets no force.
#[test]
fn the_fourth_corner_is_left_alone() {
    let mut patch = triangle(part(0.1), &NODES);
    patch.v[1] = [0.01, 0.02, 0.03, 0.0];
    patch.w[2] = [0.01, 0.02, 0.03, 0.0];
    patch.step(1.0);
    assert!(patch.corner(0, 2).0 != [0.0; 3]);
    assert_eq!(patch.corner(0, 3), ([0.0; 3], [0.0; 3]));
}
