//! Half of the lower side of a cylinder above a plane, one cell deep: plane strain. The axis is y.
//! x = 0 is a plane of symmetry; the plane is below z = 0. Lengths in mm.
//!
//! Parts: 1 body, 2 base. Node sets: `body`, `base`, `middle` (x = 0), `top`.

use crate::builder::{Builder, graded};
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// Size of the cells of the base over that of the smallest cells of the body.
const COARSE: f64 = 1.3;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "hertz",
    options: &[
        ("radius", 10.0, "radius of the cylinder [mm]"),
        ("half_width", 0.2349, "expected half width of the contact [mm]"),
        ("size", 10.0, "width and height of the body, in half widths, 4 to 20"),
        ("cells", 4.0, "number of cells on the half width, 1 to 64"),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let radius = options.real("radius", 1e-3..=1e6, &mut wrong);
    let half = options.real("half_width", 1e-6..=1e5, &mut wrong);
    let size = options.real("size", 4.0..=20.0, &mut wrong) * half;
    let cells = options.count("cells", 1..=64, &mut wrong);
    if wrong.is_empty() && size >= radius {
        wrong.push(Problem::error(
            "scene.size",
            format!("the body is {size} wide, not less than its radius {radius}"),
            "give a smaller `size` or `half_width`",
        ));
    }
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let first = half / cells as f64;
    let (along, up) = (graded(first, 3 * cells / 2, size), graded(first, 1, size));
    let deep = 2.0 * first;
    let mut mesh = Builder::default();
    let body = mesh.block(1, [along.len() - 1, 1, up.len() - 1], |[i, j, k]| {
        let (x, z) = (along[i], up[k] / size);
        let low = radius - (radius * radius - x * x).sqrt();
        [x, deep * j as f64, low + (size - low) * z]
    });
    let coarse = COARSE * first;
    let count = (2.5 * half / coarse).ceil() as usize;
    let base = mesh.block(2, [count, 1, 1], |[i, j, k]| {
        [coarse * (i as f64 - 0.4), deep * (2.0 * j as f64 - 0.5), coarse * (k as f64 - 1.0)]
    });
    mesh.set("body", body.all());
    mesh.set("base", base.all());
    mesh.set("middle", body.face(0, false));
    mesh.set("top", body.face(2, true));
    Ok(mesh.finish(first))
}
