//! The compiled part of the Python package `crumple`, the module `crumple._native`. Its functions
//! take and return plain data; the Python files of the package give them their form.

use crumple::analysis::check::{self, Described};
use crumple::cli::{JobOptions, RunArgs};
use crumple::input::{init, job, reference};
use crumple::results::field_file::{self, PieceArrays};
use crumple::results::fields;
use crumple::run::in_process::{self, InProcessError};
use crumple::run::launch::StartProblems;
use crumple::run::progress::{FeedContent, ProgressFeed, RunState};
use crumple::run::service::signals::{Manner, StopFlag};
use crumple_worker::vtu::POINT_ARRAYS;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};
use pythonize::{depythonize, pythonize};
use serde::Deserialize;
use std::path::PathBuf;
use std::time::Duration;

/// Interval at which a run looks for signals and calls the function for progress.
const LOOK_EVERY: Duration = Duration::from_millis(100);

#[pymodule(name = "_native")]
mod native {
    #[pymodule_export]
    use super::{
        check_job, check_keys, examples, from_toml, read_step, run, schema, steps, to_toml,
    };
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let commit = env!("CRUMPLE_COMMIT");
        if !commit.is_empty() {
            crumple::features::COMMIT.get_or_init(|| commit);
        }
        module.add("VERSION", env!("CARGO_PKG_VERSION"))?;
        let names: Vec<&str> = super::POINT_ARRAYS.iter().map(|array| array.name).collect();
        module.add("POINT_ARRAYS", names)
    }
}

/// Returns the TOML text of a table.
#[pyfunction]
fn to_toml(table: &Bound<'_, PyAny>) -> PyResult<String> {
    let table: toml::Table = depythonize(table)?;
    toml::to_string(&table).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Returns the table of a TOML text.
#[pyfunction]
fn from_toml<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    let table: toml::Table =
        toml::from_str(text).map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(pythonize(py, &table)?)
}

/// Returns name and text of each example job that needs no file.
#[pyfunction]
fn examples() -> Vec<(&'static str, &'static str)> {
    let alone = init::EXAMPLES.iter().filter(|example| example.mesh.is_none());
    alone.map(|example| (example.name, example.job)).collect()
}

/// Returns the JSON Schema of jobs as text.
#[pyfunction]
fn schema() -> String {
    reference::schema().to_string()
}

/// Returns path, message and remedy of each problem of the keys of a job.
#[pyfunction]
fn check_keys(py: Python<'_>, text: &str) -> Vec<(String, String, String)> {
    let problems = py.detach(|| job::check_keys(text));
    problems.into_iter().map(|problem| (problem.path, problem.message, problem.help)).collect()
}

/// Checks a job as `crumple check` does: the file at `path`, or `text` in place of it. Returns the
/// findings.
#[pyfunction]
fn check_job<'py>(
    py: Python<'py>,
    path: PathBuf,
    text: Option<String>,
    set: Vec<String>,
    workers: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let findings = py.detach(|| {
        let model = match text {
            None => job::read(&path, &set),
            Some(text) => job::read_text(path, text, &set),
        };
        check::findings(&model.and_then(|model| Described::new(model, workers)), usize::MAX)
    });
    Ok(pythonize(py, &findings)?)
}

/// Options of a run.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RunOptions {
    job: Option<PathBuf>,
    resume: Option<PathBuf>,
    out: Option<PathBuf>,
    workers: Option<usize>,
    set: Vec<String>,
    overwrite: bool,
    report: bool,
}

impl From<RunOptions> for RunArgs {
    fn from(options: RunOptions) -> Self {
        let RunOptions { job, resume, out, workers, set, overwrite, report } = options;
        let (options, no_report) = (JobOptions::new(workers, set), !report);
        Self { job, options, resume, out, overwrite, no_report, quiet: true, ..Self::default() }
    }
}

