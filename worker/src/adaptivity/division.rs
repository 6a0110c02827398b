//! Division of shells: the ids of new elements and nodes, their records, masses and histories.

use super::marks::sides;
use super::{Adaptivity, Middle, Side, side};
use crate::contact::pairs::PairKey;
use crate::fem::elements::{Element, build_block};
use crate::parallel::history_message::{Memories, put_histories, take_histories};
use crate::parallel::partition::PartitionData;
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::{ElemId, NodeId, SegmentId};
use crumple_proto::mesh::Shape;
use crumple_proto::partition::{ElementRecord, NodeRecord, Settings};
use crumple_proto::transport::{Mailbox, RankLost, Transport, gather_all};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// Division of a shell, as its worker sends it to all others.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub(super) struct Division {
    id: ElemId,
    nodes: [NodeId; 4],
    /// Mass and rotational inertia of the shell at each corner [mass], [mass length^2].
    whole: [f64; 2],
    /// The same of its quarters.
    quarters: [[f64; 2]; 4],
}

/// A division with its new ids.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct NumberedDivision {
    pub of: Division,
    /// Ids of the quarters at the corners.
    pub quarters: [ElemId; 4],
    /// Nodes in the middle of the sides 0-1, 1-2, 2-3, 3-0.
    pub middles: [NodeId; 4],
    pub centre: NodeId,
}

impl NumberedDivision {
    /// Returns the new nodes, each with those between which it lies. Nodes that another division
    /// made too, or made before, are among them.
    pub fn made(&self) -> impl Iterator<Item = (NodeId, Vec<NodeId>)> {
        let ends = |k: usize| vec![self.of.nodes[k], self.of.nodes[(k + 1) % 4]];
        let middles = (0..4).map(move |k| (self.middles[k], ends(k)));
        middles.chain([(self.centre, self.of.nodes.to_vec())])
    }

    /// Returns the quarter of the shell at a corner.
    fn quarter_of(&self, whole: &ElementRecord, corner: usize) -> ElementRecord {
        let nodes = self.nodes_of(corner);
        ElementRecord {
            id: self.quarters[corner],
            nodes: std::array::from_fn(|c| nodes[c.min(3)]),
            ..*whole
        }
    }

    /// Returns the nodes of the quarter at a corner, in the order of the corners of the shell, so
    /// that its axes are those of the shell.
    fn nodes_of(&self, corner: usize) -> [NodeId; 4] {
        let ([a, b, c, d], [ab, bc, cd, da]) = (self.of.nodes, self.middles);
        let m = self.centre;
        [[a, ab, m, da], [ab, b, bc, m], [m, bc, c, cd], [da, m, cd, d]][corner]
    }
}

/// Returns the corners of the quarter of a quad at one of its corners [length].
fn quarter_of_quad(x: &[[f64; 3]; 4], corner: usize) -> [[f64; 3]; 4] {
    let mean = |of: &[usize]| {
        [0, 1, 2].map(|c| of.iter().map(|&k| x[k][c]).sum::<f64>() / of.len() as f64)
    };
    let all = [0, 1, 2, 3];
    match corner {
        0 => [x[0], mean(&[0, 1]), mean(&all), mean(&[0, 3])],
        1 => [mean(&[0, 1]), x[1], mean(&[1, 2]), mean(&all)],
        2 => [mean(&all), mean(&[1, 2]), x[2], mean(&[2, 3])],
        _ => [mean(&[0, 3]), mean(&all), mean(&[2, 3]), x[3]],
    }
}

/// The formulations of the parts of divided shells.
pub(super) struct Formulations<'a> {
    settings: &'a Settings,
    built: HashMap<u32, Box<dyn Element>>,
}

impl<'a> Formulations<'a> {
    pub fn new(settings: &'a Settings) -> Self {
        Self { settings, built: HashMap::new() }
    }

