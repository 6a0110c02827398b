//! Converts groups of nodes and elements.

use super::StarterConverter;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::ids::{ElemId, NodeId};
use std::collections::{BTreeMap, BTreeSet};

/// Keywords of groups of nodes.
const NODES: [&str; 10] = [
    "/GRNOD/NODE",
    "/GRNOD/PART",
    "/GRNOD/SUBSET",
    "/GRNOD/MAT",
    "/GRNOD/PROP",
    "/GRNOD/BOX",
    "/GRNOD/GENE",
    "/GRNOD/GRSHEL",
    "/GRNOD/SURF",
    "/GRNOD/GRNOD",
];
/// Kinds of groups of elements: the word in the name of a group, and that in `/GRNOD/...`.
const KINDS: [&str; 6] = ["GRSHEL", "GRSH3N", "GRBRIC", "GRBEAM", "GRTRUS", "GRSPRI"];

/// Returns the ids of a list with their places.
pub fn ids(record: &CardRecord) -> Vec<(i64, Place)> {
    record.lines("ids").flat_map(|line| line.integers("ids").collect::<Vec<_>>()).collect()
}

/// Returns the id of a node, if the number is valid.
pub fn node(n: i64) -> Option<NodeId> {
    u64::try_from(n).ok().filter(|&n| n > 0).map(NodeId)
}

/// Returns the kind of a group of elements in a name such as `/GRNOD/GRSHEL`.
pub fn kind_in(name: &str) -> Option<&'static str> {
    KINDS.into_iter().find(|kind| name.split('/').any(|word| word == *kind))
}

impl StarterConverter {
    /// Reads groups of elements: the nodes and the parts of their elements.
    pub(super) fn element_groups(&mut self) {
        for record in self.take(&["/GRSHEL/SHEL", "/GRSHEL/PART"]) {
            let Some(kind) = kind_in(&record.written) else { continue };
            let (id, list) = (record.integer("id"), ids(&record));
            let (mut nodes, mut parts) = (BTreeSet::new(), BTreeSet::new());
            if record.row.keyword.name == "/GRSHEL/PART" {
                parts.extend(list.iter().filter_map(|&(p, place)| self.part(p, place)));
                nodes.extend(self.nodes_of(&parts));
            } else {
                self.index_elements();
                for (element, place) in list {
                    let found = u64::try_from(element).ok().and_then(|e| {
                        Some(self.elements.get(&ElemId(e))?.iter().filter(|of| of.2 == kind))
                    });
                    let found: Vec<_> = found.into_iter().flatten().cloned().collect();
                    if found.is_empty() {
                        self.deck.missing(place, "element", element, &[]);
                    }
                    for (corners, part, _) in found {
                        if self.deck.is_left_out(part) {
                            continue;
                        }
                        nodes.extend(corners);
                        parts.insert(part);
                    }
                }
            }
            self.element_groups.insert((kind, id), (nodes, parts));
        }
    }

    /// Makes the index of elements by their ids as written.
    fn index_elements(&mut self) {
        if !self.elements.is_empty() {
            return;
        }
        use crumple_proto::mesh::Shape;
        let [solids, springs, beams] = self.deck.rows.raised;
        let [triangles, trusses] = self.raised;
        for element in self.deck.rows.elements().chain(&self.deck.rows.removed) {
            let (kind, raised) = match element.shape {
                Shape::Quad4 => ("GRSHEL", 0),
                Shape::Tri3 => ("GRSH3N", triangles),
                Shape::Line2 => ("GRSPRI", springs),
                Shape::Beam2 => ("GRBEAM", beams),
                Shape::Truss2 => ("GRTRUS", beams + trusses),
                _ => ("GRBRIC", solids),
            };
            let id = ElemId(element.id.0.saturating_sub(raised));
            let of = (element.corners().to_vec(), i64::from(element.part), kind);
            self.elements.entry(id).or_default().push(of);
        }
    }

    /// Returns the nodes of all elements of parts.
    pub(super) fn nodes_of(&self, parts: &BTreeSet<i64>) -> Vec<NodeId> {
        self.deck.rows.nodes_of(|part| parts.contains(&i64::from(part)))
    }

