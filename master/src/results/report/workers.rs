//! Plots of `workers.csv`: displacement and load of each worker, with the limits at which the
//! master orders a redecomposition.

use super::plots::{Plot, PlotLine};
use crate::results::workers::FILE;
use std::collections::BTreeMap;
use std::path::Path;

/// Maximum number of workers in a plot; those with the largest values are shown.
const MOST_LINES: usize = 6;

/// Limits at which the master orders a redecomposition, from the summary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RedecompositionLimits {
    /// Share of the margin: *high*.
    pub margin: f64,
    /// Imbalance: *low*.
    pub imbalance: f64,
}

/// Largest values of a worker up to each history row since the row before; NaN without a report.
type WorkerPeaks = BTreeMap<usize, Vec<f64>>;

/// Returns the plots over the times of the history, none for a single worker or without the file.
pub fn plots(
    dir: &Path,
    time: &[f64],
    limits: Option<RedecompositionLimits>,
    problems: &mut Vec<String>,
) -> Vec<Plot> {
    let path = dir.join(FILE);
    if !path.exists() || time.is_empty() {
        return Vec::new();
    }
    match read(&path, time) {
        Ok(read) if read.share.len() > 1 => plots_of(read, time.len(), limits),
        Ok(_) => Vec::new(),
        Err(why) => {
            problems.push(format!("{}: {why}", path.display()));
            Vec::new()
        }
    }
}

/// Columns of the file over the times of the history.
#[derive(Default)]
struct WorkerColumns {
    share: WorkerPeaks,
    load: WorkerPeaks,
    imbalance: Vec<f64>,
}

fn read(path: &Path, time: &[f64]) -> Result<WorkerColumns, String> {
    let mut reader =
        csv::ReaderBuilder::new().flexible(true).from_path(path).map_err(|e| e.to_string())?;
    let header = reader.headers().map_err(|e| e.to_string())?.clone();
    let column = |name: &str| {
        let found = header.iter().position(|h| h == name || h.starts_with(&format!("{name} [")));
        found.ok_or(format!("has no column `{name}`"))
    };
    let [worker, at, share, load, imbalance] = [
        column("worker")?,
        column("time")?,
        column("share of margin")?,
        column("load")?,
        column("imbalance")?,
    ];
    let mut all =
        WorkerColumns { imbalance: vec![f64::NAN; time.len()], ..WorkerColumns::default() };
    for record in reader.records() {
        let record = record.map_err(|e| e.to_string())?;
        let number = |at: usize| record.get(at).and_then(|f| f.parse::<f64>().ok());
        let (Some(worker), Some(at)) = (number(worker), number(at)) else { continue };
        let row = time.partition_point(|&t| t < at).min(time.len() - 1);
        let raise = |values: &mut Vec<f64>, value: Option<f64>| {
            values.resize(time.len(), f64::NAN);
            values[row] = values[row].max(value.unwrap_or(f64::NAN));
        };
        raise(all.share.entry(worker as usize).or_default(), number(share));
        raise(all.load.entry(worker as usize).or_default(), number(load));
        raise(&mut all.imbalance, number(imbalance));
    }
    let columns = all.share.values_mut().chain(all.load.values_mut());
    columns.chain([&mut all.imbalance]).for_each(|values| carry_on(values));
    Ok(all)
}

/// Fills gaps with the value before.
fn carry_on(values: &mut [f64]) {
    for i in 1..values.len() {
        if values[i].is_nan() {
            values[i] = values[i - 1];
        }
    }
}

fn line(label: String, values: Vec<f64>) -> PlotLine {
    PlotLine { label, values, steps: true }
}

/// Returns the lines of the workers with the largest values.
fn largest(columns: WorkerPeaks) -> Vec<PlotLine> {
    let top = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let mut all: Vec<_> = columns.into_iter().collect();
    all.sort_by(|a, b| top(&b.1).total_cmp(&top(&a.1)));
    all.truncate(MOST_LINES);
    all.sort_by_key(|a| a.0);
    all.into_iter().map(|(worker, values)| line(format!("worker {worker}"), values)).collect()
}

fn plots_of(read: WorkerColumns, rows: usize, limits: Option<RedecompositionLimits>) -> Vec<Plot> {
    let WorkerColumns { share, mut load, imbalance } = read;
    for row in 0..rows {
        let mean = load.values().map(|v| v[row]).sum::<f64>() / load.len() as f64;
        load.values_mut().for_each(|v| v[row] /= mean);
    }
    let mut displacements = largest(share);
    let mut loads = vec![line("imbalance".into(), imbalance)];
    loads.extend(largest(load));
    if let Some(limits) = limits {
        displacements.push(line("limit for high".into(), vec![limits.margin; rows]));
        loads.push(line("limit for low".into(), vec![limits.imbalance; rows]));
    }
    let plot = |title: &str, unit: &str, note: &str, lines| Plot {
        title: title.into(),
        unit: unit.into(),
        note: note.into(),
        lines,
    };
    vec![
        plot(
            "Displacement of workers",
            "of the margin",
            "Largest relative motion of a worker and another since the last redecomposition, as a \
             share of what the ghosts allow. The limit is that for a high redecomposition.",
            displacements,
        ),
        plot(
            "Load of workers",
            "of the mean",
            "CPU time of a cycle over the mean of all workers; imbalance: the largest without \
             contact plus the largest of contact, since the master last judged it. The master \
             orders a low redecomposition above the limit, if it pays.",
            loads,
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_are_collected_by_the_rows_of_the_history() {
        let dir = tempfile::tempdir().unwrap();
        let text = "worker,time [ms],share of margin,load [s],imbalance\n\
                    0,0.5,0.1,1,1\n1,0.5,0.2,3,1\n0,0.9,0.6,1,1.5\n\
                    0,2.5,0.3,2,1.2\n1,2.5,0,2,1.2\n";
        std::fs::write(dir.path().join(FILE), text).unwrap();
        let limits = Some(RedecompositionLimits { margin: 0.7, imbalance: 1.1 });
        let mut problems = Vec::new();
        let made = plots(dir.path(), &[0.0, 1.0, 2.0, 3.0], limits, &mut problems);
        assert_eq!((made.len(), problems.len()), (2, 0), "{problems:?}");
        let values = |plot: usize, label: &str| {
            let found = made[plot].lines.iter().find(|l| l.label == label);
            found.unwrap_or_else(|| panic!("{label}: {:?}", made[plot])).values[1..].to_vec()
        };
        assert_eq!(values(0, "worker 0"), [0.6, 0.6, 0.3], "the largest; gaps keep the last");
        assert_eq!(values(0, "limit for high"), [0.7; 3]);
        assert_eq!(values(1, "worker 1"), [1.5, 1.5, 1.0], "of the mean");
        assert_eq!(values(1, "imbalance"), [1.5, 1.5, 1.2]);
        assert_eq!(values(1, "limit for low"), [1.1; 3]);
        std::fs::write(dir.path().join(FILE), "worker,time [ms]\n").unwrap();
        assert!(plots(dir.path(), &[0.0], None, &mut problems).is_empty());
        assert!(problems[0].ends_with("has no column `share of margin`"), "{problems:?}");
    }
}
