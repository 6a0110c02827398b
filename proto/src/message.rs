//! All control messages between master and workers.
//!
//! Start-up: the master sends `Start` to each worker. Workers then run, and send `Report`,
//! `History` and `Fields` unasked. The master sends `Order`s. The workers agree among
//! themselves on the cycle before which all of them execute an order. Workers answer a `Recut`
//! order with `Ready`; `Extents` and `Histograms` requests follow, and `Cuts` completes it. A
//! worker that saves a checkpoint sends `Captured` when its state is copied and `Saved` when it is
//! on disk. A copy that stays in memory is announced by `Copied`; if the run fails, `Saved`
//! follows. An order of a user is answered by `Steered`, a `View` order by `Viewed`. At the end
//! each worker sends `Closing` with the states of its nodes.
//!
//! A run that continues from a checkpoint begins with `Resume` instead of `Start`. A worker answers
//! with `Ready`, or with `Trouble` if it cannot read its files. The first boxes come from requests
//! as in a repartition.

use crate::boxes::{Aabb, CutTree};
use crate::checkpoint::{Captured, FileRecord, Saved};
use crate::exact_sum::ExactSum;
use crate::ids::ElemId;
use crate::partition::{ElementRecord, NodeRecord, Settings};
use crate::report::{Failure, FinalReport, HistoryPart, StepLoads, StepReport};
use crate::steering::{Steer, Steered};
use crate::trace::Recording;
use serde::{Deserialize, Serialize};

/// Message from the master to a worker.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum ToWorker {
    /// The job and this worker's first partition of the mesh.
    Start {
        /// Settings that are equal on all workers.
        settings: Box<Settings>,
        /// First tree of boxes.
        tree: CutTree,
        /// This worker's elements.
        elements: Vec<ElementRecord>,
        /// All nodes of these elements.
        nodes: Vec<NodeRecord>,
        /// True if the worker records spans and moments for `--trace`.
        trace: bool,
    },
    /// Continuation of a run from a checkpoint; sent instead of `Start`. Requests for the
    /// distribution of the load and `Cuts` follow, as in a repartition.
    Resume {
        /// Settings that are equal on all workers.
        settings: Box<Settings>,
        /// Folder of the checkpoint.
        folder: String,
        /// File with the common state.
        common: FileRecord,
        /// Files of the workers of that time.
        pieces: Vec<FileRecord>,
        /// Changes of the model.
        changes: Changes,
        /// True if the worker records spans and moments for `--trace`.
        trace: bool,
    },
    /// The job is invalid and there is no work; sent instead of `Start`.
    Quit,
    /// Order that all workers execute before the same cycle; orders are numbered from 1.
    Order {
        /// Number of the order.
        number: u64,
        /// Action to execute.
        action: Action,
    },
    /// Requests the extents of this worker's element centres in leaf entries of the growing
    /// tree.
    Extents {
        /// Tree so far.
        tree: CutTree,
        /// Leaf entries that are requested.
        entries: Vec<usize>,
    },
    /// Requests the distribution of load along an axis in leaf entries of the growing tree.
    Histograms {
        /// Tree so far.
        tree: CutTree,
        /// Entry, axis, lower and upper end of each histogram.
        of: Vec<(usize, usize, f64, f64)>,
        /// Number of bins.
        bins: usize,
        /// Time of a contact pair in a cycle [s]; the rest of the time of contact forces is that of
        /// messages, and does not go with the pairs.
        pair_s: f64,
    },
    /// New boxes: the workers migrate elements and continue the run.
    Cuts(CutTree),
}

/// Changes of the model when a run continues from a checkpoint; parts are indices.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Changes {
    /// Parts that are deleted.
    pub delete: Vec<u32>,
    /// Parts, and the velocity of their nodes [length/time].
    pub velocities: Vec<(Vec<u32>, [f64; 3])>,
}

