//! A sheet of steel shells whose one half moves against the other, with waves across: plastic
//! strain from the first steps on. Units mm, ms, kg.

use crumple_device_kernels::{
    COLUMNS, CORNER_COLUMNS, Mesh, POINT_COLUMNS, POINTS, SECTION_COLUMNS, Sheet,
};
use crumple_fem::elements::thread_shell::ThreadShell;

/// Side of a shell [mm].
const SIDE: f64 = 5.0;
/// Speed of the half and of the waves [mm/ms].
const SPEED: f64 = 20.0;
/// Shells per wave.
const WAVE: f64 = 24.0;

/// The numbers of the steel.
pub const SHEET: Sheet = Sheet {
    thickness: 1.5,
    density: 7.85e-6,
    youngs_modulus: 210.0,
    poisson: 0.3,
    yield_stress: 0.25,
    hardening_modulus: 1.0,
};

/// All columns of a [`Mesh`].
#[derive(Clone)]
pub struct Columns {
    pub corners: Vec<u32>,
    pub history: Vec<f64>,
    pub energies: Vec<f64>,
    pub forces: Vec<f64>,
    pub trouble: Vec<u32>,
    pub x: Vec<[f64; 4]>,
    pub v: Vec<[f64; 4]>,
    pub w: Vec<[f64; 4]>,
    pub inverse: Vec<[f64; 2]>,
    pub start: Vec<u32>,
    pub slots: Vec<u32>,
}

/// The sheet on the CPU.
pub struct Scene {
    pub shell: ThreadShell,
    pub data: Columns,
}

impl Scene {
    /// Creates `along x across` shells.
    pub fn new([along, across]: [usize; 2]) -> Self {
        let shell = SHEET.shell();
        assert_eq!(shell.columns(), COLUMNS);
        let count = along * across;
        let of = |i: usize, j: usize| i * (across + 1) + j;
        let mut x = Vec::new();
        let mut v = Vec::new();
        for i in 0..=along {
            for j in 0..=across {
                let (a, b) = (i as f64, j as f64);
                x.push([SIDE * a, SIDE * b, 0.0, 0.0]);
                let phase = std::f64::consts::TAU * (a / WAVE + b / (1.7 * WAVE));
                let half = if 2 * i > along { -SPEED } else { 0.0 };
                v.push([half, 0.0, SPEED * phase.sin(), 0.0]);
            }
        }
        let mut corners = vec![0; 4 * count];
        let mut touching = vec![Vec::new(); x.len()];
        for e in 0..count {
            let (i, j) = (e / across, e % across);
            let nodes = [of(i, j), of(i + 1, j), of(i + 1, j + 1), of(i, j + 1)];
            for (c, node) in nodes.into_iter().enumerate() {
                corners[c * count + e] = node as u32;
                touching[node].push((4 * e + c) as u32);
            }
        }
        let square = [[0.0; 3], [SIDE, 0.0, 0.0], [SIDE, SIDE, 0.0], [0.0, SIDE, 0.0]];
        let (first, (mass, inertia)) = (shell.history(&square), shell.corner_mass(&square));
        let history = first.iter().flat_map(|&column| std::iter::repeat_n(column, count)).collect();
        let inverse = touching.iter().map(|slots| {
            let corners = slots.len() as f64;
            [1.0 / (corners * mass), 1.0 / (corners * inertia)]
        });
        let mut start = vec![0];
        start.extend(touching.iter().scan(0, |sum, slots| {
            *sum += slots.len() as u32;
            Some(*sum)
        }));
        let data = Columns {
            corners,
            history,
            energies: vec![0.0; 2 * count],
            forces: vec![0.0; CORNER_COLUMNS * count],
            trouble: vec![0],
            w: vec![[0.0; 4]; x.len()],
            inverse: inverse.collect(),
            start,
            slots: touching.concat(),
            x,
            v,
        };
        Self { shell, data }
    }

    /// Returns the pointers to the columns.
    pub fn mesh(&mut self) -> Mesh {
        let d = &mut self.data;
        Mesh {
            count: d.corners.len() / 4,
            nodes: d.x.len(),
            corners: d.corners.as_ptr(),
            history: d.history.as_mut_ptr(),
            energies: d.energies.as_mut_ptr(),
            forces: d.forces.as_mut_ptr(),
            trouble: d.trouble.as_mut_ptr().cast_const().cast(),
            x: d.x.as_mut_ptr(),
            v: d.v.as_mut_ptr(),
            w: d.w.as_mut_ptr(),
            inverse: d.inverse.as_ptr(),
            start: d.start.as_ptr(),
            slots: d.slots.as_ptr(),
        }
    }

    /// Returns the largest plastic strain, and the share of points that have any.
    pub fn plastic_strain(&self) -> [f64; 2] {
        let count = self.data.corners.len() / 4;
        let of = |k: usize| SECTION_COLUMNS + k * POINT_COLUMNS + 3;
        let strains =
            || (0..POINTS).flat_map(|k| &self.data.history[of(k) * count..(of(k) + 1) * count]);
        let flowed = strains().filter(|strain| **strain > 0.0).count() as f64;
        let most = strains().fold(0.0, |most: f64, &strain| most.max(strain));
        [most, flowed / (POINTS * count) as f64]
    }

    /// See [`Columns::columns`].
    pub fn columns(&self) -> Vec<(&'static str, Vec<f64>)> {
        self.data.columns()
    }
}

impl Columns {
    /// Returns the state by name.
    pub fn columns(&self) -> Vec<(&'static str, Vec<f64>)> {
        vec![
            ("coordinates", self.x.as_flattened().to_vec()),
            ("velocities", self.v.as_flattened().to_vec()),
            ("rotational velocities", self.w.as_flattened().to_vec()),
            ("history", self.history.clone()),
            ("energies", self.energies.clone()),
        ]
    }
}
