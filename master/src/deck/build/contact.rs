//! `*CONTACT_...`: all contacts of a deck are one, in which every part meets every other and itself.

use super::Build;
use crate::deck::record::Record;
use crate::job::tree::Place;
use std::collections::BTreeSet;

const KEYWORDS: [(&str, bool); 11] = [
    ("CONTACT_AUTOMATIC_SINGLE_SURFACE", true),
    ("CONTACT_AUTOMATIC_GENERAL", true),
    ("CONTACT_SINGLE_SURFACE", true),
    ("CONTACT_ERODING_SINGLE_SURFACE", true),
    ("CONTACT_AUTOMATIC_SURFACE_TO_SURFACE", false),
    ("CONTACT_AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE", false),
    ("CONTACT_AUTOMATIC_NODES_TO_SURFACE", false),
    ("CONTACT_SURFACE_TO_SURFACE", false),
    ("CONTACT_NODES_TO_SURFACE", false),
    ("CONTACT_ERODING_SURFACE_TO_SURFACE", false),
    ("CONTACT_ERODING_NODES_TO_SURFACE", false),
];

/// Fields with no bearing on a contact that needs no stiffness, and what a blank stands for.
const IGNORED: [&str; 22] = [
    "vdc", "penchk", "sfsa", "sfsb", "sfsat", "sfsbt", "fsf", "vsf", "soft", "sofscl", "maxpar", "sbopt", "depth",
    "bsort", "frcfrq", "penmax", "shlthk", "snlog", "igap", "ignore", "dprfac", "edgek",
];

/// Fields that would change the surfaces.
const THICKNESSES: [&str; 3] = ["sast", "sbst", "sldthk"];

impl Build {
    pub(super) fn contacts(&mut self) {
        let mut parts: Option<BTreeSet<i64>> = Some(BTreeSet::new());
        let mut place: Option<Place> = None;
        let mut frictions: Vec<(f64, Place)> = Vec::new();
        let mut number = 0;
        for (keyword, single) in KEYWORDS {
            for record in self.take(keyword) {
                number += 1;
                place = place.or(Some(record.head));
                let name = format!("contact {number}");
                let sides: &[(&str, &str)] = match single {
                    true => &[("surfa", "surfatyp")],
                    false => &[("surfa", "surfatyp"), ("surfb", "surfbtyp")],
                };
                for (side, kind) in sides {
                    match (self.side(&record, side, kind), &mut parts) {
                        (Some(own), Some(all)) => all.extend(own),
                        (None, _) => parts = None,
                        _ => {}
                    }
                }
                frictions.push((self.friction(&record, &name), record.place("fs")));
                let said =
                    ["AUTOMATIC_", "ERODING_"].iter().fold(keyword.replace("CONTACT_", ""), |n, w| n.replace(w, ""));
                let used = match single {
                    true => "every part with every other and itself",
                    false => "both sides with each other, and each with itself",
                };
                self.map(&name, said.to_lowercase().replace('_', " "), used);
                self.options(&record, &name);
            }
        }
        let Some(place) = place else { return };
        let most = frictions.iter().map(|f| f.0).fold(0.0, f64::max);
        if let Some(&(other, at)) = frictions.iter().find(|f| f.0 != most) {
            let message = format!("contacts have different friction, {other} and {most}; there is one contact here");
            self.trouble.warning(
                at,
                message,
                format!("{most} holds for all; give contact.friction in a job to change it"),
            );
        }
        let at = frictions.iter().find(|f| f.0 == most).map_or(place, |f| f.1);
        self.tree.set_in("contact", "friction", at, most);
        if let Some(parts) = parts {
            self.tree.set_in("contact", "parts", place, parts.into_iter().collect::<Vec<_>>());
        }
    }

