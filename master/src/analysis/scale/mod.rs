//! `crumple scale`: predicts the parallel efficiency of a job for any number of workers.
//!
//! - `kernels.rs`: cost of elements, nodes, candidates and pairs on this machine
//! - `model.rs`: time of a step from these costs, a network and the counts of each worker
//! - `report.rs`: the table, `scale.csv`, the chart
//!
//! One worker runs the job to each of the times. There, for every number of workers, space is
//! decomposed as in a run (`decompose/`), and the elements, nodes and messages of each worker are
//! counted (`census.rs`). No run has more than one worker, except a
//! check with two workers from the start.

mod census;
mod kernels;
mod model;
mod report;

use crate::cli::ScaleArgs;
use crate::input::job::{self, Model, Report};
use crate::run::decompose::{Before, Centres, ElementLoads, Load, bisect};
use crate::run::embedded::{run_alone, time_side_by_side};
use crate::run::progress::{Audience, ProgressDisplay, RunState};
use crate::stdout::say;
use census::{Census, Count, centre_for, messages_to_all};
use crumple_proto::boxes::CutTree;
use crumple_proto::report::{PHASES, Phase};
use crumple_proto::transport::threads;
use crumple_worker::contact::Contact;
use crumple_worker::engine::Engine;
use crumple_worker::math::row::xyz;
use crumple_worker::parallel::contact_decomposition;
use crumple_worker::parallel::pair_exchange::TrafficEstimate;
use kernels::{Kernels, STEPS, Watch};
use model::{CostModel, Network, PredictedStep, WorkerStep};
use std::ops::ControlFlow;

/// Exit codes as in `docs/reference/exit-codes.md`.
const DONE: u8 = 0;
const BAD_INPUT: u8 = 2;
const FAILED: u8 = 3;

/// Cycles before the check with two workers, and timed cycles of the check.
const CHECKED: [u64; 2] = [20, 200];
/// Minimum number of workers whose boxes have as many neighbours as those of larger numbers.
const TYPICAL: usize = 8;

/// Prediction for one number of workers at one time.
pub struct Prediction {
    /// Number of workers.
    pub workers: usize,
    /// Counts of each worker.
    pub counts: Vec<Count>,
    /// Step for the given mesh.
    pub step: PredictedStep,
    /// Messages per step from each worker to all others.
    pub to_all: f64,
    /// Efficiency for a mesh that grows with the number of workers.
    pub scaled: f64,
}

/// All predictions for one time.
pub struct ScaleSample {
    /// Requested simulated time [time].
    pub at: f64,
    /// Cycle of the count. It follows the timed steps, which start at the requested time.
    pub cycle: u64,
    /// Counts of one worker with the whole mesh, and its step.
    pub whole: Count,
    /// See `whole`.
    pub alone: WorkerStep,
    /// Costs on this machine.
    pub kernels: Kernels,
    /// Elements per worker of the growing mesh.
    pub grows_by: f64,
    /// Predictions by number of workers, ascending.
    pub predictions: Vec<Prediction>,
}

