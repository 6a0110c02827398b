//! `crumple check`: describes a job, measures its cost and, if asked for, the stable step of the
//! assembled system.

use crate::analysis::{cost, spectrum};
use crate::cli::CheckArgs;
use crate::input::check::{describe, figure};
use crate::input::confine;
use crate::input::findings::Findings;
use crate::input::job::report::SHOWN;
use crate::input::job::{self, Model, Report};
use crate::results::report::Made;
use crate::results::report::model_page::{self, ExpectedCost};
use crate::results::requirements;
use crate::stdout;
use crumple_proto::exit_code::COMPLETED;
use std::path::Path;

/// Runs `crumple check`: prints the description to standard output, or all problems to standard
/// error; with `--json`, the findings to standard output in both cases. Returns the exit code.
pub fn run(args: &CheckArgs) -> u8 {
    if let Some(folder) = &args.job.options.within
        && let Err(error) = confine::to(folder)
    {
        eprintln!("error: {}: {error}", folder.display());
        return Report::EXIT_CODE;
    }
    let read = job::read(&args.job.job, &args.sets());
    let described = read.and_then(|model| Described::new(model, args.job.options.workers));
    let code = if described.is_ok() { COMPLETED } else { Report::EXIT_CODE };
    let page = args.page().map(|path| write_page(args, &described, &path));
    if args.json {
        print(&findings(&described, SHOWN));
        return said(page.as_ref(), true).unwrap_or(code);
    }
    let Described { model, text, .. } = match described {
        Ok(described) => described,
        Err(report) => {
            eprint!("{report}");
            said(page.as_ref(), false);
            return Report::EXIT_CODE;
        }
    };
    stdout::write(format_args!("{text}"));
    if let Some(code) = said(page.as_ref(), false) {
        return code;
    }
    let Some(time) = args.step else { return COMPLETED };
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

/// Writes the page of a job that can run, or of its problems.
fn write_page(
    args: &CheckArgs,
    described: &Result<Described, Report>,
    path: &Path,
) -> Result<Made, String> {
    match described {
        Ok(Described { model, text, cost }) => model_page::write(model, cost, text, path),
        Err(report) => model_page::write_refused(&args.job.job, report, path),
    }
}

/// Says where the page is, or why it is not written, and returns the exit code of that.
fn said(page: Option<&Result<Made, String>>, quiet: bool) -> Option<u8> {
    match page? {
        Ok(made) if quiet => eprintln!("{made}"),
        Ok(made) => stdout::write(format_args!("\n{made}\n")),
        Err(why) => {
            eprintln!("error: {why}");
            return Some(Report::EXIT_CODE);
        }
    }
    None
}

/// A job that can run.
pub struct Described {
    model: Model,
    text: String,
    cost: ExpectedCost,
}

impl Described {
    /// Describes a job with its cost on `workers`, or on the number of workers that the job or this
    /// machine gives.
    ///
    /// # Errors
    /// The number of workers or a requirement of the job cannot be used.
    pub fn new(model: Model, workers: Option<usize>) -> Result<Self, Report> {
        let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
        let workers = model.workers(workers, cores)?;
        requirements::check_names(&model)?;
        let (costs, cost) = cost::describe(&model, workers);
        let text = describe(&model) + &costs;
        Ok(Self { model, text, cost })
    }
}

/// Returns the problems of a job, or its warnings and its description; at most `most` of them.
pub fn findings(described: &Result<Described, Report>, most: usize) -> Findings {
    match described {
        Ok(Described { model, text, cost }) => {
            let warnings: Vec<_> = model.warnings.iter().map(|one| model.show(one)).collect();
            Findings::new(true, cost.memory_mb, (&warnings, most), text.clone())
        }
        Err(report) => Findings::new(false, 0.0, (&report.problems, most), report.to_string()),
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
