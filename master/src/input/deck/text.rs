//! The files of a deck and their blocks of lines: one block for each keyword, in the order in
//! which they apply.
//!
//! `*INCLUDE` is replaced by the included file. Text before `*KEYWORD`, comments (`$`), and text
//! after `*END` in its file are ignored, and so are the blocks of cases that are not chosen
//! (`cases.rs`).

use super::cases;
use super::diagnostics::Trouble;
use super::fields::CardFormat;
use super::number;
use crate::input::confine;
use crate::input::job::tree::Place;
use std::path::{Path, PathBuf};

/// Largest file [byte], because places in it have 32 bits.
const LARGEST_FILE: u64 = u32::MAX as u64;
/// Maximum number of files of one deck.
const MOST_FILES: usize = 1000;
/// Prefix of comments that hold keys of a job, see [`Text::fragment`].
const FRAGMENT: &[u8] = b"$crumple:";
/// Starts of the first and the last line of an encrypted part.
const ENCRYPTED: &[u8] = b"-----BEGIN PGP";
const ENCRYPTED_END: &[u8] = b"-----END PGP";

/// A file of a deck.
#[derive(Debug)]
pub struct Text {
    /// Its name as the user or the deck gave it.
    pub file: String,
    /// Where it was found.
    pub path: PathBuf,
    /// Its text; bytes that are not UTF-8 are replaced by question marks.
    pub text: String,
    /// The text after `$crumple:` in its comments, with blanks elsewhere so that places are kept:
    /// keys of a job in TOML.
    pub fragment: Option<String>,
}

/// A keyword and its lines.
#[derive(Debug)]
pub struct KeywordBlock {
    /// Number of its file.
    pub file: u32,
    /// Its number in the order of the deck, in which an included file is at its `*INCLUDE`.
    pub number: usize,
    /// Bytes of the keyword's own line.
    pub head: (u32, u32),
    /// Name in capitals: without asterisk, or with the slashes of Radioss and without ids.
    pub name: String,
    /// Format of its cards.
    pub format: CardFormat,
    /// First byte of each line and one past its last; without comments.
    pub lines: Vec<(u32, u32)>,
    /// Number of the `*INCLUDE_TRANSFORM` by which its file is included, from 1 on in the order
    /// of the deck; 0 outside of such files.
    pub submodel: u32,
}

impl KeywordBlock {
    /// Returns the name for messages, with the sign that begins a keyword.
    pub fn shown(&self) -> String {
        if self.name.starts_with('/') { self.name.clone() } else { format!("*{}", self.name) }
    }

    /// Returns the place of the keyword's own line.
    pub fn place(&self) -> Place {
        Place::Deck { file: self.file, start: self.head.0, end: self.head.1 }
    }

    /// Returns the place of a part of a line.
    pub fn span(&self, line: (u32, u32), from: usize, to: usize) -> Place {
        let end = if to > from { line.0 + to as u32 } else { line.1 };
        Place::Deck {
            file: self.file,
            start: if to > from { line.0 + from as u32 } else { line.0 },
            end,
        }
    }
}

/// All files of a deck, and its blocks.
#[derive(Debug, Default)]
pub struct Texts {
    /// The files, the main one first.
    pub files: Vec<Text>,
    /// The blocks in the order of the deck.
    pub blocks: Vec<KeywordBlock>,
    /// Places of encrypted lines.
    pub encrypted: Vec<Place>,
}

impl Texts {
    /// Returns a line of a block.
    pub fn line(&self, block: &KeywordBlock, line: (u32, u32)) -> &[u8] {
        self.files[block.file as usize]
            .text
            .as_bytes()
            .get(line.0 as usize..line.1 as usize)
            .unwrap_or_default()
    }

    /// Adds a block and numbers it.
    pub(super) fn push(&mut self, block: KeywordBlock) {
        self.blocks.push(KeywordBlock { number: self.blocks.len(), ..block });
    }

    /// Reads a deck and all files that it includes, and reports problems.
    pub fn read(path: &Path, trouble: &mut Trouble) -> Self {
        let mut reader = DeckReader::new(path, trouble);
        reader.file(path, path.display().to_string(), None, CardFormat::Standard);
        reader.texts
    }
}

