//! Converts seat belts: `*ELEMENT_SEATBELT_...`, `*MAT_SEATBELT` and their parts.

use super::DeckConverter;
use super::sets::id;
use super::tree::JobTable;
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::job::tree::Place;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::Shape;
use std::collections::{BTreeMap, BTreeSet};

/// Part of the length of an element by which the node of a ring or retractor may be off its belt.
const OFF: f64 = 0.01;
/// Length over the fed length of a retractor up to which an element at it is wound up.
const COINCIDENT: f64 = 1e-3;
/// Smallest length over that of the shortest element, if the deck has none.
const TENTH: f64 = 0.1;

/// An element of a belt.
#[derive(Clone, Debug)]
struct DeckBelt {
    part: u32,
    ends: [NodeId; 2],
    /// Unstretched length less the distance of its nodes [length].
    slack: f64,
    place: Place,
}

/// Seat belts of a deck.
#[derive(Debug, Default)]
pub struct DeckBelts {
    /// By the ids of the deck.
    elements: BTreeMap<i64, DeckBelt>,
    laws: BTreeMap<i64, CardRecord>,
    rings: Vec<CardRecord>,
    retractors: Vec<CardRecord>,
    /// Number that has been added to the ids, because springs have them too.
    raise: u64,
}

impl DeckBelts {
    /// Returns the ids of the materials.
    pub fn laws(&self) -> impl Iterator<Item = &i64> {
        self.laws.keys()
    }
}

impl DeckConverter {
    /// Reads elements and materials. Nodes of rings and retractors take the places of those of
    /// their elements.
    pub(super) fn belt_elements(&mut self) {
        for record in self.take_records("MAT_SEATBELT") {
            let (mid, place) = (record.integer("mid"), record.place("mid"));
            if self.belts.laws.insert(mid, record).is_some() {
                let message = format!("there are two materials with the id {mid}");
                self.trouble.error(place, message, "give each a different id");
            }
        }
        for record in self.take_records("ELEMENT_SEATBELT") {
            for line in record.lines("eid") {
                self.belt_element(&record, line);
            }
        }
        self.belts.rings = self.take_records("ELEMENT_SEATBELT_SLIPRING");
        self.belts.retractors = self.take_records("ELEMENT_SEATBELT_RETRACTOR");
        for ring in self.belts.rings.clone() {
            self.move_onto_ring(&ring);
        }
        for retractor in self.belts.retractors.clone() {
            self.move_onto_retractor(&retractor);
        }
        let springs = self.rows.elements().filter(|e| e.shape == Shape::Line2);
        let springs: BTreeSet<u64> = springs.map(|e| e.id.0).collect();
        if self.belts.elements.keys().any(|eid| springs.contains(&(*eid as u64))) {
            let own = self.belts.elements.keys().map(|eid| *eid as u64);
            let most = springs.iter().copied().chain(own).max().unwrap_or(0);
            let mut raise = 10u64;
            while raise <= most && raise < 1_000_000_000_000_000 {
                raise *= 10;
            }
            self.belts.raise = raise;
            self.map("belts", "ids that springs have too", format!("ids raised by {raise}"));
        }
        for (eid, belt) in &self.belts.elements {
            let own = ElemId(*eid as u64 + self.belts.raise);
            self.rows.spring(own, belt.part, belt.ends, belt.place);
        }
    }

    fn belt_element(&mut self, record: &CardRecord, line: &CardLine) {
        let eid = line.integer("eid");
        if line.integer("n3") != 0 || line.integer("n4") != 0 {
            let message = format!(
                "{}: element {eid} is a shell (n3, n4): belts of shells are not supported",
                record.name()
            );
            let what = format!("{} n3", record.name());
            return self.unsupported(line.place("n3"), message, what);
        }
        let ids = [id(eid), id(line.integer("n1")), id(line.integer("n2"))];
        let part = u32::try_from(line.integer("pid")).ok();
        let ([Some(_), Some(n1), Some(n2)], Some(part)) = (ids, part) else {
            let message = format!("{}: element {eid} has an invalid id", record.name());
            let help = "give whole numbers above 0; the largest part id is 4294967295";
            return self.trouble.error(line.place, message, help);
        };
        let slack = line.real("slen");
        let belt = DeckBelt { part, ends: [n1, n2], slack, place: line.place };
        if self.belts.elements.insert(eid, belt).is_some() {
            let message = format!("there are two elements of belts with the id {eid}");
            self.trouble.error(line.place, message, "give each a different id");
        }
    }

