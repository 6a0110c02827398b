//! Penalty: a spring between node and contact point, and one from the stick point, limited to
//! the friction cone.
//!
//! The stiffness k has two forms, with the compliance c = 1/M1 + 1/M2 of the pair:
//! - *soft*, from masses and the step, `k = scale / (c dt^2)`: below the central difference
//!   limit whatever the material (the form that LS-DYNA calls SOFT=1; Hallquist, LS-DYNA theory
//!   manual, ch. 29);
//! - *stiffness*, from the segment's material and its shape in the mesh: `k = scale E A / d`
//!   with the face's area A and for d a shell's longest diagonal (same source, ch. 29, the
//!   standard penalty), or a solid's depth: there A^2/V is A/d, and the source's bulk modulus is
//!   replaced by E, so that a scale of 1 is as stiff as a bar of the elements. A beam is a strip
//!   as wide as it is thick, d its length. The step may be too long for this form.
//!
//! **Damping.** A dashpot of `2 damping sqrt(k / c)` parallel to the normal spring, which never
//! pulls. Without it, nodes that slide or rest on springs chatter. Its force is computed from
//! the velocity after the step (implicit), so that it does not lower the stable step.
//!
//! **Begin and end of a contact.** Forces act at the ends of steps. In the step in which a spring
//! gets its first compression, its full force takes up to `1/8 k (v dt)^2` too much energy; in the
//! step after which it is free, the full force gives too much. Between two times with the
//! compressions d and d' central differences keep `1/2 m u^2 + 1/2 k d d'`, where u is the velocity
//! between them. Therefore the first impulse J of a spring takes exactly `1/2 k d d'` from the
//! kinetic energy: `J (v + u)/2 = 1/2 k d (d + u dt)` with the speeds of approach v before and u
//! after it. The last impulse returns `1/2 k d d'` of the step before. Both are less than `k d dt`.
//! A single undamped pair without friction then keeps its energy to round-off, at constant steps,
//! masses and stiffness; others do so approximately.
//!
//! **Friction** acts from the first force of a contact on: its spring is stretched by the
//! distance slid since the contact began within the step before. Without that a body that
//! chatters would lose the friction of a fraction of a step in every contact.
//!
//! Where friction turns nodes, the compliance c of its spring includes their rotations; its
//! stiffness is reduced so that k c is the same as without them.
//!
//! **Bound.** Springs raise the highest frequency. By Weyl's inequality omega^2 is at most that
//! of the elements, `(2 safety / dt)^2`, plus that of the contact springs alone. The latter is
//! at most the largest `k c` of a pair when every nodal mass is split among the pairs that use
//! it (Rayleigh quotient, node by node). Therefore central differences stay stable while
//! `k c dt^2 <= 4 (1 - safety^2)`. Near that limit they are stable but not accurate. Therefore
//! no stiffness above half of it is used unless the job requests it (`cases/studies/README.md`,
//! penalty-map).

use super::{
    ContactLaw, DefaultValue, Elasticity, Form, Iteration, LawRow, ParameterRow, Range, Values,
    split, within_cone,
};
use crate::pairs::Pair;
use crate::surface::Segment;
use crumple_fem::time::StepSizes;
use crumple_math::row::{Row, V3};
use crumple_proto::problem::Problem;

pub(super) const LAW: LawRow = LawRow {
    name: "penalty",
    meaning: "Penalty springs between slaves and the segments that they penetrate.",
    parameters: PARAMETERS,
    global: &[],
    conflict: no_margin,
    build: |values, parts| Box::new(Penalty::new(values, parts)),
};

/// Names of the forms of the stiffness in a job.
const SOFT: &str = "soft";
const STIFFNESS: &str = "stiffness";

pub(super) const PARAMETERS: &[ParameterRow] = &[
    ParameterRow {
        key: "penalty_form",
        form: Form::Word(&[SOFT, STIFFNESS]),
        otherwise: DefaultValue::Word(SOFT),
        range: None,
        meaning: "Form of the penalty stiffness: `soft`, from nodal masses and the step, or \
                  `stiffness`. `stiffness` is E A / d with Young's modulus E and area A of the \
                  segment, and d the shortest edge of a solid or the longest diagonal of a shell. \
                  With the law `mortar` it is the stiffness of a pressure. See \
                  `cases/studies/README.md`, reversal and hertz.",
    },
    ParameterRow {
        key: "penalty_scale",
        form: Form::Number,
        otherwise: DefaultValue::Number(0.35),
        range: Some(Range {
            wanted: "above 0; 0.1 to 0.4 is usual for the soft form",
            fits: |scale| scale > 0.0,
        }),
        meaning: "Factor on the penalty stiffness of either form. See `cases/studies/README.md`, \
                  bars, reversal and penalty-map.",
    },
    ParameterRow {
        key: "penalty_damping",
        form: Form::Number,
        otherwise: DefaultValue::Number(0.1),
        range: Some(Range { wanted: "from 0 to 1", fits: |d| (0.0..=1.0).contains(&d) }),
        meaning: "Normal damping of the penalty, as a fraction of the critical damping of the \
                  masses in contact. Without damping, a sliding body bounces on the contact \
                  springs, and its friction is too small (`cases/studies/README.md`, slide). With \
                  0.1 an impact of bars loses as much as with the Lagrange law.",
    },
    ParameterRow {
        key: "penalty_cap",
        form: Form::Flag,
        otherwise: DefaultValue::Flag(true),
        range: None,
        meaning: "Reduce the penalty stiffness where it would make the step unstable, with a \
                  warning. Without it a run may become unstable (`cases/studies/README.md`, \
                  penalty-map).",
    },
];

