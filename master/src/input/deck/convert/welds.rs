//! Converts `*CONSTRAINED_SPOTWELD` and `*CONSTRAINED_GENERALIZED_WELD_SPOT`, rigid or as beams
//! that fail, `*CONSTRAINED_SHELL_TO_SOLID`, and `*CONSTRAINED_NODE_SET`: nodes with the same
//! displacements.

use super::DeckConverter;
use super::parts::DeckPart;
use super::sets::id;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::ids::{ElemId, NodeId};
use std::collections::{BTreeMap, BTreeSet};

/// Bits of limits and exponents, and the material. Welds with the same ones form one part.
type WeldKey = ([u64; 4], String);

/// Welds of one kind; they get ids and lengths later.
struct Breaking {
    limits: [f64; 4],
    links: Vec<([NodeId; 2], Place)>,
}

/// Value above which failure strains and times of a deck mean no failure.
const NEVER: f64 = 1e19;
/// Exponent for blanks.
const SQUARE: f64 = 2.0;

impl DeckConverter {
    pub(super) fn welds(&mut self) {
        let mut bodies: Vec<(BTreeSet<NodeId>, Place)> = Vec::new();
        let mut breaking: BTreeMap<WeldKey, Breaking> = BTreeMap::new();
        for record in self.take_records("CONSTRAINED_SPOTWELD") {
            let place = record.place("n1");
            let [Some(n1), Some(n2)] = ["n1", "n2"].map(|field| id(record.integer(field))) else {
                let message = format!("{}: a node has an invalid id", record.name());
                self.trouble.error(place, message, "give whole numbers above 0");
                continue;
            };
            self.never_fails(&record, "tf", "ep");
            self.weld(&record, vec![n1, n2], place, &mut bodies, &mut breaking);
        }
        for record in self.take_records("CONSTRAINED_GENERALIZED_WELD_SPOT") {
            let (nsid, place) = (record.integer("nsid"), record.place("nsid"));
            self.never_fails(&record, "tfail", "epsf");
            if self.node_set(nsid, place).is_some() {
                let nodes = self.node_sets[&nsid].0.clone();
                self.weld(&record, nodes, place, &mut bodies, &mut breaking);
            }
        }
        for record in self.take_records("CONSTRAINED_SHELL_TO_SOLID") {
            let (nsid, place) = (record.integer("nsid"), record.place("nsid"));
            let Some(node) = id(record.integer("nid")) else {
                let message = format!("{}: `nid` is no id of a node", record.name());
                self.trouble.error(record.place("nid"), message, "give the node of the shell");
                continue;
            };
            if self.node_set(nsid, place).is_some() {
                let mut nodes: BTreeSet<NodeId> = self.node_sets[&nsid].0.iter().copied().collect();
                nodes.insert(node);
                self.map(
                    format!("{}: node {node}", record.name()),
                    "a node of a shell on a fibre of nodes of solids",
                    "a rigid body: the fibre turns with the shell and keeps its length",
                );
                bodies.push((nodes, place));
            }
        }
        self.rigid_welds(bodies);
        self.breaking_welds(breaking);
    }

    /// Converts sets of nodes that have the displacements of their first node.
    pub(super) fn node_sets_as_one(&mut self) {
        for record in self.take_records("CONSTRAINED_NODE_SET") {
            let (nsid, place) = (record.integer("nsid"), record.place("nsid"));
            if record.integer("dof") != 7 {
                self.unsupported_card(&record, "dof", "use 7 (all displacements)");
                continue;
            }
            if record.real("tf") > 0.0 && record.real("tf") < self.end_time {
                self.unsupported_value(&record, "tf", "constraints that fail at a given time");
            }
            if self.node_set(nsid, place).is_none() {
                continue;
            }
            let mut nodes = self.node_sets[&nsid].0.clone();
            nodes.sort_unstable();
            nodes.dedup();
            let Some((first, others)) = nodes.split_first() else { continue };
            let set = format!("set-{nsid}-but-one");
            let count = others.len();
            self.rows.add_set(set.clone(), others.to_vec(), place);
            let carrier = i64::try_from(first.0).unwrap_or(i64::MAX);
            let table = JobTable::new(place).with("nodes", place, set).with("node", place, carrier);
            self.add_tie(record.block, table);
            self.map(
                format!("set {nsid}"),
                "nodes that share displacements",
                format!("{count} tied to node {carrier}"),
            );
        }
    }

