//! A dashpot between slave and contact point: `f = -d v_n` while the surfaces penetrate, with the
//! coefficient `d = scale/(c dt)`.
//!
//! The force is that of the velocity that it leaves, `f = -d v/(1 + d c dt)`, so that it does not
//! lower the stable step. Left out: friction, removal of the penetration.

use crumple_worker::contact::enforce::{ContactLaw, Iteration, LawRow};
use crumple_worker::contact::pairs::Pair;
use crumple_worker::math::row::V3;
use crumple_worker::parameter::{DefaultValue, Form, ParameterRow, Range};
use crumple_worker::time::StepSizes;

/// The row of this law.
pub static LAW: LawRow = LawRow {
    name: "damper",
    meaning: "A dashpot between slaves and segments that penetrate.",
    parameters: &[ParameterRow {
        key: "damper_scale",
        form: Form::Number,
        otherwise: DefaultValue::Number(0.35),
        range: Some(Range { wanted: "above 0", fits: |scale| scale > 0.0 }),
        meaning: "Factor on the coefficient of the dashpot.",
    }],
    global: &[],
    conflict: |_, _| None,
    build: |values, _| Box::new(Damper { scale: values.number("damper_scale") }),
};

struct Damper {
    scale: f64,
}

impl ContactLaw for Damper {
    fn sweeps(&self) -> usize {
        1
    }

    fn iteration(&self) -> Iteration {
        Iteration::Split
    }

    fn initial_force(&self, _: &Pair, _: StepSizes) -> V3 {
        V3::zeros()
    }

    fn update(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> Option<V3> {
        let compliance = pair.compliance[0];
        if compliance <= 0.0 || pair.gap >= 0.0 {
            return None; // both sides are fixed, or nothing penetrates
        }
        let damping = self.scale / (compliance * steps.dt);
        let pressed =
            -damping * velocity.dot(&pair.normal) / (1.0 + damping * compliance * steps.dt_damped);
        Some(pair.normal * pressed.max(0.0))
    }

    fn slip(&self, _: &Pair, _: &V3, _: StepSizes) -> V3 {
        V3::zeros()
    }
}
