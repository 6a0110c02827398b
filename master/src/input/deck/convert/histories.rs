//! Converts `*CONTACT_FORCE_TRANSDUCER_...`, `*DATABASE_CROSS_SECTION_...`,
//! `*DATABASE_HISTORY_NODE...`: quantities to record. They do not change a run, so unsupported
//! content is only a warning.

use super::DeckConverter;
use super::names::names;
use super::sets::{ELEMENT_SETS, ElementSets, id, ids};
use super::space::{cross, unit};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::{MeshElement, Shape};
use std::collections::{BTreeSet, HashSet};

impl DeckConverter {
    pub(super) fn histories(&mut self) {
        self.transducers();
        let mut sections = Vec::new();
        let sets = std::mem::take(&mut self.element_sets);
        let (of_sets, of_planes) = (
            self.take_records("DATABASE_CROSS_SECTION_SET"),
            self.take_records("DATABASE_CROSS_SECTION_PLANE"),
        );
        let names = names(of_sets.iter().chain(&of_planes), "cross section ", ["title", "csid"]);
        let (set_names, plane_names) = names.split_at(of_sets.len());
        for (record, name) in of_sets.iter().zip(set_names) {
            sections.extend(self.section_of_sets(record, name.clone(), &sets));
        }
        for (record, name) in of_planes.iter().zip(plane_names) {
            sections.extend(self.section_of_plane(record, name.clone()));
        }
        sections.extend(self.weld_forces());
        self.put_list("section", sections);
        self.node_histories();
    }

    /// Adds tables to a list of `[output]`.
    pub(super) fn put_list(&mut self, key: &str, list: Vec<(Place, JobTable)>) {
        let Some(&(place, _)) = list.first() else { return };
        let tables: Vec<JobTable> = list.into_iter().map(|entry| entry.1).collect();
        self.tree.set_in("output", key, place, tables);
    }

    fn transducers(&mut self) {
        let mut transducers = Vec::new();
        let records = self.take_records("CONTACT_FORCE_TRANSDUCER_PENALTY");
        let names = names(&records, "transducer ", ["heading", "cid"]);
        for (record, name) in records.iter().zip(names) {
            let mut table =
                JobTable::new(record.head).with("name", record.place("heading"), name.as_str());
            let surfaces = [
                ("surfa", "surfatyp", ["parts", "nodes"]),
                ("surfb", "surfbtyp", ["from_parts", "from_nodes"]),
            ];
            let mut all = [true; 2];
            for ((side, kind, keys), all) in surfaces.into_iter().zip(&mut all) {
                *all = !self.felt_surface(record, &name, (side, kind), keys, &mut table);
            }
            if all[0] {
                let help = "give the measured surface as surfa: the force of all parts on all \
                    parts is zero";
                self.trouble.warning(
                    record.place("surfa"),
                    format!("{name} is left out: it has no surface"),
                    help,
                );
                continue;
            }
            let from = if all[1] { "from all" } else { "from surfb" };
            self.map(
                &name,
                "force transducer",
                format!("transducers.csv: contact force on surfa {from}"),
            );
            transducers.push((record.head, table));
        }
        self.put_list("transducer", transducers);
    }

    /// Adds a surface of a transducer. Returns true if it is a surface that does not include
    /// everything.
    fn felt_surface(
        &mut self,
        record: &CardRecord,
        name: &str,
        (side, kind): (&str, &str),
        [parts, nodes]: [&str; 2],
        table: &mut JobTable,
    ) -> bool {
        let (number, place) = (record.integer(side), record.place(side));
        if number == 0 {
            return false;
        }
        match record.integer(kind) {
            0 => {
                let Some(set) = self.segment_set(number, place) else { return false };
                let own: BTreeSet<NodeId> =
                    set.iter().flat_map(|s| s.nodes.iter().copied()).collect();
                let set = format!("segments-{number}");
                self.rows.add_set(set.clone(), own.into_iter().collect(), place);
                table.put(nodes, place, set);
                self.map(
                    name,
                    format!("{side}: segments of set {number}"),
                    "their nodes, and the faces between them",
                );
            }
            4 => {
                let Some(set) = self.node_set(number, place) else { return false };
                table.put(nodes, place, set);
            }
            5 => return false,
            2 => table.put(parts, place, self.part_set(number, place)),
            3 if self.has_part(number, place) => table.put(parts, place, vec![number]),
            3 => return false,
            6 => {
                let out = self.part_set(number, place);
                let rest: Vec<i64> =
                    self.parts.keys().copied().filter(|p| !out.contains(p)).collect();
                if rest.is_empty() {
                    // An empty surface is different from one that includes everything.
                    let message = format!("{name}: {side} excludes all parts");
                    self.trouble.error(place, message, "exclude fewer parts, or remove it");
                    return false;
                }
                table.put(parts, place, rest);
            }
            _ => {
                self.unsupported_value(
                    record,
                    kind,
                    "use 0 (segments), 2 or 6 (set of parts), 3 (part), 4 (nodes) or 5 (all)",
                );
                return false;
            }
        }
        true
    }

