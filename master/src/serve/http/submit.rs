//! Submission of jobs: files and options arrive, are stored, and are then checked by the loop.

use super::App;
use super::guard::{Detail, Subject, require};
use super::problem::{Answered, Problem};
use crate::cli::Role;
use crate::serve::api::{Job, Refusal, Submission};
use crate::serve::folder::{JobFolder, create, relative};
use crate::serve::store::NewJob;
use crate::serve::tokens::Identity;
use axum::Json;
use axum::extract::multipart::{Field, Multipart, MultipartError};
use axum::extract::{Extension, FromRequest, Request, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tokio::io::AsyncWriteExt;

/// Most files of a job.
const MOST_FILES: usize = 2000;
/// Most jobs that wait or run.
const MOST_OPEN: i64 = 20_000;
/// Longest pause of a client that sends files.
const SLOWEST: Duration = Duration::from_secs(30);
/// Largest part `options` [byte].
const LARGEST_OPTIONS: usize = 256 * 1024;
/// Most changes of a job, and the longest one [byte].
const MOST_SETS: (usize, usize) = (100, 2000);
/// Longest name [characters].
const LONGEST_NAME: usize = 200;

/// Submits a job.
#[utoipa::path(post, path = "/api/jobs", request_body(content(
    (Submission = "application/json"), (Submission = "multipart/form-data"))),
    responses((status = 201, body = Job), (status = 403, body = Refusal),
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
        return Err(Problem(StatusCode::SERVICE_UNAVAILABLE, why));
    }
    let id = app.keeper.store.reserve(identity.name.clone()).await?;
    let mut arrival =
        Arrival { app: app.clone(), id, folder: app.keeper.root.job(id), kept: false };
    let (options, files) = arrival.receive(request).await?;
    let new = new_job(&app, &identity, options, &files)?;
    let detail = format!("{}: {} with {} files", new.name, new.main, files.len());
    app.keeper.store.submit(id, new).await?;
    arrival.kept = true;
    app.keeper.announce(id).await.map_err(Problem::internal)?;
    app.keeper.wake.notify_one();
    let job = super::jobs::found(&app, id).await?.job;
    let location = [(header::LOCATION, format!("/api/jobs/{id}"))];
    let answer = (StatusCode::CREATED, location, Json(job));
    Ok((Extension(Subject(id)), Extension(Detail(detail)), answer).into_response())
}

/// A job that arrives. Its files are removed if it does not become a job.
struct Arrival {
    app: App,
    id: i64,
    folder: JobFolder,
    kept: bool,
}

