//! Converts `*LOAD_BODY_GENERALIZED`: an acceleration of the frame of reference of some nodes or
//! parts. Radioss has `/GRAV` of a group, which is the same without the change of sign.

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crumple_proto::ids::NodeId;
use std::collections::BTreeSet;

/// Keywords and their fields of nodes or parts.
const KEYWORDS: [(&str, &str); 3] = [
    ("LOAD_BODY_GENERALIZED", "n1"),
    ("LOAD_BODY_GENERALIZED_SET_NODE", "nsid"),
    ("LOAD_BODY_GENERALIZED_SET_PART", "psid"),
];
/// Consequence of a load that is left out.
const LOST: &str = "the load is left out: these nodes have no gravity by it";

/// Masses on which gravity acts.
pub(super) enum GravityOf {
    /// Those of the whole model.
    All,
    /// Those of the elements of these parts.
    Parts(Vec<i64>),
    /// Those of the nodes of this set.
    Nodes(String),
    /// None: the nodes have no masses.
    Nothing,
}

impl std::fmt::Display for GravityOf {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::All => f.write_str("of all masses"),
            Self::Parts(parts) => write!(f, "of the elements of parts {parts:?}"),
            Self::Nodes(name) => write!(f, "of the masses of the nodes of {name}"),
            Self::Nothing => f.write_str("of nothing"),
        }
    }
}

/// Parts on whose masses a load acts.
pub(super) enum MassesOf {
    /// The whole model.
    All,
    /// Some parts, which share this number of nodes with others.
    Parts(Vec<i64>, usize),
}

impl DeckConverter {
    /// Converts all of these keywords.
    pub(super) fn accelerations(&mut self) {
        for (keyword, field) in KEYWORDS {
            for record in self.take_records(keyword) {
                self.acceleration(&record, field);
            }
        }
    }

    fn acceleration(&mut self, record: &CardRecord, field: &str) {
        let (number, place) = (record.integer(field), record.place(field));
        let of = match field {
            "psid" => match self.part_set(number, place) {
                parts if parts.is_empty() => return,
                parts => GravityOf::Parts(parts),
            },
            "nsid" => match self.node_set(number, place) {
                Some(name) => self.gravity_of(&self.node_sets[&number].0.clone(), name),
                None => return,
            },
            _ => {
                let last = record.integer("n2").max(number);
                let range = |node: &NodeId| (number..=last).contains(&(node.0 as i64));
                let nodes: Vec<NodeId> =
                    self.rows.nodes.iter().map(|n| n.id).filter(range).collect();
                let of = self.gravity_of(&nodes, format!("nodes-{number}-{last}"));
                if let GravityOf::Nodes(name) = &of {
                    self.rows.add_set(name.clone(), nodes, place);
                }
                of
            }
        };
        let Some(line) = record.line("ax").cloned() else { return };
        let given = ["ax", "ay", "az"].map(|axis| line.real(axis));
        let Some(base) = self.in_global_axes(given, &line, "cid", LOST) else { return };
        // Bodies accelerate against their frame of reference.
        let acceleration = base.map(|c| if c == 0.0 { 0.0 } else { -c });
        let at = record.place("lcid");
        let Some(curve) = self.time_curve(record.integer("lcid"), at) else { return };
        let table = JobTable::new(record.head)
            .with("acceleration", line.place("ax"), acceleration)
            .with("curve", at, curve);
        let asked = format!("{field} {number} with {given:?}");
        let used = format!("acceleration {acceleration:?} {of}, as of *LOAD_BODY");
        self.map(record.name(), asked, used);
        self.add_gravity(table, of, record, field);
    }

