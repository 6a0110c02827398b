//! Archives of submissions: zip, tar and tar.gz. An entry obeys the rules of an uploaded file;
//! links and devices are refused. What an archive states of itself is not believed: bytes are
//! counted as they are written.

use super::intake::{Intake, IntakeFault, Taken};
use flate2::read::MultiGzDecoder;
use std::cell::Cell;
use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::rc::Rc;
use std::time::Instant;
use tar::EntryType;
use tokio_util::sync::CancellationToken;
use zip::ZipArchive;
use zip::result::ZipError;

/// Most entries of an archive, with folders.
const MOST_ENTRIES: usize = 4000;
/// Largest headers of an entry of tar [byte]: long names are such headers.
const LARGEST_HEADERS: u64 = 64 * 1024;
/// Largest directory of a zip file [byte].
const LARGEST_DIRECTORY: u64 = 8 << 20;
/// Most bytes after the last entry of tar.
const MOST_PADDING: u64 = 1 << 20;
/// Size of the pieces in which bytes are written.
const PIECE: usize = 64 * 1024;
/// Bits of the mode of a file that are its type, and the types of files and folders.
const TYPE_BITS: u32 = 0o170_000;
const TYPE_FILE: u32 = 0o100_000;
const TYPE_FOLDER: u32 = 0o040_000;
const TYPE_LINK: u32 = 0o120_000;

/// Format of an archive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArchiveFormat {
    /// With a directory at its end.
    Zip,
    /// A plain stream.
    Tar,
    /// A stream compressed by gzip.
    TarGz,
}

impl ArchiveFormat {
    /// Returns the format that the end of a file name stands for.
    pub fn of_name(name: &str) -> Option<Self> {
        let name = name.to_ascii_lowercase();
        let ends = |ends: &[&str]| ends.iter().any(|end| name.ends_with(end));
        match () {
            () if ends(&[".zip"]) => Some(Self::Zip),
            () if ends(&[".tar"]) => Some(Self::Tar),
            () if ends(&[".tar.gz", ".tgz"]) => Some(Self::TarGz),
            () => None,
        }
    }
}

/// Limits while an archive is unpacked.
pub struct ArchiveLimits {
    /// Most bytes of all files.
    pub most_bytes: u64,
    /// When it has to be complete.
    pub until: Instant,
    /// Cancelled if the client has left.
    pub gone: CancellationToken,
}

/// Unpacks an archive. Files that were made before an error stay.
///
/// # Errors
/// The archive or an entry is refused, a limit is exceeded, or a file cannot be written.
pub fn unpack(
    archive: &Path,
    format: ArchiveFormat,
    intake: &mut Intake,
    limits: &ArchiveLimits,
) -> Taken<()> {
    let file = File::open(archive).map_err(IntakeFault::Failed)?;
    let before = intake.files().len();
    let mut sink = Sink { intake, limits, bytes: 0, entries: 0 };
    match format {
        ArchiveFormat::Zip => unpack_zip(file, &mut sink)?,
        ArchiveFormat::Tar => unpack_tar(BufReader::new(file), &mut sink)?,
        ArchiveFormat::TarGz => {
            unpack_tar(BufReader::new(MultiGzDecoder::new(BufReader::new(file))), &mut sink)?;
        }
    }
    match intake.files().len() > before {
        true => Ok(()),
        false => Err(IntakeFault::Refused("the archive has no files".into())),
    }
}

fn refused(name: &str, rule: impl std::fmt::Display) -> IntakeFault {
    IntakeFault::Refused(format!("the entry `{}` of the archive is refused: {rule}", shown(name)))
}

fn shown(name: &str) -> String {
    name.chars().take(80).filter(|c| !c.is_control()).collect()
}

fn broken(error: impl std::fmt::Display) -> IntakeFault {
    let why: String = error.to_string().chars().take(200).filter(|c| !c.is_control()).collect();
    IntakeFault::Refused(format!("the archive cannot be read: {why}"))
}

/// Returns the name of an entry. A leading `./` has no meaning; of `.` itself nothing is left.
fn name_of(bytes: &[u8]) -> Taken<&str> {
    let name = std::str::from_utf8(bytes)
        .map_err(|_| refused(&String::from_utf8_lossy(bytes), "its name is not UTF-8"))?;
    Ok(name.strip_prefix("./").unwrap_or(name))
}

/// Where entries go.
struct Sink<'a> {
    intake: &'a mut Intake,
    limits: &'a ArchiveLimits,
    bytes: u64,
    entries: usize,
}

impl Sink<'_> {
    fn count(&mut self) -> Taken<()> {
        self.entries += 1;
        match self.entries <= MOST_ENTRIES {
            true => Ok(()),
            false => {
                Err(IntakeFault::TooMuch(format!("an archive has at most {MOST_ENTRIES} entries")))
            }
        }
    }

    fn too_large(&self, name: &str) -> IntakeFault {
        let most = self.limits.most_bytes as f64 / 1e6;
        let name = shown(name);
        IntakeFault::TooMuch(format!(
            "the files of the archive have more than {most} MB, with `{name}`"
        ))
    }

    fn folder(&mut self, name: &str) -> Taken<()> {
        match name.trim_end_matches('/') {
            "" if name.is_empty() => Ok(()),
            name => self.intake.folder(name),
        }
    }

    /// Writes a file whose archive states its size.
    fn file(&mut self, name: &str, stated: u64, from: &mut impl Read) -> Taken<()> {
        if stated > self.limits.most_bytes.saturating_sub(self.bytes) {
            return Err(self.too_large(name));
        }
        let mut file = self.intake.create(name)?;
        let mut piece = [0; PIECE];
        let mut size = 0;
        loop {
            if self.limits.gone.is_cancelled() || Instant::now() > self.limits.until {
                return Err(IntakeFault::Late("unpacking the archive takes too long".into()));
            }
            let read = match from.read(&mut piece) {
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                read => read.map_err(|error| refused(name, error))?,
            };
            if read == 0 {
                break;
            }
            size += read as u64;
            self.bytes += read as u64;
            if self.bytes > self.limits.most_bytes {
                return Err(self.too_large(name));
            }
            file.write_all(&piece[..read]).map_err(IntakeFault::Failed)?;
        }
        match size == stated {
            true => Ok(()),
            false => {
                Err(refused(name, format!("it has {size} bytes; the archive states {stated}")))
            }
        }
    }
}

