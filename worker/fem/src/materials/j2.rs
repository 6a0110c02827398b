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
//! `hardening_by_rate = [[rate, eps_p, sigma], ...]` gives a curve for each strain rate instead,
//! linear between rates and constant beyond them. `rate_factors = [[rate, factor], ...]` is a curve
//! of factors on the yield stress. With `viscoplastic` the rate of all of these is that of the
//! plastic strain.
//!
//! `kinematic_modulus` adds kinematic hardening by Prager's rule, also together with isotropic
//! hardening: the back stress grows by this modulus times the plastic strain, in uniaxial stress.
//!
//! `failure_strain`: effective plastic strain at which a point fails; its stress is zero from
//! then on. `softening = [start, rupture]` lets the stress fall to zero between two plastic strains
//! (`plasticity/softening.rs`).
//!
//! `lankford` makes sheets anisotropic through the thickness (`plasticity/plane_stress.rs`).
//!
//! Not included: transverse shear in the yield condition of shells (as in most shell codes).

use super::parameters::Parameters;
use super::plasticity::combined::{CombinedPlasticity, RateFactor};
use super::plasticity::softening;
use super::plasticity::{Anisotropy, Coefficients, FailureCriterion, Plasticity, Rate, YieldCurve};
use super::polyline::{Beyond, CurveFamily, RampCurve};
use super::{
    DefaultValue, ELASTIC, Elastic, Form, Law, LawResult, ParameterRow, PlaneStress, Solid,
    SolidLawResult,
};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law {
    name: "j2",
    meaning: "Von Mises plasticity with isotropic and kinematic hardening.",
    constants: ELASTIC,
    parameters: PARAMETERS,
    build: Some(build),
    solid: Some(solid),
    cohesive: None,
};

