//! Numbers from the results of a run: an entry of `summary.json`, a column of `history.csv`, a
//! field of a part.

use super::probe;
use crate::input::job::Model;
use crate::results::history;
use crate::results::summary::{Summary, phases};
use serde::Deserialize;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A number of a run. The source is one of `summary`, `history` and `field`; the value is
/// `(source - minus) / over * scale`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// Dotted path in `summary.json`, such as `energy.error_max` or `momentum.end.0`.
    pub summary: Option<String>,
    /// Column of `history.csv`, with or without its unit.
    pub history: Option<String>,
    /// Array of the field files, such as `velocity`: the mean over the elements of `part`.
    pub field: Option<String>,
    /// Component of the field: x, y, z, or xx, yy, zz, xy, yz, zx of a tensor. By default the
    /// length of a vector.
    pub component: Option<String>,
    /// Id of the part whose elements are used; all parts by default.
    pub part: Option<u32>,
    /// Reduction of the elements to one number; the mean by default.
    pub elements: Option<Over>,
    /// Simulated time of the value [time]. History rows are interpolated; of fields the nearest
    /// output step is used.
    pub at: Option<f64>,
    /// Reduction of the rows to one number; the last row by default.
    pub stat: Option<Stat>,
    /// Value of the column. The result is the time at which the column first crosses it,
    /// interpolated between rows; NaN if it never does.
    pub crossing: Option<f64>,
    /// Time of the first row used [time].
    pub from: Option<f64>,
    /// Time of the last row used [time].
    pub to: Option<f64>,
    /// Quantity that is subtracted.
    pub minus: Option<Box<Quantity>>,
    /// Quantity by which the result is divided.
    pub over: Option<Box<Quantity>>,
    /// Factor of the result.
    pub scale: Option<f64>,
}

/// Reduction of the elements of a part to one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// Mean.
    Mean,
    /// Minimum.
    Min,
    /// Maximum.
    Max,
}

/// Reduction of a column to one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stat {
    /// First row.
    First,
    /// Last row.
    Last,
    /// Minimum.
    Min,
    /// Maximum.
    Max,
    /// Mean over time by the trapezoidal rule.
    Mean,
    /// Slope of the least squares line [1/time].
    Slope,
    /// Largest magnitude over that of the first row.
    Growth,
}

/// Results of a run.
pub struct RunResults {
    /// Content of `summary.json`.
    pub summary: Value,
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
    folder: PathBuf,
}

