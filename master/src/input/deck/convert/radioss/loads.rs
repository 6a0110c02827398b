//! Converts forces, gravity, pressure and masses.

use super::StarterConverter;
use super::motion::or_one;
use crate::input::deck::convert::accelerations::{GravityOf, MassesOf};
use crate::input::deck::convert::segments::DeckSegment;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::radioss::keywords::ENGINE_DAMP;
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::BTreeMap;

const DIRECTIONS: [&str; 6] = ["X", "Y", "Z", "XX", "YY", "ZZ"];

impl StarterConverter {
    pub(super) fn loads(&mut self) {
        for record in self.take(&["/CLOAD"]) {
            let Some(line) = record.line("fct").cloned() else { continue };
            self.only_plain(&record);
            let (grnod, place) = (record.integer("grnod"), record.place("grnod"));
            let Some((dof, amount, curve)) = self.direction(&record, &line) else { continue };
            let Some(set) = self.deck.node_set(grnod, place) else { continue };
            let mut nodes = self.deck.node_sets[&grnod].0.clone();
            self.without_inner_mains(&record, &mut nodes, false);
            let (key, axis) = if dof < 3 { ("force", dof) } else { ("moment", dof - 3) };
            let table = |of: JobTable, count: usize| {
                let mut value = [0.0; 3];
                value[axis] = amount * count as f64;
                of.with(key, line.place("fscale"), value).with(
                    "curve",
                    line.place("fct"),
                    curve.as_str(),
                )
            };
            let mains = self.load_bodies(&record, &nodes, |of| table(of, 1));
            // A deck loads each node; a job divides a force among the nodes with elements.
            let used = self.used_nodes();
            let count = nodes.iter().filter(|n| used.contains(n)).count();
            if count > 0 || mains == 0 {
                let of = JobTable::new(record.head).with("nodes", place, set);
                self.deck.add("load", table(of, count));
            }
        }
        for record in self.take(&["/GRAV"]) {
            let Some(line) = record.line("fct").cloned() else { continue };
            self.only_plain(&record);
            let Some((dof, amount, curve)) = self.direction(&record, &line) else { continue };
            if dof > 2 {
                let message = "/GRAV: `dir` has to be X, Y or Z";
                self.deck.trouble.error(line.place("dir"), message, "name an axis");
                continue;
            }
            let of = match record.integer("grnod") {
                0 => GravityOf::All,
                group => match self.deck.node_set(group, record.place("grnod")) {
                    Some(name) => {
                        let nodes = self.deck.node_sets[&group].0.clone();
                        self.deck.gravity_of(&nodes, name)
                    }
                    None => continue,
                },
            };
            let mut value = [0.0; 3];
            value[dof] = amount;
            if !matches!(of, GravityOf::All) {
                let asked = format!("on the nodes of group {}", record.integer("grnod"));
                self.deck.map(record.name(), asked, format!("acceleration {value:?} {of}"));
            }
            let table = JobTable::new(record.head)
                .with("acceleration", line.place("fscale"), value)
                .with("curve", line.place("fct"), curve);
            self.deck.add_gravity(table, of, &record, "grnod");
        }
    }

    /// Converts `/DAMP` with the values that the engine file gives for it.
    pub(super) fn damping(&mut self) {
        let mut of_engine: BTreeMap<i64, CardRecord> = BTreeMap::new();
        for record in self.take(&[ENGINE_DAMP]) {
            of_engine.insert(record.integer("id"), record);
        }
        let mut of_all = 0.0;
        for starter in self.take(&["/DAMP"]) {
            let id = starter.integer("id");
            let values = of_engine.remove(&id).unwrap_or_else(|| starter.clone());
            if values.real("beta") != 0.0 {
                let why = "a damping by the stiffness; alpha damps low frequencies";
                self.deck.unsupported_value(&values, "beta", why);
            }
            let alpha = values.real("alpha");
            if alpha == 0.0 {
                self.deck.map(format!("/DAMP/{id}"), "alpha 0", "no damping");
                continue;
            }
            let (start, stop) = (starter.real("tstart"), starter.real("tstop"));
            if start > 0.0 || (stop > 0.0 && stop < self.deck.end_time) {
                let field = if start > 0.0 { "tstart" } else { "tstop" };
                let why = "damping that begins or ends within the run";
                self.deck.unsupported_value(&starter, field, why);
            }
            let (place, at) = (values.place("alpha"), starter.place("grnod"));
            match self.parts_of(&starter) {
                Some(MassesOf::All) => {
                    of_all += alpha;
                    self.deck.tree.set_in("time", "damping", place, of_all);
                }
                Some(MassesOf::Parts(parts, shared)) => {
                    self.deck.warn_of_shared(&starter, "grnod", ("damping", shared));
                    let table = JobTable::new(starter.head)
                        .with("coefficient", place, alpha)
                        .with("parts", at, parts);
                    self.deck.add("damping", table);
                }
                None => {}
            }
        }
        for (id, record) in of_engine {
            self.deck.missing(record.head, "/DAMP", id, &[]);
        }
    }

