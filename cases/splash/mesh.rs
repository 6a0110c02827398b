//! A drop of particles above a plate of shells. Lengths in mm.
//!
//! Node sets `drop`, `plate` and `edge`, the nodes on the sides of the plate; parts 1 (plate) and 2
//! (drop). The particles are those places of a cubic lattice that lie in a ball; the plate lies in
//! z = 0.

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "splash",
    options: &[
        ("radius", 6.0, "radius of the drop [mm]"),
        ("spacing", 1.0, "distance of neighbouring particles, `part.drop.particles.spacing` [mm]"),
        ("gap", 1.0, "distance of the lowest place of the drop from the plane of the plate [mm]"),
        ("side", 40.0, "side of the plate [mm]"),
        ("shells", 20.0, "number of shells along a side of the plate, 1 to 1000"),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let radius = options.real("radius", 1e-6..=1e6, &mut wrong);
    let spacing = options.real("spacing", 1e-6..=1e6, &mut wrong);
    let gap = options.real("gap", 0.0..=1e6, &mut wrong);
    let side = options.real("side", 1e-6..=1e6, &mut wrong);
    let shells = options.count("shells", 1..=1000, &mut wrong);
    let layers = radius / spacing;
    if wrong.is_empty() && !(1.0..=100.0).contains(&layers) {
        wrong.push(Problem::error(
            "scene.spacing",
            format!("the radius is {layers} spacings"),
            "it has to be from 1 to 100 spacings",
        ));
    }
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let mut mesh = Builder::default();
    let place = |i: usize| side * (i as f64 / shells as f64 - 0.5);
    let rows: Vec<Vec<usize>> = (0..=shells)
        .map(|i| (0..=shells).map(|j| mesh.point([place(i), place(j), 0.0])).collect())
        .collect();
    for i in 0..shells {
        mesh.strip(1, &rows[i + 1], &rows[i], false);
    }
    let on_edge = |i: usize| i == 0 || i == shells;
    for (i, row) in rows.iter().enumerate() {
        let edge = row.iter().enumerate().filter(|(j, _)| on_edge(i) || on_edge(*j));
        mesh.set("edge", edge.map(|(_, &node)| node));
        mesh.set("plate", row.iter().copied());
    }
    let reach = layers.ceil() as i64;
    let numbers = || -reach..=reach;
    for (i, j) in numbers().flat_map(|i| numbers().map(move |j| (i, j))) {
        for k in numbers() {
            let at = [i, j, k].map(|n| n as f64 * spacing);
            if at.iter().map(|c| c * c).sum::<f64>() <= radius * radius {
                let node = mesh.point([at[0], at[1], at[2] + radius + gap]);
                mesh.particle(2, node);
                mesh.set("drop", [node]);
            }
        }
    }
    Ok(mesh.finish(spacing))
}
