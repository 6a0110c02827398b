//! Partition of the mesh: from a worker's elements to its local mesh, its links and its ghosts.
//!
//! The same path is taken at the start and whenever boxes are renewed. Workers exchange data
//! with each other only.

use crate::contact::surface::{ContactParts, OwnScales, Segment, Surface};
use crate::fem::blocks::{Blocks, Class, LocalElement, RemoteCorner};
use crate::fem::elements::build_block;
use crate::math::row::xyz;
use crate::math::threads;
use crate::nodes::{Nodes, OuterStepMean};
use crate::parallel::boxes::{ClassCounts, WorkerBoxes, half_width};
use crate::parallel::contact_decomposition::SearchRegions;
use crate::parallel::ghost_segments::{copy_ghosts, covered, exchange_bounds, send_users};
use crate::parallel::ghosts::{GhostLink, Ghosts};
use crate::parallel::history_message::Memories;
use crate::parallel::volumes::VolumeLinks;
use crate::time::ElementSet;
use bytemuck::{Pod, Zeroable};
use crumple_proto::boxes::{Aabb, CutTree};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::Shape;
use crumple_proto::partition::{ElementRecord, NodeRecord, Settings};
use crumple_proto::transport::{RankLost, Transport, exchange_with, gather_all};
use std::collections::{BTreeSet, HashSet};

/// Least number of elements of which a thread looks up the nodes at a time.
const PIECE: usize = 1024;

/// Data of one worker, as distributed at the start or migrated.
#[derive(Default)]
pub struct PartitionData {
    /// Elements with their history columns (empty if fresh).
    pub elements: Vec<(ElementRecord, Vec<f64>)>,
    /// All nodes of these elements; duplicates are possible.
    pub nodes: Vec<NodeRecord>,
    /// Pair histories of nodes; duplicates are possible.
    pub memories: Memories,
    /// Mean translational and rotational velocities of nodes in the outer step; duplicates are
    /// possible. Empty without subcycles.
    pub means: Vec<OuterStepMean>,
}

impl PartitionData {
    /// Removes the elements of some parts, and the nodes that no other element has.
    pub fn remove_parts(&mut self, parts: &[u32]) {
        self.elements.retain(|(e, _)| !parts.contains(&e.part));
        let used: BTreeSet<NodeId> = self.elements.iter().flat_map(|(e, _)| e.nodes).collect();
        self.nodes.retain(|n| used.contains(&n.id));
        self.memories.retain(|id, _| used.contains(id));
        self.means.retain(|m| used.contains(&m.id));
    }
}

/// Local mesh and links of a worker.
pub struct LocalMesh {
    /// Nodal columns.
    pub nodes: Nodes,
    /// Own elements.
    pub blocks: Blocks,
    /// Links to other workers.
    pub halo: Ghosts,
    /// Contact surface, if the model has contact.
    pub surface: Option<Surface>,
    /// Boxes of this worker.
    pub boxes: WorkerBoxes,
    /// Numbers of elements and nodes by class.
    pub classes: ClassCounts,
    /// Pair histories of local nodes and, if a worker searches for nodes of others, of ghosts.
    pub memories: Memories,
}

/// Cuts of the decomposition.
#[derive(Clone, Copy)]
pub struct Cuts<'a> {
    /// Boxes of all workers: the partition has the elements whose centres lie in the box of the
    /// worker. With a second decomposition this holds at the start, and the boxes are not used.
    pub boxes: &'a CutTree,
    /// Last cuts of the second decomposition, if there were any.
    pub contact: Option<&'a CutTree>,
}

/// Element corner at a shared node, as it is sent to the other worker.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct WireCorner {
    node: NodeId,
    elem: ElemId,
    /// Half thickness and scale of the sender's surface at the node, see
    /// [`Surface::include_remote`].
    half: f64,
    scale: f64,
    slow: u64,
    /// See [`VolumeLinks::mark`].
    averages: u64,
}

