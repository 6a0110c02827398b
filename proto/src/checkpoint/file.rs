//! Files of a checkpoint: the magic bytes and the format version, the kind of compression, the
//! number of words, and the words, little-endian.

use super::{FORMAT, FileRecord};
use crate::disk::{WatchedFile, watched};
use crate::job::Compression;
use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

/// First bytes of a file.
const MAGIC: [u8; 4] = *b"CRCK";
/// Bytes of the header: magic bytes, version, compression, number of words.
const HEADER: usize = 4 + 4 + 8 + 8;
/// Level of compression: the fastest one.
const LEVEL: i32 = 1;

/// Returns the bytes of a file with these words.
///
/// # Errors
/// The compressor reports an error.
pub fn encode(words: &[u64], compression: Compression) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(HEADER + 8 * words.len());
    stream(&mut bytes, &[words], compression)?;
    Ok(bytes)
}

/// Writes the bytes of a file with these words, which come in several pieces.
fn stream(out: &mut impl Write, words: &[&[u64]], compression: Compression) -> io::Result<()> {
    let count: usize = words.iter().map(|piece| piece.len()).sum();
    out.write_all(&MAGIC)?;
    out.write_all(&FORMAT.to_le_bytes())?;
    out.write_all(&(compression as u64).to_le_bytes())?;
    out.write_all(&(count as u64).to_le_bytes())?;
    match compression {
        Compression::None => stream_words(out, words),
        Compression::Zstd => {
            let mut encoder = zstd::Encoder::new(out, LEVEL)?;
            stream_words(&mut encoder, words)?;
            encoder.finish().map(|_| ())
        }
    }
}

/// Writes words as bytes, in portions.
fn stream_words(out: &mut impl Write, words: &[&[u64]]) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(PORTION);
    for portion in words.iter().flat_map(|piece| piece.chunks(PORTION / 8)) {
        bytes.clear();
        portion.iter().for_each(|w| bytes.extend(w.to_le_bytes()));
        out.write_all(&bytes)?;
    }
    Ok(())
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

/// Bytes that are written or read at once, and bytes after which the disk must have them.
const PORTION: usize = 4 << 20;
const SYNC_EVERY: usize = 64 << 20;

/// A file that is being written, with the sum of its bytes so far.
struct Summed<'a> {
    file: File,
    sum: blake3::Hasher,
    bytes: u64,
    /// Bytes that the disk may not have.
    unsure: usize,
    progress: &'a dyn Fn(),
}

impl Write for Summed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(&bytes[..bytes.len().min(PORTION)])?;
        self.sum.update(&bytes[..written]);
        self.bytes += written as u64;
        self.unsure += written;
        (self.progress)();
        if self.unsure >= SYNC_EVERY {
            self.flush()?;
        }
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.sync_data()?;
        self.unsure = 0;
        (self.progress)();
        Ok(())
    }
}

/// Writes a file under its name in `folder`, and waits until the disk has it. Its words come in
/// several pieces; beyond them the memory of a portion is used. Calls `progress` after each
/// portion.
///
/// # Errors
/// The file cannot be written.
pub fn write(
    folder: &Path,
    name: &str,
    words: &[&[u64]],
    compression: Compression,
    progress: &dyn Fn(),
) -> io::Result<FileRecord> {
    let file = File::create(folder.join(name))?;
    let sum = blake3::Hasher::new();
    let mut out = Summed { file, sum, bytes: 0, unsure: 0, progress };
    // The compressor writes small portions.
    let mut buffered = BufWriter::with_capacity(PORTION, &mut out);
    stream(&mut buffered, words, compression)?;
    buffered.into_inner().map_err(io::IntoInnerError::into_error)?;
    out.file.sync_all()?;
    let blake3 = out.sum.finalize().to_hex().to_string();
    Ok(FileRecord { name: name.into(), bytes: out.bytes, blake3 })
}

/// Reads a file of the folder and checks its size and its sum.
///
/// # Errors
/// The file cannot be read or is not the one of the record; the message names it.
pub fn read(folder: &Path, record: &FileRecord) -> Result<Vec<u64>, String> {
    let path = folder.join(&record.name);
    let named = |why: String| format!("{}: {why}", path.display());
    decode(&checked(folder, record)?).map_err(named)
}

/// Checks the size of a file of the folder.
///
/// # Errors
/// It does not exist or has another size; the message names it.
pub fn verify_size(folder: &Path, record: &FileRecord) -> Result<(), String> {
    let path = folder.join(&record.name);
    let named = |why: String| format!("{}: {why}", path.display());
    let size = std::fs::metadata(&path).map_err(|e| named(e.to_string()))?.len();
    if size == record.bytes {
        return Ok(());
    }
    Err(named(format!("it has {size} bytes instead of {}", record.bytes)))
}

fn checked(folder: &Path, record: &FileRecord) -> Result<Vec<u8>, String> {
    let path = folder.join(&record.name);
    let named = |why: String| format!("{}: {why}", path.display());
    watched(&path, || verify_size(folder, record))?;
    let size = usize::try_from(record.bytes).map_err(|e| named(e.to_string()))?;
    let mut bytes = vec![0; size];
    let mut sum = blake3::Hasher::new();
    let mut file =
        WatchedFile::open(&path, |path| File::open(path)).map_err(|e| named(e.to_string()))?;
    for portion in bytes.chunks_mut(PORTION) {
        file.read_exact(portion).map_err(|e| named(e.to_string()))?;
        sum.update(portion);
    }
    if sum.finalize().to_hex().as_str() != record.blake3 {
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
            let record =
                write(dir.path(), "a.bin", &[&WORDS[..2], &WORDS[2..]], kind, &|| ()).unwrap();
            assert_eq!(read(dir.path(), &record).unwrap(), WORDS);
        }
    }

    /// A change of any byte, and a cut at any place, is noticed by the sum or the size. The decoder
    /// without them may accept changed words, but never panics.
    #[test]
    fn no_changed_file_is_read() {
        let dir = tempfile::tempdir().unwrap();
        for kind in [Compression::None, Compression::Zstd] {
            let record =
                write(dir.path(), "a.bin", &[&WORDS[..2], &WORDS[2..]], kind, &|| ()).unwrap();
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