    /// Parts of one side; `None` for all.
    fn side(&mut self, record: &Record, side: &str, kind: &str) -> Option<Vec<i64>> {
        let (id, place) = (record.integer(side), record.place(side));
        match record.integer(kind) {
            5 => None,
            _ if id == 0 => None,
            2 => Some(self.part_set(id, place)),
            3 => Some(if self.has_part(id, place) { vec![id] } else { Vec::new() }),
            6 => {
                let out = self.part_set(id, place);
                Some(self.parts.keys().copied().filter(|p| !out.contains(p)).collect())
            }
            0 => match self.segment_sets.get(&id) {
                Some(set) => {
                    let nodes: BTreeSet<_> = set.iter().flat_map(|s| s.nodes.iter().copied()).collect();
                    Some(self.parts_with(record, side, "segments", &nodes))
                }
                None => {
                    let known: Vec<String> = self.segment_sets.keys().map(i64::to_string).collect();
                    self.missing(place, "*SET_SEGMENT", id, &known);
                    Some(Vec::new())
                }
            },
            4 => {
                self.node_set(id, place)?;
                let nodes: BTreeSet<_> = self.node_sets[&id].0.iter().copied().collect();
                Some(self.parts_with(record, side, "nodes", &nodes))
            }
            _ => {
                self.unsupported_value(record, kind, "0 segments, 2 and 6 set of parts, 3 part, 4 nodes, 5 all");
                Some(Vec::new())
            }
        }
    }

    /// Parts that have any of these nodes: contact goes by whole parts.
    fn parts_with(
        &mut self,
        record: &Record,
        side: &str,
        what: &str,
        nodes: &BTreeSet<crumple_proto::ids::NodeId>,
    ) -> Vec<i64> {
        let found: BTreeSet<i64> = self
            .rows
            .elements()
            .filter(|e| !e.shape.faces().is_empty() && e.corners().iter().any(|n| nodes.contains(n)))
            .map(|e| i64::from(e.part))
            .collect();
        let list: Vec<String> = found.iter().map(i64::to_string).collect();
        self.map(
            "contact",
            format!("{side}: {what} of set {}", record.integer(side)),
            format!("the parts {}", list.join(", ")),
        );
        found.into_iter().collect()
    }

    fn friction(&mut self, record: &Record, name: &str) -> f64 {
        let fs = record.real("fs");
        if fs == -1.0 {
            return self.friction_of_parts(record, name);
        }
        if fs < 0.0 {
            self.unsupported_value(record, "fs", "-1 is the friction of the parts, other codes name tables");
            return 0.0;
        }
        self.friction_at_speed(record, name)
    }

    /// The largest friction of `*PART_CONTACT`, which holds for all as that of several contacts does.
    fn friction_of_parts(&mut self, record: &Record, name: &str) -> f64 {
        let own: BTreeSet<u64> = self.part_friction.values().map(|f| f.to_bits()).collect();
        let most = own.iter().map(|&f| f64::from_bits(f)).fold(0.0, f64::max);
        if own.len() > 1 {
            let message = "parts have different friction; there is one for all here".to_string();
            let help = format!("{most} holds, the largest; give contact.friction in a job to change it");
            self.trouble.warning(record.place("fs"), message, help);
        }
        self.map(name, "fs -1: friction of the parts", format!("friction {most}"));
        most
    }

    /// Friction of a card with fs, fd and dc.
    pub(super) fn friction_at_speed(&mut self, record: &Record, name: &str) -> f64 {
        let (fs, fd, dc) = (record.real("fs"), record.real("fd"), record.real("dc"));
        if dc > 0.0 && fs != fd {
            self.map(name, format!("friction from {fs} down to {fd} with the speed"), format!("friction {fd}"));
            return fd;
        }
        if fs != fd {
            self.map(name, format!("fs {fs}, fd {fd}, no decay"), format!("friction {fs}"));
        }
        fs
    }

    /// Options that are not used, in one line.
    fn options(&mut self, record: &Record, name: &str) {
        let given = |field: &&str| {
            let default = record
                .row
                .cards
                .iter()
                .flat_map(|c| &c.0.fields)
                .find(|f| f.name == **field)
                .map_or(0.0, |f| f.default);
            !record.is_blank(field) && record.real(field) != default && record.real(field) != 0.0
        };
        let ignored: Vec<String> =
            IGNORED.iter().filter(|f| given(f)).map(|f| format!("{f} {}", record.real(f))).collect();
        if !ignored.is_empty() {
            self.map(name, ignored.join(", "), "not used");
        }
        for field in THICKNESSES.iter().filter(|f| given(f)) {
            self.unsupported_value(record, field, "contact is as thick as its shells");
        }
        for field in ["saboxid", "sbboxid"].iter().filter(|f| record.integer(f) != 0) {
            self.unsupported_value(record, field, "contact goes by parts");
        }
        let (birth, death) = (record.real("bt"), record.real("dt"));
        if birth > 0.0 || (death > 0.0 && death < self.end_time) {
            let field = if birth > 0.0 { "bt" } else { "dt" };
            self.unsupported_value(record, field, "contact that comes or goes within the run");
        }
    }
}
