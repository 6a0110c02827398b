//! Every path in ARCHITECTURE.md exists.

use std::fs;
use std::path::Path;

/// Returns true if a word in backticks is a path: it has a slash, or an ending of files in this
/// repository. `DIR/...` is output of a run.
fn is_path(word: &str) -> bool {
    const ENDINGS: [&str; 6] = [".rs", ".sh", ".py", ".md", ".toml", ".sbatch"];
    let plain = word.chars().all(|c| c.is_ascii_alphanumeric() || "._-/".contains(c));
    plain
        && !word.starts_with("DIR/")
        && (word.contains('/') || ENDINGS.iter().any(|ending| word.ends_with(ending)))
}

#[test]
fn every_path_of_the_map_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let text = fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let (mut paths, mut missing) = (0, Vec::new());
    for (number, line) in text.lines().enumerate() {
        for word in line.split('`').skip(1).step_by(2).filter(|word| is_path(word)) {
            paths += 1;
            if !root.join(word).exists() {
                missing.push(format!("ARCHITECTURE.md:{}: {word} does not exist", number + 1));
            }
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
    assert!(paths > 20, "only {paths} paths found: check that the map has backticks");
}
