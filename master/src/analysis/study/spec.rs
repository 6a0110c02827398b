//! A study as it is written in TOML, and what can be wrong with it before anything runs.

use super::quantity::Quantity;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// A study: a job, a grid of settings, what is measured, what it costs, what is drawn.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// One line; the head of the charts.
    pub title: String,
    /// The job, relative to the study's file.
    pub job: PathBuf,
    /// Settings of all points, as behind `--set`.
    #[serde(default)]
    pub set: Table,
    /// What is compared.
    pub series: Vec<Series>,
    /// What is measured.
    pub measure: Vec<Measure>,
    /// What it costs.
    #[serde(default)]
    pub cost: Cost,
    /// What is drawn.
    #[serde(default)]
    pub chart: Vec<Chart>,
    /// Longest that a point may take [s of wall time]; one that takes longer has failed. None
    /// without it.
    pub time_limit: Option<f64>,
}

/// Points of one name, such as a contact law.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// Name in legends.
    pub name: String,
    /// Settings of all points of the series.
    #[serde(default)]
    pub set: Table,
    /// Lists of values; every combination is a point.
    #[serde(default)]
    pub grid: Table,
    /// Lists of values of equal length that go side by side; combined with `grid`.
    #[serde(default)]
    pub zip: Table,
}

/// Something measured in every run.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Name in charts and in `results.csv`.
    pub name: String,
    /// Its unit; none for a plain number.
    #[serde(default)]
    pub unit: String,
    /// Where it comes from.
    pub quantity: Quantity,
    /// What it should be.
    pub reference: Option<Reference>,
    /// Whether the error is divided by the reference.
    #[serde(default = "yes")]
    pub relative: bool,
}

fn yes() -> bool {
    true
}

/// What a measure is compared with.
#[derive(Clone, Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "a reference is a number, or { set = { ... } } for a run with the finest settings"
)]
pub enum Reference {
    /// A closed form or a published value.
    Value(f64),
    /// The same quantity of a run with the study's own settings and these.
    Run {
        /// Settings, as behind `--set`.
        set: Table,
    },
}

/// What a point costs.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cost {
    /// Name in charts.
    pub name: String,
    /// Its unit.
    #[serde(default)]
    pub unit: String,
    /// Where it comes from.
    pub quantity: Quantity,
}

impl Default for Cost {
    /// CPU time of all workers over simulated time.
    fn default() -> Self {
        let quantity = Quantity {
            over: Some(Box::new(Quantity::summary("end_time"))),
            ..Quantity::summary("cpu_s.total")
        };
        Self {
            name: "CPU time per simulated time".into(),
            unit: "s / unit of time".into(),
            quantity,
        }
    }
}

/// Kinds of charts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ChartKind {
    /// Error against cost, both logarithmic, with the Pareto front.
    Pareto,
    /// A measure, or how runs ended, as colour over two settings; one chart for each series.
    Map,
    /// A measure over one setting.
    Lines,
}

/// A chart.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chart {
    /// Name of the files, without ending.
    pub file: String,
    /// Kind.
    pub kind: ChartKind,
    /// Head; the study's title without it.
    pub title: Option<String>,
    /// Name of the measure; the first one without it. For a map also `ended`: well or not.
    pub measure: Option<String>,
    /// Draw the error of the measure, not its value (maps and lines).
    #[serde(default)]
    pub error: bool,
    /// Setting along x (maps and lines).
    pub x: Option<String>,
    /// Setting along y (maps).
    pub y: Option<String>,
    /// Title of the x axis, with its unit; the setting's name without it.
    pub x_title: Option<String>,
    /// Title of the y axis, with its unit.
    pub y_title: Option<String>,
    /// Which of `x`, `y` and `colour` are logarithmic (maps and lines).
    #[serde(default)]
    pub log: Vec<String>,
    /// Names of the series to show; all without it.
    pub series: Option<Vec<String>>,
    /// Curves over the map or the lines.
    #[serde(default)]
    pub curve: Vec<Curve>,
}

/// A curve of theory: points, or a formula.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Points in the chart's own coordinates.
    #[serde(default)]
    pub points: Vec<[f64; 2]>,
    /// y as a formula of `x`, such as `2 / sqrt(1 + x)`.
    pub formula: Option<String>,
}

impl Study {
    /// Reads a study.
    ///
    /// # Errors
    /// Everything that is wrong with it, as text for people.
    pub fn read(path: &Path) -> Result<Self, String> {
        let shown = path.display();
        let text = std::fs::read_to_string(path).map_err(|error| format!("{shown}: {error}"))?;
        let mut study: Self = toml::from_str(&text).map_err(|error| format!("{shown}: {error}"))?;
        study.job = path.parent().unwrap_or(Path::new("")).join(&study.job);
        let wrong = study.wrong();
        if wrong.is_empty() {
            Ok(study)
        } else {
            Err(format!("{shown}:\n  {}", wrong.join("\n  ")))
        }
    }

