//! Hanging nodes: nodes in the middle of a side that belongs to a shell that is not divided, and in
//! the middle of its halves, and nodes between nodes of one prescribed motion. They are tied to the
//! nodes between which they lie. One of these that hangs itself is replaced by what it follows.

use super::{Adaptivity, NewNode, ShellSide, marks, side};
use crate::constraints::ties::AddedTie;
use crate::parallel::partition::PartitionData;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::{CornerNodes, Shape};
use crumple_proto::partition::NodeRecord;
use crumple_proto::tie::Tie;
use crumple_proto::transport::{RankLost, Transport, gather_all};
use std::collections::{BTreeMap, BTreeSet};

/// Returns the nodes that hang, on all workers, for the elements of this partition.
///
/// # Errors
/// A worker is gone.
pub(crate) fn find(
    comm: &mut dyn Transport,
    known: &Adaptivity,
    share: &PartitionData,
) -> Result<BTreeSet<NodeId>, RankLost> {
    let shells = share.elements.iter().filter(|(e, _)| !e.failed && e.shape.is_shell());
    let mut open: Vec<ShellSide> = shells.flat_map(|(e, _)| sides_of(e.shape, &e.nodes)).collect();
    let mut own = BTreeSet::new();
    while let Some(whole) = open.pop() {
        if let Some(&middle) = known.of_sides.get(&whole) {
            own.insert(middle);
            open.extend(whole.map(|end| side(end, middle)));
        }
    }
    let mut all: BTreeSet<NodeId> =
        gather_all(comm, own.into_iter().collect())?.into_iter().flatten().collect();
    let led = known.nodes.iter().filter(|(_, node)| known.are_led(&node.between));
    all.extend(led.map(|(&id, _)| id));
    Ok(all)
}

fn sides_of(shape: Shape, nodes: &CornerNodes) -> Vec<ShellSide> {
    match shape {
        Shape::Tri3 => (0..3).map(|k| side(nodes[k], nodes[(k + 1) % 3])).collect(),
        _ => marks::sides(nodes).to_vec(),
    }
}

impl Adaptivity {
    /// Removes the masses of all hanging nodes from the nodes that they follow. Records have their
    /// own masses after it.
    pub(crate) fn take_back(&self, records: &mut [NodeRecord]) {
        self.move_masses(records, -1.0);
    }

    /// Gives the masses of hanging nodes to the nodes that they follow.
    pub(crate) fn give(&self, records: &mut [NodeRecord]) {
        self.move_masses(records, 1.0);
    }

    fn move_masses(&self, records: &mut [NodeRecord], factor: f64) {
        let mut given: BTreeMap<NodeId, Vec<(f64, [f64; 2])>> = BTreeMap::new();
        for node in self.nodes.values() {
            for &(master, weight) in &node.follows {
                given.entry(master).or_default().push((weight, node.mass));
            }
        }
        for record in records {
            for (weight, [mass, inertia]) in given.get(&record.id).into_iter().flatten() {
                record.mass += factor * weight * mass;
                record.inertia += factor * weight * inertia;
            }
            if let Some(node) = self.nodes.get(&record.id).filter(|n| !n.follows.is_empty()) {
                let own = if factor < 0.0 { node.mass } else { [0.0; 2] };
                [record.mass, record.inertia] = own;
            }
        }
    }

    /// Sets which nodes hang, and what they follow.
    pub(crate) fn hang(&mut self, hanging: &BTreeSet<NodeId>) {
        let weights: Vec<_> = self.nodes.keys().map(|&id| self.weights(id, hanging)).collect();
        for (node, follows) in self.nodes.values_mut().zip(weights) {
            node.follows = follows;
        }
    }

    /// Returns the nodes that a node follows, ascending, with their weights; none if it is free.
    fn weights(&self, id: NodeId, hanging: &BTreeSet<NodeId>) -> Vec<(NodeId, f64)> {
        if !hanging.contains(&id) {
            return Vec::new();
        }
        let mut sums: BTreeMap<NodeId, f64> = BTreeMap::new();
        let mut open = vec![(id, 1.0)];
        while let Some((node, weight)) = open.pop() {
            match self.nodes.get(&node).filter(|_| hanging.contains(&node)) {
                Some(NewNode { between, .. }) => {
                    let share = weight / between.len() as f64;
                    open.extend(between.iter().map(|&end| (end, share)));
                }
                None => *sums.entry(node).or_default() += weight,
            }
        }
        sums.into_iter().collect()
    }

    /// Returns the ties of all hanging nodes, ascending.
    pub(crate) fn ties(&self) -> Vec<AddedTie> {
        let hanging = self.nodes.iter().filter(|(_, node)| !node.follows.is_empty());
        let tie = |(&id, node): (&NodeId, &NewNode)| AddedTie {
            tie: Tie {
                node: id,
                masters: node.follows.clone(),
                near: Vec::new(),
                faces: Vec::new(),
                rotations: true,
                offset: false,
                mean: false,
                failure: None,
            },
            mass: node.mass,
        };
        hanging.map(tie).collect()
    }

    /// Returns true if a division has made the node.
    pub(crate) fn has_made(&self, node: NodeId) -> bool {
        self.nodes.contains_key(&node)
    }
}
