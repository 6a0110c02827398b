//! Checkpoints of a worker: copying the state, writing it on a thread, and reading it again.

pub mod writer;

use crate::engine::checkpoint::{CommonState, WorkerState};
use crate::fem::blocks::Block;
use crate::fem::elements::build_block;
use crate::parallel::migrate::{centre_of_record, unpack};
use crate::parallel::partition::PartitionData;
use crumple_proto::checkpoint::{FileRecord, read};
use crumple_proto::ids::NodeId;
use crumple_proto::partition::{ElementRecord, Settings};
use crumple_proto::wire;
use std::collections::{BTreeMap, HashMap};
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

/// Adds the content of a worker's file to what was read. Returns the number of its elements.
///
/// # Errors
/// The words are no state: the reason.
fn take_piece(
    words: &[u64],
    share: &mut PartitionData,
    own: &mut WorkerState,
) -> Result<usize, String> {
    let other = || "another version of the program wrote it".to_string();
    let (parcel, state) = words
        .split_first()
        .and_then(|(&count, rest)| rest.split_at_checked(usize::try_from(count).ok()?))
        .ok_or_else(other)?;
    own.add(&wire::decode(state).ok_or_else(other)?);
    let mut piece = PartitionData::default();
    unpack(parcel.to_vec(), &mut piece).ok_or_else(other)?;
    let mut nodes: Vec<NodeId> = piece.nodes.iter().map(|n| n.id).collect();
    nodes.sort_unstable();
    for (e, _) in &piece.elements {
        if let Some(n) = e.nodes.iter().find(|n| nodes.binary_search(n).is_err()) {
            return Err(format!("element {} has node {n}, which the file does not have", e.id));
        }
    }
    if let Some(n) = piece.nodes.iter().find(|n| n.fixed >> 6 != 0) {
        return Err(format!("node {} has degrees of freedom that do not exist", n.id));
    }
    let count = piece.elements.len();
    share.elements.append(&mut piece.elements);
    share.nodes.append(&mut piece.nodes);
    share.memories.append(&mut piece.memories);
    share.means.append(&mut piece.means);
    Ok(count)
}

/// Checks that a worker's file can be read. Returns the number of its elements.
///
/// # Errors
/// It is no state; the message names the file.
pub fn verify_piece(folder: &Path, record: &FileRecord) -> Result<usize, String> {
    let words = read(folder, record)?;
    take_piece(&words, &mut PartitionData::default(), &mut WorkerState::default())
        .map_err(|why| format!("{}: {why}", folder.join(&record.name).display()))
}

/// Checks that the elements that were read are those of parts of the job, with their columns.
fn fit(settings: &Settings, elements: &[(ElementRecord, Vec<f64>)]) -> Result<(), String> {
    let mut known: BTreeMap<(u32, u8), usize> = BTreeMap::new();
    for (e, columns) in elements {
        let kind = (e.part, e.shape as u8);
        let wanted = match known.get(&kind) {
            Some(&wanted) => wanted,
            None => {
                let built = (e.part as usize) < settings.parts.len();
                let built = built.then(|| build_block(settings, e.part as usize, e.shape));
                let Some(Ok(element)) = built else {
                    return Err(format!("element {} belongs to no part of the job", e.id));
                };
                known.insert(kind, Block::columns_of(&*element));
                known[&kind]
            }
        };
        if columns.len() != wanted {
            return Err(format!(
                "element {} has {} columns, and the element of its part has {wanted}",
                e.id,
                columns.len()
            ));
        }
    }
    Ok(())
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
    let other = || named(common, "another version of the program wrote it".into());
    let read_common: CommonState = wire::decode(&words).ok_or_else(other)?;
    read_common.fit(settings).map_err(|why| named(common, why))?;
    let mut state = ReadState {
        common: read_common,
        own: WorkerState::default(),
        share: PartitionData::default(),
    };
    for record in pieces.iter().skip(me).step_by(workers) {
        let words = read(folder, record)?;
        let from = state.share.elements.len();
        take_piece(&words, &mut state.share, &mut state.own)
            .and_then(|_| fit(settings, &state.share.elements[from..]))
            .map_err(|why| named(record, why))?;
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
