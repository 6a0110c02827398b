//! Local Lagrange multipliers (Wang, Wang, Cheng & Yao 2007, eq. 10 to 14): the force that
//! closes the gap at the end of the step, given the forces of all other pairs, iterated over all
//! pairs.
//!
//! With the compliance c = 1/M1 + 1/M2 of the pair, eq. 10 reads
//! `df_n = -(g/dt + n.v) / (dt_damped c)`, where v is the relative mid-step velocity with all
//! present forces applied. The total normal force may not pull. The tangential force sticks to
//! the stick point within the cone mu f_n. [`Iteration`] defines the order of the pairs and the
//! masses in c.

use super::{ContactLaw, GAP, Iteration, LawRow, overlap, split, stuck, within_cone};
use crate::contact::pairs::Pair;
use crate::math::row::V3;
use crate::time::StepSizes;

pub(super) const LAW: LawRow = LawRow {
    name: "lagrange",
    meaning: "Local Lagrange multipliers: forces that close the gaps by the end of the step, \
              iterated over all pairs.",
    build: |c, _| {
        let iteration = ITERATIONS.iter().find(|i| i.0 == c.iteration);
        let iteration = iteration.unwrap_or_else(|| panic!("no iteration {}", c.iteration)).1;
        let carry = if c.accelerated > 0 && c.sweeps > 1 { 1.0 } else { CARRY };
        Box::new(Lagrange { carry, sweeps: c.sweeps, tolerance: c.tolerance, iteration })
    },
};

/// Methods of iteration with their names in a job.
pub const ITERATIONS: &[(&str, Iteration)] =
    &[("split", Iteration::Split), ("gauss_seidel", Iteration::GaussSeidel)];

/// Fraction of the last step's normal force with which sweeps start if none are accelerated.
/// Where sweeps do not converge, as with a light layer between heavy ones, a force that pushes
/// too much decays in a few steps. If it were carried over completely, it would throw the layers
/// apart (`cases/studies/README.md`, sandwich).
const CARRY: f64 = 0.5;

/// Residual of plain sweeps above which accelerated sweeps follow, as a fraction of the velocity
/// that a force has to change. Smaller residuals are removed by the next step's sweeps, which
/// start from the forces of this step. Jeep frame to 12 ms, tolerance 1e-7: 1239 of 7033 steps
/// are accelerated if any residual above the tolerance triggers it, 322 with 1e-4, 25 with 1e-3;
/// penetration is the same. With 1e-3, bricks for which `split` has not converged push each
/// other apart (A07).
const COARSE: f64 = 1e-4;

/// Smallest residual of a force that drops to zero, as a multiple of the permitted residual.
const ENDS: f64 = 2.0;

struct Lagrange {
    carry: f64,
    sweeps: usize,
    tolerance: f64,
    iteration: Iteration,
}

impl ContactLaw for Lagrange {
    fn sweeps(&self) -> usize {
        self.sweeps
    }

    fn iteration(&self) -> Iteration {
        self.iteration
    }

    fn converges(&self) -> bool {
        self.sweeps > 1
    }

    fn coarse(&self) -> f64 {
        (COARSE / self.tolerance).max(1.0)
    }

    fn initial_force(&self, pair: &Pair, _: StepSizes) -> V3 {
        let (pressed, sheared) = split(&pair.force, &pair.normal);
        let pressed = pressed.max(0.0) * self.carry;
        pair.normal * pressed + within_cone(sheared, pressed, pair)
    }

    fn update(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> Option<V3> {
        self.refine(pair, velocity, steps).and_then(|(force, left)| (left > 1.0).then_some(force))
    }

    fn refine(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> Option<(V3, f64)> {
        let [soft_n, soft_t] = pair.compliance.map(|c| steps.dt_damped * c);
        if soft_n <= 0.0 {
            return None; // both sides are fixed
        }
        let (pressed, sheared) = split(&pair.force, &pair.normal);
        let (opening, sliding) = split(velocity, &pair.normal);
        let new_pressed = (pressed - (overlap(pair, steps) / steps.dt + opening) / soft_n).max(0.0);
        let new_sheared = if pair.friction_coefficient > 0.0 {
            within_cone(sheared - (pair.slip / steps.dt + sliding) / soft_t, new_pressed, pair)
        } else {
            V3::zeros()
        };
        // Velocity that is still to be changed, over the velocity that the pair has to change:
        // its approach, and the effect of its force on the side with the smaller compliance.
        // Where masses differ much, a small change of the force is not a small velocity for the
        // lighter side.
        let left =
            (soft_n * (new_pressed - pressed).abs()).max(soft_t * (new_sheared - sheared).norm());
        let whole = pair
            .approach_speed
            .max(steps.dt_damped * pair.stiffer_compliance * new_pressed.max(pressed));
        // A force that drops to zero is updated, however small it is: unchanged, it would
        // continue to push.
        let ends = pressed > 0.0 && new_pressed == 0.0;
        let left = left / (GAP * pair.contact_thickness / steps.dt).max(self.tolerance * whole);
        Some((pair.normal * new_pressed + new_sheared, if ends { left.max(ENDS) } else { left }))
    }

    fn slip(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> V3 {
        stuck(pair, velocity, steps)
    }
}
