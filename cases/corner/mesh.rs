//! A cube of 10 mm in front of two fixed walls of shells that meet at the line x = y = 0: a
//! re-entrant corner. Lengths in mm.
//!
//! Parts: 1 walls, 2 cube. Node sets: `walls`, `cube`.

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;
use std::f64::consts::FRAC_PI_4;

/// Width and height of a wall, side of the cube [mm].
const WALL: f64 = 30.0;
const CUBE: f64 = 10.0;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "corner",
    options: &[
        (
            "angle",
            90.0,
            "angle between the walls, half of it on each side of the x axis, 20 to 160 [degree]",
        ),
        ("turn", 0.0, "rotation of the cube about z; at 0 an edge points into the corner [degree]"),
        ("facets", 6.0, "quads over the width of a wall, 1 to 128"),
        ("cells", 2.0, "solids over a side of the cube, 1 to 64"),
        ("thickness", 1.0, "thickness of the walls, as in their part [mm]"),
        ("gap", 0.5, "distance of the cube along x until contact [mm]"),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let half = 0.5 * options.real("angle", 20.0..=160.0, &mut wrong).to_radians();
    let turn = options.real("turn", -360.0..=360.0, &mut wrong).to_radians();
    let facets = options.count("facets", 1..=128, &mut wrong);
    let cells = options.count("cells", 1..=64, &mut wrong);
    let thickness = options.real("thickness", 1e-3..=10.0, &mut wrong);
    let gap = options.real("gap", 1e-9..=10.0, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let mut mesh = Builder::default();
    // From one rim to the corner and to the other rim.
    let columns: Vec<Vec<usize>> = (0..=2 * facets)
        .map(|i| {
            let along = WALL * (i as f64 / facets as f64 - 1.0);
            let (sin, cos) = half.sin_cos();
            let (x, y) = (along.abs() * cos, along * sin);
            (0..=facets)
                .map(|k| mesh.point([x, y, WALL * (k as f64 / facets as f64 - 0.5)]))
                .collect()
        })
        .collect();
    columns.windows(2).for_each(|pair| mesh.strip(1, &pair[0], &pair[1], false));
    // Rotated so that an edge points along -x, then by `turn`: corners of the section around its
    // centre.
    let (sin, cos) = (turn + FRAC_PI_4).sin_cos();
    let place = |x: f64, y: f64| [cos * x - sin * y, sin * x + cos * y];
    let h = 0.5 * CUBE;
    let reach = [[-h, -h], [h, -h], [h, h], [-h, h]].map(|[x, y]| {
        let [x, y] = place(x, y);
        // Distance along x of the corner from the line through a wall if the centre is at x = 0.
        let near = |y: f64| (0.5 * thickness + half.cos() * y) / half.sin() - x;
        near(y).max(near(-y))
    });
    let centre = gap + reach.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let cube = mesh.block(2, [cells; 3], |ijk| {
        let [x, y, z] = ijk.map(|n| CUBE * (n as f64 / cells as f64 - 0.5));
        let [x, y] = place(x, y);
        [x + centre, y, z]
    });
    mesh.set("walls", columns.into_iter().flatten());
    mesh.set("cube", cube.all());
    Ok(mesh.finish(CUBE / cells as f64))
}
