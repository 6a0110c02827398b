//! `crumple init`: writes an example job, of those that are in the program.

use crate::cli::InitArgs;
use crate::input::job::nearest;
use crate::stdout;
pub use crumple_cases::EXAMPLES;
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
    let line = |(name, text): &(&str, &str)| {
        let title = text.lines().find_map(|line| line.strip_prefix("title = "));
        format!("  {name:<12} {}\n", title.unwrap_or_default().trim_matches('"'))
    };
    let all: String = EXAMPLES.iter().map(line).collect();
    format!("examples, for `crumple init NAME`:\n{}", all.trim_end())
}

/// Writes an example into a folder and returns how to run it.
///
/// # Errors
/// There is no such example, or the folder has a job, or it cannot be written.
fn write(name: &str, out: Option<PathBuf>) -> Result<String, String> {
    let Some((_, text)) = EXAMPLES.iter().find(|(known, _)| *known == name) else {
        let names: Vec<&str> = EXAMPLES.iter().map(|(known, _)| *known).collect();
        return Err(format!("there is no example {name}; {}", nearest(name, &names)));
    };
    let folder = out.unwrap_or_else(|| PathBuf::from(name));
    let file = folder.join("job.toml");
    if file.exists() {
        return Err(format!(
            "{} exists; name another folder with --out, or remove it: your changes would be lost",
            file.display()
        ));
    }
    std::fs::create_dir_all(&folder)
        .and_then(|()| std::fs::write(&file, text))
        .map_err(|error| format!("{}: {error}; name another folder with --out", file.display()))?;
    Ok(format!(
        "{} is written; check it with `crumple check {1}`, run it with `crumple run {1}`",
        file.display(),
        folder.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::job;

    #[test]
    fn each_example_is_a_job_without_errors() {
        let dir = tempfile::tempdir().unwrap();
        for (name, _) in EXAMPLES {
            let folder = dir.path().join(name);
            write(name, Some(folder.clone())).unwrap();
            job::read(&folder, &[]).unwrap_or_else(|report| panic!("{name}: {report}"));
            assert!(write(name, Some(folder)).unwrap_err().contains("your changes"));
            assert!(list().contains(name));
        }
        assert!(write("bras", None).unwrap_err().contains("bars"));
    }
}