/// Runs `crumple scale` and returns the exit code.
pub fn run(args: &ScaleArgs) -> u8 {
    let mut model = match job::read(&args.job, &args.set) {
        Ok(model) => model,
        Err(report) => {
            eprint!("{report}");
            return Report::EXIT_CODE;
        }
    };
    let (mut workers, mut times) = (args.workers.clone(), args.at.clone());
    if workers.is_empty() {
        workers =
            (1..=10).map(|power| 1 << power).filter(|&n| n <= model.mesh.elements.len()).collect();
    }
    workers.sort_unstable();
    workers.dedup();
    times.sort_by(f64::total_cmp);
    times.dedup();
    if let Some(why) = refuse(&model, &workers, &times) {
        eprintln!("error: {why}");
        return BAD_INPUT;
    }
    let out = args.out_dir();
    if let Err(error) = std::fs::create_dir_all(&out) {
        eprintln!("error: {}: {error}; choose another folder with --out", out.display());
        return BAD_INPUT;
    }
    let network = Network { latency: args.latency, bandwidth: args.bandwidth };
    // The run continues after the last time for the timed steps. Nothing is written and no code
    // reads the history.
    model.settings.end_time = f64::MAX;
    model.settings.max_cycles = 0;
    model.settings.history_interval = f64::MAX;
    model.settings.field_times.clear();
    let samples = match samples(&model, &workers, &times, network) {
        Ok(samples) => samples,
        Err(why) => {
            eprintln!("error: {why}");
            return FAILED;
        }
    };
    for sample in &samples {
        say!("{}", report::table(sample, network));
    }
    if let Some(sample) = samples.first().filter(|_| times[0] == 0.0) {
        match check(&model, sample) {
            Ok(said) => say!("{said}"),
            Err(why) => eprintln!("not checked with two workers: {why}"),
        }
    }
    if let count @ 1.. = model.settings.ties.len() {
        say!(
            "not included: the cost of {count} tied nodes, up to five messages per step between \
             workers that share a tie"
        );
    }
    match report::write(&model.job.title, &samples, &out) {
        Ok(files) => say!("written: {files}"),
        Err(why) => {
            eprintln!("error: {why}; choose another folder with --out");
            return BAD_INPUT;
        }
    }
    DONE
}

fn refuse(model: &Model, workers: &[usize], times: &[f64]) -> Option<String> {
    let (elements, end) = (model.mesh.elements.len(), model.settings.end_time);
    if model.settings.subcycles > 1 {
        return Some(
            "time.subcycles: the cost model computes all elements in each cycle; add --set \
             time.subcycles=1"
                .into(),
        );
    }
    if let Some(n) = workers.iter().find(|&&n| n > elements) {
        return Some(format!(
            "{n} workers are more than the {elements} elements of the job; give fewer with \
             --workers"
        ));
    }
    if workers.is_empty() {
        return Some("the job has one element: it cannot be decomposed".into());
    }
    let late = times.iter().find(|&&t| t >= end)?;
    Some(format!(
        "time {late} is not before the job's end_time = {end}; give an earlier one with --at"
    ))
}

/// Runs the job on one worker and predicts at each of the times.
fn samples(
    model: &Model,
    workers: &[usize],
    times: &[f64],
    network: Network,
) -> Result<Vec<ScaleSample>, String> {
    let last = times[times.len() - 1];
    let audience = if last == 0.0 { Audience::Silent } else { Audience::Terminal };
    let mut progress = ProgressDisplay::new(last.max(f64::MIN_POSITIVE), audience);
    let mut watch: Option<Watch> = None;
    let mut samples: Vec<ScaleSample> = Vec::new();
    let mut failed = None;
    let ended = run_alone(model, |engine| {
        let clock = &engine.clock;
        progress.show(&RunState {
            cycle: clock.cycle,
            time: clock.time,
            dt: clock.dt,
            ..RunState::default()
        });
        if watch.as_mut().is_some_and(|w| w.sample(engine))
            && let Some(watch) = watch.take()
        {
            progress.println(&format!("predicting at T={:.4e}", engine.clock.time));
            match sample(model, engine, &watch, workers, network) {
                Ok(sample) => samples.push(ScaleSample { at: times[samples.len()], ..sample }),
                Err(why) => failed = Some(why),
            }
        }
        if samples.len() == times.len() || failed.is_some() {
            return ControlFlow::Break(());
        }
        if watch.is_none() && engine.clock.time >= times[samples.len()] {
            watch = Some(Watch::new(engine));
        }
        ControlFlow::Continue(())
    });
    progress.finish();
    let ended = ended.map_err(|lost| lost.to_string())?;
    match (failed, ended.trouble) {
        (Some(why), _) => Err(why),
        (None, Some(element)) => Err(format!(
            "element {element} fails at time {:.6e}; see `crumple run`",
            ended.engine.clock.time
        )),
        (None, None) => Ok(samples),
    }
}

