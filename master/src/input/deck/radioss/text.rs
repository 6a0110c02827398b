//! The files of a Radioss deck and their blocks of lines: those of the starter file, then those of
//! the engine file. A starter file may have the keywords of the engine first, up to `/END/ENGINE`.
//!
//! A line that begins with `/` is a keyword: words, then ids. The ids become the first line of its
//! block. Lines that begin with `#` or `$` are comments, except `#include`, which is replaced by
//! the named file. Text before the first keyword and after `/END` in its file is ignored.

use crate::input::deck::fields::CardFormat;
use crate::input::deck::radioss::keywords;
use crate::input::deck::text::{DeckReader, KeywordBlock, Texts, copy_fragment, lines};
use crate::input::deck::{diagnostics::Trouble, number};
use crate::input::job::tree::Place;
use std::path::{Path, PathBuf};

/// Ends of the names of a starter file and of its first engine file.
const STARTER: &str = "_0000";
const ENGINE: &str = "_0001";
/// End of the keywords of the engine within a starter file.
const ENGINE_END: &str = "/END/ENGINE";
/// Start of the line that includes a file.
const INCLUDE: &[u8] = b"#include";

/// Returns the engine file that belongs to a starter file; `None` if its name does not end in
/// `_0000`.
pub fn engine_file(starter: &Path) -> Option<PathBuf> {
    let stem = starter.file_stem()?.to_string_lossy().into_owned();
    let base = stem.strip_suffix(STARTER)?;
    let extension = starter.extension().map_or(String::new(), |e| format!(".{}", e.display()));
    Some(starter.with_file_name(format!("{base}{ENGINE}{extension}")))
}

/// Reads a starter file and its engine file, with all files that they include.
pub fn read(path: &Path, trouble: &mut Trouble) -> Texts {
    let mut reader = DeckReader::new(path, trouble);
    reader.file(path, path.display().to_string(), None, CardFormat::Columns);
    let engine = engine_file(path);
    match engine.filter(|engine| engine.is_file()) {
        Some(engine) => {
            let shown = engine.display().to_string();
            reader.file(&engine, shown, None, CardFormat::Words);
        }
        None if has_engine(&reader.texts) => {}
        None => reader.warn_of_no_engine(path),
    }
    reader.texts
}

impl DeckReader<'_> {
    fn warn_of_no_engine(&mut self, path: &Path) {
        let message = match engine_file(path) {
            Some(engine) => format!("there is no engine file {}", engine.display()),
            None => "the name of the starter file does not end in _0000, so no engine file is read"
                .to_string(),
        };
        let help = "it has the end of the run (/RUN), steps (/DT) and output: put it there, or \
                    name the starter by mesh.deck of a job and give end_time in the job";
        self.trouble.warning(Place::Whole, message, help);
    }

    /// Splits a file into blocks.
    pub(in crate::input::deck) fn slash_blocks(
        &mut self,
        file: u32,
        path: &Path,
        mut format: CardFormat,
    ) {
        let text = std::mem::take(&mut self.texts.files[file as usize].text);
        let bytes = text.as_bytes();
        let mut fragment: Option<Vec<u8>> = None;
        let mut block: Option<KeywordBlock> = None;
        let mut stray = None;
        let mut ends_engine = lines(bytes, 0).any(|(line, _)| is_engine_end(line));
        if ends_engine {
            format = CardFormat::Words;
        }
        for (line, span) in lines(bytes, 0) {
            match line.first() {
                Some(b'#') if starts_with_word(line, INCLUDE) => {
                    block.take().into_iter().for_each(|block| self.texts.push(block));
                    self.include(line, file, span, path, format);
                }
                Some(b'#' | b'$') => copy_fragment(bytes, line, span, &mut fragment),
                Some(b'/') => {
                    block.take().into_iter().for_each(|block| self.texts.push(block));
                    let head = begin(line, file, span, format);
                    if ends_engine && is_engine_end(line) {
                        (ends_engine, format) = (false, CardFormat::Columns);
                        continue;
                    }
                    if head.name == "/END" {
                        break;
                    }
                    block = Some(head);
                }
                first => match &mut block {
                    Some(block) => block.lines.push(span),
                    None if first.is_some() && stray.is_none() => stray = Some((line, span)),
                    None => {}
                },
            }
        }
        block.take().into_iter().for_each(|block| self.texts.push(block));
        if let Some((line, (start, end))) = stray {
            self.report_stray_line(line, Place::Deck { file, start, end });
        }
        let fragment = fragment.and_then(|f| String::from_utf8(f).ok());
        let own = &mut self.texts.files[file as usize];
        (own.text, own.fragment) = (text, fragment);
    }

    /// Reads the file that a line includes.
    fn include(
        &mut self,
        line: &[u8],
        file: u32,
        span: (u32, u32),
        path: &Path,
        format: CardFormat,
    ) {
        let rest = &line[INCLUDE.len()..];
        let name = String::from_utf8_lossy(rest).trim().to_string();
        let place = Place::Deck { file, start: span.0, end: span.1 };
        if name.is_empty() {
            let help = "write the name of the file after it, or remove the line";
            return self.trouble.error(place, "#include names no file", help);
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let found = self.resolve_include(&name, folder, place);
        self.file(&found, name, Some(place), format);
    }

    /// Reports a line before the first keyword: an error if it has numbers as a card has.
    fn report_stray_line(&mut self, line: &[u8], place: Place) {
        let mut words = line.split(u8::is_ascii_whitespace);
        let is_card = words.all(|word| word.is_empty() || number::real(word).is_some());
        if is_card {
            let help = "write its keyword, a line that begins with /, above it";
            self.trouble.error(place, "a card precedes the first keyword", help);
        } else {
            let help = "it is not read: a keyword begins with /, a comment with #";
            self.trouble.warning(place, "text precedes the first keyword", help);
        }
    }
}

