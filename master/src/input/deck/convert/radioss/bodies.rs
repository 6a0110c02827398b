//! Converts `/RBODY` and `/RBE2`, and constraints. Conditions on the main node of a body act on the
//! body.

use super::StarterConverter;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::{BTreeMap, BTreeSet};

const TRANSLATIONS: [&str; 3] = ["x", "y", "z"];
const ROTATIONS: [&str; 3] = ["rx", "ry", "rz"];
/// ICoG of a body that has mass and inertia of its main node only.
const ONLY_MAIN: i64 = 4;

/// A rigid body of a deck.
#[derive(Debug)]
pub struct StarterBody {
    /// Name in the job.
    pub name: String,
    /// Nodes of its group, and the main node if elements have it.
    pub nodes: BTreeSet<NodeId>,
    /// Those without the nodes of inner bodies: they carry the mass of the main node.
    pub own: BTreeSet<NodeId>,
    /// Degrees of freedom that are fixed.
    fixed: BTreeSet<&'static str>,
    /// Place of the keyword.
    place: Place,
    /// Place of its number, for the order.
    order: usize,
    /// Name of the node set of all its nodes, once there is one.
    pub set: Option<String>,
    /// True if walls stop its nodes.
    pub in_walls: bool,
    /// Mass that is added to it [mass].
    pub mass: f64,
    /// Inertia that is added to it, xx, yy, zz, xy, yz, zx [mass length^2], and its place.
    pub added_inertia: Option<([f64; 6], Place)>,
    /// Forces and moments on it.
    pub loads: Vec<JobTable>,
    /// True if the main node stays where it is, and does not move to the centre of the body.
    pub keeps_main: bool,
}

impl StarterConverter {
    pub(super) fn bodies(&mut self) {
        for (order, record) in self.take(&["/RBODY", "/RBE2"]).into_iter().enumerate() {
            let id = record.integer("id");
            let is_link = record.row.keyword.name == "/RBE2";
            if is_link && !self.ties_all(&record) {
                continue;
            }
            let place = record.place("grnod");
            let Some(set) = self.deck.node_set(record.integer("grnod"), place) else { continue };
            let group = self.deck.node_sets[&record.integer("grnod")].0.clone();
            if group.is_empty() {
                let message = format!("{}/{id}: {set} has no nodes", record.name());
                let help = "give the nodes of the body, or remove it";
                self.deck.trouble.error(place, message, help);
                continue;
            }
            let Some(main) = self.main_node(&record) else { continue };
            let mut nodes: BTreeSet<NodeId> = group.into_iter().collect();
            if self.used_nodes().contains(&main) || is_link {
                nodes.insert(main);
            } else {
                self.deck.rows.stand_ins.insert(main);
                self.deck.map(
                    format!("node {}", main.label()),
                    "main node of /RBODY, in no element",
                    "no part of the model: conditions on it act on its body",
                );
            }
            let name = self.body_name(&record, id, is_link);
            let fixed = BTreeSet::new();
            let mass = if is_link { 0.0 } else { record.real("mass") };
            let in_walls = is_link || record.integer("ikrem") == 1;
            let keeps_main = !is_link && record.integer("icog") > 2;
            let added_inertia = if is_link { None } else { self.added_inertia(&record) };
            let place = record.head;
            let body = StarterBody {
                name,
                own: nodes.clone(),
                nodes,
                fixed,
                place,
                order,
                set: None,
                in_walls,
                mass,
                added_inertia,
                loads: Vec::new(),
                keeps_main,
            };
            if self.mains.insert(main, body).is_some() {
                let message = format!("node {} is the main node of two bodies", main.label());
                let help = "give each body its own main node";
                self.deck.trouble.error(record.place("node"), message, help);
            }
        }
        self.join_inner_bodies();
    }

