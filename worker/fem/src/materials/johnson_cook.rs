//! Johnson & Cook 1983 plasticity with adiabatic heating, and failure of Johnson & Cook 1985:
//! ```text
//! sig_y = (a + b eps_p^n) (1 + c ln rate*) (1 - T*^m),   rate* = rate/reference_rate, at least 1
//! T* = (T - reference_temperature)/(melting_temperature - reference_temperature)
//! rho specific_heat dT = taylor_quinney sig_y d eps_p,   T = reference_temperature at the start
//! eps_f = (D1 + D2 exp(D3 sig*)) (1 + D4 ln rate*) (1 + D5 T*)
//! failure at sum of d eps_p/eps_f = 1
//! ```
//! with sig* the mean stress over the von Mises stress, at most 1.5. The rate is that of the
//! total deviatoric strain over the step. The temperature is that before the step, so it is of
//! first order in the step. Heat is not conducted.
//!
//! `a`, `b`, `n` are required. Optional are `c` with `reference_rate` [1/time], `m` with
//! `melting_temperature` and `specific_heat` [energy/(mass temperature)], and `damage = [D1, D2,
//! D3, D4, D5]`. `b eps_p^n` is a straight line below eps_p = 1e-5, and `a + b eps_p^n` is at most
//! `largest_stress`. The return to the yield surface is in `plasticity`.

use super::parameters::Parameters;
use super::plasticity::{Coefficients, FailureCriterion, Plasticity, Rate, Thermal, YieldCurve};
use super::{DefaultValue, ELASTIC, Elastic, Form, Law, LawResult, ParameterRow, SolidLawResult};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law {
    name: "johnson_cook",
    meaning: "Johnson-Cook plasticity with strain rate, adiabatic heating and failure.",
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
        meaning: "Hardening exponent.",
    },
    ParameterRow {
        key: "largest_stress",
        form: Form::Number,
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Largest value of `a + b strain^n`, which rate and temperature then scale \
                  [force/length^2].",
    },
    ParameterRow {
        key: "c",
        form: Form::Number,
        otherwise: DefaultValue::Number(0.0),
        range: None,
        meaning: "Strain rate: factor `1 + c ln(rate/reference_rate)`.",
    },
    ParameterRow {
        key: "reference_rate",
        form: Form::Number,
        otherwise: DefaultValue::Depends("needed with `c`, and with `damage` that has a D4"),
        range: None,
        meaning: "Strain rate below which the rate has no effect [1/time].",
    },
    ParameterRow {
        key: "m",
        form: Form::Number,
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Temperature: factor `1 - T*^m` with T* from 0 at `reference_temperature` to 1 at \
                  `melting_temperature`.",
    },
    ParameterRow {
        key: "reference_temperature",
        form: Form::Number,
        otherwise: DefaultValue::Number(0.0),
        range: None,
        meaning: "Initial temperature [temperature].",
    },
    ParameterRow {
        key: "melting_temperature",
        form: Form::Number,
        otherwise: DefaultValue::Depends("needed with `m`"),
        range: None,
        meaning: "Melting temperature [temperature].",
    },
    ParameterRow {
        key: "specific_heat",
        form: Form::Number,
        otherwise: DefaultValue::Depends("needed with `m`"),
        range: None,
        meaning: "Specific heat capacity [energy/(mass temperature)].",
    },
    ParameterRow {
        key: "taylor_quinney",
        form: Form::Number,
        otherwise: DefaultValue::Number(0.9),
        range: None,
        meaning: "Fraction of plastic work that becomes heat.",
    },
    ParameterRow {
        key: "damage",
        form: Form::List("[D1, D2, D3, D4, D5]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Failure: the plastic strain at failure is \
                  `(D1 + D2 exp(D3 triaxiality)) (1 + D4 ln rate*) (1 + D5 T*)`.",
    },
];

fn build(material: &Material) -> LawResult {
    Parameters::new(material).shell_law(read)
}

fn solid(material: &Material) -> SolidLawResult {
    Parameters::new(material).solid_law(read)
}

/// Reads the remaining parameters and returns the law.
fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<Plasticity, Vec<Problem>> {
    let a = parameters.required("a", "above 0", |a| a > 0.0);
    let b = parameters.required("b", "0 or above", |b| b >= 0.0);
    let n = parameters.required("n", "above 0 and at most 1", |n| n > 0.0 && n <= 1.0);
    let largest = parameters
        .optional("largest_stress", "`a` or above", |limit| limit >= a)
        .unwrap_or(f64::INFINITY);
    let c = parameters.optional("c", "0 or above", |c| c >= 0.0).unwrap_or(0.0);
    let d = failure(&mut parameters);
    let needs_rate = c > 0.0 || d.is_some_and(|d| d[3] != 0.0);
    let reference =
        number(&mut parameters, "reference_rate", needs_rate, |rate| rate > 0.0, "above 0");
    let thermal = thermal(&mut parameters, a, elastic.density);
    parameters.finish()?;
    Ok(Plasticity {
        elastic,
        yield_stress: a,
        curve: YieldCurve::Power { b: b / a, n, largest: largest / a },
        rate: if c > 0.0 { Rate::Logarithmic { c, reference } } else { Rate::None },
        thermal,
        failure: d
            .map_or(FailureCriterion::None, |d| FailureCriterion::JohnsonCook { d, reference }),
        coefficients: Coefficients::new(&elastic, a),
    })
}

/// Returns a number, required if `needed`; one if it is not given.
fn number(
    parameters: &mut Parameters<'_>,
    key: &'static str,
    needed: bool,
    fits: impl Fn(f64) -> bool,
    wanted: &str,
) -> f64 {
    if needed {
        parameters.required(key, wanted, fits)
    } else {
        parameters.optional(key, wanted, fits).unwrap_or(1.0)
    }
}

fn thermal(parameters: &mut Parameters<'_>, a: f64, density: f64) -> Option<Thermal> {
    let exponent = parameters.optional("m", "above 0", |m| m > 0.0);
    let start =
        parameters.optional("reference_temperature", "a temperature", |_| true).unwrap_or(0.0);
    let needed = exponent.is_some();
    let melting = number(parameters, "melting_temperature", needed, |_| true, "a temperature");
    let heat = number(parameters, "specific_heat", needed, |heat| heat > 0.0, "above 0");
    let fraction = parameters
        .optional("taylor_quinney", "from 0 to 1", |f| (0.0..=1.0).contains(&f))
        .unwrap_or(0.9);
    let m = exponent?;
    if melting <= start {
        let what = format!("is {melting}, which is not above reference_temperature = {start}");
        parameters.wrong("melting_temperature", what, "give both on one scale, kelvin or Celsius");
    }
    Some(Thermal { m, to_melting: melting - start, heating: fraction * a / (density * heat) })
}

/// Returns D1 to D5.
fn failure(parameters: &mut Parameters<'_>) -> Option<[f64; 5]> {
    const KEY: &str = "damage";
    let given = parameters.get(KEY)?;
    let list: Option<[f64; 5]> = match given {
        Param::List(list) => list.as_slice().try_into().ok(),
        _ => None,
    };
    match list.filter(|d| d.iter().all(|d| d.is_finite()) && d[0] >= 0.0 && d[0] + d[1] > 0.0) {
        Some(d) => Some(d),
        None => {
            let help = "give five numbers, with D1 at least 0 and D1 + D2 above 0";
            parameters.wrong(KEY, "is not [D1, D2, D3, D4, D5]", help);
            None
        }
    }
}

#[cfg(test)]
#[path = "johnson_cook_tests.rs"]
mod tests;
