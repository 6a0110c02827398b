//! Static benchmarks of shells (verification B09, A21): what each formulation reaches of the known displacements.

use super::statics::Statics;
use super::testing::*;
use crumple_proto::job::Part;

/// A part of a formulation, with the hourglass coefficient of the reference table.
fn shell(element: &str, thickness: f64) -> Part {
    Part { element: element.into(), hourglass_coefficient: 0.02, ..part(thickness) }
}

/// Nodes of a grid of `nx` by `ny` elements put where `at` says, from fractions of both directions.
fn surface(nx: usize, ny: usize, at: impl Fn(f64, f64) -> [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 4]>) {
    let (flat, quads) = grid(nx, ny, 1.0, 1.0);
    (flat.iter().map(|x| at(x[0], x[1])).collect(), quads)
}

/// Strip of length 12 and width 1.1, twisted by a right angle; tip displacement over the known one, for a load in
/// the direction of its width at the tip (z) and across it (y).
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
        let mut statics = Statics::new(shell(element, thickness), elastic(29e6, 0.22, 1.0), &nodes, &quads);
        (0..=ny).for_each(|node| statics.fix(node, &[0, 1, 2, 3, 4, 5]));
        statics.load[6 * tip + direction] = load;
        statics.solve()[tip][direction] / known[2 - direction]
    })
}

/// Quarter of the roof of Scordelis & Lo under its weight: the free edge at mid-length sinks by 0.3024.
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

/// Quarter of a hemisphere with a hole of 18 degrees, pulled and pushed by unit loads: 0.093 under each.
fn hemisphere(element: &str, n: usize) -> f64 {
    let (nodes, quads) = surface(n, n, |r, s| {
        let (sin, cos) = (s * std::f64::consts::FRAC_PI_2).sin_cos();
        let (up, out) = (r * 72_f64.to_radians()).sin_cos();
        [10.0 * out * cos, 10.0 * out * sin, 10.0 * up]
    });
    let mut statics = Statics::new(shell(element, 0.04), elastic(6.825e7, 0.3, 1.0), &nodes, &quads);
    for r in 0..=n {
        statics.fix(r, &[1, 3, 5]);
        statics.fix(n * (n + 1) + r, &[0, 4, 5]);
    }
    statics.fix(0, &[2]);
    statics.load[0] = 1.0;
    statics.load[6 * n * (n + 1) + 1] = -1.0;
    statics.solve()[0][0] / 0.093
}

#[test]
fn figures() {
    for element in ["belytschko_tsay", "stabilised_quad"] {
        for n in [8, 16] {
            println!("{element} {n}: roof {:.4} cylinder {:.4} hemisphere {:.4}", roof(element, n), cylinder(element, n), hemisphere(element, n));
        }
        for nx in [24, 48] {
            println!("{element} {nx}: thick {:.4?} thin {:.4?}", twisted_beam(element, 0.32, nx), twisted_beam(element, 0.0032, nx));
        }
    }
}
