//! Converts sets of nodes and of parts.

use super::DeckConverter;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::{BTreeMap, BTreeSet};

/// Sets of elements: keyword, keyword with ranges, and field of a cross section that names the
/// set.
pub const ELEMENT_SETS: [(&str, &str, &str); 3] = [
    ("SET_SOLID", "SET_SOLID_GENERATE", "hsid"),
    ("SET_SHELL_LIST", "SET_SHELL_LIST_GENERATE", "ssid"),
    ("SET_DISCRETE", "SET_DISCRETE_GENERATE", "dsid"),
];
/// Index of sets of shells in [`ELEMENT_SETS`].
pub const SHELL_SETS: usize = 1;

/// Elements of sets by id: ranges from the first to the last id.
pub type ElementSets = BTreeMap<i64, Vec<[i64; 2]>>;

impl DeckConverter {
    /// Reads the sets of elements, in the order of [`ELEMENT_SETS`].
    pub(super) fn read_element_sets(&mut self) {
        self.element_sets = ELEMENT_SETS.map(|(list, ranges, _)| {
            let mut sets = ElementSets::new();
            for record in self.take_records(list) {
                let own = ids(&record, "id").into_iter().map(|(e, _)| [e, e]);
                sets.entry(record.integer("sid")).or_default().extend(own);
            }
            for record in self.take_records(ranges) {
                let ends: Vec<i64> = ids(&record, "id").into_iter().map(|e| e.0).collect();
                let own = ends.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
                sets.entry(record.integer("sid")).or_default().extend(own);
            }
            sets
        });
    }

    pub(super) fn sets(&mut self) {
        self.part_lists();
        for record in self.take_records("SET_NODE_LIST") {
            let ids = ids(&record, "id");
            self.add_node_set(&record, ids);
        }
        for record in self.take_records("SET_NODE_COLUMN") {
            let ids = ids(&record, "nid");
            self.add_node_set(&record, ids);
        }
        for record in self.take_records("SET_NODE_LIST_GENERATE") {
            let ranges = ids(&record, "id");
            let known: BTreeSet<u64> = self.rows.nodes.iter().map(|n| n.id.0).collect();
            let mut nodes = Vec::new();
            for pair in ranges.chunks(2) {
                let (Some(from), Some(to)) = (id(pair[0].0), pair.get(1).and_then(|p| id(p.0)))
                else {
                    let message = format!("{}: a range has no last id", record.name());
                    self.trouble.error(
                        pair[0].1,
                        message,
                        "give the first and the last id of each range",
                    );
                    continue;
                };
                if from.0 <= to.0 {
                    nodes.extend(known.range(from.0..=to.0).map(|&n| (n as i64, pair[0].1)));
                }
            }
            self.add_node_set(&record, nodes);
        }
        for record in self.take_records("SET_NODE_GENERAL") {
            let nodes = self.general(&record);
            self.keep_nodes(&record, nodes);
        }
        // Sets of sets may name those that come later.
        let adding = self.take_records("SET_NODE_ADD");
        for _ in 0..=adding.len() {
            for record in &adding {
                let mut nodes: BTreeSet<NodeId> = BTreeSet::new();
                for (other, _) in ids(record, "id") {
                    nodes.extend(self.node_sets.get(&other).into_iter().flat_map(|s| &s.0));
                }
                self.node_sets.insert(
                    record.integer("sid"),
                    (nodes.into_iter().collect(), record.place("sid")),
                );
            }
        }
        for record in &adding {
            for (other, place) in ids(record, "id") {
                self.node_set(other, place);
            }
            self.named(record);
        }
    }

    fn part_lists(&mut self) {
        for record in self.take_records("SET_PART_LIST") {
            self.part_sets.insert(record.integer("sid"), ids(&record, "id"));
        }
        for record in self.take_records("SET_PART_LIST_GENERATE") {
            let ranges = ids(&record, "id");
            let mut parts = Vec::new();
            for pair in ranges.chunks(2) {
                let (from, to) = (pair[0].0, pair.get(1).map_or(pair[0].0, |p| p.0));
                let within = self.parts.range(from.min(to)..=to).map(|(&id, _)| (id, pair[0].1));
                parts.extend(within);
            }
            self.part_sets.insert(record.integer("sid"), parts);
        }
        let adding = self.take_records("SET_PART_ADD");
        for _ in 0..=adding.len() {
            for record in &adding {
                let others = ids(record, "id");
                let mut parts: Vec<(i64, Place)> = others
                    .iter()
                    .filter_map(|(o, _)| self.part_sets.get(o))
                    .flatten()
                    .copied()
                    .collect();
                parts.sort_by_key(|p| p.0);
                parts.dedup_by_key(|p| p.0);
                self.part_sets.insert(record.integer("sid"), parts);
            }
        }
    }

