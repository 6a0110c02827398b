//! The socket of a run: `run.sock` in its folder, open to its owner only.
//!
//! The address of a socket has at most 107 bytes, and some network file systems have no sockets.
//! `run.sock` is then a link to a socket in the folder for files of a session
//! (`XDG_RUNTIME_DIR`), or in a folder of the user for temporary files. Its name follows from the
//! folder of the run, so that a run that continues after a kill finds the old one and removes it.

use rustix::process::geteuid;
use std::fs::{self, Permissions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt, symlink};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

/// Name in the folder of the run.
pub const NAME: &str = "run.sock";

/// A socket that is open. It is removed when it is dropped.
pub struct Socket {
    /// The socket, and the link to it if it is elsewhere.
    files: Vec<PathBuf>,
}

impl Socket {
    /// Opens the socket of the run in the folder `out`. The folder is locked, so a socket that is
    /// there is left over from a run that was killed, and is removed.
    ///
    /// # Errors
    /// No socket can be made; the message names the path.
    pub fn bind(out: &Path) -> Result<(Self, UnixListener), String> {
        let named = |path: &Path, error: io::Error| format!("{}: {error}", path.display());
        let folder = fs::canonicalize(out).map_err(|error| named(out, error))?;
        let path = folder.join(NAME);
        let elsewhere = elsewhere(&folder);
        remove(&path).map_err(|error| named(&path, error))?;
        if let Ok(elsewhere) = &elsewhere {
            let _ = remove(elsewhere);
        }
        match listen(&path) {
            Ok(listener) => Ok((Self { files: vec![path] }, listener)),
            Err(_) => {
                let socket = elsewhere.map_err(|(path, error)| named(&path, error))?;
                let listener = listen(&socket).map_err(|error| named(&socket, error))?;
                let files = vec![path.clone(), socket.clone()];
                let opened = Self { files };
                symlink(&socket, &path).map_err(|error| named(&path, error))?;
                Ok((opened, listener))
            }
        }
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        // A socket that stays is harmless: no process answers, and the next run removes it.
        self.files.iter().for_each(|path| drop(remove(path)));
    }
}

/// Connects to the run in the folder `out`.
///
/// # Errors
/// No process answers.
pub fn connect(out: &Path) -> io::Result<UnixStream> {
    let path = fs::canonicalize(out)?.join(NAME);
    fs::symlink_metadata(&path)?; // for a long path, the system reports only its length
    UnixStream::connect(fs::read_link(&path).unwrap_or(path))
}

/// Opens a socket for this user only.
fn listen(path: &Path) -> io::Result<UnixListener> {
    let listener = UnixListener::bind(path)?;
    fs::set_permissions(path, Permissions::from_mode(0o600))?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Returns a short path for the socket of the run in this folder, in a folder that only this user
/// can write.
fn elsewhere(folder: &Path) -> Result<PathBuf, (PathBuf, io::Error)> {
    let user = geteuid().as_raw();
    let session = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from).filter(|d| d.is_dir());
    let base = session.unwrap_or_else(std::env::temp_dir).join(format!("crumple-{user}"));
    let made = match fs::DirBuilder::new().mode(0o700).create(&base) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => Err(error),
        _ => fs::symlink_metadata(&base),
    };
    let is_safe = |m: &fs::Metadata| m.is_dir() && m.uid() == user && m.mode() & 0o077 == 0;
    let refused = || io::Error::new(ErrorKind::PermissionDenied, "others can write this folder");
    match made {
        Ok(metadata) if is_safe(&metadata) => {}
        Ok(_) => return Err((base, refused())),
        Err(error) => return Err((base, error)),
    }
    let name = blake3::hash(folder.as_os_str().as_encoded_bytes()).to_hex();
    Ok(base.join(&name[..16]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns true if a client reaches the listener.
    fn is_reached(out: &Path, listener: &UnixListener) -> bool {
        let client = connect(out);
        client.is_ok() && listener.accept().is_ok()
    }

    #[test]
    fn a_socket_is_private_and_is_removed_and_one_that_stayed_is_replaced() {
        let deep = "a/".repeat(60) + "b";
        for folder in ["short", &deep] {
            let dir = tempfile::tempdir().unwrap();
            let out = dir.path().join(folder);
            fs::create_dir_all(&out).unwrap();
            let (left, _) = Socket::bind(&out).unwrap();
            std::mem::forget(left); // as after a kill
            assert!(connect(&out).is_err_and(|e| e.kind() == ErrorKind::ConnectionRefused));
            let (socket, listener) = Socket::bind(&out).unwrap();
            assert!(is_reached(&out, &listener), "{folder}");
            let files = socket.files.clone();
            assert_eq!(files.len(), if folder == "short" { 1 } else { 2 });
            let mode = fs::metadata(files.last().unwrap()).unwrap().mode();
            assert_eq!(mode & 0o777, 0o600, "{mode:o}");
            drop(socket);
            assert!(files.iter().all(|path| fs::symlink_metadata(path).is_err()), "{files:?}");
            assert!(connect(&out).is_err_and(|e| e.kind() == ErrorKind::NotFound));
        }
    }
}
