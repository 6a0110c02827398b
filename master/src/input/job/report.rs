//! Problems of a job, shown with the faulty line.

use super::include::IncludedFile;
use super::mesh::added::AddedMesh;
use super::tree::{Node, Place};
use crate::input::deck;
use crate::input::mesh_file::{Fate, ImportRow};
use crumple_proto::problem::{Problem, Severity};
use std::fmt;
use std::path::PathBuf;

/// Maximum number of problems that are printed; the others are counted.
pub const SHOWN: usize = 50;
/// Maximum number of columns of a source line that are printed.
const WIDTH: usize = 100;

/// A file that was read.
#[derive(Debug)]
pub(crate) struct SourceFile {
    /// Its name as the user gave it.
    pub file: String,
    /// Its text.
    pub text: String,
    /// Its values.
    pub tree: Node,
}

/// All sources of a job: the job file, files that it includes, a mesh file, and `--set` of the
/// command line.
#[derive(Debug)]
pub struct SourceFiles {
    pub(crate) job: SourceFile,
    /// Files that the job includes.
    pub(crate) included: Vec<IncludedFile>,
    pub(crate) mesh: Option<SourceFile>,
    /// The table of the content of a mesh file of another program.
    pub(crate) mesh_rows: Vec<ImportRow>,
    /// The meshes that were added to the mesh.
    pub(crate) added: Vec<AddedMesh>,
    /// Files of the meshes.
    pub(crate) mesh_files: Vec<PathBuf>,
    pub(crate) deck: Option<DeckSource>,
    pub(crate) sets: Vec<String>,
}

/// The files of a deck, and the places of its mesh.
#[derive(Debug)]
pub(crate) struct DeckSource {
    pub files: Vec<deck::Text>,
    pub places: deck::Places,
}

/// Prefix of the path of a problem in a deck.
const DECK: &str = "deck:";

/// Returns the path of a problem at a place of a deck, or of a problem of the whole deck.
pub(crate) fn deck_path(place: Place) -> String {
    match place {
        Place::Deck { file, start, end } => format!("{DECK}{file}:{start}:{end}"),
        _ => "mesh.deck".into(),
    }
}

/// Returns the place in such a path.
pub(crate) fn deck_place(path: &str) -> Option<Place> {
    let mut numbers = path.strip_prefix(DECK)?.split(':').map(|n| n.parse().ok());
    Some(Place::Deck { file: numbers.next()??, start: numbers.next()??, end: numbers.next()?? })
}

/// A problem, and its place if it differs from the place of its path.
#[derive(Debug)]
pub(crate) struct PlacedProblem {
    pub problem: Problem,
    pub place: Option<Place>,
    /// True if it was found in the mesh file.
    pub in_mesh_file: bool,
}

impl From<Problem> for PlacedProblem {
    fn from(problem: Problem) -> Self {
        PlacedProblem { problem, place: None, in_mesh_file: false }
    }
}

/// A problem and its place.
#[derive(Clone, Debug)]
pub struct Located {
    /// The problem.
    pub problem: Problem,
    /// Its place; `None` if no file or argument is the cause.
    pub spot: Option<Spot>,
}

/// A place for the user.
#[derive(Clone, Debug, PartialEq)]
pub enum Spot {
    /// A line of a file.
    Line {
        /// The file as the user gave it.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// The line, or the part of it around the column.
        text: String,
        /// First underlined character of `text`, and their number; none for the line as a whole.
        underline: Option<(usize, usize)>,
    },
    /// An argument `--set ...`.
    Set(String),
}

/// All problems of a job. Its text is complete: file, line, problem and advice.
#[derive(Clone, Debug)]
pub struct Report {
    /// The problems, errors first, then in the order of the file.
    pub problems: Vec<Located>,
}

impl Report {
    /// Exit code of the process: invalid input.
    pub const EXIT_CODE: u8 = crumple_proto::exit_code::BAD_INPUT;

    /// Creates a report of one problem without a place in a file.
    pub fn from_problem(problem: Problem) -> Self {
        Report { problems: vec![Located { problem, spot: None }] }
    }

    pub(crate) fn new(findings: Vec<PlacedProblem>, sources: &SourceFiles) -> Self {
        let mut problems: Vec<Located> = findings.into_iter().map(|f| sources.show(f)).collect();
        problems.sort_by(|a, b| a.order().cmp(&b.order()));
        Report { problems }
    }

    /// Returns the number of problems that prevent the run.
    pub fn errors(&self) -> usize {
        self.problems.iter().filter(|p| p.problem.severity == Severity::Error).count()
    }
}

impl std::error::Error for Report {}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for problem in self.problems.iter().take(SHOWN) {
            writeln!(f, "{problem}")?;
        }
        if self.problems.len() > SHOWN {
            writeln!(f, "... and {} more", self.problems.len() - SHOWN)?;
        }
        match self.errors() {
            1 => writeln!(f, "1 error: nothing was run"),
            n => writeln!(f, "{n} errors: nothing was run"),
        }
    }
}

impl Located {
    fn order(&self) -> (std::cmp::Reverse<Severity>, &str, usize, usize) {
        let severity = std::cmp::Reverse(self.problem.severity);
        match &self.spot {
            Some(Spot::Line { file, line, column, .. }) => (severity, file, *line, *column),
            _ => (severity, "", 0, 0),
        }
    }
}