    fn of(&mut self, part: u32) -> &dyn Element {
        let settings = self.settings;
        &**self.built.entry(part).or_insert_with(|| {
            let built = build_block(settings, part as usize, Shape::Quad4);
            built.unwrap_or_else(|problems| panic!("part {part} was built before: {problems:?}"))
        })
    }

    /// Returns the smallest stable step of the quarters of a shell with its slots at `x` [time]. It
    /// is that at the present shape and the mass of the start of a shell of that shape, and so an
    /// estimate.
    pub fn step_of_quarters(&mut self, e: &ElementRecord, x: &[[f64; 3]]) -> f64 {
        let corners = std::array::from_fn(|c| x[c]);
        let element = self.of(e.part);
        let steps = (0..4).map(|k| element.stable_dt(&quarter_of_quad(&corners, k), e.own));
        steps.fold(f64::INFINITY, f64::min) * (e.mass_factor * e.share).sqrt()
    }

    /// Returns the division of a shell with its corners at `x` at the start.
    pub fn division(&mut self, e: &ElementRecord, x: &[[f64; 3]; 4]) -> Division {
        let element = self.of(e.part);
        let at = |x: &[[f64; 3]; 4]| {
            let (mass, inertia) = element.corner_mass(x, e.own);
            [mass * e.mass_factor, inertia * e.mass_factor]
        };
        Division {
            id: e.id,
            nodes: std::array::from_fn(|c| e.nodes[c]),
            whole: at(x),
            quarters: std::array::from_fn(|corner| at(&quarter_of_quad(x, corner))),
        }
    }
}

/// Returns the divisions of all workers, sorted by element.
///
/// # Errors
/// A worker is gone.
pub(super) fn gather(
    comm: &mut dyn Transport,
    own: Vec<Division>,
) -> Result<Vec<Division>, RankLost> {
    let mut all = gather_all(comm, own)?.concat();
    all.sort_unstable_by_key(|d| d.id);
    Ok(all)
}

impl Adaptivity {
    /// Gives the new elements and nodes of divisions after a cycle their ids.
    pub(super) fn number(&mut self, divisions: &[Division], cycle: u64) -> Vec<NumberedDivision> {
        let mut numbered = Vec::with_capacity(divisions.len());
        for (&of, count) in divisions.iter().zip(self.divided()..) {
            let level = self.level(of.id) + 1;
            let first = self.settings.first.0.after(4 * count);
            let quarters: [ElemId; 4] = std::array::from_fn(|k| first.after(k as u64));
            self.levels.remove(&of.id);
            self.levels.extend(quarters.map(|id| (id, level)));
            let middles = std::array::from_fn(|k| self.middle(of.nodes[k], of.nodes[(k + 1) % 4]));
            numbered.push(NumberedDivision { of, quarters, middles, centre: self.new_node() });
        }
        self.divisions.extend(&numbered);
        self.cycles += cycle * numbered.len() as u64;
        numbered
    }

    fn new_node(&mut self) -> NodeId {
        self.made += 1;
        self.settings.first.1.after(self.made - 1)
    }

    /// Returns the node in the middle of a side; makes it if there is none.
    fn middle(&mut self, a: NodeId, b: NodeId) -> NodeId {
        let side = side(a, b);
        if let Some(&middle) = self.of_sides.get(&side) {
            return middle;
        }
        let id = self.new_node();
        self.of_sides.insert(side, id);
        self.middles.insert(id, Middle { side, mass: [0.0; 2], follows: Vec::new() });
        if self.led.contains(&side) {
            self.led.extend([[side[0], id], [side[1], id]]);
        }
        id
    }

