//! The brick wall of PRONTO3D (Attaway et al. 1994): a rod hits a stack of bricks that rests
//! against a wall. x is the rod's direction, y runs along the stack, z upwards.
//!
//! Published: 17 bricks, 54 elements for a full one, 8400 elements in all, a rod at 2000 in/s. Five
//! courses in running bond, three and a half bricks and two halves in turn, make 17 with 810
//! elements; rod (5 x 6 x 33) and wall (30 x 22 x 10) have the other 7590. Lengths are not
//! published: bricks of 200 x 100 x 100 mm.

use crate::builder::{BlockNodes, Builder};
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// Length, depth and height of a brick [mm]; a half brick has half the length.
const BRICK: [f64; 3] = [200.0, 100.0, 100.0];
/// Elements along these.
const CELLS: [usize; 3] = [6, 3, 3];
/// Bricks in a course, and courses.
const WIDE: usize = 3;
const COURSES: usize = 5;

/// Parts: 1 rod, 2 bricks, 3 wall. Node sets: `rod`, `bricks`, `wall`, `back` (the face of the wall
/// away from the rod).
pub const GENERATOR: Generator = Generator {
    name: "brick_wall",
    options: &[
        ("scale", 1.0, "scaled problem: approximate factor on the number of elements"),
        ("gap", 0.0, "gap between bricks, in every direction [mm]"),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let scale = options.real("scale", 1.0..=4096.0, &mut wrong);
    let gap = options.real("gap", 0.0..=20.0, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    // The same factor in every direction, with an even number along a brick, so that a half brick
    // has an integer number.
    let fine = scale.cbrt();
    let more = |n: usize| ((n as f64 * fine).round() as usize).max(1);
    let half_cells = more(CELLS[0] / 2);
    let [across, up] = [more(CELLS[1]), more(CELLS[2])];
    let mut mesh = Builder::default();
    let mut body = |part: u32, cells: [usize; 3], from: [f64; 3], size: [f64; 3]| -> BlockNodes {
        mesh.block(part, cells, |ijk| {
            [0, 1, 2].map(|c| from[c] + size[c] * ijk[c] as f64 / cells[c] as f64)
        })
    };
    let mut bricks = Vec::new();
    let [length, depth, height] = BRICK;
    for course in 0..COURSES {
        let shifted = course % 2 == 1;
        let halves = if shifted { 2 * WIDE } else { 0 };
        let mut at = 0;
        while at < 2 * WIDE {
            let is_half = shifted && (at == 0 || at + 1 == halves);
            let long = if is_half { 1 } else { 2 };
            let from =
                [0.0, at as f64 * (0.5 * length + 0.5 * gap), course as f64 * (height + gap)];
            let size = [depth, 0.5 * length * long as f64, height];
            bricks.push(body(2, [across, half_cells * long, up], from, size));
            at += long;
        }
    }
    let (width, tall) = (WIDE as f64 * length, COURSES as f64 * height);
    let wall_size = [100.0, 1.5 * width, 1.32 * tall];
    let wall_from = [depth + gap, 0.5 * (width - wall_size[1]), 0.5 * (tall - wall_size[2])];
    let wall = body(3, [more(10), more(30), more(22)], wall_from, wall_size);
    let rod_size = [660.0, 100.0, 120.0];
    let rod_from =
        [-rod_size[0] - 1.0, 0.5 * (width - rod_size[1]) + 10.0, 0.5 * (tall - rod_size[2]) + 7.0];
    let rod = body(1, [more(33), more(5), more(6)], rod_from, rod_size);
    mesh.set("rod", rod.all());
    mesh.set("bricks", bricks.iter().flat_map(BlockNodes::all));
    mesh.set("wall", wall.all());
    mesh.set("back", wall.face(0, true));
    Ok(mesh.finish(depth / CELLS[1] as f64 / fine))
}
