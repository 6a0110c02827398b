//! Radioss decks: a starter file `NAME_0000.rad` and its engine file `NAME_0001.rad`.
//!
//! 1. `text.rs`: files, `#include`, blocks of lines
//! 2. `keywords`: the table of keywords; cards are read as those of LS-DYNA, by
//!    `deck/record.rs`
//! 3. `deck/convert/radioss`: a job's tree of values, and a mesh
//! 4. `export`: the reverse conversion

pub mod export;
pub mod keywords;
pub mod text;

use super::reference::{Families, tables};

/// Time up to which functions get points, over the end of the run.
pub const BEYOND: f64 = 1e3;

/// Text above the table.
const HEAD: &str = include_str!("reference_head.md");

/// Returns the page of keywords, `cases/RADIOSS.md`.
pub fn page() -> String {
    let families: Families = keywords::FAMILIES;
    let mut page = String::from(HEAD);
    // Writing to a string cannot fail.
    let _ = tables(&mut page, families);
    page + "\nEvery other keyword is an error that names its line; `--allow-unsupported` ignores \
            it with a\nwarning.\n"
}
