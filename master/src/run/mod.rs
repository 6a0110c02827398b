//! The run on the master: start, control, balance, decomposition, progress and stop.

pub mod attach;
pub mod attempt;
pub mod balance;
pub mod checkpoint;
pub mod control;
pub mod decompose;
pub mod embedded;
pub mod in_process;
pub mod launch;
pub mod lock;
pub mod log;
pub mod progress;
pub mod request;
pub mod service;
pub mod supervise;
