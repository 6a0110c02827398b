//! What a worker records of its time for `crumple run --trace`: phases as spans, orders and
//! renewals as moments.

use serde::{Deserialize, Serialize};

/// Most events of one worker; what happens later is not recorded. A cycle has about a dozen: the
/// first 15,000 or so.
pub const MAX_EVENTS: usize = 200_000;

/// A stretch of time in one phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Span {
    /// Index into [`crate::report::PHASES`].
    pub phase: u8,
    /// Cycles done before it.
    pub cycle: u64,
    /// Begin, since the recording's origin [ns].
    pub start: u64,
    /// Duration [ns].
    pub duration: u64,
}

/// What an order asks for, in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// High redecomposition.
    High,
    /// Low redecomposition.
    Low,
    /// Stop.
    Stop,
}

/// What has happened at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Event {
    /// The order of this number has come from the master.
    Arrived(u64, Kind),
    /// All workers begin to carry out the order of this number.
    Begun(u64, Kind),
    /// Elements that have failed leave the contact surface, with a renewal of membership.
    Erosion,
}

/// A moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Moment {
    /// What has happened.
    pub event: Event,
    /// Cycles done before it.
    pub cycle: u64,
    /// When, since the recording's origin [ns].
    pub at: u64,
}

/// All that one worker has recorded.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recording {
    /// The origin of all times by the monotonic clock of the worker's machine [ns].
    pub origin: u64,
    /// The origins of any two workers are the same moment up to the larger of their two figures
    /// [ns].
    pub doubt: u64,
    /// Spans in the order of time; they do not overlap.
    pub spans: Vec<Span>,
    /// Moments in the order of time.
    pub moments: Vec<Moment>,
    /// Cycles done when [`MOST_EVENTS`] were reached.
    pub full: Option<u64>,
}
