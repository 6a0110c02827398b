//! The damper with a coefficient that has no default.

use super::damper;
use crumple_worker::contact::enforce::LawRow;
use crumple_worker::parameter::{DefaultValue, Form, ParameterRow, Values};
use std::collections::BTreeMap;

/// The row of this law.
pub static LAW: LawRow = LawRow {
    name: "strict",
    meaning: "A dashpot whose coefficient has no default.",
    parameters: &[ParameterRow {
        key: "strict_scale",
        form: Form::Number,
        otherwise: DefaultValue::Needed,
        range: None,
        meaning: "Factor on the coefficient of the dashpot.",
    }],
    global: &[],
    conflict: |values, _| {
        assert!(values.number("strict_scale").is_finite(), "it is called with all required keys");
        None
    },
    build: |values, parts| {
        let given =
            BTreeMap::from([("damper_scale".to_string(), values.number("strict_scale").into())]);
        (damper::LAW.build)(&Values::new([damper::LAW.parameters, &[]], &given), parts)
    },
};
