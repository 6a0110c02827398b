//! A folder that the files of jobs must not leave (`--within`), for jobs of other users.
//!
//! It holds for the whole process and is set before the first file is read.

use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::OnceLock;

static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// Confines this process to a folder.
///
/// # Errors
/// The folder does not exist.
pub fn to(folder: &Path) -> io::Result<()> {
    let folder = std::fs::canonicalize(folder)?;
    FOLDER.get_or_init(|| folder);
    Ok(())
}

/// Checks that a file of a job may be read.
///
/// # Errors
/// It is outside the folder; the message is the same whether it exists or not.
pub fn check(path: &Path) -> io::Result<()> {
    match FOLDER.get() {
        Some(folder) if !is_within(folder, path) => Err(io::Error::new(
            io::ErrorKind::PermissionDenied,
            "files of this job must be in its own folder",
        )),
        _ => Ok(()),
    }
}

/// Returns true if a path is in a folder, after all links. The end of the path need not exist.
pub fn is_within(folder: &Path, path: &Path) -> bool {
    let mut existing = path;
    loop {
        let named = if existing.as_os_str().is_empty() { Path::new(".") } else { existing };
        match std::fs::canonicalize(named) {
            Ok(whole) => {
                let rest = path.strip_prefix(existing).unwrap_or(Path::new(""));
                let plain = rest.components().all(|c| matches!(c, Component::Normal(_)));
                // A link without a target is there, but has no canonical path.
                let is_link = rest.components().next().is_some_and(|next| {
                    std::fs::symlink_metadata(whole.join(next)).is_ok_and(|m| m.is_symlink())
                });
                return whole.starts_with(folder) && plain && !is_link;
            }
            Err(_) => match existing.parent() {
                Some(parent) => existing = parent,
                None => return false,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn paths_are_judged_after_links_and_whether_they_exist_or_not() {
        let dir = tempfile::tempdir().unwrap();
        let dir = std::fs::canonicalize(dir.path()).unwrap();
        let own = dir.join("own");
        std::fs::create_dir_all(own.join("sub")).unwrap();
        std::fs::create_dir_all(dir.join("own2")).unwrap();
        std::fs::write(own.join("a"), "").unwrap();
        std::fs::write(dir.join("b"), "").unwrap();
        symlink("../b", own.join("link")).unwrap();
        symlink("../absent", own.join("dangling")).unwrap();
        symlink("..", own.join("up")).unwrap();
        symlink("a", own.join("inner")).unwrap();
        for (path, inside) in [
            ("own/a", true),
            ("own/sub/../a", true),
            ("own/inner", true),
            ("own/absent", true),
            ("own/absent/deeper", true),
            ("own/../b", false),
            ("own/../absent", false),
            ("own/absent/../../b", false),
            ("own/link", false),
            ("own/dangling", false),
            ("own/up/b", false),
            ("own/up/absent", false),
            ("own2", false),
            ("own2/absent", false),
            ("b", false),
        ] {
            assert_eq!(is_within(&own, &dir.join(path)), inside, "{path}");
        }
        assert!(!is_within(&own, Path::new("/etc/passwd")));
        assert!(!is_within(&own, Path::new("relative")));
    }
}