fn sample(
    model: &Model,
    engine: &Engine,
    watch: &Watch,
    workers: &[usize],
    network: Network,
) -> Result<ScaleSample, String> {
    let mut whole = count(engine, &CutTree::single(), None);
    let whole = whole.swap_remove(0);
    let kernels = watch.kernels(model, engine, &whole).map_err(|lost| lost.to_string())?;
    let costs = CostModel { kernels: &kernels, network };
    let alone = WorkerStep::new(&whole, [0.0; 2], None, costs);
    let mut load = load(engine, &kernels, &whole);
    let before = Before { tree: None, buffer: engine.settings.buffer };
    let mut predictions = Vec::new();
    for &n in workers {
        let tree = bisect(load.as_mut(), n, before).map_err(|lost| lost.to_string())?;
        let counts = count(engine, &tree, contact_cuts(engine, n, None)?);
        let step = step(engine, &counts, n, costs, [alone.kernels(), alone.search]);
        predictions.push(Prediction {
            workers: n,
            counts,
            step,
            to_all: messages_to_all(engine, n),
            scaled: 0.0,
        });
    }
    // Counts of a worker for a typical number of workers, in a mesh that grows with that number.
    let typical = workers.iter().position(|&n| n >= TYPICAL).unwrap_or(workers.len() - 1);
    let (base, counts) = (workers[typical] as f64, predictions[typical].counts.clone());
    for p in &mut predictions {
        let grown = step(engine, &counts, p.workers, costs, [alone.kernels(), alone.search]);
        p.scaled = alone.total() / base / grown.total;
    }
    let grows_by = whole.elements as f64 / base;
    let (at, cycle) = (engine.clock.time, engine.clock.cycle);
    Ok(ScaleSample { at, cycle, whole, alone, kernels, grows_by, predictions })
}

/// Returns the cuts of the second decomposition for a number of workers, from the `last` ones;
/// `None` if contact has none.
fn contact_cuts(
    engine: &Engine,
    workers: usize,
    last: Option<&CutTree>,
) -> Result<Option<CutTree>, String> {
    let contact = engine.contact.as_ref().filter(|_| engine.settings.has_second_decomposition());
    let Some(contact) = contact else { return Ok(None) };
    let place = |&n: &u32| xyz(&engine.nodes.x[n as usize]);
    let points: Vec<[f64; 3]> = contact.surface.slaves.iter().map(place).collect();
    let mut alone = threads::connect(2);
    let cuts = contact_decomposition::bisect(&mut alone[1], workers, last, &points);
    cuts.map(Some).map_err(|lost| lost.to_string())
}

/// Counts the elements, nodes, pairs and messages of each worker for the boxes of a tree and the
/// cuts of a second decomposition of contact.
fn count(engine: &Engine, tree: &CutTree, contact: Option<CutTree>) -> Vec<Count> {
    let mut census = Census::new(engine, tree, contact);
    census.count_contact(engine);
    census.counts
}

/// Returns the step of `workers` workers with these counts. If there are more workers than
/// counts, the others are assumed to be of the same kind.
fn step(
    engine: &Engine,
    counts: &[Count],
    workers: usize,
    costs: CostModel<'_>,
    alone: [f64; 2],
) -> PredictedStep {
    let exchange = |count: &Count| {
        let sweeps = costs.kernels.sweeps;
        let estimate =
            |c: &Contact| TrafficEstimate::estimate(c.laws(), sweeps, count.quiet, count.phases);
        engine.contact.as_ref().map_or(TrafficEstimate::default(), estimate)
    };
    let of = |c: &Count| {
        let estimate = exchange(c);
        WorkerStep::new(c, c.traffic_with_sums(engine, workers, &estimate), Some(estimate), costs)
    };
    let works: Vec<WorkerStep> = counts.iter().map(of).collect();
    PredictedStep::new(&works, alone)
}