    /// Returns what divisions add to the masses and inertias of nodes, and adds it to those of the
    /// nodes in the middle of sides.
    pub(super) fn add_masses(
        &mut self,
        divisions: &[NumberedDivision],
    ) -> BTreeMap<NodeId, [f64; 2]> {
        let mut added: BTreeMap<NodeId, [f64; 2]> = BTreeMap::new();
        let mut add = |node: NodeId, factor: f64, mass: [f64; 2]| {
            let sum = added.entry(node).or_default();
            (0..2).for_each(|k| sum[k] += factor * mass[k]);
        };
        for d in divisions {
            d.of.nodes.iter().for_each(|&n| add(n, -1.0, d.of.whole));
            for (corner, &mass) in d.of.quarters.iter().enumerate() {
                d.nodes_of(corner).iter().for_each(|&n| add(n, 1.0, mass));
            }
        }
        for (node, mass) in &added {
            if let Some(middle) = self.middles.get_mut(node) {
                (0..2).for_each(|k| middle.mass[k] += mass[k]);
            }
        }
        added
    }
}

/// Sends all workers the records and the pair histories of the nodes in `wanted` that this worker
/// owns, and adds those of the others to the partition.
///
/// # Errors
/// A worker is gone.
pub(super) fn publish(
    comm: &mut dyn Transport,
    share: &mut PartitionData,
    wanted: &BTreeSet<NodeId>,
    owned: impl Fn(NodeId) -> bool,
) -> Result<(), RankLost> {
    let is_wanted = |n: &&NodeRecord| wanted.contains(&n.id) && owned(n.id);
    let mut mail = Mailbox::default();
    for node in share.nodes.iter().filter(is_wanted) {
        mail.push(*node);
        put_histories(&mut mail, node.id, share.memories.get(&node.id).map_or(&[], Vec::as_slice));
    }
    let mut present: HashSet<NodeId> = share.nodes.iter().map(|n| n.id).collect();
    for words in gather_all(comm, mail.into_words())? {
        let mut mail = Mailbox::from_words(words);
        while !mail.is_read() {
            let node: NodeRecord = mail.take();
            let (id, histories) = take_histories(&mut mail).expect("workers send whole messages");
            if present.insert(id) {
                share.nodes.push(node);
                if !histories.is_empty() {
                    share.memories.insert(id, histories);
                }
            }
        }
    }
    Ok(())
}

impl Adaptivity {
    /// Divides elements of the mesh at the start as those of the run were.
    pub fn divide_at_start(&self, elements: &mut Vec<ElementRecord>, nodes: &mut Vec<NodeRecord>) {
        let mut all: BTreeMap<ElemId, ElementRecord> =
            elements.drain(..).map(|e| (e.id, e)).collect();
        let mut records: BTreeMap<NodeId, NodeRecord> =
            nodes.drain(..).map(|n| (n.id, n)).collect();
        for division in &self.divisions {
            let Some(whole) = all.remove(&division.of.id) else { continue };
            if !division.of.nodes.iter().all(|n| records.contains_key(n)) {
                continue;
            }
            make_nodes(division, &mut records);
            let quarters = (0..4).map(|corner| division.quarter_of(&whole, corner));
            all.extend(quarters.map(|e| (e.id, e)));
        }
        elements.extend(all.into_values());
        nodes.extend(records.into_values());
    }

    /// Adds hanging nodes to the ties of the job, and new nodes to the sets of its walls.
    pub fn extend(&self, settings: &mut Settings) {
        settings.ties.extend(self.ties().into_iter().map(|added| added.tie));
        settings.ties.sort_by_key(|tie| tie.node);
        for (new, between) in self.divisions.iter().flat_map(NumberedDivision::made) {
            settings.walls.iter_mut().for_each(|wall| wall.inherit(new, &between));
        }
    }
}

/// Returns the node with the mean state of others, without mass.
fn mean_of(id: NodeId, of: &[&NodeRecord]) -> NodeRecord {
    let mean = |get: &dyn Fn(&NodeRecord) -> [f64; 3]| {
        [0, 1, 2].map(|c| of.iter().map(|n| get(n)[c]).sum::<f64>() / of.len() as f64)
    };
    NodeRecord {
        id,
        fixed: of.iter().fold(u64::MAX, |all, n| all & n.fixed),
        x0: mean(&|n| n.x0),
        x: mean(&|n| n.x),
        seen: mean(&|n| n.seen),
        v: mean(&|n| n.v),
        w: mean(&|n| n.w),
        mass: 0.0,
        inertia: 0.0,
    }
}

