//! Converts `*CONSTRAINED_LINEAR_GLOBAL` and `..._LOCAL`, linear equations between displacements of
//! nodes, as far as they hold nodes or let them move alike; and `*CONSTRAINED_TIED_NODES_FAILURE`,
//! coincident nodes that move alike.

use super::DeckConverter;
use super::sets::id;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::{BTreeMap, HashMap};

const LINEAR: [&str; 2] = ["CONSTRAINED_LINEAR_GLOBAL", "CONSTRAINED_LINEAR_LOCAL"];
/// Value above which a failure strain means no failure.
const NEVER: f64 = 1e19;
/// Names of the degrees of freedom 1 to 6.
const DOFS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
/// Bits of all displacements, and of all rotations.
const DISPLACEMENTS: u8 = 0b111;
const ROTATIONS: u8 = 0b11_1000;

/// Degrees of freedom that two nodes have in common, with a card that says so.
#[derive(Debug)]
struct CommonMotion {
    dofs: u8,
    record: CardRecord,
}

/// A term of an equation: node, degree of freedom from 0, coefficient, system of axes.
type LinearTerm = (NodeId, usize, f64, i64);

impl DeckConverter {
    /// Converts linear equations. Those of one node hold it; those of two nodes that say that all
    /// of their displacements are equal tie one to the other.
    pub(super) fn linear_equations(&mut self) {
        // By nodes, the lower one first, and system.
        let mut pairs: BTreeMap<(NodeId, NodeId, i64), CommonMotion> = BTreeMap::new();
        let mut held: BTreeMap<usize, (Vec<NodeId>, Place)> = BTreeMap::new();
        for record in self.take_in_order(&LINEAR) {
            let Some(terms) = self.terms(&record) else { continue };
            match terms[..] {
                [] => {}
                [(node, dof, _, cid)] if self.is_plain(cid) => {
                    let of = held.entry(dof).or_insert_with(|| (Vec::new(), record.place("nid")));
                    of.0.push(node);
                }
                [(a, dof, p, cid), (b, other, q, other_cid)]
                    if dof == other && p == -q && cid == other_cid && a != b =>
                {
                    let cid = if self.is_plain(cid) { 0 } else { cid };
                    let pair = (a.min(b), a.max(b), cid);
                    let common =
                        pairs.entry(pair).or_insert_with(|| CommonMotion { dofs: 0, record });
                    common.dofs |= 1 << dof;
                }
                _ => {
                    let why = "an equation is supported if it holds one node, or lets two nodes \
                               have the same displacement";
                    self.unsupported_card(&record, "nid", why);
                }
            }
        }
        for (dof, (nodes, place)) in held {
            self.fix_nodes("linear", vec![DOFS[dof]], nodes, place);
        }
        self.common_motions(pairs, ("linear", "nid"));
    }

    /// Returns the terms of an equation with a coefficient other than 0.
    fn terms(&mut self, record: &CardRecord) -> Option<Vec<LinearTerm>> {
        let mut terms = Vec::new();
        for line in record.lines("nid") {
            let dof = line.integer("dof");
            let place = line.place("dof");
            let Some(node) = id(line.integer("nid")) else {
                let message = format!("{}: a term has no node", record.name());
                self.trouble.error(line.place("nid"), message, "give the id of a node, above 0");
                return None;
            };
            if !(1..=6).contains(&dof) {
                let message = format!("{}: a term has `dof` {dof}", record.name());
                let help = "give 1 to 3 for displacements and 4 to 6 for rotations of a node";
                self.trouble.error(place, message, help);
                return None;
            }
            let coefficient = line.real("coef");
            if coefficient != 0.0 {
                terms.push((node, dof as usize - 1, coefficient, line.integer("cid")));
            }
        }
        Some(terms)
    }