/// Returns the load for the decomposition of the elements. At the start, and at any time with a
/// second decomposition of contact, it is the number of elements, as on the
/// master; later the measured cost with that of pairs, as in a low redecomposition.
fn load(engine: &Engine, kernels: &Kernels, whole: &Count) -> Box<dyn Load> {
    if engine.settings.has_second_decomposition() {
        let elements = engine.blocks.elements.iter();
        let centres = elements.map(|e| centre_for(&engine.nodes, e, true)).collect();
        return Box::new(Centres(centres));
    }
    let mut loads = Vec::new();
    let units = |n: u64| n as f64;
    let elements: f64 = kernels.element.iter().zip(&whole.lanes).map(|(s, &n)| s * units(n)).sum();
    let of = |k: [f64; 2], n: u64| k[0] * units(whole.slaves) + k[1] * units(n);
    let mut seconds = [0.0; PHASES.len()];
    seconds[Phase::Elements as usize] = elements;
    seconds[Phase::Search as usize] =
        kernels.watch * units(whole.held) + kernels.search * units(whole.segments + whole.slaves);
    seconds[Phase::Local as usize] = of(kernels.local, whole.near);
    seconds[Phase::Contact as usize] = of(kernels.contact, whole.pairs);
    let weighs = engine.clock.cycle > STEPS as u64 && whole.pairs > 0 && elements > 0.0;
    engine.for_each_load(&seconds, f64::INFINITY, |centre, load| loads.push((centre, load)));
    if weighs {
        Box::new(ElementLoads(loads))
    } else {
        Box::new(Centres(loads.into_iter().map(|l| l.0).collect()))
    }
}

/// Compares a run of two workers from the start with the prediction.
fn check(model: &Model, sample: &ScaleSample) -> Result<String, String> {
    let Some(p) = sample.predictions.iter().find(|p| p.workers == 2) else {
        return Err("2 is not among --workers".into());
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    if cores < 2 {
        return Err("this machine has one core".into());
    }
    let [skip, cycles] = CHECKED;
    let timings = time_side_by_side(model, 2, skip, cycles)?;
    let each = |seconds: f64| 1e6 * seconds / cycles as f64;
    let most =
        |of: fn(&crate::run::embedded::Timing) -> f64| timings.iter().map(of).fold(0.0, f64::max);
    let mean = |n: u64| n as f64 / (2 * cycles) as f64;
    let (messages, bytes) =
        timings.iter().fold((0, 0), |s, t| (s.0 + t.traffic.messages, s.1 + t.traffic.bytes));
    let (cpu, wall) = (each(most(|t| t.cpu_s)), each(most(|t| t.wall_s)));
    let alone = 1e6 * sample.alone.total();
    let busy = if wall > 1.25 * cpu {
        " Wall time is much longer than CPU time: two cores were not free, or waiting is slow \
         on this machine; use the CPU time."
    } else {
        ""
    };
    Ok(format!(
        "measured with two workers, as threads without a network, {cycles} steps from the start: \
         predicted {:.1} us of own work for the slower one, {:.0} messages and {:.1} kB for the \
         one that sends most; measured {cpu:.1} us of CPU time, {wall:.1} us of wall time, \
         {:.1} messages and {:.1} kB (mean). Efficiency: {:.1} % from the predicted own work, \
         {:.1} % from CPU time, {:.1} % from wall time.{busy}",
        1e6 * p.step.own,
        p.step.messages,
        1e-3 * p.step.bytes,
        mean(messages),
        1e-3 * mean(bytes),
        100.0 * sample.alone.total() / (2.0 * p.step.own),
        50.0 * alone / cpu,
        50.0 * alone / wall
    ))
}

#[cfg(test)]
mod tests;
