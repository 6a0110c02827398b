//! The commands of all tutorials run in one folder, page after page as a reader may do it, with the
//! files that the pages show. Runs stop after a few cycles: results are not compared, output of
//! `check` is.

use crumple_tests::manual::{Snippet, blocks, pages};
use crumple_tests::program::{crumple, root};
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

/// Stops runs after a few cycles and reports the exit code.
const CRUMPLE: &str = r##"#!/usr/bin/env bash
more=()
[[ $1 == run ]] && more=(--set time.max_cycles=20)
"$CRUMPLE_BIN" "$@" "${more[@]}"
code=$?
echo "@@ exit $code: crumple $*"
exit $code
"##;

/// Calls the program that is there instead of one that cargo would build.
const CARGO: &str = r#"#!/usr/bin/env bash
if [[ "$1 $2 $3" == "run --release --" ]]; then
    exec crumple "${@:4}"
fi
"#;

/// Programs that the pages call and this test does not.
const NOT_CALLED: [&str; 6] =
    ["module", "mpirun", "podman", "sbatch", "deploy/run.sh", "deploy/test.sh"];

/// Pages whose commands need a program that has been changed as the page says.
/// `added_laws/main.rs` does what `new-material.md` says.
const NEED_OTHER_PROGRAM: [&str; 1] = ["docs/tutorials/new-material.md"];

/// Writes an executable file.
fn script(path: &Path, text: &str) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}

/// Makes the folder in which the commands of all pages run.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for name in ["cases", "tests"] {
        symlink(root().join(name), at.join(name)).unwrap();
    }
    script(&at.join("bin/crumple"), CRUMPLE);
    script(&at.join("bin/cargo"), CARGO);
    for name in NOT_CALLED {
        let path = if name.contains('/') { at.join(name) } else { at.join("bin").join(name) };
        script(&path, "#!/usr/bin/env bash\n");
    }
    folder
}

/// Writes the files that a page shows.
fn write_files(blocks: &[Snippet], at: &Path) {
    for Snippet { file, text, language, .. } in blocks {
        if let Some(file) = file.as_ref().filter(|_| ["toml", "python"].contains(&&language[..])) {
            if root().join(file).exists() {
                continue; // an excerpt of a file of the repository
            }
            fs::create_dir_all(at.join(file).parent().unwrap()).unwrap();
            // Points of studies are runs too.
            fs::write(at.join(file), text.replace("[set]\n", "[set]\ntime.max_cycles = 20\n"))
                .unwrap();
        }
    }
}

/// Runs the shell blocks of a page as one script in this folder. Returns the output of each.
fn run(page: &str, blocks: &[Snippet], folder: &Path) -> Vec<String> {
    write_files(blocks, folder);
    let shell = blocks.iter().filter(|block| block.language == "sh");
    let text: String = shell.map(|block| format!("echo '@@ block'\n{}\n", block.text)).collect();
    let path = format!("{}/bin:{}", folder.display(), std::env::var("PATH").unwrap());
    let bash = Command::new("bash")
        .args(["-c", &format!("exec 2>&1\n{text}")])
        .env("PATH", path)
        .env("CRUMPLE_BIN", crumple())
        .current_dir(folder)
        .output()
        .unwrap_or_else(|error| panic!("{page}: bash: {error}"));
    let said = String::from_utf8_lossy(&bash.stdout).into_owned();
    said.split("@@ block\n").skip(1).map(String::from).collect()
}

/// Returns true if the pieces of a block of output (between `...`) are in `said`, in order. Blanks
/// count as one.
fn shows(said: &str, expected: &str) -> Result<(), String> {
    let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let said = plain(said);
    let mut rest = &said[..];
    for piece in expected.lines().flat_map(|line| line.split("...")).map(plain) {
        let Some(at) = rest.find(&piece) else {
            return Err(format!("`{piece}` is not in its place in the output"));
        };
        rest = &rest[at + piece.len()..];
    }
    Ok(())
}

#[test]
fn commands_of_the_tutorials_run() {
    let mut list = pages("docs/tutorials");
    list.extend(["docs/getting-started.md".into(), "README.md".into()]);
    let mut wrong = Vec::new();
    let shared = folder();
    for page in list.iter().filter(|page| !NEED_OTHER_PROGRAM.contains(&&page[..])) {
        let blocks = blocks(page);
        // The tutorials follow each other, the other two pages are begins.
        let own = (!page.starts_with("docs/tutorials")).then(folder);
        let outputs = run(page, &blocks, own.as_ref().unwrap_or(&shared).path());
        let shell: Vec<usize> =
            (0..blocks.len()).filter(|at| blocks[*at].language == "sh").collect();
        assert_eq!(outputs.len(), shell.len(), "{page}: the script ended early: {outputs:?}");
        assert!(outputs.iter().any(|said| said.contains("@@ exit")), "{page} calls crumple");
        for (at, said) in shell.into_iter().zip(outputs) {
            let shown = blocks.get(at + 1).filter(|next| next.language.is_empty());
            let expected = shown.map_or("", |block| &block.text[..]);
            let place = format!("{page}:{}", blocks[at].line);
            let failed = said.lines().any(|l| l.starts_with("@@ exit") && !l.contains("exit 0:"));
            if failed && !expected.contains("error") || said.contains("command not found") {
                wrong.push(format!("{place}: a command failed:\n{said}"));
            }
            let is_run = blocks[at].text.contains("crumple run");
            if let Err(why) = shows(&said, if is_run { "" } else { expected }) {
                wrong.push(format!("{place}: {why}:\n{said}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn missing_output_is_noticed() {
    assert_eq!(shows("a  b\nc d", "a b\n...\nd"), Ok(()));
    assert!(shows("a b", "b\na").is_err());
    assert!(shows("a b", "a ... c").is_err());
}
