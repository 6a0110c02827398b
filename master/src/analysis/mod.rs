//! Analysis of jobs and runs: studies, advice, comparison and repetition of runs, cost, benchmarks,
//! predicted scaling and the measured stable step.

pub mod advise;
pub mod bench;
pub mod check;
pub mod cost;
pub mod diff;
pub mod reproduce;
pub mod scale;
pub mod spectrum;
pub mod study;
