//! Penalty: a spring between node and contact point, and one from the stick point, held within the
//! friction cone.
//!
//! Two forms of its stiffness k, with the compliance c = 1/M1 + 1/M2 of the pair:
//! - *soft*, from masses and the step, `k = scale / (c dt^2)`: below the central difference limit
//!   whatever the material (the kind that LS-DYNA calls SOFT=1; Hallquist, LS-DYNA theory manual,
//!   ch. 29);
//! - *stiffness*, from the segment's material and shape as the mesh is given: `k = scale E A / d`
//!   with the face's area A and a shell's longest diagonal (same source, ch. 29, the standard
//!   penalty), or a solid's depth, for d: there A^2/V is A/d, and the source's bulk modulus is
//!   replaced by E, so that a scale of 1 is as stiff as a bar of the elements. A beam is a strip as
//!   wide as it is thick, d its length. The step may be too long for it.
//!
//! **Damping.** A dashpot of `2 damping sqrt(k / c)` beside the normal spring, never pulling:
//! without it what slides or rests on springs chatters. Its force is that of the velocity which it
//! leaves, so it does not lower the stable step.
//!
//! **Friction** acts from the first force of a touch on: its spring is stretched by the way that is
//! slid since the touch began within the step before. Without that a body which chatters loses
//! friction's share of a step in every touch.
//!
//! Where it turns nodes the compliance c of its spring has a part of their rotations too; its
//! stiffness is less by so much that k c is as without them.
//!
//! **Bound.** Springs add to the highest frequency: by Weyl's inequality omega^2 is at most that of
//! the elements, `(2 safety / dt)^2`, plus that of the contact springs alone. The latter is at most
//! the largest `k c` of a pair when every nodal mass is split among the pairs that use it (Rayleigh
//! quotient, node by node). So central differences stay stable while `k c dt^2 <= 4 (1 -
//! safety^2)`. Near that they are stable but not accurate, so no stiffness above half of it is used
//! unless the job says so (`cases/studies/README.md`, penalty-map).

use super::{ContactLaw, Elasticity, Iteration, LawRow, StepSizes, split, within_cone};
use crate::contact::geometry::V3;
use crate::contact::pairs::Pair;
use crate::contact::surface::Segment;
use crate::nodes::Row;
use crumple_proto::job::Contact;

pub(super) const LAW: LawRow = LawRow {
    name: "penalty",
    meaning: "Springs between nodes and what they sink into.",
    build: |c, parts| Box::new(Penalty::new(c, parts)),
};

/// Forms of the stiffness, as a job names them.
pub const FORMS: &[&str] = &["soft", "stiffness"];

pub(super) struct Penalty {
    scale: f64,
    /// Fraction of critical damping.
    damping: f64,
    /// Young's modulus per part, if stiffness comes from the material.
    moduli: Option<Vec<f64>>,
    /// Most `k c dt^2`.
    most: f64,
}

impl Penalty {
    pub(super) fn new(job: &Contact, parts: &Elasticity) -> Self {
        let moduli = (job.penalty_form == "stiffness").then(|| parts.moduli.clone());
        let room = 0.5 * 4.0 * (1.0 - parts.safety * parts.safety);
        let most = if job.penalty_cap { room.max(0.0) } else { f64::INFINITY };
        Self { scale: job.penalty_scale, damping: job.penalty_damping, moduli, most }
    }

    /// Stiffness as the job asks for it, and the most that keeps the step stable [force/length].
    fn wanted(&self, pair: &Pair, steps: StepSizes) -> (f64, f64) {
        let per_step = steps.dt_stable * steps.dt_stable;
        let (soft_n, soft_t) = (
            pair.compliance[0] * per_step,
            (pair.compliance[1] - pair.rotational_compliance) * per_step,
        );
        if soft_n <= 0.0 {
            return (0.0, 0.0); // both sides are held fixed
        }
        let k =
            if self.moduli.is_some() { self.scale * pair.stiffness } else { self.scale / soft_n };
        (k, self.most / soft_n.max(soft_t))
    }

    fn stiffness(&self, pair: &Pair, steps: StepSizes) -> f64 {
        let (k, most) = self.wanted(pair, steps);
        k.min(most)
    }
}

impl ContactLaw for Penalty {
    fn sweeps(&self) -> usize {
        1
    }

    fn iteration(&self) -> Iteration {
        Iteration::Split
    }

    fn segment_stiffness(&self, segment: &Segment, x0: &[Row]) -> Option<f64> {
        let [a, b, c, d] = segment.corners(x0);
        let (one, other) = (c - a, d - b);
        // A triangle, whose fourth corner is its third, has no diagonals; its longest side stands
        // for them.
        let third = if segment.is_triangle() { (b - a).norm() } else { 0.0 };
        let shell = one.norm().max(other.norm()).max(third);
        let depth = if segment.is_solid() { segment.depth() } else { shell };
        // A line is a strip as wide as the beam.
        let line = 2.0 * segment.half_thickness * third;
        let area = if segment.is_line() { line } else { 0.5 * one.cross(&other).norm() };
        self.moduli.as_ref().map(|moduli| moduli[segment.part as usize] * area / depth)
    }

    fn initial_force(&self, _: &Pair, _: StepSizes) -> V3 {
        V3::zeros()
    }

    fn update(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> Option<V3> {
        let (k, c) = (self.stiffness(pair, steps), pair.compliance[0]);
        if c <= 0.0 {
            return None; // both sides are held fixed
        }
        let damper = 2.0 * self.damping * (k / c).sqrt();
        let spring = (-k * pair.gap).max(0.0);
        let damped =
            (spring - damper * velocity.dot(&pair.normal)) / (1.0 + damper * c * steps.dt_damped);
        let pressed = if spring > 0.0 { damped.max(0.0) } else { 0.0 };
        Some(pair.normal * pressed + within_cone(pair.slip * -tangential(pair, k), pressed, pair))
    }

    fn slip(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> V3 {
        let (pressed, sheared) = split(&pair.force, &pair.normal);
        let (opening, sliding) = split(velocity, &pair.normal);
        let k = self.stiffness(pair, steps);
        if pressed <= 0.0 || k <= 0.0 {
            // A touch that begins within the step sticks to where it begins: as the normal spring
            // has sunk in by then, so the tangential one is stretched, and the first force of a
            // touch has its friction.
            let sunk = pair.gap + opening * steps.dt;
            let since =
                if sunk < 0.0 && opening < 0.0 { (sunk / opening).min(steps.dt) } else { 0.0 };
            return sliding * since;
        }
        // Where the cone cut the force, the stick point is dragged along.
        let stretched = sheared / -tangential(pair, k);
        stretched + sliding * steps.dt
    }

    fn is_capped(&self, pair: &Pair, steps: StepSizes) -> bool {
        let (k, most) = self.wanted(pair, steps);
        k > most && pair.force != V3::zeros()
    }
}

/// Stiffness of the spring from the stick point, where the normal one has the stiffness `k`
/// [force/length]. What turns would make it swing faster.
fn tangential(pair: &Pair, k: f64) -> f64 {
    let [_, soft] = pair.compliance;
    if pair.rotational_compliance > 0.0 && pair.rotational_compliance < soft {
        k * (1.0 - pair.rotational_compliance / soft)
    } else {
        k
    }
}