    fn wrong(&self) -> Vec<String> {
        let mut wrong = Vec::new();
        if self.series.is_empty() || self.measure.is_empty() {
            wrong.push("a study needs at least one [[series]] and one [[measure]]".into());
        }
        if !self.job.exists() {
            wrong.push(format!("job: {} is not there", self.job.display()));
        }
        if self.time_limit.is_some_and(|limit| limit.is_nan() || limit <= 0.0) {
            wrong.push("time_limit has to be above 0 [s]".into());
        }
        let names: Vec<&str> = self.series.iter().map(|s| s.name.as_str()).collect();
        let measures: Vec<&str> = self.measure.iter().map(|m| m.name.as_str()).collect();
        for (what, names) in [("series", &names), ("measure", &measures)] {
            let twice = names.iter().enumerate().filter(|(i, n)| names[..*i].contains(n));
            wrong.extend(twice.map(|(_, n)| format!("two entries of [[{what}]] are called `{n}`")));
        }
        for m in &self.measure {
            wrong.extend(m.quantity.wrong().map(|why| format!("measure `{}`: {why}", m.name)));
        }
        wrong.extend(self.cost.quantity.wrong().map(|why| format!("cost: {why}")));
        for c in &self.chart {
            wrong.extend(
                self.wrong_chart(c, &names, &measures)
                    .map(|why| format!("chart `{}`: {why}", c.file)),
            );
        }
        wrong
    }

    fn wrong_chart(&self, c: &Chart, names: &[&str], measures: &[&str]) -> Option<String> {
        let map = c.kind == ChartKind::Map;
        if let Some(m) =
            c.measure.as_deref().filter(|m| !(measures.contains(m) || map && *m == ENDED))
        {
            let last = if map { ", ended" } else { "" };
            return Some(format!(
                "there is no measure `{m}`; there are: {}{last}",
                measures.join(", ")
            ));
        }
        let unknown = c.series.iter().flatten().find(|s| !names.contains(&s.as_str()));
        if let Some(s) = unknown {
            return Some(format!("there is no series `{s}`; there are: {}", names.join(", ")));
        }
        if let Some(l) = c.log.iter().find(|l| !["x", "y", "colour"].contains(&l.as_str())) {
            return Some(format!("log = [\"{l}\"]: give any of x, y, colour"));
        }
        let asked = match c.kind {
            ChartKind::Pareto => vec![],
            ChartKind::Lines => vec![("x", &c.x)],
            ChartKind::Map => vec![("x", &c.x), ("y", &c.y)],
        };
        let settings = self.varied();
        for (axis, setting) in asked {
            match setting {
                None => return Some(format!("give the setting along {axis}: {axis} = \"...\"")),
                Some(s) if !settings.contains(s) => {
                    return Some(format!(
                        "no series varies `{s}`; varied are: {}",
                        settings.join(", ")
                    ));
                }
                Some(_) => {}
            }
        }
        let with_error = c.kind == ChartKind::Pareto || c.error;
        let measure =
            self.measure.iter().find(|m| c.measure.as_ref().is_none_or(|name| *name == m.name));
        if with_error && measure.is_some_and(|m| m.reference.is_none()) {
            return Some("an error needs a measure with a `reference`".into());
        }
        c.curve.iter().find_map(|curve| match (&curve.formula, curve.points.len()) {
            (Some(f), 0) => formula(f).err().map(|why| format!("curve `{}`: {why}", curve.name)),
            (None, 2..) => None,
            _ => Some(format!(
                "curve `{}` needs either a formula of x or at least two points",
                curve.name
            )),
        })
    }

    /// Settings that any series varies.
    fn varied(&self) -> Vec<String> {
        let lists =
            self.series.iter().flat_map(|s| flatten(&s.grid).into_iter().chain(flatten(&s.zip)));
        let mut keys: Vec<String> = lists.map(|(key, _)| key).collect();
        keys.sort();
        keys.dedup();
        keys
    }
}

/// What a map shows when it shows how runs ended.
pub const ENDED: &str = "ended";

/// A formula of `x` as a function.
///
/// # Errors
/// It cannot be read, or has other variables.
pub fn formula(text: &str) -> Result<impl Fn(f64) -> f64 + use<>, String> {
    use exmex::Express;
    let read = exmex::FlatEx::<f64>::parse(text).map_err(|_| {
        format!("formula `{text}` cannot be read: it has to be an expression of x, such as 2 / sqrt(1 + x)")
    })?;
    let strange = read.var_names().iter().find(|name| *name != "x").cloned();
    if let Some(name) = strange {
        return Err(format!("formula `{text}`: `{name}` is not known, the only variable is x"));
    }
    let variables = read.var_names().len();
    Ok(move |x: f64| read.eval(&[x][..variables]).unwrap_or(f64::NAN))
}

/// Keys of a table with dots and their values; `a.b = 1` and `"a.b" = 1` are the same.
pub fn flatten(table: &Table) -> Vec<(String, Value)> {
    let mut flat = Vec::new();
    for (key, value) in table {
        match value {
            Value::Table(inner) => {
                flat.extend(flatten(inner).into_iter().map(|(k, v)| (format!("{key}.{k}"), v)))
            }
            value => flat.push((key.clone(), value.clone())),
        }
    }
    flat
}
