//! Converts sets of segments.

use super::DeckConverter;
use super::segments::{DeckSegment, key, segment};
use super::sets::{SHELL_SETS, SOLID_SETS, id, ids};
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::MeshElement;
use std::collections::{HashMap, HashSet};

const ADDING: &str = "SET_SEGMENT_ADD";

impl DeckConverter {
    /// Reads all sets of segments. Parts, boxes and sets of elements are known.
    pub(super) fn segment_sets(&mut self) {
        for record in self.take_records("SET_SEGMENT") {
            let segments = record.lines("n").map(segment).collect();
            self.segment_sets.insert(record.integer("sid"), segments);
        }
        let mut waiting = self.take_in_order(&["SET_SEGMENT_GENERAL", ADDING]);
        // Sets of sets may name those that come later.
        while !waiting.is_empty() {
            let open: HashSet<i64> = waiting.iter().map(|record| record.integer("sid")).collect();
            let is_ready =
                |record: &CardRecord| sets_of(record).iter().all(|other| !open.contains(other));
            let (ready, rest): (Vec<_>, Vec<_>) = waiting.into_iter().partition(is_ready);
            if ready.is_empty() {
                return self.circle_of_sets(&rest);
            }
            for record in ready {
                let segments = match record.row.keyword.name {
                    ADDING => self.sum_of_sets(&record),
                    _ => self.general_segments(&record),
                };
                self.segment_sets.insert(record.integer("sid"), segments);
            }
            waiting = rest;
        }
    }

    /// Returns the segments of other sets.
    fn sum_of_sets(&mut self, record: &CardRecord) -> Vec<DeckSegment> {
        let others = ids(record, "id").into_iter();
        let found = others.filter_map(|(other, place)| self.segment_set(other, place));
        without_repeats(found.flatten().collect())
    }

    /// Reports sets that cannot be read, since each needs another one of them first.
    fn circle_of_sets(&mut self, records: &[CardRecord]) {
        for record in records {
            let sid = record.integer("sid");
            let message = format!("{} {sid}: it is made of itself", record.name());
            let help = "remove a set from the circle of sets that name each other";
            self.trouble.error(record.place("sid"), message, help);
            self.segment_sets.insert(sid, Vec::new());
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
            let own = self.ids_of_option(record, &line);
            match word.as_str() {
                "ALL" => segments.extend(self.skin(line.place, |_| true)),
                "PART" => {
                    let parts = self.existing_parts(&own);
                    segments.extend(self.skin(line.place, |e| parts.contains(&e.part.into())));
                }
                "SHELL" => {
                    own.iter().for_each(|&(shell, place)| self.check_shell(shell, place));
                    let is_own = |e: &MeshElement| {
                        e.shape.is_shell() && own.iter().any(|entry| entry.0 == e.id.0 as i64)
                    };
                    segments.extend(self.skin(line.place, is_own));
                }
                "SET_SHELL" | "SET_SOLID" => {
                    let kind = if word == "SET_SHELL" { SHELL_SETS } else { SOLID_SETS };
                    for &(set, place) in &own {
                        let members: HashSet<_> =
                            self.elements_of_set(kind, set, place).iter().map(|e| e.id).collect();
                        segments.extend(self.skin(line.place, |e| members.contains(&e.id)));
                    }
                }
                "SET" => {
                    for &(set, place) in &own {
                        segments.extend(self.segment_set(set, place).into_iter().flatten());
                    }
                }
                "BOX" | "BOX_SHELL" | "BOX_SOLID" => {
                    let kinds = |e: &MeshElement| match word.as_str() {
                        "BOX_SHELL" => e.shape.is_shell(),
                        "BOX_SOLID" => !e.shape.is_shell(),
                        _ => true,
                    };
                    for &(number, place) in &own {
                        let inside: HashSet<_> = self.in_box(number, place).into_iter().collect();
                        let skin = self.skin(line.place, kinds);
                        let is_in = |s: &DeckSegment| s.nodes.iter().all(|n| inside.contains(n));
                        segments.extend(skin.into_iter().filter(is_in));
                    }
                }
                "SEG" => {
                    let mut nodes: Vec<_> = own.iter().filter_map(|n| id(n.0)).collect();
                    nodes.dedup();
                    segments.push(DeckSegment { nodes, place: line.place });
                }
                "DSEG" => {
                    let nodes: Vec<_> = own.iter().filter_map(|n| id(n.0)).collect();
                    segments.retain(|s| key(&s.nodes) != key(&nodes));
                }
                "DPART" => {
                    let parts = self.existing_parts(&own);
                    let gone: HashSet<_> = self
                        .skin(line.place, |e| parts.contains(&e.part.into()))
                        .iter()
                        .map(|s| key(&s.nodes))
                        .collect();
                    segments.retain(|s| !gone.contains(&key(&s.nodes)));
                }
                "DBOX" => {
                    for &(number, place) in &own {
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

    /// Returns the ids of a line of a general set. Attributes after them have no effect.
    fn ids_of_option(&mut self, record: &CardRecord, line: &CardLine) -> Vec<(i64, Place)> {
        let word = line.word("option");
        let mut given = line.reals("e");
        let attributes = given.split_off(number_of_ids(word).min(given.len()));
        if attributes.iter().any(|a| *a != 0.0) {
            let asked = format!("attributes on a line of {word}");
            self.map(record.name(), asked, "not used: no keyword here refers to them");
        }
        let mut found = Vec::new();
        for (x, place) in given.into_iter().zip(line.places("e")).filter(|(x, _)| *x != 0.0) {
            if x.fract() == 0.0 {
                found.push((x as i64, place));
                continue;
            }
            let message = format!("{}: `e` has to be a whole number, not {x}", record.name());
            let help = "give ids, and attributes after them";
            self.trouble.error(place, message, help);
        }
        found
    }

    /// Reports a shell that does not exist.
    fn check_shell(&mut self, shell: i64, place: Place) {
        let is_it = |e: &MeshElement| e.id.0 as i64 == shell;
        if self.trouble.is_unsure() || self.rows.shells.iter().any(is_it) {
            return;
        }
        let message = format!("*SET_SEGMENT_GENERAL: there is no shell {shell}");
        match self.rows.removed.iter().any(|e| e.shape.is_shell() && is_it(e)) {
            true => {
                let help = "its part is left out; the set has its other segments";
                self.trouble.warning(place, message, help);
            }
            false => self.trouble.error(place, message, "correct the id, or remove it"),
        }
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

/// Returns the number of ids on a line of a general set; attributes follow them.
pub fn number_of_ids(option: &str) -> usize {
    match option.to_ascii_uppercase().as_str() {
        "SEG" | "DSEG" => 4,
        "SET" | "DPART" | "DBOX" => 7,
        _ => 3,
    }
}

/// Returns the sets of segments that a set is made of.
fn sets_of(record: &CardRecord) -> Vec<i64> {
    if record.row.keyword.name == ADDING {
        return ids(record, "id").into_iter().map(|entry| entry.0).collect();
    }
    let lines = record.lines("option").filter(|l| l.word("option").eq_ignore_ascii_case("SET"));
    lines.flat_map(|l| l.reals("e")).map(|x| x as i64).collect()
}

/// Returns segments without those whose nodes an earlier one has.
fn without_repeats(mut segments: Vec<DeckSegment>) -> Vec<DeckSegment> {
    let mut seen = HashSet::new();
    segments.retain(|segment| seen.insert(key(&segment.nodes)));
    segments
}
