//! Converts masses, gravity, and forces on nodes.

use super::DeckConverter;
use super::sets::id;
use super::tree::JobTable;
use crate::input::deck::record::CardLine;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::{BTreeMap, HashSet};

/// Keywords of gravity along the axes, and along a vector.
const BODY_LOADS: [&str; 4] = ["LOAD_BODY_X", "LOAD_BODY_Y", "LOAD_BODY_Z", "LOAD_BODY_VECTOR"];
/// Consequence of a body load that is left out.
const LOST: &str = "the load is left out: there is no gravity by it";

impl DeckConverter {
    /// Converts `*ELEMENT_MASS`.
    pub(super) fn masses(&mut self) {
        let mut equal: BTreeMap<u64, (f64, Vec<NodeId>, Place)> = BTreeMap::new();
        let lost = self.rows.lost_nodes();
        for record in self.take_records("ELEMENT_MASS") {
            for line in record.lines("nid") {
                let mass = line.real("mass");
                let of =
                    equal.entry(mass.to_bits()).or_insert_with(|| (mass, Vec::new(), line.place));
                of.1.extend(id(line.integer("nid")).filter(|node| !lost.contains(node)));
            }
        }
        for (number, (mass, nodes, place)) in
            equal.into_values().enumerate().filter(|(_, m)| m.0 != 0.0 && !m.1.is_empty())
        {
            let name = format!("mass-{}", number + 1);
            let total = mass * nodes.len() as f64;
            self.rows.add_set(name.clone(), nodes, place);
            self.add(
                "mass",
                JobTable::new(place).with("nodes", place, name).with("mass", place, total),
            );
        }
        for record in self.take_records("ELEMENT_MASS_PART") {
            let lines: Vec<CardLine> = record.lines("pid").cloned().collect();
            for line in lines.iter().filter(|line| line.real("addmass") != 0.0) {
                let (pid, place) = (line.integer("pid"), line.place("pid"));
                if !self.has_part(pid, place) {
                    continue;
                }
                let set = self.nodes_of_parts(&[pid]);
                let mass = line.real("addmass");
                self.map(
                    format!("part {pid}"),
                    format!("a mass of {mass} by area or volume"),
                    "the same mass on each of its nodes",
                );
                let table = JobTable::new(line.place).with("nodes", place, set);
                self.add("mass", table.with("mass", line.place("addmass"), mass));
            }
        }
        for record in self.take_records("ELEMENT_MASS_NODE_SET") {
            for line in record.lines("nsid") {
                let Some(set) = self.node_set(line.integer("nsid"), line.place("nsid")) else {
                    continue;
                };
                let table = JobTable::new(line.place).with("nodes", line.place("nsid"), set);
                self.add("mass", table.with("mass", line.place("mass"), line.real("mass")));
            }
        }
    }

    /// Converts `*LOAD_BODY_...`: an acceleration of the frame of reference, so bodies accelerate
    /// in the opposite direction.
    pub(super) fn body_loads(&mut self) {
        let mut parts: Vec<i64> = Vec::new();
        let chosen = self.take_records("LOAD_BODY_PARTS");
        for record in &chosen {
            parts.extend(self.part_set(record.integer("psid"), record.place("psid")));
        }
        parts.sort_unstable();
        parts.dedup();
        match chosen.first().filter(|_| parts.is_empty()) {
            // An empty list of parts would be the whole model.
            Some(record) => {
                BODY_LOADS.iter().for_each(|keyword| drop(self.take_records(keyword)));
                let message = format!("{}: the model has no part of its sets", record.name());
                let help = "the model has no gravity of *LOAD_BODY_X, Y and Z";
                self.trouble.warning(record.place("psid"), message, help);
            }
            None => self.body_loads_of(&parts),
        }
        self.part_gravity();
        self.accelerations();
    }

