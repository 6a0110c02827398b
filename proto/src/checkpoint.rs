//! Files of a checkpoint: words with a header, as bytes, optionally compressed.
//!
//! A checkpoint is a folder. Every worker writes one file, its *piece*; the first worker also
//! writes the state that all workers have in common. A file has the magic bytes and the format
//! version, the kind of compression, the number of words, and the words, little-endian. The
//! manifest of the master names every file with its size and its blake3 sum, so that a truncated
//! or changed file is never used.

use crate::job::Compression;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// Version of the format of manifests and files. It changes with every change of their content.
pub const FORMAT: u32 = 3;
/// First bytes of a file.
const MAGIC: [u8; 4] = *b"CRCK";
/// Bytes of the header: magic bytes, version, compression, number of words.
const HEADER: usize = 4 + 4 + 8 + 8;
/// Level of compression: the fastest one.
const LEVEL: i32 = 1;
/// Name of the file with the state that all workers have in common.
pub const COMMON: &str = "common.bin";

/// Returns the name of the file of a worker.
pub fn piece_name(worker: usize) -> String {
    format!("piece_{worker:05}.bin")
}

/// A file of a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRecord {
    /// Name in the folder of the checkpoint.
    pub name: String,
    /// Size [byte].
    pub bytes: u64,
    /// Blake3 sum of all bytes, in hexadecimal digits.
    pub blake3: String,
}

/// Names the checkpoint that all workers have captured, and what they had sent to the master
/// before. Equal on all workers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Captured {
    /// Cycles completed.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Number of history rows sent, see [`HistoryPart::row`](crate::report::HistoryPart::row).
    pub rows: u64,
    /// Number of field outputs written.
    pub fields: u64,
}

/// End of the writing of a worker's files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Saved {
    /// Cycles completed at the checkpoint.
    pub cycle: u64,
    /// The files, or the reason why they could not be written.
    pub files: Result<Vec<FileRecord>, String>,
    /// Time of the copy, during which the worker did not advance [s].
    pub copy_s: f64,
    /// Time of the writing, during which the worker advanced [s].
    pub write_s: f64,
}

/// Returns the name of the folder of a checkpoint in the folder of all checkpoints of a run.
pub fn folder_name(cycle: u64) -> String {
    format!("cycle_{cycle:010}")
}

/// Returns the bytes of a file with these words.
///
/// # Errors
/// The compressor reports an error.
pub fn encode(words: &[u64], compression: Compression) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(HEADER + 8 * words.len());
    bytes.extend(MAGIC);
    bytes.extend(FORMAT.to_le_bytes());
    bytes.extend((compression as u64).to_le_bytes());
    bytes.extend((words.len() as u64).to_le_bytes());
    match compression {
        Compression::None => words.iter().for_each(|w| bytes.extend(w.to_le_bytes())),
        Compression::Zstd => {
            let raw: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
            bytes.extend(zstd::bulk::compress(&raw, LEVEL)?);
        }
    }
    Ok(bytes)
}

/// Returns the words of a file.
///
/// # Errors
/// The bytes are no complete file of this format; the message says why.
pub fn decode(bytes: &[u8]) -> Result<Vec<u64>, String> {
    let short = || "the file is too short".to_string();
    let (header, body) = bytes.split_at_checked(HEADER).ok_or_else(short)?;
    let number = |at: usize| u64::from_le_bytes(header[at..at + 8].try_into().expect("8 bytes"));
    if header[..4] != MAGIC {
        return Err("the file is not one of a checkpoint".into());
    }
    let format = u32::from_le_bytes(header[4..8].try_into().expect("4 bytes"));
    if format != FORMAT {
        return Err(format!("the file has format {format}; this program reads format {FORMAT}"));
    }
    let count = usize::try_from(number(16)).map_err(|_| short())?;
    let size = count.checked_mul(8).ok_or_else(short)?;
    let unpacked;
    let raw = match number(8) {
        0 => body,
        1 => {
            // The number of words is not known to be right: no memory is reserved for it.
            unpacked = zstd::decode_all(body).map_err(|e| format!("decompression failed: {e}"))?;
            &unpacked[..]
        }
        kind => return Err(format!("compression {kind} is unknown")),
    };
    if raw.len() != size {
        return Err(format!("the file has {} bytes of data instead of {size}", raw.len()));
    }
    let word = |w: &[u8]| u64::from_le_bytes(w.try_into().expect("8 bytes"));
    Ok(raw.chunks_exact(8).map(word).collect())
}

