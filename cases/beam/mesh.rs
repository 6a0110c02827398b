//! The vibrating beam of PRONTO3D (Attaway et al. 1994; after Flanagan & Belytschko 1981): half of
//! a beam under a step pressure, in plane strain. x runs from the pinned end to the symmetry plane,
//! y across the beam, z upwards.
//!
//! Published: 19,500 elements and 22,506 nodes, the counts of 65 x 30 x 10 elements, and 6480
//! elements per worker for the scaled problem, here 54 x 12 x 10 side by side. Lengths are not
//! published: cubes of 5 mm.

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// Node sets: `pinned` (the line at mid-height of the outer end), `middle` (symmetry plane),
/// `sides` (front and back), `top`, `tip` (mid-height line of the symmetry plane).
pub const GENERATOR: Generator = Generator {
    name: "beam",
    options: &[
        (
            "scale",
            0.0,
            "number of workers with 6480 elements each; 0: fixed-size problem with 19,500",
        ),
        ("side", 5.0, "side of the cubes [mm]"),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let scale = options.count("scale", 0..=1024, &mut wrong);
    let side = options.real("side", 1e-3..=1e3, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let (along, height) = if scale == 0 { (65, 10) } else { (54, 10) };
    let across = if scale == 0 { 30 } else { 12 * scale };
    let mut mesh = Builder::default();
    let beam =
        mesh.block(1, [along, across, height], |[i, j, k]| [i, j, k].map(|n| n as f64 * side));
    mesh.set("pinned", (0..=across).map(|j| beam.node([0, j, height / 2])));
    mesh.set("middle", beam.face(0, true));
    mesh.set("sides", beam.face(1, false).into_iter().chain(beam.face(1, true)));
    mesh.set("top", beam.face(2, true));
    mesh.set("tip", (0..=across).map(|j| beam.node([along, j, height / 2])));
    Ok(mesh.finish(side))
}
