//! Numbers from the results of a run: an entry of `summary.json`, a column of `history.csv` or of a
//! file with one row per object and time, a field of a part.

use super::channels::{Channels, ObjectFile, bare, filter_error, unit, unknown};
use super::probe;
use crate::input::job::Model;
use crate::results::history;
use crate::results::summary::{Summary, phases};
use crumple_proto::job::{ElementReduction, ObjectTable, Quantity, RowReduction};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Results of a run.
pub struct RunResults {
    /// Content of `summary.json`.
    pub summary: Value,
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
    folder: PathBuf,
    /// Files by object of a run that has not begun, or the reason why it will not have them.
    expected: BTreeMap<ObjectTable, Result<ObjectFile, String>>,
    /// Interval of histories of such a run [time].
    interval: f64,
}

/// Value of a quantity in a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuantityValue {
    /// The number.
    pub value: f64,
    /// Its unit, as far as it is known; empty if not.
    pub unit: String,
    /// Time of the row with the smallest or largest value, if it is one of these [time].
    pub time: Option<f64>,
    /// Unit of that time; empty without a time.
    pub unit_of_time: String,
}

/// A name that no run of a job has.
pub struct UnknownName {
    /// Dotted path of its key within the quantity.
    pub key: String,
    /// Message with the names that exist.
    pub why: String,
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
        let expected = BTreeMap::new();
        Ok(Self { summary, header, rows, folder: folder.to_owned(), expected, interval: 0.0 })
    }

    /// Returns the results of a run of this job without its numbers, so that names can be checked
    /// before any run.
    pub fn blank(model: &Model) -> Self {
        let summary = Summary { phase_s: phases(&[]), ..Summary::default() };
        let summary = serde_json::to_value(summary).unwrap_or_default();
        let table = |&table: &ObjectTable| (table, ObjectFile::of_job(model, table));
        Self {
            summary,
            header: history::columns(model),
            rows: Vec::new(),
            folder: PathBuf::new(),
            expected: ObjectTable::ALL.iter().map(table).collect(),
            interval: model.settings.history_interval,
        }
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
        self.header.iter().position(|h| h == name || bare(h) == name).ok_or_else(|| {
            let names: Vec<String> = self.header.iter().map(|h| bare(h).to_string()).collect();
            unknown("history.csv", name, name, &names)
        })
    }

    fn unit_of_time(&self) -> &str {
        self.header.first().map_or("", |time| unit(time))
    }

    /// Returns the values of a column over time.
    fn channels(&self, q: &Quantity, column: &str) -> Result<Channels, String> {
        if let (Some(table), Some(of)) = (q.table, &q.of) {
            let file = ObjectFile::of_run(&self.folder, table)?;
            return file.read(&self.folder, of, q.relative_to.as_deref(), column);
        }
        let at = self.place(column)?;
        Ok(Channels {
            times: self.rows.iter().map(|row| row[0]).collect(),
            channels: vec![self.rows.iter().map(|row| row[at]).collect()],
            unit: unit(&self.header[at]).into(),
            unit_of_time: self.unit_of_time().into(),
        })
    }

    /// Returns the key and the reason of a wrong name or filter of a history, if any.
    fn wrong_history(&self, q: &Quantity, column: &str) -> Option<(&'static str, String)> {
        let own = match (q.table, &q.of) {
            (Some(table), Some(of)) => match self.expected.get(&table) {
                Some(Ok(file)) => file.wrong_name(of, q.relative_to.as_deref(), column),
                Some(Err(why)) => Some(("table", why.clone())),
                None => None,
            },
            _ => self.place(column).err().map(|why| ("history", why)),
        };
        own.or_else(|| {
            let why = filter_error(q.filter?, self.unit_of_time(), self.interval)?;
            Some(("filter", why))
        })
    }
}

/// Returns the error in a name that no run of the job has, or in a filter that its histories do not
/// suffice for, if any. `blank` is [`RunResults::blank`].
/// Lists that are empty there, such as that of parts, may have any entry.
pub fn unknown_name(q: &Quantity, blank: &RunResults) -> Option<UnknownName> {
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
        (Some(path), _, _) if !open(path) => {
            blank.in_summary(path).err().map(|why| ("summary", why))
        }
        (_, Some(column), _) => blank.wrong_history(q, column),
        (_, _, Some(field)) => {
            probe::unknown(field, q.component.as_deref()).map(|why| ("field", why))
        }
        _ => None,
    };
    let inner = |(key, q): (&str, &Option<Box<Quantity>>)| {
        let UnknownName { key: below, why } = unknown_name(q.as_ref()?, blank)?;
        Some(UnknownName { key: format!("{key}.{below}"), why })
    };
    own.map(|(key, why)| UnknownName { key: key.into(), why })
        .or_else(|| [("minus", &q.minus), ("over", &q.over)].into_iter().find_map(inner))
}

