//! constraints

pub mod prescribed;
pub mod rigid;
pub mod ties;
pub mod walls;
