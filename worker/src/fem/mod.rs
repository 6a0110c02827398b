//! fem

pub mod assembly;
pub mod blocks;
pub mod columns;
pub mod elements;
pub mod materials;
