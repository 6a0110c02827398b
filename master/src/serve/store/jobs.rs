//! Jobs in the database.

use super::{Store, StoreResult, now};
use crate::serve::api::{JobState, ServiceJob};
use rusqlite::types::Value;
use rusqlite::{OptionalExtension, Row, params, params_from_iter};
use strum::IntoEnumIterator;

/// State of a job whose files are still arriving. Clients do not see it.
const INCOMING: &str = "incoming";
/// Values of the column `stopping`.
const ASKED: u8 = 1;
const FORCED: u8 = 2;
const COLUMNS: &str = "id, name, owner, state, priority, workers, launcher, main, sets, retries, \
                       memory_mb, submitted, started, ended, code, reason, attempt, stopping, \
                       later_sets, handle, lost, check_only";

/// A job with what only the service needs.
#[derive(Clone, Debug)]
pub struct StoredJob {
    /// The job as clients see it.
    pub job: ServiceJob,
    /// Changes given when it was resumed.
    pub later_sets: Vec<String>,
    /// Name of the process at its launcher, such as a number of Slurm.
    pub handle: String,
    /// Number of processes that were lost since its last order to start.
    pub lost: u32,
    /// True if it is only checked.
    pub check_only: bool,
}

/// A job to be stored.
#[derive(Clone, Debug)]
pub struct NewJob {
    /// Name.
    pub name: String,
    /// Name of the token.
    pub owner: String,
    /// Priority.
    pub priority: i32,
    /// Number of workers.
    pub workers: u32,
    /// Launcher.
    pub launcher: String,
    /// Job file in its folder of input.
    pub main: String,
    /// Changes of the job.
    pub sets: Vec<String>,
    /// Number of retries.
    pub retries: u32,
    /// True if it is only checked.
    pub check_only: bool,
}

/// Jobs that a list shows.
#[derive(Clone, Debug, Default)]
pub struct Filter {
    /// Only jobs in this state.
    pub state: Option<JobState>,
    /// Only jobs of this owner.
    pub owner: Option<String>,
    /// Only jobs whose name contains this text.
    pub name: Option<String>,
    /// Only jobs with smaller numbers.
    pub before: Option<i64>,
    /// Largest number of jobs.
    pub limit: u32,
}

fn list(text: String) -> Vec<String> {
    serde_json::from_str(&text).unwrap_or_default()
}

fn text(list: &[String]) -> String {
    serde_json::to_string(list).unwrap_or_default()
}

fn stored(row: &Row) -> StoreResult<StoredJob> {
    let state: String = row.get(3)?;
    Ok(StoredJob {
        job: ServiceJob {
            id: row.get(0)?,
            name: row.get(1)?,
            owner: row.get(2)?,
            state: state.parse().unwrap_or(JobState::Lost),
            priority: row.get(4)?,
            workers: row.get(5)?,
            launcher: row.get(6)?,
            job: row.get(7)?,
            set: list(row.get(8)?),
            retries: row.get(9)?,
            memory_mb: row.get(10)?,
            submitted: row.get(11)?,
            started: row.get(12)?,
            ended: row.get(13)?,
            code: row.get(14)?,
            reason: row.get(15)?,
            attempt: row.get(16)?,
            stopping: row.get(17)?,
            forced: row.get::<_, u8>(17)? == FORCED,
        },
        later_sets: list(row.get(18)?),
        handle: row.get(19)?,
        lost: row.get(20)?,
        check_only: row.get(21)?,
    })
}

impl Store {
    /// Returns a number for a job whose files are about to arrive.
    ///
    /// # Errors
    /// The database fails.
    pub async fn reserve(&self, owner: String) -> StoreResult<i64> {
        self.call(move |db| {
            let sql = "INSERT INTO job (name, owner, state, priority, workers, launcher, main, \
                       sets, retries, submitted) VALUES ('', ?1, ?2, 0, 1, '', '', '[]', 0, ?3)";
            db.execute(sql, params![owner, INCOMING, now()])?;
            Ok(db.last_insert_rowid())
        })
        .await
    }

    /// Stores a job whose files are complete. From here on it is not lost.
    ///
    /// # Errors
    /// The database fails.
    pub async fn submit(&self, id: i64, new: NewJob) -> StoreResult<()> {
        self.call(move |db| {
            let sql = "UPDATE job SET name = ?2, owner = ?3, state = ?4, priority = ?5, workers = \
                       ?6, launcher = ?7, main = ?8, sets = ?9, retries = ?10, check_only = ?11, \
                       submitted = ?12 WHERE id = ?1";
            let state = JobState::Checking.name();
            let NewJob { name, owner, priority, workers, launcher, main, sets, .. } = new;
            let sets = text(&sets);
            let values = params![
                id,
                name,
                owner,
                state,
                priority,
                workers,
                launcher,
                main,
                sets,
                new.retries,
                new.check_only,
                now()
            ];
            db.execute(sql, values).map(drop)
        })
        .await
    }

