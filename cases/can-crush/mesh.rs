//! The can crush of PRONTO3D (Attaway et al. 1994): a tilted plate crushes half of a can with a
//! fixed bottom edge. The axis of the can is z, the symmetry plane is y = 0, the plate moves
//! downwards.
//!
//! Published: wall 0.25 in, inner radius 5 in, length 15 in, plate 22 x 11 x 2.5 in tilted by 10
//! degrees, both three elements thick, 7152 elements: here 48 x 39 x 3 for the can and 32 x 16 x 3
//! for the plate.

use crate::builder::Builder;
use crate::{Generator, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

const INCH: f64 = 25.4;
/// Inner radius, wall and length of the can [mm].
const RADIUS: f64 = 5.0 * INCH;
const WALL: f64 = 0.25 * INCH;
const LENGTH: f64 = 15.0 * INCH;
/// The plate along x, y and its thickness [mm].
const PLATE: [f64; 3] = [22.0 * INCH, 11.0 * INCH, 2.5 * INCH];

/// Parts: 1 can, 2 plate. Node sets: `can`, `plate`, `bottom` (lower edge of the can), `symmetry`
/// (both parts, y = 0).
pub const GENERATOR: Generator = Generator {
    name: "can_crush",
    options: &[
        ("scale", 1.0, "scaled problem: approximate factor on the number of elements"),
        ("tilt", 10.0, "tilt of the plate about the y axis [degree]"),
        ("layers", 3.0, "elements through the wall, for scale = 1"),
    ],
    build,
};

fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let scale = options.real("scale", 1.0..=4096.0, &mut wrong);
    let tilt = options.real("tilt", -45.0..=45.0, &mut wrong).to_radians();
    let layers = options.count("layers", 1..=8, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let fine = scale.cbrt();
    let more = |n: usize| ((n as f64 * fine).round() as usize).max(1);
    let mut mesh = Builder::default();
    let cells = [more(layers), more(48), more(39)];
    let can = mesh.block(1, cells, |[i, j, k]| {
        let r = RADIUS + WALL * i as f64 / cells[0] as f64;
        let angle = std::f64::consts::PI * j as f64 / cells[1] as f64;
        // The ends are exactly on the symmetry plane.
        let y = if j == 0 || j == cells[1] { 0.0 } else { r * angle.sin() };
        [r * angle.cos(), y, LENGTH * k as f64 / cells[2] as f64]
    });
    let cells = [more(32), more(16), more(layers)];
    // The lowest point of the plate over the can's upper edge starts just above it.
    let clear = (RADIUS + WALL) * tilt.abs().tan() + 1.0;
    let plate = mesh.block(2, cells, |ijk| {
        let [x, y, z] = [0, 1, 2].map(|c| PLATE[c] * ijk[c] as f64 / cells[c] as f64);
        let x = x - 0.5 * PLATE[0];
        [x * tilt.cos() - z * tilt.sin(), y, LENGTH + clear + x * tilt.sin() + z * tilt.cos()]
    });
    mesh.set("can", can.all());
    mesh.set("plate", plate.all());
    mesh.set("bottom", can.face(2, false));
    mesh.set(
        "symmetry",
        can.face(1, false).into_iter().chain(can.face(1, true)).chain(plate.face(1, false)),
    );
    Ok(mesh.finish(LENGTH / 39.0 / fine))
}
