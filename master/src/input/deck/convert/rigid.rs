//! Converts rigid bodies: parts of `*MAT_RIGID`, parts switched to rigid, sets of nodes, and
//! joints of these.

use super::DeckConverter;
use super::sets::id;
use super::stops::BodyEntries;
use super::tree::JobTable;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A body under construction, by its leading part.
#[derive(Debug, Default)]
struct DeckBody {
    parts: BTreeSet<i64>,
    nodes: BTreeSet<NodeId>,
    fixed: BTreeSet<&'static str>,
    place: Option<Place>,
}

impl DeckConverter {
    pub(super) fn rigid(&mut self) {
        let (loads, followers) = self.body_forces();
        let mut entries = [self.stops(), loads];
        let mut lead: BTreeMap<i64, i64> = BTreeMap::new();
        for (&id, part) in &self.parts {
            if part.rigid.is_some() {
                lead.insert(id, id);
            }
        }
        self.switched(&mut lead);
        let mut follow = BTreeSet::new();
        for record in self.take_records("CONSTRAINED_RIGID_BODIES") {
            for line in record.lines("pidl") {
                let (l, c) = (line.integer("pidl"), line.integer("pidc"));
                if self.is_rigid(l, line.place("pidl"), &lead)
                    && self.is_rigid(c, line.place("pidc"), &lead)
                {
                    join(&mut lead, l, c);
                    follow.extend((line.integer("iflag") == 0).then_some(c));
                }
            }
        }
        self.join_touching(&mut lead);
        let mut bodies: BTreeMap<i64, DeckBody> = BTreeMap::new();
        for &part in lead.keys() {
            let body = bodies.entry(root(&lead, part)).or_default();
            body.parts.insert(part);
            let of = &self.parts[&part];
            body.fixed.extend(of.rigid.iter().flatten());
            body.place = body.place.or(Some(of.place));
        }
        self.extra_nodes(&lead, &mut bodies);
        let any_extra = bodies.values().any(|body| !body.nodes.is_empty());
        let connected = if any_extra { self.rows.nodes_of(|_| true) } else { Vec::new() };
        for (id, mut body) in bodies {
            let place = body.place.unwrap_or(Place::Whole);
            self.hold(id, &mut body);
            let name = format!("part-{id}");
            let mut table = JobTable::new(place).with("name", place, name.as_str());
            let parts: Vec<i64> = body.parts.into_iter().collect();
            let of_parts = self.rows.nodes_of(|part| parts.contains(&i64::from(part)));
            let has_elements = !of_parts.is_empty();
            let members: Vec<NodeId> =
                of_parts.into_iter().chain(body.nodes.iter().copied()).collect();
            self.put_added_inertia(&members, &mut table);
            self.node_bodies.extend(members.into_iter().map(|node| (node, name.clone())));
            // Nodes without elements have no mass; joints only need their positions.
            self.keep_connected(&mut body.nodes, &connected);
            let set = format!("body-{id}-nodes");
            let extra = body.nodes.len();
            let heavy = self.count_with_mass(&body.nodes);
            if extra > 0 {
                self.rows.add_set(set.clone(), body.nodes.into_iter().collect(), place);
                table.put("nodes", place, set.as_str());
            }
            if !has_elements && extra > 0 {
                parts.iter().for_each(|&part| self.bare_inertia(part, &set));
            } else {
                self.put_inertia(id, (&parts, &follow), heavy, &mut table);
                table.put("parts", place, parts);
            }
            if !body.fixed.is_empty() {
                table.put("fixed", place, body.fixed.into_iter().collect::<Vec<_>>());
            }
            for own in &mut entries {
                own.put(&mut table, |pid| lead.contains_key(&pid) && root(&lead, pid) == id);
            }
            self.add("rigid", table);
        }
        for &part in lead.keys() {
            self.bodies.insert(part, format!("part-{}", root(&lead, part)));
        }
        self.nodal_bodies(&mut entries);
        entries.into_iter().for_each(|own| self.entries_without_body(own));
        self.inertias_without_body();
        self.check_followers(&followers);
    }

    /// Removes nodes without elements from the nodes of a body. They follow it, so they are no
    /// nodes that are left out.
    fn keep_connected(&mut self, nodes: &mut BTreeSet<NodeId>, connected: &[NodeId]) {
        let is_connected = |node: &NodeId| connected.binary_search(node).is_ok();
        self.rows.stand_ins.extend(nodes.iter().filter(|node| !is_connected(node)));
        nodes.retain(is_connected);
    }

