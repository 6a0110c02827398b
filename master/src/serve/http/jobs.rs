//! Lists of jobs, one job, and orders to the queue.

use super::App;
use super::guard::{Detail, may_order, require};
use super::problem::{Answered, HttpProblem};
use crate::cli::Role;
use crate::input::findings::Findings;
use crate::run::checkpoint::find::newest_cycle;
use crate::serve::api::{AuditEntry, JobPage, JobState, Refusal, ResumeRequest, ServiceJob};
use crate::serve::store::{Filter, StoredJob};
use crate::serve::tokens::Identity;
use axum::Json;
use axum::extract::{Extension, Path, Query, State};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use strum::IntoEnumIterator;
use utoipa::IntoParams;

/// Largest page of a list.
const LARGEST_PAGE: u32 = 500;

/// Filters and page of a list.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct ListQuery {
    /// Only jobs in this state.
    state: Option<String>,
    /// Only jobs of this token.
    owner: Option<String>,
    /// Only jobs whose name contains this text.
    name: Option<String>,
    /// Only jobs with smaller numbers: `next` of the page before.
    before: Option<i64>,
    /// Number of jobs, at most 500; 50 without it.
    limit: Option<u32>,
}

/// Lists jobs, the newest first.
#[utoipa::path(get, path = "/api/jobs", params(ListQuery), responses(
    (status = 200, body = JobPage), (status = 422, body = Refusal)))]
pub async fn list(
    State(app): State<App>,
    Query(query): Query<ListQuery>,
) -> Answered<Json<JobPage>> {
    let state = match query.state.as_deref() {
        None => None,
        Some(name) => Some(name.parse().map_err(|_| {
            let names: Vec<_> = JobState::iter().map(JobState::name).collect();
            HttpProblem::bad(format!("there is no such state; these are: {}", names.join(", ")))
        })?),
    };
    let limit = query.limit.unwrap_or(50).clamp(1, LARGEST_PAGE);
    let ListQuery { owner, name, before, .. } = query;
    let filter = Filter { state, owner, name, before, limit };
    let (jobs, total) = app.keeper.store.list(filter).await?;
    let is_full = jobs.len() == limit as usize;
    let next = jobs.last().map(|job| job.id).filter(|_| is_full);
    Ok(Json(JobPage { jobs, total, next }))
}

/// Returns a job, or a refusal.
pub async fn found(app: &App, id: i64) -> Answered<StoredJob> {
    let found = app.keeper.store.job(id).await?;
    found.ok_or_else(|| HttpProblem::absent(format!("there is no job {id}")))
}

/// Returns one job.
#[utoipa::path(get, path = "/api/jobs/{id}", params(("id" = i64, Path, description = "job")),
    responses((status = 200, body = ServiceJob), (status = 404, body = Refusal)))]
pub async fn one(State(app): State<App>, Path(id): Path<i64>) -> Answered<Json<ServiceJob>> {
    Ok(Json(found(&app, id).await?.job))
}

/// Returns what `crumple check` found in a job.
#[utoipa::path(get, path = "/api/jobs/{id}/check",
    params(("id" = i64, Path, description = "job")),
    responses((status = 200, body = Findings), (status = 404, body = Refusal)))]
pub async fn findings(State(app): State<App>, Path(id): Path<i64>) -> Answered<Json<Findings>> {
    found(&app, id).await?;
    let read = tokio::fs::read(app.keeper.root.job(id).findings()).await;
    let read = read.map_err(|_| HttpProblem::absent("the job has not been checked yet"))?;
    serde_json::from_slice(&read).map(Json).map_err(HttpProblem::internal)
}

/// Returns the last progress of a run, as on its socket.
#[utoipa::path(get, path = "/api/jobs/{id}/progress",
    params(("id" = i64, Path, description = "job")),
    responses((status = 200, description = "a line `progress`", content_type = "application/json"),
              (status = 404, body = Refusal)))]
pub async fn progress(State(app): State<App>, Path(id): Path<i64>) -> Answered<Response> {
    found(&app, id).await?;
    let line = app.keeper.live.progress(id);
    let line =
        line.ok_or_else(|| HttpProblem::absent("the job does not run, or has just begun"))?;
    Ok(([(CONTENT_TYPE, "application/json")], line.to_string()).into_response())
}

