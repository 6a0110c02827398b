//! input

pub mod check;
pub mod deck;
pub mod job;
pub mod reference;
