//! Converts the cards of `*PART_INERTIA` and `*CONSTRAINED_NODAL_RIGID_BODY_INERTIA`: mass
//! properties and initial motion of rigid parts and bodies of nodes.

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::centre;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::BTreeSet;

/// Largest distance between the given centre of mass and that of the elements that is round-off,
/// as a fraction of the radius of gyration.
const SAME_CENTRE: f64 = 0.01;

/// Mass properties of a rigid part.
#[derive(Clone, Copy, Debug)]
pub struct DeckInertia {
    /// Mass [mass].
    mass: f64,
    /// Components xx, yy, zz, xy, yz, zx about the centre [mass length^2].
    tensor: [f64; 6],
    /// Centre of mass [length].
    centre: [f64; 3],
    /// Velocity [length/time] and rotational velocity [1/time] at the start.
    motion: [[f64; 3]; 2],
    place: Place,
}

impl DeckConverter {
    /// Reads the cards of inertia of a part or body; `None` if it has none.
    pub(super) fn inertia_card(&mut self, record: &CardRecord) -> Option<DeckInertia> {
        record.line("tm")?;
        if record.integer("ircs") != 0 {
            self.unsupported_card(record, "ircs", "inertia about local axes");
            return None;
        }
        let number = |field: &str| record.real(field);
        let mut centre = ["xc", "yc", "zc"].map(number);
        if let Ok(node @ 1..) = u64::try_from(record.integer("nodeid")) {
            match self.rows.at(NodeId(node)) {
                Some(x) => centre = x,
                None => self.missing(record.place("nodeid"), "node", node as i64, &[]),
            }
        }
        let mass = number("tm");
        if mass <= 0.0 {
            // A blank one has been reported.
            if !record.is_blank("tm") {
                let message = format!("{}: `tm` is {mass}, it has to be above 0", record.name());
                self.trouble.error(record.place("tm"), message, "give the mass of the body");
            }
            return None;
        }
        Some(DeckInertia {
            mass,
            tensor: ["ixx", "iyy", "izz", "ixy", "iyz", "ixz"].map(number),
            centre,
            motion: [["vtx", "vty", "vtz"].map(number), ["vrx", "vry", "vrz"].map(number)],
            place: record.place("tm"),
        })
    }

    /// Adds the inertia of a body of these parts, which is that of its leading part `lead`. Parts
    /// that `follow` are joined to it without an effect on its inertia. `extra` is the number of
    /// nodes of other parts in the body that have a mass.
    pub(super) fn put_inertia(
        &mut self,
        lead: i64,
        (parts, follow): (&[i64], &BTreeSet<i64>),
        extra: usize,
        table: &mut JobTable,
    ) {
        let inertia_of = |part: &i64| self.parts.get(part).and_then(|p| p.inertia);
        let is_whole = parts.iter().all(|part| *part == lead || follow.contains(part));
        let Some(given) = inertia_of(&lead).filter(|_| is_whole) else {
            let with: Vec<(i64, Place)> =
                parts.iter().filter_map(|part| Some((*part, inertia_of(part)?.place))).collect();
            for (part, place) in with {
                let message =
                    format!("part {part}: *PART_INERTIA of a part that is joined to others");
                self.unsupported(place, message, "*PART_INERTIA".into());
            }
            return;
        };
        let part = lead;
        if extra > 0 {
            let message = format!(
                "part {part}: masses of nodes of other parts in the body ({extra}) are added to tm"
            );
            let help = "the original counts tm for all of them; a body whose motion is prescribed \
                        does not depend on it";
            self.trouble.warning(given.place, message, help);
        }
        table.put("mass", given.place, given.mass);
        table.put("inertia", given.place, given.tensor);
        let centre = self.centre_of(parts);
        let away = (0..3).map(|c| (centre[c] - given.centre[c]).powi(2)).sum::<f64>().sqrt();
        let moves = away > round_off(given.mass, given.tensor);
        let can_move = moves && self.holds_centre(parts, given.centre);
        if can_move {
            table.put("centre", given.place, given.centre);
        } else if moves {
            let message = format!(
                "part {part}: its centre of mass is {:?} in the deck, which is not inside of its \
                 elements; that of the elements is {centre:?}",
                given.centre
            );
            let help = "the body has the centre of its elements: add masses that move it";
            self.trouble.warning(given.place, message, help);
        }
        self.map(
            format!("part {part}"),
            format!("inertia: mass {}", given.mass),
            if can_move {
                "mass, centre and inertia of the rigid body"
            } else {
                "mass and inertia of the rigid body"
            },
        );
        let [v, w] = given.motion;
        if given.motion != [[0.0; 3]; 2] {
            let set = self.nodes_of_parts(parts);
            let spin = (w != [0.0; 3]).then_some((w, if can_move { given.centre } else { centre }));
            self.initial(given.place, Some(set), v, spin);
        }
    }

