//! Numbers from the results of a run, and requirements on them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A requirement on the results. If the run completes and does not meet it, the exit code is 1.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Requirement {
    /// Name in the results, such as `peak force`.
    pub name: String,
    /// Number that is compared with the limits.
    pub quantity: Quantity,
    /// Largest value that meets the requirement, in the unit of the quantity.
    #[serde(default)]
    pub below: Option<f64>,
    /// Smallest value that meets the requirement, in the unit of the quantity.
    #[serde(default)]
    pub above: Option<f64>,
}

impl Requirement {
    /// Returns true if a value is within the limits. Infinity and NaN are not.
    pub fn is_met_by(&self, value: f64) -> bool {
        self.below.is_none_or(|limit| value <= limit)
            && self.above.is_none_or(|limit| value >= limit)
            && value.is_finite()
    }
}

/// A number of a run. The source is one of `summary`, `history` and `field`; the value is
/// `(source - minus) / over * scale`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Quantity {
    /// Dotted path in `summary.json`, such as `energy.error_max` or `momentum.end.0`.
    pub summary: Option<String>,
    /// Column of `history.csv`, or with `table` of the file of that name, with or without its unit.
    /// In a table also a vector, such as `acceleration`, for its magnitude; with `relative_to`
    /// nodes also have their `distance` and its `distance change` since the first row.
    pub history: Option<String>,
    /// File of the column of `history`, if that is not `history.csv`.
    pub table: Option<ObjectTable>,
    /// Entry of the table: the name of a part, section, transducer, wall, airbag, or of an
    /// `[[output.node]]` with one node; the id of a part or node; name and id of a node, such
    /// as `head 7`; or kind and name of an object of a seat belt, such as `ring D-ring`.
    pub of: Option<String>,
    /// Entry of the table whose values are subtracted, named as in `of`. The difference of a vector
    /// is that of its components.
    pub relative_to: Option<String>,
    /// Filter of SAE J211-1 for the column of `history`, with zero phase. Components of a vector
    /// are filtered before its magnitude. Needs `units` of the job, and an
    /// `output.history_interval` below 0.24 s over the number of the class; the standard asks for
    /// 0.1 s over it.
    pub filter: Option<FilterClass>,
    /// Array of the field files, such as `velocity`: the mean over the elements of `part`.
    pub field: Option<String>,
    /// Component of the field: x, y, z, or xx, yy, zz, xy, yz, zx of a tensor. By default the
    /// length of a vector.
    pub component: Option<String>,
    /// Id of the part whose elements are used; all parts by default.
    pub part: Option<u32>,
    /// Reduction of the elements to one number; the mean by default.
    pub elements: Option<ElementReduction>,
    /// Simulated time of the value [time]. History rows are interpolated; of fields the nearest
    /// output step is used.
    pub at: Option<f64>,
    /// Reduction of the rows to one number; the last row by default.
    pub stat: Option<RowReduction>,
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

/// File with one row per object and time.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum ObjectTable {
    /// `nodes.csv`: nodes of `[[output.node]]`.
    Nodes,
    /// `parts.csv`.
    Parts,
    /// `sections.csv`: sections of `[[output.section]]`.
    Sections,
    /// `transducers.csv`: force transducers of `[[output.transducer]]`.
    Transducers,
    /// `walls.csv`: rigid walls.
    Walls,
    /// `contacts.csv`: the contact force on each part.
    Contacts,
    /// `airbags.csv`.
    Airbags,
    /// `belts.csv`.
    Belts,
}

impl ObjectTable {
    /// All tables.
    pub const ALL: [Self; 8] = [
        Self::Nodes,
        Self::Parts,
        Self::Sections,
        Self::Transducers,
        Self::Walls,
        Self::Contacts,
        Self::Airbags,
        Self::Belts,
    ];
}

/// Channel frequency class of SAE J211-1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum FilterClass {
    /// -3 dB at 100 Hz.
    #[serde(rename = "CFC 60")]
    Cfc60,
    /// -3 dB at 300 Hz.
    #[serde(rename = "CFC 180")]
    Cfc180,
    /// -3 dB at 1000 Hz.
    #[serde(rename = "CFC 600")]
    Cfc600,
    /// -3 dB at 1667 Hz.
    #[serde(rename = "CFC 1000")]
    Cfc1000,
}