/// Builds a worker's local mesh from its partition. With `fresh`, nodal masses are assembled from
/// the elements. Collective.
///
/// # Errors
/// A worker is gone.
pub fn build_local_mesh(
    comm: &mut dyn Transport,
    settings: &Settings,
    cuts: Cuts<'_>,
    share: PartitionData,
    fresh: bool,
) -> Result<LocalMesh, RankLost> {
    let me = comm.rank() - 1;
    let mut records = share.nodes;
    records.sort_unstable_by_key(|r| r.id);
    records.dedup_by_key(|r| r.id);
    let mut nodes = Nodes::new(&records, me as u32, settings.rotations);
    let bounds = Aabb::around(records.iter().map(|r| r.x));
    drop(records); // the columns contain all of it
    let all_bounds = exchange_bounds(comm, &bounds)?;
    let shared = find_shared(comm, &nodes, &all_bounds)?;
    for (worker, list) in shared.iter().enumerate() {
        list.iter()
            .for_each(|&i| nodes.owner[i as usize] = nodes.owner[i as usize].min(worker as u32));
    }
    let mut is_shared = vec![false; nodes.local_count];
    shared.iter().flatten().for_each(|&i| is_shared[i as usize] = true);
    let local_nodes = threads::collect(share.elements.len(), PIECE, |i| {
        let local = |n| nodes.local_index(n).expect("a partition has all nodes of its elements");
        share.elements[i].0.nodes.map(local)
    });
    let elements = share.elements.into_iter().zip(local_nodes).map(|((record, history), local)| {
        (
            LocalElement {
                record,
                nodes: local,
                shared: local.iter().any(|&n| is_shared[n as usize]),
                class: Class::Interface,
            },
            history,
        )
    });
    let mut elements: Vec<(LocalElement, Vec<f64>)> = elements.collect();
    let parts = ContactParts::from_settings(settings);
    let own = || elements.iter().map(|e| &e.0);
    let mut surface = settings.contact.as_ref().map(|_| Surface::new(own(), &nodes, &parts));
    let exposes = surface.is_some() && solids_can_fail(comm, settings, own())?;
    if let Some(surface) = surface.as_mut().filter(|_| exposes) {
        surface.include_hidden(own(), &nodes, &parts);
    }
    let around = match &mut surface {
        Some(surface) => {
            let largest = share_scales(comm, surface, 0)?.0;
            covered(settings, surface, largest, exposes)
        }
        None => 0.5 * settings.buffer,
    };
    let regions = match &surface {
        Some(surface) if settings.has_second_decomposition() => {
            Some(SearchRegions::new(comm, cuts.contact, surface, &nodes)?)
        }
        _ => None,
    };
    let mut boxes = match &regions {
        Some(regions) => WorkerBoxes::new(&regions.tree, me, around),
        None => WorkerBoxes::new(cuts.boxes, me, half_width(cuts.boxes, &all_bounds, around)),
    };
    let copied = match (&regions, &surface) {
        (Some(regions), Some(surface)) => {
            copied_elements(&regions.seeking, surface, &nodes, around)
        }
        _ => HashSet::new(),
    };
    let mut classes = ClassCounts::default();
    for (e, _) in &mut elements {
        let is_interior = match &regions {
            Some(_) => !e.shared && !copied.contains(&e.record.id),
            None => boxes.is_interior(&Aabb::around(e.nodes.map(|n| xyz(&nodes.x[n as usize])))),
        };
        if is_interior {
            e.class = Class::Interior;
            classes.interior += 1;
        } else {
            classes.interface += 1;
        }
    }
    let mut blocks = Blocks::new(settings, elements);
    let mut halo =
        link_element_forces(comm, settings, &mut blocks, &nodes, &shared, surface.as_mut())?;
    if fresh {
        blocks.measure(&nodes);
        blocks.set_initial(&nodes, &settings.initial);
        blocks.set_corner_masses(&nodes, |_| true);
        halo.send_element_forces(comm, &blocks, ElementSet::All)?;
        halo.recv_element_forces(comm, &mut blocks, ElementSet::All)?;
        blocks.assemble_masses(&mut nodes);
    }
    let mut memories = share.memories;
    halo.regions = regions;
    if let Some(surface) = &mut surface {
        surface.collect_slaves(&nodes);
        let local = (&mut nodes, &mut halo, &mut *surface, &mut memories);
        boxes.external = copy_ghosts(comm, settings, local, &all_bounds, around)?;
        if let Some(regions) = &halo.regions {
            surface.collect_slaves_in(&nodes, |x| regions.tree.worker_of(x) == me);
        }
        send_users(comm, &nodes, &mut halo)?;
        classes.count_exterior(surface, &nodes);
    }
    Ok(LocalMesh { nodes, blocks, halo, surface, boxes, classes, memories })
}

