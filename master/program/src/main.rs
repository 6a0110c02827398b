//! The `crumple` binary: one call for each command, into the library of the master or, for
//! `crumple verify`, into the catalogue of verification cases.

use clap::{CommandFactory, FromArgMatches};
use crumple::cli::{Cli, Command};
use crumple::features::COMMIT;
use std::process::ExitCode;

/// Commit of the sources, see `build.rs`; empty if it is not known.
const OWN_COMMIT: &str = env!("CRUMPLE_COMMIT");

/// Reads the command line. `--version` shows the commit too.
fn command() -> Command {
    let mut command = Cli::command();
    if !OWN_COMMIT.is_empty() {
        COMMIT.get_or_init(|| OWN_COMMIT);
        command =
            command.version(concat!(env!("CARGO_PKG_VERSION"), " (", env!("CRUMPLE_COMMIT"), ")"));
    }
    let matches = command.get_matches();
    Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit()).command
}

fn main() -> ExitCode {
    ExitCode::from(match command() {
        Command::Check(args) => crumple::analysis::check::run(&args),
        Command::Attach(args) => crumple::run::attach::run(&args),
        Command::Run(args) => crumple::run::launch::run(&args),
        Command::Serve(args) => crumple::serve::run(&args),
        Command::Submit(args) => crumple::client::submit(&args),
        Command::Jobs(args) => crumple::client::jobs(&args),
        Command::Watch(args) => crumple::client::watch(&args),
        Command::Stop(args) => crumple::client::stop(&args),
        Command::Resume(args) => crumple::client::resume(&args),
        Command::Fetch(args) => crumple::client::fetch(&args),
        Command::Verify(args) => crumple_verification::run(&args),
        Command::Reproduce(args) => crumple::analysis::reproduce::run(&args),
        Command::Diff(args) => crumple::analysis::diff::run(&args),
        Command::Init(args) => crumple::input::init::run(&args),
        Command::Completions { shell } => crumple::cli::pages::completions(shell),
        Command::Manual { dir } => crumple::cli::pages::manual(&dir),
        Command::Advise { dir } => crumple::analysis::advise::run(&dir),
        Command::Bench(args) => crumple::analysis::bench::run(&args),
        Command::Report { dir, second } => crumple::results::report::run(&dir, second.as_deref()),
        Command::Import(args) => crumple::input::mesh_file::import::run(&args),
        Command::ExportDeck(args) => crumple::input::deck::export::run(&args),
        Command::Convert(args) => crumple::input::deck::translate::run(&args),
        Command::Scale(args) => crumple::analysis::scale::run(&args),
        Command::ExportD3plot { dir, file_size, strains } => {
            crumple::results::d3plot::run(&dir, file_size, strains)
        }
        Command::ExportBinout { dir } => crumple::results::binout::run(&dir),
        Command::ExportVtkhdf { dir } => crumple::results::vtkhdf::run(&dir),
        Command::ExportExodus { dir } => crumple::results::exodus::run(&dir),
        Command::Materials(args) => crumple::input::job::library::run(&args),
        Command::Schema(args) => crumple::input::reference::run(&args),
        Command::Study(args) => crumple::analysis::study::run(&args),
    })
}
