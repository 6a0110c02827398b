//! The newest state of a job as a picture.

use super::App;
use super::jobs::found;
use super::problem::{Answered, HttpProblem};
use crate::serve::api::Refusal;
use axum::extract::{Path, Query, State};
use axum::http::header::{CONTENT_TYPE, ETAG, IF_NONE_MATCH};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::IntoParams;

/// Choice of the state.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct ViewQuery {
    /// The newest output up to this time; without it, the present state.
    time: Option<f64>,
}

/// Returns the newest state of a job, for the 3D view: the description `model` and the bytes
/// `picture` (base64 of zlib; `master/src/results/report/encode.rs` has the format), at most
/// 100,000 triangles.
#[utoipa::path(get, path = "/api/jobs/{id}/view",
    params(("id" = i64, Path, description = "job"), ViewQuery,
           ("If-None-Match" = Option<String>, Header, description = "`ETag` of an answer before")),
    responses((status = 200, description = "the state", content_type = "application/json"),
              (status = 204, description = "the job has written no state yet"),
              (status = 304, description = "the state has not changed"),
              (status = 404, body = Refusal), (status = 503, body = Refusal)))]
pub async fn view(
    State(app): State<App>,
    Path(id): Path<i64>,
    Query(query): Query<ViewQuery>,
    headers: HeaderMap,
) -> Answered<Response> {
    found(&app, id).await?;
    let folder = app.keeper.root.job(id);
    let newest = match query.time {
        Some(time) => app.keeper.views.at(&folder, time).await,
        None => app.keeper.views.newest(id, &folder).await,
    };
    let newest = newest.map_err(|why| HttpProblem(StatusCode::SERVICE_UNAVAILABLE, why))?;
    let Some(picture) = newest else { return Ok(StatusCode::NO_CONTENT.into_response()) };
    let known =
        headers.get(IF_NONE_MATCH).is_some_and(|tag| tag.as_bytes() == picture.tag.as_bytes());
    let tag = [(ETAG, picture.tag)];
    Ok(match known {
        true => (StatusCode::NOT_MODIFIED, tag).into_response(),
        false => {
            let kind = [(CONTENT_TYPE, "application/json")];
            (tag, kind, picture.text.to_string()).into_response()
        }
    })
}