    /// Adds a node set given by ids.
    fn add_node_set(&mut self, record: &CardRecord, ids: Vec<(i64, Place)>) {
        let nodes = ids.into_iter().filter_map(|(n, place)| {
            let found = id(n);
            if found.is_none() {
                let message = format!("{}: {n} is not a node id", record.name());
                self.trouble.error(place, message, "give whole numbers above 0");
            }
            found
        });
        let nodes: Vec<NodeId> = nodes.collect();
        self.keep_nodes(record, nodes);
    }

    fn keep_nodes(&mut self, record: &CardRecord, mut nodes: Vec<NodeId>) {
        nodes.sort_unstable();
        nodes.dedup();
        let (sid, place) = (record.integer("sid"), record.place("sid"));
        if self.node_sets.insert(sid, (nodes, place)).is_some() {
            self.trouble.error(
                place,
                format!("there are two node sets with the id {sid}"),
                "give each a different id",
            );
        }
        self.named(record);
    }

    /// Adds the set under its title too.
    fn named(&mut self, record: &CardRecord) {
        let title = record.word("heading").to_string();
        if let (false, Some((nodes, place))) =
            (title.is_empty(), self.node_sets.get(&record.integer("sid")))
        {
            match record.in_submodel {
                // The file may be included several times.
                true => drop(self.rows.add_new_set(&title, nodes.clone(), *place)),
                false => {
                    self.rows.add_set(title.clone(), nodes.clone(), *place);
                    self.node_set_titles.insert(record.integer("sid"), title);
                }
            }
        }
    }

    fn general(&mut self, record: &CardRecord) -> Vec<NodeId> {
        let mut nodes: BTreeSet<NodeId> = BTreeSet::new();
        let lines: Vec<_> = record.lines("option").cloned().collect();
        for line in lines {
            let word = line.word("option").to_ascii_uppercase();
            let (word, away) = match word.strip_prefix('D') {
                Some(rest) if ["NODE", "PART", "BOX", "SET_NODE", "SET_PART"].contains(&rest) => {
                    (rest.to_string(), true)
                }
                _ => (word, false),
            };
            let own: Vec<(i64, Place)> = line.integers("e").collect();
            let mut found: Vec<NodeId> = Vec::new();
            match word.as_str() {
                "ALL" => found.extend(self.rows.nodes.iter().map(|n| n.id)),
                "NODE" => found.extend(own.iter().filter_map(|n| id(n.0))),
                "PART" => {
                    let parts: Vec<i64> =
                        own.iter().filter(|p| self.has_part(p.0, p.1)).map(|p| p.0).collect();
                    found = self.rows.nodes_of(|part| parts.contains(&i64::from(part)));
                }
                "SET_PART" => {
                    let parts: Vec<i64> =
                        own.iter().flat_map(|p| self.part_set(p.0, p.1)).collect();
                    found = self.rows.nodes_of(|part| parts.contains(&i64::from(part)));
                }
                "SET_NODE" => {
                    for (other, place) in own {
                        if self.node_set(other, place).is_some() {
                            found.extend(&self.node_sets[&other].0);
                        }
                    }
                }
                "BOX" => own.iter().for_each(|b| found.extend(self.in_box(b.0, b.1))),
                _ => {
                    let message = format!("*SET_NODE_GENERAL: option {word} is not supported");
                    self.unsupported(
                        line.place("option"),
                        message,
                        format!("*SET_NODE_GENERAL {word}"),
                    );
                }
            }
            match away {
                true => nodes.retain(|n| !found.contains(n)),
                false => nodes.extend(found),
            }
        }
        nodes.into_iter().collect()
    }

    /// Returns the nodes in a box, including its faces.
    pub(super) fn in_box(&mut self, id: i64, place: Place) -> Vec<NodeId> {
        let Some(sides) = self.boxes.get(&id) else {
            let known: Vec<String> = self.boxes.keys().map(i64::to_string).collect();
            self.missing(place, "*DEFINE_BOX", id, &known);
            return Vec::new();
        };
        let inside = |x: &[f64; 3]| (0..3).all(|c| sides[c][0] <= x[c] && x[c] <= sides[c][1]);
        self.rows.nodes.iter().filter(|n| inside(&n.x)).map(|n| n.id).collect()
    }
}

/// Returns all ids of a list with their places.
pub fn ids(record: &CardRecord, name: &str) -> Vec<(i64, Place)> {
    record.lines(name).flat_map(|line| line.integers(name).collect::<Vec<_>>()).collect()
}

/// Returns the id of a node, if the number is valid.
pub fn id(n: i64) -> Option<NodeId> {
    u64::try_from(n).ok().filter(|&n| n > 0).map(NodeId)
}