/// Reader of files, with those that they include.
pub(super) struct DeckReader<'t> {
    /// Files and blocks so far.
    pub(super) texts: Texts,
    /// Files that are being read, the innermost last, to detect files that include themselves.
    open: Vec<PathBuf>,
    /// Folders in which included files are searched.
    folders: Vec<PathBuf>,
    /// Problems.
    pub(super) trouble: &'t mut Trouble,
    /// Number of `*INCLUDE_TRANSFORM` so far, and that of the present file.
    submodels: u32,
    submodel: u32,
}

impl<'t> DeckReader<'t> {
    /// Creates a reader for the deck at a path.
    pub(super) fn new(path: &Path, trouble: &'t mut Trouble) -> Self {
        let folders = vec![path.parent().unwrap_or(Path::new("")).to_path_buf()];
        let (submodels, submodel) = (0, 0);
        let texts = Texts::default();
        DeckReader { texts, open: Vec::new(), folders, trouble, submodels, submodel }
    }
}

impl DeckReader<'_> {
    /// Reads one file; `from` is the place where it is named.
    pub(super) fn file(
        &mut self,
        path: &Path,
        shown: String,
        from: Option<Place>,
        format: CardFormat,
    ) {
        let place = from.unwrap_or(Place::Whole);
        if self.texts.files.len() >= MOST_FILES {
            let message = format!("the deck includes more than {MOST_FILES} files");
            return self.trouble.error(place, message, "combine some of them");
        }
        let whole = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if self.open.contains(&whole) {
            let message = format!("{shown} includes itself, directly or through another file");
            return self.trouble.error(place, message, "remove one include of the cycle");
        }
        let text = match load(path) {
            Ok(text) => text,
            Err(what) => {
                let alike = self.folders.iter().find_map(|folder| alike(folder, &shown));
                let near = alike.map_or(String::new(), |name| format!("there is {name}; "));
                let help = format!(
                    "{near}check its name and permissions; names are relative to the folder of the \
                     main deck, the folder of the including file, or an *INCLUDE_PATH; a deck for \
                     a service is sent with all files that it includes"
                );
                return self.trouble.error(place, format!("{shown} {what}"), help);
            }
        };
        let file = self.texts.files.len() as u32;
        self.texts.files.push(Text { file: shown, path: path.to_owned(), text, fragment: None });
        self.open.push(whole);
        match format {
            CardFormat::Columns | CardFormat::Words => self.slash_blocks(file, path, format),
            _ => self.blocks(file, path, format),
        }
        self.open.pop();
    }

    /// Splits a file into blocks.
    fn blocks(&mut self, file: u32, path: &Path, mut format: CardFormat) {
        let text = std::mem::take(&mut self.texts.files[file as usize].text);
        let bytes = text.as_bytes();
        let begin = first_keyword(bytes).unwrap_or_else(|| {
            self.warn_of_no_keyword(file, bytes);
            0
        });
        let mut block: Option<KeywordBlock> = None;
        let mut fragment: Option<Vec<u8>> = None;
        let mut stray = None;
        let mut ended = false;
        let mut encrypted = false;
        for (line, span) in lines(bytes, begin) {
            if encrypted || line.starts_with(ENCRYPTED) {
                if !encrypted {
                    let (start, end) = span;
                    self.texts.encrypted.push(Place::Deck { file, start, end });
                }
                encrypted = !line.starts_with(ENCRYPTED_END);
                continue;
            }
            match line.first() {
                Some(b'$') => copy_fragment(bytes, line, span, &mut fragment),
                Some(b'*') => {
                    if let Some(block) = block.take() {
                        self.end_block(block, &text, path, format);
                    }
                    let Head { name, format: own } = Head::read(line, format);
                    match name.as_str() {
                        "END" => {
                            ended = true;
                            break;
                        }
                        "KEYWORD" => format = own,
                        _ if is_keyword(&name) => {
                            // A line with the name of the project follows.
                            format = own;
                            block = Some(self.begin_block((file, span), name, format));
                        }
                        _ => {
                            block = Some(self.begin_block((file, span), name, own));
                        }
                    }
                }
                first => match &mut block {
                    Some(block) => block.lines.push(span),
                    None if first.is_some() && stray.is_none() => stray = Some(span),
                    None => {}
                },
            }
        }
        if let Some(block) = block.take() {
            self.end_block(block, &text, path, format);
        }
        if !ended {
            self.warn_of_no_end(file, bytes);
        }
        if let Some((start, end)) = stray {
            self.report_stray(
                &bytes[start as usize..end as usize],
                Place::Deck { file, start, end },
            );
        }
        // All characters outside the fragment that are not ASCII were replaced by blanks, so it
        // is UTF-8 like the text.
        let fragment = fragment.and_then(|f| String::from_utf8(f).ok());
        let own = &mut self.texts.files[file as usize];
        (own.text, own.fragment) = (text, fragment);
    }

    /// Returns a block without lines.
    fn begin_block(
        &self,
        (file, head): (u32, (u32, u32)),
        name: String,
        format: CardFormat,
    ) -> KeywordBlock {
        let (lines, submodel) = (Vec::new(), self.submodel);
        KeywordBlock { file, number: 0, head, name, format, lines, submodel }
    }

    /// Reads the file of `*INCLUDE_TRANSFORM`. Its block keeps the cards after the name, and
    /// precedes the blocks of the file.
    fn include_transform(
        &mut self,
        mut block: KeywordBlock,
        line: impl Fn((u32, u32)) -> String,
        folder: &Path,
        format: CardFormat,
    ) {
        let begin = block.lines.iter().position(|l| l.0 < l.1).unwrap_or(0);
        let goes_on = |span: &&(u32, u32)| line(**span).trim_end().ends_with(" +");
        let count = 1 + block.lines[begin..].iter().take_while(goes_on).count();
        let count = count.min(block.lines.len() - begin);
        let cards = block.lines.split_off(begin + count);
        let named = std::mem::replace(&mut block.lines, cards);
        let place = block.place();
        let Some((name, span)) = names(&named, line).into_iter().next() else {
            let help = "name the file on the line after the keyword";
            return self.trouble.error(place, "*INCLUDE_TRANSFORM has no file", help);
        };
        let place = block.span(span, 0, (span.1 - span.0) as usize);
        let found = self.resolve_include(&name, folder, place);
        self.texts.push(block);
        self.submodels += 1;
        let outer = std::mem::replace(&mut self.submodel, self.submodels);
        self.file(&found, name, Some(place), format);
        self.submodel = outer;
    }

    /// Reports a line before the first keyword: an error if it has numbers as a card has, else a
    /// warning, as other programs skip text there.
    fn report_stray(&mut self, line: &[u8], place: Place) {
        let mut words = line.split(|b| b.is_ascii_whitespace() || *b == b',');
        let is_card = words.all(|word| word.is_empty() || number::real(word).is_some());
        if is_card {
            let help = "write its keyword, a line that begins with *, above it";
            self.trouble.error(place, "a card precedes the first keyword", help);
        } else {
            let help = "it is not read: a deck begins with *KEYWORD, comments with $";
            self.trouble.warning(place, "text precedes the first keyword", help);
        }
    }

    /// Warns if the main file has text but no `*KEYWORD`.
    fn warn_of_no_keyword(&mut self, file: u32, bytes: &[u8]) {
        if file == 0 && !bytes.is_empty() {
            let help = "begin the deck with *KEYWORD; text before it is not read";
            let place = Place::Deck { file, start: 0, end: 0 };
            self.trouble.warning(place, "the deck has no *KEYWORD", help);
        }
    }

    /// Warns if the main file has text but no `*END`.
    fn warn_of_no_end(&mut self, file: u32, bytes: &[u8]) {
        if file == 0 && !bytes.is_empty() {
            let last = Place::Deck { file, start: bytes.len() as u32, end: bytes.len() as u32 };
            let help = "if the file is complete, add *END as its last line";
            self.trouble.warning(last, "the deck has no *END", help);
        }
    }

    /// Stores a block, or reads the file that it includes.
    fn end_block(&mut self, mut block: KeywordBlock, text: &str, path: &Path, format: CardFormat) {
        let bytes = text.as_bytes();
        let line = |span: (u32, u32)| {
            String::from_utf8_lossy(&bytes[span.0 as usize..span.1 as usize]).into_owned()
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        let without_block = ["INCLUDE", "INCLUDE_PATH", "INCLUDE_PATH_RELATIVE"];
        if without_block.contains(&block.name.as_str())
            && cases::subcase_on_line(&line(block.head)).is_some()
        {
            let message = format!("{}: CID is not supported here", block.shown());
            let help = "write *CASE_BEGIN_n above *INCLUDE and *CASE_END_n below it; folders of \
                        *INCLUDE_PATH are those of all cases";
            self.trouble.error(block.place(), message, help);
        }
        match block.name.as_str() {
            "INCLUDE" => {
                for (name, span) in names(&block.lines, line) {
                    let place = block.span(span, 0, (span.1 - span.0) as usize);
                    let found = self.resolve_include(&name, folder, place);
                    self.file(&found, name, Some(place), format);
                }
            }
            "INCLUDE_TRANSFORM" => self.include_transform(block, line, folder, format),
            "INCLUDE_PATH" | "INCLUDE_PATH_RELATIVE" => {
                let root = if block.name == "INCLUDE_PATH" {
                    PathBuf::new()
                } else {
                    folder.to_path_buf()
                };
                let folders =
                    names(&block.lines, line).into_iter().map(|(name, _)| root.join(name));
                self.folders.extend(folders);
            }
            // The name of the project, which has no effect.
            name if is_keyword(name) => {}
            _ => {
                while block.lines.last().is_some_and(|l| l.0 == l.1) && block.lines.len() > 64 {
                    block.lines.pop();
                }
                self.texts.push(block);
            }
        }
    }

    /// Returns the file for a name: as it is, or in forms of other systems, in quotes or with
    /// backslashes. A file that is not there is looked for next to the deck, without the folders
    /// of its name.
    pub(super) fn resolve_include(&mut self, name: &str, folder: &Path, place: Place) -> PathBuf {
        let bare = name.trim_matches(['"', '\'']);
        let names = [name.to_string(), bare.to_string(), bare.replace('\\', "/")];
        let places = || self.folders.iter().map(PathBuf::as_path).chain([folder]);
        let all = names.iter().flat_map(|name| places().map(move |folder| folder.join(name)));
        if let Some(found) = all.into_iter().find(|p| p.is_file()) {
            return found;
        }
        let last = bare.rsplit(['/', '\\']).next().unwrap_or_default();
        let near = places().map(|folder| folder.join(last)).find(|p| p.is_file());
        match near.filter(|_| last != bare) {
            Some(found) => {
                let message = format!("{bare} is not there: {} is read", found.display());
                self.trouble.warning(place, message, "name the file by its path from the deck");
                found
            }
            None => folder.join(name),
        }
    }
}

