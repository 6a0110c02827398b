//! Files of a job, whole or in part.

use super::App;
use super::jobs::found;
use super::problem::{Answered, Problem};
use crate::serve::api::{FileEntry, Refusal};
use axum::Json;
use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::header::{self, HeaderMap, HeaderName};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use std::io::{ErrorKind, SeekFrom};
use tokio::io::{AsyncReadExt, AsyncSeekExt};
use tokio_util::io::ReaderStream;

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
    let files = files.map_err(Problem::internal)?.into_iter();
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
    headers: HeaderMap,
) -> Answered<Response> {
    found(&app, id).await?;
    let path = app.keeper.root.job(id).readable(&name).map_err(|error| match error.kind() {
        ErrorKind::InvalidInput => Problem::bad(error.to_string()),
        _ => Problem::absent("the job has no such file"),
    })?;
    let mut file = tokio::fs::File::open(&path).await?;
    let size = file.metadata().await?.len();
    let part = match headers.get(header::RANGE) {
        None => None,
        Some(range) => match range.to_str().ok().and_then(|text| Range::parse(text, size)) {
            Some(range) => Some(range),
            None => {
                let why = format!("Range: give one range of bytes below {size}");
                let problem = Problem(StatusCode::RANGE_NOT_SATISFIABLE, why);
                return Ok(
                    ([(header::CONTENT_RANGE, format!("bytes */{size}"))], problem).into_response()
                );
            }
        },
    };
    let Range { from, length } = part.unwrap_or(Range { from: 0, length: size });
    file.seek(SeekFrom::Start(from)).await?;
    let body = Body::from_stream(ReaderStream::with_capacity(file.take(length), 64 * 1024));
    let mut response = body.into_response();
    let mut set = |name: HeaderName, value: String| {
        if let Ok(value) = HeaderValue::from_str(&value) {
            response.headers_mut().insert(name, value);
        }
    };
    set(header::ACCEPT_RANGES, "bytes".into());
    set(header::CONTENT_LENGTH, length.to_string());
    let is_report = name == "results/report.html";
    let (kind, shown) = match name.rsplit('.').next() {
        _ if is_report => ("text/html; charset=utf-8", true),
        Some("json" | "jsonl") => ("application/json", true),
        Some("csv") => ("text/csv; charset=utf-8", true),
        Some("txt" | "toml" | "k" | "key" | "dyn" | "log") => ("text/plain; charset=utf-8", true),
        _ => ("application/octet-stream", false),
    };
    set(header::CONTENT_TYPE, kind.into());
    if is_report {
        set(header::CONTENT_SECURITY_POLICY, REPORT_POLICY.into());
    }
    if !shown {
        set(header::CONTENT_DISPOSITION, "attachment".into());
    }
    if part.is_some() {
        set(header::CONTENT_RANGE, format!("bytes {from}-{}/{size}", from + length - 1));
        *response.status_mut() = StatusCode::PARTIAL_CONTENT;
    }
    Ok(response)
}

/// Part of a file [byte].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    from: u64,
    length: u64,
}

impl Range {
    /// Reads `bytes=from-to`, `bytes=from-` or `bytes=-last`; none if it is no single range within
    /// the file.
    fn parse(text: &str, size: u64) -> Option<Self> {
        let (from, to) = text.strip_prefix("bytes=")?.split_once('-')?;
        let number = |text: &str| match text.bytes().all(|b| b.is_ascii_digit()) {
            true => text.parse::<u64>().ok(),
            false => None,
        };
        let (from, end) = match (from, to) {
            ("", last) => (size.saturating_sub(number(last)?), size),
            (from, "") => (number(from)?, size),
            (from, to) => (number(from)?, number(to)?.checked_add(1)?.min(size)),
        };
        (from < end).then(|| Self { from, length: end - from })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_single_and_within_the_file() {
        for (text, part) in [
            ("bytes=0-9", Some((0, 10))),
            ("bytes=5-", Some((5, 95))),
            ("bytes=-10", Some((90, 10))),
            ("bytes=-1000", Some((0, 100))),
            ("bytes=90-1000", Some((90, 10))),
            ("bytes=100-", None),
            ("bytes=9-8", None),
            ("bytes=-0", None),
            ("bytes=-", None),
            ("bytes=0-1,5-6", None),
            ("bytes=+1-2", None),
            ("bytes=0-18446744073709551615", None),
            ("lines=0-1", None),
            ("", None),
        ] {
            let found = Range::parse(text, 100).map(|range| (range.from, range.length));
            assert_eq!(found, part, "{text}");
        }
        assert_eq!(Range::parse("bytes=0-", 0), None);
    }
}
