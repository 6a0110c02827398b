//! `crumple completions` and `crumple manual`: files for shells and for `man`, from the command
//! line itself.

use super::Cli;
use crate::stdout;
use clap::CommandFactory;
use clap_complete::Shell;
use std::path::Path;

/// Prints the completions for a shell. Returns the exit code.
pub fn completions(shell: Shell) -> u8 {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "crumple", &mut script);
    stdout::write(format_args!("{}", String::from_utf8_lossy(&script)));
    0
}

/// Writes the manual page of the program and one of each command. Returns the exit code.
pub fn manual(dir: &Path) -> u8 {
    let written = std::fs::create_dir_all(dir)
        .and_then(|()| clap_mangen::generate_to(Cli::command(), dir))
        .map(|()| {
            format!("manual pages are in {0}; read them with: man -l {0}/crumple.1", dir.display())
        });
    stdout::ended(written.map_err(|error| format!("{}: {error}", dir.display())))
}