impl FilterClass {
    /// Returns the number of the class: the upper end of its pass band [Hz].
    pub fn hertz(self) -> f64 {
        match self {
            Self::Cfc60 => 60.0,
            Self::Cfc180 => 180.0,
            Self::Cfc600 => 600.0,
            Self::Cfc1000 => 1000.0,
        }
    }
}

/// Reduction of the elements of a part to one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ElementReduction {
    /// Mean.
    Mean,
    /// Minimum.
    Min,
    /// Maximum.
    Max,
}

/// Reduction of a column to one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RowReduction {
    /// First row.
    First,
    /// Last row.
    Last,
    /// Minimum.
    Min,
    /// Maximum.
    Max,
    /// Largest magnitude.
    Peak,
    /// Mean over time by the trapezoidal rule.
    Mean,
    /// Slope of the least squares line [1/time].
    Slope,
    /// Largest magnitude over that of the first row.
    Growth,
}

impl Quantity {
    /// Creates a quantity from a path in the summary.
    pub fn summary(path: &str) -> Self {
        Self { summary: Some(path.into()), ..Self::default() }
    }

    /// Returns the ids of the parts that it names.
    pub fn parts(&self) -> Vec<u32> {
        let inner = [&self.minus, &self.over].into_iter().flatten().flat_map(|q| q.parts());
        self.part.into_iter().chain(inner).collect()
    }

    /// Returns a time that it names outside of a run to `end_time`, if any.
    pub fn time_outside(&self, end_time: f64) -> Option<f64> {
        let own = [self.at, self.from].into_iter().flatten().find(|t| *t > end_time);
        let own = own.or([self.at, self.to].into_iter().flatten().find(|t| *t < 0.0));
        let inner = || {
            [&self.minus, &self.over].into_iter().flatten().find_map(|q| q.time_outside(end_time))
        };
        own.or_else(inner)
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
        let of_object = self.table.is_some() || self.of.is_some() || self.relative_to.is_some();
        if self.history.is_none() && (of_object || self.filter.is_some()) {
            return Some(
                "`table`, `of`, `relative_to` and `filter` belong to history = \"...\"".into(),
            );
        }
        if of_object && (self.table.is_none() || self.of.is_none()) {
            return Some(
                "`table` and `of` belong together: table = \"nodes\", of = \"head\"".into(),
            );
        }
        if [&self.of, &self.relative_to].into_iter().flatten().any(|name| name.is_empty()) {
            return Some("give `of` and `relative_to` a name or an id".into());
        }
        if let (Some(from), Some(to)) = (self.from, self.to)
            && from > to
        {
            return Some(format!("no time is from {from} to {to}: exchange them"));
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
}

#[cfg(test)]
mod tests {
    use super::*;

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
            "history = \"a\"\ntable = \"nodes\"",
            "history = \"a\"\nof = \"head\"",
            "history = \"a\"\ntable = \"walls\"\nof = \"\"",
            "summary = \"a\"\nfilter = \"CFC 60\"",
            "summary = \"a\"\ntable = \"nodes\"\nof = \"head\"",
            "history = \"a\"\nfrom = 2.0\nto = 1.0",
        ] {
            assert!(toml::from_str::<Quantity>(text).unwrap().wrong().is_some(), "{text}");
        }
        assert_eq!(Quantity::summary("cycles").wrong(), None);
        let late: Quantity =
            toml::from_str("summary = \"a\"\nover = { history = \"b\", from = 2.0 }").unwrap();
        assert_eq!((late.time_outside(1.0), late.time_outside(2.0)), (Some(2.0), None));
        let early = Quantity { at: Some(-0.5), ..Quantity::default() };
        assert_eq!(early.time_outside(1.0), Some(-0.5));
    }

    #[test]
    fn a_value_meets_both_limits_or_not_at_all() {
        let of = |below, above| Requirement {
            name: "force".into(),
            quantity: Quantity::summary("a"),
            below,
            above,
        };
        assert!(of(Some(2.0), Some(1.0)).is_met_by(1.5));
        assert!(of(Some(2.0), None).is_met_by(2.0) && of(None, Some(2.0)).is_met_by(2.0));
        assert!(!of(Some(2.0), None).is_met_by(2.1) && !of(None, Some(2.0)).is_met_by(1.9));
        assert!(!of(Some(2.0), None).is_met_by(f64::NAN));
        assert!(!of(None, Some(2.0)).is_met_by(f64::INFINITY), "a division by zero");
    }
}
