//! Local Lagrange multipliers (Wang, Wang, Cheng & Yao 2007, eq. 10 to 14): the force that
//! closes the gap at the end of the step, given the forces of all other pairs, iterated over all
//! pairs.
//!
//! With the compliance c = 1/M1 + 1/M2 of the pair, eq. 10 reads
//! `df_n = -(g/dt + n.v) / (dt_damped c)`, where v is the relative mid-step velocity with all
//! present forces applied. The total normal force may not pull. The tangential force sticks to
//! the stick point within the cone mu f_n. [`Iteration`] defines the order of the pairs and the
//! masses in c.

use super::{
    ContactLaw, DefaultValue, Form, GAP, Iteration, LawRow, ParameterRow, SWEEPS, TOLERANCE,
    overlap, split, stuck, within_cone,
};
use crate::pairs::Pair;
use crumple_fem::time::StepSizes;
use crumple_math::row::V3;

pub(super) const LAW: LawRow = LawRow {
    name: "lagrange",
    meaning: "Local Lagrange multipliers: forces that close the gaps by the end of the step, \
              iterated over all pairs.",
    parameters: &[
        ParameterRow {
            key: "iteration",
            form: Form::Word(&[AUTO, SPLIT, GAUSS_SEIDEL]),
            otherwise: DefaultValue::Word(AUTO),
            range: None,
            meaning: "Iteration for coupled pairs. `split` updates all pairs from the same state, \
                      with nodal masses split among their pairs and with momentum (Nesterov); \
                      workers exchange one message per sweep. `gauss_seidel` updates one pair \
                      after the other, in an order that does not depend on the workers: fewer \
                      sweeps, but many messages where contact is dense. `auto` (default): `split` \
                      if the step before had 300 pairs or more and sweeps can be accelerated, else \
                      `gauss_seidel` (`cases/bench/RESULTS.md`).",
        },
        SWEEPS,
        TOLERANCE,
    ],
    global: &[ParameterRow {
        key: "accelerated",
        form: Form::Whole,
        otherwise: DefaultValue::Whole(100),
        range: None,
        meaning: "Largest number of accelerated sweeps in a step; 0 for none. They follow if the \
                  plain sweeps leave more than 1e-4 of the velocity that a force has to change, \
                  or sweeps with momentum more than 1e-5. This happens with layers of less than \
                  a hundredth of the mass of their neighbours. With `sweeps = 1` none follow. \
                  See `cases/studies/README.md`, sandwich.",
    }],
    conflict: |_, _| None,
    build: |values, parts| {
        let iteration = match values.word("iteration").as_str() {
            AUTO if parts.is_dense => Iteration::Split,
            AUTO => Iteration::GaussSeidel,
            SPLIT => Iteration::Split,
            GAUSS_SEIDEL => Iteration::GaussSeidel,
            other => panic!("no iteration {other}"),
        };
        let (sweeps, accelerated) = (values.whole("sweeps"), values.whole("accelerated"));
        let carry = if accelerated > 0 && sweeps > 1 { 1.0 } else { CARRY };
        let tolerance = values.number("tolerance");
        Box::new(Lagrange { carry, sweeps, accelerated, tolerance, iteration })
    },
};

/// Names of the iterations in a job.
const AUTO: &str = "auto";
const SPLIT: &str = "split";
const GAUSS_SEIDEL: &str = "gauss_seidel";

/// Fraction of the last step's normal force with which sweeps start if none are accelerated.
/// Where sweeps do not converge, as with a light layer between heavy ones, a force that pushes
/// too much decays in a few steps. If it were carried over completely, it would throw the layers
/// apart (`cases/studies/README.md`, sandwich).
const CARRY: f64 = 0.5;

/// Largest number of sweeps with momentum (`contact/nesterov.rs`), as a multiple of the largest
/// number of plain sweeps: they cost less than accelerated sweeps, which have global reductions.
/// Brick wall, 246 cycles on one worker, CPU of contact with 1, 3, 4, 6: 1.48, 0.50, 0.42, 0.40 s.
const MOMENTUM_SWEEPS: usize = 4;

/// Residual of plain sweeps above which accelerated sweeps follow, as a fraction of the velocity
/// that a force has to change. Smaller residuals are removed by the next step's sweeps, which
/// start from the forces of this step. Jeep frame to 12 ms, tolerance 1e-7: 1239 of 7033 steps
/// are accelerated if any residual above the tolerance triggers it, 322 with 1e-4, 25 with 1e-3;
/// penetration is the same. With 1e-3, bricks for which `split` has not converged push each
/// other apart (A07).
const COARSE: f64 = 1e-4;
/// The same after sweeps with momentum. With 1e-4, rows of three bodies of a tenth of the mass of
/// their neighbours end with errors of 4e-5 (`accelerated_sweeps_settle_whatever_the_masses`).
const COARSE_WITH_MOMENTUM: f64 = 1e-5;

/// Smallest residual of a force that drops to zero, as a multiple of the permitted residual.
const ENDS: f64 = 2.0;

struct Lagrange {
    carry: f64,
    sweeps: usize,
    accelerated: usize,
    tolerance: f64,
    iteration: Iteration,
}

impl ContactLaw for Lagrange {
    fn sweeps(&self) -> usize {
        match self.iteration {
            Iteration::Split if self.sweeps > 1 => MOMENTUM_SWEEPS * self.sweeps,
            _ => self.sweeps,
        }
    }

    fn iteration(&self) -> Iteration {
        self.iteration
    }

    fn accelerated(&self) -> usize {
        self.accelerated
    }

    fn converges(&self) -> bool {
        self.sweeps > 1
    }

    fn coarse(&self) -> f64 {
        let coarse = match self.iteration {
            Iteration::Split => COARSE_WITH_MOMENTUM,
            _ => COARSE,
        };
        (coarse / self.tolerance).max(1.0)
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
            return None; // both sides are fixed, or the pair is redundant
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
