//! Checkpoints: names of their files, and the reports of workers on them.
//!
//! A checkpoint is a folder. Every worker writes one file, its *piece*; the first worker also
//! writes the state that all workers have in common. The manifest of the master names every file
//! with its size and its blake3 sum, so that a truncated or changed file is never used.

#[cfg(not(target_arch = "nvptx64"))]
mod file;

#[cfg(not(target_arch = "nvptx64"))]
pub use file::{decode, encode, read, verify_size, write};

use serde::{Deserialize, Serialize};

/// Version of the format of manifests and files. It changes with every change of their content.
pub const FORMAT: u32 = 14;
/// Largest count in a checkpoint, such as a number of cycles. A larger one was not counted but is
/// wrong, and could overflow.
pub const MOST: u64 = 1 << 53;
/// Name of the file with the state that all workers have in common.
pub const COMMON: &str = "common.bin";

/// Mark in the name of a folder in which a checkpoint is being written.
pub const PARTIAL: &str = ".part";

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
    /// Number of earlier captures in the same cycle.
    pub repeat: u64,
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

/// Returns the name of the folder in which a checkpoint is written. When it is complete, it gets
/// the name of [`folder_name`]. `repeat` is the number of earlier captures in the same cycle: a run
/// that is paused or stopped may have several, and none writes into the files of another.
pub fn partial_name(cycle: u64, repeat: u64) -> String {
    format!("{}{PARTIAL}{repeat}", folder_name(cycle))
}