/// Action that an order requests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Action {
    /// Membership update (*high* redecomposition): the boxes only drift, the members are
    /// renewed.
    Renew(CutTree),
    /// Repartition (*low* redecomposition): the boxes are computed again as well.
    Recut,
    /// A checkpoint of the present state. The run continues.
    Checkpoint,
    /// A copy of the present state in memory, in place of the one before. The run continues.
    Copy,
    /// The fields of own elements in this folder, as a picture for clients. The run continues.
    View(String),
    /// An order of the user, or the end of the run by [`Steer::Stop`]. It takes effect when the
    /// next outer step begins.
    Steer(Steer),
    /// As [`Steer::Stop`], but the run has failed: the checkpoint is that of the copy in memory, if
    /// there is one.
    Fail,
}

impl Action {
    /// Returns true if no worker lacks ghosts after the action, or no step follows it.
    pub fn renews_or_ends(&self) -> bool {
        use Steer::Stop;
        matches!(self, Self::Renew(_) | Self::Recut | Self::Steer(Stop) | Self::Fail)
    }

    /// Returns the name of the action.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Renew(_) => "high redecomposition",
            Self::Recut => "low redecomposition",
            Self::Checkpoint => "checkpoint",
            Self::Copy => "copy",
            Self::View(_) => "view",
            Self::Steer(Steer::Pause) => "pause",
            Self::Steer(Steer::Continue) => "continue",
            Self::Steer(Steer::Checkpoint) => "checkpoint",
            Self::Steer(Steer::Stop) => "stop",
            Self::Steer(Steer::Set(_)) => "change",
            Self::Fail => "fail",
        }
    }
}

/// Answer to a `View` order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Viewed {
    /// Cycles completed.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Time that the worker needed [s].
    pub seconds: f64,
    /// Why the files could not be written.
    pub error: Option<String>,
}

/// Edges of elements that have passed through segments where contact cannot detect it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EdgeCrossings {
    /// Cycle in which the worker has found them.
    pub cycle: u64,
    /// Simulated time of this cycle [time].
    pub time: f64,
    /// Number of crossings that the worker has found.
    pub count: u64,
    /// Element of the first edge.
    pub edge: ElemId,
    /// Element through which it has passed.
    pub surface: ElemId,
}

/// Message from a worker to the master.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum ToMaster {
    /// Progress and load.
    Report(Box<StepReport>),
    /// Contribution of this worker to a history row.
    History(Box<HistoryPart<ExactSum>>),
    /// The field files of one time are complete.
    Fields {
        /// Number of the output.
        index: usize,
        /// Simulated time [time].
        time: f64,
    },
    /// The worker has copied its state for a checkpoint. All rows and fields that `Captured`
    /// counts were sent before.
    Captured(Captured, u64),
    /// The worker has copied its state in memory, in this time [s]. All rows and fields that
    /// `Captured` counts were sent before.
    Copied(Captured, u64, f64),
    /// The files of a `View` order are written.
    Viewed(Viewed),
    /// The files of a checkpoint are on disk, or could not be written.
    Saved(Saved),
    /// Warning that does not end the run.
    Warning(String),
    /// Edges have passed through segments; sent once.
    Crossed(EdgeCrossings),
    /// The worker has stopped for a `Recut` order and waits for requests.
    Ready,
    /// Answer to `Extents`: box around the element centres, per entry.
    Extents(Vec<Aabb>),
    /// Answer to `Histograms`: loads per bin, per entry.
    Histograms(Vec<Vec<StepLoads>>),
    /// An order of the user has taken effect; sent by the first worker for all. The number is that
    /// of the order, 0 for one that was planned.
    Steered(u64, Steered),
    /// The worker cannot continue; all workers stop at this state.
    Trouble(Failure),
    /// Recorded trace, if requested; sent before `Closing`, and also when another worker was
    /// lost.
    Recording(Box<Recording>),
    /// The run is over; contains the states of owned nodes as node records.
    Closing(Box<FinalReport>, Vec<NodeRecord>),
}
