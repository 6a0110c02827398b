//! Code of the manual is code of the repository, which is compiled and tested.

use crumple_tests::imports::files;
use crumple_tests::manual::{blocks, pages};
use crumple_tests::program::root;
use std::fs;

/// Returns the code without blanks and without what differs between a law in the crate and the same
/// law in a test: imports, and the visibility of its row.
fn plain(code: &str) -> String {
    let mut kept = String::new();
    let mut import = false;
    for line in code.lines() {
        import |= line.trim_start().starts_with("use ");
        if !import {
            kept.push_str(line);
        }
        import &= !line.ends_with(';');
    }
    let kept = kept.replace("pub(super) const LAW", "pub const LAW");
    let kept = kept.replace("pub static LAW", "pub const LAW");
    kept.split_whitespace().collect()
}

/// Blocks that are no code of a file: the frame of an element, with comments for bodies.
const FRAMES: [(&str, &str); 2] = [
    ("docs/developer/add-element.md", "impl Kernel for MyQuad"),
    ("docs/developer/add-element.md", "mod my_quad;"),
];

/// Rows that the pages add to a table.
const ADDED: [&str; 3] = ["ludwik", "maxwell", "damper"];

#[test]
fn code_of_the_manual_is_code_of_the_repository() {
    let sources: Vec<String> = files(root())
        .into_iter()
        .map(|path| plain(&fs::read_to_string(root().join(path)).expect("a source")))
        .collect();
    let (mut seen, mut wrong) = (0, Vec::new());
    for page in pages("docs") {
        for block in blocks(&page).into_iter().filter(|block| block.language == "rust") {
            if FRAMES.iter().any(|(of, part)| *of == page && block.text.contains(part)) {
                continue;
            }
            seen += 1;
            let mut code = plain(&block.text);
            if code.starts_with("mod") {
                for name in ADDED {
                    code = code.replace(&format!("mod{name};"), "");
                    code = code.replace(&format!(",{name}::LAW"), "");
                }
            }
            if !sources.iter().any(|source| source.contains(&code)) {
                wrong.push(format!("{page}:{}: no file has this code", block.line));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen > 8, "only {seen} pieces of code found");
}