    /// Returns an element that a ring or retractor names.
    fn named_belt(&mut self, record: &CardRecord, field: &str) -> Option<DeckBelt> {
        let eid = record.integer(field);
        let found = self.belts.elements.get(&eid).cloned();
        if found.is_none() {
            let known: Vec<String> = self.belts.elements.keys().map(i64::to_string).collect();
            self.missing(record.place(field), "*ELEMENT_SEATBELT", eid, &known);
        }
        found
    }

    /// Returns the distance of two nodes [length].
    fn distance(&mut self, a: NodeId, b: NodeId) -> Option<f64> {
        let (a, b) = (self.rows.at(a)?, self.rows.at(b)?);
        Some((0..3).map(|c| (b[c] - a[c]).powi(2)).sum::<f64>().sqrt())
    }

    /// Puts the node of a ring or retractor into all elements in place of `from`, which has to be
    /// at the same place.
    fn put_anchor(&mut self, record: &CardRecord, from: NodeId, ends: [NodeId; 2]) {
        let place = record.place("sbrnid");
        let Some(to) = id(record.integer("sbrnid")) else { return };
        if from == to {
            return;
        }
        let apart = self.distance(from, to);
        let length = self.distance(ends[0], ends[1]);
        if let (Some(apart), Some(length)) = (apart, length)
            && apart > OFF * length
        {
            let message = format!(
                "{}: node {to} is {apart:.4e} away from node {from} of the belt",
                record.name()
            );
            let help = "put the node of a ring or a retractor and that of the belt at one place";
            return self.trouble.error(place, message, help);
        }
        for belt in self.belts.elements.values_mut() {
            belt.ends.iter_mut().filter(|end| **end == from).for_each(|end| *end = to);
        }
    }

    fn move_onto_ring(&mut self, ring: &CardRecord) {
        let (first, second) = (self.named_belt(ring, "sbid1"), self.named_belt(ring, "sbid2"));
        let (Some(first), Some(second)) = (first, second) else { return };
        let Some(&common) = first.ends.iter().find(|end| second.ends.contains(end)) else {
            let message = format!(
                "{}: the elements {} and {} have no common node",
                ring.name(),
                ring.integer("sbid1"),
                ring.integer("sbid2")
            );
            let help = "name the elements before and after the ring";
            return self.trouble.error(ring.place("sbid1"), message, help);
        };
        self.put_anchor(ring, common, first.ends);
    }

    fn move_onto_retractor(&mut self, retractor: &CardRecord) {
        let Some(mouth) = self.named_belt(retractor, "sbid") else { return };
        let Some(own) = id(retractor.integer("sbrnid")) else { return };
        if mouth.ends.contains(&own) {
            return;
        }
        let away = mouth.ends.map(|end| self.distance(end, own).unwrap_or(f64::INFINITY));
        let near = mouth.ends[usize::from(away[1] < away[0])];
        self.put_anchor(retractor, near, mouth.ends);
    }

    /// Converts a part of belts.
    pub(super) fn belt_part(&mut self, record: &CardRecord, name: &str) {
        let (pid, mid) = (record.integer("pid"), record.integer("mid"));
        let Some(law) = self.belts.laws.get(&mid).cloned() else {
            let known: Vec<String> = self.belts.laws.keys().map(i64::to_string).collect();
            return self.missing(record.place("mid"), "*MAT_SEATBELT", mid, &known);
        };
        let mut belt =
            JobTable::new(law.head).with("mass_per_length", law.place("mpul"), law.real("mpul"));
        for (key, field) in [("force_strain", "llcid"), ("unloading", "ulcid")] {
            let (lcid, place) = (law.integer(field), law.place(field));
            if lcid == 0 && field == "ulcid" {
                continue;
            }
            let Some(curve) = self.curve(lcid, place) else { continue };
            let carries = |p: &&[f64; 2]| p[0] >= 0.0 || p[1] != 0.0;
            let points: Vec<Vec<f64>> =
                curve.points.iter().filter(carries).map(|p| p.to_vec()).collect();
            belt.put(key, curve.place, points);
        }
        let ends: Vec<[NodeId; 2]> = self
            .belts
            .elements
            .values()
            .filter(|e| i64::from(e.part) == pid)
            .map(|e| e.ends)
            .collect();
        let lengths = ends.iter().filter_map(|[a, b]| self.distance(*a, *b));
        let shortest = lengths.filter(|l| *l > 0.0).fold(f64::INFINITY, f64::min);
        let least = match law.real("lmin") {
            0.0 if shortest.is_finite() => {
                let used = format!("min_length {:.4e}, a tenth of the shortest", TENTH * shortest);
                self.map(format!("part {pid}"), "lmin 0", used);
                TENTH * shortest
            }
            given => given,
        };
        belt.put("min_length", law.place("lmin"), least);
        self.map(format!("part {pid}"), law.name(), "seat belts");
        let table = JobTable::new(record.head)
            .with("id", record.place("pid"), pid)
            .with("name", record.place("heading"), name)
            .with("belt", law.head, belt);
        self.add("part", table);
    }