    /// Converts `*LOAD_GRAVITY_PART`, with the sign of `*LOAD_BODY_...`.
    fn part_gravity(&mut self) {
        for (keyword, field) in [("LOAD_GRAVITY_PART", "pid"), ("LOAD_GRAVITY_PART_SET", "psid")] {
            for record in self.take_records(keyword) {
                let lines: Vec<CardLine> = record.lines(field).cloned().collect();
                for line in lines {
                    let (id, place) = (line.integer(field), line.place(field));
                    let parts = self.parts_named(field, id, place);
                    let dof = line.integer("dof");
                    if parts.is_empty() || !(1..=3).contains(&dof) {
                        if !parts.is_empty() {
                            let message = format!("{keyword}: `dof` is {dof}");
                            let help = "give 1, 2 or 3 for x, y or z";
                            self.trouble.error(line.place("dof"), message, help);
                        }
                        continue;
                    }
                    let mut acceleration = [0.0; 3];
                    acceleration[dof as usize - 1] = -line.real("accel");
                    let mut table = JobTable::new(line.place)
                        .with("acceleration", line.place("accel"), acceleration)
                        .with("parts", place, parts);
                    if line.integer("lc") != 0 {
                        let at = line.place("lc");
                        let Some(curve) = self.time_curve(line.integer("lc"), at) else { continue };
                        table.put("curve", at, curve);
                    }
                    self.map(
                        format!("*{keyword} {id}"),
                        format!("dof {dof}, accel {}", line.real("accel")),
                        format!("acceleration {acceleration:?}, as of *LOAD_BODY"),
                    );
                    self.add("gravity", table);
                }
            }
        }
    }

    fn body_loads_of(&mut self, parts: &[i64]) {
        for (axis, keyword) in BODY_LOADS.into_iter().enumerate() {
            for record in self.take_records(keyword) {
                let Some(line) = record.line("lcid").cloned() else { continue };
                let along = match keyword {
                    "LOAD_BODY_VECTOR" => ["v1", "v2", "v3"].map(|name| record.real(name)),
                    _ => [0, 1, 2].map(|c| if c == axis { 1.0 } else { 0.0 }),
                };
                let scale = -record.real("sf");
                let given = along.map(|c| if c == 0.0 { 0.0 } else { scale * c });
                let Some(acceleration) = self.in_global_axes(given, &line, "cid", LOST) else {
                    continue;
                };
                let place = record.place("lcid");
                let Some(curve) = self.time_curve(record.integer("lcid"), place) else { continue };
                let mut table = JobTable::new(record.head).with(
                    "acceleration",
                    record.place("sf"),
                    acceleration,
                );
                if !parts.is_empty() {
                    table.put("parts", record.head, parts.to_vec());
                }
                self.add("gravity", table.with("curve", place, curve));
            }
        }
    }

    /// Converts `*LOAD_NODE_...`.
    pub(super) fn nodal_loads(&mut self) {
        for (keyword, field) in [("LOAD_NODE_SET", "nsid"), ("LOAD_NODE_POINT", "nid")] {
            let mut used: Option<HashSet<NodeId>> = None;
            for record in self.take_records(keyword) {
                let lines: Vec<CardLine> = record.lines(field).cloned().collect();
                for line in lines {
                    let of = line.integer(field);
                    let set = if field == "nsid" {
                        self.node_set(of, line.place(field))
                    } else {
                        let name = format!("load-node-{of}");
                        self.rows.add_set(
                            name.clone(),
                            id(of).into_iter().collect(),
                            line.place(field),
                        );
                        Some(name)
                    };
                    let Some(set) = set else { continue };
                    // A deck loads each node; a job divides a force among the nodes with
                    // elements.
                    let used = used
                        .get_or_insert_with(|| self.rows.nodes_of(|_| true).into_iter().collect());
                    let count = match field {
                        "nsid" => self.node_sets[&of].0.iter().filter(|n| used.contains(n)).count(),
                        _ => 1,
                    };
                    let force = line.real("sf") * count as f64;
                    self.nodal_load(&line, set, force);
                }
            }
        }
    }

    fn nodal_load(&mut self, line: &CardLine, set: String, force: f64) {
        let dof = line.integer("dof");
        if !matches!(dof, 1..=3 | 5..=7) {
            let message = format!(
                "a nodal load with dof {dof} is not supported: it follows nodes, and loads keep \
                 their direction"
            );
            return self.unsupported(line.place("dof"), message, format!("*LOAD_NODE dof={dof}"));
        }
        let Some(curve) = self.time_curve(line.integer("lcid"), line.place("lcid")) else { return };
        let (key, axis) = if dof < 4 { ("force", dof - 1) } else { ("moment", dof - 5) };
        let local = [0, 1, 2].map(|c| if c == axis { force } else { 0.0 });
        let lost = "the load is left out: it does not act on the nodes";
        let Some(amount) = self.in_global_axes(local, line, "cid", lost) else { return };
        let table = JobTable::new(line.place)
            .with("nodes", line.place, set)
            .with(key, line.place("dof"), amount)
            .with("curve", line.place("lcid"), curve);
        self.add("load", table);
    }
}
