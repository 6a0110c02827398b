//! Numbers from the results of a run: an entry of `summary.json`, a column of `history.csv`, a
//! field of a part.

use super::probe;
use crate::input::job::Model;
use crate::results::history;
use crate::results::summary::{Summary, phases};
use crumple_proto::job::{ElementReduction, Quantity, RowReduction};
use serde_json::Value;
use std::path::{Path, PathBuf};

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

/// Returns the error in a name that no run of the job has, if any. `blank` is
/// [`RunResults::blank`].
/// Lists that are empty there, such as that of parts, may have any entry.
pub fn unknown_name(q: &Quantity, blank: &RunResults) -> Option<String> {
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
    let own = match (&q.summary, &q.history, &q.field) {
        (Some(path), _, _) if !open(path) => blank.in_summary(path).err(),
        (_, Some(column), _) => blank.place(column).err(),
        (_, _, Some(field)) => probe::unknown(field, q.component.as_deref()),
        _ => None,
    };
    own.or_else(|| [&q.minus, &q.over].into_iter().flatten().find_map(|q| unknown_name(q, blank)))
}

/// Returns its value in a run.
///
/// # Errors
/// The run does not have it. The message lists the names that exist.
pub fn value(q: &Quantity, run: &RunResults) -> Result<f64, String> {
    let mut result = match (&q.summary, &q.history, &q.field) {
        (Some(path), _, _) => run.in_summary(path)?,
        (_, Some(column), _) => in_history(q, &run.column(column, window(q))?)?,
        (_, _, Some(field)) => {
            let values = probe::values(&run.folder, field, q.component.as_deref(), q.part, q.at)?;
            match q.elements.unwrap_or(ElementReduction::Mean) {
                ElementReduction::Mean => values.iter().sum::<f64>() / values.len() as f64,
                ElementReduction::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
                ElementReduction::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            }
        }
        _ => return Err("a quantity needs a source".into()),
    };
    if let Some(minus) = &q.minus {
        result -= value(minus, run)?;
    }
    if let Some(over) = &q.over {
        result /= value(over, run)?;
    }
    Ok(result * q.scale.unwrap_or(1.0))
}

/// Returns the time window of the rows, slightly widened because times in the file are
/// rounded.
fn window(q: &Quantity) -> [f64; 2] {
    let hair = |t: f64| 1e-8 * t.abs();
    let from = q.from.map_or(f64::NEG_INFINITY, |t| t - hair(t));
    [from, q.to.map_or(f64::INFINITY, |t| t + hair(t))]
}

fn in_history(q: &Quantity, rows: &[[f64; 2]]) -> Result<f64, String> {
    let between = |a: [f64; 2], b: [f64; 2], s: f64| [0, 1].map(|c| a[c] + s * (b[c] - a[c]));
    if let Some(at) = q.at {
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
    if let Some(level) = q.crossing {
        let pair = rows
            .windows(2)
            .find(|w| (w[0][1] - level) * (w[1][1] - level) <= 0.0 && w[0][1] != w[1][1]);
        let time = |w: &[[f64; 2]]| between(w[0], w[1], (level - w[0][1]) / (w[1][1] - w[0][1]))[0];
        return Ok(pair.map_or(f64::NAN, time));
    }
    let values = rows.iter().map(|r| r[1]);
    Ok(match q.stat.unwrap_or(RowReduction::Last) {
        RowReduction::First => rows[0][1],
        RowReduction::Last => rows[rows.len() - 1][1],
        RowReduction::Min => values.fold(f64::INFINITY, f64::min),
        RowReduction::Max => values.fold(f64::NEG_INFINITY, f64::max),
        RowReduction::Mean if rows.len() == 1 => rows[0][1],
        RowReduction::Mean => {
            let area: f64 =
                rows.windows(2).map(|w| 0.5 * (w[0][1] + w[1][1]) * (w[1][0] - w[0][0])).sum();
            area / (rows[rows.len() - 1][0] - rows[0][0])
        }
        RowReduction::Slope => {
            let n = rows.len() as f64;
            let mean = [0, 1].map(|c| rows.iter().map(|r| r[c]).sum::<f64>() / n);
            let sum = |f: fn(f64, f64) -> f64| {
                rows.iter().map(|r| f(r[0] - mean[0], r[1] - mean[1])).sum::<f64>()
            };
            sum(|t, v| t * v) / sum(|t, _| t * t)
        }
        RowReduction::Growth => values.map(f64::abs).fold(0.0, f64::max) / rows[0][1].abs(),
    })
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
        for (text, wanted) in cases {
            assert_eq!(quantity(text).wrong(), None, "{text}");
            // Exact except for the rounding of a few operations on numbers of order one.
            assert!((value(&quantity(text), &run()).unwrap() - wanted).abs() < 1e-14, "{text}");
        }
    }

    #[test]
    fn a_typo_is_answered_with_what_there_is() {
        let why = |text: &str| value(&quantity(text), &run()).unwrap_err();
        assert!(why("summary = \"energy.eror\"").contains("did you mean `error`?"));
        assert!(why("summary = \"energy\"").contains("it contains: error, list"));
        assert!(why("summary = \"reason\"").contains("not a number"));
        assert!(
            why("history = \"kinetik\"")
                .contains("did you mean `kinetic`? there are: time, kinetic")
        );
        assert!(why("history = \"kinetic\"\nat = 5.0").contains("goes from 0 to 4"));
        assert!(
            value(&quantity("history = \"kinetic\"\ncrossing = 50.0"), &run()).unwrap().is_nan()
        );
    }
}
