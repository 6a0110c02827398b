//! A box of solids from the origin. Lengths in mm.
//!
//! Node sets: `left` and `right` (ends along x), `front` and `back` (along y), `bottom` and `top`
//! (along z).

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "block",
    options: &[
        ("length", 10.0, "length along x [mm]"),
        ("width", 10.0, "width along y [mm]"),
        ("height", 10.0, "height along z [mm]"),
        ("along", 4.0, "solids along x, 1 to 512"),
        ("across", 4.0, "solids along y, 1 to 512"),
        ("high", 4.0, "solids along z, 1 to 512"),
        ("refine", 1.0, "factor on each of the three counts, 1 to 64"),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let size = ["length", "width", "height"].map(|key| options.real(key, 1e-3..=1e6, &mut wrong));
    let refine = options.count("refine", 1..=64, &mut wrong);
    let count =
        ["along", "across", "high"].map(|key| refine * options.count(key, 1..=512, &mut wrong));
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let mut mesh = Builder::default();
    let block =
        mesh.block(1, count, |ijk| [0, 1, 2].map(|c| size[c] * ijk[c] as f64 / count[c] as f64));
    for (axis, names) in
        [["left", "right"], ["front", "back"], ["bottom", "top"]].into_iter().enumerate()
    {
        for (name, end) in names.into_iter().zip([false, true]) {
            mesh.set(name, block.face(axis, end));
        }
    }
    Ok(mesh.finish(size[0] / count[0] as f64))
}
