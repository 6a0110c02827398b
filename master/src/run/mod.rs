//! The run on the master: start, control, balance, decomposition, progress and stop.

pub mod balance;
pub mod checkpoint;
pub mod control;
pub mod decompose;
pub mod embedded;
pub mod launch;
pub mod lock;
pub mod progress;
pub mod stop;
pub mod supervise;
