//! A beam twisted by a right angle from root to tip, of MacNeal and Harder (1985): 12 x 1.1 inch
//! along x. Its quads are warped in every mesh.
//!
//! Node sets `root` and `tip`.

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;
use std::f64::consts::FRAC_PI_2;

/// Length and width [inch].
const LENGTH: f64 = 12.0;
const WIDTH: f64 = 1.1;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "twist",
    options: &[("across", 2.0, "quads across, 1 to 64; six times this number along")],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let across = options.count("across", 1..=64, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let along = 6 * across;
    let mut mesh = Builder::default();
    let rows: Vec<Vec<usize>> = (0..=along)
        .map(|i| {
            let part = i as f64 / along as f64;
            let (sin, cos) = (FRAC_PI_2 * part).sin_cos();
            let width = |j: usize| WIDTH * (j as f64 / across as f64 - 0.5);
            (0..=across)
                .map(|j| mesh.point([LENGTH * part, width(j) * cos, width(j) * sin]))
                .collect()
        })
        .collect();
    rows.windows(2).for_each(|pair| mesh.strip(1, &pair[0], &pair[1], false));
    mesh.set("root", rows[0].iter().copied());
    mesh.set("tip", rows[along].iter().copied());
    Ok(mesh.finish(LENGTH / along as f64))
}
