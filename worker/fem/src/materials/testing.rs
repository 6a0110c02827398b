//! Helpers for tests of laws: a cube and a sheet of one point on a path of strain.

use super::{LAWS, PlaneStress, Points, Solid, SolidPoint, build, build_solid};
use crumple_proto::partition::{Material, Param};

/// Returns a material from numbers and other parameters.
pub fn material(law: &str, numbers: &[(&str, f64)], others: &[(&str, Param)]) -> Material {
    let numbers = numbers.iter().map(|&(key, value)| (key.to_string(), Param::Number(value)));
    let others = others.iter().map(|(key, value)| (key.to_string(), value.clone()));
    let parameters = numbers.chain(others).collect();
    Material { name: "sample".into(), law: law.into(), density: 1e-6, parameters }
}

/// Returns a table of rows.
pub fn table<const N: usize>(rows: &[[f64; N]]) -> Param {
    Param::Table(rows.iter().map(|row| row.to_vec()).collect())
}

/// Returns the texts of all problems of a material, in shells and in solids.
pub fn problems(material: &Material) -> String {
    let solid = build_solid(material).err();
    let row = LAWS.iter().find(|row| row.name == material.law).expect("a law");
    let shell = row.build.and_then(|_| build(material).err());
    format!("{:?} {:?}", solid, shell)
}

/// A cube of one point.
#[derive(Clone)]
pub struct Cube {
    law: std::rc::Rc<dyn Solid>,
    /// Stress and history.
    pub state: Vec<f64>,
    /// Logarithmic strain along the axes, and the sum of the shear increments.
    pub strain: [f64; 6],
    /// Work per volume at the start [force/length^2].
    pub work: f64,
}

impl Cube {
    pub fn new(material: &Material) -> Self {
        Self::around(material, |law| law)
    }

    /// Creates a cube of what `with` makes of the law.
    pub fn around(
        material: &Material,
        with: impl FnOnce(Box<dyn Solid>) -> Box<dyn Solid>,
    ) -> Self {
        let law = build_solid(material).map_err(|problems| format!("{problems:?}")).unwrap();
        let law: std::rc::Rc<dyn Solid> = with(law).into();
        let state = vec![0.0; 6 + law.history().len()];
        Self { law, state, strain: [0.0; 6], work: 0.0 }
    }

    /// Returns the value of a column of the history.
    pub fn at(&self, name: &str) -> f64 {
        let column = self.law.history().iter().position(|column| *column == name);
        self.state[6 + column.unwrap_or_else(|| panic!("no column {name}"))]
    }

    /// Sets the value of a column of the history.
    pub fn set(&mut self, name: &str, value: f64) {
        let column = self.law.history().iter().position(|column| *column == name);
        self.state[6 + column.unwrap_or_else(|| panic!("no column {name}"))] = value;
    }

    /// Applies an increment of strain. Returns what the law returns.
    pub fn step(&mut self, strain: [f64; 6], dt: f64) -> f64 {
        let before: [f64; 6] = std::array::from_fn(|c| self.state[c]);
        let left = self.law.update_one(SolidPoint { state: &mut self.state, strain: &strain }, dt);
        let volume =
            (self.strain[..3].iter().sum::<f64>() + 0.5 * strain[..3].iter().sum::<f64>()).exp();
        for c in 0..6 {
            self.work += 0.5 * volume * (before[c] + self.state[c]) * strain[c];
            // An increment is the change of length over the mean length, as in the elements.
            self.strain[c] += if c < 3 { 2.0 * (0.5 * strain[c]).atanh() } else { strain[c] };
        }
        left
    }

    /// Applies `strain`, with the same strain along all axes in `free` such that their stress is
    /// zero.
    pub fn pull(&mut self, strain: [f64; 6], free: &[usize], dt: f64) {
        let along = |lateral: f64| {
            let mut strain = strain;
            free.iter().for_each(|&axis| strain[axis] = lateral);
            strain
        };
        let size = 1e-3 + 2.0 * strain.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
        let (mut low, mut high) = (-size, size);
        for _ in 0..90 {
            let middle = 0.5 * (low + high);
            let mut trial = self.state.clone();
            let strain = along(middle);
            self.law.update_one(SolidPoint { state: &mut trial, strain: &strain }, dt);
            if trial[free[0]] > 0.0 { high = middle } else { low = middle }
        }
        self.step(along(0.5 * (low + high)), dt);
    }

    /// Applies `strain`, with the same strain along all axes in `free` such that their stress is
    /// `stress`: the least such strain above `-size`.
    pub fn pull_against(
        &mut self,
        strain: [f64; 6],
        free: &[usize],
        (stress, size): (f64, f64),
        dt: f64,
    ) {
        let along = |lateral: f64| {
            let mut strain = strain;
            free.iter().for_each(|&axis| strain[axis] = lateral);
            strain
        };
        let above = |lateral: f64| {
            let mut trial = self.state.clone();
            let strain = along(lateral);
            self.law.update_one(SolidPoint { state: &mut trial, strain: &strain }, dt);
            trial[free[0]] > stress
        };
        let steps = (-20..=20).map(|k| 0.05 * f64::from(k) * size);
        let mut high = steps.clone().find(|lateral| above(*lateral)).unwrap_or(size);
        let mut low = high - 0.05 * size;
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if above(middle) { high = middle } else { low = middle }
        }
        self.step(along(0.5 * (low + high)), dt);
    }

    /// Stretches the cube along x to a stretch in so many steps, with free sides.
    pub fn stretch(&mut self, to: f64, steps: usize, dt: f64) {
        let each = 2.0 * (0.5 * (to.ln() - self.strain[0]) / steps as f64).tanh();
        (0..steps).for_each(|_| self.pull([each, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], dt));
    }

    /// Returns the von Mises stress.
    pub fn von_mises(&self) -> f64 {
        let s = &self.state;
        let direct = (s[0] - s[1]).powi(2) + (s[1] - s[2]).powi(2) + (s[2] - s[0]).powi(2);
        (0.5 * direct + 3.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5])).sqrt()
    }
}

/// A sheet of one point.
pub struct Sheet {
    law: Box<dyn PlaneStress>,
    /// Stress and history.
    pub state: Vec<f64>,
    /// Strain, with that through the thickness.
    pub strain: [f64; 4],
}

impl Sheet {
    pub fn new(material: &Material) -> Self {
        let law = build(material).map_err(|problems| format!("{problems:?}")).unwrap();
        let state = vec![0.0; 3 + law.history().len()];
        Self { law, state, strain: [0.0; 4] }
    }

    /// Applies an increment of strain.
    pub fn step(&mut self, strain: [f64; 3], dt: f64) {
        let mut through = [0.0];
        let points =
            Points { state: &mut self.state, strain: &[strain], thickness_strain: &mut through };
        self.law.update_one(points, dt);
        (0..3).for_each(|c| self.strain[c] += strain[c]);
        self.strain[3] += through[0];
    }

    /// Applies a strain along x, with the lateral strain that leaves no lateral stress.
    pub fn pull(&mut self, eps: f64, dt: f64) {
        let size = 1e-3 + 2.0 * eps.abs();
        let (mut low, mut high) = (-size, size);
        for _ in 0..90 {
            let middle = 0.5 * (low + high);
            let mut state = self.state.clone();
            let points = Points {
                state: &mut state,
                strain: &[[eps, middle, 0.0]],
                thickness_strain: &mut [0.0],
            };
            self.law.update_one(points, dt);
            if state[1] > 0.0 { high = middle } else { low = middle }
        }
        self.step([eps, 0.5 * (low + high), 0.0], dt);
    }
}
