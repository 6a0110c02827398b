//! Keyword decks: formats and problems, models, contacts, joints, arbitrary bytes, runs.

mod base;
mod bytes;
mod contacts;
mod formats;
mod joints;
mod models;
mod runs;
