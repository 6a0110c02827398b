//! `crumple import`: writes a job for a mesh file, and prints what became of its content.

mod job_text;

use super::reading::table;
use super::{KEY, ReadMesh, read};
use crate::cli::ImportArgs;
use crate::input::job::{Located, Report};
use crate::stdout;
use crumple_proto::problem::Problem;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Runs `crumple import`. Returns the exit code.
pub fn run(args: &ImportArgs) -> u8 {
    match import(args) {
        Ok(text) => {
            stdout::write(format_args!("{text}"));
            0
        }
        Err(problems) => {
            let located = |problem| Located { problem, spot: None };
            eprint!("{}", Report { problems: problems.into_iter().map(located).collect() });
            Report::EXIT_CODE
        }
    }
}

/// Reads the file, writes the folder of the job and returns the text to print.
fn import(args: &ImportArgs) -> Result<String, Vec<Problem>> {
    let file = &args.file;
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let folder = args.out.clone().unwrap_or_else(|| PathBuf::from(&name));
    let job = folder.join("job.toml");
    let read = read(file, args.allow_unsupported)?;
    if job.exists() {
        let message = format!("{} exists", job.display());
        let help = "name another folder with --out, or remove it: your changes would be lost";
        return Err(vec![Problem::error(KEY, message, help)]);
    }
    let copied = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let text = job_text::write(&job_text::ImportedJob {
        name: &name,
        file: &copied,
        read: &read,
        allowed: args.allow_unsupported,
    });
    write_folder(&folder, file, &read, &text.job).map_err(|error| {
        let message = format!("{} cannot be written: {error}", folder.display());
        vec![Problem::error(KEY, message, "name another folder with --out")]
    })?;
    let mut said = format!("file         {}: {}\n\n", file.display(), read.format.name);
    said += &table(&read.rows);
    for warning in &read.warnings {
        let _ = write!(said, "\n{}", Located { problem: warning.clone(), spot: None });
    }
    let _ = writeln!(said, "\njob          {}", job.display());
    if !text.placeholders.is_empty() {
        let _ = writeln!(said, "placeholders {}", text.placeholders.join(", "));
    }
    let _ = writeln!(said, "next         set the placeholders; crumple check {}", folder.display());
    Ok(said)
}

/// Writes the job, and copies the mesh file and the files that it includes next to it.
fn write_folder(folder: &Path, file: &Path, read: &ReadMesh, text: &str) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let base = file.parent().unwrap_or(Path::new(""));
    for source in &read.files {
        let inside = source.strip_prefix(base).unwrap_or(source);
        let target = folder.join(inside);
        if let Some(parent) = target.parent() {
            std::fs::create_dir_all(parent)?;
        }
        let is_there =
            target.exists() && std::fs::canonicalize(&target)? == std::fs::canonicalize(source)?;
        if !is_there {
            std::fs::copy(source, &target)?;
        }
    }
    std::fs::write(folder.join("job.toml"), text)
}
