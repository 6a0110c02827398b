//! The format of a deck, by its content.

use super::diagnostics::Trouble;
use crate::input::confine;
use crate::input::job::tree::Place;
use crate::input::mesh_file;
use std::io::Read;
use std::path::Path;

/// Bytes at the begin of a file by which its format is found.
const HEAD: u64 = 64 * 1024;

/// End of the name of an engine file.
const ENGINE: &str = "_0001.rad";

/// Format of a deck.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeckFormat {
    /// LS-DYNA.
    LsDyna,
    /// Radioss.
    Radioss,
}

impl DeckFormat {
    /// Returns its name with an article, and the end of the names of its files.
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            DeckFormat::LsDyna => ("an LS-DYNA keyword deck", ".k"),
            DeckFormat::Radioss => ("a Radioss starter file", "_0000.rad"),
        }
    }
}

/// Returns the format of a file that is certainly a deck, whatever its name.
pub fn of_file(path: &Path) -> Option<DeckFormat> {
    let (head, _) = head(path);
    of_content(&head).filter(|_| is_ls_dyna(&head) || is_radioss(&head))
}

/// Returns the format of a deck, and `None` after an error for a file of another format. Warns of
/// a name that is for the other format.
pub fn format(path: &Path, trouble: &mut Trouble) -> Option<DeckFormat> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let by_name = match extension.as_deref() {
        Some("rad") => DeckFormat::Radioss,
        _ => DeckFormat::LsDyna,
    };
    let (head, length) = head(path);
    let found = of_content(&head);
    if !is_ls_dyna(&head) && !is_radioss(&head) && is_other(path, (&head, length), trouble) {
        return None;
    }
    if let Some(format) = found.filter(|format| *format != by_name) {
        let (is, ending) = format.names();
        let message = format!("{} is {is}, by its content", path.display());
        let help = format!("it is read as such; rename it so that it ends in {ending}");
        trouble.warning(Place::Whole, message, help);
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if let Some(base) = name.strip_suffix(ENGINE) {
        let message = format!("{} is an engine file", path.display());
        let help = format!("name the starter file {base}_0000.rad, which is read with it");
        trouble.error(Place::Whole, message, help);
    }
    Some(found.unwrap_or(by_name))
}

/// Returns the begin of a file, empty if it cannot be read, and its length [byte].
fn head(path: &Path) -> (Vec<u8>, usize) {
    let mut head = Vec::new();
    let mut length = 0;
    if confine::check(path).is_ok()
        && path.is_file()
        && let Ok(file) = std::fs::File::open(path)
    {
        length = file.metadata().map_or(0, |data| data.len() as usize);
        // The reader of the deck reports a file that cannot be read.
        let _ = file.take(HEAD).read_to_end(&mut head);
    }
    (head, length)
}

/// Returns the format of the first keyword; `None` if there is none.
fn of_content(head: &[u8]) -> Option<DeckFormat> {
    head.split(|&b| b == b'\n').find_map(|line| match line.first() {
        Some(b'*') if keyword(line).is_some() => Some(DeckFormat::LsDyna),
        Some(b'/') if line.get(1).is_some_and(u8::is_ascii_alphabetic) => Some(DeckFormat::Radioss),
        Some(b'#') if line.to_ascii_uppercase().starts_with(b"#RADIOSS") => {
            Some(DeckFormat::Radioss)
        }
        _ => None,
    })
}

/// Returns the keyword of a line, without its asterisk and what follows a blank or comma.
fn keyword(line: &[u8]) -> Option<&[u8]> {
    let rest =
        line.strip_prefix(b"*").filter(|rest| rest.first().is_some_and(u8::is_ascii_alphabetic))?;
    let end = rest.iter().position(|&b| b.is_ascii_whitespace() || b == b',');
    Some(&rest[..end.unwrap_or(rest.len())])
}

/// Returns true for a deck of LS-DYNA. Its first keyword is `*KEYWORD`, or a keyword has `_`, as no
/// keyword of Abaqus has.
pub fn is_ls_dyna(head: &[u8]) -> bool {
    let mut keywords = head.split(|&b| b == b'\n').filter_map(keyword);
    of_content(head) == Some(DeckFormat::LsDyna)
        && keywords.any(|word| word.contains(&b'_') || word.eq_ignore_ascii_case(b"KEYWORD"))
}

/// Returns true for a starter of Radioss: it has a line `#RADIOSS` or `/BEGIN`.
pub fn is_radioss(head: &[u8]) -> bool {
    head.split(|&b| b == b'\n')
        .any(|line| line.starts_with(b"#RADIOSS") || line.trim_ascii_end() == b"/BEGIN")
}

/// Returns true if a keyword has a parameter with a value, or is a heading, as in Abaqus.
fn has_parameters(head: &[u8]) -> bool {
    head.split(|&b| b == b'\n').any(|line| {
        let value = line.contains(&b'=') && line.contains(&b',');
        keyword(line).is_some_and(|word| value || word.eq_ignore_ascii_case(b"HEADING"))
    })
}

/// Reports a file of another format. Returns true if it is one.
fn is_other(path: &Path, (head, length): (&[u8], usize), trouble: &mut Trouble) -> bool {
    let shown = path.display();
    let Some(format) = mesh_file::format_of(head, length) else { return false };
    // Keywords that both have, such as *NODE, are no sign of Abaqus.
    if format.name == mesh_file::ABAQUS && !has_parameters(head) {
        return false;
    }
    let message = format!("{shown} is a file of the format {}, not a deck", format.name);
    let help = match format.refusal() {
        Some(cure) => cure.to_string(),
        None => {
            format!("write a job for it: crumple import {shown}; or name it by mesh.file of a job")
        }
    };
    trouble.error(Place::Whole, message, help);
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first keyword shows the format; comments and text do not.
    #[test]
    fn the_first_keyword_shows_the_format() {
        let of = |text: &str| of_content(text.as_bytes());
        assert_eq!(of("$ /BEGIN\n*KEYWORD\n"), Some(DeckFormat::LsDyna));
        assert_eq!(of("#RADIOSS STARTER\n/BEGIN\n"), Some(DeckFormat::Radioss));
        assert_eq!(of("# text\n/NODE\n"), Some(DeckFormat::Radioss));
        assert_eq!(of("some text\n1,2,3\n"), None);
        assert_eq!(of(""), None);
    }

    /// A deck without `*KEYWORD` has keywords with `_`; an Abaqus file has none, also if its names
    /// have some.
    #[test]
    fn keywords_show_which_of_both_it_is() {
        assert!(is_ls_dyna(b"*KEYWORD\r\n*NODE\r\n"));
        assert!(is_ls_dyna(b"*keyword memory=20m\n*NODE\n"));
        assert!(is_ls_dyna(b"a title\n*NODE\n1,0,0,0\n*ELEMENT_SHELL\n"));
        let abaqus = b"** a_b\n*NODE, NSET=a_b\n1,0,0,0\n*SHELL SECTION, ELSET=a_b\n";
        assert!(!is_ls_dyna(abaqus) && has_parameters(abaqus));
        assert!(!is_ls_dyna(b"*NODE\n1,0,0,0\n*END\n") && !has_parameters(b"*NODE\n1,a=b\n"));
        assert!(!is_ls_dyna(b"/BEGIN\n*A_B\n"));
    }
}
