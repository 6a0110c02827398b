//! The whole conversation between master and workers on one page.
//!
//! Start-up: `Start` to each worker. Then workers run and send `Report`, `History`, `Fields` on
//! their own; the master sends `Order`s, which all workers carry out before the same cycle (they
//! agree on it among themselves). Workers answer a `Recut` order with `Ready`; `Extents` and
//! `Histograms` questions follow, and `Cuts` ends it. At the end each worker sends `Closing` and
//! its node states.

use crate::boxes::{Aabb, CutTree};
use crate::partition::{ElementRecord, NodeRecord, Settings};
use crate::report::{Failure, FinalReport, HistoryPart, StepReport};
use crate::trace::Recording;
use serde::{Deserialize, Serialize};

/// Master to worker.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum ToWorker {
    /// The job and this worker's first share of the mesh.
    Start {
        /// What all workers know.
        settings: Box<Settings>,
        /// First boxes.
        tree: CutTree,
        /// This worker's elements.
        elements: Vec<ElementRecord>,
        /// All nodes of these elements.
        nodes: Vec<NodeRecord>,
        /// Whether to record what happens when.
        trace: bool,
    },
    /// There is nothing to do: the job is bad. Instead of `Start`.
    Quit,
    /// To be carried out by all workers before the same cycle; numbered from 1.
    Order {
        /// Number of the order.
        number: u64,
        /// What to do.
        action: Action,
    },
    /// Which extents do your element centres have in these leaf entries of the growing tree?
    Extents {
        /// The tree so far.
        tree: CutTree,
        /// Leaf entries asked about.
        entries: Vec<usize>,
    },
    /// How is the load spread along an axis within leaf entries of the growing tree?
    Histograms {
        /// The tree so far.
        tree: CutTree,
        /// Entry, axis, lower and upper end.
        of: Vec<(usize, usize, f64, f64)>,
        /// Number of bins.
        bins: usize,
        /// Cost of a contact pair in units of an element's.
        pair_weight: f64,
    },
    /// The new boxes: migrate and go on.
    Cuts(CutTree),
}

/// What an order asks for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Action {
    /// High redecomposition: boxes only drift; membership is renewed.
    Renew(CutTree),
    /// Low redecomposition: boxes are recomputed too.
    Recut,
    /// Stop with outputs intact.
    Stop,
}

/// Worker to master.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum ToMaster {
    /// Progress and load.
    Report(StepReport),
    /// A history row's share.
    History(Box<HistoryPart>),
    /// Field files of one time are written.
    Fields {
        /// Number of the output.
        index: usize,
        /// Simulated time [time].
        time: f64,
    },
    /// Something went wrong that does not end the run.
    Warning(String),
    /// Stopped for a `Recut` order, ready for questions.
    Ready,
    /// Answer to `Extents`: box around element centres per entry.
    Extents(Vec<Aabb>),
    /// Answer to `Histograms`: load per bin, per entry.
    Histograms(Vec<Vec<f64>>),
    /// The run cannot go on; all workers stop at this state.
    Trouble(Failure),
    /// What was recorded, before `Closing` and also when another worker was lost; only if asked
    /// for.
    Recording(Box<Recording>),
    /// The run is over; the states of owned nodes follow as node records.
    Closing(Box<FinalReport>, Vec<NodeRecord>),
}