/// Returns its value in a run.
///
/// # Errors
/// The run does not have it. The message lists the names that exist.
pub fn value(q: &Quantity, run: &RunResults) -> Result<f64, String> {
    measure(q, run).map(|measured| measured.value)
}

/// Returns its value in a run with its unit, and with the time of an extreme.
///
/// # Errors
/// The run does not have it. The message lists the names that exist.
pub fn measure(q: &Quantity, run: &RunResults) -> Result<QuantityValue, String> {
    let mut result = match (&q.summary, &q.history, &q.field) {
        (Some(path), _, _) => {
            QuantityValue { value: run.in_summary(path)?, ..QuantityValue::default() }
        }
        (_, Some(column), _) => of_history(q, run.channels(q, column)?)?,
        (_, _, Some(field)) => {
            let values = probe::values(&run.folder, field, q.component.as_deref(), q.part, q.at)?;
            let value = match q.elements.unwrap_or(ElementReduction::Mean) {
                ElementReduction::Mean => values.iter().sum::<f64>() / values.len() as f64,
                ElementReduction::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
                ElementReduction::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            };
            QuantityValue { value, ..QuantityValue::default() }
        }
        _ => return Err("a quantity needs a source".into()),
    };
    if let Some(minus) = &q.minus {
        let other = measure(minus, run)?;
        result.value -= other.value;
        if other.unit != result.unit {
            result.unit = String::new();
        }
    }
    if let Some(over) = &q.over {
        result.value /= value(over, run)?;
    }
    // A result of two quantities has no time of its own.
    if q.minus.is_some() || q.over.is_some() {
        (result.time, result.unit_of_time) = (None, String::new());
    }
    // A ratio or a converted value has another unit.
    if q.over.is_some() || q.scale.is_some() {
        result.unit = String::new();
    }
    result.value *= q.scale.unwrap_or(1.0);
    Ok(result)
}

/// Reduces a history to one number.
fn of_history(q: &Quantity, channels: Channels) -> Result<QuantityValue, String> {
    let (unit, unit_of_time) = (channels.unit.clone(), channels.unit_of_time.clone());
    let [from, to] = window(q);
    let inside = |row: &[f64; 2]| row[0] >= from && row[0] <= to;
    let rows: Vec<[f64; 2]> = channels.curve(q.filter)?.into_iter().filter(inside).collect();
    if rows.is_empty() {
        let side = |time: Option<f64>, end: &str| time.map_or(end.into(), |t| t.to_string());
        let (from, to) = (side(q.from, "the start"), side(q.to, "the end"));
        return Err(format!("the history has no rows from {from} to {to}"));
    }
    let (value, time) = in_history(q, &rows)?;
    let unit = match q.stat {
        _ if q.crossing.is_some() => unit_of_time.clone(),
        Some(RowReduction::Growth) => String::new(),
        Some(RowReduction::Slope) if unit.is_empty() => format!("1/{unit_of_time}"),
        Some(RowReduction::Slope) if unit.contains('/') => format!("({unit})/{unit_of_time}"),
        Some(RowReduction::Slope) => format!("{unit}/{unit_of_time}"),
        _ => unit,
    };
    let unit_of_time = time.map_or(String::new(), |_| unit_of_time);
    Ok(QuantityValue { value, unit, time, unit_of_time })
}

/// Returns the time window of the rows, slightly widened because times in the file are
/// rounded.
fn window(q: &Quantity) -> [f64; 2] {
    let hair = |t: f64| 1e-8 * t.abs();
    let from = q.from.map_or(f64::NEG_INFINITY, |t| t - hair(t));
    [from, q.to.map_or(f64::INFINITY, |t| t + hair(t))]
}

