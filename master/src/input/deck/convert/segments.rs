//! Segments: faces given by their nodes, for pressure.

use super::DeckConverter;
use super::blast::AS_CURVE;
use super::sets::{SHELL_SETS, id};
use super::tree::JobTable;
use crate::input::deck::record::CardLine;
use crate::input::job::tree::{NodeContent, Place};
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::{MeshElement, Shape};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// A face given by its nodes in order.
#[derive(Clone, Debug)]
pub struct DeckSegment {
    /// Three or four nodes.
    pub nodes: Vec<NodeId>,
    /// Place of the segment.
    pub place: Place,
}

/// Pressure on faces: curve, scale, place, faces.
type SegmentPressure = (i64, f64, Place, Vec<DeckSegment>);

/// Adds the pressure of a card on these faces. Faces with the same curve and scale form one load.
fn add_pressure(loads: &mut Vec<SegmentPressure>, line: &CardLine, faces: Vec<DeckSegment>) {
    let (curve, scale) = (line.integer("lcid"), line.real("sf"));
    match loads.iter_mut().find(|load| load.0 == curve && load.1 == scale) {
        Some(load) => load.3.extend(faces),
        None => loads.push((curve, scale, line.place, faces)),
    }
}

pub(super) fn segment(line: &CardLine) -> DeckSegment {
    let mut nodes: Vec<NodeId> = line.integers("n").filter_map(|n| id(n.0)).collect();
    nodes.dedup();
    DeckSegment { nodes, place: line.place }
}

/// Returns the nodes of a face in ascending order.
pub(super) fn key(nodes: &[NodeId]) -> Vec<NodeId> {
    let mut key = nodes.to_vec();
    key.sort_unstable();
    key.dedup();
    key
}

impl DeckConverter {
    pub(super) fn pressures(&mut self) {
        let mut loads = self.shell_pressures();
        for record in self.take_records("LOAD_SEGMENT") {
            for line in record.lines("lcid") {
                self.arrival(line);
                add_pressure(&mut loads, line, vec![segment(line)]);
            }
        }
        for record in self.take_records("LOAD_SEGMENT_SET") {
            for line in record.lines("lcid") {
                self.arrival(line);
                let ssid = line.integer("ssid");
                if let Some(set) = self.segment_set(ssid, line.place("ssid")) {
                    loads.push((line.integer("lcid"), line.real("sf"), line.place, set));
                }
            }
        }
        let mut blasts = self.blasts();
        let of_curves = loads.into_iter().map(|load| (load, false));
        let of_blasts = self.blast_segments().into_iter().map(|load| (load, true));
        let loads: Vec<_> = of_curves.chain(of_blasts).collect();
        let mut used = BTreeSet::new();
        for (number, ((curve, scale, place, segments), is_blast)) in loads.into_iter().enumerate() {
            let is_blast = is_blast || curve == AS_CURVE && blasts.contains_key(&curve);
            let (key, value) = if is_blast {
                used.insert(curve);
                match blasts.get(&curve) {
                    Some((Some(blast), _)) => ("blast", NodeContent::from(blast.copy())),
                    Some((None, _)) => continue,
                    None => {
                        let known = blasts.keys().filter(|id| **id != AS_CURVE);
                        let known: Vec<String> = known.map(i64::to_string).collect();
                        self.missing(place, "*LOAD_BLAST_ENHANCED", curve, &known);
                        continue;
                    }
                }
            } else {
                let Some(name) = self.time_curve(curve, place) else { continue };
                ("curve", NodeContent::from(name.as_str()))
            };
            let groups = self.groups_of_faces(&segments, false);
            let mut counts = [0; 2];
            for (sign, group, nodes) in groups {
                let count = &mut counts[usize::from(sign < 0.0)];
                *count += 1;
                let back = if sign > 0.0 { "" } else { "back-" };
                let set = format!("pressure-{}-{back}{count}", number + 1);
                self.rows.add_set(set.clone(), nodes, group);
                let table = JobTable::new(place)
                    .with("nodes", place, set)
                    .with("pressure", place, sign * scale)
                    .with(key, place, value.clone());
                self.add("pressure", table);
            }
        }
        blasts.retain(|id, blast| !used.contains(id) && blast.0.is_some());
        for (id, (_, place)) in blasts {
            let (which, card) = match id {
                AS_CURVE => ("*LOAD_BLAST".to_string(), "*LOAD_SEGMENT_SET with lcid -2"),
                id => (format!("explosion {id}"), "*LOAD_BLAST_SEGMENT_SET"),
            };
            let message = format!("{which} loads no segment: it has no effect");
            self.trouble.warning(place, message, format!("name it on {card}, or remove it"));
        }
    }