    /// Ties nodes that have all displacements in common. Chains of them follow one node. The sets
    /// are named after `what`; `field` of the cards has their nodes.
    fn common_motions(
        &mut self,
        pairs: BTreeMap<(NodeId, NodeId, i64), CommonMotion>,
        (what, field): (&str, &str),
    ) {
        let mut leaders: HashMap<NodeId, NodeId> = HashMap::new();
        let leader = |leaders: &HashMap<NodeId, NodeId>, mut node: NodeId| {
            while let Some(&next) = leaders.get(&node) {
                node = next;
            }
            node
        };
        let mut rotations: BTreeMap<NodeId, bool> = BTreeMap::new();
        let mut places: BTreeMap<NodeId, (usize, Place)> = BTreeMap::new();
        for ((a, b, _), CommonMotion { dofs, record }) in pairs {
            let turning = dofs & ROTATIONS;
            if dofs & DISPLACEMENTS != DISPLACEMENTS || (turning != 0 && turning != ROTATIONS) {
                let named: Vec<&str> =
                    (0..6).filter(|dof| dofs & 1 << dof != 0).map(|dof| DOFS[dof]).collect();
                let why = format!(
                    "nodes {a} and {b} have only {} in common: a tie is one of all displacements, \
                     with all rotations or none",
                    named.join(", ")
                );
                self.unsupported_card(&record, field, &why);
                continue;
            }
            let (one, other) = (leader(&leaders, a), leader(&leaders, b));
            let known = [one, other]
                .iter()
                .any(|node| rotations.get(node).is_some_and(|turns| *turns != (turning != 0)));
            if known {
                let why = "a chain of nodes of which only some have rotations in common";
                self.unsupported_card(&record, field, why);
                continue;
            }
            let (low, high) = (one.min(other), one.max(other));
            if low != high {
                leaders.insert(high, low);
            }
            for node in [a, b] {
                rotations.insert(node, turning != 0);
                places.entry(node).or_insert((record.block, record.place(field)));
            }
        }
        let mut groups: BTreeMap<NodeId, Vec<NodeId>> = BTreeMap::new();
        for &node in rotations.keys() {
            let first = leader(&leaders, node);
            if first != node {
                groups.entry(first).or_default().push(node);
            }
        }
        for (first, others) in groups {
            let turns = rotations[&first];
            self.tie_to_node(first, others, turns, places[&first], what);
        }
    }

    /// Ties nodes to another one.
    fn tie_to_node(
        &mut self,
        first: NodeId,
        others: Vec<NodeId>,
        turns: bool,
        (block, place): (usize, Place),
        what: &str,
    ) {
        let set = format!("{what}-{}", first.0);
        self.rows.add_set(set.clone(), others, place);
        let carrier = i64::try_from(first.0).unwrap_or(i64::MAX);
        let mut table = JobTable::new(place).with("nodes", place, set).with("node", place, carrier);
        if turns {
            table.put("rotations", place, true);
        }
        self.add_tie(block, table);
    }

    /// Converts coincident nodes that move alike.
    pub(super) fn coincident_nodes(&mut self) {
        let mut pairs: BTreeMap<(NodeId, NodeId, i64), CommonMotion> = BTreeMap::new();
        for record in self.take_records("CONSTRAINED_TIED_NODES_FAILURE") {
            let (nsid, place) = (record.integer("nsid"), record.place("nsid"));
            let strain = record.real("eppf");
            if strain > 0.0 && strain < NEVER {
                let why = "ties that fail by the plastic strain of their elements";
                self.unsupported_value(&record, "eppf", why);
            }
            if self.node_set(nsid, place).is_none() {
                continue;
            }
            let mut at: BTreeMap<[u64; 3], Vec<NodeId>> = BTreeMap::new();
            for node in self.node_sets[&nsid].0.clone() {
                if let Some(x) = self.rows.at(node) {
                    at.entry(x.map(|c| (c + 0.0).to_bits())).or_default().push(node);
                }
            }
            let (mut count, mut alone) = (0, 0);
            for mut nodes in at.into_values() {
                nodes.sort_unstable();
                nodes.dedup();
                if nodes.len() < 2 {
                    alone += 1;
                    continue;
                }
                count += nodes.len() - 1;
                let turns = if record.integer("etype") == 0 { ROTATIONS } else { 0 };
                for &node in &nodes[1..] {
                    let motion =
                        CommonMotion { dofs: DISPLACEMENTS | turns, record: record.clone() };
                    pairs.insert((nodes[0], node, 0), motion);
                }
            }
            if alone > 0 {
                let message = format!(
                    "{} {nsid}: {alone} of its nodes have no other one at exactly their place, \
                     and stay free",
                    record.name()
                );
                let help = "give nodes that move alike the same coordinates, or tie them by a \
                            *CONTACT_TIED_NODES_TO_SURFACE";
                self.trouble.warning(place, message, help);
            }
            self.map(
                format!("{} {nsid}", record.name()),
                "coincident nodes that move alike",
                format!("{count} nodes tied to others at their places"),
            );
        }
        self.common_motions(pairs, ("coincident", "nsid"));
    }
}