    fn section_of_sets(
        &mut self,
        record: &CardRecord,
        name: String,
        sets: &[ElementSets; 4],
    ) -> Option<(Place, JobTable)> {
        let set = self.node_set(record.integer("nsid"), record.place("nsid"))?;
        let mut elements: Vec<i64> = Vec::new();
        for (kind, (_, _, field)) in ELEMENT_SETS.iter().enumerate() {
            let (number, place) = (record.integer(field), record.place(field));
            if number == 0 {
                continue;
            }
            let Some(ranges) = sets[kind].get(&number) else {
                let message = format!(
                    "{name}: there is no set of elements with the id {number} that `{field}` gives"
                );
                self.trouble.warning(
                    place,
                    message,
                    "it is ignored: list its elements one by one or by ranges",
                );
                continue;
            };
            elements.extend(self.elements_in(kind, ranges).iter().map(|e| e.id.0 as i64));
        }
        if record.integer("tsid") != 0 {
            let message = format!("{name}: elements of `tsid` are ignored");
            let help = "use solids, shells, beams or springs";
            self.trouble.warning(record.place("tsid"), message, help);
        }
        let nodes: HashSet<NodeId> =
            self.node_sets[&record.integer("nsid")].0.iter().copied().collect();
        let ends = |e: &&MeshElement| e.corners().iter().any(|n| nodes.contains(n));
        let there: HashSet<i64> =
            self.rows.elements().filter(ends).map(|e| e.id.0 as i64).collect();
        elements.retain(|e| there.contains(e));
        self.section(record, name, set, elements)
    }

    fn section(
        &mut self,
        record: &CardRecord,
        name: String,
        set: String,
        elements: Vec<i64>,
    ) -> Option<(Place, JobTable)> {
        let rigid = |e: &&MeshElement| self.bodies.contains_key(&i64::from(e.part));
        let without_forces: HashSet<u64> =
            self.rows.elements().filter(rigid).map(|e| e.id.0).collect();
        let elements: Vec<i64> =
            elements.into_iter().filter(|&e| !without_forces.contains(&(e as u64))).collect();
        if elements.is_empty() {
            let help =
                "name deformable elements at its nodes, or a plane that cuts deformable elements";
            self.trouble.warning(
                record.head,
                format!("{name} is left out: it has no elements"),
                help,
            );
            return None;
        }
        if record.integer("id") != 0 {
            self.map(&name, "forces in the axes of id", "in global axes");
        }
        self.map(&name, "cross section", format!("sections.csv: {} elements", elements.len()));
        let table = JobTable::new(record.head).with("name", record.place("title"), name);
        Some((
            record.head,
            table.with("nodes", record.head, set).with("elements", record.head, elements),
        ))
    }

    fn section_of_plane(&mut self, record: &CardRecord, name: String) -> Option<(Place, JobTable)> {
        let place = record.place("psid");
        let parts: Option<Vec<i64>> = match record.integer("psid") {
            0 => None,
            set => Some(self.part_set(set, place)),
        };
        let plane = CuttingPlane::from_record(record);
        let Some(plane) = plane else {
            let help = "give a head that differs from the tail";
            self.trouble.warning(
                record.place("xch"),
                format!("{name} is left out: its normal has no direction"),
                help,
            );
            return None;
        };
        let own = |e: &&MeshElement| parts.as_ref().is_none_or(|p| p.contains(&i64::from(e.part)));
        let elements: Vec<MeshElement> = self.rows.elements().filter(own).copied().collect();
        let (mut cut, mut nodes, mut beams) = (Vec::new(), BTreeSet::new(), 0);
        for e in &elements {
            let corners: Vec<(NodeId, [f64; 3])> =
                e.corners().iter().filter_map(|&n| self.rows.at(n).map(|x| (n, x))).collect();
            let behind = |x: &[f64; 3]| plane.height(x) <= 0.0;
            let count = corners.iter().filter(|c| behind(&c.1)).count();
            let middle = [0, 1, 2]
                .map(|c| corners.iter().map(|n| n.1[c]).sum::<f64>() / corners.len().max(1) as f64);
            if count == 0 || count == corners.len() || !plane.reaches(&middle) {
                continue;
            }
            if e.shape == Shape::Beam2 {
                beams += 1;
                continue;
            }
            cut.push(e.id.0 as i64);
            nodes.extend(corners.iter().filter(|c| behind(&c.1)).map(|c| c.0));
        }
        if beams > 0 {
            let message = format!("{name}: {beams} beams that the plane cuts are ignored");
            self.trouble.warning(record.head, message, "use shells, solids or springs");
        }
        let set = format!("{name} nodes");
        self.rows.add_set(set.clone(), nodes.into_iter().collect(), record.head);
        self.section(record, name, set, cut)
    }

