//! `crumple watch`: the stream of events of a job.

use super::CommandResult;
use super::server::Server;
use crate::run::attach::show_progress;
use crate::run::request::Answer;
use crate::serve::api::ServiceJob;
use crate::stdout::say;
use crumple_proto::exit_code::WORKER_LOST;
use std::io::{BufRead, BufReader};
use std::time::{Duration, Instant};

/// Interval between two lines of progress.
const LINE_EVERY: Duration = Duration::from_secs(1);
/// Longest time without an answer of the service, which may be starting again.
const PATIENCE: Duration = Duration::from_secs(60);

/// Shows a job until it ends. Returns the exit code of the run.
///
/// # Errors
/// The service refuses, or is away for too long.
pub fn watch(server: &Server, id: i64) -> CommandResult {
    let path = format!("/api/jobs/{id}/events");
    let mut shown = Shown::default();
    let mut away = None::<Instant>;
    loop {
        match server.events(&path, shown.last) {
            Ok(stream) => {
                away = None;
                if shown.read(BufReader::new(stream)) {
                    let job: ServiceJob = server.get(&format!("/api/jobs/{id}"))?;
                    return Ok(job.code.unwrap_or_default());
                }
            }
            Err((false, why)) => return Err(why),
            Err((true, why)) => {
                if away.get_or_insert_with(Instant::now).elapsed() > PATIENCE {
                    eprintln!("error: {why}");
                    return Ok(WORKER_LOST);
                }
            }
        }
        std::thread::sleep(LINE_EVERY);
    }
}

/// Text that has been shown.
#[derive(Default)]
struct Shown {
    /// Number of the last event.
    last: i64,
    progress: Option<Instant>,
    /// Last state and reason.
    state: String,
}

impl Shown {
    /// Shows events until the stream breaks (false) or the job ends (true).
    fn read(&mut self, stream: impl BufRead) -> bool {
        let (mut kind, mut data) = (String::new(), String::new());
        for line in stream.lines().map_while(Result::ok) {
            match line.split_once(':').map(|(key, value)| (key, value.trim_start())) {
                Some(("event", value)) => kind = value.into(),
                Some(("data", value)) => data += value,
                Some(("id", value)) => self.last = value.parse().unwrap_or(self.last),
                _ if line.is_empty() && !kind.is_empty() => {
                    if kind == "end" {
                        return true;
                    }
                    self.show(&kind, &data);
                    (kind, data) = (String::new(), String::new());
                }
                _ => {}
            }
        }
        false
    }

    fn show(&mut self, kind: &str, data: &str) {
        if kind == "state" {
            let Ok(job) = serde_json::from_str::<ServiceJob>(data) else { return };
            let why =
                if job.reason.is_empty() { String::new() } else { format!(": {}", job.reason) };
            let state = format!("{}{why}", job.state.name());
            if self.state != state {
                say!("job {}: {state}", job.id);
                self.state = state;
            }
            return;
        }
        match serde_json::from_str(data) {
            Ok(Answer::Event { text }) => say!("{text}"),
            Ok(Answer::Progress(progress))
                if self.progress.is_none_or(|at| at.elapsed() >= LINE_EVERY) =>
            {
                self.progress = Some(Instant::now());
                show_progress(&progress);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_is_read_to_its_end_or_its_break() {
        let mut shown = Shown::default();
        let cut = "id: 7\nevent: event\ndata: {\"answer\": \"event\", \"text\": \"hello\"}\n\n\
                   : alive\n\n";
        assert!(!shown.read(cut.as_bytes()));
        assert_eq!(shown.last, 7);
        assert!(shown.read("event: end\ndata: {}\n\nevent: event\n".as_bytes()));
    }
}
