//! Plots of `history.csv`: groups of columns, and derived values.

use serde::Serialize;
use std::path::Path;

/// Maximum number of rows in a plot. Longer histories are thinned.
pub const MOST_ROWS: usize = 4000;

/// A file of columns whose names contain units.
#[derive(Clone, Debug, Default)]
pub struct ColumnFile {
    columns: Vec<PlotColumn>,
    /// Number of rows of the file; the columns may have fewer.
    pub rows: usize,
    /// Damage of the file after these rows.
    pub damage: Option<String>,
}

#[derive(Clone, Debug)]
struct PlotColumn {
    name: String,
    unit: String,
    values: Vec<f64>,
}

/// Lines over a common axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plot {
    /// Title.
    pub title: String,
    /// Unit of its lines.
    pub unit: String,
    /// Note for the reader.
    pub note: String,
    /// Lines.
    pub lines: Vec<PlotLine>,
}

/// Values over the rows. A value that is not finite is a gap.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlotLine {
    /// Name in the legend.
    pub label: String,
    /// One value per row.
    pub values: Vec<f64>,
    /// True if the value is constant up to the next row.
    pub steps: bool,
}

/// All plots, over a common time axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Plots {
    /// Unit of the time.
    pub unit: String,
    /// Time of each row.
    pub time: Vec<f64>,
    /// The plots in their order.
    pub plots: Vec<Plot>,
}

/// Energies as named in `history.csv`, with their sign in the energy balance. Friction is part of
/// contact.
const ENERGIES: [(&str, f64); 7] = [
    ("kinetic", 1.0),
    ("internal", 1.0),
    ("hourglass", 1.0),
    ("contact work", -1.0),
    ("wall work", -1.0),
    ("external work", -1.0),
    ("friction work", 0.0),
];
const TOTAL: &str = "total";

