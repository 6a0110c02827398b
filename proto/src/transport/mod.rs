//! Transport of messages between ranks: threads of one process, or MPI with the feature `mpi`.
//!
//! A message is a sequence of 64-bit words, so that columns of numbers are sent without a
//! second copy. Messages with the same sender and tag arrive in the order in which they were
//! sent. Sending never waits for the receiver.

mod collective;
mod mailbox;
#[cfg(feature = "mpi")]
pub mod mpi;
mod rest;
pub mod threads;
mod wait;

pub use collective::{
    MaxReduction, exchange_all, exchange_with, gather_all, max_among, messages_of_sum, sum_all,
    sum_among, traffic_of_gather,
};
pub use mailbox::{Mailbox, words_of};
use std::time::Duration;

/// The other rank of a message is gone: it panicked, was killed or exited early.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("rank {rank} was lost")]
pub struct RankLost {
    /// Rank that does not answer.
    pub rank: usize,
}

/// Kind of a message; messages of different kinds are received independently.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Tag {
    /// Messages from the master to a worker.
    Order = 1,
    /// Messages from a worker to the master.
    Report,
    /// Element nodal forces at shared nodes.
    Corners,
    /// States of ghost nodes.
    Exterior,
    /// Contact pairs of this step.
    Pairs,
    /// Contact forces of one sweep.
    Sweep,
    /// Forces and moments on rigid bodies.
    Bodies,
    /// Forces and moments on tied nodes, and velocities of their masters.
    Ties,
    /// Nodes that may touch walls with a mass.
    Walls,
    /// Global maximum.
    Maximum,
    /// Set-up and migration.
    Renewal,
    /// Convergence of contact sweeps, and sums for their acceleration.
    Settled,
    /// Volumes of elements at shared nodes.
    Volumes,
    /// Volumes of airbags.
    Airbags,
    /// Nodes that directions of springs follow.
    Followed,
}

/// Messages and bytes sent so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Messages sent.
    pub messages: u64,
    /// Bytes sent.
    pub bytes: u64,
}

/// Communication of one rank. Rank 0 is the master, ranks 1.. are workers.
pub trait Transport {
    /// Returns this rank.
    fn rank(&self) -> usize;
    /// Returns the number of ranks, master included.
    fn size(&self) -> usize;
    /// Sends words; returns before they have arrived.
    ///
    /// # Errors
    /// The receiver is gone.
    fn send(&mut self, to: usize, tag: Tag, words: &[u64]) -> Result<(), RankLost>;
    /// Receives the next message of this sender and tag into `words` (old content is dropped),
    /// if it has arrived. Returns true if a message was received.
    ///
    /// # Errors
    /// The sender is gone and none of its messages is left.
    fn try_recv(&mut self, from: usize, tag: Tag, words: &mut Vec<u64>) -> Result<bool, RankLost>;
    /// Waits for the next message of this sender and tag.
    ///
    /// # Errors
    /// The sender is gone and none of its messages is left.
    fn recv(&mut self, from: usize, tag: Tag, words: &mut Vec<u64>) -> Result<(), RankLost>;
    /// Returns the CPU time that this rank has used while it waited in [`Transport::recv`].
    fn wait_cpu(&self) -> Duration;
    /// Returns the messages and bytes that this rank has sent.
    fn traffic(&self) -> Traffic;
    /// Returns true if all ranks read the same monotonic clock.
    fn one_clock(&self) -> bool;
    /// Returns the name for summaries.
    fn name(&self) -> &'static str;
}

/// Returns the time of this machine's monotonic clock, the same for all its processes.
pub fn clock() -> Duration {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    Duration::new(t.tv_sec as u64, t.tv_nsec as u32)
}

/// Returns the CPU time of the calling thread so far.
pub fn thread_cpu() -> Duration {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(t.tv_sec as u64, t.tv_nsec as u32)
}
