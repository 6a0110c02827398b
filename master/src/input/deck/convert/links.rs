//! Nodes of rigid bodies that belong to no element: each that carries a mass, an inertia, a load or
//! a history, or that the direction of a spring follows, gets a spring without force to another
//! node of its body. With it, the node belongs to the mesh. The inertia of nodes,
//! `*ELEMENT_INERTIA`, is here, too.

use super::DeckConverter;
use super::parts::DeckPart;
use super::sets::{id, ids};
use super::springs::DeckDirection;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::ids::{ElemId, NodeId};
use std::collections::{BTreeMap, BTreeSet};

/// Keywords that give nodes something to carry, and their fields of nodes.
const LADEN_NODES: [(&str, &[&str]); 6] = [
    ("ELEMENT_MASS", &["nid"]),
    ("ELEMENT_INERTIA", &["nid"]),
    ("ELEMENT_SEATBELT_ACCELEROMETER", &["nid1", "nid2", "nid3"]),
    ("LOAD_NODE_POINT", &["nid"]),
    ("DATABASE_HISTORY_NODE", &["id"]),
    ("DATABASE_HISTORY_NODE_ID", &["id"]),
];

/// The same for fields of node sets.
const LADEN_SETS: [(&str, &str); 3] = [
    ("ELEMENT_MASS_NODE_SET", "nsid"),
    ("LOAD_NODE_SET", "nsid"),
    ("DATABASE_HISTORY_NODE_SET", "id"),
];

/// Rigid body of the deck: a rigid part with its extra nodes, or a set of nodes.
struct NodesOfBody {
    /// Part of its elements; `None` for a set of nodes.
    part: Option<i64>,
    nodes: Vec<NodeId>,
}

impl DeckConverter {
    /// Connects nodes without elements that carry something to their rigid body.
    pub(super) fn links(&mut self) {
        let connected: BTreeSet<NodeId> = self.rows.nodes_of(|_| true).into_iter().collect();
        let mut laden = self.laden_nodes(&connected);
        self.read_inertias();
        // Nodes of elements that are left out go with them.
        let lost = self.rows.lost_nodes();
        laden.retain(|node, _| !connected.contains(node) && !lost.contains(node));
        let Some(&place) = laden.values().next() else { return };
        let Some(part) = self.free_part(place) else { return };
        let (pid, mut next) = (i64::from(part), self.largest_element());
        let mut linked = Vec::new();
        for body in self.nodes_of_bodies() {
            for &node in &body.nodes {
                let Some(&place) = laden.get(&node) else { continue };
                let Some(other) = self.partner(node, &body, &connected) else { continue };
                next += 1;
                self.rows.spring(ElemId(next), part, [node, other], place);
                laden.remove(&node);
                linked.push((node, place));
            }
        }
        let Some(&(first, place)) = linked.first() else { return };
        self.parts.insert(pid, DeckPart { rigid: None, material: None, inertia: None, place });
        // A spring without a law would be an error.
        let no_force = vec![[-1.0, 0.0], [1.0, 0.0]];
        let spring = JobTable::new(place).with("force_elongation", place, no_force);
        let table = JobTable::new(place).with("id", place, pid).with("name", place, "links");
        self.add("part", table.with("spring", place, spring));
        self.map(
            "rigid bodies",
            format!("{} nodes without elements, the first is {first}", linked.len()),
            format!("springs without force connect them, part {pid} `links`"),
        );
    }

    /// Returns an id that no part and no body of nodes has. Reports at `place` if there is none.
    pub(super) fn free_part(&mut self, place: Place) -> Option<u32> {
        let bodies = self.records.get("CONSTRAINED_NODAL_RIGID_BODY").into_iter().flatten();
        let ids = bodies.map(|record| record.integer("pid")).chain(self.bodies.keys().copied());
        let of_elements = self.rows.elements().map(|e| i64::from(e.part));
        let most = ids.chain(of_elements).chain(self.parts.keys().copied()).max().unwrap_or(0);
        let free = u32::try_from(most.saturating_add(1)).ok();
        if free.is_none() {
            let help = "use smaller part ids: the springs or beams of this card need a part of \
                        their own, with an id up to 4294967295";
            self.trouble.error(place, "there is no id left for a part", help);
        }
        free
    }

    /// Returns the largest id of an element.
    pub(super) fn largest_element(&self) -> u64 {
        self.rows.elements().map(|e| e.id.0).max().unwrap_or(0)
    }