    /// Converts `*BOUNDARY_NON_REFLECTING`.
    pub(super) fn non_reflecting(&mut self) {
        let mut number = 0;
        for record in self.take_records("BOUNDARY_NON_REFLECTING") {
            let lines: Vec<CardLine> = record.lines("ssid").cloned().collect();
            for line in lines {
                let (ssid, place) = (line.integer("ssid"), line.place("ssid"));
                let Some(segments) = self.segment_set(ssid, place) else { continue };
                for (_, group, nodes) in self.groups_of_faces(&segments, false) {
                    number += 1;
                    let set = format!("non-reflecting-{number}");
                    self.rows.add_set(set.clone(), nodes, group);
                    let mut table = JobTable::new(line.place).with("nodes", place, set);
                    for (field, key) in [("ad", "pressure_waves"), ("as", "shear_waves")] {
                        if line.real(field) != 0.0 {
                            table.put(key, line.place(field), false);
                        }
                    }
                    self.add("non_reflecting", table);
                }
            }
        }
    }

    /// Converts `*LOAD_SHELL_...`: pressures against the normals of shells.
    fn shell_pressures(&mut self) -> Vec<SegmentPressure> {
        let mut loads = Vec::new();
        let of_elements = self.take_records("LOAD_SHELL_ELEMENT");
        let of_sets = self.take_records("LOAD_SHELL_SET");
        if of_elements.is_empty() && of_sets.is_empty() {
            return loads;
        }
        let shells: BTreeMap<i64, Vec<NodeId>> = self
            .rows
            .elements()
            .filter(|e| e.shape.is_shell())
            .map(|e| (e.id.0 as i64, e.corners().to_vec()))
            .collect();
        let faces = |range: [i64; 2], place: Place| -> Vec<DeckSegment> {
            let found = shells.range(range[0]..=range[1].max(range[0]));
            found.map(|(_, nodes)| DeckSegment { nodes: nodes.clone(), place }).collect()
        };
        for line in of_elements.iter().flat_map(|record| record.lines("lcid")) {
            self.arrival(line);
            let (id, place) = (line.integer("eid"), line.place("eid"));
            let found = faces([id; 2], place);
            let is_removed = self.rows.removed.iter().any(|e| e.id.0 as i64 == id);
            if found.is_empty() && !is_removed {
                let message = format!("*LOAD_SHELL_ELEMENT: there is no shell {id}");
                self.trouble.error(place, message, "correct the id, or remove the line");
            }
            add_pressure(&mut loads, line, found);
        }
        for line in of_sets.iter().flat_map(|record| record.lines("lcid")) {
            self.arrival(line);
            let (id, place) = (line.integer("esid"), line.place("esid"));
            match self.element_sets[SHELL_SETS].get(&id) {
                Some(ranges) => {
                    let found: Vec<_> =
                        ranges.iter().flat_map(|&range| faces(range, place)).collect();
                    if found.is_empty() {
                        let message =
                            format!("*LOAD_SHELL_SET: set {id} has no shells of the deck");
                        self.trouble.error(place, message, "correct the ids of the set");
                    }
                    add_pressure(&mut loads, line, found);
                }
                None => {
                    let sets = self.element_sets[SHELL_SETS].keys();
                    let known: Vec<String> = sets.map(i64::to_string).collect();
                    self.missing(place, "*SET_SHELL_...", id, &known);
                }
            }
        }
        loads
    }

    /// Returns faces in groups of nodes that contain no other face, with the sign of a pressure on
    /// them: 1 if their normal is that of their element, otherwise -1. Reports segments that are no
    /// face.
    pub(super) fn groups_of_faces(
        &mut self,
        segments: &[DeckSegment],
        solids_have_sense: bool,
    ) -> Vec<(f64, Place, Vec<NodeId>)> {
        if segments.is_empty() {
            return Vec::new();
        }
        let faces = self.faces(solids_have_sense);
        let segments = &self.with_triangles(segments)[..];
        let mut found = Vec::new();
        for (along, sign) in [(true, 1.0), (false, -1.0)] {
            let loaded = self.of_sense(segments, &faces, along);
            let groups = whole_groups(&loaded, &faces);
            found.extend(groups.into_iter().map(|(place, nodes)| (sign, place, nodes)));
        }
        found
    }

    /// Returns the nodes of faces that have no other face between them, and true if the normals of
    /// all segments are opposite to those of their elements. Reports segments that are no face, and
    /// other faces.
    pub(super) fn nodes_of_surface(
        &mut self,
        segments: &[DeckSegment],
        place: Place,
        keyword: &str,
    ) -> Option<(Vec<NodeId>, bool)> {
        let faces = self.faces(true);
        let segments = &self.with_triangles(segments)[..];
        let along = self.of_sense(segments, &faces, true);
        let against = self.of_sense(segments, &faces, false);
        if along.len() + against.len() < segments.len() {
            return None;
        }
        let mut groups = whole_groups(segments, &faces);
        if groups.len() != 1 {
            let message = format!(
                "{keyword}: the nodes of the segments have other faces between them, or a segment \
                 is there twice"
            );
            self.unsupported(place, message, format!("{keyword} with such segments"));
            return None;
        }
        groups.pop().map(|(_, nodes)| (nodes, along.is_empty()))
    }

