//! Problems of a job, described such that its author can correct them.

use std::fmt;

/// Severity of a [`Problem`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The run continues.
    Warning,
    /// The run does not start.
    Error,
}

/// One problem: its location, description and remedy.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Severity.
    pub severity: Severity,
    /// Path of the key in the job, such as `part.0.thickness`; empty if no key is at fault.
    pub path: String,
    /// Description, with the name of the entity.
    pub message: String,
    /// Remedy.
    pub help: String,
}

impl Problem {
    /// Builds a problem that prevents the run from starting.
    pub fn error(
        path: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self {
            severity: Severity::Error,
            path: path.into(),
            message: message.into(),
            help: help.into(),
        }
    }

    /// Builds a warning to the user.
    pub fn warning(
        path: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self {
            severity: Severity::Warning,
            path: path.into(),
            message: message.into(),
            help: help.into(),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.message)?;
        if !self.help.is_empty() {
            write!(f, " ({})", self.help)?;
        }
        Ok(())
    }
}
