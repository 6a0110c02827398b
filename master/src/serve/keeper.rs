//! The loop of the service: it checks, starts, watches and ends jobs. Its whole state is in the
//! database and in the folders of the jobs, so that it can be killed at any moment.

use super::api::{JobState, ServiceJob};
use super::check;
use super::folder::{JobFolder, Root};
use super::launcher::{LaunchOrder, LaunchState, Launcher};
use super::limits::{Amount, starts};
use super::live::{Live, LiveLine};
use super::store::{Store, StoredJob};
use super::views::Views;
use crate::input::findings::Findings;
use crate::run::attempt::{self, State};
use crate::run::checkpoint::find::newest_cycle;
use crumple_proto::exit_code::{BAD_INPUT, STOPPED, WORKER_LOST};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::{Notify, Semaphore};

/// Interval between two looks at all runs.
const LOOK_EVERY: Duration = Duration::from_millis(300);
/// Time in which a process has to claim its attempt.
const CLAIM_WITHIN: Duration = Duration::from_secs(60);
/// Time after which a run that does not stop is asked again.
const ASK_AGAIN: Duration = Duration::from_secs(20);
/// Longest call of a launcher.
const LAUNCHER_TIME: Duration = Duration::from_secs(60);
/// Number of processes of a job that may be lost in a row.
const MOST_LOST: u32 = 3;
/// Number of checks at a time.
const MOST_CHECKS: usize = 2;
/// Longest reason that is stored [characters].
const LONGEST_REASON: usize = 400;

/// State of the service for all jobs.
pub struct Keeper {
    /// Database.
    pub store: Store,
    /// Folder.
    pub root: Root,
    /// Launchers by name.
    pub launchers: BTreeMap<&'static str, Arc<dyn Launcher>>,
    /// Streams.
    pub live: Live,
    /// Pictures of jobs that are watched.
    pub views: Views,
    /// Wakes the loop.
    pub wake: Arc<Notify>,
    /// The program.
    pub program: PathBuf,
    checks: Arc<Semaphore>,
    notes: Mutex<Notes>,
}

/// State that exists only while the service runs.
#[derive(Default)]
struct Notes {
    checking: HashSet<i64>,
    followed: HashSet<i64>,
    /// When this process ordered an attempt.
    ordered: HashMap<i64, Instant>,
    /// When a run was asked to stop, by the number of its job; with true, when its processes were
    /// killed.
    asked: HashMap<(i64, bool), Instant>,
}

/// The database or a launcher has failed; the loop tries again.
type LoopResult = Result<(), String>;

fn failed(error: rusqlite::Error) -> String {
    format!("the database: {error}")
}

impl Keeper {
    /// Returns a keeper for a folder.
    pub fn new(
        store: Store,
        root: Root,
        launchers: BTreeMap<&'static str, Arc<dyn Launcher>>,
        program: PathBuf,
    ) -> Arc<Self> {
        Arc::new(Self {
            store,
            root,
            launchers,
            program,
            live: Live::default(),
            views: Views::default(),
            wake: Arc::default(),
            checks: Arc::new(Semaphore::new(MOST_CHECKS)),
            notes: Mutex::default(),
        })
    }

