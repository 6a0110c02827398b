//! Tables of laws that can be extended: built-in rows, and rows that a program adds before it
//! reads a job.

use std::sync::{PoisonError, RwLock};

/// A row with a name in jobs.
pub trait Named {
    /// Returns the name.
    fn name(&self) -> &'static str;
}

/// A table of rows with built-in and added ones.
pub struct Registry<T: 'static> {
    built_in: &'static [T],
    added: RwLock<Vec<&'static T>>,
}

impl<T: Named + Sync> Registry<T> {
    /// Creates a table of built-in rows.
    pub const fn new(built_in: &'static [T]) -> Self {
        Self { built_in, added: RwLock::new(Vec::new()) }
    }

    /// Adds a row. Call it before the first job is read, because the schema of jobs is built once.
    ///
    /// # Panics
    /// If the table has a row with this name: a job could not select the new one.
    pub fn add(&self, row: &'static T) {
        let mut added = self.added.write().unwrap_or_else(PoisonError::into_inner);
        let mut all = self.built_in.iter().chain(added.iter().copied());
        let is_taken = all.any(|other| other.name() == row.name());
        assert!(
            !is_taken,
            "there is a row `{}` already: give the new row another name",
            row.name()
        );
        added.push(row);
    }

    /// Returns the built-in rows, then the added ones in their order.
    pub fn iter(&self) -> impl Iterator<Item = &'static T> + use<T> {
        let added = self.added.read().unwrap_or_else(PoisonError::into_inner).clone();
        self.built_in.iter().chain(added)
    }
}