    /// Notes that failure at a time or by a strain is not supported.
    fn never_fails(&mut self, record: &CardRecord, time: &str, strain: &str) {
        if record.real(time) > 0.0 && record.real(time) < self.end_time {
            self.unsupported_value(record, time, "welds that fail at a given time");
        }
        if record.real(strain) > 0.0 && record.real(strain) < NEVER {
            self.unsupported_value(
                record,
                strain,
                "welds that fail by the strain of the joined parts",
            );
        }
    }

    fn weld(
        &mut self,
        record: &CardRecord,
        nodes: Vec<NodeId>,
        place: Place,
        bodies: &mut Vec<(BTreeSet<NodeId>, Place)>,
        breaking: &mut BTreeMap<WeldKey, Breaking>,
    ) {
        let limits = ["sn", "ss"].map(|field| record.real(field));
        if limits.iter().all(|&limit| limit <= 0.0 || limit > NEVER) {
            return bodies.push((nodes.into_iter().collect(), place));
        }
        let &[n1, n2] = nodes.as_slice() else {
            return self.unsupported_card(record, "sn", "only welds of two nodes break");
        };
        let element = self.rows.elements().find(|e| e.corners().contains(&n1));
        let part = element.and_then(|e| self.parts.get(&i64::from(e.part)));
        let Some(material) = part.and_then(|p| p.material.clone()) else {
            let message = format!("{}: no part with a material has node {n1}", record.name());
            return self.trouble.error(
                place,
                message,
                "put its first node in a part with a material: a weld that breaks takes that \
                 material",
            );
        };
        let exponents = ["n", "m"]
            .map(|field| if record.real(field) > 0.0 { record.real(field) } else { SQUARE });
        let limits = [limits[0].max(0.0), limits[1].max(0.0), exponents[0], exponents[1]];
        let of = breaking
            .entry((limits.map(f64::to_bits), material))
            .or_insert_with(|| Breaking { limits, links: Vec::new() });
        of.links.push(([n1, n2], place));
    }

    /// Adds bodies of the nodes of welds. Those with common nodes are one body.
    fn rigid_welds(&mut self, welds: Vec<(BTreeSet<NodeId>, Place)>) {
        let mut whole: Vec<(BTreeSet<NodeId>, Place)> = Vec::new();
        for (mut nodes, place) in welds {
            whole.retain(|(other, _)| {
                let apart = other.is_disjoint(&nodes);
                if !apart {
                    nodes.extend(other);
                }
                apart
            });
            whole.push((nodes, place));
        }
        if !whole.is_empty() {
            self.map(
                "welds",
                "rigid links between nodes",
                format!("{} rigid bodies of their nodes", whole.len()),
            );
        }
        for (number, (nodes, place)) in whole.into_iter().enumerate() {
            let name = format!("weld-{}", number + 1);
            self.rows.add_set(name.clone(), nodes.into_iter().collect(), place);
            self.add(
                "rigid",
                JobTable::new(place).with("name", place, name.as_str()).with(
                    "nodes",
                    place,
                    name.as_str(),
                ),
            );
        }
    }

    /// Adds a part of beams for each kind.
    fn breaking_welds(&mut self, kinds: BTreeMap<WeldKey, Breaking>) {
        let mut next = self.largest_element();
        for ((_, material), Breaking { limits, links }) in kinds {
            let place = links[0].1;
            let Some(part) = self.free_part(place) else { continue };
            let pid = i64::from(part);
            let mut lengths = 0.0;
            for (ends, at) in &links {
                next += 1;
                self.rows.beam(ElemId(next), part, [ends[0], ends[1], NodeId(0)], *at);
                let [from, to] = ends.map(|n| self.rows.at(n).unwrap_or_default());
                lengths += (0..3).map(|c| (to[c] - from[c]).powi(2)).sum::<f64>().sqrt();
            }
            let diameter = lengths / links.len() as f64;
            let [normal, shear, n, m] = limits;
            let weld = JobTable::new(place)
                .with("normal", place, normal)
                .with("shear", place, shear)
                .with("exponents", place, [n, m]);
            let beam = JobTable::new(place)
                .with("section", place, "tube")
                .with("radius", place, 0.5 * diameter)
                .with("weld", place, weld);
            let name = format!("welds-{pid}");
            let table = JobTable::new(place)
                .with("id", place, pid)
                .with("name", place, name)
                .with("material", place, material.as_str())
                .with("beam", place, beam);
            self.parts.insert(
                pid,
                DeckPart { rigid: None, material: Some(material), inertia: None, place },
            );
            self.round_parts.insert(part);
            self.welded_parts.insert(part);
            self.map(
                format!("part {pid}"),
                format!("{} spot welds, sn {normal}, ss {shear}", links.len()),
                format!("beams of diameter {diameter:.4}, their mean length, that break"),
            );
            self.add("part", table);
        }
    }
}