/// Hardening over the plastic strain.
pub const HARDENING: [ParameterRow; 3] = [
    ParameterRow {
        key: "yield_stress",
        form: Form::Number,
        otherwise: DefaultValue::Depends("needed without `hardening` and `hardening_by_rate`"),
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
];

const PARAMETERS: &[ParameterRow] = &[
    HARDENING[0],
    HARDENING[1],
    HARDENING[2],
    ParameterRow {
        key: "cowper_symonds",
        form: Form::List("[C, p]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Strain rate: factor `1 + (rate/C)^(1/p)` on the yield stress; C is a rate \
                  [1/time].",
    },
    ParameterRow {
        key: "hardening_by_rate",
        form: Form::List("[[rate, strain, stress], ...]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Tables as in `hardening`, one for each strain rate [1/time], in ascending order, \
                  none below that of a smaller rate; linear between rates, constant beyond them \
                  [force/length^2].",
    },
    ParameterRow {
        key: "rate_factors",
        form: Form::List("[[rate, factor], ...]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Strain rate: curve of the factor on the yield stress over the rate [1/time]; \
                  constant beyond its points.",
    },
    ParameterRow {
        key: "viscoplastic",
        form: Form::Flag,
        otherwise: DefaultValue::Flag(false),
        range: None,
        meaning: "True if the rate is that of the plastic strain, in equilibrium with the stress; \
                  otherwise that of the total strain.",
    },
    ParameterRow {
        key: "kinematic_modulus",
        form: Form::Number,
        otherwise: DefaultValue::Number(0.0),
        range: None,
        meaning: "Slope of the back stress over plastic strain in uniaxial stress: kinematic \
                  hardening [force/length^2].",
    },
    ParameterRow {
        key: "failure_strain",
        form: Form::Number,
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Effective plastic strain at which a point fails; then its stress is zero.",
    },
    softening::ROW,
    ParameterRow {
        key: LANKFORD,
        form: Form::Number,
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Anisotropy of sheets: ratio R of the plastic strains across and through the \
                  sheet in uniaxial tension, the same in all its directions. For shells, without \
                  `kinematic_modulus`.",
    },
];

/// The key of Lankford's coefficient.
pub const LANKFORD: &str = "lankford";

fn build(material: &Material) -> LawResult {
    let mut parameters = Parameters::new(material);
    let elastic = parameters.elastic();
    let strains = softening::read(&mut parameters);
    let law: Box<dyn PlaneStress> = match read(parameters, elastic, true)? {
        J2Form::Isotropic(law) => Box::new(law),
        J2Form::Combined(law) => Box::new(law),
    };
    softening::shell(law, strains)
}

fn solid(material: &Material) -> SolidLawResult {
    let mut parameters = Parameters::new(material);
    let elastic = parameters.solid_elastic();
    let strains = softening::read(&mut parameters);
    let law: Box<dyn Solid> = match read(parameters, elastic, false)? {
        J2Form::Isotropic(law) => Box::new(law),
        J2Form::Combined(law) => Box::new(law),
    };
    softening::solid(law, strains)
}

/// The two forms of this law.
enum J2Form {
    /// Isotropic hardening, with the rate of Cowper and Symonds.
    Isotropic(Plasticity),
    /// All options.
    Combined(CombinedPlasticity),
}

/// Reads the remaining parameters and returns the law, of shells or of solids.
fn read(
    mut parameters: Parameters<'_>,
    elastic: Elastic,
    for_shells: bool,
) -> Result<J2Form, Vec<Problem>> {
    let by_rate = hardening_by_rate(&mut parameters);
    let (yield_stress, slope, ramps) = match &by_rate {
        Some(rows) => (rows.first().map_or(1.0, |row| row[2]), 0.0, Vec::new()),
        None => hardening(&mut parameters),
    };
    let cowper_symonds = cowper_symonds(&mut parameters);
    let factors = rate_factors(&mut parameters);
    if cowper_symonds.is_some() && factors.is_some() {
        let what = "is given together with cowper_symonds";
        parameters.wrong("rate_factors", what, "give only one of them");
    }
    let viscoplastic = parameters.flag("viscoplastic");
    if viscoplastic && by_rate.is_none() && factors.is_none() && cowper_symonds.is_none() {
        let help = "give cowper_symonds, rate_factors or hardening_by_rate, or leave it out";
        parameters.wrong("viscoplastic", "is true without a dependence on the rate", help);
    }
    let kinematic = parameters.optional("kinematic_modulus", "0 or above", |h| h >= 0.0);
    let kinematic = kinematic.unwrap_or(0.0);
    let failure_strain = parameters.optional("failure_strain", "above 0", |f| f > 0.0);
    let lankford = parameters.optional(LANKFORD, "above 0", |r| r > 0.0).unwrap_or(1.0);
    if lankford != 1.0 && !for_shells {
        let help = "remove it, or use the material in parts of shells only";
        parameters.wrong(LANKFORD, "is for shells only, and a part of solids has it", help);
    } else if lankford != 1.0 && kinematic > 0.0 {
        let what = "is given together with kinematic_modulus";
        parameters.wrong(LANKFORD, what, "give only one of them");
    }
    parameters.finish()?;
    let is_combined = by_rate.is_some() || factors.is_some() || viscoplastic || kinematic > 0.0;
    let rate = match cowper_symonds {
        Some([c, p]) if !is_combined => Rate::CowperSymonds { c, inv_p: 1.0 / p },
        _ => Rate::None,
    };
    let failure = match failure_strain {
        Some(strain) if !is_combined => FailureCriterion::Strain(strain),
        _ => FailureCriterion::None,
    };
    let points = match &by_rate {
        Some(rows) => {
            let lowest = rows.iter().take_while(|row| row[0] == rows[0][0]);
            lowest.map(|row| [row[1], row[2]]).collect()
        }
        None => Vec::new(),
    };
    let (slope, ramps) = if by_rate.is_some() { bends(&points) } else { (slope, ramps) };
    let base = Plasticity {
        elastic,
        yield_stress,
        curve: YieldCurve::lines(yield_stress, slope, &ramps),
        rate,
        thermal: None,
        failure,
        coefficients: Coefficients::anisotropic(&elastic, yield_stress, Anisotropy::new(lankford)),
    };
    if !is_combined {
        return Ok(J2Form::Isotropic(base));
    }
    // Only a hardening modulus has no last point.
    let endless = by_rate.is_none() && ramps.is_empty();
    let beyond = if endless { Beyond::Straight } else { Beyond::Constant };
    let rows = by_rate.unwrap_or_else(|| rows_of(yield_stress, slope, &ramps));
    Ok(J2Form::Combined(CombinedPlasticity {
        base,
        hardening: CurveFamily::new(&rows, 1.0 / yield_stress, beyond),
        kinematic: kinematic / yield_stress,
        rate: match (cowper_symonds, factors) {
            (Some([c, p]), _) => RateFactor::CowperSymonds { c, inv_p: 1.0 / p },
            (_, Some(points)) => RateFactor::Curve(RampCurve::new(&points, 1.0, Beyond::Constant)),
            _ => RateFactor::None,
        },
        viscoplastic,
        failure_strain: failure_strain.unwrap_or(f64::INFINITY),
    }))
}

/// Returns the rows [0, eps_p, sigma] of a curve that begins with this stress and slope and has
/// these changes of slope.
pub fn rows_of(yield_stress: f64, slope: f64, ramps: &[(f64, f64)]) -> Vec<[f64; 3]> {
    let mut rows = vec![[0.0, 0.0, yield_stress]];
    let (mut slope, mut last) = (slope, [0.0, yield_stress]);
    for &(start, change) in ramps {
        last = [start, last[1] + slope * (start - last[0])];
        rows.push([0.0, last[0], last[1]]);
        slope += change;
    }
    if ramps.is_empty() {
        rows.push([0.0, 1.0, yield_stress + slope]);
    }
    rows
}

/// Returns C [1/time] and p.
fn cowper_symonds(parameters: &mut Parameters<'_>) -> Option<[f64; 2]> {
    const KEY: &str = "cowper_symonds";
    match parameters.get(KEY)? {
        Param::List(list) if list.len() == 2 && list.iter().all(|v| v.is_finite() && *v > 0.0) => {
            Some([list[0], list[1]])
        }
        _ => {
            let help = "give two numbers above 0: C in 1/time, and p";
            parameters.wrong(KEY, "is not [C, p]", help);
            None
        }
    }
}

/// Returns the points of the factor over the rate.
fn rate_factors(parameters: &mut Parameters<'_>) -> Option<Vec<[f64; 2]>> {
    const KEY: &str = "rate_factors";
    let rows = parameters.rows::<2>(KEY, "[[rate, factor], ...]")?;
    let ascends = rows.windows(2).all(|two| two[0][0] < two[1][0] && two[0][1] <= two[1][1]);
    if !(rows.is_empty() || ascends && rows[0][0] >= 0.0 && rows[0][1] > 0.0) {
        let help = "give increasing rates from 0 on, and factors above 0 that do not decrease";
        parameters.wrong(KEY, "has rates or factors in the wrong order", help);
    }
    Some(rows)
}

/// Returns the rows [rate, plastic strain, stress].
fn hardening_by_rate(parameters: &mut Parameters<'_>) -> Option<Vec<[f64; 3]>> {
    const KEY: &str = "hardening_by_rate";
    let rows = parameters.rows::<3>(KEY, "[[rate, eps_p, sigma], ...]")?;
    for key in ["yield_stress", "hardening_modulus", "hardening"] {
        if parameters.get(key).is_some() {
            let what = format!("is given together with {key}");
            parameters.wrong(KEY, what, "give only one of them");
        }
    }
    if rows.is_empty() {
        return Some(rows);
    }
    let curves: Vec<&[[f64; 3]]> = rows.chunk_by(|a, b| a[0] == b[0]).collect();
    let fault = if rows[0][0] < 0.0 || curves.windows(2).any(|two| two[0][0][0] >= two[1][0][0]) {
        Some("has rates that are below 0 or do not increase")
    } else if curves
        .iter()
        .any(|curve| curve[0][1] != 0.0 || curve.windows(2).any(|two| two[0][1] >= two[1][1]))
    {
        Some("has plastic strains of a rate that do not increase from 0 on")
    } else if curves
        .iter()
        .any(|curve| curve[0][2] <= 0.0 || curve.windows(2).any(|two| two[0][2] > two[1][2]))
    {
        Some("has a stress that is not above 0 or decreases from one row of a rate to the next")
    } else {
        None
    };
    if let Some(fault) = fault {
        let help = "give [[rate, 0, sigma], [rate, eps_p, sigma], ...], rate by rate";
        parameters.wrong(KEY, fault, help);
        return Some(vec![[0.0, 0.0, 1.0]]);
    }
    let last = rows.iter().fold(0.0, |last: f64, row| last.max(row[1]));
    let family = CurveFamily::new(&rows, 1.0, Beyond::Constant);
    if let Some([rate, strain]) = family.crossing(last) {
        let what = format!(
            "has a stress at the rate {rate} and the plastic strain {strain} below that of the \
             rate before it"
        );
        parameters.wrong(KEY, what, "the yield stress must not fall as the rate grows");
    }
    Some(rows)
}

/// Returns the yield stress, the first slope, and the changes of slope.
pub fn hardening(parameters: &mut Parameters<'_>) -> (f64, f64, Vec<(f64, f64)>) {
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
    let (slope, ramps) = bends(&rows);
    (rows[0][1], slope, ramps)
}

/// Returns the first slope of a curve that is constant beyond its last point, and the changes of
/// slope.
fn bends(rows: &[[f64; 2]]) -> (f64, Vec<(f64, f64)>) {
    let mut slopes: Vec<f64> =
        rows.windows(2).map(|p| (p[1][1] - p[0][1]) / (p[1][0] - p[0][0])).collect();
    slopes.push(0.0);
    let bends =
        rows.iter().skip(1).zip(slopes.windows(2)).map(|(row, s)| (row[0], s[1] - s[0])).collect();
    (slopes[0], bends)
}
