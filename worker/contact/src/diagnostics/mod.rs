//! Checks and records of contact. They do not change the state: the run is the same without them.

pub mod crossing;
pub mod initial_penetration;
pub mod search_record;
