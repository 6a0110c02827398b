//! Events of a job as a stream (server-sent events). A client that was cut off continues by the
//! header `Last-Event-ID`.

use super::App;
use super::jobs::found;
use super::problem::{Answered, HttpProblem};
use crate::serve::api::Refusal;
use crate::serve::live::LiveLine;
use axum::extract::{Path, Query, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::IntoResponse;
use axum::response::sse::{Event, KeepAlive, Sse};
use futures_util::stream::{self, Stream};
use serde::Deserialize;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::OwnedSemaphorePermit;
use tokio::sync::broadcast::{Receiver, error::RecvError};
use utoipa::IntoParams;

/// Events that are read at once.
const BATCH: u32 = 200;
/// Interval between two signs of life.
const ALIVE_EVERY: Duration = Duration::from_secs(15);

/// Where the stream begins.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct EventQuery {
    /// Only events with larger numbers; as the header `Last-Event-ID`.
    after: Option<i64>,
}

/// Streams the events of a job: `state` with the job, `event` and `progress` with a line of the
/// run. It ends with `end` when the job has ended.
#[utoipa::path(get, path = "/api/jobs/{id}/events",
    params(("id" = i64, Path, description = "job"), EventQuery),
    responses((status = 200, description = "events", content_type = "text/event-stream"),
              (status = 404, body = Refusal), (status = 503, body = Refusal)))]
pub async fn events(
    State(app): State<App>,
    Path(id): Path<i64>,
    Query(query): Query<EventQuery>,
    headers: HeaderMap,
) -> Answered<impl IntoResponse> {
    found(&app, id).await?;
    let place = app.counters.places.clone().try_acquire_owned().map_err(|_| {
        let why = "the service has too many watchers";
        HttpProblem(StatusCode::SERVICE_UNAVAILABLE, why.into())
    })?;
    let last = headers.get("last-event-id").and_then(|value| value.to_str().ok());
    let last = match last.filter(|text| !text.is_empty()) {
        Some(text) => {
            Some(text.parse().map_err(|_| HttpProblem::bad("Last-Event-ID: give a number"))?)
        }
        None => query.after,
    };
    let (lines, progress) = app.keeper.live.subscribe(id);
    let mut ready = VecDeque::new();
    ready.extend(progress.map(|data| LiveLine { id: None, kind: "progress", data }));
    let watcher = Watcher {
        app,
        id,
        last: last.unwrap_or(0),
        lines,
        ready,
        behind: true,
        ended: false,
        _place: place,
    };
    Ok(Sse::new(watcher.stream()).keep_alive(KeepAlive::new().interval(ALIVE_EVERY)))
}

struct Watcher {
    app: App,
    id: i64,
    /// Number of the last event that was sent.
    last: i64,
    lines: Receiver<LiveLine>,
    ready: VecDeque<LiveLine>,
    /// True if the database may have events that were not sent.
    behind: bool,
    ended: bool,
    _place: OwnedSemaphorePermit,
}

impl Watcher {
    fn stream(self) -> impl Stream<Item = Result<Event, Infallible>> {
        stream::unfold(self, |mut watcher| async move {
            let line = watcher.next().await?;
            let event = Event::default().event(line.kind).data(&*line.data);
            let event = match line.id {
                Some(id) => event.id(id.to_string()),
                None => event,
            };
            Some((Ok(event), watcher))
        })
    }

    async fn next(&mut self) -> Option<LiveLine> {
        loop {
            if let Some(line) = self.ready.pop_front() {
                return Some(line);
            }
            if self.ended {
                return None;
            }
            if self.behind {
                self.read().await?;
                continue;
            }
            match self.lines.recv().await {
                Ok(LiveLine { id: Some(id), .. }) if id <= self.last => {}
                Ok(line) => {
                    self.last = line.id.unwrap_or(self.last);
                    self.behind = line.kind == "state"; // it may be the last one
                    return Some(line);
                }
                Err(RecvError::Lagged(_)) => self.behind = true,
                Err(RecvError::Closed) => return None,
            }
        }
    }

    /// Reads events that were missed. Ends the stream if none will follow.
    async fn read(&mut self) -> Option<()> {
        let store = &self.app.keeper.store;
        // In this order: an event that comes between the two is read.
        let is_final = store.job(self.id).await.ok()??.job.state.is_final();
        let events = store.events(self.id, self.last, BATCH).await.ok()?;
        let all = events.len() < BATCH as usize;
        for event in events {
            self.last = event.id;
            let kind = if event.kind == "state" { "state" } else { "event" };
            self.ready.push_back(LiveLine { id: Some(event.id), kind, data: event.data.into() });
        }
        if all {
            self.behind = false;
            self.ended = is_final;
            if is_final {
                self.ready.push_back(LiveLine { id: None, kind: "end", data: Arc::from("{}") });
            }
        }
        Some(())
    }
}
