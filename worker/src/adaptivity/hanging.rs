//! Hanging nodes: nodes in the middle of a side that belongs to a shell that is not divided. They
//! are tied to the ends of the side. An end that hangs itself is replaced by the nodes that it
//! follows.

use super::{Adaptivity, marks};
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
pub(super) fn find(
    comm: &mut dyn Transport,
    known: &Adaptivity,
    share: &PartitionData,
) -> Result<BTreeSet<NodeId>, RankLost> {
    let shells = share.elements.iter().filter(|(e, _)| !e.failed && e.shape.is_shell());
    let sides = shells.flat_map(|(e, _)| sides_of(e.shape, &e.nodes));
    let own: BTreeSet<NodeId> = sides.filter_map(|s| known.of_sides.get(&s).copied()).collect();
    let mut all: BTreeSet<NodeId> =
        gather_all(comm, own.into_iter().collect())?.into_iter().flatten().collect();
    all.extend(known.led.iter().filter_map(|side| known.of_sides.get(side)));
    Ok(all)
}

fn sides_of(shape: Shape, nodes: &CornerNodes) -> Vec<super::Side> {
    match shape {
        Shape::Tri3 => (0..3).map(|k| super::side(nodes[k], nodes[(k + 1) % 3])).collect(),
        _ => marks::sides(nodes).to_vec(),
    }
}

impl Adaptivity {
    /// Removes the masses of all hanging nodes from the nodes that they follow. Records have their
    /// own masses after it.
    pub(super) fn take_back(&self, records: &mut [NodeRecord]) {
        self.move_masses(records, -1.0);
    }

    /// Gives the masses of hanging nodes to the nodes that they follow.
    pub(super) fn give(&self, records: &mut [NodeRecord]) {
        self.move_masses(records, 1.0);
    }

    fn move_masses(&self, records: &mut [NodeRecord], factor: f64) {
        let mut given: BTreeMap<NodeId, Vec<(f64, [f64; 2])>> = BTreeMap::new();
        let following = || self.middles.iter().filter(|(_, m)| !m.follows.is_empty());
        for (_, middle) in following() {
            for &(node, weight) in &middle.follows {
                given.entry(node).or_default().push((weight, middle.mass));
            }
        }
        for record in records {
            for (weight, [mass, inertia]) in given.get(&record.id).into_iter().flatten() {
                record.mass += factor * weight * mass;
                record.inertia += factor * weight * inertia;
            }
            if let Some(middle) = self.middles.get(&record.id).filter(|m| !m.follows.is_empty()) {
                let own = if factor < 0.0 { middle.mass } else { [0.0; 2] };
                [record.mass, record.inertia] = own;
            }
        }
    }

    /// Sets which nodes hang, and what they follow.
    pub(super) fn hang(&mut self, hanging: &BTreeSet<NodeId>) {
        let weights: Vec<(NodeId, Vec<(NodeId, f64)>)> =
            self.middles.keys().map(|&id| (id, self.weights(id, hanging))).collect();
        for (id, follows) in weights {
            self.middles.get_mut(&id).expect("its own key").follows = follows;
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
            match self.middles.get(&node).filter(|_| hanging.contains(&node)) {
                Some(middle) => open.extend(middle.side.map(|end| (end, 0.5 * weight))),
                None => *sums.entry(node).or_default() += weight,
            }
        }
        sums.into_iter().collect()
    }

    /// Returns the ties of all hanging nodes, ascending.
    pub(super) fn ties(&self) -> Vec<AddedTie> {
        let hanging = self.middles.iter().filter(|(_, middle)| !middle.follows.is_empty());
        let tie = |(&node, middle): (&NodeId, &super::Middle)| AddedTie {
            tie: Tie {
                node,
                masters: middle.follows.clone(),
                near: Vec::new(),
                faces: Vec::new(),
                rotations: true,
                offset: false,
                mean: false,
                failure: None,
            },
            mass: middle.mass,
        };
        hanging.map(tie).collect()
    }

    /// Returns true if the node is in the middle of a side.
    pub(super) fn is_middle(&self, node: NodeId) -> bool {
        self.middles.contains_key(&node)
    }
}