    /// Returns the parts that a list of parts, subsets, materials or properties means.
    pub(super) fn parts_by(&mut self, what: &str, list: &[(i64, Place)]) -> BTreeSet<i64> {
        let mut found = BTreeSet::new();
        for &(id, place) in list {
            let of = |test: fn(&super::StarterPart) -> i64| -> BTreeSet<i64> {
                self.parts.iter().filter(|(_, p)| test(p) == id).map(|(part, _)| *part).collect()
            };
            let more = match what {
                "MAT" => of(|p| p.material),
                "PROP" => of(|p| p.property),
                "SUBSET" => match self.subsets.get(&id) {
                    Some(parts) => parts.clone(),
                    None => {
                        let known: Vec<String> = self.subsets.keys().map(i64::to_string).collect();
                        self.deck.missing(place, "/SUBSET", id, &known);
                        BTreeSet::new()
                    }
                },
                _ => self.part(id, place).into_iter().collect(),
            };
            found.extend(more);
        }
        found
    }

    /// Reads groups of nodes. Groups of groups and of surfaces follow later.
    pub(super) fn groups(&mut self) {
        let mut later: Vec<CardRecord> = Vec::new();
        for record in self.take(&NODES) {
            let name = record.row.keyword.name;
            let list = ids(&record);
            let nodes = match name {
                "/GRNOD/NODE" => self.nodes_by_id(&record, &list),
                "/GRNOD/GENE" => self.ranges(&list),
                "/GRNOD/BOX" => list.iter().flat_map(|&(b, place)| self.in_box(b, place)).collect(),
                "/GRNOD/GRSHEL" => self.of_element_groups(&record, &list),
                "/GRNOD/GRNOD" | "/GRNOD/SURF" => {
                    later.push(record);
                    continue;
                }
                _ => {
                    let what = name.rsplit('/').next().unwrap_or_default();
                    let parts = self.parts_by(what, &list);
                    self.nodes_of(&parts)
                }
            };
            self.add_group(&record, nodes);
        }
        self.later = later;
    }

    /// Reads groups of surfaces and of groups, which may name later ones.
    pub(super) fn later_groups(&mut self) {
        let (of_groups, of_surfaces): (Vec<_>, Vec<_>) = std::mem::take(&mut self.later)
            .into_iter()
            .partition(|r| r.row.keyword.name == "/GRNOD/GRNOD");
        for record in of_surfaces {
            let mut nodes = BTreeSet::new();
            for (id, place) in ids(&record) {
                if let Some(surface) = self.surface(id, place) {
                    nodes.extend(self.nodes_of_surface(&surface));
                }
            }
            self.add_group(&record, nodes.into_iter().collect());
        }
        let mut known: BTreeSet<i64> = self.deck.node_sets.keys().copied().collect();
        known.extend(of_groups.iter().map(|r| r.integer("id")));
        for _ in 0..of_groups.len() {
            for record in &of_groups {
                let mut nodes: BTreeSet<NodeId> = BTreeSet::new();
                let (less, more): (Vec<_>, Vec<_>) =
                    ids(record).into_iter().partition(|(id, _)| *id < 0);
                let of = |id: i64| self.deck.node_sets.get(&id).map(|s| s.0.clone());
                more.iter().filter_map(|(id, _)| of(*id)).for_each(|n| nodes.extend(n));
                for gone in less.iter().filter_map(|(id, _)| of(id.saturating_neg())) {
                    nodes.retain(|n| !gone.contains(n));
                }
                let entry = (nodes.into_iter().collect(), record.place("id"));
                self.deck.node_sets.insert(record.integer("id"), entry);
            }
        }
        for record in &of_groups {
            for (id, place) in ids(record) {
                let id = id.saturating_abs();
                if !known.contains(&id) {
                    let known: Vec<String> = known.iter().map(i64::to_string).collect();
                    self.deck.missing(place, "/GRNOD/...", id, &known);
                }
            }
            self.note_title(record);
        }
    }

