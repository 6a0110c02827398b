//! `crumple bench`: cost of elements per cycle, phase by phase, compared with the present speed
//! of the machine.
//!
//! - `scenes.rs`: table `SCENES` of timed scenes
//! - `calibration.rs`: peak rate and memory rate of one core
//! - `traffic.rs`: data that a step touches
//!
//! Each round runs all scenes in turn, so that a slowdown of the machine affects all of them. A
//! scene restarts in every round and is timed over the same cycles. Times are CPU times of the
//! workers without waiting. The wall time is reported as well: with several workers or threads it
//! is shorter.

mod calibration;
mod scenes;
mod traffic;

use crate::cli::BenchArgs;
use crate::input::job::{Model, read_text};
use crate::run::embedded::{Timing, time_side_by_side};
use calibration::{Calibration, calibrate};
use crumple_proto::report::PHASES;
use indicatif::{ProgressBar, ProgressStyle};
use scenes::{BenchScene, SCENES};
use serde::Serialize;
use std::fmt::Write;
use std::io::IsTerminal;

/// Exit codes as in `docs/reference/exit-codes.md`.
const DONE: u8 = 0;
const BAD_INPUT: u8 = 2;
const FAILED: u8 = 3;

/// Cycles of all scenes with `--tiny`, which only checks that the scenes run.
const TINY: [u64; 2] = [1, 4];
/// Peak rate of the core on which the goals were set [GFLOP/s].
const GOAL_GFLOPS: f64 = 58.7;
/// Share of the total time below which a phase is not shown.
const SHOWN: f64 = 0.005;

/// Result of a scene; times per element and cycle.
#[derive(Serialize)]
struct Measured {
    scene: &'static str,
    elements: usize,
    workers: usize,
    cycles: u64,
    /// CPU time of all workers, per round [ns].
    cpu_ns: Vec<f64>,
    /// Median of the CPU time [ns].
    median_ns: f64,
    /// Median of the wall time [ns].
    wall_ns: f64,
    /// Medians of the phases [ns]; those of waiting are wall time.
    phase_ns: Vec<(&'static str, f64)>,
    /// The median times the peak rate: operations that the core could have done in this time.
    peak_flops: f64,
    /// Median over the goal, both in such operations; none if there is no goal.
    over_goal: Option<f64>,
}

#[derive(Serialize)]
struct BenchResults {
    version: &'static str,
    vectors: String,
    calibration: Calibration,
    rounds: usize,
    scenes: Vec<Measured>,
}

/// Runs `crumple bench` and returns the exit code.
pub fn run(args: &BenchArgs) -> u8 {
    let unknown: Vec<&str> = args
        .only
        .iter()
        .map(String::as_str)
        .filter(|name| !SCENES.iter().any(|s| s.name == *name))
        .collect();
    if !unknown.is_empty() {
        let names: Vec<&str> = SCENES.iter().map(|s| s.name).collect();
        eprintln!("error: there is no scene '{}'", unknown.join("', '"));
        eprintln!("  known: '{}'", names.join("', '"));
        return BAD_INPUT;
    }
    let wanted: Vec<&'static BenchScene> = SCENES
        .iter()
        .filter(|s| args.only.is_empty() || args.only.iter().any(|name| name == s.name))
        .collect();
    let made = if args.traffic {
        traffic::count(&wanted)
            .map(|all| (traffic::table(&all), serde_json::to_string_pretty(&all)))
    } else {
        measure(&wanted, args).map(|all| (table(&all), serde_json::to_string_pretty(&all)))
    };
    let (table, json) = match made {
        Ok(made) => made,
        Err(why) => {
            eprintln!("error: {why}");
            return FAILED;
        }
    };
    crate::stdout::write(format_args!("{table}"));
    if let Some(file) = &args.json
        && let Err(error) = std::fs::write(file, json.unwrap_or_default())
    {
        eprintln!("error: {}: {error}; choose another file with --json", file.display());
        return BAD_INPUT;
    }
    DONE
}

fn measure(scenes: &[&BenchScene], args: &BenchArgs) -> Result<BenchResults, String> {
    let models: Vec<Model> = scenes.iter().map(|s| model(s)).collect::<Result<_, _>>()?;
    let rounds = if args.tiny { 1 } else { args.rounds };
    let bar = std::io::stderr().is_terminal().then(|| {
        let bar = ProgressBar::new((rounds * scenes.len()) as u64);
        let style = ProgressStyle::with_template(
            "{bar:20} {pos}/{len} elapsed {elapsed} remaining {eta} {wide_msg}",
        );
        style.into_iter().for_each(|s| bar.set_style(s));
        bar
    });
    let mut peaks = Vec::new();
    let mut timings: Vec<Vec<Vec<Timing>>> = scenes.iter().map(|_| Vec::new()).collect();
    for round in 0..rounds {
        peaks.push(calibrate());
        for ((scene, model), timings) in scenes.iter().zip(&models).zip(&mut timings) {
            match &bar {
                Some(bar) => bar.set_message(scene.name),
                None => eprintln!("round {} of {rounds}: {}", round + 1, scene.name),
            }
            let [skip, cycles] = if args.tiny { TINY } else { scene.cycles };
            timings.push(time_side_by_side(model, scene.workers, skip, cycles).map_err(|why| {
                format!("scene '{}' failed within its {} cycles: {why}", scene.name, skip + cycles)
            })?);
            bar.iter().for_each(|bar| bar.inc(1));
        }
    }
    bar.iter().for_each(ProgressBar::finish_and_clear);
    let calibration = Calibration {
        fma_gflops: median(peaks.iter().map(|p| p.fma_gflops)),
        triad_gb_s: median(peaks.iter().map(|p| p.triad_gb_s)),
    };
    let each = scenes.iter().zip(&models).zip(&timings);
    Ok(BenchResults {
        version: env!("CARGO_PKG_VERSION"),
        vectors: crumple_worker::math::lanes::vectors(),
        calibration,
        rounds,
        scenes: each
            .map(|((scene, model), timings)| evaluate(scene, model, timings, &calibration))
            .collect(),
    })
}

fn model(scene: &BenchScene) -> Result<Model, String> {
    let text = crumple_cases::job(scene.job)
        .ok_or_else(|| format!("there is no job '{}' in the program", scene.job))?;
    let sets: Vec<String> = scene.sets.iter().map(|&s| s.to_string()).collect();
    let mut model =
        read_text(scene.job.into(), text.into(), &sets).map_err(|report| report.to_string())?;
    if !scene.contact {
        model.settings.contact = None;
    }
    Ok(model)
}

fn evaluate(
    scene: &BenchScene,
    model: &Model,
    rounds: &[Vec<Timing>],
    calibration: &Calibration,
) -> Measured {
    let elements = model.mesh.elements.len();
    let cycles = rounds[0][0].cycles;
    let each = |seconds: f64| 1e9 * seconds / (elements as f64 * cycles as f64);
    let cpu_ns: Vec<f64> = rounds.iter().map(|r| each(r.iter().map(|t| t.cpu_s).sum())).collect();
    let slowest = |r: &Vec<Timing>| r.iter().map(|t| t.wall_s).fold(0.0, f64::max);
    let phase = |p: usize| median(rounds.iter().map(|r| each(r.iter().map(|t| t.phases[p]).sum())));
    let median_ns = median(cpu_ns.iter().copied());
    let peak_flops = median_ns * calibration.fma_gflops;
    Measured {
        scene: scene.name,
        elements,
        workers: scene.workers,
        cycles,
        median_ns,
        wall_ns: median(rounds.iter().map(|r| each(slowest(r)))),
        phase_ns: PHASES.iter().enumerate().map(|(p, &name)| (name, phase(p))).collect(),
        peak_flops,
        over_goal: (scene.goal_ns > 0.0).then(|| peak_flops / (scene.goal_ns * GOAL_GFLOPS)),
        cpu_ns,
    }
}

/// Returns the median, the mean of the two middle values for an even number, or zero without
/// values.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 { 0.0 } else { 0.5 * (values[(n - 1) / 2] + values[n / 2]) }
}

