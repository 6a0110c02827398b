//! Mathematics that does not depend on nodes, elements or workers.

pub mod lanes;
pub mod rigid_motion;
pub mod row;
pub mod vector_range;
