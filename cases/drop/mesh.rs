//! Small loose plates fall on the middle of one large shell: many slave nodes on one segment.
//! Lengths have no unit.
//!
//! Node sets `base` and `plates`; parts 1 and 2. The plates are side by side in a square around the
//! centre of the shell.

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// Side of the large shell, of a plate, and of the square reserved for a plate.
const BASE: f64 = 20.0;
const PLATE: f64 = 1.0;
const PITCH: f64 = 1.6;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "drop",
    options: &[
        ("plates", 4.0, "number of small plates with four nodes each, 1 to 64"),
        ("height", 0.45, "height of the middle planes of the plates above that of the shell"),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let plates = options.count("plates", 1..=64, &mut wrong);
    let height = options.real("height", 1e-6..=1e5, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let mut mesh = Builder::default();
    let mut square = |part: u32, centre: [f64; 2], side: f64, z: f64| {
        let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        let nodes =
            corners.map(|c| mesh.point([centre[0] + side * c[0], centre[1] + side * c[1], z]));
        mesh.quad(part, nodes);
        mesh.set(if part == 1 { "base" } else { "plates" }, nodes);
    };
    square(1, [0.0, 0.0], BASE, 0.0);
    let row = (1..).find(|n| n * n >= plates).unwrap_or(1);
    let at = |n: usize| PITCH * (n as f64 - 0.5 * (row - 1) as f64);
    (0..plates).for_each(|n| square(2, [at(n % row), at(n / row)], PLATE, height));
    Ok(mesh.finish(PLATE))
}
