//! Static benchmarks of shells (verification B09, A21): displacements of each formulation over the
//! known ones.

use super::statics::Statics;
use super::testing::*;
use crumple_proto::job::Part;

/// Returns a part of a formulation, with the hourglass coefficient of the reference table.
fn shell(element: &str, thickness: f64) -> Part {
    part_of(element, thickness).with("hourglass_coefficient", 0.02)
}

/// Returns the nodes of a grid of `nx` by `ny` elements; `at` gives the coordinates for fractions
/// of both directions.
fn surface(
    nx: usize,
    ny: usize,
    at: impl Fn(f64, f64) -> [f64; 3],
) -> (Vec<[f64; 3]>, Vec<[u32; 4]>) {
    let (flat, quads) = grid(nx, ny, 1.0, 1.0);
    (flat.iter().map(|x| at(x[0], x[1])).collect(), quads)
}

/// Returns tip displacements over the known ones, of a strip of length 12 and width 1.1 that is
/// twisted by a right angle, for a load in the direction of its width at the tip (z) and across it
/// (y).
fn twisted_beam(element: &str, thickness: f64, nx: usize) -> [f64; 2] {
    let ny = nx / 6;
    let (nodes, quads) = surface(ny, nx, |s, r| {
        let (sin, cos) = (r * std::f64::consts::FRAC_PI_2).sin_cos();
        [12.0 * r, 1.1 * (s - 0.5) * cos, 1.1 * (s - 0.5) * sin]
    });
    let (load, known) =
        if thickness > 0.1 { (1.0, [5.4245e-3, 1.7532e-3]) } else { (1e-6, [5.256e-3, 1.294e-3]) };
    let tip = nx * (ny + 1) + ny / 2;
    [2, 1].map(|direction| {
        let mut statics =
            Statics::new(shell(element, thickness), elastic(29e6, 0.22, 1.0), &nodes, &quads);
        (0..=ny).for_each(|node| statics.fix(node, &[0, 1, 2, 3, 4, 5]));
        statics.load[6 * tip + direction] = load;
        statics.solve()[tip][direction] / known[2 - direction]
    })
}

/// Quarter of the roof of Scordelis & Lo under its weight: the free edge at mid-length moves down
/// by 0.3024.
fn roof(element: &str, n: usize) -> f64 {
    let (nodes, quads) = surface(n, n, |r, s| {
        let (sin, cos) = (s * 40_f64.to_radians()).sin_cos();
        [25.0 * r, 25.0 * sin, 25.0 * cos]
    });
    let mut statics = Statics::new(shell(element, 0.25), elastic(4.32e8, 0.0, 1.0), &nodes, &quads);
    let share = |k: usize| if k == 0 || k == n { 0.5 } else { 1.0 };
    let chord = 50.0 * (20_f64.to_radians() / n as f64).sin();
    for node in 0..nodes.len() {
        let (i, j) = (node % (n + 1), node / (n + 1));
        statics.load[6 * node + 2] = -90.0 * 25.0 / n as f64 * chord * share(i) * share(j);
        if i == 0 {
            statics.fix(node, &[0, 4, 5]);
        }
        if i == n {
            statics.fix(node, &[1, 2]);
        }
        if j == 0 {
            statics.fix(node, &[1, 3, 5]);
        }
    }
    -statics.solve()[n * (n + 1)][2] / 0.3024
}

/// Octant of a cylinder with diaphragms, pinched by two unit loads: 1.82488e-5 under each.
fn cylinder(element: &str, n: usize) -> f64 {
    let (nodes, quads) = surface(n, n, |r, s| {
        let (sin, cos) = (s * std::f64::consts::FRAC_PI_2).sin_cos();
        [300.0 * r, 300.0 * sin, 300.0 * cos]
    });
    let mut statics = Statics::new(shell(element, 3.0), elastic(3e6, 0.3, 1.0), &nodes, &quads);
    for node in 0..nodes.len() {
        let (i, j) = (node % (n + 1), node / (n + 1));
        if i == 0 {
            statics.fix(node, &[0, 4, 5]);
        }
        if i == n {
            statics.fix(node, &[1, 2]);
        }
        if j == 0 {
            statics.fix(node, &[1, 3, 5]);
        }
        if j == n {
            statics.fix(node, &[2, 3, 4]);
        }
    }
    statics.load[2] = -0.25;
    -statics.solve()[0][2] / 1.82488e-5
}

/// Quarter of a hemisphere with a hole of 18 degrees, loaded by unit forces outwards and inwards:
/// 0.093 under each.
fn hemisphere(element: &str, n: usize) -> f64 {
    let (nodes, quads) = surface(n, n, |r, s| {
        let (sin, cos) = (s * std::f64::consts::FRAC_PI_2).sin_cos();
        let (up, out) = (r * 72_f64.to_radians()).sin_cos();
        [10.0 * out * cos, 10.0 * out * sin, 10.0 * up]
    });
    let mut statics =
        Statics::new(shell(element, 0.04), elastic(6.825e7, 0.3, 1.0), &nodes, &quads);
    for r in 0..=n {
        statics.fix(r, &[1, 3, 5]);
        statics.fix(n * (n + 1) + r, &[0, 4, 5]);
    }
    statics.fix(0, &[2]);
    statics.load[0] = 1.0;
    statics.load[6 * n * (n + 1) + 1] = -1.0;
    statics.solve()[0][0] / 0.093
}

