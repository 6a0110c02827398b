//! The engine of Crumple. It runs without MPI. Search and elements are serial and do not depend
//! on ranks.
//!
//! - [`step`]: the time step, start there; [`serve`]: one worker from the first order to the last
//!   report
//! - [`engine`]: owns all parts of a worker; [`nodes`]: nodal columns; [`work`]: work of impulses
//! - [`fem`]: elements, materials, blocks of elements, assembly
//! - [`contact`]: search, then enforcement
//! - [`checkpoint`]: state on disk, and back from there; `stateless`: types without any
//! - [`constraints`]: prescribed motion, rigid bodies, ties, rigid walls
//! - [`coupling`]: the constraints and the other workers, as contact sees them
//! - [`parallel`]: partition, ghosts, migration, the reduction of each step
//! - [`parameter`], [`registry`]: keys of laws; tables of laws that can be extended
//! - [`math`]: SIMD lanes, best-fit rigid motion
//! - [`adaptivity`]: division of shells that bend
//! - [`loads`], [`airbags`], [`curve`]: external forces, airbags, factors over time; [`erosion`]:
//!   failed elements
//! - [`time`], [`energy`], [`histories`], [`output`], [`vtu`]: step sizes, ledger, records,
//!   files; [`timer`], [`trace`]: time by phase, time line of a worker

pub mod adaptivity;
pub mod airbags;
pub mod blast;
pub mod checkpoint;
pub mod constraints;
pub mod coupling;
pub mod curve;
pub mod energy;
pub mod engine;
pub mod erosion;
pub mod histories;
pub mod loads;
pub mod output;
pub mod parallel;
pub mod serve;
pub mod step;
pub mod timer;
pub mod trace;
pub mod vtu;

pub use crumple_contact as contact;
pub use crumple_fem as fem;
pub use crumple_fem::{nodes, parameter, piecewise_linear, registry, step_data, time, work};
pub use crumple_math as math;
use crumple_math::stateless;
