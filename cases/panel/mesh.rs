//! A quarter of a cylindrical panel of 120 degrees, along x, with the crown up. Morino, Leech and
//! Witmer (1971) loaded this panel by explosive. It has two planes of symmetry. Lengths in inches.
//!
//! Part 1 is covered by the explosive, half of the arc and 13/16 of the length; part 2 is the rest.
//! Node sets `side` and `end` are the supports, `middle` (x = 0) and `crown` (y = 0) the planes of
//! symmetry, `centre` the node on both.

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;
use std::f64::consts::FRAC_PI_3;

/// Half of the length, and the radius of the middle surface [inch].
#[expect(clippy::approx_constant, reason = "a length as published, no angle")]
const LENGTH: f64 = 6.28;
const RADIUS: f64 = 2.9375;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "panel",
    options: &[("eighths", 1.0, "quads in an eighth of half the arc, 1 to 16")],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let eighths = options.count("eighths", 1..=16, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    // For any number, quads are square and the edges of the explosive are between quads.
    let (around, along) = (8 * eighths, 16 * eighths);
    let mut mesh = Builder::default();
    let rows: Vec<Vec<usize>> = (0..=along)
        .map(|i| {
            let x = LENGTH * i as f64 / along as f64;
            let angle = |j: usize| FRAC_PI_3 * j as f64 / around as f64;
            (0..=around)
                .map(|j| mesh.point([x, RADIUS * angle(j).sin(), RADIUS * angle(j).cos()]))
                .collect()
        })
        .collect();
    for (i, pair) in rows.windows(2).enumerate() {
        let covered = if i < 13 * eighths { around / 2 } else { 0 };
        let (near, far) = (&pair[0], &pair[1]);
        mesh.strip(1, &near[..=covered], &far[..=covered], false);
        mesh.strip(2, &near[covered..], &far[covered..], false);
    }
    mesh.set("middle", rows[0].iter().copied());
    mesh.set("end", rows[along].iter().copied());
    mesh.set("crown", rows.iter().map(|row| row[0]));
    mesh.set("side", rows.iter().map(|row| row[around]));
    mesh.set("centre", [rows[0][0]]);
    Ok(mesh.finish(LENGTH / along as f64))
}
