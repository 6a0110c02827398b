//! A run in threads of this process, for programs that use the master as a library: it takes no
//! signals and no clients, prints nothing, and returns all problems.

use crate::cli::RunArgs;
use crate::results::report;
use crate::results::summary::Summary;
use crate::run::control::{self, Guidance, Results, RunError};
use crate::run::launch::{self, StartProblems};
use crate::run::progress::{Audience, ProgressFeed};
use crate::run::service::signals::{Manner, StopFlag};

/// Reason why a run has no summary, or not all of its files.
#[derive(Debug, thiserror::Error)]
pub enum InProcessError {
    /// It has not begun.
    #[error(transparent)]
    Start(#[from] StartProblems),
    /// It was lost.
    #[error(transparent)]
    Run(#[from] RunError),
    /// An export that the job asks for cannot be written.
    #[error("{0}")]
    Export(String),
}

/// Runs a job. Of `args` the job, its options, `resume`, `out`, `overwrite`, `end_time` and
/// `no_report` have an effect. When `stop` is raised, the run ends with a checkpoint.
///
/// # Errors
/// See [`InProcessError`].
pub fn run(
    args: &RunArgs,
    stop: &StopFlag,
    feed: &ProgressFeed,
) -> Result<Summary, InProcessError> {
    stop.set_manner(Manner::Patient);
    let ready = launch::prepare(args, |m| m.workers(args.options.workers, launch::cores()))?;
    launch::with_threads(ready, |ready, comm| {
        let launch::Ready { mut model, origin, out, .. } = ready;
        model.warnings.iter().for_each(|warning| feed.say(&model.show(warning).to_string()));
        report::forget(&out); // from an earlier run
        let guidance = Guidance { audience: Audience::Thread(feed.clone()), stop, desk: None };
        let results = Results { out: &out, trace: None };
        let ended = control::run(&mut model, comm, results, origin, guidance);
        if let Some(Err(why)) = launch::make_report(args, &ended, &out) {
            feed.say(&format!("warning: no report was written: {why}"));
        }
        let summary = ended?;
        launch::export(&model, &out).map_err(InProcessError::Export)?;
        Ok(summary)
    })
}