/// How a job is stopped.
#[derive(Debug, Deserialize, IntoParams)]
pub struct StopQuery {
    /// Kill the processes of a job that was asked to stop and does not.
    #[serde(default)]
    force: bool,
}

/// Stops a job: one that waits never starts, one that runs keeps its state. With `force`, a job
/// that was asked before is killed: it keeps the state of its last checkpoint.
#[utoipa::path(post, path = "/api/jobs/{id}/stop",
    params(("id" = i64, Path, description = "job"), StopQuery),
    responses((status = 202, body = ServiceJob), (status = 403, body = Refusal),
              (status = 404, body = Refusal), (status = 409, body = Refusal)))]
pub async fn stop(
    State(app): State<App>,
    Extension(identity): Extension<Identity>,
    Path(id): Path<i64>,
    Query(query): Query<StopQuery>,
) -> Answered<Response> {
    let stored = found(&app, id).await?;
    may_order(&identity, &stored.job.owner)?;
    let active = matches!(stored.job.state, JobState::Starting | JobState::Running);
    if query.force && active && !stored.job.stopping {
        return Err(HttpProblem::conflict(
            "the job was not asked to stop: ask it first, without force; it then keeps its state",
        ));
    }
    if app.keeper.store.stop(id, identity.name, query.force).await?.is_none() {
        return Err(HttpProblem::conflict(format!(
            "the job is {} already",
            stored.job.state.name()
        )));
    }
    app.keeper.announce(id).await.map_err(HttpProblem::internal)?;
    app.keeper.wake.notify_one();
    let detail = Detail(if query.force { "force" } else { "" }.into());
    let job = Json(found(&app, id).await?.job);
    Ok((Extension(detail), (StatusCode::ACCEPTED, job)).into_response())
}

/// Starts a job that was only checked, or continues one from its newest checkpoint.
#[utoipa::path(post, path = "/api/jobs/{id}/resume", request_body = ResumeRequest,
    params(("id" = i64, Path, description = "job")),
    responses((status = 202, body = ServiceJob), (status = 403, body = Refusal),
              (status = 404, body = Refusal), (status = 409, body = Refusal),
              (status = 422, body = Refusal)))]
pub async fn resume(
    State(app): State<App>,
    Extension(identity): Extension<Identity>,
    Path(id): Path<i64>,
    body: Option<Json<ResumeRequest>>,
) -> Answered<Response> {
    let job = found(&app, id).await?.job;
    may_order(&identity, &job.owner)?;
    let Json(change) = body.unwrap_or_default();
    super::submit::check_sets(&change.set)?;
    let workers = change.workers.unwrap_or(job.workers);
    super::submit::check_workers(&app, &job.launcher, workers)?;
    let folder = app.keeper.root.job(id);
    if job.state == JobState::Completed && newest_cycle(&folder.results()).is_none() {
        return Err(HttpProblem::conflict("the job is complete and has no checkpoint"));
    }
    let detail = format!("workers={workers} {}", change.set.join(" "));
    if !app.keeper.store.resume(id, workers, change.set).await? {
        return Err(HttpProblem::conflict(format!("the job is {}", job.state.name())));
    }
    app.keeper.announce(id).await.map_err(HttpProblem::internal)?;
    app.keeper.wake.notify_one();
    let answer = (StatusCode::ACCEPTED, Json(found(&app, id).await?.job));
    Ok((Extension(Detail(detail)), answer).into_response())
}

/// Returns the newest orders, for admins.
#[utoipa::path(get, path = "/api/audit", responses(
    (status = 200, body = Vec<AuditEntry>), (status = 403, body = Refusal)))]
pub async fn audit(
    State(app): State<App>,
    Extension(identity): Extension<Identity>,
) -> Answered<Json<Vec<AuditEntry>>> {
    require(&identity, Role::Admin)?;
    Ok(Json(app.keeper.store.audit_log(LARGEST_PAGE).await?))
}
