//! Two equal bars end to end along x: strips of square shells in the plane, or cubes with a given
//! number across. Lengths in mm.
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
    (
        "distance",
        0.200001,
        "distance of the facing ends; surfaces touch at the thickness of the shells [mm]",
    ),
    ("across", 0.0, "solids across a bar, up to 20; 0 for shells"),
    ("shift", 0.0, "shift of the second bar across the first, in element sides, 0 to 1"),
];

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let elements = options.count("elements", 2..=2000, &mut wrong);
    let length = options.real("length", 1.0..=1e5, &mut wrong);
    let distance = options.real("distance", 0.0..=1e5, &mut wrong);
    let across = options.count("across", 0..=20, &mut wrong);
    let shift = options.real("shift", 0.0..=1.0, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let side = length / elements as f64;
    let mut mesh = Builder::default();
    for (part, from, off, name) in
        [(1, 0.0, 0.0, "one"), (2, length + distance, shift * side, "two")]
    {
        if across > 0 {
            let place = |[i, j, k]: [usize; 3]| {
                [from + side * i as f64, off + side * j as f64, off + side * k as f64]
            };
            let bar = mesh.block(part, [elements, across, across], place);
            mesh.set(name, bar.all());
            continue;
        }
        let mut row = |y: f64| -> Vec<usize> {
            (0..=elements).map(|i| mesh.point([from + side * i as f64, off + y, 0.0])).collect()
        };
        let (low, high) = (row(0.0), row(side));
        mesh.strip(part, &high, &low, false);
        mesh.set(name, low.into_iter().chain(high));
    }
    Ok(mesh.finish(side))
}
