//! The live stream: the service is one client of each run, and passes its lines on to all watchers.

use super::folder::JobFolder;
use super::store::Store;
use crate::run::request::{Answer, Request};
use crate::run::service::socket;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader};
use tokio::net::UnixStream;
use tokio::sync::broadcast;

/// Lines that a watcher may lag behind; then it reads the events from the database.
const MOST_LINES: usize = 64;

/// A line for watchers.
#[derive(Clone, Debug)]
pub struct LiveLine {
    /// Number of a stored event; progress has none.
    pub id: Option<i64>,
    /// `state`, `event` or `progress`.
    pub kind: &'static str,
    /// JSON.
    pub data: Arc<str>,
}

/// All streams.
#[derive(Clone, Default)]
pub struct Live {
    topics: Arc<Mutex<HashMap<i64, Topic>>>,
}

struct Topic {
    lines: broadcast::Sender<LiveLine>,
    /// The last progress, for those who come later.
    progress: Option<Arc<str>>,
}

impl Live {
    fn with<T>(&self, job: i64, body: impl FnOnce(&mut Topic) -> T) -> T {
        let mut topics = self.topics.lock().unwrap_or_else(PoisonError::into_inner);
        body(
            topics.entry(job).or_insert_with(|| Topic {
                lines: broadcast::channel(MOST_LINES).0,
                progress: None,
            }),
        )
    }

    /// Returns the lines of a job from now on, and its last progress.
    pub fn subscribe(&self, job: i64) -> (broadcast::Receiver<LiveLine>, Option<Arc<str>>) {
        self.with(job, |topic| (topic.lines.subscribe(), topic.progress.clone()))
    }

    /// Returns the last progress of a job.
    pub fn progress(&self, job: i64) -> Option<Arc<str>> {
        let topics = self.topics.lock().unwrap_or_else(PoisonError::into_inner);
        topics.get(&job).and_then(|topic| topic.progress.clone())
    }

    /// Sends a line to all watchers.
    pub fn publish(&self, job: i64, line: LiveLine) {
        self.with(job, |topic| {
            if line.kind == "progress" {
                topic.progress = Some(line.data.clone());
            }
            let _ = topic.lines.send(line); // an error means that there are no watchers
        });
    }

    /// Forgets jobs without watchers that do not run.
    pub fn tidy(&self, runs: impl Fn(i64) -> bool) {
        let mut topics = self.topics.lock().unwrap_or_else(PoisonError::into_inner);
        topics.retain(|job, topic| topic.lines.receiver_count() > 0 || runs(*job));
    }

    /// Passes the stream of a run on to watchers until it ends or cannot be reached.
    ///
    /// # Errors
    /// The run does not answer.
    pub async fn relay_stream(
        &self,
        job: i64,
        folder: &JobFolder,
        store: &Store,
    ) -> std::io::Result<()> {
        let mut stream = connect(folder).await?;
        stream.write_all(Request::Watch.to_line().as_bytes()).await?;
        let mut lines = BufReader::new(stream).lines();
        while let Some(line) = lines.next_line().await? {
            match serde_json::from_str(&line) {
                Ok(Answer::Progress(_)) => {
                    let line = LiveLine { id: None, kind: "progress", data: line.into() };
                    self.publish(job, line);
                }
                Ok(Answer::Event { .. }) => match store.add_event(job, "event", line.clone()).await
                {
                    Ok(id) => {
                        self.publish(
                            job,
                            LiveLine { id: Some(id), kind: "event", data: line.into() },
                        );
                    }
                    Err(error) => tracing::error!(%error, job, "an event was not stored"),
                },
                Ok(Answer::Refused { why }) => return Err(std::io::Error::other(why)),
                _ => {}
            }
        }
        Ok(())
    }
}

/// Connects to a run.
async fn connect(folder: &JobFolder) -> std::io::Result<UnixStream> {
    let stream = socket::connect(&folder.results())?;
    stream.set_nonblocking(true)?;
    UnixStream::from_std(stream)
}

/// Passes a request on to a run, and returns its answer.
///
/// # Errors
/// The run does not answer.
pub async fn ask(folder: &JobFolder, request: &Request) -> std::io::Result<Answer> {
    let mut stream = connect(folder).await?;
    stream.write_all(request.to_line().as_bytes()).await?;
    let mut lines = BufReader::new(stream).lines();
    let line = lines.next_line().await?;
    let gone = || std::io::Error::new(std::io::ErrorKind::UnexpectedEof, "the run has ended");
    serde_json::from_str(&line.ok_or_else(gone)?).map_err(std::io::Error::other)
}