/// Returns true if some blocks are those of an engine file.
fn has_engine(texts: &Texts) -> bool {
    texts.blocks.iter().any(|block| block.format == CardFormat::Words)
}

/// Returns true for the line that ends the keywords of the engine.
fn is_engine_end(line: &[u8]) -> bool {
    line.eq_ignore_ascii_case(ENGINE_END.as_bytes())
}

/// Returns true if a line begins with a word, in any case.
fn starts_with_word(line: &[u8], word: &[u8]) -> bool {
    line.get(..word.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(word))
        && line.get(word.len()).is_none_or(u8::is_ascii_whitespace)
}

/// Returns the block that a keyword begins. Its first line is the ids in the keyword's own line.
fn begin(line: &[u8], file: u32, head: (u32, u32), format: CardFormat) -> KeywordBlock {
    // In other places a slash with blanks around it may follow the ids.
    let text = String::from_utf8_lossy(line).to_ascii_uppercase();
    let mut name = String::new();
    let mut at = 1;
    for part in text[1..].split('/') {
        let part_end = at + part.len();
        let trimmed = part.trim();
        let is_id = !trimmed.is_empty() && number::integer(trimmed.as_bytes()).is_some();
        if is_id {
            break;
        }
        if !trimmed.is_empty() {
            name += "/";
            name += trimmed;
        }
        at = part_end + 1;
    }
    let tail = (head.0 + at.min(line.len()) as u32, head.1);
    if name == "/DAMP" && format == CardFormat::Words {
        name = keywords::ENGINE_DAMP.into();
    }
    // A starter file may have them without the line that ends them.
    let format = if keywords::is_of_engine(&name) { CardFormat::Words } else { format };
    KeywordBlock { file, number: 0, head, name, format, lines: vec![tail], submodel: 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(line: &str) -> (String, String) {
        let length = line.len() as u32;
        let block = begin(line.as_bytes(), 0, (0, length), CardFormat::Columns);
        let (from, to) = block.lines[0];
        (block.name, line[from as usize..to as usize].to_string())
    }

    /// A keyword is words and then ids; the ids are the first line of the block.
    #[test]
    fn ids_are_split_from_the_name() {
        let both = |name: &str, ids: &str| (name.to_string(), ids.to_string());
        assert_eq!(parts("/MAT/LAW1/12"), both("/MAT/LAW1", "12"));
        assert_eq!(parts("/mat/elast/12/3"), both("/MAT/ELAST", "12/3"));
        assert_eq!(parts("/NODE"), both("/NODE", ""));
        assert_eq!(parts("/ADMAS/0/7"), both("/ADMAS", "0/7"));
        assert_eq!(parts("/PRINT/-500"), both("/PRINT", "-500"));
        assert_eq!(parts("/RUN/tube/1/"), both("/RUN/TUBE", "1/"));
        assert_eq!(parts("/"), both("", ""));
    }

    #[test]
    fn the_engine_file_has_the_name_of_the_starter() {
        let of = |name: &str| engine_file(Path::new(name)).map(|p| p.display().to_string());
        assert_eq!(of("a/tube_0000.rad").as_deref(), Some("a/tube_0001.rad"));
        assert_eq!(of("tube.rad"), None);
    }
}