impl RunResults {
    /// Reads the folder of a run.
    ///
    /// # Errors
    /// A file is missing or damaged.
    pub fn load(folder: &Path) -> Result<Self, String> {
        let path = folder.join("summary.json");
        let text = std::fs::read_to_string(&path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let summary =
            serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        let path = folder.join("history.csv");
        let cannot = |error: csv::Error| format!("{}: {error}", path.display());
        let mut reader = csv::Reader::from_path(&path).map_err(cannot)?;
        let header = reader.headers().map_err(cannot)?.iter().map(String::from).collect();
        let row = |record: csv::StringRecord| {
            record.iter().map(|f| f.parse().unwrap_or(f64::NAN)).collect()
        };
        let rows =
            reader.records().map(|r| r.map(row)).collect::<Result<_, _>>().map_err(cannot)?;
        Ok(Self { summary, header, rows, folder: folder.to_owned() })
    }

    /// Returns the results of a run of this job without its numbers, so that names can be checked
    /// before any run.
    pub fn blank(model: &Model) -> Self {
        let summary = Summary { phase_s: phases(&[]), ..Summary::default() };
        let summary = serde_json::to_value(summary).unwrap_or_default();
        Self { summary, header: history::columns(model), rows: Vec::new(), folder: PathBuf::new() }
    }

    fn in_summary(&self, path: &str) -> Result<f64, String> {
        let mut value = &self.summary;
        for key in path.split('.') {
            let (next, there): (_, Vec<String>) = match value {
                Value::Object(map) => (map.get(key), map.keys().cloned().collect()),
                Value::Array(list) => (
                    key.parse().ok().and_then(|i: usize| list.get(i)),
                    (0..list.len()).map(|i| i.to_string()).collect(),
                ),
                _ => (None, Vec::new()),
            };
            value = next.ok_or_else(|| unknown("summary.json", path, key, &there))?;
        }
        let inside = || value.as_object().map(|m| m.keys().cloned().collect::<Vec<_>>().join(", "));
        value.as_f64().ok_or_else(|| match inside() {
            Some(keys) => format!("`{path}` in summary.json is not a number; it contains: {keys}"),
            None => format!("`{path}` in summary.json is not a number: {value}"),
        })
    }

    /// Returns the index of a column.
    fn place(&self, name: &str) -> Result<usize, String> {
        let bare = |h: &str| h.split(" [").next().unwrap_or(h).to_string();
        self.header.iter().position(|h| h == name || bare(h) == name).ok_or_else(|| {
            let names: Vec<String> = self.header.iter().map(|h| bare(h)).collect();
            unknown("history.csv", name, name, &names)
        })
    }

    /// Returns times and values of a column within a time window.
    fn column(&self, name: &str, window: [f64; 2]) -> Result<Vec<[f64; 2]>, String> {
        let at = self.place(name)?;
        let inside = |r: &&Vec<f64>| r[0] >= window[0] && r[0] <= window[1];
        let rows: Vec<[f64; 2]> = self.rows.iter().filter(inside).map(|r| [r[0], r[at]]).collect();
        if rows.is_empty() {
            Err(format!("history.csv has no rows from {} to {}", window[0], window[1]))
        } else {
            Ok(rows)
        }
    }
}

fn unknown(file: &str, path: &str, key: &str, there: &[String]) -> String {
    let within = if path == key { String::new() } else { format!(" (in `{path}`)") };
    let near = there.iter().max_by(|a, b| strsim::jaro(key, a).total_cmp(&strsim::jaro(key, b)));
    let near = near
        .filter(|n| strsim::jaro(key, n) > 0.7)
        .map_or(String::new(), |n| format!("did you mean `{n}`? "));
    format!("{file} has no `{key}`{within}; {near}there are: {}", there.join(", "))
}

impl Quantity {
    /// Creates a quantity from a path in the summary.
    pub fn summary(path: &str) -> Self {
        Self {
            summary: Some(path.into()),
            history: None,
            field: None,
            component: None,
            part: None,
            elements: None,
            at: None,
            stat: None,
            crossing: None,
            from: None,
            to: None,
            minus: None,
            over: None,
            scale: None,
        }
    }

    /// Returns the error of the quantity as it is written, if any.
    pub fn wrong(&self) -> Option<String> {
        let sources = [self.summary.is_some(), self.history.is_some(), self.field.is_some()];
        if sources.iter().filter(|s| **s).count() != 1 {
            return Some(
                "a quantity needs one of summary = \"...\", history = \"...\" and field = \"...\""
                    .into(),
            );
        }
        let ways = [self.at.is_some(), self.stat.is_some(), self.crossing.is_some()];
        if ways.iter().filter(|w| **w).count() > 1 {
            return Some("give one of `at`, `stat` and `crossing`".into());
        }
        let window = self.from.is_some() || self.to.is_some();
        if self.history.is_none() && (self.stat.is_some() || self.crossing.is_some() || window) {
            return Some("`stat`, `crossing`, `from` and `to` belong to history = \"...\"".into());
        }
        if self.summary.is_some() && self.at.is_some() {
            return Some("summary.json has no times; `at` belongs to history and field".into());
        }
        if self.field.is_none()
            && (self.component.is_some() || self.part.is_some() || self.elements.is_some())
        {
            return Some("`component`, `part` and `elements` belong to field = \"...\"".into());
        }
        [&self.minus, &self.over].into_iter().flatten().find_map(|q| q.wrong())
    }

