//! Imports and types of the crates of the workspace, as far as text shows them: `use` declarations
//! and paths in code that start at a crate, and types that are items of a file. Code and files
//! under `#[cfg(test)]` are left out.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Folder of each crate and its name in paths. Inner folders stand first.
const CRATES: [(&str, &str); 11] = [
    ("tests/verification/src/", "crumple_verification"),
    ("tests/src/", "crumple_tests"),
    ("master/program/src/", "crumple_program"),
    ("master/python/src/", "crumple_native"),
    ("master/src/", "crumple"),
    ("worker/math/src/", "crumple_math"),
    ("worker/fem/src/", "crumple_fem"),
    ("worker/contact/src/", "crumple_contact"),
    ("worker/src/", "crumple_worker"),
    ("proto/src/", "crumple_proto"),
    ("cases/src/", "crumple_cases"),
];

/// Code of one file that is no test.
pub struct Source {
    /// Path from the root of the repository.
    pub path: String,
    /// Module of the file: the name of the crate, then the modules.
    pub module: Vec<String>,
    /// Paths that the code imports or calls, in full: the name of a crate, then the modules.
    pub imports: Vec<Vec<String>>,
    /// Names of the structs, enums, unions, traits and type aliases that the file defines.
    pub types: Vec<String>,
}

/// Returns all Rust files of the repository, as sorted paths from its root.
///
/// # Panics
/// When a folder cannot be read.
pub fn files(root: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of the repository") {
            let path = entry.expect("an entry").path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                if name != "target" && !name.starts_with('.') {
                    folders.push(path);
                }
            } else if name.ends_with(".rs") {
                let inner = path.strip_prefix(root).expect("a path below the root");
                found.push(inner.to_string_lossy().into_owned());
            }
        }
    }
    found.sort();
    found
}

/// Reads the code of all crates that is no test.
///
/// # Panics
/// When a file cannot be read.
pub fn sources(root: &Path) -> Vec<Source> {
    let files = files(root);
    let read = |path: &String| fs::read_to_string(root.join(path)).expect("a file");
    let texts: Vec<String> = files.iter().map(|path| without_comments(&read(path))).collect();
    let tests: BTreeSet<PathBuf> =
        files.iter().zip(&texts).flat_map(|(path, text)| test_files(path, text)).collect();
    let is_test = |path: &str| {
        let path = Path::new(path);
        tests.iter().any(|test| path == test || path.starts_with(test.with_extension("")))
    };
    let mut found = Vec::new();
    for (path, text) in files.iter().zip(&texts).filter(|(path, _)| !is_test(path)) {
        let Some(module) = module(path) else { continue };
        let code = without_test_modules(text);
        let imports = paths(&code).into_iter().filter_map(|p| in_full(&module, p)).collect();
        found.push(Source { path: path.clone(), module, imports, types: types(&code) });
    }
    found
}

/// Returns the module of a file, or `None` if it belongs to no crate. The meshes of `cases/` lie
/// outside its `src/`.
fn module(path: &str) -> Option<Vec<String>> {
    if let Some(folder) = path.strip_prefix("cases/").and_then(|p| p.strip_suffix("/mesh.rs")) {
        return Some(vec!["crumple_cases".into(), folder.replace('-', "_")]);
    }
    let (folder, name) = CRATES.iter().find(|(folder, _)| path.starts_with(folder))?;
    let inner = path[folder.len()..].trim_end_matches(".rs");
    let modules = inner.split('/').filter(|m| !["mod", "lib", "main"].contains(m));
    Some(std::iter::once(*name).chain(modules).map(String::from).collect())
}

/// Replaces line comments by nothing. The project has no block comments.
fn without_comments(text: &str) -> String {
    let code = |line: &str| line.split("//").next().unwrap_or_default().to_string() + "\n";
    text.lines().map(code).collect()
}

/// Returns the files that a file declares as modules under `#[cfg(test)]`.
fn test_files(path: &str, text: &str) -> Vec<PathBuf> {
    let path = Path::new(path);
    let folder = path.parent().unwrap_or(Path::new(""));
    let stem = path.file_stem().unwrap_or_default();
    let inner = match stem.to_string_lossy().as_ref() {
        "mod" | "lib" | "main" => folder.to_path_buf(),
        _ => folder.join(stem),
    };
    let mut found = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.trim() != "#[cfg(test)]" {
            continue;
        }
        let mut next = lines.next().unwrap_or_default();
        if let Some(named) = next.strip_prefix("#[path = \"") {
            found.push(folder.join(named.trim_end_matches("\"]")));
            next = "";
        }
        if let Some(name) = next.strip_suffix(';').and_then(|l| l.split("mod ").nth(1)) {
            found.push(inner.join(format!("{name}.rs")));
            found.push(inner.join(name).join("mod.rs"));
        }
    }
    found
}