    /// Converts rings, retractors, pretensioners and sensors, and the lengths of elements.
    pub(super) fn belts(&mut self) {
        self.belt_lengths();
        let rings: Vec<JobTable> = std::mem::take(&mut self.belts.rings)
            .iter()
            .map(|ring| {
                let mut table = device(ring, "slipring", "sbsrid")
                    .with("node", ring.place("sbrnid"), ring.integer("sbrnid"))
                    .with("friction", ring.place("fc"), ring.real("fc"));
                if ring.real("fcs") != 0.0 {
                    table.put("static_friction", ring.place("fcs"), ring.real("fcs"));
                    table.put("decay", ring.place("dc"), ring.real("dc"));
                }
                let lock = ring.real("ltime");
                if lock > 0.0 && lock < 1e19 {
                    table.put("lock_time", ring.place("ltime"), lock);
                }
                table
            })
            .collect();
        let mut retractors = Vec::new();
        for reel in std::mem::take(&mut self.belts.retractors) {
            let mut table = device(&reel, "retractor", "sbrid")
                .with("node", reel.place("sbrnid"), reel.integer("sbrnid"))
                .with("delay", reel.place("tdel"), reel.real("tdel"))
                .with("pull_out", reel.place("pull"), reel.real("pull"));
            sensors(&mut table, &reel, ["sid1", "sid2", "sid3", "sid4"]);
            self.belt_curve(&mut table, "force_pull_out", &reel, "llcid");
            if reel.integer("ulcid") != 0 {
                self.belt_curve(&mut table, "unloading", &reel, "ulcid");
            }
            if reel.real("lfed") > 0.0 {
                table.put("fed_length", reel.place("lfed"), reel.real("lfed"));
            }
            retractors.push(table);
        }
        let mut pretensioners = Vec::new();
        for charge in self.take_records("ELEMENT_SEATBELT_PRETENSIONER") {
            if !matches!(charge.integer("sbprty"), 1 | 5) {
                let why = "pretensioners other than those with a pull-in over time (1 and 5)";
                self.unsupported_card(&charge, "sbprty", why);
                continue;
            }
            let reel = format!("retractor-{}", charge.integer("sbrid"));
            let mut table = device(&charge, "pretensioner", "sbprid")
                .with("retractor", charge.place("sbrid"), reel)
                .with("delay", charge.place("time"), charge.real("time"));
            sensors(&mut table, &charge, ["sbsid1", "sbsid2", "sbsid3", "sbsid4"]);
            self.belt_curve(&mut table, "pull_in", &charge, "ptlcid");
            if charge.integer("sbprty") == 5 && charge.real("lmtfrc") > 0.0 {
                table.put("force_limit", charge.place("lmtfrc"), charge.real("lmtfrc"));
            }
            pretensioners.push(table);
        }
        let cards = self.take_records("ELEMENT_SEATBELT_SENSOR");
        let sensors = cards.iter().filter_map(|card| self.belt_sensor(card)).collect();
        let lists = [
            ("ring", rings),
            ("retractor", retractors),
            ("pretensioner", pretensioners),
            ("sensor", sensors),
        ];
        for (list, entries) in lists {
            if let Some(place) = entries.first().map(JobTable::place) {
                self.tree.set_in("belts", list, place, entries);
            }
        }
    }

