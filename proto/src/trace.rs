//! Trace of a worker for `crumple run --trace`: phases as spans, orders and renewals as
//! moments.

use serde::{Deserialize, Serialize};

/// Largest number of events of one worker; later ones are not recorded. A cycle has about a
/// dozen events, so the trace covers the first 15,000 cycles or so.
pub const MAX_EVENTS: usize = 200_000;

/// Interval of time in one phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Span {
    /// Index into [`crate::report::PHASES`].
    pub phase: u8,
    /// Cycles completed before the span.
    pub cycle: u64,
    /// Start, since the origin of the recording [ns].
    pub start: u64,
    /// Duration [ns].
    pub duration: u64,
}

/// Kind of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum OrderKind {
    /// Membership update (*high* redecomposition).
    High,
    /// Repartition (*low* redecomposition).
    Low,
    /// Checkpoint.
    Checkpoint,
    /// Picture for clients.
    View,
    /// Change of a setting, pause or continuation.
    Steering,
    /// End of the run.
    Stop,
}

/// Event at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Event {
    /// The order with this number has arrived from the master.
    Arrived(u64, OrderKind),
    /// All workers begin to execute the order with this number.
    Begun(u64, OrderKind),
    /// Failed elements leave the contact surface, with a membership update.
    Erosion,
    /// Numbers of interior, interface and exterior elements of this worker from now on.
    Classes([u64; 3]),
}

/// Event with its cycle and time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Moment {
    /// The event.
    pub event: Event,
    /// Cycles completed before the event.
    pub cycle: u64,
    /// Time since the origin of the recording [ns].
    pub at: u64,
}

/// Complete recording of one worker.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recording {
    /// Origin of all times, by the monotonic clock of the worker's machine [ns].
    pub origin: u64,
    /// Uncertainty of the origin [ns]. The origins of any two workers are the same moment up to
    /// the larger of their two uncertainties.
    pub doubt: u64,
    /// Spans in ascending time; they do not overlap.
    pub spans: Vec<Span>,
    /// Moments in ascending time.
    pub moments: Vec<Moment>,
    /// Cycles completed when [`MAX_EVENTS`] was reached.
    pub full: Option<u64>,
}
