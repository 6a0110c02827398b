//! J2 (von Mises) plasticity with the power law of Ludwik (1909), `sig_y = a + b eps_p^n`
//! [force/length^2]. The return to the yield surface is in `plasticity`.
//!
//! Valid for 0 < n <= 1. `b eps_p^n` is a straight line below eps_p = 1e-5.
//!
//! Left out: strain rate, heat, failure.

use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;
use crumple_worker::fem::materials::plasticity::{
    Coefficients, FailureCriterion, Plasticity, Rate, YieldCurve,
};
use crumple_worker::fem::materials::{
    DefaultValue, ELASTIC, Elastic, Form, Law, LawResult, ParameterRow, Parameters, SolidLawResult,
};

/// The row of this law.
pub static LAW: Law = Law {
    name: "ludwik",
    meaning: "Von Mises plasticity with Ludwik's power law.",
    constants: ELASTIC,
    parameters: PARAMETERS,
    build: Some(build),
    solid: Some(solid),
    cohesive: None,
};

const PARAMETERS: &[ParameterRow] = &[
    ParameterRow {
        key: "a",
        form: Form::Number,
        otherwise: DefaultValue::Needed,
        range: None,
        meaning: "Yield stress at zero plastic strain [force/length^2].",
    },
    ParameterRow {
        key: "b",
        form: Form::Number,
        otherwise: DefaultValue::Needed,
        range: None,
        meaning: "Hardening, `a + b strain^n` [force/length^2].",
    },
    ParameterRow {
        key: "n",
        form: Form::Number,
        otherwise: DefaultValue::Needed,
        range: None,
        meaning: "Exponent of hardening.",
    },
];

fn build(material: &Material) -> LawResult {
    Parameters::new(material).shell_law(read)
}

fn solid(material: &Material) -> SolidLawResult {
    Parameters::new(material).solid_law(read)
}

/// The law from its parameters.
fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<Plasticity, Vec<Problem>> {
    let a = parameters.required("a", "above 0", |a| a > 0.0);
    let b = parameters.required("b", "0 or above", |b| b >= 0.0);
    let n = parameters.required("n", "above 0 and at most 1", |n| n > 0.0 && n <= 1.0);
    parameters.finish()?;
    Ok(Plasticity {
        coefficients: Coefficients::new(&elastic, a),
        elastic,
        yield_stress: a,
        curve: YieldCurve::Power { b: b / a, n, largest: f64::INFINITY },
        rate: Rate::None,
        thermal: None,
        failure: FailureCriterion::None,
    })
}
