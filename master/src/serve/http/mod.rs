//! The service over HTTP: routes and what all of them share.

mod events;
mod files;
mod guard;
mod jobs;
pub mod listen;
mod login;
mod metrics;
pub mod openapi;
mod orders;
mod paced;
mod page;
mod problem;
mod submit;
mod view;

use super::disk::Disk;
use super::keeper::Keeper;
use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::middleware::{from_fn, from_fn_with_state};
use axum::routing::{get, post};
use guard::Guard;
use metrics::Counters;
use std::sync::Arc;

/// Largest body of a request other than a submission [byte].
const SMALL_BODY: usize = 64 * 1024;

/// State that all handlers share.
#[derive(Clone)]
pub struct App {
    /// Jobs.
    pub keeper: Arc<Keeper>,
    /// Sessions and limits.
    guard: Arc<Guard>,
    counters: Arc<Counters>,
    /// Largest submission [byte].
    most_bytes: u64,
    disk: Disk,
}

/// Settings of the service over HTTP.
#[derive(Clone, Debug)]
pub struct HttpSettings {
    /// Names under which the service is reached, with the port.
    pub hosts: Vec<String>,
    /// True with TLS.
    pub is_secure: bool,
    /// Largest submission [byte].
    pub most_bytes: u64,
    /// Requests per second and token.
    pub rate: u32,
    /// Where submissions are stored.
    pub disk: Disk,
}

/// Returns the service.
pub fn router(keeper: Arc<Keeper>, settings: HttpSettings) -> Router {
    let (most_bytes, disk) = (settings.most_bytes, settings.disk.clone());
    let (guard, counters) = (Arc::new(Guard::new(settings)), Arc::default());
    let app = App { keeper, guard, counters, most_bytes, disk };
    let largest = usize::try_from(most_bytes).unwrap_or(usize::MAX);
    let submit = Router::new()
        .route("/api/jobs", post(submit::submit))
        .layer(DefaultBodyLimit::max(largest));
    let guarded = Router::new()
        .route("/api/about", get(login::about))
        .route("/api/jobs", get(jobs::list))
        .route("/api/jobs/{id}", get(jobs::one))
        .route("/api/jobs/{id}/check", get(jobs::findings))
        .route("/api/jobs/{id}/stop", post(jobs::stop))
        .route("/api/jobs/{id}/resume", post(jobs::resume))
        .route("/api/jobs/{id}/progress", get(jobs::progress))
        .route("/api/jobs/{id}/view", get(view::view))
        .route("/api/jobs/{id}/events", get(events::events))
        .route("/api/jobs/{id}/orders", post(orders::order))
        .route("/api/jobs/{id}/files", get(files::list))
        .route("/api/jobs/{id}/files/{*path}", get(files::file))
        .route("/api/audit", get(jobs::audit))
        .route("/api/openapi.json", get(openapi::document))
        .route("/logout", post(login::logout))
        .route("/metrics", get(metrics::metrics))
        .layer(DefaultBodyLimit::max(SMALL_BODY))
        .merge(submit)
        .method_not_allowed_fallback(guard::no_such_method)
        .layer(from_fn_with_state(app.clone(), guard::identify));
    let open = Router::new()
        .route("/login", post(login::login))
        .route("/health", get(metrics::health))
        .route("/ready", get(metrics::ready))
        .merge(page::routes())
        .method_not_allowed_fallback(guard::no_such_method)
        .layer(DefaultBodyLimit::max(SMALL_BODY));
    guarded
        .merge(open)
        .fallback(guard::no_such_path)
        .layer(from_fn(problem::explain))
        .layer(from_fn_with_state(app.clone(), guard::bound))
        .layer(from_fn(guard::headers))
        .with_state(app)
}