    fn notes<T>(&self, body: impl FnOnce(&mut Notes) -> T) -> T {
        body(&mut self.notes.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Keeps all jobs, for ever.
    pub async fn run(self: Arc<Self>) {
        loop {
            if let Err(why) = self.turn().await {
                tracing::error!(why, "the queue was not served");
            }
            let woken = self.wake.notified();
            let _ = tokio::time::timeout(LOOK_EVERY, woken).await;
        }
    }

    /// Removes what arrived in part before the service ended, and adds the events that it did not
    /// store any more.
    ///
    /// # Errors
    /// The database fails.
    pub async fn tidy(&self) -> LoopResult {
        for id in self.store.incoming().await.map_err(failed)? {
            let _ = tokio::fs::remove_dir_all(self.root.job(id).path()).await;
            self.store.forget(id).await.map_err(failed)?;
        }
        for id in self.store.unannounced().await.map_err(failed)? {
            self.announce(id).await?;
        }
        Ok(())
    }

    async fn turn(self: &Arc<Self>) -> LoopResult {
        for stored in self.store.in_state(JobState::Checking).await.map_err(failed)? {
            self.check(stored);
        }
        let mut active = Vec::new();
        for state in [JobState::Starting, JobState::Running] {
            active.extend(self.store.in_state(state).await.map_err(failed)?);
        }
        for stored in &active {
            if let Err(why) = self.update_job(stored).await {
                tracing::warn!(why, job = stored.job.id, "a run could not be watched");
            }
        }
        let ids: HashSet<i64> = active.iter().map(|stored| stored.job.id).collect();
        self.notes(|notes| {
            notes.ordered.retain(|id, _| ids.contains(id));
            notes.asked.retain(|(id, _), _| ids.contains(id));
        });
        self.live.tidy(|id| ids.contains(&id));
        self.start_those_that_fit().await
    }

    /// Begins the check of a job, unless it has begun.
    fn check(self: &Arc<Self>, stored: StoredJob) {
        let id = stored.job.id;
        if !self.notes(|notes| notes.checking.insert(id)) {
            return;
        }
        let keeper = self.clone();
        tokio::spawn(async move {
            if let Ok(_permit) = keeper.checks.acquire().await
                && let Err(why) = keeper.checked(&stored).await
            {
                tracing::error!(why, job = id, "a check failed");
            }
            keeper.notes(|notes| notes.checking.remove(&id));
            keeper.wake.notify_one();
        });
    }

    async fn checked(&self, stored: &StoredJob) -> LoopResult {
        let job = &stored.job;
        let folder = self.root.job(job.id);
        let limit = self.launchers.get(job.launcher.as_str()).map(|l| l.limit());
        let limit = limit.ok_or_else(|| format!("there is no launcher {}", job.launcher))?;
        let checked =
            check::check(&self.program, &folder, &job.job, &job.set, job.workers, limit.memory_mb)
                .await;
        let json = serde_json::to_vec(&checked).map_err(|e| e.to_string())?;
        // A client never reads half of it.
        let fresh = folder.findings().with_extension("new");
        tokio::fs::write(&fresh, json).await.map_err(|e| e.to_string())?;
        tokio::fs::rename(&fresh, folder.findings()).await.map_err(|e| e.to_string())?;
        let too_large = checked.usable && checked.memory_mb > limit.memory_mb;
        let (state, reason) = match checked.usable {
            _ if too_large => (
                JobState::Refused,
                format!(
                    "the job needs about {:.0} MB; {} has {:.0} MB",
                    checked.memory_mb, job.launcher, limit.memory_mb
                ),
            ),
            false => (JobState::Refused, first_error(&checked)),
            true if stored.check_only => (JobState::Checked, String::new()),
            true => (JobState::Queued, String::new()),
        };
        let changed = self.store.checked(job.id, state, checked.memory_mb, reason).await;
        if changed.map_err(failed)? {
            self.announce(job.id).await?;
        }
        Ok(())
    }

    /// Sends the present state of a job to all watchers.
    ///
    /// # Errors
    /// The database fails.
    pub async fn announce(&self, id: i64) -> Result<(), String> {
        let Some(stored) = self.store.job(id).await.map_err(failed)? else { return Ok(()) };
        let data = serde_json::to_string(&stored.job).map_err(|error| error.to_string())?;
        let event = self.store.add_event(id, "state", data.clone()).await.map_err(failed)?;
        self.live.publish(id, LiveLine { id: Some(event), kind: "state", data: data.into() });
        Ok(())
    }

    /// Calls a launcher on a thread where it may wait.
    async fn ask<T: Send + 'static>(
        &self,
        job: &ServiceJob,
        body: impl FnOnce(&dyn Launcher) -> Result<T, String> + Send + 'static,
    ) -> Result<T, String> {
        let launcher = self.launchers.get(job.launcher.as_str()).cloned();
        let launcher = launcher.ok_or_else(|| format!("there is no launcher {}", job.launcher))?;
        let called = tokio::task::spawn_blocking(move || body(&*launcher));
        match tokio::time::timeout(LAUNCHER_TIME, called).await {
            Ok(Ok(said)) => said,
            Ok(Err(error)) => Err(error.to_string()),
            Err(_) => Err(format!("{} does not answer", job.launcher)),
        }
    }

    /// Reads the state of a job that has or may have a process, and stores what has changed.
    async fn update_job(self: &Arc<Self>, stored: &StoredJob) -> LoopResult {
        let job = &stored.job;
        let (order, handle) = (self.order(stored), stored.handle.clone());
        let seen = {
            let (order, handle) = (order.clone(), handle.clone());
            self.ask(job, move |launcher| launcher.attempt_state(&order, &handle)).await?
        };
        match seen {
            LaunchState::Waiting => self.wait(stored, &order).await?,
            LaunchState::Running => {
                if self.store.runs(job.id).await.map_err(failed)? {
                    self.announce(job.id).await?;
                }
                self.watch_run(job.id);
            }
            LaunchState::Ended(code) => return self.end(stored, code).await,
            LaunchState::Lost => return self.lost(stored, 1).await,
        }
        // It is asked before it is killed, also if both orders have arrived since the last turn.
        let forced = job.forced && self.notes(|notes| notes.asked.contains_key(&(job.id, false)));
        let key = (job.id, forced);
        let is_due = job.stopping
            && self.notes(|notes| {
                let asked = notes.asked.get(&key);
                asked.is_none_or(|asked| asked.elapsed() > ASK_AGAIN)
            });
        if is_due && (seen == LaunchState::Running || !handle.is_empty()) {
            self.notes(|notes| notes.asked.insert(key, Instant::now()));
            let end = move |launcher: &dyn Launcher| match forced {
                true => launcher.kill(&order, &handle),
                false => launcher.stop(&order, &handle),
            };
            self.ask(job, end).await?;
        }
        Ok(())
    }

    /// Withdraws an attempt that no process has claimed in time, or that was ordered before the
    /// service was killed: a process for it may exist.
    async fn wait(&self, stored: &StoredJob, order: &LaunchOrder) -> LoopResult {
        let id = stored.job.id;
        let handle = stored.handle.clone();
        let elsewhere = self
            .ask(&stored.job, move |launcher| Ok(launcher.is_queued_elsewhere(&handle)))
            .await?;
        let ordered = self.notes(|notes| notes.ordered.get(&id).copied());
        let is_new = ordered.is_some_and(|at| at.elapsed() < CLAIM_WITHIN);
        if elsewhere || (is_new && !stored.job.stopping) {
            return Ok(());
        }
        let path = order.folder.attempt(order.attempt);
        match attempt::withdraw(&path).map_err(|error| format!("{}: {error}", path.display()))? {
            // Only an attempt that this service has ordered says something about the job.
            State::Withdrawn => self.lost(stored, u32::from(ordered.is_some())).await,
            _ => Ok(()), // a process has claimed it meanwhile
        }
    }

    /// Starts to relay the stream of a run, unless that is done already.
    fn watch_run(self: &Arc<Self>, id: i64) {
        if !self.notes(|notes| notes.followed.insert(id)) {
            return;
        }
        let keeper = self.clone();
        tokio::spawn(async move {
            let folder = keeper.root.job(id);
            // A run without a socket, before its start or on another machine, is tried again.
            let _ = keeper.live.relay_stream(id, &folder, &keeper.store).await;
            keeper.notes(|notes| notes.followed.remove(&id));
        });
    }

    async fn end(&self, stored: &StoredJob, code: u8) -> LoopResult {
        let folder = self.root.job(stored.job.id);
        let is_killed = stored.job.forced && code_of_summary(&folder, stored.job.attempt).is_none();
        let reason = match code {
            0 => String::new(),
            _ if is_killed => {
                let from = newest_cycle(&folder.results());
                let kept = from.map_or("nothing".into(), |c| format!("the state of cycle {c}"));
                format!("killed, since it did not stop; it keeps {kept}")
            }
            _ => reason(&folder),
        };
        let id = stored.job.id;
        self.store.end(id, JobState::of_code(code), code, reason).await.map_err(failed)?;
        self.announce(id).await
    }

    /// Treats an attempt that has ended without an exit code, or has not begun. Adds `more` to the
    /// processes that the job has lost.
    async fn lost(&self, stored: &StoredJob, more: u32) -> LoopResult {
        let (id, folder) = (stored.job.id, self.root.job(stored.job.id));
        if let Some(code) = code_of_summary(&folder, stored.job.attempt) {
            return self.end(stored, code).await;
        }
        if stored.job.stopping {
            return self.end(stored, STOPPED).await;
        }
        let lost = stored.lost + more;
        if lost > MOST_LOST {
            let reason = format!("its process was lost {lost} times");
            let ended = self.store.end(id, JobState::Lost, WORKER_LOST, reason).await;
            ended.map_err(failed)?;
        } else {
            let from = newest_cycle(&folder.results());
            let from = from.map_or("the start".into(), |cycle| format!("cycle {cycle}"));
            let reason = format!("its process was lost; it continues from {from}");
            self.store.requeue(id, lost, reason).await.map_err(failed)?;
        }
        self.announce(id).await
    }

    /// Starts jobs that wait, as far as they fit.
    async fn start_those_that_fit(self: &Arc<Self>) -> LoopResult {
        let queued = self.store.in_state(JobState::Queued).await.map_err(failed)?;
        let (queued, never) = self.without_those_that_never_fit(queued);
        for (id, reason) in never {
            let ended = self.store.end(id, JobState::Refused, BAD_INPUT, reason).await;
            ended.map_err(failed)?;
            self.announce(id).await?;
        }
        if queued.is_empty() {
            return Ok(());
        }
        let mut active = self.store.in_state(JobState::Starting).await.map_err(failed)?;
        active.extend(self.store.in_state(JobState::Running).await.map_err(failed)?);
        for (name, launcher) in &self.launchers {
            let own = |list: &[StoredJob]| -> Vec<StoredJob> {
                list.iter().filter(|stored| stored.job.launcher == *name).cloned().collect()
            };
            let used = own(&active).iter().map(need).fold(Amount::default(), Amount::plus);
            let waiting = own(&queued);
            let needs: Vec<Amount> = waiting.iter().map(need).collect();
            for stored in waiting.iter().take(starts(&needs, used, launcher.limit())) {
                self.start(stored).await?;
            }
        }
        Ok(())
    }

    /// Takes out the jobs that would hold back all others for ever, with the reasons: the service
    /// was started again without their launcher, or with lower limits.
    fn without_those_that_never_fit(
        &self,
        queued: Vec<StoredJob>,
    ) -> (Vec<StoredJob>, Vec<(i64, String)>) {
        let mut never = Vec::new();
        let reason = |stored: &StoredJob| {
            let name = &stored.job.launcher;
            let Some(launcher) = self.launchers.get(name.as_str()) else {
                return Some(format!("this service has no launcher {name}"));
            };
            let (need, limit) = (need(stored), launcher.limit());
            (!need.fits(limit)).then(|| {
                format!(
                    "the job needs {} workers and about {:.0} MB; {name} has {} workers and \
                     {:.0} MB",
                    need.workers, need.memory_mb, limit.workers, limit.memory_mb
                )
            })
        };
        let fitting = queued.into_iter().filter(|stored| {
            let why = reason(stored).map(|why| (stored.job.id, why));
            let fits = why.is_none();
            never.extend(why);
            fits
        });
        (fitting.collect(), never)
    }

    async fn start(self: &Arc<Self>, stored: &StoredJob) -> LoopResult {
        let id = stored.job.id;
        if !self.store.start_attempt(id).await.map_err(failed)? {
            return Ok(()); // it was stopped meanwhile
        }
        let Some(stored) = self.store.job(id).await.map_err(failed)? else { return Ok(()) };
        self.notes(|notes| notes.ordered.insert(id, Instant::now()));
        self.announce(id).await?;
        let order = self.order(&stored);
        let started = self.ask(&stored.job, move |launcher| launcher.start(&order)).await;
        match started {
            Ok(handle) if handle.is_empty() => Ok(()),
            Ok(handle) => self.store.set_handle(id, handle).await.map_err(failed),
            Err(why) => {
                // The attempt is withdrawn in case that there is a process nevertheless.
                let path = self.root.job(id).attempt(stored.job.attempt);
                if matches!(attempt::withdraw(&path), Ok(State::Withdrawn)) {
                    let ended = self.store.end(id, JobState::Lost, WORKER_LOST, why).await;
                    ended.map_err(failed)?;
                    self.announce(id).await?;
                }
                Ok(())
            }
        }
    }

    fn order(&self, stored: &StoredJob) -> LaunchOrder {
        let job = &stored.job;
        let folder = self.root.job(job.id);
        let mut words = vec!["run".to_string()];
        let mut sets = stored.later_sets.clone();
        if newest_cycle(&folder.results()).is_some() {
            words.extend(["--resume".into(), "results".into()]);
        } else {
            words.extend([format!("input/{}", job.job), "--out".into(), "results".into()]);
            words.push("--overwrite".into()); // of an attempt that was lost
            sets = [job.set.clone(), sets].concat();
        }
        words.extend(["--within".into(), "input".into(), "--quiet".into()]);
        words.extend(["--workers".into(), job.workers.to_string()]);
        words.extend(["--retries".into(), job.retries.to_string()]);
        words.extend(["--attempt".into(), JobFolder::attempt_name(job.attempt)]);
        words.extend(sets.into_iter().map(|set| format!("--set={set}")));
        let launcher = self.launchers.get(job.launcher.as_str());
        if let Some(command) = launcher.and_then(|launcher| launcher.ranks()) {
            words.extend(["--launcher".into(), command.into()]);
        }
        LaunchOrder { id: job.id, folder, attempt: job.attempt, workers: job.workers, words }
    }
}

fn need(stored: &StoredJob) -> Amount {
    Amount { workers: stored.job.workers, memory_mb: stored.job.memory_mb }
}

/// Returns the first error of a job.
fn first_error(findings: &Findings) -> String {
    let first = findings.findings.first().map(|finding| finding.message.as_str());
    shortened(&format!("error: {}", first.unwrap_or("the check failed")))
}

fn shortened(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(LONGEST_REASON).collect()
}

/// Returns why a run has ended: by its summary, or else by the last line that it printed.
fn reason(folder: &JobFolder) -> String {
    let said = std::fs::read_to_string(folder.output()).unwrap_or_default();
    let last = said.lines().rfind(|line| line.starts_with("error"));
    let summary = || summary(folder)?["reason"].as_str().map(String::from);
    shortened(&last.map(String::from).or_else(summary).unwrap_or_default())
}

fn summary(folder: &JobFolder) -> Option<serde_json::Value> {
    let text = std::fs::read(folder.results().join("summary.json")).ok()?;
    serde_json::from_slice(&text).ok()
}

/// Returns the exit code that the summary stands for, if it was written during the attempt.
fn code_of_summary(folder: &JobFolder, attempt: u32) -> Option<u8> {
    let modified = |path: PathBuf| path.metadata().and_then(|m| m.modified()).ok();
    let written = modified(folder.results().join("summary.json"))?;
    if written < modified(folder.attempt(attempt))? {
        return None;
    }
    let summary = summary(folder)?;
    let requirements = summary["requirements"].as_array().into_iter().flatten();
    let is_unmet = requirements.into_iter().any(|one| one["is_met"] == false);
    match summary["status"].as_str()? {
        "completed" if is_unmet => Some(crumple_proto::exit_code::UNMET),
        "completed" => Some(crumple_proto::exit_code::COMPLETED),
        "stopped" => Some(STOPPED),
        "failed" => Some(crumple_proto::exit_code::FAILED),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::serve::store::NewJob;

    /// A launcher whose processes never claim their attempts.
    struct NoProcess;

    impl Launcher for NoProcess {
        fn limit(&self) -> Amount {
            Amount { workers: 1, memory_mb: 1e6 }
        }

        fn ranks(&self) -> Option<&str> {
            None
        }

        fn start(&self, _: &LaunchOrder) -> Result<String, String> {
            Ok(String::new())
        }

        fn attempt_state(&self, _: &LaunchOrder, _: &str) -> Result<LaunchState, String> {
            Ok(LaunchState::Waiting)
        }

        fn stop(&self, _: &LaunchOrder, _: &str) -> Result<(), String> {
            Ok(())
        }

        fn kill(&self, _: &LaunchOrder, _: &str) -> Result<(), String> {
            Ok(())
        }

        fn is_queued_elsewhere(&self, _: &str) -> bool {
            false
        }
    }

    #[tokio::test]
    async fn a_job_that_starts_whenever_its_service_is_killed_is_not_given_up() {
        let dir = tempfile::tempdir().unwrap();
        let root = Root::make(dir.path()).unwrap();
        let store = Store::open(&root.path("service.db")).unwrap();
        let id = store.reserve("anna".into()).await.unwrap();
        std::fs::create_dir_all(root.job(id).input()).unwrap();
        let new = NewJob {
            name: "job".into(),
            owner: "anna".into(),
            priority: 0,
            workers: 1,
            launcher: "threads".into(),
            main: "job.toml".into(),
            sets: Vec::new(),
            retries: 0,
            check_only: false,
        };
        store.submit(id, new).await.unwrap();
        store.checked(id, JobState::Queued, 1.0, String::new()).await.unwrap();
        let starts = 3 * MOST_LOST;
        for _ in 0..starts {
            let launcher: Arc<dyn Launcher> = Arc::new(NoProcess);
            let launchers = BTreeMap::from([("threads", launcher)]);
            let keeper = Keeper::new(store.clone(), root.clone(), launchers, PathBuf::new());
            keeper.turn().await.unwrap();
        }
        let found = store.job(id).await.unwrap().unwrap();
        let state = (found.job.state, found.job.attempt, found.lost);
        assert_eq!(state, (JobState::Starting, starts, 0));
    }
}