    /// Returns the inertia that a body gets in addition to that of its nodes [mass length^2]. With
    /// ispher or with icog 4 it would replace that one, which is reported, as are other axes.
    fn added_inertia(&mut self, record: &CardRecord) -> Option<([f64; 6], Place)> {
        let fields = ["jxx", "jyy", "jzz", "jxy", "jyz", "jxz"];
        let given = fields.map(|field| record.real(field));
        let is_turned = !self.deck.is_plain(record.integer("skew"));
        let (field, _) = fields.iter().zip(given).find(|(_, j)| *j != 0.0)?;
        let place = record.place(field);
        let replaces = record.integer("ispher") != 0 || record.integer("icog") >= ONLY_MAIN;
        if !replaces && !is_turned {
            return Some((given, place));
        }
        let message = format!("{}: the inertia of the main node is ignored", record.name());
        let help = match replaces {
            true => {
                "with ispher 1, or with icog 4, it would replace that of the nodes: give \
                 `inertia` of the body in a job"
            }
            false => "give it in the global axes, without Skew_ID",
        };
        self.deck.trouble.warning(place, message, help);
        None
    }

    /// Returns the main node of a body, which has to exist.
    fn main_node(&mut self, record: &CardRecord) -> Option<NodeId> {
        let (n, place) = (record.integer("node"), record.place("node"));
        let node = super::groups::node(n).filter(|&node| self.deck.rows.at(node).is_some());
        if node.is_none() {
            self.deck.missing(place, "/NODE", n, &[]);
        }
        node
    }

    /// Returns true if a link ties all degrees of freedom, else reports it.
    fn ties_all(&mut self, record: &CardRecord) -> bool {
        let codes = ["tra", "rot"].map(|field| record.word(field).trim().to_string());
        let is_all = codes.iter().all(|code| matches!(code.as_str(), "" | "111" | "000"));
        if !is_all {
            let message = format!(
                "/RBE2/{}: single degrees of freedom ({}) are not supported",
                record.integer("id"),
                codes.join(" ")
            );
            self.deck.unsupported(record.place("tra"), message, "/RBE2 Trarot".into());
        }
        is_all
    }

    /// Returns the name of a body, other than those of parts and other bodies.
    fn body_name(&mut self, record: &CardRecord, id: i64, is_link: bool) -> String {
        let title = record.word("title").trim().to_string();
        let plain = if is_link { format!("link-{id}") } else { format!("body-{id}") };
        let name = if title.is_empty() || self.names.contains(&title) { plain } else { title };
        self.names.insert(name.clone());
        name
    }

    /// Returns all nodes of elements.
    pub(super) fn used_nodes(&mut self) -> &BTreeSet<NodeId> {
        if self.used.is_empty() {
            self.used = self.deck.rows.nodes_of(|_| true).into_iter().collect();
        }
        &self.used
    }

    /// Converts `/BCS`.
    pub(super) fn fix(&mut self) {
        for record in self.take(&["/BCS"]) {
            let (grnod, place) = (record.integer("grnod"), record.place("grnod"));
            self.only_plain(&record);
            let dofs = self.dofs(&record);
            let Some(set) = self.deck.node_set(grnod, place) else { continue };
            let mut all = self.deck.node_sets[&grnod].0.clone();
            let count = all.len();
            self.without_inner_mains(&record, &mut all, false);
            let wall_nodes = self.wall_nodes.clone();
            let mut others = Vec::with_capacity(all.len());
            self.warn_of_walls(&record, &all);
            for &node in all.iter().filter(|n| !wall_nodes.contains(n)) {
                match self.mains.get_mut(&node) {
                    Some(body) => body.fixed.extend(&dofs),
                    None => others.push(node),
                }
            }
            if others.len() == count {
                self.deck.fix_set((set, false), others, dofs, place);
            } else if !others.is_empty() {
                let name = format!("bcs-{}", record.integer("id"));
                self.deck.fix_set((name, true), others, dofs, place);
            }
        }
    }

    /// Warns of conditions on nodes of walls, which are no part of the model.
    pub(super) fn warn_of_walls(&mut self, record: &CardRecord, nodes: &[NodeId]) {
        if let Some(node) = nodes.iter().find(|n| self.wall_nodes.contains(n)) {
            let message =
                format!("{} on node {}, that of a wall, is ignored", record.name(), node.label());
            let help = "a wall moves as its card and /IMPVEL of its node say; a free one moves \
                        along its normal only";
            self.deck.trouble.warning(record.place("grnod"), message, help);
        }
    }

