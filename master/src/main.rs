//! The `crumple` binary.

use clap::Parser;
use crumple::cli::{Cli, Command};
use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(match Cli::parse().command {
        Command::Check(args) => crumple::check::run(&args),
        Command::Run(args) => crumple::launch::run(&args),
        Command::Verify(args) => crumple::verify::run(&args),
        Command::Advise { dir } => crumple::advise::run(&dir),
        Command::Bench(args) => crumple::bench::run(&args),
        Command::Report { dir } => crumple::report::run(&dir),
        Command::ExportDeck(args) => crumple::deck::export::run(&args),
        Command::Scale(args) => crumple::scale::run(&args),
        Command::ExportD3plot { dir, file_size } => crumple::d3plot::run(&dir, file_size),
        Command::ExportVtkhdf { dir } => crumple::vtkhdf::run(&dir),
        Command::Schema(args) => crumple::reference::run(&args),
        Command::Study(args) => crumple::study::run(&args),
    })
}
