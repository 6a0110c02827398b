//! Two equal bars end to end in the plane, along x: strips of square shells. Lengths in mm.
//!
//! Node sets `one` and `two`; parts 1 and 2.

use crate::builder::Builder;
use crate::{Generator, OptionRow, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator { name: "bars", options: OPTIONS, build };

const OPTIONS: &[OptionRow] = &[
    ("elements", 40.0, "shells along each bar, 2 to 2000"),
    ("length", 100.0, "length of a bar [mm]"),
    ("distance", 0.200001, "between the ends that meet; their surfaces touch at the thickness of the shells [mm]"),
];

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let elements = options.count("elements", 2..=2000, &mut wrong);
    let length = options.real("length", 1.0..=1e5, &mut wrong);
    let distance = options.real("distance", 0.0..=1e5, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let side = length / elements as f64;
    let mut mesh = Builder::default();
    for (part, from, name) in [(1, 0.0, "one"), (2, length + distance, "two")] {
        let mut row =
            |y: f64| -> Vec<usize> { (0..=elements).map(|i| mesh.point([from + side * i as f64, y, 0.0])).collect() };
        let (low, high) = (row(0.0), row(side));
        mesh.strip(part, &high, &low, false);
        mesh.set(name, low.into_iter().chain(high));
    }
    Ok(mesh.finish(side))
}
