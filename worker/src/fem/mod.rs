//! Elements and materials, the columns they are stored in, and the assembly of their forces at
//! nodes.

pub mod assembly;
pub mod blocks;
pub mod columns;
pub mod elements;
pub mod materials;
