//! Charts of a study, each as SVG and as PNG.
//!
//! - `canvas`: shapes on a page, and the two kinds of files
//! - `axis`: scales and ticks
//! - `frame`: title, axes and legend, common to all charts
//! - `pareto`, `map`, `lines`: the kinds of charts; `series`: curves without a study

mod axis;
mod canvas;
mod frame;
mod lines;
mod map;
mod pareto;
pub mod series;

use super::results::{PointResult, PointTable};
use super::spec::{Chart, ChartKind, Measure, Study};
use canvas::Sheet;
use std::path::{Path, PathBuf};

/// Draws all charts of a study into a folder, and returns the files.
///
/// # Errors
/// A chart has no data, or a file cannot be written.
pub fn draw_all(study: &Study, table: &PointTable, out: &Path) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    for chart in &study.chart {
        let view = ChartView { study, table, chart };
        let sheets: Vec<(String, Sheet)> = match chart.kind {
            ChartKind::Pareto => vec![(chart.file.clone(), pareto::draw(&view)?)],
            ChartKind::Lines => vec![(chart.file.clone(), lines::draw(&view)?)],
            ChartKind::Map => {
                let shown: Vec<usize> =
                    (0..study.series.len()).filter(|&s| view.shows_series(s)).collect();
                let of =
                    |&s: &usize| Ok((map_name(study, chart, s, shown.len()), map::draw(&view, s)?));
                shown.iter().map(of).collect::<Result<_, String>>()?
            }
        };
        for (name, sheet) in sheets {
            files.extend(sheet.write(&out.join(name))?);
        }
    }
    Ok(files)
}

/// Returns the file name of a map, with the name of its series if there are several.
fn map_name(study: &Study, chart: &Chart, series: usize, shown: usize) -> String {
    if shown == 1 {
        return chart.file.clone();
    }
    let name = study.series[series].name.to_lowercase();
    let words: Vec<&str> =
        name.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    format!("{}-{}", chart.file, words.join("-"))
}

/// A chart and its data.
struct ChartView<'a> {
    study: &'a Study,
    table: &'a PointTable,
    chart: &'a Chart,
}

impl ChartView<'_> {
    fn head(&self) -> &str {
        self.chart.title.as_deref().unwrap_or(&self.study.title)
    }

    /// Returns the index of the measure, 0 if the chart names none.
    fn measure_index(&self) -> usize {
        let named = |m: &Measure| self.chart.measure.as_ref().is_none_or(|name| *name == m.name);
        self.study.measure.iter().position(named).unwrap_or(0)
    }

    fn measure(&self) -> &Measure {
        &self.study.measure[self.measure_index()]
    }

    fn is_log(&self, axis: &str) -> bool {
        self.chart.log.iter().any(|l| l == axis)
    }

    fn shows_series(&self, series: usize) -> bool {
        self.chart
            .series
            .as_ref()
            .is_none_or(|names| names.contains(&self.study.series[series].name))
    }

    fn rows(&self) -> impl Iterator<Item = (usize, &PointResult)> {
        self.table.rows.iter().enumerate().filter(|(_, r)| self.shows_series(r.series))
    }

    /// Returns the value of a row in maps and lines.
    fn value(&self, row: &PointResult) -> f64 {
        let m = self.measure_index();
        if self.chart.error { row.errors[m] } else { row.values[m] }
    }

    /// Returns the axis title of the measure, with its unit.
    fn measure_title(&self, error: bool) -> String {
        let m = self.measure();
        match (error, m.relative) {
            (true, true) => format!("relative error of {} [-]", m.name),
            (true, false) => format!("error of {} [{}]", m.name, dash(&m.unit)),
            (false, _) => format!("{} [{}]", m.name, dash(&m.unit)),
        }
    }
}

/// Returns a unit, or the sign for none.
fn dash(unit: &str) -> &str {
    if unit.is_empty() { "-" } else { unit }
}
