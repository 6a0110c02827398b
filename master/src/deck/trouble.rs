//! What is wrong with a deck so far.

use crate::job::report::Finding;
use crate::job::tree::Place;
use crumple_proto::problem::Problem;
use std::collections::HashSet;

/// Problems that are kept one by one; those of a mesh of millions would fill the memory.
const KEPT: usize = 500;

/// Everything that is wrong, each with its place.
#[derive(Debug, Default)]
pub struct Trouble {
    pub(crate) list: Vec<Finding>,
    /// Errors that were not kept.
    more: usize,
    warned: HashSet<String>,
    /// Whether a card could not be read: what refers to it would be blamed for that.
    unsure: bool,
}

impl Trouble {
    /// Notes what keeps the run from starting.
    pub fn error(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        if self.list.len() < KEPT {
            self.add(Problem::error("", message, help), place);
        } else {
            self.more += 1;
        }
    }

    /// Notes what the user should know of.
    pub fn warning(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        if self.list.len() < KEPT {
            self.add(Problem::warning("", message, help), place);
        }
    }

    /// The same, unless this kind has been warned of already.
    pub fn warn_once(&mut self, kind: &str, place: Place, message: impl Into<String>, help: impl Into<String>) {
        if self.warned.insert(kind.to_string()) {
            self.warning(place, message, help);
        }
    }

    /// Notes that a card could not be read as a whole.
    pub fn unsure(&mut self) {
        self.unsure = true;
    }

    /// Whether what refers to something that is not there may be right.
    pub fn is_unsure(&self) -> bool {
        self.unsure
    }

    fn add(&mut self, problem: Problem, place: Place) {
        self.list.push(super::placed(problem, place));
    }

    /// All that was noted.
    pub(crate) fn into_findings(mut self) -> Vec<Finding> {
        if self.more > 0 {
            let message = format!("{} more errors in the deck are not listed", self.more);
            self.add(Problem::error("", message, "correct those that are listed first"), Place::Whole);
        }
        self.list
    }
}
