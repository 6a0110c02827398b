//! Ghost segments: which segments of other workers a worker gets, with their nodes, at a renewal
//! and when elements fail (`surface_update.rs`).

use crate::contact;
use crate::contact::beams::with_edges;
use crate::contact::edges::contact_edges;
use crate::contact::enforce::by_segments;
use crate::contact::surface::{NOT_LOCAL, Segment, Surface};
use crate::math::row::xyz;
use crate::nodes::Nodes;
use crate::parallel::ghosts::Ghosts;
use crate::parallel::history_message::{Memories, put_histories, take_histories};
use crate::parallel::reduction::near_pairs_decide;
use bytemuck::{Pod, Zeroable};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::{NodeId, SegmentId};
use crumple_proto::partition::{NodeRecord, Settings};
use crumple_proto::transport::{
    Mailbox, RankLost, Transport, exchange_all, exchange_with, gather_all,
};

/// Segment of a ghost element.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct WireSegment {
    id: SegmentId,
    nodes: [NodeId; 4],
    behind: [NodeId; 4],
    half: f64,
    offset: f64,
    scale: f64,
    part: u64,
}

/// Node of a ghost element.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct WireNode {
    record: NodeRecord,
    owner: u64,
}

impl WireNode {
    pub(super) fn record_and_owner(&self) -> (NodeRecord, u32) {
        (self.record, self.owner as u32)
    }
}

/// Returns the distance around a worker's own slaves and edges within which it gets ghost
/// segments: the reach of the search, for the largest scale of any worker's surface, plus the
/// reach of a smooth patch, plus the buffer, plus half the skin if what comes near in the next
/// steps limits the step ([`approach`]) [length]. It can do so from a later cycle on if solids can
/// fail (`exposes`), since smaller ones may be behind them.
///
/// [`approach`]: crate::contact::approach
pub fn covered(settings: &Settings, surface: &Surface, largest_scale: f64, exposes: bool) -> f64 {
    let skin = settings.contact.as_ref().map_or(0.0, |c| c.skin);
    let decide = exposes || near_pairs_decide(surface.thinnest, skin);
    let ahead = if decide { 0.5 * skin } else { 0.0 };
    contact::search_reach(&surface.interfaces, largest_scale, largest_scale)
        + surface.shift_reach()
        + surface.patch_reach()
        + settings.buffer
        + ahead
}

/// Returns the box around a worker's own slaves, edges and, where segments touch segments, the
/// nodes of these; nodes that can come to the surface count as well. `surface` has own segments
/// only.
pub fn seeking(settings: &Settings, surface: &Surface, nodes: &Nodes) -> Aabb {
    let is_met = with_edges(settings) || settings.contact.as_ref().is_some_and(by_segments);
    let of_edges = if is_met { contact_edges(surface) } else { Vec::new() };
    let all = surface.slaves.iter().chain(&of_edges).chain(&surface.hidden);
    Aabb::around(all.map(|&i| xyz(&nodes.x[i as usize])))
}

/// Returns true if an entity in the box `held` could be within `grow` of the box `seeking`.
pub fn are_near(seeking: &Aabb, held: &Aabb, grow: f64) -> bool {
    !seeking.is_empty() && !held.is_empty() && !seeking.intersection(&held.grown(grow)).is_empty()
}

/// Exchanges the boxes of all workers.
pub(super) fn exchange_bounds(
    comm: &mut dyn Transport,
    mine: &Aabb,
) -> Result<Vec<Aabb>, RankLost> {
    let boxes = gather_all(comm, vec![mine.min, mine.max])?;
    Ok(boxes.iter().map(|b| Aabb { min: b[0], max: b[1] }).collect())
}