    /// Returns the degrees of freedom that a card fixes.
    fn dofs(&mut self, record: &CardRecord) -> Vec<&'static str> {
        let mut found = Vec::new();
        for (field, names) in [("tra", TRANSLATIONS), ("rot", ROTATIONS)] {
            let code = record.word(field).trim().to_string();
            let is_code = code.len() <= 3 && code.bytes().all(|b| b == b'0' || b == b'1');
            if !is_code {
                let message = format!(
                    "{}: `{field}` has to be three digits 0 or 1, not `{code}`",
                    record.name()
                );
                let help = "give them in the columns 4 to 6 and 8 to 10, such as `   111 111`";
                self.deck.trouble.error(record.place(field), message, help);
                continue;
            }
            let digits = format!("{code:0>3}");
            let of = digits.bytes().zip(names).filter(|(digit, _)| *digit == b'1');
            found.extend(of.map(|(_, name)| name));
        }
        found
    }

    /// Reports a system with other axes than the global ones.
    pub(super) fn only_plain(&mut self, record: &CardRecord) {
        if !self.deck.is_plain(record.integer("skew")) {
            let why = "axes other than the global ones";
            self.deck.unsupported_value(record, "skew", why);
        }
    }

    /// Adds the bodies to the job.
    pub(super) fn put_bodies(&mut self) {
        let mut loads: BTreeMap<usize, Vec<JobTable>> = self
            .mains
            .values_mut()
            .map(|body| (body.order, std::mem::take(&mut body.loads)))
            .collect();
        let mut bodies: Vec<_> = self.mains.values().collect();
        bodies.sort_by_key(|body| body.order);
        let mut tables = Vec::new();
        let mut masses = Vec::new();
        for body in self.inner_bodies.values().chain(bodies.iter().copied()) {
            if body.mass > 0.0 {
                masses.push((body.name.clone(), body.own.clone(), body.mass, body.place));
            }
        }
        for body in bodies {
            let place = body.place;
            let mut table = JobTable::new(place).with("name", place, body.name.as_str());
            let parts = self.whole_parts(&body.nodes);
            let of_parts: BTreeSet<NodeId> = self.nodes_of(&parts).into_iter().collect();
            let rest: Vec<NodeId> = body.nodes.difference(&of_parts).copied().collect();
            if !parts.is_empty() {
                table.put("parts", place, parts.into_iter().collect::<Vec<i64>>());
            }
            let set = (!rest.is_empty()).then(|| (format!("{} nodes", body.name), rest));
            if let Some((inertia, place)) = body.added_inertia {
                table.put("added_inertia", place, inertia);
            }
            if !body.fixed.is_empty() {
                table.put("fixed", place, body.fixed.iter().copied().collect::<Vec<_>>());
            }
            if let Some(loads) = loads.remove(&body.order).filter(|loads| !loads.is_empty()) {
                table.put("load", place, loads);
            }
            tables.push((table, set, place));
        }
        for (mut table, set, place) in tables {
            if let Some((name, nodes)) = set {
                let name = self.deck.rows.add_new_set(&name, nodes, place);
                table.put("nodes", place, name);
            }
            self.deck.add("rigid", table);
        }
        self.main_masses(masses);
    }

    /// Adds the masses of main nodes in equal shares to the nodes of their bodies.
    fn main_masses(&mut self, masses: Vec<(String, BTreeSet<NodeId>, f64, Place)>) {
        for (name, nodes, mass, place) in masses {
            let nodes = nodes.into_iter().collect();
            let set = self.deck.rows.add_new_set(&format!("{name} mass"), nodes, place);
            let table = JobTable::new(place).with("nodes", place, set);
            self.deck.add("mass", table.with("mass", place, mass));
            let asked = format!("mass {mass} of its main node");
            self.deck.map(name, asked, "in equal shares on its nodes");
        }
    }

    /// Returns the parts all of whose nodes are in a set. Parts of lines are not among them.
    fn whole_parts(&self, nodes: &BTreeSet<NodeId>) -> BTreeSet<i64> {
        let (mut within, mut without) = (BTreeSet::new(), BTreeSet::new());
        for element in self.deck.rows.elements() {
            let is_in = !element.shape.faces().is_empty()
                && element.corners().iter().all(|n| nodes.contains(n));
            let of = if is_in { &mut within } else { &mut without };
            of.insert(i64::from(element.part));
        }
        within.difference(&without).copied().collect()
    }
}
