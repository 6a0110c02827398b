//! `*ELEMENT_DISCRETE`, and the sections and laws of its parts.

use super::Build;
use super::sections::Section;
use super::sets::id;
use super::tree::Table;
use crate::deck::record::Record;
use crate::job::tree::Place;
use crumple_proto::ids::{ElemId, NodeId};
use std::collections::BTreeMap;

const LAWS: [&str; 4] =
    ["MAT_SPRING_ELASTIC", "MAT_DAMPER_VISCOUS", "MAT_SPRING_NONLINEAR_ELASTIC", "MAT_DAMPER_NONLINEAR_VISCOUS"];

/// Fields of sections for which there is nothing, and what they ask for.
const UNSERVED: [(&str, &str); 6] = [
    ("dro", "springs and dampers of rotations"),
    ("kd", "stiffnesses that grow with the rate"),
    ("cl", "a clearance"),
    ("fd", "springs that break"),
    ("cdl", "a limit of compression"),
    ("tdl", "a limit of tension"),
];

impl Build {
    /// Elements and laws.
    pub(super) fn springs(&mut self) {
        for record in LAWS.iter().flat_map(|law| self.take(law)).collect::<Vec<_>>() {
            let (mid, place) = (record.integer("mid"), record.place("mid"));
            if self.spring_laws.insert(mid, record).is_some() {
                self.trouble.error(place, format!("there are two materials with the id {mid}"), "give each its own");
            }
        }
        let directions = self.directions();
        let mut grounded: Vec<(NodeId, ElemId, u32, Place)> = Vec::new();
        for record in self.take("ELEMENT_DISCRETE") {
            for line in record.lines("eid") {
                let number = line.integer("eid");
                let mut missing = |field: &str, why: &str| {
                    let message = format!("{}: spring {number} has {why}, which is not supported yet", record.name());
                    self.unsupported(line.place(field), message, format!("{} {field}", record.name()));
                };
                let (to_ground, vid) = (line.integer("n2") == 0, line.integer("vid"));
                if to_ground && vid == 0 {
                    missing("n2", "the ground for its second node and no vid");
                    continue;
                }
                if line.real("offset") != 0.0 {
                    missing("offset", "an elongation at the start");
                }
                let second = line.integer(if to_ground { "n1" } else { "n2" });
                let ids = [number, line.integer("n1"), second].map(id);
                let part = u32::try_from(line.integer("pid")).ok();
                let ([Some(own), Some(n1), Some(n2)], Some(part)) = (ids, part) else {
                    let message = format!("{}: spring {number} has an id that is none", record.name());
                    self.trouble.error(line.place, message, "ids are whole numbers above 0, of parts up to 4294967295");
                    continue;
                };
                let scale = (line.real("s"), line.place("s"));
                let first = self.spring_scales.entry(i64::from(part)).or_insert(scale).0;
                if first != scale.0 {
                    let message = format!("{}: part {part} has springs with s {first} and {}", record.name(), scale.0);
                    self.unsupported(scale.1, message, format!("{} s", record.name()));
                }
                if vid != 0 && !directions.contains_key(&vid) {
                    let known: Vec<String> = directions.keys().map(i64::to_string).collect();
                    self.missing(line.place("vid"), "*DEFINE_SD_ORIENTATION", vid, &known);
                }
                let direction = directions.get(&vid).copied();
                if *self.spring_directions.entry(i64::from(part)).or_insert(direction) != direction {
                    let message = format!("{}: part {part} has springs with different vid", record.name());
                    self.unsupported(line.place("vid"), message, format!("{} vid", record.name()));
                }
                match to_ground {
                    true => grounded.push((n1, ElemId(own.0), part, line.place)),
                    false => self.rows.spring(ElemId(own.0), part, [n1, n2], line.place),
                }
            }
        }
        self.ground(grounded);
    }

    /// Directions by their ids.
    fn directions(&mut self) -> BTreeMap<i64, [f64; 3]> {
        let mut directions = BTreeMap::new();
        for record in self.take("DEFINE_SD_ORIENTATION") {
            if record.integer("iop") != 0 {
                self.unsupported_value(&record, "iop", "0 is a vector that stays; nodes lead no direction");
            }
            directions.insert(record.integer("vid"), ["xt", "yt", "zt"].map(|c| record.real(c)));
        }
        directions
    }

    /// Springs to the ground: each ends at a node of its own where its first one stands, which is held.
    fn ground(&mut self, grounded: Vec<(NodeId, ElemId, u32, Place)>) {
        let Some(&(.., place)) = grounded.first() else { return };
        let at: Vec<([f64; 3], Place)> =
            grounded.iter().map(|g| (self.rows.at(g.0).unwrap_or_default(), g.3)).collect();
        let ends = self.rows.add_nodes(&at);
        for (&(node, own, part, place), &end) in grounded.iter().zip(&ends) {
            self.rows.spring(own, part, [node, end], place);
        }
        let set = "ground-of-springs";
        self.map("springs", format!("{} to the ground", ends.len()), format!("nodes {set} are added there and held"));
        self.rows.add_set(set.into(), ends, place);
        self.add("fix", Table::new(place).with("nodes", place, set).with("dofs", place, vec!["x", "y", "z"]));
    }

    /// A part of springs.
    pub(super) fn spring_part(&mut self, record: &Record, section: &Section, name: &str) {
        let (pid, mid) = (record.integer("pid"), record.integer("mid"));
        for (field, why) in UNSERVED {
            if section.record.real(field) != 0.0 {
                self.unsupported_value(&section.record, field, why);
            }
        }
        let Some(law) = self.spring_laws.get(&mid).cloned() else {
            let known: Vec<String> = self.spring_laws.keys().map(i64::to_string).collect();
            return self.missing(record.place("mid"), "*MAT_SPRING_... or *MAT_DAMPER_...", mid, &known);
        };
        let scale = self.spring_scales.get(&pid).map_or(1.0, |s| s.0);
        let direction = self.spring_directions.get(&pid).copied().flatten();
        let mut spring = Table::new(law.head);
        let (key, field, below) = match law.row.keyword.name {
            "MAT_SPRING_ELASTIC" => ("stiffness", "k", None),
            "MAT_DAMPER_VISCOUS" => ("damping", "dc", None),
            "MAT_SPRING_NONLINEAR_ELASTIC" => ("force_elongation", "lcd", Some("negative elongations")),
            _ => ("force_rate", "lcdr", Some("negative rates")),
        };
        let at = law.place(field);
        match below {
            None => spring.put(key, at, scale * law.real(field)),
            Some(below) => {
                if law.integer("lcr") != 0 {
                    self.unsupported_value(&law, "lcr", "a curve over the rate");
                }
                let Some(curve) = self.curve(law.integer(field), at) else { return };
                if curve.points.first().is_some_and(|p| p[0] >= 0.0) {
                    let asked = format!("curve {} says nothing of {below}", law.integer(field));
                    self.map(format!("part {pid}"), asked, "its first slope goes on there");
                }
                let points: Vec<Vec<f64>> = curve.points.iter().map(|p| vec![p[0], scale * p[1]]).collect();
                spring.put(key, curve.place, points);
            }
        }
        let asked = match scale == 1.0 {
            true => law.name(),
            false => format!("{} scaled by {scale}", law.name()),
        };
        self.map(format!("part {pid}"), asked, format!("springs with {key}"));
        if let Some(direction) = direction {
            spring.put("direction", law.head, direction);
        }
        let table = Table::new(record.head)
            .with("id", record.place("pid"), pid)
            .with("name", record.place("heading"), name)
            .with("spring", law.head, spring);
        self.add("part", table);
    }
}
