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

/// Returns the format of a deck. Reports a file of another format, and one whose name is for the
/// other format.
pub fn format(path: &Path, trouble: &mut Trouble) -> DeckFormat {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let by_name = match extension.as_deref() {
        Some("rad") => DeckFormat::Radioss,
        _ => DeckFormat::LsDyna,
    };
    let head = head(path);
    let found = of_content(&head);
    match found {
        Some(format) if format != by_name => {
            let (is, ending) = match format {
                DeckFormat::LsDyna => ("an LS-DYNA keyword deck", ".k"),
                DeckFormat::Radioss => ("a Radioss starter file", "_0000.rad"),
            };
            let message = format!("{} is {is}, by its content", path.display());
            let help = format!("it is read as such; rename it so that it ends in {ending}");
            trouble.warning(Place::Whole, message, help);
        }
        None => report_other(path, &head, trouble),
        Some(_) => {}
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if let Some(base) = name.strip_suffix(ENGINE) {
        let message = format!("{} is an engine file", path.display());
        let help = format!("name the starter file {base}_0000.rad, which is read with it");
        trouble.error(Place::Whole, message, help);
    }
    found.unwrap_or(by_name)
}

/// Returns the begin of a file, empty if it cannot be read.
fn head(path: &Path) -> Vec<u8> {
    let mut head = Vec::new();
    if confine::check(path).is_ok()
        && path.is_file()
        && let Ok(file) = std::fs::File::open(path)
    {
        // The reader of the deck reports a file that cannot be read.
        let _ = file.take(HEAD).read_to_end(&mut head);
    }
    head
}

/// Returns the format of the first keyword; `None` if there is none.
fn of_content(head: &[u8]) -> Option<DeckFormat> {
    head.split(|&b| b == b'\n').find_map(|line| match line.first() {
        Some(b'*') if line.get(1).is_some_and(u8::is_ascii_alphabetic) => Some(DeckFormat::LsDyna),
        Some(b'/') if line.get(1).is_some_and(u8::is_ascii_alphabetic) => Some(DeckFormat::Radioss),
        Some(b'#') if line.to_ascii_uppercase().starts_with(b"#RADIOSS") => {
            Some(DeckFormat::Radioss)
        }
        _ => None,
    })
}

/// Reports a file of another format, or an engine file.
fn report_other(path: &Path, head: &[u8], trouble: &mut Trouble) {
    if head.is_empty() {
        return;
    }
    if let Some(format) = mesh_file::format_of(head, head.len()) {
        let message = format!("{} is a file of the format {}", path.display(), format.name);
        let help = "name it by mesh.file of a job; crumple import writes one";
        trouble.error(Place::Whole, message, help);
    }
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
}