/// Removes modules with tests. As `cargo fmt` writes them, they end at a brace in the first column.
fn without_test_modules(text: &str) -> String {
    let mut kept = String::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        let test = line == "#[cfg(test)]" && lines.peek().is_some_and(|next| next.ends_with('{'));
        if test {
            lines.by_ref().find(|line| *line == "}");
        } else {
            kept.push_str(line);
            kept.push('\n');
        }
    }
    kept
}

/// Returns the names of the types that are items of a file. As `cargo fmt` writes them, they start
/// in the first column.
fn types(text: &str) -> Vec<String> {
    const KINDS: [&str; 5] = ["struct", "enum", "union", "trait", "type"];
    let name = |line: &str| {
        let mut words = line.split([' ', '(', ')', '<', ';', ':', '{']).filter(|w| !w.is_empty());
        let kind = words.find(|w| !["pub", "crate", "super", "unsafe"].contains(w))?;
        KINDS.contains(&kind).then(|| words.next().map(String::from))?
    };
    text.lines().filter(|line| !line.starts_with(' ')).filter_map(name).collect()
}

/// Returns all paths with `::` in code; a group in braces gives one path for each of its entries.
fn paths(text: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find(|c: char| c.is_ascii_alphabetic() || c == '_') {
        rest = &rest[start..];
        let mut tree = Vec::new();
        let used = tree_at(rest, &[], &mut tree);
        found.extend(tree.into_iter().filter(|path: &Vec<String>| path.len() > 1));
        rest = &rest[used..];
    }
    found
}

/// Reads the path at the start of a text and adds its expansions; returns the length read.
fn tree_at(text: &str, before: &[String], found: &mut Vec<Vec<String>>) -> usize {
    let word = |text: &str| {
        text.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(text.len())
    };
    let mut path = before.to_vec();
    let mut at = 0;
    loop {
        let length = word(&text[at..]);
        if length == 0 {
            break;
        }
        path.push(text[at..at + length].to_string());
        at += length;
        match text[at..].strip_prefix("::") {
            Some(after) if after.starts_with('{') => return at + 3 + group(after, &path, found),
            Some(_) => at += 2,
            None => break,
        }
    }
    found.push(path);
    at.max(1)
}

/// Reads the entries of a group `{a, b::{c, d}}` and returns the length read after its first brace.
fn group(text: &str, path: &[String], found: &mut Vec<Vec<String>>) -> usize {
    let mut at = 1;
    while let Some(c) = text[at..].chars().next() {
        match c {
            '}' => return at,
            _ if c.is_ascii_alphabetic() || c == '_' => at += tree_at(&text[at..], path, found),
            _ => at += c.len_utf8(),
        }
    }
    at
}

/// Returns a path with the name of its crate as the first word; `None` if it does not start at a
/// crate, at `self` or at `super`.
fn in_full(module: &[String], path: Vec<String>) -> Option<Vec<String>> {
    let ups = path.iter().take_while(|word| *word == "super").count();
    let known = |name: &str| CRATES.iter().any(|c| c.1 == name) || name == "tokio" || name == "mpi";
    match path[0].as_str() {
        "crate" => Some([&module[..1], &path[1..]].concat()),
        "super" => Some([&module[..module.len().checked_sub(ups)?], &path[ups..]].concat()),
        "self" => Some([module, &path[1..]].concat()),
        name if known(name) => Some(path),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Vec<String> {
        let module = ["crumple_worker", "contact", "pairs"].map(String::from);
        let code = without_test_modules(&without_comments(text));
        let paths = paths(&code).into_iter().filter_map(|p| in_full(&module, p));
        paths.map(|p| p.join("::")).collect()
    }

    #[test]
    fn groups_give_one_path_for_each_entry() {
        let found = read("use crate::{fem::{blocks, materials::J2}, step};\nlet x = 1;");
        let wanted =
            ["fem::blocks", "fem::materials::J2", "step"].map(|p| format!("crumple_worker::{p}"));
        assert_eq!(found, wanted);
    }

    #[test]
    fn paths_in_code_and_of_outer_modules_are_imports() {
        let found = read("use super::search;\nfn f() -> crate::time::Clock { tokio::run() }");
        let wanted =
            ["crumple_worker::contact::search", "crumple_worker::time::Clock", "tokio::run"];
        assert_eq!(found, wanted);
    }

    #[test]
    fn types_of_any_visibility_are_found() {
        let text = "pub struct Wall {\n    type Inner = u8;\n}\nstruct Line(u8);\npub(super) enum \
                    Form<T> {}\npub(crate) trait Law: Send {}\ntype Rows = u8;\nfn f() {}\n";
        assert_eq!(types(text), ["Wall", "Line", "Form", "Law", "Rows"]);
    }

    #[test]
    fn comments_and_tests_are_no_imports() {
        let text =
            "// crate::a::b\n#[cfg(test)]\nmod tests {\n    use crate::c;\n}\nuse crate::d;\n";
        assert_eq!(read(text), ["crumple_worker::d"]);
        let files = test_files("worker/src/a.rs", "#[cfg(test)]\n#[path = \"b_tests.rs\"]\nmod b;");
        assert_eq!(files, [PathBuf::from("worker/src/b_tests.rs")]);
    }
}