    /// Returns the number of nodes that have a mass: of elements other than springs, or by a card.
    fn count_with_mass(&self, nodes: &BTreeSet<NodeId>) -> usize {
        if nodes.is_empty() {
            return 0;
        }
        let rows = &self.rows;
        let elements = rows.shells.iter().chain(&rows.solids).chain(&rows.beams);
        let corners = elements.chain(&rows.particles).flat_map(|e| e.corners());
        let masses = self.records.get("ELEMENT_MASS").into_iter().flatten();
        let by_card = masses.flat_map(|record| record.lines("nid")).map(|line| line.integer("nid"));
        let all = corners.copied().chain(by_card.filter_map(id));
        all.filter(|node| nodes.contains(node)).collect::<BTreeSet<NodeId>>().len()
    }

    /// Fixes what constraints of all nodes of a body fix.
    fn hold(&mut self, id: i64, body: &mut DeckBody) {
        let mut nodes: BTreeSet<NodeId> =
            self.rows.nodes_of(|part| body.parts.contains(&i64::from(part))).into_iter().collect();
        nodes.extend(&body.nodes);
        let held = self.body_held(&nodes);
        if !held.is_empty() {
            let used: Vec<&str> = held.iter().copied().collect();
            self.map(
                format!("rigid part {id}"),
                "constraints of all its nodes",
                format!("the body is fixed: {}", used.join(", ")),
            );
            body.fixed.extend(held);
            return;
        }
        let parts: Vec<i64> = body.parts.iter().copied().collect();
        let centre = self.centre_of(&parts);
        let Some((held, place)) = self.held_by_some(&nodes, centre) else { return };
        let dofs: Vec<&str> = held.iter().copied().collect();
        let message = format!(
            "constraints of some nodes of the rigid part {id} hold its body: it is fixed in {}",
            dofs.join(", ")
        );
        let help = "rotations that would move these nodes are fixed, too: it cannot rock about \
                    them. Use con1 and con2 of *MAT_RIGID, or a joint, if this is not meant";
        self.trouble.warning(place, message, help);
        body.fixed.extend(held);
    }

    /// Converts `*DEFORMABLE_TO_RIGID`.
    fn switched(&mut self, lead: &mut BTreeMap<i64, i64>) {
        for record in self.take_records("DEFORMABLE_TO_RIGID") {
            for line in record.lines("pid") {
                let (pid, place) = (line.integer("pid"), line.place("pid"));
                let parts = match line.word("ptype").to_ascii_uppercase().as_str() {
                    "PSET" => self.part_set(pid, place),
                    _ if self.has_part(pid, place) => vec![pid],
                    _ => Vec::new(),
                };
                for part in parts {
                    if let Entry::Vacant(free) = lead.entry(part) {
                        free.insert(part);
                        self.map(
                            format!("part {part}"),
                            "switched to rigid",
                            "a rigid body for the whole run",
                        );
                    }
                    let other = line.integer("lrb");
                    if other != 0 && self.is_rigid(other, line.place("lrb"), lead) {
                        join(lead, other, part);
                    }
                }
            }
        }
    }

    fn is_rigid(&mut self, part: i64, place: Place, lead: &BTreeMap<i64, i64>) -> bool {
        if lead.contains_key(&part) {
            return true;
        }
        if self.has_part(part, place) {
            let message = format!("part {part} is not rigid");
            self.trouble.error(place, message, "give it a *MAT_RIGID, or name a part that has one");
        }
        false
    }

    /// Joins rigid parts with common nodes to one body, because separate bodies would be
    /// impossible.
    fn join_touching(&mut self, lead: &mut BTreeMap<i64, i64>) {
        let mut owner: HashMap<NodeId, i64> = HashMap::new();
        let mut found: BTreeMap<(i64, i64), usize> = BTreeMap::new();
        for element in self.rows.elements() {
            let part = i64::from(element.part);
            if !lead.contains_key(&part) {
                continue;
            }
            for &node in element.corners() {
                let first = *owner.entry(node).or_insert(part);
                if root(lead, first) != root(lead, part) {
                    join(lead, first.min(part), first.max(part));
                    found.insert((first.min(part), first.max(part)), 1);
                }
            }
        }
        for (a, b) in found.into_keys() {
            self.map(format!("parts {a} and {b}"), "rigid, with nodes in common", "one rigid body");
        }
    }

