//! Refusals as answers.

use crate::serve::api::Refusal;
use crate::serve::intake::IntakeFault;
use axum::Json;
use axum::body::to_bytes;
use axum::extract::Request;
use axum::http::{StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// A refusal: status code and reason.
#[derive(Debug)]
pub struct HttpProblem(pub StatusCode, pub String);

/// Answer of a handler.
pub type Answered<T> = Result<T, HttpProblem>;

impl HttpProblem {
    /// A request that cannot be understood or is out of range.
    pub fn bad(why: impl Into<String>) -> Self {
        Self(StatusCode::UNPROCESSABLE_ENTITY, why.into())
    }

    /// Something that does not exist.
    pub fn absent(what: impl Into<String>) -> Self {
        Self(StatusCode::NOT_FOUND, what.into())
    }

    /// An order that does not fit the state.
    pub fn conflict(why: impl Into<String>) -> Self {
        Self(StatusCode::CONFLICT, why.into())
    }

    /// A failure of the service. The cause goes to its log only.
    pub fn internal(why: impl std::fmt::Display) -> Self {
        tracing::error!(%why, "a request failed");
        Self(StatusCode::INTERNAL_SERVER_ERROR, "the service failed; see its log".into())
    }
}

impl From<rusqlite::Error> for HttpProblem {
    fn from(error: rusqlite::Error) -> Self {
        Self::internal(error)
    }
}

impl From<IntakeFault> for HttpProblem {
    fn from(fault: IntakeFault) -> Self {
        match fault {
            IntakeFault::Refused(why) => Self::bad(why),
            IntakeFault::TooMuch(why) => Self(StatusCode::PAYLOAD_TOO_LARGE, why),
            IntakeFault::Late(why) => Self(StatusCode::REQUEST_TIMEOUT, why),
            IntakeFault::Full(why) => Self(StatusCode::INSUFFICIENT_STORAGE, why),
            IntakeFault::Failed(error) => error.into(),
        }
    }
}

impl From<std::io::Error> for HttpProblem {
    fn from(error: std::io::Error) -> Self {
        use std::io::ErrorKind::{QuotaExceeded, StorageFull};
        match error.kind() {
            StorageFull | QuotaExceeded => {
                Self(StatusCode::INSUFFICIENT_STORAGE, "the disk of the service is full".into())
            }
            _ => Self::internal(error),
        }
    }
}

impl IntoResponse for HttpProblem {
    fn into_response(self) -> Response {
        (self.0, Json(Refusal { error: self.1 })).into_response()
    }
}

/// Largest refusal of the framework that is read [byte].
const LARGEST: usize = 64 * 1024;

/// Gives refusals of the framework, which are plain text, the form of all others.
pub async fn explain(request: Request, next: Next) -> Response {
    let response = next.run(request).await;
    let status = response.status();
    let kind = response.headers().get(header::CONTENT_TYPE);
    let is_text = kind.is_some_and(|kind| kind.as_bytes().starts_with(b"text/plain"));
    if !is_text || !(status.is_client_error() || status.is_server_error()) {
        return response;
    }
    let text = to_bytes(response.into_body(), LARGEST).await.unwrap_or_default();
    HttpProblem(status, String::from_utf8_lossy(&text).into_owned()).into_response()
}
