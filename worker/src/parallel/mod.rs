//! The parallel run as a worker sees it: its partition, ghosts of other workers' nodes and
//! elements, migration, and the reduction of each step.

pub mod ghosts;
pub mod migrate;
pub mod partition;
pub mod reduction;
