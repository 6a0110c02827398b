//! The begin of a run: its folder, its tables, and the state of a checkpoint.

use super::steer::Steering;
use super::view::Viewing;
use super::{Control, Origin, Results, RunError};
use crate::input::job::Model;
use crate::results::fields::{self, FieldSeries};
use crate::results::history::{Course, History};
use crate::results::provenance::{self, ProgramStart};
use crate::results::summary::{MeshOutline, RestartSummary};
use crate::results::table::Tables;
use crate::results::trace::TraceFile;
use crate::results::workers::WorkerFile;
use crate::run::balance::{Balance, BalanceLimits};
use crate::run::checkpoint::find::{Resumption, tidy};
use crate::run::checkpoint::manifest::Stamp;
use crate::run::checkpoint::{Checkpoints, MasterState};
use crate::run::progress::{Audience, ProgressDisplay};
use crate::run::service::Desk;
use crumple_proto::boxes::CutTree;
use crumple_proto::checkpoint::Captured;
use crumple_proto::transport::Transport;
use crumple_worker::vtu::OptionalArrays;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

impl<'a> Control<'a> {
    /// Prepares the output folder and continues with the state of the checkpoint, if any.
    pub(super) fn new(
        model: &'a mut Model,
        comm: &'a mut dyn Transport,
        Results { out, trace }: Results<'_>,
        (Origin { stamp, start, mut from }, tree): (Origin, CutTree),
        (audience, desk): (Audience, Option<Desk>),
    ) -> Result<Self, RunError> {
        let workers = comm.size() - 1;
        std::fs::create_dir_all(out).map_err(output_error(out))?;
        let start = ProgramStart { workers, transport: comm.name().into(), ..start };
        provenance::record(out, stamp.job.clone(), start)
            .map_err(output_error(&out.join(provenance::FILE)))?;
        let mut checkpoints = new_checkpoints(model, out, workers, stamp);
        let arrays = OptionalArrays::of(&model.settings);
        let mut series = FieldSeries::new(&out.join(fields::DIR), arrays);
        let known = match &mut from {
            Some((from, _)) => Some(restore_files(from, out, &mut checkpoints, &mut series)?),
            None => {
                remove_old_files(out, &checkpoints, &series)?;
                None
            }
        };
        let (history, of_workers) = open_tables(model, out, workers, known.as_ref())?;
        let trace = trace.map(|path| new_trace(path, workers)).transpose()?;
        let balance = new_balance(model, workers, known.as_ref());
        let known = known.unwrap_or_default();
        let mut restarts = known.restarts;
        let from = from.map(|(from, changes)| {
            let Captured { cycle, time, .. } = from.manifest.captured;
            let transport = comm.name().into();
            restarts.push(RestartSummary { cycle, time, workers, transport, changes });
            from
        });
        Ok(Self {
            began: Instant::now(),
            tree,
            balance,
            series,
            progress: ProgressDisplay::new(model.settings.end_time, audience),
            out: out.to_owned(),
            orders: 0,
            stop_ordered: false,
            ready: Vec::new(),
            ready_since: None,
            pieces: BTreeMap::new(),
            trouble: None,
            warnings: known.warnings,
            checkpoints,
            from,
            restarts,
            wall_before: known.wall_s,
            steering: Steering::new(desk, known.steering),
            viewing: Viewing::new(out),
            closings: vec![None; workers],
            trace,
            states: Vec::new(),
            outline: MeshOutline::from_mesh(&model.mesh),
            model,
            comm,
            workers,
            history,
            of_workers,
        })
    }
}

fn output_error(path: &Path) -> impl FnOnce(std::io::Error) -> RunError {
    let path = path.to_owned();
    move |error| RunError::Output { path, error }
}

fn new_checkpoints(model: &Model, out: &Path, workers: usize, stamp: Stamp) -> Checkpoints {
    let deleted = &model.job.restart.delete;
    let elements = model.mesh.elements.iter().filter(|e| !deleted.contains(&e.part)).count();
    let mut checkpoints = Checkpoints::new(out, &model.job.checkpoint, workers, elements);
    checkpoints.set_stamp(stamp);
    checkpoints
}

/// Takes the output folder back to the state of the checkpoint. Returns the state of the master.
fn restore_files(
    from: &mut Resumption,
    out: &Path,
    checkpoints: &mut Checkpoints,
    series: &mut FieldSeries,
) -> Result<MasterState, RunError> {
    from.begin_lost_histories();
    from.removed = tidy(checkpoints.dir(), Some(&from.folder));
    checkpoints.newest = Some((from.manifest.captured.cycle, from.manifest.captured.time));
    let folder = series.dir().to_owned();
    series.restore(&from.master.steps).map_err(output_error(&folder))?;
    remove_file(&out.join("summary.json"))?; // of the run before
    Ok(from.master.clone())
}

/// Removes the summary, the checkpoints and the field files of an earlier run.
fn remove_old_files(
    out: &Path,
    checkpoints: &Checkpoints,
    series: &FieldSeries,
) -> Result<(), RunError> {
    remove_file(&out.join("summary.json"))?;
    tidy(checkpoints.dir(), None);
    let folder = series.dir();
    if folder.exists() {
        std::fs::remove_dir_all(folder).map_err(output_error(folder))?;
    }
    Ok(())
}

/// Opens the histories and `workers.csv`, at the end of the rows that a checkpoint knows.
fn open_tables(
    model: &Model,
    out: &Path,
    workers: usize,
    known: Option<&MasterState>,
) -> Result<(History, WorkerFile), RunError> {
    let lengths = known.map(|known| &known.lengths);
    let course = known.map_or_else(Course::default, |known| known.course.clone());
    let unwritten = |(path, error): (PathBuf, std::io::Error)| RunError::Output { path, error };
    let history = History::new(Tables { dir: out, lengths }, workers, model, course);
    let history = history.map_err(unwritten)?;
    let of_workers = WorkerFile::new(Tables { dir: out, lengths }, workers, model);
    Ok((history, of_workers.map_err(unwritten)?))
}

fn new_trace(path: &Path, workers: usize) -> Result<TraceFile, RunError> {
    TraceFile::new(path, workers).map_err(|error| RunError::Trace { path: path.to_owned(), error })
}

fn new_balance(model: &Model, workers: usize, known: Option<&MasterState>) -> Balance {
    let all = &model.decomposition;
    let limits = BalanceLimits {
        imbalance: all.imbalance,
        low_every_at_least: all.low_every_at_least,
        forced: all.force_every > 0,
        migrates: !model.settings.has_second_decomposition(),
    };
    let mut balance = Balance::new(workers, limits);
    if let Some(known) = known {
        balance.restore(&known.accounts);
    }
    balance
}

/// Removes a file if it exists.
fn remove_file(path: &Path) -> Result<(), RunError> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(RunError::Output { path: path.to_owned(), error })
        }
        _ => Ok(()),
    }
}
