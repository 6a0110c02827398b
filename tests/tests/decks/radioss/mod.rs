//! Radioss decks: a plate of two shells above a cube, to which tests add keywords.

mod broken;
mod bytes;
mod fates;
mod files;
mod inner_bodies;
mod laws;
mod meaning;
mod models;
mod runs;
mod type19;

use crumple::input::job::{Model, read};
use std::fs;
use std::path::Path;

/// Returns a card: `i5` is a whole number and `wX` a word in ten columns, `r0.5` a number in
/// twenty, `_` is ten blanks. The fields follow each other without gaps.
pub fn card(fields: &str) -> String {
    let mut text = String::new();
    for field in fields.split_whitespace() {
        let (kind, value) = field.split_at(1);
        text += &match kind {
            "i" | "w" => format!("{value:>10}"),
            "r" => format!("{value:>20}"),
            _ => " ".repeat(10),
        };
    }
    text.trim_end().to_string() + "\n"
}

/// Returns keywords with their cards: lines that begin with `/` or `=` are as they are (`=` for
/// titles), all others are cards.
pub fn deck(lines: &str) -> String {
    let line = |line: &str| match line.trim() {
        text if text.starts_with('/') || text.starts_with('#') => format!("{text}\n"),
        text if text.starts_with('=') => format!("{}\n", &text[1..]),
        text => card(text),
    };
    lines.lines().filter(|l| !l.trim().is_empty()).map(line).collect()
}

/// The run, units and mesh. Part 1: two shells at z = 12, part 2: a solid below; nodes 1 to 8 the
/// cube, 11 to 16 the plate. Units mm, ms, kg.
pub fn mesh() -> String {
    "/RUN/PLATE/1\n10.0\n/END/ENGINE\n".to_string()
        + &deck(
            "/BEGIN
            =plate
            i2022 i0
            rkg rmm rms
            rkg rmm rms
            /NODE
            i1 r0 r0 r0
            i2 r10 r0 r0
            i3 r10 r10 r0
            i4 r0 r10 r0
            i5 r0 r0 r10
            i6 r10 r0 r10
            i7 r10 r10 r10
            i8 r0 r10 r10
            i11 r0 r0 r12
            i12 r10 r0 r12
            i13 r20 r0 r12
            i14 r0 r10 r12
            i15 r10 r10 r12
            i16 r20 r10 r12
            /SHELL/1
            i1 i11 i12 i15 i14
            i2 i12 i13 i16 i15
            /BRICK/2
            i1 i1 i2 i3 i4 i5 i6 i7 i8
            /PART/1
            =plate
            i1 i1 i0
            /PART/2
            =cube
            i2 i1 i0",
        )
}

/// The properties of both parts.
pub fn properties() -> String {
    deck(
        "/PROP/SHELL/1
        =sheet
        i24 i0 i0 i0
        r0 r0 r0 r0 r0
        i3 i0 r1.0
        /PROP/SOLID/2
        =block
        i24",
    )
}

/// The material of both parts.
pub fn steel() -> String {
    deck(
        "/MAT/ELAST/1
        =steel
        r7.85e-6
        r207.0 r0.3",
    )
}

/// An initial velocity, so that the model moves.
pub fn moves() -> String {
    deck(
        "/GRNOD/PART/900
        =moving
        i1 i2
        /INIVEL/TRA/1
        =start
        r1.0 r0 r0 i900",
    )
}

/// Returns the whole base with further keywords.
pub fn with(lines: &str) -> String {
    mesh() + &properties() + &steel() + &moves() + &deck(lines)
}

/// Writes a deck and reads it.
pub fn reading(text: &str, sets: &[&str]) -> Result<Model, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate_0000.rad");
    fs::write(&path, format!("{text}/END\n")).unwrap();
    read_at(&path, sets)
}

/// Reads a deck or a job.
pub fn read_at(path: &Path, sets: &[&str]) -> Result<Model, String> {
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    read(path, &sets).map_err(|report| report.to_string())
}

/// Returns the model of a valid deck.
pub fn model(text: &str) -> Model {
    reading(text, &[]).unwrap_or_else(|report| panic!("{report}"))
}

/// Returns everything that is said of a model: its description and its warnings with their help.
pub fn said(model: &Model) -> String {
    let warnings = model.warnings.iter().map(|w| format!("{}: {}\n", w.message, w.help));
    crumple::input::check::describe(model) + &warnings.collect::<String>()
}
