//! A spring between slave and contact point that holds no friction, `f = -s g/(c dt^2)` while the
//! surfaces penetrate, with the key `stickiness` s.

use crumple_worker::contact::enforce::{ContactLaw, Iteration, LawRow};
use crumple_worker::contact::pairs::Pair;
use crumple_worker::math::row::V3;
use crumple_worker::parameter::{DefaultValue, Form, ParameterRow, Range};
use crumple_worker::time::StepSizes;

/// The row of this law.
pub static LAW: LawRow = LawRow {
    name: "sticky",
    meaning: "Springs of a test.",
    parameters: &[ParameterRow {
        key: "stickiness",
        form: Form::Number,
        otherwise: DefaultValue::Number(0.25),
        range: Some(Range { wanted: "from 0 to 1", fits: |s| (0.0..=1.0).contains(&s) }),
        meaning: "Stiffness of the springs over that of one step.",
    }],
    global: &[],
    conflict: |_, _| None,
    build: |values, _| Box::new(Sticky { stickiness: values.number("stickiness") }),
};

struct Sticky {
    stickiness: f64,
}

impl ContactLaw for Sticky {
    fn sweeps(&self) -> usize {
        1
    }

    fn iteration(&self) -> Iteration {
        Iteration::Split
    }

    fn initial_force(&self, _: &Pair, _: StepSizes) -> V3 {
        V3::zeros()
    }

    fn update(&self, pair: &Pair, _: &V3, steps: StepSizes) -> Option<V3> {
        let compliance = pair.compliance[0];
        let stiffness = self.stickiness / (compliance * steps.dt * steps.dt);
        (compliance > 0.0).then(|| pair.normal * (-stiffness * pair.gap).max(0.0))
    }

    fn slip(&self, _: &Pair, _: &V3, _: StepSizes) -> V3 {
        V3::zeros()
    }
}