/// Returns the problem of a safety factor that leaves nothing to the springs.
pub(super) fn no_margin(values: &Values<'_>, safety: f64) -> Option<Problem> {
    (values.flag("penalty_cap") && safety >= 1.0).then(|| {
        let message = format!("safety = {safety} leaves penalty springs no margin of stability");
        let help = "reduce it (0.9 is usual), or use contact.law lagrange or kinematic, which need \
                    no margin";
        Problem::error("time.safety", message, help)
    })
}

pub(super) struct Penalty {
    scale: f64,
    /// Fraction of critical damping.
    damping: f64,
    /// Young's modulus per part, if stiffness comes from the material [force/length^2].
    moduli: Option<Vec<f64>>,
    /// Upper limit of `k c dt^2`.
    most: f64,
}

impl Penalty {
    pub(super) fn new(values: &Values<'_>, parts: &Elasticity) -> Self {
        let moduli = (values.word("penalty_form") == STIFFNESS).then(|| parts.moduli.clone());
        let room = 0.5 * 4.0 * (1.0 - parts.safety * parts.safety);
        let most = if values.flag("penalty_cap") { room.max(0.0) } else { f64::INFINITY };
        let (scale, damping) = (values.number("penalty_scale"), values.number("penalty_damping"));
        Self { scale, damping, moduli, most }
    }

    /// Returns the stiffness that the job requests, and the largest one with a stable step
    /// [force/length].
    fn wanted(&self, pair: &Pair, steps: StepSizes) -> (f64, f64) {
        let per_step = steps.dt_stable * steps.dt_stable;
        let (soft_n, soft_t) = (
            pair.compliance[0] * per_step,
            (pair.compliance[1] - pair.rotational_compliance) * per_step,
        );
        if soft_n <= 0.0 {
            return (0.0, 0.0); // both sides are fixed
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
        // A triangle, whose fourth corner is its third, has no diagonals; its longest side
        // replaces them.
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
            return None; // both sides are fixed
        }
        let opening = velocity.dot(&pair.normal);
        let share = share_of_impulse(pair, k, opening, steps);
        let damper = 2.0 * self.damping * (k / c).sqrt() * share;
        let spring = (-k * pair.gap).max(0.0) * share;
        let damped = (spring - damper * opening) / (1.0 + damper * c * steps.dt_damped);
        let pressed = if spring > 0.0 { damped.max(0.0) } else { 0.0 };
        Some(pair.normal * pressed + within_cone(pair.slip * -tangential(pair, k), pressed, pair))
    }

    fn slip(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> V3 {
        let (pressed, sheared) = split(&pair.force, &pair.normal);
        let (opening, sliding) = split(velocity, &pair.normal);
        let k = self.stiffness(pair, steps);
        if pressed <= 0.0 || k <= 0.0 {
            // A contact that begins within the step sticks where it begins. The normal spring
            // has been compressed since then, so the tangential spring is stretched too, and the
            // first force of the contact includes friction.
            let sunk = pair.gap + opening * steps.dt;
            let since =
                if sunk < 0.0 && opening < 0.0 { (sunk / opening).min(steps.dt) } else { 0.0 };
            return sliding * since;
        }
        // Where the cone limits the force, the stick point is dragged along.
        let stretched = sheared / -tangential(pair, k);
        stretched + sliding * steps.dt
    }

    fn is_capped(&self, pair: &Pair, steps: StepSizes) -> bool {
        let (k, most) = self.wanted(pair, steps);
        k > most && pair.force != V3::zeros()
    }
}

/// Returns the share of a spring's full impulse that keeps energy where the contact begins or ends,
/// else 1 (see the head of the file, with `dt_damped` for the impulse). `opening` is the relative
/// velocity along the normal at the next mid-step without the force of the spring, which has the
/// stiffness `k`.
fn share_of_impulse(pair: &Pair, k: f64, opening: f64, steps: StepSizes) -> f64 {
    let depth = -pair.gap;
    let whole = k * depth * steps.dt_damped;
    if whole <= 0.0 {
        return 1.0;
    }
    let (before, dt, c) = (pair.opening_before, steps.dt, pair.compliance[0]);
    let depth_before = depth + before * steps.dt_before();
    let leaves = depth < (opening + c * whole) * dt;
    let impulse = match (depth_before < 0.0, leaves) {
        // The smaller root of `c J^2 - b J + e = 0`. With equal steps b is above zero.
        (true, false) => {
            let b = c * whole - opening - before;
            let e = k * depth * (depth - opening * dt);
            let root = (b * b - 4.0 * c * e).max(0.0).sqrt();
            if b > 0.0 { 2.0 * e / (b + root) } else { whole }
        }
        // The larger root of `c J^2 + b J - e = 0`.
        (false, true) => {
            let b = opening + before;
            let e = k * depth * depth_before;
            if e > 0.0 { 2.0 * e / (b + (b * b + 4.0 * c * e).sqrt()) } else { 0.0 }
        }
        // A pair that gets its first compression and is free again in one step has a spring that is
        // too stiff for the step, or is opened by other forces. It has the full impulse, so that
        // too large a stiffness shows (A24).
        (true, true) | (false, false) => whole,
    };
    (impulse / whole).clamp(0.0, 1.0)
}

/// Returns the stiffness of the spring from the stick point, where the normal spring has the
/// stiffness `k` [force/length]. It is smaller where friction turns nodes, because the rotation
/// would raise the frequency of the spring.
fn tangential(pair: &Pair, k: f64) -> f64 {
    let [_, soft] = pair.compliance;
    if pair.rotational_compliance > 0.0 && pair.rotational_compliance < soft {
        k * (1.0 - pair.rotational_compliance / soft)
    } else {
        k
    }
}