    /// Replaces segments with the three corners of a side of a ten-node tetrahedron by its four
    /// triangles.
    fn with_triangles(&self, segments: &[DeckSegment]) -> Vec<DeckSegment> {
        let mut sides = HashMap::new();
        for element in self.rows.elements().filter(|e| e.shape == Shape::Tet10) {
            for side in element.shape.faces().chunks_exact(4) {
                // The last triangle is the one between the edges.
                let triangles = [0, 1, 2, 3].map(|t| [0, 1, 2].map(|c| element.nodes[side[t][c]]));
                let corners = [0, 1, 2].map(|t| triangles[t][0]);
                sides.insert(key(&corners), (corners, triangles));
            }
        }
        let split = |segment: &DeckSegment| -> Vec<DeckSegment> {
            match sides.get(&key(&segment.nodes)) {
                Some((corners, triangles)) => {
                    let outwards = same_sense(corners, &segment.nodes);
                    let of = |&[a, b, c]: &[NodeId; 3]| DeckSegment {
                        nodes: if outwards { vec![a, b, c] } else { vec![a, c, b] },
                        place: segment.place,
                    };
                    triangles.iter().map(of).collect()
                }
                None => vec![segment.clone()],
            }
        };
        segments.iter().flat_map(split).collect()
    }

    fn arrival(&mut self, line: &CardLine) {
        if line.real("at") != 0.0 {
            let message = format!("`at` = {}: arrival times are not supported", line.real("at"));
            self.unsupported(line.place("at"), message, "*LOAD_SEGMENT at".into());
        }
    }

    /// Returns the faces of all shells, with their nodes in order, and of all solids; with
    /// `solids_have_sense` these have an order too, with the normal outwards.
    fn faces(&self, solids_have_sense: bool) -> HashMap<Vec<NodeId>, Option<Vec<NodeId>>> {
        let mut faces = HashMap::new();
        for element in self.rows.elements() {
            for face in element.shape.faces() {
                let corners: Vec<NodeId> = face.iter().map(|&c| element.nodes[c]).collect();
                let order = match element.shape.is_shell() {
                    true => Some(element.corners().to_vec()),
                    false => solids_have_sense.then(|| {
                        let mut order = corners.clone();
                        order.dedup();
                        order
                    }),
                };
                faces.entry(key(&corners)).or_insert(order);
            }
        }
        faces
    }

    /// Returns the segments whose normal is that of their shell (or those on any solid) if
    /// `along` is true, the other ones otherwise.
    fn of_sense(
        &mut self,
        segments: &[DeckSegment],
        faces: &HashMap<Vec<NodeId>, Option<Vec<NodeId>>>,
        along: bool,
    ) -> Vec<DeckSegment> {
        let of_element = |e: &MeshElement| {
            let corner = |face: &[usize]| face.iter().map(|&c| e.nodes[c]).collect::<Vec<_>>();
            e.shape.faces().iter().map(|face| key(&corner(face))).collect::<Vec<_>>()
        };
        let removed: HashSet<_> = self.rows.removed.iter().flat_map(of_element).collect();
        let mut found = Vec::new();
        for segment in segments {
            match faces.get(&key(&segment.nodes)) {
                // The face of an element of a part that is left out.
                None if removed.contains(&key(&segment.nodes)) => {}
                None if along => {
                    let ids: Vec<String> = segment.nodes.iter().map(NodeId::to_string).collect();
                    let message =
                        format!("the segment {} is not a face of an element", ids.join(" "));
                    self.trouble.error(
                        segment.place,
                        message,
                        "give the nodes of a shell, or of one face of a solid",
                    );
                }
                Some(order) => {
                    let same = order.as_ref().is_none_or(|order| same_sense(order, &segment.nodes));
                    found.extend((same == along).then(|| segment.clone()));
                }
                None => {}
            }
        }
        found
    }
}

/// Returns true if two cycles of the same nodes have the same direction.
fn same_sense(order: &[NodeId], nodes: &[NodeId]) -> bool {
    let next = |cycle: &[NodeId], n: NodeId| {
        let at = cycle.iter().position(|&m| m == n)?;
        cycle.get((at + 1) % cycle.len()).copied()
    };
    nodes.first().is_some_and(|&n| next(order, n) == next(nodes, n))
}

/// Returns the segments in groups of nodes that contain no other face: one group if possible,
/// otherwise one per segment.
fn whole_groups(
    segments: &[DeckSegment],
    faces: &HashMap<Vec<NodeId>, Option<Vec<NodeId>>>,
) -> Vec<(Place, Vec<NodeId>)> {
    let Some(first) = segments.first() else { return Vec::new() };
    let nodes: BTreeSet<NodeId> = segments.iter().flat_map(|s| s.nodes.iter().copied()).collect();
    let wanted: BTreeSet<Vec<NodeId>> = segments.iter().map(|s| key(&s.nodes)).collect();
    let held = faces.keys().filter(|face| face.iter().all(|n| nodes.contains(n))).count();
    if held == wanted.len() && wanted.len() == segments.len() {
        return vec![(first.place, nodes.into_iter().collect())];
    }
    segments.iter().map(|s| (s.place, key(&s.nodes))).collect()
}