impl fmt::Display for Located {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = match self.problem.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        writeln!(f, "{word}: {}", self.problem.message)?;
        let mut margin = 1;
        match &self.spot {
            Some(Spot::Line { file, line, column, text, underline }) => {
                margin = line.to_string().len();
                writeln!(f, "{:margin$}--> {file}:{line}:{column}", "")?;
                if let Some((start, length)) = underline {
                    writeln!(f, "{:margin$} |", "")?;
                    writeln!(f, "{line} | {text}")?;
                    writeln!(f, "{:margin$} | {:start$}{}", "", "", "^".repeat(*length))?;
                }
            }
            Some(Spot::Set(argument)) => writeln!(f, "{:margin$}--> --set {argument}", "")?,
            None => {}
        }
        if !self.problem.help.is_empty() {
            writeln!(f, "{:margin$} = help: {}", "", self.problem.help)?;
        }
        Ok(())
    }
}

impl SourceFiles {
    /// Returns the content of mesh files that is left out though it changes the result.
    pub(crate) fn left_out(&self) -> impl Iterator<Item = &ImportRow> {
        let added = self.added.iter().flat_map(|added| &added.rows);
        self.mesh_rows.iter().chain(added).filter(|row| row.fate == Fate::LeftOut)
    }

    /// Finds the line of a problem from its path.
    pub fn locate(&self, problem: &Problem) -> Located {
        self.show(PlacedProblem::from(problem.clone()))
    }

    fn show(&self, finding: PlacedProblem) -> Located {
        let PlacedProblem { problem, place, in_mesh_file } = finding;
        // Below these keys a mesh file replaces the job's [mesh].
        let keys = ["nodes", "shells", "thicknesses", "offsets", "stresses", "node_sets"];
        let inside = keys.iter().any(|key| {
            problem.path.strip_prefix("mesh.").is_some_and(|p| p.split('.').next() == Some(key))
        });
        let (source, path) = match &self.mesh {
            Some(mesh) if inside || in_mesh_file => {
                (mesh, problem.path.strip_prefix("mesh.").unwrap_or_default())
            }
            _ => (&self.job, problem.path.as_str()),
        };
        let written = |deck: &DeckSource| {
            deck_place(&problem.path).or_else(|| deck.places.place_of(&problem.path))
        };
        let place = place.or_else(|| self.deck.as_ref().and_then(written));
        let place = place.unwrap_or_else(|| source.tree.locate(path));
        let spot = match place {
            Place::Set(index) => self.sets.get(index as usize).map(|s| Spot::Set(printable(s))),
            Place::Whole => Some(source.spot(0, None)),
            Place::File { start, end } => Some(source.spot(start as usize, Some(end as usize))),
            Place::Included { file, start, end } => {
                let file = self.included.get(file as usize);
                file.map(|f| {
                    let name = f.path.display().to_string();
                    spot(&name, &f.text, start as usize, Some(end as usize))
                })
            }
            Place::Deck { file, start, end } => {
                let files = self.deck.iter().flat_map(|deck| &deck.files);
                let file = files.into_iter().nth(file as usize);
                file.map(|f| spot(&f.file, &f.text, start as usize, Some(end as usize)))
            }
        };
        Located { problem, spot }
    }
}

impl SourceFile {
    /// Returns the line of a place of this file, from 1.
    pub(crate) fn line(&self, place: Place) -> usize {
        let start = match place {
            Place::File { start, .. } => start as usize,
            _ => 0,
        };
        1 + self.text.bytes().take(start).filter(|&byte| byte == b'\n').count()
    }

    fn spot(&self, start: usize, end: Option<usize>) -> Spot {
        spot(&self.file, &self.text, start, end)
    }
}

/// Returns the place of a range of bytes in a text.
fn spot(file: &str, text: &str, start: usize, end: Option<usize>) -> Spot {
    let mut start = start.min(text.len());
    while !text.is_char_boundary(start) {
        start -= 1;
    }
    let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
    let line_end = text[start..].find('\n').map_or(text.len(), |i| start + i);
    let line = text[..line_start].bytes().filter(|&b| b == b'\n').count() + 1;
    let line_text: Vec<char> = text[line_start..line_end].trim_end_matches('\r').chars().collect();
    let column = text[line_start..start].chars().count();
    let underline = end.map(|end| {
        let length = text[start..].char_indices().take_while(|(i, _)| start + i < end).count();
        (column, length.clamp(1, (line_text.len().saturating_sub(column)).max(1)))
    });
    // A mesh can be one line of a million characters, so only the part around the place is shown.
    let first = if column > WIDTH / 2 && line_text.len() > WIDTH { column - WIDTH / 4 } else { 0 };
    let shown: String = line_text.iter().skip(first).take(WIDTH).collect();
    let underline = underline
        .map(|(at, length)| (at - first, length.min(WIDTH.saturating_sub(at - first)).max(1)));
    Spot::Line {
        file: file.to_string(),
        line,
        column: column + 1,
        text: printable(&shown),
        underline,
    }
}

/// Replaces control characters by blanks, because they could disturb a terminal.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
