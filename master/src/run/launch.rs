//! `crumple run`: starts workers as threads or MPI processes, and sets the exit code of the
//! process.

use crate::cli::RunArgs;
use crate::features;
use crate::input::confine;
use crate::input::job::{self, Model, Report};
use crate::results::provenance::ProgramStart;
use crate::results::summary::{RunEnd, Summary};
use crate::results::{binout, d3plot, exodus, fields, report, requirements, steering, vtkhdf};
use crate::run::attempt::{self, Attempt};
use crate::run::checkpoint::manifest::{Manifest, Stamp};
use crate::run::checkpoint::{compare, find};
use crate::run::control::{self, Guidance, Origin, Results, RunError};
use crate::run::lock::Lock;
use crate::run::log::Logs;
#[cfg(feature = "mpi")]
use crate::run::log::RankLog;
use crate::run::progress::Audience;
use crate::run::service::Service;
#[cfg(feature = "mpi")]
use crate::run::service::signals;
use crate::run::service::signals::Manner;
use crate::run::supervise;
use crate::stdout::say;
use crumple_proto::disk;
#[cfg(feature = "mpi")]
use crumple_proto::exit_code::{COMPLETED, WORKER_LOST};
use crumple_proto::job::{Checkpoint, Output, Restart};
use crumple_proto::transport::{Transport, threads};
use std::path::{Path, PathBuf};

/// Returns true if an MPI launcher has started this process. Launchers set these
/// environment variables.
pub fn launched_by_mpi() -> bool {
    ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"]
        .iter()
        .any(|name| std::env::var_os(name).is_some())
}

/// Runs a job and returns the exit code.
pub fn run(args: &RunArgs) -> u8 {
    if let Some(folder) = &args.options.within
        && let Err(error) = confine::to(folder)
    {
        eprintln!("error: {}: {error}", folder.display());
        return Report::EXIT_CODE;
    }
    let attempt = match args.attempt.as_deref().map(Attempt::claim).transpose() {
        Ok(attempt) => attempt,
        Err(why) => {
            eprintln!("error: {why}");
            return Report::EXIT_CODE;
        }
    };
    let code = run_or_supervise(args, attempt.as_ref());
    if let Some(attempt) = attempt {
        attempt.end(code);
    }
    code
}

fn run_or_supervise(args: &RunArgs, attempt: Option<&Attempt>) -> u8 {
    if let Some(retries) = args.retries.filter(|_| !launched_by_mpi()) {
        return supervise::run(args, retries, attempt);
    }
    #[cfg(feature = "mpi")]
    if launched_by_mpi() {
        // SAFETY: this is the only thread; the calls below start others.
        unsafe { crumple_proto::transport::mpi::Mpi::configure() };
    }
    if launched_by_mpi() {
        run_under_mpi(args)
    } else {
        run_threads(args, &Service::start(Manner::AtOnce))
    }
}

/// Returns true if the launcher says that this process is a worker.
#[cfg(feature = "mpi")]
fn is_worker_rank() -> bool {
    let rank = |name| std::env::var(name).ok()?.parse::<usize>().ok();
    let names = ["OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK"];
    names.into_iter().find_map(rank).is_some_and(|rank| rank > 0)
}

/// A job that is ready to run.
pub(super) struct Ready {
    pub(super) model: Model,
    pub(super) workers: usize,
    pub(super) origin: Origin,
    pub(super) out: PathBuf,
    logs: Logs,
    _lock: Lock,
}

