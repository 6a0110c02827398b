//! Submission of jobs: files and options arrive, are stored, and are then checked by the loop.

use super::App;
use super::guard::{Detail, Subject, require};
use super::problem::{Answered, HttpProblem};
use crate::cli::Role;
use crate::serve::api::{Refusal, ServiceJob, Submission};
use crate::serve::archive::{self, ArchiveFormat, ArchiveLimits};
use crate::serve::folder::{JobFolder, relative};
use crate::serve::intake::Intake;
use crate::serve::store::NewJob;
use crate::serve::tokens::Identity;
use axum::Json;
use axum::extract::multipart::{Field, Multipart, MultipartError};
use axum::extract::{Extension, FromRequest, Request, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tokio::io::AsyncWriteExt;
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;

/// Most jobs that wait or run.
const MOST_OPEN: i64 = 20_000;
/// Longest pause of a client that sends files.
const SLOWEST: Duration = Duration::from_secs(30);
/// Longest time in which an archive is unpacked.
const UNPACK_WITHIN: Duration = Duration::from_secs(300);
/// Places for archives that are unpacked at a time.
static UNPACKING: Semaphore = Semaphore::const_new(2);
/// Largest part `options` [byte].
const LARGEST_OPTIONS: usize = 256 * 1024;
/// Most changes of a job, and the longest one [byte].
const MOST_SETS: (usize, usize) = (100, 2000);
/// Longest name [characters].
const LONGEST_NAME: usize = 200;

/// Submits a job.
#[utoipa::path(post, path = "/api/jobs", request_body(content(
    (Submission = "application/json"), (Submission = "multipart/form-data"))),
    responses((status = 201, body = ServiceJob), (status = 403, body = Refusal),
              (status = 413, body = Refusal), (status = 422, body = Refusal)))]
pub async fn submit(
    State(app): State<App>,
    Extension(identity): Extension<Identity>,
    request: Request,
) -> Answered<Response> {
    require(&identity, Role::Submit)?;
    let open = app.keeper.store.open_jobs().await?;
    if open >= MOST_OPEN {
        let why = format!("{open} jobs wait already; try again later");
        return Err(HttpProblem(StatusCode::SERVICE_UNAVAILABLE, why));
    }
    let disk = app.disk.clone();
    let stated = stated_length(&request);
    let room = tokio::task::spawn_blocking(move || disk.room(stated)).await;
    room.map_err(HttpProblem::internal)??;
    let id = app.keeper.store.reserve(identity.name.clone()).await?;
    let folder = app.keeper.root.job(id);
    let arrival = Arc::new(Arrival { app: app.clone(), id, folder, kept: AtomicBool::new(false) });
    let (options, intake) = arrival.receive(request).await?;
    let new = new_job(&app, &identity, options, intake.files())?;
    let detail = format!("{}: {} with {} files", new.name, new.main, intake.files().len());
    app.keeper.store.submit(id, new).await?;
    arrival.kept.store(true, Ordering::Relaxed);
    app.keeper.announce(id).await.map_err(HttpProblem::internal)?;
    app.keeper.wake.notify_one();
    let job = super::jobs::found(&app, id).await?.job;
    let location = [(header::LOCATION, format!("/api/jobs/{id}"))];
    let answer = (StatusCode::CREATED, location, Json(job));
    Ok((Extension(Subject(id)), Extension(Detail(detail)), answer).into_response())
}

/// Returns the size that a request states [byte]; 0 without one.
fn stated_length(request: &Request) -> u64 {
    let length = request.headers().get(header::CONTENT_LENGTH);
    length.and_then(|length| length.to_str().ok()?.parse().ok()).unwrap_or(0)
}

/// A job that arrives. Its files are removed if it does not become a job, after all threads that
/// write them have ended.
struct Arrival {
    app: App,
    id: i64,
    folder: JobFolder,
    kept: AtomicBool,
}

impl Drop for Arrival {
    fn drop(&mut self) {
        if self.kept.load(Ordering::Relaxed) {
            return;
        }
        let (store, id, folder) = (self.app.keeper.store.clone(), self.id, self.folder.clone());
        tokio::spawn(async move {
            // Files that stay are removed at the next start.
            let _ = tokio::fs::remove_dir_all(folder.path()).await;
            let _ = store.forget(id).await;
        });
    }
}

fn broken(error: MultipartError) -> HttpProblem {
    HttpProblem(error.status(), error.body_text())
}

