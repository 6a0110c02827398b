//! Mathematics of the engine that does not depend on nodes, elements or workers.
//!
//! - [`lanes`]: SIMD lanes; [`row`]: nodal vectors; [`vector_range`]: ranges of vectors
//! - [`rigid_motion`]: best-fit rigid motion
//! - [`threads`]: threads that share the loops of a worker
//! - [`stateless!`]: the check that a type has nothing that a checkpoint must contain

mod stateless;

pub mod lanes;
pub mod rigid_motion;
pub mod row;
pub mod threads;
pub mod vector_range;
