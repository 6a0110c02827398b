//! Update of the contact surface after elements have failed, without a renewal.
//!
//! Failed elements take their segments away, and solids behind them get new ones. The nodes of a
//! worker, its elements and its box do not change, so only some workers are concerned: those with
//! such elements or with solids behind them, those with ghosts of either, and those with a common
//! node whose thickness changes. All others keep their surface and the results of their searches.
//! Neighbours exchange the thickness at common nodes and the new segments that are needed as
//! ghosts; all workers agree on the scales of the surface and on whether there are new ghost nodes.
//! The box within which a worker needs ghosts was made at the last renewal for all nodes that can
//! come to the surface ([`Surface::hidden`]).

use crate::contact::surface::{ContactParts, Segment, Surface};
use crate::fem::blocks::Blocks;
use crate::math::row::Row;
use crate::nodes::Nodes;
use crate::parallel::ghost_segments::{
    Arrived, WireNode, add_segments, pack_segments, request_states, send_users,
};
use crate::parallel::ghosts::{GhostLink, Ghosts};
use crate::parallel::partition::{include_widths, share_scales};
use crumple_proto::ids::{ElemId, SegmentId};
use crumple_proto::partition::Settings;
use crumple_proto::transport::{Mailbox, RankLost, Transport, exchange_with};
use std::collections::HashSet;

/// Failures that concern a worker.
#[derive(Default)]
pub struct Failures {
    /// Own elements that have failed.
    pub own: Vec<ElemId>,
    /// Elements of neighbours that have failed.
    pub of_others: HashSet<ElemId>,
    /// True if faces of own solids have become free.
    pub frees_faces: bool,
}

impl Failures {
    /// Returns true if the segments of own elements change.
    pub fn concern_own(&self) -> bool {
        !self.own.is_empty() || self.frees_faces
    }
}

/// Result of [`update`].
pub struct SurfaceUpdate {
    /// The new surface of this worker, if it has changed.
    pub surface: Option<Surface>,
    /// True if any worker has got ghost nodes.
    pub has_new_ghosts: bool,
}

/// Updates the surface of this worker and its ghosts after elements have failed. `reference` has
/// the positions of local nodes at the last renewal, at which ghosts are selected [length]. The
/// surface `old` gets the scales that all workers agree on. All workers call this together.
///
/// # Errors
/// A worker is gone.
pub fn update(
    comm: &mut dyn Transport,
    settings: &Settings,
    (nodes, blocks, halo): (&mut Nodes, &Blocks, &mut Ghosts),
    old: &mut Surface,
    failures: &Failures,
    reference: &[Row],
) -> Result<SurfaceUpdate, RankLost> {
    let workers = comm.size() - 1;
    let parts = ContactParts::from_settings(settings);
    let own_surface = |nodes: &Nodes| Surface::new(blocks.elements.iter(), nodes, &parts);
    let mut fresh = failures.concern_own().then(|| own_surface(nodes));

    let mut parcels = vec![Vec::new(); workers];
    if let Some(surface) = &fresh {
        let own = old.segments.iter().filter(|s| s.own);
        let known: HashSet<SegmentId> = own.map(|s| s.id).collect();
        for link in &halo.links {
            parcels[link.worker] = pack(nodes, surface, link, &known, reference).into_words();
        }
    }
    let mut arrived = Arrived::default();
    let mut have_widths_changed = false;
    let neighbours = halo.neighbours(workers);
    let mut all = exchange_with(comm, parcels, &neighbours)?;
    for link in &mut halo.links {
        let words = std::mem::take(&mut all[link.worker]);
        if words.is_empty() {
            continue;
        }
        let mut mail = Mailbox::from_words(words);
        let widths: &[[f64; 2]] = mail.take_many(link.shared.len());
        have_widths_changed |= link.widths != widths;
        link.widths.copy_from_slice(widths);
        arrived.take(&mut mail);
    }
    let added = arrived.unknown_nodes(nodes);

    let surface = match &mut fresh {
        Some(surface) => surface,
        None => &mut *old,
    };
    let (_, most_added) = share_scales(comm, surface, added.len())?;
    let has_new_ghosts = most_added > 0;
    let scales = (surface.thinnest, surface.short, surface.largest_offset, surface.longest_side);
    (old.thinnest, old.short, old.largest_offset, old.longest_side) = scales;
    if has_new_ghosts {
        add_ghosts(comm, nodes, halo, old, &added)?;
    }
    let is_gone = |s: &Segment| !s.own && failures.of_others.contains(&s.id.elem());
    let is_concerned = fresh.is_some()
        || have_widths_changed
        || !arrived.segments.is_empty()
        || old.segments.iter().any(is_gone);
    if !is_concerned {
        return Ok(SurfaceUpdate { surface: None, has_new_ghosts });
    }
    let mut surface = fresh.unwrap_or_else(|| own_surface(nodes));
    (surface.thinnest, surface.short, surface.largest_offset, surface.longest_side) = scales;
    surface.hidden.clone_from(&old.hidden);
    halo.links.iter().for_each(|link| include_widths(&mut surface, link));
    surface.collect_slaves(nodes);
    surface.segments.extend(old.segments.iter().filter(|s| !s.own && !is_gone(s)));
    add_segments(nodes, &mut surface, &arrived.segments);
    Ok(SurfaceUpdate { surface: Some(surface), has_new_ghosts })
}

/// Returns the message to a neighbour: half thickness and scale at each common node, and the new
/// segments that it needs as ghosts.
fn pack(
    nodes: &Nodes,
    surface: &Surface,
    link: &GhostLink,
    known: &HashSet<SegmentId>,
    reference: &[Row],
) -> Mailbox {
    let width = |&n: &u32| [surface.node_half[n as usize], surface.node_scale[n as usize]];
    let is_needed = |s: &&Segment| {
        let is_near = |b| s.bounds(reference, 0.0).intersects(b);
        !known.contains(&s.id) && link.supplies.as_ref().is_some_and(is_near)
    };
    let mut mail = Mailbox::default();
    mail.extend(&link.shared.iter().map(width).collect::<Vec<_>>());
    mail.append(&pack_segments(nodes, surface.segments.iter().filter(is_needed), None));
    mail
}

/// Adds ghost nodes. Ghosts are numbered by their ids, so the numbers of others can change.
fn add_ghosts(
    comm: &mut dyn Transport,
    nodes: &mut Nodes,
    halo: &mut Ghosts,
    surface: &mut Surface,
    added: &[WireNode],
) -> Result<(), RankLost> {
    let local = nodes.local_count;
    let moved = nodes.add_ghosts(added.iter().map(WireNode::record_and_owner));
    let renumber = |n: &mut u32| {
        if let Some(ghost) = (*n as usize).checked_sub(local) {
            *n = moved.get(ghost).copied().unwrap_or(*n); // a corner that is not local stays so
        }
    };
    halo.links.iter_mut().flat_map(|l| &mut l.import).for_each(renumber);
    for s in &mut surface.segments {
        s.nodes.iter_mut().chain(&mut s.behind).for_each(renumber);
    }
    let workers = comm.size() - 1;
    request_states(comm, nodes, halo, added, workers)?;
    send_users(comm, nodes, halo)
}
