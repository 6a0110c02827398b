//! Problems of a deck.

use crate::input::job::report::PlacedProblem;
use crate::input::job::tree::Place;
use crumple_proto::problem::{Problem, Severity};
use std::collections::{HashMap, HashSet};

/// Maximum number of problems that are stored singly. Those of a mesh of millions would fill the
/// memory.
const KEPT: usize = 500;
/// Maximum number of problems of one kind that are stored singly: a repeated mistake must not hide
/// the others.
const KEPT_OF_KIND: usize = 5;

/// Problems that differ only by numbers and values.
#[derive(Debug, Default)]
struct ProblemKind {
    /// Number of stored problems.
    stored: usize,
    /// Number of others.
    more: usize,
    /// Index of the last stored one.
    last: usize,
}

/// All problems, each with its place.
#[derive(Debug, Default)]
pub struct Trouble {
    list: Vec<(Problem, Place)>,
    kinds: HashMap<String, ProblemKind>,
    /// Number of errors of kinds of which none was stored.
    more: usize,
    warned: HashSet<String>,
    /// True if a card could not be read. References to it would be reported as errors.
    unsure: bool,
    /// The error that makes all other problems void.
    only: Option<(Problem, Place)>,
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

    /// Adds the error that makes all other problems void, those before and after it.
    pub fn only(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        self.unsure = true;
        self.only = Some((Problem::error("", message, help), place));
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
        self.add(Problem::error("", message, help), place);
    }

    /// Adds a warning.
    pub fn warning(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        self.add(Problem::warning("", message, help), place);
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

    /// Stores a problem, or counts it if there are several of its kind.
    fn add(&mut self, problem: Problem, place: Place) {
        let full = self.list.len() >= KEPT;
        let kind = self.kinds.entry(kind_of(&problem)).or_default();
        if kind.stored < KEPT_OF_KIND && !full {
            kind.stored += 1;
            kind.last = self.list.len();
            self.list.push((problem, place));
        } else if kind.stored > 0 {
            kind.more += 1;
        } else if problem.severity == Severity::Error {
            self.more += 1;
        }
    }

    /// Returns true if there is an error.
    pub fn has_errors(&self) -> bool {
        self.only.is_some()
            || self.list.iter().any(|(problem, _)| problem.severity == Severity::Error)
    }

    /// Returns the places of all problems that are stored.
    pub fn places(&self) -> impl Iterator<Item = Place> + '_ {
        self.list.iter().map(|(_, place)| *place)
    }

    /// Returns all problems. The last one of a kind that occurs often has the number of the others.
    pub(crate) fn into_findings(mut self) -> Vec<PlacedProblem> {
        if let Some((problem, place)) = self.only {
            return vec![super::placed(problem, place)];
        }
        for kind in self.kinds.values().filter(|kind| kind.more > 0) {
            self.list[kind.last].0.message += &format!("; and {} more of this kind", kind.more);
        }
        if self.more > 0 {
            let message = format!("{} more errors in the deck are not listed", self.more);
            let problem = Problem::error("", message, "correct the listed errors first");
            self.list.push((problem, Place::Whole));
        }
        self.list.into_iter().map(|(problem, place)| super::placed(problem, place)).collect()
    }
}

/// Returns the text of a problem without numbers, and without a value that it quotes at its end.
fn kind_of(problem: &Problem) -> String {
    let message = problem.message.split(", not `").next().unwrap_or_default();
    let plain = message.split(|c: char| c.is_ascii_digit()).filter(|part| !part.is_empty());
    format!("{:?} {}", problem.severity, plain.collect::<Vec<_>>().join("#"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mistake in a thousand lines is listed a few times, with the number of the others; other
    /// mistakes are listed as well.
    #[test]
    fn a_repeated_mistake_does_not_fill_the_list() {
        let mut trouble = Trouble::default();
        for line in 0..1000 {
            let place = Place::Deck { file: 0, start: line, end: line };
            trouble.error(place, format!("`x` has to be a number, not `{line}.x`"), "help");
        }
        trouble.error(Place::Whole, "another mistake", "help");
        let found = trouble.into_findings();
        assert_eq!(found.len(), KEPT_OF_KIND + 1);
        assert!(found[4].problem.message.ends_with("`4.x`; and 995 more of this kind"));
        assert_eq!(found[5].problem.message, "another mistake");
    }
}
