//! Converts `*ELEMENT_DISCRETE`, and the sections of its parts.

use super::DeckConverter;
use super::sections::DeckSection;
use super::sets::id;
use super::spring_laws::{LAWS, SpringCard};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crumple_proto::ids::ElemId;
use std::collections::BTreeMap;

/// Unsupported fields of sections, and their requests.
const UNSERVED: [(&str, &str); 5] = [
    ("kd", "a stiffness that depends on the rate"),
    ("cl", "a clearance"),
    ("fd", "failure of springs"),
    ("cdl", "a limit of compression"),
    ("tdl", "a limit of tension"),
];

/// Direction of springs on a card of `*DEFINE_SD_ORIENTATION`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeckDirection {
    /// A vector.
    Fixed([f64; 3]),
    /// From one node to another, at each time.
    Nodes([u64; 2]),
}

/// Orientation of springs; true if the line between their nodes is projected onto the plane normal
/// to the direction.
pub type SpringOrientation = (DeckDirection, bool);

impl DeckConverter {
    /// Converts elements and laws.
    pub(super) fn springs(&mut self) {
        for record in LAWS.iter().flat_map(|law| self.take_records(law)).collect::<Vec<_>>() {
            let (mid, place) = (record.integer("mid"), record.place("mid"));
            if self.spring_laws.insert(mid, record).is_some() {
                self.trouble.error(
                    place,
                    format!("there are two materials with the id {mid}"),
                    "give each a different id",
                );
            }
        }
        let orientations = self.orientations();
        for record in self.take_records("ELEMENT_DISCRETE") {
            for line in record.lines("eid") {
                let number = line.integer("eid");
                let mut missing = |field: &str, why: &str| {
                    let message = format!(
                        "{}: spring {number} has {why}, which is not supported yet",
                        record.name()
                    );
                    self.unsupported(
                        line.place(field),
                        message,
                        format!("{} {field}", record.name()),
                    );
                };
                let (vid, grounded) = (line.integer("vid"), line.integer("n2") == 0);
                if grounded && vid == 0 {
                    missing("n2", "no second node (n2) and no direction (vid)");
                    continue;
                }
                if line.real("offset") != 0.0 {
                    missing("offset", "an initial elongation");
                }
                if vid != 0 && !orientations.contains_key(&vid) {
                    let known: Vec<String> = orientations.keys().map(i64::to_string).collect();
                    let of = ("*DEFINE_SD_ORIENTATION", vid);
                    self.missing_for(line.place("vid"), of, &known, "the spring is left out");
                    continue;
                }
                let first = id(line.integer("n1"));
                let second = match first.filter(|_| grounded) {
                    Some(node) => self.rows.ground(node, line.place),
                    None => id(line.integer("n2")),
                };
                let ids = [id(number), first, second];
                let part = u32::try_from(line.integer("pid")).ok();
                let ([Some(own), Some(n1), Some(n2)], Some(part)) = (ids, part) else {
                    let message = format!("{}: spring {number} has an invalid id", record.name());
                    self.trouble.error(
                        line.place,
                        message,
                        "give whole numbers above 0; the largest part id is 4294967295",
                    );
                    continue;
                };
                let scale = (line.real("s"), line.place("s"));
                let first = self.spring_scales.entry(i64::from(part)).or_insert(scale).0;
                if first != scale.0 {
                    let message = format!(
                        "{}: part {part} has springs with s {first} and {}",
                        record.name(),
                        scale.0
                    );
                    self.unsupported(scale.1, message, format!("{} s", record.name()));
                }
                let along = (orientations.get(&vid).copied(), line.place("vid"));
                if self.spring_directions.entry(i64::from(part)).or_insert(along).0 != along.0 {
                    let message = format!(
                        "{}: part {part} has springs with different directions",
                        record.name()
                    );
                    self.unsupported(along.1, message, format!("{} vid", record.name()));
                }
                self.rows.spring(ElemId(own.0), part, [n1, n2], line.place);
            }
        }
    }

    /// Returns the orientations.
    fn orientations(&mut self) -> BTreeMap<i64, SpringOrientation> {
        let mut found = BTreeMap::new();
        for record in self.take_records("DEFINE_SD_ORIENTATION") {
            for line in record.lines("vid") {
                let (vid, iop) = (line.integer("vid"), line.integer("iop"));
                let along = ["xt", "yt", "zt"].map(|c| line.real(c));
                let nodes = ["nid1", "nid2"].map(|field| id(line.integer(field)));
                let (direction, place, help) = match (iop, nodes) {
                    (0 | 1, _) => (
                        (along != [0.0; 3]).then_some(DeckDirection::Fixed(along)),
                        line.place("xt"),
                        "give xt, yt, zt: a vector along the springs, or normal to them",
                    ),
                    (2 | 3, [Some(from), Some(to)]) => {
                        let nodes = [from, to].map(|node| node.0);
                        (Some(DeckDirection::Nodes(nodes)), line.place("nid1"), "")
                    }
                    (2 | 3, _) => (None, line.place("nid1"), "give nid1 and nid2: two nodes"),
                    _ => (None, line.place("iop"), "give an iop of 0 to 3"),
                };
                let Some(direction) = direction else {
                    let message = format!("{}: vid {vid} has no direction", record.name());
                    self.trouble.error(place, message, help);
                    continue;
                };
                found.insert(vid, (direction, matches!(iop, 1 | 3)));
            }
        }
        found
    }

    /// Converts a part of springs.
    pub(super) fn spring_part(&mut self, record: &CardRecord, section: &DeckSection, name: &str) {
        let (pid, mid) = (record.integer("pid"), record.integer("mid"));
        for (field, why) in UNSERVED {
            if section.record.real(field) != 0.0 {
                self.unsupported_value(&section.record, field, why);
            }
        }
        let Some(law) = self.spring_laws.get(&mid).cloned() else {
            let known: Vec<String> = self.spring_laws.keys().map(i64::to_string).collect();
            return self.missing(
                record.place("mid"),
                "*MAT_SPRING_... or *MAT_DAMPER_...",
                mid,
                &known,
            );
        };
        let scale = self.spring_scales.get(&pid).map_or(1.0, |s| s.0);
        let mut spring = JobTable::new(law.head);
        let rotational = section.record.integer("dro") == 1;
        if rotational {
            spring.put("rotational", section.record.place("dro"), true);
            if self.submodels.iter().any(|submodel| submodel.units != [1.0; 3]) {
                let why = "a rotational spring next to files in other units; use one set of units";
                self.unsupported_value(&section.record, "dro", why);
            }
        }
        let Some(key) = self.spring_law(&SpringCard { card: &law, pid, scale }, &mut spring) else {
            return;
        };
        if let Some(&(Some((direction, projected)), at)) = self.spring_directions.get(&pid) {
            match direction {
                DeckDirection::Fixed(along) => spring.put("direction", at, along),
                DeckDirection::Nodes(nodes) => {
                    let ids = nodes.map(|node| i64::try_from(node).unwrap_or(i64::MAX));
                    spring.put("direction_nodes", at, ids.to_vec());
                }
            }
            if projected {
                spring.put("projected", at, true);
            }
        }
        let asked = match scale == 1.0 {
            true => law.name(),
            false => format!("{} scaled by {scale}", law.name()),
        };
        let kind = if rotational { "rotational springs" } else { "springs" };
        self.map(format!("part {pid}"), asked, format!("{kind} with {key}"));
        let table = JobTable::new(record.head)
            .with("id", record.place("pid"), pid)
            .with("name", record.place("heading"), name)
            .with("spring", law.head, spring);
        self.add("part", table);
    }
}
