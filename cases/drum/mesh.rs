//! A cube of 8 mm slides on the inner side of a drum of flat shells, of radius 100 mm, about the y
//! axis.
//!
//! Parts: 1 drum, 2 block. Node sets: `drum`, `block`.

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;
use std::f64::consts::{PI, TAU};

/// Radius and width of the drum, and side of the block [mm].
const RADIUS: f64 = 100.0;
const WIDTH: f64 = 40.0;
const SIDE: f64 = 8.0;
/// Rows of shells over the width.
const ROWS: usize = 4;
/// Gap between the drum and the block [mm].
const GAP: f64 = 0.02;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "drum",
    options: &[
        ("facets", 72.0, "number of shells around the drum, 12 to 720"),
        ("thickness", 2.0, "thickness of the drum, as in its part [mm]"),
        ("turn", 7.0, "rotation of the block about the radius [degree]"),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let facets = options.count("facets", 12..=720, &mut wrong);
    let thickness = options.real("thickness", 1e-6..=50.0, &mut wrong);
    let (sin, cos) = options.real("turn", -180.0..=180.0, &mut wrong).to_radians().sin_cos();
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let mut mesh = Builder::default();
    let rows: Vec<Vec<usize>> = (0..=ROWS)
        .map(|j| {
            let y = WIDTH * (j as f64 / ROWS as f64 - 0.5);
            (0..facets)
                .map(|k| {
                    // The block starts over the middle of a facet.
                    let (s, c) = (TAU * (k as f64 + 0.5) / facets as f64).sin_cos();
                    mesh.point([RADIUS * s, y, -RADIUS * c])
                })
                .collect()
        })
        .collect();
    rows.windows(2).for_each(|pair| mesh.strip(1, &pair[0], &pair[1], true));
    // The facets are chords, and the corners of the block touch them.
    let chord = RADIUS * (PI / facets as f64).cos() - 0.5 * thickness;
    let foot = -(chord * chord - 0.5 * SIDE * SIDE).sqrt() + GAP;
    let block = mesh.block(2, [1; 3], |[i, j, k]| {
        let [x, y] = [i, j].map(|n| SIDE * (n as f64 - 0.5));
        [cos * x - sin * y, sin * x + cos * y, foot + SIDE * k as f64]
    });
    mesh.set("drum", rows.into_iter().flatten());
    mesh.set("block", block.all());
    Ok(mesh.finish(TAU * RADIUS / facets as f64))
}
