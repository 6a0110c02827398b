//! Linear statics for tests: the stiffness follows from the forces of the kernels for each small
//! corner motion; the equations are solved directly.

use super::testing::Patch;
use crumple_proto::job::Part;
use crumple_proto::partition::Material;

/// Motion of the probes. Its square must vanish even compared with the residue of rigid motion: the
/// bending forces of thin shells are 1e-14 of their membrane forces.
const PROBE: f64 = 1.0 / (1u128 << 100) as f64;

/// A mesh with its stiffness, as the lower band of a symmetric matrix; six unknowns per node.
pub struct Statics {
    band: usize,
    rows: Vec<Vec<f64>>,
    pub load: Vec<f64>,
    fixed: Vec<bool>,
}

impl Statics {
    pub fn new(part: Part, material: Material, nodes: &[[f64; 3]], quads: &[[u32; 4]]) -> Self {
        // Every element has its own nodes, so that one pass probes all elements.
        let apart: Vec<[f64; 3]> =
            quads.iter().flatten().map(|&node| nodes[node as usize]).collect();
        let cells: Vec<[u32; 4]> =
            (0..quads.len() as u32).map(|e| [0, 1, 2, 3].map(|c| 4 * e + c)).collect();
        let mut patch = Patch::new(part, material, &apart, &cells);
        let fresh = patch.history.clone();
        let span = |quad: &[u32; 4]| quad.iter().max().unwrap() - quad.iter().min().unwrap();
        let band = 6 * (quads.iter().map(span).max().unwrap() as usize + 1);
        let size = 6 * nodes.len();
        let mut rows = vec![vec![0.0; band]; size];
        for probe in 0..24 {
            patch.history.clone_from(&fresh);
            for (node, (v, w)) in patch.v.iter_mut().zip(&mut patch.w).enumerate() {
                (*v, *w) = ([0.0; 4], [0.0; 4]);
                let (corner, c) = (probe / 6, probe % 6);
                if node % 4 == corner {
                    if c < 3 { v[c] = PROBE } else { w[c - 3] = PROBE }
                }
            }
            assert_eq!(patch.forces(1.0).trouble, None);
            for (e, quad) in quads.iter().enumerate() {
                let column = 6 * quad[probe / 6] as usize + probe % 6;
                for (corner, &node) in quad.iter().enumerate() {
                    let (f, m) = patch.corner(e, corner);
                    for (c, value) in f.into_iter().chain(m).enumerate() {
                        let row = 6 * node as usize + c;
                        if row >= column {
                            rows[row][row - column] += value / PROBE;
                        }
                    }
                }
            }
        }
        Self { band, rows, load: vec![0.0; size], fixed: vec![false; size] }
    }

    /// Fixes unknowns of a node: x, y, z, then the rotations about them.
    pub fn fix(&mut self, node: usize, unknowns: &[usize]) {
        unknowns.iter().for_each(|c| self.fixed[6 * node + c] = true);
    }

    /// Returns displacements and rotations with the first `count` nodes fixed to a field.
    pub fn hold(mut self, count: usize, field: impl Fn(usize) -> [f64; 6]) -> Vec<[f64; 6]> {
        let held: Vec<f64> = (0..count).flat_map(field).collect();
        for (row, terms) in self.rows.iter().enumerate().skip(held.len()) {
            for (off, term) in terms.iter().enumerate().take(row + 1) {
                self.load[row] -= term * held.get(row - off).unwrap_or(&0.0);
            }
        }
        self.fixed[..held.len()].fill(true);
        let mut found = self.solve();
        found[..count].copy_from_slice(held.as_chunks().0);
        found
    }

    /// Returns displacements and rotations under the load, by Cholesky decomposition in the band.
    pub fn solve(mut self) -> Vec<[f64; 6]> {
        let (size, band) = (self.load.len(), self.band);
        for row in 0..size {
            for off in 0..band.min(row + 1) {
                if self.fixed[row] || self.fixed[row - off] {
                    self.rows[row][off] = f64::from(u8::from(off == 0));
                }
            }
            if self.fixed[row] {
                self.load[row] = 0.0;
            }
        }
        for row in 0..size {
            let first = (row + 1).saturating_sub(band);
            for column in first..=row {
                let from = first.max((column + 1).saturating_sub(band));
                let mut sum = self.rows[row][row - column];
                for k in from..column {
                    sum -= self.rows[row][row - k] * self.rows[column][column - k];
                }
                self.rows[row][row - column] = if column == row {
                    assert!(sum > 0.0, "unknown {row} is not constrained: {sum}");
                    sum.sqrt()
                } else {
                    sum / self.rows[column][0]
                };
            }
            let sum: f64 = (first..row).map(|k| self.rows[row][row - k] * self.load[k]).sum();
            self.load[row] = (self.load[row] - sum) / self.rows[row][0];
        }
        for row in (0..size).rev() {
            self.load[row] /= self.rows[row][0];
            for k in (row + 1).saturating_sub(band)..row {
                self.load[k] -= self.rows[row][row - k] * self.load[row];
            }
        }
        self.load.as_chunks::<6>().0.to_vec()
    }
}