    /// Adds a load to the bodies whose main nodes are among these and in no element. Returns the
    /// number of bodies.
    fn load_bodies(
        &mut self,
        record: &CardRecord,
        nodes: &[NodeId],
        load: impl Fn(JobTable) -> JobTable,
    ) -> usize {
        self.used_nodes();
        let mut count = 0;
        for node in nodes.iter().filter(|n| !self.used.contains(n)) {
            let Some(body) = self.mains.get_mut(node) else { continue };
            count += 1;
            body.loads.push(load(JobTable::new(record.head)));
            let name = format!("{}/{}", record.name(), record.integer("id"));
            let asked = format!("load on node {}, the main node of {}", node.label(), body.name);
            if body.keeps_main {
                let message = format!("{name}: {asked}, which is not at the centre of the body");
                let what = "/CLOAD on a body with icog 3 or 4".into();
                self.deck.unsupported(record.place("grnod"), message, what);
            } else {
                self.deck.map(name, asked, "at the centre of mass of the body");
            }
        }
        count
    }

    /// Returns the parts whose nodes the group of a record has; `None` after a report.
    fn parts_of(&mut self, record: &CardRecord) -> Option<MassesOf> {
        let (grnod, place) = (record.integer("grnod"), record.place("grnod"));
        if grnod == 0 {
            return Some(MassesOf::All);
        }
        self.deck.node_set(grnod, place)?;
        let group = self.deck.node_sets[&grnod].0.clone();
        let of = self.deck.parts_of_group(&group);
        if of.is_none() {
            let why = "damping acts on the masses of whole parts";
            self.deck.unsupported_card(record, "grnod", why);
        }
        of
    }

    /// Returns the degree of freedom of a load, its amount and its curve.
    fn direction(&mut self, record: &CardRecord, line: &CardLine) -> Option<(usize, f64, String)> {
        let word = line.word("dir").to_ascii_uppercase();
        let Some(dof) = DIRECTIONS.iter().position(|d| *d == word) else {
            let message = format!("{}: `dir` has to be a direction, not `{word}`", record.name());
            let help = "give X, Y or Z, or XX, YY or ZZ for a moment, in the columns 11 to 20";
            self.deck.trouble.error(line.place("dir"), message, help);
            return None;
        };
        let amount = or_one(line.real("fscale"));
        let curve = self.time_function(line, or_one(line.real("ascale")))?;
        Some((dof, amount, curve))
    }

    pub(super) fn pressures(&mut self) {
        let mut number = 0;
        for record in self.take(&["/PLOAD"]) {
            let Some(line) = record.line("fct").cloned() else { continue };
            let (id, place) = (record.integer("surf"), record.place("surf"));
            // A positive value acts along the normal in a deck, and against it in a job.
            let amount = -or_one(line.real("fscale"));
            let curve = self.time_function(&line, or_one(line.real("ascale")));
            let (Some(surface), Some(curve)) = (self.surface(id, place), curve) else { continue };
            let table = |key: &str, value: JobTable| {
                value.with("pressure", line.place(key), amount).with(
                    "curve",
                    line.place("fct"),
                    curve.as_str(),
                )
            };
            if !surface.parts.is_empty() {
                let parts: Vec<i64> = surface.parts.iter().copied().collect();
                let of = JobTable::new(record.head).with("parts", place, parts);
                self.deck.add("pressure", table("fscale", of));
            }
            let groups = self.deck.groups_of_faces(&surface.segments, true);
            for (sign, of, nodes) in groups {
                number += 1;
                let set = format!("pressure-{number}");
                let set = self.deck.rows.add_new_set(&set, nodes, of);
                let mut whole = table("fscale", JobTable::new(of).with("nodes", of, set));
                whole.put("pressure", line.place("fscale"), sign * amount);
                self.deck.add("pressure", whole);
            }
        }
    }

