//! Checks of every request: the name of the host, the token, the rate, the time. Every order
//! goes into the audit log.

use super::problem::HttpProblem;
use super::{App, HttpSettings};
use crate::cli::Role;
use crate::serve::api::AuditEntry;
use crate::serve::store::now;
use crate::serve::tokens::{self, Identity};
use axum::extract::{ConnectInfo, Request, State};
use axum::http::header::{self, HeaderMap, HeaderName, HeaderValue};
use axum::http::{Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};
use std::collections::HashMap;
use std::net::{IpAddr, SocketAddr};
use std::num::NonZeroU32;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longest time until an answer begins, except for submissions.
const ANSWER_WITHIN: Duration = Duration::from_secs(150);
/// Longest time of a submission.
const SUBMIT_WITHIN: Duration = Duration::from_secs(3600);
/// Wrong tokens per minute and address.
const WRONG_TOKENS: u32 = 30;
/// Longest session of a browser.
const SESSION: Duration = Duration::from_secs(12 * 3600);
/// Largest number of sessions.
const MOST_SESSIONS: usize = 1000;
/// Cookie of a session.
pub const COOKIE: &str = "crumple_session";

/// Sessions and limits.
pub struct Guard {
    /// Settings.
    pub settings: HttpSettings,
    /// Sessions of browsers, by the hash of their cookie.
    sessions: Mutex<HashMap<String, Session>>,
    by_token: DefaultKeyedRateLimiter<String>,
    wrong: DefaultKeyedRateLimiter<IpAddr>,
}

struct Session {
    /// Hash of the token; a token that is removed ends its sessions.
    token: String,
    until: Instant,
}

fn count(n: u32) -> NonZeroU32 {
    NonZeroU32::new(n).unwrap_or(NonZeroU32::MIN)
}

impl Guard {
    /// Returns a guard without sessions.
    pub fn new(settings: HttpSettings) -> Self {
        let rate = count(settings.rate);
        let quota = Quota::per_second(rate).allow_burst(rate.saturating_mul(count(2)));
        Self {
            settings,
            sessions: Mutex::default(),
            by_token: RateLimiter::keyed(quota),
            wrong: RateLimiter::keyed(Quota::per_minute(count(WRONG_TOKENS))),
        }
    }