    /// Sets the unstretched lengths of elements with slack, and of those that are wound up: they
    /// have the fed length of their retractor.
    fn belt_lengths(&mut self) {
        let reels: Vec<(NodeId, f64)> = self
            .belts
            .retractors
            .iter()
            .filter_map(|reel| Some((id(reel.integer("sbrnid"))?, reel.real("lfed"))))
            .collect();
        let known: BTreeSet<ElemId> = self.rows.elements().map(|e| e.id).collect();
        let mut rows = Vec::new();
        let elements = std::mem::take(&mut self.belts.elements);
        for (eid, belt) in &elements {
            let own = self.rows.spring_id(ElemId(*eid as u64 + self.belts.raise));
            let distance = self.distance(belt.ends[0], belt.ends[1]).unwrap_or(0.0);
            let mut length = distance + belt.slack;
            let mut nearest = (f64::INFINITY, 0.0);
            for &(reel, fed) in &reels {
                let away = self.distance(reel, belt.ends[0]).unwrap_or(f64::INFINITY);
                if away < nearest.0 {
                    nearest = (away, fed);
                }
            }
            // An element at its reel is wound up.
            if length <= COINCIDENT * nearest.1 {
                length = nearest.1;
            }
            if length != distance && known.contains(&own) {
                rows.push((vec![own.0 as f64, length], belt.place));
            }
        }
        if let Some(&(_, place)) = rows.first() {
            let rows: Vec<Vec<f64>> = rows.into_iter().map(|row| row.0).collect();
            self.tree.set_in("belts", "unstretched", place, rows);
        }
        self.belts.elements = elements;
    }

    fn belt_curve(&mut self, table: &mut JobTable, key: &str, record: &CardRecord, field: &str) {
        if let Some(curve) = self.curve(record.integer(field), record.place(field)) {
            let rows: Vec<Vec<f64>> = curve.points.iter().map(|p| p.to_vec()).collect();
            table.put(key, curve.place, rows);
        }
    }

    fn belt_sensor(&mut self, card: &CardRecord) -> Option<JobTable> {
        let mut table = device(card, "sensor", "sbsid");
        match card.integer("sbstyp") {
            1 => {
                let axis = (card.integer("dof") - 1).clamp(0, 2) as usize;
                if !(1..=3).contains(&card.integer("dof")) {
                    self.unsupported_card(card, "dof", "directions other than 1, 2 and 3");
                    return None;
                }
                let mut direction = [0.0; 3];
                table.put("node", card.place("nid"), card.integer("nid"));
                // A limit below 0 is one of the other sense.
                let limit = card.real("acc");
                direction[axis] = if limit < 0.0 { -1.0 } else { 1.0 };
                table.put("direction", card.place("dof"), direction);
                table.put("acceleration", card.place("acc"), limit.abs());
                table.put("duration", card.place("atime"), card.real("atime"));
            }
            2 => {
                let reel = format!("retractor-{}", card.integer("sbrid"));
                table.put("retractor", card.place("sbrid"), reel);
                table.put("pull_out_rate", card.place("pulrat"), card.real("pulrat"));
                table.put("duration", card.place("pultim"), card.real("pultim"));
            }
            3 => table.put("time", card.place("time"), card.real("time")),
            4 => {
                let nodes = ["nid1", "nid2"].map(|field| card.integer(field));
                table.put("nodes", card.place("nid1"), nodes.to_vec());
                for (key, field) in [("max_distance", "dmx"), ("min_distance", "dmn")] {
                    if card.real(field) > 0.0 {
                        table.put(key, card.place(field), card.real(field));
                    }
                }
            }
            _ => {
                self.unsupported_card(card, "sbstyp", "sensors of other types than 1 to 4");
                return None;
            }
        }
        Some(table)
    }
}

/// Returns the table of a device, named by its kind and its id.
fn device(record: &CardRecord, kind: &str, field: &str) -> JobTable {
    let name = format!("{kind}-{}", record.integer(field));
    JobTable::new(record.head).with("name", record.place(field), name)
}

/// Puts the names of sensors into a table.
fn sensors(table: &mut JobTable, record: &CardRecord, fields: [&str; 4]) {
    let ids = fields.map(|field| record.integer(field));
    let names: Vec<String> =
        ids.iter().filter(|id| **id != 0).map(|id| format!("sensor-{id}")).collect();
    table.put("sensors", record.place(fields[0]), names);
}