    /// Returns existing nodes by their ids.
    pub(super) fn nodes_by_id(
        &mut self,
        record: &CardRecord,
        list: &[(i64, Place)],
    ) -> Vec<NodeId> {
        let mut found = Vec::with_capacity(list.len());
        for &(n, place) in list {
            match node(n) {
                Some(id) => found.push(id),
                None => {
                    let message = format!("{}: {n} is not a node id", record.name());
                    self.deck.trouble.error(place, message, "give whole numbers above 0");
                }
            }
        }
        found
    }

    /// Returns the existing nodes in ranges of ids: pairs of the first and the last one.
    pub(super) fn ranges(&mut self, list: &[(i64, Place)]) -> Vec<NodeId> {
        let known: BTreeSet<NodeId> = self.deck.rows.nodes.iter().map(|n| n.id).collect();
        let mut found = Vec::new();
        for pair in list.chunks(2) {
            let ends = (node(pair[0].0), pair.get(1).and_then(|p| node(p.0)));
            let (Some(from), Some(to)) = ends else {
                let help = "give the first and the last id of each range";
                self.deck.trouble.error(pair[0].1, "a range has no last id", help);
                continue;
            };
            if from <= to {
                found.extend(known.range(from..=to));
            }
        }
        found
    }

    /// Returns the nodes in a box, including its faces.
    pub(super) fn in_box(&mut self, id: i64, place: Place) -> Vec<NodeId> {
        if !self.deck.boxes.contains_key(&id) {
            let known: Vec<String> = self.deck.boxes.keys().map(i64::to_string).collect();
            self.deck.missing(place, "/BOX/RECTA", id, &known);
            return Vec::new();
        }
        self.deck.in_box(id, place)
    }

    fn of_element_groups(&mut self, record: &CardRecord, list: &[(i64, Place)]) -> Vec<NodeId> {
        let Some(kind) = kind_in(&record.written) else { return Vec::new() };
        let found = self.groups_of_elements(kind, list);
        found.into_iter().flat_map(|(nodes, _)| nodes).collect()
    }

    /// Returns groups of elements by their ids.
    pub(super) fn groups_of_elements(
        &mut self,
        kind: &'static str,
        list: &[(i64, Place)],
    ) -> Vec<(BTreeSet<NodeId>, BTreeSet<i64>)> {
        let mut found = Vec::new();
        for &(id, place) in list {
            match self.element_groups.get(&(kind, id)) {
                Some(group) => found.push(group.clone()),
                None => {
                    let known: Vec<String> = self
                        .element_groups
                        .keys()
                        .filter(|k| k.0 == kind)
                        .map(|k| k.1.to_string())
                        .collect();
                    self.deck.missing(place, &format!("/{kind}/..."), id, &known);
                }
            }
        }
        found
    }

    /// Adds a group of nodes.
    pub(super) fn add_group(&mut self, record: &CardRecord, mut nodes: Vec<NodeId>) {
        nodes.sort_unstable();
        nodes.dedup();
        let (id, place) = (record.integer("id"), record.place("id"));
        if self.deck.node_sets.insert(id, (nodes, place)).is_some() {
            self.twice("groups of nodes", id, place);
        }
        self.note_title(record);
    }

    fn note_title(&mut self, record: &CardRecord) {
        let title = record.word("title").trim().to_string();
        if !title.is_empty() {
            self.titles.entry(title).or_default().push(record.integer("id"));
        }
    }

    /// Adds groups under their titles too, if no other group and no part has the name.
    pub(super) fn name_groups(&mut self) {
        let mut named: BTreeMap<String, (Vec<NodeId>, Place)> = BTreeMap::new();
        for (title, ids) in &self.titles {
            if let ([id], false) = (&ids[..], self.names.contains(title))
                && let Some(group) = self.deck.node_sets.get(id)
            {
                named.insert(title.clone(), group.clone());
            }
        }
        for (id, (nodes, place)) in std::mem::take(&mut self.deck.node_sets) {
            self.deck.rows.add_set(format!("set-{id}"), nodes, place);
        }
        for (title, (nodes, place)) in named {
            if !self.deck.rows.has_set(&title) {
                self.deck.rows.add_set(title, nodes, place);
            }
        }
    }
}