    /// Returns the nodes to which the deck gives a mass, an inertia, a load or a history, and those
    /// that directions of springs follow, with the place of one of these. Of a set only its nodes
    /// with elements count, if it has any.
    fn laden_nodes(&self, connected: &BTreeSet<NodeId>) -> BTreeMap<NodeId, Place> {
        let mut found = BTreeMap::new();
        let records = |keyword: &str| self.records.get(keyword).into_iter().flatten();
        for (keyword, fields) in LADEN_NODES {
            for (record, field) in records(keyword).flat_map(|r| fields.iter().map(move |f| (r, f)))
            {
                for (number, place) in numbers(record, field) {
                    found.extend(id(number).map(|node| (node, place)));
                }
            }
        }
        for (keyword, field) in LADEN_SETS {
            for (number, place) in records(keyword).flat_map(|record| numbers(record, field)) {
                let nodes = self.node_sets.get(&number).map_or(&[][..], |set| &set.0);
                if nodes.iter().all(|node| !connected.contains(node)) {
                    found.extend(nodes.iter().map(|&node| (node, place)));
                }
            }
        }
        for (direction, place) in self.spring_directions.values() {
            if let Some((DeckDirection::Nodes(nodes), _)) = direction {
                found.extend(nodes.map(|node| (NodeId(node), *place)));
            }
        }
        found
    }

    fn nodes_of_bodies(&self) -> Vec<NodesOfBody> {
        let records = |keyword: &str| self.records.get(keyword).into_iter().flatten();
        let of_set = |number: i64| self.node_sets.get(&number).map(|set| set.0.clone());
        let mut bodies = Vec::new();
        for record in records("CONSTRAINED_NODAL_RIGID_BODY") {
            let number = match record.integer("nsid") {
                0 => record.integer("pid"),
                given => given,
            };
            bodies.extend(of_set(number).map(|nodes| NodesOfBody { part: None, nodes }));
        }
        for record in records("CONSTRAINED_EXTRA_NODES_NODE") {
            for line in record.lines("pid") {
                let nodes = id(line.integer("nid")).into_iter().collect();
                bodies.push(NodesOfBody { part: Some(line.integer("pid")), nodes });
            }
        }
        for record in records("CONSTRAINED_EXTRA_NODES_SET") {
            for line in record.lines("pid") {
                let part = Some(line.integer("pid"));
                let nodes = of_set(line.integer("nsid"));
                bodies.extend(nodes.map(|nodes| NodesOfBody { part, nodes }));
            }
        }
        bodies
    }

    /// Returns a node of the body at another place than a node, one with an element if there is
    /// any. A spring has to have a length.
    fn partner(
        &mut self,
        node: NodeId,
        body: &NodesOfBody,
        connected: &BTreeSet<NodeId>,
    ) -> Option<NodeId> {
        let own = self.rows.at(node)?;
        // Two corners of an element are at different places.
        let element = self.rows.elements().find(|e| Some(i64::from(e.part)) == body.part);
        let corners = element.map_or(Vec::new(), |element| element.corners().to_vec());
        let (with, without): (Vec<NodeId>, Vec<NodeId>) =
            body.nodes.iter().copied().partition(|other| connected.contains(other));
        let mut all = corners.into_iter().chain(with).chain(without);
        all.find(|&other| self.rows.at(other).is_some_and(|x| x != own))
    }

    /// Reads `*ELEMENT_INERTIA`; its masses are `[[mass]]`.
    fn read_inertias(&mut self) {
        for record in self.take_records("ELEMENT_INERTIA") {
            let Some(node) = id(record.integer("nid")) else { continue };
            let place = record.place("nid");
            if record.integer("cid") != 0 {
                self.unsupported_card(&record, "cid", "inertia about local axes");
                continue;
            }
            if record.real("mass") != 0.0 {
                let set = self.rows.add_new_set(&format!("inertia-{node}"), vec![node], place);
                let table = JobTable::new(place).with("nodes", place, set);
                self.add("mass", table.with("mass", record.place("mass"), record.real("mass")));
            }
            let tensor = ["ixx", "iyy", "izz", "ixy", "iyz", "ixz"].map(|c| record.real(c));
            if tensor == [0.0; 6] {
                continue;
            }
            let sum = self.node_inertias.entry(node).or_insert(([0.0; 6], place));
            (0..6).for_each(|c| sum.0[c] += tensor[c]);
        }
    }

    /// Adds the inertias of its nodes to a body.
    pub(super) fn put_added_inertia(&mut self, nodes: &[NodeId], table: &mut JobTable) {
        let (mut sum, mut first) = ([0.0; 6], None);
        for (tensor, place) in nodes.iter().filter_map(|node| self.node_inertias.remove(node)) {
            first = first.or(Some(place));
            (0..6).for_each(|c| sum[c] += tensor[c]);
        }
        if let Some(place) = first {
            table.put("added_inertia", place, sum);
        }
    }

    /// Refuses inertias of nodes of no rigid body.
    pub(super) fn inertias_without_body(&mut self) {
        for (node, (_, place)) in std::mem::take(&mut self.node_inertias) {
            let message = format!(
                "*ELEMENT_INERTIA: node {node} belongs to no rigid body, for which an inertia is \
                 not supported"
            );
            self.unsupported(place, message, "*ELEMENT_INERTIA of a deformable part".into());
        }
    }
}

/// Returns the numbers in a field of all lines of a record.
fn numbers(record: &CardRecord, field: &str) -> Vec<(i64, Place)> {
    match field {
        "id" => ids(record, field),
        _ => record.lines(field).map(|line| (line.integer(field), line.place(field))).collect(),
    }
}
