//! analysis

pub mod advise;
pub mod bench;
pub mod cost;
pub mod pieces;
pub mod scale;
pub mod spectrum;
pub mod study;
