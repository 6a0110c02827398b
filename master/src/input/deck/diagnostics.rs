//! Problems of a deck.

use crate::input::job::report::PlacedProblem;
use crate::input::job::tree::Place;
use crumple_proto::problem::Problem;
use std::collections::HashSet;

/// Maximum number of problems that are stored singly. Those of a mesh of millions would fill the
/// memory.
const KEPT: usize = 500;

/// All problems, each with its place.
#[derive(Debug, Default)]
pub struct Trouble {
    pub(crate) list: Vec<PlacedProblem>,
    /// Number of errors that were not stored.
    more: usize,
    warned: HashSet<String>,
    /// True if a card could not be read. References to it would be reported as errors.
    unsure: bool,
    /// Lines with a field that could not be read. Further problems of these lines are suppressed.
    misread: Vec<(u32, u32, u32)>,
}

impl Trouble {
    /// Adds an error, which prevents the run.
    pub fn error(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        let within = |&(of, from, to): &(u32, u32, u32)| {
            matches!(
                place,
                Place::Deck { file, start, end } if file == of && start >= from && end <= to
            )
        };
        if self.misread.iter().any(within) {
            return;
        }
        self.add_error(place, message, help);
    }

    /// Reports a field that cannot be read, once for each kind.
    pub fn misread(
        &mut self,
        line: Place,
        kind: Option<&str>,
        place: Place,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.unsure = true;
        if kind.is_none_or(|kind| self.warned.insert(kind.to_string())) {
            self.add_error(place, message, help);
        }
        let Place::Deck { file, start, end } = line else { return };
        if self.misread.len() < KEPT && self.misread.last() != Some(&(file, start, end)) {
            self.misread.push((file, start, end));
        }
    }

    fn add_error(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        if self.list.len() < KEPT {
            self.add(Problem::error("", message, help), place);
        } else {
            self.more += 1;
        }
    }

    /// Adds a warning.
    pub fn warning(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        if self.list.len() < KEPT {
            self.add(Problem::warning("", message, help), place);
        }
    }

    /// Adds a warning, unless there is one of this kind already.
    pub fn warn_once(
        &mut self,
        kind: &str,
        place: Place,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        if self.warned.insert(kind.to_string()) {
            self.warning(place, message, help);
        }
    }

    /// Notes that a card could not be read as a whole.
    pub fn unsure(&mut self) {
        self.unsure = true;
    }

    /// Returns true if a missing reference may be valid, because a card could not be read.
    pub fn is_unsure(&self) -> bool {
        self.unsure
    }

    fn add(&mut self, problem: Problem, place: Place) {
        self.list.push(super::placed(problem, place));
    }

    /// Returns all problems.
    pub(crate) fn into_findings(mut self) -> Vec<PlacedProblem> {
        if self.more > 0 {
            let message = format!("{} more errors in the deck are not listed", self.more);
            self.add(Problem::error("", message, "correct the listed errors first"), Place::Whole);
        }
        self.list
    }
}