    fn sessions<T>(&self, body: impl FnOnce(&mut HashMap<String, Session>) -> T) -> T {
        body(&mut self.sessions.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Begins a session and returns its secret.
    ///
    /// # Errors
    /// The system has no random numbers.
    pub fn open_session(&self, token: String) -> std::io::Result<String> {
        let secret = tokens::secret()?;
        let session = Session { token, until: Instant::now() + SESSION };
        self.sessions(|all| {
            let now = Instant::now();
            all.retain(|_, session| session.until > now);
            if all.len() >= MOST_SESSIONS
                && let Some(oldest) =
                    all.iter().min_by_key(|(_, s)| s.until).map(|(key, _)| key.clone())
            {
                all.remove(&oldest);
            }
            all.insert(tokens::hash(&secret), session)
        });
        Ok(secret)
    }

    /// Ends the session of a request.
    pub fn leave(&self, headers: &HeaderMap) {
        if let Some(secret) = cookie(headers) {
            self.sessions(|all| all.remove(&tokens::hash(&secret)));
        }
    }

    /// Counts a wrong token and returns the refusal. A token has 256 bits, so a limit would not
    /// make it harder to guess; the code shows an administrator that someone tries.
    pub fn count_wrong(&self, address: IpAddr) -> HttpProblem {
        self.wrong.retain_recent();
        match self.wrong.check_key(&address) {
            Ok(()) => HttpProblem(
                StatusCode::UNAUTHORIZED,
                "give a valid token, as `Authorization: Bearer TOKEN`".into(),
            ),
            Err(_) => HttpProblem(
                StatusCode::TOO_MANY_REQUESTS,
                "too many wrong tokens; wait a minute".into(),
            ),
        }
    }
}

/// Returns the secret of the session cookie; none if there are two.
fn cookie(headers: &HeaderMap) -> Option<String> {
    let all = headers.get_all(header::COOKIE);
    let pairs = all.iter().filter_map(|value| value.to_str().ok()).flat_map(|v| v.split(';'));
    let mut own = pairs.filter_map(|pair| pair.trim().strip_prefix(COOKIE)?.strip_prefix('='));
    let secret = own.next()?.to_string();
    own.next().is_none().then_some(secret)
}

/// Returns the token of the header; an error if the header is no such thing.
fn bearer(headers: &HeaderMap) -> Result<Option<String>, ()> {
    let mut all = headers.get_all(header::AUTHORIZATION).iter();
    let Some(value) = all.next() else { return Ok(None) };
    let token = value.to_str().ok().and_then(|text| text.strip_prefix("Bearer "));
    let is_one = |token: &&str| token.len() == 64 && token.bytes().all(|b| b.is_ascii_hexdigit());
    match (token.filter(is_one), all.next()) {
        (Some(token), None) => Ok(Some(token.to_string())),
        _ => Err(()),
    }
}

/// Finds the token of a request, and checks its rate. Orders go into the audit log.
pub async fn identify(
    State(app): State<App>,
    ConnectInfo(address): ConnectInfo<SocketAddr>,
    mut request: Request,
    next: Next,
) -> Response {
    let identity = match identity(&app, address.ip(), request.headers(), request.method()).await {
        Ok(identity) => identity,
        Err(problem) => return problem.into_response(),
    };
    if app.guard.by_token.check_key(&identity.name).is_err() {
        let why = "too many requests; wait a second";
        return HttpProblem(StatusCode::TOO_MANY_REQUESTS, why.into()).into_response();
    }
    let is_order = is_order(request.method());
    let what = format!("{} {}", request.method(), request.uri().path());
    let who = identity.name.clone();
    request.extensions_mut().insert(identity);
    let response = next.run(request).await;
    if is_order {
        let job = what.split("/api/jobs/").nth(1).and_then(|rest| rest.split('/').next());
        let job = job
            .and_then(|id| id.parse().ok())
            .or_else(|| response.extensions().get::<Subject>().map(|subject| subject.0));
        let detail = response.extensions().get::<Detail>().map(|d| d.0.clone()).unwrap_or_default();
        let status = response.status().as_u16();
        let entry = AuditEntry { at: now(), who, what, job, detail, status };
        if let Err(error) = app.keeper.store.audit(entry).await {
            tracing::error!(%error, "an order is not in the audit log");
        }
    }
    response
}

/// Details of an order for the audit log, as an extension of its answer.
#[derive(Clone)]
pub struct Detail(pub String);

/// Job of an order that is not in its path.
#[derive(Clone)]
pub struct Subject(pub i64);

fn is_order(method: &Method) -> bool {
    !matches!(*method, Method::GET | Method::HEAD | Method::OPTIONS)
}

async fn identity(
    app: &App,
    address: IpAddr,
    headers: &HeaderMap,
    method: &Method,
) -> Result<Identity, HttpProblem> {
    let guard = &app.guard;
    let hash = match bearer(headers) {
        Err(()) => return Err(guard.count_wrong(address)),
        Ok(Some(token)) => tokens::hash(&token),
        Ok(None) => {
            let secret = cookie(headers).map(|secret| tokens::hash(&secret));
            let token = secret.and_then(|secret| {
                guard.sessions(|all| {
                    let session = all.get(&secret).filter(|s| s.until > Instant::now());
                    session.map(|session| session.token.clone())
                })
            });
            let Some(token) = token else {
                let why = "give a token, as `Authorization: Bearer TOKEN`";
                return Err(HttpProblem(StatusCode::UNAUTHORIZED, why.into()));
            };
            // Another page of the same machine would send the cookie too.
            if is_order(method) && !is_same_origin(app, headers) {
                let why = "orders with a cookie are taken from the page of the service only";
                return Err(HttpProblem(StatusCode::FORBIDDEN, why.into()));
            }
            token
        }
    };
    match app.keeper.store.token(hash).await? {
        Some(identity) => Ok(identity),
        None => Err(guard.count_wrong(address)),
    }
}

/// Returns true if the request comes from a page of the service.
pub fn is_same_origin(app: &App, headers: &HeaderMap) -> bool {
    let scheme = if app.guard.settings.is_secure { "https" } else { "http" };
    let text = |name: HeaderName| headers.get(name).and_then(|value| value.to_str().ok());
    match (text(header::ORIGIN), text(header::HOST)) {
        (Some(origin), Some(host)) => origin == format!("{scheme}://{host}"),
        _ => false,
    }
}

/// Checks the name of the host, so that no foreign name can lead a browser here, and bounds the
/// time of a request.
pub async fn bound(State(app): State<App>, request: Request, next: Next) -> Response {
    app.counters.count_request();
    let host = request.headers().get(header::HOST).and_then(|value| value.to_str().ok());
    if !host.is_some_and(|host| app.guard.settings.hosts.iter().any(|own| own == host)) {
        let why = "the service has another name; add this one with --host";
        return HttpProblem(StatusCode::MISDIRECTED_REQUEST, why.into()).into_response();
    }
    let is_submission = *request.method() == Method::POST && request.uri().path() == "/api/jobs";
    let limit = if is_submission { SUBMIT_WITHIN } else { ANSWER_WITHIN };
    match tokio::time::timeout(limit, next.run(request)).await {
        Ok(response) => {
            if response.status().is_client_error() {
                app.counters.count_refused();
            }
            response
        }
        Err(_) => {
            let why = "the request took too long";
            HttpProblem(StatusCode::REQUEST_TIMEOUT, why.into()).into_response()
        }
    }
}

/// Headers of all answers.
pub async fn headers(request: Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    let policy = "default-src 'none'; script-src 'self'; style-src 'self'; \
                  connect-src 'self'; img-src 'self' data:; frame-ancestors 'none'; \
                  base-uri 'none'; form-action 'self'";
    headers.entry(header::CONTENT_SECURITY_POLICY).or_insert(HeaderValue::from_static(policy));
    for (name, value) in [
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
}

/// Answers requests for paths that do not exist.
pub async fn no_such_path() -> HttpProblem {
    HttpProblem::absent("there is no such path; see /api/openapi.json")
}

/// Answers requests by methods that a path does not have.
pub async fn no_such_method() -> HttpProblem {
    let why = "the path has no method of this name; see /api/openapi.json";
    HttpProblem(StatusCode::METHOD_NOT_ALLOWED, why.into())
}

/// Checks that a token has a role.
///
/// # Errors
/// It has a lesser one.
pub fn require(identity: &Identity, role: Role) -> Result<(), HttpProblem> {
    match identity.role >= role {
        true => Ok(()),
        false => {
            let why = format!(
                "the token {} has the role {}; this needs {}",
                identity.name,
                identity.role.name(),
                role.name()
            );
            Err(HttpProblem(StatusCode::FORBIDDEN, why))
        }
    }
}

/// Checks that a token may give orders to a job of this owner.
///
/// # Errors
/// It may not.
pub fn may_order(identity: &Identity, owner: &str) -> Result<(), HttpProblem> {
    require(identity, Role::Submit)?;
    match identity.role == Role::Admin || identity.name == owner {
        true => Ok(()),
        false => Err(HttpProblem(
            StatusCode::FORBIDDEN,
            format!("the job belongs to {owner}; only {owner} and admins give it orders"),
        )),
    }
}
