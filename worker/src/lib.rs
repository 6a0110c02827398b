//! The engine of Crumple. It runs without MPI. Search and elements are serial and do not depend
//! on ranks.
//!
//! - [`step`]: the time step, start there; [`serve`]: one worker from the first order to the last
//!   report
//! - [`engine`]: owns all parts of a worker; [`nodes`]: nodal columns
//! - [`fem`]: elements, materials, blocks of elements, assembly
//! - [`contact`]: search, then enforcement
//! - [`checkpoint`]: state on disk, and back from there; `stateless`: types without any
//! - [`constraints`]: prescribed motion, rigid bodies, ties, rigid walls
//! - [`coupling`]: the constraints and the other workers, as contact sees them
//! - [`parallel`]: partition, ghosts, migration, the reduction of each step
//! - [`parameter`], [`registry`]: keys of laws; tables of laws that can be extended
//! - [`math`]: SIMD lanes, best-fit rigid motion
//! - [`loads`], [`curve`]: external forces and their factors over time; [`erosion`]: failed
//!   elements
//! - [`time`], [`energy`], [`histories`], [`output`], [`vtu`]: step sizes, ledger, records,
//!   files; [`timer`], [`trace`]: time by phase, time line of a worker

#[macro_use]
mod stateless;

pub mod checkpoint;
pub mod constraints;
pub mod contact;
pub mod coupling;
pub mod curve;
pub mod energy;
pub mod engine;
pub mod erosion;
pub mod fem;
pub mod histories;
pub mod loads;
pub mod math;
pub mod nodes;
pub mod output;
pub mod parallel;
pub mod parameter;
pub mod registry;
pub mod serve;
pub mod step;
#[cfg(test)]
mod testing;
pub mod time;
pub mod timer;
pub mod trace;
pub mod vtu;