/// Returns the own elements that other workers get as ghosts: those with a segment within the
/// distance `grow` [length] of the contact entities for which another worker searches.
fn copied_elements(
    seeking: &[Aabb],
    surface: &Surface,
    nodes: &Nodes,
    grow: f64,
) -> HashSet<ElemId> {
    let me = nodes.me as usize;
    let of_others = seeking.iter().enumerate().filter(|&(w, b)| w != me && !b.is_empty());
    let others: Vec<Aabb> = of_others.map(|(_, b)| b.grown(grow)).collect();
    let is_copied = |s: &&Segment| {
        let bounds = s.bounds(&nodes.x, 0.0);
        others.iter().any(|b| b.intersects(&bounds))
    };
    surface.segments.iter().filter(is_copied).map(|s| s.id.elem()).collect()
}

/// Returns true if solids can fail on any worker, so that solids behind them come to the surface
/// between two renewals. All workers call this together.
fn solids_can_fail<'a>(
    comm: &mut dyn Transport,
    settings: &Settings,
    mut elements: impl Iterator<Item = &'a LocalElement>,
) -> Result<bool, RankLost> {
    let is_solid = |shape: &Shape| shape.is_solid();
    let can_fail = |part| {
        let solids = Shape::ALL.into_iter().filter(is_solid);
        solids.filter_map(|shape| build_block(settings, part, shape).ok()).any(|e| e.can_fail())
    };
    let fallible: Vec<bool> = (0..settings.parts.len()).map(can_fail).collect();
    // The second decomposition is renewed with its ghosts after each failure.
    if settings.has_second_decomposition() || !fallible.contains(&true) {
        return Ok(false);
    }
    let here = elements.any(|e| e.record.shape.is_solid() && fallible[e.record.part as usize]);
    Ok(gather_all(comm, vec![u64::from(here)])?.iter().any(|w| w[0] == 1))
}

/// Agrees on the scales and offsets of all surfaces. Returns the largest scale of any worker's
/// surface [length] and the largest `count` of any worker.
///
/// # Errors
/// A worker is gone.
pub(super) fn share_scales(
    comm: &mut dyn Transport,
    surface: &mut Surface,
    count: usize,
) -> Result<(f64, usize), RankLost> {
    let OwnScales { largest, smallest, short, offset, longest, diameter } = surface.own_scales;
    let own = [largest, smallest, short, offset, longest, diameter, count as f64];
    let scales = gather_all(comm, vec![own])?;
    let of_all = |i: usize| scales.iter().map(move |w| w[0][i]);
    surface.thinnest = surface.interfaces.least(of_all(1).fold(f64::INFINITY, f64::min));
    surface.short = of_all(2).fold(f64::INFINITY, f64::min);
    let most = |i: usize| of_all(i).fold(0.0, f64::max);
    surface.largest_offset = most(3);
    (surface.longest_side, surface.diameter) = (most(4), most(5));
    Ok((most(0), most(6) as usize))
}

/// Returns the local nodes that each other worker has as well, ascending.
fn find_shared(
    comm: &mut dyn Transport,
    nodes: &Nodes,
    bounds: &[Aabb],
) -> Result<Vec<Vec<u32>>, RankLost> {
    let me = nodes.me as usize;
    // A shared node lies in both boxes.
    let offered = |b: &Aabb| {
        (0..nodes.local_count)
            .filter(|&i| b.contains(xyz(&nodes.x[i])))
            .map(|i| nodes.id[i])
            .collect()
    };
    let is_near = |b: &Aabb| b.intersects(&bounds[me]);
    let near: Vec<bool> = bounds.iter().map(is_near).collect();
    let others = exchange_with(comm, bounds.iter().map(offered).collect(), &near)?;
    let common = |w: &Vec<NodeId>| w.iter().filter_map(|&id| nodes.local_index(id)).collect();
    Ok(others
        .iter()
        .enumerate()
        .map(|(w, ids)| if w == me { Vec::new() } else { common(ids) })
        .collect())
}

