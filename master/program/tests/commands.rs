//! Commands of the binary. This test also makes `cargo test --workspace` build the binary, which
//! tests of other packages start.

use std::process::{Command, Output};

fn crumple(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_crumple")).args(args).output().unwrap()
}

#[test]
fn a_command_of_the_master_runs() {
    let schema = crumple(&["schema"]);
    assert_eq!(schema.status.code(), Some(0));
    assert!(String::from_utf8(schema.stdout).unwrap().contains("end_time"));
}

#[test]
fn verify_names_the_nearest_entry() {
    let verify = crumple(&["verify", "--only", "A0l"]);
    assert_eq!(verify.status.code(), Some(2));
    let words = String::from_utf8(verify.stderr).unwrap();
    assert!(words.contains("no entry A0l; did you mean A01"), "{words}");
}

#[test]
fn completions_and_manual_pages_name_all_commands() {
    let help = String::from_utf8(crumple(&["--help"]).stdout).unwrap();
    let of_line = |line: &str| line.strip_prefix("  ")?.split(' ').next().map(String::from);
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names: Vec<String> = listed.map_while(of_line).filter(|name| !name.is_empty()).collect();
    assert!(names.len() > 20 && names.contains(&"reproduce".into()), "{names:?}");
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = String::from_utf8(crumple(&["completions", shell]).stdout).unwrap();
        assert!(names.iter().all(|name| script.contains(name.as_str())), "{shell}");
    }
    let dir = tempfile::tempdir().unwrap();
    let written = crumple(&["manual", dir.path().to_str().unwrap()]);
    assert_eq!(written.status.code(), Some(0));
    for name in names.iter().filter(|name| *name != "help") {
        let page = dir.path().join(format!("crumple-{name}.1"));
        assert!(page.is_file(), "{}", page.display());
    }
}
