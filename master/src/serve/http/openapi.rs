//! Description of the interface, made from the types and handlers.

use super::{events, files, jobs, login, metrics, orders, submit, view};
use crate::input::findings;
use crate::serve::api;
use axum::Json;
use utoipa::OpenApi;

#[derive(OpenApi)]
#[openapi(
    info(
        title = "Crumple service",
        description = "Every path but /health and /ready needs a \
        token, as `Authorization: Bearer TOKEN`.",
        license(name = "MIT OR Apache-2.0")
    ),
    paths(
        login::about,
        jobs::list,
        submit::submit,
        jobs::one,
        jobs::findings,
        jobs::stop,
        jobs::resume,
        jobs::progress,
        view::view,
        events::events,
        orders::order,
        files::list,
        files::file,
        jobs::audit,
        document,
        metrics::metrics,
        metrics::health,
        metrics::ready,
    ),
    components(schemas(
        api::ServiceJob,
        api::JobState,
        api::JobPage,
        api::Submission,
        api::ResumeRequest,
        api::FileEntry,
        findings::Findings,
        findings::Finding,
        findings::Level,
        findings::SourceLine,
        findings::Mark,
        api::AuditEntry,
        api::About,
        api::Refusal,
    ))
)]
struct Document;

/// Returns the description as JSON.
pub fn text() -> String {
    Document::openapi().to_pretty_json().expect("plain data is always JSON") + "\n"
}

/// Returns this description.
#[utoipa::path(get, path = "/api/openapi.json", responses(
    (status = 200, description = "this document", content_type = "application/json")))]
pub async fn document() -> Json<utoipa::openapi::OpenApi> {
    Json(Document::openapi())
}
