//! `crumple convert`: writes a job or a deck as a deck of another format, with a list of what that
//! format has no card for.

use super::{export, radioss};
use crate::cli::ConvertArgs;
use crate::input::job::{self, Located, Model, Report};
use crate::stdout;
use crumple_proto::problem::Problem;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// End of the name of a starter file.
const STARTER: &str = "_0000.rad";
/// Ending of the file with the list of losses.
const LOSSES: &str = "losses.txt";

/// Runs `crumple convert`. Returns the exit code.
pub fn run(args: &ConvertArgs) -> u8 {
    let model = match job::read(&args.from, &args.set) {
        Ok(model) => model,
        Err(report) => {
            eprint!("{report}");
            return Report::EXIT_CODE;
        }
    };
    match convert(&model, args) {
        Ok(text) => {
            stdout::write(format_args!("{text}"));
            0
        }
        Err(problem) => {
            let located = Located { problem, spot: None };
            eprint!("{}", Report { problems: vec![located] });
            Report::EXIT_CODE
        }
    }
}

/// A deck that was made: its files with their texts, and what it lacks.
struct MadeDeck {
    files: Vec<(PathBuf, String)>,
    losses: Vec<String>,
}

/// Writes the files and returns the text to print.
fn convert(model: &Model, args: &ConvertArgs) -> Result<String, Problem> {
    let mut made = made(model, &args.to)?;
    let reading = losses_of_reading(model);
    made.losses.splice(0..0, reading);
    let warnings: Vec<String> =
        model.warnings.iter().map(|w| format!("{}: {}", w.message, w.help)).collect();
    let list = args.to.with_extension(LOSSES);
    let mut text = format!("{} as {}\n\n", args.from.display(), args.to.display());
    match made.losses.is_empty() {
        true if warnings.is_empty() => text += "Nothing is lost.\n",
        true => text += "No losses apart from these warnings of reading.\n",
        false => {
            let _ = writeln!(text, "Losses ({}):", made.losses.len());
            made.losses.iter().for_each(|loss| text += &format!("- {loss}\n"));
            text += "\nKeys without a card are in comments that begin with $crumple: only Crumple \
                     reads them.\n";
        }
    }
    if !warnings.is_empty() {
        let _ = writeln!(text, "\nWarnings of reading ({}):", warnings.len());
        warnings.iter().for_each(|warning| text += &format!("- {warning}\n"));
    }
    made.files.push((list, text.clone()));
    // No file is written if one of them is in the way.
    for (path, _) in &made.files {
        if !args.overwrite && std::fs::symlink_metadata(path).is_ok() {
            let message = format!("{} exists", path.display());
            return Err(Problem::error("", message, "name another file, or give --overwrite"));
        }
    }
    for (path, content) in &made.files {
        std::fs::write(path, content).map_err(|error| {
            let message = format!("{} cannot be written: {error}", path.display());
            Problem::error("", message, "name a file in a folder that you can write to")
        })?;
    }
    text += "\nwritten:\n";
    made.files.iter().for_each(|(path, _)| text += &format!("  {}\n", path.display()));
    Ok(text)
}

/// Returns the deck in the format that the name of the file has.
fn made(model: &Model, to: &Path) -> Result<MadeDeck, Problem> {
    let name = to.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let cannot = |message: String| {
        Problem::error("", message, "remove it from the job, or write another format")
    };
    if let Some(base) = name.strip_suffix(STARTER) {
        let deck = radioss::export::export(model, base).map_err(cannot)?;
        let engine = radioss::text::engine_file(to).unwrap_or_default();
        let files = vec![(to.to_path_buf(), deck.starter), (engine, deck.engine)];
        return Ok(MadeDeck { files, losses: deck.losses });
    }
    if super::is_deck(to) && !name.to_lowercase().ends_with(".rad") {
        let deck = export::export(model).map_err(cannot)?;
        return Ok(MadeDeck { files: vec![(to.to_path_buf(), deck.text)], losses: deck.left });
    }
    let message = format!("{} has no ending of a deck", to.display());
    Err(Problem::error(
        "",
        message,
        "end it in _0000.rad for Radioss, or in .k, .key or .dyn for LS-DYNA",
    ))
}

/// Returns what the deck that was read asks for and the job has in another form.
fn losses_of_reading(model: &Model) -> Vec<String> {
    let unsupported = model.unsupported.iter().map(|text| format!("not read: {text}"));
    let changed = model.mapping.iter().map(|m| format!("{}: {} -> {}", m.of, m.asked, m.used));
    unsupported.chain(changed).collect()
}