/// Problems that prevent a run.
#[derive(Debug, thiserror::Error)]
pub enum StartProblems {
    /// Problems of the job. The text ends with a line break.
    #[error("{0}")]
    Job(#[from] Report),
    /// Another reason, such as a folder of results that is in use.
    #[error("{0}")]
    Other(String),
}

impl From<String> for StartProblems {
    fn from(why: String) -> Self {
        Self::Other(why)
    }
}

/// Reads the job and, if the run continues, its checkpoint; locks the folder of results.
///
/// # Errors
/// All problems of the job, or the reason why the folder cannot be used.
pub(super) fn prepare(
    args: &RunArgs,
    workers: impl Fn(&Model) -> Result<usize, Report>,
) -> Result<Ready, StartProblems> {
    set_patience(args);
    match &args.resume {
        None => begin(args, workers),
        Some(dir) => go_on(args, workers, dir),
    }
}

/// As [`prepare`]; prints all problems.
fn prepare_or_print(
    args: &RunArgs,
    workers: impl Fn(&Model) -> Result<usize, Report>,
) -> Option<Ready> {
    let print = |problems| match problems {
        StartProblems::Job(report) => eprint!("{report}"),
        StartProblems::Other(why) => eprintln!("error: {why}"),
    };
    prepare(args, workers).map_err(print).ok()
}

/// Prepares a run from time 0.
fn begin(
    args: &RunArgs,
    workers: impl Fn(&Model) -> Result<usize, Report>,
) -> Result<Ready, StartProblems> {
    let (model, sets, workers) = read_job(args, workers, None)?;
    if model.job.restart != Restart::default() {
        let why = "`restart` changes a run that continues: give --resume too";
        return Err(why.to_string().into());
    }
    let start = program_start(&model, &sets, 0)?;
    let origin = Origin { stamp: compare::stamp(&model, sets), start, from: None };
    let out = args.out_dir();
    let lock = locked(args, &out)?;
    if !args.overwrite
        && let Some(why) = disk::watched(&out, || find::occupied(&out))
    {
        return Err(why.into());
    }
    let logs = Logs::new(&out, args.log.as_deref());
    Ok(Ready { model, workers, origin, out, logs, _lock: lock })
}

/// Prepares a run that continues from the newest checkpoint that is a state of its job.
fn go_on(
    args: &RunArgs,
    workers: impl Fn(&Model) -> Result<usize, Report>,
    dir: &Path,
) -> Result<Ready, StartProblems> {
    let out = find::run_folder(dir)?;
    // The folder is locked first: another run may be changing its checkpoints.
    let lock = locked(args, &out)?;
    let mut candidates = find::Candidates::new(dir)?;
    loop {
        let (folder, manifest) = candidates.next_candidate()?;
        let (mut model, sets, workers) = read_job(args, &workers, Some(&manifest.stamp))?;
        let start = program_start(&model, &sets, manifest.captured.cycle)?;
        let stamp = compare::stamp(&model, sets);
        compare::changes(&manifest.stamp, &stamp)
            .map_err(|why| format!("{}: {why}", folder.display()))?;
        let mut from = match candidates.resume_from(&folder, &manifest, &stamp) {
            Ok(from) => from,
            Err(why) => {
                candidates.refuse(why);
                continue;
            }
        };
        let changes = compare::adapt(&mut model, &stamp, &args.sets(), &mut from)
            .map_err(|why| format!("{}: {why}", folder.display()))?;
        if let Err(why) = from.validate(&model) {
            candidates.refuse(why);
            continue;
        }
        let logs = Logs::new(&out, args.log.as_deref());
        let origin = Origin { stamp, start, from: Some((from, changes)) };
        return Ok(Ready { model, workers, origin, out, logs, _lock: lock });
    }
}

/// Describes this start, from a cycle, for `provenance.json`.
fn program_start(model: &Model, sets: &[String], from_cycle: u64) -> Result<ProgramStart, String> {
    let commit = features::COMMIT.get().copied();
    let start = ProgramStart::of_this_process(commit, (&model.path, &model.files()), sets)?;
    Ok(ProgramStart { from_cycle, ..start })
}

/// Locks the folder of results. A run whose supervisor was killed before counts as lost, so that
/// another process may be about to run in its place: it runs nothing.
fn locked(args: &RunArgs, out: &Path) -> Result<Lock, String> {
    let lock = disk::watched(out, || Lock::acquire(out))?;
    match args.under.as_deref().filter(|attempt| attempt::is_released(attempt)) {
        None => Ok(lock),
        Some(attempt) => {
            Err(format!("{}: the supervisor has ended; nothing is run", attempt.display()))
        }
    }
}

/// Sets the time for which reading waits for a file system to that of the command line: that of the
/// job is not known yet.
fn set_patience(args: &RunArgs) {
    let sets = args.sets();
    let given = sets.iter().rev().find_map(|set| set.strip_prefix("checkpoint.patience="));
    let asked = given.map(|text| Checkpoint {
        patience: text.trim_matches('"').into(),
        ..Checkpoint::default()
    });
    // A value that is not valid is reported with the job.
    if let Some(patience) = asked.and_then(|asked| asked.patience().ok()) {
        disk::set_patience(patience);
    }
}

/// Reads the job, with the `key=value` of a checkpoint before those of the command line. Returns
/// the model, all `key=value`, and the number of workers.
fn read_job(
    args: &RunArgs,
    workers: impl Fn(&Model) -> Result<usize, Report>,
    known: Option<&Stamp>,
) -> Result<(Model, Vec<String>, usize), StartProblems> {
    let file = args.job.clone().or_else(|| known.map(|stamp| PathBuf::from(&stamp.file)));
    let sets: Vec<String> =
        known.iter().flat_map(|stamp| stamp.set.clone()).chain(args.sets()).collect();
    let mut model = job::read(&file.unwrap_or_default(), &sets)?;
    let workers = workers(&model)?;
    requirements::check_names(&model)?;
    if let Ok(patience) = model.job.checkpoint.patience() {
        disk::set_patience(patience);
    }
    if let Some(path) = &args.steering {
        model.settings.planned = steering::read(path)?;
    }
    Ok((model, sets, workers))
}

fn run_threads(args: &RunArgs, service: &Service) -> u8 {
    let ready = prepare_or_print(args, |m| m.workers(args.options.workers, cores()));
    let Some(mut ready) = ready else { return Report::EXIT_CODE };
    let _log = ready.logs.start_master(ready.origin.from.is_some());
    with_threads(ready, |ready, master| as_master(args, ready, master, service).0)
}

/// Returns the number of cores of this machine.
pub(super) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Starts the workers as threads of this process, and ends them when the master has ended.
pub(super) fn with_threads<T>(
    ready: Ready,
    as_master: impl FnOnce(Ready, &mut dyn Transport) -> T,
) -> T {
    let mut ends = threads::connect_teams(ready.workers + 1, ready.model.settings.threads);
    let mut master = ends.remove(0);
    let workers: Vec<_> = ends
        .into_iter()
        .map(|mut end| {
            let rank = end.rank();
            let name = format!("worker {}", rank - 1);
            let logs = ready.logs.clone();
            let body = move || {
                if let Err(lost) = crumple_worker::serve::serve(&mut end) {
                    tracing::error!(worker = rank - 1, %lost, "worker ends");
                }
            };
            let logged = move || logs.with_thread(rank, body);
            std::thread::Builder::new().name(name).spawn(logged)
        })
        .collect();
    let ended = as_master(ready, &mut master);
    drop(master); // workers that wait for a message end
    for worker in workers.into_iter().flatten() {
        // The worker has printed its panic, and the master reports it as a lost worker.
        let _ = worker.join();
    }
    ended
}

#[cfg(not(feature = "mpi"))]
fn run_under_mpi(_: &RunArgs) -> u8 {
    eprintln!(
        "error: this crumple was built without MPI; build it with \
         `cargo build --release --features mpi`,"
    );
    eprintln!("  or run it without mpirun; workers are then threads");
    Report::EXIT_CODE
}

#[cfg(feature = "mpi")]
fn run_under_mpi(args: &RunArgs) -> u8 {
    use crumple_proto::{message::ToWorker, transport::Tag, transport::mpi::Mpi, wire::post};
    // Before MPI starts, which takes a while.
    let service = if is_worker_rank() {
        signals::leave_to_master();
        None
    } else {
        Some(Service::start(Manner::AtOnce))
    };
    let service = || service.unwrap_or_else(|| Service::start(Manner::AtOnce));
    let Some(mut comm) = Mpi::start() else {
        eprintln!("error: MPI could not be started");
        return WORKER_LOST;
    };
    if comm.size() == 1 {
        drop(comm);
        return run_threads(args, &service());
    }
    if comm.rank() > 0 {
        let log = log_of_worker(args, comm.rank());
        // The panic of a worker is printed by then; the run ends as if the worker were lost.
        let served = std::panic::AssertUnwindSafe(|| crumple_worker::serve::serve(&mut comm));
        let served = std::panic::catch_unwind(served);
        drop(log); // its last lines are written
        return match served {
            Ok(Ok(())) => COMPLETED,
            Ok(Err(lost)) => {
                eprintln!("error: worker {}: {lost}", comm.rank() - 1);
                comm.abort(i32::from(WORKER_LOST))
            }
            Err(_) => comm.abort(i32::from(WORKER_LOST)),
        };
    }
    let ranks = comm.size() - 1;
    let ready = prepare_or_print(args, |m| {
        m.workers(Some(ranks), ranks)?;
        Ok(ranks)
    });
    match ready {
        Some(mut ready) => {
            let log = ready.logs.start_master(ready.origin.from.is_some());
            let (code, ended) = as_master(args, ready, &mut comm, &service());
            drop(log);
            match ended {
                WorkersAre::Gone => code,
                WorkersAre::Waiting => comm.abort(i32::from(code)),
            }
        }
        None => {
            for rank in 1..=ranks {
                // A worker that has ended needs no message.
                let _ = post(&mut comm, rank, Tag::Order, &ToWorker::Quit);
            }
            Report::EXIT_CODE
        }
    }
}

/// Starts the log of a worker process. Without a folder of results the master refuses the run.
#[cfg(feature = "mpi")]
fn log_of_worker(args: &RunArgs, rank: usize) -> Option<RankLog> {
    let out = args.resume.as_ref().map_or_else(|| Ok(args.out_dir()), |dir| find::run_folder(dir));
    Logs::new(&out.ok()?, args.log.as_deref()).start_process(rank)
}

/// The workers when the master ends.
enum WorkersAre {
    /// They have ended, or end by themselves.
    Gone,
    /// They compute, or wait for the master.
    Waiting,
}

/// Runs the job as the master. Returns the exit code of the process.
fn as_master(
    args: &RunArgs,
    ready: Ready,
    comm: &mut dyn Transport,
    service: &Service,
) -> (u8, WorkersAre) {
    let Ready { mut model, origin, out, _lock, .. } = ready;
    let model = &mut model;
    for warning in model.warnings.iter().filter(|_| !args.quiet) {
        eprint!("{}", model.show(warning));
    }
    if !args.quiet {
        crate::stdout::write(format_args!("{}", crate::input::check::mapping(model)));
    }
    model.warnings.iter().for_each(|warning| tracing::warn!(%warning, "job"));
    report::forget(&out); // from an earlier run
    let stop = service.stop();
    stop.set_manner(Manner::Orderly);
    let desk = service.open(&out);
    if let Err(why) = &desk {
        tracing::warn!(why, "no client can attach to this run");
    }
    let audience = match (args.quiet, args.verbose) {
        (true, _) => Audience::Silent,
        (false, true) => Audience::VerboseTerminal,
        (false, false) => Audience::Terminal,
    };
    let guidance = Guidance { audience, stop, desk: desk.ok() };
    let results = Results { out: &out, trace: args.trace.as_deref() };
    let ended = control::run(model, comm, results, origin, guidance);
    let made = make_report(args, &ended, &out);
    let (code, workers) = match &ended {
        Ok(summary) => (conclude(args, model, summary, &out), WorkersAre::Gone),
        Err(error) => {
            eprintln!("error: {error}");
            let workers = match error {
                RunError::Unusable(_) | RunError::Refused(_) => WorkersAre::Gone,
                RunError::Lost(_) | RunError::Output { .. } | RunError::Trace { .. } => {
                    if disk::watched(&out, || find::newest_cycle(&out)).is_some() {
                        eprintln!("  continue with: crumple run --resume {}", out.display());
                    }
                    WorkersAre::Waiting
                }
            };
            (error.exit_code(), workers)
        }
    };
    match made.filter(|_| !args.quiet) {
        Some(Ok(made)) => say!("{made}"),
        Some(Err(why)) => eprintln!("warning: no report was written: {why}"),
        None => {}
    }
    (code, workers)
}

/// Makes the report of a run that has ended, if it is wanted and the folder can be written.
pub(super) fn make_report(
    args: &RunArgs,
    ended: &Result<Summary, RunError>,
    out: &Path,
) -> Option<Result<report::Made, String>> {
    let writable = !matches!(ended, Err(RunError::Output { .. }));
    (writable && !args.no_report).then(|| report::write(out, args.quiet))
}

/// Writes the exports that the job asks for.
///
/// # Errors
/// One cannot be written; the message names the file.
pub(super) fn export(model: &Model, out: &Path) -> Result<(), String> {
    type Export = fn(&Path, &Output) -> Result<String, String>;
    let output = &model.job.output;
    let exports: [(bool, Export); 4] = [
        (output.d3plot, |out, output| {
            d3plot::export(out, 1_000_000 * crate::cli::D3PLOT_FILE_SIZE, output.strains)
        }),
        (output.d3plot, |out, _| binout::export(out)),
        (output.vtkhdf, |out, _| vtkhdf::export(out)),
        (output.exodus, |out, _| exodus::export(out)),
    ];
    exports.iter().filter(|(is_asked, _)| *is_asked).try_for_each(|(_, export)| {
        export(out, output)?;
        Ok(())
    })
}

/// Prints how a run ended and writes the exports that the job asks for. Returns the exit code.
fn conclude(args: &RunArgs, model: &Model, summary: &Summary, out: &Path) -> u8 {
    if !args.quiet {
        print_summary(summary, out);
    }
    if let Err(why) = export(model, out) {
        eprintln!("error: {why}");
        return Report::EXIT_CODE;
    }
    if summary.status == RunEnd::Failed {
        eprintln!("error: {}", summary.reason);
        name_last_state(out, summary);
    }
    if summary.status == RunEnd::Stopped && !args.quiet && find::newest_cycle(out).is_some() {
        say!("continue with: crumple run --resume {}", out.display());
    }
    summary.exit_code()
}

/// Names the last state of a run that has failed, and the command that continues from it.
fn name_last_state(out: &Path, summary: &Summary) {
    match disk::watched(out, || find::newest(out)) {
        Some((folder, manifest)) => {
            let at = manifest.captured;
            eprintln!(
                "  the state of cycle {}, time {:.6e}, {} cycles before the end, is kept in {}",
                at.cycle,
                at.time,
                summary.cycles.saturating_sub(at.cycle),
                folder.display()
            );
            eprintln!(
                "  continue from it with a change, such as: crumple run --resume {} --set \
                 time.dt_max={:.3e}",
                out.display(),
                0.5 * summary.dt.last
            );
            let whole = |f: &PathBuf| *f != folder && Manifest::read(f).is_ok();
            if let Some(older) = find::folders(&out.join(find::DIR)).into_iter().find(whole) {
                eprintln!("  if this state is already wrong: --resume {}", older.display());
            }
        }
        None => eprintln!("  there is no checkpoint: the run starts again from time 0"),
    }
}

fn print_summary(s: &Summary, out: &Path) {
    let ending = match s.status {
        RunEnd::Completed => "NORMAL TERMINATION",
        RunEnd::Stopped => "STOPPED BEFORE THE END",
        RunEnd::Failed => "ERROR TERMINATION",
    };
    say!("{ending}: {:?}, {}", s.status, s.reason);
    say!(
        "time {:.6e} after {} cycles, dt first {:.3e} min {:.3e}",
        s.end_time,
        s.cycles,
        s.dt.first,
        s.dt.min
    );
    let e = &s.energy;
    let percent = |error: f64| match error.is_finite() {
        true => format!("{:.3} %", 100.0 * error),
        false => "unknown".to_string(),
    };
    say!(
        "energy: kinetic {:.4e} internal {:.4e} hourglass {:.4e} contact work {:.4e} \
         wall work {:.4e}, error {} (max {})",
        e.kinetic,
        e.internal,
        e.hourglass,
        e.contact,
        e.wall,
        percent(e.error),
        percent(e.error_max)
    );
    say!(
        "{} workers ({}{}), {:.1} s wall, grind {:.0} ns per element and cycle; \
         {} low and {} high redecompositions, imbalance {:.2}",
        s.workers,
        s.transport,
        if s.threads > 1 { format!(", {} threads each", s.threads) } else { String::new() },
        s.wall_s,
        s.grind_ns,
        s.redecompositions.low,
        s.redecompositions.high,
        s.imbalance.mean
    );
    if let Some(a) = &s.adaptivity {
        let before: usize = s.elements.values().sum();
        say!("adaptivity: {} shells divided, {before} elements became {}", a.divided, a.elements);
    }
    let total: f64 = s.phase_s.values().map(|p| p.mean).sum();
    let mut phases: Vec<_> = s.phase_s.iter().collect();
    phases.sort_by(|a, b| b.1.mean.total_cmp(&a.1.mean));
    let share = |p: f64| if total > 0.0 { 100.0 * p / total } else { 0.0 };
    let shares: Vec<_> =
        phases.iter().map(|(name, p)| format!("{name} {:.1} %", share(p.mean))).collect();
    say!("share of phases: {}", shares.join(", "));
    s.warnings.iter().for_each(|one| say!("warning: {}", one.line()));
    s.requirements.iter().for_each(|one| say!("{}", one.line()));
    say!("state_digest {}", s.state_digest);
    say!(
        "results in {}; open {} in ParaView",
        out.display(),
        out.join(fields::DIR).join(fields::COLLECTION).display()
    );
}
