//! Events of a run, by `tracing`: `log.jsonl` with those of the master, and on request (`--log`,
//! `RUST_LOG`) `logs/rank_NNNN.log` with spans and events of each rank.

use crumple_proto::disk::{self, WatchedFile};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tracing::level_filters::LevelFilter;
use tracing::{Dispatch, Subscriber};
use tracing_appender::non_blocking;
use tracing_appender::non_blocking::{ErrorCounter, NonBlocking, WorkerGuard};
use tracing_subscriber::fmt::format::FmtSpan;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::registry::LookupSpan;
use tracing_subscriber::{EnvFilter, Layer};

/// Folder of the files of all ranks.
const DIR: &str = "logs";
/// Variable with the directives, used without `--log`.
const VARIABLE: &str = "RUST_LOG";

/// The logs of a run.
#[derive(Clone)]
pub struct Logs {
    out: PathBuf,
    /// Directives for the files of the ranks, if they are requested.
    directives: Option<String>,
    /// `log.jsonl`.
    events: Option<Arc<WatchedFile>>,
}

/// The log of a rank. Its last lines are written when it is dropped.
pub struct RankLog {
    path: PathBuf,
    lost: ErrorCounter,
    _guard: WorkerGuard,
}

impl Logs {
    /// Prepares the logs of a run in the folder `out`. `asked` are the directives of `--log`.
    pub fn new(out: &Path, asked: Option<&str>) -> Self {
        let set = || std::env::var(VARIABLE).ok().filter(|text| !text.is_empty());
        let directives = asked.map(String::from).or_else(set);
        Self { out: out.to_owned(), directives, events: None }
    }

    /// Starts the log of the master in its process, and opens `log.jsonl`. A run that `continues`
    /// appends to the files; otherwise those of an earlier run are removed. If the folder cannot
    /// be written, the run itself reports it.
    pub fn start_master(&mut self, continues: bool) -> Option<RankLog> {
        let path = self.out.join("log.jsonl");
        let open = |path: &Path| match continues {
            true => File::options().create(true).append(true).open(path),
            false => File::create(path),
        };
        let file = disk::watched(&self.out, || std::fs::create_dir_all(&self.out))
            .and_then(|()| WatchedFile::open(&path, open));
        if !continues {
            let _ = std::fs::remove_dir_all(self.out.join(DIR));
        }
        self.events = file.ok().map(Arc::new);
        let (dispatch, log) = self.dispatch(0);
        // A second run in the same process continues with the first log.
        let _ = tracing::dispatcher::set_global_default(dispatch);
        log
    }

    /// Starts the log of a worker that is a process of its own.
    pub fn start_process(&self, rank: usize) -> Option<RankLog> {
        self.directives.as_ref()?;
        let (dispatch, log) = self.dispatch(rank);
        let _ = tracing::dispatcher::set_global_default(dispatch);
        log
    }

    /// Runs a worker that is a thread, with a log of its own if one is requested.
    pub fn with_thread<T>(&self, rank: usize, body: impl FnOnce() -> T) -> T {
        if self.directives.is_none() {
            return body();
        }
        let (dispatch, _log) = self.dispatch(rank);
        tracing::dispatcher::with_default(&dispatch, body)
    }

    /// Returns the receiver of all events of a rank.
    fn dispatch(&self, rank: usize) -> (Dispatch, Option<RankLog>) {
        let events = self.events.clone().map(|file| {
            let lines = tracing_subscriber::fmt::layer().json();
            let lines = lines.with_current_span(false).with_span_list(false);
            lines.with_writer(file).with_filter(LevelFilter::INFO)
        });
        let (layer, log) = match &self.directives {
            None => (None, None),
            Some(directives) => {
                let path = self.out.join(DIR).join(format!("rank_{rank:04}.log"));
                let (writer, guard) = non_blocking(Lazy { path: path.clone(), file: None });
                let log = RankLog { path, lost: writer.error_counter(), _guard: guard };
                (Some(lines_of_rank(directives, writer)), Some(log))
            }
        };
        (tracing_subscriber::registry().with(events).with(layer).into(), log)
    }
}

/// Returns the layer that writes lines for a reader. Spans show their duration when they close.
fn lines_of_rank<S>(directives: &str, writer: NonBlocking) -> impl Layer<S>
where
    S: Subscriber + for<'a> LookupSpan<'a>,
{
    tracing_subscriber::fmt::layer()
        .with_ansi(false)
        .with_span_events(FmtSpan::CLOSE)
        .with_writer(writer)
        .with_filter(EnvFilter::new(directives))
}

impl Drop for RankLog {
    fn drop(&mut self) {
        let lost = self.lost.dropped_lines();
        if lost > 0 {
            eprintln!("warning: {}: the disk was too slow for {lost} lines", self.path.display());
        }
    }
}

/// A file that is created with its first line. A worker process that the master refuses to run
/// writes none, and so changes no file of another run.
struct Lazy {
    path: PathBuf,
    file: Option<File>,
}

impl Write for Lazy {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let file = match &mut self.file {
            Some(file) => file,
            none => {
                std::fs::create_dir_all(self.path.parent().unwrap_or(Path::new(".")))?;
                none.insert(File::options().create(true).append(true).open(&self.path)?)
            }
        };
        file.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.as_mut().map_or(Ok(()), File::flush)
    }
}
