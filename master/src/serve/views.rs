//! Pictures of the jobs that someone watches. All watchers of a job share one picture, which is
//! made at most every [`NEW_EVERY`]; a job without watchers costs nothing.

use super::folder::JobFolder;
use super::live;
use crate::results::report::state::PictureState;
use crate::run::request::{Answer, Request, View};
use crumple_worker::vtu;
use serde_json::json;
use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};
use tokio::sync::{Mutex as Turn, Semaphore};

/// Interval between two pictures of a job.
const NEW_EVERY: Duration = Duration::from_secs(2);
/// Time after which a picture without requests is forgotten.
const KEPT_FOR: Duration = Duration::from_secs(60);
/// Longest wait for the answer of a run, which may be in a long cycle.
const PATIENCE: Duration = Duration::from_secs(20);

/// A picture of a job.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Changes with the picture.
    pub tag: String,
    /// JSON.
    pub text: Arc<str>,
}

/// Time of the last request for a job, and its picture.
type Watched = (Instant, Arc<Turn<Kept>>);

/// The pictures of all jobs.
pub struct Views {
    jobs: Mutex<HashMap<i64, Watched>>,
    /// Only one picture is made at a time, which bounds the memory.
    one: Semaphore,
}

impl Default for Views {
    fn default() -> Self {
        Self { jobs: Mutex::default(), one: Semaphore::new(1) }
    }
}

#[derive(Default)]
struct Kept {
    looked: Option<Instant>,
    source: Option<PictureSource>,
    picture: Option<Picture>,
}

/// Where a picture comes from. The same one gives the same picture.
#[derive(Clone, Debug, PartialEq)]
struct PictureSource {
    state: PictureState,
    written: Option<SystemTime>,
}

impl PictureSource {
    fn from_state(state: PictureState) -> Self {
        let about = state.pieces.first().and_then(|file| std::fs::metadata(file).ok());
        Self { written: about.and_then(|about| about.modified().ok()), state }
    }

    /// Returns the picture. Damage of the files is in the log only: it names paths.
    ///
    /// # Errors
    /// The state is too large.
    fn picture(&self, results: &Path, view: Option<&View>) -> Result<Option<Picture>, String> {
        self.state.check_size()?;
        let mut picture = match self.state.picture(results, view.map(|view| &view.about)) {
            Ok(picture) => picture,
            Err(why) => {
                tracing::warn!(why, "a state cannot be shown");
                return Ok(None);
            }
        };
        picture["boxes"] = json!(view.map_or(&[][..], |view| &view.boxes));
        picture["cycle"] = json!(view.map(|view| view.cycle));
        let text: Arc<str> = picture.to_string().into();
        let tag = format!("\"{}\"", &blake3::hash(text.as_bytes()).to_hex()[..16]);
        Ok(Some(Picture { tag, text }))
    }
}

impl Views {
    /// Returns the newest picture of a job, none before its first state.
    ///
    /// # Errors
    /// The state is too large.
    pub async fn newest(&self, id: i64, folder: &JobFolder) -> Result<Option<Picture>, String> {
        let place = self.place(id);
        let mut kept = place.lock().await;
        if kept.looked.is_some_and(|looked| looked.elapsed() < NEW_EVERY) {
            return Ok(kept.picture.clone());
        }
        let _one = self.one.acquire().await.map_err(|error| error.to_string())?;
        let view = ask(folder).await;
        let (results, before) = (folder.results(), kept.source.clone());
        let made = tokio::task::spawn_blocking(move || make(&results, view, before.as_ref())).await;
        kept.looked = Some(Instant::now());
        if let Some((source, picture)) = made.map_err(|error| error.to_string())?? {
            (kept.source, kept.picture) = (Some(source), Some(picture));
        }
        Ok(kept.picture.clone())
    }

    /// Returns the picture of the newest output of a job up to a time; none if there is no output.
    ///
    /// # Errors
    /// The state is too large.
    pub async fn at(&self, folder: &JobFolder, time: f64) -> Result<Option<Picture>, String> {
        let _one = self.one.acquire().await.map_err(|error| error.to_string())?;
        let results = folder.results();
        let make = move || match PictureState::output_at(&results, time) {
            Some(state) => PictureSource::from_state(state).picture(&results, None),
            None => Ok(None),
        };
        tokio::task::spawn_blocking(make).await.map_err(|error| error.to_string())?
    }

    /// Returns the place of a job, and forgets those without requests.
    fn place(&self, id: i64) -> Arc<Turn<Kept>> {
        let mut jobs = self.jobs.lock().unwrap_or_else(PoisonError::into_inner);
        jobs.retain(|_, (asked, _)| asked.elapsed() < KEPT_FOR);
        let entry = jobs.entry(id).or_insert_with(|| (Instant::now(), Arc::default()));
        entry.0 = Instant::now();
        entry.1.clone()
    }
}

/// Asks a run for its present state. Returns none if it does not answer: it has no socket yet, it
/// is ending, or it is on another machine.
async fn ask(folder: &JobFolder) -> Option<View> {
    let answer = tokio::time::timeout(PATIENCE, live::ask(folder, &Request::View)).await;
    match answer {
        Ok(Ok(Answer::View(view))) => Some(*view),
        _ => None,
    }
}

/// Returns the newest picture: that of the run, else its newest output; none if it is that of
/// `before` or there is no state.
///
/// # Errors
/// The state is too large.
fn make(
    results: &Path,
    view: Option<View>,
    before: Option<&PictureSource>,
) -> Result<Option<(PictureSource, Picture)>, String> {
    let state = match &view {
        Some(view) => {
            let folder = results.join(&view.folder);
            let pieces = (0..view.pieces).map(|w| folder.join(vtu::piece_name(w))).collect();
            Some(PictureState { time: view.time, pieces })
        }
        None => PictureState::output_at(results, f64::INFINITY),
    };
    let Some(source) = state.map(PictureSource::from_state).filter(|source| Some(source) != before)
    else {
        return Ok(None);
    };
    Ok(source.picture(results, view.as_ref())?.map(|picture| (source, picture)))
}
