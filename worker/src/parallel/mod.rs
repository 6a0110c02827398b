//! The parallel run as a worker sees it: its partition, ghosts of other workers' nodes and
//! elements, migration, the exchange of contact pairs, and the reduction of each step.

pub mod boxes;
pub mod contact_decomposition;
pub mod convergence;
pub mod decomposition;
pub mod followed;
pub mod ghost_segments;
pub mod ghosts;
pub mod history_message;
pub mod migrate;
pub mod pair_exchange;
pub mod particles;
pub mod partition;
pub mod reduction;
pub mod replicated_pairs;
pub mod surface_update;
pub mod volumes;
