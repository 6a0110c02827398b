//! A box of solids from the origin. Lengths in mm.
//!
//! Node sets: `left` and `right` (ends along x), `front` and `back` (along y), `bottom` and `top`
//! (along z).

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::{Mesh, Shape};
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
        (
            "nodes",
            8.0,
            "nodes of an element: 8, or cubes cut into tetrahedra (4 or 10) or wedges (6)",
        ),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let size = ["length", "width", "height"].map(|key| options.real(key, 1e-3..=1e6, &mut wrong));
    let refine = options.count("refine", 1..=64, &mut wrong);
    let count =
        ["along", "across", "high"].map(|key| refine * options.count(key, 1..=512, &mut wrong));
    let nodes = options.count("nodes", 4..=10, &mut wrong);
    let shapes = [Shape::Tet4, Shape::Wedge6, Shape::Hex8, Shape::Tet10];
    let shape = shapes.into_iter().find(|shape| shape.corners() == nodes);
    if shape.is_none() {
        let message = format!("`nodes` = {nodes} is no number of nodes of a solid");
        wrong.push(Problem::error("scene.nodes", message, "give 4, 6, 8 or 10"));
    }
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let mut mesh = Builder::default();
    let block =
        mesh.block(1, count, |ijk| [0, 1, 2].map(|c| size[c] * ijk[c] as f64 / count[c] as f64));
    mesh.cut(shape.unwrap_or(Shape::Hex8));
    for (axis, names) in
        [["left", "right"], ["front", "back"], ["bottom", "top"]].into_iter().enumerate()
    {
        for (name, end) in names.into_iter().zip([false, true]) {
            let on_face = mesh.plane(axis, block.face(axis, end)[0]);
            mesh.set(name, on_face);
        }
    }
    Ok(mesh.finish(size[0] / count[0] as f64))
}
