//! Writes LSDA, the format of LS-DYNA's time histories: named arrays in folders.
//!
//! Source: LSTC I/O Library file format (lsda-1.1). A file is a header and records; each record
//! begins with its length and a command. Arrays are data records, and a table at the end has their
//! names, types and offsets. Lengths and offsets have 8 bytes, in the byte order of this machine.

use std::io::{self, Write};

/// Header: its length, bytes of lengths, offsets, commands and types, byte order, IEEE numbers.
const HEADER: [u8; 8] = [8, 8, 8, 1, 1, cfg!(target_endian = "little") as u8, 0, 0];
/// Offset of the offset of the table of symbols, after the header, a length and a command.
const TABLE: usize = HEADER.len() + 9;

/// Commands of records.
#[derive(Clone, Copy)]
#[repr(u8)]
enum LsdaCommand {
    Folder = 2,
    Data = 3,
    Variable = 4,
    BeginTable = 5,
    EndTable = 6,
    TableOffset = 7,
}

/// Types of arrays that are written.
#[derive(Clone, Copy)]
#[repr(u8)]
enum LsdaType {
    /// Text, one byte per character.
    Text = 1,
    /// Integers of 64 bits.
    Integer = 4,
    /// Numbers of 64 bits.
    Real = 10,
}

/// An array in the table of symbols.
struct LsdaSymbol {
    folder: usize,
    name: String,
    kind: LsdaType,
    offset: u64,
    count: u64,
}

/// A file that is being written, in memory.
pub struct LsdaFile {
    bytes: Vec<u8>,
    folders: Vec<String>,
    symbols: Vec<LsdaSymbol>,
}

impl LsdaFile {
    /// Begins a file.
    pub fn new() -> Self {
        let mut file = Self { bytes: HEADER.to_vec(), folders: Vec::new(), symbols: Vec::new() };
        file.record(LsdaCommand::TableOffset, &0_u64.to_ne_bytes());
        file
    }

    /// Opens a folder for the arrays that follow; the path begins with `/`.
    pub fn open(&mut self, path: String) {
        self.record(LsdaCommand::Folder, path.as_bytes());
        self.folders.push(path);
    }

    /// Writes text, with blanks up to `width` bytes for each of the texts.
    pub fn add_text<'t>(
        &mut self,
        name: &str,
        texts: impl IntoIterator<Item = &'t str>,
        width: usize,
    ) {
        let mut bytes = Vec::new();
        for text in texts {
            // One byte per character: readers take them one by one.
            let plain = text.chars().map(|c| if c.is_ascii() { c as u8 } else { b'?' });
            bytes.extend(plain.chain(std::iter::repeat(b' ')).take(width));
        }
        self.array(name, LsdaType::Text, bytes.len(), &bytes);
    }

    /// Writes integers.
    pub fn add_integers(&mut self, name: &str, values: &[i64]) {
        self.array(name, LsdaType::Integer, values.len(), bytemuck::cast_slice(values));
    }

    /// Writes numbers.
    pub fn add_reals(&mut self, name: &str, values: &[f64]) {
        self.array(name, LsdaType::Real, values.len(), bytemuck::cast_slice(values));
    }

    /// Adds the table of symbols and writes the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(mut self, out: &mut dyn Write) -> io::Result<()> {
        let begin = self.bytes.len();
        self.record(LsdaCommand::BeginTable, &[]);
        let mut folder = None;
        for symbol in std::mem::take(&mut self.symbols) {
            if folder != Some(symbol.folder) {
                folder = Some(symbol.folder);
                let path = self.folders[symbol.folder].clone();
                self.record(LsdaCommand::Folder, path.as_bytes());
            }
            let mut entry = symbol.name.into_bytes();
            entry.push(symbol.kind as u8);
            entry.extend(symbol.offset.to_ne_bytes());
            entry.extend(symbol.count.to_ne_bytes());
            self.record(LsdaCommand::Variable, &entry);
        }
        self.record(LsdaCommand::EndTable, &0_u64.to_ne_bytes()); // there is no further part
        let length = (self.bytes.len() - begin) as u64;
        self.bytes[begin..begin + 8].copy_from_slice(&length.to_ne_bytes());
        self.bytes[TABLE..TABLE + 8].copy_from_slice(&(begin as u64).to_ne_bytes());
        out.write_all(&self.bytes)
    }

    fn array(&mut self, name: &str, kind: LsdaType, count: usize, data: &[u8]) {
        let offset = self.bytes.len() as u64;
        let head = [kind as u8, name.len() as u8];
        let content: Vec<u8> =
            head.into_iter().chain(name.bytes()).chain(data.iter().copied()).collect();
        self.record(LsdaCommand::Data, &content);
        let folder = self.folders.len().saturating_sub(1);
        let count = count as u64;
        self.symbols.push(LsdaSymbol { folder, name: name.into(), kind, offset, count });
    }

    fn record(&mut self, command: LsdaCommand, content: &[u8]) {
        let length = (8 + 1 + content.len()) as u64;
        self.bytes.extend(length.to_ne_bytes());
        self.bytes.push(command as u8);
        self.bytes.extend(content);
    }
}