    /// Forgets a number whose files did not arrive.
    ///
    /// # Errors
    /// The database fails.
    pub async fn forget(&self, id: i64) -> StoreResult<()> {
        let sql = "DELETE FROM job WHERE id = ?1 AND state = ?2";
        self.call(move |db| db.execute(sql, params![id, INCOMING]).map(drop)).await
    }

    /// Returns the numbers whose files did not arrive before the service ended.
    ///
    /// # Errors
    /// The database fails.
    pub async fn incoming(&self) -> StoreResult<Vec<i64>> {
        self.call(|db| {
            let mut query = db.prepare("SELECT id FROM job WHERE state = ?1")?;
            query.query_map([INCOMING], |row| row.get(0))?.collect()
        })
        .await
    }

    /// Returns a job.
    ///
    /// # Errors
    /// The database fails.
    pub async fn job(&self, id: i64) -> StoreResult<Option<StoredJob>> {
        self.call(move |db| {
            let sql = format!("SELECT {COLUMNS} FROM job WHERE id = ?1 AND state != ?2");
            db.prepare_cached(&sql)?.query_row(params![id, INCOMING], stored).optional()
        })
        .await
    }

    /// Returns all jobs in a state, in the order in which they start.
    ///
    /// # Errors
    /// The database fails.
    pub async fn in_state(&self, state: JobState) -> StoreResult<Vec<StoredJob>> {
        self.call(move |db| {
            let sql =
                format!("SELECT {COLUMNS} FROM job WHERE state = ?1 ORDER BY priority DESC, id");
            let mut query = db.prepare_cached(&sql)?;
            query.query_map([state.name()], stored)?.collect()
        })
        .await
    }

    /// Returns the jobs that match, the newest first, and the number of all that match.
    ///
    /// # Errors
    /// The database fails.
    pub async fn list(&self, filter: Filter) -> StoreResult<(Vec<ServiceJob>, i64)> {
        self.call(move |db| {
            let mut clauses = vec!["state != ?".to_string()];
            let mut values: Vec<Value> = vec![INCOMING.to_string().into()];
            if let Some(state) = filter.state {
                clauses.push("state = ?".into());
                values.push(state.name().to_string().into());
            }
            if let Some(owner) = filter.owner {
                clauses.push("owner = ?".into());
                values.push(owner.into());
            }
            if let Some(name) = filter.name {
                clauses.push("instr(lower(name), lower(?)) > 0".into());
                values.push(name.into());
            }
            let all = clauses.join(" AND ");
            let total = db
                .prepare_cached(&format!("SELECT count(*) FROM job WHERE {all}"))?
                .query_row(params_from_iter(values.iter()), |row| row.get(0))?;
            let mut page = all;
            if let Some(before) = filter.before {
                page += " AND id < ?";
                values.push(before.into());
            }
            values.push(i64::from(filter.limit).into());
            let sql = format!("SELECT {COLUMNS} FROM job WHERE {page} ORDER BY id DESC LIMIT ?");
            let mut query = db.prepare_cached(&sql)?;
            let rows = query.query_map(params_from_iter(values.iter()), stored)?;
            let jobs: StoreResult<Vec<ServiceJob>> =
                rows.map(|row| row.map(|stored| stored.job)).collect();
            Ok((jobs?, total))
        })
        .await
    }

    /// Returns the number of jobs in each state.
    ///
    /// # Errors
    /// The database fails.
    pub async fn counts(&self) -> StoreResult<Vec<(JobState, i64)>> {
        self.call(|db| {
            let mut query = db.prepare_cached("SELECT state, count(*) FROM job GROUP BY state")?;
            let rows = query.query_map([], |row| Ok((row.get::<_, String>(0)?, row.get(1)?)))?;
            let found: Vec<(String, i64)> = rows.collect::<StoreResult<_>>()?;
            let count = |state: JobState| {
                found.iter().find(|(name, _)| name == state.name()).map_or(0, |(_, n)| *n)
            };
            Ok(JobState::iter().map(|state| (state, count(state))).collect())
        })
        .await
    }

    /// Returns the number of jobs that arrive, wait or run.
    ///
    /// # Errors
    /// The database fails.
    pub async fn open_jobs(&self) -> StoreResult<i64> {
        let sql = "SELECT count(*) FROM job WHERE state IN \
                   ('incoming', 'checking', 'queued', 'starting', 'running')";
        self.call(move |db| db.query_row(sql, [], |row| row.get(0))).await
    }

