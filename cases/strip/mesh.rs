//! A strip of quads in the plane z = 0: x from the middle of a beam to its end, y from its axis to
//! its edge. Lengths in mm.
//!
//! Node sets: `middle` (x = 0), `end`, `axis` (y = 0), `loaded` (x below the border of the load),
//! `border` (the row on the border).

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "strip",
    options: &[
        ("length", 127.0, "length along x [mm]"),
        ("width", 15.24, "width along y [mm]"),
        ("along", 25.0, "quads along x, 1 to 4096"),
        ("across", 3.0, "quads along y, 1 to 512"),
        ("loaded", 25.4, "loaded length, from the middle [mm]"),
        (
            "slant",
            0.0,
            "slant of the lines across, in quads, from -0.4 to 0.4, with alternating sign",
        ),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let length = options.real("length", 1e-3..=1e6, &mut wrong);
    let width = options.real("width", 1e-3..=1e6, &mut wrong);
    let along = options.count("along", 1..=4096, &mut wrong);
    let across = options.count("across", 1..=512, &mut wrong);
    let loaded = options.real("loaded", 0.0..=1e6, &mut wrong);
    let slant = options.real("slant", -0.4..=0.4, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let quad = length / along as f64;
    let mut mesh = Builder::default();
    let rows: Vec<Vec<usize>> = (0..=along)
        .map(|i| {
            // Ends stay straight.
            let lean = if i == 0 || i == along {
                0.0
            } else {
                slant * if i % 2 == 0 { 1.0 } else { -1.0 }
            };
            (0..=across)
                .map(|j| {
                    let part = j as f64 / across as f64;
                    mesh.point([quad * (i as f64 + lean * (2.0 * part - 1.0)), width * part, 0.0])
                })
                .collect()
        })
        .collect();
    rows.windows(2).for_each(|pair| mesh.strip(1, &pair[0], &pair[1], false));
    mesh.set("middle", rows[0].iter().copied());
    mesh.set("end", rows[along].iter().copied());
    mesh.set("axis", rows.iter().map(|row| row[0]));
    let border = ((loaded / quad).round() as usize).min(along);
    mesh.set("loaded", rows[..border.max(1)].iter().flatten().copied());
    mesh.set("border", rows[border].iter().copied());
    Ok(mesh.finish(quad))
}