    /// Returns the error in a name that no run of the job has, if any. `blank` is
    /// [`RunResults::blank`].
    /// Lists that are empty there, such as that of parts, may have any entry.
    pub fn unknown(&self, blank: &RunResults) -> Option<String> {
        let open = |path: &str| {
            let mut value = &blank.summary;
            path.split('.').any(|key| {
                let empty = value.as_object().is_some_and(|m| m.is_empty())
                    || value.as_array().is_some_and(|l| l.is_empty());
                value = value
                    .get(key)
                    .or(key.parse().ok().and_then(|i: usize| value.get(i)))
                    .unwrap_or(&Value::Null);
                empty
            })
        };
        let own = match (&self.summary, &self.history, &self.field) {
            (Some(path), _, _) if !open(path) => blank.in_summary(path).err(),
            (_, Some(column), _) => blank.place(column).err(),
            (_, _, Some(field)) => probe::unknown(field, self.component.as_deref()),
            _ => None,
        };
        own.or_else(|| {
            [&self.minus, &self.over].into_iter().flatten().find_map(|q| q.unknown(blank))
        })
    }

    /// Returns its value in a run.
    ///
    /// # Errors
    /// The run does not have it. The message lists the names that exist.
    pub fn value(&self, run: &RunResults) -> Result<f64, String> {
        let mut value = match (&self.summary, &self.history, &self.field) {
            (Some(path), _, _) => run.in_summary(path)?,
            (_, Some(column), _) => self.in_history(&run.column(column, self.window())?)?,
            (_, _, Some(field)) => {
                let values = probe::values(
                    &run.folder,
                    field,
                    self.component.as_deref(),
                    self.part,
                    self.at,
                )?;
                match self.elements.unwrap_or(Over::Mean) {
                    Over::Mean => values.iter().sum::<f64>() / values.len() as f64,
                    Over::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
                    Over::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                }
            }
            _ => return Err("a quantity needs a source".into()),
        };
        if let Some(minus) = &self.minus {
            value -= minus.value(run)?;
        }
        if let Some(over) = &self.over {
            value /= over.value(run)?;
        }
        Ok(value * self.scale.unwrap_or(1.0))
    }

    /// Returns the time window of the rows, slightly widened because times in the file are
    /// rounded.
    fn window(&self) -> [f64; 2] {
        let hair = |t: f64| 1e-8 * t.abs();
        let from = self.from.map_or(f64::NEG_INFINITY, |t| t - hair(t));
        [from, self.to.map_or(f64::INFINITY, |t| t + hair(t))]
    }