    /// Stores the result of the check. Returns false if the job is no longer being checked.
    ///
    /// # Errors
    /// The database fails.
    pub async fn checked(
        &self,
        id: i64,
        state: JobState,
        memory: f64,
        why: String,
    ) -> StoreResult<bool> {
        self.call(move |db| {
            let sql = "UPDATE job SET state = ?2, memory_mb = ?3, reason = ?4, code = ?5, ended = \
                       ?6 WHERE id = ?1 AND state = 'checking'";
            let refused = state == JobState::Refused;
            let code = refused.then_some(crumple_proto::exit_code::BAD_INPUT);
            let ended = refused.then(now);
            Ok(db.execute(sql, params![id, state.name(), memory, why, code, ended])? == 1)
        })
        .await
    }

    /// Changes a job that waits to `starting`, and gives it a new attempt. Returns false if it no
    /// longer waits.
    ///
    /// # Errors
    /// The database fails.
    pub async fn start_attempt(&self, id: i64) -> StoreResult<bool> {
        self.call(move |db| {
            let sql = "UPDATE job SET state = 'starting', attempt = attempt + 1, handle = '', \
                       started = ?2, ended = NULL, code = NULL, reason = '' \
                       WHERE id = ?1 AND state = 'queued' AND NOT stopping";
            Ok(db.execute(sql, params![id, now()])? == 1)
        })
        .await
    }

    /// Stores the name of the process at its launcher.
    ///
    /// # Errors
    /// The database fails.
    pub async fn set_handle(&self, id: i64, handle: String) -> StoreResult<()> {
        let sql = "UPDATE job SET handle = ?2 WHERE id = ?1";
        self.call(move |db| db.execute(sql, params![id, handle]).map(drop)).await
    }

    /// Changes the state of an active job to `running`.
    ///
    /// # Errors
    /// The database fails.
    pub async fn runs(&self, id: i64) -> StoreResult<bool> {
        let sql = "UPDATE job SET state = 'running' WHERE id = ?1 AND state = 'starting'";
        self.call(move |db| Ok(db.execute(sql, [id])? == 1)).await
    }

    /// Ends a job.
    ///
    /// # Errors
    /// The database fails.
    pub async fn end(&self, id: i64, state: JobState, code: u8, reason: String) -> StoreResult<()> {
        self.call(move |db| {
            let sql = "UPDATE job SET state = ?2, code = ?3, reason = ?4, ended = ?5, stopping = 0 \
                       WHERE id = ?1";
            db.execute(sql, params![id, state.name(), code, reason, now()]).map(drop)
        })
        .await
    }

    /// Queues an active job again: its process was lost. One that is to stop stays as it is.
    ///
    /// # Errors
    /// The database fails.
    pub async fn requeue(&self, id: i64, lost: u32, reason: String) -> StoreResult<()> {
        let sql = "UPDATE job SET state = 'queued', lost = ?2, reason = ?3 \
                   WHERE id = ?1 AND state IN ('starting', 'running') AND NOT stopping";
        self.call(move |db| db.execute(sql, params![id, lost, reason]).map(drop)).await
    }

    /// Notes that a job is to stop; with `forced`, that its processes are to be killed. One that
    /// has no process ends at once. Returns its state before, or `None` if there is none or it has
    /// ended.
    ///
    /// # Errors
    /// The database fails.
    pub async fn stop(&self, id: i64, who: String, forced: bool) -> StoreResult<Option<JobState>> {
        self.call(move |db| {
            let tx = db.transaction()?;
            let sql = "SELECT state FROM job WHERE id = ?1";
            let state: Option<String> = tx.query_row(sql, [id], |row| row.get(0)).optional()?;
            let state = state.and_then(|name| name.parse().ok());
            let waits = matches!(state, Some(JobState::Checking | JobState::Queued));
            let open = state.filter(|state| !state.is_final());
            if waits {
                let reason = format!("cancelled by {who}");
                let sql = "UPDATE job SET state = 'stopped', code = 130, reason = ?2, ended = ?3 \
                           WHERE id = ?1";
                tx.execute(sql, params![id, reason, now()])?;
            } else if open.is_some() {
                let sql = "UPDATE job SET stopping = MAX(stopping, ?2) WHERE id = ?1";
                tx.execute(sql, params![id, if forced { FORCED } else { ASKED }])?;
            }
            tx.commit()?;
            Ok(open)
        })
        .await
    }

    /// Queues a job that has ended. Returns false if it has not.
    ///
    /// # Errors
    /// The database fails.
    pub async fn resume(&self, id: i64, workers: u32, sets: Vec<String>) -> StoreResult<bool> {
        self.call(move |db| {
            let sql = "UPDATE job SET state = 'queued', workers = ?2, later_sets = ?3, lost = 0, \
                       stopping = 0, code = NULL, ended = NULL, reason = '' WHERE id = ?1 AND \
                       state IN ('checked', 'completed', 'failed', 'lost', 'stopped')";
            Ok(db.execute(sql, params![id, workers, text(&sets)])? == 1)
        })
        .await
    }
}
