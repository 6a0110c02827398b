//! How messages travel between ranks: threads of one process, or MPI behind the feature `mpi`.
//!
//! A message is a sequence of 64-bit words, so that columns of numbers travel without being copied
//! twice. Messages of one sender and tag arrive in the order they were sent. Sending never waits
//! for the receiver.

mod collective;
#[cfg(feature = "mpi")]
pub mod mpi;
pub mod threads;

pub use collective::{MaxReduction, exchange_all, sum_all};
use std::time::Duration;

/// The partner of a message is gone: it panicked, was killed or left early.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("rank {rank} was lost")]
pub struct RankLost {
    /// The rank that does not answer.
    pub rank: usize,
}

/// What a message is for; messages of different kinds do not mix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Tag {
    /// Master to worker.
    Order = 1,
    /// Worker to master.
    Report,
    /// Corner forces of elements at shared nodes.
    Corners,
    /// State of exterior nodes.
    Exterior,
    /// Contact pairs of this step.
    Pairs,
    /// Contact forces of one sweep.
    Sweep,
    /// What acts on rigid bodies.
    Bodies,
    /// What acts on tied nodes, and how those move that carry them.
    Ties,
    /// What acts on walls that have a mass.
    Walls,
    /// Global maximum.
    Maximum,
    /// Set-up and migration.
    Renewal,
    /// Whether contact sweeps have settled, and what accelerates them.
    Settled,
}

/// Messages and words sent so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Messages sent.
    pub messages: u64,
    /// Bytes sent.
    pub bytes: u64,
}

/// A rank's end of the wires. Rank 0 is the master, ranks 1.. are workers.
pub trait Transport {
    /// This rank.
    fn rank(&self) -> usize;
    /// Number of ranks, master included.
    fn size(&self) -> usize;
    /// Sends words; returns before they have arrived.
    ///
    /// # Errors
    /// The receiver is gone.
    fn send(&mut self, to: usize, tag: Tag, words: &[u64]) -> Result<(), RankLost>;
    /// Takes the next message of this sender and tag, if it has arrived, into `words` (old content
    /// is dropped).
    ///
    /// # Errors
    /// The sender is gone and nothing is left of it.
    fn try_recv(&mut self, from: usize, tag: Tag, words: &mut Vec<u64>) -> Result<bool, RankLost>;
    /// Waits for the next message of this sender and tag.
    ///
    /// # Errors
    /// The sender is gone and nothing is left of it.
    fn recv(&mut self, from: usize, tag: Tag, words: &mut Vec<u64>) -> Result<(), RankLost>;
    /// CPU time that this rank burnt while waiting in [`Transport::recv`].
    fn wait_cpu(&self) -> Duration;
    /// What this rank has sent.
    fn traffic(&self) -> Traffic;
    /// Whether all ranks read the same monotonic clock.
    fn one_clock(&self) -> bool;
    /// Name for summaries.
    fn name(&self) -> &'static str;
}

/// The monotonic clock of this machine; all its processes read the same.
pub fn clock() -> Duration {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    Duration::new(t.tv_sec as u64, t.tv_nsec as u32)
}

/// CPU time of the calling thread so far.
pub fn thread_cpu() -> Duration {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(t.tv_sec as u64, t.tv_nsec as u32)
}
