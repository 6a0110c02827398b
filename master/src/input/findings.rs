//! Findings of `crumple check` as typed data: `crumple check --json` prints them, and the service
//! stores and serves them.

use crate::input::job::{Located, Spot};
use crumple_proto::problem::Severity;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Longest message, help or argument [characters]: these may quote text of users.
const LONGEST: usize = 2000;

/// Findings of `crumple check` on a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Findings {
    /// True if the job can run.
    pub usable: bool,
    /// Estimated memory [MB]; 0 if the job cannot run.
    pub memory_mb: f64,
    /// Errors first, then warnings, each in the order of the files; at most 50.
    pub findings: Vec<Finding>,
    /// Number of findings that are not listed.
    pub more: usize,
    /// Description, warnings and errors as a terminal shows them.
    pub text: String,
}

/// An error or a warning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Finding {
    /// Severity.
    pub severity: Level,
    /// The error or the reason of the warning.
    pub message: String,
    /// Remedy; empty if there is none.
    pub help: String,
    /// The line at fault; none if no line is.
    pub place: Option<SourceLine>,
    /// The argument `--set` at fault; none if no argument is.
    pub set: Option<String>,
}

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// The job cannot run.
    Error,
    /// The job can run.
    Warning,
}

/// A line of the input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SourceLine {
    /// File.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The line, or the part of it around the column.
    pub text: String,
    /// The characters of `text` at fault; none for the line as a whole.
    pub mark: Option<Mark>,
}

/// A range of characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Mark {
    /// First character, from 0.
    pub start: usize,
    /// Number of characters, at least 1.
    pub length: usize,
}

impl Findings {
    /// Builds the findings from problems in the order in which they are listed. At most `most` are
    /// listed.
    pub fn new(
        usable: bool,
        memory_mb: f64,
        (problems, most): (&[Located], usize),
        text: String,
    ) -> Self {
        let findings = problems.iter().take(most).map(Finding::from).collect();
        let more = problems.len().saturating_sub(most);
        Self { usable, memory_mb, findings, more, text }
    }

    /// Builds the findings of a check that did not come to its end.
    pub fn refused(message: &str, text: String) -> Self {
        let finding = Finding {
            severity: Level::Error,
            message: shortened(message),
            help: String::new(),
            place: None,
            set: None,
        };
        Self { usable: false, memory_mb: 0.0, findings: vec![finding], more: 0, text }
    }
}

impl From<&Located> for Finding {
    fn from(located: &Located) -> Self {
        let Located { problem, spot } = located;
        let (place, set) = match spot {
            Some(Spot::Line { file, line, column, text, underline }) => {
                let mark = underline.map(|(start, length)| Mark { start, length });
                let (file, text) = (file.clone(), text.clone());
                (Some(SourceLine { file, line: *line, column: *column, text, mark }), None)
            }
            Some(Spot::Set(argument)) => (None, Some(shortened(argument))),
            None => (None, None),
        };
        let severity = match problem.severity {
            Severity::Error => Level::Error,
            Severity::Warning => Level::Warning,
        };
        let (message, help) = (shortened(&problem.message), shortened(&problem.help));
        Self { severity, message, help, place, set }
    }
}

fn shortened(text: &str) -> String {
    text.chars().take(LONGEST).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::problem::Problem;

    #[test]
    fn a_finding_has_its_line_or_its_argument() {
        let problem = Problem::error("a", "x".repeat(LONGEST + 1), "help");
        let spot = Spot::Line {
            file: "job.toml".into(),
            line: 3,
            column: 5,
            text: "a = <b>".into(),
            underline: Some((4, 3)),
        };
        let finding = Finding::from(&Located { problem: problem.clone(), spot: Some(spot) });
        let place = finding.place.unwrap();
        assert_eq!((place.line, place.column, &place.text[..]), (3, 5, "a = <b>"));
        assert_eq!(place.mark, Some(Mark { start: 4, length: 3 }));
        assert_eq!((finding.message.len(), finding.set), (LONGEST, None));
        let set = Some(Spot::Set("a=1".into()));
        let finding = Finding::from(&Located { problem, spot: set });
        assert_eq!((finding.place, finding.set.as_deref()), (None, Some("a=1")));
    }

    #[test]
    fn findings_that_are_not_listed_are_counted() {
        let one = Located { problem: Problem::warning("", "m", ""), spot: None };
        let found = Findings::new(true, 1.0, (&vec![one; 5], 3), String::new());
        assert_eq!((found.findings.len(), found.more), (3, 2));
        assert_eq!(found.findings[0].severity, Level::Warning);
    }
}
