//! Queue, events, tokens and audit log in an SQLite database. An order is answered after it is on
//! disk.

mod jobs;
mod records;

pub use jobs::{Filter, NewJob, StoredJob};

use rusqlite::Connection;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

/// The database.
#[derive(Clone)]
pub struct Store {
    connection: Arc<Mutex<Connection>>,
}

/// Outcome of a call.
pub type StoreResult<T> = rusqlite::Result<T>;

impl Store {
    /// Opens the database, or makes it. Only its owner can read it.
    ///
    /// # Errors
    /// The file cannot be used; the message names it.
    pub fn open(path: &Path) -> Result<Self, String> {
        let named = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        private(path).map_err(|error| named(&error))?;
        let open = || -> StoreResult<Connection> {
            let connection = Connection::open(path)?;
            connection.busy_timeout(std::time::Duration::from_secs(10))?;
            connection.pragma_update(None, "journal_mode", "WAL")?;
            connection.pragma_update(None, "synchronous", "FULL")?;
            connection.execute_batch(include_str!("schema.sql"))?;
            Ok(connection)
        };
        let connection = Arc::new(Mutex::new(open().map_err(|error| named(&error))?));
        Ok(Self { connection })
    }

    /// Calls a function with the database, on a thread where it may wait.
    async fn call<T: Send + 'static>(
        &self,
        body: impl FnOnce(&mut Connection) -> StoreResult<T> + Send + 'static,
    ) -> StoreResult<T> {
        let connection = self.connection.clone();
        let called = tokio::task::spawn_blocking(move || {
            body(&mut connection.lock().unwrap_or_else(PoisonError::into_inner))
        });
        // The call fails as a whole if its thread panics.
        called.await.unwrap_or(Err(rusqlite::Error::InvalidQuery))
    }
}

/// Makes a file that only its owner can read, if there is none.
fn private(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::OpenOptionsExt;
    let file = std::fs::OpenOptions::new().create(true).append(true).mode(0o600).open(path)?;
    drop(file);
    Ok(())
}

/// Returns the seconds since 1970.
pub fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64()
}
