//! Constraints on velocities: prescribed motion, rigid bodies, ties and rigid walls.

pub mod prescribed;
pub mod rigid;
pub mod ties;
pub mod walls;
