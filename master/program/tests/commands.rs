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