/// Returns the existing path that equals a name except for upper and lower case.
fn alike(folder: &Path, name: &str) -> Option<String> {
    confine::check(folder).ok()?;
    let mut found = folder.to_path_buf();
    for part in Path::new(name).components() {
        let part = part.as_os_str();
        let same = |entry: &std::fs::DirEntry| entry.file_name().eq_ignore_ascii_case(part);
        confine::check(&found).ok()?;
        let here = if found.as_os_str().is_empty() { Path::new(".") } else { &found };
        found = match found.join(part).exists() {
            true => found.join(part),
            false => found.join(std::fs::read_dir(here).ok()?.flatten().find(same)?.file_name()),
        };
    }
    Some(found.strip_prefix(folder).unwrap_or(&found).display().to_string())
}

/// Returns names of files, one per line. A name that ends with ` +` continues in the next line.
fn names(lines: &[(u32, u32)], text: impl Fn((u32, u32)) -> String) -> Vec<(String, (u32, u32))> {
    let mut names: Vec<(String, (u32, u32))> = Vec::new();
    let mut open = false;
    for &span in lines {
        let line = text(span);
        let part = line.trim();
        let (part, goes_on) = match part.strip_suffix(" +") {
            Some(part) => (part.trim_end(), true),
            None => (part, false),
        };
        match names.last_mut().filter(|_| open) {
            Some(last) => last.0 += part,
            None if part.is_empty() => {}
            None => names.push((part.into(), span)),
        }
        open = goes_on;
    }
    names
}