/// Bytes that may be read before the next allowance: headers that are read to memory are bounded.
#[derive(Clone, Default)]
struct Meter {
    left: Rc<Cell<u64>>,
    has_ended: Rc<Cell<bool>>,
}

struct Metered<R> {
    inner: R,
    meter: Meter,
}

impl<R: Read> Read for Metered<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let left = self.meter.left.get();
        if left == 0 && !into.is_empty() {
            return Err(io::Error::other("its headers or its padding are too long"));
        }
        let most = usize::try_from(left).unwrap_or(usize::MAX).min(into.len());
        let read = self.inner.read(&mut into[..most])?;
        self.meter.left.set(left - read as u64);
        self.meter.has_ended.set(self.meter.has_ended.get() || (read == 0 && most > 0));
        Ok(read)
    }
}

impl<R: Seek> Seek for Metered<R> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.inner.seek(to)
    }
}

fn unpack_tar(reader: impl Read, sink: &mut Sink) -> Taken<()> {
    let meter = Meter::default();
    let mut archive = tar::Archive::new(Metered { inner: reader, meter: meter.clone() });
    let mut entries = archive.entries().map_err(broken)?;
    loop {
        meter.left.set(LARGEST_HEADERS);
        let Some(entry) = entries.next() else { break };
        let mut entry = entry.map_err(broken)?;
        sink.count()?;
        let bytes = entry.path_bytes().into_owned();
        let name = name_of(&bytes)?;
        let rule = match entry.header().entry_type() {
            EntryType::Regular if is_sparse(&mut entry)? => "it is a sparse file",
            EntryType::Regular => {
                meter.left.set(u64::MAX);
                sink.file(name, entry.size(), &mut entry)?;
                continue;
            }
            EntryType::Directory => {
                sink.folder(name)?;
                continue;
            }
            // A comment of the whole archive, such as that of `git archive`.
            EntryType::XGlobalHeader => continue,
            EntryType::Symlink => "it is a symbolic link",
            EntryType::Link => "it is a hard link",
            EntryType::Char | EntryType::Block => "it is a device",
            EntryType::Fifo => "it is a pipe",
            _ => "it is neither a file nor a folder",
        };
        return Err(refused(name, rule));
    }
    if meter.has_ended.get() {
        return Err(IntakeFault::Refused("the archive is cut off: it has no end mark".into()));
    }
    // The check sum of gzip comes last.
    meter.left.set(MOST_PADDING);
    io::copy(&mut archive.into_inner(), &mut io::sink()).map(drop).map_err(broken)
}

/// Returns true if the body of an entry is not the content of its file.
fn is_sparse(entry: &mut tar::Entry<impl Read>) -> Taken<bool> {
    let Some(extensions) = entry.pax_extensions().map_err(broken)? else { return Ok(false) };
    let mut keys = extensions.filter_map(Result::ok).map(|pair| pair.key_bytes().to_vec());
    Ok(keys.any(|key| key.starts_with(b"GNU.sparse")))
}

fn unpack_zip(file: File, sink: &mut Sink) -> Taken<()> {
    let meter = Meter::default();
    meter.left.set(LARGEST_DIRECTORY);
    let metered = Metered { inner: file, meter: meter.clone() };
    let mut archive = ZipArchive::new(metered).map_err(broken)?;
    if archive.has_duplicate_names() {
        return Err(IntakeFault::Refused("two entries of the archive have the same name".into()));
    }
    // Headers before the entries may not contradict the directory: other readers believe those.
    meter.left.set(u64::MAX);
    archive.validate_header_consistency().map_err(broken)?;
    for index in 0..archive.len() {
        sink.count()?;
        let about = archive.by_index_data(index).map_err(broken)?;
        let name = name_of(about.name_raw())?.to_string();
        let kind = about.unix_mode().unwrap_or(0) & TYPE_BITS;
        let rule = match kind {
            _ if about.encrypted() => "it is encrypted",
            TYPE_LINK => "it is a symbolic link",
            0 | TYPE_FILE | TYPE_FOLDER if about.is_dir() => {
                sink.folder(&name)?;
                continue;
            }
            0 | TYPE_FILE => "",
            _ => "it is neither a file nor a folder",
        };
        if !rule.is_empty() {
            return Err(refused(&name, rule));
        }
        let stated = about.size();
        let mut entry = archive.by_index(index).map_err(|error| match error {
            ZipError::UnsupportedArchive(why) => refused(&name, why),
            error => refused(&name, error),
        })?;
        sink.file(&name, stated, &mut entry)?;
    }
    Ok(())
}