/// Copies the segments of other workers' interface elements, with their nodes, that reach into
/// the external box: those that could touch the slaves and edges for which this worker searches
/// before the next renewal.
/// `grow` is the distance from [`covered`]. Returns the external box.
///
/// # Errors
/// A worker is gone.
pub(super) fn copy_ghosts(
    comm: &mut dyn Transport,
    settings: &Settings,
    (nodes, halo, surface, memories): (&mut Nodes, &mut Ghosts, &mut Surface, &mut Memories),
    held_bounds: &[Aabb],
    grow: f64,
) -> Result<Aabb, RankLost> {
    let me = nodes.me as usize;
    // A worker that searches for nodes of other workers needs their histories.
    let (slave_boxes, sent) = match &halo.regions {
        Some(regions) => (regions.seeking.clone(), Some(&*memories)),
        None => (exchange_bounds(comm, &seeking(settings, surface, nodes))?, None),
    };
    set_reaches(halo, me, (&slave_boxes, held_bounds), (settings.buffer, grow));
    // A worker may get ghosts from another one that gets none from it.
    let reaches = |a: usize, b: usize| slave_boxes[a].grown(grow).intersects(&held_bounds[b]);
    let partners: Vec<bool> =
        (0..slave_boxes.len()).map(|w| reaches(me, w) || reaches(w, me)).collect();
    let offer = |(w, b): (usize, &Aabb)| match w != me && reaches(w, me) {
        true => {
            let grown = b.grown(grow);
            let near =
                surface.segments.iter().filter(|s| grown.intersects(&s.bounds(&nodes.x, 0.0)));
            pack_segments(nodes, near, sent).into_words()
        }
        false => Vec::new(),
    };
    let offers = slave_boxes.iter().enumerate().map(offer).collect();
    let mut arrived = Arrived::default();
    for words in exchange_with(comm, offers, &partners)?.into_iter().filter(|w| !w.is_empty()) {
        let mut mail = Mailbox::from_words(words);
        arrived.take(&mut mail);
        while !mail.is_read() {
            let (id, list) = take_histories(&mut mail).expect("workers send whole messages");
            memories.insert(id, list);
        }
    }
    let added = arrived.unknown_nodes(nodes);
    nodes.add_ghosts(added.iter().map(WireNode::record_and_owner));
    add_segments(nodes, surface, &arrived.segments);
    request_states(comm, nodes, halo, &added, held_bounds.len())?;
    let own = slave_boxes[me];
    Ok(if own.is_empty() { Aabb::EMPTY } else { own.grown(grow) })
}

/// Sets for each other worker how near its segments are to own slaves and edges.
fn set_reaches(
    halo: &mut Ghosts,
    me: usize,
    (slave_boxes, held_bounds): (&[Aabb], &[Aabb]),
    (buffer, grow): (f64, f64),
) {
    for link in &mut halo.links {
        let (mine, theirs) = (&slave_boxes[me].grown(grow), &held_bounds[link.worker]);
        link.reach = (!theirs.is_empty()).then(|| theirs.grown(grow));
        if !slave_boxes[me].is_empty() && !theirs.is_empty() {
            let near = slave_boxes[me].intersection(&theirs.grown(grow));
            link.region = Some(if near.is_empty() { slave_boxes[me] } else { near });
            link.is_distant = near.is_empty();
            link.margin = buffer + mine.distance(theirs);
        }
        let needs = |seeking: &Aabb, held: &Aabb| seeking.grown(grow).intersects(held);
        link.needs = needs(&slave_boxes[me], theirs);
        let others = &slave_boxes[link.worker];
        link.supplies = needs(others, &held_bounds[me]).then(|| others.grown(grow));
        link.both_distant = !are_near(&slave_boxes[me], theirs, grow)
            && !are_near(&slave_boxes[link.worker], &held_bounds[me], grow);
    }
}

/// Segments and nodes of other workers that have arrived.
#[derive(Default)]
pub(super) struct Arrived {
    pub(super) segments: Vec<WireSegment>,
    nodes: Vec<WireNode>,
}

impl Arrived {
    /// Takes the items of [`pack_segments`] from a message.
    pub(super) fn take(&mut self, mail: &mut Mailbox) {
        let [count, corners] = mail.take::<[u64; 2]>();
        self.segments.extend(mail.take_many::<WireSegment>(count as usize));
        self.nodes.extend(mail.take_many::<WireNode>(corners as usize));
    }

    /// Returns the nodes that this worker does not have yet, in ascending id.
    pub(super) fn unknown_nodes(&mut self, nodes: &Nodes) -> Vec<WireNode> {
        let mut unknown = std::mem::take(&mut self.nodes);
        unknown.retain(|c| nodes.index_of(c.record.id).is_none());
        unknown.sort_unstable_by_key(|c| c.record.id);
        unknown.dedup_by_key(|c| c.record.id);
        unknown
    }
}

/// Returns a message with segments: their number and that of their nodes, the segments, the nodes,
/// and the pair histories of the nodes in `memories`.
pub(super) fn pack_segments<'a>(
    nodes: &Nodes,
    segments: impl Iterator<Item = &'a Segment> + Clone,
    memories: Option<&Memories>,
) -> Mailbox {
    let pack = |s: &Segment| WireSegment {
        id: s.id,
        nodes: s.nodes.map(|n| nodes.id[n as usize]),
        behind: s
            .behind
            .map(|n| if n == NOT_LOCAL { NodeId(u64::MAX) } else { nodes.id[n as usize] }),
        half: s.half_thickness,
        offset: s.offset,
        scale: s.scale,
        part: u64::from(s.part),
    };
    let packed: Vec<WireSegment> = segments.clone().map(pack).collect();
    let mut corners: Vec<u32> = segments.flat_map(|s| s.nodes).collect();
    corners.sort_unstable();
    corners.dedup();
    let node = |&i: &u32| WireNode {
        record: nodes.record(i as usize),
        owner: u64::from(nodes.owner[i as usize]),
    };
    let mut mail = Mailbox::default();
    mail.push([packed.len(), corners.len()].map(|count| count as u64));
    mail.extend(&packed);
    mail.extend(&corners.iter().map(node).collect::<Vec<_>>());
    for id in corners.iter().map(|&i| nodes.id[i as usize]) {
        if let Some(list) = memories.and_then(|all| all.get(&id)) {
            put_histories(&mut mail, id, list);
        }
    }
    mail
}

