//! Results of the points of a study: values, errors, costs, the Pareto front, `results.csv`.

use super::grid::{StudyPlan, StudySetting, plain};
use super::runs::{self, PointOutcome};
use super::spec::{Reference, Study};
use crate::results::quantity::{self, RunResults};
use std::path::Path;

/// All points of the series.
pub struct PointTable {
    /// Rows in the order of the plan.
    pub rows: Vec<PointResult>,
    /// Reference value of each measure, if it has one.
    pub references: Vec<Option<f64>>,
    header: Vec<String>,
    settings: Vec<String>,
}

/// A point and its results.
pub struct PointResult {
    /// Index of the series, and its name.
    pub series: usize,
    name: String,
    /// Settings that the series varies.
    pub varied: Vec<StudySetting>,
    /// Short name of the point.
    pub label: String,
    /// End of the run.
    pub outcome: PointOutcome,
    /// Cost, NaN if the run has none.
    pub cost: f64,
    /// Value of each measure, NaN if the run has none.
    pub values: Vec<f64>,
    /// Error of each measure, NaN without a reference.
    pub errors: Vec<f64>,
    key: String,
}

impl PointResult {
    /// Returns true if the run completed.
    pub fn ended_well(&self) -> bool {
        self.outcome.code == 0
    }

    /// Returns the value of a setting that the series varies.
    pub fn setting(&self, key: &str) -> Option<&toml::Value> {
        self.varied.iter().find(|(k, _)| k == key).map(|(_, v)| v)
    }
}

impl PointTable {
    /// Reads the results of the runs.
    ///
    /// # Errors
    /// A point has not been run, or a reference run has failed.
    pub fn collect(study: &Study, plan: &StudyPlan, out: &Path) -> Result<Self, String> {
        let mut references = Vec::new();
        for (measure, at) in study.measure.iter().zip(&plan.reference) {
            references.push(match (&measure.reference, at) {
                (Some(Reference::Value(value)), _) => Some(*value),
                (_, Some(at)) => {
                    let point = &plan.points[*at];
                    let outcome =
                        runs::outcome(out, point).ok_or("the reference has not been run")?;
                    if outcome.code != 0 {
                        return Err(format!(
                            "the reference of `{}` failed: {}",
                            measure.name, outcome.reason
                        ));
                    }
                    let run = RunResults::load(&runs::folder(out, point))?;
                    Some(quantity::value(&measure.quantity, &run)?)
                }
                _ => None,
            });
        }
        let mut rows = Vec::new();
        for point in &plan.points {
            let Some(series) = point.series else { continue };
            let label = point.label(study);
            let outcome = runs::outcome(out, point).ok_or_else(|| format!("{label}: not run"))?;
            // A failed run may have written some of its results, or none.
            let run = RunResults::load(&runs::folder(out, point)).ok();
            let value = |q: &crumple_proto::job::Quantity| {
                run.as_ref().and_then(|r| quantity::value(q, r).ok()).unwrap_or(f64::NAN)
            };
            let values: Vec<f64> = study.measure.iter().map(|m| value(&m.quantity)).collect();
            let error = |m: usize| {
                let (measured, Some(reference)) = (values[m], references[m]) else {
                    return f64::NAN;
                };
                let scale = if study.measure[m].relative { reference.abs() } else { 1.0 };
                (measured - reference).abs() / scale
            };
            let errors = (0..values.len()).map(error).collect();
            let (varied, key, name) =
                (point.varied.clone(), point.key.clone(), study.series[series].name.clone());
            rows.push(PointResult {
                series,
                name,
                varied,
                label,
                outcome,
                cost: value(&study.cost.quantity),
                values,
                errors,
                key,
            });
        }
        let mut settings: Vec<String> = Vec::new();
        for (key, _) in rows.iter().flat_map(|r| &r.varied) {
            if !settings.contains(key) {
                settings.push(key.clone());
            }
        }
        let unit = |name: &str, unit: &str| {
            if unit.is_empty() { name.into() } else { format!("{name} [{unit}]") }
        };
        let mut header: Vec<String> = vec!["series".into()];
        header.extend(settings.iter().cloned());
        header.push("exit code".into());
        header.push(unit(&study.cost.name, &study.cost.unit));
        for (m, measure) in study.measure.iter().enumerate() {
            header.push(unit(&measure.name, &measure.unit));
            if references[m].is_some() {
                let of = if measure.relative { "relative error" } else { "error" };
                header.extend([
                    format!("{of} of {}", measure.name),
                    format!("on the Pareto front of {}", measure.name),
                ]);
            }
        }
        header.extend(["reason", "run"].map(String::from));
        Ok(Self { rows, references, header, settings })
    }

    /// Returns the indices of the rows on the Pareto front of a measure, by ascending cost. No
    /// other completed row of `shown` has a smaller error at the same or lower cost.
    pub fn front(&self, measure: usize, shown: impl Fn(&PointResult) -> bool) -> Vec<usize> {
        let points: Vec<(usize, [f64; 2])> = self
            .rows
            .iter()
            .enumerate()
            .filter(|(_, r)| r.ended_well() && shown(r))
            .map(|(i, r)| (i, [r.cost, r.errors[measure]]))
            .collect();
        pareto(&points)
    }

    /// Writes `results.csv` with one row per point.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> csv::Result<()> {
        let mut file = csv::Writer::from_path(path)?;
        file.write_record(&self.header)?;
        let number = |x: f64| if x.is_finite() { format!("{x:.6e}") } else { String::new() };
        let fronts: Vec<Vec<usize>> =
            (0..self.references.len()).map(|m| self.front(m, |_| true)).collect();
        for (i, row) in self.rows.iter().enumerate() {
            let mut record = vec![row.name.clone()];
            record.extend(
                self.settings.iter().map(|key| row.setting(key).map_or(String::new(), plain)),
            );
            record.extend([row.outcome.code.to_string(), number(row.cost)]);
            for (m, front) in fronts.iter().enumerate() {
                record.push(number(row.values[m]));
                if self.references[m].is_some() {
                    let on = if front.contains(&i) { "yes" } else { "no" };
                    record.extend([number(row.errors[m]), on.to_string()]);
                }
            }
            record.extend([row.outcome.reason.clone(), row.key.clone()]);
            file.write_record(&record)?;
        }
        Ok(file.flush()?)
    }
}

/// Returns the Pareto front of `points` (index, `[cost, error]`) by ascending cost. Of equal
/// points the first is taken.
fn pareto(points: &[(usize, [f64; 2])]) -> Vec<usize> {
    let mut sorted: Vec<_> =
        points.iter().filter(|(_, p)| p.iter().all(|c| c.is_finite())).collect();
    sorted.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]).then(a.1[1].total_cmp(&b.1[1])));
    let mut best = f64::INFINITY;
    let better = |(name, [_, error]): &&(usize, [f64; 2])| {
        let better = *error < best;
        best = best.min(*error);
        better.then_some(*name)
    };
    sorted.iter().filter_map(better).collect()
}

#[cfg(test)]
mod tests {
    use super::pareto;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = [
            [1.0, 9.0],
            [2.0, 4.0],
            [2.0, 3.0],
            [3.0, 3.0],
            [4.0, 1.0],
            [5.0, 2.0],
            [0.5, f64::NAN],
        ];
        let named: Vec<_> = points.into_iter().enumerate().collect();
        assert_eq!(pareto(&named), [0, 2, 4]);
        assert_eq!(pareto(&named[6..]), [0usize; 0]);
    }
}
