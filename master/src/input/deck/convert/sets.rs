//! Converts sets of nodes and of parts.

use super::DeckConverter;
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::MeshElement;
use std::collections::{BTreeMap, BTreeSet};

/// Sets of elements: keyword, keyword of sets of sets, and field of a cross section that names the
/// set. The keyword with ranges ends in `_GENERATE`.
pub const ELEMENT_SETS: [(&str, &str, &str); 4] = [
    ("SET_SOLID", "SET_SOLID_ADD", "hsid"),
    ("SET_SHELL_LIST", "SET_SHELL_ADD", "ssid"),
    ("SET_DISCRETE", "SET_DISCRETE_ADD", "dsid"),
    ("SET_BEAM", "SET_BEAM_ADD", "bsid"),
];
/// Index of sets of solids in [`ELEMENT_SETS`].
pub const SOLID_SETS: usize = 0;
/// Index of sets of shells in [`ELEMENT_SETS`].
pub const SHELL_SETS: usize = 1;
/// Index of sets of springs in [`ELEMENT_SETS`].
const SPRING_SETS: usize = 2;
/// Index of sets of beams in [`ELEMENT_SETS`].
pub const BEAM_SETS: usize = 3;

/// Keyword of sets of the nodes that all of some sets have.
const INTERSECT: &str = "SET_NODE_INTERSECT";
/// Option of sets whose cards with the same id are one set.
const COLLECT: &str = "COLLECT";

/// Consequence of a set of a set that is left out.
const WITHOUT_SET: &str = "the set has the members of its other sets";

/// Elements of sets by id: ranges from the first to the last id.
pub type ElementSets = BTreeMap<i64, Vec<[i64; 2]>>;

/// Members of a set of nodes from other sets.
#[derive(Default)]
struct SetMembers {
    /// Sets of nodes, with their places.
    sets: Vec<(i64, Place)>,
    /// Nodes of other kinds of sets.
    nodes: BTreeSet<NodeId>,
}

impl DeckConverter {
    /// Reads the sets of elements; those of beams are known.
    pub(super) fn read_element_sets(&mut self) {
        for kind in [SOLID_SETS, SHELL_SETS, SPRING_SETS] {
            self.read_sets_of(kind);
        }
    }

    /// Reads the sets of the kind of elements with an index in [`ELEMENT_SETS`].
    pub(super) fn read_sets_of(&mut self, kind: usize) {
        let (list, adding, _) = ELEMENT_SETS[kind];
        self.element_sets[kind] = self.sets_of(list, adding);
    }

    /// Reads sets of one kind of elements: lists, ranges, and sets of sets.
    fn sets_of(&mut self, list: &str, adding: &str) -> ElementSets {
        let mut sets = ElementSets::new();
        for record in self.take_records(list) {
            let own = ids(&record, "id").into_iter().map(|(e, _)| [e, e]);
            sets.entry(record.integer("sid")).or_default().extend(own);
        }
        for record in self.take_records(&format!("{list}_GENERATE")) {
            let ends: Vec<i64> = ids(&record, "id").into_iter().map(|e| e.0).collect();
            let own = ends.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
            sets.entry(record.integer("sid")).or_default().extend(own);
        }
        self.sets_by_options(list, &mut sets);
        let adding = self.take_records(adding);
        // Sets of sets may name those that come later.
        for _ in 0..=adding.len() {
            for record in &adding {
                let others = ids(record, "id");
                let own = others.iter().filter_map(|(other, _)| sets.get(other));
                let own = own.flatten().copied().collect();
                sets.insert(record.integer("sid"), own);
            }
        }
        for (other, place) in adding.iter().flat_map(|record| ids(record, "id")) {
            if !sets.contains_key(&other) {
                let known: Vec<String> = sets.keys().map(i64::to_string).collect();
                self.missing_for(place, (&format!("*{list}"), other), &known, WITHOUT_SET);
            }
        }
        sets
    }

    /// Returns the elements of a set of the index `kind` in [`ELEMENT_SETS`]. Reports an error at
    /// `place` if there is none.
    pub(super) fn elements_of_set(
        &mut self,
        kind: usize,
        set: i64,
        place: Place,
    ) -> Vec<MeshElement> {
        match self.element_sets[kind].get(&set) {
            Some(ranges) => self.elements_in(kind, ranges),
            None => {
                let known = self.element_sets[kind].keys().map(i64::to_string);
                let known: Vec<String> = known.collect();
                self.missing(place, &format!("*{}", ELEMENT_SETS[kind].0), set, &known);
                Vec::new()
            }
        }
    }

