//! A flat bag of two rectangular sheets, sewn at their rims and folded once in the middle. Lengths
//! in mm.
//!
//! Parts 1 (inner sheet of the fold) and 2 (outer sheet); sets `bag` and `rim`. The fold is at
//! x = 0, with two flaps along +x, one above the other; the width is along y.

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;
use std::f64::consts::PI;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "airbag",
    options: &[
        ("length", 300.0, "length of the unfolded bag [mm]"),
        ("width", 200.0, "width of the bag [mm]"),
        ("gap", 2.0, "distance of the two sheets [mm]"),
        ("radius", 4.0, "radius of the fold, more than half the gap [mm]"),
        ("along", 12.0, "number of shells along each flap, 2 to 1000"),
        ("arc", 4.0, "number of shells around the fold, 2 to 100"),
        ("across", 16.0, "number of shells across the width, 2 to 1000"),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let length = options.real("length", 1e-6..=1e6, &mut wrong);
    let width = options.real("width", 1e-6..=1e6, &mut wrong);
    let gap = options.real("gap", 1e-6..=1e6, &mut wrong);
    let radius = options.real("radius", 1e-6..=1e6, &mut wrong);
    let along = options.count("along", 2..=1000, &mut wrong);
    let arc = options.count("arc", 2..=100, &mut wrong);
    let across = options.count("across", 2..=1000, &mut wrong);
    let flap = 0.5 * (length - PI * radius);
    if wrong.is_empty() && (flap <= 0.0 || 2.0 * radius <= gap) {
        let message = format!("a fold of radius {radius} does not fit the bag");
        let help = "its arc has to be shorter than the bag, and its diameter larger than the gap";
        wrong.push(Problem::error("scene.radius", message, help));
    }
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let mut mesh = Builder::default();
    let count = 2 * along + arc;
    // Place of a point of the middle surface, and its normal towards the outer sheet.
    let middle = |i: usize| -> ([f64; 2], [f64; 2]) {
        if i < along {
            ([flap * (along - i) as f64 / along as f64, -radius], [0.0, -1.0])
        } else if i <= along + arc {
            let (sin, cos) = (PI * (i - along) as f64 / arc as f64).sin_cos();
            ([-radius * sin, -radius * cos], [-sin, -cos])
        } else {
            ([flap * (i - along - arc) as f64 / along as f64, radius], [0.0, 1.0])
        }
    };
    let is_rim = |i: usize, j: usize| i == 0 || i == count || j == 0 || j == across;
    let mut point = |i: usize, j: usize, side: f64| {
        let ([x, z], [nx, nz]) = middle(i);
        let half = if is_rim(i, j) { 0.0 } else { 0.5 * side * gap };
        mesh.point([x + half * nx, width * (j as f64 / across as f64 - 0.5), z + half * nz])
    };
    let rows = |of: &mut dyn FnMut(usize, usize) -> usize| -> Vec<Vec<usize>> {
        (0..=count).map(|i| (0..=across).map(|j| of(i, j)).collect()).collect()
    };
    let inner = rows(&mut |i, j| point(i, j, -1.0));
    let outer = rows(&mut |i, j| if is_rim(i, j) { inner[i][j] } else { point(i, j, 1.0) });
    for i in 0..count {
        mesh.strip(1, &inner[i + 1], &inner[i], false);
        mesh.strip(2, &outer[i], &outer[i + 1], false);
    }
    for i in 0..=count {
        for j in 0..=across {
            mesh.set("bag", [inner[i][j]]);
            if is_rim(i, j) {
                mesh.set("rim", [inner[i][j]]);
            } else {
                mesh.set("bag", [outer[i][j]]);
            }
        }
    }
    Ok(mesh.finish(flap / along as f64))
}
