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
use super::table::Effect;
use super::text::Texts;
use crate::input::mesh_file::{Fate, ImportRow};

/// Time up to which functions get points, over the end of the run.
pub const BEYOND: f64 = 1e3;

/// Text above the table.
const HEAD: &str = include_str!("reference_head.md");

/// Returns the keywords of a deck in the order of their first blocks: number of blocks and fate.
pub fn fates(texts: &Texts) -> Vec<ImportRow> {
    let mut rows: Vec<ImportRow> = Vec::new();
    for block in &texts.blocks {
        let (what, fate, became) = match keywords::find(&block.name).map(|row| row.keyword) {
            Some(known) => {
                let fate = match known.effect {
                    Effect::Model => Fate::Read,
                    Effect::Harmless => Fate::Ignored,
                    Effect::NotYet => Fate::LeftOut,
                };
                (known.name, fate, known.note)
            }
            None => (block.name.as_str(), Fate::LeftOut, "not supported"),
        };
        match rows.iter_mut().find(|row| row.what == what) {
            Some(row) => row.count += 1,
            None => {
                rows.push(ImportRow { what: what.into(), count: 1, fate, became: became.into() });
            }
        }
    }
    rows
}

/// Returns the page of keywords, `cases/RADIOSS.md`.
pub fn page() -> String {
    let families: Families = keywords::FAMILIES;
    let mut page = String::from(HEAD);
    // Writing to a string cannot fail.
    let _ = tables(&mut page, families);
    page + "\nEvery other keyword is an error that names its line; `--allow-unsupported` ignores \
            it with a\nwarning.\n"
}
