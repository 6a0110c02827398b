//! `crumple init`: writes an example job, of those that are in the program.

use crate::cli::InitArgs;
use crate::input::job::nearest;
use crate::stdout;
pub use crumple_cases::{EXAMPLES, Example};
use std::path::PathBuf;

/// Writes the example, or lists all. Returns the exit code.
pub fn run(args: &InitArgs) -> u8 {
    stdout::ended(match &args.example {
        None => Ok(list()),
        Some(name) => write(name, args.out.clone()),
    })
}

/// Returns the names of the examples with the titles of their jobs.
fn list() -> String {
    let line = |example: &Example| {
        let title = example.job.lines().find_map(|line| line.strip_prefix("title = "));
        let mesh = example.mesh.map(|(file, _)| format!(" ({file})")).unwrap_or_default();
        format!("  {:<12} {}{mesh}\n", example.name, title.unwrap_or_default().trim_matches('"'))
    };
    let all: String = EXAMPLES.iter().map(line).collect();
    format!("examples, for `crumple init NAME`:\n{}", all.trim_end())
}

/// Writes an example into a folder and returns how to run it.
///
/// # Errors
/// There is no such example, or the folder has one of its files, or it cannot be written.
fn write(name: &str, out: Option<PathBuf>) -> Result<String, String> {
    let Some(example) = EXAMPLES.iter().find(|known| known.name == name) else {
        let names: Vec<&str> = EXAMPLES.iter().map(|known| known.name).collect();
        return Err(format!("there is no example {name}; {}", nearest(name, &names)));
    };
    let folder = out.unwrap_or_else(|| PathBuf::from(name));
    let job = ("job.toml", example.job.as_bytes());
    let files: Vec<(PathBuf, &[u8])> = std::iter::once(job)
        .chain(example.mesh)
        .map(|(file, content)| (folder.join(file), content))
        .collect();
    if let Some((file, _)) = files.iter().find(|(file, _)| file.exists()) {
        return Err(format!(
            "{} exists; name another folder with --out, or remove it: your changes would be lost",
            file.display()
        ));
    }
    for (file, content) in &files {
        std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(file, content)).map_err(
            |error| format!("{}: {error}; name another folder with --out", file.display()),
        )?;
    }
    let names: Vec<String> = files.iter().map(|(file, _)| file.display().to_string()).collect();
    Ok(format!(
        "{} {}; check it with `crumple check {2}`, run it with `crumple run {2}`",
        names.join(" and "),
        if names.len() == 1 { "is written" } else { "are written" },
        stdout::shell_word(&folder)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::job;

    #[test]
    fn each_example_is_a_job_without_errors() {
        let dir = tempfile::tempdir().unwrap();
        for Example { name, .. } in EXAMPLES {
            let folder = dir.path().join(name);
            write(name, Some(folder.clone())).unwrap();
            job::read(&folder, &[]).unwrap_or_else(|report| panic!("{name}: {report}"));
            assert!(write(name, Some(folder)).unwrap_err().contains("your changes"));
            assert!(list().contains(name));
        }
        assert!(write("bras", None).unwrap_err().contains("bars"));
    }
}