/// A keyword's own line.
struct Head {
    name: String,
    format: CardFormat,
}

impl Head {
    /// Reads the name, and the format after it: `+` long, `-` standard, `%` with ids of ten
    /// columns, and on `*KEYWORD` also `LONG=Y` and `I10=Y`.
    fn read(line: &[u8], format: CardFormat) -> Self {
        let text = String::from_utf8_lossy(&line[1..]).to_ascii_uppercase();
        let mut words = text.split(|c: char| c.is_ascii_whitespace() || c == ',' || c == '(');
        let first = words.next().unwrap_or_default();
        let name = first.trim_end_matches(['+', '-', '%']);
        let mut head = Head { name: name.to_string(), format };
        let signs = first[name.len()..].chars().map(String::from).chain(words.map(String::from));
        for word in signs {
            match (word.as_str(), is_keyword(name)) {
                ("+", _) | ("LONG=Y" | "LONG=YES", true) => head.format = CardFormat::Long,
                ("-", _) | ("LONG=S" | "LONG=N" | "LONG=NO", true) => {
                    head.format = CardFormat::Standard
                }
                ("%", _) | ("I10=Y" | "I10=YES", true) => head.format = CardFormat::I10,
                _ => {}
            }
        }
        head
    }
}

/// Returns true for the name of the keyword that begins a deck.
fn is_keyword(name: &str) -> bool {
    ["KEYWORD", "KEYWORD_ID", "KEYWORD_JOBID"].contains(&name)
}

