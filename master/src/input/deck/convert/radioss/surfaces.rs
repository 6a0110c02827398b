//! Converts surfaces, lines and general sets.

use super::StarterConverter;
use super::groups::ids;
use crate::input::deck::convert::segments::DeckSegment;
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::{BTreeMap, BTreeSet};

/// Keywords of surfaces by ids.
const SURFACES: [&str; 7] = [
    "/SURF/PART",
    "/SURF/SUBSET",
    "/SURF/MAT",
    "/SURF/PROP",
    "/SURF/GRSHEL",
    "/SURF/SEG",
    "/SURF/SURF",
];

/// A surface: all faces of parts, and single faces.
#[derive(Clone, Debug, Default)]
pub struct StarterSurface {
    /// Parts.
    pub parts: BTreeSet<i64>,
    /// Faces by their nodes.
    pub segments: Vec<DeckSegment>,
}

impl StarterSurface {
    fn add(&mut self, other: &StarterSurface) {
        self.parts.extend(&other.parts);
        self.segments.extend(other.segments.iter().cloned());
    }
}

/// One key of a general set with its ids.
struct SetClause {
    key: String,
    place: Place,
    list: Vec<(i64, Place)>,
    /// First id, last id and increment of ranges.
    ranges: Vec<([i64; 3], Place)>,
    segments: Vec<DeckSegment>,
}

/// Content of a clause of a general set.
#[derive(Default)]
struct SetContent {
    nodes: BTreeSet<NodeId>,
    surface: StarterSurface,
    /// Other general sets.
    sets: Vec<i64>,
    /// True if the content is taken away.
    is_away: bool,
}

impl StarterConverter {
    pub(super) fn surfaces(&mut self) {
        let mut later = Vec::new();
        for record in self.take(&SURFACES) {
            let name = record.row.keyword.name;
            let mut surface = StarterSurface::default();
            match name {
                "/SURF/SEG" => surface.segments = record.lines("n").map(segment).collect(),
                "/SURF/SURF" => {
                    later.push(record);
                    continue;
                }
                "/SURF/GRSHEL" => {
                    let words = record.written.split('/').nth(2).unwrap_or_default().to_string();
                    let kind = super::groups::kind_in(&format!("/{words}"));
                    let list = ids(&record);
                    for (_, parts) in
                        kind.map(|k| self.groups_of_elements(k, &list)).unwrap_or_default()
                    {
                        surface.parts.extend(parts);
                    }
                }
                _ => {
                    let what = name.rsplit('/').next().unwrap_or_default();
                    surface.parts = self.parts_by(what, &ids(&record));
                }
            }
            self.add_surface(&record, surface);
        }
        let mut known: BTreeSet<i64> = self.surfaces.keys().copied().collect();
        known.extend(later.iter().map(|r| r.integer("id")));
        for _ in 0..later.len() {
            for record in &later {
                let mut whole = StarterSurface::default();
                for (id, _) in ids(record) {
                    self.surfaces.get(&id).iter().for_each(|other| whole.add(other));
                }
                self.surfaces.insert(record.integer("id"), whole);
            }
        }
        for (id, place) in later.iter().flat_map(ids) {
            if !known.contains(&id) {
                let known: Vec<String> = known.iter().map(i64::to_string).collect();
                self.deck.missing(place, "/SURF/...", id, &known);
            }
        }
        self.edge_lines();
        self.later_groups();
        self.general_sets();
    }

    fn add_surface(&mut self, record: &CardRecord, surface: StarterSurface) {
        let (id, place) = (record.integer("id"), record.place("id"));
        if self.surfaces.insert(id, surface).is_some() {
            self.twice("surfaces", id, place);
        }
    }

    /// Returns a surface by its id. Reports an error at `place` if there is none.
    pub(super) fn surface(&mut self, id: i64, place: Place) -> Option<StarterSurface> {
        let found = self.surfaces.get(&id).cloned();
        if found.is_none() {
            let known: Vec<String> = self.surfaces.keys().map(i64::to_string).collect();
            self.deck.missing(place, "/SURF/...", id, &known);
        }
        found
    }