    fn extra_nodes(&mut self, lead: &BTreeMap<i64, i64>, bodies: &mut BTreeMap<i64, DeckBody>) {
        for (keyword, field) in
            [("CONSTRAINED_EXTRA_NODES_NODE", "nid"), ("CONSTRAINED_EXTRA_NODES_SET", "nsid")]
        {
            for record in self.take_records(keyword) {
                for line in record.lines("pid") {
                    let part = line.integer("pid");
                    if !self.is_rigid(part, line.place("pid"), lead) {
                        continue;
                    }
                    let Some(body) = bodies.get_mut(&root(lead, part)) else { continue };
                    let of = line.integer(field);
                    if field == "nid" {
                        body.nodes.extend(id(of));
                    } else if self.node_set(of, line.place(field)).is_some() {
                        body.nodes.extend(&self.node_sets[&of].0);
                    }
                }
            }
        }
    }

    /// Returns what constraints of nodes of a body of nodes fix of it, and removes the nodes from
    /// these: of all its nodes, of its centre (`centre`), or of one node if that is the same.
    fn hold_nodal(
        &mut self,
        name: &str,
        nodes: &BTreeSet<NodeId>,
        centre: Option<NodeId>,
    ) -> BTreeSet<&'static str> {
        let mut held = self.body_held(nodes);
        let mut what = "constraints of all its nodes";
        if held.is_empty() {
            held = self.held_as_body(nodes, centre);
            what = "constraints of its centre, or of a node of a body that does not turn";
        }
        if !held.is_empty() {
            let used: Vec<&str> = held.iter().copied().collect();
            self.map(name, what, format!("the body is fixed: {}", used.join(", ")));
        }
        held
    }

    /// Converts `*CONSTRAINED_NODAL_RIGID_BODY`.
    fn nodal_bodies(&mut self, entries: &mut [BodyEntries]) {
        for record in self.take_records("CONSTRAINED_NODAL_RIGID_BODY") {
            let pid = record.integer("pid");
            // Without a set number, it is the set with the body's id.
            let (nsid, field) = match record.integer("nsid") {
                0 => (pid, "pid"),
                given => (given, "nsid"),
            };
            for field in ["drflag", "rrflag"] {
                if record.integer(field) != 0 {
                    self.unsupported_value(&record, field, "released degrees of freedom");
                }
            }
            let place = record.place("pid");
            let Some(set) = self.node_set(nsid, record.place(field)) else { continue };
            let name = format!("body-{pid}");
            let mut members: BTreeSet<NodeId> = self.node_sets[&nsid].0.iter().copied().collect();
            self.node_bodies.extend(members.iter().map(|node| (*node, name.clone())));
            let pnode = id(record.integer("pnode"));
            self.rows.stand_ins.extend(pnode);
            let held = self.hold_nodal(&name, &members, pnode);
            let connected = self.rows.nodes_of(|_| true);
            self.keep_connected(&mut members, &connected);
            let mut table = JobTable::new(place).with("name", place, name.as_str()).with(
                "nodes",
                record.place(field),
                set.as_str(),
            );
            let members = self.node_sets[&nsid].0.clone();
            self.nodal_inertia(&record, (&set, &members), &mut table);
            self.put_added_inertia(&members, &mut table);
            let mut fixed = match record.has("SPC") {
                true => self.held_centre(&record),
                false => Vec::new(),
            };
            let more: Vec<&str> = held.into_iter().filter(|dof| !fixed.contains(dof)).collect();
            fixed.extend(more);
            if !fixed.is_empty() {
                let field = if record.has("SPC") { "cmo" } else { "pid" };
                table.put("fixed", record.place(field), fixed);
            }
            entries.iter_mut().for_each(|own| own.put(&mut table, |of| of == pid));
            self.add("rigid", table);
            self.bodies.entry(pid).or_insert(name);
        }
    }
}

fn root(lead: &BTreeMap<i64, i64>, mut part: i64) -> i64 {
    while let Some(&up) = lead.get(&part).filter(|&&up| up != part) {
        part = up;
    }
    part
}

fn join(lead: &mut BTreeMap<i64, i64>, a: i64, b: i64) {
    let (a, b) = (root(lead, a), root(lead, b));
    if a != b {
        lead.insert(b, a);
    }
}
