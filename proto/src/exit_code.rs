//! Exit codes of the program.

/// The run or the command is complete.
pub const COMPLETED: u8 = 0;
/// The run is complete, but its results do not meet a requirement of the job.
pub const UNMET: u8 = 1;
/// The input cannot be used, or a file cannot be written.
pub const BAD_INPUT: u8 = 2;
/// Numerical failure.
pub const FAILED: u8 = 3;
/// A worker was lost.
pub const WORKER_LOST: u8 = 4;
/// A signal stopped the run.
pub const STOPPED: u8 = 130;