/// Adds the segments of other workers to the surface.
pub(super) fn add_segments(nodes: &Nodes, surface: &mut Surface, segments: &[WireSegment]) {
    let local = |id: NodeId| nodes.index_of(id).expect("a worker has all nodes of a segment");
    surface.segments.extend(segments.iter().map(|s| Segment {
        id: s.id,
        nodes: s.nodes.map(local),
        behind: s.behind.map(|n| nodes.index_of(n).unwrap_or(NOT_LOCAL)),
        half_thickness: s.half,
        offset: s.offset,
        scale: s.scale,
        part: s.part as u32,
        own: false,
        searched: false,
    }));
    surface.segments.sort_unstable_by_key(|s| s.id);
}

/// Asks the owners of new ghost nodes for their states, which they send in every step.
///
/// # Errors
/// A worker is gone.
pub(super) fn request_states(
    comm: &mut dyn Transport,
    nodes: &Nodes,
    halo: &mut Ghosts,
    ghosts: &[WireNode],
    workers: usize,
) -> Result<(), RankLost> {
    let wanted = |w: usize| {
        let of_worker = ghosts.iter().filter(|g| g.owner as usize == w);
        of_worker.map(|g| g.record.id).collect::<Vec<NodeId>>()
    };
    let requests = exchange_all(comm, (0..workers).map(wanted).collect())?;
    for link in &mut halo.links {
        let number = |&id: &NodeId| nodes.index_of(id).expect("requested nodes are local");
        link.export.extend(requests[link.worker].iter().map(number));
        link.import.extend(wanted(link.worker).iter().map(number));
        // A segment may come from one worker while its far corner belongs to another one, which
        // is not nearer for this reason.
        link.both_distant &= link.export.is_empty() && link.import.is_empty();
    }
    Ok(())
}

/// Sends the list of workers that have an owned node to each of these workers.
pub(super) fn send_users(
    comm: &mut dyn Transport,
    nodes: &Nodes,
    halo: &mut Ghosts,
) -> Result<(), RankLost> {
    let me = nodes.me;
    let mut users: Vec<Vec<u32>> = vec![Vec::new(); nodes.len()];
    for link in &halo.links {
        let own = |i: &&u32| nodes.is_owned(**i as usize);
        let with = link.shared.iter().filter(own).chain(&link.export);
        with.for_each(|&i| users[i as usize].push(link.worker as u32));
    }
    let mut parcels = vec![Mailbox::default(); comm.size() - 1];
    let mut partners = vec![false; comm.size() - 1];
    for link in &halo.links {
        let lists = [&link.shared, &link.export, &link.import];
        partners[link.worker] = lists.iter().any(|list| !list.is_empty());
    }
    for (i, list) in users.iter_mut().enumerate() {
        list.sort_unstable();
        list.dedup();
        for &to in list.iter() {
            let mail = &mut parcels[to as usize];
            mail.push(nodes.id[i]);
            mail.push(list.len() as u64);
            let others = list.iter().filter(|&&u| u != to).chain(std::iter::once(&me));
            others.for_each(|&u| mail.push(u64::from(u)));
        }
    }
    let parcels = parcels.into_iter().map(Mailbox::into_words).collect();
    let parcels = exchange_with(comm, parcels, &partners)?;
    for (from, words) in parcels.into_iter().enumerate().filter(|(w, _)| *w != me as usize) {
        let mut mail = Mailbox::from_words(words);
        while !mail.is_read() {
            let (id, count): (NodeId, u64) = (mail.take(), mail.take());
            let i = nodes
                .index_of(id)
                .unwrap_or_else(|| panic!("worker {from} names a node that is not local"));
            users[i as usize] =
                mail.take_many::<u64>(count as usize).iter().map(|&u| u as u32).collect();
            users[i as usize].sort_unstable();
        }
    }
    (halo.users, halo.user_start) = (Vec::new(), vec![0]);
    for list in &users {
        halo.users.extend(list);
        halo.user_start.push(halo.users.len() as u32);
    }
    for link in &mut halo.links {
        link.shares_nodes = users.iter().any(|l| l.contains(&(link.worker as u32)));
    }
    Ok(())
}