/// Returns the first byte of the line `*KEYWORD`.
fn first_keyword(bytes: &[u8]) -> Option<usize> {
    let mut at = 0;
    for line in bytes.split(|&b| b == b'\n') {
        if line.first() == Some(&b'*') && is_keyword(&Head::read(line, CardFormat::Standard).name) {
            return Some(at);
        }
        at += line.len() + 1;
    }
    None
}

/// Returns the lines from a byte on, without white space at their ends, and their bytes.
pub(super) fn lines(bytes: &[u8], mut at: usize) -> impl Iterator<Item = (&[u8], (u32, u32))> {
    std::iter::from_fn(move || {
        let rest = bytes.get(at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        let line = rest[..length].trim_ascii_end();
        let span = (at as u32, (at + line.len()) as u32);
        at += length + 1;
        Some((line, span))
    })
}

/// Copies the text of a comment after `$crumple:` to its place in the fragment.
pub(super) fn copy_fragment(
    bytes: &[u8],
    line: &[u8],
    span: (u32, u32),
    fragment: &mut Option<Vec<u8>>,
) {
    if line.len() >= FRAGMENT.len() && line[..FRAGMENT.len()].eq_ignore_ascii_case(FRAGMENT) {
        let own = fragment.get_or_insert_with(|| blank(bytes));
        let (from, end) = (span.0 as usize + FRAGMENT.len(), span.1 as usize);
        own[from..end].copy_from_slice(&bytes[from..end]);
    }
}

fn blank(bytes: &[u8]) -> Vec<u8> {
    bytes.iter().map(|&b| if b == b'\n' { b'\n' } else { b' ' }).collect()
}

fn load(path: &Path) -> Result<String, String> {
    let cannot = |error: std::io::Error| format!("cannot be read: {error}");
    confine::check(path).map_err(cannot)?;
    let about = std::fs::metadata(path).map_err(cannot)?;
    if !about.is_file() {
        return Err("is not a file".into());
    }
    if about.len() > LARGEST_FILE {
        return Err("is larger than 4 GiB".into());
    }
    let mut bytes = std::fs::read(path).map_err(cannot)?;
    if let [0xff, 0xfe, rest @ ..] | [0xfe, 0xff, rest @ ..] = &bytes[..] {
        let pair = |pair: &[u8]| match bytes[0] {
            0xff => u16::from_le_bytes([pair[0], pair[1]]),
            _ => u16::from_be_bytes([pair[0], pair[1]]),
        };
        let units: Vec<u16> = rest.chunks_exact(2).map(pair).collect();
        return Ok(String::from_utf16_lossy(&units));
    }
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
    }
    // Titles in other encodings are common; one byte for each byte keeps the columns.
    Ok(String::from_utf8(bytes).unwrap_or_else(|error| {
        let bytes = error.as_bytes().iter().map(|&b| if b.is_ascii() { b } else { b'?' });
        bytes.map(char::from).collect()
    }))
}