/// Builds the links with their element nodal forces, and the order of the nodal assembly.
fn link_element_forces(
    comm: &mut dyn Transport,
    settings: &Settings,
    blocks: &mut Blocks,
    nodes: &Nodes,
    shared: &[Vec<u32>],
    surface: Option<&mut Surface>,
) -> Result<Ghosts, RankLost> {
    let me = nodes.me as usize;
    let slots = blocks.first_slots();
    let mut volumes = VolumeLinks::new(blocks);
    let mut corners: Vec<(ElemId, usize, u32, u32, bool)> = Vec::new();
    for (e, slot) in blocks.elements.iter().zip(slots).filter(|(e, _)| e.shared) {
        let corner = |c: usize| (e.record.id, c, e.nodes[c], (slot + c) as u32, e.record.slow);
        corners.extend((0..e.record.shape.corners()).map(corner));
    }
    corners.sort_unstable_by_key(|c| (c.0, c.1));
    let mut links = Vec::new();
    let mut parcels = Vec::new();
    for (worker, list) in shared.iter().enumerate() {
        let at_shared: Vec<_> =
            corners.iter().filter(|c| list.binary_search(&c.2).is_ok()).collect();
        let reach = |n: u32| {
            surface
                .as_ref()
                .map_or((0.0, 0.0), |s| (s.node_half[n as usize], s.node_scale[n as usize]))
        };
        let wired = |c: &&(ElemId, usize, u32, u32, bool)| {
            let (half, scale) = reach(c.2);
            WireCorner {
                node: nodes.id[c.2 as usize],
                elem: c.0,
                half,
                scale,
                slow: u64::from(c.4),
                averages: volumes.mark(c.0),
            }
        };
        parcels.push(at_shared.iter().map(wired).collect::<Vec<WireCorner>>());
        let fast_out =
            at_shared.iter().filter(|c| settings.subcycles > 1 && !c.4).map(|c| c.3).collect();
        links.push(GhostLink {
            worker,
            shared: list.clone(),
            widths: vec![[0.0; 2]; list.len()],
            element_forces_out: at_shared.iter().map(|c| c.3).collect(),
            fast_out,
            ..GhostLink::default()
        });
    }
    let sharing: Vec<bool> = shared.iter().map(|list| !list.is_empty()).collect();
    let others = exchange_with(comm, parcels, &sharing)?;
    let mut foreign = Vec::new();
    for (link, theirs) in links.iter_mut().zip(&others).filter(|(l, _)| l.worker != me) {
        let local = |c: &WireCorner| nodes.local_index(c.node).expect("shared nodes are local");
        let is_shared =
            |c: &&(ElemId, usize, u32, u32, bool)| link.shared.binary_search(&c.2).is_ok();
        let mine = corners.iter().filter(is_shared).map(|c| c.0);
        volumes.add(link.worker, mine, theirs.iter().map(|c| (c.elem, c.averages, local(c))));
        link.element_forces_in = (blocks.own_slots() + foreign.len(), theirs.len());
        for c in theirs {
            let node = local(c);
            let slow = c.slow != 0;
            if settings.subcycles > 1 && !slow {
                link.fast_in.push((blocks.own_slots() + foreign.len()) as u32);
            }
            foreign.push(RemoteCorner { node, elem: c.elem, slow });
            let place = link.shared.binary_search(&node).expect("a corner at a shared node");
            link.widths[place] = [c.half, c.scale];
        }
    }
    if let Some(surface) = surface {
        links.iter().for_each(|link| include_widths(surface, link));
    }
    blocks.build_assembly(nodes.local_count, &foreign, |id| settings.loads.presses(id));
    links.retain(|l| l.worker != me);
    let mut ghosts = Ghosts::new(links);
    ghosts.volumes = volumes.finish(blocks);
    Ok(ghosts)
}

/// Raises the half thickness and scale of shared nodes to those of the other worker's surface.
pub(super) fn include_widths(surface: &mut Surface, link: &GhostLink) {
    for (&node, &[half, scale]) in link.shared.iter().zip(&link.widths) {
        surface.include_remote(node, half, scale);
    }
}
