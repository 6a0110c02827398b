//! `crumple import`: writes a job for a mesh file, and prints what became of its content.

mod job_text;

use super::reading::table;
use super::{KEY, ReadMesh, read};
use crate::cli::ImportArgs;
use crate::input::check;
use crate::input::job::{Located, Report};
use crate::stdout;
use crumple_proto::problem::Problem;
use std::fmt::Write as _;
use std::path::{Component, Path, PathBuf};

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
    let read = read(file, args.allow_unsupported, None)?;
    if std::fs::symlink_metadata(&job).is_ok() {
        let message = format!("{} exists", job.display());
        let help = "name another folder with --out, or remove it: your changes would be lost";
        return Err(vec![Problem::error(KEY, message, help)]);
    }
    let copied = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let copies = copies(&folder, file, &read)?;
    let text = match &read.deck {
        Some(deck) if deck.has_parts => job_text::of_deck(&name, &copied, args.allow_unsupported),
        _ => job_text::write(&job_text::ImportedJob {
            name: &name,
            file: &copied,
            read: &read,
            allowed: args.allow_unsupported,
        }),
    };
    write_folder(&folder, &copies, &text.job).map_err(|error| {
        let message = format!("{} cannot be written: {error}", folder.display());
        vec![Problem::error(KEY, message, "name another folder with --out")]
    })?;
    let mut said = format!("file         {}: {}\n\n", file.display(), read.format.name);
    let of_deck = read.deck.as_ref();
    said += &table(of_deck.map_or(&read.rows, |deck| &deck.rows));
    if let Some(deck) = of_deck {
        said += &check::mapping_of(&deck.mapping, &deck.unsupported);
    }
    let warnings = of_deck.map_or(&[][..], |deck| &deck.warnings[..]);
    for warning in read.warnings.iter().chain(warnings) {
        let _ = write!(said, "\n{}", Located { problem: warning.clone(), spot: None });
    }
    let _ = writeln!(said, "\njob          {}", job.display());
    if of_deck.is_some_and(|deck| !deck.has_parts) {
        let _ = writeln!(
            said,
            "deck         it has no /PART: the job has only its nodes, elements and groups"
        );
    }
    if !text.units.is_empty() {
        let _ = writeln!(said, "units        {}", text.units);
    }
    let first = match text.placeholders.is_empty() {
        true => "",
        false => "set the placeholders; ",
    };
    if !text.placeholders.is_empty() {
        let _ = writeln!(said, "placeholders {}", text.placeholders.join(", "));
    }
    let _ = writeln!(said, "next         {first}crumple check {}", stdout::shell_word(&folder));
    said += &text.to_add;
    Ok(said)
}

/// A file of the mesh, and its copy in the folder of the job.
struct MeshCopy<'a> {
    source: &'a Path,
    target: PathBuf,
}

/// Returns the copies to make. They are all in the folder of the job and replace no other file.
///
/// # Errors
/// All files that would be outside of the folder, or would replace a file there.
fn copies<'a>(
    folder: &Path,
    file: &Path,
    read: &'a ReadMesh,
) -> Result<Vec<MeshCopy<'a>>, Vec<Problem>> {
    let base = file.parent().unwrap_or(Path::new(""));
    let (mut found, mut problems) = (Vec::new(), Vec::new());
    for source in &read.files {
        let inside = source.strip_prefix(base).unwrap_or(source);
        let is_below =
            inside.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if !is_below {
            let message = format!(
                "the included file {} is not in the folder of {}",
                source.display(),
                file.display()
            );
            let help = "copy it next to the mesh file, and include it by its name alone";
            problems.push(Problem::error(KEY, message, help));
            continue;
        }
        let target = folder.join(inside);
        let is_job = inside == Path::new("job.toml");
        if is_job || std::fs::symlink_metadata(&target).is_ok() && !is_same(source, &target) {
            let message = format!("{} would replace {}", source.display(), target.display());
            let help = "name another folder with --out, or rename one of the two files";
            problems.push(Problem::error(KEY, message, help));
            continue;
        }
        found.push(MeshCopy { source, target });
    }
    if problems.is_empty() { Ok(found) } else { Err(problems) }
}

/// Returns true if two paths are one file, or two files with the same bytes.
fn is_same(source: &Path, target: &Path) -> bool {
    let is_one = match (std::fs::canonicalize(source), std::fs::canonicalize(target)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    };
    is_one
        || match (std::fs::read(source), std::fs::read(target)) {
            (Ok(a), Ok(b)) => a == b,
            _ => false,
        }
}

/// Writes the job, and copies the mesh file and the files that it includes next to it.
fn write_folder(folder: &Path, copies: &[MeshCopy], text: &str) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    for copy in copies.iter().filter(|copy| !is_same(copy.source, &copy.target)) {
        if let Some(parent) = copy.target.parent() {
            std::fs::create_dir_all(parent)?;
        }
        std::fs::copy(copy.source, &copy.target)?;
    }
    std::fs::write(folder.join("job.toml"), text)
}
