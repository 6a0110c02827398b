//! run

pub mod balance;
pub mod control;
pub mod decompose;
pub mod embedded;
pub mod launch;
pub mod progress;
pub mod say;
pub mod stop;