    /// Returns all nodes of a surface.
    pub(super) fn nodes_of_surface(&self, surface: &StarterSurface) -> BTreeSet<NodeId> {
        let mut nodes: BTreeSet<NodeId> = self.nodes_of(&surface.parts).into_iter().collect();
        nodes.extend(surface.segments.iter().flat_map(|s| &s.nodes));
        nodes
    }

    /// Returns the parts of a surface; those of single faces are the parts that have their nodes.
    pub(super) fn parts_of_surface(&mut self, surface: &StarterSurface) -> BTreeSet<i64> {
        let mut parts = surface.parts.clone();
        if !surface.segments.is_empty() {
            let nodes: BTreeSet<NodeId> =
                surface.segments.iter().flat_map(|s| s.nodes.iter().copied()).collect();
            parts.extend(self.parts_with(&nodes, true));
        }
        parts
    }

    /// Returns the parts with all nodes of a face in a set, or with any of them.
    pub(super) fn parts_with(&self, nodes: &BTreeSet<NodeId>, whole: bool) -> BTreeSet<i64> {
        let fits = |e: &&crumple_proto::mesh::MeshElement| {
            let has = |n: &NodeId| nodes.contains(n);
            match whole {
                true => e.shape.faces().iter().any(|f| f.iter().all(|&c| has(&e.nodes[c]))),
                false => !e.shape.faces().is_empty() && e.corners().iter().any(has),
            }
        };
        let found = self.deck.rows.elements().filter(fits);
        found.map(|e| i64::from(e.part)).collect()
    }

    /// Reads lines: the parts whose edges they have.
    fn edge_lines(&mut self) {
        for record in self.take(&["/LINE/PART", "/LINE/SURF"]) {
            let list = ids(&record);
            let mut parts = BTreeSet::new();
            match (record.row.keyword.name, record.written.ends_with("SUBSET")) {
                ("/LINE/PART", false) => parts = self.parts_by("PART", &list),
                ("/LINE/PART", true) => parts = self.parts_by("SUBSET", &list),
                _ => {
                    for (id, place) in list {
                        if let Some(surface) = self.surface(id, place) {
                            parts.extend(self.parts_of_surface(&surface));
                        }
                    }
                }
            }
            self.lines.insert(record.integer("id"), parts);
        }
    }

    /// Reads general sets: each is a group of nodes and a surface.
    fn general_sets(&mut self) {
        let records = self.take(&["/SET/GENERAL"]);
        let known: BTreeSet<i64> = records.iter().map(|r| r.integer("id")).collect();
        let mut all: Vec<(CardRecord, Vec<SetContent>)> = Vec::with_capacity(records.len());
        for record in records {
            let mut contents = Vec::new();
            for clause in clauses(&record) {
                let content = self.content(&clause);
                for &(id, place) in &clause.list {
                    if !content.sets.is_empty() && !known.contains(&id) {
                        let known: Vec<String> = known.iter().map(i64::to_string).collect();
                        self.deck.missing(place, "/SET/GENERAL", id, &known);
                    }
                }
                contents.push(content);
            }
            all.push((record, contents));
        }
        let mut found: BTreeMap<i64, (BTreeSet<NodeId>, StarterSurface)> = BTreeMap::new();
        // Sets may name those that come later, so all are made once more for each set.
        for _ in 0..=all.len() {
            for (record, contents) in &all {
                let made = whole_set(contents, &found);
                found.insert(record.integer("id"), made);
            }
        }
        for (record, _) in &all {
            let (nodes, surface) = found.remove(&record.integer("id")).unwrap_or_default();
            self.add_group(record, nodes.into_iter().collect());
            self.add_surface(record, surface);
        }
    }