impl Arrival {
    async fn receive(self: &Arc<Self>, request: Request) -> Answered<(Submission, Intake)> {
        tokio::fs::create_dir_all(self.folder.input()).await?;
        let kind = request.headers().get(header::CONTENT_TYPE).cloned();
        let kind = kind.as_ref().and_then(|kind| kind.to_str().ok()).unwrap_or_default();
        if kind.starts_with("multipart/form-data") {
            let parts = Multipart::from_request(request, &()).await;
            let parts = parts.map_err(|error| HttpProblem(error.status(), error.body_text()))?;
            return self.receive_parts(parts).await;
        }
        let parsed = Json::<Submission>::from_request(request, &()).await;
        let Json(mut options) =
            parsed.map_err(|error| HttpProblem(error.status(), error.body_text()))?;
        let given = std::mem::take(&mut options.files);
        let arrival = self.clone();
        let write = move || -> Answered<Intake> {
            let mut intake = Intake::new(arrival.folder.input());
            for (name, text) in given {
                std::io::Write::write_all(&mut intake.create(&name)?, text.as_bytes())?;
            }
            Ok(intake)
        };
        let intake = tokio::task::spawn_blocking(write).await.map_err(HttpProblem::internal)??;
        Ok((options, intake))
    }

    async fn receive_parts(
        self: &Arc<Self>,
        mut parts: Multipart,
    ) -> Answered<(Submission, Intake)> {
        let (mut options, mut has_archive) = (None, false);
        let mut intake = Intake::new(self.folder.input());
        while let Some(part) = in_time(parts.next_field()).await?.map_err(broken)? {
            match part.name() {
                Some("options") if options.is_none() => options = Some(read_options(part).await?),
                Some("file") => {
                    let name = part.file_name().unwrap_or_default().to_string();
                    store(part, intake.create(&name)?).await?;
                }
                Some("archive") if !has_archive => {
                    has_archive = true;
                    intake = self.unpack(part, intake).await?;
                }
                _ => {
                    let why = "give one part `options`, parts `file` and at most one `archive`";
                    return Err(HttpProblem::bad(why));
                }
            }
        }
        Ok((options.unwrap_or_default(), intake))
    }

    /// Stores an archive and unpacks it on a thread of its own.
    async fn unpack(self: &Arc<Self>, part: Field<'_>, mut intake: Intake) -> Answered<Intake> {
        let format =
            ArchiveFormat::of_name(part.file_name().unwrap_or_default()).ok_or_else(|| {
                HttpProblem::bad(
                    "archive: give a file name that ends in .zip, .tar, .tar.gz or .tgz",
                )
            })?;
        let path = self.folder.path().join("archive");
        store(part, std::fs::File::create_new(&path)?).await?;
        let permit = UNPACKING.acquire().await.map_err(HttpProblem::internal)?;
        let gone = CancellationToken::new();
        let _leaves_with_client = gone.clone().drop_guard();
        let arrival = self.clone();
        let unpack = move || -> Answered<Intake> {
            let _permit = permit;
            let app = &arrival.app;
            let most_bytes = app.disk.room(0)?.min(app.most_bytes);
            let limits = ArchiveLimits { most_bytes, until: Instant::now() + UNPACK_WITHIN, gone };
            archive::unpack(&path, format, &mut intake, &limits)?;
            std::fs::remove_file(&path)?;
            Ok(intake)
        };
        tokio::task::spawn_blocking(unpack).await.map_err(HttpProblem::internal)?
    }
}

async fn store(mut part: Field<'_>, file: std::fs::File) -> Answered<()> {
    let mut file = tokio::fs::File::from_std(file);
    while let Some(bytes) = in_time(part.chunk()).await?.map_err(broken)? {
        file.write_all(&bytes).await?;
    }
    Ok(file.flush().await?)
}

/// Waits for a client that sends, as long as it is not too slow.
async fn in_time<T>(next: impl Future<Output = T>) -> Answered<T> {
    let late = |_| HttpProblem(StatusCode::REQUEST_TIMEOUT, "the files arrive too slowly".into());
    tokio::time::timeout(SLOWEST, next).await.map_err(late)
}

async fn read_options(mut part: Field<'_>) -> Answered<Submission> {
    let mut text = Vec::new();
    while let Some(bytes) = in_time(part.chunk()).await?.map_err(broken)? {
        text.extend_from_slice(&bytes);
        if text.len() > LARGEST_OPTIONS {
            let why = format!("options have at most {LARGEST_OPTIONS} bytes");
            return Err(HttpProblem(StatusCode::PAYLOAD_TOO_LARGE, why));
        }
    }
    let options: Submission = serde_json::from_slice(&text)
        .map_err(|error| HttpProblem::bad(format!("options: {error}")))?;
    match options.files.is_empty() {
        true => Ok(options),
        false => Err(HttpProblem::bad("options: give files as parts `file`")),
    }
}

/// Checks the changes of a job.
///
/// # Errors
/// There are too many, or one is no change.
pub fn check_sets(sets: &[String]) -> Answered<()> {
    let (most, longest) = MOST_SETS;
    if sets.len() > most {
        return Err(HttpProblem::bad(format!("give at most {most} changes")));
    }
    let is_one = |set: &String| {
        set.len() <= longest && set.contains('=') && !set.chars().any(char::is_control)
    };
    match sets.iter().find(|set| !is_one(set)) {
        None => Ok(()),
        Some(_) => Err(HttpProblem::bad("set: give key=value, such as end_time=5")),
    }
}