/// Replaces the divided shells of this partition by their quarters, and makes the new nodes.
pub(super) fn divide(
    share: &mut PartitionData,
    divisions: &[NumberedDivision],
    formulations: &mut Formulations<'_>,
) {
    let by_id: HashMap<ElemId, &NumberedDivision> =
        divisions.iter().map(|d| (d.of.id, d)).collect();
    let mut records: BTreeMap<NodeId, NodeRecord> =
        share.nodes.drain(..).map(|n| (n.id, n)).collect();
    let mut quarters = Vec::new();
    share.elements.retain(|(e, columns)| {
        let Some(division) = by_id.get(&e.id) else { return true };
        make_nodes(division, &mut records);
        for corner in 0..4 {
            let nodes = division.nodes_of(corner);
            let x = nodes.map(|n| records[&n].x0);
            let (history, energies) = columns.split_at(columns.len() - 2);
            let element = formulations.of(e.part);
            let mut quarter =
                element.quarter(history, corner, &x, e.own).expect("parts with quads are divided");
            // The quarters share the energies of the shell.
            quarter.extend(energies.iter().map(|energy| 0.25 * energy));
            quarters.push((division.quarter_of(e, corner), quarter));
        }
        false
    });
    share.elements.extend(quarters);
    share.nodes = records.into_values().collect();
    hand_over(&mut share.memories, &by_id);
}

fn make_nodes(division: &NumberedDivision, records: &mut BTreeMap<NodeId, NodeRecord>) {
    let ends: [Side; 4] =
        std::array::from_fn(|k| side(division.of.nodes[k], division.of.nodes[(k + 1) % 4]));
    for (id, ends) in division.middles.into_iter().zip(ends) {
        if !records.contains_key(&id) {
            let of = ends.map(|n| &records[&n]);
            let new = mean_of(id, &of);
            records.insert(id, new);
        }
    }
    let new = mean_of(division.centre, &division.of.nodes.map(|n| &records[&n]));
    records.insert(division.centre, new);
}

/// Gives the pair histories of nodes with divided shells to the quarters of these. The quarters lie
/// on the surface of the shell, so that the side and the penetration remain.
fn hand_over(memories: &mut Memories, by_id: &HashMap<ElemId, &NumberedDivision>) {
    for (&node, list) in memories.iter_mut() {
        let division = |segment: u64| by_id.get(&SegmentId(segment).elem());
        let is_stale = list.iter().any(|h| {
            let name = &h.name;
            name.is_node() && division(name.target[0]).is_some()
                || name.is_segment()
                    && [name.slave.0, name.target[0]].into_iter().any(|s| division(s).is_some())
        });
        if !is_stale {
            continue;
        }
        let mut new = Vec::with_capacity(list.len() + 3);
        for history in list.drain(..) {
            let name = &history.name;
            if name.is_node() {
                match division(name.target[0]) {
                    Some(d) => new.extend(d.quarters.map(|quarter| {
                        let name = PairKey::of_node(node, SegmentId::new(quarter, 0));
                        crate::contact::pairs::PairHistory { name, ..history }
                    })),
                    None => new.push(history),
                }
            } else if !name.is_segment()
                || [name.slave.0, name.target[0]].into_iter().all(|s| division(s).is_none())
            {
                new.push(history);
            }
        }
        new.sort_unstable_by_key(|h| h.name);
        *list = new;
    }
}

/// Returns the nodes in the middle of the sides of these divisions that existed before, given
/// whether a side had one.
pub(super) fn known_middles(known: &Adaptivity, divisions: &[Division]) -> BTreeSet<NodeId> {
    let of = |d: &Division| {
        let nodes = std::array::from_fn(|c| d.nodes[c.min(3)]);
        sides(&nodes)
    };
    divisions.iter().flat_map(of).filter_map(|s| known.of_sides.get(&s).copied()).collect()
}