/// Formats the table as Markdown.
fn table(results: &BenchResults) -> String {
    let Calibration { fma_gflops, triad_gb_s } = results.calibration;
    let mut out = format!(
        "One core: {fma_gflops:.1} GFLOP/s fused multiply-add, {triad_gb_s:.1} GB/s triad; \
         kernels use {}. {} rounds.\n\n\
         CPU time per element and cycle: median, minimum and maximum of the rounds.\n\
         Operations: those that the core can do in this time at its peak rate.\n\
         Over goal: operations over a fifth of those of the established open solver.\n\n\
         | scene | elements | workers | ns | min..max | wall | operations | over goal \
         | phases [ns] |\n\
         |---|---|---|---|---|---|---|---|---|\n",
        results.vectors, results.rounds
    );
    for m in &results.scenes {
        let least = m.cpu_ns.iter().copied().fold(f64::INFINITY, f64::min);
        let most = m.cpu_ns.iter().copied().fold(0.0, f64::max);
        let shown = m.phase_ns.iter().filter(|p| p.1 > SHOWN * m.median_ns);
        let phases: Vec<String> = shown.map(|(name, ns)| format!("{name} {ns:.1}")).collect();
        let goal = m.over_goal.map_or(String::new(), |g| format!("{g:.2}"));
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "| {} | {} | {} | {:.1} | {least:.1}..{most:.1} | {:.1} | {:.0} | {goal} | {} |",
            m.scene,
            m.elements,
            m.workers,
            m.median_ns,
            m.wall_ns,
            m.peak_flops,
            phases.join(", ")
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_a_sound_job_and_runs() {
        for scene in SCENES.iter().filter(|s| s.sets.is_empty()) {
            let model = model(scene).unwrap();
            let timings = time_side_by_side(&model, scene.workers, 1, 2).unwrap();
            assert_eq!((timings.len(), timings[0].cycles), (scene.workers, 2), "{}", scene.name);
            let m = evaluate(
                scene,
                &model,
                &[timings],
                &Calibration { fma_gflops: 50.0, triad_gb_s: 20.0 },
            );
            assert!(m.median_ns > 1.0 && m.peak_flops > 50.0, "{}: {} ns", scene.name, m.median_ns);
        }
    }

    #[test]
    fn the_median_is_the_middle_one_or_between_the_middle_two() {
        assert_eq!(
            (median([3.0, 1.0, 2.0].into_iter()), median([4.0, 1.0].into_iter())),
            (2.0, 2.5)
        );
    }
}
