//! A square plate in the plane z = 0, fixed at its rim. With `strip` it has a strip of narrow quads
//! along y through its middle. Lengths in mm.
//!
//! Node sets `rim` (all four edges) and `inside` (the rest).

use crate::builder::Builder;
use crate::{Generator, OptionRow, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator { name: "plate", options: OPTIONS, build };

const OPTIONS: &[OptionRow] = &[
    ("elements", 10.0, "quads along half a side, 1 to 500"),
    ("side", 200.0, "side of the plate [mm]"),
    ("strip", 0.0, "columns of narrow quads, 0 to all"),
    ("narrow", 4.0, "width of the other quads over that of the narrow ones, 1 to 100"),
];

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let half = options.count("elements", 1..=500, &mut wrong);
    let side = options.real("side", 1.0..=1e5, &mut wrong);
    let n = 2 * half;
    let strip = options.count("strip", 0..=n, &mut wrong);
    let narrow = options.real("narrow", 1.0..=100.0, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let quad = side / n as f64;
    let wide = side / ((n - strip) as f64 + strip as f64 / narrow);
    let before = (n - strip) / 2;
    let across = |i: usize| {
        let inside = i.clamp(before, before + strip) - before;
        wide * (i - inside) as f64 + wide / narrow * inside as f64 - 0.5 * side
    };
    let mut mesh = Builder::default();
    let at = |i: usize| quad * i as f64 - 0.5 * side;
    let rows: Vec<Vec<usize>> =
        (0..=n).map(|j| (0..=n).map(|i| mesh.point([across(i), at(j), 0.0])).collect()).collect();
    for pair in rows.windows(2) {
        mesh.strip(1, &pair[1], &pair[0], false);
    }
    let ends = [0, n];
    let on_rim = |i: usize, j: usize| ends.contains(&i) || ends.contains(&j);
    let rim = rows.iter().enumerate().flat_map(|(j, row)| {
        row.iter().enumerate().filter(move |(i, _)| on_rim(*i, j)).map(|(_, &node)| node)
    });
    mesh.set("rim", rim.collect::<Vec<_>>());
    mesh.set(
        "inside",
        rows.iter()
            .enumerate()
            .flat_map(|(j, row)| {
                row.iter().enumerate().filter(move |(i, _)| !on_rim(*i, j)).map(|(_, &node)| node)
            })
            .collect::<Vec<_>>(),
    );
    Ok(mesh.finish(if strip > 0 { wide / narrow } else { quad }))
}
