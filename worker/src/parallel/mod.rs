//! parallel

pub mod census;
pub mod ghosts;
pub mod migrate;
pub mod partition;
pub mod reduction;
