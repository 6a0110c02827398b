//! The quarters of divided shells with their histories, and the new nodes, in the partition of a
//! worker; the same for the mesh at the start, when a run continues.

use super::Adaptivity;
use super::division::{Formulations, NumberedDivision};
use super::pair_histories::hand_over;
use crate::parallel::history_message::{put_histories, take_histories};
use crate::parallel::partition::PartitionData;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::partition::{ElementRecord, NodeRecord, Settings};
use crumple_proto::transport::{Mailbox, RankLost, Transport, gather_all};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// Sends all workers the records and the pair histories of the nodes in `wanted` that this worker
/// owns, and adds those of the others to the partition.
///
/// # Errors
/// A worker is gone.
pub(crate) fn publish(
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

/// Returns a node with the mean state of those between which it lies, without mass. `fixed` are
/// its fixed degrees of freedom.
fn mean_of(id: NodeId, fixed: u64, of: &[&NodeRecord]) -> NodeRecord {
    let mean = |get: &dyn Fn(&NodeRecord) -> [f64; 3]| {
        [0, 1, 2].map(|c| of.iter().map(|n| get(n)[c]).sum::<f64>() / of.len() as f64)
    };
    NodeRecord {
        id,
        fixed,
        x0: mean(&|n| n.x0),
        x: mean(&|n| n.x),
        seen: mean(&|n| n.seen),
        v: mean(&|n| n.v),
        w: mean(&|n| n.w),
        mass: 0.0,
        inertia: 0.0,
    }
}

impl Adaptivity {
    /// Replaces the divided shells of this partition by their quarters, and makes the new nodes.
    pub(crate) fn divide(
        &self,
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
            self.make_nodes(division, &mut records);
            for corner in 0..4 {
                let x = division.nodes_of(corner).map(|n| records[&n].x0);
                let (history, energies) = columns.split_at(columns.len() - 2);
                let quarter = formulations.of(e.part).quarter(history, corner, &x, e.own);
                let mut quarter = quarter.expect("only quads are divided");
                // The quarters share the energies of the shell.
                quarter.extend(energies.iter().map(|energy| 0.25 * energy));
                quarters.push((division.quarter_of(e, corner), quarter));
            }
            false
        });
        share.elements.extend(quarters);
        // Others have published nodes that this worker does not need.
        let used: HashSet<NodeId> = share.elements.iter().flat_map(|(e, _)| e.nodes).collect();
        share.nodes = records.into_values().filter(|n| used.contains(&n.id)).collect();
        share.memories.retain(|id, _| used.contains(id));
        hand_over(&mut share.memories, &by_id);
    }

    /// Makes the new nodes of a division that are not there yet.
    fn make_nodes(&self, division: &NumberedDivision, records: &mut BTreeMap<NodeId, NodeRecord>) {
        for (id, between) in division.made() {
            if !records.contains_key(&id) {
                let of: Vec<&NodeRecord> = between.iter().map(|n| &records[n]).collect();
                let fixed = of.iter().fold(u64::MAX, |all, n| all & self.held(n));
                let new = mean_of(id, fixed, &of);
                records.insert(id, new);
            }
        }
    }

    /// Divides elements of the mesh at the start as those of the run were.
    ///
    /// # Errors
    /// The mesh does not have them: the reason.
    pub fn divide_at_start(
        &self,
        elements: &mut Vec<ElementRecord>,
        nodes: &mut Vec<NodeRecord>,
    ) -> Result<(), String> {
        let mut all: BTreeMap<ElemId, ElementRecord> =
            elements.drain(..).map(|e| (e.id, e)).collect();
        let mut records: BTreeMap<NodeId, NodeRecord> =
            nodes.drain(..).map(|n| (n.id, n)).collect();
        for division in &self.divisions {
            let id = division.of.id;
            let whole = all.remove(&id).filter(|e| e.nodes[..4] == division.of.nodes);
            let whole = whole.ok_or_else(|| format!("the job has no element {id} to divide"))?;
            self.make_nodes(division, &mut records);
            let quarters = (0..4).map(|corner| division.quarter_of(&whole, corner));
            all.extend(quarters.map(|e| (e.id, e)));
        }
        elements.extend(all.into_values());
        nodes.extend(records.into_values());
        Ok(())
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
