//! Events, tokens and the audit log in the database.

use super::{Store, StoreResult, now};
use crate::cli::Role;
use crate::serve::api::AuditEntry;
use crate::serve::tokens::Identity;
use rusqlite::{OptionalExtension, params};

/// Number of events that a job keeps; older ones are removed.
const MOST_EVENTS: i64 = 10_000;

/// Event of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct JobEvent {
    /// Number, ascending over all jobs.
    pub id: i64,
    /// `state` or `event`.
    pub kind: String,
    /// JSON.
    pub data: String,
}

impl Store {
    /// Stores an event and returns its number.
    ///
    /// # Errors
    /// The database fails.
    pub async fn add_event(&self, job: i64, kind: &'static str, data: String) -> StoreResult<i64> {
        self.call(move |db| {
            let sql = "INSERT INTO event (job, at, kind, data) VALUES (?1, ?2, ?3, ?4)";
            db.prepare_cached(sql)?.execute(params![job, now(), kind, data])?;
            let id = db.last_insert_rowid();
            if id % 100 == 0 {
                let sql = "DELETE FROM event WHERE job = ?1 AND id <= (SELECT id FROM event WHERE \
                           job = ?1 ORDER BY id DESC LIMIT 1 OFFSET ?2)";
                db.execute(sql, params![job, MOST_EVENTS])?;
            }
            Ok(id)
        })
        .await
    }

    /// Returns the first events of a job after a number, at most `limit`.
    ///
    /// # Errors
    /// The database fails.
    pub async fn events(&self, job: i64, after: i64, limit: u32) -> StoreResult<Vec<JobEvent>> {
        self.call(move |db| {
            let sql = "SELECT id, kind, data FROM event WHERE job = ?1 AND id > ?2 ORDER BY id \
                       LIMIT ?3";
            let mut query = db.prepare_cached(sql)?;
            let event = |row: &rusqlite::Row| {
                Ok(JobEvent { id: row.get(0)?, kind: row.get(1)?, data: row.get(2)? })
            };
            query.query_map(params![job, after, limit], event)?.collect()
        })
        .await
    }

    /// Returns the jobs whose present state is not their last event: the service was killed between
    /// the two.
    ///
    /// # Errors
    /// The database fails.
    pub async fn unannounced(&self) -> StoreResult<Vec<i64>> {
        self.call(|db| {
            let sql = "SELECT id FROM job WHERE state != 'incoming' AND state IS NOT (SELECT \
                       json_extract(data, '$.state') FROM event WHERE event.job = job.id AND kind \
                       = 'state' ORDER BY event.id DESC LIMIT 1)";
            db.prepare_cached(sql)?.query_map([], |row| row.get(0))?.collect()
        })
        .await
    }

    /// Stores a token by its hash. Replaces one of the same name.
    ///
    /// # Errors
    /// The database fails.
    pub async fn add_token(&self, name: String, role: Role, hash: String) -> StoreResult<()> {
        let sql = "INSERT OR REPLACE INTO token (name, role, hash, made) VALUES (?1, ?2, ?3, ?4)";
        self.call(move |db| db.execute(sql, params![name, role.name(), hash, now()]).map(drop))
            .await
    }

    /// Removes a token. Returns false if there is none.
    ///
    /// # Errors
    /// The database fails.
    pub async fn remove_token(&self, name: String) -> StoreResult<bool> {
        self.call(move |db| Ok(db.execute("DELETE FROM token WHERE name = ?1", [name])? == 1)).await
    }

    /// Returns the token with this hash.
    ///
    /// # Errors
    /// The database fails.
    pub async fn token(&self, hash: String) -> StoreResult<Option<Identity>> {
        self.call(move |db| {
            let sql = "SELECT name, role FROM token WHERE hash = ?1";
            let row = |row: &rusqlite::Row| {
                let role: String = row.get(1)?;
                Ok((row.get(0)?, role))
            };
            let found: Option<(String, String)> =
                db.prepare_cached(sql)?.query_row([hash], row).optional()?;
            Ok(found.and_then(|(name, role)| Some(Identity { name, role: Role::of_name(&role)? })))
        })
        .await
    }

    /// Returns true if there is a token.
    ///
    /// # Errors
    /// The database fails.
    pub async fn has_tokens(&self) -> StoreResult<bool> {
        let sql = "SELECT count(*) > 0 FROM token";
        self.call(move |db| db.query_row(sql, [], |row| row.get(0))).await
    }

    /// Adds an entry to the audit log.
    ///
    /// # Errors
    /// The database fails.
    pub async fn audit(&self, entry: AuditEntry) -> StoreResult<()> {
        self.call(move |db| {
            let sql = "INSERT INTO audit (at, who, what, job, detail, status) \
                       VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
            let AuditEntry { at, who, what, job, detail, status } = entry;
            db.prepare_cached(sql)?.execute(params![at, who, what, job, detail, status]).map(drop)
        })
        .await
    }

    /// Returns the newest entries of the audit log, the newest first.
    ///
    /// # Errors
    /// The database fails.
    pub async fn audit_log(&self, limit: u32) -> StoreResult<Vec<AuditEntry>> {
        self.call(move |db| {
            let sql =
                "SELECT at, who, what, job, detail, status FROM audit ORDER BY id DESC LIMIT ?1";
            let mut query = db.prepare_cached(sql)?;
            let entry = |row: &rusqlite::Row| {
                Ok(AuditEntry {
                    at: row.get(0)?,
                    who: row.get(1)?,
                    what: row.get(2)?,
                    job: row.get(3)?,
                    detail: row.get(4)?,
                    status: row.get(5)?,
                })
            };
            query.query_map([limit], entry)?.collect()
        })
        .await
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_state_without_its_event_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(&folder.path().join("service.db")).unwrap();
        let id = store.reserve("anna".into()).await.unwrap();
        assert!(store.unannounced().await.unwrap().is_empty(), "its files arrive");
        store.end(id, crate::serve::api::JobState::Failed, 1, String::new()).await.unwrap();
        assert_eq!(store.unannounced().await.unwrap(), [id], "no event");
        let add = |state: &str| store.add_event(id, "state", format!("{{\"state\":\"{state}\"}}"));
        add("running").await.unwrap();
        assert_eq!(store.unannounced().await.unwrap(), [id], "an earlier state");
        add("failed").await.unwrap();
        store.add_event(id, "event", "{}".into()).await.unwrap();
        assert!(store.unannounced().await.unwrap().is_empty());
    }
}
