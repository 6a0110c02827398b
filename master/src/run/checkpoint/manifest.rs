//! The manifest of a checkpoint: what its files are and which job they belong to.
//!
//! The first line has the format version and the blake3 sum of the rest, which is JSON. The file is
//! renamed into place after all others are on disk: a folder without it is no checkpoint.

use crumple_proto::checkpoint::{Captured, FORMAT, FileRecord};
use crumple_worker::checkpoint::layout::Layout;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// Name of the file.
pub const MANIFEST: &str = "MANIFEST";
/// First word of the file.
const TITLE: &str = "crumple-checkpoint";
/// Largest manifest that is read [byte].
const LARGEST: u64 = 1 << 30;

/// The job of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stamp {
    /// The job file, as an absolute path.
    pub file: String,
    /// The `key=value` of the command line.
    pub set: Vec<String>,
    /// All keys of the job except those of the mesh.
    pub job: serde_json::Value,
    /// Blake3 sum of the model at time 0: nodes and elements.
    pub mesh: String,
    /// Names of all columns and fields in the files.
    pub layout: Layout,
}

/// Contents of a manifest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of the program that wrote it.
    pub program: String,
    /// The state.
    pub captured: Captured,
    /// The job.
    pub stamp: Stamp,
    /// Number of elements.
    pub elements: usize,
    /// State of the master.
    pub master: FileRecord,
    /// State that all workers have in common.
    pub common: FileRecord,
    /// Files of the workers.
    pub pieces: Vec<FileRecord>,
}

impl Manifest {
    /// Returns all files.
    pub fn files(&self) -> impl Iterator<Item = &FileRecord> {
        [&self.master, &self.common].into_iter().chain(&self.pieces)
    }

    /// Returns the text of the file.
    pub fn to_text(&self) -> String {
        let body = serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        format!("{TITLE} {FORMAT} {}\n{body}", blake3::hash(body.as_bytes()).to_hex())
    }

    /// Reads the text of the file.
    ///
    /// # Errors
    /// It is no manifest of this format; the message says why.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let end = bytes.iter().position(|&b| b == b'\n').ok_or("it has no first line")?;
        let first = std::str::from_utf8(&bytes[..end]).map_err(|_| "its first line is no text")?;
        let body = &bytes[end + 1..];
        let words: Vec<&str> = first.split(' ').collect();
        let [TITLE, format, sum] = words[..] else {
            return Err("its first line is not that of a manifest".into());
        };
        if format != FORMAT.to_string() {
            return Err(format!(
                "it has format {format}, and this program ({}) reads format {FORMAT}: use the \
                 version of the program that wrote it",
                env!("CARGO_PKG_VERSION")
            ));
        }
        if blake3::hash(body).to_hex().as_str() != sum {
            return Err("its content has changed: the blake3 sum differs".into());
        }
        serde_json::from_slice(body).map_err(|error| error.to_string())
    }

    /// Reads the manifest in a folder.
    ///
    /// # Errors
    /// There is none, or it cannot be used; the message names the file.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let path = folder.join(MANIFEST);
        let named = |why: String| format!("{}: {why}", path.display());
        let size = std::fs::metadata(&path).map_err(|e| named(e.to_string()))?.len();
        if size > LARGEST {
            return Err(named(format!("a manifest does not have {size} bytes")));
        }
        let bytes = std::fs::read(&path).map_err(|e| named(e.to_string()))?;
        Self::from_bytes(&bytes).map_err(named)
    }

    /// Writes the manifest. Before it returns, the disk has the file under its name.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        let temporary = folder.join(format!("{MANIFEST}.tmp"));
        let mut file = File::create(&temporary)?;
        file.write_all(self.to_text().as_bytes())?;
        file.sync_all()?;
        sync(folder)?; // the names of the other files, before that of the manifest
        std::fs::rename(&temporary, folder.join(MANIFEST))?;
        sync(folder)?;
        folder.parent().map_or(Ok(()), sync)
    }
}

/// Waits until the disk has a file, or the names in a folder.
pub fn sync(path: &Path) -> io::Result<()> {
    File::open(path)?.sync_all()
}

#[cfg(test)]
/// A manifest for tests of this folder.
pub mod tests {
    use super::*;

    /// Returns a manifest for tests.
    pub fn sample() -> Manifest {
        let file = |name: &str| FileRecord { name: name.into(), bytes: 7, blake3: "ab".into() };
        Manifest {
            program: "0.1.0".into(),
            captured: Captured { cycle: 1200, time: 0.22171391042741825, rows: 4, fields: 2 },
            stamp: Stamp { file: "/job.toml".into(), ..Stamp::default() },
            elements: 12,
            master: file("master.bin"),
            common: file("common.bin"),
            pieces: vec![file("piece_00000.bin"), file("piece_00001.bin")],
        }
    }

    #[test]
    fn manifests_make_the_round_trip_and_no_change_is_accepted() {
        let text = sample().to_text();
        let back = Manifest::from_bytes(text.as_bytes()).unwrap();
        assert_eq!(back, sample(), "to the last bit");
        assert_eq!((back.captured.cycle, back.files().count()), (1200, 4));
        let other = text.replacen(&format!(" {FORMAT} "), " 999 ", 1);
        assert!(Manifest::from_bytes(other.as_bytes()).unwrap_err().contains("format 999"));
        for i in 0..text.len() {
            let mut bad = text.clone().into_bytes();
            bad[i] ^= 1 << (i % 7);
            assert!(Manifest::from_bytes(&bad).is_err(), "byte {i}");
            assert!(Manifest::from_bytes(&text.as_bytes()[..i]).is_err(), "cut at {i}");
        }
    }
}
