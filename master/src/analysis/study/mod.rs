//! `crumple study`: runs one job over a grid of settings, and shows cost and error as a table and
//! as charts.
//!
//! - [`spec`]: the study file and its errors
//! - [`grid`]: the points of the grid
//! - [`runs`]: each point as a separate process; finished points are not repeated
//! - [`results`]: errors, costs, the Pareto front, `results.csv`
//! - [`chart`]: the charts

pub mod chart;
pub mod grid;
pub mod results;
pub mod runs;
pub mod spec;

use crate::cli::StudyArgs;
use crate::run::service::{Service, signals::Manner};
use crate::stdout::say;
use grid::StudyPlan;
use results::PointTable;
use runs::Ending;
use spec::Study;
use std::path::PathBuf;

/// Exit codes as in `docs/reference/exit-codes.md`.
const COMPLETED: u8 = 0;
const BAD_INPUT: u8 = 2;
const STOPPED: u8 = 130;

/// Runs a study and returns the exit code.
pub fn run(args: &StudyArgs) -> u8 {
    match study(args) {
        Ok(code) => code,
        Err(why) => {
            eprintln!("error: {why}");
            BAD_INPUT
        }
    }
}

fn study(args: &StudyArgs) -> Result<u8, String> {
    let study = Study::read(&args.study)?;
    let plan = StudyPlan::new(&study)?;
    let out = args.out.clone().unwrap_or_else(|| {
        let name = args.study.file_stem().unwrap_or("study".as_ref());
        PathBuf::from("out").join("studies").join(name)
    });
    if args.fresh {
        runs::forget(&plan, &out)?;
    }
    say!(
        "{}: {} points, {} of them to run",
        study.title,
        plan.points.len(),
        runs::open(&plan, &out)
    );
    if runs::run_all(&study, &plan, &out, args.jobs, Service::start(Manner::Orderly).stop())?
        == Ending::Stopped
    {
        eprintln!("stopped: repeat the command to continue");
        return Ok(STOPPED);
    }
    let table = PointTable::collect(&study, &plan, &out)?;
    let csv = out.join("results.csv");
    table.write(&csv).map_err(|error| format!("{}: {error}", csv.display()))?;
    say!("{}", csv.display());
    for path in chart::draw_all(&study, &table, &out)? {
        say!("{}", path.display());
    }
    for row in table.rows.iter().filter(|row| !row.ended_well()) {
        say!("{}: exit code {}: {}", row.label, row.outcome.code, row.outcome.reason);
    }
    Ok(COMPLETED)
}
