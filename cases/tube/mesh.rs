//! A square tube of quads along z, with a trigger that starts the first fold: a half sine over part
//! of the height, inwards on two faces and outwards on the others. Lengths in mm.
//!
//! Node sets: `tube` and `head` (the ring at the top).

use crate::builder::{Builder, shuffled};
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;
use std::f64::consts::PI;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator {
    name: "tube",
    options: &[
        ("side", 30.0, "side of the square, between middle surfaces [mm]"),
        ("length", 60.0, "length of the tube [mm]"),
        ("elements", 12.0, "quads over a side, 1 to 256"),
        ("trigger", 0.3, "depth of the trigger [mm]"),
        ("trigger_from", 3.0, "start of the trigger, from the lower end [mm]"),
        ("trigger_to", 20.0, "end of the trigger, from the lower end [mm]"),
        ("shuffle", 0.0, "seed of random ids, 1 to 1000; 0: ids along the tube"),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let side = options.real("side", 1e-3..=1e6, &mut wrong);
    let length = options.real("length", 1e-3..=1e6, &mut wrong);
    let elements = options.count("elements", 1..=256, &mut wrong);
    let depth = options.real("trigger", 0.0..=1e3, &mut wrong);
    let from = options.real("trigger_from", 0.0..=1e6, &mut wrong);
    let to = options.real("trigger_to", 0.0..=1e6, &mut wrong);
    let seed = options.count("shuffle", 0..=1000, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let quad = side / elements as f64;
    let along = ((length / quad).round() as usize).max(1);
    let mut mesh = Builder::default();
    let rings: Vec<Vec<usize>> = (0..=along)
        .map(|k| {
            let z = length * k as f64 / along as f64;
            let wave = if z > from && z < to { (PI * (z - from) / (to - from)).sin() } else { 0.0 };
            (0..4 * elements)
                .map(|n| {
                    let (face, part) = (n / elements, (n % elements) as f64 / elements as f64);
                    let (at, bulge) = (side * (part - 0.5), depth * wave * (PI * part).sin());
                    let out = 0.5 * side + if face % 2 == 0 { -bulge } else { bulge };
                    let [x, y] = match face {
                        0 => [out, at],
                        1 => [-at, out],
                        2 => [-out, -at],
                        _ => [at, -out],
                    };
                    mesh.point([x, y, z])
                })
                .collect()
        })
        .collect();
    rings.windows(2).for_each(|pair| mesh.strip(1, &pair[1], &pair[0], true));
    mesh.set("tube", rings.iter().flatten().copied());
    mesh.set("head", rings[along].iter().copied());
    let mesh = mesh.finish(quad);
    Ok(if seed == 0 { mesh } else { shuffled(mesh, seed as u64) })
}