    /// Converts `/ADMAS`.
    pub(super) fn masses(&mut self) {
        self.used_nodes();
        let lost = self.deck.rows.lost_nodes();
        let mut equal: BTreeMap<u64, (f64, Vec<NodeId>, Place)> = BTreeMap::new();
        for record in self.take(&["/ADMAS"]) {
            let kind = record.integer("kind");
            for line in record.lines("of").cloned().collect::<Vec<_>>() {
                let (mass, of, place) = (line.real("mass"), line.integer("of"), line.place("of"));
                match kind {
                    0 | 1 => {
                        if self.deck.node_set(of, place).is_none() {
                            continue;
                        }
                        let nodes = self.deck.node_sets[&of].0.clone();
                        let count = nodes.len().max(1) as f64;
                        let each = if kind == 0 { mass } else { mass / count };
                        let total = if kind == 0 { mass * count } else { mass };
                        self.mass_of_group(&record, (of, nodes), (each, total), place);
                    }
                    5 => {
                        let Some(node) = super::groups::node(of) else { continue };
                        self.warn_of_walls(&record, &[node]);
                        let is_none = self.wall_nodes.contains(&node) || lost.contains(&node);
                        if is_none || self.mass_of_main(node, mass, place) {
                            continue;
                        }
                        let entry = equal
                            .entry(mass.to_bits())
                            .or_insert_with(|| (mass, Vec::new(), line.place));
                        entry.1.push(node);
                    }
                    _ => {
                        let why =
                            "use 0 (each node of a group), 1 (a whole group) or 5 (single nodes)";
                        self.deck.unsupported_card(&record, "kind", why);
                        break;
                    }
                }
            }
        }
        for (number, (mass, nodes, place)) in (1..).zip(equal.into_values()) {
            let total = mass * nodes.len() as f64;
            let set = self.deck.rows.add_new_set(&format!("mass-{number}"), nodes, place);
            self.put_mass(place, set, total);
        }
    }

    /// Adds a mass to the nodes of a group: `each` on each of them, `total` on all.
    fn mass_of_group(
        &mut self,
        record: &CardRecord,
        (id, nodes): (i64, Vec<NodeId>),
        (each, total): (f64, f64),
        place: Place,
    ) {
        self.warn_of_walls(record, &nodes);
        let count = nodes.len();
        let mut others: Vec<NodeId> =
            nodes.into_iter().filter(|&n| !self.mass_of_main(n, each, place)).collect();
        let lost = self.deck.rows.lost_nodes();
        others.retain(|node| !self.wall_nodes.contains(node) && !lost.contains(node));
        if others.len() == count {
            return self.put_mass(place, format!("set-{id}"), total);
        }
        if !others.is_empty() {
            let total = each * others.len() as f64;
            let set = self.deck.rows.add_new_set(&format!("mass of set-{id}"), others, place);
            self.put_mass(place, set, total);
        }
    }

    /// Adds the mass of a main node, which is no part of the model, to the nodes of its body.
    /// Returns false if the node is none.
    fn mass_of_main(&mut self, node: NodeId, mass: f64, place: Place) -> bool {
        let body = self.mains.get(&node).or_else(|| self.inner_bodies.get(&node));
        let Some(body) = body.filter(|_| !self.used.contains(&node)) else { return false };
        let (name, nodes) = (body.name.clone(), body.own.iter().copied().collect());
        let set = self.deck.rows.add_new_set(&format!("{name} mass"), nodes, place);
        self.put_mass(place, set, mass);
        let asked = format!("/ADMAS: mass {mass} of its main node");
        self.deck.map(name, asked, "in equal shares on its nodes");
        true
    }

    fn put_mass(&mut self, place: Place, set: String, mass: f64) {
        if mass != 0.0 {
            let table = JobTable::new(place).with("nodes", place, set).with("mass", place, mass);
            self.deck.add("mass", table);
        }
    }
}

/// Returns the ids of the nodes of faces.
pub fn nodes_of_faces(segments: &[DeckSegment]) -> Vec<NodeId> {
    let mut nodes: Vec<NodeId> = segments.iter().flat_map(|s| s.nodes.iter().copied()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
