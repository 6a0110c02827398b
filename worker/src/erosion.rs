//! Erosion: elements whose law has failed leave the contact surface, and the faces behind them
//! become free.
//!
//! A failed element stays in its block, and its mass at its nodes. It carries no force, does not
//! limit the step and is not in contact. The reduction of the step reports failures to all
//! workers ([`crate::parallel::reduction`]). Neighbours then exchange the faces of failed
//! solids. A solid that has such a face too marks it as free from then on. What follows from it for
//! the surface is in [`crate::parallel::surface_update`].

use crate::fem::blocks::Blocks;
use crate::nodes::Nodes;
use crate::parallel::ghosts::Ghosts;
use crate::parallel::surface_update::Failures;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::{CornerNodes, face_key};
use crumple_proto::transport::{Mailbox, RankLost, Transport, exchange_with, gather_all};
use std::collections::HashSet;

/// Number of cycles between two searches for failed elements. Until then a failed element carries
/// no force.
pub const EVERY: u64 = 8;

/// Nodes of a face, ascending.
type FaceNodes = [NodeId; 4];

fn faces_of(nodes: &CornerNodes, faces: &[[usize; 4]]) -> impl Iterator<Item = FaceNodes> {
    faces.iter().map(|corners| face_key(corners.map(|c| nodes[c])))
}

/// Lets the other elements of their `groups` fail, marks own elements that have failed, and frees
/// the faces of own solids that failed solids of any worker covered. Returns all failures that
/// concern this worker. Its surface must be updated afterwards. All workers call this together.
///
/// # Errors
/// A worker is gone.
pub fn erode(
    comm: &mut dyn Transport,
    blocks: &mut Blocks,
    nodes: &Nodes,
    halo: &Ghosts,
    groups: &[Vec<ElemId>],
) -> Result<Failures, RankLost> {
    fail_with_others(comm, blocks, groups)?;
    let failed: Vec<usize> = blocks.newly_failed().collect();
    leave_surface(comm, blocks, nodes, halo, &failed)
}

/// Lets own elements fail in whose group an element of any worker has failed.
fn fail_with_others(
    comm: &mut dyn Transport,
    blocks: &mut Blocks,
    groups: &[Vec<ElemId>],
) -> Result<(), RankLost> {
    if groups.is_empty() {
        return Ok(());
    }
    let failed: HashSet<ElemId> =
        blocks.newly_failed().map(|i| blocks.elements[i].record.id).collect();
    let own =
        groups.iter().enumerate().filter(|(_, group)| group.iter().any(|id| failed.contains(id)));
    let own: Vec<u64> = own.map(|(index, _)| index as u64).collect();
    let all = gather_all(comm, own)?;
    let members: HashSet<ElemId> =
        all.iter().flatten().flat_map(|&index| &groups[index as usize]).copied().collect();
    if !members.is_empty() {
        blocks.fail(&members);
    }
    Ok(())
}

/// Marks these own elements as failed, and frees the faces of own solids that such solids of any
/// worker covered. Returns all failures that concern this worker. All workers call this together.
///
/// # Errors
/// A worker is gone.
pub fn leave_surface(
    comm: &mut dyn Transport,
    blocks: &mut Blocks,
    nodes: &Nodes,
    halo: &Ghosts,
    failed: &[usize],
) -> Result<Failures, RankLost> {
    failed.iter().for_each(|&i| blocks.elements[i].record.failed = true);
    let records = || failed.iter().map(|&i| &blocks.elements[i].record);
    let own: Vec<ElemId> = records().map(|r| r.id).collect();
    let solids = records().filter(|r| r.shape.is_solid());
    let mut bared: Vec<FaceNodes> =
        solids.flat_map(|r| faces_of(&r.nodes, r.shape.faces())).collect();
    let mut mail = Mailbox::default();
    if !own.is_empty() {
        mail.push(own.len() as u64);
        mail.extend(&own);
        mail.extend(&bared);
    }
    // The element behind a face has its nodes too, and so belongs to a neighbour.
    let workers = comm.size() - 1;
    let mut all = exchange_with(comm, vec![mail.into_words(); workers], &halo.neighbours(workers))?;
    all[comm.rank() - 1].clear();
    let mut of_others = HashSet::new();
    for words in all.into_iter().filter(|words| !words.is_empty()) {
        let mut mail = Mailbox::from_words(words);
        let count: u64 = mail.take();
        of_others.extend(mail.take_many::<ElemId>(count as usize));
        bared.extend(mail.rest::<FaceNodes>());
    }
    let frees_faces = free_faces_behind(blocks, nodes, &bared);
    Ok(Failures { own, of_others, frees_faces })
}

/// Frees the faces of own solids that failed solids covered. Returns true if there are any.
fn free_faces_behind(blocks: &mut Blocks, nodes: &Nodes, bared: &[FaceNodes]) -> bool {
    let here = |face: &&FaceNodes| nodes.local_index(face[0]).is_some();
    let bared: HashSet<&FaceNodes> = bared.iter().filter(here).collect();
    if bared.is_empty() {
        return false;
    }
    let mut frees_any = false;
    let records = blocks.elements.iter_mut().map(|e| &mut e.record);
    for record in records.filter(|r| r.shape.is_solid() && !r.failed) {
        for (f, face) in faces_of(&record.nodes, record.shape.faces()).enumerate() {
            if bared.contains(&face) {
                frees_any |= record.free_faces >> f & 1 == 0;
                record.free_faces |= 1 << f;
            }
        }
    }
    frees_any
}