/// Bytes that are written at once, and bytes after which the disk must have them.
const PORTION: usize = 4 << 20;
const SYNC_EVERY: usize = 64 << 20;

/// Writes a file under its name in `folder`, and waits until the disk has it. Calls `progress`
/// after each portion.
///
/// # Errors
/// The file cannot be written.
pub fn write(
    folder: &Path,
    name: &str,
    words: &[u64],
    compression: Compression,
    progress: &dyn Fn(),
) -> io::Result<FileRecord> {
    let bytes = encode(words, compression)?;
    let mut file = File::create(folder.join(name))?;
    for part in bytes.chunks(SYNC_EVERY) {
        for portion in part.chunks(PORTION) {
            file.write_all(portion)?;
            progress();
        }
        file.sync_data()?;
        progress();
    }
    file.sync_all()?;
    let blake3 = blake3::hash(&bytes).to_hex().to_string();
    Ok(FileRecord { name: name.into(), bytes: bytes.len() as u64, blake3 })
}

/// Reads a file of the folder and checks its size and its sum.
///
/// # Errors
/// The file cannot be read or is not the one of the record; the message names it.
pub fn read(folder: &Path, record: &FileRecord) -> Result<Vec<u64>, String> {
    let path = folder.join(&record.name);
    let named = |why: String| format!("{}: {why}", path.display());
    decode(&checked(&path, record)?).map_err(named)
}

/// Checks size and sum of a file of the folder.
///
/// # Errors
/// As [`read`].
pub fn verify(folder: &Path, record: &FileRecord) -> Result<(), String> {
    checked(&folder.join(&record.name), record).map(|_| ())
}

fn checked(path: &Path, record: &FileRecord) -> Result<Vec<u8>, String> {
    let named = |why: String| format!("{}: {why}", path.display());
    let size = std::fs::metadata(path).map_err(|e| named(e.to_string()))?.len();
    if size != record.bytes {
        return Err(named(format!("it has {size} bytes instead of {}", record.bytes)));
    }
    let bytes = std::fs::read(path).map_err(|e| named(e.to_string()))?;
    if blake3::hash(&bytes).to_hex().as_str() != record.blake3 {
        return Err(named("its content has changed: the blake3 sum differs".into()));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORDS: [u64; 5] = [1, u64::MAX, 0, 1 << 63, 77];

    #[test]
    fn files_make_the_round_trip() {
        for kind in [Compression::None, Compression::Zstd] {
            for words in [&WORDS[..], &[]] {
                assert_eq!(decode(&encode(words, kind).unwrap()).unwrap(), words, "{kind:?}");
            }
            let dir = tempfile::tempdir().unwrap();
            let record = write(dir.path(), "a.bin", &WORDS, kind, &|| ()).unwrap();
            assert_eq!(read(dir.path(), &record).unwrap(), WORDS);
            verify(dir.path(), &record).unwrap();
        }
    }

    /// A change of any byte, and a cut at any place, is noticed by the sum or the size. The decoder
    /// without them may accept changed words, but never panics.
    #[test]
    fn no_changed_file_is_read() {
        let dir = tempfile::tempdir().unwrap();
        for kind in [Compression::None, Compression::Zstd] {
            let record = write(dir.path(), "a.bin", &WORDS, kind, &|| ()).unwrap();
            let path = dir.path().join("a.bin");
            let good = std::fs::read(&path).unwrap();
            for i in 0..good.len() {
                let mut bad = good.clone();
                bad[i] ^= 1 << (i % 8);
                std::fs::write(&path, &bad).unwrap();
                assert!(read(dir.path(), &record).unwrap_err().contains("blake3"), "byte {i}");
                let _ = decode(&bad);
                std::fs::write(&path, &good[..i]).unwrap();
                assert!(read(dir.path(), &record).unwrap_err().contains("bytes instead of"));
                assert!(decode(&good[..i]).is_err());
            }
            std::fs::remove_file(&path).unwrap();
            assert!(read(dir.path(), &record).unwrap_err().contains("a.bin"));
        }
    }
}