    /// Returns the elements in ranges of the ids that the deck has for them; `kind` is their index
    /// in [`ELEMENT_SETS`].
    pub(super) fn elements_in(&self, kind: usize, ranges: &[[i64; 2]]) -> Vec<MeshElement> {
        let (of_kind, raised) = match kind {
            SOLID_SETS => (&self.rows.solids, self.rows.raised[0]),
            SHELL_SETS => (&self.rows.shells, 0),
            SPRING_SETS => (&self.rows.springs, self.rows.raised[1]),
            _ => (&self.rows.beams, self.rows.raised[2]),
        };
        let own = |e: &&MeshElement| {
            let written = e.id.0.saturating_sub(raised) as i64;
            ranges.iter().any(|r| r[0] <= written && written <= r[1])
        };
        of_kind.iter().filter(own).copied().collect()
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
        let keywords = ["SET_NODE_ADD", "SET_NODE_ADD_ADVANCED", INTERSECT];
        let adding = self.take_in_order(&keywords);
        let members: Vec<SetMembers> = adding.iter().map(|record| self.members(record)).collect();
        for _ in 0..=adding.len() {
            for (record, members) in adding.iter().zip(&members) {
                let mut nodes = members.nodes.clone();
                let of = |other: &i64| self.node_sets.get(other).map_or(&[][..], |set| &set.0);
                if record.row.keyword.name == INTERSECT {
                    nodes.extend(members.sets.first().into_iter().flat_map(|s| of(&s.0)));
                    for (other, _) in members.sets.iter().skip(1) {
                        let other: BTreeSet<&NodeId> = of(other).iter().collect();
                        nodes.retain(|node| other.contains(node));
                    }
                } else {
                    members.sets.iter().for_each(|(other, _)| nodes.extend(of(other)));
                }
                self.node_sets.insert(
                    record.integer("sid"),
                    (nodes.into_iter().collect(), record.place("sid")),
                );
            }
        }
        for (record, members) in adding.iter().zip(members) {
            for (other, place) in members.sets {
                self.node_set(other, place);
            }
            self.named(record);
        }
    }

    /// Returns the members of a set of sets. The fields `type` of `*SET_NODE_ADD_ADVANCED` are the
    /// kinds of its sets.
    fn members(&mut self, record: &CardRecord) -> SetMembers {
        let mut members = SetMembers::default();
        let lines: Vec<CardLine> = record.lines("id").cloned().collect();
        for line in lines {
            let kinds = line.all_integers("type");
            for (k, set) in line.all_integers("id").into_iter().enumerate() {
                let place = line.place("id");
                let found: Vec<NodeId> = match (set, kinds.get(k).copied().unwrap_or(1)) {
                    (0, _) => continue,
                    (_, 0 | 1) => {
                        members.sets.push((set, place));
                        continue;
                    }
                    (_, 5) => {
                        let segments = self.segment_set(set, place).unwrap_or_default();
                        segments.into_iter().flat_map(|segment| segment.nodes).collect()
                    }
                    (_, kind @ (2 | 4 | 6)) => {
                        let kind = match kind {
                            2 => SHELL_SETS,
                            4 => SOLID_SETS,
                            _ => SPRING_SETS,
                        };
                        let elements = self.elements_of_set(kind, set, place);
                        elements.iter().flat_map(|e| e.corners().to_vec()).collect()
                    }
                    _ => {
                        let why = "use 1 (nodes), 2 (shells), 4 (solids), 5 (segments) or 6 \
                                   (springs)";
                        self.unsupported_value(record, "type", why);
                        continue;
                    }
                };
                members.nodes.extend(found);
            }
        }
        members
    }

    fn part_lists(&mut self) {
        for record in self.take_records("SET_PART_LIST") {
            self.add_part_set(&record, ids(&record, "id"));
        }
        for record in self.take_records("SET_PART_LIST_GENERATE") {
            let ranges = ids(&record, "id");
            let mut parts = Vec::new();
            for pair in ranges.chunks(2) {
                let (from, to) = (pair[0].0, pair.get(1).map_or(pair[0].0, |p| p.0));
                let within = self.parts.range(from.min(to)..=to).map(|(&id, _)| (id, pair[0].1));
                parts.extend(within);
            }
            self.add_part_set(&record, parts);
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
        for (other, place) in adding.iter().flat_map(|record| ids(record, "id")) {
            if !self.part_sets.contains_key(&other) {
                let known: Vec<String> = self.part_sets.keys().map(i64::to_string).collect();
                self.missing_for(place, ("*SET_PART_...", other), &known, WITHOUT_SET);
            }
        }
    }

    /// Adds a set of parts.
    fn add_part_set(&mut self, record: &CardRecord, parts: Vec<(i64, Place)>) {
        let set = self.part_sets.entry(record.integer("sid")).or_default();
        if !record.has(COLLECT) {
            set.clear();
        }
        set.extend(parts);
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
        let (sid, place) = (record.integer("sid"), record.place("sid"));
        if record.has(COLLECT) {
            nodes.extend(self.node_sets.remove(&sid).into_iter().flat_map(|set| set.0));
        }
        nodes.sort_unstable();
        nodes.dedup();
        if self.node_sets.insert(sid, (nodes, place)).is_some() {
            self.trouble.error(
                place,
                format!("there are two node sets with the id {sid}"),
                "give each a different id",
            );
        }
        self.named(record);
    }

    /// Adds the set under its title too; with a number if another set has this title, as sets of a
    /// file that is included several times do.
    fn named(&mut self, record: &CardRecord) {
        let title = record.word("heading").to_string();
        let sid = record.integer("sid");
        if let (false, Some((nodes, place))) = (title.is_empty(), self.node_sets.get(&sid)) {
            let name = self.rows.add_named_set(&title, nodes.clone(), *place);
            if !record.in_submodel {
                self.node_set_titles.insert(sid, name);
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
            let lost = "the card acts on no node of this box";
            self.missing_for(place, ("*DEFINE_BOX", id), &known, lost);
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