    /// Gives the nodes of other parts, in a set, the motion of a part without elements, whose mass
    /// and inertia have no carrier.
    pub(super) fn bare_inertia(&mut self, part: i64, set: &str) {
        let Some(given) = self.parts.get(&part).and_then(|p| p.inertia) else { return };
        let message = format!(
            "part {part} has no elements: its body has the mass, centre and inertia of its nodes, \
             not those of *PART_INERTIA"
        );
        let help = "a body whose motion is prescribed does not depend on them; else give the part \
                    elements, or its nodes masses by *ELEMENT_MASS";
        self.trouble.warning(given.place, message, help);
        let [v, w] = given.motion;
        if given.motion != [[0.0; 3]; 2] {
            let spin = (w != [0.0; 3]).then_some((w, given.centre));
            self.initial(given.place, Some(set.to_string()), v, spin);
        }
    }

    /// Adds the inertia of a body of nodes. They carry the mass, in shares that have the centre of
    /// the card if it is between them.
    pub(super) fn nodal_inertia(
        &mut self,
        record: &CardRecord,
        (set, members): (&str, &[NodeId]),
        table: &mut JobTable,
    ) {
        let Some(given) = self.inertia_card(record) else { return };
        let (pid, place) = (record.integer("pid"), given.place);
        table.put("inertia", place, given.tensor);
        // Nodes without elements have no mass.
        let connected = self.rows.nodes_of(|_| true);
        let is_connected = |node: &NodeId| connected.binary_search(node).is_ok();
        let nodes: Vec<NodeId> = members.iter().copied().filter(is_connected).collect();
        let points: Vec<[f64; 3]> = nodes.iter().filter_map(|&node| self.rows.at(node)).collect();
        let [v, w] = given.motion;
        if given.motion != [[0.0; 3]; 2] {
            let spin = (w != [0.0; 3]).then_some((w, given.centre));
            self.initial(place, Some(set.to_string()), v, spin);
        }
        if nodes.is_empty() || points.len() < nodes.len() {
            return;
        }
        let each = given.mass / nodes.len() as f64;
        let shares = centre::factors(&vec![each; nodes.len()], &points, given.centre);
        let used = match &shares {
            Some(_) => "mass of its nodes with this centre, inertia of the rigid body",
            None => "mass of its nodes in equal shares, inertia of the rigid body",
        };
        self.map(format!("body-{pid}"), format!("inertia: mass {}", given.mass), used);
        let message = format!("body {pid}: its mass is tm and the masses of its nodes");
        let help = "the original has tm for all; a body whose motion is prescribed does not depend \
                    on its mass";
        self.trouble.warning(place, message, help);
        match shares {
            Some(factors) => {
                for (node, factor) in nodes.into_iter().zip(factors) {
                    self.add_mass(&format!("body-{pid} mass"), vec![node], each * factor, place);
                }
            }
            None => {
                let message = format!(
                    "body {pid}: its centre of mass is {:?} in the deck, which is not between its \
                     nodes",
                    given.centre
                );
                let help = "the body has the centre of its nodes: add nodes around the centre";
                self.trouble.warning(place, message, help);
                self.add_mass(&format!("body-{pid} mass"), nodes, given.mass, place);
            }
        }
    }

    /// Adds a mass in equal shares on nodes; their set has the name, or that with a number.
    fn add_mass(&mut self, name: &str, nodes: Vec<NodeId>, mass: f64, place: Place) {
        let set = self.rows.add_new_set(name, nodes, place);
        let table = JobTable::new(place).with("nodes", place, set);
        self.add("mass", table.with("mass", place, mass));
    }

    /// Returns true if masses of the elements of parts can have this centre.
    fn holds_centre(&mut self, parts: &[i64], centre: [f64; 3]) -> bool {
        let (masses, points) = self.middles_of(parts);
        centre::factors(&masses, &points, centre).is_some()
    }
}

/// Returns the largest distance between the given centre of a body and that of its elements that
/// is round-off, from its mass and its moments of inertia [length].
pub(in crate::input::deck) fn round_off(mass: f64, tensor: [f64; 6]) -> f64 {
    let [xx, yy, zz, ..] = tensor;
    SAME_CENTRE * (0.5 * (xx + yy + zz) / mass).sqrt()
}