impl Drop for Arrival {
    fn drop(&mut self) {
        if self.kept {
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

fn broken(error: MultipartError) -> Problem {
    Problem(error.status(), error.body_text())
}

impl Arrival {
    async fn receive(&self, request: Request) -> Answered<(Submission, Vec<PathBuf>)> {
        tokio::fs::create_dir_all(self.folder.input()).await?;
        let kind = request.headers().get(header::CONTENT_TYPE).cloned();
        let kind = kind.as_ref().and_then(|kind| kind.to_str().ok()).unwrap_or_default();
        let most = self.app.most_bytes;
        if kind.starts_with("multipart/form-data") {
            let parts = Multipart::from_request(request, &()).await;
            let parts = parts.map_err(|error| Problem(error.status(), error.body_text()))?;
            return self.receive_parts(parts).await;
        }
        let parsed = Json::<Submission>::from_request(request, &()).await;
        let Json(mut options) =
            parsed.map_err(|error| Problem(error.status(), error.body_text()))?;
        let given = std::mem::take(&mut options.files);
        if given.len() > MOST_FILES || given.values().map(|t| t.len() as u64).sum::<u64>() > most {
            return Err(Problem(StatusCode::PAYLOAD_TOO_LARGE, "the job is too large".into()));
        }
        let input = self.folder.input();
        let write = move || -> Answered<Vec<PathBuf>> {
            let mut files = Vec::new();
            for (name, text) in given {
                let path = relative(&name).map_err(Problem::bad)?;
                let mut file = create(&input, &path).map_err(|error| taken(&name, error))?;
                std::io::Write::write_all(&mut file, text.as_bytes())?;
                files.push(path);
            }
            Ok(files)
        };
        let files = tokio::task::spawn_blocking(write).await.map_err(Problem::internal)??;
        Ok((options, files))
    }

    async fn receive_parts(&self, mut parts: Multipart) -> Answered<(Submission, Vec<PathBuf>)> {
        let (mut options, mut files) = (None, Vec::new());
        while let Some(part) = in_time(parts.next_field()).await?.map_err(broken)? {
            match part.name() {
                Some("options") if options.is_none() => options = Some(read_options(part).await?),
                Some("file") if files.len() < MOST_FILES => files.push(self.store(part).await?),
                Some("file") => {
                    let why = format!("a job has at most {MOST_FILES} files");
                    return Err(Problem(StatusCode::PAYLOAD_TOO_LARGE, why));
                }
                _ => return Err(Problem::bad("give one part `options` and parts `file`")),
            }
        }
        Ok((options.unwrap_or_default(), files))
    }

    async fn store(&self, mut part: Field<'_>) -> Answered<PathBuf> {
        let name = part.file_name().unwrap_or_default().to_string();
        let path = relative(&name).map_err(Problem::bad)?;
        let file = create(&self.folder.input(), &path).map_err(|error| taken(&name, error))?;
        let mut file = tokio::fs::File::from_std(file);
        while let Some(bytes) = in_time(part.chunk()).await?.map_err(broken)? {
            file.write_all(&bytes).await?;
        }
        file.flush().await?;
        Ok(path)
    }
}

fn taken(name: &str, error: std::io::Error) -> Problem {
    use std::io::ErrorKind::{AlreadyExists, InvalidFilename, IsADirectory, NotADirectory};
    match error.kind() {
        AlreadyExists | NotADirectory | IsADirectory => {
            Problem::bad(format!("the name {name} is given twice"))
        }
        InvalidFilename => Problem::bad("a file name is too long"),
        _ => error.into(),
    }
}

/// Waits for a client that sends, as long as it is not too slow.
async fn in_time<T>(next: impl Future<Output = T>) -> Answered<T> {
    let late = |_| Problem(StatusCode::REQUEST_TIMEOUT, "the files arrive too slowly".into());
    tokio::time::timeout(SLOWEST, next).await.map_err(late)
}

async fn read_options(mut part: Field<'_>) -> Answered<Submission> {
    let mut text = Vec::new();
    while let Some(bytes) = in_time(part.chunk()).await?.map_err(broken)? {
        text.extend_from_slice(&bytes);
        if text.len() > LARGEST_OPTIONS {
            let why = format!("options have at most {LARGEST_OPTIONS} bytes");
            return Err(Problem(StatusCode::PAYLOAD_TOO_LARGE, why));
        }
    }
    let options: Submission =
        serde_json::from_slice(&text).map_err(|error| Problem::bad(format!("options: {error}")))?;
    match options.files.is_empty() {
        true => Ok(options),
        false => Err(Problem::bad("options: give files as parts `file`")),
    }
}

/// Checks the changes of a job.
///
/// # Errors
/// There are too many, or one is no change.
pub fn check_sets(sets: &[String]) -> Answered<()> {
    let (most, longest) = MOST_SETS;
    if sets.len() > most {
        return Err(Problem::bad(format!("give at most {most} changes")));
    }
    let is_one = |set: &String| {
        set.len() <= longest && set.contains('=') && !set.chars().any(char::is_control)
    };
    match sets.iter().find(|set| !is_one(set)) {
        None => Ok(()),
        Some(_) => Err(Problem::bad("set: give key=value, such as end_time=5")),
    }
}

/// Checks the number of workers.
///
/// # Errors
/// The launcher never has so many, or there is no such launcher.
pub fn check_workers(app: &App, launcher: &str, workers: u32) -> Answered<()> {
    let Some(found) = app.keeper.launchers.get(launcher) else {
        let names: Vec<_> = app.keeper.launchers.keys().copied().collect();
        return Err(Problem::bad(format!("launcher: this service has {}", names.join(", "))));
    };
    let most = found.limit().workers;
    match (1..=most).contains(&workers) {
        true => Ok(()),
        false => Err(Problem::bad(format!("workers: give 1 to {most}"))),
    }
}

fn new_job(
    app: &App,
    identity: &Identity,
    options: Submission,
    files: &[PathBuf],
) -> Answered<NewJob> {
    let main = main_file(&options.job, files).map_err(Problem::bad)?;
    let name = match options.name.trim() {
        "" => main.clone(),
        name => name.to_string(),
    };
    if name.chars().count() > LONGEST_NAME || name.chars().any(char::is_control) {
        return Err(Problem::bad(format!(
            "name: give at most {LONGEST_NAME} printable characters"
        )));
    }
    let priority = options.priority;
    if !(-100..=100).contains(&priority) {
        return Err(Problem::bad("priority: give -100 to 100"));
    }
    let retries = options.retries.unwrap_or(2);
    if retries > 20 {
        return Err(Problem::bad("retries: give at most 20"));
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
    if files.iter().any(|path| *path == Path::new("job.toml")) {
        return Ok("job.toml".into());
    }
    match (&of(&["toml"])[..], &of(&["k", "key", "dyn"])[..]) {
        ([one], _) | ([], [one]) => Ok(text(one)),
        _ => Err("job: name the job file or the deck among the files".into()),
    }
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
            ("", &[], None),
            ("c.k", &["b.k", "c.k"], Some("c.k")),
            ("../c.k", &["c.k"], None),
            ("d.k", &["c.k"], None),
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