/// Results of a formulation on finer and finer meshes.
struct Benchmark {
    element: &'static str,
    /// Roof, cylinder and hemisphere at 8 and 16 elements a side.
    curved: [[f64; 3]; 2],
    /// Twisted beam, thick and thin, loads along z and y, at 12 and 24 elements along it.
    twisted: [[[f64; 2]; 2]; 2],
}

/// Displacements over the known ones. The table of B09 has for Belytschko-Tsay 1.040, .806, .978
/// and 1.007, .960, 1.005 on the curved ones. Its values for the thin twisted strip (.003 to .012)
/// are due to hourglass rates that the rigid rotation of a warped element excites, which ours
/// exclude. MITC4, which has the same shear as the stabilised shell, is known to reach about .74
/// and .93 in the cylinder. The 3 % in the thick beam are due to the soft drilling of 0.01; 0.1
/// reduces them to less than 1 %, and lowers the hemisphere by as much at 16, by more at 8.
const ROWS: [Benchmark; 3] = [
    Benchmark {
        element: "belytschko_tsay",
        curved: [[1.0398, 0.8058, 0.9777], [1.0065, 0.9604, 1.0054]],
        twisted: [[[1.0307, 1.0779], [0.7126, 0.9080]], [[1.0300, 1.0361], [0.9775, 0.9939]]],
    },
    Benchmark {
        element: "stabilised_quad",
        curved: [[1.0072, 0.7621, 0.9609], [0.9996, 0.9395, 1.0002]],
        twisted: [[[1.0298, 1.0152], [1.0083, 0.9916]], [[1.0301, 1.0231], [0.9987, 0.9967]]],
    },
    Benchmark {
        element: "fully_integrated_quad",
        curved: [[1.0072, 0.7621, 0.9609], [0.9996, 0.9395, 1.0002]],
        twisted: [[[1.0298, 1.0152], [1.0083, 0.9916]], [[1.0301, 1.0231], [0.9987, 0.9967]]],
    },
];

#[test]
fn curved_shells_sink_as_far_as_known() {
    for row in &ROWS {
        for (n, wanted) in [8, 16].into_iter().zip(row.curved) {
            let found =
                [roof(row.element, n), cylinder(row.element, n), hemisphere(row.element, n)];
            for (found, wanted) in found.into_iter().zip(wanted) {
                assert_close(
                    found,
                    wanted,
                    2e-4,
                    &format!("{} at {n}: rounding of the reference values", row.element),
                );
            }
        }
    }
}

#[test]
fn twisted_beams_do_not_lock() {
    for row in &ROWS {
        for (nx, wanted) in [12, 24].into_iter().zip(row.twisted) {
            for (thickness, wanted) in [0.32, 0.0032].into_iter().zip(wanted) {
                for (found, wanted) in
                    twisted_beam(row.element, thickness, nx).into_iter().zip(wanted)
                {
                    let why = format!(
                        "{} at {nx}, t {thickness}: rounding of the reference values",
                        row.element
                    );
                    assert_close(found, wanted, 2e-4, &why);
                }
            }
        }
    }
}

/// Verification A21: bending of the distorted patch, `w = (x^2 + xy + y^2)/2` on its border, to the
/// stress of `-(1 + nu) D`, and `(1 - nu)/2` of it in twist.
#[test]
fn bending_patch_is_exact_where_shear_is_projected() {
    let inner = [[0.04, 0.02], [0.18, 0.03], [0.16, 0.08], [0.08, 0.08]];
    let outer = [[0.0, 0.0], [0.24, 0.0], [0.24, 0.12], [0.0, 0.12]];
    let nodes: Vec<[f64; 3]> = outer.iter().chain(&inner).map(|p| [p[0], p[1], 0.0]).collect();
    let quads = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]];
    let off = |element: &str| {
        let statics = Statics::new(shell(element, 0.001), elastic(1e6, 0.25, 1.0), &nodes, &quads);
        let field = |node: usize| {
            let [x, y, _] = nodes[node];
            [0.0, 0.0, 0.5 * (x * x + x * y + y * y), 0.5 * x + y, -(x + 0.5 * y), 0.0]
        };
        let found = statics.hold(4, field);
        let wanted: Vec<[f64; 6]> = (0..8).map(field).collect();
        let pairs = found[4..].iter().flatten().zip(wanted[4..].iter().flatten());
        pairs.map(|(found, wanted)| (found - wanted).abs()).fold(0.0, f64::max)
    };
    for element in ["stabilised_quad", "fully_integrated_quad"] {
        let projected = off(element);
        assert!(
            projected < 1e-9,
            "{element}: round-off over (L/t)^2 of 6e4, in slopes of 0.3: {projected:e}"
        );
    }
    let plain = off("belytschko_tsay");
    assert!(plain > 0.01, "the shell without projection is known to fail: {plain:e}");
}