/// Returns the number, and the time of its row if it is an extreme.
fn in_history(q: &Quantity, rows: &[[f64; 2]]) -> Result<(f64, Option<f64>), String> {
    let between = |a: [f64; 2], b: [f64; 2], s: f64| [0, 1].map(|c| a[c] + s * (b[c] - a[c]));
    if let Some(at) = q.at {
        let last = rows[rows.len() - 1];
        if at < rows[0][0] || at > last[0] * (1.0 + 1e-8) {
            return Err(format!(
                "the history goes from {} to {}, not to {at}",
                rows[0][0], last[0]
            ));
        }
        let pair = rows.windows(2).find(|w| w[1][0] >= at);
        let value =
            pair.map_or(last, |w| between(w[0], w[1], (at - w[0][0]) / (w[1][0] - w[0][0])))[1];
        return Ok((value, None));
    }
    if let Some(level) = q.crossing {
        let pair = rows
            .windows(2)
            .find(|w| (w[0][1] - level) * (w[1][1] - level) <= 0.0 && w[0][1] != w[1][1]);
        let time = |w: &[[f64; 2]]| between(w[0], w[1], (level - w[0][1]) / (w[1][1] - w[0][1]))[0];
        return Ok((pair.map_or(f64::NAN, time), None));
    }
    let values = rows.iter().map(|r| r[1]);
    // The first of equal rows; rows without a number are no extremes.
    let extreme = |size: fn(f64) -> f64| {
        let numbers = rows.iter().filter(|row| !row[1].is_nan());
        let larger = |best: &[f64; 2], row: &[f64; 2]| size(row[1]) > size(best[1]);
        let best =
            numbers.copied().reduce(|best, row| if larger(&best, &row) { row } else { best });
        best.map_or((f64::NAN, None), |[time, value]| (value, Some(time)))
    };
    let value = match q.stat.unwrap_or(RowReduction::Last) {
        RowReduction::First => rows[0][1],
        RowReduction::Last => rows[rows.len() - 1][1],
        RowReduction::Min => return Ok(extreme(|value| -value)),
        RowReduction::Max => return Ok(extreme(|value| value)),
        RowReduction::Peak => {
            let (value, time) = extreme(f64::abs);
            return Ok((value.abs(), time));
        }
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
    };
    Ok((value, None))
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
        let (folder, expected) = (PathBuf::new(), BTreeMap::new());
        RunResults { summary, header, rows, folder, expected, interval: 0.0 }
    }

    #[test]
    fn numbers_come_from_the_summary_and_from_columns() {
        let cases = [
            ("summary = \"energy.list.1\"", 7.0),
            ("history = \"kinetic\"", 10.0),
            ("history = \"kinetic [J]\"\nat = 1.5", 0.0),
            ("history = \"kinetic\"\nstat = \"min\"", -2.0),
            ("history = \"kinetic\"\nstat = \"max\"\nto = 1.0", 4.0),
            ("history = \"kinetic\"\nstat = \"peak\"\nfrom = 1.0\nto = 2.0", 2.0),
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
    fn values_have_units_and_extremes_have_times() {
        let of = |text: &str| measure(&quantity(text), &run()).unwrap();
        let value = |value, unit: &str, time: Option<f64>| QuantityValue {
            value,
            unit: unit.into(),
            time,
            unit_of_time: if time.is_some() { "ms".into() } else { String::new() },
        };
        for (text, wanted) in [
            ("history = \"kinetic\"\nstat = \"max\"", value(10.0, "J", Some(4.0))),
            ("history = \"kinetic\"\nstat = \"min\"", value(-2.0, "J", Some(2.0))),
            ("history = \"kinetic\"\nstat = \"peak\"\nfrom = 1.0\nto = 2.0", {
                value(2.0, "J", Some(1.0))
            }),
            ("history = \"kinetic\"", value(10.0, "J", None)),
            ("history = \"kinetic\"\ncrossing = 1.0", value(1.25, "ms", None)),
            ("history = \"kinetic\"\nscale = 2.0", value(20.0, "", None)),
            ("history = \"kinetic\"\nstat = \"max\"\nminus.history = \"kinetic\"", {
                value(0.0, "J", None)
            }),
            ("history = \"kinetic\"\nminus.history = \"kinetic\"\nminus.crossing = 1.0", {
                value(8.75, "", None)
            }),
        ] {
            assert_eq!(of(text), wanted, "{text}");
        }
        assert_eq!(of("summary = \"energy.error\"").unit, "");
    }

    #[test]
    fn a_typo_is_answered_with_what_there_is() {
        let why = |text: &str| value(&quantity(text), &run()).unwrap_err();
        assert!(why("summary = \"energy.eror\"").contains("did you mean `error`?"));
        assert!(why("summary = \"energy\"").contains("it contains: error, list"));
        assert!(why("summary = \"reason\"").contains("not a number"));
        assert!(
            why("history = \"kinetik\"").contains("did you mean `kinetic`? known: time, kinetic")
        );
        assert!(why("history = \"kinetic\"\nat = 5.0").contains("goes from 0 to 4"));
        assert!(
            value(&quantity("history = \"kinetic\"\ncrossing = 50.0"), &run()).unwrap().is_nan()
        );
    }
}
