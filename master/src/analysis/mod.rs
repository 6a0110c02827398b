//! Analysis of jobs and runs: studies, advice, cost, benchmarks, predicted scaling and the
//! measured stable step.

pub mod advise;
pub mod bench;
pub mod check;
pub mod cost;
pub mod scale;
pub mod spectrum;
pub mod study;
