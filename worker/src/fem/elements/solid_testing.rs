//! Helpers for tests of solids: a mesh of hexahedra with its columns, meshes, a minimal explicit
//! solver.

use super::testing::{Noise, Passed, lay, part, passed, settings};
use super::{Element, ElementFields, ElementNodalForces, ElementPass, build_block};
use crate::fem::columns::HistoryColumns;
use crate::nodes::NodeView;
use crumple_proto::job::{HourglassForm, Part, Precision};
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::partition::Material;

/// Returns a part of solids without bulk viscosity.
pub fn solid_part(hourglass: HourglassForm, coefficient: Option<f64>) -> Part {
    Part {
        hourglass: Some(hourglass),
        hourglass_coefficient: coefficient,
        bulk_viscosity: Some([0.0; 2]),
        ..part(0.0)
    }
}

/// Hexahedra of one part with their nodes, columns and corner forces.
pub struct Solids {
    pub element: Box<dyn Element>,
    pub x: Vec<[f64; 4]>,
    pub v: Vec<[f64; 4]>,
    pub cells: Vec<[u32; 8]>,
    pub groups: Vec<u32>,
    pub history: HistoryColumns,
    pub unstrained: Vec<bool>,
    pub force: Vec<[f64; 4]>,
}

impl Solids {
    pub fn new(part: Part, material: Material, nodes: &[[f64; 3]], cells: &[[u32; 8]]) -> Self {
        Self::in_precision(Precision::Double, part, material, nodes, cells)
    }

    pub fn in_precision(
        precision: Precision,
        part: Part,
        material: Material,
        nodes: &[[f64; 3]],
        cells: &[[u32; 8]],
    ) -> Self {
        let element = build_block(&settings(part, material), 0, Shape::Hex8)
            .map_err(|e| format!("{e:?}"))
            .unwrap();
        let (groups, history) = lay(&*element, precision, cells);
        let mut all = Self {
            element,
            x: nodes.iter().map(|x| [x[0], x[1], x[2], 0.0]).collect(),
            v: vec![[0.0; 4]; nodes.len()],
            cells: cells.to_vec(),
            unstrained: vec![false; groups.len() / (8 * history.lanes())],
            history,
            force: vec![[0.0; 4]; groups.len()],
            groups,
        };
        all.forces(0.0);
        all
    }

    /// Computes the forces at the present positions of the nodes.
    pub fn forces(&mut self, dt: f64) -> Passed {
        let nodes = NodeView { x: &self.x, v: &self.v, w: &self.v };
        let out = ElementNodalForces { force: &mut self.force, moment: &mut [] };
        let lanes = self.history.lanes();
        passed((self.cells.len(), self.groups.len() / 8, lanes), |energies| {
            self.element.forces(ElementPass {
                range: 0..self.groups.len() / (8 * self.history.lanes()),
                count: self.cells.len(),
                groups: &self.groups,
                history: self.history.as_mut(),
                unstrained: &mut self.unstrained,
                nodes,
                dt,
                out,
                energies,
            })
        })
    }

    /// Moves nodes with their velocities, then computes the forces.
    pub fn step(&mut self, dt: f64) -> Passed {
        for (x, v) in self.x.iter_mut().zip(&self.v) {
            (0..3).for_each(|i| x[i] += dt * v[i]);
        }
        self.forces(dt)
    }

    /// Moves every node to `target` in a step of 1.
    pub fn go(&mut self, target: impl Fn([f64; 3]) -> [f64; 3]) -> Passed {
        for (x, v) in self.x.iter().zip(&mut self.v) {
            let to = target([x[0], x[1], x[2]]);
            (0..3).for_each(|i| v[i] = to[i] - x[i]);
        }
        self.step(1.0)
    }

    pub fn corners(&self, element: usize) -> [[f64; 3]; 8] {
        self.cells[element].map(|node| std::array::from_fn(|i| self.x[node as usize][i]))
    }

    pub fn fields(&self, element: usize) -> ElementFields {
        self.element.fields(self.history.element(element), &self.corners(element))
    }

    /// Returns the forces of the elements on the nodes.
    pub fn nodal(&self) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; self.x.len()];
        for (e, cell) in self.cells.iter().enumerate() {
            for (c, &node) in cell.iter().enumerate() {
                (0..3).for_each(|i| sums[node as usize][i] += self.force[8 * e + c][i]);
            }
        }
        sums
    }

    /// Returns the largest magnitude of any corner force.
    pub fn largest(&self) -> f64 {
        self.force.iter().flatten().fold(0.0, |m: f64, f| m.max(f.abs()))
    }

    /// Returns the sum of corner forces, and of their moments about the origin.
    pub fn sums(&self) -> ([f64; 3], [f64; 3]) {
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        for (f, x) in self.nodal().iter().zip(&self.x) {
            let arm =
                [x[1] * f[2] - x[2] * f[1], x[2] * f[0] - x[0] * f[2], x[0] * f[1] - x[1] * f[0]];
            for i in 0..3 {
                force[i] += f[i];
                moment[i] += arm[i];
            }
        }
        (force, moment)
    }

    /// Returns the power of corner forces at the nodal velocities.
    pub fn power(&self) -> f64 {
        self.nodal()
            .iter()
            .zip(&self.v)
            .map(|(f, v)| (0..3).map(|i| f[i] * v[i]).sum::<f64>())
            .sum()
    }

    pub fn masses(&self) -> Vec<f64> {
        let mut masses = vec![0.0; self.x.len()];
        for (e, cell) in self.cells.iter().enumerate() {
            let mass = self.element.corner_mass(&self.corners(e), OwnSection::default()).0;
            cell.iter().for_each(|&node| masses[node as usize] += mass);
        }
        masses
    }

    /// Returns the stable step of the mesh's elements.
    pub fn stable_dt(&self) -> f64 {
        (0..self.cells.len())
            .map(|e| self.element.stable_dt(&self.corners(e), OwnSection::default()))
            .fold(f64::INFINITY, f64::min)
    }

    /// Advances one explicit step: `load` adds to nodal forces, `fix` clears prescribed velocities.
    pub fn explicit(
        &mut self,
        dt: f64,
        masses: &[f64],
        load: impl Fn(usize) -> [f64; 3],
        fix: impl Fn(usize, &mut [f64; 4]),
    ) -> Passed {
        for (node, force) in self.nodal().into_iter().enumerate() {
            let load = load(node);
            (0..3).for_each(|i| self.v[node][i] += dt * (load[i] - force[i]) / masses[node]);
            fix(node, &mut self.v[node]);
        }
        self.step(dt)
    }
}

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
        Part { hourglass: Some(form), ..part(0.0) },
        steel.clone(),
        &nodes,
        &cells,
    )
}
