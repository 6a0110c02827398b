//! Requirements of a job: their names are checked before the run, their values after it.

use super::quantity::{self, QuantityValue, RunResults, UnknownName};
use crate::input::job::{Model, Report};
use crate::results::summary::RequirementResult;
use crumple_proto::job::Requirement;
use crumple_proto::problem::Problem;
use std::path::Path;

/// Checks the names of quantities; [`crate::input::job`] checks the rest.
///
/// # Errors
/// No run of the job has them.
pub fn check_names(model: &Model) -> Result<(), Report> {
    if model.job.require.is_empty() {
        return Ok(());
    }
    let blank = RunResults::blank(model);
    let problem = |(index, one): (usize, &Requirement)| {
        let UnknownName { key, why } = quantity::unknown_name(&one.quantity, &blank)?;
        let path = format!("require.{index}.quantity.{key}");
        let cause = match key.ends_with("filter") {
            true => "its filter cannot be used",
            false => "no run has this quantity",
        };
        let message = format!("requirement `{}`: {cause}", one.name);
        Some(Problem::error(path, message, why))
    };
    let problems: Vec<Problem> = model.job.require.iter().enumerate().filter_map(problem).collect();
    if problems.is_empty() { Ok(()) } else { Err(model.report(&problems)) }
}

/// Returns the requirements of a job with the values of a completed run, whose files are in `out`.
pub fn judge(requirements: &[Requirement], out: &Path) -> Vec<RequirementResult> {
    if requirements.is_empty() {
        return Vec::new();
    }
    let results = RunResults::load(out);
    let judge_one = |one: &Requirement| {
        let measured = match &results {
            Ok(results) => quantity::measure(&one.quantity, results),
            Err(why) => Err(why.clone()),
        };
        let is_met = measured.as_ref().is_ok_and(|found| one.is_met_by(found.value));
        let why = match &measured {
            Ok(found) if !found.value.is_finite() => "the results do not have the value".into(),
            Ok(_) => String::new(),
            Err(why) => why.clone(),
        };
        let found = measured.ok().filter(|found| found.value.is_finite());
        let value = found.as_ref().map(|found| found.value);
        let QuantityValue { unit, time, unit_of_time, .. } = found.unwrap_or_default();
        RequirementResult {
            name: one.name.clone(),
            value,
            unit,
            time,
            unit_of_time,
            below: one.below,
            above: one.above,
            is_met,
            why,
        }
    };
    requirements.iter().map(judge_one).collect()
}
