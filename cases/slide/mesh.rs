//! A block of 20 x 20 x 10 mm on a flat base of shells, 80 x 40 mm. The base is rotated so that no
//! lines of the meshes match.
//!
//! Parts: 1 base, 2 block. Node sets: `base`, `block`, `top` and `foot` of the block.

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// Base along x and y, and the block [mm].
const BASE: [f64; 2] = [80.0, 40.0];
const BLOCK: [f64; 3] = [20.0, 20.0, 10.0];

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "slide",
    options: &[
        ("facets", 8.0, "number of quads along the base, 2 to 512; half this number across"),
        (
            "cells",
            2.0,
            "solids along the block, 1 to 128; half this number, at least one, over its height",
        ),
        ("turn", 7.0, "rotation of the base about z [degree]"),
        ("thickness", 2.0, "thickness of the base, as in its part [mm]"),
        (
            "gap",
            0.0,
            "gap between the upper side of the base and the block; negative: penetration [mm]",
        ),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let facets = options.count("facets", 2..=512, &mut wrong);
    let cells = options.count("cells", 1..=128, &mut wrong);
    let (sin, cos) = options.real("turn", -180.0..=180.0, &mut wrong).to_radians().sin_cos();
    let thickness = options.real("thickness", 1e-6..=1e3, &mut wrong);
    let gap = options.real("gap", -1e3..=1e3, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let mut mesh = Builder::default();
    let across = facets / 2;
    let rows: Vec<Vec<usize>> = (0..=across)
        .map(|j| {
            (0..=facets)
                .map(|i| {
                    let x = BASE[0] * (i as f64 / facets as f64 - 0.25);
                    let y = BASE[1] * (j as f64 / across as f64 - 0.5);
                    mesh.point([cos * x - sin * y, sin * x + cos * y, -0.5 * thickness - gap])
                })
                .collect()
        })
        .collect();
    rows.windows(2).for_each(|pair| mesh.strip(1, &pair[1], &pair[0], false));
    let high = (cells / 2).max(1);
    let block = mesh.block(2, [cells, cells, high], |[i, j, k]| {
        let part = |n: usize, of: usize| n as f64 / of as f64;
        [
            BLOCK[0] * (part(i, cells) - 0.5),
            BLOCK[1] * (part(j, cells) - 0.5),
            BLOCK[2] * part(k, high),
        ]
    });
    mesh.set("base", rows.into_iter().flatten());
    mesh.set("block", block.all());
    mesh.set("top", block.face(2, true));
    mesh.set("foot", block.face(2, false));
    Ok(mesh.finish(BASE[0] / facets as f64))
}
