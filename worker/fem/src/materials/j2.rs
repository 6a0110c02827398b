//! J2 (von Mises) plasticity with isotropic hardening. The return to the yield surface is in
//! `plasticity`.
//!
//! Yield stress `sig_y(eps_p)` [force/length^2], one of
//! - `yield_stress` and optionally the plastic modulus `hardening_modulus`: `yield_stress +
//!   hardening_modulus eps_p`;
//! - `hardening = [[eps_p, sigma], ...]`: straight lines between points, constant beyond the
//!   last.
//!
//! `cowper_symonds = [C, p]` (Cowper & Symonds 1957) multiplies it by `1 + (rate/C)^(1/p)`. The
//! rate is that of the total effective strain over the step, `sqrt(2/3 e:e)/dt` with the deviator
//! e of the increment (in plane stress taken as isochoric, so `e:e = 2 (e_x^2 + e_y^2 + e_x e_y +
//! e_xy^2)`). It is not filtered. It has no effect while the trial is below the static yield
//! stress.
//!
//! `failure_strain`: effective plastic strain at which a point fails; its stress is zero from
//! then on.
//!
//! Not included: kinematic hardening, transverse shear in the yield condition of shells (as in
//! most shell codes).

use super::parameters::Parameters;
use super::plasticity::{Coefficients, FailureCriterion, Plasticity, Rate, YieldCurve};
use super::{DefaultValue, Elastic, Form, Law, LawResult, ParameterRow, SolidLawResult};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law {
    name: "j2",
    meaning: "Von Mises plasticity with isotropic hardening.",
    parameters: PARAMETERS,
    build,
    solid,
};

const PARAMETERS: &[ParameterRow] = &[
    ParameterRow {
        key: "yield_stress",
        form: Form::Number,
        otherwise: DefaultValue::Depends("needed without `hardening`"),
        range: None,
        meaning: "Yield stress at zero plastic strain [force/length^2].",
    },
    ParameterRow {
        key: "hardening_modulus",
        form: Form::Number,
        otherwise: DefaultValue::Number(0.0),
        range: None,
        meaning: "Slope of the yield stress over plastic strain; only with `yield_stress` \
                  [force/length^2].",
    },
    ParameterRow {
        key: "hardening",
        form: Form::List("[[strain, stress], ...]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Table that replaces both: effective plastic strain, from 0, and yield stress; \
                  linear between rows, constant beyond the last [force/length^2].",
    },
    ParameterRow {
        key: "cowper_symonds",
        form: Form::List("[C, p]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Strain rate: factor `1 + (rate/C)^(1/p)` on the yield stress; C is a rate \
                  [1/time].",
    },
    ParameterRow {
        key: "failure_strain",
        form: Form::Number,
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Effective plastic strain at which a point fails; then its stress is zero.",
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
    let (yield_stress, slope, ramps) = hardening(&mut parameters);
    let rate = match parameters.get("cowper_symonds") {
        None => Rate::None,
        Some(Param::List(list))
            if list.len() == 2 && list.iter().all(|v| v.is_finite() && *v > 0.0) =>
        {
            Rate::CowperSymonds { c: list[0], inv_p: 1.0 / list[1] }
        }
        Some(_) => {
            parameters.wrong(
                "cowper_symonds",
                "is not [C, p]",
                "give two numbers above 0: C in 1/time, and p",
            );
            Rate::None
        }
    };
    let failure = match parameters.optional("failure_strain", "above 0", |f| f > 0.0) {
        Some(strain) => FailureCriterion::Strain(strain),
        None => FailureCriterion::None,
    };
    parameters.finish()?;
    let curve = YieldCurve::lines(yield_stress, slope, &ramps);
    let coefficients = Coefficients::new(&elastic, yield_stress);
    Ok(Plasticity { elastic, yield_stress, curve, rate, thermal: None, failure, coefficients })
}

/// Returns the yield stress, the first slope, and the changes of slope.
fn hardening(parameters: &mut Parameters<'_>) -> (f64, f64, Vec<(f64, f64)>) {
    const TABLE: &str = "hardening";
    let yield_stress = parameters.optional("yield_stress", "above 0", |y| y > 0.0);
    let modulus = parameters.optional("hardening_modulus", "0 or above", |h| h >= 0.0);
    let single = parameters.given("yield_stress") || parameters.given("hardening_modulus");
    let Some(table) = parameters.get(TABLE) else {
        if !parameters.given("yield_stress") {
            let help =
                "give it, with hardening_modulus if it hardens, or give the table `hardening`";
            parameters.wrong("yield_stress", "is missing", help);
        }
        return (yield_stress.unwrap_or(1.0), modulus.unwrap_or(0.0), Vec::new());
    };
    if single {
        parameters.wrong(
            TABLE,
            "is given together with yield_stress or hardening_modulus",
            "give only one of them",
        );
    }
    let rows: Vec<[f64; 2]> = match table {
        Param::Table(rows) => {
            rows.iter().filter_map(|row| row.as_slice().try_into().ok()).collect()
        }
        _ => Vec::new(),
    };
    let complete = matches!(table, Param::Table(all) if !all.is_empty() && all.len() == rows.len());
    let fault = if !complete || rows.iter().flatten().any(|value| !value.is_finite()) {
        Some("is not a table of pairs")
    } else if rows[0][0] != 0.0 {
        Some("does not start at plastic strain 0")
    } else if rows.windows(2).any(|pair| pair[1][0] <= pair[0][0]) {
        Some("has plastic strains that do not increase from row to row")
    } else if rows[0][1] <= 0.0 || rows.windows(2).any(|pair| pair[1][1] < pair[0][1]) {
        Some("has a stress that is not above 0 or decreases from one row to the next")
    } else {
        None
    };
    if let Some(fault) = fault {
        parameters.wrong(
            TABLE,
            fault,
            "give [[0, sigma], [eps_p, sigma], ...] with increasing plastic strain",
        );
        return (1.0, 0.0, Vec::new());
    }
    let mut slopes: Vec<f64> =
        rows.windows(2).map(|p| (p[1][1] - p[0][1]) / (p[1][0] - p[0][0])).collect();
    slopes.push(0.0);
    let ramps =
        rows[1..].iter().zip(slopes.windows(2)).map(|(row, s)| (row[0], s[1] - s[0])).collect();
    (rows[0][1], slopes[0], ramps)
}