    /// Adds gravity on these masses. A field of the record names them.
    pub(super) fn add_gravity(
        &mut self,
        mut table: JobTable,
        of: GravityOf,
        record: &CardRecord,
        field: &str,
    ) {
        let place = record.place(field);
        match of {
            GravityOf::All => {}
            GravityOf::Parts(parts) => table.put("parts", place, parts),
            GravityOf::Nodes(name) => table.put("nodes", place, name),
            GravityOf::Nothing => {
                let message = format!("{}: none of its nodes has a mass", record.name());
                return self.trouble.warning(place, message, LOST);
            }
        }
        self.add("gravity", table);
    }

    /// Returns the masses of a group of nodes, a set with this name.
    pub(super) fn gravity_of(&self, group: &[NodeId], name: String) -> GravityOf {
        match self.parts_of_group(group) {
            Some(MassesOf::All) => GravityOf::All,
            // Gravity of parts acts on the masses of elements only.
            Some(MassesOf::Parts(parts, 0)) if !self.has_nodal_masses() => GravityOf::Parts(parts),
            _ => {
                let used: BTreeSet<NodeId> = self.rows.nodes_of(|_| true).into_iter().collect();
                match group.iter().any(|node| used.contains(node)) {
                    true => GravityOf::Nodes(name),
                    false => GravityOf::Nothing,
                }
            }
        }
    }

    /// Returns true if cards give masses to nodes.
    fn has_nodal_masses(&self) -> bool {
        let is_mass = |name: &str| {
            name.starts_with("ELEMENT_MASS") || ["ELEMENT_INERTIA", "/ADMAS"].contains(&name)
        };
        self.read.iter().any(|card| is_mass(card.row.keyword.name))
    }

    /// Warns of masses that a load of parts does not act on: of nodes that other parts have too,
    /// and those that cards give to nodes.
    pub(super) fn warn_of_shared(
        &mut self,
        record: &CardRecord,
        field: &str,
        (load, shared): (&str, usize),
    ) {
        if self.has_nodal_masses() {
            let message = format!("{}: masses of nodes have no {load} by it", record.name());
            let help = format!(
                "it acts on the elements of its parts: name all nodes of the model for {load} on \
                 all masses"
            );
            self.trouble.warning(record.place(field), message, help);
        }
        if shared > 0 {
            let message = format!(
                "{}: {shared} of its nodes belong to other parts, too, whose masses there have no \
                 {load} by it",
                record.name()
            );
            let help = format!(
                "{load} acts on the masses of elements: add all nodes of these parts, or expect \
                 the difference of a row of elements"
            );
            self.trouble.warning(record.place(field), message, help);
        }
    }

    /// Returns the parts whose nodes are those of a group; `None` if the group has only some nodes
    /// of a part that has a mass.
    pub(super) fn parts_of_group(&self, group: &[NodeId]) -> Option<MassesOf> {
        let group: BTreeSet<NodeId> = group.iter().copied().collect();
        let used: BTreeSet<NodeId> = self.rows.nodes_of(|_| true).into_iter().collect();
        if used.is_subset(&group) {
            return Some(MassesOf::All);
        }
        let rows = &self.rows;
        let (mut within, mut without) = (BTreeSet::new(), BTreeSet::new());
        let bodies = rows.shells.iter().chain(&rows.solids).chain(&rows.beams);
        for element in bodies.clone().chain(&rows.particles) {
            let is_in = element.corners().iter().all(|node| group.contains(node));
            let of = if is_in { &mut within } else { &mut without };
            of.insert(i64::from(element.part));
        }
        let parts: Vec<i64> = within.difference(&without).copied().collect();
        let is_own = |part: u32| parts.binary_search(&i64::from(part)).is_ok();
        let own: BTreeSet<NodeId> = rows.nodes_of(is_own).into_iter().collect();
        if parts.is_empty() || group.intersection(&used).any(|node| !own.contains(node)) {
            return None;
        }
        let others = bodies.chain(&rows.particles).filter(|e| !is_own(e.part));
        let others: BTreeSet<NodeId> = others.flat_map(|e| e.corners()).copied().collect();
        let shared = own.intersection(&others).count();
        Some(MassesOf::Parts(parts, shared))
    }
}
