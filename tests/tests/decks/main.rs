//! Keyword decks: formats and problems, models, joints, arbitrary bytes, runs.

mod bytes;
mod formats;
mod joints;
mod models;
mod runs;
