//! The files of a job, and their way to the service.

use super::server::Server;
use crate::serve::ArchiveFormat;
use crate::serve::api::{ServiceJob, Submission};
use std::fs::File;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

/// Files of a job.
#[derive(Debug)]
pub struct Files {
    /// Path of the job file in the job; empty if the service is to find it.
    pub main: String,
    /// Path in the job, and file.
    pub all: Vec<(String, PathBuf)>,
    /// Name of the parts of the form: `file`, or `archive` for one that the service unpacks.
    part: &'static str,
}

/// Returns the files that belong to a job: those of its folder, the job file and further files, or
/// an archive.
///
/// # Errors
/// One cannot be read, or lies outside the folder of the job.
pub fn files(job: &Path, further: &[PathBuf]) -> Result<Files, String> {
    let named = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
    if let Some(name) = archive_name(job) {
        if !further.is_empty() {
            return Err(format!("{}: an archive has all files of the job", job.display()));
        }
        let all = vec![(name, job.to_path_buf())];
        return Ok(Files { main: String::new(), all, part: "archive" });
    }
    let folder = if job.is_dir() { job } else { job.parent().unwrap_or(Path::new("")) };
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let base = std::fs::canonicalize(here).map_err(|error| named(here, error))?;
    let mut all = Vec::new();
    let mut add = |path: &Path| -> Result<String, String> {
        let whole = std::fs::canonicalize(path).map_err(|error| named(path, error))?;
        let name = whole.strip_prefix(&base).map_err(|_| {
            format!("{}: files must be below the folder of the job", path.display())
        })?;
        let name = name.to_string_lossy().into_owned();
        all.push((name.clone(), whole));
        Ok(name)
    };
    let main = match job.is_dir() {
        false => add(job)?,
        true => {
            let mut open = vec![job.to_path_buf()];
            while let Some(folder) = open.pop() {
                let entries = std::fs::read_dir(&folder).map_err(|error| named(&folder, error))?;
                for entry in entries.flatten() {
                    let hidden = entry.file_name().to_string_lossy().starts_with('.');
                    match entry.file_type() {
                        Ok(kind) if kind.is_dir() && !hidden => open.push(entry.path()),
                        Ok(kind) if kind.is_file() && !hidden => drop(add(&entry.path())?),
                        _ => {}
                    }
                }
            }
            String::new()
        }
    };
    for file in further {
        add(file)?;
    }
    all.sort();
    all.dedup();
    Ok(Files { main, all, part: "file" })
}

/// Returns the file name of an archive; none if the path is another file or a folder.
fn archive_name(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_string_lossy().into_owned();
    (ArchiveFormat::of_name(&name).is_some() && !path.is_dir()).then_some(name)
}

/// Submits a job as `multipart/form-data`. `ureq` has such a form too, but writes names of files as
/// they are: a quotation mark would end the header.
///
/// # Errors
/// The service refuses, or a file cannot be read.
pub fn send(server: &Server, options: &Submission, files: &Files) -> Result<ServiceJob, String> {
    let secret = crate::serve::secret().map_err(|error| error.to_string())?;
    let boundary = &secret[..40];
    let mut body: Box<dyn Read> = Box::new(std::io::empty());
    let text = serde_json::to_string(options).map_err(|error| error.to_string())?;
    let head = format!("--{boundary}\r\nContent-Disposition: form-data; name=\"options\"\r\n\r\n");
    body = Box::new(body.chain(Cursor::new(head + &text + "\r\n")));
    for (name, path) in &files.all {
        let file = File::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let name = name.replace('"', "%22").replace(['\r', '\n'], " ");
        let head = format!(
            "--{boundary}\r\nContent-Disposition: form-data; name=\"{}\"; filename=\"{name}\"\r\n\
             Content-Type: application/octet-stream\r\n\r\n",
            files.part
        );
        body = Box::new(body.chain(Cursor::new(head)).chain(file).chain(Cursor::new("\r\n")));
    }
    let mut body = body.chain(Cursor::new(format!("--{boundary}--\r\n")));
    server.send("/api/jobs", &format!("multipart/form-data; boundary={boundary}"), &mut body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_keep_their_paths_below_the_folder_of_the_job() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("job");
        std::fs::create_dir_all(folder.join("parts")).unwrap();
        for name in ["job.toml", "parts/a.k", ".hidden"] {
            std::fs::write(folder.join(name), "").unwrap();
        }
        std::fs::write(dir.path().join("other"), "").unwrap();
        let names = |files: &Files| files.all.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
        let whole = files(&folder, &[]).unwrap();
        assert_eq!(
            (names(&whole), &*whole.main),
            (vec!["job.toml".into(), "parts/a.k".into()], "")
        );
        let one = files(&folder.join("job.toml"), &[folder.join("parts/a.k")]).unwrap();
        assert_eq!((names(&one), &*one.main), (names(&whole), "job.toml"));
        let why = files(&folder, &[dir.path().join("other")]).unwrap_err();
        assert!(why.contains("below the folder"), "{why}");
        assert!(files(&folder.join("absent.toml"), &[]).is_err());
        let archive = files(&folder.join("a.TGZ"), &[]).unwrap();
        assert_eq!((names(&archive), archive.part), (vec!["a.TGZ".into()], "archive"));
        assert!(files(&folder.join("a.zip"), &[folder.join("job.toml")]).is_err());
    }
}
