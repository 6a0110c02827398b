//! Sessions of browsers: a token is exchanged for a cookie that no script can read.

use super::App;
use super::guard::{COOKIE, is_same_origin};
use super::problem::{Answered, HttpProblem};
use crate::serve::api::About;
use crate::serve::tokens::{self, Identity};
use axum::Json;
use axum::extract::{ConnectInfo, Extension, State};
use axum::http::StatusCode;
use axum::http::header::{HeaderMap, SET_COOKIE};
use axum::response::IntoResponse;
use serde::Deserialize;
use std::net::SocketAddr;

/// Token of a user.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Login {
    token: String,
}

/// Begins a session.
pub async fn login(
    State(app): State<App>,
    ConnectInfo(address): ConnectInfo<SocketAddr>,
    headers: HeaderMap,
    Json(login): Json<Login>,
) -> Answered<impl IntoResponse> {
    if !is_same_origin(&app, &headers) {
        let why = "sessions begin on the page of the service only";
        return Err(HttpProblem(StatusCode::FORBIDDEN, why.into()));
    }
    let hash = tokens::hash(&login.token);
    if app.keeper.store.token(hash.clone()).await?.is_none() {
        return Err(app.guard.count_wrong(address.ip()));
    }
    let secret = app.guard.open_session(hash)?;
    let secure = if app.guard.settings.is_secure { "; Secure" } else { "" };
    let cookie = format!("{COOKIE}={secret}; Path=/; HttpOnly; SameSite=Strict{secure}");
    Ok((StatusCode::NO_CONTENT, [(SET_COOKIE, cookie)]))
}

/// Ends a session.
pub async fn logout(State(app): State<App>, headers: HeaderMap) -> impl IntoResponse {
    app.guard.leave(&headers);
    let cookie = format!("{COOKIE}=; Path=/; HttpOnly; SameSite=Strict; Max-Age=0");
    (StatusCode::NO_CONTENT, [(SET_COOKIE, cookie)])
}

/// Says what the token may do, and what the service offers.
#[utoipa::path(get, path = "/api/about", responses((status = 200, body = About)))]
pub async fn about(
    State(app): State<App>,
    Extension(identity): Extension<Identity>,
) -> Json<About> {
    let launchers = app.keeper.launchers.iter();
    Json(About {
        name: identity.name,
        role: identity.role.name().into(),
        launchers: launchers.map(|(name, l)| (name.to_string(), l.limit().workers)).collect(),
        version: env!("CARGO_PKG_VERSION").into(),
    })
}
