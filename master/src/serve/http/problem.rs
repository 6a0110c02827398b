//! Refusals as answers.

use crate::serve::api::Refusal;
use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};

/// A refusal: status code and reason.
#[derive(Debug)]
pub struct Problem(pub StatusCode, pub String);

/// Answer of a handler.
pub type Answered<T> = Result<T, Problem>;

impl Problem {
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

impl From<rusqlite::Error> for Problem {
    fn from(error: rusqlite::Error) -> Self {
        Self::internal(error)
    }
}

impl From<std::io::Error> for Problem {
    fn from(error: std::io::Error) -> Self {
        Self::internal(error)
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        (self.0, Json(Refusal { error: self.1 })).into_response()
    }
}