/// Checks the number of workers.
///
/// # Errors
/// The launcher never has so many, or there is no such launcher.
pub fn check_workers(app: &App, launcher: &str, workers: u32) -> Answered<()> {
    let Some(found) = app.keeper.launchers.get(launcher) else {
        let names: Vec<_> = app.keeper.launchers.keys().copied().collect();
        return Err(HttpProblem::bad(format!("launcher: this service has {}", names.join(", "))));
    };
    let most = found.limit().workers;
    match (1..=most).contains(&workers) {
        true => Ok(()),
        false => Err(HttpProblem::bad(format!("workers: give 1 to {most}"))),
    }
}

fn new_job(
    app: &App,
    identity: &Identity,
    options: Submission,
    files: &[PathBuf],
) -> Answered<NewJob> {
    let main = main_file(&options.job, files).map_err(HttpProblem::bad)?;
    let name = match options.name.trim() {
        "" => main.clone(),
        name => name.to_string(),
    };
    if name.chars().count() > LONGEST_NAME || name.chars().any(char::is_control) {
        return Err(HttpProblem::bad(format!(
            "name: give at most {LONGEST_NAME} printable characters"
        )));
    }
    let priority = options.priority;
    if !(-100..=100).contains(&priority) {
        return Err(HttpProblem::bad("priority: give -100 to 100"));
    }
    let retries = options.retries.unwrap_or(2);
    if retries > 20 {
        return Err(HttpProblem::bad("retries: give at most 20"));
    }
    check_sets(&options.set)?;
    let launcher = match options.launcher.as_str() {
        "" if app.keeper.launchers.contains_key("threads") => "threads".to_string(),
        "" => app.keeper.launchers.keys().next().copied().unwrap_or_default().to_string(),
        name => name.to_string(),
    };
    let workers = options.workers.unwrap_or(1);
    check_workers(app, &launcher, workers)?;
    let (owner, sets, check_only) = (identity.name.clone(), options.set, options.check_only);
    Ok(NewJob { name, owner, priority, workers, launcher, main, sets, retries, check_only })
}

/// Returns the job file among the files.
fn main_file(given: &str, files: &[PathBuf]) -> Result<String, String> {
    let text = |path: &PathBuf| path.to_string_lossy().into_owned();
    if !given.is_empty() {
        let path = relative(given)?;
        return match files.contains(&path) {
            true => Ok(text(&path)),
            false => Err("job: there is no such file among the files".into()),
        };
    }
    let of = |kinds: &[&str]| -> Vec<&PathBuf> {
        let is = |path: &&PathBuf| {
            let kind = path.extension().map(|e| e.to_string_lossy().to_lowercase());
            kind.is_some_and(|kind| kinds.contains(&kind.as_str()))
        };
        files.iter().filter(is).collect()
    };
    // An archive often has all files in one folder.
    let folder = common_folder(files);
    if files.contains(&folder.join("job.toml")) {
        return Ok(text(&folder.join("job.toml")));
    }
    let mut decks = of(&["k", "key", "dyn"]);
    let is_starter = |path: &&PathBuf| path.to_string_lossy().ends_with("_0000.rad");
    decks.extend(files.iter().filter(is_starter));
    match (&of(&["toml"])[..], &decks[..]) {
        ([one], _) | ([], [one]) => Ok(text(one)),
        _ => Err("job: name the job file or the deck among the files".into()),
    }
}

/// Returns the folder in which all files are.
fn common_folder(files: &[PathBuf]) -> PathBuf {
    let Some(first) = files.first().and_then(|path| path.parent()) else { return PathBuf::new() };
    let holds_all = |folder: &&Path| files.iter().all(|path| path.starts_with(folder));
    first.ancestors().find(holds_all).unwrap_or(Path::new("")).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_job_file_is_found_among_the_files() {
        let files = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        for (given, names, found) in [
            ("", &["mesh.toml", "job.toml"][..], Some("job.toml")),
            ("", &["a.toml", "b.k"], Some("a.toml")),
            ("", &["b.K", "c.txt"], Some("b.K")),
            ("", &["b.k", "c.k"], None),
            ("", &["b_0000.rad", "b_0001.rad"], Some("b_0000.rad")),
            ("", &[], None),
            ("c.k", &["b.k", "c.k"], Some("c.k")),
            ("../c.k", &["c.k"], None),
            ("d.k", &["c.k"], None),
            ("", &["a/job.toml", "a/b/c.toml"], Some("a/job.toml")),
            ("", &["a/b/c.toml", "a/b/job.toml"], Some("a/b/job.toml")),
            ("", &["a/job.toml", "b/job.toml"], None),
        ] {
            assert_eq!(main_file(given, &files(names)).ok().as_deref(), found, "{given} {names:?}");
        }
    }

    #[test]
    fn changes_are_key_and_value_on_one_line() {
        let check = |set: &str| check_sets(&[set.to_string()]).is_ok();
        assert!(check("end_time=5") && check("--a=b"));
        assert!(!check("end_time") && !check("a=b\nc") && !check(&"a=".repeat(2000)));
        assert!(check_sets(&vec!["a=b".to_string(); 101]).is_err());
    }
}