impl ColumnFile {
    /// Reads the intact part of the file. A field that is not a number is a gap.
    ///
    /// # Errors
    /// The file is missing, or has no times.
    pub fn read(path: &Path) -> Result<Self, String> {
        let cannot = |error: csv::Error| match error.into_kind() {
            csv::ErrorKind::Io(error) => format!("{}: {error}", path.display()),
            csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
                let line = pos.map_or(0, |p| p.line());
                format!(
                    "{}: line {line} has {len} fields, the header {expected_len}",
                    path.display()
                )
            }
            _ => format!("{}: is not a table", path.display()),
        };
        let mut reader = csv::Reader::from_path(path).map_err(cannot)?;
        let mut columns: Vec<PlotColumn> =
            reader.headers().map_err(cannot)?.iter().map(PlotColumn::from_header).collect();
        let mut damage = None;
        for record in reader.records() {
            match record.map_err(cannot) {
                Ok(record) => columns.iter_mut().zip(&record).for_each(|(c, field)| {
                    c.values.push(field.parse().unwrap_or(f64::NAN));
                }),
                Err(why) => {
                    damage = Some(why);
                    break;
                }
            }
        }
        let rows = columns.first().map_or(0, |c| c.values.len());
        let every = rows.div_ceil(MOST_ROWS).max(1);
        if every > 1 {
            columns.iter_mut().for_each(|c| {
                let kept = c
                    .values
                    .iter()
                    .enumerate()
                    .filter(|(row, _)| row % every == 0 || row + 1 == rows);
                c.values = kept.map(|(_, v)| *v).collect();
            });
        }
        match columns.iter().any(|c| c.name == "time") {
            true => Ok(Self { columns, rows, damage }),
            false => Err(format!("{}: has no time column", path.display())),
        }
    }

    /// Returns the number of rows in plots.
    pub fn shown(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    fn column(&self, name: &str) -> Option<&PlotColumn> {
        self.columns.iter().find(|c| c.name == name)
    }

    /// Returns the unit of a column, empty if it has none.
    pub fn unit(&self, name: &str) -> &str {
        self.column(name).map_or("", |c| &c.unit)
    }

    fn values(&self, name: &str) -> Option<&[f64]> {
        self.column(name).map(|c| &c.values[..])
    }

    fn line(&self, name: &str, label: &str) -> Option<PlotLine> {
        Some(PlotLine { label: label.into(), values: self.values(name)?.to_vec(), steps: false })
    }

    /// Returns all plots whose columns exist. The number of workers is needed for the imbalance.
    pub fn plots(&self, workers: Option<u64>) -> Plots {
        let time = self.values("time").unwrap_or_default().to_vec();
        let all = [
            self.energies(),
            self.error(),
            self.forces(),
            self.step(),
            self.imbalance(workers),
            self.redecompositions(),
            self.classes(),
        ];
        let plots = all
            .into_iter()
            .flatten()
            .chain(self.contact())
            .filter(|p| !p.lines.is_empty())
            .collect();
        Plots { unit: self.unit("time").into(), time, plots }
    }

    fn energies(&self) -> Option<Plot> {
        let mut lines: Vec<PlotLine> =
            ENERGIES.iter().filter_map(|(name, _)| self.line(name, name)).collect();
        let mut total = vec![0.0; self.values("kinetic")?.len()];
        for (name, sign) in ENERGIES.iter().filter(|(_, sign)| *sign != 0.0) {
            total
                .iter_mut()
                .zip(self.values(name).unwrap_or_default())
                .for_each(|(t, v)| *t += sign * v);
        }
        // Lines that are zero everywhere are omitted.
        lines.retain(|line| line.values.iter().any(|v| *v != 0.0));
        lines.insert(0, PlotLine { label: TOTAL.into(), values: total, steps: false });
        let note = "total = kinetic + internal + hourglass, minus the work of contact, walls and \
                    loads. It should be constant. The work of contact includes friction.";
        Some(Plot {
            title: "Energies".into(),
            unit: self.unit("kinetic").into(),
            note: note.into(),
            lines,
        })
    }

    fn error(&self) -> Option<Plot> {
        let mut line = self.line("energy error", "balance error")?;
        line.values.iter_mut().for_each(|v| *v *= 100.0);
        let note = "Change of the total as a fraction of the supplied energy.";
        Some(Plot {
            title: "Energy balance".into(),
            unit: "%".into(),
            note: note.into(),
            lines: vec![line],
        })
    }

    /// Plots the magnitude of every force; of a single force the components as well.
    fn forces(&self) -> Option<Plot> {
        let of: Vec<&str> =
            self.columns.iter().filter_map(|c| c.name.strip_suffix(" force x")).collect();
        let mut lines = Vec::new();
        for name in &of {
            let component = |c: &str| self.values(&format!("{name} force {c}"));
            let (Some(x), Some(y), Some(z)) = (component("x"), component("y"), component("z"))
            else {
                continue;
            };
            let length = |i: usize| (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]).sqrt();
            let label = name.strip_suffix(" mean").unwrap_or(name);
            lines.push(PlotLine {
                label: label.into(),
                values: (0..x.len()).map(length).collect(),
                steps: true,
            });
            if of.len() == 1 {
                let of_axis = |(axis, v): (&str, &[f64])| PlotLine {
                    label: format!("{label} {axis}"),
                    values: v.to_vec(),
                    steps: true,
                };
                lines.extend([("x", x), ("y", y), ("z", z)].into_iter().map(of_axis));
            }
        }
        let unit = self.unit(&format!("{} force x", of.first()?)).to_owned();
        let note = "Forces on the model, means since the previous row.";
        Some(Plot { title: "Forces of rigid walls".into(), unit, note: note.into(), lines })
    }

    fn step(&self) -> Option<Plot> {
        let lines = vec![self.line("dt", "dt")?];
        let unit = self.unit("dt").to_owned();
        Some(Plot { title: "Time step".into(), unit, note: String::new(), lines })
    }

    /// Plots the CPU time of the critical path over the mean of all workers, since the row before.
    fn imbalance(&self, workers: Option<u64>) -> Option<Plot> {
        let (all, critical) =
            (self.values("cpu of all workers")?, self.values("cpu of the critical path")?);
        let workers = workers? as f64;
        let rise = |v: &[f64], i: usize| if i == 0 { v[0] } else { v[i] - v[i - 1] };
        let of_row = |i: usize| {
            let total = rise(all, i);
            if total > 0.0 { workers * rise(critical, i) / total } else { f64::NAN }
        };
        let values = (0..all.len()).map(of_row).collect();
        let lines = vec![PlotLine { label: "critical path over mean".into(), values, steps: true }];
        let note = "Largest CPU time without contact plus the largest of contact, in each cycle, \
                    over the mean of all workers, since the previous row. 1 is perfect balance.";
        Some(Plot {
            title: "Imbalance of workers".into(),
            unit: String::new(),
            note: note.into(),
            lines,
        })
    }

    fn redecompositions(&self) -> Option<Plot> {
        let line =
            |name: &str, label: &str| Some(PlotLine { steps: true, ..self.line(name, label)? });
        let mut lines = vec![
            line("low redecompositions", "low (new boxes)")?,
            line("high redecompositions", "high (membership)")?,
        ];
        let erosions = line("surface updates", "surface updates");
        lines.extend(erosions.filter(|l| l.values.iter().any(|v| *v != 0.0)));
        let note = "Total since the start.";
        Some(Plot {
            title: "Redecompositions".into(),
            unit: String::new(),
            note: note.into(),
            lines,
        })
    }

    /// Plots the elements by class, over all workers; none if a single worker has all elements.
    fn classes(&self) -> Option<Plot> {
        let line = |class: &str| {
            Some(PlotLine { steps: true, ..self.line(&format!("{class} elements"), class)? })
        };
        let lines = vec![line("interior")?, line("interface")?, line("exterior")?];
        let several = lines[1].values.iter().any(|v| *v > 0.0);
        let note = "Own elements in the internal boxes and in the buffers, and ghosts; summed over \
                    workers.";
        several.then(|| Plot {
            title: "Elements by class".into(),
            unit: String::new(),
            note: note.into(),
            lines,
        })
    }

    fn contact(&self) -> Vec<Plot> {
        let of = |name: &str, label: &str, title: &str, unit: &str| {
            let line = self.line(name, label).filter(|l| l.values.iter().any(|v| *v != 0.0))?;
            Some(Plot {
                title: title.into(),
                unit: unit.into(),
                note: String::new(),
                lines: vec![line],
            })
        };
        let depth = "fraction of thickness";
        let all = [
            of("pairs", "pairs", "Contact pairs", ""),
            of("penetration", "largest", "Penetration", depth),
        ];
        all.into_iter().flatten().collect()
    }
}

