//! Elements and materials, the columns that store them and their nodes, the assembly of element
//! nodal forces, and step sizes. This crate knows no contact, constraints or ranks.
//!
//! - [`nodes`]: nodal columns; [`time`]: step sizes; [`work`]: work of impulses
//! - [`elements`], [`materials`]: formulations and laws; [`parameter`], [`registry`]: their keys,
//!   and tables of laws that can be extended
//! - [`blocks`], [`columns`]: elements of a part and their history; [`assembly`]: nodal sums
//! - [`particles`]: sums over the neighbours of particles

pub mod assembly;
// It measures its CPU time, for which a GPU has no clock.
#[cfg(not(target_arch = "nvptx64"))]
pub mod blocks;
pub mod columns;
pub mod elements;
pub mod materials;
pub mod nodes;
pub mod parameter;
pub mod particles;
pub mod piecewise_linear;
pub mod registry;
pub mod step_data;
pub mod testing;
pub mod time;
pub mod work;