    fn in_history(&self, rows: &[[f64; 2]]) -> Result<f64, String> {
        let between = |a: [f64; 2], b: [f64; 2], s: f64| [0, 1].map(|c| a[c] + s * (b[c] - a[c]));
        if let Some(at) = self.at {
            let last = rows[rows.len() - 1];
            if at < rows[0][0] || at > last[0] * (1.0 + 1e-8) {
                return Err(format!(
                    "history.csv goes from {} to {}, not to {at}",
                    rows[0][0], last[0]
                ));
            }
            let pair = rows.windows(2).find(|w| w[1][0] >= at);
            return Ok(
                pair.map_or(last, |w| between(w[0], w[1], (at - w[0][0]) / (w[1][0] - w[0][0])))[1]
            );
        }
        if let Some(level) = self.crossing {
            let pair = rows
                .windows(2)
                .find(|w| (w[0][1] - level) * (w[1][1] - level) <= 0.0 && w[0][1] != w[1][1]);
            let time =
                |w: &[[f64; 2]]| between(w[0], w[1], (level - w[0][1]) / (w[1][1] - w[0][1]))[0];
            return Ok(pair.map_or(f64::NAN, time));
        }
        let values = rows.iter().map(|r| r[1]);
        Ok(match self.stat.unwrap_or(Stat::Last) {
            Stat::First => rows[0][1],
            Stat::Last => rows[rows.len() - 1][1],
            Stat::Min => values.fold(f64::INFINITY, f64::min),
            Stat::Max => values.fold(f64::NEG_INFINITY, f64::max),
            Stat::Mean if rows.len() == 1 => rows[0][1],
            Stat::Mean => {
                let area: f64 =
                    rows.windows(2).map(|w| 0.5 * (w[0][1] + w[1][1]) * (w[1][0] - w[0][0])).sum();
                area / (rows[rows.len() - 1][0] - rows[0][0])
            }
            Stat::Slope => {
                let n = rows.len() as f64;
                let mean = [0, 1].map(|c| rows.iter().map(|r| r[c]).sum::<f64>() / n);
                let sum = |f: fn(f64, f64) -> f64| {
                    rows.iter().map(|r| f(r[0] - mean[0], r[1] - mean[1])).sum::<f64>()
                };
                sum(|t, v| t * v) / sum(|t, _| t * t)
            }
            Stat::Growth => values.map(f64::abs).fold(0.0, f64::max) / rows[0][1].abs(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity(text: &str) -> Quantity {
        toml::from_str(text).unwrap()
    }

    fn run() -> RunResults {
        let header = ["time [ms]", "kinetic [J]"].map(String::from).to_vec();
        let rows = [[0.0, 4.0], [1.0, 2.0], [2.0, -2.0], [4.0, 10.0]].map(Vec::from).to_vec();
        let summary = serde_json::json!({
            "energy": { "error": 0.25, "list": [1.0, 7.0] },
            "reason": "end_time"
        });
        RunResults { summary, header, rows, folder: PathBuf::new() }
    }

    #[test]
    fn numbers_come_from_the_summary_and_from_columns() {
        let cases = [
            ("summary = \"energy.list.1\"", 7.0),
            ("history = \"kinetic\"", 10.0),
            ("history = \"kinetic [J]\"\nat = 1.5", 0.0),
            ("history = \"kinetic\"\nstat = \"min\"", -2.0),
            ("history = \"kinetic\"\nstat = \"max\"\nto = 1.0", 4.0),
            ("history = \"kinetic\"\nstat = \"mean\"", (3.0 + 0.0 + 8.0) / 4.0),
            ("history = \"kinetic\"\nstat = \"slope\"\nto = 1.0", -2.0),
            ("history = \"kinetic\"\nstat = \"growth\"", 2.5),
            ("history = \"kinetic\"\ncrossing = 1.0", 1.25),
            (
                "history = \"kinetic\"\nstat = \"first\"\nminus = { summary = \"energy.error\" }\n\
                 scale = 2.0",
                7.5,
            ),
            ("summary = \"energy.error\"\nover = { history = \"kinetic\" }", 0.025),
        ];
        for (text, value) in cases {
            assert_eq!(quantity(text).wrong(), None, "{text}");
            // Exact except for the rounding of a few operations on numbers of order one.
            assert!((quantity(text).value(&run()).unwrap() - value).abs() < 1e-14, "{text}");
        }
    }

    #[test]
    fn a_typo_is_answered_with_what_there_is() {
        let why = |text: &str| quantity(text).value(&run()).unwrap_err();
        assert!(why("summary = \"energy.eror\"").contains("did you mean `error`?"));
        assert!(why("summary = \"energy\"").contains("it contains: error, list"));
        assert!(why("summary = \"reason\"").contains("not a number"));
        assert!(
            why("history = \"kinetik\"")
                .contains("did you mean `kinetic`? there are: time, kinetic")
        );
        assert!(why("history = \"kinetic\"\nat = 5.0").contains("goes from 0 to 4"));
        assert!(quantity("history = \"kinetic\"\ncrossing = 50.0").value(&run()).unwrap().is_nan());
    }

    #[test]
    fn contradictions_are_found_before_anything_runs() {
        for text in [
            "at = 1.0",
            "summary = \"a\"\nhistory = \"b\"",
            "summary = \"a\"\nat = 1.0",
            "history = \"a\"\nat = 1.0\nstat = \"max\"",
            "history = \"a\"\npart = 1",
            "summary = \"a\"\nfrom = 1.0",
            "summary = \"a\"\nminus = { at = 1.0 }",
        ] {
            assert!(quantity(text).wrong().is_some(), "{text}");
        }
    }
}
