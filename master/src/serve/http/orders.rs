//! Orders to a run in progress, passed on to its socket.

use super::App;
use super::guard::{Detail, may_order};
use super::jobs::found;
use super::problem::{Answered, HttpProblem};
use crate::run::request::{Answer, Request};
use crate::serve::api::Refusal;
use crate::serve::live;
use crate::serve::tokens::Identity;
use axum::Json;
use axum::extract::{Extension, Path, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use std::time::Duration;

/// Longest time until an order takes effect.
const EFFECT_WITHIN: Duration = Duration::from_secs(120);

/// Passes an order on to a run, such as `{"request": "pause"}` or `{"request": "set", "key":
/// "end_time", "value": 40.0}`. The answer comes when the order has taken effect.
#[utoipa::path(post, path = "/api/jobs/{id}/orders",
    params(("id" = i64, Path, description = "job")),
    request_body(content = String, content_type = "application/json",
                 description = "a request as on the socket of a run"),
    responses((status = 200, description = "the line of the run",
               content_type = "application/json"),
              (status = 403, body = Refusal), (status = 404, body = Refusal),
              (status = 409, body = Refusal), (status = 422, body = Refusal)))]
pub async fn order(
    State(app): State<App>,
    Extension(identity): Extension<Identity>,
    Path(id): Path<i64>,
    body: String,
) -> Answered<Response> {
    let job = found(&app, id).await?.job;
    may_order(&identity, &job.owner)?;
    let request = Request::from_line(&body).map_err(HttpProblem::bad)?;
    if request == Request::Watch {
        return Err(HttpProblem::bad(format!("the stream is at /api/jobs/{id}/events")));
    }
    if !job.state.is_active() {
        return Err(HttpProblem::conflict(format!("the job is {}", job.state.name())));
    }
    let detail = Extension(Detail(request.to_line().trim().to_string()));
    let folder = app.keeper.root.job(id);
    let asked = tokio::time::timeout(EFFECT_WITHIN, live::ask(&folder, &request)).await;
    let answer = match asked {
        Err(_) => {
            let why = "the order has not taken effect yet; it may do so later";
            return Err(HttpProblem(StatusCode::GATEWAY_TIMEOUT, why.into()));
        }
        Ok(Err(_)) => {
            return Err(HttpProblem::conflict("the run does not answer: it begins or ends"));
        }
        Ok(Ok(answer)) => answer,
    };
    Ok(match answer {
        Answer::Refused { why } => (detail, HttpProblem::conflict(why)).into_response(),
        answer => (detail, Json(answer)).into_response(),
    })
}