    /// Returns the histories of accelerometers, and adds their masses.
    fn accelerometers(&mut self) -> Vec<(Place, JobTable)> {
        let mut histories = Vec::new();
        for record in self.take_records("ELEMENT_SEATBELT_ACCELEROMETER") {
            for line in record.lines("sbacid") {
                let name = format!("accelerometer {}", line.integer("sbacid"));
                let nodes = ["nid1", "nid2", "nid3"].map(|field| line.integer(field));
                let table = JobTable::new(line.place)
                    .with("name", line.place("sbacid"), name.as_str())
                    .with("ids", line.place("nid1"), vec![nodes[0]])
                    .with("axes", line.place("nid1"), nodes.to_vec());
                histories.push((line.place, table));
                let mass = line.real("mass");
                if mass != 0.0 {
                    self.rows.add_set(
                        name.clone(),
                        nodes.into_iter().filter_map(id).collect(),
                        line.place,
                    );
                    let table = JobTable::new(line.place).with("nodes", line.place("nid1"), name);
                    self.add("mass", table.with("mass", line.place("mass"), mass));
                }
            }
        }
        histories
    }

    fn node_histories(&mut self) {
        // First, because a binout has only the first history of a node.
        let mut histories = self.accelerometers();
        for record in self.take_records("DATABASE_HISTORY_NODE_SET") {
            for (set, place) in ids(&record, "id") {
                if let Some(name) = self.node_set(set, place) {
                    let mut table = JobTable::new(record.head).with("nodes", place, name);
                    if let Some(title) = self.node_set_titles.get(&set) {
                        table.put("name", place, title.as_str());
                    }
                    histories.push((place, table));
                }
            }
        }
        let used: HashSet<NodeId> =
            self.rows.elements().flat_map(|e| e.corners()).copied().collect();
        let mut there = |(number, place): &(i64, Place)| {
            let found = id(*number).is_some_and(|n| used.contains(&n));
            if !found {
                let message = format!("a history names node {number}, which no element has");
                self.trouble.warning(*place, message, "the history is ignored");
                self.rows.stand_ins.extend(id(*number));
            }
            found
        };
        let mut named = Vec::new();
        for record in self.records.remove("DATABASE_HISTORY_NODE").unwrap_or_default() {
            let own: Vec<(i64, Place)> =
                ids(&record, "id").into_iter().filter(&mut there).collect();
            let list: Vec<i64> = own.iter().map(|n| n.0).collect();
            named.extend(
                (!list.is_empty()).then(|| {
                    (record.head, JobTable::new(record.head).with("ids", record.head, list))
                }),
            );
        }
        for record in self.records.remove("DATABASE_HISTORY_NODE_ID").unwrap_or_default() {
            for line in record.lines("id") {
                if there(&(line.integer("id"), line.place("id"))) {
                    let table = JobTable::new(line.place).with(
                        "name",
                        line.place("heading"),
                        line.word("heading"),
                    );
                    named.push((
                        line.place,
                        table.with("ids", line.place("id"), vec![line.integer("id")]),
                    ));
                }
            }
        }
        histories.extend(named);
        self.put_list("node", histories);
    }
}

/// A cutting plane, with or without an edge.
struct CuttingPlane {
    tail: [f64; 3],
    /// Unit normal.
    normal: [f64; 3],
    /// Radius of a disc around the tail, 0 for none [length].
    radius: f64,
    /// Sides of a rectangle from the tail, as unit vectors with their lengths; 0 for an infinite
    /// side [length].
    sides: [([f64; 3], f64); 2],
}

impl CuttingPlane {
    fn from_record(record: &CardRecord) -> Option<Self> {
        let tail = ["xct", "yct", "zct"].map(|c| record.real(c));
        let head = ["xch", "ych", "zch"].map(|c| record.real(c));
        let normal = unit([0, 1, 2].map(|c| head[c] - tail[c]))?;
        let edge = ["xhev", "yhev", "zhev"].map(|c| record.real(c));
        let along = [0, 1, 2].map(|c| edge[c] - tail[c]);
        let lift = dot(&along, &normal);
        let sides = match unit([0, 1, 2].map(|c| along[c] - lift * normal[c])) {
            Some(first) => {
                [(first, record.real("lenl")), (cross(normal, first), record.real("lenm"))]
            }
            None => [([0.0; 3], 0.0); 2],
        };
        Some(Self { tail, normal, radius: record.real("radius"), sides })
    }

    fn height(&self, x: &[f64; 3]) -> f64 {
        dot(&self.offset(x), &self.normal)
    }

    fn offset(&self, x: &[f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|c| x[c] - self.tail[c])
    }

    /// Returns true if a point lies within the edge of the plane, seen along its normal.
    fn reaches(&self, x: &[f64; 3]) -> bool {
        let (d, lift) = (self.offset(x), self.height(x));
        let aside = (dot(&d, &d) - lift * lift).max(0.0).sqrt();
        let within = |(side, length): &([f64; 3], f64)| {
            *length <= 0.0 || (0.0..=*length).contains(&dot(&d, side))
        };
        if self.radius > 0.0 { aside <= self.radius } else { self.sides.iter().all(within) }
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
