//! `crumple check`: describes a job, measures its cost and, if asked for, the stable step of the
//! assembled system.

use crate::analysis::{cost, spectrum};
use crate::cli::CheckArgs;
use crate::input::check::{describe, figure};
use crate::input::confine;
use crate::input::findings::Findings;
use crate::input::job::{self, Model, Report};
use crate::results::requirements;
use crate::stdout;

/// Runs `crumple check`: prints the description to standard output, or all problems to standard
/// error; with `--json`, the findings to standard output in both cases. Returns the exit code.
pub fn run(args: &CheckArgs) -> u8 {
    if let Some(folder) = &args.job.options.within
        && let Err(error) = confine::to(folder)
    {
        eprintln!("error: {}: {error}", folder.display());
        return Report::EXIT_CODE;
    }
    let read = || -> Result<(Model, String, f64), Report> {
        let model = job::read(&args.job.job, &args.sets())?;
        let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
        let workers = model.workers(args.job.options.workers, cores)?;
        requirements::check_names(&model)?;
        let (costs, memory_mb) = cost::describe(&model, workers);
        let text = describe(&model) + &costs;
        Ok((model, text, memory_mb))
    };
    let (model, text, memory_mb) = match read() {
        Ok(read) => read,
        Err(report) if args.json => {
            print(&Findings::new(false, 0.0, &report.problems, report.to_string()));
            return Report::EXIT_CODE;
        }
        Err(report) => {
            eprint!("{report}");
            return Report::EXIT_CODE;
        }
    };
    if args.json {
        let warnings: Vec<_> = model.warnings.iter().map(|warning| model.show(warning)).collect();
        print(&Findings::new(true, memory_mb, &warnings, text));
        return 0;
    }
    stdout::write(format_args!("{text}"));
    let Some(time) = args.step else { return 0 };
    match spectrum::assembled(&model, time) {
        Ok(found) => {
            stdout::write(format_args!("{}", stability(&found, model.settings.safety)));
            if found.taken > found.limit { UNSTABLE } else { 0 }
        }
        Err(why) => {
            eprintln!("error: the step of the assembled system was not found: {why}");
            UNSTABLE
        }
    }
}

fn print(findings: &Findings) {
    let line = serde_json::to_string(findings).expect("plain data is always JSON");
    stdout::write(format_args!("{line}\n"));
}

/// Exit code if the step is larger than the stable step of the assembled system.
const UNSTABLE: u8 = 3;

/// Compares the stable step of the assembled system with the step of the run.
fn stability(found: &spectrum::Estimate, safety: f64) -> String {
    let share = found.taken / found.limit;
    let mut text = format!(
        "\nassembled    stable step {} at time {} ({} force evaluations, error at most {} %), \
         largest motion at node {}; the step of the run is {} of it\n",
        figure(found.limit),
        figure(found.time),
        found.pushes,
        figure(50.0 * found.residual),
        found.node,
        figure(share)
    );
    if share > 1.0 {
        let bearable = figure(safety / share);
        text += &format!(
            "warning: the run is unstable at this step: set time.safety below {bearable}\n"
        );
    }
    text
}
