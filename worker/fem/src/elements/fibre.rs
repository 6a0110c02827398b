//! Material of fibres: a law in plane stress, with zero stress across. Beams and trusses use it.

use super::law_column;
use crate::materials::{Elastic, MAX_POINTS, PlaneStress, Points};

/// Number of stress columns of a fibre, before those of the law: along, across, shear.
const STRESS: usize = 3;
/// Largest number of columns of a fibre.
const MOST: usize = 12;
/// Largest number of corrections of the strain across a fibre, and the residual stress across that
/// is accepted, over the modulus.
const CORRECTIONS: usize = 20;
const SETTLED: f64 = 1e-13;

/// Material of the fibres of a part. The columns of a fibre are its stress along, across and in
/// shear [force/length^2], then those of the law.
pub struct FibreMaterial {
    law: Box<dyn PlaneStress>,
    /// Elastic constants and density.
    pub elastic: Elastic,
    /// Number of columns of a fibre.
    pub stride: usize,
    /// Column of a fibre with its effective plastic strain.
    pub plastic_strain: Option<usize>,
    /// Column of a fibre with the mark of its failure.
    pub failed: Option<usize>,
}

impl FibreMaterial {
    /// Builds it from a law, or returns `None` if the law has too many history columns.
    pub fn new(law: Box<dyn PlaneStress>) -> Option<Self> {
        let history = law.history().to_vec();
        (STRESS + history.len() <= MOST).then(|| Self {
            elastic: law.elastic(),
            stride: STRESS + history.len(),
            plastic_strain: law_column(&history, "plastic_strain", STRESS),
            failed: law_column(&history, "failed", STRESS),
            law,
        })
    }

    /// Returns the names of the columns of a fibre.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        let stresses = ["stress along", "stress across", "stress shear"];
        stresses.into_iter().chain(self.law.history().iter().copied())
    }

    /// Updates at most [`MAX_POINTS`] fibres over a step `dt` [time]. `strain` are their increments
    /// along, across and in shear. That across is replaced by the one without stress across; it is
    /// found by the secant method, from the elastic one.
    pub fn strain(&self, states: &mut [f64], strain: &mut [[f64; 3]], dt: f64) {
        let n = strain.len();
        let stiff = self.elastic.plane_stress()[0];
        let mut trial = [0.0; MAX_POINTS * MOST];
        let trial = &mut trial[..states.len()];
        let mut through = [0.0; MAX_POINTS];
        let mut before = [(0.0, 0.0); MAX_POINTS];
        for (k, eps) in strain.iter_mut().enumerate() {
            eps[1] = -self.elastic.poisson * eps[0] - states[k * self.stride + 1] / stiff;
        }
        for correction in 0..CORRECTIONS {
            trial.copy_from_slice(states);
            let points = Points { state: trial, strain, thickness_strain: &mut through[..n] };
            self.law.update_one(points, dt);
            let mut settled = true;
            for (k, eps) in strain.iter_mut().enumerate() {
                let left = trial[k * self.stride + 1];
                if left.abs() <= SETTLED * stiff {
                    continue;
                }
                let (old, old_left) = std::mem::replace(&mut before[k], (eps[1], left));
                let slope = (left - old_left) / (eps[1] - old);
                let secant = correction > 0 && slope.is_finite() && slope > 0.0;
                eps[1] -= left / if secant { slope } else { stiff };
                settled = false;
            }
            if settled {
                break;
            }
        }
        states.copy_from_slice(trial);
    }
}
