//! Checkpoints of a worker: copying the state, writing it on a thread, and reading it again.

pub mod writer;

use crate::engine::checkpoint::{CommonState, WorkerState};
use crate::parallel::migrate::{centre_of_record, unpack};
use crate::parallel::partition::PartitionData;
use crumple_proto::checkpoint::{FileRecord, read};
use crumple_proto::ids::NodeId;
use crumple_proto::partition::Settings;
use crumple_proto::wire;
use std::collections::HashMap;
use std::path::Path;

/// Returns the words of a worker's file.
pub fn piece_words(parcel: &[u64], own: &WorkerState) -> Vec<u64> {
    let own = wire::encode(own);
    let mut words = Vec::with_capacity(1 + parcel.len() + own.len());
    words.push(parcel.len() as u64);
    words.extend(parcel);
    words.extend(own);
    words
}

/// State that a worker reads from a checkpoint.
pub struct ReadState {
    /// State that all workers have in common.
    pub common: CommonState,
    /// Sums of the workers whose files it has read.
    pub own: WorkerState,
    /// Elements and nodes of these files.
    pub share: PartitionData,
}

/// Reads the common state, and every `workers`-th file from number `me` on.
///
/// # Errors
/// A file cannot be read, or has changed; the message names it.
pub fn read_state(
    folder: &Path,
    common: &FileRecord,
    pieces: &[FileRecord],
    (me, workers): (usize, usize),
) -> Result<ReadState, String> {
    let broken = |record: &FileRecord| {
        format!("{}: another version of the program wrote it", folder.join(&record.name).display())
    };
    let words = read(folder, common)?;
    let mut state = ReadState {
        common: wire::decode(&words).ok_or_else(|| broken(common))?,
        own: WorkerState::default(),
        share: PartitionData::default(),
    };
    for record in pieces.iter().skip(me).step_by(workers) {
        let words = read(folder, record)?;
        let (parcel, own) = words
            .split_first()
            .and_then(|(&count, rest)| rest.split_at_checked(usize::try_from(count).ok()?))
            .ok_or_else(|| broken(record))?;
        state.own.add(&wire::decode(own).ok_or_else(|| broken(record))?);
        unpack(parcel.to_vec(), &mut state.share);
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
