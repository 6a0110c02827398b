//! The `crumple` binary: one call for each command, into the library of the master or, for
//! `crumple verify`, into the catalogue of verification cases.

use clap::Parser;
use crumple::cli::{Cli, Command};
use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(match Cli::parse().command {
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
        Command::Advise { dir } => crumple::analysis::advise::run(&dir),
        Command::Bench(args) => crumple::analysis::bench::run(&args),
        Command::Report { dir } => crumple::results::report::run(&dir),
        Command::Import(args) => crumple::input::mesh_file::import::run(&args),
        Command::ExportDeck(args) => crumple::input::deck::export::run(&args),
        Command::Scale(args) => crumple::analysis::scale::run(&args),
        Command::ExportD3plot { dir, file_size } => crumple::results::d3plot::run(&dir, file_size),
        Command::ExportVtkhdf { dir } => crumple::results::vtkhdf::run(&dir),
        Command::ExportExodus { dir } => crumple::results::exodus::run(&dir),
        Command::Schema(args) => crumple::input::reference::run(&args),
        Command::Study(args) => crumple::analysis::study::run(&args),
    })
}