impl PlotColumn {
    fn from_header(header: &str) -> Self {
        let [name, unit] = named(header);
        Self { name, unit, values: Vec::new() }
    }
}

/// Returns name and unit of a column called `name [unit]`. The unit is empty if there is none.
pub fn named(header: &str) -> [String; 2] {
    match header.rsplit_once(" [") {
        Some((name, rest)) => [name.into(), rest.strip_suffix(']').unwrap_or(rest).into()],
        None => [header.into(), String::new()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(text: &str) -> Result<ColumnFile, String> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("history.csv");
        std::fs::write(&path, text).unwrap();
        ColumnFile::read(&path)
    }

    #[test]
    fn plots_follow_from_the_columns() {
        let text = "time [ms],dt [ms],kinetic [J],internal [J],hourglass [J],contact work [J],\
                    friction work [J],wall work [J],external work [J],energy error [-],\
                    \"a, b mean force x [kN]\",\
                    \"a, b mean force y [kN]\",\"a, b mean force z [kN]\",cpu of all workers [s],\
                    cpu of the critical path [s],low redecompositions,high redecompositions\n\
                    0,1e-3,100,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n\
                    1,NaN,70,25,1,-1,-1,-2,0,-0.01,3,0,-4,2,1.5,0,1\n";
        let plots = history(text).unwrap().plots(Some(2));
        let titles: Vec<&str> = plots.plots.iter().map(|p| p.title.as_str()).collect();
        let wanted = [
            "Energies",
            "Energy balance",
            "Forces of rigid walls",
            "Time step",
            "Imbalance of workers",
            "Redecompositions",
        ];
        assert_eq!(titles, wanted);
        assert_eq!((plots.unit.as_str(), &plots.time[..]), ("ms", &[0.0, 1.0][..]));
        let line = |plot: usize, label: &str| {
            let found = plots.plots[plot].lines.iter().find(|l| l.label == label);
            found.unwrap_or_else(|| panic!("{label}: {:?}", plots.plots[plot])).values.clone()
        };
        assert_eq!(line(0, TOTAL), [100.0, 70.0 + 25.0 + 1.0 + 1.0 + 2.0]);
        assert!(
            plots.plots[0].lines.iter().all(|l| l.label != "external work"),
            "zero in all rows"
        );
        assert_eq!((line(2, "a, b"), plots.plots[2].unit.as_str()), (vec![0.0, 5.0], "kN"));
        assert_eq!(line(2, "a, b z"), [0.0, -4.0]);
        assert_eq!(line(4, "critical path over mean")[1], 1.5);
        assert!(line(4, "critical path over mean")[0].is_nan() && line(3, "dt")[1].is_nan());
        let json = serde_json::to_string(&plots).unwrap();
        assert!(json.contains(r#""values":[0.001,null]"#), "{json}");
        assert_eq!(
            history(text).unwrap().plots(None).plots.len(),
            5,
            "no imbalance without the number of workers"
        );
    }

    #[test]
    fn a_history_without_rows_or_torn_is_no_trouble() {
        let empty = history("time [ms],dt [ms],kinetic [J]\n").unwrap();
        assert_eq!((empty.rows, empty.plots(None).time.len()), (0, 0));
        assert!(history("").unwrap_err().ends_with("history.csv: has no time column"));
        let torn = history("time [ms],dt [ms]\n1,2\n2").unwrap();
        assert_eq!(torn.plots(None).time, [1.0]);
        let damage = torn.damage.unwrap();
        assert!(damage.ends_with("history.csv: line 3 has 1 fields, the header 2"), "{damage}");
    }

    #[test]
    fn long_histories_are_thinned_and_keep_their_end() {
        let rows: String = (0..10_000).map(|i| format!("{i}\n")).collect();
        let long = history(&format!("time [s]\n{rows}")).unwrap();
        let time = long.plots(None).time;
        assert_eq!((long.rows, time[0], time[time.len() - 1]), (10_000, 0.0, 9999.0));
        assert!(long.shown() <= MOST_ROWS + 1 && long.shown() > MOST_ROWS / 2, "{}", long.shown());
    }
}
