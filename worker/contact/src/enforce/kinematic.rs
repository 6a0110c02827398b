//! Partitioned kinematic predictor-corrector (Taylor & Flanagan 1989; Attaway et al. 1998, eq.
//! 18 to 27).
//!
//! Predictor: with the present velocities a node s ends the step by `delta` inside a segment. If
//! the segment stood still, `f_s = m_s delta / (dt dt_damped)` would put the node on its
//! surface. Corrector: under all predictor forces the segment's nodes move by
//! `a_i = sum_s N_i f_s / (m_i + sum_s N_i m_s)` and the contact point by `a_p = sum_i N_i a_i`.
//! Therefore `f = f_s - m_s a_p` is enough. Each force acts on the node and, with the opposite
//! sign, on the segment, so that momentum is conserved to round-off. The source makes one such
//! pass per step (`sweeps = 1`) and leaves the residual to the next step. Further passes start
//! from the result of the last one, and may take back an excess.
//!
//! Two points differ from the source.
//! - The correction is exact for nodes at the centre of a segment of equal masses. Elsewhere it
//!   is too strong, by up to `sum_i m_i / m` for a heavy node near a corner of a light segment.
//!   Therefore no correction is larger than the one that would close the pair's own gap alone,
//!   `f_s / (m_s c)` with the compliance c = 1/m_s + sum N_i^2/m_i.
//! - A fixed node has no usable mass; it counts as a very heavy one (`FIXED_MASS_RATIO` in
//!   `pairs.rs`).
//!
//! **Partition.** Where two surfaces touch, each is slave of the other, and both would close the
//! gap. The surface of the lower part, or of the lower segment within a part, takes the fraction
//! beta of each correction, the other surface 1 - beta. A pair is one-sided, and gets the whole
//! correction, if no node of its segment is pushed back by a pair from the same side. Example: a
//! node at mid-face of a coarse mesh whose corners touch nothing closes its gap in the first
//! pass. If corners do touch elsewhere, a pair at mid-face gets its fraction only, and each
//! further pass leaves 1 - beta or beta of the residual: gaps are never closed twice. With one
//! pass per step such pairs penetrate while the bodies decelerate. Where one surface is fixed, the
//! free one takes the whole correction: fixed nodes with a share of the load would let a block
//! creep on them under a pull below mu N.
//!
//! Friction is computed in the same way from the tangential distance to the stick point, with
//! its total within the cone. Where friction turns nodes, the slave's mass is that of its
//! translation and its rotation together, `1 / (1/m_s + a^2/I_s)` with the lever arm a.

use super::{
    ContactLaw, DefaultValue, Form, GAP, Iteration, LawRow, ParameterRow, Range, SWEEPS, TOLERANCE,
    no_longer, overlap, split, stuck, within_cone,
};
use crate::pairs::Pair;
use crumple_fem::time::StepSizes;
use crumple_math::row::V3;

pub(super) const LAW: LawRow = LawRow {
    name: "kinematic",
    meaning: "Partitioned kinematic predictor and corrector, as in PRONTO3D.",
    parameters: &[
        SWEEPS,
        TOLERANCE,
        ParameterRow {
            key: "partition",
            form: Form::Number,
            otherwise: DefaultValue::Number(0.5),
            range: Some(Range {
                wanted: "between 0 and 1; 0.5 treats both surfaces alike",
                fits: |beta| (0.0..=1.0).contains(&beta),
            }),
            meaning: "Partition factor beta: fraction of the correction that one surface takes as \
                      slave of the other. It is the surface of the lower part, or within a part \
                      of the lower element. The other surface takes the rest as slave of the \
                      first. Pairs whose surfaces are not slaves of each other are not \
                      partitioned. See `cases/studies/README.md`, bars-solids.",
        },
    ],
    global: &[],
    conflict: |_, _| None,
    build: |values, _| {
        Box::new(Kinematic {
            partition: values.number("partition"),
            sweeps: values.whole("sweeps"),
            tolerance: values.number("tolerance"),
        })
    },
};

struct Kinematic {
    partition: f64,
    sweeps: usize,
    tolerance: f64,
}

/// Fraction of a force that round-off leaves open, whatever the tolerance.
const LITTLE: f64 = 1e-6;

/// Returns the force that moves the slave's mass to the surface and to the stick point within
/// the step, normal and tangential, if the segment moves as `velocity` says [force]. Friction
/// that turns the slave moves a smaller mass.
fn needed(pair: &Pair, velocity: &V3, steps: StepSizes) -> (f64, V3) {
    let (opening, sliding) = split(velocity, &pair.normal);
    let per_step = -pair.slave_mass / steps.dt_damped;
    let across = -pair.slave_sliding_mass / steps.dt_damped;
    (
        per_step * (overlap(pair, steps) / steps.dt + opening),
        (pair.slip / steps.dt + sliding) * across,
    )
}

impl ContactLaw for Kinematic {
    fn sweeps(&self) -> usize {
        self.sweeps
    }

    fn iteration(&self) -> Iteration {
        Iteration::Correct { partition: self.partition, little: self.tolerance.max(LITTLE) }
    }

    fn initial_force(&self, _: &Pair, _: StepSizes) -> V3 {
        V3::zeros()
    }

    fn guess(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> V3 {
        let (pressed, sheared) = split(&pair.force, &pair.normal);
        let (more, pull) = needed(pair, velocity, steps);
        let more = more.max(-pressed);
        pair.normal * more + within_cone(sheared + pull, pressed + more, pair) - sheared
    }

    /// Here `velocity` is the velocity of the node relative to the contact point under all
    /// predictor forces.
    fn update(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> Option<V3> {
        let (guess_n, guess_t) = split(&pair.predictor_force, &pair.normal);
        // Fractions of the predictor forces that close this pair's gap alone.
        let [alone_n, alone_t] =
            pair.compliance.map(|c| if c > 0.0 { 1.0 / (pair.slave_mass * c) } else { 0.0 });
        let (more, pull) = needed(pair, velocity, steps);
        let limit = guess_n * alone_n;
        let more = more.clamp(limit.min(0.0), limit.max(0.0));
        let most = if pair.has_couple() {
            pair.max_tangential_correction
        } else {
            guess_t.norm() * alone_t
        };
        let pull = no_longer(pull, most);
        let (pressed, sheared) = split(&pair.force, &pair.normal);
        let new_pressed = (pressed + pair.partition_factor * more).max(0.0);
        let new_sheared = within_cone(sheared + pull * pair.partition_factor, new_pressed, pair);
        let change = (new_pressed - pressed).abs();
        // Friction under a light load is small against the gap's tolerance, but it is needed.
        let turns =
            (new_sheared - sheared).norm() > self.tolerance * pair.friction_force(new_pressed);
        let floor =
            GAP * pair.contact_thickness * pair.slave_mass * alone_n / (steps.dt * steps.dt_damped);
        let ends = pressed > 0.0 && new_pressed == 0.0;
        (ends || turns || change > floor.max(self.tolerance * new_pressed.max(pressed)))
            .then(|| pair.normal * new_pressed + new_sheared)
    }

    fn slip(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> V3 {
        stuck(pair, velocity, steps)
    }
}
