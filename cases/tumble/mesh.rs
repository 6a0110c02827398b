//! Four open box tubes and three plates with different rotations around a common centre, a few mm
//! apart. Lengths in mm. There is one node set per body; job.toml moves them towards each other.
//!
//! A tube is 36 mm square and 108 mm long, a plate 108 mm square, quads 9 mm: 4*192 + 3*144 = 1200
//! shells, 4*208 + 3*169 = 1339 nodes. Rotations are quaternions of integers, so that no two edges
//! are parallel and positions need no sines.

use crate::builder::Builder;
use crate::{Generator, OptionRow, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator { name: "tumble", options: OPTIONS, build };

const OPTIONS: &[OptionRow] = &[
    ("refine", 1.0, "number of pieces of each side of a shell, 1 to 6"),
    ("spread", 1.0, "factor on the distances of the bodies from the centre, 1 to 5"),
];

/// Side of a quad at `refine = 1` [mm].
const SIDE: f64 = 9.0;
/// Quads across a tube's wall, and along a tube or a plate, at `refine = 1`.
const ACROSS: usize = 4;
const ALONG: usize = 12;

enum BodyShape {
    /// Box tube along the local z axis, open at both ends.
    Tube,
    /// Square plate perpendicular to the local z axis.
    Plate,
}

struct TumblingBody {
    name: &'static str,
    shape: BodyShape,
    /// Rotation from the local axes: quaternion of any length.
    turn: [f64; 4],
    /// Centre [mm].
    centre: [f64; 3],
}

/// The bodies; part ids count from 1 in this order.
const BODIES: [TumblingBody; 7] = [
    TumblingBody {
        name: "tube_1",
        shape: BodyShape::Tube,
        turn: [7.0, 1.0, 2.0, 0.0],
        centre: [0.0, 0.0, 0.0],
    },
    TumblingBody {
        name: "tube_2",
        shape: BodyShape::Tube,
        turn: [5.0, 4.0, -1.0, 2.0],
        centre: [68.0, 6.0, 4.0],
    },
    TumblingBody {
        name: "tube_3",
        shape: BodyShape::Tube,
        turn: [6.0, -2.0, 5.0, 1.0],
        centre: [-86.0, -8.0, 12.0],
    },
    TumblingBody {
        name: "tube_4",
        shape: BodyShape::Tube,
        turn: [6.0, 1.0, -4.0, 3.0],
        centre: [6.0, 80.0, -10.0],
    },
    TumblingBody {
        name: "plate_1",
        shape: BodyShape::Plate,
        turn: [5.0, 5.0, 1.0, -1.0],
        centre: [-6.0, -58.0, 8.0],
    },
    TumblingBody {
        name: "plate_2",
        shape: BodyShape::Plate,
        turn: [9.0, 1.0, 2.0, 3.0],
        centre: [8.0, 4.0, 92.0],
    },
    TumblingBody {
        name: "plate_3",
        shape: BodyShape::Plate,
        turn: [9.0, -2.0, 1.0, 1.0],
        centre: [-8.0, 8.0, -90.0],
    },
];

/// Builds the bodies.
fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let mut wrong = Vec::new();
    let refine = options.count("refine", 1..=6, &mut wrong);
    let spread = options.real("spread", 1.0..=5.0, &mut wrong);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let mut mesh = Builder::default();
    for (body, part) in BODIES.iter().zip(1..) {
        let section = match body.shape {
            BodyShape::Tube => square(ACROSS * refine),
            BodyShape::Plate => (0..=ALONG * refine)
                .map(|i| [i as f64 - 0.5 * (ALONG * refine) as f64, 0.0])
                .collect(),
        };
        let side = SIDE / refine as f64;
        let turn = matrix(body.turn);
        let mut rows: Vec<Vec<usize>> = Vec::new();
        for k in 0..=ALONG * refine {
            let along = k as f64 - 0.5 * (ALONG * refine) as f64;
            let place = |&[a, b]: &[f64; 2]| {
                let own = match body.shape {
                    BodyShape::Tube => [a, b, along],
                    BodyShape::Plate => [a, along, b],
                };
                let x =
                    turn.map(|row| side * (row[0] * own[0] + row[1] * own[1] + row[2] * own[2]));
                [0, 1, 2].map(|i| spread * body.centre[i] + x[i])
            };
            rows.push(section.iter().map(|s| mesh.point(place(s))).collect());
        }
        let closed = matches!(body.shape, BodyShape::Tube);
        for pair in rows.windows(2) {
            mesh.strip(part, &pair[0], &pair[1], closed);
        }
        mesh.set(body.name, rows.into_iter().flatten());
    }
    Ok(mesh.finish(SIDE / refine as f64))
}

/// Returns the points around a square of `n` sides per wall, in sides from its middle.
fn square(n: usize) -> Vec<[f64; 2]> {
    let (n, half) = (n as i64, 0.5 * n as f64);
    let wall = |i: i64| match i / n {
        0 => [i, 0],
        1 => [n, i - n],
        2 => [3 * n - i, n],
        _ => [0, 4 * n - i],
    };
    (0..4 * n).map(|i| wall(i).map(|c| c as f64 - half)).collect()
}

/// Rotation matrix of the quaternion (w, x, y, z), of any length.
fn matrix([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
    let s = 2.0 / (w * w + x * x + y * y + z * z);
    [
        [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
    ]
}
