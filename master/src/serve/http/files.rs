//! Files of a job, whole or in part.

use super::App;
use super::jobs::found;
use super::problem::{Answered, HttpProblem};
use crate::serve::api::{FileEntry, Refusal};
use axum::Json;
use axum::body::Body;
use axum::extract::{Path, Request, State};
use axum::http::header::{self, HeaderName};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use std::io::ErrorKind;
use tower_http::services::ServeFile;

/// Policy of the report page, which has its scripts in itself: it cannot reach the service.
const REPORT_POLICY: &str = "sandbox allow-scripts allow-downloads; default-src 'none'; script-src \
                             'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; \
                             connect-src data: blob:; worker-src blob:; frame-ancestors 'none'";

/// Lists the files of a job.
#[utoipa::path(get, path = "/api/jobs/{id}/files",
    params(("id" = i64, Path, description = "job")),
    responses((status = 200, body = Vec<FileEntry>), (status = 404, body = Refusal)))]
pub async fn list(State(app): State<App>, Path(id): Path<i64>) -> Answered<Json<Vec<FileEntry>>> {
    found(&app, id).await?;
    let folder = app.keeper.root.job(id);
    let files = tokio::task::spawn_blocking(move || folder.files()).await;
    let files = files.map_err(HttpProblem::internal)?.into_iter();
    Ok(Json(files.map(|(path, size)| FileEntry { path, size }).collect()))
}

/// Returns a file, or the part that the header `Range` names.
#[utoipa::path(get, path = "/api/jobs/{id}/files/{path}",
    params(("id" = i64, Path, description = "job"),
           ("path" = String, Path, description = "path in the list of files")),
    responses((status = 200, description = "the file", content_type = "application/octet-stream"),
              (status = 206, description = "a part of it"), (status = 404, body = Refusal),
              (status = 416, body = Refusal), (status = 422, body = Refusal)))]
pub async fn file(
    State(app): State<App>,
    Path((id, name)): Path<(i64, String)>,
    request: Request,
) -> Answered<Response> {
    found(&app, id).await?;
    let path = app.keeper.root.job(id).readable(&name).map_err(|error| match error.kind() {
        ErrorKind::InvalidInput => HttpProblem::bad(error.to_string()),
        _ => HttpProblem::absent("the job has no such file"),
    })?;
    let served = ServeFile::new(&path).try_call(request).await?;
    let mut response = served.map(Body::new);
    if response.status() == StatusCode::RANGE_NOT_SATISFIABLE {
        let size = response.headers().get(header::CONTENT_RANGE).cloned();
        let why = "Range: give one range of bytes within the file".to_string();
        let mut refusal = HttpProblem(StatusCode::RANGE_NOT_SATISFIABLE, why).into_response();
        refusal.headers_mut().extend(size.map(|size| (header::CONTENT_RANGE, size)));
        return Ok(refusal);
    }
    let mut set = |name: HeaderName, value: String| {
        if let Ok(value) = HeaderValue::from_str(&value) {
            response.headers_mut().insert(name, value);
        }
    };
    let is_report = name == "results/report.html";
    let (kind, shown) = match name.rsplit('.').next() {
        _ if is_report => ("text/html; charset=utf-8", true),
        Some("json" | "jsonl") => ("application/json", true),
        Some("csv") => ("text/csv; charset=utf-8", true),
        Some("txt" | "toml" | "k" | "key" | "dyn" | "rad" | "log") => {
            ("text/plain; charset=utf-8", true)
        }
        _ => ("application/octet-stream", false),
    };
    set(header::CONTENT_TYPE, kind.into());
    if is_report {
        set(header::CONTENT_SECURITY_POLICY, REPORT_POLICY.into());
    }
    if !shown {
        set(header::CONTENT_DISPOSITION, "attachment".into());
    }
    Ok(response)
}