    /// Returns the content of a clause. Reports its problems.
    fn content(&mut self, clause: &SetClause) -> SetContent {
        let (key, is_away) = match clause.key.strip_suffix("_D") {
            Some(key) => (key, true),
            None => (clause.key.as_str(), false),
        };
        let mut content = SetContent { is_away, ..SetContent::default() };
        let nodes = &mut content.nodes;
        match key {
            "ALL" => {
                nodes.extend(self.deck.rows.nodes.iter().map(|n| n.id));
                content.surface.parts.extend(self.parts.keys());
            }
            "NODE" => nodes.extend(clause.list.iter().filter_map(|(n, _)| super::groups::node(*n))),
            "NODE_G" => {
                for &([first, last, step], place) in &clause.ranges {
                    let range = self.ranges(&[(first, place), (last, place)]);
                    let step = u64::try_from(step.max(1)).unwrap_or(1);
                    let from = range.first().map_or(0, |_| u64::try_from(first).unwrap_or(0));
                    nodes.extend(range.into_iter().filter(|n| (n.0 - from).is_multiple_of(step)));
                }
            }
            "BOX" => {
                clause.list.iter().for_each(|&(b, place)| nodes.extend(self.in_box(b, place)));
            }
            "PART" | "SUBS" | "SUBSET" | "MAT" | "PROP" => {
                let of = if key == "SUBS" { "SUBSET" } else { key };
                content.surface.parts = self.parts_by(of, &clause.list);
                nodes.extend(self.nodes_of(&content.surface.parts));
            }
            "SEG" => {
                nodes.extend(clause.segments.iter().flat_map(|s| s.nodes.iter().copied()));
                content.surface.segments = clause.segments.clone();
            }
            "SET" => content.sets = clause.list.iter().map(|(id, _)| *id).collect(),
            _ => {
                let message = format!("/SET/GENERAL: the key {key} is not supported");
                let what = format!("/SET/GENERAL {key}");
                self.deck.unsupported(clause.place, message, what);
            }
        }
        content
    }
}

/// Returns the nodes and the surface of a general set from its clauses and the other sets.
fn whole_set(
    contents: &[SetContent],
    sets: &BTreeMap<i64, (BTreeSet<NodeId>, StarterSurface)>,
) -> (BTreeSet<NodeId>, StarterSurface) {
    let (mut nodes, mut surface) = (BTreeSet::new(), StarterSurface::default());
    for content in contents {
        let (mut of, mut more) = (content.nodes.clone(), content.surface.clone());
        for (n, s) in content.sets.iter().filter_map(|id| sets.get(id)) {
            of.extend(n);
            more.add(s);
        }
        if content.is_away {
            nodes.retain(|n| !of.contains(n));
            surface.parts.retain(|p| !more.parts.contains(p));
            let gone: BTreeSet<Vec<NodeId>> = more.segments.iter().map(corners).collect();
            surface.segments.retain(|s| !gone.contains(&corners(s)));
        } else {
            nodes.extend(of);
            surface.add(&more);
        }
    }
    (nodes, surface)
}

/// Returns the nodes of a segment in ascending order.
fn corners(segment: &DeckSegment) -> Vec<NodeId> {
    let mut nodes = segment.nodes.clone();
    nodes.sort_unstable();
    nodes
}

/// Returns the keys of a general set with their ids. A line without a key continues the one above.
fn clauses(record: &CardRecord) -> Vec<SetClause> {
    let mut found: Vec<SetClause> = Vec::new();
    for line in record.lines("ids") {
        let key = line.word("key").to_ascii_uppercase();
        if !key.is_empty() || found.is_empty() {
            let (list, ranges, segments) = (Vec::new(), Vec::new(), Vec::new());
            found.push(SetClause { key, place: line.place("key"), list, ranges, segments });
        }
        let Some(last) = found.last_mut() else { continue };
        // Ranges and segments have their numbers in fixed fields, of which some may be zero.
        let fields = line.all_integers("ids");
        match last.key.strip_suffix("_D").unwrap_or(&last.key) {
            "SEG" => {
                let mut nodes: Vec<NodeId> =
                    fields[1..5].iter().filter_map(|n| super::groups::node(*n)).collect();
                nodes.dedup();
                last.segments.push(DeckSegment { nodes, place: line.place });
            }
            "NODE_G" => {
                let ranges = fields.chunks_exact(3).map(|f| [f[0], f[1], f[2]]);
                let given = ranges.filter(|range| range[..2] != [0, 0]);
                last.ranges.extend(given.map(|range| (range, line.place)));
            }
            _ => last.list.extend(line.integers("ids")),
        }
    }
    found
}

fn segment(line: &CardLine) -> DeckSegment {
    // The number of the segment has no meaning.
    line.integer("seg");
    let mut nodes: Vec<NodeId> =
        line.integers("n").filter_map(|(n, _)| super::groups::node(n)).collect();
    nodes.dedup();
    DeckSegment { nodes, place: line.place }
}
