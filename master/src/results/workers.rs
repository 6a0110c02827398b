//! `workers.csv`: what the master knows of each worker, one row per worker and report.
//!
//! Workers report every 10 cycles. In a run of more than `MOST_ROWS` reports of a worker, as
//! many consecutive reports make one row as keep the file below that number.

use crate::input::job::Model;
use crate::results::history::Labels;
use crate::results::table::{CsvTable, Tables, Unwritten};
use crumple_proto::report::{PHASES, Phase, StepReport};
use std::path::PathBuf;

/// Name of the file.
pub const FILE: &str = "workers.csv";
/// Largest number of rows of a worker, about.
const MOST_ROWS: f64 = 2000.0;
/// Number of phases of a cycle; the time of renewals is in a column of its own.
const TIMED: usize = Phase::Renewal as usize;

/// The file, and the reports that are not in it yet.
pub struct WorkerFile {
    file: CsvTable,
    /// Set when the file was removed and made again; all rows until then are lost.
    pub lost: Option<PathBuf>,
    waiting: Vec<Option<StepReport>>,
    end_time: f64,
}

/// Columns before those of the phases; `length` and `time` are names of units.
fn columns(length: &str, time: &str) -> Vec<String> {
    let mut header = vec![
        "worker".to_string(),
        "cycle".into(),
        format!("time [{time}]"),
        "cycles".into(),
        format!("displacement [{length}]"),
        format!("margin [{length}]"),
        "share of margin".into(),
        "load [s]".into(),
        "imbalance".into(),
    ];
    let counts = [
        "interior elements",
        "interface elements",
        "exterior elements",
        "exterior nodes",
        "slaves",
        "candidates",
        "pairs",
        "messages",
        "bytes",
        "surface updates",
    ];
    header.extend(counts.map(String::from));
    header.extend(PHASES[..TIMED].iter().map(|phase| format!("cpu {phase} [s]")));
    header.push("cpu renewal [s]".into());
    header
}

impl WorkerFile {
    /// Creates the file, or opens that of the run that continues.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn new(tables: Tables<'_>, workers: usize, model: &Model) -> Result<Self, Unwritten> {
        let labels = Labels::from_units(&model.job.units);
        let file = tables.open(FILE, columns(&labels.length, &labels.time))?;
        Ok(Self {
            file,
            lost: None,
            waiting: vec![None; workers],
            end_time: model.settings.end_time,
        })
    }

    /// Adds a report. `imbalance` is that since the master last judged it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, worker: usize, report: &StepReport, imbalance: f64) -> csv::Result<()> {
        match &mut self.waiting[worker] {
            Some(waiting) => waiting.append(report.clone()),
            empty => *empty = Some(report.clone()),
        }
        let cycles = self.waiting[worker].as_ref().map_or(0, |r| r.cpu.len()) as f64;
        let expected = if report.dt > 0.0 { self.end_time / report.dt } else { 0.0 };
        if cycles >= (expected / MOST_ROWS).floor() {
            self.write(worker, imbalance)
        } else {
            Ok(())
        }
    }

    /// Writes the reports that are not in the file yet: at the end, and for a checkpoint.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(&mut self, imbalance: f64) -> csv::Result<()> {
        (0..self.waiting.len()).try_for_each(|worker| self.write(worker, imbalance))?;
        Ok(self.file.flush()?)
    }

    fn write(&mut self, worker: usize, imbalance: f64) -> csv::Result<()> {
        let Some(r) = self.waiting[worker].take() else { return Ok(()) };
        if let Some(path) = self.file.check()? {
            self.lost = Some(path);
        }
        let number = |a: f64| format!("{a:.6e}");
        let cycles = r.cpu.len();
        let load = r.cpu.iter().map(|&s| f64::from(s)).sum::<f64>() / cycles.max(1) as f64;
        let mut record = vec![worker.to_string(), r.cycle.to_string(), number(r.time)];
        record.push(cycles.to_string());
        let d = r.displacement;
        record.extend([d.moved, d.margin, d.share, load, imbalance].map(number));
        let counts = [
            r.elements - r.interface,
            r.interface,
            r.exterior,
            r.exterior_nodes,
            r.slaves,
            r.candidates,
            r.pairs,
            r.messages,
            r.bytes,
            r.erosions,
        ];
        record.extend(counts.map(|n| n.to_string()));
        record.extend(r.phase_cpu[..TIMED].iter().chain([&r.renewal_s]).map(|&s| number(s)));
        self.file.write_record(&record)
    }
}
