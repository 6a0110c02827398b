//! Erosion: elements whose law has failed leave the contact surface, and what was behind them comes
//! to light.
//!
//! A failed element stays where it is in its block, and its mass with its nodes; it bears nothing,
//! sets no step and cannot be touched. All workers agree that some have failed
//! ([`crate::parallel::reduction`]) and tell each other the faces that these had. A solid that has
//! one of these faces too, which its opposing-face list tells, shows it from then on.

use crate::fem::blocks::Blocks;
use crate::nodes::Nodes;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::transport::{RankLost, Transport, exchange_all};
use std::collections::HashMap;

/// Failed elements are looked for in every so many cycles: a failed element bears nothing
/// meanwhile.
pub const EVERY: u64 = 8;

/// Nodes of a face, ascending.
type Face = [NodeId; 4];

fn faces_of(nodes: &[NodeId; 8], faces: &[[usize; 4]]) -> impl Iterator<Item = Face> {
    faces.iter().map(|corners| {
        let mut face = corners.map(|c| nodes[c]);
        face.sort_unstable();
        face
    })
}

/// Marks own elements that have failed, and opens the faces of own solids that failed ones of any
/// worker had covered. Membership has to be settled anew afterwards. Gives the former. All workers
/// call this together.
///
/// # Errors
/// A worker is gone.
pub fn erode(
    comm: &mut dyn Transport,
    blocks: &mut Blocks,
    nodes: &Nodes,
) -> Result<Vec<ElemId>, RankLost> {
    let failed: Vec<usize> = blocks.newly_failed().collect();
    failed.iter().for_each(|&i| blocks.elements[i].record.failed = true);
    let ids = failed.iter().map(|&i| blocks.elements[i].record.id).collect();
    let solids = failed.iter().map(|&i| &blocks.elements[i].record).filter(|r| r.shape.is_solid());
    let bared: Vec<Face> = solids.flat_map(|r| faces_of(&r.nodes, r.shape.faces())).collect();
    // Only who has a corner of a face near can have its other side; all are told, since failure is
    // rare.
    let words: Vec<u64> = bared.iter().flatten().map(|n| n.0).collect();
    let parcels = vec![words; comm.size() - 1];
    let told = exchange_all(comm, parcels)?;
    let bared: Vec<Face> =
        told.iter().flat_map(|w| w.as_chunks::<4>().0).map(|ids| ids.map(NodeId)).collect();
    let here = |face: &&Face| nodes.local_index(face[0]).is_some();
    let bared: Vec<Face> = bared.iter().filter(here).copied().collect();
    if bared.is_empty() {
        return Ok(ids);
    }
    let mut opposing: HashMap<Face, Vec<(usize, usize)>> = HashMap::new();
    for (i, e) in blocks.elements.iter().enumerate().filter(|(_, e)| e.record.shape.is_solid()) {
        for (f, face) in faces_of(&e.record.nodes, e.record.shape.faces()).enumerate() {
            opposing.entry(face).or_default().push((i, f));
        }
    }
    for &(i, f) in bared.iter().filter_map(|face| opposing.get(face)).flatten() {
        blocks.elements[i].record.free_faces |= 1 << f;
    }
    Ok(ids)
}
