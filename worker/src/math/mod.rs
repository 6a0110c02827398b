//! math

pub mod lanes;
pub mod rigid_motion;
