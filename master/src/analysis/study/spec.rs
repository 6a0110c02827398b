//! The study file in TOML, and its checks before any run.

use crumple_proto::job::Quantity;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// A study: a job, a grid of settings, measures, cost and charts.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Title in one line, shown at the top of the charts.
    pub title: String,
    /// The job, relative to the study file.
    pub job: PathBuf,
    /// Settings of all points, as for `--set`.
    #[serde(default)]
    pub set: Table,
    /// Series that are compared.
    pub series: Vec<StudySeries>,
    /// Measured quantities.
    pub measure: Vec<Measure>,
    /// Cost of a point.
    #[serde(default)]
    pub cost: Cost,
    /// Charts.
    #[serde(default)]
    pub chart: Vec<Chart>,
    /// Limit of the wall time of a point [s]. A point that takes longer has failed. No limit by
    /// default.
    pub time_limit: Option<f64>,
}

/// Points with one name, such as those of a contact law.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudySeries {
    /// Name in legends.
    pub name: String,
    /// Settings of all points of the series.
    #[serde(default)]
    pub set: Table,
    /// Lists of values; every combination is a point.
    #[serde(default)]
    pub grid: Table,
    /// Lists of values of equal length that vary together; combined with `grid`.
    #[serde(default)]
    pub zip: Table,
}

/// A quantity measured in every run.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Name in charts and in `results.csv`.
    pub name: String,
    /// Unit; empty for a plain number.
    #[serde(default)]
    pub unit: String,
    /// Source of the value.
    pub quantity: Quantity,
    /// Reference value.
    pub reference: Option<Reference>,
    /// True if the error is divided by the reference.
    #[serde(default = "yes")]
    pub relative: bool,
}

fn yes() -> bool {
    true
}

/// Reference of a measure.
#[derive(Clone, Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "a reference is a number, or { set = { ... } } for a run with the finest settings"
)]
pub enum Reference {
    /// A closed form or a published value.
    Value(f64),
    /// The same quantity of a run with the settings of the study and these.
    Run {
        /// Settings, as for `--set`.
        set: Table,
    },
}

/// Cost of a point.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cost {
    /// Name in charts.
    pub name: String,
    /// Unit.
    #[serde(default)]
    pub unit: String,
    /// Source of the value.
    pub quantity: Quantity,
}

impl Default for Cost {
    /// Returns the CPU time of all workers over simulated time.
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
    /// Error over cost, both logarithmic, with the Pareto front.
    Pareto,
    /// A measure, or the end of the runs, as colour over two settings; one chart per series.
    Map,
    /// A measure over one setting.
    Lines,
}

/// A chart.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chart {
    /// File name without extension.
    pub file: String,
    /// Kind.
    pub kind: ChartKind,
    /// Title of the chart; the study's title by default.
    pub title: Option<String>,
    /// Name of the measure; the first one by default. For a map also `ended`: completed or
    /// failed.
    pub measure: Option<String>,
    /// True to draw the error of the measure instead of its value (maps and lines).
    #[serde(default)]
    pub error: bool,
    /// Setting along x (maps and lines).
    pub x: Option<String>,
    /// Setting along y (maps).
    pub y: Option<String>,
    /// Title of the x axis with its unit; the setting's name by default.
    pub x_title: Option<String>,
    /// Title of the y axis with its unit.
    pub y_title: Option<String>,
    /// Logarithmic scales among `x`, `y` and `colour` (maps and lines).
    #[serde(default)]
    pub log: Vec<String>,
    /// Names of the series to show; all by default.
    pub series: Option<Vec<String>>,
    /// Curves over the map or the lines.
    #[serde(default)]
    pub curve: Vec<TheoryCurve>,
}

/// A theoretical curve: points, or a formula.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TheoryCurve {
    /// Name in the legend.
    pub name: String,
    /// Points in the coordinates of the chart.
    #[serde(default)]
    pub points: Vec<[f64; 2]>,
    /// y as a formula of `x`, such as `2 / sqrt(1 + x)`.
    pub formula: Option<String>,
}

impl Study {
    /// Reads a study.
    ///
    /// # Errors
    /// The study has errors; the text lists all of them.
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
            wrong.push(format!("job: {} does not exist", self.job.display()));
        }
        if self.time_limit.is_some_and(|limit| limit.is_nan() || limit <= 0.0) {
            wrong.push("time_limit has to be above 0 [s]".into());
        }
        let names: Vec<&str> = self.series.iter().map(|s| s.name.as_str()).collect();
        let measures: Vec<&str> = self.measure.iter().map(|m| m.name.as_str()).collect();
        for (what, names) in [("series", &names), ("measure", &measures)] {
            let twice = names.iter().enumerate().filter(|(i, n)| names[..*i].contains(n));
            wrong.extend(
                twice.map(|(_, n)| format!("two entries of [[{what}]] have the name `{n}`")),
            );
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
            return Some(format!("log = [\"{l}\"]: use x, y or colour"));
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
                        "no series varies `{s}`; varied settings: {}",
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

    /// Returns the settings that any series varies.
    fn varied(&self) -> Vec<String> {
        let lists =
            self.series.iter().flat_map(|s| flatten(&s.grid).into_iter().chain(flatten(&s.zip)));
        let mut keys: Vec<String> = lists.map(|(key, _)| key).collect();
        keys.sort();
        keys.dedup();
        keys
    }
}

/// Name of the pseudo-measure by which a map shows how runs ended.
pub const ENDED: &str = "ended";

/// Returns a formula of `x` as a function.
///
/// # Errors
/// The formula is invalid, or has other variables.
pub fn formula(text: &str) -> Result<impl Fn(f64) -> f64 + use<>, String> {
    use exmex::Express;
    let read = exmex::FlatEx::<f64>::parse(text).map_err(|_| {
        format!(
            "formula `{text}` cannot be read: it has to be an expression of x, such as \
             2 / sqrt(1 + x)"
        )
    })?;
    let strange = read.var_names().iter().find(|name| *name != "x").cloned();
    if let Some(name) = strange {
        return Err(format!("formula `{text}`: `{name}` is unknown; the only variable is x"));
    }
    let variables = read.var_names().len();
    Ok(move |x: f64| read.eval(&[x][..variables]).unwrap_or(f64::NAN))
}

/// Returns the dotted keys of a table with their values; `a.b = 1` and `"a.b" = 1` are equal.
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
