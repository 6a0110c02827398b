//! Helpers for tests of solids: parts and meshes.

use super::HourglassForm;
use super::testing::{Noise, Patch, part};
use crumple_proto::job::{Part, Precision};
use crumple_proto::partition::Material;

/// Returns a part of solids without bulk viscosity.
pub fn solid_part(hourglass: HourglassForm, coefficient: Option<f64>) -> Part {
    let part = part(0.0).with("hourglass", hourglass.word()).with("bulk_viscosity", [0.0; 2]);
    match coefficient {
        Some(coefficient) => part.with("hourglass_coefficient", coefficient),
        None => part,
    }
}

/// Hexahedra of one part.
pub type Solids = Patch<8>;

/// Returns nodes and cells of a block of `n` elements along each axis; node
/// `(k (ny + 1) + j) (nx + 1) + i`.
pub fn block(n: [usize; 3], size: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 8]>) {
    let [nx, ny, nz] = n;
    let at = |i: usize, axis: usize| size[axis] * i as f64 / n[axis] as f64;
    let mut nodes = Vec::new();
    for k in 0..=nz {
        for j in 0..=ny {
            nodes.extend((0..=nx).map(|i| [at(i, 0), at(j, 1), at(k, 2)]));
        }
    }
    let id = |i: usize, j: usize, k: usize| ((k * (ny + 1) + j) * (nx + 1) + i) as u32;
    let face = |i: usize, j: usize, k: usize| {
        [id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k)]
    };
    let mut cells = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let (low, high) = (face(i, j, k), face(i, j, k + 1));
                cells.push(std::array::from_fn(|c| if c < 4 { low[c] } else { high[c - 4] }));
            }
        }
    }
    (nodes, cells)
}

/// Returns distorted solids, 3 by 3 by 3, with one of the hourglass controls.
pub fn solids(precision: Precision, steel: &Material, form: HourglassForm) -> Solids {
    let mut noise = Noise(17);
    let (mut nodes, mut cells) = (Vec::new(), Vec::new());
    let id = |i: u32, j: u32, k: u32| (k * 4 + j) * 4 + i;
    for k in 0..4 {
        for j in 0..4 {
            for i in 0..4 {
                nodes.push([i, j, k].map(|c| f64::from(c) + 0.1 * noise.next()));
                if i.max(j).max(k) < 3 {
                    let low = [id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k)];
                    let [a, b, c, d] = low;
                    cells.push([a, b, c, d, a + 16, b + 16, c + 16, d + 16]);
                }
            }
        }
    }
    Solids::in_precision(
        precision,
        part(0.0).with("hourglass", form.word()),
        steel.clone(),
        &nodes,
        &cells,
    )
}
