//! Elements and materials, the columns that store them, and the assembly of element nodal forces.

pub mod assembly;
pub mod blocks;
pub mod columns;
pub mod elements;
pub mod materials;
