//! Runs with MPI, and decisions by measured load. They are a binary of their own, because cargo
//! runs one binary after the other: ranks that wait for each other on cores that other tests use
//! take ten times as long.

mod processes;
mod redecomposition;
mod steering;
mod supervisor;
mod torture;
