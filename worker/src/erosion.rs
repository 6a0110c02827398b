//! Erosion: elements whose law has failed leave the contact surface, and the faces behind them
//! become free.
//!
//! A failed element stays in its block, and its mass at its nodes. It carries no force, does not
//! limit the step and is not in contact. The reduction of the step reports failures to all
//! workers ([`crate::parallel::reduction`]). The workers then exchange the faces of failed
//! solids. A solid that has such a face too marks it as free from then on.

use crate::fem::blocks::Blocks;
use crate::nodes::Nodes;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::transport::{RankLost, Transport, gather_all};
use std::collections::HashMap;

/// Number of cycles between two searches for failed elements. Until then a failed element carries
/// no force.
pub const EVERY: u64 = 8;

/// Nodes of a face, ascending.
type FaceNodes = [NodeId; 4];

fn faces_of(nodes: &[NodeId; 8], faces: &[[usize; 4]]) -> impl Iterator<Item = FaceNodes> {
    faces.iter().map(|corners| {
        let mut face = corners.map(|c| nodes[c]);
        face.sort_unstable();
        face
    })
}

/// Marks own elements that have failed and returns their ids. Frees the faces of own solids that
/// failed solids of any worker covered. The partition must be built again afterwards. All workers
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
    leave_surface(comm, blocks, nodes, &failed)?;
    Ok(failed.iter().map(|&i| blocks.elements[i].record.id).collect())
}

/// Marks these own elements as failed, and frees the faces of own solids that such solids of any
/// worker covered. All workers call this together.
///
/// # Errors
/// A worker is gone.
pub fn leave_surface(
    comm: &mut dyn Transport,
    blocks: &mut Blocks,
    nodes: &Nodes,
    failed: &[usize],
) -> Result<(), RankLost> {
    failed.iter().for_each(|&i| blocks.elements[i].record.failed = true);
    let solids = failed.iter().map(|&i| &blocks.elements[i].record).filter(|r| r.shape.is_solid());
    let bared: Vec<FaceNodes> = solids.flat_map(|r| faces_of(&r.nodes, r.shape.faces())).collect();
    // Only workers that have a corner of a face can have its other side. All get the message,
    // since failure is rare.
    let bared = gather_all(comm, bared)?;
    let here = |face: &&FaceNodes| nodes.local_index(face[0]).is_some();
    let bared: Vec<FaceNodes> = bared.iter().flatten().filter(here).copied().collect();
    if bared.is_empty() {
        return Ok(());
    }
    let mut opposing: HashMap<FaceNodes, Vec<(usize, usize)>> = HashMap::new();
    for (i, e) in blocks.elements.iter().enumerate().filter(|(_, e)| e.record.shape.is_solid()) {
        for (f, face) in faces_of(&e.record.nodes, e.record.shape.faces()).enumerate() {
            opposing.entry(face).or_default().push((i, f));
        }
    }
    for &(i, f) in bared.iter().filter_map(|face| opposing.get(face)).flatten() {
        blocks.elements[i].record.free_faces |= 1 << f;
    }
    Ok(())
}
