//! Checkpoints of a worker: copying the state, writing it on a thread, and reading it again.

pub mod fit;
pub mod layout;
pub mod writer;

use crate::engine::checkpoint::{CommonState, WorkerState};
use crate::parallel::migrate::{centre_of_record, unpack};
use crate::parallel::partition::PartitionData;
use crumple_proto::checkpoint::{FileRecord, read};
use crumple_proto::ids::NodeId;
use crumple_proto::partition::Settings;
use crumple_proto::wire;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// State that a worker reads from a checkpoint.
pub struct ReadState {
    /// State that all workers have in common.
    pub common: CommonState,
    /// Sums of the workers whose files it has read.
    pub own: WorkerState,
    /// Elements and nodes of these files.
    pub share: PartitionData,
}

/// Content of a worker's file.
pub struct CheckpointPiece {
    /// Elements and nodes.
    pub share: PartitionData,
    /// Sums of the worker.
    pub own: WorkerState,
}

impl CheckpointPiece {
    /// Reads the words of a file: the number of words of the parcel, the parcel, and the sums.
    ///
    /// # Errors
    /// They are no state: the reason.
    pub fn new(words: &[u64]) -> Result<Self, String> {
        let other = || "it is not the state of a worker".to_string();
        let (parcel, state) = words
            .split_first()
            .and_then(|(&count, rest)| rest.split_at_checked(usize::try_from(count).ok()?))
            .ok_or_else(other)?;
        let own = wire::decode(state).ok_or_else(other)?;
        let mut share = PartitionData::default();
        unpack(parcel.to_vec(), &mut share).ok_or_else(other)?;
        let mut nodes: Vec<NodeId> = share.nodes.iter().map(|n| n.id).collect();
        nodes.sort_unstable();
        let lacks = |n: &NodeId| nodes.binary_search(n).is_err();
        for (e, _) in &share.elements {
            if let Some(n) = e.nodes.iter().find(|n| lacks(n)) {
                return Err(format!("element {} has node {n}, which the file does not have", e.id));
            }
        }
        let named = share.memories.keys().chain(share.means.iter().map(|mean| &mean.id));
        if let Some(n) = named.into_iter().find(|n| lacks(n)) {
            return Err(format!("it has a history of node {n}, but not the node"));
        }
        if let Some(n) = share.nodes.iter().find(|n| n.fixed >> 6 != 0) {
            return Err(format!("node {} has degrees of freedom that do not exist", n.id));
        }
        Ok(Self { share, own })
    }

    /// Adds it to those that were read before.
    pub fn add_to(mut self, share: &mut PartitionData, own: &mut WorkerState) {
        own.add(&self.own);
        share.elements.append(&mut self.share.elements);
        share.nodes.append(&mut self.share.nodes);
        share.memories.append(&mut self.share.memories);
        share.means.append(&mut self.share.means);
    }
}

/// Reads the common state, and every `workers`-th file from number `me` on.
///
/// # Errors
/// A file cannot be read, has changed, or does not belong to the job; the message names it.
pub fn read_state(
    folder: &Path,
    settings: &Settings,
    common: &FileRecord,
    pieces: &[FileRecord],
    (me, workers): (usize, usize),
) -> Result<ReadState, String> {
    let named = |record: &FileRecord, why: String| {
        format!("{}: {why}", folder.join(&record.name).display())
    };
    let words = read(folder, common)?;
    let other = || named(common, "it is not the state that all workers share".into());
    let read_common: CommonState = wire::decode(&words).ok_or_else(other)?;
    read_common.validate(settings).map_err(|why| named(common, why))?;
    let mut state = ReadState {
        common: read_common,
        own: WorkerState::default(),
        share: PartitionData::default(),
    };
    let mut known = BTreeMap::new();
    for record in pieces.iter().skip(me).step_by(workers) {
        let words = read(folder, record)?;
        let piece = CheckpointPiece::new(&words).map_err(|why| named(record, why))?;
        piece
            .own
            .validate(settings)
            .and_then(|()| fit::fit_columns(settings, &piece.share.elements, &mut known))
            .map_err(|why| named(record, why))?;
        piece.add_to(&mut state.share, &mut state.own);
    }
    Ok(state)
}

/// Returns the centre and the load of each element that was read.
pub fn loads<'a>(
    settings: &'a Settings,
    share: &'a PartitionData,
) -> impl Iterator<Item = ([f64; 3], f64)> + 'a {
    let places: HashMap<NodeId, [f64; 3]> = share.nodes.iter().map(|n| (n.id, n.x)).collect();
    share.elements.iter().map(move |(e, _)| (centre_of_record(e, |n| places[&n]), settings.load(e)))
}
