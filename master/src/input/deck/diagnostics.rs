//! What is wrong with a deck so far.

use crate::input::job::report::Finding;
use crate::input::job::tree::Place;
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
    /// Lines with a field that could not be read: nothing else is said of what stands in them.
    misread: Vec<(u32, u32, u32)>,
}

impl Trouble {
    /// Notes what keeps the run from starting.
    pub fn error(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        let within = |&(of, from, to): &(u32, u32, u32)| matches!(place, Place::Deck { file, start, end } if file == of && start >= from && end <= to);
        if self.misread.iter().any(within) {
            return;
        }
        self.add_error(place, message, help);
    }

    /// Notes a field of a line that cannot be read, those of one kind once.
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

    /// Notes what the user should know of.
    pub fn warning(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        if self.list.len() < KEPT {
            self.add(Problem::warning("", message, help), place);
        }
    }

    /// The same, unless this kind has been warned of already.
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
            self.add(
                Problem::error("", message, "correct those that are listed first"),
                Place::Whole,
            );
        }
        self.list
    }
}
