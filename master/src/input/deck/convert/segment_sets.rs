//! Converts sets of segments.

use super::DeckConverter;
use super::segments::{DeckSegment, key, segment};
use super::sets::{SHELL_SETS, SOLID_SETS, id, ids};
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::MeshElement;
use std::collections::{HashMap, HashSet};

/// Number of ids on a line of a general set that adds segments; attributes follow them.
const IDS: usize = 3;

impl DeckConverter {
    /// Reads all sets of segments. Parts, boxes and sets of elements are known.
    pub(super) fn segment_sets(&mut self) {
        for record in self.take_records("SET_SEGMENT") {
            let segments = record.lines("n").map(segment).collect();
            self.segment_sets.insert(record.integer("sid"), segments);
        }
        for record in self.take_records("SET_SEGMENT_GENERAL") {
            let segments = self.general_segments(&record);
            self.segment_sets.insert(record.integer("sid"), segments);
        }
        let adding = self.take_records("SET_SEGMENT_ADD");
        // Sets of sets may name those that come later.
        for _ in 0..=adding.len() {
            for record in &adding {
                let others = ids(record, "id");
                let found = others.iter().filter_map(|(other, _)| self.segment_sets.get(other));
                let segments = without_repeats(found.flatten().cloned().collect());
                self.segment_sets.insert(record.integer("sid"), segments);
            }
        }
        for (other, place) in adding.iter().flat_map(|record| ids(record, "id")) {
            self.segment_set(other, place);
        }
    }

    /// Returns the segments of a set. Reports an error at `place` if there is none.
    pub(super) fn segment_set(&mut self, id: i64, place: Place) -> Option<Vec<DeckSegment>> {
        let found = self.segment_sets.get(&id).cloned();
        if found.is_none() {
            let known: Vec<String> = self.segment_sets.keys().map(i64::to_string).collect();
            self.missing(place, "*SET_SEGMENT", id, &known);
        }
        found
    }

    fn general_segments(&mut self, record: &CardRecord) -> Vec<DeckSegment> {
        let mut segments: Vec<DeckSegment> = Vec::new();
        let lines: Vec<CardLine> = record.lines("option").cloned().collect();
        for line in lines {
            let word = line.word("option").to_ascii_uppercase();
            let all: Vec<(i64, Place)> = line.integers("e").collect();
            let first = &all[..all.len().min(IDS)];
            match word.as_str() {
                "ALL" => segments.extend(self.skin(line.place, |_| true)),
                "PART" => {
                    let parts = self.existing_parts(first);
                    segments.extend(self.skin(line.place, |e| parts.contains(&e.part.into())));
                }
                "SHELL" => {
                    let shells: Vec<i64> = first.iter().map(|entry| entry.0).collect();
                    let own =
                        |e: &MeshElement| e.shape.is_shell() && shells.contains(&(e.id.0 as i64));
                    segments.extend(self.skin(line.place, own));
                }
                "SET_SHELL" | "SET_SOLID" => {
                    let kind = if word == "SET_SHELL" { SHELL_SETS } else { SOLID_SETS };
                    for &(set, place) in first {
                        let own: HashSet<_> =
                            self.elements_of_set(kind, set, place).iter().map(|e| e.id).collect();
                        segments.extend(self.skin(line.place, |e| own.contains(&e.id)));
                    }
                }
                "SET" => {
                    for &(set, place) in &all {
                        segments.extend(self.segment_set(set, place).into_iter().flatten());
                    }
                }
                "BOX" | "BOX_SHELL" | "BOX_SOLID" => {
                    let kinds = |e: &MeshElement| match word.as_str() {
                        "BOX_SHELL" => e.shape.is_shell(),
                        "BOX_SOLID" => !e.shape.is_shell(),
                        _ => true,
                    };
                    for &(number, place) in first {
                        let inside: HashSet<_> = self.in_box(number, place).into_iter().collect();
                        let skin = self.skin(line.place, kinds);
                        let is_in = |s: &DeckSegment| s.nodes.iter().all(|n| inside.contains(n));
                        segments.extend(skin.into_iter().filter(is_in));
                    }
                }
                "SEG" => {
                    let mut nodes: Vec<_> = all.iter().take(4).filter_map(|n| id(n.0)).collect();
                    nodes.dedup();
                    segments.push(DeckSegment { nodes, place: line.place });
                }
                "DSEG" => {
                    let nodes: Vec<_> = all.iter().take(4).filter_map(|n| id(n.0)).collect();
                    segments.retain(|s| key(&s.nodes) != key(&nodes));
                }
                "DPART" => {
                    let parts = self.existing_parts(&all);
                    let gone: HashSet<_> = self
                        .skin(line.place, |e| parts.contains(&e.part.into()))
                        .iter()
                        .map(|s| key(&s.nodes))
                        .collect();
                    segments.retain(|s| !gone.contains(&key(&s.nodes)));
                }
                "DBOX" => {
                    for &(number, place) in &all {
                        let inside: HashSet<_> = self.in_box(number, place).into_iter().collect();
                        segments.retain(|s| !s.nodes.iter().all(|n| inside.contains(n)));
                    }
                }
                _ => {
                    let message = format!("*SET_SEGMENT_GENERAL: option {word} is not supported");
                    let what = format!("*SET_SEGMENT_GENERAL {word}");
                    self.unsupported(line.place("option"), message, what);
                }
            }
        }
        without_repeats(segments)
    }

    /// Returns those of these parts that exist.
    fn existing_parts(&mut self, ids: &[(i64, Place)]) -> Vec<i64> {
        ids.iter().filter(|(part, place)| self.has_part(*part, *place)).map(|p| p.0).collect()
    }

    /// Returns the segments of elements: all shells, and the faces of solids that no other solid
    /// of their part has. Their normals point out of the solids.
    fn skin(&self, place: Place, is_member: impl Fn(&MeshElement) -> bool) -> Vec<DeckSegment> {
        let mut count: HashMap<(u32, Vec<NodeId>), usize> = HashMap::new();
        let mut faces = Vec::new();
        for element in self.rows.elements() {
            let is_own = is_member(element);
            if element.shape.is_shell() {
                faces.extend(is_own.then(|| (None, element.corners().to_vec())));
                continue;
            }
            for face in element.shape.faces() {
                let mut nodes: Vec<NodeId> = face.iter().map(|&c| element.nodes[c]).collect();
                nodes.dedup();
                let of = (element.part, key(&nodes));
                *count.entry(of.clone()).or_default() += 1;
                faces.extend(is_own.then_some((Some(of), nodes)));
            }
        }
        let is_outer =
            |of: &Option<(u32, Vec<NodeId>)>| of.as_ref().is_none_or(|of| count[of] == 1);
        let outer = faces.into_iter().filter(|(of, _)| is_outer(of));
        outer.map(|(_, nodes)| DeckSegment { nodes, place }).collect()
    }
}

/// Returns segments without those whose nodes an earlier one has.
fn without_repeats(mut segments: Vec<DeckSegment>) -> Vec<DeckSegment> {
    let mut seen = HashSet::new();
    segments.retain(|segment| seen.insert(key(&segment.nodes)));
    segments
}
