//! Counts for Prometheus, and the state of the service.

use super::App;
use super::problem::Answered;
use axum::extract::State;
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;
use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use tokio::sync::Semaphore;

/// Largest number of watchers.
const MOST_WATCHERS: usize = 2000;

/// Counts since the start.
pub struct Counters {
    requests: AtomicI64,
    refused: AtomicI64,
    /// Places for watchers.
    pub places: Arc<Semaphore>,
}

impl Default for Counters {
    fn default() -> Self {
        let places = Arc::new(Semaphore::new(MOST_WATCHERS));
        Self { requests: AtomicI64::new(0), refused: AtomicI64::new(0), places }
    }
}

impl Counters {
    /// Counts a request.
    pub fn count_request(&self) {
        self.requests.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a request that was refused.
    pub fn count_refused(&self) {
        self.refused.fetch_add(1, Ordering::Relaxed);
    }
}

/// Counts for Prometheus.
#[utoipa::path(get, path = "/metrics", responses((status = 200, content_type = "text/plain",
    description = "counts for Prometheus")))]
pub async fn metrics(State(app): State<App>) -> Answered<impl IntoResponse> {
    let mut text = String::new();
    let mut family = |name: &str, kind: &str, help: &str, values: &[(String, i64)]| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "# HELP {name} {help}\n# TYPE {name} {kind}");
        for (labels, value) in values {
            let _ = writeln!(text, "{name}{labels} {value}");
        }
    };
    let one = |value: i64| vec![(String::new(), value)];
    let counts = app.keeper.store.counts().await?;
    let jobs: Vec<_> =
        counts.iter().map(|(state, n)| (format!("{{state=\"{}\"}}", state.name()), *n)).collect();
    family("crumple_jobs", "gauge", "Jobs by state.", &jobs);
    let watchers = MOST_WATCHERS - app.counters.places.available_permits();
    family("crumple_watchers", "gauge", "Open streams of events.", &one(watchers as i64));
    let requests = app.counters.requests.load(Ordering::Relaxed);
    family("crumple_requests_total", "counter", "Requests.", &one(requests));
    let refused = app.counters.refused.load(Ordering::Relaxed);
    family("crumple_refused_total", "counter", "Requests that were refused.", &one(refused));
    if let Some(bytes) = resident() {
        family("process_resident_memory_bytes", "gauge", "Memory of the service.", &one(bytes));
    }
    Ok(([(CONTENT_TYPE, "text/plain; version=0.0.4")], text))
}

/// Returns the memory of this process [byte].
fn resident() -> Option<i64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().trim_end_matches("kB").trim().parse::<i64>().ok().map(|kb| 1024 * kb)
}

/// Says that the process answers.
#[utoipa::path(get, path = "/health", responses((status = 200, description = "it answers")))]
pub async fn health() -> &'static str {
    "ok\n"
}

/// Says whether the database answers.
#[utoipa::path(get, path = "/ready", responses(
    (status = 200, description = "it is ready"), (status = 503, description = "it is not")))]
pub async fn ready(State(app): State<App>) -> impl IntoResponse {
    match app.keeper.store.has_tokens().await {
        Ok(_) => (StatusCode::OK, "ready\n"),
        Err(_) => (StatusCode::SERVICE_UNAVAILABLE, "the database does not answer\n"),
    }
}
