//! Code blocks of the manual, so that tests can run them.

use crate::program::root;
use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag, TagEnd};
use std::fs;
use std::path::{Path, PathBuf};

/// A code block of a page.
#[derive(Debug)]
pub struct Snippet {
    /// Line of the page where the block starts, from 1.
    pub line: usize,
    /// Language of the block; empty for output.
    pub language: String,
    /// Contents.
    pub text: String,
    /// File that the sentence before the block names last: `Save this as ...:`.
    pub file: Option<String>,
}

/// Returns the Markdown files below a folder of the repository, with paths from its root, in order.
///
/// # Panics
/// When the folder cannot be read.
pub fn pages(folder: &str) -> Vec<String> {
    fn below(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).expect("a folder of the manual") {
            let path = entry.expect("an entry of it").path();
            if path.is_dir() {
                below(&path, found);
            } else if path.extension().is_some_and(|e| e == "md") {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    below(&root().join(folder), &mut found);
    found.sort();
    let name = |path: PathBuf| {
        let path = path.strip_prefix(root()).expect("a path below the root").to_owned();
        path.into_os_string().into_string().expect("names of pages are text")
    };
    found.into_iter().map(name).collect()
}

/// Returns the code blocks of a page, in order. `page` is a path from the root of the repository.
///
/// # Panics
/// When the page cannot be read.
pub fn blocks(page: &str) -> Vec<Snippet> {
    let text = fs::read_to_string(root().join(page)).unwrap_or_else(|e| panic!("{page}: {e}"));
    let mut found: Vec<Snippet> = Vec::new();
    let (mut inside, mut file, mut sentence) = (false, None, String::new());
    for (event, range) in Parser::new(&text).into_offset_iter() {
        match event {
            Event::Start(Tag::CodeBlock(kind)) => {
                let language = match kind {
                    CodeBlockKind::Fenced(words) => words.to_string(),
                    CodeBlockKind::Indented => "formula".to_string(),
                };
                let named = sentence.trim_end().ends_with(':').then(|| file.take()).flatten();
                let line = text[..range.start].lines().count() + 1;
                found.push(Snippet { line, language, text: String::new(), file: named });
                inside = true;
            }
            Event::End(TagEnd::CodeBlock) => inside = false,
            Event::Text(part) if inside => {
                found.last_mut().expect("a block is open").text.push_str(&part);
            }
            Event::Start(Tag::Paragraph | Tag::Heading { .. } | Tag::Item | Tag::Table(_)) => {
                (file, sentence) = (None, String::new());
            }
            Event::Code(name) => {
                sentence.push_str(&name);
                let is_file = [".toml", ".py", ".rs"].iter().any(|ending| name.ends_with(ending));
                if is_file && !name.contains(' ') {
                    file = Some(name.to_string());
                }
            }
            Event::Text(part) => sentence.push_str(&part),
            _ => {}
        }
    }
    found
}
