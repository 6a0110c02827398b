//! Requests to a run in progress and its answers: a line of JSON each.
//!
//! `{"request": "status"}` and in its place `watch`, `view`, `checkpoint`, `pause`, `continue` or
//! `stop`; `{"request": "set", "key": "end_time", "value": 5.0}`. The answer to an order comes when
//! the order has taken effect. After `watch`, lines of the stream follow: `progress`, `event`, and
//! `ended` as the last.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Request of a client.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "request", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// The present state.
    Status,
    /// The present state, and the live stream.
    Watch,
    /// The present state as a picture, in files that belong to no result.
    View,
    /// A checkpoint. The answer comes when it is complete.
    Checkpoint,
    /// The workers hold their state and wait.
    Pause,
    /// A paused run goes on.
    Continue,
    /// End of the run, as by SIGTERM.
    Stop,
    /// Change of a setting.
    Set {
        /// Key, as in the job.
        key: String,
        /// New value, in the units of the job.
        value: f64,
    },
}

/// Answer, or line of the stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "answer", rename_all = "snake_case")]
pub enum Answer {
    /// The present state.
    Status(Box<Status>),
    /// The order has taken effect.
    Done(Done),
    /// The picture is in files.
    View(Box<View>),
    /// The request is refused.
    Refused {
        /// Reason, and what is allowed.
        why: String,
    },
    /// Progress, several times a second.
    Progress(Progress),
    /// Message that the run prints: redecompositions, warnings, checkpoints, orders.
    Event {
        /// Text.
        text: String,
    },
    /// The run has ended. The last line.
    Ended {
        /// Exit code of the run, see `docs/reference/exit-codes.md`.
        code: u8,
        /// Reason.
        reason: String,
    },
}

/// Where an order has taken effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// The order, as in `summary.json`.
    pub order: String,
    /// Cycles completed.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Further information, such as the folder of a checkpoint.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

/// A picture in files: fields of the elements of each worker, `piece_000.vtu` and so on. They stay
/// until the picture after the next one, at least a quarter of a second, and are removed at the end
/// of the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// Cycles completed.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Folder of the pieces, in the folder of the run.
    pub folder: String,
    /// Number of pieces: workers.
    pub pieces: usize,
    /// `units`, `parts` (`id`, `name`) and `walls`, as in `summary.json`.
    pub about: serde_json::Map<String, serde_json::Value>,
    /// Lower and upper corner of the box of each worker [length]; null is infinite.
    pub boxes: Vec<[[Option<f64>; 3]; 2]>,
}

/// State of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Title of the job.
    pub title: String,
    /// `running`, `paused` or `stopping`.
    pub state: String,
    /// Process id of the master.
    pub pid: u32,
    /// Number of workers.
    pub workers: usize,
    /// `threads` or `mpi`.
    pub transport: String,
    /// Keys that may change, with their present values.
    pub settings: BTreeMap<String, f64>,
    /// Cycle and time of the newest complete checkpoint.
    pub checkpoint: Option<(u64, f64)>,
    /// Progress.
    pub progress: Progress,
}

/// Progress of a run, from the last reports of its workers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Cycles completed.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Step size [time].
    pub dt: f64,
    /// Wall time of the run so far [s].
    pub wall_s: f64,
    /// Energies of the last history row [energy].
    pub energy: Energy,
    /// Active contact pairs.
    pub pairs: u64,
    /// Critical path over the mean CPU time of the workers, in the whole run.
    pub imbalance: f64,
    /// Redecompositions so far: *low*, *high*.
    pub redecompositions: [u64; 2],
    /// Where the master orders them.
    pub thresholds: Thresholds,
    /// Workers.
    pub workers: Vec<Worker>,
}

/// Thresholds of redecompositions, as in `summary.json`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// Share of the margin, for a *high* one.
    pub margin: f64,
    /// Imbalance, for a *low* one.
    pub imbalance: f64,
}

/// Energies [energy].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Internal energy.
    pub internal: f64,
    /// Hourglass and drilling energy.
    pub hourglass: f64,
    /// Work of contact.
    pub contact: f64,
    /// Work of external loads.
    pub external: f64,
    /// Energy error as a fraction.
    pub error: f64,
}

/// Motion and load of a worker in its last report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Worker {
    /// Largest accumulated displacement since the last redecomposition [length].
    pub displacement: f64,
    /// Motion that the ghosts allow [length].
    pub margin: f64,
    /// Their ratio.
    pub share: f64,
    /// CPU time per cycle [s].
    pub load: f64,
    /// Own elements.
    pub elements: u64,
    /// Active contact pairs.
    pub pairs: u64,
}

impl Request {
    /// Reads a request.
    ///
    /// # Errors
    /// The line is none; the message shows what requests look like.
    pub fn from_line(line: &str) -> Result<Self, String> {
        serde_json::from_str(line).map_err(|error| {
            format!(
                "no request: {error}; give {{\"request\": \"status\"}}, or watch, view, \
                 checkpoint, pause, continue, stop, or {{\"request\": \"set\", \
                 \"key\": \"end_time\", \"value\": 5.0}}"
            )
        })
    }

    /// Returns the request as a line.
    pub fn to_line(&self) -> String {
        serde_json::to_string(self).expect("plain data is always JSON") + "\n"
    }
}

impl Answer {
    /// Returns a refusal.
    pub fn refused(why: impl Into<String>) -> Self {
        Self::Refused { why: why.into() }
    }

    /// Returns the answer as a line.
    pub fn to_line(&self) -> String {
        serde_json::to_string(self).expect("plain data is always JSON") + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_as_they_are_written() {
        for request in [
            Request::Status,
            Request::Continue,
            Request::Set { key: "end_time".into(), value: 0.1 + 0.2 },
        ] {
            assert_eq!(Request::from_line(request.to_line().trim()), Ok(request));
        }
        let progress = Progress { workers: vec![Worker::default(); 2], ..Progress::default() };
        let done = Done { order: "stop".into(), cycle: 7, time: 0.1 + 0.2, note: String::new() };
        for answer in [Answer::Progress(progress), Answer::Done(done), Answer::refused("no")] {
            let line = answer.to_line();
            assert_eq!(line.matches('\n').count(), 1);
            assert_eq!(serde_json::from_str::<Answer>(&line).unwrap(), answer);
        }
    }

    #[test]
    fn other_lines_are_refused_with_what_is_allowed() {
        for line in ["", "status", "[]", "{}", "{\"request\": \"halt\"}", "{\"request\": \"set\"}"]
        {
            let why = Request::from_line(line).unwrap_err();
            assert!(why.contains("{\"request\": \"status\"}"), "{line}: {why}");
        }
    }
}