/// Runs a job with the options of [`RunOptions`] and returns its exit code and its folder. Calls
/// `look` with cycle, time, end, step size, energy error, pairs, imbalance and new messages several
/// times a second. After an exception of `look`, or a signal that Python turns into one, the run
/// stops with a checkpoint, and the exception goes on.
#[pyfunction]
fn run(
    py: Python<'_>,
    options: &Bound<'_, PyAny>,
    look: &Bound<'_, PyAny>,
) -> PyResult<(u8, PathBuf)> {
    let args = RunArgs::from(depythonize::<RunOptions>(options)?);
    let out = args.resume.clone().unwrap_or_else(|| args.out_dir());
    let (stop, feed) = (StopFlag::default(), ProgressFeed::default());
    // Before the first call of `look`: it may raise, and the flag must not end this process.
    stop.set_manner(Manner::Patient);
    let caller = std::thread::current();
    let body = {
        let (stop, feed) = (stop.clone(), feed.clone());
        move || {
            let ended = in_process::run(&args, &stop, &feed);
            caller.unpark();
            ended
        }
    };
    let master = std::thread::Builder::new().name("master".into()).spawn(body)?;
    let mut raised = None;
    loop {
        // Asked first: a last call shows the end.
        let is_finished = master.is_finished();
        let looked = py.check_signals().and_then(|()| show(look, &feed.take()));
        if let Err(error) = looked {
            raised.get_or_insert(error);
            stop.raise();
        }
        if is_finished {
            break;
        }
        py.detach(|| std::thread::park_timeout(LOOK_EVERY));
    }
    let ended = master.join().map_err(|_| {
        PyRuntimeError::new_err("the run has ended by a defect of the program; please report it")
    })?;
    match (raised, ended) {
        (Some(error), _) => Err(error),
        (None, Ok(summary)) => Ok((summary.exit_code(), out)),
        (None, Err(error)) => Err(exception(py, &error)),
    }
}

/// Calls the function of Python for progress.
fn show(look: &Bound<'_, PyAny>, content: &FeedContent) -> PyResult<()> {
    let RunState { cycle, time, dt, error, pairs, imbalance } = content.state;
    let numbers = (cycle, time, content.end_time, dt, error, pairs, imbalance);
    look.call1((numbers, &content.messages))?;
    Ok(())
}

/// Returns the exception for a run without a summary.
fn exception(py: Python<'_>, error: &InProcessError) -> PyErr {
    let raise = || -> PyResult<Bound<'_, PyAny>> {
        let errors = py.import("crumple.errors")?;
        match error {
            InProcessError::Start(StartProblems::Job(report)) => {
                let findings = check::findings(&Err(report.clone()), usize::MAX);
                errors.getattr("JobError")?.call1((pythonize(py, &findings)?,))
            }
            other => errors.getattr("RunError")?.call1((other.to_string(),)),
        }
    };
    raise().map_or_else(|error| error, PyErr::from_value)
}

/// Returns time and file of each output step of the run in a folder.
#[pyfunction]
fn steps(folder: PathBuf) -> PyResult<Vec<(f64, PathBuf)>> {
    let collection = folder.join(fields::DIR).join(fields::COLLECTION);
    let steps = field_file::steps(&collection).map_err(PyValueError::new_err)?;
    Ok(steps.into_iter().map(|step| (step.time, step.file)).collect())
}

/// Returns the arrays of each piece of an output step: by name, the type of VTK and the bytes.
#[pyfunction]
fn read_step<'py>(py: Python<'py>, file: PathBuf) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let read = || -> Result<Vec<PieceArrays>, String> {
        field_file::pieces(&file)?.iter().map(|piece| PieceArrays::read(piece)).collect()
    };
    let pieces = py.detach(read).map_err(PyValueError::new_err)?;
    let as_dict = |piece: &PieceArrays| {
        let arrays = PyDict::new(py);
        for (name, kind, bytes) in piece.stored() {
            arrays.set_item(name, (kind.vtk_name(), PyByteArray::new(py, bytes)))?;
        }
        Ok(arrays)
    };
    pieces.iter().map(as_dict).collect()
}
