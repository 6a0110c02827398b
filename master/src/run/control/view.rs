//! Pictures of the present state for clients, in `view` in the folder of the run. They are made
//! only while a client asks, and take at most a fiftieth of the time of the workers. No result
//! depends on them.

use super::Control;
use crate::run::request::{Answer, View};
use crate::run::service::Reply;
use crumple_proto::message::{Action, Viewed};
use crumple_worker::vtu;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Folder of the pictures in that of a run.
const DIR: &str = "view";
/// Shortest interval between two pictures.
const SHORTEST: Duration = Duration::from_millis(250);
/// Least ratio of the interval to the time that a worker needs for a picture.
const REST: f64 = 50.0;

/// Pictures, and the clients that wait for one. The files are removed when it is dropped.
pub(super) struct Viewing {
    dir: PathBuf,
    waiting: Vec<Reply>,
    /// Answers of workers to the present order, none without one.
    answers: Option<Vec<Viewed>>,
    /// Number of orders. Folders alternate, so that a client can read the one before.
    orders: usize,
    ordered: Instant,
    interval: Duration,
    last: Option<View>,
}

impl Viewing {
    /// Prepares pictures of the run in the folder `out`.
    pub(super) fn new(out: &Path) -> Self {
        let viewing = Self {
            dir: out.join(DIR),
            waiting: Vec::new(),
            answers: None,
            orders: 0,
            ordered: Instant::now(),
            interval: Duration::ZERO,
            last: None,
        };
        viewing.clear(); // of a run that was killed
        viewing
    }

    /// Lets the clients that wait learn that the run has ended.
    pub(super) fn end(&mut self) {
        self.waiting.clear();
    }

    fn clear(&self) {
        let _ = std::fs::remove_dir_all(&self.dir); // it may not exist
    }
}

impl Drop for Viewing {
    fn drop(&mut self) {
        self.clear();
    }
}

impl Control<'_> {
    /// Answers with a picture, a recent one if the next one is not due yet.
    pub(super) fn take_view(&mut self, reply: Reply) {
        let viewing = &mut self.viewing;
        if viewing.answers.is_some() {
            return viewing.waiting.push(reply);
        }
        if let Some(last) =
            viewing.last.clone().filter(|_| viewing.ordered.elapsed() < viewing.interval)
        {
            return reply.send(Answer::View(Box::new(last)));
        }
        if self.stop_ordered {
            return reply.send(Answer::refused("the run is stopping"));
        }
        viewing.waiting.push(reply);
        viewing.answers = Some(Vec::new());
        viewing.ordered = Instant::now();
        viewing.orders += 1;
        let folder = viewing.dir.join(vtu::step_folder(viewing.orders % 2));
        self.order(Action::View(folder.to_string_lossy().into_owned()));
    }

    /// Takes the answer of a worker; the last one completes the picture.
    pub(super) fn take_viewed(&mut self, viewed: Viewed) {
        let Some(mut answers) = self.viewing.answers.take() else { return };
        answers.push(viewed);
        if answers.len() < self.workers {
            self.viewing.answers = Some(answers);
            return;
        }
        let seconds = answers.iter().map(|a| a.seconds).fold(0.0, f64::max);
        self.viewing.interval = SHORTEST.max(Duration::from_secs_f64(REST * seconds));
        let answer = match answers.iter().find_map(|a| a.error.clone()) {
            Some(error) => Answer::refused(error),
            None => {
                let view = self.view(answers[0].cycle, answers[0].time);
                self.viewing.last = Some(view.clone());
                Answer::View(Box::new(view))
            }
        };
        self.viewing.waiting.drain(..).for_each(|reply| reply.send(answer.clone()));
    }

    fn view(&self, cycle: u64, time: f64) -> View {
        let (job, parts) = (&self.model.job, &self.model.settings.parts);
        let named: Vec<_> = parts.iter().map(|p| json!({"id": p.id, "name": p.name})).collect();
        let about = json!({"units": job.units, "parts": named, "walls": job.wall});
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        View {
            cycle,
            time,
            folder: format!("{DIR}/{}", vtu::step_folder(self.viewing.orders % 2)),
            pieces: self.workers,
            about: about.as_object().cloned().unwrap_or_default(),
            boxes: self
                .tree
                .boxes()
                .iter()
                .map(|b| [b.min.map(finite), b.max.map(finite)])
                .collect(),
        }
    }
}
